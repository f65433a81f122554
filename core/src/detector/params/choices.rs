//! Parameters with a few named values, and those with a syntax of their own, such as `auto` or `2..9`.

use serde::{Deserialize, Serialize};

/// Value with a few names, as options, files and menus show them.
pub trait Word {
    /// Name on the command line and in files.
    fn word(&self) -> &'static str;
    /// Names of all values, in order: on the command line and in files, and in the window.
    fn words(&self) -> &'static [(&'static str, &'static str)];
    /// Takes the value with this name; false where there is none.
    fn set_word(&mut self, word: &str) -> bool;
}

/// Gives the variants of a type their names on the command line and in the window.
macro_rules! words {
    ($type:ty, $(($variant:ident, $word:literal, $label:literal)),+) => {
        impl $crate::detector::params::Word for $type {
            fn word(&self) -> &'static str {
                match self {
                    $(Self::$variant => $word),+
                }
            }

            fn words(&self) -> &'static [(&'static str, &'static str)] {
                &[$(($word, $label)),+]
            }

            fn set_word(&mut self, word: &str) -> bool {
                match word {
                    $($word => *self = Self::$variant,)+
                    _ => return false,
                }
                true
            }
        }
    };
}
pub(crate) use words;

words!(Method, (Buff, "buff", "BuFF"), (Sift, "sift", "SIFT"), (Merge, "merge", "Merge + SIFT"));
words!(SlopeExtrema, (Each, "each", "Each"), (Joint, "joint", "Joint"));
words!(SearchSlopes, (All, "full", "All slopes"), (Field, "field", "Around the field"));
words!(NoiseModelKind, (Local, "local", "Local"), (White, "white", "White"));
words!(Flicker, (Auto, "auto", "Auto"), (Off, "off", "Off"));

/// Detector to run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Method {
    /// The burst feature finder: extrema of place and scale over all slopes, at each slope for itself or jointly (see
    /// [`SlopeExtrema`]). One line of slopes is BuFF 1D, a plane of slopes BuFF 2D.
    #[default]
    Buff,
    /// SIFT on the middle frame of those used: the same detector with one frame and slope 0.
    Sift,
    /// SIFT on the frames used, merged by [`crate::detect::detect`] into one image; the detector alone takes the mean.
    Merge,
}

/// Rule for candidates: extrema of place and scale at their own slope, or jointly over slopes too.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum SlopeExtrema {
    /// At each slope for itself: extrema of place and scale at their own slope.
    #[default]
    Each,
    /// Jointly: a sample must also beat those around it at other slopes, as in the paper and in LiFF.
    Joint,
}

/// Slopes at which each place is searched.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum SearchSlopes {
    /// All of the grid.
    #[default]
    #[serde(rename = "full")]
    All,
    /// Those around the motions that the [field of motion](crate::detector::field) finds around the place, or where its
    /// motion is unknown in the whole picture; all in bursts without a field.
    Field,
}

/// Slope at which a feature's orientation and descriptor are computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum DescribeSlope {
    /// The feature's own slope, between those of the grid.
    #[default]
    Refined,
    /// The grid's slope at which it was found, as the published codes do.
    Grid,
}

/// Distance at which a weaker keypoint is taken for the same blob.
#[derive(Debug, Clone, Copy, PartialEq, strum::Display)]
pub enum Distinct {
    /// All keypoints stay.
    #[strum(to_string = "off")]
    Off,
    /// Of keypoints nearer than this many σ of the stronger one, the stronger stays; above 0.
    #[strum(to_string = "{0}")]
    Radius(f32),
}

impl Default for Distinct {
    /// See [`super::doc::DISTINCT`]; chosen by reconstruction results (docs/MEASUREMENTS.md).
    fn default() -> Self {
        Self::Radius(1.25)
    }
}

impl std::str::FromStr for Distinct {
    type Err = String;

    /// Reads `off` or a number.
    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = |_| format!("'{text}' is neither 'off' nor a radius in σ, such as 1.25");
        let text = text.trim();
        if text == "off" { Ok(Self::Off) } else { text.parse().map(Self::Radius).map_err(wrong) }
    }
}

/// Form in files of a value whose text is a number or a word, for `#[serde(with)]`.
pub(super) mod number_or_word {
    use serde::{Deserialize, Deserializer, Serializer, de::Error};

