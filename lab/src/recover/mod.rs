//! Things planted in a burst and searched for, to measure what the search as it is set would find.
//!
//! Discs or blobs of known SNR, size and slope are added to copies of the burst's own frames, with the noise of their
//! light. The search runs on every copy, and each thing is found, by the rule of [`burstscope_core::inspect::result`],
//! or has a fate in the words of the [probe](burstscope_core::inspect::place::probe()). The [`report`] has the shares
//! found over SNR, slope and size beside those expected, the SNR at which half are found, and a map of faintness.
//!
//! Unknown slopes are found once, in the burst itself. Reports are the same for any number of threads, but for times.

mod expected;
mod fit;
mod ground;
mod levels;
pub mod plots;
pub mod report;
mod thing;

pub use levels::Levels;
pub use report::RecoverReport;
pub use thing::Shape;

use crate::synth::random::Stream;
use crate::synth::truth::{FeatureTruth, Truth, TruthKind, disc_sigma};
use burstscope_core::detector::{SearchParams, Slope, SlopeAxis, Test};
use burstscope_core::error::{Error, Result};
use burstscope_core::inspect::result::{Ranking, judge_by_discs, miss};
use burstscope_core::monitor::{Cancelled, Monitor, Stage};
#[cfg(feature = "cli")]
use burstscope_core::synth::options::words;
use burstscope_core::{burst::Burst, inspect::ProbeCache, plane::Plane, plane::sample::bilinear};
use expected::expected;
use ground::Ground;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::{sync::Arc, time::Instant};
use thing::Painting;

/// Brightness of the planted things relative to what is around them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Contrast {
    /// Brighter than their surroundings.
    #[default]
    Bright,
    /// Darker than their surroundings.
    Dark,
    /// Half brighter, half darker than the ground.
    Both,
}

/// Quantity that a group of things varies, while the others stay in the middle of the search.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Varied {
    /// SNR of one pixel in one frame; slopes anywhere in the grid.
    Snr,
    /// Slope along the grid's first axis of several slopes.
    Slope,
    /// Radius; slopes anywhere in the grid.
    Size,
}

impl Varied {
    /// All quantities, in the order in which the things of a copy take turns.
    pub const ALL: [Self; 3] = [Self::Snr, Self::Slope, Self::Size];
}

/// A study: the things that are planted, and the search for them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(clap::Args))]
#[serde(deny_unknown_fields)]
pub struct RecoverStudy {
    /// Shape of the things: disc, or blob, a Gaussian of σ = radius/√2.
    #[cfg_attr(
        feature = "cli",
        arg(long, value_name = "SHAPE", value_parser = words::<Shape>(&["disc", "blob"]), default_value = "disc")
    )]
    pub shape: Shape,
    /// Brightness of the things relative to what is around them: bright, dark or both.
    #[cfg_attr(
        feature = "cli",
        arg(long, value_name = "CONTRAST", value_parser = words::<Contrast>(&["bright", "dark", "both"])),
        arg(default_value = "bright")
    )]
    pub contrast: Contrast,
    /// SNRs of one pixel in one frame, separated by commas [default: around the one that the noise gate lets expect].
    #[cfg_attr(feature = "cli", arg(long = "snr", value_name = "RATIO,…", value_delimiter = ','))]
    pub snrs: Vec<f64>,
    /// Radii, pixels, separated by commas [default: 2 to 16].
    #[cfg_attr(feature = "cli", arg(long = "radius", value_name = "PX,…", value_delimiter = ','))]
    pub radii: Vec<f64>,
    /// Slopes of the things along the grid's first axis, pixels per frame [default: those of the grid, half-way
    /// between, and a step beyond].
    #[cfg_attr(
        feature = "cli",
        arg(id = "planted-slopes", long = "planted-slopes", value_name = "MIN:MAX:COUNT", allow_hyphen_values = true)
    )]
    pub slopes: Option<SlopeAxis>,
    /// SNR of things of several slopes or radii [default: 1.7 times the one of which half are expected to be found].
    #[cfg_attr(feature = "cli", arg(long, value_name = "RATIO"))]
    pub at_snr: Option<f64>,
    /// Radius of things of several SNRs or slopes, pixels.
    #[cfg_attr(feature = "cli", arg(long, value_name = "PX", default_value_t = Self::default().at_radius))]
    pub at_radius: f64,
    /// Number of copies of the burst.
    #[cfg_attr(feature = "cli", arg(long, value_name = "N", default_value_t = Self::default().copies))]
    pub copies: u64,
    /// Seed of the first copy; the next ones count up.
    #[cfg_attr(feature = "cli", arg(long = "seed", value_name = "SEED", default_value_t = 1))]
    pub first_seed: u64,
    /// Number of things in a copy [default: as many as leave each other room].
    #[cfg_attr(feature = "cli", arg(long, value_name = "N"))]
    pub per_copy: Option<usize>,
    /// Plant only where a thing is inside the image in all frames.
    #[cfg_attr(feature = "cli", arg(long))]
    pub inside: bool,
    /// Plant on strong features of the burst too.
    #[cfg_attr(feature = "cli", arg(long))]
    pub on_features: bool,
    /// The search.
    #[cfg_attr(feature = "cli", arg(skip))]
    pub search: SearchParams,
}

