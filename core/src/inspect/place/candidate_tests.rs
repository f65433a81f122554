//! The fate of a sample: the value and the limit of each test, and the rival. The verdict is the search's own
//! ([`crate::detector::Judgement`]); this only says what it compared.

use super::fate::{Fate, OnEdge, Outcome, Rival, TestReport, apart_sigmas};
use super::shares::{direction_of, directions};
use crate::detector::pipeline::{FIRST_PEAK_PART, compared_slopes};
use crate::detector::refine::{Limits, MAX_OFFSET};
use crate::detector::search::extrema::scale_ease;
use crate::detector::search::{MIN_SEEN, ascends, first_gate_part};
use crate::detector::{Distinct, Judgement, Neighbourhood, Sample, Slope, SlopeExtrema, SlopeNeighbours, Test, Trail};
use crate::detector::{feature::Keypoint, scale_space::octave_pixel};

/// The fate of a judged sample; `around` holds it.
pub fn fate(trail: &Trail, around: &Neighbourhood, sample: &Sample, judgement: &Judgement) -> Fate {
    let tested = CandidateTests::new(trail, around, sample, judgement);
    let keypoint = tested.keypoint;
    let tests: Vec<TestReport> = Test::ALL.into_iter().map(|test| tested.report(test)).collect();
    // Rejections of the search come before decisions over the whole list of keypoints.
    let fails = |test: &Test| tests[*test as usize].outcome == Outcome::Fails;
    let first_failed = judgement.rejected_by.or_else(|| [Test::Duplicate, Test::MaxFeatures].into_iter().find(fails));
    let grid = trail.params().used_slopes();
    let (u, v, sigma) = tested.in_image();
    let (i, j) = grid.coordinates(sample.slope_index);
    let found = &trail.detection().features;
    let features: Vec<usize> =
        keypoint.into_iter().flat_map(|k| trail.ranks_of(k)).filter(|r| *r < found.len()).collect();
    let refined = features.first().map(|&index| found[index]);
    let slope = refined.map_or_else(|| grid.slope(sample.slope_index), |f| f.slope);
    let asks_for_edge = matches!(first_failed, Some(Test::Refinement | Test::Edge));
    let fate = Fate {
        octave: sample.octave,
        level: sample.level,
        slope_index: sample.slope_index,
        sample: [sample.x, sample.y],
        pos_image: refined.map_or([u, v], |f| [f.u, f.v]),
        sigma: refined.map_or(sigma, |f| f.sigma),
        slope,
        would_move: judgement.would_be.filter(|_| refined.is_none()).map_or(slope, |keypoint| keypoint.slope),
        edge: if asks_for_edge { tested.edge(slope) } else { None },
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

pub(super) fn over(value: f32, noise: f32) -> f32 {
    if noise > 0.0 { value / noise } else { f32::INFINITY }
}

pub(super) fn keypoint_of(trail: &Trail, judgement: &Judgement) -> Option<usize> {
    judgement.keypoint().and_then(|k| trail.keypoint_at(k.octave, k.level, k.slope_index, k.sample))
}

fn outcome(is_asked: bool, passes: bool) -> Outcome {
    match passes {
        _ if !is_asked => Outcome::NotAsked,
        true => Outcome::Passes,
        false => Outcome::Fails,
    }
}

pub(super) struct CandidateTests<'a> {
    trail: &'a Trail,
    around: &'a Neighbourhood,
    sample: &'a Sample,
    judgement: &'a Judgement,
    keypoint: Option<usize>,
}

impl<'a> CandidateTests<'a> {
    pub fn new(trail: &'a Trail, around: &'a Neighbourhood, sample: &'a Sample, judgement: &'a Judgement) -> Self {
        Self { trail, around, sample, judgement, keypoint: keypoint_of(trail, judgement) }
    }

    pub fn report(&self, test: Test) -> TestReport {
        match test {
            Test::PeakThreshold => {
                let (value, limit) = (self.judgement.value.abs(), FIRST_PEAK_PART * self.trail.params().peak_threshold);
                TestReport::new(test, outcome(limit > 0.0, value >= limit), Some(value.into()), Some(limit.into()))
            }
            Test::NoiseGate => self.gate(),
            Test::SpaceExtremum | Test::ScaleExtremum => self.neighbours(test),
            Test::SlopeExtremum => self.slopes(),
            Test::Refinement | Test::InterpolatedContrast | Test::Edge | Test::Outside => self.fitted(test),
            Test::Seen => self.seen(),
            Test::Duplicate => self.duplicate(),
            Test::MaxFeatures => self.cut_off(),
        }
    }

    /// Place (u, v) and scale σ of the fit, or of the sample where the fit did not settle; input pixels.
    fn in_image(&self) -> (f32, f32, f32) {
        let (sample, pixel) = (self.sample, octave_pixel(self.sample.octave));
        let sigma = self.trail.space().sigma_image(sample.octave, f64::from(sample.level)) as f32;
        let own = (sample.x as f32 * pixel, sample.y as f32 * pixel, sigma);
        self.judgement.would_be.as_ref().map_or(own, Keypoint::in_image)
    }

    fn seen(&self) -> TestReport {
        let (u, v, sigma) = self.in_image();
        let slope = self.trail.params().used_slopes().slope(self.sample.slope_index);
        let seen = self.trail.seen_share((u, v), slope, sigma);
        let outcome = outcome(seen.is_some(), seen.is_none_or(|seen| seen >= MIN_SEEN));
        TestReport::new(Test::Seen, outcome, seen.map(f64::from), seen.map(|_| f64::from(MIN_SEEN)))
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
        // A sample of exactly 0 is no extremum, whatever the gate.
        let outcome = outcome(factor > 0.0 || value <= 0.0, passes && value > 0.0);
        TestReport::new(Test::NoiseGate, outcome, Some(over(value, sigma_d).into()), Some(factor.into()))
    }

    /// Report of a comparison with other samples, the strongest of which is the `rival`.
    fn compared(&self, test: Test, is_asked: bool, passes: bool, limit: f64, rival: Strongest) -> TestReport {
        let (u, v, level_index) = rival.at;
        let pixel = octave_pixel(self.sample.octave);
        let rival = Rival {
            pos_image: [u as f32 * pixel, v as f32 * pixel],
            sigma: self.trail.space().sigma_image(self.sample.octave, level_index as f64 - 1.0) as f32,
            slope: self.trail.params().used_slopes().slope(rival.slope_index),
            value: self.judgement.value.signum() * rival.value,
            feature: None,
        };
        let value = f64::from(self.judgement.value.abs());
        let report = TestReport::new(test, outcome(is_asked, passes), Some(value), Some(limit));
        TestReport { rival: Some(rival), ..report }
    }

    /// The strongest of the samples around this one at a slope and some levels, by D of its sign; not itself.
    fn strongest(&self, slope_index: usize, levels: &[usize]) -> Strongest {
        let Sample { x, y, slope_index: own, .. } = *self.sample;
        let (dog, sign) = (&self.around.tiles[slope_index], self.judgement.value.signum());
        let around =
            levels.iter().flat_map(|&s| (y - 1..=y + 1).flat_map(move |v| (x - 1..=x + 1).map(move |u| (u, v, s))));
        around
            .filter(|at| slope_index != own || *at != (x, y, self.sample.level_index()))
            .map(|at| Strongest { slope_index, at, value: sign * dog.at(at.2, at.0, at.1) })
            .max_by(|a, b| a.value.total_cmp(&b.value))
            .expect("there are neighbours")
    }

    fn neighbours(&self, test: Test) -> TestReport {
        let index = self.sample.level_index();
        let levels: &[usize] = if test == Test::SpaceExtremum { &[index] } else { &[index - 1, index + 1] };
        let rival = self.strongest(self.sample.slope_index, levels);
        let ascends = ascends(self.trail.params(), self.sample.octave);
        let ease = scale_ease(ascends && test == Test::ScaleExtremum);
        let passes = ease * self.judgement.value.abs() > rival.value;
        self.compared(test, true, passes, f64::from(rival.value) / f64::from(ease), rival)
    }

    /// The rival is at a slope that the joint rule compares with, or at any where each is searched for itself.
    fn slopes(&self) -> TestReport {
        let (params, index) = (self.trail.params(), self.sample.level_index());
        let joint = params.used_extrema() == SlopeExtrema::Joint;
        let neighbours = if joint { params.rules.slope_neighbours } else { SlopeNeighbours::All };
        let grid = params.used_slopes();
        let others = compared_slopes(&grid, self.sample.slope_index, neighbours);
        let strongest = others.map(|other| self.strongest(other, &[index - 1, index, index + 1]));
        let Some(rival) = strongest.max_by(|a, b| a.value.total_cmp(&b.value)) else {
            let value = f64::from(self.judgement.value.abs());
            return TestReport::new(Test::SlopeExtremum, Outcome::NotAsked, Some(value), None);
        };
        self.compared(Test::SlopeExtremum, joint, !self.judgement.is_beaten, rival.value.into(), rival)
    }

    fn fitted(&self, test: Test) -> TestReport {
        let (params, size, fit) = (self.trail.params(), self.around.size, self.judgement.fit);
        let levels = self.trail.space().levels + 2;
        let limits = Limits { gate: 0.0, peak_threshold: params.peak_threshold, edge_threshold: params.edge_threshold };
        let limit = match test {
            Test::Refinement => MAX_OFFSET,
            Test::InterpolatedContrast => params.peak_threshold.into(),
            Test::Edge => params.edge_threshold.into(),
            _ => 0.0,
        };
        let value = fit.map(|fit| match test {
            Test::Refinement => fit.largest_offset(),
            Test::InterpolatedContrast => fit.value.abs(),
            Test::Edge => fit.curvature_ratio(),
            // Distance inside, in samples along the axis that is nearest to an end.
            _ => {
                let (x, y) = fit.place();
                let to_end = |at: f64, n: usize| at.min((n - 1) as f64 - at);
                to_end(x, size.0).min(to_end(y, size.1)).min(to_end(fit.level_refined, levels + 1))
            }
        });
        let passes = fit.map(|fit| fit.tests(size, levels, limits).contains(&(test, true)));
        let outcome = match passes {
            Some(true) if test == Test::InterpolatedContrast && params.peak_threshold <= 0.0 => Outcome::NotAsked,
            Some(passes) => outcome(true, passes),
            None if test == Test::Refinement => Outcome::Fails,
            None => Outcome::Unknown,
        };
        TestReport::new(test, outcome, value, Some(limit))
    }

    fn duplicate(&self) -> TestReport {
        let would_be = self.judgement.would_be;
        let by = match (self.keypoint, &would_be) {
            (Some(keypoint), _) => self.trail.covered_by(keypoint),
            (None, Some(would_be)) => self.trail.would_be_covered_by(would_be),
            (None, None) => None,
        };
        let distinct = self.trail.params().distinct;
        let radius = if let Distinct::Radius(radius) = distinct { Some(f64::from(radius)) } else { None };
        let outcome = match by {
            _ if radius.is_none() || self.keypoint.is_some_and(|own| self.trail.is_cut(own)) => Outcome::NotAsked,
            None if would_be.is_none() => Outcome::Unknown,
            by => outcome(true, by.is_none()),
        };
        let stronger = by.map(|by| self.trail.keypoints()[by]);
        let distance = stronger.zip(would_be).map(|(stronger, own)| f64::from(apart_sigmas(&stronger, &own)));
        let count = self.trail.detection().features.len();
        let rival = by.zip(stronger).map(|(by, stronger)| {
            let (u, v, sigma) = stronger.in_image();
            let feature = self.trail.ranks_of(by).find(|rank| *rank < count);
            Rival { pos_image: [u, v], sigma, slope: stronger.slope, value: stronger.value, feature }
        });
        TestReport { rival, ..TestReport::new(Test::Duplicate, outcome, distance, radius) }
    }

    /// The edge at the sample: where one principal curvature of D is that much larger than the other, or they differ in
    /// sign. It runs in the direction of the smaller one.
    fn edge(&self, slope: Slope) -> Option<OnEdge> {
        let (&Sample { x, y, slope_index, .. }, level) = (self.sample, self.sample.level_index());
        let at = |u: usize, v: usize| self.around.tiles[slope_index].at(level, u, v);
        let twice = 2.0 * at(x, y);
        let (uu, vv) = (at(x + 1, y) + at(x - 1, y) - twice, at(x, y + 1) + at(x, y - 1) - twice);
        let uv = 0.25 * (at(x + 1, y + 1) + at(x - 1, y - 1) - at(x + 1, y - 1) - at(x - 1, y + 1));
        let (mean, half) = (0.5 * (uu + vv), 0.5 * (uu - vv).hypot(2.0 * uv));
        let (large, small) = (mean.abs() + half, mean.abs() - half);
        if small > 0.0 && large < EDGE_RATIO * small {
            return None;
        }
        // Angle of the axis of the larger curvature; the edge is at right angles to it.
        let steepest = 0.5 * (2.0 * uv * mean.signum()).atan2((uu - vv) * mean.signum());
        let direction = [-steepest.sin(), steepest.cos()];
        let grid = self.trail.params().used_slopes();
        let is_along = |[u, v]: [f32; 2]| (u * direction[0] + v * direction[1]).abs() > ALONG;
        let line = directions(&grid).filter(|_| !grid.is_plane()).any(is_along);
        let motion = slope.magnitude() > 0.0 && is_along(direction_of(slope));
        Some(OnEdge { direction, along_motion: line || motion })
    }

    fn cut_off(&self) -> TestReport {
        let max = self.trail.params().max_features;
        let rank = self.keypoint.and_then(|keypoint| {
            let cut = self.trail.is_cut(keypoint).then(|| self.trail.rank_uncut(keypoint));
            cut.or_else(|| self.trail.ranks_of(keypoint).next())
        });
        let outcome = match rank {
            None if max > 0 => Outcome::Unknown,
            rank => outcome(max > 0, rank.is_some_and(|rank| rank < max)),
        };
        let value = rank.map(|rank| (rank + 1) as f64);
        TestReport::new(Test::MaxFeatures, outcome, value, (max > 0).then_some(max as f64))
    }
}

/// Ratio of principal curvatures from which a candidate that fails lies on an edge.
const EDGE_RATIO: f32 = 5.0;
/// Cosine of the largest angle, 30°, between an edge and a motion along it.
const ALONG: f32 = 0.866;

struct Strongest {
    slope_index: usize,
    /// Column, row, and index of the level.
    at: (usize, usize, usize),
    /// D, positive if it has the candidate's sign.
    value: f32,
}
