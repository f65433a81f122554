//! Scenes of the examples.

use super::{EXAMPLE_SIZE, HALF_SPAN, SEED};
use crate::synth::layer::Layer;
use crate::synth::paint::{Area, fractal_relief};
use crate::synth::random::Stream;

/// Period of the garlands, pixels.
pub const GARLAND_PERIOD: f32 = 8.0;
/// Slope of everything in the aliasing example, px/frame.
pub const ALIASING_SLOPE: f32 = 1.0;
/// Rows of the garlands.
const GARLANDS: [f32; 3] = [104.0, 128.0, 152.0];
/// Radius of the garlands' lamps, pixels.
const GARLAND_RADIUS: f64 = 2.4;
/// A dark gap between two lamps of a garland, which is kept as a feature at −7 px/frame.
pub(super) const GARLAND_PLACE: [f32; 2] = [172.0, 101.3];
/// Slope of the discs of the low-contrast example, px/frame.
pub(super) const DISCS_SLOPE: f32 = 1.0;
/// Discs of the low-contrast example: position of the first one, distance, and radius, pixels.
const DISCS: (f32, f32, f32) = (40.0, 40.0, 6.0);
/// Ratio of the contrast of each disc to that of the one before.
const FAINTER: f32 = 0.7;
/// Contrast of the brightest disc, fraction of full scale above the background.
const BRIGHTEST: f32 = 0.02;
/// Background of most scenes, fraction of full scale.
pub(super) const GROUND: f32 = 0.03;
/// Slopes of the street's far and near walls, px/frame.
pub(super) const STREET_SLOPES: [f64; 2] = [1.2, 2.2];
/// Position of a lamp on the street's far wall.
pub(super) const STREET_PLACE: [f32; 2] = [128.0, 48.0];
/// Position of a disc of the still scene.
pub(super) const TRIPOD_PLACE: [f32; 2] = [120.0, 90.0];
/// Rows of the lamps at many depths, with their radii, pixels.
const LAMP_ROWS: [(f32, f64); 3] = [(40.0, 2.5), (90.0, 3.5), (140.0, 5.0)];
/// Number of depths, with a column of lamps at each.
const DEPTHS: usize = 9;

/// Place of disc `index` of the low-contrast example.
pub fn disc_place(index: usize) -> [f32; 2] {
    let (first, apart, _) = DISCS;
    [first + apart * (index % 5) as f32, if index < 5 { 60.0 } else { 120.0 }]
}

/// Place of the lamp in column `index` and the middle row of the lamps at many depths.
pub(super) fn lamp_place(index: usize) -> [f32; 2] {
    [18.0 + 25.0 * index as f32, LAMP_ROWS[1].0]
}

pub(super) fn garlands() -> Layer {
    let mut layer = Layer::new("garlands", EXAMPLE_SIZE, (f64::from(ALIASING_SLOPE), 0.0), HALF_SPAN);
    layer.sheet.fill(|u, v| 0.02 + 0.004 * fractal_relief(41, u, v, 40.0, 2));
    // A row of lamps at unequal distances determines the true slope.
    for (u, v, radius) in [
        (22.0, 40.0, 5.0),
        (61.0, 52.0, 3.5),
        (88.0, 36.0, 4.2),
        (131.0, 47.0, 5.5),
        (172.0, 38.0, 3.2),
        (214.0, 50.0, 4.6),
    ] {
        layer.landmark(u, v, radius, 0.11, true);
    }
    for v in GARLANDS {
        for k in -6..44 {
            layer.landmark(f64::from(GARLAND_PERIOD * k as f32), f64::from(v), GARLAND_RADIUS, 0.09, true);
        }
    }
    layer
}

pub(super) fn discs() -> Layer {
    let mut layer = Layer::new("discs", EXAMPLE_SIZE, (f64::from(DISCS_SLOPE), 0.0), HALF_SPAN);
    layer.sheet.fill(|_, _| GROUND);
    let mut contrast = BRIGHTEST;
    for index in 0..9 {
        let [u, v] = disc_place(index);
        layer.landmark(f64::from(u), f64::from(v), f64::from(DISCS.2), GROUND + contrast, true);
        contrast *= FAINTER;
    }
    layer
}

