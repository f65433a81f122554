//! The only writer: functions that change what is set and what was found, at the user's wish (`apply`) or because an
//! answer came (`asking`), a file for each part of the window.

pub mod asking;
#[cfg(test)]
pub mod bench;
pub mod change;
pub mod comparison;
pub mod datasets;
pub mod detection;
pub mod explained;
pub mod methods;
pub mod opening;
pub mod pair;
pub mod panes;
pub mod params;
pub mod probe;
pub mod staged;
pub mod studies;
#[cfg(test)]
mod tests;

use crate::app::actions::registry::{ActionId, Does};
use crate::app::document::panes::Change;
use crate::app::document::{Action, Pointed, Side};
use crate::app::results::{Effect, Model, Read};
use crate::engine::Engine;

/// Applies an action. It is a step to undo, or a part of one, where it changes settings that undo covers.
pub fn apply(action: Action, model: &mut Model, engine: &Engine) -> Vec<Effect> {
    match action {
        Action::Point(pointed) => point_at(model, pointed),
        Action::Stage(staged) => return staged::take_staged(model, staged, engine).into_iter().collect(),
        Action::Do(id @ (ActionId::Undo | ActionId::Redo)) => staged::take_step(model, id == ActionId::Undo, engine),
        action => {
            let before = model.document.clone();
            let effects = applied(action, model, engine);
            params::check_params(model);
            model.shell.history.take(before, &model.document);
            return effects;
        }
    }
    Vec::new()
}

/// Applies those that need the engine, the bursts or what was answered; the others change the document alone, as
/// their declaration says (`document::action`).
fn applied(action: Action, model: &mut Model, engine: &Engine) -> Vec<Effect> {
    use Action as A;
    match action {
        A::Do(id) => return do_row(id, model, engine).into_iter().collect(),
        A::Open(side, source) => _ = opening::open(model, side, source, engine),
        A::OpenDataset(source) => {
            let mut options = model.document.calibration.clone();
            if Read::of(model).settings_are_of(Side::A).is_some() {
                options = options.with_burst_of(&crate::burst::OpenOptions::default());
            }
            opening::look_at_dataset(model, source, None, options, engine);
        }
        A::UseFeatureFolder(folder) => datasets::use_feature_folder(model, folder, engine),
        A::OpenGold(side, source) => methods::open_gold(model, side, source, engine),
        A::OpenFeatures(side, path) => {
            comparison::lay_over(model, side, path);
            model.document.bottom_tab = crate::teach::BottomTab::Compared;
        }
        A::OpenTrajectory(which, path) => studies::open_trajectory(model, which, Some(path), engine),
        A::CloseTrajectory(which) => studies::open_trajectory(model, which, None, engine),
        A::OpenBurstAt(place) => datasets::open_burst_at(model, Side::A, place, engine),
        A::CutOpenBurst(length) => datasets::cut_open_burst(model, length, engine),
        A::Calibrate(options) => return vec![opening::calibrate(model, options, engine)],
        A::TakeLeftBehind(uses) => opening::take_left_behind(model, uses, engine),
        A::DetectAllAnyway => datasets::detect_all(model, engine),
        A::SetPoseStudy(study) => studies::set_pose_study(model, study, engine),
        A::OpenCamera(label) => datasets::look_at_camera(model, &label, None, engine),
        A::OpenFeature(label, index) => datasets::look_at_camera(model, &label, Some(index), engine),
        A::Note(text) => model.shell.messages.note(text),
        A::DismissMessage(id) => model.shell.messages.dismiss(id),
        A::ColourBy(by) => {
            model.document.colour_by = by;
            // Choosing a quantity again starts its computation again, if that was cancelled.
            model.results.coherence.try_again();
        }
        A::ToggleTab(tab) => {
            let opens = !Read::of(model).shows_bottom() || model.document.bottom_tab != tab;
            (model.document.panels.bottom, model.document.bottom_tab) = (opens.into(), tab);
        }
        A::SetPairTab(tab) => {
            let opens = !Read::of(model).shows_bottom() || model.document.pair_tab != tab;
            (model.document.panels.bottom, model.document.pair_tab) = (opens.into(), tab);
        }
        A::UseFrames(count) => panes::use_frames(model, count),
        A::ApplyChanges(side, changes) => explained::apply_advice(model, side, &changes),
        A::ApplySetUp => explained::apply_set_up(model),
        A::ExamineSlopes => model.results.explained.slopes_wanted = true,
        A::SearchDecoys => explained::want_decoys(model),
        A::Probe(side, question) => probe::ask_probe(model, side, question),
        A::ProbeFeature(side, index) => probe::probe_feature(model, side, index),
        // The open probe speaks of what is selected.
        A::Select(Some(index)) if model.document.probe.is_open && model.document.probe.is_on() => {
            probe::probe_feature(model, Side::A, index);
        }
        A::ProbeSubject(subject) => probe::look_at(model, subject),
        A::CompareWith(side, with) => comparison::show_comparison(model, side, with),
        A::SelectRow(side, row) => comparison::select_row(model, side, row),
        A::AskFeature(index) => pair::ask_feature(model, index),
        A::ShowKept(index, shown) => {
            model.results.studies.kept.get_mut(index).into_iter().for_each(|kept| kept.is_shown = shown);
        }
        A::NameKept(index, name) => {
            model.results.studies.kept.get_mut(index).into_iter().for_each(|kept| kept.name.clone_from(&name));
        }
        A::ForgetKept(index) => studies::forget_kept(model, index),
        A::SortPairs(column) => model.results.datasets.open.iter_mut().for_each(|open| open.matches.sort_by(column)),
        A::ChangePanes(change) => panes::change_panes(model, change),
        A::MoveView { pane, before, after } => model.document.move_view(pane, &before, after),
        A::StopFollowing => model.document.probe.follows = false,
        action => action.change(&mut model.document),
    }
    Vec::new()
}

