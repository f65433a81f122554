//! Noise at each level of the search relative to white noise, measured with the search's own filters.
//!
//! Correlated noise leaves more at coarse levels than white noise, and noise that files round away less at fine ones.
//! So contrasts of frames are filtered as in the search, in tiles spread over the image. The tails are measured too:
//! JPEG files keep few coefficients, whose noise is rare and strong. Structures with several motions do not cancel
//! everywhere, and can only add: where tiles differ more than noise does, their quiet part is taken, at most what finer
//! levels predict. Without this `correlated` has 12 991 false features a megapixel, not 6.

use super::contrast::{Contrast, Pixels as Source, SceneMotion, shifts};
use super::high_pass::{quantile, quiet_variance, sorted, spread};
use crate::burst::{Offset, Positions};
use crate::detector::noise::{dog_energy, dog_noise_variance};
use crate::detector::params::{Interpolation, Slope};
use crate::detector::scale_space::{
    DogTile, OctaveFilters, Pixels, SIGMA_BASE, SIGMA_INPUT, ScaleSpace, dog_tile, octave_pixel, octave_size,
};
use crate::detector::stack::frame_offsets;
use crate::kernel::gaussian_bank::{FilterBank, FilterScratch};
use crate::monitor::{Cancelled, Monitor};
use crate::plane::Plane;
use crate::plane::blur::GaussianKernel;
use crate::plane::tile::{Region, Tile};
use rayon::prelude::*;
use serde::Serialize;
use std::ops::Range;

/// Noise of one DoG level.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LevelNoise {
    /// Variance of D over that of white noise; the finer level's where no tile is measured.
    pub over_white: f32,
    /// Excess kurtosis of D in one frame: 0 for a normal distribution.
    pub excess_kurtosis: f32,
    /// Standard error of `over_white`: 0 where a codec flattened blocks, ∞ where structures may be a part of it.
    #[serde(skip)]
    pub(super) error: f32,
}

impl LevelNoise {
    pub(super) const WHITE: Self = Self { over_white: 1.0, excess_kurtosis: 0.0, error: 0.0 };
}

/// Spread of tiles, relative to that of noise, above which some hold moving structures.
const NOISE_SPREAD: f32 = 2.5;
/// Distance of a tile from their middle, in errors of a tile, beyond which it counts no further.
const OUTLYING: f32 = 4.0;
/// Spread of the first level's tiles up to which what all have more than twice of is noise: structures differ more.
const EVEN: f32 = 0.4;
/// Number of tiles, and deviation of the logarithm of their noise, from which a fall with its strength is sought.
const MIN_ALONG: usize = 8;
const MIN_ACROSS: f32 = 0.3;
/// Deviation of the logarithm of tiles from the fall up to which they are noise, and errors of it that are significant.
const EVEN_ALONG: f32 = 0.3;
const SURE: f32 = 4.0;
/// Variance relative to white noise below which it is only rounding.
const MIN_OVER_WHITE: f32 = 0.02;
/// Upper bound of the kurtosis: that of JPEG files of low quality.
const MAX_KURTOSIS: f32 = 8.0;
/// Number of independent values in a tile below which the kurtosis is derived from the finer level's.
const FREE_FOR_KURTOSIS: f32 = 40.0;
/// Kurtosis up to which noise counts as normal, and largest standard error of a measured kurtosis.
const MIN_KURTOSIS: f32 = 0.3;
/// Standard errors of a mean of tiles that a kurtosis must exceed: their quartile has 1.4 times its error.
const SURE_OF_TAILS: f32 = 5.0;
/// Kurtosis of one frame relative to that of a combination of frames with weights 1, −2, 1, or 1, −1.
const OF_ONE_FRAME: f32 = 2.0;

pub fn measure(
    sources: Sources<'_>,
    space: &ScaleSpace,
    octaves: Range<i32>,
    monitor: &Monitor,
) -> Result<Vec<Vec<LevelNoise>>, Cancelled> {
    let of_octave = |octave| tiles_of_octave(sources, space, octave, monitor);
    let per_octave: Vec<Vec<TileMoments>> = octaves.into_par_iter().map(of_octave).collect::<Result<_, Cancelled>>()?;
    let (mut before, mut differs): (Option<LevelNoise>, bool) = (None, sources.differs);
    let mut of_level = |tiles: &[TileMoments], level: usize| {
        let found = match sources.are_flattened {
            true => rare_noise(tiles, level),
            false => noise_at(tiles, level, space, before, &mut differs),
        };
        let noise = found.or(before).unwrap_or(LevelNoise::WHITE);
        before = Some(noise);
        noise
    };
    let of_octave = |tiles: Vec<TileMoments>| (0..space.levels).map(|level| of_level(&tiles, level)).collect();
    let mut levels: Vec<Vec<LevelNoise>> = per_octave.into_iter().map(of_octave).collect();
    // Files show at the finest level first; long tails at coarser levels alone come from moving structures.
    let no_tails = levels.iter().flatten().next().is_some_and(|finest| finest.excess_kurtosis == 0.0);
    if !sources.are_flattened && no_tails {
        levels.iter_mut().flatten().for_each(|level| level.excess_kurtosis = 0.0);
    }
    Ok(levels)
}

