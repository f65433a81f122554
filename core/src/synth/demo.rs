//! The demo: a street at night, built into the program and drawn on request.
//!
//! Four planes pass the camera, so dark that one frame shows little. Averaging at a plane's slope makes it visible.

use super::layer::{Layer, draw_layers, even_within, visible_landmarks};
use super::paint::{Area, fractal_relief};
use super::random::{Stream, lattice};
use super::truth::{Truth, TruthKind};
use super::{capture_burst, noise::Camera, uneven::Taken};
use crate::burst::{Burst, Offset};
use crate::monitor::Monitor;

const DEMO_SIZE: (usize, usize) = (480, 360);
const DEMO_FRAMES: usize = 10;

const SEED: u64 = 20_220_919;
/// Time from the middle of the demo to the middle of the later burst, frames.
pub const LATER_FRAMES: f64 = 12.0;
const HALF_SPAN: f64 = 0.5 * (DEMO_FRAMES as f64 - 1.0);
/// Share of the light of the painted layers that reaches the camera: so little that the burst is needed.
const LIGHT: f32 = 0.38;
const SKY: f32 = 0.006;

/// The camera: a high gain (200 electrons at full scale), 3 electrons of read noise, 12 bits.
pub(super) fn camera() -> Camera {
    Camera { full_scale_electrons: 200.0, read_noise_electrons: 3.0, black_level: 0.07, bits: Some(12) }
}

/// The demo burst: 10 frames of 480×360 pixels, always the same bits.
pub fn demo_burst() -> Burst {
    demo_burst_at("demo", 0.0, SEED)
}

/// The demo's street [`LATER_FRAMES`] frames later, with other noise, to match with the first burst.
pub fn later_demo_burst() -> Burst {
    demo_burst_at("demo-later", LATER_FRAMES, SEED + 1)
}

fn demo_burst_at(name: &str, later: f64, noise_seed: u64) -> Burst {
    // Painted as far as the later burst sees: the street must not end at its border.
    let layers = layers(HALF_SPAN + later);
    let never = Monitor::default();
    let signal = |at: Offset| {
        let mut signal = draw_layers(&layers, DEMO_SIZE, later + at.u, &never)?;
        signal.data_mut().iter_mut().for_each(|value| *value *= LIGHT);
        Ok(signal)
    };
    capture_burst(name, &Taken::even(DEMO_FRAMES), noise_seed, &camera(), &never, signal)
        .expect("nobody can cancel this monitor")
}

/// The truth of the demo burst.
pub fn demo_truth() -> Truth {
    let layers = layers(HALF_SPAN);
    let noise = (f64::from(SKY * LIGHT), None);
    let truth = Truth::captured(TruthKind::Demo, DEMO_SIZE, (DEMO_FRAMES, SEED), &camera(), noise);
    let features = visible_landmarks(&layers, DEMO_SIZE, &even_within(HALF_SPAN));
    Truth { layers: layers.iter().map(Layer::truth).collect(), features, ..truth }
}

/// The layers at the demo's mid-burst, painted as far as they are visible `reach` frames away from it.
fn layers(reach: f64) -> [Layer; 4] {
    [skyline(reach), houses(reach), sign(reach), lanterns(reach)]
}

