//! The two pictures side by side.

use crate::app::actions::{ActionId, Queue, menu::item_ui};
use crate::app::canvas::CanvasOutput;
use crate::app::canvas::overlay::{ColourScale, OverlayStyle, draw_features};
use crate::app::inspector::{PaneWidgets, picture_ui};
use crate::app::pane::PaneId;
use crate::app::panel::features::{at_time, frames_from_middle};
use crate::app::panel::picture::PictureState;
use crate::app::project::Model;
use crate::app::project::pair::Side;
use crate::app::style;
use crate::app::window::BurstscopeApp;
use crate::app::workspace::pair::empty::empty_ui;
use crate::app::workspace::pair::lines::lines_ui;
use crate::app::workspace::pair::why::marks_ui;
use egui::{Align, Frame, Label, Layout, Margin, Rect, RichText, Ui, UiBuilder, pos2};

/// Points between the two panes.
const GAP: f32 = 6.0;

/// Draws both panes and the matches between them. Answers which match the pointer is over; `None` while it is over
/// neither picture.
pub fn panes_ui(app: &mut BurstscopeApp, ui: &mut Ui, queue: &mut Queue) -> Option<Option<usize>> {
    let room = ui.available_rect_before_wrap();
    let middle = (room.center().x * ui.ctx().pixels_per_point()).round() / ui.ctx().pixels_per_point();
    let left = Rect::from_min_max(room.min, pos2(middle - 0.5 * GAP, room.bottom()));
    let right = Rect::from_min_max(pos2(middle + 0.5 * GAP, room.top()), room.max);
    app.pair_panels.rect_b = Some(right);
    let linked = app.model.pair.links.views;
    let (model, widgets) = (&mut app.model, &mut app.widgets);
    let before = model.panes.of(Side::A).view;
    let a = in_rect(ui, left, |ui| pane_ui(ui, model, Side::A, widgets, queue));
    if linked {
        let after = model.panes.of(Side::A).view;
        model.panes.of_mut(Side::B).view.follow(&before, &after);
    }
    if model.burst_of(Side::B).is_none() {
        in_rect(ui, right, |ui| empty_ui(ui, model, queue));
        return a.pointer_ui.map(|_| None);
    }
    let before = model.panes.of(Side::B).view;
    let b = in_rect(ui, right, |ui| pane_ui(ui, model, Side::B, widgets, queue));
    if linked {
        let after = model.panes.of(Side::B).view;
        model.panes.of_mut(Side::A).view.follow(&before, &after);
    }
    let outputs = [a, b];
    if model.pair.look.features {
        for (side, output) in Side::BOTH.into_iter().zip(&outputs) {
            features_ui(model, side, output);
        }
    }
    let pointed = lines_ui(ui, model, &outputs, queue);
    marks_ui(model, &outputs);
    pointed
}

fn in_rect<T>(ui: &mut Ui, rect: Rect, draw: impl FnOnce(&mut Ui) -> T) -> T {
    ui.scope_builder(UiBuilder::new().max_rect(rect).layout(Layout::top_down(Align::Min)), draw).inner
}

fn pane_ui(ui: &mut Ui, model: &mut Model, side: Side, widgets: &mut PaneWidgets, queue: &mut Queue) -> CanvasOutput {
    let id = PaneId::of(side);
    widgets.of(id).picture.refresh(model.picture_of(side));
    ui.spacing_mut().item_spacing.y = 0.0;
    let fill = ui.visuals().panel_fill;
    Frame::new().inner_margin(Margin::symmetric(8, 3)).fill(fill).show(ui, |ui| {
        header_ui(ui, model, side, &widgets.of(id).picture, model.is_current(id), queue);
    });
    let name = if side == Side::A { "Picture A" } else { "Picture B" };
    picture_ui(ui, model, id, widgets, name).output
}

fn header_ui(ui: &mut Ui, model: &Model, side: Side, state: &PictureState, current: bool, queue: &mut Queue) {
    ui.horizontal(|ui| {
        let active = model.active_side() == side;
        let name = RichText::new(side.name()).strong();
        let name = if active { name.color(ui.visuals().hyperlink_color) } else { name };
        ui.label(name).on_hover_text(if active {
            "The sliders move this one"
        } else {
            "Click the picture to move this one"
        });
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            if side == Side::B {
                open_menu_ui(ui, model, queue);
            }
            if state.shown().is_some() && !current {
                ui.label(RichText::new("updating…").small().color(style::warning(ui)));
            }
            ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                let burst = model.burst_of(side).map_or("", |open| open.burst.name.as_str());
                let shown = state.shown().map_or("", |s| s.label.as_str());
                let text = format!("{burst}  ·  {shown}");
                ui.add(Label::new(&text).truncate()).on_hover_text(text);
            });
        });
    });
}

fn open_menu_ui(ui: &mut Ui, model: &Model, queue: &mut Queue) {
    ui.menu_button("Open B…", |ui| {
        ui.set_min_width(180.0);
        for id in [ActionId::OpenFolderB, ActionId::OpenFilesB, ActionId::OpenPathB, ActionId::OpenDemoB] {
            item_ui(ui, model, queue, id);
        }
        ui.separator();
        item_ui(ui, model, queue, ActionId::CloseB);
    });
}

/// All features of a side, over its picture.
fn features_ui(model: &Model, side: Side, output: &CanvasOutput) {
    let Some(found) = model.found_of(side) else { return };
    let features = &found.detection.features;
    let scale = ColourScale::of(model.colour_by, features);
    let style = OverlayStyle {
        orientations: false,
        motion: false,
        stale: found.asked != model.asked_of(side),
        ..OverlayStyle::new(&scale, found.detection.frames_used.len())
    };
    match frames_from_middle(model.picture_of(side), &found.detection) {
        Some(dt) => {
            let moved: Vec<_> = features.iter().map(|f| at_time(f, dt)).collect();
            draw_features(output, &moved, &style);
        }
        None => draw_features(output, features, &style),
    }
}
