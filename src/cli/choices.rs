//! Arguments that take one of a few words.

use crate::detector::params::AUTO;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use serde::Deserialize;
use serde::de::DeserializeOwned;

/// Parser of words that `T` is read from in a parameter file, so that file and command line share their words.
///
/// `words` must be words of `T`; a test below checks it.
pub(super) fn words<T>(words: &'static [&'static str]) -> impl TypedValueParser<Value = T>
where
    T: DeserializeOwned + Clone + Send + Sync + 'static,
{
    PossibleValuesParser::new(words).try_map(|word| read_word::<T>(&word))
}

fn read_word<T: DeserializeOwned>(word: &str) -> Result<T, serde_json::Error> {
    serde_json::from_value(serde_json::Value::String(word.to_owned()))
}

/// Word of `--slopes`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum AutoWord {
    /// Slopes are found from each burst.
    Auto,
}

/// The words of [`AutoWord`].
pub(super) const AUTO_WORDS: &[&str] = &[AUTO];
/// The words of [`crate::detector::Method`].
pub(super) const METHODS: &[&str] = &["buff", "sift", "merge"];
/// The words of [`crate::detector::SlopeNeighbours`].
pub(super) const SLOPE_NEIGHBOURS: &[&str] = &["adjacent", "all"];
/// The words of [`crate::detector::SlopeExtrema`].
pub(super) const SLOPE_EXTREMA: &[&str] = &["each", "joint"];
/// The words of [`crate::detector::DescribeSlope`].
pub(super) const DESCRIBE_SLOPES: &[&str] = &["refined", "grid"];
/// The words of [`crate::detector::Interpolation`].
pub(super) const INTERPOLATIONS: &[&str] = &["linear", "nearest", "truncated"];
/// The words of [`crate::detector::Localisation`].
pub(super) const LOCALISATIONS: &[&str] = &["continuous", "quadratic"];
/// The words of [`crate::detector::NoiseModelKind`].
pub(super) const NOISE_MODELS: &[&str] = &["local", "white"];
/// The words of [`crate::detector::Flicker`].
pub(super) const FLICKERS: &[&str] = &["auto", "off"];
/// The words of [`crate::dataset::ImageKind`].
pub(super) const IMAGE_KINDS: &[&str] = &["middle", "merged"];
/// The words of [`crate::burst::RawColour`].
pub(super) const RAW_COLOURS: &[&str] = &["luma", "green", "red", "blue"];
/// The words of [`crate::matching::Geometry`].
pub(super) const GEOMETRIES: &[&str] = &["none", "fundamental", "essential", "homography"];
/// The words of [`crate::matching::CameraModel`].
#[cfg(feature = "colmap")]
pub(super) const CAMERA_MODELS: &[&str] = &["SIMPLE_PINHOLE", "PINHOLE", "SIMPLE_RADIAL", "OPENCV"];
/// The words of [`crate::evaluate::poses::Association`].
pub(super) const ASSOCIATIONS: &[&str] = &["name", "time", "order"];
/// The words of [`crate::app::project::cursor::ViewKind`].
#[cfg(feature = "app")]
pub(super) const VIEW_KINDS: &[&str] = &["frame", "stack", "dog"];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dataset::ImageKind;
    use crate::detector::NoiseModelKind;
    use crate::detector::{DescribeSlope, Flicker, Interpolation, Localisation, Method, SlopeExtrema, SlopeNeighbours};
    use crate::evaluate::poses::Association;
    use crate::matching::Geometry;

    #[test]
    fn every_word_is_known_to_its_type() {
        assert!(AUTO_WORDS.iter().all(|w| read_word::<AutoWord>(w).is_ok()));
        let methods: Vec<Method> = METHODS.iter().map(|w| read_word(w).expect(w)).collect();
        assert_eq!(methods, Method::ALL);
        assert_eq!(Method::ALL.map(Method::name).as_slice(), METHODS);
        assert!(SLOPE_NEIGHBOURS.iter().all(|w| read_word::<SlopeNeighbours>(w).is_ok()));
        assert!(SLOPE_EXTREMA.iter().all(|w| read_word::<SlopeExtrema>(w).is_ok()));
        assert!(DESCRIBE_SLOPES.iter().all(|w| read_word::<DescribeSlope>(w).is_ok()));
        assert!(INTERPOLATIONS.iter().all(|w| read_word::<Interpolation>(w).is_ok()));
        assert!(LOCALISATIONS.iter().all(|w| read_word::<Localisation>(w).is_ok()));
        assert!(NOISE_MODELS.iter().all(|w| read_word::<NoiseModelKind>(w).is_ok()));
        assert!(FLICKERS.iter().all(|w| read_word::<Flicker>(w).is_ok()));
        assert!(IMAGE_KINDS.iter().all(|w| read_word::<ImageKind>(w).is_ok()));
        assert!(RAW_COLOURS.iter().all(|w| read_word::<crate::burst::RawColour>(w).is_ok()));
        let geometries: Vec<Geometry> = GEOMETRIES.iter().map(|w| read_word(w).expect(w)).collect();
        assert_eq!(geometries, Geometry::ALL);
        assert_eq!(Geometry::ALL.map(Geometry::name).as_slice(), GEOMETRIES);
        assert!(ASSOCIATIONS.iter().all(|w| read_word::<Association>(w).is_ok()));
    }

    #[cfg(feature = "colmap")]
    #[test]
    fn every_camera_model_is_known() {
        use crate::matching::CameraModel;
        let models: Vec<CameraModel> = CAMERA_MODELS.iter().map(|w| read_word(w).expect(w)).collect();
        assert_eq!(models, CameraModel::ALL);
    }

    #[cfg(feature = "app")]
    #[test]
    fn every_kind_of_picture_is_known() {
        use crate::app::project::cursor::ViewKind;
        let kinds: Vec<ViewKind> = VIEW_KINDS.iter().map(|w| read_word(w).expect(w)).collect();
        assert_eq!(kinds, ViewKind::ALL);
    }
}
