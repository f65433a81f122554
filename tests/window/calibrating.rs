//! Bias and flat frames in the window: chosen, dropped, applied, saved in the session.

use crate::support::Start;
use egui::accesskit::Role;
use egui_kittest::kittest::Queryable;
use image::{ImageBuffer, Luma};
use std::path::Path;

/// Writes frames of an even light of 1200 behind a lens that dims the right half by one half, on stripes of 100 and
/// 300.
fn frames(home: &Path) {
    let bias = |v: u32| if v.is_multiple_of(2) { 100u16 } else { 300 };
    let light = |u: u32| if u < 48 { 1200u16 } else { 600 };
    let save = |name: &str, value: &dyn Fn(u32, u32) -> u16| {
        ImageBuffer::<Luma<u16>, _>::from_fn(96, 64, |u, v| Luma([value(u, v)])).save(home.join(name)).unwrap();
    };
    std::fs::create_dir(home.join("night")).unwrap();
    for t in 0..4u16 {
        save(&format!("night/{t}.png"), &|u, v| bias(v) + light(u) + (u as u16 * 7 + v as u16 * 5 + t) % 3);
    }
    save("bias.png", &|_, v| bias(v));
    save("mask.png", &|u, _| if u < 8 { 0 } else { 65_535 });
    save("flat.png", &|u, v| bias(v) + 3 * light(u));
}

#[test]
fn calibration_is_dropped_applied_and_kept_in_the_session() {
    let home = tempfile::tempdir().unwrap();
    frames(home.path());
    let mut window = Start::of(&home.path().join("night")).open();
    let value = |window: &crate::support::Window, u: usize, v: usize| {
        window.app().model.slots.a.burst.as_ref().unwrap().burst.frames[0].at(u, v) * 65_535.0
    };
    assert!((value(&window, 0, 0) - 1300.0).abs() < 3.0 && (value(&window, 90, 1) - 900.0).abs() < 3.0);
    // The suggestion about the values was noted when the burst was opened.
    assert!(
        window
            .app()
            .model
            .slots
            .a
            .burst
            .as_ref()
            .unwrap()
            .burst
            .notes()
            .iter()
            .any(|note| note.option == Some("full-scale"))
    );
    window.run_action("calibration");
    // The first dropped file is the bias; the flat is chosen.
    window.drop_file(home.path().join("bias.png"));
    window.dialogs.will_choose(home.path().join("flat.png"));
    window.click("Choose flat frame…");
    window.wait("both are named", |app| app.is_settled());
    window.harness.run_steps(3);
    // The third is the mask.
    window.drop_file(home.path().join("mask.png"));
    window.harness.run_steps(3);
    assert!(window.shows("bias.png") && window.shows("flat.png") && window.shows("mask.png"));
    window.snapshot("calibration");
    window.click("Apply");
    window.settle();
    let masked = window.app().model.slots.a.burst.as_ref().unwrap().burst.frames[0].clone();
    assert_eq!([masked.weight_at(7, 30), masked.weight_at(8, 30)], [0.0, 1.0]);
    // Both halves are as bright, and there are no stripes.
    for (u, v) in [(0, 0), (0, 1), (90, 0), (90, 1)] {
        assert!((value(&window, u, v) - 900.0).abs() < 4.0, "({u}, {v}): {}", value(&window, u, v));
    }
    let file = home.path().join("night.burstscope.toml");
    window.dialogs.will_choose(&file);
    window.run_action("save session");
    window.settle();
    let mut other = Start::without_auto_detect().open();
    other.dialogs.will_choose(&file);
    other.run_action("open session");
    other.settle();
    assert!((value(&other, 90, 1) - 900.0).abs() < 4.0);
    let kept = other.app().model.calibration.clone();
    assert!(kept.bias.is_some_and(|path| path.ends_with("bias.png")) && kept.flat.is_some() && kept.mask.is_some());
    // Without calibration, values are as in the files.
    other.run_action("calibration");
    other.click("Reset");
    other.click("Apply");
    other.settle();
    assert!((value(&other, 0, 0) - 1300.0).abs() < 3.0);
}

#[test]
fn a_calibration_that_does_not_fit_is_said_and_the_burst_stays() {
    let home = tempfile::tempdir().unwrap();
    frames(home.path());
    let wrong = home.path().join("small.png");
    image::GrayImage::new(8, 8).save(&wrong).unwrap();
    let mut window = Start::of(&home.path().join("night")).open();
    window.run_action("calibration");
    window.drop_file(wrong);
    window.harness.get_by_role_and_label(Role::CheckBox, "Linear light").click();
    window.harness.run_steps(2);
    window.click("Apply");
    window.wait("a message", |app| !app.model.messages.errors().is_empty());
    assert!(window.shows("the bias frame is 8×8"));
    assert_eq!(window.app().model.slots.a.burst.as_ref().unwrap().burst.len(), 4);
}
