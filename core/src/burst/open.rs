//! Opening of a burst: finds the files, decodes them in parallel and calibrates the values to fractions of full scale.

use super::Burst;
use super::calibrate::{Calibration, Levels, check_bias, gain, mean_in_unit_of};
use super::decode::{self, Expected, FileScale, RawFrame};
use super::encoding::Encoding;
use super::error::OpenError;
use super::notes::{Remark, suggested_full_scale};
use super::options::OpenOptions;
use super::progress::{Ticker, in_order};
use super::source::find_bursts;
use crate::monitor::{Monitor, Stage};
use crate::plane::Plane;
use rayon::prelude::*;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

impl Burst {
    /// Opens a folder of frames, a picture, a multi-page TIFF or a `.npy` stack with the default options.
    ///
    /// # Errors
    /// See [`OpenError`]; every message names the file and a remedy.
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
    /// value that became 1. Colour becomes luma with the weights of Rec. 709 on the stored values
    /// ([`super::LUMA_WEIGHTS`]), or on linear ones with [`OpenOptions::linearise`]; alpha is ignored. A photograph is
    /// turned as its EXIF orientation says. Frames of different bits (8 and 16, integers and floats) are refused,
    /// unless [`OpenOptions::full_scale`] says which value of all their files becomes 1.
    ///
    /// **Damaged files.** The sizes that a file announces are compared with its length before it is decoded. Raw files,
    /// and pictures whose decoding takes much memory, are decoded by a [`super::DecodeWorker`] where one is installed.
    ///
    /// Frames are decoded in parallel; progress is reported to `monitor` for every frame, and cancellation checked
    /// before each.
    ///
    /// # Errors
    /// See [`OpenError`]. Of several faulty frames the first is named.
    pub fn open_with(inputs: &[PathBuf], options: &OpenOptions, monitor: &Monitor) -> Result<Self, OpenError> {
        monitor.check()?;
        monitor.report(Stage::Open, 0.0);
        let mut raw = read(inputs, options, monitor, &|frames| Ticker::new(monitor, frames))?;
        let remarks = Remark::of(&mut raw.frames);
        let levels = Levels::of(&raw.frames, options.full_scale, options.black_level)?;
        let calibration = calibration(&raw, levels, options, monitor)?;
        let integer = raw.frames.iter().all(|f| !matches!(f.scale, FileScale::Data { integer: false, .. }));
        let suggested_full_scale = suggested_full_scale(&raw.frames, options);
        let encoding =
            if raw.frames.iter().any(|f| f.encoding == Encoding::Srgb) { Encoding::Srgb } else { Encoding::Linear };
        let binning = raw.frames[0].binning;
        let frames = raw.frames.into_par_iter().map(|frame| {
            monitor.check()?;
            Ok(Arc::new(calibration.apply(frame, levels)))
        });
        let frames = frames.collect::<Result<Vec<_>, OpenError>>()?;
        if !options.is_plain() {
            check_overflow(&frames, &raw.origins)?;
        }
        Ok(Self {
            name: raw.name,
            frames,
            frame_names: raw.frame_names,
            full_scale: levels.full_scale,
            quantisation_step: if integer { 1.0 / (levels.full_scale - levels.black) } else { 0.0 },
            encoding,
            binning,
            suggested_full_scale,
            remarks,
            sources: inputs.iter().map(|p| std::path::absolute(p).unwrap_or_else(|_| p.clone())).collect(),
        })
    }
}

/// Bias and gain from the files that the options name, in the burst's unit.
fn calibration(
    burst: &RawBurst,
    levels: Levels,
    options: &OpenOptions,
    monitor: &Monitor,
) -> Result<Calibration, OpenError> {
    let mean = |path: &Path, kind| -> Result<_, OpenError> {
        // Quiet, because its progress would begin again after the burst's own.
        let frames = read(&[path.to_path_buf()], options, monitor, &|_| Ticker::quiet(monitor))?;
        Ok((mean_in_unit_of(&burst.frames, levels, &frames.frames, kind, path)?, frames.frames[0].scale))
    };
    let bias = match &options.bias {
        Some(path) => {
            let (bias, scale) = mean(path, "bias")?;
            check_bias(&bias, scale, &burst.frames, path)?;
            Some(bias)
        }
        None => None,
    };
    let gain = match &options.flat {
        Some(path) => Some(gain(mean(path, "flat")?.0, bias.as_ref(), levels.black, path)?),
        None => None,
    };
    Ok(Calibration { bias, gain })
}

