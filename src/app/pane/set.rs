//! All panes, where they are, and which of them the sliders move.

use super::preset::Laid;
use super::{Arrangement, Content, Direction, Link, MAX_PANES, Over, Pane, PaneId, Preset};
use crate::app::canvas::View;
use crate::app::project::cursor::Cursor;
use crate::app::project::side::Side;
use crate::detector::DetectorParams;
use std::collections::BTreeMap;

/// All panes.
#[derive(Debug)]
pub struct Panes {
    /// The two that are always there.
    sides: [Pane; 2],
    more: BTreeMap<PaneId, Pane>,
    arrangement: Arrangement,
    focus: PaneId,
    next: u32,
}

impl Default for Panes {
    fn default() -> Self {
        let first = PaneId::of(Side::A);
        Self {
            sides: Side::BOTH.map(Pane::new),
            more: BTreeMap::new(),
            arrangement: Arrangement::Pane(first),
            focus: first,
            next: 2,
        }
    }
}

impl Panes {
    /// The pane called `id`.
    pub fn get(&self, id: PaneId) -> Option<&Pane> {
        self.sides.get(id.0 as usize).or_else(|| self.more.get(&id))
    }

    /// The same, to be changed.
    pub fn get_mut(&mut self, id: PaneId) -> Option<&mut Pane> {
        self.sides.get_mut(id.0 as usize).or_else(|| self.more.get_mut(&id))
    }

    /// The pane that is always there for the burst of `side`.
    pub fn of(&self, side: Side) -> &Pane {
        &self.sides[side as usize]
    }

    /// The same, to be changed.
    pub fn of_mut(&mut self, side: Side) -> &mut Pane {
        &mut self.sides[side as usize]
    }

    /// All of them, on the screen or not.
    pub fn iter(&self) -> impl Iterator<Item = (PaneId, &Pane)> {
        let sides = Side::BOTH.into_iter().map(|side| (PaneId::of(side), self.of(side)));
        sides.chain(self.more.iter().map(|(id, pane)| (*id, pane)))
    }

    /// The same, to be changed.
    pub fn iter_mut(&mut self) -> impl Iterator<Item = (PaneId, &mut Pane)> {
        let sides = Side::BOTH.into_iter().map(PaneId::of).zip(&mut self.sides);
        sides.chain(self.more.iter_mut().map(|(id, pane)| (*id, pane)))
    }

    /// Where the panes of the inspector are.
    pub fn arrangement(&self) -> &Arrangement {
        &self.arrangement
    }

    /// Takes what the pointer made of the arrangement: panes may have moved and have other sizes, but are the same.
    pub fn rearrange(&mut self, arrangement: Arrangement) {
        let mut panes = [arrangement.panes(), self.arrangement.panes()];
        panes.iter_mut().for_each(|ids| ids.sort_unstable());
        if panes[0] == panes[1] {
            self.arrangement = arrangement;
        }
    }

    /// The panes of the inspector, in reading order.
    pub fn shown(&self) -> Vec<PaneId> {
        self.arrangement.panes()
    }

    /// Whether the inspector has more than one pane.
    pub fn are_many(&self) -> bool {
        !matches!(self.arrangement, Arrangement::Pane(_))
    }

    /// The number of a pane of the inspector as a person reads it: its place in reading order, from 1.
    pub fn number(&self, id: PaneId) -> Option<usize> {
        self.shown().iter().position(|shown| *shown == id).map(|place| place + 1)
    }

    /// The pane of the inspector that sliders and keys move.
    pub fn focus(&self) -> PaneId {
        self.focus
    }

    /// Lets sliders and keys move `id`, if the inspector has it.
    pub fn set_focus(&mut self, id: PaneId) {
        if self.shown().contains(&id) {
            self.focus = id;
        }
    }

    /// Lets them move the pane after (or before) the one in focus, in reading order, round and round.
    pub fn focus_next(&mut self, forward: bool) {
        let shown = self.shown();
        let place = shown.iter().position(|id| *id == self.focus).unwrap_or(0);
        let step = if forward { 1 } else { shown.len() - 1 };
        self.focus = shown[(place + step) % shown.len()];
    }

