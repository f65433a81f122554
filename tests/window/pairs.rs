//! Two bursts side by side, and the matches between them.

use crate::support::*;
use burstscope::{dataset::DetectedBurst, dataset::match_bursts, matching::Geometry};

fn pair() -> Window {
    Start::two_bursts([1400.0, 900.0]).open()
}

fn middle_of(window: &Window, index: usize) -> Pos2 {
    let row = window.app().model.results.pair.matches.as_ref().unwrap().row(index).unwrap();
    let a = window.ui_from_image_of(Side::A, pos2(row.a.u, row.a.v)).unwrap();
    let b = window.ui_from_image_of(Side::B, pos2(row.b.u, row.b.v)).unwrap();
    a + 0.5 * (b - a)
}

#[test]
fn a_second_burst_is_opened_beside_the_first_and_matched() {
    let mut window = Start { size: [1400.0, 900.0], ..Start::default() }.open();
    window.choose("One burst ⏷", "Two bursts").settle();
    assert!(window.shows("Open a second burst"));
    window.click("Later demo burst as B").settle();
    let names = Side::BOTH.map(|side| window.read().burst_of(side).unwrap().burst.name.clone());
    assert_eq!(names, ["demo", "demo-later"]);
    let sides = Side::BOTH.map(|side| {
        let (burst, found) = (&window.read().burst_of(side).unwrap().burst, window.read().found_of(side).unwrap());
        DetectedBurst { burst, params: &found.params, detection: &found.detection }
    });
    let expected = match_bursts(sides, &window.document().matching, &Monitor::default()).unwrap();
    assert_eq!(*window.matches().result, expected, "the window matches as the library does");
    let counts = expected.counts;
    assert!(counts.inliers.unwrap() > 50 && counts.inlier_ratio().unwrap() > 0.7, "{counts:?}");
    for text in [
        format!("Keypoints {} + {}", counts.keypoints_a, counts.keypoints_b),
        format!("Putative {}", counts.putative),
        format!("Inliers {}", counts.inliers.unwrap()),
        format!("Match ratio {:.3}", counts.match_ratio()),
        format!("Match score {:.3}", counts.match_score().unwrap()),
        format!("Inlier ratio {:.3}", counts.inlier_ratio().unwrap()),
    ] {
        assert!(window.shows(&text), "{text}");
    }
}

#[test]
fn cameras_beside_the_frames_are_offered() {
    let home = folder();
    let [a, b] = ["n1", "n2"].map(|name| {
        let folder = home.join(name);
        fs::create_dir(&folder).unwrap();
        noisy_stack(&folder, 5, 96, 128)
    });
    let camera = |f: f64| format!("model = \"PINHOLE\"\nwidth = 128\nheight = 96\nparams = [{f}, {f}, 64, 48]\n");
    let open = || {
        let (start, second) = (Start::of(&a), Some(BurstSource::Paths(vec![b.clone()])));
        Start { size: [1280.0, 800.0], startup: Startup { second, ..start.startup }, ..start }.open()
    };
    fs::write(home.join("camera.toml"), camera(150.0)).unwrap();
    fs::write(home.join("n2/camera.toml"), camera(140.0)).unwrap();
    let mut window = open();
    assert!(window.document().matching.camera.is_none(), "not unasked");
    window.click("Use camera.toml").settle();
    let focal = |window: &Window| window.document().matching.cameras().map(|two| two.map(|camera| camera.params[0]));
    assert_eq!(focal(&window), Some([150.0, 140.0]));
    assert!(window.document().matching.geometry == Geometry::Essential && !window.shows("Use camera.toml"));
    window.ctrl(Key::Z);
    assert!(focal(&window).is_none() && window.shows("Use camera.toml"), "it is one step");
    fs::write(home.join("n2/camera.toml"), "model = 3\n").unwrap();
    let window = open();
    assert!(!window.shows("Use camera.toml") && window.shows("n2/camera.toml"), "what is wrong is said");
}

