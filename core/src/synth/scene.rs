//! Layered scenes: textured planes at several depths, each with its own slope.
//!
//! The farthest layer fills the frame; nearer ones carry boards of writing, stripes, or dots, the truth's landmarks.

use super::layer::{Layer, draw_layers, visible_landmarks};
#[cfg(feature = "cli")]
use super::options::{SNR_HELP, motions};
use super::paint::{Area, fractal_relief};
use super::truth::{Truth, TruthKind};
use super::{Motion, capture_burst, check_common, random::Stream, uneven::Uneven};
use super::{arm::Arm, chart::CLEARANCE_SIGMAS, noise::Camera};
use crate::burst::{Burst, Offset};
use crate::error::{Error, Result};
use crate::monitor::Monitor;

/// Parameters of a layered scene.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "cli", derive(clap::Args))]
pub struct SceneParams {
    /// Columns.
    #[cfg_attr(feature = "cli", arg(long, value_name = "PIXELS", default_value_t = Self::default().width))]
    pub width: usize,
    /// Rows.
    #[cfg_attr(feature = "cli", arg(long, value_name = "PIXELS", default_value_t = Self::default().height))]
    pub height: usize,
    /// Number of layers; the farthest fills the frame.
    #[cfg_attr(feature = "cli", arg(long, value_name = "N", default_value_t = Self::default().layers))]
    pub layers: usize,
    /// Number of frames.
    #[cfg_attr(feature = "cli", arg(long, value_name = "N", default_value_t = Self::default().frames))]
    pub frames: usize,
    /// Times of the frames.
    #[cfg_attr(feature = "cli", command(flatten))]
    pub uneven: Uneven,
    /// Share of the columns that a textured thing hides, on the left, which stands still in all frames, as a robot's
    /// arm. Its mask is written to masks/mask.png, and what it hides is not among the known features.
    #[cfg_attr(feature = "cli", arg(long, value_name = "SHARE", default_value_t = 0.0))]
    pub mask: f64,
    /// Directions of motion: 1d is horizontal, 2d any.
    #[cfg_attr(feature = "cli", arg(long, value_name = "DIRECTIONS", default_value = "1d", value_parser = motions()))]
    pub motion: Motion,
    /// Largest slope on each axis, pixels per frame.
    #[cfg_attr(feature = "cli", arg(long, value_name = "SLOPE", default_value_t = Self::default().max_slope))]
    pub max_slope: f64,
    /// Signal-to-noise ratio of one pixel in one frame between boards ([`BOARD`]) and marks ([`MARK`]).
    #[cfg_attr(feature = "cli", arg(long, value_name = "RATIO", default_value_t = Self::default().snr, help = SNR_HELP))]
    pub snr: f64,
    /// Standard deviation of the read noise, electrons.
    #[cfg_attr(feature = "cli", arg(long, value_name = "ELECTRONS", default_value_t = Self::default().read_noise))]
    pub read_noise: f64,
    /// Bits of the camera's converter.
    #[cfg_attr(feature = "cli", arg(long, value_name = "BITS", default_value_t = Self::default().bits))]
    pub bits: u32,
    /// Seed: the same seed makes the same burst on every machine.
    #[cfg_attr(feature = "cli", arg(long, value_name = "N", default_value_t = Self::default().seed))]
    pub seed: u64,
}

impl Default for SceneParams {
    fn default() -> Self {
        Self {
            width: 640,
            height: 480,
            layers: 4,
            frames: 10,
            uneven: Uneven::default(),
            mask: 0.0,
            motion: Motion::OneD,
            max_slope: 3.0,
            snr: 1.0,
            read_noise: 3.0,
            bits: 12,
            seed: 1,
        }
    }
}

/// Signal of a board's bare surface, fraction of full scale above black.
pub const BOARD: f64 = 0.04;
/// Signal of the bright marks on a board, fraction of full scale above black.
pub const MARK: f64 = 0.1;

