//! The texture of a picture on the card: its layout in tiles and coarser levels, and the upload.
//!
//! A picture larger than a texture may be is cut into equal tiles, one array layer each. Coarser levels hold means of
//! 2×2 pixels. A tile's side is a multiple of 2^(levels − 1), hence a cell of any level lies in one tile.

use crate::plane::{Plane, memory};
use rayon::prelude::*;
use std::time::Duration;

pub struct PictureTexture {
    pub layout: Layout,
    pub view: wgpu::TextureView,
}

/// Size of what is on its way to the card at once, bytes.
const BYTES_ON_THE_WAY: u64 = 32 << 20;

/// Time allowed to the card for what it is working on. A device that does not answer is not waited for any longer.
const CARD_TIMEOUT: Duration = Duration::from_secs(30);

/// Waits until the card is done with `submission`, or with everything, so that memory no longer needed is given back.
pub(super) fn wait_for_card(device: &wgpu::Device, submission: Option<wgpu::SubmissionIndex>) {
    let _ = device.poll(wgpu::PollType::Wait { submission_index: submission, timeout: Some(CARD_TIMEOUT) });
}

/// Describes a texture of one level, which is not multisampled.
pub(in crate::app) fn flat_texture(
    label: &'static str,
    size: wgpu::Extent3d,
    format: wgpu::TextureFormat,
    usage: wgpu::TextureUsages,
) -> wgpu::TextureDescriptor<'static> {
    wgpu::TextureDescriptor {
        label: Some(label),
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage,
        view_formats: &[],
    }
}

struct NoRoom;

fn within_memory<T>(device: &wgpu::Device, make: impl FnOnce() -> T) -> Result<T, NoRoom> {
    let scope = device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
    let made = make();
    pollster::block_on(scope.pop()).map_or(Ok(made), |_| Err(NoRoom))
}

impl PictureTexture {
    /// Uploads `plane` and its coarser levels. Fails, with a sentence for the user, when no memory is left.
    pub fn upload(device: &wgpu::Device, queue: &wgpu::Queue, plane: &Plane, layout: Layout) -> Result<Self, String> {
        let uploaded = memory::refusable(|| Self::filled(device, queue, plane, layout));
        let ((width, height), mb) = (layout.size, layout.bytes() >> 20);
        uploaded.unwrap_or(Err(NoRoom)).map_err(|NoRoom| {
            format!("There is no memory left to show this picture of {width} × {height} pixels ({mb} MB on the graphics card). Close other programs, or crop the picture.")
        })
    }

    fn filled(device: &wgpu::Device, queue: &wgpu::Queue, plane: &Plane, layout: Layout) -> Result<Self, NoRoom> {
        let (width, height) = layout.tile;
        let size = wgpu::Extent3d { width, height, depth_or_array_layers: layout.layers() };
        let usage = wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST;
        let flat = flat_texture("burstscope picture", size, wgpu::TextureFormat::R32Float, usage);
        let described = wgpu::TextureDescriptor { mip_level_count: layout.levels, ..flat };
        let texture = within_memory(device, || device.create_texture(&described))?;
        let mut writes = Writes { device, queue, texture: &texture, commands: Vec::new(), bytes: 0 };
        writes.write_level(plane, layout, 0)?;
        // Each level is made from the one before: two at most are in memory beside the picture.
        let mut coarse: Option<Plane> = None;
        for level in 1..layout.levels {
            let next = halve(coarse.as_ref().unwrap_or(plane));
            writes.write_level(&next, layout, level)?;
            coarse = Some(next);
        }
        writes.submit()?;
        let dimension = Some(wgpu::TextureViewDimension::D2Array);
        let described = wgpu::TextureViewDescriptor { dimension, ..Default::default() };
        let view = within_memory(device, || texture.create_view(&described))?;
        Ok(Self { layout, view })
    }
}

/// Through buffers of our own: where a device has no memory for those of its queue, it is lost.
struct Writes<'a> {
    device: &'a wgpu::Device,
    queue: &'a wgpu::Queue,
    texture: &'a wgpu::Texture,
    commands: Vec<wgpu::CommandBuffer>,
    bytes: u64,
}

