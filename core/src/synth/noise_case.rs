//! Noise as cameras and files produce it: bursts of a scene without structure, each with one deviation from white
//! noise.
//!
//! Every frame is a grey level with white Gaussian noise, except for the changes of the [`NoiseCase`]. There are no
//! objects, so every feature of such a burst is false. Values are floats without rounding unless the case is about
//! files.

use super::noise::{quantisation_step, quantised_word};
use super::random::Stream;
use crate::burst::Burst;
use crate::monitor::{Cancelled, Monitor};
use crate::plane::Plane;
use serde::{Serialize, Serializer};
use std::io::Cursor;

/// Deviation of a burst's noise from white noise.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum NoiseCase {
    /// No deviation: white noise of equal strength in every frame, around half of full scale.
    #[default]
    White,
    /// Every frame occurs twice.
    Doubled,
    /// Frames are stored as JPEG files of this quality (1 … 100), 8 bits.
    Jpeg(u8),
    /// Each pixel shares its noise with the neighbouring pixels, with weights 1, 2, 1 along both axes; as strong as
    /// white noise.
    Correlated,
    /// The middle frame is black.
    BlackFrame,
    /// The middle frame has five times the noise.
    NoisyFrame,
    /// The right half has three times the noise.
    NoisyHalf,
    /// Each column has its own offset, as strong as the noise, the same in all frames.
    ColumnStripes,
    /// 200 pixels are brighter by 5 to 20 standard deviations, the same in all frames.
    HotPixels,
    /// Each frame has its own exposure, with a spread of 10 %.
    GainFlicker,
    /// The level is black, so that half of the noise is clipped.
    ClippedBlack,
    /// The level is white, so that half of the noise is clipped.
    Saturated,
    /// The middle frame has no noise, like a dropped one that was filled.
    ConstantFrame,
    /// No frame has noise.
    Constant,
}

/// Ratio of the noise of the middle frame of [`NoiseCase::NoisyFrame`] to that of the others.
const NOISY_FRAME: f64 = 5.0;
/// Ratio of the noise of the right half of [`NoiseCase::NoisyHalf`] to that of the left.
const NOISY_HALF: f64 = 3.0;
/// Number of hot pixels of [`NoiseCase::HotPixels`].
const HOT_PIXELS: usize = 200;
/// Spread of exposures of [`NoiseCase::GainFlicker`].
const FLICKER: f64 = 0.1;
/// Grey level of the scene, fraction of full scale.
const LEVEL: f64 = 0.5;

impl NoiseCase {
    /// All cases, with the JPEG qualities that are commonly measured.
    pub const ALL: [Self; 16] = [
        Self::White,
        Self::Doubled,
        Self::Jpeg(90),
        Self::Jpeg(60),
        Self::Jpeg(30),
        Self::Correlated,
        Self::BlackFrame,
        Self::NoisyFrame,
        Self::NoisyHalf,
        Self::ColumnStripes,
        Self::HotPixels,
        Self::GainFlicker,
        Self::ClippedBlack,
        Self::Saturated,
        Self::ConstantFrame,
        Self::Constant,
    ];

    /// Name on the command line and in reports; [`str::parse`] reads it.
    pub fn name(self) -> String {
        let word = match self {
            Self::White => "white",
            Self::Doubled => "doubled",
            Self::Jpeg(quality) => return format!("jpeg-{quality}"),
            Self::Correlated => "correlated",
            Self::BlackFrame => "black-frame",
            Self::NoisyFrame => "noisy-frame",
            Self::NoisyHalf => "noisy-half",
            Self::ColumnStripes => "column-stripes",
            Self::HotPixels => "hot-pixels",
            Self::GainFlicker => "gain-flicker",
            Self::ClippedBlack => "clipped-black",
            Self::Saturated => "saturated",
            Self::ConstantFrame => "constant-frame",
            Self::Constant => "constant",
        };
        word.to_owned()
    }

    /// Makes a burst of `frames` frames of `size` = (columns, rows), with noise of standard deviation `sigma` (fraction
    /// of full scale) unless the case changes it.
    ///
    /// # Errors
    /// [`Cancelled`] once `monitor` was cancelled.
    pub fn burst(
        self,
        size: (usize, usize),
        frames: usize,
        sigma: f64,
        seed: u64,
        monitor: &Monitor,
    ) -> Result<Burst, Cancelled> {
        // Stream 0 is for the pattern shared by all frames; frame t has stream t + 1.
        let pattern = self.pattern(size, sigma, &mut Stream::new(seed, 0));
        let mut exposures = Stream::new(seed, frames as u64 + 1);
        let mut planes: Vec<Plane> = Vec::with_capacity(frames);
        for t in 0..frames {
            monitor.check()?;
            if self == Self::Doubled && t % 2 == 1 {
                planes.push(planes[t - 1].clone());
                continue;
            }
            let middle = t == frames / 2;
            let gain = if self == Self::GainFlicker { 1.0 + FLICKER * exposures.normal() } else { 1.0 };
            let frame = self.frame(size, sigma, &pattern, middle, &mut Stream::new(seed, t as u64 + 1));
            planes.push(match self {
                Self::GainFlicker => mapped(&frame, |x| (f64::from(x) * gain) as f32),
                Self::Jpeg(quality) => through_jpeg(&frame, quality),
                Self::Correlated => with_shared_noise(&frame),
                Self::ClippedBlack | Self::Saturated => mapped(&frame, |x| x.clamp(0.0, 1.0)),
                _ => frame,
            });
        }
        let mut burst = Burst::from_planes(self.name(), planes);
        if matches!(self, Self::Jpeg(_)) {
            burst.quantisation_step = quantisation_step(8) as f32;
        }
        Ok(burst)
    }

