//! Noise: how noisy one frame is, and how large D must be to be none.
//!
//! [`estimate`] measures one white σ of a burst; [`gate`] carries a frame's noise through stack and filters to σ_D.
//! Noise that is not white everywhere is [`super::noise_model`]'s.

pub mod estimate;
pub mod gate;
