//! Laws of light fields: one row of views is a burst, a transposed light field has transposed features, and disparities
//! are found as those of the truth.

use crate::prelude::*;
use burstscope_core::inspect::result::finds;

fn chart(rows: usize, columns: usize, snr: f64) -> (Burst, Truth) {
    let uneven = Uneven { views: ViewGrid::new(rows, columns), ..Uneven::default() };
    let params = ChartParams { width: 320, height: 260, discs: 24, radius: 3.6..=12.0, ..ChartParams::default() };
    let params = ChartParams { max_slope: 2.0, snr, uneven, ..params };
    synth_chart(&params, &quiet()).expect("a chart")
}

fn with(params: DetectorParams, burst: &Burst) -> Detection {
    search(burst, &params.into(), &quiet()).expect("valid parameters").detection
}

fn line() -> DetectorParams {
    DetectorParams { slopes: SlopeGrid::line(-2.2..=2.2, 12), ..DetectorParams::default() }
}

/// Discs that a feature finds with their disparity, to a tenth of a pixel per view.
fn found(detection: &Detection, truth: &Truth) -> usize {
    let has_slope = |f: &Feature, slope: f64| (f64::from(f.slope.u) - slope).hypot(f64::from(f.slope.v)) < 0.1;
    let is_found = |disc: &&burstscope_core::synth::FeatureTruth| {
        detection.features.iter().any(|f| finds(f, disc) && has_slope(f, disc.slope_u))
    };
    truth.features.iter().filter(is_found).count()
}

fn row_of(burst: &Burst, rows: usize, columns: usize) -> Burst {
    let frames: Vec<usize> = (0..columns).map(|column| rows / 2 * columns + column).collect();
    burst.clone().of_frames(&frames, burst.positions.of(&frames))
}

#[test]
fn one_row_of_views_has_the_bits_of_a_burst_and_disparities_are_those_of_the_truth() {
    let (views, _) = chart(5, 7, 2.0);
    let row = row_of(&views, 5, 7);
    let planes: Vec<Plane> = row.frames.iter().map(|frame| (**frame).clone()).collect();
    let burst = Burst { quantisation_step: row.quantisation_step, ..Burst::from_planes("row", planes) };
    assert_eq!(row.positions, Positions::even(7));
    let [of_row, of_burst] = [&row, &burst].map(|burst| with(line(), burst));
    assert!(of_row.features.len() > 10);
    assert_eq!((of_row.features, of_row.descriptors), (of_burst.features, of_burst.descriptors));
    let (views, truth) = chart(7, 7, 0.5);
    assert_eq!((truth.views.len(), truth.span()), (49, 2.0 * 3f64.hypot(3.0)));
    let of_all = found(&with(line(), &views), &truth);
    let of_row = found(&with(line(), &row_of(&views, 7, 7)), &truth);
    println!("{of_all} of {} discs in all views, {of_row} in one row", truth.features.len());
    assert!(of_all * 10 >= truth.features.len() * 9 && of_row * 3 < of_all * 2, "{of_all} {of_row}");
    let joint = with(DetectorParams { slope_extrema: SlopeExtrema::Joint, ..line() }, &views);
    let of_joint = found(&joint, &truth);
    assert!(of_joint * 10 >= truth.features.len() * 8, "{of_joint} by the joint search");
}

#[test]
fn a_transposed_light_field_has_transposed_features() {
    let (views, _) = chart(3, 5, 3.0);
    let transposed = |k: usize| {
        let frame = &views.frames[k % 3 * 5 + k / 3];
        Arc::new(Plane::from_fn(frame.height(), frame.width(), |u, v| frame.at(v, u)))
    };
    let turned = Burst { frames: (0..15).map(transposed).collect(), positions: Positions::grid(5, 3), ..views.clone() };
    let [own, other] = [&views, &turned].map(|burst| with(line(), burst));
    let strong = |f: &&Feature| f.snr > 30.0;
    let is_it = |f: &Feature, g: &Feature| {
        (f.u - g.v).abs() < 0.02
            && (f.v - g.u).abs() < 0.02
            && (f.sigma / g.sigma - 1.0).abs() < 0.01
            && (f.slope.u - g.slope.u).abs() < 0.01
            // The peak is as wide; noise is measured in parts of the frames, which differ.
            && (f.slope_sigma * f.snr / (g.slope_sigma * g.snr) - 1.0).abs() < 0.02
    };
    assert!(own.features.iter().filter(strong).count() > 15);
    own.features.iter().filter(strong).for_each(|f| assert!(other.features.iter().any(|g| is_it(f, g)), "{f:?}"));
}

#[test]
fn slopes_are_found_along_the_disparity_alone_and_nothing_is_said_of_time() {
    let params = SceneParams { width: 320, height: 240, layers: 3, max_slope: 1.5, snr: 2.0, ..SceneParams::default() };
    let params = SceneParams { uneven: Uneven { views: ViewGrid::new(5, 5), ..Uneven::default() }, ..params };
    let (views, truth) = synth_scene(&params, &quiet()).expect("a scene");
    let finding = find_slopes(&views, &DetectorParams::default(), None, &quiet()).expect("not cancelled");
    assert_eq!((finding.verdict, finding.warnings.len()), (SlopeVerdict::Found, 0), "{}", finding.summary());
    assert!(!finding.grid.is_plane() && finding.grid.direction_deg == 0.0, "{:?}", finding.grid);
    let axis = finding.grid.u;
    let holds = |slope: f64| (f64::from(axis.min)..=f64::from(axis.max)).contains(&slope);
    assert!(truth.layers.iter().all(|layer| holds(layer.slope_u)), "{axis:?} {:?}", truth.layers);
    assert!(finding.confidence > 0.8 && axis.max - axis.min < 5.0, "{} {axis:?}", finding.confidence);
    // The field of the disparities is the depth map.
    let found = search(&views, &SearchParams::default(), &quiet()).expect("valid parameters").detection;
    let field = found.field.expect("a field");
    let near = |slope: f32| truth.layers.iter().any(|layer| (f64::from(slope) - layer.slope_u).abs() < 0.15);
    let known: Vec<_> = (0..30)
        .flat_map(|j| (0..40).map(move |i| (8.0 * i as f32, 8.0 * j as f32)))
        .filter_map(|(u, v)| field.known_at(u, v))
        .collect();
    let right = known.iter().filter(|motion| motion.slope.v == 0.0 && near(motion.slope.u)).count();
    assert!(known.len() > 600 && right * 10 > known.len() * 6, "{right} of {}", known.len());
}
