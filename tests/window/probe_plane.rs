//! Burst that moves along both axes: the probe's map of both slopes, slices along and across the motion, and the map of
//! winning slopes.

use crate::support::*;
use burstscope::{app::pane::SliceAxis, inspect::place::winning_slopes, synth::random::Stream};

/// Discs on the left move by (1, −1), those on the right by (−1, 0.5); a `.npy` stack.
const LEFT: Slope = Slope { u: 1.0, v: -1.0 };
const RIGHT: Slope = Slope { u: -1.0, v: 0.5 };
const SIZE: (usize, usize) = (240, 160);
const FRAMES: usize = 7;

fn two_motions(folder: &Path) -> PathBuf {
    let mut stream = Stream::new(17, 0);
    let discs = [
        (LEFT, 40.0, 40.0),
        (LEFT, 74.0, 92.0),
        (LEFT, 34.0, 120.0),
        (RIGHT, 160.0, 50.0),
        (RIGHT, 206.0, 84.0),
        (RIGHT, 168.0, 124.0),
    ];
    stack(folder, "two_motions.npy", (FRAMES, SIZE.1, SIZE.0), |(t, v, u)| {
        let dt = t as f32 - 0.5 * (FRAMES as f32 - 1.0);
        let light = |(slope, x, y): (Slope, f32, f32)| {
            let d2 = (u as f32 - x - dt * slope.u).powi(2) + (v as f32 - y - dt * slope.v).powi(2);
            (-d2 / (2.0 * 3.0 * 3.0)).exp()
        };
        0.1 + 0.12 * discs.into_iter().map(light).sum::<f32>() + 0.02 * stream.normal() as f32
    })
}

fn open() -> Window {
    let home = folder();
    let mut start = Start { size: [1280.0, 800.0], ..Start::of(&two_motions(&home)) };
    let slopes = SlopeGrid::plane(-2.0..=2.0, 5, -2.0..=2.0, 5);
    start.startup.params = DetectorParams { slopes, ..DetectorParams::default() }.into();
    let mut window = start.open();
    window.key(Key::D).settle();
    window
}

fn probe_strongest(window: &mut Window) -> Feature {
    window.key(Key::Home).click("Why?").settle();
    let feature = *window.read().selected_feature().expect("there is one");
    let near = |slope: Slope| (feature.slope.u - slope.u).hypot(feature.slope.v - slope.v) < 0.3;
    assert!(near(LEFT) || near(RIGHT), "{feature:?}");
    feature
}

#[test]
fn the_probe_shows_the_response_over_both_slopes() {
    let mut window = open();
    let feature = probe_strongest(&mut window);
    // Makes space for the widgets below.
    window.harness.get_by_label("Candidates here").click();
    window.settle();
    let rect = window.rect(Role::Image, "Response over both slopes");
    assert!(window.harness.ctx.content_rect().contains_rect(rect), "{rect:?}");
    let plane = window.results().probed.answer.as_ref().unwrap().probe.response.plane.clone().expect("two axes");
    let (columns, rows) = plane.snr.size();
    let cells = (0..rows).flat_map(|row| (0..columns).map(move |column| (column, row)));
    let (column, row) =
        cells.max_by(|a, b| plane.snr.at(a.0, a.1).abs().total_cmp(&plane.snr.at(b.0, b.1).abs())).unwrap();
    let peak = (plane.u.values[column], plane.v.values[row]);
    assert!((peak.0 - feature.slope.u).abs() < 0.5 && (peak.1 - feature.slope.v).abs() < 0.5, "{peak:?} {feature:?}");
    window.snapshot("probe_both_slopes");
    // A click sets that slope, at the scale of the map. The centre of the range is slope 0.
    window.click_at(rect.center()).settle();
    let (model, scale) = (window.model(), plane.scale);
    let cursor = *model.document.cursor();
    let near_zero = |x: f32| x.abs() < 0.4; // A cell of the map is a third of a slope wide.
    assert!(near_zero(cursor.slope.u) && near_zero(cursor.slope.v), "{:?}", cursor.slope);
    assert!(model.document.focused().shows(ViewKind::Dog));
    assert_eq!((cursor.octave, cursor.level), (scale.octave, scale.level));
    // A click in a row of the upper map sets the scale of the lower one.
    let above = window.rect(Role::Image, "Response over slope and scale");
    window.click_at(pos2(above.center().x, above.top() + 0.7 * above.height())).settle();
    let coarser = window.results().probed.answer.as_ref().unwrap().probe.response.plane.clone().expect("two axes");
    assert!(coarser.scale.sigma > scale.sigma, "{} {}", coarser.scale.sigma, scale.sigma);
}

