//! Statistics of planes.

use crate::prelude::*;
use burstscope_core::plane::statistics::*;

fn plane_of(values: &[f32]) -> Plane {
    Plane::from_vec(values.len(), 1, values.to_vec())
}

#[test]
fn summary_and_regions_leave_out_what_is_not_finite_or_beyond_and_histograms_have_edges() {
    let plane = plane_of(&[1.0, f32::NAN, 3.0, f32::INFINITY, -2.0]);
    let s = summary(&plane, &Region::whole(&plane));
    assert_eq!((s.count, s.not_finite, s.min, s.max), (3, 2, -2.0, 3.0));
    assert!((s.mean - 2.0 / 3.0).abs() < 1e-12);
    let none = plane_of(&[f32::NAN]);
    assert_eq!(summary(&none, &Region::whole(&none)).range(), None);
    assert_eq!(percentiles(&none, &Region::whole(&none), &[50.0]), None);
    assert_eq!(percentiles_until(&plane, &Region::whole(&plane), &[50.0], &cancelled()), Err(Cancelled));
    let plane = Plane::from_fn(10, 10, |u, v| (u + 10 * v) as f32);
    assert_eq!(summary(&plane, &Region { columns: 2..4, rows: 3..5 }).range(), Some((32.0, 43.0)));
    let beyond = Region { columns: 8..100, rows: 9..100 };
    assert_eq!(beyond.within(&plane).len(), 2);
    assert!(Region { columns: 20..30, rows: 0..1 }.within(&plane).is_empty());
    assert_eq!(summary(&plane, &Region { columns: 20..30, rows: 0..1 }).count, 0);
    let plane = plane_of(&[0.0, 0.24, 0.25, 1.0, -0.1, 1.1, f32::NAN]);
    let h = histogram(&plane, &Region::whole(&plane), 0.0, 1.0, 4);
    assert_eq!(h.counts, vec![2, 1, 0, 1]);
    assert_eq!((h.below, h.above, h.nan), (1, 1, 1));
    assert_eq!(h.bin_range(1), (0.25, 0.5));
}

proptest! {
    #[test]
    fn percentiles_are_those_of_the_sorted_values(
        values in prop::collection::vec(prop_oneof![any::<f32>(), -1f32..1.0], 1..200), percent in 0f32..100.0
    ) {
        let plane = plane_of(&values);
        let mut sorted: Vec<f32> = values.iter().copied().filter(|x| x.is_finite()).collect();
        sorted.sort_by(f32::total_cmp);
        let found = percentiles(&plane, &Region::whole(&plane), &[percent]);
        if sorted.is_empty() {
            prop_assert_eq!(found, None);
        } else {
            let rank = (f64::from(percent) / 100.0 * (sorted.len() - 1) as f64).round() as usize;
            prop_assert_eq!(found.unwrap()[0].to_bits(), sorted[rank].to_bits());
        }
    }

    #[test]
    fn every_value_is_counted_once(values in prop::collection::vec(any::<f32>(), 0..200), bins in 1usize..50) {
        let plane = plane_of(&values);
        let h = histogram(&plane, &Region::whole(&plane), -1.0, 2.0, bins);
        prop_assert_eq!(h.counts.iter().sum::<u64>() + h.below + h.above + h.nan, values.len() as u64);
    }
}
