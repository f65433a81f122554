//! The canvas: one picture that can be panned and zoomed, and its overlays.
//!
//! Positions are in pixels of the input image (`pos_image`: the centre of the first pixel is (0, 0), it covers −0.5 …
//! 0.5) or in points of the window (`pos_ui`). `ui_from_image` maps the former to the latter. A picture of another
//! octave is laid over the image where its pixels belong, so that switching the kind of picture does not move the view.
//!
//! The wheel (with or without Ctrl) and pinching zoom at the pointer, dragging pans, a double click fits.

pub mod overlay;
mod picture;
mod readout;

pub use crate::app::view::{MAX_POINTS_PER_PIXEL, RectTransform, View, Zoom, number, signed_number};
pub use picture::Picture;
pub use readout::{Quantity, Readout, VALUE_MIN_POINTS, readable_on, readout};

use crate::app::gpu::{Gpu, PicturePaint};
use crate::plane::display::Display;
use egui::{Align2, Color32, CursorIcon, Painter, PointerButton, Pos2, Rect, Response, Sense, Stroke, Ui, Vec2};

pub struct Canvas<'a> {
    /// For screen readers and tests; no two on screen may share a name.
    pub name: &'a str,
    /// Without one the canvas shows `empty_text`.
    pub picture: Option<&'a Picture>,
    /// Preview of the next picture, drawn over the picture and never read.
    pub preview: Option<&'a Picture>,
    pub display: Display,
    pub dim: bool,
    /// Value in the file that became 1.0, in whose unit values are drawn into large pixels.
    pub full_scale: f32,
    pub values: bool,
    pub empty_text: &'a str,
    /// Whether dragging with the primary button pans. Where that button draws instead, the middle button still pans.
    pub primary_pans: bool,
}

pub struct CanvasOutput {
    pub response: Response,
    pub painter: Painter,
    pub ui_from_image: RectTransform,
    pub image_from_ui: RectTransform,
    /// Part of the image plane that the canvas shows, in image pixels; may extend beyond the image.
    pub visible_image: Rect,
    pub pointer_ui: Option<Pos2>,
    /// The pointer, in image pixels, while it is over the canvas and over the picture.
    pub hover_image: Option<Pos2>,
}

impl CanvasOutput {
    pub fn clicked_in_sight(&self) -> bool {
        let pos = self.response.interact_pointer_pos();
        self.response.clicked() && pos.is_none_or(|pos| self.painter.clip_rect().contains(pos))
    }
}

impl<'a> Canvas<'a> {
    pub fn new(name: &'a str) -> Self {
        let (display, full_scale, empty_text) = (Display::default(), 1.0, "No picture");
        let (values, primary_pans) = (true, true);
        Self { name, picture: None, preview: None, display, dim: false, full_scale, values, empty_text, primary_pans }
    }

