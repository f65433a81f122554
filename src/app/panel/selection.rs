//! Selected feature: its numbers, patches and descriptor. The last two are also drawn for matches.

use crate::app::actions::{ActionId, Queue, button_ui};
use crate::app::panel::widgets::{draw_plane, named, number_row_ui, section_ui};
use crate::app::results::{Read, verdict_words};
use crate::app::view::{KnownOfFeature, depth_text, fixed, layer_text, motion_text, quantity_text};
use crate::app::{document::Side, panel::picture::at_time};
use crate::detector::{Descriptor, Feature, MotionLayer, Quantity};
use crate::inspect::place::Verdict;
use crate::plane::Plane;
use crate::plane::display::Display;
use crate::plane::sample::sample_patch;
use egui::{Color32, Label, Rect, Response, RichText, Role, Sense, Stroke, StrokeKind, Ui, Vec2, vec2};
use std::sync::Arc;

pub fn walk_ui(ui: &mut Ui, model: Read<'_>, queue: &mut Queue) {
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        button_ui(ui, model, queue, ActionId::PreviousFeature, Some("Previous"));
        button_ui(ui, model, queue, ActionId::NextFeature, Some("Next"));
        button_ui(ui, model, queue, ActionId::GoToFeature, Some("Go to"));
        button_ui(ui, model, queue, ActionId::ClearSelection, Some("Clear"));
        if model.document.workspace.inspects() && model.document.selected.is_some() {
            button_ui(ui, model, queue, ActionId::ProbeFeature, Some("Why?"));
        }
    });
}

pub fn selection_ui(ui: &mut Ui, model: Read<'_>, queue: &mut Queue) {
    section_ui(ui, "Selected feature", |ui| {
        walk_ui(ui, model, queue);
        let (Some(index), Some(feature)) = (model.document.selected, model.selected_feature().copied()) else {
            ui.add_space(4.0);
            ui.weak("Click a feature in the picture or a row of the table.");
            return;
        };
        if model.stale().is_some() {
            ui.label(RichText::new("Stale: found with other parameters").color(crate::app::style::warning(ui)));
        }
        ui.add_space(4.0);
        patches_ui(ui, model, &feature);
        ui.add_space(4.0);
        let judged = model.judged().and_then(|judged| judged.get(index)).cloned();
        if let Some(judged) = &judged {
            let colour = match judged.verdict {
                Verdict::Real | Verdict::Unclear => ui.visuals().text_color(),
                Verdict::Ghost | Verdict::Alias | Verdict::Duplicate => crate::app::style::warning(ui),
            };
            ui.add(Label::new(RichText::new(verdict_words(Some(&feature), judged)).color(colour)).wrap());
            ui.add_space(4.0);
        }
        let found = model.found_of(Side::A);
        let layers = found.and_then(|found| found.detection.field.as_ref()).map_or(&[][..], |field| &field.layers);
        let known = model.document.set_up.known(&feature, judged.as_ref());
        numbers_ui(ui, index, &feature, known, layers);
        ui.add_space(6.0);
        if let Some(descriptor) = found.and_then(|found| found.detection.descriptors.get(index)) {
            ui.label(RichText::new("Descriptor").small().weak());
            descriptor_ui(ui, "Descriptor", descriptor, ui.available_width().min(200.0));
        }
    });
}

/// Quantities that stand in a row with others, or above the numbers.
const WITH_OTHERS: [Quantity; 12] = {
    use Quantity::{Depth, FieldSigma, FieldU, FieldV, Layer, Rank, SlopeSigma, SlopeU, SlopeV, U, V, Verdict};
    [Rank, U, V, SlopeU, SlopeV, SlopeSigma, FieldU, FieldV, FieldSigma, Layer, Depth, Verdict]
};

