//! The slopes that a burst needs: features found at each slope, evidence of the frames before any threshold, and
//! advice.
//!
//! The features show where the detector found something; the *evidence* ([`crate::detector::SlopeFinding`]) shows where
//! the motion stack has power that single frames do not have, also beyond the slopes that were searched. Advice
//! compares the two with the grid.

mod advice;
mod aliases;
mod frames;
mod loss;
mod range;

pub use advice::{SlopeAdvice, Subject};
pub use aliases::Alias;
pub use loss::step_loss;

use super::ProbeCache;
use crate::detector::slopes::SlopeEvidence;
use crate::detector::{Detection, Slope, SlopeChoice, SlopeFinding, SlopeGrid, find_slopes};
use crate::monitor::{Cancelled, Monitor};
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
    /// Number of features whose slope is nearest to this one.
    pub features: usize,
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
    /// Result of finding the slopes from the frames.
    pub finding: SlopeFinding,
    /// Confirmed evidence, strongest first.
    #[serde(skip)]
    pub evidence: Vec<SlopeEvidence>,
    /// Periodic textures.
    pub aliases: Vec<Alias>,
    /// Cost of the search.
    pub cost: Cost,
    /// Number of frames used.
    pub frames: usize,
    /// Advice, the most important first; empty when none is needed.
    pub advice: Vec<SlopeAdvice>,
}

/// Maximum number of grid steps beyond the rim that are shown.
const MAX_BEYOND: i64 = 40;

impl Spectrum {
    /// The searched slope with the most features that do not lie at the limit; `None` without features. See
    /// [`slope_with_most_features`].
    pub fn most_features(&self) -> Option<Slope> {
        // The slopes searched come first, in the grid's order.
        let counts: Vec<usize> = self.bars.iter().filter(|bar| bar.is_searched).map(|bar| bar.features).collect();
        slope_with_most_features(&self.grid, &counts).map(|(index, _)| self.grid.slope(index))
    }
}

/// Computes the spectrum of the burst of `cache`.
///
/// # Errors
/// [`Cancelled`] once `monitor` was cancelled.
pub fn spectrum(cache: &ProbeCache, monitor: &Monitor) -> Result<Spectrum, Cancelled> {
    let (trail, params) = (&cache.trail, cache.params());
    let grid = params.used_slopes();
    let finding = match &cache.finding {
        // A finding for a line has no evidence for the rest of the plane.
        Some(finding) if cache.asked.slopes == SlopeChoice::AUTO => finding.clone(),
        _ => find_slopes(&cache.burst, params, None, monitor)?,
    };
    let mut evidence = finding.confirmed(params, cache.burst.len());
    evidence.sort_by(|a, b| b.significance.total_cmp(&a.significance));
    let detection = trail.detection();
    let bars = bars(cache, &grid, &evidence);
    let aliases = aliases::aliases(cache, &evidence, &finding.evidence, monitor)?;
    let at_limit = detection.features.iter().filter(|f| f.at_slope_limit).count();
    let spectrum = Spectrum {
        grid,
        bars,
        features: detection.features.len(),
        at_limit,
        finding,
        evidence,
        aliases,
        cost: Cost { slopes: grid.len(), samples: detection.tally.samples, search_secs: detection.times.search_secs },
        frames: detection.frames_used.len(),
        advice: Vec::new(),
    };
    let advice = advice::advice(cache, &spectrum);
    Ok(Spectrum { advice, ..spectrum })
}

/// The share of a picture of `size` that all of `frames` frames show at `slope`.
pub fn coverage_share(slope: Slope, frames: usize, size: (usize, usize)) -> f32 {
    let part = |slope: f32, n: usize| (1.0 - slope.abs() * (frames.saturating_sub(1)) as f32 / n as f32).max(0.0);
    part(slope.u, size.0) * part(slope.v, size.1)
}

/// The coordinates of the slope of the grid, or of its continuation beyond the rim, nearest to a slope.
fn nearest(grid: &SlopeGrid, slope: Slope) -> [i64; 2] {
    let (i, j) = grid.position(slope);
    [i.round() as i64, j.round() as i64]
}

/// For each slope of the search, in its order, the number of features whose own slope is nearest to it.
pub fn features_at_slopes(detection: &Detection) -> Vec<usize> {
    let grid = &detection.slopes;
    let (nu, nv) = (grid.u.count as i64, grid.v.count as i64);
    let mut counts = vec![0usize; grid.len()];
    for feature in &detection.features {
        let [i, j] = nearest(grid, feature.slope);
        counts[(j.clamp(0, nv - 1) * nu + i.clamp(0, nu - 1)) as usize] += 1;
    }
    counts
}

/// The index of the slope of `grid` with the most of `counts` features, and their number; `None` where there are none.
/// Features on the rim are mostly of motions beyond it, so they count only where there are no others. Of equal slopes
/// the slowest is taken, then the first.
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
    places
        .into_iter()
        .map(|at| {
            let is_searched = inside(at);
            let slope = grid.at(at[0] as f32, at[1] as f32);
            SlopeBar {
                at,
                slope,
                is_searched,
                is_on_rim: is_searched && grid.on_rim(at[0] as usize, at[1] as usize),
                features: if is_searched { counts[(at[1] * nu + at[0]) as usize] } else { 0 },
                // An empty sum would be −0.
                evidence: seen.iter().filter(|(place, _)| *place == at).fold(0.0, |sum, (_, s)| sum + s) / total,
                coverage: coverage_share(slope, detection.frames_used.len(), cache.burst.size()),
            }
        })
        .collect()
}