/// Decoded frames, before calibration.
struct RawBurst {
    name: String,
    frames: Vec<RawFrame>,
    frame_names: Vec<String>,
    /// File of each frame, and the frame's index in it.
    origins: Vec<(PathBuf, usize)>,
}

/// Decodes the burst that `inputs` name. `ticker` makes the counter for a number of frames.
fn read<'a>(
    inputs: &[PathBuf],
    options: &OpenOptions,
    monitor: &Monitor,
    ticker: &dyn Fn(usize) -> Ticker<'a>,
) -> Result<RawBurst, OpenError> {
    let limits = &options.limits;
    let mut sources = find_bursts(inputs)?;
    if sources.len() > 1 {
        return Err(OpenError::SeveralBursts { names: sources.into_iter().map(|s| s.name).collect() });
    }
    let source = sources.pop().ok_or(OpenError::NothingGiven)?;
    let files = source.files()?;
    let Some(first) = files.first() else {
        return Err(OpenError::NothingGiven);
    };
    let (header, decoded) = decode::header(first, options, monitor)?;
    if files.len() == 1 {
        let ticker = ticker(header.frames);
        let frames = match decoded {
            Some(frame) => {
                ticker.tick();
                vec![frame]
            }
            None => decode::stack(first, options, &ticker)?,
        };
        let name = file_name(first);
        let frame_names = match frames.len() {
            1 => vec![name],
            n => (0..n).map(|t| format!("{name} [{t}]")).collect(),
        };
        let page = |t: usize| PathBuf::from(format!("{} (frame {t})", first.display()));
        check_samples(&frames, options, page)?;
        let origins = (0..frames.len()).map(|t| (first.clone(), t)).collect();
        return Ok(RawBurst { name: source.name, frames, frame_names, origins });
    }
    let size = (header.width, header.height);
    limits.check_burst(&inputs[0], files.len() as u64, size.0 as u64, size.1 as u64)?;
    let ticker = ticker(files.len());
    let expected = Expected { first, size };
    let decoded = Mutex::new(decoded);
    let frames = in_order(files.len(), |i| {
        ticker.check()?;
        let ready = if i == 0 { decoded.lock().unwrap_or_else(PoisonError::into_inner).take() } else { None };
        let frame = ready.map_or_else(|| decode::frame(&files[i], Some(expected), options, monitor), Ok)?;
        ticker.tick();
        Ok(frame)
    })?;
    check_samples(&frames, options, |t| files[t].clone())?;
    let frame_names = files.iter().map(|f| file_name(f)).collect();
    let origins = files.into_iter().map(|f| (f, 0)).collect();
    Ok(RawBurst { name: source.name, frames, frame_names, origins })
}

/// Checks that the frames' values have a common unit; `path` gives the path of a frame.
fn check_samples(frames: &[RawFrame], options: &OpenOptions, path: impl Fn(usize) -> PathBuf) -> Result<(), OpenError> {
    let Some((first, others)) = frames.split_first() else { return Ok(()) };
    for (t, frame) in others.iter().enumerate() {
        let (first_kind, kind) = (std::mem::discriminant(&first.scale), std::mem::discriminant(&frame.scale));
        if first_kind != kind || first.binning != frame.binning {
            return Err(OpenError::MixedSamples { first: path(0), path: path(t + 1) });
        }
        // A given full scale is a value of all files alike.
        let (first_samples, samples) = (first.scale.samples(), frame.scale.samples());
        if first_samples != samples && options.full_scale.is_none() {
            return Err(OpenError::MixedBits { first: path(0), first_samples, path: path(t + 1), samples });
        }
    }
    Ok(())
}

fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// Fails at the first value that the bias or a tiny full scale has driven out of the range of `f32`.
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
