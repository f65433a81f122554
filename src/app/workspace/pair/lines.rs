//! The matches over the two pictures: drawn, pointed at, chosen, and where a point can be in the other picture.

use crate::app::actions::{ActionId, Queue};
use crate::app::canvas::CanvasOutput;
use crate::app::canvas::overlay::{self, MatchLine, MatchLineStyle, Pane};
use crate::app::panel::features::{at_time, frames_from_middle};
use crate::app::project::Model;
use crate::app::project::pair::{MatchRow, Matches, Side};
use crate::app::workspace::pair::table::match_menu_ui;
use crate::detector::Feature;
use egui::{Color32, Painter, Pos2, RichText, Shape, Stroke, Ui, pos2};

/// Draws the matches over the canvases of A and B and lets the pointer choose among them. Answers which one it is over;
/// `None` while it is over neither canvas.
pub fn lines_ui(ui: &Ui, model: &mut Model, outputs: &[CanvasOutput; 2], queue: &mut Queue) -> Option<Option<usize>> {
    let pointer = outputs.iter().find_map(|output| output.pointer_ui);
    let Some(matches) = model.pair.matches.clone() else {
        return pointer.map(|_| None);
    };
    let panes = [0, 1].map(|i| Pane { ui_from_image: outputs[i].ui_from_image, rect_ui: outputs[i].response.rect });
    let shifts = Side::BOTH.map(|side| shift(model, &matches, side));
    let look = model.pair.look;
    let alone = model.pair.selected.filter(|_| look.alone);
    let drawn: Vec<MatchLine> = model
        .pair
        .listed
        .iter()
        .copied()
        .filter(|index| alone.is_none_or(|one| one == *index))
        // A match that is selected stays, even where its kind is hidden.
        .chain(model.pair.selected.filter(|s| !model.pair.listed.contains(s)))
        .filter_map(|index| Some(line_of(&matches.row(index)?, shifts)))
        .collect();
    let pointed = pointer.and_then(|pos| overlay::match_at(&drawn, &panes, pos));
    let dragged = outputs.iter().any(|output| output.response.dragged());
    let hovered = if pointer.is_some() { pointed } else { model.pair.hovered };
    let focus = model.pair.selected.or(hovered);
    let painter = ui.painter_at(panes[0].rect_ui.union(panes[1].rect_ui));
    if look.geometry
        && let Some(row) = focus.and_then(|index| matches.row(index))
    {
        locus_ui(&painter, model, &matches, &row, outputs);
    }
    let style =
        MatchLineStyle { opacity: look.opacity, selected: model.pair.selected, hovered, others_faint: focus.is_some() };
    overlay::draw_match_lines(&painter, &panes, &drawn, &style);
    if let Some(row) = focus.and_then(|index| matches.row(index)) {
        for (side, output) in Side::BOTH.into_iter().zip(outputs) {
            let feature = if side == Side::A { row.a } else { row.b };
            circle_ui(model, &matches, side, at_time(feature, shifts[side as usize]), output);
        }
    }
    for (side, output) in Side::BOTH.into_iter().zip(outputs) {
        if output.response.clicked() {
            model.pair.selected = pointed;
            model.pair.active = side;
            // Where there is no line, a feature of A can be asked about.
            model.pair.lost.selected = None;
            if pointed.is_none() && side == Side::A {
                let feature = output
                    .response
                    .interact_pointer_pos()
                    .and_then(|pos| feature_of_a(&matches, shifts[0], output, pos));
                model.ask_feature(feature);
            }
        }
    }
    menus_ui(ui, model, &matches, outputs, pointed, queue);
    if let Some(row) = pointed.filter(|_| !dragged).and_then(|index| matches.row(index)) {
        tip_ui(ui, &row);
    }
    pointer.map(|_| pointed)
}

/// The feature of A at `pos`, in points.
fn feature_of_a(matches: &Matches, shift: f32, output: &CanvasOutput, pos: Pos2) -> Option<usize> {
    let placed: Vec<Feature> = matches.detection(Side::A).features.iter().map(|f| at_time(f, shift)).collect();
    overlay::feature_at(&placed, None, output.ui_from_image, pos)
}

