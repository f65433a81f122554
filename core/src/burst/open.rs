//! Opening of a burst: finds the files, decodes them in parallel and calibrates the values to fractions of full scale.
//!
//! A frame's value becomes (value − bias) / (full scale − black) / gain. The bias is a bias frame where there is one
//! and the black level otherwise; the gain is the flat frame less the bias, over its own mean. Where their files are of
//! another kind, their values are converted to the frames' unit, or refused where the unit cannot be told.

use super::notes::{Remark, suggested_full_scale};
use super::options::{Encoding, OpenOptions};
use super::reading::{Declared, Expected, FileScale, RawFrame, Reading, Ticker, in_order};
use super::source::only_burst;
use super::stamps::Timing;
use super::views::{placed, views_of};
use super::{Burst, formats, layout::ViewsChoice, masks::Masks, positions::Positions, rotations::turned};
use crate::error::{Error, ErrorKind, Result};
use crate::monitor::{Monitor, Stage};
use crate::plane::Plane;
use rayon::prelude::*;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

impl Burst {
    /// Opens a folder of frames, a picture, a multi-page TIFF or a `.npy` stack with the default options.
    pub fn open(path: impl AsRef<Path>) -> Result<Self> {
        Self::open_with(&[path.as_ref().to_path_buf()], &OpenOptions::default(), &Monitor::default())
    }

    /// Opens one burst: a folder of frames (in natural order), a file with several (a multi-page TIFF, a `.npy` stack,
    /// a film), or several files, its frames in this order. A single picture is a burst without slopes.
    ///
    /// Integers of 8 and 16 bit are divided by their type's largest value (255, 65535; 127 and 32767 if signed), even
    /// if the camera has fewer bits: 12-bit values reach 4095/65535 only, unless [`OpenOptions::full_scale`] says
    /// otherwise. Float files are taken as they are if their values lie in [0, 1] (values up to 2 are taken for noise
    /// around that), otherwise they are divided by the burst's largest value (before the bias is subtracted); so are
    /// integers of 32 and 64 bit. [`Burst::full_scale`] remembers the file's value that became 1. Colour becomes luma
    /// with the weights of Rec. 709 on the stored values ([`super::LUMA_WEIGHTS`]), or on linear ones with
    /// [`OpenOptions::linearise`]; alpha is ignored. A photograph is turned as its EXIF orientation says. Frames of
    /// different bits or types are refused without [`OpenOptions::full_scale`]. NaN is masked.
    ///
    /// Frames are decoded in parallel, raw and very large ones by a [`super::DecodeWorker`] where one is installed.
    /// Each is reported to `monitor`, and cancellation checked before it. Of several errors the first frame's counts.
    pub fn open_with(inputs: &[PathBuf], options: &OpenOptions, monitor: &Monitor) -> Result<Self> {
        monitor.check()?;
        monitor.report(Stage::Open, 0.0);
        let raw = read(inputs, options, monitor)?;
        let measured = |path: &Option<PathBuf>| {
            let Some(path) = path.clone() else { return Ok(None) };
            // Quiet, because its progress would begin again after the burst's own.
            let options = &OpenOptions { take: None, times: None, views: None, ..options.clone() };
            let frames = read(std::slice::from_ref(&path), options, &monitor.silent())?.frames;
            Ok::<_, Error>(Some(Measured { frames, path }))
        };
        let measured = [measured(&options.bias)?, measured(&options.flat)?];
        // A mask has the frames' size as they are opened: nothing is binned or calibrated.
        let plain = OpenOptions { limits: options.limits, ..OpenOptions::default() };
        let masks = Masks::of_options(options, (&raw.origins, raw.size()), &|path| {
            Ok(read(&[path.to_path_buf()], &plain, &monitor.silent())?.frames)
        })?;
        let sources = inputs.iter().map(|p| std::path::absolute(p).unwrap_or_else(|_| p.clone())).collect();
        calibrated(raw, measured, &masks, sources, options, monitor)
    }
}

