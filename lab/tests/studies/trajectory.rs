//! Trajectories: pictures, poses and truth agree.

use crate::prelude::*;
use burstscope_lab::synth::{paint::Area, paint::Sheet, trajectory::*};
use nalgebra::{Isometry3, Point3, Translation3, Vector3};

fn small() -> TrajectoryParams {
    TrajectoryParams { width: 160, height: 120, bursts: 3, frames: 5, max_slope: 2.0, ..TrajectoryParams::default() }
}

fn made(params: &TrajectoryParams) -> Trajectory {
    Trajectory::new(params, &quiet()).expect("a trajectory")
}

fn centroid(picture: &Plane) -> [f64; 2] {
    let (mut mass, mut mu, mut mv) = (0.0, 0.0, 0.0);
    for v in 0..picture.height() {
        for (u, &x) in picture.row(v).iter().enumerate() {
            let x = f64::from(x);
            mass += x;
            mu += x * u as f64;
            mv += x * v as f64;
        }
    }
    [mu / mass, mv / mass]
}

#[test]
fn a_known_point_is_where_the_picture_has_it() {
    let lens = Lens { width: 200, height: 150, focal_px: 180.0 };
    // A plane 4 m ahead, turned about each axis, with one spot: so small (σ = 1 px) that the image of its centre is
    // 0.02 px from the centre of gravity of its image, and without edges, whose pixels would shift it.
    let slant = world::turn(0.2, -0.2, 0.1);
    let pixel = 4.0 / lens.focal_px;
    let mut sheet = Sheet::new(220, 180, 2, 2);
    sheet.paint(Area::around(131.3, 62.6, 9.0), |x, y| {
        let square = (x - 131.3).powi(2) + (y - 62.6).powi(2);
        (1.0, (-0.5 * square).exp())
    });
    let (right, down) = (slant * Vector3::new(pixel, 0.0, 0.0), slant * Vector3::new(0.0, pixel, 0.0));
    let plane = ScenePlane::new("disc", Point3::new(-2.5, -2.0, 4.0), right, down, &sheet);
    let point = plane.point(131.3, 62.6);
    let camera = BurstCamera {
        world_from_camera: Isometry3::from_parts(Translation3::new(0.1, -0.2, 0.3), world::turn(-0.1, 0.05, 0.04)),
        step: Vector3::new(0.03, -0.01, 0.08),
        shake: world::Shake::default(),
    };
    assert_eq!(lens.direction(99.5, 74.5), Vector3::new(0.0, 0.0, 1.0));
    assert_eq!(lens.pixel(&Point3::new(0.0, 0.0, -1.0)), None);
    let mut places = Vec::new();
    for dt in [-4.5, -2.0, 0.0, 0.3, 4.5] {
        let picture = world::render(std::slice::from_ref(&plane), &lens, &camera.at(dt), &quiet());
        let [u, v] = centroid(&picture.expect("not cancelled"));
        let [expected_u, expected_v] = camera.pixel_of(&lens, &point, dt).expect("in front");
        assert!((u - expected_u).abs() < 0.025, "{dt}: {u} {v}, {expected_u} {expected_v}");
        assert!((v - expected_v).abs() < 0.025, "{dt}: {u} {v}, {expected_u} {expected_v}");
        places.push(u);
    }
    assert!((places[0] - places[4]).abs() > 5.0, "it moves: {places:?}");
}

