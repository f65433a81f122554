//! Accuracy in enough light: errors of positions, scales and motions of the discs found.
//!
//! Charts whose slopes are drawn from a continuum are searched with a grid of slopes. For every disc found (by the rule
//! of [`burstscope_core::inspect::result`]) the strongest feature is compared with the truth at mid-burst. Discs may
//! move faster than the grid reaches; features on the rim of the grid are counted, and left out of the errors.
//!
//! # Two kinds of charts
//! The published chart is crowded: most discs have a neighbour, or its smear, within the surroundings that a detector
//! looks at, which shifts the extremum of D in position and above all to smaller scales. On a chart of fewer discs that
//! [stand apart](stands_apart) in all frames the remaining errors are the detector's own. There is a study of each.
//!
//! # The expected scale
//! The response of the Laplacian of a Gaussian to a disc of radius r is strongest at σ = r/√2. That of a difference of
//! Gaussians D = G(kσ) − G(σ) is strongest at another σ, and in VLFeat's convention the smaller of the two is reported.
//! At the disc's centre G(σ) is 1 − exp(−r²/2σ²), so D is extremal where, with x = r²/2σ², exp(−x·(1 − 1/k²)) = 1/k²:
//! at σ = r/√(2·ln(k²)/(1 − 1/k²)). With 3 levels an octave, k = 2^(1/3), that is 0.633·r, 10.5 % below r/√2. Scale
//! errors are relative to that σ; no other correction is applied.

use super::chart::{LookedChart, summary};
use super::statistics::{Errors, quantiles};
use super::{RowStudy, check_lists};
use crate::synth::{ChartParams, FeatureTruth, Motion, Truth, synth_chart};
use burstscope_core::detector::{DetectorParams, Feature, SlopeGrid};
use burstscope_core::inspect::result::{Ranking, judge};
use burstscope_core::{detect::detect, error::Result, monitor::Monitor};
use serde::Serialize;

/// The σ at which a DoG pyramid of `levels` levels an octave reports a disc of `radius` pixels (see the module).
pub fn expected_sigma(radius: f64, levels: u32) -> f64 {
    let k2 = 2f64.powf(2.0 / f64::from(levels));
    radius / (2.0 * k2.ln() / (1.0 - 1.0 / k2)).sqrt()
}

/// Charts and detector parameters of a study of accuracy.
#[derive(Debug, Clone, PartialEq)]
pub struct AccuracyStudy {
    /// Parameters of the charts; their ratio and seed are set by the study.
    pub chart: ChartParams,
    /// Per-pixel signal-to-noise ratios, one row each; infinite for charts without noise.
    pub snrs: Vec<f64>,
    /// The first seed.
    pub first_seed: u64,
    /// Number of seeds, counting up from the first; 1 or more.
    pub seeds: u64,
    /// The detector's parameters, with the slopes that are searched.
    pub detector: DetectorParams,
}

impl AccuracyStudy {
    /// The published chart with slopes up to half a pixel beyond a grid of ±3 px/frame in steps of 0.5.
    pub fn with_motion(motion: Motion) -> Self {
        let slopes = match motion {
            Motion::OneD => SlopeGrid::line(-3.0..=3.0, 13),
            Motion::TwoD => SlopeGrid::plane(-3.0..=3.0, 13, -3.0..=3.0, 13),
        };
        Self {
            chart: ChartParams { motion, max_slope: 3.5, ..ChartParams::default() },
            snrs: vec![5.0, 0.6],
            first_seed: 1,
            seeds: 5,
            detector: DetectorParams { slopes, ..DetectorParams::default() },
        }
    }

    /// This study on charts of `discs` discs that stand apart: the gap has room for surroundings and relative motion.
    pub fn standing_apart(&self, discs: usize) -> Self {
        let chart = &self.chart;
        let axes: f64 = if chart.motion == Motion::OneD { 1.0 } else { 2.0 };
        // Two slopes differ by at most twice the largest, and act over half the burst's span to either side.
        let relative_motion = 2.0 * chart.max_slope * axes.sqrt() * 0.5 * chart.uneven.count_and_span(chart.frames).1;
        let gap = (SURROUNDINGS_IN_RADII - 1.0) * chart.radius.end() + relative_motion;
        Self { chart: ChartParams { discs, gap: gap.ceil(), ..chart.clone() }, ..self.clone() }
    }
}

/// Default number of discs that stand apart: 20 on 800×600 pixels, in proportion to the area, at least 1.
pub fn discs_apart(chart: &ChartParams) -> usize {
    (chart.width * chart.height / 24_000).max(1)
}

/// A disc of a chart, and the strongest feature that finds it.
#[derive(Debug, Clone)]
pub struct FoundDisc {
    disc: FeatureTruth,
    apart: bool,
    feature: Option<Feature>,
}

impl RowStudy for AccuracyStudy {
    type Row = f64;
    type Cell = Vec<FoundDisc>;
    type Report = AccuracyReport;

