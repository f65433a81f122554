//! Comparison with the authors' own BuFF code, in one and two dimensions: the stages bit by bit, and the features, with
//! the cause of each difference.

use super::published::{as_published, demo_1d, numbers, open};
use crate::prelude::*;
use burstscope_core::detector::{scale_space::SIGMA_BASE, stack::motion_stack};
use burstscope_core::plane::blur::{GaussianKernel, gaussian_blur};
use ndarray::{Array3, Array4, Axis};

/// Input of the authors' code: contrast stretched between the bounds, then every pixel doubled.
fn stretched_and_doubled(frame: &Plane, low: f32, high: f32) -> Plane {
    Plane::from_fn(frame.width() * 2, frame.height() * 2, |u, v| {
        ((frame.at(u / 2, v / 2) - low) / (high - low)).clamp(0.0, 1.0)
    })
}

/// The part of the transposed demo that the authors' code was run on.
fn transposed_crop() -> Burst {
    let demo = demo_1d();
    let crop = |f: &Plane| Plane::from_fn(256, 320, |u, v| f.at(300 + v, 200 + u));
    let mut burst = Burst::from_planes("crop", demo.frames.iter().map(|f| crop(f)).collect());
    burst.quantisation_step = demo.quantisation_step;
    burst
}

/// The authors' octave 2, level 1 and the next one, from a doubled motion-stack image: a chain of blurs whose kernels
/// end at 2σ, then every second pixel from the second on.
fn authors_levels(stack: &Plane, levels: usize) -> Vec<Plane> {
    let blur = |plane: &Plane, sigma: f64| gaussian_blur(plane, &GaussianKernel::with_cut(sigma, 2.0));
    let step = 2f64.powf(1.0 / 3.0);
    let sigma = |i: i32| SIGMA_BASE * step.powi(i - 1) * (step * step - 1.0).sqrt();
    let mut plane = blur(stack, (SIGMA_BASE * SIGMA_BASE - 1.0).sqrt());
    for i in 1..4 {
        plane = blur(&plane, sigma(i));
    }
    let half = Plane::from_fn(plane.width() / 2, plane.height() / 2, |u, v| plane.at(2 * u + 1, 2 * v + 1));
    let mut out = vec![half];
    for i in 1..levels {
        let next = blur(&out[i - 1], sigma(i as i32));
        out.push(next);
    }
    out
}

#[track_caller]
fn assert_close<'a>(name: &str, ours: &Plane, theirs: impl Iterator<Item = (usize, usize, &'a f32)>, bar: f32) {
    let worst = theirs.map(|(u, v, x)| (ours.at(u, v) - x).abs()).fold(0.0, f32::max);
    println!("{name}: largest difference {worst:.1e}");
    assert!(worst <= bar, "{name}: {worst}");
}

#[needs::shared("data/buff-demo-1d", "goldens/buff1d")]
#[test]
fn authors_1d_stages() {
    let (burst, golden) = (transposed_crop(), shared("goldens/buff1d/stages.npz"));
    let (low, high) = (7.629_394_5e-6, 0.999_977_1);
    let doubled: Vec<Plane> = burst.frames.iter().map(|f| stretched_and_doubled(f, low, high)).collect();
    let doubled: Vec<&Plane> = doubled.iter().collect();
    let mut file = ndarray_npy::NpzReader::new(fs::File::open(golden).expect("readable")).expect("npz");
    let stacks: Array3<f32> = file.by_name("motion_stack").expect("f32");
    let gauss: Array3<f32> = file.by_name("gauss_octave2_level1").expect("f32");
    let dog: Array3<f32> = file.by_name("dog_octave2_level2").expect("f32");
    for index in 0..5 {
        // Their slope −3.2 … 3.2 along rows is −2 … 2 of our pixels per frame, twice that on the doubled image.
        let slope = Slope::new(0.0, 2.0 * (index as f32 - 2.0));
        let ours = motion_stack(&doubled, &Positions::even(doubled.len()), slope, Interpolation::Nearest, &quiet())
            .expect("not cancelled");
        // Where a frame does not reach, theirs leaves it out but still divides by N.
        let inner = 16..640 - 16;
        let values = stacks.index_axis(Axis(0), index);
        let inside = values.indexed_iter().filter(|((v, _), _)| inner.contains(v)).map(|((v, u), x)| (u, v, x));
        assert_close("motion stack", &ours, inside, 1e-5);
        // The later stages start from their own stack, so that its border does not matter.
        let theirs = Plane::from_fn(512, 640, |u, v| stacks[[index, v, u]]);
        let levels = authors_levels(&theirs, 3);
        let values = gauss.index_axis(Axis(0), index);
        assert_close("Gaussian", &levels[0], values.indexed_iter().map(|((v, u), x)| (u, v, x)), 1e-5);
        let difference = Plane::from_fn(256, 320, |u, v| levels[2].at(u, v) - levels[1].at(u, v));
        let values = dog.index_axis(Axis(0), index);
        assert_close("DoG", &difference, values.indexed_iter().map(|((v, u), x)| (u, v, x)), 1e-5);
    }
}