    /// The pattern added to every frame.
    fn pattern(self, (width, height): (usize, usize), sigma: f64, stream: &mut Stream) -> Plane {
        let mut pattern = Plane::zeros(width, height);
        match self {
            Self::ColumnStripes => {
                let columns: Vec<f32> = (0..width).map(|_| (sigma * stream.normal()) as f32).collect();
                (0..height).for_each(|v| pattern.row_mut(v).copy_from_slice(&columns));
            }
            Self::HotPixels => {
                for _ in 0..HOT_PIXELS {
                    let (u, v) = (stream.below(width), stream.below(height));
                    pattern.row_mut(v)[u] = (sigma * stream.within(5.0, 20.0)) as f32;
                }
            }
            _ => {}
        }
        pattern
    }

    /// One frame before the effects of files and exposures; `middle` is true for the middle one.
    fn frame(self, size: (usize, usize), sigma: f64, pattern: &Plane, middle: bool, stream: &mut Stream) -> Plane {
        let level = match self {
            Self::ClippedBlack => 0.0,
            Self::Saturated => 1.0,
            Self::BlackFrame if middle => 0.0,
            _ => LEVEL,
        };
        let factor = |u: usize| match self {
            Self::NoisyFrame if middle => NOISY_FRAME,
            Self::NoisyHalf if 2 * u >= size.0 => NOISY_HALF,
            Self::ConstantFrame if middle => 0.0,
            Self::BlackFrame if middle => 0.0,
            Self::Constant => 0.0,
            _ => 1.0,
        };
        Plane::from_fn(size.0, size.1, |u, v| (level + sigma * factor(u) * stream.normal()) as f32 + pattern.at(u, v))
    }
}

impl std::str::FromStr for NoiseCase {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let quality = text.strip_prefix("jpeg-").and_then(|q| q.parse().ok());
        if let Some(quality @ 1..=100) = quality {
            return Ok(Self::Jpeg(quality));
        }
        Self::ALL.into_iter().find(|case| case.name() == text).ok_or_else(|| {
            let names: Vec<String> = Self::ALL.iter().map(|case| case.name()).collect();
            format!("'{text}' is none of {} (any quality from 1 to 100)", names.join(", "))
        })
    }
}

impl Serialize for NoiseCase {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(&self.name())
    }
}

fn mapped(plane: &Plane, value: impl Fn(f32) -> f32) -> Plane {
    Plane::from_vec(plane.width(), plane.height(), plane.data().iter().map(|&x| value(x)).collect())
}

/// The frame after storage in an 8-bit grey JPEG file of `quality`.
fn through_jpeg(frame: &Plane, quality: u8) -> Plane {
    let (width, height) = frame.size();
    let grey: Vec<u8> = frame.data().iter().map(|&x| (quantised_word(f64::from(x), 8) >> 8) as u8).collect();
    let mut file = Vec::new();
    image::codecs::jpeg::JpegEncoder::new_with_quality(&mut file, quality)
        .encode(&grey, width as u32, height as u32, image::ExtendedColorType::L8)
        .expect("a grey picture of a burst's size can be a JPEG file");
    let decoded = image::load(Cursor::new(file), image::ImageFormat::Jpeg).expect("the file was just written");
    Plane::from_vec(width, height, decoded.to_luma8().iter().map(|&x| f32::from(x) / 255.0).collect())
}

