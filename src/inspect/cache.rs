//! What questions about one burst are answered from: its detection with all it left behind. It is made once and then
//! asked as often as one likes.

use crate::baseline::prepare;
use crate::burst::Burst;
use crate::detector::slopes::resolve;
use crate::detector::{
    DetectError, Detection, DetectorParams, Method, SearchParams, SlopeChoice, SlopeFinding, Trail, detect_with_trail,
};
use crate::monitor::Monitor;

/// A burst, its detection, and what the detection was made with.
#[derive(Debug)]
pub struct ProbeCache {
    /// The burst as it was searched: for [`Method::Merge`] the merged frame.
    pub burst: Burst,
    /// The detection and what it left.
    pub trail: Trail,
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
        let trail = detect_with_trail(&burst, &resolved, &monitor.part(share, 1.0 - share))?;
        Ok(Self { burst, trail, finding, asked: params.clone() })
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
