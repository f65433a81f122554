//! All files that are read and written: bursts, parameters, features, COLMAP's files and its database; sound ones, and
//! randomly damaged ones.

#[path = "../common/damage.rs"]
mod damage;
#[path = "../common/prelude.rs"]
mod prelude;
#[path = "../common/shared.rs"]
mod shared;

mod cases;
#[cfg(feature = "colmap")]
mod colmap;
#[cfg(feature = "colmap")]
mod colmap_database;
mod export;
mod opening;
mod params;
mod parsers;
mod reading_and_locks;
