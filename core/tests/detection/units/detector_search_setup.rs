//! Tests of `detector::search::setup`.
#![allow(unused_imports)]

use burstscope_core::burst::*;
use burstscope_core::detector::*;
use burstscope_core::detector::noise::*;
use burstscope_core::detector::noise_model::*;
use burstscope_core::detector::params::*;
use burstscope_core::detector::scale_space::*;
use burstscope_core::detector::stack::*;
use burstscope_core::error::*;
use burstscope_core::monitor::*;
use burstscope_core::plane::*;
use std::borrow::Borrow;
use std::ops::Range;
use std::sync::{Arc, Mutex};
use proptest::prelude::*;

proptest! {
    #[test]
    fn groups_own_every_slope_once_and_visit_what_they_need(
        count in 1usize..90, reach in 0usize..9, max in 0usize..100,
    ) {
        let Some(groups) = SlopeGroup::cut(count, Some(reach), max) else {
            prop_assert!(max < count && max <= 2 * reach);
            return Ok(());
        };
        let owned: Vec<usize> = groups.iter().flat_map(|group| group.own.clone()).collect();
        prop_assert_eq!(owned, (0..count).collect::<Vec<_>>());
        for SlopeGroup { own, visited } in &groups {
            prop_assert!(!own.is_empty() && visited.len() <= max);
            prop_assert_eq!(visited.start, own.start.saturating_sub(if groups.len() > 1 { reach } else { 0 }));
            prop_assert!(visited.end == count || visited.end >= own.end + reach);
        }
    }
}

#[test]
fn what_needs_all_slopes_is_not_cut() {
    let groups = |reach, max| SlopeGroup::cut(7, reach, max).map(|groups| groups.len());
    assert_eq!([groups(None, 7), groups(None, 6), groups(Some(1), 5)], [Some(1), None, Some(3)]);
}