#[test]
fn a_match_is_pointed_at_chosen_and_seen_alone() {
    let mut window = pair();
    // Zoomed in on one match with no others nearby.
    window.click("Sort by σ A").click("Sort by σ A").settle();
    let index = window.results().pair.listed[0];
    window.click_at(middle_of(&window, index)).settle();
    let chosen = window.document().selected_match.expect("a line is there");
    assert!(window.shows(&format!("Match {chosen}: ")));
    let named = ["Patch in A", "Patch in B", "Descriptor in A", "Descriptor in B"];
    assert!(named.iter().all(|name| window.has(Role::Image, name)));
    let row = window.matches().row(chosen).unwrap();
    for (side, feature) in [(Side::A, row.a), (Side::B, row.b)] {
        assert!(window.read().stack_at(side, feature.slope).is_some(), "from its own motion stack");
    }
    let shown =
        [row.found.ratio.map_or("no other".to_owned(), |ratio| format!("{ratio:.3}")), "Epipolar error".to_owned()];
    assert!(shown.iter().all(|text| window.shows(text)), "{shown:?}");
    window.click_on(Role::Row, &format!("Match {chosen}")).steps(2);
    assert_eq!(window.document().selected_match, Some(chosen), "a click on the selected row keeps it selected");
    window.key(Key::Home);
    assert_eq!(window.document().selected_match, Some(index));
    window.key(Key::N);
    assert_eq!(window.document().selected_match, Some(window.results().pair.listed[1]));
    window.key(Key::Enter).settle();
    let row = window.matches().row(window.document().selected_match.unwrap()).unwrap();
    assert_eq!(window.document().panes.of(Side::A).cursor.slope, row.a.slope);
    assert_eq!(window.document().panes.of(Side::B).cursor.slope, row.b.slope);
    window.key(Key::Escape);
    assert_eq!(window.document().selected_match, None);
}

#[test]
fn headings_sort_switches_leave_out_pictures_zoom_together_and_what_cannot_be_opened_is_named() {
    let mut window = pair();
    window.click("Sort by Ratio").settle();
    let ratios = |window: &Window| -> Vec<f32> {
        let pair = &window.results().pair;
        let matches = pair.matches.as_ref().unwrap();
        pair.listed.iter().map(|&i| matches.row(i).unwrap().found.ratio.unwrap_or(0.0)).collect()
    };
    assert_eq!(window.document().match_order.column, MatchColumn::Ratio);
    assert!(ratios(&window).is_sorted());
    let counts = window.matches().result.counts;
    assert_eq!(ratios(&window).len(), counts.putative);
    window.click_on(Role::CheckBox, "Outliers").settle();
    assert_eq!(ratios(&window).len(), counts.inliers.unwrap());
    window.key(Key::U).key(Key::I).settle();
    assert_eq!(ratios(&window).len(), counts.putative - counts.inliers.unwrap());
    let views = |window: &Window| {
        Side::BOTH.map(|side| window.document().panes.of(side).view).map(|view| (view.zoom, view.centre_image))
    };
    let pos = window.ui_from_image(pos2(120.0, 90.0)).unwrap();
    window.zoom_at(pos);
    let [a, b] = views(&window);
    assert_ne!(a.0, burstscope::app::canvas::Zoom::Fit);
    assert_eq!(a, b);
    window.key(Key::V).zoom_at(pos);
    let [a, b] = views(&window);
    assert_ne!(a, b);
    let before = window.read().burst_of(Side::B).unwrap().id;
    window.will_choose("/no/such/burst-of-frames").run_action("open b: folder").wait_for_error();
    assert!(window.shows("burst-of-frames"));
    assert_eq!(window.read().burst_of(Side::B).unwrap().id, before);
}

