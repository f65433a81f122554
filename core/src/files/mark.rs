//! The mark by which Burstscope recognises what it wrote, so that it replaces this alone without being told to.
//!
//! A [`Mark`] is one record, in JSON: program, kind of the output, format of the mark, and length and checksum of what
//! it claims. It stands in a text chunk of PNG, a comment of GIF, ZIP, XML, PDF and LaTeX, a free box of MP4, or a
//! comment line, at the end of a file, and claims all bytes before; in `Software` of TIFF, for samples; in a
//! [file](OutputKind::file) of a folder. COLMAP's database has a number in its header alone, a matched pair its first
//! line, and tables have none, see [`is_ours`](crate::export::is_ours).

use super::{MAX_TABLE_BYTES, next_bytes, path_text, read_text};
use serde::{Deserialize, Serialize, de::DeserializeOwned};
use serde_json::Value;
use std::io::{self, BufReader, Read, Seek, SeekFrom, Write};
use std::{collections::BTreeMap, fs::File, path::Path};
use tiff::{decoder::Decoder, tags::Tag};

/// The program's name and version, for the `Software` field of pictures.
pub(crate) const SOFTWARE: &str = concat!("Burstscope ", env!("CARGO_PKG_VERSION"));
/// Application id of COLMAP's databases that this program wrote, in the field that SQLite has for it.
pub(crate) const DATABASE_ID: u32 = u32::from_be_bytes(*b"Brst");
/// Begin of a file of a matched pair, of any form.
const PAIR_MARK: &[u8] = b"Burstscope pair ";
const FORMAT: u32 = 1;
/// Number of bytes at the start of a file that tell its format.
const HEAD: u64 = 128;
/// Number of bytes at the end of a file that hold its mark.
const TAIL: u64 = 1024;

/// Kind of an output.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum OutputKind {
    /// Folder of a synthetic burst: a chart or a scene.
    Burst,
    /// Folder of noisy copies.
    NoisyCopies,
    /// Folder of a trajectory.
    Trajectory,
    /// Folder of a dataset for COLMAP.
    Dataset,
    /// Folder of figures.
    Figures,
    /// Hidden folder of work that is not finished.
    Unfinished,
    /// PNG or TIFF.
    Picture,
    /// GIF or MP4.
    Film,
    /// SVG, PDF or LaTeX.
    Drawing,
    /// HTML or Markdown.
    Page,
    /// Features, or a field of motion, in NumPy's archive.
    Features,
    /// Case.
    Case,
    /// Parameters, or a session.
    Settings,
}

impl OutputKind {
    /// File with the mark of a folder of this kind.
    pub fn file(self) -> &'static str {
        match self {
            Self::Dataset => "manifest.json",
            Self::Unfinished => "in-use",
            _ => ".burstscope.json",
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Program {
    Burstscope,
}

/// Mark of an output.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Mark {
    program: Program,
    version: String,
    kind: OutputKind,
    format: u32,
    #[serde(flatten)]
    content: Checksum,
}

impl Mark {
    /// The mark of an output of this program that claims `content`.
    pub fn new(kind: OutputKind, content: Checksum) -> Self {
        let version = env!("CARGO_PKG_VERSION").to_owned();
        Self { program: Program::Burstscope, version, kind, format: FORMAT, content }
    }

    /// The mark on one line.
    pub fn text(&self) -> String {
        serde_json::to_string(self).expect("a mark is plain values")
    }

    fn parsed(text: &[u8]) -> Option<Self> {
        serde_json::from_slice(text).ok().filter(|mark: &Self| mark.format == FORMAT)
    }
}

/// Length and checksum by which an altered file is recognised.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Checksum {
    bytes: u64,
    crc32: u32,
}

impl Checksum {
    /// The checksum of these bytes.
    pub fn of(bytes: &[u8]) -> Self {
        Self { bytes: bytes.len() as u64, crc32: crc32fast::hash(bytes) }
    }

