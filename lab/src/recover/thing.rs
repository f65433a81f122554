//! Things that are planted: their shape, and how light that was not there is added to a frame.
//!
//! A bright thing adds light. Photons arrive independently, so the noise already there stays, and the added light
//! brings its own: for a variance of a per brightness, Δ of light is a times a Poisson number of mean Δ/a. A dark thing
//! takes light away: a part 1 − p of the photons is removed, which scales what is there by p, and the noise that a
//! frame with so much less light would have is made up.

use crate::synth::{chart::draw_disc, random::Stream, truth::disc_sigma};
use burstscope_core::monitor::{Cancelled, Monitor};
use burstscope_core::plane::Plane;
use serde::{Deserialize, Serialize};

/// Shape of a planted thing; the scale that suits either shape is radius/√2.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Shape {
    /// Disc of even brightness.
    #[default]
    Disc,
    /// Gaussian blob, whose standard deviation is radius/√2.
    Blob,
}

impl Shape {
    /// All shapes.
    pub const ALL: [Self; 2] = [Self::Disc, Self::Blob];

    /// Name, as on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Disc => "disc",
            Self::Blob => "blob",
        }
    }

    /// Scale σ of a detector that suits a thing of `radius`, input pixels: radius/√2 for both.
    pub fn sigma(self, radius: f64) -> f64 {
        disc_sigma(radius)
    }

    /// Distance from the centre, pixels, beyond which a thing of `radius` adds nothing.
    pub fn reach(self, radius: f64) -> f64 {
        match self {
            Self::Disc => radius,
            Self::Blob => 4.0 * self.sigma(radius),
        }
    }

    /// Pixel means of a thing of amplitude 1 and `radius` centred at (u, v), with the column and row of the first.
    fn shares(self, u: f64, v: f64, radius: f64) -> (Plane, i64, i64) {
        let reach = self.reach(radius) + 1.0;
        let (left, top) = ((u - reach).floor(), (v - reach).floor());
        let side = (2.0 * reach).ceil() as usize + 2;
        let (u, v) = (u - left, v - top);
        let plane = match self {
            Self::Disc => {
                let mut plane = Plane::zeros(side, side);
                draw_disc(&mut plane, u, v, radius, 1.0);
                plane
            }
            Self::Blob => {
                let sigma = self.sigma(radius);
                // The blob is a product: one value for each column and one for each row.
                let over_pixels = |centre: f64| -> Vec<f64> {
                    let edge = |x: f64| libm::erf((x - centre) / (sigma * std::f64::consts::SQRT_2));
                    let half = sigma * (std::f64::consts::PI / 2.0).sqrt();
                    (0..side).map(|i| half * (edge(i as f64 + 0.5) - edge(i as f64 - 0.5))).collect()
                };
                let (columns, rows) = (over_pixels(u), over_pixels(v));
                Plane::from_fn(side, side, |x, y| (columns[x] * rows[y]) as f32)
            }
        };
        (plane, left as i64, top as i64)
    }
}

/// Noise of light in the frames of a burst.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LightNoise {
    /// Variance per brightness, a, fraction of full scale; 0 where the noise does not depend on brightness.
    pub per_brightness: f64,
    /// Variance at brightness 0, b, (fraction of full scale)²; at least 0.
    pub dark: f64,
    /// Smallest difference of the files' values, fraction of full scale; 0 for floats, which have no range either.
    pub step: f64,
}

impl LightNoise {
    /// Amplitude, fraction of full scale, of a thing of this `snr` on a background of this `variance`; the noise is
    /// that of one pixel half-way between background and thing. `sign`: 1 for a bright thing, −1 for a dark one.
    pub fn amplitude(&self, snr: f64, variance: f64, sign: f64) -> f64 {
        // A² = snr²·(V ± a·A/2).
        let p = 0.5 * snr * snr * self.per_brightness * sign;
        sign * 0.5 * (p + (p * p + 4.0 * snr * snr * variance).sqrt())
    }

