//! A window on a burst without noise, with features that no detector found: for tests of panels, whose pictures change
//! only when the panel does.

use crate::support::*;
use burstscope::{burst::Positions, detector::noise_model::NoiseModel};

const SIZE: (usize, usize) = (480, 360);
const FRAMES: usize = 9;

/// A disc: column and row in the middle of the burst, radius, pixels; motion along u, pixels per frame.
const DISCS: [[f32; 4]; 4] =
    [[120.0, 100.0, 12.0, -2.0], [310.0, 130.0, 24.0, 1.0], [190.0, 260.0, 36.0, 0.0], [400.0, 270.0, 8.0, 2.0]];

fn discs() -> OpenBurst {
    let frame = |t: usize| {
        Plane::from_fn(SIZE.0, SIZE.1, |x, y| {
            let since_middle = t as f32 - (FRAMES - 1) as f32 / 2.0;
            let light = DISCS.map(|[u, v, radius, slope]| {
                let distance = (x as f32 - u - slope * since_middle).hypot(y as f32 - v);
                (radius + 0.5 - distance).clamp(0.0, 1.0)
            });
            0.2 + 0.5 * light.iter().sum::<f32>()
        })
    };
    let burst = Burst::from_planes("discs", (0..FRAMES).map(frame).collect());
    OpenBurst::new(burst, BurstSource::Paths(vec!["discs".into()]))
}

pub fn open(size: [f32; 2]) -> Window {
    open_with(Start { size, ..Start::default() })
}

pub fn open_with(start: Start) -> Window {
    let settings = Settings { auto_detect: false, ..start.startup.settings };
    let startup = Startup { source: None, settings, ..start.startup };
    let mut window = Start { startup, ..start }.open();
    apply::opening::take_burst(&mut window.app_mut().model, discs());
    window.settle();
    window
}

pub fn at_slopes(size: [f32; 2], slopes: SlopeGrid) -> Start {
    let mut startup = given();
    startup.params.slopes = slopes.into();
    Start { size, startup, ..Start::default() }
}

/// The window with a feature on each disc, and their tally: the table and the panel of a selected feature also tell
/// verdicts, which are those of a search.
pub fn with_features(mut window: Window) -> Window {
    let model = &mut window.app_mut().model;
    let asked = Read::of(model).asked();
    let slopes: Vec<Slope> = asked.at_given().slopes.slopes().collect();
    let features = DISCS.iter().enumerate().map(|(i, &[u, v, radius, slope])| Feature {
        u,
        v,
        sigma: radius / std::f32::consts::SQRT_2,
        orientation: i as f32,
        slope: Slope::new(slope, 0.0),
        response: -0.06 + 0.01 * i as f32,
        snr: 60.0 - 10.0 * i as f32,
        octave: i as i32 / 2,
        level: 1 + i as i32 % 3,
        slope_index: slopes.iter().position(|s| *s == Slope::new(slope, 0.0)).expect("a slope of the grid"),
        slope_sigma: 0.05,
        field: Slope::new(slope, 0.0),
        field_sigma: 0.04,
        layer: 1,
        ..Feature::default()
    });
    let detection = Arc::new(Detection {
        features: features.collect(),
        descriptors: (0..DISCS.len()).map(|i| std::array::from_fn(|k| (k * (i + 3) % 97) as u8)).collect(),
        tally: Tally {
            samples: 2_000_000,
            rejected: Test::ALL.map(|test| match test {
                // Nothing is masked.
                Test::Seen => 0,
                test => 1000 * (test as u64 + u64::from(test < Test::Seen)),
            }),
            kept: 4,
            ..Tally::default()
        },
        frame_noise: 0.004,
        noise: Arc::new(NoiseModel::white(0.004)),
        field: None,
        noise_gate_factor: 5.0,
        slopes: asked.at_given().slopes,
        frames_used: 0..FRAMES,
        positions: Positions::even(FRAMES),
        octaves: 0..5,
        times: Default::default(),
    });
    let burst = Read::of(model).burst_of(Side::A).expect("it is open").id;
    let (params, searched) = (asked.at_given(), asked.at_given());
    let detected =
        Detected { burst, asked, params, searched, search_secs: 0.1, finding: None, detection, judgement: None };
    model.document.bottom_tab = BottomTab::Tally;
    apply::detection::take_detection(model, Side::A, detected, Duration::from_millis(120));
    window.settle();
    window
}
