//! Drawing of a histogram: bars on a logarithmic count scale, the range and its handles, a strip of the colour map.

use crate::app::canvas::number;
use crate::plane::display::Display;
use crate::plane::statistics::Histogram;
use egui::{Align2, Color32, Mesh, Painter, Pos2, Rect, Shape, Stroke, StrokeKind, TextStyle, Ui, pos2, vec2};

/// Height of the colour strip under the bars, in points.
const STRIP_POINTS: f32 = 9.0;

/// Height of the axis labels, in points.
const LABELS_POINTS: f32 = 15.0;

/// Geometry of the plot: values along x, counts along y.
#[derive(Debug, Clone, Copy)]
pub struct PlotGeometry {
    /// The bars.
    pub bars: Rect,
    /// The colour strip.
    pub strip: Rect,
    /// Lowest and highest value of the axis.
    pub axis: (f32, f32),
}

impl PlotGeometry {
    /// Geometry of a plot in `rect` whose axis spans `axis`.
    pub fn new(rect: Rect, axis: (f32, f32)) -> Self {
        // Margin for half a handle at each side.
        let inner = rect.shrink2(vec2(6.0, 0.0));
        let bottom = inner.bottom() - LABELS_POINTS;
        let strip = Rect::from_min_max(pos2(inner.left(), bottom - STRIP_POINTS), pos2(inner.right(), bottom));
        let bars = Rect::from_min_max(inner.min, pos2(inner.right(), strip.top() - 2.0));
        Self { bars, strip, axis }
    }

    /// Position of `value` along x, in points.
    pub fn x_of(&self, value: f32) -> f32 {
        let t = (value - self.axis.0) / (self.axis.1 - self.axis.0);
        self.bars.left() + t.clamp(-0.05, 1.05) * self.bars.width()
    }

    /// Value at `x`, also outside the plot.
    pub fn value_at(&self, x: f32) -> f32 {
        self.axis.0 + (x - self.bars.left()) / self.bars.width() * (self.axis.1 - self.axis.0)
    }
}

/// Part of the range that the pointer is near or drags; it is drawn strong.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Grip {
    /// The lower end of the range.
    Min,
    /// The upper end.
    Max,
    /// The whole range.
    Both,
}

/// Draws the histogram.
pub fn draw(
    ui: &Ui,
    painter: &Painter,
    geometry: &PlotGeometry,
    histogram: &Histogram,
    display: &Display,
    grip: Option<Grip>,
) {
    let visuals = ui.visuals();
    painter.rect_filled(geometry.bars.expand2(vec2(6.0, 0.0)), 3.0, visuals.extreme_bg_color);
    let (low, high) = (geometry.x_of(display.min), geometry.x_of(display.max));
    let inside = Rect::from_x_y_ranges(low..=high, geometry.bars.y_range()).intersect(geometry.bars);
    painter.rect_filled(inside, 0.0, visuals.selection.bg_fill.gamma_multiply(0.22));
    draw_bars(painter, geometry, histogram, display, visuals.text_color());
    draw_strip(painter, geometry, display, visuals.weak_text_color());
    draw_labels(ui, painter, geometry);
    for (value, this) in [(display.min, Grip::Min), (display.max, Grip::Max)] {
        let strong = grip == Some(this) || grip == Some(Grip::Both);
        draw_handle(ui, painter, geometry, geometry.x_of(value), strong);
    }
}

/// Bars on a logarithmic scale of counts; those outside the range are fainter.
fn draw_bars(painter: &Painter, geometry: &PlotGeometry, histogram: &Histogram, display: &Display, colour: Color32) {
    let most = histogram.counts.iter().copied().max().unwrap_or(0);
    if most == 0 {
        return;
    }
    let bars = geometry.bars;
    let scale = (bars.height() - 4.0) / (1.0 + most as f32).ln();
    let mut mesh = Mesh::default();
    for (i, &count) in histogram.counts.iter().enumerate().filter(|&(_, &count)| count > 0) {
        let (from, to) = histogram.bin_range(i);
        let centre = 0.5 * (from + to);
        let within = centre >= display.min && centre <= display.max;
        let height = (scale * (1.0 + count as f32).ln()).max(1.0);
        let rect = Rect::from_min_max(
            pos2(geometry.x_of(from), bars.bottom() - height),
            pos2(geometry.x_of(to).max(geometry.x_of(from) + 0.5), bars.bottom()),
        );
        mesh.add_colored_rect(rect, colour.gamma_multiply(if within { 0.85 } else { 0.32 }));
    }
    painter.add(Shape::mesh(mesh));
}

/// Draws the strip of colours that values get, including the end colours beyond the range.
fn draw_strip(painter: &Painter, geometry: &PlotGeometry, display: &Display, outline: Color32) {
    const STEPS: usize = 192;
    let colours = display.colours();
    let strip = geometry.strip;
    let mut mesh = Mesh::default();
    for i in 0..STEPS {
        let x = |i: usize| strip.left() + strip.width() * i as f32 / STEPS as f32;
        let [r, g, b] = colours.colour(geometry.value_at(0.5 * (x(i) + x(i + 1))));
        let rect = Rect::from_x_y_ranges(x(i)..=x(i + 1), strip.y_range());
        mesh.add_colored_rect(rect, Color32::from_rgb(r, g, b));
    }
    painter.add(Shape::mesh(mesh));
    painter.rect_stroke(strip, 0.0, Stroke::new(1.0, outline.gamma_multiply(0.7)), StrokeKind::Outside);
}

/// The values at the ends of the axis and, when it is inside, at zero.
fn draw_labels(ui: &Ui, painter: &Painter, geometry: &PlotGeometry) {
    let font = TextStyle::Small.resolve(ui.style());
    let colour = ui.visuals().weak_text_color();
    let y = geometry.strip.bottom() + 3.0;
    let (low, high) = geometry.axis;
    let text = |x: f32, align: Align2, value: f32| {
        painter.text(pos2(x, y), align, number(value, 3), font.clone(), colour);
    };
    text(geometry.bars.left(), Align2::LEFT_TOP, low);
    text(geometry.bars.right(), Align2::RIGHT_TOP, high);
    let zero = -low / (high - low);
    if (0.3..=0.7).contains(&zero) {
        text(geometry.x_of(0.0), Align2::CENTER_TOP, 0.0);
    }
}

/// A line over the bars with a knob on the strip.
fn draw_handle(ui: &Ui, painter: &Painter, geometry: &PlotGeometry, x: f32, strong: bool) {
    let visuals = ui.visuals();
    let colour = if strong { visuals.strong_text_color() } else { visuals.selection.stroke.color };
    let stroke = Stroke::new(if strong { 2.0 } else { 1.5 }, colour);
    painter.vline(x, geometry.bars.top()..=geometry.strip.bottom(), stroke);
    let knob = Rect::from_center_size(Pos2::new(x, geometry.strip.center().y), vec2(7.0, STRIP_POINTS + 5.0));
    painter.rect(knob, 3.0, visuals.widgets.active.bg_fill, stroke, StrokeKind::Inside);
}
