//! Scale space: Gaussian levels of a motion stack, octave by octave, and their differences D. Here the scales, and
//! tiles of D in one octave; `planes` computes whole levels of one slope.
//!
//! Octaves and levels are in VLFeat's convention. Octave `o` has pixels of 2^o input pixels; its levels `s = −1 … S+1`
//! have σ = σ0·2^(o + s/S) input pixels, with σ0 = 1.6·2^(1/S), so that an octave's first level always has σ = 1.6
//! octave pixels. The input is taken to have σ = 0.5. Each level is blurred from the level before by
//! σ0·2^(s/S)·√(1 − 2^(−2/S)) octave pixels; the next octave starts from every second pixel of level S−1, with twice
//! the first level's σ. DoG level `s` (−1 … S) is `G(s+1) − G(s)`, and extrema are searched at levels 0 … S−1. Octave
//! −1 is the image doubled by linear interpolation: pixel (2i, 2j) is pixel (i, j). A positive first octave o has every
//! 2^o-th pixel of the mean of *binned* frames: triangle-weighted means of pixels less than 2^o columns and rows away,
//! the nearest repeated beyond the frame. Binning commutes with shifts and sums, so each frame is binned once for all
//! slopes. Codes that skip pixels ([`CoarseStart`]) lose light, and alias.
//!
//! Tiles include the pixels around them that their filters need, so each value is bitwise independent of the tiles.

pub(super) mod planes;

use crate::detector::params::{CoarseStart, DetectorParams, MIN_OCTAVE_SIDE};
use crate::detector::stack::stack_row;
use crate::kernel::gaussian_bank::{Axis, FilterBank, FilterScratch, filter_tile};
use crate::kernel::machine::STACKED_ROWS;
use crate::kernel::stack::{FrameOffset, RowStacker};
use crate::monitor::{Cancelled, Monitor};
use crate::plane::Plane;
use crate::plane::blur::{GaussianKernel, triangle_blur};
use crate::plane::tile::{Region, Tile};
use std::ops::Range;

/// Assumed σ of the input image, in input pixels.
pub const SIGMA_INPUT: f64 = 0.5;
/// σ of the first level (s = −1) of every octave, in octave pixels.
pub const SIGMA_BASE: f64 = 1.6;

/// Scale of D.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Scale {
    /// Octave.
    pub octave: i32,
    /// DoG level.
    pub level: i32,
}

/// Scales and kernels of a scale space with `S` levels per octave, in VLFeat's convention.
#[derive(Debug, Clone)]
pub struct ScaleSpace {
    /// Number of levels per octave, S.
    pub levels: usize,
    /// Index of the finest octave.
    pub first_octave: i32,
    /// Pixels of a first octave coarser than the input.
    pub coarse_start: CoarseStart,
    /// Radius at which kernels are cut, in standard deviations.
    pub kernel_cut: f64,
    /// Kernel from the input's σ to the first level of the first octave.
    pub base_kernel: GaussianKernel,
    /// Kernels from level s−1 to level s, for s = 0 … S+1.
    pub step_kernels: Vec<GaussianKernel>,
}

impl ScaleSpace {
    /// Scale space of a search with `params`, by its levels, first octave and rules.
    pub fn of(params: &DetectorParams) -> Self {
        let (levels, cut) = (params.levels as usize, f64::from(params.rules.kernel_cut));
        Self::starting(levels, params.first_octave, params.rules.coarse_start, cut)
    }

    /// Scale space of `levels` per octave from octave `first_octave` on; kernels end at `kernel_cut` of their σ.
    pub fn new(levels: usize, first_octave: i32, kernel_cut: f64) -> Self {
        Self::starting(levels, first_octave, CoarseStart::Binned, kernel_cut)
    }

    /// As [`Self::new`], with the pixels of a coarse first octave made by `coarse_start`.
    pub fn starting(levels: usize, first_octave: i32, coarse_start: CoarseStart, kernel_cut: f64) -> Self {
        let step_kernels =
            (0..levels + 2).map(|s| GaussianKernel::with_cut(Self::step_sigma(levels, s), kernel_cut)).collect();
        let base_kernel = GaussianKernel::new(0.0);
        let space = Self { levels, first_octave, coarse_start, base_kernel, step_kernels, kernel_cut };
        let input = space.sigma_before(first_octave);
        let base = (SIGMA_BASE * SIGMA_BASE - input * input).max(0.0).sqrt();
        Self { base_kernel: GaussianKernel::with_cut(base, kernel_cut), ..space }
    }

