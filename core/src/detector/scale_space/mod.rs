//! Scale space: Gaussian levels of a motion stack, octave by octave, and their differences D.
//!
//! [`levels`] defines the scales and the octaves that are searched; [`octave`] computes one tile of D, `planes` whole
//! levels of one slope.

pub mod levels;
pub mod octave;
pub(super) mod planes;
