//! Nothing is cut off on the screens of the window, whatever its size, scale and theme.

use crate::{cut::cut_off, steps_back::second_click_at, support::*};
use egui::ThemePreference;

const SIZES: [[f32; 2]; 3] = [[960.0, 640.0], [1280.0, 800.0], [1920.0, 1080.0]];

/// Asserts that nothing of this screen is cut off at any size, scale and theme.
#[track_caller]
fn assert_whole(window: &mut Window, screen: &str) {
    let mut told = Vec::new();
    for theme in [ThemePreference::Dark, ThemePreference::Light] {
        window.set().theme = theme;
        for [width, height] in SIZES {
            for scale in [1.0, 2.0] {
                let viewports = &mut window.harness.set_size(vec2(width, height)).input_mut().viewports;
                viewports.values_mut().for_each(|viewport| viewport.native_pixels_per_point = Some(scale));
                // Sizes measured in one pass are used in the next.
                window.steps(4);
                let lines = cut_off(&window.harness);
                told.extend(lines.into_iter().map(|line| format!("{width}×{height} at {scale}, {theme:?}: {line}")));
            }
        }
    }
    assert!(told.is_empty(), "{screen}: cut off:\n{}", told.join("\n"));
}

fn open() -> Window {
    let start = Start::automatic();
    Start { size: SIZES[1], ..start }.open()
}

#[test]
fn a_selected_feature_tells_all_its_numbers() {
    let mut window = open();
    window.key(Key::Home).settle();
    for size in SIZES {
        window.harness.set_size(size.into());
        window.steps(4);
        let index = window.document().selected.expect("the strongest");
        let feature = window.read().features()[index];
        for value in [format!("{:.1}", feature.snr), feature.octave.to_string(), feature.level.to_string()] {
            assert!(window.shows(&value), "{value} at {size:?}");
        }
        for name in ["Slope index", "Orientation", "Octave", "Level", "Slope limit"] {
            assert!(window.shows(name), "{name} at {size:?}");
        }
    }
    assert_whole(&mut window, "a selected feature");
}

#[test]
fn tables_tabs_a_probe_and_a_match_are_whole() {
    let mut window = open();
    for tab in [BottomTab::Table, BottomTab::Tally, BottomTab::Noise, BottomTab::Slopes] {
        window.change(|document| document.bottom_tab = tab).settle();
        assert_whole(&mut window, &format!("{tab:?}"));
    }
    window.shift_click_at(window.ui_from_image(pos2(257.4, 150.5)).expect("drawn")).settle();
    assert_whole(&mut window, "a probe");
    let startup = burstscope::app::Startup { second: Some(BurstSource::DemoLater), ..given() };
    let mut window = Start { size: SIZES[1], startup, ..Start::default() }.open();
    window.key(Key::Home).settle();
    assert_whole(&mut window, "a match");
}

#[test]
fn the_loupe_is_whole_and_beside_its_place_in_one_pane_and_in_several() {
    use egui::accesskit::Role;
    use egui_kittest::kittest::{NodeT, Queryable, by};
    let mut window = open();
    let document = window.set();
    (document.follows_focus, document.panels) = (true, Panels { loupe: true, welcome: false, ..Panels::default() });
    for layout in [Key::Num5, Key::Num9] {
        window.key(layout).settle();
        let mut seen = 0;
        for (size, place) in SIZES.into_iter().flat_map(|size| (0..15).map(move |place| (size, place))) {
            let parts = vec2([0.03, 0.3, 0.5, 0.7, 0.97][place % 5], [0.2, 0.5, 0.9][place / 5]);
            let pointer = (parts * vec2(size[0], size[1])).to_pos2();
            window.harness.set_size(size.into()).hover_at(pointer);
            window.steps(4);
            assert_eq!(cut_off(&window.harness), Vec::<String>::new(), "{layout:?} {size:?} {pointer}");
            let is_loupe = |node: &egui_kittest::Node<'_>| {
                node.accesskit_node().role() == Role::Label && node.rect().height() > 60.0
            };
            let mut loupes = window.harness.query_all_by_label_contains("Sharp at ");
            let Some(loupe) = loupes.find(is_loupe) else { continue };
            let canvases = by().role(Role::Canvas);
            let mut panes = window.harness.query_all(canvases).map(|node| node.rect());
            let pane = panes.find(|pane| pane.contains(pointer)).expect("the pointer is in a pane");
            assert!(pane.expand(1.0).contains_rect(loupe.rect()), "{layout:?} {size:?} {pointer}");
            assert!(!loupe.rect().contains(pointer), "{layout:?} {size:?} {pointer}");
            seen += 1;
        }
        assert!(seen > 4, "{seen} of {layout:?}");
        assert_whole(&mut window, &format!("the loupe, {layout:?}"));
    }
}

#[test]
fn dialogs_and_lessons_are_whole() {
    let mut window = open();
    for action in ["calibration", "export figure", "export film", "lessons", "keyboard shortcuts"] {
        window.run_action(action).settle();
        assert_whole(&mut window, action);
        window.key(Key::Escape);
    }
    let lesson = burstscope::teach::built_in()[0].clone();
    window.app_mut().start_lesson(lesson);
    window.settle();
    assert_whole(&mut window, "a lesson");
}

