//! Pan and zoom of a canvas, and the transforms between coordinate systems that follow from them.

use egui::{Pos2, Rect, Vec2, pos2};
use serde::{Deserialize, Serialize};

pub const MAX_POINTS_PER_PIXEL: f32 = 128.0;

const FIT_MARGIN_POINTS: f32 = 6.0;

#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Zoom {
    #[default]
    Fit,
    /// A part of the image of this size (columns, rows) around the centre fits; follows the size of the canvas.
    Region([f32; 2]),
    PointsPerPixel(f32),
}

/// Pan and zoom in pixels of the input image alone, so that all kinds of pictures and several canvases share a view.
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct View {
    pub zoom: Zoom,
    /// (u, v) at the centre of the canvas, image pixels; the image's centre while it is fitted.
    pub centre_image: [f32; 2],
    /// Zoom of [`Zoom::Fit`] on the last canvas, points per image pixel; 0 before the first frame.
    #[serde(skip)]
    fit_points_per_pixel: f32,
    #[serde(skip)]
    region_points_per_pixel: f32,
    /// Size of the last canvas, points.
    #[serde(skip)]
    size_points: Vec2,
}

/// Equal views show the same part of the picture; the size last drawn is not compared.
impl PartialEq for View {
    fn eq(&self, other: &Self) -> bool {
        (self.zoom, self.centre_image) == (other.zoom, other.centre_image)
    }
}

impl View {
    pub fn new(zoom: Zoom, centre_image: [f32; 2]) -> Self {
        Self { zoom, centre_image, ..Self::default() }
    }

    pub fn fit() -> Self {
        Self::default()
    }

    pub fn region(min_image: [f32; 2], max_image: [f32; 2]) -> Self {
        let rect = Rect::from_min_max(min_image.into(), max_image.into());
        Self::new(Zoom::Region(rect.size().into()), rect.center().into())
    }

    pub fn set_fit(&mut self) {
        self.zoom = Zoom::Fit;
    }

    pub fn is_fit(&self) -> bool {
        self.zoom == Zoom::Fit
    }

    /// Shows one image pixel for each pixel of the screen, about the same centre. `pixels_per_point` is the screen's.
    pub fn set_one_to_one(&mut self, pixels_per_point: f32) {
        self.zoom = Zoom::PointsPerPixel(1.0 / pixels_per_point);
    }

    pub fn zoom_by(&mut self, factor: f32) {
        self.zoom = Zoom::PointsPerPixel(self.limited(self.points_per_pixel() * factor));
    }

    pub fn look_at(&mut self, pos_image: Pos2, min_points_per_pixel: f32) {
        self.zoom = Zoom::PointsPerPixel(self.limited(self.points_per_pixel().max(min_points_per_pixel)));
        self.centre_image = pos_image.into();
    }

    pub fn points_per_pixel(&self) -> f32 {
        match self.zoom {
            Zoom::Fit if self.fit_points_per_pixel > 0.0 => self.fit_points_per_pixel,
            Zoom::Region(_) if self.region_points_per_pixel > 0.0 => self.region_points_per_pixel,
            Zoom::Fit | Zoom::Region(_) => 1.0,
            Zoom::PointsPerPixel(zoom) => zoom,
        }
    }

    /// Part of the image plane that the last canvas showed, image pixels.
    pub fn visible_image(&self) -> Rect {
        Rect::from_center_size(self.centre_image.into(), self.size_points / self.points_per_pixel())
    }

    /// Zooms by `factor` so that the place under `pointer_ui` stays under it. `rect_ui` is the canvas.
    pub fn zoom_at(&mut self, pointer_ui: Pos2, factor: f32, rect_ui: Rect) {
        let before = self.points_per_pixel();
        let after = self.limited(before * factor);
        if !(factor.is_finite() && factor > 0.0) || after == before {
            return;
        }
        let from_centre = pointer_ui - rect_ui.center();
        self.move_centre(from_centre / before - from_centre / after);
        self.zoom = Zoom::PointsPerPixel(after);
    }

    /// Moves the image with the pointer, by `delta_ui` points. A fitted image is no longer fitted then.
    pub fn pan(&mut self, delta_ui: Vec2) {
        if delta_ui != Vec2::ZERO {
            let zoom = self.points_per_pixel();
            self.zoom = Zoom::PointsPerPixel(zoom);
            self.move_centre(-delta_ui / zoom);
        }
    }

    fn move_centre(&mut self, delta_image: Vec2) {
        self.centre_image = [self.centre_image[0] + delta_image.x, self.centre_image[1] + delta_image.y];
    }

    /// Limits the zoom to half the fitted size (or 0.25, so that 1:1 is in reach anywhere) … [`MAX_POINTS_PER_PIXEL`].
    fn limited(&self, points_per_pixel: f32) -> f32 {
        // Before the first frame the fitted size is unknown.
        let fit = if self.fit_points_per_pixel > 0.0 { self.fit_points_per_pixel } else { 1.0 };
        points_per_pixel.clamp((0.5 * fit).min(0.25), MAX_POINTS_PER_PIXEL.max(fit))
    }

