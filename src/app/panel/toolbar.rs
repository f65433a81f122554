//! Toolbar: open, the kind of picture, detect.

use crate::app::actions::{ActionId, Queue, button_ui, checked, enabled, keys_text, shown_by, tooltip};
use crate::app::document::Side;
use crate::app::panel::widgets::{in_time, progress_text, progress_ui};
use crate::app::{parts::mark, results::Read};
use crate::inspect::words::counted;
use crate::requests::{Running, ViewKind};
use crate::teach::Part;
use egui::{Align, Button, Color32, Layout, Rect, RichText, Ui};

/// Minimum room for the button that finds actions, in points.
const ROOM_FOR_FIND: f32 = 280.0;

pub fn toolbar_ui(ui: &mut Ui, model: Read<'_>, queue: &mut Queue) {
    ui.horizontal(|ui| {
        button_ui(ui, model, queue, ActionId::OpenFolder, Some("Open…"));
        ui.separator();
        let kinds = ui.scope(|ui| {
            ui.spacing_mut().item_spacing.x = 2.0;
            for kind in ViewKind::OF_CURSOR {
                button_ui(ui, model, queue, shown_by(kind), Some(kind.label()));
            }
        });
        mark(ui, Part::Kinds, kinds.response.rect);
        ui.separator();
        let before = ui.cursor().left();
        detect_ui(ui, model, queue);
        mark(ui, Part::Detect, ui.min_rect().intersect(Rect::everything_right_of(before)));
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            let palette = ActionId::Palette.action();
            let keys = palette.shortcut.map(|s| keys_text(ui.ctx(), &s)).unwrap_or_default();
            // A narrow window has the keys and the menu.
            if ui.available_width() > ROOM_FOR_FIND {
                let find = Button::new(RichText::new("Find action").weak()).shortcut_text(RichText::new(keys).weak());
                queue.push_if(ui.add(find).on_hover_text(tooltip(ui.ctx(), palette)).clicked(), ActionId::Palette);
            }
        });
    });
}

fn detect_ui(ui: &mut Ui, model: Read<'_>, queue: &mut Queue) {
    if let Some((who, running)) = activity(model) {
        button_ui(ui, model, queue, ActionId::Cancel, None);
        progress_ui(ui, &running, Some(260.0), &format!("{who}{}", progress_text(&running)));
        return;
    }
    let in_pair = model.document.workspace.shows_pair();
    let needed = model.needs_detection(Side::A) || (in_pair && model.needs_detection(Side::B));
    // As long as detection is automatic, as it is at first, the menu alone switches it off.
    let mut auto = checked(ActionId::AutoDetect, model).unwrap_or(false);
    if needed || !auto {
        let text = RichText::new("Detect");
        let button = Button::new(if needed { text.color(Color32::WHITE).strong() } else { text });
        let button = if needed { button.fill(crate::app::style::ACCENT) } else { button };
        let wrong = model.results.slots.a.param_error.as_ref().map(ToString::to_string);
        let tip = wrong.unwrap_or_else(|| tooltip(ui.ctx(), ActionId::Detect.action()));
        let response = ui.add_enabled(enabled(ActionId::Detect, model), button);
        queue.push_if(response.on_hover_text(tip.clone()).on_disabled_hover_text(tip).clicked(), ActionId::Detect);
    }
    let tip = tooltip(ui.ctx(), ActionId::AutoDetect.action());
    queue.push_if(!auto && ui.checkbox(&mut auto, "Auto").on_hover_text(tip).clicked(), ActionId::AutoDetect);
    if in_pair {
        pair_found_ui(ui, model);
    } else if let Some(found) = &model.results.slots.a.found {
        let text = format!("{}{}", counted(model.features().len(), "feature"), in_time(found.elapsed));
        let times = &found.detection.times;
        let kept = counted(found.detection.tally.kept as usize, "keypoint");
        let secs = [times.noise_secs, times.search_secs, times.describe_secs].map(|secs| format!("{secs:.2} s"));
        let stages = format!("Noise {}, search {}, descriptors {}", secs[0], secs[1], secs[2]);
        ui.weak(text).on_hover_text(format!("Of {kept}: one has a feature for each of its orientations\n{stages}"));
    }
}

/// Running task, and the burst that it works on where there are two.
fn activity(model: Read<'_>) -> Option<(&'static str, Running)> {
    let [a, b] = model.results.slots.both().map(|slot| slot.detecting.running);
    if !model.document.workspace.shows_pair() {
        return Some(("", a?));
    }
    let in_a = a.map(|running| ("A: ", running));
    in_a.or(b.map(|running| ("B: ", running))).or(model.results.pair.matching.running.map(|running| ("", running)))
}

fn pair_found_ui(ui: &mut Ui, model: Read<'_>) {
    let count = |side| Some(model.found_of(side)?.detection.features.len().to_string());
    let counts: Vec<String> = Side::BOTH.into_iter().filter_map(count).collect();
    if counts.is_empty() {
        return;
    }
    let noun = if counts == ["1"] { "feature" } else { "features" };
    let matches = model.results.pair.matches.as_ref();
    let matches = matches.map(|m| format!(", {}{}", counted(m.len(), "match"), in_time(m.elapsed)));
    ui.weak(format!("{} {noun}{}", counts.join(" + "), matches.unwrap_or_default()));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::requests::JobId;
    use crate::teach::Workspace;

    #[test]
    fn of_two_bursts_it_is_said_for_which_one_there_is_work() {
        let running = |id| Some(Running { id: JobId(id), started: std::time::Instant::now(), progress: None });
        let mut model = crate::app::results::Model::default();
        let told = |model: Read<'_>| activity(model).map(|(who, running)| (who, running.id.0));
        assert_eq!(told(Read::of(&model)), None);
        model.results.pair.matching.running = running(3);
        assert_eq!(told(Read::of(&model)), None, "matches belong to two bursts");
        model.document.workspace = Workspace::Pair;
        assert_eq!(told(Read::of(&model)), Some(("", 3)));
        model.results.slots.b.detecting.running = running(2);
        assert_eq!(told(Read::of(&model)), Some(("B: ", 2)), "matches wait for the features");
        model.results.slots.a.detecting.running = running(1);
        assert_eq!(told(Read::of(&model)), Some(("A: ", 1)));
        model.document.workspace = Workspace::Inspect;
        assert_eq!(told(Read::of(&model)), Some(("", 1)));
    }
}
