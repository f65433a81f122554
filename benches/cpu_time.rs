//! CPU time, wall time and memory of whole detections, as the operating system counts them, on request: the partner of
//! `versus_opencv.py`, which asks for runs in turns with another program's, so that both see the same machine.
//!
//! Writes the middle frames of its scene and of its burst by day as 8-bit PNG files `scene.png` and `day.png` to the
//! folder given as the first argument, then reads commands from standard input, one a line: `METHOD THREADS
//! [PEAK_THRESHOLD]`, with METHOD one of `1d`, `2d`, `2d-field`, `1d-doubled`, `sift` on the scene, or `1d-day`,
//! `2d-day`, `2d-day-field`: the defaults by day, the 3000 strongest kept. Those with `field` search around the field
//! of motion. Answers each with a line of `METHOD features cpu_secs wall_secs peak_bytes_over_burst`. The burst by day
//! is made of a picture of `../shared` (or `BURSTSCOPE_SHARED`); without it there is none.

mod common;

use burstscope::detector::{DetectorParams, Method, SearchSlopes, SlopeGrid};
use burstscope::plane::statistics::{Region, summary};
use burstscope::{Burst, Monitor, detect};
use std::io::BufRead;
use std::path::Path;

fn params(method: &str, peak_threshold: f32) -> Option<DetectorParams> {
    if let Some(method) = method.strip_suffix("-field") {
        return params(method, peak_threshold).map(|all| DetectorParams { search: SearchSlopes::Field, ..all });
    }
    let base = DetectorParams { octaves: 16, levels: 3, peak_threshold, ..DetectorParams::default() };
    Some(match method {
        "1d" => base,
        "1d-doubled" => DetectorParams { first_octave: -1, ..base },
        "2d" => DetectorParams { slopes: SlopeGrid::plane(-3.0..=3.0, 7, -3.0..=3.0, 7), ..base },
        "sift" => DetectorParams { method: Method::Sift, ..base },
        "1d-day" => by_day(SlopeGrid::line(-3.0..=3.0, 7)),
        "2d-day" => by_day(SlopeGrid::plane(-3.0..=3.0, 7, -3.0..=3.0, 7)),
        _ => return None,
    })
}

/// The defaults, but for what `versus_opencv.py` says.
fn by_day(slopes: SlopeGrid) -> DetectorParams {
    DetectorParams { slopes, levels: 3, max_features: 3000, ..DetectorParams::default() }
}

/// Writes the middle frame of a burst as an 8-bit PNG.
fn write_middle(burst: &Burst, path: &Path) {
    let frame = &burst.frames[burst.len() / 2];
    let range = summary(frame, &Region::whole(frame));
    let byte = |x: f32| ((x - range.min) / (range.max - range.min) * 255.0).round() as u8;
    let bytes = frame.data().iter().map(|&x| byte(x)).collect();
    image::GrayImage::from_raw(frame.width() as u32, frame.height() as u32, bytes)
        .expect("one byte a pixel")
        .save(path)
        .expect("the picture can be written");
}

/// A number of kB from `/proc/self/status`; 0 where there is none.
fn status_bytes(field: &str) -> u64 {
    let text = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = text.lines().find(|l| l.starts_with(field)).unwrap_or_default();
    line.split_whitespace().nth(1).and_then(|n| n.parse::<u64>().ok()).unwrap_or(0) * 1024
}

fn main() {
    let mut arguments = std::env::args().skip(1).filter(|a| a != "--bench");
    let burst = common::burst(1600, 1200);
    let day = common::by_day((1, 0)).zip(common::by_day((1, 1)));
    if let Some(folder) = arguments.next() {
        write_middle(&burst, &Path::new(&folder).join("scene.png"));
        if let Some((along_u, _)) = &day {
            write_middle(along_u, &Path::new(&folder).join("day.png"));
        }
    }
    println!("ready");
    for line in std::io::stdin().lock().lines() {
        let line = line.expect("text");
        let words: Vec<&str> = line.split_whitespace().collect();
        let (Some(method), Some(threads)) = (words.first(), words.get(1).and_then(|n| n.parse().ok())) else { break };
        let peak = words.get(2).and_then(|n| n.parse().ok()).unwrap_or(0.0003);
        let Some(params) = params(method, peak) else { break };
        let burst = match (*method, &day) {
            ("1d-day", Some((along_u, _))) => along_u,
            ("2d-day" | "2d-day-field", Some((_, along_both))) => along_both,
            (day, None) if day.contains("-day") => break,
            _ => &burst,
        };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        // Forget the peak so far, where the system allows it.
        let _ = std::fs::write("/proc/self/clear_refs", "5");
        let before = status_bytes("VmRSS");
        let (cpu, wall) = (cpu_time::ProcessTime::now(), std::time::Instant::now());
        let found = pool.install(|| detect(burst, &params, &Monitor::default())).expect("valid parameters");
        let (cpu, wall) = (cpu.elapsed().as_secs_f64(), wall.elapsed().as_secs_f64());
        let peak = status_bytes("VmHWM").saturating_sub(before);
        let t = found.times;
        eprintln!("noise {:.3} search {:.3} describe {:.3}", t.noise_secs, t.search_secs, t.describe_secs);
        println!("{method} {} {cpu:.4} {wall:.4} {peak}", found.features.len());
    }
}