pub(super) fn calibrated(
    mut raw: RawBurst,
    measured: [Option<Measured>; 2],
    masks: &Masks,
    sources: Vec<PathBuf>,
    options: &OpenOptions,
    monitor: &Monitor,
) -> Result<Burst> {
    let remarks = Remark::of(&mut raw.frames);
    let levels = Levels::of(&raw.frames, options.full_scale, options.black_level)?;
    let is_plain = options.is_plain() && measured.iter().all(Option::is_none);
    let calibration = calibration(&raw, levels, measured)?;
    let integer = raw.frames.iter().all(|f| !matches!(f.scale, FileScale::Data { integer: false, .. }));
    let suggested_full_scale = suggested_full_scale(&raw.frames, options);
    let encoding =
        if raw.frames.iter().any(|f| f.encoding == Encoding::Srgb) { Encoding::Srgb } else { Encoding::Linear };
    let binning = raw.frames[0].binning;
    let frames = raw.frames.into_par_iter().enumerate().map(|(t, frame)| {
        monitor.check()?;
        // Saturation is judged before calibration, which moves the full scale.
        let saturated = masks.saturated(&frame, levels.white_of(&frame));
        let (plane, masked) = masks.applied(t, calibration.apply(frame, levels), &saturated);
        Ok((Arc::new(plane), masked))
    });
    let (frames, masked): (Vec<_>, Vec<_>) = frames.collect::<Result<Vec<_>>>()?.into_iter().unzip();
    raw.taken.extend(masks.told(&raw.origins, frames[0].data().len(), &masked, options)?);
    // Decoding has checked the values as they are stored; only arithmetic can drive them out of range.
    if !is_plain {
        check_overflow(&frames, &raw.origins)?;
    }
    let burst = Burst {
        name: raw.name,
        positions: raw.positions,
        frames,
        frame_names: raw.frame_names,
        full_scale: levels.full_scale,
        quantisation_step: if integer { 1.0 / (levels.full_scale - levels.black) } else { 0.0 },
        encoding,
        binning,
        suggested_full_scale,
        remarks,
        taken: raw.taken,
        sources,
    };
    let files: Vec<PathBuf> = raw.origins.into_iter().map(|(file, _)| file).collect();
    match options.files_of_rotations(&files) {
        Some([list, lens]) => turned(burst, &raw.seconds, (&list, &lens), options.take, monitor),
        None => Ok(burst),
    }
}

pub(super) struct Measured {
    pub frames: Vec<RawFrame>,
    pub path: PathBuf,
}

fn calibration(burst: &RawBurst, levels: Levels, measured: [Option<Measured>; 2]) -> Result<Calibration> {
    let mean = |of: &Measured, kind| mean_in_unit_of(&burst.frames, levels, &of.frames, kind, &of.path);
    let [bias, flat] = measured;
    let bias = bias.map(|of| {
        let bias = mean(&of, "bias")?;
        check_bias(&bias, of.frames[0].scale, &burst.frames, &of.path)?;
        Ok::<_, Error>(bias)
    });
    let bias = bias.transpose()?;
    let gain = flat.map(|of| gain(mean(&of, "flat")?, bias.as_ref(), levels.black, &of.path)).transpose()?;
    Ok(Calibration { bias, gain })
}

pub(super) struct RawBurst {
    pub name: String,
    pub frames: Vec<RawFrame>,
    pub frame_names: Vec<String>,
    /// File of each frame, and the frame's index in it.
    pub origins: Vec<(PathBuf, usize)>,
    pub taken: Vec<String>,
    pub positions: Positions,
    /// As of [`Timing`].
    pub seconds: Vec<f64>,
}

impl RawBurst {
    pub fn size(&self) -> (usize, usize) {
        self.frames[0].plane.size()
    }
}

