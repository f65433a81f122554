//! Rules in which the published codes differ from this detector.
//!
//! A choice of rules names a detector: it sets the [details](Rules) that have no parameter of their own, and the
//! [parameters that go with them](DetectorParams::under), which can then be set one by one.

use super::{
    CoarseStart, DescribeSlope, DetectorParams, Distinct, Flicker, Interpolation, Localisation, NoiseGate,
    NoiseModelKind, SearchParams, SearchSlopes, SlopeExtrema, SlopeNeighbours, Word,
};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Details of the search that users set together, by a [named](Rules::NAMED) set; tests set single fields.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rules {
    /// Slopes that a joint extremum must beat.
    pub slope_neighbours: SlopeNeighbours,
    /// Sampling of frames between pixels when they are shifted.
    pub interpolation: Interpolation,
    /// Pixels of a first octave of 1 and above.
    pub coarse_start: CoarseStart,
    /// Cut of the kernel of each blur from level to level, in its standard deviations; 1 to 8. At 4 the blur is exact
    /// to a thousandth. A level's whole kernel is cut at 4.5 of its own in any case.
    pub kernel_cut: f32,
    /// Method for place, scale and slope between the samples.
    pub localisation: Localisation,
    /// Slope at which orientation and descriptor are taken.
    pub describe_slope: DescribeSlope,
}

impl Rules {
    /// Rules of this program: the most accurate choice of each.
    pub const BURSTSCOPE: Self = Self {
        slope_neighbours: SlopeNeighbours::Adjacent,
        interpolation: Interpolation::Linear,
        coarse_start: CoarseStart::Binned,
        kernel_cut: 4.0,
        localisation: Localisation::Continuous,
        describe_slope: DescribeSlope::Refined,
    };
    /// Rules of VLFeat's SIFT.
    pub const VLFEAT: Self = Self {
        coarse_start: CoarseStart::Skipped,
        localisation: Localisation::Quadratic,
        describe_slope: DescribeSlope::Grid,
        ..Self::BURSTSCOPE
    };
    /// Rules of LiFF: VLFeat's, with frames shifted by truncated places.
    pub const LIFF: Self = Self { interpolation: Interpolation::Truncated, ..Self::VLFEAT };
    /// Rules of the BuFF authors' code, whose short kernels miss some sizes of blobs.
    pub const BUFF: Self = Self {
        slope_neighbours: SlopeNeighbours::All,
        interpolation: Interpolation::Nearest,
        kernel_cut: 2.0,
        ..Self::VLFEAT
    };
    /// Sets that users choose from, each with its name on the command line and in files.
    pub const NAMED: [(Self, &'static str); 4] =
        [(Self::BURSTSCOPE, "burstscope"), (Self::BUFF, "buff"), (Self::LIFF, "liff"), (Self::VLFEAT, "vlfeat")];
}

impl<S: Clone + Default> DetectorParams<S> {
    /// These parameters under other `rules`: the tests of candidates, the noise and the description become those of the
    /// named detector. Method, frames, slopes, octaves and the number of features stay.
    ///
    /// [BuFF](Rules::BUFF) are the joint extrema of the paper (Ravendran et al., §III-C) with its 4 levels and edge
    /// threshold of 10, a peak threshold of 0.0003 of full scale, and one descriptor; the paper knows no noise gate.
    /// [LiFF](Rules::LIFF) and [VLFeat](Rules::VLFEAT) have 3 levels and up to 4 orientations, and no peak threshold
    /// until one is given. Under rules without a name all other parameters stay.
    pub fn under(self, rules: Rules) -> Self {
        let published = Self {
            levels: 3,
            peak_threshold: 0.0,
            noise_gate: NoiseGate::Factor(0.0),
            noise_model: NoiseModelKind::White,
            flicker: Flicker::Off,
            edge_threshold: 10.0,
            search: SearchSlopes::All,
            slope_extrema: SlopeExtrema::Joint,
            distinct: Distinct::Off,
            max_orientations: 4,
            describe_scales: 1,
            ..Self::default()
        };
        // Rules made up by a test have no detector to take the other parameters from.
        let named = if rules == Rules::BURSTSCOPE {
            Self::default()
        } else if rules == Rules::BUFF {
            Self { levels: 4, peak_threshold: 0.0003, max_orientations: 1, ..published }
        } else if rules == Rules::LIFF || rules == Rules::VLFEAT {
            published
        } else {
            self.clone()
        };
        Self {
            // The choice of data and effort is the user's, not a detector's.
            method: self.method,
            frames: self.frames,
            octaves: self.octaves,
            first_octave: self.first_octave,
            max_features: self.max_features,
            slopes: self.slopes,
            rules,
            ..named
        }
    }

    /// Values that need not be given beside `rules`: those that the rules bring, and the default rules.
    pub fn implied_by(rules: Rules) -> Self {
        Self { rules: Rules::default(), ..Self::default().under(rules) }
    }
}

impl Word for SearchParams {
    fn word(&self) -> &'static str {
        self.rules.word()
    }

    fn words(&self) -> &'static [(&'static str, &'static str)] {
        self.rules.words()
    }

    fn set_word(&mut self, word: &str) -> bool {
        // Naming the present rules again must not reset parameters that were set one by one.
        let mut rules = self.rules;
        let is_known = rules.set_word(word);
        if is_known && rules != self.rules {
            *self = std::mem::take(self).under(rules);
        }
        is_known
    }
}

impl Default for Rules {
    fn default() -> Self {
        Self::BURSTSCOPE
    }
}

impl Word for Rules {
    /// Name of the set; `own` for another one, which no file has.
    fn word(&self) -> &'static str {
        Self::NAMED.iter().find(|(rules, _)| rules == self).map_or("own", |(_, word)| word)
    }

    fn words(&self) -> &'static [(&'static str, &'static str)] {
        &[("burstscope", "Burstscope"), ("buff", "Paper (BuFF)"), ("liff", "LiFF"), ("vlfeat", "VLFeat")]
    }

    fn set_word(&mut self, word: &str) -> bool {
        Self::NAMED.iter().find(|(_, name)| *name == word).map(|(rules, _)| *self = *rules).is_some()
    }
}

impl Serialize for Rules {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.word())
    }
}

impl<'de> Deserialize<'de> for Rules {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let (word, mut rules) = (String::deserialize(deserializer)?, Self::default());
        let names = Self::NAMED.map(|(_, name)| name).join(", ");
        let wrong = || serde::de::Error::custom(format!("rules: '{word}' is not known; give one of {names}"));
        rules.set_word(&word).then_some(rules).ok_or_else(wrong)
    }
}
