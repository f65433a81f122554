//! Marks of the place under the pointer in all linked panes, and of the probed place in the panes of its burst.

use super::{Drawn, PaneWidgets, PlaceValue, chip_ui};
use crate::app::canvas::CanvasOutput;
use crate::app::document::{Action, Cursor, MethodId, Pointed, Queue, Side};
use crate::app::pane::{Content, Link, PaneId, place_in};
use crate::app::panel::widgets::dashed_circle;
use crate::app::results::Read;
use crate::burst::Positions;
use crate::detector::{Feature, Slope};
use crate::inspect::place::{AT_PLACE_PX, ProbeSubject};
use crate::inspect::words::slope_text;
use crate::requests::{PictureKind, ProbeQuestion};
use egui::{Align2, Color32, FontId, Key, Pos2, Stroke, Ui, pos2, vec2};
use std::ops::Range;

pub(super) fn marks_ui(model: Read<'_>, widgets: &mut PaneWidgets, drawn: &[Drawn]) {
    widgets.values.clear();
    let Some((first, pos_image)) = pointed(drawn) else { return };
    widgets.values.extend(value_at(model, widgets, first, pos_image));
    let is_linked = |drawn: &&Drawn| model.document.panes.has_link(drawn.pane, Link::Place);
    if !is_linked(&first) {
        return;
    }
    // Each linked pane shows the same place of the scene, at its own frame and slope.
    for other in drawn.iter().filter(|other| other.pane != first.pane).filter(is_linked) {
        let Some(pos) = same_place(model, first.shown, other.shown, pos_image) else { continue };
        let value = value_at(model, widgets, other, pos);
        let text = value.map(|value| value.readout.short_text());
        mark(&other.output, pos, text.as_deref(), POINTER);
        widgets.values.extend(value);
    }
}

/// The picture under the pointer, and the pointer's place in it.
fn pointed(drawn: &[Drawn]) -> Option<(&Drawn, Pos2)> {
    drawn.iter().find_map(|drawn| Some((drawn, drawn.output.hover_image?)))
}

pub(in crate::app) fn same_place(model: Read<'_>, from: PaneId, to: PaneId, pos_image: Pos2) -> Option<Pos2> {
    let (a, b) = (model.pane(from)?, model.pane(to)?);
    let kinds = [from, to].map(|id| model.picture_in(id).map(|picture| picture.request.kind));
    Some(place_in(pos_image, kinds[0]?, &a.cursor, kinds[1]?, &b.cursor, used(model, a.side)?))
}

fn value_at(model: Read<'_>, widgets: &PaneWidgets, drawn: &Drawn, pos_image: Pos2) -> Option<PlaceValue> {
    let readout = widgets.get(drawn.shown)?.picture.readout_at(model, drawn.shown, pos_image)?;
    Some(PlaceValue { id: drawn.pane, number: model.document.panes.number(drawn.pane)?, readout })
}

/// Draws a cross with a gap in its middle, so that the marked place can be seen, and a text beside it.
fn mark(output: &CanvasOutput, pos_image: Pos2, text: Option<&str>, colour: Color32) {
    let (painter, rect) = (&output.painter, output.response.rect);
    let centre = output.ui_from_image.pos(pos_image);
    if !rect.contains(centre) {
        return;
    }
    for (width, colour) in [(3.0, Color32::from_black_alpha(150)), (1.2, colour)] {
        for direction in [vec2(1.0, 0.0), vec2(-1.0, 0.0), vec2(0.0, 1.0), vec2(0.0, -1.0)] {
            painter.line_segment([centre + 3.0 * direction, centre + 10.0 * direction], Stroke::new(width, colour));
        }
    }
    let Some(text) = text else { return };
    let galley = painter.layout_no_wrap(text.to_owned(), FontId::monospace(11.0), Color32::WHITE);
    // Beside the mark, on the side with enough space.
    let right = centre.x + 14.0 + galley.size().x < rect.right();
    let anchor = if right { Align2::LEFT_BOTTOM } else { Align2::RIGHT_BOTTOM };
    let at = centre + vec2(if right { 8.0 } else { -8.0 }, -5.0);
    let ground = anchor.anchor_size(at, galley.size() + vec2(6.0, 2.0));
    painter.rect_filled(ground, 3.0, Color32::from_black_alpha(180));
    painter.galley(ground.min + vec2(3.0, 1.0), galley, Color32::WHITE);
}

/// Maps a place of pane `id` to mid-burst of the pane's burst; `None` for panes without a picture.
pub(in crate::app) fn mid_burst(model: Read<'_>, id: PaneId, pos_image: Pos2) -> Option<(Side, [f32; 2])> {
    // A gold standard was taken from a place of its own.
    let pane = model.pane(id).filter(|pane| pane.method != Some(MethodId::Gold))?;
    let kind = model.picture_in(id)?.request.kind;
    let middle = PictureKind::Stack { slope: pane.cursor.slope };
    let place = place_in(pos_image, kind, &pane.cursor, middle, &pane.cursor, used(model, pane.side)?);
    Some((pane.side, [place.x, place.y]))
}

