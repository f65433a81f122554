//! The window, driven as a person drives it: by what is written on its buttons, and by keys.
#![allow(clippy::unwrap_used)] // A test may panic; so may its helpers.

mod common;

#[path = "window/support.rs"]
mod support;

#[path = "window/calibrating.rs"]
mod calibrating;
#[path = "window/candidates.rs"]
mod candidates;
#[path = "window/closing.rs"]
mod closing;
#[path = "window/coherence.rs"]
mod coherence;
#[path = "window/compared.rs"]
mod compared;
#[path = "window/dataset_matches.rs"]
mod dataset_matches;
#[path = "window/datasets.rs"]
mod datasets;
#[path = "window/detecting.rs"]
mod detecting;
#[path = "window/examples.rs"]
mod examples;
#[path = "window/filmstrip.rs"]
mod filmstrip;
#[path = "window/finding_ones_way.rs"]
mod finding_ones_way;
#[path = "window/glossary.rs"]
mod glossary;
#[path = "window/keeping.rs"]
mod keeping;
#[path = "window/lab.rs"]
mod lab;
#[path = "window/lessons.rs"]
mod lessons;
#[path = "window/long_films.rs"]
mod long_films;
#[path = "window/looks.rs"]
mod looks;
#[path = "window/lost_matches.rs"]
mod lost_matches;
#[path = "window/maps.rs"]
mod maps;
#[path = "window/measuring.rs"]
mod measuring;
#[path = "window/methods.rs"]
mod methods;
#[path = "window/narrow.rs"]
mod narrow;
#[path = "window/noise.rs"]
mod noise;
#[path = "window/opening.rs"]
mod opening;
#[path = "window/pairs.rs"]
mod pairs;
#[path = "window/panes.rs"]
mod panes;
#[path = "window/paper_figures.rs"]
mod paper_figures;
#[path = "window/probe.rs"]
mod probe;
#[path = "window/probe_plane.rs"]
mod probe_plane;
#[path = "window/recovery.rs"]
mod recovery;
#[path = "window/scrubbing.rs"]
mod scrubbing;
#[path = "window/slopes.rs"]
mod slopes;
#[path = "window/spectrum.rs"]
mod spectrum;
#[path = "window/steps_back.rs"]
mod steps_back;
#[path = "window/trajectories.rs"]
mod trajectories;
#[path = "window/truth.rs"]
mod truth;
