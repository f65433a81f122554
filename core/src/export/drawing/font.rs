//! Letters of drawings that are no SVG: their widths and outlines.

use super::shape::{Anchor, Face};
use epaint_default_fonts::{HACK_REGULAR, UBUNTU_LIGHT};
use skrifa::instance::{LocationRef, Size};
use skrifa::outline::{DrawSettings, OutlinePen};
use skrifa::{FontRef, GlyphId, MetadataProvider};
use vello_cpu::kurbo::BezPath;

/// Width of the stroke that makes letters bold, as a part of their height.
pub(super) const BOLD: f32 = 0.05;

/// The fonts of the window. Bold letters are drawn with an outline.
pub(super) fn font_of(face: Face) -> &'static [u8] {
    if face == Face::Mono { HACK_REGULAR } else { UBUNTU_LIGHT }
}

/// Distance from the begin of a text of `size` to its position.
pub(super) fn overhang(face: Face, size: f32, anchor: Anchor, text: &str) -> f32 {
    let part = match anchor {
        Anchor::Start => return 0.0,
        Anchor::Middle => 0.5,
        Anchor::End => 1.0,
    };
    part * glyphs(face, size, text).map(|(_, advance)| advance).sum::<f32>()
}

fn glyphs(face: Face, size: f32, text: &str) -> impl Iterator<Item = (GlyphId, f32)> {
    let font = FontRef::new(font_of(face)).expect("the fonts of the program are sound");
    let (letters, widths) = (font.charmap(), font.glyph_metrics(Size::new(size), LocationRef::default()));
    text.chars().map(move |letter| {
        let glyph = letters.map(letter).unwrap_or_default();
        (glyph, widths.advance_width(glyph).unwrap_or(0.0))
    })
}

/// The outline of a text that begins at (0, 0) on its baseline.
pub(super) fn outline(face: Face, size: f32, text: &str) -> BezPath {
    let font = FontRef::new(font_of(face)).expect("the fonts of the program are sound");
    let outlines = font.outline_glyphs();
    let mut pen = Pen { path: BezPath::new(), x: 0.0 };
    for (glyph, advance) in glyphs(face, size, text) {
        let settings = DrawSettings::unhinted(Size::new(size), LocationRef::default());
        // A letter without an outline is a space.
        let _ = outlines.get(glyph).map(|outline| outline.draw(settings, &mut pen));
        pen.x += advance;
    }
    pen.path
}

struct Pen {
    path: BezPath,
    x: f32,
}

impl Pen {
    /// Fonts have their y axis upwards.
    fn at(&self, x: f32, y: f32) -> (f64, f64) {
        (f64::from(self.x + x), f64::from(-y))
    }
}

impl OutlinePen for Pen {
    fn move_to(&mut self, x: f32, y: f32) {
        self.path.move_to(self.at(x, y));
    }

    fn line_to(&mut self, x: f32, y: f32) {
        self.path.line_to(self.at(x, y));
    }

    fn quad_to(&mut self, cx: f32, cy: f32, x: f32, y: f32) {
        self.path.quad_to(self.at(cx, cy), self.at(x, y));
    }

    fn curve_to(&mut self, ax: f32, ay: f32, bx: f32, by: f32, x: f32, y: f32) {
        self.path.curve_to(self.at(ax, ay), self.at(bx, by), self.at(x, y));
    }

    fn close(&mut self) {
        self.path.close_path();
    }
}
