//! Arguments of the studies on charts: the charts, and the methods compared on them.

use crate::evaluate::{BurstMethod, Ranking};
use crate::synth::options::{motions, parse_range, words};
use crate::synth::{ChartParams, Motion, RadiusLaw};
use clap::Args;
use std::ops::RangeInclusive;
use std::str::FromStr;

fn chart() -> ChartParams {
    ChartParams::default()
}

/// The picture of a chart: its size and its discs.
#[derive(Debug, Clone, Args)]
pub struct DiscsArgs {
    /// Columns.
    #[arg(long, value_name = "PIXELS", default_value_t = chart().width)]
    pub width: usize,
    /// Rows.
    #[arg(long, value_name = "PIXELS", default_value_t = chart().height)]
    pub height: usize,
    /// Number of discs.
    #[arg(long, value_name = "N", default_value_t = chart().discs)]
    pub discs: usize,
    /// Range of the discs' radii, pixels.
    #[arg(long, value_name = "MIN:MAX", default_value = "3.6:19", value_parser = parse_range)]
    pub radius: RangeInclusive<f64>,
    /// Law of the radii: uniform, or log, by which every octave of radii is equally likely.
    #[arg(long, value_name = "LAW", default_value = "uniform", value_parser = words::<RadiusLaw>(&["uniform", "log"]))]
    pub radius_law: RadiusLaw,
}

/// The charts of a study.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Charts")]
pub struct ChartsArgs {
    /// Number of charts for each ratio, with seeds counting up.
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u64).range(1..=100_000))]
    pub seeds: u64,
    /// The first chart's seed.
    #[arg(long, value_name = "FIRST", default_value_t = 1)]
    pub seed: u64,
    /// Directions of motion: 1d is horizontal, 2d any.
    #[arg(long, value_name = "DIRECTIONS", default_value = "1d", value_parser = motions())]
    pub motion: Motion,
    #[command(flatten)]
    pub discs: DiscsArgs,
}

impl ChartsArgs {
    /// Parameters of the charts; the study sets ratio and seed.
    pub fn params(&self, max_slope: f64) -> ChartParams {
        let DiscsArgs { width, height, discs, radius, radius_law } = self.discs.clone();
        ChartParams { width, height, discs, radius, radius_law, motion: self.motion, max_slope, ..chart() }
    }
}

/// What is compared on charts.
#[derive(Debug, Clone, Args)]
pub struct ComparedArgs {
    /// Methods, separated by commas: sift-frame (SIFT on the middle frame), sift-mean (SIFT on the plain mean of all
    /// frames), sift-merge (SIFT on the aligned and merged burst), buff-1d, buff-2d, buff-auto (slopes found from each
    /// burst).
    #[arg(long, value_name = "METHOD,…", value_delimiter = ',', default_value = "sift-frame,sift-mean,sift-merge,buff-1d,buff-2d",
        value_parser = BurstMethod::from_str)]
    pub methods: Vec<BurstMethod>,
    /// Quantity that a threshold is put on.
    #[arg(long, value_enum, value_name = "RANKING", default_value_t = Ranking::Strength)]
    pub ranking: Ranking,
    /// The share of false detections at which methods are compared.
    #[arg(long, value_name = "SHARE", default_value_t = 0.1)]
    pub false_fraction: f64,
    /// Largest slope of the discs on each axis that moves, pixels per frame.
    #[arg(long, value_name = "SLOPE", default_value_t = chart().max_slope)]
    pub max_slope: f64,
}
