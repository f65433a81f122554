//! Detections of either burst: asked for, taken, and the slope that the cursor goes to with the first of them.

use crate::app::apply::{explained, panes, params};
use crate::app::results::explained::SHORT_SECS;
use crate::app::results::{FoundFeatures, Model, Read};
use crate::app::{document::Side, document::filter::at_slope, pane::PaneId};
use crate::engine::{Ended, Engine};
use crate::inspect::slopes::{features_at_slopes, slope_with_most_features};
use crate::requests::{DetectRequest, Detected};
use std::time::Duration;

pub fn start_detection(model: &mut Model, side: Side, engine: &Engine) {
    let request = Read::of(model).detect_request(side);
    if let Some(request) = request.filter(|_| model.results.slots[side].param_error.is_none()) {
        model.results.slots[side].detecting.ask(engine, request);
    }
}

pub(super) fn take_features(model: &mut Model, side: Side, ended: Ended<DetectRequest>) {
    if let Some(detected) = model.shell.messages.outcome(ended.result, side.detection()) {
        take_detection(model, side, detected, ended.elapsed);
    }
}

/// Shows the features of one slope of a long search, until all are there; not in place of others of the burst.
pub(super) fn take_first_features(model: &mut Model, side: Side, first: Detected) {
    let is_first = model.results.slots[side].found.is_none();
    if !is_first || Read::of(model).burst_of(side).is_none_or(|burst| burst.id != first.burst) {
        return;
    }
    let found = FoundFeatures::new(first, Duration::ZERO);
    model.results.slots[side].found = Some(FoundFeatures { is_first_slope: true, ..found });
    explained::refresh_listed(model);
    go_to_first_slope(model, side, None);
}

/// Takes the features, unless they are of another burst. The selection stays if the same feature was found again.
pub fn take_detection(model: &mut Model, side: Side, detected: Detected, elapsed: Duration) {
    if Read::of(model).burst_of(side).is_none_or(|burst| burst.id != detected.burst) {
        return;
    }
    let found = FoundFeatures::new(detected, elapsed);
    if side == Side::B {
        let earlier = model.results.slots.b.found.replace(found);
        params::check_params(model);
        go_to_first_slope(model, Side::B, earlier);
        return;
    }
    let keep = model.results.reselect.take().or_else(|| Read::of(model).saved_selection());
    if model.document.params.slopes.is_auto() && found.asked.slopes == model.document.params.slopes {
        model.results.slots.a.usable_params.slopes = found.params.slopes;
        params::check_params(model);
    }
    let earlier = model.results.slots.a.found.replace(found);
    model.results.explained.slopes_wanted = false;
    model.results.hovered = None;
    model.document.selected = keep.and_then(|saved| Read::of(model).find_again(&saved));
    explained::refresh_listed(model);
    go_to_first_slope(model, Side::A, earlier);
}

/// Unless a slope was chosen since that burst was opened. A cursor that jumps from what was on show says where to.
fn go_to_first_slope(model: &mut Model, side: Side, earlier: Option<FoundFeatures>) {
    let takes_long = Read::of(model).found_of(side).is_some_and(|found| found.elapsed.as_secs_f32() > SHORT_SECS);
    let was_seen = earlier.is_some_and(|earlier| takes_long || !earlier.is_first_slope);
    let (focus, own) = (model.document.panes.focus(), PaneId::of(side));
    let leader = if model.document.panes.is_on(focus, side) { focus } else { own };
    // The burst's own pane, which other workspaces show, moves too if it is not on the screen.
    let alone = own != leader && !model.document.panes.shown().contains(&own);
    for id in [Some(leader), alone.then_some(own)].into_iter().flatten() {
        if model.document.panes.get(id).is_some_and(|pane| !pane.slope_chosen) {
            panes::forget_range_of(model, id);
            let before = model.document.panes.get(id).map(|pane| pane.cursor.slope);
            let note = go_to_busiest_slope(model, id);
            let is_jump = was_seen && model.document.panes.get(id).map(|pane| pane.cursor.slope) != before;
            note.filter(|_| is_jump).into_iter().for_each(|note| model.shell.messages.note(note));
        }
    }
}

/// Slopes on the grid's rim count only if there are features nowhere else. Returns the slope in words.
pub fn go_to_busiest_slope(model: &mut Model, id: PaneId) -> Option<String> {
    let found = Read::of(model).found_of(model.document.panes.get(id)?.side)?;
    let grid = found.detection.slopes;
    let (index, count) = slope_with_most_features(&grid, &features_at_slopes(&found.detection))?;
    let slope = grid.slope(index);
    let [_, own] = at_slope(&found.detection, slope);
    model.document.lead(id, |pane| pane.cursor.slope = slope);
    let [u, v] = [slope.u, slope.v].map(|part| crate::app::view::fixed(part, 2));
    let by_own = if own == count { String::new() } else { format!(", {own} by their own slope") };
    Some(format!("Most features ({count}) are at slope ({u}, {v}) px/frame{by_own}"))
}
