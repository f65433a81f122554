//! Small built-in bursts as examples: two failures of the paper's method, and scenes that show one effect each.
//! [`Example::help`] says what an example shows, [`Example::place`] where to probe it.

use super::layer::{Layer, draw_layers, even_within, visible_landmarks};
use super::truth::{Truth, TruthKind};
use super::{capture_burst, demo::camera, uneven::Taken};
use crate::burst::{Burst, Offset, Positions};
use crate::synth::paint::{Area, fractal_relief};
use crate::{monitor::Monitor, synth::random::Stream};
use serde::{Deserialize, Serialize};
use std::ops::RangeInclusive;
use strum::{EnumCount, VariantArray};

const EXAMPLE_SIZE: (usize, usize) = (240, 180);
/// Number of frames of an example.
pub const EXAMPLE_FRAMES: usize = 9;

const VIEWS: usize = 5;
const SEED: u64 = 20_220_920;
const HALF_SPAN: f64 = 0.5 * (EXAMPLE_FRAMES as f64 - 1.0);
/// Time from the middle of the street to the middle of the later one, frames.
const LATER_FRAMES: f64 = 10.0;

/// Example burst.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize, EnumCount, VariantArray)]
#[serde(rename_all = "snake_case")]
pub enum Example {
    /// Objects at many depths, each with its own slope.
    Depths,
    /// Light field of the objects of `Depths`.
    Views,
    /// Lamps of two motions whose ways cross.
    Crossing,
    /// Textured walls in the dark.
    Street,
    /// The walls of `Street` a little later.
    StreetLater,
    /// Periodic texture that responds at slopes of no motion.
    Aliasing,
    /// Discs fainter than the gate are not found.
    LowContrast,
    /// A still camera before a still scene.
    Tripod,
    /// Pixels that are bright independently of the scene.
    HotPixels,
}

impl Example {
    /// All examples.
    pub const ALL: [Self; Self::COUNT] = *Self::VARIANTS.first_chunk().expect("as many");

