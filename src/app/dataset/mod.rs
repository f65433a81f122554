//! Many bursts: [`filmstrip`], matching [`pairs`], trajectories ([`cameras`], [`errors_panel`]); and the questions
//! before work on them: whether and how a film is cut, and whether features may be replaced.

pub mod cameras;
pub mod errors_panel;
pub mod filmstrip;
pub mod pairs;

use crate::app::actions::{ActionId, Queue};
use crate::app::document::Action;
use crate::app::panel::widgets::{accept_ui, confirm_ui, modal_ui};
use crate::app::results::Datasets;
use crate::burst::SequenceCut;
use crate::dataset::DatasetSource;
use crate::inspect::words::counted;
use egui::{DragValue, Grid, RichText, Ui};
use std::path::PathBuf;

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CutDialog {
    paths: Vec<PathBuf>,
    frames: usize,
    length: usize,
    contiguous: bool,
    step: usize,
}

impl CutDialog {
    /// Asks how the `frames` frames (2 or more) at `paths` are cut, beginning with bursts of `length` frames.
    pub fn new(paths: Vec<PathBuf>, frames: usize, length: usize) -> Self {
        let length = length.clamp(1, frames.max(1));
        Self { paths, frames, length, contiguous: true, step: length }
    }

    /// Draws the dialog. Returns the dataset when it was accepted, and whether the dialog stays open.
    pub fn ui(&mut self, ctx: &egui::Context) -> (Option<DatasetSource>, bool) {
        let (mut accepted, mut stays) = (None, true);
        modal_ui(ctx, &mut stays, ("cut sequence", 400.0, "Cut a sequence into bursts"), |ui| {
            let place = self.paths.first().map_or_else(String::new, |p| p.display().to_string());
            ui.weak(format!("{}: {place}", counted(self.frames, "frame")));
            ui.add_space(6.0);
            self.rows_ui(ui);
            ui.add_space(6.0);
            ui.label(self.consequence());
            ui.add_space(6.0);
            if accept_ui(ui, "Cut", true).clicked() || ui.input(|i| i.key_pressed(egui::Key::Enter)) {
                accepted = Some(self.source());
                ui.close();
            }
        });
        (accepted, stays)
    }

    fn rows_ui(&mut self, ui: &mut Ui) {
        Grid::new("cut").num_columns(2).show(ui, |ui| {
            let label = ui.label("Burst length").on_hover_text("Frames of each burst");
            ui.add(DragValue::new(&mut self.length).range(1..=self.frames).suffix(" frames")).labelled_by(label.id);
            ui.end_row();
            let help = "Frames from the start of a burst to the start of the next";
            let label = ui.label("Burst step").on_hover_text(help);
            ui.horizontal(|ui| {
                ui.checkbox(&mut self.contiguous, "one after another");
                let field = DragValue::new(&mut self.step).range(1..=self.frames).suffix(" frames");
                ui.add_enabled(!self.contiguous, field).labelled_by(label.id);
            });
            ui.end_row();
        });
        if self.contiguous {
            self.step = self.length;
        }
    }

    fn source(&self) -> DatasetSource {
        DatasetSource {
            paths: self.paths.clone(),
            burst_length: Some(self.length),
            burst_step: (!self.contiguous).then_some(self.step),
        }
    }

    fn consequence(&self) -> String {
        let count = SequenceCut::new(self.length, Some(self.step)).map_or(0, |cut| cut.ranges(self.frames).len());
        let used = (count.max(1) - 1) * self.step + self.length;
        let rest = match self.frames.saturating_sub(used) {
            0 => String::new(),
            1 => "; the last frame is left out".to_owned(),
            rest => format!("; the last {rest} frames are left out"),
        };
        format!("{}, each named after its middle frame{rest}", counted(count, "burst"))
    }
}

/// Offers to cut a film into bursts of `length` frames; returns whether it is to be kept as one burst.
pub fn cut_offer_ui(ui: &mut Ui, frames: usize, length: usize, queue: &mut Queue) -> bool {
    let offer = ui.horizontal_wrapped(|ui| {
        let text = format!("{} are long for one burst: nothing moves evenly for so long.", counted(frames, "frame"));
        ui.label(RichText::new(text).color(crate::app::style::warning(ui)));
        let mut choice = |text: &str, tip: &str| ui.button(text).on_hover_text(tip).clicked();
        let cut = format!("Cut into bursts of {length}");
        queue.push_if(choice(&cut, "Open them as a dataset, one burst after another"), Action::CutOpenBurst(length));
        queue.push_if(choice("Cut…", "Choose length and step of the bursts first"), ActionId::CutSequence);
        choice("Keep as one", "Look at all frames as one burst")
    });
    offer.inner
}

pub fn replace_features_ui(ctx: &egui::Context, open: &mut bool, datasets: &Datasets, queue: &mut Queue) {
    // The dataset may have been closed under the question.
    let Some(dataset) = datasets.open.as_ref().filter(|_| *open) else {
        *open = false;
        return;
    };
    let answer = confirm_ui(ctx, "replace features", "Replace features?", "Replace", |ui| {
        let folder = dataset.folder.as_ref().map_or_else(String::new, |f| f.display().to_string());
        ui.label(format!("The folder {folder} has features that were found with other parameters."));
        ui.add_space(4.0);
        let bursts = counted(dataset.bursts.len(), "burst");
        ui.label(format!(
            "Detect all finds the features of {bursts} again with the parameters as they are now, and replaces \
             the old ones, burst by burst. Cancelled, it keeps the new features of the bursts that are finished. The bursts \
             themselves are not touched. To keep the old features, cancel and choose another folder."
        ));
    });
    *open = answer.is_none();
    queue.push_if(answer == Some(true), Action::DetectAllAnyway);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bursts_that_overlap_begin_a_step_apart() {
        let dialog = CutDialog { paths: vec!["film".into()], frames: 9, length: 3, contiguous: false, step: 2 };
        assert!(dialog.consequence().starts_with("4 bursts, each") && dialog.source().burst_step == Some(2));
    }
}
