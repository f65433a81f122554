//! Why are there few features or none? The test that took more than usual, and a setting that was tried and finds more.
//!
//! A good search rejects nearly every sample too, so each test's share of rejections is compared with its usual one,
//! and the worst test blamed. On noise alone any weaker setting finds something: a setting is offered only if a search
//! with it finds more than white noise would give it.

use crate::burst::Burst;
use crate::detect::{Searched, detect};
use crate::detector::noise::false_keypoints;
use crate::detector::params::{Word, doc};
use crate::detector::test::{LOWEST_GATE, wider_axis};
use crate::detector::{Detection, DetectorParams, Method, Param, ParamChange, SearchParams, Tally, Test};
use crate::inspect::words::{capitalised, grouped};
use crate::monitor::{Cancelled, Monitor};

/// Reason why a search found few features or none, and settings that were tried.
#[derive(Debug, Clone, PartialEq)]
pub struct TooFew {
    /// Reason: a clause without a capital at its start or a full stop at its end.
    pub problem: String,
    /// Change that helps, with the number of features then; `None` where none of the tried ones does.
    pub change: Option<(ParamChange, usize)>,
    /// Changes that find no more than noise alone would.
    pub in_vain: Vec<ParamChange>,
}

impl TooFew {
    /// Sentence for the command line, which names options.
    pub fn for_command(&self) -> String {
        self.problem.clone() + &self.tried(ParamChange::option)
    }

    /// Sentence for the window, which names parameters by their labels.
    pub fn for_window(&self) -> String {
        capitalised(&self.problem) + &self.tried(ParamChange::label)
    }

    fn tried(&self, named: fn(&ParamChange) -> String) -> String {
        let in_vain: Vec<String> = self.in_vain.iter().map(named).collect();
        match &self.change {
            Some((change, then)) => format!("; try {}, which finds {}", named(change), grouped(*then as u64)),
            None if in_vain.is_empty() => String::new(),
            None => format!("; with {} there is no more than noise alone gives", in_vain.join(" or ")),
        }
    }
}

/// Fewer features than this in a million pixels are too few.
const LITTLE_PER_MEGAPIXEL: f64 = 50.0;
/// Fewer features than this are too few in an image of any size.
const LITTLE: usize = 8;
/// Least number of samples above both thresholds for one feature: usually one of 650 to 1000 became a keypoint.
const SAMPLES_PER_FEATURE: u64 = 500;
/// Part of its usual share of passing candidates below which a test is blamed.
const BLAMED_BELOW: f64 = 0.5;
/// Gate's share of rejected samples below which the peak threshold before it had already taken the noise.
const GATE_REJECTS_NOISE: f64 = 0.999;

type Setting = (Param<SearchParams>, String);

/// Whether `detection` has too few features for an image of `size` (columns, rows), however many a maximum kept.
pub fn has_too_few(detection: &Detection, size: (usize, usize)) -> bool {
    // Features cut by the user's maximum were found: nothing is wrong.
    detection.features.len() < wanted(size) && detection.tally.rejected_by(Test::MaxFeatures) == 0
}

fn wanted(size: (usize, usize)) -> usize {
    LITTLE.max((LITTLE_PER_MEGAPIXEL * megapixels(size)) as usize)
}

fn megapixels((width, height): (usize, usize)) -> f64 {
    1e-6 * width as f64 * height as f64
}

