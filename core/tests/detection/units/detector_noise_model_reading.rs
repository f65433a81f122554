//! Tests of `detector::noise_model::reading`.
#![allow(unused_imports)]

use burstscope_core::detector::*;
use burstscope_core::detector::noise_model::*;
use burstscope_core::monitor::*;
use burstscope_core::plane::*;
use multiversion::multiversion;
use rayon::prelude::*;
use std::ops::Range;
use burstscope_core::synth::random::Stream;

#[test]
fn one_reading_gives_what_single_looks_give() {
    let mut stream = Stream::new(2, 0);
    let mut frames = [(); 5].map(|()| Plane::from_fn(101, 75, |_, _| stream.normal() as f32));
    for frame in &mut frames {
        [(0, 3), (40, 40), (100, 74)].iter().for_each(|&(u, v)| frame.row_mut(v)[u] = 50.0);
    }
    let frames: Vec<&Plane> = frames.iter().collect();
    let reading = Reading::new(&frames, 4, Some(20.0), &Monitor::default()).expect("not cancelled");
    assert_eq!(reading.standing_out, [(0, 3), (40, 40), (100, 74)]);
    let alone = Reading::new(&frames, 4, None, &Monitor::default()).expect("not cancelled");
    for ((pyramid, alone), frame) in reading.pyramids.iter().zip(&alone.pyramids).zip(&frames) {
        assert_eq!(*pyramid, BoxPyramid::new(frame, 4));
        assert_eq!(pyramid, alone);
    }
    for (t, frame) in frames.iter().enumerate() {
        let mean = |columns: Range<usize>, rows: Range<usize>| {
            let count = (columns.len() * rows.len()) as f32;
            rows.map(|v| frame.row(v)[columns.clone()].iter().sum::<f32>()).sum::<f32>() / count
        };
        assert!((reading.columns[t][0][7] - mean(7..8, 0..8)).abs() < 1e-5);
        assert!((reading.columns[t][7][7] - mean(7..8, 64..75)).abs() < 1e-5);
        assert!((reading.rows[t][1][70] - mean(12..25, 70..71)).abs() < 1e-5);
        assert_eq!(reading.rows[t][1].len(), 75);
        assert_eq!(lines_of(frame), [reading.columns[t].clone(), reading.rows[t].clone()]);
    }
}

#[test]
fn a_ramp_is_sampled_as_it_is_and_levels_end_where_no_square_fits() {
    let small = BoxPyramid::new(&Plane::zeros(13, 9), 9);
    assert_eq!((small.len(), small.level(1).size(), small.level(7).size()), (3, (6, 4), (1, 1)));
    let frame = Plane::from_fn(64, 48, |u, v| u as f32 + 2.0 * v as f32);
    let pyramid = BoxPyramid::new(&frame, 3);
    for (u, v) in [(20.0, 11.0), (3.5, 3.5), (41.25, 30.0)] {
        assert!((sample_at(pyramid.level(3), 8.0, u, v) - (u + 2.0 * v)).abs() < 1e-3);
    }
    assert!((sample_at(pyramid.level(3), 8.0, 0.0, 0.0) - (3.5 + 7.0)).abs() < 1e-3, "the nearest square");
    assert!(sample_at(pyramid.level(6), 64.0, 5.0, 5.0).is_finite());
}

