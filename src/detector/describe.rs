//! Orientations and descriptors, on the Gaussian level of the feature's own motion-stack image.
//!
//! As in VLFeat: a histogram of 36 gradient directions within 4.5σ, weighted by a Gaussian of 1.5σ, smoothed six times, whose peaks of at least 0.8 of the
//! highest give the orientations, interpolated by a parabola; then 4×4 cells of 3σ, each a histogram of 8 directions, filled
//! with trilinear weights under a Gaussian of two cells. The 128 numbers are normalised, cut at 0.2, normalised again, then
//! L1-normalised, square-rooted ("RootSIFT"), multiplied by 512 and cut at 255.
//!
//! Only a patch around each feature is made: stacked (or cut from the octave's stored first level), blurred to the level, differentiated.

use super::feature::Descriptor;
use super::octave::Base;
use super::scale_space::ScaleSpace;
use crate::plane::Plane;
use std::f32::consts::TAU;

const ORIENTATION_BINS: usize = 36;
const CELLS: usize = 4;
const DIRECTIONS: usize = 8;
/// Size of a cell, in σ.
const MAGNIFICATION: f32 = 3.0;

/// Gradients around a feature, in octave pixels.
#[derive(Debug)]
pub struct GradientPatch {
    /// Column and row of the octave at which the patch begins.
    left: usize,
    top: usize,
    /// The octave's size.
    size: (usize, usize),
    width: usize,
    magnitude: Vec<f32>,
    /// Radians in [0, 2π), from +u towards +v.
    angle: Vec<f32>,
}

/// Half the side of the square that a descriptor of scale `sigma` (octave pixels) looks at.
fn descriptor_radius(sigma: f32) -> i64 {
    (std::f32::consts::SQRT_2 * MAGNIFICATION * sigma * (CELLS as f32 + 1.0) / 2.0 + 0.5).floor() as i64
}

impl GradientPatch {
    /// The gradients that orientation and descriptor of a feature at (x, y) with scale `sigma` (octave pixels of an octave of `size`) need, on
    /// Gaussian level `level`.
    pub fn around(
        base: &Base<'_>,
        space: &ScaleSpace,
        size: (usize, usize),
        (x, y): (f32, f32),
        sigma: f32,
        level: i32,
    ) -> Self {
        let radius = descriptor_radius(sigma) + 2;
        let span = |centre: f32, n: usize| {
            let middle = (centre + 0.5) as i64;
            (middle - radius).clamp(0, n as i64 - 1) as usize..(middle + radius + 1).clamp(1, n as i64) as usize
        };
        let (columns, rows) = (span(x, size.0), span(y, size.1));
        let (left, top) = (columns.start, rows.start);
        let sigma_level = space.sigma_octave(f64::from(level));
        Self::of(&base.level_patch(size, columns, rows, sigma_level, space.kernel_cut), (left, top), size)
    }

    /// The gradients of a `patch` whose first pixel is (left, top) of an octave of `size`. Central differences, one-sided at the patch's border.
    pub fn of(patch: &Plane, (left, top): (usize, usize), size: (usize, usize)) -> Self {
        let (width, height) = patch.size();
        let mut magnitude = Vec::with_capacity(width * height);
        let mut angle = Vec::with_capacity(width * height);
        for v in 0..height {
            let (above, below) = (patch.row(v.saturating_sub(1)), patch.row((v + 1).min(height - 1)));
            let row = patch.row(v);
            let scale_v = if v == 0 || v + 1 == height { 1.0 } else { 0.5 };
            for u in 0..width {
                let (before, after) = (u.saturating_sub(1), (u + 1).min(width - 1));
                let scale_u = if u == 0 || u + 1 == width { 1.0 } else { 0.5 };
                let (gu, gv) = (scale_u * (row[after] - row[before]), scale_v * (below[u] - above[u]));
                magnitude.push((gu * gu + gv * gv).sqrt());
                let direction = gv.atan2(gu);
                angle.push(if direction < 0.0 { direction + TAU } else { direction });
            }
        }
        Self { left, top, size, width, magnitude, angle }
    }

    /// Calls `f(column, row, magnitude, angle)` for the octave's pixels within `radius` of the pixel (xi, yi), except the image's rim.
    fn for_each_within(&self, (xi, yi): (i64, i64), radius: i64, mut f: impl FnMut(i64, i64, f32, f32)) {
        let rows = (yi - radius).max(1)..=(yi + radius).min(self.size.1 as i64 - 2);
        for row in rows {
            let line = (row as usize - self.top) * self.width;
            for column in (xi - radius).max(1)..=(xi + radius).min(self.size.0 as i64 - 2) {
                let at = line + column as usize - self.left;
                f(column, row, self.magnitude[at], self.angle[at]);
            }
        }
    }

