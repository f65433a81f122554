//! Slices through a burst along a line of pixels: one row for each frame (the epipolar-plane image, ImageJ's
//! *Reslice*). Content that moves along the line is slanted in it.

use crate::detector::{Slope, Trail};
use crate::plane::Plane;
use crate::plane::sample::bilinear;

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
    /// The column in row `row` of content that moves at `slope` through the place at mid-burst; only the motion along
    /// this line counts.
    pub fn column_at(&self, slope: Slope, row: usize) -> f32 {
        let along = slope.u * self.direction[0] + slope.v * self.direction[1];
        self.centre_column as f32 + along * self.times[row]
    }
}

/// Cuts the slice through `place` (input pixels) along `direction` (u, v; of any length but 0), `half_px` pixels to
/// each side.
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
