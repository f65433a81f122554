//! Content of one pane: a picture, with another one over it; or a slice through the frames at the probed place, with a
//! row for each frame, in which moving objects are slanted and the slope of the pane is a line that can be dragged.

use super::widgets::{PaneWidgets, canvas_name};
use crate::app::canvas::{Canvas, CanvasOutput};
use crate::app::document::cursor::stepped;
use crate::app::document::{Action, Queue, Visibility};
use crate::app::measure::Tool;
use crate::app::pane::{Over, PaneId, SliceAxis};
use crate::app::panel::widgets::{WHOLE, draw_plane, named};
use crate::app::results::Read;
use crate::app::{canvas, style};
use crate::app::{panel::cursor_row::wheel_over, panel::features::features_ui};
use crate::detector::Slope;
use crate::inspect::place::Slice;
use crate::inspect::words::{counted, number};
use crate::plane::Plane;
use crate::requests::{Probed, ViewKind};
use egui::text::LayoutJob;
use egui::{
    Align2, Color32, CursorIcon, PointerButton, Pos2, Rect, Response, Sense, Stroke, TextStyle, Ui, pos2, vec2,
};

pub struct Drawn {
    pub pane: PaneId,
    /// Pane whose picture is shown: the pane itself or, flipped, another.
    pub shown: PaneId,
    /// Output of the canvas; of a wipe, that of its left part.
    pub output: CanvasOutput,
    pub right: Option<(PaneId, CanvasOutput)>,
}

impl Drawn {
    pub fn is_touched(&self, ui: &Ui) -> bool {
        let response = &self.output.response;
        let scrolled = response.contains_pointer()
            && ui.input(|i| i.smooth_scroll_delta() != egui::Vec2::ZERO || i.zoom_delta() != 1.0);
        response.clicked() || response.secondary_clicked() || response.drag_started() || scrolled
    }
}

/// Draws the picture of pane `id` on a canvas; flipped, that of the pane laid over it.
pub(super) fn picture_ui(
    ui: &mut Ui,
    model: Read<'_>,
    id: PaneId,
    widgets: &mut PaneWidgets,
    queue: &mut Queue,
) -> Drawn {
    let name = canvas_name(model, id);
    let shown = if let Some(Over::Flip { other, flipped: true }) = model.document.panes.over(id) { other } else { id };
    widgets.of(shown).picture.refresh(model.drawn_in(shown));
    let problem = model.problem_of(shown);
    let before = model.pane(id).map(|pane| pane.view).unwrap_or_default();
    let mut view = before;
    // A panel that comes beside a single picture must not move what was clicked.
    if !model.document.panes.are_many() {
        let is_beside = model.document.panels.right == Visibility::Auto && model.shows_right();
        widgets.of(id).aside.keep(&mut view, ui.available_rect_before_wrap(), is_beside);
    }
    let state = &mut widgets.of(shown).picture;
    let canvas = Canvas {
        picture: state.shown.as_ref().filter(|_| problem.is_none()),
        preview: state.preview.as_ref(),
        empty_text: problem.as_deref().unwrap_or("Computing the picture…"),
        primary_pans: !model.document.workspace.inspects() || model.document.measure.tool == Tool::Pan,
        ..canvas_of(model, shown, &name)
    };
    let output = canvas.show(ui, &mut view);
    widgets.of(id).aside.left = Some(view);
    let state = &mut widgets.of(shown).picture;
    state.paint_colours(ui, model, shown, &output);
    state.readout = output.hover_image.and_then(|pos| state.readout_at(model, shown, pos));
    let visible = state.shown.is_some().then_some(output.visible_image);
    let state = &mut widgets.of(id).picture;
    (state.ui_from_image, state.visible_image) = (Some(output.ui_from_image), visible);
    // Settling alone is no action of the user: only a view that looks different is recorded.
    queue.push_if(!view.is_drawn_as(&before), Action::MoveView { pane: id, before, after: view });
    Drawn { pane: id, shown, output, right: None }
}

