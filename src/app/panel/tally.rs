//! Tests of the search: how many samples each rejected, and the candidates that one of them rejected, over the picture.

use crate::app::canvas::overlay::{CircleMark, circle_at, draw_circles, rgb};
use crate::app::canvas::{CanvasOutput, number};
use crate::app::document::{Action, Destination, Pointed, Queue, Side};
use crate::app::pane::PaneId;
use crate::app::panel::widgets::{instead_ui, label_ui, progress_text, tip_ui, weak_ui, with_whole_numbers};
use crate::app::results::{FoundFeatures, Read};
use crate::detector::{NoiseGate, Slope, Test};
use crate::inspect::place::{CandidateMark, ProbeSubject, Survey};
use crate::inspect::result::{DecoyReport, DecoyStudy, Decoys};
use crate::inspect::words::{capitalised, counted, sentence};
use crate::requests::{JobError, ProbeQuestion, ViewKind};
use egui::{Align2, Button, Color32, Frame, Label, Margin, Pos2, Rect, RichText, ScrollArea, Sense, Ui, vec2};
use std::sync::Arc;

pub fn summary(_: Read<'_>, found: &FoundFeatures) -> Option<[String; 2]> {
    let detection = &found.detection;
    let gate = match found.params.noise_gate {
        NoiseGate::Factor(k) => format!("{k} σ"),
        word => format!("{word}, {:.2} σ", detection.noise_gate_factor),
    };
    let (noise, slopes) = (number(detection.frame_noise, 3), counted(detection.slopes.len(), "slope"));
    let (first, last) = (detection.octaves.start, detection.octaves.end - 1);
    let gates = format!("Frame noise {noise} of full scale  ·  noise gate {gate}");
    let text = format!("{gates}  ·  {slopes}  ·  octaves {first} … {last}");
    Some([text.clone(), text])
}

/// Draws the bars. Rows of tests that reject candidates are switches: they show these candidates in the picture.
pub fn tally_ui(ui: &mut Ui, model: Read<'_>, queue: &mut Queue) {
    let Some(found) = &model.results.slots.a.found else {
        return instead_ui(ui, model.without_features(Side::A, "Press Detect to see what each test rejects"));
    };
    // The counts do not fit into a narrow window.
    ScrollArea::both().auto_shrink(false).show(ui, |ui| {
        ui.spacing_mut().item_spacing.y = 1.0;
        selected_ui(ui, model, queue);
        let tally = &found.detection.tally;
        let survey = model.survey_counts();
        ui.horizontal(|ui| {
            let hint = RichText::new("Click a test to see its candidates in the picture").small().weak();
            label_ui(ui, hint, NAME_WIDTH);
            for (head, tip) in HEADS.into_iter().take(if survey.is_some() { 2 } else { 1 }) {
                count_ui(ui, RichText::new(head).small().weak()).on_hover_text(tip);
            }
        });
        let most = tally.rejected.iter().copied().max().unwrap_or(0).max(tally.kept).max(1);
        line_ui(ui, "Samples of D examined", [Some(tally.samples), None], None, None);
        if tally.not_searched > 0 {
            line_ui(ui, crate::detector::test::NOT_SEARCHED, [Some(tally.not_searched), None], None, None);
        }
        // Without masks nothing is told of them.
        let told = |test: &Test| *test != Test::Seen || tally.rejected_by(*test) > 0;
        for test in Test::ALL.into_iter().filter(told) {
            let counted = survey.and_then(|survey| survey.counts.iter().find(|count| count.test == test));
            let counts = [Some(tally.rejected_by(test)), counted.map(|count| count.candidates)];
            let mut shown = model.document.shown_test == Some(test);
            let before = shown;
            let bar = Some((most, ui.visuals().weak_text_color()));
            line_ui(ui, test.reason(), counts, bar, test.takes_candidates().then_some(&mut shown));
            queue.push_if(shown != before, Action::ShowTest(shown.then_some(test)));
        }
        let counts = [Some(tally.kept), survey.map(|survey| survey.kept)];
        line_ui(ui, "Kept: keypoints", counts, Some((most, crate::app::style::ACCENT)), None);
        let words = |decoys: &Arc<Decoys>| (format!("Decoys: {}", decoys.report.sentence()), decoys.report.doubt());
        decoys_ui(ui, model, "False rate…", model.decoys().map(words), queue);
        crate::app::panel::noise::warnings_ui(ui, found);
    });
}

