//! Layers: painted sheets that move, one in front of the other.
//!
//! A layer's point at `x` at mid-burst is at `x + dt·λ` in the frame `dt` frames later. To draw a frame, each layer's
//! samples are interpolated (Catmull–Rom, which preserves centres of gravity) at the moved positions and averaged over
//! each pixel, in one short filter per axis; then the layers are composited, far to near.

use super::outermost;
use super::paint::{OVERSAMPLING, Sheet};
use super::truth::{FeatureTruth, LayerTruth, disc_sigma};
use crate::monitor::{Cancelled, Monitor};
use crate::{burst::Offset, plane::Plane};

/// Disc painted on a layer, recorded for the truth: at mid-burst, pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Landmark {
    pub u: f64,
    pub v: f64,
    pub radius: f64,
    /// Whether it is brighter than its surroundings.
    pub bright: bool,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Layer {
    pub name: String,
    /// Motion to the right and downwards, pixels per frame.
    pub slope_u: f64,
    pub slope_v: f64,
    pub sheet: Sheet,
    pub landmarks: Vec<Landmark>,
}

const TAPS: usize = OVERSAMPLING + 3;

/// The filter that samples one axis: the index of its first sample for pixel 0, and its weights.
fn axis_filter(first_sample: f64) -> (i64, [f32; TAPS]) {
    // The pixel's subsamples lie at first, first + 1, …; all have the same fraction.
    let base = first_sample.floor();
    let f = first_sample - base;
    // Catmull–Rom weights of the four samples around the fraction.
    let cubic = [
        ((-0.5 * f + 1.0) * f - 0.5) * f,
        (1.5 * f - 2.5) * f * f + 1.0,
        ((-1.5 * f + 2.0) * f + 0.5) * f,
        (0.5 * f - 0.5) * f * f,
    ];
    let mut weights = [0.0f64; TAPS];
    for sub in 0..OVERSAMPLING {
        for (k, w) in cubic.iter().enumerate() {
            weights[sub + k] += w / OVERSAMPLING as f64;
        }
    }
    (base as i64 - 1, weights.map(|w| w as f32))
}

impl Layer {
    /// Visible at most `half_span` frames away from mid-burst.
    pub fn new(name: &str, size: (usize, usize), slope: (f64, f64), half_span: f64) -> Self {
        Self::seen_at(name, size, slope, &[half_span.into()])
    }

    /// Visible at the `offsets` from mid-burst, and at those opposite.
    pub fn seen_at(name: &str, size: (usize, usize), slope: (f64, f64), offsets: &[Offset]) -> Self {
        let (reach_u, reach_v) = outermost(offsets, slope);
        let margin = |reach: f64| reach.ceil() as usize + 3;
        Self {
            name: name.to_owned(),
            slope_u: slope.0,
            slope_v: slope.1,
            sheet: Sheet::new(size.0, size.1, margin(reach_u), margin(reach_v)),
            landmarks: Vec::new(),
        }
    }

    pub fn landmark(&mut self, u: f64, v: f64, radius: f64, value: f32, bright: bool) {
        self.sheet.disc(u as f32, v as f32, radius as f32, value);
        self.landmarks.push(Landmark { u, v, radius, bright });
    }

