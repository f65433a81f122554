//! Pictures with marks on them, parts of several figures.

use burstscope_core::export::sheet::{Area, Colour, Sheet};
use burstscope_core::plane::{Plane, display::Display};
use burstscope_core::{detector::Feature, export::FigureStroke};

pub(super) const RIGHT: Colour = [0x4f, 0xa3, 0xff];
pub(super) const WRONG: Colour = [0xff, 0x8c, 0x1a];

#[derive(Debug, Clone, Copy)]
pub(super) struct Panel {
    pub area: Area,
    /// Sheet pixels for each image pixel.
    pub scale: f64,
}

impl Panel {
    /// Draws `plane` with its left top at `at`, `width` wide, under a line of text.
    pub fn draw(sheet: &mut Sheet, at: (f64, f64), width: f64, plane: &Plane, display: &Display, title: &str) -> Self {
        let scale = width / plane.width() as f64;
        let area = Area { x: at.0, y: at.1, width, height: scale * plane.height() as f64 };
        sheet.heading((at.0, at.1 - 6.0), 12.0, title);
        sheet.picture(area, plane, display);
        Self { area, scale }
    }

    /// The position on the sheet of the image pixel (u, v), of its middle.
    pub fn at(&self, [u, v]: [f64; 2]) -> (f64, f64) {
        (self.area.x + (u + 0.5) * self.scale, self.area.y + (v + 0.5) * self.scale)
    }

    pub fn shows(&self, pos_image: [f64; 2]) -> bool {
        let (x, y) = self.at(pos_image);
        x >= self.area.x && x <= self.area.right() && y >= self.area.y && y <= self.area.bottom()
    }

    pub fn circle(&self, sheet: &mut Sheet, pos_image: [f64; 2], radius_px: f64, stroke: FigureStroke) {
        if self.shows(pos_image) {
            sheet.circle(self.at(pos_image), radius_px * self.scale, stroke);
        }
    }

    /// Draws a feature: the rim of the disc with the strongest response at its scale.
    pub fn feature(&self, sheet: &mut Sheet, feature: &Feature, colour: Colour) {
        let pos_image = [f64::from(feature.u), f64::from(feature.v)];
        self.circle(sheet, pos_image, 1.5 * f64::from(feature.sigma), FigureStroke::new(colour, 1.6));
    }
}
