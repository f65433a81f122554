//! Painting: shapes with smooth edges, and textures of them, on a sheet that is larger and finer than the frames.
//!
//! A [`Sheet`] holds one layer of a scene at mid-burst: for each point a value, and the share of the point that the
//! layer covers (its alpha). Coordinates are image pixels at `t0`; the sheet extends beyond the image by a margin, so
//! that content is visible when the layer moves, and has [`OVERSAMPLING`] samples per pixel on each axis, so that it
//! can be moved by fractions of a pixel and averaged down without stair-steps.
//!
//! Dead leaves are a texture with structure at every scale: shapes of random size, grey value and orientation fall on a
//! sheet, later ones over earlier ones. Sizes follow the law 1/r³, by which every octave of sizes covers the same area.
//! Such pictures have the statistics of natural ones (A. B. Lee, D. Mumford and J. Huang, "Occlusion models for natural
//! images", International Journal of Computer Vision 41 (2001), 35–59), so that a detector finds features at all its
//! scales.

use super::random::{Stream, lattice};
use crate::plane::memory;
use std::ops::RangeInclusive;

/// Samples per pixel on each axis.
pub const OVERSAMPLING: usize = 2;

/// Rectangle in image pixels; bounds of a shape.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Area {
    /// Left edge.
    pub u0: f32,
    /// Upper edge.
    pub v0: f32,
    /// Right edge.
    pub u1: f32,
    /// Lower edge.
    pub v1: f32,
}

impl Area {
    /// The rectangle from (u0, v0) to (u1, v1).
    pub const fn new(u0: f32, v0: f32, u1: f32, v1: f32) -> Self {
        Self { u0, v0, u1, v1 }
    }

    /// The square around a centre.
    pub fn around(u: f32, v: f32, reach: f32) -> Self {
        Self::new(u - reach, v - reach, u + reach, v + reach)
    }

    /// Signed distance from (u, v) to its edge, pixels; negative inside.
    pub fn distance(&self, u: f32, v: f32) -> f32 {
        let du = (u - 0.5 * (self.u0 + self.u1)).abs() - 0.5 * (self.u1 - self.u0);
        let dv = (v - 0.5 * (self.v0 + self.v1)).abs() - 0.5 * (self.v1 - self.v0);
        let (ou, ov) = (du.max(0.0), dv.max(0.0));
        (ou * ou + ov * ov).sqrt() + du.max(dv).min(0.0)
    }
}

/// Picture of one layer at mid-burst, with alpha. Values are premultiplied by alpha.
#[derive(Debug, Clone, PartialEq)]
pub struct Sheet {
    width: usize,
    height: usize,
    margin_u: usize,
    margin_v: usize,
    value: Vec<f32>,
    alpha: Vec<f32>,
    /// Columns and rows of the sheet that were painted: (first, one past the last).
    used: Option<[usize; 4]>,
}

impl Sheet {
    /// An empty sheet for an image of `width × height` pixels, with margins of whole pixels around it.
    pub fn new(width: usize, height: usize, margin_u: usize, margin_v: usize) -> Self {
        let (w, h) = ((width + 2 * margin_u) * OVERSAMPLING, (height + 2 * margin_v) * OVERSAMPLING);
        let (value, alpha) = (memory::zeroed(w * h), memory::zeroed(w * h));
        Self { width: w, height: h, margin_u, margin_v, value, alpha, used: None }
    }

    /// (columns, rows) of samples.
    pub fn size(&self) -> (usize, usize) {
        (self.width, self.height)
    }

    /// The sheet's whole area in image pixels.
    pub fn area(&self) -> Area {
        let (u, v) = (self.margin_u as f32 + 0.5, self.margin_v as f32 + 0.5);
        let s = OVERSAMPLING as f32;
        Area::new(-u, -v, self.width as f32 / s - u, self.height as f32 / s - v)
    }

    /// Row `row` of the samples: (values times alpha, alpha).
    pub fn row(&self, row: usize) -> (&[f32], &[f32]) {
        let range = row * self.width..(row + 1) * self.width;
        (&self.value[range.clone()], &self.alpha[range])
    }

