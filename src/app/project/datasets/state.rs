//! States of a dataset's bursts.

use crate::dataset::FinishedBurst;
use crate::inspect::words::counted;

/// State of a burst.
#[derive(Debug, Clone, PartialEq)]
pub enum BurstState {
    /// Its features were not found yet, or with other parameters.
    Waiting,
    /// Its features are being found.
    Running,
    /// Its features are in the dataset's folder.
    Done(FinishedBurst),
    /// Finding its features failed, for this reason.
    Failed(String),
}

impl BurstState {
    /// The state in a few words, for below a burst's picture.
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

    /// The state in a sentence, for tooltips and screen readers.
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

/// Numbers of bursts by state.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct StateCounts {
    /// Number of bursts that are finished.
    pub done: usize,
    /// Number of bursts that failed.
    pub failed: usize,
    /// Number of features in all finished bursts.
    pub features: usize,
}
