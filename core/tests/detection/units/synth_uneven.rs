//! Tests of `synth::uneven`.

use burstscope_core::synth::uneven::*;

#[test]
fn numbers_and_spans_are_those_of_the_positions() {
    for text in ["", "1x9", "9x1", "3x5", "9x9"] {
        let uneven = Uneven { views: text.parse().ok(), ..Uneven::default() };
        let (whole, (count, span)) = (uneven.whole(10), uneven.count_and_span(10));
        assert!(count == whole.len() && (span - whole.span()).abs() < 1e-9, "{text}: {count} {span}");
    }
    assert_eq!(Uneven::default().count_and_span(usize::MAX).0, usize::MAX, "any number costs nothing");
}

#[test]
fn exchanged_frames_are_told_by_the_images_and_the_truth_alone() {
    use burstscope_core::Monitor;
    use burstscope_core::synth::{ChartParams, synth_chart};
    let chart = ChartParams { width: 200, height: 150, discs: 4, max_slope: 1.0, frames: 5, ..Default::default() };
    let chart = ChartParams { radius: 3.6..=8.0, ..chart };
    let made = |drop: &[usize], exchange: &[usize]| {
        let uneven = Uneven { drop: drop.to_vec(), exchange: exchange.to_vec(), ..Uneven::default() };
        synth_chart(&ChartParams { uneven, ..chart.clone() }, &Monitor::default())
    };
    let ((even, plain), (burst, truth)) = (made(&[], &[]).expect("even"), made(&[], &[0, 3]).expect("exchanged"));
    assert_eq!(truth.times, [3.0, 1.0, 2.0, 0.0, 4.0]);
    assert!(burst.positions.is_even() && (truth.t0, truth.span()) == (plain.t0, 4.0));
    assert_eq!((&burst.frames[0], &burst.frames[3]), (&even.frames[3], &even.frames[0]));
    assert_eq!(truth.features, plain.features);
    let (burst, truth) = made(&[1], &[0, 1]).expect("exchanged and dropped");
    assert_eq!(
        (&truth.times[..], burst.positions.since_first()),
        (&[2.0, 0.0, 3.0, 4.0][..], vec![0.0, 2.0, 3.0, 4.0])
    );
    for wrong in [&[1][..], &[2, 2], &[0, 5], &[0, 1, 2]] {
        let error = made(&[], wrong).expect_err("no two frames").to_string();
        assert!(error.starts_with("exchange: these are no two frames"), "{error}");
    }
}