impl Writes<'_> {
    fn write_level(&mut self, plane: &Plane, layout: Layout, level: u32) -> Result<(), NoRoom> {
        let tile = ((layout.tile.0 >> level) as usize, (layout.tile.1 >> level) as usize);
        for layer in 0..layout.layers() {
            let (u0, v0) = ((layer % layout.tiles.0) as usize * tile.0, (layer / layout.tiles.0) as usize * tile.1);
            let columns = tile.0.min(plane.width().saturating_sub(u0));
            let rows = tile.1.min(plane.height().saturating_sub(v0));
            // The picture may end before a tile of a coarse level begins.
            if columns == 0 {
                continue;
            }
            let row_bytes = (columns * 4).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT as usize);
            let rows_per_write = (BYTES_ON_THE_WAY as usize / row_bytes).max(1);
            for first in (0..rows).step_by(rows_per_write) {
                let count = rows_per_write.min(rows - first);
                let row = |row: usize| &plane.row(v0 + first + row)[u0..u0 + columns];
                let origin = wgpu::Origin3d { x: 0, y: first as u32, z: layer };
                self.write_strip(level, origin, (columns, count), row_bytes, row)?;
            }
        }
        Ok(())
    }

    fn write_strip<'p>(
        &mut self,
        mip_level: u32,
        origin: wgpu::Origin3d,
        (columns, rows): (usize, usize),
        row_bytes: usize,
        row: impl Fn(usize) -> &'p [f32],
    ) -> Result<(), NoRoom> {
        let size = (row_bytes * rows) as u64;
        // Bytes on the way are in memory twice: the card has to take them before more are added.
        if self.bytes + size > BYTES_ON_THE_WAY {
            wait_for_card(self.device, Some(self.submit()?));
        }
        // Each step may lack memory, which must fail this picture only and not lose the device.
        let usage = wgpu::BufferUsages::MAP_WRITE | wgpu::BufferUsages::COPY_SRC;
        let label = Some("burstscope picture");
        let described = wgpu::BufferDescriptor { label, size, usage, mapped_at_creation: true };
        let buffer = within_memory(self.device, || self.device.create_buffer(&described))?;
        let mut mapped = buffer.get_mapped_range_mut(..).map_err(|_| NoRoom)?;
        for index in 0..rows {
            let start = index * row_bytes;
            mapped.slice(start..start + 4 * columns).copy_from_slice(bytemuck::cast_slice(row(index)));
        }
        drop(mapped);
        buffer.unmap();
        let bytes_per_row = Some(row_bytes as u32);
        let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row, rows_per_image: None };
        let from = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
        let aspect = wgpu::TextureAspect::All;
        let into = wgpu::TexelCopyTextureInfo { texture: self.texture, mip_level, origin, aspect };
        let copied = wgpu::Extent3d { width: columns as u32, height: rows as u32, depth_or_array_layers: 1 };
        self.commands.push(within_memory(self.device, || {
            let mut encoder = self.device.create_command_encoder(&Default::default());
            encoder.copy_buffer_to_texture(from, into, copied);
            encoder.finish()
        })?);
        self.bytes += size;
        Ok(())
    }

    fn submit(&mut self) -> Result<wgpu::SubmissionIndex, NoRoom> {
        self.bytes = 0;
        within_memory(self.device, || self.queue.submit(self.commands.drain(..)))
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Layout {
    pub size: (u32, u32),
    pub tile: (u32, u32),
    pub tiles: (u32, u32),
    pub levels: u32,
}

impl Layout {
    /// Maximum number of levels: the coarsest cell is 2^7 = 128 pixels wide.
    const MAX_LEVELS: u32 = 8;

    /// Fails, with a sentence for the user, when the device cannot hold such a picture.
    pub fn new(size: (usize, usize), limits: DeviceLimits) -> Result<Self, String> {
        let too_large = || {
            format!(
                "This picture of {} × {} pixels is larger than the graphics card can show ({} tiles of {} × {}). Crop it, or open a part of it.",
                size.0, size.1, limits.max_layers, limits.max_side, limits.max_side
            )
        };
        let (Ok(width), Ok(height)) = (u32::try_from(size.0), u32::try_from(size.1)) else { return Err(too_large()) };
        if width == 0 || height == 0 {
            return Err("This picture has no pixels.".to_owned());
        }
        // One more level for each halving that leaves at least 32 pixels.
        let levels = (width.max(height) / 32).checked_ilog2().map_or(1, |l| l + 1).min(Self::MAX_LEVELS);
        // Sides of this multiple halve evenly down to the coarsest level.
        let multiple = 1 << (levels - 1);
        let largest_tile = limits.max_side / multiple * multiple;
        if largest_tile == 0 {
            return Err(too_large());
        }
        let split = |side: u32| {
            let count = side.div_ceil(largest_tile);
            // Equal tiles waste less than full ones and a remainder.
            (count, side.div_ceil(count).next_multiple_of(multiple).min(largest_tile))
        };
        let ((across, tile_width), (down, tile_height)) = (split(width), split(height));
        if u64::from(across) * u64::from(down) > u64::from(limits.max_layers) {
            return Err(too_large());
        }
        Ok(Self { size: (width, height), tile: (tile_width, tile_height), tiles: (across, down), levels })
    }

    pub fn layers(&self) -> u32 {
        self.tiles.0 * self.tiles.1
    }

    pub fn bytes(&self) -> u64 {
        let level = |l: u32| u64::from(self.tile.0 >> l) * u64::from(self.tile.1 >> l) * 4;
        (0..self.levels).map(level).sum::<u64>() * u64::from(self.layers())
    }

    /// The coarsest level whose cells are not wider than a pixel of the screen.
    pub fn level_for(&self, picture_px_per_px: f32) -> u32 {
        let level = if picture_px_per_px >= 2.0 { picture_px_per_px.log2().floor() as u32 } else { 0 };
        level.min(self.levels - 1)
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DeviceLimits {
    pub max_side: u32,
    pub max_layers: u32,
}

impl DeviceLimits {
    pub fn of(device: &wgpu::Device) -> Self {
        let limits = device.limits();
        Self { max_side: limits.max_texture_dimension_2d, max_layers: limits.max_texture_array_layers }
    }
}

/// (⌈columns/2⌉, ⌈rows/2⌉) cells: means of up to four numbers; NaN where all four are.
pub fn halve(fine: &Plane) -> Plane {
    let (width, height) = (fine.width().div_ceil(2), fine.height().div_ceil(2));
    let mut coarse = Plane::zeros(width, height);
    if width == 0 {
        return coarse;
    }
    coarse.data_mut().par_chunks_mut(width).enumerate().with_min_len(8).for_each(|(v, out)| {
        let top = fine.row(2 * v);
        // The last row or column of an odd size counts twice.
        let bottom = fine.row((2 * v + 1).min(fine.height() - 1));
        for (u, cell) in out.iter_mut().enumerate() {
            let (left, right) = (2 * u, (2 * u + 1).min(fine.width() - 1));
            let four = [top[left], top[right], bottom[left], bottom[right]];
            let mean = 0.25 * (four[0] + four[1] + four[2] + four[3]);
            *cell = if mean.is_nan() { mean_of_numbers(four) } else { mean };
        }
    });
    coarse
}

fn mean_of_numbers(values: [f32; 4]) -> f32 {
    let (sum, count) = values.into_iter().filter(|x| !x.is_nan()).fold((0.0, 0), |(s, n), x| (s + x, n + 1));
    if count == 0 { f32::NAN } else { sum / count as f32 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const LIMITS: DeviceLimits = DeviceLimits { max_side: 8192, max_layers: 256 };

    #[test]
    fn an_ordinary_picture_is_one_tile_and_what_cannot_be_held_is_said() {
        let layout = Layout::new((1600, 1200), LIMITS).unwrap();
        assert_eq!(layout.layers(), 1);
        assert_eq!(layout.tile, (1600, 1216));
        assert_eq!([0.1, 1.9, 4.0, 1e9].map(|ratio| layout.level_for(ratio)), [0, 0, 2, layout.levels - 1]);
        assert_eq!(Layout::new((3, 2), LIMITS).unwrap().tile, (3, 2));
        let small = DeviceLimits { max_side: 2048, max_layers: 4 };
        assert!(Layout::new((4096, 4096), small).is_ok());
        let message = Layout::new((10_000, 4096), small).unwrap_err();
        assert!(message.contains("10000 × 4096") && message.contains("2048"), "{message}");
        assert!(Layout::new((0, 5), small).is_err());
    }

    proptest! {
        #[test]
        fn every_pixel_has_a_place(width in 1usize..50_000, height in 1usize..50_000, side in 1024u32..16384) {
            if let Ok(layout) = Layout::new((width, height), DeviceLimits { max_side: side, max_layers: 256 }) {
                prop_assert!(layout.tile.0 <= side && layout.tile.1 <= side);
                prop_assert!(layout.tile.0 * layout.tiles.0 >= width as u32);
                prop_assert!(layout.tile.1 * layout.tiles.1 >= height as u32);
                if layout.levels > 1 {
                    prop_assert_eq!(layout.tile.0 % (1 << (layout.levels - 1)), 0);
                }
                prop_assert!((layout.tile.0.max(layout.tile.1)) >> (layout.levels - 1) > 0);
            }
        }
    }

    #[test]
    fn even_and_odd_sizes() {
        let plane = Plane::from_fn(5, 3, |u, v| (u + 10 * v) as f32);
        let half = halve(&plane);
        assert_eq!(half.size(), (3, 2));
        assert_eq!(half.at(0, 0), (0.0 + 1.0 + 10.0 + 11.0) / 4.0);
        assert_eq!(half.at(2, 0), (4.0 + 14.0) / 2.0);
        assert_eq!(half.at(2, 1), 24.0);
        assert_eq!(halve(&Plane::zeros(0, 0)).size(), (0, 0));
        // A NaN counts only where there is nothing else.
        let nan = f32::NAN;
        let plane = Plane::from_vec(4, 2, vec![nan, 2.0, nan, nan, 4.0, nan, nan, nan]);
        let half = halve(&plane);
        assert_eq!(half.at(0, 0), 3.0);
        assert!(half.at(1, 0).is_nan());
    }
}