    pub fn draw_over(&self, picture: &mut Plane, at: Offset, monitor: &Monitor) -> Result<(), Cancelled> {
        // A sparse layer costs only its painted part.
        let Some([c0, c1, r0, r1]) = self.sheet.used() else { return Ok(()) };
        let half = 0.5 * (OVERSAMPLING as f64 - 1.0);
        let (du, dv) = self.displacement(at);
        // The sample that is seen at pixel 0: the motion is undone.
        let (first_column, weights_u) = axis_filter(self.sheet.column_of(-du) - half);
        let (first_row, weights_v) = axis_filter(self.sheet.row_of(-dv) - half);
        let s = OVERSAMPLING as i64;
        let taps = TAPS as i64;
        let (sheet_width, sheet_height) = (self.sheet.size().0 as i64, self.sheet.size().1 as i64);
        // Pixels whose filter touches used samples; the margins keep it inside the sheet but for rounding.
        let pixels = |first: i64, used: (usize, usize), end: usize| {
            let start = (used.0 as i64 - taps + 1 - first).div_euclid(s).clamp(0, end as i64);
            let stop = ((used.1 as i64 - 1 - first).div_euclid(s) + 1).clamp(0, end as i64);
            start as usize..stop.max(start) as usize
        };
        let columns = pixels(first_column, (c0, c1), picture.width());
        let rows = pixels(first_row, (r0, r1), picture.height());
        if columns.is_empty() {
            return Ok(());
        }
        let from = (first_column + s * columns.start as i64).clamp(0, sheet_width) as usize;
        let to = (first_column + s * (columns.end as i64 - 1) + taps).clamp(0, sheet_width) as usize;
        let (mut values, mut alphas) = (vec![0.0f32; to - from], vec![0.0f32; to - from]);
        // Separable: rows are filtered down once, then each pixel across.
        for v in rows {
            monitor.check()?;
            values.fill(0.0);
            alphas.fill(0.0);
            for (k, &w) in weights_v.iter().enumerate() {
                let row = (first_row + s * v as i64 + k as i64).clamp(0, sheet_height - 1);
                let (value, alpha) = self.sheet.row(row as usize);
                for ((sum, more), (&x, &a)) in
                    values.iter_mut().zip(&mut alphas).zip(value[from..to].iter().zip(&alpha[from..to]))
                {
                    *sum += w * x;
                    *more += w * a;
                }
            }
            let out = &mut picture.row_mut(v)[columns.clone()];
            for (k, pixel) in out.iter_mut().enumerate() {
                let start = first_column + s * (columns.start + k) as i64 - from as i64;
                let (mut value, mut alpha) = (0.0, 0.0);
                for (tap, &w) in weights_u.iter().enumerate() {
                    // At the sheet's edge its last sample is repeated.
                    let i = (start + tap as i64).clamp(0, values.len() as i64 - 1) as usize;
                    value += w * values[i];
                    alpha += w * alphas[i];
                }
                // The sheet's values are premultiplied by alpha.
                *pixel = *pixel * (1.0 - alpha) + value;
            }
        }
        Ok(())
    }

    fn displacement(&self, at: Offset) -> (f64, f64) {
        at.displacement((self.slope_u, self.slope_v))
    }

    /// Whether the layer covers any of the image's disc around (u, v) in a frame `at` an offset from mid-burst.
    fn hides(&self, u: f64, v: f64, radius: f64, at: Offset) -> bool {
        let (du, dv) = self.displacement(at);
        // Back to mid-burst, where the sheet is painted.
        let (u, v) = (u - du, v - dv);
        let reach = radius.ceil() as i64;
        (-reach..=reach).any(|j| {
            (-reach..=reach).any(|i| {
                let (du, dv) = (i as f64, j as f64);
                du * du + dv * dv <= radius * radius && self.sheet.alpha_at(u + du, v + dv) > 0.02
            })
        })
    }

    pub fn truth(&self) -> LayerTruth {
        LayerTruth { name: self.name.clone(), slope_u: self.slope_u, slope_v: self.slope_v }
    }
}

/// The signal of `layers` (far to near) in an image of `size` = (columns, rows) at an offset from mid-burst.
pub fn draw_layers(
    layers: &[Layer],
    size: (usize, usize),
    at: impl Into<Offset>,
    monitor: &Monitor,
) -> Result<Plane, Cancelled> {
    let mut picture = Plane::zeros(size.0, size.1);
    let at = at.into();
    for layer in layers {
        layer.draw_over(&mut picture, at, monitor)?;
    }
    Ok(picture)
}

/// Offsets of even frames within `half_span` of mid-burst.
pub fn even_within(half_span: f64) -> Vec<Offset> {
    let steps = (2.0 * half_span).round() as usize;
    (0..=steps).map(|k| Offset::from(k as f64 - half_span)).collect()
}

