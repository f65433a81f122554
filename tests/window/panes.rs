//! Panes of the inspector: presets, splitting, links, a wipe, a flip, a difference; and contents that a small window
//! still shows.

use crate::{flat, support::*};
use burstscope::{baseline::merge_burst, detector::view::dog_view, detector::view::stack_view};

fn open() -> Window {
    Start { size: [1280.0, 800.0], ..Start::default() }.open()
}

fn laid_out(mut window: Window, key: Key) -> Window {
    window.key(key).settle();
    window
}

fn shown(window: &Window) -> Vec<PaneId> {
    window.document().panes.shown()
}

fn slopes(window: &Window) -> Vec<f32> {
    let panes = &window.document().panes;
    panes.shown().iter().map(|id| panes.get(*id).unwrap().cursor.slope.u).collect()
}

/// Centre of the canvas of pane `number`, in points.
fn middle(window: &Window, number: usize) -> Pos2 {
    window.rect(Role::Canvas, &format!("Picture {number}")).center()
}

#[test]
fn every_kind_of_picture_is_what_the_library_makes_and_a_pane_shows_the_other_burst() {
    let window = laid_out(open(), Key::Num9);
    let burst = &window.opened().burst;
    let planes: Vec<_> = shown(&window).iter().map(|id| window.read().picture_in(*id).unwrap().plane.clone()).collect();
    let (cursor, params, monitor) =
        (*window.document().cursor(), &window.document().params.at_given(), Monitor::default());
    assert_eq!(planes[0], burst.frames[cursor.frame]);
    assert_eq!(*planes[1], stack_view(burst, params, cursor.slope, &monitor).unwrap());
    assert_eq!(*planes[2], dog_view(burst, params, cursor.slope, cursor.octave, cursor.level, &monitor).unwrap());
    assert_eq!(planes[3], merge_burst(burst, 0..burst.len(), &monitor).unwrap().frames[0]);
    assert!(window.shows("Merged frames"));
    let mut window = Start::two_bursts([1280.0, 800.0]).open();
    window.click("One burst").key(Key::S).click("Menu of pane 2").steps(3).click_on(Role::RadioButton, "B");
    window.steps(2).key(Key::Escape).settle();
    let id = shown(&window)[1];
    assert_eq!(window.document().panes.get(id).unwrap().side, Side::B);
    assert_eq!(window.read().picture_in(id).unwrap().request.burst.id, window.read().burst_of(Side::B).unwrap().id);
    window.run_action("close b").settle();
    assert_eq!(shown(&window), [PaneId::of(Side::A)]);
}

#[test]
fn panes_are_split_by_buttons_and_keys_and_closed() {
    let mut window = open();
    assert!(window.has(Role::Canvas, "Picture"));
    window.key(Key::S).settle();
    assert_eq!(shown(&window).len(), 2);
    let new = window.document().panes.focus();
    assert_eq!(new, shown(&window)[1], "the new pane has the focus");
    window.key(Key::Num1).settle();
    let panes = &window.document().panes;
    assert!(panes.get(new).unwrap().shows(ViewKind::Frame) && panes.of(Side::A).shows(ViewKind::Stack));
    window.shift(Key::S).settle();
    assert_eq!(shown(&window).len(), 3);
    // Each pane has these buttons, named by its number.
    window.click("Close pane 2").settle();
    assert_eq!(shown(&window).len(), 2);
    window.ctrl(Key::W).settle();
    assert_eq!(shown(&window), [PaneId::of(Side::A)]);
    window.ctrl(Key::W);
    assert_eq!(shown(&window).len(), 1, "the last one stays");
    assert!(window.has(Role::Canvas, "Picture"));
}

#[test]
fn a_click_gives_a_pane_the_focus_keys_move_it_and_a_display_of_its_own_is_changed_alone() {
    let mut window = laid_out(open(), Key::Num7);
    assert_eq!(slopes(&window), [-2.0, -1.0]);
    window.click_at(middle(&window, 2) + vec2(0.0, 150.0));
    assert_eq!(window.document().panes.focus(), shown(&window)[1]);
    window.key(Key::ArrowRight).settle();
    assert_eq!(slopes(&window), [-2.0, 0.0], "two slopes are moved each on its own");
    window.key(Key::J).key(Key::ArrowRight).settle();
    assert_eq!(slopes(&window), [-1.0, 0.0]);
    assert!(window.read().pictures_are_current());
    window.click("Link display of pane 1").settle();
    assert!(window.shows("This pane's range for motion stacks and merged frames"));
    window.click("Full range").settle();
    let displays: Vec<_> = shown(&window).iter().map(|id| window.read().display_of(*id)).collect();
    assert_ne!(displays[0].max, displays[1].max);
    window.click("Link display of pane 1").settle();
    assert_eq!(window.read().display_of(shown(&window)[0]), displays[1]);
}

