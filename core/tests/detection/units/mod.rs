//! Tests of the parts of the library that are public, a file for each room.

mod dataset;
mod detector;
mod drawing;
mod export;
mod inspect;
mod matching;
mod smaller;
mod synth;
