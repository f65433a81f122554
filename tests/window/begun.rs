//! What is set for one burst ends with it: its mask, times, frames used, slopes and filter do nothing to the next one,
//! to which a line offers them. Sessions, and the same burst opened again, keep theirs.

use crate::support::*;
use burstscope::burst::TimesChoice;
use image::GrayImage;

/// Writes bursts of four frames and a mask that hides the left eight columns, all of one size.
fn bursts() -> (Folder, PathBuf, PathBuf, PathBuf) {
    let home = folder();
    for (burst, shift) in [("slider", 0u32), ("cube", 3)] {
        fs::create_dir(home.join(burst)).unwrap();
        for t in 0..4 {
            let value = |u: u32, v: u32| image::Luma([(40 + (u * 7 + v * 5 + 3 * t + shift) % 60) as u8]);
            GrayImage::from_fn(96, 64, value).save(home.join(burst).join(format!("{t}.png"))).unwrap();
        }
    }
    let mask = home.join("mask.png");
    GrayImage::from_fn(96, 64, |u, _| image::Luma([if u < 8 { 0 } else { 255 }])).save(&mask).unwrap();
    let (slider, cube) = (home.join("slider"), home.join("cube"));
    (home, slider, cube, mask)
}

fn start(path: &Path) -> Start {
    let mut start = Start::of(path);
    start.startup.params = SearchParams::default();
    start
}

fn open(window: &mut Window, path: &Path) {
    window.will_choose(path).click("Open…").settle();
}

fn set_mask(window: &mut Window, mask: &Path) {
    window.run_action("calibration").will_choose(mask).click("Choose mask…").settle().click("Apply").settle();
}

fn is_masked(window: &Window) -> bool {
    window.opened().burst.frames[0].weight_at(3, 30) == 0.0
}

#[test]
fn the_next_burst_begins_without_what_was_set_and_a_mask_is_hatched_in_every_picture() {
    let (_home, slider, cube, mask) = bursts();
    let mut window = start(&slider).open();
    set_mask(&mut window, &mask);
    assert!(is_masked(&window));
    let model = &mut window.app_mut().model;
    model.document.params.frames = Some(FrameRange { start: 1, end: 3 });
    model.document.params.slopes = SlopeGrid::line(-2.0..=2.0, 5).into();
    model.document.filter.verdict = Some(Verdict::Ghost);
    let search = model.document.params.clone();
    open(&mut window, &slider);
    assert!(is_masked(&window) && window.document().params == search && !window.document().filter.is_open());
    assert!(!window.shows("not used here"));
    open(&mut window, &cube);
    assert!(!is_masked(&window), "the mask of another burst");
    assert_eq!(window.document().calibration.mask.clone(), None);
    assert_eq!(window.document().params.frames, None);
    assert_eq!(window.document().params.slopes, Slopes::AUTO);
    assert!(window.document().filter.is_open());
    assert!(window.shows("The mask, frames used, slopes and filter of slider are not used here."));
    window.click("Use them").settle();
    assert!(is_masked(&window) && window.document().params.slopes == search.slopes);
    assert!(window.document().params.frames == search.frames);
    assert!(!window.document().filter.is_open() && !window.shows("not used here"));
    open(&mut window, &slider);
    assert!(!is_masked(&window));
    assert!(window.shows("of cube are not used here."));
    window.click("Dismiss").settle();
    assert!(!window.shows("not used here"));
    let (_home, slider, _, mask) = bursts();
    let mut window = start(&slider).open();
    set_mask(&mut window, &mask);
    for key in [Key::Z, Key::B, Key::G] {
        window.key(key).settle();
        let picture = window.read().picture().unwrap();
        let hides = |u: usize| picture.plane.is_hidden_at(u, 30);
        assert!(hides(1) && !hides(60), "{:?}", picture.request.kind);
    }
}

