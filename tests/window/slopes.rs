//! Slopes in the window: found automatically, as bars under the slider and in the tab with its advice; and the colours
//! by coherence, which show how evenly the frames respond along each feature's motion.

use crate::support::*;
use burstscope::{app::document::cursor::slope_limit, inspect::place::judged, synth::random::Stream};

fn grid(window: &Window) -> SlopeGrid {
    window.read().grid_of(Side::A)
}

fn is_auto(window: &Window) -> bool {
    window.document().params.slopes.is_auto()
}

#[test]
fn the_demo_opens_with_its_slopes_found_and_shown_and_presets_give_ranges_and_reset_all_finds_them() {
    let window = Start { size: [1280.0, 1000.0], ..Start::automatic() }.open();
    let found = window.found();
    let finding = found.finding.as_ref().unwrap();
    assert!(is_auto(&window) && finding.verdict == SlopeVerdict::Found);
    assert_eq!((grid(&window), found.params.slopes), (finding.grid, finding.grid));
    assert!(finding.grid.is_plane() && window.read().stale().is_none());
    let (u, v) = (finding.grid.u, finding.grid.v);
    let number = |x| burstscope::inspect::words::number(x, 3);
    let text =
        |name, axis: SlopeAxis| format!("{name} {} to {} in {} slopes", number(axis.min), number(axis.max), axis.count);
    assert!(window.shows(&format!("; found: {}, {}", text("u", u), text("v", v))));
    assert!(slope_limit(&window.results().slots.a.usable_params.slopes) >= finding.grid.max_magnitude());
    assert_eq!(window.results().slots.a.usable_params.slopes, finding.grid);
    let mut window = Start::automatic().open();
    window.choose("BuFF 2D ⏷", "Preset BuFF 1D").settle();
    assert_eq!((is_auto(&window), grid(&window)), (false, SlopeGrid::line(-3.0..=3.0, 7)));
    window.click("Reset all").settle();
    assert!(is_auto(&window) && grid(&window).is_plane());
}

#[test]
fn the_switch_gives_what_was_found_to_be_edited_and_a_reset_finds_it_again() {
    let mut window = Start { size: [1280.0, 1000.0], ..Start::automatic() }.open();
    let found = grid(&window);
    window.click_on(Role::CheckBox, "Auto slopes").settle();
    assert_eq!((is_auto(&window), grid(&window)), (false, found));
    assert!(window.found().finding.is_none());
    window.click("Reset Slopes").settle();
    assert_eq!((is_auto(&window), grid(&window)), (true, found));
    // A range edited by hand is given. Those that are found have no fields.
    assert!(!window.has(Role::SpinButton, "Slopes v"));
    window.click_on(Role::CheckBox, "Auto slopes").settle();
    window.harness.get_all_by_role_and_label(Role::SpinButton, "Slopes v").nth(2).unwrap().set_value_accesskit(3.0);
    window.settle();
    assert_eq!((is_auto(&window), grid(&window).v.count), (false, 3));
    assert_eq!((grid(&window).u, window.found().params.slopes.v.count), (found.u, 3));
}

#[test]
fn sessions_keep_the_switch_and_given_ranges() {
    let mut window = Start::automatic().open();
    let text = Session::of(window.read()).unwrap().to_toml();
    assert!(text.contains("slopes = \"auto\""), "{text}");
    let mut restored = Start::without_auto_detect().open();
    let model = &mut restored.app_mut().model;
    apply::staged::show_document(
        model,
        Session::from_toml(&text).unwrap().over_first(&model.document),
        Reselect::Feature(None),
    );
    assert!(is_auto(&restored));
    // Sessions of before had a choice beside the ranges, which were those found last where slopes were found.
    let old = |choice: &str| {
        let ranges = "[document.params.slopes.u]\nmin = -1.0\nmax = 1.0\ncount = 5\n";
        let text = format!("version = 4\nburst = \"demo\"\n[document.slopes.auto]\n{choice}{ranges}");
        Session::from_toml(&text).unwrap().document.params.slopes
    };
    assert_eq!((old(""), old("direction_deg = 30.0\n")), (Slopes::AUTO, Slopes::Auto { direction_deg: Some(30.0) }));
    let given = "version = 4\nburst = \"demo\"\n[document]\nslopes = \"given\"\n[document.params.slopes.u]\nmin = -1.0\nmax = 1.0\ncount = 5\n";
    let model = &mut window.app_mut().model;
    apply::staged::show_document(
        model,
        Session::from_toml(given).unwrap().over_first(&model.document),
        Reselect::Feature(None),
    );
    window.settle();
    assert!(!is_auto(&window));
    assert_eq!(grid(&window).u, SlopeAxis::new(-1.0..=1.0, 5));
    assert!(window.found().finding.is_none());
    assert_eq!(grid(&window).v.value(0.0), Slope::default().v);
}

