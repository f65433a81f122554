//! Panes as a file holds them: what makes no sense is left out as they are read.

use super::set::{PLACES, Placed, place_of};
use super::{Over, Pane, PaneId, Panes};
use crate::app::project::side::Side;
use crate::app::project::workspace::Workspace;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

#[derive(Clone, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(super) struct PanesFile {
    open: Workspace,
    /// Number of the next pane.
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
        let (open, next) = (PLACES[panes.open], panes.next);
        let [inspect, pair, methods] = panes.placed;
        Self { open, next, inspect, pair, methods, pane }
    }
}

impl TryFrom<PanesFile> for Panes {
    type Error = String;

    fn try_from(file: PanesFile) -> Result<Self, String> {
        let mut all = BTreeMap::new();
        for (name, pane) in file.pane {
            let id = name.parse().map_err(|_| format!("a pane is named '{name}'; give it a number"))?;
            all.insert(PaneId(id), sound(pane));
        }
        let mut panes = Self::default();
        for (side, own) in Side::BOTH.into_iter().zip(&mut panes.sides) {
            if let Some(pane) = all.get(&PaneId::of(side)) {
                *own = Pane { side, method: None, ..pane.clone() };
            }
        }
        for (workspace, placed) in PLACES.into_iter().zip([file.inspect, file.pair, file.methods]) {
            panes.restore(workspace, placed.arrangement, all.clone(), placed.focus);
        }
        (panes.open, panes.next) = (place_of(file.open), panes.next.max(file.next));
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
