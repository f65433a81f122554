//! Arguments that take one of a few words.

pub(super) use crate::synth::options::words;

#[cfg(feature = "colmap")]
pub(super) const IMAGE_KINDS: &[&str] = &["middle", "merged"];
pub(super) const MATCH_PICTURES: &[&str] = &["stack", "middle", "merged"];
pub(super) const FIGURE_FORMATS: &[&str] = &["png", "svg", "pdf"];
#[cfg(feature = "colmap")]
pub(super) const CAMERA_MODELS: &[&str] = &["SIMPLE_PINHOLE", "PINHOLE", "SIMPLE_RADIAL", "OPENCV"];
pub(super) const COMBINES: &[&str] =
    &["mean", "median", "clipped-mean", "max", "min", "deviation", "mean-minus-median"];
#[cfg(feature = "app")]
pub(super) const VIEW_KINDS: &[&str] = &["frame", "stack", "dog"];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dataset::ImageKind;
    use crate::synth::options::read_word;

    #[test]
    fn every_word_is_known_to_its_type() {
        #[cfg(feature = "colmap")]
        assert!(IMAGE_KINDS.iter().all(|w| read_word::<ImageKind>(w).is_ok()));
        assert!(MATCH_PICTURES.iter().all(|w| read_word::<crate::requests::MatchPictures>(w).is_ok()));
        assert!(FIGURE_FORMATS.iter().all(|w| read_word::<crate::export::FigureFormat>(w).is_ok()));
        assert!(COMBINES.iter().all(|w| read_word::<crate::detector::Combine>(w).is_ok()));
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
