//! Options for opening a burst: calibration, masks, encoding, layout of pixels where files are silent, and limits.
//!
//! Declared sizes are checked against the [`Limits`] before pixels are allocated: no file can exhaust the memory.

use super::layout::{AxisChoice, Dump, FrameRange, Mosaic, TimesChoice, ViewsChoice};
use crate::error::{Error, ErrorKind, Result};
use crate::{camera::CAMERA_FILE, plane::memory::machine_bytes};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Options for opening a burst: they turn the values of files into linear light, and tell which of them count.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(clap::Args))]
#[cfg_attr(feature = "cli", command(next_help_heading = "Calibration", allow_negative_numbers = true))]
#[serde(default, deny_unknown_fields)]
pub struct OpenOptions {
    /// Bias frame (or stack or folder of them, which is averaged), subtracted from each frame. Files of another kind
    /// are converted to the frames' unit, or refused.
    #[cfg_attr(feature = "cli", arg(long, value_name = "FILE"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bias: Option<PathBuf>,
    /// Flat frame (or stack or folder of them, which is averaged): a picture of an even surface, by which each frame is
    /// divided.
    #[cfg_attr(feature = "cli", arg(long, value_name = "FILE"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub flat: Option<PathBuf>,
    /// Value in the files that becomes intensity 1, such as 4095 for 12 bits in 16-bit files [default: what their type
    /// can hold].
    #[cfg_attr(feature = "cli", arg(long, value_name = "VALUE"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub full_scale: Option<f32>,
    /// Value in the files that becomes intensity 0; values below it become negative [default: 0, or what a raw file
    /// says].
    #[cfg_attr(feature = "cli", arg(long, value_name = "VALUE", allow_negative_numbers = true))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub black_level: Option<f32>,
    /// Undo the sRGB encoding of 8 and 16-bit pictures, so that values are proportional to light.
    #[cfg_attr(feature = "cli", arg(long))]
    pub linearise: bool,
    /// Take JPEG frames whose data is damaged or ends early as far as they can be decoded; the rest of such a frame is
    /// grey, and the notes say which they are. Also a FITS image that does not add up to its DATASUM
    /// [default: these are errors].
    #[cfg_attr(feature = "cli", arg(long))]
    pub accept_damaged: bool,
    /// Mask of the frames' size, 0 where they are hidden, and anything else where they are seen, as COLMAP reads masks;
    /// or a folder with one for each file of frames, named NAME.EXT.png, as COLMAP names them, or as the file. What is
    /// masked is in no mean and gives no features.
    #[cfg_attr(feature = "cli", arg(long, value_name = "FILE"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mask: Option<PathBuf>,
    /// Mask pixels at or above the full scale.
    #[cfg_attr(feature = "cli", arg(long))]
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub mask_saturated: bool,
    /// Colour that is taken of the 2×2 pixels of raw frames and mosaics.
    #[cfg_attr(feature = "cli", arg(long, value_enum, value_name = "COLOUR", default_value_t = RawColour::Luma))]
    pub raw_colour: RawColour,
    /// Mosaic of colours of frames whose files do not say that they have one, such as PNG, TIFF and files without
    /// header: the colours of the 2×2 pixels in the corner, row by row. With `none` each pixel stays one, whatever the
    /// file says.
    #[cfg_attr(feature = "cli", arg(long, value_enum, value_name = "PATTERN"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mosaic: Option<Mosaic>,
    /// Shape of files without header, such as 1600x1200:u16le; +BYTES stands before the first frame. Types: u1 (bits,
    /// the highest first; also of .npy arrays that numpy.packbits made), u8, u16le, u16be, f32, f32be,
    /// mono10p, mono12p, mono10packed, mono12packed.
    #[cfg_attr(feature = "cli", arg(long, value_name = "WxH:TYPE[+BYTES]"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub raw: Option<Dump>,
    /// Axis of the frames in a file that has others than time: T, Z or C of a TIFF, with places on the others such as
    /// T,C=1; first or last of an array.
    #[cfg_attr(feature = "cli", arg(long, value_name = "AXIS"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub axis: Option<AxisChoice>,
    /// Array of an .npz archive, image of a FITS or OME file, or track of a film, that holds the frames.
    #[cfg_attr(feature = "cli", arg(long, value_name = "NAME"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub array: Option<String>,
    /// Topic of a ROS bag or MCAP file that holds the frames, where several hold pictures, such as /camera/image_raw.
    #[cfg_attr(feature = "cli", arg(long, value_name = "TOPIC"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub topic: Option<String>,
    /// Frames A … B−1 of a long recording that are opened, counted from 0 in the order of the whole; times, masks and
    /// results are those of these frames.
    #[cfg_attr(feature = "cli", arg(long, value_name = "A..B"))]
    #[serde(skip_serializing_if = "Option::is_none", with = "as_text")]
    pub take: Option<FrameRange>,
    /// Times of the frames: a list (one time a line, or lines 'name,time', also beside or above the frames), names for
    /// stamps in the names of the files, header or exif for times that the files hold, found for those in which the
    /// images move uniformly, even for none [default: even].
    #[cfg_attr(feature = "cli", arg(long, value_name = "FILE|names|header|found|even"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub times: Option<TimesChoice>,
    /// Orientations of the camera (x right, y down, z forward) in the world, by which each frame is turned to
    /// mid-burst, so that slopes are of the camera's way alone: a line a frame (qx qy qz qw), or lines with stamps for
    /// frames with times (TUM: seconds tx ty tz qx qy qz qw; EuRoC: nanoseconds,x,y,z,qw,qx,qy,qz). Also beside or
    /// above the frames.
    #[cfg_attr(feature = "cli", arg(long, value_name = "FILE"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rotations: Option<PathBuf>,
    /// Camera file by which rotations move the pixels, as for colmap's --camera, also beside or above the frames
    /// [default: camera.toml there].
    #[cfg_attr(feature = "cli", arg(long, value_name = "FILE", requires = "rotations"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lens: Option<PathBuf>,
    /// Frames are views of a light field: ROWSxCOLUMNS, such as 9x9, row by row; :tiled or :eslf for one picture that
    /// holds all views side by side or interleaved; names for rows and columns in the names of the files
    /// (view_03_07.png, which needs no option where all of a grid are there). 1xN takes them as frames in time.
    #[cfg_attr(feature = "cli", arg(long, value_name = "ROWSxCOLUMNS[:tiled|:eslf]|names"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub views: Option<ViewsChoice>,
    /// Limits of the burst's size.
    #[serde(skip)]
    #[cfg_attr(feature = "cli", arg(skip))]
    pub limits: Limits,
}

