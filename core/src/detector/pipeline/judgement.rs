//! Judgement of single samples from a trail: D around them, every test of the search, and the keypoint that they make.
//!
//! The order of the tests and the neighbouring slopes are those of `slope_window`, which works on a whole tile; a test
//! in tests/detection/inspect checks that both agree, sample by sample.

use super::trail::Trail;
use crate::detector::feature::{Keypoint, Test};
use crate::detector::params::{SlopeGrid, SlopeNeighbours};
use crate::detector::refine::{Fit, Limits, fit};
use crate::detector::scale_space::{DogTile, OctaveFilters, Pixels, dog_tile, octave_pixel, stack_tiles};
use crate::detector::search::ascends;
use crate::detector::search::extrema::{Candidate, beats_all_27, own_slope_verdict};
use crate::detector::search::setup::{HELD, Search};
use crate::detector::search::slope_window::{OtherSlopes, refined_slope};
use crate::kernel::compact_kernel::PixelView;
use crate::kernel::gaussian_bank::FilterScratch;
use crate::monitor::{Cancelled, Monitor};
use crate::plane::Plane;
use crate::plane::tile::{Region, Tile};
use rayon::prelude::*;

/// Sample of D by its octave, level, slope and place: the key of a question to a [`Trail`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
pub struct Sample {
    /// Octave index.
    pub octave: i32,
    /// DoG level, 0 … S−1.
    pub level: i32,
    /// Index in the slope grid.
    pub slope_index: usize,
    /// Column, octave pixels.
    pub x: usize,
    /// Row, octave pixels.
    pub y: usize,
}

impl Sample {
    /// Index of the DoG level among the computed levels.
    pub fn level_index(&self) -> usize {
        (self.level + 1) as usize
    }
}

/// D of all slopes and levels in a part of one octave, bitwise equal to the values that the search compares.
#[derive(Debug)]
pub struct Neighbourhood {
    /// Octave index.
    pub octave: i32,
    /// Size (columns, rows) of the octave.
    pub size: (usize, usize),
    /// Samples that can be judged; `tiles` reach farther.
    pub region: Region,
    /// One tile a slope, with the region and the pixels that its refinement may read.
    pub tiles: Vec<DogTile>,
    /// The octave's first level around, one part a slope; none in the first octave.
    pixels: Vec<PartOfLevel>,
}

/// Pixels of a level, and the first of them.
type PartOfLevel = (Plane, (usize, usize));

fn part_of(level: &Plane, region: &Region) -> PartOfLevel {
    let (u, v) = (region.columns.start, region.rows.start);
    (Plane::from_fn(region.columns.len(), region.rows.len(), |x, y| level.at(u + x, v + y)), (u, v))
}

/// Results of the search's tests of one sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Judgement {
    /// D at the sample.
    pub value: f32,
    /// First test of the search that rejects the sample, if any; duplicates are judged later.
    pub rejected_by: Option<Test>,
    /// σ_D at its level and slope at the place of least noise.
    pub sigma_d_min: f32,
    /// σ_D at the sample.
    pub sigma_d: f32,
    /// Whether a neighbouring slope beats it; only the joint rule asks.
    pub is_beaten: bool,
    /// The quadratic fit; `None` where D has none.
    pub fit: Option<Fit>,
    /// Keypoint that the sample would make if it passed all tests; `None` where the fit did not converge in the octave.
    pub would_be: Option<Keypoint>,
}

impl Judgement {
    /// The keypoint of a candidate; `None` where a test rejects the candidate.
    pub fn keypoint(&self) -> Option<Keypoint> {
        self.would_be.filter(|_| self.rejected_by.is_none())
    }
}

