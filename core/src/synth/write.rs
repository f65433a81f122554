//! Writing a synthetic burst: 16-bit PNG frames and `truth.json`, as a complete folder or not at all.
//!
//! Values of a converter with fewer than 16 bits are stored at the top of the 16-bit word (see [`super::noise`]), so
//! that the files hold them exactly; values that were never rounded are rounded to 16 bits.

use super::folder::{WriteBurstError, io, write_folder};
use super::noise::quantised_word;
use super::truth::Truth;
use crate::burst::Burst;
use crate::monitor::{Monitor, Stage};
use crate::plane::Plane;
use image::ImageFormat;
use std::io::Cursor;
use std::path::Path;

/// Writes `burst` as `frame_000.png` … and `truth` as `truth.json` into the folder `dir`, which is created. An earlier
/// synthetic burst in it is replaced as a whole; a folder that holds anything else is left unchanged.
///
/// # Errors
/// See [`WriteBurstError`]; the folder is then unchanged.
pub fn write_burst(dir: &Path, burst: &Burst, truth: &Truth, monitor: &Monitor) -> Result<(), WriteBurstError> {
    write_folder(dir, replaceable, |fresh| {
        for (t, frame) in burst.frames.iter().enumerate() {
            monitor.check()?;
            write_frame(&fresh.join(frame_name(t)), frame)?;
            monitor.report(Stage::Write, (t + 1) as f32 / burst.len() as f32);
        }
        let path = fresh.join("truth.json");
        let text = serde_json::to_string_pretty(truth).map_err(std::io::Error::other).map_err(io(&path))?;
        std::fs::write(&path, text + "\n").map_err(io(&path))?;
        Ok(monitor.check()?)
    })
}

/// Writes one frame as 16-bit PNG.
pub(super) fn write_frame(path: &Path, frame: &Plane) -> Result<(), WriteBurstError> {
    let words: Vec<u16> = frame.data().iter().map(|&x| quantised_word(f64::from(x), 16)).collect();
    let picture =
        image::ImageBuffer::<image::Luma<u16>, _>::from_raw(frame.width() as u32, frame.height() as u32, words)
            .expect("a plane has width × height values");
    // Through memory: a buffered file that the encoder closes would silently lose its last bytes where the disk is
    // full.
    let mut png = Cursor::new(Vec::new());
    picture.write_to(&mut png, ImageFormat::Png).map_err(|e| std::io::Error::other(e.to_string())).map_err(io(path))?;
    std::fs::write(path, png.into_inner()).map_err(io(path))
}

/// The file name of frame `t`.
pub fn frame_name(t: usize) -> String {
    format!("frame_{t:03}.png")
}

/// Whether `dir` holds only files that [`write_burst`] writes.
fn replaceable(dir: &Path) -> std::io::Result<bool> {
    let mut has_truth = false;
    for entry in std::fs::read_dir(dir)? {
        let entry = entry?;
        let name = entry.file_name();
        let name = name.to_string_lossy();
        let number = name.strip_prefix("frame_").and_then(|rest| rest.strip_suffix(".png"));
        let is_frame = number.is_some_and(|n| !n.is_empty() && n.bytes().all(|b| b.is_ascii_digit()));
        has_truth |= name == "truth.json";
        if !(is_frame || name == "truth.json") || entry.file_type()?.is_dir() {
            return Ok(false);
        }
    }
    Ok(has_truth)
}

#[cfg(test)]
mod tests {
    use super::super::{ChartParams, synth_chart};
    use super::*;

    fn chart(seed: u64, frames: usize) -> (Burst, Truth) {
        let params = ChartParams { width: 64, height: 48, discs: 2, frames, seed, ..ChartParams::default() };
        let params = ChartParams { radius: 3.0..=5.0, max_slope: 1.0, ..params };
        synth_chart(&params, &Monitor::default()).expect("a chart")
    }

    #[test]
    fn files_hold_every_value_and_the_truth_exactly() {
        let home = tempfile::tempdir().expect("a folder");
        let dir = home.path().join("deep").join("chart");
        let (burst, truth) = chart(1, 3);
        write_burst(&dir, &burst, &truth, &Monitor::default()).expect("written");
        for (t, frame) in burst.frames.iter().enumerate() {
            let picture = image::open(dir.join(frame_name(t))).expect("a picture").into_luma16();
            let read: Vec<f32> = picture.as_raw().iter().map(|&x| f32::from(x) / 65535.0).collect();
            assert_eq!(read, frame.data());
        }
        let text = std::fs::read_to_string(dir.join("truth.json")).expect("a file");
        // Numbers have all their digits (the JSON reader may be off by the last one).
        assert_eq!(text.trim_end(), serde_json::to_string_pretty(&truth).expect("valid"));
        assert_eq!(serde_json::from_str::<Truth>(&text).expect("valid").features.len(), truth.features.len());
        assert_eq!(std::fs::read_dir(dir.parent().expect("it has one")).expect("a folder").count(), 1, "no leftovers");
    }

    #[test]
    fn an_earlier_burst_is_replaced_whole_and_other_files_are_left_alone() {
        let home = tempfile::tempdir().expect("a folder");
        let dir = home.path().join("chart");
        let (long, truth) = chart(1, 5);
        write_burst(&dir, &long, &truth, &Monitor::default()).expect("written");
        let (short, truth) = chart(2, 3);
        write_burst(&dir, &short, &truth, &Monitor::default()).expect("replaced");
        assert_eq!(std::fs::read_dir(&dir).expect("a folder").count(), 4);
        std::fs::write(dir.join("thesis.txt"), "precious").expect("written");
        let error = write_burst(&dir, &long, &truth, &Monitor::default()).expect_err("occupied").to_string();
        assert!(error.contains("chart"), "{error}");
        assert_eq!(std::fs::read_dir(&dir).expect("a folder").count(), 5);
        // Pictures without a truth beside them belong to somebody else.
        let own = home.path().join("own");
        std::fs::create_dir(&own).expect("made");
        std::fs::write(own.join("frame_000.png"), "mine").expect("written");
        assert!(write_burst(&own, &long, &truth, &Monitor::default()).is_err());
    }

    #[test]
    fn cancelling_or_failing_leaves_nothing() {
        let home = tempfile::tempdir().expect("a folder");
        let monitor = Monitor::default();
        let (burst, truth) = chart(1, 3);
        monitor.cancel();
        let result = write_burst(&home.path().join("chart"), &burst, &truth, &monitor);
        assert!(matches!(result, Err(WriteBurstError::Cancelled(_))));
        let file = home.path().join("file");
        std::fs::write(&file, "").expect("written");
        assert!(write_burst(&file.join("chart"), &burst, &truth, &Monitor::default()).is_err());
        assert_eq!(std::fs::read_dir(home.path()).expect("a folder").count(), 1);
    }
}
