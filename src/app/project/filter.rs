//! Filter and sort order of the features, and the list that results: what the table shows, and steps through it.

use crate::app::project::{Model, filter};
use crate::app::view::{fixed, number, signed, signed_number};
use crate::detector::{Feature, Slope};
use crate::inspect::set_up::SetUp;
use crate::inspect::verdict::{Judged, Verdict};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// A closed interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Interval {
    /// Smallest value in the interval.
    pub min: f32,
    /// Largest value in the interval.
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
    /// Verdict on the feature.
    pub verdict: Option<Verdict>,
    /// Largest distance of a feature's slope from the slope on show, pixels per frame.
    pub near_slope: Option<f32>,
}

impl Filter {
    /// Whether the filter has no condition.
    pub fn is_open(&self) -> bool {
        *self == Self::default()
    }

    /// Whether it depends on what is judged of the features.
    pub fn needs_verdicts(&self) -> bool {
        self.coherence.is_some() || self.verdict.is_some()
    }

    /// Whether `feature` passes, when the slope on show is `slope`; `judged` is what is known of it. Before that is
    /// known, it passes.
    pub fn passes(&self, feature: &Feature, judged: Option<&Judged>, slope: crate::detector::Slope) -> bool {
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

/// What is known of a feature beside itself.
#[derive(Debug, Clone, Copy, Default)]
pub struct Known<'a> {
    /// Coherence and verdict, once they were computed.
    pub judged: Option<&'a Judged>,
    /// Depth that its slope means, metres; `None` without a set-up, and where no depth explains the slope.
    pub depth_m: Option<f64>,
}

/// Columns of the table: those of the CSV, the verdict, and the depth; the most important come first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Column {
    /// Rank by strength, from 1.
    #[default]
    Rank,
    /// Column u.
    U,
    /// Row v.
    V,
    /// Scale σ.
    Sigma,
    /// Orientation.
    Orientation,
    /// Slope u.
    SlopeU,
    /// Slope v.
    SlopeV,
    /// Response.
    Response,
    /// Signal-to-noise ratio.
    Snr,
    /// Octave.
    Octave,
    /// Level.
    Level,
    /// Whether it is at the limit of the slopes.
    AtSlopeLimit,
    /// How alike the frames respond.
    Coherence,
    /// Likely nature.
    Verdict,
    /// Depth that the slope means.
    Depth,
}

impl Column {
    /// All columns, from left to right.
    pub const ALL: [Self; 15] = [
        Self::Rank,
        Self::U,
        Self::V,
        Self::Sigma,
        Self::SlopeU,
        Self::SlopeV,
        Self::Depth,
        Self::Snr,
        Self::Coherence,
        Self::Verdict,
        Self::Response,
        Self::Orientation,
        Self::Octave,
        Self::Level,
        Self::AtSlopeLimit,
    ];

    /// Heading in the table.
    pub fn heading(self) -> &'static str {
        match self {
            Self::Rank => "#",
            Self::U => "u",
            Self::V => "v",
            Self::Sigma => "σ",
            Self::Orientation => "Orient.",
            Self::SlopeU => "Slope u",
            Self::SlopeV => "Slope v",
            Self::Response => "Response",
            Self::Snr => "SNR",
            Self::Octave => "Oct.",
            Self::Level => "Level",
            Self::AtSlopeLimit => "Limit",
            Self::Coherence => "Coher.",
            Self::Verdict => "Verdict",
            Self::Depth => "Depth",
        }
    }

    /// The columns, from left to right; depths only where slopes are read as depths.
    pub fn shown(with_depths: bool) -> impl Iterator<Item = Self> {
        Self::ALL.into_iter().filter(move |column| with_depths || *column != Self::Depth)
    }

    /// Description of the column's values, with their unit.
    pub fn help(self) -> &'static str {
        match self {
            Self::Rank => "Rank by strength of the response, from 1",
            Self::U => "Column at mid-burst, in pixels; the centre of the first pixel is 0",
            Self::V => "Row at mid-burst, in pixels; the centre of the first pixel is 0",
            Self::Sigma => "Scale σ, in input pixels",
            Self::Orientation => "Orientation, in degrees from +u towards +v",
            Self::SlopeU => "Apparent motion to the right, in pixels per frame",
            Self::SlopeV => "Apparent motion downwards, in pixels per frame",
            Self::Response => "Interpolated DoG value, as a fraction of full scale; bright blobs are negative",
            Self::Snr => "|response| over the standard deviation of the noise in D",
            Self::Coherence => {
                "How alike the frames respond along its motion, 0 to 1; about the share of frames that respond"
            }
            Self::Verdict => {
                "Likely real, a ghost of another motion, an alias of a periodic texture, a duplicate, or unclear"
            }
            Self::Depth => "Depth that the slope means by the set-up, in metres; – where none explains it",
            Self::Octave => "Octave in which it was found; −1 is the doubled image",
            Self::Level => "Level within the octave",
            Self::AtSlopeLimit => {
                "Marked if the response still rises beyond the searched slopes: the motion lies outside"
            }
        }
    }

    /// The value by which the column sorts. What is not known is greatest.
    pub fn value(self, index: usize, feature: &Feature, known: Known<'_>) -> f32 {
        match self {
            Self::Rank => index as f32,
            Self::U => feature.u,
            Self::V => feature.v,
            Self::Sigma => feature.sigma,
            Self::Orientation => feature.orientation,
            Self::SlopeU => feature.slope.u,
            Self::SlopeV => feature.slope.v,
            Self::Response => feature.response,
            Self::Snr => feature.snr,
            Self::Octave => feature.octave as f32,
            Self::Level => feature.level as f32,
            Self::AtSlopeLimit => f32::from(u8::from(feature.at_slope_limit)),
            Self::Depth => known.depth_m.map_or(f32::INFINITY, |metres| metres as f32),
            Self::Coherence => known.judged.and_then(|judged| judged.coherence).unwrap_or(f32::INFINITY),
            Self::Verdict => known.judged.map_or(f32::INFINITY, |judged| judged.verdict as u8 as f32),
        }
    }

    /// The value as the table shows it.
    pub fn text(self, index: usize, feature: &Feature, known: Known<'_>) -> String {
        match self {
            Self::Rank => (index + 1).to_string(),
            Self::U => fixed(feature.u, 2),
            Self::V => fixed(feature.v, 2),
            Self::Sigma => format!("{:.2}", feature.sigma),
            Self::Orientation => format!("{}°", fixed(feature.orientation.to_degrees(), 0)),
            Self::SlopeU => signed(feature.slope.u, 2),
            Self::SlopeV => signed(feature.slope.v, 2),
            Self::Response => signed_number(feature.response, 3),
            Self::Snr => format!("{:.1}", feature.snr),
            Self::Octave => feature.octave.to_string(),
            Self::Level => feature.level.to_string(),
            Self::AtSlopeLimit => if feature.at_slope_limit { "yes" } else { "" }.to_owned(),
            Self::Depth => depth_text(known.depth_m),
            Self::Coherence => match known.judged {
                Some(judged) => judged.coherence.map_or_else(|| "?".to_owned(), |c| format!("{c:.2}")),
                None => "…".to_owned(),
            },
            Self::Verdict => known.judged.map_or("…", |judged| judged.verdict.word()).to_owned(),
        }
    }
}

