//! Tests of the public functions of `synth`.

use crate::prelude::*;
use burstscope_core::{detector::stack::motion_stack, synth::noise::*, synth::paint::*, synth::random::*};

#[test]
fn an_arm_stands_still_and_hides_what_lies_behind_it() {
    let plain = ChartParams { width: 240, height: 180, discs: 12, frames: 5, ..ChartParams::default() };
    let plain = ChartParams { radius: 3.6..=9.0, snr: f64::INFINITY, ..plain };
    let made = |mask: f64| synth_chart(&ChartParams { mask, ..plain.clone() }, &quiet());
    let (bare, all) = made(0.0).expect("a chart");
    let (burst, truth) = made(0.4).expect("a chart");
    assert_eq!((all.mask_columns, truth.mask_columns, all.mask()), (0, 96, None));
    assert!(!truth.features.is_empty() && truth.features.iter().all(|disc| disc.u > 96.0));
    assert!(all.features.iter().filter(|disc| disc.u > 130.0).all(|disc| truth.features.contains(disc)));
    for (frame, bare) in burst.frames.iter().zip(&bare.frames) {
        assert_eq!(frame.row(50)[..96], burst.frames[0].row(50)[..96], "the arm moves");
        assert_eq!(frame.row(50)[96..], bare.row(50)[96..], "the rest is the chart");
    }
    let masked = truth.masked(burst);
    assert!(masked.frames.iter().all(|frame| frame.weight_at(95, 0) == 0.0 && frame.weight_at(96, 0) == 1.0));
    let error = made(0.95).expect_err("nothing is left").to_string();
    assert!(error.starts_with("mask: 0.95 of the columns"), "{error}");
}

fn small_chart() -> ChartParams {
    ChartParams { width: 240, height: 180, discs: 9, radius: 3.6..=12.0, frames: 5, ..ChartParams::default() }
}

#[test]
fn nonsense_in_a_chart_or_a_scene_is_named_with_its_remedy() {
    for (params, name) in [
        (ChartParams { discs: 5000, ..small_chart() }, "discs"),
        (ChartParams { radius: 5.0..=3.0, ..small_chart() }, "radius"),
        (ChartParams { contrast: 1.0, ..small_chart() }, "contrast"),
        (ChartParams { snr: -1.0, ..small_chart() }, "snr"),
        (ChartParams { bits: 2, ..small_chart() }, "bits"),
        (ChartParams { frames: 0, ..small_chart() }, "frames"),
        (ChartParams { width: 3, ..small_chart() }, "width"),
        (ChartParams { max_slope: 1000.0, ..small_chart() }, "max-slope"),
        (ChartParams { max_slope: f64::NAN, ..small_chart() }, "max-slope"),
        (ChartParams { width: 32768, height: 32768, frames: 4096, ..small_chart() }, "frames"),
        (ChartParams { read_noise: -1.0, ..small_chart() }, "read-noise"),
        (ChartParams { gap: f64::NAN, ..small_chart() }, "gap"),
    ] {
        let error = synth_chart(&params, &quiet()).expect_err(name).to_string();
        assert!(error.starts_with(&format!("{name}: ")), "{error}");
    }
    assert!(synth_chart(&small_chart(), &cancelled()).is_err_and(|error| error.is_cancelled()));
    for (params, name) in [
        (SceneParams { layers: 0, ..small_scene() }, "layers"),
        (SceneParams { layers: 99, ..small_scene() }, "layers"),
        (SceneParams { snr: 0.01, ..small_scene() }, "snr"),
        (SceneParams { height: 1, ..small_scene() }, "height"),
    ] {
        let error = synth_scene(&params, &quiet()).expect_err(name).to_string();
        assert!(error.starts_with(name), "{error}");
    }
}

