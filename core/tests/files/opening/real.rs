//! Bursts of real cameras, where they are available.

use crate::shared::shared;
use burstscope_core::burst::{Burst, OpenError, find_bursts};

#[needs::shared("data")]
#[test]
fn real_bursts_open() {
    let data = shared("data");
    let cases = [
        ("buff-demo-1d", 5, (800, 640)),
        ("buff-demo-2d", 5, (200, 200)),
        ("slider-far", 60, (240, 180)),
        ("visp-cube", 40, (384, 288)),
        ("light-field-shop", 27, (960, 640)),
    ];
    for (name, frames, size) in cases {
        let burst = Burst::open(data.join(name)).expect(name);
        assert_eq!((burst.name.as_str(), burst.len(), burst.size(), burst.full_scale), (name, frames, size, 255.0));
        let values = burst.frames.iter().flat_map(|f| f.data());
        let (min, max) = values.fold((1.0f32, 0.0f32), |(a, b), &v| (a.min(v), b.max(v)));
        assert!(min >= 0.0 && max <= 1.0 && max - min > 0.05, "{name}: {min} … {max}");
    }
    let burst = Burst::open(data.join("slider-far")).expect("opens");
    assert_eq!(
        (burst.frame_names[0].as_str(), burst.frame_names[59].as_str()),
        ("frame_00000008.png", "frame_00000067.png")
    );
    // Four channels, all grey: the values equal those of the file.
    let discs = Burst::open(data.join("buff-demo-2d")).expect("opens");
    assert!(discs.frames[0].data().iter().all(|v| (v * 255.0).round() / 255.0 == *v));
}

#[needs::shared("data")]
#[test]
fn the_data_folder_is_a_dataset() {
    let data = shared("data");
    let names: Vec<String> = find_bursts(&[data]).expect("bursts").into_iter().map(|s| s.name).collect();
    let raw = cfg!(feature = "raw").then_some("raw");
    let expected: Vec<&str> = ["buff-demo-1d", "buff-demo-2d", "light-field-shop"]
        .into_iter()
        .chain(raw)
        .chain(["slider-far", "visp-cube"])
        .collect();
    assert_eq!(names, expected);
}

#[needs::shared("data")]
#[test]
fn sensor_raw_files_open_or_are_refused_with_a_reason() {
    let data = shared("data");
    let opened = Burst::open(data.join("raw/colorchart.dng"));
    if cfg!(feature = "raw") {
        let chart = opened.expect("a camera's own DNG");
        let (width, height) = chart.size();
        assert!(chart.binning == 2 && width > 500 && height > 500, "{width}×{height}");
        let values = chart.frames[0].data();
        let mean = values.iter().sum::<f32>() / values.len() as f32;
        println!("{width}×{height}, white {}, mean {mean}", chart.full_scale);
        assert!((0.01..0.9).contains(&mean) && values.iter().all(|v| (-0.1..1.3).contains(v)), "mean {mean}");
    } else {
        let error = opened.expect_err("nothing reads it");
        assert!(matches!(error, OpenError::Unsupported { .. }) && error.to_string().contains("raw"), "{error}");
    }
    let error = Burst::open(data.join("raw/openisp_test_1920x1080.raw")).expect_err("no header");
    assert!(matches!(error, OpenError::UnknownKind { .. }), "{error}");
}
