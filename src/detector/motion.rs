//! The motion stack: frames shifted by a slope and averaged (the paper's shift-sum filter H_M).
//!
//! Numerics. Frame `t` is sampled at `x + (t − t0)·λ`. The offset is the same for every pixel, so it splits once into whole pixels and a
//! fraction, and a row of the result is a weighted sum of at most two rows of each frame, read at a whole-pixel distance: contiguous
//! loads, no gather. A frame covers a pixel when the sampling point lies between the centres of its first and last pixel; the sum
//! is divided by the number of frames that do, which keeps borders from darkening. Where no frame covers a pixel (a corner, with diagonal
//! slopes and an even number of frames) the frames' nearest pixels are averaged instead.

use super::params::Interpolation;
use super::slope_grid::Slope;
use crate::monitor::{Cancelled, Monitor};
use crate::plane::Plane;
use multiversion::multiversion;
use rayon::prelude::*;
use std::ops::Range;

/// Where one frame is read: whole pixels and a fraction in [0, 1) in each direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrameOffset {
    /// Whole columns.
    pub whole_u: i64,
    /// Whole rows.
    pub whole_v: i64,
    /// The rest of a column.
    pub part_u: f32,
    /// The rest of a row.
    pub part_v: f32,
}

impl FrameOffset {
    fn new(u_px: f64, v_px: f64, interpolation: Interpolation) -> Self {
        // A fraction under a millionth of a pixel is a rounding error of the slope; without it whole-pixel slopes stay exact.
        let split = |x: f64| match interpolation {
            Interpolation::Nearest => (x.round() as i64, 0.0),
            Interpolation::Linear => {
                let (whole, part) = (x.floor(), x - x.floor());
                if part < 1e-6 {
                    (whole as i64, 0.0)
                } else if part > 1.0 - 1e-6 {
                    (whole as i64 + 1, 0.0)
                } else {
                    (whole as i64, part as f32)
                }
            }
        };
        let ((whole_u, part_u), (whole_v, part_v)) = (split(u_px), split(v_px));
        Self { whole_u, whole_v, part_u, part_v }
    }

    /// Positions `0 … n−1` that this offset keeps inside, as a half-open range: whole offset `whole`, fraction `part`.
    fn covered(whole: i64, part: f32, n: usize) -> Range<usize> {
        let reach = i64::from(part > 0.0);
        let start = (-whole).clamp(0, n as i64);
        let end = (n as i64 - whole - reach).clamp(start, n as i64);
        start as usize..end as usize
    }

    /// Whether the frame covers the pixel (u, v) of an image of `size`.
    pub fn covers(&self, u: usize, v: usize, size: (usize, usize)) -> bool {
        Self::covered(self.whole_u, self.part_u, size.0).contains(&u)
            && Self::covered(self.whole_v, self.part_v, size.1).contains(&v)
    }
}

/// The offsets (t − t0)·λ of `frame_count` frames, in time order.
pub fn frame_offsets(frame_count: usize, slope: Slope, interpolation: Interpolation) -> Vec<FrameOffset> {
    let t0 = (frame_count as f64 - 1.0) / 2.0;
    (0..frame_count)
        .map(|t| {
            let dt = t as f64 - t0;
            FrameOffset::new(dt * f64::from(slope.u), dt * f64::from(slope.v), interpolation)
        })
        .collect()
}

/// `out += weight·row`.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx512dq", "x86_64+avx2+fma", "aarch64+neon"))]
fn add_1(row: &[f32], out: &mut [f32]) {
    for (o, a) in out.iter_mut().zip(row) {
        *o += a;
    }
}

/// `out += (1−part)·a + part·b`.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx512dq", "x86_64+avx2+fma", "aarch64+neon"))]
fn add_2(a: &[f32], b: &[f32], part: f32, out: &mut [f32]) {
    for ((o, a), b) in out.iter_mut().zip(a).zip(b) {
        *o += (1.0 - part) * a + part * b;
    }
}

