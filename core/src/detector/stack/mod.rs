//! Motion stack: frames shifted by a slope and averaged.
//!
//! [`offsets`] computes where each frame is read at a slope, and makes the stack; [`refined`] makes it for features, at
//! slopes between those of the grid.

pub mod offsets;
pub mod refined;
