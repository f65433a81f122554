//! Periodic textures: their places in the picture, and the slopes at which they respond again.

use crate::detector::slopes::SlopeEvidence;
use crate::detector::{Slope, SlopeGrid};
use crate::inspect::ProbeCache;
use crate::inspect::slices::direction_of;
use crate::inspect::suspicion::stack_around;
use crate::inspect::texture::{dirichlet, period_along};
use crate::monitor::{Cancelled, Monitor};
use serde::Serialize;

/// A texture that is periodic along an axis of the slopes.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Alias {
    /// Period, pixels: slopes that differ by as many px/frame look alike.
    pub period_px: f32,
    /// Correlation of the texture with itself after a period, 0 … 1.
    pub correlation: f32,
    /// Direction of the slopes along which it is periodic, u and v, of length 1.
    pub direction: [f32; 2],
    /// Slope of the texture, px/frame, as far as it can be distinguished from its aliases.
    pub slope: Slope,
    /// Number of aliases of that slope within the slopes searched.
    pub inside_range: usize,
    /// Height (0 … 1) of the side lobes between them, for the frames used.
    pub side_lobe: f32,
    /// Places of the texture: (u, v) of the middle of each window, input pixels, the clearest first.
    pub places: Vec<[f32; 2]>,
}

/// Minimum ambiguity of a window to be examined.
const AMBIGUOUS: f32 = 0.5;
/// Minimum significance of a window to be examined.
const SIGNIFICANT: f32 = 6.5;
/// Maximum number of windows examined: the most significant ones.
const MAX_WINDOWS: usize = 120;
/// Relative difference below which two periods are the same.
const SAME_PERIOD: f32 = 0.12;
/// Pixels to each side in which a period is searched.
const HALF_PX: usize = 32;

/// Finds the periodic textures of a burst; those with aliases in range and with the most places come first. `all` is
/// the evidence of every window, `confirmed` the confirmed evidence.
pub(super) fn aliases(
    cache: &ProbeCache,
    confirmed: &[SlopeEvidence],
    all: &[SlopeEvidence],
    monitor: &Monitor,
) -> Result<Vec<Alias>, Cancelled> {
    let grid = cache.params().used_slopes();
    let frames = cache.trail.frames().0.len();
    if frames < 2 {
        return Ok(Vec::new());
    }
    let mut windows: Vec<&SlopeEvidence> =
        all.iter().filter(|e| e.significance >= SIGNIFICANT && e.ambiguity >= AMBIGUOUS).collect();
    windows.sort_by(|a, b| b.significance.total_cmp(&a.significance));
    windows.truncate(MAX_WINDOWS);
    let mut found: Vec<Alias> = Vec::new();
    for window in windows {
        monitor.check()?;
        let slope = believed(window, confirmed);
        let (stack, centre) = stack_around(&cache.trail, window.centre, slope, HALF_PX + 8, monitor)?;
        for direction in directions(&grid) {
            let Some(period) = period_along(&stack, centre, direction, HALF_PX) else { continue };
            let same = |alias: &&mut Alias| {
                alias.direction == direction && (alias.period_px / period.px - 1.0).abs() < SAME_PERIOD
            };
            match found.iter_mut().find(same) {
                Some(alias) => {
                    alias.correlation = alias.correlation.max(period.correlation);
                    let is_new = alias
                        .places
                        .iter()
                        .all(|[u, v]| (u - window.centre[0]).hypot(v - window.centre[1]) > HALF_PX as f32);
                    if is_new {
                        alias.places.push(window.centre);
                    }
                }
                None => found.push(Alias {
                    period_px: period.px,
                    correlation: period.correlation,
                    direction,
                    slope,
                    inside_range: inside_range(&grid, slope, direction, period.px),
                    side_lobe: highest_lobe(frames),
                    places: vec![window.centre],
                }),
            }
        }
    }
    // Textures with aliases within the slopes searched come first.
    let matters = |alias: &Alias| (alias.inside_range > 0, alias.places.len());
    found.sort_by(|a, b| matters(b).cmp(&matters(a)).then(b.correlation.total_cmp(&a.correlation)));
    Ok(found)
}

/// The slope of a window: that of the smallest confirmed evidence that contains its middle, or its own where there is
/// none.
fn believed(window: &SlopeEvidence, confirmed: &[SlopeEvidence]) -> Slope {
    let holds = |e: &&SlopeEvidence| {
        (e.centre[0] - window.centre[0]).abs() <= 0.5 * e.size[0]
            && (e.centre[1] - window.centre[1]).abs() <= 0.5 * e.size[1]
    };
    let area = |e: &SlopeEvidence| e.size[0] * e.size[1];
    let smallest = confirmed.iter().filter(holds).min_by(|a, b| area(a).total_cmp(&area(b)));
    smallest.map_or(window.slope, |e| e.slope)
}

/// The directions of the axes that have several slopes.
fn directions(grid: &SlopeGrid) -> Vec<[f32; 2]> {
    let origin = grid.at(0.0, 0.0);
    let towards = |to: Slope| direction_of(Slope::new(to.u - origin.u, to.v - origin.v));
    let axes = [(grid.u.count, grid.at(1.0, 0.0)), (grid.v.count, grid.at(0.0, 1.0))];
    axes.into_iter().filter(|(count, _)| *count > 1).map(|(_, to)| towards(to)).collect()
}

/// The number of slopes whole periods away from `slope` within the range of the axis along `direction`.
fn inside_range(grid: &SlopeGrid, slope: Slope, direction: [f32; 2], period: f32) -> usize {
    let along = |s: Slope| s.u * direction[0] + s.v * direction[1];
    let own = along(slope);
    let (min, max) =
        grid.slopes().map(along).fold((f32::INFINITY, f32::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
    let reach = ((max - min).abs() / period).ceil() as i64 + 1;
    let around = |k: &i64| *k != 0 && (min..=max).contains(&(own + *k as f32 * period));
    (-reach..=reach).filter(around).count()
}

/// The highest side lobe of the mean over `frames` frames, between two aliases.
fn highest_lobe(frames: usize) -> f32 {
    // Beyond the first zero, which lies 1/N of a period from the peak.
    let first = 1.0 / frames as f64;
    let lobes = (0..=200).map(|k| first + (0.5 - first) * f64::from(k) / 200.0).map(|x| dirichlet(frames, 1.0, x));
    if frames > 2 { lobes.fold(0.0, f64::max) as f32 } else { 0.0 }
}
