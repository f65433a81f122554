//! Two failures to look at: aliasing and low contrast, the cases in which the paper's method finds what is not there,
//! or does not find what is.
//!
//! | example | what there is to see | where to probe |
//! | --- | --- | --- |
//! | aliasing | three garlands with a small lamp every 8 px, under larger lamps that stand apart, all moving by 1 px/frame: the garlands answer again at −7 px/frame | a small lamp |
//! | low contrast | nine discs, each fainter than the one before, down to what the noise hides | a disc that the gate takes |

use super::capture::capture_burst;
use super::layer::{Layer, draw_layers};
use super::noise::Camera;
use super::paint::fractal_relief;
use crate::burst::Burst;
use crate::monitor::Monitor;
use serde::{Deserialize, Serialize};
use std::ops::RangeInclusive;

/// Columns and rows of an example's frames.
pub const EXAMPLE_SIZE: (usize, usize) = (240, 180);
/// Frames of an example.
pub const EXAMPLE_FRAMES: usize = 9;
/// After how many pixels the garlands repeat themselves.
pub const GARLAND_PERIOD: f32 = 8.0;
/// How fast everything in the aliasing example moves, px/frame.
pub const ALIASING_SLOPE: f32 = 1.0;

const SEED: u64 = 20_220_920;
const HALF_SPAN: f64 = 0.5 * (EXAMPLE_FRAMES as f64 - 1.0);
/// Rows of the garlands.
const GARLANDS: [f32; 3] = [104.0, 128.0, 152.0];
/// The discs of the low-contrast example: place of the first one, distance, and radius, pixels.
const DISCS: (f32, f32, f32) = (40.0, 40.0, 6.0);
/// How much fainter each disc is than the one before.
const FAINTER: f32 = 0.7;
/// The brightest disc, fraction of full scale above the ground.
const BRIGHTEST: f32 = 0.02;

/// A failure to look at.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Example {
    /// Periodic texture answers at slopes that nothing moves with.
    Aliasing,
    /// What is fainter than the gate is not found.
    LowContrast,
}

impl Example {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Aliasing, Self::LowContrast];

    /// The word that names it on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Aliasing => "demo-aliasing",
            Self::LowContrast => "demo-low-contrast",
        }
    }

    /// What menus call it.
    pub fn label(self) -> &'static str {
        match self {
            Self::Aliasing => "Example: aliasing",
            Self::LowContrast => "Example: low contrast",
        }
    }

    /// What it shows, as a sentence for menus and tooltips.
    pub fn help(self) -> &'static str {
        match self {
            Self::Aliasing => {
                "Garlands repeat themselves every 8 px, so slopes 8 px/frame apart look alike: features at −7 px/frame, though nothing moves so."
            }
            Self::LowContrast => {
                "Discs of falling contrast: the noise gate takes those that the noise could have made."
            }
        }
    }

    /// The place (u, v) worth probing, pixels at mid-burst.
    pub fn place(self) -> [f32; 2] {
        match self {
            Self::Aliasing => [120.0, GARLANDS[1]],
            Self::LowContrast => disc_place(8),
        }
    }

    /// The horizontal slopes with which it shows what it is for: their range, px/frame, and how many.
    pub fn slopes_u(self) -> (RangeInclusive<f32>, usize) {
        match self {
            Self::Aliasing => (-9.0..=9.0, 37),
            Self::LowContrast => (-2.0..=2.0, 9),
        }
    }

    /// Its frames, always the same bits.
    pub fn burst(self) -> Burst {
        let never = Monitor::default();
        let layers = match self {
            Self::Aliasing => [garlands()],
            Self::LowContrast => [discs()],
        };
        let draw = |dt: f64| draw_layers(&layers, EXAMPLE_SIZE, dt, &never);
        capture_burst(self.name(), EXAMPLE_FRAMES, SEED, &camera(), &never, draw)
            .expect("nobody can cancel this monitor")
    }
}

/// Place of disc `index` of the low-contrast example.
pub fn disc_place(index: usize) -> [f32; 2] {
    let (first, apart, _) = DISCS;
    [first + apart * (index % 5) as f32, if index < 5 { 60.0 } else { 120.0 }]
}

/// As dark as the demo's: 200 electrons at full scale, 3 electrons of read noise, 12 bits.
fn camera() -> Camera {
    Camera { full_scale_electrons: 200.0, read_noise_electrons: 3.0, black_level: 0.07, bits: Some(12) }
}

fn garlands() -> Layer {
    let mut layer = Layer::new("garlands", EXAMPLE_SIZE, (f64::from(ALIASING_SLOPE), 0.0), HALF_SPAN);
    layer.sheet.fill(|u, v| 0.02 + 0.004 * fractal_relief(41, u, v, 40.0, 2));
    // A row of lamps, of which no two are equally far apart, tells the true slope.
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
            layer.sheet.disc(GARLAND_PERIOD * k as f32, v, 2.4, 0.09);
        }
    }
    layer
}

fn discs() -> Layer {
    let mut layer = Layer::new("discs", EXAMPLE_SIZE, (1.0, 0.0), HALF_SPAN);
    const GROUND: f32 = 0.03;
    layer.sheet.fill(|_, _| GROUND);
    let mut contrast = BRIGHTEST;
    for index in 0..9 {
        let [u, v] = disc_place(index);
        layer.landmark(f64::from(u), f64::from(v), f64::from(DISCS.2), GROUND + contrast, true);
        contrast *= FAINTER;
    }
    layer
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
            assert!(example.name().starts_with("demo-") && !example.help().is_empty());
        }
    }
}
