//! The camera's noise: the capture of a noiseless signal by a sensor.
//!
//! A signal `x` is a fraction of full scale *above the black level*. The sensor collects `Poisson(x·F)` electrons,
//! where `F` is the number of electrons at full scale; reading it out adds Gaussian noise of `r` electrons. The result,
//! divided by `F`, is raised by the black level, which keeps noise from clipping at zero, and rounded to the levels of
//! a converter. Level `d` of `bits` bits is the value `d·2^(16−bits)/65535`, so a 16-bit file holds each value exactly.
//!
//! The per-pixel signal-to-noise ratio of an object on a background is `|x_object − x_background| / σ`, with σ of one
//! pixel at the mean `x` of both levels: `σ² = (x·F + r²)/F² + q²/12` for the quantisation step `q`.

use super::{check_snr, random::Stream};
use crate::error::{Error, Result};
use crate::monitor::{Cancelled, Monitor};
use crate::plane::Plane;

/// Camera: electrons at full scale, read noise, pedestal, and converter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// Electrons at full scale, F; infinite for a camera without noise.
    pub full_scale_electrons: f64,
    /// Standard deviation of the read noise, electrons.
    pub read_noise_electrons: f64,
    /// Pedestal, fraction of full scale.
    pub black_level: f64,
    /// Bits of the converter, 4 … 16, or `None` for values that are not rounded.
    pub bits: Option<u32>,
}

impl Camera {
    /// A camera without noise and rounding, which only adds the black level.
    pub fn noiseless(black_level: f64) -> Self {
        Self { full_scale_electrons: f64::INFINITY, read_noise_electrons: 0.0, black_level, bits: None }
    }

    /// The camera whose exposure gives the per-pixel SNR `snr` between `background` and `object` (fractions of full
    /// scale above black), with read noise (electrons) and converter; [`Self::noiseless`] for an infinite `snr`.
    ///
    /// # Errors
    /// When `snr` is not positive, or so high that rounding alone makes more noise.
    pub fn for_snr(
        snr: f64,
        background: f64,
        object: f64,
        read_noise_electrons: f64,
        black_level: f64,
        bits: u32,
    ) -> Result<Self> {
        if snr == f64::INFINITY {
            return Ok(Self::noiseless(black_level));
        }
        check_snr(snr)?;
        // Solve σ² = x·y + r²·y² + q²/12 for y = 1/F.
        let middle = 0.5 * (background + object);
        let sigma = (object - background).abs() / snr;
        let rounding = quantisation_step(bits).powi(2) / 12.0;
        let rest = sigma * sigma - rounding;
        if rest <= 0.0 {
            let problem = format!("{snr} is out of reach: rounding to {bits} bits alone makes more noise");
            return Err(Error::param("snr", problem, "give a lower ratio, more bits, or inf for no noise"));
        }
        // The stable form of the quadratic formula; it also holds for r = 0.
        let r2 = read_noise_electrons * read_noise_electrons;
        let y = 2.0 * rest / (middle + (middle * middle + 4.0 * r2 * rest).sqrt());
        Ok(Self { full_scale_electrons: 1.0 / y, read_noise_electrons, black_level, bits: Some(bits) })
    }

    /// Whether frames are captured without noise.
    pub fn is_noiseless(&self) -> bool {
        self.full_scale_electrons.is_infinite()
    }

    /// The smallest difference between two values, fraction of full scale; 0 when values are not rounded.
    pub fn quantisation_step(&self) -> f64 {
        self.bits.map_or(0.0, quantisation_step)
    }

    /// Standard deviation of one pixel of one frame where the signal is `signal`; both are fractions of full scale.
    pub fn sigma(&self, signal: f64) -> f64 {
        let rounding = self.quantisation_step().powi(2) / 12.0;
        if self.is_noiseless() {
            return rounding.sqrt();
        }
        let f = self.full_scale_electrons;
        ((signal.max(0.0) * f + self.read_noise_electrons.powi(2)) / (f * f) + rounding).sqrt()
    }

    /// Captures one frame: `signal` (fractions of full scale above black) with black level, noise, rounding; in [0, 1].
    pub fn capture(&self, signal: &Plane, stream: &mut Stream, monitor: &Monitor) -> Result<Plane, Cancelled> {
        let mut frame = signal.clone();
        for row in 0..frame.height() {
            monitor.check()?;
            for value in frame.row_mut(row) {
                *value = self.capture_pixel(f64::from(*value), stream);
            }
        }
        Ok(frame)
    }

    fn capture_pixel(&self, signal: f64, stream: &mut Stream) -> f32 {
        // A Poisson mean is not negative.
        let mut value = signal.max(0.0);
        if !self.is_noiseless() {
            let electrons =
                stream.poisson(value * self.full_scale_electrons) + self.read_noise_electrons * stream.normal();
            value = electrons / self.full_scale_electrons;
        }
        value += self.black_level;
        let whole = |bits| f32::from(quantised_word(value, bits)) / 65535.0;
        self.bits.map_or(value.clamp(0.0, 1.0) as f32, whole)
    }
}

/// The 16-bit word that holds `value` rounded to `bits` bits, which are at its top.
pub fn quantised_word(value: f64, bits: u32) -> u16 {
    let shift = 16 - bits.min(16);
    let levels = (1u32 << bits.min(16)) - 1;
    // Truncation rounds down, because nothing is negative after the clamp.
    let level = (value * (65535.0 / f64::from(1u32 << shift)) + 0.5).clamp(0.0, f64::from(levels));
    ((level as u32) << shift) as u16
}

/// The difference between neighbouring levels of a converter of `bits` bits, fraction of full scale.
pub fn quantisation_step(bits: u32) -> f64 {
    f64::from(1u32 << (16 - bits.min(16))) / 65535.0
}
