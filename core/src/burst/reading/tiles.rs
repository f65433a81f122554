//! FITS images that are compressed in tiles. The tiles of an image lie in the rows of a table, which refer to bytes
//! behind it; those of one frame after the other. Format: section 10 of the FITS standard 4.0.
//!
//! The table is read here alone, and so is gzip data. The decoder of the tiles gets a table that is made of what was
//! read and checked, of one layer of frames: it finds no number of the file that could lead it astray.

use super::Reading;
use crate::error::{Error, ErrorKind, Result};
use crate::{burst::options::Limits, plane::memory};
use fitsio_pure::bintable::{BinaryColumnType, parse_binary_table_columns};
use fitsio_pure::hdu::{Hdu, HduInfo};
use fitsio_pure::{header::Card, image::serialize_image, tiled::read_tiled_image, value::Value};
use flate2::bufread::GzDecoder;
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::{fs::File, path::Path};

const KIND: &str = "FITS";
const MAX_COLUMNS: usize = 999;
/// Largest row of a table; those of images have some tens of bytes.
const MAX_ROW_BYTES: u64 = 1 << 16;
/// Largest block of the Rice code; all writers take 16 or 32.
const MAX_BLOCK: usize = 1 << 15;
/// Length of the sequence of noise that was added before floats were rounded.
const NOISE: i64 = 10_000;
/// Most bytes that a byte of gzip data unpacks to.
const MOST_OF_BYTE: u64 = 1032;
/// Bytes of both references in a row of the decoder's table.
const REFERENCES_BYTES: usize = 32;
/// Columns with a number for each tile, and their lengths in bytes.
const NUMBERS: [(&str, &str, usize); 3] = [("ZSCALE", "1D", 8), ("ZZERO", "1D", 8), ("ZBLANK", "1J", 4)];
/// Keywords that the decoder gets as they are, besides those of the code's parameters.
const KEPT: [&str; 6] = ["ZIMAGE", "ZBITPIX", "ZQUANTIZ", "ZSCALE", "ZZERO", "ZBLANK"];

/// Compression of tiles, as far as their length can be told from their pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Code {
    /// Bytes of the first pixel, bits of a block of pixels at least, and pixels of a block.
    Rice(u64, u64, u64),
    /// gzip data; whether all first bytes of the pixels come first, then all second ones.
    Gzip { is_shuffled: bool },
    /// Tiles as they are.
    Plain,
    /// Packed in another way, which the decoder alone checks.
    Other,
}

#[derive(Debug, Clone)]
pub struct Tiles {
    /// Header of the decoder's table, but for what differs from layer to layer.
    cards: Vec<Card>,
    first_noise: i64,
    /// Place of the first row, and of the bytes to which rows refer.
    rows_at: u64,
    heap_at: u64,
    heap_bytes: u64,
    row_bytes: usize,
    /// Columns and rows of the image, and of a tile.
    size: [u64; 2],
    tile: [u64; 2],
    layer_frames: u64,
    frames: u64,
    code: Code,
    /// Bytes of a pixel, and those that a pixel of gzip data may have.
    pixel_bytes: u64,
    widths: Vec<u64>,
    packed: Reference,
    /// References to pixels that could not be packed: as they are, and as gzip data.
    plain: Option<Reference>,
    gzip: Option<Reference>,
    /// Places in a row, and lengths, of the numbers of each tile.
    numbers: Vec<(usize, usize)>,
}

/// Reference of a row to bytes: their number of elements, and where they begin.
#[derive(Debug, Clone, Copy)]
struct Reference {
    at: usize,
    /// Bytes of each of both numbers: 4 or 8.
    width: usize,
    element_bytes: u64,
}

fn find<'a>(cards: &'a [Card], name: &str) -> Option<&'a Value> {
    cards.iter().find(|card| card.keyword_str() == name)?.value.as_ref()
}

fn whole(cards: &[Card], name: &str) -> Option<i64> {
    if let Some(Value::Integer(number)) = find(cards, name) { Some(*number) } else { None }
}

fn card(name: &str, value: Value) -> Card {
    Card::new(name, value).expect("a keyword of the standard")
}

