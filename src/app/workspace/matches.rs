//! Matches of a whole dataset: choice of the pairs, the matrix, and the list of pairs.

use crate::app::actions::{ActionId, Queue, button_ui};
use crate::app::document::{Action, PairChoice};
use crate::app::panel::widgets::{section_ui, warning_ui};
use crate::app::workspace::{WorkspaceParts, left_panel, right_panel, side_width};
use crate::app::{dataset::filmstrip::working_ui, dataset::pairs};
use crate::app::{results::Read, workspace::pair::parameters};
use crate::inspect::words::counted;
use egui::{CentralPanel, DragValue, Frame, Label, Margin, RichText, Ui};

pub(super) fn matches_workspace_ui(ui: &mut Ui, parts: &mut WorkspaceParts<'_>) {
    let (model, WorkspaceParts { queue, .. }) = (parts.model, parts);
    let (Some(dataset), Some(set)) = (&model.results.datasets.open, &model.document.dataset) else {
        CentralPanel::default().show(ui, |ui| empty_ui(ui, model, queue));
        return;
    };
    if model.shows_left() {
        left_panel(ui, model, "matches left", side_width(model), |ui| {
            pairs_ui(ui, model, queue);
            selected_ui(ui, model, queue);
            next_ui(ui, model, queue);
            parameters::parameters_ui(ui, model, queue);
        });
    }
    let mut opened = None;
    if model.shows_right() {
        right_panel(ui, model, "matches right", 392.0, 280.0..=640.0, |ui| {
            opened = pairs::pair_list_ui(ui, dataset, set, queue);
        });
    }
    let ground = Frame::new().fill(ui.visuals().panel_fill);
    CentralPanel::default().frame(ground).show(ui, |ui| {
        ground.inner_margin(Margin::symmetric(8, 3)).show(ui, |ui| header_ui(ui, model));
        Frame::new().inner_margin(Margin::same(8)).show(ui, |ui| {
            opened = pairs::matrix_ui(ui, dataset, set, queue).or(opened);
        });
    });
    queue.push_if(opened.is_some(), ActionId::ShowPair);
}

fn empty_ui(ui: &mut Ui, model: Read<'_>, queue: &mut Queue) {
    ui.vertical_centered(|ui| {
        ui.add_space((ui.available_height() * 0.3).max(12.0));
        ui.label(RichText::new("Open a dataset").size(18.0).strong());
        ui.weak(
            "a folder of bursts, or a long sequence that is cut into bursts: all of them are matched with one another",
        );
        ui.add_space(10.0);
        button_ui(ui, model, queue, ActionId::OpenDataset, None);
    });
}

fn pairs_ui(ui: &mut Ui, model: Read<'_>, queue: &mut Queue) {
    section_ui(ui, "Pairs", |ui| {
        let PairChoice { neighbours, mut overlap, alike } = model.document.pairs;
        let (mut rule, mut partners) = ((neighbours, alike.is_some()), alike.unwrap_or(overlap));
        ui.radio_value(&mut rule, (false, false), "All pairs").on_hover_text("Each burst with every other one");
        let next = "Each burst with the next few, for a camera path that does not return";
        let most_alike = "Each burst with those in which most of its strongest features have their nearest: for a camera path that comes back, or bursts in no order";
        for (of, label, help, count) in [
            ((true, false), "Each with the next", next, &mut overlap),
            ((false, true), "Each with the most alike", most_alike, &mut partners),
        ] {
            ui.horizontal(|ui| {
                let label = ui.radio_value(&mut rule, of, label).on_hover_text(help);
                let field = DragValue::new(count).range(1..=100_000).suffix(" bursts");
                ui.add_enabled(rule == of, field).labelled_by(label.id);
            });
        }
        let (neighbours, alike) = (rule.0, rule.1.then_some(partners));
        queue.edit(model.document, Action::SetPairChoice(PairChoice { neighbours, overlap, alike }));
        ui.add_space(4.0);
        if model.results.datasets.work.is_some() {
            working_ui(ui, &model.results.datasets);
            button_ui(ui, model, queue, ActionId::CancelDataset, None);
        } else {
            ui.horizontal(|ui| {
                button_ui(ui, model, queue, ActionId::MatchPairs, None);
                button_ui(ui, model, queue, ActionId::DetectAll, None);
            });
        }
        let Some(dataset) = &model.results.datasets.open else { return };
        let (count, done) = (dataset.bursts.len(), dataset.counts().done);
        if done < count {
            let text = format!("{} of {count} bursts have no features yet; pairs with them are left out", count - done);
            warning_ui(ui, RichText::new(text).small());
        }
        if !dataset.matches.counts.is_empty() && dataset.matches.params != model.document.matching {
            let text = "The matching parameters changed; match again to update the matches";
            warning_ui(ui, RichText::new(text).small());
        }
    });
}

/// Draws the next step after the matches: the export, and once that is done the commands that reconstruct.
fn next_ui(ui: &mut Ui, model: Read<'_>, queue: &mut Queue) {
    section_ui(ui, "Next", |ui| {
        button_ui(ui, model, queue, ActionId::ExportDatabase, None);
        let Some((folder, knows_cameras)) = &model.results.datasets.exported else { return };
        let [make, map, python] = crate::requests::next_commands(folder, *knows_cameras);
        ui.add_space(4.0);
        for (name, line) in [("COLMAP", format!("{make} && {map}")), ("pycolmap", python)] {
            if ui.button(format!("Copy the line for {name}")).on_hover_text(&line).clicked() {
                ui.copy_text(line);
            }
        }
        button_ui(ui, model, queue, ActionId::OpenEstimate, None);
    });
}

fn selected_ui(ui: &mut Ui, model: Read<'_>, queue: &mut Queue) {
    section_ui(ui, "Selected pair", |ui| {
        let (Some(dataset), Some(set)) = (&model.results.datasets.open, &model.document.dataset) else { return };
        match set.selected() {
            Some(pair) => ui.add(Label::new(pairs::pair_text(dataset, pair)).wrap()),
            None => ui.weak("Click a cell of the matrix, or choose A and B in the filmstrip."),
        };
        ui.add_space(4.0);
        ui.horizontal(|ui| {
            button_ui(ui, model, queue, ActionId::MatchSelected, None);
            button_ui(ui, model, queue, ActionId::ShowPair, Some("Side by side"));
        });
    });
}

fn header_ui(ui: &mut Ui, model: Read<'_>) {
    let Some(dataset) = &model.results.datasets.open else { return };
    let matches = &dataset.matches;
    let verified = matches.listed().iter().filter(|(_, c)| c.inliers.is_some_and(|n| n > 0)).count();
    ui.horizontal(|ui| {
        ui.label(RichText::new(format!("Matches of {}", dataset.source.label())).strong());
        let text = format!("{} matched, {verified} of them verified", counted(matches.counts.len(), "pair"));
        ui.add(Label::new(RichText::new(text).weak()).truncate());
    });
    ui.horizontal(|ui| pairs::legend_ui(ui, matches.strongest()));
}
