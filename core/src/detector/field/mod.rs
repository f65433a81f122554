//! Field of motion: how each place of a burst moves, and how surely that is known.
//!
//! The slope of a single feature is where noise helps it most, and along an edge it is undefined. The motion of a
//! *place* is known much better, since its surroundings mostly move alike. A sweep (`evidence`) of the plane of slopes
//! on reduced, band-passed frames gives, for each cell and slope, how much more likely the frames are if the cell moves
//! so, in nats. All evidence together gives how likely each motion is at each cell (`posterior`): its mean around the
//! likeliest one is the motion, its variance the uncertainty. Things of a few cells are found by the window around each
//! (`windows`). The burst's motions become [layers](MotionLayer); [`in_focus`] stacks by place.
//!
//! (The paper has no such step: its features carry the slope at which they were found.)

mod beyond;
pub(crate) mod depth;
mod evidence;
mod in_focus;
mod layers;
mod posterior;
mod windows;

use crate::detector::params::slope_grid::{Slope, SlopeGrid};
use crate::detector::stack::FrameTimes;
use crate::monitor::{Cancelled, Monitor};
use crate::plane::Plane;
use crate::plane::blur::smoothed;
pub(crate) use beyond::{Beyond, FIELD_BEYOND, field_over};
use evidence::{Evidence, MERGED_CELLS, swept};
pub use in_focus::in_focus;
use layers::KnownCell;
pub use layers::MotionLayer;
use posterior::{MotionEstimate, Posterior};
use serde::Serialize;
use windows::{overrule, refine};

/// Reason why [`motion_field`] found no field, and the remedy.
pub const NO_FIELD: &str =
    "there is no field of motion: it needs at least 3 frames of 32 × 32 pixels and a range of slopes";

/// Number of cells times slopes above which cells are larger: they take 80 MB.
const MAX_VALUES: usize = 20_000_000;
/// Pixels on a side of the smallest cells.
const CELL_PX: usize = 8;
/// Side of a cell in images of at most [`SMALL_IMAGE_PX`], pixels: their things are small.
const SMALL_CELL_PX: usize = 6;
/// Pixels of the largest image that counts as small.
const SMALL_IMAGE_PX: usize = 360_000;
/// Parts of two variances that count as errors in real pictures: of the probabilities, since a tree does not count all
/// that neighbouring cells know, and of the change to the next cell, since a border may lie a cell off.
const VARIANCE_PARTS: [f32; 2] = [0.15, 0.75];
/// Standard deviation of the window in which changes of the motion are looked at, cells.
const CHANGE_WINDOW_CELLS: f64 = 1.0;
/// Standard deviations by which two motions differ significantly.
const OTHER_SIGMAS: f32 = 3.0;
/// Uncertainty of a motion in its least certain direction from which it is unknown, pixels of smear over the burst.
const UNKNOWN_SMEAR_PX: f32 = 6.0;
/// Uncertainty of any motion, pixels of smear: structure that moves otherwise within a cell.
const LEAST_SMEAR_PX: f32 = 0.3;

/// Motion of a place with its uncertainty.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Motion {
    /// Apparent motion of the place, pixels per frame.
    pub slope: Slope,
    /// Covariance of the motion (uu, uv, vv), (pixels per frame)². Across a line of slopes the least of any motion.
    pub covariance: [f32; 3],
}

impl Motion {
    /// Semi-axes of the ellipse of one standard deviation, pixels per frame, the longer first, and the angle of the
    /// longer one from +u towards +v, radians. Along an edge nothing is known, and the longer axis shows it.
    pub fn ellipse(&self) -> ([f32; 2], f32) {
        let ((cos, sin), variances) = eigen(self.covariance);
        (variances.map(|variance| variance.max(0.0).sqrt()), sin.atan2(cos))
    }

    /// Mahalanobis distance of `slope`, with its own `sigma` in each direction (pixels per frame), from this motion.
    pub fn distance(&self, slope: Slope, sigma: f32) -> f32 {
        let [uu, uv, vv] = self.covariance;
        let (uu, vv) = (uu + sigma * sigma, vv + sigma * sigma);
        let (du, dv) = (slope.u - self.slope.u, slope.v - self.slope.v);
        let determinant = (uu * vv - uv * uv).max(f32::MIN_POSITIVE);
        ((vv * du * du - 2.0 * uv * du * dv + uu * dv * dv) / determinant).max(0.0).sqrt()
    }
}

