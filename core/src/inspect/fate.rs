//! The fate of one candidate: every test of the search with its value, its limit and its rival, in the order of the
//! search.
//!
//! A candidate is a sample that is an extremum in place and scale at its own slope, whatever its size. The first test
//! that it fails is the search's own verdict ([`crate::detector::Judgement`]); only the explanation of a verdict is
//! computed here. The later tests are also evaluated, because they decide what to change next.

use crate::detector::keypoint::Keypoint;
use crate::detector::params::doc;
use crate::detector::pipeline::{FIRST_PEAK_PART, strongest_around};
use crate::detector::refine::{Limits, MAX_OFFSET};
use crate::detector::scale_space::levels::octave_pixel;
use crate::detector::{
    Distinct, Judgement, Neighbourhood, ParamChange, ParamDoc, Sample, Slope, SlopeExtrema, SlopeNeighbours, Test,
    Trail,
};
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
    /// Whether the slope is on the rim of the grid.
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

/// The fate of a judged sample; `around` holds it.
pub fn fate(trail: &Trail, around: &Neighbourhood, sample: &Sample, judgement: &Judgement) -> Fate {
    let telling = Telling { trail, around, sample, judgement };
    let keypoint = judgement.keypoint().and_then(|k| trail.keypoint_at(k.octave, k.level, k.slope_index, k.sample));
    let tests = telling.tests(keypoint);
    // Rejections of the search come before decisions over the whole list of keypoints.
    let later = [Test::Duplicate, Test::MaxFeatures].into_iter();
    let first_failed = judgement
        .rejected_by
        .or_else(|| later.into_iter().find(|test| tests[*test as usize].outcome == Outcome::Fails));
    let pixel = octave_pixel(sample.octave);
    let grid = trail.params().used_slopes();
    let (pos_image, sigma) = match &judgement.would_be {
        Some(k) => {
            let (u, v, sigma) = k.in_image();
            ([u, v], sigma)
        }
        None => (
            [sample.x as f32 * pixel, sample.y as f32 * pixel],
            trail.space().sigma_image(sample.octave, f64::from(sample.level)) as f32,
        ),
    };
    let (i, j) = grid.coordinates(sample.slope_index);
    let features: Vec<usize> =
        keypoint.map(|k| trail.ranks_of(k).filter(|r| *r < count(trail)).collect()).unwrap_or_default();
    let refined = features.first().map(|&index| trail.detection().features[index]);
    let fate = Fate {
        octave: sample.octave,
        level: sample.level,
        slope_index: sample.slope_index,
        sample: [sample.x, sample.y],
        pos_image: refined.map_or(pos_image, |f| [f.u, f.v]),
        sigma: refined.map_or(sigma, |f| f.sigma),
        slope: refined.map_or_else(|| grid.slope(sample.slope_index), |f| f.slope),
        value: judgement.value,
        snr: over(judgement.value.abs(), judgement.sigma_d),
        sigma_d: judgement.sigma_d,
        tests,
        first_failed,
        at_slope_limit: refined.map_or_else(|| grid.on_rim(i, j), |f| f.at_slope_limit),
        features,
        keypoint,
        verdict: String::new(),
        remedy: None,
    };
    super::remedy::explained(trail, judgement, fate)
}

/// The margin of a judged sample in one test (see [`TestReport::margin`]); `around` holds the sample.
pub fn margin_of(
    trail: &Trail,
    around: &Neighbourhood,
    sample: &Sample,
    judgement: &Judgement,
    test: Test,
) -> Option<f64> {
    let keypoint = judgement.keypoint().and_then(|k| trail.keypoint_at(k.octave, k.level, k.slope_index, k.sample));
    Telling { trail, around, sample, judgement }.test(test, keypoint).margin()
}

/// The number of features of the detection.
fn count(trail: &Trail) -> usize {
    trail.detection().features.len()
}

/// The ratio of value to noise; infinite over 0.
fn over(value: f32, noise: f32) -> f32 {
    if noise > 0.0 { value / noise } else { f32::INFINITY }
}

/// One candidate with the data to report on it.
struct Telling<'a> {
    trail: &'a Trail,
    around: &'a Neighbourhood,
    sample: &'a Sample,
    judgement: &'a Judgement,
}

