//! Evidence for each slope at each cell, in nats, from a sweep over the slopes on reduced, band-passed frames.
//!
//! Where a cell moves by λ the frames shifted by λ add up: their sum S has N times the signal and √N times the noise of
//! one frame. With the noise of one frame σ, z = S/(√N·σ) is a standard normal where there is nothing. Most of a scene
//! shows nothing and a part of it strong structure, so the evidence is the logarithm of a mixture: nothing (a share 1 −
//! π), or structure that is ρ times as strong as the noise of S (a share π). It is about 0 for noise, whatever the
//! slope, and grows as z²/2 for what stands out; a plain square would add the noise of all empty cells to each window.

use super::windows::{enlarged, means};
use crate::detector::params::slope_grid::{Slope, SlopeAxis, SlopeGrid};
use crate::detector::stack::FrameTimes;
use crate::monitor::{Cancelled, Monitor};
use crate::plane::Plane;
use crate::plane::blur::smoothed;
use rayon::prelude::*;

/// Band that is looked at: Gaussians of these σ, in cells.
const BAND_CELLS: [f64; 2] = [1.0, 1.6];
/// Cells that the noise of one band-passed cell is shared by: the evidence of that many cells is that of one.
const CORRELATED_CELLS: f32 = 12.0;
/// Share of the cells that show structure.
const SHARE: f32 = 0.3;
/// Power of their structure in S, of that of the noise.
const POWER: f32 = 16.0;
/// Largest smear that a step of the sweep leaves between the first and the last frame, cells.
const STEP_CELLS: f32 = 1.125;
/// Maximum number of slopes of an axis, on a line and in a plane.
const MAX_STEPS: [usize; 2] = [65, 17];
/// Standard deviation of the window in which the noise is the same, cells.
const NOISE_WINDOW_CELLS: f64 = 16.0;
/// Cells on a side of the squares that its means are taken of.
const NOISE_CELLS: usize = 4;
/// Slopes whose residuals are in memory at once.
const SLOPES_AT_ONCE: usize = 16;

/// Evidence of all cells for all swept slopes.
pub(super) struct Evidence {
    /// Columns and rows of cells.
    pub size: (usize, usize),
    /// Pixels on a side of a cell.
    pub cell_px: usize,
    /// Swept slopes; one step more on each side than asked for.
    pub grid: SlopeGrid,
    /// Number of the last frame, from 0.
    pub last_frame: f32,
    /// Nats for each cell, a plane a slope.
    pub nats: Vec<Plane>,
}

impl Evidence {
    /// Sweeps the range of `grid` over `frames`, reduced to cells of `cell_px`.
    pub fn new(
        frames: &[&Plane],
        times: &FrameTimes,
        cell_px: usize,
        grid: &SlopeGrid,
        monitor: &Monitor,
    ) -> Result<Self, Cancelled> {
        let bands = frames.par_iter().zip(times.from_middle());
        let bands = bands.map(|(frame, time)| Ok((time, band(frame, cell_px, monitor)?)));
        let bands: Vec<(f32, Plane)> = bands.collect::<Result<_, _>>()?;
        let grid = swept(grid, times, cell_px);
        let slopes: Vec<Slope> = grid.slopes().collect();
        let size = bands[0].1.size();
        // The residual of a wrong slope has the signal in it: the noise is that of the best slope around a place.
        let mut variance = vec![f32::INFINITY; size.0 * size.1];
        let mut nats = Vec::with_capacity(slopes.len());
        for some in slopes.chunks(SLOPES_AT_ONCE) {
            let stacks = some.par_iter().map(|&slope| stacked(&bands, slope, cell_px, monitor));
            for (power, residual) in stacks.collect::<Result<Vec<_>, _>>()? {
                variance.iter_mut().zip(residual.data()).for_each(|(least, x)| *least = least.min(*x));
                nats.push(power);
            }
        }
        nats.par_iter_mut().for_each(|power| to_nats(power, &variance));
        Ok(Self { size, cell_px, grid, last_frame: (times.frame_count - 1) as f32, nats })
    }
}

/// The sweep over the range of `grid`, a step wider on each side so that its ends can be peaks, in steps that leave no
/// more smear than the band can bear.
pub(super) fn swept(grid: &SlopeGrid, times: &FrameTimes, cell_px: usize) -> SlopeGrid {
    let step = STEP_CELLS * cell_px as f32 / (times.frame_count.max(2) - 1) as f32;
    let most = MAX_STEPS[usize::from(grid.is_plane())];
    let axis = |axis: SlopeAxis| {
        if axis.count < 2 {
            return axis;
        }
        let count = (((axis.max - axis.min) / step).ceil() as usize + 1).clamp(3, most - 2);
        SlopeAxis { count, ..axis }.with_more(1, 1)
    };
    SlopeGrid { u: axis(grid.u), v: axis(grid.v), ..*grid }
}

