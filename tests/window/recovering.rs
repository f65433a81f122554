//! Things planted in the open burst, the set-up from which slopes are computed, and cases.

use crate::support::*;
use burstscope::app::view::ColourBy;
use burstscope::export::case::{Case, Enclosed, read_session, read_truth, write_case};
use burstscope::inspect::slopes::SetUp;
use burstscope::study::StudyReport;
use burstscope::synth::{ChartParams, synth_chart};

/// A small burst of discs, and a search of few slopes.
fn small() -> (Burst, DetectorParams) {
    let chart = ChartParams { width: 240, height: 180, discs: 6, max_slope: 1.0, snr: 0.8, ..ChartParams::default() };
    let (burst, _) = synth_chart(&chart, &Monitor::default()).expect("a chart");
    let slopes = SlopeGrid::line(-1.0..=1.0, 5);
    (burst, DetectorParams { slopes, noise_gate: NoiseGate::Factor(5.0), ..DetectorParams::default() })
}

/// The window with the small burst as a case, with its search and a place to probe.
fn with_case() -> (Folder, Window) {
    let home = folder();
    let (burst, params) = small();
    let (case, part) = Case::of(&burst, &params.into(), (Some([120.0, 90.0]), None), "a note", &Monitor::default())
        .expect("nobody cancels");
    let path = home.join("night.burstcase");
    write_case(&path, (&case, &part), &Enclosed::default(), &Monitor::default()).expect("written");
    let mut window = Start { size: [1280.0, 800.0], ..Start::automatic() }.open();
    window.will_choose(&path).run_action("open files").settle();
    (home, window)
}

#[test]
fn a_case_opens_like_a_burst_and_a_damaged_one_is_said_once() {
    let (home, mut window) = with_case();
    let (burst, params) = small();
    assert_eq!(window.opened().burst.frames, burst.frames);
    assert_eq!(window.document().params.slopes, params.slopes.into());
    assert_eq!(window.read().probed_place(), Some([120.0, 90.0]));
    // Another ending is refused, as the file could not be opened again.
    window.will_choose(home.join("again.png")).run_action("save case").wait_for_error();
    assert!(window.shows("name the file .burstcase") && !home.join("again.png").exists());
    let again = home.join("again.burstcase");
    window.will_choose(&again).run_action("save case").wait("it is written", |_| again.is_file()).settle();
    let read = burstscope::export::case::read_about(&again).expect("a case");
    assert_eq!((read.place, read.search.slopes), (Some([120.0, 90.0]), params.slopes.into()));
    let (_home, path) = folder_with("damaged.burstcase");
    fs::write(&path, b"PK\x03\x04 and no more").expect("written");
    let mut window = Start::of(&path).open();
    let errors = window.errors();
    assert!(errors.len() == 1 && errors[0].text.contains("damaged.burstcase"), "{errors:?}");
    assert!(window.results().slots.a.burst.is_none());
    window.run_action("Open demo burst").settle();
    assert!(window.results().slots.a.burst.is_some());
}

