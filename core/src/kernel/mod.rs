//! Vector code of the detector's most expensive steps: rows of frames that are weighted and summed (`stack`,
//! `masked_rows`), all Gaussian levels of an octave in one pass ([`gaussian_bank`]), and, on the [`patch`] around one
//! feature, its motion stack, its blur, its `gradient`s and the response of a compactly supported kernel
//! ([`compact_kernel`]). Each routine has a plain reference of a few lines, and a test that compares the two.

pub mod compact_kernel;
pub mod gaussian_bank;
pub mod gaussian_jet;
pub(crate) mod gradient;
pub(crate) mod machine;
mod masked_rows;
pub(crate) mod offset;
pub mod patch;
pub mod stack;