    /// Whether the first octave is made from binned frames.
    pub fn bins(&self) -> bool {
        self.first_octave > 0 && self.coarse_start == CoarseStart::Binned
    }

    /// Number of input pixels from one kept pixel to the next where the first octave skips pixels; otherwise 1.
    pub fn skip(&self) -> usize {
        if self.bins() { 1 } else { 1 << self.first_octave.max(0) }
    }

    /// Frames as the first octave reads them if it bins; otherwise none, as it reads `frames` themselves.
    pub fn binned(&self, frames: &[&Plane], monitor: &Monitor) -> Result<Vec<Plane>, Cancelled> {
        let frames = if self.bins() { frames } else { &[] };
        frames.iter().map(|frame| triangle_blur(frame, 1 << self.first_octave, monitor)).collect()
    }

    /// σ of the pixels from which `octave` is made, before any of its filters; octave pixels.
    pub fn sigma_before(&self, octave: i32) -> f64 {
        if octave != self.first_octave {
            return SIGMA_BASE;
        }
        let pixel = 2f64.powi(octave);
        // The triangle of half-width n has the variance (n² − 1)/6.
        let triangle = if self.bins() { (pixel * pixel - 1.0) / 6.0 } else { 0.0 };
        (SIGMA_INPUT * SIGMA_INPUT + triangle).sqrt() / pixel
    }

    fn sigma0(levels: usize) -> f64 {
        SIGMA_BASE * 2f64.powf(1.0 / levels as f64)
    }

    /// σ of the blur from level s−1 to level s, octave pixels.
    fn step_sigma(levels: usize, s: usize) -> f64 {
        let k = 2f64.powf(1.0 / levels as f64);
        Self::sigma0(levels) * k.powi(s as i32) * (1.0 - 1.0 / (k * k)).sqrt()
    }

    /// σ in octave pixels at `level`, which may be fractional.
    pub fn sigma_octave(&self, level: f64) -> f64 {
        Self::sigma0(self.levels) * 2f64.powf(level / self.levels as f64)
    }

    /// σ in input pixels at `octave` and `level`.
    pub fn sigma_image(&self, octave: i32, level: f64) -> f64 {
        self.sigma_octave(level) * 2f64.powi(octave)
    }

    /// Filters that make the Gaussian level indices `levels` (0 is level −1) of the first or a later octave.
    pub fn bank(&self, first: bool, levels: Range<usize>) -> FilterBank {
        let base = if first { self.base_kernel.clone() } else { GaussianKernel::new(0.0) };
        FilterBank::new(std::iter::once(base).chain(self.step_kernels.iter().cloned()).collect(), levels)
    }

    /// Indices of all Gaussian levels of an octave: those of levels −1 … S+1.
    pub fn all_levels(&self) -> Range<usize> {
        0..self.levels + 3
    }
}

/// Size (columns, rows) of an octave of an image of `size`.
pub fn octave_size(size: (usize, usize), octave: i32) -> (usize, usize) {
    if octave < 0 { (size.0 << -octave, size.1 << -octave) } else { (size.0 >> octave, size.1 >> octave) }
}

/// Number of input pixels per octave pixel along a side, 2^octave.
pub fn octave_pixel(octave: i32) -> f32 {
    2f32.powi(octave)
}

/// Requested octaves whose shorter side has [`MIN_OCTAVE_SIDE`] pixels in an image of `size`; at least the first one.
pub fn searched_octaves(params: &DetectorParams, size: (usize, usize)) -> Range<i32> {
    let first = params.first_octave;
    let side = size.0.min(size.1);
    let fits = |o: i32| (if o < 0 { side * 2 } else { side >> o }) >= MIN_OCTAVE_SIDE;
    let end = (first..first + params.octaves as i32).take_while(|&o| fits(o)).last().unwrap_or(first) + 1;
    first..end
}

