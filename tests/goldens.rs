//! Agreement with the published implementations: VLFeat's SIFT, LiFF, and the authors' own BuFF code.
//!
//! Each test sets our parameters to theirs, converts coordinates as the method page says, and counts. Two features agree when they are within
//! 0.1 px, 2 % in scale and 0.03 rad, at the same slope. What is left over is explained where the bars are.

#[path = "common/shared.rs"]
mod shared;

use burstscope::detector::describe::to_vlfeat_order;
use burstscope::detector::motion::motion_stack;
use burstscope::detector::scale_space::SIGMA_BASE;
use burstscope::detector::{Descriptor, Detection, Interpolation, Localisation, Method, NoiseGate, Slope};
use burstscope::plane::blur::{GaussianKernel, gaussian_blur};
use burstscope::{Burst, DetectorParams, Monitor, Plane, SlopeGrid, detect};
use ndarray::{Array2, Array3, Array4, s};
use shared::shared;
use std::io::Read;
use std::path::PathBuf;

/// A feature of theirs or ours, in our units.
#[derive(Debug, Clone, Copy)]
struct Frame {
    u: f32,
    v: f32,
    sigma: f32,
    orientation: f32,
    slope_index: usize,
}

fn angle_between(a: f32, b: f32) -> f32 {
    let d = (a - b).rem_euclid(std::f32::consts::TAU);
    d.min(std::f32::consts::TAU - d)
}

fn agree(a: &Frame, b: &Frame) -> bool {
    a.slope_index == b.slope_index
        && (a.u - b.u).hypot(a.v - b.v) <= 0.1
        && (a.sigma / b.sigma - 1.0).abs() <= 0.02
        && angle_between(a.orientation, b.orientation) <= 0.03
}

fn frames_of(detection: &Detection) -> Vec<Frame> {
    let frame = |f: &burstscope::Feature| Frame {
        u: f.u,
        v: f.v,
        sigma: f.sigma,
        orientation: f.orientation,
        slope_index: f.slope_index,
    };
    detection.features.iter().map(frame).collect()
}

/// Counts of an agreement.
struct Agreement {
    missed: Vec<Frame>,
    extra: Vec<Frame>,
    /// Pairs (theirs, ours) of agreeing features.
    pairs: Vec<(usize, usize)>,
    total_theirs: usize,
    total_ours: usize,
}

impl Agreement {
    fn of(theirs: &[Frame], ours: &[Frame]) -> Self {
        let mut pairs = Vec::new();
        let mut missed = Vec::new();
        for (i, t) in theirs.iter().enumerate() {
            match ours.iter().position(|o| agree(t, o)) {
                Some(j) => pairs.push((i, j)),
                None => missed.push(*t),
            }
        }
        let extra = ours.iter().filter(|o| !theirs.iter().any(|t| agree(t, o))).copied().collect();
        Self { missed, extra, pairs, total_theirs: theirs.len(), total_ours: ours.len() }
    }

    fn missed_percent(&self) -> f32 {
        100.0 * self.missed.len() as f32 / self.total_theirs as f32
    }

    fn extra_percent(&self) -> f32 {
        100.0 * self.extra.len() as f32 / self.total_ours as f32
    }

    fn check(&self, name: &str, most_missed_percent: f32, most_extra_percent: f32) {
        println!(
            "{name}: theirs {}, ours {}, missed {:.2} %, extra {:.2} %",
            self.total_theirs,
            self.total_ours,
            self.missed_percent(),
            self.extra_percent()
        );
        assert!(self.missed_percent() <= most_missed_percent, "{name}: missed {:.2} %", self.missed_percent());
        assert!(self.extra_percent() <= most_extra_percent, "{name}: extra {:.2} %", self.extra_percent());
    }

    /// Mean absolute difference of the bytes of agreeing features.
    fn descriptor_difference(&self, theirs: &[[f32; 128]], ours: &[Descriptor]) -> f64 {
        let total: f64 = self
            .pairs
            .iter()
            .map(|&(i, j)| {
                let ours = to_vlfeat_order(&ours[j]);
                theirs[i].iter().zip(ours).map(|(a, b)| f64::from((a - f32::from(b)).abs())).sum::<f64>()
            })
            .sum();
        total / (128.0 * self.pairs.len() as f64)
    }
}

