//! Text and pictures for the clipboard: a row, a value, a place, a picture.

use super::canvas::Readout;
use super::inspector::PaneWidgets;
use super::pane::PaneId;
use crate::app::project::Model;
use crate::app::project::pair::{MatchColumn, MatchRow, Side};
use crate::app::project::workspace::Workspace;
use crate::app::view::fixed;
use crate::burst::OpenOptions;
use crate::detector::{Feature, Quantity};
use crate::export::feature_header;
use crate::requests::{BurstSource, detect_line};

/// The features' columns and one feature's numbers, separated by tabs: two rows for a spreadsheet.
pub fn feature_text(feature: &Feature) -> String {
    let values = Quantity::STORED.map(|quantity| quantity.cell(feature));
    format!("{}\n{}", feature_header().replace(',', "\t"), values.join("\t"))
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
    format!("{}, {}", fixed(readout.u, 2), fixed(readout.v, 2))
}

/// The picture of a pane in its range and colours; `None` without one.
pub fn picture_of(model: &Model, id: PaneId) -> Option<egui::ColorImage> {
    let picture = model.panes.get(id)?.picture.as_ref()?;
    let (width, height) = picture.plane.size();
    let rgba = picture.rgba(&model.display_of(id));
    Some(egui::ColorImage::from_rgba_unmultiplied([width, height], rgba.as_raw()))
}

/// Whether copying is asked for and no text is being edited or selected.
pub fn is_asked(ctx: &egui::Context) -> bool {
    let asked = ctx.input(|i| i.events.iter().any(|event| matches!(event, egui::Event::Copy)));
    // Text that is selected in a label is copied by egui itself.
    let text_is_selected = ctx
        .plugin_opt::<egui::text_selection::LabelSelectionState>()
        .is_some_and(|plugin| plugin.lock().has_selection());
    asked && !ctx.egui_wants_keyboard_input() && !text_is_selected
}

/// Copies the selected feature or match, or else the value under the pointer.
pub fn copy_row(ctx: &egui::Context, model: &mut Model, widgets: &PaneWidgets) {
    let readouts = model.panes.shown().into_iter().filter_map(|id| widgets.get(id)?.picture.readout);
    let value = readouts.into_iter().next().map(|readout| value_text(&readout));
    if let Some(text) = selected_text(model).or(value) {
        let what = text.lines().last().unwrap_or_default().replace('\t', "  ");
        model.messages.note(format!("Copied {what}"));
        ctx.copy_text(text);
    }
}

/// The selected match in *Two bursts*, elsewhere the selected feature.
fn selected_text(model: &Model) -> Option<String> {
    match model.workspace {
        Workspace::Pair => Some(match_text(&model.pair.matches.as_ref()?.row(model.pair.selected?)?)),
        _ => model.selected_feature().map(feature_text),
    }
}

/// Copies the command that finds the features of the burst in focus.
pub fn copy_command(ctx: &egui::Context, model: &mut Model) {
    let side = model.active_side();
    let Some(burst) = model.burst_of(side) else { return };
    match command_text(&burst.source, side, model) {
        Ok(line) => {
            model.messages.note(format!("Copied {line}"));
            ctx.copy_text(line);
        }
        Err(why) => model.messages.error("Copy as command", why),
    }
}

/// The command that finds the features of the burst of `side`, opened from `source`, with the present parameters.
fn command_text(source: &BurstSource, side: Side, model: &Model) -> Result<String, &'static str> {
    let inputs = source
        .arguments()
        .ok_or("this burst was made in the Lab and lies in no file; 'burstscope synth' makes such bursts")?;
    // Built-in bursts are opened without calibration.
    let calibration =
        if matches!(source, BurstSource::Paths(_)) { model.calibration.clone() } else { OpenOptions::default() };
    Ok(detect_line(&inputs, &model.asked_of(side), &calibration))
}

pub fn copy_picture(ctx: &egui::Context, model: &mut Model) {
    if let Some(image) = picture_of(model, model.focus()) {
        ctx.copy_image(image);
        model.messages.note("Copied the picture");
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
            at_slope_limit: true,
            ..Feature::default()
        };
        let text = feature_text(&feature);
        let lines: Vec<Vec<&str>> = text.lines().map(|line| line.split('\t').collect()).collect();
        assert_eq!((lines.len(), lines[0].len()), (2, lines[1].len()));
        assert_eq!(lines[1], ["1.5", "2", "3", "0.25", "-1", "0.5", "-0.125", "8", "1", "2", "1"]);
    }

    #[test]
    fn the_command_has_the_calibration_with_which_files_were_opened() {
        let mut model = Model::default();
        model.calibration.full_scale = Some(4095.0);
        let of_files = command_text(&BurstSource::Paths(vec!["a.npy".into()]), Side::A, &model).expect("files");
        assert!(of_files.contains("a.npy") && of_files.contains("4095"), "{of_files}");
        let built_in = command_text(&BurstSource::Demo, Side::A, &model).expect("built in");
        assert!(built_in.contains("demo") && !built_in.contains("4095"), "{built_in}");
        let dark = BurstSource::DarkCopy { of: Box::new(BurstSource::Demo), noise: model.lab.dark_copy };
        assert!(command_text(&dark, Side::A, &model).is_err_and(|why| why.contains("synth")));
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
            smoothing_px: 0.0,
        };
        assert_eq!((value_text(&readout), place_text(&readout)), ("-0.25".to_owned(), "12.35, 6.00".to_owned()));
    }
}
