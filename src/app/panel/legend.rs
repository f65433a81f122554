//! Legends in a corner of the picture. A click folds one to a small chip, and unfolds it.

use crate::app::actions::{ActionId, Queue};
use crate::app::canvas::overlay::ColourScale;
use crate::app::pane::PaneId;
use crate::app::panel::widgets::named;
use crate::app::results::Read;
use egui::{Align2, Color32, Frame, Margin, Rect, Sense, TextStyle, Ui, UiBuilder, Vec2, vec2};

/// Draws a legend of `size` points, margins included, or its chip, in the corner `align`; a click folds or unfolds it.
pub fn legend_ui(
    ui: &mut Ui,
    model: Read<'_>,
    (align, rect_ui, size): (Align2, Rect, Vec2),
    queue: &mut Queue,
    add_contents: impl FnOnce(&mut Ui),
) {
    let is_open = model.document.look.legend;
    let rect = align.align_size_within_rect(if is_open { size } else { CHIP }, rect_ui.shrink(10.0));
    let name = if is_open { "Fold the legend" } else { "Show the legend" };
    let response = ui.interact(rect, ui.scope_id().with("legend"), Sense::click());
    named(&response, egui::Role::Button, name);
    ui.scope_builder(UiBuilder::new().max_rect(rect), |ui| {
        ui.spacing_mut().item_spacing.y = 4.0;
        if is_open {
            let margin = Margin::symmetric(8, 6);
            Frame::new().fill(ground(ui)).corner_radius(5).inner_margin(margin).show(ui, |ui| {
                ui.set_width(ui.available_width());
                add_contents(ui);
            });
        } else {
            ui.painter().rect_filled(rect, 5.0, ground(ui));
            let (font, colour) = (TextStyle::Small.resolve(ui.style()), ui.visuals().text_color());
            ui.painter().text(rect.center(), Align2::CENTER_CENTER, "Legend", font, colour);
        }
    });
    let help = if is_open { "Colours of the features; click to fold (L)" } else { "Colours of the features (L)" };
    queue.push_if(response.on_hover_text(help).clicked(), ActionId::ToggleLegend);
}

/// Minimum size of a picture with a key of its own colours, in points.
pub const KEY_ROOM: Vec2 = vec2(430.0, 150.0);

/// Colours of the motions in the picture of pane `id`, drawn in `rect`, which a key in its corner explains.
pub fn motion_key(model: Read<'_>, id: PaneId, rect: Rect) -> Option<ColourScale> {
    let motion = model.picture_in(id)?.motion.as_ref()?;
    let has_room = rect.width() >= KEY_ROOM.x && rect.height() >= KEY_ROOM.y;
    has_room.then(|| ColourScale::of_slopes(&motion.grid, model.features_of_motion(id)))
}

const CHIP: Vec2 = vec2(62.0, 20.0);

pub fn ground(ui: &Ui) -> Color32 {
    if ui.visuals().dark_mode { Color32::from_black_alpha(190) } else { Color32::from_white_alpha(225) }
}