const DECOYS_HELP: &str = "Searches copies whose frames are in other orders, with the noise of the burst: nothing moves there as it did, so the features found there are false. Their number tells how many found here are: for each of these, from an SNR on, or of those that pass the filter";

/// Draws how many of the features that pass the filter noise explains, or a button that asks for it.
pub fn expected_ui(ui: &mut Ui, model: Read<'_>, queue: &mut Queue) {
    let words = |report: &DecoyReport| (report.expected_words(), report.doubt());
    decoys_ui(ui, model, "Expected of noise…", model.results.listed_decoys.as_ref().map(words), queue);
}

/// Draws what decoys say, with the reason to doubt it, or a button `ask` for it: it takes a search for each copy.
fn decoys_ui(ui: &mut Ui, model: Read<'_>, ask: &str, told: Option<(String, Option<String>)>, queue: &mut Queue) {
    if let Some((text, doubt)) = told {
        let tip = doubt.map_or_else(String::new, |doubt| format!("\n\n{}", sentence(&doubt)));
        ui.add(Label::new(with_whole_numbers(&text)).wrap()).on_hover_text(format!("{DECOYS_HELP}.{tip}"));
        return;
    }
    // Known decoys wait for the verdicts on the features that they are compared with.
    let Some(found) = model.found_of(Side::A).filter(|_| model.decoys().is_none()) else { return };
    let asked = &model.results.explained.asked_decoys;
    if asked.is_pending() {
        let progress = asked.running.map_or_else(|| "waiting".to_owned(), |running| progress_text(&running));
        ui.weak(format!("Decoys: {progress}")).on_hover_text(DECOYS_HELP);
        return;
    }
    let failure = asked.failure().filter(|(request, _)| model.decoys_request().as_ref() == Some(*request));
    if let Some((_, why)) = failure.filter(|(_, why)| **why != JobError::Cancelled) {
        weak_ui(ui, format!("Noise unknown: {why}"));
    }
    let copies = DecoyStudy::default().copies;
    let secs = (copies as f32 * found.search_secs).ceil();
    let tip = format!("{DECOYS_HELP}.\n\nIt takes {copies} searches and verdicts, over {secs:.0} s, in the background");
    let is_current = model.stale().is_none() && model.takes_advice(Side::A);
    let button = ui.add_enabled(is_current, Button::new(ask)).on_hover_text(tip);
    if button.on_disabled_hover_text("The parameters changed: press Detect first").clicked() {
        queue.push(Action::SearchDecoys);
    }
}

const HEADS: [(&str, &str); 2] = [
    ("samples", "Samples of D that fail this test first"),
    ("candidates", "Samples that were extrema in place and scale at their own slope: possible features"),
];
const NAME_WIDTH: f32 = 250.0;
const COUNT_WIDTH: f32 = 96.0;

fn count_ui(ui: &mut Ui, text: RichText) -> egui::Response {
    let size = vec2(COUNT_WIDTH, 16.0);
    ui.allocate_ui_with_layout(size, egui::Layout::right_to_left(egui::Align::Center), |ui| {
        ui.set_min_width(size.x);
        ui.label(text)
    })
    .inner
}

/// Draws the counts of samples and of candidates after a name, which is a switch with `shown`, and a bar beside the
/// longest one, whose length grows with the logarithm of the samples.
fn line_ui(ui: &mut Ui, name: &str, counts: [Option<u64>; 2], bar: Option<(u64, Color32)>, shown: Option<&mut bool>) {
    ui.horizontal(|ui| {
        if let Some(shown) = shown {
            let size = vec2(NAME_WIDTH, ui.spacing().interact_size.y);
            ui.allocate_ui_with_layout(size, egui::Layout::left_to_right(egui::Align::Center), |ui| {
                ui.set_min_width(NAME_WIDTH);
                let tip = "Show the candidates that fail this test first in the picture, coloured by how far they fail";
                ui.toggle_value(shown, name).on_hover_text(tip);
            });
        } else {
            label_ui(ui, name, NAME_WIDTH);
        }
        for count in counts.into_iter().flatten() {
            count_ui(ui, RichText::new(crate::inspect::words::grouped(count)).monospace());
        }
        if let Some((most, colour)) = bar {
            let room = (ui.available_width() - 8.0).clamp(40.0, 420.0);
            let (rect, response) = ui.allocate_exact_size(vec2(room, 10.0), Sense::hover());
            let share = (1.0 + counts[0].unwrap_or(0) as f32).ln() / (1.0 + most as f32).ln();
            ui.painter().rect_filled(rect, 2.0, ui.visuals().faint_bg_color);
            ui.painter().rect_filled(Rect::from_min_size(rect.min, vec2(room * share, 10.0)), 2.0, colour);
            response.on_hover_text("Logarithm of the number of samples");
        }
    });
}

