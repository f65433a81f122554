//! Limits of a graphics device.

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
