//! The window: panes, panels, overlays, shortcuts. It computes nothing that a command could not compute.
//!
//! [`project`] holds what is open as plain values. Each pass of [`window::BurstscopeApp`] takes what the workers of
//! [`crate::engine`] have published, runs the [`actions`] that were asked for, draws, and lets `jobs` ask the workers
//! for what is wanted and not there.
//!
//! What lies between toolbar and status bar is a [`workspace`]: one burst, two, several methods, or many bursts
//! ([`dataset`]); each arranges panes and panels. Pictures are shown in [panes](pane), each with its own cursor; the
//! [`inspector`] draws any arrangement of them, [`canvas`] is the picture's widget, [`gpu`] draws its pixels,
//! [`histogram`] sets their range. On the pictures one can [`measure`], and a [`figure`] is made of what they show. A
//! [`panel`] is about one subject.

pub mod actions;
pub mod canvas;
pub mod clipboard;
pub mod dataset;
pub mod dialogs;
pub mod figure;
mod files;
pub mod gpu;
pub mod histogram;
pub mod inspector;
mod jobs;
pub mod measure;
pub mod offscreen;
mod overlays;
pub mod pane;
pub mod panel;
pub mod project;
mod render;
mod run;
pub mod session;
pub mod settings;
mod shell;
mod style;
pub mod window;
pub mod workspace;

pub use render::{RenderError, RenderOptions, render_to_png};
pub use run::run;
pub use window::{BurstscopeApp, Startup};