/// Columns of lamps on posts, at nine depths: the farthest on the left, the nearest on the right.
pub(super) fn depths() -> Vec<Layer> {
    (0..DEPTHS)
        .map(|depth| {
            let name = format!("depth {}", depth + 1);
            let mut layer = Layer::new(&name, EXAMPLE_SIZE, (0.3 * depth as f64, 0.0), HALF_SPAN);
            if depth == 0 {
                layer.sheet.fill(|u, v| 0.012 + 0.008 * fractal_relief(7, u, v, 30.0, 3));
            }
            let [u, _] = lamp_place(depth);
            layer.sheet.rectangle(Area::new(u - 0.8, LAMP_ROWS[0].0, u + 0.8, 200.0), 0.035);
            for (v, radius) in LAMP_ROWS {
                layer.landmark(f64::from(u), f64::from(v), radius, 0.1, true);
            }
            layer
        })
        .collect()
}

/// Discs on a textured wall that does not move.
pub(super) fn still() -> Layer {
    let mut layer = Layer::new("wall", EXAMPLE_SIZE, (0.0, 0.0), HALF_SPAN);
    layer.sheet.fill(|u, v| 0.02 + 0.02 * fractal_relief(11, u, v, 18.0, 4));
    for j in 0..3 {
        for i in 0..5 {
            let (u, v) = (40.0 + 40.0 * f64::from(i), 45.0 + 45.0 * f64::from(j));
            layer.landmark(u, v, 3.0 + f64::from((i + 2 * j) % 4), 0.075, true);
        }
    }
    layer
}

/// Lamps before an even background, moving to the right.
pub(super) fn lamps() -> Layer {
    let mut layer = Layer::new("lamps", EXAMPLE_SIZE, (1.0, 0.0), HALF_SPAN);
    layer.sheet.fill(|_, _| GROUND);
    for j in 0..3 {
        for i in 0..5 {
            let (u, v) = (36.0 + 42.0 * f64::from(i), 40.0 + 50.0 * f64::from(j));
            layer.landmark(u, v, 3.0 + f64::from((i + j) % 3), 0.07, true);
        }
    }
    layer
}

/// Hot pixels of the sensor: their positions (column, row) and their added values.
pub(super) fn hot_pixels() -> Vec<([usize; 2], f32)> {
    let mut stream = Stream::new(SEED, 900);
    (0..60)
        .map(|_| {
            let u = stream.within(6.0, EXAMPLE_SIZE.0 as f64 - 6.0) as usize;
            let v = stream.within(6.0, EXAMPLE_SIZE.1 as f64 - 6.0) as usize;
            ([u, v], stream.within(0.12, 0.35) as f32)
        })
        .collect()
}

/// A wall of plaster and stains behind boards with prints, both with lamps, seen at most `reach` frames from mid-burst.
pub(super) fn street(reach: f64) -> Vec<Layer> {
    let [far, near] = STREET_SLOPES;
    let mut wall = Layer::new("wall", EXAMPLE_SIZE, (far, 0.0), reach);
    wall.sheet.fill(|u, v| 0.012 + 0.06 * fractal_relief(23, u, v, 16.0, 4).powi(2));
    for (u, v, radius) in [
        (128.0, 48.0, 4.0),
        (64.0, 30.0, 3.0),
        (178.0, 66.0, 3.5),
        (88.0, 78.0, 5.0),
        (150.0, 22.0, 3.0),
        (112.0, 96.0, 3.0),
    ] {
        wall.landmark(u, v, radius, 0.09, true);
    }
    let mut boards = Layer::new("boards", EXAMPLE_SIZE, (near, 0.0), reach);
    for k in 0..6 {
        let left = -60.0 + 62.0 * k as f32;
        let board = Area::new(left, 112.0 + 9.0 * (k % 3) as f32, left + 48.0, 190.0);
        boards.sheet.shape(
            board,
            move |u, v| board.distance(u, v),
            |u, v| 0.02 + 0.07 * fractal_relief(57, u, v, 11.0, 3).powi(2),
        );
        boards.landmark(f64::from(left) + 24.0, 150.0, 4.0, 0.004, false);
    }
    vec![wall, boards]
}