/// Explains why a search of `burst` found few features or none; `None` where it has enough. A setting to change is
/// tried: each takes a search of its own, of more slopes than before where it widens them.
///
/// # Errors
/// [`Cancelled`] once `monitor` was cancelled.
pub fn too_few(burst: &Burst, searched: &Searched, monitor: &Monitor) -> Result<Option<TooFew>, Cancelled> {
    let Searched { detection, params, finding, .. } = searched;
    if !has_too_few(detection, burst.size()) {
        return Ok(None);
    }
    let what = match detection.features.len() {
        0 => "no feature was found".to_owned(),
        1 => "only 1 feature was found".to_owned(),
        found => format!("only {found} features were found"),
    };
    let gate = detection.noise_gate_factor;
    let Some((problem, settings)) = blamed(&what, wanted(burst.size()) as u64, &detection.tally, params, gate) else {
        return Ok(None);
    };
    // Slopes found before the search fit what moves.
    let is_open = |(parameter, _): &Setting| finding.is_none() || ![doc::SLOPES_U, doc::SLOPES_V].contains(parameter);
    let mut found = TooFew { problem, change: None, in_vain: Vec::new() };
    for (parameter, value) in settings.into_iter().filter(is_open) {
        let change = ParamChange::new(parameter, value);
        // What makes no sense here, or takes more memory than there is, is no advice.
        let Ok(changed) = change.applied(params) else { continue };
        let then = detect(burst, &changed, &monitor.silent());
        monitor.check()?;
        let Ok(then) = then else { continue };
        let more = then.features.len().saturating_sub(detection.features.len()) as f64;
        let by_noise = megapixels(burst.size()) * false_keypoints(&changed, f64::from(then.noise_gate_factor));
        // Twice what white noise gives, since the kinds of noise differ, and what chance adds.
        if more > (2.0 * by_noise + 3.0 * by_noise.sqrt()).max(LITTLE as f64) {
            found.change = Some((change, then.features.len()));
            break;
        }
        found.in_vain.push(change);
    }
    Ok(Some(found))
}

/// The test to blame, as a clause after `what`, and settings that may help, the likeliest first.
fn blamed(
    what: &str,
    wanted: u64,
    tally: &Tally,
    params: &DetectorParams,
    gate: f32,
) -> Option<(String, Vec<Setting>)> {
    if tally.samples == 0 {
        let octave = (params.first_octave > -1).then(|| (doc::FIRST_OCTAVE, (params.first_octave - 1).to_string()));
        let problem = format!("{what}, because the image is too small for the searched octaves");
        return Some((problem, octave.into_iter().collect()));
    }
    let advised = |test: Test| (test.record().advised)(params);
    let took = |test: Test, reached: u64| {
        let (reached, rejected) = (grouped(reached), grouped(tally.rejected_by(test)));
        format!("{what}: of {reached} samples {rejected} were rejected as {}", test.reason())
    };
    let above_peak = tally.samples.saturating_sub(tally.rejected_by(Test::PeakThreshold));
    let above = above_peak.saturating_sub(tally.rejected_by(Test::NoiseGate));
    // Too little reached the later tests, so a threshold is to blame: the peak threshold if it left the gate no noise.
    if above < SAMPLES_PER_FEATURE * wanted {
        let gated = tally.rejected_by(Test::NoiseGate) as f64 / above_peak.max(1) as f64;
        if params.peak_threshold > 0.0 && above_peak < tally.samples && gated < GATE_REJECTS_NOISE {
            let problem = format!("{} of {}", took(Test::PeakThreshold, tally.samples), params.peak_threshold);
            return Some((problem, advised(Test::PeakThreshold).into_iter().collect()));
        }
        let lower = advised(Test::NoiseGate).filter(|_| gate > LOWEST_GATE && params.method != Method::Sift);
        let other = match params.method {
            Method::Buff => {
                // Twice as wide, half of it on each side.
                let (parameter, axis) = wider_axis(&params.slopes);
                let more = axis.count.saturating_sub(1).div_ceil(2).max(1);
                (parameter, axis.with_more(more, more).to_string())
            }
            Method::Sift | Method::Merge => (doc::METHOD, Method::Buff.word().to_owned()),
        };
        let problem = format!("{} of {gate:.2} σ", took(Test::NoiseGate, above_peak));
        return Some((problem, lower.into_iter().chain([other]).collect()));
    }
    let (test, reached) = to_blame(tally)?;
    Some((took(test, reached), vec![advised(test)?]))
}

/// Test after the thresholds that most exceeds its usual share of rejections, and how many candidates reached it.
fn to_blame(tally: &Tally) -> Option<(Test, u64)> {
    let mut reached = tally.samples;
    let mut worst: Option<(f64, Test, u64)> = None;
    for test in Test::ALL {
        let passed = reached.saturating_sub(tally.rejected_by(test));
        if let Some(usual) = test.record().usual_share.filter(|_| reached > 0) {
            // Tests reject very different shares as a rule: each is compared with its usual one.
            let over_usual = passed as f64 / reached as f64 / usual;
            if over_usual < BLAMED_BELOW && worst.is_none_or(|(min, ..)| over_usual < min) {
                worst = Some((over_usual, test, reached));
            }
        }
        reached = passed;
    }
    worst.map(|(_, test, reached)| (test, reached))
}
