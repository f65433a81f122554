//! The columns of the table of matches.

use crate::app::project::pair::MatchRow;
use crate::app::view::number;
use serde::{Deserialize, Serialize};

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
            Self::UA => format!("{:.2}", row.a.u),
            Self::VA => format!("{:.2}", row.a.v),
            Self::UB => format!("{:.2}", row.b.u),
            Self::VB => format!("{:.2}", row.b.v),
            Self::SigmaA => format!("{:.2}", row.a.sigma),
            Self::SigmaB => format!("{:.2}", row.b.sigma),
            Self::SlopeA => format!("{:+.2}", row.a.slope.u),
            Self::SlopeB => format!("{:+.2}", row.b.slope.u),
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