fn skyline(reach: f64) -> Layer {
    let mut layer = Layer::new("skyline", DEMO_SIZE, (0.95, 0.0), reach);
    layer.sheet.fill(|u, v| {
        let dusk = SKY + 0.00003 * v;
        // Clouds, down to where the houses begin.
        if v < 220.0 { dusk + 0.010 * (fractal_relief(5, u, 2.0 * v, 90.0, 2) - 0.4).max(0.0) } else { dusk }
    });
    // The moon in its haze, and stars.
    layer.sheet.glow(92.0, 58.0, 90.0, 0.010);
    layer.landmark(92.0, 58.0, 19.0, 0.062, true);
    for (u, v, r) in [(86.0, 52.0, 5.0), (99.0, 64.0, 4.0), (95.0, 49.0, 2.5)] {
        layer.sheet.disc(u, v, r, 0.046);
    }
    for (u, v, r) in [
        (24.0, 30.0, 2.2),
        (160.0, 24.0, 2.0),
        (190.0, 78.0, 2.4),
        (238.0, 36.0, 2.0),
        (282.0, 70.0, 2.6),
        (340.0, 22.0, 2.2),
        (390.0, 60.0, 2.0),
        (446.0, 34.0, 2.5),
        (140.0, 104.0, 2.0),
        (36.0, 108.0, 2.2),
    ] {
        layer.landmark(u, v, r, 0.06, true);
    }
    // Towers: dark blocks against the sky's glow, with windows, some of them lit.
    let mut stream = Stream::new(SEED, 100);
    let mut u = -12.0f32;
    let mut tower = 0i64;
    while u < 500.0 {
        let width = stream.within(28.0, 46.0) as f32;
        let top = stream.within(112.0, 172.0) as f32;
        layer.sheet.rectangle(Area::new(u, top, u + width, 300.0), 0.0035);
        if tower % 3 == 1 {
            layer.sheet.stroke((u + 0.5 * width, top - 16.0), (u + 0.5 * width, top), 2.0, 0.0035);
            layer.landmark(f64::from(u + 0.5 * width), f64::from(top) - 18.0, 2.2, 0.06, true);
        }
        let columns = ((width - 6.0) / 9.0) as i64;
        for j in 0..8i64 {
            for i in 0..columns {
                let (wu, wv) = (u + 5.0 + 9.0 * i as f32, top + 7.0 + 12.0 * j as f32);
                if wv < 215.0 && lattice(SEED ^ 31, tower * 16 + i, j) < 0.42 {
                    layer.sheet.rectangle(Area::new(wu, wv, wu + 5.0, wv + 6.5), 0.045);
                }
            }
        }
        u += width + stream.within(0.0, 10.0) as f32;
        tower += 1;
    }
    layer
}

fn houses(reach: f64) -> Layer {
    let mut layer = Layer::new("houses", DEMO_SIZE, (-1.05, 0.0), reach);
    let mut stream = Stream::new(SEED, 101);
    let mut left = -14.0f32;
    let mut house = 0i64;
    while left < 500.0 {
        let width = stream.within(74.0, 96.0) as f32;
        let eaves = stream.within(196.0, 212.0) as f32;
        let ridge = eaves - stream.within(22.0, 34.0) as f32;
        let wall = stream.within(0.012, 0.019) as f32;
        let (middle, half) = (left + 0.5 * width, 0.5 * width + 3.0);
        // The roof first: the front covers its lower edge.
        layer.sheet.shape(
            Area::new(left - 4.0, ridge, left + width + 4.0, eaves + 1.0),
            move |u, v| {
                let sloping = ((u - middle).abs() - half * (v - ridge) / (eaves - ridge)) * 0.6;
                sloping.max(v - eaves - 1.0)
            },
            |_, _| 0.005,
        );
        let front = Area::new(left, eaves, left + width, 300.0);
        layer.sheet.textured(front, |u, v| wall + 0.006 * (fractal_relief(77, u, v, 10.0, 2) - 0.5));
        // A round window in the gable, two rows of windows, a door with a lamp over it.
        layer.landmark(f64::from(middle), f64::from(eaves) - 9.0, 4.5, 0.058, true);
        let pitch = width / 3.0;
        for j in 0..2i64 {
            for i in 0..3i64 {
                let (u, v) = (left + pitch * (i as f32 + 0.5), eaves + 13.0 + 36.0 * j as f32);
                if j == 1 && i == house.rem_euclid(3) {
                    layer.sheet.rectangle(Area::new(u - 8.0, v - 2.0, u + 8.0, 300.0), 0.004);
                    layer.landmark(f64::from(u), f64::from(v) - 9.0, 3.2, 0.075, true);
                    continue;
                }
                // By place, not from the stream, so that lit windows change nothing else.
                let lit = lattice(SEED ^ 57, house * 4 + i, j) < 0.62;
                let value = if lit { 0.062 } else { 0.004 };
                layer.sheet.rectangle(Area::new(u - 7.0, v, u + 7.0, v + 19.0), value);
                layer.sheet.rectangle(Area::new(u - 0.8, v, u + 0.8, v + 19.0), wall);
                layer.sheet.rectangle(Area::new(u - 7.0, v + 8.0, u + 7.0, v + 9.6), wall);
            }
        }
        left += width + stream.within(3.0, 9.0) as f32;
        house += 1;
    }
    // The street: pavement, kerb, asphalt with lane marks.
    layer.sheet.rectangle(Area::new(-60.0, 300.0, 540.0, 312.0), 0.022);
    let asphalt = Area::new(-60.0, 312.0, 540.0, 380.0);
    layer.sheet.textured(asphalt, |u, v| 0.009 + 0.007 * (fractal_relief(13, u, 3.0 * v, 24.0, 3) - 0.5));
    for k in 0..9 {
        let u = -40.0 + 66.0 * k as f32;
        layer.sheet.rectangle(Area::new(u, 334.0, u + 34.0, 338.5), 0.05);
    }
    layer
}

