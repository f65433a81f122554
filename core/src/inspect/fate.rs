//! The fate of one candidate: every test of the search with its value, its limit and what beat it, in the order of the
//! search.
//!
//! A candidate is a sample that is an extremum in place and scale at its own slope, whatever its size. The first test
//! that it fails is the search's own verdict. The tests after that one are asked all the same, because what people
//! change next depends on them.

use crate::detector::keypoint::Keypoint;
use crate::detector::params::doc;
use crate::detector::{ParamChange, ParamDoc, Sample, Slope, Test};
use serde::Serialize;

/// What a test says of a candidate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Outcome {
    /// It passes.
    Passes,
    /// It fails.
    Fails,
    /// The parameters do not ask for this test.
    NotAsked,
    /// It cannot be said: the fit that the test needs did not settle.
    Unknown,
}

/// Which side of the limit passes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Side {
    /// The value must not be below the limit.
    AtLeast,
    /// The value must not be above the limit.
    AtMost,
}

/// Another sample or keypoint that stands in the way.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Rival {
    /// (u, v) at mid-burst, input pixels.
    pub pos_image: [f32; 2],
    /// Scale σ, input pixels.
    pub sigma: f32,
    /// Its slope, px/frame.
    pub slope: Slope,
    /// D there.
    pub value: f32,
    /// Index of a feature of the detection that it is; `None` for a mere sample.
    pub feature: Option<usize>,
}

/// One test of one candidate.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct TestReport {
    /// The test.
    pub test: Test,
    /// What it says.
    pub outcome: Outcome,
    /// What is compared; `None` where there is nothing to compare.
    pub value: Option<f64>,
    /// With what.
    pub limit: Option<f64>,
    /// Which side passes.
    pub side: Side,
    /// Unit of both.
    pub unit: &'static str,
    /// What beat it, or comes nearest to beating it.
    pub rival: Option<Rival>,
}

impl TestReport {
    /// By how much the value lies on the passing side of the limit, as a part of the limit: below 0 where it fails.
    /// `None` where there is no limit to speak of.
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
    /// What would keep it, as a sentence without a full stop, such as “a noise gate of 3.9 instead of 4.64”.
    pub sentence: String,
    /// The change.
    pub change: ParamChange,
    /// The next test that it fails then, if there is one.
    pub then_fails: Option<Test>,
}

/// The fate of one candidate.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Fate {
    /// Octave.
    pub octave: i32,
    /// DoG level, 0 … S−1.
    pub level: i32,
    /// Index of its slope in the grid.
    pub slope_index: usize,
    /// The sample (column, row), octave pixels.
    pub sample: [usize; 2],
    /// (u, v) at mid-burst, input pixels: the fit's place where it settled, otherwise the sample's.
    pub pos_image: [f32; 2],
    /// Scale σ, input pixels, likewise.
    pub sigma: f32,
    /// The slope, px/frame: the refined one of a feature, otherwise the grid's.
    pub slope: Slope,
    /// D at the sample.
    pub value: f32,
    /// |D| over its noise there; infinite without noise.
    pub snr: f32,
    /// σ_D at the sample.
    pub sigma_d: f32,
    /// All tests in order.
    pub tests: Vec<TestReport>,
    /// The first one that it fails: the search's verdict. `None` for what became a feature.
    pub first_failed: Option<Test>,
    /// Whether its slope is on the rim of the grid.
    pub at_slope_limit: bool,
    /// The features that it became, strongest first.
    pub features: Vec<usize>,
    /// Which keypoint of the detection it is, if it is one.
    pub keypoint: Option<usize>,
    /// What happened, as one sentence.
    pub verdict: String,
    /// What would keep it; `None` for what was kept, where no setting would, and for duplicates in a list (see
    /// [`super::remedy::duplicate_remedy`]).
    pub remedy: Option<Remedy>,
}

impl Fate {
    /// The sample.
    pub fn of_sample(&self) -> Sample {
        let [x, y] = self.sample;
        Sample { octave: self.octave, level: self.level, slope_index: self.slope_index, x, y }
    }

    /// Whether it became a feature.
    pub fn is_kept(&self) -> bool {
        self.first_failed.is_none()
    }

    /// What a test says.
    pub fn report(&self, test: Test) -> &TestReport {
        &self.tests[test as usize]
    }

    /// The tests after the first one that it fails, which it fails too.
    pub fn fails_later(&self) -> impl Iterator<Item = Test> + '_ {
        let after = self.first_failed.map_or(Test::ALL.len(), |test| test as usize + 1);
        self.tests[after.min(self.tests.len())..].iter().filter(|t| t.outcome == Outcome::Fails).map(|t| t.test)
    }
}

/// The parameter that a test compares with; `None` for those that have none.
pub fn parameter_of(test: Test) -> Option<ParamDoc> {
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
