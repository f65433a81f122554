//! Tests of `synth::scene`.

use burstscope_core::detector::stack::motion_stack;
use burstscope_core::detector::{Interpolation, Slope};
use burstscope_core::monitor::*;
use burstscope_core::plane::Plane;
use burstscope_core::synth::LayerTruth;
use burstscope_core::synth::scene::*;
use burstscope_core::synth::*;

fn small() -> SceneParams {
    SceneParams { width: 320, height: 240, layers: 3, frames: 5, ..SceneParams::default() }
}

#[test]
fn landmarks_stand_out_at_their_own_slope_and_place() {
    let params = SceneParams { snr: f64::INFINITY, motion: Motion::TwoD, ..small() };
    let (burst, truth) = synth_scene(&params, &Monitor::default()).expect("a scene");
    assert!(truth.features.len() >= 10, "{} landmarks", truth.features.len());
    assert!(truth.layers.windows(2).all(|w| w[1].slope_u > w[0].slope_u), "{:?}", truth.layers);
    let frames: Vec<&Plane> = burst.frames.iter().map(|f| &**f).collect();
    let stack = |layer: &LayerTruth| {
        let slope = Slope::new(layer.slope_u as f32, layer.slope_v as f32);
        motion_stack(&frames, &burst.positions, slope, Interpolation::Linear, &Monitor::default()).expect("a stack")
    };
    let stacks: Vec<Plane> = truth.layers.iter().map(stack).collect();
    for feature in &truth.features {
        let stack = &stacks[feature.layer.expect("scenes have layers")];
        let ring = |r: f64| {
            let at = |k: i32| {
                let (sin, cos) = (std::f64::consts::TAU * f64::from(k) / 24.0).sin_cos();
                let (u, v) = (feature.u + r * cos, feature.v + r * sin);
                f64::from(stack.get(u.round() as i64, v.round() as i64).unwrap_or(0.0))
            };
            (0..24).map(at).sum::<f64>() / 24.0
        };
        let contrast = ring(0.0) - ring(feature.radius + 1.5);
        assert!(contrast * f64::from(feature.contrast_sign) > 0.004, "{feature:?}: {contrast}");
    }
}

#[test]
fn nonsense_is_named() {
    for (params, name) in [
        (SceneParams { layers: 0, ..small() }, "layers"),
        (SceneParams { layers: 99, ..small() }, "layers"),
        (SceneParams { snr: 0.01, ..small() }, "snr"),
        (SceneParams { height: 1, ..small() }, "height"),
    ] {
        let error = synth_scene(&params, &Monitor::default()).expect_err(name).to_string();
        assert!(error.starts_with(name), "{error}");
    }
}
