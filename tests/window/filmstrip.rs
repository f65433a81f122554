//! Filmstrip of a dataset: the text and look of each cell.

use crate::datasets::{click_burst, start, walk};
use crate::support::{Start, Window};
use burstscope::app::project::datasets::BurstState;
use egui_kittest::kittest::Queryable;

#[test]
fn filmstrip() {
    let home = tempfile::tempdir().unwrap();
    let source = walk(home.path());
    std::fs::write(home.path().join("film/frame_012.png"), "broken").unwrap();
    let mut window = start(source).open();
    window.click("Detect all");
    window.settle();
    click_burst(&mut window, "Use frame_002 as A");
    click_burst(&mut window, "Use frame_007 as B");
    let model = &mut window.app_mut().model;
    let dataset = model.datasets.open.as_mut().unwrap();
    // Times, and the place of this test's files, differ from run to run.
    for state in &mut dataset.states {
        if let BurstState::Done(finished) = state {
            finished.seconds = Some(0.3);
        }
    }
    dataset.folder = Some("/data/film-burstscope-5".into());
    model.messages.note("2 bursts done");
    window.snapshot("filmstrip");
}

/// Whether the line below the picture of the burst with this label has a green mark.
fn has_green_mark(window: &mut Window, label: &str) -> bool {
    let cell = window.harness.get_by_label_contains(label).rect();
    let image = window.harness.render().expect("a picture");
    let (columns, rows) =
        (cell.left() as u32..cell.left() as u32 + 16, cell.bottom() as u32 - 16..cell.bottom() as u32);
    let is_green = |[r, g, b, _]: [u8; 4]| i32::from(g) > i32::from(r) + 40 && i32::from(g) > i32::from(b) + 20;
    rows.into_iter().any(|y| columns.clone().any(|x| is_green(image.get_pixel(x, y).0)))
}

#[test]
fn a_burst_without_features_is_not_marked_as_good() {
    let home = tempfile::tempdir().unwrap();
    let source = walk(home.path());
    let detected = |start: Start| {
        let mut window = start.open();
        window.click("Detect all");
        window.settle();
        window
    };
    let mut window = detected(start(source));
    assert!(has_green_mark(&mut window, "Burst frame_002: "), "with features it is");
    let other = tempfile::tempdir().unwrap();
    let mut strict = start(walk(other.path()));
    strict.startup.params.detector.peak_threshold = 0.9;
    let mut window = detected(strict);
    assert!(window.shows("Burst frame_002: no features") && window.shows("3 bursts, 3 done"));
    assert!(!has_green_mark(&mut window, "Burst frame_002: no features"));
}
