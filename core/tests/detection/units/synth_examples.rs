//! Tests of `synth::examples`.
#![allow(unused_imports)]

use burstscope_core::burst::*;
use burstscope_core::monitor::*;
use burstscope_core::synth::demo::*;
use burstscope_core::synth::examples::*;
use burstscope_core::synth::paint::*;
use burstscope_core::synth::random::*;
use burstscope_core::synth::truth::*;
use burstscope_core::synth::uneven::*;
use burstscope_core::synth::*;
use serde::{Deserialize, Serialize};
use std::ops::RangeInclusive;
use strum::{EnumCount, VariantArray};

#[test]
fn the_truth_lies_in_the_picture_and_moves_as_its_layer() {
    for example in Example::ALL {
        let truth = example.truth();
        assert!(truth.features.len() >= 5, "{example:?}: {} features", truth.features.len());
        for feature in &truth.features {
            let layer = &truth.layers[feature.layer.expect("scenes have layers")];
            assert_eq!((feature.slope_u, feature.slope_v), (layer.slope_u, layer.slope_v));
            let inside = (0.0..240.0).contains(&feature.u) && (0.0..180.0).contains(&feature.v);
            assert!(inside, "{example:?}: {feature:?}");
        }
    }
    let slopes: Vec<f64> = Example::Depths.truth().layers.iter().map(|layer| layer.slope_u).collect();
    assert!(slopes.len() == 9 && slopes.is_sorted() && slopes[8] > 2.0, "{slopes:?}");
}
