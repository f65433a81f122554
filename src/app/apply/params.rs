//! Parameters that are checked against the open bursts, and the cursors that are brought into their range.

use crate::app::document::Side;
use crate::app::results::{Model, Read, Slot};
use crate::detector::{DetectorParams, Method, Slope, SlopeGrid};
use crate::error::Error;

pub fn check_params(model: &mut Model) {
    let auto = model.document.params.slopes.is_auto();
    for side in Side::BOTH {
        let params = Read::of(model).params_of(side);
        let slot = &mut model.results.slots[side];
        if side == Side::A || slot.burst.is_some() {
            slot.param_error = checked(slot, params, auto);
        }
    }
    model.results.pair.param_error = model.document.matching.validate().err();
    check_cursors(model);
}

/// Brings cursors into the range of their bursts. Those that follow the one in focus may lie outside, so that they
/// keep their distance to it, and slopes until those of the burst are found.
fn check_cursors(model: &mut Model) {
    let (follows, focus, before) = (model.document.panes.followers(), model.document.focus(), *model.document.cursor());
    let knows_slopes = Side::BOTH.map(|side| Read::of(model).knows_slopes(side));
    for (_, pane) in model.document.panes.iter_mut().filter(|(id, _)| !follows.contains(id)) {
        let slot = &model.results.slots[pane.side];
        if let Some(burst) = &slot.burst {
            let slope = pane.cursor.slope;
            pane.cursor = pane.cursor_within(burst, &slot.usable_params);
            if !knows_slopes[usize::from(pane.side == Side::B)] && slope.u.is_finite() && slope.v.is_finite() {
                pane.cursor.slope = slope;
            }
        }
    }
    model.document.panes.follow_cursor(focus, before);
}

/// Checks `params` against the burst of `slot`. Returns why they are invalid, and keeps the last valid ones as usable.
fn checked(slot: &mut Slot, mut params: DetectorParams, slopes_are_found: bool) -> Option<Error> {
    let (burst, usable) = (slot.burst.as_ref(), &mut slot.usable_params);
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
    } else if let Some(open) = burst.filter(|_| check(usable).is_err()) {
        // Valid for any burst whose frames are not tiny.
        let method = if open.burst.len() <= 1 { Method::Sift } else { Method::Buff };
        *usable = DetectorParams { method, ..DetectorParams::default() };
    }
    error
}
