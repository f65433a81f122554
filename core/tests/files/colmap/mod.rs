//! From a dataset to COLMAP: what is written, that it is not done twice, and, where pycolmap is installed, that COLMAP
//! reads it.

mod support;

mod reading;
mod resuming;
