//! Maps as kinds of picture: the local noise, the coverage.

use crate::support::*;
use burstscope::app::canvas::overlay::{ColourBy, ColourScale};
use burstscope::detector::view::{coverage_view, gate_noise_map};
use burstscope::synth::random::Stream;

/// Writes a dark room with a bright lamp on the right, as a `.npy` stack: the noise grows with the light. Discs move by
/// (1, 0).
pub fn lamp(folder: &Path) -> PathBuf {
    let mut stream = Stream::new(5, 0);
    let blob = |u: f32, v: f32, at: (f32, f32), sigma: f32| {
        (-((u - at.0).powi(2) + (v - at.1).powi(2)) / (2.0 * sigma * sigma)).exp()
    };
    stack(folder, "lamp.npy", (8, 160, 240), |(t, v, u)| {
        let (at, v) = (u as f32 - t as f32, v as f32);
        let discs: f32 = [(40.0, 50.0), (90.0, 110.0), (60.0, 120.0)].iter().map(|d| blob(at, v, *d, 4.0)).sum();
        let light = 0.03 + 0.6 * blob(u as f32, v, (180.0, 80.0), 34.0) + 0.06 * discs;
        light + (0.004f32.powi(2) + 0.0015 * light).sqrt() * stream.normal() as f32
    })
}

fn open() -> Window {
    Start::at_slopes(&lamp(&folder()), SlopeGrid::line(-2.0..=2.0, 5)).open()
}

#[test]
fn the_local_noise_is_a_picture_of_its_own() {
    let mut window = open();
    window.slide("Slope u", 1.0).shift(Key::N).settle();
    let cursor = *window.document().cursor();
    assert_eq!(window.document().focused().content, Content::Map(ViewKind::Noise));
    let burst = &window.opened().burst;
    let (params, monitor) = (&window.results().slots.a.usable_params, Monitor::default());
    let expected = gate_noise_map(burst, params, cursor.slope, cursor.octave, cursor.level, &monitor).unwrap();
    let map = window.read().picture().unwrap().plane.clone();
    assert_eq!(*map, expected);
    assert!(map.at(180, 80) > 2.0 * map.at(30, 30), "it is stronger in the light");
    let (own, frames) = (window.read().display_of(window.document().focus()), window.document().look.ranges.intensity);
    assert!(own.max < 0.1 * frames.max && own.map != frames.map, "{own:?} {frames:?}");
    assert!(window.shows("One range for all noise maps") && window.shows("Local noise"));
    assert!(window.harness.query_by_label_contains("Colour bar: Noise (σ) of the response").is_some());
    window.hover(window.ui_from_image(pos2(180.0, 80.0)).unwrap()).steps(3);
    assert!(window.shows("σ 0.0") && window.shows("of full scale"), "the status bar says what it is");
    window.snapshot("noise_map");
    window.slide("Slope u", -2.0).key(Key::PageUp).key(Key::CloseBracket).settle();
    assert_eq!(window.document().focused().content, Content::Map(ViewKind::Noise));
    let coarser = &window.read().picture().unwrap().plane;
    assert_eq!((coarser.width(), window.document().cursor().octave), (map.width() / 2, cursor.octave + 1));
    window.key(Key::Num1).settle();
    assert_eq!(window.document().focused().content, Content::Cursor);
}

#[test]
fn coverage_is_a_share_of_the_frames() {
    let mut window = open();
    window.slide("Slope u", 2.0).shift(Key::C).settle();
    let burst = &window.opened().burst;
    let expected = coverage_view(
        burst,
        &window.results().slots.a.usable_params,
        window.document().cursor().slope,
        &Monitor::default(),
    )
    .unwrap();
    let map = window.read().picture().unwrap().plane.clone();
    assert_eq!(*map, expected);
    assert_eq!((map.at(120, 80), map.at(0, 80)), (1.0, 0.5), "half of the frames reach the left border");
    assert_eq!(window.read().display_of(window.document().focus()).min, 0.0);
    assert_eq!(window.read().display_of(window.document().focus()).max, 1.0);
    window.hover(window.ui_from_image(pos2(0.0, 80.0)).unwrap()).steps(3);
    assert!(window.shows("50 % of the frames"));
    window.harness.remove_cursor();
    window.steps(2).snapshot("flat/coverage_map");
}

