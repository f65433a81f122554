//! Masks: which samples of a frame are seen, and fill values for hidden ones.
//!
//! A hidden sample has no weight where frames are averaged, but still a value, because filters read whole rectangles:
//! [`Plane::masked`] fills it smoothly from the seen samples around, so that no mask makes an edge and nothing is NaN.
//! Values are filled from means over squares of 2, 4, 8 … pixels, the coarse ones where little is seen.

use super::{Plane, sample::bilinear, statistics::Region};
use std::ops::{Add, Range};
use std::{borrow::Cow, sync::Arc};

/// Weight of a hidden sample beside 1 for a seen one: it decides only where no frame sees a place.
pub(crate) const HIDDEN_WEIGHT: f32 = 1.0 / 1024.0;
/// Weight from which a sample counts as seen.
const SEEN: f32 = 0.5;
/// Share of hidden samples up to which the noise of a region can be measured.
const NOISE_SHARE: f32 = 0.02;
/// Samples by which the mean of a coarser square counts beside those of a finer one, against noise in the fill.
const COARSER_SAMPLES: f32 = 4.0;

/// Weights of a frame's samples, at least one of which is not wholly seen.
#[derive(Debug, Clone, PartialEq)]
pub struct Mask {
    weights: Plane,
    /// For each row the columns with samples that are not wholly seen, in order, as [`join`] joins them.
    spans: Vec<Vec<Range<usize>>>,
}

impl Mask {
    /// Mask with these weights, from 0 for a hidden sample to 1 for a seen one; `None` where all are seen.
    pub fn new(weights: Plane) -> Option<Arc<Self>> {
        let touched = |v: usize| weights.row(v).iter().enumerate().filter(|(_, weight)| **weight < 1.0);
        let spans: Vec<_> = (0..weights.height()).map(|v| join(touched(v).map(|(u, _)| u..u + 1))).collect();
        spans.iter().any(|spans| !spans.is_empty()).then(|| Arc::new(Self { weights, spans }))
    }

    /// Weights of the samples, 0 … 1; fractions where masks were blurred or halved.
    pub fn weights(&self) -> &Plane {
        &self.weights
    }

    /// Columns of row `v` with samples that are not wholly seen, as [`join`] joins them.
    pub(crate) fn spans(&self, v: usize) -> &[Range<usize>] {
        &self.spans[v]
    }

    /// Whether a sample of `columns` × `rows`, which lie inside, may be one that is not wholly seen.
    pub(crate) fn touches(&self, columns: &Range<usize>, rows: Range<usize>) -> bool {
        let overlaps = |span: &Range<usize>| span.start < columns.end && span.end > columns.start;
        self.spans[rows].iter().flatten().any(overlaps)
    }
}

/// Ranges, ordered by their starts, of which those with less than 32 between them are one: a row that begins and ends
/// hidden has two, and what is seen between them costs nothing.
pub(crate) fn join<I: Ord + Copy + Add<Output = I> + From<u8>>(
    ranges: impl IntoIterator<Item = Range<I>>,
) -> Vec<Range<I>> {
    let mut joined: Vec<Range<I>> = Vec::new();
    for range in ranges {
        match joined.last_mut().filter(|last| range.start < last.end + I::from(32)) {
            Some(last) => last.end = last.end.max(range.end),
            None => joined.push(range),
        }
    }
    joined
}

impl Plane {
    /// Weights of the samples; `None` where all are seen.
    pub fn mask(&self) -> Option<&Arc<Mask>> {
        self.mask.as_ref()
    }

    /// The part of `region`, which lies inside, with its mask.
    pub(crate) fn part(&self, Region { columns, rows }: &Region) -> Self {
        let part = |of: &Self| {
            let at = |u: usize, v: usize| of.at(columns.start + u, rows.start + v);
            Self::from_fn(columns.len(), rows.len(), at)
        };
        part(self).masked(self.mask().and_then(|mask| Mask::new(part(mask.weights()))))
    }

    /// Weight of the sample at column `u`, row `v`: 1 unless a mask hides it.
    pub fn weight_at(&self, u: usize, v: usize) -> f32 {
        self.mask.as_ref().map_or(1.0, |mask| mask.weights.at(u, v))
    }

    /// Whether the sample at column `u`, row `v` is hidden: its weight is below a half.
    pub fn is_hidden_at(&self, u: usize, v: usize) -> bool {
        self.weight_at(u, v) < SEEN
    }

    /// Whether too many samples of `region` are hidden for a measurement of the noise there.
    pub(crate) fn hides(&self, region: &Region) -> bool {
        let Some(mask) = &self.mask else { return false };
        let Region { columns, rows } = region.within(self);
        let row = |v: usize| mask.weights.row(v)[columns.clone()].iter().filter(|weight| **weight < 1.0).count();
        rows.filter(|&v| mask.touches(&columns, v..v + 1)).map(row).sum::<usize>() as f32
            > NOISE_SHARE * region.len() as f32
    }

    /// This plane with a mask of its size, its hidden values filled. `None` removes the mask and changes no value.
    ///
    /// # Panics
    /// When the mask has another size.
    #[must_use]
    pub fn masked(mut self, mask: Option<Arc<Mask>>) -> Self {
        if let Some(mask) = &mask {
            assert_eq!(mask.weights.size(), self.size(), "a mask has the size of its plane");
            fill(&mut self, &mask.weights);
        }
        self.with_mask(mask)
    }

