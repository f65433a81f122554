//! The lowest and the highest level of D, computed only where they are read.
//!
//! These two levels have no extrema of their own. They are read around those extrema of the levels next to them that
//! have passed all other comparisons, which are few, and the highest one takes a quarter of all filtering. So D of the
//! other levels is computed first, and these two in cells around such samples. Values are bitwise those of the whole
//! tile.

use crate::detector::feature::{Tally, Test};
use crate::detector::refine::fit;
use crate::detector::scale_space::{DogTile, OctaveFilters, Pixels, ScaleSpace, differences};
use crate::detector::search::SlopeTile;
use crate::detector::search::extrema::{Candidate, beats_level, level_space_extrema};
use crate::detector::search::setup::HELD;
use crate::kernel::gaussian_bank::{FilterBank, FilterScratch};
use crate::kernel::machine::{BLOCK_COLUMNS, CELL_ROWS};
use crate::plane::tile::{Region, Tile};
use std::ops::Range;

/// Cells between two that are wanted in a block of columns which are computed with them: that takes less than the rows
/// that the filters need around each.
const BRIDGED: usize = 2;
/// Offset from a sample, pixels, up to which its refinement certainly stays there.
const STAYS: f64 = 0.59;
/// Time for a cell in units of that for its samples in a whole tile: the filters need rows around it.
const CELL_TIMES: f32 = 6.0;

/// Filters of parts of an octave's levels.
#[derive(Debug)]
pub(crate) struct PartBanks {
    inner: FilterBank,
    lowest: FilterBank,
    highest: FilterBank,
}

impl PartBanks {
    /// Filters for the first octave of `space`, or for later ones.
    pub(crate) fn new(space: &ScaleSpace, first: bool) -> Self {
        let [inner, lowest, highest] = parts(space).map(|levels| space.bank(first, levels));
        Self { inner, lowest, highest }
    }
}

/// Gaussian level indices of which the inner, the lowest and the highest levels of D are made.
fn parts(space: &ScaleSpace) -> [Range<usize>; 3] {
    [1..space.levels + 2, 0..2, space.levels + 1..space.levels + 3]
}

/// Filters of an octave for [`SlopeTile::search_inner_first`].
#[derive(Debug)]
pub(crate) struct PartFilters {
    inner: OctaveFilters,
    lowest: OctaveFilters,
    highest: OctaveFilters,
}

impl PartFilters {
    /// Filters for an octave of `size` of `space`.
    pub(crate) fn new(space: &ScaleSpace, banks: &PartBanks, size: (usize, usize)) -> Self {
        let [inner, lowest, highest] = parts(space);
        let filters = |bank: &FilterBank, levels: Range<usize>| OctaveFilters::new(space, bank, &levels, size);
        Self {
            inner: filters(&banks.inner, inner),
            lowest: filters(&banks.lowest, lowest),
            highest: filters(&banks.highest, highest),
        }
    }
}

/// State of a cell.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
enum Cell {
    /// Not computed.
    #[default]
    Open,
    Wanted,
    Made,
}

/// Cells of one level of D in a tile, block of columns by block of columns.
#[derive(Debug, Default)]
struct Cells {
    held: Region,
    /// Number of cells in a block of columns.
    rows: usize,
    states: Vec<Cell>,
}

impl Cells {
    fn reset(&mut self, held: &Region) {
        self.held = held.clone();
        self.rows = held.rows.len().div_ceil(CELL_ROWS);
        self.states.clear();
        self.states.resize(held.columns.len().div_ceil(BLOCK_COLUMNS) * self.rows, Cell::Open);
    }

