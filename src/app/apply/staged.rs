//! Lessons begin and end, documents of sessions are put in place of the one on show, and steps are undone.

use crate::app::apply::{change, datasets, explained, methods, opening, pair, panes, params, probe, studies};
use crate::app::document::{DatasetChoice, Document, History, Reselect, Side, Sides, Staged};
use crate::app::pane::Preset;
use crate::app::results::{ComparisonResults, Effect, Model, ProbeResults, Read, Results, UserProject};
use crate::engine::Engine;
use crate::requests::{BurstSource, OpenRequest};
use std::mem::{replace, take};

pub(in crate::app) fn take_staged(model: &mut Model, staged: Staged, engine: &Engine) -> Option<Effect> {
    match staged {
        Staged::BeginLesson => return Some(begin_lesson(model)),
        Staged::EndLesson { keeps_opening } => return end_lesson(model, keeps_opening, engine),
        Staged::Reopen(side, source) => {
            let options = Read::of(model).calibration_of(side).clone();
            model.results.slots[side].open(OpenRequest { source, options }, None, engine);
        }
        Staged::Open { bursts, cameras } => open_for_step(model, bursts, cameras, engine),
        Staged::Begin { document, layout, probe } => begin_with(model, *document, layout, probe),
        Staged::SelectFirst => change::select_first(model, engine),
        Staged::Show(document, reselect) => show_document(model, *document, reselect),
        Staged::ReadNamed => return read_named(model, engine),
        Staged::ProbeWhenOpen(source, place) => model.results.studies.probe_when_open = Some((source, place)),
    }
    None
}

fn begin_lesson(model: &mut Model) -> Effect {
    let slot = &mut model.results.slots.a;
    let opening = slot.opening.pending().map(|request| (request.clone(), slot.leaves.take()));
    model.results.slots.a.opening.forget();
    let of_lesson = Document { figure: model.document.figure, ..Document::default() };
    let (document, results, history) = show(model, of_lesson, Results::default(), History::default());
    model.shell.of_user = Some(Box::new(UserProject { document, results, history, opening }));
    Effect::ForgetWidgets
}

fn end_lesson(model: &mut Model, keeps_opening: bool, engine: &Engine) -> Option<Effect> {
    let UserProject { document, results, history, opening } = *model.shell.of_user.take()?;
    let (_, of_lesson, _) = show(model, document, results, history);
    if model.results.poses.reading.pending().is_some() {
        // What was read meanwhile was not taken.
        studies::read_trajectories(model, engine);
    }
    if keeps_opening {
        model.results.slots.a.opening = of_lesson.slots.a.opening;
    } else if let Some((request, leaves)) = opening {
        model.results.slots.a.open(request, leaves, engine);
    }
    Some(Effect::ForgetWidgets)
}

/// Shows another project, and returns the former one. Dataset, Lab and colours of the window stay: their work goes on.
fn show(model: &mut Model, document: Document, results: Results, history: History) -> (Document, Results, History) {
    let Document { theme, dataset, pairs, lab, .. } = model.document.clone();
    let document = Document { theme, dataset, pairs, lab, ..document };
    let Results { figures, datasets, studies, .. } = &mut model.results;
    let (figures, datasets, studies) = (take(figures), take(datasets), take(studies));
    let results = Results { figures, datasets, studies, ..results };
    model.shell.messages.forget_note();
    let document = replace(&mut model.document, document);
    (document, replace(&mut model.results, results), replace(&mut model.shell.history, history))
}

fn open_for_step(model: &mut Model, bursts: Sides<Option<BurstSource>>, cameras: bool, engine: &Engine) {
    // The burst that another step requested is not needed any more.
    model.results.slots.a.opening.forget();
    // Which of two bursts was opened last says nothing.
    model.shell.messages.forget_note();
    for (side, source) in [(Side::A, bursts.a), (Side::B, bursts.b)] {
        let is_open = Read::of(model).burst_of(side).is_some_and(|burst| Some(&burst.source) == source.as_ref());
        let Some(source) = source.filter(|_| !is_open) else { continue };
        // A burst that was open before the lesson need not be opened again.
        let of_user = Read::of(model).project_of_user().results.slots.both().map(|slot| slot.burst.clone());
        match (side, of_user.into_iter().flatten().find(|burst| burst.source == source)) {
            (Side::A, Some(burst)) => opening::take_burst(model, burst),
            (Side::B, Some(burst)) => pair::take_second_burst(model, burst),
            (side, None) => {
                let request = OpenRequest { source, options: Default::default() };
                model.results.slots[side].open(request, None, engine);
            }
        }
    }
    if !cameras {
        studies::close_trajectories(model);
    } else if model.results.poses.is_empty() {
        studies::show_demo_cameras(model, engine);
    }
}

