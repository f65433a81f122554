//! Matches of two bursts with what they were made from, the columns of their table, and their display settings.

use crate::app::project::filter::Order;
use crate::app::project::pair::Side;
use crate::app::view::{fixed, number, signed};
use crate::detector::{Detection, Feature};
use crate::matching::align::Measured;
use crate::matching::aligned::NARROW;
use crate::matching::{Match, MatchResult, TwoViewModel};
use crate::requests::{MatchRequest, Matched};
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use std::time::Duration;

#[derive(Debug, Clone)]
pub struct Matches {
    pub request: MatchRequest,
    pub result: Arc<MatchResult>,
    pub elapsed: Duration,
}

#[derive(Debug, Clone, Copy)]
pub struct MatchRow<'a> {
    pub index: usize,
    pub found: &'a Match,
    pub a: &'a Feature,
    pub b: &'a Feature,
    /// Whether it agrees with the geometry; `None` where it was not verified.
    pub inlier: Option<bool>,
    /// Pixels; `None` where there is no geometry, infinite where the distance is undefined.
    pub error_px: Option<f32>,
    pub aligned: Option<Aligned>,
}

/// A match as the pictures of its places say it.
#[derive(Debug, Clone, Copy)]
pub struct Aligned {
    /// Place, scale and orientation in B of what A's feature shows.
    pub b: Feature,
    /// From B's place to that one, pixels.
    pub shift_px: [f64; 2],
    /// Correlation of the two pictures, −1 … 1.
    pub correlation: f64,
    /// Distance from where the other matches put it, pixels.
    pub residual_px: f64,
}

impl Aligned {
    fn of((measured, residual_px): (Measured, f64), a: &Feature, b: &Feature) -> Self {
        let ([u, v], (rotation, ratio)) = (measured.shift_px, measured.rotation_and_ratio());
        let b = Feature {
            u: b.u + u as f32,
            v: b.v + v as f32,
            sigma: a.sigma * ratio as f32,
            orientation: a.orientation + rotation as f32,
            ..*b
        };
        Self { b, shift_px: measured.shift_px, correlation: measured.correlation, residual_px }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SavedMatch {
    pub a: [f32; 2],
    pub b: [f32; 2],
}

/// Maximum distance of both features from those of a saved match that counts as the same, pixels.
const SAME_PLACE_PX: f32 = 1.0;

impl Matches {
    pub fn new(matched: Matched, elapsed: Duration) -> Self {
        Self { request: matched.request, result: matched.result, elapsed }
    }

    pub fn len(&self) -> usize {
        self.result.matches.len()
    }

    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    pub fn detection(&self, side: Side) -> &Arc<Detection> {
        match side {
            Side::A => &self.request.a,
            Side::B => &self.request.b,
        }
    }

    pub fn is_of(&self, side: Side, detection: &Arc<Detection>) -> bool {
        Arc::ptr_eq(self.detection(side), detection)
    }

    pub fn model(&self) -> Option<&TwoViewModel> {
        self.result.verification.as_ref()?.model.as_ref()
    }

    pub fn row(&self, index: usize) -> Option<MatchRow<'_>> {
        let found = self.result.matches.get(index)?;
        let (a, b) = (self.request.a.features.get(found.a)?, self.request.b.features.get(found.b)?);
        let verified = self.result.verification.as_ref();
        let inlier = verified.and_then(|v| v.inlier.get(index).copied());
        let error_px = verified.filter(|v| v.model.is_some()).and_then(|v| v.error_px.get(index).copied());
        let measured = self.result.alignment.as_ref().and_then(|alignment| alignment.measured[index]);
        let aligned = measured.map(|measured| Aligned::of(measured, a, b));
        Some(MatchRow { index, found, a, b, inlier, error_px, aligned })
    }

    /// Largest error of an inlier, pixels.
    pub fn max_error_px(&self) -> f32 {
        let part = if self.result.alignment.is_some() { NARROW } else { 1.0 };
        part * self.request.params.max_error_px
    }

    /// Limit that the match `row` passes, which makes it an outlier; `None` for an inlier, and where no geometry is
    /// known.
    pub fn passed_limit(&self, row: &MatchRow<'_>) -> Option<String> {
        let error = row.error_px.filter(|_| row.inlier == Some(false))?;
        let limit = self.max_error_px();
        let residual = row.aligned.map_or(0.0, |aligned| aligned.residual_px as f32);
        Some(match &self.result.alignment {
            _ if error > limit => format!("Error {error:.2} px, at most {limit:.2} px is allowed"),
            Some(alignment) if !alignment.was_inlier[row.index] => {
                "Too far from the geometry before the alignment".into()
            }
            _ if residual > limit => format!("Contradiction {residual:.2} px, at most {limit:.2} px is allowed"),
            _ => "The picture of its place is not found in B".into(),
        })
    }

    pub fn rows(&self) -> impl Iterator<Item = MatchRow<'_>> {
        (0..self.len()).filter_map(|index| self.row(index))
    }

