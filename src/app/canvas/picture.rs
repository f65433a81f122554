//! A plane with its place in the image, and the hatching over what a mask hides of it.

use super::RectTransform;
use crate::app::gpu::PictureId;
use crate::plane::Plane;
use crate::plane::statistics::Region;
use egui::{Pos2, Rect, Vec2, pos2, vec2};
use std::sync::Arc;

/// Distance between two lines of the hatching, points.
const BETWEEN: f32 = 9.0;
/// Distance of the places along a line at which the mask is looked up, points.
const STEP: f32 = 1.5;

/// Pixel (i, j) of the plane is centred at ((i + u)·s, (j + v)·s) of the input image, where s is
/// `image_from_picture_scale`, and (u, v) the `first` pixel.
#[derive(Debug, Clone)]
pub struct Picture {
    /// Id of the content: new values need a new id, unchanged values should keep theirs.
    pub id: PictureId,
    pub plane: Arc<Plane>,
    /// Values as drawn: `plane`, or a smoothed plane of the same size.
    pub drawn: Arc<Plane>,
    /// 1 for frames and motion-stack images, 2^octave for DoG responses.
    pub image_from_picture_scale: f32,
    /// (0, 0) but for a part of a picture.
    pub first: Vec2,
    /// (columns, rows) of the input image, which a fitted view shows whole.
    pub image_size: (usize, usize),
    pub label: String,
}

impl Picture {
    pub fn new(plane: Arc<Plane>, label: impl Into<String>) -> Self {
        let image_size = plane.size();
        Self::of_octave(plane, 0, image_size, label)
    }

    /// On the pixels of `octave` (−1: the doubled image) of an input image of `image_size`.
    pub fn of_octave(plane: Arc<Plane>, octave: i32, image_size: (usize, usize), label: impl Into<String>) -> Self {
        let image_from_picture_scale = 2f32.powi(octave);
        let (drawn, label) = (plane.clone(), label.into());
        Self { id: PictureId::fresh(), plane, drawn, image_from_picture_scale, first: Vec2::ZERO, image_size, label }
    }

    pub fn rect_image(&self) -> Rect {
        let s = self.image_from_picture_scale;
        let (width, height) = self.plane.size();
        Rect::from_min_size(s * (self.first - Vec2::splat(0.5)).to_pos2(), s * vec2(width as f32, height as f32))
    }

    pub fn ui_from_picture(&self, ui_from_image: RectTransform) -> RectTransform {
        let s = self.image_from_picture_scale;
        let RectTransform { anchor_from, anchor_to, .. } = ui_from_image;
        RectTransform::new((anchor_from.to_vec2() / s - self.first).to_pos2(), anchor_to, s * ui_from_image.scale())
    }

    pub fn pixel_at(&self, pos_image: Pos2) -> Option<(usize, usize)> {
        let index = |x: f32, first: f32, size: usize| {
            let i = (x / self.image_from_picture_scale + 0.5).floor() - first;
            (i >= 0.0 && i < size as f32).then_some(i as usize)
        };
        let (width, height) = self.plane.size();
        Some((index(pos_image.x, self.first.x, width)?, index(pos_image.y, self.first.y, height)?))
    }

    /// Pixels of the plane that lie at least partly in `rect_image`; may be empty.
    pub fn region(&self, rect_image: Rect) -> Region {
        let s = self.image_from_picture_scale;
        let range = |low: f32, high: f32, first: f32| {
            let start = ((low / s + 0.5).floor() - first).max(0.0) as usize;
            start..(((high / s + 0.5).ceil() - first).max(0.0) as usize).max(start)
        };
        let region = Region {
            columns: range(rect_image.min.x, rect_image.max.x, self.first.x),
            rows: range(rect_image.min.y, rect_image.max.y, self.first.y),
        };
        region.within(&self.plane)
    }

