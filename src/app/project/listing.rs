//! Features that the table lists, and steps through them.

use crate::app::project::Model;
use crate::app::project::filter::{self, Column, Filter};
use crate::app::project::order::Order;
use crate::detector::Slope;
use std::sync::Arc;

/// Inputs from which the list was made.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ListedFor {
    detection: usize,
    filter: Filter,
    order: Order<Column>,
    slope: Slope,
}

impl Model {
    /// Updates [`Model::listed`]. Cheap when nothing changed.
    pub fn refresh_listed(&mut self) {
        let Some(found) = &self.slots.a.found else {
            self.listed.clear();
            self.listed_for = None;
            return;
        };
        // The slope on show matters only to the filter by slope.
        let slope = if self.filter.near_slope.is_some() { self.cursor().slope } else { Slope::default() };
        let now = ListedFor {
            detection: Arc::as_ptr(&found.detection) as usize,
            filter: self.filter,
            order: self.order,
            slope,
        };
        if self.listed_for.as_ref() != Some(&now) {
            self.listed = filter::listed(&found.detection.features, &self.filter, slope, self.order);
            self.listed_for = Some(now);
        }
    }

    /// For each feature whether it passes the filter.
    pub fn listed_flags(&self) -> Vec<bool> {
        let mut flags = vec![false; self.features().len()];
        for &i in &self.listed {
            if let Some(flag) = flags.get_mut(i) {
                *flag = true;
            }
        }
        flags
    }

    /// Selects the feature after (or before) the selected one in the table's order.
    pub fn select_neighbour(&mut self, forward: bool) {
        self.refresh_listed();
        self.selected = neighbour(&self.listed, self.selected, forward);
    }
}

/// The item of a list after (or before) the selected one: the first (or last) if none is selected; the selected one at
/// the end of the list.
pub(crate) fn neighbour(listed: &[usize], selected: Option<usize>, forward: bool) -> Option<usize> {
    let place = selected.and_then(|s| listed.iter().position(|&i| i == s));
    let last = listed.len().saturating_sub(1);
    let next = match (place, forward) {
        (None, true) => 0,
        (None, false) => last,
        (Some(p), true) => (p + 1).min(last),
        (Some(p), false) => p.saturating_sub(1),
    };
    listed.get(next).copied().or(selected)
}
