//! Features at the limit of the slopes, and the judgement of the slopes, on bursts of known motion inside, at and beyond
//! the range.

use super::probing::cache;
use super::slopes::{about, applied, asked, uniform};
use burstscope_core::detector::{Detection, DetectorParams, Slope, SlopeGrid, find_slopes};
use burstscope_core::inspect::spectrum::{SlopeJudgement, Spectrum, Subject, judgement};
use burstscope_core::synth::demo_burst;
use burstscope_core::synth::random::Stream;
use burstscope_core::{Burst, Monitor, Plane, detect};

const FRAMES: usize = 8;

/// Line from −1 to 1 px/frame.
fn line() -> SlopeGrid {
    SlopeGrid::line(-1.0..=1.0, 5)
}

fn plane() -> SlopeGrid {
    SlopeGrid::plane(-1.0..=1.0, 5, -1.0..=1.0, 5)
}

fn found(burst: &Burst, slopes: SlopeGrid) -> Detection {
    let params = DetectorParams { slopes, octaves: 2, ..DetectorParams::default() };
    detect(burst, &params, &Monitor::default()).expect("valid")
}

/// The share of the stronger half of the features at the limit, and the number of those on the rim.
fn share(detection: &Detection) -> (f64, usize) {
    let strong = &detection.features[..detection.features.len().div_ceil(2)];
    let at_limit = strong.iter().filter(|f| f.at_slope_limit).count();
    let on_rim = strong.iter().filter(|f| detection.slopes.nearest_on_rim(f.slope)).count();
    (at_limit as f64 / strong.len().max(1) as f64, on_rim)
}

#[test]
fn measure() {
    for (grid, slopes) in [
        (line(), vec![(0.3, 0.0), (0.9, 0.0), (1.0, 0.0), (-1.0, 0.0), (1.2, 0.0), (1.4, 0.0), (1.6, 0.0), (2.0, 0.0), (-2.4, 0.0), (3.0, 0.0), (0.3,1.5)]),
        (plane(), vec![(0.3, -0.4), (1.0, 0.2), (1.0, -1.0), (1.7, 0.1), (0.0, -1.7), (1.6, -1.6), (-2.2, 1.0)]),
    ] {
        for (u, v) in slopes {
            let detection = found(&uniform(Slope::new(u, v), FRAMES), grid);
            let all = detection.features.iter().filter(|f| f.at_slope_limit).count();
            let (part, rim) = share(&detection);
            eprintln!("{u} {v}: {} features, {all} at limit, strong half {part:.3}, on rim {rim}", detection.features.len());
        }
    }
    let mut noise = Stream::new(3, 7);
    let frames = (0..FRAMES).map(|_| Plane::from_fn(320, 240, |_, _| 0.5 + 0.1 * noise.normal() as f32)).collect();
    let noise = Burst::from_planes("noise", frames);
    let params = |slopes| DetectorParams { slopes, noise_gate: burstscope_core::detector::NoiseGate::Factor(3.5), ..DetectorParams::default() };
    for slopes in [line(), plane()] {
        let detection = detect(&noise, &params(slopes), &Monitor::default()).expect("valid");
        let all = detection.features.iter().filter(|f| f.at_slope_limit).count();
        eprintln!("noise: {} features, {all}, {:?}", detection.features.len(), share(&detection));
    }
    let demo = demo_burst();
    let auto = find_slopes(&demo, &DetectorParams::default(), None, &Monitor::default()).expect("f");
    for slopes in [auto.grid, SlopeGrid::line(-1.0..=1.0, 5), SlopeGrid::line(-3.0..=3.0, 7), SlopeGrid::line(-3.0..=3.0, 13), SlopeGrid::plane(-3.0..=3.0, 7, -3.0..=3.0, 7)] {
        let params = DetectorParams { slopes, ..DetectorParams::default() };
        let start = std::time::Instant::now();
        let detection = detect(&demo, &params, &Monitor::default()).expect("valid");
        let secs = start.elapsed().as_secs_f64();
        let start = std::time::Instant::now();
        let finding = find_slopes(&demo, &params, None, &Monitor::default()).expect("f");
        let finder = start.elapsed().as_secs_f64();
        let all = detection.features.iter().filter(|f| f.at_slope_limit).count();
        eprintln!("demo {slopes:?}: {} features, {all}, {:?}; {secs:.2} {:?} finder {finder:.2}", detection.features.len(), share(&detection), detection.times);
        eprintln!("   {:?}", judgement(&detection, &params, Some(&finding), demo.len()));
        eprintln!("   {:?}", judgement(&detection, &params, None, demo.len()).map(|j| j.sentence));
    }
}