    pub fn show(self, ui: &mut Ui, view: &mut View) -> CanvasOutput {
        let size = ui.available_size().max(Vec2::splat(16.0));
        let (rect, mut response) = ui.allocate_exact_size(size, Sense::click_and_drag());
        let pixels_per_point = ui.ctx().pixels_per_point();
        let zoom_before = view.points_per_pixel();
        // Without a picture any size will do; nothing is drawn with it.
        let image_size = self.picture.map_or((1, 1), |p| p.image_size);
        if self.picture.is_some() {
            // The pointer acts on the view as it fits this rectangle: the view is settled before and after.
            view.settle(rect, image_size, pixels_per_point);
            navigate(ui, &response, rect, view, self.primary_pans);
        }
        let mut settled = *view;
        let ui_from_image = settled.settle(rect, image_size, pixels_per_point);
        if self.picture.is_some() {
            if settled.points_per_pixel() != zoom_before {
                // Widgets that show the zoom may have been drawn before it was known.
                ui.ctx().request_repaint();
            }
            *view = settled;
        }
        let image_from_ui = ui_from_image.inverse();
        let pointer_ui = response.hover_pos().or_else(|| response.interact_pointer_pos()).filter(|&p| rect.contains(p));
        let is_over = |p: &Pos2| self.picture.is_some_and(|picture| picture.rect_image().contains(*p));
        let output = CanvasOutput {
            painter: ui.painter_at(rect),
            ui_from_image,
            image_from_ui,
            visible_image: image_from_ui.rect(rect),
            pointer_ui,
            hover_image: pointer_ui.map(|p| image_from_ui.pos(p)).filter(is_over),
            response: response.clone(),
        };
        if ui.is_rect_visible(rect) {
            self.draw(ui, &output, output.response.id);
        }
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Canvas, ui.is_enabled(), self.name));
        if self.picture.is_some() {
            let is_panning = response.dragged() && self.primary_pans;
            let cursor = if is_panning { CursorIcon::Grabbing } else { CursorIcon::Crosshair };
            response = response.on_hover_and_drag_cursor(cursor);
        }
        CanvasOutput { response, ..output }
    }

    /// Draws over the canvas of `below`, at the same places of the image, but only within `clip_ui`.
    pub fn show_over(self, ui: &Ui, below: &CanvasOutput, clip_ui: Rect) -> CanvasOutput {
        let output = CanvasOutput {
            response: below.response.clone(),
            painter: below.painter.with_clip_rect(clip_ui.intersect(below.response.rect)),
            ..*below
        };
        if output.painter.clip_rect().is_positive() {
            self.draw(ui, &output, output.response.id.with(self.name));
        }
        output
    }

    fn draw(&self, ui: &Ui, output: &CanvasOutput, pane: egui::Id) {
        let rect = output.response.rect;
        let backdrop = backdrop(ui);
        output.painter.rect_filled(rect, 0.0, backdrop);
        let say = |text: &str| message(ui, &output.painter, rect, text);
        let Some(picture) = self.picture else { return say(self.empty_text) };
        let Some(gpu) = Gpu::of(ui.ctx()) else {
            return say("Pictures cannot be drawn: this window has no graphics card to draw with.");
        };
        // A picture that cannot be shown is reported in its own place; other panes go on.
        if let Some(obstacle) = gpu.obstacle(picture.id, picture.plane.size()) {
            return say(&obstacle);
        }
        let (dim, display) = (ui.ctx().animate_bool(pane.with("dim"), self.dim), self.display.sanitised());
        let paint = |picture: &Picture, pane: egui::Id| {
            let (id, plane) = (picture.id, picture.drawn.clone());
            let ui_from_picture = picture.ui_from_picture(output.ui_from_image);
            let paint = PicturePaint { pane, id, plane, ui_from_picture, display, dim, backdrop };
            output.painter.add(egui_wgpu::Callback::new_paint_callback(rect, paint));
        };
        let seen = output.visible_image.intersect(picture.rect_image());
        // Its octave may end a pixel before the picture.
        let covers = |other: &Picture| other.rect_image().expand(other.image_from_picture_scale).contains_rect(seen);
        if !self.preview.is_some_and(covers) {
            paint(picture, pane);
        }
        if let Some(preview) = self.preview {
            return paint(preview, pane.with("preview"));
        }
        for line in picture.hatching(output.ui_from_image, rect) {
            for (width, colour) in [(2.5, Color32::from_black_alpha(110)), (1.0, Color32::from_gray(190))] {
                output.painter.line_segment(line, Stroke::new(width, colour));
            }
        }
        if self.values {
            self.draw_values(picture, output);
        }
    }
}

/// Neutral grey around the picture, so that the surroundings do not tint it.
pub fn backdrop(ui: &Ui) -> Color32 {
    if ui.visuals().dark_mode { Color32::from_gray(20) } else { Color32::from_gray(206) }
}

pub fn message(ui: &Ui, painter: &Painter, rect: Rect, text: &str) {
    let font = egui::TextStyle::Body.resolve(ui.style());
    let width = (rect.width() - 32.0).clamp(40.0, 460.0);
    let mut job = egui::text::LayoutJob::simple(text.to_owned(), font, ui.visuals().weak_text_color(), width);
    job.halign = egui::Align::Center;
    let galley = painter.layout_job(job);
    let pos = Align2::CENTER_CENTER.anchor_size(rect.center(), galley.size()).center_top();
    painter.galley(pos, galley, ui.visuals().weak_text_color());
}

pub fn navigate(ui: &Ui, response: &Response, rect: Rect, view: &mut View, primary_pans: bool) {
    if response.double_clicked() {
        view.set_fit();
    }
    if (primary_pans && response.dragged_by(PointerButton::Primary)) || response.dragged_by(PointerButton::Middle) {
        view.pan(response.drag_delta());
    }
    // `contains_pointer` looks at layers too: a window above the canvas keeps its wheel.
    if response.contains_pointer()
        && let Some(pointer) = ui.input(|i| i.pointer.hover_pos())
    {
        /// Points of scrolling that zoom by a factor of e; a wheel's notch gives about 40 to 50 points.
        const POINTS_PER_E_FOLD: f32 = 220.0;
        let (scroll, zoom) = ui.input(|i| (i.smooth_scroll_delta(), i.zoom_delta()));
        // With Alt the wheel goes through frames and slopes; what is left of its turn when Alt is let go zooms nothing.
        let id = response.id.with("wheel with Alt");
        let is_left = scroll != Vec2::ZERO && ui.data(|data| data.get_temp(id)).unwrap_or(false);
        let is_with_alt = is_left || ui.input(|i| i.modifiers.alt);
        ui.data_mut(|data| data.insert_temp(id, is_with_alt));
        if is_with_alt {
            return;
        }
        view.zoom_at(pointer, zoom * (scroll.y / POINTS_PER_E_FOLD).exp(), rect);
        // A second axis, or the wheel with Shift, moves sideways.
        view.pan(Vec2::new(scroll.x, 0.0));
    }
}
