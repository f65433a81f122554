//! The texture of a picture on the card: its layout in tiles and coarser levels, and the upload.
//!
//! A texture has a largest side ([`DeviceLimits`]); a larger picture is cut into equal tiles, one array layer each,
//! and the shader finds the layer of a pixel. Coarser levels hold means of 2×2 pixels, so that a picture shown small
//! is averaged, not subsampled. The side of a tile is a multiple of 2^(levels − 1), hence a cell of any level lies in
//! one tile.

use crate::plane::Plane;
use rayon::prelude::*;

/// Picture on the card.
pub struct PictureTexture {
    /// Layout in the texture.
    pub layout: Layout,
    /// View of all levels and tiles.
    pub view: wgpu::TextureView,
}

/// Maximum size of one write into the texture, bytes; it keeps the copy on its way to the card small.
const BYTES_PER_WRITE: usize = 32 << 20;

impl PictureTexture {
    /// Uploads `plane`, and the coarser levels made from it.
    ///
    /// # Errors
    /// When the card has no memory left; a sentence for the user.
    pub fn upload(device: &wgpu::Device, queue: &wgpu::Queue, plane: &Plane, layout: Layout) -> Result<Self, String> {
        let scope = device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("burstscope picture"),
            size: wgpu::Extent3d {
                width: layout.tile.0,
                height: layout.tile.1,
                depth_or_array_layers: layout.layers(),
            },
            mip_level_count: layout.levels,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::R32Float,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        if pollster::block_on(scope.pop()).is_some() {
            return Err(format!(
                "The graphics card has no room for this picture of {} × {} pixels ({} MB). Close other programs that use it, or crop the picture.",
                layout.size.0,
                layout.size.1,
                layout.bytes() >> 20
            ));
        }
        write_level(queue, &texture, plane, layout, 0);
        let mut coarse: Option<Plane> = None;
        for level in 1..layout.levels {
            let next = halve(coarse.as_ref().unwrap_or(plane));
            write_level(queue, &texture, &next, layout, level);
            coarse = Some(next);
        }
        let view = texture.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2Array),
            ..Default::default()
        });
        Ok(Self { layout, view })
    }
}

/// Writes one level, tile by tile, in strips of rows.
fn write_level(queue: &wgpu::Queue, texture: &wgpu::Texture, plane: &Plane, layout: Layout, level: u32) {
    let tile = ((layout.tile.0 >> level) as usize, (layout.tile.1 >> level) as usize);
    let bytes: &[u8] = bytemuck::cast_slice(plane.data());
    for layer in 0..layout.layers() {
        let (u0, v0) = ((layer % layout.tiles.0) as usize * tile.0, (layer / layout.tiles.0) as usize * tile.1);
        let columns = tile.0.min(plane.width().saturating_sub(u0));
        let rows = tile.1.min(plane.height().saturating_sub(v0));
        if columns == 0 {
            continue;
        }
        // Whole rows of the plane are passed; the card copies the tile's columns out of them.
        let rows_per_write = (BYTES_PER_WRITE / (plane.width() * 4)).max(1);
        for first in (0..rows).step_by(rows_per_write) {
            let count = rows_per_write.min(rows - first);
            let start = ((v0 + first) * plane.width() + u0) * 4;
            let end = ((v0 + first + count - 1) * plane.width() + u0 + columns) * 4;
            queue.write_texture(
                wgpu::TexelCopyTextureInfo {
                    texture,
                    mip_level: level,
                    origin: wgpu::Origin3d { x: 0, y: first as u32, z: layer },
                    aspect: wgpu::TextureAspect::All,
                },
                &bytes[start..end],
                wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(plane.width() as u32 * 4),
                    rows_per_image: None,
                },
                wgpu::Extent3d { width: columns as u32, height: count as u32, depth_or_array_layers: 1 },
            );
        }
    }
}