/// What a click with the second button on a line shows.
fn menus_ui(
    ui: &Ui,
    model: &mut Model,
    matches: &Matches,
    outputs: &[CanvasOutput; 2],
    pointed: Option<usize>,
    queue: &mut Queue,
) {
    for output in outputs {
        // The match that the menu is about is the one that was under the pointer when it was opened.
        let key = output.response.id.with("menu of match");
        if output.response.secondary_clicked() {
            ui.data_mut(|data| data.insert_temp(key, pointed));
        }
        let about: Option<usize> = ui.data(|data| data.get_temp(key)).flatten();
        let Some(row) = about.and_then(|index| matches.row(index)) else { continue };
        output.response.context_menu(|ui| {
            if match_menu_ui(ui, &row) {
                model.pair.selected = Some(row.index);
                queue.push(ActionId::GoToFeature);
            }
        });
    }
}

/// How many frames the frame on show is after mid-burst, 0 where no frame is on show.
fn shift(model: &Model, matches: &Matches, side: Side) -> f32 {
    frames_from_middle(model.picture_of(side), matches.detection(side)).unwrap_or(0.0)
}

fn line_of(row: &MatchRow<'_>, shifts: [f32; 2]) -> MatchLine {
    let place = |f: &Feature, dt: f32| {
        let f = at_time(f, dt);
        pos2(f.u, f.v)
    };
    MatchLine {
        index: row.index,
        a: place(row.a, shifts[0]),
        b: place(row.b, shifts[1]),
        kind: overlay::LineKind::of(row.inlier),
    }
}

/// The feature of the match that is looked at, as it is drawn everywhere else.
fn circle_ui(model: &Model, matches: &Matches, side: Side, feature: Feature, output: &CanvasOutput) {
    let detection = matches.detection(side);
    let scale = overlay::ColourScale::of(model.colour_by, &detection.features);
    let style = overlay::OverlayStyle {
        selected: Some(0),
        motion: model.look.motion_vectors,
        ..overlay::OverlayStyle::new(&scale, detection.frames_used.len())
    };
    overlay::draw_features(output, &[feature], &style);
}

/// Where in each picture the other picture's point can be.
fn locus_ui(painter: &Painter, model: &Model, matches: &Matches, row: &MatchRow<'_>, outputs: &[CanvasOutput; 2]) {
    let Some(geometry) = matches.model() else { return };
    let place = |f: &Feature| [f64::from(f.u), f64::from(f.v)];
    for (side, output) in Side::BOTH.into_iter().zip(outputs) {
        let Some(size) = model.burst_of(side).map(|open| open.burst.size()) else { continue };
        let locus = match side {
            Side::A => geometry.locus_in_a(place(row.b), size),
            Side::B => geometry.locus_in_b(place(row.a), size),
        };
        let points: Vec<Pos2> =
            locus.iter().map(|p| output.ui_from_image.pos(pos2(p[0] as f32, p[1] as f32))).collect();
        let painter = painter.with_clip_rect(output.response.rect);
        for (width, colour) in [(3.0, Color32::from_black_alpha(130)), (1.2, Color32::from_white_alpha(210))] {
            let stroke = Stroke::new(width, colour);
            match points.as_slice() {
                [] => {}
                // A homography says exactly where.
                [one] => {
                    for diagonal in [egui::vec2(6.0, 6.0), egui::vec2(6.0, -6.0)] {
                        painter.line_segment([*one - diagonal, *one + diagonal], stroke);
                    }
                }
                _ => {
                    painter.add(Shape::line(points.clone(), stroke));
                }
            }
        }
    }
}

/// The numbers of the match under the pointer.
fn tip_ui(ui: &Ui, row: &MatchRow<'_>) {
    let verdict = match row.inlier {
        Some(true) => "  inlier",
        Some(false) => "  outlier",
        None => "",
    };
    let error = row.error_px.map_or_else(String::new, |e| format!("  error {} px", crate::app::canvas::number(e, 3)));
    let text = format!(
        "Match {}{verdict}\ndistance {:.1}  ratio {:.3}{error}\nslopes ({:+.2}, {:+.2}) and ({:+.2}, {:+.2}) px/frame",
        row.index + 1,
        row.found.distance,
        row.found.ratio,
        row.a.slope.u,
        row.a.slope.v,
        row.b.slope.u,
        row.b.slope.v
    );
    let (id, anchor) = (egui::Id::unique("match tip"), egui::PopupAnchor::Pointer);
    egui::Tooltip::always_open(ui.ctx().clone(), ui.layer_id(), id, anchor)
        .gap(14.0)
        .show(|ui| ui.label(RichText::new(text).monospace()));
}
