//! Explanations of a detection.
//!
//! A detector returns what it found. When that is nothing, or too much, or wrong, people ask: what happened at this
//! place ([`probe()`])? Which slopes does this burst need ([`spectrum`])? Which test rejected the candidates
//! ([`candidates`])? What did my change of a parameter do ([`changes`])? Why is this feature not matched
//! ([`unmatched`])? Which true discs were missed ([`truth`])?
//!
//! Everything here explains and decides nothing: a verdict about a sample comes from the search's own function
//! ([`crate::detector::Trail`]), and over a whole picture the verdicts add up to the detection's tally. Where one
//! setting would help, an explanation ends with that setting and its value ([`crate::detector::ParamChange`]).

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
