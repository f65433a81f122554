//! The window, driven as a user drives it: by the labels of its buttons, and by keys.
#![allow(clippy::unwrap_used)] // A test may panic; so may its helpers.

#[cfg(feature = "raw")]
#[allow(dead_code)] // other tests use more of them
#[path = "../../core/tests/files/opening/crafted.rs"]
mod crafted;
mod cut;
#[cfg(feature = "raw")]
#[allow(dead_code)]
#[path = "../../core/tests/files/opening/dng.rs"]
mod dng;
mod flat;
mod gpu;
mod greys;
mod harness;
mod pictures;
#[path = "../../core/tests/common/shared.rs"]
mod shared;
mod structure;
mod support;

mod advice;
mod around_lessons;
mod arranging;
mod at_hand;
mod begun;
mod calibrating;
mod canvas;
mod closing;
mod compared;
mod dataset_matches;
mod datasets;
mod detecting;
mod drawn_panels;
mod finding_ones_way;
mod first_start;
mod ghosts;
mod help;
mod keeping;
mod lab;
mod lessons;
mod long_films;
mod looks;
mod lost_matches;
mod maps;
mod measuring;
mod methods;
mod motion;
mod noise;
mod opening;
mod pairs;
mod panes;
mod pinned;
mod playing;
#[cfg(all(unix, not(target_os = "macos")))]
mod portal;
mod probe;
mod probe_plane;
mod recovering;
mod recovery;
mod scrubbing;
mod slopes;
mod steady;
mod steps_back;
mod trajectories;
mod values;
mod whole;
