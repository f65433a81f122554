//! Advice on slopes: how often the sentence about the slopes of a search is right.
//!
//! Bursts whose motion is known are searched, with slopes that are found or with wrong ones, and the judgement of the
//! slopes (`burstscope_core::inspect::slopes`) is compared with the truth. What it says without knowing is no mistake.

use super::{check_lists, run_jobs};
use crate::synth::{Motion, NoiseCase, SceneParams, Truth, Uneven, synth_scene};
use burstscope_core::burst::{Burst, Positions};
use burstscope_core::detect::{Searched, search};
use burstscope_core::detector::{SearchParams, Slope, SlopeGrid, Slopes, find_slopes};
use burstscope_core::error::{Error, Result};
use burstscope_core::inspect::slopes::{AdviceSubject, SlopeJudgement, judgement};
use burstscope_core::monitor::Monitor;
use burstscope_core::plane::Plane;
use serde::Serialize;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Statement about the slopes of a search, said or true.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
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

impl Statement {
    /// All statements.
    pub const ALL: [Self; 8] =
        [Self::Fits, Self::Range, Self::Step, Self::Direction, Self::Cost, Self::Times, Self::Frames, Self::Unknown];

    /// Name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Fits => "fits",
            Self::Range => "range",
            Self::Step => "step",
            Self::Direction => "direction",
            Self::Cost => "cost",
            Self::Times => "times",
            Self::Frames => "frames",
            Self::Unknown => "unknown",
        }
    }

    fn said(judgement: &SlopeJudgement) -> Self {
        match &judgement.advice {
            None if judgement.fits => Self::Fits,
            None => Self::Unknown,
            Some(advice) => match advice.subject {
                AdviceSubject::Range => Self::Range,
                AdviceSubject::Step => Self::Step,
                AdviceSubject::Direction => Self::Direction,
                AdviceSubject::Cost => Self::Cost,
                AdviceSubject::Frames if advice.times.is_some() => Self::Times,
                AdviceSubject::Frames | AdviceSubject::Coverage => Self::Frames,
                // Textures that repeat themselves are no fault of the slopes.
                AdviceSubject::Aliases => Self::Unknown,
            },
        }
    }
}

/// Kind of burst, and how its slopes are searched: found, unless the kind says otherwise.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum AdviceKind {
    /// A plane that moves to the right or left.
    Line,
    /// Four layers that move in different directions.
    Plane,
    /// Four layers that move along a line.
    Layers,
    /// Two layers behind a textured thing that stands still and is masked.
    Masked,
    /// Four layers along a line; the two fastest move beyond the range that is given.
    Narrow,
    /// Four layers along a line; the slopes given are too far apart.
    Coarse,
    /// Four layers that move in different directions; a horizontal line of slopes is given.
    Beside,
    /// A plane that moves along a line; a plane of slopes is given.
    Wide,
    /// Layers that stand still; a line of slopes is given.
    Still,
    /// Four layers along a line; two frames stand in each other's place.
    Exchanged,
    /// Two layers along a line, and a camera that goes down and up again.
    Curved,
    /// Noise alone.
    Noise,
}

impl AdviceKind {
    /// All kinds.
    pub const ALL: [Self; 12] = [
        Self::Line,
        Self::Plane,
        Self::Layers,
        Self::Masked,
        Self::Narrow,
        Self::Coarse,
        Self::Beside,
        Self::Wide,
        Self::Still,
        Self::Exchanged,
        Self::Curved,
        Self::Noise,
    ];

    /// Name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Line => "line",
            Self::Plane => "plane",
            Self::Layers => "layers",
            Self::Masked => "masked",
            Self::Narrow => "narrow",
            Self::Coarse => "coarse",
            Self::Beside => "beside",
            Self::Wide => "wide",
            Self::Still => "still",
            Self::Exchanged => "exchanged",
            Self::Curved => "curved",
            Self::Noise => "noise",
        }
    }

    /// Slopes that are searched, and what is true of them; `None` for slopes that are found.
    fn given(self) -> Option<(SlopeGrid, Statement)> {
        let line = |range: f32, count| SlopeGrid::line(-range..=range, count);
        Some(match self {
            Self::Narrow => (line(1.0, 7), Statement::Range),
            Self::Coarse => (line(3.0, 4), Statement::Step),
            Self::Beside => (line(3.0, 19), Statement::Direction),
            Self::Wide => (SlopeGrid::plane(-3.0..=3.0, 13, -3.0..=3.0, 13), Statement::Cost),
            Self::Still => (line(2.0, 13), Statement::Cost),
            _ => return None,
        })
    }
}