/// Layout of one picture in a texture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Layout {
    /// (columns, rows) of the picture.
    pub size: (u32, u32),
    /// (columns, rows) of a tile at level 0.
    pub tile: (u32, u32),
    /// (tiles across, tiles down).
    pub tiles: (u32, u32),
    /// Number of levels, at least 1.
    pub levels: u32,
}

impl Layout {
    /// Maximum number of levels: the coarsest cell is 2^7 = 128 pixels wide.
    const MAX_LEVELS: u32 = 8;

    /// Computes the layout of a picture of `size` on a device with `limits`.
    ///
    /// # Errors
    /// When the device cannot hold such a picture; a sentence for the user.
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
        let longer = width.max(height);
        // One more level for each halving that leaves at least 32 pixels.
        let levels = (longer / 32).checked_ilog2().map_or(1, |l| l + 1).min(Self::MAX_LEVELS);
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

    /// Number of array layers: one for each tile.
    pub fn layers(&self) -> u32 {
        self.tiles.0 * self.tiles.1
    }

    /// Size of the texture, bytes.
    pub fn bytes(&self) -> u64 {
        let level = |l: u32| u64::from(self.tile.0 >> l) * u64::from(self.tile.1 >> l) * 4;
        (0..self.levels).map(level).sum::<u64>() * u64::from(self.layers())
    }

    /// Level for showing `picture_px_per_px` pixels of the picture in one pixel of the screen: the coarsest level whose
    /// cells are not wider than a screen pixel.
    pub fn level_for(&self, picture_px_per_px: f32) -> u32 {
        let level = if picture_px_per_px >= 2.0 { picture_px_per_px.log2().floor() as u32 } else { 0 };
        level.min(self.levels - 1)
    }
}

/// Limits of a device that concern pictures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DeviceLimits {
    /// Longest side of a texture, in pixels.
    pub max_side: u32,
    /// Maximum number of layers of a texture array.
    pub max_layers: u32,
}

impl DeviceLimits {
    /// Limits of `device`.
    pub fn of(device: &wgpu::Device) -> Self {
        let limits = device.limits();
        Self { max_side: limits.max_texture_dimension_2d, max_layers: limits.max_texture_array_layers }
    }
}

/// Next coarser level of `fine`: (⌈columns/2⌉, ⌈rows/2⌉) cells, each the mean of those of its four cells that exist and
/// are numbers; NaN when none is.
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

/// Mean of the values that are numbers.
fn mean_of_numbers(values: [f32; 4]) -> f32 {
    let numbers = values.into_iter().filter(|x| !x.is_nan());
    let (sum, count) = numbers.fold((0.0, 0), |(s, n), x| (s + x, n + 1));
    if count == 0 { f32::NAN } else { sum / count as f32 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const LIMITS: DeviceLimits = DeviceLimits { max_side: 8192, max_layers: 256 };

    #[test]
    fn an_ordinary_picture_is_one_tile() {
        let layout = Layout::new((1600, 1200), LIMITS).unwrap();
        assert_eq!(layout.layers(), 1);
        assert_eq!(layout.tile, (1600, 1216));
        assert_eq!(layout.level_for(0.1), 0);
        assert_eq!(layout.level_for(1.9), 0);
        assert_eq!(layout.level_for(4.0), 2);
        assert_eq!(layout.level_for(1e9), layout.levels - 1);
        assert_eq!(Layout::new((3, 2), LIMITS).unwrap().tile, (3, 2));
    }

    #[test]
    fn what_cannot_be_held_is_said() {
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
    }

    #[test]
    fn a_nan_counts_only_where_there_is_nothing_else() {
        let nan = f32::NAN;
        let plane = Plane::from_vec(4, 2, vec![nan, 2.0, nan, nan, 4.0, nan, nan, nan]);
        let half = halve(&plane);
        assert_eq!(half.at(0, 0), 3.0);
        assert!(half.at(1, 0).is_nan());
    }
}