/// The band of one frame, on cells that are means of `cell_px`² pixels. What is left at the right and lower edge is no
/// whole cell, and is left out.
fn band(frame: &Plane, cell_px: usize, monitor: &Monitor) -> Result<Plane, Cancelled> {
    let weight = 1.0 / (cell_px * cell_px) as f32;
    let cells = Plane::from_fn(frame.width() / cell_px, frame.height() / cell_px, |i, j| {
        let rows = (j * cell_px..(j + 1) * cell_px).map(|v| &frame.row(v)[i * cell_px..(i + 1) * cell_px]);
        weight * rows.map(|row| row.iter().sum::<f32>()).sum::<f32>()
    });
    let [fine, coarse] = BAND_CELLS;
    let mut band = smoothed(&cells, fine, monitor)?;
    let coarse = smoothed(&cells, coarse, monitor)?;
    band.data_mut().iter_mut().zip(coarse.data()).for_each(|(x, y)| *x -= y);
    Ok(band)
}

/// S²/N of the sum S of the frames that are shifted by `slope`, and the variance of the frames around their mean,
/// smoothed. Both are in the power of one frame.
fn stacked(
    bands: &[(f32, Plane)],
    slope: Slope,
    cell_px: usize,
    monitor: &Monitor,
) -> Result<(Plane, Plane), Cancelled> {
    monitor.check()?;
    let (width, height) = bands[0].1.size();
    let count = bands.len() as f32;
    let [mut sum, mut squares] = [Plane::zeros(width, height), Plane::zeros(width, height)];
    let mut row = vec![0.0; width];
    let mut line = Vec::new();
    for (time, band) in bands {
        let [shift_u, shift_v] = [slope.u, slope.v].map(|slope| Shift::new(slope * time / cell_px as f32));
        for v in 0..height {
            shifted_row(band, v, &shift_u, &shift_v, &mut line, &mut row);
            // Squares after the shift: interpolation smooths noise, and slope 0 would be favoured without.
            let sums = sum.row_mut(v).iter_mut().zip(squares.row_mut(v));
            sums.zip(&row).for_each(|((sum, squares), x)| {
                *sum += x;
                *squares += x * x;
            });
        }
    }
    for (sum, square) in sum.data_mut().iter_mut().zip(squares.data_mut()) {
        *sum *= *sum / count;
        *square = (*square - *sum) / (count - 1.0);
    }
    // A smooth plane is as well blurred where it is small.
    let few = means(&squares, NOISE_CELLS);
    let few = smoothed(&few, NOISE_WINDOW_CELLS / NOISE_CELLS as f64, monitor)?;
    Ok((sum, enlarged(&few, NOISE_CELLS, (width, height))))
}

/// Makes the power of a stack its evidence, with `variance` that of the noise of one frame in each cell.
fn to_nats(power: &mut Plane, variance: &[f32]) {
    let (gain, cost) = (0.5 * POWER / (1.0 + POWER), (1.0 + POWER).sqrt());
    for (power, variance) in power.data_mut().iter_mut().zip(variance) {
        // Beyond 60 nats the exponential says nothing more, and would overflow.
        let exponent = (gain * *power / variance.max(f32::MIN_POSITIVE)).min(60.0);
        *power = (1.0 - SHARE + SHARE / cost * exponent.exp()).ln() / CORRELATED_CELLS;
    }
}

/// A shift along one axis: whole cells and the weights of the four cells around the place (Catmull–Rom).
struct Shift {
    whole: i64,
    weights: [f32; 4],
}

impl Shift {
    fn new(cells: f32) -> Self {
        let whole = cells.floor();
        let x = cells - whole;
        let weights = [
            0.5 * x * (x * (2.0 - x) - 1.0),
            0.5 * (x * x * (3.0 * x - 5.0) + 2.0),
            0.5 * x * (x * (4.0 - 3.0 * x) + 1.0),
            0.5 * x * x * (x - 1.0),
        ];
        Self { whole: whole as i64, weights }
    }
}

/// Row `v` of the band at the places (u, v) + shift; beyond the edge the nearest cell is repeated.
fn shifted_row(band: &Plane, v: usize, shift_u: &Shift, shift_v: &Shift, line: &mut Vec<f32>, out: &mut [f32]) {
    let (width, height) = band.size();
    // One column before the first place and two behind the last one are needed.
    line.clear();
    line.resize(width + 3, 0.0);
    let before = shift_u.whole - 1;
    // Columns of `line` that lie within the band.
    let start = (-before).clamp(0, width as i64 + 3) as usize;
    let end = (width as i64 - before).clamp(start as i64, width as i64 + 3) as usize;
    for (k, &weight) in shift_v.weights.iter().enumerate().filter(|(_, weight)| **weight != 0.0) {
        let row = band.row((v as i64 + shift_v.whole + k as i64 - 1).clamp(0, height as i64 - 1) as usize);
        let inside = &row[(start as i64 + before).clamp(0, width as i64) as usize..];
        line[..start].iter_mut().for_each(|sum| *sum += weight * row[0]);
        line[start..end].iter_mut().zip(inside).for_each(|(sum, x)| *sum += weight * x);
        line[end..].iter_mut().for_each(|sum| *sum += weight * row[width - 1]);
    }
    let [a, b, c, d] = shift_u.weights;
    for (out, at) in out.iter_mut().zip(line.windows(4)) {
        *out = a * at[0] + b * at[1] + c * at[2] + d * at[3];
    }
}