impl Tiles {
    /// Checks the sizes that the header `cards` of a table declares: rows of the axes `table` (bytes, rows) from byte
    /// `data` of the file's `length` bytes on, and an image of this shape (frames, rows, columns).
    pub fn of(
        path: &Path,
        cards: &[Card],
        table: &[u64],
        (frames, height, width): (u64, u64, u64),
        (data, length): (u64, u64),
        limits: &Limits,
    ) -> Result<Self> {
        let corrupt = |reason: String| Error::corrupt(path, KIND, reason);
        limits.check_frame(path, width, height)?;
        limits.check_burst(path, frames, width, height)?;
        let there = length.saturating_sub(data);
        let [row_bytes, rows] = *table else {
            return Err(corrupt(format!("its table has {} axes (NAXIS), not 2", table.len())));
        };
        let rows_bytes = row_bytes.saturating_mul(rows);
        if rows_bytes > there || row_bytes > MAX_ROW_BYTES {
            let reason =
                format!("{rows} rows of {row_bytes} bytes (NAXIS1, NAXIS2) are announced; {there} bytes are there");
            return Err(corrupt(reason));
        }
        let hdu = Hdu::from_cards(cards.to_vec(), 0, 0).map_err(|e| corrupt(e.to_string()))?;
        let HduInfo::CompressedImage { ztile, zcmptype, blocksize, rice_bytepix, tfields, zbitpix, .. } = hdu.info
        else {
            return Err(corrupt("its table holds no image".to_owned()));
        };
        if zcmptype.starts_with("RICE") && !(1..=MAX_BLOCK).contains(&blocksize) {
            return Err(corrupt(format!("the blocks of the Rice code have {blocksize} pixels (ZVAL1)")));
        }
        let code = match (&*zcmptype, rice_bytepix) {
            ("GZIP_1", _) => Code::Gzip { is_shuffled: false },
            ("GZIP_2", _) => Code::Gzip { is_shuffled: true },
            ("NOCOMPRESS", _) => Code::Plain,
            ("RICE_1" | "RICE_ONE", 1 | 2 | 4) => {
                // A block of equal pixels takes only its header: 3, 4 or 5 bits for pixels of 1, 2 or 4 bytes.
                Code::Rice(rice_bytepix as u64, 3 + rice_bytepix.ilog2() as u64, blocksize as u64)
            }
            _ => Code::Other,
        };
        let tile = |axis: usize, length: u64| match ztile.get(axis) {
            Some(0) => length,
            tile => tile.map_or(1, |tile| length.min(*tile as u64)),
        };
        let (tile, layer_frames) = ([tile(0, width), tile(1, height)], tile(2, frames));
        if layer_frames.saturating_mul(width * height) > limits.max_pixels {
            let problem = format!("each tile of this image holds pixels of {layer_frames} frames");
            return Err(Error::new(ErrorKind::Unsupported, problem, "unpack it first, with funpack").about(path));
        }
        let layer_rows = width.div_ceil(tile[0]) * height.div_ceil(tile[1]);
        let tiles = layer_rows.saturating_mul(frames.div_ceil(layer_frames));
        // The heap follows the rows unless THEAP says otherwise; PCOUNT counts the gap too.
        let heap = whole(cards, "THEAP").map_or(rows_bytes, |heap| heap.max(0) as u64);
        let heap_bytes = whole(cards, "PCOUNT").map_or(0, |bytes| bytes.max(0) as u64).saturating_add(rows_bytes);
        if tiles > rows || heap_bytes > there || heap < rows_bytes {
            let reason =
                format!("{tiles} tiles in {heap_bytes} bytes are announced; {rows} in {there} bytes are there");
            return Err(corrupt(reason));
        }
        if !(1..=MAX_COLUMNS).contains(&tfields) {
            return Err(corrupt(format!("its table has {tfields} columns (TFIELDS)")));
        }
        // Columns of the decoder's table: the bytes of a tile, packed or not, then the numbers of each tile.
        let mut own = vec![("COMPRESSED_DATA", "1QB"), ("UNCOMPRESSED_DATA", "1QB")];
        let (mut references, mut numbers, mut at) = ([None; 3], Vec::new(), 0usize);
        let columns = parse_binary_table_columns(cards, tfields);
        for column in columns.map_err(|e| corrupt(format!("a column of its table (TFORM): {e}")))? {
            let name = column.name.as_deref().unwrap_or_default().trim();
            let wrong =
                || corrupt(format!("the column {name} of its table has another type (TFORM) than that of its meaning"));
            let (form, width) = match column.col_type {
                BinaryColumnType::VarArrayP(element) => (Some((4, element)), 8),
                BinaryColumnType::VarArrayQ(element) => (Some((8, element)), 16),
                _ => (None, column.byte_width),
            };
            let names = ["COMPRESSED_DATA", "UNCOMPRESSED_DATA", "GZIP_COMPRESSED_DATA"];
            // A column of no elements takes no bytes in a row.
            let is_there = column.repeat == 1;
            if let Some(slot) = names.iter().position(|own| *own == name) {
                let (width, element) = form.filter(|_| is_there).ok_or_else(wrong)?;
                let element_bytes = match element {
                    'B' => 1,
                    'I' => 2,
                    'J' | 'E' => 4,
                    'K' | 'D' => 8,
                    _ => return Err(wrong()),
                };
                references[slot].get_or_insert(Reference { at, width, element_bytes });
            } else if let Some((name, form, bytes)) = NUMBERS.into_iter().find(|(own, ..)| *own == name) {
                let is_right = match column.col_type {
                    BinaryColumnType::Double => bytes == 8,
                    BinaryColumnType::Int => bytes == 4,
                    _ => false,
                };
                if !is_right || !is_there {
                    return Err(wrong());
                }
                own.push((name, form));
                numbers.push((at, bytes));
            }
            at = at.saturating_add(if form.is_some() { width.saturating_mul(column.repeat) } else { width });
        }
        if at as u64 > row_bytes {
            return Err(corrupt(format!("the columns of its table take {at} bytes, a row has {row_bytes}")));
        }
        let [packed, plain, gzip] = references;
        let packed = packed.ok_or_else(|| corrupt("its table has no column COMPRESSED_DATA".to_owned()))?;
        let is_given = |name| find(cards, name).is_some() || own.iter().any(|(own, _)| *own == name);
        // Floats are packed as integers only where both scale and zero are there.
        let is_rounded = !matches!(find(cards, "ZQUANTIZ"), Some(Value::String(text)) if text.trim() == "NONE")
            && is_given("ZSCALE")
            && is_given("ZZERO");
        let pixel_bytes = zbitpix.unsigned_abs() / 8;
        // cfitsio packs small numbers as larger ones too.
        let widths = match zbitpix {
            -64 | -32 if is_rounded => vec![2, 4],
            8 => vec![1, 4],
            16 => vec![2, 4],
            _ => vec![pixel_bytes],
        };
        // Only these keywords of the file reach the decoder; all sizes are written anew.
        let parameters = |name: &str| name.starts_with("ZNAME") || name.starts_with("ZVAL");
        let kept = cards.iter().filter(|card| KEPT.contains(&card.keyword_str()) || parameters(card.keyword_str()));
        let mut header: Vec<Card> = kept.cloned().collect();
        let text = |text: &str| Value::String(text.to_owned());
        // gzip data is unpacked here, so the decoder gets plain bytes.
        let unpacked = if matches!(code, Code::Gzip { .. }) { "NOCOMPRESS" } else { &zcmptype };
        header.extend([card("XTENSION", text("BINTABLE")), card("ZCMPTYPE", text(unpacked))]);
        let own_bytes = REFERENCES_BYTES + numbers.iter().map(|(_, bytes)| bytes).sum::<usize>();
        let sizes = [
            ("BITPIX", 8),
            ("NAXIS", 2),
            ("NAXIS1", own_bytes as u64),
            ("PCOUNT", 0),
            ("GCOUNT", 1),
            ("TFIELDS", own.len() as u64),
            ("ZNAXIS", 3),
            ("ZNAXIS1", width),
            ("ZNAXIS2", height),
            ("ZTILE1", tile[0]),
            ("ZTILE2", tile[1]),
            ("ZTILE3", layer_frames),
        ];
        header.extend(sizes.map(|(name, value)| card(name, Value::Integer(value as i64))));
        header.extend(own.iter().zip(1..).flat_map(|((name, form), number)| {
            [card(&format!("TTYPE{number}"), text(name)), card(&format!("TFORM{number}"), text(form))]
        }));
        Ok(Self {
            cards: header,
            first_noise: whole(cards, "ZDITHER0").unwrap_or(1).wrapping_sub(1).rem_euclid(NOISE),
            rows_at: data,
            heap_at: data.saturating_add(heap),
            heap_bytes: heap_bytes.saturating_sub(heap),
            row_bytes: row_bytes as usize,
            size: [width, height],
            tile,
            layer_frames,
            frames,
            code,
            pixel_bytes,
            widths,
            packed,
            plain,
            gzip,
            numbers,
        })
    }

