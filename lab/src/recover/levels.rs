//! The SNRs, slopes and radii at which things are planted.

use super::{RecoverStudy, Varied, bounds, expected::expected, ground::Ground};
use crate::synth::random::Stream;
use burstscope_core::detector::{Slope, SlopeAxis, SlopeGrid};
use burstscope_core::error::{Error, Result};
use serde::Serialize;

/// Levels of a study, those left open chosen for the burst.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Levels {
    /// SNRs of one pixel in one frame, in increasing order.
    pub snrs: Vec<f64>,
    /// Slopes along the grid's first axis of several slopes, pixels per frame, in increasing order.
    pub slopes: Vec<f64>,
    /// Radii, pixels, in increasing order.
    pub radii: Vec<f64>,
    /// SNR at which slopes and sizes are varied.
    pub at_snr: f64,
    /// Radius at which SNRs and slopes are varied, pixels.
    pub at_radius: f64,
    /// Things in a copy.
    pub per_copy: usize,
    /// SNR of which half are expected to be found: radius as above, a slope of the grid, mid-picture, all frames.
    pub expected_half: f64,
    /// Amplitude of such a thing, fraction of full scale.
    pub expected_amplitude: f64,
    #[serde(skip)]
    grid: SlopeGrid,
}

/// SNRs of the levels relative to the one of which half are expected to be found.
const SNR_RANGE: [f64; 2] = [0.45, 2.4];
const SNR_LEVELS: usize = 10;
const SIZE_LEVELS: usize = 7;
/// SNR at which slopes and sizes are varied, relative to the one of which half are expected.
const CLEAR: f64 = 1.7;
const MAX_SLOPE_LEVELS: usize = 41;
/// Area of the picture for one thing, square pixels.
const AREA_PX: f64 = 8000.0;

impl Levels {
    pub(super) fn of(study: &RecoverStudy, ground: &Ground) -> Result<Self> {
        let trail = &ground.cache.trail;
        let (width, height) = trail.size_image();
        let grid = trail.params().used_slopes();
        let centre = (0.5 * width as f64, 0.5 * height as f64);
        // A thing at the centre that hardly moves is in all frames: the levels are relative to its expected SNR.
        let slope = grid.slopes().min_by(|a, b| a.magnitude().total_cmp(&b.magnitude())).unwrap_or_default();
        let Some(middle) = expected(trail, study.shape, study.at_radius, centre, slope) else {
            let problem = format!("no scale of the search suits things of {} pixels", study.at_radius);
            return Err(Error::param("at-radius", problem, "give another radius, or search more octaves"));
        };
        let factor = f64::from(ground.cache.detection().noise_gate_factor);
        if factor <= 0.0 && study.snrs.is_empty() {
            let remedy = "set a noise gate, or give the ratios yourself";
            return Err(Error::param("snr", "without a noise gate no ratio is expected to be the limit", remedy));
        }
        let expected_amplitude = middle.amplitude_at(factor);
        let variance = ground.sigma_at(centre.0, centre.1).powi(2);
        // Inverse of `LightNoise::amplitude` for a bright thing: the noise is that half-way from background to thing.
        let expected_half =
            expected_amplitude / (variance + 0.5 * ground.light.per_brightness * expected_amplitude).sqrt();
        // No file could hold the light of a larger SNR.
        let (_, most) = bounds::SNR.span().into_inner();
        if expected_half > most && (study.snrs.is_empty() || study.at_snr.is_none()) {
            let problem = format!("a thing needs an SNR of {expected_half:.1e} to pass a gate of {factor:.1e} σ");
            return Err(Error::param("noise-gate", problem, "lower the gate, or give snr and at-snr yourself"));
        }
        // Three significant digits, so that tables and axes can name the levels.
        let tidy = |x: f64| {
            let digits = 10f64.powi(2 - x.log10().floor() as i32);
            (x * digits).round() / digits
        };
        let sorted = |list: &[f64]| {
            let mut list = list.to_vec();
            list.sort_by(f64::total_cmp);
            list.dedup();
            list
        };
        let snrs = match &study.snrs[..] {
            [] => geometric(SNR_RANGE.map(|part| part * expected_half), SNR_LEVELS).map(tidy).collect(),
            given => sorted(given),
        };
        let largest = (width.min(height) as f64 / 12.0).clamp(4.0, 16.0);
        let radii = match &study.radii[..] {
            [] => geometric([2.0, largest], SIZE_LEVELS).map(tidy).collect(),
            given => sorted(given),
        };
        let slopes = match study.slopes {
            Some(axis) => (0..axis.count).map(|i| f64::from(axis.value(i as f32))).collect(),
            None => slopes_around(along(&grid), ground.used.len()),
        };
        let room = (width as f64 * height as f64 / AREA_PX) as usize;
        let (at_snr, at_radius) = (study.at_snr.unwrap_or_else(|| tidy(CLEAR * expected_half)), study.at_radius);
        let per_copy = study.per_copy.unwrap_or_else(|| room.clamp(9, 90));
        Ok(Self { snrs, slopes, radii, at_snr, at_radius, per_copy, expected_half, expected_amplitude, grid })
    }

    /// Number of levels of a quantity.
    pub fn count(&self, varied: Varied) -> usize {
        self.values(varied).len()
    }

    /// Levels of a quantity in increasing order: SNRs, slopes (px/frame) or radii (px).
    pub fn values(&self, varied: Varied) -> &[f64] {
        match varied {
            Varied::Snr => &self.snrs,
            Varied::Slope => &self.slopes,
            Varied::Size => &self.radii,
        }
    }