#[test]
fn every_way_to_another_burst_drops_the_mask() {
    let (_home, slider, cube, mask) = bursts();
    type Way = for<'w> fn(&'w mut Window, &Path) -> &'w mut Window;
    let ways: [(&str, Way); 5] = [
        ("dropped", |window, cube| window.drop_file(cube.to_owned())),
        ("dialog", |window, cube| window.will_choose(cube).click("Open…")),
        ("recent", |window, cube| {
            open(window, cube);
            window.will_choose(cube.with_file_name("slider")).click("Open…").settle();
            set_mask(window, &cube.with_file_name("mask.png"));
            window.click("File").click("Open recent").click("cube")
        }),
        ("palette", |window, _| window.run_action("open demo burst")),
        ("example", |window, _| window.run_action("example: low contrast")),
    ];
    for (name, way) in ways {
        let mut window = start(&slider).open();
        set_mask(&mut window, &mask);
        way(&mut window, &cube).settle();
        let model = window.model();
        assert!(model.shell.messages.errors.is_empty(), "{name}: {:?}", model.shell.messages.errors);
        assert_eq!(model.document.calibration.mask, None, "{name}");
        assert!(window.shows("The mask of slider is not used here."), "{name}");
    }
}

#[test]
fn a_second_burst_has_not_the_mask_of_the_first_and_a_session_keeps_both() {
    let (home, slider, cube, mask) = bursts();
    let mut window = start(&slider).open();
    set_mask(&mut window, &mask);
    window.will_choose(&cube).run_action("open b: folder").settle();
    let hides = |window: &Window| {
        let weight = |side: Side| {
            let open = window.read().burst_of(side).expect("both are open");
            open.burst.frames[0].weight_at(3, 30)
        };
        Side::BOTH.map(|side| weight(side) == 0.0)
    };
    assert_eq!(hides(&window), [true, false]);
    assert!(window.shows("The mask of slider is not used in B."));
    let file = home.join("two.burstscope.toml");
    let other = window.kept_and_opened_in_another(&file);
    assert_eq!(hides(&other), [true, false]);
    assert!(!other.shows("not used"));
    window.click("Use it").settle();
    assert_eq!(hides(&window), [true, true]);
}

#[test]
fn a_refused_calibration_changes_nothing_and_a_step_back_takes_times_back() {
    let (_home, slider, cube, _) = bursts();
    let mut window = start(&slider).open();
    window.run_action("calibration");
    // The frames do not say when they were taken.
    window.click_on(Role::RadioButton, "Files").steps(2).click("Apply").wait_for_error().settle();
    assert_eq!(window.document().calibration.times, None);
    open(&mut window, &cube);
    assert_eq!((window.read().frame_count(), window.errors()), (4, &[][..]), "it opens");
    assert_eq!(window.opened().source, BurstSource::Paths(vec![cube]));
    let (_home, slider, ..) = bursts();
    let mut window = start(&slider).open();
    let names = |window: &Window| window.document().calibration.times.clone();
    window.run_action("calibration");
    // The views have such a choice as well, below.
    window.harness.query_all_by_role_and_label(Role::RadioButton, "Names").next().unwrap().click();
    window.steps(2).click("Apply").settle();
    assert_eq!(names(&window), Some(TimesChoice::Names));
    window.ctrl(Key::Z).settle();
    assert_eq!(names(&window), None);
    assert_eq!(window.model().shell.messages.note.as_deref(), Some("Undone: Times"));
    window.run_action("redo").settle();
    assert_eq!(names(&window), Some(TimesChoice::Names));
    window.ctrl(Key::Z).settle();
    assert_eq!(names(&window), None, "a step that was made again is taken back again");
}

#[test]
fn a_filter_is_seen_above_the_picture_until_it_is_gone() {
    let mut window = Start { size: [1280.0, 800.0], ..Start::default() }.open();
    let chip = "Show all features again";
    let has_chip = |window: &Window| window.has(Role::Button, chip);
    assert!(!has_chip(&window));
    window.change(|document| document.filter.verdict = Some(Verdict::Ghost)).settle();
    // Also where no table is open, and in each of several panes.
    window.run_action("table and tally").settle();
    assert!(has_chip(&window));
    window.key(Key::S).settle();
    assert_eq!(window.harness.query_all_by_role_and_label(Role::Button, chip).count(), 2);
    window.harness.query_all_by_role_and_label(Role::Button, chip).next().unwrap().click();
    window.settle();
    assert!(window.document().filter.is_open() && !has_chip(&window));
}
