//! Pixels around a place: whether they repeat along a direction, and with which period; the SNR of a flat spot on a
//! flat background; and whether the picture around a feature moves by the feature's slope (see [`PatchCoherence`]).
//!
//! Slopes that differ by the period p in px/frame show a texture alike: from frame to frame it moves by one more whole
//! period, which cannot be seen.

use super::shares::directions;
use crate::detector::coherence::PatchCoherence;
use crate::detector::{Feature, Slope, SlopeGrid, Trail};
use crate::inspect::words::slope_text;
use crate::monitor::{Cancelled, Monitor};
use crate::plane::{Plane, sample::bilinear};
use serde::Serialize;

/// Period of a texture.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Period {
    /// Length of the period, pixels.
    pub px: f32,
    /// Correlation of the texture with itself after a period, 0 … 1.
    pub correlation: f32,
}

const FINEST_PX: usize = 3;
const MIN_CORRELATION: f32 = 0.35;
/// Part of its height below which the correlation must fall between two repetitions.
const TROUGH: f32 = 0.3;
/// Number of lines to each side of the one through the place, a pixel apart.
const LINES: i32 = 6;

/// The period of `plane` around `centre` (u, v) along `direction` (of length 1), within `half_px` pixels to each side;
/// `None` where nothing repeats at least twice there.
pub fn period_along(plane: &Plane, centre: [f32; 2], direction: [f32; 2], half_px: usize) -> Option<Period> {
    let [du, dv] = direction;
    let lines: Vec<Vec<f32>> =
        (-LINES..=LINES).filter_map(|line| profile(plane, centre, [du, dv], line as f32, half_px)).collect();
    let n = 2 * half_px + 1;
    let max = n * 2 / 5;
    if lines.is_empty() || max <= FINEST_PX {
        return None;
    }
    // Unbiased: each lag is normalised by the number and the energy of its own products.
    let correlation = |lag: usize| -> f32 {
        let (mut product, mut energy) = (0.0f64, 0.0f64);
        for line in &lines {
            for i in 0..n - lag {
                let (a, b) = (f64::from(line[i]), f64::from(line[i + lag]));
                product += a * b;
                energy += 0.5 * (a * a + b * b);
            }
        }
        if energy > 0.0 { (product / energy) as f32 } else { 0.0 }
    };
    let r: Vec<f32> = (0..=max).map(correlation).collect();
    // The first peak beyond the first trough.
    let trough = (1..max).find(|&lag| r[lag] < r[lag + 1] && r[lag] < TROUGH * r[1].max(MIN_CORRELATION))?;
    let peak = (trough.max(FINEST_PX)..max)
        .filter(|&lag| r[lag] >= r[lag - 1] && r[lag] > r[lag + 1])
        .find(|&lag| r[lag] > MIN_CORRELATION)?;
    let (a, b, c) = (r[peak - 1], r[peak], r[peak + 1]);
    let curvature = a - 2.0 * b + c;
    let offset = if curvature < 0.0 { (0.5 * (a - c) / curvature).clamp(-0.5, 0.5) } else { 0.0 };
    Some(Period { px: peak as f32 + offset, correlation: b.clamp(0.0, 1.0) })
}

/// A line of pixels beside the place, without its trend; `None` where it leaves the plane.
fn profile(plane: &Plane, centre: [f32; 2], [du, dv]: [f32; 2], beside: f32, half_px: usize) -> Option<Vec<f32>> {
    let at = |i: i64| {
        let along = i as f32;
        bilinear(plane, centre[0] + along * du - beside * dv, centre[1] + along * dv + beside * du)
    };
    let half = half_px as i64;
    let mut line: Vec<f32> = (-half..=half).map(at).collect::<Option<_>>()?;
    let n = line.len() as f32;
    let mean = line.iter().sum::<f32>() / n;
    let place = |i: usize| i as f32 - half as f32;
    let squares: f32 = (0..line.len()).map(|i| place(i).powi(2)).sum();
    let trend = line.iter().enumerate().map(|(i, x)| place(i) * x).sum::<f32>() / squares.max(1.0);
    line.iter_mut().enumerate().for_each(|(i, x)| *x -= mean + trend * place(i));
    Some(line)
}

