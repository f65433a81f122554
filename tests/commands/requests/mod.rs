//! Tests of requests: when two are the same, that the answer is the library's, and how a request ends.

mod datasets;
mod ending;
mod film;
mod sameness;

use crate::support::*;
use burstscope::requests::{Detected, DetectionSource};

fn chart(seed: u64) -> ChartParams {
    let radius = 3.0..=6.0;
    ChartParams { width: 96, height: 72, frames: 4, discs: 4, radius, snr: 20.0, seed, ..ChartParams::default() }
}

fn params() -> DetectorParams {
    DetectorParams { slopes: SlopeGrid::line(-1.0..=1.0, 3), octaves: 2, ..DetectorParams::default() }
}

fn open() -> OpenBurst {
    static OPEN: OnceLock<OpenBurst> = OnceLock::new();
    let source = || BurstSource::Chart(Box::new(chart(1)));
    OPEN.get_or_init(|| source().open(&OpenOptions::default(), &Monitor::default()).expect("a chart")).clone()
}

fn empty(size: (usize, usize), frames: usize) -> OpenBurst {
    let planes = (0..frames).map(|_| Plane::zeros(size.0, size.1)).collect();
    OpenBurst::new(Burst::from_planes("empty", planes), BurstSource::Demo)
}

fn detected() -> Detected {
    static DETECTED: OnceLock<Detected> = OnceLock::new();
    let find = || answer(DetectRequest { burst: open(), params: params().into() }).expect("valid parameters");
    DETECTED.get_or_init(find).clone()
}

fn source() -> DetectionSource {
    DetectionSource { burst: open(), asked: params().into(), params: params(), finding: None }
}

fn answer<R: Request>(request: R) -> Result<R::Answer, JobError> {
    request.compute(&Work::alone(&Monitor::default()))
}

fn write_chart(folder: &Path, seed: u64) {
    let monitor = Monitor::default();
    let (burst, truth) = burstscope::synth::synth_chart(&chart(seed), &monitor).expect("valid parameters");
    burstscope::synth::write_burst(folder, &burst, &truth, &monitor).expect("written");
}
