//! Row of the cursor's panel, and the wheel that turns its values.

use crate::app::panel::widgets::{hint, label_ui};
use crate::app::words::{explained, word};
use crate::teach::Part;
use egui::{Response, Stroke, Ui, pos2, vec2};
use std::ops::RangeInclusive;

/// Row of the cursor's panel: a label, a slider with marks, and a field for the number.
pub struct CursorRow<'a> {
    pub label: &'a str,
    pub help: &'a str,
    pub range: RangeInclusive<f32>,
    pub marks: &'a [f32],
    pub whole: bool,
    /// Range of the slider beside the number, in the unit of the value; `None` without a slider.
    pub slides: Option<egui::Rangef>,
}

const LABEL_WIDTH: f32 = 52.0;
const VALUE_WIDTH: f32 = 58.0;

impl<'a> CursorRow<'a> {
    pub fn whole(label: &'a str, help: &'a str, range: RangeInclusive<f32>) -> Self {
        let slides = Some(egui::Rangef::new(*range.start(), *range.end()));
        Self { label, help, range, marks: &[], whole: true, slides }
    }

    /// Draws the row; returns whether `value` was changed.
    pub fn ui(self, ui: &mut Ui, value: &mut f32) -> bool {
        let before = *value;
        let row = ui.horizontal(|ui| {
            let entry = subject_of(self.label).1.and_then(word);
            let label = explained(label_ui(ui, self.label, LABEL_WIDTH), self.help, entry);
            let enabled = self.range.end() > self.range.start();
            let (low, high) = (*self.range.start(), *self.range.end());
            let span = if enabled { self.range.clone() } else { low..=low + 1.0 };
            ui.spacing_mut().slider_width = (ui.available_width() - VALUE_WIDTH - 10.0).max(40.0);
            ui.add_enabled_ui(enabled, |ui| {
                if let Some(slides) = self.slides {
                    let step = if self.whole { 1.0 } else { 0.0 };
                    let reached = if enabled { slides.into() } else { span.clone() };
                    // A value beyond is shown at the end, and stays until the slider is moved.
                    let slider = egui::Slider::new(value, reached.clone()).show_value(false).step_by(step);
                    let slider = slider.clamping(egui::SliderClamping::Edits);
                    let slider = hint(ui.add(slider).labelled_by(label.id), self.help);
                    let notches = if enabled { wheel_over(ui, &slider) } else { 0 };
                    *value = wheeled(*value, notches, self.marks, if self.whole { 1.0 } else { 0.01 * (high - low) })
                        .clamp(low, high.max(low));
                    marks_ui(ui, slider.rect, &reached, self.marks);
                }
                let speed = if self.whole { 0.05 } else { f64::from(high - low) / 600.0 };
                let mut field = egui::DragValue::new(value).range(span).speed(speed);
                field = field.fixed_decimals(if self.whole { 0 } else { 2 });
                let field = ui.add_sized(vec2(VALUE_WIDTH, ui.spacing().interact_size.y), field);
                hint(field.labelled_by(label.id), self.help);
            });
            if !enabled {
                *value = low;
            }
        });
        if let Some(part) = subject_of(self.label).0 {
            crate::app::parts::mark(ui, part, row.response.rect);
        }
        if self.whole {
            *value = value.round();
        }
        *value != before
    }
}

/// Notches by which the wheel was turned over a widget, upwards counted positive; nothing else scrolls by them.
pub fn wheel_over(ui: &Ui, response: &Response) -> i32 {
    /// Points of a trackpad's scrolling that count as a notch.
    const NOTCH: f32 = 40.0;
    if !response.contains_pointer() {
        return 0;
    }
    let turned = ui.input_mut(|input| {
        // What is turned in this pass is scrolled by in this and the next ones.
        input.smooth_scroll_delta = egui::Vec2::ZERO;
        let notches = input.events.iter().filter_map(|event| match event {
            egui::Event::MouseWheel { unit: egui::MouseWheelUnit::Point, delta, .. } => Some(delta.y / NOTCH),
            egui::Event::MouseWheel { delta, .. } => Some(delta.y),
            _ => None,
        });
        notches.sum::<f32>()
    });
    let id = response.id.with("wheel");
    let rest = turned + ui.data(|data| data.get_temp::<f32>(id)).unwrap_or_default();
    ui.data_mut(|data| data.insert_temp(id, rest.fract()));
    rest.trunc() as i32
}

/// The value that lies so many marks, or steps where there are none, above `value`.
fn wheeled(value: f32, notches: i32, marks: &[f32], step: f32) -> f32 {
    const SAME: f32 = 1e-4;
    if marks.len() < 2 {
        return value + step * notches as f32;
    }
    (0..notches.abs()).fold(value, |at, _| match notches > 0 {
        true => marks.iter().copied().filter(|mark| *mark > at + SAME).fold(f32::INFINITY, f32::min),
        false => marks.iter().copied().filter(|mark| *mark < at - SAME).fold(f32::NEG_INFINITY, f32::max),
    })
}

/// Part of the window, and entry of the glossary, of the row with this label.
fn subject_of(label: &str) -> (Option<Part>, Option<&'static str>) {
    match label {
        "Frame" => (Some(Part::Frame), Some("frame")),
        "Frames" => (None, Some("frame")),
        "Slope u" => (Some(Part::SlopeU), Some("slope")),
        "Slope v" => (Some(Part::SlopeV), Some("slope")),
        "Octave" => (Some(Part::Octave), Some("octave")),
        "Level" => (Some(Part::Level), Some("level")),
        _ => (None, None),
    }
}

/// Range of the handle's centre on the slider of a [`CursorRow`] drawn here, and the width of the row, in points.
pub fn slider_track(ui: &Ui) -> (egui::Rangef, f32) {
    let spacing = ui.spacing();
    let width = ui.available_width();
    let left = ui.cursor().left() + LABEL_WIDTH + spacing.item_spacing.x;
    let slider = (width - LABEL_WIDTH - spacing.item_spacing.x - VALUE_WIDTH - 10.0).max(40.0);
    let handle = spacing.interact_size.y / 2.5;
    (egui::Rangef::new(left, left + slider).shrink(handle), width)
}

fn marks_ui(ui: &Ui, rect: egui::Rect, range: &RangeInclusive<f32>, marks: &[f32]) {
    // Range of the handle's centre: the slider keeps its handle inside.
    let x_range = rect.x_range().shrink(rect.height() / 2.5);
    let (low, high) = (*range.start(), *range.end());
    let points_per_mark = x_range.span() / marks.len().max(1) as f32;
    if high <= low || points_per_mark < 2.5 {
        return;
    }
    let colour = ui.visuals().weak_text_color();
    for &mark in marks.iter().filter(|m| (low..=high).contains(*m)) {
        let x = egui::lerp(x_range, (mark - low) / (high - low));
        let y = rect.bottom();
        ui.painter().line_segment([pos2(x, y - 2.5), pos2(x, y + 1.5)], Stroke::new(1.0, colour));
    }
}
