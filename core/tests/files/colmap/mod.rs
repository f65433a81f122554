//! Export of a dataset to COLMAP: the written files, resuming without repeated work, and, where pycolmap is installed,
//! reading by COLMAP.

mod support;

mod reading;
mod resuming;
