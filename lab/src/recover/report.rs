//! The report of planted things: shares found, the SNR of which half are, the tests failed, and faintness by place.

use super::fit::{FittedCurve, Outcome, Prior, fitted, share_interval};
use super::{Contrast, Levels, Planted, RecoverStudy, RecoverTimes, Shape, Varied, ground::Ground};
use burstscope_core::detector::{DetectorParams, Slope, SlopeGrid, Test};
use burstscope_core::export::{Cell, PLANTED_COLUMNS, Table};
use burstscope_core::inspect::words::{counted, number};
use burstscope_core::{burst::Burst, plane::Plane};
use serde::Serialize;
use std::{f64::consts::SQRT_2, sync::Arc};

/// Report of a study, complete or partial.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[allow(missing_docs)] // where a name says it
pub struct RecoverReport {
    pub burst: String,
    /// Columns and rows of the frames.
    pub size: [usize; 2],
    pub frames: usize,
    /// Parameters of the search, with the slopes that were searched.
    pub detector: DetectorParams,
    pub grid: SlopeGrid,
    pub noise_gate_factor: f32,
    /// σ of one frame's noise, fraction of full scale.
    pub frame_noise: f32,
    /// Features of the burst itself.
    pub features: usize,
    pub shape: Shape,
    pub contrast: Contrast,
    /// SNRs, slopes and radii at which things are planted.
    pub levels: Levels,
    /// Number of copies of the whole study.
    pub copies: u64,
    /// Number of copies that were searched.
    pub copies_done: u64,
    /// Shares found over SNR, of things in the range of the slopes.
    pub over_snr: Vec<LevelShare>,
    /// Shares found over slope.
    pub over_slope: Vec<LevelShare>,
    /// Shares found over radius, of things in the range of the slopes.
    pub over_size: Vec<LevelShare>,
    /// Curve of the share found over SNR.
    pub curve: FittedCurve,
    /// SNR at which half are found; `None` beyond the planted range.
    pub half: Option<HalfFound>,
    /// Tests that things failed, most frequent first.
    pub fates: Vec<FateCount>,
    /// Amplitude of which half are found, by place.
    pub map: FaintnessMap,
    /// Seconds spent on planting, searching and explaining misses.
    pub times: RecoverTimes,
    /// Things of all copies searched so far, with their fates.
    pub planted: Vec<Planted>,
}

/// Share found at one level.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LevelShare {
    /// SNR, slope (px/frame) or radius (px).
    pub level: f64,
    /// Number of things planted.
    pub planted: usize,
    /// Number of planted things found.
    pub found: usize,
    /// Ends of the 68 % interval of the share, 0 … 1.
    pub interval: [f64; 2],
    /// Mean of the shares that noise and gate let expect, 0 … 1.
    pub expected: f64,
}

impl LevelShare {
    /// Share found, 0 … 1.
    pub fn share(&self) -> f64 {
        self.found as f64 / self.planted.max(1) as f64
    }
}

/// SNR of which half are found.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct HalfFound {
    /// SNR of one pixel in one frame.
    pub snr: f64,
    /// Standard error.
    pub error: f64,
}

/// Number of things that failed a test.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FateCount {
    /// The test; `None` for things without a candidate.
    pub test: Option<Test>,
    /// Reason in words.
    pub reason: &'static str,
    /// Number of things.
    pub count: usize,
}

/// Amplitude of a thing of the study's radius of which half are found, by place.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FaintnessMap {
    /// Side of a cell, pixels.
    pub cell_px: f64,
    /// Amplitudes by row and column, fraction of full scale; `None` where too little was planted.
    pub rows: Vec<Vec<Option<f64>>>,
    /// The amplitudes as a picture: one pixel for each cell, NaN where too little was planted.
    #[serde(skip)]
    pub plane: Arc<Plane>,
}

/// Ratio of the SNR of which half are found to the expected one, above which more than the noise decides.
const HIDDEN: f64 = 1.5;
/// Number of cells along the longer side of the map, about.
const CELLS: f64 = 16.0;
/// Standard deviation, in cells, within which things count for a cell.
const CELL_SIGMA: f64 = 1.0;
/// Sum of weights below which a cell stays empty.
const MIN_WEIGHT: f64 = 2.5;
/// Prior standard deviation of the logarithm of a cell's amplitude around that of the whole picture.
const CELL_DEVIATION: f64 = 0.5;

