//! Files for the tests.

use burstscope::Monitor;
use burstscope::burst::{Burst, OpenError, OpenOptions};
use image::{ImageBuffer, Luma, Pixel};
use std::path::{Path, PathBuf};
use tempfile::TempDir;
use tiff::encoder::{TiffEncoder, TiffValue, colortype::ColorType};

/// A new folder that disappears after the test.
pub fn folder() -> TempDir {
    tempfile::tempdir().expect("a temporary folder")
}

/// Saves a picture in the format of its name's ending.
pub fn save<P>(path: &Path, image: &ImageBuffer<P, Vec<P::Subpixel>>)
where
    P: Pixel + image::PixelWithColorType,
    [P::Subpixel]: image::EncodableLayout,
{
    image.save(path).expect("the picture can be saved");
}

/// A grey picture of 8 bit whose pixel (u, v) is `seed + 10·v + u`.
pub fn grey8(width: u32, height: u32, seed: u8) -> ImageBuffer<Luma<u8>, Vec<u8>> {
    ImageBuffer::from_fn(width, height, |u, v| Luma([seed.wrapping_add((10 * v + u) as u8)]))
}

/// A TIFF with one page for each element of `pages`.
pub fn tiff_pages<C: ColorType>(path: &Path, size: (u32, u32), pages: &[Vec<C::Inner>])
where
    [C::Inner]: TiffValue,
{
    let file = std::fs::File::create(path).expect("created");
    let mut encoder = TiffEncoder::new(file).expect("a TIFF begins");
    for page in pages {
        encoder.write_image::<C>(size.0, size.1, page).expect("a page is written");
    }
}

/// Opens files with the default options.
pub fn open(paths: &[PathBuf]) -> Result<Burst, OpenError> {
    Burst::open_with(paths, &OpenOptions::default(), &Monitor::default())
}

/// Asserts that two lists are the same within a part in a million.
#[track_caller]
pub fn assert_close(found: &[f32], expected: &[f32]) {
    assert_eq!(found.len(), expected.len());
    for (i, (f, e)) in found.iter().zip(expected).enumerate() {
        assert!((f - e).abs() <= 1e-6 * e.abs().max(1e-3), "value {i} is {f}, expected {e}");
    }
}
