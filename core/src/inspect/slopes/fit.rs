//! Judgement of the slopes of a search: one sentence, and one set of changes that mends whatever is wrong: direction,
//! range and step of both axes at once. The *evidence* of the frames decides; the features *at the limit*
//! (`limit`) only where the frames show nothing clear.

use super::{AdviceSubject, SlopeAdvice};
use crate::burst::{Burst, Positions, TimesChoice};
use crate::detector::field::{Beyond, FIELD_BEYOND};
use crate::detector::scale_space::ScaleSpace;
use crate::detector::slopes::{SlopeEvidence, axis_through, slopes_needed};
use crate::detector::{
    Detection, DetectorParams, Feature, FrameRange, Method, MotionField, ParamChange, Slope, SlopeAxis, SlopeFinding,
    SlopeGrid, SlopeVerdict,
};
use crate::detector::{limit::response_loss, params::doc};
use crate::inspect::words::{counted, grouped, number};
use crate::monitor::{Cancelled, Monitor};
use serde::Serialize;
use std::ops::Range;

/// Loss of the finest features half-way between two slopes from which the step is too coarse.
const TOO_COARSE: f32 = 0.15;
/// Loss of the finest features beside the searched line from which a window is evidence for another direction.
const OFF_LINE: f32 = 0.25;
/// Part of the evidence beside the line from which another direction is advised.
const OFF_LINE_PART: f32 = 0.2;
/// Part of the evidence beyond the range from which a wider range is advised.
const BEYOND: f32 = 0.08;
/// Part of the slopes that suffices, up to which the search is said to cost too much.
const NEEDED: f64 = 0.4;
/// Part of the stronger half of the features at the limit from which a wider range is advised. It is at most 0.036 for
/// motions inside the range (0.012 but for the corners of planes), and 0.12 or more half a step beyond it.
const AT_LIMIT: f64 = 0.08;
/// Part of those that must lie at one end of an axis for the axis to be widened there.
const OF_THOSE: f64 = 0.25;
const ENOUGH_FEATURES: usize = 10;
/// Tolerated deviation from a uniform motion, pixels: about the blur that smears the finest features.
const STRAIGHT_PX: f32 = 1.4;
/// Part of the motion seen that slopes hold at least where they fit.
const FITS: f32 = 0.8;
/// Sum of the significances of the evidence from which slopes can fit: in frames that show less, a layer, an exchange
/// of frames and a bend go unseen.
const SHOWN: f32 = 600.0;
/// Such a sum from which nothing moves where all of it is slow: still frames show 300 or more at SNR 0.5.
const STILL: f32 = 150.0;
/// Smallest number of frames of which an even motion is reported.
const FEWEST: usize = 3;

/// Judgement of the slopes of a search.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SlopeJudgement {
    /// Sentence: a clause without a capital at its start or a full stop at its end.
    pub sentence: String,
    /// Whether the frames show that the slopes fit: not where there is a fault, nor where they show too little.
    pub fits: bool,
    /// The fault, with the changes that mend it; `None` where the slopes fit or cannot be judged.
    pub advice: Option<SlopeAdvice>,
}

impl SlopeJudgement {
    /// Whether the slopes hold the motion that the frames show, also if they are too many; `None` if too little shows.
    pub fn holds(&self) -> Option<bool> {
        self.advice.as_ref().map(|advice| advice.subject == AdviceSubject::Cost).or(self.fits.then_some(true))
    }
}

/// Judges the slopes with which `detection` was made from `burst`; `finding` is what the frames show, if it is known.
/// Slopes fit only where the motion is straight and lies inside. `None` for a method without slopes, or one frame.
///
/// # Errors
/// [`Cancelled`] once `monitor` was cancelled: changes are tried before they are offered.
pub fn judgement(
    detection: &Detection,
    params: &DetectorParams,
    finding: Option<&SlopeFinding>,
    burst: &Burst,
    monitor: &Monitor,
) -> Result<Option<SlopeJudgement>, Cancelled> {
    let evidence = finding.map(|finding| finding.confirmed(params, &burst.positions)).unwrap_or_default();
    let judging = Judging::new(detection, params, finding, &evidence, burst);
    judging.map(|judging| judging.judgement(monitor)).transpose()
}

