//! Progress and cancellation: the one handle that long work carries.
//!
//! A [`Monitor`] is cheap to clone; clones share the cancel flag and the listener. Long loops call [`Monitor::check`]
//! once per strip, slope or file and return at once when it fails, without a partial result. Progress is a stage's name
//! and the fraction of it that is done; it may be reported from any thread.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// The work was cancelled; there is no result.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("cancelled")]
pub struct Cancelled;

/// Progress of a piece of work.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress {
    /// Current stage; its text is such as "Searching octave 1".
    pub stage: Stage,
    /// Fraction of the whole work done, 0 … 1.
    pub fraction: f32,
}

/// The stages of long work, in the order in which they happen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, strum::Display)]
pub enum Stage {
    /// Reading and decoding files.
    #[strum(to_string = "Opening frames")]
    Open,
    /// Aligning frames and averaging them.
    #[strum(to_string = "Merging frames")]
    Merge,
    /// Finding the slopes of a burst.
    #[strum(to_string = "Finding slopes")]
    Slopes,
    /// Estimating the noise of a frame.
    #[strum(to_string = "Estimating noise")]
    Noise,
    /// Smoothing and stacking frames, filtering over scales and searching one octave.
    #[strum(to_string = "Searching octave {octave}")]
    Search {
        /// The octave being searched; −1 is the doubled image.
        octave: i32,
    },
    /// Orientations and descriptors.
    #[strum(to_string = "Describing features")]
    Describe,
    /// Comparing the responses of single frames along the tracks of features.
    #[strum(to_string = "Comparing frames")]
    Frames,
    /// Comparing descriptors, and verifying their matches geometrically.
    #[strum(to_string = "Matching features")]
    Match,
    /// Making a synthetic burst.
    #[strum(to_string = "Making the burst")]
    Synth,
    /// Running detectors over many synthetic bursts and scoring what they find.
    #[strum(to_string = "Evaluating")]
    Evaluate,
    /// Writing files.
    #[strum(to_string = "Writing files")]
    Write,
}

type Listener = Arc<dyn Fn(Progress) + Send + Sync>;

/// The handle that carries progress out and cancellation in. The default one reports to nobody and is never cancelled.
#[derive(Clone, Default)]
pub struct Monitor {
    cancel: Arc<AtomicBool>,
    listener: Option<Listener>,
}

impl std::fmt::Debug for Monitor {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Monitor").field("cancel", &self.cancel).finish_non_exhaustive()
    }
}

impl Monitor {
    /// Creates a monitor that calls `listener` with progress, on whichever thread does the work.
    pub fn with_listener(listener: impl Fn(Progress) + Send + Sync + 'static) -> Self {
        Self { cancel: Arc::default(), listener: Some(Arc::new(listener)) }
    }

    /// Monitor with the same cancel flag that reports no progress: for a part of work that reports progress itself.
    pub fn silent(&self) -> Self {
        Self { cancel: self.cancel.clone(), listener: None }
    }

    /// Monitor for a part of larger work, with the same cancel flag; its 0 … 1 is reported as `done` to `done + share`.
    pub fn part(&self, done: f32, share: f32) -> Self {
        let listener = self.listener.clone().map(|listener| -> Listener {
            Arc::new(move |p: Progress| {
                listener(Progress { fraction: (done + share * p.fraction).clamp(0.0, 1.0), ..p });
            })
        });
        Self { cancel: self.cancel.clone(), listener }
    }

    /// Asks the work to stop. It returns [`Cancelled`] at its next check.
    pub fn cancel(&self) {
        self.cancel.store(true, Ordering::Relaxed);
    }

    #[cfg(test)]
    pub(crate) fn cancelled() -> Self {
        let monitor = Self::default();
        monitor.cancel();
        monitor
    }

    /// Whether [`Self::cancel`] was called on this monitor or a clone of it.
    pub fn is_cancelled(&self) -> bool {
        // No data is handed over with the flag.
        self.cancel.load(Ordering::Relaxed)
    }

    /// Fails once the work was cancelled. Loops call it at least every few milliseconds.
    pub fn check(&self) -> Result<(), Cancelled> {
        if self.is_cancelled() { Err(Cancelled) } else { Ok(()) }
    }

    /// Reports progress; `fraction` (of the whole work, 0 … 1) is clamped.
    pub fn report(&self, stage: Stage, fraction: f32) {
        if let Some(listener) = &self.listener {
            listener(Progress { stage, fraction: fraction.clamp(0.0, 1.0) });
        }
    }
}
