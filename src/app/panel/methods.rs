//! Methods that are compared: how their panes are laid out, their gold standards, and the table of their numbers.

use crate::app::actions::{ActionId, Queue, button_ui};
use crate::app::document::panes::Change;
use crate::app::document::{Action, MethodId, Side};
use crate::app::pane::{MethodsPreset, Over};
use crate::app::panel::table::{ROW_HEIGHT, cell_ui, striped_table};
use crate::app::panel::widgets::{in_time, label_ui, progress_text, progress_ui, section_ui};
use crate::app::results::{PAIR_NUMBERS, Read};
use crate::evaluate::curves::percent;
use crate::export::{Cell, Table};
use egui::{RichText, Ui};
use egui_extras::Column;

pub fn controls_ui(ui: &mut Ui, model: Read<'_>, queue: &mut Queue) {
    section_ui(ui, "Compare", |ui| {
        layout_ui(ui, model, queue);
        if let Some(over) = model.document.panes.over(model.document.focus()) {
            two_ui(ui, model, over, queue);
        }
        let mut look = model.document.methods.clone();
        if let Some(rate) = &model.document.methods.same_false_rate {
            let text = format!("At {} false on charts of SNR {}", percent(rate.false_fraction), rate.snr);
            let tip = "Each method has the peak threshold at which this share of its detections on the Lab's charts is false. \
                       Untick it for the peak threshold of the search";
            if ui.checkbox(&mut true, text).on_hover_text(tip).changed() {
                look.same_false_rate = None;
            }
        }
        queue.edit(model.document, Action::SetMethods(look));
        gold_ui(ui, model, queue);
        if let Some((method, running)) = model.results.compare.running() {
            progress_ui(ui, &running, None, &format!("{}: {}", method.label(), progress_text(&running)));
            button_ui(ui, model, queue, ActionId::Cancel, None);
        } else if MethodId::ALL.iter().any(|method| model.results.compare.problem(*method).is_some()) {
            button_ui(ui, model, queue, ActionId::CompareAgain, Some("Try again"));
        }
    });
}

fn layout_ui(ui: &mut Ui, model: Read<'_>, queue: &mut Queue) {
    let has_second = model.burst_of(Side::B).is_some();
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 2.0;
        for preset in MethodsPreset::ALL {
            let ([name, help], enabled) = (preset.words(), preset != MethodsPreset::Matches || has_second);
            let button = ui.add_enabled(enabled, egui::Button::new(name)).on_hover_text(help);
            let response = button.on_disabled_hover_text("Matches need a second burst: open one as B");
            queue.push_if(response.clicked(), Action::ChangePanes(Change::LayOutMethods(preset)));
        }
    });
}

fn two_ui(ui: &mut Ui, model: Read<'_>, over: Over, queue: &mut Queue) {
    let methods_shown = model.methods_shown();
    for (id, name) in [(model.document.focus(), "Left"), (over.other(), "Right")] {
        let Some(before) = model.pane(id).and_then(|pane| pane.method) else { continue };
        let mut chosen = before;
        ui.horizontal(|ui| {
            let label = label_ui(ui, name, 52.0);
            let list = egui::ComboBox::from_id_salt(("method", name)).selected_text(chosen.label());
            let list = list.width(ui.available_width() - 8.0).show_ui(ui, |ui| {
                for method in &methods_shown {
                    ui.selectable_value(&mut chosen, *method, method.label()).on_hover_text(method.words()[1]);
                }
            });
            list.response.labelled_by(label.id);
        });
        queue.set(&before, chosen, |method| Action::SetMethod(id, method));
    }
    if matches!(over, Over::Flip { .. }) {
        button_ui(ui, model, queue, ActionId::Flip, None);
    }
}

fn gold_ui(ui: &mut Ui, model: Read<'_>, queue: &mut Queue) {
    ui.horizontal(|ui| {
        ui.weak("Gold standard");
        for (side, id) in [(Side::A, ActionId::OpenGoldA), (Side::B, ActionId::OpenGoldB)] {
            let mark = if model.results.compare.gold[side].is_some() { " ✔" } else { "…" };
            button_ui(ui, model, queue, id, Some(&format!("{}{mark}", side.name())));
        }
    });
}

