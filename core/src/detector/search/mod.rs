//! Search: extrema of D over place and scale, at each slope for itself or jointly over slope.
//!
//! [`extrema`] compares samples of one slope; [`slope_window`] compares slopes and holds their tiles; [`tile`] goes
//! through all slopes of one tile and applies the tests to each candidate.

pub mod extrema;
pub(super) mod groups;
pub(super) mod inputs;
pub(super) mod octaves;
pub(super) mod setup;
pub mod slope_window;
pub mod tile;
