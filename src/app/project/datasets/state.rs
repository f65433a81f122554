//! How far a burst of a dataset is.

use crate::dataset::FinishedBurst;
use crate::inspect::words::counted;

/// How far a burst is.
#[derive(Debug, Clone, PartialEq)]
pub enum BurstState {
    /// Its features are not there, or were found with other parameters.
    Waiting,
    /// Its features are being found.
    Running,
    /// Its features are in the dataset's folder.
    Done(FinishedBurst),
    /// It has no features, and why.
    Failed(String),
}

impl BurstState {
    /// In a few words, as it stands below a burst's picture.
    pub fn text(&self) -> String {
        match self {
            Self::Waiting => "waiting".to_owned(),
            Self::Running => "running".to_owned(),
            Self::Failed(_) => "failed".to_owned(),
            Self::Done(FinishedBurst { features: 0, .. }) => "no features".to_owned(),
            Self::Done(FinishedBurst { features, seconds: None }) => format!("{features}"),
            Self::Done(FinishedBurst { features, seconds: Some(seconds) }) => format!("{features} · {seconds:.1} s"),
        }
    }

    /// In a sentence, for tooltips and screen readers.
    pub fn sentence(&self) -> String {
        match self {
            Self::Waiting => "waiting: no features with these parameters yet".to_owned(),
            Self::Running => "running: its features are being found".to_owned(),
            Self::Failed(error) => format!("failed: {error}"),
            Self::Done(FinishedBurst { features, seconds }) => {
                let time = seconds.map_or_else(String::new, |s| format!(", found in {s:.2} s"));
                let count = if *features == 0 { "no features".to_owned() } else { counted(*features, "feature") };
                format!("done: {count}{time}")
            }
        }
    }
}

/// How many bursts are how far.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct StateCounts {
    /// Finished.
    pub done: usize,
    /// Failed.
    pub failed: usize,
    /// Features of all that are finished.
    pub features: usize,
}
