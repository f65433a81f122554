//! Filter and sort order of the features, and the list that results: what the table shows, and steps through it.

use crate::app::project::set_up::SetUpState;
use crate::app::project::{Model, filter};
use crate::app::view::{number, quantity_value};
use crate::detector::{Detection, Feature, Moves, Quantity, Slope, SlopeGrid};
use crate::inspect::set_up::SetUp;
use crate::inspect::spectrum::is_at_slope;
use crate::inspect::verdict::{Judged, Verdict};
use crate::inspect::words::counted;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
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
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
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
    pub hide_slope_limit: bool,
    /// Coherence of the frames' responses, 0 … 1. Features without one (too noisy to tell) pass.
    pub coherence: Option<Interval>,
    pub verdict: Option<Verdict>,
    /// Motion layers that are switched off, by number from 1; 0 for what is in none.
    pub hidden_layers: BTreeSet<i32>,
    /// Motion layer that is shown alone, whatever is switched off.
    pub solo_layer: Option<i32>,
    pub moves: Option<Moves>,
    /// Largest distance of a feature's motion from the slope on show, pixels per frame.
    pub near_slope: Option<f32>,
}

/// Largest distance of the motions that belong to a slope of `grid`, pixels per frame: slightly more than half-way to
/// the grid's next slope.
pub fn near_slope(grid: &SlopeGrid) -> f32 {
    (0.55 * grid.u.step().max(grid.v.step())).max(0.1)
}

/// Whether the motion of `feature` differs from `slope` by at most `limit`; at the distance of [`near_slope`], whether it
/// is at that slope of `grid`, so that there is one count of these.
pub fn moves_by(grid: &SlopeGrid, feature: &Feature, slope: Slope, limit: f32) -> bool {
    if limit == near_slope(grid) {
        return is_at_slope(grid, feature, slope);
    }
    let (motion, _) = feature.motion();
    (motion.u - slope.u).hypot(motion.v - slope.v) <= limit
}

/// Numbers of features at `slope` by the motion that they share with their surroundings or have alone, which is what is
/// counted, drawn and filtered; and of those that are there by their own slope too.
pub fn at_slope(detection: &Detection, slope: Slope) -> [usize; 2] {
    let own = |feature: &Feature| Feature { slope: feature.slope, ..Feature::default() };
    let count = |is_at: &dyn Fn(&Feature) -> bool| detection.features.iter().filter(|feature| is_at(feature)).count();
    let grid = &detection.slopes;
    let is_at = |f: &Feature| is_at_slope(grid, f, slope);
    [count(&is_at), count(&|f| is_at(f) && is_at_slope(grid, &own(f), slope))]
}

impl Filter {
    pub fn is_open(&self) -> bool {
        *self == Self::default()
    }

    /// Its conditions, each in a few words.
    pub fn words(&self) -> Vec<String> {
        let range = |name: &str, interval: Option<Interval>| {
            interval.map(|Interval { min, max }| format!("{name} {} … {}", number(min, 3), number(max, 3)))
        };
        let hidden = self.hidden_layers.len();
        let layers = (hidden > 0).then(|| format!("{} hidden", counted(hidden, "layer")));
        let words = [
            self.verdict.map(|verdict| verdict.word().to_owned()),
            self.moves.map(|moves| moves.words().to_owned()),
            self.near_slope.map(|_| "at this slope".to_owned()),
            self.solo_layer.map(|number| format!("layer {number} alone")).or(layers),
            range("slope u", self.slope_u),
            range("slope v", self.slope_v),
            range("σ", self.sigma),
            range("|response|", self.response),
            range("coherence", self.coherence),
            self.hide_slope_limit.then(|| "not at the limit".to_owned()),
        ];
        words.into_iter().flatten().collect()
    }

    pub fn needs_verdicts(&self) -> bool {
        self.coherence.is_some() || self.verdict.is_some()
    }

    /// Whether layer `number` is shown; 0 for what is in none.
    pub fn shows_layer(&self, number: i32) -> bool {
        self.solo_layer.map_or_else(|| !self.hidden_layers.contains(&number), |solo| number == solo)
    }

    /// When the slope on show, of `grid`, is `slope`; before `judged` is known, the feature passes.
    pub fn passes(&self, feature: &Feature, judged: Option<&Judged>, grid: &SlopeGrid, slope: Slope) -> bool {
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
            && self.shows_layer(feature.layer)
            && self.moves.is_none_or(|moves| feature.moves == moves)
            && self.near_slope.is_none_or(|limit| moves_by(grid, feature, slope, limit))
    }
}

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
    /// Updates [`Results::listed`](crate::app::project::Results::listed). Cheap when nothing changed.
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
            self.results.listed = filter::listed(
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

/// The first (or last) if none is selected; the selected one at the end of the list.
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

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(default, bound(deserialize = "C: Default + Deserialize<'de>"))]
pub struct Order<C> {
    pub column: C,
    pub descending: bool,
}

impl<C: PartialEq> Order<C> {
    /// Ascending by it, or reversed if the table is sorted by it already.
    #[must_use]
    pub fn clicked(self, column: C) -> Self {
        Self { descending: self.column == column && !self.descending, column }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::view::{Known, quantity_text};

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