    /// The orientations of a feature at (x, y), scale `sigma`, in octave pixels: radians in [0, 2π), strongest first, at most `most` (1 … 4).
    /// Without any gradient the only orientation is 0.
    pub fn orientations(&self, x: f32, y: f32, sigma: f32, most: usize) -> Vec<f32> {
        let window = 1.5 * sigma;
        let radius = (3.0 * window).floor().max(1.0) as i64;
        let (xi, yi) = ((x + 0.5) as i64, (y + 0.5) as i64);
        let mut histogram = [0.0f32; ORIENTATION_BINS];
        let reach = (radius * radius) as f32 + 0.6;
        self.for_each_within((xi, yi), radius, |column, row, magnitude, angle| {
            let (du, dv) = (column as f32 - x, row as f32 - y);
            let r2 = du * du + dv * dv;
            if r2 >= reach {
                return;
            }
            let weight = (-r2 / (2.0 * window * window)).exp() * magnitude;
            let at = ORIENTATION_BINS as f32 * angle / TAU - 0.5;
            let bin = at.floor();
            let share = at - bin;
            let bin = bin as i64 + ORIENTATION_BINS as i64;
            histogram[(bin as usize) % ORIENTATION_BINS] += (1.0 - share) * weight;
            histogram[(bin as usize + 1) % ORIENTATION_BINS] += share * weight;
        });
        for _ in 0..6 {
            let before = histogram;
            for (i, out) in histogram.iter_mut().enumerate() {
                let (a, b) =
                    (before[(i + ORIENTATION_BINS - 1) % ORIENTATION_BINS], before[(i + 1) % ORIENTATION_BINS]);
                *out = (a + before[i] + b) / 3.0;
            }
        }
        let highest = histogram.iter().copied().fold(0.0, f32::max);
        let mut peaks: Vec<(f32, f32)> = Vec::new();
        for i in 0..ORIENTATION_BINS {
            let here = histogram[i];
            let before = histogram[(i + ORIENTATION_BINS - 1) % ORIENTATION_BINS];
            let after = histogram[(i + 1) % ORIENTATION_BINS];
            if here > 0.8 * highest && here > before && here > after {
                let offset = -0.5 * (after - before) / (after + before - 2.0 * here);
                peaks.push((here, TAU * (i as f32 + offset + 0.5) / ORIENTATION_BINS as f32));
            }
        }
        peaks.sort_by(|a, b| b.0.total_cmp(&a.0));
        peaks.truncate(most);
        if peaks.is_empty() { vec![0.0] } else { peaks.into_iter().map(|(_, angle)| angle.rem_euclid(TAU)).collect() }
    }

    /// The descriptor of a feature at (x, y), scale `sigma`, in octave pixels, turned by `orientation` radians.
    pub fn descriptor(&self, x: f32, y: f32, sigma: f32, orientation: f32) -> Descriptor {
        let cell = MAGNIFICATION * sigma + f32::EPSILON;
        let (sin, cos) = orientation.sin_cos();
        let half = CELLS as i64 / 2;
        let mut bins = [0.0f32; CELLS * CELLS * DIRECTIONS];
        let (xi, yi) = ((x + 0.5) as i64, (y + 0.5) as i64);
        self.for_each_within((xi, yi), descriptor_radius(sigma), |column, row, magnitude, angle| {
            let (du, dv) = (column as f32 - x, row as f32 - y);
            let (nx, ny) = ((cos * du + sin * dv) / cell, (cos * dv - sin * du) / cell);
            // Farther than 2.5 cells nothing is added.
            if nx.abs() >= 2.5 || ny.abs() >= 2.5 {
                return;
            }
            let turned = DIRECTIONS as f32 * (angle - orientation).rem_euclid(TAU) / TAU;
            // A Gaussian of half the descriptor's width, which is two cells.
            let weight = magnitude * (-(nx * nx + ny * ny) / 8.0).exp();
            let (bx, by, bt) = ((nx - 0.5).floor(), (ny - 0.5).floor(), turned.floor());
            let (rx, ry, rt) = (nx - bx - 0.5, ny - by - 0.5, turned - bt);
            for (dx, wx) in [(0, 1.0 - rx), (1, rx)] {
                let cell_x = bx as i64 + dx + half;
                if !(0..CELLS as i64).contains(&cell_x) {
                    continue;
                }
                for (dy, wy) in [(0, 1.0 - ry), (1, ry)] {
                    let cell_y = by as i64 + dy + half;
                    if !(0..CELLS as i64).contains(&cell_y) {
                        continue;
                    }
                    let at = (cell_y as usize * CELLS + cell_x as usize) * DIRECTIONS;
                    let weight = weight * wx * wy;
                    bins[at + bt as usize % DIRECTIONS] += weight * (1.0 - rt);
                    bins[at + (bt as usize + 1) % DIRECTIONS] += weight * rt;
                }
            }
        });
        quantise(bins)
    }
}

