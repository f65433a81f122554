//! Layout of a figure: positions of all its parts.

use super::{
    ColourBar, Drawing, FAN_OPACITY, FigureMark, FigureOptions, FigurePanel, FigureRect, FigureShape, FigureStroke,
    LegendEntry, fan,
};

/// Margin around the whole figure and between panels, in heights of letters.
const GAP: f32 = 0.8;

/// Lays out panels on a sheet, row by row; rows with the same number of panels share their columns.
///
/// Marks with invalid numbers (not finite, or beyond 10⁹) are left out.
pub fn lay_out(rows: &[Vec<FigurePanel>], options: &FigureOptions) -> Drawing {
    let within = |value: f32, min: f32, max: f32| if value.is_nan() { min } else { value.clamp(min, max) };
    let style = Style {
        scale: within(options.scale, 1.0 / 64.0, 64.0),
        stroke: within(options.stroke_width_px, 0.0, 1000.0),
        font: within(options.font_size_px, 1.0, 1000.0),
        scale_bar: options.scale_bar,
    };
    let mut shapes = Vec::new();
    let count = rows.iter().flatten().count();
    let mut letters = (0..count).map(|place| (options.letters && count > 1).then(|| letter(place)));
    let mut with_letter = |panel| (letters.next().flatten(), panel);
    let lettered: Vec<Vec<Lettered<'_>>> = rows.iter().map(|row| row.iter().map(&mut with_letter).collect()).collect();
    // With title and legend.
    let width_of = |(letter, panel): &Lettered<'_>| style.panel(panel, letter.as_deref(), [0.0; 2], &mut Vec::new())[0];
    let widths: Vec<Vec<f32>> = lettered.iter().map(|row| row.iter().map(width_of).collect()).collect();
    let (mut width, mut top) = (0f32, 0f32);
    let gap = GAP * style.font;
    for row in &lettered {
        let (mut left, mut height) = (0f32, 0f32);
        for (column, (letter, panel)) in row.iter().enumerate() {
            let size = style.panel(panel, letter.as_deref(), [left, top], &mut shapes);
            let alike = widths.iter().filter(|other| other.len() == row.len());
            left += alike.map(|other| other[column]).fold(0.0, f32::max) + gap;
            height = height.max(size[1]);
        }
        width = width.max(left - gap);
        top += height + gap;
    }
    let size = [width.max(1.0), (top - gap).max(1.0)];
    let titles: Vec<&str> = rows.iter().flatten().filter_map(|panel| panel.title.as_deref()).collect();
    shapes.insert(0, FigureShape::Fill { rect: FigureRect { min: [0.0, 0.0], size }, color: [255; 3] });
    Drawing { size, shapes, title: titles.join("; ") }
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

/// Whether a number is one of a place that can be drawn.
fn drawable(number: &f32) -> bool {
    number.abs() < 1e9
}

type Lettered<'a> = (Option<String>, &'a FigurePanel);

struct Style {
    scale: f32,
    stroke: f32,
    font: f32,
    scale_bar: bool,
}

impl Style {
    /// The width of a text, estimated: a letter is at most about 0.65 of its height wide on average.
    fn text_width(&self, text: &str) -> f32 {
        0.65 * self.font * text.chars().count() as f32
    }

    fn text(&self, at: [f32; 2], text: &str) -> FigureShape {
        FigureShape::Text { at, size: self.font, text: text.to_owned(), color: [0; 3] }
    }

    /// Draws a panel with its left top corner at `corner`; returns its size.
    fn panel(
        &self,
        panel: &FigurePanel,
        letter: Option<&str>,
        corner: [f32; 2],
        out: &mut Vec<FigureShape>,
    ) -> [f32; 2] {
        let font = self.font;
        let titles: Vec<&str> = letter.into_iter().chain(panel.title.as_deref()).collect();
        let px = self.scale * panel.image_px_per_px;
        let size = [panel.size.0 as f32 * px, panel.size.1 as f32 * px];
        let mut width = size[0];
        let mut top = corner[1];
        if !titles.is_empty() {
            let title = titles.join("  ");
            out.push(self.text([corner[0], top + 1.15 * font], &title));
            width = width.max(self.text_width(&title));
            top += 1.6 * font;
        }
        let rect = FigureRect { min: [corner[0], top], size };
        out.push(FigureShape::Picture { rect, size: panel.size, rgba: panel.rgba.clone() });
        let mut over = Vec::new();
        panel.marks.iter().for_each(|mark| self.fan(panel, mark, rect, &mut over));
        panel.marks.iter().for_each(|mark| self.mark(panel, mark, rect, &mut over));
        if self.scale_bar {
            self.scale_bar(rect, &mut over);
        }
        if !over.is_empty() {
            out.push(FigureShape::Clipped { rect, shapes: over });
        }
        let mut bottom = top + size[1];
        if let Some(bar) = &panel.bar {
            width = width.max(self.colour_bar(bar, [corner[0], bottom], size[0], out));
            bottom += 1.7 * font;
        }
        let (legend_width, legend_height) = self.legend(&panel.legend, [corner[0], bottom], size[0], out);
        [width.max(legend_width), bottom + legend_height - corner[1]]
    }

