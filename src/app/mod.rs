//! The window: panes, panels, overlays, shortcuts. It computes nothing that a command could not compute.
//!
//! [`document`] holds what is set, as plain values, and [`results`] what the workers of [`crate::engine`] answered
//! about it. Each pass of [`window::BurstscopeApp`] takes what was published, draws, runs the [`actions`] that were
//! asked for, and requests what is missing. What a part changes beyond what it owns is a value, a [`results::Effect`].
//!
//! A [`workspace`] arranges panes and panels; the [`inspector`] draws [panes](pane), [`canvas`] is a picture's widget.

pub mod actions;
pub mod apply;
pub mod canvas;
pub mod clipboard;
pub mod dataset;
mod defaults;
pub mod dialogs;
pub mod document;
mod effects;
pub mod figure;
mod files;
pub mod gpu;
pub mod histogram;
pub mod inspector;
pub mod lesson;
pub mod measure;
mod memo;
pub mod messages;
pub mod offscreen;
mod overlays;
pub mod pane;
pub mod panel;
pub mod parts;
pub mod recovery;
mod render;
pub mod results;
mod run;
pub mod session;
pub mod settings;
mod startup;
mod style;
mod ticks;
pub mod view;
pub mod window;
pub mod words;
pub mod workspace;

pub use render::{RenderOptions, render_to_png};
pub use run::run;
pub use startup::{EndRequest, Startup};
pub use window::BurstscopeApp;
