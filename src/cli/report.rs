//! Reports of `detect` about each burst, as JSON and as a summary for people.

use crate::burst::{Burst, Encoding, Note};
use crate::detect::Searched;
use crate::detector::advice::grouped;
use crate::detector::noise_model::NoiseModel;
use crate::detector::{
    Advice, Detection, DetectorParams, Method, NoiseGate, SearchParams, SlopeFinding, SlopeGrid, Test, explain,
};
use crate::files::path_text;
use crate::inspect::spectrum::SlopeJudgement;
use serde::{Serialize, Serializer};
use std::collections::BTreeMap;
use std::fmt::Write;
use std::sync::Arc;

/// The JSON document of `detect`.
#[derive(Debug, Serialize)]
pub(super) struct DetectReport<'a> {
    version: &'static str,
    command: &'static str,
    params: &'a SearchParams,
    /// Bursts that were searched, in the order of the arguments.
    pub bursts: Vec<BurstReport>,
    /// Bursts that failed.
    pub failures: Vec<FailureReport>,
}

impl<'a> DetectReport<'a> {
    pub fn new(params: &'a SearchParams) -> Self {
        Self { version: env!("CARGO_PKG_VERSION"), command: "detect", params, bursts: Vec::new(), failures: Vec::new() }
    }
}

/// Burst that failed.
#[derive(Debug, Serialize)]
pub(super) struct FailureReport {
    pub name: String,
    pub error: String,
}

/// Burst that was searched.
#[derive(Debug, Serialize)]
pub(super) struct BurstReport {
    name: String,
    inputs: Vec<String>,
    frames: usize,
    frames_used: [usize; 2],
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
    #[serde(skip)]
    notes: Vec<Note>,
    pub features: usize,
    /// Files that were written, by format; absent where none was.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    files: BTreeMap<String, String>,
    frame_noise: f32,
    #[serde(serialize_with = "shared")]
    noise: Arc<NoiseModel>,
    noise_gate_factor: f32,
    octaves: [i32; 2],
    slope_grid: SlopeGrid,
    /// Result of finding the slopes; absent where they were given.
    #[serde(skip_serializing_if = "Option::is_none")]
    slopes_found: Option<SlopeFinding>,
    slopes: Vec<SlopeCount>,
    tally: TallyReport,
    times: TimesReport,
    /// Judgement of the slopes; absent for a method without slopes and for a single frame.
    #[serde(skip_serializing_if = "Option::is_none")]
    slopes_judged: Option<SlopeJudgement>,
    /// Advice where there are no or few features; `None` (null) otherwise.
    advice: Option<AdviceReport>,
}

/// The part of the document of `detect` about one burst (JSON), for features that are not written to files: without
/// `files` and the judgement of the slopes, and with 0 for the times of opening and writing.
///
/// # Errors
/// When a number cannot be put into JSON.
pub fn burst_document(burst: &Burst, searched: &Searched) -> serde_json::Result<String> {
    let Searched { detection, params, finding, slopes_secs } = searched;
    let inputs = burst.sources.iter().map(|path| path_text(path)).collect();
    let report = BurstReport::new(&burst.name, inputs, burst, detection, BTreeMap::new(), [0.0, *slopes_secs, 0.0])
        .with_slopes(finding.clone())
        .with_advice(explain(detection, params, burst.size()));
    serde_json::to_string(&report)
}

/// Description of a problem, and the one option to change.
#[derive(Debug, Serialize)]
struct AdviceReport {
    message: String,
    parameter: &'static str,
    value: String,
}

impl From<Advice> for AdviceReport {
    fn from(advice: Advice) -> Self {
        Self { message: advice.for_command(), parameter: advice.parameter.name, value: advice.value }
    }
}

fn shared<S: Serializer>(noise: &Arc<NoiseModel>, serializer: S) -> Result<S::Ok, S::Error> {
    noise.serialize(serializer)
}

/// Number of features found at a slope of the grid.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(super) struct SlopeCount {
    u: f32,
    v: f32,
    features: usize,
}

#[derive(Debug, Serialize)]
struct TallyReport {
    samples: u64,
    kept: u64,
    rejected: BTreeMap<Test, u64>,
}

#[derive(Debug, Serialize)]
struct TimesReport {
    open_secs: f32,
    slopes_secs: f32,
    noise_secs: f32,
    search_secs: f32,
    describe_secs: f32,
    write_secs: f32,
}