    /// This plane with its NaN masked and filled; any earlier mask is dropped.
    #[must_use]
    pub fn with_nan_masked(self) -> Self {
        let seen = |u: usize, v: usize| f32::from(!self.at(u, v).is_nan());
        let mask = Mask::new(Self::from_fn(self.width, self.height, seen));
        self.masked(mask)
    }

    /// Values of the samples, row by row, NaN where masked.
    pub fn seen_values(&self) -> Cow<'_, [f32]> {
        let Some(mask) = &self.mask else { return Cow::Borrowed(self.data()) };
        let seen = |(value, weight): (&f32, &f32)| if *weight < SEEN { f32::NAN } else { *value };
        self.data().iter().zip(mask.weights.data()).map(seen).collect()
    }

    pub(crate) fn with_mask(self, mask: Option<Arc<Mask>>) -> Self {
        Self { mask, ..self }
    }
}

/// Means of squares of 2×2 of `values` by their numbers of samples, and the sums of these; smaller at an odd end.
fn coarser(values: &Plane, samples: &Plane) -> (Plane, Plane) {
    let (width, height) = values.size();
    let size = (width.div_ceil(2), height.div_ceil(2));
    let (mut means, mut sums) = (Plane::zeros(size.0, size.1), Plane::zeros(size.0, size.1));
    for v in 0..height {
        let (means, sums) = (means.row_mut(v / 2), sums.row_mut(v / 2));
        for (u, (value, count)) in values.row(v).iter().zip(samples.row(v)).enumerate() {
            // A hidden value may be NaN.
            if *count > 0.0 {
                means[u / 2] += count * value;
                sums[u / 2] += count;
            }
        }
    }
    means.data_mut().iter_mut().zip(sums.data()).for_each(|(mean, sum)| *mean /= sum.max(f32::MIN_POSITIVE));
    (means, sums)
}

fn fill(plane: &mut Plane, weights: &Plane) {
    let seen = Plane::from_fn(plane.width(), plane.height(), |u, v| f32::from(weights.at(u, v) >= SEEN));
    let mut levels = vec![coarser(plane, &seen)];
    while let Some((means, sums)) = levels.last().filter(|(means, _)| means.data().len() > 1) {
        levels.push(coarser(means, sums));
    }
    let mut filled: Option<Plane> = None;
    let upper = |filled: &Plane, u: usize, v: usize| {
        bilinear(filled, (u as f32 - 0.5) / 2.0, (v as f32 - 0.5) / 2.0).unwrap_or_default()
    };
    // From coarse to fine: each level leans on the coarser one where it has few samples of its own.
    for (mut means, sums) in levels.into_iter().rev() {
        if let Some(coarse) = &filled {
            let width = means.width();
            for (at, (mean, sum)) in means.data_mut().iter_mut().zip(sums.data()).enumerate() {
                let around = upper(coarse, at % width, at / width);
                *mean = (sum * *mean + COARSER_SAMPLES * around) / (sum + COARSER_SAMPLES);
            }
        }
        filled = Some(means);
    }
    let (width, Some(coarse)) = (plane.width(), filled) else { return };
    let hidden = plane.data_mut().iter_mut().zip(seen.data()).enumerate().filter(|(_, (_, seen))| **seen == 0.0);
    hidden.for_each(|(at, (value, _))| *value = upper(&coarse, at % width, at / width));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synth::random::Stream;

    fn ramp(u: usize, v: usize) -> f32 {
        0.2 + 0.002 * u as f32 + 0.001 * v as f32
    }

    fn disc(u: usize, v: usize) -> f32 {
        f32::from((u as f32 - 30.0).hypot(v as f32 - 25.0) > 12.0)
    }

    #[test]
    fn hidden_values_follow_their_surroundings_and_seen_ones_stay() {
        let mask = Mask::new(Plane::from_fn(97, 61, disc)).expect("a disc is hidden");
        let mut noise = Stream::new(3, 0);
        let frame = Plane::from_fn(97, 61, |u, v| if disc(u, v) > 0.0 { ramp(u, v) } else { f32::NAN });
        let noisy = Plane::from_fn(97, 61, |u, v| frame.at(u, v) + 0.05 * noise.normal() as f32);
        let (filled, of_noisy) = (frame.clone().masked(Some(mask.clone())), noisy.clone().masked(Some(mask.clone())));
        let mut largest = [0.0f32; 2];
        for (u, v) in (0..61).flat_map(|v| (0..97).map(move |u| (u, v))) {
            if disc(u, v) > 0.0 {
                assert_eq!((filled.at(u, v), of_noisy.at(u, v)), (frame.at(u, v), noisy.at(u, v)));
            } else {
                let off = [&filled, &of_noisy].map(|plane| (plane.at(u, v) - ramp(u, v)).abs());
                largest = [0, 1].map(|i| largest[i].max(off[i]));
            }
        }
        assert!(largest[0] < 0.02 && largest[1] < 0.06, "{largest:?}");
        assert_eq!(mask.spans(25).iter().chain(mask.spans(40)).collect::<Vec<_>>(), [&(18..43)]);
    }
}
