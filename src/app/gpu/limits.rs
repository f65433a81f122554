//! What a graphics device can hold.

/// What the device can hold, as far as pictures are concerned.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DeviceLimits {
    /// Longest side of a texture, in pixels.
    pub max_side: u32,
    /// Most layers of a texture array.
    pub max_layers: u32,
}

impl DeviceLimits {
    /// Those of `device`.
    pub fn of(device: &wgpu::Device) -> Self {
        let limits = device.limits();
        Self { max_side: limits.max_texture_dimension_2d, max_layers: limits.max_texture_array_layers }
    }
}
