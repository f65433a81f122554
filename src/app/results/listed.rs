//! Filter and sort order of the features, and the list that results: what the table shows, and steps through it.

use crate::app::document::filter::{Filter, Order, near_slope, neighbour};
use crate::app::document::probe::SetUpState;
use crate::app::results::Model;
use crate::app::view::quantity_value;
use crate::detector::{Feature, Quantity, Slope, SlopeGrid};
use crate::inspect::set_up::SetUp;
use crate::inspect::verdict::Judged;
use std::sync::Arc;

/// Indices of the features that pass the filter at `slope`, sorted by `order`; `judged` and `set_up` say more of them.
pub fn listed(
    features: &[Feature],
    judged: Option<&[Judged]>,
    set_up: &SetUpState,
    filter: &Filter,
    grid: &SlopeGrid,
    slope: Slope,
    order: Order<Quantity>,
) -> Vec<usize> {
    let of = |index: usize| judged.and_then(|judged| judged.get(index));
    let mut indices: Vec<usize> =
        (0..features.len()).filter(|&i| filter.passes(&features[i], of(i), grid, slope)).collect();
    indices.sort_by(|&a, &b| {
        let value = |index: usize| {
            let known = set_up.known(&features[index], of(index));
            // What is not known is greatest.
            quantity_value(order.column, index, &features[index], known).unwrap_or(f32::INFINITY)
        };
        let by = value(a).total_cmp(&value(b));
        let by = if order.descending { by.reverse() } else { by };
        by.then(a.cmp(&b))
    });
    indices
}

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ListedFor {
    detection: usize,
    judged: usize,
    filter: Filter,
    order: Order<Quantity>,
    slope: Slope,
    set_up: Option<SetUp>,
}

impl Model {
    /// Updates [`Results::listed`](crate::app::results::Results::listed). Cheap when nothing changed.
    pub fn refresh_listed(&mut self) {
        let Some(found) = &self.results.slots.a.found else {
            self.results.listed.clear();
            self.results.listed_for = None;
            return;
        };
        // The slope on show matters only to the filter by slope.
        let slope =
            if self.document.filter.near_slope.is_some() { self.document.cursor().slope } else { Slope::default() };
        let judged = self.results.coherence.of(&found.detection);
        let now = ListedFor {
            detection: Arc::as_ptr(&found.detection) as usize,
            judged: judged.map_or(0, |judged| Arc::as_ptr(judged) as usize),
            filter: self.document.filter.clone(),
            order: self.document.order,
            slope,
            set_up: self.document.set_up.depths_by().copied(),
        };
        if self.results.listed_for.as_ref() != Some(&now) {
            self.results.listed = listed(
                &found.detection.features,
                judged.map(|judged| &judged[..]),
                &self.document.set_up,
                &self.document.filter,
                &found.detection.slopes,
                slope,
                self.document.order,
            );
            self.results.listed_for = Some(now);
        }
    }

    /// Default of [`Filter::near_slope`]: as for the features over the picture.
    pub fn near_slope(&self) -> f32 {
        near_slope(
            self.results
                .slots
                .a
                .found
                .as_ref()
                .map_or(&self.results.slots.a.usable_params.slopes, |f| &f.detection.slopes),
        )
    }

    pub fn listed_flags(&self) -> Vec<bool> {
        let mut flags = vec![false; self.read().features().len()];
        for &i in &self.results.listed {
            if let Some(flag) = flags.get_mut(i) {
                *flag = true;
            }
        }
        flags
    }

    pub fn select_neighbour(&mut self, forward: bool) {
        self.refresh_listed();
        self.document.selected = neighbour(&self.results.listed, self.document.selected, forward);
    }
}