    /// Wants all cells that hold samples at most `reach` pixels from a candidate's.
    fn want_around(&mut self, candidate: &Candidate, reach: usize) {
        let part = |at: usize, held: &Range<usize>, side: usize| {
            let (first, last) = (at.saturating_sub(reach).max(held.start), (at + reach).min(held.end - 1));
            (first - held.start) / side..(last - held.start) / side + 1
        };
        for block in part(candidate.x, &self.held.columns, BLOCK_COLUMNS) {
            for row in part(candidate.y, &self.held.rows, CELL_ROWS) {
                let state = &mut self.states[block * self.rows + row];
                if *state == Cell::Open {
                    *state = Cell::Wanted;
                }
            }
        }
    }

    /// Samples of cells `rows` of block `block`.
    fn region(&self, block: usize, rows: Range<usize>) -> Region {
        let part =
            |range: &Range<usize>, first: usize, end: usize| range.start + first..(range.start + end).min(range.end);
        Region {
            columns: part(&self.held.columns, block * BLOCK_COLUMNS, (block + 1) * BLOCK_COLUMNS),
            rows: part(&self.held.rows, rows.start * CELL_ROWS, rows.end * CELL_ROWS),
        }
    }

    /// Marks the wanted cells, and those few between them, as made, and returns their samples in as few regions as
    /// blocks of columns allow.
    fn take_wanted(&mut self) -> Vec<Region> {
        let mut regions = Vec::new();
        let rows = self.rows.max(1);
        for block in 0..self.states.len() / rows {
            let states = &mut self.states[block * rows..(block + 1) * rows];
            let wanted: Vec<usize> = (0..rows).filter(|&row| states[row] == Cell::Wanted).collect();
            for run in wanted.chunk_by(|a, b| b - a <= BRIDGED + 1) {
                let run = run[0]..run[run.len() - 1] + 1;
                self.states[block * rows..][run.clone()].fill(Cell::Made);
                regions.push(self.region(block, run));
            }
        }
        regions
    }

    /// Computes the wanted cells of `level`. `part` is a buffer.
    fn make(
        &mut self,
        filters: &OctaveFilters,
        pixels: Pixels<'_>,
        (scratch, part): (&mut FilterScratch, &mut Tile),
        level: &mut Tile,
    ) {
        for region in self.take_wanted() {
            differences(filters, pixels, &region, scratch, (std::slice::from_mut(part), None), &mut |_, _| ());
            let left = region.columns.start - self.held.columns.start;
            for v in region.rows {
                level.row_mut(v)[left..left + region.columns.len()].copy_from_slice(part.row(v));
            }
        }
    }

    /// Part of the cells that are computed.
    fn part_made(&self) -> f32 {
        let made = self.states.iter().filter(|state| **state == Cell::Made).count();
        made as f32 / self.states.len().max(1) as f32
    }
}

/// Buffers of [`SlopeTile::search_inner_first`], reused from tile to tile.
#[derive(Debug, Default)]
pub(crate) struct PartScratch {
    part: Tile,
    lowest: Cells,
    highest: Cells,
    columns: Vec<u32>,
    found: Vec<Candidate>,
}

