//! Planes: values between pixels, colours, and statistics.

mod display;
mod sample;
mod statistics;
