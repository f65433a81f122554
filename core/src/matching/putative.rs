//! Putative matches: nearest neighbours that pass the ratio test and the mutual check.

use super::MatchError;
use super::nearest::nearest_two;
use super::params::MatchParams;
use crate::detector::Descriptor;
use crate::monitor::Monitor;
use serde::Serialize;

/// A pair of features whose descriptors match.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Match {
    /// Index of the feature in image A.
    pub a: usize,
    /// Index of the feature in image B.
    pub b: usize,
    /// Euclidean distance of their descriptors, in the descriptors' own unit: 0 … 2885, and up to about 724 for those
    /// of the detector, which have a length of about 512.
    pub distance: f32,
    /// Ratio of that distance to the one to the second nearest descriptor, 0 … 1; with the mutual check the larger of
    /// the two images' ratios. It is 0 where there is no second descriptor, and 1 where both distances are 0.
    pub ratio: f32,
}

/// Finds the putative matches of the descriptors of images A and B, in the order of A's.
///
/// Each match is a descriptor of A with its nearest one in B, if the ratio of the distances to the nearest and the
/// second nearest is at most [`MatchParams::ratio`]. With [`MatchParams::mutual`] the descriptor of A must also be the
/// nearest to that of B, and pass the same test among those of A; the matches of (B, A) are then those of (A, B) with
/// the sides exchanged, as long as no two distances are equal. Of equally near descriptors the first counts as the
/// nearest.
///
/// # Errors
/// [`MatchError::Param`] for parameters that make no sense, [`MatchError::Cancelled`] once `monitor` was cancelled.
pub fn match_descriptors(
    a: &[Descriptor],
    b: &[Descriptor],
    params: &MatchParams,
    monitor: &Monitor,
) -> Result<Vec<Match>, MatchError> {
    params.validate()?;
    let of_a = nearest_two(a, b, monitor)?;
    let of_b = if params.mutual { Some(nearest_two(b, a, monitor)?) } else { None };
    let candidates = of_a.iter().enumerate().filter_map(|(index, nearest)| {
        let mut ratio = nearest.ratio();
        if let Some(of_b) = &of_b {
            let back = &of_b[nearest.index];
            if back.index != index {
                return None;
            }
            ratio = ratio.max(back.ratio());
        }
        let distance = f64::from(nearest.distance_squared).sqrt() as f32;
        Some(Match { a: index, b: nearest.index, distance, ratio })
    });
    Ok(candidates.filter(|m| m.ratio <= params.ratio).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::detector::ParamError;
    use proptest::prelude::*;

    fn matches(a: &[Descriptor], b: &[Descriptor], params: &MatchParams) -> Vec<Match> {
        match_descriptors(a, b, params, &Monitor::default()).expect("valid and not cancelled")
    }

    /// A descriptor with two non-zero elements.
    fn at(x: u8, y: u8) -> Descriptor {
        let mut descriptor = [0; 128];
        (descriptor[3], descriptor[100]) = (x, y);
        descriptor
    }

    #[test]
    fn the_ratio_test_and_the_mutual_check_do_what_they_say() {
        // A's first has a clear partner; its second lies between two; its third's partner is nearer to the first.
        let a = [at(0, 0), at(100, 0), at(3, 0)];
        let b = [at(1, 0), at(105, 0), at(94, 0), at(255, 255)];
        let pairs = |params: &MatchParams| matches(&a, &b, params).iter().map(|m| (m.a, m.b)).collect::<Vec<_>>();
        let one_way = MatchParams { mutual: false, ..MatchParams::default() };
        assert_eq!(pairs(&one_way), [(0, 0), (2, 0)]);
        assert_eq!(pairs(&MatchParams { ratio: 0.9, ..one_way.clone() }), [(0, 0), (1, 1), (2, 0)]);
        assert_eq!(pairs(&MatchParams::default()), [(0, 0)]);
        assert_eq!(pairs(&MatchParams { ratio: 1.0, ..MatchParams::default() }), [(0, 0), (1, 1)]);
        let found = matches(&a, &b, &one_way)[1];
        assert_eq!((found.distance, found.ratio), (2.0, 2.0 / 91.0));
        // Among A's the nearest to b₀ is 1 away and the second 2.
        assert_eq!(matches(&a, &b, &MatchParams::default())[0].ratio, 0.5);
    }

    #[test]
    fn twins_are_ambiguous_and_a_lone_descriptor_is_not() {
        let params = MatchParams { mutual: false, ..MatchParams::default() };
        assert_eq!(matches(&[at(5, 5)], &[at(5, 5), at(5, 5)], &params), []);
        let off = MatchParams { ratio: 1.0, ..params.clone() };
        assert_eq!(
            matches(&[at(5, 5)], &[at(5, 5), at(5, 5)], &off),
            [Match { a: 0, b: 0, distance: 0.0, ratio: 1.0 }]
        );
        assert_eq!(matches(&[at(5, 5)], &[at(5, 9)], &params), [Match { a: 0, b: 0, distance: 4.0, ratio: 0.0 }]);
    }

    #[test]
    fn an_empty_side_has_no_matches() {
        for mutual in [false, true] {
            let params = MatchParams { mutual, ..MatchParams::default() };
            assert_eq!(matches(&[], &[at(1, 1)], &params), []);
            assert_eq!(matches(&[at(1, 1)], &[], &params), []);
            assert_eq!(matches(&[], &[], &params), []);
        }
    }

    #[test]
    fn nonsense_is_refused() {
        let params = MatchParams { ratio: 0.0, ..MatchParams::default() };
        let error = match_descriptors(&[], &[], &params, &Monitor::default());
        assert!(matches!(error, Err(MatchError::Param(ParamError { parameter: "ratio", .. }))), "{error:?}");
    }

    fn descriptors(count: std::ops::Range<usize>) -> impl Strategy<Value = Vec<Descriptor>> {
        let one = prop::array::uniform32(any::<u32>());
        let bytes = |words: [u32; 32]| std::array::from_fn(|i| words[i / 4].to_le_bytes()[i % 4]);
        prop::collection::vec(one.prop_map(bytes), count)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn exchanging_the_images_exchanges_the_sides(a in descriptors(0..50), b in descriptors(0..50), ratio in 0.9f32..=1.0) {
            let params = MatchParams { ratio, mutual: true, ..MatchParams::default() };
            let there = matches(&a, &b, &params);
            let mut back: Vec<Match> = matches(&b, &a, &params).iter().map(|m| Match { a: m.b, b: m.a, ..*m }).collect();
            back.sort_by_key(|m| m.a);
            prop_assert_eq!(there, back);
        }

        #[test]
        fn the_order_of_the_features_does_not_matter(a in descriptors(1..50), b in descriptors(1..50), turn in 0usize..50, mutual: bool) {
            let params = MatchParams { ratio: 0.98, mutual, ..MatchParams::default() };
            let mut expected = matches(&a, &b, &params);
            let (mut turned_a, mut turned_b) = (a.clone(), b.clone());
            let (by_a, by_b) = (turn % a.len(), turn % b.len());
            turned_a.rotate_left(by_a);
            turned_b.rotate_left(by_b);
            for m in &mut expected {
                m.a = (m.a + a.len() - by_a) % a.len();
                m.b = (m.b + b.len() - by_b) % b.len();
            }
            expected.sort_by_key(|m| m.a);
            prop_assert_eq!(matches(&turned_a, &turned_b, &params), expected);
        }
    }
}
