//! Candidates near the place: the first test that each fails, all tests of the selected one, and the one setting that
//! would keep it.

use super::apply_ui;
use crate::app::actions::Queue;
use crate::app::pane::PaneId;
use crate::app::project::Model;
use crate::app::project::pair::Side;
use crate::app::style;
use crate::detector::Test;
use crate::inspect::Fate;
use crate::inspect::fate::{Outcome, Rival, TestReport};
use crate::inspect::probe::Wanted;
use crate::inspect::report::value_text;
use crate::inspect::words::{counted_from_one, number, slope_text};
use crate::requests::Probed;
use egui::{Align2, FontId, Label, RichText, ScrollArea, Sense, TextStyle, Ui, vec2};

/// Height of a row of the list, points.
const ROW: f32 = 18.0;
/// Number of visible rows of the list.
const ROWS_SEEN: usize = 6;

/// Short name of a test.
fn short_name(test: Test) -> &'static str {
    match test {
        Test::PeakThreshold => "peak threshold",
        Test::NoiseGate => "noise gate",
        Test::SpaceExtremum => "in space",
        Test::ScaleExtremum => "in scale",
        Test::SlopeExtremum => "in slope",
        Test::Refinement => "fit settles",
        Test::InterpolatedContrast => "fit's contrast",
        Test::Edge => "edge",
        Test::Outside => "inside",
        Test::Duplicate => "distinct",
        Test::MaxFeatures => "strongest",
    }
}

/// Draws the list, and below it the selected candidate's tests.
pub(super) fn fates_ui(ui: &mut Ui, model: &mut Model, answer: &Probed, queue: &mut Queue) {
    let fates = &answer.probe.fates;
    if fates.is_empty() {
        ui.weak("No sample here is an extremum in place and scale.");
        return;
    }
    heading_ui(ui);
    let seen = fates.len().min(ROWS_SEEN) as f32;
    ui.spacing_mut().item_spacing.y = 0.0;
    ScrollArea::vertical().id_salt("fates").max_height(seen * ROW).auto_shrink([false, true]).show_rows(
        ui,
        ROW,
        fates.len(),
        |ui, rows| {
            for index in rows {
                if row_ui(ui, index, &fates[index], answer.probe.subject.fate == Some(index)) {
                    model.probe.look_at(Wanted::Candidate(fates[index].of_sample()));
                }
            }
        },
    );
    ui.spacing_mut().item_spacing.y = 3.0;
    ui.add_space(4.0);
    match answer.probe.subject_fate() {
        Some(fate) => fate_ui(ui, model, fate, queue),
        None => {
            ui.add(Label::new(RichText::new("No candidate at this slope and scale.").weak()).wrap());
        }
    }
}

/// Positions of the list's columns, as fractions of its width: σ, slope and strength end there, the test begins there.
const COLUMNS: [f32; 4] = [0.12, 0.42, 0.58, 0.61];

fn heading_ui(ui: &mut Ui) {
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), ROW), Sense::hover());
    let colour = ui.visuals().weak_text_color();
    let font = TextStyle::Small.resolve(ui.style());
    let names = ["σ px", "slope", "SNR", "fails first at"];
    for ((name, x), align) in names.into_iter().zip(COLUMNS).zip(ALIGNS) {
        let pos = egui::pos2(rect.left() + x * rect.width(), rect.center().y);
        ui.painter().text(pos, align, name, font.clone(), colour);
    }
    response.on_hover_text(
        "Samples that are extrema in place and scale at their own slope, however weak; what came farthest is first",
    );
}

const ALIGNS: [Align2; 4] = [Align2::RIGHT_CENTER, Align2::RIGHT_CENTER, Align2::RIGHT_CENTER, Align2::LEFT_CENTER];

