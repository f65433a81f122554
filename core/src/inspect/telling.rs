//! Reports of the tests of a candidate: each test of the search for one sample, with the values that it compares.
//!
//! The verdict is the search's own ([`crate::detector::Judgement`]). Only the explanation of a verdict is computed
//! here: the value, the limit, and the rival.

use super::fate::{Fate, Outcome, Rival, Side, TestReport, apart_sigmas};
use crate::detector::feature::Keypoint;
use crate::detector::params::doc;
use crate::detector::pipeline::{FIRST_PEAK_PART, strongest_around};
use crate::detector::refine::{Limits, MAX_OFFSET};
use crate::detector::scale_space::octave_pixel;
use crate::detector::search::extrema::scale_ease;
use crate::detector::search::{ascends, first_gate_part};
use crate::detector::{Distinct, Judgement, Neighbourhood, Sample, SlopeExtrema, SlopeNeighbours, Test, Trail};

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
        let sample = self.judgement.value.abs();
        let (sigma_d, first_part) = (self.judgement.sigma_d, first_gate_part(self.trail.params()));
        let passes_first =
            sample >= first_part * (factor * sigma_d) && sample >= first_part * factor * self.judgement.sigma_d_min;
        // The refined value is compared with the gate, and the sample with a part of it.
        let fit = self.judgement.fit.filter(|fit| first_part < 1.0 && fit.largest_offset() < MAX_OFFSET);
        let fit = fit.map(|fit| fit.value.abs() as f32);
        let passes = passes_first && fit.is_none_or(|fit| fit >= factor * sigma_d);
        let value = (sample / first_part).min(fit.unwrap_or(f32::INFINITY));
        TestReport {
            test: Test::NoiseGate,
            // A sample of exactly 0 is no extremum, whatever the gate.
            outcome: if factor <= 0.0 && value > 0.0 { Outcome::NotAsked } else { outcome(passes && value > 0.0) },
            value: Some(f64::from(over(value, sigma_d))),
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
        let (place, rival) = strongest.expect("there are neighbours");
        let ascends = ascends(self.trail.params(), self.sample.octave);
        let ease = scale_ease(ascends && test == Test::ScaleExtremum);
        TestReport {
            test,
            outcome: outcome(ease * self.judgement.value.abs() > rival),
            value: Some(self.magnitude()),
            limit: Some(f64::from(rival) / f64::from(ease)),
            side: Side::AtLeast,
            unit: "of full scale",
            rival: Some(self.rival_sample(place, slope_index, sign * rival)),
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
        let joint = params.used_extrema() == SlopeExtrema::Joint;
        let all = !joint || params.rules.slope_neighbours == SlopeNeighbours::All;
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
        let limits = Limits { gate: 0.0, peak_threshold: params.peak_threshold, edge_threshold: params.edge_threshold };
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
                () if !asked || self.is_cut(keypoint) => Outcome::NotAsked,
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

    /// Whether it is a keypoint that is cut before it is compared with others.
    fn is_cut(&self, keypoint: Option<usize>) -> bool {
        keypoint.is_some_and(|keypoint| self.trail.is_cut(keypoint))
    }

    fn cut_off(&self, keypoint: Option<usize>) -> TestReport {
        let max = self.trail.params().max_features;
        let rank = keypoint.and_then(|keypoint| {
            let cut = self.trail.is_cut(keypoint).then(|| self.trail.rank_uncut(keypoint));
            cut.or_else(|| self.trail.ranks_of(keypoint).next())
        });
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
