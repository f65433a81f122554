//! Takes newly opened bursts, and keeps parameters and cursors valid for the bursts.

use crate::app::pane::PaneId;
use crate::app::project::Model;
use crate::app::project::cursor::Cursor;
use crate::app::project::pair::Side;
use crate::app::view::View;
use crate::detector::{DetectorParams, Method, ParamError, Slope, SlopeGrid};
use crate::requests::OpenBurst;

impl Model {
    /// Replaces the first burst by a newly opened one.
    pub fn take_burst(&mut self, burst: OpenBurst) {
        let middle = burst.burst.len() / 2;
        let slot = &mut self.slots.a;
        (slot.burst, slot.found, self.patch) = (Some(burst), None, None);
        slot.detecting.forget();
        self.forget_asked_pictures();
        (self.selected, self.hovered, self.playing) = (None, None, false);
        self.look.ranges.forget();
        self.explained.forget();
        self.pair.forget_matches();
        self.compare.gold[0] = None;
        self.start_panes(Side::A, |cursor| Cursor { kind: cursor.kind, frame: middle, ..Cursor::default() });
        self.check_params();
    }

    /// Resets the panes on the burst of `side` for a newly opened burst: the leading pane (that in focus, if it is on
    /// `side`) gets the cursor from `begin`, the others keep their distance to it.
    pub(crate) fn start_panes(&mut self, side: Side, begin: impl Fn(&Cursor) -> Cursor) {
        let focus = self.panes.focus();
        let leader = if self.panes.get(focus).is_some_and(|pane| pane.side == side) { focus } else { PaneId::of(side) };
        let Some(before) = self.panes.get(leader).map(|pane| pane.cursor) else { return };
        let after = begin(&before);
        for (id, pane) in self.panes.iter_mut().filter(|(_, pane)| pane.side == side) {
            pane.cursor = if id == leader { after } else { pane.cursor.moved_as(&before, &after) };
            (pane.picture, pane.problem, pane.slope_chosen) = (None, None, false);
            pane.view = View::fit();
            pane.own_ranges.iter_mut().for_each(|own| own.forget());
        }
    }

    /// Checks the edited parameters against A's burst and brings all cursors into range.
    pub fn check_params(&mut self) {
        let auto = self.slopes.is_auto();
        self.slots.a.param_error =
            checked(self.slots.a.burst.as_ref(), self.params.clone(), auto, &mut self.slots.a.usable_params);
        self.check_cursors();
    }

    /// Checks the parameters of matching, and those of the detector against B.
    pub fn check_pair(&mut self) {
        self.pair.param_error = self.pair.params.validate().err();
        if self.slots.b.burst.is_some() {
            let (params, auto) = (self.params_of(Side::B), self.slopes.is_auto());
            let b = &mut self.slots.b;
            b.param_error = checked(b.burst.as_ref(), params, auto, &mut b.usable_params);
            self.check_cursors();
        }
    }

    /// Clamps cursors to their ranges. Those of panes that follow the one in focus may lie outside, so that they keep
    /// their distance to it.
    fn check_cursors(&mut self) {
        let follows = self.panes.followers();
        let bursts = [
            (self.slots.a.burst.as_ref(), &self.slots.a.usable_params),
            (self.slots.b.burst.as_ref(), &self.slots.b.usable_params),
        ];
        for (id, pane) in self.panes.iter_mut() {
            if let (Some(burst), params) = bursts[pane.side as usize]
                && !follows.contains(&id)
            {
                pane.cursor = pane.cursor_within(burst, params);
            }
        }
    }
}

/// Checks `params` against `burst`. Returns why they are invalid, and keeps the last valid ones in `usable`.
fn checked(
    burst: Option<&OpenBurst>,
    mut params: DetectorParams,
    slopes_are_found: bool,
    usable: &mut DetectorParams,
) -> Option<ParamError> {
    let check = |params: &DetectorParams| match burst {
        Some(open) => params.validate_for(open.burst.len(), open.burst.size()),
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
        && usable.validate_for(open.burst.len(), open.burst.size()).is_err()
    {
        *usable = usable_for(open.burst.len());
    }
    error
}

/// Parameters that are valid for any burst of `frame_count` frames whose frames are not tiny.
fn usable_for(frame_count: usize) -> DetectorParams {
    let mut params = DetectorParams::default();
    if frame_count <= 1 {
        params.method = Method::Sift;
    }
    params
}