/// Letters as seven rows of five lamps, the leftmost lamp in the highest bit.
const LETTERS: [[u8; 7]; 5] = [
    [0b11110, 0b10001, 0b10001, 0b11110, 0b10001, 0b10001, 0b11110],
    [0b10001, 0b10001, 0b10001, 0b10001, 0b10001, 0b10001, 0b01110],
    [0b11110, 0b10001, 0b10001, 0b11110, 0b10100, 0b10010, 0b10001],
    [0b01111, 0b10000, 0b10000, 0b01110, 0b00001, 0b00001, 0b11110],
    [0b11111, 0b00100, 0b00100, 0b00100, 0b00100, 0b00100, 0b00100],
];

fn sign(reach: f64) -> Layer {
    let mut layer = Layer::new("sign", DEMO_SIZE, (-2.1, 0.0), reach);
    // A board of lamps that spells BURST, on two posts.
    for post in [238.0, 372.0] {
        layer.sheet.rectangle(Area::new(post - 3.0, 150.0, post + 3.0, 380.0), 0.026);
    }
    layer.sheet.rectangle(Area::new(212.0, 128.0, 398.0, 184.0), 0.030);
    layer.sheet.rectangle(Area::new(215.0, 131.0, 395.0, 181.0), 0.002);
    let pitch = 5.7;
    for (k, letter) in LETTERS.iter().enumerate() {
        for (j, row) in letter.iter().enumerate() {
            for i in (0..5).filter(|i| row & (0b10000 >> i) != 0) {
                let u = 223.5 + pitch * (6 * k + i) as f32;
                let v = 139.0 + pitch * j as f32;
                layer.sheet.disc(u, v, 2.3, 0.075);
            }
        }
    }
    // A bus stop: a bright disc with a dark one on it, and a timetable of dots.
    layer.sheet.rectangle(Area::new(86.0, 190.0, 91.0, 380.0), 0.03);
    layer.sheet.disc(88.5, 186.0, 17.0, 0.055);
    layer.landmark(88.5, 186.0, 8.0, 0.004, false);
    layer.sheet.rectangle(Area::new(70.0, 222.0, 107.0, 274.0), 0.045);
    for j in 0..4 {
        for i in 0..3 {
            layer.landmark(f64::from(76 + 12 * i) + 0.5, f64::from(229 + 13 * j), 3.0, 0.003, false);
        }
    }
    // A fence along the near edge of the street.
    for rail in [326.0, 346.0] {
        layer.sheet.rectangle(Area::new(-60.0, rail, 540.0, rail + 3.5), 0.030);
    }
    for k in 0..32 {
        let u = -52.0 + 19.0 * k as f32;
        layer.sheet.rectangle(Area::new(u - 2.5, 316.0, u + 2.5, 380.0), 0.034);
        layer.landmark(f64::from(u), 313.0, 4.2, 0.05, true);
    }
    layer
}

fn lanterns(reach: f64) -> Layer {
    let mut layer = Layer::new("lanterns", DEMO_SIZE, (1.6, -1.2), reach);
    for (u, v, size) in [
        (150.0f32, 150.0f32, 1.15f32),
        (304.0, 74.0, 0.85),
        (424.0, 104.0, 1.3),
        (210.0, 92.0, 0.6),
        (366.0, 48.0, 0.5),
    ] {
        // Paper lanterns: ellipses, brightest below their middle.
        let (half_u, half_v) = (9.0 * size, 12.0 * size);
        layer.sheet.shape(
            Area::new(u - half_u, v - half_v, u + half_u, v + half_v),
            move |x, y| {
                let (du, dv) = ((x - u) / half_u, (y - v) / half_v);
                ((du * du + dv * dv).sqrt() - 1.0) * half_u
            },
            move |x, y| {
                let (du, dv) = ((x - u) / half_u, (y - v - 0.3 * half_v) / half_v);
                0.078 - 0.03 * (du * du + dv * dv)
            },
        );
        layer.sheet.rectangle(Area::new(u - 0.5 * half_u, v + half_v, u + 0.5 * half_u, v + half_v + 2.5 * size), 0.02);
    }
    layer
}
