//! All panes, their arrangement in each workspace, and the focus.

use super::{Arrangement, Link, Over, Pane, PaneId};
use crate::app::document::{MethodId, Side};
use crate::teach::Workspace;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Place of an arrangement: *One burst* has two, one where methods are compared and one for all else.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PaneGroup {
    #[default]
    Inspect,
    Pair,
    Methods,
}

impl PaneGroup {
    pub(super) const ALL: [Self; 3] = [Self::Inspect, Self::Pair, Self::Methods];

    /// Workspaces without own panes use the panes of *One burst*.
    fn of(workspace: Workspace) -> Self {
        if workspace.shows_pair() { Self::Pair } else { Self::Inspect }
    }
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Placed {
    pub(super) arrangement: Arrangement,
    pub(super) focus: PaneId,
}

impl Placed {
    pub(super) fn alone(id: PaneId) -> Self {
        Self { arrangement: Arrangement::Pane(id), focus: id }
    }
}

pub(super) type PanesById = BTreeMap<PaneId, Pane>;

/// Two panes, one a burst, are permanent. In several workspaces a pane shows the same.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "PanesFile", into = "PanesFile")]
pub struct Panes {
    pub(super) sides: [Pane; 2],
    pub(super) more: PanesById,
    pub(super) placed: [Placed; PaneGroup::ALL.len()],
    pub open: PaneGroup,
    pub(super) next: u32,
}

impl Default for Panes {
    fn default() -> Self {
        let mut sides = Side::BOTH.map(Pane::new);
        // A pixel position in another burst is not the same place of the scene.
        sides[Side::B as usize].links.place = false;
        let mut placed = PaneGroup::ALL.map(|_| Placed::alone(PaneId::of(Side::A)));
        placed[PaneGroup::Pair as usize].arrangement = Arrangement::sides();
        Self { sides, more: PanesById::new(), placed, open: PaneGroup::Inspect, next: 2 }
    }
}

impl Arrangement {
    pub(super) fn sides() -> Self {
        Self::rows(&[Side::BOTH.map(PaneId::of).to_vec()])
    }

    fn stacked_sides() -> Self {
        Self::rows(&Side::BOTH.map(|side| vec![PaneId::of(side)]))
    }
}

impl Panes {
    pub fn turn_to(&mut self, workspace: Workspace) {
        self.open = PaneGroup::of(workspace);
    }

    /// Follows the workspace that is on show, where methods may be compared.
    pub fn follow(&mut self, workspace: Workspace) {
        if !(self.open == PaneGroup::Methods && workspace.inspects()) {
            self.turn_to(workspace);
        }
    }

    pub fn get(&self, id: PaneId) -> Option<&Pane> {
        self.sides.get(id.0 as usize).or_else(|| self.more.get(&id))
    }

    pub fn get_mut(&mut self, id: PaneId) -> Option<&mut Pane> {
        self.sides.get_mut(id.0 as usize).or_else(|| self.more.get_mut(&id))
    }

    pub fn is_on(&self, id: PaneId, side: Side) -> bool {
        self.get(id).is_some_and(|pane| pane.side == side)
    }

    pub fn has_link(&self, id: PaneId, link: Link) -> bool {
        self.get(id).is_some_and(|pane| pane.links.has(link))
    }

    pub fn of(&self, side: Side) -> &Pane {
        &self.sides[side as usize]
    }

    pub fn of_mut(&mut self, side: Side) -> &mut Pane {
        &mut self.sides[side as usize]
    }

    pub fn iter(&self) -> impl Iterator<Item = (PaneId, &Pane)> {
        let sides = Side::BOTH.into_iter().map(|side| (PaneId::of(side), self.of(side)));
        sides.chain(self.more.iter().map(|(id, pane)| (*id, pane)))
    }

    pub fn iter_mut(&mut self) -> impl Iterator<Item = (PaneId, &mut Pane)> {
        let sides = Side::BOTH.into_iter().map(PaneId::of).zip(&mut self.sides);
        sides.chain(self.more.iter_mut().map(|(id, pane)| (*id, pane)))
    }

    pub(super) fn here(&self) -> &Placed {
        &self.placed[self.open as usize]
    }

    pub(super) fn here_mut(&mut self) -> &mut Placed {
        &mut self.placed[self.open as usize]
    }

    pub fn arrangement(&self) -> &Arrangement {
        &self.here().arrangement
    }

    /// Takes an arrangement in which the pointer moved panes; one with other panes is ignored.
    pub fn rearrange(&mut self, arrangement: Arrangement) {
        let mut panes = [arrangement.panes(), self.shown()];
        panes.iter_mut().for_each(|ids| ids.sort_unstable());
        if panes[0] == panes[1] {
            self.here_mut().arrangement = arrangement;
        }
    }

    /// Places A and B one above the other or side by side, unless panes were added or moved.
    pub fn place_by_shape(&mut self, stacked: bool) {
        let arrangement = &mut self.placed[PaneGroup::Pair as usize].arrangement;
        if [Arrangement::sides(), Arrangement::stacked_sides()].contains(arrangement) {
            *arrangement = if stacked { Arrangement::stacked_sides() } else { Arrangement::sides() };
        }
    }

