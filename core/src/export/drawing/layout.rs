//! Layout of a figure: positions of all its parts.

use super::links::{FigureMatches, lines_of};
use super::panel::{
    ColourBar, FigureMark, FigureOptions, FigurePanel, FigureWidth, LegendEntry, LegendMark, POINTS_PER_MM,
};
use super::shape::{Anchor, Colour, DASH, Drawing, Face, FigureRect, FigureShape, FigureStroke, Style as ShapeStyle};
use crate::plane::display::direction_colour;
use std::f32::consts::{FRAC_PI_2, PI};

/// Gap between panels, in heights of letters.
const GAP: f32 = 0.8;
/// Height of a line of a title, in heights of letters.
const LINE: f32 = 1.25;
/// Room that a title has above a narrower picture, in heights of letters; not in a figure of a given width.
const LEAST_ROOM: f32 = 20.0;

/// Lays out panels on a sheet, row by row, with the matches between them; rows with the same number of panels share
/// their columns. Bars and legends that all panels share stand once, above the legend of the matches. Image pixels are
/// equally large in all panels, so that one scale bar, over the first, is for all.
///
/// Marks with invalid numbers (not finite, or beyond 10⁹) are left out.
pub fn lay_out(rows: &[Vec<FigurePanel>], matches: &FigureMatches, options: &FigureOptions) -> Drawing {
    let within = |value: f32, min: f32, max: f32| if value.is_nan() { min } else { value.clamp(min, max) };
    let font = within(options.font_size, 1.0, 1000.0);
    let gap = GAP * font;
    let panels: Vec<&FigurePanel> = rows.iter().flatten().collect();
    let of_rows = |of: &dyn Fn(usize, &FigurePanel) -> f32| {
        let mut place = 0..;
        let mut of_panel = |panel| of(place.next().expect("numbers do not end"), panel);
        rows.iter().map(|row| row.iter().map(&mut of_panel).collect()).collect::<Vec<Vec<f32>>>()
    };
    let (scale, paper) = match options.width {
        FigureWidth::PxPerPx(scale) => (within(scale, 1.0 / 64.0, 64.0), None),
        FigureWidth::Millimetres(mm) => {
            let width = POINTS_PER_MM * within(mm, 10.0, 2000.0);
            let widths_px = of_rows(&|_, panel| width_px(panel));
            let fitting = |row: &Vec<f32>| {
                let width_px: f32 = columns_of(&widths_px, row.len()).iter().sum();
                (width - gap * (row.len() as f32 - 1.0)).max(1.0) / width_px
            };
            // Image pixels are equally large in all panels: the row with the least room decides.
            let scale = widths_px.iter().filter(|row| !row.is_empty()).map(fitting).fold(f32::INFINITY, f32::min);
            (if scale.is_finite() { scale } else { 1.0 }, Some(width))
        }
    };
    let style = Style { scale, stroke: within(options.stroke_width, 0.0, 1000.0), font, paper };
    let shared = Shared::of(&panels);
    let title = |place: usize, panel: &FigurePanel| {
        style.title(panel, (options.letters && panels.len() > 1).then(|| letter(place)))
    };
    // With titles and legends; on paper pictures alone fill the width.
    let widths = of_rows(&|place, panel| match paper {
        Some(_) => width_px(panel) * scale,
        None => style.panel(panel, (&title(place, panel), 0), &shared, [0.0; 2], &mut Vec::new())[0],
    });
    // Row by row, with columns in line over all rows of the same length.
    let mut shapes = Vec::new();
    let (mut width, mut top, mut first) = (paper.unwrap_or(0.0), 0f32, 0);
    for row in rows {
        let titles: Vec<Vec<String>> = (first..).zip(row).map(|(place, panel)| title(place, panel)).collect();
        // The longest title makes room for all of its row: pictures of a row are level.
        let lines = titles.iter().map(Vec::len).max().unwrap_or(0);
        let (mut left, mut height) = (0f32, 0f32);
        for (column, (panel, in_column)) in row.iter().zip(columns_of(&widths, row.len())).enumerate() {
            let size = style.panel(panel, (&titles[column], lines), &shared, [left, top], &mut shapes);
            left += in_column + gap;
            height = height.max(size[1]);
        }
        first += row.len();
        width = width.max(left - gap);
        top += height + gap;
    }
    // Links lead from panel to panel, so they are drawn over all of them.
    let pictures = shapes.iter().filter_map(|shape| match shape {
        FigureShape::Picture { rect, .. } => Some(*rect),
        _ => None,
    });
    let placed: Vec<(FigureRect, &FigurePanel)> = pictures.zip(panels.iter().copied()).collect();
    shapes.extend(lines_of(&placed, &matches.links, style.stroke));
    if let Some(&(rect, _)) = placed.first().filter(|_| options.scale_bar) {
        let mut bar = Vec::new();
        style.scale_bar(rect, &mut bar);
        shapes.push(FigureShape::Clipped { rect, round: true, shapes: bar });
    }
    let mut bottom = top - gap;
    if let Some(bar) = shared.bar {
        style.colour_bar(bar, [0.0, bottom], width, &mut shapes);
        bottom += BAR_HEIGHT * font;
    }
    for entries in [shared.legend, &matches.legend] {
        let (legend_width, legend_height) = style.legend(entries, [0.0, bottom], width, &mut shapes);
        (width, bottom) = (width.max(legend_width), bottom + legend_height);
    }
    let size = [width.max(1.0), bottom.max(1.0)];
    let titles: Vec<&str> = panels.iter().filter_map(|panel| panel.title.as_deref()).collect();
    // Last, when the size is known, but below all.
    shapes.insert(0, filled(FigureRect { min: [0.0, 0.0], size }, [255; 3]));
    Drawing { size, unit: options.width.unit(), shapes, title: titles.join("; ") }
}

