//! Matches made exact by the pixels around them.
//!
//! The place of a blob in a dark burst is uncertain by about half its σ, since only a few pixels determine it. Its
//! surroundings do far better: two views of the same thing can be laid over one another to a tenth of that. Each place
//! keeps a [`Chip`], the mean of the frames along its motion for 16 σ to each side. For the matches of a pair of images
//! ([`pair`]) one chip is found in the other by normalised correlation (`search`) and fitted by an affine map
//! (`lucas_kanade`). From all pairs together [`solve()`] computes one correction for each place.
//!
//! Everything here is a function from values to values, with the same bits for any number of threads.

pub mod chip;
mod grid;
mod lucas_kanade;
pub mod pair;
mod search;
pub mod solve;

pub use chip::{Chip, ChipSource};
pub use pair::{Guess, Measured, PairFrame, View, measure, measure_near};
pub use solve::{Link, Places, Solved, solve};
