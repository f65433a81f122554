//! The candidates of a whole picture: for each the first test that it fails and the margin; maps of the winning slopes.
//!
//! A candidate is a sample that is an extremum in place and scale at its own slope; most are noise. The detection's
//! tally counts all samples.

use super::candidate_tests::{CandidateTests, keypoint_of, over};
use crate::detector::search::extrema::{Candidate, Thresholds, own_slope_extrema, scale_ease};
use crate::detector::{Judgement, Neighbourhood, Sample, Scale, Tally, Test, Trail};
use crate::detector::{scale_space::octave_pixel, search::ascends};
use crate::monitor::{Cancelled, Monitor, Stage};
use crate::plane::Plane;
use crate::plane::tile::{Region, cuts};
use std::ops::Range;

/// A candidate of the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CandidateMark {
    /// (u, v) of the sample, input pixels.
    pub pos_image: [f32; 2],
    /// Scale σ of its level, input pixels.
    pub sigma: f32,
    /// The sample.
    pub sample: Sample,
    /// D there.
    pub value: f32,
    /// Ratio of |D| to its noise.
    pub snr: f32,
    /// First test that it fails; `None` for a kept candidate.
    pub first_failed: Option<Test>,
    /// Margin of that test, as a part of the limit: below 0. `None` for a kept candidate and for tests without a limit.
    pub margin: Option<f32>,
}

/// Rejections of one test.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TestCount {
    /// The test.
    pub test: Test,
    /// Number of samples that it rejected first, as in the detection's tally.
    pub samples: u64,
    /// Number of candidates among them.
    pub candidates: u64,
}

/// The candidates of a picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Survey {
    /// The listed candidates, in order of octaves, tiles, slopes and levels.
    pub marks: Vec<CandidateMark>,
    /// Both counts for each test, in the order of [`Test::ALL`].
    pub counts: Vec<TestCount>,
    /// Number of all candidates.
    pub candidates: u64,
    /// Number of candidates that were kept.
    pub kept: u64,
}

/// Selection of the candidates to list; all are counted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurveyOptions {
    /// Minimum |D| over its noise. Noise alone has millions of weak candidates.
    pub min_snr: f32,
    /// Test that they fail first; `None` lists the candidates of all tests, and the kept ones.
    pub test: Option<Test>,
}

impl Default for SurveyOptions {
    fn default() -> Self {
        Self { min_snr: 3.0, test: None }
    }
}

/// Side of the parts in which a picture is surveyed, octave pixels, unless there are very many slopes.
const PART_PX: usize = 160;
const PART_BYTES: usize = 256 << 20;

fn parts(trail: &Trail, octave: i32) -> Vec<Region> {
    let of_pixel = trail.params().used_slopes().len() * (trail.space().levels + 2) * size_of::<f32>();
    // The margin held around a part does not count, however small the part is.
    let px = (PART_BYTES / of_pixel.max(1)).isqrt().clamp(PART_PX / 8, PART_PX);
    let (width, height) = trail.octave_size(octave);
    let columns = cuts(width, px);
    let row = |rows: Range<usize>| columns.iter().map(move |c| Region { columns: c.clone(), rows: rows.clone() });
    cuts(height, px).into_iter().flat_map(row).collect()
}

/// Searches the picture again, counts its candidates by the first test that they fail, and lists those of `options`.
pub fn survey(trail: &Trail, options: &SurveyOptions, monitor: &Monitor) -> Result<Survey, Cancelled> {
    let tally = &trail.detection().tally;
    let mut by_test = [0u64; Test::ALL.len()];
    let mut survey = Survey { marks: Vec::new(), counts: Vec::new(), candidates: 0, kept: 0 };
    let all_pixels: f32 = trail.octaves().map(|octave| pixels(trail, octave)).sum();
    let mut done = 0.0;
    for octave in trail.octaves() {
        let parts = parts(trail, octave);
        let share = pixels(trail, octave) / all_pixels / parts.len() as f32;
        for part in parts {
            for mark in marks(trail, &trail.neighbourhood(octave, &part, monitor)?) {
                survey.candidates += 1;
                match mark.first_failed {
                    Some(test) => by_test[test as usize] += 1,
                    None => survey.kept += 1,
                }
                let asked = options.test.is_none_or(|test| mark.first_failed == Some(test));
                survey.marks.extend(Some(mark).filter(|mark| asked && mark.snr >= options.min_snr));
            }
            done += share;
            monitor.report(Stage::Search { octave }, done);
        }
    }
    let count = |test: Test| TestCount { test, samples: tally.rejected_by(test), candidates: by_test[test as usize] };
    survey.counts = Test::ALL.into_iter().map(count).collect();
    Ok(survey)
}

fn pixels(trail: &Trail, octave: i32) -> f32 {
    let (width, height) = trail.octave_size(octave);
    width as f32 * height as f32
}

