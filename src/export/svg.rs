//! A figure for a paper: the picture as shown, with the features drawn over it as vectors.
//!
//! A feature is a circle of radius √2·σ, the radius of the blob to which a scale σ answers most strongly; a tick from its centre to the circle
//! in the direction of its orientation; and an arrow along its slope, as long as the way from mid-burst to the last frame. The coordinate system is that of the
//! image, with half a pixel added, because in SVG the first pixel's centre is at (0.5, 0.5).

use super::atomic::write_whole;
use super::base64::write_base64;
use super::error::ExportError;
use super::png::Picture;
use crate::detector::Feature;
use std::f32::consts::SQRT_2;
use std::io::{self, Write};
use std::path::Path;

/// What a colour of the figure means.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LegendEntry {
    /// Red, green, blue.
    pub color: [u8; 3],
    /// What has this colour.
    pub label: String,
}

/// How a figure is drawn. Lengths named `_px` are in the figure's own pixels, whatever the scale.
#[derive(Debug, Clone, PartialEq)]
pub struct FigureOptions {
    /// Figure pixels for each image pixel, 1/64 … 64. Default 1.
    pub scale: f32,
    /// Width of all strokes, figure pixels. Default 1.5.
    pub stroke_width_px: f32,
    /// Height of the letters of title and legend, figure pixels. Default 14.
    pub font_size_px: f32,
    /// Whether orientation ticks are drawn. Default true.
    pub orientation: bool,
    /// Frames from mid-burst to the burst's end, (N − 1)/2: the length of a motion arrow is this times the slope. 0 (the default) draws none.
    pub motion_frames: f32,
    /// A line above the picture.
    pub title: Option<String>,
    /// What the colours mean, below the picture.
    pub legend: Vec<LegendEntry>,
}

impl Default for FigureOptions {
    fn default() -> Self {
        Self {
            scale: 1.0,
            stroke_width_px: 1.5,
            font_size_px: 14.0,
            orientation: true,
            motion_frames: 0.0,
            title: None,
            legend: Vec::new(),
        }
    }
}