fn do_row(id: ActionId, model: &mut Model, engine: &Engine) -> Option<Effect> {
    let (focus, mut cursor) = (model.document.focus(), *model.document.cursor());
    match id.action().does {
        Some(Does::Ask(purpose)) => return Some(Effect::Ask(purpose)),
        Some(Does::Open(source)) => _ = opening::open(model, Side::A, source(), engine),
        Some(Does::LayOut(preset)) => panes::change_panes(model, Change::LayOut(focus, preset)),
        Some(Does::Workspace(workspace)) => model.document.open_workspace(workspace),
        Some(Does::Switch { turn: set, .. } | Does::Set(set)) => set(&mut model.document),
        Some(Does::Slope(of)) => {
            let slope = of(&Read::of(model).cursor_params().slopes, cursor.slope);
            model.document.paused().show_slope(focus, slope);
        }
        Some(Does::Frame(go)) => {
            go(&mut cursor);
            model.document.paused().show_frame(focus, cursor.frame);
        }
        Some(Does::Scale(go)) => {
            go(&mut cursor);
            model.document.paused().show_scale(focus, cursor.octave, cursor.level);
        }
        Some(Does::Show(kind)) => model.document.lead(focus, |pane| pane.show(kind)),
        Some(Does::Run(run)) => run(model, engine),
        Some(Does::Change(change)) => return change(model, engine),
        None => {}
    }
    None
}

pub fn point_at(model: &mut Model, pointed: Pointed) {
    match pointed {
        Pointed::Feature(index) => model.results.hovered = index,
        Pointed::Candidate(index) => model.results.explained.pointed = index,
        Pointed::Row(side, row) => model.results.slots[side].comparison.hovered = row,
        Pointed::Match(index) => model.results.pair.hovered = index,
        Pointed::Camera(index) => model.results.poses.hovered = index,
        Pointed::Place(place) => model.results.probed.pointer = place,
        Pointed::Dots(features) => model.results.probed.as_dots = features,
        Pointed::Lines(drawn, all) => model.results.pair.lines_drawn = (drawn, all),
        Pointed::Loupe(place) => model.results.patches.loupe = place,
        Pointed::Figure(asked) => model.results.preview.ask(asked.map(|asked| *asked)),
        Pointed::Shape(asked) => model.results.shape.ask(asked),
        Pointed::Folder(asked) => model.results.folder.ask(asked),
    }
}
