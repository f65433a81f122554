//! Picture of a pane on the canvas, its description, and the warning over it where its features are stale.

use crate::app::actions::{ActionId, Queue};
use crate::app::canvas::{CanvasOutput, Quantity, Readout, overlay};
use crate::app::document::{FeaturesShown, RangeClass};
use crate::app::memo::{Itself, Memo};
use crate::app::results::{Read, Stale};
use crate::app::view::{ColourBy, fixed};
use crate::app::{canvas, style};
use crate::app::{pane::PaneId, panel::widgets::paint};
use crate::burst::Offset;
use crate::detector::{Detection, Feature, MotionField, Scale, Slope, SlopeAxis};
use crate::requests::{PictureAnswer, PictureKind, PictureRequest, line_of};
use egui::{Align, Frame, Layout, Margin, Rect, RichText, Ui, UiBuilder, vec2};
use std::sync::Arc;

/// Colours of a picture of motions on the card, made of the motions, the line along which the colours run, if they do,
/// and the layers of the field that are drawn dark.
type Colours = Memo<(Itself, Option<(f32, SlopeAxis)>, Vec<u8>), egui::TextureHandle>;

/// Brightness of the hidden layers of a field, as a fraction.
const HIDDEN: f32 = 0.2;

#[derive(Default)]
pub struct PictureState {
    pub readout: Option<Readout>,
    pub visible_image: Option<Rect>,
    pub ui_from_image: Option<canvas::RectTransform>,
    pub shown: Option<canvas::Picture>,
    pub preview: Option<canvas::Picture>,
    colours: Colours,
    scale: Memo<(Itself, ColourBy), overlay::ColourScale>,
    /// Numbers of features drawn in full, and in view, as last drawn; `None` without features.
    pub drawn_of: Option<(usize, usize)>,
    /// Feature under the pointer, as last drawn.
    pub pointed: Option<usize>,
}

impl PictureState {
    /// Updates the picture on the canvas and its preview. Unchanged pixels keep their id: they are uploaded once.
    pub(in crate::app) fn refresh(&mut self, pictures: [Option<&PictureAnswer>; 2]) {
        for (kept, picture) in [&mut self.shown, &mut self.preview].into_iter().zip(pictures) {
            *kept = picture.map(|picture| match kept.take() {
                Some(kept) if Arc::ptr_eq(&kept.drawn, &picture.drawn) => {
                    canvas::Picture { label: describe(picture), ..kept }
                }
                _ => canvas_picture(picture),
            });
        }
    }

    /// Motions have the colours of those of the features; of a field of motion, layers that the filter hides are dark.
    pub(in crate::app) fn paint_colours(&mut self, ui: &Ui, model: Read<'_>, id: PaneId, output: &CanvasOutput) {
        let (features, filter) = (model.features_of_motion(id), model.filter_of(id));
        let Some(motion) = model.picture_in(id).and_then(|picture| picture.motion.as_ref()) else {
            self.colours = Memo::default();
            return;
        };
        let Some(rect_image) = self.shown.as_ref().map(canvas::Picture::rect_image) else { return };
        let layers = motion.field.iter().flat_map(|field| 0..=field.layers.len() as u8);
        let hides = |layer: &u8| filter.is_some_and(|filter| !filter.shows_layer((*layer).into()));
        let hidden: Vec<u8> = layers.filter(hides).collect();
        let is_hidden = |u: f32, v: f32| {
            let of = |field: &MotionField| hidden.contains(&field.layer_at(u, v));
            !hidden.is_empty() && motion.field.as_ref().is_some_and(of)
        };
        let texture = self.colours.get((motion.into(), line_of(&motion.grid, features), hidden.clone()), || {
            let colours = motion.colours(features);
            // Only every n-th pixel, where the card cannot hold a picture of this size.
            let most = ui.ctx().input(|i| i.max_texture_side).max(1) as u32;
            let (width, height) = colours.dimensions();
            let every = width.max(height).div_ceil(most).max(1);
            let size = [width.div_ceil(every) as usize, height.div_ceil(every) as usize];
            let pixels = (0..size[0] * size[1]).map(|i| {
                let (x, y) = ((i % size[0]) as u32 * every, (i / size[0]) as u32 * every);
                let [r, g, b, _] = colours.get_pixel(x, y).0;
                let brightness = if is_hidden(x as f32, y as f32) { HIDDEN } else { 1.0 };
                let [r, g, b] = [r, g, b].map(|channel| (brightness * f32::from(channel)) as u8);
                egui::Color32::from_rgb(r, g, b)
            });
            let image = egui::ColorImage::new(size, pixels.collect());
            ui.ctx().load_texture("winning slopes", image, egui::TextureOptions::NEAREST)
        });
        paint(&output.painter, texture.id(), output.ui_from_image.rect(rect_image));
        if let Some(field) = &motion.field {
            let known = |u: f32, v: f32| field.known_at(u, v).filter(|_| !is_hidden(u, v));
            overlay::draw_field(output, field, motion.grid.max_magnitude().max(f32::MIN_POSITIVE), known);
        }
    }

