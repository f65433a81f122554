//! The fate of one candidate: every test of the search with its value, its limit and its rival, in the order of the
//! search. The first test that it fails is the search's own verdict; the later ones decide what to change next.

use crate::detector::{ParamChange, Sample, Slope, Test};
use crate::detector::{feature::Keypoint, test::Side};
use crate::inspect::words::{filled, number, slope_text, snr_text, value_text};
use serde::Serialize;

/// Outcome of a test of a candidate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Outcome {
    /// The candidate passes.
    Passes,
    /// The candidate fails.
    Fails,
    /// The parameters switch this test off.
    NotAsked,
    /// Unknown, because the fit that the test needs did not converge.
    Unknown,
}

/// Another sample or keypoint that beats a candidate.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Rival {
    /// (u, v) at mid-burst, input pixels.
    pub pos_image: [f32; 2],
    /// Scale σ, input pixels.
    pub sigma: f32,
    /// Slope, px/frame.
    pub slope: Slope,
    /// D at the rival.
    pub value: f32,
    /// Index of the feature of the detection, if the rival is one; `None` for a mere sample.
    pub feature: Option<usize>,
}

impl Rival {
    /// “feature 3”, or “another keypoint”.
    pub fn name(&self) -> String {
        self.feature.map_or_else(|| "another keypoint".to_owned(), |index| format!("feature {index}"))
    }
}

/// One test of one candidate.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct TestReport {
    /// The test.
    pub test: Test,
    /// Outcome of the test.
    pub outcome: Outcome,
    /// Value that is compared; `None` where there is none.
    pub value: Option<f64>,
    /// Limit that it is compared with.
    pub limit: Option<f64>,
    /// Side of the limit that passes.
    pub side: Side,
    /// Unit of value and limit.
    pub unit: &'static str,
    /// Rival that beats the candidate, or comes nearest to it.
    pub rival: Option<Rival>,
}

impl TestReport {
    pub(super) fn new(test: Test, outcome: Outcome, value: Option<f64>, limit: Option<f64>) -> Self {
        let record = test.record();
        Self { test, outcome, value, limit, side: record.side, unit: record.unit, rival: None }
    }

    /// The distance of the value from the limit, as a part of the limit: below 0 where the test fails.
    pub fn margin(&self) -> Option<f64> {
        let (value, limit) = (self.value?, self.limit.filter(|limit| *limit != 0.0)?);
        Some(if self.side == Side::AtLeast { value / limit - 1.0 } else { 1.0 - value / limit })
    }

    /// The margin in percent; empty without one, and from 1000 % on.
    pub fn margin_text(&self) -> String {
        let percent = self.margin().map_or(f64::NAN, |margin| (100.0 * margin).round());
        let sign = if percent > 0.0 { "+" } else { "" };
        if percent.abs() < 1000.0 { format!("{sign}{} %", number(percent as f32, 0)) } else { String::new() }
    }

    /// The limit after the sign of the side that passes; empty without one.
    pub fn limit_text(&self) -> String {
        self.limit.map_or_else(String::new, |limit| format!("{} {}", self.side.sign(), value_text(limit)))
    }

    /// The test and its outcome in words, with the numbers that were compared; a clause without a full stop.
    pub fn sentence(&self) -> String {
        let record = self.test.record();
        let is_off = self.limit.is_none_or(|limit| limit <= 0.0) && self.rival.is_none();
        let template = match self.outcome {
            Outcome::Passes if !record.passes.is_empty() => record.passes,
            Outcome::Passes => record.fails,
            Outcome::Fails => self.unless_boundless(record.fails),
            Outcome::NotAsked if is_off => record.off,
            Outcome::NotAsked => record.waived[usize::from(self.limit > self.value)],
            Outcome::Unknown => record.unknown,
        };
        filled(template, |word| self.word(word))
    }