fn width_px(panel: &FigurePanel) -> f32 {
    panel.size.0 as f32 * panel.image_px_per_px
}

fn columns_of(widths: &[Vec<f32>], count: usize) -> Vec<f32> {
    let alike = || widths.iter().filter(|row| row.len() == count);
    (0..count).map(|column| alike().map(|row| row[column]).fold(0.0, f32::max)).collect()
}

struct Shared<'a> {
    bar: Option<&'a ColourBar>,
    legend: &'a [LegendEntry],
}

impl<'a> Shared<'a> {
    fn of(panels: &[&'a FigurePanel]) -> Self {
        let bars: Vec<&ColourBar> = panels.iter().filter_map(|panel| panel.bar.as_ref()).collect();
        let legends: Vec<&[LegendEntry]> =
            panels.iter().map(|panel| &panel.legend[..]).filter(|legend| !legend.is_empty()).collect();
        let all_alike = bars.len() > 1 && bars.iter().all(|bar| *bar == bars[0]);
        let told_alike = legends.len() > 1 && legends.iter().all(|legend| *legend == legends[0]);
        Self { bar: all_alike.then(|| bars[0]), legend: if told_alike { legends[0] } else { &[] } }
    }
}

/// The letters of panel `place`: (a), (b), … (z), (aa), …
fn letter(place: usize) -> String {
    let mut letters = String::new();
    let mut rest = place + 1;
    while rest > 0 {
        letters.insert(0, char::from(b'a' + ((rest - 1) % 26) as u8));
        rest = (rest - 1) / 26;
    }
    format!("({letters})")
}

/// Whether a coordinate is finite, and small enough to be drawn.
fn drawable(number: &f32) -> bool {
    number.abs() < 1e9
}

/// Height of a colour bar with its labels, in heights of letters.
const BAR_HEIGHT: f32 = 1.7;

struct Style {
    scale: f32,
    stroke: f32,
    font: f32,
    paper: Option<f32>,
}

impl Style {
    /// The width of a text, estimated: a letter is at most about 0.65 of its height wide on average.
    fn text_width(&self, text: &str) -> f32 {
        0.65 * self.font * text.chars().count() as f32
    }

