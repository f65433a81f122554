//! Planes: values between pixels, and colours.

mod display;
mod sample;
