//! Steps after the search: of the keypoints on one blob the strongest stays, and those that stay are localised and
//! described.

use crate::detector::describe::octave_inputs::Describing;
use crate::detector::describe::two_motions::{FramesOfOctaves, Motions};
use crate::detector::describe::{self, Described};
use crate::detector::distinct::{self, Blob};
use crate::detector::keypoint::Keypoint;
use crate::detector::params::{DescribeSlope, Distinct};
use crate::detector::scale_space::levels::octave_size;
use crate::detector::search::groups::{FirstLevels, SlopeGroup};
use crate::detector::search::octaves::SEARCH_PART;
use crate::detector::search::setup::Search;
use crate::monitor::{Cancelled, Stage};
use crate::plane::Plane;
use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

impl Search<'_> {
    /// For each keypoint the index of the stronger one that shows the same blob; `None` for those that stay.
    pub(super) fn distinct(
        &self,
        keypoints: &[Keypoint],
        frames: &FramesOfOctaves<'_>,
    ) -> Result<Vec<Option<usize>>, Cancelled> {
        let Distinct::Radius(radius) = self.params.distinct else {
            return Ok(vec![None; keypoints.len()]);
        };
        let blobs: Vec<Blob> = keypoints.iter().map(|keypoint| Blob::of(keypoint, &self.space)).collect();
        let rule = distinct::Rule { radius, scale_ratio: self.params.distinct_scale };
        frames.make(keypoints.iter());
        let motions = Motions {
            frames,
            times: self.times,
            size_image: self.size_image,
            space: &self.space,
            interpolation: self.params.interpolation,
        };
        distinct::covered_by(&blobs, rule, |a, b| motions.are_two(&keypoints[a], &keypoints[b]), self.monitor)
    }

    /// Localises and describes `keypoints`, which are in order of octaves. The first levels are taken from `bases`;
    /// where they were not kept, they are computed again for one of the `groups` of slopes after the other.
    pub(super) fn describe(
        &self,
        octaves: &Range<i32>,
        keypoints: &[Keypoint],
        (bases, groups): (Option<&[FirstLevels]>, &[SlopeGroup]),
        frames: &FramesOfOctaves<'_>,
    ) -> Result<Vec<Described>, Cancelled> {
        let finished = AtomicUsize::new(0);
        let described = |count: usize| {
            let done = (finished.fetch_add(count, Ordering::Relaxed) + count) as f32 / keypoints.len() as f32;
            self.monitor.report(Stage::Describe, SEARCH_PART + (1.0 - SEARCH_PART) * done);
        };
        self.monitor.report(Stage::Describe, SEARCH_PART);
        if let Some(bases) = bases {
            return self.describe_with(octaves, keypoints, bases, (frames, &described));
        }
        let mut found = Vec::with_capacity(keypoints.len() + keypoints.len() / 2);
        for group in groups {
            let numbers: Vec<usize> =
                (0..keypoints.len()).filter(|&number| group.own.contains(&keypoints[number].slope_index)).collect();
            let of_group: Vec<Keypoint> = numbers.iter().map(|&number| keypoints[number]).collect();
            let Some(last) = of_group.last().map(|keypoint| keypoint.octave) else { continue };
            let bases = self.first_levels(octaves.start..last + 1, &group.visited)?;
            let features = self.describe_with(octaves, &of_group, &bases, (frames, &described))?;
            found.extend(features.into_iter().map(|one| Described { keypoint: numbers[one.keypoint], ..one }));
        }
        Ok(found)
    }

    /// First levels of each octave at consecutive slopes; none for the first octave.
    fn first_levels(&self, octaves: Range<i32>, slopes: &Range<usize>) -> Result<Vec<FirstLevels>, Cancelled> {
        let mut planes: Vec<Vec<Plane>> = octaves.clone().map(|_| Vec::new()).collect();
        for slope_index in slopes.clone() {
            let of_slope = self.stack(slope_index).first_levels(octaves.end - 1, self.monitor)?;
            planes[1..].iter_mut().zip(of_slope).for_each(|(planes, plane)| planes.push(plane));
        }
        Ok(planes.into_iter().map(|planes| FirstLevels::new(slopes.start, planes)).collect())
    }

    /// Localises and describes `keypoints` with the first levels `bases`; `described` is called with the number of
    /// further keypoints that are finished.
    fn describe_with(
        &self,
        octaves: &Range<i32>,
        keypoints: &[Keypoint],
        bases: &[FirstLevels],
        (frames, described): (&FramesOfOctaves<'_>, &(dyn Fn(usize) + Sync)),
    ) -> Result<Vec<Described>, Cancelled> {
        let mut found = Vec::with_capacity(keypoints.len() + keypoints.len() / 2);
        let of_octave = |octave: i32| &bases[(octave - octaves.start) as usize];
        let mut first = 0;
        for in_octave in keypoints.chunk_by(|a, b| a.octave == b.octave) {
            let octave = in_octave[0].octave;
            let base = |slope_index: usize| self.base(octave, of_octave(octave), slope_index);
            let finer = |slope_index: usize| self.base(octave - 1, of_octave(octave - 1), slope_index);
            let own_slopes = self.describes_own_slopes(octave).then(|| {
                frames.make(in_octave.iter());
                frames.of(octave)
            });
            let describing = Describing {
                base: &base,
                finer: (octave > octaves.start).then_some(&finer as _),
                offsets: &self.offsets,
                octave,
                size: octave_size(self.size_image, octave),
                size_image: self.size_image,
                grid: self.grid,
                space: &self.space,
                params: self.params,
                own_slopes,
                monitor: self.monitor,
                described,
            };
            found.extend(describing.describe(in_octave, first)?);
            first += in_octave.len();
        }
        Ok(found)
    }

    /// Whether features of `octave` are described at their own slopes: the octave is fine enough to show the
    /// difference.
    pub(super) fn describes_own_slopes(&self, octave: i32) -> bool {
        let step = [self.grid.u.step(), self.grid.v.step()].into_iter().fold(0.0, f32::max);
        let outermost_px = step * 0.5 * (self.times.frame_count as f32 - 1.0);
        self.params.describe_slope == DescribeSlope::Refined
            && describe::misaligned(outermost_px, self.space.sigma_image(octave, 0.0) as f32)
    }
}
