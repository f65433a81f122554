//! Candidates near the place: the tests that they fail, and the one setting that would keep the selected one.

use super::{apply_ui, go_to_ui};
use crate::app::document::{Action, Queue};
use crate::app::panel::widgets::{named, only_ui, small_text};
use crate::app::{results::Read, style};
use crate::detector::Test;
use crate::inspect::place::{Fate, Needed, Outcome, Probe, ProbeSubject, TestReport};
use crate::inspect::words::{number, sentence, slope_text, value_text};
use crate::requests::{ProbeQuestion, Probed};
use egui::{Align2, FontId, Label, RichText, ScrollArea, Sense, Ui, vec2};

const ROW: f32 = 18.0;
const ROWS_SEEN: usize = 6;

pub(super) fn fates_ui(ui: &mut Ui, model: Read<'_>, answer: &Probed, queue: &mut Queue) {
    let (probe, subject) = (&answer.probe, answer.probe.subject.fate);
    scale_ui(ui, model, answer, queue);
    if probe.fates.is_empty() {
        return only_ui(ui, "No sample here is an extremum in place and scale.");
    }
    let (near, larger) = (0..probe.near, probe.near..probe.fates.len());
    match near.is_empty() {
        true => only_ui(ui, "No candidate is centred near this place."),
        false => list_ui(ui, answer, near.clone(), queue),
    }
    if !larger.is_empty() {
        // Folded unless the selected candidate is there, or no other.
        let is_open = near.is_empty() || subject.is_some_and(|index| larger.contains(&index));
        egui::CollapsingHeader::new(format!("Larger blobs over this place ({})", larger.len()))
            .id_salt(("larger blobs", is_open))
            .default_open(is_open)
            .show_unindented(ui, |ui| list_ui(ui, answer, larger, queue));
    }
    ui.add_space(4.0);
    match (answer.probe.subject_fate(), answer.request.question) {
        (Some(fate), _) => fate_ui(ui, model, fate, answer.probe.outlook.as_ref(), queue),
        (None, ProbeQuestion::At { wanted: ProbeSubject::Scale { .. }, .. }) => {
            only_ui(ui, "No candidate at this slope and scale.");
        }
        (None, _) => only_ui(ui, "Click a candidate to see its tests."),
    }
}

fn scale_ui(ui: &mut Ui, model: Read<'_>, answer: &Probed, queue: &mut Queue) {
    let sigma_text = |sigma: f32| format!("Near σ {} px", number(sigma, 1));
    let mut chosen = model.document.probe.near_sigma;
    let text = chosen.map_or_else(|| "All scales".to_owned(), sigma_text);
    let combo = egui::ComboBox::from_id_salt("scale of candidates").selected_text(&text).show_ui(ui, |ui| {
        ui.selectable_value(&mut chosen, None, "All scales");
        for scale in &answer.probe.response.scales {
            ui.selectable_value(&mut chosen, Some(scale.sigma), sigma_text(scale.sigma));
        }
    });
    queue.edit(model.document, Action::ProbeNear(chosen));
    let help = "Candidates near this scale come first; a probe begins with the scale of the DoG in view";
    named(&combo.response.on_hover_text(help), egui::Role::ComboBox, format!("Scale of candidates: {text}"));
}

fn list_ui(ui: &mut Ui, answer: &Probed, listed: std::ops::Range<usize>, queue: &mut Queue) {
    let (fates, first) = (&answer.probe.fates[listed.clone()], listed.start);
    heading_ui(ui);
    let seen = fates.len().min(ROWS_SEEN) as f32;
    let spacing = std::mem::replace(&mut ui.spacing_mut().item_spacing.y, 0.0);
    let area = ScrollArea::vertical().id_salt(("fates", first > 0)).max_height(seen * ROW).auto_shrink([false, true]);
    area.show_rows(ui, ROW, fates.len(), |ui, rows| {
        for row in rows {
            let (index, fate) = (first + row, &fates[row]);
            let is_clicked = row_ui(ui, &answer.probe, index, answer.probe.subject.fate == Some(index));
            queue.push_if(is_clicked, Action::ProbeSubject(ProbeSubject::Candidate(fate.of_sample())));
        }
    });
    ui.spacing_mut().item_spacing.y = spacing;
}

/// Columns' positions as fractions of the width: distance, σ, slope and strength end there, the test begins there.
const COLUMNS: [(f32, Align2); 5] = {
    let right = Align2::RIGHT_CENTER;
    [(0.10, right), (0.19, right), (0.515, right), (0.635, right), (0.655, Align2::LEFT_CENTER)]
};

fn heading_ui(ui: &mut Ui) {
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), ROW), Sense::hover());
    for (name, (x, align)) in ["away", "σ px", "slope", "SNR", "fails first at"].into_iter().zip(COLUMNS) {
        small_text(ui, ui.painter(), egui::pos2(rect.left() + x * rect.width(), rect.center().y), align, name);
    }
    response.on_hover_text(
        "Samples that are extrema in place and scale at their own slope, however weak; away: px from the place\n\
         Those within 3 px come first: at the slope in view, then at the place's own motion, then others, and of \
         these the kept ones, then those with the largest SNR; farther away the nearest come first",
    );
}

