//! Planes: values between pixels, masks, and colours.

mod display;
mod mask;
mod sample;
