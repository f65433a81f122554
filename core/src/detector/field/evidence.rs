//! Evidence for each slope at each cell, in nats, from a sweep over the slopes on reduced, band-passed frames.
//!
//! Where a cell moves by λ the frames shifted by λ add up: their sum S has N times the signal and √N times the noise of
//! one frame. With σ, the noise of one frame, z = S/(√N·σ) is standard normal in empty cells. Most of a scene is empty
//! and a part of it strong structure, so the evidence is the logarithm of a mixture: empty (a share 1 − π), or
//! structure ρ times as strong as the noise of S (a share π). It is about 0 for noise, whatever the slope, and grows as
//! z²/2 for structure; a plain square would add the noise of empty cells.

use crate::burst::Offset;
use crate::detector::params::slope_grid::{Slope, SlopeAxis, SlopeGrid};
use crate::detector::stack::FrameTimes;
use crate::kernel::stack::any_masked;
use crate::monitor::{Cancelled, Monitor};
use crate::plane::Plane;
use crate::plane::blur::smoothed;
use multiversion::multiversion;
use rayon::prelude::*;

/// Gaussians that bound the band, σ in the finest cells, as all lengths here.
const BAND_CELLS: [f64; 2] = [1.0, 1.6];
/// Number of cells that share the noise of one band-passed cell: together their evidence counts once.
const CORRELATED_CELLS: f32 = 12.0;
/// Share of the cells that show structure.
const SHARE: f32 = 0.3;
/// Power of structure in S, relative to the noise's.
const POWER: f32 = 16.0;
/// Largest smear that a step of the sweep leaves between the first and the last frame, cells.
const STEP_CELLS: f32 = 1.125;
/// Maximum number of slopes of an axis, on a line and in a plane.
const MAX_STEPS: [usize; 2] = [65, 17];
/// Standard deviation of the window in which the noise is the same, cells.
const NOISE_WINDOW_CELLS: f64 = 16.0;
/// Cells on a side of the squares over which the noise is averaged.
const NOISE_CELLS: usize = 4;
/// Share of a square's samples, in all frames, below which it is hidden.
const MIN_SEEN: f32 = 0.8;
/// Finest cells on a side of a cell for which evidence is kept: only the smallest things are as small.
pub(super) const MERGED_CELLS: usize = 2;

pub(super) struct Evidence {
    /// Columns and rows of cells.
    pub size: (usize, usize),
    /// Swept slopes; one step more on each side than requested.
    pub grid: SlopeGrid,
    /// Time from the first to the last frame, frame intervals.
    pub last_frame: f32,
    /// Nats for each cell, a plane a slope.
    pub nats: Vec<Plane>,
}

