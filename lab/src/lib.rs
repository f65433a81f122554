//! The measuring bench of Burstscope: what measures and teaches the detector of [`burstscope_core`].
//!
//! Somebody who wants burst features needs the library alone. Here is what shows how good they are: datasets of a
//! camera that moves past a scene ([`synth`]), studies against known truth ([`evaluate`]), things planted in a burst
//! and counted ([`recover`]), and every figure and table of the paper ([`figures`]). A module may use those below it:
//!
//! ```text
//! figures             every figure and table of the paper, reproduced
//! study               one study of any kind, with its table and plots
//! recover             the share of planted things that a search finds
//! evaluate            the quality of the detector, measured against known truth
//! synth               trajectories and dark copies of real frames, besides the library's charts and scenes
//! burstscope_core     the method and its files
//! ```
//!
//! The conventions are those of [`burstscope_core`].

// A public item says its shape, unit, range and errors; in the program a comment stands where it says something.
#![warn(missing_docs)]

pub mod evaluate;
pub mod figures;
pub mod recover;
pub mod study;
pub mod synth;
