//! Slopes of the burst: features and evidence at each slope, and advice; slopes from the set-up (speed, turning, frame
//! rate, lens and depths), and slopes read as depths.

pub(super) mod chart;

use crate::app::actions::{ActionId, button_ui};
use crate::app::document::{Action, Queue, Side};
use crate::app::panel::widgets::{error_ui, named, warning_ui, weak_ui, with_whole_numbers};
use crate::app::results::{FoundFeatures, Read};
use crate::app::style;
use crate::app::view::{number, signed_slope};
use crate::burst::OpenOptions;
use crate::detector::{Method, Slope, SlopeFinding, SlopeVerdict};
use crate::inspect::result::TooFew;
use crate::inspect::slopes::{SetUp, SlopeAdvice, SlopeJudgement, Spectrum, set_up_bounds};
use crate::inspect::words::{counted, grouped};
use egui::{Align, Button, DragValue, Frame, Grid, Label, Margin, RichText, Role, ScrollArea, Ui, WidgetInfo, vec2};

/// Maximum width of the charts, points; the advice gets the rest.
const CHART_WIDTH: f32 = 400.0;

pub fn summary(model: Read<'_>, _: &FoundFeatures) -> Option<[String; 2]> {
    let spectrum = model.spectrum()?;
    let features = counted(spectrum.features, "feature");
    let text = format!("{features} at {}", counted(spectrum.cost.slopes, "slope"));
    Some([text, format!("The frames: {}", spectrum.finding.summary_beside_judgement())])
}

pub fn slopes_ui(ui: &mut Ui, model: Read<'_>, queue: &mut Queue) {
    let Some(spectrum) = model.spectrum() else { return waiting_ui(ui, model, queue) };
    ui.spacing_mut().item_spacing.x = 14.0;
    let height = ui.available_height();
    ui.horizontal_top(|ui| {
        // Room for the longest heading beside it.
        let width = CHART_WIDTH.min(0.55 * ui.available_width()).min(ui.available_width() - 175.0);
        ui.allocate_ui_with_layout(vec2(width, height), egui::Layout::top_down(Align::Min), |ui| {
            ui.set_width(width);
            let marks = chart::Marks { here: model.document.cursor().slope, expected: expected(model) };
            let chart_ui = if spectrum.grid.is_plane() { chart::plane_ui } else { chart::line_ui };
            chart_ui(ui, spectrum, &marks, height);
        });
        ui.vertical(|ui| advice_list_ui(ui, model, spectrum, queue));
    });
}

fn waiting_ui(ui: &mut Ui, model: Read<'_>, queue: &mut Queue) {
    ui.vertical_centered(|ui| {
        ui.add_space(16.0);
        if model.results.slots.a.found.is_none() {
            ui.weak(model.without_features(Side::A, "Press Detect to see which slopes the burst needs"));
        } else if model.stale().is_some() {
            let press = "The parameters changed: press Detect to see which slopes the burst needs";
            ui.weak(model.without_features(Side::A, press));
        } else if model.found_of(Side::A).is_some_and(|found| found.params.method != Method::Buff) {
            ui.weak("One image has no slopes: choose the method BuFF");
        } else if model.slopes_take_long() && !model.results.explained.slopes_wanted {
            let secs = model.found_of(Side::A).map_or(0.0, |found| found.elapsed.as_secs_f32());
            let tip = format!("It takes about as long as the detection did, {secs:.0} s, in the background");
            queue.push_if(ui.button("Analyse slopes").on_hover_text(tip).clicked(), Action::ExamineSlopes);
        } else {
            ui.weak("Analysing the slopes…");
        }
    });
    set_up_ui(ui, model, queue);
}

fn advice_list_ui(ui: &mut Ui, model: Read<'_>, spectrum: &std::sync::Arc<Spectrum>, queue: &mut Queue) {
    ScrollArea::vertical().auto_shrink(false).id_salt("slope advice").show(ui, |ui| {
        if let Some(judgement) = spectrum.judgement.as_ref().filter(|judgement| judgement.advice.is_none()) {
            faultless_ui(ui, model, judgement, "");
        }
        for (index, advice) in spectrum.advice.iter().enumerate() {
            let name = if index == 0 { "Apply".to_owned() } else { format!("Apply {}", index + 1) };
            piece_ui(ui, model, &name, advice, queue);
        }
        set_up_ui(ui, model, queue);
        let cost = &spectrum.cost;
        let text = format!("Cost: {}, {} samples", counted(cost.slopes, "slope"), grouped(cost.samples));
        weak_ui(ui, text).on_hover_text(format!("Search time: {} s", number(cost.search_secs, 2)));
    });
}