#[test]
fn near_planes_hide_far_ones_in_whatever_order_they_are_given() {
    let lens = Lens { width: 60, height: 40, focal_px: 50.0 };
    let plane = |depth: f64, value: f32, area: Option<Area>| {
        let mut sheet = Sheet::new(100, 80, 2, 2);
        match area {
            Some(area) => sheet.rectangle(area, value),
            None => sheet.fill(|_, _| value),
        }
        let pixel = depth / lens.focal_px;
        let origin = Point3::new(-50.0 * pixel, -40.0 * pixel, depth);
        ScenePlane::new("", origin, Vector3::new(pixel, 0.0, 0.0), Vector3::new(0.0, pixel, 0.0), &sheet)
    };
    // Its right half covers the right half of the image.
    let near = plane(2.0, 0.9, Some(Area::new(50.0, 0.0, 90.0, 70.0)));
    let far = plane(5.0, 0.2, None);
    let camera = Isometry3::identity();
    let view = |planes: &[ScenePlane]| world::render(planes, &lens, &camera, &quiet()).expect("not cancelled");
    let picture = view(&[far.clone(), near.clone()]);
    assert!((picture.at(10, 20) - 0.2).abs() < 1e-5 && (picture.at(50, 20) - 0.9).abs() < 1e-5);
    assert_eq!(picture, view(&[near.clone(), far.clone()]));
    let depth = |u: f64| world::nearest_point(&[far.clone(), near.clone()], &lens, &camera, u, 20.0).expect("seen").z;
    assert!((depth(10.0) - 5.0).abs() < 1e-9 && (depth(50.0) - 2.0).abs() < 1e-9);
}

#[test]
fn apparent_motion_follows_from_depth_and_reaches_the_largest_that_was_asked_for() {
    for motion in [Motion::OneD, Motion::TwoD] {
        let trajectory = made(&TrajectoryParams { motion, ..small() });
        for (camera, [u, v]) in trajectory.cameras.iter().zip(&trajectory.slopes) {
            let max = [u, v].into_iter().flatten().fold(0.0f64, |max, x| max.max(x.abs()));
            assert!((max - 2.0).abs() < 1e-6, "{max}");
            match motion {
                // Content moves left while the camera moves right, by focal length × step / depth.
                Motion::OneD => {
                    assert!(v.iter().all(|x| x.abs() < 1e-9) && u[1] < 0.0 && u[1] - u[0] > 0.5, "{u:?} {v:?}");
                    let point = world::nearest_point(
                        &trajectory.planes,
                        &trajectory.lens,
                        &camera.world_from_camera,
                        80.0,
                        60.0,
                    )
                    .expect("the wall fills the image");
                    let depth = camera.world_from_camera.inverse_transform_point(&point).z;
                    let from = camera.pixel_of(&trajectory.lens, &point, 0.0).expect("in front");
                    assert!((from[0] - 80.0).abs() < 1e-9 && (from[1] - 60.0).abs() < 1e-9, "{from:?}");
                    let to = camera.pixel_of(&trajectory.lens, &point, 1.0).expect("in front");
                    let expected = -trajectory.lens.focal_px * camera.step.norm() / depth;
                    assert!((to[0] - from[0] - expected).abs() < 1e-9 && (to[1] - from[1]).abs() < 1e-9);
                }
                Motion::TwoD => assert!(u[0] < -0.3 && u[1] > 0.3 && v[0] < -0.3 && v[1] > 0.3, "{u:?} {v:?}"),
            }
        }
    }
}

#[test]
fn the_wall_fills_every_frame_and_a_seed_gives_the_same_bits_for_any_number_of_threads() {
    for motion in [Motion::OneD, Motion::TwoD] {
        let params = TrajectoryParams { motion, light: Light::Snr(f64::INFINITY), ..small() };
        let trajectory = made(&params);
        for index in 0..3 {
            let burst = trajectory.burst(index, &quiet()).expect("a burst");
            let dark = trajectory.exposure.camera.black_level + 0.03 * trajectory.exposure.gain;
            for frame in &burst.frames {
                assert!(frame.data().iter().all(|&x| f64::from(x) > dark && x < 1.0), "{motion:?}, burst {index}");
            }
        }
    }
    let make = |threads: usize, seed: u64| {
        on_threads(threads, || {
            let trajectory = made(&TrajectoryParams { seed, ..small() });
            let burst = trajectory.burst(1, &quiet()).expect("a burst");
            (trajectory.truth(), burst.frames, trajectory.gold(1, &quiet()).expect("a view"))
        })
    };
    let (one, other) = (make(1, 3), make(2, 4));
    assert!(one == make(3, 3));
    assert!(one.0 != other.0 && one.1 != other.1 && one.2 != other.2);
}