/// Kinds of bursts, light and seeds of a study of advice.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "cli", derive(clap::Args))]
pub struct AdviceStudy {
    /// Signal-to-noise ratios of one pixel in one frame, separated by commas; 0.5 or more, 'inf' makes no noise.
    #[cfg_attr(
        feature = "cli",
        arg(long = "snr", value_name = "RATIO,…", value_delimiter = ',', default_values_t = Self::default().snrs)
    )]
    pub snrs: Vec<f64>,
    /// Number of bursts of each kind and ratio.
    #[cfg_attr(feature = "cli", arg(long, value_name = "N", default_value_t = Self::default().seeds))]
    pub seeds: u64,
    /// The first burst's seed.
    #[cfg_attr(feature = "cli", arg(long = "seed", value_name = "FIRST", default_value_t = Self::default().first_seed))]
    pub first_seed: u64,
    /// Columns.
    #[cfg_attr(feature = "cli", arg(long, value_name = "PIXELS", default_value_t = Self::default().width))]
    pub width: usize,
    /// Rows.
    #[cfg_attr(feature = "cli", arg(long, value_name = "PIXELS", default_value_t = Self::default().height))]
    pub height: usize,
}

impl Default for AdviceStudy {
    fn default() -> Self {
        Self { snrs: vec![0.5, 1.0, 2.0, 4.0], seeds: 20, first_seed: 1, width: 240, height: 180 }
    }
}

/// What was said of one burst, and what is true.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AdvisedBurst {
    /// Kind of burst and search.
    pub kind: AdviceKind,
    /// Ratio of signal to noise.
    pub snr: f64,
    /// Seed.
    pub seed: u64,
    /// What the judgement says.
    pub said: Statement,
    /// What is true.
    #[serde(rename = "true")]
    pub truth: Statement,
    /// The judgement's sentence.
    pub sentence: String,
}

impl AdvisedBurst {
    /// Whether something else is said than is true, as if it were known.
    pub fn is_wrong(&self) -> bool {
        self.said != Statement::Unknown && self.said != self.truth
    }
}

/// Bursts of which one statement was made.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SaidRow {
    /// The statement.
    pub said: Statement,
    /// Number of bursts for each truth that occurs.
    #[serde(rename = "true")]
    pub of: BTreeMap<Statement, usize>,
    /// Number of these bursts of which it is wrong; of what is not known nothing is.
    pub wrong: usize,
}

/// Report of a study of advice.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AdviceReport {
    /// Columns of a frame.
    pub width: usize,
    /// Rows of a frame.
    pub height: usize,
    /// Frames of a burst.
    pub frames: usize,
    /// The first seed.
    pub first_seed: u64,
    /// Number of bursts of each kind and ratio.
    pub seeds: u64,
    /// What was said, against what is true: a row for each statement that was made.
    pub rows: Vec<SaidRow>,
    /// Share (0 … 1) of the confident answers that are wrong; `None` without any.
    pub wrong_share: Option<f64>,
    /// All bursts, by kind, ratio and seed.
    pub bursts: Vec<AdvisedBurst>,
}

