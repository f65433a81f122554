//! Detection on noise alone: the number of features found where all are false.
//!
//! Bursts of Gaussian noise around half of full scale are searched with the given parameters: white noise, exact and
//! rounded to the levels of a converter, and noise as cameras and files produce it ([`NoiseKind`]). The noise gate
//! promises at most one feature, all being false, in a million pixels of the image, for any noise and number of slopes.

use super::RowStudy;
use crate::synth::noise::{quantisation_step, quantised_word};
use crate::synth::{NoiseCase, NoiseKind, random::Stream};
use burstscope_core::burst::{Burst, Positions};
use burstscope_core::detector::{DetectorParams, SlopeGrid, noise::gate_factor, params::doc};
use burstscope_core::error::{Error, Result};
use burstscope_core::{detect::detect, monitor::Monitor, plane::Plane};
use serde::Serialize;

/// One kind of noise.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct NoiseLevel {
    /// Standard deviation in one frame, fraction of full scale.
    pub sigma: f64,
    /// Bits of the converter that rounds the noise, 4 … 16; `None` without rounding.
    pub bits: Option<u32>,
    /// Deviation from white noise; only white noise is rounded to `bits`.
    pub case: NoiseKind,
    /// Grey level of the frames, fraction of full scale.
    pub mean: f64,
}

/// A search and its name.
#[derive(Debug, Clone, PartialEq)]
pub struct NoiseSearch {
    /// Name in a table, such as "BuFF 1D".
    pub label: String,
    /// The detector's parameters.
    pub detector: DetectorParams,
}

/// Kinds of noise and searches of a study on noise alone.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "cli", derive(clap::Args))]
pub struct NoiseStudy {
    /// Kinds of noise, one row for each.
    #[cfg_attr(feature = "cli", arg(skip))]
    pub levels: Vec<NoiseLevel>,
    /// Searches, one column for each.
    #[cfg_attr(feature = "cli", arg(skip))]
    pub searches: Vec<NoiseSearch>,
    /// Frames of a burst.
    #[cfg_attr(feature = "cli", arg(skip = Self::default().frames))]
    pub frames: usize,
    /// Millions of pixels of the image to be searched for each number of the table, at least.
    #[cfg_attr(feature = "cli", arg(long, value_name = "MPX", default_value_t = Self::default().megapixels))]
    pub megapixels: f64,
    /// Number of bursts for each number of the table, instead of --megapixels; the table then shows the largest count
    /// of one of them.
    #[cfg_attr(feature = "cli", arg(long, value_name = "N", conflicts_with = "megapixels"))]
    pub seeds: Option<usize>,
    /// Number of kinds of noise drawn from a grid of all cases, alone and in pairs, their strengths, periods, phases
    /// and levels; the ten with most false features are measured again with other seeds, ten times as long, and shown.
    #[cfg_attr(feature = "cli", arg(long, value_name = "N", conflicts_with_all = ["case", "sigma", "bits"]))]
    pub cases: Option<usize>,
    /// The first burst's seed.
    #[cfg_attr(feature = "cli", arg(long = "seed", value_name = "FIRST", default_value_t = 1))]
    pub first_seed: u64,
    /// Columns.
    #[cfg_attr(feature = "cli", arg(long, value_name = "PIXELS", default_value_t = Self::default().width))]
    pub width: usize,
    /// Rows.
    #[cfg_attr(feature = "cli", arg(long, value_name = "PIXELS", default_value_t = Self::default().height))]
    pub height: usize,
}

/// Distance from black and white in standard deviations from which noise is not cut off.
const NOT_CUT: f64 = 4.0;

