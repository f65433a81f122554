//! FITS images that are compressed in tiles. The tiles of an image lie in the rows of a table, which refer to bytes
//! behind it; those of one frame after the other. So a frame is decoded from its own rows: they are read, with the bytes
//! to which they refer, as a table of one frame. Format: section 10 of the FITS standard 4.0.

use crate::burst::options::Limits;
use crate::error::{Error, ErrorKind, Result};
use fitsio_pure::bintable::{BinaryColumnType, parse_binary_table_columns};
use fitsio_pure::hdu::{Hdu, HduInfo};
use fitsio_pure::header::Card;
use fitsio_pure::image::serialize_image;
use fitsio_pure::tiled::read_tiled_image;
use fitsio_pure::value::Value;
use flate2::read::MultiGzDecoder;
use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::path::Path;

const KIND: &str = "FITS";
/// Largest number of columns of the standard.
const MAX_COLUMNS: usize = 999;
/// Largest block of the Rice code; all writers take 16 or 32.
const MAX_BLOCK: usize = 1 << 15;
/// Length of the sequence of noise that was added before floats were rounded.
const NOISE: i64 = 10_000;

/// Way to the tiles of an image. A layer is the frames that tiles have in common: one, or several.
#[derive(Debug, Clone)]
pub(super) struct Tiles {
    cards: Vec<Card>,
    /// Place of the first row, and of the bytes to which rows refer.
    rows_at: u64,
    heap_at: u64,
    heap_bytes: u64,
    row_bytes: usize,
    layer_rows: usize,
    layer_frames: usize,
    frames: usize,
    tile_pixels: u64,
    references: Vec<Reference>,
}

/// Reference of a row to bytes: their number of elements, and where they begin.
#[derive(Debug, Clone)]
struct Reference {
    /// Place in the row.
    at: usize,
    /// Bytes of each of both numbers: 4 or 8.
    width: usize,
    element_bytes: u64,
    is_gzip: bool,
}

/// Whole number of a keyword.
fn whole(cards: &[Card], name: &str) -> Option<i64> {
    cards.iter().find(|card| card.keyword_str() == name).and_then(|card| match card.value {
        Some(Value::Integer(number)) => Some(number),
        _ => None,
    })
}

impl Tiles {
    /// Checks the sizes that the header `cards` of a table declares. The table's data begins at byte `data` of the
    /// `length` bytes of the file; its image has the `shape` (frames, rows, columns).
    pub(super) fn of(
        path: &Path,
        cards: Vec<Card>,
        (frames, height, width): (u64, u64, u64),
        (data, length): (u64, u64),
        limits: &Limits,
    ) -> Result<Self> {
        let corrupt = |reason: String| Error::corrupt(path, KIND, reason);
        limits.check_frame(path, width, height)?;
        limits.check_burst(path, frames, width, height)?;
        let Hdu { info, cards, data_len, .. } = Hdu::from_cards(cards, 0, 0).map_err(|e| corrupt(e.to_string()))?;
        let HduInfo::CompressedImage { ztile, naxis1, naxis2, zcmptype, blocksize, tfields, .. } = info else {
            return Err(corrupt("its table holds no image".to_owned()));
        };
        if zcmptype.starts_with("RICE") && !(1..=MAX_BLOCK).contains(&blocksize) {
            return Err(corrupt(format!("the blocks of the Rice code have {blocksize} pixels (ZVAL1)")));
        }
        let tile = |axis: usize, length: u64| match ztile.get(axis) {
            Some(0) => length,
            tile => tile.map_or(1, |tile| length.min(*tile as u64)),
        };
        let (tile_width, tile_height, layer_frames) = (tile(0, width), tile(1, height), tile(2, frames));
        if layer_frames.saturating_mul(width * height) > limits.max_pixels {
            let problem = format!("each tile of this image holds pixels of {layer_frames} frames");
            return Err(Error::new(ErrorKind::Unsupported, problem, "unpack it first, with funpack").about(path));
        }
        let layer_rows = width.div_ceil(tile_width) * height.div_ceil(tile_height);
        let tiles = layer_rows.saturating_mul(frames.div_ceil(layer_frames));
        let (bytes, there) = (data_len as u64, length.saturating_sub(data));
        if tiles > naxis2 as u64 || bytes > there {
            let reason = format!("{tiles} tiles in {bytes} bytes are announced; {naxis2} in {there} bytes are there");
            return Err(corrupt(reason));
        }
        if !(1..=MAX_COLUMNS).contains(&tfields) {
            return Err(corrupt(format!("its table has {tfields} columns (TFIELDS)")));
        }
        let (mut references, mut at) = (Vec::new(), 0usize);
        let columns = parse_binary_table_columns(&cards, tfields);
        for column in columns.map_err(|e| corrupt(format!("a column of its table (TFORM): {e}")))? {
            let form = match column.col_type {
                BinaryColumnType::VarArrayP(element) => Some((4, element)),
                BinaryColumnType::VarArrayQ(element) => Some((8, element)),
                _ => None,
            };
            let name = column.name.unwrap_or_default();
            let is_gzip = name.starts_with("GZIP") || zcmptype.starts_with("GZIP") && name == "COMPRESSED_DATA";
            references.extend(form.map(|(width, element)| {
                let element_bytes = match element {
                    'I' => 2,
                    'J' | 'E' => 4,
                    'K' | 'D' => 8,
                    _ => 1,
                };
                Reference { at, width, element_bytes, is_gzip }
            }));
            at = at.saturating_add(column.byte_width.max(form.map_or(0, |(width, _)| 2 * width)));
        }
        if at > naxis1 {
            return Err(corrupt(format!("the columns of its table take {at} bytes, a row has {naxis1}")));
        }
        let rows_bytes = (naxis1 as u64).saturating_mul(naxis2 as u64);
        let heap = whole(&cards, "THEAP").map_or(rows_bytes, |heap| heap.max(0) as u64);
        Ok(Self {
            cards,
            rows_at: data,
            heap_at: data.saturating_add(heap),
            heap_bytes: bytes.saturating_sub(heap),
            row_bytes: naxis1,
            layer_rows: layer_rows as usize,
            layer_frames: layer_frames as usize,
            frames: frames as usize,
            tile_pixels: tile_width * tile_height * layer_frames,
            references,
        })
    }