/// Goes by the wheel with Alt through the frames of a pane that shows one, or else its slopes; with Shift along v.
pub(super) fn scrub_ui(ui: &Ui, model: Read<'_>, drawn: &Drawn, queue: &mut Queue) {
    let id = drawn.pane;
    let modifiers = ui.input(|i| i.modifiers);
    let notches = if modifiers.alt { wheel_over(ui, &drawn.output.response) } else { 0 };
    let Some(pane) = model.pane(id).filter(|_| notches != 0) else { return };
    queue.push(Action::Focus(id));
    if pane.shown() == Some(ViewKind::Frame) {
        queue.push(Action::SetFrame(id, pane.cursor.frame.saturating_add_signed(notches as isize)));
    } else {
        let step = |slope, _| stepped(&model.cursor_params().slopes, slope, modifiers.shift, notches > 0);
        queue.push(Action::SetSlope(id, (0..notches.abs()).fold(pane.cursor.slope, step)));
    }
}

/// Draws the other picture of a wipe over the drawn one, with its features; the drawn one ends at the line.
pub(super) fn over_ui(ui: &mut Ui, model: Read<'_>, widgets: &mut PaneWidgets, drawn: &mut Drawn, queue: &mut Queue) {
    let Some(Over::Wipe { other, at }) = model.document.panes.over(drawn.pane) else { return };
    let rect = drawn.output.response.rect;
    let x = egui::lerp(rect.x_range(), at);
    let state = &mut widgets.of(other).picture;
    state.refresh(model.drawn_in(other));
    let right = Rect::from_min_max(pos2(x, rect.top()), rect.max);
    let (picture, preview) = (state.shown.as_ref(), state.preview.as_ref());
    let canvas = Canvas { picture, preview, ..canvas_of(model, other, "Wipe, right side") };
    let over = canvas.show_over(ui, &drawn.output, right);
    state.paint_colours(ui, model, other, &over);
    // From here on the marks of the drawn picture end at the line too.
    drawn.output.painter.set_clip_rect(Rect::from_min_max(rect.min, pos2(x, rect.bottom())));
    features_ui(ui, model, other, &mut widgets.of(other).picture, &over, false, queue);
    drawn.right = Some((other, over));
}

pub(super) fn over_names_ui(ui: &Ui, model: Read<'_>, drawn: &Drawn, queue: &mut Queue) {
    let id = drawn.pane;
    let name = |id: PaneId| {
        let number = model.document.panes.number(id).map_or_else(String::new, |number| format!("{number}  ·  "));
        format!("{number}{}", super::short_description(model, id, false))
    };
    match model.document.panes.over(id) {
        None => {}
        // Of two pictures in one place the name says which is on show.
        Some(Over::Flip { .. }) => {
            chip_ui(ui, &drawn.output, Align2::LEFT_TOP, &name(drawn.shown), ("flip", id));
        }
        Some(Over::Wipe { other, at: before }) => {
            let mut at = before;
            chip_ui(ui, &drawn.output, Align2::LEFT_TOP, &name(id), ("wipe left", id));
            if let Some((right, over)) = &drawn.right {
                chip_ui(ui, over, Align2::RIGHT_TOP, &name(*right), ("wipe right", id));
            }
            over_handle_ui(ui, &mut at, drawn.output.response.rect);
            queue.set(&before, at, |at| Action::SetOver(id, Some(Over::Wipe { other, at })));
        }
    }
}

fn canvas_of<'a>(model: Read<'_>, id: PaneId, name: &'a str) -> Canvas<'a> {
    let (display, full_scale) = (model.display_of(id), model.full_scale(id));
    Canvas { display, dim: !model.is_current(id), full_scale, ..Canvas::new(name) }
}

/// Draws the line of a wipe over `rect`, which can be dragged; `at` is 0 … 1 from the left.
fn over_handle_ui(ui: &Ui, at: &mut f32, rect: Rect) {
    let x = egui::lerp(rect.x_range(), *at);
    // Wider than drawn, to be caught easily.
    let line = Rect::from_center_size(pos2(x, rect.center().y), vec2(12.0, rect.height()));
    let response = ui.interact(line, ui.scope_id().with("wipe handle"), Sense::drag());
    if let Some(pos) = response.interact_pointer_pos() {
        *at = ((pos.x - rect.left()) / rect.width().max(1.0)).clamp(0.0, 1.0);
    }
    let lit = response.hovered() || response.dragged();
    let painter = ui.painter_at(rect);
    for (width, colour) in [(5.0, Color32::from_black_alpha(140)), (if lit { 3.0 } else { 2.0 }, Color32::WHITE)] {
        painter.vline(x, rect.y_range(), Stroke::new(width, colour));
    }
    let grip = pos2(x, rect.center().y);
    painter.circle_filled(grip, 9.0, Color32::from_black_alpha(170));
    painter.circle_stroke(grip, 9.0, Stroke::new(1.5, Color32::WHITE));
    for sign in [-1.0, 1.0] {
        let tip = grip + vec2(6.0 * sign, 0.0);
        for turn in [-1.0, 1.0] {
            painter.line_segment([tip, tip + vec2(-3.0 * sign, 3.0 * turn)], Stroke::new(1.5, Color32::WHITE));
        }
    }
    response.widget_info(|| egui::WidgetInfo::slider(true, f64::from(*at), "Wipe line"));
    response.on_hover_and_drag_cursor(CursorIcon::ResizeHorizontal);
}

