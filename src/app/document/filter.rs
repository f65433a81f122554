//! Filter and sort order of the features, and the selected one, by which it is found again.

use crate::app::view::{KnownOfFeature, number, quantity_value};
use crate::detector::quantity::Form;
use crate::detector::{Detection, Feature, Moves, Quantity, Slope, SlopeGrid};
use crate::inspect::place::{Judged, Verdict};
use crate::inspect::slopes::{self, is_at_slope};
use crate::inspect::words::counted;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Interval {
    pub min: f32,
    pub max: f32,
}

/// Conditions that a feature must satisfy to be shown; `None` lets all features pass.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct Filter {
    /// Ranges of quantities, in the unit of each; of a response its magnitude. Features without a value pass.
    #[serde(flatten)]
    pub ranges: BTreeMap<Quantity, Interval>,
    pub hide_slope_limit: bool,
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

/// Whether the motion of `feature` differs from `slope` by at most `limit`; at the distance of [`near_slope`], whether
/// it is at that slope of `grid`, so that there is one count of these.
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
    let is_at = slopes::at_slope(&detection.slopes, slope);
    [count(&is_at), count(&|f| is_at(f) && is_at(&own(f)))]
}

/// Quantities by whose ranges features can be filtered: all with decimals, but the depth, which is not the feature's.
pub fn ranged_quantities() -> impl Iterator<Item = Quantity> {
    let has_decimals = |quantity: &Quantity| {
        *quantity != Quantity::Depth && !matches!(quantity.record().form, Form::Whole | Form::Degrees | Form::Flag)
    };
    Quantity::ALL.into_iter().filter(has_decimals)
}

pub fn range_name(quantity: Quantity) -> &'static str {
    if quantity == Quantity::Response { "|Response|" } else { quantity.record().title }
}

/// Value that has to lie in the range of a quantity; `None` where there is none, or it is not known yet.
pub fn ranged(quantity: Quantity, feature: &Feature, known: KnownOfFeature<'_>) -> Option<f32> {
    let value = quantity_value(quantity, 0, feature, known);
    value.map(|value| if quantity == Quantity::Response { value.abs() } else { value })
}

impl Filter {
    pub fn is_open(&self) -> bool {
        *self == Self::default()
    }

    pub fn words(&self) -> Vec<String> {
        let range = |(quantity, interval): (&Quantity, &Interval)| {
            let [min, max] = [interval.min, interval.max].map(|end| number(end, 3));
            format!("{} {min} … {max}", range_name(*quantity))
        };
        let hidden = self.hidden_layers.len();
        let layers = (hidden > 0).then(|| format!("{} hidden", counted(hidden, "layer")));
        let words = [
            self.verdict.map(|verdict| verdict.word().to_owned()),
            self.moves.map(|moves| moves.words().to_owned()),
            self.near_slope.map(|_| "at this slope".to_owned()),
            self.solo_layer.map(|number| format!("layer {number} alone")).or(layers),
            self.hide_slope_limit.then(|| "not at the limit".to_owned()),
        ];
        words.into_iter().flatten().chain(self.ranges.iter().map(range)).collect()
    }

    pub fn needs_verdicts(&self) -> bool {
        self.ranges.contains_key(&Quantity::Coherence) || self.verdict.is_some()
    }

    /// Whether layer `number` is shown; 0 for what is in none.
    pub fn shows_layer(&self, number: i32) -> bool {
        self.solo_layer.map_or_else(|| !self.hidden_layers.contains(&number), |solo| number == solo)
    }

    /// When the slope on show, of `grid`, is `slope`; before `judged` is known, the feature passes.
    pub fn passes(&self, feature: &Feature, judged: Option<&Judged>, grid: &SlopeGrid, slope: Slope) -> bool {
        let known = KnownOfFeature { judged, depth_m: None };
        let is_within = |(quantity, Interval { min, max }): (&Quantity, &Interval)| {
            ranged(*quantity, feature, known).is_none_or(|value| (*min..=*max).contains(&value))
        };
        self.ranges.iter().all(is_within)
            && judged.is_none_or(|judged| self.verdict.is_none_or(|verdict| judged.verdict == verdict))
            && !(self.hide_slope_limit && feature.at_slope_limit)
            && self.shows_layer(feature.layer)
            && self.moves.is_none_or(|moves| feature.moves == moves)
            && self.near_slope.is_none_or(|limit| moves_by(grid, feature, slope, limit))
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

#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SavedSelection {
    pub index: usize,
    pub u: f32,
    pub v: f32,
    pub sigma: f32,
    pub slope: Slope,
}

impl SavedSelection {
    /// Feature of which only the index is known, as of a keypoint in COLMAP's model; its scale is 0.
    pub fn of_index(index: usize) -> Self {
        Self { index, u: 0.0, v: 0.0, sigma: 0.0, slope: Slope::default() }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SavedMatch {
    pub a: [f32; 2],
    pub b: [f32; 2],
}
