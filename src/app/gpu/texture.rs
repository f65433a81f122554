//! Uploads a picture to the card: one texture with all its tiles and levels.

use super::layout::Layout;
use super::pyramid::halve;
use crate::plane::Plane;

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
