//! Small built-in bursts as examples: two failures, in which the paper's method finds false features or misses discs;
//! and scenes that show one effect each.
//!
//! | example | content | where to probe |
//! | --- | --- | --- |
//! | aliasing | three garlands with a small lamp every 8 px, under larger lamps that stand apart, all moving by 1 px/frame: the garlands respond again at −7 px/frame | a dark gap beside a lamp, which is kept at −7 px/frame |
//! | low contrast | nine discs, each fainter than the one before, the last ones hidden by noise | a disc that only the gate rejects |
//! | many depths | a column of lamps at each of nine depths, slope 0 on the left to 2.4 px/frame on the right: a fan in the x–t slice | a lamp in the middle |
//! | tripod | a still camera: everything has slope 0, so depths cannot be told apart | a disc |
//! | hot pixels | lamps that move by 1 px/frame, behind sixty hot pixels of the sensor | a hot pixel |
//! | street, street later | textured walls at two depths in the dark, and the same ones later: for matching | a lamp |

mod scenes;

pub use scenes::{ALIASING_SLOPE, GARLAND_PERIOD, disc_place};

use super::capture::capture_burst;
use super::layer::{Layer, draw_layers, visible_landmarks};
use super::noise::Camera;
use super::truth::{NoiseTruth, Truth, TruthKind};
use crate::burst::Burst;
use crate::monitor::Monitor;
use serde::{Deserialize, Serialize};
use std::ops::RangeInclusive;

/// Columns and rows of an example's frames.
pub const EXAMPLE_SIZE: (usize, usize) = (240, 180);
/// Number of frames of an example.
pub const EXAMPLE_FRAMES: usize = 9;

const SEED: u64 = 20_220_920;
const HALF_SPAN: f64 = 0.5 * (EXAMPLE_FRAMES as f64 - 1.0);
/// Time from the middle of the street to the middle of the later one, frames.
const LATER_FRAMES: f64 = 10.0;

/// Example burst.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Example {
    /// Periodic texture that responds at slopes of no motion.
    Aliasing,
    /// Discs fainter than the gate are not found.
    LowContrast,
    /// Objects at many depths, each with its own slope.
    Depths,
    /// A still camera before a still scene.
    Tripod,
    /// Pixels that are bright independently of the scene.
    HotPixels,
    /// Textured walls in the dark.
    Street,
    /// The walls of `Street` a little later.
    StreetLater,
}

impl Example {
    /// All examples.
    pub const ALL: [Self; 7] = [
        Self::Depths,
        Self::Street,
        Self::StreetLater,
        Self::Aliasing,
        Self::LowContrast,
        Self::Tripod,
        Self::HotPixels,
    ];