#[test]
fn each_disc_is_where_the_truth_says_in_every_frame() {
    let params = ChartParams { snr: f64::INFINITY, motion: Motion::TwoD, ..small_chart() };
    let (burst, truth) = synth_chart(&params, &quiet()).expect("a chart");
    let background = params.exposure().expect("valid").background + truth.black_level;
    let mut measured = 0;
    for (t, frame) in burst.frames.iter().enumerate() {
        let dt = t as f64 - truth.t0;
        for disc in &truth.features {
            let (u, v) = disc.position(dt);
            let is_near = |d: &FeatureTruth| {
                let (x, y) = d.position(dt);
                d.id != disc.id && (x - u).hypot(y - v) <= d.radius + disc.radius + 4.0
            };
            if truth.features.iter().any(is_near) {
                continue;
            }
            let span = |at: f64| (at - disc.radius - 2.0).ceil() as usize..=(at + disc.radius + 2.0) as usize;
            let (mut mass, mut moment) = (0.0, [0.0; 2]);
            for (x, y) in span(v).flat_map(|y| span(u).map(move |x| (x, y))) {
                let w = f64::from(frame.at(x, y)) - background;
                mass += w;
                moment = [moment[0] + w * x as f64, moment[1] + w * y as f64];
            }
            let middle = moment.map(|sum| sum / mass);
            let off = (middle[0] - u).abs().max((middle[1] - v).abs());
            assert!(off < 0.01, "frame {t}, disc {}: {middle:?} for {u}, {v}", disc.id);
            let area = mass / (params.exposure().expect("valid").disc - background + truth.black_level);
            let true_area = std::f64::consts::PI * disc.radius * disc.radius;
            assert!((area / true_area - 1.0).abs() < 2e-3, "area {area} for {true_area}");
            measured += 1;
        }
    }
    assert!(measured > 30, "only {measured} discs stood alone");
}

#[test]
fn a_seed_gives_the_same_bits_for_ever_and_discs_keep_their_distance_and_stay_inside() {
    let made = |seed: u64| synth_chart(&ChartParams { seed, ..small_chart() }, &quiet()).expect("a chart");
    let [one, four, other] = [(1, 3), (4, 3), (4, 4)].map(|(threads, seed)| on_threads(threads, || made(seed)));
    assert_eq!((&one.0.frames, &one.1), (&four.0.frames, &four.1));
    assert!(one.0.frames != other.0.frames && one.1.features != other.1.features);
    let params = ChartParams { motion: Motion::TwoD, frames: 10, ..ChartParams::default() };
    let discs = synth_chart(&params, &quiet()).expect("they fit").1.features;
    assert_eq!(discs.len(), 90);
    for a in &discs {
        for dt in [-4.5, 4.5] {
            let (u, v) = a.position(dt);
            assert!(u - a.radius >= 0.0 && v - a.radius >= 0.0);
            assert!(u + a.radius <= 799.0 && v + a.radius <= 599.0);
        }
        for b in discs.iter().filter(|b| b.id != a.id) {
            assert!((a.u - b.u).hypot(a.v - b.v) >= a.radius + b.radius + params.gap);
        }
    }
    // Published tables use these charts.
    let first = synth_chart(&ChartParams::default(), &quiet()).expect("they fit").1.features[0];
    let expected = [18.941_430_711_460_43, 124.522_301_286_314_56, 42.249_995_958_163_68, 2.564_286_188_923_249_6];
    assert_eq!([first.radius, first.u, first.v, first.slope_u], expected);
}

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

#[test]
fn the_examples_and_the_demo_are_what_they_say_and_the_same_everywhere() {
    let alone = |make: &(dyn Fn() -> Burst + Sync)| on_threads(1, make).frames;
    for example in Example::ALL {
        let burst = example.burst();
        assert_eq!(burst.name, example.name());
        assert_eq!((burst.len(), burst.size()), (burst.positions.len(), (240, 180)));
        assert_eq!(burst.frames, alone(&|| example.burst()));
        let [u, v] = example.place();
        assert!(u < 240.0 && v < 180.0);
        assert!(example.slopes_u().0.contains(&example.slope_u()));
        assert!(example.name().starts_with("demo-") && !example.help().is_empty());
        assert_eq!(Example::named(example.name()), Some(example));
    }
    let demo = demo_burst();
    assert_eq!((demo.name.as_str(), demo.len(), demo.size()), ("demo", 10, (480, 360)));
    assert_eq!(demo.frames, alone(&demo_burst));
    let checksum = demo.frames.iter().flat_map(|f| f.data()).fold(0xcbf2_9ce4_8422_2325u64, |hash, &x| {
        let word = (f64::from(x) * 65535.0).round() as u64;
        (hash ^ word).wrapping_mul(0x0100_0000_01b3)
    });
    assert_eq!(checksum, 17_673_008_048_598_753_493, "the demo changed; if that is meant, change the number here");
    let truth = demo_truth();
    assert!(truth.layers.len() == 4 && truth.features.len() >= 40, "{} landmarks", truth.features.len());
}

