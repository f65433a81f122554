//! Advice: that of the judgement on direction, range and step; on frames that add nothing, and on frames that much of
//! the picture has left. It is tried before it is offered: the advice that would be given after its changes is
//! computed, from the frames and their field of motion over the changed slopes.

use super::{Spectrum, coverage_share, fit::Judging};
use crate::detector::{
    Feature, ParamChange, Slope, SlopeAxis, SlopeFinding, SlopeGrid, SlopeVerdict, Slopes, find_slopes,
};
use crate::detector::{field::field_over, slopes::UNCERTAIN, slopes::retimed};
use crate::inspect::{ProbeCache, words::slope_text};
use crate::monitor::{Cancelled, Monitor};
use crate::{burst::TimesChoice, detect::search};
use serde::Serialize;

/// Subject of a piece of advice.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum AdviceSubject {
    /// The range is too narrow.
    Range,
    /// The step is too coarse.
    Step,
    /// The motion is not along the line that is searched.
    Direction,
    /// Frames add nothing, because the motion is not straight.
    Frames,
    /// Much of the picture leaves the frames at the relevant slopes.
    Coverage,
    /// More slopes are searched than needed.
    Cost,
}

/// A piece of advice.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SlopeAdvice {
    /// Subject of the advice.
    pub subject: AdviceSubject,
    /// Number that the advice is based on: the part of the evidence beyond the range; the loss at half a step; the part
    /// of the evidence off the line; the number of frames that add nothing; the share covered; the part of the slopes
    /// that is needed.
    pub number: f64,
    /// Problem and its reason, as a sentence.
    pub sentence: String,
    /// Settings to change: several where one alone makes no sense.
    pub changes: Vec<ParamChange>,
    /// Source of the frames' times that applies it, where the frames are at fault.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub times: Option<TimesChoice>,
}

impl SlopeAdvice {
    pub(super) fn new(subject: AdviceSubject, number: f64, sentence: String, changes: Vec<ParamChange>) -> Self {
        Self { subject, number, sentence, changes, times: None }
    }

    /// Options of the command line that apply it; empty where none does.
    pub fn options(&self) -> String {
        let times = self.times.iter().map(|times| format!("--times {times}"));
        self.changes.iter().map(ParamChange::option).chain(times).collect::<Vec<_>>().join(" ")
    }
}

pub(super) fn advice(
    cache: &ProbeCache,
    spectrum: &Spectrum,
    monitor: &Monitor,
) -> Result<Vec<SlopeAdvice>, Cancelled> {
    let (finding, evidence) = (Some(&spectrum.finding), &spectrum.evidence);
    let judging = Judging::new(cache.detection(), cache.params(), finding, evidence, &cache.burst);
    let Some(judging) = judging else { return Ok(Vec::new()) };
    let judged = spectrum.judgement.as_ref().and_then(|judgement| judgement.advice.clone());
    // Missing slopes come before superfluous ones, and those of frames that do not move straight after these.
    let is_superfluous = judged.as_ref().is_some_and(|one| one.subject == AdviceSubject::Cost);
    let (missing, superfluous) = if is_superfluous { (None, judged) } else { (judged, None) };
    let coverage = judging.tried(judging.coverage(spectrum), monitor)?;
    Ok([missing, coverage, superfluous].into_iter().flatten().collect())
}

/// Minimum share of the picture that all frames should show at the typical slope of the evidence.
const COVERED: f32 = 0.7;

