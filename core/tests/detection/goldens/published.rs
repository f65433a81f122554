//! Shared code of the tests of agreement: opening the published input and reading numbers; and a real camera's noise.

use crate::prelude::*;

pub fn open(paths: &[PathBuf]) -> Burst {
    Burst::open_with(paths, &Default::default(), &quiet()).expect("the published input opens")
}

/// The 1D demo in the order in which its motion is uniform.
pub fn demo_1d() -> Burst {
    let folder = shared("data/buff-demo-1d");
    open(&["5.png", "1.png", "2.png", "4.png", "3.png"].map(|name| folder.join(name)))
}

pub fn numbers(line: &str, separator: impl Fn(char) -> bool) -> Vec<f32> {
    line.split(separator).filter(|s| !s.is_empty()).map(|s| s.parse().expect("a number")).collect()
}

/// The published codes' settings wherever our defaults differ, each named: joint extrema, all keypoints kept, described
/// at the grid's slope in one orientation.
pub fn as_published() -> DetectorParams {
    DetectorParams {
        levels: 4,
        peak_threshold: 0.0003,
        noise_gate: NoiseGate::Strict,
        noise_model: NoiseModelKind::White,
        edge_threshold: 10.0,
        slope_extrema: SlopeExtrema::Joint,
        distinct: Distinct::Off,
        max_orientations: 1,
        rules: Rules { describe_slope: DescribeSlope::Grid, ..Rules::default() },
        describe_scales: 1,
        ..DetectorParams::default()
    }
}

// Where no pixel is black, and wherever a band of brightness is taken, second differences of this camera's frames and
// of their differences show a noise of 2.3 to 3.1 grey values; the median over the image is 2.7. Half of each frame is
// black, which must not count.
#[needs::shared("data/slider-far")]
#[test]
fn noise_of_a_real_dim_camera() {
    let burst = open(&[shared("data/slider-far")]);
    let noise = burstscope_core::detector::noise::frame_noise(&burst, 20..29, &quiet()).expect("not cancelled");
    println!("slider-far: noise of a frame {:.2} grey values", 255.0 * noise);
    assert!((255.0 * noise / 2.7 - 1.0).abs() < 0.15, "{}", 255.0 * noise);
}
