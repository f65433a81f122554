//! Which slopes does this burst need? The [`spectrum`] answers with the features at each slope, and with *evidence*.
//!
//! The evidence ([`crate::detector::SlopeFinding`]) shows where the motion stack has power that single frames do not
//! have, before any threshold and also beyond the slopes that were searched. `fit` judges whether the searched slopes
//! suit it, `advice` says what to change, and `set_up` computes slopes from the speed and the distances of the camera.

mod advice;
mod fit;
mod set_up;

pub use advice::{AdviceSubject, SlopeAdvice};
pub use fit::{SlopeJudgement, is_doubtful, judgement};
pub use set_up::{SetUp, SetUpSlopes, set_up_bounds};

use super::ProbeCache;
use crate::detector::{Detection, Feature, Slope, SlopeFinding, SlopeGrid};
use crate::monitor::{Cancelled, Monitor};
use crate::{burst::Positions, detector::slopes::SlopeEvidence};
use serde::Serialize;

/// Features and evidence at one slope.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SlopeBar {
    /// Coordinates in the grid, first axis and second; outside the grid beyond its rim.
    pub at: [i64; 2],
    /// Slope, px/frame.
    pub slope: Slope,
    /// Whether the slope was searched.
    pub is_searched: bool,
    /// Whether it is on the rim of the searched slopes.
    pub is_on_rim: bool,
    /// Number of features whose [motion](Feature::motion) is nearest to this slope.
    pub features: usize,
    /// Number of those at the limit of the slopes.
    pub at_limit: usize,
    /// Part (0 … 1) of all evidence, weighted by significance, whose slope is nearest to this one.
    pub evidence: f32,
    /// Share (0 … 1) of the picture that all frames show at this slope.
    pub coverage: f32,
}

/// Cost of a search.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Cost {
    /// Number of slopes searched.
    pub slopes: usize,
    /// Number of samples of D examined.
    pub samples: u64,
    /// Wall-clock time of the search, seconds.
    pub search_secs: f32,
}

/// Spectrum of the slopes of a burst.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Spectrum {
    /// Slopes that were searched.
    pub grid: SlopeGrid,
    /// Slopes of the grid in its order, first axis fastest, and those beyond its rim with evidence.
    pub bars: Vec<SlopeBar>,
    /// Number of features.
    pub features: usize,
    /// Number of features at the limit of the slopes.
    pub at_limit: usize,
    /// Judgement of the slopes; `None` for a method without slopes and for a single frame.
    pub judgement: Option<SlopeJudgement>,
    /// Result of finding the slopes from the frames.
    pub finding: SlopeFinding,
    /// Confirmed evidence, strongest first.
    #[serde(skip)]
    pub evidence: Vec<SlopeEvidence>,
    /// Cost of the search.
    pub cost: Cost,
    /// Number of frames used.
    pub frames: usize,
    /// Advice, the most important first; empty when none is needed.
    pub advice: Vec<SlopeAdvice>,
}

const MAX_BEYOND: i64 = 40;

impl Spectrum {
    /// See [`slope_with_most_features`].
    pub fn most_features(&self) -> Option<Slope> {
        // The slopes searched come first, in the grid's order.
        let counts: Vec<usize> = self.bars.iter().filter(|bar| bar.is_searched).map(|bar| bar.features).collect();
        slope_with_most_features(&self.grid, &counts).map(|(index, _)| self.grid.slope(index))
    }
}

/// Computes the spectrum of the burst of `cache`.
pub fn spectrum(cache: &ProbeCache, monitor: &Monitor) -> Result<Spectrum, Cancelled> {
    let (trail, params) = (&cache.trail, cache.params());
    let grid = params.used_slopes();
    let finding = cache.shown(monitor)?.clone();
    let mut evidence = finding.confirmed(params, &cache.burst.positions);
    evidence.sort_by(|a, b| b.significance.total_cmp(&a.significance));
    let detection = trail.detection();
    let bars = bars(cache, &grid, &evidence);
    let judging = fit::Judging::new(detection, params, Some(&finding), &evidence, &cache.burst);
    let judgement = judging.map(|judging| judging.judgement(monitor)).transpose()?;
    let spectrum = Spectrum {
        grid,
        bars,
        features: detection.features.len(),
        at_limit: detection.features.iter().filter(|f| f.at_slope_limit).count(),
        judgement,
        finding,
        evidence,
        cost: Cost { slopes: grid.len(), samples: detection.tally.samples, search_secs: detection.times.search_secs },
        frames: detection.frames_used.len(),
        advice: Vec::new(),
    };
    Ok(Spectrum { advice: advice::advice(cache, &spectrum, monitor)?, ..spectrum })
}

