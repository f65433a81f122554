//! Filter of the features: the number that pass, and the accepted ranges of slope, scale and response.

use crate::app::actions::{ActionId, Queue, button_ui};
use crate::app::project::Model;
use crate::app::project::filter::Interval;
use crate::detector::Feature;
use egui::{RichText, Ui};

/// Draws the bar.
pub fn filter_bar_ui(ui: &mut Ui, model: &mut Model, queue: &mut Queue) {
    let (total, listed) = (model.features().len(), model.listed.len());
    if total == 0 {
        ui.weak(if model.slots.a.found.is_some() { "No feature was found" } else { "No features yet" });
        return;
    }
    let text = if listed == total { format!("{total}") } else { format!("{listed} of {total}") };
    ui.label(text).on_hover_text("Features that pass the filter");
    let title = if model.filter.is_open() { RichText::new("Filter") } else { RichText::new("Filter (on)") };
    ui.menu_button(title, |ui| {
        ui.set_min_width(330.0);
        ranges_ui(ui, model);
        ui.separator();
        ui.checkbox(&mut model.filter.hide_slope_limit, "Hide features at the slope limit")
            .on_hover_text("Their slope is at the end of the searched range, so their true motion may lie beyond it");
        near_slope_ui(ui, model);
        ui.separator();
        button_ui(ui, model, queue, ActionId::ClearFilter, None);
    });
    let mut near = model.filter.near_slope.is_some();
    let tip = "Show only features within 0.5 px/frame of the shown slope";
    if ui.checkbox(&mut near, "At this slope").on_hover_text(tip).changed() {
        model.filter.near_slope = near.then_some(0.5);
    }
    if !model.filter.is_open() {
        button_ui(ui, model, queue, ActionId::ClearFilter, None);
    }
}

fn ranges_ui(ui: &mut Ui, model: &mut Model) {
    let found = model.slots.a.found.clone();
    let features: &[Feature] = found.as_ref().map_or(&[], |f| &f.detection.features);
    range_ui(ui, "Slope u", "px/frame", features, |f| f.slope.u, &mut model.filter.slope_u);
    range_ui(ui, "Slope v", "px/frame", features, |f| f.slope.v, &mut model.filter.slope_v);
    range_ui(ui, "Scale σ", "px", features, |f| f.sigma, &mut model.filter.sigma);
    range_ui(ui, "|Response|", "of full scale", features, |f| f.response.abs(), &mut model.filter.response);
}

/// Draws two handles over the range of the features' values; the whole range accepts all.
fn range_ui(
    ui: &mut Ui,
    label: &str,
    unit: &str,
    features: &[Feature],
    value: fn(&Feature) -> f32,
    interval: &mut Option<Interval>,
) {
    let (low, high) = features
        .iter()
        .map(value)
        .filter(|x| x.is_finite())
        .fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
    ui.horizontal(|ui| {
        let name = crate::app::panel::widgets::label_ui(ui, label, 70.0).on_hover_text(format!("{label}, {unit}"));
        if high <= low {
            ui.weak("all the same");
            return;
        }
        let set = interval.unwrap_or(Interval { min: low, max: high });
        let (mut min, mut max) = (set.min, set.max);
        ui.spacing_mut().slider_width = 140.0;
        let text = |x: f64, _: std::ops::RangeInclusive<usize>| crate::app::canvas::number(x as f32, 4);
        ui.add(egui::RangeSlider::new(&mut min, &mut max, low..=high).custom_formatter(text)).labelled_by(name.id);
        // The slider rounds what it shows; only the pointer moves it by more than that. A handle at its end accepts
        // everything beyond.
        let step = 0.002 * (high - low);
        if (min - set.min).abs() > step || (max - set.max).abs() > step {
            let min = if min - low <= step { low } else { min };
            let max = if high - max <= step { high } else { max };
            *interval = (min > low || max < high).then_some(Interval { min, max });
        }
    });
}

fn near_slope_ui(ui: &mut Ui, model: &mut Model) {
    let mut near = model.filter.near_slope.is_some();
    ui.horizontal(|ui| {
        if ui.checkbox(&mut near, "Only near the shown slope, within").changed() {
            model.filter.near_slope = near.then_some(0.5);
        }
        let mut limit = model.filter.near_slope.unwrap_or(0.5);
        let field = egui::DragValue::new(&mut limit).range(0.0..=100.0).speed(0.01).suffix(" px/frame");
        let response = ui.add_enabled(near, field);
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::SpinButton, near, "Distance in slope"));
        if response.changed() {
            model.filter.near_slope = Some(limit);
        }
    });
}
