//! Tests of `synth::paint`.

use burstscope_core::synth::paint::*;

#[test]
fn a_disc_covers_its_inside() {
    let mut sheet = Sheet::new(40, 30, 3, 2);
    sheet.disc(17.3, 12.8, 6.0, 0.5);
    assert_eq!(sheet.alpha_at(17.0, 13.0), 1.0);
    assert_eq!(sheet.alpha_at(30.0, 13.0), 0.0);
    assert_eq!(sheet.alpha_at(-99.0, 1e9), 0.0);
    let mut outside = Sheet::new(20, 20, 0, 0);
    outside.disc(-100.0, 5.0, 3.0, 1.0);
    assert_eq!(outside.used(), None);
}

#[test]
fn relief_is_smooth_and_within_bounds() {
    let mut last = fractal_relief(1, 0.0, 3.0, 20.0, 3);
    for k in 1..2000 {
        let x = fractal_relief(1, k as f32 * 0.1, 3.0, 20.0, 3);
        assert!((0.0..=1.0).contains(&x) && (x - last).abs() < 0.03);
        last = x;
    }
}
