//! Status bar: the value under the pointer, the last note, the open burst.

use crate::app::actions::{ActionId, Queue};
use crate::app::panel::widgets::progress_text;
use crate::app::project::Model;
use crate::app::project::workspace::Workspace;
use egui::{Align, Label, Layout, RichText, Ui};

/// Draws the status bar.
pub fn status_ui(ui: &mut Ui, model: &Model, readout: Option<&str>, queue: &mut Queue) {
    ui.horizontal(|ui| {
        let hint = if model.slots.a.burst.is_some() { "Point at the picture to read values" } else { "" };
        let text = readout.unwrap_or(hint);
        let width = if model.panes.are_many() { 460.0 } else { 330.0 };
        ui.allocate_ui_with_layout(egui::vec2(width, 18.0), Layout::left_to_right(Align::Center), |ui| {
            ui.set_min_width(width);
            let text = RichText::new(text);
            let text = if readout.is_some() { text.monospace() } else { text.weak() };
            let label = ui.add(Label::new(text).truncate());
            if let Some(readout) = readout {
                label.on_hover_text(readout);
            }
        });
        ui.separator();
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            ui.label(RichText::new(burst_text(model)).weak());
            let opening =
                [("Opening…", model.slots.a.opening.running()), ("Opening B…", model.slots.b.opening.running())];
            if let Some((what, running)) = opening.into_iter().find_map(|(what, busy)| Some((what, busy?))) {
                let percent = running.progress.map_or(0.0, |p| 100.0 * p.fraction);
                if model.slots.a.burst.is_some() && ui.small_button("Cancel opening").clicked() {
                    queue.push(ActionId::Cancel);
                }
                ui.label(format!("{what} {percent:.0} %"));
            }
            if let Some(running) = &model.coherence.running() {
                if ui.small_button("Cancel coherence").clicked() {
                    queue.push(ActionId::Cancel);
                }
                let text = format!("Coherence  {}", progress_text(running));
                ui.label(text).on_hover_text("Computing how well the single frames agree on each feature");
            }
            if let Some(running) = &model.figures.running() {
                if ui.small_button("Cancel figures").clicked() {
                    queue.push(ActionId::CancelFigures);
                }
                let text = format!("Figures  {}", progress_text(running));
                ui.label(text).on_hover_text("Remaking the figures of the paper");
            }
            ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                if let Some(note) = model.messages.last_note() {
                    ui.add(Label::new(note).truncate());
                }
            });
        });
    });
}

fn burst_text(model: &Model) -> String {
    let side = model.active_side();
    let Some(open) = model.burst_of(side) else { return "No burst open".to_owned() };
    // With two bursts, the text names this one.
    let which = if model.workspace == Workspace::Pair { format!("{}: ", side.name()) } else { String::new() };
    let burst = &open.burst;
    let (width, height) = burst.size();
    let depth = if burst.quantisation_step > 0.0 {
        // Twelve bits in the upper part of a 16-bit word end slightly below full scale: whole steps, and the level at
        // zero.
        format!(" · {:.0} levels", (1.0 / burst.quantisation_step + 0.02).floor() + 1.0)
    } else {
        " · float".to_owned()
    };
    let frames = if burst.len() == 1 { "frame" } else { "frames" };
    format!("{which}{} · {} {frames} · {width} × {height}{depth}", burst.name, burst.len())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::project::tests::open;

    #[test]
    fn the_burst_is_said_with_its_frames_size_and_levels() {
        let mut model = Model::default();
        assert_eq!(burst_text(&model), "No burst open");
        model.take_burst(open((64, 48), 5));
        assert_eq!(burst_text(&model), "test · 5 frames · 64 × 48 · float");
        let with_step = |quantisation_step: f32| {
            let mut burst = (*open((64, 48), 1).burst).clone();
            burst.quantisation_step = quantisation_step;
            let mut model = Model::default();
            model.take_burst(crate::requests::OpenBurst::new(burst, crate::requests::BurstSource::Demo));
            model.workspace = Workspace::Pair;
            burst_text(&model)
        };
        assert_eq!(with_step(1.0 / 255.0), "A: test · 1 frame · 64 × 48 · 256 levels");
        // Twelve bits in the upper part of sixteen.
        assert_eq!(with_step(16.0 / 65535.0), "A: test · 1 frame · 64 × 48 · 4096 levels");
    }
}
