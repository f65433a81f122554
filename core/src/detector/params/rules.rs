//! Rules in which the published codes differ from this detector.

use super::{CoarseStart, DescribeSlope, Interpolation, Localisation, SlopeNeighbours, Word};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Details of the search that nobody sets one by one: users choose one of the [named](Rules::NAMED) sets, and tests of
/// agreement with other codes set the fields.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rules {
    /// Slopes that a joint extremum must beat.
    pub slope_neighbours: SlopeNeighbours,
    /// Sampling of frames between pixels when they are shifted.
    pub interpolation: Interpolation,
    /// Pixels of a first octave of 1 and above.
    pub coarse_start: CoarseStart,
    /// End of the kernel of each blur from level to level, in its standard deviations; 1 to 8. At 4 it is exact to a
    /// thousandth. What a level sums up ends at 4.5 of its own in any case.
    pub kernel_cut: f32,
    /// Method for place, scale and slope between the samples.
    pub localisation: Localisation,
    /// Slope at which orientation and descriptor are taken.
    pub describe_slope: DescribeSlope,
}

impl Rules {
    /// Those of this program: the most accurate of each.
    pub const BURSTSCOPE: Self = Self {
        slope_neighbours: SlopeNeighbours::Adjacent,
        interpolation: Interpolation::Linear,
        coarse_start: CoarseStart::Binned,
        kernel_cut: 4.0,
        localisation: Localisation::Continuous,
        describe_slope: DescribeSlope::Refined,
    };
    /// Those of VLFeat's SIFT.
    pub const VLFEAT: Self = Self {
        coarse_start: CoarseStart::Skipped,
        localisation: Localisation::Quadratic,
        describe_slope: DescribeSlope::Grid,
        ..Self::BURSTSCOPE
    };
    /// Those of LiFF.
    pub const LIFF: Self = Self { interpolation: Interpolation::Truncated, ..Self::VLFEAT };
    /// Those of the BuFF authors' code, which misses some sizes of blobs by its kernels.
    pub const BUFF: Self = Self {
        slope_neighbours: SlopeNeighbours::All,
        interpolation: Interpolation::Nearest,
        kernel_cut: 2.0,
        ..Self::VLFEAT
    };
    /// The sets that users choose from, each with its name on the command line and in files.
    pub const NAMED: [(Self, &'static str); 4] =
        [(Self::BURSTSCOPE, "burstscope"), (Self::BUFF, "buff"), (Self::LIFF, "liff"), (Self::VLFEAT, "vlfeat")];
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
        &[("burstscope", "Burstscope"), ("buff", "BuFF authors"), ("liff", "LiFF"), ("vlfeat", "VLFeat")]
    }

    fn set_word(&mut self, word: &str) -> bool {
        let named = Self::NAMED.iter().find(|(_, name)| *name == word);
        named.map(|(rules, _)| *self = *rules).is_some()
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_name_stands_for_its_rules_and_others_are_refused() {
        for ((rules, name), (word, _)) in Rules::NAMED.into_iter().zip(Rules::default().words()) {
            assert_eq!((name, rules.word()), (*word, name));
            let mut read = Rules { kernel_cut: 3.0, ..Rules::default() };
            assert!(read.word() == "own" && read.set_word(name) && read == rules);
        }
        assert!(!Rules::default().set_word("own"));
        let error = serde_json::from_str::<Rules>("\"own\"").expect_err("no set of this name");
        assert!(error.to_string().contains("give one of burstscope, buff, liff, vlfeat"), "{error}");
    }
}