impl NoiseStudy {
    /// `count` kinds of noise from a grid of all: the same for the same `seed`. Noise that differs by place stays clear
    /// of black and white: cut off, its mean would differ too, and be a picture.
    pub fn drawn_levels(count: usize, seed: u64) -> Vec<NoiseLevel> {
        let level = |index: usize| {
            let stream = &mut Stream::new(seed, (1 << 40) + index as u64);
            let case = NoiseKind::drawn(index, seed);
            let drawn = [0.005, 0.02, 0.05][stream.below(3)];
            let mean: f64 = [0.15, 0.3, 0.5, 0.7][stream.below(4)];
            let most = (1e3 * mean.min(1.0 - mean) / (NOT_CUT * case.most_by_place())).floor() / 1e3;
            let sigma = if case.most_by_place() > 1.0 { f64::min(drawn, most) } else { drawn };
            NoiseLevel { sigma, bits: None, case, mean }
        };
        (0..count).map(level).collect()
    }

    /// A study of the `count` worst kinds of `report`, with ten times as many bursts, of the seeds after its own.
    pub fn again(&self, report: &NoiseReport, count: usize) -> Self {
        let mut rows: Vec<&NoiseRow> = report.rows.iter().collect();
        rows.sort_by(|a, b| b.most().total_cmp(&a.most()));
        let levels = rows.iter().take(count).map(|row| row.level).collect();
        let (seeds, first_seed) = (Some(10 * report.bursts), self.first_seed + report.bursts as u64);
        Self { levels, seeds, first_seed, ..self.clone() }
    }

    fn burst_megapixels(&self) -> f64 {
        (self.width * self.height) as f64 * 1e-6
    }

    /// The searches of BuFF 1D and 2D as charts have them: 13 slopes, and 7×7, over ±3 px/frame.
    pub fn searches(detector: &DetectorParams) -> Vec<NoiseSearch> {
        let search = |label: &str, slopes: SlopeGrid| NoiseSearch {
            label: label.to_owned(),
            detector: DetectorParams { slopes, ..detector.clone() },
        };
        vec![
            search("BuFF 1D", SlopeGrid::line(-3.0..=3.0, 13)),
            search("BuFF 2D", SlopeGrid::plane(-3.0..=3.0, 7, -3.0..=3.0, 7)),
        ]
    }
}

impl Default for NoiseStudy {
    /// Weak, medium and strong white noise, exact and rounded to 8 bits; 50 million pixels each.
    fn default() -> Self {
        let levels =
            [None, Some(8)].into_iter().flat_map(|bits| [0.002, 0.02, 0.1].map(|sigma| NoiseLevel::white(sigma, bits)));
        Self {
            levels: levels.collect(),
            searches: Self::searches(&DetectorParams::default()),
            width: 800,
            height: 600,
            frames: 10,
            megapixels: 50.0,
            seeds: None,
            cases: None,
            first_seed: 1,
        }
    }
}

/// Report of a study on noise alone.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[allow(missing_docs)] // where a name says it
pub struct NoiseReport {
    pub width: usize,
    pub height: usize,
    pub frames: usize,
    pub first_seed: u64,
    /// Number of bursts searched for each row.
    pub bursts: usize,
    /// Pixels of the image that were searched for each row, in millions.
    pub megapixels: f64,
    pub rows: Vec<NoiseRow>,
}

/// Results for one kind of noise.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NoiseRow {
    /// The noise.
    pub level: NoiseLevel,
    /// Results of the searches, in the study's order.
    pub searches: Vec<NoiseCount>,
}

impl NoiseRow {
    /// Most false features in a million pixels by one of the searches.
    pub fn most(&self) -> f64 {
        self.searches.iter().map(|search| search.per_megapixel).fold(0.0, f64::max)
    }
}

/// Result of one search in one kind of noise.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[allow(missing_docs)] // where a name says it
pub struct NoiseCount {
    pub label: String,
    pub slopes: usize,
    pub noise_gate_factor: f32,
    /// Number of features, all of them false.
    pub false_features: usize,
    /// Number of bursts in which the strict gate refuses to promise anything; they are not searched.
    pub refused: usize,
    /// Number of features in each burst, from the first seed on.
    pub of_bursts: Vec<usize>,
    /// Number of features per million pixels of the image, of the bursts searched; NaN where there are none.
    pub per_megapixel: f64,
    /// Standard error of that, for independent features: √count over the millions of pixels.
    pub standard_error: f64,
    /// Mean of the estimated noise of a frame over the true one (with its rounding), for white noise.
    pub noise_estimate_ratio: Option<f64>,
}