    pub fn listed(&self, look: &MatchLook, order: Order<MatchColumn>) -> Vec<usize> {
        let mut rows: Vec<MatchRow<'_>> = self.rows().filter(|row| look.shows_row(row)).collect();
        rows.sort_by(|a, b| {
            let by = order.column.value(a).total_cmp(&order.column.value(b));
            let by = if order.descending { by.reverse() } else { by };
            by.then(a.index.cmp(&b.index))
        });
        rows.iter().map(|row| row.index).collect()
    }

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
    /// Difference of the motions in A and in B, px/frame.
    pub fn motion_apart(&self) -> f32 {
        let ((a, _), (b, _)) = (self.a.motion(), self.b.motion());
        (a.u - b.u).hypot(a.v - b.v)
    }

    pub fn saved(&self) -> SavedMatch {
        SavedMatch { a: [self.a.u, self.a.v], b: [self.b.u, self.b.v] }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MatchColumn {
    #[default]
    Number,
    UA,
    VA,
    UB,
    VB,
    SigmaA,
    SigmaB,
    SlopeA,
    SlopeB,
    Motion,
    Distance,
    Ratio,
    Error,
    Inlier,
}

impl MatchColumn {
    pub const ALL: [Self; 14] = {
        use MatchColumn::*;
        [Number, UA, VA, UB, VB, SigmaA, SigmaB, SlopeA, SlopeB, Motion, Distance, Ratio, Error, Inlier]
    };

    fn words(self) -> [&'static str; 2] {
        match self {
            Self::Number => ["#", "Number of the match, in the order of A's features: the strongest first"],
            Self::UA => ["u A", "Column in A at mid-burst, in pixels; the centre of the first pixel is 0"],
            Self::VA => ["v A", "Row in A at mid-burst, in pixels; the centre of the first pixel is 0"],
            Self::UB => ["u B", "Column in B at mid-burst, in pixels; the centre of the first pixel is 0"],
            Self::VB => ["v B", "Row in B at mid-burst, in pixels; the centre of the first pixel is 0"],
            Self::SigmaA => ["σ A", "Scale σ in A, in pixels"],
            Self::SigmaB => ["σ B", "Scale σ in B, in pixels"],
            Self::SlopeA => ["Slope A", "Apparent motion in A to the right, in pixels per frame"],
            Self::SlopeB => ["Slope B", "Apparent motion in B to the right, in pixels per frame"],
            Self::Motion => ["Motions", "Difference of the motions in A and in B, in pixels per frame"],
            Self::Distance => ["Distance", "Euclidean distance of the two descriptors"],
            Self::Ratio => ["Ratio", "Distance to the nearest descriptor over that to the second nearest"],
            Self::Error => ["Error", "Distance of the match from the geometry that most matches agree on, in pixels"],
            Self::Inlier => ["Inlier", "Whether the match agrees with that geometry"],
        }
    }

    pub fn heading(self) -> &'static str {
        self.words()[0]
    }

    pub fn help(self) -> &'static str {
        self.words()[1]
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
            Self::Motion => row.motion_apart(),
            Self::Distance => row.found.distance,
            Self::Ratio => row.found.ratio,
            Self::Error => row.error_px.unwrap_or(f32::INFINITY),
            Self::Inlier => row.inlier.map_or(2.0, |inlier| f32::from(u8::from(!inlier))),
        }
    }

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
            Self::Motion => format!("{:.2}", row.motion_apart()),
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

/// Way in which matches are drawn over the pictures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MatchesAs {
    /// Lines from picture to picture.
    #[default]
    Lines,
    /// In A, from the place in A to that in B.
    Vectors,
    /// Lines that end near the pointer.
    Near,
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct MatchLook {
    /// Whether the matches that agree with the geometry are shown; also those that were not verified.
    pub inliers: bool,
    pub outliers: bool,
    /// Opacity of lines, 0 … 1.
    pub opacity: f32,
    pub alone: bool,
    pub features: bool,
    pub geometry: bool,
    pub drawn_as: MatchesAs,
    /// Whether lines have the colour of the difference of the motions.
    pub by_motion: bool,
    /// Largest difference of the motions of the matches that are shown, px/frame.
    pub max_motion: Option<f32>,
}

impl Default for MatchLook {
    fn default() -> Self {
        Self {
            inliers: true,
            outliers: true,
            opacity: 0.7,
            alone: true,
            features: false,
            geometry: true,
            drawn_as: MatchesAs::Lines,
            by_motion: false,
            max_motion: None,
        }
    }
}

impl MatchLook {
    pub fn shows(&self, inlier: Option<bool>) -> bool {
        if inlier == Some(false) { self.outliers } else { self.inliers }
    }

    pub fn shows_row(&self, row: &MatchRow<'_>) -> bool {
        self.shows(row.inlier) && self.max_motion.is_none_or(|max| row.motion_apart() <= max)
    }

    pub(crate) fn listing(&self) -> Self {
        let Self { inliers, outliers, max_motion, .. } = *self;
        Self { inliers, outliers, max_motion, ..Self::default() }
    }

    /// Copy with an opacity of 0.05 … 1, or the default if it is not finite: a file may contain any value.
    #[must_use]
    pub fn sanitised(self) -> Self {
        let max_motion = self.max_motion.filter(|max| *max >= 0.0);
        let opacity = if self.opacity.is_finite() { self.opacity.clamp(0.05, 1.0) } else { Self::default().opacity };
        Self { opacity, max_motion, ..self }
    }
}
