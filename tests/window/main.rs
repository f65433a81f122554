//! The window, driven as a user drives it: by the labels of its buttons, and by keys.
#![allow(clippy::unwrap_used)] // A test may panic; so may its helpers.

#[cfg(feature = "raw")]
#[allow(dead_code)] // other tests use more of them
#[path = "../../core/tests/files/opening/crafted.rs"]
mod crafted;
#[cfg(feature = "raw")]
#[allow(dead_code)]
#[path = "../../core/tests/files/opening/dng.rs"]
mod dng;
mod harness;
mod pictures;
mod support;

mod canvas;
mod compared;
mod datasets;
mod detecting;
mod finding_ones_way;
mod keeping;
mod lab;
mod lessons;
mod looks;
mod maps;
mod measuring;
mod methods;
mod opening;
mod pairs;
mod panes;
mod probe;
mod recovery;
mod scrubbing;
mod slopes;
mod trajectories;
