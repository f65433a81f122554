//! Advice on the frames: frames that add nothing, and frames that much of the picture has left.

use super::advice::{SlopeAdvice, Subject, Telling};
use super::coverage_share;
use crate::detector::params::doc;
use crate::detector::{FrameRange, ParamChange, Slope, SlopeVerdict};
use crate::inspect::words::{number, slope_text};

/// Minimum share of the picture that all frames should show at the typical slope of the evidence.
const COVERED: f32 = 0.7;
/// Tolerated deviation from a uniform motion, pixels: about the blur that smears the finest features.
const STRAIGHT_PX: f32 = 1.4;

impl Telling<'_> {
    pub(super) fn frames(&self) -> Option<SlopeAdvice> {
        let finding = &self.spectrum.finding;
        let frames = self.spectrum.frames;
        let left = match finding.verdict {
            SlopeVerdict::NotStraight => {
                // The deviation of a bent motion grows with the square of the time.
                let off = finding.deviation_px.filter(|off| *off > STRAIGHT_PX)?;
                (frames as f32 * (STRAIGHT_PX / off).sqrt()) as usize
            }
            SlopeVerdict::Film => {
                let (width, height) = self.cache.burst.size();
                let part = finding.moved_px / width.min(height) as f32;
                (frames as f32 * 0.25 / part.max(0.25)) as usize
            }
            _ => return None,
        };
        let left = left.clamp(2, frames);
        let fewer = frames - left;
        let why = match finding.verdict {
            SlopeVerdict::Film => format!(
                "the picture moves by {} px over the frames, more than a third of it",
                number(finding.moved_px, 0)
            ),
            _ => format!(
                "the motion is not straight: it deviates from a uniform one by up to {} px",
                number(finding.deviation_px.unwrap_or(0.0), 1)
            ),
        };
        (fewer > 0).then(|| SlopeAdvice {
            subject: Subject::Frames,
            number: fewer as f64,
            sentence: format!("{why}; {fewer} of the {frames} frames add nothing but blur"),
            changes: vec![self.middle_frames(left)],
        })
    }

    /// The change that uses only the middle `count` frames.
    fn middle_frames(&self, count: usize) -> ParamChange {
        let used = self.cache.detection().frames_used.clone();
        let start = used.start + (used.len() - count.min(used.len())) / 2;
        ParamChange::new(doc::FRAMES, FrameRange { start, end: start + count.min(used.len()) })
    }

    pub(super) fn coverage(&self) -> Option<SlopeAdvice> {
        let size = self.cache.burst.size();
        let frames = self.spectrum.frames;
        // The typical slope: half of the evidence moves faster.
        let mut slopes: Vec<(Slope, f32)> = self.evidence().iter().map(|e| (e.slope, e.significance)).collect();
        slopes.sort_by(|a, b| a.0.magnitude().total_cmp(&b.0.magnitude()));
        let half = 0.5 * slopes.iter().map(|s| s.1).sum::<f32>();
        let mut sum = 0.0;
        let (typical, _) = *slopes.iter().find(|(_, significance)| {
            sum += significance;
            sum >= half
        })?;
        let share = coverage_share(typical, frames, size);
        if share >= COVERED || self.spectrum.finding.verdict == SlopeVerdict::Film {
            return None;
        }
        let enough = (2..frames).rev().find(|&count| coverage_share(typical, count, size) >= COVERED).unwrap_or(2);
        let sentence = format!(
            "at the typical slope {} px/frame all {frames} frames show only {:.0} % of the picture; the middle {enough} show {:.0} %",
            slope_text(typical),
            100.0 * share,
            100.0 * coverage_share(typical, enough, size)
        );
        Some(SlopeAdvice {
            subject: Subject::Coverage,
            number: f64::from(share),
            sentence,
            changes: vec![self.middle_frames(enough)],
        })
    }
}
