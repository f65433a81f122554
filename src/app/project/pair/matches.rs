//! Matches of two bursts with what they were made from, the columns of their table, and their display settings.

use crate::app::project::filter::Order;
use crate::app::project::pair::Side;
use crate::app::view::number;
use crate::app::view::{fixed, signed};
use crate::detector::{Detection, Feature};
use crate::matching::{Match, MatchResult, TwoViewModel};
use crate::requests::{MatchRequest, Matched};
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use std::time::Duration;

/// The matches of two bursts with what they were made from.
#[derive(Debug, Clone)]
pub struct Matches {
    /// The features and parameters that they were made from.
    pub request: MatchRequest,
    /// The matches, their geometry and counts.
    pub result: Arc<MatchResult>,
    /// Wall-clock time of the matching.
    pub elapsed: Duration,
}

/// One match with its features.
#[derive(Debug, Clone, Copy)]
pub struct MatchRow<'a> {
    /// Its index among the matches.
    pub index: usize,
    /// The match itself.
    pub found: &'a Match,
    /// Its feature in A.
    pub a: &'a Feature,
    /// Its feature in B.
    pub b: &'a Feature,
    /// Whether it agrees with the geometry; `None` where it was not verified.
    pub inlier: Option<bool>,
    /// Distance from the geometry, pixels; `None` where there is no geometry, infinite where the distance is
    /// undefined.
    pub error_px: Option<f32>,
}

/// Places of a match's features, with which it is selected again after the next matching.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SavedMatch {
    /// (u, v) in A, pixels.
    pub a: [f32; 2],
    /// (u, v) in B, pixels.
    pub b: [f32; 2],
}

/// Maximum distance of both features from those of a saved match that counts as the same, pixels.
const SAME_PLACE_PX: f32 = 1.0;

impl Matches {
    /// Wraps the engine's answer.
    pub fn new(matched: Matched, elapsed: Duration) -> Self {
        Self { request: matched.request, result: matched.result, elapsed }
    }

    /// Number of matches.
    pub fn len(&self) -> usize {
        self.result.matches.len()
    }

    /// Whether there are no matches.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The detection of one side.
    pub fn detection(&self, side: Side) -> &Detection {
        match side {
            Side::A => &self.request.a,
            Side::B => &self.request.b,
        }
    }

    /// Whether these are the features of `side` that were matched.
    pub fn is_of(&self, side: Side, detection: &Arc<Detection>) -> bool {
        match side {
            Side::A => Arc::ptr_eq(&self.request.a, detection),
            Side::B => Arc::ptr_eq(&self.request.b, detection),
        }
    }

    /// Geometry that most matches agree on.
    pub fn model(&self) -> Option<&TwoViewModel> {
        self.result.verification.as_ref()?.model.as_ref()
    }

    /// The match of this index.
    pub fn row(&self, index: usize) -> Option<MatchRow<'_>> {
        let found = self.result.matches.get(index)?;
        let (a, b) = (self.request.a.features.get(found.a)?, self.request.b.features.get(found.b)?);
        let verified = self.result.verification.as_ref();
        let inlier = verified.and_then(|v| v.inlier.get(index).copied());
        let error_px = verified.filter(|v| v.model.is_some()).and_then(|v| v.error_px.get(index).copied());
        Some(MatchRow { index, found, a, b, inlier, error_px })
    }

    /// All matches.
    pub fn rows(&self) -> impl Iterator<Item = MatchRow<'_>> {
        (0..self.len()).filter_map(|index| self.row(index))
    }

    /// Indices of the matches that are shown, in the table's order.
    pub fn listed(&self, look: &MatchLook, order: Order<MatchColumn>) -> Vec<usize> {
        let mut rows: Vec<MatchRow<'_>> = self.rows().filter(|row| look.shows(row.inlier)).collect();
        rows.sort_by(|a, b| {
            let by = order.column.value(a).total_cmp(&order.column.value(b));
            let by = if order.descending { by.reverse() } else { by };
            by.then(a.index.cmp(&b.index))
        });
        rows.iter().map(|row| row.index).collect()
    }

    /// Index of the match at the places of `saved`, if there is one.
    pub fn find_again(&self, saved: &SavedMatch) -> Option<usize> {
        let apart = |row: &MatchRow<'_>| {
            let of = |f: &Feature, at: [f32; 2]| (f.u - at[0]).hypot(f.v - at[1]);
            of(row.a, saved.a).max(of(row.b, saved.b))
        };
        let nearest = self.rows().min_by(|x, y| apart(x).total_cmp(&apart(y)))?;
        (apart(&nearest) <= SAME_PLACE_PX).then_some(nearest.index)
    }
}

impl MatchRow<'_> {
    /// Places with which the match is found again.
    pub fn saved(&self) -> SavedMatch {
        SavedMatch { a: [self.a.u, self.a.v], b: [self.b.u, self.b.v] }
    }
}

/// The columns of the table of matches.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MatchColumn {
    /// Number of the match, in the order of A's features.
    #[default]
    Number,
    /// Column in A.
    UA,
    /// Row in A.
    VA,
    /// Column in B.
    UB,
    /// Row in B.
    VB,
    /// Scale in A.
    SigmaA,
    /// Scale in B.
    SigmaB,
    /// Slope u in A.
    SlopeA,
    /// Slope u in B.
    SlopeB,
    /// Distance of the descriptors.
    Distance,
    /// Distance over the distance to the second nearest.
    Ratio,
    /// Distance from the geometry.
    Error,
    /// Whether it agrees with the geometry.
    Inlier,
}

