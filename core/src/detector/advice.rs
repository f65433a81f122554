//! Advice on a detection with few or no features: the reason, and a setting to change. A good detection rejects nearly
//! every sample too, so each test's share of rejected candidates is compared with its usual one; the test that exceeds
//! it most is to blame. (Whether the slopes fit is judged in `inspect::slopes`.)

use super::feature::{Detection, Tally, Test};
use super::params::{DetectorParams, Method, Param, SearchParams, Word, doc};
use super::test::{LOWEST_GATE, wider_axis};

/// Reason for a poor detection, and a setting to change.
#[derive(Debug, Clone, PartialEq)]
pub struct Advice {
    /// The reason: a clause without a capital at its start or a full stop at its end.
    pub problem: String,
    /// Parameter to change.
    pub parameter: Param<SearchParams>,
    /// Its new value, as the command line takes it.
    pub value: String,
}

impl Advice {
    /// Sentence for the command line, which names the option.
    pub fn for_command(&self) -> String {
        format!("{}; try --{} {}", self.problem, self.parameter.name, self.value)
    }

    /// Sentence for the window, which names the parameter by its label.
    pub fn for_window(&self) -> String {
        format!("{}; try {} {}", capitalised(&self.problem), self.parameter.label, self.value)
    }
}

/// Fewer features than this in a million pixels are too few.
const LITTLE_PER_MEGAPIXEL: f64 = 50.0;
/// Fewer features than this are too few in an image of any size.
const LITTLE: usize = 8;
/// Minimum number of samples above both thresholds for one feature: usually one of 650 to 1000 became a keypoint.
const SAMPLES_PER_FEATURE: u64 = 500;
/// A test that lets pass less than this fraction of its usual share is to blame.
const BLAMED_BELOW: f64 = 0.5;
/// Gate's share of rejected samples below which the peak threshold before it had already taken the noise.
const GATE_REJECTS_NOISE: f64 = 0.999;

/// Explains why `detection`, found with `params` in images of `size` (columns, rows), has few or no features; `None`
/// where it has enough, or where the parameters ask for few.
pub fn explain(detection: &Detection, params: &DetectorParams, size: (usize, usize)) -> Option<Advice> {
    let found = detection.features.len();
    let wanted = LITTLE.max((LITTLE_PER_MEGAPIXEL * 1e-6 * size.0 as f64 * size.1 as f64) as usize);
    if found >= wanted || detection.tally.rejected_by(Test::MaxFeatures) > 0 {
        return None;
    }
    let what = match found {
        0 => "no feature was found".to_owned(),
        1 => "only 1 feature was found".to_owned(),
        _ => format!("only {found} features were found"),
    };
    little(&what, wanted as u64, &detection.tally, params, detection.noise_gate_factor)
}

/// Advice where there are few or no features.
fn little(what: &str, wanted: u64, tally: &Tally, params: &DetectorParams, gate: f32) -> Option<Advice> {
    let advice =
        |problem: String, parameter: Param<SearchParams>, value: String| Some(Advice { problem, parameter, value });
    if tally.samples == 0 {
        let problem = format!("{what}, because the image is too small for the searched octaves");
        return advice(problem, doc::FIRST_OCTAVE, (params.first_octave - 1).max(-1).to_string());
    }
    let took = |test: Test, reached: u64| {
        let (reached, rejected) = (grouped(reached), grouped(tally.rejected_by(test)));
        format!("{what}: of {reached} samples {rejected} were rejected as {}", test.reason())
    };
    let above_peak = tally.samples.saturating_sub(tally.rejected_by(Test::PeakThreshold));
    let above = above_peak.saturating_sub(tally.rejected_by(Test::NoiseGate));
    if above < SAMPLES_PER_FEATURE * wanted {
        let gated = tally.rejected_by(Test::NoiseGate) as f64 / above_peak.max(1) as f64;
        if params.peak_threshold > 0.0 && above_peak < tally.samples && gated < GATE_REJECTS_NOISE {
            let problem = took(Test::PeakThreshold, tally.samples);
            return advice(format!("{problem} of {}", params.peak_threshold), doc::PEAK_THRESHOLD, "0".to_owned());
        }
        let problem = format!("{} of {gate:.2} σ", took(Test::NoiseGate, above_peak));
        return match params.method {
            Method::Buff | Method::Merge if gate > LOWEST_GATE => {
                advice(problem, doc::NOISE_GATE, LOWEST_GATE.to_string())
            }
            Method::Buff => {
                // Twice as wide.
                let (parameter, axis) = wider_axis(&params.slopes);
                let more = axis.count.saturating_sub(1).div_ceil(2).max(1);
                advice(problem, parameter, axis.with_more(more, more).to_string())
            }
            Method::Sift | Method::Merge => advice(problem, doc::METHOD, Method::Buff.word().to_owned()),
        };
    }
    let (test, reached) = to_blame(tally)?;
    let (parameter, value) = (test.record().advised)(params)?;
    advice(took(test, reached), parameter, value)
}