    /// Place on the sheet of the place `at` of a panel's image, whose picture lies in `rect`.
    fn place(&self, panel: &FigurePanel, rect: FigureRect, at: [f32; 2]) -> [f32; 2] {
        [0, 1].map(|i| rect.min[i] + (at[i] - panel.origin_image[i]) * self.scale)
    }

    fn fan(&self, panel: &FigurePanel, mark: &FigureMark, rect: FigureRect, out: &mut Vec<FigureShape>) {
        let Some(ends) = mark.motion.filter(|ends| ends.iter().flatten().all(drawable)) else { return };
        let [from, tip] = ends.map(|at| self.place(panel, rect, at));
        let middle = [0, 1].map(|i| 0.5 * (from[i] + tip[i]));
        if let Some(points) = fan(middle, tip, mark.motion_sigma * self.scale) {
            let opacity = FAN_OPACITY * mark.opacity.clamp(0.0, 1.0);
            out.push(FigureShape::Fan { points, color: mark.color, opacity });
        }
    }

    fn mark(&self, panel: &FigurePanel, mark: &FigureMark, rect: FigureRect, out: &mut Vec<FigureShape>) {
        let place = |at: [f32; 2]| self.place(panel, rect, at);
        let numbers = [mark.centre[0], mark.centre[1], mark.radius, mark.orientation.unwrap_or(0.0)];
        if !(numbers.iter().all(drawable) && mark.radius >= 0.0) {
            return;
        }
        let stroke =
            FigureStroke { width: self.stroke * mark.weight, color: mark.color, opacity: mark.opacity.clamp(0.0, 1.0) };
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
                out.push(FigureShape::Line { points: vec![from, to], stroke, class: "motion" });
                out.push(FigureShape::Line { points: vec![end(1.0), to, end(-1.0)], stroke, class: "motion" });
            }
        }
        if mark.weight > 0.0 && radius > 0.0 {
            out.push(FigureShape::Circle { centre, radius, stroke, dashed: mark.dashed });
        }
        if let Some(angle) = mark.orientation {
            let (sin, cos) = angle.sin_cos();
            let tip = [centre[0] + radius * cos, centre[1] + radius * sin];
            out.push(FigureShape::Line { points: vec![centre, tip], stroke, class: "orientation" });
        }
    }

    fn scale_bar(&self, rect: FigureRect, out: &mut Vec<FigureShape>) {
        let length_px = round_length(f64::from(0.2 * rect.size[0] / self.scale).max(1.0)) as f32;
        let length = length_px * self.scale;
        let right = rect.min[0] + rect.size[0] - 0.7 * self.font;
        let y = rect.min[1] + rect.size[1] - 0.7 * self.font;
        let label = format!("{length_px} px");
        let text = [right - 0.5 * (length + 0.55 * self.font * label.chars().count() as f32), y - 0.45 * self.font];
        // White with a dark edge: readable on any picture.
        for (extra, color) in [(3.0, [0u8; 3]), (0.0, [255; 3])] {
            let stroke = FigureStroke { width: 0.2 * self.font + extra, color, opacity: 1.0 };
            out.push(FigureShape::Line { points: vec![[right - length, y], [right, y]], stroke, class: "scale" });
        }
        for shift in [[-1.0, 0.0], [1.0, 0.0], [0.0, -1.0], [0.0, 1.0]] {
            let at = [text[0] + shift[0], text[1] + shift[1]];
            out.push(FigureShape::Text { at, size: self.font, text: label.clone(), color: [0; 3] });
        }
        out.push(FigureShape::Text { at: text, size: self.font, text: label, color: [255; 3] });
    }

    /// Draws the colours of the values in one line, with the values at their ends; returns its width.
    fn colour_bar(&self, bar: &ColourBar, corner: [f32; 2], room: f32, out: &mut Vec<FigureShape>) -> f32 {
        let font = self.font;
        let (low, high) = (self.text_width(&bar.low), self.text_width(&bar.high));
        let length = (room - low - high - font).clamp(4.0 * font, 20.0 * font);
        let (left, baseline) = (corner[0] + low + 0.4 * font, corner[1] + 1.35 * font);
        out.push(self.text([corner[0], baseline], &bar.low));
        let step = length / bar.colors.len().max(1) as f32;
        for (i, &color) in bar.colors.iter().enumerate() {
            let min = [left + step * i as f32, baseline - 0.8 * font];
            // A little wider than a step, so that there is no gap between two steps.
            out.push(FigureShape::Fill { rect: FigureRect { min, size: [step + 0.3, 0.9 * font] }, color });
        }
        out.push(self.text([left + length + 0.4 * font, baseline], &bar.high));
        low + high + length + font
    }

    /// Draws the legend's entries in as many lines as they need; returns the size.
    fn legend(&self, entries: &[LegendEntry], corner: [f32; 2], room: f32, out: &mut Vec<FigureShape>) -> (f32, f32) {
        let font = self.font;
        let (mut left, mut row, mut width) = (0f32, 0usize, 0f32);
        for entry in entries {
            let needed = 2.3 * font + self.text_width(&entry.label); // with the swatch and the gaps
            if left > 0.0 && left + needed > room {
                (left, row) = (0.0, row + 1);
            }
            let (x, baseline) = (corner[0] + left, corner[1] + font * (1.35 + 1.5 * row as f32));
            let rect = FigureRect { min: [x, baseline - 0.8 * font], size: [0.9 * font; 2] };
            out.push(FigureShape::Fill { rect, color: entry.color });
            out.push(self.text([x + 1.2 * font, baseline], &entry.label));
            left += needed;
            width = width.max(left);
        }
        (width, if entries.is_empty() { 0.0 } else { font * (0.3 + 1.5 * (row + 1) as f32) })
    }
}