fn expose(camera: &Camera, signal: &Plane, seed: u64) -> Plane {
    camera.capture(signal, &mut Stream::new(seed, 1), &quiet()).expect("not cancelled")
}

/// Mean and variance.
fn moments(samples: impl Iterator<Item = f64>) -> (f64, f64) {
    let values: Vec<f64> = samples.collect();
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    (mean, values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / values.len() as f64)
}

#[test]
fn mean_variance_and_snr_follow_the_model_and_rounding_keeps_to_the_levels() {
    const SIDE: usize = 500;
    for (electrons, signal, bits) in [(60.0, 0.05, 12), (300.0, 0.2, 8), (15_000.0, 0.3, 12), (40.0, 0.1, 10)] {
        let (full_scale_electrons, bits) = (electrons, Some(bits));
        let camera = Camera { full_scale_electrons, read_noise_electrons: 3.0, black_level: 0.45, bits };
        let frame = expose(&camera, &Plane::from_fn(SIDE, SIDE, |_, _| signal as f32), 2);
        let (mean, variance) = moments(frame.data().iter().map(|&x| f64::from(x)));
        let n = (SIDE * SIDE) as f64;
        let sigma = camera.sigma(signal);
        assert!((mean - 0.45 - signal).abs() < 5.0 * sigma / n.sqrt(), "{electrons}: mean {mean}");
        // The variance of a variance is 2σ⁴/n for Gaussian noise; Poisson's tails make it a little larger.
        let error = (2.2 / n).sqrt() * sigma * sigma;
        assert!((variance - sigma * sigma).abs() < 5.0 * error, "{electrons}: {variance} for {}", sigma * sigma);
    }
    for snr in [0.05, 0.2, 0.35, 1.0, 5.0, 20.0] {
        for read_noise in [0.0, 3.0] {
            let camera = Camera::for_snr(snr, 0.1, 0.12, read_noise, 0.02, 12).expect("within reach");
            let got = 0.02 / camera.sigma(0.11);
            assert!((got - snr).abs() < 1e-9 * snr, "{snr}: {got}");
        }
    }
    assert!(Camera::for_snr(f64::INFINITY, 0.1, 0.12, 3.0, 0.0, 12).expect("noiseless").is_noiseless());
    for bad in [0.0, -1.0, f64::NAN, 1e9] {
        let error = Camera::for_snr(bad, 0.1, 0.12, 3.0, 0.0, 12).expect_err("nonsense").to_string();
        assert!(error.starts_with("snr: "), "{error}");
    }
    assert_eq!([0.0, -1.0, 2.0, quantisation_step(12) * 7.4].map(|x| quantised_word(x, 12)), [0, 0, 65520, 7 * 16]);
    assert_eq!(quantised_word(1.0, 16), 65535);
    let words: Vec<u16> = (0..4096u16).map(|d| quantised_word(f64::from(d * 16) / 65535.0, 12)).collect();
    assert!(words.iter().enumerate().all(|(d, &w)| usize::from(w) == d * 16));
}

const SIZE: (usize, usize) = (200, 120);

fn burst(case: NoiseCase) -> Burst {
    case.burst(SIZE, 10, 0.02, 3, &quiet()).expect("not cancelled")
}

fn of_frame(burst: &Burst, t: usize, columns: std::ops::Range<usize>) -> (f64, f64) {
    let row = |v: usize| burst.frames[t].row(v)[columns.clone()].iter().map(|&x| f64::from(x));
    let (mean, variance) = moments((0..SIZE.1).flat_map(row));
    (mean, variance.sqrt())
}