/// Whether a search by itself makes its slopes doubtful: steps that are too coarse, or features or places of its field
/// beyond an end. Nothing is measured; [`judgement`] with what the frames show finds out what is so.
pub fn is_doubtful(detection: &Detection, params: &DetectorParams, burst: &Burst) -> bool {
    Judging::new(detection, params, None, &[], burst).is_some_and(|judging| {
        let field = judging.field.and_then(|field| field.beyond(&judging.grid, Some(judging.features)));
        field.is_some() || judging.range_by_features().is_some() || judging.coarse().next().is_some()
    })
}

#[derive(Clone, Copy)]
pub(super) struct Judging<'a> {
    pub detection: &'a Detection,
    /// Features that count, and the field of motion over the grid.
    pub features: &'a [Feature],
    pub field: Option<&'a MotionField>,
    pub params: &'a DetectorParams,
    pub finding: Option<&'a SlopeFinding>,
    pub evidence: &'a [SlopeEvidence],
    pub grid: SlopeGrid,
    /// Number of frames used.
    pub frames: usize,
    /// Their positions.
    pub positions: &'a Positions,
    /// σ of the finest features, px.
    pub sigma: f32,
    pub burst: &'a Burst,
}

impl<'a> Judging<'a> {
    /// `None` for a search without slopes.
    pub fn new(
        detection: &'a Detection,
        params: &'a DetectorParams,
        finding: Option<&'a SlopeFinding>,
        evidence: &'a [SlopeEvidence],
        burst: &'a Burst,
    ) -> Option<Self> {
        let frames = detection.frames_used.len();
        let space = ScaleSpace::of(params);
        let sigma = space.sigma_image(space.first_octave, 0.0) as f32;
        let has_slopes = params.method == Method::Buff && frames > 1;
        let grid = params.used_slopes();
        let positions = &detection.positions;
        let (features, field) = (&detection.features[..], detection.field.as_deref());
        let judging =
            Self { detection, features, field, params, finding, evidence, grid, frames, positions, sigma, burst };
        has_slopes.then_some(judging)
    }

    pub fn judgement(&self, monitor: &Monitor) -> Result<SlopeJudgement, Cancelled> {
        let features = self.detection.features.len();
        let at_limit = self.detection.features.iter().filter(|f| f.at_slope_limit).count();
        let clause = match (at_limit, features) {
            (_, 0) => String::new(),
            (0, _) => format!("; none of {} lies at the limit", counted(features, "feature")),
            (1, _) => format!("; 1 of {} lies at the limit", counted(features, "feature")),
            _ => format!("; {} of {} lie at the limit", grouped(at_limit as u64), counted(features, "feature")),
        };
        let mut advice = self.tried(self.advice(), monitor)?;
        // Motion beyond the range that the frames refute hides no later fault.
        if advice.is_none() && self.finding.is_some_and(|finding| finding.grid != self.grid) {
            advice = self.tried(self.step().or_else(|| self.cost()), monitor)?;
        }
        let advice = advice.map(|advice| SlopeAdvice { sentence: advice.sentence + &clause, ..advice });
        let held = self.held();
        let fits = advice.is_none() && self.shown() >= SHOWN && held >= FITS;
        let sentence = match (&advice, self.finding) {
            (Some(advice), _) => advice.sentence.clone(),
            _ if fits => format!("the slopes fit the burst{clause}"),
            (_, Some(_)) if held < FITS && !self.evidence.is_empty() => format!(
                "too little to judge the slopes: {:.0} % of the motion seen lies within them{clause}",
                100.0 * held
            ),
            (_, Some(_)) => format!("the frames show too little to judge the slopes{clause}"),
            (_, None) => format!("the slopes were not compared with the frames, as 'slopes' does{clause}"),
        };
        Ok(SlopeJudgement { sentence, fits, advice })
    }

    /// The sum of the significances of the evidence.
    fn shown(&self) -> f32 {
        self.evidence.iter().map(|evidence| evidence.significance).sum()
    }

    /// The part of the motion seen that the slopes hold.
    fn held(&self) -> f32 {
        self.finding.map_or(0.0, |finding| finding.agreement(&self.grid, self.params, self.positions))
    }

    /// The first fault, with changes that mend this fault and the later ones.
    fn advice(&self) -> Option<SlopeAdvice> {
        self.order().or_else(|| self.frames(true)).or_else(|| self.fault_of_slopes())
    }