impl Trail {
    /// D of all slopes around `region` of `octave`, at least one pixel of which must lie in the octave.
    pub fn neighbourhood(&self, octave: i32, region: &Region, monitor: &Monitor) -> Result<Neighbourhood, Cancelled> {
        self.with_search(monitor, |search| {
            let size = self.octave_size(octave);
            let held = region.widened(HELD, size);
            let first = octave == search.space.first_octave;
            let bank = if first { &search.banks.0 } else { &search.banks.1 };
            let filters = OctaveFilters::new(search.space, bank, &search.space.all_levels(), size);
            let inputs = filters.inputs(&held);
            let one = |pixels: Pixels<'_>, scratch: &mut FilterScratch| {
                let mut dog = DogTile::default();
                dog_tile(&filters, pixels, &held, scratch, &mut dog, None, &mut |_, _| ());
                let part = if let Pixels::Level(level) = pixels { Some(part_of(level, &inputs)) } else { None };
                (dog, part)
            };
            let bases = self.outcome.bases.as_ref().map(|bases| &bases[(octave - search.space.first_octave) as usize]);
            let of_slope = |index: usize, scratch: &mut FilterScratch, stacked: &mut Vec<Tile>| {
                monitor.check()?;
                let pixels = match bases.filter(|_| !first) {
                    None => {
                        stack_tiles(&search.planes, &search.offsets[index..=index], octave, &inputs, stacked);
                        Pixels::Stacked(&stacked[0])
                    }
                    // Slopes that the search did not hold have no kept level, but may still be looked at.
                    Some(_) if !search.inputs.holds(index) => {
                        let level = search.stack(index).first_level(octave, &inputs, monitor)?;
                        return Ok(one(Pixels::Level(&level), scratch));
                    }
                    Some(bases) => Pixels::Level(bases.at(index)),
                };
                Ok(one(pixels, scratch))
            };
            let slopes = 0..search.grid.len();
            let made: Vec<(DogTile, Option<PartOfLevel>)> = if first || bases.is_some() {
                let space = || (FilterScratch::default(), Vec::new());
                let of_slope = |(scratch, stacked): &mut _, index| of_slope(index, scratch, stacked);
                slopes.into_par_iter().map_init(space, of_slope).collect::<Result<_, Cancelled>>()?
            } else {
                // Levels that were not kept are made again, one slope at a time: each may take much of the picture.
                let mut scratch = FilterScratch::default();
                let mut of_slope = |index| {
                    let level = search.stack(index).first_level(octave, &inputs, monitor)?;
                    Ok(one(Pixels::Level(&level), &mut scratch))
                };
                slopes.map(&mut of_slope).collect::<Result<_, Cancelled>>()?
            };
            let (tiles, pixels): (Vec<_>, Vec<_>) = made.into_iter().unzip();
            let pixels = pixels.into_iter().flatten().collect();
            Ok(Neighbourhood { octave, size, region: region.clone(), tiles, pixels })
        })
    }

    /// Whether slope `slope_index` is tried at `place` (u, v), input pixels: `SearchSlopes::Field` leaves some out.
    pub fn searches(&self, place: [f32; 2], slope_index: usize) -> bool {
        self.inputs.searches(place, slope_index)
    }

    /// Judges samples of a neighbourhood; `None` on the octave's border and at slopes that the search leaves out there.
    pub fn judge(&self, around: &Neighbourhood, samples: &[Sample]) -> Vec<Option<Judgement>> {
        self.with_search(&Monitor::default(), |search| {
            samples.iter().map(|sample| self.judge_one(search, around, sample)).collect()
        })
    }

    fn judge_one(&self, search: &Search<'_>, around: &Neighbourhood, sample: &Sample) -> Option<Judgement> {
        let &Sample { octave, slope_index, x, y, .. } = sample;
        let pixel = octave_pixel(octave);
        if !search.inputs.searches([x as f32 * pixel, y as f32 * pixel], slope_index) {
            return None;
        }
        let level_index = sample.level_index();
        let own = &around.tiles[slope_index];
        let sigma_d = &self.sigma_d[(octave - search.space.first_octave) as usize];
        let thresholds = search.thresholds(octave, sigma_d, slope_index);
        let at_own = own_slope_verdict(&own.levels, (x, y, level_index), around.size, &thresholds)?;
        let value = own.at(level_index, x, y);
        let candidate = Candidate { x, y, level_index, value };
        let sigma_d_min = sigma_d[level_index][slope_index];
        let sigma_d = sigma_d_min * search.place_factor(octave, slope_index, x, y);
        let others = OtherSlopes::of(search.params);
        let is_beaten = match others {
            OtherSlopes::Beaten(neighbours) => compared_slopes(&search.grid, slope_index, neighbours)
                // Of two slopes with equal D the earlier one stays.
                .any(|other| !beats_all_27(value, &around.tiles[other], x, y, level_index, other > slope_index)),
            OtherSlopes::Unseen | OtherSlopes::Seen => false,
        };
        let part = around.pixels.get(slope_index).filter(|_| ascends(search.params, octave));
        let first = part.map(|(plane, (u, v))| {
            search.first_level(PixelView { left: *u as i64, top: *v as i64, ..PixelView::of(plane) })
        });
        let samples = (own, first.as_ref());
        let refined = search.refined(samples, &candidate, (octave, around.size), slope_index, sigma_d).map(|_| ());
        let rejected_by = match at_own {
            Err(test) => Some(test),
            Ok(_) if !search.passes_gate(&candidate, sigma_d) => Some(Test::NoiseGate),
            Ok(_) if is_beaten => Some(Test::SlopeExtremum),
            Ok(_) => refined.err(),
        };
        // Open limits: `would_be` shows the keypoint of a sample that only thresholds reject.
        let open = Limits { gate: 0.0, peak_threshold: -1.0, edge_threshold: f32::INFINITY };
        let fit = fit(samples, (x, y), level_index, around.size);
        let settled = fit.filter(|fit| {
            let tests = fit.tests(around.size, own.levels.len(), open);
            tests.iter().all(|(test, passes)| *passes || matches!(test, Test::Edge | Test::InterpolatedContrast))
        });
        let would_be = settled.map(|fit| {
            let d_around = d_around(search, around, slope_index, level_index, &fit);
            let slope = refined_slope(&search.grid, others, slope_index, &d_around);
            search.keypoint(octave, &candidate, &fit, (slope_index, slope), sigma_d)
        });
        Some(Judgement { value, rejected_by, sigma_d_min, sigma_d, is_beaten, fit, would_be })
    }
}

/// The slopes that the joint rule compares with slope `index`.
pub fn compared_slopes(grid: &SlopeGrid, index: usize, neighbours: SlopeNeighbours) -> impl Iterator<Item = usize> {
    let grid = *grid;
    let (i, j) = grid.coordinates(index);
    (0..grid.len()).filter(move |&other| {
        let (ii, jj) = grid.coordinates(other);
        other != index && (neighbours == SlopeNeighbours::All || (i.abs_diff(ii) <= 1 && j.abs_diff(jj) <= 1))
    })
}

/// D of the refined sample at the slopes around slope `index`, 0 beyond the grid.
fn d_around(search: &Search<'_>, around: &Neighbourhood, index: usize, level_index: usize, fit: &Fit) -> [[f32; 3]; 3] {
    let d_at = |slope: usize| around.tiles[slope].at(level_index, fit.x, fit.y);
    let mut values = search.grid.around(index).map(|slope| slope.map_or(0.0, d_at));
    std::array::from_fn(|_| std::array::from_fn(|_| values.next().expect("nine slopes")))
}