/// Draws as much of a text as fits on a dark background in a corner of a picture. `salt` makes its id unique.
pub(in crate::app) fn chip_ui(
    ui: &Ui,
    output: &CanvasOutput,
    corner: Align2,
    text: &str,
    salt: impl egui::AsIdSalt,
) -> Response {
    let painter = &output.painter;
    let rect = output.response.rect.intersect(painter.clip_rect());
    let mut job = LayoutJob::simple_singleline(text.to_owned(), egui::FontId::proportional(13.0), Color32::WHITE);
    (job.wrap.max_width, job.wrap.max_rows) = ((rect.width() - 30.0).max(40.0), 1);
    let galley = painter.layout_job(job);
    let ground = corner.align_size_within_rect(galley.size() + vec2(14.0, 6.0), rect.shrink(8.0));
    painter.rect_filled(ground, 4.0, Color32::from_black_alpha(190));
    painter.galley(ground.min + vec2(7.0, 3.0), galley, Color32::WHITE);
    let response = ui.interact(ground, output.response.id.with(salt), Sense::hover());
    named(&response, egui::Role::Label, text);
    response
}

/// Space for the frames' numbers on the left and the pixels below, points.
const LEFT: f32 = 34.0;
const BELOW: f32 = 20.0;
/// Maximum height of a row, points, so that few frames do not fill the pane.
const MAX_ROW: f32 = 26.0;

/// Draws the slice of pane `id`; returns whether the pointer touched it.
pub(super) fn slice_ui(ui: &mut Ui, model: Read<'_>, id: PaneId, axis: SliceAxis, queue: &mut Queue) -> bool {
    let (whole, response) = ui.allocate_exact_size(ui.available_size(), Sense::click_and_drag());
    let [name, _] = axis.words();
    named(&response, egui::Role::Image, name);
    ui.painter().rect_filled(whole, 0.0, canvas::backdrop(ui));
    let touched = response.clicked() || response.drag_started();
    let is_probed = model.document.panes.is_on(id, model.document.probe.side);
    let answer = model.results.probed.answer.as_ref().filter(|_| is_probed);
    let Some((answer, pane)) = answer.zip(model.pane(id)) else {
        let text = if is_probed && model.document.probe.question.is_some() { "Probing the place…" } else { HOW };
        canvas::message(ui, ui.painter(), whole, text);
        return touched;
    };
    let slice = &answer.probe.slices[axis as usize];
    let (slope, display) = (pane.cursor.slope, model.document.ranges_of(pane).intensity);
    let area = Area::of(whole, slice);
    let values = Some(((&answer.probe).into(), WHOLE, || area.over_time.plane(slice)));
    draw_plane(ui, (&format!("{name} in pane {}", id.0), area.rect), display, values);
    numbers_ui(ui, &area, slice);
    line(ui, &area, slice, answer.probe.subject.slope, false);
    line(ui, &area, slice, slope, true);
    // In another pane the first click moves the focus, and must not move its slope.
    if model.document.panes.focus() == id {
        let dragged = dragged_slope(&area, slice, slope, &response);
        dragged.into_iter().for_each(|slope| queue.push(Action::SetSlope(id, slope)));
    }
    let Some(pos) = response.hover_pos().filter(|pos| area.rect.contains(*pos)) else { return touched };
    let text = reading(answer, slice, &area, pos);
    response.on_hover_and_drag_cursor(CursorIcon::ResizeHorizontal).on_hover_text_at_pointer(text);
    touched
}

const HOW: &str = "Shift+click a place in another pane: this shows it in every frame, one row each.";