impl OpenOptions {
    /// Whether every option but the limits has its default: nothing is calibrated, and files are taken as they are.
    pub fn is_plain(&self) -> bool {
        *self == Self { limits: self.limits, ..Self::default() }
    }

    /// These options with what of `other` is of one burst alone: mask, part, times, rotations, views, place in a file.
    #[must_use]
    pub fn with_burst_of(self, other: &Self) -> Self {
        let Self { mask, take, times, views, axis, array, topic, rotations, lens, .. } = other.clone();
        Self { mask, take, times, views, axis, array, topic, rotations, lens, ..self }
    }

    /// Options other than the default: names on a command line, with values as text; `None` for switches.
    pub fn given(&self) -> Vec<(String, Option<String>)> {
        let fields = |options: &Self| serde_json::to_value(options).ok().and_then(|all| all.as_object().cloned());
        // JSON holds no path that is not text.
        let mut own = self.clone();
        own.paths_mut().for_each(|path| *path = path.to_string_lossy().into_owned().into());
        let usual = fields(&Self::default()).unwrap_or_default();
        let given = fields(&own).unwrap_or_default().into_iter().filter(|(name, value)| usual.get(name) != Some(value));
        let text = |value: Value| match value {
            Value::String(text) => Some(text),
            // With the digits of the number that was read, not with those of its double.
            Value::Number(number) => number.as_f64().map(|number| (number as f32).to_string()),
            _ => None,
        };
        given.map(|(name, value)| (name.replace('_', "-"), text(value))).collect()
    }

