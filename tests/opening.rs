//! Opening bursts: every format and its values, every way to name a burst, every failure and its message, and files
//! that are damaged at random.

#[path = "opening/errors.rs"]
mod errors;
#[path = "opening/formats.rs"]
mod formats;
#[path = "opening/fuzz.rs"]
mod fuzz;
#[path = "opening/options.rs"]
mod options;
#[path = "opening/real.rs"]
mod real;
#[path = "opening/sources.rs"]
mod sources;
#[path = "opening/support.rs"]
mod support;