impl Telling<'_> {
    fn tests(&self, keypoint: Option<usize>) -> Vec<TestReport> {
        Test::ALL.into_iter().map(|test| self.test(test, keypoint)).collect()
    }

    fn test(&self, test: Test, keypoint: Option<usize>) -> TestReport {
        match test {
            Test::PeakThreshold => self.peak(),
            Test::NoiseGate => self.gate(),
            Test::SpaceExtremum | Test::ScaleExtremum => self.neighbours(test),
            Test::SlopeExtremum => self.slopes(),
            Test::Refinement | Test::InterpolatedContrast | Test::Edge | Test::Outside => self.fitted(test),
            Test::Duplicate => self.duplicate(keypoint),
            Test::MaxFeatures => self.cut_off(keypoint),
        }
    }

    fn magnitude(&self) -> f64 {
        f64::from(self.judgement.value.abs())
    }

    fn peak(&self) -> TestReport {
        let limit = FIRST_PEAK_PART * self.trail.params().peak_threshold;
        TestReport {
            test: Test::PeakThreshold,
            outcome: match () {
                () if limit <= 0.0 => Outcome::NotAsked,
                () => outcome(self.judgement.value.abs() >= limit),
            },
            value: Some(self.magnitude()),
            limit: Some(f64::from(limit)),
            side: Side::AtLeast,
            unit: "of full scale",
            rival: None,
        }
    }

    fn gate(&self) -> TestReport {
        let factor = self.trail.detection().noise_gate_factor;
        let value = self.judgement.value.abs();
        let passes = value >= factor * self.judgement.sigma_d.max(self.judgement.sigma_d_min);
        TestReport {
            test: Test::NoiseGate,
            // A sample of exactly 0 is no extremum, whatever the gate.
            outcome: if factor <= 0.0 && value > 0.0 { Outcome::NotAsked } else { outcome(passes && value > 0.0) },
            value: Some(f64::from(over(value, self.judgement.sigma_d))),
            limit: Some(f64::from(factor)),
            side: Side::AtLeast,
            unit: doc::NOISE_GATE.unit,
            rival: None,
        }
    }

    /// Report of an extremum test: the rival is the strongest of the samples around it, at its own level or at the
    /// neighbouring ones.
    fn neighbours(&self, test: Test) -> TestReport {
        let Sample { x, y, slope_index, .. } = *self.sample;
        let index = self.sample.level_index();
        let levels: &[usize] = if test == Test::SpaceExtremum { &[index] } else { &[index - 1, index + 1] };
        let dog = &self.around.tiles[slope_index];
        let sign = self.judgement.value.signum();
        let places =
            levels.iter().flat_map(|&s| (y - 1..=y + 1).flat_map(move |v| (x - 1..=x + 1).map(move |u| (u, v, s))));
        let strongest = places
            .filter(|place| *place != (x, y, index))
            .map(|(u, v, s)| ((u, v, s), sign * dog.at(s, u, v)))
            .max_by(|a, b| a.1.total_cmp(&b.1));
        let (place, limit) = strongest.expect("there are neighbours");
        TestReport {
            test,
            outcome: outcome(self.magnitude() > f64::from(limit)),
            value: Some(self.magnitude()),
            limit: Some(f64::from(limit)),
            side: Side::AtLeast,
            unit: "of full scale",
            rival: Some(self.rival_sample(place, slope_index, sign * limit)),
        }
    }

    fn rival_sample(&self, (u, v, level_index): (usize, usize, usize), slope_index: usize, value: f32) -> Rival {
        let pixel = octave_pixel(self.sample.octave);
        Rival {
            pos_image: [u as f32 * pixel, v as f32 * pixel],
            sigma: self.trail.space().sigma_image(self.sample.octave, level_index as f64 - 1.0) as f32,
            slope: self.trail.params().used_slopes().slope(slope_index),
            value,
            feature: None,
        }
    }

    /// Report of the slope test: the rival is the strongest sample around it at the other slopes, those that the joint
    /// rule compares with, or all where each slope is searched for itself.
    fn slopes(&self) -> TestReport {
        let Sample { x, y, slope_index, .. } = *self.sample;
        let (params, index) = (self.trail.params(), self.sample.level_index());
        let (grid, sign) = (params.used_slopes(), self.judgement.value.signum());
        let joint = params.slope_extrema == SlopeExtrema::Joint;
        let all = !joint || params.slope_neighbours == SlopeNeighbours::All;
        let (i, j) = grid.coordinates(slope_index);
        let compared = |&other: &usize| {
            let (ii, jj) = grid.coordinates(other);
            other != slope_index && (all || (i.abs_diff(ii) <= 1 && j.abs_diff(jj) <= 1))
        };
        let strongest = |other: usize| strongest_around(&self.around.tiles[other], x, y, index, sign);
        let best = (0..grid.len())
            .filter(compared)
            .map(|other| (other, strongest(other)))
            .max_by(|a, b| a.1.1.total_cmp(&b.1.1));
        let limit = best.map(|(_, (_, value))| f64::from(value));
        TestReport {
            test: Test::SlopeExtremum,
            outcome: match () {
                () if !joint || best.is_none() => Outcome::NotAsked,
                () => outcome(self.judgement.beaten_by.is_none()),
            },
            value: Some(self.magnitude()),
            limit,
            side: Side::AtLeast,
            unit: "of full scale",
            rival: best.map(|(other, (place, value))| self.rival_sample(place, other, sign * value)),
        }
    }

    fn fitted(&self, test: Test) -> TestReport {
        let params = self.trail.params();
        let limits = Limits { peak_threshold: params.peak_threshold, edge_threshold: params.edge_threshold };
        let levels = self.trail.space().levels + 2;
        let size = self.around.size;
        let (value, limit, side, unit) = match (test, self.judgement.fit) {
            (Test::Refinement, fit) => (fit.map(|fit| fit.largest_offset()), MAX_OFFSET, Side::AtMost, "samples"),
            (Test::InterpolatedContrast, fit) => {
                (fit.map(|fit| fit.value.abs()), f64::from(params.peak_threshold), Side::AtLeast, "of full scale")
            }
            (Test::Edge, fit) => {
                (fit.map(|fit| fit.curvature_ratio()), f64::from(params.edge_threshold), Side::AtMost, "")
            }
            (_, fit) => {
                // Distance inside, in samples along the axis that is nearest to an end.
                let inside = fit.map(|fit| {
                    let (x, y) = fit.place();
                    let to_end = |at: f64, n: usize| at.min((n - 1) as f64 - at);
                    to_end(x, size.0).min(to_end(y, size.1)).min(to_end(fit.level_refined, levels + 1))
                });
                (inside, 0.0, Side::AtLeast, "samples")
            }
        };
        let asked = test != Test::InterpolatedContrast || params.peak_threshold > 0.0;
        let tests = self.judgement.fit.map(|fit| fit.tests(size, levels, limits));
        let passes = tests.and_then(|tests| tests.into_iter().find(|(t, _)| *t == test)).map(|(_, passes)| passes);
        TestReport {
            test,
            outcome: match passes {
                Some(true) if !asked => Outcome::NotAsked,
                Some(passes) => outcome(passes),
                None if test == Test::Refinement => Outcome::Fails,
                None => Outcome::Unknown,
            },
            value,
            limit: Some(limit),
            side,
            unit,
            rival: None,
        }
    }

    fn duplicate(&self, keypoint: Option<usize>) -> TestReport {
        let (radius, asked) = match self.trail.params().distinct {
            Distinct::Off => (None, false),
            Distinct::Radius(radius) => (Some(f64::from(radius)), true),
        };
        let by = match (keypoint, &self.judgement.would_be) {
            (Some(keypoint), _) => self.trail.covered_by(keypoint),
            (None, Some(would_be)) => self.trail.would_be_covered_by(would_be),
            (None, None) => None,
        };
        let stronger = by.map(|by| (by, self.trail.keypoints()[by]));
        let place = self.judgement.would_be;
        let distance = stronger.zip(place).map(|((_, stronger), own)| f64::from(apart_sigmas(&stronger, &own)));
        TestReport {
            test: Test::Duplicate,
            outcome: match () {
                () if !asked => Outcome::NotAsked,
                () if by.is_some() => Outcome::Fails,
                () if place.is_none() => Outcome::Unknown,
                () => Outcome::Passes,
            },
            value: distance,
            limit: radius,
            side: Side::AtLeast,
            unit: doc::DISTINCT.unit,
            rival: stronger.map(|(by, k)| self.rival_keypoint(by, &k)),
        }
    }

    fn rival_keypoint(&self, index: usize, keypoint: &Keypoint) -> Rival {
        let (u, v, sigma) = keypoint.in_image();
        let feature = self.trail.ranks_of(index).find(|rank| *rank < count(self.trail));
        Rival { pos_image: [u, v], sigma, slope: keypoint.slope, value: keypoint.value, feature }
    }

    fn cut_off(&self, keypoint: Option<usize>) -> TestReport {
        let max = self.trail.params().max_features;
        let rank = keypoint.and_then(|keypoint| self.trail.ranks_of(keypoint).next());
        TestReport {
            test: Test::MaxFeatures,
            outcome: match rank {
                _ if max == 0 => Outcome::NotAsked,
                Some(rank) => outcome(rank < max),
                None => Outcome::Unknown,
            },
            value: rank.map(|rank| (rank + 1) as f64),
            limit: (max > 0).then_some(max as f64),
            side: Side::AtMost,
            unit: "features",
            rival: None,
        }
    }
}

fn outcome(passes: bool) -> Outcome {
    if passes { Outcome::Passes } else { Outcome::Fails }
}
