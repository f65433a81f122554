//! Histogram of a picture, with handles on the range's ends, and the settings of range, colour map and gamma.
//!
//! The range changes only by hand, so that pictures can be compared; the axis stays while range and values fit on it.

use crate::app::canvas::overlay::rgb;
use crate::app::canvas::{Picture, number};
use crate::app::panel::widgets::{hint, small_text, strip_of_colours};
use crate::app::words::choices;
use crate::app::{gpu::PictureId, memo::Memo};
use crate::inspect::words::counted;
use crate::plane::display::{ColourMap, Display, GAMMA_RANGE};
use crate::plane::statistics::{Histogram, Region, histogram, percentiles, summary};
use egui::{
    Align2, Color32, CursorIcon, DragValue, Mesh, Painter, Pos2, Rangef, Rect, Response, Sense, Shape, Slider, Stroke,
    StrokeKind, Ui, pos2, vec2,
};

const BINS: usize = 256;

const PLOT_POINTS: f32 = 118.0;

/// The range leaves out the darkest and the brightest thousandth.
const PERCENTILES: [f32; 2] = [0.1, 99.9];

/// State of the histogram panel: one for each kind of picture, as each kind has its own range and axis.
#[derive(Default)]
pub struct HistogramPanel {
    data_range: Memo<PictureId, Option<(f32, f32)>>,
    counts: Memo<(PictureId, Rangef), Histogram>,
    axis: Option<Rangef>,
    drag: Option<Drag>,
}

choices! {
    /// Values of a picture from which its range is set.
    RangeOf {
        All: "Full range", "From the smallest to the largest value of the picture";
        Percentiles: "Percentiles", "Leaves out the lowest and the highest 0.1 % of the values";
        Visible: "Visible region", "The same percentiles, of the part of the picture that can be seen";
    }
}

impl RangeOf {
    /// Part of the picture with the values; `None` where it has none. `visible` is the part in sight, image pixels.
    fn region(self, picture: &Picture, visible: Option<Rect>) -> Option<Region> {
        let region = match self {
            Self::All | Self::Percentiles => Region::whole(&picture.drawn),
            Self::Visible => picture.region(visible?),
        };
        let has_value = |v| picture.drawn.row(v)[region.columns.clone()].iter().any(|x| x.is_finite());
        region.rows.clone().any(has_value).then_some(region)
    }

    fn range(self, picture: &Picture, region: &Region) -> Option<(f32, f32)> {
        match self {
            Self::All => summary(&picture.drawn, region).range(),
            _ => percentiles(&picture.drawn, region, &PERCENTILES).map(|ends| (ends[0], ends[1])),
        }
    }
}

