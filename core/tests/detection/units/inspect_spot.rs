//! Tests of `inspect::spot`.

use burstscope_core::inspect::spot::*;
use burstscope_core::plane::*;
use burstscope_core::synth::random::Stream;

fn picture(frames: usize) -> Plane {
    let mut stream = Stream::new(7, 0);
    let mut noise = |_| (0..frames).map(|_| stream.normal()).sum::<f64>() / frames as f64;
    let values: Vec<f64> = (0..64 * 64).map(&mut noise).collect();
    Plane::from_fn(64, 64, |u, v| {
        let disc = (u as f32 - 30.0).hypot(v as f32 - 34.0) < 8.0;
        0.2 + 0.1 * f32::from(disc) + 0.05 * values[v * 64 + u] as f32
    })
}

#[test]
fn it_measures_what_is_there_grows_with_the_root_of_the_frames_and_is_nothing_beside_the_picture() {
    let of = |frames| spot_snr(&picture(frames), [30.0, 34.0], 7.0, [10.0, 20.0]).expect("inside");
    assert!((of(1).ratio() - 2.0).abs() < 0.2, "{:?}", of(1));
    for frames in [4, 9] {
        let growth = of(frames).ratio() / of(1).ratio();
        assert!((growth / (frames as f32).sqrt() - 1.0).abs() < 0.12, "{frames} frames: {growth}");
    }
    for place in [[-40.0, 10.0], [1e9, 0.0], [f32::NAN, 3.0]] {
        assert_eq!(spot_snr(&picture(1), place, 5.0, [6.0, 9.0]), None);
    }
}