    pub(super) fn layer_of(&self, frame: u64) -> usize {
        frame as usize / self.layer_frames
    }

    /// Numbers of the frames of a layer, as an image without compression has them, and the first frame of it.
    pub(super) fn layer(&self, path: &Path, layer: usize) -> Result<(Vec<u8>, u64)> {
        let corrupt = |reason: String| Error::corrupt(path, KIND, reason);
        let bytes = self.table_of(path, layer)?;
        let first = layer * self.layer_frames;
        let noise = whole(&self.cards, "ZDITHER0").unwrap_or(1).wrapping_sub(1);
        let own = [
            ("NAXIS2", self.layer_rows as i64),
            ("ZNAXIS3", self.layer_frames.min(self.frames - first) as i64),
            ("ZDITHER0", (noise.rem_euclid(NOISE) + (layer * self.layer_rows) as i64) % NOISE + 1),
        ];
        let is_other = |card: &&Card| own.iter().all(|(name, _)| card.keyword_str() != *name);
        let mut cards: Vec<Card> = self.cards.iter().filter(is_other).cloned().collect();
        cards.extend(own.iter().flat_map(|(name, value)| Card::new(name, Value::Integer(*value))));
        let image = Hdu::from_cards(cards, 0, 0).and_then(|hdu| read_tiled_image(&bytes, &hdu));
        let image = image.map_err(|e| corrupt(format!("the tiles of frame {first}: {e}")))?;
        Ok((serialize_image(&image), first as u64))
    }

    /// Rows of a layer, and behind them the bytes to which they refer. Checks how much these unpack to.
    fn table_of(&self, path: &Path, layer: usize) -> Result<Vec<u8>> {
        let fail = |e: io::Error| Error::from_read(path, KIND, &e);
        let corrupt = |reason: String| Error::corrupt(path, KIND, reason);
        let mut file = BufReader::new(File::open(path).map_err(fail)?);
        let mut bytes = vec![0; self.layer_rows * self.row_bytes];
        let rows_end = bytes.len();
        file.seek(SeekFrom::Start(self.rows_at + (layer * rows_end) as u64)).map_err(fail)?;
        file.read_exact(&mut bytes).map_err(fail)?;
        // Bytes of a tile as numbers, and of one that has grown.
        let (most, most_packed) = (8 * self.tile_pixels, 16 * self.tile_pixels + 4096);
        for row in 0..self.layer_rows {
            for Reference { at, width, element_bytes, is_gzip } in &self.references {
                let at = row * self.row_bytes + at;
                let number = |at: usize| bytes[at..at + width].iter().fold(0, |value, byte| value << 8 | *byte as u64);
                let (length, place) = (number(at).saturating_mul(*element_bytes), number(at + width));
                let start = bytes.len();
                let moved = (start - rows_end) as u64;
                if length > most_packed || place.saturating_add(length) > self.heap_bytes || moved > u32::MAX as u64 {
                    let reason = format!("a tile has {length} bytes from byte {place} of {} on", self.heap_bytes);
                    return Err(corrupt(reason));
                }
                bytes[at + width..at + 2 * width].copy_from_slice(&moved.to_be_bytes()[8 - width..]);
                file.seek(SeekFrom::Start(self.heap_at + place)).map_err(fail)?;
                bytes.resize(start + length as usize, 0);
                file.read_exact(&mut bytes[start..]).map_err(fail)?;
                if *is_gzip && length > 0 {
                    let unpacked = &mut MultiGzDecoder::new(&bytes[start..]).take(most + 1);
                    let is_too_much = io::copy(unpacked, &mut io::sink()).is_ok_and(|length| length > most);
                    if is_too_much || !bytes[start..].starts_with(&[0x1f, 0x8b]) {
                        return Err(corrupt("a tile unpacks to more than its pixels, or is no gzip data".to_owned()));
                    }
                }
            }
        }
        Ok(bytes)
    }
}
