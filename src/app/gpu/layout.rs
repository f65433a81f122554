//! Layout of a picture in a texture: tiles for pictures wider than a texture may be, and coarser levels for small
//! views.
//!
//! A texture has a largest side; a larger picture is cut into equal tiles, one array layer each, and the shader finds
//! the layer of a pixel. Coarser levels hold means of 2×2 pixels, so that a picture shown small is averaged, not
//! subsampled. The side of a tile is a multiple of 2^(levels − 1), hence a cell of any level lies in one tile.

use super::limits::DeviceLimits;

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
}
