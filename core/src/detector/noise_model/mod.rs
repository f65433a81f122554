//! Noise model of a burst as cameras and files make it, for a noise gate that is right at every place.
//!
//! The gate of [`crate::detector::noise::gate`] propagates white noise of one strength through the filters. Real noise
//! grows with brightness ([`photon_transfer`]), differs by place ([`place`]), is correlated between neighbouring pixels
//! and has long tails where files were compressed ([`spectrum`]); frames repeat others, are black or too noisy
//! ([`frames`]), and a sensor has a pattern of its own ([`fixed_pattern`]). [`examine()`] finds all of it from the
//! burst alone and gives a [`NoiseModel`], which computes σ of D for an octave, a level, a slope and a place, with a
//! [`NoiseWarning`] for each assumption that fails.

pub mod contrast;
pub mod examine;
pub mod fixed_pattern;
pub mod frames;
pub mod high_pass;
pub mod hot_pixels;
pub mod level_tiles;
pub mod model;
pub mod photon_transfer;
pub mod place;
pub mod pyramid;
pub mod reading;
pub mod scene_motion;
pub mod spectrum;
pub mod stripes;
pub mod warning;

pub use examine::{Examined, ForSearch, examine};
pub use model::NoiseModel;
pub use warning::{NoiseWarning, WarningKind};
