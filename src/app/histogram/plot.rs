//! The plot of a histogram: its axis, its drawing, and dragging of the range's ends or of the whole range.

use crate::app::canvas::number;
use crate::app::canvas::overlay::rgb;
use crate::app::panel::widgets::strip_of_colours;
use crate::plane::display::Display;
use crate::plane::statistics::Histogram;
use egui::{Align2, Color32, Mesh, Painter, Pos2, Rangef, Rect, Shape, Stroke, StrokeKind, TextStyle, Ui, pos2, vec2};

const STRIP_POINTS: f32 = 9.0;

const LABELS_POINTS: f32 = 15.0;

#[derive(Debug, Clone, Copy)]
pub struct PlotGeometry {
    pub bars: Rect,
    pub strip: Rect,
    pub axis: Rangef,
}

impl PlotGeometry {
    pub fn new(rect: Rect, axis: Rangef) -> Self {
        // Margin for half a handle at each side.
        let inner = rect.shrink2(vec2(6.0, 0.0));
        let bottom = inner.bottom() - LABELS_POINTS;
        let strip = Rect::from_min_max(pos2(inner.left(), bottom - STRIP_POINTS), pos2(inner.right(), bottom));
        let bars = Rect::from_min_max(inner.min, pos2(inner.right(), strip.top() - 2.0));
        Self { bars, strip, axis }
    }

    pub fn x_of(&self, value: f32) -> f32 {
        let t = (value - self.axis.min) / self.axis.span();
        self.bars.left() + t.clamp(-0.05, 1.05) * self.bars.width()
    }

    pub fn value_at(&self, x: f32) -> f32 {
        self.axis.min + (x - self.bars.left()) / self.bars.width() * self.axis.span()
    }
}

/// Part of the range that the pointer is near or drags; it is drawn strong.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Grip {
    Min,
    Max,
    Both,
}

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
    strip_of_colours(painter, strip, STEPS, |_, middle| rgb(colours.colour(geometry.value_at(middle))));
    painter.rect_stroke(strip, 0.0, Stroke::new(1.0, outline.gamma_multiply(0.7)), StrokeKind::Outside);
}

