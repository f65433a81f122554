//! Paint callback: one picture in one pane.

use super::PictureId;
use super::renderer::{PictureRenderer, lut_row};
use super::uniforms::Uniforms;
use crate::app::canvas::RectTransform;
use crate::plane::Plane;
use crate::plane::display::Display;
use std::sync::Arc;

/// One picture in one pane, for one frame.
#[derive(Debug, Clone)]
pub struct PicturePaint {
    /// Id of the pane; unique in a frame.
    pub pane: egui::Id,
    /// Id of the picture.
    pub id: PictureId,
    /// Values of the picture; read only when it is not on the card yet.
    pub plane: Arc<Plane>,
    /// Transform from pixels of the picture (centre of the first one at 0) to points of the window.
    pub ui_from_picture: RectTransform,
    /// Range, gamma and colour map.
    pub display: Display,
    /// Dimming: 0 none, 1 that of a stale picture.
    pub dim: f32,
    /// Colour towards which a dimmed picture fades.
    pub backdrop: egui::Color32,
}

impl PicturePaint {
    /// Shape that draws the picture into `rect_ui`.
    pub fn into_shape(self, rect_ui: egui::Rect) -> egui::Shape {
        egui_wgpu::Callback::new_paint_callback(rect_ui, self).into()
    }

    fn uniforms(&self, pixels_per_point: f32) -> Uniforms {
        let origin_ui = self.ui_from_picture.anchor_to();
        let anchor = self.ui_from_picture.anchor_from();
        let display = self.display.sanitised();
        let backdrop = [self.backdrop.r(), self.backdrop.g(), self.backdrop.b()].map(|c| f32::from(c) / 255.0);
        Uniforms {
            origin_px: [origin_ui.x * pixels_per_point, origin_ui.y * pixels_per_point],
            anchor_picture: [anchor.x, anchor.y],
            backdrop,
            picture_px_per_px: screen_ratio(1.0 / (self.ui_from_picture.scale() * pixels_per_point)),
            range_min: display.min,
            range_scale: 1.0 / (display.max - display.min),
            exponent: 1.0 / display.gamma,
            lut_row: lut_row(display.map),
            flags: u32::from(display.map.is_diverging()),
            dim: self.dim.clamp(0.0, 1.0),
            ..bytemuck::Zeroable::zeroed()
        }
    }
}

/// Rounds a ratio to 1 where it differs only by rounding, so that pixels are copied and not mixed with their
/// neighbours.
fn screen_ratio(picture_px_per_px: f32) -> f32 {
    if (picture_px_per_px - 1.0).abs() < 1e-5 { 1.0 } else { picture_px_per_px }
}

impl egui_wgpu::CallbackTrait for PicturePaint {
    fn prepare(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        screen: &egui_wgpu::ScreenDescriptor,
        _encoder: &mut wgpu::CommandEncoder,
        resources: &mut egui_wgpu::CallbackResources,
    ) -> Vec<wgpu::CommandBuffer> {
        if let Some(renderer) = resources.get_mut::<PictureRenderer>() {
            let uniforms = self.uniforms(screen.pixels_per_point);
            renderer.prepare(device, queue, self.pane.value(), (self.id, &self.plane), uniforms);
        }
        Vec::new()
    }

    fn finish_prepare(
        &self,
        _device: &wgpu::Device,
        _queue: &wgpu::Queue,
        _encoder: &mut wgpu::CommandEncoder,
        resources: &mut egui_wgpu::CallbackResources,
    ) -> Vec<wgpu::CommandBuffer> {
        if let Some(renderer) = resources.get_mut::<PictureRenderer>() {
            renderer.end_frame();
        }
        Vec::new()
    }

    fn paint(
        &self,
        _info: egui::PaintCallbackInfo,
        pass: &mut wgpu::RenderPass<'static>,
        resources: &egui_wgpu::CallbackResources,
    ) {
        if let Some(renderer) = resources.get::<PictureRenderer>() {
            renderer.paint(self.pane.value(), pass);
        }
    }
}
