//! Histogram of a picture, and the settings with which its values are shown: range, colour map, gamma.
//!
//! The range changes only by hand, so that pictures can be compared; the axis stays as long as range and values fit on
//! it.

mod plot;

use crate::app::canvas::overlay::rgb;
use crate::app::canvas::{Picture, number};
use crate::app::gpu::PictureId;
use crate::app::memo::Memo;
use crate::app::panel::widgets::{hint, strip_of_colours};
use crate::app::words::choices;
use crate::inspect::words::counted;
use crate::plane::display::{ColourMap, Display, GAMMA_RANGE};
use crate::plane::statistics::{Histogram, Region, histogram, percentiles, summary};
use egui::{CursorIcon, DragValue, Rangef, Rect, Response, Sense, Slider, Ui, vec2};
use plot::{Drag, Grip, PlotGeometry, axis_fits, axis_for, dragged, grip_at};

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

fn full_range(picture: &Picture) -> Option<(f32, f32)> {
    summary(&picture.drawn, &Region::whole(&picture.drawn)).range()
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
            plot::draw(ui, &ui.painter_at(rect), &geometry, &counts, display, grip);
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
        let data_range = *self.data_range.get(picture.id, || full_range(picture));
        // While a handle is dragged the axis stays.
        let axis = match self.axis {
            Some(axis) if self.drag.is_some() || axis_fits(axis, data_range, display) => axis,
            _ => axis_for(data_range, display),
        };
        self.axis = Some(axis);
        let whole = Region::whole(&picture.drawn);
        let counted = || histogram(&picture.drawn, &whole, axis.min, axis.max, BINS);
        (axis, self.counts.get((picture.id, axis), counted).clone())
    }

    fn drag_handles(&mut self, response: &Response, geometry: &PlotGeometry, display: &mut Display) -> Option<Grip> {
        if response.drag_started()
            && let Some(pointer) = response.interact_pointer_pos()
        {
            // The place of the press, not that where the drag was recognised, decides what is grabbed.
            let press = pointer - response.total_drag_delta().unwrap_or_default();
            let grip = grip_at(press, geometry, display);
            // A press outside the range moves its nearer end.
            let end = if press.x < geometry.x_of(display.min) { Grip::Min } else { Grip::Max };
            let grip = grip.unwrap_or(end);
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
            let button = ui.button("0 – 1").on_hover_text("The full scale of the file: from black to saturated.");
            if button.clicked() {
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
        let slider = ui.add(slider).labelled_by(label.id);
        hint(slider, "Raising it brightens the dark values. 1 is linear.");
        display.gamma = display.gamma.clamp(*GAMMA_RANGE.start(), *GAMMA_RANGE.end());
        ui.end_row();
    });
}
