//! Progress and cancellation while the machine is busy with other work.
//!
//! Nothing here measures time: a cancelled search must end long before it is finished, judging by its own progress.

use crate::prelude::*;
use std::sync::{Mutex, OnceLock, atomic::AtomicBool, atomic::Ordering};

fn burst() -> Burst {
    let scene = SceneParams { width: 640, height: 480, snr: 8.0, seed: 7, ..SceneParams::default() };
    synth_scene(&scene, &quiet()).expect("valid parameters").0
}

fn params() -> DetectorParams {
    DetectorParams { slopes: SlopeGrid::plane(-3.0..=3.0, 7, -3.0..=3.0, 7), ..DetectorParams::default() }
}

/// Keeps every processor busy while `work` runs.
fn while_busy<T>(work: impl FnOnce() -> T) -> T {
    let stop = AtomicBool::new(false);
    let threads = std::thread::available_parallelism().map_or(2, usize::from);
    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                let mut x = 1u64;
                while !stop.load(Ordering::Relaxed) {
                    x = std::hint::black_box(x.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1));
                }
            });
        }
        let result = work();
        stop.store(true, Ordering::Relaxed);
        result
    })
}

#[test]
fn progress_runs_from_noise_to_description_and_never_back_by_more_than_threads_overlap() {
    let heard: Arc<Mutex<Vec<Progress>>> = Arc::default();
    let listener = heard.clone();
    let monitor = Monitor::with_listener(move |progress| listener.lock().expect("no panic").push(progress));
    while_busy(|| detect(&burst(), &params(), &monitor)).expect("valid parameters");
    let heard = heard.lock().expect("no panic");
    assert_eq!(heard.first().map(|p| (p.stage, p.fraction)), Some((Stage::Noise, 0.0)));
    assert_eq!(heard.last().map(|p| (p.stage, p.fraction)), Some((Stage::Describe, 1.0)));
    assert!(heard.iter().any(|p| matches!(p.stage, Stage::Search { octave: 2 })));
    let mut max = 0.0f32;
    for progress in heard.iter() {
        assert!(progress.fraction > max - 0.05, "{progress:?} after {max}");
        max = max.max(progress.fraction);
    }
    // Fine enough for a progress bar: no step of more than a tenth of the whole.
    let steps = heard.windows(2).map(|pair| pair[1].fraction - pair[0].fraction);
    assert!(steps.fold(0.0, f32::max) < 0.1);
}

#[test]
fn a_cancel_is_obeyed_while_the_machine_is_busy() {
    let burst = burst();
    for at in [0.0, 0.1, 0.4, 0.7] {
        let heard_after: Arc<Mutex<Vec<f32>>> = Arc::default();
        let own: Arc<OnceLock<Monitor>> = Arc::default();
        let (later, inner) = (heard_after.clone(), own.clone());
        let monitor = Monitor::with_listener(move |progress| {
            let monitor = inner.get().expect("it is set before the work begins");
            if monitor.is_cancelled() {
                later.lock().expect("no panic").push(progress.fraction);
            } else if progress.fraction >= at {
                monitor.cancel();
            }
        });
        own.set(monitor.clone()).expect("set once");
        let result = while_busy(|| detect(&burst, &params(), &monitor));
        assert!(result.is_err_and(|error| error.is_cancelled()), "cancelled at {at}");
        let max = heard_after.lock().expect("no panic").iter().copied().fold(0.0, f32::max);
        assert!(max < at + 0.2, "cancelled at {at}, still working at {max}");
    }
}