fn numbers_ui(ui: &mut Ui, index: usize, f: &Feature, known: KnownOfFeature<'_>, layers: &[MotionLayer]) {
    let grid = egui::Grid::new("numbers").num_columns(2).spacing([12.0, 2.0]).striped(true).min_col_width(96.0);
    grid.show(ui, |ui| {
        let mut row = |name: &str, help: &str, value: String| number_row_ui(ui, name, help, &value);
        row("Number", "By |D|·√SNR, the strongest first, from 0 as in files", index.to_string());
        let help = "At mid-burst, pixels; the centre of the first pixel is (0, 0)";
        row("Place (u, v)", help, format!("{}, {} px", fixed(f.u, 2), fixed(f.v, 2)));
        // The names of the rows have the unit.
        let motion = |slope, sigma| motion_text(slope, sigma, 2).replace(" px/frame", "");
        let help = "(u, v) of its own motion, refined between the grid's slopes, ± the standard deviation along its least certain direction";
        row("Slope, px/frame", help, motion(f.slope, f.slope_sigma));
        let help = "(u, v) of the motion of its place, from the field of motion, ± the standard deviation along the least certain direction";
        let field = f.known_field().map_or_else(|| "unknown".to_owned(), |field| motion(field, f.field_sigma));
        row("Field, px/frame", help, field);
        let layer = usize::try_from(f.layer - 1).ok().and_then(|index| layers.get(index));
        let layer = layer.map_or_else(|| "none".to_owned(), |layer| layer_text(f.layer, layer));
        row("Layer, px/frame", Quantity::Layer.record().help, layer.replace(" px/frame", ""));
        if let Some(depth) = known.depth_m {
            row("Depth", "Depth that its motion means by the set-up, ± the standard deviation", depth_text(depth));
        }
        row("Speed, px/frame", "Length of the slope", format!("{:.3}", f.slope.magnitude()));
        row("Slope index", "Index of the slope of the grid at which it was found, from 0", f.slope_index.to_string());
        for quantity in Quantity::ALL.into_iter().filter(|quantity| !WITH_OTHERS.contains(quantity)) {
            let (record, text) = (quantity.record(), quantity_text(quantity, index, f, known));
            let has_unit = !record.unit.is_empty() && !text.ends_with('°');
            let unit = if has_unit { format!(", {}", record.unit) } else { String::new() };
            let text = if text.is_empty() { "no" } else { text.strip_prefix("moves ").unwrap_or(&text) };
            row(&format!("{}{unit}", record.title), record.help, text.to_owned());
        }
    });
}

fn patches_ui(ui: &mut Ui, model: Read<'_>, feature: &Feature) {
    let Some(burst) = &model.results.slots.a.burst else { return };
    let display = model.document.look.ranges.intensity;
    let side = (0.5 * (ui.available_width() - 8.0)).clamp(60.0, 150.0);
    ui.horizontal(|ui| {
        let view = PatchView { name: "Patch in the motion stack", feature: *feature, turned: false, display };
        view.ui(ui, model.stack_at(Side::A, feature.slope), side, RichText::new("Motion stack").small().weak());
        let t = model.document.cursor().frame.min(burst.burst.len() - 1);
        let used = model.found_of(Side::A).map_or(0..burst.burst.len(), |f| f.detection.frames_used.clone());
        // In a frame the feature lies further along its motion, away from the middle of the frames used.
        let feature = at_time(feature, burst.burst.positions.offset_from(used, t).to_f32());
        let view = PatchView { name: "Patch in one frame", feature, turned: false, display };
        view.ui(ui, Some(&burst.burst.frames[t]), side, RichText::new(format!("Frame {t}")).small().weak());
    });
}

/// Number of cells on a side, and of directions in a cell.
const CELLS: usize = 4;
const DIRECTIONS: usize = 8;

/// Draws the roses in a square of `side` points, the feature's orientation to the right; `name` is for screen readers.
pub fn descriptor_ui(ui: &mut Ui, name: &str, descriptor: &Descriptor, side: f32) {
    let stroke = Stroke::new(1.5, ui.visuals().hyperlink_color);
    let (rect, response) = ui.allocate_exact_size(vec2(side, side), Sense::hover());
    let painter = ui.painter_at(rect.expand(1.0));
    painter.rect_filled(rect, 2.0, ui.visuals().extreme_bg_color);
    let cell = side / CELLS as f32;
    let grid = Stroke::new(1.0, ui.visuals().widgets.noninteractive.bg_stroke.color);
    let longest = f32::from(descriptor.iter().copied().max().unwrap_or(0).max(1));
    for row in 0..CELLS {
        for column in 0..CELLS {
            let square = Rect::from_min_size(rect.min + cell * vec2(column as f32, row as f32), Vec2::splat(cell));
            painter.rect_stroke(square, 0.0, grid, StrokeKind::Middle);
            for direction in 0..DIRECTIONS {
                let value = f32::from(descriptor[(row * CELLS + column) * DIRECTIONS + direction]) / longest;
                let tip = 0.46 * cell * value * Vec2::angled(angle_of(direction));
                painter.line_segment([square.center(), square.center() + tip], stroke);
            }
        }
    }
    painter.rect_stroke(rect, 2.0, grid, StrokeKind::Inside);
    named(&response, Role::Image, name);
    response.on_hover_text(
        "Descriptor: strength of the gradients in 8 directions in each of 4 × 4 cells, summed over the scales that Describe scales says. The feature's orientation points to the right.",
    );
}

