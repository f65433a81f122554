//! What a session holds of the second burst and the matches.

use super::sources::{absolute, gold_source};
use crate::app::canvas::View;
use crate::app::pane::PaneId;
use crate::app::project::Model;
use crate::app::project::cursor::Cursor;
use crate::app::project::look::Look;
use crate::app::project::order::Order;
use crate::app::project::pair::{Links, MatchColumn, MatchLook, SavedMatch, Side};
use crate::app::project::workspace::Workspace;
use crate::matching::MatchParams;
use crate::requests::BurstSource;
use serde::{Deserialize, Serialize};

/// What a session file holds of the second burst and the matches.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PairSession {
    /// Where the second burst comes from, if one was open.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub burst: Option<BurstSource>,
    /// Where its gold standard comes from.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gold: Option<BurstSource>,
    /// Whose cursor moved.
    pub active: Side,
    /// What moved together.
    pub links: Links,
    /// The parameters of matching.
    pub params: MatchParams,
    /// Where B's cursor was.
    pub scrub: Cursor,
    /// B's pan and zoom.
    pub view: View,
    /// B's ranges and maps, where they were its own.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub look: Option<Look>,
    /// How matches looked.
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

    /// Puts what it holds into the model, whose second burst (if there was one) was just opened.
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
        model.check_pair();
    }
}
