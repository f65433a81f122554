//! Distinct keypoints: one keypoint for one blob, over all slopes, scales and octaves.
//!
//! Two keypoints with nearly the same descriptor make each other's matches ambiguous. So, strongest first, a keypoint
//! stays unless it lies within [`Rule::radius`] σ (of the stronger one) of a keypoint that stayed, and their scales
//! differ by at most the factor [`Rule::scale_ratio`]. A removed keypoint removes no other.
//!
//! Two blobs that pass each other at one place both stay if the frames show two motions ([`Along::are_two`]). A ghost
//! (a blob smeared in the stack of a wrong slope) responds only in frames in which the true blob crosses its path. So
//! only frames count in which the two paths are well apart: there a separate structure keeps its full response, and
//! between the paths there is none. (An edge that slides along itself responds there too.)

use super::feature::Keypoint;
use crate::burst::Offset;
use crate::detector::along::Along;
use crate::detector::params::Slope;
use crate::detector::scale_space::ScaleSpace;
use crate::monitor::{Cancelled, Monitor};
use rayon::prelude::*;

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rule {
    /// Largest distance in σ of the stronger one; above 0.
    pub radius: f32,
    /// Largest ratio of their scales; above 1.
    pub scale_ratio: f32,
}

/// A keypoint, input pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Blob {
    pub u: f32,
    pub v: f32,
    /// Above 0.
    pub sigma: f32,
    /// The larger, the stronger.
    pub rank: f32,
}

impl Blob {
    /// Ranked by snr·|D|^¼: snr alone serves matching best, |D|·√snr finds most discs of charts, and this lies between
    /// (docs/MEASUREMENTS.md). The noise is scaled as 1/σ to the refined scale: with the level's own, a smear one level
    /// coarser would win over the sharp blob. Without noise the rank is |D|.
    pub fn of(keypoint: &Keypoint, space: &ScaleSpace) -> Self {
        let (u, v, sigma) = keypoint.in_image();
        let magnitude = keypoint.value.abs();
        let rank = if keypoint.snr.is_finite() {
            let level_sigma = space.sigma_octave(f64::from(keypoint.level)) as f32;
            keypoint.snr * (keypoint.sigma_octave / level_sigma) * magnitude.sqrt().sqrt()
        } else {
            magnitude
        };
        Self { u, v, sigma, rank }
    }

    pub fn covers(&self, weaker: &Self, rule: Rule) -> bool {
        let ratio = self.sigma.max(weaker.sigma) / self.sigma.min(weaker.sigma);
        ratio <= rule.scale_ratio && (self.u - weaker.u).hypot(self.v - weaker.v) <= rule.radius * self.sigma
    }
}

/// Distance of the paths, in σ of the stronger keypoint, from which a frame counts: its response has passed through 0.
const APART_SIGMAS: f32 = 2.5;
/// Minimum share of all frames that must count; two frames must in any case.
const FRAMES_SHARE: f32 = 0.2;
/// Minimum fraction of its response that a separate structure keeps in those frames.
const KEPT_RESPONSE: f32 = 0.6;
/// Minimum of the kept response in deviations of noise: a false second keypoint makes matches ambiguous.
const FRAMES_SNR: f32 = 5.0;
/// Maximum response between the two paths, as a fraction of the weaker response.
const BETWEEN_RESPONSE: f32 = 0.5;