/// Writes the figure as SVG 1.1. `color_of` is asked for each feature's colour (red, green, blue). Features that lie nowhere
/// (a number that is not finite, or beyond 10⁹) are left out.
///
/// # Errors
/// [`ExportError`] when the picture has no pixels or the file cannot be written; an older one is then untouched.
pub fn write_svg(
    path: &Path,
    picture: Picture<'_>,
    features: &[Feature],
    color_of: impl Fn(&Feature) -> [u8; 3],
    options: &FigureOptions,
) -> Result<(), ExportError> {
    picture.check_size(path)?;
    let within = |value: f32, least: f32, most: f32| if value.is_nan() { least } else { value.clamp(least, most) };
    let scale = within(options.scale, 1.0 / 64.0, 64.0);
    let layout = Layout::new(picture.size(), scale, within(options.font_size_px, 1.0, 1000.0) / scale, options);
    write_whole(path, |out| {
        layout.write_start(out, options)?;
        write_background(out, picture)?;
        let stroke = within(options.stroke_width_px, 0.0, 1000.0) / scale;
        writeln!(out, r#"<g id="features" fill="none" stroke-width="{}" stroke-linecap="round">"#, Number(stroke))?;
        for feature in features {
            write_feature(out, feature, color_of(feature), stroke, options)?;
        }
        writeln!(out, "</g>")?;
        layout.write_legend(out, options)?;
        writeln!(out, "</svg>")
    })
}

/// Where things are, in image pixels: the picture is at (0, 0), the title above it, the legend below.
struct Layout {
    /// Width of the whole figure: that of the picture, or more if title or legend need it.
    width: f32,
    /// Height of the picture.
    height: f32,
    scale: f32,
    /// Height of the letters.
    font: f32,
    title_height: f32,
    legend_height: f32,
    /// The legend's entries in rows: (column's left edge, row) of each.
    entries: Vec<(f32, usize)>,
}

impl Layout {
    fn new(size: (usize, usize), scale: f32, font: f32, options: &FigureOptions) -> Self {
        let (width, height) = (size.0 as f32, size.1 as f32);
        // A letter is at most about 0.65 of its height wide on average.
        let text_width = |text: &str| 0.65 * font * text.chars().count() as f32;
        let mut full_width = width.max(options.title.as_ref().map_or(0.0, |title| font + text_width(title)));
        let title_height = if options.title.is_some() { 1.8 * font } else { 0.0 };
        let (mut entries, mut left, mut row) = (Vec::new(), 0.5 * font, 0);
        for entry in &options.legend {
            let needed = 2.5 * font + text_width(&entry.label); // with the swatch and the gaps
            if left > 0.5 * font && left + needed > width {
                (left, row) = (0.5 * font, row + 1);
            }
            entries.push((left, row));
            left += needed;
            full_width = full_width.max(left);
        }
        let legend_height = if entries.is_empty() { 0.0 } else { font * (0.6 + 1.5 * (row + 1) as f32) };
        Self { width: full_width, height, scale, font, title_height, legend_height, entries }
    }

    fn write_start(&self, out: &mut impl Write, options: &FigureOptions) -> io::Result<()> {
        let full_height = self.title_height + self.height + self.legend_height;
        writeln!(out, r#"<?xml version="1.0" encoding="UTF-8"?>"#)?;
        writeln!(
            out,
            r#"<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" version="1.1" width="{}" height="{}" viewBox="0 {} {} {}">"#,
            Number(self.width * self.scale),
            Number(full_height * self.scale),
            Number(-self.title_height),
            Number(self.width),
            Number(full_height)
        )?;
        if let Some(title) = &options.title {
            writeln!(out, "<title>{}</title>", escaped(title))?;
        }
        // Paper is white, also in viewers with a dark background.
        writeln!(
            out,
            r##"<rect x="0" y="{}" width="{}" height="{}" fill="#ffffff"/>"##,
            Number(-self.title_height),
            Number(self.width),
            Number(full_height)
        )?;
        if let Some(title) = &options.title {
            self.write_text(out, 0.5 * self.font, -0.55 * self.font, title)?;
        }
        Ok(())
    }

    fn write_legend(&self, out: &mut impl Write, options: &FigureOptions) -> io::Result<()> {
        if self.entries.is_empty() {
            return Ok(());
        }
        writeln!(out, r#"<g id="legend">"#)?;
        for (entry, &(left, row)) in options.legend.iter().zip(&self.entries) {
            let baseline = self.height + self.font * (1.4 + 1.5 * row as f32);
            let side = 0.9 * self.font;
            writeln!(
                out,
                r#"<rect x="{}" y="{}" width="{side}" height="{side}" fill="{}"/>"#,
                Number(left),
                Number(baseline - 0.8 * self.font),
                Color(entry.color),
                side = Number(side),
            )?;
            self.write_text(out, left + 1.3 * self.font, baseline, &entry.label)?;
        }
        writeln!(out, "</g>")
    }

    fn write_text(&self, out: &mut impl Write, x: f32, y: f32, text: &str) -> io::Result<()> {
        writeln!(
            out,
            r##"<text x="{}" y="{}" font-family="sans-serif" font-size="{}" fill="#000000">{}</text>"##,
            Number(x),
            Number(y),
            Number(self.font),
            escaped(text)
        )
    }
}

fn write_background(out: &mut impl Write, picture: Picture<'_>) -> io::Result<()> {
    let (width, height) = picture.size();
    let mut png = Vec::new();
    picture.encode_png(&mut png)?;
    // Pixels stay sharp when magnified. `xlink:href` is what all of today's readers know.
    write!(
        out,
        r#"<image width="{width}" height="{height}" preserveAspectRatio="none" style="image-rendering:pixelated" xlink:href="data:image/png;base64,"#
    )?;
    write_base64(&png, out)?;
    writeln!(out, r#""/>"#)
}

fn write_feature(
    out: &mut impl Write,
    feature: &Feature,
    color: [u8; 3],
    stroke: f32,
    options: &FigureOptions,
) -> io::Result<()> {
    let numbers =
        [feature.u, feature.v, feature.sigma, feature.orientation, feature.slope.u, feature.slope.v, feature.response];
    let drawable = |n: f32| n.abs() < 1e9;
    if !numbers.into_iter().all(drawable) {
        return Ok(());
    }
    let (x, y, radius) = (feature.u + 0.5, feature.v + 0.5, SQRT_2 * feature.sigma.max(0.0));
    writeln!(out, r#"<g stroke="{}">"#, Color(color))?;
    writeln!(out, r#"<circle cx="{}" cy="{}" r="{}"/>"#, Number(x), Number(y), Number(radius))?;
    if options.orientation {
        let (sin, cos) = feature.orientation.sin_cos();
        writeln!(
            out,
            r#"<path class="orientation" d="M{} {}L{} {}"/>"#,
            Number(x),
            Number(y),
            Number(x + radius * cos),
            Number(y + radius * sin)
        )?;
    }
    let (du, dv) = (feature.slope.u * options.motion_frames, feature.slope.v * options.motion_frames);
    let length = du.hypot(dv);
    if length > 0.0 && drawable(length) {
        let (tip_x, tip_y) = (x + du, y + dv);
        let (along_u, along_v) = (du / length, dv / length);
        // Two barbs, no larger than the arrow itself.
        let barb = (4.0 * stroke).min(0.5 * length);
        let barb_end = |side: f32| {
            (tip_x - barb * (along_u + 0.5 * side * along_v), tip_y - barb * (along_v - 0.5 * side * along_u))
        };
        let ((lx, ly), (rx, ry)) = (barb_end(1.0), barb_end(-1.0));
        writeln!(
            out,
            r#"<path class="motion" d="M{} {}L{tip}M{} {}L{tip}L{} {}"/>"#,
            Number(x),
            Number(y),
            Number(lx),
            Number(ly),
            Number(rx),
            Number(ry),
            tip = format_args!("{} {}", Number(tip_x), Number(tip_y)),
        )?;
    }
    writeln!(out, "</g>")
}

/// A number in an SVG: a thousandth of a pixel is enough for the eye, and keeps files small.
struct Number(f32);

impl std::fmt::Display for Number {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let text = format!("{:.3}", self.0);
        let short = text.trim_end_matches('0').trim_end_matches('.');
        f.write_str(if short == "-0" { "0" } else { short })
    }
}

/// A colour as `#rrggbb`.
struct Color([u8; 3]);

impl std::fmt::Display for Color {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [r, g, b] = self.0;
        write!(f, "#{r:02x}{g:02x}{b:02x}")
    }
}

/// Text for XML: markup is escaped, and characters that XML 1.0 does not allow at all are replaced.
fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\u{fffe}' | '\u{ffff}' => out.push('\u{fffd}'),
            c if c.is_control() && !matches!(c, '\t' | '\n' | '\r') => out.push('\u{fffd}'),
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_colours_are_short() {
        let cases = [(1.0, "1"), (-0.00001, "0"), (2.5, "2.5"), (100.0, "100"), (1.0 / 3.0, "0.333")];
        for (number, text) in cases {
            assert_eq!(Number(number).to_string(), text);
        }
        assert_eq!(Color([0, 171, 255]).to_string(), "#00abff");
        assert_eq!(escaped("a<b & \"c\"\u{1}"), "a&lt;b &amp; &quot;c&quot;\u{fffd}");
    }
}
