//! Painting: shapes with smooth edges, and textures of them, on a sheet that is larger and finer than the frames.
//!
//! A [`Sheet`] holds one layer of a scene at mid-burst: for each point a value, and the share of the point that the
//! layer covers (its alpha). Coordinates are image pixels at `t0`; a margin beyond the image holds what the motion
//! shows, and [`OVERSAMPLING`] samples per pixel on each axis let it move by fractions of a pixel without stair-steps.

use super::random::lattice;
use crate::plane::memory;

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
        let painted = self.each(bounds, |u, v, value, alpha| {
            let (x, a) = shade(u, v);
            if a > 0.0 {
                *value += a * (x - *value);
                *alpha += a * (1.0 - *alpha);
            }
        });
        if let Some([c0, c1, r0, r1]) = painted {
            let old = self.used.unwrap_or([c0, c1, r0, r1]);
            self.used = Some([old[0].min(c0), old[1].max(c1), old[2].min(r0), old[3].max(r1)]);
        }
    }

    /// Adds a glow to the painted content: `value` at its centre, 0 at `radius`. It does not change alpha.
    pub fn glow(&mut self, u: f32, v: f32, radius: f32, value: f32) {
        self.each(Area::around(u, v, radius), |x, y, light, alpha| {
            let q = ((x - u) * (x - u) + (y - v) * (y - v)) / (radius * radius);
            if q < 1.0 {
                *light += *alpha * value * (1.0 - q) * (1.0 - q);
            }
        });
    }

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
        self.textured(area, |_, _| value);
    }

    /// Paints a rectangle with the values `value(u, v)`.
    pub fn textured(&mut self, area: Area, value: impl Fn(f32, f32) -> f32) {
        self.shape(area, |u, v| area.distance(u, v), value);
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
