//! The picture follows the cursor, and the filmstrip of a dataset shows each cell's text and look.

use crate::datasets::{click_burst, start, walk};
use crate::support::*;
use burstscope::app::view::View;
use burstscope::detector::view::{dog_view, stack_view};
use burstscope::engine::{Engine, Wanted};
use burstscope::plane::{Mask, statistics::Region};
use std::ops::Range;

#[test]
fn sliders_and_keys_move_the_slope_the_kind_the_frame_and_the_scale_that_are_shown() {
    let mut window = Start::without_auto_detect().open();
    let before = window.read().picture().cloned().unwrap();
    window.slide("Slope u", 1.37).settle();
    let after = window.read().picture().cloned().unwrap();
    assert_ne!(before.plane, after.plane);
    let burst = &window.opened().burst;
    let slope = Slope::new(window.document().cursor().slope.u, 0.0);
    assert!((slope.u - 1.37).abs() < 1e-6, "slopes between the grid's are shown");
    let expected = stack_view(burst, &window.document().params.at_given(), slope, &Monitor::default()).unwrap();
    assert_eq!(*after.plane, expected);
    assert!(window.shows("slope (1.37, 0.00) px/frame"));
    let mut window = Start::without_auto_detect().open();
    window.key(Key::ArrowRight);
    assert_eq!(window.document().cursor().slope, Slope::new(1.0, 0.0));
    window.key(Key::ArrowRight).key(Key::ArrowLeft).key(Key::ArrowLeft);
    assert_eq!(window.document().cursor().slope, Slope::new(0.0, 0.0));
    window.slide("Slope u", 1.8).key(Key::G);
    assert_eq!(window.document().cursor().slope, Slope::new(2.0, 0.0));
    window.key(Key::Num1).settle();
    let frame = window.opened().burst.frames[window.document().cursor().frame].clone();
    assert_eq!(window.read().picture().unwrap().plane, frame);
    window.key(Key::Num3).slide("Octave", 1.0).settle();
    let burst = &window.opened().burst;
    let expected = dog_view(
        burst,
        &window.document().params.at_given(),
        window.document().cursor().slope,
        1,
        window.document().cursor().level,
        &Monitor::default(),
    )
    .unwrap();
    assert_eq!(*window.read().picture().unwrap().plane, expected);
    assert!(window.shows("octave 1"));
    window.slide("Frame", 7.0).settle();
    assert_eq!((window.document().cursor().kind, window.document().cursor().frame), (ViewKind::Frame, 7));
}

