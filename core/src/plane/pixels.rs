//! Memory that holds the pixels of a plane: its own, or that of another owner.

use std::fmt;
use std::sync::Arc;

/// Owner of pixels that planes show without a copy, such as an array of another program part. The pixels must stay the
/// same as long as a plane shows them.
pub trait PixelOwner: Send + Sync {
    /// The pixels, row by row.
    fn pixels(&self) -> &[f32];
}

#[derive(Clone)]
pub(super) enum Pixels {
    /// The plane's own.
    Own(Vec<f32>),
    /// Pixels of another owner; copied before they are changed.
    Shared(Arc<dyn PixelOwner>),
}

impl Pixels {
    #[inline]
    pub(super) fn get(&self) -> &[f32] {
        match self {
            Self::Own(pixels) => pixels,
            Self::Shared(owner) => owner.pixels(),
        }
    }

    /// All pixels, mutable and the plane's own.
    pub(super) fn get_mut(&mut self) -> &mut Vec<f32> {
        if let Self::Shared(owner) = self {
            *self = Self::Own(copied(owner.pixels()));
        }
        match self {
            Self::Own(pixels) => pixels,
            Self::Shared(_) => unreachable!("made its own above"),
        }
    }

    pub(super) fn into_vec(self) -> Vec<f32> {
        match self {
            Self::Own(pixels) => pixels,
            Self::Shared(owner) => copied(owner.pixels()),
        }
    }
}

fn copied(pixels: &[f32]) -> Vec<f32> {
    let mut copy = super::memory::with_capacity(pixels.len());
    copy.extend_from_slice(pixels);
    copy
}

impl fmt::Debug for Pixels {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.get().fmt(f)
    }
}

impl PartialEq for Pixels {
    fn eq(&self, other: &Self) -> bool {
        self.get() == other.get()
    }
}

#[cfg(test)]
mod tests {
    use super::super::Plane;
    use super::*;

    struct Array(Vec<f32>);

    impl PixelOwner for Array {
        fn pixels(&self) -> &[f32] {
            &self.0
        }
    }

    #[test]
    fn shared_pixels_are_shown_in_place_and_copied_before_a_change() {
        let array = Arc::new(Array(vec![1.0, 2.0, 3.0, 4.0]));
        let plane = Plane::from_shared(2, 2, array.clone());
        assert!(std::ptr::eq(plane.data(), array.pixels()));
        let mut changed = plane.clone();
        changed.data_mut()[3] = 9.0;
        changed.row_mut(0)[0] = 7.0;
        assert_eq!((changed.data(), array.pixels()), (&[7.0, 2.0, 3.0, 9.0][..], &[1.0, 2.0, 3.0, 4.0][..]));
        assert_eq!(plane, Plane::from_vec(2, 2, plane.clone().into_vec()));
    }
}