    /// Rising lines over the hidden pixels that lie in `rect`. They keep their places in the image.
    pub(super) fn hatching(&self, ui_from_image: RectTransform, rect: Rect) -> Vec<[Pos2; 2]> {
        let of_picture = ui_from_image.rect(self.rect_image());
        let seen = rect.intersect(of_picture);
        let mut lines = Vec::new();
        if self.plane.mask().is_none() || !seen.is_positive() {
            return lines;
        }
        let image_from_ui = ui_from_image.inverse();
        let pixel_at = |pos_ui: Pos2| self.pixel_at(image_from_ui.pos(pos_ui));
        let hides = |pos_ui| pixel_at(pos_ui).is_some_and(|(u, v)| self.plane.is_hidden_at(u, v));
        // A line holds the places whose x + y is the same.
        let origin = of_picture.min.x + of_picture.min.y;
        let first = ((seen.min.x + seen.min.y - origin) / BETWEEN).ceil() as i32;
        let last = ((seen.max.x + seen.max.y - origin) / BETWEEN).floor() as i32;
        for line in first..=last {
            let sum = origin + line as f32 * BETWEEN;
            let (from, to) = (seen.min.x.max(sum - seen.max.y), seen.max.x.min(sum - seen.min.y));
            let mut begun = None;
            // The last place lies beyond the end, however this is rounded.
            for k in 0..=((to - from) / STEP) as usize + 2 {
                let x = from + k as f32 * STEP;
                let pos = pos2(x, sum - x);
                let is_hidden = x <= to && hides(pos);
                if is_hidden {
                    begun.get_or_insert(pos);
                } else if let Some(start) = begun.take() {
                    lines.push([start, pos]);
                }
            }
        }
        lines
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plane::Mask;

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
        let part = Picture { first: vec2(3.0, 1.0), ..octave };
        assert_eq!(part.pixel_at(pos2(5.9, 6.1)), None);
        assert_eq!(part.pixel_at(pos2(17.9, 6.1)), Some((1, 1)));
        assert_eq!(part.rect_image(), Rect::from_min_max(pos2(10.0, 2.0), pos2(50.0, 22.0)));
        assert_eq!(part.region(Rect::from_min_max(pos2(0.0, 0.0), pos2(13.0, 11.0))).columns, 0..1);
        assert_eq!(Picture::of_octave(plane, -1, (5, 3), "DoG").pixel_at(pos2(0.5, 0.0)), Some((1, 0)));
    }

    #[test]
    fn a_region_holds_what_is_seen() {
        let picture = Picture::new(Arc::new(Plane::zeros(100, 50)), "frame");
        let region = picture.region(Rect::from_min_max(pos2(9.6, -30.0), pos2(20.4, 10.0)));
        assert_eq!((region.columns, region.rows), (10..21, 0..11));
        assert!(picture.region(Rect::from_min_max(pos2(500.0, 0.0), pos2(600.0, 10.0))).is_empty());
        assert!(picture.region(Rect::from_min_max(pos2(-50.0, 0.0), pos2(-20.0, 10.0))).is_empty());
    }

    #[test]
    fn what_a_mask_hides_is_hatched_from_edge_to_edge() {
        let plane = Plane::zeros(40, 30);
        let mask = Mask::new(Plane::from_fn(40, 30, |u, _| f32::from(u >= 20)));
        let picture = Picture::new(Arc::new(plane.masked(mask)), "frame");
        for scale in [1.5, 9.0, 13.7] {
            let transform = RectTransform::new(Pos2::ZERO, pos2(31.25, 7.5), scale);
            let rect = transform.rect(picture.rect_image());
            let lines = picture.hatching(transform, rect);
            let reach = (0.5 * rect.width() + rect.height()) / BETWEEN;
            assert!((lines.len() as f32 - reach).abs() <= 2.0, "{} lines at {scale}, {reach} fit", lines.len());
            let hidden = rect.with_max_x(rect.center().x).expand(2.0 * STEP);
            assert!(lines.iter().flatten().all(|pos| hidden.contains(*pos)), "{lines:?}");
        }
    }
}