fn open(paths: &[PathBuf]) -> Burst {
    Burst::open_with(paths, &Default::default(), &Monitor::default()).expect("the published input opens")
}

/// The 1D demo in the order in which its motion is uniform.
fn demo_1d() -> Option<Burst> {
    let folder = shared("data/buff-demo-1d")?;
    Some(open(&["5.png", "1.png", "2.png", "4.png", "3.png"].map(|name| folder.join(name))))
}

fn numbers(line: &str, separator: impl Fn(char) -> bool) -> Vec<f32> {
    line.split(separator).filter(|s| !s.is_empty()).map(|s| s.parse().expect("a number")).collect()
}

/// VLFeat writes L2-normalised bytes; ours are L1-root: √(d/Σd)·512.
fn to_l1_root(l2: &[f32]) -> [f32; 128] {
    let sum: f32 = l2.iter().sum();
    std::array::from_fn(|i| if sum > 0.0 { ((l2[i] / sum).sqrt() * 512.0).min(255.0) } else { 0.0 })
}

fn check_vlfeat(name: &str, image: &str, first_octave: i32, peak_of_255: f32, missed: f32, extra: f32) {
    let (Some(image), Some(golden)) = (shared(image), shared("goldens/vlsift")) else { return };
    let burst = open(&[image]);
    let params = DetectorParams {
        method: Method::Sift,
        first_octave,
        peak_threshold: peak_of_255 / 255.0,
        noise_gate: NoiseGate::Factor(0.0),
        localisation: Localisation::Quadratic,
        max_orientations: 4,
        octaves: 16,
        levels: 3,
        ..DetectorParams::default()
    };
    let ours = detect(&burst, &params, &Monitor::default()).expect("valid parameters");
    let text = std::fs::read_to_string(golden.join(format!("{name}.frame"))).expect("the frames are there");
    let theirs: Vec<Frame> = text
        .lines()
        .map(|line| {
            let x = numbers(line, char::is_whitespace);
            Frame { u: x[0], v: x[1], sigma: x[2], orientation: x[3], slope_index: 0 }
        })
        .collect();
    let agreement = Agreement::of(&theirs, &frames_of(&ours));
    agreement.check(name, missed, extra);

    let mut text = String::new();
    let file = std::fs::File::open(golden.join(format!("{name}.descr.gz"))).expect("the descriptors are there");
    flate2::read::GzDecoder::new(file).read_to_string(&mut text).expect("gzip");
    let theirs: Vec<[f32; 128]> = text.lines().map(|line| to_l1_root(&numbers(line, char::is_whitespace))).collect();
    let difference = agreement.descriptor_difference(&theirs, &ours.descriptors);
    println!("{name}: descriptors differ by {difference:.3} of 255 in the mean");
    assert!(difference <= 3.0, "{name}: {difference}");
}

// What these three miss are second orientations whose histogram peak lies at 0.8 of the highest within a rounding error, and large blobs whose
// orientation is ambiguous: the place and scale are found in every case looked at.
#[test]
fn vlfeat_from_octave_0() {
    check_vlfeat("frame3_fo0_pt5.1", "data/buff-demo-1d/3.png", 0, 5.1, 1.0, 1.0);
}

#[test]
fn vlfeat_from_octave_minus_1() {
    check_vlfeat("frame3_default", "data/buff-demo-1d/3.png", -1, 0.0, 2.0, 2.0);
    check_vlfeat("box_default", "goldens/vlsift/box.pgm", -1, 0.0, 2.0, 2.0);
}

