//! The detector as a whole, and the studies and explanations based on it: laws, published results, accuracy, noise,
//! slopes, cancellation.

#[path = "../common/prelude.rs"]
mod prelude;
#[path = "../common/shared.rs"]
mod shared;

mod aligned;
mod claims;
mod field;
mod found_slopes;
mod goldens;
mod inspect;
mod laws;
mod masks;
mod merging;
mod noise_model;
mod pictures_of_places;
mod planes;
mod rejudged;
mod scenes;
mod score;
mod slopes;
mod stays;
mod under_load;
mod uneven;
mod units;
mod views;
