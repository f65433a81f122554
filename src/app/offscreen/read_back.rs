//! Reads pixels back from the card.

use super::error::OffscreenError;
use image::RgbaImage;
use std::time::Duration;

/// Time allowed to the card for each [`TIMED_PIXELS`] of a frame. A software adapter needs a fraction of a second.
const CARD_TIMEOUT: Duration = Duration::from_secs(30);
/// Number of pixels of a large screen.
const TIMED_PIXELS: u32 = 1 << 23;

/// Reads the pixels of an 8-bit RGBA texture back.
pub(super) fn read_back(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    texture: &wgpu::Texture,
) -> Result<RgbaImage, OffscreenError> {
    let (width, height) = (texture.width(), texture.height());
    let row_bytes = 4 * width as usize;
    let padded_bytes = row_bytes.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT as usize);
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("burstscope offscreen"),
        size: (padded_bytes * height as usize) as u64,
        usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let mut encoder = device.create_command_encoder(&Default::default());
    encoder.copy_texture_to_buffer(
        texture.as_image_copy(),
        wgpu::TexelCopyBufferInfo {
            buffer: &buffer,
            layout: wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(padded_bytes as u32),
                rows_per_image: None,
            },
        },
        texture.size(),
    );
    let submission = queue.submit([encoder.finish()]);
    let timeout = CARD_TIMEOUT * (width * height).div_ceil(TIMED_PIXELS);
    let (sender, receiver) = std::sync::mpsc::channel();
    buffer.map_async(wgpu::MapMode::Read, .., move |result| {
        // The receiver is gone when the wait has timed out.
        let _ = sender.send(result);
    });
    let failed = |error: &dyn std::fmt::Display| OffscreenError::Card(error.to_string());
    device
        .poll(wgpu::PollType::Wait { submission_index: Some(submission), timeout: Some(timeout) })
        .map_err(|e| failed(&e))?;
    receiver.recv_timeout(timeout).map_err(|e| failed(&e))?.map_err(|e| failed(&e))?;
    let mapped = buffer.get_mapped_range(..).map_err(|e| failed(&e))?;
    let mut bytes = Vec::with_capacity(row_bytes * height as usize);
    for row in mapped.chunks_exact(padded_bytes) {
        bytes.extend_from_slice(&row[..row_bytes]);
    }
    // Without a surface egui's target is Rgba8Unorm; other formats would need their channels reordered.
    debug_assert_eq!(texture.format(), wgpu::TextureFormat::Rgba8Unorm);
    RgbaImage::from_raw(width, height, bytes).ok_or_else(|| failed(&"the answer had the wrong size"))
}
