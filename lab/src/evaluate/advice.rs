//! Advice on slopes: how often the sentence about the slopes of a search is right.
//!
//! Bursts whose motion is known are searched, with slopes that are found or with wrong ones, and the judgement of the
//! slopes ([`judgement`]) is compared with the truth. What it says without knowing is no mistake.

use super::{check_lists, run_jobs};
use crate::synth::{Motion, NoiseCase, SceneParams, Truth, synth_scene};
use burstscope_core::burst::{Burst, Positions};
use burstscope_core::detect::{Searched, search};
use burstscope_core::detector::{SearchParams, Slope, SlopeGrid, Slopes, find_slopes};
use burstscope_core::error::{Error, Result};
use burstscope_core::inspect::slopes::{AdviceSubject, SlopeJudgement, judgement};
use burstscope_core::{monitor::Monitor, plane::Plane, synth::random::Stream};
use serde::Serialize;
use std::{collections::BTreeMap, sync::Arc};

/// Statement about the slopes of a search, said or true.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Statement {
    /// The slopes fit.
    Fits,
    /// The range is too narrow.
    Range,
    /// The step is too coarse.
    Step,
    /// The motion is not along the line that is searched.
    Direction,
    /// Fewer slopes are enough.
    Cost,
    /// The frames are in another order or at other times.
    Times,
    /// The motion is not straight, or too long for a burst.
    Frames,
    /// The frames show too little to tell.
    Unknown,
}

use Statement::{Cost, Direction, Fits, Frames, Range, Step, Times, Unknown};

impl Statement {
    /// All statements.
    pub const ALL: [Self; 8] = [Fits, Range, Step, Direction, Cost, Times, Frames, Unknown];

    fn said(judgement: &SlopeJudgement) -> Self {
        match judgement.advice.as_ref().map(|advice| (advice.subject, &advice.times)) {
            None if judgement.fits => Fits,
            Some((AdviceSubject::Range, _)) => Range,
            Some((AdviceSubject::Step, _)) => Step,
            Some((AdviceSubject::Direction, _)) => Direction,
            Some((AdviceSubject::Cost, _)) => Cost,
            Some((AdviceSubject::Frames, Some(_))) => Times,
            Some((AdviceSubject::Frames | AdviceSubject::Coverage, _)) => Frames,
            None => Unknown,
        }
    }
}

/// Kind of burst and of its search: the name, the scene, the slopes that are given unless they are found, and what is
/// true where it does not depend on the slopes found.
type Kind = (&'static str, SceneParams, Option<SlopeGrid>, Option<Statement>);

fn kinds() -> [Kind; 14] {
    use Motion::{OneD, TwoD};
    let (width, height) = SIZE;
    let scene =
        |layers, motion| SceneParams { width, height, layers, motion, frames: FRAMES, ..SceneParams::default() };
    let line = |range: f32, count| Some(SlopeGrid::line(-range..=range, count));
    let plane = SlopeGrid::plane(-3.0..=3.0, 13, -3.0..=3.0, 13);
    [
        ("line", scene(1, OneD), None, None),
        ("plane", scene(4, TwoD), None, None),
        ("layers", scene(4, OneD), None, None),
        ("masked", SceneParams { mask: 0.25, ..scene(2, OneD) }, None, None),
        ("narrow", scene(4, OneD), line(1.0, 7), Some(Range)),
        ("coarse", scene(4, OneD), line(3.0, 4), Some(Step)),
        ("beside", scene(4, TwoD), line(3.0, 19), Some(Direction)),
        ("wide", scene(1, OneD), Some(plane), Some(Cost)),
        ("still", SceneParams { max_slope: 0.0, ..scene(4, OneD) }, line(2.0, 13), Some(Cost)),
        ("exchanged", scene(4, OneD), None, Some(Times)),
        ("curved", SceneParams { height: height + BEND_PX, ..scene(2, OneD) }, None, Some(Frames)),
        ("striped", scene(2, OneD), None, None),
        ("noise", scene(0, OneD), None, Some(Unknown)),
        ("camera", scene(0, OneD), None, Some(Unknown)),
    ]
}

/// Light and seeds of a study of advice, whose bursts are of fourteen kinds.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "cli", derive(clap::Args))]
pub struct AdviceStudy {
    /// Signal-to-noise ratios of one pixel in one frame, separated by commas; 0.5 or more, 'inf' makes no noise.
    #[cfg_attr(
        feature = "cli",
        arg(long = "snr", value_name = "RATIO,…", value_delimiter = ',', default_value = "0.5,1,2,4")
    )]
    pub snrs: Vec<f64>,
    /// Number of bursts of each kind and ratio.
    #[cfg_attr(feature = "cli", arg(long, value_name = "N", default_value_t = 20))]
    pub seeds: u64,
    /// The first burst's seed.
    #[cfg_attr(feature = "cli", arg(long = "seed", value_name = "FIRST", default_value_t = 1))]
    pub first_seed: u64,
}