#[test]
fn a_strip_moves_as_one_until_a_pane_is_let_go() {
    let mut window = laid_out(open(), Key::Num8);
    assert_eq!(slopes(&window), [-3.0, -2.0, -1.0, 0.0, 1.0]);
    window.key(Key::ArrowRight).settle();
    assert_eq!(slopes(&window), [-2.0, -1.0, 0.0, 1.0, 2.0]);
    window.click("Link cursor of pane 5").slide("Slope u", 0.5).settle();
    assert_eq!(slopes(&window), [-0.5, 0.5, 1.5, 2.5, 2.0]);
    let last = window.read().picture_in(shown(&window)[0]).unwrap();
    let burst = &window.opened().burst;
    let expected =
        stack_view(burst, &window.document().params.at_given(), Slope::new(-0.5, 0.0), &Monitor::default()).unwrap();
    assert_eq!(*last.plane, expected);
}

#[test]
fn views_move_together_where_they_are_linked() {
    let mut window = laid_out(open(), Key::Num6);
    let zooms = |window: &Window| -> Vec<Zoom> {
        let panes = &window.document().panes;
        panes.shown().iter().map(|id| panes.get(*id).unwrap().view.zoom).collect()
    };
    let pos = middle(&window, 1);
    window.zoom_at(pos);
    let first = zooms(&window);
    assert!(first[0] != Zoom::Fit && first[0] == first[1], "{first:?}");
    window.click("Link view of pane 2");
    window.zoom_at(pos);
    let second = zooms(&window);
    assert!(second[0] != first[0] && second[1] == first[1], "{second:?}");
}

#[test]
fn the_place_under_the_pointer_is_marked_with_its_value_where_the_slope_takes_it_and_linked_place() {
    let mut window = laid_out(open(), Key::Num6);
    window.key(Key::J);
    for _ in 0..4 {
        window.key(Key::Period);
    }
    window.settle();
    // The frame is the last one now, 4.5 frames after the middle; the stack is at slope −2.
    let [frame, stack] = shown(&window)[..] else { panic!("two panes") };
    let cursor = |id| window.document().panes.get(id).unwrap().cursor;
    assert_eq!((cursor(frame).frame, cursor(stack).slope.u), (9, -2.0));
    let place = pos2(200.3, 150.2);
    let at = window.app().widgets.ui_from_image(stack).unwrap().pos(place);
    window.hover(at).steps(3);
    let values = window.app().widgets.values.clone();
    assert_eq!(values.iter().map(|v| v.id).collect::<Vec<_>>(), [stack, frame]);
    assert!((values[0].readout.u - 200.3).abs() < 0.6);
    let (moved, (u, v)) = (values[1].readout.u - values[0].readout.u, values[1].readout.pixel);
    assert!((moved + 9.0).abs() < 0.01, "{moved}");
    assert_eq!(values[1].readout.value, window.opened().burst.frames[9].at(u, v));
    assert!(window.shows("v 150.") && window.shows("2: 0."), "the status bar has both values");
    window.click("Link place of pane 1").hover(at).steps(3);
    assert_eq!(window.app().widgets.values.len(), 1);
    let mut window = laid_out(open(), Key::Num9);
    let at = window.app().widgets.ui_from_image(shown(&window)[1]).unwrap().pos(pos2(122.0, 96.0));
    window.snapshot_with_pointer("linked_place", at);
}

#[test]
fn a_pane_is_laid_over_another_as_a_wipe_and_as_a_flip() {
    let mut window = laid_out(open(), Key::Num6);
    let focus = window.document().panes.focus();
    let other = shown(&window)[0];
    let over = |window: &Window| window.document().panes.get(focus).unwrap().over;
    window.key(Key::W).settle();
    assert_eq!(over(&window), Some(Over::Wipe { other, at: 0.5 }));
    let handle = window.rect(Role::Slider, "Wipe line").center();
    window.harness.drag_at(handle);
    window.steps(1).hover(handle + vec2(60.0, 0.0)).steps(1);
    window.harness.drop_at(handle + vec2(60.0, 0.0));
    window.steps(2);
    let Some(Over::Wipe { at, .. }) = over(&window) else { panic!("still a wipe") };
    assert!(at > 0.55, "{at}");
    window.key(Key::W).key(Key::Y).settle();
    assert_eq!(over(&window), Some(Over::Flip { other, flipped: true }));
    assert!(window.shows("1  ·  Frame 5"), "what is on show is said");
    window.key(Key::W);
    assert_eq!(over(&window), None);
}

