//! Many bursts: [`filmstrip`], how a film is [`cut`], matching [`pairs`], trajectories ([`cameras`], [`errors_panel`]).

pub mod cameras;
pub mod cut;
pub mod errors_panel;
pub mod filmstrip;
pub mod pairs;

pub use cut::CutDialog;
pub(in crate::app) use cut::{cut_offer_ui, replace_features_ui};