impl Default for RecoverStudy {
    fn default() -> Self {
        Self {
            shape: Shape::Disc,
            contrast: Contrast::Bright,
            snrs: Vec::new(),
            slopes: None,
            radii: Vec::new(),
            at_snr: None,
            at_radius: 5.0,
            copies: 16,
            first_seed: 1,
            per_copy: None,
            inside: false,
            on_features: false,
            search: SearchParams::default(),
        }
    }
}

/// The feature that found a thing.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct FoundThing {
    /// Index of the feature in the copy's detection.
    pub feature: usize,
    /// Slope of the feature, px/frame.
    pub slope: Slope,
    /// SNR of the feature in D.
    pub snr: f32,
}

/// One planted thing with its fate.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Planted {
    /// Seed of its copy.
    pub seed: u64,
    /// Quantity that its group varies.
    pub varied: Varied,
    /// Place at mid-burst, size and motion; its number within the copy.
    pub truth: FeatureTruth,
    /// SNR of one pixel in one frame.
    pub snr: f64,
    /// Light of the thing, fraction of full scale; negative for a dark one.
    pub amplitude: f64,
    /// Whether its slope lies in the range of the search.
    pub is_in_range: bool,
    /// Number of frames that show its centre.
    pub frames: usize,
    /// Expected SNR in D; `None` where no scale of the search suits the thing.
    pub expected_snr_d: Option<f64>,
    /// The feature that found it.
    pub found: Option<FoundThing>,
    /// First test failed by the best candidate; `None` for a thing found or without candidate.
    pub failed: Option<Test>,
    /// Reason why it was not found, in the probe's words; empty if it was.
    pub why: String,
}

/// Times of a study, seconds.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct RecoverTimes {
    /// Planting.
    pub plant_secs: f64,
    /// Searching the burst and its copies.
    pub search_secs: f64,
    /// Finding the fates of what was missed.
    pub fate_secs: f64,
}

fn truth_of_thing(id: usize, (u, v): (f64, f64), radius: f64, slope: Slope, contrast_sign: i8) -> FeatureTruth {
    let (slope_u, slope_v) = (f64::from(slope.u), f64::from(slope.v));
    FeatureTruth { id, layer: None, u, v, radius, sigma: disc_sigma(radius), slope_u, slope_v, contrast_sign }
}

/// Ranges of a study's numbers, for options, files and fields of the window.
pub mod bounds {
    use burstscope_core::detector::params::Bounds;
    use std::ops::Bound::{Excluded, Included};

    /// SNR of one pixel in one frame.
    pub const SNR: Bounds =
        Bounds::new((Excluded(0.0), Included(1e6)), "give ratios above 0 and up to 1000000, such as 0.2,0.6,1.2");
    /// Radius, pixels.
    pub const RADIUS: Bounds = Bounds::new((Included(0.5), Included(500.0)), "give 0.5 to 500 pixels, such as 2,8,16");
    /// Number of copies.
    pub const COPIES: Bounds = Bounds::new((Included(1.0), Included(100_000.0)), "give 1 to 100000");
    /// Number of things in a copy.
    pub const PER_COPY: Bounds = Bounds::new((Included(1.0), Included(10_000.0)), "give 1 to 10000, or leave it out");
}