#[test]
fn parameters_of_matching_are_live_documented_and_checked() {
    let mut window = Start::two_bursts([1400.0, 1700.0]).open();
    for doc in burstscope::matching::params::doc::ALL {
        assert!(window.shows(doc.label), "{}", doc.label);
        assert!(doc.unit.is_empty() || window.shows(doc.unit), "the unit of {}", doc.label);
    }
    // Predicted matches have a ratio of their own.
    window.change(|document| document.matching.predict = false).settle();
    let before = window.matches().result.clone();
    window.change(|document| document.matching.ratio = 0.6).settle();
    let after = window.matches().result.clone();
    assert!(after.matches.len() < before.matches.len());
    assert!(after.matches.iter().all(|m| m.ratio.is_none_or(|ratio| ratio <= 0.6)));
    window.change(|document| document.matching.ratio = -1.0).settle();
    assert!(window.shows("give more than 0 and at most 1"));
    assert_eq!(window.matches().result.counts, after.counts, "the last ones stay");
    window.click("Reset Ratio test").settle();
    assert_eq!(window.matches().result.counts, before.counts);
    window.change(|document| document.matching.geometry = Geometry::Essential).settle();
    assert!(window.shows("the essential matrix needs the camera's intrinsics"));
    window.click("Guess").settle();
    assert_eq!(window.document().matching.camera.as_ref().map(|c| (c.width, c.height)), Some((480, 360)));
    assert!(window.matches().model().is_some());
    // A typed camera is read as soon as it is whole; until then it stays as it was.
    let focal = |window: &Window| window.document().matching.camera.as_ref().map(|camera| camera.params[0]);
    let before = focal(&window);
    let type_in = |window: &mut Window, text: &str| {
        let field = window.harness.get_by_role_and_label(Role::TextInput, "Camera");
        field.focus();
        field.type_text(text);
        window.steps(2);
    };
    window.harness.get_by_role_and_label(Role::TextInput, "Camera").focus();
    window.steps(2).ctrl(Key::A);
    type_in(&mut window, "PINHOLE 480 360 500");
    assert!(focal(&window) == before && window.shows("PINHOLE"), "what is typed stays");
    type_in(&mut window, " 500 240 180");
    assert_eq!(focal(&window), Some(500.0));
}

#[test]
fn hands_move_together_or_each_its_own() {
    let mut window = pair();
    window.slide("Slope u", 1.25).settle();
    let slopes = |window: &Window| Side::BOTH.map(|side| window.document().panes.of(side).cursor.slope.u);
    assert_eq!(slopes(&window), [1.25, 1.25]);
    window.click_on(Role::CheckBox, "Slope and scale together").steps(2).click("Cursor of B");
    window.slide("Slope u", -0.5).key(Key::Num3).settle();
    assert_eq!(slopes(&window), [1.25, -0.5]);
    assert_eq!(Side::BOTH.map(|side| window.document().panes.of(side).cursor.kind), [ViewKind::Stack, ViewKind::Dog]);
    assert!(window.read().pictures_are_current());
    assert!(window.shows("A  Stack (1.25, 0)") && window.shows("B  DoG 0/0 (−0.5, 0)"));
    window.key(Key::T).key(Key::K).settle();
    assert_eq!(slopes(&window), [1.25, 1.25], "the one that the sliders do not move comes to the other");
}

#[test]
fn files_dropped_on_the_right_pane_are_opened_there() {
    let folder = folder();
    let path = noisy_stack(&folder, 5, 60, 80);
    let mut window = Start::without_auto_detect().open();
    window.ctrl(Key::Num2).settle();
    let pane = window.app().widgets.rect_ui(PaneId::of(Side::B)).unwrap();
    window.hover(pane.center()).steps(1).drop_file(path).settle();
    assert_eq!(window.read().burst_of(Side::A).unwrap().burst.name, "demo");
    assert_eq!(window.read().burst_of(Side::B).unwrap().burst.size(), (80, 60));
    assert!(window.shows("No features yet in A and B"));
    window.run_action("swap a and b").settle();
    assert_eq!(window.read().burst_of(Side::A).unwrap().burst.size(), (80, 60));
}

#[test]
fn a_session_brings_the_pair_back_and_a_session_keeps_how_two_bursts_are_arranged() {
    let (_folder, file) = folder_with("pair.burstscope.toml");
    let mut window = pair();
    window.change(|document| document.matching.ratio = 0.7).settle();
    window.key(Key::Home).key(Key::N).key(Key::K).click("Cursor of B").slide("Slope u", 0.75).settle();
    let saved = window.read().saved_match().unwrap();
    let other = window.kept_and_opened_in(Start { size: [1400.0, 900.0], ..Start::default() }, &file);
    assert_eq!(other.document().workspace, Workspace::Pair);
    assert_eq!(other.read().burst_of(Side::B).unwrap().source, BurstSource::DemoLater);
    assert_eq!(other.document().matching.ratio, 0.7);
    assert_eq!(other.document().panes.of(Side::B).cursor.slope, Slope::new(0.75, 0.0));
    assert_eq!((other.read().active_side(), other.document().pair_links().cursor), (Side::B, false));
    assert_eq!(other.read().saved_match(), Some(saved), "the same match is selected");
    let mut window = pair();
    window.shift(Key::S).key(Key::Num3).settle();
    let arrangement = window.document().panes.arrangement().clone();
    assert_eq!(arrangement.panes().len(), 3);
    let other = window.kept_and_opened_in(Start { size: [1400.0, 900.0], ..Start::default() }, &file);
    let panes = &other.document().panes;
    assert_eq!((panes.arrangement(), panes.focus()), (&arrangement, window.document().panes.focus()));
    assert!(panes.get(panes.focus()).unwrap().shows(ViewKind::Dog));
}

