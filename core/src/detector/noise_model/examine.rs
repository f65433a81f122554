//! Examination of a burst: measures its noise, and cleans the frames for the search.
//!
//! Useless frames, flicker and the sensor's pattern are removed, as far as found; the noise of the rest is measured.

use super::changing_lines::ChangingLines;
use super::codec::Flattened;
use super::contrast::{SceneMotion, looked_at, looked_at_views};
use super::fixed_pattern::{FixedPattern, are_struck, mask_struck};
use super::frames::FrameSurvey;
use super::high_pass::{FREE_VALUES, HighPass, Lattice, SQUARE_PIXELS, median};
use super::reading::{BoxPyramid, Lines, Reading};
use super::spectrum::{Sources, measure};
use super::variance::{ExcessMap, PhotonTransfer, Square, differ_by_place};
use super::warning::{cut_off, of_frames, of_pattern, of_places, of_spectrum};
use super::{FRAMES_SAMPLED, NoiseModel};
use crate::burst::{Offset, Positions};
use crate::detector::params::{Flicker, Slope};
use crate::detector::scale_space::ScaleSpace;
use crate::monitor::{Cancelled, Monitor};
use crate::plane::Plane;
use crate::plane::tile::Region;
use rayon::prelude::*;
use std::ops::Range;
use std::sync::Arc;

/// Relative growth of the limit for hot pixels where all noise is cut off on one side, which skews its means.
const SKEWED_MEANS: f32 = 0.5;

/// Noise and cleaned frames of a burst.
#[derive(Debug, Clone)]
pub struct Examined {
    /// Noise of the kept frames after cleaning.
    pub model: NoiseModel,
    /// Frames that take part, cleaned.
    pub frames: Vec<Arc<Plane>>,
    /// Indices of these frames, counted from the first one given.
    pub kept: Vec<usize>,
}

/// Properties of the search for which the noise is measured.
#[derive(Debug, Clone)]
pub struct ForSearch<'a> {
    /// Scales of the search's filters, with which the noise is measured.
    pub space: &'a ScaleSpace,
    /// Octaves of the search.
    pub octaves: Range<i32>,
    /// Slopes of the search, px/frame, by which the scene may move.
    pub slopes: &'a [Slope],
    /// Treatment of frames whose exposures differ.
    pub flicker: Flicker,
    /// Positions of the frames in the order given; those of views lie on a grid.
    pub positions: &'a Positions,
}

