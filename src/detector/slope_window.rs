//! The slopes that the joint search holds at once, for one tile of the octave.
//!
//! Slopes are visited in running order, first axis fastest. A candidate at one slope is decided as soon as its last neighbouring slope has been made; then
//! the oldest DoG tile is overwritten. So a line of slopes needs three tiles, a plane two rows of the grid and three.

use super::octave::DogTile;
use super::params::SlopeNeighbours;
use super::refine::{peak_offset, peak_offset_2d};
use super::search::{Candidate, beats_all_27};
use super::slope_grid::{Slope, SlopeGrid};

/// DoG tiles and undecided candidates of the slopes in reach.
#[derive(Debug)]
pub(super) struct SlopeWindow {
    grid: SlopeGrid,
    neighbours: SlopeNeighbours,
    tiles: Vec<DogTile>,
    candidates: Vec<Vec<Candidate>>,
}

/// How many tiles the window holds.
pub(super) fn capacity(grid: &SlopeGrid, neighbours: SlopeNeighbours) -> usize {
    match neighbours {
        SlopeNeighbours::All => grid.len(),
        SlopeNeighbours::Adjacent => (2 * reach(grid) + 1).min(grid.len()),
    }
}

/// Running distance from a slope to its farthest neighbour.
fn reach(grid: &SlopeGrid) -> usize {
    if grid.v.count > 1 { grid.u.count + 1 } else { 1 }
}

impl SlopeWindow {
    pub(super) fn new(grid: SlopeGrid, neighbours: SlopeNeighbours) -> Self {
        let capacity = capacity(&grid, neighbours);
        Self {
            grid,
            neighbours,
            tiles: (0..capacity).map(|_| DogTile::default()).collect(),
            candidates: vec![Vec::new(); capacity],
        }
    }

    /// The tile and the (emptied) candidates to be filled for slope `index`.
    pub(super) fn slot_mut(&mut self, index: usize) -> (&mut DogTile, &mut Vec<Candidate>) {
        let slot = index % self.tiles.len();
        self.candidates[slot].clear();
        (&mut self.tiles[slot], &mut self.candidates[slot])
    }

    pub(super) fn tile(&self, index: usize) -> &DogTile {
        &self.tiles[index % self.tiles.len()]
    }

    pub(super) fn candidates(&self, index: usize) -> &[Candidate] {
        &self.candidates[index % self.candidates.len()]
    }

    /// The slopes that can be decided once slope `made` has been made.
    pub(super) fn decidable(&self, made: usize) -> std::ops::Range<usize> {
        let last = made + 1 == self.grid.len();
        match self.neighbours {
            SlopeNeighbours::All if last => 0..self.grid.len(),
            SlopeNeighbours::All => 0..0,
            SlopeNeighbours::Adjacent => {
                let reach = reach(&self.grid);
                let start = made.saturating_sub(reach);
                let end = if last { self.grid.len() } else { (made + 1).saturating_sub(reach) };
                start.min(end)..end
            }
        }
    }

    /// Whether the candidate at slope `index` beats its 27 neighbours at each slope that it is compared with.
    pub(super) fn is_slope_extremum(&self, index: usize, candidate: &Candidate) -> bool {
        let beats = |other: usize| {
            let or_equals = other > index;
            beats_all_27(candidate.value, self.tile(other), candidate.x, candidate.y, candidate.level_index, or_equals)
        };
        match self.neighbours {
            SlopeNeighbours::All => (0..self.grid.len()).all(|other| other == index || beats(other)),
            SlopeNeighbours::Adjacent => {
                let (i, j) = self.grid.coordinates(index);
                let around = |at: usize, count: usize| at.saturating_sub(1)..(at + 2).min(count);
                around(j, self.grid.v.count).all(|jj| {
                    around(i, self.grid.u.count).all(|ii| (ii, jj) == (i, j) || beats(jj * self.grid.u.count + ii))
                })
            }
        }
    }

    /// The slope of the extremum between the grid's slopes, from D at the sample (x, y, level index) of the neighbouring slopes. An axis
    /// on which `index` is the first or last keeps the grid's slope.
    pub(super) fn refined_slope(&self, index: usize, x: usize, y: usize, level_index: usize) -> Slope {
        let (i, j) = self.grid.coordinates(index);
        let value = |ii: usize, jj: usize| self.tile(jj * self.grid.u.count + ii).at(level_index, x, y);
        let inner = |at: usize, count: usize| at > 0 && at + 1 < count;
        let here = value(i, j);
        let (di, dj) = match (inner(i, self.grid.u.count), inner(j, self.grid.v.count)) {
            (false, false) => (0.0, 0.0),
            (true, false) => (peak_offset(value(i - 1, j), here, value(i + 1, j)), 0.0),
            (false, true) => (0.0, peak_offset(value(i, j - 1), here, value(i, j + 1))),
            (true, true) => {
                peak_offset_2d(std::array::from_fn(|b| std::array::from_fn(|a| value(i + a - 1, j + b - 1))))
            }
        };
        self.grid.at(i as f32 + di, j as f32 + dj)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_slope_is_decided_once_while_its_neighbours_are_held() {
        let grids = [
            SlopeGrid::line(-1.0..=1.0, 1),
            SlopeGrid::line(-1.0..=1.0, 2),
            SlopeGrid::line(-1.0..=1.0, 9),
            SlopeGrid::line_along(90.0, -1.0..=1.0, 5),
            SlopeGrid::plane(-1.0..=1.0, 3, -1.0..=1.0, 2),
            SlopeGrid::plane(-1.0..=1.0, 5, -1.0..=1.0, 7),
            SlopeGrid::plane(0.0..=0.0, 1, -1.0..=1.0, 4),
        ];
        for grid in grids {
            for neighbours in [SlopeNeighbours::Adjacent, SlopeNeighbours::All] {
                let window = SlopeWindow::new(grid, neighbours);
                let mut decided = Vec::new();
                for made in 0..grid.len() {
                    for index in window.decidable(made) {
                        decided.push(index);
                        let (i, j) = grid.coordinates(index);
                        for other in 0..grid.len() {
                            let (a, b) = grid.coordinates(other);
                            let near = a.abs_diff(i) <= 1 && b.abs_diff(j) <= 1;
                            if near || neighbours == SlopeNeighbours::All {
                                assert!(
                                    other <= made && made - other < capacity(&grid, neighbours),
                                    "{grid:?} {index} {other}"
                                );
                            }
                        }
                    }
                }
                assert_eq!(decided, (0..grid.len()).collect::<Vec<_>>(), "{grid:?}");
            }
        }
    }
}