impl BurstReport {
    pub fn new(
        name: &str,
        inputs: Vec<String>,
        burst: &Burst,
        detection: &Detection,
        files: BTreeMap<String, String>,
        [open_secs, slopes_secs, write_secs]: [f32; 3],
    ) -> Self {
        let tally = &detection.tally;
        let times = &detection.times;
        Self {
            name: name.to_owned(),
            inputs,
            frames: burst.len(),
            frames_used: [detection.frames_used.start, detection.frames_used.end],
            width: burst.size().0,
            height: burst.size().1,
            full_scale: burst.full_scale,
            encoding: burst.encoding,
            binning: burst.binning,
            suggested_full_scale: burst.suggested_full_scale,
            damaged_frames: burst.damaged_frames().map(|(name, _)| name.to_owned()).collect(),
            notes: burst.notes(),
            features: detection.features.len(),
            files,
            frame_noise: detection.frame_noise,
            noise: detection.noise.clone(),
            noise_gate_factor: detection.noise_gate_factor,
            octaves: [detection.octaves.start, detection.octaves.end],
            slope_grid: detection.slopes,
            slopes_found: None,
            slopes: slope_counts(detection),
            tally: TallyReport {
                samples: tally.samples,
                kept: tally.kept,
                rejected: Test::ALL.into_iter().map(|test| (test, tally.rejected_by(test))).collect(),
            },
            times: TimesReport {
                open_secs,
                slopes_secs,
                noise_secs: times.noise_secs,
                search_secs: times.search_secs,
                describe_secs: times.describe_secs,
                write_secs,
            },
            slopes_judged: None,
            advice: None,
        }
    }

    /// Adds the result of finding the slopes.
    pub fn with_slopes(self, slopes_found: Option<SlopeFinding>) -> Self {
        Self { slopes_found, ..self }
    }

    /// Adds the judgement of the slopes.
    pub fn with_judgement(self, slopes_judged: Option<SlopeJudgement>) -> Self {
        Self { slopes_judged, ..self }
    }

    /// Adds the advice.
    pub fn with_advice(self, advice: Option<Advice>) -> Self {
        Self { advice: advice.map(Into::into), ..self }
    }
}

/// Counts the features at each slope of the grid, in the grid's order.
pub(super) fn slope_counts(detection: &Detection) -> Vec<SlopeCount> {
    let mut counts = vec![0; detection.slopes.len()];
    for feature in &detection.features {
        if let Some(count) = counts.get_mut(feature.slope_index) {
            *count += 1;
        }
    }
    detection.slopes.slopes().zip(counts).map(|(s, features)| SlopeCount { u: s.u, v: s.v, features }).collect()
}

/// Maximum number of slopes in the summary.
const SLOPES_SHOWN: usize = 25;
/// Width of the longest bar of the histogram, characters.
const BAR_WIDTH: usize = 30;

/// Summary for people; ends with an empty line.
pub(super) fn summary(report: &BurstReport, params: &DetectorParams) -> String {
    let mut text = String::new();
    // Writing into a string cannot fail.
    let _ = write_summary(&mut text, report, params);
    text
}