/// The landmarks inside the image and under no nearer layer in every frame at the `offsets` from mid-burst.
pub fn visible_landmarks(layers: &[Layer], size: (usize, usize), offsets: &[Offset]) -> Vec<FeatureTruth> {
    let mut features = Vec::new();
    for (index, layer) in layers.iter().enumerate() {
        for landmark in &layer.landmarks {
            let seen = offsets.iter().all(|at| {
                let (du, dv) = layer.displacement(*at);
                let (u, v) = (landmark.u + du, landmark.v + dv);
                // A disc that the border or a nearer layer cuts would have another centre than the truth.
                let inside = u >= landmark.radius
                    && v >= landmark.radius
                    && u + landmark.radius <= (size.0 - 1) as f64
                    && v + landmark.radius <= (size.1 - 1) as f64;
                inside && layers[index + 1..].iter().all(|near| !near.hides(u, v, landmark.radius + 1.0, *at))
            });
            if seen {
                let &Landmark { u, v, radius, bright } = landmark;
                let (id, sigma, contrast_sign) = (features.len(), disc_sigma(radius), if bright { 1 } else { -1 });
                let (slope_u, slope_v, layer) = (layer.slope_u, layer.slope_v, Some(index));
                features.push(FeatureTruth { id, layer, u, v, radius, sigma, slope_u, slope_v, contrast_sign });
            }
        }
    }
    features
}

#[cfg(test)]
mod tests {
    use super::*;

    fn centroid(plane: &Plane) -> (f64, f64, f64) {
        let (mut mass, mut mu, mut mv) = (0.0, 0.0, 0.0);
        for v in 0..plane.height() {
            for (u, &x) in plane.row(v).iter().enumerate() {
                let x = f64::from(x);
                mass += x;
                mu += x * u as f64;
                mv += x * v as f64;
            }
        }
        (mu / mass, mv / mass, mass)
    }

    #[test]
    fn a_layer_moves_by_its_slope() {
        let mut layer = Layer::new("dot", (64, 48), (1.37, -0.61), 4.5);
        layer.landmark(31.2, 24.7, 5.0, 1.0, true);
        let still = draw_layers(std::slice::from_ref(&layer), (64, 48), 0.0, &Monitor::default()).expect("done");
        let (u0, v0, mass) = centroid(&still);
        assert!((mass - std::f64::consts::PI * 25.0).abs() < 0.3, "{mass}");
        assert!((u0 - 31.2).abs() < 0.01 && (v0 - 24.7).abs() < 0.01, "{u0} {v0}");
        for k in 0..10 {
            let dt = f64::from(k) - 4.5;
            let moved = draw_layers(std::slice::from_ref(&layer), (64, 48), dt, &Monitor::default()).expect("done");
            let (u, v, m) = centroid(&moved);
            assert!((u - u0 - dt * 1.37).abs() < 0.005, "{u}");
            assert!((v - v0 + dt * 0.61).abs() < 0.005, "{v}");
            assert!((m / mass - 1.0).abs() < 1e-3);
        }
    }

    #[test]
    fn a_layer_that_fills_the_frame_keeps_filling_it() {
        let mut layer = Layer::new("wall", (40, 30), (3.0, -2.5), 4.5);
        layer.sheet.fill(|_, _| 0.25);
        for k in 0..10 {
            let picture = draw_layers(std::slice::from_ref(&layer), (40, 30), f64::from(k) - 4.5, &Monitor::default());
            assert!(picture.expect("done").data().iter().all(|x| (x - 0.25).abs() < 1e-6));
        }
    }

    #[test]
    fn near_layers_hide_far_ones_and_their_landmarks() {
        let mut far = Layer::new("far", (60, 40), (0.0, 0.0), 2.0);
        far.sheet.fill(|_, _| 0.1);
        far.landmark(15.0, 20.0, 4.0, 0.9, true);
        far.landmark(45.0, 20.0, 4.0, 0.9, true);
        let mut near = Layer::new("near", (60, 40), (2.0, 0.0), 2.0);
        near.sheet.disc(34.0, 20.0, 4.0, 0.0);
        let layers = [far, near];
        let picture = draw_layers(&layers, (60, 40), 0.0, &Monitor::default()).expect("done");
        assert!(picture.at(34, 20) < 1e-6 && (picture.at(5, 5) - 0.1).abs() < 1e-6);
        let seen = visible_landmarks(&layers, (60, 40), &even_within(2.0));
        assert_eq!(seen.len(), 1, "the near disc moves over the right landmark");
        assert_eq!(seen[0].u, 15.0);
    }
}
