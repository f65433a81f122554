//! Datasets with known truth: bursts along a trajectory, dark copies of real frames, and their files.
//!
//! The library's own synthetic bursts (charts, scenes, the demo) are handed on. A [`trajectory`] is a whole dataset:
//! bursts of a camera that moves past a scene of textured planes, with its poses. [`noisy`] captures real frames again
//! with a synthetic camera. Everything follows from a seed, as in [`burstscope_core::synth`].

pub mod noisy;
pub mod trajectory;
pub mod write;

pub use burstscope_core::synth::*;
pub use noisy::{FrameLevels, NoisyExposure, NoisyParams, NoisyTruth, write_noisy};
pub use trajectory::{Light, Trajectory, TrajectoryParams, write_trajectory};
pub use write::write_burst;