/// Maps a mid-burst place of the burst of `side` that moves by `slope` to pane `id`; `None` for panes of the other burst.
fn in_pane(model: Read<'_>, id: PaneId, (side, place): (Side, [f32; 2]), slope: Slope) -> Option<Pos2> {
    let pane = model.pane(id).filter(|pane| pane.side == side)?;
    let kind = model.picture_in(id)?.request.kind;
    let cursor = Cursor { slope, ..pane.cursor };
    let [u, v] = place;
    Some(place_in(pos2(u, v), PictureKind::Stack { slope }, &cursor, kind, &cursor, used(model, pane.side)?))
}

/// Positions of the frames of a burst, and those of them that are searched.
fn used(model: Read<'_>, side: Side) -> Option<(&Positions, Range<usize>)> {
    let positions = &model.burst_of(side)?.burst.positions;
    Some((positions, model.results.slots[side].usable_params.used_frames(positions.len())))
}

/// Draws the probe's marks, and takes the place under the pointer: Shift+click probes it, any click ends following.
pub(super) fn probe_ui(ui: &Ui, model: Read<'_>, widgets: &PaneWidgets, drawn: &[Drawn], queue: &mut Queue) {
    place_marks_ui(model, drawn);
    probe_marks_ui(model, drawn);
    let pointed = pointed(drawn);
    let pointer = pointed.and_then(|(drawn, pos)| mid_burst(model, drawn.shown, pos));
    queue.set(&model.results.probed.pointer, pointer, |place| Action::Point(Pointed::Place(place)));
    let Some((drawn, _)) = pointed.filter(|(drawn, _)| drawn.output.response.clicked()) else { return };
    let with_shift = is_with_shift(ui);
    if !with_shift && !model.document.probe.follows {
        return;
    }
    queue.push_if(model.document.probe.follows, Action::StopFollowing);
    let Some((side, place)) = pointer else { return };
    // Features can be pointed at where they are listed, and with their circle; the place clicked stays the subject.
    let feature = widgets.get(drawn.shown).and_then(|widget| widget.picture.pointed).filter(|index| {
        let [u, v] = place;
        let is_at = |feature: &Feature| (feature.u - u).hypot(feature.v - v) <= AT_PLACE_PX;
        with_shift && model.document.workspace.inspects() && model.features().get(*index).is_some_and(is_at)
    });
    queue.push(match feature {
        Some(feature) => Action::ProbeFeature(Side::A, feature),
        None => Action::Probe(side, ProbeQuestion::At { place, wanted: ProbeSubject::Best }),
    });
}

/// What a pane showed before the pointer led its slope, while Ctrl is held.
#[derive(Clone, Copy)]
struct Before(PaneId, Content, Cursor);

const FOCUS: &str = "focus under the pointer";

/// Whether the pointer leads the slope now: all that it leads through is one step to undo.
pub fn is_led(ctx: &egui::Context) -> bool {
    ctx.data(|data| data.get_temp(egui::Id::unique(FOCUS))).unwrap_or(false)
}

/// Shows the place under the pointer at its own motion, while the switch is on or Ctrl is held. With Ctrl a click stays
/// at that slope; without one the pane goes back to what it showed.
pub(super) fn focus_ui(ui: &Ui, model: Read<'_>, drawn: &[Drawn], queue: &mut Queue) {
    let (flag, kept) = (egui::Id::unique(FOCUS), egui::Id::unique((FOCUS, "before")));
    // Ctrl alone: the key itself may be among those that are down.
    let is_ctrl = |key: &Key| matches!(key, Key::ControlLeft | Key::ControlRight | Key::SuperLeft | Key::SuperRight);
    let is_held = ui.input(|i| i.modifiers.command_only() && i.keys_down.iter().all(is_ctrl));
    let before: Option<Before> = ui.data(|data| data.get_temp(kept));
    if let Some(Before(id, content, cursor)) = before.filter(|_| !is_held) {
        ui.data_mut(|data| data.remove::<Before>(kept));
        queue.push(Action::SetSlope(id, cursor.slope));
        queue.push(match content {
            Content::Cursor => Action::Show(id, cursor.kind),
            content => Action::SetContent(id, content),
        });
    }
    let is_on = is_held || model.document.follows_focus;
    let led = pointed(drawn).filter(|_| is_on && model.document.workspace.inspects());
    ui.data_mut(|data| data.insert_temp(flag, led.is_some()));
    let Some((drawn, pos)) = led else { return };
    let id = drawn.pane;
    let (Some(pane), Some((side, [u, v]))) = (model.pane(id), mid_burst(model, drawn.shown, pos)) else {
        return;
    };
    let field = model.found_of(side).and_then(|found| found.detection.field.as_ref());
    let text = match (field, field.and_then(|field| field.known_at(u, v))) {
        (None, _) => "Focus needs the motions of a detection".to_owned(),
        (_, None) => "Here no motion is known".to_owned(),
        (_, Some(motion)) => {
            // A slope that differs by less looks the same, and would be computed for nothing.
            let is_other = (motion.slope.u - pane.cursor.slope.u).hypot(motion.slope.v - pane.cursor.slope.v) > 0.02;
            let is_sharp = pane.shown().is_some_and(|kind| kind.about().of_slope) && !is_other;
            if ui.input(|i| i.pointer.delta() != egui::Vec2::ZERO) && !is_sharp {
                if is_held && before.is_none() {
                    ui.data_mut(|data| data.insert_temp(kept, Before(id, pane.content, pane.cursor)));
                }
                queue.push(Action::Focus(id));
                queue.push(Action::SetSlope(id, motion.slope));
            }
            format!("Sharp at {} px/frame", slope_text(motion.slope))
        }
    };
    if drawn.output.response.clicked() {
        ui.data_mut(|data| data.remove::<Before>(kept));
    }
    chip_ui(ui, &drawn.output, Align2::LEFT_BOTTOM, &text, (FOCUS, id));
}