    /// `sentence`, or the one for a candidate without a finite value.
    pub(super) fn unless_boundless(&self, sentence: &'static str) -> &'static str {
        let boundless = self.test.record().boundless;
        if self.value.is_some_and(f64::is_finite) || boundless.is_empty() { sentence } else { boundless }
    }

    /// The text in place of a word in braces in the sentences of [`crate::detector::test::TestRecord`].
    pub(super) fn word(&self, name: &str) -> String {
        let (value, limit) = (self.value.unwrap_or(f64::NAN), self.limit.unwrap_or(f64::NAN));
        match (name, self.rival) {
            ("value", _) => value_text(value),
            ("value.1", _) => number(value as f32, 1),
            ("|D|", _) if value >= 0.01 => number(value as f32, 4),
            ("|D|", _) => format!("{value:.2e}"),
            ("limit", _) => value_text(limit),
            ("by", _) => self.margin().filter(|margin| margin.is_finite()).map_or_else(String::new, |margin| {
                format!(": {:.0} % {}", 100.0 * margin.abs(), if margin < 0.0 { "too little" } else { "more" })
            }),
            // A rival's response is the limit.
            ("times", _) => number((limit / value) as f32, 2),
            ("responds", _) if limit / value > 1.0 && limit / value < 100.0 => {
                format!("responds {} times as strongly", self.word("times"))
            }
            ("responds", _) => "responds as strongly or more".to_owned(),
            ("rival", Some(rival)) => rival.name(),
            ("slope", Some(rival)) => slope_text(rival.slope),
            ("sigma", Some(rival)) => number(rival.sigma, 1),
            ("u", Some(rival)) => number(rival.pos_image[0], 1),
            ("v", Some(rival)) => number(rival.pos_image[1], 1),
            _ => String::new(),
        }
    }
}

/// The one setting that would keep a candidate.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Remedy {
    /// Setting as a sentence without a full stop, such as “a noise gate of 3.9 instead of 4.64”.
    pub sentence: String,
    /// Change that applies it.
    pub change: ParamChange,
    /// Next test that it would then fail, if any.
    pub then_fails: Option<Test>,
}

/// Edge on which a candidate lies.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct OnEdge {
    /// Direction (u, v) of the edge, of length 1.
    pub direction: [f32; 2],
    /// Whether it runs along the candidate's motion, or along the searched line of slopes: all slopes show it alike.
    pub along_motion: bool,
}

/// The fate of one candidate.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Fate {
    /// Octave of the sample.
    pub octave: i32,
    /// DoG level, 0 … S−1.
    pub level: i32,
    /// Index of its slope in the grid.
    pub slope_index: usize,
    /// The sample (column, row), octave pixels.
    pub sample: [usize; 2],
    /// (u, v) at mid-burst, input pixels: the fit's position where it converged, otherwise the sample's.
    pub pos_image: [f32; 2],
    /// Scale σ, input pixels, of the fit or the sample likewise.
    pub sigma: f32,
    /// Slope, px/frame: the refined one of a feature, otherwise the grid's.
    pub slope: Slope,
    /// Slope, px/frame, that it would have as a keypoint: between those of the grid where the fit converged.
    #[serde(skip)]
    pub would_move: Slope,
    /// The edge that it lies on, where the fit did not converge or the candidate fails the test of edges.
    pub edge: Option<OnEdge>,
    /// D at the sample.
    pub value: f32,
    /// |D| over its noise there; infinite without noise.
    pub snr: f32,
    /// σ_D at the sample.
    pub sigma_d: f32,
    /// Reports of all tests in order.
    pub tests: Vec<TestReport>,
    /// First test that it fails: the search's verdict. `None` for a candidate that became a feature.
    pub first_failed: Option<Test>,
    /// Whether it is at the limit of the slopes; of one that became no feature, whether it is on their rim.
    pub at_slope_limit: bool,
    /// Indices of the features that it became, strongest first.
    pub features: Vec<usize>,
    /// Index of the detection's keypoint that it became, if any.
    pub keypoint: Option<usize>,
    /// Verdict as one sentence.
    pub verdict: String,
    /// Setting that would keep it; `None` for a kept candidate, where none would, and for duplicates in a list.
    pub remedy: Option<Remedy>,
}

impl Fate {
    /// The candidate's sample.
    pub fn of_sample(&self) -> Sample {
        let [x, y] = self.sample;
        Sample { octave: self.octave, level: self.level, slope_index: self.slope_index, x, y }
    }

    /// Whether it became a feature.
    pub fn is_kept(&self) -> bool {
        self.first_failed.is_none()
    }

    /// The report of a test.
    pub fn report(&self, test: Test) -> &TestReport {
        &self.tests[test as usize]
    }

