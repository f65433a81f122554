//! Tests of `matching::align::grid`.
#![allow(unused_imports)]

use burstscope_core::matching::*;
use burstscope_core::matching::align::*;
use burstscope_core::matching::align::chip::*;

#[test]
fn an_affine_map_and_its_inverse_undo_one_another() {
    let map = Affine { matrix: [[1.2, -0.3], [0.4, 0.9]], shift: [3.0, -2.0] };
    let none = map.after(&map.inverse().expect("it can be undone"));
    let [u, v] = none.apply(5.0, -7.0);
    assert!((u - 5.0).abs() < 1e-5 && (v + 7.0).abs() < 1e-5, "{none:?}");
    assert_eq!(Affine { matrix: [[1.0, 2.0], [2.0, 4.0]], ..map }.inverse(), None);
}

#[test]
fn between_the_samples_a_parabola_is_exact_with_its_derivatives() {
    let value = |x: f32, y: f32| 0.5 * x * x - 0.2 * x * y + 0.1 * y * y + x - 3.0;
    let values = (0..SIDE * SIDE).map(|k| value((k % SIDE) as f32 - 20.0, (k / SIDE) as f32 - 20.0)).collect();
    let grid = Grid { values, readable: [[1.0, SIDE as f32 - 2.0]; 2] };
    let places = Affine { matrix: [[0.9, -0.4], [0.4, 0.9]], shift: [20.0, 20.0] };
    let (x, y) = ([0.3f32, -4.1, 7.77, 90.0], [0.0f32, 2.6, -5.5, 0.0]);
    let (mut values, mut along_x, mut along_y, mut seen) = ([0.0; 4], [0.0; 4], [0.0; 4], [0.0; 4]);
    let mut into = Template { values: &mut values, along_x: &mut along_x, along_y: &mut along_y, seen: &mut seen };
    grid.read_with_gradient(&places, Points { x: &x, y: &y }, &mut into);
    assert_eq!(seen, [1.0, 1.0, 1.0, 0.0]);
    let at = |x: f32, y: f32| value(0.9 * x - 0.4 * y, 0.4 * x + 0.9 * y);
    for k in 0..3 {
        let expected = [
            at(x[k], y[k]),
            (at(x[k] + 0.5, y[k]) - at(x[k] - 0.5, y[k])),
            (at(x[k], y[k] + 0.5) - at(x[k], y[k] - 0.5)),
        ];
        for (found, expected) in [values[k], along_x[k], along_y[k]].iter().zip(expected) {
            assert!((found - expected).abs() < 1e-3, "{k}: {found} {expected}");
        }
    }
    let (mut again, mut seen) = ([0.0; 4], [0.0; 4]);
    grid.read(&places, Points { x: &x, y: &y }, &mut again, &mut seen);
    assert_eq!(again, values);
}

