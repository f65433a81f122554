//! Quantities of a feature. One record for each states its form in files, tables, filters and colours, so that a new
//! quantity is added here, where it is computed, and nowhere else.

use super::feature::{Feature, Moves};
use crate::plane::display::ColourMap;
use serde::{Deserialize, Serialize};
use strum::{EnumCount, VariantArray};

/// Quantity of a feature. Depth, coherence and verdict are found after the detection; [`Feature`] does not hold them.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default, Serialize, Deserialize, EnumCount, VariantArray,
)]
#[serde(rename_all = "snake_case")]
#[allow(missing_docs)] // each is described by the help of its record
pub enum Quantity {
    #[default]
    Rank,
    U,
    V,
    Sigma,
    SlopeU,
    SlopeV,
    Depth,
    Snr,
    Coherence,
    Verdict,
    Response,
    Orientation,
    Octave,
    Level,
    AtSlopeLimit,
    SlopeSigma,
    FieldU,
    FieldV,
    FieldSigma,
    Layer,
    #[serde(rename = "motion")]
    Moves,
}

/// Place of a quantity in a feature, as an accessor by type.
#[derive(Debug, Clone, Copy)]
pub enum FeatureField {
    /// Real number, in the unit of the record.
    Real(fn(&mut Feature) -> &mut f32),
    /// Whole number.
    Whole(fn(&mut Feature) -> &mut i32),
    /// Yes or no.
    Flag(fn(&mut Feature) -> &mut bool),
    /// Kind of motion: a word, or its number in [`Moves::ALL`].
    Moves(fn(&mut Feature) -> &mut Moves),
    /// Computed beside the feature, such as depth.
    Beside,
}

/// Form of a value for people, in tables and legends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// Whole number, without decimals.
    Whole,
    /// Number with so many decimals.
    Fixed(usize),
    /// Number with so many decimals, and a sign.
    Signed(usize),
    /// Number with so many significant digits.
    Digits(usize),
    /// Number with so many significant digits, and a sign.
    SignedDigits(usize),
    /// Whole degrees, of an angle in radians.
    Degrees,
    /// "yes", or nothing.
    Flag,
}

/// Range of values that the colours of a quantity span.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Span {
    /// Range of the features' values; this one without features.
    Found(f32, f32),
    /// ± the largest magnitude of the features; ± this one without features.
    Around(f32),
    /// Fixed range, whatever the features.
    Always(f32, f32),
}

/// Colours of the values of a quantity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Colours {
    /// Map of colours, which `part` cuts.
    pub map: ColourMap,
    /// Parts of the map (0 … 1) at the smallest and largest value, without ends too dark for a dark picture.
    pub part: [f32; 2],
    /// Whether the colours follow the logarithm of the value.
    pub is_log: bool,
    /// Range of values that the colours span.
    pub span: Span,
}

/// Record of a quantity: all that files, tables, filters and legends know about it.
#[derive(Debug, Clone, Copy)]
pub struct Record {
    /// Name of the column in files; part of the file format.
    pub key: &'static str,
    /// Name in lists and legends.
    pub title: &'static str,
    /// Heading of the column in tables.
    pub heading: &'static str,
    /// Unit of the value in files; empty where it has none.
    pub unit: &'static str,
    /// Meaning, with the unit.
    pub help: &'static str,
    /// Entry of the program's glossary that explains it.
    pub term: Option<&'static str>,
    /// Form in tables.
    pub form: Form,
    /// Text in place of an unknown value.
    pub unknown: &'static str,
    /// Width of the column in tables, points.
    pub width: f32,
    /// Accessor of the value in a feature.
    pub place: FeatureField,
    /// Colours, if features can be coloured by the quantity.
    pub colours: Option<Colours>,
}

/// Lighter part of Viridis, which stands out from grey pictures and DoG maps, also with a colour vision deficiency.
pub const BRIGHT: Colours =
    Colours { map: ColourMap::Viridis, part: [0.35, 1.0], is_log: false, span: Span::Found(-1.0, 1.0) };
