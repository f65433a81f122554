//! Workspaces of the window: each lays out its panels between the toolbar above and the status bar below.

pub mod matches;
pub mod pair;

use crate::app::actions::menu::item_ui;
use crate::app::actions::{ActionId, Queue, button_ui, checked, workspaces};
use crate::app::dataset::{cameras, errors_panel};
use crate::app::document::{LabQuestion, Pointed, Side};
use crate::app::inspector::{PaneWidgets, inspector_ui};
use crate::app::panel;
use crate::app::panel::lab::{self, chart, curves, planted};
use crate::app::panel::widgets::{instead_ui, named, section_ui};
use crate::app::results::Read;
use crate::teach::{BottomTab, Workspace};
use egui::{Align2, CentralPanel, Frame, Margin, Panel, ScrollArea, Sense, Shape, TextStyle, Ui, vec2};

pub struct WorkspaceParts<'a> {
    pub model: Read<'a>,
    pub widgets: &'a mut PaneWidgets,
    pub queue: &'a mut Queue,
}

/// In points; narrower windows have a menu.
const MIN_WIDTH_WITH_SWITCH: f32 = 900.0;

/// A workspace as it is drawn; `document::workspace` has what is set there.
struct Room {
    of: Workspace,
    has_content: fn(Read<'_>) -> bool,
    ui: fn(&mut Ui, &mut WorkspaceParts<'_>),
}

const ROOMS: [Room; 5] = {
    use Workspace::{Inspect, Lab, Matches, Pair, Trajectories};
    let with_poses = |model: Read<'_>| model.results.datasets.open.is_some() || !model.results.poses.is_empty();
    let with_dataset = |model: Read<'_>| model.results.datasets.open.is_some();
    [
        Room { of: Inspect, has_content: |_| true, ui: inspect_workspace_ui },
        Room { of: Pair, has_content: |model| model.results.slots.b.burst.is_some(), ui: pair::pair_workspace_ui },
        Room { of: Matches, has_content: with_dataset, ui: matches::matches_workspace_ui },
        Room { of: Trajectories, has_content: with_poses, ui: trajectories_workspace_ui },
        Room { of: Lab, has_content: |model| !model.lab_results().is_empty(), ui: lab_workspace_ui },
    ]
};

fn room(of: Workspace) -> &'static Room {
    ROOMS.iter().find(|room| room.of == of).expect("each workspace has a room")
}

/// Whether there is something for the workspace to show, or it is the open one.
fn is_offered((id, workspace): (ActionId, Workspace), model: Read<'_>) -> bool {
    let has_content = id != ActionId::WorkspaceMethods && (room(workspace).has_content)(model);
    has_content || checked(id, model) == Some(true)
}

/// Draws the switch between the workspaces, from the right end of a line: a button for each that has something to show,
/// or one menu where that is a single one, or there is no room.
pub fn switch_ui(ui: &mut egui::Ui, model: Read<'_>, queue: &mut Queue) {
    let is_narrow = model.shell.window_width_points < MIN_WIDTH_WITH_SWITCH;
    let (shown, more): (Vec<_>, Vec<_>) = workspaces().partition(|one| is_offered(*one, model));
    ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
        ui.spacing_mut().item_spacing.x = 2.0;
        let first = ui.cursor().right();
        if is_narrow || shown.len() == 1 {
            let open = workspaces().find(|(id, _)| checked(*id, model) == Some(true));
            let name = open.map_or("Workspace", |(id, _)| id.action().label);
            ui.menu_button(format!("{name} ⏷"), |ui| workspaces().for_each(|(id, _)| item_ui(ui, model, queue, id)));
        } else {
            if !more.is_empty() {
                ui.menu_button("More ⏷", |ui| more.iter().for_each(|(id, _)| item_ui(ui, model, queue, *id)));
            }
            for (id, _) in shown.into_iter().rev() {
                button_ui(ui, model, queue, id, None);
            }
        }
        let switch = ui.min_rect().intersect(egui::Rect::everything_left_of(first));
        crate::app::parts::mark(ui, crate::teach::Part::Workspaces, switch);
    });
}

pub fn workspace_ui(ui: &mut egui::Ui, parts: &mut WorkspaceParts<'_>) {
    (room(parts.model.document.workspace).ui)(ui, parts);
}

const BOTTOM_HEIGHTS: std::ops::RangeInclusive<f32> = 90.0..=520.0;

const PICTURES_HEIGHT: f32 = 320.0;

/// Widths of the panel on the left, points.
const LEFT_WIDTHS: std::ops::RangeInclusive<f32> = 250.0..=420.0;

fn side_frame(ui: &egui::Ui) -> egui::Frame {
    egui::Frame::side_top_panel(ui.style()).inner_margin(egui::Margin { left: 8, right: 5, top: 6, bottom: 4 })
}

/// Heights of panels in a hall, where they are all below the pictures, which need the width: on a projector of 1024×700
/// points a picture of 4:3 keeps 500 points.
const LEFT_IN_HALL: f32 = 150.0;
const BOTTOM_IN_HALL: f32 = 120.0;
/// Without and with the panel of the left side.
const RIGHT_IN_HALL: [f32; 2] = [240.0, 120.0];

