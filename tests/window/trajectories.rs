//! An estimated trajectory beside the true one.

use crate::support::*;
use burstscope::evaluate::poses::{PoseReport, PoseStudy, Projection, evaluate_poses, read_trajectory};
use std::fmt::Write;

fn true_centres() -> Vec<[f64; 3]> {
    (0..14).map(|k| f64::from(k) * 0.2).map(|t| [3.0 * t.sin(), 0.3 * t, 3.0 * (1.0 - t.cos())]).collect()
}

/// Writes the truth as a trajectory file with names, and a sparse model of another scale in which one camera is missing
/// and the others are slightly off.
fn files(home: &Path) -> (PathBuf, PathBuf) {
    let (mut truth, mut images, mut points) = (String::new(), String::new(), String::new());
    for (k, [x, y, z]) in true_centres().into_iter().enumerate() {
        writeln!(truth, "burst_{k:02}.png {x} {y} {z} 0 0 0 1").unwrap();
        if k == 9 {
            continue;
        }
        let off = 0.05 * ((7 * k % 5) as f64 - 2.0);
        let (x, y, z) = (2.0 * x + off, 2.0 * y - off, 2.0 * z + 0.5 * off);
        // A sparse model holds transforms from world to camera. The cameras' pitch is slightly wrong.
        let half = 0.002 * ((5 * k % 7) as f64 - 3.0);
        let (sin, cos) = ((2.0 * half).sin(), (2.0 * half).cos());
        let (x, y, z) = (-x, -(cos * y - sin * z), -(sin * y + cos * z));
        writeln!(images, "{} {} {} 0 0 {x} {y} {z} 1 burst_{k:02}.png", k + 1, half.cos(), half.sin()).unwrap();
        let seen = 40 + 30 * (k % 4);
        let keypoints: Vec<String> = (0..seen).map(|i| format!("{i} {i} {}", i + 1)).collect();
        writeln!(images, "{}", keypoints.join(" ")).unwrap();
    }
    (1..=130).for_each(|point| writeln!(points, "{point} 0 0 9 128 128 128 0.6 1 0 2 0 3 0").unwrap());
    let (model, path) = (home.join("sparse"), home.join("truth.txt"));
    fs::create_dir_all(&model).unwrap();
    fs::write(model.join("images.txt"), images).unwrap();
    fs::write(model.join("points3D.txt"), points).unwrap();
    fs::write(&path, truth).unwrap();
    (model, path)
}

fn open_both() -> (Folder, Window, PoseReport) {
    let home = folder();
    let (estimate, truth) = files(&home);
    let report =
        evaluate_poses(&read_trajectory(&estimate).unwrap(), &read_trajectory(&truth).unwrap(), &PoseStudy::default())
            .unwrap();
    let mut window = Start { size: [1280.0, 800.0], ..Start::without_auto_detect() }.open();
    window.will_choose(estimate.join("images.txt")).run_action("open estimated trajectory").settle();
    window.will_choose(truth).run_action("open true trajectory").settle();
    (home, window, report)
}

#[test]
fn the_errors_are_those_of_the_library() {
    let (_home, mut window, report) = open_both();
    assert_eq!(window.document().workspace, Workspace::Trajectories);
    assert_eq!(window.results().poses.report(Which::Estimate).map(|r| (**r).clone()), Some(report.clone()));
    assert!(window.shows("13 of 14 (93 %)"));
    for errors in [&report.absolute, &report.relative] {
        assert!(window.shows(&format!("{:.4}", errors.translation.rmse)));
    }
    assert!(window.shows(&format!("{:.1}", report.model.unwrap().points_per_image)));
    window.click_on(Role::Row, "Camera burst_04.png").steps(2);
    assert_eq!(window.document().trajectories.selected, Some(4));
    window.slide("Step", 3.0).settle();
    let over_three = window.results().poses.report(Which::Estimate).unwrap().clone();
    assert_eq!((over_three.step, over_three.relative.count), (3, 10));
    assert!(window.shows(&format!("{:.4}", over_three.relative.translation.rmse)));
    window.run_action("close trajectories").settle();
    assert!(window.results().poses.is_empty() && window.shows("none yet"));
}

