//! Tests of `synth::noise_case`.

use burstscope_core::burst::*;
use burstscope_core::monitor::*;
use burstscope_core::synth::noise_case::*;

const SIZE: (usize, usize) = (200, 120);

fn burst(case: NoiseCase) -> Burst {
    case.burst(SIZE, 10, 0.02, 3, &Monitor::default()).expect("not cancelled")
}

fn of_frame(burst: &Burst, t: usize, columns: std::ops::Range<usize>) -> (f64, f64) {
    let frame = &burst.frames[t];
    let values: Vec<f64> =
        (0..SIZE.1).flat_map(|v| frame.row(v)[columns.clone()].iter().map(|&x| f64::from(x))).collect();
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    (mean, (values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / values.len() as f64).sqrt())
}

#[test]
fn names_are_read_back_and_others_are_refused() {
    for case in NoiseCase::ALL {
        assert_eq!(case.name().parse(), Ok(case));
    }
    assert_eq!("jpeg-77".parse(), Ok(NoiseCase::Jpeg(77)));
    assert_eq!("varying-3".parse(), Ok(NoiseCase::Varying(3)));
    assert_eq!("drifting-stripes-2".parse(), Ok(NoiseCase::DriftingStripes(20)));
    for bad in "jpeg-0 jpeg-101 varying-1 varying-x drifting-stripes-0.0 drifting-stripes-10 fading- grey ".split(' ') {
        let error = bad.parse::<NoiseCase>().expect_err(bad);
        assert!(error.contains("column-stripes"), "{error}");
    }
}

#[test]
fn every_case_is_what_it_says() {
    let all = 0..SIZE.0;
    let near = |a: f64, b: f64| (a / b - 1.0).abs() < 0.03;
    let doubled = burst(NoiseCase::Doubled);
    assert!(doubled.frames[4] == doubled.frames[5] && doubled.frames[5] != doubled.frames[6]);
    assert_eq!(of_frame(&burst(NoiseCase::BlackFrame), 5, all.clone()), (0.0, 0.0));
    assert!(near(of_frame(&burst(NoiseCase::NoisyFrame), 5, all.clone()).1, 0.1));
    assert!(near(of_frame(&burst(NoiseCase::NoisyFrame), 4, all.clone()).1, 0.02));
    let half = burst(NoiseCase::NoisyHalf);
    assert!(near(of_frame(&half, 2, 0..100).1, 0.02) && near(of_frame(&half, 2, 100..200).1, 0.06));
    assert!(near(of_frame(&burst(NoiseCase::Correlated), 1, all.clone()).1, 0.02));
    assert!(near(of_frame(&burst(NoiseCase::ClippedBlack), 1, all.clone()).0, 0.02 * 0.398_9));
    assert!(near(1.0 - of_frame(&burst(NoiseCase::Saturated), 1, all.clone()).0, 0.02 * 0.398_9));
    assert_eq!(of_frame(&burst(NoiseCase::ConstantFrame), 5, all.clone()).1, 0.0);
    assert_eq!(of_frame(&burst(NoiseCase::Constant), 1, all.clone()), (0.5, 0.0));
    let flicker = burst(NoiseCase::GainFlicker);
    let means: Vec<f64> = (0..10).map(|t| of_frame(&flicker, t, all.clone()).0 / 0.5 - 1.0).collect();
    let spread = (means.iter().map(|x| x * x).sum::<f64>() / 10.0).sqrt();
    assert!((0.04..0.2).contains(&spread), "{spread}");
}