/// As [`BRIGHT`], for values without a sign.
pub const WARM: Colours =
    Colours { map: ColourMap::Magma, part: [0.45, 1.0], is_log: true, span: Span::Found(1.0, 16.0) };
/// As [`BRIGHT`], from light to dark: the few uneven responses stand out.
const REVERSED: Colours =
    Colours { map: ColourMap::Viridis, part: [1.0, 0.35], is_log: false, span: Span::Always(0.0, 1.0) };

fn named(key: &'static str, heading: &'static str, unit: &'static str, help: &'static str) -> Record {
    let (form, place, term, unknown, width, colours) = (Form::Whole, FeatureField::Beside, None, "", 46.0, None);
    Record { key, title: heading, heading, unit, help, term, form, unknown, width, place, colours }
}

fn motion(key: &'static str, heading: &'static str, term: &'static str, help: &'static str) -> Record {
    let (form, term, colours) = (Form::Signed(2), Some(term), Some(BRIGHT));
    Record { form, term, colours, ..named(key, heading, "px/frame", help) }
}

fn uncertainty(key: &'static str, help: &'static str) -> Record {
    let colours = Some(Colours { span: Span::Found(0.01, 1.0), ..WARM });
    Record { form: Form::Fixed(2), colours, ..named(key, "±", "px/frame", help) }
}

impl Quantity {
    /// All quantities, as tables show them from left to right: the most important come first.
    pub const ALL: [Self; Self::COUNT] = *Self::VARIANTS.first_chunk().expect("as many");

    /// Columns of files, in order. Positions and scale are in input pixels; orientation in radians; slopes in pixels
    /// per frame; `response` is the interpolated DoG value with its sign, fraction of full scale; `snr` is
    /// |response|/σ_D; `at_slope_limit` is 1 or 0. Uncertainties of motions are standard deviations along the least
    /// certain direction. Tables as text have [empty](Self::is_empty) cells where the field or the layer is unknown.
    pub const STORED: [Self; 17] = [
        Self::U,
        Self::V,
        Self::Sigma,
        Self::Orientation,
        Self::SlopeU,
        Self::SlopeV,
        Self::Response,
        Self::Snr,
        Self::Octave,
        Self::Level,
        Self::AtSlopeLimit,
        Self::SlopeSigma,
        Self::FieldU,
        Self::FieldV,
        Self::FieldSigma,
        Self::Layer,
        Self::Moves,
    ];
    /// Numbers of the stored columns that files of earlier versions have.
    pub const STORED_EARLIER: [usize; 2] = [16, 11];