/// Motions of all places of a burst at mid-burst, cell by cell; made by [`motion_field`].
#[derive(Debug, Clone, PartialEq)]
pub struct MotionField {
    /// Columns and rows of cells.
    pub size: (usize, usize),
    /// Pixels of the input image on a side of a cell.
    pub cell_px: usize,
    /// Motion of each cell, row by row.
    pub motions: Vec<Motion>,
    /// Uncertainty from which on a motion counts as unknown, pixels per frame.
    pub unknown_sigma: f32,
    /// Motions that exist in the burst, nearest first, then the layers that move by themselves.
    pub layers: Vec<MotionLayer>,
    /// Layer of each cell, from 1; 0 for none.
    pub layer: Vec<u8>,
}

impl MotionField {
    /// Index of the cell at the place (`u`, `v`) of the input image; the nearest one outside it.
    fn cell(&self, u: f32, v: f32) -> usize {
        let along = |x: f32, count: usize| (((x + 0.5) / self.cell_px as f32) as usize).min(count.saturating_sub(1));
        along(v, self.size.1) * self.size.0 + along(u, self.size.0)
    }

    /// Motion at the place (`u`, `v`) of the input image, that of its cell.
    pub fn at(&self, u: f32, v: f32) -> Motion {
        self.motions[self.cell(u, v)]
    }

    /// Motion at the place (`u`, `v`) of the input image; `None` where it is unknown in some direction.
    pub fn known_at(&self, u: f32, v: f32) -> Option<Motion> {
        Some(self.at(u, v)).filter(|motion| self.is_known(motion))
    }

    /// Layer at the place (`u`, `v`), from 1; 0 for none.
    pub fn layer_at(&self, u: f32, v: f32) -> u8 {
        self.layer[self.cell(u, v)]
    }

    /// Layer, from 1, of a feature at the place (`u`, `v`) that moves by `slope` ± `sigma`, pixels per frame: that of
    /// the place, or else the layer of the nearest motion among the others; 0 if the feature moves like none.
    pub fn layer_of(&self, (u, v): (f32, f32), slope: Slope, sigma: f32) -> u8 {
        if self.at(u, v).distance(slope, sigma) < OTHER_SIGMAS {
            return self.layer_at(u, v);
        }
        let apart = |layer: &MotionLayer| {
            (slope.u - layer.slope.u).hypot(slope.v - layer.slope.v) / sigma.hypot(layer.spread).max(f32::MIN_POSITIVE)
        };
        let nearest = (1u8..).zip(self.layers.iter().map(apart)).min_by(|(_, a), (_, b)| a.total_cmp(b));
        nearest.filter(|(_, apart)| *apart < OTHER_SIGMAS).map_or(0, |(number, _)| number)
    }

    /// Certainty of a motion of this field, from 1 for an exact one to 0 for an unknown one.
    pub fn certainty(&self, motion: &Motion) -> f32 {
        (1.0 - motion.ellipse().0[0] / self.unknown_sigma).max(0.0)
    }

    /// Lengths of the motions, pixels per frame, on the pixels of an image of `size` (columns, rows).
    pub fn magnitudes(&self, size: (usize, usize)) -> Plane {
        Plane::from_fn(size.0, size.1, |u, v| self.at(u as f32, v as f32).slope.magnitude())
    }

    /// Slope of `grid` nearest to the motions of the most cells, the first of equal ones; `None` where none is known.
    pub fn commonest_of(&self, grid: &SlopeGrid) -> Option<Slope> {
        let mut cells = vec![0usize; grid.len()];
        self.motions.iter().filter(|motion| self.is_known(motion)).for_each(|m| cells[grid.nearest(m.slope)] += 1);
        let most = cells.iter().max().filter(|most| **most > 0)?;
        cells.iter().position(|count| count == most).map(|index| grid.slope(index))
    }

    /// Whether a motion of this field is known in every direction.
    pub fn is_known(&self, motion: &Motion) -> bool {
        motion.ellipse().0[0] < self.unknown_sigma
    }
}