/// Draws one candidate; returns whether it was clicked.
fn row_ui(ui: &mut Ui, probe: &Probe, index: usize, selected: bool) -> bool {
    let fate = &probe.fates[index];
    let ([u, v], [at_u, at_v]) = (fate.pos_image, probe.pos_image);
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), ROW), Sense::click());
    let visuals = ui.visuals();
    if selected || response.hovered() {
        let fill = if selected { visuals.selection.bg_fill } else { visuals.widgets.hovered.weak_bg_fill };
        ui.painter().rect_filled(rect, 2.0, fill);
    }
    let colour = if selected { visuals.selection.stroke.color } else { visuals.text_color() };
    let why = |test: Test| format!("{} {}", test.record().short, fate.report(test).margin_text());
    let outcome = fate.first_failed.map_or_else(|| "kept".to_owned(), why);
    let away = number((u - at_u).hypot(v - at_v), 1);
    let texts = [away, number(fate.sigma, 1), slope_text(fate.slope), fate.snr_text(), outcome.clone()];
    for (text, (x, align)) in texts.iter().zip(COLUMNS) {
        let pos = egui::pos2(rect.left() + x * rect.width(), rect.center().y);
        let colour = if *text == outcome && fate.is_kept() && !selected { style::good(ui) } else { colour };
        ui.painter().text(pos, align, text, FontId::proportional(12.0), colour);
    }
    let name = format!("Candidate {}: {}", index + 1, outcome.trim());
    response.widget_info(|| egui::WidgetInfo::selected(egui::Role::Button, true, selected, &name));
    let clicked = response.clicked();
    let (u, v, octave, level) = (number(u, 1), number(v, 1), fate.octave, fate.level);
    let response_text = format!("D {:+.2e}, its noise {:.2e}\n{}", fate.value, fate.sigma_d, fate.verdict);
    response.on_hover_text(format!("At ({u}, {v}), octave {octave}, level {level}\n{response_text}"));
    clicked
}

fn fate_ui(ui: &mut Ui, model: Read<'_>, fate: &Fate, outlook: Option<&Needed>, queue: &mut Queue) {
    ui.add(Label::new(RichText::new(sentence(&fate.verdict)).strong()).wrap());
    if let Some(remedy) = &fate.remedy {
        let rejected = |test: Test| format!(" It would then be rejected as {}.", test.reason());
        let then = remedy.then_fails.map_or_else(String::new, rejected);
        ui.add(Label::new(format!("{}{then}", sentence(&remedy.sentence))).wrap());
        ui.horizontal_wrapped(|ui| apply_ui(ui, model, &remedy.change, queue));
    }
    if let Some(outlook) = outlook {
        let label = ui.add(Label::new(sentence(&outlook.sentence)).wrap());
        label.on_hover_text("What would have to change in the world, from the noise of the burst");
    }
    if let Some(rival) = fate.first_failed.and_then(|test| fate.report(test).rival) {
        go_to_ui(ui, model, rival.feature, (rival.pos_image, rival.slope), queue);
    }
    ui.add_space(2.0);
    // A test that is off and has no number tells nothing.
    let telling = |report: &&TestReport| report.outcome != Outcome::NotAsked || report.value.is_some();
    for report in fate.tests.iter().filter(telling) {
        test_ui(ui, report, fate.first_failed == Some(report.test));
    }
}

/// Draws one test in words after its mark; the numbers are shown on hovering.
fn test_ui(ui: &mut Ui, report: &TestReport, first: bool) {
    let (mark, colour, says) = match report.outcome {
        Outcome::Passes => ("✔", style::good(ui), "passes"),
        Outcome::Fails if first => ("✖", ui.visuals().error_fg_color, "fails: the search's verdict"),
        Outcome::Fails => ("✖", style::warning(ui), "would fail too"),
        Outcome::NotAsked => ("–", ui.visuals().weak_text_color(), "is not applied"),
        Outcome::Unknown => ("?", ui.visuals().weak_text_color(), "cannot be decided"),
    };
    let value = report.value.map(value_text).unwrap_or_default();
    let (record, limit, margin) = (report.test.record(), report.limit_text(), report.margin_text());
    let tip = format!("{}: {says} {value} {limit} {margin}", record.name);
    let is_weak = matches!(report.outcome, Outcome::NotAsked | Outcome::Unknown);
    let text = format!("{}: {}", record.short, report.sentence());
    let mut text = RichText::new(text).size(12.0);
    text = if is_weak { text.weak() } else { text };
    text = if first { text.strong() } else { text };
    ui.horizontal_top(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        let (rect, _) = ui.allocate_exact_size(vec2(12.0, 14.0), Sense::hover());
        ui.painter().text(rect.center(), Align2::CENTER_CENTER, mark, FontId::proportional(12.0), colour);
        ui.add(Label::new(text).wrap()).on_hover_text(tip.trim_end());
    });
}