    /// Record of this quantity.
    pub fn record(self) -> Record {
        // Each record starts from `named` or a relative, and gives only what differs.
        match self {
            Self::Rank => {
                Record { width: 34.0, ..named("rank", "#", "", "Number in the order of strength, from 0, as in files") }
            }
            Self::U => Record {
                place: FeatureField::Real(|f| &mut f.u),
                form: Form::Fixed(2),
                ..named("u", "u", "px", "Column at mid-burst, in pixels; the centre of the first pixel is 0")
            },
            Self::V => Record {
                place: FeatureField::Real(|f| &mut f.v),
                form: Form::Fixed(2),
                ..named("v", "v", "px", "Row at mid-burst, in pixels; the centre of the first pixel is 0")
            },
            Self::Sigma => Record {
                place: FeatureField::Real(|f| &mut f.sigma),
                form: Form::Fixed(2),
                title: "Scale",
                term: Some("scale"),
                width: 34.0,
                colours: Some(WARM),
                ..named("sigma", "σ", "px", "Scale σ, in input pixels")
            },
            Self::Orientation => Record {
                place: FeatureField::Real(|f| &mut f.orientation),
                form: Form::Degrees,
                title: "Orientation",
                term: Some("orientation"),
                width: 40.0,
                ..named("orientation", "Orient.", "rad", "Orientation, in degrees from +u towards +v")
            },
            Self::SlopeU => Record {
                place: FeatureField::Real(|f| &mut f.slope.u),
                ..motion("slope_u", "Slope u", "slope", "Apparent motion to the right, in pixels per frame")
            },
            Self::SlopeV => Record {
                place: FeatureField::Real(|f| &mut f.slope.v),
                ..motion("slope_v", "Slope v", "slope", "Apparent motion downwards, in pixels per frame")
            },
            Self::Response => Record {
                place: FeatureField::Real(|f| &mut f.response),
                form: Form::SignedDigits(3),
                term: Some("response"),
                width: 64.0,
                colours: Some(Colours { span: Span::Around(0.1), ..BRIGHT }),
                ..named(
                    "response",
                    "Response",
                    "of full scale",
                    "Interpolated DoG value, as a fraction of full scale; bright blobs are negative",
                )
            },
            Self::Snr => Record {
                place: FeatureField::Real(|f| &mut f.snr),
                form: Form::Fixed(1),
                term: Some("snr"),
                width: 40.0,
                colours: Some(Colours { span: Span::Found(1.0, 100.0), ..WARM }),
                ..named("snr", "SNR", "σ", "|response| over the σ of the noise of the DoG")
            },
            Self::Octave => Record {
                place: FeatureField::Whole(|f| &mut f.octave),
                title: "Octave",
                term: Some("octave"),
                width: 34.0,
                ..named("octave", "Oct.", "", "Octave in which it was found; −1 is the doubled image")
            },
            Self::Level => Record {
                place: FeatureField::Whole(|f| &mut f.level),
                term: Some("level"),
                width: 36.0,
                ..named("level", "Level", "", "Level within the octave")
            },
            Self::AtSlopeLimit => Record {
                place: FeatureField::Flag(|f| &mut f.at_slope_limit),
                form: Form::Flag,
                title: "Slope limit",
                term: Some("slope-limit"),
                width: 36.0,
                colours: Some(Colours { span: Span::Always(0.0, 1.0), ..BRIGHT }),
                ..named(
                    "at_slope_limit",
                    "Limit",
                    "",
                    "Marked if the response still rises beyond the searched slopes: the motion lies outside",
                )
            },
            Self::SlopeSigma => Record {
                place: FeatureField::Real(|f| &mut f.slope_sigma),
                title: "Slope ±",
                ..uncertainty("slope_sigma", "Standard deviation of its slope along its least certain direction")
            },
            Self::FieldU => Record {
                place: FeatureField::Real(|f| &mut f.field.u),
                unknown: "–",
                ..motion("field_u", "Field u", "field", "Motion of its place to the right, from the field of motion")
            },
            Self::FieldV => Record {
                place: FeatureField::Real(|f| &mut f.field.v),
                unknown: "–",
                ..motion("field_v", "Field v", "field", "Motion of its place downwards, from the field of motion")
            },
            Self::FieldSigma => Record {
                place: FeatureField::Real(|f| &mut f.field_sigma),
                title: "Field ±",
                term: Some("field"),
                ..uncertainty(
                    "field_sigma",
                    "Standard deviation of its place's motion along the least certain direction; ∞ where it is unknown",
                )
            },
            Self::Layer => Record {
                place: FeatureField::Whole(|f| &mut f.layer),
                unknown: "–",
                term: Some("layer"),
                width: 36.0,
                colours: Some(Colours { span: Span::Found(0.0, 1.0), ..BRIGHT }),
                ..named("layer", "Layer", "", "Motion layer that it moves with, from 1, the nearest; 0 for none")
            },
            Self::Moves => Record {
                place: FeatureField::Moves(|f| &mut f.moves),
                term: Some("field"),
                // The longest of its words, “moves with its surroundings”.
                width: 196.0,
                colours: Some(Colours { span: Span::Always(0.0, 4.0), ..BRIGHT }),
                ..named(
                    "motion",
                    "Moves",
                    "",
                    "With its surroundings, by itself, not defined (an edge, which shows no motion along itself), or a ghost of another motion",
                )
            },
            Self::Coherence => Record {
                form: Form::Fixed(2),
                title: "Coherence",
                term: Some("coherence"),
                unknown: "?",
                width: 40.0,
                colours: Some(REVERSED),
                ..named(
                    "coherence",
                    "Coher.",
                    "",
                    "How alike the frames respond along its motion, 0 to 1; about the share of frames that respond",
                )
            },
            Self::Verdict => Record {
                term: Some("ghost"),
                width: 64.0,
                ..named(
                    "verdict",
                    "Verdict",
                    "",
                    "Likely real, a ghost of another motion, an alias of a periodic texture, a duplicate, or unclear",
                )
            },
            Self::Depth => Record {
                form: Form::Digits(3),
                unknown: "–",
                colours: Some(Colours { span: Span::Always(1.0, 10.0), ..WARM }),
                ..named(
                    "depth",
                    "Depth",
                    "m",
                    "Depth that the slope means by the set-up, in metres; – where none explains it",
                )
            },
        }
    }