pub fn show_document(model: &mut Model, document: Document, reselect: Reselect) {
    for side in Side::BOTH {
        if document.comparisons[side] != model.document.comparisons[side] {
            model.results.slots[side].comparison = ComparisonResults::default();
        }
    }
    if document.probe != model.document.probe {
        model.results.probed = ProbeResults::default();
    }
    model.document = document;
    match reselect {
        Reselect::Feature(feature) => model.results.reselect = feature,
        Reselect::Match(of_match) => model.results.pair.reselect = of_match,
    }
    methods::keep_methods_arranged(model);
    params::check_params(model);
}

fn read_named(model: &mut Model, engine: &Engine) -> Option<Effect> {
    studies::read_trajectories(model, engine);
    match model.document.dataset.clone() {
        Some(DatasetChoice { source, folder, .. }) => {
            opening::look_at_dataset(model, source, folder, model.document.calibration.clone(), engine);
            None
        }
        None => Some(datasets::close_dataset(model)),
    }
}

/// Takes a step back or forward. The note about it replaces one about the settings that are no longer set.
pub(super) fn take_step(model: &mut Model, is_back: bool, engine: &Engine) {
    let before = model.document.clone();
    let (history, document) = (&mut model.shell.history, &mut model.document);
    let (what, calibration) =
        if is_back { ("Undone", history.undo(document)) } else { ("Redone", history.redo(document)) };
    params::check_params(model);
    let calibration = calibration.unwrap_or_else(|| before.calibration.clone());
    let changed = Document { calibration: calibration.clone(), ..model.document.clone() }.changed_from(&before);
    if !changed.is_empty() {
        model.shell.messages.note(format!("{what}: {changed}"));
    }
    if calibration != before.calibration {
        model.results.slots.a.stepped_to = Some(calibration.clone());
        opening::calibrate(model, calibration, engine);
    }
}

fn begin_with(model: &mut Model, document: Document, layout: Option<Preset>, probe: Option<[f32; 2]>) {
    model.document = document;
    for side in Side::BOTH {
        if !model.document.auto_detect || !Read::of(model).features_are_current(side) {
            model.results.slots[side].found = None;
        }
    }
    (model.results.hovered, model.results.reselect, model.results.probed) = Default::default();
    params::check_params(model);
    explained::refresh_listed(model);
    if let Some(layout) = layout {
        panes::lay_out(model, layout);
    }
    if let Some(place) = probe {
        let panels = model.document.panels;
        probe::probe_place(model, Side::A, place);
        // A probe opens its panel.
        model.document.panels = panels;
    }
    panes::settle_ranges(model);
    model.shell.history = Default::default();
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::apply::pair::tests::pair;
    use crate::matching::MatchParams;

    fn pass(model: &mut Model, goes_on: bool, change: impl FnOnce(&mut Document)) {
        let before = model.document.clone();
        change(&mut model.document);
        model.shell.history.take(before, &model.document);
        model.shell.history.close_step(&model.document, goes_on);
    }

    #[test]
    fn a_new_step_removes_the_steps_that_were_undone() {
        let mut model = Model::default();
        pass(&mut model, false, |m| m.params.levels = 5);
        pass(&mut model, false, |m| m.matching.ratio = 0.5);
        pass(&mut model, false, |_| {});
        model.shell.history.undo(&mut model.document);
        assert_eq!((&model.document.matching, model.document.params.levels), (&MatchParams::default(), 5));
        pass(&mut model, false, |m| m.params.octaves = 2);
        assert!(!model.shell.history.can_redo());
    }

    #[test]
    fn steps_in_b_are_undone_in_b_also_after_the_sides_were_swapped() {
        let mut model = pair();
        model.document.open_workspace(crate::teach::Workspace::Pair);
        let slopes = |model: Read<'_>| Side::BOTH.map(|side| model.document.panes.of(side).cursor.slope.u);
        model.document.focus_on_side(Side::B);
        let (a, before) = (slopes(Read::of(&model))[0], slopes(Read::of(&model))[1]);
        pass(&mut model, false, |m| m.focused_mut().cursor.slope.u = 0.25);
        assert_eq!(slopes(Read::of(&model)), [a, 0.25]);
        model.shell.history.undo(&mut model.document);
        assert_eq!(slopes(Read::of(&model)), [a, before]);
        model.shell.history.redo(&mut model.document);
        pair::swap_sides(&mut model);
        assert_eq!(slopes(Read::of(&model)), [0.25, a]);
        model.shell.history.undo(&mut model.document);
        assert_eq!(slopes(Read::of(&model)), [before, a], "the burst that was B");
    }

    #[test]
    fn a_drag_that_comes_back_and_what_changes_by_itself_are_no_steps() {
        let mut model = Model::default();
        let before = model.document.params.edge_threshold;
        for (value, goes_on) in [(1.0, true), (30.0, true), (before, false)] {
            pass(&mut model, goes_on, |m| m.params.edge_threshold = value);
        }
        assert!(!model.shell.history.can_undo());
        pass(&mut model, false, |m| _ = m.panes.split(m.focus(), crate::app::pane::Direction::Right));
        assert!(!model.shell.history.can_undo(), "a new pane");
    }
}