impl HistogramPanel {
    /// Returns whether `display` changed. `visible` is the part of the image that the canvas shows, image pixels.
    pub fn ui(&mut self, ui: &mut Ui, picture: Option<&Picture>, visible: Option<Rect>, display: &mut Display) -> bool {
        let before = *display;
        *display = display.sanitised();
        if let Some(picture) = picture {
            self.plot_ui(ui, picture, display);
        } else {
            let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), PLOT_POINTS), Sense::hover());
            response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, false, "Histogram"));
            ui.painter().rect_filled(rect, 3.0, ui.visuals().extreme_bg_color);
        }
        if ends_ui(ui, display) {
            self.axis = None;
        }
        ui.horizontal_wrapped(|ui| {
            ui.spacing_mut().item_spacing.x = 4.0;
            if ranges_ui(ui, picture, visible, display) {
                // The axis is chosen again for the new range.
                self.axis = None;
            }
        });
        ui.add_space(4.0);
        colours_ui(ui, display);
        *display != before
    }

    fn plot_ui(&mut self, ui: &mut Ui, picture: &Picture, display: &mut Display) {
        let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), PLOT_POINTS), Sense::click_and_drag());
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, ui.is_enabled(), "Histogram"));
        if response.double_clicked() {
            self.axis = None;
        }
        let (axis, counts) = self.count(picture, display);
        let geometry = PlotGeometry::new(rect, axis);
        let grip = self.drag_handles(&response, &geometry, display);
        if ui.is_rect_visible(rect) {
            draw(ui, &ui.painter_at(rect), &geometry, &counts, display, grip);
        }
        let cursor = match grip {
            Some(Grip::Min | Grip::Max) => CursorIcon::ResizeHorizontal,
            Some(Grip::Both) if response.dragged() => CursorIcon::Grabbing,
            Some(Grip::Both) => CursorIcon::Grab,
            None => CursorIcon::Default,
        };
        let response = response.on_hover_and_drag_cursor(cursor);
        if let Some(pointer) = response.hover_pos().filter(|p| geometry.bars.contains(*p) && !response.dragged()) {
            let t = (geometry.value_at(pointer.x) - counts.min) / (counts.max - counts.min);
            let i = ((t * counts.counts.len() as f32).max(0.0) as usize).min(counts.counts.len() - 1);
            let (from, to) = counts.bin_range(i);
            let pixels = counted(counts.counts[i] as usize, "pixel");
            response.on_hover_text_at_pointer(format!("{} … {}: {pixels}", number(from, 4), number(to, 4)));
        }
    }

    /// The axis, and what is counted along it.
    fn count(&mut self, picture: &Picture, display: &Display) -> (Rangef, Histogram) {
        let whole = Region::whole(&picture.drawn);
        let data_range = *self.data_range.get(picture.id, || summary(&picture.drawn, &whole).range());
        // While a handle is dragged the axis stays.
        let kept = self.axis.filter(|axis| self.drag.is_some() || axis_fits(*axis, data_range, display));
        let axis = kept.unwrap_or_else(|| axis_for(data_range, display));
        self.axis = Some(axis);
        let counted = || histogram(&picture.drawn, &whole, axis.min, axis.max, BINS);
        (axis, self.counts.get((picture.id, axis), counted).clone())
    }

    fn drag_handles(&mut self, response: &Response, geometry: &PlotGeometry, display: &mut Display) -> Option<Grip> {
        if response.drag_started()
            && let Some(pointer) = response.interact_pointer_pos()
        {
            // The place of the press, not that where the drag was recognised, decides what is grabbed.
            let press = pointer - response.total_drag_delta().unwrap_or_default();
            // A press outside the range moves its nearer end.
            let nearer = if press.x < geometry.x_of(display.min) { Grip::Min } else { Grip::Max };
            let grip = grip_at(press, geometry, display).unwrap_or(nearer);
            self.drag = Some(Drag { grip, start: *display, start_value: geometry.value_at(press.x) });
        }
        if !response.dragged() {
            self.drag = None;
        }
        let pointer = response.interact_pointer_pos().or(response.hover_pos())?;
        let Some(drag) = self.drag else { return grip_at(pointer, geometry, display) };
        *display = dragged(drag, geometry.value_at(pointer.x), geometry.axis);
        Some(drag.grip)
    }
}

/// Draws a button for each choice of values that the range can be set from; returns whether one was pressed.
pub fn ranges_ui(ui: &mut Ui, picture: Option<&Picture>, visible: Option<Rect>, display: &mut Display) -> bool {
    let mut is_set = false;
    for of in RangeOf::ALL {
        let values = picture.and_then(|picture| Some((picture, of.region(picture, visible)?)));
        let [label, help] = of.words();
        let button = ui.add_enabled(values.is_some(), egui::Button::new(label)).on_hover_text(help);
        // Counted only when asked for: percentiles of a large picture take a quarter of a second.
        let asked = values.filter(|_| button.clicked());
        if let Some((min, max)) = asked.and_then(|(picture, region)| of.range(picture, &region)) {
            (*display, is_set) = (display.with_range(min, max), true);
        }
    }
    is_set
}

/// Draws the numbers of the range; returns whether its button was pressed.
pub fn ends_ui(ui: &mut Ui, display: &mut Display) -> bool {
    let mut full_scale = false;
    let speed = f64::from((display.max - display.min) * 0.004);
    ui.horizontal(|ui| {
        if display.symmetric {
            let mut limit = display.max;
            if value_ui(ui, "Range ±", &mut limit, speed) {
                *display = display.with_range(-limit.abs(), limit.abs());
            }
        } else {
            let (mut min, mut max) = (display.min, display.max);
            if value_ui(ui, "Min", &mut min, speed) {
                *display = display.with_range(min, max.max(min));
            }
            if value_ui(ui, "Max", &mut max, speed) {
                *display = display.with_range(min.min(max), max);
            }
            if ui.button("0 – 1").on_hover_text("The full scale of the file: from black to saturated.").clicked() {
                *display = display.with_range(0.0, 1.0);
                full_scale = true;
            }
        }
    });
    full_scale
}

