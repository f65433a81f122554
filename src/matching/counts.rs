//! How well two images match, in the numbers of the paper's Table 1.
//!
//! Match ratio is the share of the keypoints that have a putative match, match score the share that have an inlier match, and precision the share of the putative
//! matches that are inliers (after Schönberger, Hardmeier, Sattler and Pollefeys, "Comparative Evaluation of Hand-Crafted and Learned Local Features",
//! CVPR 2017). The first two are taken for each image with its own keypoints and averaged over the images, here A and B. Against many other images, as
//! in the table, an image's matches with all of them are added up, so that these shares may pass 1.

use serde::Serialize;

/// The numbers of one pair of images, A and B.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct MatchCounts {
    /// Features of A.
    pub keypoints_a: usize,
    /// Features of B.
    pub keypoints_b: usize,
    /// Matches by descriptors alone.
    pub putative: usize,
    /// Matches that a common geometry explains; `None` where none was asked for.
    pub inliers: Option<usize>,
}

impl MatchCounts {
    /// Mean number of features of an image.
    pub fn keypoints_per_image(&self) -> f64 {
        (self.keypoints_a + self.keypoints_b) as f64 / 2.0
    }

    /// Putative matches over keypoints, mean of A and B; 0 where there are no matches.
    pub fn match_ratio(&self) -> f64 {
        self.share_of_keypoints(self.putative)
    }

    /// Inliers over keypoints, mean of A and B; `None` where the geometry was not verified.
    pub fn match_score(&self) -> Option<f64> {
        self.inliers.map(|inliers| self.share_of_keypoints(inliers))
    }

    /// Inliers over putative matches; `None` where the geometry was not verified or there are no matches.
    pub fn precision(&self) -> Option<f64> {
        let inliers = self.inliers?;
        (self.putative > 0).then(|| inliers as f64 / self.putative as f64)
    }

    fn share_of_keypoints(&self, matches: usize) -> f64 {
        let share = |keypoints: usize| if keypoints > 0 { matches as f64 / keypoints as f64 } else { 0.0 };
        (share(self.keypoints_a) + share(self.keypoints_b)) / 2.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ratios_are_of_each_images_own_keypoints() {
        let counts = MatchCounts { keypoints_a: 100, keypoints_b: 200, putative: 40, inliers: Some(30) };
        assert_eq!(counts.keypoints_per_image(), 150.0);
        assert!((counts.match_ratio() - (0.4 + 0.2) / 2.0).abs() < 1e-12);
        assert!((counts.match_score().expect("verified") - (0.3 + 0.15) / 2.0).abs() < 1e-12);
        assert_eq!(counts.precision(), Some(0.75));
    }

    #[test]
    fn nothing_found_is_no_division_by_zero() {
        let none = MatchCounts { inliers: Some(0), ..MatchCounts::default() };
        assert_eq!((none.match_ratio(), none.match_score(), none.precision()), (0.0, Some(0.0), None));
        let unverified = MatchCounts { keypoints_a: 1, keypoints_b: 1, putative: 1, inliers: None };
        assert_eq!((unverified.match_ratio(), unverified.match_score(), unverified.precision()), (1.0, None, None));
    }
}