fn normalise(bins: &mut [f32; 128]) {
    let norm = bins.iter().map(|x| x * x).sum::<f32>().sqrt();
    if norm > 0.0 {
        bins.iter_mut().for_each(|x| *x /= norm);
    }
}

/// From the 128 sums to bytes, in UBC/COLMAP's order: within each cell the directions run the other way round than VLFeat's, the first stays.
fn quantise(mut bins: [f32; 128]) -> Descriptor {
    normalise(&mut bins);
    bins.iter_mut().for_each(|x| *x = x.min(0.2));
    normalise(&mut bins);
    let sum: f32 = bins.iter().sum();
    let mut out = [0; 128];
    if sum <= 0.0 {
        return out;
    }
    for (cell, values) in bins.chunks(DIRECTIONS).enumerate() {
        for (direction, value) in values.iter().enumerate() {
            let byte = ((value / sum).sqrt() * 512.0).round().min(255.0) as u8;
            out[cell * DIRECTIONS + (DIRECTIONS - direction) % DIRECTIONS] = byte;
        }
    }
    out
}

/// The same descriptor in VLFeat's order; its own inverse.
pub fn to_vlfeat_order(descriptor: &Descriptor) -> Descriptor {
    std::array::from_fn(|i| {
        let (cell, direction) = (i / DIRECTIONS, i % DIRECTIONS);
        descriptor[cell * DIRECTIONS + (DIRECTIONS - direction) % DIRECTIONS]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn patch_of(f: impl Fn(f32, f32) -> f32) -> GradientPatch {
        let plane = Plane::from_fn(101, 101, |u, v| f(u as f32 - 50.0, v as f32 - 50.0));
        GradientPatch::of(&plane, (0, 0), (101, 101))
    }

    #[test]
    fn a_ramp_has_the_direction_in_which_it_rises() {
        for degrees in [3.0f32, 47.0, 95.0, 181.0, 275.0, 344.0] {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let patch = patch_of(|u, v| 0.01 * (cos * u + sin * v));
            let found = patch.orientations(50.0, 50.0, 2.0, 4);
            assert_eq!(found.len(), 1);
            assert!((found[0].to_degrees() - degrees).abs() < 0.5, "{degrees}: {}", found[0].to_degrees());
        }
    }

    #[test]
    fn a_turned_pattern_has_the_same_descriptor() {
        let pattern = |u: f32, v: f32| (-((u - 4.0).powi(2) + (v + 3.0).powi(2)) / 40.0).exp() + 0.02 * u;
        let straight = patch_of(pattern).descriptor(50.0, 50.0, 2.5, 0.0);
        let angle = 0.7f32;
        let (sin, cos) = angle.sin_cos();
        let turned = patch_of(|u, v| pattern(cos * u + sin * v, cos * v - sin * u)).descriptor(50.0, 50.0, 2.5, angle);
        let worst = straight.iter().zip(turned).map(|(a, b)| a.abs_diff(b)).max();
        assert!(worst <= Some(8), "{worst:?}");
    }

    #[test]
    fn descriptors_are_root_normalised() {
        let patch = patch_of(|u, v| (0.3 * u).sin() + (0.2 * v + 0.1 * u).cos());
        let descriptor = patch.descriptor(50.2, 49.7, 3.0, 1.0);
        let energy: f32 = descriptor.iter().map(|&x| (f32::from(x) / 512.0).powi(2)).sum();
        assert!((energy - 1.0).abs() < 0.02, "{energy}");
        assert_eq!(to_vlfeat_order(&to_vlfeat_order(&descriptor)), descriptor);
    }

    #[test]
    fn nothing_to_see_gives_zeros() {
        let patch = patch_of(|_, _| 0.4);
        assert_eq!(patch.orientations(50.0, 50.0, 2.0, 4), vec![0.0]);
        assert_eq!(patch.descriptor(50.0, 50.0, 2.0, 0.0), [0; 128]);
    }
}
