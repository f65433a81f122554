//! How close features come to the truth: places, scales and slopes of a chart's discs, in one and two dimensions of motion.
//!
//! True slopes are drawn from a continuum and the grid has steps of 0.5 px/frame, so what is finer than the step is the refinement's work. Discs
//! reach half a pixel per frame beyond the grid; those must be marked.

use burstscope::evaluate::accuracy::{AccuracyReport, AccuracyStudy};
use burstscope::evaluate::statistics::Errors;
use burstscope::synth::{ChartParams, Motion};
use burstscope::{DetectorParams, Monitor, SlopeGrid};

/// What must hold at one signal-to-noise ratio. All are medians of magnitudes.
struct Bar {
    snr: f64,
    /// Distance from the true place, pixels: what must hold, and what is aimed at.
    distance_px: f64,
    distance_aim_px: f64,
    /// Scale, relative to the expected σ.
    scale: f64,
    /// Slope on each axis that moves, pixels per frame.
    slope_px_per_frame: f64,
}

/// Tighten these as the detector gets better. `cargo test --test accuracy -- --nocapture` shows what is measured.
const BARS_1D: [Bar; 2] = [
    Bar { snr: 5.0, distance_px: 0.16, distance_aim_px: 0.05, scale: 0.03, slope_px_per_frame: 0.03 },
    Bar { snr: 0.6, distance_px: 0.5, distance_aim_px: 0.5, scale: 0.03, slope_px_per_frame: 0.1 },
];
const BARS_2D: [Bar; 2] = [
    Bar { snr: 5.0, distance_px: 0.16, distance_aim_px: 0.05, scale: 0.03, slope_px_per_frame: 0.03 },
    Bar { snr: 0.6, distance_px: 0.5, distance_aim_px: 0.5, scale: 0.03, slope_px_per_frame: 0.1 },
];
/// Where discs do not crowd each other, places are better.
const BAR_APART: Bar =
    Bar { snr: 5.0, distance_px: 0.06, distance_aim_px: 0.05, scale: 0.03, slope_px_per_frame: 0.03 };
/// A bias of this many standard errors happens by chance once in 15 000 times; a test looks at a few dozen.
const BIAS_STANDARD_ERRORS: f64 = 4.0;
/// The scale may be off by this much in the mean: the expected σ knows nothing of the pixels' own blur and of what surrounds a disc.
const SCALE_BIAS: f64 = 0.02;

fn check(report: &AccuracyReport, bars: &[Bar]) {
    for (row, bar) in report.rows.iter().zip(bars) {
        let median = |e: &Errors| e.median_magnitude;
        let slopes = if report.chart.motion == "2d" { vec![&row.slope_u, &row.slope_v] } else { vec![&row.slope_u] };
        println!(
            "{} SNR {}: {} of {} found; median errors: distance {:.3} px (bar {}, aim {}), scale {:.4} (bar {}), slope {:.4?} px/frame (bar {}); \
             beyond the grid {} of {} found discs are marked",
            report.chart.motion,
            row.snr,
            row.within.found,
            row.within.discs,
            row.distance[0],
            bar.distance_px,
            bar.distance_aim_px,
            median(&row.scale),
            bar.scale,
            slopes.iter().map(|s| median(s)).collect::<Vec<_>>(),
            bar.slope_px_per_frame,
            row.beyond.marked,
            row.beyond.found,
        );
        assert_eq!(row.snr, bar.snr);
        assert!(row.within.found * 100 >= row.within.discs * 95, "{:?}", row.within);
        assert!(row.u.count >= 50, "few are left to compare: {:?}", row.within);
        assert!(row.distance[0] <= bar.distance_px, "{:?}", row.distance);
        assert!(median(&row.scale) <= bar.scale, "{:?}", row.scale);
        for slope in &slopes {
            assert!(median(slope) <= bar.slope_px_per_frame, "{slope:?}");
        }
        for unbiased in [&row.u, &row.v].into_iter().chain(slopes) {
            assert!(unbiased.signed.is_consistent_with_zero(BIAS_STANDARD_ERRORS), "{unbiased:?}");
        }
        assert!(row.scale.signed.mean.abs() <= SCALE_BIAS, "{:?}", row.scale);
        // What is beyond the grid is marked, but for a few whose noise pulls them inside.
        assert!(row.beyond.marked * 100 >= row.beyond.found * 95, "{:?}", row.beyond);
        // Inside, only what lies next to the rim may be: in two dimensions about a quarter.
        assert!(row.within.marked * 5 <= row.within.found * 2, "{:?}", row.within);
    }
}

fn study(motion: Motion, bars: &[Bar], seeds: u64) -> AccuracyStudy {
    let snrs = bars.iter().map(|bar| bar.snr).collect();
    AccuracyStudy { snrs, first_seed: 21, seeds, ..AccuracyStudy::with_motion(motion) }
}

fn run(study: &AccuracyStudy) -> AccuracyReport {
    study.run(&Monitor::default()).expect("a report")
}

#[test]
fn features_are_where_the_discs_are_in_one_dimension_of_motion() {
    check(&run(&study(Motion::OneD, &BARS_1D, 3)), &BARS_1D);
}

#[test]
fn features_are_where_the_discs_are_in_two_dimensions_of_motion() {
    // The published chart is large for a plane of slopes: a third of it, and slopes a little beyond ±2.
    let full = study(Motion::TwoD, &BARS_2D, 4);
    let chart = ChartParams { width: 480, height: 360, discs: 30, max_slope: 2.25, ..full.chart.clone() };
    let slopes = SlopeGrid::plane(-2.0..=2.0, 9, -2.0..=2.0, 9);
    let detector = DetectorParams { slopes, ..full.detector.clone() };
    check(&run(&AccuracyStudy { chart, detector, ..full }), &BARS_2D);
}

#[test]
fn features_are_closer_where_discs_stand_apart() {
    let bars = [BAR_APART];
    let crowded = study(Motion::OneD, &bars, 8);
    let chart = ChartParams { discs: 12, max_slope: 2.75, ..crowded.chart.clone() };
    check(&run(&AccuracyStudy { chart, ..crowded }), &bars);
}

#[test]
fn the_report_does_not_depend_on_the_threads() {
    let study = AccuracyStudy {
        chart: ChartParams { width: 300, height: 200, discs: 10, max_slope: 1.5, ..ChartParams::default() },
        snrs: vec![2.0, f64::INFINITY],
        seeds: 2,
        ..AccuracyStudy::with_motion(Motion::OneD)
    };
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| run(&study))
    };
    assert_eq!(with(1), with(3));
}