/// A slice over time: its rows are at even distances in time, so that each frame stands where it was taken.
#[derive(Debug)]
struct OverTime {
    first: f32,
    step: f32,
    rows: usize,
    /// Farthest from a frame that its row reaches: half of the usual time to the next one. Beyond nothing is drawn.
    reach: f32,
}

impl OverTime {
    /// Maximum number of rows for a frame: uneven times with one short gap would take very many.
    const FINEST: usize = 4;

    fn of(times: &[f32]) -> Self {
        let mut gaps: Vec<f32> = times.windows(2).map(|two| two[1] - two[0]).collect();
        gaps.sort_by(f32::total_cmp);
        let [first, .., last] = *times else {
            return Self { first: times.first().copied().unwrap_or(0.0), step: 1.0, rows: times.len(), reach: 0.5 };
        };
        let rows = (((last - first) / gaps[0]).round() as usize + 1).min(Self::FINEST * times.len());
        // A little more than half, so that rounding leaves no gap between frames at even times.
        Self { first, step: (last - first) / (rows - 1) as f32, rows, reach: 0.505 * gaps[gaps.len() / 2] }
    }

    fn nearest(times: &[f32], time: f32) -> Option<usize> {
        (0..times.len()).min_by(|a, b| (times[*a] - time).abs().total_cmp(&(times[*b] - time).abs()))
    }

    /// Frame of each row; `None` where none was taken.
    fn frames(&self, times: &[f32]) -> Vec<Option<usize>> {
        let of_row = |row: usize| {
            let time = self.first + row as f32 * self.step;
            Self::nearest(times, time).filter(|frame| (times[*frame] - time).abs() <= self.reach)
        };
        (0..self.rows).map(of_row).collect()
    }

    fn plane(&self, slice: &Slice) -> Plane {
        let frames = self.frames(&slice.times);
        Plane::from_fn(slice.plane.width(), self.rows, |column, row| {
            frames[row].map_or(f32::NAN, |frame| slice.plane.at(column, frame))
        })
    }
}

struct Area {
    rect: Rect,
    columns: f32,
    over_time: OverTime,
}

impl Area {
    fn of(whole: Rect, slice: &Slice) -> Self {
        let over_time = OverTime::of(&slice.times);
        let room = Rect::from_min_max(whole.min + vec2(LEFT, 6.0), whole.max - vec2(8.0, BELOW));
        let height = (MAX_ROW * over_time.rows as f32).min(room.height()).max(8.0);
        let rect = Rect::from_center_size(room.center(), vec2(room.width().max(8.0), height));
        Self { rect, columns: slice.plane.width() as f32, over_time }
    }

    fn pos(&self, column: f32, time: f32) -> Pos2 {
        let OverTime { first, step, rows, .. } = self.over_time;
        let part = vec2((column + 0.5) / self.columns, ((time - first) / step + 0.5) / rows as f32);
        self.rect.min + part * self.rect.size()
    }

    fn at(&self, pos: Pos2) -> (f32, f32) {
        let OverTime { first, step, rows, .. } = self.over_time;
        let part = (pos - self.rect.min) / self.rect.size();
        let row = (part.y * rows as f32 - 0.5).clamp(0.0, rows as f32 - 1.0);
        (part.x * self.columns - 0.5, first + row * step)
    }
}

fn numbers_ui(ui: &Ui, area: &Area, slice: &Slice) {
    let (painter, colour) = (ui.painter(), ui.visuals().text_color());
    let font = TextStyle::Small.resolve(ui.style());
    let mut free = f32::NEG_INFINITY;
    for (frame, time) in slice.frames.iter().zip(&slice.times) {
        let at = pos2(area.rect.left() - 5.0, area.pos(0.0, *time).y);
        // Numbers of close rows would overlap.
        if at.y >= free {
            painter.text(at, Align2::RIGHT_CENTER, frame.to_string(), font.clone(), colour);
            free = at.y + 13.0;
        }
    }
    let half = slice.centre_column as f32;
    for part in [-1.0, -0.5, 0.0, 0.5, 1.0] {
        let away = (part * half).round();
        let x = area.pos(half + away, 0.0).x;
        let text = if away == 0.0 { "0 px".to_owned() } else { number(away, 0) };
        painter.vline(x, area.rect.bottom()..=area.rect.bottom() + 3.0, Stroke::new(1.0, colour));
        let anchor = if part == 1.0 { Align2::RIGHT_TOP } else { Align2::CENTER_TOP };
        painter.text(pos2(x, area.rect.bottom() + 3.0), anchor, text, font.clone(), colour);
    }
}