    /// Painted columns and rows: `[first column, end column, first row, end row]`; `None` when nothing was painted.
    pub fn used(&self) -> Option<[usize; 4]> {
        self.used
    }

    /// The sample index of an image column; it may be fractional.
    pub fn column_of(&self, u: f64) -> f64 {
        (u + self.margin_u as f64 + 0.5) * OVERSAMPLING as f64 - 0.5
    }

    /// The sample index of an image row; it may be fractional.
    pub fn row_of(&self, v: f64) -> f64 {
        (v + self.margin_v as f64 + 0.5) * OVERSAMPLING as f64 - 0.5
    }

    /// Alpha at the sample nearest to the image position (u, v); 0 outside.
    pub fn alpha_at(&self, u: f64, v: f64) -> f32 {
        let (column, row) = (self.column_of(u).round(), self.row_of(v).round());
        if column < 0.0 || row < 0.0 || column >= self.width as f64 || row >= self.height as f64 {
            return 0.0;
        }
        self.alpha[row as usize * self.width + column as usize]
    }

    /// Paints each sample within `bounds` with `shade(u, v)` = (value, alpha), over the existing content.
    pub fn paint(&mut self, bounds: Area, mut shade: impl FnMut(f32, f32) -> (f32, f32)) {
        let Some([c0, c1, r0, r1]) = self.each(bounds, |u, v, value, alpha| {
            let (x, a) = shade(u, v);
            if a > 0.0 {
                *value += a * (x - *value);
                *alpha += a * (1.0 - *alpha);
            }
        }) else {
            return;
        };
        let old = self.used.unwrap_or([c0, c1, r0, r1]);
        self.used = Some([old[0].min(c0), old[1].max(c1), old[2].min(r0), old[3].max(r1)]);
    }

    /// Adds a soft glow of light to the painted content: `value` at its centre, 0 at `radius`. It does not change
    /// alpha.
    pub fn glow(&mut self, u: f32, v: f32, radius: f32, value: f32) {
        self.each(Area::around(u, v, radius), |x, y, light, alpha| {
            let q = ((x - u) * (x - u) + (y - v) * (y - v)) / (radius * radius);
            if q < 1.0 {
                *light += *alpha * value * (1.0 - q) * (1.0 - q);
            }
        });
    }

    /// Calls `change(u, v, value, alpha)` for each sample within `bounds`; returns the samples visited, in the form of
    /// [`Self::used`].
    fn each(&mut self, bounds: Area, mut change: impl FnMut(f32, f32, &mut f32, &mut f32)) -> Option<[usize; 4]> {
        let s = OVERSAMPLING as f32;
        let clip = |x: f64, end: usize| x.clamp(0.0, end as f64) as usize;
        let c0 = clip(self.column_of(f64::from(bounds.u0)).floor(), self.width);
        let c1 = clip(self.column_of(f64::from(bounds.u1)).ceil() + 1.0, self.width);
        let r0 = clip(self.row_of(f64::from(bounds.v0)).floor(), self.height);
        let r1 = clip(self.row_of(f64::from(bounds.v1)).ceil() + 1.0, self.height);
        if c0 >= c1 || r0 >= r1 {
            return None;
        }
        for row in r0..r1 {
            let v = (row as f32 + 0.5) / s - 0.5 - self.margin_v as f32;
            let start = row * self.width;
            let samples = self.value[start + c0..start + c1].iter_mut().zip(&mut self.alpha[start + c0..start + c1]);
            for (column, (value, alpha)) in (c0..c1).zip(samples) {
                change((column as f32 + 0.5) / s - 0.5 - self.margin_u as f32, v, value, alpha);
            }
        }
        Some([c0, c1, r0, r1])
    }

    /// Keeps only the part covered by `mask`, a sheet of the same size: value and alpha are multiplied by its alpha.
    pub fn keep_where(&mut self, mask: &Self) {
        for ((value, alpha), share) in self.value.iter_mut().zip(&mut self.alpha).zip(&mask.alpha) {
            *value *= share;
            *alpha *= share;
        }
        self.used = mask.used;
    }