/// Measurement of a spot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpotSnr {
    /// Mean of the spot minus that of its background, fraction of full scale.
    pub signal: f32,
    /// Standard deviation of one pixel, around the mean of the spot or of the background, fraction of full scale.
    pub noise: f32,
}

impl SpotSnr {
    /// |signal| over noise; infinite without noise.
    pub fn ratio(&self) -> f32 {
        self.signal.abs() / self.noise
    }
}

const MIN_PIXELS: usize = 12;

/// Measures the spot around `place` (u, v): its pixels are nearer than `inner`, those of its background between
/// `ground[0]` and `ground[1]` away, in pixels. `None` where the picture holds too few of either.
pub fn spot_snr(picture: &Plane, place: [f32; 2], inner: f32, ground: [f32; 2]) -> Option<SpotSnr> {
    let (mut spot, mut around) = (Vec::new(), Vec::new());
    let [u, v] = place;
    let span = |x: f32, n: usize| {
        let (first, end) = ((x - ground[1]).floor().max(0.0), (x + ground[1]).ceil() + 1.0);
        first as usize..(end.max(0.0) as usize).min(n)
    };
    for row in span(v, picture.height()) {
        for column in span(u, picture.width()) {
            let value = picture.at(column, row);
            match (column as f32 - u).hypot(row as f32 - v) {
                _ if !value.is_finite() => {}
                away if away < inner => spot.push(value),
                away if (ground[0]..=ground[1]).contains(&away) => around.push(value),
                _ => {}
            }
        }
    }
    if spot.len() < MIN_PIXELS || around.len() < MIN_PIXELS {
        return None;
    }
    let mean = |values: &[f32]| values.iter().map(|&x| f64::from(x)).sum::<f64>() / values.len() as f64;
    let means = [mean(&spot), mean(&around)];
    let squares = |values: &[f32], mean: f64| values.iter().map(|&x| (f64::from(x) - mean).powi(2)).sum::<f64>();
    // Two means were estimated from the same pixels.
    let free = (spot.len() + around.len() - 2) as f64;
    let noise = ((squares(&spot, means[0]) + squares(&around, means[1])) / free).sqrt();
    Some(SpotSnr { signal: (means[0] - means[1]) as f32, noise: noise as f32 })
}

// The limits were set on scenes of known motion: docs/MEASUREMENTS.md, “What is said to be real”.
/// Coherence below which the picture changes, and standard deviations of noise by which it must.
const CHANGES_BELOW: f32 = 0.9;
const CHANGES_SIGMAS: f32 = 2.0;
/// Shift over half of the burst, in σ, by which another slope differs clearly.
const APART_SIGMAS: f32 = 1.5;
/// Least coherence at such a slope where the picture moves as well, and the most by which the feature's own is larger.
const AS_WELL: f32 = 0.85;
const LESS: f32 = 0.08;
/// Least share of the strength of D at such a slope.
const KEEPS: f32 = 0.5;
/// Shift over half of the burst, in σ, between the slopes at which the picture's own is sought, and their number.
const STEP_SIGMAS: f32 = 0.5;
const STEPS: usize = 64;

/// Motion of the picture around a feature: a changing one, another slope, or another slope beside the feature's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Around {
    Changes,
    MovesBy(Slope),
    MovesAlsoBy(Slope),
}

