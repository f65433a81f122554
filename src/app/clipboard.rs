//! Text and pictures for the clipboard: a row, a value, a place, a picture.

use super::canvas::Readout;
use super::pane::PaneId;
use super::window::BurstscopeApp;
use crate::app::project::Model;
use crate::app::project::pair::{MatchColumn, MatchRow};
use crate::app::project::workspace::Workspace;
use crate::burst::OpenOptions;
use crate::detector::Feature;
use crate::export::{COLUMNS, FeatureRow};
use crate::requests::{BurstSource, detect_line};

/// The features' columns and one feature's numbers, separated by tabs: two rows for a spreadsheet.
pub fn feature_text(feature: &Feature) -> String {
    let values = FeatureRow::from(feature).values().map(|value| value.to_string());
    format!("{}\n{}", COLUMNS.join("\t"), values.join("\t"))
}

/// The table's headings and one match's values, separated by tabs: two rows for a spreadsheet.
pub fn match_text(row: &MatchRow<'_>) -> String {
    let headings = MatchColumn::ALL.map(MatchColumn::heading).join("\t");
    let values = MatchColumn::ALL.map(|column| column.text(row)).join("\t");
    format!("{headings}\n{values}")
}

/// The value alone, as a program reads it.
pub fn value_text(readout: &Readout) -> String {
    readout.value.to_string()
}

/// A place, (u, v) in pixels of the input image.
pub fn place_text(readout: &Readout) -> String {
    format!("{:.2}, {:.2}", readout.u, readout.v)
}

/// The picture of a pane in its range and colours; `None` without one.
pub fn picture_of(model: &Model, id: PaneId) -> Option<egui::ColorImage> {
    let picture = model.panes.get(id)?.picture.as_ref()?;
    let (width, height) = picture.plane.size();
    let rgba = picture.rgba(&model.display_of(id));
    Some(egui::ColorImage::from_rgba_unmultiplied([width, height], rgba.as_raw()))
}

impl BurstscopeApp {
    /// Copies the selected feature or match, or else the value under the pointer, when that is asked for and no text is
    /// being edited.
    pub(super) fn take_copy(&mut self, ctx: &egui::Context) {
        let asked = ctx.input(|i| i.events.iter().any(|event| matches!(event, egui::Event::Copy)));
        // Text that is selected in a label is copied by egui itself.
        let text_is_selected = ctx
            .plugin_opt::<egui::text_selection::LabelSelectionState>()
            .is_some_and(|plugin| plugin.lock().has_selection());
        if asked && !ctx.egui_wants_keyboard_input() && !text_is_selected {
            self.copy_row(ctx);
        }
    }

    /// Copies the command that finds the features on show.
    pub(super) fn copy_command(&mut self, ctx: &egui::Context) {
        let Some(burst) = &self.model.slots.a.burst else { return };
        let Some(inputs) = burst.source.arguments() else {
            let why = "this burst was made in the Lab and lies in no file; 'burstscope synth' makes such bursts";
            self.model.messages.error("Copy as command", why);
            return;
        };
        let line = detect_line(&inputs, &self.model.asked(), &self.calibration_of_open());
        self.model.messages.note(format!("Copied {line}"));
        ctx.copy_text(line);
    }

    /// Options with which the burst was opened; the default for built-in bursts.
    fn calibration_of_open(&self) -> OpenOptions {
        match self.model.slots.a.burst.as_ref().map(|open| &open.source) {
            Some(BurstSource::Paths(_)) => self.model.calibration.clone(),
            _ => OpenOptions::default(),
        }
    }

    /// Copies the selected feature or match, or else the value under the pointer.
    pub(super) fn copy_row(&mut self, ctx: &egui::Context) {
        let pair = &self.model.pair;
        let row = match self.model.workspace {
            Workspace::Pair => {
                pair.matches.as_ref().and_then(|matches| Some(match_text(&matches.row(pair.selected?)?)))
            }
            _ => self.model.selected_feature().map(feature_text),
        };
        let readouts = self.model.visible_panes().into_iter().filter_map(|id| self.widgets.get(id)?.picture.readout);
        let value = readouts.into_iter().next().map(|readout| value_text(&readout));
        if let Some(text) = row.or(value) {
            let what = text.lines().last().unwrap_or_default().replace('\t', "  ");
            self.model.messages.note(format!("Copied {what}"));
            ctx.copy_text(text);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::detector::Slope;

    #[test]
    fn a_row_has_as_many_numbers_as_headings() {
        let feature = Feature {
            u: 1.5,
            v: 2.0,
            sigma: 3.0,
            orientation: 0.25,
            slope: Slope::new(-1.0, 0.5),
            response: -0.125,
            snr: 8.0,
            octave: 1,
            level: 2,
            slope_index: 3,
            at_slope_limit: true,
        };
        let text = feature_text(&feature);
        let lines: Vec<Vec<&str>> = text.lines().map(|line| line.split('\t').collect()).collect();
        assert_eq!((lines.len(), lines[0].len()), (2, lines[1].len()));
        assert_eq!(lines[1], ["1.5", "2", "3", "0.25", "-1", "0.5", "-0.125", "8", "1", "2", "1"]);
    }

    #[test]
    fn values_and_places_can_be_read_by_a_program() {
        let readout = Readout {
            u: 12.345,
            v: 6.0,
            pixel: (12, 6),
            value: -0.25,
            full_scale: 255.0,
            image_from_picture_scale: 1.0,
            quantity: Default::default(),
        };
        assert_eq!((value_text(&readout), place_text(&readout)), ("-0.25".to_owned(), "12.35, 6.00".to_owned()));
    }
}
