//! Noise of single tiles of an octave, filtered as in the search.

use super::contrast::{Contrast, Pixels as Source};
use super::pyramid::BoxPyramid;
use super::scene_motion::SceneMotion;
use crate::detector::noise::gate::{dog_energy, dog_noise_variance};
use crate::detector::params::Interpolation;
use crate::detector::params::slope_grid::Slope;
use crate::detector::scale_space::levels::{SIGMA_BASE, SIGMA_INPUT, ScaleSpace, octave_pixel, octave_size};
use crate::detector::scale_space::octave::{DogTile, OctaveFilters, Pixels, dog_tile};
use crate::detector::stack::offsets::frame_offsets;
use crate::kernel::gaussian_bank::{FilterBank, FilterScratch};
use crate::monitor::{Cancelled, Monitor};
use crate::plane::Plane;
use crate::plane::blur::GaussianKernel;
use crate::plane::tile::{Region, Tile};
use rayon::prelude::*;
use std::ops::Range;

/// Side of a tile of the first octave, octave pixels.
const TILE: usize = 64;
/// Side of a tile of later octaves, octave pixels. Both are halved in octaves with fewer than [`MIN_TILES`] tiles.
const COARSE_TILE: usize = 48;
/// Number of tiles that an octave should have, to tell moving structures from noise.
const MIN_TILES: usize = 6;
/// Number of pixels of the first octave that are measured, about: a standard deviation then has an error of three
/// percent.
const PIXELS: usize = 32_768;
/// Number of pixels of octaves after the first, about; these have less noise.
const COARSE_PIXELS: usize = 24_000;
/// Number of octaves that are measured, from the first one searched. Noise correlated over the distances of coarser
/// octaves is rare, and there the scene is far stronger than the noise.
const OCTAVES: i32 = 3;
/// Border of the image that is left out, octave pixels: filters that repeat the border let more noise pass there.
const BORDER: usize = 8;
/// Side, inside the border, below which an octave is not measured, octave pixels.
const LEAST_SIDE: usize = 16;

/// Frames to measure, with their contrasts and motion.
#[derive(Clone, Copy)]
pub struct Sources<'a> {
    /// Frames that take part, cleaned, in time order; at least two.
    pub frames: &'a [&'a Plane],
    /// Contrasts of the frames.
    pub contrasts: &'a [Contrast],
    /// Pyramids of the frames, as far as the octaves that are searched, and the scene's motion in them.
    pub motion: SceneMotion<'a>,
    /// Variance of the white noise of one frame in a region of the image, in (fraction of full scale)².
    pub variance_in: &'a (dyn Fn(&Region) -> f32 + Sync),
}

impl<'a> Sources<'a> {
    fn pyramids(&self) -> &'a [&'a BoxPyramid] {
        self.motion.pyramids
    }
}

/// Second and fourth moments of the levels of one tile.
#[derive(Debug, Clone)]
pub struct TileMoments {
    /// Number of pixels.
    pub pixels: usize,
    /// Mean square relative to that of white noise, and excess kurtosis, by level.
    pub levels: Vec<(f32, f32)>,
}