fn read(inputs: &[PathBuf], options: &OpenOptions, monitor: &Monitor) -> Result<RawBurst> {
    let source = only_burst(inputs, options)?;
    let (mut files, limits) = (source.files()?, &options.limits);
    let count = files.len();
    let timing = if count > 1 { placed(&mut files, None, options, monitor)? } else { Timing::even(1) };
    // Of several files, only those taken are left.
    let options = &OpenOptions { take: options.take.filter(|_| count == 1), ..options.clone() };
    let first = files.first().ok_or_else(Error::nothing_given)?;
    let Declared { width, height, frames, views, taken, first: decoded, .. } =
        formats::declared(first, options, monitor)?;
    if count == 1 {
        let ticker = Ticker::new(monitor, frames);
        // Describing a raw file decodes its frame, which is not decoded again.
        let mut frames = match decoded {
            Some(frame) => {
                ticker.tick();
                options.taken(first, vec![frame], (1, 1))?
            }
            None => formats::stack(Reading::new(first, options, &ticker))?,
        };
        if let Some((grid, tiling)) = options.views.and_then(ViewsChoice::picture) {
            let [picture] = &frames[..] else { return Err(Error::views_of_stack(first, frames.len())) };
            limits.check_burst(first, grid.count() as u64, 1, 1)?;
            frames = views_of(first, picture, grid, tiling)?;
        }
        let in_one = Some((frames.len(), views));
        let Timing { positions, seconds, said, .. } = placed(&mut vec![first.clone()], in_one, options, monitor)?;
        let name = file_name(first);
        let columns = positions.rows_and_columns().map_or(frames.len(), |(_, columns)| columns);
        let frame_names = match frames.len() {
            1 if options.take.is_none() => vec![name],
            n if columns < n => (0..n).map(|k| format!("{name} [{}, {}]", k / columns, k % columns)).collect(),
            n => (0..n).map(|t| format!("{name} [{}]", t + options.take.map_or(0, |range| range.start))).collect(),
        };
        let page = |t: usize| PathBuf::from(format!("{} (frame {t})", first.display()));
        check_samples(&frames, options, page)?;
        let origins = (0..frames.len()).map(|t| (first.clone(), t)).collect();
        let taken = taken.into_iter().chain(said).collect();
        return Ok(RawBurst { name: source.name, frames, frame_names, origins, taken, positions, seconds });
    }
    let size = (width, height);
    limits.check_burst(&inputs[0], files.len() as u64, size.0 as u64, size.1 as u64)?;
    let ticker = Ticker::new(monitor, files.len());
    let expected = Expected { first, size };
    // The first frame may be decoded already; each file counts once in the progress, so its own is silent.
    let (decoded, silent) = (Mutex::new(decoded), monitor.silent());
    let frames = in_order(files.len(), |i| {
        ticker.check()?;
        let ready = if i == 0 { decoded.lock().unwrap_or_else(PoisonError::into_inner).take() } else { None };
        let ticker_of_file = &Ticker::new(&silent, 1);
        let reading = Reading { path: &files[i], expected: Some(expected), options, ticker: ticker_of_file };
        let frame = ready.map_or_else(|| formats::frame(reading), Ok)?;
        ticker.tick();
        Ok(frame)
    })?;
    check_samples(&frames, options, |t| files[t].clone())?;
    let frame_names = files.iter().map(|f| file_name(f)).collect();
    let origins = files.into_iter().map(|f| (f, 0)).collect();
    let Timing { positions, seconds, said, doubt } = timing;
    let taken = taken.into_iter().chain(said).chain(doubt).collect();
    Ok(RawBurst { name: source.name, frames, frame_names, origins, taken, positions, seconds })
}

fn check_samples(frames: &[RawFrame], options: &OpenOptions, path: impl Fn(usize) -> PathBuf) -> Result<()> {
    let Some((first, others)) = frames.split_first() else { return Ok(()) };
    for (t, frame) in others.iter().enumerate() {
        let mismatch = |problem: String, remedy: String| Err(Error::new(ErrorKind::Mismatch, problem, remedy));
        let paths = || [path(0), path(t + 1)].map(|path| path.display().to_string());
        let (first_kind, kind) = (std::mem::discriminant(&first.scale), std::mem::discriminant(&frame.scale));
        if first_kind != kind || first.binning != frame.binning {
            let problem = "frames of 8 or 16 bit and frames of float or 32-bit values have no unit in common";
            return mismatch(problem.into(), format!("save all frames alike: {}", paths().join(" and ")));
        }
        // A given full scale is a value of all files alike.
        let (first_samples, samples) = (first.scale.samples(), frame.scale.samples());
        if first_samples != samples && options.full_scale.is_none() {
            let [first, path] = paths();
            let problem = format!("this frame has {first_samples}: {first}, and this one has {samples}: {path}");
            let remedy = "save all frames alike, or say with a full scale which value is white in all of them";
            return mismatch(problem, remedy.into());
        }
    }
    Ok(())
}

fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// Fails at the first value that the bias or a tiny full scale has driven out of the range of `f32`.
fn check_overflow(frames: &[Arc<Plane>], origins: &[(PathBuf, usize)]) -> Result<()> {
    let bad = frames.par_iter().map(|plane| plane.data().iter().position(|v| !v.is_finite())).collect::<Vec<_>>();
    for ((plane, (path, frame)), index) in frames.iter().zip(origins).zip(bad) {
        if let Some(index) = index {
            return Err(Error::not_finite(path, *frame, plane.width(), index, plane.data()[index]));
        }
    }
    Ok(())
}

/// Float files up to this value are taken to be in [0, 1]: noise and calibration exceed 1 a little, other units by far.
const MAX_UNIT_VALUE: f32 = 2.0;
/// Fraction of the flat frame's mean; a pixel below it is dead, and is left as it is.
const DEAD_GAIN: f32 = 0.05;
/// Share of dead pixels (0 … 1) above which a flat frame is refused.
const DEAD_PART: f32 = 0.01;

/// File values that become 0 and 1, in the files' units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Levels {
    /// Full scale set in the options; `None` takes each frame's own.
    pub given: Option<f32>,
    /// Value that becomes 1.0, from the options or from the files.
    pub full_scale: f32,
    pub black: f32,
}

impl Levels {
    pub fn of(frames: &[RawFrame], given: Option<f32>, black: Option<f32>) -> Result<Self> {
        if let Some(value) = given.filter(|s| !(s.is_finite() && *s > 0.0)) {
            let problem = "the full scale is the file's value that becomes 1.0";
            let remedy = format!("it must be a positive number, not {value}");
            return Err(Error::new(ErrorKind::Request, problem, remedy));
        }
        let full_scale = given.unwrap_or_else(|| natural_full_scale(frames));
        let black = black.unwrap_or(0.0);
        if !(black.is_finite() && black < full_scale) {
            let problem = "the black level is the file's value that becomes 0";
            let remedy = format!("it must be a number below the full scale, {full_scale}, not {black}");
            return Err(Error::new(ErrorKind::Request, problem, remedy));
        }
        Ok(Self { given, full_scale, black })
    }

    /// The full scale in the unit of the values of a frame before calibration.
    pub fn white_of(&self, frame: &RawFrame) -> f32 {
        match frame.scale {
            FileScale::Range(range) => self.given.unwrap_or(range) / range,
            FileScale::Data { .. } => self.full_scale,
            FileScale::Raw { .. } => 1.0,
        }
    }
}

/// File value that becomes 1.0. Of 8-bit and 16-bit frames it is the larger one; each frame is divided by its own.
fn natural_full_scale(frames: &[RawFrame]) -> f32 {
    let range = frames.iter().filter_map(|f| match f.scale {
        FileScale::Range(white) | FileScale::Raw { white } => Some(white),
        FileScale::Data { .. } => None,
    });
    let largest =
        frames.iter().filter_map(|f| if let FileScale::Data { largest, .. } = f.scale { Some(largest) } else { None });
    let of_data = || largest.reduce(f32::max).filter(|&l| l > MAX_UNIT_VALUE).unwrap_or(1.0);
    range.reduce(f32::max).unwrap_or_else(of_data)
}

/// Bias and gain of each pixel: the first is subtracted from a frame, the second divides it. In the frames' unit.
#[derive(Debug, Default)]
pub(super) struct Calibration {
    pub bias: Option<Plane>,
    /// The gain of each pixel, 1 on average.
    pub gain: Option<Plane>,
}

impl Calibration {
    pub fn apply(&self, frame: RawFrame, levels: Levels) -> Plane {
        let mut plane = frame.plane;
        // `unit`: the plane is already divided by it; `divisor`: to divide by in the end.
        let (unit, divisor, black) = match frame.scale {
            FileScale::Range(range) => (range, levels.given.unwrap_or(range) - levels.black, levels.black),
            FileScale::Data { .. } => (1.0, levels.full_scale - levels.black, levels.black),
            // Black and white, of the file or given, have been applied already.
            FileScale::Raw { .. } => (1.0, 1.0, 0.0),
        };
        if unit != divisor {
            plane.data_mut().iter_mut().for_each(|v| *v = *v * unit / divisor);
        }
        match &self.bias {
            Some(bias) => plane.data_mut().iter_mut().zip(bias.data()).for_each(|(v, b)| *v -= b / divisor),
            None if black != 0.0 => {
                let black = black / divisor;
                plane.data_mut().iter_mut().for_each(|v| *v -= black);
            }
            None => {}
        }
        if let Some(gain) = &self.gain {
            plane.data_mut().iter_mut().zip(gain.data()).for_each(|(v, g)| *v /= g);
        }
        plane
    }
}