/// The frame around [`LEVEL`] filtered by 1, 2, 1 along both axes and scaled to its previous strength.
fn with_shared_noise(frame: &Plane) -> Plane {
    let (width, height) = frame.size();
    let at = |u: i64, v: i64| frame.at(u.clamp(0, width as i64 - 1) as usize, v.clamp(0, height as i64 - 1) as usize);
    // The weights' squares sum to (1 + 4 + 1)².
    let scale = 1.0 / 6.0;
    Plane::from_fn(width, height, |u, v| {
        let line = |dv: i64| {
            let at = |du: i64| at(u as i64 + du, v as i64 + dv) - LEVEL as f32;
            at(-1) + 2.0 * at(0) + at(1)
        };
        LEVEL as f32 + scale * (line(-1) + 2.0 * line(0) + line(1))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: (usize, usize) = (200, 120);

    fn burst(case: NoiseCase) -> Burst {
        case.burst(SIZE, 10, 0.02, 3, &Monitor::default()).expect("not cancelled")
    }

    /// Mean and standard deviation of the columns `columns` of frame `t`.
    fn of_frame(burst: &Burst, t: usize, columns: std::ops::Range<usize>) -> (f64, f64) {
        let frame = &burst.frames[t];
        let values: Vec<f64> =
            (0..SIZE.1).flat_map(|v| frame.row(v)[columns.clone()].iter().map(|&x| f64::from(x))).collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        (mean, (values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / values.len() as f64).sqrt())
    }

    #[test]
    fn names_are_read_back_and_others_are_refused() {
        for case in NoiseCase::ALL {
            assert_eq!(case.name().parse(), Ok(case));
        }
        assert_eq!("jpeg-77".parse(), Ok(NoiseCase::Jpeg(77)));
        for bad in ["jpeg-0", "jpeg-101", "grey", ""] {
            let error = bad.parse::<NoiseCase>().expect_err(bad);
            assert!(error.contains("column-stripes"), "{error}");
        }
    }

    #[test]
    fn every_case_is_what_it_says() {
        let all = 0..SIZE.0;
        let near = |a: f64, b: f64| (a / b - 1.0).abs() < 0.03;
        let doubled = burst(NoiseCase::Doubled);
        assert!(doubled.frames[4] == doubled.frames[5] && doubled.frames[5] != doubled.frames[6]);
        assert_eq!(of_frame(&burst(NoiseCase::BlackFrame), 5, all.clone()), (0.0, 0.0));
        assert!(near(of_frame(&burst(NoiseCase::NoisyFrame), 5, all.clone()).1, 0.1));
        assert!(near(of_frame(&burst(NoiseCase::NoisyFrame), 4, all.clone()).1, 0.02));
        let half = burst(NoiseCase::NoisyHalf);
        assert!(near(of_frame(&half, 2, 0..100).1, 0.02) && near(of_frame(&half, 2, 100..200).1, 0.06));
        assert!(near(of_frame(&burst(NoiseCase::Correlated), 1, all.clone()).1, 0.02));
        assert!(near(of_frame(&burst(NoiseCase::ClippedBlack), 1, all.clone()).0, 0.02 * 0.398_9));
        assert!(near(1.0 - of_frame(&burst(NoiseCase::Saturated), 1, all.clone()).0, 0.02 * 0.398_9));
        assert_eq!(of_frame(&burst(NoiseCase::ConstantFrame), 5, all.clone()).1, 0.0);
        assert_eq!(of_frame(&burst(NoiseCase::Constant), 1, all.clone()), (0.5, 0.0));
        let flicker = burst(NoiseCase::GainFlicker);
        let means: Vec<f64> = (0..10).map(|t| of_frame(&flicker, t, all.clone()).0 / 0.5 - 1.0).collect();
        let spread = (means.iter().map(|x| x * x).sum::<f64>() / 10.0).sqrt();
        assert!((0.04..0.2).contains(&spread), "{spread}");
    }

    #[test]
    fn fixed_patterns_stay_and_jpeg_files_lose_fine_noise() {
        let mean_of = |case: NoiseCase| {
            let burst = burst(case);
            Plane::from_fn(SIZE.0, SIZE.1, |u, v| burst.frames.iter().map(|f| f.at(u, v)).sum::<f32>() / 10.0)
        };
        let stripes = mean_of(NoiseCase::ColumnStripes);
        let columns: Vec<f32> =
            (0..SIZE.0).map(|u| (0..SIZE.1).map(|v| stripes.at(u, v)).sum::<f32>() / SIZE.1 as f32 - 0.5).collect();
        let spread = (columns.iter().map(|x| x * x).sum::<f32>() / SIZE.0 as f32).sqrt();
        assert!((spread / 0.02 - 1.0).abs() < 0.15, "{spread}");
        let hot = mean_of(NoiseCase::HotPixels).data().iter().filter(|&&x| x > 0.5 + 0.08).count();
        assert!((HOT_PIXELS * 9 / 10..=HOT_PIXELS).contains(&hot), "{hot}");
        // Neighbouring pixels differ less with stronger compression.
        let difference = |case| {
            let frame = &burst(case).frames[0];
            let differences = frame.data().windows(2).map(|w| (w[1] - w[0]).powi(2));
            differences.sum::<f32>() / (frame.data().len() - 1) as f32
        };
        let [white, fine, coarse] = [NoiseCase::White, NoiseCase::Jpeg(90), NoiseCase::Jpeg(30)].map(difference);
        assert!(coarse < 0.1 * fine && fine < 1.1 * white, "{white} {fine} {coarse}");
    }
}
