//! The Help menu: its two failure cases, each with the probe on the place that shows it; the glossary, opened from the
//! menu, from a caption, from a parameter's tooltip, and searched; the figures of the paper.

use crate::{flat, probe::answer, steps_back::copied, support::*};
use burstscope::figures::{FigureSize, FiguresJob, PaperFigure};
use burstscope::inspect::place::SuspicionKind;
use burstscope::synth::examples::{ALIASING_SLOPE, GARLAND_PERIOD};

fn example(example: Example) -> Window {
    let mut start = Start { size: [1280.0, 800.0], ..Start::automatic() };
    start.startup.source = Some(BurstSource::Example(example));
    start.open()
}

#[test]
fn an_example_opens_probed_and_a_remedy_is_applied_and_taken_back() {
    let mut window = example(Example::LowContrast);
    assert_eq!(answer(&window).probe.pos_image, Example::LowContrast.place());
    assert!(!window.document().params.slopes.is_auto());
    assert!(window.shows("Nothing was kept here") && window.shows("Below the noise gate"), "it is said at once");
    let first = answer(&window).probe.subject_fate().expect("a candidate").remedy.clone().expect("a remedy");
    assert!(window.shows(&first.change.label()) && first.then_fails.is_none(), "and what would keep it");
    window.snapshot("probe_low_contrast");
    let fates = answer(&window).probe.fates.clone();
    let lost = fates
        .iter()
        .position(|fate| {
            fate.first_failed == Some(Test::NoiseGate) && fate.remedy.as_ref().is_some_and(|r| r.then_fails.is_none())
        })
        .expect("a candidate that only the gate takes");
    assert!(lost < 6, "it is among the first that came far: {lost}");
    let name = format!("Candidate {}: noise gate", lost + 1);
    window.harness.query_all_by_label_contains(&name).next().expect("it is listed").click();
    window.steps(2).settle();
    assert_eq!(answer(&window).probe.subject_fate().map(|f| f.of_sample()), Some(fates[lost].of_sample()));
    assert!(window.shows("Below the noise gate"));
    let (before, change) = (window.document().params.clone(), fates[lost].remedy.clone().unwrap().change);
    window.click(&format!("Apply {}", change.label())).settle();
    let gate = window.document().params.noise_gate;
    assert!(matches!(gate, NoiseGate::Factor(_)) && gate != before.noise_gate);
    let now = answer(&window);
    assert!(!window.read().probe_is_stale());
    let fate = now.probe.fates.iter().find(|f| f.of_sample() == fates[lost].of_sample()).expect("the same candidate");
    assert_ne!(fate.first_failed, Some(Test::NoiseGate));
    window.ctrl(Key::Z).settle();
    assert_eq!(window.document().params, before);
    assert_eq!(window.found().params.noise_gate, before.noise_gate);
    // Another burst is searched at slopes that are found in it.
    window.run_action("open demo burst").settle();
    assert!(window.document().params.slopes.is_auto() && window.read().probed_place().is_none());
}

#[test]
fn the_garlands_open_on_an_alias_with_its_evidence() {
    let mut window = example(Example::Aliasing);
    let probed = &answer(&window).probe;
    assert_eq!(probed.pos_image, Example::Aliasing.place());
    let fate = probed.subject_fate().expect("a candidate").clone();
    assert!(fate.is_kept() && (fate.slope.u - Example::Aliasing.slope_u()).abs() < 0.5, "{fate:?}");
    let alias = probed.suspicions.iter().find(|s| s.kind == SuspicionKind::Alias).expect("an alias").clone();
    // The object that really moves there responds more strongly, one period of the texture away.
    let other = alias.other_slope.expect("another slope");
    assert!((other.u - ALIASING_SLOPE).abs() < 0.2 && alias.number > 1.0, "{alias:?}");
    assert!(window.shows("Alias?") && window.shows("repeats every 8 px"), "it is said at once");
    // The picture is that of a slope at which nothing moves, and yet the garlands are sharp.
    let slope = window.document().cursor().slope;
    assert_eq!((slope.u, slope.v), (ALIASING_SLOPE - GARLAND_PERIOD, 0.0));
    assert_eq!(Example::Aliasing.slope_u(), slope.u);
    window.snapshot("probe_aliasing");
    // With other parameters the place is probed again.
    window.change(|document| document.params.edge_threshold = 10.0).settle();
    assert_eq!(answer(&window).probe.pos_image, Example::Aliasing.place());
    // With other slopes and octaves the probe answers too.
    let mut start = Start::default();
    start.startup.params.first_octave = 1;
    start.startup.source = Some(BurstSource::Example(Example::Aliasing));
    assert_eq!(answer(&start.open()).probe.pos_image, Example::Aliasing.place());
}

