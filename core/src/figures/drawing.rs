//! Pictures on a figure's sheet, and marks on them.

use crate::detector::Feature;
use crate::export::sheet::{Anchor, Area, Sheet};
use crate::plane::Plane;
use crate::plane::display::Display;
use crate::plane::statistics::{Region, percentiles};

/// Colour of right or found features.
pub(super) const RIGHT: &str = "#4fa3ff";
/// Colour of wrong or false features.
pub(super) const WRONG: &str = "#ff8c1a";

/// Picture on the sheet.
#[derive(Debug, Clone, Copy)]
pub(super) struct Panel {
    /// Area of the picture on the sheet.
    pub area: Area,
    /// Sheet pixels for each image pixel.
    pub scale: f64,
    /// Image pixel at the left top, (u, v).
    origin: [usize; 2],
}

impl Panel {
    /// Draws `plane` with its left top at `at`, `width` wide, under a line of text.
    pub fn draw(sheet: &mut Sheet, at: (f64, f64), width: f64, plane: &Plane, display: &Display, title: &str) -> Self {
        Self::draw_part(sheet, at, width, (plane, [0, 0], plane.size()), display, title)
    }

    /// Draws the part of `plane` that begins at `origin` and has this `size`, cut to the plane.
    pub fn draw_part(
        sheet: &mut Sheet,
        at: (f64, f64),
        width: f64,
        (plane, origin, size): (&Plane, [usize; 2], (usize, usize)),
        display: &Display,
        title: &str,
    ) -> Self {
        let size = (size.0.min(plane.width() - origin[0]), size.1.min(plane.height() - origin[1]));
        let part = Plane::from_fn(size.0, size.1, |u, v| plane.at(origin[0] + u, origin[1] + v));
        let scale = width / size.0 as f64;
        let area = Area { x: at.0, y: at.1, width, height: scale * size.1 as f64 };
        sheet.styled_text((at.0, at.1 - 6.0), 12.0, Anchor::Start, r#"font-weight="bold""#, title);
        sheet.picture(area, &part, display);
        Self { area, scale, origin }
    }

    /// The position on the sheet of the image pixel (u, v), of its middle.
    pub fn at(&self, [u, v]: [f64; 2]) -> (f64, f64) {
        let place = |x: f64, origin: usize| (x + 0.5 - origin as f64) * self.scale;
        (self.area.x + place(u, self.origin[0]), self.area.y + place(v, self.origin[1]))
    }

    /// Whether the image pixel (u, v) is in the picture.
    pub fn shows(&self, pos_image: [f64; 2]) -> bool {
        let (x, y) = self.at(pos_image);
        x >= self.area.x && x <= self.area.right() && y >= self.area.y && y <= self.area.bottom()
    }

    /// Draws a circle around an image pixel; the radius is in image pixels.
    pub fn circle(&self, sheet: &mut Sheet, pos_image: [f64; 2], radius_px: f64, colour: &str, style: &str) {
        if self.shows(pos_image) {
            let style = format!(r#"fill="none" stroke="{colour}" {style}"#);
            sheet.circle(self.at(pos_image), radius_px * self.scale, &style);
        }
    }

    /// Draws a feature: the rim of the disc with the strongest response at its scale.
    pub fn feature(&self, sheet: &mut Sheet, feature: &Feature, colour: &str) {
        let pos_image = [f64::from(feature.u), f64::from(feature.v)];
        self.circle(sheet, pos_image, 1.5 * f64::from(feature.sigma), colour, r#"stroke-width="1.6""#);
    }
}

/// The display range that covers nearly all pixels.
pub(super) fn stretched(plane: &Plane) -> Display {
    match percentiles(plane, &Region::whole(plane), &[0.1, 99.9]).as_deref() {
        Some([black, white]) => Display::default().with_range(*black, *white),
        _ => Display::default(),
    }
}
