//! The program: the window and the commands on top of the library [`burstscope_core`], which finds and shows *burst
//! features*. The library's modules and its most used items are handed on, so that `burstscope::detector` is
//! `burstscope_core::detector`, whose conventions hold here.
//!
//! A room may use the rooms below it, never those above:
//!
//! ```text
//! cli, app            the commands; the window
//! teach               lessons and the glossary, as data
//! engine              background workers: latest request wins, cancel, progress
//! requests            what can be asked for in the background, and what is answered
//! burstscope_lab      what measures and teaches the method
//! burstscope_core     the method and its files
//! ```

#[cfg(feature = "app")]
pub mod app;
#[cfg(feature = "cli")]
pub mod cli;
pub mod engine;
pub mod requests;
pub mod teach;

pub use burstscope_core::{Burst, Cancelled, Detection, DetectorParams, Feature, Monitor, Plane, SlopeGrid, detect};
pub use burstscope_core::{
    baseline, burst, dataset, detector, error, export, files, inspect, matching, monitor, plane,
};
pub use burstscope_lab::{evaluate, figures, recover, study, synth};