impl SlopeTile<'_> {
    /// As [`SlopeTile::search_everywhere`] of a searched tile, but D of the lowest and the highest level is computed
    /// only where it is compared or where refinement may read it. Returns whether that takes less.
    pub(super) fn search_inner_first(
        &self,
        filters: &PartFilters,
        (filter, scratch): (&mut FilterScratch, &mut PartScratch),
        dog: &mut DogTile,
        (candidates, tally): (&mut Vec<Candidate>, &mut Tally),
        next: Option<&mut Tile>,
    ) -> bool {
        let Self { pixels, region, held, .. } = *self;
        let PartScratch { part, lowest, highest, columns, found } = scratch;
        let last = filters.inner.differences();
        dog.levels.resize_with(last + 2, Tile::default);
        for (cells, level) in [(&mut *lowest, 0), (&mut *highest, last + 1)] {
            cells.reset(held);
            dog.levels[level].reset(held, held.columns.len().next_multiple_of(BLOCK_COLUMNS));
        }
        found.clear();
        let mut search = |inner: &[Tile], part: &Region| {
            for (at, level) in inner.iter().enumerate() {
                let first = found.len();
                level_space_extrema((level, at + 1), part, self.size, self.thresholds, tally, columns, found);
                let neighbours = [at.checked_sub(1), Some(at + 1)].map(|at| at.and_then(|at| inner.get(at)));
                let lost =
                    found.extract_if(first.., |one| !neighbours.iter().flatten().all(|level| beats_level(one, level)));
                tally.reject(Test::ScaleExtremum, lost.count() as u64);
            }
        };
        let mut rows = region.rows.start..region.rows.start;
        let mut batch_done = |inner: &[Tile], finished: Range<usize>| {
            rows = self.searchable(rows.end, &finished);
            search(inner, &Region { columns: region.columns.clone(), rows: rows.clone() });
        };
        let inner = &mut dog.levels[1..=last];
        differences(&filters.inner, pixels, held, filter, (inner, next), &mut batch_done);

        let mut make = |cells: [&mut Cells; 2], dog: &mut DogTile| {
            let [lowest, highest] = cells;
            lowest.make(&filters.lowest, pixels, (&mut *filter, &mut *part), &mut dog.levels[0]);
            highest.make(&filters.highest, pixels, (&mut *filter, &mut *part), &mut dog.levels[last + 1]);
        };
        let want = |one: &Candidate, reach: usize, [lowest, highest]: [&mut Cells; 2]| {
            if one.level_index == 1 {
                lowest.want_around(one, reach);
            }
            if one.level_index == last {
                highest.want_around(one, reach);
            }
        };
        found.iter().for_each(|one| want(one, 1, [lowest, highest]));
        make([lowest, highest], dog);
        let before = found.len();
        found.retain(|one| {
            let outer = [(one.level_index == 1).then_some(0), (one.level_index == last).then_some(last + 1)];
            outer.into_iter().flatten().all(|level| beats_level(one, &dog.levels[level]))
        });
        tally.reject(Test::ScaleExtremum, (before - found.len()) as u64);
        found.iter().filter(|one| may_move(one, dog)).for_each(|one| want(one, HELD, [lowest, highest]));
        make([lowest, highest], dog);
        candidates.append(found);
        // The highest level takes about four times as much as the lowest.
        CELL_TIMES * (highest.part_made() + 0.25 * lowest.part_made()) < 1.25
    }
}

