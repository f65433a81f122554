//! Noise as cameras and files produce it: bursts with one deviation from white noise.
//!
//! Every frame of a [`NoiseCase`] is a grey level with white Gaussian noise, except for the changes of the case.
//! Without objects, every feature is false. Values are floats without rounding unless the case is about files.

use super::noise::{quantisation_step, quantised_word};
use super::random::Stream;
use crate::burst::{Burst, LUMA_WEIGHTS};
use crate::monitor::{Cancelled, Monitor};
use crate::plane::Plane;
use serde::{Serialize, Serializer};
use std::{f64::consts::TAU, io::Cursor, ops::RangeInclusive};
use strum::IntoEnumIterator;

/// Deviation of a burst's noise from white noise.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, strum::EnumIter)]
pub enum NoiseCase {
    /// No deviation: white noise of equal strength in every frame, around half of full scale.
    #[default]
    White,
    /// Every frame occurs twice.
    Doubled,
    /// Frames are stored as JPEG files of this quality (1 … 100), 8 bits.
    Jpeg(u8),
    /// Frames are colour JPEG files of this quality (1 … 100), 8 bits, with noise in each colour; luma is searched.
    ColourJpeg(u8),
    /// Each pixel shares its noise with its neighbours, with weights 1, 2, 1 along both axes; as strong as white noise.
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
    /// As [`Self::ColumnStripes`], but the stripes move to the right by this many tenths of a pixel a frame (1 … 99).
    DriftingStripes(u8),
    /// The standard deviation varies over 250 px along both axes, from its usual value to this multiple of it (2 … 9).
    Varying(u8),
    /// The rows' brightness varies by ±2 % with a period of 180 rows, and moves by a seventh of it from frame to frame.
    Banding,
    /// As [`Self::Banding`], but the bands stay where they are.
    StillBanding,
    /// Each frame after the first is 0.8 of the frame before and 0.2 of a new one, so that the noise falls to a third.
    Smoothed,
    /// One pixel in a thousand is brighter by 5 to 20 standard deviations, in half of the frames, at random.
    FlickeringPixels,
    /// One column in fifty has an offset as strong as the noise, a new one in each frame.
    NoisyColumns,
    /// The level is black, and values below it are negative, as after subtraction of a black level.
    Negative,
    /// The level rises evenly by this many percent from the first frame to the last (1 … 99), as at dawn.
    Fading(u8),
    /// The level rises and falls again over the burst, by this many percent (1 … 99), as under clouds.
    Breathing(u8),
    /// Each frame has its own bright lines, 1 in 20 000 pixels, 5 to 40 px long, 5 to 20 standard deviations bright.
    CosmicStreaks,
    /// Each pixel has its own offset, the same in all frames, of this many percent of the noise (1 … 100).
    FixedPattern(u8),
    /// A pixel is 0 or 1, and 1 in this many percent of the frames (1 … 99), as single-photon cameras count.
    Bits(u8),
    /// As [`Self::ColumnStripes`], but none at the top and of full strength at the bottom.
    GrowingStripes,
}

/// A case with its parameters, alone or together with another one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NoiseKind {
    /// The cases; of one alone the second is white.
    pub cases: [NoiseCase; 2],
    /// Multiple of the usual strength of patterns and of changes of the level.
    pub strength: f64,
    /// Pixels after which stripes, bands and variations repeat; `None` for as usual.
    pub period_px: Option<u16>,
    /// Part of the period by which they are moved, 0 … 1.
    pub phase: f64,
}

const NOISY_HALF: f64 = 3.0;

impl From<NoiseCase> for NoiseKind {
    fn from(case: NoiseCase) -> Self {
        Self { cases: [case, NoiseCase::White], strength: 1.0, period_px: None, phase: 0.0 }
    }
}