#[test]
fn matches_are_exported_as_a_table_and_as_a_picture() {
    let folder = folder();
    let mut window = pair();
    for (action, name) in [("matches as csv", "m.csv"), ("figure as before", "m.png")] {
        window.will_choose(folder.join(name)).run_action(action).settle();
        assert!(window.shows(&format!("Wrote {}", folder.join(name).display())), "{action}");
    }
    let counts = window.matches().result.counts;
    let csv = fs::read_to_string(folder.join("m.csv")).unwrap();
    assert_eq!(csv.lines().count(), counts.putative + 1);
    // A match has one number in the table, the panel, the tip's text and the file, and one ratio and error in each.
    let matches = window.matches();
    let chosen = matches
        .rows()
        .find(|row| row.found.predicted.is_some() && row.aligned.is_some() && row.inlier == Some(true))
        .unwrap();
    let cells: Vec<&str> = csv.lines().nth(1 + chosen.index).unwrap().split(',').collect();
    assert_eq!(cells[..2], [chosen.found.a.to_string(), chosen.found.b.to_string()]);
    assert_eq!(MatchColumn::Number.text(&chosen), chosen.index.to_string());
    assert_eq!(cells[13], "predicted");
    assert_eq!(cells[8].parse().ok(), chosen.error_px, "the aligned one");
    assert_eq!(cells[20].parse().ok(), chosen.error_found_px, "the one as found");
    let (index, how, error) = (chosen.index, chosen.how_words(), chosen.error_words());
    assert!(how.starts_with("predicted by its motion (") && how.ends_with(" among all)"), "{how}");
    assert!(error.contains(" px aligned, ") && error.ends_with(" px as found"), "{error}");
    let outlier = matches.rows().find(|row| matches.passed_limit(row).is_some_and(|why| why.starts_with("Error")));
    let why = matches.passed_limit(&outlier.unwrap()).unwrap();
    assert!(why.starts_with("Error aligned "), "{why}");
    assert!(why.ends_with("at most 1.40 px is allowed: 0.35 × the max error of 4 px"), "{why}");
    window.change(|document| document.selected_match = Some(index)).settle();
    assert!(window.shows(&format!("Match {index}: ")) && window.shows("predicted by its motion"));
    ["Ratio among all", "Error as found", " aligned"].into_iter().for_each(|row| assert!(window.shows(row), "{row}"));
    let ratios = window.matches().row(index).unwrap().found.ratio_words();
    assert!(window.shows(&format!("ratio {ratios}")), "{ratios}");
    window.change(|document| document.selected_match = None).settle();
    // 181 mm at 300 pixels an inch.
    assert_eq!(image::open(folder.join("m.png")).unwrap().width(), 2138);
    let svg = folder.join("m.svg");
    window.will_choose(&svg).run_action("figure as before").settle();
    let as_drawn = fs::read_to_string(&svg).unwrap();
    window.set().figure.matches = burstscope::export::FigureAmount::All;
    let whole = folder.join("all.svg");
    window.will_choose(&whole).run_action("figure as before").settle();
    let text = fs::read_to_string(&whole).unwrap();
    let inliers = counts.inliers.unwrap();
    assert!(text.contains(&format!(">{inliers} inliers<")) && text.contains(">(a) A: "), "{inliers}");
    assert!(text.contains("pt\""), "{inliers}");
    // At first a figure has the lines that the window draws.
    let count = |text: &str| text.matches("<line").count() + text.matches("<path").count();
    let (drawn, lines) = window.results().pair.lines_drawn;
    assert_eq!(count(&text) - count(&as_drawn), lines - drawn, "{drawn} of {lines}");
    assert!(0 < drawn && drawn < lines);
}

fn shown(window: &Window) -> Vec<PaneId> {
    window.document().panes.shown()
}

