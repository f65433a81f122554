//! Advice on the slopes: each piece is a number, a sentence, and the change that applies it. There is none when none
//! is needed.
//!
//! On the range: motion beyond it, and aliases that it need not include. On the step: the loss of response between
//! two slopes. On the frames: frames that add nothing, and frames that much of the picture has left.

use super::{Alias, Spectrum, coverage_share, off_by, step_loss};
use crate::detector::params::doc;
use crate::detector::scale_space::ScaleSpace;
use crate::detector::slopes::SlopeEvidence;
use crate::detector::{FrameRange, Method, ParamChange, Slope, SlopeAxis, SlopeGrid, SlopeVerdict};
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

/// Part of the evidence beyond the range, and part of the stronger half of the features at its limit, from which advice
/// is given.
const BEYOND: f32 = 0.08;
const AT_LIMIT: f64 = 0.4;
/// Minimum ratio of that part of the features to the part expected on the rim by chance.
const AT_LIMIT_OVER_CHANCE: f64 = 1.4;
/// Minimum number of features for which shares are computed.
const ENOUGH_FEATURES: usize = 10;
/// Minimum number of places of a relevant periodic texture.
const ALIAS_PLACES: usize = 2;

impl Telling<'_> {
    pub(super) fn range(&self) -> Option<SlopeAdvice> {
        let grid = self.grid();
        let axes = [(doc::SLOPES_U, grid.u, false), (doc::SLOPES_V, grid.v, true)];
        let by_evidence = axes.into_iter().filter(|(_, axis, _)| axis.count > 1).find_map(|(parameter, axis, second)| {
            let (min, max) = self.reach(second)?;
            let margin = 0.5 * axis.step();
            let part = self.part(|e| {
                let at = self.along(e, second);
                at < axis.min - margin || at > axis.max + margin
            });
            (part > BEYOND).then(|| {
                let step = axis.step();
                let more = |beyond: f32| if beyond > 0.0 { (beyond / step).ceil() as usize + 1 } else { 0 };
                let wider = axis.with_more(more(axis.min - min), more(max - axis.max));
                let sentence = format!(
                    "{:.0} % of what the frames show moves faster than the range {} to {} px/frame: it reaches from {} to {}{}",
                    100.0 * part,
                    number(axis.min, 2),
                    number(axis.max, 2),
                    number(min, 2),
                    number(max, 2),
                    self.limit_clause()
                );
                SlopeAdvice {
                    subject: Subject::Range,
                    number: f64::from(part),
                    sentence,
                    changes: vec![ParamChange::new(parameter, wider)],
                }
            })
        });
        by_evidence.or_else(|| self.range_by_features())
    }

    fn limit_clause(&self) -> String {
        let Spectrum { at_limit, features, .. } = self.spectrum;
        if *at_limit == 0 {
            return String::new();
        }
        format!("; {at_limit} of {} lie at the limit", counted(*features, "feature"))
    }

    /// Advice from the features at the limit, where the frames give no clear evidence.
    fn range_by_features(&self) -> Option<SlopeAdvice> {
        let (grid, detection) = (self.grid(), self.cache.detection());
        // The stronger half: a strong blob beyond the range also leaves weaker smears of itself at all other slopes.
        let strong = &detection.features[..detection.features.len().div_ceil(2)];
        let share = |count: usize, of: usize| count as f64 / of.max(1) as f64;
        let at_limit = share(strong.iter().filter(|f| f.at_slope_limit).count(), strong.len());
        let rim = self.spectrum.bars.iter().filter(|bar| bar.is_on_rim).count();
        let chance = share(rim, grid.len());
        // Evidence that ends inside the range outweighs features.
        if strong.len() < ENOUGH_FEATURES
            || at_limit < AT_LIMIT.max(AT_LIMIT_OVER_CHANCE * chance)
            || !self.evidence().is_empty()
        {
            return None;
        }
        let max = self.spectrum.bars.iter().filter(|bar| bar.is_on_rim).max_by_key(|bar| bar.features)?;
        let half = |axis: &SlopeAxis| axis.count.saturating_sub(1).div_ceil(2).max(1);
        let [i, j] = max.at;
        let widened = |axis: &SlopeAxis, at: i64| {
            (axis.count > 1 && (at == 0 || at + 1 == axis.count as i64))
                .then(|| axis.with_more(if at == 0 { half(axis) } else { 0 }, if at == 0 { 0 } else { half(axis) }))
        };
        let change = widened(&grid.u, i)
            .map(|axis| ParamChange::new(doc::SLOPES_U, axis))
            .or_else(|| widened(&grid.v, j).map(|axis| ParamChange::new(doc::SLOPES_V, axis)))?;
        let sentence = format!(
            "{:.0} % of the stronger half of the features lie at the limit of the slopes, most of them at {}: the motion probably lies beyond",
            100.0 * at_limit,
            slope_text(max.slope)
        );
        Some(SlopeAdvice { subject: Subject::Range, number: at_limit, sentence, changes: vec![change] })
    }

    pub(super) fn aliases(&self) -> Option<SlopeAdvice> {
        let alias: &Alias =
            self.spectrum.aliases.iter().find(|a| a.inside_range > 0 && a.places.len() >= ALIAS_PLACES)?;
        let [u, v] = alias.places[0];
        let sentence = format!(
            "the texture around ({}, {}) and at {} repeats every {} px, so it responds again at slopes {} px/frame apart, {} within the range, with side lobes of {:.0} % between them",
            number(u, 0),
            number(v, 0),
            counted(alias.places.len() - 1, "more place"),
            number(alias.period_px, 1),
            number(alias.period_px, 1),
            counted(alias.inside_range, "time"),
            100.0 * alias.side_lobe
        );
        Some(SlopeAdvice {
            subject: Subject::Aliases,
            number: f64::from(alias.period_px),
            sentence,
            changes: self.within_a_period(alias).into_iter().collect(),
        })
    }

    /// The part of the range around the unambiguous evidence that contains no alias; `None` where that evidence itself
    /// needs more.
    fn within_a_period(&self, alias: &Alias) -> Option<ParamChange> {
        let grid = self.grid();
        let of_first = |d: [f32; 2]| {
            let origin = grid.at(0.0, 0.0);
            let to = grid.at(1.0, 0.0);
            grid.u.count > 1 && ((to.u - origin.u) * d[0] + (to.v - origin.v) * d[1]).abs() > 0.5 * grid.u.step()
        };
        let second = !of_first(alias.direction);
        let (parameter, axis) = if second { (doc::SLOPES_V, grid.v) } else { (doc::SLOPES_U, grid.u) };
        let (min, max) = self.reach(second)?;
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
}

