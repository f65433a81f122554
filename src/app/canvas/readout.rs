//! Values of pixels as text: the one under the pointer, for the status bar, and those drawn into large pixels.

use super::{Canvas, CanvasOutput, Picture, number};
use crate::app::view::{fixed, motion_text};
use crate::detector::{Motion, Slope};
use egui::{Align2, Color32, FontId, Pos2, pos2};

#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Quantity {
    #[default]
    Value,
    /// A standard deviation of the noise, as a fraction of full scale.
    Sigma,
    FramesShare,
    /// Response of the winning slope at the place, over its noise.
    Slope {
        slope: Slope,
        /// Relative lead over all other slopes, 0 … 1; 0 where no response reaches the gate.
        confidence: f32,
    },
    /// Motion of the place, from the field; `None` where it is unknown.
    Field(Option<Motion>),
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Readout {
    pub u: f32,
    pub v: f32,
    /// Column and row of the picture's own pixel, which differ from (u, v) in other octaves.
    pub pixel: (usize, usize),
    /// The value as a fraction of full scale.
    pub value: f32,
    /// Value in the file that became 1.0: 255 for 8 bit, 65535 for 16 bit, 1 for float files.
    pub full_scale: f32,
    pub image_from_picture_scale: f32,
    pub quantity: Quantity,
    /// Standard deviation by which the picture is smoothed around the value, input pixels; the value itself is not.
    pub smoothing_px: f32,
    /// Whether a mask hides the pixel, whose value is filled in.
    pub is_masked: bool,
}

/// Without interpolation; `None` outside the picture. `full_scale` is the burst's.
pub fn readout(picture: &Picture, pos_image: Pos2, full_scale: f32) -> Option<Readout> {
    let pixel = picture.pixel_at(pos_image)?;
    let (Pos2 { x: u, y: v }, quantity, smoothing_px) = (pos_image, Quantity::Value, 0.0);
    let (value, is_masked) = (picture.plane.at(pixel.0, pixel.1), picture.plane.is_hidden_at(pixel.0, pixel.1));
    let image_from_picture_scale = picture.image_from_picture_scale;
    Some(Readout { u, v, pixel, value, full_scale, image_from_picture_scale, quantity, smoothing_px, is_masked })
}

impl Readout {
    pub fn short_text(&self) -> String {
        match self.quantity {
            Quantity::Value => number(self.value, 4),
            Quantity::Sigma => format!("σ {}", number(self.value, 3)),
            Quantity::FramesShare => format!("{} % of the frames", number(100.0 * self.value, 3)),
            Quantity::Field(None) => "motion unknown".to_owned(),
            Quantity::Field(Some(motion)) => motion_text(motion.slope, motion.ellipse().0[0], 2),
            // No slope wins where no response reaches the gate.
            Quantity::Slope { confidence, .. } if confidence <= 0.0 => {
                format!("below the gate ({} σ)", number(self.value, 2))
            }
            Quantity::Slope { slope: Slope { u, v }, confidence } => {
                let ([u, v, snr], sure) = ([u, v, self.value].map(|x| number(x, 3)), number(100.0 * confidence, 2));
                format!("({u}, {v}) px/frame, {snr} σ, sure {sure} %")
            }
        }
    }
}

impl std::fmt::Display for Readout {
    /// For example `u 12.3  v 45.6    0.01235 = 809.4 of 65535`.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "u {}  v {}", fixed(self.u, 1), fixed(self.v, 1))?;
        // In another octave the pixels of the picture are not those of the image.
        if self.image_from_picture_scale != 1.0 {
            write!(f, "  (pixel {}, {})", self.pixel.0, self.pixel.1)?;
        }
        write!(f, "    {}", self.short_text())?;
        if self.quantity == Quantity::Sigma && self.full_scale == 1.0 {
            write!(f, " of full scale")?;
        }
        if self.full_scale != 1.0 && matches!(self.quantity, Quantity::Value | Quantity::Sigma) {
            write!(f, " = {} of {}", number(self.value * self.full_scale, 4), number(self.full_scale, 6))?;
        }
        if self.is_masked {
            write!(f, "  (masked: filled in from around)")?;
        }
        if self.smoothing_px > 0.0 {
            write!(f, "  (display smoothed, σ {} px)", number(self.smoothing_px, 2))?;
        }
        Ok(())
    }
}

pub const VALUE_MIN_POINTS: f32 = 36.0;

impl Canvas<'_> {
    /// In the file's unit when the full scale is not 1. Draws nothing while pixels are too small.
    pub(super) fn draw_values(&self, picture: &Picture, output: &CanvasOutput) {
        let ui_from_picture = picture.ui_from_picture(output.ui_from_image);
        let pixel_points = ui_from_picture.scale();
        if pixel_points < VALUE_MIN_POINTS {
            return;
        }
        let region = picture.region(output.visible_image);
        // Five characters fit across a pixel.
        let font = FontId::monospace((pixel_points * 0.21).clamp(7.0, 15.0));
        let digits = if pixel_points > 60.0 { 4 } else { 3 };
        let colours = self.display.colours();
        for v in region.rows {
            for u in region.columns.clone().filter(|u| !picture.plane.is_hidden_at(*u, v)) {
                let value = picture.plane.at(u, v);
                let centre = ui_from_picture.pos(pos2(u as f32, v as f32));
                let (text, colour) = (number(value * self.full_scale, digits), readable_on(colours.colour(value)));
                output.painter.text(centre, Align2::CENTER_CENTER, text, font.clone(), colour);
            }
        }
    }
}

pub fn readable_on(colour: [u8; 3]) -> Color32 {
    let [r, g, b] = colour.map(f32::from);
    let luma = 0.2126 * r + 0.7152 * g + 0.0722 * b;
    if luma > 120.0 { Color32::from_black_alpha(215) } else { Color32::from_white_alpha(215) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plane::{Mask, Plane};
    use std::sync::Arc;

    #[test]
    fn what_is_hidden_is_said_to_be_filled_in_and_beyond_the_picture_is_nothing() {
        let plane = Plane::from_fn(4, 4, |u, v| (u + 4 * v) as f32 / 255.0);
        let mask = Mask::new(Plane::from_fn(4, 4, |u, _| f32::from(u != 1)));
        let masked = Picture::new(Arc::new(plane.masked(mask)), "frame");
        let said = |u: f32| readout(&masked, pos2(u, 1.9), 255.0).map(|readout| readout.to_string());
        assert!(said(1.2).is_some_and(|text| text.ends_with("(masked: filled in from around)")));
        assert_eq!(said(2.2).as_deref(), Some("u 2.2  v 1.9    0.03922 = 10 of 255"));
        assert_eq!(said(4.0), None);
    }
}