/// Draws one candidate; returns whether it was clicked.
fn row_ui(ui: &mut Ui, index: usize, fate: &Fate, selected: bool) -> bool {
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), ROW), Sense::click());
    let visuals = ui.visuals();
    if selected || response.hovered() {
        let fill = if selected { visuals.selection.bg_fill } else { visuals.widgets.hovered.weak_bg_fill };
        ui.painter().rect_filled(rect, 2.0, fill);
    }
    let colour = if selected { visuals.selection.stroke.color } else { visuals.text_color() };
    let outcome = match fate.first_failed {
        None => "kept".to_owned(),
        Some(test) => {
            let margin = fate.report(test).margin().map(margin_text).unwrap_or_default();
            format!("{} {margin}", short_name(test))
        }
    };
    let strength = if fate.snr.is_finite() { number(fate.snr, 1) } else { "∞".to_owned() };
    let font = FontId::proportional(12.0);
    for ((text, x), align) in
        [number(fate.sigma, 1), slope_text(fate.slope), strength, outcome.clone()].iter().zip(COLUMNS).zip(ALIGNS)
    {
        let pos = egui::pos2(rect.left() + x * rect.width(), rect.center().y);
        let good = *text == outcome && fate.is_kept() && !selected;
        let colour = if good { style::good(ui) } else { colour };
        ui.painter().text(pos, align, text, font.clone(), colour);
    }
    let name = format!("Candidate {}: {}", index + 1, outcome.trim());
    response.widget_info(|| egui::WidgetInfo::selected(egui::Role::Button, true, selected, &name));
    let [u, v] = fate.pos_image;
    let clicked = response.clicked();
    response.on_hover_text(format!(
        "At ({}, {}), octave {}, level {}\nD {:+.2e}, its noise {:.2e}\n{}",
        number(u, 1),
        number(v, 1),
        fate.octave,
        fate.level,
        fate.value,
        fate.sigma_d,
        counted_from_one(&fate.verdict)
    ));
    clicked
}

/// Distance beyond or short of a limit, in percent; empty from 1000 % on.
fn margin_text(margin: f64) -> String {
    if margin.is_finite() && margin.abs() < 10.0 {
        format!("{:+.0} %", 100.0 * margin).replace('-', "−")
    } else {
        String::new()
    }
}

/// Draws the verdict, the remedy, and every test in order.
fn fate_ui(ui: &mut Ui, model: &mut Model, fate: &Fate, queue: &mut Queue) {
    let verdict = counted_from_one(&fate.verdict);
    ui.add(Label::new(RichText::new(sentence(&verdict)).strong()).wrap());
    if let Some(remedy) = &fate.remedy {
        let then = remedy
            .then_fails
            .map_or_else(String::new, |test| format!(" It would then be rejected as {}.", test.reason()));
        ui.add(Label::new(format!("{}{then}", sentence(&remedy.sentence))).wrap());
        ui.horizontal(|ui| {
            apply_ui(ui, model, &remedy.change, queue);
            ui.label(RichText::new(remedy.change.label()).weak());
        });
    }
    if let Some(rival) = fate.first_failed.and_then(|test| fate.report(test).rival) {
        rival_ui(ui, model, &rival);
    }
    ui.add_space(2.0);
    egui::Grid::new("tests").num_columns(5).spacing([6.0, 1.0]).striped(true).show(ui, |ui| {
        for report in &fate.tests {
            test_ui(ui, report, fate.first_failed == Some(report.test));
        }
    });
}

/// Makes a sentence: adds a capital letter and a full stop.
pub(super) fn sentence(text: &str) -> String {
    let mut letters = text.chars();
    let first = letters.next().map(|c| c.to_uppercase().to_string()).unwrap_or_default();
    format!("{first}{}.", letters.as_str())
}

