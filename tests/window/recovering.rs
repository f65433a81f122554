//! Things planted in the open burst, the set-up from which slopes are computed, and cases.

use crate::support::{Start, Window};
use burstscope::app::project::BottomTab;
use burstscope::app::project::workspace::Workspace;
use burstscope::app::session::Session;
use burstscope::app::view::ColourBy;
use burstscope::detector::{DetectorParams, NoiseGate, SlopeChoice, SlopeGrid};
use burstscope::export::case::{Case, write_case};
use burstscope::inspect::set_up::SetUp;
use burstscope::inspect::study::StudyReport;
use burstscope::requests::BurstSource;
use burstscope::synth::{ChartParams, synth_chart};
use burstscope::{Burst, Monitor};
use egui::accesskit::Role;
use egui_kittest::kittest::Queryable;

/// A small burst of discs, and a search of few slopes.
fn small() -> (Burst, DetectorParams) {
    let chart = ChartParams { width: 240, height: 180, discs: 6, max_slope: 1.0, snr: 0.8, ..ChartParams::default() };
    let (burst, _) = synth_chart(&chart, &Monitor::default()).expect("a chart");
    let slopes = SlopeGrid::line(-1.0..=1.0, 5);
    (burst, DetectorParams { slopes, noise_gate: NoiseGate::Factor(5.0), ..DetectorParams::default() })
}

/// The window with the small burst as a case, with its search and a place to probe.
fn with_case(home: &std::path::Path) -> Window {
    let (burst, params) = small();
    let (case, part) = Case::of(&burst, &params.into(), Some([120.0, 90.0]), None, "a note");
    let path = home.join("night.burstcase");
    write_case(&path, &case, &part, &Monitor::default()).expect("written");
    let mut window = Start { size: [1280.0, 800.0], ..Start::automatic() }.open();
    window.dialogs.will_choose(&path);
    window.run_action("open files");
    window.settle();
    window
}

#[test]
fn a_case_opens_like_a_burst_with_its_search_and_its_place() {
    let home = tempfile::tempdir().expect("a folder");
    let mut window = with_case(home.path());
    let model = &window.app().model;
    let (burst, params) = small();
    assert_eq!(model.slots.a.burst.as_ref().expect("open").burst.frames, burst.frames);
    assert_eq!((model.params.slopes, model.slopes), (params.slopes, SlopeChoice::Given));
    assert_eq!(model.probe.place(), Some([120.0, 90.0]));
    // Saved again, it is the same case.
    let again = home.path().join("again.burstcase");
    window.dialogs.will_choose(&again);
    window.run_action("save case");
    window.wait("it is written", |_| again.is_file());
    window.settle();
    let read = burstscope::export::case::read_about(&again).expect("a case");
    assert_eq!((read.place, read.search.detector.slopes), (Some([120.0, 90.0]), params.slopes));
    let film = home.path().join("sweep.gif");
    window.dialogs.will_choose(&film);
    window.run_action("export film as gif");
    window.wait("it is written", |_| film.is_file());
}

#[test]
fn things_are_planted_in_the_open_burst_and_one_is_probed() {
    let home = tempfile::tempdir().expect("a folder");
    let mut window = with_case(home.path());
    window.run_action("lab");
    window.click("In this burst");
    window.app_mut().model.lab.planted.copies = 6;
    window.click("Run study");
    window.wait("the study is finished", |app| {
        !app.model.lab.wanted.is_pending() && app.model.lab.current.as_ref().is_some_and(|result| result.is_whole)
    });
    window.settle();
    let result = window.app().model.lab.current.clone().expect("a result");
    let StudyReport::Recover(report) = &result.report else { panic!("a report of planted things") };
    assert_eq!(report.copies_done, 6);
    let of_command = match &result.study {
        burstscope::inspect::study::Study::Recover(study, bursts) => {
            study.run(&bursts.burst, &Monitor::default()).expect("a report")
        }
        other => panic!("{other:?}"),
    };
    assert_eq!(report.planted, of_command.planted, "the numbers are those of the command");
    for title in ["SNR", "slope", "radius"] {
        assert!(window.shows(&format!("Planted things found against {title}")), "{title}");
    }
    window.click("Keep curves");
    assert_eq!(window.app().model.lab.shown_results().len(), 2);
    window.click("Next missed");
    window.settle();
    let thing = window.app().model.lab.selected_thing().expect("one was missed").clone();
    assert!(thing.found.is_none() && window.shows("Missed, "));
    window.snapshot("lab_in_this_burst");
    window.click("Probe planted thing");
    window.settle();
    let model = &window.app().model;
    assert_eq!(model.workspace, Workspace::Inspect);
    let source = &model.slots.a.burst.as_ref().expect("open").source;
    assert!(matches!(source, BurstSource::Planted { seed, .. } if *seed == thing.seed), "{source:?}");
    let place = model.probe.place().expect("probed");
    assert!((f64::from(place[0]) - thing.truth.u).abs() < 0.01 && (f64::from(place[1]) - thing.truth.v).abs() < 0.01);
}