    pub fn layer_of(&self, frame: u64) -> u64 {
        frame / self.layer_frames
    }

    /// Tiles across a frame, and of a layer.
    fn counts(&self) -> (u64, u64) {
        let [across, down] = [0, 1].map(|axis| self.size[axis].div_ceil(self.tile[axis]));
        (across, across * down)
    }

    pub fn layer_bytes(&self) -> u64 {
        let pixels = self.layer_frames * self.size[0] * self.size[1];
        // Packed, unpacked and written out; numbers of one tile in the decoder; rows with what surrounds their pixels.
        let tile = self.layer_frames * self.tile[0] * self.tile[1];
        pixels * (8 + 2 * self.pixel_bytes) + 40 * tile + 600 * self.counts().1
    }

    /// Numbers of the frames of a layer, as an image without compression has them, and the first frame of it.
    pub fn layer(&self, reading: Reading<'_>, layer: u64) -> Result<(Vec<u8>, u64)> {
        let corrupt = |reason: String| Error::corrupt(reading.path, KIND, reason);
        let first = layer * self.layer_frames;
        let depth = self.layer_frames.min(self.frames - first);
        let bytes = self.table_of(reading, layer, depth)?;
        let (_, rows) = self.counts();
        // The sequence goes on from tile to tile.
        let noise = (self.first_noise + (layer * rows) as i64 % NOISE) % NOISE + 1;
        let own = [("NAXIS2", rows as i64), ("ZNAXIS3", depth as i64), ("ZDITHER0", noise)];
        let mut cards = self.cards.clone();
        cards.extend(own.map(|(name, value)| card(name, Value::Integer(value))));
        let image = Hdu::from_cards(cards, 0, 0).and_then(|hdu| read_tiled_image(&bytes, &hdu));
        let image = image.map_err(|e| corrupt(format!("the tiles of frame {first}: {e}")))?;
        Ok((serialize_image(&image), first))
    }