/// A depth in metres for people; – where no depth is known.
pub fn depth_text(depth_m: Option<f64>) -> String {
    depth_m.map_or_else(|| "–".to_owned(), |metres| number(metres as f32, 3))
}

/// Indices of the features that pass the filter at `slope`, sorted by `order`; `judged` and `set_up` say more of them.
pub fn listed(
    features: &[Feature],
    (judged, set_up): (Option<&[Judged]>, Option<&SetUp>),
    filter: &Filter,
    slope: crate::detector::Slope,
    order: Order<Column>,
) -> Vec<usize> {
    let of = |index: usize| judged.and_then(|judged| judged.get(index));
    let mut indices: Vec<usize> = (0..features.len()).filter(|&i| filter.passes(&features[i], of(i), slope)).collect();
    indices.sort_by(|&a, &b| {
        let depth = |index: usize| set_up.and_then(|set_up| set_up.depth_at(features[index].slope));
        let known = |index: usize| Known { judged: of(index), depth_m: depth(index) };
        let value = |index: usize| order.column.value(index, &features[index], known(index));
        let by = value(a).total_cmp(&value(b));
        let by = if order.descending { by.reverse() } else { by };
        by.then(a.cmp(&b))
    });
    indices
}

/// Inputs from which the list was made.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ListedFor {
    detection: usize,
    judged: usize,
    filter: Filter,
    order: Order<Column>,
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

/// Sort order: a column of type `C` and a direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(default, bound(deserialize = "C: Default + Deserialize<'de>"))]
pub struct Order<C> {
    /// The column.
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
    use crate::detector::Slope;

    fn feature(u: f32, sigma: f32, slope_u: f32) -> Feature {
        Feature {
            u,
            v: 0.0,
            sigma,
            orientation: 0.0,
            slope: Slope::new(slope_u, 0.0),
            response: -0.1 * sigma,
            snr: 9.0,
            octave: 0,
            level: 1,
            slope_index: 0,
            at_slope_limit: slope_u.abs() >= 3.0,
        }
    }

    #[test]
    fn filters_add_up_and_the_order_turns_round() {
        let features = [feature(5.0, 2.0, 1.0), feature(1.0, 4.0, -2.0), feature(3.0, 8.0, 3.0)];
        let slope = Slope::new(1.0, 0.0);
        let mut filter = Filter::default();
        assert!(filter.is_open());
        let order = Order::default().clicked(Column::U);
        assert_eq!(listed(&features, (None, None), &filter, slope, order), [1, 2, 0]);
        assert_eq!(listed(&features, (None, None), &filter, slope, order.clicked(Column::U)), [0, 2, 1]);
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
        let order = Order::default().clicked(Column::Depth);
        let default = SetUp::default();
        let sorted = |set_up| listed(&features, (None, set_up), &Filter::default(), Slope::default(), order);
        assert_eq!(sorted(Some(&default)), [2, 0, 1]);
        assert_eq!(sorted(None), [0, 1, 2], "without a set-up no depth is known");
        let known = Known { depth_m: SetUp::default().depth_at(features[0].slope), ..Known::default() };
        assert_eq!(Column::Depth.text(0, &features[0], known), "8");
        assert!(Column::shown(true).eq(Column::ALL) && Column::shown(false).all(|column| column != Column::Depth));
    }

    #[test]
    fn a_response_of_a_dark_burst_is_not_nought() {
        let dark = Feature { response: -0.000_021_7, ..feature(5.0, 2.0, 3.0) };
        assert_eq!(Column::Response.text(0, &dark, Known::default()), "−2.17e−5");
    }

    #[test]
    fn every_column_has_a_heading_a_help_and_a_text() {
        let feature = feature(5.0, 2.0, 3.0);
        for column in Column::ALL {
            assert!(!column.heading().is_empty() && !column.help().is_empty());
            assert!(!column.text(0, &feature, Known::default()).is_empty(), "{column:?}");
        }
    }
}
