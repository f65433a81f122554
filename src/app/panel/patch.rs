//! Patch: the pixels around a feature, with the feature's circle and orientation over them.

use crate::app::canvas::overlay::circle_radius_image;
use crate::detector::Feature;
use crate::plane::Plane;
use crate::plane::display::{Display, to_rgba8};
use crate::plane::sample::sample_patch_turned;
use egui::{Color32, Rect, Sense, Stroke, TextureHandle, TextureOptions, Ui, Vec2, pos2};
use std::sync::Arc;

/// Number of samples on a side of a patch.
const SAMPLES: usize = 72;
/// Half width of a patch, in σ: the reach of the descriptor's 4×4 cells of 3 σ.
const SIGMAS: f32 = 6.0;

/// Last drawn patch, kept as a texture until another one is drawn.
#[derive(Default)]
pub struct PatchTexture(Option<(PatchKey, TextureHandle)>);

#[derive(Clone, Copy, PartialEq)]
struct PatchKey {
    plane: usize,
    centre: (f32, f32),
    half_width_px: f32,
    angle_rad: f32,
    display: Display,
    dark: bool,
}

/// Content of a patch.
pub struct PatchView<'a> {
    /// Name of the patch, for screen readers and tests.
    pub name: &'a str,
    /// Picture that the patch is cut from, on the input image's pixels.
    pub plane: &'a Arc<Plane>,
    /// Feature, at its place in that picture.
    pub feature: Feature,
    /// Whether the patch is rotated so that the feature's orientation points to the right, as its descriptor sees it.
    pub turned: bool,
    /// Range and colours.
    pub display: Display,
}

impl PatchView<'_> {
    /// Half width of the patch, pixels.
    fn half_width_px(&self) -> f32 {
        (SIGMAS * self.feature.sigma).max(4.0)
    }

    /// Draws the patch into a square of `side` points.
    pub fn ui(&self, ui: &mut Ui, texture: &mut PatchTexture, side: f32) -> egui::Response {
        let half_width_px = self.half_width_px();
        let angle_rad = if self.turned { self.feature.orientation } else { 0.0 };
        let key = PatchKey {
            plane: Arc::as_ptr(self.plane) as usize,
            centre: (self.feature.u, self.feature.v),
            half_width_px,
            angle_rad,
            display: self.display,
            dark: ui.visuals().dark_mode,
        };
        if texture.0.as_ref().is_none_or(|(k, _)| *k != key) {
            texture.0 = Some((key, self.load(ui, &key)));
        }
        let (rect, response) = ui.allocate_exact_size(Vec2::splat(side), Sense::hover());
        if let Some((_, texture)) = &texture.0 {
            let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
            ui.painter().image(texture.id(), rect, whole, Color32::WHITE);
        }
        let radius = circle_radius_image(&self.feature) * 0.5 * side / half_width_px;
        let tip = rect.center() + radius * Vec2::angled(self.feature.orientation - angle_rad);
        for (width, colour) in [(3.0, Color32::from_black_alpha(140)), (1.4, Color32::from_rgb(255, 214, 90))] {
            ui.painter().circle_stroke(rect.center(), radius, Stroke::new(width, colour));
            ui.painter().line_segment([rect.center(), tip], Stroke::new(width, colour));
        }
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, self.name));
        let turned = if self.turned { ", turned so that the orientation points to the right" } else { "" };
        response.on_hover_text(format!("{}: {half_width_px:.0} px to each side{turned}", self.name))
    }

    fn load(&self, ui: &Ui, key: &PatchKey) -> TextureHandle {
        let patch = sample_patch_turned(self.plane, key.centre, key.half_width_px, key.angle_rad, SAMPLES);
        let mut rgba = to_rgba8(&patch, &key.display);
        let beside = if key.dark { 20 } else { 206 };
        for (pixel, value) in rgba.pixels_mut().zip(patch.data()) {
            if value.is_nan() {
                // Outside the picture: the neutral grey that surrounds pictures.
                pixel.0 = [beside, beside, beside, 255];
            }
        }
        let image = egui::ColorImage::from_rgba_unmultiplied([SAMPLES; 2], rgba.as_raw());
        ui.ctx().load_texture(self.name, image, TextureOptions::NEAREST)
    }
}
