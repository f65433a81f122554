//! Map of a response in the panel: its cells, the numbers around it, and its overlays.

use crate::inspect::response::FineAxis;
use crate::inspect::words::number;
use crate::plane::Plane;
use egui::{Align2, Color32, Painter, Pos2, Rect, Sense, Stroke, StrokeKind, TextStyle, Ui, pos2, vec2};

/// Space for the numbers beside and below a map, points.
pub(super) const LEFT: f32 = 30.0;
const BELOW: f32 = 28.0;

/// Area of a map in the panel: cells in `rect`.
pub(super) struct Area {
    pub(super) rect: Rect,
    pub(super) cells: (usize, usize),
}

impl Area {
    /// Position of a cell's centre; fractions lie between cells.
    pub(super) fn pos(&self, column: f32, row: f32) -> Pos2 {
        let (width, height) = (self.cells.0 as f32, self.cells.1 as f32);
        self.rect.min + vec2((column + 0.5) / width * self.rect.width(), (row + 0.5) / height * self.rect.height())
    }

    /// Cell under `pos`.
    pub(super) fn cell(&self, pos: Pos2) -> Option<(usize, usize)> {
        let at = |x: f32, span: f32, n: usize| ((x / span * n as f32).max(0.0) as usize).min(n - 1);
        let from = pos - self.rect.min;
        self.rect
            .contains(pos)
            .then(|| (at(from.x, self.rect.width(), self.cells.0), at(from.y, self.rect.height(), self.cells.1)))
    }
}

/// Allocates space for a map with numbers beside and below it.
pub(super) fn area_ui(ui: &mut Ui, height: f32, cells: (usize, usize)) -> (Area, egui::Response) {
    let (whole, response) = ui.allocate_exact_size(vec2(ui.available_width(), height + BELOW), Sense::click());
    let rect = Rect::from_min_max(whole.min + vec2(LEFT, 2.0), whole.max - vec2(4.0, BELOW - 2.0));
    (Area { rect, cells }, response)
}

/// Column of a slope along an axis; fractions lie between columns.
pub(super) fn column_of(axis: &FineAxis, slope: f32) -> f32 {
    match axis.values[..] {
        [first, second, ..] => (slope - first) / (second - first),
        _ => 0.0,
    }
}

/// First and last slope of a grid.
pub(super) fn ends(grid: &[f32]) -> Vec<f32> {
    let mut ends: Vec<f32> = grid.first().into_iter().chain(grid.last()).copied().collect();
    ends.dedup();
    ends
}

/// Draws marks at the grid's slopes, numbers at some of them, and the axis's name.
pub(super) fn grid_below(ui: &Ui, area: &Area, axis: &FineAxis, name: &str) {
    let (painter, colour) = (ui.painter(), ui.visuals().weak_text_color());
    let font = TextStyle::Small.resolve(ui.style());
    let bottom = area.rect.bottom();
    let room = (area.rect.width() / 42.0).max(1.0) as usize;
    let each = axis.grid.len().div_ceil(room).max(1);
    for (index, &slope) in axis.grid.iter().enumerate() {
        let x = area.pos(column_of(axis, slope), 0.0).x;
        painter.vline(x, bottom..=bottom + 3.0, Stroke::new(1.0, colour));
        if index % each == 0 {
            painter.text(pos2(x, bottom + 3.0), Align2::CENTER_TOP, number(slope, 2), font.clone(), colour);
        }
    }
    painter.text(pos2(area.rect.center().x, bottom + 14.0), Align2::CENTER_TOP, name, font, colour);
}

/// Draws dashes at the ends of the searched slopes, and faint lines at each slope.
pub(super) fn rims(painter: &Painter, area: &Area, axis: &FineAxis, upright: bool) {
    if axis.grid.len() < 2 {
        return;
    }
    let line = |at: f32| {
        let column = column_of(axis, at);
        if upright {
            let y = area.pos(0.0, column).y;
            [pos2(area.rect.left(), y), pos2(area.rect.right(), y)]
        } else {
            let x = area.pos(column, 0.0).x;
            [pos2(x, area.rect.top()), pos2(x, area.rect.bottom())]
        }
    };
    for &slope in &axis.grid {
        painter.line_segment(line(slope), Stroke::new(0.5, Color32::from_black_alpha(40)));
    }
    for rim in ends(&axis.grid) {
        painter.extend(egui::Shape::dashed_line(&line(rim), Stroke::new(1.0, Color32::from_gray(60)), 3.0, 3.0));
    }
}

/// Draws lines between cells that reach the gate and cells that do not.
pub(super) fn contour(painter: &Painter, area: &Area, plane: &Plane, gate: f32) {
    let reaches = |column: usize, row: usize| plane.at(column, row).abs() >= gate;
    let (columns, rows) = plane.size();
    let stroke = Stroke::new(1.2, Color32::BLACK);
    for row in 0..rows {
        for column in 0..columns {
            let (x, y) = (column as f32, row as f32);
            if column + 1 < columns && reaches(column, row) != reaches(column + 1, row) {
                painter.line_segment([area.pos(x + 0.5, y - 0.5), area.pos(x + 0.5, y + 0.5)], stroke);
            }
            if row + 1 < rows && reaches(column, row) != reaches(column, row + 1) {
                painter.line_segment([area.pos(x - 0.5, y + 0.5), area.pos(x + 0.5, y + 0.5)], stroke);
            }
        }
    }
}

/// Draws a candidate; kept and selected ones are larger.
pub(super) fn ring(painter: &Painter, at: Pos2, kept: bool, selected: bool) {
    let radius = if kept || selected { 5.5 } else { 2.5 };
    let width = if kept { 2.0 } else { 1.0 };
    let colour = if selected { Color32::from_rgb(0, 90, 30) } else { Color32::from_gray(30) };
    if kept || selected {
        painter.circle_stroke(at, radius, Stroke::new(width + 2.0, Color32::from_white_alpha(200)));
    }
    painter.circle_stroke(at, radius, Stroke::new(width, colour));
}

/// Draws the place of the focused pane's cursor.
pub(super) fn square(painter: &Painter, at: Pos2) {
    let rect = Rect::from_center_size(at, vec2(8.0, 8.0));
    for (width, colour) in [(3.0, Color32::from_white_alpha(200)), (1.2, Color32::BLACK)] {
        painter.rect_stroke(rect, 0.0, Stroke::new(width, colour), StrokeKind::Middle);
    }
}
