//! The sheet on which a figure is drawn: lines, text, pictures, and axes with round ticks.

use super::base64::picture_as_data_url;
use super::mark::SVG_COMMENT;
use crate::plane::Plane;
use crate::plane::display::Display;
use std::fmt::Write;

/// Colour of letters and axes.
pub const INK: &str = "#24292f";
/// Colour of less important parts.
pub const FAINT: &str = "#8c959f";
/// Colour of lines behind curves.
pub const GRID: &str = "#e4e8ec";
/// Okabe and Ito's blue; [`RED`] and [`GREEN`] are of the same palette, which colour-blind readers can tell apart.
pub const BLUE: &str = "#0072b2";
/// Okabe and Ito's vermilion.
pub const RED: &str = "#d55e00";
/// Okabe and Ito's green, darker.
pub const GREEN: &str = "#007a58";
/// Approximate width of a letter over the size of the font.
const LETTER: f64 = 0.52;

/// A rectangle of the sheet, pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Area {
    /// Left side.
    pub x: f64,
    /// Upper side.
    pub y: f64,
    /// Width.
    pub width: f64,
    /// Height.
    pub height: f64,
}

impl Area {
    /// Right side.
    pub fn right(&self) -> f64 {
        self.x + self.width
    }

    /// Lower side.
    pub fn bottom(&self) -> f64 {
        self.y + self.height
    }
}

/// Alignment of a text to its position.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Anchor {
    /// The text begins there.
    Start,
    /// The text's middle is there.
    Middle,
    /// The text ends there.
    End,
}

/// SVG document under construction. Lengths are pixels.
#[derive(Debug)]
pub struct Sheet {
    body: String,
    width: f64,
    title: String,
    /// Number of clipping rectangles.
    clips: usize,
}

impl Sheet {
    /// Creates an empty sheet; screen readers use `title`.
    pub fn new(width: f64, title: &str) -> Self {
        Self { body: String::new(), width, title: title.to_owned(), clips: 0 }
    }