/// Makes a layered scene and its truth: the layers' slopes, and the landmarks completely visible in every frame.
///
/// # Errors
/// A parameter that makes no sense, or cancellation.
pub fn synth_scene(params: &SceneParams, monitor: &Monitor) -> Result<(Burst, Truth)> {
    let frames = params.uneven.count_and_span(params.frames);
    check_common(params.width, params.height, frames, params.max_slope, params.read_noise, params.bits)?;
    let whole = params.uneven.whole(params.frames);
    if !(1..=16).contains(&params.layers) {
        return Err(Error::param("layers", format!("{} layers", params.layers), "give 1 to 16"));
    }
    let mut camera = Camera::for_snr(params.snr, BOARD, MARK, params.read_noise, 0.0, params.bits)?;
    camera.black_level = (CLEARANCE_SIGMAS * camera.sigma(0.0)).max(1.0 / 64.0);
    // Marks and noise above the pedestal must stay below white.
    if camera.black_level + 3.0 * MARK > 1.0 {
        let problem = format!("{} makes the noise wider than full scale", params.snr);
        return Err(Error::param("snr", problem, "give a ratio of 0.5 or more"));
    }
    let arm = Arm::new(params.mask, params.width, BOARD, params.seed)?;
    let layers = build_layers(params, whole.offsets(), monitor)?;
    let size = (params.width, params.height);
    let taken = params.uneven.taken(params.frames, params.seed)?;
    let burst = capture_burst("scene", &taken, params.seed, &camera, monitor, |at| {
        let mut picture = draw_layers(&layers, size, at, monitor)?;
        arm.draw_over(&mut picture);
        Ok(picture)
    })?;
    let noise = (BOARD, Some(params.snr));
    let truth = Truth::captured(TruthKind::Scene, size, (params.frames, params.seed), &camera, noise);
    // Seen in all frames of the even burst, so that an uneven one has the same things.
    let features = visible_landmarks(&layers, size, whole.offsets());
    let truth = taken.truth(Truth { layers: layers.iter().map(Layer::truth).collect(), features, ..truth });
    Ok((burst, arm.truth(truth)))
}

fn build_layers(params: &SceneParams, offsets: &[Offset], monitor: &Monitor) -> Result<Vec<Layer>> {
    let mut stream = Stream::new(params.seed, 0);
    let mut layers = Vec::with_capacity(params.layers);
    for index in 0..params.layers {
        monitor.check()?;
        let slope = layer_slope(params, index, &mut stream);
        let name = if index == 0 { "ground".to_owned() } else { format!("boards {index}") };
        let mut layer = Layer::seen_at(&name, (params.width, params.height), slope, offsets);
        if index == 0 {
            paint_ground(&mut layer, params.seed, &mut stream);
        } else {
            paint_boards(&mut layer, params, index, &mut stream);
        }
        layers.push(layer);
    }
    Ok(layers)
}

/// Each layer's slope is drawn from the middle of its own part of the range.
fn layer_slope(params: &SceneParams, index: usize, stream: &mut Stream) -> (f64, f64) {
    let part = 2.0 * params.max_slope / params.layers as f64;
    let mut along = || -params.max_slope + part * (index as f64 + stream.within(0.2, 0.8));
    let u = along();
    match params.motion {
        Motion::OneD => (u, 0.0),
        // The vertical parts go in steps of two, so that the slopes do not lie on a line.
        Motion::TwoD => {
            let other = (index * 2 + 1) % params.layers.max(1);
            (u, -params.max_slope + part * (other as f64 + stream.within(0.2, 0.8)))
        }
    }
}

fn paint_ground(layer: &mut Layer, seed: u64, stream: &mut Stream) {
    let area = layer.sheet.area();
    layer.sheet.fill(|u, v| {
        let ground = 0.012 + 0.05 * fractal_relief(seed, u, v, 48.0, 5);
        // A second relief, thresholded at its middle, gives edges.
        let edge = fractal_relief(seed ^ 0x5bd1, u, v, 90.0, 2);
        ground + 0.02 * ((edge - 0.5) * 40.0).clamp(-0.5, 0.5)
    });
    let count = (((area.u1 - area.u0) * (area.v1 - area.v0)) / 5000.0) as usize;
    let mut placed: Vec<(f64, f64, f64)> = Vec::new();
    for _ in 0..count {
        let radius = stream.within(2.5, 9.0);
        let (u, v) = place_in(area, radius + 2.0, stream);
        // Blobs apart from each other by several pixels are single features.
        if placed.iter().all(|p| (p.0 - u).hypot(p.1 - v) > p.2 + radius + 6.0) {
            placed.push((u, v, radius));
            let bright = stream.uniform() < 0.6;
            layer.landmark(u, v, radius, if bright { 0.11 } else { 0.004 }, bright);
        }
    }
}

