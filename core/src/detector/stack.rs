//! Motion stack: frames shifted by a slope and averaged (the paper's shift-sum filter H_M).
//!
//! Frame `t` is sampled at `x + (t − t0)·λ`, where t is the frame's position and t0 the mean of all positions. The
//! offset is constant over the image, so it is split once into whole pixels and a fraction. A frame covers a pixel when
//! the sampling point lies between the centres of its first and last pixel; the sum is divided by the number of
//! covering frames, or, under masks, is the mean of the seen samples. Where no frame covers a pixel (a corner, with
//! diagonal slopes and an even number of frames) the frames' nearest pixels are averaged.

use crate::burst::{Offset, Positions};
use crate::detector::params::{Interpolation, Slope};
use crate::kernel::stack::{FrameOffset, RowStacker};
use crate::monitor::{Cancelled, Monitor};
use crate::plane::Plane;
use crate::plane::tile::Region;
use rayon::prelude::*;
use std::borrow::Borrow;
use std::ops::Range;

/// Positions of a burst's frames, and which of the frames take part.
#[derive(Debug, Clone, PartialEq)]
pub struct FrameTimes {
    /// Positions of the N frames used; t0 is their mean.
    pub positions: Positions,
    /// Indices of the kept frames, in increasing order unless they were [reordered](Self::reordered).
    pub kept: Vec<usize>,
}

impl FrameTimes {
    /// All frames at `positions`.
    pub fn all(positions: Positions) -> Self {
        Self { kept: (0..positions.len()).collect(), positions }
    }

    /// Positions of the kept frames, from mid-burst.
    pub fn from_middle(&self) -> Vec<Offset<f32>> {
        self.kept.iter().map(|&t| self.positions.offset(t).to_f32()).collect()
    }

    /// Standard deviation of the kept frames' positions, frames.
    pub fn spread_frames(&self) -> f32 {
        let [uu, vv, _] = self.moments();
        (uu + vv).sqrt()
    }

    /// Variances of the kept frames' positions along u and v, and their covariance, frames²; along v 0 but for views.
    pub fn moments(&self) -> [f32; 3] {
        let at = self.from_middle();
        let mean = |of: &dyn Fn(&Offset<f32>) -> f32| at.iter().map(of).sum::<f32>() / at.len().max(1) as f32;
        let (u, v) = (mean(&|at| at.u), mean(&|at| at.v));
        [mean(&|at| (at.u - u) * (at.u - u)), mean(&|at| (at.v - v) * (at.v - v)), mean(&|at| (at.u - u) * (at.v - v))]
    }

    /// Times after a permutation: the frame at place i among the kept ones takes the time of the one at `order[i]`.
    ///
    /// # Panics
    /// If `order` is no permutation of their places.
    pub fn reordered(&self, order: &[usize]) -> Self {
        let mut places = order.to_vec();
        places.sort_unstable();
        assert!(places.into_iter().eq(0..self.kept.len()), "{order:?} is no order of {} frames", self.kept.len());
        Self { kept: order.iter().map(|&place| self.kept[place]).collect(), ..self.clone() }
    }

    /// Selects the offsets of the kept frames from those of all frames.
    pub fn of(&self, offsets: Vec<FrameOffset>) -> Vec<FrameOffset> {
        self.kept.iter().map(|&t| offsets[t]).collect()
    }
}

/// Offset (u, v), pixels, as `interpolation` reads it.
fn offset_at(u_px: f64, v_px: f64, interpolation: Interpolation) -> FrameOffset {
    // A fraction under a millionth of a pixel is rounding of the slope; without it whole-pixel slopes are exact.
    let split = |x: f64| match interpolation {
        Interpolation::Nearest => (x.round() as i64, 0.0, 0),
        // Truncating place + 1/2 is its floor, except for places between −1.5 and −0.5, where it gives 0.
        Interpolation::Truncated => ((x + 0.5).floor() as i64, 0.0, i64::from((x + 0.5).fract() != 0.0)),
        Interpolation::Linear => {
            let (whole, part) = (x.floor(), x - x.floor());
            if part < 1e-6 {
                (whole as i64, 0.0, 0)
            } else if part > 1.0 - 1e-6 {
                (whole as i64 + 1, 0.0, 0)
            } else {
                (whole as i64, part as f32, 0)
            }
        }
    };
    let ((whole_u, part_u, before_u), (whole_v, part_v, before_v)) = (split(u_px), split(v_px));
    FrameOffset { whole_u, whole_v, part_u, part_v, before_u, before_v }
}

