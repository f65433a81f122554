//! From the frames of a burst to its noise, and to the frames as the search takes them.
//!
//! Frames that are worth nothing are left out, flicker and the sensor's pattern are taken off; then the noise of what remains is measured. Where nothing is found
//! the frames are those that came in.

use super::fixed_pattern::FixedPattern;
use super::frames::FrameSurvey;
use super::high_pass::{FREE_VALUES, HighPass, SQUARE_PIXELS, quiet_variance};
use super::model::NoiseModel;
use super::photon_transfer::PhotonTransfer;
use super::place::{ExcessMap, Square};
use super::pyramid::BoxPyramid;
use super::spectrum::{LevelNoise, Sources, measure};
use super::warning::{NoiseWarning, WarningKind, of_frames, of_pattern};
use crate::detector::scale_space::ScaleSpace;
use crate::monitor::{Cancelled, Monitor};
use crate::plane::Plane;
use crate::plane::tile::Region;
use rayon::prelude::*;
use std::ops::Range;
use std::sync::Arc;

/// A burst whose noise is known.
#[derive(Debug, Clone)]
pub struct Examined {
    /// Its noise.
    pub model: NoiseModel,
    /// The frames that take part, cleaned.
    pub frames: Vec<Arc<Plane>>,
    /// Which of the frames they are, counted from the first one given.
    pub kept: Vec<usize>,
}

/// Examines `frames` of one size, in time order, whose values differ by `quantisation_step` at least (0 if unknown), for a search of `octaves` of `space`. `None` where
/// there is too little to tell noise from texture: fewer than two different frames, or sides under 20 pixels.
///
/// # Errors
/// [`Cancelled`] once `monitor` was cancelled.
pub fn examine(
    frames: &[Arc<Plane>],
    quantisation_step: f32,
    space: &ScaleSpace,
    octaves: Range<i32>,
    monitor: &Monitor,
) -> Result<Option<Examined>, Cancelled> {
    let levels = (octaves.end.max(1) as usize + 1).max(5);
    let mut pyramids = pyramids_of(frames, levels, monitor)?;
    let squares = HighPass::new(&pyramids.iter().collect::<Vec<_>>());
    let survey = FrameSurvey::new(&squares);
    let kept = survey.kept();
    if squares.places.is_empty() || kept.len() < 2 {
        return Ok(None);
    }
    let mut clean: Vec<Arc<Plane>> = kept.iter().map(|&t| frames[t].clone()).collect();
    if survey.flicker > 0.0 {
        for (frame, &t) in clean.iter_mut().zip(&kept) {
            let gain = survey.frames[t].gain;
            Arc::make_mut(frame).data_mut().iter_mut().for_each(|x| *x /= gain);
        }
    }
    let about = quiet_variance(mean_variances(&squares, &kept), FREE_VALUES);
    let planes: Vec<&Plane> = clean.iter().map(|f| &**f).collect();
    let pattern = FixedPattern::find(&planes, about, monitor)?;
    if !pattern.is_empty() {
        clean.par_iter_mut().for_each(|frame| pattern.remove_from(Arc::make_mut(frame)));
    }
    let squares = if survey.flicker > 0.0 || !pattern.is_empty() {
        pyramids = pyramids_of(&clean, levels, monitor)?;
        HighPass::new(&pyramids.iter().collect::<Vec<_>>())
    } else {
        let mut all = std::mem::take(&mut pyramids).into_iter().map(Some).collect::<Vec<_>>();
        pyramids = kept.iter().filter_map(|&t| all[t].take()).collect();
        squares.only(&kept)
    };
    let mut model = NoiseModel {
        is_local: true,
        correlation: survey.correlation,
        warnings: [of_frames(&survey), of_pattern(&pattern)].concat(),
        pattern,
        ..NoiseModel::default()
    };
    let squares = measured_squares(&squares);
    fit_places(&mut model, &squares, kept.len(), quantisation_step, frames[0].size());
    model.brightness.relative_variance =
        kept.iter().map(|&t| survey.frames[t].relative_variance).sum::<f32>() / kept.len() as f32;
    model.frames = survey.frames;
    let planes: Vec<&Plane> = clean.iter().map(|f| &**f).collect();
    let middle = &pyramids[pyramids.len() / 2];
    let sources = Sources {
        frames: &planes,
        pyramids: &pyramids.iter().collect::<Vec<_>>(),
        variance_in: &|region| variance_in(&model, middle, &squares.0, region),
    };
    let levels = measure(sources, space, octaves.clone(), monitor)?;
    model.warnings.extend(of_spectrum(&levels));
    model.warnings.extend(of_places(&model));
    let (share, warning) = cut_off(&clean, quantisation_step);
    model.brightness.cut_off = share;
    model.warnings.extend(warning);
    model.levels = levels;
    prepare(&mut model, pyramids, octaves);
    Ok(Some(Examined { model, frames: clean, kept }))
}