    /// Value and its quantity at `pos_image` in the picture of pane `id`; `None` outside it, and under a preview.
    pub(in crate::app) fn readout_at(&self, model: Read<'_>, id: PaneId, pos_image: egui::Pos2) -> Option<Readout> {
        let picture = model.picture_in(id)?;
        let is_seen = |shown: &&canvas::Picture| Arc::ptr_eq(&shown.plane, &picture.plane) && self.preview.is_none();
        let readout = canvas::readout(self.shown.as_ref().filter(is_seen)?, pos_image, model.full_scale(id))?;
        let (u, v) = readout.pixel;
        let quantity = match (RangeClass::of(&picture.request), &picture.motion) {
            (RangeClass::Noise, _) => Quantity::Sigma,
            (RangeClass::Share, _) => Quantity::FramesShare,
            (RangeClass::Motion, Some(motion)) => match &motion.field {
                Some(field) => Quantity::Field(field.known_at(u as f32, v as f32)),
                None => {
                    let (slope, confidence) = motion.at(readout.pixel);
                    Quantity::Slope { slope, confidence }
                }
            },
            _ => Quantity::Value,
        };
        Some(Readout { quantity, smoothing_px: picture.request.smoothing_px, ..readout })
    }

    /// Colours of the features of `detection`, constant until the next detection or another choice.
    pub fn colour_scale(&mut self, model: Read<'_>, detection: &Arc<Detection>) -> overlay::ColourScale {
        let by = model.document.colour_by;
        let of = || overlay::ColourScale::of(by, &detection.features, &detection.slopes);
        let scale = self.scale.get((detection.into(), by), of).clone();
        scale.with_coherences(model.results.coherence.of(detection)).with_set_up(model.document.set_up.depths_by())
    }
}

pub(in crate::app) fn canvas_picture(picture: &PictureAnswer) -> canvas::Picture {
    let (plane, label) = (picture.plane.clone(), describe(picture));
    let (octave, first) = picture.preview.as_ref().map_or((picture.request.kind.octave(), [0; 2]), |preview| {
        (preview.octave, [preview.region.columns.start, preview.region.rows.start])
    });
    let on_canvas = canvas::Picture::of_octave(plane, octave, picture.request.burst.burst.size(), label);
    canvas::Picture { drawn: picture.drawn.clone(), first: first.map(|at| at as f32).into(), ..on_canvas }
}

pub fn describe(picture: &PictureAnswer) -> String {
    let first = describe_request(&picture.request);
    match picture.request.minus() {
        Some(minus) => format!("{first}  −  {}", describe_request(minus)),
        None => first,
    }
}

fn describe_request(request: &PictureRequest) -> String {
    let burst = &request.burst.burst;
    let name = match request.kind {
        PictureKind::Frame(index) => {
            let name = burst.frame_names.get(index).map_or("", String::as_str);
            let place = format!("Frame {index} of {} (0 … {})", burst.len(), burst.len() - 1);
            // Bursts without files name their frames by number, which the text already has.
            let is_told = name.is_empty() || *name == format!("frame {index}");
            return if is_told { place } else { format!("{place}  ·  {name}") };
        }
        PictureKind::Merge => {
            let used = request.params.used_frames(burst.len());
            return format!("Merged frames  ·  {} … {}", used.start, used.end - 1);
        }
        kind => kind.about().label,
    };
    let at = request.kind.scale().map(|Scale { octave, level }| format!("  ·  octave {octave}, level {level}"));
    let slope = request.kind.slope().map(|Slope { u, v }| [u, v].map(|part| fixed(part, 2)).join(", "));
    let of = slope.map(|slope| format!("  ·  slope ({slope}) px/frame"));
    format!("{name}{}{}", at.unwrap_or_default(), of.unwrap_or_default())
}

pub(in crate::app) fn at_time(feature: &Feature, from_middle: Offset<f32>) -> Feature {
    let (u, v) = feature.motion().0.displacement(from_middle);
    Feature { u: feature.u + u, v: feature.v + v, ..*feature }
}

pub fn stale_ui(ui: &mut Ui, model: Read<'_>, rect: Rect, queue: &mut Queue) {
    let Some(stale) = model.stale() else { return };
    if model.document.measure.tool == crate::app::measure::Tool::Mask
        || model.document.look.overlay == FeaturesShown::None
        || model.results.slots.a.detecting.is_pending()
    {
        return;
    }
    let text = match stale {
        Stale::FirstSlope => "Features of the first slope only: the search did not end",
        Stale::Parameters => "Stale features: the parameters changed",
        Stale::InvalidParameters => "Stale features: the parameters are invalid",
    };
    let room = Rect::from_min_max(rect.left_top() + vec2(10.0, 10.0), rect.right_top() + vec2(-10.0, 44.0));
    ui.scope_builder(UiBuilder::new().max_rect(room).layout(Layout::left_to_right(Align::Min)), |ui| {
        let colour = style::warning(ui);
        let frame = Frame::popup(ui.style()).stroke(egui::Stroke::new(1.0, colour));
        frame.inner_margin(Margin::symmetric(8, 4)).show(ui, |ui| {
            ui.label(RichText::new(text).color(colour));
            if stale != Stale::InvalidParameters && ui.small_button("Detect again").clicked() {
                queue.push(ActionId::Detect);
            }
        });
    });
}
