//! Slopes of a search that an earlier one has searched already.
//!
//! Where each slope is searched for itself, a search is the sum of the searches of its slopes. A search whose range was
//! widened, moved or made finer takes over the keypoints and the first levels that an earlier search of the same frames
//! left at the slopes that both have. Only the other slopes are stacked and filtered.

use crate::detector::feature::Tally;
use crate::detector::search::FoundKeypoint;
use crate::detector::search::setup::FirstLevels;
use crate::plane::Plane;
use std::ops::Range;
use std::sync::Arc;

pub(crate) struct KnownSlopes<'a> {
    /// For each slope of the grid its index in the grid of the earlier search; `None` where it is new.
    pub(crate) slopes: Vec<Option<usize>>,
    /// First levels of each octave at the slopes of the earlier search.
    pub(crate) bases: &'a [FirstLevels],
    /// Keypoints at these slopes, with the indices of this search's grid.
    pub(crate) keypoints: Vec<FoundKeypoint>,
    /// Numbers of samples by slope of the grid; zeros where it is new.
    pub(crate) tallies: Vec<Tally>,
}

impl KnownSlopes<'_> {
    /// First level of the octave `later` octaves after the first at slope `index`, if it is known.
    pub(super) fn first_level(&self, later: usize, index: usize) -> Option<Arc<Plane>> {
        self.slopes[index].map(|earlier| self.bases[later].planes[earlier].clone())
    }

    /// Adds the known keypoints of `octave` to its `tiles`, in the order of one search of all slopes.
    pub(super) fn merge_into(
        &self,
        tiles: &mut [Vec<FoundKeypoint>],
        octave: i32,
        (columns, rows): (Vec<Range<usize>>, Vec<Range<usize>>),
    ) {
        let part = |parts: &[Range<usize>], at: u32| parts.partition_point(|part| part.end <= at as usize);
        for found in self.keypoints.iter().filter(|(keypoint, _)| keypoint.octave == octave) {
            let [x, y] = found.0.sample;
            tiles[part(&rows, y) * columns.len() + part(&columns, x)].push(*found);
        }
        // The sort is stable: keypoints of one slope keep the order in which they were found.
        tiles.iter_mut().for_each(|tile| tile.sort_by_key(|(keypoint, _)| keypoint.slope_index));
    }
}
