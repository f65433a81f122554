//! Search around the field: which slopes are searched at which place of the picture.
//!
//! The picture is cut into fixed blocks, independent of the tiles, so that threads and memory change nothing. A block
//! searches the slopes within [`STEPS`] steps of the motions of its cells and of the other layers beside it. A block
//! whose motion is mostly unknown, as where nothing has structure, searches around all known motions of the picture. D
//! equals that of a search of all slopes: coarser octaves start from whole first levels of every slope searched
//! anywhere, and a tile makes of a slope that it does not search only the pixels of the next first level.

use crate::detector::field::MotionField;
use crate::detector::params::slope_grid::{SlopeAxis, SlopeGrid};
use crate::detector::scale_space::octave_pixel;
use crate::plane::tile::Region;
use std::ops::Range;

/// Steps of the grid around a motion that are searched, along each axis.
const STEPS: usize = 2;
/// Side of a block, pixels of the input image.
const BLOCK_PX: usize = 64;
/// Part of a block's cells that must lack a known motion for the block's motion to be unknown.
const MOSTLY: f32 = 0.5;
/// Part of the blocks with a known motion below which the other blocks search all slopes.
const FEW: f32 = 0.2;

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct SlopesAround {
    grid: SlopeGrid,
    size: (usize, usize),
    /// `[block][slope]`: whether a block (row by row) searches a slope of the grid.
    searched: Vec<Vec<bool>>,
    /// Slopes searched anywhere, with their neighbours, which localisation in slope needs.
    held: Vec<bool>,
}

impl SlopesAround {
    /// Slopes of `grid` around the motions of `field` in a picture of `size` (columns, rows).
    pub(crate) fn new(field: &MotionField, grid: SlopeGrid, size: (usize, usize)) -> Self {
        let blocks = (size.0.div_ceil(BLOCK_PX), size.1.div_ceil(BLOCK_PX));
        let places = (0..blocks.1).flat_map(|row| (0..blocks.0).map(move |column| (column, row)));
        let near: Vec<Option<Vec<bool>>> = places.map(|block| of_block(field, &grid, block)).collect();
        let known = || near.iter().flatten();
        // A few known motions do not speak for the rest of the picture.
        let few_known = (known().count() as f32) < FEW * near.len() as f32;
        let all: Vec<bool> = (0..grid.len()).map(|index| few_known || known().any(|block| block[index])).collect();
        let searched: Vec<Vec<bool>> =
            near.iter().map(|block| widened(&grid, block.as_ref().unwrap_or(&all), STEPS)).collect();
        let anywhere: Vec<bool> = (0..grid.len()).map(|index| searched.iter().any(|block| block[index])).collect();
        Self { grid, size: blocks, searched, held: widened(&grid, &anywhere, 1) }
    }

    /// Whether first levels are made for slope `index`.
    pub(crate) fn holds(&self, index: usize) -> bool {
        self.held[index]
    }

    /// Whether slope `index` is searched at the place (`u`, `v`) of the input image.
    pub(crate) fn searches(&self, [u, v]: [f32; 2], index: usize) -> bool {
        // A negative place is rounded to 0.
        let along = |x: f32, count: usize| (x as usize / BLOCK_PX).min(count - 1);
        self.searched[along(v, self.size.1) * self.size.0 + along(u, self.size.0)][index]
    }

    /// Slopes that are searched anywhere in `region` of `octave`; with `beside` those beside them too.
    pub(crate) fn in_region(&self, octave: i32, region: &Region, beside: bool) -> Vec<bool> {
        let mut some = vec![false; self.grid.len()];
        for (_, _, block) in self.blocks(octave, region) {
            some.iter_mut().zip(block).for_each(|(some, searched)| *some |= searched);
        }
        if beside { widened(&self.grid, &some, 1) } else { some }
    }

    pub(crate) fn parts(&self, octave: i32, region: &Region, index: usize) -> Vec<Region> {
        let mut parts: Vec<Region> = Vec::new();
        for (columns, rows, _) in self.blocks(octave, region).filter(|(.., block)| block[index]) {
            match parts.last_mut().filter(|last| last.rows == rows && last.columns.end == columns.start) {
                Some(last) => last.columns.end = columns.end,
                None => parts.push(Region { columns, rows }),
            }
        }
        parts
    }