    /// Response over its noise in words: below the noise gate the ratio that the gate compared.
    pub fn snr_text(&self) -> String {
        let gated = (self.first_failed == Some(Test::NoiseGate)).then(|| self.report(Test::NoiseGate).value);
        gated.flatten().map_or_else(|| snr_text(self.snr), value_text)
    }

    /// Further failed tests, after the first.
    pub fn fails_later(&self) -> impl Iterator<Item = Test> + '_ {
        let after = self.first_failed.map_or(Test::ALL.len(), |test| test as usize + 1);
        self.tests[after.min(self.tests.len())..].iter().filter(|t| t.outcome == Outcome::Fails).map(|t| t.test)
    }
}

/// The distance of two keypoints in σ of the first.
pub(super) fn apart_sigmas(stronger: &Keypoint, other: &Keypoint) -> f32 {
    let ((su, sv, sigma), (u, v, _)) = (stronger.in_image(), other.in_image());
    (su - u).hypot(sv - v) / sigma
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tests_are_sentences_with_their_numbers() {
        use Outcome::{Fails, NotAsked, Passes, Unknown};
        let rival =
            Rival { pos_image: [3.0, 4.0], sigma: 2.0, slope: Slope::new(1.5, 0.0), value: 0.0036, feature: Some(9) };
        let nan = f64::NAN;
        let responds = "slope 1.5 responds 1.8 times as strongly";
        let waived = format!("{responds}; not required, because each slope is searched for itself");
        for (test, outcome, value, limit, sentence) in [
            (Test::SlopeExtremum, NotAsked, 0.002, 0.0036, &*waived),
            (Test::SlopeExtremum, NotAsked, 0.0036, 0.002, "all other slopes respond less; not required"),
            (Test::SlopeExtremum, NotAsked, 0.0036, -0.002, "all other slopes respond less; not required"),
            (Test::SlopeExtremum, NotAsked, 0.0036, nan, "there is no other slope"),
            (Test::SlopeExtremum, Fails, 0.002, 0.0036, responds),
            (Test::NoiseGate, Fails, 3.28, 4.0, "3.28 σ of its noise, 4 σ is required: 18 % too little"),
            (Test::NoiseGate, Passes, 5.0, 4.0, "5 σ of its noise, 4 σ is required: 25 % more"),
            (Test::NoiseGate, NotAsked, 5.0, 0.0, "no noise gate is set"),
            (Test::ScaleExtremum, Fails, 0.002, 0.002, "a neighbour at the next scale responds as strongly or more"),
            (Test::Edge, Fails, 45.9, 12.0, "one curvature is 45.9 times the other; 12 is allowed"),
            (Test::Edge, Unknown, nan, 12.0, "unknown, because the fit did not settle"),
            (Test::Refinement, Fails, nan, 1.5, "the fit has no peak"),
            (Test::Duplicate, Fails, 0.4, 1.25, "feature 9, 0.4 σ away, stands for this blob; 1.25 σ makes two"),
            (Test::Duplicate, NotAsked, nan, 1.25, "not tested: weaker than the strongest that are kept"),
            (Test::MaxFeatures, Fails, 501.0, 500.0, "number 501 by strength; 500 are kept"),
            (Test::MaxFeatures, Unknown, nan, 500.0, "it became no keypoint"),
        ] {
            let [value, limit] = [value, limit].map(|x| Some(x).filter(|x| x.is_finite()));
            let of_others = matches!(test, Test::SlopeExtremum | Test::ScaleExtremum | Test::Duplicate);
            let rival = Some(rival).filter(|_| of_others && limit.is_some());
            assert_eq!(TestReport { rival, ..TestReport::new(test, outcome, value, limit) }.sentence(), sentence);
        }
    }

    #[test]
    fn margins_are_percents_with_a_real_minus_and_nothing_where_they_say_nothing() {
        let of = |margin: f64| TestReport::new(Test::NoiseGate, Outcome::Passes, Some(1.0 + margin), Some(1.0));
        for (margin, text) in
            [(0.25, "+25 %"), (-0.081, "−8 %"), (0.0, "0 %"), (-0.003, "0 %"), (12.0, ""), (f64::INFINITY, "")]
        {
            assert_eq!(of(margin).margin_text(), text);
        }
        let edge = TestReport::new(Test::Edge, Outcome::Passes, None, Some(4.64));
        assert_eq!([of(0.0).limit_text(), edge.limit_text(), edge.margin_text()], ["≥ 1", "≤ 4.64", ""]);
    }
}
