//! Orientations and descriptors, on the Gaussian level of the feature's own motion-stack image.
//!
//! As in VLFeat: a histogram of 36 gradient directions within 4.5σ, weighted by a Gaussian of 1.5σ, smoothed six times, whose peaks of at least 0.8 of the
//! highest give the orientations, interpolated by a parabola; then 4×4 cells of 3σ, each a histogram of 8 directions, filled
//! with trilinear weights under a Gaussian of two cells. The 128 numbers are normalised, cut at 0.2, normalised again, then
//! L1-normalised, square-rooted ("RootSIFT"), multiplied by 512 and cut at 255.
//!
//! Only a patch around each feature is made: stacked (or cut from the octave's stored first level), blurred to the level, differentiated.

use super::feature::Descriptor;
use super::octave::widened;
use super::patch::RawPatch;
use crate::plane::Plane;
use crate::plane::blur::GaussianKernel;
use multiversion::multiversion;
use std::f32::consts::TAU;
use std::ops::Range;

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

/// Half the side of the square whose gradients [`GradientPatch::around`] needs for a feature of scale `sigma`, octave pixels.
pub fn gradient_radius(sigma: f32) -> usize {
    descriptor_radius(sigma) as usize + 2
}

/// The columns (or rows) within `radius` of `centre`, inside an octave of `n`.
pub fn span(centre: f32, radius: usize, n: usize) -> Range<usize> {
    let middle = ((centre + 0.5).max(0.0) as usize).min(n - 1);
    widened(&(middle..middle + 1), radius, n)
}

/// Magnitudes and angles of one row's gradients from the rows above and below; `scale_v` is 1 over their distance.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx512dq", "x86_64+avx2+fma", "aarch64+neon"))]
fn gradient_row(above: &[f32], row: &[f32], below: &[f32], scale_v: f32, magnitude: &mut [f32], angle: &mut [f32]) {
    let n = row.len();
    if n < 3 {
        // An octave has at least 16 columns; such a patch has nothing to say.
        return;
    }
    let inner = n - 2;
    let (before, after) = (&row[..inner], &row[2..]);
    let (above_in, below_in) = (&above[1..=inner], &below[1..=inner]);
    {
        let (m, a) = (&mut magnitude[1..=inner], &mut angle[1..=inner]);
        for i in 0..inner {
            let gu = 0.5 * (after[i] - before[i]);
            let gv = scale_v * (below_in[i] - above_in[i]);
            m[i] = (gu * gu + gv * gv).sqrt();
            a[i] = direction(gv, gu);
        }
    }
    for (u, gu) in [(0, row[1] - row[0]), (n - 1, row[n - 1] - row[n - 2])] {
        let gv = scale_v * (below[u] - above[u]);
        magnitude[u] = (gu * gu + gv * gv).sqrt();
        angle[u] = direction(gv, gu);
    }
}

/// The direction of (gu, gv) in [0, 2π), to 2·10⁻⁶ radians: a minimax polynomial for the arctangent on [0, 1], without branches so that it
/// runs in vector lanes.
#[inline(always)]
fn direction(gv: f32, gu: f32) -> f32 {
    let (x, y) = (gu.abs(), gv.abs());
    let (small, large) = (x.min(y), x.max(y));
    let a = small / large.max(f32::MIN_POSITIVE);
    let s = a * a;
    let mut r = -0.011_721_2;
    r = r * s + 0.052_653_32;
    r = r * s - 0.116_432_87;
    r = r * s + 0.193_543_46;
    r = r * s - 0.332_623_47;
    r = r * s + 0.999_977_26;
    r *= a;
    r = if y > x { std::f32::consts::FRAC_PI_2 - r } else { r };
    r = if gu < 0.0 { std::f32::consts::PI - r } else { r };
    r = if gv < 0.0 { TAU - r } else { r };
    if r >= TAU { 0.0 } else { r }
}

