//! Reports of `detect` about each burst, as JSON and as a summary for people.

use crate::burst::{Burst, Encoding, Note};
use crate::detect::Searched;
use crate::detector::{DetectorParams, Method, NoiseGate, Slope, SlopeFinding, SlopeGrid, StageTimes, Tally, Test};
use crate::detector::{noise_model::NoiseModel, test::NOT_SEARCHED};
use crate::files::path_text;
use crate::inspect::result::{TooFew, too_few};
use crate::inspect::slopes::{SlopeJudgement, features_at_slopes};
use crate::inspect::words::{counted, grouped};
use crate::monitor::{Cancelled, Monitor};
use serde::Serialize;
use std::collections::BTreeMap;

#[derive(Debug, Serialize)]
pub(super) struct FailureReport {
    pub name: String,
    pub error: String,
}

#[derive(Debug, Serialize)]
pub(super) struct BurstReport {
    pub name: String,
    pub inputs: Vec<String>,
    frames: usize,
    frames_used: [usize; 2],
    /// Position of each frame from the first one, frame intervals; absent for even ones.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    positions: Vec<f64>,
    /// Column and row of each view of a light field from the first one; absent for frames in time.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    views: Vec<[f64; 2]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    interval_s: Option<f64>,
    /// Slopes in pixels per second, a clause.
    #[serde(skip)]
    rate: Option<String>,
    width: usize,
    height: usize,
    /// Value in the files that became 1.0.
    full_scale: f32,
    encoding: Encoding,
    /// Pixels of the sensor along a side of one pixel; places, scales and slopes are in pixels of the frames.
    binning: usize,
    /// Largest value of a converter with fewer bits, which the data suggest; absent where they suggest none.
    #[serde(skip_serializing_if = "Option::is_none")]
    suggested_full_scale: Option<f32>,
    /// Names of the damaged frames that were accepted; absent where all are whole.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    damaged_frames: Vec<String>,
    /// Guesses and choices about the files, as clauses: an axis, an array, times and an order found; absent without.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    taken: Vec<String>,
    /// Names of the frames in their order, where something was taken so.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    frame_names: Vec<String>,
    #[serde(skip)]
    notes: Vec<Note>,
    pub features: usize,
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub files: BTreeMap<String, String>,
    frame_noise: f32,
    noise: NoiseModel,
    noise_gate_factor: f32,
    octaves: [i32; 2],
    slope_grid: SlopeGrid,
    #[serde(skip_serializing_if = "Option::is_none")]
    slopes_found: Option<SlopeFinding>,
    slopes: Vec<SlopeCount>,
    tally: Tally,
    pub times: TimesReport,
    /// Judgement of the slopes; absent for a method without slopes and for a single frame.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub slopes_judged: Option<SlopeJudgement>,
    advice: Option<AdviceReport>,
}

/// JSON of the report of a search of one burst, with advice.
///
/// # Errors
/// [`Cancelled`] once `monitor` was cancelled.
pub fn burst_document(
    burst: &Burst,
    searched: &Searched,
    monitor: &Monitor,
) -> Result<serde_json::Result<String>, Cancelled> {
    Ok(serde_json::to_string(&BurstReport::of(burst, searched, too_few(burst, searched, monitor)?)))
}

