//! The second burst and the matches in a session.

use super::sources::{absolute, gold_source, saved_against};
use crate::app::canvas::View;
use crate::app::pane::PaneId;
use crate::app::project::Model;
use crate::app::project::against::SavedAgainst;
use crate::app::project::cursor::Cursor;
use crate::app::project::filter::Order;
use crate::app::project::look::Look;
use crate::app::project::pair::{Links, MatchColumn, MatchLook, SavedMatch, Side};
use crate::app::project::probe::SavedProbe;
use crate::app::project::workspace::Workspace;
use crate::matching::MatchParams;
use crate::requests::BurstSource;
use serde::{Deserialize, Serialize};

/// The second burst and the matches as a session file stores them.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PairSession {
    /// Source of the second burst, if one was open.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub burst: Option<BurstSource>,
    /// Source of its gold standard.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gold: Option<BurstSource>,
    /// The place of the second burst that is probed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub probe: Option<SavedProbe>,
    /// Features with which those of the second burst were compared.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub against: Option<SavedAgainst>,
    /// Side of the pane in focus.
    pub active: Side,
    /// Links between the two bursts' panes.
    pub links: Links,
    /// The parameters of matching.
    pub params: MatchParams,
    /// B's cursor.
    pub scrub: Cursor,
    /// B's pan and zoom.
    pub view: View,
    /// B's ranges and maps, where they were its own.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub look: Option<Look>,
    /// Display of matches.
    pub match_look: MatchLook,
    /// The table's order.
    pub order: Order<MatchColumn>,
    /// The selected match.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub selection: Option<SavedMatch>,
}

impl PairSession {
    pub(super) fn of(model: &Model) -> Self {
        let (pair, pane) = (&model.pair, model.panes.of(Side::B));
        Self {
            burst: model.slots.b.burst.as_ref().map(|open| absolute(&open.source)),
            gold: gold_source(model, Side::B),
            probe: model.probe.saved(Side::B),
            against: saved_against(model, Side::B),
            active: model.panes.get(model.panes.placed_in(Workspace::Pair).1).map_or(Side::A, |pane| pane.side),
            links: model.pair_links(),
            params: pair.params.clone(),
            scrub: pane.cursor,
            view: pane.view,
            look: pane.own_ranges.map(|ranges| Look { ranges, ..Look::default() }),
            match_look: pair.look,
            order: pair.order,
            selection: pair.saved_match(),
        }
    }

    /// Restores it in `model`, whose second burst (if there was one) was just opened.
    pub fn apply(&self, model: &mut Model) {
        let pair = &mut model.pair;
        pair.params = self.params.clone();
        (pair.look, pair.order, pair.reselect) = (self.match_look.sanitised(), self.order, self.selection);
        model.set_pair_links(self.links);
        model.panes.set_focus_in(Workspace::Pair, PaneId::of(self.active));
        let pane = model.panes.of_mut(Side::B);
        (pane.cursor, pane.slope_chosen, pane.view) = (self.scrub, true, self.view);
        if let (Some(own), Some(look)) = (&mut pane.own_ranges, &self.look) {
            *own = look.ranges;
        }
        model.restore_probe(Side::B, self.probe);
        model.restore_against(Side::B, self.against.clone());
        model.check_pair();
    }
}
