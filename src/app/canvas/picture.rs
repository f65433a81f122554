//! A plane with its place in the image.

use super::RectTransform;
use crate::app::gpu::PictureId;
use crate::plane::Plane;
use crate::plane::statistics::Region;
use egui::{Pos2, Rect, pos2};
use std::sync::Arc;

/// Plane with its place in the input image. Cheap to clone; the pixels are shared.
///
/// Pixel (i, j) of the plane is centred at (i·s, j·s) of the input image, where s is `image_from_picture_scale`; with
/// s = 2^octave this is where the detector's octaves lie.
#[derive(Debug, Clone)]
pub struct Picture {
    /// Id of the content: new values need a new id, unchanged values should keep theirs.
    pub id: PictureId,
    pub plane: Arc<Plane>,
    /// The values that are drawn: the same, or smoothed ones of the same size.
    pub drawn: Arc<Plane>,
    /// Image pixels from one pixel of the plane to the next: 1 for frames and motion-stack images, 2^octave for DoG
    /// responses.
    pub image_from_picture_scale: f32,
    /// (columns, rows) of the input image, which a fitted view shows whole.
    pub image_size: (usize, usize),
    /// Description in a few words, for example "Frame 3".
    pub label: String,
}

impl Picture {
    /// Creates a picture with a fresh id whose pixels are the input image's.
    pub fn new(plane: Arc<Plane>, label: impl Into<String>) -> Self {
        let image_size = plane.size();
        let (drawn, label) = (plane.clone(), label.into());
        Self { id: PictureId::fresh(), plane, drawn, image_from_picture_scale: 1.0, image_size, label }
    }

    /// Creates a picture with a fresh id on the pixels of `octave` (−1: the doubled image) of an input image of
    /// `image_size`.
    pub fn of_octave(plane: Arc<Plane>, octave: i32, image_size: (usize, usize), label: impl Into<String>) -> Self {
        let image_from_picture_scale = 2f32.powi(octave);
        let (drawn, label) = (plane.clone(), label.into());
        Self { id: PictureId::fresh(), plane, drawn, image_from_picture_scale, image_size, label }
    }

    /// Part of the image that the picture's pixels cover, in image pixels.
    pub fn rect_image(&self) -> Rect {
        let s = self.image_from_picture_scale;
        let (width, height) = self.plane.size();
        Rect::from_min_max(pos2(-0.5 * s, -0.5 * s), pos2((width as f32 - 0.5) * s, (height as f32 - 0.5) * s))
    }

    /// Transform from pixels of the plane to points of the window.
    pub fn ui_from_picture(&self, ui_from_image: RectTransform) -> RectTransform {
        ui_from_image.from_scaled(self.image_from_picture_scale)
    }

    /// Pixel (column, row) of the plane under `pos_image`, if there is one.
    pub fn pixel_at(&self, pos_image: Pos2) -> Option<(usize, usize)> {
        let index = |x: f32, size: usize| {
            let i = (x / self.image_from_picture_scale + 0.5).floor();
            (i >= 0.0 && i < size as f32).then_some(i as usize)
        };
        Some((index(pos_image.x, self.plane.width())?, index(pos_image.y, self.plane.height())?))
    }

    /// Pixels of the plane that lie at least partly in `rect_image`; may be empty.
    pub fn region(&self, rect_image: Rect) -> Region {
        let s = self.image_from_picture_scale;
        let range = |low: f32, high: f32| {
            let start = (low / s + 0.5).floor().max(0.0) as usize;
            start..((high / s + 0.5).ceil().max(0.0) as usize).max(start)
        };
        let region = Region {
            columns: range(rect_image.min.x, rect_image.max.x),
            rows: range(rect_image.min.y, rect_image.max.y),
        };
        region.within(&self.plane)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_are_centred_on_whole_numbers_times_the_scale() {
        let plane = Arc::new(Plane::zeros(10, 5));
        let picture = Picture::new(plane.clone(), "frame");
        assert_eq!(picture.pixel_at(pos2(-0.49, 4.49)), Some((0, 4)));
        assert_eq!(picture.pixel_at(pos2(-0.51, 0.0)), None);
        assert_eq!(picture.pixel_at(pos2(9.51, 0.0)), None);
        let octave = Picture::of_octave(plane.clone(), 2, (40, 20), "DoG");
        assert_eq!(octave.pixel_at(pos2(4.0, 8.0)), Some((1, 2)));
        assert_eq!(octave.pixel_at(pos2(5.9, 6.1)), Some((1, 2)));
        assert_eq!(octave.rect_image().min, pos2(-2.0, -2.0));
        let doubled = Picture::of_octave(plane, -1, (5, 3), "DoG");
        assert_eq!(doubled.pixel_at(pos2(0.5, 0.0)), Some((1, 0)));
    }

    #[test]
    fn a_region_holds_what_is_seen() {
        let picture = Picture::new(Arc::new(Plane::zeros(100, 50)), "frame");
        let region = picture.region(Rect::from_min_max(pos2(9.6, -30.0), pos2(20.4, 10.0)));
        assert_eq!((region.columns, region.rows), (10..21, 0..11));
        assert!(picture.region(Rect::from_min_max(pos2(500.0, 0.0), pos2(600.0, 10.0))).is_empty());
        assert!(picture.region(Rect::from_min_max(pos2(-50.0, 0.0), pos2(-20.0, 10.0))).is_empty());
    }
}
