//! The walls of the house: which part of the packages may use which, read from the code itself, and what the library
//! depends on. That the library knows nothing of the program is kept by Cargo.

#[path = "house/circles.rs"]
mod circles;
#[path = "house/dependencies.rs"]
mod dependencies;
#[path = "house/documents.rs"]
mod documents;
#[path = "house/floors.rs"]
mod floors;
#[path = "house/reading.rs"]
mod reading;
#[path = "house/walls.rs"]
mod walls;