/// Offsets (t − t0)·λ of frames at `positions`, in time order.
pub fn frame_offsets(positions: &Positions, slope: Slope, interpolation: Interpolation) -> Vec<FrameOffset> {
    shifted_offsets(positions, (f64::from(slope.u), f64::from(slope.v)), 0.0, interpolation)
}

/// Offsets for a slope in the frames' own pixels, with every frame read `shift_px` farther along both axes.
pub(super) fn shifted_offsets(
    positions: &Positions,
    slope_px_per_frame: (f64, f64),
    shift_px: f64,
    interpolation: Interpolation,
) -> Vec<FrameOffset> {
    let offset = |t: usize| {
        let (u, v) = positions.displacement(t, slope_px_per_frame);
        offset_at(u + shift_px, v + shift_px, interpolation)
    };
    (0..positions.len()).map(offset).collect()
}

/// Variances along u and v, pixels², of the blur by linear interpolation in a stack: the mean of f(1 − f).
pub fn interpolation_blur(offsets: &[FrameOffset]) -> (f64, f64) {
    let mean = |part: fn(&FrameOffset) -> f32| {
        let blur = |offset| f64::from(part(offset)) * (1.0 - f64::from(part(offset)));
        offsets.iter().map(blur).sum::<f64>() / offsets.len().max(1) as f64
    };
    (mean(|offset| offset.part_u), mean(|offset| offset.part_v))
}

/// Computes row `v`, columns `columns`, of the motion-stack image into `out`, one value a column.
pub fn stack_row(frames: &[&Plane], offsets: &[FrameOffset], v: usize, columns: Range<usize>, out: &mut [f32]) {
    let stride = out.len();
    RowStacker::new(frames, vec![offsets]).rows(v..v + 1, &columns, &mut [out], stride);
}

/// Number of `frames`, read at the offsets `at`, that cover the pixel (u, v), and the number that see it: each counts
/// as the unmasked share of its samples up to `radius` pixels around.
pub fn coverage(frames: &[impl Borrow<Plane>], at: &[FrameOffset], (u, v): (usize, usize), radius: f32) -> (f32, f32) {
    let covering = frames.iter().map(Borrow::borrow).zip(at);
    let covering = covering.filter(|(frame, offset)| offset.covers(u, v, frame.size()));
    covering.fold((0.0, 0.0), |(all, seen), (frame, offset)| (all + 1.0, seen + offset.weight(frame, (u, v), radius)))
}

/// Computes the motion-stack image of `frames` (one size, in time order) at `positions`, at `slope`: for each pixel the
/// mean of `F_t(x + (t − t0)·λ)` over the frames that cover it, where t is a frame's position and t0 the mean of all.
///
/// # Panics
/// If there is no frame, the sizes differ, or there are fewer positions.
pub fn motion_stack(
    frames: &[&Plane],
    positions: &Positions,
    slope: Slope,
    interpolation: Interpolation,
    monitor: &Monitor,
) -> Result<Plane, Cancelled> {
    stack_part(frames, positions, slope, interpolation, &Region::whole(frames[0]), monitor)
}

