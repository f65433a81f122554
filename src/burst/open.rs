//! Opening a burst: which files, in what order, decoded in parallel, less the bias, in units of full scale.

use super::Burst;
use super::decode::{self, Expected, FileScale, RawFrame};
use super::error::OpenError;
use super::limits::Limits;
use super::progress::{Ticker, in_order};
use super::source::find_bursts;
use crate::monitor::{Monitor, Stage};
use crate::plane::Plane;
use rayon::prelude::*;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Float files whose largest magnitude is not above this are taken to be in [0, 1] already. Noise and calibration push
/// single values of such files above 1; files in other units lie far above it.
const LARGEST_UNIT_VALUE: f32 = 2.0;

/// How to open a burst.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct OpenOptions {
    /// A bias frame, or a stack or folder of them, which is averaged. It is subtracted in file units, before the
    /// division by the full scale. Negative differences are kept: clipping them would raise the mean of the noise and
    /// make it look smaller than it is.
    pub bias: Option<PathBuf>,
    /// The file's value that becomes 1.0, such as 4095 for 12-bit values in 16-bit files. `None` takes it from the
    /// files: see [`Burst::open_with`].
    pub full_scale: Option<f32>,
    /// How large the burst may be.
    pub limits: Limits,
}

impl Burst {
    /// Opens a folder of frames, a picture, a multi-page TIFF or a `.npy` stack with the default options.
    ///
    /// # Errors
    /// See [`OpenError`]; every message names the file and what to do.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, OpenError> {
        Self::open_with(&[path.as_ref().to_path_buf()], &OpenOptions::default(), &Monitor::default())
    }

    /// Opens one burst: a folder of frames (in natural order), a multi-page TIFF, a `.npy` stack, or several files that
    /// are its frames (in the order given). One single picture is a burst of one frame, which is enough for SIFT but
    /// has no slopes.
    ///
    /// **Values.** Integers of 8 and 16 bit are divided by their type's largest value (255, 65535; 127 and 32767 if
    /// signed), also when the camera has fewer bits: 12-bit values in 16-bit files reach 4095/65535 only, unless
    /// [`OpenOptions::full_scale`] says otherwise. Float files are taken as they are if their values lie in [0, 1]
    /// (magnitudes up to 2 are taken for noise around that), otherwise they are divided by the burst's largest
    /// magnitude (before the bias is subtracted); so are integers of 32 and 64 bit. [`Burst::full_scale`] remembers the
    /// divisor. Colour becomes luma with the weights of Rec. 709 on the stored values ([`super::LUMA_WEIGHTS`]); alpha
    /// is ignored. Pixels stay where the file has them: notes on how to turn a photograph (EXIF) are not followed.
    ///
    /// Frames are decoded in parallel; `monitor` hears of every frame and is asked before each.
    ///
    /// # Errors
    /// See [`OpenError`]. Of several faulty frames the first is named.
    pub fn open_with(inputs: &[PathBuf], options: &OpenOptions, monitor: &Monitor) -> Result<Self, OpenError> {
        if let Some(value) = options.full_scale.filter(|s| !(s.is_finite() && *s > 0.0)) {
            return Err(OpenError::FullScale { value });
        }
        monitor.check()?;
        monitor.report(Stage::Open, 0.0);
        let raw = read(inputs, &options.limits, &|frames| Ticker::new(monitor, frames))?;
        let bias = match &options.bias {
            Some(path) => Some(mean_bias(path, &raw, &options.limits, monitor)?),
            None => None,
        };
        let full_scale = options.full_scale.unwrap_or_else(|| natural_full_scale(&raw.frames));
        let integer = raw.frames.iter().all(|f| !matches!(f.scale, FileScale::Data { integer: false, .. }));
        let frames = raw.frames.into_par_iter().map(|frame| {
            monitor.check()?;
            Ok(Arc::new(calibrated(frame, bias.as_ref(), options.full_scale, full_scale)))
        });
        let frames = frames.collect::<Result<Vec<_>, OpenError>>()?;
        if bias.is_some() || options.full_scale.is_some() {
            check_overflow(&frames, &raw.origins)?;
        }
        Ok(Self {
            name: raw.name,
            frames,
            frame_names: raw.frame_names,
            full_scale,
            quantisation_step: if integer { 1.0 / full_scale } else { 0.0 },
            sources: inputs.iter().map(|p| std::path::absolute(p).unwrap_or_else(|_| p.clone())).collect(),
        })
    }
}

/// Frames as they come from the files.
struct RawBurst {
    name: String,
    frames: Vec<RawFrame>,
    frame_names: Vec<String>,
    /// The file of each frame, and its index there.
    origins: Vec<(PathBuf, usize)>,
}