fn write_summary(out: &mut String, report: &BurstReport, params: &DetectorParams) -> std::fmt::Result {
    let [first, end] = report.frames_used;
    let used = if end - first == report.frames { String::new() } else { format!(", {first}..{end} used") };
    writeln!(out, "{}: {} frames of {}×{}{used}", report.name, report.frames, report.width, report.height)?;
    if report.binning > 1 {
        writeln!(out, "  binned    {0}×{0} pixels of the sensor are one pixel", report.binning)?;
    }
    for note in &report.notes {
        writeln!(out, "  note      {}", note.for_command())?;
    }
    let gate = match params.noise_gate {
        NoiseGate::Factor(_) => format!("{:.2} σ", report.noise_gate_factor),
        word => format!("{:.2} σ ({word})", report.noise_gate_factor),
    };
    writeln!(out, "  noise     {:.5} of full scale in a frame; noise gate {gate}", report.frame_noise)?;
    for warning in &report.noise.warnings {
        writeln!(out, "  warning   {}", warning.text)?;
    }
    if let Some(finding) = &report.slopes_found {
        writeln!(out, "  slopes    {}", finding.summary())?;
    }
    if let Some(SlopeJudgement { sentence, advice }) = &report.slopes_judged {
        writeln!(out, "  {:<9} {sentence}", if report.slopes_found.is_some() { "" } else { "slopes" })?;
        let changes = advice.iter().flat_map(|advice| &advice.changes).map(|change| change.option());
        let options: Vec<String> = changes.collect();
        if !options.is_empty() {
            writeln!(out, "            try {}", options.join(" "))?;
        }
    }
    writeln!(out, "  features  {}", report.features)?;
    if params.method == Method::Buff && report.features > 0 {
        write_histogram(out, &report.slopes)?;
    }
    writeln!(out, "  rejected, of {} samples", grouped(report.tally.samples))?;
    for (test, &count) in &report.tally.rejected {
        if count > 0 {
            writeln!(out, "    {:>15}  {}", grouped(count), test.reason())?;
        }
    }
    if let Some(advice) = &report.advice {
        writeln!(out, "  note      {}", advice.message)?;
    }
    let t = &report.times;
    let slopes = report.slopes_found.as_ref().map_or(String::new(), |_| format!("slopes {:.2} s, ", t.slopes_secs));
    writeln!(
        out,
        "  time      open {:.2} s, {slopes}noise {:.2} s, search {:.2} s, describe {:.2} s, write {:.2} s",
        t.open_secs, t.noise_secs, t.search_secs, t.describe_secs, t.write_secs
    )?;
    for path in report.files.values() {
        writeln!(out, "  wrote     {path}")?;
    }
    writeln!(out)
}

/// `x`, or 0 without a sign where `decimals` decimals would write −0.
pub(super) fn unsigned_zero(x: f32, decimals: i32) -> f32 {
    if (x * 10f32.powi(decimals)).round() == 0.0 { 0.0 } else { x }
}

fn write_histogram(out: &mut String, slopes: &[SlopeCount]) -> std::fmt::Result {
    let max = slopes.iter().map(|s| s.features).max().unwrap_or(0).max(1);
    let mut counts: Vec<usize> = slopes.iter().map(|s| s.features).filter(|&n| n > 0).collect();
    counts.sort_unstable_by(|a, b| b.cmp(a));
    let min = counts.get(SLOPES_SHOWN - 1).copied().unwrap_or(1);
    let shown: Vec<&SlopeCount> = slopes.iter().filter(|s| s.features >= min).take(SLOPES_SHOWN).collect();
    writeln!(out, "  by slope (px/frame)")?;
    for slope in &shown {
        let bar = "#".repeat((slope.features * BAR_WIDTH).div_ceil(max));
        writeln!(
            out,
            "    ({:>6.2}, {:>6.2}) {:>7}  {bar}",
            unsigned_zero(slope.u, 2),
            unsigned_zero(slope.v, 2),
            slope.features
        )?;
    }
    let rest = slopes.iter().filter(|s| s.features > 0).count() - shown.len();
    if rest > 0 {
        let others = slopes.iter().map(|s| s.features).sum::<usize>() - shown.iter().map(|s| s.features).sum::<usize>();
        writeln!(out, "    and {rest} more slopes with {others} features")?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_that_rounds_to_zero_has_no_minus() {
        assert_eq!(
            [-0.004, -0.0, 0.004, -0.006].map(|x| format!("{:.2}", unsigned_zero(x, 2))),
            ["0.00", "0.00", "0.00", "-0.01"]
        );
        let mut text = String::new();
        write_histogram(&mut text, &[SlopeCount { u: -0.0, v: -0.001, features: 3 }]).expect("written");
        assert!(text.contains("(  0.00,   0.00)"), "{text}");
    }

    #[test]
    fn a_long_histogram_shows_the_largest_and_counts_the_rest() {
        let slopes: Vec<SlopeCount> = (0..40).map(|k| SlopeCount { u: k as f32, v: 0.0, features: k }).collect();
        let mut text = String::new();
        write_histogram(&mut text, &slopes).expect("written");
        assert_eq!(text.lines().count(), 1 + SLOPES_SHOWN + 1);
        assert!(text.contains("( 39.00,   0.00)      39"), "{text}");
        assert!(text.ends_with("and 14 more slopes with 105 features\n"), "{text}");
    }
}
