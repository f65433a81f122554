//! Matches of two bursts with what they were made from, the columns of their table, and their display settings.

use crate::app::document::{MatchColumn, MatchLook, Order, PairColumn, SavedMatch, Side};
use crate::app::view::{fixed, number, signed};
use crate::detector::quantity::Form;
use crate::detector::{Detection, Feature};
use crate::matching::{Match, MatchResult, TwoViewModel};
use crate::matching::{align::Measured, aligned::NARROW};
use crate::requests::{MatchRequest, Matched};
use std::sync::Arc;
use std::time::Duration;

/// Numbers of matches with the names and helps that they have where two bursts are compared.
pub const PAIR_NUMBERS: [(&str, &str, PairColumn); 5] = [
    ("Putative", "Matches by descriptors alone", PairColumn::Putative),
    ("Inliers", "Putative matches that agree with the geometry of the two views", PairColumn::Inliers),
    ("Match ratio", "Putative matches over keypoints, mean of A and B", PairColumn::Ratio),
    ("Match score", "Inliers over keypoints, mean of A and B", PairColumn::Score),
    ("Inlier ratio", "Inliers over putative matches", PairColumn::InlierRatio),
];

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
    pub error_found_px: Option<f32>,
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
    fn of(measured: &Measured, residual_px: f64, a: &Feature, b: &Feature) -> Self {
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
        if side == Side::A { &self.request.a } else { &self.request.b }
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
        let aligned = measured.map(|(measured, residual_px)| Aligned::of(&measured, residual_px, a, b));
        let place = |f: &Feature| [f.u, f.v].map(f64::from);
        let error_found_px = self.model().map(|model| model.error_px(place(a), place(b)) as f32);
        Some(MatchRow { index, found, a, b, inlier, error_px, error_found_px, aligned })
    }

    pub fn max_error_px(&self) -> f32 {
        let part = if self.result.alignment.is_some() { NARROW } else { 1.0 };
        part * self.request.params.max_error_px
    }

    /// Limit that the match `row` passes, which makes it an outlier; `None` for an inlier, and without a geometry.
    pub fn passed_limit(&self, row: &MatchRow<'_>) -> Option<String> {
        let error = row.error_px.filter(|_| row.inlier == Some(false))?;
        let limit = self.max_error_px();
        let residual = row.aligned.map_or(0.0, |aligned| aligned.residual_px as f32);
        let why = format!(": {NARROW} × the max error of {} px", self.request.params.max_error_px);
        let passed = |what: &str, px: f32, why| format!("{what} {px:.2} px, at most {limit:.2} px is allowed{why}");
        Some(match &self.result.alignment {
            None if error > limit => passed("Error", error, ""),
            Some(alignment) if let Some(off_px) = alignment.contradicted.get(&row.index) => {
                let (off_px, most_px) = (number(*off_px as f32, 2), self.request.params.max_error_px);
                format!("All matches around put it {off_px} px off, at most the max error of {most_px} px is allowed")
            }
            Some(_) if error > limit => passed("Error aligned", error, &why),
            Some(alignment) if !alignment.was_inlier[row.index] => {
                "Too far from the geometry before the alignment".into()
            }
            _ if residual > limit => passed("Contradiction", residual, &why),
            _ => "The picture of its place is not found in B".into(),
        })
    }

    pub fn rows(&self) -> impl Iterator<Item = MatchRow<'_>> {
        (0..self.len()).filter_map(|index| self.row(index))
    }

    pub fn listed(&self, look: &MatchLook, order: Order<MatchColumn>) -> Vec<usize> {
        let mut rows: Vec<MatchRow<'_>> = self.rows().filter(|row| row.is_shown(look)).collect();
        let (value, _) = order.column.value();
        rows.sort_by(|a, b| {
            let by = value(a).total_cmp(&value(b));
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
    /// Its error after the alignment and as found: "0.15 px aligned, 2.62 px as found".
    pub fn error_words(&self) -> String {
        let px = |error: Option<f32>| error.map_or_else(|| "–".to_owned(), |e| format!("{} px", number(e, 3)));
        match self.aligned {
            Some(_) => format!("{} aligned, {} as found", px(self.error_px), px(self.error_found_px)),
            None => px(self.error_px),
        }
    }

    /// Whether it was predicted, with its ratios: "predicted by its motion (0.48 among 5; 0.84 among all)".
    pub fn how_words(&self) -> String {
        let how = if self.found.predicted.is_some() { "predicted by its motion" } else { "sure" };
        format!("{how} ({})", self.found.ratio_words())
    }

    pub fn is_shown(&self, look: &MatchLook) -> bool {
        look.shows(self.inlier) && look.max_motion.is_none_or(|max| self.motion_apart() <= max)
    }

    /// Difference of the motions in A and in B, px/frame.
    pub fn motion_apart(&self) -> f32 {
        let ((a, _), (b, _)) = (self.a.motion(), self.b.motion());
        (a.u - b.u).hypot(a.v - b.v)
    }
}

impl MatchColumn {
    /// The value by which it sorts, with its form; rows without a value come last.
    fn value(self) -> (fn(&MatchRow<'_>) -> f32, Form) {
        let (px, slope) = (Form::Fixed(2), Form::Signed(2));
        match self {
            Self::Number => (|row| row.index as f32, Form::Whole),
            Self::UA => (|row| row.a.u, px),
            Self::VA => (|row| row.a.v, px),
            Self::UB => (|row| row.b.u, px),
            Self::VB => (|row| row.b.v, px),
            Self::SigmaA => (|row| row.a.sigma, px),
            Self::SigmaB => (|row| row.b.sigma, px),
            Self::SlopeA => (|row| row.a.slope.u, slope),
            Self::SlopeB => (|row| row.b.slope.u, slope),
            Self::Motion => (|row| row.motion_apart(), px),
            Self::Distance => (|row| row.found.distance, Form::Fixed(1)),
            Self::Ratio => (|row| row.found.rank(), Form::Fixed(3)),
            Self::Error => (|row| row.error_px.unwrap_or(f32::INFINITY), Form::Digits(3)),
            Self::Inlier => (|row| row.inlier.map_or(2.0, |inlier| f32::from(u8::from(!inlier))), Form::Whole),
        }
    }

    pub fn text(self, row: &MatchRow<'_>) -> String {
        let (value, form) = self.value();
        let x = value(row);
        match (self, form) {
            (Self::Inlier, _) => row.inlier.map_or("–", |inlier| if inlier { "yes" } else { "no" }).to_owned(),
            (Self::Error, _) if row.error_px.is_none() => "–".to_owned(),
            (Self::Ratio, _) if row.found.ratio.is_none() => "–".to_owned(),
            (_, Form::Fixed(decimals)) => fixed(x, decimals),
            (_, Form::Signed(decimals)) => signed(x, decimals),
            (_, Form::Digits(digits)) => number(x, digits),
            _ => format!("{x:.0}"),
        }
    }
}