/// Factor from calibration frames' values to the unit of the burst's files. The error is a reason and a remedy.
fn factor(frames: FileScale, levels: Levels, of: FileScale) -> Result<f32, &'static str> {
    match (frames, of) {
        (FileScale::Range(a), FileScale::Range(b)) if a == b => Ok(b),
        (FileScale::Range(_), FileScale::Range(_)) if levels.given.is_some() => Err(
            "it is of another depth than the frames, and with a full scale of your own nothing says how they belong together; save it with the frames' depth",
        ),
        // Each is a fraction of its own range, as for frames of mixed depths.
        (FileScale::Range(a), FileScale::Range(_)) => Ok(a),
        // Fractions of the frames' full scale, as `stack` writes.
        (FileScale::Range(a), FileScale::Data { integer: false, largest }) if largest <= 1.0 => {
            Ok(levels.given.unwrap_or(a))
        }
        (FileScale::Range(a), FileScale::Data { largest, .. }) if largest <= a => Ok(1.0),
        (FileScale::Range(_), FileScale::Data { .. }) => Err(
            "its values lie beyond the range of the frames' files; save it in their unit, or as fractions of full scale",
        ),
        (FileScale::Data { integer: a, largest }, FileScale::Data { integer: b, largest: own }) => {
            let (unit, own_unit) = (!a && largest <= MAX_UNIT_VALUE, !b && own <= MAX_UNIT_VALUE);
            match levels.given {
                // Calibration frames of zeros fit any unit.
                _ if own == 0.0 || unit == own_unit => Ok(1.0),
                Some(_) if own_unit => Ok(levels.full_scale),
                _ => Err("its values and the frames' have different units; save both in the same unit"),
            }
        }
        // Integer calibration files: fractions of their range for frames in fractions, values in file units for others.
        (FileScale::Data { integer: false, largest }, FileScale::Range(_)) if largest <= MAX_UNIT_VALUE => Ok(1.0),
        (FileScale::Data { .. }, FileScale::Range(b)) => Ok(b),
        (FileScale::Raw { .. }, FileScale::Raw { .. }) => Ok(1.0),
        (FileScale::Raw { .. }, FileScale::Data { integer: false, largest }) if largest <= 1.0 => Ok(1.0),
        (FileScale::Raw { .. }, _) | (_, FileScale::Raw { .. }) => {
            Err("save it with the same program and in the same format as the frames")
        }
    }
}

/// The mean of calibration frames in the unit of the burst's own files; `kind` is "bias" or "flat".
pub(super) fn mean_in_unit_of(
    frames: &[RawFrame],
    levels: Levels,
    of: &[RawFrame],
    kind: &str,
    path: &Path,
) -> Result<Plane> {
    let (own_size, frame_size) = (of[0].plane.size(), frames[0].plane.size());
    if own_size != frame_size {
        let ((width, height), (frame_width, frame_height)) = (own_size, frame_size);
        let problem = format!("the {kind} frame is {width}×{height}, but the frames are {frame_width}×{frame_height}");
        let remedy = "take it with the same camera settings";
        return Err(Error::new(ErrorKind::Mismatch, problem, remedy).about(path));
    }
    // The unit of float files is that of the largest of all values.
    let whole = |frames: &[RawFrame]| {
        let largest = |scale| if let FileScale::Data { largest, .. } = scale { largest } else { 0.0 };
        match frames[0].scale {
            FileScale::Data { integer, .. } => {
                FileScale::Data { integer, largest: frames.iter().map(|f| largest(f.scale)).fold(0.0, f32::max) }
            }
            scale => scale,
        }
    };
    let burst = whole(frames);
    let mut mean = Plane::zeros(frame_size.0, frame_size.1);
    let count = of.len() as f32;
    for frame in of {
        let scale = if let FileScale::Data { .. } = frame.scale { whole(of) } else { frame.scale };
        let factor = factor(burst, levels, scale).map_err(|reason| Error::calibration(path, kind, reason))?;
        mean.data_mut().iter_mut().zip(frame.plane.data()).for_each(|(sum, value)| *sum += value * factor / count);
    }
    Ok(mean)
}

