//! From a dataset to COLMAP: what is written, that it is not done twice, and, where pycolmap is installed, that COLMAP
//! reads it.

#[path = "colmap/support.rs"]
mod support;

#[path = "colmap/reading.rs"]
mod reading;
#[path = "colmap/resuming.rs"]
mod resuming;
