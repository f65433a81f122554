//! The panes of A and of B: the active cursor, and the properties that the panes share.

use crate::app::document::Document;
use crate::app::pane::{Link, PaneId, PaneLinks};
use crate::app::project::Model;
use crate::app::project::cursor::Cursor;
use crate::app::project::look::Ranges;
use crate::app::project::side::Side;
use crate::app::project::workspace::Workspace;
use crate::requests::Picture;

impl Document {
    pub fn bring_cursors_together(&mut self) {
        let (cursor, side) = (*self.cursor(), self.focused().side.other());
        let own = PaneId::of(side);
        let others = self.panes.shown_of(side, None);
        let alone = others.len() < 2;
        for id in others.into_iter().filter(|id| *id != own).chain([own]) {
            if let Some(pane) = self.panes.get_mut(id) {
                let kind = if alone { cursor.kind } else { pane.cursor.kind };
                (pane.cursor, pane.slope_chosen) = (Cursor { kind, ..cursor }, true);
            }
        }
    }

    /// Cursors of two bursts that are linked are brought together.
    pub fn toggle_link(&mut self, link: Link) {
        let on = !self.panes.all_share(link);
        if self.workspace == Workspace::Pair {
            self.link_pair(link, on);
        } else {
            self.panes.shown().into_iter().for_each(|id| self.set_link(id, link, on));
        }
        if on && link == Link::Cursor && self.workspace == Workspace::Pair {
            self.bring_cursors_together();
        }
    }

    pub fn cursor_of(&self, side: Side) -> &Cursor {
        &self.panes.of(side).cursor
    }

    /// The pane that stands for the burst of `side` in *Two bursts*: its own, or where that was closed the first one.
    pub fn pane_for(&self, side: Side) -> PaneId {
        let own = PaneId::of(side);
        let shown = self.panes.shown_in(Workspace::Pair);
        let is_on = |id: &PaneId| self.panes.get(*id).is_some_and(|pane| pane.side == side);
        if shown.contains(&own) { own } else { shown.into_iter().find(is_on).unwrap_or(own) }
    }

    pub fn ranges_of_side(&self, side: Side) -> &Ranges {
        self.ranges_of(self.panes.of(side))
    }

    /// Links that all panes of *Two bursts* have.
    pub fn pair_links(&self) -> PaneLinks {
        let shown = self.panes.shown_in(Workspace::Pair);
        let all = |link| shown.iter().filter_map(|id| self.panes.get(*id)).all(|pane| pane.links.has(link));
        let (view, cursor, display) = (all(Link::View), all(Link::Cursor), all(Link::Display));
        PaneLinks { view, cursor, display, ..PaneLinks::default() }
    }

    pub fn link_pair(&mut self, link: Link, on: bool) {
        for id in self.panes.shown_in(Workspace::Pair) {
            if on || self.panes.get(id).is_some_and(|pane| pane.side == Side::B) {
                self.set_link(id, link, on);
            }
        }
    }

    pub fn focus_other_side(&mut self) {
        let side = self.focused().side.other();
        if let Some(id) = self.panes.shown_of(side, self.focused().method).first() {
            self.panes.set_focus(*id);
        }
    }

    pub fn set_pair_links(&mut self, links: PaneLinks) {
        for link in [Link::View, Link::Cursor, Link::Display] {
            self.link_pair(link, links.has(link));
        }
    }
}

impl Model {
    /// Side whose slope and scale the cursor sets now.
    pub fn active_side(&self) -> Side {
        let both = self.document.workspace == Workspace::Pair && self.results.slots.b.burst.is_some();
        if both { self.document.focused().side } else { Side::A }
    }

    pub fn picture_of(&self, side: Side) -> Option<&Picture> {
        self.picture_in(self.document.pane_for(side))
    }

    pub(in crate::app) fn go_to_match(&mut self) {
        let Some(matches) = self.results.pair.matches.clone() else { return };
        let Some(row) = self.document.selected_match.and_then(|index| matches.row(index)) else { return };
        let sigma = row.a.sigma.max(row.b.sigma).max(1.0);
        // Of each burst the pane in focus, or its first; those that are linked to it come along.
        let panes = &mut self.document.panes;
        let leaders = Side::BOTH.map(|side| {
            let shown = panes.shown_of(side, None);
            let leader = shown.iter().find(|id| **id == panes.focus()).or(shown.first());
            leader.copied().unwrap_or(PaneId::of(side))
        });
        let zooms = leaders.map(|id| panes.get(id).map_or(0.0, |pane| pane.view.points_per_pixel()));
        let zoom = (40.0 / sigma).max(zooms[0]).max(zooms[1]);
        for ((side, feature), leader) in [(Side::A, row.a), (Side::B, row.b)].into_iter().zip(leaders) {
            let links = panes.get(leader).map(|pane| pane.links).unwrap_or_default();
            for id in panes.shown_of(side, None).into_iter().chain([leader]) {
                let Some(pane) = panes.get_mut(id) else { continue };
                if id == leader || (links.cursor && pane.links.cursor) {
                    pane.cursor.slope = feature.slope;
                }
                if id == leader {
                    pane.show_slope();
                }
                if id == leader || (links.view && pane.links.view) {
                    pane.view.look_at(egui::pos2(feature.u, feature.v), zoom);
                }
            }
        }
        self.document.playing = false;
    }
}