/// How the picture around a feature moves, with its coherence and a clause; `None` where by the feature's slope alone,
/// and where too little is seen.
pub(super) fn around(
    trail: &Trail,
    feature: &Feature,
    monitor: &Monitor,
) -> Result<Option<(Around, f32, String)>, Cancelled> {
    monitor.check()?;
    let Feature { u, v, slope, sigma, .. } = *feature;
    // Masked pixels may stand still, or change.
    let is_seen = trail.seen_share((u, v), slope, 2.0 * sigma).is_none_or(|share| share >= 1.0);
    let grid = trail.params().used_slopes();
    let shift = |sigmas: f32| 2.0 * sigmas * sigma / trail.frames().2.span().max(1.0) as f32;
    let looked = Looked { trail, feature, grid, apart: shift(APART_SIGMAS), step: shift(STEP_SIGMAS) };
    let Some(own) = Some(slope).filter(|_| is_seen).and_then(|slope| looked.at(slope)) else { return Ok(None) };
    if own.coherence < CHANGES_BELOW && own.excess_sigmas > CHANGES_SIGMAS {
        let changes = format!("the picture around it changes along its motion (coherence {:.2}", own.coherence);
        let Some((other, found)) = looked.own_slope(slope, own) else {
            return Ok(Some((Around::Changes, own.coherence, changes + ")")));
        };
        let evidence = format!("{changes}), and moves by slope {} ({:.2})", slope_text(other), found.coherence);
        return Ok(Some((Around::MovesBy(other), own.coherence, evidence)));
    }
    let as_well = |(other, found): (Slope, PatchCoherence)| {
        let (at, [there, here]) = (slope_text(other), [found.coherence, own.coherence]);
        let evidence = format!(
            "the picture around it moves by slope {at} as well (coherence {there:.2}, at its own {here:.2}), as along an edge"
        );
        (Around::MovesAlsoBy(other), there, evidence)
    };
    Ok(looked.as_well(slope, own).map(as_well))
}

struct Looked<'a> {
    trail: &'a Trail,
    feature: &'a Feature,
    grid: SlopeGrid,
    /// Difference of a slope that is clearly another, and of the next one that is tried, px/frame.
    apart: f32,
    step: f32,
}

impl Looked<'_> {
    fn at(&self, slope: Slope) -> Option<PatchCoherence> {
        let Feature { u, v, .. } = *self.feature;
        self.trail.along().patch_coherence(self.feature.scale(), (u, v), slope)
    }

    /// The most coherent of the slopes `distance` px/frame from `slope`, to both sides along each of `axes`.
    fn best(
        &self,
        slope: Slope,
        distance: f32,
        axes: impl Iterator<Item = [f32; 2]>,
        is_eligible: impl Fn(&PatchCoherence) -> bool,
    ) -> Option<(Slope, PatchCoherence)> {
        let both =
            axes.flat_map(|[u, v]| [distance, -distance].map(|by| Slope::new(slope.u + by * u, slope.v + by * v)));
        let found = both.filter_map(|slope| self.at(slope).map(|found| (slope, found)));
        found.filter(|(_, found)| is_eligible(found)).max_by(|a, b| a.1.coherence.total_cmp(&b.1.coherence))
    }

    /// A clearly other slope than `slope` by which the picture moves as well.
    fn as_well(&self, slope: Slope, own: PatchCoherence) -> Option<(Slope, PatchCoherence)> {
        let axis = if self.grid.is_plane() { Some(own.flattest) } else { directions(&self.grid).next() };
        self.best(slope, self.apart, axis.into_iter(), |found| {
            found.strength > KEEPS * own.strength && found.coherence > AS_WELL.max(own.coherence - LESS)
        })
    }

    /// Slope by which alone the picture moves, climbed to from `slope`, at which it does not.
    fn own_slope(&self, slope: Slope, own: PatchCoherence) -> Option<(Slope, PatchCoherence)> {
        let mut best = (slope, own);
        for _ in 0..STEPS {
            let is_better = |found: &PatchCoherence| found.coherence > best.1.coherence;
            let Some(next) = self.best(best.0, self.step, directions(&self.grid), is_better) else { break };
            best = next;
        }
        let moves_by = |(slope, found): &(Slope, PatchCoherence)| {
            found.coherence >= CHANGES_BELOW
                && found.strength > KEEPS * own.strength
                && self.as_well(*slope, *found).is_none()
        };
        Some(best).filter(moves_by)
    }
}