    /// Name on the command line.
    pub fn name(self) -> &'static str {
        self.words().0
    }

    /// The example of this name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|example| example.name() == name)
    }

    /// Label in menus.
    pub fn label(self) -> &'static str {
        self.words().1
    }

    /// Name and label.
    fn words(self) -> (&'static str, &'static str) {
        match self {
            Self::Aliasing => ("demo-aliasing", "Example: aliasing"),
            Self::LowContrast => ("demo-low-contrast", "Example: low contrast"),
            Self::Depths => ("demo-depths", "Example: many depths"),
            Self::Crossing => ("demo-crossing", "Example: two ways that cross"),
            Self::Tripod => ("demo-tripod", "Example: still tripod"),
            Self::HotPixels => ("demo-hot-pixels", "Example: hot pixels"),
            Self::Street => ("demo-street", "Example: dark street"),
            Self::StreetLater => ("demo-street-later", "Example: dark street, later"),
            Self::Views => ("demo-views", "Example: light field"),
        }
    }

    /// Description as a sentence, for menus and tooltips.
    pub fn help(self) -> &'static str {
        match self {
            Self::Aliasing => {
                "Garlands repeat themselves every 8 px, so slopes 8 px/frame apart look alike: features at −7 px/frame, although nothing moves at that slope."
            }
            Self::LowContrast => "Discs of falling contrast: the noise gate rejects those that noise could have made.",
            Self::Depths => {
                "Lamps at nine depths, from slope 0 on the left to 2.4 px/frame on the right: each is sharp at its own slope, and slants of its own in the slice."
            }
            Self::Crossing => {
                "Lamps that pass to the right and to the left, by 1.5 px/frame each: features at other slopes are ghosts, to which only some of the frames respond."
            }
            Self::Tripod => "A still camera before a still scene: more light, but slope 0 everywhere, and so no depth.",
            Self::HotPixels => {
                "Lamps that move by 1 px/frame, and sixty pixels of the sensor that stay bright at their places: at slope 0 they look like objects."
            }
            Self::Street => "Textured walls at two depths, too dark for one frame: match it with the later one.",
            Self::StreetLater => "The textured walls a little later: the second burst to match with.",
            Self::Views => {
                "A light field of 5 × 5 views of the lamps at nine depths: a slope is the disparity between neighbouring views, along rows and columns alike."
            }
        }
    }

    /// The place (u, v) worth probing, pixels at mid-burst.
    pub fn place(self) -> [f32; 2] {
        match self {
            Self::Aliasing => GARLAND_PLACE,
            Self::LowContrast => disc_place(8),
            Self::Depths | Self::Views => lamp_place(4),
            Self::Crossing => GHOST.0,
            Self::Tripod => [120.0, 90.0],
            Self::HotPixels => hot_pixels()[0].0.map(|x| x as f32),
            Self::Street => STREET_PLACE,
            Self::StreetLater => {
                let [u, v] = STREET_PLACE;
                [u + LATER_FRAMES as f32 * STREET_SLOPES[0] as f32, v]
            }
        }
    }

    /// The horizontal slope, px/frame, at which the example shows its effect.
    pub fn slope_u(self) -> f32 {
        match self {
            Self::Aliasing => ALIASING_SLOPE - GARLAND_PERIOD,
            Self::LowContrast => DISCS_SLOPE,
            Self::Depths | Self::Views => self.truth().layers[4].slope_u as f32,
            Self::Crossing => GHOST.1,
            Self::Tripod | Self::HotPixels => 0.0,
            Self::Street | Self::StreetLater => STREET_SLOPES[0] as f32,
        }
    }

    /// The (octave, level) of the response to look at; `None` where it is the strongest at its place.
    pub fn scale(self) -> Option<(i32, i32)> {
        (self == Self::Aliasing).then_some((0, 0))
    }

    /// The horizontal slopes at which to search the example: their range, px/frame, and their number.
    pub fn slopes_u(self) -> (RangeInclusive<f32>, usize) {
        match self {
            Self::Aliasing => (-9.0..=9.0, 37),
            Self::LowContrast => (-2.0..=2.0, 9),
            Self::Depths | Self::Views => (-0.5..=3.0, 15),
            Self::Tripod | Self::HotPixels => (-2.0..=2.0, 9),
            Self::Crossing | Self::Street | Self::StreetLater => (-3.0..=3.0, 13),
        }
    }

    /// The burst; always the same bits.
    pub fn burst(self) -> Burst {
        let never = Monitor::default();
        let layers = self.layers();
        let hot = if self == Self::HotPixels { hot_pixels() } else { Vec::new() };
        let draw = |at: Offset| {
            let mut signal = draw_layers(&layers, EXAMPLE_SIZE, at.u + self.later(), &never)?;
            for ([u, v], value) in &hot {
                signal.data_mut()[v * EXAMPLE_SIZE.0 + u] += value;
            }
            Ok(signal)
        };
        let seed = SEED + u64::from(self == Self::StreetLater);
        capture_burst(self.name(), &Taken::all(&self.positions()), seed, &camera(), &never, draw)
            .expect("nobody can cancel this monitor")
    }

    /// The truth of the example.
    pub fn truth(self) -> Truth {
        let layers = self.layers();
        let positions = self.positions();
        let seen_in = match self {
            Self::Views => positions.offsets().to_vec(),
            // The later street lies farther from the layers' own mid-burst.
            _ => even_within(HALF_SPAN + self.later()),
        };
        let mut features = visible_landmarks(&layers, EXAMPLE_SIZE, &seen_in);
        for feature in &mut features {
            (feature.u, feature.v) = feature.position(self.later());
        }
        let seed = SEED + u64::from(self == Self::StreetLater);
        let noise = (f64::from(GROUND), None);
        let truth = Truth::captured(TruthKind::Scene, EXAMPLE_SIZE, (positions.len(), seed), &camera(), noise);
        let layers = layers.iter().map(Layer::truth).collect();
        Truth { layers, features, views: positions.views(), ..truth }
    }

    fn positions(self) -> Positions {
        if self == Self::Views { Positions::grid(VIEWS, VIEWS) } else { Positions::even(EXAMPLE_FRAMES) }
    }

    /// Time of its mid-burst after the scene's own, frames.
    fn later(self) -> f64 {
        if self == Self::StreetLater { LATER_FRAMES } else { 0.0 }
    }

    fn layers(self) -> Vec<Layer> {
        match self {
            Self::Aliasing => vec![garlands()],
            Self::LowContrast => vec![discs()],
            Self::Depths | Self::Views => depths(self.positions().offsets()),
            Self::Crossing => crossing(),
            Self::Tripod => vec![still()],
            Self::HotPixels => vec![lamps()],
            Self::Street | Self::StreetLater => street(HALF_SPAN + LATER_FRAMES),
        }
    }
}

