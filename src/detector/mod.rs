//! The core: from the frames of a burst to features.
//!
//! The way of the data is one line, and each step is a module: frames → [`motion`] (shift by a slope and average) → [`scale_space`] and [`octave`]
//! (Gaussian levels and their differences D, tile by tile) → [`search`] (extrema over place and scale at each slope, or jointly over slope too) → [`refine`] (between the
//! samples) → [`distinct`] (one [`keypoint`] for one blob) → [`locate`] (place on a [`hat`], [`scale_peak`], slope) → [`orientation`] and [`descriptor`] (on a [`patch`] of the Gaussian level). [`noise_estimate`] says how
//! noisy a frame is, and
//! [`noise`] how large D must then be. [`pipeline`] puts them together. [`slopes`] finds which slopes a burst
//! needs, before all that, and [`view`] shows single steps as pictures. Everything here is a function from values to values.

pub mod advice;
pub mod describe;
pub mod distinct;
mod error;
pub mod feature;
pub mod keypoint;
pub mod localise;
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
