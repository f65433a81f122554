//! How much of the noise each level of the search lets through, measured with the search's own filters.
//!
//! White noise would leave in D what the filters' energy says. Noise that neighbouring pixels share (from demosaicing, scaling, JPEG) leaves more at coarse levels, and
//! noise that files round away leaves less at fine ones. So differences of frames, in which the scene cancels, are filtered at each octave as in the search, in tiles
//! spread over the image, and the variance is compared with white noise's. The tails are measured too: JPEG files keep few coefficients, so that their noise is seldom and
//! strong, and exceeds five standard deviations more often than a normal distribution does.
//!
//! What moves does not cancel, and can only add. Where the tiles differ among themselves more than noise does, their quiet part is taken, and never more than the
//! finer levels, where the scene shows least, let expect.

use super::frames::median;
use super::high_pass::quiet_variance;
use super::pyramid::BoxPyramid;
use crate::detector::motion::{FrameOffset, frame_offsets};
use crate::detector::noise::dog_noise_variance;
use crate::detector::octave::{DogTile, OctaveFilters, Pixels, dog_tile, stack_tiles};
use crate::detector::params::Interpolation;
use crate::detector::scale_space::{SIGMA_BASE, SIGMA_INPUT, ScaleSpace, octave_pixel, octave_size};
use crate::detector::slope_grid::Slope;
use crate::monitor::{Cancelled, Monitor};
use crate::plane::Plane;
use crate::plane::bank::{FilterBank, FilterScratch};
use crate::plane::blur::GaussianKernel;
use crate::plane::tile::{Region, Tile};
use rayon::prelude::*;
use serde::Serialize;
use std::ops::Range;

/// What one level lets through.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LevelNoise {
    /// Variance of D over that of white noise.
    pub over_white: f32,
    /// Excess kurtosis of D in one frame: 0 for a normal distribution.
    pub excess_kurtosis: f32,
}

impl LevelNoise {
    /// White noise.
    pub const WHITE: Self = Self { over_white: 1.0, excess_kurtosis: 0.0 };
}

/// Side of a tile, octave pixels; half of it in octaves that hold fewer than [`MIN_TILES`].
const TILE: usize = 64;
/// Tiles that an octave should have, to tell what moves from noise.
const MIN_TILES: usize = 6;
/// Pixels of the first octave that are looked at, about: a standard deviation is then right within two percent.
const PIXELS: usize = 50_000;
/// The same of octaves after the first, which have less noise to let through.
const COARSE_PIXELS: usize = 25_000;
/// Pixels at the image's border that are left out, if there are enough, octave pixels.
const BORDER: usize = 8;
/// Tiles that differ more than this many times what noise does hold something that moves.
const NOISE_SPREAD: f32 = 2.5;
/// Less noise than this is rounding.
const LEAST_OVER_WHITE: f32 = 0.02;
/// Kurtosis that is believed at most: that of JPEG files of low quality.
const MAX_KURTOSIS: f32 = 8.0;
/// Fewer independent values in a tile, and too many tiles with few, tell nothing of the tails; then the finer level speaks for the coarser.
const FREE_FOR_KURTOSIS: f32 = 40.0;
/// Less is not told from none.
const LEAST_KURTOSIS: f32 = 0.3;
/// A combination of frames with weights 1, −2, 1, or 1, −1, has half the kurtosis of one frame.
const OF_ONE_FRAME: f32 = 2.0;

/// The frames that are looked at.
#[derive(Clone, Copy)]
pub struct Sources<'a> {
    /// The frames that take part, cleaned, in time order; two at least.
    pub frames: &'a [&'a Plane],
    /// Their pyramids, which reach as far as the octaves that are searched.
    pub pyramids: &'a [&'a BoxPyramid],
    /// The variance of white noise in one frame in a region of the image, in (fraction of full scale)².
    pub variance_in: &'a (dyn Fn(&Region) -> f32 + Sync),
}

