//! Tests of the public functions of `files`, `monitor` and `plane`.

use crate::prelude::*;
use burstscope_core::{files::mark::*, plane::blur::*};

#[test]
fn a_folder_is_ours_until_it_is_changed_and_claims_come_back_whole_or_not_at_all() {
    let home = folder();
    let at = |name: &str| home.join(name);
    fs::create_dir(at("deep")).expect("made");
    ["a.png", "deep/b.png"].into_iter().for_each(|name| fs::write(at(name), name).expect("written"));
    let is_ours = |kind| is_unchanged(&home, kind).expect("it can be read");
    assert!(!is_ours(OutputKind::Burst), "it has no mark");
    seal_folder(&home, OutputKind::Burst).expect("marked");
    assert!(is_ours(OutputKind::Burst));
    assert!(!is_ours(OutputKind::Trajectory) && has_mark(&at(OutputKind::Burst.file()), true));
    for (name, content) in [("a.png", "A.png"), ("deep/c.png", ""), ("notes.txt", "mine")] {
        let before = fs::read(at(name)).ok();
        fs::write(at(name), content).expect("written");
        assert!(!is_ours(OutputKind::Burst), "{name}");
        let undone = before.map_or_else(|| fs::remove_file(at(name)), |text| fs::write(at(name), text));
        undone.expect("as it was");
    }
    fs::create_dir(at("empty")).expect("made");
    assert!(!is_ours(OutputKind::Burst));
    fs::remove_dir(at("empty")).expect("removed");
    fs::remove_file(at("a.png")).expect("removed");
    assert!(is_ours(OutputKind::Burst), "what is gone is lost to nobody");
    let mark = fs::read_to_string(at(OutputKind::Burst.file())).expect("there");
    for wrong in [mark.replace("b.png", "a.png"), mark.replace("burstscope", "another"), "{}".into(), "".into()] {
        fs::write(at(OutputKind::Burst.file()), wrong).expect("written");
        assert!(!is_ours(OutputKind::Burst) && !has_mark(&at(OutputKind::Burst.file()), false));
    }
    let home = folder();
    // Numbers whose last digit a reader of JSON may lose.
    let numbers: Vec<f64> = (1..200).map(|n| (n as f64).sqrt() * 1e-7).collect();
    fs::write(home.join(OutputKind::Dataset.file()), claiming(OutputKind::Dataset, &numbers)).expect("written");
    let read: Vec<f64> = claims(&home, OutputKind::Dataset).expect("whole");
    assert!(read.iter().zip(&numbers).all(|(a, b)| (a - b).abs() < 1e-20) && read.len() == numbers.len());
    assert_eq!(claims::<Vec<f64>>(&home, OutputKind::Figures), None);
    assert_eq!(claims::<String>(&home, OutputKind::Dataset), None);
}

#[test]
fn monitors_share_the_cancel_flag_and_a_part_tells_its_progress_as_one_of_the_whole() {
    let monitor = Monitor::with_listener(|_| panic!("nobody is to hear of this"));
    let silent = monitor.clone().silent();
    silent.report(Stage::Evaluate, 0.5);
    assert_eq!(monitor.check(), Ok(()));
    silent.cancel();
    assert_eq!(monitor.check(), Err(Cancelled));
    let heard = Arc::new(std::sync::Mutex::new(Vec::new()));
    let sink = heard.clone();
    let monitor = Monitor::with_listener(move |p| sink.lock().expect("not poisoned").push(p.fraction));
    let second_of_four = monitor.part(0.25, 0.25);
    second_of_four.report(Stage::Noise, 0.0);
    second_of_four.part(0.5, 0.5).report(Stage::Noise, 1.5);
    second_of_four.cancel();
    assert!(monitor.is_cancelled());
    assert_eq!(*heard.lock().expect("not poisoned"), [0.25, 0.5]);
}

#[test]
fn kernels_sum_to_one_and_reach_four_sigma_and_smoothing_for_looking_at_is_the_blur_and_leaves_out_nan() {
    for sigma in [0.3, 1.0, 1.6, 3.09] {
        let kernel = GaussianKernel::new(sigma);
        let sum = kernel.half()[0] + 2.0 * kernel.half()[1..].iter().sum::<f32>();
        assert!((sum - 1.0).abs() < 1e-6);
        assert_eq!(kernel.radius(), (4.0 * sigma).ceil() as usize);
    }
    assert_eq!(GaussianKernel::new(0.0).half(), &[1.0]);
    let noise = |u: usize, v: usize| ((u * 7919 + v * 104_729) % 1000) as f32 / 1000.0;
    let plane = Plane::from_fn(53, 31, noise);
    let monitor = Monitor::default();
    let smoothed = |plane: &Plane, sigma| smoothed(plane, sigma, &monitor).expect("nobody cancels");
    let (fast, plain) = (smoothed(&plane, 1.7), gaussian_blur(&plane, &GaussianKernel::with_cut(1.7, 3.0)));
    assert!(fast.data().iter().zip(plain.data()).all(|(a, b)| (a - b).abs() < 1e-6));
    assert_eq!(smoothed(&plane, 0.0), plane);
    let hole = |u: usize, v: usize| if (20..24).contains(&u) && v == 10 { f32::NAN } else { 0.25 };
    let flat = smoothed(&Plane::from_fn(53, 31, hole), 2.0);
    for v in 0..31 {
        for u in 0..53 {
            let x = flat.at(u, v);
            assert!(if hole(u, v).is_nan() { x.is_nan() } else { (x - 0.25).abs() < 1e-6 }, "({u}, {v}): {x}");
        }
    }
    monitor.cancel();
    assert_eq!(burstscope_core::plane::blur::smoothed(&plane, 1.7, &monitor), Err(Cancelled));
}

#[test]
fn a_transposed_frame_is_filled_as_the_frame_is_and_one_of_everything_with_nothing() {
    let mut noise = Stream::new(5, 0);
    let frame = Plane::from_fn(53, 38, |_, _| noise.normal() as f32);
    let transposed = |plane: &Plane| Plane::from_fn(plane.height(), plane.width(), |u, v| plane.at(v, u));
    let weights = Plane::from_fn(53, 38, |u, v| f32::from((u * 7 + v * 3) % 11 > 4 && u < 40));
    let of = |frame: Plane, weights: Plane| frame.masked(Mask::new(weights));
    let (one, other) = (of(frame.clone(), weights.clone()), of(transposed(&frame), transposed(&weights)));
    let apart = transposed(&one).data().iter().zip(other.data()).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(apart < 1e-5, "{apart}");
    assert_eq!(transposed(one.mask().expect("masked").weights()), *other.mask().expect("masked").weights());
    assert_eq!(Mask::new(Plane::from_fn(9, 7, |_, _| 1.0)), None);
    let blind = Plane::from_fn(9, 7, |_, _| f32::NAN).masked(Mask::new(Plane::zeros(9, 7)));
    assert!(blind.data().iter().all(|x| *x == 0.0));
}
