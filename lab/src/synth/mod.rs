//! Datasets with known truth: bursts along a trajectory, dark copies of real frames, and their files.
//!
//! The library's own synthetic bursts (charts, scenes, the demo) are handed on, so that all are in one place. A
//! [`trajectory`] is a whole dataset: bursts of a camera that moves past a scene of textured planes, drawn in
//! perspective, with its poses. Real frames can be captured again by a synthetic camera: [`noisy`] makes dark copies of
//! them. Everything follows from a seed, as in [`burstscope_core::synth`].

pub mod noisy;
pub mod trajectory;
pub mod write;

pub use burstscope_core::synth::*;
pub use noisy::{FrameLevels, NoisyExposure, NoisyParams, NoisyTruth, write_noisy};
pub use trajectory::{Light, Trajectory, TrajectoryParams, write_trajectory};
pub use write::write_burst;