/// Source of the first level (s = −1) of an octave at one slope.
#[derive(Debug)]
pub enum Base<'a> {
    /// Frames shifted by a slope's offsets: for the first octave.
    Frames {
        /// Frames of one size, in time order; [binned](ScaleSpace::binned) where the scale space bins.
        frames: &'a [&'a Plane],
        /// [`crate::detector::stack::frame_offsets`] of the slope.
        offsets: &'a [FrameOffset],
        /// Index of the first octave.
        octave: i32,
    },
    /// Finished first level, on the octave's pixels.
    Level(&'a Plane),
}

impl Base<'_> {
    /// Calls `write(v, row)` with each row of the stacked image at the octave's resolution, before any blur.
    pub(crate) fn raw_rows(
        &self,
        rows: Range<usize>,
        columns: Range<usize>,
        stacked: &mut Vec<f32>,
        mut write: impl FnMut(usize, &[f32]),
    ) {
        let Self::Frames { frames, offsets, octave } = self else {
            unreachable!("only frames are made into raw rows");
        };
        match octave {
            0 => {
                stacked.resize(columns.len(), 0.0);
                for v in rows {
                    stack_row(frames, offsets, v, columns.clone(), stacked);
                    write(v, stacked);
                }
            }
            -1 => doubled_rows(frames, offsets, rows, columns, stacked, write),
            _ => {
                // Rows between are never stacked: only every 2^o-th pixel of a binned or skipped octave is read.
                let step = 1usize << octave;
                let wide = columns.start * step..(columns.end - 1) * step + 1;
                stacked.resize(wide.len(), 0.0);
                let mut row = vec![0.0; columns.len()];
                for v in rows {
                    stack_row(frames, offsets, v * step, wide.clone(), stacked);
                    row.iter_mut().zip(stacked.chunks(step)).for_each(|(out, chunk)| *out = chunk[0]);
                    write(v, &row);
                }
            }
        }
    }
}

/// Filters of an octave, which know its borders.
#[derive(Debug)]
pub struct OctaveFilters {
    along_u: Axis,
    along_v: Axis,
    /// Index of the level from which the next octave starts, among those that are made.
    next: Option<usize>,
}

impl OctaveFilters {
    /// Filters for an octave of `size`; `bank` ([`ScaleSpace::bank`]) makes the level indices `levels` (0 is level −1).
    pub fn new(space: &ScaleSpace, bank: &FilterBank, levels: &Range<usize>, size: (usize, usize)) -> Self {
        let next = levels.contains(&space.levels).then(|| space.levels - levels.start);
        Self { along_u: bank.axis(size.0), along_v: bank.axis(size.1), next }
    }

    /// Pixels that the values of `region` depend on.
    pub fn inputs(&self, region: &Region) -> Region {
        Region { columns: self.along_u.inputs(&region.columns), rows: self.along_v.inputs(&region.rows) }
    }
}

/// Tile of the differences of consecutive Gaussian levels of one slope. In a search index 0 is DoG level −1.
#[derive(Debug, Default)]
pub struct DogTile {
    /// One tile a level.
    pub levels: Vec<Tile>,
}

impl DogTile {
    /// D at DoG level index `level_index` and the octave's pixel (x, y).
    #[inline]
    pub fn at(&self, level_index: usize, x: usize, y: usize) -> f32 {
        self.levels[level_index].at(x, y)
    }
}

