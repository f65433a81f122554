//! The motion stack: frames shifted by a slope and averaged.
//!
//! [`offsets`] says where each frame is read at a slope, and makes the stack; [`refined`] makes it again at slopes
//! between those of the grid, for features.

pub mod offsets;
pub mod refined;