fn check_liff(first_octave: i32, missed: f32, extra: f32, missed_inside: &[(f32, f32)]) {
    let (Some(burst), Some(golden)) = (demo_1d(), shared(&format!("goldens/liff1d/first_octave_{first_octave}")))
    else {
        return;
    };
    let params = DetectorParams {
        slopes: SlopeGrid::line(-4.0..=4.0, 9),
        first_octave,
        peak_threshold: 0.02,
        noise_gate: NoiseGate::Factor(0.0),
        interpolation: Interpolation::Nearest,
        localisation: Localisation::Quadratic,
        max_orientations: 4,
        octaves: 16,
        levels: 3,
        ..DetectorParams::default()
    };
    let ours = detect(&burst, &params, &Monitor::default()).expect("valid parameters");
    let text = std::fs::read_to_string(golden.join("features.csv")).expect("the features are there");
    let theirs: Vec<Frame> = text
        .lines()
        .skip(1)
        .map(|line| {
            let x = numbers(line, |c| c == ',');
            Frame { u: x[0] - 1.0, v: x[1] - 1.0, sigma: x[2], orientation: x[3], slope_index: x[4] as usize - 1 }
        })
        .collect();
    let agreement = Agreement::of(&theirs, &frames_of(&ours));
    agreement.check(&format!("LiFF first octave {first_octave}"), missed, extra);
    // LiFF's rounding takes column −1 for column 0 (see `liff_motion_stack`), so near the left border its stack is another one; blurs carry that as far as
    // some 16 px. What it misses elsewhere are second orientations at 0.8 of the highest within a rounding error.
    for (border, bar) in missed_inside {
        let inside = |f: &&Frame| f.u >= *border && f.v >= *border && f.u <= 799.0 - border && f.v <= 639.0 - border;
        let all = theirs.iter().filter(inside).count() as f32;
        let missed = 100.0 * agreement.missed.iter().filter(inside).count() as f32 / all;
        println!("LiFF first octave {first_octave}, away from a {border} px border: missed {missed:.2} %");
        assert!(missed <= *bar, "{missed}");
    }
    let file = std::fs::File::open(golden.join("descriptors.npz")).expect("the descriptors are there");
    let bytes: Array2<u8> = ndarray_npy::NpzReader::new(file).expect("npz").by_name("u8_l1root").expect("u8");
    let theirs: Vec<[f32; 128]> = bytes.rows().into_iter().map(|r| std::array::from_fn(|i| f32::from(r[i]))).collect();
    let difference = agreement.descriptor_difference(&theirs, &ours.descriptors);
    println!("LiFF first octave {first_octave}: descriptors differ by {difference:.3} of 255 in the mean");
    assert!(difference <= 3.0, "{difference}");
}

#[test]
fn liff_from_octave_0() {
    check_liff(0, 3.0, 3.0, &[(8.0, 1.3), (16.0, 1.0)]);
}

#[test]
fn liff_from_octave_minus_1() {
    check_liff(-1, 4.0, 4.0, &[(8.0, 1.0)]);
}

#[test]
fn liff_motion_stack() {
    let (Some(burst), Some(golden)) = (demo_1d(), shared("goldens/liff1d/focal_stack_rows_300_363.npz")) else {
        return;
    };
    let frames: Vec<&Plane> = burst.frames.iter().map(|f| &**f).collect();
    let file = std::fs::File::open(golden).expect("readable");
    let stack: Array3<f32> = ndarray_npy::NpzReader::new(file).expect("npz").by_name("stack").expect("f32");
    for (index, slope) in SlopeGrid::line(-4.0..=4.0, 9).slopes().enumerate() {
        let ours = motion_stack(&frames, slope, Interpolation::Nearest, &Monitor::default()).expect("not cancelled");
        for v in 0..64 {
            for u in 0..800 {
                // Where a frame would be read at column −1, LiFF reads column 0 and counts it; otherwise it too averages the frames that are there.
                let reads_before = |t: usize| u as f32 + (t as f32 - 2.0) * slope.u == -1.0;
                let covers = |t: usize| (0.0..=799.0).contains(&(u as f32 + (t as f32 - 2.0) * slope.u));
                let count = (0..5).filter(|&t| covers(t)).count() as f32;
                let before: Vec<f32> = (0..5).filter(|&t| reads_before(t)).map(|t| frames[t].at(0, 300 + v)).collect();
                let expected =
                    (ours.at(u, 300 + v) * count + before.iter().sum::<f32>()) / (count + before.len() as f32);
                assert!((expected - stack[[index, v, u]]).abs() <= 1e-6, "slope {slope:?} at ({u}, {v})");
            }
        }
    }
}

/// The authors' input: contrast stretched between the bounds, then every pixel doubled.
fn stretched_and_doubled(frame: &Plane, low: f32, high: f32) -> Plane {
    Plane::from_fn(frame.width() * 2, frame.height() * 2, |u, v| {
        ((frame.at(u / 2, v / 2) - low) / (high - low)).clamp(0.0, 1.0)
    })
}