/// Finds the motion of every place of the burst of `frames` taken at `times`, all of one size, among the slopes of
/// `grid` and those one step beyond. `None` for a single slope, fewer than 3 frames, or under 4 cells on a side.
///
/// The field has the same bits for any number of threads, and takes up to 100 MB while it is found.
///
/// # Errors
/// [`Cancelled`] once `monitor` was cancelled.
pub fn motion_field(
    frames: &[&Plane],
    times: &FrameTimes,
    grid: &SlopeGrid,
    monitor: &Monitor,
) -> Result<Option<MotionField>, Cancelled> {
    let Some(first) = frames.first() else { return Ok(None) };
    let (width, height) = first.size();
    // Cells grow until the values of the whole sweep fit into memory.
    let cells = |cell_px: usize| MERGED_CELLS * MERGED_CELLS * (width / cell_px) * (height / cell_px);
    let values = |cell_px: &usize| cells(*cell_px) * swept(grid, times, *cell_px).len();
    let smallest_px = if width * height > SMALL_IMAGE_PX { CELL_PX } else { SMALL_CELL_PX };
    let cell_px =
        (smallest_px..).step_by(MERGED_CELLS).find(|cell_px| values(cell_px) <= MAX_VALUES).unwrap_or(smallest_px);
    if frames.len() < 3 || grid.len() < 2 || width.min(height) < 4 * cell_px.max(CELL_PX) {
        return Ok(None);
    }
    let evidence = Evidence::new(frames, times, cell_px, grid, monitor)?;
    let swept = [evidence.grid.u.count, evidence.grid.v.count];
    // Windows come after the posterior: they correct its cells and add the accuracy between slopes.
    let mut found = Posterior::new(&evidence.nats, swept, monitor)?.found();
    overrule(&mut found, &evidence, monitor)?;
    let of_window = refine(&mut found, &evidence, monitor)?;
    complete_covariances(&mut found, &of_window, evidence.size, monitor)?;
    let motions = found.iter().map(|found| motion(found, &evidence)).collect();
    let (size, last_frame) = (evidence.size, evidence.last_frame);
    let unknown_sigma = UNKNOWN_SMEAR_PX / last_frame;
    let mut field = MotionField { size, cell_px, motions, unknown_sigma, layers: Vec::new(), layer: Vec::new() };
    let known_cell = |(index, motion): (usize, &Motion)| {
        let centre = |at: usize| (at as f64 + 0.5) * cell_px as f64 - 0.5;
        let pos_image = [centre(index % size.0), centre(index / size.0)];
        field.is_known(motion).then(|| KnownCell { pos_image, motion: (motion.slope, motion.ellipse().0[0]) })
    };
    let known: Vec<Option<KnownCell>> = field.motions.iter().enumerate().map(known_cell).collect();
    (field.layers, field.layer) = layers::layers(&known, last_frame, monitor)?;
    Ok(Some(field))
}

/// Completes the covariances `found` by those `of_window` and by the changes between cells.
fn complete_covariances(
    found: &mut [MotionEstimate],
    of_window: &[[f32; 3]],
    (width, height): (usize, usize),
    monitor: &Monitor,
) -> Result<(), Cancelled> {
    let change = |axis: usize| {
        let change = Plane::from_fn(width, height, |i, j| {
            let at = |i: usize, j: usize| found[j.min(height - 1) * width + i.min(width - 1)].at[axis];
            (at(i, j) - at(i + 1, j)).powi(2) + (at(i, j) - at(i, j + 1)).powi(2)
        });
        smoothed(&change, CHANGE_WINDOW_CELLS, monitor)
    };
    let (along_u, along_v) = (change(0)?, change(1)?);
    let changes = along_u.data().iter().zip(along_v.data()).map(|(uu, vv)| [*uu, 0.0, *vv]);
    let [own, border] = VARIANCE_PARTS;
    for ((found, of_window), change) in found.iter_mut().zip(of_window).zip(changes) {
        found.covariance = [0, 1, 2].map(|k| own * found.covariance[k] + of_window[k] + border * change[k]);
    }
    Ok(())
}

/// Motion in pixels per frame of an estimate on the grid of the sweep.
fn motion(found: &MotionEstimate, evidence: &Evidence) -> Motion {
    let grid = &evidence.grid;
    let (sin, cos) = grid.direction_deg.to_radians().sin_cos();
    let (step_u, step_v) = (grid.u.step(), grid.v.step());
    let [uu, uv, vv] = found.covariance;
    let [a, b, c] = [uu * step_u * step_u, uv * step_u * step_v, vv * step_v * step_v];
    let least = (LEAST_SMEAR_PX / evidence.last_frame).powi(2);
    let covariance = [
        a * cos * cos - 2.0 * b * sin * cos + c * sin * sin + least,
        (a - c) * sin * cos + b * (cos * cos - sin * sin),
        a * sin * sin + 2.0 * b * sin * cos + c * cos * cos + least,
    ];
    Motion { slope: grid.at(found.at[0], found.at[1]), covariance }
}

/// Rotation (cosine, sine) to the principal axes of a symmetric matrix (uu, uv, vv), and its eigenvalues, larger first.
fn eigen([uu, uv, vv]: [f32; 3]) -> ((f32, f32), [f32; 2]) {
    let (mean, half) = (0.5 * (uu + vv), (0.5 * (uu - vv)).hypot(uv));
    let (sin, cos) = (0.5 * (2.0 * uv).atan2(uu - vv)).sin_cos();
    ((cos, sin), [mean + half, mean - half])
}

/// The symmetric matrix with these principal axes and eigenvalues.
fn turned((cos, sin): (f32, f32), [first, second]: [f32; 2]) -> [f32; 3] {
    let uv = (first - second) * cos * sin;
    [first * cos * cos + second * sin * sin, uv, first * sin * sin + second * cos * cos]
}