/// The share of a picture of `size` that all frames at `positions` show at `slope`.
pub fn coverage_share(slope: Slope, positions: &Positions, size: (usize, usize)) -> f32 {
    let moved = || positions.offsets().iter().map(|offset| slope.displacement(offset.to_f32()));
    let part = |of: fn((f32, f32)) -> f32, n: usize| {
        let (least, most) = moved().map(of).fold((0.0, 0.0), |(a, b): (f32, f32), x| (a.min(x), b.max(x)));
        (1.0 - (most - least) / n as f32).max(0.0)
    };
    part(|by| by.0, size.0) * part(|by| by.1, size.1)
}

/// Coordinates in the grid, or in its continuation beyond the rim.
fn nearest(grid: &SlopeGrid, slope: Slope) -> [i64; 2] {
    <[f32; 2]>::from(grid.position(slope)).map(rounded)
}

/// The nearest whole number; of two the larger one, so that each place belongs to one.
fn rounded(x: f32) -> i64 {
    (x + 0.5).floor() as i64
}

/// Whether a feature of a search over `grid` is at `slope`, which may lie between the grid's slopes: whether its
/// [motion](Feature::motion) is within half a step on each axis, as for [`features_at_slopes`]. Motions beyond the grid
/// are at its rim; none are at a slope beside a line of slopes by more than half a step (0.1 px/frame for one slope).
pub fn is_at_slope(grid: &SlopeGrid, feature: &Feature, slope: Slope) -> bool {
    at_slope(grid, slope)(feature)
}

/// Test of many features by [`is_at_slope`], for which what depends on the slope alone is computed once.
pub fn at_slope(grid: &SlopeGrid, slope: Slope) -> impl Fn(&Feature) -> bool + use<> {
    let rim = |x: f32, count: usize| x.clamp(0.0, count.max(1) as f32 - 1.0);
    let (grid, (at_i, at_j)) = (*grid, grid.position(slope));
    let on_grid = grid.at(at_i, at_j);
    // Slopes of the grid are at whole numbers but for rounding, by which a place half-way would be at two.
    let [at_i, at_j] = [at_i, at_j].map(|at| if (at - at.round()).abs() < 1e-3 { at.round() } else { at });
    let beside = (slope.u - on_grid.u).hypot(slope.v - on_grid.v);
    let is_on_grid = beside <= 0.5 * grid.u.step().max(grid.v.step()).max(0.2);
    move |feature| {
        let (i, j) = grid.position(feature.motion().0);
        is_on_grid && rounded(rim(i, grid.u.count) - at_i) == 0 && rounded(rim(j, grid.v.count) - at_j) == 0
    }
}

/// For each slope of the search, in its order, the number of features whose [motion](Feature::motion) is nearest to it.
pub fn features_at_slopes(detection: &Detection) -> Vec<usize> {
    counts_of(&detection.slopes, &detection.features, |_| true)
}

fn counts_of(grid: &SlopeGrid, features: &[Feature], counts_too: impl Fn(&Feature) -> bool) -> Vec<usize> {
    let (nu, nv) = (grid.u.count as i64, grid.v.count as i64);
    let mut counts = vec![0usize; grid.len()];
    for feature in features.iter().filter(|feature| counts_too(feature)) {
        let [i, j] = nearest(grid, feature.motion().0);
        counts[(j.clamp(0, nv - 1) * nu + i.clamp(0, nu - 1)) as usize] += 1;
    }
    counts
}

/// The index of the slope of `grid` with the most of `counts` features, and their number. Features on the rim, which
/// are mostly of motions beyond it, count only where there are no others; of equal slopes the slowest is taken.
pub fn slope_with_most_features(grid: &SlopeGrid, counts: &[usize]) -> Option<(usize, usize)> {
    let is_inner = |index: usize| {
        let (i, j) = grid.coordinates(index);
        counts[index] > 0 && !grid.on_rim(i, j)
    };
    let any_inner = (0..counts.len()).any(is_inner);
    let wanted = counts.iter().copied().enumerate().filter(|&(i, n)| if any_inner { is_inner(i) } else { n > 0 });
    let slowness = |index: usize| -grid.slope(index).magnitude();
    wanted.max_by(|a, b| a.1.cmp(&b.1).then(slowness(a.0).total_cmp(&slowness(b.0))).then(b.0.cmp(&a.0)))
}

