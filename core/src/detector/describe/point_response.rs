//! D at single places: the frames are shifted by any slope and averaged in a small patch, and the patch is weighted by
//! two Gaussians.
//!
//! Stacking and filtering commute, so the values are those of a search at that slope, up to interpolation (and, in
//! coarser octaves, the way in which the frames are brought to their resolution). Used to test whether two motions
//! share one place, and for D between the slopes of the grid and in a single frame.

use crate::detector::describe::patch::around;
use crate::detector::params::Interpolation;
use crate::detector::params::slope_grid::Slope;
use crate::detector::scale_space::levels::{ScaleSpace, octave_pixel, octave_size};
use crate::detector::scale_space::octave::Base;
use crate::detector::stack::refined::OctaveFrames;
use crate::kernel::patch::{Patch, PatchScratch};
use crate::kernel::stack::FrameOffset;
use crate::plane::Plane;
use crate::plane::blur::GaussianKernel;
use std::ops::Range;

/// D of the mean of the `chosen` frames at each of the DoG `levels` of `octave`, on the path through `place` (input
/// pixels, at mid-burst) at `slope`. The octave's pixel nearest to the place is taken.
pub(in crate::detector) fn point_response(
    frames: &OctaveFrames<'_>,
    (space, octave, levels): (&ScaleSpace, i32, Range<i32>),
    size_image: (usize, usize),
    (place, slope): ((f32, f32), Slope),
    interpolation: Interpolation,
    chosen: &[usize],
) -> Vec<f32> {
    let (planes, offsets) = (frames.planes(), frames.offsets(slope, interpolation));
    let planes: Vec<&Plane> = chosen.iter().map(|&index| planes[index]).collect();
    let offsets: Vec<FrameOffset> = chosen.iter().map(|&index| offsets[index]).collect();
    let from = frames.sigma_octave(&offsets);
    let kernel = |s: i32| {
        let sigma = space.sigma_octave(f64::from(s));
        GaussianKernel::new((sigma * sigma - from * from).max(0.0).sqrt())
    };
    let kernels: Vec<GaussianKernel> = (levels.start..levels.end + 1).map(kernel).collect();
    let size = octave_size(size_image, octave);
    let pixel = octave_pixel(octave);
    let inside = |x: f32, n: usize| (x / pixel).clamp(0.0, n as f32 - 1.0);
    let (x, y) = (inside(place.0, size.0), inside(place.1, size.1));
    let reach = kernels.last().map_or(0, GaussianKernel::radius);
    let base: Base<'_> = frames.base(&planes, &offsets);
    let (mut scratch, mut patch) = (PatchScratch::default(), Patch::default());
    base.patch(size, around(x, reach), around(y, reach), &mut scratch, &mut patch);
    let weighted: Vec<f32> = kernels.iter().map(|kernel| weighted(&patch, kernel, reach)).collect();
    weighted.windows(2).map(|two| two[1] - two[0]).collect()
}

/// Value of `kernel` applied at the middle of `patch`, which reaches `reach` pixels from it.
fn weighted(patch: &Patch, kernel: &GaussianKernel, reach: usize) -> f32 {
    let radius = kernel.radius();
    let half = kernel.half();
    let taps: Vec<f32> = half[1..].iter().rev().chain(half).copied().collect();
    let within = reach - radius..reach + radius + 1;
    let row = |v: i64| -> f32 { patch.row(v)[within.clone()].iter().zip(&taps).map(|(x, w)| x * w).sum() };
    let first = patch.rows().start + (reach - radius) as i64;
    taps.iter().zip(first..).map(|(w, v)| w * row(v)).sum()
}
