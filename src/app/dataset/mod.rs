//! Many bursts in one window: a dataset's filmstrip, the matches of its pairs, and the trajectories that come of it.
//!
//! [`model`], [`mod@matches`] and [`trajectories`] hold what is known as plain values; `work` starts work of the engine and takes its answers. [`filmstrip`]
//! shows the bursts with their states, [`cut`] asks how a long sequence is cut into bursts; [`matrix`] and [`pair_list`] show the matches of all pairs;
//! [`plane_view`], [`points_strip`], [`camera_list`] and [`errors_panel`] show an estimated trajectory beside the true one.

pub mod camera_list;
pub mod cut;
pub mod errors_panel;
pub mod filmstrip;
pub mod matches;
pub mod matrix;
pub mod model;
pub mod pair_list;
pub mod plane_view;
pub mod points_strip;
pub mod thumbnails;
pub mod trajectories;

pub use cut::CutDialog;
pub use model::{BurstState, Dataset, Datasets, Work};
pub use trajectories::{Trajectories, Which};
