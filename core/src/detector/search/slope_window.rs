//! Window of the slopes held at once for one tile: one, unless candidates are compared or refined over slopes.
//!
//! Slopes are visited in running order, first axis fastest. A candidate is compared with the slopes before its own as
//! soon as it is found, and with those after its own as they come; meanwhile it keeps the values that it needs of its
//! own tile, which is then free. So a line of slopes needs two tiles, a plane one row of the grid and two.

use crate::detector::feature::{Tally, Test};
use crate::detector::params::{DetectorParams, Localisation, Slope, SlopeExtrema, SlopeGrid, SlopeNeighbours};
use crate::detector::refine::{Fit, peak_offset, peak_offset_2d};
use crate::detector::scale_space::DogTile;
use crate::detector::search::extrema::{Candidate, beats_all_27};
use std::ops::Range;

/// Candidate that no slope has beaten so far.
#[derive(Debug, Clone, Copy)]
pub struct Undecided {
    pub candidate: Candidate,
    /// The refined extremum, or the test that rejects it if no slope does.
    pub refined: Result<Fit, Test>,
    /// D of the refined sample at the slopes around, as far as they have been visited: `around[dj + 1][di + 1]`.
    around: [[f32; 3]; 3],
}

impl Undecided {
    fn look_at(&mut self, tile: &DogTile, (di, dj): (i64, i64)) {
        if let (Ok(Fit { x, y, .. }), -1..=1, -1..=1) = (self.refined, di, dj) {
            self.around[(dj + 1) as usize][(di + 1) as usize] = tile.at(self.candidate.level_index, x, y);
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OtherSlopes {
    Unseen,
    /// D at the neighbouring slopes refines the candidate's slope.
    Seen,
    /// The candidate must beat the 27 samples at each of these slopes, which then refine its slope.
    Beaten(SlopeNeighbours),
}

impl OtherSlopes {
    pub fn of(params: &DetectorParams) -> Self {
        match (params.used_extrema(), params.rules.localisation) {
            (SlopeExtrema::Joint, _) => Self::Beaten(params.rules.slope_neighbours),
            (SlopeExtrema::Each, Localisation::Quadratic) => Self::Seen,
            (SlopeExtrema::Each, Localisation::Continuous) => Self::Unseen,
        }
    }

    /// Distance, in running indices, from a slope to the farthest one held with it; `None` for all of them.
    pub fn reach(self, grid: &SlopeGrid) -> Option<usize> {
        match self {
            Self::Unseen => Some(0),
            Self::Beaten(SlopeNeighbours::All) => None,
            Self::Seen | Self::Beaten(SlopeNeighbours::Adjacent) => Some(grid.neighbour_distance()),
        }
    }
}

#[derive(Debug)]
pub struct SlopeWindow {
    grid: SlopeGrid,
    others: OtherSlopes,
    visited: Range<usize>,
    tiles: Vec<DogTile>,
    /// Candidates of the slope that was computed last.
    candidates: Vec<Candidate>,
    undecided: Vec<Vec<Undecided>>,
}

pub fn capacity(grid: &SlopeGrid, others: OtherSlopes) -> usize {
    others.reach(grid).map_or(grid.len(), |reach| (reach + 1).min(grid.len()))
}

impl SlopeWindow {
    pub fn new(grid: SlopeGrid, others: OtherSlopes) -> Self {
        let capacity = capacity(&grid, others);
        let (visited, tiles) = (0..grid.len(), (0..capacity).map(|_| DogTile::default()).collect());
        let (candidates, undecided) = (Vec::new(), vec![Vec::new(); capacity]);
        Self { grid, others, visited, tiles, candidates, undecided }
    }

    /// Begins another tile. Only slopes whose neighbours are all among `visited` may have candidates.
    pub fn begin(&mut self, visited: &Range<usize>) {
        self.visited = visited.clone();
    }

    /// The tile and the (emptied) list of candidates to fill for slope `index`.
    pub fn slot_mut(&mut self, index: usize) -> (&mut DogTile, &mut Vec<Candidate>) {
        let slot = index % self.tiles.len();
        self.candidates.clear();
        (&mut self.tiles[slot], &mut self.candidates)
    }

    /// Leaves slope `index` out: it has no candidates, and none of another slope is compared with it.
    pub fn leave_out(&mut self, index: usize) {
        let slot = index % self.undecided.len();
        self.undecided[slot].clear();
    }

    fn tile(&self, index: usize) -> &DogTile {
        &self.tiles[index % self.tiles.len()]
    }

    /// Slopes before slope `index` that its candidates are compared with, and their distances in steps.
    fn earlier(&self, index: usize) -> Vec<(usize, (i64, i64))> {
        let (i, j) = self.grid.coordinates(index);
        let reach = self.others.reach(&self.grid);
        let first = reach.map_or(0, |reach| index.saturating_sub(reach));
        (first.max(self.visited.start)..index)
            .map(|other| {
                let (ii, jj) = self.grid.coordinates(other);
                (other, (ii as i64 - i as i64, jj as i64 - j as i64))
            })
            .filter(|(_, (di, dj))| reach.is_none() || (di.abs() <= 1 && dj.abs() <= 1))
            .collect()
    }

    /// Compares the tile of slope `made` with the candidates that wait for it, and its candidates with the slopes
    /// before it. One that passes `gate` and beats them waits with the result of `refine`; `tally` counts the others.
    pub fn compare(
        &mut self,
        made: usize,
        gate: impl Fn(&Candidate) -> bool,
        refine: impl Fn(&DogTile, &Candidate) -> Result<Fit, Test>,
        tally: &mut Tally,
    ) {
        let earlier = self.earlier(made);
        let slots = self.tiles.len();
        let own = &self.tiles[made % slots];
        let joint = matches!(self.others, OtherSlopes::Beaten(_));
        // Of two slopes with equal D the earlier one stays.
        let beats = |candidate: &Candidate, tile: &DogTile, or_equals: bool| {
            !joint || beats_all_27(candidate.value, tile, candidate.x, candidate.y, candidate.level_index, or_equals)
        };
        // Candidates of earlier slopes have waited for this tile, the last value that they lacked.
        for &(other, (di, dj)) in &earlier {
            let waiting = &mut self.undecided[other % slots];
            let before = waiting.len();
            waiting.retain_mut(|undecided| {
                let stays = beats(&undecided.candidate, own, true);
                undecided.look_at(own, (-di, -dj));
                stays
            });
            tally.reject(Test::SlopeExtremum, (before - waiting.len()) as u64);
        }
        let mut waiting = std::mem::take(&mut self.undecided[made % slots]);
        waiting.clear();
        for candidate in &self.candidates {
            if !gate(candidate) {
                tally.reject(Test::NoiseGate, 1);
            } else if !earlier.iter().all(|&(other, _)| beats(candidate, self.tile(other), false)) {
                tally.reject(Test::SlopeExtremum, 1);
            } else {
                // Refined before the later slopes are known: the slot of this tile is reused by then.
                let refined = refine(own, candidate);
                let mut undecided = Undecided { candidate: *candidate, refined, around: [[0.0; 3]; 3] };
                undecided.look_at(own, (0, 0));
                earlier.iter().for_each(|&(other, step)| undecided.look_at(self.tile(other), step));
                waiting.push(undecided);
            }
        }
        self.undecided[made % slots] = waiting;
    }

    /// Slopes whose candidates have been compared with all their neighbours once slope `made` has been compared.
    pub fn decidable(&self, made: usize) -> Range<usize> {
        let Range { start: first, end } = self.visited;
        let last = made + 1 == end;
        match self.others.reach(&self.grid) {
            // Compared with every slope, none is decided before the last one is made.
            None if last => first..end,
            None => 0..0,
            Some(reach) => {
                let start = made.saturating_sub(reach).max(first);
                let end = if last { end } else { (made + 1).saturating_sub(reach) };
                start.min(end)..end
            }
        }
    }

    pub fn undecided(&self, index: usize) -> &[Undecided] {
        &self.undecided[index % self.undecided.len()]
    }

    pub fn refined_slope(&self, index: usize, undecided: &Undecided) -> Slope {
        refined_slope(&self.grid, self.others, index, &undecided.around)
    }
}

/// Slope of the extremum between the grid's slopes: `around[dj + 1][di + 1]` is D of the refined sample at the slopes
/// around `index`, 0 beyond the grid. Axes on which it is first or last, or all if no others are used, keep its slope.
pub fn refined_slope(grid: &SlopeGrid, others: OtherSlopes, index: usize, around: &[[f32; 3]; 3]) -> Slope {
    if others == OtherSlopes::Unseen {
        return grid.slope(index);
    }
    let (i, j) = grid.coordinates(index);
    let inner = |at: usize, count: usize| at > 0 && at + 1 < count;
    let (di, dj) = match (inner(i, grid.u.count), inner(j, grid.v.count)) {
        (false, false) => (0.0, 0.0),
        (true, false) => (peak_offset(around[1][0], around[1][1], around[1][2]), 0.0),
        (false, true) => (0.0, peak_offset(around[0][1], around[1][1], around[2][1])),
        (true, true) => peak_offset_2d(*around),
    };
    grid.beside(index, di, dj)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plane::tile::{Region, Tile};

    fn grids() -> [SlopeGrid; 7] {
        [
            SlopeGrid::line(-1.0..=1.0, 1),
            SlopeGrid::line(-1.0..=1.0, 2),
            SlopeGrid::line(-1.0..=1.0, 9),
            SlopeGrid::line_along(90.0, -1.0..=1.0, 5),
            SlopeGrid::plane(-1.0..=1.0, 3, -1.0..=1.0, 2),
            SlopeGrid::plane(-1.0..=1.0, 5, -1.0..=1.0, 7),
            SlopeGrid::plane(0.0..=0.0, 1, -1.0..=1.0, 4),
        ]
    }

    /// Fills a tile of 3×3 samples with D = `values[slope]` in the middle, and a little less around.
    fn fill(tile: &mut DogTile, value: f32) {
        tile.levels.resize_with(3, Tile::default);
        for (s, level) in tile.levels.iter_mut().enumerate() {
            level.reset(&Region { columns: 0..3, rows: 0..3 }, 16);
            for v in 0..3 {
                for u in 0..3 {
                    let middle = (s, u, v) == (1, 1, 1);
                    level.row_mut(v)[u] = if middle { value } else { value - 0.5 };
                }
            }
        }
    }

    /// Slopes that keep a candidate in the middle, in the order in which they are decided, and D around them.
    fn kept(grid: SlopeGrid, others: OtherSlopes, values: &[f32]) -> (Vec<usize>, Vec<[[f32; 3]; 3]>, Tally) {
        let mut window = SlopeWindow::new(grid, others);
        let (mut kept, mut around, mut tally) = (Vec::new(), Vec::new(), Tally::default());
        for (made, &value) in values.iter().enumerate() {
            let (tile, candidates) = window.slot_mut(made);
            fill(tile, value);
            candidates.push(Candidate { x: 1, y: 1, level_index: 1, value });
            let (offset, value, curvature) = ([0.0; 3], f64::from(value), [-1.0, 0.0, -1.0]);
            let here = Fit { x: 1, y: 1, offset, level_refined: 1.0, level_reach: 1.0, value, curvature };
            window.compare(made, |_| true, |_, _| Ok(here), &mut tally);
            for index in window.decidable(made) {
                for undecided in window.undecided(index) {
                    kept.push(index);
                    around.push(undecided.around);
                }
            }
        }
        (kept, around, tally)
    }

    #[test]
    fn every_slope_is_compared_with_all_its_neighbours_and_decided_once() {
        for grid in grids() {
            // Repeats, so that some neighbours are equal.
            let values: Vec<f32> = (0..grid.len()).map(|k| 1.0 + ((k * 7919 + 13) % 11) as f32).collect();
            for others in [
                OtherSlopes::Beaten(SlopeNeighbours::Adjacent),
                OtherSlopes::Beaten(SlopeNeighbours::All),
                OtherSlopes::Seen,
                OtherSlopes::Unseen,
            ] {
                let (kept, around, tally) = kept(grid, others, &values);
                let near = |a: usize, b: usize| a.abs_diff(b) <= 1;
                let is_kept = |index: &usize| {
                    let (i, j) = grid.coordinates(*index);
                    (0..grid.len()).all(|other| {
                        let (ii, jj) = grid.coordinates(other);
                        let compared = match others {
                            OtherSlopes::Beaten(SlopeNeighbours::All) => true,
                            OtherSlopes::Beaten(SlopeNeighbours::Adjacent) => near(i, ii) && near(j, jj),
                            OtherSlopes::Seen | OtherSlopes::Unseen => false,
                        };
                        let earlier_or_less =
                            values[other] < values[*index] || (values[other] == values[*index] && other >= *index);
                        !compared || earlier_or_less
                    })
                };
                let expected: Vec<usize> = (0..grid.len()).filter(is_kept).collect();
                assert_eq!(kept, expected, "{grid:?} {others:?}");
                let rejected = tally.rejected_by(Test::SlopeExtremum) as usize;
                if others == OtherSlopes::Unseen {
                    assert_eq!(capacity(&grid, others), 1);
                    assert_eq!(refined_slope(&grid, others, grid.len() - 1, &around[0]), grid.slope(grid.len() - 1));
                }
                assert_eq!(rejected + kept.len(), grid.len());
                for (index, around) in kept.iter().zip(&around) {
                    let (i, j) = grid.coordinates(*index);
                    for (dj, row) in (-1i64..).zip(around) {
                        for (di, &value) in (-1i64..).zip(row) {
                            let (ii, jj) = (i as i64 + di, j as i64 + dj);
                            let inside =
                                (0..grid.u.count as i64).contains(&ii) && (0..grid.v.count as i64).contains(&jj);
                            let is_seen = others != OtherSlopes::Unseen || (di, dj) == (0, 0);
                            let expected =
                                if inside && is_seen { values[jj as usize * grid.u.count + ii as usize] } else { 0.0 };
                            assert_eq!(value, expected, "{grid:?} {index} {di} {dj}");
                        }
                    }
                }
            }
        }
    }
}
