//! The form of a study: a row for each setting that its question asks for, made from the record of the setting.

use crate::app::document::{Lab, LabQuestion};
use crate::app::panel::widgets::name_field;
use crate::recover::{Contrast, Shape, bounds};
use crate::synth::Motion;
use egui::{DragValue, Grid, Id, TextEdit, Ui};
use std::ops::RangeInclusive;

struct Setting {
    label: &'static str,
    /// Text after a number.
    unit: &'static str,
    help: &'static str,
    /// Numbers that it takes.
    range: RangeInclusive<f64>,
    is_asked: fn(LabQuestion) -> bool,
    value: fn(&mut Lab) -> Value<'_>,
}

enum Value<'a> {
    Usize(&'a mut usize),
    U64(&'a mut u64),
    /// Number, with the change for a point of dragging, and the decimals.
    F64(&'a mut f64, f64, usize),
    Ends(&'a mut RangeInclusive<f64>),
    /// Number that may be left open, and its first value where it is given.
    Maybe(&'a mut Option<f64>, f64),
    Text(&'a mut String),
    Flag(&'a mut bool),
    Motion(&'a mut Motion),
    Shape(&'a mut Shape),
    Contrast(&'a mut Contrast),
}
use Value::{Ends, F64, Flag, Maybe, Text, U64, Usize};

macro_rules! settings {
    ($($label:literal, $unit:literal, $range:expr, $is_asked:expr, $value:expr; $help:literal;)+) => {
        vec![$(Setting { label: $label, unit: $unit, help: $help, range: $range, is_asked: $is_asked, value: $value }),+]
    };
}

/// Records of all settings, in the order of the form.
fn settings() -> Vec<Setting> {
    const ANY: RangeInclusive<f64> = 0.0..=f64::MAX;
    let (charts, planted) = (LabQuestion::needs_charts, |question| question == LabQuestion::InBurst);
    let of_frames = |question: LabQuestion| question.needs_charts() && !question.counts_frames();
    settings! {
        "Numbers", "", ANY, LabQuestion::counts_frames, |lab| Text(&mut lab.counts_text);
        "Numbers of frames, separated by commas; of the open burst the middle frames are taken";
        "SNR", "", ANY, charts, |lab| Text(&mut lab.snrs_text);
        "Ratios of signal to noise of one pixel in one frame, separated by commas";
        "Charts", " each", 1.0..=1000.0, charts, |lab| U64(&mut lab.seeds);
        "Charts per ratio; more give smoother curves and smaller errors";
        "First seed", "", ANY, charts, |lab| U64(&mut lab.first_seed);
        "Seed of the first chart; those of the others count up from it";
        "Discs", "", 1.0..=2000.0, charts, |lab| Usize(&mut lab.chart.discs);
        "Discs per chart";
        "Radius", " px", 0.5..=200.0, charts, |lab| Ends(&mut lab.chart.radius);
        "Min and max radius of the discs, pixels";
        "Contrast", "", 0.0..=8.0, charts, |lab| F64(&mut lab.chart.contrast, 0.01, 2);
        "Intensity of a disc over that of the background; above 1 is brighter";
        "Frames", "", 2.0..=200.0, of_frames, |lab| Usize(&mut lab.chart.frames);
        "Frames of a burst";
        "Max slope", " px/frame", 0.0..=30.0, charts, |lab| F64(&mut lab.chart.max_slope, 0.05, 2);
        "Discs move with slopes up to this in both directions, px/frame";
        "Motion", "", ANY, charts, |lab| Value::Motion(&mut lab.chart.motion);
        "Whether discs move horizontally only, or in any direction";
        "Width", " px", 64.0..=4096.0, charts, |lab| Usize(&mut lab.chart.width);
        "Columns of a frame";
        "Height", " px", 64.0..=4096.0, charts, |lab| Usize(&mut lab.chart.height);
        "Rows of a frame";
        "Shape", "", ANY, planted, |lab| Value::Shape(&mut lab.planted.shape);
        "Discs of even brightness, or Gaussian blobs of σ = radius/√2";
        "Contrast", "", ANY, planted, |lab| Value::Contrast(&mut lab.planted.contrast);
        "Brighter or darker than what is around them";
        "At radius", " px", bounds::RADIUS.span(), planted, |lab| F64(&mut lab.planted.at_radius, 0.1, 1);
        "Radius at which SNRs and slopes are varied";
        "At SNR", "", bounds::SNR.span(), planted, |lab| Maybe(&mut lab.planted.at_snr, 1.0);
        "SNR of one pixel in one frame at which slopes and sizes are varied; otherwise 1.7 times the SNR at which half are expected to be found";
        "Copies", "", bounds::COPIES.span(), planted, |lab| U64(&mut lab.planted.copies);
        "Copies of the burst, each with other things; more give smaller errors";
        "First seed", "", ANY, planted, |lab| U64(&mut lab.planted.first_seed);
        "Seed of the first copy; the next copies count up from it";
        "Inside", "", ANY, planted, |lab| Flag(&mut lab.planted.inside);
        "Plant only where a thing stays inside the picture in all frames";
        "On features", "", ANY, planted, |lab| Flag(&mut lab.planted.on_features);
        "Plant on strong features of the burst too; otherwise they are left alone";
    }
}

pub fn form_ui(ui: &mut Ui, lab: &mut Lab) {
    Grid::new("lab form").num_columns(2).show(ui, |ui| {
        let question = lab.question;
        for setting in settings().into_iter().filter(|setting| (setting.is_asked)(question)) {
            let label = ui.label(setting.label).on_hover_text(setting.help).id;
            ui.horizontal(|ui| setting.value_ui(ui, (setting.value)(lab), label)).response.on_hover_text(setting.help);
            ui.end_row();
        }
    });
    let tip = "Chart of the published measurements: 90 discs, 10 frames of 800 × 600";
    if lab.question.needs_charts() && ui.button("Published chart").on_hover_text(tip).clicked() {
        lab.chart = crate::synth::ChartParams::default();
    }
}

impl Setting {
    fn value_ui(&self, ui: &mut Ui, value: Value<'_>, label: Id) {
        let number_ui = |ui: &mut Ui, field: DragValue<'_>| {
            ui.add(field.range(self.range.clone()).suffix(self.unit)).labelled_by(label).changed()
        };
        match value {
            Usize(n) => _ = number_ui(ui, DragValue::new(n)),
            U64(n) => _ = number_ui(ui, DragValue::new(n)),
            F64(x, speed, decimals) => _ = number_ui(ui, DragValue::new(x).speed(speed).max_decimals(decimals)),
            Ends(ends) => {
                let (mut least, mut most) = (*ends.start(), *ends.end());
                let first = number_ui(ui, DragValue::new(&mut least).speed(0.1).max_decimals(1));
                ui.label("to");
                if number_ui(ui, DragValue::new(&mut most).speed(0.1).max_decimals(1)) || first {
                    *ends = least.min(most)..=least.max(most);
                }
            }
            Maybe(value, first) => {
                let mut has_own = value.is_some();
                if ui.checkbox(&mut has_own, "").labelled_by(label).changed() {
                    *value = has_own.then_some(first);
                }
                value.iter_mut().for_each(|x| _ = number_ui(ui, DragValue::new(x).speed(0.01).max_decimals(2)));
            }
            Text(text) => {
                let response = ui.add(TextEdit::singleline(text).desired_width(130.0)).labelled_by(label);
                name_field(&response, self.label, text);
            }
            Flag(flag) => _ = ui.checkbox(flag, "").labelled_by(label),
            Value::Motion(motion) => choice_ui(ui, motion, &[(Motion::OneD, "1D"), (Motion::TwoD, "2D")]),
            Value::Shape(shape) => choice_ui(ui, shape, &[(Shape::Disc, "Discs"), (Shape::Blob, "Blobs")]),
            Value::Contrast(contrast) => {
                let names = [(Contrast::Bright, "Bright"), (Contrast::Dark, "Dark"), (Contrast::Both, "Both")];
                choice_ui(ui, contrast, &names);
            }
        }
    }
}

fn choice_ui<T: PartialEq + Copy>(ui: &mut Ui, value: &mut T, names: &[(T, &str)]) {
    for (choice, name) in names {
        ui.selectable_value(value, *choice, *name);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_settings_of_a_question_have_different_labels_and_their_defaults_are_in_range() {
        let mut lab = Lab::default();
        for question in LabQuestion::ALL {
            let [name, _] = question.words();
            let asked: Vec<Setting> = settings().into_iter().filter(|one| (one.is_asked)(question)).collect();
            assert!(!asked.is_empty(), "{name}");
            for (index, Setting { label, range, value, .. }) in asked.iter().enumerate() {
                assert!(asked[..index].iter().all(|one| one.label != *label), "{name}: {label}");
                let number = match value(&mut lab) {
                    Usize(n) => *n as f64,
                    U64(n) => *n as f64,
                    F64(x, ..) => *x,
                    Ends(ends) => *ends.start(),
                    _ => continue,
                };
                assert!(range.contains(&number), "{name}: {label} {number}");
            }
        }
    }
}
