//! Float picture as a texture, made again only for another answer or another display.

use crate::plane::Plane;
use crate::plane::display::{Display, to_rgba8};
use egui::{Color32, Rect, TextureHandle, TextureOptions, Ui, pos2};
use std::any::Any;
use std::sync::Arc;

/// Last drawn texture.
#[derive(Default)]
pub struct PlaneTexture(Option<Made>);

struct Made {
    of: Arc<dyn Any + Send + Sync>,
    display: Display,
    dark: bool,
    texture: TextureHandle,
}

impl PlaneTexture {
    /// Draws a picture of the answer `of` into `rect`: pixels are sharp squares, NaN has the colour of the canvas's
    /// backdrop.
    pub fn draw<T: Any + Send + Sync>(
        &mut self,
        ui: &Ui,
        rect: Rect,
        (name, of): (&str, &Arc<T>),
        display: Display,
        plane: impl FnOnce() -> Plane,
    ) {
        let dark = ui.visuals().dark_mode;
        let of: Arc<dyn Any + Send + Sync> = of.clone();
        // The texture keeps its answer alive, so that no other has its address.
        let is_same = |made: &Made| std::ptr::addr_eq(Arc::as_ptr(&made.of), Arc::as_ptr(&of));
        let fits = |made: &Made| is_same(made) && made.display == display && made.dark == dark;
        if !self.0.as_ref().is_some_and(fits) {
            let plane = plane();
            let mut rgba = to_rgba8(&plane, &display);
            let beside = if dark { 20 } else { 206 };
            for (pixel, value) in rgba.pixels_mut().zip(plane.data()) {
                if value.is_nan() {
                    pixel.0 = [beside, beside, beside, 255];
                }
            }
            let (width, height) = plane.size();
            let image = egui::ColorImage::from_rgba_unmultiplied([width, height], rgba.as_raw());
            let texture = ui.ctx().load_texture(name, image, TextureOptions::NEAREST);
            self.0 = Some(Made { of, display, dark, texture });
        }
        if let Some(made) = &self.0 {
            let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
            ui.painter().image(made.texture.id(), rect, whole, Color32::WHITE);
        }
    }
}
