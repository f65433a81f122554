//! A lesson before a hall: its panels, the keys of a presenter; and the rings around places that a step speaks of.

use super::snr::shown_spot;
use super::state::{LessonAction, Lessons};
use super::steps::panels_of;
use crate::app::document::Document;
use crate::app::inspector::PaneWidgets;
use crate::app::pane::Content;
use crate::app::project::Model;
use crate::app::project::side::Side;
use egui::{Color32, Context, Id, Key, LayerId, Modifiers, Order, Stroke, pos2};

/// Steps that are asked for by keys in a hall: those of a presenter, and the arrows.
pub fn take_hall_keys(ctx: &Context, lessons: &Lessons, model: &Model) -> Option<LessonAction> {
    let open = lessons.open.as_ref().filter(|_| model.panels.hall && !ctx.egui_wants_keyboard_input())?;
    let pressed = |keys: [Key; 2]| {
        ctx.input_mut(|input| keys.into_iter().filter(|key| input.consume_key(Modifiers::NONE, *key)).count() > 0)
    };
    if pressed([Key::PageDown, Key::ArrowRight]) {
        // At the end of the last lesson a presenter's key closes nothing.
        Some(open.onward(lessons.next_lesson().is_some())).filter(|asked| *asked != LessonAction::Leave)
    } else if pressed([Key::PageUp, Key::ArrowLeft]) {
        open.back()
    } else {
        None
    }
}

impl Lessons {
    /// Shows the open lesson to a hall, or as before.
    pub fn toggle_hall(&self, document: &mut Document) {
        if let Some(open) = &self.open {
            document.panels = panels_of(open.step(), !document.panels.hall);
        }
    }
}

/// Draws rings around the places that the open step names, and around the spot that it measures.
pub fn rings_ui(ctx: &Context, lessons: &Lessons, model: &Model, widgets: &PaneWidgets) {
    let Some(open) = lessons.open.as_ref().filter(|open| open.is_ready && !open.is_ended) else { return };
    let state = &open.step().state;
    let mut rings: Vec<_> = state.rings.iter().flatten().map(|ring| (ring.place, ring.radius)).collect();
    if let Some(spot) = state.spot
        && let Some((_, place)) = shown_spot(model, spot, state.slope.unwrap_or_default())
    {
        rings.extend([spot.inner, spot.ground[0], spot.ground[1]].map(|radius| (place, radius)));
    }
    for id in model.panes.shown() {
        let is_picture = model.panes.get(id).is_some_and(|pane| {
            pane.side == Side::A && !matches!(pane.content, Content::Slice(_) | Content::Difference(..))
        });
        let (Some(ui_from_image), Some(rect_ui)) = (widgets.ui_from_image(id), widgets.rect_ui(id)) else { continue };
        if !is_picture {
            continue;
        }
        let layer = LayerId::new(Order::Background, Id::unique("lesson rings"));
        let painter = ctx.layer_painter(layer).with_clip_rect(rect_ui);
        for ([u, v], radius) in &rings {
            let centre = ui_from_image.pos(pos2(*u, *v));
            let radius = centre.distance(ui_from_image.pos(pos2(u + radius, *v)));
            for (width, colour) in [(3.5, Color32::from_black_alpha(160)), (1.5, super::panel::HIGHLIGHT)] {
                painter.circle_stroke(centre, radius, Stroke::new(width, colour));
            }
        }
    }
}
