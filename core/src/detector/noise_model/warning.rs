//! Warnings about a burst's noise: what was found, what the search does about it, and a remedy.

use super::changing_lines::Extent;
use super::fixed_pattern::FixedPattern;
use super::frames::{FrameSurvey, LeftOut};
use super::spectrum::LevelNoise;
use super::variance::ExcessMap;
use crate::plane::Plane;
use serde::Serialize;

/// Assumption about the noise that does not hold for a burst.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NoiseWarning {
    /// Kind of the assumption, for programs; `text` is for people.
    pub kind: WarningKind,
    /// Size of the effect: a count, a share, or a factor, as the text says.
    pub number: f32,
    /// Finding, treatment and remedy, in one or two sentences.
    pub text: String,
}

/// Kind of an assumption about the noise.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum WarningKind {
    /// Frames repeat earlier ones bit by bit, or nearly.
    DuplicateFrames,
    /// Frames are black, flashed, empty, too noisy or blurred.
    OutlierFrames,
    /// Exposures differ from frame to frame.
    GainFlicker,
    /// The noise of consecutive frames is correlated.
    SmoothedOverTime,
    /// The noise of neighbouring pixels is correlated.
    SharedByNeighbours,
    /// Strong noise is more frequent than in a normal distribution.
    LongTails,
    /// The files' codec flattened blocks.
    FlattenedByCodec,
    /// The noise differs by place more than the brightness predicts.
    DiffersByPlace,
    /// Single pixels stay bright or dark.
    HotPixels,
    /// Single pixels are bright in one frame only.
    Struck,
    /// Columns or rows have offsets.
    Stripes,
    /// Columns or rows have offsets that change from frame to frame.
    ChangingLines,
    /// A fixed pattern cannot be told from the scene, which stays in place too.
    StillScene,
    /// Pixels are cut off at black or white.
    CutOff,
    /// A merged image keeps the strongest noise of its middle frame.
    KeptByMerge,
}

impl NoiseWarning {
    pub(super) fn new(kind: WarningKind, number: f32, text: String) -> Self {
        Self { kind, number, text }
    }
}

pub(super) fn of_frames(survey: &FrameSurvey, is_evened: bool) -> Vec<NoiseWarning> {
    let total = survey.frames.len();
    let mut warnings = Vec::new();
    let list = |wanted: fn(&LeftOut) -> bool| -> Vec<usize> {
        (0..total).filter(|&t| survey.frames[t].left_out.as_ref().is_some_and(wanted)).collect()
    };
    let copies = list(|why| matches!(why, LeftOut::Duplicate(_)));
    let count = copies.len();
    if count > 0 {
        let text = format!(
            "{count} of {total} frames repeat an earlier one ({}) and do not count; give the frames as they were captured, each once",
            numbered(&copies)
        );
        warnings.push(NoiseWarning::new(WarningKind::DuplicateFrames, count as f32, text));
    }
    type Wanted = fn(&LeftOut) -> bool;
    let kinds: [(&str, Wanted); 5] = [
        ("less than half as bright as the others", |why| matches!(why, LeftOut::Black)),
        ("more than twice as bright as the others", |why| matches!(why, LeftOut::Flash)),
        ("without any noise, as if filled in", |why| matches!(why, LeftOut::Empty)),
        ("far noisier than the others", |why| matches!(why, LeftOut::Noisy(_))),
        ("blurred", |why| matches!(why, LeftOut::Blurred(_))),
    ];
    for (words, wanted) in kinds {
        let which = list(wanted);
        let count = which.len();
        if count > 0 {
            let text = format!(
                "{count} of {total} frames left out as {words} ({}); leave them out of the burst, or give --frames",
                numbered(&which)
            );
            warnings.push(NoiseWarning::new(WarningKind::OutlierFrames, count as f32, text));
        }
    }
    // Flicker and drift are the same fault to the user, but drift hurts only at borders.
    if survey.flicker > 0.0 {
        let done = if is_evened {
            "were brought to the same brightness; fix the exposure, or give --flicker off to search them as they are"
        } else {
            "were left as they are; fix the exposure, or give --flicker auto to bring them to the same brightness"
        };
        let text = format!("the exposure flickers by {:.1} %; the frames {done}", 100.0 * survey.flicker);
        warnings.push(NoiseWarning::new(WarningKind::GainFlicker, survey.flicker, text));
    }
    if survey.drift > 0.0 {
        let done = if is_evened {
            "the frames were brought to the same brightness; fix the exposure, or give --flicker off to search them as they are"
        } else {
            "the frames were left as they are, so that borders that not all of them cover show edges; give --flicker auto"
        };
        let text = format!("the exposure changes by {:.1} % over the burst; {done}", 100.0 * survey.drift);
        warnings.push(NoiseWarning::new(WarningKind::GainFlicker, survey.drift, text));
    }
    if let Some(&correlation) = survey.correlations.first() {
        let text = format!(
            "the noise of consecutive frames is correlated ({correlation:.2}), so {} frames are worth fewer; the gate is raised; record \
             without noise reduction over time",
            survey.kept().len()
        );
        warnings.push(NoiseWarning::new(WarningKind::SmoothedOverTime, correlation, text));
    }
    warnings
}