/// Maximum number of marks drawn; of more, the strongest are drawn.
const MAX_DRAWN: usize = 20_000;

/// Draws the candidates over the picture of pane `id`, and lets the pointer choose one.
pub fn candidates_ui(ui: &Ui, model: Read<'_>, id: PaneId, output: &CanvasOutput, queue: &mut Queue) {
    let Some(test) = model.document.shown_test else {
        return queue.point(&model.results.explained.pointed, None, Pointed::Candidate);
    };
    let Some(found) = model.found_of(Side::A).filter(|_| model.document.panes.is_on(id, Side::A)) else { return };
    let dt = model.frames_from_middle(id, &found.detection).unwrap_or_default();
    let slopes = found.detection.slopes;
    let Some(survey) = model.survey() else {
        return note_ui(ui, output, &format!("Finding candidates: {}…", test.reason()));
    };
    let shown = strongest(survey);
    let circle = |&index: &usize| {
        let CandidateMark { pos_image, sigma, sample, margin, .. } = survey.marks[index];
        let pos_image = Pos2::from(pos_image) + slopes.slope(sample.slope_index).displacement(dt).into();
        CircleMark { pos_image, sigma, from_image: None, colour: margin_colour(margin), dashed: false }
    };
    let circles: Vec<CircleMark> = shown.iter().map(circle).collect();
    let is_selected = |index: &usize| model.document.selected_candidate == Some(*index);
    draw_circles(output, &circles, shown.iter().position(is_selected));
    let (drawn, all) = (shown.len(), counted(survey.marks.len(), "candidate"));
    let more = if survey.marks.len() > drawn { format!(" (the {drawn} strongest)") } else { String::new() };
    let min_snr = crate::inspect::place::SurveyOptions::default().min_snr;
    note_ui(ui, output, &format!("{all}{more}: {}; SNR ≥ {min_snr}", test.reason()));
    let Some(pointer) = output.pointer_ui.filter(|pos| output.painter.clip_rect().contains(*pos)) else { return };
    let pointed = circle_at(output, &circles, pointer).map(|place| shown[place]);
    // The pointer meets the topmost marks, not the features below them.
    queue.point(&model.results.explained.pointed, pointed, Pointed::Candidate);
    queue.push_if(pointed.is_some(), Pointed::Feature(None));
    queue.push_if(output.response.clicked(), Action::SelectCandidate(pointed));
    if let Some(index) = pointed.filter(|_| !output.response.dragged()) {
        let text = mark_text(&survey.marks[index], slopes.slope(survey.marks[index].sample.slope_index));
        tip_ui(ui, "candidate tip", |ui| _ = ui.label(RichText::new(text).monospace()));
    }
}

fn strongest(survey: &Arc<Survey>) -> Vec<usize> {
    let mut indices: Vec<usize> = (0..survey.marks.len()).collect();
    if indices.len() > MAX_DRAWN {
        let by_snr = |a: &usize, b: &usize| survey.marks[*b].snr.total_cmp(&survey.marks[*a].snr);
        indices.select_nth_unstable_by(MAX_DRAWN, by_snr);
        indices.truncate(MAX_DRAWN);
        indices.sort_unstable();
    }
    indices
}

/// Colour of a margin: yellow for nearly passed, dark for far from it.
fn margin_colour(margin: Option<f32>) -> Color32 {
    let t = 1.0 + margin.unwrap_or(-0.5).clamp(-1.0, 0.0);
    rgb(crate::plane::display::ColourMap::Viridis.lut()[(255.0 * (0.25 + 0.75 * t)) as usize])
}

