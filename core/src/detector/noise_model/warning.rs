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
    /// A part of the noise is the same in all frames.
    FixedPattern,
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

/// Growth of the variance of the frames' mean by a pattern that they share from which it is worth a warning.
const MIN_GROWTH: f32 = 0.2;

pub(super) fn of_frames(survey: &FrameSurvey, is_evened: bool, pattern_share: f32) -> Vec<NoiseWarning> {
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
    let changes = [("flickers by", "", survey.flicker), ("changes by", " over the burst", survey.drift)];
    for (changes, over, by) in changes.into_iter().filter(|(.., by)| *by > 0.0) {
        let done = if is_evened {
            "brought to the same brightness; fix the exposure, or give --flicker off to search them as they are"
        } else {
            "left as they are; fix the exposure, or give --flicker auto to bring them to the same brightness"
        };
        let text = format!("the exposure {changes} {:.1} %{over}; the frames were {done}", 100.0 * by);
        warnings.push(NoiseWarning::new(WarningKind::GainFlicker, by, text));
    }
    let frames = survey.kept().len();
    let shared = if survey.shares_pattern() { survey.correlations[0] } else { pattern_share };
    if shared * (frames as f32 - 1.0) > MIN_GROWTH {
        let text = format!(
            "{:.0} % of the noise is the same in all frames, as a sensor's fixed pattern is, so {frames} frames are worth fewer; the gate is \
             raised; a dark frame given as --bias, or an even one as --flat, removes it",
            100.0 * shared
        );
        warnings.push(NoiseWarning::new(WarningKind::FixedPattern, shared, text));
    } else if let Some(&correlation) = survey.correlations.first() {
        let text = format!(
            "the noise of consecutive frames is correlated ({correlation:.2}), so {frames} frames are worth fewer; the gate is raised; record \
             without noise reduction over time"
        );
        warnings.push(NoiseWarning::new(WarningKind::SmoothedOverTime, correlation, text));
    }
    warnings
}

const STEADY: &str = "record without stabilisation, and not under lamps that flicker";

pub(super) fn of_pattern(pattern: &FixedPattern) -> Vec<NoiseWarning> {
    let mut warnings = Vec::new();
    let hot = pattern.hot_pixels.len();
    if hot > 0 {
        let what = if hot == 1 { "pixel" } else { "pixels" };
        let text = format!(
            "{hot} hot, dead or flickering {what} masked; a dark frame given as --bias removes those that do not flicker exactly"
        );
        warnings.push(NoiseWarning::new(WarningKind::HotPixels, hot as f32, text));
    }
    if pattern.struck > 0 {
        let text = format!(
            "{} bright in one frame only, as cosmic rays leave them, and masked there; leave out frames with flashes",
            if pattern.struck == 1 { "1 pixel is".to_owned() } else { format!("{} pixels are", pattern.struck) }
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
    let lines =
        [("columns", pattern.changing_columns, &pattern.columns), ("rows", pattern.changing_rows, &pattern.rows)];
    for (words, lines, stripes) in lines {
        // Lines that stay beside stripes are the smooth part of these.
        if let Some(lines) = lines.filter(|lines| !lines.stay || stripes.is_none()) {
            let deviation = lines.deviation;
            let (kind, what, remedy) = match (lines.stay, lines.extent) {
                (true, _) => (
                    WarningKind::Stripes,
                    "bands that stay the same",
                    "a dark frame given as --bias removes them, if they are the sensor's",
                ),
                (false, Extent::Sharp) => {
                    (WarningKind::ChangingLines, "offsets that change from frame to frame", STEADY)
                }
                (false, Extent::Wide) => (WarningKind::ChangingLines, "bands", STEADY),
            };
            let text = format!(
                "{words} have {what}, of {deviation:.5} of full scale; they were taken off each frame, as far as all of a line shares \
                 them; {remedy}"
            );
            warnings.push(NoiseWarning::new(kind, deviation, text));
        }
    }
    if pattern.inseparable > 0 {
        let text = format!(
            "{} in place, as a scene may that does not move; give a dark frame as --bias, or move the camera",
            match pattern.inseparable {
                1 => "1 single pixel stands out and stays".to_owned(),
                many => format!("{many} single pixels stand out and stay"),
            }
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

/// Number of standard errors by which the noise of a level must exceed that of white noise.
const SURE_OF_SHARED: f32 = 3.0;

/// Long tails are laid to the codec only where it is known to have flattened blocks.
pub(super) fn of_spectrum(levels: &[Vec<LevelNoise>], are_flattened: bool) -> Vec<NoiseWarning> {
    let max = |value: fn(&LevelNoise) -> f32| levels.iter().flatten().map(value).fold(0.0, f32::max);
    let mut warnings = Vec::new();
    let shared = max(|level| level.over_white);
    let surely = max(|level| level.over_white - SURE_OF_SHARED * level.error);
    let finest = levels.first().and_then(|octave| octave.first()).map_or(1.0, |level| level.over_white);
    // Raised against the finest level, since a codec lowers fine levels rather than raising coarse ones.
    if surely > 1.4 * finest.min(1.0) {
        let text = format!(
            "neighbouring pixels share their noise: at coarse levels it has {shared:.1} times the variance of white noise; the gate is raised there; \
             if the frames were scaled, compressed or sharpened, give them as captured"
        );
        warnings.push(NoiseWarning::new(WarningKind::SharedByNeighbours, shared, text));
    }
    let tails = max(|level| level.excess_kurtosis);
    if tails > 0.0 {
        let [cause, remedy] = if are_flattened {
            [", as files of low JPEG quality have", "; save the frames without loss"]
        } else {
            [""; 2]
        };
        let text = format!(
            "the noise has long tails (excess kurtosis {tails:.1} in a frame){cause}; the gate is raised{remedy}"
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
