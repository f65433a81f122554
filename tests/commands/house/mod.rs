//! The walls of the house: which part of the packages may use which, read from the code itself, and what the library
//! depends on. That the library knows nothing of the program is kept by Cargo.

mod circles;
mod dependencies;
mod documents;
mod floors;
mod reading;
mod walls;
