//! Tests of `matching`.
#![allow(unused_imports)]

use align::Measured;
use burstscope_core::detector::*;
use burstscope_core::error::*;
use burstscope_core::matching::*;
use burstscope_core::monitor::*;
use serde::Serialize;
use std::fmt;
use std::str::FromStr;

#[test]
fn ratios_are_of_each_images_own_keypoints_and_never_divided_by_zero() {
    let counts = MatchCounts { keypoints_a: 100, keypoints_b: 200, putative: 40, inliers: Some(30), refused: None };
    assert_eq!(counts.keypoints_per_image(), 150.0);
    assert!((counts.match_ratio() - (0.4 + 0.2) / 2.0).abs() < 1e-12);
    assert!((counts.match_score().expect("verified") - (0.3 + 0.15) / 2.0).abs() < 1e-12);
    assert_eq!(counts.inlier_ratio(), Some(0.75));
    let none = MatchCounts { inliers: Some(0), ..MatchCounts::default() };
    assert_eq!((none.match_ratio(), none.match_score(), none.inlier_ratio()), (0.0, Some(0.0), None));
    let unverified = MatchCounts { keypoints_a: 1, keypoints_b: 1, putative: 1, inliers: None, refused: None };
    assert_eq!((unverified.match_ratio(), unverified.match_score(), unverified.inlier_ratio()), (1.0, None, None));
}

#[test]
fn an_images_matches_with_all_others_are_added_up() {
    let counts = |putative, inliers| MatchCounts { putative, inliers: Some(inliers), ..MatchCounts::default() };
    let pairs = [((0, 1), counts(4, 3)), ((0, 2), counts(6, 0))];
    let all = ImageCounts::of(&[10, 8, 0], &pairs).expect("three images");
    // Image 0 has 10 putative matches, image 1 has 4, image 2 has 6 (and no keypoint to divide them by).
    assert_eq!((all.keypoints_per_image, all.putative_per_image, all.inliers_per_image), (6.0, 20.0 / 3.0, 2.0));
    assert!((all.match_ratio - (1.0 + 0.5) / 3.0).abs() < 1e-12);
    assert!((all.match_score - (0.3 + 0.375) / 3.0).abs() < 1e-12);
    assert_eq!((all.inlier_ratio, all.verified_pairs), (Some(0.3), 1));
    assert_eq!(ImageCounts::of(&[], &[]), None);
    assert_eq!(ImageCounts::of(&[5], &[]).expect("one image").inlier_ratio, None);
}

#[test]
fn pairs_are_in_order_and_each_is_there_once() {
    assert_eq!(PairSelection::All.pairs(4), [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)]);
    assert_eq!(PairSelection::Sequential(2).pairs(4), [(0, 1), (0, 2), (1, 2), (1, 3), (2, 3)]);
    assert_eq!(PairSelection::Sequential(usize::MAX).pairs(3).len(), 3);
    assert!(PairSelection::All.pairs(1).is_empty() && PairSelection::Sequential(3).pairs(0).is_empty());
    for choice in [PairSelection::All, PairSelection::Sequential(7)] {
        assert_eq!(choice.to_string().parse(), Ok(choice));
    }
    for bad in ["", "some", "sequential", "sequential:0", "sequential:-1", "sequential:x"] {
        assert!(bad.parse::<PairSelection>().is_err(), "{bad}");
    }
}