    /// The decoder's table of a layer of `depth` frames: rows, and behind them the bytes to which they refer.
    fn table_of(&self, reading: Reading<'_>, layer: u64, depth: u64) -> Result<Vec<u8>> {
        let fail = |e: io::Error| Error::from_read(reading.path, KIND, &e);
        let mut file = BufReader::new(File::open(reading.path).map_err(fail)?);
        let (across, rows) = self.counts();
        let own_bytes = REFERENCES_BYTES + self.numbers.iter().map(|(_, bytes)| bytes).sum::<usize>();
        let rows_end = rows as usize * own_bytes;
        let mut bytes = memory::zeroed(rows_end);
        let mut row = vec![0; self.row_bytes];
        for number in 0..rows {
            reading.ticker.check()?;
            let place = layer * rows + number;
            file.seek(SeekFrom::Start(self.rows_at + place * self.row_bytes as u64)).map_err(fail)?;
            file.read_exact(&mut row).map_err(fail)?;
            let at = [number % across * self.tile[0], number / across * self.tile[1]];
            let [width, height] = [0, 1].map(|axis| self.tile[axis].min(self.size[axis] - at[axis]));
            let (tile, is_packed) = self.tile_of(&mut file, &row, width * height * depth).map_err(|e| {
                let reason = match e.kind() {
                    io::ErrorKind::InvalidData => format!("tile {place}: {e}"),
                    _ => return fail(e),
                };
                Error::corrupt(reading.path, KIND, reason)
            })?;
            let own = number as usize * own_bytes;
            let reference = own + if is_packed { 0 } else { REFERENCES_BYTES / 2 };
            // References count from the end of the rows, where the bytes of tiles begin.
            let numbers = [tile.len() as u64, (bytes.len() - rows_end) as u64].map(u64::to_be_bytes);
            bytes[reference..reference + REFERENCES_BYTES / 2].copy_from_slice(&numbers.concat());
            let mut end = own + REFERENCES_BYTES;
            for (at, length) in &self.numbers {
                bytes[end..end + length].copy_from_slice(&row[*at..at + length]);
                end += length;
            }
            bytes.extend_from_slice(&tile);
            // Tiles may share bytes of the heap, so their sum is limited too.
            if bytes.len() as u64 > self.layer_bytes() {
                let reason = format!("the tiles up to {place} have far more bytes than their pixels");
                return Err(Error::corrupt(reading.path, KIND, reason));
            }
        }
        Ok(bytes)
    }