/// `panel` at the side, which has the name `id`; below the pictures in a hall.
fn side(ui: &Ui, model: Read<'_>, (id, height): (&'static str, f32), panel: Panel) -> Panel {
    let below = || Panel::bottom(egui::Id::unique((id, "hall"))).exact_size(height).resizable(false);
    if model.document.panels.hall { below() } else { panel }.frame(side_frame(ui))
}

fn left_side(ui: &Ui, model: Read<'_>, id: &'static str, width: f32) -> Panel {
    side(ui, model, (id, LEFT_IN_HALL), Panel::left(id).default_size(width).size_range(LEFT_WIDTHS))
}

fn left_panel(ui: &mut Ui, model: Read<'_>, id: &'static str, width: f32, add_contents: impl FnOnce(&mut Ui)) {
    left_side(ui, model, id, width).show(ui, |ui| scroll_ui(ui, add_contents));
}

fn right_panel(
    ui: &mut Ui,
    model: Read<'_>,
    id: &'static str,
    width: f32,
    widths: std::ops::RangeInclusive<f32>,
    add_contents: impl FnOnce(&mut Ui),
) {
    let panel = Panel::right(id).default_size(width).size_range(widths);
    side(ui, model, (id, RIGHT_IN_HALL[usize::from(model.shows_left())]), panel).show(ui, add_contents);
}

/// Content of a side panel. One that is wider than the panel does not widen it: pictures stay where they are.
fn scroll_ui(ui: &mut Ui, add_contents: impl FnOnce(&mut Ui)) {
    let rect = ui.available_rect_before_wrap();
    let mut inner = ui.new_child(egui::UiBuilder::new().max_rect(rect));
    ScrollArea::vertical().auto_shrink(false).show(&mut inner, add_contents);
    ui.advance_cursor_after_rect(rect);
}

/// Draws a panel below the pictures, `height` points high until it is dragged, or less in a small window, whatever its
/// content, so that nothing moves under the pointer. Returns whether the pointer is over it.
fn bottom_panel(ui: &mut Ui, model: Read<'_>, id: &'static str, height: f32, show: impl FnOnce(&mut Ui)) -> bool {
    let frame = egui::Frame::side_top_panel(ui.style()).inner_margin(egui::Margin::symmetric(8, 4));
    let height = height.min(ui.available_height() - PICTURES_HEIGHT).max(*BOTTOM_HEIGHTS.start());
    let panel = egui::Panel::bottom(id).resizable(true).default_size(height).size_range(BOTTOM_HEIGHTS);
    let shown = side(ui, model, (id, BOTTOM_IN_HALL), panel).frame(frame).show(ui, |ui| {
        ui.take_available_height();
        show(ui);
    });
    ui.rect_contains_pointer(shown.response.rect)
}

/// Width of a panel at the side, in points; smaller in a small window, where the picture needs the space more.
fn side_width(model: Read<'_>) -> f32 {
    (0.235 * model.shell.window_width_points).clamp(280.0, 300.0)
}

const FOLDED_WIDTH: f32 = 22.0;

/// Draws the panel on the left as a strip with its name where it is folded; a click opens it.
pub(in crate::app::workspace) fn folded_ui(ui: &mut Ui, model: Read<'_>, queue: &mut Queue) {
    if model.folds_left() {
        strip_ui(ui, Panel::left("left folded"), ActionId::ToggleLeft, "slope, scale, parameters", queue);
    }
    if model.folds_right() {
        strip_ui(ui, Panel::right("right folded"), ActionId::ToggleRight, "the selected match, and display", queue);
    }
}

fn strip_ui(ui: &mut Ui, panel: Panel, toggle: ActionId, contents: &str, queue: &mut Queue) {
    let frame = Frame::side_top_panel(ui.style()).inner_margin(Margin::ZERO);
    panel.frame(frame).exact_size(FOLDED_WIDTH).resizable(false).show(ui, |ui| {
        let (rect, response) = ui.allocate_exact_size(ui.available_size(), Sense::click());
        let name = toggle.action().label;
        named(&response, egui::Role::Button, format!("Unfold {name}"));
        let (font, colour) = (TextStyle::Body.resolve(ui.style()), ui.style().interact(&response).text_color());
        let galley = ui.painter().layout_no_wrap(name.to_owned(), font, colour);
        let text = egui::epaint::TextShape::new(rect.center_top() + vec2(0.0, 12.0), galley, colour);
        let upwards = text.with_angle_and_anchor(std::f32::consts::FRAC_PI_2, Align2::LEFT_CENTER);
        ui.painter().add(Shape::Text(upwards));
        queue.push_if(response.on_hover_text(format!("Open the panel: {contents}")).clicked(), toggle);
    });
}

