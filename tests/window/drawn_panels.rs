//! Panels by themselves, each drawn from documents that nobody would make.

use crate::support::*;
use burstscope::app::{dataset, panel::*, results::Model, workspace};
use egui::Ui;

type Drawing = fn(&mut Ui, Read<'_>, &mut Queue);

const PANELS: &[(&str, Drawing)] = &[
    ("toolbar", toolbar::toolbar_ui),
    ("workspaces", workspace::switch_ui),
    ("cursor", cursor::cursor_ui),
    ("plane of slopes", cursor::slope_pad_ui),
    ("strip", |ui, model, queue| cursor::strip_ui(ui, model, false, queue)),
    ("parameters", parameters::parameters_ui),
    ("display", |ui, model, queue| display::display_ui(ui, model, &mut Default::default(), true, queue)),
    ("ranges", |ui, model, queue| display::display_ui(ui, model, &mut Default::default(), false, queue)),
    ("selection", selection::selection_ui),
    ("steps of the selection", selection::walk_ui),
    ("probe", |ui, model, queue| {
        probe::probe_tab_ui(ui, model, "Display", "The other tab", queue);
    }),
    ("bottom", |ui, model, queue| {
        bottom::bottom_ui(ui, model, &Default::default(), queue);
    }),
    ("closed bottom", bottom::closed_ui),
    ("table", table::table_ui),
    ("filter", table::filter_bar_ui),
    ("samples", tally::tally_ui),
    ("selected candidate", tally::selected_ui),
    ("slopes", slopes::slopes_ui),
    ("verdict on the slopes", slopes::verdict_ui),
    ("noise", noise::noise_ui),
    ("comparison", |ui, model, queue| against::against_ui(ui, model, &Default::default(), queue)),
    ("Lab", lab::lab_settings_ui),
    ("curves", lab::curves::curves_ui),
    ("chart of the Lab", lab::chart::lab_chart_ui),
    ("status", |ui, model, queue| {
        status::status_ui(ui, model, None, queue);
    }),
    ("methods", methods::table_ui),
    ("trajectories", dataset::cameras::plane_ui),
    ("points of cameras", dataset::cameras::points_strip_ui),
    ("cameras", dataset::cameras::camera_list_ui),
    ("errors of trajectories", dataset::errors_panel::errors_panel_ui),
    ("bursts", |ui, model, queue| dataset::filmstrip::filmstrip_ui(ui, model, &mut Default::default(), queue)),
];

/// Documents of a new window, of one whose values make no sense, and of one that speaks of what is not there.
fn documents() -> [Document; 3] {
    let plain = Document::of_new_window();
    let mut invalid = plain.clone();
    (invalid.params.levels, invalid.params.slopes) = (0, SlopeGrid::line(2.0..=-1.0, 0).into());
    invalid.matching.ratio = -3.0;
    let mut absent = plain.clone();
    (absent.selected, absent.selected_match, absent.asked_about) = (Some(9999), Some(9999), Some(9999));
    (absent.shown_test, absent.selected_candidate) = (Some(Test::NoiseGate), Some(9999));
    (absent.probe.is_open, absent.probe.near_sigma) = (true, Some(2.0));
    absent.comparisons.a.with = Some(Reference::Pinned);
    (absent.trajectories.selected, absent.bottom_tab) = (Some(9999), BottomTab::Compared);
    (absent.order.column, absent.set_up.is_open) = (Quantity::Depth, true);
    [plain, invalid, absent]
}

fn drawn(panel: Drawing, model: Model) -> Harness<'static, (Model, Vec<Action>)> {
    let draw = move |ui: &mut Ui, (model, pushed): &mut (Model, Vec<Action>)| {
        let mut queue = Queue::default();
        panel(ui, Read::of(model), &mut queue);
        pushed.extend(queue.0);
    };
    Harness::builder().with_size([900.0, 700.0]).build_ui_state(draw, (model, Vec::new()))
}

#[test]
fn each_panel_draws_any_document_and_changes_nothing_by_itself() {
    for document in documents() {
        for (name, panel) in PANELS {
            let mut harness = drawn(*panel, Model::from(document.clone()));
            harness.run_steps(3);
            let pushed = &harness.state().1;
            assert!(pushed.is_empty(), "{name}: {pushed:?}");
        }
    }
}
