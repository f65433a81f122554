//! Masks of a burst's frames: those of files, and the samples without a value or beyond the full scale.
//!
//! A mask is a picture of the frames' size. It hides where it is 0 and nowhere else, as COLMAP reads masks; a note
//! reports greys and labels, which a program that softens edges may mean otherwise. In a folder each file of frames has
//! its own mask, under COLMAP's name (`NAME.EXT.png`) or its own, in a folder named as the frames' or directly.

use super::options::OpenOptions;
use super::reading::{FileScale, RawFrame};
use crate::error::{Error, ErrorKind, Result};
use crate::plane::{Mask, Plane};
use std::path::{Path, PathBuf};
use std::sync::Arc;

#[derive(Debug, Default)]
pub(super) struct Masks {
    /// `None` for a mask that hides nothing.
    of_files: Vec<Option<Arc<Mask>>>,
    notes: Vec<String>,
    is_saturation_masked: bool,
}

#[derive(Debug, Clone, Copy)]
pub(super) struct Masked {
    by_files: usize,
    undefined: usize,
    saturated: usize,
}

impl Masks {
    /// Masks that the options name for frames of `size` from the files `origins`; `read` reads a file's frames.
    pub(super) fn of_options(
        options: &OpenOptions,
        (origins, size): (&[(PathBuf, usize)], (usize, usize)),
        read: &dyn Fn(&Path) -> Result<Vec<RawFrame>>,
    ) -> Result<Self> {
        let count = origins.len();
        let Some(path) = &options.mask else { return Self::of_frames(&[], (count, size), options, Path::new("")) };
        if !path.is_dir() {
            return Self::of_frames(&read(path)?, (count, size), options, path);
        }
        let mut masks = Self::of_frames(&[], (count, size), options, path)?;
        for (index, (file, _)) in origins.iter().enumerate() {
            // Frames of one file share its mask.
            if index > 0 && *file == origins[index - 1].0 {
                masks.of_files.push(masks.of_files[index - 1].clone());
                continue;
            }
            let own = mask_of(path, file)?;
            match &read(&own)?[..] {
                [mask] => {
                    masks.of_files.push(seen(&own, mask, size)?);
                    masks.notes.extend(note(&own, mask));
                }
                several => return Err(Error::stack_among_frames(&own, several.len())),
            }
        }
        Ok(masks)
    }

    pub(super) fn of_frames(
        masks: &[RawFrame],
        (frames, size): (usize, (usize, usize)),
        options: &OpenOptions,
        path: &Path,
    ) -> Result<Self> {
        let count = masks.len();
        if count > 1 && count != frames {
            let problem = format!("there are {count} masks, but the burst has {frames} frames");
            return Err(Error::new(ErrorKind::Mismatch, problem, "give one for all, or one a frame").about(path));
        }
        let of_files = masks.iter().map(|mask| seen(path, mask, size)).collect::<Result<_>>()?;
        let notes = masks.iter().filter_map(|mask| note(path, mask)).collect();
        Ok(Self { of_files, notes, is_saturation_masked: options.mask_saturated })
    }

    /// Whether each sample of `frame`, whose full scale is `white`, is saturated; empty unless these are masked.
    pub(super) fn saturated(&self, frame: &RawFrame, white: f32) -> Vec<bool> {
        if !self.is_saturation_masked {
            return Vec::new();
        }
        let limit = white * (1.0 - ROUNDING);
        frame.plane.data().iter().map(|value| *value >= limit).collect()
    }

    /// Masks calibrated frame `t`, whose values are NaN where they are undefined.
    pub(super) fn applied(&self, t: usize, plane: Plane, saturated: &[bool]) -> (Plane, Masked) {
        let of_file = self.of_files.get(if self.of_files.len() == 1 { 0 } else { t }).cloned().flatten();
        let hidden = |mask: &Arc<Mask>| mask.weights().data().iter().filter(|weight| **weight == 0.0).count();
        let mut masked = Masked { by_files: of_file.as_ref().map_or(0, hidden), undefined: 0, saturated: 0 };
        let is_hidden = |(index, x): &(usize, &f32)| x.is_nan() || saturated.get(*index) == Some(&true);
        let own: Vec<(usize, f32)> = plane.data().iter().enumerate().filter(is_hidden).map(|(i, x)| (i, *x)).collect();
        // A frame that hides nothing of its own shares the file's mask, without a copy.
        if own.is_empty() {
            return (plane.masked(of_file), masked);
        }
        let all_seen = || Plane::from_fn(plane.width(), plane.height(), |_, _| 1.0);
        let mut weights = of_file.map_or_else(all_seen, |mask| mask.weights().clone());
        for (index, value) in own {
            let weight = &mut weights.data_mut()[index];
            // A sample that a file hides counts once, as hidden by the file.
            if *weight > 0.0 {
                *weight = 0.0;
                *(if value.is_nan() { &mut masked.undefined } else { &mut masked.saturated }) += 1;
            }
        }
        (plane.masked(Mask::new(weights)), masked)
    }