const FRAMES: usize = 10;
/// Largest slope on an axis, pixels per frame.
const MAX_SLOPE: f64 = 3.0;
/// How far the camera of a curved motion goes down at both ends of the burst, pixels.
const BEND_PX: usize = 9;
/// Displacement in the outermost frames, pixels, by which a motion may differ from the nearest slope searched.
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
        let of_kind = |kind| self.snrs.iter().flat_map(move |&snr| seeds().map(move |seed| (kind, snr, seed)));
        let jobs: Vec<(AdviceKind, f64, u64)> = AdviceKind::ALL.into_iter().flat_map(of_kind).collect();
        let bursts = run_jobs(&jobs, 1, monitor, |&(kind, snr, seed), monitor, steps| {
            let advised = self.advised(kind, snr, seed, monitor)?;
            steps.done();
            Ok(advised)
        })?;
        let row = |said: Statement| {
            let mut row = SaidRow { said, of: BTreeMap::new(), wrong: 0 };
            for burst in bursts.iter().filter(|burst| burst.said == said) {
                *row.of.entry(burst.truth).or_default() += 1;
                row.wrong += usize::from(burst.is_wrong());
            }
            row
        };
        let rows = Statement::ALL.into_iter().map(row).filter(|row| !row.of.is_empty()).collect();
        let confident = bursts.iter().filter(|burst| burst.said != Statement::Unknown).count();
        let wrong = bursts.iter().filter(|burst| burst.is_wrong()).count();
        let wrong_share = (confident > 0).then(|| wrong as f64 / confident as f64);
        let Self { width, height, first_seed, seeds, .. } = *self;
        Ok(AdviceReport { width, height, frames: FRAMES, first_seed, seeds, rows, wrong_share, bursts })
    }

    fn advised(&self, kind: AdviceKind, snr: f64, seed: u64, monitor: &Monitor) -> Result<AdvisedBurst> {
        let (burst, truth) = self.burst(kind, snr, seed, monitor)?;
        let given = kind.given();
        let slopes = given.map_or(Slopes::AUTO, |(grid, _)| grid.into());
        let asked = SearchParams { slopes, ..SearchParams::default() };
        let Searched { detection, params, finding, .. } = search(&burst, &asked, monitor)?;
        let shown = match finding {
            Some(finding) => finding,
            None => find_slopes(&burst, &params, None, monitor)?,
        };
        let judged = judgement(&detection, &params, Some(&shown), &burst, monitor)?;
        let (said, sentence) =
            judged.map_or((Statement::Unknown, String::new()), |j| (Statement::said(&j), j.sentence));
        let truth = match (kind, given) {
            (_, Some((_, truth))) => truth,
            (AdviceKind::Exchanged, _) => Statement::Times,
            (AdviceKind::Curved, _) => Statement::Frames,
            (AdviceKind::Noise, _) => Statement::Unknown,
            _ => truth_of(&truth, &params.used_slopes(), &burst.positions),
        };
        Ok(AdvisedBurst { kind, snr, seed, said, truth, sentence })
    }

    fn burst(&self, kind: AdviceKind, snr: f64, seed: u64, monitor: &Monitor) -> Result<(Burst, Option<Truth>)> {
        if kind == AdviceKind::Noise {
            let size = (self.width, self.height);
            return Ok((NoiseCase::White.burst(size, FRAMES, 0.02, seed, monitor)?, None));
        }
        let (layers, motion) = match kind {
            AdviceKind::Line | AdviceKind::Wide => (1, Motion::OneD),
            AdviceKind::Plane | AdviceKind::Beside => (4, Motion::TwoD),
            AdviceKind::Masked | AdviceKind::Curved => (2, Motion::OneD),
            _ => (4, Motion::OneD),
        };
        let bend = if kind == AdviceKind::Curved { BEND_PX } else { 0 };
        let params = SceneParams {
            width: self.width,
            height: self.height + bend,
            layers,
            frames: FRAMES,
            uneven: Uneven {
                exchange: if kind == AdviceKind::Exchanged { exchanged(seed) } else { Vec::new() },
                ..Uneven::default()
            },
            mask: if kind == AdviceKind::Masked { 0.25 } else { 0.0 },
            motion,
            max_slope: if kind == AdviceKind::Still { 0.0 } else { MAX_SLOPE },
            snr,
            seed,
            ..SceneParams::default()
        };
        let (mut burst, truth) = synth_scene(&params, monitor)?;
        // Nobody has told the times of the frames.
        burst.positions = Positions::even(FRAMES);
        if bend > 0 {
            burst = bent(burst, self.height);
        }
        Ok((truth.masked(burst), Some(truth)))
    }
}

/// Two neighbours or frames apart, by the seed.
fn exchanged(seed: u64) -> Vec<usize> {
    let first = (seed % (FRAMES as u64 - 3)) as usize;
    vec![first, first + 1 + (seed / 2 % 2) as usize]
}