    /// The checksum of the file at `path`.
    pub fn of_file(path: &Path) -> io::Result<Self> {
        Self::of_parts(&mut super::open(path)?, &[(0, u64::MAX)])
    }

    /// The checksum of parts of a file, each from an offset on and of at most so many bytes.
    fn of_parts(file: &mut File, parts: &[(u64, u64)]) -> io::Result<Self> {
        let (mut hasher, mut piece, mut bytes) = (crc32fast::Hasher::new(), Vec::with_capacity(1 << 16), 0);
        for &(offset, length) in parts {
            file.seek(SeekFrom::Start(offset))?;
            let mut part = file.take(length);
            while part.by_ref().take(1 << 16).read_to_end(&mut piece)? > 0 {
                hasher.update(&piece);
                bytes += piece.len() as u64;
                piece.clear();
            }
        }
        Ok(Self { bytes, crc32: hasher.finalize() })
    }

    /// Whether the file at `path` has the same length; checked without reading it.
    pub fn is_as_long_as(&self, path: &Path) -> bool {
        std::fs::metadata(path).is_ok_and(|file| file.is_file() && file.len() == self.bytes)
    }

    /// Whether the file at `path` has this content. A file of another length is not read.
    pub fn is_of(&self, path: &Path) -> bool {
        self.is_as_long_as(path) && Self::of_file(path).is_ok_and(|now| now == *self)
    }
}

/// Place of the mark in a file that has it at its end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum MarkPlace {
    Png,
    Gif,
    Mp4,
    Zip,
    Xml,
    Pdf,
    Latex,
    Line,
}

impl MarkPlace {
    fn of(head: &[u8]) -> Self {
        let starts: [(usize, &[u8], Self); 7] = [
            (0, b"\x89PNG\r\n\x1a\n", Self::Png),
            (0, b"GIF8", Self::Gif),
            (4, b"ftyp", Self::Mp4),
            (0, b"PK\x03\x04", Self::Zip),
            (0, b"<", Self::Xml),
            (0, b"%PDF", Self::Pdf),
            (0, b"% ", Self::Latex),
        ];
        let begins = |at: usize, start: &[u8]| head.get(at..).is_some_and(|rest| rest.starts_with(start));
        starts.into_iter().find(|(at, start, _)| begins(*at, start)).map_or(Self::Line, |(.., place)| place)
    }

    /// The end of a file, in place of which the mark comes: the last chunk or block, or the length of an empty comment.
    fn end(self) -> &'static [u8] {
        match self {
            Self::Png => b"\0\0\0\0IEND\xae\x42\x60\x82",
            Self::Gif => b"\x3b",
            Self::Zip => b"\0\0",
            Self::Mp4 | Self::Xml | Self::Pdf | Self::Latex | Self::Line => b"",
        }
    }

    fn marked_end(self, text: &[u8]) -> Vec<u8> {
        match self {
            Self::Png => {
                let data = [b"tEXtBurstscope\0", text].concat();
                let length = (data.len() as u32 - 4).to_be_bytes();
                [&length[..], &data, &crc32fast::hash(&data).to_be_bytes(), self.end()].concat()
            }
            // A block of a comment has at most 255 bytes.
            Self::Gif => {
                let blocks = text.chunks(255).flat_map(|part| [&[part.len() as u8], part].concat());
                [b"\x21\xfe".to_vec(), blocks.collect(), vec![0], self.end().to_vec()].concat()
            }
            // A box with its length and kind, which readers pass over.
            Self::Mp4 => [&(text.len() as u32 + 8).to_be_bytes()[..], b"free", text].concat(),
            Self::Zip => [&(text.len() as u16).to_le_bytes(), text].concat(),
            Self::Xml => [b"<!-- ", text, b" -->\n"].concat(),
            // Readers look for the end of a PDF in its last thousand bytes.
            Self::Pdf => [b"\n% ", text, b"\n"].concat(),
            Self::Latex => [b"% ", text, b"\n"].concat(),
            Self::Line => [b"# ", text, b"\n"].concat(),
        }
    }
}