impl RowStudy for NoiseStudy {
    type Row = NoiseLevel;
    /// Of each search the number of features, and the estimated noise of a frame.
    type Cell = Vec<(usize, f64)>;
    type Report = NoiseReport;

    fn check(&self) -> Result<()> {
        let check = |is_right: bool, parameter, problem: String, remedy| {
            if is_right { Ok(()) } else { Err(Error::param(parameter, problem, remedy)) }
        };
        for &NoiseLevel { sigma, bits, case, mean } in &self.levels {
            let remedy = "give standard deviations above 0 and up to 0.1, so that nothing is cut off at black or white";
            check(sigma > 0.0 && sigma <= 0.1, "sigma", sigma.to_string(), remedy)?;
            check(mean > 0.0 && mean < 1.0, "case_level", mean.to_string(), "give a level between 0 and 1")?;
            let is_white = bits.is_none() || case == NoiseCase::White.into();
            check(is_white, "bits", format!("{bits:?} of {}", case.name()), "round white noise only")?;
            let can_round = bits.is_none_or(|bits| (4..=16).contains(&bits));
            check(can_round, "bits", format!("{bits:?}"), "give 4 to 16")?;
        }
        let is_any = !self.levels.is_empty() && !self.searches.is_empty();
        check(is_any, "sigma", "no noise or no search is given".to_owned(), "give one or more")?;
        let (size, pixels) = (format!("{}×{}", self.width, self.height), self.width as f64 * self.height as f64);
        let fits = [self.width, self.height].iter().all(|side| (16..=32768).contains(side)) && pixels <= 1e8;
        check(fits, "width", format!("{size} pixels"), "give 16 to 32768 a side, 100 million at most")?;
        // As f32 the largest burst takes 8 GB, and each thread holds a burst.
        let fits = (1..=4096).contains(&self.frames) && pixels * self.frames as f64 <= 2e9;
        let remedy = "give 1 to 4096 frames, 2000 million pixels at most";
        check(fits, "frames", format!("{} frames of {size}", self.frames), remedy)?;
        let can_count = self.seeds.is_none_or(|seeds| (1..=1_000_000).contains(&seeds));
        check(can_count, "seeds", format!("{:?}", self.seeds), "give 1 to a million")?;
        let remedy = "give millions of pixels, above 0 and up to a million";
        let is_area = self.megapixels > 0.0 && self.megapixels <= 1e6;
        check(is_area, "megapixels", self.megapixels.to_string(), remedy)?;
        for search in &self.searches {
            search.detector.validate_for(&Positions::even(self.frames), (self.width, self.height))?;
        }
        Ok(())
    }

    fn rows(&self) -> Vec<NoiseLevel> {
        self.levels.clone()
    }

    fn seeds(&self) -> (u64, u64) {
        let bursts = self.seeds.unwrap_or((self.megapixels / self.burst_megapixels()).ceil().max(1.0) as usize);
        (self.first_seed, bursts as u64)
    }

    fn steps(&self, _: NoiseLevel) -> usize {
        self.searches.len()
    }

    fn cell(
        &self,
        level: NoiseLevel,
        seed: u64,
        monitor: &Monitor,
        done: &(dyn Fn(usize) + Sync),
    ) -> Result<Vec<(usize, f64)>> {
        // All searches share a burst, so that the columns of a row differ by the search alone.
        let burst = noise_burst(level, (self.width, self.height), self.frames, seed, monitor)?;
        let search = |search: &NoiseSearch| {
            let found = detect(&burst, &search.detector, monitor);
            done(1);
            match found {
                // Where a gate says that it can promise nothing, no promise is broken.
                Err(error) if error.subject == doc::NOISE_GATE.name => Ok((0, f64::NAN)),
                found => found.map(|found| (found.features.len(), f64::from(found.frame_noise))),
            }
        };
        self.searches.iter().map(search).collect()
    }