/// Writes the model of `files` as the second of two parts, with one of its cameras far off; the first part is smaller.
fn second_estimate(home: &Path) -> PathBuf {
    let rec = home.join("merge");
    for (part, images) in [("0", 3), ("1", 13)] {
        fs::create_dir_all(rec.join(part)).unwrap();
        let text = fs::read_to_string(home.join("sparse/images.txt")).unwrap();
        let mut lines: Vec<String> = text.lines().take(2 * images).map(str::to_owned).collect();
        lines[4] = "3 1 0 0 0 9 9 9 1 burst_02.png".to_owned();
        fs::write(rec.join(part).join("images.txt"), lines.join("\n") + "\n").unwrap();
        fs::copy(home.join("sparse/points3D.txt"), rec.join(part).join("points3D.txt")).unwrap();
    }
    rec
}

#[test]
fn two_estimates_and_the_truth_are_shown_at_once_with_their_errors() {
    let (home, mut window, first) = open_both();
    assert!(window.shows("13 of 14 cameras right"));
    window.will_choose(second_estimate(&home)).run_action("open second estimate").settle();
    assert!(window.shows("merge/1, the largest of 2 parts"));
    let poses = &window.results().poses;
    let [one, two] = Which::ESTIMATES.map(|which| poses.report(which).unwrap().clone());
    assert_eq!((&*one, two.right), (&first, 12), "one far off shifts the alignment by all, and not the count");
    assert_eq!(poses.scene(&window.document().trajectories).cameras.each_ref().map(Vec::len), [13, 13, 14]);
    assert!(window.shows("12 of 14 cameras right"));
    for report in [&one, &two] {
        assert!(window.shows(&format!("{:.4}", report.absolute.translation.rmse)));
        assert!(window.shows(&format!("{:.3}", report.absolute.rotation_deg.rmse)));
    }
    // A row has what each estimate has; the image without a camera has a row too.
    assert!(window.shows("error 2") && window.shows(&format!("{:.4}", two.pairs[2].translation_error)));
    window.harness.get_by_role_and_label(Role::Row, "Camera burst_09.png").click_accesskit();
    window.steps(2);
    assert_eq!(window.document().trajectories.selected, Some(9));
    let other = window.kept_and_opened_in_another(&home.join("two.burstscope.toml"));
    assert_eq!(other.results().poses.report(Which::Second).map(|r| r.absolute), Some(two.absolute));
    assert_eq!(other.document().trajectories.selected, Some(9));
    window.harness.get_by_label("Close Second estimate").click();
    window.settle();
    let poses = &window.results().poses;
    assert!(poses.read(Which::Second).is_none() && poses.report(Which::Estimate).is_some());
}

#[test]
fn a_camera_is_pointed_at_in_the_plane_and_trajectories() {
    let (_home, mut window, _) = open_both();
    window.change(|document| document.trajectories.projection = Projection::Xz).settle();
    let canvas = window.rect(Role::Canvas, "Trajectories");
    let scene = window.results().poses.scene(&window.document().trajectories);
    let view = window.document().trajectories.view;
    let at = canvas.center() + view.points_per_pixel() * (scene.cameras[0][6].pos - Pos2::from(view.centre_image));
    window.hover(at).steps(30);
    assert_eq!(window.results().poses.hovered, Some(6));
    assert!(window.shows("burst_06.png\noff by"), "the tooltip names the image and its error");
    window.click_at(at);
    assert_eq!(window.document().trajectories.selected, Some(6));
    let (_home, mut window, _) = open_both();
    let compared = &mut window.app_mut().model.results.poses.compared;
    // The place of this test's files differs from run to run.
    compared.read[0].as_mut().unwrap().0 = "/data/rec/sparse".into();
    compared.read[2].as_mut().unwrap().0 = "/data/truth.txt".into();
    window.set().trajectories.selected = Some(3);
    window.app_mut().model.shell.messages.note("Opened demo");
    window.snapshot("trajectories");
}

