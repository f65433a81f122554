//! Panes of a workspace as a session stores them: without pictures, which are made again.

use super::set::PLACES;
use super::{Arrangement, Content, Over, Pane, PaneId, PaneLinks, Panes};
use crate::app::project::cursor::Cursor;
use crate::app::project::look::Ranges;
use crate::app::project::method::Contender;
use crate::app::project::side::Side;
use crate::app::project::workspace::Workspace;
use crate::app::view::View;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SavedPanes {
    pub focus: PaneId,
    pub arrangement: Arrangement,
    pub panes: Vec<SavedPane>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SavedPane {
    pub id: PaneId,
    #[serde(default)]
    pub side: Side,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub method: Option<Contender>,
    #[serde(default)]
    pub content: Content,
    #[serde(default)]
    pub cursor: Cursor,
    /// Pan and zoom.
    #[serde(default)]
    pub view: View,
    #[serde(default)]
    pub links: PaneLinks,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub own_ranges: Option<Ranges>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub over: Option<Over>,
}

#[derive(Debug, Clone, PartialEq, Default)]
pub struct SavedWorkspaces {
    /// Panes of *Inspect*, *Two bursts* and *Methods*; `None` leaves a workspace unchanged.
    pub placed: [Option<SavedPanes>; PLACES.len()],
}

impl SavedWorkspaces {
    pub fn of(panes: &Panes) -> Self {
        Self { placed: PLACES.map(|workspace| Some(SavedPanes::of(panes, workspace))) }
    }

    pub fn apply(&self, panes: &mut Panes) {
        for (saved, workspace) in self.placed.iter().zip(PLACES) {
            saved.iter().for_each(|saved| saved.apply(panes, workspace));
        }
    }
}

impl SavedPanes {
    pub fn of(panes: &Panes, workspace: Workspace) -> Self {
        let saved = |id: PaneId| {
            let Pane { side, method, content, cursor, view, links, own_ranges, over, .. } = panes.get(id)?.clone();
            Some(SavedPane { id, side, method, content, cursor, view, links, own_ranges, over })
        };
        let (arrangement, focus) = panes.placed_in(workspace);
        let all = arrangement.panes().into_iter().filter_map(saved).collect();
        Self { focus, arrangement: arrangement.clone(), panes: all }
    }

    /// Restores them in `panes` as those of `workspace`, in place of the present ones. Invalid parts are left out.
    pub fn apply(&self, panes: &mut Panes, workspace: Workspace) {
        let pane = |saved: &SavedPane| {
            let SavedPane { id, side, method, content, cursor, view, links, own_ranges, over } = saved.clone();
            let over = over.map(|over| match over {
                Over::Wipe { other, at } => {
                    Over::Wipe { other, at: if at.is_finite() { at.clamp(0.0, 1.0) } else { 0.5 } }
                }
                flip @ Over::Flip { .. } => flip,
            });
            // A pane that shares its display has no own ranges; any other pane has.
            let own_ranges = if links.display { None } else { Some(own_ranges.unwrap_or_default().sanitised()) };
            let pane =
                Pane { method, content, cursor, view, links, own_ranges, over, slope_chosen: true, ..Pane::new(side) };
            (id, pane)
        };
        let all: BTreeMap<PaneId, Pane> = self.panes.iter().map(pane).collect();
        panes.restore(workspace, self.arrangement.clone(), all, self.focus);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::pane::{Direction, Link, Preset};
    use crate::detector::DetectorParams;

    #[test]
    fn panes_come_back_as_they_were() {
        let mut panes = Panes::default();
        panes.lay_out(Preset::FiveSlopes, &DetectorParams::default());
        panes.split_with(Direction::Down, |pane| {
            (pane.content, pane.side) = (Content::Merge, Side::B);
            pane.links.set(Link::Display, false);
            pane.own_ranges = Some(Ranges::default());
        });
        panes.split_with(Direction::Down, |pane| pane.show_slice(crate::app::pane::SliceAxis::Across));
        panes.focus_next(true);
        panes.next_over();
        let saved = SavedPanes::of(&panes, Workspace::Inspect);
        let text = toml::to_string(&saved).unwrap();
        let read: SavedPanes = toml::from_str(&text).unwrap();
        assert_eq!(read, saved, "{text}");
        let mut workspaces = Panes::default();
        workspaces.turn_to(Workspace::Methods);
        let methods = [Contender::Sift, Contender::Buff1d];
        workspaces.lay_out_methods(crate::app::pane::MethodsPreset::Matches, &methods, true);
        workspaces.turn_to(Workspace::Pair);
        workspaces.split(PaneId(1), Direction::Down);
        let all = SavedWorkspaces::of(&workspaces);
        let mut again = Panes::default();
        all.apply(&mut again);
        assert_eq!(SavedWorkspaces::of(&again), all);
        let mut other = Panes::default();
        read.apply(&mut other, Workspace::Inspect);
        assert_eq!(SavedPanes::of(&other, Workspace::Inspect), saved);
        // New panes get unused ids.
        let new = other.split(other.focus(), Direction::Right).expect("there is room");
        assert!(saved.panes.iter().all(|pane| pane.id != new));
    }

    #[test]
    fn what_makes_no_sense_is_left_out() {
        let id = PaneId(7);
        let text = "focus = 99\n[arrangement]\nrow = [{ share = -3.0, inner = { pane = 7 } }, { share = 1.0, inner = { pane = 8 } }]\n\
                    [[panes]]\nid = 7\ncontent = { difference = [7, 8] }\nover = { wipe = { other = 8, at = nan } }\n";
        let saved: SavedPanes = toml::from_str(text).unwrap();
        let mut panes = Panes::default();
        saved.apply(&mut panes, Workspace::Inspect);
        assert_eq!((panes.shown(), panes.focus()), (vec![id], id));
        let pane = panes.get(id).expect("it is there");
        assert_eq!((pane.content, pane.over), (Content::Cursor, None));
    }
}
