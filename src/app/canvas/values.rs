//! Values drawn into large pixels, and the grid between pixels.

use super::number;
use super::{Picture, RectTransform};
use crate::plane::display::Display;
use egui::{Align2, Color32, FontId, Painter, Rect, Stroke, pos2};

/// Minimum size of a pixel into which its value is drawn, in points.
pub const VALUE_MIN_POINTS: f32 = 36.0;

/// Minimum size of pixels between which the grid is drawn, in points.
pub const GRID_MIN_POINTS: f32 = 8.0;

/// Draws the value of every visible pixel into it, in the file's unit when `full_scale` is not 1. Draws nothing while
/// pixels are too small.
pub fn draw_values(
    painter: &Painter,
    picture: &Picture,
    display: &Display,
    ui_from_image: RectTransform,
    visible_image: Rect,
    full_scale: f32,
) {
    let ui_from_picture = picture.ui_from_picture(ui_from_image);
    let pixel_points = ui_from_picture.scale();
    if pixel_points < VALUE_MIN_POINTS {
        return;
    }
    let region = picture.region(visible_image);
    // Five characters fit across a pixel.
    let font = FontId::monospace((pixel_points * 0.21).clamp(7.0, 15.0));
    let digits = if pixel_points > 60.0 { 4 } else { 3 };
    let colours = display.colours();
    for v in region.v {
        for u in region.u.clone() {
            let value = picture.plane.at(u, v);
            let centre = ui_from_picture.pos(pos2(u as f32, v as f32));
            painter.text(
                centre,
                Align2::CENTER_CENTER,
                number(value * full_scale, digits),
                font.clone(),
                readable_on(colours.colour(value)),
            );
        }
    }
}

/// Black or white, whichever reads better on `colour`; slightly transparent, so that the numbers do not dominate.
pub fn readable_on(colour: [u8; 3]) -> Color32 {
    let [r, g, b] = colour.map(f32::from);
    let luma = 0.2126 * r + 0.7152 * g + 0.0722 * b;
    if luma > 120.0 { Color32::from_black_alpha(215) } else { Color32::from_white_alpha(215) }
}

/// Draws lines between visible pixels. Draws nothing while pixels are too small.
pub fn draw_grid(painter: &Painter, picture: &Picture, ui_from_image: RectTransform, visible_image: Rect) {
    let ui_from_picture = picture.ui_from_picture(ui_from_image);
    let pixel_points = ui_from_picture.scale();
    if pixel_points < GRID_MIN_POINTS {
        return;
    }
    // Fades in, so that it does not appear suddenly.
    let strength = ((pixel_points - GRID_MIN_POINTS) / 16.0).clamp(0.0, 1.0);
    let stroke = Stroke::new(1.0, Color32::from_gray(128).gamma_multiply(0.35 * strength));
    let region = picture.region(visible_image);
    let corner = |u: usize, v: usize| ui_from_picture.pos(pos2(u as f32 - 0.5, v as f32 - 0.5));
    let rect = Rect::from_min_max(corner(region.u.start, region.v.start), corner(region.u.end, region.v.end));
    for u in region.u.start..=region.u.end {
        painter.vline(corner(u, 0).x, rect.y_range(), stroke);
    }
    for v in region.v.start..=region.v.end {
        painter.hline(rect.x_range(), corner(0, v).y, stroke);
    }
}
