//! The window: panes, panels, overlays, shortcuts. It computes nothing that a command could not compute.

pub mod canvas;
pub mod gpu;
pub mod offscreen;
