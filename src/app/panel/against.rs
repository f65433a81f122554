//! Comparison of the features with a pinned result, a file or the truth: the list, and the marks over the pictures.

use crate::app::actions::{ActionId, Queue, button_ui};
use crate::app::canvas::CanvasOutput;
use crate::app::canvas::overlay::{CircleMark, circle_at, draw_circles};
use crate::app::document::{Action, Compared, Destination, Pointed, Reference, Side};
use crate::app::panel::table::{Heading, Listed, rows_ui, texts};
use crate::app::panel::widgets::{dashed_circle, progress_text, progress_ui, tip_ui};
use crate::app::results::Read;
use crate::app::results::comparison::{Row, Shown};
use crate::app::view::{fixed, signed_slope};
use crate::app::{inspector::PaneWidgets, pane::PaneId, panel::display};
use egui::{Align2, Button, Color32, Label, RichText, Sense, Stroke, Ui, pos2, vec2};

/// Colour of a comparison's outcome: distinct in hue and in lightness, and visible over a grey picture.
pub fn colour(with: Reference, kind: Compared) -> Color32 {
    match (with, kind) {
        (_, Compared::Theirs) => Color32::from_rgb(0xff, 0x6b, 0xb5),
        (_, Compared::WrongMotion) => Color32::from_rgb(0x4d, 0xd0, 0xe1),
        (Reference::Truth, Compared::Ours) => Color32::from_rgb(0xff, 0x8a, 0x3d),
        (Reference::Truth, Compared::Same) | (_, Compared::Ours) => Color32::from_rgb(0x5c, 0xe0, 0x7c),
        (_, Compared::Moved) => Color32::from_rgb(0xff, 0xd2, 0x4a),
        (_, Compared::Repeated) => Color32::from_rgb(0xc4, 0xa2, 0xff),
        (_, Compared::Same) => Color32::from_rgb(0x86, 0xb7, 0xee),
    }
}

fn switch_ui(ui: &mut Ui, model: Read<'_>, side: Side, queue: &mut Queue) {
    if model.document.workspace.shows_pair() {
        ui.label(RichText::new(format!("Features of {}", side.name())).strong());
    }
    for with in Reference::ALL {
        let (on, there) = (model.document.comparisons[side].with == Some(with), model.has_reference(side, with));
        let [label, help] = with.words();
        let button = Button::selectable(on, label).frame_when_inactive(true);
        let response = ui.add_enabled(there, button).on_hover_text(help).on_disabled_hover_text(help);
        queue.push_if(response.clicked(), Action::CompareWith(side, (!on).then_some(with)));
    }
    ui.separator();
    button_ui(ui, model, queue, ActionId::PinResult, Some("Pin"));
    match model.document.comparisons[side].with {
        Some(Reference::Pinned) => _ = button_ui(ui, model, queue, ActionId::UnpinResult, Some("Unpin")),
        Some(Reference::File) => _ = button_ui(ui, model, queue, ActionId::CloseFeatures, Some("Close")),
        Some(Reference::Truth) | None => {}
    }
    if let Some(running) = &model.results.slots[side].comparison.wanted.running {
        progress_ui(ui, running, Some(220.0), &progress_text(running));
    }
}

const PROBE_HELP: &str = "Say why there is a feature at its place, or why there is none";

