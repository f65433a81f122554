//! A bank of Gaussian filters: all levels of an octave straight from its first pixels.
//!
//! In the scale space each level is blurred from the one before. So every level is also one blur of the chain's input,
//! by the convolution of the kernels so far, cut at [`LEVEL_CUT`] standard deviations: one pass along the rows makes
//! all levels with each pixel loaded once, a second one along the columns finishes them. Near the border, where the
//! chain repeats the nearest pixel of every level, the weights come from the chain's own matrix (`weights`). Every
//! value is made by the same operations in the same order, so results do not depend on tiles and threads, to the bit.

mod passes;
mod weights;

pub use weights::Axis;

use crate::kernel::machine::{BATCH_ROWS, MAX_LEVEL_ROWS};
use crate::plane::tile::{Region, Tile};
use crate::plane::{blur::GaussianKernel, memory::Aligned};
use passes::{BLOCK, Band, Blocks, Packed, Sink, convolve_row, edge_columns, edge_rows, inner_rows, packed};
use pulp::{Arch, Simd, WithSimd};
use std::ops::Range;
use weights::{Edges, Section};

/// Radius of a level's kernel, in its standard deviations: beyond it lie 7 millionths of its weight.
pub const LEVEL_CUT: f64 = 4.5;

/// Filters that make some consecutive levels of a chain of blurs.
#[derive(Debug)]
pub struct FilterBank {
    chain: Vec<GaussianKernel>,
    wanted: Range<usize>,
    kernels: Vec<GaussianKernel>,
    /// Weights near a border that is far from the opposite one.
    edges: Edges,
}

impl FilterBank {
    /// Filters for the levels `wanted` of `chain`: level `i` is the input blurred by `chain[0]` … `chain[i]` in turn.
    pub fn new(chain: Vec<GaussianKernel>, wanted: Range<usize>) -> Self {
        let kernels: Vec<GaussianKernel> = weights::composed(&chain, LEVEL_CUT).drain(wanted.clone()).collect();
        let edges = Edges::far_apart(&chain, &wanted, &kernels);
        Self { chain, wanted, kernels, edges }
    }

    pub fn radius(&self) -> usize {
        self.kernels.iter().map(GaussianKernel::radius).max().unwrap_or(0)
    }
}

pub trait Lines {
    /// Row `v` from column `first` on, up to the end of its memory: at least all held columns.
    fn line(&self, v: usize, first: usize) -> &[f32];
}

impl Lines for crate::plane::Plane {
    fn line(&self, v: usize, first: usize) -> &[f32] {
        &self.row(v)[first..]
    }
}

impl Lines for Tile {
    fn line(&self, v: usize, first: usize) -> &[f32] {
        &self.padded_row(v)[first - self.region().columns.start..]
    }
}

#[derive(Debug, Default)]
pub struct FilterScratch {
    line: Aligned,
    /// For each level, the rows that the second pass reads.
    bands: Vec<Band>,
    /// A block of columns of the previous level.
    level: Aligned,
}

/// One tile's work as a value, since `pulp` compiles code for the processor behind a trait, not a closure.
struct FilterJob<'a, L: Lines + ?Sized> {
    along_u: &'a Axis,
    along_v: &'a Axis,
    groups: Vec<Packed>,
    lines: &'a L,
    region: &'a Region,
    stride: usize,
    /// Rows of the image that the bands hold; for each level, at least those that it still needs.
    held: Range<usize>,
    scratch: &'a mut FilterScratch,
    differences: &'a mut [Tile],
    keep: Option<(usize, &'a mut Tile)>,
    batch_done: &'a mut dyn FnMut(&[Tile], Range<usize>),
}

/// Filters a tile: `differences` (one fewer than levels) become level `i + 1` minus level `i`. `keep` names a level to
/// store as well, and its tile. `batch_done` gets the differences and the range of rows just finished.
pub fn filter_tile<L: Lines + ?Sized>(
    (along_u, along_v): (&Axis, &Axis),
    lines: &L,
    region: &Region,
    scratch: &mut FilterScratch,
    differences: &mut [Tile],
    mut keep: Option<(usize, &mut Tile)>,
    batch_done: &mut dyn FnMut(&[Tile], Range<usize>),
) {
    assert_eq!(differences.len() + 1, along_u.levels.len(), "one difference fewer than levels");
    // Rows of whole blocks: no pass needs a case for a shorter end.
    let stride = region.columns.len().next_multiple_of(BLOCK);
    differences.iter_mut().for_each(|tile| tile.reset(region, stride));
    if let Some((_, tile)) = &mut keep {
        tile.reset(region, stride);
    }
    let groups = packed(along_u);
    Arch::new().dispatch(FilterJob {
        along_u,
        along_v,
        groups,
        lines,
        region,
        stride,
        held: 0..0,
        scratch,
        differences,
        keep,
        batch_done,
    });
}

