//! Centre of *One burst* and *Two bursts*: panes in any arrangement, drawn and dragged by `egui_tiles`, their content
//! and links. Changes are pushed as actions, which are applied after all panes are drawn.

mod header;
mod marks;
mod menu;
mod pane_ui;
mod panes;
mod widgets;

pub(in crate::app) use marks::{is_led, is_with_shift, same_place};
pub(in crate::app) use menu::{copy_ui, feature_items_ui, match_menu_ui};
pub use pane_ui::Drawn;
pub(in crate::app) use pane_ui::chip_ui;
pub use panes::inspector_ui;
pub use widgets::{PaneWidget, PaneWidgets, PlaceValue, joined_panes, short_description, side_of};