/// Moments of tiles of `octave` of `space`, spread over the image; none where the octave is too small, too coarse, or
/// made of skipped pixels.
///
/// # Errors
/// [`Cancelled`] once `monitor` was cancelled.
pub fn tiles_of_octave(
    sources: Sources<'_>,
    space: &ScaleSpace,
    octave: i32,
    monitor: &Monitor,
) -> Result<Vec<TileMoments>, Cancelled> {
    let first = octave == space.first_octave;
    // Where the first octave skips pixels, its noise is white for the octaves after it.
    if (space.first_octave > 0 && !first) || octave - space.first_octave >= OCTAVES {
        return Ok(Vec::new());
    }
    // Octaves after the first are made from means over squares; the base kernel accounts for their blur.
    let halvings = (octave - space.first_octave.max(0)).max(0) as usize;
    let (size, source) = if first || halvings == 0 {
        (octave_size(sources.frames[0].size(), octave), Source::Frames(sources.frames, octave))
    } else {
        (sources.pyramids()[0].level(halvings).size(), Source::Squares(sources.pyramids(), halvings))
    };
    let (tile, wanted) = if first { (TILE, PIXELS) } else { (COARSE_TILE, COARSE_PIXELS) };
    let regions = regions(size, tile, wanted);
    if regions.is_empty() {
        return Ok(Vec::new());
    }
    let means = OfMeans::new(space, halvings);
    let bank = if first { space.bank(true, space.all_levels()) } else { means.bank(space) };
    let filters = OctaveFilters::new(space, &bank, &space.all_levels(), size);
    let motion = sources.motion.for_octave(octave);
    let contrasts = sources.contrasts;
    let pixels: usize = regions.iter().map(|r| r.columns.len() * r.rows.len()).sum();
    let rounds = (wanted / pixels.max(1)).clamp(1, contrasts.len());
    let one_frame = frame_offsets(1, Slope::default(), Interpolation::Linear);
    let white = |level: f64| {
        if first { dog_noise_variance(space, octave, level, &one_frame) } else { means.white(space, level) }
    };
    let white: Vec<f64> = (0..space.levels).map(|level| white(level as f64)).collect();
    let look_at = |(index, region): (usize, &Region), scratch: &mut Scratch| {
        monitor.check()?;
        let in_image = in_image(region, octave);
        let variance = (sources.variance_in)(&in_image);
        let slope = motion.slope_in(&in_image);
        let of_round = |round: usize| {
            let contrast = &contrasts[(index + round) % contrasts.len()];
            let Scratch { filter, dog, single, input } = &mut *scratch;
            source.contrast((contrast, sources.motion.times, slope), &filters.inputs(region), (&mut *input, single));
            dog_tile(&filters, Pixels::Stacked(input), region, filter, dog, None, &mut |_, _| ());
            moments(dog, region, &white, variance)
        };
        Ok((0..rounds).map(of_round).collect::<Vec<_>>())
    };
    let tiles: Vec<Vec<TileMoments>> = regions
        .par_iter()
        .enumerate()
        .map_init(Scratch::default, |scratch, at| look_at(at, scratch))
        .collect::<Result<_, Cancelled>>()?;
    Ok(tiles.concat())
}

/// Buffers of a thread.
#[derive(Default)]
struct Scratch {
    filter: FilterScratch,
    dog: DogTile,
    single: Vec<Tile>,
    input: Tile,
}

/// Part of the image that a region of an octave covers.
fn in_image(region: &Region, octave: i32) -> Region {
    let in_image = |range: &Range<usize>| {
        let image = |at: usize| (at as f32 * octave_pixel(octave)) as usize;
        image(range.start)..image(range.end).max(image(range.start) + 1)
    };
    Region { columns: in_image(&region.columns), rows: in_image(&region.rows) }
}

/// Tiles of an octave of `size` to measure, of `tile` pixels a side and about `pixels` pixels together.
fn regions((width, height): (usize, usize), tile: usize, pixels: usize) -> Vec<Region> {
    let inner = |n: usize| BORDER..n.saturating_sub(BORDER).max(BORDER);
    let (columns, rows) = (inner(width), inner(height));
    if columns.len().min(rows.len()) < LEAST_SIDE {
        return Vec::new();
    }
    let many = (columns.len() / tile) * (rows.len() / tile) >= MIN_TILES;
    let tile = if many { tile } else { tile / 2 };
    let cut = |range: &Range<usize>| -> Vec<Range<usize>> {
        // Tiles cover the range from end to end, and overlap a little where its length is no multiple of theirs.
        let (count, last) = (range.len().div_ceil(tile), range.len().saturating_sub(tile));
        (0..count)
            .map(|i| {
                let start = range.start + i * last / (count - 1).max(1);
                start..(start + tile).min(range.end)
            })
            .collect()
    };
    let (columns, rows) = (cut(&columns), cut(&rows));
    let all = columns.len() * rows.len();
    let count = all.min((pixels / (tile * tile)).max(1));
    (0..count)
        .map(|i| {
            let index = i * all / count;
            let row = index / columns.len();
            // Shifted from row to row, so that no column of tiles is preferred.
            let column = if count < all { (index + 3 * row) % columns.len() } else { index % columns.len() };
            Region { columns: columns[column].clone(), rows: rows[row].clone() }
        })
        .collect()
}

