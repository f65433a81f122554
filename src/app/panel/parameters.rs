//! Parameters of the detector: slopes, gate and number of features, and folded below them all others.

use crate::app::actions::{ActionId, Queue, button_ui, checked, enabled};
use crate::app::document::{Action, Panels, Side};
use crate::app::panel::cursor::mark_fields;
use crate::app::panel::parameter_rows as rows;
use crate::app::panel::widgets::{section_ui, weak_ui};
use crate::app::results::Read;
use crate::app::{parts, style};
use crate::detector::params::{Param, doc};
use crate::detector::{NoiseGate, SearchParams, SlopeFinding, SlopeGrid, Slopes};
use crate::teach::Part;
use egui::{Align, Layout, Rect, RichText, Ui};

/// Parameters that are always shown; all others are *Advanced*.
const BASIC: [Param<SearchParams>; 4] = [doc::SLOPES, doc::SLOPES_U, doc::SLOPES_V, doc::NOISE_GATE];

pub fn parameters_ui(ui: &mut Ui, model: Read<'_>, queue: &mut Queue) {
    section_ui(ui, "Detector", |ui| {
        ui.horizontal(|ui| {
            let presets = [ActionId::Preset1d, ActionId::Preset2d, ActionId::PresetSift];
            let on = presets.into_iter().find(|id| checked(*id, model) == Some(true));
            let name = on.map_or("Preset", |id| id.action().label.trim_start_matches("Preset "));
            ui.menu_button(format!("{name} ⏷"), |ui| {
                presets.into_iter().for_each(|id| crate::app::actions::menu::item_ui(ui, model, queue, id));
            });
            if enabled(ActionId::ResetParams, model) {
                ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                    button_ui(ui, model, queue, ActionId::ResetParams, Some("Reset all"));
                });
            }
        });
        ui.add_space(4.0);
        let error = model.results.slots.a.param_error.as_ref();
        let (grid, asked) = (model.grid_of(Side::A), &model.document.params);
        // Found slopes have no other default.
        let usual = if asked.slopes.is_auto() { grid } else { SlopeGrid::default() };
        let defaults = SearchParams { slopes: usual.into(), ..SearchParams::implied_by(asked.rules) };
        // The gate of the search whose features are shown, where it chose by itself.
        let found = model.found_of(Side::A).filter(|found| found.params.noise_gate == model.document.params.noise_gate);
        let chosen = found.filter(|found| !matches!(found.params.noise_gate, NoiseGate::Factor(_)));
        let note = chosen.map(|found| (doc::NOISE_GATE.name, format!("{:.2}", found.detection.noise_gate_factor)));
        let table = rows::ParamTable { error, defaults, frame_count: model.frame_count(), note };
        let search = SearchParams { slopes: grid.into(), ..asked.clone() };
        let mut rows = Rows { model, table, search, choice: asked.slopes };
        let is_found = |record: &Param<SearchParams>| {
            let has_fields = [doc::SLOPES_U, doc::SLOPES_V].contains(record);
            has_fields && asked.slopes.is_auto() && !parts::is_wanted(ui.ctx(), Part::parameter(record))
        };
        // Slopes that are found stand in words.
        for record in BASIC.into_iter().filter(|record| !is_found(record)).collect::<Vec<_>>() {
            rows.row_ui(ui, &record);
        }
        rows.advanced_ui(ui, queue);
        let Rows { mut search, choice, .. } = rows;
        if search.slopes == grid.into() {
            search.slopes = choice;
        }
        model.document.action_to(search).into_iter().for_each(|action| queue.push(action));
    });
}

/// Rows of the detector's parameters: those of `search`, whose grid is that in use, and the `choice` of its slopes.
struct Rows<'a> {
    model: Read<'a>,
    table: rows::ParamTable<'a, SearchParams>,
    search: SearchParams,
    choice: Slopes,
}

impl Rows<'_> {
    fn row_ui(&mut self, ui: &mut Ui, record: &Param<SearchParams>) {
        let top = ui.next_widget_position();
        ui.add_enabled_ui((record.in_use)(&self.search), |ui| {
            if *record == doc::SLOPES {
                self.slopes_ui(ui);
            } else {
                self.table.row(ui, record, &mut self.search);
            }
        });
        if [doc::SLOPES_U, doc::SLOPES_V].contains(record) {
            mark_fields(ui, Rect::from_min_max(top, ui.min_rect().right_bottom()), *record == doc::SLOPES_U);
        }
    }

    fn slopes_ui(&mut self, ui: &mut Ui) {
        let grid = self.model.grid_of(Side::A);
        let reset = (self.choice != Slopes::AUTO, |choice: &mut Slopes| *choice = Slopes::AUTO);
        self.table.row_with(ui, &doc::SLOPES, &mut self.choice, reset, |ui, choice, _| {
            let mut auto = choice.is_auto();
            if ui.checkbox(&mut auto, "Auto slopes").changed() {
                *choice = if auto { Slopes::AUTO } else { grid.into() };
            }
        });
        let finding = self.model.found_of(Side::A).and_then(|found| found.finding.as_ref());
        // Slopes that were found stand in the verdict, where it is drawn; why none were, as commands say it.
        let words = |finding: &SlopeFinding| match crate::app::panel::slopes::found_words(finding) {
            Some(found) => self.model.document.panels.hall.then_some(found),
            None => Some(finding.summary()),
        };
        if let Some(finding) = finding.filter(|_| self.choice.is_auto()).and_then(words) {
            weak_ui(ui, RichText::new(crate::inspect::words::capitalised(&finding)).small());
        }
    }

    /// Draws the folded parameters with the number of those that are not at their defaults. An error or a lesson that
    /// points at one of them opens the fold.
    fn advanced_ui(&mut self, ui: &mut Ui, queue: &mut Queue) {
        let Self { model, table, search, .. } = self;
        let changed = advanced().filter(|record| record.text(search) != record.text(&table.defaults)).count();
        let is_needed = |record: &Param<SearchParams>| {
            table.error.is_some_and(|error| error.subject == record.name)
                || parts::is_wanted(ui.ctx(), Part::parameter(record))
        };
        // Without an animation: a part that a lesson points at is in its place at once.
        if fold_ui(ui, *model, advanced().any(is_needed), changed, queue) {
            advanced().for_each(|record| self.row_ui(ui, record));
        }
    }
}

fn advanced() -> impl Iterator<Item = &'static Param<SearchParams>> {
    doc::ALL.iter().filter(|record| !BASIC.contains(record))
}

/// Draws the fold of the advanced parameters, of which `changed` are not at their defaults; returns whether it is open.
pub fn fold_ui(ui: &mut Ui, model: Read<'_>, is_needed: bool, changed: usize, queue: &mut Queue) -> bool {
    let is_open = model.document.panels.advanced || is_needed;
    let toggled = ui.horizontal(|ui| {
        let (_, icon) = ui.allocate_exact_size(egui::vec2(12.0, 14.0), egui::Sense::click());
        egui::collapsing_header::paint_default_icon(ui, if is_open { 1.0 } else { 0.0 }, &icon);
        let title = ui.selectable_label(false, "Advanced").on_hover_text("All other parameters");
        if changed > 0 {
            ui.label(RichText::new(format!("{changed} not the default")).small().color(style::warning(ui)))
                .on_hover_text("Open to see which; ↺ resets one");
        }
        title.clicked() || icon.clicked()
    });
    queue.push_if(toggled.inner, Action::SetPanels(Panels { advanced: !is_open, ..model.document.panels }));
    is_open
}
