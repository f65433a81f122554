//! Burstscope finds and shows *burst features*.
//!
//! A robot at night takes bursts of dark, noisy frames. One frame shows little; but if the frames are shifted by the
//! right apparent motion (a *slope*, in pixels per frame) and averaged, everything that moves that way stands out from
//! the noise. The right motion differs from place to place, so the detector tries a whole grid of slopes, filters each
//! mean image over a range of scales, and keeps the extrema over place and scale: at each slope for itself, with one
//! keypoint for each blob, or, as in the paper, jointly over slope too. This is the method of Ravendran, Bryson and
//! Dansereau, "BuFF: Burst Feature Finder for Light-Constrained 3D Reconstruction" (arXiv 2209.09470).
//!
//! This is the library for whoever wants burst features. The package `burstscope-lab` measures it, and `burstscope`
//! adds the window and the command line. A module may use the modules below it, never those above:
//!
//! ```text
//! inspect             explanations: the fate of a candidate, the slopes a burst needs, the effect of a change
//! dataset             many bursts along a path, and their export to COLMAP
//! detect              the front door: features of a burst, by any method
//! baseline, matching  methods for comparison; from descriptors to matches
//! export              one source file for each format
//! detector, synth     the method; bursts with known truth
//! burst               opening, decoding and calibrating frames
//! kernel              vector code of the detector's steps
//! camera              intrinsics of cameras
//! plane               one float image
//! files               small text files, names of files, locks and marks
//! error               the one record of everything that goes wrong
//! monitor             progress and cancellation
//! ```
//!
//! # Conventions
//! `u` is the column, to the right; `v` the row, down; the centre of the first pixel is (0, 0). Slopes are pixels of
//! the input image per frame; a point at `x` at the reference time `t0 = (N − 1)/2` is at `x + (t − t0)·λ` in frame
//! `t`. Frames hold `f32` in [0, 1] of the file's full scale, and thresholds are in that unit. Scale `sigma` is in
//! input pixels. `D = G(next level) − G(this level)`: a bright blob is a negative extremum. Orientations are radians
//! from +u towards +v.

// A public item says its shape, unit, range and errors; in the program a comment stands where it says something.
#![warn(missing_docs)]

pub mod baseline;
pub mod burst;
pub mod camera;
pub mod dataset;
pub mod detect;
pub mod detector;
pub mod error;
pub mod export;
pub mod files;
pub mod inspect;
pub(crate) mod kernel;
pub mod matching;
pub mod monitor;
pub mod plane;
pub mod synth;

/// The commit of which this was built, where the build says it in `BURSTSCOPE_COMMIT`, as `make run` does.
pub const COMMIT: Option<&str> = match option_env!("BURSTSCOPE_COMMIT") {
    Some(given) if !given.is_empty() => Some(given),
    _ => None,
};

pub use burst::Burst;
pub use detect::detect;
pub use detector::{Detection, DetectorParams, Feature, SlopeGrid};
pub use error::Error;
pub use monitor::{Cancelled, Monitor};
pub use plane::Plane;