#[test]
fn slopes_from_the_set_up_are_applied_as_the_command_computes_them() {
    let mut window = Start { size: [1280.0, 1000.0], ..Start::automatic() }.open();
    window.app_mut().model.bottom_tab = BottomTab::Slopes;
    window.settle();
    window.run_action("slopes from the set-up");
    window.settle();
    let expected = {
        let model = &window.app().model;
        model.set_up.values.slopes(10, &model.params).expect("valid").grid
    };
    window.harness.get_by_role_and_label(Role::Button, "Apply set-up").click();
    window.harness.run_steps(3);
    let model = &window.app().model;
    assert_eq!((model.params.slopes, model.slopes), (expected, SlopeChoice::Given));
}

#[test]
fn slopes_are_read_as_depths_in_the_table_and_as_colours() {
    let mut window = Start { size: [1280.0, 1000.0], ..Start::automatic() }.open();
    // A camera that moves to the left with 6 cm/s: 2.4 px/frame is 1 m.
    window.app_mut().model.set_up.values =
        SetUp { speed_m_s: 0.06, direction_deg: 180.0, depth_m: [0.5, 8.0], ..SetUp::default() };
    window.run_action("slopes from the set-up");
    window.settle();
    window.click("Read slopes as depths");
    window.settle();
    window.snapshot("slopes_from_set_up");
    window.app_mut().model.bottom_tab = BottomTab::Table;
    window.settle();
    window.click("Sort by Depth");
    window.settle();
    let model = &window.app().model;
    let depths: Vec<Option<f64>> =
        model.listed.iter().map(|&i| model.set_up.values.depth_at(model.features()[i].slope)).collect();
    let known = depths.iter().take_while(|depth| depth.is_some()).count();
    assert!(known > 10 && known < depths.len(), "features of both directions: {known} of {}", depths.len());
    assert!(depths[..known].is_sorted() && depths[known..].iter().all(Option::is_none));
    window.app_mut().model.colour_by = ColourBy::Depth;
    window.settle();
    assert!(window.shows("Legend: depth from 0.5 to 8 m"));
    // As a session it is kept; switched off, the colours show slopes again.
    let session = Session::of(&window.app().model).expect("a burst is open");
    assert_eq!(session.depths_by, Some(window.app().model.set_up.values));
    window.app_mut().model.bottom_tab = BottomTab::Slopes;
    window.settle();
    window.click("Read slopes as depths");
    window.settle();
    assert_eq!(window.app().model.colour_by, ColourBy::SlopeDirection);
}

#[test]
fn other_ways_to_add_frames_are_pictures_of_a_pane() {
    let mut window = Start { size: [1280.0, 800.0], ..Start::automatic() }.open();
    window.run_action("show median");
    window.settle();
    let median = window.app().model.picture().expect("a picture").plane.clone();
    window.run_action("show mean minus median");
    window.settle();
    let difference = window.app().model.picture().expect("a picture").plane.clone();
    assert_eq!(median.size(), difference.size());
    assert_ne!(median, difference);
    window.snapshot("mean_minus_median");
}
