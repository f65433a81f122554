//! Two bursts side by side, and the matches between them.

mod detail;
pub mod lines;
pub mod parameters;
mod table;

use super::{WorkspaceParts, bottom_panel, folded_ui, left_panel, right_panel, scroll_ui, side_frame, side_width};
use crate::app::actions::menu::item_ui;
use crate::app::actions::{ActionId, Queue, button_ui, checked, tooltip};
use crate::app::canvas::overlay::rgb;
use crate::app::document::{Action, MatchLook, MatchesAs, PairTab, Pointed, Side};
use crate::app::inspector::{Drawn, inspector_ui};
use crate::app::panel;
use crate::app::panel::widgets::{error_ui, label_ui, name_field, section_ui, strip_of_colours};
use crate::app::{parts::mark, results::Read};
use crate::export::MatchKind;
use crate::teach::Part;
use egui::{CentralPanel, Color32, DragValue, Frame, Margin, Panel, Role, Sense, Stroke, Ui, vec2};

pub(super) fn pair_workspace_ui(ui: &mut egui::Ui, parts: &mut WorkspaceParts<'_>) {
    let (model, WorkspaceParts { widgets, queue, .. }) = (parts.model, parts);
    folded_ui(ui, model, queue);
    let match_is_left = model.match_is_left();
    if model.shows_left() && !match_is_left {
        left_panel(ui, model, "pair left", side_width(model), |ui| {
            sides_ui(ui, model, queue);
            switches_ui(ui, model, queue);
            panel::cursor::cursor_ui(ui, model, queue);
            parameters::parameters_ui(ui, model, queue);
            panel::parameters::parameters_ui(ui, model, queue);
        });
    }
    if model.shows_right() {
        let match_ui = |ui: &mut Ui| {
            let tip = "Close the match and the probe  (Esc)";
            if match_is_left && ui.button("⏴ Parameters").on_hover_text(tip).clicked() {
                queue.push(ActionId::ClearSelection);
                queue.push(Action::OpenProbe(false));
            }
            let help = "The selected match, and how matches and pictures are drawn";
            if panel::probe::probe_tab_ui(ui, model, "Match and display", help, queue) {
                return;
            }
            scroll_ui(ui, |ui| {
                detail::detail_ui(ui, model, queue);
                detail::why_ui(ui, model, queue);
                if !model.shows_left() || match_is_left {
                    switches_ui(ui, model, queue);
                }
                panel::display::display_ui(ui, model, widgets, false, queue);
            });
        };
        let width = side_width(model);
        if match_is_left {
            // The panel of the parameters, whose width is kept.
            let panel = Panel::left("pair left").frame(side_frame(ui)).default_size(width);
            panel.size_range(super::LEFT_WIDTHS).show(ui, match_ui);
        } else {
            right_panel(ui, model, "pair right", width, 250.0..=460.0, match_ui);
        }
    }
    let (mut in_table, mut over_list) = (None, false);
    if !model.shows_bottom() {
        let frame = Frame::side_top_panel(ui.style()).inner_margin(Margin::symmetric(8, 2));
        Panel::bottom("pair tabs").frame(frame).show(ui, |ui| table::tabs_ui(ui, model, queue));
    } else {
        let is_over = bottom_panel(ui, model, "pair bottom", 300.0, |ui| {
            mark(ui, Part::Below, ui.max_rect());
            table::tabs_ui(ui, model, queue);
            ui.separator();
            match model.document.pair_tab {
                PairTab::Matches => in_table = table::table_ui(ui, model, queue),
                PairTab::Unmatched => {
                    table::steps_ui(ui, model, queue);
                    table::lost_table_ui(ui, model, queue);
                }
                PairTab::Compared => panel::against::against_ui(ui, model, widgets, queue),
            }
        });
        over_list = is_over && model.document.pair_tab == PairTab::Compared;
    }
    CentralPanel::default().frame(Frame::new().fill(ui.visuals().panel_fill)).show(ui, |ui| {
        mark(ui, Part::Pictures, ui.max_rect());
        let drawn = inspector_ui(ui, model, widgets, queue);
        let over_pictures = lines::lines_ui(ui, model, &drawn, queue);
        queue.point(&model.results.pair.hovered, over_pictures.unwrap_or(in_table), Pointed::Match);
        for side in Side::BOTH {
            let is_over =
                |drawn: &Drawn| drawn.output.pointer_ui.is_some() && model.document.panes.is_on(drawn.pane, side);
            if !(drawn.iter().any(is_over) || (over_list && model.active_side() == side)) {
                queue.point(&model.results.slots[side].comparison.hovered, None, |row| Pointed::Row(side, row));
            }
        }
    });
}

pub fn sides_ui(ui: &mut Ui, model: Read<'_>, queue: &mut Queue) {
    section_ui(ui, "A and B", |ui| {
        let both = model.burst_of(Side::B).is_some();
        ui.add_enabled_ui(both, |ui| {
            ui.horizontal(|ui| {
                ui.spacing_mut().item_spacing.x = 4.0;
                label_ui(ui, "Cursor of", 60.0)
                    .on_hover_text("Burst whose frame, slope, octave and level the sliders and keys move");
                let active = model.active_side();
                for side in Side::BOTH {
                    let tip = format!("Move the frame, slope, octave and level of {}  (T)", side.name());
                    let button = egui::Button::selectable(active == side, side.name()).frame_when_inactive(true);
                    let response = ui.add(button).on_hover_text(tip);
                    let name = format!("Cursor of {}", side.name());
                    response.widget_info(|| egui::WidgetInfo::selected(Role::Button, both, active == side, &name));
                    queue.push_if(response.clicked() && active != side, ActionId::OtherSide);
                }
                button_ui(ui, model, queue, ActionId::SwapSides, Some("Swap"));
            });
        });
        ui.menu_button("Open B…", |ui| {
            ui.set_min_width(180.0);
            for id in [ActionId::OpenFolderB, ActionId::OpenFilesB, ActionId::OpenPathB, ActionId::OpenDemoB] {
                item_ui(ui, model, queue, id);
            }
            ui.separator();
            item_ui(ui, model, queue, ActionId::CloseB);
        });
        for id in [ActionId::LinkCursors, ActionId::LinkViews, ActionId::LinkRanges] {
            let mut on = checked(id, model).unwrap_or(false);
            let response = ui.checkbox(&mut on, id.action().label).on_hover_text(tooltip(ui.ctx(), id.action()));
            queue.push_if(response.clicked(), id);
        }
        let [a, b] = model.results.slots.both().map(|slot| slot.param_error.as_ref());
        if let Some(error) = b.filter(|_| a.is_none()) {
            error_ui(ui, egui::RichText::new(format!("The parameters do not fit B: {error}")).small());
        }
    });
}

