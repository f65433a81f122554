//! Tests of `kernel::gaussian_bank`.
#![allow(unused_imports)]

use burstscope_core::plane::*;
use burstscope_core::plane::blur::*;
use passes::{BLOCK, Band, Blocks, Packed, Sink, convolve_row, edge_columns, edge_rows, inner_rows, packed};
use pulp::{Arch, Simd, WithSimd};
use std::ops::Range;
use weights::{Edges, Section};
use burstscope_core::plane::Plane;
use burstscope_core::plane::blur::gaussian_blur;

fn chain() -> Vec<GaussianKernel> {
    [1.5, 1.2, 1.6, 2.0, 2.5].map(GaussianKernel::new).to_vec()
}

fn texture(width: usize, height: usize) -> Plane {
    Plane::from_fn(width, height, |u, v| ((u * 31 + v * 17 + u * v % 7) % 29) as f32 / 29.0)
}

fn filtered(plane: &Plane, bank: &FilterBank, region: &Region, keep: usize) -> (Vec<Tile>, Tile) {
    let mut differences = vec![Tile::default(); bank.kernels.len() - 1];
    let mut kept = Tile::default();
    let axes = (bank.axis(plane.width()), bank.axis(plane.height()));
    let mut rows = Vec::new();
    filter_tile(
        (&axes.0, &axes.1),
        plane,
        region,
        &mut FilterScratch::default(),
        &mut differences,
        Some((keep, &mut kept)),
        &mut |_, range| rows.extend(range),
    );
    assert_eq!(rows, region.rows.clone().collect::<Vec<_>>());
    (differences, kept)
}

#[test]
fn levels_are_those_of_the_chain_up_to_the_cut() {
    for (width, height) in [(190, 150), (40, 33), (75, 61), (22, 23), (24, 25), (5, 17)] {
        let plane = texture(width, height);
        let mut levels = Vec::new();
        for kernel in chain() {
            let before = levels.last().unwrap_or(&plane);
            levels.push(gaussian_blur(before, &kernel));
        }
        let bank = FilterBank::new(chain(), 0..5);
        let whole = Region { columns: 0..width, rows: 0..height };
        let (differences, kept) = filtered(&plane, &bank, &whole, 3);
        for v in 0..height {
            for u in 0..width {
                assert!((kept.at(u, v) - levels[3].at(u, v)).abs() < 1e-5, "{u} {v}");
                for (i, difference) in differences.iter().enumerate() {
                    let expected = levels[i + 1].at(u, v) - levels[i].at(u, v);
                    assert!((difference.at(u, v) - expected).abs() < 2e-5, "{i} {u} {v}");
                }
            }
        }
    }
}

#[test]
fn tiles_and_fewer_levels_give_the_bits_of_the_whole() {
    let plane = texture(203, 171);
    let whole = Region { columns: 0..203, rows: 0..171 };
    let (all, _) = filtered(&plane, &FilterBank::new(chain(), 0..5), &whole, 0);
    let regions = [
        Region { columns: 0..57, rows: 0..171 },
        Region { columns: 3..9, rows: 5..14 },
        Region { columns: 51..150, rows: 33..104 },
        Region { columns: 180..203, rows: 160..171 },
    ];
    for region in regions {
        let (tile, _) = filtered(&plane, &FilterBank::new(chain(), 0..5), &region, 0);
        let (two, _) = filtered(&plane, &FilterBank::new(chain(), 2..4), &region, 0);
        for v in region.rows.clone() {
            let columns = region.columns.clone();
            for i in 0..4 {
                assert_eq!(tile[i].row(v), &all[i].row(v)[columns.clone()], "{region:?} {v} {i}");
            }
            assert_eq!(two[0].row(v), &all[2].row(v)[columns], "{region:?} {v}");
        }
    }
}

