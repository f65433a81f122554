//! Several methods on one burst.

use crate::support::*;
use burstscope::app::actions::ActionId;
use burstscope::detect;
use burstscope::detector::view::{dog_view, stack_view};
use burstscope::inspect::words::counted;

fn methods(second: bool) -> Window {
    let mut start = Start { size: [1400.0, 900.0], ..Start::default() };
    start.startup.second = second.then_some(BurstSource::DemoLater);
    let mut window = start.open();
    window.ctrl(Key::Num3).settle();
    window
}

#[test]
fn each_method_finds_what_the_library_finds() {
    let window = methods(false);
    let burst = window.opened().burst.clone();
    for method in [MethodId::Sift, MethodId::Merge, MethodId::Buff1d, MethodId::Buff2d] {
        let found = window.read().method_found(method, Side::A).unwrap();
        let expected =
            detect(&burst, &method.params(&window.document().params.at_given()), &Monitor::default()).unwrap();
        assert_eq!(found.detection.features, expected.features, "{method:?}");
        assert!(window.shows(&format!("{}  ·  {}", method.label(), counted(expected.features.len(), "feature"))));
        let name = format!("A: {}", method.label());
        assert!(window.has(Role::Canvas, &name), "{name}");
    }
    assert!(window.read().method_found(MethodId::Gold, Side::A).is_none());
}

#[test]
fn with_a_second_burst_matches_are_compared_and_a_method_switched_off_loses_its_pane() {
    let mut window = methods(true);
    let inliers = |method| window.read().method_matches(method).unwrap().result.counts.inliers.unwrap();
    assert!(inliers(MethodId::Buff1d) > 2 * inliers(MethodId::Sift), "a burst shows what one frame does not");
    assert!(window.shows(&inliers(MethodId::Buff1d).to_string()));
    // Side by side, lines are in proportion to the inliers: a picture full of lines has most of them.
    let most = MethodId::ALL.into_iter().filter(|of| window.read().method_matches(*of).is_some());
    let most = most.max_by_key(|of| inliers(*of)).unwrap();
    let lines = |of: MethodId| window.read().most_lines(Some(of)).unwrap();
    assert_eq!(lines(most), 40);
    assert_eq!(lines(MethodId::Sift), (40 * inliers(MethodId::Sift)).div_ceil(inliers(most)));
    window.click("Match lines").settle();
    assert_eq!(window.document().panes.arrangement().in_rows().len(), 4, "a row for each");
    assert!(window.has(Role::Canvas, "B: BuFF 1D"));
    let methods = |window: &Window| -> Vec<MethodId> {
        let panes = &window.document().panes;
        panes.shown().iter().filter_map(|id| panes.get(*id)?.method).collect()
    };
    let merge = "SIFT, merged";
    window.click_on(Role::CheckBox, merge).settle();
    let left = [MethodId::Sift, MethodId::Buff1d, MethodId::Buff2d];
    assert_eq!(methods(&window), left.into_iter().flat_map(|method| [method; 2]).collect::<Vec<_>>());
    window.click_on(Role::CheckBox, merge).settle();
    assert_eq!(methods(&window)[6..], [MethodId::Merge; 2], "in a row of its own");
    assert!(window.shows("matches are inliers"));
}

#[test]
fn a_wipe_is_dragged_and_a_flip_is_flipped() {
    let mut window = methods(false);
    window.click("Wipe").settle();
    let [left, right] = window.document().panes.shown()[..] else { panic!("two in one place") };
    let handle = window.rect(Role::Slider, "Wipe line").center();
    window.harness.drag_at(handle);
    window.steps(1).hover(handle + vec2(120.0, 0.0)).steps(1);
    window.harness.drop_at(handle + vec2(120.0, 0.0));
    window.steps(2);
    let over = window.document().panes.over(left);
    assert!(matches!(over, Some(Over::Wipe { other, at }) if other == right && at > 0.55), "{over:?}");
    let methods = |window: &Window| [left, right].map(|id| window.document().panes.get(id).unwrap().method.unwrap());
    assert_eq!(methods(&window), [MethodId::Sift, MethodId::Buff1d]);
    window.click_on(Role::ComboBox, "Right").steps(2).click("SIFT, merged").settle();
    assert_eq!(methods(&window), [MethodId::Sift, MethodId::Merge]);
    assert!(window.shows("SIFT, merged  ·  Merged frames"));
    window.key(Key::W).settle();
    assert!(window.shows("1  ·  SIFT, one frame  ·  Frame 5"));
    window.key(Key::Y).settle();
    assert!(window.shows("2  ·  SIFT, merged  ·  Merged frames"), "the other one is on show");
}