    /// Paths of the files that are read beside the frames: bias, flat, mask, lists of times and rotations, camera.
    pub fn paths_mut(&mut self) -> impl Iterator<Item = &mut PathBuf> {
        let times = if let Some(TimesChoice::List(path)) = &mut self.times { Some(path) } else { None };
        let of_camera = self.rotations.iter_mut().chain(&mut self.lens);
        self.bias.iter_mut().chain(&mut self.flat).chain(&mut self.mask).chain(times).chain(of_camera)
    }

    /// File with the times of `frames`, also beside them or in the folder above; `None` where no list is to be read.
    pub fn list_of_times(&self, frames: &[PathBuf]) -> Option<PathBuf> {
        let Some(TimesChoice::List(path)) = &self.times else { return None };
        Some(near(path, frames, 2))
    }

    /// Files with the rotations of `frames` and of their camera; `None` where the frames are not to be turned.
    pub fn files_of_rotations(&self, frames: &[PathBuf]) -> Option<[PathBuf; 2]> {
        self.rotations.as_deref().map(|list| [near(list, frames, 2), self.file_of_camera(frames)])
    }

    /// File of the camera of `frames`, which need not exist: beside them or in one of the three folders above.
    pub fn file_of_camera(&self, frames: &[PathBuf]) -> PathBuf {
        near(self.lens.as_deref().unwrap_or(Path::new(CAMERA_FILE)), frames, 4)
    }

    /// The paths of [`paths_mut`](Self::paths_mut), cloned.
    pub fn paths(&self) -> Vec<PathBuf> {
        self.clone().paths_mut().map(|path| path.clone()).collect()
    }

    pub(super) fn mosaic_of(&self, declared: Option<Mosaic>) -> Option<Mosaic> {
        self.mosaic.or(declared).filter(|mosaic| *mosaic != Mosaic::None)
    }

    /// These options for looking through a whole file, of which a part may be taken.
    pub(super) fn of_whole(&self) -> Self {
        let limits = if self.take.is_some() { self.limits.of_whole() } else { self.limits };
        Self { limits, ..self.clone() }
    }

    /// The part of `all` frames of `path` to be taken, checked against the limits for frames of `size` (columns, rows).
    pub(super) fn taken<T>(&self, path: &Path, mut all: Vec<T>, size: (usize, usize)) -> Result<Vec<T>> {
        let range = self.taken_of(path, all.len(), size)?;
        all.truncate(range.end);
        all.drain(..range.start);
        Ok(all)
    }

    pub(super) fn taken_of(&self, path: &Path, count: usize, (width, height): (usize, usize)) -> Result<Range<usize>> {
        let Some(range) = self.take else { return Ok(0..count) };
        let problem = match range.check() {
            Err((problem, _)) => problem,
            Ok(()) if range.end > count => format!("{range} reaches beyond the {count} frames of {}", path.display()),
            Ok(()) => {
                self.limits.check_burst(path, (range.end - range.start) as u64, width as u64, height as u64)?;
                return Ok(range.start..range.end);
            }
        };
        Err(Error::param("take", problem, format!("give A..B with 0 ≤ A < B ≤ {count}")))
    }
}

/// `path`, or if nothing is there the file of its name beside the first of `frames` or above, in `levels` folders.
fn near(path: &Path, frames: &[PathBuf], levels: usize) -> PathBuf {
    let frame = frames.first().and_then(|frame| std::path::absolute(frame).ok()).unwrap_or_default();
    let mut files =
        frame.ancestors().skip(1).take(levels).map(|folder| folder.join(path.file_name().unwrap_or_default()));
    let found = if path.exists() { None } else { files.find(|file| file.is_file()) };
    found.unwrap_or_else(|| path.to_owned())
}

mod as_text {
    use super::FrameRange;
    use serde::{Deserialize, Deserializer, Serialize, Serializer, de::Error};