    fn text(&self, at: [f32; 2], text: &str) -> FigureShape {
        self.coloured_text(at, [0; 3], text)
    }

    fn coloured_text(&self, at: [f32; 2], color: Colour, text: &str) -> FigureShape {
        let (anchor, face, upwards, text) = (Anchor::Start, Face::Plain, false, text.to_owned());
        FigureShape::Text { at, anchor, size: self.font, face, color, upwards, text }
    }

    /// Lines of a panel's title, each as wide as the picture at most where its words allow it.
    fn title(&self, panel: &FigurePanel, letter: Option<String>) -> Vec<String> {
        // On a screen a small picture's title may be wider than the picture; on paper the width is fixed.
        let least = if self.paper.is_some() { 0.0 } else { LEAST_ROOM * self.font };
        let room = (width_px(panel) * self.scale).max(least);
        let mut lines: Vec<String> = Vec::new();
        // The two numbers of a slope stay together.
        let title = panel.title.as_ref().map(|title| title.replace(", ", ",\u{a0}"));
        for word in letter.iter().map(String::as_str).chain(title.iter().flat_map(|title| title.split(' '))) {
            match lines.last_mut() {
                Some(line) if self.text_width(line) + self.text_width(word) <= room => {
                    line.push(' ');
                    line.push_str(word);
                }
                _ => lines.push(word.to_owned()),
            }
        }
        lines
    }

    /// Draws a panel with its left top corner at `corner`, below a title in a room of so many lines; returns its size.
    fn panel(
        &self,
        panel: &FigurePanel,
        (title, lines): (&[String], usize),
        shared: &Shared<'_>,
        corner: [f32; 2],
        out: &mut Vec<FigureShape>,
    ) -> [f32; 2] {
        let font = self.font;
        // A panel's picture may be binned: the scale is of image pixels, the same in all panels.
        let px = self.scale * panel.image_px_per_px;
        let size = [panel.size.0 as f32 * px, panel.size.1 as f32 * px];
        let mut width = size[0];
        for (line, text) in title.iter().enumerate() {
            let baseline = corner[1] + (1.0 + LINE * (lines.saturating_sub(title.len()) + line) as f32) * font;
            out.push(self.text([corner[0], baseline], text));
            width = if self.paper.is_some() { width } else { width.max(self.text_width(text)) };
        }
        let top = corner[1] + if lines > 0 { (0.35 + LINE * lines as f32) * font } else { 0.0 };
        let rect = FigureRect { min: [corner[0], top], size };
        out.push(FigureShape::Picture { rect, size: panel.size, rgba: panel.rgba.clone() });
        let mut over = Vec::new();
        // All fans below all marks, so that no fan hides a circle.
        panel.marks.iter().for_each(|mark| self.fan(panel, mark, rect, &mut over));
        panel.marks.iter().for_each(|mark| self.mark(panel, mark, rect, &mut over));
        out.extend((!over.is_empty()).then_some(FigureShape::Clipped { rect, round: true, shapes: over }));
        let mut bottom = top + size[1];
        if let Some(bar) = panel.bar.as_ref().filter(|_| shared.bar.is_none()) {
            width = width.max(self.colour_bar(bar, [corner[0], bottom], size[0], out));
            bottom += BAR_HEIGHT * font;
        }
        // A legend that all panels share stands once, below all.
        let legend = if shared.legend.is_empty() { &panel.legend[..] } else { &[] };
        let (legend_width, legend_height) = self.legend(legend, [corner[0], bottom], size[0], out);
        [width.max(legend_width), bottom + legend_height - corner[1]]
    }

