//! The core: from the frames of a burst to features.
//!
//! The way of the data is one line, and each step is a folder or a file, in the order of the paper: frames →
//! [`stack`] (shift by a slope and average) → [`scale_space`] (Gaussian levels and their differences D, tile by tile)
//! → [`search`] (extrema over place and scale, at each slope for itself or jointly over slope) → [`refine`] (between
//! the samples) → [`distinct`] (one [`keypoint`] for one blob) → [`localise`] (place on a compactly supported kernel,
//! scale, slope) → [`orient`] and [`describe`] (on the pixels around the feature) → [`feature`].
//!
//! Beside the line: [`params`] with the grid of slopes; [`noise`], how noisy a frame is and how large D must be, and
//! [`noise_model`], the same where noise is not white; [`slopes`], which slopes a burst needs, found before all that;
//! [`view`], single steps as pictures; [`advice`], why there is nothing. [`pipeline`] puts the steps together.
//! Everything here is a function from values to values; what takes the time is in [`crate::kernel`].

pub mod advice;
pub mod describe;
pub mod distinct;
mod error;
pub mod feature;
pub mod keypoint;
pub mod localise;
pub mod memory;
pub mod noise;
pub mod noise_model;
pub mod orient;
pub mod params;
pub mod pipeline;
pub mod refine;
pub mod revision;
pub mod scale_space;
pub mod search;
pub mod slopes;
pub mod stack;
pub mod view;

pub use advice::{Advice, explain};
pub use error::DetectError;
pub use feature::{Descriptor, Detection, Feature, StageTimes, Tally, Test};
pub use params::slope_grid::{Slope, SlopeAxis, SlopeGrid};
pub use params::{
    DescribeSlope, DetectorParams, Distinct, Flicker, FrameRange, Interpolation, Localisation, Method, NoiseGate,
    NoiseModelKind, ParamChange, ParamDoc, ParamError, SearchParams, SlopeChoice, SlopeExtrema, SlopeNeighbours,
};
pub use pipeline::{Judgement, Neighbourhood, Sample, Trail, detect, detect_with_trail};
pub use revision::REVISION;
pub use slopes::{SlopeFinding, SlopeVerdict, find_slopes};