impl Evidence {
    /// Sweeps the range of `grid` over `frames`, reduced to cells of `cell_px`, a multiple of [`MERGED_CELLS`].
    pub fn new(
        frames: &[&Plane],
        times: &FrameTimes,
        cell_px: usize,
        grid: &SlopeGrid,
        monitor: &Monitor,
    ) -> Result<Self, Cancelled> {
        let fine_px = cell_px / MERGED_CELLS;
        let bands = frames.par_iter().map(|frame| band(frame, fine_px, monitor));
        let bands: Vec<Plane> = bands.collect::<Result<_, _>>()?;
        let in_cells = |at: Offset<f32>| Offset { u: at.u / fine_px as f32, v: at.v / fine_px as f32 };
        let at_cells: Vec<Offset<f32>> = times.from_middle().into_iter().map(in_cells).collect();
        let are_views = times.positions.are_views();
        let grid = swept(grid, times, cell_px);
        let slopes: Vec<Slope> = grid.slopes().collect();
        let size = bands[0].size();
        // At a wrong slope the residual contains the signal: the noise is the smallest over all slopes around a place.
        let mut variance = Plane::zeros(size.0.div_ceil(NOISE_CELLS), size.1.div_ceil(NOISE_CELLS));
        variance.data_mut().fill(f32::MAX);
        let hidden = hidden_squares(frames, fine_px * NOISE_CELLS, variance.size());
        let mut nats = Vec::with_capacity(slopes.len());
        // Slopes of one row share the shift down; views of a light field move down by any slope.
        for same_v in slopes.chunk_by(|a, b| !are_views && a.v == b.v) {
            monitor.check()?;
            let moved = |slope: &Slope| at_cells.iter().map(|at| slope.displacement(*at)).collect::<Vec<_>>();
            let reach = |slope: &Slope| moved(slope).iter().map(|(u, _)| u.abs()).fold(0.0, f32::max);
            let margin = same_v.iter().map(reach).fold(0.0, f32::max).ceil() as usize + 3;
            let down = moved(&same_v[0]);
            let shifted = bands.par_iter().zip(down).map(|(band, (_, v))| shifted_down(band, v, margin));
            let shifted: Vec<Plane> = shifted.collect();
            let stacks = same_v.par_iter().map(|slope| {
                let shifts: Vec<Shift> = moved(slope).into_iter().map(|(u, _)| Shift::new(u)).collect();
                let (power, mut residual) = stacked(&shifted, &shifts, margin);
                // NaN keeps hidden squares out of the windows around them and of the least variance.
                hidden.iter().for_each(|&square| residual.data_mut()[square] = f32::NAN);
                Ok((power, smoothed(&residual, NOISE_WINDOW_CELLS / NOISE_CELLS as f64, monitor)?))
            });
            for (power, residual) in stacks.collect::<Result<Vec<_>, Cancelled>>()? {
                variance.data_mut().iter_mut().zip(residual.data()).for_each(|(least, x)| *least = least.min(*x));
                nats.push(power);
            }
        }
        let mut scale = enlarged(&variance, NOISE_CELLS, size);
        let gain = 0.5 * POWER / (1.0 + POWER);
        scale.data_mut().iter_mut().for_each(|x| *x = gain / x.max(f32::MIN_POSITIVE));
        nats.par_iter_mut().for_each(|power| {
            to_nats(power, &scale);
            *power = summed(power, MERGED_CELLS);
        });
        Ok(Self { size: nats[0].size(), grid, last_frame: times.positions.span() as f32, nats })
    }
}

/// Squares of `side` pixels, numbered row by row in a plane of `size`, with too few seen samples to have any evidence.
fn hidden_squares(frames: &[&Plane], side: usize, (columns, rows): (usize, usize)) -> Vec<usize> {
    if !any_masked(frames) {
        return Vec::new();
    }
    let seen = |square: usize| {
        let (first_u, first_v) = (square % columns * side, square / columns * side);
        let end = |first: usize, n: usize| (first + side).min(n);
        let (width, height) = frames[0].size();
        let pixels = (first_v..end(first_v, height)).flat_map(|v| (first_u..end(first_u, width)).map(move |u| (u, v)));
        let sum = |frame: &&Plane| pixels.clone().map(|(u, v)| frame.weight_at(u, v)).sum::<f32>();
        frames.iter().map(sum).sum::<f32>() / (frames.len() * pixels.clone().count()).max(1) as f32
    };
    (0..columns * rows).filter(|&square| seen(square) < MIN_SEEN).collect()
}

