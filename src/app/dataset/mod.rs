//! Many bursts in one window: a dataset's filmstrip, the matches of its pairs, and the resulting trajectories.
//!
//! The data is in [`datasets`](crate::app::project::datasets) and [`trajectories`](crate::app::project::trajectories)
//! of the project. [`filmstrip`] shows the bursts with their states, [`cut`] asks how a long sequence is cut into
//! bursts, and a film opened as one burst is offered to be cut; [`matrix`] and [`pair_list`] show the matches of all
//! pairs; [`plane_view`], [`points_strip`], [`camera_list`] and [`errors_panel`] show an estimated trajectory beside
//! the true one.

pub mod camera_list;
pub mod cut;
mod cut_offer;
pub mod errors_panel;
pub mod filmstrip;
pub mod matrix;
pub mod pair_list;
pub mod plane_view;
pub mod points_strip;
mod replace;
pub mod thumbnails;

pub use cut::CutDialog;
pub(in crate::app) use cut_offer::{CutChoice, cut_offer_ui};
pub(in crate::app) use replace::replace_features_ui;