pub fn against_ui(ui: &mut Ui, model: Read<'_>, widgets: &PaneWidgets, queue: &mut Queue) {
    let side = model.active_side();
    ui.horizontal_wrapped(|ui| switch_ui(ui, model, side, queue));
    let Some(shown) = &model.results.slots[side].comparison.shown else {
        ui.centered_and_justified(|ui| match model.results.slots[side].comparison.problem() {
            Some(problem) => ui.label(RichText::new(problem).color(ui.visuals().error_fg_color)),
            None => ui.weak(what_to_do(model, side)),
        });
        return;
    };
    ui.horizontal_wrapped(|ui| {
        ui.label(RichText::new(&shown.summary).strong());
        if model.shown_comparison(side).is_none() {
            ui.weak("(of the earlier features)");
        }
        // The button is there without a selected row too, so that selecting one moves nothing under the pointer.
        let selected = model.document.comparisons[side].selected.and_then(|row| shown.rows.get(row));
        let why = ui.add_enabled(selected.is_some(), Button::new("Why here?").small());
        let why = why.on_hover_text(PROBE_HELP).on_disabled_hover_text("Select a row first");
        if let Some(row) = selected.filter(|_| why.clicked()) {
            queue.push(Action::Probe(side, row.question()));
        }
        ui.separator();
        for &kind in Compared::of(shown.with) {
            let mut on = model.document.comparisons[side].shows(kind);
            let text = format!("{} {}", shown.label(kind), shown.count(kind));
            key_ui(ui, shown, kind);
            let response = ui.checkbox(&mut on, text).on_hover_text("Draw and list these");
            queue.push_if(response.changed(), Action::ShowKind(side, kind, on));
        }
    });
    if let Some(row) = table_ui(ui, model, side, shown, queue) {
        queue.push(Action::SelectRow(side, Some(row)));
        let seen = widgets.get(model.document.focus()).and_then(|widget| widget.picture.visible_image);
        let is_seen = |row: &Row| seen.is_some_and(|seen| seen.contains(row.pos_image.into()));
        if let Some(row) = shown.rows.get(row).filter(|row| !is_seen(row)) {
            queue.push(Action::GoTo(side, Destination { at: Some((row.pos_image, 0.0)), ..Destination::default() }));
        }
    }
}

fn what_to_do(model: Read<'_>, side: Side) -> &'static str {
    match model.document.comparisons[side].with {
        Some(_) if model.found_of(side).is_none() => {
            model.without_features(side, "Press Detect to find features to compare")
        }
        Some(_) => "Comparing…",
        None => "Pin a result, change a parameter and detect again; or open features from a file",
    }
}

/// Headings of the rows, and their widths, points; the note takes the rest.
const COLUMNS: [(&str, f32); 7] =
    [("", 104.0), ("u", 54.0), ("v", 54.0), ("σ", 44.0), ("Slope", 96.0), ("Ours", 48.0), ("", 0.0)];

/// Returns the clicked row.
fn table_ui(ui: &mut Ui, model: Read<'_>, side: Side, shown: &Shown, queue: &mut Queue) -> Option<usize> {
    let (set, hovered_before) = (&model.document.comparisons[side], model.results.slots[side].comparison.hovered);
    let items: Vec<usize> = (0..shown.rows.len()).filter(|&row| set.shows(shown.rows[row].kind)).collect();
    let listed = Listed { items: &items, selected: set.selected, hovered: hovered_before };
    let (mut clicked, mut hovered) = (None, None);
    let is_pointed_at = ui.rect_contains_pointer(ui.available_rect_before_wrap());
    let heading = |(text, width)| Heading { text, width, is_exact: width > 0.0, is_left: true, ..Heading::default() };
    let headings = COLUMNS.map(heading);
    let mut texts = texts(&headings, |column, index| text(&shown.rows[index], column));
    let contents_ui = |ui: &mut Ui, column: usize, index: usize| match (column, &shown.rows[index]) {
        (0, row) => {
            key_ui(ui, shown, row.kind);
            ui.add(Label::new(shown.label(row.kind)).selectable(false));
        }
        (6, row) => _ = ui.add(Label::new(&row.note).selectable(false).truncate()),
        _ => texts(ui, column, index),
    };
    let name = |index: usize| format!("{} {index}", shown.label(shown.rows[index].kind));
    rows_ui(ui, &headings, None, &listed, contents_ui, name, |response, index| {
        let row = &shown.rows[index];
        hovered = hovered.or(response.hovered().then_some(index));
        clicked = clicked.or(response.clicked().then_some(index));
        response.context_menu(|ui| {
            let response = ui.button("Probe this place").on_hover_text(PROBE_HELP);
            queue.push_if(response.clicked(), Action::Probe(side, row.question()));
        });
        if !row.note.is_empty() {
            response.clone().on_hover_text(&row.note);
        }
    });
    // The pointer may be over a picture instead, which then sets the hovered row.
    if is_pointed_at {
        queue.point(&hovered_before, hovered, |row| Pointed::Row(side, row));
    }
    clicked
}

fn text(row: &Row, column: usize) -> String {
    let or_dash = |text: Option<String>| text.unwrap_or_else(|| "–".to_owned());
    match column {
        1 => fixed(row.pos_image[0], 1),
        2 => fixed(row.pos_image[1], 1),
        3 => format!("{:.2}", row.sigma),
        4 => or_dash(row.slope.map(|slope| signed_slope(slope, 2))),
        _ => or_dash(row.feature.map(|index| format!("#{index}"))),
    }
}

pub struct RowsInPane<'a> {
    pub id: PaneId,
    pub side: Side,
    pub shown: &'a Shown,
    pub drawn: Vec<bool>,
}