    /// Covers the whole sheet with `value(u, v)`.
    pub fn fill(&mut self, mut value: impl FnMut(f32, f32) -> f32) {
        self.paint(self.area(), |u, v| (value(u, v), 1.0));
    }

    /// Paints the inside of a shape given by its signed distance (pixels, negative inside), with edges one sample wide.
    pub fn shape(&mut self, bounds: Area, distance: impl Fn(f32, f32) -> f32, value: impl Fn(f32, f32) -> f32) {
        let s = OVERSAMPLING as f32;
        let bounds = Area::new(bounds.u0 - 1.0, bounds.v0 - 1.0, bounds.u1 + 1.0, bounds.v1 + 1.0);
        self.paint(bounds, |u, v| {
            let alpha = (0.5 - distance(u, v) * s).clamp(0.0, 1.0);
            (if alpha > 0.0 { value(u, v) } else { 0.0 }, alpha)
        });
    }

    /// Paints a filled rectangle.
    pub fn rectangle(&mut self, area: Area, value: f32) {
        self.shape(area, |u, v| area.distance(u, v), |_, _| value);
    }

    /// Paints a disc.
    pub fn disc(&mut self, u: f32, v: f32, radius: f32, value: f32) {
        self.shape(
            Area::around(u, v, radius),
            |x, y| ((x - u) * (x - u) + (y - v) * (y - v)).sqrt() - radius,
            |_, _| value,
        );
    }

    /// Paints a straight stroke with round ends, `thickness` pixels wide.
    pub fn stroke(&mut self, from: (f32, f32), to: (f32, f32), thickness: f32, value: f32) {
        let r = 0.5 * thickness;
        let bounds = Area::new(from.0.min(to.0) - r, from.1.min(to.1) - r, from.0.max(to.0) + r, from.1.max(to.1) + r);
        let (du, dv) = (to.0 - from.0, to.1 - from.1);
        let length2 = (du * du + dv * dv).max(1e-9);
        let distance = |u: f32, v: f32| {
            let along = (((u - from.0) * du + (v - from.1) * dv) / length2).clamp(0.0, 1.0);
            let (eu, ev) = (u - from.0 - along * du, v - from.1 - along * dv);
            (eu * eu + ev * ev).sqrt() - r
        };
        self.shape(bounds, distance, |_, _| value);
    }
}

/// Smooth random relief in [0, 1]: values on a lattice of `cell` pixels, interpolated.
pub fn relief(seed: u64, u: f32, v: f32, cell: f32) -> f32 {
    let (x, y) = (u / cell, v / cell);
    let (i, j) = (x.floor(), y.floor());
    let smooth = |f: f32| f * f * (3.0 - 2.0 * f);
    let (fx, fy) = (smooth(x - i), smooth(y - j));
    let at = |di: i64, dj: i64| lattice(seed, i as i64 + di, j as i64 + dj);
    let upper = at(0, 0) + fx * (at(1, 0) - at(0, 0));
    let lower = at(0, 1) + fx * (at(1, 1) - at(0, 1));
    upper + fy * (lower - upper)
}

/// Random relief with detail at `octaves` scales, each half as large and half as strong as the one before; in [0, 1].
pub fn fractal_relief(seed: u64, u: f32, v: f32, cell: f32, octaves: u32) -> f32 {
    let (mut sum, mut weight, mut total, mut size) = (0.0, 1.0, 0.0, cell);
    for octave in 0..octaves {
        sum += weight * relief(seed.wrapping_add(u64::from(octave) * 7919), u, v, size);
        total += weight;
        weight *= 0.5;
        size *= 0.5;
    }
    sum / total
}

/// Mean number of times that the leaves cover the sheet; exp(−3) or 5 % of the previous content remains.
const COVERAGE: f64 = 3.0;

