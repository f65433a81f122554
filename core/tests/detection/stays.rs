//! Features that stay: a burst whose pixels are moved to other samples of the coarse octaves keeps its features.
//!
//! Cropping by a pixel moves every sample of the octaves after the first to other places on the scene; so do mirroring
//! and, for what is found at several slopes, turning time round. Transposing and a gain only change the order of sums.
//! Each law counts, octave by octave, the features that have a partner where it predicts one.

use crate::prelude::*;

/// Frames of textured layers in a little light, whose last pixels along both sides are no whole ones of coarse octaves.
fn scene(seed: u64) -> Burst {
    let (width, height) = (400, 300);
    let params = SceneParams { width, height, frames: 8, layers: 3, max_slope: 1.5, ..SceneParams::default() };
    let params = SceneParams { motion: Motion::OneD, snr: 1.5, seed, ..params };
    synth_scene(&params, &quiet()).expect("valid parameters").0
}

/// Parameters with the white noise model: the other one depends on the squares that it measures, and these do not move
/// with the scene.
fn params() -> DetectorParams {
    DetectorParams {
        slopes: SlopeGrid::line(-1.5..=1.5, 5),
        noise_model: NoiseModelKind::White,
        max_orientations: 1,
        ..DetectorParams::default()
    }
}

/// Whether `found` is the same feature as `expected`: within half its σ and a fifth of its scale, with the same sign,
/// and with a slope within half a step of the grid or half its σ in the outermost frames.
fn is_partner(found: &Feature, expected: &Feature) -> bool {
    (found.u - expected.u).hypot(found.v - expected.v) <= 0.5 * expected.sigma
        && (found.sigma / expected.sigma).ln().abs() < 0.2
        && (found.slope.u - expected.slope.u).hypot(found.slope.v - expected.slope.v)
            < (0.5 * expected.sigma / 3.5).max(0.375)
        && found.response * expected.response > 0.0
}

/// Features by octave, and how many of them `changed` frames and slopes keep; `moved` is what the change does to a
/// feature. The last entry counts all octaves.
fn kept(
    changed: impl Fn(&Plane) -> Plane,
    (slopes, reversed): (SlopeGrid, bool),
    moved: impl Fn(&Feature) -> Feature,
) -> Vec<(usize, usize)> {
    let mut counts = vec![(0, 0); 7];
    for seed in 1..=3 {
        let burst = scene(seed);
        let mut frames: Vec<Arc<Plane>> = burst.frames.iter().map(|frame| Arc::new(changed(frame))).collect();
        if reversed {
            frames.reverse();
        }
        let after = Burst { frames, ..burst.clone() };
        let find = |burst: &Burst, slopes| {
            detect(burst, &DetectorParams { slopes, ..params() }, &quiet()).expect("valid parameters")
        };
        let (before, after) = (find(&burst, params().slopes), find(&after, slopes));
        for feature in &before.features {
            let expected = moved(feature);
            let is_kept = after.features.iter().any(|found| is_partner(found, &expected));
            for slot in [feature.octave as usize, 6] {
                counts[slot].0 += 1;
                counts[slot].1 += usize::from(is_kept);
            }
        }
    }
    counts
}

/// Asserts that of all features the share `all` is kept, and of those of each octave with at least 100 the share
/// `worst`.
fn assert_kept(law: &str, counts: &[(usize, usize)], all: f64, worst: f64) {
    let share = |(count, kept): (usize, usize)| kept as f64 / count.max(1) as f64;
    let shares: Vec<String> = counts.iter().map(|&both| format!("{:.3} of {}", share(both), both.0)).collect();
    println!("{law}: {}", shares.join(", "));
    assert!(counts[6].0 > 500 && share(counts[6]) >= all, "{law}: {shares:?}");
    let octaves = counts[..6].iter().enumerate().filter(|(_, both)| both.0 >= 100);
    octaves.for_each(|(octave, &both)| assert!(share(both) >= worst, "{law}, octave {octave}: {shares:?}"));
}