#[test]
fn a_large_stack_is_previewed_at_the_resolution_at_which_it_is_seen() {
    let of = |burst: &OpenBurst, slope: Slope| {
        PictureRequest::new(burst.clone(), PictureKind::Stack { slope }, DetectorParams::default())
    };
    let large = large_burst((0..3).map(large_frame).collect());
    let engine = Engine::new(Arc::new(|| {}), 1 << 28);
    let (all, some) = ([[0.0; 2], [2099.0, 1499.0]], [[900.5, 400.0], [1500.0, 900.0]]);
    for (points_per_pixel, octave, seen) in
        [(0.3, 2, all), (0.24, 3, all), (0.01, 4, all), (0.3, 2, some), (0.7, 0, some), (9.0, 0, some)]
    {
        let (mut wanted, mut told) = (Wanted::default(), Vec::new());
        // Each time another one: what is kept needs no preview.
        let slope = Slope::new(2.0 + 0.1 * octave as f32 + 0.003 * points_per_pixel + seen[0][0] * 1e-5, -1.0);
        wanted.ask(&engine, of(&large, slope).previewed(points_per_pixel, seen));
        let whole = loop {
            told.extend(wanted.take_partial());
            if let Some(ended) = wanted.take().pop() {
                break ended.result.expect("not cancelled");
            }
            std::thread::sleep(std::time::Duration::from_millis(1));
        };
        told.extend(wanted.take_partial());
        let [preview] = &told[..] else { panic!("{} previews", told.len()) };
        assert_eq!((&preview.request, &whole.preview), (&whole.request, &None));
        let shown = preview.preview.as_ref().expect("a preview");
        assert_eq!(shown.octave, octave);
        let (step, Region { columns, rows }) = (1 << octave, &shown.region);
        assert_eq!(preview.plane.size(), (columns.len(), rows.len()));
        for (range, at) in [(columns, 0), (rows, 1)] {
            let [from, to] = seen.map(|corner| corner[at] / step as f32);
            // An octave ends up to a pixel before the picture.
            assert!(range.start as f32 <= from && to < range.end as f32 + 1.0, "{range:?} for {from} to {to}");
        }
        let inside = |range: &Range<usize>, count: usize| range.start.max(2)..range.end.min(count / step - 2);
        let (columns_inside, rows_inside) = (inside(columns, 2100), inside(rows, 1500));
        for (u, v) in rows_inside.flat_map(|v| columns_inside.clone().map(move |u| (u, v))).step_by(31) {
            let off = preview.plane.at(u - columns.start, v - rows.start) - whole.plane.at(step * u, step * v);
            // On the pixels of the frames the values are those of the whole.
            let limit = if octave == 0 { 0.0 } else { 0.02 };
            assert!(off.abs() <= limit, "({u}, {v}) at octave {octave}: {off}");
        }
    }
    // Not where nearly all is seen, nor where it is quick, nor where it would not show what a mask hides.
    let slope = Slope::new(1.0, 0.0);
    assert_eq!(of(&large, slope).previewed(0.7, all).preview, None);
    assert_eq!(of(&large_burst(vec![Plane::zeros(400, 300); 3]), slope).previewed(0.3, some).preview, None);
    let mask = Mask::new(Plane::from_fn(2100, 1500, |u, _| f32::from(u > 9))).expect("hides some");
    let masked = large_burst(vec![large_frame(0).masked(Some(mask)), large_frame(1)]);
    assert_eq!(of(&masked, slope).previewed(0.3, some).preview, None);
}

fn large_frame(t: usize) -> Plane {
    let scene = |u: f32, v: f32| 0.5 + 0.2 * (0.021 * u + 0.6).sin() + 0.2 * (0.017 * v - 0.011 * u).cos();
    Plane::from_fn(2100, 1500, |u, v| scene(u as f32 - 2.0 * t as f32, v as f32 + t as f32))
}

fn large_burst(frames: Vec<Plane>) -> OpenBurst {
    OpenBurst::new(Burst::from_planes("large", frames), BurstSource::Demo)
}

#[test]
fn a_preview_is_drawn_and_nothing_is_read_from_it() {
    let mut window = Start::without_auto_detect().open();
    let id = window.document().focus();
    apply::opening::take_burst(&mut window.app_mut().model, large_burst((0..9).map(large_frame).collect()));
    window.settle();
    for zoom in [0.3, 2.0] {
        let view = View::new(Zoom::PointsPerPixel(zoom), [1000.0, 700.0]);
        window.change(|document| document.panes.get_mut(id).expect("it is there").view = view).settle();
        let before = window.read().picture().expect("a picture").plane.clone();
        let canvas = window.app().widgets.get(id).expect("drawn").picture.ui_from_image.expect("drawn");
        window.hover(canvas.pos(pos2(1000.0, 700.0))).steps(2);
        assert!(window.app().widgets.get(id).expect("drawn").picture.readout.is_some());
        let slope = Slope::new(2.0 + 0.1 * zoom, -1.0);
        window.change(|document| document.panes.get_mut(id).expect("it is there").cursor.slope = slope);
        window.wait("a preview or the picture", |app| {
            app.read().drawn_in(id)[1].is_some() || app.read().picture_is_current()
        });
        // On a fast machine the whole picture may be there at once.
        if window.read().drawn_in(id)[1].is_some() {
            let picture = &window.app().widgets.get(id).expect("drawn").picture;
            let shown = picture.shown.as_ref().expect("a picture");
            assert!(Arc::ptr_eq(&shown.plane, &before), "profiles and histograms wait");
            assert!(picture.preview.is_none() || picture.readout.is_none(), "so does the value under the pointer");
        }
        window.settle();
        assert!(window.read().drawn_in(id)[1].is_none());
        let burst = &window.opened().burst;
        let params = window.document().params.at_given();
        let expected = stack_view(burst, &params, slope, &Monitor::default()).unwrap();
        assert_eq!(*window.read().picture().unwrap().plane, expected);
    }
}