/// exp(−d²/(2·sigma²)) of the distances of `range` from `centre`.
fn window(range: Range<i64>, centre: f32, sigma: f32) -> Vec<f32> {
    let scale = -0.5 / (sigma * sigma);
    range.map(|at| (scale * (at as f32 - centre).powi(2)).exp()).collect()
}

impl GradientPatch {
    /// The gradients that orientation and descriptor of a feature at (x, y) with scale `sigma` need, from the pixels around it (which reach
    /// [`gradient_radius`] and the kernel's radius) blurred by `kernel` to the feature's Gaussian level. All in octave pixels.
    pub fn around(raw: &RawPatch, (x, y): (f32, f32), sigma: f32, kernel: &GaussianKernel) -> Self {
        let (columns, rows) =
            (span(x, gradient_radius(sigma), raw.size.0), span(y, gradient_radius(sigma), raw.size.1));
        let corner = (columns.start, rows.start);
        Self::of(&raw.blurred(columns, rows, kernel), corner, raw.size)
    }

    /// The gradients of a `patch` whose first pixel is (left, top) of an octave of `size`. Central differences, one-sided at the patch's border.
    pub fn of(patch: &Plane, (left, top): (usize, usize), size: (usize, usize)) -> Self {
        let (width, height) = patch.size();
        let mut magnitude = vec![0.0; width * height];
        let mut angle = vec![0.0; width * height];
        for (v, (magnitude, angle)) in magnitude.chunks_mut(width).zip(angle.chunks_mut(width)).enumerate() {
            let (above, below) = (patch.row(v.saturating_sub(1)), patch.row((v + 1).min(height - 1)));
            let scale_v = if v == 0 || v + 1 == height { 1.0 } else { 0.5 };
            gradient_row(above, patch.row(v), below, scale_v, magnitude, angle);
        }
        Self { left, top, size, width, magnitude, angle }
    }

    /// The octave's columns (or rows) within `radius` of `centre`, except the image's rim.
    fn reach(centre: i64, radius: i64, n: usize) -> Range<i64> {
        (centre - radius).max(1)..(centre + radius + 1).min(n as i64 - 1)
    }

    /// Magnitudes and angles of a row's `columns`.
    fn line(&self, row: i64, columns: &Range<i64>) -> (&[f32], &[f32]) {
        let start = (row as usize - self.top) * self.width + columns.start as usize - self.left;
        let end = start + (columns.end - columns.start) as usize;
        (&self.magnitude[start..end], &self.angle[start..end])
    }