/// Marks of the drawn rows, with the rows' indices; in a frame, at the frame's time.
fn marks_of(model: Read<'_>, place: &RowsInPane<'_>) -> (Vec<usize>, Vec<CircleMark>) {
    let RowsInPane { side, id, shown, .. } = *place;
    let dt = model.frames_from_middle(id, &shown.detection).unwrap_or_default();
    let pointed = [model.document.comparisons[side].selected, model.results.slots[side].comparison.hovered];
    let drawn = shown.rows.iter().enumerate().filter(|(index, row)| {
        model.document.comparisons[side].shows(row.kind) && (place.drawn[*index] || pointed.contains(&Some(*index)))
    });
    drawn
        .map(|(index, row)| {
            let (moved_u, moved_v) = row.slope.unwrap_or_default().displacement(dt);
            let at = |pos: [f32; 2]| pos2(pos[0] + moved_u, pos[1] + moved_v);
            let mark = CircleMark {
                pos_image: at(row.pos_image),
                sigma: row.sigma,
                from_image: row.from_image.map(at),
                colour: colour(shown.with, row.kind),
                dashed: row.kind == Compared::Theirs,
            };
            (index, mark)
        })
        .unzip()
}

pub fn marks_ui(ui: &Ui, model: Read<'_>, place: &RowsInPane<'_>, output: &CanvasOutput, queue: &mut Queue) {
    let RowsInPane { side, shown, .. } = *place;
    let (rows, marks) = marks_of(model, place);
    let clip = output.painter.clip_rect();
    // Candidates and matches lie on top.
    let is_over_match = model.document.workspace.shows_pair() && model.results.pair.hovered.is_some();
    let on_top = model.results.explained.pointed.is_none() && !is_over_match;
    let pointer = output.pointer_ui.filter(|pos| on_top && clip.contains(*pos));
    let pointed = pointer.and_then(|pos| circle_at(output, &marks, pos));
    let hovered_before = model.results.slots[side].comparison.hovered;
    let hovered = if pointer.is_some() { pointed.map(|mark| rows[mark]) } else { hovered_before };
    queue.point(&hovered_before, hovered, |row| Pointed::Row(side, row));
    if pointer.is_some() {
        // Features under the marks are not hovered.
        queue.point(&model.results.hovered, None, Pointed::Feature);
    }
    // A feature selected or hovered elsewhere is one of ours.
    let of_ours = |feature: usize| rows.iter().position(|row| shown.rows[*row].feature == Some(feature));
    let focus = hovered.or(model.document.comparisons[side].selected);
    let highlighted = focus.and_then(|row| rows.iter().position(|r| *r == row));
    let elsewhere = model.results.hovered.or(model.document.selected).filter(|_| side == Side::A);
    let highlighted = highlighted.or_else(|| elsewhere.and_then(of_ours));
    draw_circles(output, &marks, highlighted);
    queue.push_if(on_top && output.clicked_in_sight(), Action::SelectRow(side, pointed.map(|mark| rows[mark])));
    let Some(mark) = pointed.filter(|_| !output.response.dragged()) else { return };
    let row = &shown.rows[rows[mark]];
    let slope = row.slope.map_or_else(String::new, |s| format!("  slope ({}) px/frame", signed_slope(s, 2)));
    let note = if row.note.is_empty() { String::new() } else { format!("\n{}", row.note) };
    let text = format!("{}  σ {:.2} px{slope}{note}", shown.label(row.kind), row.sigma);
    tip_ui(ui, "compared tip", |ui| {
        ui.set_max_width(420.0);
        ui.label(text);
    });
}