pub(in crate::app) fn is_with_shift(ui: &Ui) -> bool {
    ui.input(|i| {
        // The modifiers at the release count: Shift may be up again when the pass sees the click.
        let let_go = i.events.iter().rev().find_map(|event| match event {
            egui::Event::PointerButton { pressed: false, modifiers, .. } => Some(modifiers.shift),
            _ => None,
        });
        let_go.unwrap_or(i.modifiers.shift)
    })
}

/// Marks the pinned places of each picture's burst, as they lie at the slope on show.
fn place_marks_ui(model: Read<'_>, drawn: &[Drawn]) {
    for (drawn, pane) in drawn.iter().filter_map(|drawn| Some((drawn, model.pane(drawn.shown)?))) {
        // A gold standard was taken from a place of its own.
        let places = model.places_of(pane.side).filter(|_| pane.method != Some(MethodId::Gold));
        for (_, place) in places {
            if let Some(pos) = in_pane(model, drawn.shown, (pane.side, place.at), pane.cursor.slope) {
                mark(&drawn.output, pos, Some(&place.name), MARK);
            }
        }
    }
}

fn probe_marks_ui(model: Read<'_>, drawn: &[Drawn]) {
    let Some(place) = model.probed_place() else { return };
    let answer = model.results.probed.answer.as_ref().filter(|_| model.probe_is_current());
    let is_linked = |id: PaneId| model.document.panes.has_link(id, Link::Place);
    let side = model.document.probe.side;
    let is_probed = |id: PaneId| model.document.panes.is_on(id, side);
    // B's panes are not linked to A's; where none of the probed burst's panes is linked, all of them show the marks.
    let any_linked = drawn.iter().any(|drawn| is_probed(drawn.pane) && is_linked(drawn.pane));
    for drawn in drawn.iter().filter(|drawn| is_linked(drawn.pane) || !any_linked) {
        let own = model.pane(drawn.pane).map_or_else(Slope::default, |pane| pane.cursor.slope);
        let slope = answer.map_or(own, |answer| answer.probe.subject.slope);
        if let Some(pos) = in_pane(model, drawn.shown, (side, place), slope) {
            probe_mark(&drawn.output, pos);
        }
        let Some(probe) = answer.map(|answer| &answer.probe) else { continue };
        let Some(fate) = probe.subject_fate() else { continue };
        // The selected candidate, and the rival that beat it.
        if let Some(pos) = in_pane(model, drawn.shown, (side, fate.pos_image), fate.slope) {
            blob(&drawn.output, pos, fate.sigma, MARK);
        }
        let rival = fate.first_failed.and_then(|test| fate.report(test).rival);
        if let Some(rival) = rival
            && let Some(pos) = in_pane(model, drawn.shown, (side, rival.pos_image), rival.slope)
        {
            blob(&drawn.output, pos, rival.sigma, RIVAL);
        }
    }
}

const POINTER: Color32 = Color32::from_rgb(255, 214, 90);
const MARK: Color32 = Color32::from_rgb(80, 220, 255);
const RIVAL: Color32 = Color32::from_rgb(255, 120, 90);

fn probe_mark(output: &CanvasOutput, pos_image: Pos2) {
    let centre = output.ui_from_image.pos(pos_image);
    if !output.response.rect.contains(centre) {
        return;
    }
    for (width, colour) in [(4.0, Color32::from_black_alpha(170)), (2.0, MARK)] {
        for direction in [vec2(1.0, 1.0), vec2(-1.0, 1.0), vec2(1.0, -1.0), vec2(-1.0, -1.0)] {
            let direction = direction.normalized();
            let ends = [centre + 5.0 * direction, centre + 14.0 * direction];
            output.painter.line_segment(ends, Stroke::new(width, colour));
        }
    }
}

/// Draws a blob's circle, dashed to distinguish it from a feature.
fn blob(output: &CanvasOutput, pos_image: Pos2, sigma: f32, colour: Color32) {
    let centre = output.ui_from_image.pos(pos_image);
    let radius = (std::f32::consts::SQRT_2 * sigma * output.ui_from_image.scale()).max(4.0);
    if !output.response.rect.expand(radius).contains(centre) {
        return;
    }
    dashed_circle(&output.painter, centre, radius, Stroke::new(1.6, colour), (5.0, 4.0));
}
