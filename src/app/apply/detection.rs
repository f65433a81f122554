//! Detections of either burst: asked for, taken, and the slope that the cursor goes to with the first of them.

use crate::app::apply::{explained, panes, params};
use crate::app::document::Side;
use crate::app::document::filter::at_slope;
use crate::app::pane::PaneId;
use crate::app::results::{FoundFeatures, Model, Read};
use crate::app::view::fixed;
use crate::engine::{Ended, Engine};
use crate::inspect::slopes::{features_at_slopes, slope_with_most_features};
use crate::requests::{DetectRequest, Detected};
use std::time::Duration;

pub fn start_detection(model: &mut Model, side: Side, engine: &Engine) {
    if let Some(request) =
        Read::of(model).detect_request(side).filter(|_| model.results.slots[side].param_error.is_none())
    {
        model.results.slots[side].detecting.ask(engine, request);
    }
}

pub(super) fn take_features(model: &mut Model, side: Side, ended: Ended<DetectRequest>) {
    match ended.result {
        Ok(detected) => {
            model.shell.messages.resolved(side.detection());
            take_detection(model, side, detected, ended.elapsed);
        }
        Err(error) => model.shell.messages.failed(side.detection(), &error),
    }
}

/// Shows the features of one slope of a long search, until all are there; not in place of others of the burst.
pub(super) fn take_first_features(model: &mut Model, side: Side, first: Detected) {
    let Some(burst) = Read::of(model).burst_of(side).filter(|burst| burst.id == first.burst) else { return };
    if model.results.slots[side].found.is_some() {
        return;
    }
    // One slope tells nothing about the range.
    let found = FoundFeatures::new(first, burst, Duration::ZERO);
    let found = FoundFeatures { is_first_slope: true, advice: None, ..found };
    model.results.slots[side].found = Some(found);
    explained::refresh_listed(model);
    go_to_first_slope(model, side);
}

/// Takes the features, unless they are of another burst. The selection stays if the same feature was found again.
pub fn take_detection(model: &mut Model, side: Side, detected: Detected, elapsed: Duration) {
    let Some(burst) = Read::of(model).burst_of(side).filter(|burst| burst.id == detected.burst) else { return };
    let found = FoundFeatures::new(detected, burst, elapsed);
    if side == Side::B {
        model.results.slots.b.found = Some(found);
        params::check_params(model);
        go_to_first_slope(model, Side::B);
        return;
    }
    let keep = model.results.reselect.take().or_else(|| Read::of(model).saved_selection());
    if model.document.params.slopes.is_auto() && found.asked.slopes == model.document.params.slopes {
        model.results.slots.a.usable_params.slopes = found.params.slopes;
        params::check_params(model);
    }
    model.results.slots.a.found = Some(found);
    model.results.explained.slopes_wanted = false;
    model.results.hovered = None;
    model.document.selected = keep.and_then(|saved| Read::of(model).find_again(&saved));
    explained::refresh_listed(model);
    go_to_first_slope(model, Side::A);
}

/// Unless a slope was chosen since that burst was opened.
pub(crate) fn go_to_first_slope(model: &mut Model, side: Side) {
    let (focus, own) = (model.document.panes.focus(), PaneId::of(side));
    let leader = if model.document.panes.is_on(focus, side) { focus } else { own };
    // The burst's own pane, which other workspaces show, moves too if it is not on the screen.
    let alone = own != leader && !model.document.panes.shown().contains(&own);
    for id in [Some(leader), alone.then_some(own)].into_iter().flatten() {
        if model.document.panes.get(id).is_some_and(|pane| !pane.slope_chosen) {
            panes::forget_range_of(model, id);
            go_to_busiest_slope(model, id);
        }
    }
}

/// Slopes on the grid's rim count only if there are features nowhere else.
pub fn go_to_busiest_slope(model: &mut Model, id: PaneId) {
    let Some(side) = model.document.panes.get(id).map(|pane| pane.side) else { return };
    let Some(found) = Read::of(model).found_of(side) else { return };
    let grid = found.detection.slopes;
    if let Some((index, count)) = slope_with_most_features(&grid, &features_at_slopes(&found.detection)) {
        let slope = grid.slope(index);
        let [_, own] = at_slope(&found.detection, slope);
        model.document.lead(id, |pane| pane.cursor.slope = slope);
        let [u, v] = [slope.u, slope.v].map(|part| fixed(part, 2));
        let by_own = if own == count { String::new() } else { format!(", {own} by their own slope") };
        model.shell.messages.note(format!("Most features ({count}) are at slope ({u}, {v}) px/frame{by_own}"));
    }
}