    pub(super) fn serialize<S: Serializer>(take: &Option<FrameRange>, to: S) -> Result<S::Ok, S::Error> {
        take.as_ref().map(ToString::to_string).serialize(to)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Option<FrameRange>, D::Error> {
        let text = Option::<String>::deserialize(from)?;
        text.map(|text| text.parse().map_err(D::Error::custom)).transpose()
    }
}

/// Colour that is taken of a raw frame, whose pixels have one colour each, in squares of 2×2.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
#[serde(rename_all = "lowercase")]
pub enum RawColour {
    /// The mean of the four pixels of a square.
    #[default]
    Luma,
    /// The mean of the two green pixels.
    Green,
    /// The red pixel, which is not in the middle of its square.
    Red,
    /// The blue pixel, which is not in the middle of its square.
    Blue,
}

/// Upper bounds for opened files. The defaults are far above any real burst and below what would stop a workstation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Limits {
    /// Longest side of a frame, pixels. Default 32768.
    pub max_side_px: usize,
    /// Pixels of one frame. Default 2²⁸ (16384×16384).
    pub max_pixels: u64,
    /// Number of frames. Default 4096; `usize::MAX` where they are looked through one by one.
    pub max_frames: usize,
    /// Memory of all frames together as `f32`, bytes. Default 16 GiB. The process's own memory is a further limit.
    pub max_bytes: u64,
}

impl Default for Limits {
    fn default() -> Self {
        Self { max_side_px: 32_768, max_pixels: 1 << 28, max_frames: 4096, max_bytes: 16 << 30 }
    }
}

impl Limits {
    /// Limits for a file of any length that is looked through, not kept.
    fn of_whole(self) -> Self {
        Self { max_frames: usize::MAX, ..self }
    }

    pub(crate) fn check_frame(&self, path: &Path, width: u64, height: u64) -> Result<()> {
        if width == 0 || height == 0 {
            let problem = format!("this file's frames have no pixels ({width}×{height})");
            return Err(Error::new(ErrorKind::Damaged, problem, "write it again or remove it").about(path));
        }
        if width.max(height) > self.max_side_px as u64 || width.saturating_mul(height) > self.max_pixels {
            let found = format!("its frames are {width}×{height} pixels");
            let limit = format!("{} pixels a side and {} pixels in all", self.max_side_px, self.max_pixels);
            return Err(Error::too_large(path, found, limit, "crop or shrink the frames"));
        }
        self.check_burst(path, 1, width, height)
    }

    /// Checks the number of frames, and the memory that they need together.
    ///
    /// # Errors
    /// Names `path`, the number or size that is too large, and the limit.
    pub fn check_burst(&self, path: &Path, frames: u64, width: u64, height: u64) -> Result<()> {
        if frames > self.max_frames as u64 {
            let (found, limit) = (format!("it has {frames} frames"), format!("{} frames", self.max_frames));
            return Err(Error::too_large(
                path,
                found,
                limit,
                "take a part of it, such as --take 0..10 (in the window: Calibration…)",
            ));
        }
        // A file that is looked through is not kept.
        let frames = if self.max_frames == usize::MAX { 1 } else { frames };
        let bytes = frames.saturating_mul(width).saturating_mul(height).saturating_mul(4);
        let max_bytes = machine_bytes().map_or(self.max_bytes, |bytes| bytes.min(self.max_bytes));
        if bytes > max_bytes {
            let found = format!("{frames} × {width}×{height} pixels need {} MiB", bytes >> 20);
            let limit = format!("{} MiB", max_bytes >> 20);
            return Err(Error::too_large(path, found, limit, "open fewer frames, or crop or shrink them"));
        }
        Ok(())
    }
}

/// Relation of the values of a burst's files to light.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Encoding {
    /// Proportional to light, as far as the files tell.
    #[default]
    Linear,
    /// Encoded for screens (sRGB), with more codes for dark values than for bright: 8-bit colours, JPEG and WebP.
    Srgb,
}