fn value_ui(ui: &mut Ui, name: &str, value: &mut f32, speed: f64) -> bool {
    let label = ui.label(name);
    let drag = DragValue::new(value)
        .speed(speed)
        .update_while_editing(false)
        .custom_formatter(|x, _| number(x as f32, 4))
        .custom_parser(|text| {
            text.trim().replace('−', "-").replace(',', ".").parse().ok().filter(|x: &f64| x.is_finite())
        });
    let field = ui.add_sized(vec2(66.0, ui.spacing().interact_size.y), drag).labelled_by(label.id);
    field.on_hover_text("As a fraction of full scale.").changed()
}

fn colours_ui(ui: &mut Ui, display: &mut Display) {
    egui::Grid::new("colours").num_columns(2).spacing(vec2(8.0, 6.0)).show(ui, |ui| {
        let label = ui.label("Colour map");
        let combo = egui::ComboBox::from_id_salt("colour map").selected_text(display.map.name()).width(170.0);
        let response = combo.show_ui(ui, |ui| {
            for map in ColourMap::ALL {
                ui.horizontal(|ui| {
                    let (rect, _) = ui.allocate_exact_size(vec2(44.0, 12.0), Sense::hover());
                    let lut = map.lut();
                    strip_of_colours(ui.painter(), rect, 32, |i, _| rgb(lut[i * 255 / 31]));
                    ui.selectable_value(&mut display.map, map, map.name()).on_hover_text(map.help());
                });
            }
        });
        response.response.labelled_by(label.id).on_hover_text(display.map.help());
        ui.end_row();
        let label = ui.label("Gamma");
        ui.spacing_mut().slider_width = 110.0;
        // The slider covers the useful range; numbers beyond it can be typed.
        let slider = Slider::new(&mut display.gamma, 0.25..=4.0)
            .logarithmic(true)
            .max_decimals(2)
            .clamping(egui::SliderClamping::Never);
        hint(ui.add(slider).labelled_by(label.id), "Raising it brightens the dark values. 1 is linear.");
        display.gamma = display.gamma.clamp(*GAMMA_RANGE.start(), *GAMMA_RANGE.end());
        ui.end_row();
    });
}

const STRIP_POINTS: f32 = 9.0;
/// Number of colours in the strip.
const STEPS: usize = 192;

const LABELS_POINTS: f32 = 15.0;

#[derive(Debug, Clone, Copy)]
struct PlotGeometry {
    bars: Rect,
    strip: Rect,
    axis: Rangef,
}

impl PlotGeometry {
    fn new(rect: Rect, axis: Rangef) -> Self {
        // Margin for half a handle at each side.
        let inner = rect.shrink2(vec2(6.0, 0.0));
        let bottom = inner.bottom() - LABELS_POINTS;
        let strip = Rect::from_min_max(pos2(inner.left(), bottom - STRIP_POINTS), pos2(inner.right(), bottom));
        let bars = Rect::from_min_max(inner.min, pos2(inner.right(), strip.top() - 2.0));
        Self { bars, strip, axis }
    }

    fn x_of(&self, value: f32) -> f32 {
        let t = (value - self.axis.min) / self.axis.span();
        self.bars.left() + t.clamp(-0.05, 1.05) * self.bars.width()
    }

    fn value_at(&self, x: f32) -> f32 {
        self.axis.min + (x - self.bars.left()) / self.bars.width() * self.axis.span()
    }
}

/// Part of the range that the pointer is near or drags; it is drawn strong.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Grip {
    Min,
    Max,
    Both,
}