    /// Finishes the document, `height` high.
    pub fn finish(self, height: f64) -> String {
        let Self { body, width, title, .. } = self;
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" xmlns:xlink=\"http://www.w3.org/1999/xlink\" width=\"{width:.0}\" height=\"{height:.0}\" \
             viewBox=\"0 0 {width:.0} {height:.0}\" font-family=\"Helvetica, Arial, 'DejaVu Sans', sans-serif\" font-size=\"12\" fill=\"{INK}\">\n\
             {SVG_COMMENT}\n<title>{}</title>\n<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n{body}</svg>\n",
            escaped(&title)
        )
    }

    /// Draws a line of text of `size` pixels.
    pub fn text(&mut self, (x, y): (f64, f64), size: f64, anchor: Anchor, text: &str) {
        self.styled_text((x, y), size, anchor, "", text);
    }

    /// Draws a line of text with more attributes, such as a colour.
    pub fn styled_text(&mut self, (x, y): (f64, f64), size: f64, anchor: Anchor, style: &str, text: &str) {
        let anchor = match anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        self.put(format_args!(
            r#"<text x="{x:.1}" y="{y:.1}" font-size="{size}" text-anchor="{anchor}" {style}>{}</text>"#,
            escaped(text)
        ));
    }

    /// Draws text in lines of at most `width` pixels; returns the position of the next line.
    pub fn paragraph(&mut self, (x, y): (f64, f64), size: f64, width: f64, text: &str) -> f64 {
        let letters = (width / (LETTER * size)).max(8.0) as usize;
        let (mut line, mut y) = (String::new(), y);
        for word in text.split_whitespace() {
            if !line.is_empty() && line.chars().count() + 1 + word.chars().count() > letters {
                self.text((x, y), size, Anchor::Start, &line);
                line.clear();
                y += 1.35 * size;
            }
            if !line.is_empty() {
                line.push(' ');
            }
            line.push_str(word);
        }
        self.text((x, y), size, Anchor::Start, &line);
        y + 1.35 * size
    }

    /// Draws a straight line.
    pub fn line(&mut self, (x1, y1): (f64, f64), (x2, y2): (f64, f64), colour: &str, style: &str) {
        self.put(format_args!(
            r#"<line x1="{x1:.1}" y1="{y1:.1}" x2="{x2:.1}" y2="{y2:.1}" stroke="{colour}" {style}/>"#
        ));
    }

    /// Draws a rectangle, filled and outlined by `style`.
    pub fn rectangle(&mut self, area: Area, style: &str) {
        let Area { x, y, width, height } = area;
        self.put(format_args!(r#"<rect x="{x:.1}" y="{y:.1}" width="{width:.1}" height="{height:.1}" {style}/>"#));
    }

    /// Draws a circle, filled and outlined by `style`.
    pub fn circle(&mut self, (x, y): (f64, f64), radius: f64, style: &str) {
        self.put(format_args!(r#"<circle cx="{x:.1}" cy="{y:.1}" r="{radius:.1}" {style}/>"#));
    }

    /// Draws a line through points, with breaks where a point is `None`.
    pub fn polyline(&mut self, points: impl IntoIterator<Item = Option<(f64, f64)>>, style: &str) {
        let mut path = String::new();
        let mut is_down = false;
        for point in points {
            match point {
                Some((x, y)) => {
                    // Writing into a string cannot fail.
                    let _ = write!(path, "{}{x:.1} {y:.1}", if is_down { "L" } else { "M" });
                    is_down = true;
                }
                None => is_down = false,
            }
        }
        self.put(format_args!(r#"<path d="{path}" fill="none" {style}/>"#));
    }

    /// Draws a plane as a picture that fills `area`; pixels stay sharp.
    pub fn picture(&mut self, area: Area, plane: &Plane, display: &Display) {
        let colours = display.colours();
        let pixels: Vec<u8> = plane.data().iter().flat_map(|&x| colours.colour(x)).collect();
        let url = picture_as_data_url(plane.width(), plane.height(), &pixels);
        let Area { x, y, width, height } = area;
        self.put(format_args!(
            r#"<image x="{x:.1}" y="{y:.1}" width="{width:.1}" height="{height:.1}" preserveAspectRatio="none" style="image-rendering:pixelated" xlink:href="{url}"/>"#
        ));
    }

    /// Draws the shapes of `draw`, clipped to `area`.
    pub fn clipped(&mut self, area: Area, draw: impl FnOnce(&mut Self)) {
        self.clips += 1;
        let (id, Area { x, y, width, height }) = (self.clips, area);
        self.put(format_args!(
            r#"<clipPath id="clip{id}"><rect x="{x:.1}" y="{y:.1}" width="{width:.1}" height="{height:.1}"/></clipPath><g clip-path="url(#clip{id})">"#
        ));
        draw(self);
        self.put(format_args!("</g>"));
    }

    /// Draws ticks and labels under an area, for values from `range.0` at its left to `range.1` at its right.
    pub fn axis_below(&mut self, area: Area, range: (f64, f64), label: &str) {
        for tick in ticks(range) {
            let x = area.x + (tick - range.0) / (range.1 - range.0) * area.width;
            self.line((x, area.bottom()), (x, area.bottom() + 4.0), INK, "");
            self.text((x, area.bottom() + 16.0), 11.0, Anchor::Middle, &short(tick));
        }
        self.text((area.x + 0.5 * area.width, area.bottom() + 32.0), 12.0, Anchor::Middle, label);
    }

    /// Draws ticks and labels left of an area, for values from `range.0` at its bottom to `range.1` at its top.
    pub fn axis_left(&mut self, area: Area, range: (f64, f64), label: &str) {
        for tick in ticks(range) {
            let y = area.bottom() - (tick - range.0) / (range.1 - range.0) * area.height;
            self.line((area.x - 4.0, y), (area.x, y), INK, "");
            self.text((area.x - 7.0, y + 4.0), 11.0, Anchor::End, &short(tick));
        }
        self.label_left(area, label);
    }

    /// Draws the label of a vertical axis.
    pub fn label_left(&mut self, area: Area, label: &str) {
        let (x, y) = (area.x - 50.0, area.y + 0.5 * area.height);
        self.put(format_args!(
            r#"<text transform="translate({x:.1} {y:.1}) rotate(-90)" text-anchor="middle">{}</text>"#,
            escaped(label)
        ));
    }

    fn put(&mut self, element: std::fmt::Arguments<'_>) {
        // Writing into a string cannot fail.
        let _ = self.body.write_fmt(element);
        self.body.push('\n');
    }
}

/// Round numbers within a range, about five of them.
pub fn ticks((min, max): (f64, f64)) -> Vec<f64> {
    let rough = (max - min) / 5.0;
    if !(rough > 0.0 && rough.is_finite()) {
        return vec![min];
    }
    let magnitude = 10f64.powf(rough.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].map(|s| s * magnitude).into_iter().find(|s| *s >= rough).unwrap_or(rough);
    let first = (min / step).ceil() as i64;
    (first..).map(|i| i as f64 * step).take_while(|tick| *tick <= max + 1e-9 * step).take(12).collect()
}

/// The number at a tick, as text.
pub fn short(x: f64) -> String {
    let text = if x != 0.0 && x.abs() < 1e-3 { format!("{x:.0e}") } else { format!("{x:.4}") };
    let short = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if short == "-0" { "0".to_owned() } else { short.replace('-', "−") }
}

/// Stacks documents of this module under one another, as one.
pub fn stacked(title: &str, documents: &[String]) -> String {
    let length = |document: &str, name: &str| -> f64 {
        let start = document.find(&format!(" {name}=\"")).map_or(0, |at| at + name.len() + 3);
        document[start..].split('"').next().and_then(|text| text.parse().ok()).unwrap_or(0.0)
    };
    let width = documents.iter().map(|document| length(document, "width")).fold(1.0, f64::max);
    let mut sheet = Sheet::new(width, title);
    let mut y = 0.0;
    for (index, document) in documents.iter().enumerate() {
        // An SVG within an SVG has its own position, but shares the names.
        let inner = document.trim_end().replacen("<svg ", &format!(r#"<svg y="{y:.0}" "#), 1);
        let inner = inner.replace(r#"id="clip"#, &format!(r#"id="part{index}-clip"#));
        let inner = inner.replace("url(#clip", &format!("url(#part{index}-clip"));
        sheet.put(format_args!("{inner}"));
        y += length(document, "height");
    }
    sheet.finish(y)
}

/// Escapes text for XML and HTML. Characters that XML 1.0 does not allow are replaced by U+FFFD.
pub fn escaped(text: &str) -> String {
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
    fn markup_is_escaped_and_what_xml_forbids_is_replaced() {
        assert_eq!(escaped("a<b & \"c\"\u{1}"), "a&lt;b &amp; &quot;c&quot;\u{fffd}");
        let mut sheet = Sheet::new(100.0, "title\u{0}\u{b}");
        sheet.text((1.0, 2.0), 10.0, Anchor::Start, "name\u{1b}[31m\u{ffff}");
        let document = sheet.finish(50.0);
        assert!(roxmltree::Document::parse(&document).is_ok(), "{document}");
    }

    #[test]
    fn ticks_are_round_and_inside() {
        assert_eq!(ticks((-3.0, 3.0)), [-2.0, 0.0, 2.0]);
        assert_eq!(ticks((0.0, 45.0)), [0.0, 10.0, 20.0, 30.0, 40.0]);
        assert_eq!(ticks((2.0, 2.0)), [2.0]);
        for k in 1..400 {
            let range = (-0.013 * f64::from(k), 0.031 * f64::from(k));
            let ticks = ticks(range);
            assert!(
                (2..=12).contains(&ticks.len()) && ticks.iter().all(|t| *t >= range.0 - 1e-9 && *t <= range.1 + 1e-9)
            );
        }
        assert_eq!((short(-2.0), short(0.25), short(0.000_2)), ("−2".into(), "0.25".into(), "2e−4".into()));
    }

    #[test]
    fn documents_stand_under_one_another() {
        let document = |height: f64| Sheet::new(120.0, "part").finish(height);
        let both = stacked("both", &[document(50.0), document(70.0)]);
        assert!(both.starts_with("<svg ") && both.contains(r#"width="120" height="120""#), "{both}");
        assert!(both.contains(r#"<svg y="50" "#) && both.matches("</svg>").count() == 3, "{both}");
    }

    #[test]
    fn a_paragraph_is_broken_where_it_is_full() {
        let mut sheet = Sheet::new(200.0, "a < b");
        let next = sheet.paragraph((0.0, 10.0), 10.0, 60.0, "one two three four five six");
        assert!(next > 30.0);
        let text = sheet.finish(50.0);
        assert!(text.contains("<title>a &lt; b</title>") && text.matches("<text").count() >= 3, "{text}");
    }
}