fn rival_ui(ui: &mut Ui, model: &mut Model, rival: &Rival) {
    let label = rival
        .feature
        .map_or_else(|| "Go to the stronger one".to_owned(), |index| format!("Go to feature {}", index + 1));
    let [u, v] = rival.pos_image;
    let tip = format!("At ({}, {}), slope {}", number(u, 1), number(v, 1), slope_text(rival.slope));
    if ui.button(label).on_hover_text(tip).clicked() {
        let side = model.probe.side;
        if rival.feature.is_some() && side == Side::A {
            model.selected = rival.feature;
        }
        model.focus_on_side(side);
        let pane = model.focused_mut();
        pane.cursor.slope = rival.slope;
        pane.show_slope();
        let (before, zoom) = (pane.view, pane.view.points_per_pixel().max(1.0));
        pane.view.look_at(egui::pos2(u, v), zoom);
        let focus: PaneId = model.focus();
        model.panes.follow_view(focus, &before);
    }
}

/// Draws one test: its outcome, name, value, limit and margin.
fn test_ui(ui: &mut Ui, report: &TestReport, first: bool) {
    let (mark, colour, says) = match report.outcome {
        Outcome::Passes => ("✔", style::good(ui), "passes"),
        Outcome::Fails if first => ("✖", ui.visuals().error_fg_color, "fails: the search's verdict"),
        Outcome::Fails => ("✖", style::warning(ui), "would fail too"),
        Outcome::NotAsked => ("–", ui.visuals().weak_text_color(), "is not applied"),
        Outcome::Unknown => ("?", ui.visuals().weak_text_color(), "cannot be decided"),
    };
    let (value, limit) = numbers_of(report);
    let margin = report.margin().map(margin_text).unwrap_or_default();
    let tip = format!("{}: {says}", crate::inspect::report::test_name(report.test));
    let small = |text: String| RichText::new(text).size(12.0);
    let accessible = format!("{tip} {value} {limit}");
    ui.label(RichText::new(mark).color(colour));
    let mut name = small(short_name(report.test).to_owned());
    if first {
        name = name.strong();
    }
    let response = ui.label(name);
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Label, true, &accessible));
    response.on_hover_text(&tip);
    for text in [value, limit, margin] {
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            ui.label(small(text).color(ui.visuals().text_color())).on_hover_text(&tip);
        });
    }
    ui.end_row();
}

fn numbers_of(report: &TestReport) -> (String, String) {
    let sign = if report.side == crate::inspect::fate::Side::AtLeast { '≥' } else { '≤' };
    let value = report.value.map(value_text).unwrap_or_default();
    (value, report.limit.map_or_else(String::new, |limit| format!("{sign} {}", value_text(limit))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inspect::fate::Side;

    #[test]
    fn margins_are_percents_with_a_real_minus_and_nothing_where_they_say_nothing() {
        let texts = [(0.25, "+25 %"), (-0.081, "−8 %"), (0.0, "+0 %"), (12.0, ""), (f64::INFINITY, "")];
        for (margin, text) in texts {
            assert_eq!(margin_text(margin), text);
        }
    }

    #[test]
    fn a_test_says_its_value_and_on_which_side_of_the_limit_it_passes() {
        let report = TestReport {
            test: Test::NoiseGate,
            outcome: Outcome::Fails,
            value: Some(3.9),
            limit: Some(4.64),
            side: Side::AtLeast,
            unit: "σ",
            rival: None,
        };
        assert_eq!(numbers_of(&report), ("3.9".to_owned(), "≥ 4.64".to_owned()));
        let edge = TestReport { test: Test::Edge, side: Side::AtMost, ..report };
        assert_eq!(numbers_of(&edge).1, "≤ 4.64");
        assert_eq!(numbers_of(&TestReport { value: None, limit: None, ..report }), (String::new(), String::new()));
    }

    #[test]
    fn each_test_has_a_short_name_of_its_own() {
        let mut names: Vec<&str> = Test::ALL.map(short_name).to_vec();
        assert!(names.iter().all(|name| name.len() <= 14), "{names:?}");
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), Test::ALL.len());
    }

    #[test]
    fn sentences_begin_with_a_capital_and_end_with_a_stop() {
        assert_eq!(sentence("élan is kept"), "Élan is kept.");
        assert_eq!(sentence("σ is 2"), "Σ is 2.");
        assert_eq!(sentence(""), ".");
    }
}