impl RecoverStudy {
    /// Checks the numbers of the study without a burst; the first one that makes no sense is the error.
    pub fn check(&self) -> Result<()> {
        self.snrs.iter().try_for_each(|&snr| bounds::SNR.check("snr", snr))?;
        self.at_snr.iter().try_for_each(|&snr| bounds::SNR.check("at-snr", snr))?;
        self.radii.iter().try_for_each(|&radius| bounds::RADIUS.check("radius", radius))?;
        bounds::RADIUS.check("at-radius", self.at_radius)?;
        bounds::COPIES.check("copies", self.copies as f64)?;
        self.per_copy.iter().try_for_each(|&count| bounds::PER_COPY.check("per-copy", count as f64))?;
        let wrong = |(problem, remedy)| Error::param("planted-slopes", problem, remedy);
        self.slopes.iter().try_for_each(|axis| axis.check().map_err(wrong))?;
        self.search.validate()
    }

    /// Runs the study on `burst`; calls `tell` with the report so far after every copy.
    ///
    /// # Errors
    /// Parameters that make no sense, a burst without noise, or cancellation.
    pub fn run_telling(
        &self,
        burst: &Burst,
        monitor: &Monitor,
        tell: &(dyn Fn(RecoverReport) + Sync),
    ) -> Result<RecoverReport> {
        self.check()?;
        // The search of the burst itself is one step beside those of its copies.
        let share = 1.0 / (self.copies as f32 + 1.0);
        let silent = monitor.silent();
        let started = Instant::now();
        monitor.report(Stage::Evaluate, 0.0);
        let ground = Ground::new(self, burst, &silent)?;
        let levels = Levels::of(self, &ground)?;
        let mut report = RecoverReport::begun(self, burst, &ground, levels);
        report.times.search_secs = started.elapsed().as_secs_f64();
        for copy in 0..self.copies {
            monitor.check()?;
            monitor.report(Stage::Evaluate, share * (copy + 1) as f32);
            // Only the things outlive a copy, so that memory holds one searched copy at a time.
            let (planted, times) = self.copy(burst, &ground, &report.levels, copy, &silent)?;
            report.add(&ground, planted, times);
            tell(report.clone());
        }
        monitor.report(Stage::Evaluate, 1.0);
        Ok(report)
    }

    /// Runs the study as [`Self::run_telling`] does, without partial reports.
    pub fn run(&self, burst: &Burst, monitor: &Monitor) -> Result<RecoverReport> {
        self.run_telling(burst, monitor, &|_| {})
    }

    /// Makes the copy of a seed again, with its truth, without a search; errors as of [`Self::run_telling`].
    pub fn planted_copy(&self, burst: &Burst, seed: u64, monitor: &Monitor) -> Result<(Burst, Truth)> {
        self.check()?;
        let ground = Ground::new(self, burst, &monitor.part(0.0, 0.9))?;
        let levels = Levels::of(self, &ground)?;
        // The levels of the things follow from the number of the copy, which its seed gives.
        let planted = self.things(&ground, &levels, seed.wrapping_sub(self.first_seed), monitor)?;
        let copy = self.plant(burst, &ground, &planted, seed, monitor)?;
        let (width, height) = burst.size();
        let truth = Truth {
            kind: TruthKind::Planted,
            width,
            height,
            frames: ground.used.len(),
            t0: -ground.offset(0).u,
            times: ground.cache.trail.frames().2.list(),
            views: ground.cache.trail.frames().2.views(),
            seed,
            features: planted.iter().map(|one| one.truth).collect(),
            ..Truth::default()
        };
        Ok((copy, truth))
    }