/// Examines `frames` of one size, in time order, whose values differ by `quantisation_step` at least (0 if unknown),
/// for a `search`. `None` where there is too little data: fewer than two different frames, or sides under 20 pixels.
///
/// # Errors
/// [`Cancelled`] once `monitor` was cancelled.
pub fn examine(
    frames: &[Arc<Plane>],
    quantisation_step: f32,
    search: &ForSearch<'_>,
    monitor: &Monitor,
) -> Result<Option<Examined>, Cancelled> {
    // Cleaning comes before measuring: flicker, strikes and patterns would all pass for noise.
    let ForSearch { space, octaves, slopes, flicker, positions } = search;
    let mut squares = HighPass::new(&planes(frames));
    monitor.check()?;
    let bit = bit_of(frames, quantisation_step);
    let flattened = Flattened::find(&planes(frames), quantisation_step).filter(|_| bit.is_none());
    (squares.are_flattened, squares.are_bits) = (flattened.is_some(), bit.is_some());
    squares.least_scene = quantisation_step.powi(2);
    let mut survey = FrameSurvey::new(&squares);
    let kept = survey.kept();
    if squares.places.is_empty() || kept.len() < 2 {
        return Ok(None);
    }
    let mut clean: Vec<Arc<Plane>> = kept.iter().map(|&t| frames[t].clone()).collect();
    // Exposures are evened before contrasts are formed: a brighter frame would leave the scene in them.
    let is_evened = (survey.flicker > 0.0 || survey.drift > 0.0) && *flicker == Flicker::Auto;
    if is_evened {
        for (frame, &t) in clean.iter_mut().zip(&kept) {
            let gain = survey.frames[t].gain;
            Arc::make_mut(frame).data_mut().iter_mut().for_each(|x| *x /= gain);
        }
    }
    let offsets: Vec<Offset<f32>> = kept.iter().map(|&t| positions.offset(t).to_f32()).collect();
    let (looked, contrasts) = if positions.are_views() {
        looked_at_views(&offsets, frames[0].data().len())
    } else {
        looked_at(clean.len(), frames[0].data().len())
    };
    let looked_frames: Vec<usize> = looked.iter().map(|&i| kept[i]).collect();
    let first_look = squares.only(&looked_frames);
    let about = first_look.noise_in(first_look.mean_variances(&contrasts));
    let mut shown = survey.shown(&first_look, &contrasts);
    let pattern_share = survey.pattern_share(&squares, about);
    // Frames that share noise have more of it in their mean.
    let shared = (1..).zip(&survey.correlations).map(|(lag, r)| (1.0 - lag as f32 / looked.len() as f32).max(0.0) * r);
    let more = (1.0 + 2.0 * shared.sum::<f32>()) / shown;
    let fastest = slopes.iter().map(|slope| slope.magnitude()).fold(0.0, f32::max);
    // With single photons in the dark every photon would be a strike.
    let is_struck = flattened.is_none() && bit.is_none() && are_struck(&first_look, &contrasts, about);
    // Noise that is rounded away nearly everywhere is rare, and far above what is measured.
    let of_strikes = about.max(quantisation_step.powi(2));
    let struck = if is_struck { mask_struck(&mut clean, of_strikes, fastest.ceil() as usize + 1) } else { 0 };
    monitor.check()?;
    // Needed by the octaves, by the scene's motion in them and by the brightness around a candidate.
    let levels = (octaves.end.max(1) as usize + 1).max(5);
    // The mean of n bits has longer tails: Bernstein's bound for H standard deviations adds H²·bit/(6n), with H = 6.
    let of_bits = bit.map_or(0.0, |bit| bit / (looked.len() as f32).sqrt());
    // Frames as in the files: cleaning moves values away from the ends of the range.
    let as_read: Vec<&Plane> = looked.iter().map(|&i| &*frames[kept[i]]).collect();
    let (share, cut_off) = cut_off(&as_read, quantisation_step);
    let about = ((about * more).sqrt() * (1.0 + SKEWED_MEANS * share) + of_bits).powi(2);
    let about = about.max(quantisation_step.powi(2) / 12.0);
    let are_independent = |masked: Option<&[Arc<Plane>]>| {
        // Hot pixels alone may have been what the frames shared.
        if let Some(clean) = masked.filter(|_| !survey.correlations.is_empty()) {
            let flags = (squares.are_flattened, squares.are_bits, squares.least_scene);
            let mut masked = HighPass::new(&planes(clean));
            (masked.are_flattened, masked.are_bits, masked.least_scene) = flags;
            survey.correlate_again(&masked);
            shown = survey.shown(&masked.only(&looked), &contrasts);
        }
        survey.correlations.is_empty()
    };
    let (reading, mut pattern) = read(&mut clean, &looked, about, are_independent, slopes, levels, monitor)?;
    pattern.struck = struck;
    let looked_planes: Vec<&Plane> = looked.iter().map(|&i| &*clean[i]).collect();
    // Lines hide flat blocks until they are taken off.
    let had_lines = pattern.changing_columns.is_some() || pattern.changing_rows.is_some();
    let of_clean = || had_lines.then(|| Flattened::find(&looked_planes, quantisation_step)).flatten();
    let flattened = flattened.or_else(of_clean).filter(|_| bit.is_none());
    // Squares of unchanged frames need not be filtered again.
    let is_changed = is_evened || struck > 0 || !pattern.is_empty() || had_lines;
    let squares = if is_changed { HighPass::new(&looked_planes) } else { first_look };
    let (relative, by_frame) = survey.relative_noise(&squares, &contrasts, &looked_frames);

    let at: Vec<Offset<f32>> = looked.iter().map(|&i| offsets[i]).collect();
    let pyramids: Vec<&BoxPyramid> = reading.pyramids.iter().collect();
    // Noise that frames share stays in place; read at shifted places it would seem larger.
    let slopes = if !survey.correlations.is_empty() { &[Slope::new(0.0, 0.0)] } else { *slopes };
    let motion = SceneMotion { pyramids: &pyramids, offsets: &at, slopes };
    let measured = |squares: &HighPass| {
        let of_squares = motion.slopes_at(&squares.places, frames[0].size());
        let variances = squares.still_variances(&looked_planes, &contrasts, &at, &of_squares);
        listed(squares, variances, looked.len())
    };
    let seen = |(list, free): (Vec<Square>, f32)| (list.into_iter().filter(|s| !s.variance.is_nan()).collect(), free);
    let mut squares: (Vec<Square>, f32) = seen(measured(&squares));

    let warnings = [of_frames(&survey, is_evened, pattern_share), of_pattern(&pattern)].concat();
    let model = NoiseModel { pattern_share, flattened, warnings, pattern, ..NoiseModel::default() };
    let mut model = NoiseModel { is_local: true, correlations: survey.correlations.clone(), shown, ..model };
    fit_brightness(&mut model, &squares, looked.len(), (quantisation_step, bit));
    // The map costs a filter at every square: it is made only where the sparse squares disagree.
    if flattened.is_none() && differ_by_place(&squares.0, &model.transfer, squares.1) {
        let lattice = Lattice::dense(frames[0].size());
        let dense = measured(&HighPass::on_lattice(&looked_planes, lattice));
        model.excess = ExcessMap::find(&dense.0, lattice, &model.transfer, dense.1);
        if model.excess.is_some() {
            squares = seen(dense);
        }
    }
    model.brightness.of_frames = by_frame;
    model.frames = survey.frames;
    // The middle frame stands for all in place and brightness.
    let middle = pyramids[pyramids.len() / 2];
    let variance_in = |region: &Region| variance_in(&model, middle, &squares.0, region);
    let sources = Sources {
        frames: &looked_planes,
        contrasts: &contrasts,
        relative: &relative,
        motion,
        variance_in: &variance_in,
        are_flattened: flattened.is_some(),
        differs: model.excess.is_some(),
    };
    let levels = measure(sources, space, octaves.clone(), monitor)?;
    model.warnings.extend(flattened.map(|flattened| flattened.warning()));
    // All bits lie at an end of the range and have long tails by nature: no reason to warn.
    let is_of_converter = bit.is_none();
    model.warnings.extend(is_of_converter.then(|| of_spectrum(&levels, flattened.is_some())).into_iter().flatten());
    model.warnings.extend(of_places(model.excess.as_ref()));
    model.warnings.extend(cut_off.filter(|_| is_of_converter));
    model.brightness.cut_off = if is_of_converter { share } else { 0.0 };
    model.levels = levels;
    prepare(&mut model, looked.into_iter().zip(reading.pyramids).collect(), octaves.clone());
    Ok(Some(Examined { model, frames: clean, kept }))
}

