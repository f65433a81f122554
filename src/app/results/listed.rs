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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::document::filter::Interval;
    use crate::app::view::{Known, quantity_text};
    use crate::detector::Moves;

    fn feature(u: f32, sigma: f32, slope_u: f32) -> Feature {
        let (slope, response, at_slope_limit) = (Slope::new(slope_u, 0.0), -0.1 * sigma, slope_u.abs() >= 3.0);
        Feature { u, sigma, slope, response, at_slope_limit, ..Feature::default() }
    }

    #[test]
    fn filters_add_up_and_the_order_turns_round() {
        let features = [feature(5.0, 2.0, 1.0), feature(1.0, 4.0, -2.0), feature(3.0, 8.0, 3.0)];
        let (slope, alone, grid) = (Slope::new(1.0, 0.0), SetUpState::default(), SlopeGrid::line(-3.0..=3.0, 7));
        let mut filter = Filter::default();
        assert!(filter.is_open());
        let order = Order::default().clicked(Quantity::U);
        assert_eq!(listed(&features, None, &alone, &filter, &grid, slope, order), [1, 2, 0]);
        assert_eq!(listed(&features, None, &alone, &filter, &grid, slope, order.clicked(Quantity::U)), [0, 2, 1]);
        filter.sigma = Some(Interval { min: 3.0, max: 9.0 });
        assert_eq!(listed(&features, None, &alone, &filter, &grid, slope, Order::default()), [1, 2]);
        filter.hide_slope_limit = true;
        assert_eq!(listed(&features, None, &alone, &filter, &grid, slope, Order::default()), [1]);
        let near = Filter { near_slope: Some(0.5), ..Filter::default() };
        assert_eq!(listed(&features, None, &alone, &near, &grid, slope, Order::default()), [0]);
    }

    #[test]
    fn features_are_at_a_slope_by_their_motion_and_filtered_by_layer_and_by_how_they_move() {
        let placed =
            Feature { field: Slope::new(2.0, 0.0), field_sigma: 0.05, slope_sigma: 0.2, ..feature(5.0, 2.0, 2.2) };
        let placed = Feature { moves: Moves::WithSurroundings, ..placed };
        let by_itself = Feature { slope: Slope::new(-1.0, 0.0), layer: 0, moves: Moves::ByItself, ..placed };
        let edge = Feature { slope: Slope::new(0.0, 0.5), slope_sigma: 0.9, moves: Moves::Edge, ..placed };
        let unknown = Feature { field_sigma: f32::INFINITY, layer: 2, moves: Moves::Unknown, ..placed };
        let features = [Feature { layer: 1, ..placed }, by_itself, Feature { layer: 1, ..edge }, unknown];
        let passing = |filter: Filter| {
            let (grid, slope) = (SlopeGrid::line(-3.0..=3.0, 7), Slope::new(2.0, 0.0));
            listed(&features, None, &SetUpState::default(), &filter, &grid, slope, Order::default())
        };
        let open = Filter::default;
        let near = |limit| passing(Filter { near_slope: Some(limit), ..open() });
        assert_eq!(near(0.1), [0, 2], "an edge moves as its surroundings");
        let usual = near_slope(&SlopeGrid::line(-3.0..=3.0, 7));
        assert_eq!(near(usual), [0, 2, 3], "without a field by its own slope, which is nearest to 2");
        let hidden = |layers: &[i32], solo_layer| {
            passing(Filter { hidden_layers: layers.iter().copied().collect(), solo_layer, ..open() })
        };
        assert_eq!([1, 2, 0].map(|n| hidden(&[], Some(n))), [vec![0, 2], vec![3], vec![1]]);
        assert_eq!((hidden(&[1], None), hidden(&[0, 2], None)), (vec![1, 3], vec![0, 2]));
        assert_eq!(hidden(&[1, 2], Some(1)), [0, 2], "alone, whatever is switched off");
        let moving = Moves::ALL.map(|moves| passing(Filter { moves: Some(moves), ..open() }));
        assert_eq!(moving, [vec![3], vec![0], vec![1], vec![2], vec![]]);
        let filter = Filter { hidden_layers: [2].into(), solo_layer: Some(1), moves: Some(Moves::ByItself), ..open() };
        let text = toml::to_string(&filter).expect("text");
        assert!(text.contains("solo_layer = 1") && text.contains("hidden_layers = [2]"), "{text}");
        assert_eq!(toml::from_str::<Filter>(&text).expect("a filter"), filter);
    }

    #[test]
    fn features_belong_to_a_slope_half_way_to_the_next() {
        assert!((near_slope(&SlopeGrid::line(-2.0..=2.0, 5)) - 0.55).abs() < 1e-6);
        assert!((near_slope(&SlopeGrid::plane(-1.0..=1.0, 5, -2.0..=2.0, 3)) - 1.1).abs() < 1e-6);
        assert_eq!(near_slope(&SlopeGrid::line(0.0..=0.0, 1)), 0.1, "of a single slope those that are nearly there");
    }

    #[test]
    fn depths_sort_the_features_and_unknown_ones_come_last() {
        let features = [feature(5.0, 2.0, -2.5), feature(1.0, 4.0, 2.0), feature(3.0, 8.0, -20.0)];
        let order = Order::default().clicked(Quantity::Depth);
        let sorted = |set_up: &SetUpState| {
            listed(&features, None, set_up, &Filter::default(), &SlopeGrid::default(), Slope::default(), order)
        };
        let read = SetUpState { reads_depths: true, ..SetUpState::default() };
        assert_eq!(sorted(&read), [2, 0, 1]);
        assert_eq!(sorted(&SetUpState::default()), [0, 1, 2], "without a set-up no depth is known");
        assert_eq!(quantity_text(Quantity::Depth, 0, &features[0], read.known(&features[0], None)), "8");
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