    /// Splits the pane called `id`: the new pane shows the same and gets the focus. Nothing happens once there are
    /// [`MAX_PANES`].
    pub fn split(&mut self, id: PaneId, direction: Direction) -> Option<PaneId> {
        if self.shown().len() >= MAX_PANES {
            return None;
        }
        let copy = Pane { over: None, ..self.get(id)?.clone() };
        let new = self.fresh();
        if !self.arrangement.split(id, direction, new) {
            return None;
        }
        self.more.insert(new, copy);
        self.focus = new;
        Some(new)
    }

    /// Splits the pane in focus and shows in the new one what `change` makes of it.
    pub fn split_with(&mut self, direction: Direction, change: impl FnOnce(&mut Pane)) -> Option<PaneId> {
        let new = self.split(self.focus, direction)?;
        if let Some(pane) = self.get_mut(new) {
            change(pane);
        }
        Some(new)
    }

    /// Shows in pane `id` the burst of `side`. The two panes that are always there stay on their bursts: a new pane
    /// takes the place of such a one.
    pub fn show_side(&mut self, id: PaneId, side: Side) {
        let Some(pane) = self.get(id).filter(|pane| pane.side != side) else { return };
        let changed = Pane { side, picture: None, problem: None, ..pane.clone() };
        if let Some(own) = self.more.get_mut(&id) {
            *own = changed;
            return;
        }
        let new = self.fresh();
        self.arrangement.replace(id, new);
        self.more.insert(new, changed);
        if self.focus == id {
            self.focus = new;
        }
        let renamed = |other: PaneId| if other == id { new } else { other };
        for (_, pane) in self.iter_mut() {
            if let Content::Difference(a, b) = pane.content {
                pane.content = Content::Difference(renamed(a), renamed(b));
            }
            pane.over = pane.over.map(|over| over.with_other(renamed(over.other())));
        }
        self.forget_missing();
    }

    /// Closes a pane of the inspector, unless it is the only one. Panes that show something of it go back to what their
    /// cursors say.
    pub fn close(&mut self, id: PaneId) {
        let shown = self.shown();
        let Some(place) = shown.iter().position(|shown| *shown == id).filter(|_| shown.len() > 1) else { return };
        self.arrangement.remove(id);
        self.more.remove(&id);
        if self.focus == id {
            let left = self.shown();
            self.focus = left[place.min(left.len() - 1)];
        }
        self.forget_missing();
    }

    /// Lays out a preset, made from the pane in focus.
    pub fn lay_out(&mut self, preset: Preset, params: &DetectorParams) {
        let Some(base) = self.get(self.focus) else { return };
        let Laid { rows, focus } = preset.lay_out(base, params);
        // The pane in focus keeps its name; all others are new.
        let kept = self.focus;
        let mut ids = Vec::new();
        let mut place = 0;
        let mut made = BTreeMap::new();
        for row in rows {
            let mut in_row = Vec::new();
            for pane in row {
                let id = if place == focus { kept } else { self.fresh() };
                in_row.push(id);
                made.insert(id, pane);
                place += 1;
            }
            ids.push(in_row);
        }
        self.replace(Arrangement::rows(&ids), made, kept);
    }

    /// Shows only `id`, which must be there.
    pub fn show_alone(&mut self, id: PaneId) {
        if let Some(pane) = self.get(id).cloned() {
            self.replace(Arrangement::Pane(id), BTreeMap::from([(id, pane)]), id);
        }
    }

    /// Takes the panes of a session: `panes` by their names, and where they are. What makes no sense is left out.
    pub fn restore(&mut self, arrangement: Arrangement, panes: BTreeMap<PaneId, Pane>, focus: PaneId) {
        let Some(arrangement) = arrangement.sanitised(|id| panes.contains_key(&id)) else { return };
        self.replace(arrangement, panes, focus);
    }

    fn replace(&mut self, arrangement: Arrangement, panes: BTreeMap<PaneId, Pane>, focus: PaneId) {
        let shown = arrangement.panes();
        self.arrangement = arrangement;
        self.more.clear();
        for (id, pane) in panes.into_iter().filter(|(id, _)| shown.contains(id)) {
            self.next = self.next.max(id.0.saturating_add(1));
            match self.sides.get_mut(id.0 as usize) {
                // The two that are always there stay on their bursts.
                Some(own) => *own = Pane { side: own.side, ..pane },
                None => {
                    self.more.insert(id, pane);
                }
            }
        }
        self.focus = if shown.contains(&focus) { focus } else { shown[0] };
        self.forget_missing();
    }

