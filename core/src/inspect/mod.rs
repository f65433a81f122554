//! Why: the questions that a detection raises, and their answers.
//!
//! A detector says what it found. When that is nothing, or too much, or wrong, people ask: what happened at this place
//! ([`probe()`])? Which slopes does this burst need ([`spectrum`])? Which test took the candidates ([`candidates`])?
//! What did my change of a parameter do ([`changes`])? Why is this feature not matched ([`unmatched`])? Which of the
//! things that are really there were missed ([`truth`])?
//!
//! Everything here explains and decides nothing: a verdict about a sample comes from the function of the search that
//! gave it ([`crate::detector::Trail`]), and over a whole picture the verdicts add up to the detection's tally. An
//! explanation ends, where one setting would help, in that setting and its value ([`crate::detector::ParamChange`]).

pub mod cache;
pub mod candidates;
pub mod changes;
pub mod fate;
pub mod figure;
pub mod foreign;
pub mod probe;
pub mod remedy;
pub mod report;
pub mod response;
pub mod shares;
pub mod slices;
pub mod spectrum;
pub mod spot;
pub mod suspicion;
pub mod telling;
pub mod texture;
pub mod truth;
pub mod unmatched;
pub mod words;

pub use cache::ProbeCache;
pub use fate::{Fate, Outcome, TestReport};
pub use probe::{Probe, ProbeError, ProbeOptions, Subject, probe};