fn draw(
    ui: &Ui,
    painter: &Painter,
    geometry: &PlotGeometry,
    histogram: &Histogram,
    display: &Display,
    grip: Option<Grip>,
) {
    let visuals = ui.visuals();
    painter.rect_filled(geometry.bars.expand2(vec2(6.0, 0.0)), 3.0, visuals.extreme_bg_color);
    let (low, high) = (geometry.x_of(display.min), geometry.x_of(display.max));
    let inside = Rect::from_x_y_ranges(low..=high, geometry.bars.y_range()).intersect(geometry.bars);
    painter.rect_filled(inside, 0.0, visuals.selection.bg_fill.gamma_multiply(0.22));
    draw_bars(painter, geometry, histogram, display, visuals.text_color());
    // The strip of colours that values get, including the end colours beyond the range.
    let (strip, colours) = (geometry.strip, display.colours());
    strip_of_colours(painter, strip, STEPS, |_, middle| rgb(colours.colour(geometry.value_at(middle))));
    let outline = Stroke::new(1.0, visuals.weak_text_color().gamma_multiply(0.7));
    painter.rect_stroke(strip, 0.0, outline, StrokeKind::Outside);
    draw_labels(ui, painter, geometry);
    for (value, this) in [(display.min, Grip::Min), (display.max, Grip::Max)] {
        let (x, strong) = (geometry.x_of(value), grip == Some(this) || grip == Some(Grip::Both));
        let colour = if strong { visuals.strong_text_color() } else { visuals.selection.stroke.color };
        let stroke = Stroke::new(if strong { 2.0 } else { 1.5 }, colour);
        painter.vline(x, geometry.bars.top()..=strip.bottom(), stroke);
        let knob = Rect::from_center_size(pos2(x, strip.center().y), vec2(7.0, STRIP_POINTS + 5.0));
        painter.rect(knob, 3.0, visuals.widgets.active.bg_fill, stroke, StrokeKind::Inside);
    }
}

/// Bars on a logarithmic scale of counts; those outside the range are fainter.
fn draw_bars(painter: &Painter, geometry: &PlotGeometry, histogram: &Histogram, display: &Display, colour: Color32) {
    let most = histogram.counts.iter().copied().max().unwrap_or(0);
    if most == 0 {
        return;
    }
    let bars = geometry.bars;
    let scale = (bars.height() - 4.0) / (1.0 + most as f32).ln();
    let mut mesh = Mesh::default();
    for (i, &count) in histogram.counts.iter().enumerate().filter(|&(_, &count)| count > 0) {
        let (from, to) = histogram.bin_range(i);
        let centre = 0.5 * (from + to);
        let within = centre >= display.min && centre <= display.max;
        let height = (scale * (1.0 + count as f32).ln()).max(1.0);
        let left = geometry.x_of(from);
        let x_range = left..=geometry.x_of(to).max(left + 0.5);
        let rect = Rect::from_x_y_ranges(x_range, bars.bottom() - height..=bars.bottom());
        mesh.add_colored_rect(rect, colour.gamma_multiply(if within { 0.85 } else { 0.32 }));
    }
    painter.add(Shape::mesh(mesh));
}

fn draw_labels(ui: &Ui, painter: &Painter, geometry: &PlotGeometry) {
    let y = geometry.strip.bottom() + 3.0;
    let Rangef { min: low, max: high } = geometry.axis;
    let text = |x: f32, align: Align2, value: f32| small_text(ui, painter, pos2(x, y), align, &number(value, 3));
    text(geometry.bars.left(), Align2::LEFT_TOP, low);
    text(geometry.bars.right(), Align2::RIGHT_TOP, high);
    let zero = -low / (high - low);
    if (0.3..=0.7).contains(&zero) {
        text(geometry.x_of(0.0), Align2::CENTER_TOP, 0.0);
    }
}

/// Axis that contains all values and the display range, with a margin of 4 % of its length at each end.
fn axis_for(data_range: Option<(f32, f32)>, display: &Display) -> Rangef {
    let (low, high) = data_range.unwrap_or((display.min, display.max));
    let (low, high) = (low.min(display.min), high.max(display.max));
    let limit = low.abs().max(high.abs());
    let (low, high) = if display.symmetric { (-limit, limit) } else { (low, high) };
    let room = 0.04 * (high - low);
    Rangef::new(low - room, high + room)
}

/// Whether an axis can stay: it contains the display range and the values, and they fill more than 40 % of it.
fn axis_fits(axis: Rangef, data_range: Option<(f32, f32)>, display: &Display) -> bool {
    let needed = axis_for(data_range, display);
    let holds = |low: f32, high: f32| low >= axis.min && high <= axis.max;
    holds(display.min, display.max)
        && data_range.is_none_or(|(low, high)| holds(low, high))
        && needed.span() > 0.4 * axis.span()
}

