//! The detector: computes features from the frames of a burst.
//!
//! Data flows through steps, each a folder or a file, in the order of the paper: frames → [`stack`] (shift by a slope
//! and average) → [`scale_space`] (Gaussian levels and their differences D, tile by tile) → `search` (extrema over
//! place and scale, at each slope for itself or jointly over slope) → `refine` (between the samples) → `distinct` (one
//! [keypoint](feature::Keypoint) for one blob) → [`localise`] (place on a compactly supported kernel, scale, slope) →
//! `orient` and [`describe`] (on the pixels around the feature) → `limit` (motion beyond the slopes) → [`feature`],
//! whose values [`quantity`] lists. From `distinct` on the steps read D along any motion (`along`), as [`coherence`]
//! does, a measure of how alike frames respond. [`test`](mod@test) has a record of each test.
//!
//! Besides: [`params`] with the grid of slopes; [`noise`], the noise of a frame and the threshold on D, and
//! [`noise_model`], both where noise is not white; [`slopes`], the slopes that a burst needs, found before the search;
//! [`view`], single steps as pictures. `pipeline` puts the steps together.
//! Everything here is a function from values to values; the costly inner loops are in `crate::kernel`.

mod along;
pub mod coherence;
pub mod combine;
pub mod describe;
mod distinct;
pub mod feature;
pub mod field;
pub(crate) mod limit;
pub mod localise;
pub mod memory;
pub mod noise;
pub mod noise_model;
mod orient;
pub mod params;
pub(crate) mod pipeline;
pub mod quantity;
pub(crate) mod refine;
pub mod scale_space;
pub(crate) mod search;
pub mod slopes;
pub mod stack;
pub mod test;
pub mod view;

pub use combine::Combine;
pub use feature::{Descriptor, Detection, Feature, Moves, REVISION, StageTimes, Tally, Test};
pub use field::{Motion, MotionField, MotionLayer};
pub use params::slope_grid::{Slope, SlopeAxis, SlopeGrid};
pub use params::{
    CoarseStart, DescribeSlope, DetectorParams, Distinct, Flicker, FrameRange, Interpolation, Localisation, Method,
    NoiseGate, NoiseModelKind, Param, ParamChange, ParamDoc, Rules, SearchParams, SearchSlopes, SlopeExtrema,
    SlopeNeighbours, Slopes,
};
pub use pipeline::{FirstFeatures, Judgement, Neighbourhood, Sample, Trail, follows, shared_slopes};
pub use quantity::Quantity;
pub use scale_space::Scale;
pub use slopes::{SlopeFinding, SlopeVerdict, find_slopes, open_burst};