impl MatchColumn {
    /// All columns, from left to right.
    pub const ALL: [Self; 13] = [
        Self::Number,
        Self::UA,
        Self::VA,
        Self::UB,
        Self::VB,
        Self::SigmaA,
        Self::SigmaB,
        Self::SlopeA,
        Self::SlopeB,
        Self::Distance,
        Self::Ratio,
        Self::Error,
        Self::Inlier,
    ];

    /// Its heading.
    pub fn heading(self) -> &'static str {
        match self {
            Self::Number => "#",
            Self::UA => "u A",
            Self::VA => "v A",
            Self::UB => "u B",
            Self::VB => "v B",
            Self::SigmaA => "σ A",
            Self::SigmaB => "σ B",
            Self::SlopeA => "Slope A",
            Self::SlopeB => "Slope B",
            Self::Distance => "Distance",
            Self::Ratio => "Ratio",
            Self::Error => "Error",
            Self::Inlier => "Inlier",
        }
    }

    /// Content of the column, with its unit.
    pub fn help(self) -> &'static str {
        match self {
            Self::Number => "Number of the match, in the order of A's features: the strongest first",
            Self::UA => "Column in A at mid-burst, in pixels; the centre of the first pixel is 0",
            Self::VA => "Row in A at mid-burst, in pixels; the centre of the first pixel is 0",
            Self::UB => "Column in B at mid-burst, in pixels; the centre of the first pixel is 0",
            Self::VB => "Row in B at mid-burst, in pixels; the centre of the first pixel is 0",
            Self::SigmaA => "Scale σ in A, in pixels",
            Self::SigmaB => "Scale σ in B, in pixels",
            Self::SlopeA => "Apparent motion in A to the right, in pixels per frame",
            Self::SlopeB => "Apparent motion in B to the right, in pixels per frame",
            Self::Distance => "Euclidean distance of the two descriptors",
            Self::Ratio => "Distance to the nearest descriptor over that to the second nearest",
            Self::Error => "Distance of the match from the geometry that most matches agree on, in pixels",
            Self::Inlier => "Whether the match agrees with that geometry",
        }
    }

    /// The value by which the column sorts; rows without one come last.
    pub fn value(self, row: &MatchRow<'_>) -> f32 {
        match self {
            Self::Number => row.index as f32,
            Self::UA => row.a.u,
            Self::VA => row.a.v,
            Self::UB => row.b.u,
            Self::VB => row.b.v,
            Self::SigmaA => row.a.sigma,
            Self::SigmaB => row.b.sigma,
            Self::SlopeA => row.a.slope.u,
            Self::SlopeB => row.b.slope.u,
            Self::Distance => row.found.distance,
            Self::Ratio => row.found.ratio,
            Self::Error => row.error_px.unwrap_or(f32::INFINITY),
            Self::Inlier => row.inlier.map_or(2.0, |inlier| f32::from(u8::from(!inlier))),
        }
    }

    /// The value as the table shows it.
    pub fn text(self, row: &MatchRow<'_>) -> String {
        match self {
            Self::Number => (row.index + 1).to_string(),
            Self::UA => fixed(row.a.u, 2),
            Self::VA => fixed(row.a.v, 2),
            Self::UB => fixed(row.b.u, 2),
            Self::VB => fixed(row.b.v, 2),
            Self::SigmaA => format!("{:.2}", row.a.sigma),
            Self::SigmaB => format!("{:.2}", row.b.sigma),
            Self::SlopeA => signed(row.a.slope.u, 2),
            Self::SlopeB => signed(row.b.slope.u, 2),
            Self::Distance => format!("{:.1}", row.found.distance),
            Self::Ratio => format!("{:.3}", row.found.ratio),
            Self::Error => row.error_px.map_or_else(|| "–".to_owned(), |e| number(e, 3)),
            Self::Inlier => match row.inlier {
                Some(true) => "yes",
                Some(false) => "no",
                None => "–",
            }
            .to_owned(),
        }
    }
}

/// Display settings of matches.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct MatchLook {
    /// Whether the matches that agree with the geometry are shown; also those that were not verified.
    pub inliers: bool,
    /// Whether the matches that do not agree are shown.
    pub outliers: bool,
    /// Opacity of lines, 0 … 1.
    pub opacity: f32,
    /// Whether the selected match is drawn alone.
    pub alone: bool,
    /// Whether all features are drawn over both pictures.
    pub features: bool,
    /// Whether the epipolar lines of the match that is looked at are drawn.
    pub geometry: bool,
}

impl Default for MatchLook {
    fn default() -> Self {
        Self { inliers: true, outliers: true, opacity: 0.7, alone: true, features: false, geometry: true }
    }
}

impl MatchLook {
    /// Whether a match is shown that is (or is not) an inlier, or was not verified.
    pub fn shows(&self, inlier: Option<bool>) -> bool {
        if inlier == Some(false) { self.outliers } else { self.inliers }
    }

    /// Copy with the settings that decide which matches are listed; the others have their defaults.
    pub(crate) fn listing(&self) -> Self {
        Self { inliers: self.inliers, outliers: self.outliers, ..Self::default() }
    }

    /// Copy with an opacity of 0.05 … 1, or the default if it is not finite: a file may contain any value.
    #[must_use]
    pub fn sanitised(self) -> Self {
        let opacity = if self.opacity.is_finite() { self.opacity.clamp(0.05, 1.0) } else { Self::default().opacity };
        Self { opacity, ..self }
    }
}
