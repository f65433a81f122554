//! Display of the pictures: histogram, range, gamma, colour map, and overlays.

use crate::app::canvas::overlay::ColourBy;
use crate::app::histogram::HistogramPanel;
use crate::app::inspector::{PaneWidget, PaneWidgets};
use crate::app::panel::widgets::section_ui;
use crate::app::project::Model;
use crate::app::project::look::RangeClass;
use egui::Ui;

/// State of the panel, kept between passes: a histogram for each class of picture.
#[derive(Default)]
pub struct DisplayState {
    intensity: HistogramPanel,
    response: HistogramPanel,
    difference: HistogramPanel,
    noise: HistogramPanel,
    share: HistogramPanel,
}

/// Draws the section.
pub fn display_ui(ui: &mut Ui, model: &mut Model, widgets: &mut PaneWidgets) {
    section_ui(ui, "Display", |ui| {
        range_ui(ui, model, widgets);
        ui.add_space(4.0);
        overlay_ui(ui, model);
        colouring_ui(ui, model);
    });
}

/// Draws the section without the rows for features.
pub fn ranges_ui(ui: &mut Ui, model: &mut Model, widgets: &mut PaneWidgets) {
    section_ui(ui, "Display", |ui| range_ui(ui, model, widgets));
}

/// Draws the range of the focused pane.
fn range_ui(ui: &mut Ui, model: &mut Model, widgets: &mut PaneWidgets) {
    let PaneWidget { picture: pictures, display: state, .. } = widgets.of(model.focus());
    pictures.refresh(model.picture());
    let class = model.range_class(model.focus());
    let own = model.focused().own_ranges.is_some();
    let whose = if own { "This pane's range for" } else { "One range for all" };
    ui.weak(format!("{whose} {}", class.label()))
        .on_hover_text("It stays fixed until you change it, so that pictures can be compared");
    if class == RangeClass::Motion {
        ui.add(egui::Label::new("Colour: direction of the winning slope; bright where it is certain").wrap());
        return;
    }
    let panel = match class {
        RangeClass::Intensity => &mut state.intensity,
        RangeClass::Response => &mut state.response,
        RangeClass::Difference => &mut state.difference,
        RangeClass::Noise => &mut state.noise,
        RangeClass::Share | RangeClass::Motion => &mut state.share,
    };
    panel.ui(ui, pictures.shown(), pictures.visible_image, model.focused_ranges_mut().display_mut(class));
}

/// Draws the switches of the overlays.
fn overlay_ui(ui: &mut Ui, model: &mut Model) {
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 6.0;
        ui.spacing_mut().icon_spacing = 3.0;
        let boxes = [
            (&mut model.look.overlay, "Features", "Features over the picture (O)"),
            (&mut model.look.motion_vectors, "Motion", "Each feature's motion over the burst (M)"),
            (&mut model.look.orientations, "Ticks", "Each feature's orientation (R)"),
            (&mut model.look.legend, "Legend", "What the colours mean (L)"),
        ];
        for (on, label, tip) in boxes {
            ui.checkbox(on, label).on_hover_text(tip);
        }
    });
}

/// Draws the choice of the features' colours.
fn colouring_ui(ui: &mut Ui, model: &mut Model) {
    ui.horizontal(|ui| {
        let label = crate::app::panel::widgets::label_ui(ui, "Colour by", 69.0);
        egui::ComboBox::from_id_salt("colour by")
            .selected_text(model.colour_by.name())
            .width(ui.available_width() - 6.0)
            .truncate()
            .show_ui(ui, |ui| {
                for by in ColourBy::ALL {
                    if ui.selectable_value(&mut model.colour_by, by, by.name()).clicked() {
                        // Choosing a quantity again starts its computation again, if that was cancelled.
                        model.coherence.try_again();
                    }
                }
            })
            .response
            .labelled_by(label.id);
    });
}
