//! Text and pictures for the clipboard: a row, a value, a place, a picture.

use super::canvas::Readout;
use super::inspector::PaneWidgets;
use super::pane::PaneId;
use crate::app::document::{MatchColumn, Side};
use crate::app::results::{MatchRow, Read};
use crate::app::view::fixed;
use crate::burst::OpenOptions;
use crate::detector::{Feature, Quantity};
use crate::export::feature_header;
use crate::requests::{BurstSource, detect_line};
use egui::text_selection::LabelSelectionState;

pub fn feature_text(feature: &Feature) -> String {
    let values = Quantity::STORED.map(|quantity| quantity.cell(feature));
    format!("{}\n{}", feature_header().replace(',', "\t"), values.join("\t"))
}

pub fn match_text(row: &MatchRow<'_>) -> String {
    let headings = MatchColumn::ALL.map(|column| column.words()[0]).join("\t");
    // A table reads hyphens alone as minus signs.
    let values = MatchColumn::ALL.map(|column| column.text(row).replace('−', "-")).join("\t");
    format!("{headings}\n{values}")
}

pub fn place_text(readout: &Readout) -> String {
    format!("{}, {}", fixed(readout.u, 2), fixed(readout.v, 2)).replace('−', "-")
}

pub fn is_asked(ctx: &egui::Context) -> bool {
    let asked = ctx.input(|i| i.events.iter().any(|event| matches!(event, egui::Event::Copy)));
    // Text that is selected in a label is copied by egui itself.
    let text_is_selected = ctx.plugin_opt::<LabelSelectionState>().is_some_and(|plugin| plugin.lock().has_selection());
    asked && !ctx.egui_wants_keyboard_input() && !text_is_selected
}

/// Returns the note about what was copied.
pub fn copy_row(ctx: &egui::Context, model: Read<'_>, widgets: &PaneWidgets) -> Option<String> {
    let readout = model.document.panes.shown().into_iter().find_map(|id| widgets.get(id)?.picture.readout);
    let text = selected_text(model).or(readout.map(|readout| readout.value.to_string()))?;
    let what = text.lines().last().unwrap_or_default().replace('\t', "  ");
    ctx.copy_text(text);
    Some(format!("Copied {what}"))
}

fn selected_text(model: Read<'_>) -> Option<String> {
    match model.document.workspace.shows_pair() {
        true => model.selected_match().map(|row| match_text(&row)),
        false => model.selected_feature().map(feature_text),
    }
}

/// Returns the note about what was copied, or why there is no command.
pub fn copy_command(ctx: &egui::Context, model: Read<'_>) -> Option<Result<String, &'static str>> {
    let side = model.active_side();
    Some(command_text(&model.burst_of(side)?.source, side, model).map(|line| {
        let note = format!("Copied {line}");
        ctx.copy_text(line);
        note
    }))
}

fn command_text(source: &BurstSource, side: Side, model: Read<'_>) -> Result<String, &'static str> {
    let no_file = "this burst was made in the Lab and lies in no file; 'burstscope synth' makes such bursts";
    let inputs = source.arguments().ok_or(no_file)?;
    // Built-in bursts are opened without calibration.
    let built_in = OpenOptions::default();
    let is_of_files = matches!(source, BurstSource::Paths(_));
    let calibration = if is_of_files { model.calibration_of(side) } else { &built_in };
    Ok(detect_line(&inputs, &model.asked_of(side), calibration))
}

pub fn copy_picture(ctx: &egui::Context, model: Read<'_>, id: PaneId) -> Option<String> {
    let picture = model.picture_in(id)?;
    let rgba = picture.rgba(&model.display_of(id), model.features_of_motion(id));
    ctx.copy_image(egui::ColorImage::from_rgba_unmultiplied(picture.plane.size().into(), rgba.as_raw()));
    Some("Copied the picture".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::results::Model;

    #[test]
    fn the_command_has_the_calibration_with_which_files_were_opened() {
        let mut model = Model::default();
        model.document.calibration.full_scale = Some(4095.0);
        let command = |source| command_text(&source, Side::A, Read::of(&model));
        let of_files = command(BurstSource::Paths(vec!["a.npy".into()])).expect("files");
        assert!(of_files.contains("a.npy") && of_files.contains("4095"), "{of_files}");
        let built_in = command(BurstSource::Demo).expect("built in");
        assert!(built_in.contains("demo") && !built_in.contains("4095"), "{built_in}");
        let dark = BurstSource::DarkCopy { of: Box::new(BurstSource::Demo), noise: model.document.lab.dark_copy };
        assert!(command(dark).is_err_and(|why| why.contains("synth")));
    }
}