    fn place(&self, panel: &FigurePanel, rect: FigureRect, at: [f32; 2]) -> [f32; 2] {
        [0, 1].map(|i| rect.min[i] + (at[i] - panel.origin_image[i]) * self.scale)
    }

    fn fan(&self, panel: &FigurePanel, mark: &FigureMark, rect: FigureRect, out: &mut Vec<FigureShape>) {
        let Some(ends) = mark.motion.filter(|ends| ends.iter().flatten().all(drawable)) else { return };
        let [from, tip] = ends.map(|at| self.place(panel, rect, at));
        let middle = [0, 1].map(|i| 0.5 * (from[i] + tip[i]));
        if let Some(points) = fan(middle, tip, mark.motion_sigma * self.scale) {
            out.push(area(points, mark.color, FAN_OPACITY * mark.opacity.clamp(0.0, 1.0)));
        }
    }

    fn mark(&self, panel: &FigurePanel, mark: &FigureMark, rect: FigureRect, out: &mut Vec<FigureShape>) {
        let place = |at: [f32; 2]| self.place(panel, rect, at);
        // Features may come from a table, which may hold any numbers.
        let numbers = [mark.centre[0], mark.centre[1], mark.radius, mark.orientation.unwrap_or(0.0)];
        if !(numbers.iter().all(drawable) && mark.radius >= 0.0) {
            return;
        }
        let stroke = FigureStroke::new(mark.color, self.stroke * mark.weight);
        let stroke = FigureStroke { opacity: mark.opacity.clamp(0.0, 1.0), ..stroke };
        let (centre, radius) = (place(mark.centre), mark.radius * self.scale);
        if let Some([from, to]) = mark.motion.filter(|ends| ends.iter().flatten().all(drawable)) {
            let (from, to) = (place(from), place(to));
            let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
            let length = dx.hypot(dy);
            if length > 0.5 {
                // Two barbs, no larger than the arrow itself.
                let barb = (4.0 * stroke.width).min(0.5 * length);
                let (ax, ay) = (dx / length, dy / length);
                let end = |side: f32| [to[0] - barb * (ax + 0.5 * side * ay), to[1] - barb * (ay - 0.5 * side * ax)];
                out.push(line(vec![from, to], stroke, "motion"));
                out.push(line(vec![end(1.0), to, end(-1.0)], stroke, "motion"));
            }
        }
        if mark.weight > 0.0 && radius > 0.0 {
            // Eight dashes and eight gaps fit around, so that no seam is seen.
            let dash = std::f32::consts::TAU * radius / 16.0;
            let style = if mark.dashed { stroke.dashed([dash; 2]) } else { stroke }.into();
            out.push(FigureShape::Circle { centre, radius, style });
        }
        if let Some(angle) = mark.orientation {
            let (sin, cos) = angle.sin_cos();
            let tip = [centre[0] + radius * cos, centre[1] + radius * sin];
            out.push(line(vec![centre, tip], stroke, "orientation"));
        }
    }

    fn scale_bar(&self, rect: FigureRect, out: &mut Vec<FigureShape>) {
        // At most a fifth of the picture, a round number of image pixels.
        let length_px = round_length(f64::from(0.2 * rect.size[0] / self.scale).max(1.0)) as f32;
        let (font, length, label) = (self.font, length_px * self.scale, format!("{length_px} px"));
        let width = length.max(self.text_width(&label)) + 0.6 * font;
        let right = rect.min[0] + rect.size[0] - 0.4 * font;
        let y = rect.min[1] + rect.size[1] - 0.8 * font;
        // White on black: readable on any picture.
        out.push(filled(FigureRect { min: [right - width, y - 1.4 * font], size: [width, 1.8 * font] }, [0; 3]));
        let middle = right - 0.5 * width;
        let ends = [middle - 0.5 * length, middle + 0.5 * length].map(|x| [x, y]);
        out.push(line(ends.to_vec(), FigureStroke::new([255; 3], 0.2 * font), "scale"));
        let at = [middle - 0.25 * font * label.chars().count() as f32, y - 0.4 * font];
        out.push(self.coloured_text(at, [255; 3], &label));
    }