/// Value of a set pixel, where every pixel of `frames` is that value or 0, as from single-photon cameras. In files with
/// finer steps, 0 and the next value are a camera in the dark, whose noise is cut off.
fn bit_of(frames: &[Arc<Plane>], step: f32) -> Option<f32> {
    let (mut bit, mut some_are_0) = (None, false);
    for frame in frames {
        let values = frame.seen_values();
        some_are_0 |= values.contains(&0.0);
        if values.iter().filter(|x| **x != 0.0 && !x.is_nan()).any(|x| *bit.get_or_insert(*x) != *x) {
            return None;
        }
    }
    bit.filter(|bit| some_are_0 && *bit > 0.0 && (step >= 1.0 || *bit > 1.5 * step))
}

fn planes(frames: &[Arc<Plane>]) -> Vec<&Plane> {
    frames.iter().map(|f| &**f).collect()
}

fn read(
    clean: &mut [Arc<Plane>],
    looked: &[usize],
    variance: f32,
    are_independent: impl FnOnce(Option<&[Arc<Plane>]>) -> bool,
    slopes: &[Slope],
    levels: usize,
    monitor: &Monitor,
) -> Result<(Reading, FixedPattern), Cancelled> {
    let reading = |clean: &[Arc<Plane>], finds: bool| {
        let planes: Vec<&Plane> = looked.iter().map(|&i| &*clean[i]).collect();
        let stands_out = FixedPattern::stands_out(planes.len(), planes[0].size(), variance);
        Reading::new(&planes, levels, stands_out.filter(|_| finds), monitor)
    };
    let mut read = reading(clean, true)?;
    let planes: Vec<&Plane> = looked.iter().map(|&i| &*clean[i]).collect();
    let mut pattern = FixedPattern::find(&planes, &read, variance);
    // Read anew each time: lines are sought without hot pixels, and lines that change without fixed ones.
    let has_hot_pixels = !pattern.is_empty();
    if has_hot_pixels {
        clean.par_iter_mut().for_each(|frame| pattern.remove_from(Arc::make_mut(frame)));
        read = reading(clean, true)?;
    }
    // Noise shared by frames may look like stripes.
    let are_independent = are_independent(has_hot_pixels.then_some(clean));
    if read.columns.is_empty() {
        return Ok((read, pattern));
    }
    if are_independent {
        pattern = pattern.with_lines(&read);
    }
    if pattern.has_lines() {
        clean.par_iter_mut().for_each(|frame| pattern.remove_from(Arc::make_mut(frame)));
        read = reading(clean, true)?;
    }
    let brightness = read.columns.iter().flatten().flatten().sum::<f32>()
        / read.columns.iter().flatten().map(Vec::len).sum::<usize>() as f32;
    let along = |axis: fn(&Slope) -> f32| slopes.iter().map(axis).collect::<Vec<f32>>();
    let planes: Vec<&Plane> = looked.iter().map(|&i| &*clean[i]).collect();
    let found = |lines: &[Lines], axis: usize, slopes: &[f32]| {
        ChangingLines::find(lines, brightness, slopes).filter(|lines| !lines.are_rows_of_things(&planes, axis))
    };
    pattern.changing_columns = found(&read.columns, 0, &along(|slope| slope.u));
    pattern.changing_rows = found(&read.rows, 1, &along(|slope| slope.v));
    // `remove_from` measures the lines of each frame again, so the second axis sees the first one removed.
    for (axis, lines) in [pattern.changing_columns, pattern.changing_rows].into_iter().enumerate() {
        if let Some(lines) = lines {
            clean.par_iter_mut().for_each(|frame| lines.remove_from(Arc::make_mut(frame), axis));
            read = reading(clean, true)?;
        }
    }
    if pattern.has_lines() {
        // Strong lines had hidden the hot pixels in and beside them.
        let planes: Vec<&Plane> = looked.iter().map(|&i| &*clean[i]).collect();
        let hidden = FixedPattern::find(&planes, &read, variance);
        if !hidden.is_empty() {
            clean.par_iter_mut().for_each(|frame| hidden.remove_from(Arc::make_mut(frame)));
            read = reading(clean, false)?;
            pattern.hot_pixels.extend(hidden.hot_pixels);
            pattern.hot_pixels.sort_unstable_by_key(|&(u, v)| (v, u));
            pattern.hot_pixels.dedup();
        }
    }
    Ok((read, pattern))
}