    /// Nothing is shown of panes that are not on the screen.
    fn forget_missing(&mut self) {
        let shown = self.shown();
        for (id, pane) in self.iter_mut() {
            let missing = |other: &PaneId| *other == id || !shown.contains(other);
            if let Content::Difference(a, b) = pane.content
                && (missing(&a) || missing(&b))
            {
                pane.content = Content::Cursor;
            }
            if pane.over.is_some_and(|over| missing(&over.other())) {
                pane.over = None;
            }
        }
    }

    /// Closes the panes on the burst of `side`, which is not open any more. One that is left alone goes to the other
    /// burst.
    pub fn close_side(&mut self, side: Side) {
        for id in self.shown() {
            if self.get(id).is_some_and(|pane| pane.side == side) {
                self.close(id);
            }
        }
        if self.get(self.focus).is_some_and(|pane| pane.side == side) {
            self.arrangement = Arrangement::Pane(PaneId::of(side.other()));
            self.focus = PaneId::of(side.other());
            self.more.clear();
        }
    }

    /// What was A is B, and the other way round. The two panes that are always there change places, all others stay on
    /// their bursts.
    pub fn swap_sides(&mut self) {
        self.sides.swap(0, 1);
        for (pane, side) in self.sides.iter_mut().zip(Side::BOTH) {
            pane.side = side;
        }
        self.more.values_mut().for_each(|pane| pane.side = pane.side.other());
    }

    /// Lays the next pane over the one in focus: as a wipe, then as a flip, then not any more.
    pub fn next_over(&mut self) {
        let (focus, shown) = (self.focus, self.shown());
        let place = shown.iter().position(|id| *id == focus).unwrap_or(0);
        let other = shown[(place + 1) % shown.len()];
        let Some(pane) = self.get_mut(focus) else { return };
        pane.over = match pane.over {
            None if other != focus => Some(Over::Wipe { other, at: 0.5 }),
            None | Some(Over::Flip { .. }) => None,
            Some(Over::Wipe { other, .. }) => Some(Over::Flip { other, flipped: false }),
        };
    }

    /// Shows the other picture of the flip in focus.
    pub fn flip(&mut self) {
        let focus = self.focus;
        if let Some(Pane { over: Some(Over::Flip { flipped, .. }), .. }) = self.get_mut(focus) {
            *flipped ^= true;
        }
    }

    /// Lets the panes that are linked so follow when the cursor of `moved` was moved since it was at `before`: by the
    /// same steps.
    pub fn follow_cursor(&mut self, moved: PaneId, before: Cursor) {
        let Some(after) = self.get(moved).filter(|pane| pane.links.has(Link::Cursor)).map(|pane| pane.cursor) else {
            return;
        };
        for id in self.shown() {
            if let Some(pane) = self.get_mut(id).filter(|pane| id != moved && pane.links.has(Link::Cursor)) {
                pane.cursor = pane.cursor.moved_as(&before, &after);
            }
        }
    }

    /// Lets the panes that are linked so follow when the view of `moved` was moved since it was `before`.
    pub fn follow_view(&mut self, moved: PaneId, before: &View) {
        let Some(after) = self.get(moved).filter(|pane| pane.links.has(Link::View)).map(|pane| pane.view) else {
            return;
        };
        for id in self.shown() {
            if let Some(pane) = self.get_mut(id).filter(|pane| id != moved && pane.links.has(Link::View)) {
                pane.view.follow(before, &after);
            }
        }
    }

