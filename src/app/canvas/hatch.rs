//! Hatching over the parts of a picture that a mask hides, whose values are filled in from around them.

use super::{Picture, RectTransform};
use egui::{Color32, Painter, Rect, Stroke, pos2};

/// Distance between two lines of the hatching, points.
const BETWEEN: f32 = 9.0;
/// Distance of the places along a line at which the mask is looked up, points.
const STEP: f32 = 1.5;

/// Draws falling lines over the hidden pixels of `picture` that lie in `rect`. They keep their places in the image.
pub(super) fn draw(painter: &Painter, picture: &Picture, ui_from_image: RectTransform, rect: Rect) {
    if picture.plane.mask().is_none() {
        return;
    }
    let of_picture = ui_from_image.rect(picture.rect_image());
    let seen = rect.intersect(of_picture);
    if !seen.is_positive() {
        return;
    }
    let image_from_ui = ui_from_image.inverse();
    let hides = |pos_ui| {
        let pixel = picture.pixel_at(image_from_ui.pos(pos_ui));
        pixel.is_some_and(|(u, v)| picture.plane.is_hidden_at(u, v))
    };
    // A line holds the places whose x + y is the same.
    let origin = of_picture.min.x + of_picture.min.y;
    let first = ((seen.min.x + seen.min.y - origin) / BETWEEN).ceil() as i32;
    let last = ((seen.max.x + seen.max.y - origin) / BETWEEN).floor() as i32;
    for line in first..=last {
        let sum = origin + line as f32 * BETWEEN;
        let (from, to) = (seen.min.x.max(sum - seen.max.y), seen.max.x.min(sum - seen.min.y));
        let mut begun = None;
        for k in 0..=((to - from) / STEP) as usize + 1 {
            let x = from + k as f32 * STEP;
            let pos = pos2(x, sum - x);
            let is_hidden = x <= to && hides(pos);
            match begun {
                None if is_hidden => begun = Some(pos),
                Some(start) if !is_hidden => {
                    for (width, colour) in [(2.5, Color32::from_black_alpha(110)), (1.0, Color32::from_gray(190))] {
                        painter.line_segment([start, pos], Stroke::new(width, colour));
                    }
                    begun = None;
                }
                _ => {}
            }
        }
    }
}
