//! The one function by which the user changes the project.

use super::change::change;
use crate::app::document::{Action, Pointed};
use crate::app::pane::Content;
use crate::app::project::look::Look;
use crate::app::project::{Effect, Model, Visibility};
use crate::detector::{SearchParams, SlopeChoice};
use crate::engine::Engine;
use crate::requests::ViewKind;
use crate::teach::BottomTab;

/// Applies an action. It is a step to undo, or a part of one, where it changes settings that undo covers.
pub fn apply(action: Action, model: &mut Model, engine: &Engine) -> Vec<Effect> {
    match action {
        Action::Point(pointed) => point(pointed, model),
        Action::Do(super::ActionId::Undo) => model.undo(),
        Action::Do(super::ActionId::Redo) => model.redo(),
        action => return model.as_step(|model| applied(action, model, engine)),
    }
    Vec::new()
}

fn point(pointed: Pointed, model: &mut Model) {
    match pointed {
        Pointed::Feature(index) => model.hovered = index,
        Pointed::Candidate(index) => model.explained.pointed = index,
        Pointed::Row(side, row) => model.slots[side].against.hovered = row,
        Pointed::Match(index) => model.pair.hovered = index,
        Pointed::Camera(index) => model.trajectories.hovered = index,
        Pointed::Place(place) => model.probe.pointer = place,
        Pointed::Dots(features) => model.probe.as_dots = features,
        Pointed::Lines(drawn, all) => model.pair.lines_drawn = (drawn, all),
    }
}

fn applied(action: Action, model: &mut Model, engine: &Engine) -> Vec<Effect> {
    use Action as A;
    match action {
        A::Do(id) => return change(id, model, engine).into_iter().collect(),
        A::Open(side, source) => {
            model.open(side, source, engine);
        }
        A::OpenDataset(source) => model.open_dataset(source, engine),
        A::UseFeatureFolder(folder) => model.use_feature_folder(folder, engine),
        A::OpenGold(side, source) => model.open_gold(side, source, engine),
        A::OpenFeatures(side, path) => {
            model.lay_over(side, path);
            model.bottom_tab = BottomTab::Compared;
        }
        A::OpenTrajectory(which, path) => model.open_trajectory(which, path, engine),
        A::OpenBurstAt(place) => model.open_burst_at(place, engine),
        A::CutOpenBurst(length) => model.cut_open_burst(length, engine),
        A::Calibrate(options) => return vec![model.calibrate(options, engine)],
        A::DetectAllAnyway => model.detect_all(engine),
        A::SetPoseStudy(study) => {
            model.trajectories.study = study;
            model.compare_trajectories_again(engine);
        }
        A::OpenCamera(label) => model.look_at_camera(&label, engine),
        A::Note(text) => model.messages.note(text),
        A::DismissMessage(id) => model.messages.dismiss(id),
        action => set(action, model),
    }
    Vec::new()
}

fn set(action: Action, model: &mut Model) {
    use Action as A;
    match action {
        A::SetLook(look) => {
            if look.smoothing_px != model.look.smoothing_px {
                // With less noise the values span less.
                model.focused_ranges_mut().forget();
            }
            model.look = Look { ranges: model.look.ranges, ..look };
        }
        A::SetDisplay(class, display) => *model.focused_ranges_mut().display_mut(class) = display,
        A::ColourBy(by) => {
            model.colour_by = by;
            // Choosing a quantity again starts its computation again, if that was cancelled.
            model.coherence.try_again();
        }
        A::SetMeasure(measure) => model.measure = measure,
        A::SetPanels(panels) => model.panels = panels,
        A::OpenTab(tab) => (model.bottom_tab, model.panels.bottom) = (tab, Visibility::Open),
        A::ToggleTab(tab) => {
            model.panels.bottom = Visibility::from(!model.shows_bottom() || model.bottom_tab != tab);
            model.bottom_tab = tab;
        }
        A::SetFigure(figure) => model.figure = figure,
        A::SetFilm(film) => model.film = film,
        A::SetSearch(search) => model.set_search(*search),
        A::UseFrames(count) => model.use_frames(count),
        A::ApplyChanges(side, changes) => model.apply_advice(side, &changes),
        A::SetSetUp(set_up) => model.set_up = set_up,
        A::ApplySetUp => apply_set_up(model),
        A::ReadDepths(reads) => model.read_depths(reads),
        A::Select(index) => model.selected = index,
        A::SetFilter(filter) => model.filter = filter,
        A::SetOrder(order) => model.order = order,
        A::ShowTest(test) => (model.explained.shown_test, model.explained.selected) = (test, None),
        A::SelectCandidate(index) => model.explained.selected = index,
        A::ExamineSlopes => model.explained.slopes_wanted = true,
        A::SearchDecoys => model.want_decoys(),
        A::Probe(side, question) => model.ask_probe(side, question),
        A::ProbeFeature(side, index) => model.probe_feature(side, index),
        A::ProbeSubject(subject) => model.probe.look_at(subject),
        A::ProbeNear(sigma) => model.probe.near_sigma = sigma,
        A::OpenProbe(is_open) => model.probe.is_open = is_open,
        A::StopFollowing => model.probe.follows = false,
        A::CompareWith(side, with) => model.show_against(side, with),
        A::ShowKind(side, kind, shown) => show(&mut model.slots[side].against.hidden, kind, shown),
        A::SelectRow(side, row) => model.select_row(side, row),
        A::SetMatching(params) => model.matching = *params,
        A::SetMatchLook(look) => model.match_look = look,
        A::SetPairLinks(links) => model.set_pair_links(links),
        A::SetMatchOrder(order) => model.match_order = order,
        A::SetPairTab(tab) => {
            model.panels.bottom = Visibility::from(!model.shows_bottom() || model.pair_tab != tab);
            model.pair_tab = tab;
        }
        A::SelectMatch(index) => (model.pair.selected, model.pair.lost.selected) = (index, None),
        A::AskFeature(index) => model.ask_feature(index),
        A::ShowLost(lost, shown) => {
            show(&mut model.pair.lost.hidden, lost, shown);
            model.pair_tab = crate::app::project::pair::PairTab::Unmatched;
        }
        A::SetMethods(look) => model.methods = look,
        A::SetLab(lab) => model.lab = *lab,
        A::ShowKept(index, shown) => {
            model.studies.kept.get_mut(index).into_iter().for_each(|kept| kept.is_shown = shown);
        }
        A::NameKept(index, name) => {
            model.studies.kept.get_mut(index).into_iter().for_each(|kept| kept.name.clone_from(&name));
        }
        A::ForgetKept(index) => model.forget_kept(index),
        A::SetPairChoice(choice) => model.datasets.choice = choice,
        A::ChooseBurst(..) | A::SelectPair(_) | A::SortPairs(_) => set_in_dataset(action, model),
        A::SetProjection(projection) => model.trajectories.projection = projection,
        A::MoveCameras(view) => model.trajectories.view = view,
        A::SelectCamera(index) => model.trajectories.selected = index,
        action => set_pane(action, model),
    }
}