/// The largest of 1, 2 or 5 times a power of ten that is at most `max`, which is finite and above 0.
pub fn round_length(max: f64) -> f64 {
    let power = 10f64.powf(max.log10().floor());
    [5.0, 2.0, 1.0].into_iter().map(|step| step * power).find(|length| *length <= max).unwrap_or(power)
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use std::sync::Arc;

    pub fn panel(size: (usize, usize)) -> FigurePanel {
        FigurePanel {
            size,
            rgba: Arc::new(vec![9; size.0 * size.1 * 4]),
            origin_image: [-0.5, -0.5],
            image_px_per_px: 1.0,
            marks: Vec::new(),
            title: None,
            legend: Vec::new(),
            bar: None,
        }
    }

    #[test]
    fn scale_bars_have_round_lengths_and_letters_go_on() {
        let lengths = [1999.0, 100.0, 49.0, 3.0, 1.0, 0.29].map(round_length);
        assert_eq!(lengths, [1000.0, 100.0, 20.0, 2.0, 1.0, 0.2]);
        assert_eq!([0, 1, 25, 26, 27].map(letter), ["(a)", "(b)", "(z)", "(aa)", "(ab)"]);
    }

    #[test]
    fn panels_do_not_overlap_and_lie_on_the_sheet() {
        let mut titled = panel((40, 30));
        titled.title = Some("A long title that needs much more room than its picture has".into());
        titled.bar = Some(ColourBar { colors: vec![[1; 3]; 9], low: "0".into(), high: "0.1 of full scale".into() });
        let rows = [vec![panel((20, 60)), titled.clone()], vec![titled, panel((10, 10))]];
        let options = FigureOptions { letters: true, scale: 2.0, ..FigureOptions::default() };
        let drawing = lay_out(&rows, &options);
        let rects: Vec<FigureRect> = drawing.pictures().collect();
        assert_eq!(rects.len(), 4);
        assert_eq!((rects[0].min[0], rects[1].min[0]), (rects[2].min[0], rects[3].min[0]), "columns are not in line");
        for (i, a) in rects.iter().enumerate() {
            assert!((0..2).all(|k| a.min[k] >= 0.0 && a.min[k] + a.size[k] <= drawing.size[k] + 1e-3));
            let apart =
                |b: &FigureRect| (0..2).any(|k| a.min[k] + a.size[k] <= b.min[k] || b.min[k] + b.size[k] <= a.min[k]);
            assert!(rects[..i].iter().all(apart), "{rects:?}");
        }
        let letters = |letter: &str| {
            drawing.shapes.iter().any(|s| matches!(s, FigureShape::Text { text, .. } if text.starts_with(letter)))
        };
        assert!(letters("(a)") && letters("(d)") && !letters("(e)"));
    }
}