    /// Name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Aliasing => "demo-aliasing",
            Self::LowContrast => "demo-low-contrast",
            Self::Depths => "demo-depths",
            Self::Tripod => "demo-tripod",
            Self::HotPixels => "demo-hot-pixels",
            Self::Street => "demo-street",
            Self::StreetLater => "demo-street-later",
        }
    }

    /// The example of this name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|example| example.name() == name)
    }

    /// Label in menus.
    pub fn label(self) -> &'static str {
        match self {
            Self::Aliasing => "Example: aliasing",
            Self::LowContrast => "Example: low contrast",
            Self::Depths => "Example: many depths",
            Self::Tripod => "Example: still tripod",
            Self::HotPixels => "Example: hot pixels",
            Self::Street => "Example: dark street",
            Self::StreetLater => "Example: dark street, later",
        }
    }

    /// Description as a sentence, for menus and tooltips.
    pub fn help(self) -> &'static str {
        match self {
            Self::Aliasing => {
                "Garlands repeat themselves every 8 px, so slopes 8 px/frame apart look alike: features at −7 px/frame, though nothing moves so."
            }
            Self::LowContrast => "Discs of falling contrast: the noise gate rejects those that noise could have made.",
            Self::Depths => {
                "Lamps at nine depths, from slope 0 on the left to 2.4 px/frame on the right: each is sharp at its own slope, and slants of its own in the slice."
            }
            Self::Tripod => "A still camera before a still scene: more light, but slope 0 everywhere, and so no depth.",
            Self::HotPixels => {
                "Lamps that move by 1 px/frame, and sixty pixels of the sensor that stay bright at their places: at slope 0 they look like objects."
            }
            Self::Street => "Textured walls at two depths, too dark for one frame: match it with the later one.",
            Self::StreetLater => "The textured walls a little later: the second burst to match with.",
        }
    }

    /// The place (u, v) worth probing, pixels at mid-burst.
    pub fn place(self) -> [f32; 2] {
        match self {
            Self::Aliasing => scenes::GARLAND_PLACE,
            Self::LowContrast => disc_place(8),
            Self::Depths => scenes::lamp_place(4),
            Self::Tripod => scenes::TRIPOD_PLACE,
            Self::HotPixels => scenes::hot_pixels()[0].0.map(|x| x as f32),
            Self::Street => scenes::STREET_PLACE,
            Self::StreetLater => {
                let [u, v] = scenes::STREET_PLACE;
                [u + LATER_FRAMES as f32 * scenes::STREET_SLOPES[0] as f32, v]
            }
        }
    }

    /// The horizontal slope, px/frame, at which the example shows its effect.
    pub fn slope_u(self) -> f32 {
        match self {
            Self::Aliasing => ALIASING_SLOPE - GARLAND_PERIOD,
            Self::LowContrast => scenes::DISCS_SLOPE,
            Self::Depths => self.truth().layers[4].slope_u as f32,
            Self::Tripod | Self::HotPixels => 0.0,
            Self::Street | Self::StreetLater => scenes::STREET_SLOPES[0] as f32,
        }
    }

    /// The (octave, level) of the response to look at, where it is one of several at its place and not the strongest;
    /// `None` where it is the strongest.
    pub fn scale(self) -> Option<(i32, i32)> {
        (self == Self::Aliasing).then_some((0, 0))
    }

    /// The horizontal slopes at which to search the example: their range, px/frame, and their number.
    pub fn slopes_u(self) -> (RangeInclusive<f32>, usize) {
        match self {
            Self::Aliasing => (-9.0..=9.0, 37),
            Self::LowContrast => (-2.0..=2.0, 9),
            Self::Depths => (-0.5..=3.0, 15),
            Self::Tripod | Self::HotPixels => (-2.0..=2.0, 9),
            Self::Street | Self::StreetLater => (-3.0..=3.0, 13),
        }
    }

    /// The burst; always the same bits.
    pub fn burst(self) -> Burst {
        let never = Monitor::default();
        let layers = self.layers();
        let hot = if self == Self::HotPixels { scenes::hot_pixels() } else { Vec::new() };
        let draw = |dt: f64| {
            let mut signal = draw_layers(&layers, EXAMPLE_SIZE, dt + self.later(), &never)?;
            for ([u, v], value) in &hot {
                signal.data_mut()[v * EXAMPLE_SIZE.0 + u] += value;
            }
            Ok(signal)
        };
        let seed = SEED + u64::from(self == Self::StreetLater);
        capture_burst(self.name(), EXAMPLE_FRAMES, seed, &camera(), &never, draw)
            .expect("nobody can cancel this monitor")
    }

    /// The truth of the example.
    pub fn truth(self) -> Truth {
        let layers = self.layers();
        let mut features = visible_landmarks(&layers, EXAMPLE_SIZE, HALF_SPAN + self.later());
        for feature in &mut features {
            (feature.u, feature.v) = feature.position(self.later());
        }
        Truth {
            kind: TruthKind::Scene,
            width: EXAMPLE_SIZE.0,
            height: EXAMPLE_SIZE.1,
            frames: EXAMPLE_FRAMES,
            t0: HALF_SPAN,
            seed: SEED + u64::from(self == Self::StreetLater),
            noise: NoiseTruth::of(&camera(), f64::from(scenes::GROUND), None),
            black_level: camera().black_level,
            layers: layers.iter().map(Layer::truth).collect(),
            features,
        }
    }

    /// Time of its mid-burst after the scene's own, frames.
    fn later(self) -> f64 {
        if self == Self::StreetLater { LATER_FRAMES } else { 0.0 }
    }

    /// The layers of the example, far to near.
    fn layers(self) -> Vec<Layer> {
        match self {
            Self::Aliasing => vec![scenes::garlands()],
            Self::LowContrast => vec![scenes::discs()],
            Self::Depths => scenes::depths(),
            Self::Tripod => vec![scenes::still()],
            Self::HotPixels => vec![scenes::lamps()],
            Self::Street | Self::StreetLater => scenes::street(HALF_SPAN + LATER_FRAMES),
        }
    }
}

/// As dark as the demo's: 200 electrons at full scale, 3 electrons of read noise, 12 bits.
fn camera() -> Camera {
    Camera { full_scale_electrons: 200.0, read_noise_electrons: 3.0, black_level: 0.07, bits: Some(12) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_examples_are_what_they_say_and_the_same_everywhere() {
        for example in Example::ALL {
            let burst = example.burst();
            assert_eq!(
                (burst.name.as_str(), burst.len(), burst.size()),
                (example.name(), EXAMPLE_FRAMES, EXAMPLE_SIZE)
            );
            let single = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a pool");
            assert_eq!(burst.frames, single.install(|| example.burst()).frames);
            let [u, v] = example.place();
            assert!(u < EXAMPLE_SIZE.0 as f32 && v < EXAMPLE_SIZE.1 as f32);
            assert!(example.slopes_u().0.contains(&example.slope_u()));
            assert!(example.name().starts_with("demo-") && !example.help().is_empty());
            assert_eq!(Example::named(example.name()), Some(example));
        }
    }

    #[test]
    fn the_truth_lies_in_the_picture_and_moves_as_its_layer() {
        for example in Example::ALL {
            let truth = example.truth();
            assert!(truth.features.len() >= 5, "{example:?}: {} features", truth.features.len());
            for feature in &truth.features {
                let layer = &truth.layers[feature.layer.expect("scenes have layers")];
                assert_eq!((feature.slope_u, feature.slope_v), (layer.slope_u, layer.slope_v));
                let inside = (0.0..240.0).contains(&feature.u) && (0.0..180.0).contains(&feature.v);
                assert!(inside, "{example:?}: {feature:?}");
            }
        }
        let slopes: Vec<f64> = Example::Depths.truth().layers.iter().map(|layer| layer.slope_u).collect();
        assert!(slopes.len() == 9 && slopes.is_sorted() && slopes[8] > 2.0, "{slopes:?}");
    }
}
