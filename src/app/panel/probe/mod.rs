//! Probe panel, with the answers of [`crate::inspect`]: the candidates at a place, and the reasons for their fates.

mod fates;
mod response;
mod shares;

use crate::app::actions::{ActionId, Queue, button_ui};
use crate::app::document::{Action, Destination, FeaturesShown, PinnedPlace, Side};
use crate::app::panel::widgets::{name_field, named, progress_ui, section_ui, warning_ui, weak_ui};
use crate::app::parts::mark;
use crate::app::results::{Read, verdict_words};
use crate::app::{style, view::signed};
use crate::detector::{ParamChange, Slope};
use crate::inspect::place::{CauseKind, Judged, ProbeSubject, Suspicion, Verdict};
use crate::inspect::words::{capitalised, number, sentence, slope_text};
use crate::requests::{ProbeQuestion, Probed};
use crate::teach::Part;
use egui::{Frame, Label, Margin, RichText, ScrollArea, Stroke, TextEdit, Ui};

/// Draws the right panel's tabs, and the probe if its tab is open. Returns whether it is; if not, the caller draws the
/// content of the `other` tab. Without a probe of a burst of this workspace nothing is drawn.
pub fn probe_tab_ui(ui: &mut Ui, model: Read<'_>, other: &str, help: &str, queue: &mut Queue) -> bool {
    if model.document.probe.side == Side::B && !model.document.workspace.shows_pair() {
        return false;
    }
    if model.has_probe() {
        let mut is_open = model.document.probe.is_open;
        ui.horizontal(|ui| {
            ui.selectable_value(&mut is_open, false, other).on_hover_text(help);
            ui.selectable_value(&mut is_open, true, "Probe")
                .on_hover_text("Why there is a feature at a place, or why there is none");
        });
        queue.edit(model.document, Action::OpenProbe(is_open));
        ui.separator();
    }
    if model.document.probe.is_open {
        probe_ui(ui, model, queue);
    }
    model.document.probe.is_open
}

fn probe_ui(ui: &mut Ui, model: Read<'_>, queue: &mut Queue) {
    mark(ui, Part::Probe, ui.max_rect());
    tools_ui(ui, model, queue);
    busy_ui(ui, model);
    if let Some(problem) = &model.results.probed.problem {
        warning_ui(ui, problem);
    }
    let Some(answer) = &model.results.probed.answer else {
        if model.document.probe.question.is_none() {
            ui.add_space(4.0);
            weak_ui(ui, "Shift+click a place of a picture to see why there is a feature, or why there is none.");
        }
        return;
    };
    let [u, v] = answer.probe.pos_image;
    // The explanation of another place begins at its top.
    let place = ("probe", u.to_bits(), v.to_bits());
    ScrollArea::vertical().id_salt(place).auto_shrink(false).show(ui, |ui| {
        let of_pair = model.document.workspace.shows_pair().then_some(model.document.probe.side.name());
        let burst = of_pair.map_or_else(String::new, |name| format!(" of {name}"));
        ui.label(RichText::new(format!("Place ({}, {}){burst}", number(u, 1), number(v, 1))).strong())
            .on_hover_text("At mid-burst, pixels; the centre of the first pixel is (0, 0)");
        stale_ui(ui, model, queue);
        ui.add(Label::new(&answer.probe.summary).wrap());
        reasons_ui(ui, model, answer, queue);
        ui.add_space(4.0);
        suspicions_ui(ui, model, answer, queue);
        section_ui(ui, "Candidates here", |ui| fates::fates_ui(ui, model, answer, queue));
        section_ui(ui, "Response over slope and scale", |ui| {
            response::response_ui(ui, model, answer, queue);
            mark(ui, Part::Response, ui.min_rect());
        });
        section_ui(ui, "Each frame's response", |ui| {
            shares::shares_ui(ui, model, answer, queue);
            mark(ui, Part::Shares, ui.min_rect());
        });
    });
}