    fn check(&self) -> Result<()> {
        check_lists(&self.snrs, self.seeds)
    }

    fn rows(&self) -> Vec<f64> {
        self.snrs.clone()
    }

    fn seeds(&self) -> (u64, u64) {
        (self.first_seed, self.seeds)
    }

    fn cell(&self, snr: f64, seed: u64, monitor: &Monitor, done: &(dyn Fn(usize) + Sync)) -> Result<Vec<FoundDisc>> {
        let LookedChart { truth, detection, judged, .. } = self.look(snr, seed, monitor)?;
        let unfound = |&disc| FoundDisc { disc, apart: stands_apart(&disc, &truth), feature: None };
        let mut found: Vec<FoundDisc> = truth.features.iter().map(unfound).collect();
        for judged in judged {
            if let Some(disc) = judged.disc {
                found[disc].feature = Some(detection.features[judged.feature]);
            }
        }
        done(1);
        Ok(found)
    }

    fn report(&self, charts: &[(f64, Vec<Vec<FoundDisc>>)]) -> AccuracyReport {
        AccuracyReport {
            chart: self.chart.clone(),
            first_seed: self.first_seed,
            seeds: self.seeds,
            detector: self.detector.clone(),
            rows: charts.iter().map(|(snr, charts)| self.row(*snr, charts.iter().flatten())).collect(),
        }
    }
}

impl AccuracyStudy {
    /// Makes and searches one chart of the study, for a look at a point of a curve; errors as of a run.
    pub fn look(&self, snr: f64, seed: u64, monitor: &Monitor) -> Result<LookedChart> {
        let (burst, truth) = synth_chart(&self.chart_of(snr, seed), monitor)?;
        let detection = detect(&burst, &self.detector, monitor)?;
        let judged = judge(&detection.features, &truth, Ranking::Strength);
        Ok(LookedChart { burst, truth, detection, judged })
    }

    /// The parameters of the chart of a ratio and a seed.
    pub fn chart_of(&self, snr: f64, seed: u64) -> ChartParams {
        ChartParams { snr, seed, ..self.chart.clone() }
    }

    fn row<'a>(&self, snr: f64, found: impl Iterator<Item = &'a FoundDisc>) -> AccuracyRow {
        let grid = self.detector.used_slopes();
        let (mut within, mut beyond) = (RangeCount::default(), RangeCount::default());
        // Of each compared disc whether it stands apart, and its errors in u, v, scale, and the two slopes.
        let mut errors: Vec<(bool, [f64; 5])> = Vec::new();
        for FoundDisc { disc, apart, feature } in found {
            let count = if reaches(&grid, disc) { &mut within } else { &mut beyond };
            count.discs += 1;
            let Some(feature) = feature else { continue };
            count.found += 1;
            if feature.is_on_rim(&self.detector) {
                // On the rim the slope is not interpolated, and the motion may lie beyond the grid.
                count.marked += 1;
                continue;
            }
            let of_disc = [
                f64::from(feature.u) - disc.u,
                f64::from(feature.v) - disc.v,
                f64::from(feature.sigma) / expected_sigma(disc.radius, self.detector.levels) - 1.0,
                f64::from(feature.slope.u) - disc.slope_u,
                f64::from(feature.slope.v) - disc.slope_v,
            ];
            errors.push((*apart, of_disc));
        }
        let errors_of = |column: usize| Errors::of(&errors.iter().map(|(_, one)| one[column]).collect::<Vec<_>>());
        let lengths = |[a, b]: [usize; 2], all: bool| {
            let counted = errors.iter().filter(|(apart, _)| all || *apart);
            quantiles(counted.map(|(_, one)| one[a].hypot(one[b])), [0.5, 0.95])
        };
        AccuracyRow {
            snr,
            within,
            beyond,
            distance: lengths([0, 1], true),
            apart: errors.iter().filter(|(apart, _)| *apart).count(),
            distance_apart: lengths([0, 1], false),
            u: errors_of(0),
            v: errors_of(1),
            scale: errors_of(2),
            slope_distance: lengths([3, 4], true),
            slope_u: errors_of(3),
            slope_v: errors_of(4),
        }
    }
}

/// Whether a disc's slope lies between the outermost slopes of `grid`.
fn reaches(grid: &SlopeGrid, disc: &FeatureTruth) -> bool {
    let (sin, cos) = f64::from(grid.direction_deg).to_radians().sin_cos();
    // In the axes of the grid, which may be turned.
    let along = disc.slope_u * cos + disc.slope_v * sin;
    let across = disc.slope_v * cos - disc.slope_u * sin;
    let inside = |x: f64, min: f32, max: f32, count: usize| {
        // One slope has no range: a line does not limit the motion across it.
        count < 2 || (f64::from(min)..=f64::from(max)).contains(&x)
    };
    inside(along, grid.u.min, grid.u.max, grid.u.count) && inside(across, grid.v.min, grid.v.max, grid.v.count)
}