/// `ticker` makes the counter for a number of frames.
fn read<'a>(inputs: &[PathBuf], limits: &Limits, ticker: &dyn Fn(usize) -> Ticker<'a>) -> Result<RawBurst, OpenError> {
    let mut sources = find_bursts(inputs)?;
    if sources.len() > 1 {
        return Err(OpenError::SeveralBursts { names: sources.into_iter().map(|s| s.name).collect() });
    }
    let source = sources.pop().ok_or(OpenError::NothingGiven)?;
    let files = source.files()?;
    let Some(first) = files.first() else {
        return Err(OpenError::NothingGiven);
    };
    let header = decode::header(first, limits)?;
    if files.len() == 1 {
        let ticker = ticker(header.frames);
        let frames = decode::stack(first, limits, &ticker)?;
        let name = file_name(first);
        let frame_names = match frames.len() {
            1 => vec![name],
            n => (0..n).map(|t| format!("{name} [{t}]")).collect(),
        };
        let origins = (0..frames.len()).map(|t| (first.clone(), t)).collect();
        return Ok(RawBurst { name: source.name, frames, frame_names, origins });
    }
    let size = (header.width, header.height);
    limits.check_burst(&inputs[0], files.len() as u64, size.0 as u64, size.1 as u64)?;
    let ticker = ticker(files.len());
    let expected = Expected { first, size };
    let frames = in_order(files.len(), |i| {
        ticker.check()?;
        let frame = decode::frame(&files[i], expected, limits)?;
        ticker.tick();
        Ok(frame)
    })?;
    let ranged = |f: &RawFrame| matches!(f.scale, FileScale::Range(_));
    if let Some(odd) = frames.iter().position(|f| ranged(f) != ranged(&frames[0])) {
        return Err(OpenError::MixedSamples { first: first.clone(), path: files[odd].clone() });
    }
    let frame_names = files.iter().map(|f| file_name(f)).collect();
    let origins = files.into_iter().map(|f| (f, 0)).collect();
    Ok(RawBurst { name: source.name, frames, frame_names, origins })
}

fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// The file's value that becomes 1.0. Where 8-bit and 16-bit frames come together, it is the larger one; each frame is
/// divided by its own.
fn natural_full_scale(frames: &[RawFrame]) -> f32 {
    let range = frames.iter().filter_map(|f| if let FileScale::Range(r) = f.scale { Some(r) } else { None });
    let largest =
        frames.iter().filter_map(|f| if let FileScale::Data { largest, .. } = f.scale { Some(largest) } else { None });
    match range.reduce(f32::max) {
        Some(range) => range,
        None => largest.reduce(f32::max).filter(|&l| l > LARGEST_UNIT_VALUE).unwrap_or(1.0),
    }
}

/// The mean of the bias frames, in file units.
fn mean_bias(path: &Path, burst: &RawBurst, limits: &Limits, monitor: &Monitor) -> Result<Plane, OpenError> {
    // Quiet, because its progress would begin anew after the burst's own.
    let raw = read(&[path.to_path_buf()], limits, &|_| Ticker::quiet(monitor))?;
    let (bias_size, frame_size) = (raw.frames[0].plane.size(), burst.frames[0].plane.size());
    if bias_size != frame_size {
        return Err(OpenError::BiasSize { path: path.into(), bias_size, frame_size });
    }
    let mut mean = Plane::zeros(frame_size.0, frame_size.1);
    let count = raw.frames.len() as f32;
    for frame in &raw.frames {
        let unit = if let FileScale::Range(range) = frame.scale { range } else { 1.0 };
        for (sum, value) in mean.data_mut().iter_mut().zip(frame.plane.data()) {
            *sum += value * unit / count;
        }
    }
    Ok(mean)
}

/// The frame less the bias, in units of full scale. `forced` is the full scale that the user gave.
fn calibrated(frame: RawFrame, bias: Option<&Plane>, forced: Option<f32>, full_scale: f32) -> Plane {
    let mut plane = frame.plane;
    // `unit` is what the plane is already divided by, `divisor` what it shall be divided by.
    let (unit, divisor) = match frame.scale {
        FileScale::Range(range) => (range, forced.unwrap_or(range)),
        FileScale::Data { .. } => (1.0, full_scale),
    };
    if unit != divisor {
        plane.data_mut().iter_mut().for_each(|v| *v = *v * unit / divisor);
    }
    if let Some(bias) = bias {
        plane.data_mut().iter_mut().zip(bias.data()).for_each(|(v, b)| *v -= b / divisor);
    }
    plane
}

/// Fails over the first value that the bias or a tiny full scale has driven out of the range of `f32`.
fn check_overflow(frames: &[Arc<Plane>], origins: &[(PathBuf, usize)]) -> Result<(), OpenError> {
    let bad = frames.par_iter().map(|plane| plane.data().iter().position(|v| !v.is_finite())).collect::<Vec<_>>();
    for ((plane, (path, frame)), index) in frames.iter().zip(origins).zip(bad) {
        if let Some(index) = index {
            let (u, v, value) = (index % plane.width(), index / plane.width(), plane.data()[index]);
            return Err(OpenError::NotFinite { path: path.clone(), frame: *frame, u, v, value });
        }
    }
    Ok(())
}
