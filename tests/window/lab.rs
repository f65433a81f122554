//! Lab: studies of charts, their curves, and the chart behind a point.

use crate::support::*;
use burstscope::evaluate::{BurstMethod, ChartStudy, RowStudy, curves::curves_table};
use burstscope::study::{Study, StudyReport};
use burstscope::synth::ChartParams;

/// A small chart, so that a study takes a second or two.
fn small_chart() -> ChartParams {
    ChartParams { width: 240, height: 180, discs: 12, radius: 3.6..=11.0, max_slope: 2.0, ..ChartParams::default() }
}

fn lab(size: [f32; 2]) -> Window {
    let mut window = Start { size, ..Start::automatic() }.open();
    go_to(&mut window);
    window
}

fn go_to(window: &mut Window) {
    window.run_action("lab");
    assert_eq!(window.document().workspace, Workspace::Lab);
    window.change(|document| document.lab.chart = small_chart()).change(|document| document.lab.seeds = 3);
    type_snrs(window, "0.5, 0.9, 1.8");
}

pub fn run_small_study(window: &mut Window) {
    go_to(window);
    run(window);
}

fn type_snrs(window: &mut Window, text: &str) {
    window.harness.get_by_role_and_label(Role::TextInput, "SNR").focus();
    window.steps(2).ctrl(Key::A).type_into("SNR", text).steps(2).key(Key::Enter);
}

fn run(window: &mut Window) {
    window.click("Run study");
    window.wait("the study is finished", |app| {
        !app.model.results.studies.wanted.is_pending()
            && app.model.results.studies.current.as_ref().is_some_and(|result| result.is_whole)
    });
    window.settle();
}

/// Study that the command runs with these settings.
fn expected() -> ChartStudy {
    ChartStudy {
        chart: small_chart(),
        snrs: vec![0.5, 0.9, 1.8],
        seeds: 3,
        methods: vec![BurstMethod::SiftFrame, BurstMethod::SiftMerge, BurstMethod::Buff1d],
        ..ChartStudy::default()
    }
}

#[test]
fn the_curves_are_the_numbers_of_the_command_and_a_point_shows_its_chart() {
    let mut window = lab([1280.0, 800.0]);
    run(&mut window);
    let report = expected().run(&Monitor::default()).unwrap();
    let result = window.results().studies.current.clone().unwrap();
    assert_eq!(result.study, Study::Chart(Box::new(expected())));
    assert_eq!(result.report, StudyReport::Chart(Box::new(report.clone())));
    for plot in result.report.plots(0) {
        let name = format!("Plot: {}, 3 curves", plot.title);
        assert!(window.has(Role::Image, &name), "{name}");
    }
    // A point is chosen, and its chart made again: the marks are those that were counted.
    window.click_on(Role::ComboBox, "Point").steps(2).click("SIFT, one frame, SNR 0.5").click("▶").settle();
    let score = &report.rows[0].methods[0].charts[1];
    let shown = window.read().current_chart().expect("a chart");
    assert_eq!((shown.of.seed, shown.looked.truth.features.len()), (score.seed, 12));
    assert!(window.shows(&format!("{} found", score.true_positives)));
    assert!(window.shows(&format!("{} missed", 12 - score.true_positives)));
    window.click_on(Role::CheckBox, "All detections").settle();
    assert!(window.shows(&format!("{} found", score.default_true_positives)));
    assert!(window.shows(&format!("{} false", score.default_false_features)));
    window.click_on(Role::CheckBox, "All detections").settle().snapshot("lab");
    window.click("Look at chart as burst").settle();
    assert_eq!(window.document().workspace, Workspace::Inspect);
    let frames = &window.opened().burst.frames;
    assert_eq!(frames.len(), 10);
    window.run_action("compare with the truth").settle();
    assert!(window.read().has_reference(Side::A, Reference::Truth));
    assert!(window.read().shown_comparison(Side::A).expect("a comparison").is_whole_truth);
}

#[test]
fn one_click_gives_every_method_the_same_false_rate() {
    let mut window = lab([1280.0, 800.0]);
    window.set().lab.methods.push(BurstMethod::Buff2d);
    run(&mut window);
    let result = window.results().studies.current.clone().unwrap();
    let rate = result.report.same_false_rate(window.document().lab.roc_row).expect("a rate");
    let of = |method| rate.of(method).expect("a threshold");
    assert!(of(BurstMethod::SiftFrame) > of(BurstMethod::Buff1d), "one frame has more noise");
    let before = window.document().params.peak_threshold;
    window.click("Search at 10 % false").settle();
    let (sift, buff_1d) = (MethodId::Sift, MethodId::Buff1d);
    for (method, expected) in [(sift, of(BurstMethod::SiftFrame)), (buff_1d, of(BurstMethod::Buff1d))] {
        assert_eq!(window.read().method_params(method, Side::A).peak_threshold, expected);
    }
    window.ctrl(Key::Num3).settle().click_on(Role::CheckBox, "At 10 % false on charts of SNR 0.5").settle();
    assert_eq!(window.document().methods.same_false_rate, None);
    // The search keeps that of its own method, which one step back takes away.
    let own = of(MethodId::of_search(&window.read().params_of(Side::A)).of_studies());
    assert_eq!(window.read().method_params(sift, Side::A).peak_threshold, own);
    window.run_action("undo");
    assert_eq!(window.document().params.peak_threshold, before);
}