    /// The first fault of direction, range and step. The slopes found have none but that the field shows more.
    pub fn fault_of_slopes(&self) -> Option<SlopeAdvice> {
        let found = self.finding.map(|finding| (finding.grid, finding.verdict));
        // Motions within half a step of 0 lose no more there than half-way between two slopes of a right grid.
        let half_step = self.sigma / self.positions.span() as f32;
        let is_slow = self.shown() >= STILL && self.evidence.iter().all(|e| e.slope.magnitude() <= half_step);
        let is_still = is_slow || matches!(found, Some((_, SlopeVerdict::Still)));
        if is_still && self.grid.len() > 1 {
            return Some(self.still());
        }
        if found.is_some_and(|(grid, _)| grid == self.grid) {
            return self.range_of_field();
        }
        self.direction()
            .or_else(|| self.range())
            .or_else(|| self.range_by_features())
            .or_else(|| self.range_of_field())
            .or_else(|| self.step())
            .or_else(|| self.cost())
    }

    /// The part of the evidence that satisfies `holds`.
    pub fn part(&self, holds: impl Fn(&SlopeEvidence) -> bool) -> f32 {
        let part = self.evidence.iter().filter(|e| holds(e)).map(|e| e.significance).sum::<f32>();
        part / self.shown().max(f32::MIN_POSITIVE)
    }