impl Along<'_> {
    /// Whether `weaker`, which lies near `stronger`, is a separate structure.
    pub(super) fn are_two(&self, stronger: &Keypoint, weaker: &Keypoint) -> bool {
        let ((su, sv, sigma), (wu, wv, _)) = (stronger.in_image(), weaker.in_image());
        let between = |a: f32, b: f32| 0.5 * (a + b);
        let (du, dv) = (wu - su, wv - sv);
        let (slope_u, slope_v) = (weaker.slope.u - stronger.slope.u, weaker.slope.v - stronger.slope.v);
        let times = self.inputs.times.from_middle();
        let is_apart = |at: Offset<f32>| {
            let (moved_u, moved_v) = at.displacement((slope_u, slope_v));
            (du + moved_u).hypot(dv + moved_v) > APART_SIGMAS * sigma
        };
        // Close to the crossing the stronger blob's response would pass for the weaker one's.
        let apart: Vec<usize> = (0..times.len()).filter(|&index| is_apart(times[index])).collect();
        if apart.len() < 2 || (apart.len() as f32) < FRAMES_SHARE * times.len() as f32 {
            return false;
        }
        // Responses have the weaker one's sign, at its octave and level.
        let response = |place: (f32, f32), slope: Slope| {
            let levels = weaker.level..weaker.level + 1;
            self.response(weaker.octave, levels, place, slope, &apart)[0] * weaker.value.signum()
        };
        let own = response((wu, wv), weaker.slope);
        // Fewer frames have more noise in their mean.
        let noise = weaker.value.abs() / weaker.snr * (times.len() as f32 / apart.len() as f32).sqrt();
        if own < KEPT_RESPONSE * weaker.value.abs() || own < FRAMES_SNR * noise {
            return false;
        }
        // A smear responds between the paths as well; two blobs leave a gap there.
        let slope = Slope::new(between(stronger.slope.u, weaker.slope.u), between(stronger.slope.v, weaker.slope.v));
        response((between(su, wu), between(sv, wv)), slope) < BETWEEN_RESPONSE * weaker.value.abs()
    }
}

/// Number of blobs that are compared in parallel with the blobs before them; results do not depend on it.
const BLOCK: usize = if cfg!(test) { 16 } else { 512 };

#[derive(Debug, Clone, Copy, PartialEq)]
enum Decision {
    Open,
    Stays,
    CoveredBy(u32),
}

/// Decisions on blobs, on demand: each needs those on stronger blobs that may cover the blob, and theirs in turn.
pub struct Deciding<'b> {
    all: Cells<'b>,
    stayed: Cells<'b>,
    decisions: Vec<Decision>,
}

impl<'b> Deciding<'b> {
    pub fn new(blobs: &'b [Blob], rule: Rule) -> Self {
        let mut order: Vec<usize> = (0..blobs.len()).collect();
        order.par_sort_unstable_by(|&a, &b| blobs[b].rank.total_cmp(&blobs[a].rank).then(a.cmp(&b)));
        let stayed = Cells::new(blobs, rule, &order);
        let mut all = stayed.clone();
        order.iter().rev().for_each(|&index| all.insert(index));
        Self { all, stayed, decisions: vec![Decision::Open; blobs.len()] }
    }

    /// Index of the strongest blob that stayed and covers blob `index`; `None` where it stays or is not decided.
    pub fn covered_by(&self, index: usize) -> Option<usize> {
        if let Decision::CoveredBy(by) = self.decisions[index] { Some(by as usize) } else { None }
    }

    pub fn stayed(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.decisions.len()).filter(|&index| self.decisions[index] == Decision::Stays)
    }

    /// Decides on the blobs `asked`, each given once, and on those that their decisions need.
    /// `both_stay(stronger, weaker)` is whether two blobs so near are separate structures all the same.
    ///
    /// Blobs go in blocks, strongest first: compared in parallel with blobs that stayed before, then among themselves.
    pub fn decide(
        &mut self,
        asked: &[usize],
        both_stay: impl Fn(usize, usize) -> bool + Sync,
        monitor: &Monitor,
    ) -> Result<(), Cancelled> {
        for block in self.needed(asked).chunks(BLOCK) {
            let (stayed, before) = (&self.stayed, self.stayed.inserted);
            let by_earlier = |&index: &usize| {
                monitor.check()?;
                Ok(stayed.covering(index, (0, stayed.place[index]), &both_stay))
            };
            let by_earlier: Vec<Option<usize>> =
                block.par_iter().with_min_len(16).map(by_earlier).collect::<Result<_, _>>()?;
            for (&index, by_earlier) in block.iter().zip(by_earlier) {
                // Of its own block only members stronger than the blob found already.
                let below = self.stayed.place[by_earlier.unwrap_or(index)];
                let by = self.stayed.covering(index, (before, below), &both_stay).or(by_earlier);
                self.decisions[index] = by.map_or(Decision::Stays, |by| Decision::CoveredBy(by as u32));
                if by.is_none() {
                    self.stayed.insert(index);
                }
            }
        }
        Ok(())
    }

    /// Open blobs among `asked` and all that their decisions need, strongest first.
    fn needed(&self, asked: &[usize]) -> Vec<usize> {
        let mut is_open: Vec<bool> = self.decisions.iter().map(|decision| *decision == Decision::Open).collect();
        let mut needed: Vec<usize> = asked.iter().copied().filter(|&at| std::mem::take(&mut is_open[at])).collect();
        // Breadth first: each round looks for the stronger neighbours of the blobs of the round before.
        let mut first = 0;
        while first < needed.len() && is_open.contains(&true) {
            let may_cover = |&index: &usize| {
                let mut near = Vec::new();
                self.all.near(index, |other| {
                    // Cells list the strongest first, so the first weaker blob ends the visit.
                    let is_stronger = self.all.place[other as usize] < self.all.place[index];
                    if is_stronger && is_open[other as usize] && self.all.covers(other, index) {
                        near.push(other as usize);
                    }
                    is_stronger
                });
                near
            };
            let near: Vec<Vec<usize>> = needed[first..].par_iter().with_min_len(16).map(may_cover).collect();
            first = needed.len();
            needed.extend(near.into_iter().flatten().filter(|&index| std::mem::take(&mut is_open[index])));
        }
        needed.par_sort_unstable_by_key(|&index| self.all.place[index]);
        needed
    }
}