    /// SNR, radius and slope of the thing number `turn` of those that vary a quantity.
    pub(super) fn drawn(&self, varied: Varied, turn: usize, stream: &mut Stream) -> (f64, f64, Slope) {
        // Levels take turns, so that few copies have things at all of them.
        let level = self.values(varied)[turn % self.count(varied)];
        let [a, b] = [&self.grid.u, &self.grid.v]
            .map(|axis| stream.within(f64::from(axis.value(0.0)), f64::from(axis.value(axis.count as f32 - 1.0))));
        match varied {
            Varied::Snr => (level, self.at_radius, turned(&self.grid, a, b)),
            Varied::Size => (self.at_snr, level, turned(&self.grid, a, b)),
            Varied::Slope if is_along_v(&self.grid) => (self.at_snr, self.at_radius, turned(&self.grid, a, level)),
            Varied::Slope => (self.at_snr, self.at_radius, turned(&self.grid, level, b)),
        }
    }

    /// Whether a slope lies in the range of the search.
    pub fn is_in_range(&self, slope: Slope) -> bool {
        let (i, j) = self.grid.position(slope);
        // The ends of the range count as within it, whatever their rounding.
        let within = |at: f32, axis: &SlopeAxis| axis.count < 2 || (-1e-3..=axis.count as f32 - 0.999).contains(&at);
        let single = self.grid.len() == 1;
        let near = |a: f32, b: f32| (a - b).abs() < 1e-3;
        let only = self.grid.slope(0);
        within(i, &self.grid.u)
            && within(j, &self.grid.v)
            && (!single || near(slope.u, only.u) && near(slope.v, only.v))
    }

    /// Level of a slope along the axis that is varied: the inverse of [`Self::drawn`].
    pub(super) fn slope_level(&self, slope: Slope) -> f64 {
        let (a, b) = unit(&self.grid).position(slope);
        f64::from(if is_along_v(&self.grid) { b } else { a })
    }

    /// Slopes of the grid along the axis that is varied.
    pub fn searched(&self) -> Vec<f64> {
        let axis = along(&self.grid);
        (0..axis.count).map(|i| f64::from(axis.value(i as f32))).collect()
    }
}

/// Values from the first to the last, at equal ratios.
fn geometric([first, last]: [f64; 2], count: usize) -> impl Iterator<Item = f64> {
    let ratio = (last / first).ln() / (count.max(2) - 1) as f64;
    (0..count).map(move |i| first * (ratio * i as f64).exp())
}

/// Whether slopes are varied along the second axis: it alone has several.
fn is_along_v(grid: &SlopeGrid) -> bool {
    grid.u.count == 1 && grid.v.count > 1
}

fn along(grid: &SlopeGrid) -> &SlopeAxis {
    if is_along_v(grid) { &grid.v } else { &grid.u }
}

/// A grid of the same direction whose coordinates are pixels per frame.
fn unit(grid: &SlopeGrid) -> SlopeGrid {
    let axis = SlopeAxis { min: 0.0, max: 1.0, count: 2 };
    SlopeGrid { u: axis, v: axis, ..*grid }
}

/// The slope of coordinates (a, b) along the grid's axes, pixels per frame.
fn turned(grid: &SlopeGrid, a: f64, b: f64) -> Slope {
    unit(grid).at(a as f32, b as f32)
}

/// Slopes of an axis, half-way between them, and a step beyond its ends; fewer where they are many. For a single slope
/// multiples of a step that suits `frames` frames.
fn slopes_around(axis: &SlopeAxis, frames: usize) -> Vec<f64> {
    // A step of 2·σ/(N − 1) with σ = 1.6 misaligns the outermost frames by σ of the finest scale.
    let suiting = 3.2 / (frames.max(2) - 1) as f64;
    let step = if axis.count > 1 { f64::from(axis.step()) } else { suiting };
    let stride = (2 * (axis.count + 2)).div_ceil(MAX_SLOPE_LEVELS).max(1);
    let first = f64::from(axis.value(0.0));
    let mut list = vec![first - step, first - 0.5 * step];
    for index in (0..axis.count).step_by(stride) {
        list.extend([0.0, 0.5].map(|part| first + (index as f64 + part) * step));
    }
    let last = f64::from(axis.value(axis.count as f32 - 1.0));
    list.extend([last, last + 0.5 * step, last + step]);
    let tidy = |x: f64| (x * 1e4).round() / 1e4;
    list.iter_mut().for_each(|x| *x = tidy(*x));
    list.sort_by(f64::total_cmp);
    list.dedup();
    list
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slopes_are_those_of_the_grid_half_way_between_and_beyond() {
        let axis = SlopeAxis::new(-1.0..=1.0, 3);
        assert_eq!(slopes_around(&axis, 10), [-2.0, -1.5, -1.0, -0.5, 0.0, 0.5, 1.0, 1.5, 2.0]);
        let many = slopes_around(&SlopeAxis::new(-5.0..=5.0, 101), 10);
        assert!(many.len() <= MAX_SLOPE_LEVELS + 5 && many.contains(&5.0) && many.contains(&5.1), "{many:?}");
        assert_eq!(slopes_around(&SlopeAxis::ZERO, 9), [-0.4, -0.2, 0.0, 0.2, 0.4]);
    }

    #[test]
    fn levels_are_turned_with_the_grid() {
        let slope = turned(&SlopeGrid::line_along(90.0, -2.0..=2.0, 5), 1.5, 0.0);
        assert!(slope.u.abs() < 1e-5 && (slope.v - 1.5).abs() < 1e-5, "{slope:?}");
    }
}