/// Checks that a converted bias whose files are `of` another kind is not brighter on average than all frames.
pub(super) fn check_bias(bias: &Plane, of: FileScale, frames: &[RawFrame], path: &Path) -> Result<()> {
    let is_alike = match (of, frames[0].scale) {
        (FileScale::Range(a), FileScale::Range(b)) => a == b,
        (a, b) => std::mem::discriminant(&a) == std::mem::discriminant(&b),
    };
    let unit = |frame: &RawFrame| if let FileScale::Range(range) = frame.scale { range } else { 1.0 };
    let values = frames.iter().flat_map(|f| f.plane.data().iter().map(move |v| v * unit(f)));
    let mean = mean_of(bias);
    if !is_alike && mean > f64::from(values.fold(f32::MIN, f32::max)) && mean > 0.0 {
        let reason = "it is brighter than everything in the frames; save it in their unit";
        return Err(Error::calibration(path, "bias", reason));
    }
    Ok(())
}

/// Mean of the values that are not NaN.
fn mean_of(plane: &Plane) -> f64 {
    let values = plane.data().iter().filter(|v| !v.is_nan());
    values.clone().map(|v| f64::from(*v)).sum::<f64>() / values.count() as f64
}

/// Gain of each pixel from a flat frame and the bias or black in it; 1 for dead pixels, of which many are refused.
pub(super) fn gain(mut flat: Plane, bias: Option<&Plane>, black: f32, path: &Path) -> Result<Plane> {
    match bias {
        Some(bias) => flat.data_mut().iter_mut().zip(bias.data()).for_each(|(f, b)| *f -= b),
        None => flat.data_mut().iter_mut().for_each(|f| *f -= black),
    }
    let mean = mean_of(&flat) as f32;
    let dark = |reason| Error::calibration(path, "flat", reason);
    if mean.is_nan() || mean <= 0.0 {
        return Err(dark("there is no light in it; take a picture of an even, bright surface"));
    }
    let mut dead = 0;
    for f in flat.data_mut() {
        *f /= mean;
        if *f < DEAD_GAIN {
            (dead, *f) = (dead + 1, 1.0);
        }
    }
    if dead as f32 > DEAD_PART * flat.data().len() as f32 {
        return Err(dark("more than 1 % of its pixels see nothing; take a picture of an even, bright surface"));
    }
    Ok(flat)
}

#[cfg(test)]
mod tests {
    use super::*;

    const LEVELS: Levels = Levels { given: None, full_scale: 65535.0, black: 0.0 };
    const FLOAT: fn(f32) -> FileScale = |largest| FileScale::Data { integer: false, largest };

    #[test]
    fn units_are_converted_or_refused() {
        let sixteen = FileScale::Range(65535.0);
        for (frames, of, expected) in [
            (FLOAT(0.9), FLOAT(0.1), Some(1.0)),
            (FLOAT(900.0), FLOAT(0.1), None),
            (FLOAT(900.0), sixteen, Some(65535.0)),
            (FLOAT(0.9), sixteen, Some(1.0)),
            (FileScale::Raw { white: 1023.0 }, sixteen, None),
            (FileScale::Raw { white: 1023.0 }, FileScale::Raw { white: 1023.0 }, Some(1.0)),
        ] {
            assert_eq!(factor(frames, LEVELS, of).ok(), expected, "{of:?} for {frames:?}");
        }
    }

    #[test]
    fn a_gain_is_one_on_average_and_dead_pixels_are_left_alone() {
        let path = Path::new("flat.tiff");
        let flat = Plane::from_fn(20, 10, |u, v| match (u, v) {
            (0, 0) => 100.0,
            (u, _) if u < 10 => 300.0,
            _ => 500.0,
        });
        let gain_map = gain(flat.clone(), None, 100.0, path).expect("a flat");
        assert_eq!(gain_map.at(0, 0), 1.0);
        assert!((gain_map.at(19, 9) / gain_map.at(5, 5) - 2.0).abs() < 1e-6);
        assert!(gain(flat.clone(), Some(&flat), 0.0, path).is_err());
        let half = Plane::from_fn(20, 10, |u, _| if u < 10 { 0.0 } else { 1.0 });
        assert!(gain(half, None, 0.0, path).expect_err("half of it is dark").to_string().contains("flat.tiff"));
    }
}