/// Noise of a level. It `differs` by strength where it does at all finer levels: structures that coarse levels alone
/// show may fall with the noise too.
fn noise_at(
    tiles: &[TileMoments],
    level: usize,
    space: &ScaleSpace,
    before: Option<LevelNoise>,
    differs: &mut bool,
) -> Option<LevelNoise> {
    let sigma = space.sigma_octave(level as f64) as f32;
    let mean_pixels = tiles.iter().map(|t| t.pixels).sum::<usize>() as f32 / tiles.len().max(1) as f32;
    // D at a level is correlated over about 4σ² pixels (Σρ² of its autocorrelation).
    let free = (mean_pixels / (4.0 * sigma * sigma)).max(2.0);
    let variances: Vec<f32> = tiles.iter().map(|t| t.levels[level].0).filter(|v| v.is_finite()).collect();
    if variances.is_empty() {
        return None;
    }
    // Files act alike everywhere: the lower quartile of the tiles, corrected to the median expected of noise alone.
    let of_one_tile = (24.0 / free).sqrt();
    let kurtosis = quantile(&sorted(tiles.iter().map(|t| t.levels[level].1).collect()), 0.25) + 0.674 * of_one_tile;
    // A sample's kurtosis is too low by about 6 over its number of independent values.
    let of_pair = kurtosis + 6.0 / free;
    let of_kurtosis = of_one_tile / (variances.len() as f32).sqrt();
    let kurtosis = if free < FREE_FOR_KURTOSIS || of_kurtosis > MIN_KURTOSIS {
        // The larger a filter, the more coefficients of a file it sums, and the closer the sum is to normal.
        before.map_or(0.0, |noise| noise.excess_kurtosis) * 4f32.powf(-1.0 / space.levels as f32)
    } else if of_pair < MIN_KURTOSIS.max(SURE_OF_TAILS * of_kurtosis) {
        0.0
    } else {
        (OF_ONE_FRAME * of_pair).min(MAX_KURTOSIS)
    };
    let ordered = sorted(variances.clone());
    let middle = quantile(&ordered, 0.5);
    let of_noise = ((2.0 + of_pair.clamp(0.0, MAX_KURTOSIS)) / free).sqrt();
    let own_error = of_noise / (variances.len() as f32).sqrt();
    // Once tiles differ by structure or place, coarser levels have too few of them to separate that from noise.
    let error = before.filter(|noise| noise.error.is_infinite()).map_or(own_error, |noise| noise.error);
    let quiet = quiet_variance(variances.clone(), free);
    let is_even = before.is_none() && spread(&ordered) <= EVEN && quiet > 2.0;
    let of_weakest = differs.then(|| by_strength(tiles, level, of_noise)).flatten();
    *differs &= of_weakest.is_some();
    if let Some(over_white) = of_weakest.filter(|of_weakest| *of_weakest > 1.0) {
        return Some(LevelNoise { over_white, excess_kurtosis: kurtosis, error });
    }
    if !is_even && spread(&ordered) > NOISE_SPREAD * of_noise {
        let expected = before.map_or(1.0, |noise| noise.over_white);
        // Tiles also differ by their brightness: the quiet ones do not lower the estimate below the median of all.
        let quiet = quiet.max(middle.min(expected));
        let over_white = quiet.min(expected.max(1.0));
        return Some(LevelNoise { over_white, excess_kurtosis: 0.0, error: f32::INFINITY });
    }
    // A few tiles may hold a thing that does not cancel, such as a star on a quiet ground.
    let most = middle * (1.0 + OUTLYING * of_noise);
    let mean = variances.iter().map(|variance| variance.min(most)).sum::<f32>() / variances.len() as f32;
    // A difference below its own error is taken for 0, and a larger one is shrunk in proportion (James–Stein).
    let off = mean - 1.0;
    let trust = if off == 0.0 { 0.0 } else { (1.0 - (own_error / off).powi(2)).max(0.0) };
    Some(LevelNoise { over_white: (1.0 + off * trust).max(MIN_OVER_WHITE), excess_kurtosis: kurtosis, error })
}

