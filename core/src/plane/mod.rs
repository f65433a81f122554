//! Float images, and operations that do not depend on what the image shows.
//!
//! A [`Plane`] is a rectangle of `f32` in row-major order without padding: the value at column `u` and row `v` is
//! `data[v·width + u]`. Frames, motion-stack images, Gaussian levels and DoG responses are all planes.

pub mod blur;
pub mod display;
pub mod mask;
pub mod memory;
pub mod sample;
pub mod statistics;
pub(crate) mod tile;

pub use mask::Mask;
use multiversion::multiversion;
use std::sync::Arc;

/// Float image, row-major, without padding between rows; of a frame, with a mask of the seen samples.
#[derive(Debug, Clone, PartialEq)]
pub struct Plane {
    width: usize,
    height: usize,
    data: Pixels,
    mask: Option<Arc<Mask>>,
}

impl Plane {
    /// Plane of zeros. Unwinds as [`memory::zeroed`] where the system refuses the memory, as all constructors do.
    pub fn zeros(width: usize, height: usize) -> Self {
        Self { width, height, data: Pixels::Own(memory::zeroed(width.saturating_mul(height))), mask: None }
    }

    /// Takes `data` as the pixels, row by row.
    ///
    /// # Panics
    /// When `data.len() != width * height`: a mistake of the caller, not of any input.
    pub fn from_vec(width: usize, height: usize, data: Vec<f32>) -> Self {
        assert_eq!(data.len(), width * height, "a plane's data must have width × height values");
        Self { width, height, data: Pixels::Own(data), mask: None }
    }

    /// Shows the pixels of `owner`, row by row, without a copy.
    ///
    /// # Panics
    /// When `owner` does not have `width × height` pixels: a mistake of the caller, not of any input.
    pub fn from_shared(width: usize, height: usize, owner: Arc<dyn PixelOwner>) -> Self {
        assert_eq!(owner.pixels().len(), width * height, "a plane's data must have width × height values");
        Self { width, height, data: Pixels::Shared(owner), mask: None }
    }

    /// Plane with the value `f(u, v)` at column `u`, row `v`.
    pub fn from_fn(width: usize, height: usize, mut f: impl FnMut(usize, usize) -> f32) -> Self {
        let mut data = memory::with_capacity(width.saturating_mul(height));
        for v in 0..height {
            data.extend((0..width).map(|u| f(u, v)));
        }
        Self { width, height, data: Pixels::Own(data), mask: None }
    }

    /// Number of columns.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Number of rows.
    pub fn height(&self) -> usize {
        self.height
    }

    /// Number of columns and of rows.
    pub fn size(&self) -> (usize, usize) {
        (self.width, self.height)
    }

    /// All pixels, row by row.
    pub fn data(&self) -> &[f32] {
        self.data.get()
    }

    /// All pixels, row by row, mutable; pixels of another owner are copied first.
    pub fn data_mut(&mut self) -> &mut [f32] {
        self.data.get_mut()
    }

    /// Turns the plane into its pixels, row by row.
    pub fn into_vec(self) -> Vec<f32> {
        self.data.into_vec()
    }

    /// Row `v`, `width` values.
    ///
    /// # Panics
    /// When `v >= height`.
    pub fn row(&self, v: usize) -> &[f32] {
        &self.data()[v * self.width..(v + 1) * self.width]
    }

    /// Row `v`, mutable, as by [`Self::data_mut`].
    ///
    /// # Panics
    /// When `v >= height`.
    pub fn row_mut(&mut self, v: usize) -> &mut [f32] {
        let width = self.width;
        &mut self.data_mut()[v * width..(v + 1) * width]
    }

    /// Value at column `u`, row `v`.
    ///
    /// # Panics
    /// When the pixel is outside.
    pub fn at(&self, u: usize, v: usize) -> f32 {
        assert!(u < self.width && v < self.height, "({u}, {v}) is outside {}×{}", self.width, self.height);
        self.data()[v * self.width + u]
    }

    /// Value at column `u`, row `v`, or `None` outside.
    pub fn get(&self, u: i64, v: i64) -> Option<f32> {
        let (u, v) = (usize::try_from(u).ok()?, usize::try_from(v).ok()?);
        (u < self.width && v < self.height).then(|| self.data()[v * self.width + u])
    }

    /// Means of 2×2 pixels; an odd last column or row is left out.
    pub(crate) fn halved(&self) -> Self {
        let mut out = Self::zeros(self.width() / 2, self.height() / 2);
        (0..out.height()).for_each(|v| halve_pair(self.row(2 * v), self.row(2 * v + 1), out.row_mut(v)));
        out.with_mask(self.mask.as_ref().and_then(|mask| Mask::new(mask.weights().halved())))
    }
}

/// Writes the means over squares of 2×2 pixels of two rows to `out`, as many as it holds.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx512dq", "x86_64+avx2+fma", "aarch64+neon"))]
pub(crate) fn halve_pair(upper: &[f32], lower: &[f32], out: &mut [f32]) {
    let pairs = upper.as_chunks::<2>().0.iter().zip(lower.as_chunks::<2>().0);
    for (out, (a, b)) in out.iter_mut().zip(pairs) {
        *out = 0.25 * ((a[0] + a[1]) + (b[0] + b[1]));
    }
}

/// Owner of pixels that planes show without a copy. Pixels must not change while a plane shows them.
pub trait PixelOwner: Send + Sync {
    /// Pixels, row by row, always the same.
    fn pixels(&self) -> &[f32];
}

#[derive(Clone)]
enum Pixels {
    Own(Vec<f32>),
    /// Pixels of another owner; copied before they are changed.
    Shared(Arc<dyn PixelOwner>),
}

impl Pixels {
    #[inline]
    fn get(&self) -> &[f32] {
        match self {
            Self::Own(pixels) => pixels,
            Self::Shared(owner) => owner.pixels(),
        }
    }

    fn get_mut(&mut self) -> &mut Vec<f32> {
        if let Self::Shared(owner) = self {
            *self = Self::Own(copied(owner.pixels()));
        }
        match self {
            Self::Own(pixels) => pixels,
            Self::Shared(_) => unreachable!("made its own above"),
        }
    }

    fn into_vec(self) -> Vec<f32> {
        match self {
            Self::Own(pixels) => pixels,
            Self::Shared(owner) => copied(owner.pixels()),
        }
    }
}

fn copied(pixels: &[f32]) -> Vec<f32> {
    let mut copy = memory::with_capacity(pixels.len());
    copy.extend_from_slice(pixels);
    copy
}

impl std::fmt::Debug for Pixels {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.get().fmt(f)
    }
}

impl PartialEq for Pixels {
    fn eq(&self, other: &Self) -> bool {
        self.get() == other.get()
    }
}
