//! The tally: how many candidates each test rejected, as bars that can be read.

use crate::app::actions::Queue;
use crate::app::project::Model;
use crate::detector::advice::grouped;
use crate::detector::{NoiseGate, Test};
use egui::{Rect, RichText, ScrollArea, Sense, Ui, vec2};

/// A line of numbers about the detection.
pub fn summary_ui(ui: &mut Ui, model: &Model) {
    let Some(found) = &model.found else {
        ui.weak("No detection yet");
        return;
    };
    let detection = &found.detection;
    let gate = match found.params.noise_gate {
        NoiseGate::Auto => format!("automatic, {:.2} σ", detection.noise_gate_factor),
        NoiseGate::Strict => format!("strict, {:.2} σ", detection.noise_gate_factor),
        NoiseGate::Factor(k) => format!("{k} σ"),
    };
    let text = format!(
        "Frame noise {} of full scale  ·  noise gate {gate}  ·  {} slopes  ·  octaves {} … {}",
        crate::app::canvas::number(detection.frame_noise, 3),
        detection.slopes.len(),
        detection.octaves.start,
        detection.octaves.end - 1,
    );
    ui.add(egui::Label::new(&text).truncate()).on_hover_text(text);
}

/// Draws the bars.
pub fn tally_ui(ui: &mut Ui, model: &Model, queue: &mut Queue) {
    let Some(found) = &model.found else {
        ui.centered_and_justified(|ui| ui.weak("Press Detect to see what each test rejects"));
        return;
    };
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        ui.spacing_mut().item_spacing.y = 1.0;
        let tally = &found.detection.tally;
        let most = tally.rejected.iter().copied().max().unwrap_or(0).max(tally.kept).max(1);
        line_ui(ui, "Samples of D examined", tally.samples, None);
        for test in Test::ALL {
            line_ui(ui, test.reason(), tally.rejected_by(test), Some((most, false)));
        }
        line_ui(ui, "Kept: keypoints", tally.kept, Some((most, true)));
        crate::app::panel::noise::warnings_ui(ui, found);
        ui.add_space(4.0);
        crate::app::panel::bottom::advice_ui(ui, model, queue);
    });
}

/// One test: its reason, its count, and a bar whose length grows with the logarithm of the count.
fn line_ui(ui: &mut Ui, name: &str, count: u64, bar: Option<(u64, bool)>) {
    ui.horizontal(|ui| {
        crate::app::panel::widgets::label_ui(ui, name, 250.0);
        let size = vec2(96.0, 16.0);
        ui.allocate_ui_with_layout(size, egui::Layout::right_to_left(egui::Align::Center), |ui| {
            ui.set_min_width(size.x);
            ui.label(RichText::new(grouped(count)).monospace());
        });
        if let Some((most, kept)) = bar {
            let room = (ui.available_width() - 8.0).clamp(40.0, 420.0);
            let (rect, response) = ui.allocate_exact_size(vec2(room, 10.0), Sense::hover());
            let share = if count == 0 { 0.0 } else { (1.0 + count as f32).ln() / (1.0 + most as f32).ln() };
            let colour = if kept { crate::app::style::ACCENT } else { ui.visuals().weak_text_color() };
            ui.painter().rect_filled(rect, 2.0, ui.visuals().faint_bg_color);
            ui.painter().rect_filled(Rect::from_min_size(rect.min, vec2(room * share, 10.0)), 2.0, colour);
            response.on_hover_text("The bar's length grows with the logarithm of the count");
        }
    });
}
