//! Tests of `plane::tile`.
#![allow(unused_imports)]

use burstscope_core::plane::*;
use std::ops::Range;

#[test]
fn cuts_cover_everything_once_and_split_planes() {
    let region = Region { columns: 10..13, rows: 5..7 };
    assert_eq!(region.widened(6, (14, 9)), Region { columns: 4..14, rows: 0..9 });
    for n in [1, 2, 7, 16, 99, 148, 149, 1600] {
        for max in [2, 8, 148] {
            let parts = cuts(n, max);
            assert_eq!(parts.iter().cloned().flatten().collect::<Vec<_>>(), (0..n).collect::<Vec<_>>());
            assert!(parts.iter().all(|p| p.start % 2 == 0 && p.len() <= max + 1), "{n} {max}");
        }
    }
    let mut plane = Plane::zeros(21, 13);
    let (columns, rows) = (cuts(21, 8), cuts(13, 6));
    let parts = split_mut(&mut plane, &columns, &rows);
    assert_eq!(parts.len(), columns.len() * rows.len());
    for (index, part) in parts.into_iter().enumerate() {
        for row in part {
            row.fill(index as f32 + 1.0);
        }
    }
    for v in 0..13 {
        for u in 0..21 {
            let at = |parts: &[Range<usize>], x: usize| parts.iter().position(|p| p.contains(&x)).expect("covered");
            assert_eq!(plane.at(u, v), (at(&rows, v) * columns.len() + at(&columns, u) + 1) as f32);
        }
    }
}

