//! Advice on the slopes: each piece is a number, a sentence, and the change that applies it. There is none when none is
//! needed.

use super::loss::off_by;
use super::{Spectrum, step_loss};
use crate::detector::params::doc;
use crate::detector::scale_space::levels::ScaleSpace;
use crate::detector::slopes::SlopeEvidence;
use crate::detector::{Method, ParamChange, SlopeAxis, SlopeGrid, SlopeVerdict};
use crate::inspect::ProbeCache;
use crate::inspect::words::{counted, number};
use serde::Serialize;

/// Subject of a piece of advice.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Subject {
    /// The range is too narrow.
    Range,
    /// The step is too coarse.
    Step,
    /// The motion is not along the line that is searched.
    Direction,
    /// Frames add nothing, because the motion is not straight.
    Frames,
    /// A texture responds at several of the slopes searched.
    Aliases,
    /// Much of the picture leaves the frames at the relevant slopes.
    Coverage,
    /// More slopes are searched than needed.
    Cost,
}

/// A piece of advice.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SlopeAdvice {
    /// Subject of the advice.
    pub subject: Subject,
    /// Number that the advice is based on: the part of the evidence beyond the range; the loss at half a step; the part
    /// of the evidence off the line; the number of frames that add nothing; the period in px; the share covered; the
    /// part of the slopes that is needed.
    pub number: f64,
    /// Problem and its reason, as a sentence.
    pub sentence: String,
    /// Changes that apply it: one setting, or more where one alone makes no sense.
    pub changes: Vec<ParamChange>,
}

/// Loss at half a step from which the step is too coarse.
const TOO_COARSE: f32 = 0.15;
/// Loss of the finest blob off the line from which a window is evidence for another direction.
const OFF_LINE: f32 = 0.25;
/// Part of the evidence off the line from which another direction is advised.
const OFF_LINE_PART: f32 = 0.2;
/// Part of the slopes that suffices, below which the search is said to cost too much.
const NEEDED: f64 = 0.4;

/// All advice, the most important first.
pub(super) fn advice(cache: &ProbeCache, spectrum: &Spectrum) -> Vec<SlopeAdvice> {
    if cache.params().method != Method::Buff || spectrum.frames < 2 {
        return Vec::new();
    }
    let telling = Telling { cache, spectrum, sigma: finest_sigma(cache) };
    let mut advice = Vec::new();
    advice.extend(telling.frames());
    advice.extend(telling.direction());
    advice.extend(telling.range());
    advice.extend(telling.step());
    advice.extend(telling.coverage());
    advice.extend(telling.aliases());
    // Advice on missing slopes comes before advice on superfluous ones.
    if advice.is_empty() {
        advice.extend(telling.cost());
    }
    advice
}

/// σ of the finest features, px.
fn finest_sigma(cache: &ProbeCache) -> f32 {
    let space = ScaleSpace::of(cache.params());
    space.sigma_image(space.first_octave, 0.0) as f32
}

/// Data from which the advice is made.
pub(super) struct Telling<'a> {
    pub cache: &'a ProbeCache,
    pub spectrum: &'a Spectrum,
    /// σ of the finest features, px.
    sigma: f32,
}