impl RecoverReport {
    pub(super) fn begun(study: &RecoverStudy, burst: &Burst, ground: &Ground, levels: Levels) -> Self {
        let (width, height) = burst.size();
        let detection = ground.cache.detection();
        let prior = prior(detection.noise_gate_factor, &levels);
        Self {
            burst: burst.name.clone(),
            size: [width, height],
            frames: ground.used.len(),
            detector: ground.cache.made_with(),
            grid: ground.cache.params().used_slopes(),
            noise_gate_factor: detection.noise_gate_factor,
            frame_noise: detection.frame_noise,
            features: detection.features.len(),
            shape: study.shape,
            contrast: study.contrast,
            levels,
            copies: study.copies,
            copies_done: 0,
            over_snr: Vec::new(),
            over_slope: Vec::new(),
            over_size: Vec::new(),
            curve: fitted(&[], &prior),
            half: None,
            fates: Vec::new(),
            map: FaintnessMap {
                cell_px: (width.max(height) as f64 / CELLS).max(8.0),
                rows: Vec::new(),
                plane: Arc::new(Plane::zeros(1, 1)),
            },
            times: RecoverTimes::default(),
            planted: Vec::new(),
        }
    }

    pub(super) fn add(&mut self, ground: &Ground, planted: Vec<Planted>, times: RecoverTimes) {
        self.planted.extend(planted);
        self.copies_done += 1;
        self.times.plant_secs += times.plant_secs;
        self.times.search_secs += times.search_secs;
        self.times.fate_secs += times.fate_secs;
        self.over_snr = self.shares(Varied::Snr);
        self.over_slope = self.shares(Varied::Slope);
        self.over_size = self.shares(Varied::Size);
        self.fit();
        self.fates = self.fate_counts();
        self.map.rows = self.map_rows(ground);
        let rows = &self.map.rows;
        let value = |x: usize, y: usize| rows[y][x].map_or(f32::NAN, |value| value as f32);
        self.map.plane = Arc::new(Plane::from_fn(rows.first().map_or(1, Vec::len), rows.len(), value));
    }

    /// Shares found of the things that vary a quantity.
    pub fn shares_over(&self, varied: Varied) -> &[LevelShare] {
        match varied {
            Varied::Snr => &self.over_snr,
            Varied::Slope => &self.over_slope,
            Varied::Size => &self.over_size,
        }
    }

    /// Value of a thing on the axis of its group.
    pub fn level_of(&self, one: &Planted) -> f64 {
        match one.varied {
            Varied::Snr => one.snr,
            Varied::Size => one.truth.radius,
            Varied::Slope => self.levels.slope_level(Slope::new(one.truth.slope_u as f32, one.truth.slope_v as f32)),
        }
    }

    fn shares(&self, varied: Varied) -> Vec<LevelShare> {
        let things: Vec<(f64, &Planted)> =
            self.planted.iter().filter(|one| one.varied == varied).map(|one| (self.level_of(one), one)).collect();
        // The probability that a response with its noise passes the gate.
        let passes = |snr: f64| 0.5 * libm::erfc(-(snr - f64::from(self.noise_gate_factor)) / SQRT_2);
        let share = |&level: &f64| {
            // Slopes are f32 and turned by the grid's direction, so that a level comes back with a rounding error.
            let at: Vec<&Planted> = things
                .iter()
                .filter(|(value, _)| (value - level).abs() <= 1e-3 * level.abs().max(1e-2))
                .map(|(_, one)| *one)
                .collect();
            let found = at.iter().filter(|one| one.found.is_some()).count();
            let expected = at.iter().map(|one| one.expected_snr_d.map_or(0.0, passes)).sum::<f64>() / at.len() as f64;
            let interval = share_interval(found, at.len());
            // An early report has levels without things, and these have no share.
            (!at.is_empty()).then_some(LevelShare { level, planted: at.len(), found, interval, expected })
        };
        self.levels.values(varied).iter().filter_map(share).collect()
    }

    fn fit(&mut self) {
        let of = |one: &Planted| Outcome { ln_strength: one.snr.ln(), is_found: one.found.is_some(), weight: 1.0 };
        // Things beyond the searched slopes are missed at any strength, and would flatten the curve.
        let outcomes: Vec<Outcome> =
            self.planted.iter().filter(|one| one.varied == Varied::Snr && one.is_in_range).map(of).collect();
        self.curve = fitted(&outcomes, &prior(self.noise_gate_factor, &self.levels));
        let (snr, error) = (self.curve.strength_at(0.5), self.curve.middle.exp() * self.curve.middle_error);
        let planted = self.levels.snrs.first().zip(self.levels.snrs.last());
        let is_measured = planted.is_some_and(|(first, last)| (*first..=*last).contains(&snr));
        // With nothing but hits, or nothing but misses, the prior alone fixes the middle.
        let both = [true, false].iter().all(|is| outcomes.iter().any(|one| one.is_found == *is));
        self.half = (is_measured && both).then_some(HalfFound { snr, error });
    }

