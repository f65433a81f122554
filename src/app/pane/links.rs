//! Links between panes: a pane with a link moves, and is moved by, every other pane with that link; and the places at
//! which two panes show the same of the scene.

use super::{Over, Pane, PaneId, Panes};
use crate::app::{defaults::with_defaults, document::Cursor, view::View, words::choices};
use crate::burst::{Offset, Positions};
use crate::requests::PictureKind;
use egui::{Pos2, vec2};
use serde::{Deserialize, Serialize};
use std::ops::Range;

choices! {
    Link {
        View: "Link view", "Zoom and pan together with the other panes that have this link";
        Display: "Link display", "Share the value range and the colour map; without it this pane has its own";
        /// Frame, slope, octave and level: they move by equal steps, so that differences between panes stay.
        Cursor: "Link cursor",
        "Move frame, slope, octave and level together, by the same steps; other bursts and methods also change the kind of picture";
        Place: "Link place", "Mark the place under the pointer, moved along the slope in frames, with its value";
    }
}

with_defaults! {
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
    #[serde(default)]
    pub struct PaneLinks {
        pub view: bool = true,
        pub display: bool = true,
        pub cursor: bool = true,
        pub place: bool = true,
    }
}

impl PaneLinks {
    fn field(&mut self, link: Link) -> &mut bool {
        match link {
            Link::View => &mut self.view,
            Link::Display => &mut self.display,
            Link::Cursor => &mut self.cursor,
            Link::Place => &mut self.place,
        }
    }

    pub fn has(mut self, link: Link) -> bool {
        *self.field(link)
    }

    pub fn set(&mut self, link: Link, on: bool) {
        *self.field(link) = on;
    }
}

impl Panes {
    /// Panes linked to `first` by `link`, in one workspace or over several of them; empty if `first` lacks the link.
    pub(super) fn linked_to(&self, first: PaneId, link: Link) -> Vec<PaneId> {
        if !self.has_link(first, link) {
            return Vec::new();
        }
        // Links carry on: a pane that is in two workspaces joins the panes of both.
        let mut linked = vec![first];
        let mut place = 0;
        while place < linked.len() {
            let mut beside = self.beside(linked[place]);
            beside.retain(|id| self.has_link(*id, link) && !linked.contains(id));
            linked.extend(beside);
            place += 1;
        }
        linked.split_off(1)
    }

    /// Panes whose cursors follow the focused one, and may so leave the burst's range.
    pub fn followers(&self) -> Vec<PaneId> {
        self.linked_to(self.focus(), Link::Cursor)
    }

    /// Moves linked cursors by the steps of `moved`; panes of other bursts and methods also take a new kind of picture.
    pub fn follow_cursor(&mut self, moved: PaneId, before: Cursor) {
        let Some(leader) = self.get(moved) else { return };
        let (after, side, method) = (leader.cursor, leader.side, leader.method);
        // Only a change that is seen counts: a map hides the kind of the cursor.
        let changed_kind = leader.shows(after.kind) && after.kind != before.kind;
        for id in self.linked_to(moved, Link::Cursor) {
            let Some(pane) = self.get_mut(id) else { continue };
            pane.cursor = pane.cursor.moved_as(&before, &after);
            if changed_kind && (pane.side, pane.method) != (side, method) && pane.shows(before.kind) {
                pane.show(after.kind);
            }
        }
    }

    pub fn follow_view(&mut self, moved: PaneId, before: &View) {
        let Some(after) = self.get(moved).map(|pane| pane.view).filter(|after| after != before) else { return };
        for id in self.linked_to(moved, Link::View) {
            if let Some(pane) = self.get_mut(id) {
                pane.view.follow(before, &after);
            }
        }
    }

    pub fn all_share(&self, link: Link) -> bool {
        self.each_shown().all(|pane| pane.links.has(link))
    }

    /// Lays the next pane's picture over the focused one: first as a wipe, then as a flip, then not any more.
    pub fn next_over(&mut self) {
        let (focus, shown) = (self.focus(), self.shown());
        let place = shown.iter().position(|id| *id == focus).unwrap_or(0);
        let other = shown[(place + 1) % shown.len()];
        let over = self.over(focus);
        let Some(pane) = self.get_mut(focus) else { return };
        pane.over = match over {
            None if other != focus => Some(Over::Wipe { other, at: 0.5 }),
            None | Some(Over::Flip { .. }) => None,
            Some(Over::Wipe { other, .. }) => Some(Over::Flip { other, flipped: false }),
        };
    }

    pub fn flip(&mut self) {
        let focus = self.focus();
        if let Some(Pane { over: Some(Over::Flip { flipped, .. }), .. }) = self.get_mut(focus) {
            *flipped ^= true;
        }
    }
}

/// Maps a place of one pane to another, in image pixels; the frames `used` of those at `positions` are searched.
/// Pictures of many frames show it where it is at mid-burst, a frame shows it moved along its slope: that of the pane
/// that shows no frame, or that of the pane under the pointer if both show frames.
pub fn place_in(
    pos_image: Pos2,
    from_kind: PictureKind,
    from: &Cursor,
    to_kind: PictureKind,
    to: &Cursor,
    (positions, used): (&Positions, Range<usize>),
) -> Pos2 {
    use PictureKind::{Dog, Frame, Map, Merge, Stack};
    // From mid-burst; 0 for pictures of the whole burst.
    let after = |kind: PictureKind| match kind {
        Frame(t) => positions.offset_from(used.clone(), t).to_f32(),
        _ => Offset::default(),
    };
    let slope = match (from_kind, to_kind) {
        (Frame(_), Stack { slope } | Dog { slope, .. } | Map { slope, .. })
        | (Stack { slope } | Dog { slope, .. } | Map { slope, .. }, _) => slope,
        (Frame(_), _) => from.slope,
        (Merge, _) => to.slope,
    };
    let (u, v) = slope.displacement(after(to_kind) - after(from_kind));
    pos_image + vec2(u, v)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::detector::Slope;
    use egui::pos2;
    use proptest::prelude::*;

    const SLOPE: Slope = Slope { u: 2.0, v: -1.0 };

    proptest! {
        #[test]
        fn there_and_back_is_the_same_place(u in 0f32..500.0, v in 0f32..500.0, t in 0usize..12, s in -3f32..3.0) {
            let cursor = Cursor { slope: Slope::new(s, -s), ..Cursor::default() };
            let kinds = [
                PictureKind::Frame(t),
                PictureKind::Stack { slope: SLOPE },
                PictureKind::Merge,
                PictureKind::Dog { octave: 1, level: 0, slope: SLOPE },
            ];
            for a in kinds {
                for b in kinds {
                    let there = place_in(pos2(u, v), a, &cursor, b, &cursor, (&Positions::even(12), 0..12));
                    let back = place_in(there, b, &cursor, a, &cursor, (&Positions::even(12), 0..12));
                    prop_assert!((back - pos2(u, v)).length() < 1e-3, "{a:?} {b:?}");
                }
            }
        }
    }
}