const OF_SEARCH: [(&str, &str); 3] = [
    ("Features A", "Features found in A"),
    ("Features B", "Features found in B"),
    ("SNR", "Median of |response| over the noise of the DoG, of A's features"),
];

fn columns() -> impl Iterator<Item = (&'static str, &'static str)> {
    let of_pair = PAIR_NUMBERS.map(|(name, help, _)| (name, help));
    OF_SEARCH.into_iter().chain(of_pair).chain([("Time", "Wall-clock time of the detection in A")])
}

pub fn table_ui(ui: &mut Ui, model: Read<'_>, queue: &mut Queue) {
    ui.spacing_mut().item_spacing.x = 4.0;
    let mut look = model.document.methods.clone();
    egui::ScrollArea::horizontal().auto_shrink(false).show(ui, |ui| {
        striped_table(ui)
            .column(Column::exact(116.0))
            .columns(Column::remainder().at_least(55.0), columns().count())
            .header(20.0, |mut header| {
                header.col(|ui| cell_ui(ui, RichText::new("Method").small(), true));
                for (name, help) in columns() {
                    let (_, cell) = header.col(|ui| cell_ui(ui, RichText::new(name).small(), false));
                    cell.on_hover_text(help);
                }
            })
            .body(|mut body| {
                for method in MethodId::ALL {
                    body.row(ROW_HEIGHT, |mut row| {
                        row.col(|ui| {
                            let usable = model.method_burst(method, Side::A).is_some();
                            let mut on = model.document.methods.shows(method);
                            let tip = if usable { method.words()[1] } else { "Open a sharp image of A's view first" };
                            ui.spacing_mut().interact_size.y = ROW_HEIGHT;
                            let response = ui.add_enabled(usable, egui::Checkbox::new(&mut on, method.label()));
                            if response.on_hover_text(tip).on_disabled_hover_text(tip).changed() {
                                look.show(method, on);
                            }
                        });
                        for text in cells(model, method) {
                            row.col(|ui| cell_ui(ui, RichText::new(text).monospace(), false));
                        }
                    });
                }
            });
    });
    queue.edit(model.document, Action::SetMethods(look));
}

fn cells(model: Read<'_>, method: MethodId) -> Vec<String> {
    let found = |side| model.method_found(method, side);
    let or_dash = |text: Option<String>| text.unwrap_or_else(|| "–".to_owned());
    let count = |side| found(side).map(|f| f.detection.features.len().to_string());
    let counts = model.method_matches(method).map(|m| m.result.counts);
    let is_running = model.results.compare.running().is_some_and(|(running, _)| running == method);
    let failed = || model.results.compare.problem(method).map(|_| "failed".to_owned());
    let state = is_running.then(|| "…".to_owned()).or_else(failed);
    let snr = found(Side::A).and_then(|f| {
        let mut snrs: Vec<f32> = f.detection.features.iter().map(|f| f.snr).collect();
        snrs.sort_by(f32::total_cmp);
        snrs.get(snrs.len() / 2).map(|median| format!("{median:.1}"))
    });
    let of_pair = PAIR_NUMBERS.map(|(.., of)| counts.map(|counts| of.text(&counts)));
    let time = |time: String| time.strip_prefix(" in ").unwrap_or("kept").to_owned();
    let time = found(Side::A).map(|f| time(in_time(f.elapsed)));
    let of_search = [count(Side::A).or(state), count(Side::B), snr];
    of_search.into_iter().chain(of_pair).chain([time]).map(or_dash).collect()
}

pub fn methods_table(model: Read<'_>) -> Table {
    let cell = |text: String| match text.parse() {
        Ok(number) => Cell::Number(number, text.split_once('.').map_or(0, |(_, decimals)| decimals.len())),
        Err(_) if text == "–" => Cell::Missing,
        Err(_) => Cell::Text(text),
    };
    let row = |method: MethodId| {
        std::iter::once(method.label().into()).chain(cells(model, method).into_iter().map(cell)).collect()
    };
    let names: Vec<&str> = std::iter::once("Method").chain(columns().map(|(name, _)| name)).collect();
    Table::new("Methods", &names.join(","), model.methods_shown().into_iter().map(row).collect())
}