/// The levels 0 … S−1 of the octaves `octaves` of `space`.
///
/// # Errors
/// [`Cancelled`] once `monitor` was cancelled.
pub fn measure(
    sources: Sources<'_>,
    space: &ScaleSpace,
    octaves: Range<i32>,
    monitor: &Monitor,
) -> Result<Vec<Vec<LevelNoise>>, Cancelled> {
    let zero = frame_offsets(1, Slope::default(), Interpolation::Linear);
    let per_octave: Vec<Vec<TileMoments>> = octaves
        .clone()
        .into_par_iter()
        .map(|octave| {
            monitor.check()?;
            tiles_of_octave(sources, space, octave, &zero, monitor)
        })
        .collect::<Result<_, Cancelled>>()?;
    let mut before: Option<LevelNoise> = None;
    let mut of_level = |tiles: &[TileMoments], level: usize| {
        let found = level_noise(tiles, level, space, before);
        let noise = found.or(before).unwrap_or(LevelNoise::WHITE);
        before = Some(noise);
        noise
    };
    let of_octave = |tiles: Vec<TileMoments>| (0..space.levels).map(|level| of_level(&tiles, level)).collect();
    let mut levels: Vec<Vec<LevelNoise>> = per_octave.into_iter().map(of_octave).collect();
    // What files do shows at the finest octave first; long tails that only coarser ones have are what moves.
    if levels.first().is_some_and(|finest| finest.iter().all(|level| level.excess_kurtosis == 0.0)) {
        levels.iter_mut().flatten().for_each(|level| level.excess_kurtosis = 0.0);
    }
    Ok(levels)
}

/// Second and fourth moments of the levels of one tile.
#[derive(Debug, Clone)]
struct TileMoments {
    pixels: usize,
    /// By level: mean square over that of white noise, and excess kurtosis.
    levels: Vec<(f32, f32)>,
}

/// Combinations of neighbouring frames in which a scene that moves evenly nearly cancels: weights, by frame.
fn contrasts(frames: usize) -> Vec<Vec<(usize, f32)>> {
    let of = |start: usize, weights: &[f32]| weights.iter().enumerate().map(|(i, &w)| (start + i, w)).collect();
    if frames == 2 {
        return vec![of(0, &[1.0, -1.0])];
    }
    // Those that share no frame come first.
    let starts = (0..3).flat_map(|first| (first..frames - 2).step_by(3));
    starts.map(|start| of(start, &[1.0, -2.0, 1.0])).collect()
}

/// The tiles of an octave of `size` that are looked at.
fn regions((width, height): (usize, usize), pixels: usize) -> Vec<Region> {
    let inner = |n: usize| if n > 6 * BORDER { BORDER..n - BORDER } else { 0..n };
    let (columns, rows) = (inner(width), inner(height));
    let many = (columns.len() / TILE) * (rows.len() / TILE) >= MIN_TILES;
    let tile = if many { TILE } else { TILE / 2 };
    let cut = |range: &Range<usize>| -> Vec<Range<usize>> {
        // They reach from end to end, and overlap a little where the sides are no multiples of theirs.
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
            // Moved on from row to row, so that no column of tiles is preferred.
            let column = if count < all { (index + 3 * row) % columns.len() } else { index % columns.len() };
            Region { columns: columns[column].clone(), rows: rows[row].clone() }
        })
        .collect()
}

fn tiles_of_octave(
    sources: Sources<'_>,
    space: &ScaleSpace,
    octave: i32,
    zero: &[FrameOffset],
    monitor: &Monitor,
) -> Result<Vec<TileMoments>, Cancelled> {
    let first = octave == space.first_octave;
    // Octaves after the first are made from means over squares, whose own blur the base kernel leaves out.
    let halvings = (octave - space.first_octave.max(0)).max(0) as usize;
    let size = if first || halvings == 0 {
        octave_size(sources.frames[0].size(), octave)
    } else {
        sources.pyramids[0].level(halvings).size()
    };
    if space.first_octave > 0 && !first {
        // Pixels were skipped before the means are taken: what passes is white again, as far as octaves this coarse matter.
        return Ok(Vec::new());
    }
    let bank = if first { space.bank(true, space.all_levels()) } else { bank_after_means(space, halvings) };
    let filters = OctaveFilters::new(space, &bank, &space.all_levels(), size);
    let wanted = if first { PIXELS } else { COARSE_PIXELS };
    let regions = regions(size, wanted);
    let contrasts = contrasts(sources.frames.len());
    let pixels: usize = regions.iter().map(|r| r.columns.len() * r.rows.len()).sum();
    let rounds = (wanted / pixels.max(1)).clamp(1, contrasts.len());
    let white: Vec<f64> =
        (0..space.levels).map(|level| dog_noise_variance(space, octave, level as f64, zero)).collect();
    let jobs: Vec<(usize, &Region)> =
        (0..rounds).flat_map(|round| regions.iter().enumerate().map(move |(i, region)| (i + round, region))).collect();
    jobs.par_iter()
        .map_init(
            || (FilterScratch::default(), DogTile::default(), Vec::new(), Tile::default()),
            |(scratch, dog, single, input), &(turn, region)| {
                monitor.check()?;
                let contrast = &contrasts[turn % contrasts.len()];
                let inputs = filters.inputs(region);
                input.reset(&inputs, (inputs.columns.len() + 32).next_multiple_of(16));
                for v in inputs.rows.clone() {
                    input.row_mut(v).fill(0.0);
                }
                let norm = contrast.iter().map(|(_, w)| w * w).sum::<f32>().sqrt();
                for &(t, weight) in contrast {
                    let mut add = |v: usize, row: &[f32]| {
                        let sums = input.row_mut(v).iter_mut();
                        sums.zip(row).for_each(|(sum, x)| *sum += weight / norm * x);
                    };
                    if first || halvings == 0 {
                        stack_tiles(&sources.frames[t..=t], &[zero], octave, &inputs, single);
                        inputs.rows.clone().for_each(|v| add(v, single[0].row(v)));
                    } else {
                        let plane = sources.pyramids[t].level(halvings);
                        inputs.rows.clone().for_each(|v| add(v, &plane.row(v)[inputs.columns.clone()]));
                    }
                }
                dog_tile(&filters, Pixels::Stacked(input), region, scratch, dog, None, &mut |_, _| ());
                let in_image = |range: &Range<usize>| {
                    let image = |at: usize| (at as f32 * octave_pixel(octave)) as usize;
                    image(range.start)..image(range.end).max(image(range.start) + 1)
                };
                let covered = Region { columns: in_image(&region.columns), rows: in_image(&region.rows) };
                Ok(moments(dog, region, &white, (sources.variance_in)(&covered)))
            },
        )
        .collect()
}