#[test]
fn across_the_motion_a_slice_shows_what_is_left_of_it() {
    let mut window = open();
    let feature = probe_strongest(&mut window);
    window.run_action("stack and slice").settle();
    let shown = window.document().panes.shown();
    let contents: Vec<Content> = shown.iter().map(|id| window.document().panes.get(*id).unwrap().content).collect();
    let slices = [Content::Slice(SliceAxis::Along), Content::Slice(SliceAxis::Across)];
    assert_eq!(contents, [Content::Cursor, slices[0], slices[1]]);
    let probe = &window.results().probed.answer.as_ref().unwrap().probe;
    let [along, across] = [0, 1].map(|axis| probe.slices[axis].direction);
    assert!((along[0] * across[0] + along[1] * across[1]).abs() < 1e-5, "at right angles");
    let on = |direction: [f32; 2], slope: Slope| slope.u * direction[0] + slope.v * direction[1];
    assert!(on(across, feature.slope).abs() < 0.02, "along its own motion nothing moves across");
    window.snapshot("probe_slice_across");
    // The line of the slope is dragged sideways: only the slope's component across the motion changes.
    let rect = window.rect(Role::Image, "Slice across the motion");
    window.click_at(rect.center());
    let slope = |window: &Window| window.document().panes.get(shown[2]).unwrap().cursor.slope;
    let before = slope(&window);
    // The slice has space for numbers on its left.
    let from = rect.center() + vec2(13.0, 45.0);
    window.drag(from, from + vec2(9.0, 0.0));
    let after = slope(&window);
    assert!(on(across, after) > on(across, before) + 0.3, "{before:?} {after:?}");
    // Slopes are rounded to hundredths.
    assert!((on(along, after) - on(along, before)).abs() < 0.0075, "{before:?} {after:?}");
}

#[test]
fn the_winning_slope_is_a_picture_of_the_motion() {
    let mut window = open();
    let feature = probe_strongest(&mut window);
    window.set().focused_mut().cursor.octave = feature.octave;
    window.set().focused_mut().cursor.level = feature.level;
    // The features would cover it.
    window.key(Key::O).shift(Key::V).settle();
    assert_eq!(window.document().focused().content, Content::Map(ViewKind::Motion));
    let picture = window.read().picture().unwrap();
    let motion = picture.motion.clone().expect("a map of the motion");
    let trail = &window.results().probed.answer.as_ref().unwrap().request.traced.cache.trail;
    let expected = winning_slopes(trail, feature.octave, feature.level, &Monitor::default()).unwrap();
    let slopes: Vec<Slope> = trail.params().used_slopes().slopes().collect();
    let (width, height) = expected.snr.size();
    for at in (0..width * height).map(|place| (place % width, place / width)) {
        let slope = slopes[expected.slope_index.at(at.0, at.1) as usize];
        assert_eq!(motion.at(at), (slope, expected.confidence.at(at.0, at.1)), "{at:?}");
    }
    let step = picture.request.kind.input_px_per_pixel();
    let at = |u: f32, v: f32| motion.at(((u / step).round() as usize, (v / step).round() as usize));
    for (slope, u, v) in [(LEFT, 74.0, 92.0), (RIGHT, 206.0, 84.0)] {
        let (wins, sure) = at(u, v);
        assert!((wins.u - slope.u).hypot(wins.v - slope.v) < 0.8 && sure > 0.0, "{wins:?} {slope:?} {sure}");
    }
    assert_eq!(at(120.0, 20.0).1, 0.0, "where nothing is, nothing is sure");
    window.hover(window.ui_from_image(pos2(74.0, 92.0)).unwrap()).steps(3);
    assert!(window.shows("px/frame, ") && window.shows("sure "));
    window.snapshot("winning_slope_map");
}
