//! Tests of `detector::noise_model`.
#![allow(unused_imports)]

use burstscope_core::burst::Positions;
use burstscope_core::detector::noise::*;
use burstscope_core::detector::noise_model::*;
use burstscope_core::detector::params::Interpolation;
use burstscope_core::detector::params::*;
use burstscope_core::detector::scale_space::*;
use burstscope_core::detector::stack::frame_offsets;
use burstscope_core::detector::*;
use burstscope_core::plane::*;
use serde::Serialize;

#[test]
fn white_noise_has_the_bits_of_the_one_sigma() {
    let space = ScaleSpace::new(4, 0, 4.0);
    let slope = Slope::new(1.3, 0.2);
    let offsets = frame_offsets(&Positions::even(10), slope, Interpolation::Linear);
    let model = NoiseModel::white(0.0123);
    for (octave, level) in [(0, 0), (2, 3)] {
        let expected = 0.0123 * dog_noise_variance(&space, octave, f64::from(level), &offsets).sqrt() as f32;
        assert_eq!(model.sigma_d(&space, (octave, level), (slope, &offsets), 5.0), expected);
    }
    assert_eq!(model.place_factor(0, &offsets, (3, 4), (100, 80)), 1.0);
}