fn inspect_workspace_ui(ui: &mut egui::Ui, parts: &mut WorkspaceParts<'_>) {
    let (model, WorkspaceParts { widgets, queue, .. }) = (parts.model, parts);
    folded_ui(ui, model, queue);
    if model.shows_left() {
        left_side(ui, model, "left", side_width(model)).show(ui, |ui| {
            // The verdict stays in sight, and nothing above moves when it changes.
            let below = Frame::new().inner_margin(Margin { top: 4, ..Margin::ZERO });
            if !model.document.panels.hall {
                Panel::bottom("verdict").frame(below).show_separator_line(false).show(ui, |ui| {
                    panel::slopes::verdict_ui(ui, model, queue);
                });
            }
            scroll_ui(ui, |ui| {
                if model.document.compares_methods() {
                    panel::methods::controls_ui(ui, model, queue);
                }
                panel::cursor::cursor_ui(ui, model, queue);
                panel::parameters::parameters_ui(ui, model, queue);
            });
        });
    }
    if model.shows_right() {
        right_panel(ui, model, "right", side_width(model), 250.0..=460.0, |ui| {
            let help = "The value range of the pictures, and the selected feature";
            if panel::probe::probe_tab_ui(ui, model, "Display and feature", help, queue) {
                return;
            }
            scroll_ui(ui, |ui| {
                // What the panel came for is first.
                if model.document.selected.is_some() {
                    panel::selection::selection_ui(ui, model, queue);
                }
                panel::display::display_ui(ui, model, widgets, true, queue);
                if model.document.selected.is_none() {
                    panel::selection::selection_ui(ui, model, queue);
                }
            });
        });
    }
    let mut over_rows = None;
    if model.shows_bottom() {
        let show = |ui: &mut egui::Ui| panel::bottom::bottom_ui(ui, model, widgets, queue);
        let is_over = bottom_panel(ui, model, "bottom", 276.0, show);
        over_rows = Some(model.document.bottom_tab).filter(|_| is_over);
    } else if !model.document.panels.hall {
        let frame = Frame::side_top_panel(ui.style()).inner_margin(Margin::symmetric(8, 2));
        Panel::bottom("bottom tabs").frame(frame).show(ui, |ui| panel::bottom::closed_ui(ui, model, queue));
    }
    let pictures = CentralPanel::default().frame(Frame::new()).show(ui, |ui| {
        crate::app::parts::mark(ui, crate::teach::Part::Pictures, ui.max_rect());
        if model.document.compares_methods() && model.methods_shown().is_empty() {
            instead_ui(ui, "Choose methods in the table below");
            return Vec::new();
        }
        let drawn = inspector_ui(ui, model, widgets, queue);
        if model.document.compares_methods() {
            pair::lines::method_lines_ui(ui, model, &drawn);
        }
        drawn
    });
    // A hovered feature stays marked while the pointer is over it, in a picture or in a row of the open table.
    if pictures.inner.iter().all(|drawn| drawn.output.pointer_ui.is_none()) {
        if over_rows != Some(BottomTab::Table) {
            queue.point(&model.results.hovered, None, Pointed::Feature);
        }
        if over_rows != Some(BottomTab::Compared) {
            queue.point(&model.results.slots.a.comparison.hovered, None, |row| Pointed::Row(Side::A, row));
        }
        queue.point(&model.results.explained.pointed, None, Pointed::Candidate);
    }
}

fn lab_workspace_ui(ui: &mut Ui, parts: &mut WorkspaceParts<'_>) {
    let (model, WorkspaceParts { queue, .. }) = (parts.model, parts);
    if model.shows_left() {
        left_panel(ui, model, "lab left", side_width(model), |ui| lab::lab_settings_ui(ui, model, queue));
    }
    if model.shows_right() {
        right_panel(ui, model, "lab right", 1.3 * side_width(model), 250.0..=900.0, |ui| {
            if model.document.lab.question == LabQuestion::InBurst {
                section_ui(ui, "How faint", |ui| planted::lab_planted_ui(ui, model, queue));
            } else {
                section_ui(ui, "Chart", |ui| chart::lab_chart_ui(ui, model, queue));
            }
        });
    }
    CentralPanel::default().show(ui, |ui| curves::curves_ui(ui, model, queue));
}

const STRIP_HEIGHT: f32 = 84.0;

fn trajectories_workspace_ui(ui: &mut Ui, parts: &mut WorkspaceParts<'_>) {
    let (model, WorkspaceParts { queue, .. }) = (parts.model, parts);
    if model.shows_right() {
        right_panel(ui, model, "trajectories right", side_width(model).max(330.0), 280.0..=520.0, |ui| {
            scroll_ui(ui, |ui| errors_panel::errors_panel_ui(ui, model, queue));
        });
    }
    if model.shows_bottom() {
        bottom_panel(ui, model, "trajectories bottom", 331.0, |ui| {
            let strip = vec2(ui.available_width(), STRIP_HEIGHT);
            ui.allocate_ui(strip, |ui| cameras::points_strip_ui(ui, model, queue));
            ui.separator();
            cameras::camera_list_ui(ui, model, queue);
        });
    }
    CentralPanel::default().frame(Frame::new()).show(ui, |ui| {
        crate::app::parts::mark(ui, crate::teach::Part::Pictures, ui.max_rect());
        cameras::plane_ui(ui, model, queue);
    });
}