/// The variance of the noise of one frame in a region of the image: of what the brightness says, and where that is not all, of the squares inside.
fn variance_in(model: &NoiseModel, middle: &BoxPyramid, squares: &[Square], region: &Region) -> f32 {
    let Region { columns, rows } = region;
    if model.excess.is_some() {
        let within = |x: f32, range: &Range<usize>| x >= range.start as f32 && x < range.end as f32;
        let inside = squares.iter().filter(|s| within(s.place.0, columns) && within(s.place.1, rows));
        let (sum, count) = inside.fold((0.0, 0usize), |(sum, count), s| (sum + s.variance, count + 1));
        if count >= SQUARES_INSIDE {
            return sum / count as f32;
        }
    }
    let at = |range: &Range<usize>| 0.5 * (range.start + range.end) as f32;
    model.measured_variance_at(middle, (at(columns), at(rows)))
}

fn pyramids_of(frames: &[Arc<Plane>], levels: usize, monitor: &Monitor) -> Result<Vec<BoxPyramid>, Cancelled> {
    let pyramid = |frame: &Arc<Plane>| {
        monitor.check()?;
        Ok(BoxPyramid::new(frame, levels))
    };
    frames.par_iter().map(pyramid).collect()
}

/// The variance of the noise of one frame in each square, from combinations of the frames `kept` in which the scene nearly cancels.
fn mean_variances(squares: &HighPass, kept: &[usize]) -> Vec<f32> {
    let combinations: Vec<Vec<(usize, f32)>> = match kept {
        [a, b] => vec![vec![(*a, 1.0), (*b, -1.0)]],
        _ => kept.chunks_exact(3).map(|t| vec![(t[0], 1.0), (t[1], -2.0), (t[2], 1.0)]).collect(),
    };
    let mut sums = vec![0.0f32; squares.places.len()];
    for weights in &combinations {
        sums.iter_mut().zip(squares.variances(weights)).for_each(|(sum, x)| *sum += x);
    }
    sums.iter_mut().for_each(|sum| *sum /= combinations.len() as f32);
    sums
}

/// The squares, and how many independent values are behind each.
fn measured_squares(squares: &HighPass) -> (Vec<Square>, f32) {
    let all: Vec<usize> = (0..squares.frames()).collect();
    let variances = mean_variances(squares, &all);
    let mean = |i: usize| squares.brightness.iter().map(|b| b[i]).sum::<f32>() / squares.frames() as f32;
    let each = squares.places.iter().zip(variances).enumerate();
    let list = each.map(|(i, (&place, variance))| Square { place, brightness: mean(i), variance }).collect();
    (list, FREE_VALUES * (squares.frames() / 3).max(1) as f32)
}

