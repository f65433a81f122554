//! Display settings of the matches between the two pictures.

use serde::{Deserialize, Serialize};

/// Display settings of matches.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct MatchLook {
    /// Whether the matches that agree with the geometry are shown; also those that were not verified.
    pub inliers: bool,
    /// Whether the matches that do not agree are shown.
    pub outliers: bool,
    /// Opacity of lines, 0 … 1.
    pub opacity: f32,
    /// Whether the selected match is drawn alone.
    pub alone: bool,
    /// Whether all features are drawn over both pictures.
    pub features: bool,
    /// Whether the epipolar lines of the match that is looked at are drawn.
    pub geometry: bool,
}

impl Default for MatchLook {
    fn default() -> Self {
        Self { inliers: true, outliers: true, opacity: 0.7, alone: true, features: false, geometry: true }
    }
}

impl MatchLook {
    /// Whether a match is shown that is (or is not) an inlier, or was not verified.
    pub fn shows(&self, inlier: Option<bool>) -> bool {
        if inlier == Some(false) { self.outliers } else { self.inliers }
    }

    /// Copy with the settings that decide which matches are listed; the others have their defaults.
    pub(crate) fn listing(&self) -> Self {
        Self { inliers: self.inliers, outliers: self.outliers, ..Self::default() }
    }

    /// Copy with an opacity of 0.05 … 1, or the default if it is not finite: a file may contain any value.
    #[must_use]
    pub fn sanitised(self) -> Self {
        let opacity = if self.opacity.is_finite() { self.opacity.clamp(0.05, 1.0) } else { Self::default().opacity };
        Self { opacity, ..self }
    }
}
