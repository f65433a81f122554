//! Ways to combine the shifted frames at a slope: the mean, for the detector, and others, for structure in some frames.
//!
//! The values of the frames that cover a pixel are sorted. The mean is that of [`motion_stack`], to the bit.

use super::stack::{by_rows, frame_offsets, motion_stack};
use crate::burst::Positions;
use crate::detector::params::{Interpolation, Slope};
use crate::kernel::stack::{FrameOffset, sample_clamped};
use crate::monitor::{Cancelled, Monitor};
use crate::plane::Plane;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// A way to combine the values that the frames have at a place.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
#[serde(rename_all = "kebab-case")]
pub enum Combine {
    /// Mean.
    #[default]
    Mean,
    /// Median; of an even number of values the mean of the two in the middle.
    Median,
    /// Mean of the values within [`CLIP_SIGMAS`] standard deviations of the median. The standard deviation is that of a
    /// normal distribution with the same quartiles.
    ClippedMean,
    /// Largest value.
    Max,
    /// Smallest value.
    Min,
    /// Standard deviation around the mean; 0 for one value.
    Deviation,
    /// Mean minus median: above 0 where some frames are brighter than most.
    MeanMinusMedian,
}

/// Standard deviations from the median within which values count for the clipped mean.
pub const CLIP_SIGMAS: f32 = 2.5;
/// Distance of the quartiles of a normal distribution, in standard deviations.
const QUARTILES: f32 = 1.348_98;

impl Combine {
    /// All ways.
    pub const ALL: [Self; 7] =
        [Self::Mean, Self::Median, Self::ClippedMean, Self::Max, Self::Min, Self::Deviation, Self::MeanMinusMedian];

    /// Combination of sorted values; at least one.
    fn of_sorted(self, sorted: &[f32]) -> f32 {
        let n = sorted.len();
        let mean = || sorted.iter().sum::<f32>() / n as f32;
        let median = 0.5 * (sorted[(n - 1) / 2] + sorted[n / 2]);
        match self {
            Self::Mean => mean(),
            Self::Median => median,
            Self::ClippedMean => {
                // From quartiles: values to be clipped would widen a standard deviation.
                let limit = CLIP_SIGMAS / QUARTILES * (sorted[n - 1 - n / 4] - sorted[n / 4]);
                let near = sorted.iter().filter(|x| (**x - median).abs() <= limit);
                let (sum, count) = near.fold((0.0, 0.0), |(sum, count), x| (sum + x, count + 1.0));
                if count > 0.0 { sum / count } else { median }
            }
            Self::Max => sorted[n - 1],
            Self::Min => sorted[0],
            Self::Deviation => {
                let mean = mean();
                (sorted.iter().map(|x| (x - mean) * (x - mean)).sum::<f32>() / (n.max(2) - 1) as f32).sqrt()
            }
            Self::MeanMinusMedian => mean() - median,
        }
    }
}

/// Combines `frames` (one size, in time order) at `positions`, at `slope`: for each pixel x the values
/// F_t(x + (t − t0)·λ) of the frames that see it, in the frames' size and unit. Rows in parallel.
pub fn combined_stack(
    frames: &[&Plane],
    positions: &Positions,
    slope: Slope,
    interpolation: Interpolation,
    combine: Combine,
    monitor: &Monitor,
) -> Result<Plane, Cancelled> {
    // The mean comes from the search's own code, so that the two never differ by a bit.
    if combine == Combine::Mean {
        return motion_stack(frames, positions, slope, interpolation, monitor);
    }
    let (width, height) = frames[0].size();
    let offsets = frame_offsets(positions, slope, interpolation);
    let covered: Vec<(&Plane, &FrameOffset, Range<usize>, Range<usize>)> = frames
        .iter()
        .zip(&offsets)
        .map(|(frame, offset)| (*frame, offset, offset.covers_rows(height), offset.covers_columns(width)))
        .collect();
    let fill = |v: usize, row: &mut [f32]| {
        let mut values = Vec::with_capacity(frames.len());
        for (u, out) in row.iter_mut().enumerate() {
            values.clear();
            let covering = covered.iter().filter(|(.., rows, columns)| rows.contains(&v) && columns.contains(&u));
            let seeing = covering.filter(|(frame, offset, ..)| offset.weight(frame, (u, v), 0.0) >= 0.5);
            values.extend(seeing.map(|(frame, offset, ..)| sample_clamped(frame, offset, u, v)));
            // Where every frame is hidden or outside, the nearest pixels of all frames stand in.
            if values.is_empty() {
                values.extend(covered.iter().map(|(frame, offset, ..)| sample_clamped(frame, offset, u, v)));
            }
            values.sort_unstable_by(f32::total_cmp);
            *out = combine.of_sorted(&values);
        }
    };
    by_rows((width, height), fill, monitor)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn every_way_is_its_definition() {
        let of = |values: &[f32]| Combine::ALL.map(|combine| combine.of_sorted(values));
        assert_eq!(of(&[3.0]), [3.0, 3.0, 3.0, 3.0, 3.0, 0.0, 0.0]);
        let deviation = (2.0f32 * (1.5 * 1.5 + 0.5 * 0.5) / 3.0).sqrt();
        assert_eq!(of(&[1.0, 2.0, 3.0, 4.0]), [2.5, 2.5, 2.5, 4.0, 1.0, deviation, 0.0]);
        // The quartiles are 1 and 2, so what is farther from 1.5 than 1.9 does not count.
        assert_eq!(of(&[1.0, 1.0, 2.0, 12.0])[2], 4.0 / 3.0);
    }

    proptest! {
        #[test]
        fn only_frames_that_cover_a_pixel_count(n in 1usize..9, u in -4.0f32..4.0, v in -4.0f32..4.0) {
            let slope = Slope::new(u, v);
            let frames: Vec<Plane> =
                (0..n).map(|t| Plane::from_fn(37, 23, |u, v| ((u * 31 + v * 17 + t * 41) % 29) as f32 / 29.0)).collect();
            let frames: Vec<&Plane> = frames.iter().collect();
            let positions = Positions::even(n);
            let (linear, monitor) = (Interpolation::Linear, Monitor::default());
            let of = |combine| combined_stack(&frames, &positions, slope, linear, combine, &monitor).expect("done");
            // The mean is computed elsewhere, frame by frame.
            let (mean, difference) = (of(Combine::Mean), of(Combine::MeanMinusMedian));
            let [median, max, min, clipped] = [Combine::Median, Combine::Max, Combine::Min, Combine::ClippedMean].map(of);
            for at in 0..37 * 23 {
                let [mean, median, clipped] = [&mean, &median, &clipped].map(|plane| plane.data()[at]);
                prop_assert!((mean - median - difference.data()[at]).abs() < 1e-5, "{at}");
                let range = min.data()[at] - 1e-6..=max.data()[at] + 1e-6;
                prop_assert!([median, clipped].iter().all(|value| range.contains(value)), "{at}");
                let covers = |offset: &FrameOffset| offset.covers(at % 37, at / 37, (37, 23));
                if frame_offsets(&positions, slope, Interpolation::Linear).iter().filter(|offset| covers(offset)).count() == 1 {
                    prop_assert_eq!(min.data()[at], max.data()[at]);
                }
            }
        }
    }
}
