//! Marks of the place under the pointer in all linked panes, and of the probed place in the panes of its burst.

use super::{Drawn, PaneWidgets, PlaceValue, chip_ui};
use crate::app::canvas::CanvasOutput;
use crate::app::document::{Action, Cursor, MethodId, Pointed, Queue, RangeClass, Side};
use crate::app::pane::{Content, Link, PaneId, place_in};
use crate::app::panel::selection::draw_square;
use crate::app::panel::widgets::{dashed_circle, named};
use crate::app::results::Read;
use crate::burst::Positions;
use crate::detector::{Feature, Slope};
use crate::inspect::place::{AT_PLACE_PX, ProbeSubject};
use crate::inspect::words::slope_text;
use crate::requests::{PictureKind, ProbeQuestion};
use egui::{Align2, Color32, FontId, Key, Pos2, Rect, Role, Sense, Stroke, StrokeKind, Ui, Vec2, pos2, vec2};
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
        mark(&other.output, pos, value.map(|value| value.readout.short_text()).as_deref(), POINTER);
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

/// Draws the arms of a cross, `first` and its turns, with a gap in its middle, so that the marked place can be seen.
/// Returns the place in the window, if it is in sight.
fn cross(
    output: &CanvasOutput,
    pos_image: Pos2,
    first: Vec2,
    [from, to]: [f32; 2],
    strokes: [Stroke; 2],
) -> Option<Pos2> {
    let centre = output.ui_from_image.pos(pos_image);
    if !output.response.rect.contains(centre) {
        return None;
    }
    for stroke in strokes {
        for direction in [first, first.rot90(), -first, -first.rot90()] {
            output.painter.line_segment([centre + from * direction, centre + to * direction], stroke);
        }
    }
    Some(centre)
}

fn mark(output: &CanvasOutput, pos_image: Pos2, text: Option<&str>, colour: Color32) {
    let (painter, rect) = (&output.painter, output.response.rect);
    let strokes = [Stroke::new(3.0, Color32::from_black_alpha(150)), Stroke::new(1.2, colour)];
    let centre = cross(output, pos_image, vec2(1.0, 0.0), [3.0, 10.0], strokes);
    let Some((centre, text)) = centre.zip(text) else { return };
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

/// Maps a mid-burst place of the burst of `side` that moves by `slope` to pane `id`; `None` for the other burst's.
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

/// Shows the place under the pointer at its own motion, in the whole pane or in a loupe, while the switch is on or Ctrl
/// is held. A click takes that slope; without one the pane goes back to what it showed when Ctrl is let go.
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
    let in_loupe = led.is_some() && model.document.panels.loupe;
    ui.data_mut(|data| data.insert_temp(flag, led.is_some() && !in_loupe));
    let here = led.and_then(|(drawn, pos)| Some((drawn, mid_burst(model, drawn.shown, pos)?)));
    let motion = here.map(|(_, (side, [u, v]))| {
        let field = model.found_of(side).and_then(|found| found.detection.field.as_ref());
        let motion = field.ok_or("Focus needs the motions of a detection")?.known_at(u, v);
        motion.map(|motion| motion.slope).ok_or("Here no motion is known")
    });
    let loupe = here.zip(motion).filter(|_| in_loupe).and_then(|((_, (side, _)), motion)| {
        // Slopes that differ by less look the same, and would be computed for nothing.
        let rounded = |x: f32| (50.0 * x).round() / 50.0;
        motion.ok().map(|slope| (side, Slope::new(rounded(slope.u), rounded(slope.v))))
    });
    queue.set(&model.results.patches.loupe, loupe, |loupe| Pointed::Loupe(loupe).into());
    let (Some((drawn, (_, place))), Some(motion)) = (here, motion) else { return };
    let id = drawn.pane;
    let Some(pane) = model.pane(id) else { return };
    let is_clicked = drawn.output.response.clicked();
    let text = |slope: Slope| format!("Sharp at {} px/frame", slope_text(slope));
    let text = match (motion, loupe) {
        (Err(why), _) => why.to_owned(),
        (_, Some((side, slope))) => {
            let is_taken = is_clicked && !is_with_shift(ui);
            queue.push_if(is_taken, Action::Focus(id));
            queue.push_if(is_taken, Action::SetSlope(drawn.shown, slope));
            if loupe_ui(ui, model, drawn, (side, place, slope), &text(slope)).is_some() {
                return;
            }
            text(slope)
        }
        (Ok(slope), None) => {
            // A slope that differs by less looks the same, and would be computed for nothing.
            let is_other = (slope.u - pane.cursor.slope.u).hypot(slope.v - pane.cursor.slope.v) > 0.02;
            let is_sharp = pane.shown().is_some_and(|kind| kind.about().of_slope) && !is_other;
            if ui.input(|i| i.pointer.delta() != Vec2::ZERO) && !is_sharp {
                if is_held && before.is_none() {
                    ui.data_mut(|data| data.insert_temp(kept, Before(id, pane.content, pane.cursor)));
                }
                queue.push(Action::Focus(id));
                queue.push(Action::SetSlope(id, slope));
            }
            text(slope)
        }
    };
    if is_clicked {
        ui.data_mut(|data| data.remove::<Before>(kept));
    }
    chip_ui(ui, &drawn.output, Align2::LEFT_BOTTOM, &text, (FOCUS, id));
}