    fn fate_counts(&self) -> Vec<FateCount> {
        let missed: Vec<&Planted> = self.planted.iter().filter(|one| one.found.is_none()).collect();
        let mut counts: Vec<FateCount> = Test::ALL
            .into_iter()
            .map(Some)
            .chain([None])
            .map(|test| {
                let reason = test.map_or("no candidate of its size", Test::reason);
                FateCount { test, reason, count: missed.iter().filter(|one| one.failed == test).count() }
            })
            .filter(|one| one.count > 0)
            .collect();
        counts.sort_by_key(|one| std::cmp::Reverse(one.count));
        counts
    }

    fn map_rows(&self, ground: &Ground) -> Vec<Vec<Option<f64>>> {
        let cell = self.map.cell_px;
        let trail = &ground.cache.trail;
        let centre = (0.5 * self.size[0] as f64, 0.5 * self.size[1] as f64);
        let still = self.grid.slopes().min_by(|a, b| a.magnitude().total_cmp(&b.magnitude())).unwrap_or_default();
        let factor = f64::from(self.noise_gate_factor);
        let amplitude_of =
            |radius: f64| super::expected(trail, self.shape, radius, centre, still).map(|one| one.amplitude_at(factor));
        let of_radius: Vec<(f64, f64)> = (self.levels.radii.iter().chain([&self.levels.at_radius]))
            .filter_map(|&radius| Some((radius, amplitude_of(radius)?)))
            .collect();
        // Amplitudes relative to what is expected of the size, at the noise of the whole picture.
        let things: Vec<([f64; 2], f64, bool)> = (self.planted.iter().filter(|one| one.is_in_range))
            .filter_map(|one| {
                let (_, amplitude) = of_radius.iter().find(|(radius, _)| *radius == one.truth.radius)?;
                let ln = (one.amplitude.abs() / amplitude).ln();
                Some(([one.truth.u, one.truth.v], ln, one.found.is_some()))
            })
            .collect();
        let outcome =
            |&(_, ln_strength, is_found): &([f64; 2], f64, bool), weight| Outcome { ln_strength, is_found, weight };
        // A cell has too few things for a curve of its own: its steepness is that of the SNR curve, and its middle is
        // drawn towards that of the whole picture.
        let whole = Prior { steepness: self.curve.steepness, steepness_deviation: 0.0, ..Prior::of_gate(factor, 0.0) };
        let all: Vec<Outcome> = things.iter().map(|thing| outcome(thing, 1.0)).collect();
        let middle = fitted(&all, &whole).middle;
        let prior = Prior { middle, middle_deviation: CELL_DEVIATION, ..whole };
        let cells = |n: usize| (n as f64 / cell).ceil() as usize;
        let at = |x: usize, y: usize| {
            let place = [(x as f64 + 0.5) * cell, (y as f64 + 0.5) * cell];
            let weighted: Vec<Outcome> = things
                .iter()
                .filter_map(|thing| {
                    // Weights beyond 3 σ are below 0.012 and would only cost time.
                    let away = (thing.0[0] - place[0]).hypot(thing.0[1] - place[1]) / (CELL_SIGMA * cell);
                    (away < 3.0).then(|| outcome(thing, (-0.5 * away * away).exp()))
                })
                .collect();
            let weight: f64 = weighted.iter().map(|one| one.weight).sum();
            let amplitude = fitted(&weighted, &prior).middle.exp() * self.levels.expected_amplitude;
            (weight >= MIN_WEIGHT).then_some(amplitude)
        };
        (0..cells(self.size[1])).map(|y| (0..cells(self.size[0])).map(|x| at(x, y)).collect()).collect()
    }

    /// Frames from which `share` of the things of `snr` are found, at the motions of the search; `None` without a half.
    pub fn frames_needed(&self, snr: f64, share: f64) -> Option<usize> {
        self.half?;
        // The noise of the mean falls with the root of the number of frames.
        let ratio = self.curve.strength_at(share) / snr;
        // A burst has at least two frames.
        Some(((self.frames as f64 * ratio * ratio).ceil() as usize).max(2))
    }

    /// Changes in the world that it takes for nine of ten things of half of [`HalfFound::snr`] to be found, a
    /// sentence. Where the scene hides more than the noise does, the sentence reports this instead.
    pub fn outlook(&self) -> Option<String> {
        let half = self.half?;
        // Two standard errors keep a chance result of few things from blaming the scene.
        if half.snr - 2.0 * half.error > HIDDEN * self.levels.expected_half {
            return Some(format!(
                "9 of 10 are found at SNR {}; the scene hides more than the noise, so that more frames or light help little",
                number(self.curve.strength_at(0.9) as f32, 2)
            ));
        }
        let [same, faint] = [half.snr, 0.5 * half.snr];
        let needed = |snr: f64| self.frames_needed(snr, 0.9);
        Some(format!(
            "9 of 10 are found at SNR {}; at {} it takes {} at the same motions, at {} it takes {} (now {})",
            number(self.curve.strength_at(0.9) as f32, 2),
            number(same as f32, 2),
            counted(needed(same)?, "frame"),
            number(faint as f32, 2),
            needed(faint)?,
            self.frames
        ))
    }

