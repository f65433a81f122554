//! Tests of `detector::noise_model::codec`.
#![allow(unused_imports)]

use burstscope_core::detector::*;
use burstscope_core::detector::noise_model::*;
use burstscope_core::detector::params::*;
use burstscope_core::detector::params::doc::*;
use burstscope_core::error::*;
use burstscope_core::plane::*;
use serde::Serialize;
use burstscope_core::monitor::Monitor;
use burstscope_core::synth::NoiseCase;

fn found(case: NoiseCase, level: f64) -> Option<Flattened> {
    let burst = case.burst_at(level, (320, 240), 4, 0.02, 3, &Monitor::default()).expect("not cancelled");
    Flattened::find(&burst.frames.iter().map(|f| &**f).collect::<Vec<_>>(), 1.0 / 255.0)
}

#[test]
fn blocks_of_files_of_low_quality_are_flat() {
    let grey = found(NoiseCase::Jpeg(30), 0.5).expect("flattened");
    assert!((0.5..0.8).contains(&grey.share) && grey.is_measurable(), "{grey:?}");
    for level in [0.2, 0.35] {
        let colour = found(NoiseCase::ColourJpeg(30), level).expect("flattened");
        assert!(colour.share > 0.9 && colour.shown > 2.0 * (1.0 - colour.share), "{level}: {colour:?}");
    }
    for case in [NoiseCase::White, NoiseCase::Jpeg(90), NoiseCase::ColourJpeg(90), NoiseCase::Constant] {
        assert_eq!(found(case, 0.5), None, "{case:?}");
    }
}

#[test]
fn strict_is_refused_with_the_reason_where_nothing_is_left() {
    let left = Flattened { share: 0.999, shown: 0.002 };
    assert!(!left.is_measurable() && left.warning().text.contains("too few"));
    let refused = left.against_strict().to_string();
    assert!(refused.contains("noise-gate") && refused.contains("JPEG"), "{refused}");
    assert!(Flattened { share: 0.96, shown: 0.1 }.is_measurable());
}

#[test]
fn flat_parts_of_a_scene_are_no_blocks() {
    // Rectangles of one grey each, at any place.
    let step = 1.0 / 255.0;
    let scene = Plane::from_fn(400, 300, |u, v| step * ((u / 37 * 7 + v / 23 * 5) % 64) as f32);
    assert_eq!(Flattened::find(&[&scene], step), None);
    assert_eq!(Flattened::find(&[&scene], 0.0), None);
    assert_eq!(Flattened::find(&[&Plane::zeros(15, 9)], step), None);
}



