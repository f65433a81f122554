//! Writing a synthetic burst: 16-bit PNG frames and `truth.json`, as a complete folder or not at all.
//!
//! Values of a converter with fewer than 16 bits are stored at the top of the 16-bit word (see [`super::noise`]), so
//! that the files hold them exactly; values that were never rounded are rounded to 16 bits.
//!
//! Everything goes into a hidden folder beside the target ([`Unfinished`]), which then replaces the target. A lock
//! beside the target keeps two processes from making the same folder. The mark of the folder claims all of its files:
//! one to which anything was added, or in which anything was changed, is not replaced.

use burstscope_core::error::{Error, ErrorKind, Result};
use burstscope_core::files::mark::{OutputKind, is_unchanged, seal_folder};
use burstscope_core::files::unfinished::{Unfinished, is_free};
use burstscope_core::files::{lock::FolderLock, write_problem};
use burstscope_core::monitor::{Monitor, Stage};
use burstscope_core::synth::{noise::quantised_word, truth::Truth};
use burstscope_core::{burst::Burst, plane::Plane};
use image::ImageFormat;
use serde::Serialize;
use std::{io::Cursor, path::Path};

/// Writes `burst` as `frame_000.png` …, a light field as `view_00_00.png` …, its mask as `masks/mask.png`, and `truth`
/// as `truth.json` into the folder `dir`, which is created. An earlier synthetic burst in it is replaced as a whole; a
/// folder that holds anything else is left unchanged.
///
/// # Errors
/// The folder is a link, holds other files or cannot be written; it is then unchanged.
pub fn write_burst(dir: &Path, burst: &Burst, truth: &Truth, monitor: &Monitor) -> Result<()> {
    write_folder(dir, OutputKind::Burst, |fresh| {
        let grid = burst.positions.rows_and_columns();
        for (t, frame) in burst.frames.iter().enumerate() {
            monitor.check()?;
            // A view has its row and column in its name, as LFToolbox names views.
            let view = grid.map(|(_, columns)| format!("view_{:02}_{:02}.png", t / columns, t % columns));
            write_frame(&fresh.join(view.unwrap_or_else(|| frame_name(t))), frame)?;
            monitor.report(Stage::Write, (t + 1) as f32 / burst.len() as f32);
        }
        // Evenly spaced frames need no table of times: their order says it all.
        if !burst.positions.is_even() && !burst.positions.are_views() {
            let rows = burst.positions.since_first().into_iter().enumerate();
            let rows: String = rows.map(|(t, position)| format!("{},{position}\n", frame_name(t))).collect();
            write_file(&fresh.join("times.csv"), format!("name,frames\n{rows}"))?;
        }
        if let Some(mask) = truth.mask() {
            std::fs::create_dir(fresh.join("masks")).map_err(io(fresh))?;
            write_frame(&fresh.join("masks/mask.png"), mask.weights())?;
        }
        write_json(&fresh.join("truth.json"), truth)?;
        Ok(monitor.check()?)
    })
}

pub(super) fn write_file(path: &Path, content: impl AsRef<[u8]>) -> Result<()> {
    std::fs::write(path, content).map_err(io(path))
}

pub(super) fn write_json(path: &Path, value: &impl Serialize) -> Result<()> {
    let text = serde_json::to_string_pretty(value).map_err(std::io::Error::other).map_err(io(path))?;
    write_file(path, text + "\n")
}

pub(super) fn write_frame(path: &Path, frame: &Plane) -> Result<()> {
    let words: Vec<u16> = frame.data().iter().map(|&x| quantised_word(f64::from(x), 16)).collect();
    let picture =
        image::ImageBuffer::<image::Luma<u16>, _>::from_raw(frame.width() as u32, frame.height() as u32, words)
            .expect("a plane has width × height values");
    // Through memory: a buffered file that the encoder closes would silently lose its last bytes on a full disk.
    let mut png = Cursor::new(Vec::new());
    picture.write_to(&mut png, ImageFormat::Png).map_err(|e| std::io::Error::other(e.to_string())).map_err(io(path))?;
    write_file(path, png.into_inner())
}

/// The file name of frame `t`.
pub fn frame_name(t: usize) -> String {
    format!("frame_{t:03}.png")
}

pub(super) fn io(path: &Path) -> impl Fn(std::io::Error) -> Error + use<> {
    let path = path.to_owned();
    move |error| Error::new(ErrorKind::Unwritten, format!("cannot write: {}", write_problem(&error)), "").about(&path)
}

pub(super) fn occupied(dir: &Path) -> Error {
    let problem = "the folder holds files that this command did not write there, or that were changed since";
    Error::new(ErrorKind::InTheWay, problem, "name a new or an empty folder").about(dir)
}

/// Makes the folder `dir` by `fill`, which writes into the empty folder that it is given. An existing `dir` is replaced
/// as a whole if it has an unchanged mark of this `kind` (an empty folder always is), and otherwise left unchanged.
/// Meanwhile no other process can make it.
///
/// # Errors
/// The folder is a link, holds other files or cannot be written, or an error of `fill`; it is then unchanged.
pub(super) fn write_folder(dir: &Path, kind: OutputKind, fill: impl FnOnce(&Path) -> Result<()>) -> Result<()> {
    if std::fs::symlink_metadata(dir).is_ok_and(|metadata| metadata.is_symlink()) {
        let problem = "this is a link, and links are not followed";
        return Err(Error::new(ErrorKind::Refused, problem, "name the folder itself").about(dir));
    }
    let _lock = FolderLock::beside(dir)?;
    // Checked again before the folder is replaced, because somebody may have written into it meanwhile.
    let may_go = |folder: &Path| Ok(is_free(folder)? || is_unchanged(folder, kind)?);
    if !may_go(dir).map_err(io(dir))? {
        return Err(occupied(dir));
    }
    let unfinished = Unfinished::beside(dir).map_err(io(dir))?;
    let fresh = unfinished.new_path();
    std::fs::create_dir(&fresh).map_err(io(&fresh))?;
    fill(&fresh)?;
    seal_folder(&fresh, kind).map_err(io(&fresh.join(kind.file())))?;
    if unfinished.put_folder(dir, may_go).map_err(io(dir))? { Ok(()) } else { Err(occupied(dir)) }
}

#[cfg(test)]
mod tests {
    use super::super::{ChartParams, synth_chart};
    use super::*;

    #[test]
    fn what_comes_into_the_folder_while_the_new_one_is_made_stays() {
        let home = tempfile::tempdir().expect("a folder");
        let late = home.path().join("late");
        let params = ChartParams { width: 64, height: 48, discs: 2, frames: 3, ..ChartParams::default() };
        let params = ChartParams { radius: 3.0..=5.0, max_slope: 1.0, ..params };
        let (burst, truth) = synth_chart(&params, &Monitor::default()).expect("a chart");
        write_burst(&late, &burst, &truth, &Monitor::default()).expect("written");
        let added = |_: &Path| {
            std::fs::write(late.join("thesis.txt"), "precious").expect("written");
            Ok(())
        };
        assert_eq!(write_folder(&late, OutputKind::Burst, added), Err(occupied(&late)));
        assert_eq!(std::fs::read_to_string(late.join("thesis.txt")).expect("there"), "precious");
    }
}
