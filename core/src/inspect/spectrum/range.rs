//! Advice on the range of slopes: motion beyond it, and aliases that it need not include.

use super::advice::{SlopeAdvice, Subject, Telling};
use super::{Alias, Spectrum};
use crate::detector::params::doc;
use crate::detector::{ParamChange, SlopeAxis};
use crate::inspect::words::{counted, number, slope_text};

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