/// Variance relative to white noise of the weakest noise, if it falls with the noise's strength and differs little from
/// that fall: a codec rounds weak noise to few coarse coefficients. Structures differ from tile to tile.
fn by_strength(tiles: &[TileMoments], level: usize, of_noise: f32) -> Option<f32> {
    let log = |tile: &TileMoments| (tile.variance.ln(), tile.levels[level].0.ln());
    let logs: Vec<(f32, f32)> = tiles.iter().map(log).filter(|(x, y)| x.is_finite() && y.is_finite()).collect();
    if logs.len() < MIN_ALONG {
        return None;
    }
    let mean = |of: &dyn Fn(&(f32, f32)) -> f32| logs.iter().map(of).sum::<f32>() / logs.len() as f32;
    let (x, y) = (mean(&|at| at.0), mean(&|at| at.1));
    let (across, both) = (mean(&|at| (at.0 - x).powi(2)), mean(&|at| (at.0 - x) * (at.1 - y)));
    let slope = both / across;
    let left = mean(&|at| (at.1 - y - slope * (at.0 - x)).powi(2)).sqrt();
    let weakest = quantile(&sorted(logs.iter().map(|at| at.0).collect()), 0.1) - x;
    let falls = slope * across.sqrt() < -SURE * left / (logs.len() as f32).sqrt();
    let falls = falls && across.sqrt() > MIN_ACROSS && left <= EVEN_ALONG.max(1.5 * of_noise);
    falls.then(|| (y + slope * weakest).exp())
}

/// Noise of a level from the mean of all tiles, where a codec made it rare. `None` where there is no tile.
fn rare_noise(tiles: &[TileMoments], level: usize) -> Option<LevelNoise> {
    let mean = |of: fn((f32, f32)) -> f32| {
        tiles.iter().map(|tile| f64::from(of(tile.levels[level]))).sum::<f64>() / tiles.len() as f64
    };
    let second = mean(|(second, _)| second);
    if tiles.is_empty() || second <= 0.0 {
        return None;
    }
    let fourth = mean(|(second, kurtosis)| second * second * (kurtosis + 3.0));
    let of_pair = (fourth / (second * second) - 3.0) as f32;
    Some(LevelNoise { over_white: second as f32, excess_kurtosis: OF_ONE_FRAME * of_pair.max(0.0), error: 0.0 })
}

/// Side of a tile of the first octave, octave pixels.
const TILE: usize = 64;
/// Side of a tile of later octaves, octave pixels. Both are halved in octaves with fewer than [`MIN_TILES`] tiles.
const COARSE_TILE: usize = 48;
/// Number of tiles that an octave should have to separate moving structures from noise.
const MIN_TILES: usize = 6;
/// Number of pixels of the first octave that are measured, about, for an error of three percent.
const PIXELS: usize = 32_768;
/// Number of pixels of octaves after the first, about; these have less noise.
const COARSE_PIXELS: usize = 24_000;
/// Ratio of the numbers of pixels that are measured where noise is rare or differs by place, and elsewhere.
const FOR_RARE: usize = 8;
/// Number of octaves that are measured: in coarser ones the scene is far stronger than the noise.
const OCTAVES: i32 = 3;
/// Border of the image that is left out, octave pixels: filters that repeat the border let more noise pass there.
const BORDER: usize = 8;
/// Side, inside the border, below which an octave is not measured, octave pixels.
const MIN_SIDE: usize = 16;

#[derive(Clone, Copy)]
pub struct Sources<'a> {
    /// Kept frames, cleaned, in time order; at least two.
    pub frames: &'a [&'a Plane],
    pub contrasts: &'a [Contrast],
    /// Variance of the noise in each contrast, relative to the mean of all.
    pub relative: &'a [f32],
    /// Pyramids of the frames, as far as the octaves that are searched, and the scene's motion in them.
    pub motion: SceneMotion<'a>,
    /// Variance of the white noise of one frame in a region of the image, (fraction of full scale)².
    pub variance_in: &'a (dyn Fn(&Region) -> f32 + Sync),
    /// Whether a codec flattened most of the blocks, so that what is left of the noise is rare.
    pub are_flattened: bool,
    /// Whether the noise differs by place, and its correlation may too.
    pub differs: bool,
}

#[derive(Debug, Clone)]
pub struct TileMoments {
    pub pixels: usize,
    /// Variance of one frame's white noise there, (fraction of full scale)².
    pub variance: f32,
    /// Mean square relative to that of white noise, and excess kurtosis, by level.
    pub levels: Vec<(f32, f32)>,
}