/// Period of the garlands, pixels.
pub const GARLAND_PERIOD: f32 = 8.0;
/// Slope of everything in the aliasing example, px/frame.
pub const ALIASING_SLOPE: f32 = 1.0;
const GARLANDS: [f32; 3] = [104.0, 128.0, 152.0];
/// A dark gap between two lamps of a garland, which is kept as a feature at −7 px/frame.
const GARLAND_PLACE: [f32; 2] = [172.0, 101.3];
const DISCS_SLOPE: f32 = 1.0;
/// Position of the first disc, distance, and radius, pixels.
const DISCS: (f32, f32, f32) = (40.0, 40.0, 6.0);
/// Background of most scenes, fraction of full scale.
const GROUND: f32 = 0.03;
/// Slopes of the street's far and near walls, px/frame.
const STREET_SLOPES: [f64; 2] = [1.2, 2.2];
/// Position of a lamp on the street's far wall.
const STREET_PLACE: [f32; 2] = [128.0, 48.0];
/// Speed of the crossing lamps, to the right and to the left, px/frame.
const CROSSING_SLOPE: f64 = 1.5;
/// End of a lamp's streak, kept as a feature where nothing moves: its place, and its slope in px/frame.
const GHOST: ([f32; 2], f32) = ([192.1, 89.8], 0.0);
/// Rows of the lamps at many depths, with their radii, pixels.
const LAMP_ROWS: [(f32, f64); 3] = [(40.0, 2.5), (90.0, 3.5), (140.0, 5.0)];
const DEPTHS: usize = 9;

/// Place of disc `index` of the low-contrast example.
pub fn disc_place(index: usize) -> [f32; 2] {
    let (first, apart, _) = DISCS;
    [first + apart * (index % 5) as f32, if index < 5 { 60.0 } else { 120.0 }]
}

fn lamp_place(index: usize) -> [f32; 2] {
    [18.0 + 25.0 * index as f32, LAMP_ROWS[1].0]
}

fn garlands() -> Layer {
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
            layer.landmark(f64::from(GARLAND_PERIOD * k as f32), f64::from(v), 2.4, 0.09, true);
        }
    }
    layer
}

fn discs() -> Layer {
    let mut layer = Layer::new("discs", EXAMPLE_SIZE, (f64::from(DISCS_SLOPE), 0.0), HALF_SPAN);
    layer.sheet.fill(|_, _| GROUND);
    let mut contrast = 0.02f32;
    for index in 0..9 {
        let [u, v] = disc_place(index);
        layer.landmark(f64::from(u), f64::from(v), f64::from(DISCS.2), GROUND + contrast, true);
        contrast *= 0.7;
    }
    layer
}

/// Columns of lamps on posts, at nine depths: the farthest on the left, the nearest on the right.
fn depths(offsets: &[Offset]) -> Vec<Layer> {
    (0..DEPTHS)
        .map(|depth| {
            let name = format!("depth {}", depth + 1);
            let mut layer = Layer::seen_at(&name, EXAMPLE_SIZE, (0.3 * depth as f64, 0.0), offsets);
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

/// Lamps that pass to the right, and before them lamps that pass to the left in the same rows.
fn crossing() -> Vec<Layer> {
    let lamps = |name: &str, slope: f64, apart: [f64; 3]| {
        let mut layer = Layer::new(name, EXAMPLE_SIZE, (slope, 0.0), HALF_SPAN);
        if slope > 0.0 {
            layer.sheet.fill(|_, _| GROUND);
        }
        for ((v, radius), apart) in LAMP_ROWS.into_iter().zip(apart) {
            for k in 0..5 {
                layer.landmark(28.0 + 42.0 * f64::from(k) + apart, f64::from(v), radius, 0.1, true);
            }
        }
        layer
    };
    let right = lamps("to the right", CROSSING_SLOPE, [0.0; 3]);
    // The ways of two lamps as far apart at mid-burst cross within the burst.
    vec![right, lamps("to the left", -CROSSING_SLOPE, [6.0, 9.0, 12.0])]
}

fn still() -> Layer {
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

fn lamps() -> Layer {
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

fn hot_pixels() -> Vec<([usize; 2], f32)> {
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
fn street(reach: f64) -> Vec<Layer> {
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
        boards.sheet.textured(board, |u, v| 0.02 + 0.07 * fractal_relief(57, u, v, 11.0, 3).powi(2));
        boards.landmark(f64::from(left) + 24.0, 150.0, 4.0, 0.004, false);
    }
    vec![wall, boards]
}