/// Draws the path of an object that moves by `slope`: solid for the pane's slope, dashed for the probed one.
fn line(ui: &Ui, area: &Area, slice: &Slice, slope: Slope, own: bool) {
    let Some(last) = slice.times.len().checked_sub(1) else { return };
    let ends = [0, last].map(|row| area.pos(slice.column_at(slope, row), slice.times[row]));
    let painter = ui.painter().with_clip_rect(area.rect);
    if own {
        painter.line_segment(ends, Stroke::new(4.0, Color32::from_black_alpha(150)));
        painter.line_segment(ends, Stroke::new(2.0, style::ACCENT));
        ends.into_iter().for_each(|end| _ = painter.circle_filled(end, 4.0, style::ACCENT));
    } else {
        painter.extend(egui::Shape::dashed_line(&ends, Stroke::new(1.5, Color32::from_rgb(255, 214, 90)), 4.0, 4.0));
    }
}

/// Component along the slice of the slope through the place and `pos`; `None` within half a frame of the place's time.
fn along_at(area: &Area, slice: &Slice, pos: Pos2) -> Option<f32> {
    let (column, time) = area.at(pos);
    (time.abs() >= 0.5).then(|| (column - slice.centre_column as f32) / time)
}

/// Slope of the line, dragged by the pointer from `slope`: its component along the slice changes, that across it stays.
fn dragged_slope(area: &Area, slice: &Slice, slope: Slope, response: &Response) -> Option<Slope> {
    let pos = response.interact_pointer_pos().filter(|_| response.dragged_by(PointerButton::Primary))?;
    let slope = slice.with_along(slope, along_at(area, slice, pos)?);
    // Rounded to a hundredth of a pixel, as by the sliders.
    let rounded = |x: f32| (100.0 * x).round() / 100.0;
    Some(Slope::new(rounded(slope.u), rounded(slope.v)))
}

fn reading(answer: &Probed, slice: &Slice, area: &Area, pos: Pos2) -> String {
    let (column, time) = area.at(pos);
    let column = (column.round().max(0.0) as usize).min(slice.plane.width() - 1);
    let row = OverTime::nearest(&slice.times, time).unwrap_or_default();
    let scale = answer.request.traced.cache.burst.full_scale;
    let value = canvas::number(slice.plane.at(column, row) * scale, 4);
    let way = along_at(area, slice, pos).map_or_else(String::new, |along| {
        format!("\nFrom the place to here: {} px/frame; drag to take that slope", number(along, 2))
    });
    format!("Frame {}: {value}{way}", slice.frames[row])
}

pub(super) fn method_ui(ui: &Ui, model: Read<'_>, drawn: &Drawn) {
    let Some(pane) = model.pane(drawn.pane) else { return };
    let Some(method) = pane.method.filter(|_| model.document.panes.over(drawn.pane).is_none()) else { return };
    let count = match model.method_found(method, pane.side) {
        Some(found) => &counted(found.detection.features.len(), "feature"),
        None if model.results.compare.problem(method).is_some() => "not searched",
        None => "…",
    };
    let text = format!("{}  ·  {count}", method.label());
    chip_ui(ui, &drawn.output, Align2::LEFT_TOP, &text, ("method", drawn.pane));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_stand_where_their_frames_were_taken() {
        let frames = |times: &[f32]| OverTime::of(times).frames(times);
        let even = frames(&[-1.5, -0.5, 0.5, 1.5]);
        assert_eq!(even, [Some(0), Some(1), Some(2), Some(3)], "even frames are as they are");
        assert_eq!(frames(&[0.0, 1.0, 4.0, 5.0, 6.0]), [Some(0), Some(1), None, None, Some(2), Some(3), Some(4)]);
        let late = frames(&[0.0, 1.5, 2.0, 3.0]);
        assert_eq!(late, [Some(0), Some(0), Some(1), Some(1), Some(2), Some(2), Some(3)], "{late:?}");
        assert_eq!((frames(&[]).len(), frames(&[7.0])), (0, vec![Some(0)]));
        assert_eq!(OverTime::of(&[0.0, 1e-6, 1.0, 2.0]).rows, 16, "no more rows than can be seen");
    }
}
