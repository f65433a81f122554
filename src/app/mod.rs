//! The window: panes, panels, overlays, shortcuts. It computes nothing that a command could not compute.
//!
//! [`window::BurstscopeApp`] holds the [`state::Model`] (plain values), the workers of [`crate::engine`], and what the widgets remember. Each
//! pass takes what the workers have published, runs the [`actions`] that were asked for, draws the [`panels`], and asks the workers for what is
//! wanted and not there. What lies between toolbar and status bar is a room: one burst, two, several methods, or many bursts ([`dataset`]).
//! [`canvas`] is the picture's widget, [`gpu`] draws its pixels, [`histogram`] sets their range.

pub mod actions;
mod burst_work;
pub mod canvas;
mod compare_work;
pub mod dataset;
pub mod dialogs;
mod files;
pub mod gpu;
pub mod histogram;
pub mod offscreen;
mod pair_work;
pub mod panels;
mod render;
pub mod rooms;
mod run;
pub mod session;
pub mod settings;
mod shell;
pub mod state;
mod style;
pub mod window;
mod writing;

pub use render::{RenderError, RenderOptions, render_to_png};
pub use run::run;
pub use window::{BurstscopeApp, Startup};