const GRAB_POINTS: f32 = 9.0;

#[derive(Debug, Clone, Copy)]
struct Drag {
    grip: Grip,
    start: Display,
    start_value: f32,
}

fn dragged(drag: Drag, value: f32, axis: Rangef) -> Display {
    let Drag { grip, start, start_value } = drag;
    let value = value.clamp(axis.min, axis.max);
    let moved = value - start_value;
    // An end never passes the other one.
    let least = axis.span() * 1e-3;
    let narrower = |limit: f32| start.with_range(-limit.max(least), limit.max(least));
    match (grip, start.symmetric) {
        (Grip::Min, true) => narrower(-value),
        (Grip::Max, true) => narrower(value),
        // Moving a symmetric range as a whole would break its symmetry: it is widened or narrowed instead.
        (Grip::Both, true) => narrower(start.max + if start_value < 0.0 { -moved } else { moved }),
        (Grip::Min, false) => start.with_range(value.min(start.max - least), start.max),
        (Grip::Max, false) => start.with_range(start.min, value.max(start.min + least)),
        (Grip::Both, false) => start.with_range(start.min + moved, start.max + moved),
    }
}

fn grip_at(pointer: Pos2, geometry: &PlotGeometry, display: &Display) -> Option<Grip> {
    let (low, high) = (geometry.x_of(display.min), geometry.x_of(display.max));
    let (to_low, to_high) = ((pointer.x - low).abs(), (pointer.x - high).abs());
    let outside = pointer.x < low || pointer.x > high;
    // In a narrow range the middle third still grabs the whole range.
    let reach = if outside { GRAB_POINTS } else { GRAB_POINTS.min(0.34 * (high - low).max(3.0)) };
    if to_low.min(to_high) <= reach {
        Some(if to_low < to_high { Grip::Min } else { Grip::Max })
    } else {
        (!outside).then_some(Grip::Both)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_axis_stays_while_pictures_change_a_little() {
        let display = Display { min: 0.0, max: 0.1, ..Display::default() };
        let axis = axis_for(Some((0.01, 0.09)), &display);
        assert!(axis_fits(axis, Some((0.02, 0.095)), &display));
        assert!(!axis_fits(axis, Some((0.0, 0.2)), &display), "values outside must be seen");
        let narrow = Display { max: 0.001, ..display };
        assert!(!axis_fits(axis, Some((0.0, 0.001)), &narrow), "a range must not hide in a corner");
        let symmetric = axis_for(Some((-0.01, 0.05)), &Display::symmetric(0.02));
        assert_eq!(symmetric.min, -symmetric.max);
    }

    #[test]
    fn handles_move_their_end_and_the_middle_moves_both() {
        let start = Display { min: 0.2, max: 0.6, ..Display::default() };
        let range = |grip, from, to| {
            let d = dragged(Drag { grip, start, start_value: from }, to, Rangef::new(0.0, 1.0));
            ((d.min * 1e4).round() / 1e4, (d.max * 1e4).round() / 1e4)
        };
        assert_eq!(range(Grip::Min, 0.2, 0.3), (0.3, 0.6));
        assert_eq!(range(Grip::Max, 0.6, 0.9), (0.2, 0.9));
        assert_eq!(range(Grip::Both, 0.4, 0.5), (0.3, 0.7));
        assert_eq!(range(Grip::Min, 0.2, 0.9), (0.599, 0.6));
    }

    proptest! {
        #[test]
        fn dragging_anywhere_keeps_a_usable_range(
            min in -1f32..1.0, width in 0.001f32..2.0, symmetric in any::<bool>(), from in -2f32..2.0, to in -5f32..5.0, which in 0..3
        ) {
            let start = Display { symmetric, ..Display::default() }.with_range(min, min + width);
            let grip = [Grip::Min, Grip::Max, Grip::Both][which as usize];
            let end = dragged(Drag { grip, start, start_value: from }, to, axis_for(None, &start));
            prop_assert!(end.min < end.max && end.min.is_finite() && end.max.is_finite(), "{end:?}");
            prop_assert!(!symmetric || end.min == -end.max);
        }
    }
}