/// Fits the variance over brightness and place.
fn fit_places(
    model: &mut NoiseModel,
    (squares, free): &(Vec<Square>, f32),
    frames: usize,
    step: f32,
    size: (usize, usize),
) {
    let pairs: Vec<(f32, f32)> = squares.iter().map(|s| (s.brightness, s.variance)).collect();
    model.transfer = PhotonTransfer::fit(&pairs, SQUARE_PIXELS * frames, *free);
    // Rounding alone has this much.
    let least = step * step / 12.0;
    model.transfer.least = model.transfer.least.max(least);
    model.excess = ExcessMap::find(squares, &model.transfer, size, *free);
    let mut brightness: Vec<f32> = squares.iter().map(|s| s.brightness).collect();
    let middle = brightness.len() / 2;
    let middle = *brightness.select_nth_unstable_by(middle, f32::total_cmp).1;
    model.frame_noise = model.transfer.variance(middle).sqrt();
}

/// Works out what the search asks for at every candidate.
fn prepare(model: &mut NoiseModel, pyramids: Vec<BoxPyramid>, octaves: Range<i32>) {
    let least_excess = model.excess.as_ref().map_or(1.0, |excess| excess.range().0);
    let fold = |level: usize, f: fn(f32, f32) -> f32| {
        let values = pyramids.iter().flat_map(|p| p.level(level).data().iter().copied());
        values.reduce(f).unwrap_or(0.0)
    };
    let least =
        |octave: i32| model.transfer.variance(fold(NoiseModel::brightness_level(octave), f32::min)) * least_excess;
    model.brightness.least_variance = octaves.clone().map(least).collect();
    model.brightness.brightest = fold(3, f32::max).abs();
    model.brightness.first_octave = octaves.start;
    if model.transfer.slope > 0.0 || model.excess.is_some() {
        model.brightness.pyramids = pyramids;
    }
}

/// What pixels share, and how seldom strong noise is.
fn of_spectrum(levels: &[Vec<LevelNoise>]) -> Vec<NoiseWarning> {
    let max = |value: fn(&LevelNoise) -> f32| levels.iter().flatten().map(value).fold(0.0, f32::max);
    let mut warnings = Vec::new();
    let shared = max(|level| level.over_white);
    let finest = levels.first().and_then(|octave| octave.first()).map_or(1.0, |level| level.over_white);
    if shared > 1.4 * finest.min(1.0) {
        let text = format!(
            "neighbouring pixels share their noise: at coarse levels it has {:.1} times the variance of white noise; the gate is raised there; \
             give frames that are neither scaled nor compressed nor sharpened",
            shared
        );
        warnings.push(NoiseWarning::new(WarningKind::SharedByNeighbours, shared, text));
    }
    let tails = max(|level| level.excess_kurtosis);
    if tails > 0.0 {
        let text = format!(
            "the noise has long tails (excess kurtosis {tails:.1} in a frame), as files of low JPEG quality have; the gate is raised; \
             save the frames without loss"
        );
        warnings.push(NoiseWarning::new(WarningKind::LongTails, tails, text));
    }
    warnings
}

fn of_places(model: &NoiseModel) -> Option<NoiseWarning> {
    let (min, max) = model.excess.as_ref()?.range();
    let factor = (max / min.max(1e-6)).sqrt();
    let text = format!(
        "the noise differs by place: by up to {factor:.1} times more than the brightness says; the gate follows it; check for vignetting \
         that was corrected, or parts that were denoised"
    );
    Some(NoiseWarning::new(WarningKind::DiffersByPlace, factor, text))
}

/// Squares inside a region that tell its variance.
const SQUARES_INSIDE: usize = 6;
/// Rows apart at which pixels are counted.
const ROWS_APART: usize = 16;
/// Shares of cut-off pixels below this are not worth a word.
const LEAST_CUT_OFF: f32 = 0.05;

