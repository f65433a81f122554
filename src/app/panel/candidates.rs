//! Candidates that one test rejected, over the picture: their places, and by how much they failed.

use crate::app::canvas::overlay::{CircleMark, circle_at, draw_marks};
use crate::app::canvas::{CanvasOutput, number};
use crate::app::pane::PaneId;
use crate::app::panel::features::frames_from_middle;
use crate::app::project::Model;
use crate::app::project::pair::Side;
use crate::detector::Slope;
use crate::inspect::candidates::{CandidateMark, Survey};
use crate::inspect::probe::Wanted;
use crate::plane::colour_map::ColourMap;
use crate::requests::ProbeQuestion;
use egui::{Align2, Color32, Frame, Label, Margin, Pos2, RichText, Sense, Ui, pos2, vec2};
use std::sync::Arc;

/// Maximum number of marks drawn; of more, the strongest are drawn.
const MOST: usize = 20_000;

/// Draws the candidates over the picture of pane `id`, and lets the pointer choose one.
pub fn candidates_ui(ui: &Ui, model: &mut Model, id: PaneId, output: &CanvasOutput) {
    let Some(test) = model.explained.shown_test else {
        model.explained.pointed = None;
        return;
    };
    let Some(pane) = model.panes.get(id).filter(|pane| pane.side == Side::A) else { return };
    let Some(found) = model.slots.a.found.as_ref() else { return };
    let dt = frames_from_middle(pane.picture.as_ref(), &found.detection).unwrap_or(0.0);
    let slopes = found.detection.slopes;
    let Some(survey) = model.survey().cloned() else {
        note_ui(ui, output, &format!("Finding candidates: {}…", test.reason()));
        return;
    };
    let shown = strongest(&survey);
    let circle = |mark: &CandidateMark| circle_of(mark, slopes.slope(mark.slope_index), dt);
    let selected = model.explained.selected;
    let marks = shown.iter().map(|&index| {
        let mark = &survey.marks[index];
        let (centre, radius) = circle(mark);
        CircleMark { centre, radius, colour: margin_colour(mark.margin), strong: selected == Some(index) }
    });
    draw_marks(output, marks);
    let more =
        if survey.marks.len() > shown.len() { format!(" (the {} strongest)", shown.len()) } else { String::new() };
    let min_snr = crate::inspect::candidates::SurveyOptions::default().min_snr;
    let text = format!("{} candidates{more}: {}; SNR ≥ {min_snr}", survey.marks.len(), test.reason());
    note_ui(ui, output, &text);
    let clip = output.painter.clip_rect();
    let Some(pointer) = output.pointer_ui.filter(|pos| clip.contains(*pos)) else { return };
    let pointed = circle_at(shown.iter().map(|&index| circle(&survey.marks[index])), output.ui_from_image, pointer);
    let pointed = pointed.map(|place| shown[place]);
    // The pointer meets the topmost marks, not the features below them.
    model.explained.pointed = pointed;
    if pointed.is_some() {
        model.hovered = None;
    }
    if output.response.clicked() {
        model.explained.selected = pointed;
    }
    if let Some(index) = pointed.filter(|_| !output.response.dragged()) {
        let text = mark_text(&survey.marks[index], slopes.slope(survey.marks[index].slope_index));
        let (id, anchor) = (egui::Id::unique("candidate tip"), egui::PopupAnchor::Pointer);
        egui::Tooltip::always_open(ui.ctx().clone(), ui.layer_id(), id, anchor)
            .gap(14.0)
            .show(|ui| ui.label(RichText::new(text).monospace()));
    }
}

/// Indices of the drawn marks: all of them, or the strongest.
fn strongest(survey: &Arc<Survey>) -> Vec<usize> {
    let mut indices: Vec<usize> = (0..survey.marks.len()).collect();
    if indices.len() > MOST {
        let by_snr = |a: &usize, b: &usize| survey.marks[*b].snr.total_cmp(&survey.marks[*a].snr);
        indices.select_nth_unstable_by(MOST, by_snr);
        indices.truncate(MOST);
        indices.sort_unstable();
    }
    indices
}

/// Place of a candidate `dt` frames after mid-burst, and the radius of its circle, image pixels.
fn circle_of(mark: &CandidateMark, slope: Slope, dt: f32) -> (Pos2, f32) {
    let [u, v] = mark.pos_image;
    (pos2(u, v) + dt * vec2(slope.u, slope.v), std::f32::consts::SQRT_2 * mark.sigma)
}

/// Colour of a margin: yellow for nearly passed, dark for far from it.
fn margin_colour(margin: Option<f32>) -> Color32 {
    let t = 1.0 + margin.unwrap_or(-0.5).clamp(-1.0, 0.0);
    let [r, g, b] = ColourMap::Viridis.lut()[(255.0 * (0.25 + 0.75 * t)) as usize];
    Color32::from_rgb(r, g, b)
}

/// Describes a candidate by its numbers.
fn mark_text(mark: &CandidateMark, slope: Slope) -> String {
    let [u, v] = mark.pos_image;
    let fails = match (mark.first_failed, mark.margin) {
        (Some(test), Some(margin)) => format!("{}: by {} %", test.reason(), number(-100.0 * margin, 3)),
        (Some(test), None) => test.reason().to_owned(),
        (None, _) => "kept".to_owned(),
    };
    format!(
        "candidate at ({}, {})  σ {:.2} px\noctave {} level {}  slope ({:+.2}, {:+.2}) px/frame\nD {:+.5}  SNR {:.1}\n{fails}",
        number(u, 4),
        number(v, 4),
        mark.sigma,
        mark.octave,
        mark.level,
        slope.u,
        slope.v,
        mark.value,
        mark.snr
    )
}

