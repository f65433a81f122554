//! Presets of *Methods*, and changes there when a method is switched on or off.

use super::preset::in_rows;
use super::set::place_of;
use super::{Arrangement, Content, Link, Over, Pane, PaneId, Panes};
use crate::app::document::look::Ranges;
use crate::app::document::method::MethodId;
use crate::app::document::side::Side;
use crate::teach::Workspace;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MethodsPreset {
    #[default]
    Panes,
    Wipe,
    Flip,
    Matches,
}

impl MethodsPreset {
    /// All, with their names and what each shows.
    pub const ALL: [(Self, &'static str, &'static str); 4] = [
        (Self::Panes, "Panes", "A picture for each method, side by side"),
        (Self::Wipe, "Wipe", "Two methods in one picture, with a line between them that can be dragged"),
        (Self::Flip, "Flip", "Two methods in one place: Y flips from one to the other"),
        (Self::Matches, "Match lines", "A row for each method: its matches between A and B"),
    ];
}

impl Panes {
    /// On B as well where the preset shows matches. A wipe or flip takes SIFT and BuFF 1D where these are compared.
    pub fn lay_out_methods(&mut self, preset: MethodsPreset, methods: &[MethodId], both: bool) {
        let usual = [MethodId::Sift, MethodId::Buff1d];
        let mut two = usual.into_iter().chain(methods.iter().copied()).filter(|method| methods.contains(method));
        let first = two.next();
        let second = two.find(|method| Some(*method) != first);
        let two: Vec<MethodId> = first.into_iter().chain(second).collect();
        let mut made = BTreeMap::new();
        let mut make = |panes: &mut Self, method: MethodId, side: Side| {
            let id = panes.fresh();
            made.insert(id, panes.of_method(method, side));
            id
        };
        let arrangement = match preset {
            MethodsPreset::Wipe | MethodsPreset::Flip if two.len() > 1 => {
                let ids: Vec<PaneId> = two.into_iter().map(|method| make(self, method, Side::A)).collect();
                let other = ids[1];
                let over = match preset {
                    MethodsPreset::Wipe => Over::Wipe { other, at: 0.5 },
                    _ => Over::Flip { other, flipped: false },
                };
                made.entry(ids[0]).and_modify(|pane| pane.over = Some(over));
                Arrangement::Tabs { parts: ids.into_iter().map(Arrangement::Pane).collect(), active: 0 }
            }
            MethodsPreset::Matches if both => {
                let row = |method: &MethodId| Side::BOTH.map(|side| make(self, *method, side)).to_vec();
                Arrangement::rows(&methods.iter().map(row).collect::<Vec<_>>())
            }
            _ => Arrangement::rows(&in_rows(methods.iter().map(|method| make(self, *method, Side::A)).collect())),
        };
        let Some(focus) = arrangement.panes().first().copied() else { return };
        self.replace(place_of(Workspace::Methods), arrangement, made, focus);
    }

    /// Where it has none: on A, and with B in a row of its own where the others have such rows.
    pub fn add_method(&mut self, method: MethodId, both: bool) {
        let place = place_of(Workspace::Methods);
        let shown = self.shown_in(Workspace::Methods);
        let panes = || shown.iter().filter_map(|id| self.get(*id));
        if panes().any(|pane| pane.method == Some(method)) || shown.len() + 2 > super::MAX_PANES {
            return;
        }
        let rows_of_both = both && panes().any(|pane| pane.side == Side::B);
        let sides = if rows_of_both { &Side::BOTH[..] } else { &Side::BOTH[..1] };
        let mut ids = Vec::new();
        for side in sides {
            let id = self.fresh();
            let pane = self.of_method(method, *side);
            self.more.insert(id, pane);
            ids.push(id);
        }
        self.placed[place].arrangement.append(&ids);
    }

    pub fn remove_method(&mut self, method: MethodId) {
        let place = place_of(Workspace::Methods);
        for id in self.shown_in(Workspace::Methods) {
            if self.get(id).is_some_and(|pane| pane.method == Some(method)) {
                self.close_in(place, id);
            }
        }
    }

    fn of_method(&self, method: MethodId, side: Side) -> Pane {
        let shown = self.shown_in(Workspace::Methods);
        let alike = |pane: &&Pane| pane.method.is_some() && pane.method != Some(MethodId::Gold) && pane.side == side;
        let base = shown.iter().filter_map(|id| self.get(*id)).find(alike).unwrap_or_else(|| self.of(side));
        let mut pane = Pane {
            method: Some(method),
            content: Content::Cursor,
            slope_chosen: true,
            cursor: base.cursor,
            view: base.view,
            ..Pane::new(side)
        };
        if method == MethodId::Gold {
            // It was taken in other light.
            pane.links.set(Link::Display, false);
            pane.own_ranges = Some(Ranges::default());
        }
        pane
    }
}
