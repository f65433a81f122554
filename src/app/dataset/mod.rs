//! Many bursts in one window: a dataset's filmstrip, the matches of its pairs, and the trajectories that come of it.
//!
//! [`model`] holds what is known as plain values; [`work`] starts work of the engine and takes its answers. [`filmstrip`] shows the bursts with their states,
//! [`cut`] asks how a long sequence is cut into bursts.

pub mod cut;
pub mod filmstrip;
pub mod model;
pub mod thumbnails;
mod work;

pub use cut::CutDialog;
pub use model::{BurstState, Dataset, Datasets, Work};
