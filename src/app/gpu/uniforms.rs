//! What the shader is told of one pane.

/// The shader's uniforms; field by field those of `picture.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Uniforms {
    /// A place of the framebuffer, in pixels of the screen.
    pub origin_px: [f32; 2],
    /// The place of the picture that is shown there, in its pixels.
    pub anchor_picture: [f32; 2],
    /// What a dimmed picture fades towards, sRGB in [0, 1].
    pub backdrop: [f32; 3],
    /// Pixels of the picture in one pixel of the screen.
    pub picture_px_per_px: f32,
    /// Columns, rows.
    pub size: [u32; 2],
    /// Columns, rows of one array layer.
    pub tile: [u32; 2],
    /// Tiles side by side.
    pub tiles_across: u32,
    /// The level to read.
    pub level: u32,
    /// Row of the colour map in the table.
    pub lut_row: u32,
    /// 1: diverging map; 2: the target converts from linear light.
    pub flags: u32,
    /// Lower end of the value range.
    pub range_min: f32,
    /// 1 / width of the value range.
    pub range_scale: f32,
    /// 1 / gamma.
    pub exponent: f32,
    /// 0: as it is; 1: dimmed.
    pub dim: f32,
}