pub fn switches_ui(ui: &mut Ui, model: Read<'_>, queue: &mut Queue) {
    section_ui(ui, "Matches", |ui| {
        let result = model.results.pair.matches.as_ref().map(|matches| &matches.result);
        let verified = result.is_none_or(|result| result.verification.is_some());
        let counts = result.map(|result| result.counts);
        let inliers = counts.map(|c| c.inliers.unwrap_or(c.putative));
        let outliers = counts.and_then(|c| c.inliers.map(|inliers| c.putative - inliers));
        let mut changed = model.document.match_look;
        let look = &mut changed;
        let (kind, label) = if verified { (MatchKind::Inlier, "Inliers") } else { (MatchKind::Unverified, "Putative") };
        let tip = "Matches that agree with the geometry of the two views  (I)";
        kind_ui(ui, &mut look.inliers, kind, label, inliers, tip);
        if verified {
            let tip = "Matches that do not agree with the geometry of the two views  (U)";
            kind_ui(ui, &mut look.outliers, MatchKind::Outlier, "Outliers", outliers, tip);
        }
        ui.horizontal_wrapped(|ui| {
            for way in MatchesAs::ALL {
                let [label, tip] = way.words();
                ui.radio_value(&mut look.drawn_as, way, label).on_hover_text(tip);
            }
        });
        let tip = "Draw as many, inliers first, in the order of the table; without a limit the picture bears a few in each part";
        limit_ui(ui, &mut look.most, 100, ("At most", tip), |most| {
            DragValue::new(most).range(1..=100_000).suffix(" drawn")
        });
        motion_ui(ui, look, model.largest_motion());
        let boxes = [
            (&mut look.alone, "Selected alone", "Draw the selected match alone, without the others  (X)"),
            (&mut look.geometry, "Epipolar lines", "Lines of the other picture on which the partners must lie  (E)"),
            (&mut look.features, "All features", "Draw all features over both pictures  (O)"),
        ];
        for (on, label, tip) in boxes {
            ui.checkbox(on, label).on_hover_text(tip);
        }
        queue.edit(model.document, Action::SetMatchLook(changed));
    });
}

/// Draws the filter by the difference of the motions, and the switch of its colours with their range.
fn motion_ui(ui: &mut Ui, look: &mut MatchLook, largest: f32) {
    let tip = "Show only matches whose motions in A and B differ by at most this, px/frame";
    limit_ui(ui, &mut look.max_motion, 0.5, ("Motions within", tip), |max| {
        DragValue::new(max).range(0.0..=100.0).speed(0.01).suffix(" px/frame")
    });
    ui.horizontal(|ui| {
        let tip = "Colour the lines by the difference of the motions in A and B";
        ui.checkbox(&mut look.by_motion, "Colour by motions").on_hover_text(tip);
        if look.by_motion {
            let (rect, _) = ui.allocate_exact_size(vec2(48.0, 10.0), Sense::hover());
            strip_of_colours(ui.painter(), rect, 48, |x, _| lines::motion_colour(x as f32 / 47.0));
            ui.weak(format!("0 … {largest:.1} px/frame"));
        }
    });
}

/// A limit that may be switched off; `usual` is the first one.
fn limit_ui<N: Copy + ToString>(
    ui: &mut Ui,
    limit: &mut Option<N>,
    usual: N,
    (label, tip): (&str, &str),
    field: impl Fn(&mut N) -> DragValue<'_>,
) {
    ui.horizontal(|ui| {
        let mut is_on = limit.is_some();
        ui.checkbox(&mut is_on, label).on_hover_text(tip);
        let mut value = limit.unwrap_or(usual);
        name_field(&ui.add_enabled(is_on, field(&mut value)), label, &value.to_string());
        *limit = is_on.then_some(value);
    });
}

fn kind_ui(ui: &mut Ui, on: &mut bool, kind: MatchKind, label: &str, count: Option<usize>, tip: &str) {
    ui.horizontal(|ui| {
        ui.checkbox(on, label).on_hover_text(tip);
        let (rect, _) = ui.allocate_exact_size(vec2(42.0, 14.0), Sense::hover());
        // Dark as the pictures, so that it looks alike in the light theme.
        ui.painter().rect_filled(rect, 3.0, Color32::from_gray(40));
        let ends = [rect.left_center() + vec2(4.0, 0.0), rect.right_center() - vec2(4.0, 0.0)];
        let stroke = Stroke::new(2.0, rgb(kind.color()));
        match kind.is_dashed() {
            true => ui.painter().extend(egui::Shape::dashed_line(&ends, stroke, 6.0, 4.5)),
            false => _ = ui.painter().line_segment(ends, stroke),
        }
        if let Some(count) = count {
            ui.weak(count.to_string());
        }
    });
}