#[test]
fn a_case_restores_the_view_in_which_it_was_saved() {
    let (home, mut window) = with_case();
    window.run_action("pin this result").settle();
    window.run_action("split right").change(|document| document.filter.hide_slope_limit = true);
    window.set().params.edge_threshold = 8.0;
    window.change(|document| document.lab.planted.copies = 3).settle();
    let before = window.document().panes.arrangement().in_rows();
    assert_eq!(before.iter().flatten().count(), 2);
    let kept = home.join("kept.burstcase");
    window.will_choose(&kept).run_action("save case").wait("it is written", |_| kept.is_file()).settle();
    let session = read_session(&kept).expect("read").expect("a session");
    assert!(!session.contains(&home.display().to_string()), "no path of this machine: {session}");
    let mut other = Start { size: [1280.0, 800.0], ..Start::automatic() }.open();
    other.will_choose(&kept).run_action("open files").settle();
    let (model, was) = (other.model(), window.model());
    assert_eq!(
        model.results.slots.a.burst.as_ref().expect("open").burst.frames,
        was.results.slots.a.burst.as_ref().expect("open").burst.frames
    );
    assert_eq!(model.document.panes.arrangement().in_rows(), before);
    assert!(model.document.filter.hide_slope_limit);
    assert_eq!((model.document.params.edge_threshold, model.document.lab.planted.copies), (8.0, 3));
    assert_eq!(Read::of(model).probed_place(), Some([120.0, 90.0]));
    let pinned = model.document.comparisons.a.pinned.as_ref();
    assert!(pinned.is_some_and(|pinned| pinned.edge_threshold != 8.0));
    assert_eq!(model.document.comparisons, was.document.comparisons);
    let shown = model.results.slots.a.comparison.shown.as_ref().expect("compared with the pinned result");
    assert_eq!(shown.summary, was.results.slots.a.comparison.shown.as_ref().expect("compared").summary);
    // What names other files is left out, also where a case was changed to have some.
    let hostile = session.replacen("[document]", "[document.gold.a]\npaths = [\"/etc/passwd\"]\n\n[document]", 1);
    let (case, part) =
        Case::of(&small().0, &small().1.into(), (None, None), "", &Monitor::default()).expect("nobody cancels");
    let path = home.join("hostile.burstcase");
    for text in [hostile, "not a session".to_owned()] {
        let enclosed = Enclosed { session: Some(text), truth: None };
        write_case(&path, (&case, &part), &enclosed, &Monitor::default()).expect("written");
        other.will_choose(&path).run_action("open files").settle();
        assert_eq!(other.opened().burst.sources, std::slice::from_ref(&path));
        assert!(!other.errors().iter().any(|error| error.text.contains("passwd")));
    }
    let errors = other.errors();
    assert!(errors.iter().any(|error| error.text.contains("hostile.burstcase")), "{errors:?}");
}

#[test]
fn a_film_says_its_size_and_rate_and_other_ways_to_add_frames_are_pictures_of_a_pane() {
    let (home, mut window) = with_case();
    window.run_action("export film").settle();
    assert!(window.shows("9 pictures of") && window.shows("10 a second: 0.9 s; about"));
    window.harness.get_by_label("Scales").click();
    window.settle();
    assert_eq!(window.document().film.content, FilmContent::Scales);
    assert!(!window.shows("9 pictures of"));
    window.set().film.content = FilmContent::Slopes;
    let path = home.join("sweep.gif");
    window.will_choose(&path).click("Export…").wait("it is written", |_| path.is_file()).settle();
    // The extension that gives each picture its time.
    let bytes = fs::read(&path).expect("a file");
    assert_eq!(bytes.windows(3).filter(|window| *window == [0x21, 0xf9, 4]).count(), 9);
    let mut window = Start { size: [1280.0, 800.0], ..Start::automatic() }.open();
    window.run_action("show median").settle();
    let median = window.read().picture().expect("a picture").plane.clone();
    window.run_action("show mean minus median").settle();
    let difference = window.read().picture().expect("a picture").plane.clone();
    assert_eq!(median.size(), difference.size());
    assert_ne!(median, difference);
    window.snapshot("mean_minus_median");
}

