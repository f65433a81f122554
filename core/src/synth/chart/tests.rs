//! A chart matches its parameters and its truth.

use super::*;

fn small() -> ChartParams {
    ChartParams { width: 240, height: 180, discs: 9, radius: 3.6..=12.0, frames: 5, ..ChartParams::default() }
}

#[test]
fn the_same_seed_gives_the_same_bits_for_any_number_of_threads() {
    let make = |threads: usize, seed: u64| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| synth_chart(&ChartParams { seed, ..small() }, &Monitor::default()).expect("a chart"))
    };
    let (one, truth_one) = make(1, 3);
    let (four, truth_four) = make(4, 3);
    let (other, truth_other) = make(4, 4);
    assert_eq!(one.frames, four.frames);
    assert_eq!(truth_one, truth_four);
    assert_ne!(one.frames, other.frames);
    assert_ne!(truth_one.features, truth_other.features);
}

#[test]
fn each_disc_is_where_the_truth_says_in_every_frame() {
    let params = ChartParams { snr: f64::INFINITY, motion: Motion::TwoD, ..small() };
    let (burst, truth) = synth_chart(&params, &Monitor::default()).expect("a chart");
    let background = params.exposure().expect("valid").background + truth.black_level;
    let mut measured = 0;
    for (t, frame) in burst.frames.iter().enumerate() {
        let dt = t as f64 - truth.t0;
        for disc in &truth.features {
            let (u, v) = disc.position(dt);
            let alone = truth.features.iter().filter(|d| d.id != disc.id).all(|d| {
                let (x, y) = d.position(dt);
                (x - u).hypot(y - v) > d.radius + disc.radius + 4.0
            });
            if !alone {
                continue;
            }
            let reach = disc.radius + 2.0;
            let (mut mass, mut mu, mut mv) = (0.0, 0.0, 0.0);
            for y in (v - reach).ceil() as usize..=(v + reach) as usize {
                for x in (u - reach).ceil() as usize..=(u + reach) as usize {
                    let w = f64::from(frame.at(x, y)) - background;
                    mass += w;
                    mu += w * x as f64;
                    mv += w * y as f64;
                }
            }
            assert!((mu / mass - u).abs() < 0.01, "frame {t}, disc {}: u {} for {u}", disc.id, mu / mass);
            assert!((mv / mass - v).abs() < 0.01, "frame {t}, disc {}: v {} for {v}", disc.id, mv / mass);
            let area = mass / (params.exposure().expect("valid").disc - background + truth.black_level);
            let true_area = std::f64::consts::PI * disc.radius * disc.radius;
            assert!((area / true_area - 1.0).abs() < 2e-3, "area {area} for {true_area}");
            measured += 1;
        }
    }
    assert!(measured > 30, "only {measured} discs stood alone");
}

#[test]
fn the_measured_snr_is_the_one_asked_for() {
    for snr in [0.2, 0.6, 3.0] {
        let params = ChartParams { discs: 1, radius: 40.0..=40.0, max_slope: 0.0, frames: 20, snr, ..small() };
        let (burst, truth) = synth_chart(&params, &Monitor::default()).expect("a chart");
        let disc = truth.features[0];
        let (mut inside, mut outside) = (Vec::new(), Vec::new());
        for frame in &burst.frames {
            for y in 0..params.height {
                for x in 0..params.width {
                    let r = (x as f64 - disc.u).hypot(y as f64 - disc.v);
                    if r < disc.radius - 1.0 {
                        inside.push(f64::from(frame.at(x, y)));
                    } else if r > disc.radius + 1.0 {
                        outside.push(f64::from(frame.at(x, y)));
                    }
                }
            }
        }
        let mean = |x: &[f64]| x.iter().sum::<f64>() / x.len() as f64;
        let variance = |x: &[f64]| {
            let m = mean(x);
            x.iter().map(|y| (y - m).powi(2)).sum::<f64>() / x.len() as f64
        };
        // The variance is linear in the level, so the mean of the two variances is that at the mean of the levels.
        let sigma = (0.5 * (variance(&inside) + variance(&outside))).sqrt();
        let got = (mean(&inside) - mean(&outside)) / sigma;
        // Standard error of the difference of the two means, in units of sigma, is about sqrt(1/n_inside).
        let error = 5.0 / (inside.len() as f64).sqrt() + 0.01 * snr;
        assert!((got - snr).abs() < error, "asked {snr}, measured {got}");
        assert!(burst.frames.iter().all(|f| f.data().iter().all(|&x| x > 0.0 && x < 1.0)), "noise was cut off");
    }
}

#[test]
fn discs_keep_their_distance_and_stay_inside() {
    let params = ChartParams { motion: Motion::TwoD, frames: 10, ..ChartParams::default() };
    let discs = place_discs(&params, &Monitor::default()).expect("they fit");
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
}

#[test]
fn the_law_of_the_radii_changes_radii_alone_and_the_default_is_uniform() {
    let discs = |radius_law: RadiusLaw| {
        let params = ChartParams { radius_law, ..ChartParams::default() };
        place_discs(&params, &Monitor::default()).expect("they fit")
    };
    let (uniform, log) = (discs(ChartParams::default().radius_law), discs(RadiusLaw::Log));
    // Published tables use these charts, so their numbers must never change.
    let first = uniform[0];
    assert_eq!([first.radius, first.u, first.v, first.slope_u], FIRST_DISC_OF_SEED_1);
    let fine = |discs: &[FeatureTruth]| discs.iter().filter(|d| d.radius < 7.2).count();
    assert!(fine(&log) > fine(&uniform) + 10, "{} and {}", fine(&log), fine(&uniform));
    assert!(log.iter().all(|d| (3.6..=19.0).contains(&d.radius)));
}
const FIRST_DISC_OF_SEED_1: [f64; 4] =
    [18.941_430_711_460_43, 124.522_301_286_314_56, 42.249_995_958_163_68, 2.564_286_188_923_249_6];

#[test]
fn nonsense_is_named_with_its_remedy() {
    let cases = [
        (ChartParams { discs: 5000, ..small() }, "discs"),
        (ChartParams { radius: 5.0..=3.0, ..small() }, "radius"),
        (ChartParams { contrast: 1.0, ..small() }, "contrast"),
        (ChartParams { snr: -1.0, ..small() }, "snr"),
        (ChartParams { bits: 2, ..small() }, "bits"),
        (ChartParams { frames: 0, ..small() }, "frames"),
        (ChartParams { width: 3, ..small() }, "width"),
        (ChartParams { max_slope: 1000.0, ..small() }, "max-slope"),
        (ChartParams { max_slope: f64::NAN, ..small() }, "max-slope"),
        (ChartParams { width: 32768, height: 32768, frames: 4096, ..small() }, "frames"),
        (ChartParams { read_noise: -1.0, ..small() }, "read-noise"),
        (ChartParams { gap: f64::NAN, ..small() }, "gap"),
    ];
    for (params, name) in cases {
        let error = synth_chart(&params, &Monitor::default()).expect_err(name).to_string();
        assert!(error.starts_with(&format!("{name}: ")), "{error}");
    }
    let monitor = Monitor::default();
    monitor.cancel();
    assert!(matches!(synth_chart(&small(), &monitor), Err(SynthError::Cancelled(_))));
}