    /// Whether `feature` lacks this quantity: the field where it is unknown, the layer where there is none.
    pub fn is_empty(self, feature: &Feature) -> bool {
        match self {
            Self::FieldU | Self::FieldV | Self::FieldSigma => feature.field_sigma.is_infinite(),
            Self::Layer => feature.layer == 0,
            _ => false,
        }
    }

    /// Value of `feature`; `None` for quantities beside the feature. An unknown field is NaN ± infinity; no layer is 0.
    pub fn of(self, feature: &Feature) -> Option<f32> {
        let mut feature = *feature;
        if matches!(self, Self::FieldU | Self::FieldV) && self.is_empty(&feature) {
            return Some(f32::NAN);
        }
        match self.record().place {
            FeatureField::Real(at) => Some(*at(&mut feature)),
            FeatureField::Whole(at) => Some(*at(&mut feature) as f32),
            FeatureField::Flag(at) => Some(f32::from(u8::from(*at(&mut feature)))),
            FeatureField::Moves(at) => Some(f32::from(*at(&mut feature) as u8)),
            FeatureField::Beside => None,
        }
    }

    /// Value of `feature` as files have it: with the fewest digits that read back to the same number; a flag as 1 or 0,
    /// and the motion as a word. Empty if a feature does not hold this quantity, or [lacks](Self::is_empty) it.
    pub fn cell(self, feature: &Feature) -> String {
        let mut feature = *feature;
        match self.record().place {
            _ if self.is_empty(&feature) => String::new(),
            FeatureField::Real(at) => at(&mut feature).to_string(),
            FeatureField::Whole(at) => at(&mut feature).to_string(),
            FeatureField::Flag(at) => u8::from(*at(&mut feature)).to_string(),
            FeatureField::Moves(at) => at(&mut feature).key().to_owned(),
            FeatureField::Beside => String::new(),
        }
    }

    /// Sets the value of `feature` from a file's cell; an empty cell changes nothing.
    ///
    /// # Errors
    /// Allowed values of the cell, in words.
    pub fn read(self, feature: &mut Feature, cell: &str) -> Result<(), &'static str> {
        match self.record().place {
            _ if cell.is_empty() && matches!(self, Self::FieldU | Self::FieldV | Self::FieldSigma | Self::Layer) => {}
            FeatureField::Real(at) => *at(feature) = cell.parse().map_err(|_| "a number")?,
            FeatureField::Whole(at) => *at(feature) = cell.parse().map_err(|_| "a whole number")?,
            FeatureField::Flag(at) => {
                *at(feature) = match cell {
                    "0" => false,
                    "1" => true,
                    _ => return Err("0 or 1"),
                }
            }
            FeatureField::Moves(at) => {
                let moves = Moves::ALL.into_iter().find(|moves| moves.key() == cell);
                *at(feature) = moves.ok_or("unknown, surroundings, own, edge or ghost")?;
            }
            FeatureField::Beside => return Err("in no file"),
        }
        Ok(())
    }
}