    pub fn is_drawn_as(&self, other: &Self) -> bool {
        let drawn = |view: &Self| (view.fit_points_per_pixel, view.region_points_per_pixel, view.size_points);
        self == other && drawn(self) == drawn(other)
    }

    /// Keeps the picture's place and size on the screen when its canvas changes from `before` to `after`, in points.
    pub fn keep_place(&mut self, before: Rect, after: Rect) {
        let zoom = self.points_per_pixel();
        self.zoom = Zoom::PointsPerPixel(zoom);
        self.move_centre((after.center() - before.center()) / zoom);
    }

    /// Takes a move from `before` to `after`, also where something else has moved the view since `before`.
    pub fn take(&mut self, before: &Self, after: Self) {
        if self == before {
            *self = after;
            return;
        }
        self.follow(before, &after);
        *self = Self { zoom: self.zoom, centre_image: self.centre_image, ..after };
    }

    /// The distance between the two places stays, until both are fitted.
    pub fn follow(&mut self, before: &Self, after: &Self) {
        if before == after {
            return;
        }
        if after.is_fit() {
            return self.set_fit();
        }
        self.move_centre(Pos2::from(after.centre_image) - Pos2::from(before.centre_image));
        self.zoom = after.zoom;
    }

    /// Fits the view to this frame's canvas and image (columns, rows), keeps its centre inside; gives `ui_from_image`.
    pub fn settle(&mut self, rect_ui: Rect, image_size: (usize, usize), pixels_per_point: f32) -> RectTransform {
        let (width, height) = (image_size.0.max(1) as f32, image_size.1.max(1) as f32);
        let room = (rect_ui.size() - Vec2::splat(2.0 * FIT_MARGIN_POINTS)).max(Vec2::splat(1.0));
        self.size_points = rect_ui.size();
        self.fit_points_per_pixel = (room.x / width).min(room.y / height).min(MAX_POINTS_PER_PIXEL);
        let last = pos2(width - 1.0, height - 1.0);
        // Values from a session file may be anything.
        let finite = |zoom: f32| if zoom.is_finite() { zoom } else { self.fit_points_per_pixel };
        match self.zoom {
            Zoom::Fit => self.centre_image = [0.5 * last.x, 0.5 * last.y],
            Zoom::PointsPerPixel(zoom) => self.zoom = Zoom::PointsPerPixel(self.limited(finite(zoom))),
            Zoom::Region([columns, rows]) => {
                let fits = (room.x / columns.max(1.0)).min(room.y / rows.max(1.0));
                self.region_points_per_pixel = self.limited(finite(fits));
            }
        }
        // The centre of the canvas stays on the image, so that the picture cannot be lost.
        for (x, end) in self.centre_image.iter_mut().zip([last.x, last.y]) {
            *x = if x.is_finite() { x.clamp(-0.5, end + 0.5) } else { 0.5 * end };
        }
        let transform = RectTransform::new(self.centre_image.into(), rect_ui.center(), self.points_per_pixel());
        snapped(transform, pixels_per_point)
    }
}

/// Moves the picture by less than half a screen pixel, so that its pixels' borders fall on the screen's.
fn snapped(transform: RectTransform, pixels_per_point: f32) -> RectTransform {
    let px_per_pixel = transform.scale() * pixels_per_point;
    if px_per_pixel < 0.999 || (px_per_pixel - px_per_pixel.round()).abs() > 1e-3 {
        return transform;
    }
    let centre = transform.anchor_from;
    let border_ui = transform.pos(pos2(centre.x.floor() - 0.5, centre.y.floor() - 0.5));
    // A border in the middle of a screen pixel would flicker between its neighbours.
    let on_screen = |x: f32| (x * pixels_per_point).round() / pixels_per_point;
    let moved = pos2(on_screen(border_ui.x), on_screen(border_ui.y)) - border_ui;
    RectTransform { anchor_to: transform.anchor_to + moved, ..transform }
}

/// A uniform scale and shift, as `ui_from_image` or its inverse: names say "to from". Stored as a pair of corresponding
/// points, not as an offset, which would lose its fraction at 128-fold zoom in the corner of a huge picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RectTransform {
    pub anchor_from: Pos2,
    pub anchor_to: Pos2,
    scale: f32,
}

impl RectTransform {
    pub fn new(anchor_from: Pos2, anchor_to: Pos2, scale: f32) -> Self {
        debug_assert!(scale.is_finite() && scale > 0.0, "a scale is positive, not {scale}");
        Self { anchor_from, anchor_to, scale }
    }

    pub fn scale(&self) -> f32 {
        self.scale
    }

    pub fn pos(&self, from: Pos2) -> Pos2 {
        self.anchor_to + self.scale * (from - self.anchor_from)
    }

    pub fn rect(&self, from: Rect) -> Rect {
        Rect::from_min_max(self.pos(from.min), self.pos(from.max))
    }

    #[must_use]
    pub fn inverse(&self) -> Self {
        Self { anchor_from: self.anchor_to, anchor_to: self.anchor_from, scale: 1.0 / self.scale }
    }
}