#[needs::shared("data/buff-demo-2d", "goldens/buff2d")]
#[test]
fn authors_2d_stages() {
    let (folder, golden) = (shared("data/buff-demo-2d"), shared("goldens/buff2d/stages.npz"));
    let burst = open(&[folder]);
    let (low, high) = (0.101_961_53, 0.199_997_76);
    let doubled: Vec<Plane> = burst.frames.iter().map(|f| stretched_and_doubled(f, low, high)).collect();
    let doubled: Vec<&Plane> = doubled.iter().collect();
    let mut file = ndarray_npy::NpzReader::new(fs::File::open(golden).expect("readable")).expect("npz");
    let stacks: Array4<f32> = file.by_name("motion_stack").expect("f32");
    let gauss: Array4<f32> = file.by_name("gauss_octave2_level1").expect("f32");
    let dog: Array4<f32> = file.by_name("dog_octave2_level2").expect("f32");
    for i in 0..3 {
        for j in 0..3 {
            // Slopes ±1 of theirs are ±0.625 px per frame, twice that on the doubled image, sampled linearly.
            let slope = Slope::new(1.25 * (i as f32 - 1.0), 1.25 * (j as f32 - 1.0));
            let ours = motion_stack(&doubled, &Positions::even(doubled.len()), slope, Interpolation::Linear, &quiet())
                .expect("not cancelled");
            let values = stacks.index_axis(Axis(0), i).index_axis_move(Axis(0), j);
            let inside = values
                .indexed_iter()
                .filter(|((v, u), _)| (8..392).contains(v) && (8..392).contains(u))
                .map(|((v, u), x)| (u, v, x));
            assert_close("motion stack", &ours, inside, 1e-5);
            let theirs = Plane::from_fn(400, 400, |u, v| stacks[[i, j, v, u]]);
            let levels = authors_levels(&theirs, 3);
            let values = gauss.index_axis(Axis(0), i).index_axis_move(Axis(0), j);
            assert_close("Gaussian", &levels[0], values.indexed_iter().map(|((v, u), x)| (u, v, x)), 1e-5);
            let difference = Plane::from_fn(200, 200, |u, v| levels[2].at(u, v) - levels[1].at(u, v));
            let values = dog.index_axis(Axis(0), i).index_axis_move(Axis(0), j);
            assert_close("DoG", &difference, values.indexed_iter().map(|((v, u), x)| (u, v, x)), 1e-5);
        }
    }
}

/// A feature of the authors' code in our units: their column `y` and row `x` are 1-based and 0.25 px too small.
struct Authors {
    u: f32,
    v: f32,
    sigma: f32,
    slope: Slope,
}

impl Authors {
    fn read(path: PathBuf, slope: impl Fn(&[f32]) -> Slope) -> Vec<Self> {
        let text = fs::read_to_string(path).expect("readable");
        let feature = |line: &str| {
            let x = numbers(line, |c| c == ',');
            Self { u: x[0] - 0.75, v: x[1] - 0.75, sigma: x[2], slope: slope(&x) }
        };
        text.lines().skip(1).map(feature).collect()
    }

