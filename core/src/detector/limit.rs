//! Features at the limit of the searched slopes: their own response shows that their motion lies beyond.
//!
//! A place on the rim alone is no evidence: noise, edges and ghosts lie there too. The response is: |D| over slope is
//! one bump around a blob's own. If |D| grows a step beyond the rim, its middle is over half a step beyond.
//!
//! Noise moves that comparison. D at two slopes has the correlation 1 − loss, where *loss* is the part of its response
//! that a blob of this scale loses over the difference ([`response_loss`]), so the difference of D has the standard
//! deviation σ_D·√(2·loss). A feature is at the limit if the rise exceeds `RISE_SIGMAS` of these.

use crate::burst::Positions;
use crate::detector::along::Along;
use crate::detector::feature::Feature;
use crate::detector::params::{Slope, SlopeAxis};

/// Minimum rise of the response beyond the rim, in standard deviations of the difference by noise.
const RISE_SIGMAS: f32 = 2.0;
/// Minimum ratio of the response beyond to that on the rim, for bursts with little noise.
const RISE_RATIO: f32 = 1.02;
/// Minimum number of frames that show the place at both slopes.
const MIN_FRAMES: usize = 2;

/// Rise of a feature's response from the rim of the slopes to a slope a step beyond, whatever the noise.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Rise {
    difference: f32,
    /// Response times the ratio of noise in D of the frames that show the place at both slopes to that of all frames.
    noise: f32,
    /// √(2·loss).
    spread: f32,
    /// Response beyond over that on the rim.
    pub(crate) ratio: f32,
}

impl Rise {
    /// Whether the rise exceeds noise, for a feature of signal-to-noise ratio `snr`.
    pub(super) fn exceeds_noise(self, snr: f32) -> bool {
        self.difference > RISE_SIGMAS * (self.noise / snr) * self.spread
    }
}

impl Along<'_> {
    /// Rises of the response of `feature` beyond the rim, before the test for noise; equal for all features of a
    /// keypoint. The feature is [at the limit](Feature::at_slope_limit) if one of them exceeds the noise.
    pub(crate) fn rises(&self, feature: &Feature) -> Vec<Rise> {
        let Some((rim, beyond)) = self.rim_and_beyond(feature.slope) else { return Vec::new() };
        let place = (feature.u, feature.v);
        let on_rim = self.showing(place, rim);
        let rise = |slope: Slope| {
            let there = self.showing(place, slope);
            // Both responses come from the same frames: a place that leaves the picture must not look like a fall.
            let both: Vec<usize> = on_rim.iter().copied().filter(|index| there.contains(index)).collect();
            if both.len() < MIN_FRAMES {
                return None;
            }
            let levels = feature.level..feature.level + 1;
            let of = |slope: Slope| {
                feature.response.signum() * self.response(feature.octave, levels.clone(), place, slope, &both)[0]
            };
            let (here, there) = (of(rim), of(slope));
            let apart = (slope.u - rim.u).hypot(slope.v - rim.v);
            let loss = response_loss(apart, &self.inputs.times.positions, feature.sigma);
            let frames = (on_rim.len() as f32 / both.len() as f32).sqrt();
            let (noise, spread) = (frames * feature.response.abs(), (2.0 * loss).sqrt());
            let ratio = there / here.abs();
            (ratio > RISE_RATIO).then_some(Rise { difference: there - here, noise, spread, ratio })
        };
        beyond.into_iter().filter_map(rise).collect()
    }

    /// Slope on the rim nearest to `slope`, and the slopes a step beyond: three at a corner of a plane, else one.
    /// `None` where the grid's slope nearest to `slope` is not on the rim.
    fn rim_and_beyond(&self, slope: Slope) -> Option<(Slope, Vec<Slope>)> {
        let grid = self.inputs.params.used_slopes();
        if !grid.nearest_on_rim(slope) {
            return None;
        }
        let (i, j) = grid.position(slope);
        let (i, along_u) = self.outwards(&grid.u, i);
        let (j, along_v) = self.outwards(&grid.v, j);
        let steps = along_u.iter().flat_map(|&di| along_v.iter().map(move |&dj| (di, dj)));
        let beyond = steps.filter(|step| *step != (0.0, 0.0)).map(|(di, dj)| grid.at(i + di, j + dj)).collect();
        Some((grid.at(i, j), beyond))
    }

    /// Coordinate on an axis from which to look outwards, and distances (in steps of the axis, 0 among them). A step is
    /// at least the one that the finest features need: smaller ones hardly change a response.
    fn outwards(&self, axis: &SlopeAxis, at: f32) -> (f32, Vec<f32>) {
        let last = axis.count.saturating_sub(1) as f32;
        if axis.count < 2 {
            return (0.0, vec![0.0]);
        }
        let space = &self.inputs.space;
        let span = self.inputs.times.positions.span().max(1.0) as f32;
        let finest = 2.0 * space.sigma_image(space.first_octave, 0.0) as f32 / span;
        let step = (finest / axis.step()).max(1.0);
        // Inside the range both sides were searched: only at an end may the response rise outwards.
        match at.round().clamp(0.0, last) {
            0.0 => (0.0, vec![0.0, -step]),
            end if end == last => (last, vec![0.0, step]),
            _ => (at, vec![0.0]),
        }
    }

    /// Indices, among the kept frames, of those that show the place at a slope.
    pub(super) fn showing(&self, (u, v): (f32, f32), slope: Slope) -> Vec<usize> {
        let size = self.inputs.size_image;
        let pixel = |x: f32, n: usize| (x.round().max(0.0) as usize).min(n - 1);
        let at = (pixel(u, size.0), pixel(v, size.1));
        let offsets = self.inputs.offsets(slope);
        (0..offsets.len()).filter(|&index| self.inputs.sees(index, &offsets[index], at)).collect()
    }
}

/// Part (0 … 1) of its response that a blob of scale `sigma` px loses in a stack of frames `error` px/frame off.
///
/// A blob shifted by x px under a filter of its own size has (1 − x²/(2s²))·exp(−x²/(2s²)) of its response, s² = 2σ²,
/// along the shift; the mean over the frames, each off by its position times the error, remains.
pub fn response_loss(error: f32, positions: &Positions, sigma: f32) -> f32 {
    let variance = 2.0 * f64::from(sigma).powi(2);
    let left: f64 = positions
        .offsets()
        .iter()
        .map(|offset| {
            let x = offset.length() * f64::from(error);
            let q = x * x / (2.0 * variance);
            (1.0 - q) * (-q).exp()
        })
        .sum::<f64>()
        / positions.len().max(1) as f64;
    (1.0 - left).clamp(0.0, 1.0) as f32
}
