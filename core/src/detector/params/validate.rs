//! Validation of parameters, alone and for a burst; each error gives a remedy.

use super::{DetectorParams, Distinct, MIN_OCTAVE_SIDE, Method, NoiseGate, ParamDoc, doc};

/// A parameter, or a combination of parameters, that makes no sense: the reason and a remedy.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{parameter}: {problem}; {remedy}")]
pub struct ParamError {
    /// [`ParamDoc::name`] of the parameter to change.
    pub parameter: &'static str,
    /// The fault.
    pub problem: String,
    /// A remedy.
    pub remedy: String,
}

/// Largest radius of distinct keypoints, in σ.
pub const MAX_DISTINCT_RADIUS: f32 = 10.0;
/// Largest ratio of scales of distinct keypoints.
pub const MAX_DISTINCT_SCALE: f32 = 8.0;
/// Maximum number of slopes of a grid.
pub const MAX_SLOPES: usize = 4096;

impl DetectorParams {
    /// Checks the parameters alone, without a burst.
    ///
    /// # Errors
    /// The first parameter that makes no sense.
    pub fn validate(&self) -> Result<(), ParamError> {
        let fail = |parameter: ParamDoc, problem: String, remedy: &str| {
            Err(ParamError { parameter: parameter.name, problem, remedy: remedy.to_owned() })
        };
        for (axis, parameter) in [(&self.slopes.u, doc::SLOPES_U), (&self.slopes.v, doc::SLOPES_V)] {
            if !(axis.min.is_finite() && axis.max.is_finite()) {
                return fail(parameter, "the range is not finite".into(), "give two numbers of pixels per frame");
            }
            if axis.count == 0 {
                return fail(parameter, "the count is 0".into(), "give at least 1 slope");
            }
            if axis.min > axis.max {
                return fail(parameter, format!("{} is above {}", axis.min, axis.max), "give the smaller slope first");
            }
            if axis.count > 1 && axis.min == axis.max {
                return fail(
                    parameter,
                    format!("{} slopes on an empty range", axis.count),
                    "widen the range, or ask for 1 slope",
                );
            }
            if axis.count > MAX_SLOPES {
                return fail(
                    parameter,
                    format!("{} slopes", axis.count),
                    "at most 4096 slopes are searched; use a coarser step",
                );
            }
        }
        if self.slopes.len() > MAX_SLOPES {
            return fail(
                doc::SLOPES_V,
                format!("the grid has {} slopes", self.slopes.len()),
                "at most 4096 slopes are searched; use coarser steps",
            );
        }
        if !self.slopes.direction_deg.is_finite() {
            return fail(doc::SLOPE_DIRECTION, "it is not finite".into(), "give degrees");
        }
        if let Some(range) = self.frames
            && range.start >= range.end
        {
            return fail(doc::FRAMES, format!("{range} holds no frame"), "give A..B with A below B");
        }
        if !(1..=16).contains(&self.octaves) {
            return fail(doc::OCTAVES, format!("{} octaves", self.octaves), "give 1 to 16");
        }
        if !(1..=10).contains(&self.levels) {
            return fail(doc::LEVELS, format!("{} levels", self.levels), "give 1 to 10");
        }
        if !(-1..=8).contains(&self.first_octave) {
            return fail(doc::FIRST_OCTAVE, format!("{}", self.first_octave), "give -1 to 8");
        }
        if !(self.peak_threshold.is_finite() && self.peak_threshold >= 0.0) {
            return fail(
                doc::PEAK_THRESHOLD,
                format!("{}", self.peak_threshold),
                "give 0 or more, as a fraction of full scale",
            );
        }
        if let NoiseGate::Factor(k) = self.noise_gate
            && !(k.is_finite() && k >= 0.0)
        {
            return fail(doc::NOISE_GATE, format!("{k}"), "give auto, strict, or 0 or more standard deviations");
        }
        if !(self.edge_threshold.is_finite() && self.edge_threshold >= 1.0) {
            return fail(doc::EDGE_THRESHOLD, format!("{}", self.edge_threshold), "give 1 or more (10 is usual)");
        }
        if let Distinct::Radius(radius) = self.distinct
            && !(radius.is_finite() && 0.0 < radius && radius <= MAX_DISTINCT_RADIUS)
        {
            return fail(doc::DISTINCT, format!("{radius}"), "give off, or a radius above 0 and up to 10 σ");
        }
        if !(self.distinct_scale.is_finite() && 1.0 < self.distinct_scale && self.distinct_scale <= MAX_DISTINCT_SCALE)
        {
            return fail(doc::DISTINCT_SCALE, format!("{}", self.distinct_scale), "give more than 1 and up to 8");
        }
        if !(self.kernel_cut.is_finite() && (1.0..=8.0).contains(&self.kernel_cut)) {
            return fail(
                doc::KERNEL_CUT,
                format!("{}", self.kernel_cut),
                "give 1 to 8 standard deviations (4 is usual)",
            );
        }
        if !(1..=4).contains(&self.max_orientations) {
            return fail(doc::MAX_ORIENTATIONS, format!("{}", self.max_orientations), "give 1 to 4");
        }
        Ok(())
    }

    /// Checks the range of frames against a burst of `frame_count` frames.
    ///
    /// # Errors
    /// [`doc::FRAMES`] if the range reaches past the burst.
    pub fn validate_frames(&self, frame_count: usize) -> Result<(), ParamError> {
        match self.frames.filter(|range| range.end > frame_count) {
            None => Ok(()),
            Some(range) => Err(ParamError {
                parameter: doc::FRAMES.name,
                problem: format!("{range} reaches past the burst's {frame_count} frames"),
                remedy: format!("give A..B with B at most {frame_count}"),
            }),
        }
    }

    /// Checks the parameters against a burst of `frame_count` frames of `size` = (columns, rows).
    ///
    /// # Errors
    /// The first parameter that makes no sense for it.
    pub fn validate_for(&self, frame_count: usize, size: (usize, usize)) -> Result<(), ParamError> {
        self.validate()?;
        self.validate_frames(frame_count)?;
        let fail = |parameter: ParamDoc, problem: String, remedy: String| {
            Err(ParamError { parameter: parameter.name, problem, remedy })
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
        if self.method == Method::Buff && self.used_frames(frame_count).len() == 1 && self.slopes.len() > 1 {
            return fail(
                doc::FRAMES,
                "a single frame shows no motion, so its slopes are all the same".into(),
                "use 2 frames or more, or the method sift".into(),
            );
        }
        let span = (self.used_frames(frame_count).len() - 1) as f32 * 0.5 * self.slopes.max_magnitude();
        let diagonal = (size.0 as f32).hypot(size.1 as f32);
        if self.method == Method::Buff && span >= diagonal {
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