/// Radius of the surroundings that a detector looks at, in disc radii: 3 σ of the wider Gaussian, rounded up.
pub const SURROUNDINGS_IN_RADII: f64 = 2.4;

/// Whether no other disc comes into the surroundings of `disc` ([`SURROUNDINGS_IN_RADII`]) in any frame.
pub fn stands_apart(disc: &FeatureTruth, truth: &Truth) -> bool {
    let others = || truth.features.iter().filter(|other| other.id != disc.id);
    truth.offsets().into_iter().all(|at| {
        let (u, v) = disc.position(at);
        others().all(|other| {
            let (other_u, other_v) = other.position(at);
            (other_u - u).hypot(other_v - v) > SURROUNDINGS_IN_RADII * disc.radius + other.radius
        })
    })
}

/// Report of a study of accuracy.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[allow(missing_docs)] // the names say it
pub struct AccuracyReport {
    #[serde(serialize_with = "summary")]
    pub chart: ChartParams,
    pub first_seed: u64,
    pub seeds: u64,
    pub detector: DetectorParams,
    pub rows: Vec<AccuracyRow>,
}

/// The errors at one ratio, over all seeds together.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AccuracyRow {
    /// Per-pixel signal-to-noise ratio; null in JSON for charts without noise.
    pub snr: f64,
    /// Discs that move within the grid's range, between its outermost slopes.
    pub within: RangeCount,
    /// Discs that move faster than the grid's range.
    pub beyond: RangeCount,
    /// Errors of the columns, pixels.
    pub u: Errors,
    /// Errors of the rows, pixels.
    pub v: Errors,
    /// Distances from the true positions, pixels: median and 95 %.
    pub distance: [f64; 2],
    /// Number of compared discs that stand apart, see [`stands_apart`].
    pub apart: usize,
    /// Distances of the discs that stand apart from their true positions, pixels: median and 95 %.
    pub distance_apart: [f64; 2],
    /// Relative errors of scale: σ over the expected one, minus 1.
    pub scale: Errors,
    /// Errors of the slopes to the right, pixels per frame.
    pub slope_u: Errors,
    /// Errors of the slopes down, pixels per frame.
    pub slope_v: Errors,
    /// Lengths of the slopes' errors, pixels per frame: median and 95 %.
    pub slope_distance: [f64; 2],
}

/// Numbers of discs, of discs found, and of those found on the rim of the slopes searched.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct RangeCount {
    /// Number of discs.
    pub discs: usize,
    /// Number of discs that were found.
    pub found: usize,
    /// Number of found discs whose feature lies on the rim of the slopes, where slopes are not interpolated.
    pub marked: usize,
}

#[cfg(test)]
mod tests {
    use super::super::tests::chart;
    use super::*;

    #[test]
    fn the_expected_scale_is_where_the_difference_of_gaussians_peaks() {
        for levels in [1, 3, 5] {
            let k = 2f64.powf(1.0 / f64::from(levels));
            let response = |sigma: f64| {
                let g = |s: f64| 1.0 - (-0.5 / (s * s)).exp(); // disc of radius 1
                (g(k * sigma) - g(sigma)).abs()
            };
            let sigma = expected_sigma(1.0, levels);
            assert!(response(sigma) > response(sigma * 1.001) && response(sigma) > response(sigma / 1.001));
        }
        assert!((expected_sigma(10.0, 3) - 6.327).abs() < 1e-3);
    }

    #[test]
    fn a_disc_stands_apart_until_another_comes_near_in_some_frame() {
        let chart = ChartParams { frames: 2, ..chart((160, 120), 2, 10.0..=10.0, 0.0) };
        let (_, mut truth) = synth_chart(&chart, &Monitor::default()).expect("a chart");
        // 2.4 radii and the other's radius: 34 px between the centres.
        (truth.features[1].u, truth.features[1].v) = (truth.features[0].u + 35.0, truth.features[0].v);
        assert!(stands_apart(&truth.features[0], &truth));
        truth.features[1].slope_u = -3.0; // 1.5 px nearer in the last frame
        assert!(!stands_apart(&truth.features[0], &truth));
    }

    #[test]
    fn ranges_follow_a_turned_grid() {
        let disc = |slope_u, slope_v| FeatureTruth { slope_u, slope_v, ..FeatureTruth::default() };
        let line = SlopeGrid::line(-1.0..=2.0, 4);
        assert!(reaches(&line, &disc(1.9, 0.0)) && !reaches(&line, &disc(-1.1, 0.0)));
        let down = SlopeGrid::line_along(90.0, -1.0..=2.0, 4);
        assert!(reaches(&down, &disc(0.0, 1.9)) && !reaches(&down, &disc(0.0, -1.1)));
        let plane = SlopeGrid::plane(-1.0..=1.0, 3, -2.0..=2.0, 5);
        assert!(
            reaches(&plane, &disc(0.9, 1.9)) && !reaches(&plane, &disc(1.1, 0.0)) && !reaches(&plane, &disc(0.0, 2.1))
        );
    }
}
