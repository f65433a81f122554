//! Tests that a sample of D passes on its way to a feature, in order: one record each.
//!
//! The search decides (`search`, then `refine`, then `distinct`). The rest of the program reads what it knows of a test
//! here; the value and the limit of one candidate come from [`crate::inspect::place`].
//!
//! Words in braces stand for numbers of the candidate: `crate::inspect::place::TestReport::word` has those of all
//! sentences, `remedy` those of verdicts and remedies.

use super::params::slope_grid::{SlopeAxis, SlopeGrid};
use super::params::{DetectorParams, Distinct, Param, SearchParams, doc};
use serde::{Deserialize, Serialize, Serializer};
use strum::{EnumCount, VariantArray};

/// Test of a sample of D, in the order in which the search applies them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, EnumCount, VariantArray)]
#[serde(rename_all = "snake_case")]
pub enum Test {
    /// |D| is below 0.8 times the peak threshold.
    PeakThreshold,
    /// |D| is below a part of the noise gate, or its refined value below the gate.
    NoiseGate,
    /// A neighbour in the image at its own slope and level is as strong.
    SpaceExtremum,
    /// A neighbour at an adjacent level is as strong; in octaves after the first, clearly stronger.
    ScaleExtremum,
    /// A neighbour at another slope is as strong.
    SlopeExtremum,
    /// The quadratic fit or the ascent did not converge, or leads to another level.
    Refinement,
    /// The interpolated |D| is below the peak threshold.
    InterpolatedContrast,
    /// The principal curvatures differ too much.
    Edge,
    /// The refined place is outside the image or the refined scale outside the octave.
    Outside,
    /// Too many samples of the feature's disc are masked.
    Seen,
    /// A stronger keypoint stands for the same blob.
    Duplicate,
    /// Its features are weaker than the strongest `max_features`. Weaker keypoints skip the test before.
    MaxFeatures,
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

impl Side {
    /// Sign between value and limit.
    pub fn sign(self) -> char {
        if self == Self::AtLeast { '≥' } else { '≤' }
    }
}

type Setting = (Param<SearchParams>, String);

/// Record of a test. Sentences are clauses without a capital at their start or a full stop at their end.
#[derive(Debug)]
pub struct TestRecord {
    /// Reason why a sample failed, in words.
    pub reason: &'static str,
    /// Name in a table of values, with the unit of the values.
    pub name: &'static str,
    /// Name in a list.
    pub short: &'static str,
    /// Side of the limit that passes.
    pub side: Side,
    /// Unit of value and limit.
    pub unit: &'static str,
    /// Sentence on a candidate that passes; empty where `fails` serves both.
    pub passes: &'static str,
    /// Sentence on a candidate that fails.
    pub fails: &'static str,
    /// Sentence on a candidate that fails without a finite value.
    pub boundless: &'static str,
    /// Sentence where the parameters switch the test off.
    pub off: &'static str,
    /// Sentences where the test has a limit, but is not applied: for a passing and for a failing value.
    pub waived: [&'static str; 2],
    /// Sentence where the test cannot be decided.
    pub unknown: &'static str,
    /// Verdict on a candidate that fails this test first.
    pub verdict: &'static str,
    /// Parameter that sets the limit.
    pub parameter: Option<Param<SearchParams>>,
    /// Setting by which a candidate passes.
    pub remedy: &'static str,
    /// Usual share of passing candidates in a detection that finds enough. Measured without a peak threshold on a
    /// chart, the demo, two trajectories and two real scenes, all dark: they differ by a fifth at most, by a third for
    /// slopes. `None` for the thresholds, which are judged apart, and for the maximum number of features.
    pub usual_share: Option<f64>,
    /// Setting to change where the test rejects too much; `None` where none would help.
    pub advised: fn(&DetectorParams) -> Option<Setting>,
}

/// Record of an imaginary test, as the default of fields that a record leaves out.
const NONE: TestRecord = TestRecord {
    reason: "",
    name: "",
    short: "",
    side: Side::AtLeast,
    unit: "of full scale",
    passes: "",
    fails: "",
    boundless: "",
    off: "",
    waived: [""; 2],
    unknown: "unknown, because the fit did not settle",
    verdict: "",
    parameter: None,
    remedy: "",
    usual_share: None,
    advised: |_| None,
};

/// Gate factor below which so much noise passes that lowering it further does not help.
pub(crate) const LOWEST_GATE: f32 = 4.0;

static RECORDS: [TestRecord; Test::ALL.len()] = [
    TestRecord {
        reason: "below the peak threshold",
        name: "peak threshold",
        short: "peak threshold",
        fails: "|D| is {value}, {limit} is required{by}",
        off: "no peak threshold is set",
        verdict: "below the peak threshold: |D| is {|D|}, at least 0.8 of {threshold} is required",
        parameter: Some(doc::PEAK_THRESHOLD),
        remedy: "a peak threshold of {new} instead of {was}",
        advised: no_peak_threshold,
        ..NONE
    },
    TestRecord {
        reason: "below the noise gate",
        name: "noise gate, σ",
        short: "noise gate",
        unit: doc::NOISE_GATE.doc.unit,
        fails: "{value} σ of its noise, {limit} σ is required{by}",
        off: "no noise gate is set",
        verdict: "below the noise gate: {value} σ of {limit} σ",
        parameter: Some(doc::NOISE_GATE),
        remedy: "a noise gate of {new} instead of {was}",
        advised: |_| Some((doc::NOISE_GATE, LOWEST_GATE.to_string())),
        ..NONE
    },
    TestRecord {
        reason: "not an extremum in space",
        name: "extremum in space",
        short: "in space",
        passes: "all neighbours in the picture respond less",
        fails: "a neighbour in the picture {responds}",
        verdict: "a neighbour in the image is as strong",
        usual_share: Some(0.04),
        ..NONE
    },
    TestRecord {
        reason: "not an extremum in scale",
        name: "extremum in scale",
        short: "in scale",
        passes: "all neighbours at the next scales respond less",
        fails: "a neighbour at the next scale {responds}",
        verdict: "a neighbour at an adjacent level is as strong",
        usual_share: Some(0.09),
        advised: other_levels,
        ..NONE
    },
    TestRecord {
        reason: "not an extremum in slope",
        name: "extremum in slope",
        short: "in slope",
        passes: "the slopes compared respond less",
        fails: "slope {slope} {responds}",
        off: "there is no other slope",
        waived: [
            "all other slopes respond less; not required",
            "slope {slope} {responds}; not required, because each slope is searched for itself",
        ],
        verdict: "beaten by slope {slope} {where}, {times} times as strong: {cause}",
        parameter: Some(doc::SLOPE_EXTREMA),
        remedy: "each slope for itself instead of joint extrema",
        usual_share: Some(0.3),
        advised: |params| {
            let (parameter, axis) = wider_axis(&params.slopes);
            (axis.count > 3).then(|| (parameter, SlopeAxis { count: axis.count.div_ceil(2), ..axis }.to_string()))
        },
        ..NONE
    },
    TestRecord {
        reason: "without a fit that settles",
        name: "fit settles, samples",
        short: "fit settles",
        side: Side::AtMost,
        unit: "samples",
        passes: "the fit settles {value} samples away; {limit} are allowed",
        fails: "the fit does not settle: its peak is {value} samples away; {limit} are allowed",
        boundless: "the fit has no peak",
        verdict: "the fit did not settle: its peak is {value.1} samples away",
        usual_share: Some(0.97),
        advised: other_levels,
        ..NONE
    },
    TestRecord {
        reason: "interpolated contrast below the threshold",
        name: "interpolated contrast",
        short: "fit's contrast",
        fails: "|D| of the fit is {value}, {limit} is required{by}",
        off: "no peak threshold is set",
        verdict: "below the peak threshold after interpolation: |D| is {|D|} of {threshold}",
        parameter: Some(doc::PEAK_THRESHOLD),
        remedy: "a peak threshold of {new} instead of {was}",
        usual_share: Some(0.99),
        advised: no_peak_threshold,
        ..NONE
    },
    TestRecord {
        reason: "on an edge",
        name: "no edge, curvature ratio",
        short: "edge",
        side: Side::AtMost,
        unit: "",
        fails: "one curvature is {value} times the other; {limit} is allowed",
        boundless: "a saddle: bright along one direction and dark along the other",
        verdict: "on an edge: one curvature is {value.1} times the other, at most {threshold} is allowed",
        parameter: Some(doc::EDGE_THRESHOLD),
        remedy: "an edge threshold of {new} instead of {was}",
        usual_share: Some(0.93),
        advised: |params| Some((doc::EDGE_THRESHOLD, (1.5 * params.edge_threshold).to_string())),
        ..NONE
    },
    TestRecord {
        reason: "outside the image or the scales",
        name: "inside, samples from the end",
        short: "inside",
        unit: "samples",
        passes: "the fit lies inside the image and the scales",
        fails: "the fit lies outside the image or the scales of its octave",
        verdict: "the fit lies outside the image or the scales of its octave",
        parameter: Some(doc::FIRST_OCTAVE),
        remedy: "it is finer than the first octave: a first octave of {new} instead of {was}",
        usual_share: Some(0.99),
        advised: |params| {
            (params.first_octave > -1).then(|| (doc::FIRST_OCTAVE, (params.first_octave - 1).to_string()))
        },
        ..NONE
    },
    TestRecord {
        reason: "masked",
        name: "seen, share of its disc",
        short: "seen",
        unit: "",
        fails: "{value} of its disc is seen; {limit} is required",
        off: "nothing is masked",
        verdict: "masked: {value} of its disc is seen in the frames, {limit} is required",
        ..NONE
    },
    TestRecord {
        reason: "the same blob as a stronger one",
        name: "distinct, σ from another",
        short: "distinct",
        unit: doc::DISTINCT.doc.unit,
        passes: "no other keypoint stands for this blob",
        fails: "{rival}, {value} σ away, stands for this blob; {limit} σ makes two",
        off: "duplicates are kept",
        waived: ["not tested: weaker than the strongest that are kept"; 2],
        verdict: "the same blob as {rival} at ({u}, {v}) with σ {sigma} and slope {slope}, {value} σ away",
        parameter: Some(doc::DISTINCT),
        remedy: "{name} {new} instead of {was} would keep both",
        usual_share: Some(0.45),
        advised: |_| Some((doc::DISTINCT, Distinct::Off.to_string())),
        ..NONE
    },
    TestRecord {
        reason: "weaker than the strongest kept",
        name: "among the strongest",
        short: "strongest",
        side: Side::AtMost,
        unit: "features",
        fails: "number {value} by strength; {limit} are kept",
        off: "the number of features is not limited",
        unknown: "it became no keypoint",
        verdict: "weaker than the strongest {limit} that are kept: it is number {value}",
        parameter: Some(doc::MAX_FEATURES),
        remedy: "max features {new} instead of {was}",
        ..NONE
    },
];

fn no_peak_threshold(params: &DetectorParams) -> Option<Setting> {
    (params.peak_threshold > 0.0).then(|| (doc::PEAK_THRESHOLD, "0".to_owned()))
}

/// More levels make neighbours more alike in scale, fewer make them differ.
fn other_levels(params: &DetectorParams) -> Option<Setting> {
    Some((doc::LEVELS, if params.levels > 3 { "3" } else { "4" }.to_owned()))
}

pub(crate) fn wider_axis(grid: &SlopeGrid) -> (Param<SearchParams>, SlopeAxis) {
    if grid.v.count > grid.u.count { (doc::SLOPES_V, grid.v) } else { (doc::SLOPES_U, grid.u) }
}

impl Test {
    /// All tests, in order.
    pub const ALL: [Self; Self::COUNT] = *Self::VARIANTS.first_chunk().expect("as many");

