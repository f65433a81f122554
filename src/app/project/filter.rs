//! Filter and sort order of the features, and the list that results: what the table shows, and steps through it.

use crate::app::project::{Model, filter};
use crate::app::view::{Known, quantity_value};
use crate::detector::{Feature, Quantity, Slope};
use crate::inspect::set_up::SetUp;
use crate::inspect::verdict::{Judged, Verdict};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Interval {
    pub min: f32,
    pub max: f32,
}

impl Interval {
    fn holds(self, x: f32) -> bool {
        (self.min..=self.max).contains(&x)
    }
}

/// Conditions that a feature must satisfy to be shown; `None` lets all features pass.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct Filter {
    /// Slope u, pixels per frame.
    pub slope_u: Option<Interval>,
    /// Slope v, pixels per frame.
    pub slope_v: Option<Interval>,
    /// Scale σ, input pixels.
    pub sigma: Option<Interval>,
    /// |response|, fraction of full scale.
    pub response: Option<Interval>,
    /// Whether features at the limit of the slopes are hidden.
    pub hide_slope_limit: bool,
    /// Coherence of the frames' responses, 0 … 1. Features without one (too noisy to tell) pass.
    pub coherence: Option<Interval>,
    pub verdict: Option<Verdict>,
    /// Largest distance of a feature's slope from the slope on show, pixels per frame.
    pub near_slope: Option<f32>,
}

impl Filter {
    pub fn is_open(&self) -> bool {
        *self == Self::default()
    }

    pub fn needs_verdicts(&self) -> bool {
        self.coherence.is_some() || self.verdict.is_some()
    }

    /// Whether `feature` passes, when the slope on show is `slope`; `judged` is what is known of it. Before that is
    /// known, it passes.
    pub fn passes(&self, feature: &Feature, judged: Option<&Judged>, slope: Slope) -> bool {
        let inside = |limit: Option<Interval>, x: f32| limit.is_none_or(|i| i.holds(x));
        inside(self.slope_u, feature.slope.u)
            && inside(self.slope_v, feature.slope.v)
            && inside(self.sigma, feature.sigma)
            && inside(self.response, feature.response.abs())
            && judged.is_none_or(|judged| {
                judged.coherence.is_none_or(|coherence| inside(self.coherence, coherence))
                    && self.verdict.is_none_or(|verdict| judged.verdict == verdict)
            })
            && !(self.hide_slope_limit && feature.at_slope_limit)
            && self.near_slope.is_none_or(|limit| (feature.slope.u - slope.u).hypot(feature.slope.v - slope.v) <= limit)
    }
}