fn bars(cache: &ProbeCache, grid: &SlopeGrid, evidence: &[SlopeEvidence]) -> Vec<SlopeBar> {
    let detection = cache.detection();
    let (nu, nv) = (grid.u.count as i64, grid.v.count as i64);
    let inside = |[i, j]: [i64; 2]| (0..nu).contains(&i) && (0..nv).contains(&j);
    let mut places: Vec<[i64; 2]> = (0..nv).flat_map(|j| (0..nu).map(move |i| [i, j])).collect();
    let within = |x: i64, n: i64| (-MAX_BEYOND..n + MAX_BEYOND).contains(&x);
    let seen: Vec<([i64; 2], f32)> = evidence.iter().map(|e| (nearest(grid, e.slope), e.significance)).collect();
    let mut beyond: Vec<[i64; 2]> =
        seen.iter().map(|(at, _)| *at).filter(|at| !inside(*at) && within(at[0], nu) && within(at[1], nv)).collect();
    beyond.sort_by_key(|[i, j]| (*j, *i));
    beyond.dedup();
    places.extend(beyond);
    let total = seen.iter().fold(0.0f32, |sum, (_, significance)| sum + significance).max(f32::MIN_POSITIVE);
    let counts = features_at_slopes(detection);
    let limits = counts_of(&detection.slopes, &detection.features, |feature| feature.at_slope_limit);
    places
        .into_iter()
        .map(|at| {
            let is_searched = inside(at);
            let of_searched = |counts: &[usize]| if is_searched { counts[(at[1] * nu + at[0]) as usize] } else { 0 };
            let slope = grid.at(at[0] as f32, at[1] as f32);
            SlopeBar {
                at,
                slope,
                is_searched,
                is_on_rim: is_searched && grid.on_rim(at[0] as usize, at[1] as usize),
                features: of_searched(&counts),
                at_limit: of_searched(&limits),
                // An empty sum would be −0.
                evidence: seen.iter().filter(|(place, _)| *place == at).fold(0.0, |sum, (_, s)| sum + s) / total,
                coverage: coverage_share(slope, &detection.positions, cache.burst.size()),
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::detector::limit::response_loss;

    #[test]
    fn each_feature_is_at_one_slope_and_all_counts_of_it_agree() {
        let single = SlopeGrid::line(0.0..=0.0, 1);
        let grids =
            [SlopeGrid::plane(-2.0..=2.0, 5, -1.0..=1.0, 3), SlopeGrid::line_along(30.0, -2.0..=2.0, 9), single];
        // Motions on a lattice, also half-way between slopes and beyond the grid.
        let motions = (0..400).map(|i| Slope::new(0.25 * (i % 20) as f32 - 2.5, 0.25 * (i / 20) as f32 - 2.5));
        let features: Vec<Feature> =
            motions.map(|slope| Feature { slope, field_sigma: f32::INFINITY, ..Feature::default() }).collect();
        for grid in grids {
            let mut counts = vec![0usize; grid.len()];
            for feature in &features {
                let at: Vec<usize> = (0..grid.len()).filter(|i| is_at_slope(&grid, feature, grid.slope(*i))).collect();
                let [own] = at[..] else { panic!("{:?} is at {at:?}", feature.slope) };
                counts[own] += 1;
            }
            assert_eq!(counts_of(&grid, &features, |_| true), counts);
        }
        let still = Feature::default();
        assert!(
            is_at_slope(&single, &still, Slope::new(0.05, 0.0)) && !is_at_slope(&single, &still, Slope::new(1.0, 0.0))
        );
        assert!(!is_at_slope(&SlopeGrid::line(-2.0..=2.0, 5), &still, Slope::new(0.0, 1.0)), "beside the line");
    }

    #[test]
    fn the_loss_grows_with_step_and_frames_and_not_with_scale() {
        let step_loss = |step: f32, frames, sigma| response_loss(0.5 * step, &Positions::even(frames), sigma);
        // The step 2σ/(N − 1) loses little.
        let recommended = 2.0 * 1.9 / 9.0;
        let loss = step_loss(recommended, 10, 1.9);
        assert!((0.02..0.08).contains(&loss), "{loss}");
        assert!(step_loss(3.0 * recommended, 10, 1.9) > 5.0 * loss);
        assert!(step_loss(recommended, 20, 1.9) > loss && step_loss(recommended, 10, 4.0) < loss);
        assert_eq!((step_loss(1.0, 1, 2.0), step_loss(0.0, 10, 2.0)), (0.0, 0.0));
        assert!(step_loss(60.0, 20, 1.9) > 0.9);
    }
}
