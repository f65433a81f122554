//! The figures of the paper, from the Help menu.

use crate::support::Start;
use burstscope::figures::{FigureSize, FiguresJob, PaperFigure};

#[test]
fn figures_of_the_paper_are_made_in_the_background_and_can_be_cancelled() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("paper");
    let mut window = Start::without_auto_detect().open();
    window.dialogs.will_choose(&out);
    window.run_action("figures of the paper");
    window.wait("figures are being made", |app| app.model.figures.is_pending());
    assert!(window.shows("Figures  "), "the status says how far they are");
    window.click("Cancel figures");
    let said = |words: &'static str| {
        move |app: &burstscope::app::BurstscopeApp| app.model.messages.last_note().is_some_and(|n| n.contains(words))
    };
    window.wait("they are cancelled", said("cancelled"));
    assert!(!window.app().model.figures.is_pending() && !out.join("index.html").exists());
    // One figure, with little material: the path to it is shown.
    let job = FiguresJob { out: out.clone(), only: vec![PaperFigure::Fig9], size: FigureSize::Quick, colmap: None };
    let app = window.app_mut();
    app.model.figures.ask(&app.engine, job);
    window.wait("it is there", said("index.html"));
    assert!(out.join("fig9.svg").is_file() && window.app().model.messages.errors().is_empty());
}
