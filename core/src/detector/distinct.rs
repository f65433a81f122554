//! Distinct keypoints: one keypoint for one blob, over all slopes, scales and octaves.
//!
//! The search at each slope for itself finds a blob at every slope whose stack still shows it, and often at
//! neighbouring levels and octaves too. Two keypoints with nearly the same descriptor make each other's matches
//! ambiguous, so that the ratio test rejects both. So, from the strongest to the weakest: a keypoint stays unless it
//! lies within [`Rule::radius`] σ of one that stayed, σ being the stronger one's, and their scales differ by at most
//! the factor [`Rule::scale_ratio`]. A removed keypoint removes no other. So the strongest keypoint of a blob
//! determines its slope. Two blobs that pass each other at one place both stay if the frames show two motions; the
//! caller decides that.

use super::feature::Keypoint;
use crate::detector::scale_space::ScaleSpace;
use crate::monitor::{Cancelled, Monitor};
use rayon::prelude::*;

/// Rule by which a weaker keypoint is taken for the same blob as a stronger one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rule {
    /// Largest distance in σ of the stronger one; above 0.
    pub radius: f32,
    /// Largest ratio of their scales; above 1.
    pub scale_ratio: f32,
}

/// Place, scale and rank of a keypoint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Blob {
    /// Column, input pixels.
    pub u: f32,
    /// Row, input pixels.
    pub v: f32,
    /// Scale, input pixels; above 0.
    pub sigma: f32,
    /// Rank; a stronger keypoint has a larger one.
    pub rank: f32,
}

impl Blob {
    /// Blob of a keypoint of a search over the scales of `space`.
    ///
    /// It is ranked by snr·|D|^¼: snr alone serves matching best, |D|·√snr finds most discs of charts, and this lies
    /// between them at little loss to either (docs/MEASUREMENTS.md). The noise is that at the refined scale, scaled as
    /// 1/σ from the level's: with the level's own, a smear whose best sample is one level coarser would win over the
    /// sharp blob, because noise falls from level to level. Without noise it is ranked by |D|.
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

    /// Whether `weaker` is taken for the same blob as this one.
    pub fn covers(&self, weaker: &Self, rule: Rule) -> bool {
        let ratio = self.sigma.max(weaker.sigma) / self.sigma.min(weaker.sigma);
        ratio <= rule.scale_ratio && (self.u - weaker.u).hypot(self.v - weaker.v) <= rule.radius * self.sigma
    }
}

/// Strongest of the blobs `stay` that would remove `blob`, which is none of them: the result of [`covered_by`] if
/// `blob` came after all blobs that are at least as strong. `both_stay`, called with the stronger one, is as there.
pub fn would_cover(
    blob: &Blob,
    stay: impl Iterator<Item = (usize, Blob)>,
    rule: Rule,
    both_stay: impl Fn(usize) -> bool,
) -> Option<usize> {
    stay.filter(|(index, stronger)| stronger.rank >= blob.rank && stronger.covers(blob, rule) && !both_stay(*index))
        .max_by(|a, b| a.1.rank.total_cmp(&b.1.rank))
        .map(|(index, _)| index)
}

/// Number of blobs that are compared in parallel with the blobs before them.
const BLOCK: usize = 512;

/// For each blob the index of the strongest one that stayed and covers it; `None` for those that stay. Of equally
/// strong blobs the first one goes first. `both_stay(stronger, weaker)` tells whether two that lie so near are separate
/// structures all the same.
///
/// Time grows in proportion to the number of blobs: those that stayed are kept in cells by scale and place. Blobs are
/// taken in blocks. Those that stayed of earlier blocks are stronger than a whole block, so all of the block is
/// compared with them in parallel; only blobs that none of those covers are compared with their own block, one after
/// the other. The result is that of comparing one after the other throughout.
///
/// # Errors
/// [`Cancelled`] once `monitor` was cancelled.
pub fn covered_by(
    blobs: &[Blob],
    rule: Rule,
    both_stay: impl Fn(usize, usize) -> bool + Sync,
    monitor: &Monitor,
) -> Result<Vec<Option<usize>>, Cancelled> {
    let mut order: Vec<usize> = (0..blobs.len()).collect();
    order.sort_by(|&a, &b| blobs[b].rank.total_cmp(&blobs[a].rank).then(a.cmp(&b)));
    let mut stayed = Cells::new(blobs, rule, &order);
    let mut out = vec![None; blobs.len()];
    for (number, block) in order.chunks(BLOCK).enumerate() {
        let by_earlier = |&index: &usize| {
            monitor.check()?;
            Ok(stayed.covering(index, 0, &both_stay))
        };
        let by_earlier: Vec<Option<usize>> =
            block.par_iter().with_min_len(16).map(by_earlier).collect::<Result<_, _>>()?;
        for (&index, by_earlier) in block.iter().zip(by_earlier) {
            out[index] = by_earlier.or_else(|| stayed.covering(index, number * BLOCK, &both_stay));
            if out[index].is_none() {
                stayed.insert(index);
            }
        }
    }
    Ok(out)
}

/// Marker for no blob.
const NONE: u32 = u32::MAX;

/// Smallest ratio between the ends of a grid's range of scales.
const MIN_CLASS_RATIO: f32 = 1.2;

/// Blobs of one range of scales that stayed, in square cells at least as wide as the largest distance at which one of
/// them covers another.
struct Grid {
    /// Side of a cell, input pixels.
    side: f32,
    columns: usize,
    rows: usize,
    /// The last blob inserted into each cell; empty before the first insertion.
    last: Vec<u32>,
}

