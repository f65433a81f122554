//! The parts of the window. Each draws from the model, changes the model, and puts the actions that were asked for into a queue.

pub mod about;
pub mod against;
pub mod bottom;
pub mod chooser;
pub mod cursor;
pub mod descriptor;
pub mod display;
pub mod features;
pub mod filter_bar;
pub mod messages;
pub mod noise;
pub mod parameter_rows;
pub mod parameters;
pub mod patch;
pub mod picture;
pub mod probe;
pub mod selection;
pub mod slope_pad;
pub mod sorted_table;
pub mod status;
pub mod table;
pub mod tally;
pub mod toolbar;
pub mod welcome;
pub mod widgets;