const NONE: u32 = u32::MAX;

/// Smallest ratio between the ends of a grid's range of scales.
const MIN_CLASS_RATIO: f32 = 1.2;

/// Blobs of one range of scales, in square cells at least as wide as the largest covering distance.
#[derive(Clone)]
struct Grid {
    /// Of a cell, input pixels.
    side: f32,
    columns: usize,
    rows: usize,
    /// The last blob inserted into each cell; empty before the first insertion.
    last: Vec<u32>,
}

#[derive(Clone)]
struct Cells<'b> {
    blobs: &'b [Blob],
    rule: Rule,
    /// Position of the first cell, input pixels.
    start: (f32, f32),
    sigma_min: f32,
    /// Grids by scale: grid k holds scales from r^k to r^(k+1) times the smallest, r being [`Cells::class_ratio`].
    grids: Vec<Grid>,
    /// For each blob, the blob inserted before into the same cell.
    before: Vec<u32>,
    /// For each inserted blob, the number of blobs inserted before.
    turn: Vec<u32>,
    inserted: u32,
    /// Position of each blob in the order of strength: 0 for the strongest.
    place: Vec<u32>,
}

impl<'b> Cells<'b> {
    fn new(blobs: &'b [Blob], rule: Rule, order: &[usize]) -> Self {
        let range = |of: fn(&Blob) -> f32| {
            blobs.iter().map(of).fold((f32::INFINITY, f32::NEG_INFINITY), |(min, max), x| (min.min(x), max.max(x)))
        };
        let ((u0, u1), (v0, v1), (s0, s1)) = (range(|b| b.u), range(|b| b.v), range(|b| b.sigma));
        let mut place = vec![0; blobs.len()];
        order.iter().enumerate().for_each(|(at, &index)| place[index] = at as u32);
        let (before, turn) = (vec![NONE; blobs.len()], vec![0; blobs.len()]);
        let (start, grids) = ((u0, v0), Vec::new());
        let mut cells = Self { blobs, rule, start, sigma_min: s0, grids, before, turn, inserted: 0, place };
        if blobs.is_empty() {
            return cells;
        }
        let mut population = vec![0usize; cells.scale_class(s1) + 1];
        blobs.iter().for_each(|blob| population[cells.scale_class(blob.sigma)] += 1);
        let (width, height) = (u1 - u0, v1 - v0);
        // One grid as wide as the largest blob would put all small blobs into a few cells.
        for (k, blobs_of_class) in population.into_iter().enumerate() {
            let reach = rule.radius * s0 * cells.class_ratio().powi(k as i32 + 1);
            // Cells may be wider than the reach: about one a blob, however small the radius.
            let cells_of_class = blobs_of_class.max(1) as f32;
            let one_a_blob = (width * height / cells_of_class).sqrt().max(width.max(height) / cells_of_class);
            let side = reach.max(one_a_blob);
            let count = |range: f32| (range / side) as usize + 1;
            cells.grids.push(Grid { side, columns: count(width), rows: count(height), last: Vec::new() });
        }
        cells
    }

    /// Ratio of the largest to the smallest scale of a class; few classes, so that few grids are searched.
    fn class_ratio(&self) -> f32 {
        self.rule.scale_ratio.max(MIN_CLASS_RATIO)
    }

    fn scale_class(&self, sigma: f32) -> usize {
        ((sigma / self.sigma_min).ln() / self.class_ratio().ln()).max(0.0) as usize
    }

