//! Validation of parameters, alone and for a burst; each error gives a remedy.

use super::{DetectorParams, MAX_SLOPES, MIN_OCTAVE_SIDE, Method, Param, SearchParams, doc};
use crate::burst::Positions;
use crate::error::{Error, Result};

impl SearchParams {
    /// Checks the parameters alone, without a burst.
    ///
    /// # Errors
    /// The first parameter that makes no sense.
    pub fn validate(&self) -> Result<()> {
        doc::ALL.iter().try_for_each(|record| record.check(self))?;
        let count = self.slopes.given().map_or(0, |grid| grid.len());
        if count > MAX_SLOPES {
            return Err(Error::param(
                doc::SLOPES_V.name,
                format!("the grid has {count} slopes"),
                "at most 4096 slopes are searched; use coarser steps",
            ));
        }
        Ok(())
    }
}

impl DetectorParams {
    /// Checks the parameters alone, as [`SearchParams::validate`] does.
    ///
    /// # Errors
    /// The first parameter that makes no sense.
    pub fn validate(&self) -> Result<()> {
        SearchParams::from(self.clone()).validate()
    }

    /// Checks the range of frames against a burst of `frame_count` frames.
    ///
    /// # Errors
    /// [`doc::FRAMES`] if the range reaches past the burst.
    pub fn validate_frames(&self, frame_count: usize) -> Result<()> {
        match self.frames.filter(|range| range.end > frame_count) {
            None => Ok(()),
            Some(range) => Err(Error::param(
                doc::FRAMES.name,
                format!("{range} reaches past the burst's {frame_count} frames"),
                format!("give A..B with B at most {frame_count}"),
            )),
        }
    }

    /// Checks the parameters against a burst with frames at `positions` of `size` = (columns, rows).
    ///
    /// # Errors
    /// The first parameter that makes no sense for it.
    pub fn validate_for(&self, positions: &Positions, size: (usize, usize)) -> Result<()> {
        self.validate()?;
        self.validate_frames(positions.len())?;
        let used = positions.part(self.used_frames(positions.len()));
        let fail = |parameter: Param<SearchParams>, problem: String, remedy: String| {
            Err(Error::param(parameter.name, problem, remedy))
        };
        let shift = self.first_octave;
        let side = |pixels: usize| if shift < 0 { pixels * 2 } else { pixels >> shift };
        if side(size.0.min(size.1)) < MIN_OCTAVE_SIDE {
            return fail(
                doc::FIRST_OCTAVE,
                format!(
                    "octave {shift} of a {}×{} image is under {MIN_OCTAVE_SIDE} pixels wide or high",
                    size.0, size.1
                ),
                "start at a finer octave, or use a larger image".into(),
            );
        }
        if self.method == Method::Buff && used.len() == 1 && self.slopes.len() > 1 {
            return fail(
                doc::FRAMES,
                "a single frame shows no motion, so its slopes are all the same".into(),
                "use 2 frames or more, or the method sift".into(),
            );
        }
        // Slopes that move every point out of the image by the burst's end have nothing to stack.
        let span = used.reach() as f32 * self.slopes.max_magnitude();
        if self.method == Method::Buff && span >= (size.0 as f32).hypot(size.1 as f32) {
            return fail(
                doc::SLOPES_U,
                format!(
                    "the largest slope moves a point {span:.0} px from mid-burst to its end, out of the {}×{} image",
                    size.0, size.1
                ),
                "give smaller slopes or fewer frames".into(),
            );
        }
        Ok(())
    }
}
