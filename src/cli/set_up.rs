//! `slopes --speed …`: slopes from the set-up of camera and scene, and the depths that slopes then mean.

use super::args::two;
use super::evaluate_tables::{or_dash, table};
use super::{Console, Failure, Outcome, document};
use crate::burst::Positions;
use crate::detector::{DetectorParams, Slope};
use crate::inspect::slopes::{SetUp, SetUpSlopes, Spectrum};
use crate::inspect::words::{number, slope_text};
use clap::Args;
use serde::Serialize;

/// The set-up of camera and scene.
#[derive(Debug, Clone, Copy, Args)]
#[command(next_help_heading = "Set-up of camera and scene")]
pub struct SetUpArgs {
    /// Speed of the camera parallel to its picture, metres per second; gives the slopes, and with INPUT the depths that
    /// its slopes mean.
    #[arg(long, value_name = "M/S", requires_all = ["fps", "focal_px", "depth"])]
    pub speed: Option<f64>,
    /// Direction of that motion, degrees from right towards down.
    #[arg(long, value_name = "DEG", default_value_t = 0.0, allow_negative_numbers = true)]
    pub motion_direction: f64,
    /// Turning of the camera to the right, degrees per second.
    #[arg(long, value_name = "DEG/S", default_value_t = 0.0, allow_negative_numbers = true)]
    pub turn_deg_s: f64,
    /// Frames per second.
    #[arg(long, value_name = "RATE")]
    pub fps: Option<f64>,
    /// Focal length, pixels.
    #[arg(long, value_name = "PX")]
    pub focal_px: Option<f64>,
    /// Nearest and farthest depth, metres.
    #[arg(long, value_name = "NEAR:FAR", value_parser = parse_depth)]
    pub depth: Option<[f64; 2]>,
    /// Number of frames of a burst, without INPUT.
    #[arg(long, value_name = "N", default_value_t = 10)]
    pub frame_count: usize,
}

fn parse_depth(text: &str) -> Result<[f64; 2], String> {
    two(text, ':', f64::is_finite).ok_or_else(|| format!("'{text}' is not NEAR:FAR in metres, such as 1:8"))
}

#[derive(Debug, Serialize)]
pub(super) struct SlopeDepth {
    slope: Slope,
    features: usize,
    depth_m: Option<f64>,
}

impl SetUpArgs {
    pub(super) fn set_up(&self) -> Option<SetUp> {
        Some(SetUp {
            speed_m_s: self.speed?,
            direction_deg: self.motion_direction,
            turn_deg_s: self.turn_deg_s,
            frames_per_second: self.fps?,
            focal_px: self.focal_px?,
            depth_m: self.depth?,
        })
    }

    pub(super) fn slopes(set_up: &SetUp, positions: &Positions, params: &DetectorParams) -> Outcome<SetUpSlopes> {
        set_up.slopes(positions, params).map_err(|problem| Failure::usage(format!("--{problem}")))
    }
}

pub(super) fn say_slopes(console: &Console, set_up: &SetUp, slopes: &SetUpSlopes) -> Outcome {
    console.say(&format!("{}\n  {}\n", slopes.sentence(set_up), slopes.options()))?;
    console.say_document("slopes", &document! { set_up, slopes, options: slopes.options() })
}

pub(super) fn depths(set_up: &SetUp, spectrum: &Spectrum) -> Vec<SlopeDepth> {
    // Where nothing was found there is nothing whose depth could be meant.
    let with_features = spectrum.bars.iter().filter(|bar| bar.features > 0);
    with_features
        .map(|bar| SlopeDepth { slope: bar.slope, features: bar.features, depth_m: set_up.depth_at(bar.slope) })
        .collect()
}

pub(super) fn depths_text(depths: &[SlopeDepth]) -> String {
    let row = |one: &SlopeDepth| {
        let depth = or_dash(one.depth_m, |depth| number(depth as f32, 2));
        vec![format!("  {}", slope_text(one.slope)), one.features.to_string(), depth]
    };
    table(&["  slope", "features", "depth, m"], depths.iter().map(row))
}
