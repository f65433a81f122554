//! Parameters of the shader for one pane.

/// Uniforms of the shader; field by field those of `picture.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Uniforms {
    /// Anchor in the framebuffer, in pixels of the screen.
    pub origin_px: [f32; 2],
    /// Place of the picture shown at the anchor, in its pixels.
    pub anchor_picture: [f32; 2],
    /// Colour towards which a dimmed picture fades, sRGB in [0, 1].
    pub backdrop: [f32; 3],
    /// Pixels of the picture in one pixel of the screen.
    pub picture_px_per_px: f32,
    /// Columns, rows.
    pub size: [u32; 2],
    /// Columns, rows of one array layer.
    pub tile: [u32; 2],
    /// Number of tiles side by side.
    pub tiles_across: u32,
    /// Level to read.
    pub level: u32,
    /// Row of the colour map in the table.
    pub lut_row: u32,
    /// Bits: 1, diverging map; 2, the target converts from linear light.
    pub flags: u32,
    /// Lower end of the value range.
    pub range_min: f32,
    /// 1 / width of the value range.
    pub range_scale: f32,
    /// 1 / gamma.
    pub exponent: f32,
    /// Dimming, 0 … 1.
    pub dim: f32,
}
