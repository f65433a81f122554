//! What burst features are compared with: a burst made into one image, on which an ordinary detector runs.
//!
//! Each baseline is a function from a burst to a burst of one frame. The same detector then runs on it with [`crate::detector::Method::Sift`],
//! so that a comparison shows what the burst search adds and nothing else. (SIFT on a single frame needs no baseline: that is the same
//! method on the burst itself, of which it takes the middle frame.)

mod mean;

pub use mean::plain_mean;