/// Minimum share of the picture that all frames should show at the typical slope of the evidence.
const COVERED: f32 = 0.7;
/// Tolerated deviation from a uniform motion, pixels: about the blur that smears the finest features.
const STRAIGHT_PX: f32 = 1.4;

impl Telling<'_> {
    pub(super) fn frames(&self) -> Option<SlopeAdvice> {
        let finding = &self.spectrum.finding;
        let frames = self.spectrum.frames;
        let left = match finding.verdict {
            SlopeVerdict::NotStraight => {
                // The deviation of a bent motion grows with the square of the time.
                let off = finding.deviation_px.filter(|off| *off > STRAIGHT_PX)?;
                (frames as f32 * (STRAIGHT_PX / off).sqrt()) as usize
            }
            SlopeVerdict::Film => {
                let (width, height) = self.cache.burst.size();
                let part = finding.moved_px / width.min(height) as f32;
                (frames as f32 * 0.25 / part.max(0.25)) as usize
            }
            _ => return None,
        };
        let left = left.clamp(2, frames);
        let fewer = frames - left;
        let why = match finding.verdict {
            SlopeVerdict::Film => format!(
                "the picture moves by {} px over the frames, more than a third of it",
                number(finding.moved_px, 0)
            ),
            _ => format!(
                "the motion is not straight: it deviates from a uniform one by up to {} px",
                number(finding.deviation_px.unwrap_or(0.0), 1)
            ),
        };
        (fewer > 0).then(|| SlopeAdvice {
            subject: Subject::Frames,
            number: fewer as f64,
            sentence: format!("{why}; {fewer} of the {frames} frames add nothing but blur"),
            changes: vec![self.middle_frames(left)],
        })
    }

    /// The change that uses only the middle `count` frames.
    fn middle_frames(&self, count: usize) -> ParamChange {
        let used = self.cache.detection().frames_used.clone();
        let start = used.start + (used.len() - count.min(used.len())) / 2;
        ParamChange::new(doc::FRAMES, FrameRange { start, end: start + count.min(used.len()) })
    }

    pub(super) fn coverage(&self) -> Option<SlopeAdvice> {
        let size = self.cache.burst.size();
        let frames = self.spectrum.frames;
        // The typical slope: half of the evidence moves faster.
        let mut slopes: Vec<(Slope, f32)> = self.evidence().iter().map(|e| (e.slope, e.significance)).collect();
        slopes.sort_by(|a, b| a.0.magnitude().total_cmp(&b.0.magnitude()));
        let half = 0.5 * slopes.iter().map(|s| s.1).sum::<f32>();
        let mut sum = 0.0;
        let (typical, _) = *slopes.iter().find(|(_, significance)| {
            sum += significance;
            sum >= half
        })?;
        let share = coverage_share(typical, frames, size);
        if share >= COVERED || self.spectrum.finding.verdict == SlopeVerdict::Film {
            return None;
        }
        let enough = (2..frames).rev().find(|&count| coverage_share(typical, count, size) >= COVERED).unwrap_or(2);
        let sentence = format!(
            "at the typical slope {} px/frame all {frames} frames show only {:.0} % of the picture; the middle {enough} show {:.0} %",
            slope_text(typical),
            100.0 * share,
            100.0 * coverage_share(typical, enough, size)
        );
        Some(SlopeAdvice {
            subject: Subject::Coverage,
            number: f64::from(share),
            sentence,
            changes: vec![self.middle_frames(enough)],
        })
    }
}