fn tools_ui(ui: &mut Ui, model: Read<'_>, queue: &mut Queue) {
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        button_ui(ui, model, queue, ActionId::ProbeFollow, Some("Follow pointer"));
        button_ui(ui, model, queue, ActionId::ProbeFeature, Some("Selected"));
        button_ui(ui, model, queue, ActionId::ProbeStrongest, Some("Strongest"));
        button_ui(ui, model, queue, ActionId::CloseProbe, Some("Clear probe"));
        button_ui(ui, model, queue, ActionId::PinPlace, Some("Pin place"));
    });
    ui.add_space(2.0);
    let side = model.document.probe.side;
    let mut places = model.places_of(side).peekable();
    if places.peek().is_some() {
        ScrollArea::vertical().id_salt("pinned").max_height(140.0).show(ui, |ui| {
            places.for_each(|pinned| place_ui(ui, side, pinned, queue));
        });
    }
}

/// Draws the row of a pinned place, in which it is probed, gets another name, and is removed.
fn place_ui(ui: &mut Ui, side: Side, (index, place): (usize, &PinnedPlace), queue: &mut Queue) {
    let (mut name, [u, v]) = (place.name.clone(), place.at.map(|x| number(x, 1)));
    ui.horizontal(|ui| {
        let again = ui.small_button("Probe").on_hover_text(format!("Probe ({u}, {v}) again"));
        named(&again, egui::Role::Button, format!("Probe {name}"));
        let question = ProbeQuestion::At { place: place.at, wanted: ProbeSubject::Best };
        queue.push_if(again.clicked(), Action::Probe(side, question));
        let field = ui.add(TextEdit::singleline(&mut name).desired_width(110.0));
        name_field(&field, "Name of place", &name);
        let remove = ui.small_button("Remove").on_hover_text("No longer keep this place");
        named(&remove, egui::Role::Button, format!("Remove {name}"));
        queue.push_if(remove.clicked(), Action::ForgetPlace(index));
    });
    queue.set(&place.name, name, |name| Action::NamePlace(index, name));
}

fn busy_ui(ui: &mut Ui, model: Read<'_>) {
    let (asked, probed) = (&model.document.probe, &model.results.probed);
    let running = probed.wanted_trail.running.or(model.results.slots[asked.side].detecting.running);
    if let Some(running) = running.filter(|_| asked.is_on()) {
        let percent = running.progress.map_or(0.0, |p| 100.0 * p.fraction);
        progress_ui(ui, &running, None, &format!("Searching  {percent:.0} %"));
    } else if asked.question.is_some() && probed.answer.is_none() && probed.problem.is_none() {
        ui.weak("Probing…");
    }
}

fn stale_ui(ui: &mut Ui, model: Read<'_>, queue: &mut Queue) {
    if model.probe_is_stale() && !model.results.slots[model.document.probe.side].detecting.is_pending() {
        ui.horizontal_wrapped(|ui| {
            ui.label(RichText::new("Stale: found with other parameters").color(style::warning(ui)));
            let response = ui.small_button("Detect again").on_hover_text("Search with the parameters as they are now");
            queue.push_if(response.clicked(), ActionId::Detect);
        });
    }
}

/// Reasons that no single candidate tells, each with what can be done about it.
fn reasons_ui(ui: &mut Ui, model: Read<'_>, answer: &Probed, queue: &mut Queue) {
    for reason in &answer.probe.reasons {
        let help = match reason.kind {
            CauseKind::TooSmall => "Measured at this place, at the slope named, beyond the scales that are searched",
            CauseKind::AtAnotherSlope => "Show All features to see other slopes, or go there",
            CauseKind::Ghost => "A blob with another motion crosses here: see the responses of the frames below",
        };
        ui.add(Label::new(sentence(&reason.sentence)).wrap()).on_hover_text(help);
        if reason.change.is_some() || reason.feature.is_some() {
            ui.horizontal_wrapped(|ui| {
                reason.change.iter().for_each(|change| apply_ui(ui, model, change, queue));
                reason.feature.iter().for_each(|feature| go_to_feature_ui(ui, model, answer, *feature, queue));
            });
        }
        if reason.kind == CauseKind::AtAnotherSlope && model.document.look.overlay == FeaturesShown::ThisSlope {
            weak_ui(ui, "It is shown under All, not under This slope.");
        }
    }
    for &feature in &model.results.probed.as_dots {
        let text = format!("Feature {feature} was found here, but is drawn as a dot: stronger ones take the room.");
        ui.add(Label::new(text).wrap()).on_hover_text("Zoom in, or select it, to see it in full");
        go_to_feature_ui(ui, model, answer, feature, queue);
    }
}