/// Indices of the features that pass the filter at `slope`, sorted by `order`; `judged` and `set_up` say more of them.
pub fn listed(
    features: &[Feature],
    (judged, set_up): (Option<&[Judged]>, Option<&SetUp>),
    filter: &Filter,
    slope: Slope,
    order: Order<Quantity>,
) -> Vec<usize> {
    let of = |index: usize| judged.and_then(|judged| judged.get(index));
    let mut indices: Vec<usize> = (0..features.len()).filter(|&i| filter.passes(&features[i], of(i), slope)).collect();
    indices.sort_by(|&a, &b| {
        let depth = |index: usize| set_up.and_then(|set_up| set_up.depth_at(features[index].slope));
        let known = |index: usize| Known { judged: of(index), depth_m: depth(index) };
        // What is not known is greatest.
        let value =
            |index| quantity_value(order.column, index, &features[index], known(index)).unwrap_or(f32::INFINITY);
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
    /// Updates [`Model::listed`]. Cheap when nothing changed.
    pub fn refresh_listed(&mut self) {
        let Some(found) = &self.slots.a.found else {
            self.listed.clear();
            self.listed_for = None;
            return;
        };
        // The slope on show matters only to the filter by slope.
        let slope = if self.filter.near_slope.is_some() { self.cursor().slope } else { Slope::default() };
        let judged = self.coherence.of(&found.detection);
        let now = ListedFor {
            detection: Arc::as_ptr(&found.detection) as usize,
            judged: judged.map_or(0, |judged| Arc::as_ptr(judged) as usize),
            filter: self.filter,
            order: self.order,
            slope,
            set_up: self.set_up.depths_by().copied(),
        };
        if self.listed_for.as_ref() != Some(&now) {
            self.listed = filter::listed(
                &found.detection.features,
                (judged.map(|judged| &judged[..]), self.set_up.depths_by()),
                &self.filter,
                slope,
                self.order,
            );
            self.listed_for = Some(now);
        }
    }

    pub fn listed_flags(&self) -> Vec<bool> {
        let mut flags = vec![false; self.features().len()];
        for &i in &self.listed {
            if let Some(flag) = flags.get_mut(i) {
                *flag = true;
            }
        }
        flags
    }

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

/// Sort order: a column of type `C` and a direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(default, bound(deserialize = "C: Default + Deserialize<'de>"))]
pub struct Order<C> {
    pub column: C,
    /// Whether the largest value comes first.
    pub descending: bool,
}

impl<C: PartialEq> Order<C> {
    /// Order after a click on the heading of `column`: ascending by it, or reversed if the table is sorted by it
    /// already.
    #[must_use]
    pub fn clicked(self, column: C) -> Self {
        Self { descending: self.column == column && !self.descending, column }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::view::quantity_text;

    fn feature(u: f32, sigma: f32, slope_u: f32) -> Feature {
        let (slope, response, at_slope_limit) = (Slope::new(slope_u, 0.0), -0.1 * sigma, slope_u.abs() >= 3.0);
        Feature { u, sigma, slope, response, at_slope_limit, ..Feature::default() }
    }

    #[test]
    fn filters_add_up_and_the_order_turns_round() {
        let features = [feature(5.0, 2.0, 1.0), feature(1.0, 4.0, -2.0), feature(3.0, 8.0, 3.0)];
        let slope = Slope::new(1.0, 0.0);
        let mut filter = Filter::default();
        assert!(filter.is_open());
        let order = Order::default().clicked(Quantity::U);
        assert_eq!(listed(&features, (None, None), &filter, slope, order), [1, 2, 0]);
        assert_eq!(listed(&features, (None, None), &filter, slope, order.clicked(Quantity::U)), [0, 2, 1]);
        filter.sigma = Some(Interval { min: 3.0, max: 9.0 });
        assert_eq!(listed(&features, (None, None), &filter, slope, Order::default()), [1, 2]);
        filter.hide_slope_limit = true;
        assert_eq!(listed(&features, (None, None), &filter, slope, Order::default()), [1]);
        let near = Filter { near_slope: Some(0.5), ..Filter::default() };
        assert_eq!(listed(&features, (None, None), &near, slope, Order::default()), [0]);
    }

    #[test]
    fn depths_sort_the_features_and_unknown_ones_come_last() {
        let features = [feature(5.0, 2.0, -2.5), feature(1.0, 4.0, 2.0), feature(3.0, 8.0, -20.0)];
        let order = Order::default().clicked(Quantity::Depth);
        let default = SetUp::default();
        let sorted = |set_up| listed(&features, (None, set_up), &Filter::default(), Slope::default(), order);
        assert_eq!(sorted(Some(&default)), [2, 0, 1]);
        assert_eq!(sorted(None), [0, 1, 2], "without a set-up no depth is known");
        let known = Known { depth_m: SetUp::default().depth_at(features[0].slope), ..Known::default() };
        assert_eq!(quantity_text(Quantity::Depth, 0, &features[0], known), "8");
    }

    #[test]
    fn a_response_of_a_dark_burst_is_not_nought() {
        let dark = Feature { response: -0.000_021_7, ..feature(5.0, 2.0, 3.0) };
        assert_eq!(quantity_text(Quantity::Response, 0, &dark, Known::default()), "−2.17e−5");
    }

    #[test]
    fn every_quantity_has_a_record_and_a_text() {
        let feature = feature(5.0, 2.0, 3.0);
        for quantity in Quantity::ALL {
            let record = quantity.record();
            assert!(!record.heading.is_empty() && !record.help.is_empty());
            assert_eq!(
                serde_json::to_string(&quantity).ok(),
                Some(format!("\"{}\"", record.key)),
                "as sessions name it"
            );
            assert!(!quantity_text(quantity, 0, &feature, Known::default()).is_empty(), "{quantity:?}");
            assert!(record.term.is_none_or(|term| crate::teach::glossary::glossary().find(term).is_some()));
        }
    }
}