fn draw_labels(ui: &Ui, painter: &Painter, geometry: &PlotGeometry) {
    let font = TextStyle::Small.resolve(ui.style());
    let colour = ui.visuals().weak_text_color();
    let y = geometry.strip.bottom() + 3.0;
    let Rangef { min: low, max: high } = geometry.axis;
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

fn draw_handle(ui: &Ui, painter: &Painter, geometry: &PlotGeometry, x: f32, strong: bool) {
    let visuals = ui.visuals();
    let colour = if strong { visuals.strong_text_color() } else { visuals.selection.stroke.color };
    let stroke = Stroke::new(if strong { 2.0 } else { 1.5 }, colour);
    painter.vline(x, geometry.bars.top()..=geometry.strip.bottom(), stroke);
    let knob = Rect::from_center_size(Pos2::new(x, geometry.strip.center().y), vec2(7.0, STRIP_POINTS + 5.0));
    painter.rect(knob, 3.0, visuals.widgets.active.bg_fill, stroke, StrokeKind::Inside);
}

/// Axis that contains all values and the display range, with a margin of 4 % of its length at each end.
pub fn axis_for(data_range: Option<(f32, f32)>, display: &Display) -> Rangef {
    let (low, high) =
        data_range.map_or((display.min, display.max), |(low, high)| (low.min(display.min), high.max(display.max)));
    let (low, high) = if display.symmetric {
        let limit = low.abs().max(high.abs());
        (-limit, limit)
    } else {
        (low, high)
    };
    let room = 0.04 * (high - low);
    Rangef::new(low - room, high + room)
}

/// Whether an axis can stay: it contains the display range and the values, and they fill more than 40 % of it.
pub fn axis_fits(axis: Rangef, data_range: Option<(f32, f32)>, display: &Display) -> bool {
    let needed = axis_for(data_range, display);
    let holds = |low: f32, high: f32| low >= axis.min && high <= axis.max;
    holds(display.min, display.max)
        && data_range.is_none_or(|(low, high)| holds(low, high))
        && needed.span() > 0.4 * axis.span()
}

const GRAB_POINTS: f32 = 9.0;

#[derive(Debug, Clone, Copy)]
pub struct Drag {
    pub grip: Grip,
    pub start: Display,
    pub start_value: f32,
}

pub fn dragged(drag: Drag, value: f32, axis: Rangef) -> Display {
    let Drag { grip, start, start_value } = drag;
    let value = value.clamp(axis.min, axis.max);
    let moved = value - start_value;
    // An end never passes the other one.
    let least = axis.span() * 1e-3;
    let narrower = |limit: f32| start.with_range(-limit.max(least), limit.max(least));
    match (grip, start.symmetric) {
        (Grip::Min, true) => narrower(-value),
        (Grip::Max, true) => narrower(value),
        // Moving a symmetric range as a whole would break its symmetry: it is widened or narrowed instead.
        (Grip::Both, true) => narrower(start.max + if start_value < 0.0 { -moved } else { moved }),
        (Grip::Min, false) => start.with_range(value.min(start.max - least), start.max),
        (Grip::Max, false) => start.with_range(start.min, value.max(start.min + least)),
        (Grip::Both, false) => start.with_range(start.min + moved, start.max + moved),
    }
}

pub fn grip_at(pointer: Pos2, geometry: &PlotGeometry, display: &Display) -> Option<Grip> {
    let (low, high) = (geometry.x_of(display.min), geometry.x_of(display.max));
    let (to_low, to_high) = ((pointer.x - low).abs(), (pointer.x - high).abs());
    // In a narrow range the middle third still grabs the whole range.
    let reach = GRAB_POINTS.min(0.34 * (high - low).max(3.0));
    let outside = pointer.x < low || pointer.x > high;
    let reach = if outside { GRAB_POINTS } else { reach };
    if to_low.min(to_high) <= reach {
        Some(if to_low < to_high { Grip::Min } else { Grip::Max })
    } else {
        (!outside).then_some(Grip::Both)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_axis_stays_while_pictures_change_a_little() {
        let display = Display { min: 0.0, max: 0.1, ..Display::default() };
        let axis = axis_for(Some((0.01, 0.09)), &display);
        assert!(axis_fits(axis, Some((0.02, 0.095)), &display));
        assert!(!axis_fits(axis, Some((0.0, 0.2)), &display), "values outside must be seen");
        let narrow = Display { max: 0.001, ..display };
        assert!(!axis_fits(axis, Some((0.0, 0.001)), &narrow), "a range must not hide in a corner");
        let symmetric = axis_for(Some((-0.01, 0.05)), &Display::symmetric(0.02));
        assert_eq!(symmetric.min, -symmetric.max);
    }

    #[test]
    fn handles_move_their_end_and_the_middle_moves_both() {
        let start = Display { min: 0.2, max: 0.6, ..Display::default() };
        let axis = Rangef::new(0.0, 1.0);
        let range = |grip, from, to| {
            let d = dragged(Drag { grip, start, start_value: from }, to, axis);
            ((d.min * 1e4).round() / 1e4, (d.max * 1e4).round() / 1e4)
        };
        assert_eq!(range(Grip::Min, 0.2, 0.3), (0.3, 0.6));
        assert_eq!(range(Grip::Max, 0.6, 0.9), (0.2, 0.9));
        assert_eq!(range(Grip::Both, 0.4, 0.5), (0.3, 0.7));
        assert_eq!(range(Grip::Min, 0.2, 0.9), (0.599, 0.6));
    }

    proptest! {
        #[test]
        fn dragging_anywhere_keeps_a_usable_range(
            min in -1f32..1.0, width in 0.001f32..2.0, symmetric in any::<bool>(), from in -2f32..2.0, to in -5f32..5.0, which in 0..3
        ) {
            let start = Display { symmetric, ..Display::default() }.with_range(min, min + width);
            let grip = [Grip::Min, Grip::Max, Grip::Both][which as usize];
            let axis = axis_for(None, &start);
            let end = dragged(Drag { grip, start, start_value: from }, to, axis);
            prop_assert!(end.min < end.max && end.min.is_finite() && end.max.is_finite(), "{end:?}");
            prop_assert!(!symmetric || end.min == -end.max);
        }
    }
}
