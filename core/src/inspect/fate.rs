//! The fate of one candidate: every test of the search with its value, its limit and its rival, in the order of the
//! search.
//!
//! A candidate is a sample that is an extremum in place and scale at its own slope, whatever its size. The first test
//! that it fails is the search's own verdict. The later tests are also evaluated, because they decide what to change
//! next.

use crate::detector::feature::Keypoint;
use crate::detector::params::doc;
use crate::detector::{DetectorParams, Param, ParamChange, Sample, Slope, Test};
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

/// Side of the limit that passes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Side {
    /// The value must not be below the limit.
    AtLeast,
    /// The value must not be above the limit.
    AtMost,
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
    /// The distance of the value from the limit on the passing side, as a part of the limit: below 0 where the test
    /// fails. `None` for tests without a limit.
    pub fn margin(&self) -> Option<f64> {
        let (value, limit) = (self.value?, self.limit?);
        if limit == 0.0 {
            return None;
        }
        Some(match self.side {
            Side::AtLeast => value / limit - 1.0,
            Side::AtMost => 1.0 - value / limit,
        })
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
    /// Setting that would keep it; `None` for a kept candidate, where no setting would, and for duplicates in a list
    /// (see [`super::remedy::duplicate_remedy`]).
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

    /// The tests after the first failed one that it also fails.
    pub fn fails_later(&self) -> impl Iterator<Item = Test> + '_ {
        let after = self.first_failed.map_or(Test::ALL.len(), |test| test as usize + 1);
        self.tests[after.min(self.tests.len())..].iter().filter(|t| t.outcome == Outcome::Fails).map(|t| t.test)
    }
}

/// The parameter that a test compares with; `None` for tests without one.
pub fn parameter_of(test: Test) -> Option<Param<DetectorParams>> {
    match test {
        Test::PeakThreshold | Test::InterpolatedContrast => Some(doc::PEAK_THRESHOLD),
        Test::NoiseGate => Some(doc::NOISE_GATE),
        Test::SlopeExtremum => Some(doc::SLOPE_EXTREMA),
        Test::Edge => Some(doc::EDGE_THRESHOLD),
        Test::Duplicate => Some(doc::DISTINCT),
        Test::MaxFeatures => Some(doc::MAX_FEATURES),
        Test::SpaceExtremum | Test::ScaleExtremum | Test::Refinement | Test::Outside => None,
    }
}

/// The distance of two keypoints in σ of the first.
pub(super) fn apart_sigmas(stronger: &Keypoint, other: &Keypoint) -> f32 {
    let ((su, sv, sigma), (u, v, _)) = (stronger.in_image(), other.in_image());
    (su - u).hypot(sv - v) / sigma
}
