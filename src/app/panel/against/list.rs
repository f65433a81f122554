//! List of a comparison: its counts in a line, and a row for each feature.

use super::marks::{key_ui, select};
use crate::app::actions::{ActionId, Queue, button_ui};
use crate::app::inspector::PaneWidgets;
use crate::app::panel::sorted_table::ROW_HEIGHT;
use crate::app::panel::widgets::progress_text;
use crate::app::project::Model;
use crate::app::project::against::{Kind, Row, Shown, With};
use egui::{Align, Label, Layout, ProgressBar, RichText, Sense, Ui, pos2};
use egui_extras::{Column, TableBuilder};

/// Draws the switch between the things to compare with.
fn switch_ui(ui: &mut Ui, model: &mut Model, queue: &mut Queue) {
    for with in With::ALL {
        let (on, there) = (model.against.with == Some(with), model.against.has(with));
        let button = egui::Button::selectable(on, with.label()).frame_when_inactive(true);
        let response = ui.add_enabled(there, button).on_hover_text(with.help()).on_disabled_hover_text(with.help());
        if response.clicked() {
            model.against.show((!on).then_some(with));
        }
    }
    ui.separator();
    button_ui(ui, model, queue, ActionId::PinResult, Some("Pin"));
    match model.against.with {
        Some(With::Pinned) => {
            button_ui(ui, model, queue, ActionId::UnpinResult, Some("Unpin"));
        }
        Some(With::File) => {
            button_ui(ui, model, queue, ActionId::CloseFeatures, Some("Close"));
        }
        Some(With::Truth) | None => {}
    }
    if let Some(running) = &model.against.wanted.running() {
        let fraction = running.progress.map_or(0.0, |p| p.fraction);
        ui.add(ProgressBar::new(fraction).desired_width(220.0).text(progress_text(running)));
    }
}

const PROBE_HELP: &str = "Say why there is a feature at its place, or why there is none";

/// Draws the list, or the reason why there is none.
pub fn against_ui(ui: &mut Ui, model: &mut Model, widgets: &PaneWidgets, queue: &mut Queue) {
    ui.horizontal_wrapped(|ui| switch_ui(ui, model, queue));
    let Some(shown) = model.against.shown.clone() else {
        ui.centered_and_justified(|ui| match &model.against.problem {
            Some(problem) => ui.label(RichText::new(problem).color(ui.visuals().error_fg_color)),
            None => ui.weak(what_to_do(model)),
        });
        return;
    };
    ui.horizontal_wrapped(|ui| {
        ui.label(RichText::new(&shown.summary).strong());
        if model.shown_comparison().is_none() {
            ui.weak("(of the earlier features)");
        }
        if let Some(row) = model.against.selected.and_then(|row| shown.rows.get(row))
            && ui.small_button("Why here?").on_hover_text(PROBE_HELP).clicked()
        {
            model.probe_place(row.pos_image);
        }
        ui.separator();
        for &kind in Kind::of(shown.with) {
            let mut on = model.against.shows(kind);
            let text = format!("{} {}", shown.label(kind), shown.count(kind));
            key_ui(ui, &shown, kind);
            if ui.checkbox(&mut on, text).on_hover_text("Draw and list these").changed() {
                model.against.hidden.retain(|hidden| *hidden != kind);
                if !on {
                    model.against.hidden.push(kind);
                }
            }
        }
    });
    let (clicked, probed) = table_ui(ui, model, &shown);
    if let Some(row) = probed.and_then(|row| shown.rows.get(row)) {
        model.probe_place(row.pos_image);
    }
    if let Some(row) = clicked {
        let selected = (model.against.selected != Some(row)).then_some(row);
        select(model, &shown, selected);
        if let Some(row) = selected.and_then(|row| shown.rows.get(row)) {
            bring_into_view(model, widgets, row);
        }
    }
}

fn what_to_do(model: &Model) -> &'static str {
    match model.against.with {
        Some(_) if model.slots.a.found.is_none() => "Press Detect to find features to compare",
        Some(_) => "Comparing…",
        None => "Pin a result, change a parameter and detect again; or open features from a file",
    }
}

