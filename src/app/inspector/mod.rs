//! Centre of *Inspect*, *Two bursts* and *Methods*: panes in any arrangement, their content and links.
//!
//! `egui_tiles` draws the arrangement and lets it be dragged; this module draws the content of a pane: its header, its
//! picture with features, another picture over it, and the mark of the place under the pointer of another pane.
//! Requests of a pane's menu or buttons that change other panes are collected as [`Change`]s and run after all panes
//! are drawn.

mod aside;
mod header;
mod marks;
mod menu;
mod pane_ui;
mod panes;
mod widgets;

pub(in crate::app) use marks::is_with_shift;
pub(in crate::app) use marks::same_place;
pub use menu::Change;
pub(in crate::app) use menu::{copy_ui, match_menu_ui};
pub use pane_ui::Drawn;
pub(in crate::app) use pane_ui::chip_ui;
pub use panes::{Inspected, inspector_ui};
pub use widgets::{JoinedPanes, PaneWidget, PaneWidgets, PlaceValue, compact_description, joined_panes};
