//! Opening bursts: every format and its values, every way to name a burst, every failure and its message, and files
//! that are damaged at random.

#[path = "common/shared.rs"]
mod shared;

#[path = "opening/calibrating.rs"]
mod calibrating;
#[allow(dead_code)] // other tests use more of it
#[path = "opening/crafted.rs"]
mod crafted;
#[path = "opening/damaged.rs"]
mod damaged;
#[cfg(feature = "raw")]
#[path = "opening/dng.rs"]
mod dng;
#[path = "opening/errors.rs"]
mod errors;
#[path = "opening/formats.rs"]
mod formats;
#[path = "opening/fuzz.rs"]
mod fuzz;
#[path = "opening/options.rs"]
mod options;
#[path = "opening/photographs.rs"]
mod photographs;
#[cfg(feature = "raw")]
#[path = "opening/raw.rs"]
mod raw;
#[path = "opening/real.rs"]
mod real;
#[path = "opening/sources.rs"]
mod sources;
#[path = "opening/support.rs"]
mod support;
