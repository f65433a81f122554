//! Slice through the frames at the probed place: a row for each frame, along the motion or across it. Moving objects
//! are slanted; the slope of the pane is a line that can be dragged.

use super::widgets::PaneWidgets;
use crate::app::canvas;
use crate::app::pane::{PaneId, SliceAxis};
use crate::app::project::Model;
use crate::app::style;
use crate::detector::Slope;
use crate::inspect::slices::Slice;
use crate::inspect::words::number;
use crate::requests::Probed;
use egui::{
    Align2, Color32, CursorIcon, PointerButton, Pos2, Rect, Response, Sense, Stroke, TextStyle, Ui, pos2, vec2,
};

/// Space for the frames' numbers on the left and the pixels below, points.
const LEFT: f32 = 34.0;
const BELOW: f32 = 20.0;
/// Maximum height of a row, points, so that few frames do not fill the pane.
const MAX_ROW: f32 = 26.0;

/// Draws the slice of pane `id`; returns whether the pointer touched it.
pub(super) fn slice_ui(ui: &mut Ui, model: &mut Model, id: PaneId, axis: SliceAxis, widgets: &mut PaneWidgets) -> bool {
    let (whole, response) = ui.allocate_exact_size(ui.available_size(), Sense::click_and_drag());
    let name = axis.label();
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, name));
    ui.painter().rect_filled(whole, 0.0, canvas::backdrop(ui));
    let touched = response.clicked() || response.drag_started();
    let Some(answer) = model.probe.answer.clone() else {
        let text = if model.probe.question.is_some() { "Probing the place…" } else { HOW };
        canvas::message(ui, ui.painter(), whole, text);
        return touched;
    };
    let slice = &answer.probe.slices[axis as usize];
    let Some(pane) = model.panes.get(id) else { return touched };
    let (slope, display) = (pane.cursor.slope, model.ranges_of(pane).intensity);
    let area = Area::of(whole, slice);
    widgets.of(id).slice.draw(ui, area.rect, (name, &answer.probe), display, || slice.plane.clone());
    numbers_ui(ui, &area, slice);
    line(ui, &area, slice, answer.probe.subject.slope, false);
    line(ui, &area, slice, slope, true);
    if model.panes.focus() == id {
        drag(model, id, &area, slice, &response);
    }
    let Some(pos) = response.hover_pos().filter(|pos| area.rect.contains(*pos)) else { return touched };
    let text = reading(&answer, slice, &area, pos);
    response.on_hover_and_drag_cursor(CursorIcon::ResizeHorizontal).on_hover_text_at_pointer(text);
    touched
}

const HOW: &str = "Shift+click a place in another pane: this shows it in every frame, one row each.";

/// Place of the slice's pixels in the window.
struct Area {
    rect: Rect,
    columns: f32,
    rows: f32,
}

impl Area {
    fn of(whole: Rect, slice: &Slice) -> Self {
        let (columns, rows) = (slice.plane.width() as f32, slice.plane.height() as f32);
        let room = Rect::from_min_max(whole.min + vec2(LEFT, 6.0), whole.max - vec2(8.0, BELOW));
        let height = (MAX_ROW * rows).min(room.height()).max(8.0);
        let rect = Rect::from_center_size(room.center(), vec2(room.width().max(8.0), height));
        Self { rect, columns, rows }
    }

    fn pos(&self, column: f32, row: f32) -> Pos2 {
        let part = vec2((column + 0.5) / self.columns, (row + 0.5) / self.rows);
        self.rect.min + part * self.rect.size()
    }

    /// Place at `pos` as (column, row), with fractions.
    fn at(&self, pos: Pos2) -> (f32, f32) {
        let part = (pos - self.rect.min) / self.rect.size();
        (part.x * self.columns - 0.5, part.y * self.rows - 0.5)
    }
}

/// Draws the frame of each row, and the columns' distances from the place.
fn numbers_ui(ui: &Ui, area: &Area, slice: &Slice) {
    let (painter, colour) = (ui.painter(), ui.visuals().text_color());
    let font = TextStyle::Small.resolve(ui.style());
    let each = (13.0 * area.rows / area.rect.height()).ceil().max(1.0) as usize;
    for (row, frame) in slice.frames.iter().enumerate().step_by(each) {
        let at = pos2(area.rect.left() - 5.0, area.pos(0.0, row as f32).y);
        painter.text(at, Align2::RIGHT_CENTER, frame.to_string(), font.clone(), colour);
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
    let rows = slice.times.len();
    let Some(last) = rows.checked_sub(1) else { return };
    let ends = [0, last].map(|row| area.pos(slice.column_at(slope, row), row as f32));
    let painter = ui.painter().with_clip_rect(area.rect);
    if own {
        painter.line_segment(ends, Stroke::new(4.0, Color32::from_black_alpha(150)));
        painter.line_segment(ends, Stroke::new(2.0, style::ACCENT));
        for end in ends {
            painter.circle_filled(end, 4.0, style::ACCENT);
        }
    } else {
        painter.extend(egui::Shape::dashed_line(&ends, Stroke::new(1.5, Color32::from_rgb(255, 214, 90)), 4.0, 4.0));
    }
}

/// Component along the slice of the slope through the place and `pos`; `None` within half a frame of the place's time.
fn along_at(area: &Area, slice: &Slice, pos: Pos2) -> Option<f32> {
    let (column, row) = area.at(pos);
    let row = row.clamp(0.0, area.rows - 1.0);
    let (below, part) = (row.floor() as usize, row.fract());
    let at = |row: usize| slice.times[row.min(slice.times.len() - 1)];
    let time = at(below) + part * (at(below + 1) - at(below));
    (time.abs() >= 0.5).then(|| (column - slice.centre_column as f32) / time)
}

/// Lets the pointer drag the line: the slope's component along the slice changes, that across it stays.
fn drag(model: &mut Model, id: PaneId, area: &Area, slice: &Slice, response: &Response) {
    let Some(pos) = response.interact_pointer_pos().filter(|_| response.dragged_by(PointerButton::Primary)) else {
        return;
    };
    let (Some(along), Some(pane)) = (along_at(area, slice, pos), model.panes.get_mut(id)) else { return };
    let [u, v] = slice.direction;
    let slope = pane.cursor.slope;
    let more = along - (slope.u * u + slope.v * v);
    // Rounded to a hundredth of a pixel, as by the sliders.
    let rounded = |x: f32| (100.0 * x).round() / 100.0;
    pane.cursor.slope = Slope::new(rounded(slope.u + more * u), rounded(slope.v + more * v));
    pane.slope_chosen = true;
    model.playing = false;
}

fn reading(answer: &Probed, slice: &Slice, area: &Area, pos: Pos2) -> String {
    let (column, row) = area.at(pos);
    let (column, row) = (column.round().max(0.0) as usize, row.round().max(0.0) as usize);
    let (column, row) = (column.min(slice.plane.width() - 1), row.min(slice.plane.height() - 1));
    let scale = answer.request.traced.cache.burst.full_scale;
    let value = canvas::number(slice.plane.at(column, row) * scale, 4);
    let way = along_at(area, slice, pos).map_or_else(String::new, |along| {
        format!("\nFrom the place to here: {} px/frame; drag to take that slope", number(along, 2))
    });
    format!("Frame {}: {value}{way}", slice.frames[row])
}