pub(super) fn of_pattern(pattern: &FixedPattern) -> Vec<NoiseWarning> {
    let mut warnings = Vec::new();
    let hot = pattern.hot_pixels.len();
    if hot > 0 {
        let text = format!(
            "{hot} hot, dead or flickering pixels masked; a dark frame given as --bias removes those that do not flicker exactly"
        );
        warnings.push(NoiseWarning::new(WarningKind::HotPixels, hot as f32, text));
    }
    if pattern.struck > 0 {
        let text = format!(
            "{} pixels are bright in one frame only, as cosmic rays leave them; they were masked there; leave out frames with flashes",
            pattern.struck
        );
        warnings.push(NoiseWarning::new(WarningKind::Struck, pattern.struck as f32, text));
    }
    for (words, stripes) in [("columns", &pattern.columns), ("rows", &pattern.rows)] {
        if let Some(stripes) = stripes {
            let text = format!(
                "{words} have offsets of {:.5} of full scale; their sharp part was taken off, and the gate is raised by the rest; \
                 a dark frame given as --bias removes them exactly",
                stripes.deviation
            );
            warnings.push(NoiseWarning::new(WarningKind::Stripes, stripes.deviation, text));
        }
    }
    for (words, lines) in [("columns", pattern.changing_columns), ("rows", pattern.changing_rows)] {
        if let Some(lines) = lines {
            let deviation = lines.deviation;
            let what = match lines.extent {
                Extent::Sharp => "offsets that change from frame to frame",
                Extent::Wide => "bands",
            };
            let text = format!(
                "{words} have {what}, of {deviation:.5} of full scale; they were taken off each frame, as far as all of a line shares \
                 them; record without stabilisation, and not under lamps that flicker"
            );
            warnings.push(NoiseWarning::new(WarningKind::ChangingLines, deviation, text));
        }
    }
    if pattern.inseparable > 0 {
        let text = format!(
            "{} single pixels stand out, but the scene stays in place too, so they cannot be told from it; give a dark frame \
             as --bias, or move the camera",
            pattern.inseparable
        );
        warnings.push(NoiseWarning::new(WarningKind::StillScene, pattern.inseparable as f32, text));
    }
    warnings
}

/// False features a megapixel that pass the strict gate on white noise merged from eight frames
/// (`evaluate noise --case white --method merge --noise-gate strict --frames 0..8`).
const KEPT_BY_MERGE: f32 = 12.0;

pub(in crate::detector) fn of_merge() -> NoiseWarning {
    let text = format!(
        "the merge takes strong noise of its middle frame for motion and keeps it: on noise alone {KEPT_BY_MERGE:.0} false features a \
         megapixel pass the strict gate; raise --noise-gate by a sixth, or search the frames (--method buff)"
    );
    NoiseWarning::new(WarningKind::KeptByMerge, KEPT_BY_MERGE, text)
}

