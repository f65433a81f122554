//! Writing a synthetic burst: 16-bit PNG frames and `truth.json`, as a complete folder or not at all.
//!
//! Values of a converter with fewer than 16 bits are stored at the top of the 16-bit word (see [`super::noise`]), so
//! that the files hold them exactly; values that were never rounded are rounded to 16 bits.
//!
//! Everything goes into a hidden folder beside the target, which then replaces the target. A killed run leaves its
//! hidden folder; the next one that writes there removes it. A system lock on a file in it, which ends with its
//! process, shows that it is still in use. Another lock, beside the target, keeps two processes from making the same
//! folder.

use super::noise::quantised_word;
use super::truth::Truth;
use crate::burst::Burst;
use crate::files::lock::{FolderLock, LockError, is_free};
use crate::files::write_problem;
use crate::monitor::{Cancelled, Monitor, Stage};
use crate::plane::Plane;
use image::ImageFormat;
use std::fs::{File, OpenOptions};
use std::io::{Cursor, Write};
use std::path::{Path, PathBuf};

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

/// Reason why a burst was not written.
#[derive(Debug, thiserror::Error)]
pub enum WriteBurstError {
    /// The folder holds files that are no earlier synthetic burst.
    #[error("the folder holds files that are not a synthetic burst; name a new or an empty folder: {}", .0.display())]
    Occupied(PathBuf),
    /// Writing failed.
    #[error("cannot write: {}: {}", write_problem(.source), .path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
    /// The folder's name is that of a link, which the new folder would replace.
    #[error("this is a link, and links are not followed; name the folder itself: {}", .0.display())]
    Link(PathBuf),
    /// Another process makes the folder.
    #[error(transparent)]
    Lock(#[from] LockError),
    /// The work was cancelled; nothing was written.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// Converter of a failure at `path` into an error.
pub(super) fn io(path: &Path) -> impl Fn(std::io::Error) -> WriteBurstError + use<> {
    let path = path.to_owned();
    move |source| WriteBurstError::Io { path: path.clone(), source }
}

/// Makes the folder `dir` by `fill`, which writes into the empty folder that it is given. An existing `dir` is replaced
/// as a whole if `replaceable` returns true (an empty folder always is), and otherwise left unchanged. Meanwhile no
/// other process can make it.
///
/// # Errors
/// See [`WriteBurstError`]; the folder is then unchanged.
pub(super) fn write_folder(
    dir: &Path,
    replaceable: impl FnOnce(&Path) -> std::io::Result<bool>,
    fill: impl FnOnce(&Path) -> Result<(), WriteBurstError>,
) -> Result<(), WriteBurstError> {
    if std::fs::symlink_metadata(dir).is_ok_and(|metadata| metadata.is_symlink()) {
        return Err(WriteBurstError::Link(dir.to_owned()));
    }
    let _lock = FolderLock::beside(dir)?;
    if !is_free(dir).map_err(io(dir))? && !replaceable(dir).map_err(io(dir))? {
        return Err(WriteBurstError::Occupied(dir.to_owned()));
    }
    let parent = match dir.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.to_owned(),
        _ => PathBuf::from("."),
    };
    remove_abandoned(&parent);
    let stage = tempfile::Builder::new().prefix(STAGE_PREFIX).tempdir_in(&parent).map_err(io(&parent))?;
    let _in_use = locked(&stage.path().join(LOCK_FILE), dir).map_err(io(stage.path()))?;
    let fresh = stage.path().join("new");
    std::fs::create_dir(&fresh).map_err(io(&fresh))?;
    fill(&fresh)?;
    let old = stage.path().join("old");
    if dir.exists() {
        std::fs::rename(dir, &old).map_err(io(dir))?;
    }
    if let Err(source) = std::fs::rename(&fresh, dir) {
        if old.exists() {
            std::fs::rename(&old, dir).map_err(io(dir))?;
        }
        return Err(WriteBurstError::Io { path: dir.to_owned(), source });
    }
    Ok(())
}

const STAGE_PREFIX: &str = ".synth-";
/// File in a hidden folder whose lock shows that it is in use; its text is the name of the folder that is made.
const LOCK_FILE: &str = "in-use";

fn locked(path: &Path, target: &Path) -> std::io::Result<File> {
    let file = File::create_new(path)?;
    // A file system without locks: then nothing is removed either.
    let _ = file.try_lock();
    let name = target.file_name().unwrap_or_default();
    (&file).write_all(name.as_encoded_bytes())?;
    Ok(file)
}

/// Removes the hidden folders in `parent` that killed runs have left. If a run was killed between moving the old folder
/// away and putting the new one there, the new one, which was complete by then, is moved to its place.
fn remove_abandoned(parent: &Path) {
    for entry in std::fs::read_dir(parent).into_iter().flatten().flatten() {
        let stage = entry.path();
        let is_stage = entry.file_name().to_str().is_some_and(|name| name.starts_with(STAGE_PREFIX));
        if !is_stage {
            continue;
        }
        let Ok(lock) = OpenOptions::new().write(true).open(stage.join(LOCK_FILE)) else { continue };
        if lock.try_lock().is_err() {
            continue;
        }
        if stage.join("old").exists()
            && let Ok(name) = std::fs::read_to_string(stage.join(LOCK_FILE))
            && !name.is_empty()
            && !parent.join(&name).exists()
            && std::fs::rename(stage.join("new"), parent.join(&name)).is_err()
        {
            continue;
        }
        // A folder that cannot be removed does no harm.
        let _ = std::fs::remove_dir_all(&stage);
    }
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

    /// Creates a hidden folder as a killed run leaves it.
    fn left(parent: &Path, name: &str, target: &str, parts: &[&str]) -> PathBuf {
        let stage = parent.join(name);
        std::fs::create_dir(&stage).expect("made");
        drop(locked(&stage.join(LOCK_FILE), Path::new(target)).expect("locked"));
        for part in parts {
            std::fs::create_dir(stage.join(part)).expect("made");
            std::fs::write(stage.join(part).join("truth.json"), part).expect("written");
        }
        stage
    }

    #[test]
    fn what_killed_runs_left_is_removed_and_what_is_in_use_stays() {
        let home = tempfile::tempdir().expect("a folder");
        let begun = left(home.path(), ".synth-a", "a", &["new"]);
        let replaced = left(home.path(), ".synth-b", "b", &["new", "old"]);
        let used = left(home.path(), ".synth-c", "c", &["new"]);
        let lock = OpenOptions::new().write(true).open(used.join(LOCK_FILE)).expect("there");
        lock.try_lock().expect("free");
        std::fs::create_dir(home.path().join(".synth-own")).expect("made");
        write_folder(&home.path().join("d"), |_| Ok(false), |_| Ok(())).expect("written");
        assert!(!begun.exists() && !replaced.exists() && used.exists() && home.path().join(".synth-own").exists());
        assert!(!home.path().join("a").exists() && home.path().join("d").is_dir());
        assert_eq!(std::fs::read_to_string(home.path().join("b/truth.json")).expect("put there"), "new");
    }
}
