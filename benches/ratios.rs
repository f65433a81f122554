//! Ratios that are promised, each measured side by side in one run: how long an answer takes compared with something
//! that everyone knows the cost of.
//!
//! A table comes out, one line a promise: what was measured, the ratio (or the longest time) and the bound. Medians
//! over turns; two threads unless the machine has one.
//!
//!     cargo bench --bench ratios

mod common;

use burstscope::app::gpu::AdapterChoice;
use burstscope::app::offscreen::Offscreen;
use burstscope::app::{BurstscopeApp, Startup};
use burstscope::burst::{Burst, OpenOptions};
use burstscope::detector::view::{dog_view, stack_view};
use burstscope::detector::{DetectorParams, Slope, SlopeGrid, find_slopes};
use burstscope::error::Error;
use burstscope::synth::{demo_burst, demo_truth, write_burst};
use burstscope::{Monitor, Plane, detect};
use rayon::prelude::*;
use std::hint::black_box;
use std::path::PathBuf;
use std::time::{Duration, Instant};

const TURNS: usize = 15;

fn seconds(work: impl FnOnce()) -> f64 {
    let started = Instant::now();
    work();
    started.elapsed().as_secs_f64()
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Median of the ratio of the times of two pieces of work, done in turns.
fn ratio(mut work: impl FnMut(), mut other: impl FnMut()) -> (f64, f64) {
    work();
    other();
    let turns: Vec<(f64, f64)> = (0..TURNS).map(|_| (seconds(&mut work), seconds(&mut other))).collect();
    (median(turns.iter().map(|(a, b)| a / b).collect()), median(turns.iter().map(|(a, _)| *a).collect()))
}

fn row(what: &str, measured: String, bound: &str) {
    println!("| {what:<64} | {measured:>18} | {bound:>10} |");
}

/// The longest of some waits between a cancel and the return of `work`, which is begun anew for each and cancelled at a
/// different moment.
fn longest_wait(whole: f64, work: impl Fn(&Monitor) + Sync) -> f64 {
    const TIMES: u32 = 12;
    (1..=TIMES)
        .map(|i| {
            let monitor = Monitor::default();
            std::thread::scope(|scope| {
                let worker = scope.spawn(|| {
                    work(&monitor);
                    Instant::now()
                });
                std::thread::sleep(Duration::from_secs_f64(whole * f64::from(i) / f64::from(TIMES + 1)));
                let asked = Instant::now();
                monitor.cancel();
                let ended = worker.join().expect("the work does not panic");
                ended.saturating_duration_since(asked).as_secs_f64()
            })
        })
        .fold(0.0, f64::max)
}

fn pictures(burst: &Burst, params: &DetectorParams) {
    let quiet = Monitor::default();
    let mut copies: Vec<Plane> = burst.frames.iter().map(|frame| (**frame).clone()).collect();
    let slope = Slope::new(1.3, -0.7);
    let copy = || {
        // On the same threads as the stack.
        copies.par_iter_mut().zip(&burst.frames).for_each(|(to, from)| to.data_mut().copy_from_slice(from.data()));
        black_box(&copies);
    };
    let stack = || drop(black_box(stack_view(burst, params, slope, &quiet).expect("not cancelled")));
    let (of_copy, secs) = ratio(stack, copy);
    row("a motion-stack image, of copying the burst once", format!("{of_copy:.2} ({:.1} ms)", secs * 1e3), "3");
    for (octave, level) in [(0, 0), (0, 2), (2, 1)] {
        let dog = || drop(black_box(dog_view(burst, params, slope, octave, level, &quiet).expect("not cancelled")));
        let (of_stack, secs) = ratio(dog, stack);
        row(
            &format!("a DoG picture, octave {octave} level {level}, of the motion-stack image"),
            format!("{of_stack:.2} ({:.1} ms)", secs * 1e3),
            "3",
        );
    }
}

fn finding_slopes(burst: &Burst) {
    let (quiet, params) =
        (Monitor::default(), DetectorParams { levels: 3, max_features: 3000, ..DetectorParams::default() });
    let find = || drop(black_box(find_slopes(burst, &params, None, &quiet).expect("not cancelled")));
    let search = || drop(black_box(detect(burst, &params, &quiet).expect("valid parameters")));
    let (of_search, secs) = ratio(find, search);
    row("finding the slopes, of a detection over 7 slopes", format!("{of_search:.2} ({:.0} ms)", secs * 1e3), "0.25");
    let wait = longest_wait(secs, |monitor| drop(find_slopes(burst, &params, None, monitor)));
    row("cancelling it: longest wait", format!("{:.1} ms", wait * 1e3), "50 ms");
}

fn opening(burst: &Burst) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let files: Vec<PathBuf> = (0..burst.len()).map(|t| folder.path().join(format!("frame_{t}.png"))).collect();
    for (file, frame) in files.iter().zip(&burst.frames) {
        let values: Vec<u16> = frame.data().iter().map(|x| (x * 65535.0).round() as u16).collect();
        image::ImageBuffer::<image::Luma<u16>, _>::from_raw(frame.width() as u32, frame.height() as u32, values)
            .expect("one value a pixel")
            .save(file)
            .expect("the picture can be written");
    }
    let decode = || {
        files.par_iter().for_each(|file| drop(black_box(image::open(file).expect("a picture").into_luma16())));
    };
    let open = || {
        let opened = Burst::open_with(&files, &OpenOptions::default(), &Monitor::default());
        drop(black_box(opened.expect("the burst opens")));
    };
    let (of_decoding, secs) = ratio(open, decode);
    row("opening 10 PNG of 16 bit, of decoding them", format!("{of_decoding:.2} ({:.0} ms)", secs * 1e3), "1.3");
    let wait = longest_wait(secs, |monitor| drop(Burst::open_with(&files, &OpenOptions::default(), monitor)));
    row("cancelling the opening: longest wait", format!("{:.1} ms", wait * 1e3), "50 ms");
}