/// Direction of a descriptor's element within its cell, radians from +u towards +v of the feature's own frame: in UBC's
/// layout the directions run the other way round.
fn angle_of(direction: usize) -> f32 {
    -std::f32::consts::TAU * direction as f32 / DIRECTIONS as f32
}

const SAMPLES: usize = 72;
/// Half width of a patch, in σ: the reach of the descriptor's 4×4 cells of 3 σ, those of its finest scale.
const SIGMAS: f32 = 6.0;

pub struct PatchView<'a> {
    pub name: &'a str,
    pub feature: Feature,
    /// Whether the patch is rotated so that the feature's orientation points to the right, as its descriptor sees it.
    pub turned: bool,
    pub display: Display,
}

/// Draws the square of `plane` around (u, v), `half_width_px` pixels to each side and turned by `angle_rad`; without a
/// plane the square that was drawn before.
pub fn draw_square(
    ui: &Ui,
    named_rect: (&str, Rect),
    plane: Option<&Arc<Plane>>,
    square @ [u, v, half_width_px, angle_rad]: [f32; 4],
    display: Display,
) {
    let sample = |plane| move || sample_patch(plane, (u, v), half_width_px, angle_rad, SAMPLES);
    draw_plane(ui, named_rect, display, plane.map(|plane| (plane.into(), square, sample(plane))));
}

impl PatchView<'_> {
    /// Draws the patch above its caption.
    pub fn ui(&self, ui: &mut Ui, plane: Option<&Arc<Plane>>, side: f32, caption: RichText) -> Response {
        let column = ui.vertical(|ui| {
            ui.set_width(side);
            self.patch_ui(ui, plane, side);
            ui.label(caption)
        });
        column.inner
    }

    /// Draws the patch of `plane`, on the input image's pixels, into a square of `side` points, empty without a plane.
    fn patch_ui(&self, ui: &mut Ui, plane: Option<&Arc<Plane>>, side: f32) {
        let (rect, response) = ui.allocate_exact_size(Vec2::splat(side), Sense::hover());
        let Some(plane) = plane else { return };
        let half_width_px = (SIGMAS * self.feature.sigma).max(4.0);
        let angle_rad = if self.turned { self.feature.orientation } else { 0.0 };
        let Feature { u, v, .. } = self.feature;
        draw_square(ui, (self.name, rect), Some(plane), [u, v, half_width_px, angle_rad], self.display);
        let radius = self.feature.circle_radius_px() * 0.5 * side / half_width_px;
        let tip = rect.center() + radius * Vec2::angled(self.feature.orientation - angle_rad);
        for (width, colour) in [(3.0, Color32::from_black_alpha(140)), (1.4, Color32::from_rgb(255, 214, 90))] {
            ui.painter().circle_stroke(rect.center(), radius, Stroke::new(width, colour));
            ui.painter().line_segment([rect.center(), tip], Stroke::new(width, colour));
        }
        named(&response, Role::Image, self.name);
        let turned = if self.turned { ", turned so that the orientation points to the right" } else { "" };
        response.on_hover_text(format!("{}: {half_width_px:.0} px to each side{turned}", self.name));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_roses_turn_against_the_order_of_the_elements() {
        assert_eq!(angle_of(0), 0.0);
        for (direction, tip) in [(2, vec2(0.0, -1.0)), (4, vec2(-1.0, 0.0)), (6, vec2(0.0, 1.0))] {
            assert!((Vec2::angled(angle_of(direction)) - tip).length() < 1e-6, "element {direction}");
        }
    }
}