    /// Whether one of `ours` is within `px` and `scale` (a fraction) and half a slope step.
    fn is_in(&self, ours: &Detection, px: f32, scale: f32, step_px_per_frame: f32) -> bool {
        ours.features.iter().any(|f| {
            (f.u - self.u).hypot(f.v - self.v) <= px
                && (f.sigma / self.sigma - 1.0).abs() <= scale
                && (f.slope.u - self.slope.u).abs() <= 0.5 * step_px_per_frame
                && (f.slope.v - self.slope.v).abs() <= 0.5 * step_px_per_frame
        })
    }
}

/// Number of the authors' features that have one of ours within 0.5 px, 10 % in scale and half a slope step, with their
/// three levels: by default, and with kernels that end at 2σ and the quadratic fit, as theirs do. Prints each that has
/// none by default, with its cause.
fn authors_found(theirs: &[Authors], burst: &Burst, slopes: SlopeGrid, step_px_per_frame: f32) -> (usize, usize) {
    let with = |rules: Rules| {
        let params = DetectorParams { slopes, rules, levels: 3, ..as_published() };
        detect(burst, &params, &quiet()).expect("valid parameters")
    };
    let (ours, cut) = (with(as_published().rules), with(Rules { kernel_cut: 2.0, ..Rules::VLFEAT }));
    let (mut by_default, mut by_cut) = (0, 0);
    for t in theirs {
        let agrees = t.is_in(&ours, 0.5, 0.1, step_px_per_frame);
        let agrees_cut = t.is_in(&cut, 0.5, 0.1, step_px_per_frame);
        by_default += usize::from(agrees);
        by_cut += usize::from(agrees_cut);
        if !agrees {
            let cause = if t.is_in(&ours, 1.5, 0.4, step_px_per_frame) {
                "ours is near; their kernel's cut at 2σ moved theirs"
            } else if agrees_cut {
                "there only with kernels cut at 2σ"
            } else if t.is_in(&cut, 1.5, 0.4, step_px_per_frame) {
                "near only with kernels cut at 2σ; their doubled sampling moved it"
            } else {
                "not an extremum of ours: their stretched contrast, dark borders and doubled sampling"
            };
            println!("  ({:6.2}, {:6.2}) σ {:5.2} slope ({}, {}): {cause}", t.u, t.v, t.sigma, t.slope.u, t.slope.v);
        }
    }
    println!("of {} features: {by_default} with three levels, {by_cut} with kernels cut at 2σ", theirs.len());
    (by_default, by_cut)
}

// The authors' kernels end at 2σ, which bends the DoG: on their own stack and sampling, 47 of the 231 features have no
// extremum within two samples and a level once the kernels reach 4σ, and the scales of the others shift by 3 % in the
// median and up to 20 %. So no detector with whole kernels can have nine tenths of them; with `kernel_cut = 2` most of
// the difference goes away.
#[needs::shared("data/buff-demo-1d", "goldens/buff1d")]
#[test]
fn authors_1d_features() {
    let (burst, golden) = (transposed_crop(), shared("goldens/buff1d/features.csv"));
    let theirs = Authors::read(golden, |x| Slope::new(0.0, 0.625 * x[5]));
    let (by_default, by_cut) = authors_found(&theirs, &burst, SlopeGrid::line_along(90.0, -2.0..=2.0, 5), 1.0);
    assert!(by_default * 100 >= theirs.len() * 48, "{by_default} of {}", theirs.len());
    assert!(by_cut * 100 >= theirs.len() * 82, "{by_cut} of {}", theirs.len());
}

#[needs::shared("data/buff-demo-2d", "goldens/buff2d")]
#[test]
fn authors_2d_features() {
    let (folder, golden) = (shared("data/buff-demo-2d"), shared("goldens/buff2d/features.csv"));
    let theirs = Authors::read(golden, |x| Slope::new(0.625 * x[6], 0.625 * x[7]));
    let slopes = SlopeGrid::plane(-0.625..=0.625, 3, -0.625..=0.625, 3);
    let (by_default, _) = authors_found(&theirs, &open(&[folder]), slopes, 0.625);
    assert!(by_default * 100 >= theirs.len() * 90, "{by_default} of {}", theirs.len());
}
