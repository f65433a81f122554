//! Status bar, and the messages above it: errors, the offer to restore a session, and advice after a detection.

use crate::app::actions::{ActionId, Queue};
use crate::app::document::Action;
use crate::app::messages::Messages;
use crate::app::panel::widgets::{confirm_ui, named, progress_text, text_width};
use crate::app::recovery::{Offer, RecoveryChoice};
use crate::app::results::{Own, Read};
use crate::inspect::words::counted;
use egui::{Align, Align2, Area, Button, Frame, Id, Label, Layout, RichText, Ui, vec2};

/// Points by which the room of a value grows.
const READOUT_STEP: f32 = 80.0;
/// Points that the name of the burst and a note keep beside a value.
const READOUT_REST: f32 = 300.0;

/// Draws the status bar. Returns whether the path is to be typed for which a dialog returned none.
pub fn status_ui(ui: &mut Ui, model: Read<'_>, readout: Option<&str>, queue: &mut Queue) -> bool {
    let mut types_path = false;
    ui.horizontal(|ui| {
        let text = RichText::new(readout.unwrap_or_default()).monospace();
        // A long value takes more room in whole steps, so that nothing beside it moves with each of its digits.
        let least = if model.document.panes.are_many() { 460.0 } else { 330.0 };
        let steps = ((text_width(ui, text.clone()) - least) / READOUT_STEP).ceil().max(0.0);
        let width = (least + READOUT_STEP * steps).min(ui.available_width() - READOUT_REST).max(least);
        ui.allocate_ui_with_layout(egui::vec2(width, 18.0), Layout::left_to_right(Align::Center), |ui| {
            ui.set_min_width(width);
            if let Some(readout) = readout {
                ui.add(Label::new(text).truncate()).on_hover_text(readout);
            }
        });
        ui.add_visible(readout.is_some(), egui::Separator::default());
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            ui.add(Label::new(RichText::new(burst_text(model)).weak()).truncate());
            notes_ui(ui, model);
            let [a, b] = model.results.slots.both();
            let opening = a.opening.running.map(|running| ("Opening…", running));
            if let Some((what, running)) = opening.or(b.opening.running.map(|running| ("Opening B…", running))) {
                let percent = running.progress.map_or(0.0, |p| 100.0 * p.fraction);
                let cancels = a.burst.is_some() && ui.small_button("Cancel opening").clicked();
                queue.push_if(cancels, ActionId::Cancel);
                ui.label(format!("{what} {percent:.0} %"));
            }
            let coherence = "Computing how well the single frames agree on each feature";
            let figures = "Remaking the figures of the paper";
            for (what, running, cancel, tip) in [
                ("Coherence", model.results.coherence.running(), ActionId::Cancel, coherence),
                ("Figures", model.results.figures.running, ActionId::CancelFigures, figures),
            ] {
                let Some(running) = running else { continue };
                queue.push_if(ui.small_button(format!("Cancel {}", what.to_lowercase())).clicked(), cancel);
                ui.label(format!("{what}  {}", progress_text(&running))).on_hover_text(tip);
            }
            let help = "Type the path, if no dialog appeared or it cannot be used";
            types_path = model.shell.messages.unanswered.is_some()
                && ui.small_button("Type the path…").on_hover_text(help).clicked();
            ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                if let Some(note) = &model.shell.messages.note {
                    ui.add(Label::new(note).truncate());
                }
            });
        });
    });
    types_path
}

/// Draws the number of notes on how the burst was read, if any; a click shows them, for which the bar has no space.
fn notes_ui(ui: &mut Ui, model: Read<'_>) {
    let Some(burst) = model.burst_of(model.active_side()).map(|open| &open.burst) else { return };
    let notes = burst.notes();
    if notes.is_empty() {
        return;
    }
    // What was taken as the files say it is no fault.
    let is_warning = notes.len() > burst.taken.len();
    let title = RichText::new(counted(notes.len(), if is_warning { "warning" } else { "note" }));
    ui.menu_button(if is_warning { title.color(crate::app::style::warning(ui)) } else { title.weak() }, |ui| {
        ui.set_max_width(420.0);
        for note in notes {
            ui.add(Label::new(note.for_window()).wrap());
        }
    });
}