/// The samples of a part of the picture that are extrema in place and scale at their own slope, however weak.
pub(super) fn open_candidates(trail: &Trail, around: &Neighbourhood) -> Vec<Sample> {
    let octave = around.octave;
    let scale_ease = scale_ease(ascends(trail.params(), octave));
    let open = Thresholds { peak: 0.0, gate: vec![0.0; trail.space().levels + 2], scale_ease };
    let mut samples = Vec::new();
    let mut found: Vec<Candidate> = Vec::new();
    for (slope_index, dog) in around.tiles.iter().enumerate() {
        own_slope_extrema(&dog.levels, &around.region, around.size, &open, &mut Tally::default(), &mut found);
        samples.extend(found.drain(..).map(|Candidate { x, y, level_index, .. }| {
            let level = level_index as i32 - 1;
            Sample { octave, level, slope_index, x, y }
        }));
    }
    samples
}

fn marks(trail: &Trail, around: &Neighbourhood) -> Vec<CandidateMark> {
    let samples = open_candidates(trail, around);
    let pixel = octave_pixel(around.octave);
    let judged = trail.judge(around, &samples);
    let mark = |(sample, judgement): (&Sample, Option<Judgement>)| {
        let judgement = judgement?;
        let first_failed = judgement.rejected_by.or_else(|| {
            let keypoint = keypoint_of(trail, &judgement)?;
            let is_duplicate = trail.covered_by(keypoint).is_some().then_some(Test::Duplicate);
            is_duplicate.or_else(|| trail.is_cut(keypoint).then_some(Test::MaxFeatures))
        });
        let tested = CandidateTests::new(trail, around, sample, &judgement);
        let margin = first_failed.and_then(|test| tested.report(test).margin()).map(|margin| margin as f32);
        let pos_image = [sample.x as f32 * pixel, sample.y as f32 * pixel];
        let sigma = trail.space().sigma_image(sample.octave, f64::from(sample.level)) as f32;
        let (value, snr) = (judgement.value, over(judgement.value.abs(), judgement.sigma_d));
        Some(CandidateMark { pos_image, sigma, sample: *sample, value, snr, first_failed, margin })
    };
    samples.iter().zip(judged).filter_map(mark).collect()
}

/// The winning slope at each place of an octave, with its confidence.
#[derive(Debug, Clone, PartialEq)]
pub struct WinningSlopes {
    /// Octave, in whose pixels the planes are.
    pub octave: i32,
    /// DoG level.
    pub level: i32,
    /// Index of the slope with the largest |D| over its noise.
    pub slope_index: Plane,
    /// |D| over its noise at that slope.
    pub snr: Plane,
    /// Confidence, 0 … 1: relative distance to the strongest slope that is no neighbour; 0 below the gate.
    pub confidence: Plane,
}

/// Computes the winning slope at each place, at one searched octave and level: a map of the motion.
pub fn winning_slopes(trail: &Trail, octave: i32, level: i32, monitor: &Monitor) -> Result<WinningSlopes, Cancelled> {
    let (width, height) = trail.octave_size(octave);
    let grid = trail.params().used_slopes();
    let gate = trail.detection().noise_gate_factor;
    let zeros = || Plane::zeros(width, height);
    let mut out = WinningSlopes { octave, level, slope_index: zeros(), snr: zeros(), confidence: zeros() };
    let parts = parts(trail, octave);
    let index = (level + 1) as usize;
    let sigma_d: Vec<f32> = (0..grid.len()).map(|slope| trail.sigma_d_min(Scale { octave, level }, slope)).collect();
    for (part, region) in parts.iter().enumerate() {
        let around = trail.neighbourhood(octave, region, monitor)?;
        for y in region.rows.clone() {
            for x in region.columns.clone() {
                let strength = |slope: usize| {
                    let d = around.tiles[slope].at(index, x, y).abs();
                    if sigma_d[slope] > 0.0 { d / sigma_d[slope] } else { d }
                };
                let best = (0..grid.len()).max_by(|&a, &b| strength(a).total_cmp(&strength(b))).unwrap_or(0);
                let (i, j) = grid.coordinates(best);
                let apart = |other: &usize| {
                    let (ii, jj) = grid.coordinates(*other);
                    i.abs_diff(ii) > 1 || j.abs_diff(jj) > 1
                };
                let max = strength(best);
                let second = (0..grid.len()).filter(apart).map(strength).fold(0.0, f32::max);
                out.slope_index.row_mut(y)[x] = best as f32;
                out.snr.row_mut(y)[x] = max;
                out.confidence.row_mut(y)[x] = if max > 0.0 && max >= gate { 1.0 - second / max } else { 0.0 };
            }
        }
        monitor.report(Stage::Search { octave }, (part + 1) as f32 / parts.len() as f32);
    }
    Ok(out)
}