    /// Bytes of a tile of `pixels` pixels, gzip unpacked, and whether still packed. `InvalidData`: of another length.
    fn tile_of(&self, file: &mut (impl Read + Seek), row: &[u8], pixels: u64) -> io::Result<(Vec<u8>, bool)> {
        let wrong = |reason: String| io::Error::new(io::ErrorKind::InvalidData, reason);
        let mut bytes_of = |reference: &Reference| {
            let number = |at: usize| row[at..at + reference.width].iter().fold(0, |n, byte| n << 8 | u64::from(*byte));
            let [elements, place] = [0, 1].map(|half| number(reference.at + half * reference.width));
            let length = elements.saturating_mul(reference.element_bytes);
            // Bytes of pixels as numbers, and of those that have grown in packing.
            if length > 16 * pixels + 4096 || place.saturating_add(length) > self.heap_bytes {
                return Err(wrong(format!("it has {length} bytes from byte {place} of {} on", self.heap_bytes)));
            }
            let mut bytes = memory::zeroed(length as usize);
            if length > 0 {
                file.seek(SeekFrom::Start(self.heap_at + place))?;
                file.read_exact(&mut bytes)?;
            }
            Ok(bytes)
        };
        let packed = bytes_of(&self.packed)?;
        let length = packed.len() as u64;
        let lengths = |widths: &[u64]| widths.iter().map(|width| width * pixels).collect::<Vec<_>>();
        // Pixels that could not be packed lie in another column.
        if length == 0 {
            let plain = self.plain.as_ref().map_or_else(|| Ok(Vec::new()), &mut bytes_of)?;
            let gzip = self.gzip.as_ref().filter(|_| plain.is_empty()).map(&mut bytes_of).transpose()?;
            let wanted = [self.pixel_bytes * pixels];
            let plain = match gzip {
                Some(gzip) if !gzip.is_empty() => gunzip(&gzip, &wanted).map_err(wrong)?,
                _ => plain,
            };
            if plain.len() as u64 != wanted[0] {
                return Err(wrong(format!("its {pixels} pixels have {} bytes, and not {}", plain.len(), wanted[0])));
            }
            return Ok((plain, false));
        }
        match self.code {
            Code::Gzip { is_shuffled } => {
                let unpacked = gunzip(&packed, &lengths(&self.widths)).map_err(wrong)?;
                Ok((if is_shuffled { in_turn(&unpacked, pixels as usize) } else { unpacked }, true))
            }
            Code::Plain if !lengths(&self.widths).contains(&length) => {
                Err(wrong(format!("its {pixels} pixels have {length} bytes")))
            }
            Code::Rice(first, bits, block)
                if length <= first || 8 * length < 8 * first + bits * pixels.div_ceil(block) =>
            {
                Err(wrong(format!("its {length} bytes are too few for {pixels} pixels")))
            }
            _ => Ok((packed, true)),
        }
    }
}

/// Unpacks gzip data, which has to give one of the numbers of bytes `wanted`. The error is the end of a sentence.
fn gunzip(packed: &[u8], wanted: &[u64]) -> Result<Vec<u8>, String> {
    let most = wanted.iter().copied().max().unwrap_or_default();
    let possible = most.min(MOST_OF_BYTE * packed.len() as u64);
    let mut unpacked = memory::with_capacity(possible as usize + 1);
    let mut decoder = GzDecoder::new(packed);
    let ended = (&mut decoder).take(possible + 1).read_to_end(&mut unpacked);
    if unpacked.len() as u64 > most {
        return Err("it unpacks to more than its pixels".to_owned());
    }
    ended.map_err(|e| format!("its gzip data: {e}"))?;
    if !wanted.contains(&(unpacked.len() as u64)) {
        let wanted: Vec<String> = wanted.iter().map(u64::to_string).collect();
        return Err(format!("it unpacks to {} bytes, and its pixels have {}", unpacked.len(), wanted.join(" or ")));
    }
    // Blocks are filled up with zeros.
    if decoder.into_inner().iter().any(|byte| *byte != 0) {
        return Err("bytes follow its gzip data".to_owned());
    }
    Ok(unpacked)
}

/// Pixels byte by byte, from data with all first bytes first, then all second ones.
fn in_turn(planes: &[u8], pixels: usize) -> Vec<u8> {
    let width = planes.len() / pixels;
    let mut bytes = memory::zeroed(planes.len());
    for (plane, own) in planes.chunks_exact(pixels).enumerate() {
        bytes[plane..].iter_mut().step_by(width).zip(own).for_each(|(byte, own)| *byte = *own);
    }
    bytes
}
