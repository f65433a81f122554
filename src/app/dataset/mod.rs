//! Many bursts in one window: a dataset's [`filmstrip`], how a long sequence is [`cut`] into one, the matches of its
//! [`pairs`], and the estimated trajectory beside the true one ([`cameras`], [`errors_panel`]).

pub mod cameras;
pub mod cut;
pub mod errors_panel;
pub mod filmstrip;
pub mod pairs;

pub use cut::CutDialog;
pub(in crate::app) use cut::{CutChoice, cut_offer_ui, replace_features_ui};