#[test]
fn the_menu_of_a_feature_is_whole_and_no_tip_lies_over_it() {
    for size in SIZES {
        let mut window = Start { size, ..Start::automatic() }.open();
        let feature = {
            let index = window.results().listed[0];
            window.read().features()[index]
        };
        window.set().focused_mut().cursor.slope = feature.motion().0;
        window.settle();
        let at = window.ui_from_image(pos2(feature.u, feature.v)).expect("drawn");
        window.hover(at).steps(4);
        assert!(window.shows("response "), "the tip of the feature");
        second_click_at(&mut window, at);
        assert!(window.shows("Why this feature?") && window.shows("Split down"));
        assert!(!window.shows("response "), "the tip is gone");
        assert_eq!(cut_off(&window.harness), Vec::<String>::new(), "{size:?}");
    }
}

#[test]
fn the_value_under_the_pointer_is_whole() {
    for size in SIZES {
        let mut window = Start { size, ..Start::without_auto_detect() }.open();
        window.key(Key::Num3).settle().slide("Octave", 1.0).settle();
        let at = window.ui_from_image(pos2(322.1, 166.6)).expect("drawn");
        window.hover(at).steps(4);
        let shown: Vec<(String, bool)> = readouts(&window);
        assert!(shown.len() == 1 && !shown[0].1, "{shown:?} at {size:?}");
    }
}

/// Texts of values under the pointer, and whether they are cut short.
fn readouts(window: &Window) -> Vec<(String, bool)> {
    let mut all = Vec::new();
    for clipped in &window.harness.output().shapes {
        if let egui::Shape::Text(text) = &clipped.shape
            && text.galley.text().contains("(pixel ")
        {
            all.push((text.galley.text().to_owned(), text.galley.elided));
        }
    }
    all
}

#[test]
fn the_slope_of_features_is_said_with_their_own() {
    let mut window = open();
    window.key(Key::B).settle();
    let note = window.model().shell.messages.note.clone().expect("a note");
    assert!(note.contains(" by their own slope"), "{note}");
    let found = window.found();
    let slope: Slope = window.document().cursor().slope;
    let [all, own] = burstscope::app::document::filter::at_slope(&found.detection, slope);
    assert!(note.contains(&format!("({all})")) && note.contains(&format!("{own} by")), "{note} {all} {own}");
    window.set().bottom_tab = BottomTab::Table;
    let near = window.read().near_slope();
    window.change(|document| document.filter.near_slope = Some(near)).settle();
    assert_eq!(window.results().listed.len(), all);
    assert!(window.shows(&format!("{own} by their own slope")));
    let left = |name: &str| window.rect(Role::Button, name).left();
    let columns =
        ["Slope u", "Slope v", "Field u", "Field v", "Moves", "SNR"].map(|name| left(&format!("Sort by {name}")));
    assert!(columns.is_sorted(), "{columns:?}");
}

/// Texts of the figure of what the window shows.
fn figure_texts(window: &mut Window, folder: &Path) -> String {
    let path = folder.join("figure.svg");
    let _ = fs::remove_file(&path);
    window.will_choose(&path).run_action("figure as before").settle();
    fs::read_to_string(&path).expect("it is written")
}

#[test]
fn the_legend_of_a_figure_names_what_is_drawn() {
    let folder = folder();
    let mut window = open();
    window.set().figure.legend = true;
    window.set().figure.format = burstscope::export::FigureFormat::Svg;
    // Of one slope of a plane all features that are drawn move by it, or by few.
    let (slope, grid) = (window.document().cursor().slope, window.found().detection.slopes);
    assert!(grid.is_plane());
    let here = format!("{} px/frame", burstscope::inspect::words::slope_text(grid.slope(grid.nearest(slope))));
    let others: Vec<String> = grid
        .slopes()
        .map(|slope| format!(">{} px/frame<", burstscope::inspect::words::slope_text(slope)))
        .filter(|text| !text.contains(&here))
        .collect();
    let text = figure_texts(&mut window, &folder);
    assert!(text.contains(&format!(">{here}<")), "{here}");
    assert_eq!(others.iter().filter(|other| text.contains(*other)).count(), 0, "no other slope is drawn");
    // Of many slopes it is the wheel, as in the window.
    window.set().look.overlay = FeaturesShown::All;
    window.settle();
    let text = figure_texts(&mut window, &folder);
    assert!(text.contains("slope up to ") && !others.iter().any(|other| text.contains(other)));
    // Words are said as such, and only those that are there.
    window.set().colour_by = burstscope::app::view::ColourBy::Of(Quantity::Moves);
    window.change(|document| document.filter.moves = Some(Moves::ByItself)).settle();
    let text = figure_texts(&mut window, &folder);
    assert!(text.contains(">moves by itself<") && !text.contains(">ghost<"), "{text}");
}
