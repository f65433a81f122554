//! Tests of `matching::putative`.
#![allow(unused_imports)]

use burstscope_core::detector::*;
use burstscope_core::error::*;
use burstscope_core::matching::*;
use burstscope_core::matching::params::*;
use burstscope_core::matching::putative::*;
use burstscope_core::monitor::*;
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;
use serde::Serialize;
use std::sync::atomic::{AtomicUsize, Ordering};
use proptest::prelude::*;


fn nearest(queries: &[Descriptor], searched: &[Descriptor]) -> Vec<Nearest> {
    nearest_two(queries, searched, &Monitor::default()).expect("not cancelled")
}

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
    assert_eq!((found.distance, found.ratio), (2.0, Some(2.0 / 91.0)));
    // Among A's the nearest to b₀ is 1 away and the second 2.
    assert_eq!(matches(&a, &b, &MatchParams::default())[0].ratio, Some(0.5));
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
}


fn coarse(count: std::ops::Range<usize>) -> impl Strategy<Value = Vec<Descriptor>> {
    let element = prop::sample::select(vec![0u8, 1, 255]);
    let one = (prop::collection::vec(element, 4), any::<u8>()).prop_map(|(few, shift)| {
        let mut descriptor = [0u8; 128];
        few.iter().enumerate().for_each(|(i, &x)| descriptor[(i * 31 + usize::from(shift % 2)) % 128] = x);
        descriptor
    });
    prop::collection::vec(one, count)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn it_is_brute_force(queries in descriptors(0..70), searched in descriptors(0..70)) {
        prop_assert_eq!(nearest(&queries, &searched), brute_force(&queries, &searched));
    }

    #[test]
    fn both_ways_at_once_are_each_way(a in coarse(0..90), b in coarse(0..90)) {
        let (of_a, of_b) = nearest_two_both_ways(&a, &b, &Monitor::default()).expect("not cancelled");
        prop_assert_eq!((of_a, of_b), (brute_force(&a, &b), brute_force(&b, &a)));
    }

    #[test]
    fn ties_go_to_the_lowest_index(queries in coarse(0..40), searched in coarse(1..90)) {
        prop_assert_eq!(nearest(&queries, &searched), brute_force(&queries, &searched));
    }
}

#[test]
fn the_extremes_are_exact() {
    let (black, white) = ([0u8; 128], [255u8; 128]);
    let mut nearly = white;
    nearly[127] = 254;
    for searched in [vec![black], vec![white], vec![black, nearly], vec![nearly, white], vec![black; 33]] {
        assert_eq!(nearest(&[black, white, nearly], &searched), brute_force(&[black, white, nearly], &searched));
    }
    assert_eq!(
        nearest(&[black], &[white]),
        [Nearest { index: 0, distance_squared: 8_323_200, second_distance_squared: None }]
    );
}

#[test]
fn cancelling_leaves_no_result() {
    assert_eq!(nearest_two(&[[0; 128]], &[[1; 128]], &Monitor::cancelled()), Err(Cancelled));
}