    fn report(&self, rows: &[(NoiseLevel, Vec<Vec<(usize, f64)>>)]) -> NoiseReport {
        let bursts = self.seeds().1 as usize;
        let megapixels = bursts as f64 * self.burst_megapixels();
        let count = |level: NoiseLevel, found: &[Vec<(usize, f64)>], (i, search): (usize, &NoiseSearch)| {
            let of_bursts: Vec<usize> = found.iter().map(|burst| burst[i].0).collect();
            let false_features = of_bursts.iter().sum::<usize>();
            let noise = found.iter().map(|burst| burst[i].1).sum::<f64>() / bursts as f64;
            let refused = found.iter().filter(|burst| burst[i].1.is_nan()).count();
            let megapixels = (bursts - refused) as f64 * self.burst_megapixels();
            NoiseCount {
                label: search.label.clone(),
                slopes: search.detector.used_slopes().len(),
                noise_gate_factor: gate_factor(&search.detector),
                false_features,
                refused,
                of_bursts,
                per_megapixel: false_features as f64 / megapixels,
                standard_error: (false_features as f64).sqrt() / megapixels,
                noise_estimate_ratio: (level.case == NoiseCase::White.into()).then(|| noise / level.total_sigma()),
            }
        };
        let row = |(level, found): &(NoiseLevel, Vec<Vec<(usize, f64)>>)| NoiseRow {
            level: *level,
            searches: self.searches.iter().enumerate().map(|search| count(*level, found, search)).collect(),
        };
        let Self { width, height, frames, first_seed, .. } = *self;
        let rows = rows.iter().map(row).collect();
        NoiseReport { width, height, frames, first_seed, bursts, megapixels, rows }
    }
}

impl NoiseLevel {
    /// White noise around the default grey level, rounded to `bits` if given.
    pub fn white(sigma: f64, bits: Option<u32>) -> Self {
        Self { sigma, bits, case: NoiseCase::White.into(), mean: NoiseCase::LEVEL }
    }

    /// The standard deviation including rounding, whose variance is a twelfth of a step².
    fn total_sigma(self) -> f64 {
        self.sigma.hypot(self.bits.map_or(0.0, quantisation_step) / 12f64.sqrt())
    }
}

/// Makes frames of noise around half of full scale, modified by the case.
fn noise_burst(level: NoiseLevel, size: (usize, usize), frames: usize, seed: u64, monitor: &Monitor) -> Result<Burst> {
    if level.case != NoiseCase::White.into() {
        return Ok(level.case.burst_at(level.mean, size, frames, level.sigma, seed, monitor)?);
    }
    let frame = |t: usize| {
        monitor.check()?;
        let mut stream = Stream::new(seed, t as u64);
        let value = |_, _| {
            let value = level.mean + level.sigma * stream.normal();
            level.bits.map_or(value as f32, |bits| f32::from(quantised_word(value, bits)) / 65535.0)
        };
        Ok(Plane::from_fn(size.0, size.1, value))
    };
    let mut burst = Burst::from_planes("noise", (0..frames).map(frame).collect::<Result<_>>()?);
    // No file's header gives the step of frames made in memory.
    burst.quantisation_step = level.bits.map_or(0.0, quantisation_step) as f32;
    Ok(burst)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bursts_have_the_noise_asked_for() {
        for (sigma, bits) in [(0.02, None), (0.002, Some(8)), (0.02, Some(6))] {
            let level = NoiseLevel::white(sigma, bits);
            let burst = noise_burst(level, (200, 150), 2, 3, &Monitor::default()).expect("not cancelled");
            let values: Vec<f64> = burst.frames.iter().flat_map(|f| f.data()).map(|&x| f64::from(x)).collect();
            let mean = values.iter().sum::<f64>() / values.len() as f64;
            let measured = (values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / values.len() as f64).sqrt();
            assert!((measured / level.total_sigma() - 1.0).abs() < 0.03, "{level:?}: {measured}");
            assert_ne!(burst.frames[0], burst.frames[1]);
        }
    }
}