fn colour_by_coherence(window: &mut Window) {
    window.click_on(Role::ComboBox, "Colour by").steps(4).click("Coherence");
}

#[test]
fn colours_tell_the_coherence_and_features_are_grey_until_it_is_known() {
    let mut window = Start { size: [1280.0, 800.0], ..Start::without_auto_detect() }.open();
    window.run_action("detect").settle();
    colour_by_coherence(&mut window);
    window.settle();
    let detection = window.found().detection.clone();
    let values = window.results().coherence.of(&detection).unwrap().clone();
    let cache = ProbeCache::new(&window.opened().burst, &window.read().asked(), &Monitor::default()).unwrap();
    assert_eq!(*values, judged(&cache.trail, &Monitor::default()).unwrap());
    assert!(window.shows("Legend: coherence from 0 to 1") && !window.shows("Grey: not computed yet"));
    assert_eq!(window.shows("Grey: too noisy to tell"), values.iter().any(|judged| judged.coherence.is_none()));
    let index =
        (0..values.len()).find(|&i| values[i].coherence.is_some_and(|c| c < 0.995)).expect("one is not quite even");
    let text = format!("{:.2}", values[index].coherence.unwrap());
    window.change(|document| document.selected = Some(index)).steps(2).settle();
    assert!(window.shows("Coherence") && window.shows(&text));
    let feature = detection.features[index];
    let at = window.ui_from_image(pos2(feature.u, feature.v)).unwrap();
    window.hover(at).steps(3);
    assert!(window.shows("\ncoherence "), "the pointer says it");
    window.snapshot("coherence");
    let (_folder, path) = folder_with("coherence.svg");
    window.change(|document| document.figure.legend = true).will_choose(&path).run_action("figure as before").settle();
    let svg = fs::read_to_string(&path).unwrap();
    let colours: BTreeSet<&str> = svg
        .lines()
        .filter(|line| line.contains("<circle"))
        .filter_map(|line| line.split("stroke=\"").nth(1)?.split('"').next())
        .collect();
    assert!(colours.len() > 5 && svg.contains(">0.75"), "{colours:?}");
    // Another detection has other values; unknown ones are grey, and choosing the quantity again restarts a cancelled
    // computation.
    window.change(|document| document.params.octaves = 2).run_action("detect").settle();
    let now = window.found().detection.clone();
    let model = &mut window.app_mut().model;
    assert!(model.results.coherence.of(&detection).is_none() && model.results.coherence.of(&now).is_some());
    model.results.coherence = Default::default();
    let missing = Read::of(model).missing_coherence(Side::A).expect("it is shown, and was forgotten");
    let app = window.app_mut();
    app.model.results.coherence.wanted.a.ask(&app.engine, missing);
    app.model.results.coherence.wanted.a.cancel();
    window.settle();
    assert!(window.shows("Grey: cancelled"));
    colour_by_coherence(&mut window);
    window.settle();
    assert!(window.results().coherence.of(&now).is_some() && !window.shows("Grey: cancelled"));
}

/// Writes many discs that all move by (2.5, 0), with noise, as a `.npy` stack.
pub fn fast(folder: &Path) -> PathBuf {
    let (height, width) = (150, 220);
    let mut stream = Stream::new(11, 0);
    let mut uniform = |n: usize| stream.uniform() as f32 * n as f32;
    let discs: Vec<(f32, f32)> = (0..60).map(|_| (uniform(width + 40) - 20.0, uniform(height))).collect();
    stack(folder, "fast.npy", (8, height, width), |(t, v, u)| {
        let light: f32 = discs
            .iter()
            .map(|(cu, cv)| {
                let d2 = (u as f32 - cu - 2.5 * t as f32).powi(2) + (v as f32 - cv).powi(2);
                if d2 < 200.0 { (-d2 / 18.0).exp() } else { 0.0 }
            })
            .sum();
        0.15 + 0.12 * light + 0.02 * stream.normal() as f32
    })
}

fn open() -> Window {
    let mut window = Start::at_slopes(&fast(&folder()), SlopeGrid::line(-1.0..=1.0, 5)).open();
    window.run_action("detect").settle();
    window
}

/// Opens the tab; slopes are analysed automatically, unless the detection took long.
fn look_at_slopes(window: &mut Window) {
    window.change(|document| document.bottom_tab = BottomTab::Slopes).settle();
    if window.shows("Analyse slopes") {
        window.click("Analyse slopes").settle();
    }
}

