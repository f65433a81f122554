//! Float pictures on the graphics card.
//!
//! A picture goes to the card once, as 32-bit floats; range, gamma and colour map are numbers that the shader reads, so
//! changing the exposure uploads nothing. Large pictures are tiled; one that cannot be shown is reported. A device can
//! be lost ([`Gpu::lost`]); [`install`] for a new device uploads everything to it again.

mod renderer;
mod setup;
mod texture;

pub use renderer::{PicturePaint, PictureRenderer};
pub use setup::{AdapterChoice, Gpu, install, textures_of, wgpu_setup};
pub use texture::DeviceLimits;
pub(in crate::app) use texture::flat_texture;

use std::sync::atomic::{AtomicU64, Ordering};

/// Id of a picture's content: the card holds a picture as long as its id recurs. New values need a new id.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct PictureId(u64);

impl PictureId {
    pub fn fresh() -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(1);
        Self(NEXT.fetch_add(1, Ordering::Relaxed))
    }
}
