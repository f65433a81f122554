//! Tests of `detector::noise_model::contrast`.
#![allow(unused_imports)]

use burstscope_core::burst::*;
use burstscope_core::detector::*;
use burstscope_core::detector::noise_model::*;
use burstscope_core::detector::params::*;
use burstscope_core::detector::scale_space::*;
use burstscope_core::plane::*;
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::ops::Range;
use burstscope_core::detector::params::SlopeGrid;
use burstscope_core::synth::random::Stream;

#[test]
fn contrasts_keep_the_variance_and_take_off_what_changes_steadily() {
    for frames in [2, 3, 7, 10] {
        for contrast in contrasts(frames) {
            assert!((contrast.iter().map(|(_, w)| w * w).sum::<f32>() - 1.0).abs() < 1e-6);
            assert!(contrast.iter().map(|(_, w)| w).sum::<f32>().abs() < 1e-6);
            assert!(contrast.iter().all(|&(t, _)| t < frames));
        }
    }
    assert_eq!(contrasts(7).iter().map(|c| c[0].0).collect::<Vec<_>>(), [0, 3, 1, 4, 2]);
}

#[test]
fn triples_lie_apart_from_first_to_last() {
    assert_eq!(looked_at(10, 2_000_000).0, [0, 1, 2, 7, 8, 9]);
    assert_eq!(looked_at(4, 2_000_000).0, [0, 1, 2, 3]);
    for (frames, pixels) in (2..40).flat_map(|frames| [(frames, 1000), (frames, 200_000), (frames, 5_000_000)]) {
        let (looked, contrasts) = looked_at(frames, pixels);
        assert!(
            looked.is_sorted_by(|a, b| a < b) && looked[looked.len() - 1] < frames && !contrasts.is_empty(),
            "{looked:?}"
        );
        let neighbours = |c: &Contrast| looked[c[c.len() - 1].0] - looked[c[0].0] == c.len() - 1;
        assert!(contrasts.iter().all(neighbours), "{frames} {pixels}");
    }
}

#[test]
fn views_are_compared_with_their_neighbours_in_rows_and_columns() {
    let grid = |rows: usize, columns: usize| -> Vec<Offset<f32>> {
        burstscope_core::burst::Positions::grid(rows, columns).offsets().iter().map(|at| at.to_f32()).collect()
    };
    let (looked, contrasts) = looked_at_views(&grid(3, 5), 10_000);
    assert_eq!((looked.len(), contrasts.len()), (15, 5));
    assert_eq!(contrasts[1].iter().map(|(t, _)| looked[*t]).collect::<Vec<_>>(), [5, 6, 7]);
    assert_eq!(contrasts[3].iter().map(|(t, _)| looked[*t]).collect::<Vec<_>>(), [3, 8, 13]);
    let (looked, contrasts) = looked_at_views(&grid(9, 9), 500_000);
    assert_eq!((looked.len(), contrasts.len()), (6, 2));
    assert!(contrasts.iter().flatten().all(|(t, _)| *t < 6) && looked.is_sorted());
    assert_eq!(looked_at_views(&grid(2, 2), 10_000), looked_at(4, 10_000));
}

#[test]
fn reads_stay_inside() {
    let contrast = &contrasts(3)[0];
    let at = [0.0, 1.0, 2.0].map(|time| Offset::from(time).to_f32());
    let both =
        |slope: f32, range: Range<usize>| shifts(contrast, &at, Slope::new(slope, 0.0), (&range, &range), (40, 40));
    let shifts = |slope: f32, range: Range<usize>| -> Vec<i64> {
        both(slope, range).into_iter().map(|(u, v)| if v == 0 { u } else { i64::MAX }).collect()
    };
    assert_eq!(shifts(3.0, 0..20), [0, 3, 6]);
    assert_eq!(shifts(3.0, 20..40), [-6, -3, 0]);
    assert_eq!(shifts(-3.0, 10..20), [3, 0, -3]);
    assert_eq!(shifts(3.0, 0..40), [0, 0, 0], "there is nowhere to go");
}

#[test]
fn each_part_has_its_own_motion() {
    let mut stream = Stream::new(3, 0);
    let scene = Plane::from_fn(340, 200, |_, _| stream.normal() as f32);
    // The left half moves by 2 px/frame to the right, the right half as fast to the left.
    let frame = |t: usize| {
        Plane::from_fn(256, 192, |u, v| {
            let by = if u < 128 { 40 - 2 * t } else { 40 + 2 * t };
            scene.at(u + by, v)
        })
    };
    let frames: Vec<BoxPyramid> = (0..8).map(|t| BoxPyramid::new(&frame(t), 5)).collect();
    let pyramids: Vec<&BoxPyramid> = frames.iter().collect();
    let at: Vec<Offset<f32>> = (0..8).map(|t| Offset::from(f64::from(t)).to_f32()).collect();
    let slopes: Vec<Slope> = SlopeGrid::plane(-3.0..=3.0, 7, -1.0..=1.0, 3).slopes().collect();
    let motion = SceneMotion { pyramids: &pyramids, offsets: &at, slopes: &slopes };
    let found = motion.slopes_at(&[(30.0, 90.0), (220.0, 90.0)], (256, 192));
    assert_eq!(found, [Slope::new(2.0, 0.0), Slope::new(-2.0, 0.0)]);
    // Where pixels are so large that nothing moves, and where there is no choice, the slowest is taken.
    let region = Region { columns: 0..128, rows: 0..128 };
    assert_eq!(motion.for_octave(4).slope_in(&region), Slope::default());
    let one = SceneMotion { slopes: &slopes[..1], ..motion };
    assert_eq!(one.for_octave(0).slope_in(&region), slopes[0]);
}

