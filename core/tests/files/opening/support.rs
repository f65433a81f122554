//! Files for the tests.

pub use crate::prelude::*;
pub use image::{ImageBuffer, Luma, Rgb};
pub use ndarray::{Array2, Array3, Array4};
pub use ndarray_npy::write_npy;
pub use std::slice::from_ref;
pub use tiff::{encoder::TiffEncoder, encoder::colortype, tags::Tag};

use image::Pixel;
use tiff::encoder::{TiffValue, colortype::ColorType};

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
    let file = fs::File::create(path).expect("created");
    let mut encoder = TiffEncoder::new(file).expect("a TIFF begins");
    pages.iter().for_each(|page| encoder.write_image::<C>(size.0, size.1, page).expect("a page is written"));
}

pub fn open(paths: &[PathBuf]) -> Result<Burst, Error> {
    Burst::open_with(paths, &OpenOptions::default(), &quiet())
}

pub fn open_with(path: &Path, options: &OpenOptions) -> Result<Burst, Error> {
    Burst::open_with(&[path.to_owned()], options, &quiet())
}

pub struct Made {
    pub folder: Folder,
    pub path: PathBuf,
}

impl Made {
    pub fn new(name: &str, bytes: &[u8]) -> Self {
        let (folder, path) = folder_with(name);
        fs::write(&path, bytes).expect("written");
        Self { folder, path }
    }

    pub fn open(&self, options: &OpenOptions) -> Result<Burst, Error> {
        open_with(&self.path, options)
    }

    pub fn info(&self, options: &OpenOptions) -> Info {
        Info::of(from_ref(&self.path), options, &quiet()).expect("described")
    }
}

/// Asserts that two lists are equal within a part in a million.
#[track_caller]
pub fn assert_close(found: &[f32], expected: &[f32]) {
    assert_eq!(found.len(), expected.len());
    for (i, (f, e)) in found.iter().zip(expected).enumerate() {
        assert!((f - e).abs() <= 1e-6 * e.abs().max(1e-3), "value {i} is {f}, expected {e}");
    }
}

/// A TIFF of one page, written by hand in either byte order, for variants that the encoder cannot write. `bits` are
/// those of each sample, `tags` are (tag, value) on top of the usual ones, and each element of `strips` is one strip as
/// high as the page.
pub fn raw_tiff(big_endian: bool, size: (u16, u16), bits: &[u16], tags: &[(u16, u16)], strips: &[&[u8]]) -> Vec<u8> {
    let short = |v: u16| if big_endian { v.to_be_bytes() } else { v.to_le_bytes() }.to_vec();
    let long = |v: usize| if big_endian { (v as u32).to_be_bytes() } else { (v as u32).to_le_bytes() }.to_vec();
    let mut bytes = if big_endian { b"MM\0*".to_vec() } else { b"II*\0".to_vec() };
    bytes.extend([0; 4]);
    // Appends data and returns its position; a tag's list of up to four bytes is stored in the tag itself.
    let place = |bytes: &mut Vec<u8>, data: &[u8]| {
        let at = long(bytes.len());
        bytes.extend(data);
        at
    };
    let list = |bytes: &mut Vec<u8>, data: Vec<u8>| if data.len() <= 4 { data } else { place(bytes, &data) };
    let bits_tag = list(&mut bytes, bits.iter().flat_map(|b| short(*b)).collect());
    let offsets = strips.iter().flat_map(|strip| place(&mut bytes, strip)).collect();
    let offsets_tag = list(&mut bytes, offsets);
    let counts_tag = list(&mut bytes, strips.iter().flat_map(|s| long(s.len())).collect());
    const SHORT: u16 = 3;
    const LONG: u16 = 4;
    let mut entries = vec![
        (256, SHORT, 1, short(size.0)),
        (257, SHORT, 1, short(size.1)),
        (258, SHORT, bits.len(), bits_tag),
        (259, SHORT, 1, short(1)),
        (273, LONG, strips.len(), offsets_tag),
        (277, SHORT, 1, short(bits.len() as u16)),
        (278, SHORT, 1, short(size.1)),
        (279, LONG, strips.len(), counts_tag),
    ];
    entries.extend(tags.iter().map(|(tag, value)| (*tag, SHORT, 1, short(*value))));
    entries.sort();
    let directory = long(bytes.len());
    bytes[4..8].copy_from_slice(&directory);
    bytes.extend(short(entries.len() as u16));
    for (tag, kind, count, mut value) in entries {
        value.resize(4, 0);
        bytes.extend([short(tag), short(kind), long(count), value].concat());
    }
    bytes.extend([0; 4]);
    bytes
}