fn pos_in(window: &Window, id: PaneId, feature: &Feature) -> Pos2 {
    window.app().widgets.ui_from_image(id).unwrap().pos(pos2(feature.u, feature.v))
}

/// Hovers over the line of the selected match between two panes; returns the hovered match.
fn match_between(window: &mut Window, a: PaneId, b: PaneId) -> Option<usize> {
    let row = window.matches().row(window.document().selected_match.unwrap()).unwrap();
    let (from, to) = (pos_in(window, a, row.a), pos_in(window, b, row.b));
    let mut found = None;
    // Part of the line is in the gap between the two pictures, where nothing is hovered.
    for part in [0.2, 0.4, 0.6, 0.8] {
        window.hover(from + part * (to - from)).steps(2);
        found = window.results().pair.hovered.or(found);
    }
    window.harness.remove_cursor();
    window.steps(2);
    found
}

#[test]
fn a_pane_that_is_split_has_its_part_of_the_matches_and_both_bursts_their_difference_a_wipe_and_a_flip() {
    let mut window = pair();
    window.key(Key::Home).settle();
    let selected = window.document().selected_match;
    let [a, b] = shown(&window)[..] else { panic!("A and B") };
    assert_eq!(match_between(&mut window, a, b), selected);
    // A twice: the lines begin at the pane beside B, the other one keeps the ends.
    window.click("Split right 1").key(Key::Num3).settle();
    let [first, second, b] = shown(&window)[..] else { panic!("three panes") };
    assert!(window.document().panes.get(second).unwrap().shows(ViewKind::Dog));
    for name in ["Picture A, pane 1", "Picture A, pane 2", "Picture B"] {
        assert!(window.has(Role::Canvas, name), "{name}");
    }
    assert_eq!(match_between(&mut window, second, b), selected);
    let row = selected.and_then(|index| window.results().pair.matches.as_ref()?.row(index).map(|row| *row.a));
    window.hover(pos_in(&window, first, &row.unwrap())).steps(2);
    assert_eq!(window.results().pair.hovered, selected);
    window.snapshot("two_bursts_split");
    let mut window = pair();
    window.click("Menu of pane 1").steps(3).click("Layout").steps(3).click("A, B and their difference").settle();
    let [a, b, difference] = shown(&window)[..] else { panic!("three panes") };
    assert_eq!(window.document().panes.get(difference).unwrap().content, Content::Difference(a, b));
    let plane = |id: PaneId| window.read().picture_in(id).unwrap().plane.clone();
    assert_eq!(plane(difference).at(90, 70), plane(a).at(90, 70) - plane(b).at(90, 70));
    window.snapshot("two_bursts_difference");
    // The pane of A with the picture of B over it.
    window.change(|document| document.panes.set_focus(a)).key(Key::W);
    assert_eq!(window.document().panes.over(a), Some(Over::Wipe { other: b, at: 0.5 }));
    window.settle();
    assert!(window.has(Role::Slider, "Wipe line"));
    window.key(Key::W).key(Key::Y);
    assert_eq!(window.document().panes.over(a), Some(Over::Flip { other: b, flipped: true }));
}

#[test]
fn matches_go_to_where_a_person_puts_the_panes() {
    let mut window = pair();
    window.key(Key::Home).settle();
    let selected = window.document().selected_match;
    let [a, b] = shown(&window)[..] else { panic!("A and B") };
    let middle = |window: &Window, id: PaneId| window.app().widgets.rect_ui(id).unwrap().center();
    assert!(middle(&window, a).x < middle(&window, b).x);
    // B is dragged by its name and dropped below A.
    let grip = window.app().widgets.rect_ui(b).unwrap().left_top() + vec2(40.0, 12.0);
    let target = window.app().widgets.rect_ui(a).unwrap().center_bottom() - vec2(0.0, 30.0);
    window.hover(grip).steps(1);
    window.harness.drag_at(grip);
    window.steps(1);
    for part in [0.1, 0.4, 0.7, 1.0] {
        window.hover(grip + part * (target - grip)).steps(2);
    }
    window.harness.drop_at(target);
    window.steps(4).settle();
    assert!(middle(&window, a).y < middle(&window, b).y, "B is below A now");
    assert_eq!(match_between(&mut window, a, b), selected);
    window.snapshot("two_bursts_stacked");
}