/// Draws the rows; returns the clicked row, and the one whose place is to be probed.
fn table_ui(ui: &mut Ui, model: &mut Model, shown: &Shown) -> (Option<usize>, Option<usize>) {
    let listed: Vec<usize> = (0..shown.rows.len()).filter(|&row| model.against.shows(shown.rows[row].kind)).collect();
    let (mut clicked, mut hovered, mut probed) = (None, None, None);
    let is_pointed_at = ui.rect_contains_pointer(ui.available_rect_before_wrap());
    let table = TableBuilder::new(ui)
        .striped(true)
        .sense(Sense::click())
        .cell_layout(Layout::left_to_right(Align::Center))
        .min_scrolled_height(0.0)
        .auto_shrink(false)
        .column(Column::exact(104.0))
        .columns(Column::exact(54.0), 2)
        .column(Column::exact(44.0))
        .column(Column::exact(96.0))
        .column(Column::exact(48.0))
        .column(Column::remainder().clip(true));
    table
        .header(20.0, |mut header| {
            for heading in ["", "u", "v", "σ", "Slope", "Ours", ""] {
                header.col(|ui| {
                    ui.label(RichText::new(heading).small());
                });
            }
        })
        .body(|body| {
            body.rows(ROW_HEIGHT, listed.len(), |mut table_row| {
                let index = listed[table_row.index()];
                let row = &shown.rows[index];
                table_row.set_selected(model.against.selected == Some(index));
                table_row.set_hovered(model.against.hovered == Some(index));
                table_row.col(|ui| {
                    key_ui(ui, shown, row.kind);
                    ui.add(Label::new(shown.label(row.kind)).selectable(false));
                });
                for text in cells(row) {
                    table_row.col(|ui| {
                        ui.add(Label::new(RichText::new(text).monospace()).selectable(false).extend());
                    });
                }
                table_row.col(|ui| {
                    ui.add(Label::new(&row.note).selectable(false).truncate());
                });
                let response = table_row.response();
                let name = format!("{} {}", shown.label(row.kind), index + 1);
                response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Row, true, &name));
                if response.hovered() {
                    hovered = Some(index);
                }
                if response.clicked() {
                    clicked = Some(index);
                }
                response.context_menu(|ui| {
                    if ui.button("Probe this place").on_hover_text(PROBE_HELP).clicked() {
                        probed = Some(index);
                    }
                });
                if !row.note.is_empty() {
                    response.on_hover_text(&row.note);
                }
            });
        });
    // The pointer may be over a picture instead, which then sets the hovered row.
    if is_pointed_at {
        model.against.hovered = hovered;
    }
    (clicked, probed)
}

fn cells(row: &Row) -> [String; 5] {
    [
        format!("{:.1}", row.pos_image[0]),
        format!("{:.1}", row.pos_image[1]),
        format!("{:.2}", row.sigma),
        row.slope.map_or_else(|| "–".to_owned(), |s| format!("{:+.2}, {:+.2}", s.u, s.v)),
        row.feature.map_or_else(|| "–".to_owned(), |index| format!("#{}", index + 1)),
    ]
}

/// Moves the focused picture where the row's place is not visible.
fn bring_into_view(model: &mut Model, widgets: &PaneWidgets, row: &Row) {
    let focus = model.focus();
    let place = pos2(row.pos_image[0], row.pos_image[1]);
    let seen = widgets.get(focus).and_then(|widget| widget.picture.visible_image).is_some_and(|v| v.contains(place));
    if !seen {
        let pane = model.focused_mut();
        let before = pane.view;
        let zoom = pane.view.points_per_pixel();
        pane.view.look_at(place, zoom);
        model.panes.follow_view(focus, &before);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::project::against::{Kind, With};
    use crate::app::project::tests::{detected, feature, open};
    use crate::detector::Slope;
    use std::time::Duration;

    #[test]
    fn a_row_says_dashes_for_what_it_has_not() {
        let row = Row {
            kind: Kind::Theirs,
            pos_image: [10.04, 20.0],
            from_image: None,
            sigma: 2.345,
            slope: None,
            feature: None,
            note: String::new(),
        };
        assert_eq!(cells(&row), ["10.0", "20.0", "2.35", "–", "–"]);
        let ours = Row { slope: Some(Slope::new(-1.0, 0.25)), feature: Some(4), kind: Kind::Ours, ..row };
        assert_eq!(cells(&ours)[3..], ["-1.00, +0.25", "#5"], "features are counted from one");
    }

    #[test]
    fn an_empty_list_says_the_next_step() {
        let mut model = Model::default();
        assert!(what_to_do(&model).starts_with("Pin a result"));
        model.against.with = Some(With::Truth);
        assert!(what_to_do(&model).starts_with("Press Detect"));
        let burst = open((64, 48), 3);
        model.take_burst(burst.clone());
        let params = model.params.clone();
        let features = vec![feature(10.0, 10.0, 1, &params.slopes)];
        model.take_detection(crate::app::project::side::Side::A, detected(&burst, &params, features), Duration::ZERO);
        model.against.with = Some(With::Truth);
        assert_eq!(what_to_do(&model), "Comparing…");
    }
}