#[test]
fn a_pane_of_a_method_is_split_into_stack_and_dog() {
    let mut window = methods(false);
    let pane = |window: &Window, method: MethodId| window.document().panes.shown_of(Side::A, Some(method));
    let [own] = pane(&window, MethodId::Buff1d)[..] else { panic!("one pane") };
    let number = window.document().panes.number(own).unwrap();
    window.click(&format!("Split down {number}")).key(Key::Num3).settle();
    let [stack, dog] = pane(&window, MethodId::Buff1d)[..] else { panic!("two panes") };
    let burst = &window.opened().burst;
    let params = MethodId::Buff1d.params(&window.document().params.at_given());
    let plane = |id| window.read().picture_in(id).unwrap().plane.clone();
    let cursor = window.document().panes.get(dog).unwrap().cursor;
    let monitor = Monitor::default();
    assert_eq!(*plane(stack), stack_view(burst, &params, cursor.slope, &monitor).unwrap());
    assert_eq!(*plane(dog), dog_view(burst, &params, cursor.slope, cursor.octave, cursor.level, &monitor).unwrap());
    let name = format!("A: BuFF 1D, pane {}", window.document().panes.number(dog).unwrap());
    assert!(window.has(Role::Canvas, &name), "{name}");
    // The other panes switched to the DoG of their inputs.
    let [sift] = pane(&window, MethodId::Sift)[..] else { panic!("one pane") };
    let params = MethodId::Sift.params(&window.document().params.at_given());
    let plane = window.read().picture_in(sift).unwrap().plane.clone();
    let expected = dog_view(burst_of(&window), &params, cursor.slope, cursor.octave, cursor.level, &monitor).unwrap();
    assert_eq!(*plane, expected);
    window.snapshot("methods_split");
}

fn burst_of(window: &Window) -> &Burst {
    &window.opened().burst
}

#[test]
fn a_gold_standard_is_opened_and_methods_are_switched_in_the_table() {
    let folder = folder();
    let path = noisy_stack(&folder, 1, 360, 480);
    let mut window = methods(false);
    window.will_choose(&path).run_action("gold standard of a").settle();
    let found = window.read().method_found(MethodId::Gold, Side::A).unwrap();
    assert!(window.shows(&format!("Gold standard  ·  {} features", found.detection.features.len())));
    window.click_on(Role::CheckBox, "BuFF 2D").settle();
    assert!(!window.has(Role::Canvas, "A: BuFF 2D"));
}

#[test]
fn a_session_of_when_methods_were_a_workspace_compares_them_and_the_comparison_is_kept_in_a_session() {
    let (_folder, file) = folder_with("methods.burstscope.toml");
    let mut window = methods(false);
    window.click("Wipe").settle().will_choose(&file).run_action("save session").settle();
    let written = fs::read_to_string(&file).unwrap();
    let [workspace, tab, heading] = ["workspace = \"inspect\"", "bottom_tab = \"methods\"", "[document.methods]\n"];
    assert!([workspace, tab, heading].iter().all(|part| written.contains(part)), "{written}");
    let of_then = written.replace(workspace, "workspace = \"methods\"").replace(tab, "bottom_tab = \"tally\"");
    fs::write(&file, of_then.replace(heading, "[document.methods]\nfeatures = false\n")).unwrap();
    let mut other = Start { size: [1400.0, 900.0], ..Start::default() }.open();
    other.will_choose(&file).run_action("open session").settle();
    let [before, after] = [&window, &other].map(|window| window.document().clone());
    let (errors, panes) = (other.errors(), toml::to_string(&after.panes));
    assert!(after.compares_methods() && after.workspace == Workspace::Inspect, "{errors:?} {panes:?}");
    assert_eq!((after.panes.arrangement(), after.bottom_tab), (before.panes.arrangement(), BottomTab::Methods));
    assert!(other.shows("Match score"), "the table is open");
    // A recording of then names the action that opened it.
    let did: ActionId = serde_json::from_str("\"workspace_methods\"").unwrap();
    assert_eq!(did, ActionId::WorkspaceMethods);
    other.ctrl(Key::Num1).settle();
    assert_eq!(other.document().panes.shown().len(), 1, "the panes of one burst are as they were");
    let mut window = methods(false);
    window.key(Key::W).click_on(Role::CheckBox, "BuFF 2D").settle();
    let other = window.kept_and_opened_in(Start { size: [1400.0, 900.0], ..Start::default() }, &file);
    assert_eq!(other.document().methods, window.document().methods);
    let [before, after] = [&window, &other].map(|window| window.document().panes.arrangement().clone());
    assert_eq!((after.panes().len(), &after), (3, &before));
    assert!(other.has(Role::Slider, "Wipe line"));
}