impl<L: Lines + ?Sized> WithSimd for FilterJob<'_, L> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        let rows = self.region.rows.clone();
        let room = (BATCH_ROWS + 2 * self.along_v.radius).min(self.along_v.n);
        let FilterScratch { line, bands, level } = &mut *self.scratch;
        bands.resize_with(self.along_u.levels.len(), Band::default);
        bands.iter_mut().for_each(|band| band.reset(self.stride / BLOCK, room));
        line.grow(self.stride + 2 * self.along_u.radius);
        level.grow(BATCH_ROWS * BLOCK);
        self.held = self.along_v.inputs(&rows);
        self.held.end = self.held.start;
        // Batches bound the rows between both passes, so that these stay in the cache.
        let mut start = rows.start;
        while start < rows.end {
            let batch = start..(start + BATCH_ROWS).min(rows.end);
            let needed = self.along_v.inputs(&batch);
            self.forget_above(needed.start, batch.start);
            for v in self.held.end..needed.end {
                self.make_band_row(simd, v);
            }
            self.held.end = needed.end;
            self.finish(simd, &batch);
            (self.batch_done)(self.differences, batch.clone());
            start = batch.end;
        }
    }
}

impl<L: Lines + ?Sized> FilterJob<'_, L> {
    /// Makes row `top` the first held one; keeps, for each level, the rows that it needs from row `next` on.
    fn forget_above(&mut self, top: usize, next: usize) {
        let Range { start, end } = self.held;
        for (band, level) in self.scratch.bands.iter_mut().zip(&self.along_v.levels) {
            let first = next.saturating_sub((level.half.len() - 1).max(level.head.radius)).max(top);
            if start < top && first < end {
                band.move_rows(first - start..end - start, first - top);
            }
        }
        self.held.start = top;
    }

    #[inline(always)]
    fn make_band_row<S: Simd>(&mut self, simd: S, v: usize) {
        let index = v - self.held.start;
        let reach = self.along_u.radius;
        let columns = &self.region.columns;
        let wide = self.along_u.inputs(columns);
        let offset = reach - (columns.start - wide.start);
        let FilterScratch { line, bands, .. } = &mut *self.scratch;
        // A row whose memory covers the reads of all vectors is read in place.
        let there = self.lines.line(v, wide.start);
        let line: &[f32] = if offset == 0 && there.len() >= self.stride + 2 * reach {
            there
        } else {
            line[offset..offset + wide.len()].copy_from_slice(&there[..wide.len()]);
            line
        };
        let blocks = Blocks { columns: self.stride, step: bands[0].step() };
        for group in &self.groups {
            let mut out: [&mut [f32]; passes::MOST] = Default::default();
            for (out, band) in out.iter_mut().zip(&mut bands[group.levels.clone()]) {
                *out = band.row_mut(index);
            }
            convolve_row(simd, group, (line, reach), blocks, &mut out[..group.levels.len()]);
        }
        // The columns near a border were made wrongly, as if inside, and are overwritten.
        if columns.start < reach || columns.end + reach > self.along_u.n {
            for (weights, band) in self.along_u.levels.iter().zip(bands) {
                edge_columns(simd, weights, columns, (line, reach), blocks, band.row_mut(index));
            }
        }
    }

    #[inline(always)]
    fn finish<S: Simd>(&mut self, simd: S, batch: &Range<usize>) {
        // As many rows as registers allow.
        let max = if S::F32_LANES >= 16 { MAX_LEVEL_ROWS } else { MAX_LEVEL_ROWS / 2 };
        // One block at a time through all levels: the previous level's block is still in `level`, for the difference.
        for block in (0..self.stride).step_by(BLOCK) {
            for index in 0..self.along_v.levels.len() {
                for (section, part) in self.along_v.levels[index].sections(batch, self.along_v.n) {
                    let mut first = part.start;
                    while first < part.end {
                        let left = part.end - first;
                        let rows = if left >= max { max } else { 1 << left.ilog2() };
                        match rows {
                            8 => self.level_rows::<S, 8>(simd, section, index, batch.start, first, block),
                            4 => self.level_rows::<S, 4>(simd, section, index, batch.start, first, block),
                            2 => self.level_rows::<S, 2>(simd, section, index, batch.start, first, block),
                            _ => self.level_rows::<S, 1>(simd, section, index, batch.start, first, block),
                        }
                        first += rows;
                    }
                }
                self.keep_block(index, batch, block);
            }
        }
    }

    #[inline(always)]
    fn level_rows<S: Simd, const ROWS: usize>(
        &mut self,
        simd: S,
        section: Section,
        index: usize,
        batch_start: usize,
        first: usize,
        block: usize,
    ) {
        let FilterScratch { bands, level, .. } = &mut *self.scratch;
        let (rows, top, stride) = (bands[index].block(block / BLOCK), self.held.start, self.stride);
        let weights = &self.along_v.levels[index];
        let difference = index.checked_sub(1).map(|i| self.differences[i].rows_from_mut(first, ROWS));
        let mut sink = Sink { level: &mut level[(first - batch_start) * BLOCK..][..ROWS * BLOCK], difference };
        match section {
            // Inner rows share one set of weights; each row at an edge has its own.
            Section::Inner => {
                let around = first - top - (weights.half.len() - 1);
                inner_rows::<S, ROWS>(simd, &weights.half, &rows[around..], block, stride, &mut sink);
            }
            Section::Head => edge_rows::<S, ROWS>(simd, &weights.head, (rows, top), first, block, stride, &mut sink),
            Section::Tail => edge_rows::<S, ROWS>(simd, &weights.tail, (rows, top), first, block, stride, &mut sink),
        }
    }

    fn keep_block(&mut self, index: usize, batch: &Range<usize>, block: usize) {
        if let Some((_, tile)) = self.keep.as_mut().filter(|(kept, _)| *kept == index) {
            let out = tile.rows_from_mut(batch.start, batch.len()).chunks_exact_mut(self.stride);
            for (out, made) in out.zip(self.scratch.level.chunks_exact(BLOCK)) {
                out[block..block + BLOCK].copy_from_slice(made);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plane::{Plane, blur::gaussian_blur};

    fn chain() -> Vec<GaussianKernel> {
        [1.5, 1.2, 1.6, 2.0, 2.5].map(GaussianKernel::new).to_vec()
    }

    fn texture(width: usize, height: usize) -> Plane {
        Plane::from_fn(width, height, |u, v| ((u * 31 + v * 17 + u * v % 7) % 29) as f32 / 29.0)
    }

    fn filtered(plane: &Plane, bank: &FilterBank, region: &Region, keep: usize) -> (Vec<Tile>, Tile) {
        let mut differences = vec![Tile::default(); bank.kernels.len() - 1];
        let mut kept = Tile::default();
        let axes = (bank.axis(plane.width()), bank.axis(plane.height()));
        let mut rows = Vec::new();
        filter_tile(
            (&axes.0, &axes.1),
            plane,
            region,
            &mut FilterScratch::default(),
            &mut differences,
            Some((keep, &mut kept)),
            &mut |_, range| rows.extend(range),
        );
        assert_eq!(rows, region.rows.clone().collect::<Vec<_>>());
        (differences, kept)
    }

    #[test]
    fn levels_are_those_of_the_chain_up_to_the_cut() {
        for (width, height) in [(190, 150), (40, 33), (75, 61), (22, 23), (24, 25), (5, 17)] {
            let plane = texture(width, height);
            let mut levels = Vec::new();
            for kernel in chain() {
                levels.push(gaussian_blur(levels.last().unwrap_or(&plane), &kernel));
            }
            let whole = Region { columns: 0..width, rows: 0..height };
            let (differences, kept) = filtered(&plane, &FilterBank::new(chain(), 0..5), &whole, 3);
            for v in 0..height {
                for u in 0..width {
                    assert!((kept.at(u, v) - levels[3].at(u, v)).abs() < 1e-5, "{u} {v}");
                    for (i, difference) in differences.iter().enumerate() {
                        let expected = levels[i + 1].at(u, v) - levels[i].at(u, v);
                        assert!((difference.at(u, v) - expected).abs() < 2e-5, "{i} {u} {v}");
                    }
                }
            }
        }
    }

    #[test]
    fn tiles_and_fewer_levels_give_the_bits_of_the_whole() {
        let plane = texture(203, 171);
        let whole = Region { columns: 0..203, rows: 0..171 };
        let (all, _) = filtered(&plane, &FilterBank::new(chain(), 0..5), &whole, 0);
        let regions = [
            Region { columns: 0..57, rows: 0..171 },
            Region { columns: 3..9, rows: 5..14 },
            Region { columns: 51..150, rows: 33..104 },
            Region { columns: 180..203, rows: 160..171 },
        ];
        for region in regions {
            let (tile, _) = filtered(&plane, &FilterBank::new(chain(), 0..5), &region, 0);
            let (two, _) = filtered(&plane, &FilterBank::new(chain(), 2..4), &region, 0);
            for v in region.rows.clone() {
                let columns = region.columns.clone();
                for i in 0..4 {
                    assert_eq!(tile[i].row(v), &all[i].row(v)[columns.clone()], "{region:?} {v} {i}");
                }
                assert_eq!(two[0].row(v), &all[2].row(v)[columns], "{region:?} {v}");
            }
        }
    }
}