fn place_in(area: Area, rim: f64, stream: &mut Stream) -> (f64, f64) {
    let pick = |low: f32, high: f32, stream: &mut Stream| stream.within(f64::from(low) + rim, f64::from(high) - rim);
    (pick(area.u0, area.u1, stream), pick(area.v0, area.v1, stream))
}

/// Paints boards with marks, spread over the sheet; nearer layers have fewer and larger ones.
fn paint_boards(layer: &mut Layer, params: &SceneParams, index: usize, stream: &mut Stream) {
    let scale = (params.width.min(params.height) as f64 / 480.0).clamp(0.25, 4.0);
    let size = scale * (60.0 + 25.0 * index as f64);
    let area = layer.sheet.area();
    // About a fifth of the sheet for each layer, so that farther ones stay visible.
    let covered = 0.22 * f64::from((area.u1 - area.u0) * (area.v1 - area.v0));
    let count = ((covered / (size * size)).round() as usize).clamp(1, 400);
    for number in 0..count {
        let (half_u, half_v) = (0.5 * size * stream.within(0.7, 1.3), 0.5 * size * stream.within(0.7, 1.3));
        let (u, v) = place_in(area, 0.0, stream);
        let board = Area::new((u - half_u) as f32, (v - half_v) as f32, (u + half_u) as f32, (v + half_v) as f32);
        let shade = stream.within(0.7, 1.3) as f32;
        // A new board hides landmarks of an earlier one of the same layer there.
        layer.landmarks.retain(|l| board.distance(l.u as f32, l.v as f32) > l.radius as f32 + 1.0);
        layer.sheet.rectangle(board, BOARD as f32 * shade);
        match (number + index) % 3 {
            0 => dots(layer, board, scale, stream),
            1 => writing(layer, board, scale, stream),
            _ => stripes(layer, board, scale, stream),
        }
    }
}

fn dots(layer: &mut Layer, board: Area, scale: f64, stream: &mut Stream) {
    let pitch = scale.max(0.5) * stream.within(20.0, 28.0);
    let columns = (f64::from(board.u1 - board.u0) / pitch) as usize;
    let rows = (f64::from(board.v1 - board.v0) / pitch) as usize;
    for j in 0..rows {
        for i in 0..columns {
            let radius = pitch * stream.within(0.12, 0.26);
            let jitter = 0.1 * pitch;
            let u = f64::from(board.u0) + (i as f64 + 0.5) * pitch + stream.within(-jitter, jitter);
            let v = f64::from(board.v0) + (j as f64 + 0.5) * pitch + stream.within(-jitter, jitter);
            let bright = stream.uniform() < 0.7;
            layer.landmark(u, v, radius, if bright { MARK as f32 } else { 0.006 }, bright);
        }
    }
}

fn writing(layer: &mut Layer, board: Area, scale: f64, stream: &mut Stream) {
    let height = (7.0 * scale.max(0.5)) as f32;
    let mut v = board.v0 + height;
    while v + height < board.v1 {
        let mut u = board.u0 + height;
        while u + height < board.u1 {
            for _ in 0..2 {
                let pick = |stream: &mut Stream| stream.within(0.0, f64::from(height)) as f32;
                let from = (u + 0.6 * pick(stream), v + pick(stream));
                let to = (u + 0.6 * pick(stream), v + pick(stream));
                layer.sheet.stroke(from, to, 0.2 * height, MARK as f32);
            }
            u += height * if stream.uniform() < 0.2 { 1.8 } else { 0.9 };
        }
        v += 1.9 * height;
    }
}

fn stripes(layer: &mut Layer, board: Area, scale: f64, stream: &mut Stream) {
    let width = (scale.max(0.5) * stream.within(5.0, 11.0)) as f32;
    let slant = stream.within(-0.8, 0.8) as f32;
    let inset = Area::new(board.u0 + width, board.v0 + width, board.u1 - width, board.v1 - width);
    if inset.u0 >= inset.u1 || inset.v0 >= inset.v1 {
        return;
    }
    let across = 1.0 / (1.0 + slant * slant).sqrt();
    layer.sheet.shape(
        inset,
        |u, v| {
            let x = (u + slant * v) * across / (2.0 * width);
            let stripe = ((x - x.floor() - 0.5).abs() - 0.25) * 2.0 * width;
            stripe.max(inset.distance(u, v))
        },
        |_, _| MARK as f32 * 0.8,
    );
}