    /// Record of this test.
    pub fn record(self) -> &'static TestRecord {
        &RECORDS[self as usize]
    }

    /// Reason why a sample failed: see [`TestRecord::reason`].
    pub fn reason(self) -> &'static str {
        self.record().reason
    }

    /// Whether a sample that fails this test first is a candidate: an extremum at its own slope.
    pub fn takes_candidates(self) -> bool {
        !matches!(self, Self::SpaceExtremum | Self::ScaleExtremum)
    }
}

/// Fate of samples at slopes that a search around the field of motion leaves out.
pub const NOT_SEARCHED: &str = "not searched here at this slope";

/// Numbers of samples by the first test that rejected them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct Tally {
    /// Number of samples of D that were examined: over all octaves the pixels (except each border's outermost, which
    /// lack neighbours) × the levels with one above and one below × the slopes searched there.
    pub samples: u64,
    /// Number of samples left out at their slope by [`SearchSlopes::Field`](crate::detector::SearchSlopes::Field).
    #[serde(skip_serializing_if = "is_zero")]
    pub not_searched: u64,
    /// Number of keypoints that passed every test; a keypoint may have several features.
    pub kept: u64,
    /// Number of samples that each test rejected, in the order of [`Test::ALL`].
    #[serde(serialize_with = "by_test")]
    pub rejected: [u64; Test::ALL.len()],
}

fn is_zero(count: &u64) -> bool {
    *count == 0
}

fn by_test<S: Serializer>(rejected: &[u64; Test::ALL.len()], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_map(Test::ALL.into_iter().zip(rejected))
}

impl Tally {
    /// Number of samples that `test` rejected.
    pub fn rejected_by(&self, test: Test) -> u64 {
        self.rejected[test as usize]
    }

    /// Counts `count` samples as rejected by `test`.
    pub fn reject(&mut self, test: Test, count: u64) {
        self.rejected[test as usize] += count;
    }

    /// Adds another tally, such as that of another tile or slope.
    pub fn merge(&mut self, other: &Self) {
        self.samples += other.samples;
        self.not_searched += other.not_searched;
        self.kept += other.kept;
        self.rejected.iter_mut().zip(other.rejected).for_each(|(mine, theirs)| *mine += theirs);
    }
}