/// Variance by brightness, or, where it also depends on place, the mean over the squares inside.
fn variance_in(model: &NoiseModel, middle: &BoxPyramid, squares: &[Square], region: &Region) -> f32 {
    let Region { columns, rows } = region;
    if model.excess.is_some() {
        let within = |x: f32, range: &Range<usize>| x >= range.start as f32 && x < range.end as f32;
        let inside = squares.iter().filter(|s| within(s.place.0, columns) && within(s.place.1, rows));
        let (sum, count) = inside.fold((0.0, 0usize), |(sum, count), s| (sum + s.variance, count + 1));
        // A mean of few squares would be less exact than the map.
        if count >= SQUARES_INSIDE {
            return sum / count as f32;
        }
    }
    let at = |range: &Range<usize>| 0.5 * (range.start + range.end) as f32;
    model.variance_at(middle, None, (at(columns), at(rows)))
}

/// Squares with their variances, and the number of independent values behind each, for `frames` frames.
fn listed(squares: &HighPass, variances: Vec<f32>, frames: usize) -> (Vec<Square>, f32) {
    let mean = |i: usize| squares.brightness.iter().map(|b| b[i]).sum::<f32>() / squares.frames() as f32;
    let each = squares.places.iter().zip(variances).enumerate();
    let list = each.map(|(i, (&place, variance))| Square { place, brightness: mean(i), variance }).collect();
    (list, FREE_VALUES * (frames / 3).max(1) as f32)
}