#[test]
fn it_is_as_dark_as_was_asked_for() {
    let clean = TrajectoryParams { light: Light::Snr(f64::INFINITY), max_slope: 0.0, ..small() };
    let scene = made(&clean).gold(0, &quiet()).expect("a view");
    for light in [Light::Snr(0.3), Light::Snr(3.0), Light::Electrons(1.2), Light::Electrons(4000.0)] {
        let trajectory = made(&TrajectoryParams { light, ..clean.clone() });
        let burst = trajectory.burst(0, &quiet()).expect("a burst");
        let exposure = &trajectory.exposure;
        // The noise is the electrons of each pixel minus those of the scene. Rounding loses about half a level.
        let electrons = exposure.camera.full_scale_electrons;
        let noise: Vec<f64> = burst
            .frames
            .iter()
            .flat_map(|frame| frame.data().iter().zip(scene.data()))
            .map(|(&x, &clean)| {
                let signal = exposure.gain * f64::from(clean) / GOLD_WHITE;
                electrons * (f64::from(x) - exposure.camera.black_level - signal)
            })
            .collect();
        let count = noise.len() as f64;
        let mean = noise.iter().sum::<f64>() / count;
        let variance = noise.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / count;
        assert!(mean.abs() < 5.0 * (variance / count).sqrt() + 0.02, "{light:?}: mean {mean}");
        let truth = trajectory.truth();
        let sigma = truth.noise.expect("noisy").sigma_background * electrons;
        assert!((variance.sqrt() / sigma - 1.0).abs() < 0.03, "{light:?}: {} for {sigma}", variance.sqrt());
        match light {
            Light::Snr(snr) => assert_eq!(truth.noise.and_then(|n| n.snr), Some(snr)),
            Light::Electrons(e) => assert_eq!(truth.electrons_at_white, Some(e)),
        }
        assert!((trajectory.electrons - exposure.gain * electrons).abs() < 1e-9 * trajectory.electrons);
        assert!(burst.frames.iter().all(|f| f.data().iter().all(|&x| x > 0.0 && x < 1.0)), "noise was cut off");
    }
}

#[test]
fn nonsense_is_named_with_its_remedy() {
    for (params, name) in [
        (TrajectoryParams { light: Light::Snr(0.0), ..small() }, "snr"),
        (TrajectoryParams { light: Light::Electrons(f64::NAN), ..small() }, "electrons"),
        (TrajectoryParams { width: 3, ..small() }, "width"),
        (TrajectoryParams { width: 8000, height: 8000, frames: 1, ..small() }, "width"),
        (TrajectoryParams { max_slope: 90.0, ..small() }, "max-slope"),
        (TrajectoryParams { bits: 17, ..small() }, "bits"),
        (TrajectoryParams { bursts: 0, ..small() }, "bursts"),
        (TrajectoryParams { planes: 17, ..small() }, "planes"),
    ] {
        let error = Trajectory::new(&params, &quiet()).expect_err(name).to_string();
        assert!(error.starts_with(&format!("{name}: ")), "{error}");
    }
    assert!(Trajectory::new(&small(), &cancelled()).is_err_and(|error| error.is_cancelled()));
}

/// Mean distance of the frames of two bursts where both are seen, fractions of full scale, and the share that is seen.
fn distance(a: &Burst, b: &Burst) -> (f32, f32) {
    let (mut sum, mut seen, mut all) = (0.0, 0.0, 0.0);
    for (a, b) in a.frames.iter().zip(&b.frames) {
        for (u, v) in (0..a.height()).flat_map(|v| (0..a.width()).map(move |u| (u, v))) {
            all += 1.0;
            if !a.is_hidden_at(u, v) {
                sum += (a.at(u, v) - b.at(u, v)).abs();
                seen += 1.0;
            }
        }
    }
    (sum / seen, seen / all)
}