/// `out +=` the bilinear mean of two rows; `a` and `b` have one value more than `out`.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx512dq", "x86_64+avx2+fma", "aarch64+neon"))]
fn add_4(a: &[f32], b: &[f32], part_u: f32, part_v: f32, out: &mut [f32]) {
    let n = out.len();
    let (a0, a1, b0, b1) = (&a[..n], &a[1..=n], &b[..n], &b[1..=n]);
    for i in 0..n {
        let upper = (1.0 - part_u) * a0[i] + part_u * a1[i];
        let lower = (1.0 - part_u) * b0[i] + part_u * b1[i];
        out[i] += (1.0 - part_v) * upper + part_v * lower;
    }
}

/// The bilinear sample of `frame` for pixel (u, v), its nearest pixels where it doesn't reach.
fn sample_clamped(frame: &Plane, offset: &FrameOffset, u: usize, v: usize) -> f32 {
    let (width, height) = frame.size();
    let at = |du: i64, dv: i64| {
        let x = (u as i64 + offset.whole_u + du).clamp(0, width as i64 - 1);
        let y = (v as i64 + offset.whole_v + dv).clamp(0, height as i64 - 1);
        frame.data()[y as usize * width + x as usize]
    };
    let upper = (1.0 - offset.part_u) * at(0, 0) + offset.part_u * at(1, 0);
    let lower = (1.0 - offset.part_u) * at(0, 1) + offset.part_u * at(1, 1);
    (1.0 - offset.part_v) * upper + offset.part_v * lower
}

/// Row `v`, columns `columns`, of the motion-stack image into `out` (one value a column), for `frames` of one size and their [`frame_offsets`].
pub fn stack_row(frames: &[&Plane], offsets: &[FrameOffset], v: usize, columns: Range<usize>, out: &mut [f32]) {
    let (width, height) = frames[0].size();
    out.fill(0.0);
    // The columns that every frame of this row covers share one divisor; those at the sides are counted one by one.
    let (mut inner, mut rows_covered) = (columns.clone(), 0usize);
    for (frame, offset) in frames.iter().zip(offsets) {
        if !FrameOffset::covered(offset.whole_v, offset.part_v, height).contains(&v) {
            continue;
        }
        rows_covered += 1;
        let covered = FrameOffset::covered(offset.whole_u, offset.part_u, width);
        let covered = covered.start.max(columns.start)..covered.end.min(columns.end);
        inner = inner.start.max(covered.start)..inner.end.min(covered.end);
        if covered.is_empty() {
            continue;
        }
        let y = (v as i64 + offset.whole_v) as usize;
        let x = (covered.start as i64 + offset.whole_u) as usize;
        let n = covered.len();
        let out = &mut out[covered.start - columns.start..covered.end - columns.start];
        match (offset.part_u > 0.0, offset.part_v > 0.0) {
            (false, false) => add_1(&frame.row(y)[x..x + n], out),
            (true, false) => add_2(&frame.row(y)[x..x + n], &frame.row(y)[x + 1..x + 1 + n], offset.part_u, out),
            (false, true) => add_2(&frame.row(y)[x..x + n], &frame.row(y + 1)[x..x + n], offset.part_v, out),
            (true, true) => {
                let (a, b) = (&frame.row(y)[x..=x + n], &frame.row(y + 1)[x..=x + n]);
                add_4(a, b, offset.part_u, offset.part_v, out);
            }
        }
    }
    if rows_covered == 0 || inner.is_empty() {
        inner = columns.start..columns.start;
    } else {
        let scale = 1.0 / rows_covered as f32;
        out[inner.start - columns.start..inner.end - columns.start].iter_mut().for_each(|x| *x *= scale);
    }
    for u in (columns.start..inner.start).chain(inner.end..columns.end) {
        let covering = coverage(offsets, u, v, (width, height));
        let value = &mut out[u - columns.start];
        *value = if covering > 0 {
            *value / covering as f32
        } else {
            let sum: f32 = frames.iter().zip(offsets).map(|(f, o)| sample_clamped(f, o, u, v)).sum();
            sum / frames.len() as f32
        };
    }
}

/// How many frames cover the pixel (u, v) of an image of `size`.
pub fn coverage(offsets: &[FrameOffset], u: usize, v: usize, size: (usize, usize)) -> usize {
    offsets.iter().filter(|o| o.covers(u, v, size)).count()
}

