//! Tests of `inspect::set_up`.

use burstscope_core::burst::*;
use burstscope_core::detector::*;
use burstscope_core::inspect::set_up::*;
use proptest::prelude::*;

#[test]
fn the_error_of_a_depth_grows_with_the_depth() {
    let set_up = SetUp::default();
    let at = |u: f32| set_up.depth_with_error(Slope::new(u, 0.0), 0.25);
    // 2.5 px/frame are 8 m: a tenth of the slope is a tenth of the depth.
    assert_eq!((at(-2.5), at(-5.0), at(1.0)), (Some([8.0, 0.8]), Some([4.0, 0.2]), None));
}

proptest! {
    #[test]
    fn a_slope_reads_as_the_depth_that_it_comes_from(
        speed in 0.05f64..5.0, direction in -180.0f64..180.0, turn in -10.0f64..10.0, depth in 0.3f64..50.0,
    ) {
        let set_up = SetUp { speed_m_s: speed, direction_deg: direction, turn_deg_s: turn, ..SetUp::default() };
        let read = set_up.depth_at(set_up.slope_at(depth)).expect("a depth");
        prop_assert!((read / depth - 1.0).abs() < 1e-2, "{read} {depth}");
    }

    #[test]
    fn the_grid_holds_the_slopes_of_all_depths_and_its_step_suits_the_frames(
        speed in 0.05f64..2.0, direction in -180.0f64..180.0, turn in -5.0f64..5.0, part in 0.0f64..1.0,
    ) {
        let set_up = SetUp { speed_m_s: speed, direction_deg: direction, turn_deg_s: turn, ..SetUp::default() };
        let slopes = set_up.slopes(&Positions::even(10), &DetectorParams::default()).expect("few enough");
        let depth = 1.0 / (1.0 / 8.0 + part * (1.0 - 1.0 / 8.0));
        let slope = set_up.slope_at(depth);
        let (i, _) = slopes.grid.position(slope);
        let nearest = slopes.grid.at(i.round(), 0.0);
        let apart = (nearest.u - slope.u).hypot(nearest.v - slope.v);
        prop_assert!(apart <= 0.51 * slopes.step + 2e-3, "{apart} {slopes:?}");
        prop_assert!(i > 0.2 && i < slopes.grid.u.count as f32 - 1.2, "{i}");
    }
}

#[test]
fn nonsense_is_named_with_its_remedy() {
    let good = SetUp::default();
    let cases = [
        (SetUp { speed_m_s: -1.0, ..good }, "speed: "),
        (SetUp { frames_per_second: 0.0, ..good }, "fps: "),
        (SetUp { focal_px: f64::NAN, ..good }, "focal-px: "),
        (SetUp { depth_m: [3.0, 1.0], ..good }, "depth: "),
        (SetUp { depth_m: [1e-6, 1.0], ..good }, "depth: "),
        (SetUp { turn_deg_s: f64::INFINITY, ..good }, "turn-deg-s: "),
        (SetUp { direction_deg: 1e9, ..good }, "direction: "),
        (SetUp { depth_m: [1.0, 1e9], ..good }, "depth: "),
    ];
    for (set_up, start) in cases {
        let error = set_up.slopes(&Positions::even(10), &DetectorParams::default()).expect_err(start);
        assert!(error.starts_with(start), "{error}");
    }
    let options = good.slopes(&Positions::even(10), &DetectorParams::default()).expect("valid").options();
    assert!(options.starts_with("--slopes-u -") && !options.contains("--slopes-v"), "{options}");
}
