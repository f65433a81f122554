//! Panes and their pictures: the arrangement, playing through the slopes, pictures that come, and their value ranges.

use crate::app::apply::{methods, params};
use crate::app::document::{Action, Cursor, PlayOver, RangeClass, Side, Visibility};
use crate::app::pane::{Content, PaneId, Preset};
use crate::app::results::{Model, Read};
use crate::app::{document::cursor::back_and_forth, document::panes::Change};
use crate::app::{results::panes::Play, results::pictures::PatchResults};
use crate::detector::FrameRange;
use crate::engine::Ended;
use crate::requests::{PictureAnswer, PictureRequest, ViewKind};
use std::time::{Duration, Instant};

pub fn change_panes(model: &mut Model, change: Change) {
    match change {
        Change::Split(id, direction) => _ = model.document.panes.split(id, direction),
        Change::Close(id) => model.document.panes.close(id),
        Change::LayOut(id, preset) => {
            model.document.panes.set_focus(id);
            lay_out(model, preset);
        }
        Change::LayOutSides(preset) => model.document.panes.lay_out_sides(preset),
        Change::LayOutMethods(preset) => methods::lay_out_methods(model, preset),
    }
}

pub fn auto_contrast(model: &mut Model) {
    let has_range = |picture: &&PictureAnswer| RangeClass::of(&picture.request) != RangeClass::Motion;
    let Some(picture) = Read::of(model).picture().filter(has_range).cloned() else { return };
    model.document.focused_ranges_mut().take_percentiles(&picture);
}

pub fn toggle_play(model: &mut Model) {
    model.document.playing = !model.document.playing;
    let (_, step, _) = Read::of(model).sweep();
    model.shell.play = Play { step, due: None };
}

/// The action that shows the next picture, if it is due while pictures play, and the time after which to ask again.
pub(in crate::app) fn step_play(model: &mut Model) -> Option<(Option<Action>, Duration)> {
    if !model.document.playing {
        return None;
    }
    let (now, every) = (Instant::now(), Duration::from_secs(1) / u32::from(model.document.play.rate.clamp(1, 60)));
    let due = model.shell.play.due.is_none_or(|due| now >= due);
    // The next picture waits for this one, so that a slow machine plays slowly and skips none.
    let next = (due && Read::of(model).pictures_are_seen()).then(|| {
        let step = model.shell.play.step + 1;
        model.shell.play = Play { step, due: Some(now + every) };
        let (count, _, action) = Read::of(model).sweep();
        // Frames begin again, as a film does; slopes and scales go back, so that the picture never jumps.
        let is_film = Read::of(model).played() == PlayOver::Frames;
        (count > 0).then(|| action(if is_film { step % count } else { back_and_forth(step, count) }))
    });
    Some((next.flatten(), every / 4))
}

pub fn open_left(model: &mut Model) {
    model.document.panels.left = Visibility::Open;
    if !Read::of(model).shows_left() {
        model.document.panels.right = Visibility::Closed;
    }
}

pub fn open_probe(model: &mut Model) {
    (model.document.probe.is_open, model.results.probed.problem) = (true, None);
    // Slices show the place themselves, and need the space.
    let has_slice = model.document.panes.each_shown().any(|pane| matches!(pane.content, Content::Slice(_)));
    if model.document.panels.right == Visibility::Closed && !has_slice {
        model.document.panels.right = Visibility::Auto;
    }
}

pub(in crate::app) fn forget_asked_pictures(model: &mut Model) {
    model.results.pictures.values_mut().for_each(|shown| shown.wanted.forget());
    model.results.patches = PatchResults::default();
}

/// Takes a motion stack from which patches are cut, and forgets those from which none are any more.
pub fn take_stack(model: &mut Model, ended: Ended<PictureRequest>) {
    let wanted = Read::of(model).stacks_of_patches();
    let stacks = &mut model.results.patches.stacks;
    stacks.retain(|(request, _)| wanted.contains(request));
    stacks.push((ended.request, model.shell.messages.answer(ended.result, "Patches")));
}