    /// Draws the colours of the values in one line, with the values at their ends; returns its width.
    fn colour_bar(&self, bar: &ColourBar, corner: [f32; 2], room: f32, out: &mut Vec<FigureShape>) -> f32 {
        let font = self.font;
        let (low, high) = (self.text_width(&bar.low), self.text_width(&bar.high));
        // Under a narrow picture the bar may be wider than it; under a wide one it stays short.
        let length = (room - low - high - font).clamp(4.0 * font, 20.0 * font);
        let (left, baseline) = (corner[0] + low + 0.4 * font, corner[1] + 1.35 * font);
        out.push(self.text([corner[0], baseline], &bar.low));
        let step = length / bar.colors.len().max(1) as f32;
        for (i, &color) in bar.colors.iter().enumerate() {
            let min = [left + step * i as f32, baseline - 0.8 * font];
            // A little wider than a step, so that there is no gap between two steps.
            out.push(filled(FigureRect { min, size: [step + 0.3, 0.9 * font] }, color));
        }
        out.push(self.text([left + length + 0.4 * font, baseline], &bar.high));
        low + high + length + font
    }

    /// Draws the legend's entries in as many lines as they need; returns the size.
    fn legend(&self, entries: &[LegendEntry], corner: [f32; 2], room: f32, out: &mut Vec<FigureShape>) -> (f32, f32) {
        let font = self.font;
        let (mut left, mut row, mut width) = (0f32, 0usize, 0f32);
        for entry in entries {
            let swatch = match entry.mark {
                LegendMark::Square => 0.9 * font,
                // Two dashes are seen.
                LegendMark::Line | LegendMark::Dashes => 1.75 * font,
                LegendMark::Wheel => WHEEL_HEIGHT * font,
            };
            let needed = swatch + 1.4 * font + self.text_width(&entry.label); // with the gaps
            // The first entry of a line stays, however long: another line would not help.
            if left > 0.0 && left + needed > room {
                (left, row) = (0.0, row + 1);
            }
            let (x, baseline) = (corner[0] + left, corner[1] + font * (1.35 + 1.5 * row as f32));
            let min = [x, baseline - 0.8 * font];
            let mut label = baseline;
            match entry.mark {
                LegendMark::Square => {
                    out.push(filled(FigureRect { min, size: [swatch; 2] }, entry.color));
                }
                // A wheel is higher than a line: its label stands at the middle, and rows are added.
                LegendMark::Wheel => {
                    out.extend(wheel(min.map(|corner| corner + 0.5 * swatch), 0.5 * swatch));
                    label = min[1] + 0.5 * swatch + 0.35 * font;
                    row += WHEEL_ROWS - 1;
                }
                mark => {
                    let points = [x, x + swatch].map(|x| [x, baseline - 0.35 * font]).to_vec();
                    let width = (0.12 * font).max(self.stroke);
                    let stroke = FigureStroke::new(entry.color, width);
                    let dashed = mark == LegendMark::Dashes;
                    let stroke = if dashed { stroke.dashed([DASH * width; 2]) } else { stroke };
                    out.push(line(points, stroke, "legend"));
                }
            }
            out.push(self.text([x + swatch + 0.3 * font, label], &entry.label));
            left += needed;
            width = width.max(left);
        }
        (width, if entries.is_empty() { 0.0 } else { font * (0.3 + 1.5 * (row + 1) as f32) })
    }
}

/// Diameter of a wheel of colours, heights of letters, and the lines of a legend that it takes.
const WHEEL_HEIGHT: f32 = 4.0;
const WHEEL_ROWS: usize = 3;

/// The colours of motions by direction and length. Discs and sectors overlap, so that no gap is seen.
fn wheel(centre: [f32; 2], radius: f32) -> Vec<FigureShape> {
    const RINGS: u8 = 5;
    const SECTORS: u8 = 36;
    let sector_of = |ring: u8, sector: u8| {
        let fraction = f32::from(ring) / f32::from(RINGS);
        let angle = |sector: f32| std::f32::consts::TAU * sector / f32::from(SECTORS);
        let at = |sector: f32| {
            let (sin, cos) = angle(sector).sin_cos();
            [centre[0] + fraction * radius * cos, centre[1] + fraction * radius * sin]
        };
        let points = vec![centre, at(f32::from(sector) - 0.5), at(f32::from(sector)), at(f32::from(sector) + 1.0)];
        area(points, direction_colour(angle(f32::from(sector)), fraction), 1.0)
    };
    (1..=RINGS).rev().flat_map(|ring| (0..SECTORS).map(move |sector| sector_of(ring, sector))).collect()
}

fn line(points: Vec<[f32; 2]>, stroke: FigureStroke, class: &'static str) -> FigureShape {
    FigureShape::Line { points: points.into_iter().map(Some).collect(), style: stroke.into(), class }
}

fn filled(rect: FigureRect, color: Colour) -> FigureShape {
    FigureShape::Rect { rect, style: color.into() }
}

/// An area, all of which is seen from its first point.
fn area(points: Vec<[f32; 2]>, color: Colour, opacity: f32) -> FigureShape {
    let style = ShapeStyle { fill: Some((color, opacity)), stroke: None };
    FigureShape::Line { points: points.into_iter().map(Some).collect(), style, class: "fan" }
}

/// The largest of 1, 2 or 5 times a power of ten that is at most `max`, which is finite and above 0.
pub fn round_length(max: f64) -> f64 {
    let power = 10f64.powf(max.log10().floor());
    [5.0, 2.0, 1.0].into_iter().map(|step| step * power).find(|length| *length <= max).unwrap_or(power)
}

/// Opacity of fans.
pub const FAN_OPACITY: f32 = 0.16;
/// Smallest standard deviation that has a fan, pixels of the drawing.
const MIN_SIGMA_PX: f32 = 3.0;
const PIECES: usize = 16;

/// Outline of the fan of an arrow: from its `middle` around the circle of one standard deviation `sigma` at its `tip`,
/// pixels of the drawing; the circle alone where it holds the middle. `None` where `sigma` is too small, or unknown.
pub fn fan(middle: [f32; 2], tip: [f32; 2], sigma: f32) -> Option<Vec<[f32; 2]>> {
    if !(MIN_SIGMA_PX..1e9).contains(&sigma) {
        return None;
    }
    let (along_x, along_y) = (tip[0] - middle[0], tip[1] - middle[1]);
    let (length, angle) = (along_x.hypot(along_y), along_y.atan2(along_x));
    // Up to the tangents from the middle; within the circle there is nothing to point from.
    let (from, half) = if length > sigma { (middle, FRAC_PI_2 + (sigma / length).asin()) } else { (tip, PI) };
    let around = (0..=PIECES).map(|piece| {
        let (sin, cos) = (angle + half * (2.0 * piece as f32 / PIECES as f32 - 1.0)).sin_cos();
        [tip[0] + sigma * cos, tip[1] + sigma * sin]
    });
    Some(std::iter::once(from).chain(around).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scale_bars_have_round_lengths_and_letters_go_on() {
        let lengths = [1999.0, 100.0, 49.0, 3.0, 1.0, 0.29].map(round_length);
        assert_eq!(lengths, [1000.0, 100.0, 20.0, 2.0, 1.0, 0.2]);
        assert_eq!([0, 1, 25, 26, 27].map(letter), ["(a)", "(b)", "(z)", "(aa)", "(ab)"]);
    }
}