/// Moments of tiles spread over the image; none where the octave is too small or coarse, or made of skipped pixels.
pub fn tiles_of_octave(
    sources: Sources<'_>,
    space: &ScaleSpace,
    octave: i32,
    monitor: &Monitor,
) -> Result<Vec<TileMoments>, Cancelled> {
    monitor.check()?;
    let is_first = octave == space.first_octave;
    let is_skipped = space.skip() > 1;
    // If the first octave skips pixels, its noise is white for the octaves after it.
    if (is_skipped && !is_first) || octave - space.first_octave >= OCTAVES {
        return Ok(Vec::new());
    }
    // Binned octaves and those after the first read means over squares; the base kernel accounts for their blur.
    let first = is_first && !space.bins();
    let halvings = if is_skipped { 0 } else { octave.max(0) as usize };
    let pyramids = sources.motion.pyramids;
    let (size, source) = if first || halvings == 0 {
        (octave_size(sources.frames[0].size(), octave), Source::Frames(sources.frames, octave))
    } else {
        (pyramids[0].level(halvings).size(), Source::Squares(pyramids, halvings))
    };
    let (tile, wanted) = if is_first { (TILE, PIXELS) } else { (COARSE_TILE, COARSE_PIXELS) };
    let wanted = wanted * if sources.are_flattened || sources.differs { FOR_RARE } else { 1 };
    let frames = sources.frames;
    let hidden = |region: &Region| frames.iter().any(|frame| frame.hides(&in_image(region, octave)));
    let mut regions = regions(size, tile, wanted);
    regions.retain(|region| !hidden(region));
    if regions.is_empty() {
        return Ok(Vec::new());
    }
    let means = OfMeans::new(space, halvings);
    let bank = if first { space.bank(true, space.all_levels()) } else { means.bank(space) };
    let filters = OctaveFilters::new(space, &bank, &space.all_levels(), size);
    let motion = sources.motion.for_octave(octave);
    let contrasts = sources.contrasts;
    let pixels: usize = regions.iter().map(|r| r.columns.len() * r.rows.len()).sum();
    // A small octave uses more contrasts at each tile, to reach as many values.
    let rounds = (wanted / pixels.max(1)).clamp(1, contrasts.len());
    let one_frame = frame_offsets(&Positions::even(1), Slope::default(), Interpolation::Linear);
    let white = |level: f64| {
        if first { dog_noise_variance(space, octave, level, &one_frame) } else { means.white(space, level) }
    };
    let white: Vec<f64> = (0..space.levels).map(|level| white(level as f64)).collect();
    let look_at = |(index, region): (usize, &Region), scratch: &mut Scratch| {
        monitor.check()?;
        let in_image = in_image(region, octave);
        let variance = (sources.variance_in)(&in_image);
        let of_region = motion.slope_in(&in_image);
        let of_round = |round: usize| {
            // The next tile starts with the next contrast, so that all frames take part.
            let which = (index + round) % contrasts.len();
            let (contrast, variance) = (&contrasts[which], variance * sources.relative[which]);
            let is_seen = is_seen_along(frames, contrast, sources.motion.offsets, of_region, &in_image);
            // Where a mask hides the moved structure, frames are compared in place.
            let slope = if is_seen { of_region } else { Slope::default() };
            let Scratch { filter, dog, single, input } = &mut *scratch;
            source.contrast((contrast, sources.motion.offsets, slope), &filters.inputs(region), (&mut *input, single));
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

fn is_seen_along(frames: &[&Plane], contrast: &Contrast, offsets: &[Offset<f32>], slope: Slope, part: &Region) -> bool {
    let shifts = shifts(contrast, offsets, slope, (&part.columns, &part.rows), frames[0].size());
    let moved = |range: &Range<usize>, by: i64| {
        let to = |at: usize| at.saturating_add_signed(by as isize);
        to(range.start)..to(range.end)
    };
    contrast.iter().zip(shifts).all(|(&(t, _), (du, dv))| {
        !frames[t].hides(&Region { columns: moved(&part.columns, du), rows: moved(&part.rows, dv) })
    })
}

#[derive(Default)]
struct Scratch {
    filter: FilterScratch,
    dog: DogTile,
    single: Vec<Tile>,
    input: Tile,
}

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
    if columns.len().min(rows.len()) < MIN_SIDE {
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
            // Columns are shifted from row to row, so that no column of tiles is preferred.
            let column = if count < all { (index + 3 * row) % columns.len() } else { index % columns.len() };
            Region { columns: columns[column].clone(), rows: rows[row].clone() }
        })
        .collect()
}

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

    /// Variance in D at `level` of white noise of variance 1 in a frame: means of white noise are white.
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
            // In units of the expected deviation: fourth powers stay within the range of f32.
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
    TileMoments { pixels, variance: frame, levels: white.iter().enumerate().map(of_level).collect() }
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