pub(super) fn of_spectrum(levels: &[Vec<LevelNoise>]) -> Vec<NoiseWarning> {
    let max = |value: fn(&LevelNoise) -> f32| levels.iter().flatten().map(value).fold(0.0, f32::max);
    let mut warnings = Vec::new();
    let shared = max(|level| level.over_white);
    let finest = levels.first().and_then(|octave| octave.first()).map_or(1.0, |level| level.over_white);
    // Raised against the finest level, since a codec lowers fine levels rather than raising coarse ones.
    if shared > 1.4 * finest.min(1.0) {
        let text = format!(
            "neighbouring pixels share their noise: at coarse levels it has {shared:.1} times the variance of white noise; the gate is raised there; \
             give frames that are neither scaled nor compressed nor sharpened"
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

pub(super) fn of_places(excess: Option<&ExcessMap>) -> Option<NoiseWarning> {
    let (min, max) = excess?.range();
    let factor = (max / min.max(1e-6)).sqrt();
    let text = format!(
        "the noise differs by place: by up to {factor:.1} times more than the brightness says; the gate follows it; check for vignetting \
         that was corrected, or parts that were denoised"
    );
    Some(NoiseWarning::new(WarningKind::DiffersByPlace, factor, text))
}

const ROWS_APART: usize = 16;
const MIN_CUT_OFF: f32 = 0.05;

/// Share of pixels at the ends of the range (from a frame's least value where that is below 0); a warning if large.
pub(super) fn cut_off(frames: &[&Plane], step: f32) -> (f32, Option<NoiseWarning>) {
    let (mut black, mut white, mut count) = (0usize, 0usize, 0usize);
    for frame in frames {
        let rows = || (0..frame.height()).step_by(ROWS_APART).map(|v| frame.row(v));
        // Where a black level was subtracted the range ends at the least value, not at 0.
        let least = rows().flatten().copied().fold(0.0, f32::min);
        for row in rows() {
            black += row.iter().filter(|&&x| x <= least + 0.5 * step * f32::from(u8::from(least < 0.0))).count();
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
    let warning = (share > MIN_CUT_OFF).then(|| {
        let text =
            format!("{:.0} % of the pixels are {words}, where noise and signal are cut off; {remedy}", 100.0 * share);
        NoiseWarning::new(WarningKind::CutOff, share, text)
    });
    (share, warning)
}

fn numbered(frames: &[usize]) -> String {
    let shown: Vec<String> = frames.iter().take(6).map(usize::to_string).collect();
    let rest = if frames.len() > 6 { format!(" and {} more", frames.len() - 6) } else { String::new() };
    let noun = if frames.len() == 1 { "number" } else { "numbers" };
    format!("{noun} {}{rest}, counted from 0", shown.join(", "))
}

#[cfg(test)]
mod tests {
    use super::super::frames::FrameFacts;
    use super::*;

    #[test]
    fn each_kind_of_frame_is_said_with_its_number() {
        let mut survey = FrameSurvey { flicker: 0.1, correlations: vec![0.5], ..FrameSurvey::default() };
        let why = [None, Some(LeftOut::Duplicate(0)), Some(LeftOut::Black), Some(LeftOut::Noisy(25.0)), None];
        survey.frames = why.map(|left_out| FrameFacts { gain: 1.0, relative_variance: 1.0, left_out }).to_vec();
        let warnings = of_frames(&survey, true);
        let text = |i: usize| &warnings[i].text;
        assert_eq!(warnings.len(), 5);
        assert!(text(0).starts_with("1 of 5 frames repeat an earlier one (number 1, counted from 0)"), "{}", text(0));
        assert!(text(1).contains("half as bright") && text(2).contains("noisier"), "{warnings:?}");
        assert!(text(3).contains("10.0 %") && text(4).contains("0.50"), "{warnings:?}");
        assert!(of_frames(&FrameSurvey::default(), true).is_empty() && of_pattern(&FixedPattern::default()).is_empty());
        let warnings =
            of_pattern(&FixedPattern { hot_pixels: vec![(1, 2)], inseparable: 7, ..FixedPattern::default() });
        assert_eq!(warnings.iter().map(|w| w.number).collect::<Vec<_>>(), [1.0, 7.0]);
        assert_eq!(numbered(&[0, 1, 2, 3, 4, 5, 6, 7]), "numbers 0, 1, 2, 3, 4, 5 and 2 more, counted from 0");
    }
}