#[derive(Debug, Serialize)]
struct AdviceReport {
    message: String,
    parameter: Option<&'static str>,
    value: Option<String>,
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(super) struct SlopeCount {
    u: f32,
    v: f32,
    features: usize,
}

#[derive(Debug, Serialize)]
pub(super) struct TimesReport {
    pub open_secs: f32,
    slopes_secs: f32,
    #[serde(flatten)]
    search: StageTimes,
    pub write_secs: f32,
}

impl BurstReport {
    /// For features that are not written: without `files` and slopes judged, and with 0 s for opening and writing.
    pub fn of(burst: &Burst, Searched { detection, finding, slopes_secs, .. }: &Searched, few: Option<TooFew>) -> Self {
        let advised = |few: TooFew| {
            let (message, change) = (few.for_command(), few.change.map(|(change, _)| change));
            let parameter = change.as_ref().map(|change| change.parameter.name);
            AdviceReport { message, parameter, value: change.map(|change| change.value) }
        };
        let (search, slopes_secs) = (detection.times, *slopes_secs);
        let counts = detection.slopes.slopes().zip(features_at_slopes(detection));
        Self {
            name: burst.name.clone(),
            inputs: burst.sources.iter().map(|path| path_text(path)).collect(),
            frames: burst.len(),
            frames_used: [detection.frames_used.start, detection.frames_used.end],
            positions: burst.positions.list(),
            views: burst.positions.views(),
            interval_s: burst.positions.interval_s(),
            rate: burst.positions.rate_text(),
            width: burst.size().0,
            height: burst.size().1,
            full_scale: burst.full_scale,
            encoding: burst.encoding,
            binning: burst.binning,
            suggested_full_scale: burst.suggested_full_scale,
            damaged_frames: burst.damaged_frames().map(|(name, _)| name.to_owned()).collect(),
            taken: burst.taken.clone(),
            frame_names: if burst.taken.is_empty() { Vec::new() } else { burst.frame_names.clone() },
            notes: burst.notes(),
            features: detection.features.len(),
            files: BTreeMap::new(),
            frame_noise: detection.frame_noise,
            noise: NoiseModel::clone(&detection.noise),
            noise_gate_factor: detection.noise_gate_factor,
            octaves: [detection.octaves.start, detection.octaves.end],
            slope_grid: detection.slopes,
            slopes_found: finding.clone(),
            slopes: counts.map(|(Slope { u, v }, features)| SlopeCount { u, v, features }).collect(),
            tally: detection.tally,
            times: TimesReport { open_secs: 0.0, slopes_secs, search, write_secs: 0.0 },
            slopes_judged: None,
            advice: few.map(advised),
        }
    }
}

const SLOPES_SHOWN: usize = 25;
const BAR_WIDTH: usize = 30;

/// Summary for people; ends with an empty line.
pub(super) fn summary(report: &BurstReport, params: &DetectorParams) -> String {
    let [first, end] = report.frames_used;
    let used = if end - first == report.frames { String::new() } else { format!(", {first}..{end} used") };
    let BurstReport { name, width, height, .. } = report;
    let mut text = format!("{name}: {} of {width}×{height}{used}\n", counted(report.frames, "frame"));
    let mut line = |head: &str, words: &str| text += &format!("  {head:<9} {words}\n");
    if report.binning > 1 {
        line("binned", &format!("{0}×{0} pixels of the sensor are one pixel", report.binning));
    }
    report.notes.iter().for_each(|note| line("note", &note.for_command()));
    let rule = match params.noise_gate {
        NoiseGate::Factor(_) => String::new(),
        word => format!(" ({word})"),
    };
    let (noise, gate) = (report.frame_noise, report.noise_gate_factor);
    line("noise", &format!("{noise:.5} of full scale in a frame; noise gate {gate:.2} σ{rule}"));
    report.noise.warnings.iter().for_each(|warning| line("warning", &warning.text));
    if let Some(finding) = &report.slopes_found {
        // A judgement says itself how the slopes fit, so that the finding can be shorter.
        let is_judged = report.slopes_judged.is_some();
        line("slopes", &if is_judged { finding.summary_beside_judgement() } else { finding.summary() });
    }
    if let Some(SlopeJudgement { sentence, advice, .. }) = &report.slopes_judged {
        line(if report.slopes_found.is_some() { "" } else { "slopes" }, sentence);
        let options = advice.as_ref().map_or(String::new(), |advice| advice.options());
        if !options.is_empty() {
            line("", &format!("try {options}"));
        }
    }
    line("features", &report.features.to_string());
    if params.method == Method::Buff && report.features > 0 {
        text += &histogram(&report.slopes, report.rate.as_deref());
    }
    text += &format!("  rejected, of {} samples\n", grouped(report.tally.samples));
    let rejected = Test::ALL.into_iter().map(|test| (test, report.tally.rejected_by(test)));
    for (test, count) in rejected.filter(|(_, count)| *count > 0) {
        text += &format!("    {:>15}  {}\n", grouped(count), test.reason());
    }
    let count = report.tally.not_searched;
    if count > 0 {
        text += &format!("  besides\n    {:>15}  {NOT_SEARCHED}\n", grouped(count));
    }
    // Anew, because the lines between write to `text` themselves.
    let mut line = |head: &str, words: &str| text += &format!("  {head:<9} {words}\n");
    if let Some(advice) = &report.advice {
        line("note", &advice.message);
    }
    let t = &report.times;
    let slopes = report.slopes_found.as_ref().map_or(String::new(), |_| format!("slopes {:.2} s, ", t.slopes_secs));
    let StageTimes { noise_secs, search_secs, describe_secs } = t.search;
    let search = format!("noise {noise_secs:.2} s, search {search_secs:.2} s, describe {describe_secs:.2} s");
    line("time", &format!("open {:.2} s, {slopes}{search}, write {:.2} s", t.open_secs, t.write_secs));
    report.files.values().for_each(|path| line("wrote", path));
    text + "\n"
}

/// `x`, or 0 without a sign where `decimals` decimals would write −0.
pub(super) fn unsigned_zero(x: f32, decimals: i32) -> f32 {
    if (x * 10f32.powi(decimals)).round() == 0.0 { 0.0 } else { x }
}

fn histogram(slopes: &[SlopeCount], rate: Option<&str>) -> String {
    let max = slopes.iter().map(|s| s.features).max().unwrap_or(0).max(1);
    let mut counts: Vec<usize> = slopes.iter().map(|s| s.features).filter(|&n| n > 0).collect();
    counts.sort_unstable_by(|a, b| b.cmp(a));
    // Of many slopes those with the most features are shown, in the order of the grid.
    let min = counts.get(SLOPES_SHOWN - 1).copied().unwrap_or(1);
    let shown: Vec<&SlopeCount> = slopes.iter().filter(|s| s.features >= min).take(SLOPES_SHOWN).collect();
    let rate = rate.map_or(String::new(), |rate| format!("; {rate}"));
    let mut text = format!("  by slope, of the surroundings where features move with these (px/frame{rate})\n");
    for SlopeCount { u, v, features } in &shown {
        let bar = "#".repeat((features * BAR_WIDTH).div_ceil(max));
        let (u, v) = (unsigned_zero(*u, 2), unsigned_zero(*v, 2));
        text += &format!("    ({u:>6.2}, {v:>6.2}) {features:>7}  {bar}\n");
    }
    let rest = counts.len() - shown.len();
    if rest > 0 {
        let others = counts.iter().sum::<usize>() - shown.iter().map(|s| s.features).sum::<usize>();
        text += &format!("    and {} with {}\n", counted(rest, "more slope"), counted(others, "feature"));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_that_rounds_to_zero_has_no_minus() {
        let texts = [-0.004, -0.0, 0.004, -0.006].map(|x| format!("{:.2}", unsigned_zero(x, 2)));
        assert_eq!(texts, ["0.00", "0.00", "0.00", "-0.01"]);
        let text = histogram(&[SlopeCount { u: -0.0, v: -0.001, features: 3 }], None);
        assert!(text.contains("(  0.00,   0.00)"), "{text}");
    }

    #[test]
    fn a_long_histogram_shows_the_largest_and_counts_the_rest() {
        let slopes: Vec<SlopeCount> = (0..40).map(|k| SlopeCount { u: k as f32, v: 0.0, features: k }).collect();
        let text = histogram(&slopes, Some("1 px/frame is 30.0 px/s"));
        assert_eq!(text.lines().count(), 1 + SLOPES_SHOWN + 1);
        assert!(text.contains("( 39.00,   0.00)      39"), "{text}");
        assert!(text.ends_with("and 14 more slopes with 105 features\n"), "{text}");
    }
}