impl NoiseCase {
    /// Grey level of the scene where no other is asked for, fraction of full scale.
    pub const LEVEL: f64 = 0.5;
    /// All cases, with the JPEG qualities, variations of strength and speeds that are commonly measured.
    pub fn all() -> Vec<Self> {
        let commonly_measured = |case| match case {
            Self::Jpeg(_) => vec![Self::Jpeg(90), Self::Jpeg(60), Self::Jpeg(30)],
            Self::ColourJpeg(_) => vec![Self::ColourJpeg(90), Self::ColourJpeg(60), Self::ColourJpeg(30)],
            Self::DriftingStripes(_) => [3, 15, 26, 40].map(Self::DriftingStripes).to_vec(),
            Self::Varying(_) => vec![Self::Varying(6), Self::Varying(2)],
            Self::Fading(_) => vec![Self::Fading(20)],
            Self::Breathing(_) => vec![Self::Breathing(10)],
            Self::FixedPattern(_) => vec![Self::FixedPattern(20)],
            Self::Bits(_) => vec![Self::Bits(10)],
            other => vec![other],
        };
        Self::iter().flat_map(commonly_measured).collect()
    }

    /// Name on the command line and in reports; [`str::parse`] reads it.
    pub fn name(self) -> String {
        if let Self::DriftingStripes(tenths) = self {
            return format!("drifting-stripes-{}.{}", tenths / 10, tenths % 10);
        }
        // The variant's own name in lower case, its words and its number joined by hyphens.
        let mut name = String::new();
        for letter in format!("{self:?}").chars().filter(|letter| *letter != ')') {
            let begins = letter.is_ascii_uppercase() && !name.is_empty();
            name.extend((begins || letter == '(').then_some('-'));
            name.extend((letter != '(').then_some(letter.to_ascii_lowercase()));
        }
        name
    }

    /// A burst of `size` (columns, rows) around half of full scale, with noise of σ `sigma` (fraction of it).
    pub fn burst(
        self,
        size: (usize, usize),
        frames: usize,
        sigma: f64,
        seed: u64,
        monitor: &Monitor,
    ) -> Result<Burst, Cancelled> {
        NoiseKind::from(self).burst_at(Self::LEVEL, size, frames, sigma, seed, monitor)
    }

    fn pattern(self, (width, height): (usize, usize), sigma: f64, kind: &NoiseKind, stream: &mut Stream) -> Plane {
        let mut pattern = Plane::zeros(width, height);
        let mut columns = |count: usize| -> Vec<f32> {
            let drawn: Vec<f32> = (0..count).map(|_| (sigma * stream.normal()) as f32).collect();
            let (period, moved) = (kind.period_px.map_or(count, usize::from), kind.moved(count));
            (0..count).map(|u| drawn[(u + moved) % period % count]).collect()
        };
        match self {
            Self::ColumnStripes => {
                let columns = columns(width);
                (0..height).for_each(|v| pattern.row_mut(v).copy_from_slice(&columns));
            }
            Self::GrowingStripes => {
                let columns = columns(width);
                pattern = Plane::from_fn(width, height, |u, v| columns[u] * v as f32 / height as f32);
            }
            Self::HotPixels | Self::FlickeringPixels => {
                let is_hot = self == Self::HotPixels;
                for _ in 0..if is_hot { 200 } else { width * height / 1000 } {
                    let (u, v) = (stream.below(width), stream.below(height));
                    pattern.row_mut(v)[u] = (sigma * stream.within(5.0, 20.0)) as f32;
                }
            }
            // Twice as many columns as are seen, so that the stripes can move.
            Self::DriftingStripes(_) => pattern = Plane::from_vec(2 * width, 1, columns(2 * width)),
            Self::FixedPattern(percent) => {
                let deviation = sigma * f64::from(percent) / 100.0;
                pattern = Plane::from_fn(width, height, |_, _| (deviation * stream.normal()) as f32);
            }
            _ => {}
        }
        pattern
    }