/// Filters of an octave that starts from means over squares of 2^`halvings` pixels.
fn bank_after_means(space: &ScaleSpace, halvings: usize) -> FilterBank {
    let squares = 4f64.powi(halvings as i32);
    let doubling = if space.first_octave < 0 { 0.125 } else { 0.0 };
    let of_means = (squares - 1.0) / 12.0;
    let variance = SIGMA_BASE * SIGMA_BASE - (SIGMA_INPUT * SIGMA_INPUT + of_means - doubling) / squares;
    let base = GaussianKernel::with_cut(variance.sqrt(), space.kernel_cut);
    FilterBank::new(std::iter::once(base).chain(space.step_kernels.iter().cloned()).collect(), space.all_levels())
}

fn moments(dog: &DogTile, region: &Region, white: &[f64], frame: f32) -> TileMoments {
    let pixels = region.columns.len() * region.rows.len();
    let of_level = |(index, white): (usize, &f64)| {
        let (mut second, mut fourth) = (0.0f64, 0.0f64);
        for v in region.rows.clone() {
            let (mut row_second, mut row_fourth) = (0.0f32, 0.0f32);
            // In units of the expected deviation, so that fourth powers stay within f32.
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

/// What the tiles say of a level of `space`, after the level `before`. `None` when there is no tile.
fn level_noise(
    tiles: &[TileMoments],
    level: usize,
    space: &ScaleSpace,
    before: Option<LevelNoise>,
) -> Option<LevelNoise> {
    let sigma = space.sigma_octave(level as f64) as f32;
    let mean_pixels = tiles.iter().map(|t| t.pixels).sum::<usize>() as f32 / tiles.len().max(1) as f32;
    // D at a level is correlated over about 4σ² pixels (Σρ² of its autocorrelation).
    let free = (mean_pixels / (4.0 * sigma * sigma)).max(2.0);
    let variances: Vec<f32> = tiles.iter().map(|t| t.levels[level].0).filter(|v| v.is_finite()).collect();
    if variances.is_empty() {
        return None;
    }
    let kurtosis = median(tiles.iter().map(|t| t.levels[level].1).collect());
    // A sample's kurtosis is low by about 6 over its independent values.
    let of_pair = kurtosis + 6.0 / free;
    let error = (24.0 / free / variances.len() as f32).sqrt();
    let kurtosis = if free < FREE_FOR_KURTOSIS || error > LEAST_KURTOSIS {
        // The larger a filter, the more coefficients of a file it adds up, and the more normal they are.
        before.map_or(0.0, |noise| noise.excess_kurtosis) * 4f32.powf(-1.0 / space.levels as f32)
    } else if of_pair < LEAST_KURTOSIS.max(3.0 * error) {
        0.0
    } else {
        (OF_ONE_FRAME * of_pair).min(MAX_KURTOSIS)
    };
    let mut sorted = variances.clone();
    sorted.sort_by(f32::total_cmp);
    let quantile = |part: f32| sorted[((sorted.len() - 1) as f32 * part).round() as usize];
    let spread = (quantile(0.75) - quantile(0.25)) / (1.35 * quantile(0.5)).max(f32::MIN_POSITIVE);
    let of_noise = ((2.0 + of_pair.clamp(0.0, MAX_KURTOSIS)) / free).sqrt();
    let total_error = of_noise / (variances.len() as f32).sqrt();
    if spread > NOISE_SPREAD * of_noise {
        let quiet = quiet_variance(variances, free);
        let over_white = quiet.min(before.map_or(1.0, |noise| noise.over_white).max(1.0));
        return Some(LevelNoise { over_white, excess_kurtosis: 0.0 });
    }
    let mean = variances.iter().sum::<f32>() / variances.len() as f32;
    // What differs from white by no more than its own error is taken for white, and more in proportion (James–Stein).
    let off = mean - 1.0;
    let trust = (1.0 - (total_error / off).powi(2)).max(0.0);
    Some(LevelNoise { over_white: (1.0 + off * trust).max(LEAST_OVER_WHITE), excess_kurtosis: kurtosis })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synth::{NoiseCase, SceneParams, synth_scene};

    fn measured(
        frames: &[std::sync::Arc<Plane>],
        variance: f32,
        space: &ScaleSpace,
        octaves: Range<i32>,
    ) -> Vec<Vec<LevelNoise>> {
        let pyramids: Vec<BoxPyramid> = frames.iter().map(|f| BoxPyramid::new(f, 6)).collect();
        let frames: Vec<&Plane> = frames.iter().map(|f| &**f).collect();
        let sources =
            Sources { frames: &frames, pyramids: &pyramids.iter().collect::<Vec<_>>(), variance_in: &|_| variance };
        measure(sources, space, octaves, &Monitor::default()).expect("not cancelled")
    }

    fn of_case(case: NoiseCase, frames: usize, space: &ScaleSpace, octaves: Range<i32>) -> Vec<Vec<LevelNoise>> {
        let burst = case.burst((480, 360), frames, 0.02, 3, &Monitor::default()).expect("not cancelled");
        measured(&burst.frames, 4e-4, space, octaves)
    }

    #[test]
    fn white_noise_passes_as_white_noise() {
        for (first, frames) in [(0, 10), (-1, 10), (0, 2)] {
            let space = ScaleSpace::new(3, first, 4.0);
            let noise = of_case(NoiseCase::White, frames, &space, first..4);
            for (octave, levels) in (first..).zip(&noise) {
                for (level, noise) in levels.iter().enumerate() {
                    // Coarse octaves of so small an image have few places, and mostly its border.
                    let tolerance = if octave < 2 { 0.1 } else { 0.5 };
                    let off = noise.over_white - 1.0;
                    assert!(off.abs() < tolerance, "first {first}, octave {octave}, level {level}: {noise:?}");
                    assert_eq!(noise.excess_kurtosis, 0.0);
                }
            }
        }
    }

    #[test]
    fn shared_noise_passes_more_at_coarse_levels() {
        // The weights 1, 2, 1 over √6 let 16/6 of the variance through per axis at low frequencies.
        let noise = of_case(NoiseCase::Correlated, 10, &ScaleSpace::new(3, 0, 4.0), 0..4);
        let coarse = (16.0f32 / 6.0).powi(2);
        for level in &noise[2] {
            assert!((level.over_white / coarse - 1.0).abs() < 0.15, "{noise:?}");
        }
        assert!(noise[0][0].over_white < 0.8 * coarse && noise[0][0].over_white > 0.4 * coarse, "{noise:?}");
        assert!(noise[0][0].over_white < noise[0][1].over_white && noise[0][1].over_white < noise[0][2].over_white);
    }

    #[test]
    fn files_that_keep_little_have_long_tails() {
        let space = ScaleSpace::new(4, 0, 4.0);
        let [coarse, fine] = [NoiseCase::Jpeg(30), NoiseCase::Jpeg(90)].map(|case| of_case(case, 10, &space, 0..2));
        assert!(coarse[0][0].excess_kurtosis > 1.0, "{coarse:?}");
        assert_eq!(fine[0][0].excess_kurtosis, 0.0, "{fine:?}");
    }

    #[test]
    fn what_moves_is_not_taken_for_noise() {
        let scene = SceneParams { width: 400, height: 300, frames: 6, layers: 2, ..SceneParams::default() };
        let (burst, truth) = synth_scene(&scene, &Monitor::default()).expect("a scene");
        let sigma = truth.noise.expect("there is noise").sigma_background as f32;
        let noise = measured(&burst.frames, sigma * sigma, &ScaleSpace::new(3, 0, 4.0), 0..4);
        for level in noise.iter().flatten() {
            assert!(level.over_white < 1.5, "{noise:?}");
        }
    }
}
