//! Tests of `detector::search::slope_window`.
#![allow(unused_imports)]

use burstscope_core::detector::*;
use burstscope_core::detector::feature::*;
use burstscope_core::detector::params::*;
use burstscope_core::detector::scale_space::*;
use std::ops::Range;
use burstscope_core::plane::tile::{Region, Tile};

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