/// Draws the data of the selected candidate, and its actions.
pub fn selected_ui(ui: &mut Ui, model: &mut Model) {
    let Some(mark) = model.selected_candidate().copied() else { return };
    let Some(slope) = model.slots.a.found.as_ref().map(|found| found.detection.slopes.slope(mark.slope_index)) else {
        return;
    };
    Frame::group(ui.style()).inner_margin(Margin::symmetric(6, 3)).show(ui, |ui| {
        ui.horizontal_wrapped(|ui| {
            let text = mark_text(&mark, slope).replace('\n', "  ·  ");
            let mut text = text.chars();
            let text: String = text.next().into_iter().flat_map(char::to_uppercase).chain(text).collect();
            ui.add(Label::new(text).wrap());
            let tip = "Show the DoG at its slope, octave and level, centred on it";
            if ui.button("Go to candidate").on_hover_text(tip).clicked() {
                model.playing = false;
                let pane = model.focused_mut();
                (pane.cursor.slope, pane.cursor.octave, pane.cursor.level) = (slope, mark.octave, mark.level);
                pane.slope_chosen = true;
                pane.show(crate::app::project::cursor::ViewKind::Dog);
                let [u, v] = mark.pos_image;
                pane.view.look_at(pos2(u, v), 60.0 / mark.sigma.max(1.0));
            }
            if ui
                .button("Probe candidate")
                .on_hover_text("Show its tests in order, and the setting that would keep it")
                .clicked()
            {
                let wanted = Wanted::Candidate(mark.of_sample());
                model.ask_probe(ProbeQuestion::At { place: mark.pos_image, wanted });
            }
            if ui.button("Clear").on_hover_text("Clear the selection").clicked() {
                model.explained.selected = None;
            }
        });
    });
}

/// Draws a line over the picture that explains the marks.
fn note_ui(ui: &Ui, output: &CanvasOutput, text: &str) {
    let painter = &output.painter;
    let rect = output.response.rect.intersect(painter.clip_rect());
    let font = egui::FontId::proportional(12.0);
    let mut job = egui::text::LayoutJob::simple_singleline(text.to_owned(), font, Color32::WHITE);
    job.wrap.max_width = (rect.width() - 30.0).max(40.0);
    job.wrap.max_rows = 1;
    let galley = painter.layout_job(job);
    let ground = Align2::CENTER_TOP.align_size_within_rect(galley.size() + vec2(14.0, 6.0), rect.shrink(8.0));
    painter.rect_filled(ground, 4.0, Color32::from_black_alpha(190));
    painter.galley(ground.min + vec2(7.0, 3.0), galley, Color32::WHITE);
    let response = ui.interact(ground, output.response.id.with("candidates"), Sense::hover());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Label, true, text));
    response.on_hover_text(
        "Yellow: nearly passed; dark: failed by far. Point at a circle to read its numbers; click to keep them on the screen",
    );
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::detector::Test;

    fn mark(snr: f32) -> CandidateMark {
        CandidateMark {
            pos_image: [10.5, 20.0],
            sigma: 2.0,
            octave: 0,
            level: 1,
            slope_index: 3,
            sample: [10, 20],
            value: -0.0123,
            snr,
            first_failed: Some(Test::NoiseGate),
            margin: Some(-0.125),
        }
    }

    #[test]
    fn of_very_many_candidates_the_strongest_are_drawn() {
        let survey = |count: usize| {
            // Weak and strong marks alternate.
            let marks = (0..count).map(|i| mark(if i % 2 == 0 { 3.0 } else { 9.0 + i as f32 })).collect();
            Arc::new(Survey { marks, counts: Vec::new(), candidates: count as u64, kept: 0 })
        };
        assert_eq!(strongest(&survey(7)), (0..7).collect::<Vec<_>>());
        let many = survey(2 * MOST);
        let drawn = strongest(&many);
        assert_eq!(drawn.len(), MOST);
        assert!(drawn.is_sorted() && drawn.iter().all(|&index| many.marks[index].snr > 3.0));
    }

    #[test]
    fn a_candidate_is_where_its_slope_takes_it_and_says_why_it_failed() {
        let slope = Slope::new(-1.0, 0.5);
        let (pos, radius) = circle_of(&mark(5.0), slope, 2.0);
        assert_eq!(pos, pos2(8.5, 21.0));
        assert!((radius - 2.0 * std::f32::consts::SQRT_2).abs() < 1e-6);
        let text = mark_text(&mark(5.0), slope);
        assert!(
            text.starts_with("candidate at (10.5, 20)  σ 2.00 px\noctave 0 level 1  slope (-1.00, +0.50)"),
            "{text}"
        );
        assert!(text.ends_with(&format!("{}: by 12.5 %", Test::NoiseGate.reason())), "{text}");
        let kept = CandidateMark { first_failed: None, margin: None, ..mark(5.0) };
        assert!(mark_text(&kept, slope).ends_with("\nkept"));
    }

    #[test]
    fn what_nearly_passed_is_brighter_than_what_was_far_from_it() {
        let light = |margin| margin_colour(margin).intensity();
        assert!(light(Some(-0.01)) > light(Some(-0.3)) && light(Some(-0.3)) > light(Some(-0.9)));
        assert_eq!(margin_colour(None), margin_colour(Some(-0.5)), "what has no margin lies in the middle");
        assert_eq!(margin_colour(Some(-7.0)), margin_colour(Some(-1.0)));
    }
}