fn fit_brightness(
    model: &mut NoiseModel,
    (squares, free): &(Vec<Square>, f32),
    frames: usize,
    (step, bit): (f32, Option<f32>),
) {
    let pairs: Vec<(f32, f32)> = squares.iter().map(|s| (s.brightness, s.variance)).collect();
    let fit = match model.flattened {
        // Rounding by the codec decides on the variance, not the brightness.
        Some(_) => PhotonTransfer::even(pairs.iter().map(|pair| pair.1).sum::<f32>() / pairs.len() as f32),
        None => PhotonTransfer::fit(&pairs, SQUARE_PIXELS * frames, *free),
    };
    model.transfer = match bit {
        Some(bit) => fit.of_bits(bit),
        // At least the variance of rounding.
        None => PhotonTransfer { min: fit.min.max(step * step / 12.0), ..fit },
    };
    let middle = median(squares.iter().map(|s| s.brightness).collect());
    model.frame_noise = model.transfer.variance(middle).sqrt();
}

fn prepare(model: &mut NoiseModel, mut pyramids: Vec<(usize, BoxPyramid)>, octaves: Range<i32>) {
    let step = pyramids.len().div_ceil(FRAMES_SAMPLED);
    let first = (pyramids.len() - 1) % step / 2;
    pyramids = pyramids.into_iter().skip(first).step_by(step).collect();
    let min_excess = model.excess.as_ref().map_or(1.0, |excess| excess.range().0);
    let fold = |level: usize, f: fn(f32, f32) -> f32| {
        let values = pyramids.iter().flat_map(|(_, p)| p.level(level).data().iter().copied());
        values.reduce(f).unwrap_or(0.0)
    };
    // The noise of bits is least at either end: where few are set, and where nearly all are.
    let at = |octave, end| model.transfer.variance(fold(NoiseModel::brightness_level(octave), end));
    let min = |octave: i32| at(octave, f32::min).min(at(octave, f32::max)) * min_excess;
    model.brightness.min_variance = octaves.clone().map(min).collect();
    model.brightness.brightest = fold(3, f32::max).abs();
    model.brightness.first_octave = octaves.start;
    let is_cut = model.flattened.is_some_and(|flattened| flattened.cut != [1.0; 2]);
    if model.transfer.slope > 0.0 || model.excess.is_some() || is_cut {
        model.brightness.pyramids = pyramids;
    }
}

const SQUARES_INSIDE: usize = 6;
