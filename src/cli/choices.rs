//! Arguments that take one of a few words.

use clap::builder::{PossibleValuesParser, TypedValueParser};
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

/// The words of [`crate::dataset::ImageKind`].
pub(super) const IMAGE_KINDS: &[&str] = &["middle", "merged"];
/// The words of [`crate::burst::RawColour`].
pub(super) const RAW_COLOURS: &[&str] = &["luma", "green", "red", "blue"];
/// The words of [`crate::matching::CameraModel`].
#[cfg(feature = "colmap")]
pub(super) const CAMERA_MODELS: &[&str] = &["SIMPLE_PINHOLE", "PINHOLE", "SIMPLE_RADIAL", "OPENCV"];
/// The words of [`crate::detector::Combine`].
pub(super) const COMBINES: &[&str] =
    &["mean", "median", "clipped-mean", "max", "min", "deviation", "mean-minus-median"];
/// The words of [`crate::recover::Shape`].
pub(super) const SHAPES: &[&str] = &["disc", "blob"];
/// The words of [`crate::recover::Contrast`].
pub(super) const CONTRASTS: &[&str] = &["bright", "dark", "both"];
/// The words of [`crate::evaluate::poses::Association`].
pub(super) const ASSOCIATIONS: &[&str] = &["name", "time", "order"];
/// The words of [`crate::app::project::cursor::ViewKind`].
#[cfg(feature = "app")]
pub(super) const VIEW_KINDS: &[&str] = &["frame", "stack", "dog"];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dataset::ImageKind;
    use crate::evaluate::poses::Association;

    #[test]
    fn every_word_is_known_to_its_type() {
        assert!(IMAGE_KINDS.iter().all(|w| read_word::<ImageKind>(w).is_ok()));
        assert!(RAW_COLOURS.iter().all(|w| read_word::<crate::burst::RawColour>(w).is_ok()));
        assert!(COMBINES.iter().all(|w| read_word::<crate::detector::Combine>(w).is_ok()));
        assert!(SHAPES.iter().all(|w| read_word::<crate::recover::Shape>(w).is_ok()));
        assert!(CONTRASTS.iter().all(|w| read_word::<crate::recover::Contrast>(w).is_ok()));
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
        assert_eq!(kinds, ViewKind::OF_CURSOR);
    }
}