/// Draws a judgement without a fault and what follows it, in the colour of success only if the slopes fit; otherwise
/// with the number of features that noise would give, once decoys are known.
fn faultless_ui(ui: &mut Ui, model: Read<'_>, judgement: &SlopeJudgement, then: &str) {
    let colour = if judgement.fits { style::good(ui) } else { style::warning(ui) };
    let decoys = model.decoys().filter(|_| !judgement.fits);
    let of_noise = decoys.map_or_else(String::new, |decoys| format!("; {}", decoys.report.expected_words()));
    let text = RichText::new(sentence_of(&format!("{}{of_noise}{then}", judgement.sentence))).color(colour);
    ui.add(Label::new(text).wrap());
}

fn sentence_of(clause: &str) -> String {
    with_whole_numbers(&crate::inspect::words::sentence(clause))
}

fn piece_ui(ui: &mut Ui, model: Read<'_>, name: &str, advice: &SlopeAdvice, queue: &mut Queue) {
    warning_ui(ui, sentence_of(&advice.sentence));
    let times = advice.times.iter().map(|times| format!("Times {times}"));
    let changes = advice.changes.iter().map(|change| change.label()).chain(times).collect::<Vec<_>>().join(", ");
    if !advice.options().is_empty() {
        ui.horizontal_wrapped(|ui| {
            ui.spacing_mut().item_spacing.x = 6.0;
            if is_applied(ui, model, name, &changes) {
                queue.push(match advice.times.clone() {
                    None => Action::ApplyChanges(Side::A, advice.changes.clone()),
                    times => Action::Calibrate(OpenOptions { times, ..model.document.calibration.clone() }),
                });
            }
            ui.label(RichText::new(changes).monospace());
        });
    }
    ui.add_space(6.0);
}

fn is_applied(ui: &mut Ui, model: Read<'_>, name: &str, changes: &str) -> bool {
    let button = ui.add_enabled(model.takes_advice(Side::A), Button::new("Apply"));
    named(&button, Role::Button, name);
    button.on_hover_text(format!("Set {changes}; Ctrl+Z undoes it")).clicked()
}

fn too_few_ui(ui: &mut Ui, model: Read<'_>, few: &TooFew, queue: &mut Queue) {
    ui.horizontal_wrapped(|ui| {
        let text = warning_ui(ui, with_whole_numbers(&few.for_window()));
        if let Some((change, _)) = &few.change {
            text.on_hover_text(change.parameter.help());
            let is_applied = is_applied(ui, model, "Apply setting", &change.label());
            queue.push_if(is_applied, Action::ApplyChanges(Side::A, vec![change.clone()]));
        }
        if model.features().is_empty() && model.document.workspace.inspects() {
            button_ui(ui, model, queue, ActionId::ProbeStrongest, None);
        }
    });
}

/// Slopes that were found from the frames, a clause; `None` where none were, or the finding says that something is odd.
pub fn found_words(finding: &SlopeFinding) -> Option<String> {
    let is_plain = finding.verdict == SlopeVerdict::Found && finding.warnings.is_empty();
    is_plain.then(|| format!("found: {}", crate::detector::slopes::grid_text(&finding.grid)))
}

/// Draws the verdict on the search, below the parameters of *One burst*: why there are few features, or whether the
/// slopes fit the burst, with the change that mends it, and which were found. The open tab has the judgement itself.
pub fn verdict_ui(ui: &mut Ui, model: Read<'_>, queue: &mut Queue) {
    let few = model.too_few();
    let is_in_tab = model.shows_bottom() && model.document.bottom_tab == crate::teach::BottomTab::Slopes;
    let judgement = model.slope_judgement().filter(|_| !is_in_tab || model.spectrum().is_none());
    let found = model.found_of(Side::A).filter(|_| model.document.params.slopes.is_auto());
    let found = found.and_then(|found| found_words(found.finding.as_ref()?));
    if few.is_none() && judgement.is_none() && found.is_none() {
        return;
    }
    let fill = ui.visuals().faint_bg_color;
    Frame::new().fill(fill).corner_radius(4).inner_margin(Margin::symmetric(8, 5)).show(ui, |ui| {
        ui.set_width(ui.available_width());
        if let Some(few) = few {
            too_few_ui(ui, model, few, queue);
        }
        if let Some(judgement) = judgement.filter(|judgement| judgement.advice.is_none()) {
            faultless_ui(ui, model, judgement, &found.map_or_else(String::new, |found| format!("; {found}")));
            return;
        }
        // Without features it comes second; the tab has it.
        if let Some(of_slopes) = judgement.and_then(|judgement| judgement.advice.as_ref()).filter(|_| few.is_none()) {
            piece_ui(ui, model, "Apply slopes", of_slopes, queue);
        }
        if let Some(found) = found {
            weak_ui(ui, sentence_of(&found));
        }
    });
}

