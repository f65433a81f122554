//! Motions of a field beyond the searched slopes, and a range that holds these motions.

use super::{MotionField, motion_field};
use crate::burst::Burst;
use crate::detector::Feature;
use crate::detector::params::slope_grid::{Slope, SlopeGrid};
use crate::detector::stack::FrameTimes;
use crate::monitor::{Cancelled, Monitor};
use crate::plane::Plane;
use std::ops::Range;

/// Part of the field of motion beyond an end of the range from which a wider one is advised, if
/// [features](FEATURES_BEYOND) confirm it: without them the part is up to 0.34 on bursts whose slopes fit.
pub(crate) const FIELD_BEYOND: f32 = 0.02;
/// Number of features at an end of the range that confirm a field of motion beyond it. The field is less certain there,
/// as frames were not compared farther out; noise and aliases leave one or two such features.
const FEATURES_BEYOND: usize = 3;
/// Part of the motions beyond a range that may lie beyond a wider one: where more do, noise leads on and on.
const LEFT_BEYOND: f32 = 0.5;

pub(crate) struct Beyond {
    /// Range, wider at the `ends`, with the same steps.
    pub grid: SlopeGrid,
    /// Largest part of the picture that moves beyond an end.
    pub share: f32,
    /// Ends beyond which places move, and whether each is one of the second axis.
    pub ends: Vec<(bool, f32)>,
}

impl MotionField {
    /// Motions beyond `grid`, confirmed by `features` if they are given. Places whose evidence still rises at an end of
    /// the sweep, such as a near floor, have no known motion but lie there; empty places lie at both ends alike.
    pub(crate) fn beyond(&self, grid: &SlopeGrid, features: Option<&[Feature]>) -> Option<Beyond> {
        let mut beyond = Beyond { grid: *grid, share: 0.0, ends: Vec::new() };
        for (second, axis) in grid.axes() {
            // Half a step beyond the end still belongs to the slope at the end.
            let margin = 0.5 * axis.step();
            let is_below = |slope: Slope| grid.along(slope, second) < axis.min - margin;
            let is_above = |slope: Slope| grid.along(slope, second) > axis.max + margin;
            let count = |is_known: bool, is_beyond: &dyn Fn(Slope) -> bool| {
                let motions = self.motions.iter().filter(|motion| self.is_known(motion) == is_known);
                motions.filter(|motion| is_beyond(motion.slope)).count()
            };
            // Unknown motions at the other end estimate how many are here by chance.
            let by_chance = [count(false, &is_below), count(false, &is_above)];
            let middle = 0.5 * (axis.min + axis.max);
            // Features on the other half of the axis say nothing about this end.
            let is_borne_out = |end: f32| {
                let is_there = |slope: Slope| (grid.along(slope, second) - middle) * (end - middle) > 0.0;
                features.is_none_or(|features| {
                    let there = features.iter().filter(|feature| is_there(feature.slope));
                    let is_at_end = |f: &&Feature| f.at_slope_limit || is_below(f.slope) || is_above(f.slope);
                    there.filter(is_at_end).count() >= FEATURES_BEYOND
                })
            };
            let mut more = |known: usize, [here, there]: [usize; 2], end: f32| {
                let share = (known + here.saturating_sub(there)) as f32 / self.motions.len() as f32;
                if share <= FIELD_BEYOND || !is_borne_out(end) {
                    return 0;
                }
                beyond.share = beyond.share.max(share);
                beyond.ends.push((second, end));
                axis.count.saturating_sub(1).div_ceil(2)
            };
            let below = more(count(true, &is_below), by_chance, axis.min);
            let above = more(count(true, &is_above), [by_chance[1], by_chance[0]], axis.max);
            *(if second { &mut beyond.grid.v } else { &mut beyond.grid.u }) = axis.with_more(below, above);
        }
        (!beyond.ends.is_empty()).then_some(beyond)
    }

    /// Share (0 … 1) of the picture whose motion is known and lies beyond `grid`, by more than half a step.
    pub(crate) fn known_beyond(&self, grid: &SlopeGrid) -> f32 {
        let is_beyond = |slope: Slope| {
            grid.axes().any(|(second, axis)| {
                let (at, margin) = (grid.along(slope, second), 0.5 * axis.step());
                !(axis.min - margin..=axis.max + margin).contains(&at)
            })
        };
        let beyond = self.motions.iter().filter(|motion| self.is_known(motion) && is_beyond(motion.slope)).count();
        beyond as f32 / self.motions.len() as f32
    }
}

impl Beyond {
    /// Whether a field measured over the wider range has less beyond it: an end hides what lies farther out. Where
    /// motion `beyond` these slopes is asked for, it must be known there.
    pub(crate) fn is_held(
        &self,
        beyond: Option<&SlopeGrid>,
        burst: &Burst,
        used: Range<usize>,
        monitor: &Monitor,
    ) -> Result<bool, Cancelled> {
        let Some(field) = field_over(&self.grid, burst, used, monitor)? else { return Ok(beyond.is_none()) };
        let left = field.beyond(&self.grid, None).map_or(0.0, |left| left.share);
        let is_there = beyond.is_none_or(|grid| field.known_beyond(grid) >= LEFT_BEYOND * self.share);
        Ok(left <= LEFT_BEYOND * self.share && is_there)
    }
}

pub(crate) fn field_over(
    grid: &SlopeGrid,
    burst: &Burst,
    used: Range<usize>,
    monitor: &Monitor,
) -> Result<Option<MotionField>, Cancelled> {
    let frames: Vec<&Plane> = burst.frames[used.clone()].iter().map(|frame| &**frame).collect();
    motion_field(&frames, &FrameTimes::all(burst.positions.part(used)), grid, &monitor.silent())
}
