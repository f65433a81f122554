//! Advice: that of the judgement on direction, range and step; on aliases that the range need not include; on frames
//! that add nothing, and on frames that much of the picture has left.

use super::judgement::Judging;
use super::{Alias, Spectrum, coverage_share};
use crate::burst::TimesChoice;
use crate::detector::params::doc;
use crate::detector::{ParamChange, Slope, SlopeAxis, SlopeVerdict};
use crate::inspect::ProbeCache;
use crate::inspect::words::{counted, number, slope_text};
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
    /// Source of the frames' times that applies it, where the frames are at fault.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub times: Option<TimesChoice>,
}

impl SlopeAdvice {
    pub(super) fn new(subject: Subject, number: f64, sentence: String, changes: Vec<ParamChange>) -> Self {
        Self { subject, number, sentence, changes, times: None }
    }

    /// Options of the command line that apply it; empty where none does.
    pub fn options(&self) -> String {
        let times = self.times.iter().map(|times| format!("--times {times}"));
        self.changes.iter().map(ParamChange::option).chain(times).collect::<Vec<_>>().join(" ")
    }
}

pub(super) fn advice(cache: &ProbeCache, spectrum: &Spectrum) -> Vec<SlopeAdvice> {
    let (finding, evidence, size) = (Some(&spectrum.finding), &spectrum.evidence, cache.burst.size());
    let judging = Judging::new(cache.detection(), cache.params(), finding, evidence, size);
    let Some(judging) = judging else { return Vec::new() };
    let telling = Telling { cache, spectrum, judging };
    let judged = spectrum.judgement.as_ref().and_then(|judgement| judgement.advice.clone());
    // Missing slopes come before superfluous ones, and those of frames that do not move straight after these.
    let is_superfluous = judged.as_ref().is_some_and(|one| one.subject == Subject::Cost);
    let (missing, superfluous) = if is_superfluous { (None, judged) } else { (judged, None) };
    let all = [missing, telling.coverage(), telling.aliases(), superfluous];
    all.into_iter().flatten().collect()
}

struct Telling<'a> {
    cache: &'a ProbeCache,
    spectrum: &'a Spectrum,
    judging: Judging<'a>,
}

/// Minimum share of the picture that all frames should show at the typical slope of the evidence.
const COVERED: f32 = 0.7;
const ALIAS_PLACES: usize = 2;

impl Telling<'_> {
    fn aliases(&self) -> Option<SlopeAdvice> {
        let alias: &Alias =
            self.spectrum.aliases.iter().find(|a| a.inside_range > 0 && a.places.len() >= ALIAS_PLACES)?;
        let [u, v] = alias.places[0];
        let period = number(alias.period_px, 1);
        let ([u, v], lobe) = ([u, v].map(|x| number(x, 0)), 100.0 * alias.side_lobe);
        let (more, times) = (counted(alias.places.len() - 1, "more place"), counted(alias.inside_range, "time"));
        let sentence = format!(
            "the texture around ({u}, {v}) and at {more} repeats every {period} px, so it responds again at slopes {period} px/frame apart, {times} within the range, with side lobes of {lobe:.0} % between them"
        );
        let changes = self.within_a_period(alias).into_iter().collect();
        Some(SlopeAdvice::new(Subject::Aliases, f64::from(alias.period_px), sentence, changes))
    }

    /// The part of the range around the evidence that contains no alias; `None` where the evidence itself needs more.
    fn within_a_period(&self, alias: &Alias) -> Option<ParamChange> {
        let grid = self.judging.grid;
        let of_first = |d: [f32; 2]| {
            let origin = grid.at(0.0, 0.0);
            let to = grid.at(1.0, 0.0);
            grid.u.count > 1 && ((to.u - origin.u) * d[0] + (to.v - origin.v) * d[1]).abs() > 0.5 * grid.u.step()
        };
        let second = !of_first(alias.direction);
        let (parameter, axis) = if second { (doc::SLOPES_V, grid.v) } else { (doc::SLOPES_U, grid.u) };
        let (min, max) = self.judging.reach_of(second, |_| true)?;
        let margin = 0.5 * (0.9 * alias.period_px - (max - min));
        if margin < 0.0 || axis.step() <= 0.0 {
            return None;
        }
        let first = ((min - margin - axis.min) / axis.step()).ceil().max(0.0);
        let last = ((max + margin - axis.min) / axis.step()).floor().min((axis.count - 1) as f32);
        let count = (last - first) as usize + 1;
        (last > first && count < axis.count).then(|| {
            let tidy = |x: f32| (1e4 * x).round() / 1e4;
            let part = SlopeAxis { min: tidy(axis.value(first)), max: tidy(axis.value(last)), count };
            ParamChange::new(parameter, part)
        })
    }

    fn coverage(&self) -> Option<SlopeAdvice> {
        let size = self.cache.burst.size();
        let frames = self.spectrum.frames;
        // The typical slope: half of the evidence moves faster.
        let mut slopes: Vec<(Slope, f32)> = self.spectrum.evidence.iter().map(|e| (e.slope, e.significance)).collect();
        slopes.sort_by(|a, b| a.0.magnitude().total_cmp(&b.0.magnitude()));
        let half = 0.5 * slopes.iter().map(|s| s.1).sum::<f32>();
        let mut sum = 0.0;
        let (typical, _) = *slopes.iter().find(|(_, significance)| {
            sum += significance;
            sum >= half
        })?;
        let covered = |count: usize| {
            let positions = self.judging.positions.part(self.judging.middle(count));
            coverage_share(typical, &positions, size)
        };
        let share = covered(frames);
        if share >= COVERED || self.spectrum.finding.verdict == SlopeVerdict::Film {
            return None;
        }
        let enough = (2..frames).rev().find(|&count| covered(count) >= COVERED).unwrap_or(2);
        let (slope, percent, of_middle) = (slope_text(typical), 100.0 * share, 100.0 * covered(enough));
        let sentence = format!(
            "at the typical slope {slope} px/frame all {frames} frames show only {percent:.0} % of the picture; the middle {enough} show {of_middle:.0} %"
        );
        let changes = vec![self.judging.middle_frames(enough)];
        Some(SlopeAdvice::new(Subject::Coverage, f64::from(share), sentence, changes))
    }
}