fn part(columns: usize, rows: usize, left: usize, top: usize) -> impl Fn(&Plane) -> Plane {
    move |frame| Plane::from_fn(columns, rows, |u, v| frame.at(u + left, v + top))
}

#[test]
fn a_cropped_mirrored_transposed_reversed_or_brighter_burst_keeps_its_features() {
    let slopes = params().slopes;
    for (left, top) in [(1, 1), (1, 0), (3, 2)] {
        let moved = |f: &Feature| Feature { u: f.u - left as f32, v: f.v - top as f32, ..*f };
        let counts = kept(part(400 - left, 300 - top, left, top), (slopes, false), moved);
        assert_kept(&format!("crop by {left}, {top}"), &counts, 0.93, 0.87);
    }
    let mirrored = |frame: &Plane| Plane::from_fn(400, 300, |u, v| frame.at(399 - u, v));
    let moved = |f: &Feature| Feature { u: 399.0 - f.u, slope: Slope::new(-f.slope.u, f.slope.v), ..*f };
    assert_kept("mirror", &kept(mirrored, (params().slopes, false), moved), 0.95, 0.88);
    let transposed = |frame: &Plane| Plane::from_fn(300, 400, |u, v| frame.at(v, u));
    let moved = |f: &Feature| Feature { u: f.v, v: f.u, slope: Slope::new(f.slope.v, f.slope.u), ..*f };
    let slopes = SlopeGrid::plane(0.0..=0.0, 1, -1.5..=1.5, 5);
    assert_kept("transpose", &kept(transposed, (slopes, false), moved), 0.99, 0.97);
    let moved = |f: &Feature| Feature { slope: Slope::new(-f.slope.u, -f.slope.v), ..*f };
    assert_kept("time reversed", &kept(Plane::clone, (params().slopes, true), moved), 0.99, 0.98);
    let brighter = |frame: &Plane| Plane::from_fn(400, 300, |u, v| 1.7 * frame.at(u, v));
    assert_kept("gain", &kept(brighter, (params().slopes, false), |f| *f), 0.99, 0.98);
}

/// Blobs of all sizes that two octaves share, at places that fall differently on their samples: none is lost between
/// the octaves, and each has its place and size.
#[test]
fn no_blob_is_lost_between_octaves() {
    let count = 60;
    let blob = |i: usize| {
        let sigma = 2.6 * 2f64.powf(i as f64 / 25.0);
        let (x, y) = (60 + 100 * (i % 10), 60 + 100 * (i / 10));
        (x as f64 + 0.37 * (i % 8) as f64, y as f64 + 0.23 * (i % 7) as f64, sigma)
    };
    let frame = Plane::from_fn(1040, 640, |u, v| {
        let heights = (0..count).map(blob).map(|(x, y, sigma)| {
            let r2 = (u as f64 - x).powi(2) + (v as f64 - y).powi(2);
            0.2 * (-r2 / (2.0 * sigma * sigma)).exp()
        });
        (0.3 + heights.sum::<f64>()) as f32
    });
    let frame = Arc::new(frame);
    let burst = Burst { frames: (0..3).map(|_| frame.clone()).collect(), ..scene(1) };
    let params = DetectorParams { slopes: SlopeGrid::line(0.0..=0.0, 1), ..params() };
    let found = detect(&burst, &params, &quiet()).expect("valid parameters").features;
    // The scale of D's maximum on a Gaussian blob: the geometric mean of the two Gaussians' σ is the blob's.
    let k = 2f64.powf(1.0 / params.levels as f64);
    for i in 0..count {
        let (x, y, sigma) = blob(i);
        let away = |f: &Feature| (f64::from(f.u) - x).hypot(f64::from(f.v) - y);
        let nearest = found.iter().min_by(|a, b| away(a).total_cmp(&away(b))).expect("features");
        let size = f64::from(nearest.sigma) * k.sqrt() / sigma;
        let is_right = away(nearest) < 0.05 * sigma && (size - 1.0).abs() < 0.04;
        assert!(is_right, "blob of σ {sigma:.2} at {x:.2}, {y:.2}: {nearest:?}, {size}");
    }
}