    /// Columns and rows of `region` of `octave` that lie in each block, and its slopes, row by row.
    fn blocks<'a>(
        &'a self,
        octave: i32,
        region: &'a Region,
    ) -> impl Iterator<Item = (Range<usize>, Range<usize>, &'a [bool])> {
        let cut = move |of: &Range<usize>, block: usize, count: usize| {
            // The last block has all that is left.
            let start = |block: usize| ((block * BLOCK_PX) as f32 / octave_pixel(octave)).ceil() as usize;
            let end = if block + 1 < count { start(block + 1) } else { usize::MAX };
            let (start, end) = (start(block).max(of.start), end.min(of.end));
            (start < end).then_some(start..end)
        };
        let columns = move |row: usize| {
            (0..self.size.0).filter_map(move |column| {
                let columns = cut(&region.columns, column, self.size.0)?;
                Some((columns, &self.searched[row * self.size.0 + column][..]))
            })
        };
        (0..self.size.1)
            .filter_map(move |row| Some((row, cut(&region.rows, row, self.size.1)?)))
            .flat_map(move |(row, rows)| columns(row).map(move |(columns, block)| (columns, rows.clone(), block)))
    }
}

/// Slopes nearest to the motions in and beside a block (column, row); `None` where most of its cells have none known.
fn of_block(field: &MotionField, grid: &SlopeGrid, block: (usize, usize)) -> Option<Vec<bool>> {
    // Pixels beyond the last whole cell have the motion of the nearest one.
    let cells = |first_px: usize, end_px: usize, count: usize| {
        (first_px / field.cell_px).min(count - 1)..end_px.div_ceil(field.cell_px).clamp(1, count)
    };
    let own = |at: usize, count: usize| cells(at * BLOCK_PX, (at + 1) * BLOCK_PX, count);
    let around = |at: usize, count: usize| cells(at.saturating_sub(1) * BLOCK_PX, (at + 2) * BLOCK_PX, count);
    let places = indices(own(block.0, field.size.0), own(block.1, field.size.1), field.size.0);
    let (known, count) = (places.clone().filter(|&cell| field.is_known(&field.motions[cell])), places.clone().count());
    if known.clone().count() as f32 <= (1.0 - MOSTLY) * count as f32 {
        return None;
    }
    let mut near = vec![false; grid.len()];
    known.for_each(|cell| near[grid.nearest(field.motions[cell].slope)] = true);
    // The motions of its own layers are known better from its cells.
    let own_layers: Vec<u8> = places.map(|cell| field.layer[cell]).collect();
    for cell in indices(around(block.0, field.size.0), around(block.1, field.size.1), field.size.0) {
        let number = field.layer[cell];
        // Layers are counted from 1.
        let layer = usize::from(number).checked_sub(1).and_then(|layer| field.layers.get(layer));
        if let Some(layer) = layer.filter(|_| !own_layers.contains(&number)) {
            near[grid.nearest(layer.slope)] = true;
        }
    }
    Some(near)
}

fn indices(columns: Range<usize>, rows: Range<usize>, width: usize) -> impl Iterator<Item = usize> + Clone {
    rows.flat_map(move |row| columns.clone().map(move |column| row * width + column))
}

/// The slopes of `grid` that are at most `steps` from one of `some` along each axis.
fn widened(grid: &SlopeGrid, some: &[bool], steps: usize) -> Vec<bool> {
    let mut wider = vec![false; some.len()];
    for (index, _) in some.iter().enumerate().filter(|(_, is_one)| **is_one) {
        let (i, j) = grid.coordinates(index);
        let around = |at: usize, axis: &SlopeAxis| at.saturating_sub(steps)..(at + steps + 1).min(axis.count);
        indices(around(i, &grid.u), around(j, &grid.v), grid.u.count).for_each(|index| wider[index] = true);
    }
    wider
}
