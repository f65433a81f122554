//! PNG, as the picture library reads it, except that colour profiles and texts are skipped without being unpacked. A
//! few bytes of them can unpack to thousands of millions.

use image::error::{DecodingError, ImageFormatHint, LimitError, LimitErrorKind};
use image::{ColorType, ImageDecoder, ImageError, ImageFormat, ImageResult};
use png::{BitDepth, DecodeOptions, Decoder, Limits, Reader, Transformations};
use std::io::{BufRead, Seek};

/// A PNG whose header is read.
pub(super) struct PngPicture<R: BufRead + Seek> {
    reader: Reader<R>,
    color: ColorType,
}

impl<R: BufRead + Seek> PngPicture<R> {
    /// Reads the file up to the pixels. The decoder may take `max_bytes` besides them.
    pub(super) fn new(file: R, max_bytes: u64) -> ImageResult<Self> {
        let mut options = DecodeOptions::default();
        options.set_ignore_iccp_chunk(true);
        options.set_ignore_text_chunk(true);
        let mut decoder = Decoder::new_with_options(file, options);
        decoder.set_limits(Limits { bytes: usize::try_from(max_bytes).unwrap_or(usize::MAX) });
        // Palettes become colours, and fewer than eight bits become eight.
        decoder.set_transformations(Transformations::EXPAND);
        let reader = decoder.read_info().map_err(failure)?;
        use png::ColorType::{Grayscale, GrayscaleAlpha, Rgb, Rgba};
        let color = match reader.output_color_type() {
            (Grayscale, BitDepth::Eight) => ColorType::L8,
            (Grayscale, BitDepth::Sixteen) => ColorType::L16,
            (GrayscaleAlpha, BitDepth::Eight) => ColorType::La8,
            (GrayscaleAlpha, BitDepth::Sixteen) => ColorType::La16,
            (Rgb, BitDepth::Eight) => ColorType::Rgb8,
            (Rgb, BitDepth::Sixteen) => ColorType::Rgb16,
            (Rgba, BitDepth::Eight) => ColorType::Rgba8,
            (Rgba, BitDepth::Sixteen) => ColorType::Rgba16,
            (color, depth) => return Err(decoding(format!("pixels of {color:?} and {depth:?} were not expanded"))),
        };
        Ok(Self { reader, color })
    }
}

impl<R: BufRead + Seek> ImageDecoder for PngPicture<R> {
    fn dimensions(&self) -> (u32, u32) {
        self.reader.info().size()
    }

    fn color_type(&self) -> ColorType {
        self.color
    }

    fn exif_metadata(&mut self) -> ImageResult<Option<Vec<u8>>> {
        Ok(self.reader.info().exif_metadata.as_ref().map(|exif| exif.to_vec()))
    }

    fn read_image(mut self, buffer: &mut [u8]) -> ImageResult<()> {
        self.reader.next_frame(buffer).map_err(failure)?;
        // The file's end must follow the pixels.
        self.reader.finish().map_err(failure)?;
        if self.color.bytes_per_pixel() == 2 * self.color.channel_count() {
            for bytes in buffer.as_chunks_mut::<2>().0 {
                *bytes = u16::from_be_bytes(*bytes).to_ne_bytes();
            }
        }
        Ok(())
    }

    fn read_image_boxed(self: Box<Self>, buffer: &mut [u8]) -> ImageResult<()> {
        (*self).read_image(buffer)
    }
}

fn failure(error: png::DecodingError) -> ImageError {
    match error {
        png::DecodingError::IoError(error) => ImageError::IoError(error),
        png::DecodingError::LimitsExceeded => {
            ImageError::Limits(LimitError::from_kind(LimitErrorKind::InsufficientMemory))
        }
        error @ (png::DecodingError::Format(_) | png::DecodingError::Parameter(_)) => decoding(error),
    }
}

fn decoding(error: impl Into<Box<dyn std::error::Error + Send + Sync>>) -> ImageError {
    ImageError::Decoding(DecodingError::new(ImageFormatHint::Exact(ImageFormat::Png), error))
}