/// Part `region` of the [`motion_stack`], bit for bit.
///
/// # Panics
/// As [`motion_stack`], or if the region reaches beyond the frames.
pub fn stack_part(
    frames: &[&Plane],
    positions: &Positions,
    slope: Slope,
    interpolation: Interpolation,
    region: &Region,
    monitor: &Monitor,
) -> Result<Plane, Cancelled> {
    /// Rows made at a time: setting up a sum takes as long as a few rows.
    const BAND: usize = 16;
    assert!(frames.iter().all(|f| f.size() == frames[0].size()), "frames of a burst have one size");
    let offsets = frame_offsets(positions, slope, interpolation);
    let (Region { columns, rows }, width) = (region, region.columns.len());
    let (mut plane, bands) = (Plane::zeros(width, rows.len()), rows.clone().into_par_iter().step_by(BAND));
    // `par_chunks_mut` takes no chunks of length 0.
    plane.data_mut().par_chunks_mut(BAND * width.max(1)).zip(bands).try_for_each(|(band, v)| {
        monitor.check()?;
        let mut stacker = RowStacker::new(frames, vec![&offsets]);
        stacker.rows(v..rows.end.min(v + BAND), columns, &mut [band], width);
        Ok(())
    })?;
    Ok(plane)
}

/// Plane of `size` (columns, rows) whose rows `fill` writes, in parallel.
pub(super) fn by_rows(
    (width, height): (usize, usize),
    fill: impl Fn(usize, &mut [f32]) + Sync,
    monitor: &Monitor,
) -> Result<Plane, Cancelled> {
    let mut plane = Plane::zeros(width, height);
    // `par_chunks_mut` takes no chunks of length 0.
    plane.data_mut().par_chunks_mut(width.max(1)).enumerate().try_for_each(|(v, row)| {
        monitor.check()?;
        fill(v, row);
        Ok(())
    })?;
    Ok(plane)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plane::Mask;
    use crate::plane::mask::HIDDEN_WEIGHT;
    use proptest::prelude::*;

    fn texture(t: usize) -> Plane {
        Plane::from_fn(37, 23, |u, v| ((u * 31 + v * 17 + t * 7) % 29) as f32 / 29.0)
    }

    /// The mean of the seen samples of the frames that cover a pixel, or of all samples where none covers it.
    fn by_definition(frames: &[&Plane], slope: Slope, interpolation: Interpolation) -> Plane {
        let (width, height) = frames[0].size();
        let offsets = frame_offsets(&Positions::even(frames.len()), slope, interpolation);
        Plane::from_fn(width, height, |u, v| {
            let covers = |offset: &FrameOffset| {
                let x = u as f32 + offset.whole_u as f32 + offset.part_u;
                let y = v as f32 + offset.whole_v as f32 + offset.part_v;
                let (first_u, first_v) = (-offset.before_u as f32, -offset.before_v as f32);
                x >= first_u && y >= first_v && x <= (width - 1) as f32 && y <= (height - 1) as f32
            };
            let all = || frames.iter().zip(&offsets);
            let is_covered = all().any(|(_, offset)| covers(offset));
            let read: Vec<_> = all().filter(|(_, offset)| !is_covered || covers(offset)).collect();
            let (mut sum, mut weights) = (0.0, 0.0);
            for ((frame, offset), (du, dv)) in
                read.into_iter().flat_map(|of| [(0, 0), (1, 0), (0, 1), (1, 1)].map(|d| (of, d)))
            {
                let at =
                    |x: usize, whole: i64, d: i64, n: usize| (x as i64 + whole + d).clamp(0, n as i64 - 1) as usize;
                let (x, y) = (at(u, offset.whole_u, du, width), at(v, offset.whole_v, dv, height));
                let part = |d: i64, part: f32| if d == 0 { 1.0 - part } else { part };
                let seen = if is_covered { frame.weight_at(x, y).max(HIDDEN_WEIGHT) } else { 1.0 };
                let weight = part(du, offset.part_u) * part(dv, offset.part_v) * seen;
                (sum, weights) = (sum + weight * frame.at(x, y), weights + weight);
            }
            sum / weights
        })
    }

    proptest! {
        #[test]
        fn bands_of_several_slopes_have_the_bits_of_single_rows(
            along_u in prop::collection::vec(-9.0f32..9.0, 1..4), along_v in prop::collection::vec(-3.0f32..3.0, 1..4),
            whole in any::<bool>(), first in 0usize..20, how in 0usize..3,
        ) {
            let interpolation = [Interpolation::Linear, Interpolation::Nearest, Interpolation::Truncated][how];
            let frames: Vec<Plane> = (0..4).map(texture).collect();
            let frames: Vec<&Plane> = frames.iter().collect();
            let along_v = along_v.into_iter().map(|v| if whole { v.round() } else { v });
            let slopes = along_v.flat_map(|v| along_u.iter().map(move |&u| Slope::new(u, v)));
            let offsets: Vec<_> = slopes.map(|slope| frame_offsets(&Positions::even(4), slope, interpolation)).collect();
            let (rows, columns, stride) = (first..23, 3..37, 48);
            let mut bands = vec![vec![f32::NAN; stride * rows.len()]; offsets.len()];
            let mut outs: Vec<&mut [f32]> = bands.iter_mut().map(|band| &mut band[..]).collect();
            let mut stacker = RowStacker::new(&frames, offsets.iter().map(|of| &of[..]).collect());
            stacker.rows(rows.clone(), &columns, &mut outs, stride);
            for (band, offsets) in bands.iter().zip(&offsets) {
                for (row, v) in band.chunks(stride).zip(rows.clone()) {
                    let mut alone = vec![0.0; columns.len()];
                    stack_row(&frames, offsets, v, columns.clone(), &mut alone);
                    prop_assert_eq!(&row[..columns.len()], &alone[..]);
                    prop_assert!(row[columns.len()..].iter().all(|x| x.is_nan()), "no other values are written");
                }
            }
        }

        #[test]
        fn the_fast_rows_are_the_mean_of_the_seen_samples(
            n in 1usize..6, u in -9.0f32..9.0, v in -9.0f32..9.0, whole in any::<bool>(), how in 0usize..3,
            masked in prop_oneof![Just(0), any::<u64>()],
        ) {
            let slope = if whole { Slope::new(u.round(), v.round()) } else { Slope::new(u, v) };
            let monitor = Monitor::default();
            let interpolation = [Interpolation::Linear, Interpolation::Nearest, Interpolation::Truncated][how];
            // Some frames have masks of rectangles, others of single samples, others none.
            let mask = |t: usize| Mask::new(Plane::from_fn(37, 23, |u, v| f32::from(match masked >> (2 * t) & 3 {
                0 => true,
                1 => !(5 * t..20).contains(&u) || v < 7,
                _ => !((u * 7 + v * 13 + t) as u64 ^ masked).is_multiple_of(5),
            })));
            let frames: Vec<Plane> = (0..n).map(|t| texture(t).masked(mask(t))).collect();
            let frames: Vec<&Plane> = frames.iter().collect();
            let fast = motion_stack(&frames, &Positions::even(n), slope, interpolation, &monitor).expect("not cancelled");
            let region = Region { columns: 3..20, rows: 2..21 };
            let part = stack_part(&frames, &Positions::even(n), slope, interpolation, &region, &monitor);
            let part = part.expect("not cancelled");
            region.rows.for_each(|v| assert_eq!(part.row(v - 2), &fast.row(v)[3..20], "the whole has the same bits"));
            for (a, b) in fast.data().iter().zip(by_definition(&frames, slope, interpolation).data()) {
                prop_assert!((a - b).abs() < 1e-5, "{a} {b}");
            }
        }
    }

    #[test]
    fn truncated_places_are_those_of_a_cast_to_an_integer() {
        for offset_px in [-2.0, -1.5, -1.2, -1.0, -0.5, -0.3, 0.0, 0.4, 0.5, 1.0, 1.7f64] {
            let offset = offset_at(offset_px, 0.0, Interpolation::Truncated);
            for u in 0..8 {
                let cast = (u as f64 + offset_px + 0.5) as i64;
                let covers = (0..8).contains(&cast) && u as f64 + offset_px + 0.5 > -1.0;
                assert_eq!(offset.covers(u, 0, (8, 8)), covers, "{offset_px} {u}");
                assert!(!covers || (u as i64 + offset.whole_u).max(0) == cast, "{offset_px} {u}");
            }
        }
    }
}
