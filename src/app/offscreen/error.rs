//! Errors of drawing without a display.

/// Reason why nothing could be drawn.
#[derive(Debug, thiserror::Error)]
pub enum OffscreenError {
    /// There is no adapter.
    #[error(
        "there is no graphics adapter to draw with ({0}); install a software one (on Debian and Ubuntu: apt install mesa-vulkan-drivers), \
         or use a machine with a Vulkan driver"
    )]
    NoAdapter(String),
    /// The adapter gave no device.
    #[error("the graphics adapter cannot be used: {0}")]
    NoDevice(String),
    /// A picture of this size cannot be drawn.
    #[error(
        "a window of {width} × {height} pixels cannot be drawn; this graphics adapter draws 1 to {limit} pixels a side \
         and {max_megapixels} megapixels in all; name a smaller size or scale"
    )]
    Size {
        /// Columns asked for.
        width: f32,
        /// Rows asked for.
        height: f32,
        /// The adapter's limit of a side, pixels.
        limit: u32,
        /// The adapter's limit of the picture, megapixels.
        max_megapixels: u64,
    },
    /// The card failed while drawing or answering.
    #[error("the graphics adapter failed while drawing: {0}")]
    Card(String),
}