/// Whether the refinement of a candidate may leave its sample.
fn may_move(candidate: &Candidate, dog: &DogTile) -> bool {
    let &Candidate { x, y, level_index, .. } = candidate;
    let mut levels: [Tile; 3] = Default::default();
    for (out, level) in levels.iter_mut().zip(&dog.levels[level_index - 1..]) {
        out.reset(&Region { columns: 0..3, rows: 0..3 }, 3);
        let left = x - 1 - level.region().columns.start;
        (0..3).for_each(|row| out.row_mut(row).copy_from_slice(&level.row(y - 1 + row)[left..left + 3]));
    }
    // In an octave of 3×3 samples it has nowhere to go.
    let fit = fit(&DogTile { levels: levels.into() }, (1, 1), 1, (3, 3));
    fit.is_some_and(|fit| fit.offset[..2].iter().any(|offset| offset.abs() > STAYS))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::detector::search::extrema::Thresholds;
    use crate::plane::Plane;
    use proptest::prelude::*;

    const SIZE: (usize, usize) = (236, 197);

    /// Noise and blobs, of the contrasts `parts`.
    fn texture(seed: u64, parts: [f32; 2]) -> Plane {
        let random = |u: usize, v: usize| {
            let mixed = (u as u64 * 0x9e37_79b9 ^ v as u64 * 0x85eb_ca6b ^ seed).wrapping_mul(0xd6e8_feb8_6659_fd93);
            ((mixed ^ mixed >> 32).wrapping_mul(0xd6e8_feb8_6659_fd93) >> 40) as f32 / (1 << 24) as f32
        };
        Plane::from_fn(SIZE.0, SIZE.1, |u, v| {
            let (du, dv) = ((u % 41) as f32 - 20.0, (v % 43) as f32 - 21.0);
            let blob = (-(du * du + dv * dv) / (2.0 + (u / 41 * 3) as f32).powi(2)).exp();
            parts[0] * random(u, v) + parts[1] * blob
        })
    }

    /// Result of a search: candidates by level and place, their counts, D, and the level for the next octave.
    type Searched = (Vec<Candidate>, Tally, DogTile, Tile);

    fn both(space: &ScaleSpace, first: bool, plane: &Plane, region: &Region, thresholds: &Thresholds) -> [Searched; 2] {
        let all = space.all_levels();
        let filters = OctaveFilters::new(space, &space.bank(first, all.clone()), &all, SIZE);
        let parts = PartFilters::new(space, &PartBanks::new(space, first), SIZE);
        let held = region.widened(HELD, SIZE);
        let tile = SlopeTile { pixels: Pixels::Level(plane), region, held: &held, size: SIZE, thresholds };
        let mut filter = FilterScratch::default();
        [false, true].map(|inner_first| {
            let (mut dog, mut candidates, mut tally) = (DogTile::default(), Vec::new(), Tally::default());
            let mut next = Tile::default();
            if inner_first {
                let (buffers, found) = ((&mut filter, &mut PartScratch::default()), (&mut candidates, &mut tally));
                tile.search_inner_first(&parts, buffers, &mut dog, found, Some(&mut next));
            } else {
                let searched = Some((&mut candidates, &mut tally));
                tile.search_everywhere(&filters, &mut filter, &mut dog, searched, Some(&mut next));
            }
            candidates.sort_by_key(|one| (one.level_index, one.y, one.x));
            (candidates, tally, dog, next)
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(16))]
        #[test]
        fn levels_in_parts_give_the_search_of_all(
            seed in any::<u64>(), levels in 1usize..5, first in any::<bool>(), noise in 0.0f32..1.0, limit in 0.0f32..0.2,
        ) {
            let space = ScaleSpace::new(levels, 0, 4.0);
            let plane = texture(seed, [noise, 0.5]);
            let gate = (0..levels + 2).map(|index| 0.2 * noise / (1.0 + index as f32)).collect();
            let thresholds = Thresholds { peak: limit, gate };
            for region in [Region { columns: 0..148, rows: 0..SIZE.1 }, Region { columns: 60..SIZE.0, rows: 40..190 }] {
                let [all, parts] = both(&space, first, &plane, &region, &thresholds);
                prop_assert_eq!(&all.0, &parts.0);
                prop_assert_eq!(all.1, parts.1);
                for v in region.rows.clone() {
                    prop_assert_eq!(all.3.row(v), parts.3.row(v));
                }
                for one in &all.0 {
                    // All samples that a refinement reads on its way.
                    let refined = |dog: &DogTile| fit(dog, (one.x, one.y), one.level_index, SIZE);
                    prop_assert_eq!(refined(&all.2), refined(&parts.2));
                }
            }
        }
    }

    #[test]
    fn cells_are_made_once_and_those_between_them_too() {
        let held = Region { columns: 10..100, rows: 4..140 };
        let mut cells = Cells::default();
        cells.reset(&held);
        let at = |x, y| Candidate { x, y, level_index: 1, value: 1.0 };
        cells.want_around(&at(12, 20), 1);
        cells.want_around(&at(12, 44), 1);
        cells.want_around(&at(98, 139), 6);
        let regions = cells.take_wanted();
        let expected = [(10..42, 12..52), (74..100, 132..140)];
        let expected: Vec<Region> = expected.map(|(columns, rows)| Region { columns, rows }).into();
        assert_eq!(regions, expected);
        cells.want_around(&at(12, 30), 1);
        assert!(cells.take_wanted().is_empty());
    }
}