    /// The range, along an axis, of the evidence that satisfies `holds`.
    pub fn reach_of(&self, second: bool, holds: impl Fn(f32) -> bool) -> Option<(f32, f32)> {
        let values = self.evidence.iter().map(|e| self.grid.along(e.slope, second)).filter(|x| holds(*x));
        let (min, max) = values.fold((f32::INFINITY, f32::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
        (min <= max).then_some((min, max))
    }

    pub fn changes_to(&self, wanted: SlopeGrid) -> Vec<ParamChange> {
        let grid = self.grid;
        let axis = |parameter, own, wanted| (wanted != own).then(|| ParamChange::new(parameter, wanted));
        let (u, v) = (axis(doc::SLOPES_U, grid.u, wanted.u), axis(doc::SLOPES_V, grid.v, wanted.v));
        let turned = wanted.direction_deg != grid.direction_deg;
        let direction = turned.then(|| ParamChange::new(doc::SLOPE_DIRECTION, wanted.direction_deg));
        [u, v, direction].into_iter().flatten().collect()
    }

    fn still(&self) -> SlopeAdvice {
        let slopes = self.grid.len();
        let one = SlopeGrid::single(Slope::default());
        let sentence = format!("nothing moves, so one slope, 0, is enough: {} were searched", counted(slopes, "slope"));
        let changes = self.changes_to(SlopeGrid { direction_deg: self.grid.direction_deg, ..one });
        SlopeAdvice::new(AdviceSubject::Cost, 1.0 / slopes as f64, sentence, changes)
    }

    /// The times found, where those of the frames are wrong.
    fn order(&self) -> Option<SlopeAdvice> {
        let finding = self.finding.filter(|finding| finding.uniform.is_some())?;
        let number = finding.warnings.iter().map(|warning| warning.frames.len()).sum::<usize>() as f64;
        let (sentence, times) = (finding.irregularities(), Some(TimesChoice::Found));
        Some(SlopeAdvice { subject: AdviceSubject::Frames, number, sentence, changes: Vec::new(), times })
    }

    /// Frames too many, where the motion is not straight or carries the picture away: `fewer`, or the reason alone.
    pub fn frames(&self, fewer: bool) -> Option<SlopeAdvice> {
        let (finding, frames) = (self.finding?, self.frames);
        let (left, why) = match finding.verdict {
            SlopeVerdict::NotStraight => {
                let px = number(finding.deviation_px.filter(|off| *off > STRAIGHT_PX)?, 1);
                let why = match finding.warnings[..] {
                    [] => format!("the motion is not straight: it deviates from a uniform one by up to {px} px"),
                    _ => finding.irregularities(),
                };
                let is_even =
                    |count: &usize| finding.deviation_of_middle.get(*count).is_some_and(|px| *px <= STRAIGHT_PX);
                ((FEWEST..frames).rev().find(is_even), why)
            }
            SlopeVerdict::Film => {
                let (width, height) = self.burst.size();
                let (part, px) = (finding.moved_px / width.min(height) as f32, number(finding.moved_px, 0));
                let why = format!("the picture moves by {px} px over the frames, more than a third of it");
                (Some((frames as f32 * 0.25 / part.max(0.25)) as usize), why)
            }
            _ => return None,
        };
        let Some(left) = left.filter(|_| fewer).map(|left| left.clamp(2, frames)) else {
            return Some(SlopeAdvice::new(AdviceSubject::Frames, frames as f64, why, Vec::new()));
        };
        let (blur, add) = (frames - left, if frames - left == 1 { "adds" } else { "add" });
        let sentence = format!("{why}; {blur} of the {frames} frames {add} nothing but blur");
        let changes = vec![self.middle_frames(left)];
        (blur > 0).then(|| SlopeAdvice::new(AdviceSubject::Frames, blur as f64, sentence, changes))
    }

    pub fn middle_frames(&self, count: usize) -> ParamChange {
        let (first, middle) = (self.detection.frames_used.start, self.middle(count));
        ParamChange::new(doc::FRAMES, FrameRange { start: first + middle.start, end: first + middle.end })
    }

    /// The middle `count` of the frames used.
    pub fn middle(&self, count: usize) -> Range<usize> {
        let start = (self.frames - count.min(self.frames)) / 2;
        start..start + count.min(self.frames)
    }

    fn direction(&self) -> Option<SlopeAdvice> {
        let (grid, found) = (self.grid, self.finding?.grid);
        if grid.is_plane() {
            return None;
        }
        let is_off = |e: &SlopeEvidence| {
            let off = |axis: &SlopeAxis, second: bool| match axis.count {
                1 => self.grid.along(e.slope, second) - axis.value(0.0),
                _ => 0.0,
            };
            let across = off(&grid.u, false).hypot(off(&grid.v, true));
            response_loss((across - e.uncertainty).max(0.0), self.positions, self.sigma) > OFF_LINE
        };
        let part = self.part(is_off);
        if part <= OFF_LINE_PART {
            return None;
        }
        let degrees = number(found.direction_deg, 0);
        let how = match (found.u.count, found.v.count) {
            _ if grid.len() == 1 => "at the one slope that was searched".to_owned(),
            (2.., 1) => format!("along the searched line: a line at {degrees}° fits it"),
            _ => "along the searched line: it needs slopes in two directions".to_owned(),
        };
        let sentence = format!("{:.0} % of what the frames show does not move {how}", 100.0 * part);
        Some(SlopeAdvice::new(AdviceSubject::Direction, f64::from(part), sentence, self.changes_to(found)))
    }

    fn range(&self) -> Option<SlopeAdvice> {
        let finding = self.finding?;
        let is_beyond = |axis: &SlopeAxis, x: f32| {
            let margin = 0.5 * axis.step();
            x < axis.min - margin || x > axis.max + margin
        };
        let part =
            self.part(|e| self.grid.axes().any(|(second, axis)| is_beyond(&axis, self.grid.along(e.slope, second))));
        if part <= BEYOND {
            return None;
        }
        let beyond: Vec<String> = self
            .grid
            .axes()
            .filter(|(second, axis)| self.part(|e| is_beyond(axis, self.grid.along(e.slope, *second))) > 0.5 * BEYOND)
            .map(|(second, axis)| self.beyond_text(second, axis, is_beyond))
            .collect();
        let is_coarse = |second: bool| self.coarse().any(|(axis, ..)| axis == second);
        let steps = self.grid.axes().filter(|(second, _)| is_coarse(*second));
        let steps =
            steps.map(|(second, axis)| format!("{} by {}", if second { "v" } else { "u" }, number(axis.step(), 2)));
        let steps = steps.collect::<Vec<_>>().join(" and ");
        let too_coarse = if steps.is_empty() { String::new() } else { format!("; steps of {steps} are too coarse") };
        let sentence = format!("{:.0} % of what the frames show {}{too_coarse}", 100.0 * part, beyond.join(", and "));
        let grid = self.grid;
        let wanted = match (grid.u.count > 1, grid.v.count > 1) {
            (true, false) => SlopeGrid { u: widened(&grid.u, self.line(false)?), ..grid },
            (false, true) => SlopeGrid { v: widened(&grid.v, self.line(true)?), ..grid },
            _ if grid.direction_deg != finding.grid.direction_deg => finding.grid,
            _ => SlopeGrid { u: widened(&grid.u, finding.grid.u), v: widened(&grid.v, finding.grid.v), ..grid },
        };
        Some(SlopeAdvice::new(AdviceSubject::Range, f64::from(part), sentence, self.changes_to(wanted)))
    }

    /// The range of the evidence along an axis of the grid.
    fn line(&self, second: bool) -> Option<SlopeAxis> {
        let degrees = self.grid.direction_deg + if second { 90.0 } else { 0.0 };
        axis_through(self.evidence, self.params, self.positions, degrees)
    }

    /// The part of the sentence about one axis, some of whose evidence lies beyond its range.
    fn beyond_text(&self, second: bool, axis: SlopeAxis, is_beyond: impl Fn(&SlopeAxis, f32) -> bool) -> String {
        let names = if self.grid.direction_deg == 0.0 { ["u ", "v "] } else { ["", "across "] };
        let name = names[usize::from(second)];
        let range = format!("the range {name}{} to {} px/frame", number(axis.min, 2), number(axis.max, 2));
        // A range on one side of 0, and motion on the other side.
        let side = if axis.max <= -axis.min { -1.0 } else { 1.0 };
        let is_one_sided = (axis.min >= 0.0 || axis.max <= 0.0) && axis.min != -axis.max;
        let is_opposite = |x: f32| is_one_sided && side * x < 0.0 && is_beyond(&axis, x);
        let part = |holds: &dyn Fn(f32) -> bool| self.part(|e| holds(self.grid.along(e.slope, second)));
        let mostly_opposite = part(&is_opposite) > 0.5 * part(&|x| is_beyond(&axis, x));
        match self.reach_of(second, |x| !mostly_opposite || is_opposite(x)) {
            Some((min, max)) if mostly_opposite => {
                format!("moves the other way than {range}: from {} to {}", number(min, 2), number(max, 2))
            }
            reach => {
                let (min, max) = reach.unwrap_or((axis.min, axis.max));
                format!("moves beyond {range}: it reaches from {} to {}", number(min, 2), number(max, 2))
            }
        }
    }

    /// Where a part of the picture moves, by its field and some features, beyond the slopes that the frames show best.
    pub fn beyond(&self) -> Option<Beyond> {
        // Without clear evidence nothing moves surely.
        self.field.filter(|_| !self.evidence.is_empty())?.beyond(&self.grid, Some(self.features))
    }

    fn range_of_field(&self) -> Option<SlopeAdvice> {
        let Beyond { grid, share, ends } = self.beyond()?;
        let end = |(second, end): &(bool, f32)| format!("{} {}", if *second { "v" } else { "u" }, number(*end, 2));
        let (percent, ends) = (100.0 * share, ends.iter().map(end).collect::<Vec<_>>().join(" and "));
        let sentence = format!(
            "{percent:.0} % of the picture moves beyond {ends} px/frame by its field of motion, or is sharpest there"
        );
        Some(SlopeAdvice::new(AdviceSubject::Range, f64::from(share), sentence, self.changes_to(grid)))
    }

    /// Where the frames show nothing clear.
    fn range_by_features(&self) -> Option<SlopeAdvice> {
        // The stronger half: a strong blob beyond the range also leaves weaker smears of itself at other slopes.
        let features = self.features;
        let strong = &features[..features.len().div_ceil(2)];
        let at_limit: Vec<&Feature> = strong.iter().filter(|f| f.at_slope_limit).collect();
        let share = |count: usize, of: usize| count as f64 / of.max(1) as f64;
        let part = share(at_limit.len(), strong.len());
        if features.len() < ENOUGH_FEATURES || part < AT_LIMIT || !self.evidence.is_empty() {
            return None;
        }
        let grid = self.grid;
        let at = |second: bool, f: &Feature| if second { grid.position(f.slope).1 } else { grid.position(f.slope).0 };
        let mut ends: Vec<String> = Vec::new();
        let mut widened = |second: bool, axis: SlopeAxis| {
            let last = axis.count.saturating_sub(1) as f32;
            let mut more = |end: f32, slope: f32| {
                let there = at_limit.iter().filter(|f| at(second, f).clamp(0.0, last).round() == end).count();
                let is_many = axis.count > 1 && share(there, at_limit.len()) >= OF_THOSE;
                ends.extend(is_many.then(|| format!("{} {}", if second { "v" } else { "u" }, number(slope, 2))));
                if is_many { axis.count.saturating_sub(1).div_ceil(2).max(1) } else { 0 }
            };
            let (below, above) = (more(0.0, axis.min), more(last, axis.max));
            axis.with_more(below, above)
        };
        let wanted = SlopeGrid { u: widened(false, grid.u), v: widened(true, grid.v), ..grid };
        let sentence = format!(
            "the response of {:.0} % of the stronger half of the features still rises beyond {} px/frame",
            100.0 * part,
            ends.join(" and ")
        );
        let changes = self.changes_to(wanted);
        (!changes.is_empty()).then(|| SlopeAdvice::new(AdviceSubject::Range, part, sentence, changes))
    }

    /// Axes between whose slopes the finest features lose too much, the number of slopes with which they do not, and
    /// that of now.
    fn coarse(&self) -> impl Iterator<Item = (bool, usize, usize)> {
        let needed = |axis: &SlopeAxis| slopes_needed(axis, self.params, self.positions, self.grid.is_plane());
        let axes = self.grid.axes().filter(|(_, axis)| self.loss(axis) > TOO_COARSE);
        axes.map(move |(second, axis)| (second, needed(&axis), axis.count)).filter(|(_, needed, own)| needed > own)
    }

    /// Loss of the finest features half-way between two slopes of an axis.
    fn loss(&self, axis: &SlopeAxis) -> f32 {
        response_loss(0.5 * axis.step(), self.positions, self.sigma)
    }

    /// Slopes as close as is needed, or those found, where fewer hold all that moves.
    fn step(&self) -> Option<SlopeAdvice> {
        let mut wanted = self.grid;
        for (second, count, _) in self.coarse() {
            let axis = if second { &mut wanted.v } else { &mut wanted.u };
            // A line that is far longer than the motion along it is cut to that.
            let own = self.line(second).filter(|own| !self.grid.is_plane() && 2 * own.count < count);
            *axis = own.unwrap_or(SlopeAxis { count, ..*axis });
        }
        let changed = self.grid.axes().filter(|(second, axis)| *axis != if *second { wanted.v } else { wanted.u });
        let axis = changed.map(|(_, axis)| axis).max_by(|a, b| a.step().total_cmp(&b.step()))?;
        wanted = (Self { grid: wanted, ..*self }).fewer().unwrap_or(wanted);
        let finer = wanted.axes().map(|(_, axis)| axis).max_by(|a, b| a.step().total_cmp(&b.step()))?;
        let (step, finer_step, frames) = (number(axis.step(), 2), number(finer.step(), 2), self.frames);
        let moved = number(axis.step() * self.positions.reach() as f32, 1);
        let (sigma, lost, lost_then) = (number(self.sigma, 1), 100.0 * self.loss(&axis), 100.0 * self.loss(&finer));
        let sentence = format!(
            "a step of {step} px/frame moves the outermost of {frames} frames by {moved} px between two slopes: half-way the finest features (σ {sigma} px) lose {lost:.0} % of their response; a step of {finer_step} loses {lost_then:.0} %"
        );
        let changes = self.changes_to(wanted);
        Some(SlopeAdvice::new(AdviceSubject::Step, f64::from(self.loss(&axis)), sentence, changes))
    }

    /// The slopes found, where they are so few of the grid's that the others are searched for nothing.
    fn fewer(&self) -> Option<SlopeGrid> {
        let found = self.finding.filter(|finding| finding.verdict == SlopeVerdict::Found)?.grid;
        let is_few = found.len() as f64 <= NEEDED * self.grid.len() as f64;
        // A motion that is not known lies at an end of the grid of now, not beyond the slopes found.
        let moves_beyond = |field: &MotionField| field.known_beyond(&found) > FIELD_BEYOND;
        (is_few && !self.field.is_some_and(moves_beyond)).then_some(found)
    }

    fn cost(&self) -> Option<SlopeAdvice> {
        // Where what moves has other slopes than those searched, it needs others, not fewer.
        let found = self.fewer().filter(|_| self.held() >= FITS)?;
        let part = found.len() as f64 / self.grid.len() as f64;
        let (searched, enough) = (counted(self.grid.len(), "slope"), found.len());
        let sentence =
            format!("{searched} were searched, and {enough} are enough: nothing in the frames has other motions");
        Some(SlopeAdvice::new(AdviceSubject::Cost, part, sentence, self.changes_to(found)))
    }
}

/// `axis` with as many more of its steps as reach the ends of `found`, so that its slopes need no new search; `found`
/// where its steps are wider by more than a tenth, or that would be more than twice as many slopes.
fn widened(axis: &SlopeAxis, found: SlopeAxis) -> SlopeAxis {
    let (step, most) = (axis.step(), 2 * found.count);
    let more = |px_per_frame: f32| (px_per_frame / step - 0.5).ceil().clamp(0.0, most as f32) as usize;
    let wider = axis.with_more(more(axis.min - found.min), more(found.max - axis.max));
    if step > 0.0 && step <= 1.1 * found.step() && wider.count <= most { wider } else { found }
}