#[test]
fn kept_curves_stay_beside_those_of_other_parameters() {
    let mut window = lab([1280.0, 800.0]);
    run(&mut window);
    window.click("Keep curves").change(|document| document.params.edge_threshold = 8.0);
    window.set().lab.methods = vec![BurstMethod::SiftMean];
    run(&mut window);
    assert_eq!(window.read().lab_results().len(), 2);
    assert!(window.has(Role::Image, "Plot: ROC at SNR 0.5, 4 curves"));
    window.snapshot("lab_kept_curves").click("Remove");
    assert!(window.results().studies.kept.is_empty());
    // A finished study is kept by itself when another one begins.
    window.set().lab.snrs_text = "0.9".to_owned();
    run(&mut window);
    assert_eq!((window.results().studies.kept.len(), window.read().lab_results().len()), (1, 2));
}

#[test]
fn a_study_is_cancelled_with_curves_nonsense_is_not_run_and_a_dark_copy_is_a_burst() {
    let mut window = lab([1280.0, 800.0]);
    window.change(|document| document.lab.seeds = 500).click("Run study");
    window.wait("some charts are finished", |app| app.model.results.studies.current.is_some());
    window.run_action("cancel study").wait("it has stopped", |app| !app.model.results.studies.wanted.is_pending());
    let result = window.results().studies.current.as_ref().unwrap();
    assert!(!result.is_whole && !result.report.plots(0).is_empty());
    assert!(window.shows("Curves so far"));
    assert!(window.results().studies.problem.is_none());
    type_snrs(&mut window, "0.5, dark");
    assert!(window.shows("'dark' is no ratio"));
    window.click("Run study");
    assert!(!window.results().studies.wanted.is_pending());
    let size = window.read().focused_size();
    window.change(|document| document.lab.dark_copy.snr = 0.4).run_action("dark copy of a").settle();
    assert!(window.opened().burst.name.contains("dark copy at SNR 0.4"));
    assert_eq!(window.read().focused_size(), size);
}

#[test]
fn errors_have_plots_of_their_own_and_are_written_as_a_table() {
    let mut window = lab([1280.0, 800.0]);
    window.click("Errors");
    type_snrs(&mut window, "1, 4");
    run(&mut window);
    let result = window.results().studies.current.clone().unwrap();
    let titles: Vec<String> = result.report.plots(0).into_iter().map(|plot| plot.title).collect();
    assert_eq!(titles, ["Errors of place", "Errors of scale", "Errors of slope"]);
    window.snapshot("lab_errors");
    let (_folder, path) = folder_with("errors.csv");
    window.will_choose(&path).run_action("export curves as csv").wait("it is written", |_| path.is_file());
    let written = fs::read_to_string(&path).unwrap();
    assert_eq!(written, curves_table(&[("This study".to_owned(), result.report.plots(usize::MAX))]).csv());
}

#[test]
fn the_number_of_frames_is_studied_on_charts_and_on_the_open_burst() {
    let mut window = lab([1280.0, 800.0]);
    window.click("Frames");
    assert!(window.shows("give one SNR"));
    type_snrs(&mut window, "0.9");
    window.set().lab.counts_text = "2, 4, 8".to_owned();
    run(&mut window);
    let study = ChartStudy { snrs: vec![0.9], frame_counts: vec![2, 4, 8], ..expected() };
    let report = StudyReport::Chart(Box::new(study.run(&Monitor::default()).unwrap()));
    assert_eq!(window.results().studies.current.as_ref().unwrap().report, report);
    window.snapshot("lab_frames");
    window.click("Frames of A");
    run(&mut window);
    let StudyReport::BurstFrames(report) = window.results().studies.current.clone().unwrap().report else {
        panic!("a report on the open burst");
    };
    assert_eq!(report.rows.iter().map(|row| row.frames).collect::<Vec<_>>(), [2, 4, 8]);
    assert!(report.discs.is_some_and(|discs| discs > 0), "the demo tells some of what is there");
    assert!(window.has(Role::Image, "Plot: Features of the middle frames of demo, 2 curves"));
    window.snapshot("lab_frames_of_burst");
    let (_folder, path) = folder_with("frames.svg");
    window.will_choose(&path).run_action("export curves as svg").wait("it is written", |_| path.is_file());
    assert!(fs::read_to_string(&path).unwrap().contains("confirmed by all frames"));
}