#[test]
fn known_rotations_turn_the_frames_of_a_shaken_camera_to_those_of_a_still_one() {
    let light = Light::Snr(f64::INFINITY);
    let shaken = made(&TrajectoryParams { bursts: 1, shake_deg: 1.5, light, ..small() });
    let mut still = shaken.clone();
    still.cameras[0].shake = Shake::default();
    let (home, monitor) = (folder(), Monitor::default());
    let way = home.join("way");
    write_trajectory(&way, &shaken, &monitor).expect("written");
    let folder = way.join("bursts/burst_000");
    let open = |options: OpenOptions| Burst::open_with(std::slice::from_ref(&folder), &options, &monitor);
    let turned = |list: &str, times: Option<TimesChoice>| {
        open(OpenOptions {
            rotations: Some(list.into()),
            lens: Some("lens.toml".into()),
            times,
            ..OpenOptions::default()
        })
    };
    let expected = still.burst(0, &monitor).expect("not cancelled");
    let (as_taken, _) = distance(&open(OpenOptions::default()).expect("a burst"), &expected);
    let by_lines = turned("rotations.txt", None).expect("a burst");
    let (left, seen) = distance(&by_lines, &expected);
    // Edges without any blur lose by being sampled once more.
    assert!(left < 0.2 * as_taken && seen > 0.9, "{left} of {as_taken}, {seen} seen");
    assert!(by_lines.taken.iter().any(|said| said.contains("as rotations.txt says")), "{:?}", by_lines.taken);
    // The same orientations in other forms; with stamps also ten in a frame interval, begun before the first frame.
    let lists = |every: f64| {
        let (mut tum, mut euroc) = (String::new(), String::from("#timestamp,x,y,z,qw,qx,qy,qz,vx\n"));
        for k in 0..(if every < 1.0 { 60 } else { 5 }) {
            let t = if every < 1.0 { every * f64::from(k) - 0.5 } else { f64::from(k) };
            let q = shaken.cameras[0].at(t - 2.0).rotation;
            let [x, y, z, w] = [q.i, q.j, q.k, q.w];
            tum += &format!("{} 0 0 0 {x} {y} {z} {w}\n", 100.0 + 0.1 * t);
            euroc += &format!("{},0,0,0,{w},{x},{y},{z},0\n", ((100.0 + 0.1 * t) * 1e9) as i64);
        }
        [tum, euroc]
    };
    let times: String = (0..5).map(|t| format!("{}\n", 100.0 + 0.1 * f64::from(t))).collect();
    std::fs::write(folder.join("times_s.txt"), format!("time_s\n{times}")).expect("written");
    for (every, tolerance) in [(1.0, 1e-6), (0.1, 1e-3)] {
        for list in lists(every) {
            std::fs::write(folder.join("list.txt"), list).expect("written");
            let stamps = (every < 1.0).then(|| TimesChoice::List("times_s.txt".into()));
            let (off, _) = distance(&turned("list.txt", stamps).expect("a burst"), &by_lines);
            assert!(off < tolerance, "every {every}: {off}");
        }
    }
    let refused = |list: &str, text: &str, part: &str| {
        std::fs::write(folder.join(list), text).expect("written");
        says(turned(list, None).expect_err("refused"), &[part, list]);
    };
    refused("two.txt", "0 0 0 1\n0 0 0 1\n", "2 orientations for 5 frames");
    refused("long.txt", "0 0 0 2\n", "line 1: the quaternion has the length 2");
    refused("word.txt", "0 0 0 1\n0 0 x 1\n", "line 2: not all of it are numbers");
    refused("few.txt", "0 0 1\n", "3 numbers, where there are 4, 5 or 8");
    refused("other.txt", &"0 0 0 1\n1 0 0 0\n".repeat(3)[..40], "shows nothing");
    refused("none.txt", "# nothing\n", "it holds no orientation");
    std::fs::write(way.join("lens.toml"), Lens { width: 80, ..shaken.lens }.to_toml()).expect("written");
    says(turned("rotations.txt", None).expect_err("another size"), &["80×120", "160×120"]);
    std::fs::remove_file(way.join("lens.toml")).expect("removed");
    assert!(turned("rotations.txt", None).expect_err("no camera").to_string().contains("there is no camera lens.toml"));
}

mod noisy {
    use burstscope_core::monitor::{Cancelled, Monitor};
    use burstscope_core::synth::noise::quantisation_step;
    use burstscope_core::{Burst, Plane};
    use burstscope_lab::synth::{FrameLevels, NoisyExposure, NoisyParams};

