//! Samples of a TIFF page. A page in planes and tiles is assembled here, tile by tile: the library (tiff 0.11.3) panics
//! where the size of such a page is no multiple of the tile's.

use std::fs::File;
use std::io::BufReader;
use tiff::TiffResult;
use tiff::decoder::{ChunkType, Decoder, DecodingResult};
use tiff::tags::Tag;

/// Decoder of a file.
pub(super) type FileDecoder = Decoder<BufReader<File>>;

/// Samples of a page.
pub(super) struct Samples {
    /// Interleaved, or plane after plane.
    pub samples: DecodingResult,
    /// Whether the samples are in planes.
    pub planar: bool,
}

/// Reads the decoder's current page, of `size` (columns, rows) and `channels` samples a pixel.
pub(super) fn read_samples(decoder: &mut FileDecoder, size: (usize, usize), channels: usize) -> TiffResult<Samples> {
    const PLANES: u16 = 2;
    let configuration = decoder.find_tag_unsigned::<u16>(Tag::PlanarConfiguration)?;
    let (tile_width, tile_height) = decoder.chunk_dimensions();
    let is_cut = !(size.0.is_multiple_of(tile_width as usize) && size.1.is_multiple_of(tile_height as usize));
    if decoder.get_chunk_type() == ChunkType::Tile && configuration == Some(PLANES) && channels > 1 && is_cut {
        let samples = planes_of_tiles(decoder, size, channels, (tile_width as usize, tile_height as usize))?;
        return Ok(Samples { samples, planar: true });
    }
    let mut samples = DecodingResult::U8(Vec::new());
    let layout = decoder.read_image_to_buffer(&mut samples)?;
    Ok(Samples { samples, planar: layout.planes > 1 })
}

fn planes_of_tiles(
    decoder: &mut FileDecoder,
    (width, height): (usize, usize),
    channels: usize,
    (tile_width, tile_height): (usize, usize),
) -> TiffResult<DecodingResult> {
    let across = width.div_ceil(tile_width);
    let tiles = across * height.div_ceil(tile_height);
    let mut whole: Option<DecodingResult> = None;
    for chunk in 0..tiles * channels {
        let tile = decoder.read_chunk(chunk as u32)?;
        let (columns, rows) = decoder.chunk_data_dimensions((chunk % tiles) as u32);
        let place = Place {
            // In samples from the start of the first plane.
            start: chunk / tiles * width * height
                + (chunk % tiles) / across * tile_height * width
                + (chunk % tiles) % across * tile_width,
            stride: width,
            columns: columns as usize,
            rows: rows as usize,
            samples: channels * width * height,
        };
        whole = Some(place.put(whole, tile));
    }
    Ok(whole.unwrap_or(DecodingResult::U8(Vec::new())))
}

/// Place of a tile's samples in the page.
struct Place {
    start: usize,
    stride: usize,
    columns: usize,
    rows: usize,
    samples: usize,
}

impl Place {
    /// Copies the tile into the page's samples, which are allocated at the first tile.
    fn put(&self, whole: Option<DecodingResult>, tile: DecodingResult) -> DecodingResult {
        macro_rules! kinds {
            ($($kind:ident)*) => {
                match (whole, tile) {
                    $((None, DecodingResult::$kind(tile)) => {
                        let mut samples = vec![Default::default(); self.samples];
                        self.copy(&mut samples, &tile);
                        DecodingResult::$kind(samples)
                    })*
                    $((Some(DecodingResult::$kind(mut samples)), DecodingResult::$kind(tile)) => {
                        self.copy(&mut samples, &tile);
                        DecodingResult::$kind(samples)
                    })*
                    // All tiles of a page are of one kind.
                    (Some(whole), _) => whole,
                }
            };
        }
        kinds!(U8 U16 U32 U64 I8 I16 I32 I64 F16 F32 F64)
    }

    fn copy<T: Copy>(&self, whole: &mut [T], tile: &[T]) {
        for (row, values) in tile.chunks_exact(self.columns.max(1)).take(self.rows).enumerate() {
            let start = self.start + row * self.stride;
            if let Some(target) = whole.get_mut(start..start + self.columns) {
                target.copy_from_slice(values);
            }
        }
    }
}