/// The part of the transposed demo that the authors' code was run on.
fn transposed_crop() -> Option<Burst> {
    let demo = demo_1d()?;
    let crop = |f: &Plane| Plane::from_fn(256, 320, |u, v| f.at(300 + v, 200 + u));
    let mut burst = Burst::from_planes("crop", demo.frames.iter().map(|f| crop(f)).collect());
    burst.quantisation_step = demo.quantisation_step;
    Some(burst)
}

/// The authors' octave 2, level 1 and the next one, from a doubled motion-stack image: a chain of blurs whose kernels end at 2σ, then every second
/// pixel from the second on.
fn authors_levels(stack: &Plane, levels: usize) -> Vec<Plane> {
    let blur = |plane: &Plane, sigma: f64| {
        gaussian_blur(plane, &GaussianKernel::with_cut(sigma, 2.0), &Monitor::default()).expect("not cancelled")
    };
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

#[test]
fn authors_1d_stages() {
    let (Some(burst), Some(golden)) = (transposed_crop(), shared("goldens/buff1d/stages.npz")) else { return };
    let (low, high) = (7.629_394_5e-6, 0.999_977_1);
    let doubled: Vec<Plane> = burst.frames.iter().map(|f| stretched_and_doubled(f, low, high)).collect();
    let doubled: Vec<&Plane> = doubled.iter().collect();
    let mut file = ndarray_npy::NpzReader::new(std::fs::File::open(golden).expect("readable")).expect("npz");
    let stacks: Array3<f32> = file.by_name("motion_stack").expect("f32");
    let gauss: Array3<f32> = file.by_name("gauss_octave2_level1").expect("f32");
    let dog: Array3<f32> = file.by_name("dog_octave2_level2").expect("f32");
    for index in 0..5 {
        // Their slope −3.2 … 3.2 along rows is −2 … 2 of our pixels per frame, twice that on the doubled image.
        let slope = Slope::new(0.0, 2.0 * (index as f32 - 2.0));
        let ours = motion_stack(&doubled, slope, Interpolation::Nearest, &Monitor::default()).expect("not cancelled");
        // Where a frame does not reach, theirs leaves it out but still divides by N.
        let inner = 16..640 - 16;
        let values = stacks.slice(s![index, .., ..]);
        let inside = values.indexed_iter().filter(|((v, _), _)| inner.contains(v)).map(|((v, u), x)| (u, v, x));
        assert_close("motion stack", &ours, inside, 1e-5);
        // The later stages start from their own stack, so that its border does not matter.
        let theirs = Plane::from_fn(512, 640, |u, v| stacks[[index, v, u]]);
        let levels = authors_levels(&theirs, 3);
        let values = gauss.slice(s![index, .., ..]);
        assert_close("Gaussian", &levels[0], values.indexed_iter().map(|((v, u), x)| (u, v, x)), 1e-5);
        let difference = Plane::from_fn(256, 320, |u, v| levels[2].at(u, v) - levels[1].at(u, v));
        let values = dog.slice(s![index, .., ..]);
        assert_close("DoG", &difference, values.indexed_iter().map(|((v, u), x)| (u, v, x)), 1e-5);
    }
}

#[test]
fn authors_2d_stages() {
    let (Some(folder), Some(golden)) = (shared("data/buff-demo-2d"), shared("goldens/buff2d/stages.npz")) else {
        return;
    };
    let burst = open(&[folder]);
    let (low, high) = (0.101_961_53, 0.199_997_76);
    let doubled: Vec<Plane> = burst.frames.iter().map(|f| stretched_and_doubled(f, low, high)).collect();
    let doubled: Vec<&Plane> = doubled.iter().collect();
    let mut file = ndarray_npy::NpzReader::new(std::fs::File::open(golden).expect("readable")).expect("npz");
    let stacks: Array4<f32> = file.by_name("motion_stack").expect("f32");
    let gauss: Array4<f32> = file.by_name("gauss_octave2_level1").expect("f32");
    let dog: Array4<f32> = file.by_name("dog_octave2_level2").expect("f32");
    for i in 0..3 {
        for j in 0..3 {
            // Slopes ±1 of theirs are ±0.625 px per frame, twice that on the doubled image, sampled linearly.
            let slope = Slope::new(1.25 * (i as f32 - 1.0), 1.25 * (j as f32 - 1.0));
            let ours =
                motion_stack(&doubled, slope, Interpolation::Linear, &Monitor::default()).expect("not cancelled");
            let values = stacks.slice(s![i, j, .., ..]);
            let inside = values
                .indexed_iter()
                .filter(|((v, u), _)| (8..392).contains(v) && (8..392).contains(u))
                .map(|((v, u), x)| (u, v, x));
            assert_close("motion stack", &ours, inside, 1e-5);
            let theirs = Plane::from_fn(400, 400, |u, v| stacks[[i, j, v, u]]);
            let levels = authors_levels(&theirs, 3);
            let values = gauss.slice(s![i, j, .., ..]);
            assert_close("Gaussian", &levels[0], values.indexed_iter().map(|((v, u), x)| (u, v, x)), 1e-5);
            let difference = Plane::from_fn(200, 200, |u, v| levels[2].at(u, v) - levels[1].at(u, v));
            let values = dog.slice(s![i, j, .., ..]);
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
        let text = std::fs::read_to_string(path).expect("readable");
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

/// How many of the authors' features have ours within 0.5 px, 10 % in scale and half a slope step, with their three levels: with the default kernels and with kernels that
/// end at 2σ, as theirs do. Prints each that has none by default, with its cause.
fn authors_found(theirs: &[Authors], burst: &Burst, slopes: SlopeGrid, step_px_per_frame: f32) -> (usize, usize) {
    let with = |kernel_cut: f32| {
        let params = DetectorParams { slopes, kernel_cut, levels: 3, ..DetectorParams::default() };
        detect(burst, &params, &Monitor::default()).expect("valid parameters")
    };
    let (ours, cut) = (with(4.0), with(2.0));
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

// The authors' kernels end at 2σ, which bends the DoG: on their own stack and sampling, 47 of the 231 features have no extremum within two samples and a
// level once the kernels reach 4σ, and the scales of the others shift by 3 % in the median and up to 20 %. So no detector with whole kernels can have nine
// tenths of them; with `kernel_cut = 2` most of the difference goes away.
#[test]
fn authors_1d_features() {
    let (Some(burst), Some(golden)) = (transposed_crop(), shared("goldens/buff1d/features.csv")) else { return };
    let theirs = Authors::read(golden, |x| Slope::new(0.0, 0.625 * x[5]));
    let (by_default, by_cut) = authors_found(&theirs, &burst, SlopeGrid::line_along(90.0, -2.0..=2.0, 5), 1.0);
    assert!(by_default * 100 >= theirs.len() * 48, "{by_default} of {}", theirs.len());
    assert!(by_cut * 100 >= theirs.len() * 73, "{by_cut} of {}", theirs.len());
}

#[test]
fn authors_2d_features() {
    let (Some(folder), Some(golden)) = (shared("data/buff-demo-2d"), shared("goldens/buff2d/features.csv")) else {
        return;
    };
    let theirs = Authors::read(golden, |x| Slope::new(0.625 * x[6], 0.625 * x[7]));
    let slopes = SlopeGrid::plane(-0.625..=0.625, 3, -0.625..=0.625, 3);
    let (by_default, _) = authors_found(&theirs, &open(&[folder]), slopes, 0.625);
    assert!(by_default * 100 >= theirs.len() * 90, "{by_default} of {}", theirs.len());
}

// Where no pixel is black, and wherever a band of brightness is taken, second differences of this camera's frames and of their differences show a noise of
// 2.3 to 3.1 grey values; the median over the image is 2.7. Half of each frame is black, which must not count.
#[test]
fn noise_of_a_real_dim_camera() {
    let Some(folder) = shared("data/slider-far") else { return };
    let burst = open(&[folder]);
    let noise = burstscope::detector::noise::frame_noise(&burst, 20..29, &Monitor::default()).expect("not cancelled");
    println!("slider-far: noise of a frame {:.2} grey values", 255.0 * noise);
    assert!((255.0 * noise / 2.7 - 1.0).abs() < 0.15, "{}", 255.0 * noise);
}
