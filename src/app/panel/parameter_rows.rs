//! Row of a parameter, made from its record: its name, its editor, and the button that resets it.

use crate::app::panel::widgets::{error_ui, hint};
use crate::detector::params::{Drag, Field, Param, ParamDoc};
use crate::detector::{Distinct, FrameRange, NoiseGate, SlopeAxis};
use crate::error::Error;
use crate::teach::glossary::glossary;
use egui::{Align, DragValue, Id, Layout, RichText, Ui, vec2};

const LABEL_WIDTH: f32 = 106.0;

pub struct ParamTable<'a, P> {
    pub error: Option<&'a Error>,
    pub defaults: P,
    pub frame_count: usize,
    /// Name of a parameter, and a note beside its value.
    pub note: Option<(&'static str, String)>,
}

impl<P: Clone> ParamTable<'_, P> {
    /// Draws the row of one parameter: its name and unit, editor, reset button and error; greyed out without an effect.
    pub fn row(&self, ui: &mut Ui, record: &Param<P>, params: &mut P) {
        let default = record.text(&self.defaults);
        let differs = record.text(params) != default;
        let reset = |params: &mut P| record.read(params, &default).expect("a record reads what it writes");
        self.row_with(ui, record, params, (differs, reset), |ui, params, label| {
            field_ui(ui, (record.field)(params), &record.drag, label, self.frame_count);
            if let Some((_, note)) = self.note.as_ref().filter(|(name, _)| *name == record.name) {
                ui.weak(note);
            }
        });
    }

    /// Draws a row with an editor of its own; where the value `differs` from the default, a button applies `reset`.
    pub fn row_with<V>(
        &self,
        ui: &mut Ui,
        record: &Param<P>,
        value: &mut V,
        (differs, reset): (bool, impl FnOnce(&mut V)),
        editor: impl FnOnce(&mut Ui, &mut V, Id),
    ) {
        let wrong = self.error.filter(|e| e.subject == record.name);
        let row = ui.horizontal(|ui| {
            let label = label_ui(ui, record, wrong.is_some());
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                let name = format!("Reset {}", record.label);
                let button = egui::Button::new(RichText::new("↺").weak()).frame(false).min_size(vec2(14.0, 0.0));
                let response = ui.add_visible(differs, button);
                response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, differs, &name));
                if response.on_hover_text(format!("{name} to its default")).clicked() {
                    reset(value);
                }
                ui.with_layout(Layout::left_to_right(Align::Center), |ui| editor(ui, value, label.id));
            });
        });
        crate::app::parts::mark(ui, crate::teach::Part::parameter(record), row.response.rect);
        if let Some(error) = wrong {
            error_ui(ui, RichText::new(format!("{}: {}", error.problem, error.remedy)).small());
        }
    }
}

fn field_ui(ui: &mut Ui, field: Field<'_>, drag: &Drag, label: Id, frame_count: usize) {
    match field {
        Field::F32(x) => number_ui(ui, dragged(DragValue::new(x).max_decimals(drag.decimals), drag), label),
        Field::U32(n) => number_ui(ui, dragged(DragValue::new(n), drag), label),
        Field::I32(n) => number_ui(ui, dragged(DragValue::new(n), drag), label),
        Field::Usize(n) => number_ui(ui, dragged(DragValue::new(n), drag), label),
        Field::U64(n) => number_ui(ui, dragged(DragValue::new(n), drag), label),
        Field::Flag(flag) => _ = ui.checkbox(flag, "").labelled_by(label),
        Field::Word(word) => {
            let mut chosen = word.word();
            choice_ui(ui, &mut chosen, label, word.words());
            word.set_word(chosen);
        }
        Field::Axis(axis) => axis_ui(ui, axis, label),
        Field::Frames(frames) => frames_ui(ui, frames, label, frame_count),
        Field::Gate(gate) => gate_ui(ui, gate, drag, label),
        Field::Distinct(distinct) => distinct_ui(ui, distinct, drag, label),
        // Panels with such values have editors of their own.
        Field::Text(_) | Field::Slopes(..) => {}
    }
}

/// Field for a number with the record's speed, suffix and word for 0.
fn dragged<'a>(field: DragValue<'a>, drag: &Drag) -> DragValue<'a> {
    let field = field.speed(drag.speed).suffix(drag.suffix);
    let (Some(word), decimals) = (drag.zero, drag.decimals) else { return field };
    // A value that would be shown as 0 is 0.
    let least = 0.5 * 0.1f64.powi(decimals as i32);
    field
        .custom_formatter(move |n, _| if n < least { word.to_owned() } else { format!("{n:.decimals$}") })
        .custom_parser(move |text| if text.trim() == word { Some(0.0) } else { text.trim().parse().ok() })
}