impl Telling<'_> {
    pub(super) fn grid(&self) -> SlopeGrid {
        self.spectrum.grid
    }

    /// The step that the finest features need, px/frame.
    fn right_step(&self) -> f32 {
        2.0 * self.sigma / (self.spectrum.frames - 1) as f32
    }

    pub(super) fn evidence(&self) -> &[SlopeEvidence] {
        &self.spectrum.evidence
    }

    /// The part of the evidence that satisfies `holds`.
    pub(super) fn part(&self, holds: impl Fn(&SlopeEvidence) -> bool) -> f32 {
        let sum = |evidence: &mut dyn Iterator<Item = &SlopeEvidence>| evidence.map(|e| e.significance).sum::<f32>();
        let all = sum(&mut self.evidence().iter());
        if all > 0.0 { sum(&mut self.evidence().iter().filter(|e| holds(e))) / all } else { 0.0 }
    }

    /// The coordinate of the evidence along an axis of the grid, px/frame.
    pub(super) fn along(&self, e: &SlopeEvidence, second: bool) -> f32 {
        let line = SlopeGrid {
            u: SlopeAxis { min: 0.0, max: 1.0, count: 2 },
            v: SlopeAxis { min: 0.0, max: 1.0, count: 2 },
            direction_deg: self.grid().direction_deg,
        };
        let (a, b) = line.position(e.slope);
        if second { b } else { a }
    }

    /// The range of the evidence along an axis.
    pub(super) fn reach(&self, second: bool) -> Option<(f32, f32)> {
        let values = self.evidence().iter().map(|e| self.along(e, second));
        let (min, max) = values.fold((f32::INFINITY, f32::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
        (min <= max).then_some((min, max))
    }

    fn step(&self) -> Option<SlopeAdvice> {
        let (grid, frames) = (self.grid(), self.spectrum.frames);
        let axes = [(doc::SLOPES_U, grid.u), (doc::SLOPES_V, grid.v)];
        let coarse = |axis: &SlopeAxis| (step_loss(axis.step(), frames, self.sigma), *axis);
        let found: Vec<_> = axes
            .into_iter()
            .filter(|(_, axis)| axis.count > 1)
            .map(|(parameter, axis)| (parameter, coarse(&axis)))
            .filter(|(_, (loss, _))| *loss > TOO_COARSE)
            .collect();
        let (_, (loss, axis)) = *found.iter().max_by(|a, b| a.1.0.total_cmp(&b.1.0))?;
        let wanted = self.right_step();
        let changes = found
            .iter()
            .map(|(parameter, (_, axis))| {
                let count = ((axis.max - axis.min) / wanted - 0.05).ceil() as usize + 1;
                ParamChange::new(*parameter, SlopeAxis { count, ..*axis })
            })
            .collect();
        let sentence = format!(
            "a step of {} px/frame moves the outermost of {frames} frames by {} px between two slopes: half-way the finest features (σ {} px) lose {:.0} % of their response; a step of {} loses {:.0} %",
            number(axis.step(), 2),
            number(0.5 * axis.step() * (frames - 1) as f32, 1),
            number(self.sigma, 1),
            100.0 * loss,
            number(wanted, 2),
            100.0 * step_loss(wanted, frames, self.sigma)
        );
        Some(SlopeAdvice { subject: Subject::Step, number: f64::from(loss), sentence, changes })
    }

    fn direction(&self) -> Option<SlopeAdvice> {
        let grid = self.grid();
        if grid.is_plane() || grid.len() == 1 {
            return None;
        }
        // A line may also be the second axis.
        let second_is_across = grid.v.count == 1;
        let fixed = if second_is_across { grid.v.value(0.0) } else { grid.u.value(0.0) };
        let off = |e: &SlopeEvidence| {
            let across = (self.along(e, second_is_across) - fixed).abs();
            off_by((across - e.uncertainty).max(0.0), self.spectrum.frames, self.sigma) > OFF_LINE
        };
        let part = self.part(off);
        if part <= OFF_LINE_PART {
            return None;
        }
        let found = self.spectrum.finding.grid;
        let is_line = found.v.count == 1 && found.u.count > 1;
        let mut changes = vec![ParamChange::new(doc::SLOPES_U, found.u), ParamChange::new(doc::SLOPES_V, found.v)];
        if found.direction_deg != grid.direction_deg {
            changes.push(ParamChange::new(doc::SLOPE_DIRECTION, found.direction_deg));
        }
        let what = if is_line {
            format!("a line at {}° fits it", number(found.direction_deg, 0))
        } else {
            "it needs slopes in two directions".to_owned()
        };
        let sentence =
            format!("{:.0} % of what the frames show does not move along the searched line: {what}", 100.0 * part);
        Some(SlopeAdvice { subject: Subject::Direction, number: f64::from(part), sentence, changes })
    }

    fn cost(&self) -> Option<SlopeAdvice> {
        if !matches!(self.spectrum.finding.verdict, SlopeVerdict::Found | SlopeVerdict::Still) {
            return None;
        }
        let (grid, found) = (self.grid(), self.spectrum.finding.grid);
        let part = found.len() as f64 / grid.len() as f64;
        if part > NEEDED {
            return None;
        }
        let sentence = format!(
            "{} were searched, and {} are enough: nothing in the frames has other motions",
            counted(grid.len(), "slope"),
            found.len()
        );
        let mut changes = vec![ParamChange::new(doc::SLOPES_U, found.u), ParamChange::new(doc::SLOPES_V, found.v)];
        if found.direction_deg != grid.direction_deg {
            changes.push(ParamChange::new(doc::SLOPE_DIRECTION, found.direction_deg));
        }
        Some(SlopeAdvice { subject: Subject::Cost, number: part, sentence, changes })
    }
}
