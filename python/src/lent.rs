//! Memory of numpy's arrays, read without a copy: the one place of the project with `unsafe`.
#![allow(unsafe_code)]

use burstscope::plane::PixelOwner;
use numpy::{PyArray2, PyArrayMethods};
use pyo3::prelude::*;

/// Contiguous array of float32, which lives as long as a plane shows it.
///
/// As everywhere in Python, nothing keeps others from writing into the array meanwhile; the documentation of `Burst`
/// asks not to.
pub(crate) struct LentArray {
    /// Keeps the memory.
    _array: Py<PyArray2<f32>>,
    pixels: *const f32,
    count: usize,
}

// SAFETY: the memory is only read, stays where it is while `_array` is held, and numpy lets any thread read it.
unsafe impl Send for LentArray {}
// SAFETY: as above; all access is through shared slices.
unsafe impl Sync for LentArray {}

impl LentArray {
    /// Holds `array`; `None` where its values do not follow one another in rows.
    pub(crate) fn of(array: &Bound<'_, PyArray2<f32>>) -> Option<Self> {
        let readonly = array.try_readonly().ok()?;
        let slice = readonly.as_slice().ok()?;
        Some(Self { _array: array.clone().unbind(), pixels: slice.as_ptr(), count: slice.len() })
    }
}

impl PixelOwner for LentArray {
    fn pixels(&self) -> &[f32] {
        // SAFETY: numpy gave this slice of an aligned, contiguous array, which is held.
        unsafe { std::slice::from_raw_parts(self.pixels, self.count) }
    }
}