#[test]
fn the_glossary_is_opened_searched_and_led_to_by_links_of_captions_and_tooltips() {
    let mut window = flat::open([1280.0, 800.0]);
    window.harness.key_press_modifiers(Modifiers::SHIFT, Key::F1);
    window.steps(3);
    assert!(window.shows("Alias"), "all words");
    window.type_into("Search the glossary", "noise gate").steps(3);
    assert!(window.shows("Noise gate") && !window.shows("Alias"));
    window.snapshot("flat/glossary");
    window.harness.key_press(Key::Escape);
    window.steps(3);
    let field = window.harness.query_by_role_and_label(Role::TextInput, "Search the glossary");
    assert!(field.is_none(), "Escape closes the window from its search field");
    let mut window = Start { size: [1280.0, 800.0], ..Start::nothing_open() }.open();
    window.app_mut().start_lesson(built_in()[0].clone());
    window.settle().click_on(Role::Link, "burst").steps(4);
    assert!(window.shows("Search the glossary") && window.shows("A few frames taken right after one another"));
    assert!(window.app().lessons.open.is_some(), "the lesson stays");
    let mut window = Start { size: [1280.0, 800.0], ..Start::without_auto_detect() }.open();
    follow_the_tooltip(&mut window, Role::Label, "Noise gate", "Noise gate");
    assert!(window.shows("Min |response| in standard deviations of the noise in D"));
}

/// Hovers over a widget until its tooltip appears, and follows the link in it.
fn follow_the_tooltip(window: &mut Window, role: Role, label: &str, word: &str) {
    let rect = window.harness.get_all_by_role_and_label(role, label).next().expect("its row").rect();
    window.hover(rect.center()).steps(40).click_on(Role::Link, &format!("Glossary: {word}")).steps(4);
}

#[test]
fn tooltips_of_kinds_of_picture_of_sliders_and_of_columns_lead_to_their_words() {
    let open = || Start { size: [1280.0, 800.0], ..Start::default() }.open();
    let cases = [
        (Role::Button, "DoG", "DoG", "Difference of Gaussians: the image at the next level of blur"),
        (Role::Button, "Sort by SNR", "Signal-to-noise ratio", "A signal over the standard deviation of its noise"),
        (Role::Label, "Octave", "Octave", "of the one before on each side"),
    ];
    for (role, label, word, meaning) in cases {
        let mut window = open();
        window.key(Key::Num3).settle();
        follow_the_tooltip(&mut window, role, label, word);
        assert!(window.shows(meaning), "{word}");
    }
    let mut window = open();
    window.click("Menu of pane");
    follow_the_tooltip(&mut window, Role::RadioButton, "Coverage", "Coverage");
    assert!(window.shows("Share of the frames that see a place"));
}

#[test]
fn figures_of_the_paper_are_made_in_the_background_and_can_be_cancelled() {
    let (_folder, out) = folder_with("paper");
    let mut window = Start::without_auto_detect().open();
    window.will_choose(&out).run_action("figures of the paper");
    window.wait("figures are being made", |app| app.model.results.figures.is_pending());
    assert!(window.shows("Figures  "), "the status says how far they are");
    window.click("Cancel figures");
    let said = |words: &'static str| {
        move |app: &burstscope::app::BurstscopeApp| {
            app.model.shell.messages.note.as_ref().is_some_and(|n| n.contains(words))
        }
    };
    window.wait("they are cancelled", said("cancelled"));
    assert!(!window.results().figures.is_pending() && !out.join("index.html").exists());
    let job = FiguresJob { out: out.clone(), only: vec![PaperFigure::Fig9], size: FigureSize::Quick, colmap: None };
    let app = window.app_mut();
    app.model.results.figures.ask(&app.engine, job);
    window.wait("it is there", said("index.html"));
    assert!(out.join("fig9.svg").is_file() && window.errors().is_empty());
}

#[test]
fn about_lists_the_software_of_others_and_copies_its_licences_and_how_to_cite_is_copied_and_says_so() {
    let notices = include_str!("../../assets/THIRD-PARTY.txt");
    let packages = notices.lines().filter(|line| line.matches(" | ").count() == 3).count() - 1;
    let mut window = Start::nothing_open().open();
    window.run_action("about burstscope");
    assert!(window.shows("MIT or Apache-2.0, at your option.") && !window.shows("accesskit "));
    window.click_on(Role::DisclosureTriangle, "Software of others").steps(30);
    assert!(packages > 300 && window.shows(&format!("{packages} packages, under licences of their own")));
    // The list is long: what is not in sight is not drawn.
    assert!(window.shows("accesskit ") && window.shows("MIT OR Apache-2.0") && !window.shows("zvariant "));
    let button = |window: &mut Window| window.harness.get_by_role_and_label(Role::Button, "Copy licences").click();
    assert_eq!(copied(&mut window, button), [notices]);
    let mut window = Start::nothing_open().open();
    window.run_action("how to cite");
    assert!(window.shows("Copied the program and the paper as BibTeX"));
}