#[test]
fn a_free_view_goes_around_the_cameras_and_points_are_drawn_when_asked_for() {
    let (home, mut window, _) = open_both();
    window.click_on(Role::ComboBox, "Seen from").steps(2);
    window.harness.get_by_label("Free view").click();
    window.settle();
    let set = |window: &Window| window.document().trajectories.clone();
    let scene = |window: &Window| window.results().poses.scene(&set(window));
    let is_at = |window: &Window, orbit: [f32; 2]| {
        let off = set(window).orbit.into_iter().zip(orbit).map(|(is, wanted)| (is - wanted).abs());
        assert!(off.fold(0.0, f32::max) < 0.01, "{:?} for {orbit:?}", set(window).orbit);
    };
    assert_eq!((set(&window).projection, set(&window).orbit), (Projection::Free, [0.0; 2]));
    let begin = scene(&window);
    let spot = &begin.cameras[2][0];
    assert!(spot.frustum.iter().all(|corner| corner.is_finite() && *corner != spot.pos), "{spot:?}");
    let from = window.rect(Role::Canvas, "Trajectories").center() + vec2(-300.0, 100.0);
    window.drag(from, from + vec2(100.0, 50.0));
    is_at(&window, [-40.0, 20.0]);
    let turned = scene(&window);
    assert_eq!((turned.size, turned.scale), (begin.size, begin.scale), "it turns without a change of size");
    assert!(turned.cameras[2][0].pos.distance(spot.pos) > 10.0);
    // From straight above it goes no farther; the pan of the fixed planes stays as it is.
    window.drag(from, from + vec2(0.0, 250.0));
    is_at(&window, [-40.0, 70.0]);
    assert!(set(&window).view.is_fit());
    let other = window.kept_and_opened_in_another(&home.join("free.burstscope.toml"));
    is_at(&other, [-40.0, 70.0]);
    window.double_click_at(from);
    assert_eq!(set(&window).orbit, [0.0; 2]);
    let (home, mut window, _) = open_both();
    window.click_on(Role::CheckBox, "3D points").settle();
    assert!(window.document().trajectories.points && window.shows("3D points"));
    let app = window.app_mut();
    apply::studies::open_trajectory(&mut app.model, Which::Estimate, Some(home.join("truth.txt")), &app.engine);
    window.settle();
    assert!(!window.has(Role::CheckBox, "3D points"));
}

#[test]
fn a_second_click_on_a_camera_opens_its_burst() {
    let (home, mut window, _) = open_both();
    let nights = home.join("nights");
    for (k, frames) in [(0, 3), (1, 5)] {
        let burst = nights.join(format!("burst_{k:02}"));
        fs::create_dir_all(&burst).unwrap();
        noisy_stack(&burst, frames, 40, 40);
    }
    let row = |window: &Window, name: &str| window.rect(Role::Row, name).center();
    let at = row(&window, "Camera burst_01.png");
    window.double_click_at(at);
    assert!(window.shows("Open the dataset of burst_01.png"));
    window.will_choose(&nights).run_action("open").settle();
    assert_eq!(window.read().frame_count(), 3);
    window.run_action("trajectories").settle();
    let at = row(&window, "Camera burst_01.png");
    window.double_click_at(at).settle();
    assert_eq!((window.document().workspace, window.read().frame_count()), (Workspace::Inspect, 5));
    window.run_action("trajectories").settle();
    window.double_click_at(row(&window, "Camera burst_02.png"));
    assert!(window.shows("nights has no burst with the name of the camera burst_02.png"));
}

fn open_nights(window: &mut Window, home: &Path, places: &[usize]) {
    let nights = home.join("nights");
    for k in places {
        let burst = nights.join(format!("burst_{k:02}"));
        fs::create_dir_all(&burst).unwrap();
        noisy_stack(&burst, 3, 40, 40);
    }
    window.will_choose(&nights).run_action("open dataset").settle();
}

