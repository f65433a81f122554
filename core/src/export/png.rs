//! PNG files of 8-bit RGB or RGBA pictures, as shown in the window.

use super::atomic::write_marked;
use crate::error::{Error, Result};
use crate::files::mark::{OutputKind, SOFTWARE};
use png::{BitDepth, ColorType, Compression, EncodingError, Filter};
use std::io::{self, Write};
use std::{borrow::Cow, path::Path};

/// 8-bit pixels in memory, row by row.
#[derive(Debug, Clone, Copy)]
pub struct Bitmap<'a> {
    width: usize,
    height: usize,
    has_alpha: bool,
    pixels: &'a [u8],
}

impl<'a> Bitmap<'a> {
    /// A picture of three bytes for each pixel: red, green, blue. Panics if there are not as many.
    pub fn rgb(width: usize, height: usize, pixels: &'a [u8]) -> Self {
        assert_eq!(pixels.len(), width * height * 3, "three bytes for each pixel");
        Self { width, height, has_alpha: false, pixels }
    }

    /// A picture of four bytes a pixel: red, green, blue and straight alpha. Panics if there are not as many.
    pub fn rgba(width: usize, height: usize, pixels: &'a [u8]) -> Self {
        assert_eq!(pixels.len(), width * height * 4, "four bytes for each pixel");
        Self { width, height, has_alpha: true, pixels }
    }

    /// (columns, rows).
    pub fn size(&self) -> (usize, usize) {
        (self.width, self.height)
    }

    pub(super) fn check_size(&self, path: &Path) -> Result<()> {
        // PNG's own limit is 2³¹ − 1 for each side.
        let fits = |side: usize| (1..=i32::MAX as usize).contains(&side);
        if fits(self.width) && fits(self.height) {
            return Ok(());
        }
        Err(Error::unfit(path, (self.width, self.height), "PNG"))
    }

    fn is_opaque(&self) -> bool {
        !self.has_alpha || self.pixels.chunks_exact(4).all(|pixel| pixel[3] == 255)
    }

    /// One byte a pixel where all are opaque greys.
    pub fn greys(&self) -> Option<Vec<u8>> {
        let bytes = if self.has_alpha { 4 } else { 3 };
        let pixels = || self.pixels.chunks_exact(bytes);
        let are_grey = self.is_opaque() && pixels().all(|pixel| pixel[0] == pixel[1] && pixel[1] == pixel[2]);
        are_grey.then(|| pixels().map(|pixel| pixel[0]).collect())
    }

    /// Pixels in as few bytes each as show all of them: grey, colours, or colours and alpha.
    fn reduced(&self) -> (ColorType, Cow<'_, [u8]>) {
        match self.greys() {
            Some(greys) => (ColorType::Grayscale, greys.into()),
            None if self.has_alpha && self.is_opaque() => {
                let colours: Vec<u8> = self.pixels.chunks_exact(4).flat_map(|pixel| &pixel[..3]).copied().collect();
                (ColorType::Rgb, colours.into())
            }
            None if self.has_alpha => (ColorType::Rgba, self.pixels.into()),
            None => (ColorType::Rgb, self.pixels.into()),
        }
    }

    pub(super) fn encode_png(&self, out: impl Write) -> io::Result<()> {
        let failed = |error: EncodingError| match error {
            EncodingError::IoError(error) => error,
            other => io::Error::other(other),
        };
        // Most pictures of bursts are grey, and a third as large so.
        let (kind, pixels) = self.reduced();
        let mut encoder = png::Encoder::new(out, self.width as u32, self.height as u32);
        encoder.set_color(kind);
        encoder.set_depth(BitDepth::Eight);
        encoder.set_compression(Compression::Balanced);
        encoder.set_filter(Filter::Adaptive);
        encoder.add_text_chunk("Software".to_owned(), SOFTWARE.to_owned()).map_err(failed)?;
        let mut writer = encoder.write_header().map_err(failed)?;
        writer.write_image_data(&pixels).map_err(failed)?;
        writer.finish().map_err(failed)
    }
}

/// Writes the picture as PNG.
pub fn write_png(path: &Path, picture: Bitmap<'_>) -> Result<()> {
    picture.check_size(path)?;
    write_marked(path, OutputKind::Picture, |out| picture.encode_png(out))
}