/// The `height` rows that a camera shows which is lowest in the first and last frame, on a parabola between them.
fn bent(mut burst: Burst, height: usize) -> Burst {
    let middle = 0.5 * (FRAMES - 1) as f64;
    for (t, frame) in burst.frames.iter_mut().enumerate() {
        let down = (((t as f64 - middle) / middle).powi(2) * BEND_PX as f64).round() as usize;
        *frame = Arc::new(Plane::from_fn(frame.width(), height, |u, v| frame.at(u, v + down)));
    }
    burst
}

/// What is true of slopes that were found: that they hold the motions of all layers, or why not.
fn truth_of(truth: &Option<Truth>, grid: &SlopeGrid, positions: &Positions) -> Statement {
    let steps = [grid.u, grid.v].map(|axis| 0.5 * axis.step());
    let beside = steps[0].hypot(steps[1]).max(BESIDE_PX / positions.reach() as f32);
    let is_far = |slope: &Slope| {
        let nearest = grid.slope(grid.nearest(*slope));
        (slope.u - nearest.u).hypot(slope.v - nearest.v) > beside
    };
    let layers = truth.iter().flat_map(|truth| &truth.layers);
    let mut missed =
        layers.map(|layer| Slope::new(layer.slope_u as f32, layer.slope_v as f32)).filter(is_far).peekable();
    if missed.peek().is_none() {
        return Statement::Fits;
    }
    let across = |slope: Slope| {
        let turn = f64::from(grid.direction_deg).to_radians();
        (f64::from(slope.v) * turn.cos() - f64::from(slope.u) * turn.sin()).abs() as f32
    };
    if grid.v.count == 1 && missed.any(|slope| across(slope) > beside) {
        Statement::Direction
    } else {
        Statement::Range
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn found_slopes_are_true_where_they_hold_all_layers() {
        let (_, truth) =
            synth_scene(&SceneParams { motion: Motion::TwoD, ..SceneParams::default() }, &Monitor::default())
                .expect("a scene");
        let (truth, even) = (Some(truth), Positions::even(FRAMES));
        let of = |grid: SlopeGrid| truth_of(&truth, &grid, &even);
        assert_eq!(of(SlopeGrid::plane(-3.0..=3.0, 19, -3.0..=3.0, 19)), Statement::Fits);
        assert_eq!(of(SlopeGrid::plane(-1.0..=1.0, 7, -3.0..=3.0, 19)), Statement::Range);
        assert_eq!(of(SlopeGrid::line(-3.0..=3.0, 19)), Statement::Direction);
    }

    #[test]
    fn a_table_sums_to_the_bursts_whatever_the_threads() {
        let study = AdviceStudy { snrs: vec![2.0], seeds: 1, width: 160, height: 120, ..AdviceStudy::default() };
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
            pool.install(|| study.run(&Monitor::default())).expect("a report")
        };
        let report = on(1);
        assert_eq!(report, on(2));
        assert_eq!(report.bursts.len(), AdviceKind::ALL.len());
        let counts = report.rows.iter().flat_map(|row| row.of.values());
        assert_eq!(counts.sum::<usize>(), report.bursts.len());
        let wrong = report.bursts.iter().filter(|burst| burst.is_wrong()).count();
        assert_eq!(report.rows.iter().map(|row| row.wrong).sum::<usize>(), wrong);
        let of = |kind| report.bursts.iter().find(|burst| burst.kind == kind).expect("of each");
        assert_eq!((of(AdviceKind::Noise).said, of(AdviceKind::Line).said), (Statement::Unknown, Statement::Fits));
    }

    #[test]
    fn nonsense_is_refused() {
        for (study, start) in [
            (AdviceStudy { snrs: Vec::new(), ..AdviceStudy::default() }, "snr"),
            (AdviceStudy { seeds: 0, ..AdviceStudy::default() }, "seeds"),
            (AdviceStudy { seeds: u64::MAX, ..AdviceStudy::default() }, "seeds"),
            (AdviceStudy { width: 3, ..AdviceStudy::default() }, "width"),
        ] {
            let error = study.run(&Monitor::default()).expect_err(start).to_string();
            assert!(error.starts_with(start), "{error}");
        }
    }
}
