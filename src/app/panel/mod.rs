//! Panels of the window. Each draws from the model, and puts what the user does into a queue, as actions.

pub mod against;
pub mod bottom;
pub mod cursor;
pub mod cursor_row;
pub mod display;
pub mod features;
pub mod glossary;
pub mod lab;
pub mod methods;
pub mod modals;
pub mod noise;
pub mod parameter_rows;
pub mod parameters;
pub mod picture;
pub mod probe;
pub mod selection;
pub mod slopes;
pub mod status;
pub mod table;
pub mod tally;
pub mod toolbar;
pub mod welcome;
pub mod widgets;