    /// The things of a copy, planted and searched, with their fates.
    fn copy(
        &self,
        burst: &Burst,
        ground: &Ground,
        levels: &Levels,
        copy: u64,
        monitor: &Monitor,
    ) -> Result<(Vec<Planted>, RecoverTimes)> {
        let seed = self.first_seed.wrapping_add(copy);
        let started = Instant::now();
        let mut planted = self.things(ground, levels, copy, monitor)?;
        let with_things = self.plant(burst, ground, &planted, seed, monitor)?;
        let plant_secs = started.elapsed().as_secs_f64();
        let cache = ProbeCache::new(&with_things, &ground.params, monitor)?;
        let search_secs = started.elapsed().as_secs_f64() - plant_secs;
        let truths: Vec<FeatureTruth> = planted.iter().map(|one| one.truth).collect();
        let features = &cache.detection().features;
        // The strongest feature that finds a thing stands for it.
        for judged in judge_by_discs(features, &truths, Ranking::Strength) {
            if let Some(thing) = judged.disc {
                let feature = &features[judged.feature];
                planted[thing].found =
                    Some(FoundThing { feature: judged.feature, slope: feature.slope, snr: feature.snr });
            }
        }
        let fate = |one: &mut Planted| -> Result<(), Cancelled> {
            if one.found.is_none() {
                let miss = miss(&cache, one.truth.id, &one.truth, monitor)?;
                // A candidate that was kept all the same was counted for another thing.
                one.failed = miss.fate.and_then(|fate| fate.first_failed);
                one.why = miss.why;
            }
            Ok(())
        };
        planted.par_iter_mut().try_for_each(fate)?;
        let fate_secs = started.elapsed().as_secs_f64() - plant_secs - search_secs;
        Ok((planted, RecoverTimes { plant_secs, search_secs, fate_secs }))
    }

    fn things(&self, ground: &Ground, levels: &Levels, copy: u64, monitor: &Monitor) -> Result<Vec<Planted>> {
        let seed = self.first_seed.wrapping_add(copy);
        let mut stream = Stream::new(seed, 0);
        let mut planted: Vec<Planted> = Vec::with_capacity(levels.per_copy);
        for number in 0..levels.per_copy {
            let varied = Varied::ALL[number % Varied::ALL.len()];
            // Levels go on where the copy before stopped; a file may ask for any seed, so the product wraps.
            let before = (copy as usize).wrapping_mul(levels.per_copy.div_ceil(Varied::ALL.len()));
            let turn = before.wrapping_add(number / Varied::ALL.len());
            let (snr, radius, slope) = levels.drawn(varied, turn, &mut stream);
            let sign = match self.contrast {
                Contrast::Bright => 1,
                Contrast::Dark => -1,
                // Signs alternate with each round over the levels, so that every level has bright and dark things.
                Contrast::Both => 1 - 2 * ((turn / levels.count(varied)) as i8 & 1),
            };
            // A crowded picture takes fewer things.
            let Some((u, v)) = ground.place(self, (radius, slope), &planted, &mut stream, monitor)? else { continue };
            let truth = truth_of_thing(planted.len(), (u, v), radius, slope, sign);
            let amplitude = ground.light.amplitude(snr, ground.sigma_at(u, v).powi(2), f64::from(sign));
            let expected = expected(&ground.cache.trail, self.shape, radius, (u, v), slope);
            planted.push(Planted {
                seed,
                varied,
                truth,
                snr,
                amplitude,
                is_in_range: levels.is_in_range(slope),
                frames: ground.frames_inside((u, v), slope),
                expected_snr_d: expected.map(|expected| expected.snr_d(amplitude)),
                found: None,
                failed: None,
                why: String::new(),
            });
        }
        Ok(planted)
    }

    fn plant(&self, burst: &Burst, ground: &Ground, things: &[Planted], seed: u64, monitor: &Monitor) -> Result<Burst> {
        let paint = |t: usize| -> Result<Arc<Plane>, Cancelled> {
            monitor.check()?;
            let mut frame = (*burst.frames[ground.used.start + t]).clone();
            // Every frame has its own stream; stream 0 drew the places.
            let mut stream = Stream::new(seed, 1 + t as u64);
            for one in things {
                let (u, v) = one.truth.position(ground.offset(t));
                let (shape, radius, amplitude) = (self.shape, one.truth.radius, one.amplitude * ground.gains[t]);
                let background = bilinear(&ground.brightness, u as f32, v as f32).map_or(0.0, f64::from);
                let painting = Painting { shape, radius, centre: (u, v), amplitude, background };
                painting.paint(&mut frame, &ground.light, &mut stream, monitor)?;
            }
            Ok(Arc::new(frame))
        };
        let painted: Vec<Arc<Plane>> =
            (0..ground.used.len()).into_par_iter().map(paint).collect::<Result<_, Cancelled>>()?;
        let mut copy = burst.clone();
        copy.frames.splice(ground.used.clone(), painted);
        copy.name = format!("{} with things planted, {seed}", burst.name);
        // A copy is none of the files that the burst was opened from.
        copy.sources = Vec::new();
        Ok(copy)
    }
}
