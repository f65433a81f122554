//! Many bursts in one window: a dataset's filmstrip, the matches of its pairs, and the resulting trajectories.
//!
//! The data is in [`datasets`](crate::app::project::datasets) and [`trajectories`](crate::app::project::trajectories)
//! of the project. [`filmstrip`] shows the bursts with their states, [`cut`] asks how a long sequence is cut into
//! bursts; [`pairs`] shows the matches of all pairs; [`cameras`] and [`errors_panel`] show an estimated trajectory
//! beside the true one.

pub mod cameras;
pub mod cut;
pub mod errors_panel;
pub mod filmstrip;
pub mod pairs;

pub use cut::CutDialog;
pub(in crate::app) use cut::{CutChoice, cut_offer_ui, replace_features_ui};
