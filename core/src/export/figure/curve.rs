//! A curve below a drawing, with a mark at one of its points.

use super::{Colour, Drawing, FigureRect, FigureShape, FigureStroke};
use crate::export::sheet::{short, ticks};

/// A curve with a mark at one of its points.
#[derive(Debug, Clone, PartialEq)]
pub struct FigureCurve {
    /// Points (x, y), in increasing order of x; those that are not finite are left out.
    pub points: Vec<[f32; 2]>,
    /// Index of the point that is marked.
    pub marked: usize,
    /// What the values are, above the curve.
    pub title: String,
    /// What x is, below the curve.
    pub label_x: String,
    /// Places on the x axis with their labels; empty for round numbers.
    pub ticks_x: Vec<(f32, String)>,
}

const INK: Colour = [36, 41, 47];
const GRID: Colour = [214, 220, 226];
const LINE: Colour = [0, 114, 178];
const MARK: Colour = [213, 94, 0];

/// Height of the plot, in heights of letters.
const PLOT: f32 = 5.0;
/// Room for the numbers at the left, in heights of letters.
const LEFT: f32 = 4.5;

/// Height of a curve with its texts, figure pixels.
pub fn curve_height(font_size_px: f32) -> f32 {
    (PLOT + 5.0) * font_size_px
}

/// Draws `curve` below all that is on the drawing.
pub fn draw_curve(drawing: &mut Drawing, curve: &FigureCurve, font_size_px: f32) {
    let (font, top) = (font_size_px, drawing.size[1]);
    drawing.size[1] += curve_height(font);
    let whole = FigureRect { min: [0.0, top], size: [drawing.size[0], curve_height(font)] };
    drawing.shapes.push(FigureShape::Fill { rect: whole, color: [255; 3] });
    let mut text = |at: [f32; 2], size: f32, text: &str| {
        drawing.shapes.push(FigureShape::Text { at, size, text: text.to_owned(), color: INK });
    };
    let small = 0.8 * font;
    let rect = FigureRect {
        min: [LEFT * small, top + 2.2 * font],
        size: [(drawing.size[0] - (LEFT + 1.5) * small).max(font), PLOT * font],
    };
    text([0.0, top + 1.4 * font], font, &curve.title);
    let bottom = rect.min[1] + rect.size[1];
    text([rect.min[0], bottom + 2.6 * small], small, &curve.label_x);
    let finite: Vec<[f32; 2]> = curve.points.iter().copied().filter(|p| p.iter().all(|x| x.is_finite())).collect();
    let (Some(first), Some(last)) = (finite.first(), finite.last()) else { return };
    let range_x = widened(first[0], last[0]);
    let (low, high) = finite.iter().fold((0f32, 0f32), |(a, b), p| (a.min(p[1]), b.max(p[1])));
    let range_y = widened(low, high);
    let place = |[x, y]: [f32; 2]| {
        let part = |value: f32, (min, max): (f32, f32)| (value - min) / (max - min);
        [rect.min[0] + part(x, range_x) * rect.size[0], bottom - part(y, range_y) * rect.size[1]]
    };
    let round = |(min, max): (f32, f32)| -> Vec<(f32, String)> {
        ticks((f64::from(min), f64::from(max))).into_iter().map(|tick| (tick as f32, short(tick))).collect()
    };
    let ticks_x = if curve.ticks_x.is_empty() { round(range_x) } else { curve.ticks_x.clone() };
    let mut lines = Vec::new();
    let mut line = |points: Vec<[f32; 2]>, width: f32, color: Colour| {
        let stroke = FigureStroke { width, color, opacity: 1.0 };
        lines.push(FigureShape::Line { points, stroke, dashed: false, class: "curve" });
    };
    for (x, label) in &ticks_x {
        let at = place([*x, low])[0];
        line(vec![[at, rect.min[1]], [at, bottom]], 1.0, GRID);
        text([at - 0.25 * small * label.chars().count() as f32, bottom + 1.2 * small], small, label);
    }
    for (y, label) in round(range_y) {
        let at = place([range_x.0, y])[1];
        line(vec![[rect.min[0], at], [rect.min[0] + rect.size[0], at]], 1.0, GRID);
        text([(LEFT - 0.6 * label.chars().count() as f32 - 0.3) * small, at + 0.35 * small], small, &label);
    }
    line(finite.iter().copied().map(place).collect(), 1.5, LINE);
    let marked = curve.points.get(curve.marked).filter(|p| p.iter().all(|x| x.is_finite()));
    if let Some(centre) = marked.copied().map(place) {
        line(vec![[centre[0], rect.min[1]], [centre[0], bottom]], 1.5, MARK);
        let stroke = FigureStroke { width: 2.0, color: MARK, opacity: 1.0 };
        lines.push(FigureShape::Circle { centre, radius: 0.35 * font, stroke, dashed: false });
    }
    drawing.shapes.extend(lines);
}

/// The range itself, or a wider one where it is empty.
fn widened(min: f32, max: f32) -> (f32, f32) {
    if max > min { (min, max) } else { (min - 0.5, min + 0.5) }
}