    fn cell(&self, grid: &Grid, blob: &Blob) -> (usize, usize) {
        let at = |x: f32, start: f32, count: usize| (((x - start) / grid.side) as usize).min(count - 1);
        (at(blob.u, self.start.0, grid.columns), at(blob.v, self.start.1, grid.rows))
    }

    fn insert(&mut self, index: usize) {
        let class = self.scale_class(self.blobs[index].sigma);
        let (column, row) = self.cell(&self.grids[class], &self.blobs[index]);
        let grid = &mut self.grids[class];
        if grid.last.is_empty() {
            grid.last = vec![NONE; grid.columns * grid.rows];
        }
        let last = &mut grid.last[row * grid.columns + column];
        self.before[index] = std::mem::replace(last, index as u32);
        self.turn[index] = self.inserted;
        self.inserted += 1;
    }

    fn covers(&self, stronger: u32, weaker: usize) -> bool {
        self.blobs[stronger as usize].covers(&self.blobs[weaker], self.rule)
    }

    /// Calls `visit` with the blobs of each cell near blob `index`, last inserted first, until it returns false.
    fn near(&self, index: usize, mut visit: impl FnMut(u32) -> bool) {
        let blob = &self.blobs[index];
        let class = self.scale_class(blob.sigma);
        // Scales within the ratio are at most one class away; one more on each side allows for rounding.
        let classes = class.saturating_sub(2)..(class + 3).min(self.grids.len());
        for grid in self.grids[classes].iter().filter(|grid| !grid.last.is_empty()) {
            let (column, row) = self.cell(grid, blob);
            for y in row.saturating_sub(1)..(row + 2).min(grid.rows) {
                for x in column.saturating_sub(1)..(column + 2).min(grid.columns) {
                    let mut other = grid.last[y * grid.columns + x];
                    while other != NONE && visit(other) {
                        other = self.before[other as usize];
                    }
                }
            }
        }
    }

