//! Cutting of a long sequence of frames into bursts: a robot that records all the way has no folders of bursts, but
//! every N frames of its recording are one.
//!
//! The cut is between files, and no pixel is read: each burst lists its own frames and is opened alone.

use super::decode;
use super::error::OpenError;
use super::source::{BurstFiles, is_stack, make_names_unique, stem};
use std::ops::Range;
use std::path::PathBuf;

/// Lengths of a cut: the frames of a burst, and the distance between the starts of bursts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SequenceCut {
    length: usize,
    step: usize,
}

impl SequenceCut {
    /// Bursts of `length` frames; each begins `step` frames after the one before. Without a step they follow one
    /// another: each frame is in one burst. With a step below `length` they overlap, with one above it frames between
    /// them are left out.
    ///
    /// # Errors
    /// [`OpenError::Cut`] if either is 0.
    pub fn new(length: usize, step: Option<usize>) -> Result<Self, OpenError> {
        let step = step.unwrap_or(length);
        if length == 0 || step == 0 {
            return Err(OpenError::Cut { length, step });
        }
        Ok(Self { length, step })
    }

    /// Frames of a burst, at least 1.
    pub fn length(self) -> usize {
        self.length
    }

    /// Frames from the start of a burst to the start of the next, at least 1.
    pub fn step(self) -> usize {
        self.step
    }

    /// The frames of each burst in a sequence of `frames` frames, in order. Frames at the end that do not fill a burst
    /// are left out.
    pub fn ranges(self, frames: usize) -> impl ExactSizeIterator<Item = Range<usize>> {
        let count = if frames < self.length { 0 } else { (frames - self.length) / self.step + 1 };
        (0..count).map(move |k| k * self.step..k * self.step + self.length)
    }
}

/// Cuts the sequence `sequence` (a folder of frames, or the frames themselves) into bursts, in time order.
///
/// A burst is named after its middle frame (of N frames the one with index N/2, which SIFT on one frame also uses), so
/// that its features can be compared with data on that frame, such as the camera's pose. For bursts of several
/// sequences, [`name_among_several`] makes the names differ.
///
/// # Errors
/// A folder cannot be read; a sequence is shorter than one burst; a file is a stack.
pub fn cut_sequence(sequence: &BurstFiles, cut: SequenceCut) -> Result<Vec<BurstFiles>, OpenError> {
    let frames = sequence.files()?;
    if let Some(path) = frames.iter().find(|f| is_stack(f)) {
        return Err(OpenError::CutStack { path: path.clone(), frames: decode::frame_count(path).unwrap_or(2) });
    }
    let ranges = cut.ranges(frames.len());
    if ranges.len() == 0 {
        let path = sequence.paths.first().cloned().unwrap_or_default();
        return Err(OpenError::TooShort { path, frames: frames.len(), length: cut.length });
    }
    let mut bursts: Vec<BurstFiles> = ranges.map(|range| burst_of(&frames[range])).collect();
    make_names_unique(&mut bursts);
    Ok(bursts)
}

/// Name of a burst of one of several sequences.
pub fn name_among_several(sequence: &str, burst: &str) -> String {
    format!("{sequence}_{burst}")
}

fn burst_of(frames: &[PathBuf]) -> BurstFiles {
    BurstFiles { name: stem(&frames[frames.len() / 2]), paths: frames.to_vec() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn cut(length: usize, step: Option<usize>) -> SequenceCut {
        SequenceCut::new(length, step).expect("it can be cut like this")
    }

    #[test]
    fn bursts_follow_one_another_overlap_or_leave_gaps() {
        let ranges = |cut: SequenceCut, frames| cut.ranges(frames).collect::<Vec<_>>();
        assert_eq!(ranges(cut(3, None), 10), [0..3, 3..6, 6..9]);
        assert_eq!(ranges(cut(3, Some(2)), 7), [0..3, 2..5, 4..7]);
        assert_eq!(ranges(cut(2, Some(5)), 10), [0..2, 5..7]);
        assert!(ranges(cut(4, None), 3).is_empty());
        assert!(matches!(SequenceCut::new(0, None), Err(OpenError::Cut { .. })));
        assert!(matches!(SequenceCut::new(3, Some(0)), Err(OpenError::Cut { .. })));
    }

    #[test]
    fn bursts_are_named_after_their_middle_frames() {
        let frame = |t: usize| PathBuf::from(format!("film/f_{t:02}.png"));
        let film = BurstFiles { name: "film".into(), paths: (0..9).map(frame).collect() };
        let bursts = cut_sequence(&film, cut(4, None)).expect("two bursts");
        let names: Vec<&str> = bursts.iter().map(|b| b.name.as_str()).collect();
        assert_eq!(names, ["f_02", "f_06"]);
        assert_eq!(bursts[1].paths, (4..8).map(frame).collect::<Vec<_>>());
        let error = cut_sequence(&film, cut(10, None)).expect_err("too short").to_string();
        assert!(error.contains("9 frames") && error.contains("10"), "{error}");
    }

    proptest! {
        #[test]
        fn every_burst_is_whole_and_the_last_one_is_the_last_that_fits(frames in 0usize..200, length in 1usize..20, step in 1usize..20) {
            let ranges: Vec<_> = cut(length, Some(step)).ranges(frames).collect();
            prop_assert!(ranges.iter().enumerate().all(|(k, r)| r.start == k * step && r.len() == length && r.end <= frames));
            let next = ranges.len() * step + length;
            prop_assert!(next > frames);
        }
    }
}