/// Covers the whole of `sheet` with leaves of radii in `radii` (pixels, above 0) and values in `values`.
pub(super) fn paint_leaves(
    sheet: &mut Sheet,
    radii: &RangeInclusive<f64>,
    values: &RangeInclusive<f64>,
    stream: &mut Stream,
) {
    let area = sheet.area();
    let middle = 0.5 * (values.start() + values.end());
    sheet.fill(|_, _| middle as f32);
    let (width, height) = (f64::from(area.u1 - area.u0), f64::from(area.v1 - area.v0));
    let count = (COVERAGE * width * height / mean_area(radii)).ceil() as usize;
    for _ in 0..count {
        let radius = leaf_radius(radii, stream);
        let u = f64::from(area.u0) + width * stream.uniform();
        let v = f64::from(area.v0) + height * stream.uniform();
        let value = stream.within(*values.start(), *values.end()) as f32;
        if stream.uniform() < 0.5 {
            sheet.disc(u as f32, v as f32, radius as f32, value);
        } else {
            let aspect = stream.within(0.4, 1.0);
            turned_rectangle(sheet, (u, v), (radius, aspect * radius), direction(stream), value);
        }
    }
}

/// A random radius whose density falls like 1/r³ over the range.
fn leaf_radius(radii: &RangeInclusive<f64>, stream: &mut Stream) -> f64 {
    let (fine, coarse) = (1.0 / radii.start().powi(2), 1.0 / radii.end().powi(2));
    1.0 / (fine - stream.uniform() * (fine - coarse)).sqrt()
}

/// Mean area of a leaf, pixels: that of discs, π·E(r²), and of rectangles, E(4·r²·aspect), in equal shares.
fn mean_area(radii: &RangeInclusive<f64>) -> f64 {
    let (a, b) = (*radii.start(), *radii.end());
    let mean_square = if b - a < 1e-6 * a { a * a } else { 2.0 * libm::log(b / a) / (a.powi(-2) - b.powi(-2)) };
    mean_square * 0.5 * (std::f64::consts::PI + 4.0 * 0.7)
}

/// A random direction in the plane, uniform, by rejection: sine and cosine need not round alike on every machine,
/// square roots do.
fn direction(stream: &mut Stream) -> (f64, f64) {
    loop {
        let (x, y) = (stream.within(-1.0, 1.0), stream.within(-1.0, 1.0));
        let square = x * x + y * y;
        if (0.01..=1.0).contains(&square) {
            return (x / square.sqrt(), y / square.sqrt());
        }
    }
}