    /// Strongest blob that covers blob `index`, among those inserted at turn `from` or later and placed below `below`.
    fn covering(&self, index: usize, (from, below): (u32, u32), stay: &impl Fn(usize, usize) -> bool) -> Option<usize> {
        let mut near: Vec<u32> = Vec::new();
        self.near(index, |other| {
            let is_new = self.turn[other as usize] >= from;
            if is_new && self.place[other as usize] < below && self.covers(other, index) {
                near.push(other);
            }
            is_new
        });
        // `stay` is slow, so the strongest are tested first.
        near.sort_unstable_by_key(|&other| self.place[other as usize]);
        near.into_iter().map(|other| other as usize).find(|&other| !stay(other, index))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const RULE: Rule = Rule { radius: 1.25, scale_ratio: 1.5 };

    fn blob(u: f32, v: f32, sigma: f32, rank: f32) -> Blob {
        Blob { u, v, sigma, rank }
    }

    fn covered_by(blobs: &[Blob], rule: Rule, both_stay: impl Fn(usize, usize) -> bool + Sync) -> Vec<Option<usize>> {
        let mut deciding = Deciding::new(blobs, rule);
        let all: Vec<usize> = (0..blobs.len()).collect();
        deciding.decide(&all, both_stay, &Monitor::default()).expect("nobody cancels it");
        all.iter().map(|&index| deciding.covered_by(index)).collect()
    }

    /// The definition: from the strongest to the weakest, each is compared with all that stayed.
    fn by_definition(blobs: &[Blob], rule: Rule, both_stay: impl Fn(usize, usize) -> bool) -> Vec<Option<usize>> {
        let mut order: Vec<usize> = (0..blobs.len()).collect();
        order.sort_by(|&a, &b| blobs[b].rank.total_cmp(&blobs[a].rank).then(a.cmp(&b)));
        let mut out: Vec<Option<usize>> = vec![None; blobs.len()];
        for (place, &index) in order.iter().enumerate() {
            let covers =
                |&&o: &&usize| out[o].is_none() && blobs[o].covers(&blobs[index], rule) && !both_stay(o, index);
            out[index] = order[..place].iter().find(covers).copied();
        }
        out
    }

    #[test]
    fn a_weaker_keypoint_goes_within_the_radius_and_the_ratio_and_stays_beyond() {
        let strong = blob(10.0, 20.0, 4.0, 9.0);
        for (other, goes) in [
            (blob(14.9, 20.0, 4.0, 8.0), true),
            (blob(15.1, 20.0, 4.0, 8.0), false),
            (blob(10.0, 24.9, 4.0, 8.0), true),
            (blob(10.0, 20.0, 5.9, 8.0), true),
            (blob(10.0, 20.0, 6.1, 8.0), false),
            (blob(10.0, 20.0, 2.7, 8.0), true),
            (blob(10.0, 20.0, 2.6, 8.0), false),
        ] {
            assert_eq!(covered_by(&[strong, other], RULE, |_, _| false), [None, goes.then_some(0)], "{other:?}");
        }
    }

    proptest! {
        #[test]
        fn cells_are_the_definition(
            raw in prop::collection::vec((0.0f32..60.0, 0.0f32..40.0, 0.0f32..5.0, 0u8..9), 0..120),
            radius in prop_oneof![0.01f32..0.1, 0.3f32..3.0], ratio in prop_oneof![1.0001f32..1.01, 1.05f32..3.0],
        ) {
            let rule = Rule { radius, scale_ratio: ratio };
            let blobs: Vec<Blob> = raw.iter().map(|&(u, v, s, rank)| blob(u, v, 0.9 * s.exp2(), f32::from(rank))).collect();
            for different in [1, 3] {
                let both_stay = |a: usize, b: usize| a % different != b % different;
                prop_assert_eq!(covered_by(&blobs, rule, both_stay), by_definition(&blobs, rule, both_stay));
            }
        }

        #[test]
        fn a_part_is_decided_as_the_whole_is(
            raw in prop::collection::vec((0.0f32..30.0, 0.0f32..20.0, 0.0f32..2.0, 0u8..99), 1..150),
            weights in prop::collection::vec(0u32..1000, 150),
            cuts in prop::collection::vec(1usize..40, 0..6),
        ) {
            let blobs: Vec<Blob> = raw.iter().map(|&(u, v, s, rank)| blob(u, v, 0.9 * s.exp2(), f32::from(rank))).collect();
            // Asked for in another order than that of strength, and not all of them.
            let mut order: Vec<usize> = (0..blobs.len()).collect();
            order.sort_by_key(|&index| weights[index]);
            let both_stay = |a: usize, b: usize| (a ^ b).is_multiple_of(5);
            let whole = covered_by(&blobs, RULE, both_stay);
            let mut deciding = Deciding::new(&blobs, RULE);
            for cut in cuts {
                let part: Vec<usize> = order.drain(..cut.min(order.len())).collect();
                deciding.decide(&part, both_stay, &Monitor::default()).expect("nobody cancels it");
                let stayed: Vec<usize> = deciding.stayed().collect();
                prop_assert!(stayed.iter().all(|&index| whole[index].is_none()));
                for index in part {
                    prop_assert_eq!(deciding.covered_by(index), whole[index]);
                    prop_assert_eq!(stayed.contains(&index), whole[index].is_none());
                }
            }
        }
    }

    #[test]
    fn a_part_needs_few_of_the_others() {
        let blobs: Vec<Blob> =
            (0..40_000).map(|i| blob((i % 200) as f32, (i / 200) as f32, 1.0, (i % 7) as f32)).collect();
        let deciding = Deciding::new(&blobs, RULE);
        let needed = deciding.needed(&[20_100]).len();
        assert!((1..400).contains(&needed), "{needed}");
        assert_eq!(deciding.needed(&(0..40_000).collect::<Vec<usize>>()).len(), 40_000);
    }

    #[test]
    fn cells_are_no_more_than_a_few_for_each_blob_whatever_the_rule() {
        let blobs: Vec<Blob> = (0..900)
            .map(|i| blob((i % 30) as f32 * 100.0, (i / 30) as f32 * 70.0, 1.0 + i as f32 / 40.0, 1.0))
            .collect();
        let order: Vec<usize> = (0..blobs.len()).collect();
        for radius in [1e-6, 0.01, 1.0, 1e6] {
            for scale_ratio in [1.0 + 1e-6, 1.01, 1.5, 100.0] {
                let cells = Cells::new(&blobs, Rule { radius, scale_ratio }, &order);
                let count: usize = cells.grids.iter().map(|grid| grid.columns * grid.rows).sum();
                assert!(count < 5 * blobs.len(), "{count} cells at {radius}, {scale_ratio}");
            }
        }
    }
}
