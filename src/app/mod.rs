//! The window: panes, panels, overlays, shortcuts. It computes nothing that a command could not compute.
//!
//! [`project`] holds what is open as plain values. Each pass of [`window::BurstscopeApp`] lets it take what the workers
//! of [`crate::engine`] have published, draws, runs the [`actions`] that were asked for, and lets it request what is
//! missing. What a part changes beyond what it owns is a value, a [`project::Effect`]; `effects` applies all of them.
//!
//! A [`workspace`] arranges panes and panels; the [`inspector`] draws [panes](pane), [`canvas`] is a picture's widget.

pub mod actions;
pub mod canvas;
pub mod clipboard;
pub mod dataset;
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
pub mod offscreen;
mod overlays;
pub mod pane;
pub mod panel;
pub mod parts;
pub mod project;
pub mod recovery;
mod render;
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