/// Sweep over the range of `grid`, in steps that the band can bear, one wider at each end so that ends can be peaks.
pub(super) fn swept(grid: &SlopeGrid, times: &FrameTimes, cell_px: usize) -> SlopeGrid {
    let step = STEP_CELLS * (cell_px / MERGED_CELLS) as f32 / times.positions.span().max(1.0) as f32;
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

/// Band of one frame, on cells that are means of `cell_px`² pixels; incomplete cells are dropped.
fn band(frame: &Plane, cell_px: usize, monitor: &Monitor) -> Result<Plane, Cancelled> {
    let weight = 1.0 / (cell_px * cell_px) as f32;
    let mut cells = Plane::zeros(frame.width() / cell_px, frame.height() / cell_px);
    (0..cells.height() * cell_px).for_each(|v| add_parts(frame.row(v), cell_px, cells.row_mut(v / cell_px)));
    cells.data_mut().iter_mut().for_each(|sum| *sum *= weight);
    let [fine, coarse] = BAND_CELLS;
    let mut band = smoothed(&cells, fine, monitor)?;
    let coarse = smoothed(&cells, coarse, monitor)?;
    band.data_mut().iter_mut().zip(coarse.data()).for_each(|(x, y)| *x -= y);
    Ok(band)
}

/// S²/N of the sum S of the frames, which are shifted down with a `margin` of columns at both sides, at the `shifts` to
/// the right; and their variance in squares of [`NOISE_CELLS`]. Both are in the power of one frame.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx512dq", "x86_64+avx2+fma", "aarch64+neon"))]
fn stacked(frames: &[Plane], shifts: &[Shift], margin: usize) -> (Plane, Plane) {
    let (width, height) = (frames[0].width() - 2 * margin, frames[0].height());
    let count = frames.len() as f32;
    let mut power = Plane::zeros(width, height);
    let mut residual = Plane::zeros(width.div_ceil(NOISE_CELLS), height.div_ceil(NOISE_CELLS));
    let mut squares = vec![0.0f32; width];
    for v in 0..height {
        let sum = power.row_mut(v);
        squares.fill(0.0);
        for (frame, shift) in frames.iter().zip(shifts) {
            let first = (margin as i64 + shift.whole - 1) as usize;
            let from = &frame.row(v)[first..first + width + 3];
            let [a, b, c, d] = shift.weights;
            let read = from.windows(4).map(|x| a * x[0] + b * x[1] + c * x[2] + d * x[3]);
            if v % NOISE_CELLS == 0 {
                // Squared after the shift: interpolation smooths noise, and slope 0 would be favoured otherwise.
                sum.iter_mut().zip(&mut squares).zip(read).for_each(|((sum, square), x)| {
                    *sum += x;
                    *square += x * x;
                });
            } else {
                sum.iter_mut().zip(read).for_each(|(sum, x)| *sum += x);
            }
        }
        // S²/N has the power of one frame, like the residual it is compared with.
        sum.iter_mut().for_each(|sum| *sum *= *sum / count);
        if v % NOISE_CELLS == 0 {
            let pairs = squares.chunks(NOISE_CELLS).zip(sum.chunks(NOISE_CELLS));
            for (out, (squares, power)) in residual.row_mut(v / NOISE_CELLS).iter_mut().zip(pairs) {
                let around: f32 = squares.iter().zip(power).map(|(square, power)| square - power).sum();
                *out = around / (squares.len() as f32 * (count - 1.0));
            }
        }
    }
    (power, residual)
}

/// Exponent from which evidence grows with its logarithm only.
const BRIGHT: f32 = 60.0;

/// Makes the power of a stack its evidence: ln(1 − π + π·(1 + ρ)^−½·exp(x)) for the exponent x, `scale` times the
/// power, to a hundredth of a nat before the division by correlated cells.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx512dq", "x86_64+avx2+fma", "aarch64+neon"))]
fn to_nats(power: &mut Plane, scale: &Plane) {
    let nothing = (1.0 - SHARE).ln();
    let equal = nothing - (SHARE / (1.0 + POWER).sqrt()).ln();
    for (power, scale) in power.data_mut().iter_mut().zip(scale.data()) {
        let exponent = (scale * *power).clamp(0.0, f32::MAX);
        // Bright things separate slopes, but must not speak for all around. A float's bits are about its logarithm.
        let octaves = ((exponent * (1.0 / BRIGHT)).to_bits() as i32 - (127 << 23)) as f32 * (1.0 / (1 << 23) as f32);
        let x =
            if exponent > BRIGHT { BRIGHT * (1.0 + std::f32::consts::LN_2 / 3.0 * octaves) } else { exponent } - equal;
        // ln(1 + exp(x)) tends to x where x is large; this power has the missing value and slope at 0.
        let missing = (1.0 - x.abs() * (0.5 / (6.0 * std::f32::consts::LN_2))).max(0.0);
        let cubed = missing * missing * missing;
        *power = (nothing + x.max(0.0) + std::f32::consts::LN_2 * cubed * cubed) * (1.0 / CORRELATED_CELLS);
    }
}

/// Evidence of squares of `by`² cells: it adds up, and a smaller one at an edge counts as a whole one.
pub(super) fn summed(nats: &Plane, by: usize) -> Plane {
    let mut sums = means(nats, by);
    sums.data_mut().iter_mut().for_each(|x| *x *= (by * by) as f32);
    sums
}

/// Adds the sum of each `by` values of `row` to the `sums`, which may end before the row does.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx512dq", "x86_64+avx2+fma", "aarch64+neon"))]
fn add_parts(row: &[f32], by: usize, sums: &mut [f32]) {
    // As a constant, the usual number lets each lane of a vector take one sum.
    let parts = if by == 4 { row.as_chunks::<4>().0 } else { &[] };
    let whole = parts.len().min(sums.len());
    sums.iter_mut().zip(parts).for_each(|(sum, part)| *sum += part.iter().sum::<f32>());
    let rest = sums[whole..].iter_mut().zip(row[whole * by..].chunks(by));
    rest.for_each(|(sum, part)| *sum += part.iter().sum::<f32>());
}

/// Means of squares of `by`² cells, smaller ones at the right and lower edge.
pub(super) fn means(plane: &Plane, by: usize) -> Plane {
    let (width, height) = plane.size();
    let mut means = Plane::zeros(width.div_ceil(by), height.div_ceil(by));
    for j in 0..means.height() {
        let rows = j * by..((j + 1) * by).min(height);
        let out = means.row_mut(j);
        rows.clone().for_each(|v| add_parts(plane.row(v), by, out));
        let whole = (rows.len() * by) as f32;
        // The last column of cells may be narrower.
        let last = (rows.len() * (width - (out.len() - 1) * by)) as f32;
        let count = out.len();
        out.iter_mut().enumerate().for_each(|(i, sum)| *sum /= if i + 1 < count { whole } else { last });
    }
    means
}

/// `few`, one value for `by`² cells, enlarged to a plane of `size` by linear interpolation.
pub(super) fn enlarged(few: &Plane, by: usize, (width, height): (usize, usize)) -> Plane {
    // The values before and after each place, and the weight of the later one.
    let along = |count: usize, last: usize| -> Vec<(usize, usize, f32)> {
        let place = |x: usize| ((x as f32 + 0.5) / by as f32 - 0.5).clamp(0.0, last as f32);
        (0..count).map(place).map(|x| (x as usize, (x as usize + 1).min(last), x.fract())).collect()
    };
    let columns = along(width, few.width() - 1);
    let mut plane = Plane::zeros(width, height);
    for (v, (above, below, part)) in along(height, few.height() - 1).into_iter().enumerate() {
        let (above, below) = (few.row(above), few.row(below));
        let row: Vec<f32> = above.iter().zip(below).map(|(a, b)| a + part * (b - a)).collect();
        let values = columns.iter().map(|&(left, right, part)| row[left] + part * (row[right] - row[left]));
        plane.row_mut(v).iter_mut().zip(values).for_each(|(out, value)| *out = value);
    }
    plane
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

/// Band shifted down by `cells`, with `margin` columns more at both sides; the nearest cell is repeated beyond.
fn shifted_down(band: &Plane, cells: f32, margin: usize) -> Plane {
    let (width, height) = band.size();
    let shift = Shift::new(cells);
    let mut shifted = Plane::zeros(width + 2 * margin, height);
    for v in 0..height {
        let out = shifted.row_mut(v);
        for (k, &weight) in shift.weights.iter().enumerate().filter(|(_, weight)| **weight != 0.0) {
            let row = band.row((v as i64 + shift.whole + k as i64 - 1).clamp(0, height as i64 - 1) as usize);
            out[margin..margin + width].iter_mut().zip(row).for_each(|(sum, x)| *sum += weight * x);
        }
        let (first, last) = (out[margin], out[margin + width - 1]);
        out[..margin].fill(first);
        out[margin + width..].fill(last);
    }
    shifted
}
