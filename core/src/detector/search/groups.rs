//! Groups of slopes that are searched together: one group of all slopes if memory allows, otherwise several.
//!
//! For every slope that is searched at once, the first level of each coarser octave is held. A group holds those of its
//! own slopes and of the slopes around them, which its own are compared with or localised between; the groups that own
//! those compute them again. Every value is computed by identical operations whatever the group, so the groups'
//! keypoints together are those of the whole search.

use crate::plane::Plane;
use std::ops::Range;

/// Group of consecutive slopes in running order.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct SlopeGroup {
    /// Slopes whose keypoints are found.
    pub(crate) own: Range<usize>,
    /// Slopes that are computed for that: the group's own and the slopes around them.
    pub(crate) visited: Range<usize>,
}

impl SlopeGroup {
    /// Group of all `count` slopes.
    pub(crate) fn whole(count: usize) -> Self {
        Self { own: 0..count, visited: 0..count }
    }

    /// Divides `count` slopes into as few nearly equal groups as possible, none of which visits more than `max` slopes:
    /// each needs the slopes up to `reach` steps from its own, all of them for `None`. `None` where there are no such
    /// groups.
    pub(crate) fn cut(count: usize, reach: Option<usize>, max: usize) -> Option<Vec<Self>> {
        if count <= max {
            return Some(vec![Self::whole(count)]);
        }
        let reach = reach?;
        let own = max.checked_sub(2 * reach).filter(|own| *own > 0)?;
        let groups = count.div_ceil(own);
        let cut = |i: usize| i * count / groups;
        let around = |own: &Range<usize>| own.start.saturating_sub(reach)..(own.end + reach).min(count);
        let group = |own: Range<usize>| Self { visited: around(&own), own };
        Some((0..groups).map(|i| group(cut(i)..cut(i + 1))).collect())
    }
}

/// First levels (s = −1) of one octave at consecutive slopes.
#[derive(Debug, Default)]
pub(crate) struct FirstLevels {
    /// Index of the first slope in the grid.
    first_slope: usize,
    planes: Vec<Plane>,
}

impl FirstLevels {
    /// Takes `planes` of the slopes from slope `first_slope` of the grid on.
    pub(crate) fn new(first_slope: usize, planes: Vec<Plane>) -> Self {
        Self { first_slope, planes }
    }

    /// First level at slope `slope_index` of the grid, which is among those held.
    pub(crate) fn at(&self, slope_index: usize) -> &Plane {
        &self.planes[slope_index - self.first_slope]
    }

    /// All first levels that are held.
    pub(crate) fn planes(&self) -> &[Plane] {
        &self.planes
    }
}

#[cfg(test)]
mod tests {
    use super::*;
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
        assert_eq!(SlopeGroup::cut(7, None, 7), Some(vec![SlopeGroup::whole(7)]));
        assert_eq!(SlopeGroup::cut(7, None, 6), None);
        assert_eq!(SlopeGroup::cut(7, Some(1), 5).map(|groups| groups.len()), Some(3));
    }
}