    /// The value of a pixel after `added` light (negative: taken away), where the scene around has `background`.
    fn with_light(&self, value: f64, added: f64, background: f64, stream: &mut Stream) -> f64 {
        let a = self.per_brightness;
        let light = if added >= 0.0 {
            if a > 0.0 { a * stream.poisson(added / a) } else { added }
        } else {
            // p is the share of the photons that stays.
            let p = (1.0 + added / background.max(1e-12)).clamp(0.0, 1.0);
            // Of the variance a·B + b scaling leaves p²·(a·B + b); darker light has p·a·B + b: the rest is added.
            let missing = (1.0 - p) * (a * background.max(0.0) * p + self.dark * (1.0 + p));
            // The removed part of this pixel's own noise goes with the light.
            added - (1.0 - p) * (value - background) + missing.max(0.0).sqrt() * stream.normal()
        };
        if self.step <= 0.0 {
            return value + light;
        }
        // On the lattice of the file's values, wherever calibration has moved it.
        let rounded = value + (light / self.step).round() * self.step;
        // A calibrated value may lie outside 0 … 1 already, and then stays there.
        rounded.clamp(value.min(0.0), value.max(1.0))
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Painting {
    pub shape: Shape,
    /// Pixels.
    pub radius: f64,
    /// Column and row of its centre in this frame.
    pub centre: (f64, f64),
    /// Light at full coverage, fraction of full scale; negative for a dark thing.
    pub amplitude: f64,
    /// Brightness of the scene there, fraction of full scale.
    pub background: f64,
}

impl Painting {
    pub fn paint(
        &self,
        frame: &mut Plane,
        noise: &LightNoise,
        stream: &mut Stream,
        monitor: &Monitor,
    ) -> Result<(), Cancelled> {
        let (shares, left, top) = self.shape.shares(self.centre.0, self.centre.1, self.radius);
        let (width, height) = frame.size();
        for y in 0..shares.height() {
            monitor.check()?;
            let row = top + y as i64;
            // A thing may reach beyond the picture, or move out of it.
            if row < 0 || row >= height as i64 {
                continue;
            }
            let pixels = frame.row_mut(row as usize);
            for (x, &share) in shares.row(y).iter().enumerate() {
                let column = left + x as i64;
                if share > 0.0 && column >= 0 && column < width as i64 {
                    let pixel = &mut pixels[column as usize];
                    let added = self.amplitude * f64::from(share);
                    *pixel = noise.with_light(f64::from(*pixel), added, self.background, stream) as f32;
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn painting(shape: Shape, amplitude: f64) -> Painting {
        Painting { shape, radius: 6.0, centre: (30.3, 29.6), amplitude, background: 0.2 }
    }

    #[test]
    fn light_is_where_the_thing_is_and_no_more_than_it() {
        for (shape, mass) in [
            (Shape::Disc, std::f64::consts::PI * 36.0),
            (Shape::Blob, 2.0 * std::f64::consts::PI * disc_sigma(6.0).powi(2)),
        ] {
            let (mut frame, noise) = (Plane::zeros(64, 64), LightNoise::default());
            let painted = painting(shape, 0.1).paint(&mut frame, &noise, &mut Stream::new(1, 1), &Monitor::default());
            painted.expect("nobody cancels");
            let sum = |weight: &dyn Fn(usize, usize) -> f64| -> f64 {
                let places = (0..64).flat_map(|v| (0..64).map(move |u| (u, v)));
                places.map(|(u, v)| weight(u, v) * f64::from(frame.at(u, v))).sum()
            };
            let light = sum(&|_, _| 1.0);
            assert!((light / (0.1 * mass) - 1.0).abs() < 5e-3, "{shape:?}: {light}");
            assert!((sum(&|u, _| u as f64) / light - 30.3).abs() < 0.01);
            assert!((sum(&|_, v| v as f64) / light - 29.6).abs() < 0.01);
        }
    }

    #[test]
    fn added_and_removed_light_have_the_noise_of_their_brightness() {
        let (a, b, background) = (4e-4, 1e-5, 0.2);
        let noise = LightNoise { per_brightness: a, dark: b, step: 0.0 };
        for amplitude in [0.05, -0.05] {
            let mut stream = Stream::new(7, 0);
            let (mut sum, mut squares, mut count) = (0.0, 0.0, 0.0);
            for _ in 0..40_000 {
                let electrons = stream.poisson(background / a);
                let value = a * electrons + b.sqrt() * stream.normal();
                let after = noise.with_light(value, amplitude, background, &mut stream);
                (sum, squares, count) = (sum + after, squares + after * after, count + 1.0);
            }
            let mean = sum / count;
            let variance = squares / count - mean * mean;
            assert!((mean - background - amplitude).abs() < 3e-4, "{amplitude}: mean {mean}");
            let should = a * (background + amplitude) + b;
            assert!((variance / should - 1.0).abs() < 0.03, "{amplitude}: {variance} for {should}");
        }
    }

    #[test]
    fn values_stay_on_the_lattice_and_in_the_range_of_the_file() {
        let noise = LightNoise { per_brightness: 1e-3, dark: 0.0, step: 1.0 / 255.0 };
        let mut frame = Plane::from_fn(64, 64, |u, _| (u % 256) as f32 * 4.0 / 255.0);
        frame.data_mut().iter_mut().for_each(|x| *x = x.min(1.0));
        let painted = painting(Shape::Disc, 0.9).paint(&mut frame, &noise, &mut Stream::new(3, 0), &Monitor::default());
        painted.expect("nobody cancels");
        for &x in frame.data() {
            assert!((0.0..=1.0 + 1e-6).contains(&x) && ((x * 255.0).round() - x * 255.0).abs() < 1e-2, "{x}");
        }
    }

    #[test]
    fn the_amplitude_has_the_ratio_that_charts_have() {
        let noise = LightNoise { per_brightness: 4e-4, dark: 1e-5, step: 0.0 };
        for (snr, sign) in [(0.3, 1.0), (2.0, 1.0), (1.0, -1.0)] {
            let variance = 4e-4 * 0.2 + 1e-5;
            let amplitude = noise.amplitude(snr, variance, sign);
            let middle: f64 = variance + 4e-4 * 0.5 * amplitude;
            assert!((amplitude.abs() / middle.sqrt() / snr - 1.0).abs() < 1e-9);
            assert_eq!(amplitude.signum(), sign);
        }
    }
}