/// Pixels of one slope at the octave's resolution, before any of its filters.
#[derive(Debug, Clone, Copy)]
pub enum Pixels<'a> {
    /// A stacked tile with the pixels that the filters need.
    Stacked(&'a Tile),
    /// The octave's first level.
    Level(&'a Plane),
}

/// Filters `region` of an octave into `dog`, and into `next` the next octave's start; `batch_done` gets finished rows.
pub fn dog_tile(
    filters: &OctaveFilters,
    pixels: Pixels<'_>,
    region: &Region,
    scratch: &mut FilterScratch,
    dog: &mut DogTile,
    next: Option<&mut Tile>,
    batch_done: &mut dyn FnMut(&[Tile], Range<usize>),
) {
    dog.levels.resize_with(filters.along_u.levels.len() - 1, Tile::default);
    let axes = (&filters.along_u, &filters.along_v);
    let keep = next.map(|tile| (filters.next.expect("the level is among those made"), tile));
    match pixels {
        Pixels::Stacked(tile) => filter_tile(axes, tile, region, scratch, &mut dog.levels, keep, batch_done),
        Pixels::Level(plane) => filter_tile(axes, plane, region, scratch, &mut dog.levels, keep, batch_done),
    }
}

/// Number of extra columns in a stacked row, so that filters read whole vectors in place.
const PADDING: usize = 32;

/// Stacks `slopes` (the frames' offsets) at the resolution of `octave`, in `region`: one tile a slope.
pub fn stack_tiles(
    frames: &[&Plane],
    slopes: &[impl AsRef<[FrameOffset]>],
    octave: i32,
    region: &Region,
    tiles: &mut Vec<Tile>,
) {
    tiles.resize_with(slopes.len().max(tiles.len()), Tile::default);
    let stride = (region.columns.len() + PADDING).next_multiple_of(16);
    tiles.iter_mut().take(slopes.len()).for_each(|tile| tile.reset(region, stride));
    // Without a change of resolution all slopes share each row of the frames while it is cached.
    if octave == 0 {
        let mut stacker = RowStacker::new(frames, slopes.iter().map(AsRef::as_ref).collect());
        for first in region.rows.clone().step_by(STACKED_ROWS) {
            let rows = first..(first + STACKED_ROWS).min(region.rows.end);
            let part = |tile| Tile::rows_from_mut(tile, first, rows.len());
            let mut outs: Vec<&mut [f32]> = tiles[..slopes.len()].iter_mut().map(part).collect();
            stacker.rows(rows.clone(), &region.columns, &mut outs, stride);
        }
        return;
    }
    let mut stacked = Vec::new();
    for (offsets, tile) in slopes.iter().zip(tiles) {
        let base = Base::Frames { frames, offsets: offsets.as_ref(), octave };
        base.raw_rows(region.rows.clone(), region.columns.clone(), &mut stacked, |v, row| {
            tile.row_mut(v).copy_from_slice(row);
        });
    }
}

/// Rows of the stacked image doubled by linear interpolation; the last pixel is repeated.
fn doubled_rows(
    frames: &[&Plane],
    offsets: &[FrameOffset],
    rows: Range<usize>,
    columns: Range<usize>,
    stacked: &mut Vec<f32>,
    mut write: impl FnMut(usize, &[f32]),
) {
    let (width, height) = frames[0].size();
    let narrow = columns.start / 2..((columns.end - 1) / 2 + 2).min(width);
    let n = narrow.len();
    stacked.resize(n, 0.0);
    let double = |v: usize, stacked: &mut [f32], out: &mut [f32]| {
        stack_row(frames, offsets, v.min(height - 1), narrow.clone(), stacked);
        for (out, x) in out.iter_mut().zip(columns.clone()) {
            let i = x / 2 - narrow.start;
            *out = if x % 2 == 0 { stacked[i] } else { 0.5 * (stacked[i] + stacked[(i + 1).min(n - 1)]) };
        }
    };
    let (mut upper, mut lower, mut middle) =
        (vec![0.0; columns.len()], vec![0.0; columns.len()], vec![0.0; columns.len()]);
    // A doubled row is needed up to three times: as upper, as lower, and for the row between.
    let mut upper_is = None;
    for v in rows {
        let i = v / 2;
        if upper_is != Some(i) {
            if upper_is.is_some_and(|held| held + 1 == i) && v % 2 == 0 {
                std::mem::swap(&mut upper, &mut lower);
            } else {
                double(i, stacked, &mut upper);
            }
            upper_is = Some(i);
        }
        if v % 2 == 0 {
            write(v, &upper);
        } else {
            double(i + 1, stacked, &mut lower);
            middle.iter_mut().zip(&upper).zip(&lower).for_each(|((out, a), b)| *out = 0.5 * (a + b));
            write(v, &middle);
        }
    }
}