fn mark_text(mark: &CandidateMark, slope: Slope) -> String {
    let [u, v] = mark.pos_image;
    let fails = match (mark.first_failed, mark.margin) {
        (Some(test), Some(margin)) => format!("{}: by {} %", test.reason(), number(-100.0 * margin, 3)),
        (Some(test), None) => test.reason().to_owned(),
        (None, _) => "kept".to_owned(),
    };
    let (u, v, slope) = (number(u, 4), number(v, 4), crate::app::view::signed_slope(slope, 2));
    let CandidateMark { sigma, value, snr, sample, .. } = mark;
    let (octave, level) = (sample.octave, sample.level);
    format!("candidate at ({u}, {v})  σ {sigma:.2} px\noctave {octave} level {level}  slope ({slope}) px/frame\n")
        + &format!("D {value:+.5}  SNR {snr:.1}\n{fails}")
}

pub fn selected_ui(ui: &mut Ui, model: Read<'_>, queue: &mut Queue) {
    let Some(mark) = model.selected_candidate().copied() else { return };
    let Some(found) = &model.results.slots.a.found else { return };
    let slope = found.detection.slopes.slope(mark.sample.slope_index);
    Frame::group(ui.style()).inner_margin(Margin::symmetric(6, 3)).show(ui, |ui| {
        ui.horizontal_wrapped(|ui| {
            ui.add(Label::new(capitalised(&mark_text(&mark, slope).replace('\n', "  ·  "))).wrap());
            let tip = "Show the DoG at its slope, octave and level, centred on it";
            let goes = ui.button("Go to candidate").on_hover_text(tip).clicked();
            let (scale, kind) = (Some((mark.sample.octave, mark.sample.level)), Some(ViewKind::Dog));
            let at = Some((mark.pos_image, 60.0 / mark.sigma.max(1.0)));
            let to = Destination { slope: Some(slope), scale, kind, at, ..Destination::default() };
            queue.push_if(goes, Action::GoTo(Side::A, to));
            let tip = "Show its tests in order, and the setting that would keep it";
            let probes = ui.button("Probe candidate").on_hover_text(tip).clicked();
            let question = ProbeQuestion::At { place: mark.pos_image, wanted: ProbeSubject::Candidate(mark.sample) };
            queue.push_if(probes, Action::Probe(Side::A, question));
            let response = ui.button("Clear").on_hover_text("Clear the selection");
            queue.push_if(response.clicked(), Action::SelectCandidate(None));
        });
    });
}

fn note_ui(ui: &Ui, output: &CanvasOutput, text: &str) {
    crate::app::inspector::chip_ui(ui, output, Align2::CENTER_TOP, text, "candidates").on_hover_text(
        "Yellow: nearly passed; dark: failed by far. Point at a circle to read its numbers; click to keep them on the screen",
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mark(snr: f32) -> CandidateMark {
        let sample = crate::detector::Sample { octave: 0, level: 1, slope_index: 3, x: 10, y: 20 };
        let (pos_image, first_failed, margin) = ([10.5, 20.0], Some(Test::NoiseGate), Some(-0.125));
        CandidateMark { pos_image, sigma: 2.0, sample, value: -0.0123, snr, first_failed, margin }
    }

    #[test]
    fn of_very_many_candidates_the_strongest_are_drawn() {
        let survey = |count: usize| {
            // Weak and strong marks alternate.
            let marks = (0..count).map(|i| mark(if i % 2 == 0 { 3.0 } else { 9.0 + i as f32 })).collect();
            Arc::new(Survey { marks, counts: Vec::new(), candidates: count as u64, kept: 0 })
        };
        assert_eq!(strongest(&survey(7)), (0..7).collect::<Vec<_>>());
        let many = survey(2 * MAX_DRAWN);
        let drawn = strongest(&many);
        assert_eq!(drawn.len(), MAX_DRAWN);
        assert!(drawn.is_sorted() && drawn.iter().all(|&index| many.marks[index].snr > 3.0));
    }

    #[test]
    fn what_nearly_passed_is_brighter_than_what_was_far_from_it() {
        let light = |margin| margin_colour(margin).intensity();
        assert!(light(Some(-0.01)) > light(Some(-0.3)) && light(Some(-0.3)) > light(Some(-0.9)));
        assert_eq!(margin_colour(None), margin_colour(Some(-0.5)), "what has no margin lies in the middle");
        assert_eq!(margin_colour(Some(-7.0)), margin_colour(Some(-1.0)));
    }
}