#[test]
fn names_of_cases_and_kinds_are_read_back_and_kinds_do_what_both_their_cases_do() {
    NoiseCase::all().into_iter().for_each(|case| assert_eq!(case.name().parse(), Ok(case)));
    let cases = [NoiseCase::Jpeg(77), NoiseCase::Varying(3), NoiseCase::DriftingStripes(20)];
    assert_eq!(["jpeg-77", "varying-3", "drifting-stripes-2"].map(str::parse), cases.map(Ok));
    for bad in "jpeg-0 jpeg-101 varying-1 varying-x drifting-stripes-0.0 drifting-stripes-10 fading- grey ".split(' ') {
        says(bad.parse::<NoiseCase>().expect_err(bad), &["column-stripes"]);
    }
    for index in 0..100 {
        let kind = NoiseKind::drawn(index, 3);
        assert_eq!((kind.name().parse(), NoiseKind::drawn(index, 3)), (Ok(kind), kind));
    }
    let made = |text: &str| {
        let kind: NoiseKind = text.parse().expect(text);
        kind.burst_at(0.5, SIZE, 4, 0.02, 3, &quiet()).expect("not cancelled")
    };
    // Stripes alone repeat after their period, and are as strong as is asked for.
    let [strong, usual] =
        [2, 1].map(|strength| made(&format!("constant+column-stripes:strength={strength}:period=40")));
    let (strong, usual) = (strong.frames[1].row(7), usual.frames[0].row(9));
    assert_eq!(strong[..160], strong[40..]);
    assert!(strong.iter().zip(usual).all(|(a, b)| ((a - 0.5) - 2.0 * (b - 0.5)).abs() < 1e-6));
    assert_eq!(of_frame(&made("banding+black-frame"), 2, 0..SIZE.0), (0.0, 0.0));
    for bad in ["white:strength=x", "white+grey", "white:period=1", "white:phase=1", "white:twice"] {
        assert!(bad.parse::<NoiseKind>().is_err(), "{bad}");
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

#[test]
fn a_disc_covers_its_inside_relief_is_smooth_and_lattice_values_are_spread_evenly() {
    let mut sheet = Sheet::new(40, 30, 3, 2);
    sheet.disc(17.3, 12.8, 6.0, 0.5);
    assert_eq!([(17.0, 13.0), (30.0, 13.0), (-99.0, 1e9)].map(|(u, v)| sheet.alpha_at(u, v)), [1.0, 0.0, 0.0]);
    let mut outside = Sheet::new(20, 20, 0, 0);
    outside.disc(-100.0, 5.0, 3.0, 1.0);
    assert_eq!(outside.used(), None);
    let mut last = fractal_relief(1, 0.0, 3.0, 20.0, 3);
    for k in 1..2000 {
        let x = fractal_relief(1, k as f32 * 0.1, 3.0, 20.0, 3);
        assert!((0.0..=1.0).contains(&x) && (x - last).abs() < 0.03);
        last = x;
    }
    let (mean, variance) = moments((0..20_000).map(|k| f64::from(lattice(3, k % 200, k / 200))));
    assert!((mean - 0.5).abs() < 0.01 && (variance - 1.0 / 12.0).abs() < 0.003, "{mean} {variance}");
}

#[test]
fn poisson_and_normal_have_their_moments_and_the_first_numbers_of_a_seed_are_fixed() {
    const COUNT: usize = 200_000;
    for mean in [0.3, 4.0, 23.9, 24.1, 150.0, 20_000.0] {
        let mut stream = Stream::new(11, 0);
        let (m, v) = moments((0..COUNT).map(|_| stream.poisson(mean)));
        // Five standard errors of the mean, and of the variance (fourth central moment of Poisson: λ(1 + 3λ)).
        let n = COUNT as f64;
        assert!((m - mean).abs() < 5.0 * (mean / n).sqrt(), "mean of Poisson({mean}): {m}");
        let error = ((mean * (1.0 + 3.0 * mean) - mean * mean) / n).sqrt();
        assert!((v - mean).abs() < 5.0 * error, "variance of Poisson({mean}): {v}");
    }
    assert_eq!(Stream::new(1, 0).poisson(0.0), 0.0);
    let mut stream = Stream::new(7, 3);
    let first: Vec<u64> = (0..3).map(|_| (stream.uniform() * (1u64 << 53) as f64) as u64).collect();
    assert_eq!(first, [1_635_183_741_686_038, 836_447_931_249_957, 8_818_092_840_256_605]);
    assert_ne!(Stream::new(7, 4).uniform(), Stream::new(7, 3).uniform());
    const NORMALS: usize = 400_000;
    let mut stream = Stream::new(5, 1);
    let values: Vec<f64> = (0..NORMALS).map(|_| stream.normal()).collect();
    let (m, v) = moments(values.iter().copied());
    assert!(m.abs() < 5.0 / (NORMALS as f64).sqrt(), "{m}");
    assert!((v - 1.0).abs() < 5.0 * (2.0 / NORMALS as f64).sqrt(), "{v}");
    // Shares beyond 1, 2, 3 and (in the tail, past the last block) 3.5 standard deviations; five standard errors.
    for (limit, share) in [(1.0, 0.317_311), (2.0, 0.045_500), (3.0, 0.002_700), (3.5, 0.000_465)] {
        let got = values.iter().filter(|x| x.abs() > limit).count() as f64 / NORMALS as f64;
        assert!((got - share).abs() < 5.0 * (share / NORMALS as f64).sqrt(), "beyond {limit}: {got} for {share}");
    }
}

fn small_scene() -> SceneParams {
    SceneParams { width: 320, height: 240, layers: 3, frames: 5, ..SceneParams::default() }
}

#[test]
fn landmarks_stand_out_at_their_own_slope_and_place() {
    let params = SceneParams { snr: f64::INFINITY, motion: Motion::TwoD, ..small_scene() };
    let (burst, truth) = synth_scene(&params, &quiet()).expect("a scene");
    assert!(truth.features.len() >= 10, "{} landmarks", truth.features.len());
    assert!(truth.layers.windows(2).all(|w| w[1].slope_u > w[0].slope_u), "{:?}", truth.layers);
    let frames: Vec<&Plane> = burst.frames.iter().map(|f| &**f).collect();
    let stack = |layer: &LayerTruth| {
        let slope = Slope::new(layer.slope_u as f32, layer.slope_v as f32);
        motion_stack(&frames, &burst.positions, slope, Interpolation::Linear, &quiet()).expect("a stack")
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
fn exchanged_frames_are_told_by_images_and_truth_alone_and_numbers_are_those_of_positions() {
    let chart = ChartParams { width: 200, height: 150, discs: 4, max_slope: 1.0, frames: 5, ..Default::default() };
    let chart = ChartParams { radius: 3.6..=8.0, ..chart };
    let made = |drop: &[usize], exchange: &[usize]| {
        let uneven = Uneven { drop: drop.to_vec(), exchange: exchange.to_vec(), ..Uneven::default() };
        synth_chart(&ChartParams { uneven, ..chart.clone() }, &quiet())
    };
    let ((even, plain), (burst, truth)) = (made(&[], &[]).expect("even"), made(&[], &[0, 3]).expect("exchanged"));
    assert_eq!(truth.times, [3.0, 1.0, 2.0, 0.0, 4.0]);
    assert!(burst.positions.is_even() && (truth.t0, truth.span()) == (plain.t0, 4.0));
    assert_eq!((&burst.frames[0], &burst.frames[3]), (&even.frames[3], &even.frames[0]));
    assert_eq!(truth.features, plain.features);
    let (burst, truth) = made(&[1], &[0, 1]).expect("exchanged and dropped");
    assert_eq!(truth.times, [2.0, 0.0, 3.0, 4.0]);
    assert_eq!(burst.positions.since_first(), [0.0, 2.0, 3.0, 4.0]);
    for wrong in [&[1][..], &[2, 2], &[0, 5], &[0, 1, 2]] {
        let error = made(&[], wrong).expect_err("no two frames").to_string();
        assert!(error.starts_with("exchange: these are no two frames"), "{error}");
    }
    for text in ["", "1x9", "9x1", "3x5", "9x9"] {
        let uneven = Uneven { views: text.parse().ok(), ..Uneven::default() };
        let (whole, (count, span)) = (uneven.whole(10), uneven.count_and_span(10));
        assert!(count == whole.len() && (span - whole.span()).abs() < 1e-9, "{text}: {count} {span}");
    }
    assert_eq!(Uneven::default().count_and_span(usize::MAX).0, usize::MAX, "any number costs nothing");
}
