//! Writer of SVG 1.1, for everything that is drawn as SVG: elements, one a line, escaped text, short numbers.

use super::png::Bitmap;
use base64::display::Base64Display;
use base64::engine::general_purpose::STANDARD;
use std::fmt::{self, Display, Write as _};
use std::io::{self, Write};

/// Name and value of an attribute; the value is escaped.
pub(super) type Attribute<'a> = (&'a str, &'a dyn Display);

#[derive(Debug)]
pub(super) struct SvgWriter<W> {
    out: W,
    clips: usize,
}

impl<W: Write> SvgWriter<W> {
    pub fn part(out: W) -> Self {
        Self { out, clips: 0 }
    }

    /// Begins a document of `size` (width, height) in a unit of CSS, pixels if it is empty; screen readers use `title`.
    pub fn document(out: W, size: (f64, f64, &str), title: &str, more: &[Attribute<'_>]) -> io::Result<Self> {
        let mut svg = Self::part(out);
        let view = format!("0 0 {} {}", Number(size.0), Number(size.1));
        let [width, height] = [size.0, size.1].map(|side| format!("{}{}", Number(side), size.2));
        let names: [Attribute<'_>; 2] =
            [("xmlns", &"http://www.w3.org/2000/svg"), ("xmlns:xlink", &"http://www.w3.org/1999/xlink")];
        let sizes: [Attribute<'_>; 4] =
            [("version", &"1.1"), ("width", &width), ("height", &height), ("viewBox", &view)];
        svg.begin("svg", &[&names[..], &sizes, more].concat())?;
        svg.text("title", &[], "", title)?;
        Ok(svg)
    }

    pub fn finish(mut self) -> io::Result<W> {
        self.end("svg")?;
        Ok(self.out)
    }

    pub fn into_inner(self) -> W {
        self.out
    }

    pub fn empty(&mut self, name: &str, attributes: &[Attribute<'_>], style: &str) -> io::Result<()> {
        self.tag(name, attributes, style)?;
        self.out.write_all(b"/>\n")
    }

    pub fn text(&mut self, name: &str, attributes: &[Attribute<'_>], style: &str, text: &str) -> io::Result<()> {
        self.tag(name, attributes, style)?;
        writeln!(self.out, ">{}</{name}>", Escaped(&text))
    }

    pub fn begin(&mut self, name: &str, attributes: &[Attribute<'_>]) -> io::Result<()> {
        self.tag(name, attributes, "")?;
        self.out.write_all(b">\n")
    }

    pub fn end(&mut self, name: &str) -> io::Result<()> {
        writeln!(self.out, "</{name}>")
    }

    /// Begins a group that is clipped to `rect`, to be ended as `g`. `more` are attributes of the group.
    pub fn begin_clipped(&mut self, rect: &[Attribute<'_>], more: &[Attribute<'_>]) -> io::Result<()> {
        self.clips += 1;
        let id = format!("clip{}", self.clips);
        self.begin("clipPath", &[("id", &id)])?;
        self.empty("rect", rect, "")?;
        self.end("clipPath")?;
        let clip: [Attribute<'_>; 1] = [("clip-path", &format!("url(#{id})"))];
        self.begin("g", &[&clip[..], more].concat())
    }

    /// Writes a picture into `rect`; if it is `sharp`, its pixels stay squares when magnified.
    pub fn picture(&mut self, rect: &[Attribute<'_>], picture: &Bitmap<'_>, sharp: bool) -> io::Result<()> {
        let mut png = Vec::new();
        picture.encode_png(&mut png)?;
        let rendering = if sharp { "image-rendering:pixelated" } else { "image-rendering:auto" };
        let url = format!("data:image/png;base64,{}", Base64Display::new(&png, &STANDARD));
        // `xlink:href` is understood by all current readers.
        let more: [Attribute<'_>; 3] = [("preserveAspectRatio", &"none"), ("style", &rendering), ("xlink:href", &url)];
        self.empty("image", &[rect, &more].concat(), "")
    }

    pub fn raw(&mut self, svg: impl Display) -> io::Result<()> {
        writeln!(self.out, "{svg}")
    }

    /// Writes the beginning of a tag. `style` is more attributes, in SVG's form.
    fn tag(&mut self, name: &str, attributes: &[Attribute<'_>], style: &str) -> io::Result<()> {
        write!(self.out, "<{name}")?;
        for (name, value) in attributes {
            write!(self.out, " {name}=\"{}\"", Escaped(value))?;
        }
        if style.is_empty() { Ok(()) } else { write!(self.out, " {style}") }
    }
}

pub(super) fn rectangle([x, y, width, height]: &[Number; 4]) -> [Attribute<'_>; 4] {
    [("x", x), ("y", y), ("width", width), ("height", height)]
}

/// Number in an SVG: a thousandth of a pixel is precise enough, and keeps files small.
pub(super) struct Number(pub f64);

impl Display for Number {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let text = format!("{:.3}", self.0);
        let short = text.trim_end_matches('0').trim_end_matches('.');
        f.write_str(if short == "-0" { "0" } else { short })
    }
}

/// Points joined by lines, as the data of a path; a `None` is a break.
pub(super) struct PathData<'a>(pub &'a [Option<[f64; 2]>]);

impl Display for PathData<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut command = 'M';
        for point in self.0 {
            command = match point {
                Some([x, y]) => {
                    write!(f, "{command}{} {}", Number(*x), Number(*y))?;
                    'L'
                }
                None => 'M',
            };
        }
        Ok(())
    }
}

/// Text escaped for XML and HTML. Characters that XML 1.0 does not allow are replaced by U+FFFD.
pub struct Escaped<T>(pub T);

impl<T: Display> Display for Escaped<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.to_string().chars().try_for_each(|c| match c {
            '&' => f.write_str("&amp;"),
            '<' => f.write_str("&lt;"),
            '>' => f.write_str("&gt;"),
            '"' => f.write_str("&quot;"),
            '\u{fffe}' | '\u{ffff}' => f.write_char('\u{fffd}'),
            c if c.is_control() && !matches!(c, '\t' | '\n' | '\r') => f.write_char('\u{fffd}'),
            c => f.write_char(c),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_text_is_escaped() {
        let cases = [(1.0, "1"), (-0.00001, "0"), (2.5, "2.5"), (100.0, "100"), (1.0 / 3.0, "0.333")];
        for (number, text) in cases {
            assert_eq!(Number(number).to_string(), text);
        }
        let points = [Some([0.0, 1.0]), None, Some([2.0, 3.0]), Some([4.0, 5.25])];
        assert_eq!(PathData(&points).to_string(), "M0 1M2 3L4 5.25");
        assert_eq!(Escaped("a<b & \"c\"\u{1}").to_string(), "a&lt;b &amp; &quot;c&quot;\u{fffd}");
    }
}