/// The blobs that stayed, by scale and place.
struct Cells<'b> {
    blobs: &'b [Blob],
    rule: Rule,
    /// Position of the first cell, input pixels.
    start: (f32, f32),
    /// Smallest scale, input pixels.
    sigma_min: f32,
    /// Grids by scale: grid k holds scales from r^k to r^(k+1) times the smallest, r being [`Cells::class_ratio`].
    grids: Vec<Grid>,
    /// For each blob, the one inserted before it into its cell.
    before: Vec<u32>,
    /// Position of each blob in the order of strength, in which they are inserted: 0 for the strongest.
    place: Vec<u32>,
}

impl<'b> Cells<'b> {
    /// Empty cells for blobs that will be inserted in `order`.
    fn new(blobs: &'b [Blob], rule: Rule, order: &[usize]) -> Self {
        let range = |of: fn(&Blob) -> f32| {
            blobs.iter().map(of).fold((f32::INFINITY, f32::NEG_INFINITY), |(min, max), x| (min.min(x), max.max(x)))
        };
        let ((u0, u1), (v0, v1), (s0, s1)) = (range(|b| b.u), range(|b| b.v), range(|b| b.sigma));
        let mut place = vec![0; blobs.len()];
        order.iter().enumerate().for_each(|(at, &index)| place[index] = at as u32);
        let before = vec![NONE; blobs.len()];
        let mut cells = Self { blobs, rule, start: (u0, v0), sigma_min: s0, grids: Vec::new(), before, place };
        if blobs.is_empty() {
            return cells;
        }
        let mut population = vec![0usize; cells.scale_class(s1) + 1];
        blobs.iter().for_each(|blob| population[cells.scale_class(blob.sigma)] += 1);
        let (width, height) = (u1 - u0, v1 - v0);
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

    /// Ratio of the largest to the smallest scale of a class: the rule's ratio, or a larger one, so that there are few
    /// classes even where the rule's ratio is close to 1.
    fn class_ratio(&self) -> f32 {
        self.rule.scale_ratio.max(MIN_CLASS_RATIO)
    }

    /// Index of the grid for scale `sigma`.
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
    }

    /// Strongest blob that covers blob `index`, of those that stayed and have at least position `from` in the order.
    fn covering(&self, index: usize, from: usize, both_stay: &impl Fn(usize, usize) -> bool) -> Option<usize> {
        let blob = &self.blobs[index];
        let class = self.scale_class(blob.sigma);
        // Scales within the ratio are at most one class away; one more on each side allows for rounding.
        let classes = class.saturating_sub(2)..(class + 3).min(self.grids.len());
        let mut near: Vec<u32> = Vec::new();
        for grid in self.grids[classes].iter().filter(|grid| !grid.last.is_empty()) {
            let (column, row) = self.cell(grid, blob);
            for y in row.saturating_sub(1)..(row + 2).min(grid.rows) {
                for x in column.saturating_sub(1)..(column + 2).min(grid.columns) {
                    let mut other = grid.last[y * grid.columns + x];
                    // The last one inserted is the weakest.
                    while other != NONE && self.place[other as usize] >= from as u32 {
                        if self.blobs[other as usize].covers(blob, self.rule) {
                            near.push(other);
                        }
                        other = self.before[other as usize];
                    }
                }
            }
        }
        // `both_stay` is slow, so the strongest are tested first.
        near.sort_unstable_by_key(|&other| self.place[other as usize]);
        near.into_iter().map(|other| other as usize).find(|&other| !both_stay(other, index))
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
        super::covered_by(blobs, rule, both_stay, &Monitor::default()).expect("nobody cancels it")
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
            let expected = if goes { Some(0) } else { None };
            assert_eq!(covered_by(&[strong, other], RULE, |_, _| false), [None, expected], "{other:?}");
        }
    }

    #[test]
    fn what_was_removed_removes_nothing() {
        let row = [blob(0.0, 0.0, 2.0, 9.0), blob(2.0, 0.0, 2.0, 8.0), blob(4.0, 0.0, 2.0, 7.0)];
        assert_eq!(covered_by(&row, RULE, |_, _| false), [None, Some(0), None]);
        assert_eq!(covered_by(&[], RULE, |_, _| false), []);
    }

    #[test]
    fn different_things_at_one_place_both_stay_and_each_removes_its_own() {
        let at = |rank| blob(10.0, 20.0, 4.0, rank);
        // Even and odd ones are separate structures.
        let differ = |a: usize, b: usize| a % 2 != b % 2;
        let all = [at(9.0), at(8.0), at(7.0), at(6.0)];
        assert_eq!(covered_by(&all, RULE, differ), [None, None, Some(0), Some(1)]);
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
    }

    #[test]
    fn many_blocks_are_the_definition() {
        let mut state = 1u32;
        let mut random = |range: f32| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / (1 << 24) as f32 * range
        };
        let mut one = |_| blob(random(300.0), random(200.0), 1.0 + random(9.0), random(30.0).round());
        let blobs: Vec<Blob> = (0..5 * BLOCK + 7).map(&mut one).collect();
        let both_stay = |a: usize, b: usize| (a ^ b).is_multiple_of(5);
        let expected = by_definition(&blobs, RULE, both_stay);
        assert!(expected.iter().flatten().count() > BLOCK && expected.iter().filter(|by| by.is_none()).count() > BLOCK);
        assert_eq!(covered_by(&blobs, RULE, both_stay), expected);
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

    #[test]
    fn a_cancel_ends_it() {
        let monitor = Monitor::default();
        monitor.cancel();
        let blobs = [blob(0.0, 0.0, 2.0, 9.0)];
        assert_eq!(super::covered_by(&blobs, RULE, |_, _| false, &monitor), Err(Cancelled));
    }
}