    /// Notes on what is `masked` in frames of `pixels` pixels; an error for a frame that is masked whole.
    pub fn told(
        &self,
        origins: &[(PathBuf, usize)],
        pixels: usize,
        masked: &[Masked],
        options: &OpenOptions,
    ) -> Result<Vec<String>> {
        // A frame that is masked whole has no mean: an error, not a note.
        let blind = |masked: &Masked| masked.by_files + masked.undefined + masked.saturated >= pixels;
        if let Some(t) = masked.iter().position(blind) {
            let (path, frame) = &origins[t];
            let problem = match masked[t].undefined == pixels {
                true => format!("no pixel of frame {frame} has a value (NaN)"),
                false => format!("every pixel of frame {frame} is masked"),
            };
            return Err(Error::new(ErrorKind::Unsupported, problem, "leave the frame out, or mask less").about(path));
        }
        let sum = |of: fn(&Masked) -> usize| masked.iter().map(of).sum::<usize>();
        // The first odd mask stands for all; the others are counted.
        let mut told: Vec<String> = self.notes.iter().take(1).cloned().collect();
        if self.notes.len() > 1 {
            told.push(format!("so have {} more of the masks other values than two", self.notes.len() - 1));
        }
        if let Some(path) = &options.mask {
            let share = 100.0 * sum(|of| of.by_files) as f64 / (pixels * masked.len()) as f64;
            let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
            told.push(format!("{share:.1} % of the pixels are masked by {name}"));
        }
        type Count = fn(&Masked) -> usize;
        let counts: [(&str, Count); 2] =
            [("pixels without a value (NaN)", |of| of.undefined), ("saturated pixels", |of| of.saturated)];
        for (what, of) in counts.into_iter().filter(|(_, of)| sum(*of) > 0) {
            let frames = masked.iter().filter(|masked| of(masked) > 0).count();
            told.push(format!("{what} are masked: {} in {frames} of {} frames", sum(of), masked.len()));
        }
        Ok(told)
    }
}

/// Share by which arithmetic may leave a saturated value below the full scale.
const ROUNDING: f32 = 1e-6;

/// The mask of the frames' `size` that hides where `mask` is 0, or has no value; `None` where it hides nothing.
fn seen(path: &Path, mask: &RawFrame, size: (usize, usize)) -> Result<Option<Arc<Mask>>> {
    let (width, height) = mask.plane.size();
    if (width, height) != size {
        let problem = format!("this mask is {width}×{height}, but the frames are {}×{}", size.0, size.1);
        return Err(Error::new(ErrorKind::Mismatch, problem, "draw it on a frame as it is opened").about(path));
    }
    Ok(Mask::new(Plane::from_fn(width, height, |u, v| f32::from(mask.plane.at(u, v) > 0.0))))
}

/// A note on a `mask` that hides nothing though it is not all of one value, or has more than two values.
fn note(path: &Path, mask: &RawFrame) -> Option<String> {
    const FEW: usize = 8;
    let unit = if let FileScale::Range(range) = mask.scale { range } else { 1.0 };
    let data = mask.plane.data();
    let mut values: Vec<f32> = Vec::new();
    // Masks have few values, and neighbours repeat: no need to sort all pixels.
    for value in data {
        if values.last() != Some(value) && !values.contains(value) && values.len() <= FEW {
            values.push(*value);
        }
    }
    values.sort_by(f32::total_cmp);
    let (first, largest) = (*values.first()?, data.iter().copied().fold(0.0, f32::max));
    if values.len() < 2 || (values.len() == 2 && first <= 0.0) {
        return None;
    }
    let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
    let list = values.iter().map(|value| (value * unit).to_string()).collect::<Vec<_>>().join(", ");
    let has = if values.len() > FEW {
        format!("is grey, of more than {FEW} values")
    } else {
        format!("has the values {list}")
    };
    let dark = data.iter().filter(|value| **value > 0.0 && **value < 0.5 * largest).count();
    let share = 100.0 * dark as f64 / data.len() as f64;
    Some(format!(
        "the mask {name} {has}: 0 alone is hidden, as COLMAP reads masks, and what is dark but not 0, {share:.1} % of it, \
         is seen; give a mask of two values, 0 and 255, to hide more"
    ))
}

impl OpenOptions {
    /// Files with the masks of the frames in the files `frames`, as far as they are there.
    pub fn mask_files(&self, frames: &[PathBuf]) -> Vec<PathBuf> {
        match &self.mask {
            Some(folder) if folder.is_dir() => frames.iter().filter_map(|frame| mask_of(folder, frame).ok()).collect(),
            mask => mask.iter().filter(|mask| mask.is_file()).cloned().collect(),
        }
    }
}

fn mask_of(folder: &Path, frame: &Path) -> Result<PathBuf> {
    let name = frame.file_name().unwrap_or_default();
    let mut colmap = name.to_os_string();
    colmap.push(".png");
    let inside = frame.parent().and_then(Path::file_name).map(|parent| folder.join(parent));
    let folders = || inside.iter().map(PathBuf::as_path).chain([folder]);
    let mut files = folders().flat_map(|folder| [folder.join(&colmap), folder.join(name)]);
    files.find(|file| file.is_file() && file != frame).ok_or_else(|| {
        let [name, colmap] = [name, &colmap].map(|name| name.to_string_lossy());
        let problem = format!("this folder has no mask of the frame {name}: neither {colmap} nor {name}");
        Error::new(ErrorKind::NotFound, problem, "add it, or give one mask for all frames").about(folder)
    })
}