    /// Grey level of frame `t` of `frames`, usually `level`; `strength` multiplies its change.
    fn level(self, level: f64, (t, frames): (usize, usize), strength: f64) -> f64 {
        let over = t as f64 / (frames as f64 - 1.0).max(1.0);
        match self {
            Self::ClippedBlack | Self::Negative => 0.0,
            Self::Saturated => 1.0,
            Self::BlackFrame if t == frames / 2 => 0.0,
            Self::Fading(percent) => level * (1.0 + strength * f64::from(percent) / 100.0 * (over - 0.5)),
            Self::Breathing(percent) => {
                level * (1.0 + strength * f64::from(percent) / 100.0 * libm::sin(TAU / 2.0 * over))
            }
            _ => level,
        }
    }

    fn most_by_place(self) -> f64 {
        match self {
            Self::NoisyHalf => NOISY_HALF,
            Self::Varying(times) => f64::from(times),
            _ => 1.0,
        }
    }

    /// Multiple of the usual noise at a pixel.
    fn factor(self, (u, v): (usize, usize), width: usize, is_middle: bool, kind: &NoiseKind) -> f64 {
        match self {
            Self::NoisyFrame if is_middle => 5.0,
            Self::NoisyHalf if 2 * u >= width => NOISY_HALF,
            Self::ConstantFrame | Self::BlackFrame if is_middle => 0.0,
            Self::Constant => 0.0,
            Self::Varying(times) => {
                let wave = |x: usize| libm::sin(TAU * (x as f64 / kind.period(250.0) + kind.phase));
                libm::pow(f64::from(times), 0.5 + 0.5 * wave(u) * wave(v))
            }
            _ => 1.0,
        }
    }
}

impl NoiseKind {
    /// Name on the command line and in reports, such as `column-stripes+jpeg-90:strength=2:period=40:phase=0.5`;
    /// [`str::parse`] reads it.
    pub fn name(&self) -> String {
        let [first, second] = self.cases;
        let mut name = first.name();
        name += &if second == NoiseCase::White { String::new() } else { format!("+{}", second.name()) };
        let (strength, phase) = (self.strength, self.phase);
        name += &if strength == 1.0 { String::new() } else { format!(":strength={strength}") };
        name += &self.period_px.map_or_else(String::new, |period| format!(":period={period}"));
        name + &if phase == 0.0 { String::new() } else { format!(":phase={phase}") }
    }

    /// Point `index` of a grid over all cases, their pairs and parameters: the same for the same seed.
    pub fn drawn(index: usize, seed: u64) -> Self {
        let stream = &mut Stream::new(seed, index as u64);
        // Each case comes in its turn. Without noise all is signal, so nothing is put on top of such frames; noise by
        // place that is cut off has another mean at each place and is a picture.
        let all = NoiseCase::all();
        let (first, other) = (all[index % all.len()], all[stream.below(all.len())]);
        let pair = [first, other];
        let is_cut = pair.iter().any(|case| matches!(case, NoiseCase::ClippedBlack | NoiseCase::Saturated));
        let is_picture = is_cut && pair.iter().any(|case| case.most_by_place() > 1.0);
        let is_pair = stream.uniform() < 0.5 && !pair.contains(&NoiseCase::Constant) && first != other && !is_picture;
        Self {
            cases: [first, if is_pair { other } else { NoiseCase::White }],
            strength: [0.25, 0.5, 1.0, 2.0][stream.below(4)],
            period_px: [None, Some(7), Some(16), Some(40), Some(90)][stream.below(5)],
            phase: [0.0, 0.25, 0.5, 0.75][stream.below(4)],
        }
    }

    /// Largest multiple of the usual noise at any place, in the frames of usual noise.
    pub fn most_by_place(&self) -> f64 {
        self.cases.iter().map(|case| case.most_by_place()).product()
    }

    fn has(&self, case: NoiseCase) -> bool {
        self.cases.contains(&case)
    }

    fn period(&self, usual: f64) -> f64 {
        self.period_px.map_or(usual, f64::from)
    }

    /// Pixels by which a pattern that usually repeats after `usual` is moved.
    fn moved(&self, usual: usize) -> usize {
        (self.phase * self.period(usual as f64)) as usize
    }