/// Hides or shows one of the kinds of which `hidden` are not drawn.
fn show<T: PartialEq>(hidden: &mut Vec<T>, kind: T, shown: bool) {
    hidden.retain(|other| *other != kind);
    hidden.extend((!shown).then_some(kind));
}

fn set_in_dataset(action: Action, model: &mut Model) {
    let Some(dataset) = &mut model.datasets.open else { return };
    match action {
        Action::ChooseBurst(side, place) => dataset.choose(side as usize, place),
        Action::SelectPair(pair) => dataset.select(pair),
        Action::SortPairs(column) => dataset.matches.sort_by(column),
        _ => {}
    }
}

fn set_pane(action: Action, model: &mut Model) {
    use Action as A;
    match action {
        A::Focus(id) => model.panes.set_focus(id),
        A::Rearrange(arrangement) => model.panes.rearrange(arrangement),
        A::ChangePanes(change) => model.change_panes(change),
        A::MoveView { pane, before, after } => model.move_view(pane, &before, after),
        A::GoTo(side, destination) => model.go_to(side, &destination),
        A::SetFrame(id, frame) => model.lead(id, |pane| {
            pane.cursor.frame = frame;
            pane.show(ViewKind::Frame);
        }),
        A::SetSlope(id, slope) => {
            model.playing = false;
            model.show_slope(id, slope);
        }
        A::PlaySlope(id, slope) => model.show_slope(id, slope),
        A::SetScale(id, octave, level) => model.lead(id, |pane| {
            (pane.cursor.octave, pane.cursor.level) = (octave, level);
            pane.show_scale();
        }),
        A::Show(id, kind) => model.lead(id, |pane| pane.show(kind)),
        A::SetContent(id, Content::Slice(axis)) => model.lead(id, |pane| pane.show_slice(axis)),
        A::SetContent(id, content) => model.lead(id, |pane| pane.content = content),
        A::SetOver(id, over) => model.lead(id, |pane| pane.over = over),
        A::SetLink(id, link, on) => model.set_link(id, link, on),
        A::SetMethod(id, method) => model.lead(id, |pane| pane.method = Some(method)),
        A::SetSide(id, side) => model.panes.show_side(id, side),
        _ => {}
    }
}

fn apply_set_up(model: &mut Model) {
    let frames = model.slots.a.burst.as_ref().map_or(10, |open| open.burst.len());
    let slopes = model.set_up.values.slopes(model.params.used_frames(frames).len(), &model.params);
    if let Ok(slopes) = slopes.map(|slopes| (slopes.grid, slopes.options())) {
        let (grid, options) = slopes;
        let mut detector = model.params.clone();
        detector.slopes = grid;
        model.set_search(SearchParams { detector, slopes: SlopeChoice::Given });
        model.messages.note(format!("Set {options}"));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::project::side::Side;
    use crate::app::project::tests::Bench;

    #[test]
    fn what_is_pointed_at_is_no_step_and_leaves_the_document_as_it_is() {
        let Bench { mut model, engine } = Bench::new();
        let before = model.document.clone();
        for pointed in [Pointed::Feature(Some(3)), Pointed::Row(Side::B, Some(1)), Pointed::Place(None)] {
            apply(Action::Point(pointed), &mut model, &engine);
        }
        model.close_step(false);
        assert!(model.document == before && !model.history.can_undo());
        assert_eq!((model.hovered, model.slots.b.against.hovered), (Some(3), Some(1)));
    }
}
