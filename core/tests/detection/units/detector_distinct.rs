//! Tests of `detector::distinct`.
#![allow(unused_imports)]

use burstscope_core::burst::*;
use burstscope_core::detector::*;
use burstscope_core::detector::feature::*;
use burstscope_core::detector::params::*;
use burstscope_core::detector::scale_space::*;
use burstscope_core::monitor::*;
use rayon::prelude::*;
use proptest::prelude::*;





#[test]
fn a_weaker_keypoint_goes_within_the_radius_and_the_ratio_and_stays_beyond() {
    let strong = blob(10.0, 20.0, 4.0, 9.0);
    for (other, goes) in [
        (blob(14.9, 20.0, 4.0, 8.0), true),
        (blob(15.1, 20.0, 4.0, 8.0), false),
        (blob(10.0, 24.9, 4.0, 8.0), true),
        (blob(10.0, 20.0, 5.9, 8.0), true),
        (blob(10.0, 20.0, 6.1, 8.0), false),
        (blob(10.0, 20.0, 2.7, 8.0), true),
        (blob(10.0, 20.0, 2.6, 8.0), false),
    ] {
        assert_eq!(covered_by(&[strong, other], RULE, |_, _| false), [None, goes.then_some(0)], "{other:?}");
    }
}