/// Paints a filled rectangle around `centre` with half sides `half`, the first of them along `direction`.
fn turned_rectangle(sheet: &mut Sheet, centre: (f64, f64), half: (f64, f64), direction: (f64, f64), value: f32) {
    let (u, v) = (centre.0 as f32, centre.1 as f32);
    let (cos, sin) = (direction.0 as f32, direction.1 as f32);
    let level = Area::new(-half.0 as f32, -half.1 as f32, half.0 as f32, half.1 as f32);
    let reach = (half.0 * half.0 + half.1 * half.1).sqrt() as f32;
    let distance = |x: f32, y: f32| {
        let (du, dv) = (x - u, y - v);
        level.distance(cos * du + sin * dv, cos * dv - sin * du)
    };
    sheet.shape(Area::around(u, v, reach), distance, |_, _| value);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_disc_has_its_area_and_its_place() {
        let mut sheet = Sheet::new(40, 30, 3, 2);
        sheet.disc(17.3, 12.8, 6.0, 0.5);
        let (mut mass, mut mu, mut mv) = (0.0f64, 0.0, 0.0);
        let s = OVERSAMPLING as f64;
        for row in 0..sheet.size().1 {
            for (column, &x) in sheet.row(row).0.iter().enumerate() {
                mass += f64::from(x);
                mu += f64::from(x) * ((column as f64 + 0.5) / s - 0.5 - 3.0);
                mv += f64::from(x) * ((row as f64 + 0.5) / s - 0.5 - 2.0);
            }
        }
        assert!((mass / (s * s) / 0.5 - std::f64::consts::PI * 36.0).abs() < 0.5, "{mass}");
        assert!((mu / mass - 17.3).abs() < 0.01 && (mv / mass - 12.8).abs() < 0.01);
        assert_eq!(sheet.alpha_at(17.0, 13.0), 1.0);
        assert_eq!(sheet.alpha_at(30.0, 13.0), 0.0);
        assert_eq!(sheet.alpha_at(-99.0, 1e9), 0.0);
    }

    #[test]
    fn painting_outside_is_harmless() {
        let mut sheet = Sheet::new(20, 20, 0, 0);
        sheet.disc(-100.0, 5.0, 3.0, 1.0);
        assert_eq!(sheet.used(), None);
        sheet.stroke((-50.0, 10.0), (70.0, 10.0), 2.0, 1.0);
        assert_eq!(sheet.used().map(|[a, b, ..]| (a, b)), Some((0, 40)));
    }

    #[test]
    fn relief_is_smooth_and_within_bounds() {
        let mut last = fractal_relief(1, 0.0, 3.0, 20.0, 3);
        for k in 1..2000 {
            let x = fractal_relief(1, k as f32 * 0.1, 3.0, 20.0, 3);
            assert!((0.0..=1.0).contains(&x) && (x - last).abs() < 0.03);
            last = x;
        }
    }

    #[test]
    fn every_octave_of_sizes_covers_the_same_area() {
        let (mut stream, radii) = (Stream::new(5, 0), 1.5..=24.0);
        let (mut areas, mut total) = ([0.0f64; 4], 0.0);
        const COUNT: usize = 400_000;
        for _ in 0..COUNT {
            let radius = leaf_radius(&radii, &mut stream);
            assert!((1.5 - 1e-9..=24.0 + 1e-9).contains(&radius), "{radius}");
            areas[((radius / 1.5).log2() as usize).min(3)] += radius * radius;
            total += radius * radius;
        }
        // There are few leaves in the coarsest octave, each with much area: one in 340, so its share is known to within
        // about 6 %.
        assert!(areas.iter().all(|area| (area / total - 0.25).abs() < 0.02), "{areas:?}");
        let predicted = mean_area(&radii) / (0.5 * (std::f64::consts::PI + 2.8));
        assert!((total / COUNT as f64 / predicted - 1.0).abs() < 0.03, "{predicted}");
    }

    #[test]
    fn the_sheet_is_covered_with_values_in_the_range_and_follows_from_the_stream() {
        let painted = |seed: u64| {
            let mut sheet = Sheet::new(60, 50, 2, 2);
            paint_leaves(&mut sheet, &(1.5..=12.0), &(0.1..=0.9), &mut Stream::new(seed, 4));
            sheet
        };
        let sheet = painted(1);
        let rows = (0..sheet.size().1).map(|row| sheet.row(row));
        let (mut sum, mut squares, mut count) = (0.0f64, 0.0, 0.0);
        for (values, alphas) in rows {
            assert!(alphas.iter().all(|&alpha| (alpha - 1.0).abs() < 1e-6));
            for &value in values {
                assert!((0.1 - 1e-6..=0.9 + 1e-6).contains(&value));
                sum += f64::from(value);
                squares += f64::from(value).powi(2);
                count += 1.0;
            }
        }
        let spread = (squares / count - (sum / count).powi(2)).sqrt();
        // Values uniform from 0.1 to 0.9 have a standard deviation of 0.23.
        assert!((0.15..0.28).contains(&spread), "{spread}");
        assert_eq!(sheet, painted(1));
        assert_ne!(sheet, painted(2));
    }

    #[test]
    fn a_turned_rectangle_has_its_area_and_its_direction() {
        let mut sheet = Sheet::new(60, 60, 0, 0);
        turned_rectangle(&mut sheet, (30.0, 30.0), (16.0, 6.0), (0.8, 0.6), 1.0);
        let covered: f32 = (0..sheet.size().1).map(|row| sheet.row(row).1.iter().sum::<f32>()).sum();
        assert!((covered / 4.0 - 32.0 * 12.0).abs() < 3.0, "{covered}");
        // Painted 14 px along its long side, unpainted 14 px across it.
        assert_eq!(sheet.alpha_at(30.0 + 14.0 * 0.8, 30.0 + 14.0 * 0.6), 1.0);
        assert_eq!(sheet.alpha_at(30.0 - 14.0 * 0.6, 30.0 + 14.0 * 0.8), 0.0);
    }
}