pub fn legend_ui(ui: &mut Ui, model: Read<'_>, in_pane: &RowsInPane<'_>, output: &CanvasOutput, queue: &mut Queue) {
    let RowsInPane { side, shown, .. } = *in_pane;
    let is_shown = |kind: &Compared| model.document.comparisons[side].shows(*kind);
    let kinds: Vec<Compared> = Compared::of(shown.with).iter().copied().filter(is_shown).collect();
    let size = vec2(196.0, 16.0 + 18.0 * kinds.len() as f32);
    display::legend_ui(ui, model, (Align2::RIGHT_BOTTOM, output.response.rect, size), queue, |ui| {
        ui.spacing_mut().item_spacing.y = 2.0;
        for kind in kinds {
            ui.horizontal(|ui| {
                key_ui(ui, shown, kind);
                let rows = shown.rows.iter().zip(&in_pane.drawn);
                let drawn = rows.filter(|(row, drawn)| row.kind == kind && **drawn).count();
                let all = shown.count(kind);
                let count = if drawn < all { format!("{drawn} of {all}") } else { all.to_string() };
                ui.label(RichText::new(format!("{} {count}", shown.label(kind))).small());
            });
        }
    });
}

fn key_ui(ui: &mut Ui, shown: &Shown, kind: Compared) {
    let (rect, _) = ui.allocate_exact_size(vec2(14.0, 14.0), Sense::hover());
    // Dark as the pictures, so that the colours can be told apart in the light theme too.
    ui.painter().rect_filled(rect, 3.0, Color32::from_gray(40));
    let stroke = Stroke::new(1.6, colour(shown.with, kind));
    if kind == Compared::Theirs {
        dashed_circle(ui.painter(), rect.center(), 4.5, stroke, (3.0, 2.0));
    } else {
        ui.painter().circle_stroke(rect.center(), 4.5, stroke);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::apply::bench::{detected, feature, open};
    use crate::app::apply::{detection, opening};
    use std::time::Duration;

    #[test]
    fn an_empty_list_says_the_next_step() {
        let mut model = crate::app::results::Model::default();
        assert!(what_to_do(Read::of(&model), Side::A).starts_with("Pin a result"));
        model.document.comparisons.a.with = Some(Reference::Truth);
        assert!(what_to_do(Read::of(&model), Side::A).starts_with("Press Detect"));
        let burst = open((64, 48), 3);
        opening::take_burst(&mut model, burst.clone());
        let engine = crate::engine::Engine::new(std::sync::Arc::new(|| {}), 1 << 20);
        detection::start_detection(&mut model, Side::A, &engine);
        assert_eq!(what_to_do(Read::of(&model), Side::A), "Detecting…");
        assert!(!Read::of(&model).takes_advice(Side::A));
        model.results.slots.a.detecting.forget();
        assert!(Read::of(&model).takes_advice(Side::A));
        let params = model.document.params.clone();
        let features = vec![feature(10.0, 10.0, 1, &Read::of(&model).grid_of(Side::A))];
        detection::take_detection(&mut model, Side::A, detected(&burst, &params, features), Duration::ZERO);
        model.document.comparisons.a.with = Some(Reference::Truth);
        assert_eq!(what_to_do(Read::of(&model), Side::A), "Comparing…");
    }
}