    pub fn serialize<S: Serializer>(value: &impl ToString, serializer: S) -> Result<S::Ok, S::Error> {
        let text = value.to_string();
        match text.parse() {
            Ok(number) => serializer.serialize_f32(number),
            Err(_) => serializer.serialize_str(&text),
        }
    }

    pub fn deserialize<'de, D: Deserializer<'de>, T>(deserializer: D) -> Result<T, D::Error>
    where
        T: std::str::FromStr<Err = String>,
    {
        #[derive(Deserialize)]
        #[serde(untagged)]
        enum NumberOrWord {
            Number(f32),
            Word(String),
        }
        let text = match NumberOrWord::deserialize(deserializer)? {
            NumberOrWord::Number(number) => number.to_string(),
            NumberOrWord::Word(word) => word,
        };
        text.parse().map_err(D::Error::custom)
    }
}

/// Slopes with which a candidate is compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum SlopeNeighbours {
    /// The neighbouring slopes of the grid: 2 on a line (as LiFF does), 8 in a plane.
    #[default]
    Adjacent,
    /// Every slope of the grid, as the authors' code does.
    All,
}

/// Sampling of frames between pixels when they are shifted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Interpolation {
    /// Bilinear.
    #[default]
    Linear,
    /// The nearest pixel, as the authors' code does.
    Nearest,
    /// The place plus a half, truncated towards 0, as LiFF does: the nearest pixel, but places up to a pixel and a half
    /// before the first column or row count as it.
    Truncated,
}

/// Pixels of a first octave that is coarser than the input.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum CoarseStart {
    /// Means of the pixels around, weighted by a triangle: no light is lost, and fine structures do not alias.
    #[default]
    Binned,
    /// Every 2^octave-th pixel alone, as in VLFeat.
    Skipped,
}

/// Method for the place, scale and slope of an extremum between the samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Localisation {
    /// Compactly supported kernels on the pixels, continuous in place (see [`crate::detector::localise`]).
    #[default]
    Continuous,
    /// Quadratic fit to the samples of D around it, as in VLFeat and LiFF.
    Quadratic,
}

/// The noise gate: how many standard deviations of the noise in D a response must reach.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum NoiseGate {
    /// For looking and matching: the factor is derived from the size of the search so that pure noise gives about 5
    /// false keypoints a megapixel, which matching rejects.
    #[default]
    Auto,
    /// For matching alone: as [`Self::Auto`], with about 100, among which are faint true ones that matching finds.
    Matching,
    /// The factor is derived so that pure noise gives at most one false feature a megapixel over the whole search.
    Strict,
    /// This factor; 0 switches the gate off.
    Factor(f32),
}

impl NoiseGate {
    /// The gates that derive their factor from the size of the search, with their words.
    pub const DERIVED: [(Self, &'static str); 3] =
        [(Self::Auto, "auto"), (Self::Matching, "matching"), (Self::Strict, "strict")];

    /// Its word; `None` for a factor.
    pub fn word(self) -> Option<&'static str> {
        Self::DERIVED.iter().find(|(gate, _)| *gate == self).map(|(_, word)| *word)
    }
}

impl std::fmt::Display for NoiseGate {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match (self, self.word()) {
            (Self::Factor(k), _) => write!(f, "{k}"),
            (_, word) => f.write_str(word.unwrap_or_default()),
        }
    }
}

impl std::str::FromStr for NoiseGate {
    type Err = String;

    /// Reads `auto`, `matching`, `strict` or a number.
    fn from_str(text: &str) -> Result<Self, String> {
        let text = text.trim();
        match Self::DERIVED.iter().find(|(_, word)| *word == text) {
            Some((gate, _)) => Ok(*gate),
            None => text.parse().map(Self::Factor).map_err(|_| {
                format!("'{text}' is none of 'auto', 'matching' and 'strict', and no number of standard deviations")
            }),
        }
    }
}

/// Model of the noise.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum NoiseModelKind {
    /// Noise as measured in the burst, by brightness, place and scale, without faulty frames and pixels.
    #[default]
    Local,
    /// White noise of one standard deviation.
    White,
}

/// Treatment of exposures that differ from frame to frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Flicker {
    /// Where flicker is found, the frames are scaled to the same brightness.
    #[default]
    Auto,
    /// Frames are used as they are.
    Off,
}
