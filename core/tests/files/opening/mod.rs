//! Opening bursts: every format and its values, every way to name a burst, every failure and its message, and randomly
//! damaged files.

#[cfg(feature = "bags")]
mod bags;
#[allow(dead_code)] // the commands' tests use more of it
mod crafted;
mod damaged;
mod declared;
#[cfg(feature = "raw")]
mod dng;
mod errors;
mod formats;
mod fuzz;
#[cfg(feature = "bags")]
mod hostile_bags;
mod interface;
mod options;
mod order;
mod photographs;
mod plain;
mod promises;
#[cfg(feature = "raw")]
mod raw;
mod support;
mod times;
mod views;
