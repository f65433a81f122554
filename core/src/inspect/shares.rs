//! Values of single frames along the motion of a feature: the response of each with its noise (its share), and slices.
//!
//! A true feature is in every frame: the responses are level. A ghost — a blob of another motion that shows in the
//! stack of a wrong slope — responds only in the frames in which the true blob crosses its path, so its responses form
//! a bump. Whether two keypoints at one place are different is decided by the search itself, from the frames in which
//! their paths are apart (`two_motions`); the number here is only for information.
//!
//! A slice is taken along a line of pixels and has one row for each frame (the epipolar-plane image, *Reslice* in
//! ImageJ). Content that moves along the line is slanted in it.

use crate::detector::coherence::{Evenness, FrameResponse, Shape, evenness_of, responding};
use crate::detector::{Slope, Trail};
use crate::monitor::{Cancelled, Monitor};
use crate::plane::Plane;
use crate::plane::sample::{bilinear, sample_patch};
use serde::Serialize;
use std::sync::Arc;

/// Response of one frame along a feature's motion.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FrameShare {
    /// Index of the frame in the burst.
    pub frame: usize,
    /// Position of the feature in the frame, input pixels.
    pub pos_frame: [f32; 2],
    /// Whether the frame shows the place and was used.
    pub covers: bool,
    /// D of this frame alone, fraction of full scale.
    pub value: f32,
    /// Noise of that D.
    pub sigma_d: f32,
    /// Pixels around the position; NaN beyond the frame.
    #[serde(skip)]
    pub patch: Plane,
}

/// Shares of all frames.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Shares {
    /// Octave of the responses.
    pub octave: i32,
    /// DoG level.
    pub level: i32,
    /// (u, v) at mid-burst, input pixels.
    pub pos_image: [f32; 2],
    /// Slope of the motion, px/frame.
    pub slope: Slope,
    /// Scale σ, input pixels.
    pub sigma: f32,
    /// Shares of the frames, in time order.
    pub frames: Vec<FrameShare>,
    /// Evenness of the responses. Their mean is D of the stack.
    #[serde(flatten)]
    pub evenness: Evenness,
    /// Interpretation as a sentence.
    pub meaning: String,
    /// Side of a patch, input pixels.
    pub patch_px: f32,
}

const PATCH_SIDE: usize = 33;
const PATCH_SIGMAS: f32 = 4.0;
/// Shares of all frames along the motion through `place` (input pixels, at mid-burst) at `slope`.
pub fn shares(
    trail: &Trail,
    (octave, level): (i32, i32),
    place: [f32; 2],
    slope: Slope,
    monitor: &Monitor,
) -> Result<Shares, Cancelled> {
    let (planes, ..) = trail.frames();
    let sigma = trail.space().sigma_image(octave, f64::from(level)) as f32;
    let half_px = PATCH_SIGMAS * sigma;
    let answers = trail.frame_responses((octave, level), place, slope, monitor)?;
    let share = |(plane, &answer): (&Arc<Plane>, &FrameResponse)| {
        let FrameResponse { frame, pos_frame, covers, value, sigma_d } = answer;
        let patch = sample_patch(plane, (pos_frame[0], pos_frame[1]), half_px, 0.0, PATCH_SIDE);
        FrameShare { frame, pos_frame, covers, value, sigma_d, patch }
    };
    let frames: Vec<FrameShare> = planes.iter().zip(&answers).map(share).collect();
    monitor.check()?;
    let evenness = evenness_of(&answers);
    let meaning = meaning(&frames, &evenness);
    let patch_px = 2.0 * half_px;
    Ok(Shares { octave, level, pos_image: place, slope, sigma, frames, evenness, meaning, patch_px })
}

fn meaning(frames: &[FrameShare], evenness: &Evenness) -> String {
    let number = evenness.coherence.map_or_else(String::new, |c| format!("coherence {c:.2}: "));
    let covering: Vec<&FrameShare> = frames.iter().filter(|f| f.covers).collect();
    match evenness.shape {
        Shape::Level => format!("{number}all frames respond alike, as for an object with this motion"),
        Shape::Uneven => format!("{number}the frames differ by more than their noise, but no part of them stands out"),
        Shape::Bump => {
            let answers: Vec<(f32, f32)> = covering.iter().map(|f| (f.value, f.sigma_d)).collect();
            let on = covering.iter().zip(responding(&answers)).filter(|(_, responds)| *responds);
            let on: Vec<usize> = on.map(|(frame, _)| frame.frame).collect();
            let (first, last) = (on.first().copied().unwrap_or(0), on.last().copied().unwrap_or(0));
            let which = if first == last {
                format!("frame {first} responds")
            } else {
                format!("frames {first} to {last} respond")
            };
            format!("{number}only {which}, as for a ghost: an object with another motion crosses here")
        }
        Shape::Unclear if covering.len() < 3 => "too few frames show the place to compare them".to_owned(),
        Shape::Unclear => "a single frame is too noisy here to compare the frames".to_owned(),
    }
}

/// A slice: columns are pixels along a direction, rows are frames in time order.
#[derive(Debug, Clone, PartialEq)]
pub struct Slice {
    /// Values, fraction of full scale; NaN beyond a frame.
    pub plane: Plane,
    /// Column that goes through the place.
    pub centre_column: usize,
    /// Place, input pixels.
    pub pos_image: [f32; 2],
    /// Direction along u and v, of length 1; from one column to the next it is one pixel.
    pub direction: [f32; 2],
    /// Index in the burst of each row's frame.
    pub frames: Vec<usize>,
    /// Time of each row's frame minus mid-burst, frames.
    pub times: Vec<f32>,
}

impl Slice {
    /// The column, in a row, of content that moves at `slope` through the place; its motion along the line counts.
    pub fn column_at(&self, slope: Slope, row: usize) -> f32 {
        let along = slope.u * self.direction[0] + slope.v * self.direction[1];
        self.centre_column as f32 + along * self.times[row]
    }
}

/// Cuts the slice through `place` (input pixels) along `direction` (u, v), `half_px` pixels to each side.
pub fn slice(trail: &Trail, place: [f32; 2], direction: [f32; 2], half_px: usize) -> Slice {
    let length = direction[0].hypot(direction[1]);
    let direction = if length > 0.0 { direction.map(|x| x / length) } else { [1.0, 0.0] };
    let (planes, kept, frame_count) = trail.frames();
    let t0 = 0.5 * (frame_count as f32 - 1.0);
    let at = |column: usize, row: usize| {
        let along = column as f32 - half_px as f32;
        let (u, v) = (place[0] + along * direction[0], place[1] + along * direction[1]);
        bilinear(&planes[row], u, v).unwrap_or(f32::NAN)
    };
    Slice {
        plane: Plane::from_fn(2 * half_px + 1, planes.len(), at),
        centre_column: half_px,
        pos_image: place,
        direction,
        frames: kept.iter().map(|t| t + trail.detection().frames_used.start).collect(),
        times: kept.iter().map(|&t| t as f32 - t0).collect(),
    }
}

/// The direction of a slope; to the right for slope 0.
pub fn direction_of(slope: Slope) -> [f32; 2] {
    let length = slope.magnitude();
    if length > 0.0 { [slope.u / length, slope.v / length] } else { [1.0, 0.0] }
}

/// The direction perpendicular to `direction`, a quarter turn from +u towards +v.
pub fn across([u, v]: [f32; 2]) -> [f32; 2] {
    [-v, u]
}