/// Points between the loupe and its place, and around the patches.
const AWAY: f32 = 18.0;
const GAP: f32 = 6.0;
/// Sides of the patches, points, the largest first: the first that fits is drawn.
const PATCH_SIDES: [f32; 4] = [104.0, 80.0, 60.0, 44.0];

/// Draws a place at mid-burst that moves by `slope` beside the pointer: in one frame, in the motion stack at that
/// slope, and all in focus, with `text` below. `None` where the pane has no room beside the place.
fn loupe_ui(
    ui: &Ui,
    model: Read<'_>,
    drawn: &Drawn,
    (side, [u, v], slope): (Side, [f32; 2], Slope),
    text: &str,
) -> Option<()> {
    let (output, pane, open) = (&drawn.output, model.pane(drawn.shown)?, model.burst_of(side)?);
    let (positions, frames) = used(model, side)?;
    let frame = pane.cursor.frame.min(positions.len().checked_sub(1)?);
    let (du, dv) = slope.displacement(positions.offset_from(frames, frame).to_f32());
    let in_focus = model.results.patches.in_focus.as_ref().filter(|of| of.request.burst.id == open.id);
    let clip = output.response.rect.intersect(ui.clip_rect());
    let painter = ui.painter_at(clip);
    let galley = |text: String, size| painter.layout_no_wrap(text, FontId::proportional(size), Color32::WHITE);
    let patches = [
        (galley(format!("Frame {frame}"), 11.0), Some(&open.burst.frames[frame]), [u + du, v + dv]),
        (galley("Stack".to_owned(), 11.0), model.stack_at(side, slope), [u, v]),
        (galley("In focus".to_owned(), 11.0), in_focus.map(|picture| &picture.plane), [u, v]),
    ];
    let below = galley(text.to_owned(), 13.0);
    let widest = patches.iter().map(|(name, ..)| name.size().x).fold(0.0, f32::max);
    let above = patches[0].0.size().y + 2.0;
    let size = |side: f32| {
        let width = (3.0 * side + 2.0 * GAP).max(below.size().x);
        vec2(width, above + side + GAP + below.size().y) + Vec2::splat(2.0 * GAP)
    };
    let pointer = output.pointer_ui?;
    let mut sides = PATCH_SIDES.into_iter().filter(|side| *side >= widest);
    let (side, ground) = sides.find_map(|side| Some((side, beside(pointer, clip, size(side))?)))?;
    painter.rect_filled(ground, 4.0, Color32::from_black_alpha(190));
    let id = output.response.id.with("loupe");
    named(&ui.interact(ground, id, Sense::hover()), Role::Label, text);
    painter.galley(ground.left_bottom() + vec2(GAP, -GAP - below.size().y), below, Color32::WHITE);
    // All patches share a range of brightnesses of the pane, so that they compare.
    let is_frame = model.range_class(drawn.shown) == RangeClass::Frame;
    let class = if is_frame { RangeClass::Frame } else { RangeClass::Intensity };
    let display = model.document.ranges_of(pane).display(class);
    // Twice as large as in the pane, but no fewer pixels than tell something, and no more than can be told apart.
    let half_px = (0.25 * side / output.ui_from_image.scale()).clamp(6.0, 32.0);
    let first = pos2(ground.center().x - 1.5 * side - GAP, ground.top() + GAP);
    for (index, (name, plane, [u, v])) in patches.into_iter().enumerate() {
        let at = first + vec2(index as f32 * (side + GAP), 0.0);
        let patch = Rect::from_min_size(at + vec2(0.0, above), Vec2::splat(side));
        draw_square(ui, (&format!("loupe {index}"), patch), plane, [u, v, half_px, 0.0], display);
        painter.rect_stroke(patch, 0.0, Stroke::new(1.0, Color32::GRAY), StrokeKind::Inside);
        let response = ui.interact(patch, id.with(index), Sense::hover());
        named(&response, Role::Image, format!("{} in the loupe", name.text()));
        painter.galley(at, name, Color32::WHITE);
    }
    Some(())
}