/// Puts the mark into a PNG, GIF, MP4, ZIP, XML or PDF file, or as a last comment line; an error for a cut file.
pub fn seal(file: &mut File, kind: OutputKind) -> io::Result<()> {
    let place = MarkPlace::of(&part_of(file, 0, HEAD)?);
    let before = file.seek(SeekFrom::End(0))?.saturating_sub(place.end().len() as u64);
    if part_of(file, before, TAIL)? != place.end() {
        return Err(io::Error::other("this file does not end as its format does, and takes no mark"));
    }
    let mark = Mark::new(kind, Checksum::of_parts(file, &[(0, before)])?);
    file.set_len(before)?;
    file.seek(SeekFrom::Start(before))?;
    file.write_all(&place.marked_end(mark.text().as_bytes()))
}

/// Returns the text of an XML document, of LaTeX or of settings, with their mark.
pub fn sealed(mut text: String, kind: OutputKind) -> String {
    let mark = Mark::new(kind, Checksum::of(text.as_bytes())).text();
    let end = MarkPlace::of(text.as_bytes()).marked_end(mark.as_bytes());
    text.push_str(std::str::from_utf8(&end).expect("a mark is ASCII"));
    text
}

fn part_of(file: &mut File, offset: u64, length: u64) -> io::Result<Vec<u8>> {
    file.seek(SeekFrom::Start(offset))?;
    next_bytes(file, length)
}

/// Whether the regular file at `path` has a mark of this program; with `is_whole`, only if what the mark claims has not
/// changed. A picture that was cut off, so that it has lost its mark, is known by its `Software` unless `is_whole`.
pub fn has_mark(path: &Path, is_whole: bool) -> bool {
    holds_mark(path, is_whole).unwrap_or(false)
}

fn holds_mark(path: &Path, is_whole: bool) -> io::Result<bool> {
    let mut file = super::open(path)?;
    let head = part_of(&mut file, 0, HEAD)?;
    let starts = |start: &[u8]| head.starts_with(start);
    // The application id lies at byte 68 of SQLite's header.
    if starts(b"SQLite format 3\0") {
        return Ok(head.get(68..72) == Some(&DATABASE_ID.to_be_bytes()[..]));
    }
    // Its folder alone tells whether a pair is whole.
    if starts(PAIR_MARK) {
        return Ok(!is_whole);
    }
    if starts(b"{") {
        return Ok(claims_in::<Value>(path, None).is_some());
    }
    let is_tiff = [b"II*\0", b"MM\0*", b"II+\0", b"MM\0+"].iter().any(|start| starts(*start));
    let found = if is_tiff { mark_in_tiff(&mut file) } else { mark_at_end(&mut file, MarkPlace::of(&head))? };
    match found {
        Some((mark, parts)) => Ok(!is_whole || Checksum::of_parts(&mut file, &parts)? == mark.content),
        None => {
            // The second chunk's name: behind the signature, the first chunk of 25 bytes, and a length of 4.
            let is_our_png = |rest: &[u8]| starts(b"\x89PNG") && rest.starts_with(b"tEXtSoftware\0Burstscope ");
            Ok(!is_whole && head.get(37..).is_some_and(is_our_png))
        }
    }
}

type MarkWithParts = (Mark, Vec<(u64, u64)>);

fn mark_at_end(file: &mut File, place: MarkPlace) -> io::Result<Option<MarkWithParts>> {
    let length = file.seek(SeekFrom::End(0))?;
    let tail = part_of(file, length.saturating_sub(TAIL), TAIL)?;
    let begin = tail.windows(12).rposition(|window| window == b"{\"program\":\"").unwrap_or(tail.len());
    // Its first brace ends it; bytes behind it, as of a checksum, may be braces too.
    let text = tail[begin..].split_inclusive(|byte| *byte == b'}').next().unwrap_or_default();
    let marked_end = place.marked_end(text);
    let mark = Mark::parsed(text).filter(|_| tail.ends_with(&marked_end));
    Ok(mark.map(|mark| (mark, vec![(0, length - marked_end.len() as u64)])))
}

