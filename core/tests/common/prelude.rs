//! Names that most tests use.
#![allow(dead_code, unused_imports)] // Each test program uses a part of it.

pub use crate::shared::{Folder, folder, folder_with, names, says, shared};
pub use burstscope_core::burst::*;
pub use burstscope_core::detect::{detect, search};
pub use burstscope_core::detector::{params::*, *};
pub use burstscope_core::error::{Error, ErrorKind};
pub use burstscope_core::inspect::{ProbeCache, place::ProbeOptions, place::probe};
pub use burstscope_core::matching::{Geometry, MatchParams};
pub use burstscope_core::monitor::{Cancelled, Monitor, Progress, Stage};
pub use burstscope_core::plane::*;
pub use burstscope_core::synth::{
    ChartParams, Example, FeatureTruth, LayerTruth, Motion, NoiseCase, NoiseKind, RadiusLaw, SceneParams, Truth,
    TruthKind, Uneven, demo_burst, demo_truth, later_demo_burst, random::Stream, synth_chart, synth_scene,
};
pub use proptest::prelude::*;
pub use std::{fs, path::Path, path::PathBuf, sync::Arc};

/// Monitor that nobody hears or cancels.
pub fn quiet() -> Monitor {
    Monitor::default()
}

/// Monitor of work that was cancelled before it began.
pub fn cancelled() -> Monitor {
    let monitor = quiet();
    monitor.cancel();
    monitor
}

pub fn on_threads<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool").install(work)
}