/// Rectangle of `size` within `clip`, beside `place`: on the right, or where there is room; `None` where there is none.
fn beside(place: Pos2, clip: Rect, size: Vec2) -> Option<Rect> {
    let centres = Rect::from_min_max(clip.min + 0.5 * size, clip.max - 0.5 * size);
    let away = 0.5 * size + Vec2::splat(AWAY);
    let directions = [vec2(away.x, 0.0), vec2(-away.x, 0.0), vec2(0.0, away.y), vec2(0.0, -away.y)];
    let rect = |direction| Rect::from_center_size(centres.clamp(place + direction), size);
    // Kept within the clip, a rectangle may come too near to the place.
    let is_away = |rect: &Rect| !rect.expand(AWAY - 1.0).contains(place);
    if centres.is_negative() { None } else { directions.into_iter().map(rect).find(is_away) }
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
        for (_, place) in model.places_of(pane.side).filter(|_| pane.method != Some(MethodId::Gold)) {
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
            let strokes = [Stroke::new(4.0, Color32::from_black_alpha(170)), Stroke::new(2.0, MARK)];
            cross(&drawn.output, pos, vec2(1.0, 1.0).normalized(), [5.0, 14.0], strokes);
        }
        let Some(probe) = answer.map(|answer| &answer.probe) else { continue };
        let Some(fate) = probe.subject_fate() else { continue };
        // The selected candidate, and the rival that beat it.
        if let Some(pos) = in_pane(model, drawn.shown, (side, fate.pos_image), fate.slope) {
            blob(&drawn.output, pos, fate.sigma, MARK);
        }
        let Some(rival) = fate.first_failed.and_then(|test| fate.report(test).rival) else { continue };
        if let Some(pos) = in_pane(model, drawn.shown, (side, rival.pos_image), rival.slope) {
            blob(&drawn.output, pos, rival.sigma, RIVAL);
        }
    }
}

const POINTER: Color32 = Color32::from_rgb(255, 214, 90);
const MARK: Color32 = Color32::from_rgb(80, 220, 255);
const RIVAL: Color32 = Color32::from_rgb(255, 120, 90);

/// Draws a blob's circle, dashed to distinguish it from a feature.
fn blob(output: &CanvasOutput, pos_image: Pos2, sigma: f32, colour: Color32) {
    let centre = output.ui_from_image.pos(pos_image);
    let radius = (std::f32::consts::SQRT_2 * sigma * output.ui_from_image.scale()).max(4.0);
    if !output.response.rect.expand(radius).contains(centre) {
        return;
    }
    dashed_circle(&output.painter, centre, radius, Stroke::new(1.6, colour), (5.0, 4.0));
}
