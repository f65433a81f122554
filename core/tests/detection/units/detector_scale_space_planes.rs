//! Tests of `detector::scale_space::planes`.
#![allow(unused_imports)]

use burstscope_core::detector::*;
use burstscope_core::detector::scale_space::*;
use burstscope_core::monitor::*;
use burstscope_core::plane::*;
use rayon::prelude::*;
use std::ops::Range;
use burstscope_core::burst::Positions;
use burstscope_core::detector::params::{CoarseStart, Interpolation, Slope};
use burstscope_core::detector::scale_space::{SIGMA_BASE, SIGMA_INPUT};
use burstscope_core::detector::stack::{frame_offsets, motion_stack};
use burstscope_core::plane::blur::GaussianKernel;

#[test]
fn a_part_of_a_first_level_is_that_of_the_whole() {
    let frame =
        |t: usize| Plane::from_fn(701, 423, |u, v| ((u * 7919 + v * 104_729 + t * 31) % 997) as f32 / 997.0);
    let frames: Vec<Plane> = (0..3).map(frame).collect();
    let frames: Vec<&Plane> = frames.iter().collect();
    let offsets = frame_offsets(&Positions::even(3), Slope::new(1.3, -0.4), Interpolation::Linear);
    for first_octave in [-1, 0, 1] {
        let space = ScaleSpace::new(4, first_octave, 4.0);
        let stack = SlopeStack { frames: &frames, offsets: &offsets, space: &space, size_image: (701, 423) };
        let monitor = Monitor::default();
        let last = first_octave + 3;
        let planes = stack.first_levels(last, &monitor).expect("not cancelled");
        assert_eq!(planes.len(), 3);
        for (octave, plane) in (first_octave + 1..).zip(&planes) {
            let size = octave_size((701, 423), octave);
            assert_eq!(plane.size(), size);
            for region in [
                whole(size),
                Region { columns: 0..1, rows: 0..1 },
                Region { columns: size.0 - 1..size.0, rows: size.1 / 2..size.1 },
                Region { columns: size.0 / 3..size.0 / 2, rows: size.1 / 3..size.1 / 3 + 1 },
            ] {
                let part = stack.first_level(octave, &region, &monitor).expect("not cancelled");
                for v in region.rows.clone() {
                    let columns = region.columns.clone();
                    assert_eq!(part.row(v)[columns.clone()], plane.row(v)[columns], "{first_octave} {octave}");
                }
            }
        }
    }
}

#[test]
fn stripes_finer_than_the_pixels_of_a_coarse_octave_vanish_or_where_it_skips_pixels_alias() {
    // Every second pixel of stripes 2.1 pixels apart shows stripes 21 of its own pixels apart.
    let stripes = Plane::from_fn(320, 240, |u, _| (u as f32 * 0.95 * std::f32::consts::PI).cos());
    let (offsets, monitor) =
        (frame_offsets(&Positions::even(1), Slope::default(), Interpolation::Linear), Monitor::default());
    let strongest = |start| {
        let space = ScaleSpace::starting(3, 1, start, 4.0);
        let binned = space.binned(&[&stripes], &monitor).expect("not cancelled");
        assert_eq!((binned.len(), space.skip()), if start == CoarseStart::Binned { (1, 1) } else { (0, 2) });
        let frames = [binned.first().unwrap_or(&stripes)];
        let stack = SlopeStack { frames: &frames, offsets: &offsets, space: &space, size_image: (320, 240) };
        let dog = dog_plane(&stack.base(), &space, (160, 120), 2, &monitor).expect("not cancelled");
        (20..100).flat_map(|v| dog.row(v)[20..140].to_vec()).fold(0.0, |max: f32, x| max.max(x.abs()))
    };
    let (binned, skipped) = (strongest(CoarseStart::Binned), strongest(CoarseStart::Skipped));
    assert!(skipped > 0.1 && binned < 0.01 * skipped, "{binned} {skipped}");
}

#[test]
fn a_start_that_skips_pixels_keeps_theirs() {
    let frame = |t: usize| Plane::from_fn(61, 43, |u, v| ((u * 7919 + v * 104_729 + t * 31) % 997) as f32 / 997.0);
    let frames = [0, 1, 2].map(frame);
    let (slope, monitor) = (Slope::new(1.3, -0.4), Monitor::default());
    let stack = motion_stack(&frames.each_ref(), &Positions::even(3), slope, Interpolation::Linear, &monitor)
        .expect("not cancelled");
    let offsets = frame_offsets(&Positions::even(3), slope, Interpolation::Linear);
    let (mut tiles, size) = (Vec::new(), (30, 21));
    stack_tiles(&frames.each_ref(), &[&offsets], 1, &whole(size), &mut tiles);
    for (x, y) in (0..size.1).flat_map(|y| (0..size.0).map(move |x| (x, y))) {
        assert_eq!(tiles[0].at(x, y), stack.at(2 * x, 2 * y), "({x}, {y})");
    }
    let space = ScaleSpace::starting(4, 1, CoarseStart::Skipped, 4.0);
    let base = (SIGMA_BASE.powi(2) - (SIGMA_INPUT / 2.0).powi(2)).sqrt();
    assert_eq!(space.base_kernel, GaussianKernel::with_cut(base, 4.0));
    // The triangle of half-width 2 has the variance 1/2.
    assert!((ScaleSpace::new(4, 1, 4.0).sigma_before(1).powi(2) - 0.75 / 4.0).abs() < 1e-12);
}