    /// A burst of `size` (columns, rows) around the grey `level`, where no case has its own, with noise of σ `sigma`;
    /// both are fractions of full scale.
    pub fn burst_at(
        &self,
        level: f64,
        size: (usize, usize),
        frames: usize,
        sigma: f64,
        seed: u64,
        monitor: &Monitor,
    ) -> Result<Burst, Cancelled> {
        // Stream 0 is for the pattern shared by all frames; frame t has stream t + 1.
        let pattern_streams = [0, u64::MAX];
        let pattern = |k: usize| self.cases[k].pattern(size, sigma, self, &mut Stream::new(seed, pattern_streams[k]));
        let patterns = [pattern(0), pattern(1)];
        // A stream beyond those of the frames: gains change no noise.
        let mut exposures = Stream::new(seed, frames as u64 + 1);
        let mut planes: Vec<Plane> = Vec::with_capacity(frames);
        for t in 0..frames {
            monitor.check()?;
            if self.has(NoiseCase::Doubled) && t % 2 == 1 {
                planes.push(planes[t - 1].clone());
                continue;
            }
            let stream = &mut Stream::new(seed, t as u64 + 1);
            let drawn = |stream: &mut Stream| self.frame(size, (level, sigma), &patterns, (t, frames), stream);
            let mut frame = drawn(stream);
            for case in self.cases {
                frame = match case {
                    NoiseCase::GainFlicker => {
                        let gain = 1.0 + 0.1 * self.strength * exposures.normal();
                        mapped(&frame, |x| (f64::from(x) * gain) as f32)
                    }
                    NoiseCase::Jpeg(quality) => through_jpeg(&[&frame], quality),
                    NoiseCase::ColourJpeg(quality) => {
                        // Independent noise in each channel, as colours of a sensor have.
                        let [green, blue] = [(); 2].map(|()| drawn(stream));
                        through_jpeg(&[&frame, &green, &blue], quality)
                    }
                    NoiseCase::Correlated => with_shared_noise(&frame, level),
                    NoiseCase::ClippedBlack | NoiseCase::Saturated => mapped(&frame, |x| x.clamp(0.0, 1.0)),
                    // A filter over time, as of a camera that denoises: neighbouring frames share noise.
                    NoiseCase::Smoothed => match planes.last() {
                        Some(before) => {
                            let share = 0.8;
                            let both = before.data().iter().zip(frame.data());
                            Plane::from_vec(size.0, size.1, both.map(|(b, x)| share * b + (1.0 - share) * x).collect())
                        }
                        None => frame,
                    },
                    NoiseCase::Bits(percent) => {
                        mapped(&frame, |_| f32::from(stream.uniform() < f64::from(percent) / 100.0))
                    }
                    NoiseCase::NoisyColumns => self.with_noisy_columns(frame, sigma, stream),
                    NoiseCase::CosmicStreaks => with_streaks(frame, self.strength * sigma, stream),
                    _ => frame,
                };
            }
            planes.push(frame);
        }
        let mut burst = Burst::from_planes(self.name(), planes);
        if self.cases.iter().any(|case| matches!(case, NoiseCase::Jpeg(_) | NoiseCase::ColourJpeg(_))) {
            // All other cases are floats without rounding.
            burst.quantisation_step = quantisation_step(8) as f32;
        }
        Ok(burst)
    }

