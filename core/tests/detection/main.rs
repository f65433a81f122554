//! The detector as a whole, and the studies and explanations that stand on it: laws, published answers, accuracy, noise,
//! slopes, cancelling.

#[path = "../common/shared.rs"]
mod shared;

mod accuracy;
mod evaluate;
mod extremes;
mod goldens;
mod inspect;
mod laws;
mod noise_model;
mod reconstruction;
mod slopes;
mod under_load;