#[test]
fn maps_are_chosen_in_the_menu_of_a_pane_and_kept_in_a_session() {
    let mut window = open();
    window.key(Key::S).settle();
    window.click("Menu of pane 2").steps(3).click_on(Role::RadioButton, "Local noise").steps(2).key(Key::Escape);
    window.settle();
    let second = window.document().panes.shown()[1];
    assert_eq!(window.document().panes.get(second).unwrap().content, Content::Map(ViewKind::Noise));
    assert_eq!(window.document().panes.get(window.document().panes.shown()[0]).unwrap().content, Content::Cursor);
    let session = Session::of(window.read()).unwrap();
    let text = toml::to_string(&session).unwrap();
    let read: Session = toml::from_str(&text).unwrap();
    let contents = |session: &Session| -> Vec<Content> {
        let panes = &session.document.panes;
        panes.shown().into_iter().map(|id| panes.get(id).unwrap().content).collect()
    };
    assert_eq!(contents(&read), [Content::Cursor, Content::Map(ViewKind::Noise)], "{text}");
    assert!(text.contains("map = \"noise\""), "{text}");
}

fn plane_of_slopes() -> SlopeGrid {
    SlopeGrid::plane(-3.0..=3.0, 7, -1.0..=1.0, 3)
}

fn feature(sigma: f32, (u, v): (f32, f32), response: f32) -> Feature {
    Feature { sigma, slope: Slope::new(u, v), response, snr: 5.0, ..Feature::default() }
}

#[test]
fn along_a_line_of_slopes_the_colours_run_over_the_searched_range() {
    let at = |slope| feature(2.0, slope, 0.1);
    let by = ColourBy::SlopeDirection;
    let line = ColourScale::of(by, &[at((1.0, 0.0))], &SlopeGrid::line(-3.0..=2.0, 6));
    assert_eq!((line.min, line.max, line.has_wheel(), line.name().as_str()), (-3.0, 2.0, false, "Slope u"));
    let colour = |scale: &ColourScale, slope| scale.colour(0, &at(slope));
    assert_eq!(colour(&line, (-3.0, 0.0)), line.along(-3.0));
    assert_ne!(colour(&line, (-3.0, 0.0)), colour(&line, (2.0, 0.0)));
    assert_eq!(colour(&line, (1.0, 0.3)), colour(&line, (1.0, 0.0)), "what lies across the line does not count");
    let oblique = ColourScale::of(by, &[], &SlopeGrid::line_along(90.0, -3.0..=3.0, 7));
    assert_eq!(oblique.name(), "Slope v");
    assert_eq!(colour(&oblique, (0.0, 3.0)), oblique.along(3.0));
    let plane = ColourScale::of(by, &[at((1.0, 0.0))], &plane_of_slopes());
    assert!(plane.has_wheel() && colour(&plane, (1.0, 0.0)) != colour(&plane, (-1.0, 0.0)));
}

#[test]
fn no_feature_and_odd_numbers_still_give_a_colour() {
    for by in ColourBy::all() {
        let empty = ColourScale::of(by, &[], &plane_of_slopes());
        assert!(empty.max > empty.min, "{by:?}");
        let odd = feature(f32::NAN, (f32::NAN, f32::INFINITY), f32::NAN);
        let odd = Feature { snr: f32::INFINITY, ..odd };
        empty.colour(0, &odd);
        ColourScale::of(by, &[odd], &plane_of_slopes()).colour(0, &odd);
    }
}