/// Slopes of the nearest and the farthest things, while the set-up is in use: unfolded, or read for depths.
fn expected(model: Read<'_>) -> Option<[Slope; 2]> {
    let state = &model.document.set_up;
    let in_use = (state.is_open || state.reads_depths) && state.values.check().is_ok();
    in_use.then(|| state.values.depth_m.map(|metres| state.values.slope_at(metres)))
}

fn set_up_ui(ui: &mut Ui, model: Read<'_>, queue: &mut Queue) {
    let mut state = model.document.set_up;
    let header = egui::CollapsingHeader::new("Slopes from the set-up").id_salt("slopes from the set-up");
    let unfolded = header.open(Some(model.document.set_up.is_open)).show(ui, |ui| {
        fields_ui(ui, &mut state.values);
        slopes_of_set_up_ui(ui, model, queue);
    });
    if unfolded.header_response.clicked() {
        state.is_open ^= true;
    }
    queue.edit(model.document, Action::SetSetUp(state));
}

fn fields_ui(ui: &mut Ui, values: &mut SetUp) {
    let SetUp { speed_m_s, direction_deg, turn_deg_s, frames_per_second, focal_px, depth_m } = values;
    let [near, far] = depth_m;
    let field = |ui: &mut Ui, name: &str, help: &str, widget: DragValue<'_>| {
        let response = ui.add(widget).on_hover_text(help);
        response.widget_info(|| WidgetInfo::labeled(Role::SpinButton, true, name));
    };
    Grid::new("set-up").num_columns(3).show(ui, |ui| {
        ui.label("Motion");
        let speed = DragValue::new(speed_m_s).range(set_up_bounds::SPEED.span()).speed(0.01).suffix(" m/s");
        field(ui, "Speed", "Speed of the camera parallel to its picture", speed);
        let direction = DragValue::new(direction_deg).range(set_up_bounds::DIRECTION.span()).suffix("°");
        field(ui, "Direction of motion", "Direction of that motion, from right towards down", direction);
        ui.end_row();
        ui.label("Turning");
        let turn = DragValue::new(turn_deg_s).range(set_up_bounds::TURN.span()).speed(0.05).suffix("°/s");
        field(ui, "Turning", "Turning of the camera to the right", turn);
        ui.end_row();
        ui.label("Camera");
        let rate = DragValue::new(frames_per_second).range(set_up_bounds::RATE.span()).suffix(" /s");
        field(ui, "Frame rate", "Frames per second", rate);
        let focal = DragValue::new(focal_px).range(set_up_bounds::FOCAL.span()).suffix(" px");
        field(ui, "Focal length", "Focal length in pixels", focal);
        ui.end_row();
        ui.label("Depths");
        for (name, help, metres) in
            [("Nearest", "Depth of the nearest things", near), ("Farthest", "Depth of the farthest things", far)]
        {
            let depth = DragValue::new(metres).range(set_up_bounds::DEPTH.span()).speed(0.02).suffix(" m");
            field(ui, name, help, depth);
        }
        ui.end_row();
    });
}

fn slopes_of_set_up_ui(ui: &mut Ui, model: Read<'_>, queue: &mut Queue) {
    let set_up = model.document.set_up.values;
    let slopes = set_up.slopes(&model.used_positions(), &model.params_of(Side::A));
    ui.horizontal(|ui| {
        let can_apply = slopes.is_ok() && model.takes_advice(Side::A);
        let apply = ui.add_enabled(can_apply, Button::new("Apply"));
        apply.widget_info(|| WidgetInfo::labeled(Role::Button, can_apply, "Apply set-up"));
        queue.push_if(apply.on_hover_text("Search these slopes; Ctrl+Z undoes it").clicked(), Action::ApplySetUp);
        let mut reads = model.document.set_up.reads_depths;
        let tip =
            "Give every feature the depth that its motion means, with its error: in the table, in the tips over the picture, and as colours";
        let response = ui.checkbox(&mut reads, "Read slopes as depths").on_hover_text(tip);
        queue.push_if(response.changed(), Action::ReadDepths(reads));
    });
    match slopes {
        Ok(slopes) => ui.add(Label::new(slopes.sentence(&set_up)).wrap()),
        Err(problem) => error_ui(ui, problem),
    };
    let here = model.document.cursor().slope;
    let depth = set_up.depth_at(here);
    let means = depth.map_or_else(|| "no depth".to_owned(), |metres| format!("{} m", number(metres as f32, 3)));
    ui.weak(format!("The slope on show, ({}), means {means}", signed_slope(here, 2)));
}
