//! Changes of the set of panes: splitting, closing, new layouts, sessions, and following the open bursts.

use super::preset::Laid;
use super::set::{PanesById, Placed};
use super::{Arrangement, Content, Direction, MAX_PANES, Over, Pane, PaneGroup, PaneId, Panes, Preset};
use crate::app::document::Side;
use crate::detector::DetectorParams;
use std::collections::BTreeMap;

impl Panes {
    /// The new pane shows the same and gets the focus; `None` once there are [`MAX_PANES`].
    pub fn split(&mut self, id: PaneId, direction: Direction) -> Option<PaneId> {
        if self.shown().len() >= MAX_PANES {
            return None;
        }
        let copy = Pane { over: None, ..self.get(id)?.clone() };
        let new = self.fresh();
        if !self.here_mut().arrangement.split(id, direction, new) {
            return None;
        }
        self.more.insert(new, copy);
        self.here_mut().focus = new;
        Some(new)
    }

    /// The two permanent panes stay on their bursts: a new pane takes the place of such a one.
    pub fn show_side(&mut self, id: PaneId, side: Side) {
        let Some(pane) = self.get(id).filter(|pane| self.shown().contains(&id) && pane.side != side) else { return };
        let changed = Pane { side, ..pane.clone() };
        if let Some(own) = self.more.get_mut(&id) {
            *own = changed;
            return;
        }
        let new = self.fresh();
        let here = self.here_mut();
        here.arrangement.replace(id, new);
        if here.focus == id {
            here.focus = new;
        }
        self.more.insert(new, changed);
        // Panes that subtract or overlay this pane follow to the new id.
        let renamed = |other: PaneId| if other == id { new } else { other };
        for shown in self.shown() {
            let Some(pane) = self.get_mut(shown) else { continue };
            if let Content::Difference(a, b) = pane.content {
                pane.content = Content::Difference(renamed(a), renamed(b));
            }
            pane.over.iter_mut().map(Over::other_mut).for_each(|other| *other = renamed(*other));
        }
        self.forget_missing();
    }

    /// The last pane stays. Panes with this pane's picture go back to their own cursors.
    pub fn close(&mut self, id: PaneId) {
        self.close_in(self.open, id);
    }

    pub(super) fn close_in(&mut self, place: PaneGroup, id: PaneId) {
        let placed = &mut self.placed[place as usize];
        let shown = placed.arrangement.panes();
        let Some(at) = shown.iter().position(|shown| *shown == id).filter(|_| shown.len() > 1) else { return };
        placed.arrangement.remove(id);
        if placed.focus == id {
            // Focus stays where the closed pane was.
            let left = placed.arrangement.panes();
            placed.focus = left[at.min(left.len() - 1)];
        }
        self.forget_missing();
    }

    pub fn lay_out(&mut self, preset: Preset, params: &DetectorParams) {
        let Some(base) = self.get(self.focus()) else { return };
        let Laid { rows, focus } = preset.lay_out(base, params);
        // The focused pane keeps its id; all others are new.
        let (kept, mut made) = (self.focus(), BTreeMap::new());
        let mut id_of = |pane: Pane| {
            let id = if made.len() == focus { kept } else { self.fresh() };
            made.insert(id, pane);
            id
        };
        let ids: Vec<Vec<PaneId>> = rows.into_iter().map(|row| row.into_iter().map(&mut id_of).collect()).collect();
        self.replace(self.open, Placed { arrangement: Arrangement::rows(&ids), focus: kept }, made);
    }

    pub fn show_alone(&mut self, id: PaneId) {
        if let Some(pane) = self.get(id).cloned() {
            self.replace(PaneGroup::Inspect, Placed::alone(id), BTreeMap::from([(id, pane)]));
        }
    }

    /// Invalid parts of what a session holds are left out.
    pub(super) fn restore(&mut self, place: PaneGroup, Placed { arrangement, focus }: Placed, panes: PanesById) {
        if let Some(arrangement) = arrangement.sanitised(|id| panes.contains_key(&id)) {
            self.replace(place, Placed { arrangement, focus }, panes);
        }
    }

    pub fn take_placed(&mut self, place: PaneGroup, from: &Self) {
        let panes = from.iter().map(|(id, pane)| (id, pane.clone())).collect();
        self.restore(place, from.placed[place as usize].clone(), panes);
    }

    /// The first pane gets the focus where that of `placed` is not among those shown.
    pub(super) fn replace(&mut self, place: PaneGroup, Placed { arrangement, focus }: Placed, panes: PanesById) {
        let shown = arrangement.panes();
        let focus = if shown.contains(&focus) { focus } else { shown[0] };
        self.placed[place as usize] = Placed { arrangement, focus };
        for (id, pane) in panes.into_iter().filter(|(id, _)| shown.contains(id)) {
            // A file may hold larger ids than those in use.
            self.next = self.next.max(id.0.saturating_add(1));
            match self.sides.get_mut(id.0 as usize) {
                // The two permanent panes stay on their bursts.
                Some(own) => *own = Pane { side: own.side, method: None, ..pane },
                None => _ = self.more.insert(id, pane),
            }
        }
        self.forget_missing();
    }

    /// Drops the panes that no arrangement has, and forgets those that panes subtract or overlay.
    fn forget_missing(&mut self) {
        let Self { more, placed, .. } = self;
        more.retain(|id, _| placed.iter().any(|placed| placed.arrangement.panes().contains(id)));
        let ids: Vec<PaneId> = self.iter().map(|(id, _)| id).collect();
        for id in ids {
            let beside = self.beside(id);
            let Some(pane) = self.get_mut(id) else { continue };
            let missing = |other: PaneId| !beside.contains(&other);
            if matches!(pane.content, Content::Difference(a, b) if missing(a) || missing(b)) {
                pane.content = Content::Cursor;
            }
            pane.over = pane.over.filter(|over| !missing(over.other()));
        }
    }

    /// A pane that is left alone goes to the other burst; *Two bursts* goes back to one pane for each.
    pub fn close_side(&mut self, side: Side) {
        for place in PaneGroup::ALL {
            if place == PaneGroup::Pair {
                let placed = Placed { arrangement: Arrangement::sides(), focus: PaneId::of(side.other()) };
                self.replace(place, placed, BTreeMap::new());
                continue;
            }
            for id in self.placed[place as usize].arrangement.panes() {
                if self.get(id).is_some_and(|pane| pane.side == side) {
                    self.close_in(place, id);
                }
            }
            if self.get(self.placed[place as usize].focus).is_some_and(|pane| pane.side == side) {
                self.replace(place, Placed::alone(PaneId::of(side.other())), BTreeMap::new());
            }
        }
    }

    /// Panes of *One burst* keep the burst; panes of both bursts or of methods keep the side.
    pub fn swap_sides(&mut self) {
        self.sides.swap(0, 1);
        for (pane, side) in self.sides.iter_mut().zip(Side::BOTH) {
            pane.side = side;
        }
        let inspected = self.shown_in(PaneGroup::Inspect);
        for (id, pane) in &mut self.more {
            if inspected.contains(id) {
                pane.side = pane.side.other();
            }
        }
    }
}