#[test]
fn the_range_stays_while_the_hand_moves_and_playing_runs_through_the_slopes_until_it_is_paused() {
    let mut window = Start::without_auto_detect().open();
    let before = window.document().look.ranges.intensity;
    for slope in [-2.0, 0.7, 2.9] {
        window.slide("Slope u", slope).settle();
    }
    window.key(Key::Num1).settle();
    assert_eq!(window.document().look.ranges.intensity, before);
    let mut window = Start::without_auto_detect().open();
    let first = window.document().cursor().slope;
    window.click("▶ Play").wait("another slope", |app| app.model.document.cursor().slope != first);
    let second = window.document().cursor().slope;
    window.wait("a third slope", |app| {
        app.model.document.cursor().slope != first && app.model.document.cursor().slope != second
    });
    assert!(window.read().grid_of(Side::A).slopes().any(|s| s == second), "the grid's slopes are played");
    window.click("⏸ Pause");
    assert!(!window.document().playing);
}

#[test]
fn no_tooltip_lies_over_the_next_slider_while_one_is_dragged() {
    let mut window = Start::without_auto_detect().open();
    let help = "Index from 0; moving it shows the frame";
    let slider = window.rect(Role::Slider, "Frame");
    let (from, before) = (slider.center(), window.document().cursor().frame);
    window.hover(from).steps(60);
    assert!(window.shows(help), "whoever rests on a slider is told what it does");
    window.harness.drag_at(from);
    window.steps(2);
    let to = from + vec2(0.3 * slider.width(), 2.0);
    for part in [0.2, 0.6, 1.0] {
        window.hover(from + part * (to - from)).steps(60);
        assert!(!window.shows(help), "at {part} of the way");
    }
    window.harness.drop_at(to);
    window.settle();
    assert!(window.document().cursor().frame > before);
}

#[test]
fn filmstrip() {
    let home = folder();
    let source = walk(&home);
    fs::write(home.join("film/frame_012.png"), "broken").unwrap();
    let mut window = start(source).open();
    window.click("Detect all").settle();
    click_burst(&mut window, "Use frame_002 as A");
    click_burst(&mut window, "Use frame_007 as B");
    let model = &mut window.app_mut().model;
    let dataset = model.results.datasets.open.as_mut().unwrap();
    // Times, and the place of this test's files, differ from run to run.
    for state in &mut dataset.states {
        if let BurstState::Done(finished) = state {
            finished.seconds = 0.3;
        }
    }
    dataset.opened.folder = Some("/data/film-burstscope-5".into());
    model.shell.messages.note("2 bursts done");
    window.snapshot("filmstrip");
}

fn has_green_mark(window: &mut Window, label: &str) -> bool {
    let cell = window.harness.get_by_label_contains(label).rect();
    let image = window.harness.render().expect("a picture");
    let (columns, rows) =
        (cell.left() as u32..cell.left() as u32 + 16, cell.bottom() as u32 - 16..cell.bottom() as u32);
    let is_green = |[r, g, b, _]: [u8; 4]| i32::from(g) > i32::from(r) + 40 && i32::from(g) > i32::from(b) + 20;
    rows.into_iter().any(|y| columns.clone().any(|x| is_green(image.get_pixel(x, y).0)))
}

#[test]
fn a_burst_without_features_is_not_marked_as_good() {
    let home = folder();
    let source = walk(&home);
    let detected = |start: Start| {
        let mut window = start.open();
        window.click("Detect all").settle();
        window
    };
    let mut window = detected(start(source));
    assert!(has_green_mark(&mut window, "Burst frame_002: "), "with features it is");
    let other = folder();
    let mut strict = start(walk(&other));
    strict.startup.params.peak_threshold = 0.9;
    let mut window = detected(strict);
    assert!(window.shows("Burst frame_002: no features") && window.shows("3 bursts, 3 done"));
    assert!(!has_green_mark(&mut window, "Burst frame_002: no features"));
}