impl Judging<'_> {
    fn coverage(&self, spectrum: &Spectrum) -> Option<SlopeAdvice> {
        let (size, frames) = (self.burst.size(), spectrum.frames);
        // The typical slope: half of the evidence moves faster.
        let mut slopes: Vec<(Slope, f32)> = spectrum.evidence.iter().map(|e| (e.slope, e.significance)).collect();
        slopes.sort_by(|a, b| a.0.magnitude().total_cmp(&b.0.magnitude()));
        let half = 0.5 * slopes.iter().map(|s| s.1).sum::<f32>();
        let mut sum = 0.0;
        let (typical, _) = *slopes.iter().find(|(_, significance)| {
            sum += significance;
            sum >= half
        })?;
        let covered = |count: usize| coverage_share(typical, &self.positions.part(self.middle(count)), size);
        let share = covered(frames);
        // What is seen has no typical slope where hardly any of it agrees.
        let SlopeFinding { confidence, verdict, .. } = spectrum.finding;
        if share >= COVERED || confidence < UNCERTAIN || verdict == SlopeVerdict::Film {
            return None;
        }
        let enough = (2..frames).rev().find(|&count| covered(count) >= COVERED).unwrap_or(2);
        let (slope, percent, of_middle) = (slope_text(typical), 100.0 * share, 100.0 * covered(enough));
        let sentence = format!(
            "at the typical slope {slope} px/frame all {frames} frames show only {percent:.0} % of the picture; the middle {enough} show {of_middle:.0} %"
        );
        let changes = vec![self.middle_frames(enough)];
        Some(SlopeAdvice::new(AdviceSubject::Coverage, f64::from(share), sentence, changes))
    }

    /// `advice` with changes that help: its own, or those to the slopes found. A fault that neither mends is said
    /// without changes; a saving that does not help is not said at all, nor is what the frames refute.
    pub fn tried(&self, advice: Option<SlopeAdvice>, monitor: &Monitor) -> Result<Option<SlopeAdvice>, Cancelled> {
        let Some(advice) = advice else { return Ok(None) };
        let unmended = SlopeAdvice { changes: Vec::new(), times: None, ..advice.clone() };
        if advice.times.is_some() {
            return Ok(Some(if self.is_even_after(monitor)? { advice } else { unmended }));
        }
        let params = ParamChange::all_applied(&advice.changes, self.params).ok();
        if let Some(params) = params.as_ref().filter(|params| params.frames != self.params.frames) {
            let after = find_slopes(self.burst, params, None, &monitor.silent())?;
            let helps = matches!(after.verdict, SlopeVerdict::Found | SlopeVerdict::Still) && after.uniform.is_none();
            return Ok(if helps { Some(advice) } else { self.frames(false).or(Some(unmended)) });
        }
        // None that has more slopes than can be searched.
        let wanted = params.map(|params| params.used_slopes());
        if advice.changes.is_empty() || wanted == Some(self.grid) {
            return Ok(Some(advice));
        }
        if let Some(beyond) = self.beyond().filter(|beyond| wanted == Some(beyond.grid)) {
            let is_held = beyond.is_held(Some(&self.grid), self.burst, self.detection.frames_used.clone(), monitor)?;
            return Ok(is_held.then_some(advice));
        }
        let own = if advice.subject == AdviceSubject::Cost { None } else { self.own_slopes(monitor)? };
        // Where all of a range would cost more than twice what the motion's own does, that is tried first.
        let is_dear = own.zip(wanted).is_some_and(|(own, wanted)| 2 * own.len() < wanted.len());
        let grids = if is_dear { [own, wanted] } else { [wanted, own] };
        for grid in grids.into_iter().flatten().filter(|grid| *grid != self.grid) {
            if self.is_mended_by(grid, own, monitor)? {
                return Ok(Some(SlopeAdvice { changes: self.changes_to(grid), ..advice }));
            }
        }
        Ok((advice.subject != AdviceSubject::Cost).then_some(unmended))
    }

    /// The slopes found, as a search that is to find them widens them. `None` where the frames do not show any.
    fn own_slopes(&self, monitor: &Monitor) -> Result<Option<SlopeGrid>, Cancelled> {
        let Some(finding) = self.finding.filter(|finding| is_of_frames(finding)) else { return Ok(None) };
        let field = field_over(&finding.grid, self.burst, self.detection.frames_used.clone(), monitor)?;
        if field.is_none_or(|field| field.beyond(&finding.grid, None).is_none()) {
            return Ok(Some(finding.grid));
        }
        // The field alone is not sure of what lies beyond: features bear it out, those of a search over these slopes.
        let searched = search(self.burst, &self.params.clone().with_slopes(Slopes::AUTO), &monitor.silent());
        monitor.check()?;
        Ok(Some(searched.map_or(finding.grid, |searched| searched.params.slopes)))
    }

    /// Whether the frames are even and straight once they have the times found.
    fn is_even_after(&self, monitor: &Monitor) -> Result<bool, Cancelled> {
        let whole = match self.finding.filter(|_| self.params.frames.is_none()) {
            Some(finding) => finding.clone(),
            // The times are found of all frames.
            None => find_slopes(self.burst, &Default::default(), None, &monitor.silent())?,
        };
        Ok(retimed(self.burst, &whole, monitor)?.is_some())
    }

    /// Whether no fault is left with the slopes of `grid`, or none but that of now.
    fn is_mended_by(&self, grid: SlopeGrid, own: Option<SlopeGrid>, monitor: &Monitor) -> Result<bool, Cancelled> {
        let found = self.finding.filter(|finding| is_of_frames(finding)).map(|finding| finding.grid);
        if grid.len() == 1 || own == Some(grid) || own.is_none() && found == Some(grid) {
            return Ok(true);
        }
        // Where a search over the slopes found widens them, others have to reach as far.
        let reaches = |slope: Slope| {
            let is_within = |(second, axis): (bool, SlopeAxis)| {
                let (at, margin) = (grid.along(slope, second), 0.5 * axis.step());
                (axis.min - margin..=axis.max + margin).contains(&at)
            };
            grid.axes().all(is_within)
        };
        if own != found && own.is_some_and(|own| !own.slopes().all(reaches)) {
            return Ok(false);
        }
        let field = field_over(&grid, self.burst, self.detection.frames_used.clone(), monitor)?;
        // What still rises at an end of the slopes of now need not do so inside wider ones, and is not found beyond.
        let is_at_rim = |feature: &Feature| {
            let (i, j) = grid.position(feature.slope);
            let on = |at: f32, n: usize| n > 1 && (at.abs() < 0.5 || (at - n as f32 + 1.0).abs() < 0.5);
            feature.at_slope_limit && (on(i, grid.u.count) || on(j, grid.v.count))
        };
        let features: Vec<Feature> = self.features.iter().filter(|feature| is_at_rim(feature)).copied().collect();
        let after = Judging { grid, field: field.as_ref(), features: &features, ..*self };
        let (now, then) = (self.fault_of_slopes(), after.fault_of_slopes());
        let is_less =
            |now: SlopeAdvice, then: &SlopeAdvice| now.subject == then.subject && then.number < 0.5 * now.number;
        Ok(then.is_none_or(|then| now.is_some_and(|now| is_less(now, &then))))
    }
}

/// Whether the slopes found are those that the frames show.
fn is_of_frames(finding: &SlopeFinding) -> bool {
    matches!(finding.verdict, SlopeVerdict::Found | SlopeVerdict::Still)
}