    /// Frame `t` of `frames` before the effects of files and exposures.
    fn frame(
        &self,
        size: (usize, usize),
        (level, sigma): (f64, f64),
        patterns: &[Plane; 2],
        (t, frames): (usize, usize),
        stream: &mut Stream,
    ) -> Plane {
        let level = self.cases.iter().fold(level, |level, case| case.level(level, (t, frames), self.strength));
        let band =
            |v: usize, phase: f64| level * 0.02 * libm::sin(TAU * (v as f64 / self.period(180.0) + self.phase + phase));
        let added = |k: usize, u: usize, v: usize, stream: &mut Stream| match self.cases[k] {
            NoiseCase::DriftingStripes(tenths) => {
                // Frame 0 shows the stripes from half of their columns on, so that they can come in from the left.
                let drifted = ((u + size.0 / 2) as f64 - f64::from(tenths) / 10.0 * t as f64).max(0.0);
                let (whole, part) = (drifted as usize, drifted.fract() as f32);
                (1.0 - part) * patterns[k].at(whole, 0) + part * patterns[k].at(whole + 1, 0)
            }
            NoiseCase::Banding => band(v, (1.0 / 7.0) * t as f64) as f32,
            NoiseCase::StillBanding => band(v, 0.0) as f32,
            NoiseCase::FlickeringPixels if patterns[k].at(u, v) > 0.0 && stream.uniform() < 0.5 => 0.0,
            _ => patterns[k].at(u, v),
        };
        let (is_middle, strength) = (t == frames / 2, self.strength as f32);
        Plane::from_fn(size.0, size.1, |u, v| {
            let factor: f64 = self.cases.iter().map(|case| case.factor((u, v), size.0, is_middle, self)).product();
            let noise = sigma * factor * stream.normal();
            (level + noise) as f32 + strength * added(0, u, v, stream) + strength * added(1, u, v, stream)
        })
    }

    fn with_noisy_columns(&self, mut frame: Plane, sigma: f64, stream: &mut Stream) -> Plane {
        let period = self.period(50.0) as usize;
        for u in ((period / 2 + self.moved(50)) % period..frame.width()).step_by(period) {
            let offset = (self.strength * sigma * stream.normal()) as f32;
            (0..frame.height()).for_each(|v| frame.row_mut(v)[u] += offset);
        }
        frame
    }
}

impl std::str::FromStr for NoiseKind {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let mut parts = text.split(':');
        let mut cases = parts.next().unwrap_or_default().splitn(2, '+');
        let mut kind = Self::from(cases.next().unwrap_or_default().parse::<NoiseCase>()?);
        kind.cases[1] = cases.next().map_or(Ok(NoiseCase::White), str::parse)?;
        for part in parts {
            let number = part.split_once('=').and_then(|(name, value)| Some((name, value.parse::<f64>().ok()?)));
            match number {
                Some(("strength", x)) if (0.0..=100.0).contains(&x) => kind.strength = x,
                Some(("period", x)) if (2.0..=9999.0).contains(&x) && x.fract() == 0.0 => {
                    kind.period_px = Some(x as u16);
                }
                Some(("phase", x)) if (0.0..1.0).contains(&x) => kind.phase = x,
                _ => {
                    let right = "strength=0 … 100, period=2 … 9999 pixels, or phase=0 … 1 (of it)";
                    return Err(format!("'{part}' is none of {right}, such as column-stripes:strength=2:period=40"));
                }
            }
        }
        Ok(kind)
    }
}

impl std::str::FromStr for NoiseCase {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let number = |prefix: &str, range: RangeInclusive<u8>| {
            text.strip_prefix(prefix).and_then(|n| n.parse().ok()).filter(|n| range.contains(n))
        };
        let tenths = |text: &str| {
            let (whole, part) = text.split_once('.').unwrap_or((text, "0"));
            let digit = |text: &str| text.parse::<u8>().ok().filter(|n| *n <= 9);
            digit(whole).zip(digit(part)).map(|(whole, part)| 10 * whole + part).filter(|n| *n > 0)
        };
        // Names with a number first: `all` has only the numbers that are commonly measured.
        let found = (number("jpeg-", 1..=100).map(Self::Jpeg))
            .or_else(|| number("colour-jpeg-", 1..=100).map(Self::ColourJpeg))
            .or_else(|| number("varying-", 2..=9).map(Self::Varying))
            .or_else(|| number("fading-", 1..=99).map(Self::Fading))
            .or_else(|| number("breathing-", 1..=99).map(Self::Breathing))
            .or_else(|| number("bits-", 1..=99).map(Self::Bits))
            .or_else(|| number("fixed-pattern-", 1..=100).map(Self::FixedPattern))
            .or_else(|| text.strip_prefix("drifting-stripes-").and_then(tenths).map(Self::DriftingStripes));
        if let Some(found) = found {
            return Ok(found);
        }
        Self::all().into_iter().find(|case| case.name() == text).ok_or_else(|| {
            let names: Vec<String> = Self::all().into_iter().map(|case| case.name()).collect();
            format!(
                "'{text}' is none of {} (any quality from 1 to 100, multiple from 2 to 9, percentage from 1 to 99, and speed from \
                 0.1 to 9.9 px/frame)",
                names.join(", ")
            )
        })
    }
}