    /// Smallest and largest amplitude of the map, fraction of full scale.
    pub fn map_range(&self) -> Option<[f64; 2]> {
        let values = || self.map.rows.iter().flatten().flatten().copied();
        let first = values().next()?;
        Some([values().fold(first, f64::min), values().fold(first, f64::max)])
    }

    /// The answer in one line.
    pub fn summary(&self) -> String {
        let half = match self.half {
            Some(half) => {
                format!("half found at SNR {} ± {}", number(half.snr as f32, 3), number(half.error as f32, 3))
            }
            None => format!("half expected at SNR {}", number(self.levels.expected_half as f32, 3)),
        };
        format!(
            "{}: {half}, radius {} px; {} things in {} of {} copies",
            self.burst,
            number(self.levels.at_radius as f32, 1),
            self.planted.len(),
            self.copies_done,
            self.copies
        )
    }

    /// The report as text.
    pub fn text(&self) -> String {
        let found = self.planted.iter().filter(|one| one.found.is_some()).count();
        let expected = number(self.levels.expected_half as f32, 3);
        let mut text = format!(
            "{}: {found} of {} {}s found in {}; {} at {}, gate {} σ\n",
            self.burst,
            self.planted.len(),
            self.shape.name(),
            counted(self.copies_done as usize, "copy").replace("copys", "copies"),
            counted(self.frames, "frame"),
            counted(self.grid.len(), "slope"),
            number(self.noise_gate_factor, 2),
        );
        text += &match self.half {
            Some(half) => format!(
                "  half are found at SNR {} ± {} of one pixel in one frame (radius {} px); noise and gate let expect {expected}\n",
                number(half.snr as f32, 3),
                number(half.error as f32, 3),
                number(self.levels.at_radius as f32, 1),
            ),
            None => format!(
                "  the SNR of which half are found is not among those planted; noise and gate let expect {expected}\n"
            ),
        };
        text.extend(self.outlook().map(|outlook| format!("  {outlook}\n")));
        for (varied, name) in [(Varied::Snr, "SNR"), (Varied::Slope, "slope"), (Varied::Size, "radius")] {
            text += &format!("  {name:>8}  planted  found     share  expected\n");
            for share in self.shares_over(varied) {
                let percent = |x: f64| format!("{:.0} %", 100.0 * x);
                text += &format!(
                    "  {:>8}  {:>7} {:>6}  {:>8} {:>9}  {}\n",
                    number(share.level as f32, 3),
                    share.planted,
                    share.found,
                    percent(share.share()),
                    percent(share.expected),
                    "#".repeat((20.0 * share.share()).round() as usize)
                );
            }
        }
        if let Some([min, max]) = self.map_range().map(|ends| ends.map(|x| number((100.0 * x) as f32, 3))) {
            text += &format!("  over the picture half are found from {min} % to {max} % of full scale, by place\n");
        }
        if !self.fates.is_empty() {
            let told: Vec<String> = self.fates.iter().map(|fate| format!("{} {}", fate.count, fate.reason)).collect();
            text += &format!("  missed: {}\n", told.join(", "));
        }
        text
    }
}

fn prior(noise_gate_factor: f32, levels: &Levels) -> Prior {
    Prior::of_gate(f64::from(noise_gate_factor), levels.expected_half.max(1e-9).ln())
}

/// The things as a table, one row each.
pub fn planted_table(planted: &[Planted]) -> Table {
    let row = |one: &Planted| {
        let varied = match one.varied {
            Varied::Snr => "snr",
            Varied::Slope => "slope",
            Varied::Size => "size",
        };
        let t = &one.truth;
        let found = one.found.map_or([const { Cell::Missing }; 3], |found| {
            [found.slope.u, found.slope.v, found.snr].map(|x| Cell::single(x, 3))
        });
        let place = [(t.u, 3), (t.v, 3), (t.radius, 3), (t.slope_u, 3), (t.slope_v, 3)];
        let strength = [(f64::from(t.contrast_sign), 0), (one.snr, 3), (one.amplitude, 6), (one.frames as f64, 0)];
        let number = |(x, decimals): (f64, usize)| Cell::Number(x, decimals);
        let mut cells = vec![Cell::Text(one.seed.to_string()), Cell::Number(t.id as f64, 0), varied.into()];
        cells.extend(place.into_iter().chain(strength).map(number));
        cells.extend([Cell::of(one.expected_snr_d, 3), Cell::count(one.found.is_some().into())]);
        cells.extend(found);
        cells.extend([one.failed.map_or("", Test::reason), &one.why].map(Cell::from));
        cells
    };
    Table::new("Things planted", PLANTED_COLUMNS, planted.iter().map(row).collect())
}
