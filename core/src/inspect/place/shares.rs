//! Values of single frames along the motion of a feature: the response of each with its noise (its share), and slices.
//!
//! A true feature is in every frame: the responses are level. A ghost, a blob of another motion, responds only in the
//! frames in which the true blob crosses its path, so its responses form a bump. A slice is taken along a line of
//! pixels and has one row for each frame (the epipolar-plane image, *Reslice* in ImageJ).

use crate::detector::coherence::{Evenness, FrameResponse, Shape, evenness_of, responding};
use crate::detector::{Scale, Slope, SlopeGrid, Trail};
use crate::monitor::{Cancelled, Monitor};
use crate::plane::sample::{bilinear, sample_patch};
use crate::{burst::Offset, plane::Plane};
use serde::Serialize;
use std::sync::Arc;

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
    /// Responses of the frames, in time order.
    pub frames: Vec<FrameResponse>,
    /// Pixels around the position in each frame; NaN beyond the frame.
    #[serde(skip)]
    pub patches: Vec<Plane>,
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
    scale: Scale,
    place: [f32; 2],
    slope: Slope,
    monitor: &Monitor,
) -> Result<Shares, Cancelled> {
    let ((planes, ..), Scale { octave, level }) = (trail.frames(), scale);
    let sigma = trail.space().sigma_image(octave, f64::from(level)) as f32;
    let half_px = PATCH_SIGMAS * sigma;
    let frames = trail.along().each_frame(scale, place, slope, monitor)?;
    let patch = |(plane, response): (&Arc<Plane>, &FrameResponse)| {
        sample_patch(plane, response.pos_frame.into(), half_px, 0.0, PATCH_SIDE)
    };
    let patches = planes.iter().zip(&frames).map(patch).collect();
    monitor.check()?;
    let evenness = evenness_of(&frames);
    let meaning = meaning(&frames, &evenness);
    let patch_px = 2.0 * half_px;
    Ok(Shares { octave, level, pos_image: place, slope, sigma, frames, patches, evenness, meaning, patch_px })
}

fn meaning(frames: &[FrameResponse], evenness: &Evenness) -> String {
    let number = evenness.coherence.map_or_else(String::new, |c| format!("coherence {c:.2}: "));
    let covering: Vec<&FrameResponse> = frames.iter().filter(|f| f.covers).collect();
    match evenness.shape {
        Shape::Level => format!("{number}all frames respond alike, as for an object with this motion"),
        Shape::Uneven => format!("{number}the frames differ by more than their noise, but no part of them stands out"),
        Shape::Bump => {
            let answers: Vec<(f32, f32)> = covering.iter().map(|f| (f.value, f.sigma_d)).collect();
            let on = covering.iter().zip(responding(&answers)).filter(|(_, responds)| *responds);
            let on: Vec<usize> = on.map(|(frame, _)| frame.frame).collect();
            let (first, last) = (on.first().copied().unwrap_or(0), on.last().copied().unwrap_or(0));
            let several = format!("frames {first} to {last} respond");
            let which = if first == last { format!("frame {first} responds") } else { several };
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
    /// Time of each row's frame minus mid-burst, frames; of a view, its distance from the mean view along the slice.
    pub times: Vec<f32>,
    /// Whether the rows are views of a light field.
    pub are_views: bool,
}

impl Slice {
    /// The column, in a row, of content that moves at `slope` through the place; its motion along the line counts.
    pub fn column_at(&self, slope: Slope, row: usize) -> f32 {
        self.centre_column as f32 + self.along(slope) * self.times[row]
    }

    /// Motion along the slice of what has a slope, pixels per frame: of views the disparity, in every direction.
    pub fn along(&self, slope: Slope) -> f32 {
        if self.are_views { slope.u } else { slope.u * self.direction[0] + slope.v * self.direction[1] }
    }

    /// The slope like `slope` that moves by `along` along the slice, pixels per frame.
    pub fn with_along(&self, slope: Slope, along: f32) -> Slope {
        let more = along - self.along(slope);
        let [u, v] = if self.are_views { [1.0, 0.0] } else { self.direction };
        Slope::new(slope.u + more * u, slope.v + more * v)
    }
}

/// Cuts the slice through `place` (input pixels) along `direction` (u, v), `half_px` pixels to each side. Of a light
/// field it has the views on the line in that direction through the mean view: an epipolar-plane image, in which what
/// has a disparity is a straight line.
pub fn slice(trail: &Trail, place: [f32; 2], direction: [f32; 2], half_px: usize) -> Slice {
    let direction = direction_of(Slope::new(direction[0], direction[1]));
    let (all, kept, positions) = trail.frames();
    let are_views = positions.are_views();
    // Components of a view's place along and across the line.
    let place_of = |t: usize| {
        let Offset { u, v } = positions.offset(t).to_f32();
        (u * direction[0] + v * direction[1], v * direction[0] - u * direction[1])
    };
    // Of an even number of rows, the one before the middle.
    let is_on_line = |t: usize| !are_views || (-0.501..0.499).contains(&place_of(t).1);
    let (rows, kept): (Vec<usize>, Vec<usize>) =
        kept.iter().copied().enumerate().filter(|(_, t)| is_on_line(*t)).unzip();
    let planes: Vec<&Plane> = rows.iter().map(|&index| &*all[index]).collect();
    let at = |column: usize, row: usize| {
        let along = column as f32 - half_px as f32;
        let (u, v) = (place[0] + along * direction[0], place[1] + along * direction[1]);
        bilinear(planes[row], u, v).unwrap_or(f32::NAN)
    };
    let plane = Plane::from_fn(2 * half_px + 1, planes.len(), at);
    let frames = kept.iter().map(|t| t + trail.detection().frames_used.start).collect();
    let times = kept.iter().map(|&t| if are_views { place_of(t).0 } else { positions.offset(t).u as f32 }).collect();
    Slice { plane, centre_column: half_px, pos_image: place, direction, frames, times, are_views }
}

/// The direction of a slope; to the right for slope 0.
pub fn direction_of(slope: Slope) -> [f32; 2] {
    let length = slope.magnitude();
    if length > 0.0 { [slope.u / length, slope.v / length] } else { [1.0, 0.0] }
}

/// The directions, of length 1, of the axes of `grid` that have several slopes.
pub(super) fn directions(grid: &SlopeGrid) -> impl Iterator<Item = [f32; 2]> {
    let origin = grid.at(0.0, 0.0);
    let axes = [(grid.u.count, grid.at(1.0, 0.0)), (grid.v.count, grid.at(0.0, 1.0))];
    let towards = move |to: Slope| direction_of(Slope::new(to.u - origin.u, to.v - origin.v));
    axes.into_iter().filter(|(count, _)| *count > 1).map(move |(_, to)| towards(to))
}

/// The direction perpendicular to `direction`, a quarter turn from +u towards +v.
pub fn across([u, v]: [f32; 2]) -> [f32; 2] {
    [-v, u]
}