    /// The orientations of a feature at (x, y), scale `sigma`, in octave pixels: radians in [0, 2π), strongest first, at most `most` (1 … 4).
    /// Without any gradient the only orientation is 0.
    pub fn orientations(&self, x: f32, y: f32, sigma: f32, most: usize) -> Vec<f32> {
        let spread = 1.5 * sigma;
        let radius = (3.0 * spread).floor().max(1.0) as i64;
        let columns = Self::reach((x + 0.5) as i64, radius, self.size.0);
        let rows = Self::reach((y + 0.5) as i64, radius, self.size.1);
        if columns.is_empty() {
            return vec![0.0];
        }
        let mut histogram = [0.0f32; ORIENTATION_BINS];
        let reach = (radius * radius) as f32 + 0.6;
        let (along_u, along_v) = (window(columns.clone(), x, spread), window(rows.clone(), y, spread));
        for (row, weight_v) in rows.zip(along_v) {
            let dv = row as f32 - y;
            let (magnitudes, angles) = self.line(row, &columns);
            for ((column, weight_u), (magnitude, angle)) in
                columns.clone().zip(&along_u).zip(magnitudes.iter().zip(angles))
            {
                let du = column as f32 - x;
                if du * du + dv * dv >= reach {
                    continue;
                }
                let weight = weight_u * weight_v * magnitude;
                // Shifted by a turn so that the whole part is positive.
                let at = angle * (ORIENTATION_BINS as f32 / TAU) + (ORIENTATION_BINS as f32 - 0.5);
                let bin = at as usize;
                let share = at - bin as f32;
                histogram[bin % ORIENTATION_BINS] += (1.0 - share) * weight;
                histogram[(bin + 1) % ORIENTATION_BINS] += share * weight;
            }
        }
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

    /// The descriptor of a feature at (x, y), scale `sigma`, in octave pixels, turned by `orientation` radians in [0, 2π).
    pub fn descriptor(&self, x: f32, y: f32, sigma: f32, orientation: f32) -> Descriptor {
        const PADDED: usize = CELLS + 2;
        let cell = MAGNIFICATION * sigma + f32::EPSILON;
        let (sin, cos) = orientation.sin_cos();
        let (sin, cos) = (sin / cell, cos / cell);
        // A cell more on each side takes what falls outside, so that no weight needs a test.
        let mut bins = [0.0f32; PADDED * PADDED * DIRECTIONS];
        let radius = descriptor_radius(sigma);
        let columns = Self::reach((x + 0.5) as i64, radius, self.size.0);
        let rows = Self::reach((y + 0.5) as i64, radius, self.size.1);
        if columns.is_empty() {
            return quantise([0.0; 128]);
        }
        // A Gaussian of half the descriptor's width, which is two cells.
        let (along_u, along_v) = (window(columns.clone(), x, 2.0 * cell), window(rows.clone(), y, 2.0 * cell));
        for (row, weight_v) in rows.zip(along_v) {
            let dv = row as f32 - y;
            let (magnitudes, angles) = self.line(row, &columns);
            for ((column, weight_u), (magnitude, angle)) in
                columns.clone().zip(&along_u).zip(magnitudes.iter().zip(angles))
            {
                let du = column as f32 - x;
                let (nx, ny) = (cos * du + sin * dv, cos * dv - sin * du);
                // Farther than 2.5 cells nothing is added.
                if nx.abs() >= 2.5 || ny.abs() >= 2.5 {
                    continue;
                }
                let turned = angle - orientation;
                let turned = (if turned < 0.0 { turned + TAU } else { turned }) * (DIRECTIONS as f32 / TAU);
                let weight = magnitude * weight_u * weight_v;
                // In cells from the first padded one; positive, so the whole part is the floor. The sum may round up to 5.
                let (cx, cy) = (nx + 2.5, ny + 2.5);
                let (bx, by, bt) = ((cx as usize).min(CELLS), (cy as usize).min(CELLS), turned as usize);
                let (rx, ry, rt) = (cx - bx as f32, cy - by as f32, turned - bt as f32);
                let (t0, t1) = (bt % DIRECTIONS, (bt + 1) % DIRECTIONS);
                let at = (by * PADDED + bx) * DIRECTIONS;
                for (offset, w) in [
                    (0, weight * (1.0 - rx) * (1.0 - ry)),
                    (DIRECTIONS, weight * rx * (1.0 - ry)),
                    (PADDED * DIRECTIONS, weight * (1.0 - rx) * ry),
                    ((PADDED + 1) * DIRECTIONS, weight * rx * ry),
                ] {
                    bins[at + offset + t0] += w * (1.0 - rt);
                    bins[at + offset + t1] += w * rt;
                }
            }
        }
        quantise(std::array::from_fn(|i| {
            let (cell, direction) = (i / DIRECTIONS, i % DIRECTIONS);
            let (cx, cy) = (cell % CELLS + 1, cell / CELLS + 1);
            bins[(cy * PADDED + cx) * DIRECTIONS + direction]
        }))
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
    fn directions_are_exact_to_a_few_millionths() {
        for i in 0..10_000 {
            let angle = i as f32 / 10_000.0 * TAU;
            let (gv, gu) = (0.01 * angle.sin(), 0.01 * angle.cos());
            let d = (direction(gv, gu) - angle).rem_euclid(TAU);
            assert!(d.min(TAU - d) < 4e-6, "{angle}: {}", direction(gv, gu));
        }
        assert_eq!(direction(0.0, 0.0), 0.0);
        assert!(direction(-1e-30, 1.0) < TAU);
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