#[test]
fn a_difference_is_chosen_in_the_menu_of_a_third_pane() {
    let mut window = laid_out(open(), Key::Num7);
    window.key(Key::S).settle();
    let [a, b, c] = shown(&window)[..] else { panic!("three panes") };
    let number = window.document().panes.number(window.document().panes.focus()).unwrap();
    window.click(&format!("Menu of pane {number}")).steps(3).click("Difference").steps(3);
    let others: Vec<usize> = (1..=3).filter(|n| *n != number).collect();
    window.click(&format!("{} minus", others[0])).steps(3).click(&format!("{} − {}", others[0], others[1])).settle();
    let focus = window.document().panes.focus();
    let rest: Vec<PaneId> = [a, b, c].into_iter().filter(|id| *id != focus).collect();
    assert_eq!(window.document().panes.get(focus).unwrap().content, Content::Difference(rest[0], rest[1]));
    let plane = |id: PaneId| window.read().picture_in(id).unwrap().plane.clone();
    assert_eq!(plane(focus).at(100, 80), plane(rest[0]).at(100, 80) - plane(rest[1]).at(100, 80));
}

#[test]
fn presets_are_drawn_and_wipe_and_difference() {
    for (key, size, name) in [
        (Key::Num6, [1280.0, 800.0], "flat/preset_frame_and_stack"),
        (Key::Num7, [1024.0, 700.0], "flat/preset_two_slopes"),
        (Key::Num8, [1280.0, 800.0], "flat/preset_strip_of_slopes"),
        (Key::Num9, [1280.0, 800.0], "flat/preset_two_by_two"),
    ] {
        laid_out(flat::open(size), key).snapshot(name);
    }
    let fine = flat::at_slopes([1024.0, 700.0], SlopeGrid::line(-3.0..=3.0, 13));
    flat::open_with(fine).run_action("layout: 9 slopes").settle().snapshot("flat/preset_nine_slopes");
    let mut window = flat::open([1280.0, 800.0]);
    window.run_action("layout: scales").settle().snapshot("flat/preset_strip_of_scales");
    let mut window = laid_out(flat::open([1280.0, 800.0]), Key::Num6);
    window.key(Key::W).shift(Key::S);
    let [a, b, c] = shown(&window)[..] else { panic!("three panes") };
    let focus = window.document().panes.focus();
    let rest: Vec<PaneId> = [a, b, c].into_iter().filter(|id| *id != focus).collect();
    window.set().panes.get_mut(focus).unwrap().content = Content::Difference(rest[0], rest[1]);
    window.settle().snapshot("flat/wipe_and_difference");
}

#[test]
fn at_1024_by_700_the_picture_and_the_columns_that_matter_are_seen() {
    let mut window = Start { size: [1024.0, 700.0], ..Start::default() }.open();
    window.key(Key::Home).settle().snapshot("small_window");
    // The panel on the right ends where the table does.
    let right = window.rect(Role::Button, "Why?").left();
    for heading in ["#", "u", "v", "σ", "Slope u", "Slope v", "SNR"] {
        let rect = window.rect(Role::Button, &format!("Sort by {heading}"));
        assert!(rect.right() < right && rect.bottom() < 700.0, "{heading}: {rect:?}, but {right}");
    }
    let visible = window.app().widgets.get(window.document().focus()).and_then(|w| w.picture.visible_image).unwrap();
    let (width, height) = window.read().focused_size();
    assert!(visible.width() >= width as f32 && visible.height() >= height as f32, "the whole picture: {visible:?}");
}

#[test]
fn the_numbers_of_two_bursts_fit_at_960_points() {
    let mut window = Start::two_bursts([960.0, 640.0]).open();
    assert!(window.read().found_of(Side::B).is_some());
    window.snapshot("two_bursts_narrow").click("Unmatched").settle();
    // Between the two panels on the sides.
    let left = window.rect(Role::SpinButton, "Frame").right();
    let right = window.harness.get_by_label("Selected match").rect().left();
    let wide = |role: Role, name: &str| {
        let named = window.harness.query_all_by_label_contains(name);
        let rects = named.filter(|node| node.accesskit_node().role() == role).map(|node| node.rect());
        // The numbers' line contains the name alone too, and the name with its value.
        rects.max_by(|a, b| a.width().total_cmp(&b.width())).unwrap_or_else(|| panic!("{name} is missing"))
    };
    let numbers = ["Keypoints", "Putative", "Inliers", "Match ratio", "Match score", "Inlier ratio"];
    let lost = ["no keypoint", "ratio test", "mutual check", "geometry"];
    let rects =
        [&numbers.map(|name| wide(Role::Label, name))[..], &lost.map(|name| wide(Role::CheckBox, name))].concat();
    for (index, rect) in rects.iter().enumerate() {
        assert!(rect.left() > left && rect.right() < right && rect.bottom() < 640.0, "{index}: {rect:?}");
        assert!(rects[..index].iter().all(|other| !other.shrink(1.0).intersects(*rect)), "{rects:?}");
    }
}