fn axis(window: &Window) -> SlopeAxis {
    grid(window).u
}

#[test]
fn too_narrow_a_range_is_told_and_one_click_widens_it() {
    let mut window = open();
    let slope = window.document().cursor().slope;
    look_at_slopes(&mut window);
    let spectrum = window.read().spectrum().unwrap().clone();
    let advice = &spectrum.advice[0];
    assert!(!advice.changes.is_empty() && window.shows("moves beyond the range"), "{advice:?}");
    assert!(window.shows(&advice.changes[0].label()) && window.shows("at the limit"));
    assert_eq!(window.document().cursor().slope, slope, "it never moves the slope by itself");
    window.snapshot("slopes_advice");
    let before = axis(&window);
    let sentence = advice.sentence.clone();
    window.change(|document| document.bottom_tab = BottomTab::Table).settle();
    assert!(window.shows(&sentence[1..]), "{sentence}");
    window.click("Apply slopes");
    assert!(axis(&window).max >= 2.5);
    window.ctrl(Key::Z);
    look_at_slopes(&mut window);
    window.click("Apply");
    let wider = axis(&window);
    assert!(wider.max >= 2.5 && wider.min > before.max, "straight to what was found: {wider:?}");
    assert!(!is_auto(&window));
    window.ctrl(Key::Z);
    assert_eq!(axis(&window), before, "it is undone as any change of a parameter");
    window.click("Apply").run_action("detect").settle();
    look_at_slopes(&mut window);
    let spectrum = window.read().spectrum().unwrap().clone();
    assert_eq!(spectrum.grid.u, wider, "the slopes are those of the new detection");
    assert!((spectrum.most_features().unwrap().u - 2.5).abs() < 0.6);
    let told = |spectrum: &burstscope::inspect::slopes::Spectrum| {
        spectrum.advice.iter().any(|a| a.subject == burstscope::inspect::slopes::AdviceSubject::Range)
    };
    assert!(!told(&spectrum), "{:?}", spectrum.advice);
    window.key(Key::B);
    assert!((window.document().cursor().slope.u - 2.5).abs() < 0.6);
}

#[test]
fn the_ends_of_the_range_are_dragged_below_the_slider_and_the_ends_of_a_range_far_from_0_lie_apart() {
    let mut window = open();
    assert!(window.harness.query_by_label("Features and evidence below the slider").is_some());
    let end = window.rect(Role::Slider, "Range end u").center();
    let start = window.rect(Role::Slider, "Range start u").center();
    // The distance from the middle to the end is 1 px/frame.
    let unit = 0.5 * (end.x - start.x);
    window.drag(end, end + vec2(unit, 0.0));
    assert_eq!(axis(&window), SlopeAxis { min: -1.0, max: 2.0, count: 7 }, "by whole steps");
    window.ctrl(Key::Z);
    assert_eq!(axis(&window), SlopeAxis { min: -1.0, max: 1.0, count: 5 }, "the drag is one step");
    let folder = folder();
    let mut window = Start::at_slopes(&fast(&folder), SlopeGrid::line(-4.95..=-3.15, 10)).open();
    let x = |name| window.rect(Role::Slider, name).center().x;
    assert!(x("Range end u") - x("Range start u") > 60.0);
    assert_eq!(window.document().cursor().slope.u, 0.0, "a slope beyond the slider is shown all the same");
    window.slide("Slope u", -4.0);
    assert_eq!(window.document().cursor().slope.u, -4.0);
}

#[test]
fn where_too_little_is_seen_the_verdict_has_the_number_that_noise_gives_and_a_plane_of_slopes_has_cells() {
    let (home, mut stream) = (folder(), Stream::new(1, 0));
    let path = stack(&home, "noise.npy", (9, 300, 400), |_| 0.2 + 0.05 * stream.normal() as f32);
    let mut window = Start::at_slopes(&path, SlopeGrid::line(-2.0..=2.0, 11)).open();
    window.change(|document| document.params.noise_gate = NoiseGate::Factor(3.8)).run_action("detect").settle();
    let decoys = window.read().decoys().expect("unasked").report.expected_words();
    assert!(window.shows("show too little to judge the slopes") && window.shows(&decoys), "{decoys}");
    let mut window = Start { size: [1280.0, 800.0], ..Start::automatic() }.open();
    look_at_slopes(&mut window);
    assert!(window.read().spectrum().unwrap().grid.is_plane());
    assert!(window.shows("Evidence by slope") && window.shows("Cost: "));
    assert!(window.harness.query_by_label("Features and evidence below the slider").is_none());
    window.snapshot("slopes_plane");
}