    pub fn shown(&self) -> Vec<PaneId> {
        self.arrangement().panes()
    }

    pub fn each_shown(&self) -> impl Iterator<Item = &Pane> {
        self.shown().into_iter().filter_map(|id| self.get(id))
    }

    pub fn shown_in(&self, place: PaneGroup) -> Vec<PaneId> {
        self.placed[place as usize].arrangement.panes()
    }

    pub fn shown_of(&self, side: Side, method: Option<MethodId>) -> Vec<PaneId> {
        let is_of = |id: &PaneId| self.get(*id).is_some_and(|pane| pane.side == side && pane.method == method);
        self.shown().into_iter().filter(is_of).collect()
    }

    pub(super) fn beside(&self, id: PaneId) -> Vec<PaneId> {
        let panes = self.placed.iter().map(|placed| placed.arrangement.panes());
        let mut beside: Vec<PaneId> = panes.filter(|panes| panes.contains(&id)).flatten().collect();
        beside.retain(|other| *other != id);
        // Two panes may stand beside each other in several workspaces.
        beside.sort_unstable();
        beside.dedup();
        beside
    }

    pub fn are_many(&self) -> bool {
        !matches!(self.arrangement(), Arrangement::Pane(_))
    }

    /// Number of a pane on the screen, as shown: its place in reading order, from 1.
    pub fn number(&self, id: PaneId) -> Option<usize> {
        self.shown().iter().position(|shown| *shown == id).map(|place| place + 1)
    }

    pub fn over(&self, id: PaneId) -> Option<Over> {
        self.get(id)?.over.filter(|over| self.shown().contains(&over.other()))
    }

    pub fn focus(&self) -> PaneId {
        self.here().focus
    }

    pub fn set_focus(&mut self, id: PaneId) {
        if self.shown().contains(&id) {
            self.here_mut().focus = id;
        }
    }

    pub fn focus_next(&mut self, forward: bool) {
        let (shown, focus) = (self.shown(), self.focus());
        let place = shown.iter().position(|id| *id == focus).unwrap_or(0);
        let step = if forward { 1 } else { shown.len() - 1 };
        self.here_mut().focus = shown[(place + step) % shown.len()];
    }

    pub(super) fn fresh(&mut self) -> PaneId {
        // A file may hold the largest number; the first two belong to the permanent panes.
        while self.next < 2 || self.more.contains_key(&PaneId(self.next)) {
            self.next = self.next.wrapping_add(1);
        }
        let id = PaneId(self.next);
        self.next = self.next.wrapping_add(1);
        id
    }
}

/// Panes as a file holds them: what makes no sense is left out as they are read.
#[derive(Clone, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct PanesFile {
    open: PaneGroup,
    next: u32,
    inspect: Placed,
    pair: Placed,
    methods: Placed,
    pane: BTreeMap<String, Pane>,
}

impl Default for PanesFile {
    fn default() -> Self {
        Panes::default().into()
    }
}

impl From<Panes> for PanesFile {
    fn from(panes: Panes) -> Self {
        let pane = panes.iter().map(|(id, pane)| (id.0.to_string(), pane.clone())).collect();
        let (open, next) = (panes.open, panes.next);
        let [inspect, pair, methods] = panes.placed;
        Self { open, next, inspect, pair, methods, pane }
    }
}

impl TryFrom<PanesFile> for Panes {
    type Error = String;

    fn try_from(file: PanesFile) -> Result<Self, String> {
        let mut all = PanesById::new();
        for (name, pane) in file.pane {
            let id = name.parse().map_err(|_| format!("a pane is named '{name}'; give it a number"))?;
            all.insert(PaneId(id), sound(pane));
        }
        let mut panes = Self::default();
        // The permanent panes stay on their bursts, whatever a file holds.
        for (side, own) in Side::BOTH.into_iter().zip(&mut panes.sides) {
            if let Some(pane) = all.get(&PaneId::of(side)) {
                *own = Pane { side, method: None, ..pane.clone() };
            }
        }
        for (place, placed) in PaneGroup::ALL.into_iter().zip([file.inspect, file.pair, file.methods]) {
            panes.restore(place, placed, all.clone());
        }
        // Ids are not used again, even those of panes that were left out.
        (panes.open, panes.next) = (file.open, panes.next.max(file.next));
        Ok(panes)
    }
}

fn sound(mut pane: Pane) -> Pane {
    pane.over = pane.over.map(|over| match over {
        Over::Wipe { other, at } => Over::Wipe { other, at: if at.is_finite() { at.clamp(0.0, 1.0) } else { 0.5 } },
        flip @ Over::Flip { .. } => flip,
    });
    // A pane that shares its display has no own ranges; any other pane has.
    pane.own_ranges =
        if pane.links.display { None } else { Some(pane.own_ranges.take().unwrap_or_default().sanitised()) };
    pane
}