/// Takes the picture of a pane, unless it is of another burst than the one that the pane shows now.
pub fn take_picture(model: &mut Model, id: PaneId, picture: PictureAnswer) {
    if !model.document.panes.get(id).is_some_and(|pane| Read::of(model).fits(pane, &picture)) {
        return;
    }
    model.document.ranges_mut(id).propose(&picture);
    let shown = model.results.pictures.entry(id).or_default();
    (shown.picture, shown.preview) = (Some(picture), None);
    settle_ranges(model);
}

/// Lets another picture set the range that the picture of a pane set: that of a slope at which all may be smeared.
pub(super) fn forget_range_of(model: &mut Model, id: PaneId) {
    let Some(picture) = Read::of(model).picture_in(id).cloned() else { return };
    model.document.ranges_mut(id).forget_that_of(&picture);
}

pub fn lay_out(model: &mut Model, preset: Preset) {
    if preset == Preset::Methods {
        return model.document.compare_methods();
    }
    model.document.panes.turn_to(model.document.workspace);
    let params = Read::of(model).cursor_params().clone();
    model.document.panes.lay_out(preset, &params);
    params::check_params(model);
}

/// A pane's own range is set from its picture, a shared one from the pane in focus or the first of this class.
pub fn settle_ranges(model: &mut Model) {
    let mut led = Vec::new();
    let mut ids = model.document.panes.shown();
    ids.sort_by_key(|id| *id != model.document.focus());
    for id in ids {
        let Some(class) = Read::of(model).wanted(id).map(|wanted| RangeClass::of(&wanted)) else { continue };
        let shares = model.document.panes.get(id).is_some_and(|pane| pane.own_ranges.is_none());
        let is_current = Read::of(model).is_current(id);
        let shown = model.results.pictures.get(&id);
        if shown.is_some_and(|shown| shown.wanted.failure().is_some()) || (shares && led.contains(&class)) {
            continue;
        }
        led.extend(shares.then_some(class));
        if let Some(picture) = shown.and_then(|shown| shown.picture.as_ref()).filter(|_| is_current) {
            model.document.ranges_mut(id).fix_once(picture);
        }
    }
}

/// The leading pane (that in focus, if it is on `side`) gets the cursor from `begin`; others keep their distance.
pub(crate) fn start_panes(model: &mut Model, side: Side, begin: impl Fn(&Cursor) -> Cursor) {
    let focus = model.document.panes.focus();
    let leader = if model.document.panes.is_on(focus, side) { focus } else { PaneId::of(side) };
    let Some(before) = model.document.panes.get(leader).map(|pane| pane.cursor) else { return };
    let after = begin(&before);
    let (panes, pictures) = (&mut model.document.panes, &mut model.results.pictures);
    pictures.retain(|id, _| panes.get(*id).is_some_and(|pane| pane.side != side));
    for (id, pane) in panes.iter_mut().filter(|(_, pane)| pane.side == side) {
        pane.cursor = if id == leader { after } else { pane.cursor.moved_as(&before, &after) };
        pane.slope_chosen = false;
        pane.view = crate::app::view::View::fit();
        pane.own_ranges.iter_mut().for_each(|own| own.forget());
    }
}

/// Shows the first `count` frames of A, added up along the slope, or of one its frame, which has no motion.
pub fn use_frames(model: &mut Model, count: usize) {
    let all = Read::of(model).frame_count();
    let focus = model.document.focus();
    if count <= 1 {
        model.document.lead(focus, |pane| {
            pane.cursor.frame = 0;
            pane.show(ViewKind::Frame);
        });
        return;
    }
    model.document.params.frames = (count < all).then_some(FrameRange { start: 0, end: count });
    if model.document.cursor().kind == ViewKind::Frame {
        model.document.lead(focus, |pane| pane.show(ViewKind::Stack));
    }
    params::check_params(model);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn in_a_very_narrow_window_one_side_panel_is_open_at_a_time() {
        let mut model = Model::default();
        model.shell.window_width_points = 720.0;
        open_left(&mut model);
        assert!(Read::of(&model).shows_left() && !Read::of(&model).folds_left());
        model.document.panels.right = Visibility::Auto;
        model.document.selected = Some(0);
        assert!(!Read::of(&model).shows_left() && Read::of(&model).folds_left() && Read::of(&model).shows_right());
        open_left(&mut model);
        assert!(Read::of(&model).shows_left() && !Read::of(&model).shows_right());
    }
}