/// An octave that starts from means over squares of 2^halvings pixels.
struct OfMeans {
    /// Blur that the means already have, which the base kernel leaves out, octave pixels².
    blurred: f64,
    /// Variance of a mean of white noise of variance 1.
    variance: f64,
}

impl OfMeans {
    fn new(space: &ScaleSpace, halvings: usize) -> Self {
        let squares = 4f64.powi(halvings as i32);
        let doubling = if space.first_octave < 0 { 0.125 } else { 0.0 };
        let of_means = (squares - 1.0) / 12.0;
        Self { blurred: (SIGMA_INPUT * SIGMA_INPUT + of_means - doubling) / squares, variance: 1.0 / squares }
    }

    fn bank(&self, space: &ScaleSpace) -> FilterBank {
        let base = GaussianKernel::with_cut((SIGMA_BASE * SIGMA_BASE - self.blurred).sqrt(), space.kernel_cut);
        FilterBank::new(std::iter::once(base).chain(space.step_kernels.iter().cloned()).collect(), space.all_levels())
    }

    /// Variance in D at `level` of white noise of variance 1 in a frame: means of white noise are white, whatever their
    /// blur.
    fn white(&self, space: &ScaleSpace, level: f64) -> f64 {
        let variance = |level: f64| space.sigma_octave(level).powi(2) - self.blurred;
        self.variance * dog_energy(variance(level), variance(level + 1.0))
    }
}

fn moments(dog: &DogTile, region: &Region, white: &[f64], frame: f32) -> TileMoments {
    let pixels = region.columns.len() * region.rows.len();
    let of_level = |(index, white): (usize, &f64)| {
        let (mut second, mut fourth) = (0.0f64, 0.0f64);
        for v in region.rows.clone() {
            let (mut row_second, mut row_fourth) = (0.0f32, 0.0f32);
            // In units of the expected deviation, so that fourth powers stay within the range of f32.
            let scale = 1.0 / (f64::from(frame.max(f32::MIN_POSITIVE)) * white).sqrt() as f32;
            for x in dog.levels[index + 1].row(v) {
                let square = (x * scale) * (x * scale);
                row_second += square;
                row_fourth += square * square;
            }
            second += f64::from(row_second);
            fourth += f64::from(row_fourth);
        }
        let (second, fourth) = (second / pixels as f64, fourth / pixels as f64);
        (second as f32, if second > 0.0 { (fourth / (second * second) - 3.0) as f32 } else { 0.0 })
    };
    TileMoments { pixels, levels: white.iter().enumerate().map(of_level).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_lie_inside_and_small_octaves_have_none() {
        for size in [(800, 600), (200, 150), (60, 40), (33, 32)] {
            let regions = regions(size, TILE, PIXELS);
            assert!(!regions.is_empty());
            for region in regions {
                assert!(region.columns.start >= BORDER && region.columns.end + BORDER <= size.0, "{region:?}");
                assert!(region.rows.start >= BORDER && region.rows.end + BORDER <= size.1, "{region:?}");
            }
        }
        assert!(regions((31, 200), TILE, PIXELS).is_empty() && regions((3, 3), TILE, PIXELS).is_empty());
    }
}
