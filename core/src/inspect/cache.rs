//! What questions about one burst are answered from: its detection with all it left behind. It is made once and then
//! asked as often as one likes.

use crate::baseline::prepare;
use crate::burst::Burst;
use crate::detector::slopes::resolve;
use crate::detector::{
    DetectError, Detection, DetectorParams, Method, SearchParams, SlopeChoice, SlopeFinding, Trail, detect_with_trail,
};
use crate::monitor::Monitor;
use std::sync::Arc;

/// A burst, its detection, and what the detection was made with.
#[derive(Debug)]
pub struct ProbeCache {
    /// The burst as it was searched: for [`Method::Merge`] the merged frame.
    pub burst: Burst,
    /// The detection and what it left. Shared: it is large, and may have been asked for in several words.
    pub trail: Arc<Trail>,
    /// What was found of the slopes, if they were to be found.
    pub finding: Option<SlopeFinding>,
    /// The parameters as they were asked for.
    pub asked: SearchParams,
}

/// Part of the progress that finding the slopes takes.
const SLOPES_SHARE: f32 = 0.2;

impl ProbeCache {
    /// Detects the features of `burst`, finding its slopes first where they are to be found, and keeps what questions
    /// need.
    ///
    /// # Errors
    /// [`DetectError::Param`] for parameters that make no sense for the burst, [`DetectError::Cancelled`] once
    /// `monitor` was cancelled.
    pub fn new(burst: &Burst, params: &SearchParams, monitor: &Monitor) -> Result<Self, DetectError> {
        let (resolved, finding) = resolve(burst, params, &monitor.part(0.0, SLOPES_SHARE))?;
        let share = if finding.is_some() { SLOPES_SHARE } else { 0.0 };
        let (burst, resolved) = prepare(burst, &resolved, &monitor.silent())?;
        let trail = Arc::new(detect_with_trail(&burst, &resolved, &monitor.part(share, 1.0 - share))?);
        Ok(Self { burst, trail, finding, asked: params.clone() })
    }

    /// The same detection, as what comes of asking for it with other words: `finding` is what was found of its slopes,
    /// if those words say that they are to be found.
    pub fn asked_as(&self, asked: &SearchParams, finding: Option<&SlopeFinding>) -> Self {
        let (burst, trail) = (self.burst.clone(), self.trail.clone());
        Self { burst, trail, finding: finding.cloned(), asked: asked.clone() }
    }

    /// The parameters of the whole detection: those that were asked for, with the slopes that were searched.
    pub fn made_with(&self) -> DetectorParams {
        // A merged frame is searched as one frame, whichever frames were asked for.
        DetectorParams { frames: self.asked.detector.frames, ..self.params().clone() }
    }

    /// Bytes that it takes beside `open`, the burst that was searched: about, and as much as it takes now. Some of what
    /// answers questions is made when one is asked first.
    pub fn bytes_beside(&self, open: &Burst) -> usize {
        self.trail.bytes_beside(&open.frames)
    }

    /// What was found.
    pub fn detection(&self) -> &Detection {
        self.trail.detection()
    }

    /// The parameters that were searched with, the slopes among them.
    pub fn params(&self) -> &DetectorParams {
        self.trail.params()
    }

    /// Whether the slopes were found and not given.
    pub fn slopes_were_found(&self) -> bool {
        self.params().method == Method::Buff && matches!(self.asked.slopes, SlopeChoice::Auto { .. })
    }
}