impl Serialize for NoiseKind {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(&self.name())
    }
}

fn mapped(plane: &Plane, value: impl FnMut(f32) -> f32) -> Plane {
    Plane::from_vec(plane.width(), plane.height(), plane.data().iter().copied().map(value).collect())
}

/// The frame after storage in an 8-bit JPEG file of `quality`: grey for one channel, the luma of three.
fn through_jpeg(channels: &[&Plane], quality: u8) -> Plane {
    let (width, height) = channels[0].size();
    // Rounded as a camera of 8 bits rounds.
    let byte = |x: f32| (quantised_word(f64::from(x), 8) >> 8) as u8;
    let bytes: Vec<u8> =
        (0..width * height).flat_map(|i| channels.iter().map(move |channel| byte(channel.data()[i]))).collect();
    let colour = if channels.len() == 1 { image::ExtendedColorType::L8 } else { image::ExtendedColorType::Rgb8 };
    let mut file = Vec::new();
    image::codecs::jpeg::JpegEncoder::new_with_quality(&mut file, quality)
        .encode(&bytes, width as u32, height as u32, colour)
        .expect("a picture of a burst's size can be a JPEG file");
    let decoded = image::load(Cursor::new(file), image::ImageFormat::Jpeg).expect("the file was just written");
    let grey = |pixel: &[u8]| match pixel {
        [grey] => f32::from(*grey),
        _ => pixel.iter().zip(LUMA_WEIGHTS).map(|(x, weight)| weight * f32::from(*x)).sum(),
    };
    let values = decoded.as_bytes().chunks_exact(channels.len()).map(|pixel| grey(pixel) / 255.0);
    Plane::from_vec(width, height, values.collect())
}

fn with_streaks(mut frame: Plane, sigma: f64, stream: &mut Stream) -> Plane {
    let (width, height) = frame.size();
    for _ in 0..(width * height).div_ceil(20_000) {
        let (u, v) = (width as f64 * stream.uniform(), height as f64 * stream.uniform());
        let (along, across) = (libm::cos(TAU * stream.uniform()), stream.uniform() < 0.5);
        let across = (1.0 - along * along).sqrt() * if across { 1.0 } else { -1.0 };
        let amplitude = (sigma * stream.within(5.0, 20.0)) as f32;
        // Steps of a pixel along the longer axis, so that each pixel of the line is lit once.
        let longer = along.abs().max(across.abs());
        let steps = (stream.within(5.0, 40.0) * longer) as usize;
        for i in 0..=steps {
            let at = |from: f64, by: f64| (from + i as f64 * by / longer).round();
            let (x, y) = (at(u, along), at(v, across));
            if x >= 0.0 && y >= 0.0 && (x as usize) < width && (y as usize) < height {
                frame.row_mut(y as usize)[x as usize] += amplitude;
            }
        }
    }
    frame
}

/// The frame around `level` filtered by 1, 2, 1 along both axes and scaled to its previous strength.
fn with_shared_noise(frame: &Plane, level: f64) -> Plane {
    let (width, height) = frame.size();
    let at = |u: i64, v: i64| frame.at(u.clamp(0, width as i64 - 1) as usize, v.clamp(0, height as i64 - 1) as usize);
    // The weights' squares sum to (1 + 4 + 1)².
    let scale = 1.0 / 6.0;
    Plane::from_fn(width, height, |u, v| {
        let line = |dv: i64| {
            let at = |du: i64| at(u as i64 + du, v as i64 + dv) - level as f32;
            at(-1) + 2.0 * at(0) + at(1)
        };
        level as f32 + scale * (line(-1) + 2.0 * line(0) + line(1))
    })
}
