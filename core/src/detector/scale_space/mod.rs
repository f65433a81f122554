//! The scale space: Gaussian levels of a motion stack, octave by octave, and their differences D.
//!
//! [`levels`] names the scales and says which octaves are searched; [`octave`] makes one tile of D, `planes` whole
//! levels of one slope.

pub mod levels;
pub mod octave;
pub(super) mod planes;