/// Statement and truth about one burst.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[allow(missing_docs)] // where a name says it
pub struct AdvisedBurst {
    pub kind: &'static str,
    pub snr: f64,
    pub seed: u64,
    pub said: Statement,
    #[serde(rename = "true")]
    pub truth: Statement,
    pub sentence: String,
}

impl AdvisedBurst {
    /// Whether something else is said than is true, as if it were known.
    pub fn is_wrong(&self) -> bool {
        self.said != Unknown && self.said != self.truth
    }
}

/// Report of a study of advice.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AdviceReport {
    /// The study.
    #[serde(flatten)]
    pub study: AdviceStudy,
    /// For each statement, the number of bursts of each truth of which it was said.
    pub said: BTreeMap<Statement, BTreeMap<Statement, usize>>,
    /// Share (0 … 1) of the confident answers that are wrong; `None` without any.
    pub wrong_share: Option<f64>,
    /// All bursts, by kind, ratio and seed.
    pub bursts: Vec<AdvisedBurst>,
}

/// Noise of cameras and files in which nothing stays as a scene does, one kind a seed.
const OF_CAMERAS: [NoiseCase; 7] = {
    use NoiseCase::*;
    [ColumnStripes, GrowingStripes, DriftingStripes(20), Smoothed, ColourJpeg(30), Varying(6), NoisyHalf]
};
const FRAMES: usize = 10;
const SIZE: (usize, usize) = (240, 180);
/// How far the camera of a curved motion goes down, pixels.
const BEND_PX: usize = 9;
/// Displacement in the outermost frames, pixels, by which a motion may differ from the nearest slope found.
const BESIDE_PX: f32 = 1.4;

impl AdviceStudy {
    /// Makes the bursts, searches them and compares what is said with what is true.
    ///
    /// # Errors
    /// A parameter that makes no sense, or cancellation.
    pub fn run(&self, monitor: &Monitor) -> Result<AdviceReport> {
        check_lists(&self.snrs, self.seeds)?;
        if self.seeds > 1_000_000 {
            return Err(Error::param("seeds", format!("{} bursts", self.seeds), "give 1 to a million"));
        }
        let seeds = || (0..self.seeds).map(|i| self.first_seed.wrapping_add(i));
        let kinds = kinds();
        let of_kind = |kind| self.snrs.iter().flat_map(move |&snr| seeds().map(move |seed| (kind, snr, seed)));
        let jobs: Vec<(&Kind, f64, u64)> = kinds.iter().flat_map(of_kind).collect();
        let advise = |&(kind, snr, seed): &(&Kind, f64, u64), monitor: &Monitor, done: &(dyn Fn(usize) + Sync)| {
            let advised = advised(kind, snr, seed, monitor)?;
            done(1);
            Ok(advised)
        };
        let bursts = run_jobs(&jobs, |_| 1, monitor, advise)?;
        let count = |said, truth| bursts.iter().filter(|burst| (burst.said, burst.truth) == (said, truth)).count();
        let counts = |said| Statement::ALL.map(|truth| (truth, count(said, truth))).into();
        let said = Statement::ALL.map(|said| (said, counts(said))).into();
        let confident = bursts.iter().filter(|burst| burst.said != Unknown).count();
        let wrong = bursts.iter().filter(|burst| burst.is_wrong()).count();
        let wrong_share = (confident > 0).then(|| wrong as f64 / confident as f64);
        Ok(AdviceReport { study: self.clone(), said, wrong_share, bursts })
    }
}