    /// A name that no pane has.
    fn fresh(&mut self) -> PaneId {
        let id = PaneId(self.next);
        self.next += 1;
        id
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::canvas::Zoom;
    use crate::app::project::cursor::ViewKind;
    use crate::detector::Slope;

    const A: PaneId = PaneId(0);

    #[test]
    fn panes_are_split_focused_and_closed() {
        let mut panes = Panes::default();
        assert!(!panes.are_many());
        panes.close(A);
        assert_eq!(panes.shown(), [A], "the only pane stays");
        let right = panes.split(A, Direction::Right).expect("there is room");
        let below = panes.split(right, Direction::Down).expect("there is room");
        assert_eq!((panes.shown(), panes.focus()), (vec![A, right, below], below));
        assert_eq!((panes.number(right), panes.number(PaneId(1))), (Some(2), None));
        panes.focus_next(true);
        assert_eq!(panes.focus(), A);
        panes.focus_next(false);
        assert_eq!(panes.focus(), below);
        panes.close(below);
        assert_eq!((panes.shown(), panes.focus()), (vec![A, right], right));
        panes.close(A);
        assert_eq!(panes.shown(), [right]);
        assert_eq!(panes.of(Side::A).side, Side::A, "the pane of A is still there for the other workspaces");
        for _ in 0..2 * MAX_PANES {
            panes.split(panes.focus(), Direction::Right);
        }
        assert_eq!(panes.shown().len(), MAX_PANES);
    }

    #[test]
    fn linked_cursors_keep_their_distance_and_others_stay() {
        let mut panes = Panes::default();
        panes.lay_out(Preset::Slopes(3), &DetectorParams::default());
        let slopes = |panes: &Panes| -> Vec<f32> {
            panes.shown().iter().map(|id| panes.get(*id).expect("shown").cursor.slope.u).collect()
        };
        assert_eq!(slopes(&panes), [-1.0, 0.0, 1.0]);
        let focus = panes.focus();
        let last = panes.shown()[2];
        panes.get_mut(last).expect("shown").links.cursor = false;
        let before = panes.get(focus).expect("shown").cursor;
        panes.get_mut(focus).expect("shown").cursor.slope = Slope::new(1.5, 0.0);
        panes.follow_cursor(focus, before);
        assert_eq!(slopes(&panes), [0.5, 1.5, 1.0]);
        let (first, before) = (panes.shown()[0], panes.get(focus).expect("shown").view);
        panes.get_mut(focus).expect("shown").view.zoom = Zoom::PointsPerPixel(3.0);
        panes.follow_view(focus, &before);
        assert_eq!(panes.get(first).expect("shown").view.zoom, Zoom::PointsPerPixel(3.0));
    }

    #[test]
    fn what_is_shown_of_a_pane_goes_with_it() {
        let mut panes = Panes::default();
        let second = panes.split(A, Direction::Right).expect("there is room");
        let third = panes.split_with(Direction::Down, |pane| pane.content = Content::Difference(A, second));
        let third = third.expect("there is room");
        panes.set_focus(A);
        panes.next_over();
        assert_eq!(panes.get(A).and_then(|pane| pane.over), Some(Over::Wipe { other: second, at: 0.5 }));
        panes.next_over();
        panes.flip();
        assert_eq!(panes.get(A).and_then(|pane| pane.over), Some(Over::Flip { other: second, flipped: true }));
        panes.close(second);
        assert_eq!(panes.get(A).and_then(|pane| pane.over), None);
        assert_eq!(panes.get(third).map(|pane| pane.content), Some(Content::Cursor));
    }

    #[test]
    fn a_preset_keeps_the_pane_in_focus_and_forgets_the_others() {
        let mut panes = Panes::default();
        let params = DetectorParams::default();
        panes.of_mut(Side::A).show(ViewKind::Dog);
        panes.lay_out(Preset::TwoByTwo, &params);
        assert_eq!((panes.shown().len(), panes.focus(), panes.number(A)), (4, A, Some(3)));
        panes.lay_out(Preset::Single, &params);
        assert_eq!((panes.shown(), panes.iter().count()), (vec![A], 2));
        assert!(panes.of(Side::A).shows(ViewKind::Dog));
    }

    #[test]
    fn the_panes_that_are_always_there_stay_on_their_bursts() {
        let mut panes = Panes::default();
        let right = panes.split(A, Direction::Right).expect("there is room");
        panes.next_over();
        assert_eq!(panes.get(right).and_then(|pane| pane.over).map(Over::other), Some(A));
        panes.show_side(A, Side::B);
        assert_eq!(panes.of(Side::A).side, Side::A);
        let first = panes.shown()[0];
        assert!(first != A && panes.get(first).is_some_and(|pane| pane.side == Side::B));
        assert_eq!(panes.get(right).and_then(|pane| pane.over).map(Over::other), Some(first));
        panes.show_side(right, Side::B);
        assert_eq!(panes.shown(), [first, right]);
    }

    #[test]
    fn a_burst_that_is_closed_takes_its_panes_with_it() {
        let mut panes = Panes::default();
        panes.split_with(Direction::Right, |pane| pane.side = Side::B);
        panes.close_side(Side::B);
        assert_eq!((panes.shown(), panes.focus()), (vec![A], A));
        panes.split_with(Direction::Right, |pane| pane.side = Side::B);
        panes.close(A);
        panes.close_side(Side::B);
        assert_eq!((panes.shown(), panes.focus()), (vec![A], A));
    }
}
