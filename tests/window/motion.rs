//! Motion in the window: that of the features and that of their places, with the uncertainty.

use crate::support::*;
use burstscope::app::document::filter::{moves_by, near_slope};
use burstscope::app::view::{View, Zoom, layer_text, motion_text};
use burstscope::inspect::place::Judged;

fn open() -> Window {
    Start { size: [1400.0, 1100.0], ..Start::automatic() }.open()
}

#[test]
fn one_count_of_the_features_at_this_slope() {
    let mut window = open();
    window.run_action("slope with most features").settle();
    let slope = window.document().cursor().slope;
    let near = near_slope(&window.found().detection.slopes);
    let grid = &window.found().detection.slopes;
    let here = window.read().features().iter().filter(|feature| moves_by(grid, feature, slope, near)).count();
    let by_own = |f: &&burstscope::Feature| (f.slope.u - slope.u).hypot(f.slope.v - slope.v) <= near;
    assert!(
        here > window.read().features().iter().filter(by_own).count(),
        "places that move so have features of other slopes"
    );
    let note = window.model().shell.messages.note.clone().expect("a note");
    assert!(note.starts_with(&format!("Most features ({here}) are at slope (")), "{note}");
    let total = window.read().features().len();
    window.click_on(Role::CheckBox, "At this slope").settle();
    assert!(window.shows(&format!("{here} of {total}")));
    assert!(window.document().look.overlay == FeaturesShown::ThisSlope, "and so many are drawn");
}

#[test]
fn layers_are_switches_and_with_what_moves_by_itself_filters_that_sessions_keep() {
    let mut window = open();
    let field = window.found().detection.field.clone().expect("a field");
    let count = |window: &Window, wanted: &dyn Fn(&burstscope::Feature) -> bool| {
        window.read().features().iter().filter(|feature| wanted(feature)).count()
    };
    let listed = |window: &Window| window.results().listed.len();
    let (total, first) = (count(&window, &|_| true), count(&window, &|feature| feature.layer == 1));
    let none = count(&window, &|feature| feature.layer == 0);
    let alone = count(&window, &|feature| feature.layer == 1 && feature.moves == Moves::ByItself);
    assert!(total > first && first > alone && none > 0, "{total} {first} {alone} {none}");
    let name = layer_text(1, &field.layers[0]);
    window.click("Filter").steps(3);
    // A switch leaves the menu open for the next.
    let switch = |window: &mut Window, name: &str| {
        window.click_on(Role::CheckBox, name).settle();
    };
    switch(&mut window, &name);
    assert_eq!(listed(&window), total - first);
    switch(&mut window, "no layer");
    assert_eq!(listed(&window), total - first - none);
    window.click(&format!("Solo {name}")).settle();
    assert_eq!(listed(&window), first, "alone, though it is switched off");
    window.click("moves by itself").settle();
    assert_eq!(listed(&window), alone);
    let session = Session::of(window.read()).expect("a burst is open");
    assert_eq!(Session::from_toml(&session.to_toml()).expect("a session").document.filter, window.document().filter);
    window.click("any way").click(&format!("Solo {name}")).settle();
    assert_eq!(listed(&window), total - first - none, "the switches are as they were");
    window.key(Key::Escape);
}

#[test]
fn a_hidden_layer_is_dark_in_the_field_of_motion() {
    let mut window = open();
    window.key(Key::O).run_action("show field of motion").settle();
    let shown = window.harness.render().expect("a picture");
    window.change(|document| document.filter.solo_layer = Some(1)).settle();
    let field = window.read().picture().unwrap().motion.as_ref().unwrap().field.clone().expect("the field");
    let solo = window.harness.render().expect("a picture");
    let brightness = |picture: &RgbaImage, layer: u8| {
        let cells = (0..field.size.0 * field.size.1).filter(|cell| field.layer[*cell] == layer);
        let middle = |at: usize| (at as f32 + 0.5) * field.cell_px as f32 - 0.5;
        let pixel = |cell: usize| {
            let at = pos2(middle(cell % field.size.0), middle(cell / field.size.0));
            let at = window.ui_from_image(at).expect("drawn");
            let at = at * window.harness.ctx.pixels_per_point();
            picture.get_pixel(at.x as u32, at.y as u32).0[..3].iter().map(|c| f32::from(*c)).sum::<f32>()
        };
        let (sum, count) = cells.map(pixel).fold((0.0, 0.0), |(sum, count), x| (sum + x, count + 1.0));
        sum / count
    };
    // Where panels lie over the picture they tell other numbers.
    assert!((brightness(&solo, 1) / brightness(&shown, 1) - 1.0).abs() < 0.02);
    assert!(brightness(&solo, 2) < 0.5 * brightness(&shown, 2));
}

#[test]
fn a_selected_feature_tells_its_own_motion_and_that_of_its_place() {
    let mut window = open();
    let features = window.read().features().to_vec();
    for moves in [Moves::WithSurroundings, Moves::ByItself, Moves::Edge, Moves::Ghost] {
        let index = features.iter().position(|f| f.moves == moves && f.layer > 0).expect("one moves so");
        let feature = features[index];
        window.change(|document| document.selected = Some(index)).settle();
        // The unit and the word stand in the names of the rows.
        let motions = [(feature.slope, feature.slope_sigma), (feature.field, feature.field_sigma)];
        for text in motions.map(|(motion, sigma)| motion_text(motion, sigma, 2)) {
            assert!(window.shows(text.trim_end_matches(" px/frame")), "{feature:?}");
        }
        assert!(window.shows(moves.words().trim_start_matches("moves ")), "{feature:?}");
    }
    let judged = window.read().judged().expect("judged for the table");
    // What moves as its place does has that motion, also where only some of the frames respond.
    let is_said_alike = |(feature, judged): (&burstscope::Feature, &Judged)| {
        let has_place = Moves::by_numbers(feature) == Moves::WithSurroundings;
        // The search looks at the frames alone, and not at the picture around.
        let is_by_frames = judged.verdict == Verdict::Ghost && !judged.why.contains("the picture around");
        (feature.moves == Moves::Ghost) == (is_by_frames && !has_place)
    };
    assert!(features.iter().zip(judged.iter()).all(is_said_alike), "said the same way");
}

#[test]
fn the_field_says_the_motion_under_the_pointer_and_is_a_picture_as_all_in_focus_is() {
    let mut window = open();
    window.run_action("show field of motion").settle();
    let field = window.read().picture().unwrap().motion.as_ref().unwrap().field.clone().expect("the field");
    let known = |at: &[f32; 2]| field.known_at(at[0], at[1]).is_some_and(|motion| motion.slope != Slope::default());
    let [u, v] = (2..8).map(|i| [40.0 * i as f32, 100.0]).find(known).expect("a known motion");
    // Cells of 4 pixels are large enough for ellipses then.
    window.change(|document| document.focused_mut().view = View::new(Zoom::PointsPerPixel(8.0), [u, v])).settle();
    let at = window.ui_from_image(pos2(u, v)).expect("drawn");
    window.hover(at).steps(4);
    let motion = field.at(u, v);
    assert!(window.shows(&motion_text(motion.slope, motion.ellipse().0[0], 2)));
    let mut window = Start::automatic().open();
    // The features would cover them.
    window.key(Key::O);
    for (action, name) in [("show all in focus", "all_in_focus"), ("show field of motion", "field_of_motion")] {
        window.run_action(action).settle().snapshot(name);
    }
}
