//! Bias and flat frames and masks in the window: chosen, dropped, drawn, applied, saved in the session.

use crate::support::*;
use burstscope::app::measure::Tool;
use image::{ImageBuffer, Luma};

/// Writes frames of an even light of 1200 behind a lens that dims the right half by one half, on stripes of 100 and
/// 300.
fn frames() -> Folder {
    let home = folder();
    let bias = |v: u32| if v.is_multiple_of(2) { 100u16 } else { 300 };
    let light = |u: u32| if u < 48 { 1200u16 } else { 600 };
    let save = |name: &str, value: &dyn Fn(u32, u32) -> u16| {
        ImageBuffer::<Luma<u16>, _>::from_fn(96, 64, |u, v| Luma([value(u, v)])).save(home.join(name)).unwrap();
    };
    fs::create_dir(home.join("night")).unwrap();
    for t in 0..4u16 {
        save(&format!("night/{t}.png"), &|u, v| bias(v) + light(u) + (u as u16 * 7 + v as u16 * 5 + t) % 3);
    }
    save("bias.png", &|_, v| bias(v));
    save("mask.png", &|u, _| if u < 8 { 0 } else { 65_535 });
    save("flat.png", &|u, v| bias(v) + 3 * light(u));
    home
}

#[test]
fn calibration_is_dropped_applied_and_kept_in_the_session() {
    let home = frames();
    let mut window = Start::of(&home.join("night")).open();
    let value = |window: &Window, u: usize, v: usize| window.opened().burst.frames[0].at(u, v) * 65_535.0;
    assert!((value(&window, 0, 0) - 1300.0).abs() < 3.0 && (value(&window, 90, 1) - 900.0).abs() < 3.0);
    // The suggestion about the values was noted when the burst was opened.
    assert!(
        window
            .app()
            .model
            .results
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
    window.drop_file(home.join("bias.png")).will_choose(home.join("flat.png"));
    window.click("Choose flat frame…").wait("both are named", |app| app.is_settled()).steps(3);
    window.drop_file(home.join("mask.png")).steps(3);
    assert!(window.shows("bias.png") && window.shows("flat.png") && window.shows("mask.png"));
    window.snapshot("calibration").click("Apply").settle();
    let masked = window.opened().burst.frames[0].clone();
    assert_eq!([masked.weight_at(7, 30), masked.weight_at(8, 30)], [0.0, 1.0]);
    for (u, v) in [(0, 0), (0, 1), (90, 0), (90, 1)] {
        assert!((value(&window, u, v) - 900.0).abs() < 4.0, "({u}, {v}): {}", value(&window, u, v));
    }
    let file = home.join("night.burstscope.toml");
    let mut other = window.kept_and_opened_in_another(&file);
    assert!((value(&other, 90, 1) - 900.0).abs() < 4.0);
    let kept = other.document().calibration.clone();
    assert!(kept.bias.is_some_and(|path| path.ends_with("bias.png")) && kept.flat.is_some() && kept.mask.is_some());
    other.run_action("calibration").click("Reset").click("Apply").settle();
    assert!((value(&other, 0, 0) - 1300.0).abs() < 3.0);
}

#[test]
fn a_calibration_that_does_not_fit_is_said_and_the_burst_stays() {
    let home = frames();
    let wrong = home.join("small.png");
    image::GrayImage::new(8, 8).save(&wrong).unwrap();
    let mut window = Start::of(&home.join("night")).open();
    window.run_action("calibration").drop_file(wrong).click_on(Role::CheckBox, "Linear light").steps(2);
    window.click("Apply").wait_for_error();
    assert!(window.shows("the bias frame is 8×8"));
    assert_eq!(window.opened().burst.len(), 4);
}

fn drag_along(window: &mut Window, places: &[Pos2]) {
    let places: Vec<Pos2> = places.iter().map(|pos| window.ui_from_image(*pos).unwrap()).collect();
    window.hover(places[0]).steps(1);
    window.harness.drag_at(places[0]);
    for pos in &places {
        window.hover(*pos).steps(1);
    }
    window.harness.drop_at(places[places.len() - 1]);
    window.steps(2);
}

#[test]
fn a_mask_is_drawn_on_the_picture_written_and_used() {
    let home = frames();
    let mut window = Start { size: [900.0, 600.0], ..Start::of(&home.join("night")) }.open();
    window.key(Key::Num1).run_action("calibration").click("Draw");
    assert_eq!(window.document().measure.tool, Tool::Mask);
    assert!(window.shows("Hide") && window.shows("rectangle"));
    let arm = [pos2(2.0, 20.0), pos2(30.0, 30.0), pos2(26.0, 40.0), pos2(2.0, 50.0)];
    drag_along(&mut window, &arm);
    drag_along(&mut window, &[pos2(60.0, 52.0), pos2(90.0, 52.0), pos2(90.0, 60.0), pos2(60.0, 60.0)]);
    assert_eq!(window.document().measure.hidden.len(), 2);
    window.click("Take back");
    assert_eq!(window.document().measure.hidden.len(), 1);
    let file = home.join("arm.png");
    window.will_choose(&file).click("Use as mask…").wait("the mask is written", |_| file.is_file()).settle().steps(3);
    assert!(window.shows("arm.png"));
    window.click("Apply").settle();
    let frame = window.opened().burst.frames[0].clone();
    assert_eq!(
        [frame.is_hidden_at(10, 35), frame.is_hidden_at(10, 15), frame.is_hidden_at(80, 56)],
        [true, false, false]
    );
    assert!(window.document().measure.is_empty(), "what was drawn is in the mask");
    window.run_action("draw mask");
    drag_along(&mut window, &[pos2(60.0, 52.0), pos2(90.0, 52.0), pos2(90.0, 60.0), pos2(60.0, 60.0)]);
    window.snapshot("mask_drawn");
    let both = home.join("both.png");
    window.will_choose(&both).click("Use as mask…").wait("the mask is written", |_| both.is_file()).settle();
    let greys = image::open(both).unwrap().into_luma8();
    let grey = |u: u32, v: u32| greys.get_pixel(u, v).0[0];
    assert_eq!([grey(10, 35), grey(80, 56), grey(50, 40)], [0, 0, 255]);
    // Masks of all frames lie in a folder.
    let masks = home.join("masks");
    fs::create_dir(&masks).unwrap();
    for t in 0..4 {
        fs::copy(&file, masks.join(format!("{t}.png.png"))).unwrap();
    }
    window.will_choose(&masks).click("Folder…").wait("the dialog names the folder", |app| app.is_settled());
    window.click("Apply").settle();
    let frame = window.opened().burst.frames[3].clone();
    assert!(frame.is_hidden_at(10, 35) && !frame.is_hidden_at(80, 56));
}