#[test]
fn things_are_planted_in_the_open_burst_and_one_is_probed() {
    let (home, mut window) = with_case();
    window.run_action("lab").click("In this burst").change(|document| document.lab.planted.copies = 6);
    window.click("Run study");
    window.wait("the study is finished", |app| {
        !app.model.results.studies.wanted.is_pending()
            && app.model.results.studies.current.as_ref().is_some_and(|result| result.is_whole)
    });
    window.settle();
    let result = window.results().studies.current.clone().expect("a result");
    let StudyReport::Recover(report) = &result.report else { panic!("a report of planted things") };
    assert_eq!(report.copies_done, 6);
    let of_command = match &result.study {
        burstscope::study::Study::Recover(study, bursts) => {
            study.run(&bursts.burst, &Monitor::default()).expect("a report")
        }
        other => panic!("{other:?}"),
    };
    assert_eq!(report.planted, of_command.planted, "the numbers are those of the command");
    for title in ["SNR", "slope", "radius"] {
        assert!(window.shows(&format!("Planted things found against {title}")), "{title}");
    }
    window.click("Keep curves");
    assert_eq!(window.read().lab_results().len(), 2);
    window.click("Next missed").settle();
    let thing = window.read().selected_thing().expect("one was missed").clone();
    assert!(thing.found.is_none() && window.shows("Missed, "));
    window.snapshot("lab_in_this_burst").click("Probe planted thing").settle();
    assert_eq!(window.document().workspace, Workspace::Inspect);
    let source = &window.opened().source;
    assert!(matches!(source, BurstSource::Planted { seed, .. } if *seed == thing.seed), "{source:?}");
    let place = window.read().probed_place().expect("probed");
    assert!((f64::from(place[0]) - thing.truth.u).abs() < 0.01 && (f64::from(place[1]) - thing.truth.v).abs() < 0.01);
    window.run_action("detect").settle().run_action("compare with the truth").settle();
    let against = &window.results().slots.a.comparison;
    assert_eq!(window.document().comparisons.a.with, Some(Reference::Truth));
    let of_copy = report.planted.iter().filter(|one| one.seed == thing.seed);
    // One that is found at a wrong motion only is not found for the truth, which says so.
    let found = of_copy.clone().filter(|one| one.found.is_some()).count();
    let shown = against.shown.as_ref().expect("compared").summary.clone();
    let (told, rest) = shown.split_once(&format!(" of {} found", of_copy.count())).expect("counted");
    let told: usize = told.parse().expect("a number");
    assert!(told == found || told < found && rest.contains("wrong motion"), "{found} planted found, {shown}");
    let kept = home.join("planted.burstcase");
    window.will_choose(&kept).run_action("save case").wait("it is written", |_| kept.is_file()).settle();
    assert_eq!(read_truth(&kept).expect("read").expect("a truth").seed, thing.seed);
    window.will_choose(&kept).run_action("open files").settle();
    let against = &window.results().slots.a.comparison;
    let (found, _) = shown.split_once(" missed").expect("counted");
    assert!(against.shown.as_ref().is_some_and(|against| against.summary.starts_with(found)), "{shown}");
}

#[test]
fn slopes_from_the_set_up_are_applied_as_the_command_computes_them() {
    let mut window = Start { size: [1280.0, 1000.0], ..Start::automatic() }.open();
    window.change(|document| document.bottom_tab = BottomTab::Slopes).settle();
    window.run_action("slopes from the set-up").settle();
    let expected = {
        window
            .model()
            .document
            .set_up
            .values
            .slopes(&window.read().used_positions(), &window.document().params.at_given())
            .expect("valid")
            .grid
    };
    window.click_on(Role::Button, "Apply set-up").steps(3);
    assert_eq!(window.document().params.slopes, expected.into());
}

#[test]
fn slopes_are_read_as_depths_in_the_table_and_as_colours() {
    let mut window = Start { size: [1280.0, 1000.0], ..Start::automatic() }.open();
    // A camera that moves to the left with 6 cm/s: 2.4 px/frame is 1 m.
    window.set().set_up.values =
        SetUp { speed_m_s: 0.06, direction_deg: 180.0, depth_m: [0.5, 8.0], ..SetUp::default() };
    window.run_action("slopes from the set-up").settle().click_on(Role::CheckBox, "Read slopes as depths").settle();
    window.snapshot("slopes_from_set_up").change(|document| document.bottom_tab = BottomTab::Table).settle();
    window.click("Sort by Depth").settle();
    let depth_of = |i: &usize| {
        window.document().set_up.values.depth_at(window.read().features()[*i].motion().0).map(|metres| metres as f32)
    };
    let depths: Vec<Option<f32>> = window.results().listed.iter().map(depth_of).collect();
    let known = depths.iter().take_while(|depth| depth.is_some()).count();
    assert!(known > 10 && known < depths.len(), "features of both directions: {known} of {}", depths.len());
    assert!(depths[..known].is_sorted() && depths[known..].iter().all(Option::is_none));
    window.change(|document| document.colour_by = ColourBy::Of(Quantity::Depth)).settle();
    assert!(window.shows("Legend: depth from 0.5 to 8 m"));
    // As a session it is kept; switched off, the colours show slopes again.
    assert_eq!(Session::of(window.read()).expect("a burst is open").document.set_up, window.document().set_up);
    window.change(|document| document.bottom_tab = BottomTab::Slopes).settle();
    window.click_on(Role::CheckBox, "Read slopes as depths").settle();
    assert_eq!(window.document().colour_by, ColourBy::SlopeDirection);
}