/// The test after the thresholds that most exceeds its usual share of rejections, and how many candidates reached it.
fn to_blame(tally: &Tally) -> Option<(Test, u64)> {
    let mut reached = tally.samples;
    let mut worst: Option<(f64, Test, u64)> = None;
    for test in Test::ALL {
        let passed = reached.saturating_sub(tally.rejected_by(test));
        if let Some(usual) = test.record().usual_share.filter(|_| reached > 0) {
            let over_usual = passed as f64 / reached as f64 / usual;
            if over_usual < BLAMED_BELOW && worst.is_none_or(|(min, ..)| over_usual < min) {
                worst = Some((over_usual, test, reached));
            }
        }
        reached = passed;
    }
    worst.map(|(_, test, reached)| (test, reached))
}

/// `text` with a capital at its start.
pub fn capitalised(text: &str) -> String {
    let mut chars = text.chars();
    chars.next().map_or_else(String::new, |first| first.to_uppercase().chain(chars).collect())
}

/// A count as text, with a space between groups of three digits: 12345678 becomes "12 345 678".
pub fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::with_capacity(digits.len() * 4 / 3);
    for (k, digit) in digits.chars().enumerate() {
        if k > 0 && (digits.len() - k).is_multiple_of(3) {
            text.push(' ');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Advice where no feature was found in 10 million samples, of which `rejected` were.
    fn advice(params: &DetectorParams, gate: f32, rejected: &[(Test, u64)]) -> Option<Advice> {
        let mut tally = Tally { samples: 10_000_000, ..Tally::default() };
        rejected.iter().for_each(|&(test, count)| tally.reject(test, count));
        little("no feature was found", 50, &tally, params, gate)
    }

    #[test]
    fn the_test_that_took_more_than_usual_is_named_with_a_setting_that_sees_more() {
        let params = DetectorParams::default();
        let peak = DetectorParams { peak_threshold: 0.0003, ..params.clone() };
        let sift = DetectorParams { method: Method::Sift, ..params.clone() };
        let gate = [(Test::NoiseGate, 9_999_990), (Test::SpaceExtremum, 10)];
        let above = [(Test::NoiseGate, 9_900_000), (Test::SpaceExtremum, 95_000), (Test::ScaleExtremum, 2_000)];
        let with = |more: &[(Test, u64)]| [&above[..], more].concat();
        for (params, factor, rejected, parameter, value, words) in [
            // Where the gate had nothing left to do, the peak threshold is to blame; where that let noise pass, it is.
            (
                &peak,
                4.96,
                vec![(Test::PeakThreshold, 9_999_926), (Test::NoiseGate, 60), (Test::SpaceExtremum, 14)],
                doc::PEAK_THRESHOLD,
                "0",
                "of 10 000 000 samples 9 999 926 were rejected as below the peak threshold of 0.0003",
            ),
            (
                &peak,
                4.96,
                vec![(Test::PeakThreshold, 4_000_000), (Test::NoiseGate, 5_999_990), (Test::SpaceExtremum, 10)],
                doc::NOISE_GATE,
                "4",
                "of 6 000 000 samples 5 999 990 were rejected as below the noise gate of 4.96 σ",
            ),
            (&sift, 4.96, gate.to_vec(), doc::METHOD, "buff", "noise gate"),
            (&params, 3.5, gate.to_vec(), doc::SLOPES_U, "-6:6:13", "noise gate"),
            (
                &params,
                4.96,
                with(&[(Test::SlopeExtremum, 1_000), (Test::Edge, 1_990)]),
                doc::EDGE_THRESHOLD,
                "18",
                "of 2 000 samples 1 990 were rejected as on an edge",
            ),
            (&params, 4.96, with(&[(Test::SlopeExtremum, 2_990)]), doc::SLOPES_U, "-3:3:4", "in slope"),
        ] {
            let found = advice(params, factor, &rejected).expect("advice");
            assert_eq!((found.parameter, found.value.as_str()), (parameter, value), "{}", found.problem);
            assert!(found.problem.starts_with("no feature was found: of ") && found.problem.contains(words));
            assert_eq!(found.for_command(), format!("{}; try --{} {value}", found.problem, parameter.name));
        }
    }
}
