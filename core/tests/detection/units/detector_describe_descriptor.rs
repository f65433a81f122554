//! Tests of `detector::describe::descriptor`.
#![allow(unused_imports)]

use burstscope_core::detector::*;
use burstscope_core::detector::describe::*;
use burstscope_core::detector::describe::descriptor::*;
use burstscope_core::detector::feature::*;
use multiversion::multiversion;
use std::f32::consts::TAU;
use burstscope_core::detector::scale_space::Base;
use burstscope_core::plane::Plane;

const SIZE: (usize, usize) = (101, 101);




#[test]
fn a_disc_without_some_rows_gives_nearly_the_sums_of_the_square() {
    let wave = level_of(|u, v| (0.11 * u + 0.003 * u * v).sin() + (0.13 * v + 0.1 * u).cos());
    for (place, sigma, orientation) in
        [((50.3, 49.6), 2.1, 0.4), ((48.0, 51.2), 2.9, 2.5), ((12.5, 80.0), 3.1, 5.5)]
    {
        let mut scratch = DescriptorScratch::default();
        let square = sums(&wave, SIZE, &Square::of(place, sigma, orientation), &mut scratch);
        let disc = sums(&wave, SIZE, &Square::coarse(place, sigma, orientation), &mut scratch);
        let (square, disc) = (pool(&[square]), pool(&[disc]));
        let off: f32 = square.iter().zip(disc).map(|(a, b)| f32::from(a.abs_diff(b)).powi(2)).sum();
        assert!(off.sqrt() < 40.0, "{orientation}: {} of 512", off.sqrt());
    }
}



