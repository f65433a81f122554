//! Taking a newly opened burst, and keeping parameters and cursors within what the bursts have.

use crate::app::pane::PaneId;
use crate::app::project::Model;
use crate::app::project::cursor::Cursor;
use crate::app::project::pair::Side;
use crate::app::view::View;
use crate::detector::{DetectorParams, Method, ParamError, Slope, SlopeGrid};
use crate::requests::OpenBurst;

impl Model {
    /// Takes a newly opened burst in place of the one that was open.
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

    /// Puts the panes on the burst of `side` back to where a newly opened burst begins: the one that the sliders move
    /// where `begin` says, the others as far from it as they were.
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

    /// Brings cursors into range. Panes that follow the one in focus may go beyond, so that they come back to where
    /// they were beside it.
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

/// Checks `params` against `burst`: answers why they make no sense, and keeps in `usable` the last ones that did.
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
        // Slopes that are still to be found cannot be wrong.
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

/// Parameters that make sense for any burst of `frame_count` frames whose frames are not tiny.
fn usable_for(frame_count: usize) -> DetectorParams {
    let mut params = DetectorParams::default();
    if frame_count <= 1 {
        params.method = Method::Sift;
    }
    params
}
