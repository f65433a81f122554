//! Parameters that are checked against the open bursts, and the cursors that are brought into their range.

use crate::app::document::side::Side;
use crate::app::results::{Model, Read};
use crate::detector::{DetectorParams, Method, Slope, SlopeGrid};
use crate::error::Error;
use crate::requests::OpenBurst;

pub fn check_params(model: &mut Model) {
    let auto = model.document.slopes.is_auto();
    let a = &mut model.results.slots.a;
    a.param_error = checked(a.burst.as_ref(), model.document.params.clone(), auto, &mut a.usable_params);
    model.results.pair.param_error = model.document.matching.validate().err();
    if model.results.slots.b.burst.is_some() {
        let params = Read::of(model).params_of(Side::B);
        let b = &mut model.results.slots.b;
        b.param_error = checked(b.burst.as_ref(), params, auto, &mut b.usable_params);
    }
    check_cursors(model);
}

/// Brings cursors into the range of their bursts. Those that follow the one in focus may lie outside, so that they
/// keep their distance to it.
fn check_cursors(model: &mut Model) {
    let (follows, focus, before) = (model.document.panes.followers(), model.document.focus(), *model.document.cursor());
    for (_, pane) in model.document.panes.iter_mut().filter(|(id, _)| !follows.contains(id)) {
        let slot = &model.results.slots[pane.side];
        if let Some(burst) = &slot.burst {
            pane.cursor = pane.cursor_within(burst, &slot.usable_params);
        }
    }
    model.document.panes.follow_cursor(focus, before);
}

/// Checks `params` against `burst`. Returns why they are invalid, and keeps the last valid ones in `usable`.
fn checked(
    burst: Option<&OpenBurst>,
    mut params: DetectorParams,
    slopes_are_found: bool,
    usable: &mut DetectorParams,
) -> Option<Error> {
    let check = |params: &DetectorParams| match burst {
        Some(open) => params.validate_for(&open.burst.positions, open.burst.size()),
        None => params.validate(),
    };
    if slopes_are_found && check(&params).is_err() {
        // Slopes that are still to be found cannot be invalid.
        params.slopes = SlopeGrid::single(Slope::default());
    }
    let error = check(&params).err();
    if error.is_none() {
        *usable = params;
    } else if let Some(open) = burst
        && usable.validate_for(&open.burst.positions, open.burst.size()).is_err()
    {
        // Valid for any burst whose frames are not tiny.
        let method = if open.burst.len() <= 1 { Method::Sift } else { Method::Buff };
        *usable = DetectorParams { method, ..DetectorParams::default() };
    }
    error
}
