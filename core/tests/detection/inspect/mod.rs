//! Tests of explanations against the detection: over a whole picture the verdicts add up to the tally, and the kept
//! candidates are those of the detection.

mod ghosts;
mod law;
mod limit;
mod places;
pub mod probing;
mod slopes;
mod verdicts;