pub fn label_ui(ui: &mut Ui, doc: &ParamDoc, wrong: bool) -> egui::Response {
    let size = vec2(LABEL_WIDTH, ui.spacing().interact_size.y);
    let help = format!("{}\n--{}", doc.help(), doc.name);
    ui.allocate_ui_with_layout(size, egui::Layout::top_down(egui::Align::Min), |ui| {
        ui.set_width(LABEL_WIDTH);
        ui.spacing_mut().item_spacing.y = -1.0;
        let text = RichText::new(doc.label);
        let text = if wrong { text.color(ui.visuals().error_fg_color) } else { text };
        let label = ui.add(egui::Label::new(text).truncate());
        let label = crate::app::words::explained(label, &help, glossary().of_parameter(doc.name));
        if !doc.unit.is_empty() {
            ui.add(egui::Label::new(RichText::new(doc.unit).small().weak()).truncate()).on_hover_text(&help);
        }
        label
    })
    .inner
}

fn number_ui(ui: &mut Ui, field: DragValue<'_>, label: Id) {
    ui.add_sized(vec2(66.0, ui.spacing().interact_size.y), field).labelled_by(label);
}

fn choice_ui<T: PartialEq + Copy>(ui: &mut Ui, value: &mut T, label: Id, names: &[(T, &str)]) {
    let chosen = names.iter().find(|(v, _)| v == value).map_or("", |(_, name)| name);
    let list = egui::ComboBox::from_id_salt(label).selected_text(chosen).width(86.0);
    let shown = list.show_ui(ui, |ui| {
        for (choice, name) in names {
            ui.selectable_value(value, *choice, *name);
        }
    });
    shown.response.labelled_by(label);
}

fn axis_ui(ui: &mut Ui, axis: &mut SlopeAxis, label: Id) {
    ui.spacing_mut().item_spacing.x = 3.0;
    // Three fields and the texts between them share the space.
    let width = ((ui.available_width() - 24.0) / 3.0).clamp(28.0, 46.0);
    let size = vec2(width, ui.spacing().interact_size.y);
    ui.spacing_mut().button_padding.x = 3.0;
    let step = axis.step();
    let tip = if step > 0.0 { format!("A step of {step:.3} px/frame") } else { "A single slope".to_owned() };
    let number = |value| DragValue::new(value).speed(0.05).max_decimals(2);
    hint(ui.add_sized(size, number(&mut axis.min)).labelled_by(label), format!("Min. {tip}"));
    ui.weak("…");
    hint(ui.add_sized(size, number(&mut axis.max)).labelled_by(label), format!("Max. {tip}"));
    let count = DragValue::new(&mut axis.count).speed(0.05).prefix("× ");
    hint(ui.add_sized(size, count).labelled_by(label), format!("Number of slopes. {tip}"));
}

fn frames_ui(ui: &mut Ui, frames: &mut Option<FrameRange>, label: Id, frame_count: usize) {
    ui.spacing_mut().item_spacing.x = 3.0;
    let mut all = frames.is_none();
    if ui.checkbox(&mut all, "All").changed() {
        *frames = (!all).then_some(FrameRange { start: 0, end: frame_count.max(1) });
    }
    if let Some(range) = frames {
        let size = vec2(34.0, ui.spacing().interact_size.y);
        let number = |value| DragValue::new(value).speed(0.05);
        let start = ui.add_sized(size, number(&mut range.start)).labelled_by(label);
        start.on_hover_text("First frame used, counted from 0");
        ui.weak("..");
        ui.add_sized(size, number(&mut range.end)).labelled_by(label).on_hover_text("One past the last frame used");
    }
}

fn gate_ui(ui: &mut Ui, gate: &mut NoiseGate, drag: &Drag, label: Id) {
    /// First value when switching to a factor: about that of the automatic gate for a small search.
    const FIRST_FACTOR: f32 = 4.5;
    let mut factor = if let NoiseGate::Factor(factor) = gate { *factor } else { FIRST_FACTOR };
    let names = [
        (NoiseGate::Auto, "Auto"),
        (NoiseGate::Matching, "Matching"),
        (NoiseGate::Strict, "Strict"),
        (NoiseGate::Factor(factor), "Factor"),
    ];
    choice_ui(ui, gate, label, &names);
    if let NoiseGate::Factor(_) = gate {
        narrow_ui(ui, &mut factor, drag, label);
        *gate = NoiseGate::Factor(factor);
    }
}

fn distinct_ui(ui: &mut Ui, distinct: &mut Distinct, drag: &Drag, label: Id) {
    let mut on = *distinct != Distinct::Off;
    if ui.checkbox(&mut on, "On").changed() {
        *distinct = if on { Distinct::default() } else { Distinct::Off };
    }
    if let Distinct::Radius(radius) = distinct {
        narrow_ui(ui, radius, drag, label);
    }
}

fn narrow_ui(ui: &mut Ui, value: &mut f32, drag: &Drag, label: Id) {
    let field = dragged(DragValue::new(value).max_decimals(drag.decimals), drag);
    ui.add_sized(vec2(48.0, ui.spacing().interact_size.y), field).labelled_by(label);
}