/// The motion-stack image of `frames` (one size, in time order) at `slope`: the mean over the frames that cover a pixel of
/// `F_t(x + (t − t0)·λ)`, with `t0 = (N − 1)/2`. Same size and unit as the frames. Rows in parallel.
///
/// # Errors
/// [`Cancelled`] once `monitor` was cancelled.
///
/// # Panics
/// When there is no frame or the sizes differ.
pub fn motion_stack(
    frames: &[&Plane],
    slope: Slope,
    interpolation: Interpolation,
    monitor: &Monitor,
) -> Result<Plane, Cancelled> {
    let (width, height) = frames[0].size();
    assert!(frames.iter().all(|f| f.size() == (width, height)), "frames of a burst have one size");
    let offsets = frame_offsets(frames.len(), slope, interpolation);
    let mut out = Plane::zeros(width, height);
    if width == 0 || height == 0 {
        return Ok(out);
    }
    out.data_mut().par_chunks_mut(width).enumerate().try_for_each(|(v, row)| {
        monitor.check()?;
        stack_row(frames, &offsets, v, 0..width, row);
        Ok(())
    })?;
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The definition, pixel by pixel.
    fn by_definition(frames: &[&Plane], slope: Slope, interpolation: Interpolation) -> Plane {
        let (width, height) = frames[0].size();
        let offsets = frame_offsets(frames.len(), slope, interpolation);
        Plane::from_fn(width, height, |u, v| {
            let (mut sum, mut count) = (0.0, 0);
            for (frame, offset) in frames.iter().zip(&offsets) {
                let x = u as f32 + offset.whole_u as f32 + offset.part_u;
                let y = v as f32 + offset.whole_v as f32 + offset.part_v;
                if x >= 0.0 && y >= 0.0 && x <= (width - 1) as f32 && y <= (height - 1) as f32 {
                    sum += sample_clamped(frame, offset, u, v);
                    count += 1;
                }
            }
            if count == 0 {
                count = frames.len();
                sum = frames.iter().zip(&offsets).map(|(f, o)| sample_clamped(f, o, u, v)).sum();
            }
            sum / count as f32
        })
    }

    fn texture(t: usize) -> Plane {
        Plane::from_fn(37, 23, |u, v| ((u * 31 + v * 17 + t * 7) % 29) as f32 / 29.0)
    }

    proptest! {
        #[test]
        fn the_fast_rows_are_the_definition(
            n in 1usize..6, u in -9.0f32..9.0, v in -9.0f32..9.0, whole in any::<bool>(), nearest in any::<bool>(),
        ) {
            let slope = if whole { Slope::new(u.round(), v.round()) } else { Slope::new(u, v) };
            let interpolation = if nearest { Interpolation::Nearest } else { Interpolation::Linear };
            let frames: Vec<Plane> = (0..n).map(texture).collect();
            let frames: Vec<&Plane> = frames.iter().collect();
            let fast = motion_stack(&frames, slope, interpolation, &Monitor::default()).expect("not cancelled");
            let slow = by_definition(&frames, slope, interpolation);
            for (a, b) in fast.data().iter().zip(slow.data()) {
                prop_assert!((a - b).abs() < 1e-5, "{a} {b}");
            }
        }
    }

    #[test]
    fn a_moving_point_is_where_it_was_at_mid_burst() {
        let frames: Vec<Plane> =
            (0..5).map(|t| Plane::from_fn(40, 20, |u, v| f32::from(u == 10 + 2 * t && v == 15 - t))).collect();
        let frames: Vec<&Plane> = frames.iter().collect();
        let stack = motion_stack(&frames, Slope::new(2.0, -1.0), Interpolation::Linear, &Monitor::default())
            .expect("not cancelled");
        assert_eq!(stack.at(14, 13), 1.0);
        assert_eq!(stack.data().iter().filter(|&&x| x != 0.0).count(), 1);
    }

    #[test]
    fn borders_are_not_darkened() {
        let frames: Vec<Plane> = (0..4).map(|_| Plane::from_fn(30, 30, |_, _| 0.5)).collect();
        let frames: Vec<&Plane> = frames.iter().collect();
        let stack = motion_stack(&frames, Slope::new(3.3, 2.7), Interpolation::Linear, &Monitor::default())
            .expect("not cancelled");
        assert!(stack.data().iter().all(|x| (x - 0.5).abs() < 1e-6));
    }
}