fn advised((kind, scene, given, known): &Kind, snr: f64, seed: u64, monitor: &Monitor) -> Result<AdvisedBurst> {
    let (burst, truth) = burst_of(kind, scene, *known, snr, seed, monitor)?;
    let asked = SearchParams { slopes: given.map_or(Slopes::AUTO, Into::into), ..SearchParams::default() };
    let Searched { detection, params, finding, .. } = search(&burst, &asked, monitor)?;
    let shown = finding.map_or_else(|| find_slopes(&burst, &params, None, monitor), Ok)?;
    let judged = judgement(&detection, &params, Some(&shown), &burst, monitor)?;
    let (said, sentence) = judged.map_or((Unknown, String::new()), |j| (Statement::said(&j), j.sentence));
    let of_found = || truth.map_or(Unknown, |truth| truth_of(&truth, &params.used_slopes(), &burst.positions));
    Ok(AdvisedBurst { kind, snr, seed, said, truth: known.unwrap_or_else(of_found), sentence })
}

fn burst_of(
    kind: &str,
    scene: &SceneParams,
    known: Option<Statement>,
    snr: f64,
    seed: u64,
    monitor: &Monitor,
) -> Result<(Burst, Option<Truth>)> {
    if known == Some(Unknown) {
        let of_camera = OF_CAMERAS[(seed % OF_CAMERAS.len() as u64) as usize];
        let case = if kind == "camera" { of_camera } else { NoiseCase::White };
        return Ok((case.burst(SIZE, FRAMES, 0.02, seed, monitor)?, None));
    }
    let mut scene = SceneParams { snr, seed, ..scene.clone() };
    if known == Some(Times) {
        // Two neighbours, or frames two apart.
        let first = (seed % (FRAMES as u64 - 3)) as usize;
        scene.uneven.exchange = vec![first, first + 1 + (seed / 2 % 2) as usize];
    }
    let (mut burst, truth) = synth_scene(&scene, monitor)?;
    // Nobody has told the times of the frames.
    burst.positions = Positions::even(FRAMES);
    let middle = 0.5 * (FRAMES - 1) as f64;
    // The camera goes up to mid-burst and down again.
    for (t, frame) in burst.frames.iter_mut().enumerate().filter(|_| known == Some(Frames)) {
        let down = (((t as f64 - middle) / middle).powi(2) * BEND_PX as f64).round() as usize;
        *frame = Arc::new(Plane::from_fn(SIZE.0, SIZE.1, |u, v| frame.at(u, v + down)));
    }
    // Each column of a camera with stripes is off, by twice the noise.
    let sigma = truth.noise.filter(|_| kind == "striped").map_or(0.0, |noise| 2.0 * noise.sigma_background);
    let mut stream = Stream::new(seed, 6);
    let columns: Vec<f32> = (0..SIZE.0).map(|_| (sigma * stream.normal()) as f32).collect();
    let frames = burst.frames.iter_mut().filter(|_| sigma > 0.0);
    frames.for_each(|frame| *frame = Arc::new(Plane::from_fn(SIZE.0, SIZE.1, |u, v| frame.at(u, v) + columns[u])));
    Ok((truth.masked(burst), Some(truth)))
}

/// The truth about slopes that were found: whether the motions of all layers lie in the range, or why not.
fn truth_of(truth: &Truth, grid: &SlopeGrid, positions: &Positions) -> Statement {
    let beside = (0.5 * grid.u.step().hypot(grid.v.step())).max(BESIDE_PX / positions.reach() as f32);
    let is_far = |slope: &Slope| {
        let nearest = grid.slope(grid.nearest(*slope));
        (slope.u - nearest.u).hypot(slope.v - nearest.v) > beside
    };
    let layers = truth.layers.iter().map(|layer| Slope::new(layer.slope_u as f32, layer.slope_v as f32));
    let missed: Vec<Slope> = layers.filter(is_far).collect();
    let (sin, cos) = grid.direction_deg.to_radians().sin_cos();
    let is_across = |slope: &Slope| (slope.v * cos - slope.u * sin).abs() > beside;
    match missed.is_empty() {
        true => Fits,
        false if grid.v.count == 1 && missed.iter().any(is_across) => Direction,
        false => Range,
    }
}