fn burst_text(model: Read<'_>) -> String {
    let side = model.active_side();
    let Some(open) = model.burst_of(side) else { return "No burst open".to_owned() };
    // With two bursts, the text names this one.
    let which = if model.document.workspace.shows_pair() { format!("{}: ", side.name()) } else { String::new() };
    let burst = &open.burst;
    let (width, height) = burst.size();
    let depth = if burst.quantisation_step > 0.0 {
        // Twelve bits in the upper part of a 16-bit word end slightly below full scale: whole steps and the level at 0.
        format!(" · {:.0} levels", (1.0 / burst.quantisation_step + 0.02).floor() + 1.0)
    } else {
        " · float".to_owned()
    };
    format!("{which}{} · {} · {width} × {height}{depth}", burst.name, counted(burst.len(), "frame"))
}

/// Draws the errors above all that stands below the pictures, `below` points high.
pub fn messages_ui(ctx: &egui::Context, messages: &Messages, below: f32, queue: &mut Queue) {
    Area::new(Id::unique("messages")).anchor(Align2::RIGHT_BOTTOM, vec2(-12.0, -36.0 - below)).show(ctx, |ui| {
        for message in &messages.errors {
            let colour = ui.visuals().error_fg_color;
            Frame::popup(ui.style()).stroke(egui::Stroke::new(1.0, colour)).show(ui, |ui| {
                ui.set_width(400.0);
                ui.horizontal(|ui| {
                    ui.label(RichText::new(&message.title).strong().color(colour));
                    ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                        let close = ui.add(egui::Button::new("✖").frame(false)).on_hover_text("Dismiss");
                        named(&close, egui::Role::Button, format!("Dismiss: {}", message.title));
                        queue.push_if(close.clicked(), Action::DismissMessage(message.id));
                        if ui.small_button("Copy").on_hover_text("Copy the message").clicked() {
                            ui.ctx().copy_text(format!("{}: {}", message.title, message.text));
                        }
                    });
                });
                ui.add(egui::Label::new(&message.text).wrap());
            });
        }
    });
}

/// Draws what was set for the burst before, and offers it to the open one.
pub fn left_behind_ui(ui: &mut Ui, own: &Own, queue: &mut Queue) {
    let (sentence, use_it) = own.offer();
    ui.horizontal_wrapped(|ui| {
        ui.label(sentence);
        let uses = ui.button(use_it).on_hover_text("Set this burst as the one before was").clicked();
        queue.push_if(uses, Action::TakeLeftBehind(true));
        let dismisses = ui.button("Dismiss").on_hover_text("Leave it as it is").clicked();
        queue.push_if(dismisses, Action::TakeLeftBehind(false));
    });
}

pub fn recovery_ui(ui: &mut Ui, offer: &Offer) -> Option<RecoveryChoice> {
    let mut choice = None;
    ui.horizontal_wrapped(|ui| {
        let more = if offer.more == 0 { String::new() } else { format!(" ({} more)", offer.more) };
        let text = format!("The last session was not closed. It was saved {}: {}{more}.", ago(offer.age), offer.label);
        ui.label(RichText::new(text).color(crate::app::style::warning(ui)));
        for (words, tip, chosen) in [
            ("Restore", "Open the saved session in place of what is open now", RecoveryChoice::Restore),
            ("Later", "Offer it again at the next start", RecoveryChoice::Later),
            ("Discard…", "Delete the saved session; the files that it names stay", RecoveryChoice::Discard),
        ] {
            let button = ui.add_enabled(!offer.is_restoring, Button::new(words)).on_hover_text(tip);
            choice = button.clicked().then_some(chosen).or(choice);
        }
    });
    if !offer.is_asking {
        return choice;
    }
    let answer = confirm_ui(ui.ctx(), "discard session", "Delete the saved session?", "Delete", |ui| {
        ui.label(format!("{}, saved {}", offer.label, ago(offer.age)));
        ui.weak("It cannot be restored afterwards. The files that it names stay.");
    });
    answer.map(|removes| if removes { RecoveryChoice::Remove } else { RecoveryChoice::Keep })
}

fn ago(age: std::time::Duration) -> String {
    let minutes = age.as_secs() / 60;
    let (count, unit) = match minutes {
        0 => return "just now".to_owned(),
        1..60 => (minutes, "minute"),
        60..2880 => (minutes / 60, "hour"),
        _ => (minutes / 1440, "day"),
    };
    format!("{} ago", counted(count as usize, unit))
}