fn mark_in_tiff(file: &mut File) -> Option<MarkWithParts> {
    file.rewind().ok()?;
    let mut decoder = Decoder::new(BufReader::new(file)).ok()?;
    let software = decoder.get_tag_ascii_string(Tag::Software).ok()?;
    let mark = Mark::parsed(software.get(software.find('{')?..)?.as_bytes())?;
    let offsets = decoder.get_tag_u64_vec(Tag::StripOffsets).ok()?;
    let lengths = decoder.get_tag_u64_vec(Tag::StripByteCounts).ok()?;
    Some((mark, offsets.into_iter().zip(lengths).collect()))
}

#[derive(Serialize, Deserialize)]
struct Claiming<T> {
    #[serde(flatten)]
    mark: Mark,
    claims: T,
}

/// Returns the text of a file of JSON that claims `claims`, which are plain values.
pub fn claiming(kind: OutputKind, claims: &impl Serialize) -> String {
    let claims = serde_json::to_value(claims).expect("claims are plain values");
    // As they are read back, because a number may lose its last digit on the way.
    let read: Value = serde_json::from_str(&claims.to_string()).expect("it was written just now");
    let mark = Mark::new(kind, Checksum::of(read.to_string().as_bytes()));
    serde_json::to_string(&Claiming { mark, claims }).expect("a mark is plain values") + "\n"
}

/// The claims in a file that [`claiming`] gave, if its mark is of `kind` (any, for `None`) and whole.
fn claims_in<T: DeserializeOwned>(file: &Path, kind: Option<OutputKind>) -> Option<T> {
    let text = read_text(file, MAX_TABLE_BYTES).ok()?;
    let Claiming { mark, claims }: Claiming<Value> = serde_json::from_str(&text).ok()?;
    let is_whole = mark.format == FORMAT && mark.content == Checksum::of(claims.to_string().as_bytes());
    (is_whole && kind.is_none_or(|kind| mark.kind == kind)).then(|| serde_json::from_value(claims).ok()).flatten()
}

/// The claims of the mark of `folder`, if it is a folder of this kind and they are as they were written.
pub fn claims<T: DeserializeOwned>(folder: &Path, kind: OutputKind) -> Option<T> {
    claims_in(&folder.join(kind.file()), Some(kind))
}

/// Entries of a folder and of the folders in it, with the checksums of files.
type Listing = BTreeMap<String, Option<Checksum>>;

fn list(folder: &Path, below: &str, listing: &mut Listing) -> io::Result<()> {
    for entry in std::fs::read_dir(folder)? {
        let entry = entry?;
        let (name, kind) = (below.to_owned() + &path_text(Path::new(&entry.file_name())), entry.file_type()?);
        if kind.is_dir() {
            list(&entry.path(), &format!("{name}/"), listing)?;
            listing.insert(name, None);
        } else {
            // A link or a device is of nobody: no file is as long.
            let nobodys = Checksum { bytes: u64::MAX, crc32: 0 };
            let content = if kind.is_file() { Checksum::of_file(&entry.path())? } else { nobodys };
            listing.insert(name, Some(content));
        }
    }
    Ok(())
}

/// Writes the mark of a complete folder, which claims all that is in it.
pub fn seal_folder(folder: &Path, kind: OutputKind) -> io::Result<()> {
    let mut listing = Listing::new();
    list(folder, "", &mut listing)?;
    std::fs::write(folder.join(kind.file()), claiming(kind, &listing))
}

/// Whether all that is in `folder`, which [`seal_folder`] marked, is as it was then. Missing files do not count.
pub fn is_unchanged(folder: &Path, kind: OutputKind) -> io::Result<bool> {
    let Some(claimed) = claims::<Listing>(folder, kind) else { return Ok(false) };
    let mut listing = Listing::new();
    list(folder, "", &mut listing)?;
    listing.remove(kind.file());
    Ok(listing.iter().all(|(name, content)| claimed.get(name) == Some(content)))
}