fn go_to_feature_ui(ui: &mut Ui, model: Read<'_>, answer: &Probed, feature: usize, queue: &mut Queue) {
    if let Some(found) = answer.request.traced.cache.detection().features.get(feature) {
        go_to_ui(ui, model, Some(feature), ([found.u, found.v], found.slope), queue);
    }
}

/// Draws a button that shows a place at a slope, and selects the feature there if there is one.
fn go_to_ui(ui: &mut Ui, model: Read<'_>, feature: Option<usize>, place: ([f32; 2], Slope), queue: &mut Queue) {
    let ([u, v], slope) = place;
    let label = feature.map_or_else(|| "Go to the other one".to_owned(), |index| format!("Go to feature {index}"));
    let tip = format!("At ({}, {}), slope {}", number(u, 1), number(v, 1), slope_text(slope));
    let (is_clicked, side) = (ui.button(label).on_hover_text(tip).clicked(), model.document.probe.side);
    queue.push_if(is_clicked && feature.is_some() && side == Side::A, Action::Select(feature));
    let to = Destination { slope: Some(slope), at: Some(([u, v], 1.0)), ..Destination::default() };
    queue.push_if(is_clicked, Action::GoTo(side, to));
}

fn apply_ui(ui: &mut Ui, model: Read<'_>, change: &ParamChange, queue: &mut Queue) {
    let (side, label) = (model.document.probe.side, change.label());
    let tip = format!("Set {label} and detect again; Undo reverts it\n{}", change.option());
    let response = ui.add_enabled(model.takes_advice(side), egui::Button::new("Apply")).on_hover_text(tip);
    named(&response, egui::Role::Button, format!("Apply {label}"));
    if response.clicked() {
        queue.push(Action::ApplyChanges(side, vec![change.clone()]));
        queue.push_if(!model.document.auto_detect, ActionId::Detect);
    }
    ui.label(RichText::new(label).weak());
    if let Some(time) = model.search_time_text(side, change) {
        ui.add(Label::new(time).wrap());
    }
}

fn strength_text(answer: &Probed, value: f32) -> String {
    if answer.probe.response.is_noiseless { format!("{value:+.1e}") } else { format!("{} σ", signed(value, 1)) }
}

fn suspicions_ui(ui: &mut Ui, model: Read<'_>, answer: &Probed, queue: &mut Queue) {
    let is_clear = |judged: &&Judged| matches!(judged.verdict, Verdict::Real | Verdict::Unclear);
    if let Some(judged) = answer.probe.judged.as_ref().filter(is_clear) {
        let index = answer.probe.subject_fate().and_then(|fate| fate.features.first());
        let feature = index.and_then(|index| answer.request.traced.cache.detection().features.get(*index));
        ui.add(Label::new(verdict_words(feature, judged)).wrap());
        ui.add_space(4.0);
    }
    for suspicion in &answer.probe.suspicions {
        let frame = Frame::new().stroke(Stroke::new(1.0, style::warning(ui))).corner_radius(4);
        frame.inner_margin(Margin::symmetric(6, 4)).show(ui, |ui| {
            ui.set_width(ui.available_width());
            suspicion_ui(ui, model, suspicion, queue);
        });
        ui.add_space(4.0);
    }
}

fn suspicion_ui(ui: &mut Ui, model: Read<'_>, suspicion: &Suspicion, queue: &mut Queue) {
    let [name, help] = suspicion.kind.words();
    let name = RichText::new(capitalised(name) + "?").strong().color(style::warning(ui));
    ui.label(name).on_hover_text(capitalised(help));
    ui.add(Label::new(sentence(&suspicion.evidence)).wrap());
    if suspicion.change.is_none() && suspicion.other.is_none() {
        return;
    }
    ui.horizontal_wrapped(|ui| {
        suspicion.change.iter().for_each(|change| apply_ui(ui, model, change, queue));
        if let Some(other) = suspicion.other
            && ui.button(format!("Probe feature {other}")).on_hover_text("Show why that feature was kept").clicked()
        {
            queue.push(Action::ProbeFeature(model.document.probe.side, other));
        }
    });
}