fn cancelling(burst: &Burst) {
    let line = DetectorParams { octaves: 16, levels: 3, peak_threshold: 0.001, ..DetectorParams::default() };
    let plane = DetectorParams { slopes: SlopeGrid::plane(-3.0..=3.0, 7, -3.0..=3.0, 7), ..line.clone() };
    for (name, params) in [("1D", line), ("2D", plane)] {
        let whole = seconds(|| drop(detect(burst, &params, &Monitor::default())));
        let wait = longest_wait(whole, |monitor| drop(detect(burst, &params, monitor)));
        row(&format!("cancelling a {name} detection: longest wait"), format!("{:.1} ms", wait * 1e3), "50 ms");
    }
    let params = DetectorParams::default();
    let view = |monitor: &Monitor| drop(dog_view(burst, &params, Slope::new(1.3, 0.4), 4, 1, monitor));
    let whole = seconds(|| view(&Monitor::default()));
    row("cancelling a DoG picture: longest wait", format!("{:.1} ms", longest_wait(whole, view) * 1e3), "50 ms");
    let whole = seconds(|| drop(demo_burst()));
    row("making the demo burst", format!("{:.0} ms", whole * 1e3), "");
    let (demo, truth) = (demo_burst(), demo_truth());
    let write = |monitor: &Monitor| {
        let folder = tempfile::tempdir().expect("a temporary folder");
        drop(write_burst(folder.path(), &demo, &truth, monitor));
    };
    let whole = seconds(|| write(&Monitor::default()));
    row(
        "cancelling the writing of a burst: longest wait",
        format!("{:.1} ms", longest_wait(whole, write) * 1e3),
        "50 ms",
    );
}

/// From the creation of a window on the demo to its first picture, drawn and read back. Opening the graphics driver is
/// not counted; without a card it is a software driver that draws.
fn first_picture() {
    let time = || -> Result<f64, Error> {
        let mut offscreen = Offscreen::new(egui::vec2(1280.0, 800.0), 1.0, AdapterChoice::Fastest)?;
        let started = Instant::now();
        let mut app = BurstscopeApp::new(&offscreen.context, None, Startup::default());
        while app.read().picture().is_none() {
            assert!(started.elapsed() < Duration::from_secs(30), "no picture came");
            offscreen.frame(Vec::new(), |ui| app.show(ui));
            std::thread::sleep(Duration::from_millis(1));
        }
        offscreen.frame(Vec::new(), |ui| app.show(ui));
        offscreen.image()?;
        Ok(started.elapsed().as_secs_f64())
    };
    let measured = match (0..5).map(|_| time()).collect::<Result<Vec<_>, _>>() {
        Ok(times) => format!("{:.0} ms", median(times) * 1e3),
        Err(error) => format!("not measured: {error}"),
    };
    row("from the window to the demo's first picture", measured, "500 ms");
}

/// Resident memory of this process, MB; `None` where the system does not tell.
fn resident_mb() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let kilobytes = status.lines().find_map(|line| line.strip_prefix("VmRSS:"))?.split_whitespace().next()?;
    kilobytes.parse::<u64>().ok().map(|kilobytes| kilobytes >> 10)
}

/// Resident memory that zooming in a window on the demo adds; a driver's is in it.
fn zooming() {
    let grown = || -> Result<Option<[u64; 2]>, Error> {
        let mut offscreen = Offscreen::new(egui::vec2(1280.0, 800.0), 1.0, AdapterChoice::Fastest)?;
        let mut app = BurstscopeApp::new(&offscreen.context, None, Startup::default());
        while !app.is_settled() {
            offscreen.frame(Vec::new(), |ui| app.show(ui));
            std::thread::sleep(Duration::from_millis(1));
        }
        let mut zoom = |times: u32| -> Result<Option<u64>, Error> {
            for i in 0..times {
                let (unit, phase, modifiers) = (egui::MouseWheelUnit::Line, egui::TouchPhase::Move, Default::default());
                let (source, way) = (egui::MouseWheelSource::Wheel, if i / 20 % 2 == 0 { 0.37 } else { -0.37 });
                let wheel = egui::Event::MouseWheel { unit, delta: egui::vec2(0.0, way), modifiers, phase, source };
                let place = egui::Event::PointerMoved(egui::pos2(800.0 + i as f32 % 37.0, 400.0));
                offscreen.frame(vec![place, wheel], |ui| app.show(ui));
                offscreen.image()?;
            }
            Ok(resident_mb())
        };
        Ok(zoom(40)?.zip(zoom(400)?).map(|(before, after)| [before, after]))
    };
    let measured = match grown() {
        Ok(Some([before, after])) => format!("{before} -> {after} MB"),
        Ok(None) => "not measured".to_owned(),
        Err(error) => format!("not measured: {error}"),
    };
    row("resident memory before and after 400 zooms on the demo", measured, "+96 MB");
}

fn main() {
    let threads = std::thread::available_parallelism().map_or(1, usize::from).min(2);
    rayon::ThreadPoolBuilder::new().num_threads(threads).build_global().expect("the pool is built once");
    let burst = common::burst(1600, 1200);
    println!("10 frames of 1600x1200, {threads} threads, medians of {TURNS} turns");
    row("what", "measured".into(), "at most");
    println!("| --- | --- | --- |");
    pictures(&burst, &DetectorParams { levels: 3, ..DetectorParams::default() });
    finding_slopes(&burst);
    opening(&burst);
    cancelling(&burst);
    first_picture();
    zooming();
}
