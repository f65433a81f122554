//! Table of features.

use crate::app::actions::{ActionId, Queue};
use crate::app::clipboard::feature_text;
use crate::app::inspector::copy_ui;
use crate::app::panel::sorted_table::{Listed, SortedColumn, sorted_table_ui};
use crate::app::project::Model;
use crate::app::project::filter::Column;
use crate::app::project::side::Side;
use egui::Ui;

impl SortedColumn for Column {
    const COLUMNS: &'static [Self] = &Self::ALL;

    fn heading(self) -> &'static str {
        Self::heading(self)
    }

    fn help(self) -> &'static str {
        Self::help(self)
    }

    fn word(self) -> Option<&'static str> {
        match self {
            Self::Rank | Self::U | Self::V => None,
            Self::Sigma => Some("scale"),
            Self::Orientation => Some("orientation"),
            Self::SlopeU | Self::SlopeV => Some("slope"),
            Self::Response => Some("response"),
            Self::Snr => Some("snr"),
            Self::Octave => Some("octave"),
            Self::Level => Some("level"),
            Self::AtSlopeLimit => Some("slope-limit"),
        }
    }

    fn width(self) -> f32 {
        match self {
            Self::Rank | Self::Sigma | Self::Octave => 34.0,
            Self::Level | Self::AtSlopeLimit => 36.0,
            Self::Orientation | Self::Snr => 40.0,
            Self::U | Self::V | Self::SlopeU | Self::SlopeV => 46.0,
            Self::Response => 64.0,
        }
    }
}

/// Draws the table.
pub fn table_ui(ui: &mut Ui, model: &mut Model, queue: &mut Queue) {
    if model.slots.a.found.is_none() {
        ui.centered_and_justified(|ui| ui.weak("Press Detect to find features"));
        return;
    }
    let is_pointed_at = ui.rect_contains_pointer(ui.available_rect_before_wrap());
    let listed = Listed { items: &model.listed, selected: model.selected, hovered: model.hovered };
    let text = |column: Column, index: usize| column.text(index, &model.features()[index]);
    let (mut chosen, mut asked) = (None, None);
    let menu = |ui: &mut Ui, index: usize| {
        let Some(feature) = model.features().get(index) else { return };
        if ui
            .button("Go to feature")
            .on_hover_text("Show the motion stack at its slope, with it in the middle")
            .clicked()
        {
            chosen = Some(index);
        }
        if ui.button("Why this feature?").on_hover_text(ActionId::ProbeFeature.action().help).clicked() {
            asked = Some(index);
        }
        copy_ui(ui, "Copy row", || feature_text(feature));
    };
    let pointed = sorted_table_ui(ui, model.order, &listed, text, |index| format!("Feature {}", index + 1), menu);
    (model.order, model.selected) = (pointed.order, chosen.or(pointed.selected));
    if chosen.is_some() {
        queue.push(ActionId::GoToFeature);
    }
    // The pointer may be over a picture instead, which then sets the hovered feature.
    if is_pointed_at {
        model.hovered = pointed.hovered;
    }
    if let Some(index) = asked {
        model.probe_feature(Side::A, index);
    }
}
