//! Noise of a frame, and the threshold on D that follows from it.
//!
//! [`estimate`] measures one white σ of a burst; [`gate`] propagates a frame's noise through stack and filters to σ_D.
//! For noise that is not white everywhere see [`super::noise_model`].

pub mod estimate;
pub mod gate;