    /// Three frames of a ramp from 0 to 1, whose standard deviation is 0.29.
    fn ramp() -> Burst {
        let frame = || Plane::from_fn(200, 100, |u, _| u as f32 / 199.0);
        let mut burst = Burst::from_planes("ramp", vec![frame(), frame(), frame()]);
        burst.frame_names = ["a.jpg", "b.jpg", "c.jpg"].map(str::to_owned).to_vec();
        burst
    }

    fn exposure(params: &NoisyParams, burst: &Burst) -> NoisyExposure {
        let mut levels = FrameLevels::default();
        levels.add(burst, &Monitor::default()).expect("nobody cancels");
        params.exposure(&levels).expect("a camera")
    }

    #[test]
    fn the_noise_is_what_was_asked_for_and_nothing_is_cut_off() {
        let burst = ramp();
        for snr in [0.3, 1.0, 10.0] {
            let params = NoisyParams { snr, ..NoisyParams::default() };
            let exposure = exposure(&params, &burst);
            let noisy = exposure.capture(&burst, 5, 1, &Monitor::default()).expect("not cancelled");
            // Columns near the middle have approximately the mean level.
            let offset = |u: usize, v: usize, t: usize| {
                let clean = exposure.gain * f64::from(burst.frames[t].at(u, v)) + exposure.camera.black_level;
                f64::from(noisy.frames[t].at(u, v)) - clean
            };
            let errors: Vec<f64> = (0..3)
                .flat_map(|t| (90..110).flat_map(move |u| (0..100).map(move |v| (u, v, t))))
                .map(|(u, v, t)| offset(u, v, t))
                .collect();
            let n = errors.len() as f64;
            let mean = errors.iter().sum::<f64>() / n;
            let sigma = (errors.iter().map(|x| x * x).sum::<f64>() / n).sqrt();
            let wanted = exposure.gain * (1.0f64 / 12.0).sqrt() / snr;
            assert!((sigma / wanted - 1.0).abs() < 0.04, "snr {snr}: {sigma} for {wanted}");
            assert!(mean.abs() < 4.0 * sigma / n.sqrt(), "snr {snr}: mean error {mean}");
            let all = || noisy.frames.iter().flat_map(|f| f.data());
            assert!(all().all(|&x| x > 0.0 && x < 1.0), "snr {snr}: noise is cut off");
            assert_eq!(noisy.quantisation_step, quantisation_step(12) as f32);
        }
    }

    #[test]
    fn no_noise_is_a_copy_and_frames_are_independent() {
        let burst = ramp();
        let clean = exposure(&NoisyParams { snr: f64::INFINITY, ..NoisyParams::default() }, &burst);
        let copy = clean.capture(&burst, 1, 1, &Monitor::default()).expect("not cancelled");
        let lifted = f64::from(burst.frames[0].at(120, 3)) * clean.gain + clean.camera.black_level;
        assert!((f64::from(copy.frames[0].at(120, 3)) - lifted).abs() < 1e-6);
        let noisy = exposure(&NoisyParams::default(), &burst);
        let at = |first| noisy.capture(&burst, 1, first, &Monitor::default()).expect("not cancelled");
        let (from_1, from_2) = (at(1), at(2));
        assert!(from_1.frames[0].data() != from_1.frames[1].data());
        assert_eq!(from_1.frames[1].data(), from_2.frames[0].data());
    }

    #[test]
    fn frames_without_contrast_have_no_camera_and_cancelling_ends_it() {
        let mut levels = FrameLevels::default();
        let monitor = Monitor::default();
        let grey = Burst::from_planes("grey", vec![Plane::from_fn(8, 8, |_, _| 0.5)]);
        levels.add(&grey, &monitor).expect("nobody cancels");
        let error = NoisyParams::default().exposure(&levels).expect_err("no contrast").to_string();
        assert!(error.contains("alike"), "{error}");
        monitor.cancel();
        assert_eq!(FrameLevels::default().add(&grey, &monitor), Err(Cancelled));
    }
}
