//! Tally: numbers of candidates that each test rejected, as bars.

use crate::app::actions::Queue;
use crate::app::project::Model;
use crate::detector::advice::grouped;
use crate::detector::{NoiseGate, Test};
use egui::{Rect, RichText, ScrollArea, Sense, Ui, vec2};

/// Draws a line of numbers about the detection.
pub fn summary_ui(ui: &mut Ui, model: &Model) {
    let Some(found) = &model.slots.a.found else {
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

/// Draws the bars. Rows of tests that reject candidates are switches: they show these candidates in the picture.
pub fn tally_ui(ui: &mut Ui, model: &mut Model, queue: &mut Queue) {
    let Some(found) = model.slots.a.found.clone() else {
        ui.centered_and_justified(|ui| ui.weak("Press Detect to see what each test rejects"));
        return;
    };
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        ui.spacing_mut().item_spacing.y = 1.0;
        crate::app::panel::candidates::selected_ui(ui, model);
        let tally = &found.detection.tally;
        let survey = model.survey_counts().cloned();
        head_ui(ui, survey.is_some());
        let most = tally.rejected.iter().copied().max().unwrap_or(0).max(tally.kept).max(1);
        line_ui(ui, &Row { name: "Samples of D examined", samples: tally.samples, candidates: None, bar: None }, None);
        for test in Test::ALL {
            let candidates = survey
                .as_ref()
                .and_then(|survey| survey.counts.iter().find(|count| count.test == test).map(|count| count.candidates));
            let bar = Some((most, false));
            let row = Row { name: test.reason(), samples: tally.rejected_by(test), candidates, bar };
            let mut shown = model.explained.shown_test == Some(test);
            let before = shown;
            line_ui(ui, &row, takes_candidates(test).then_some(&mut shown));
            if shown != before {
                (model.explained.shown_test, model.explained.selected) = (shown.then_some(test), None);
            }
        }
        let kept = survey.as_ref().map(|survey| survey.kept);
        let row = Row { name: "Kept: keypoints", samples: tally.kept, candidates: kept, bar: Some((most, true)) };
        line_ui(ui, &row, None);
        crate::app::panel::noise::warnings_ui(ui, &found);
        ui.add_space(4.0);
        crate::app::panel::advice::advice_ui(ui, model, queue);
    });
}

/// Whether a candidate can fail the test first: a sample that is no extremum at its own slope and scale is no
/// candidate.
fn takes_candidates(test: Test) -> bool {
    !matches!(test, Test::SpaceExtremum | Test::ScaleExtremum)
}

/// Width of the tests' names, points.
const NAME_WIDTH: f32 = 250.0;
/// Width of each count, points.
const COUNT_WIDTH: f32 = 96.0;

/// Row of the tally.
struct Row<'a> {
    name: &'a str,
    samples: u64,
    /// Number of samples that were candidates, as far as known.
    candidates: Option<u64>,
    /// Count shown by the bar, and whether it is that of the kept ones.
    bar: Option<(u64, bool)>,
}

/// Draws the headings.
fn head_ui(ui: &mut Ui, with_candidates: bool) {
    ui.horizontal(|ui| {
        let hint = RichText::new("Click a test to see its candidates in the picture").small().weak();
        crate::app::panel::widgets::label_ui(ui, hint, NAME_WIDTH);
        let mut heads = vec![("samples", "Samples of D that fail this test first")];
        if with_candidates {
            let tip = "Those of them that were extrema in place and scale at their own slope: possible features";
            heads.push(("candidates", tip));
        }
        for (head, tip) in heads {
            count_ui(ui, RichText::new(head).small().weak()).on_hover_text(tip);
        }
    });
}

/// Draws a number or its heading, at the right end of its column.
fn count_ui(ui: &mut Ui, text: RichText) -> egui::Response {
    let size = vec2(COUNT_WIDTH, 16.0);
    ui.allocate_ui_with_layout(size, egui::Layout::right_to_left(egui::Align::Center), |ui| {
        ui.set_min_width(size.x);
        ui.label(text)
    })
    .inner
}

/// Draws one test: its reason, its counts, and a bar whose length grows with the logarithm of the count. With `shown`
/// the name is a switch.
fn line_ui(ui: &mut Ui, row: &Row<'_>, shown: Option<&mut bool>) {
    ui.horizontal(|ui| {
        match shown {
            Some(shown) => {
                let size = vec2(NAME_WIDTH, ui.spacing().interact_size.y);
                ui.allocate_ui_with_layout(size, egui::Layout::left_to_right(egui::Align::Center), |ui| {
                    ui.set_min_width(NAME_WIDTH);
                    let tip =
                        "Show the candidates that fail this test first in the picture, coloured by how far they fail";
                    ui.toggle_value(shown, row.name).on_hover_text(tip);
                });
            }
            None => {
                crate::app::panel::widgets::label_ui(ui, row.name, NAME_WIDTH);
            }
        }
        count_ui(ui, RichText::new(grouped(row.samples)).monospace());
        if let Some(candidates) = row.candidates {
            count_ui(ui, RichText::new(grouped(candidates)).monospace());
        }
        if let Some((most, kept)) = row.bar {
            let room = (ui.available_width() - 8.0).clamp(40.0, 420.0);
            let (rect, response) = ui.allocate_exact_size(vec2(room, 10.0), Sense::hover());
            let count = row.samples;
            let share = if count == 0 { 0.0 } else { (1.0 + count as f32).ln() / (1.0 + most as f32).ln() };
            let colour = if kept { crate::app::style::ACCENT } else { ui.visuals().weak_text_color() };
            ui.painter().rect_filled(rect, 2.0, ui.visuals().faint_bg_color);
            ui.painter().rect_filled(Rect::from_min_size(rect.min, vec2(room * share, 10.0)), 2.0, colour);
            response.on_hover_text("Logarithm of the number of samples");
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::project::tests::open;
    use crate::detector::DetectorParams;
    use crate::inspect::ProbeCache;
    use crate::inspect::candidates::{SurveyOptions, survey};
    use crate::monitor::Monitor;

    #[test]
    fn tests_that_are_said_to_take_no_candidates_take_none() {
        let params = DetectorParams { octaves: 1, peak_threshold: 0.001, ..DetectorParams::default() };
        let cache = ProbeCache::new(&open((48, 40), 3).burst, &params.into(), &Monitor::default()).expect("valid");
        let survey = survey(&cache.trail, &SurveyOptions::default(), &Monitor::default()).expect("not cancelled");
        assert!(survey.candidates > 0);
        for count in &survey.counts {
            assert!(takes_candidates(count.test) || count.candidates == 0, "{:?}", count.test);
        }
        assert_eq!(survey.counts.iter().filter(|count| !takes_candidates(count.test)).count(), 2);
    }
}