#[test]
fn cameras_lead_to_their_weakest_pairs_missing_ones_to_the_reason_and_points_to_features() {
    let (home, mut window, _) = open_both();
    open_nights(&mut window, &home, &[8, 9, 10]);
    let dataset = window.app_mut().model.results.datasets.open.as_mut().unwrap();
    for (pair, putative, inliers) in [((0, 1), 30, 12), ((0, 2), 400, 350), ((1, 2), 20, 3)] {
        let counts = MatchCounts { keypoints_a: 500, putative, inliers: Some(inliers), ..MatchCounts::default() };
        dataset.matches.counts.insert(pair, counts);
    }
    window.run_action("trajectories").settle();
    let select = |window: &mut Window, camera: usize| {
        // Rows below the others of a low table are not drawn: the row scrolls into sight.
        window.change(|document| document.trajectories.selected = Some(camera)).steps(3);
    };
    select(&mut window, 10);
    assert!(window.shows("Weakest pair: burst_09, burst_10"));
    select(&mut window, 9);
    assert!(window.shows("not registered"));
    assert!(window.shows("12 inliers of about 30 needed; 94 % of 500 keypoints lost: ratio test or mutual check"));
    window.harness.get_by_label("Best pair: burst_08, burst_09").click();
    window.settle();
    let document = window.document();
    assert_eq!((document.workspace, document.pair_tab), (Workspace::Pair, PairTab::Unmatched));
    assert_eq!(document.dataset.as_ref().unwrap().selected(), Some((0, 1)));
    let (home, mut window, _) = open_both();
    open_nights(&mut window, &home, &[1, 2]);
    window.run_action("trajectories").click_on(Role::CheckBox, "3D points").settle();
    let canvas = window.rect(Role::Canvas, "Trajectories");
    let set = &window.document().trajectories;
    let (point, at) = window.results().poses.scene(set).points[0];
    let at = canvas.center() + set.view.points_per_pixel() * (at - Pos2::from(set.view.centre_image));
    window.click_at(at);
    assert_eq!(window.document().trajectories.point, Some(point));
    assert!(window.shows("burst_00.png, keypoint 0") && window.shows("burst_02.png, keypoint 0"));
    window.harness.get_by_label("burst_01.png, keypoint 0").click();
    window.settle();
    assert_eq!((window.document().workspace, window.read().frame_count()), (Workspace::Inspect, 3));
    assert_eq!(window.results().reselect, Some(SavedSelection::of_index(0)), "it waits for the features");
    window.run_action("detect").settle();
    let found = !window.read().features().is_empty();
    assert_eq!(window.document().selected, found.then_some(0));
}

#[test]
fn trajectories_that_will_not_do_are_named_and_what_is_open_stays() {
    let (home, mut window, _) = open_both();
    let broken = home.join("broken.txt");
    fs::write(&broken, "1 2 3\n").unwrap();
    let app = window.app_mut();
    apply::studies::open_trajectory(&mut app.model, Which::Truth, Some(broken), &app.engine);
    window.settle();
    assert!(window.shows("broken.txt") && window.shows("line 1"));
    assert!(window.results().poses.report(Which::Estimate).is_some());
    // A truth of other places: both are read, but nothing can be compared.
    let other = home.join("other.txt");
    fs::write(&other, "x.png 0 0 0 0 0 0 1\ny.png 1 0 0 0 0 0 1\n").unwrap();
    window.drop_file(other).settle();
    assert!(window.results().poses.report(Which::Estimate).is_none());
    assert!(window.results().poses.problems().next().is_some());
    assert!(window.shows("cannot be"));
}

#[test]
fn a_session_brings_the_trajectories_back() {
    let (home, mut window, report) = open_both();
    window.set().trajectories.projection = Projection::Yz;
    let file = home.join("walk.burstscope.toml");
    let other = window.kept_and_opened_in_another(&file);
    assert_eq!(other.document().workspace, Workspace::Trajectories);
    assert_eq!(other.document().trajectories.projection, Projection::Yz);
    assert_eq!(other.results().poses.report(Which::Estimate).map(|r| r.absolute), Some(report.absolute));
}