/// The share of pixels at the ends of the range, and a word about it if it matters.
fn cut_off(frames: &[Arc<Plane>], step: f32) -> (f32, Option<NoiseWarning>) {
    let (mut black, mut white, mut count) = (0usize, 0usize, 0usize);
    for frame in frames {
        for row in (0..frame.height()).step_by(ROWS_APART).map(|v| frame.row(v)) {
            black += row.iter().filter(|&&x| x <= 0.0).count();
            white += row.iter().filter(|&&x| x >= 1.0 - 0.5 * step).count();
            count += row.len();
        }
    }
    let (black, white) = (black as f32 / count as f32, white as f32 / count as f32);
    let (share, words, remedy) = if black >= white {
        (black, "black", "raise the camera's black level, or expose longer")
    } else {
        (white, "white", "expose shorter")
    };
    let warning = (share > LEAST_CUT_OFF).then(|| {
        let text =
            format!("{:.0} % of the pixels are {words}, where noise and signal are cut off; {remedy}", 100.0 * share);
        NoiseWarning::new(WarningKind::CutOff, share, text)
    });
    (share, warning)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::burst::Burst;
    use crate::synth::NoiseCase;

    fn examined(burst: &Burst) -> Examined {
        let space = ScaleSpace::new(4, 0, 4.0);
        examine(&burst.frames, burst.quantisation_step, &space, 0..4, &Monitor::default())
            .expect("not cancelled")
            .expect("there is enough")
    }

    fn case(case: NoiseCase) -> (Burst, Examined) {
        let burst = case.burst((480, 360), 10, 0.02, 3, &Monitor::default()).expect("not cancelled");
        let examined = examined(&burst);
        (burst, examined)
    }

    #[test]
    fn white_noise_is_left_as_it_is_and_nothing_is_said() {
        let (burst, found) = case(NoiseCase::White);
        assert!((found.model.frame_noise / 0.02 - 1.0).abs() < 0.02, "{}", found.model.frame_noise);
        assert_eq!(found.model.warnings, []);
        assert!(found.frames.iter().zip(&burst.frames).all(|(a, b)| Arc::ptr_eq(a, b)), "nothing is copied");
        assert!(found.model.excess.is_none() && found.model.brightness.pyramids.is_empty());
    }

    #[test]
    fn every_case_is_warned_of() {
        let kinds = |noise: NoiseCase| case(noise).1.model.warnings.iter().map(|w| w.kind).collect::<Vec<_>>();
        use WarningKind::*;
        for (noise, kind) in [
            (NoiseCase::Doubled, DuplicateFrames),
            (NoiseCase::Jpeg(30), LongTails),
            (NoiseCase::Correlated, SharedByNeighbours),
            (NoiseCase::BlackFrame, OutlierFrames),
            (NoiseCase::NoisyFrame, OutlierFrames),
            (NoiseCase::NoisyHalf, DiffersByPlace),
            (NoiseCase::ColumnStripes, Stripes),
            (NoiseCase::HotPixels, HotPixels),
            (NoiseCase::GainFlicker, GainFlicker),
            (NoiseCase::ClippedBlack, CutOff),
            (NoiseCase::Saturated, CutOff),
            (NoiseCase::ConstantFrame, OutlierFrames),
        ] {
            let kinds = kinds(noise);
            assert!(kinds.contains(&kind), "{noise:?}: {kinds:?}");
        }
    }

    #[test]
    fn too_little_to_tell_is_no_model() {
        let space = ScaleSpace::new(4, 0, 4.0);
        let examine = |frames: &[Arc<Plane>]| examine(frames, 0.0, &space, 0..1, &Monitor::default());
        let frame = Arc::new(Plane::from_fn(40, 40, |u, v| ((u * 7 + v * 13) % 11) as f32));
        assert!(examine(&[frame]).expect("not cancelled").is_none());
        let small = [(); 3].map(|()| Arc::new(Plane::zeros(12, 40))).to_vec();
        assert!(examine(&small).expect("not cancelled").is_none());
    }
}
