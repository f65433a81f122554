//! Options that describe a file: its shape without a header, mosaic, axis of the frames, and source of times or views.

use super::number::Number;
use crate::files::whole_number;
use serde::{Deserialize, Serialize};
use std::{fmt, path::PathBuf, str::FromStr};
use strum::{EnumString, IntoStaticStr};

/// Shape of a file without header: frames of one size, one after the other, from a place in the file on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Dump {
    /// Size (columns, rows) of a frame.
    pub(super) size: (usize, usize),
    pub(super) number: Number,
    pub(super) big_endian: bool,
    /// Bytes before the first frame.
    pub(super) skip: u64,
}

/// Names of the numbers of files without header, of which little endian is the usual one.
const TYPES: [(&str, Number, bool); 10] = [
    ("u1", Number::U1, false),
    ("u8", Number::U8, false),
    ("u16le", Number::U16, false),
    ("u16be", Number::U16, true),
    ("f32", Number::F32, false),
    ("mono10p", Number::U10p, false),
    ("mono12p", Number::U12p, false),
    ("mono10packed", Number::U10Packed, false),
    ("mono12packed", Number::U12Packed, false),
    ("f32be", Number::F32, true),
];

impl FromStr for Dump {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let read = || {
            let (shape, kind) = text.split_once(':')?;
            let (width, height) = shape.split_once('x')?;
            let (kind, skip) = kind.split_once('+').unwrap_or((kind, "0"));
            let (_, number, big_endian) = *TYPES.iter().find(|(name, ..)| *name == kind)?;
            let side = |text: &str| text.parse().ok().filter(|side: &usize| *side > 0);
            let size = (side(width)?, side(height)?);
            // Rows of bits fill whole bytes.
            let is_whole = number != Number::U1 || size.0.is_multiple_of(8);
            is_whole.then_some(Self { size, number, big_endian, skip: skip.parse().ok()? })
        };
        read().ok_or_else(|| {
            let names = TYPES.map(|(name, ..)| name).join(", ");
            format!("'{text}' is not WIDTHxHEIGHT:TYPE, such as 1600x1200:u16le, or with +BYTES before the first frame; types are {names}; u1 needs a width of whole bytes")
        })
    }
}

impl fmt::Display for Dump {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { size: (width, height), number, big_endian, skip } = self;
        let name =
            TYPES.iter().find(|(_, own, order)| own == number && order == big_endian).map_or("", |found| found.0);
        write!(f, "{width}x{height}:{name}")?;
        if *skip > 0 { write!(f, "+{skip}") } else { Ok(()) }
    }
}

const USUAL_SIZES: &str = "1600x1200 640x480 1280x960 1920x1080 1280x1024 1440x1080 2048x1536 2448x2048 1936x1216 1920x1200 \
    2592x1944 4096x3000 5472x3648 1024x768 1280x720 800x600 720x540 752x480 320x240 512x512 1024x1024 \
    2048x2048 256x256 2064x1544 3840x2160 4000x3000 1936x1096 3096x2080 346x260 304x240 240x180";

impl Dump {
    pub(super) fn frame_bytes(&self) -> u64 {
        self.number.bytes((self.size.0 as u64).saturating_mul(self.size.1 as u64))
    }

    /// Shapes of usual sensors that fill `length` bytes with up to `max_frames` frames, and their number; fewest first.
    pub(super) fn likely(length: u64, max_frames: u64) -> Vec<(Self, u64)> {
        let whole = |(dump, _): &(Self, u64)| length.is_multiple_of(dump.frame_bytes());
        let size = |text: &str| text.split_once('x').and_then(|(u, v)| Some((u.parse().ok()?, v.parse().ok()?)));
        let sizes = USUAL_SIZES.split(' ').filter_map(size);
        let shapes = sizes.flat_map(|size| TYPES.iter().map(move |kind| (size, *kind)));
        let mut found: Vec<(Self, u64)> = shapes
            .filter(|(_, (name, ..))| ["u8", "u16le", "f32", "mono12p"].contains(name))
            .map(|(size, (_, number, big_endian))| Self { size, number, big_endian, skip: 0 })
            .map(|dump| (dump, length / dump.frame_bytes()))
            .filter(|(_, frames)| (1..=max_frames).contains(frames))
            .filter(whole)
            .collect();
        found.sort_by_key(|(_, frames)| *frames);
        found
    }
}

/// Mosaic of colours before a sensor: the colours of a square of 2×2 pixels, row by row from the corner of the frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
#[serde(rename_all = "lowercase")]
pub enum Mosaic {
    /// Red and green, green and blue.
    Rggb,
    /// Green and red, blue and green.
    Grbg,
    /// Green and blue, red and green.
    Gbrg,
    /// Blue and green, green and red.
    Bggr,
    /// No colours: each pixel stays one, also where the file says that there is a mosaic.
    None,
}

impl Mosaic {
    /// The mosaics of squares of two green, a red and a blue pixel.
    pub(super) const ALL: [Self; 4] = [Self::Rggb, Self::Grbg, Self::Gbrg, Self::Bggr];

    /// The mosaic as seen from `u` columns and `v` rows further on.
    pub(super) fn shifted(self, u: usize, v: usize) -> Self {
        Self::of(|du, dv| self.colour_at(u + du, v + dv)).unwrap_or(self)
    }

    /// Mosaic with these colours of its pixels; `None` for a square that is not in [`Self::ALL`].
    pub(super) fn of(colour_at: impl Fn(usize, usize) -> usize) -> Option<Self> {
        let is_this = |mosaic: &Self| (0..4).all(|k| mosaic.colour_at(k % 2, k / 2) == colour_at(k % 2, k / 2));
        Self::ALL.into_iter().find(is_this)
    }

    /// Colour of a pixel: 0 red, 1 green, 2 blue.
    pub(super) fn colour_at(self, u: usize, v: usize) -> usize {
        let square = match self {
            Self::Rggb => [0, 1, 1, 2],
            Self::Grbg => [1, 0, 2, 1],
            Self::Gbrg => [1, 2, 0, 1],
            Self::Bggr => [2, 1, 1, 0],
            Self::None => [1; 4],
        };
        square[2 * (v % 2) + u % 2]
    }
}

/// Axis of a file that has several, as `--axis` names it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, EnumString, IntoStaticStr)]
#[strum(ascii_case_insensitive)]
pub enum Axis {
    /// Time.
    T,
    /// Depth: the slices of a volume.
    Z,
    /// Channel: wavelengths or dyes.
    C,
    /// The first axis of an array whose axes have no names.
    #[strum(serialize = "first")]
    First,
    /// The last axis of such an array.
    #[strum(serialize = "last")]
    Last,
}

impl Axis {
    pub(super) fn name(self) -> &'static str {
        self.into()
    }
}

/// Axis along which frames follow one another, and the places on others, such as `T,C=1`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct AxisChoice {
    pub(super) along: Axis,
    pub(super) at: Vec<(Axis, usize)>,
}

impl FromStr for AxisChoice {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let read = || {
            let mut parts = text.split(',');
            let along = parts.next()?.parse().ok()?;
            let at = parts.map(|part| {
                let (axis, place) = part.split_once('=')?;
                let axis = axis.parse().ok().filter(|axis| matches!(axis, Axis::T | Axis::Z | Axis::C))?;
                Some((axis, place.parse().ok()?))
            });
            Some(Self { along, at: at.collect::<Option<_>>()? })
        };
        read().ok_or_else(|| {
            format!(
                "'{text}' is no axis: T, Z or C, with places on the others such as T,C=1; of a .npy array first or last"
            )
        })
    }
}

impl fmt::Display for AxisChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.along.name())?;
        self.at.iter().try_for_each(|(axis, place)| write!(f, ",{}={place}", axis.name()))
    }
}

/// Source of the times of frames.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum TimesChoice {
    /// Even times, whatever files say.
    #[default]
    Even,
    /// Stamps in the names of the files.
    Names,
    /// Times that the files hold: EXIF, the date of a TIFF, DATE-OBS of FITS, those of SER and films.
    Header,
    /// Order and times in which the motion of the images is uniform. [`Burst::open_with`](super::Burst::open_with),
    /// which does not know it, leaves the frames even: [`open_burst`](crate::detector::open_burst) takes them so.
    Found,
    /// A list in a file, or in one of that name beside the frames.
    List(PathBuf),
}

const TIMES: [(&str, TimesChoice); 5] = [
    ("even", TimesChoice::Even),
    ("names", TimesChoice::Names),
    ("header", TimesChoice::Header),
    ("exif", TimesChoice::Header),
    ("found", TimesChoice::Found),
];

impl FromStr for TimesChoice {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match TIMES.iter().find(|(name, _)| *name == text) {
            Some((_, choice)) => Ok(choice.clone()),
            None if text.is_empty() => Err("give a list of times, names, header, found or even".to_owned()),
            None => Ok(Self::List(text.into())),
        }
    }
}

impl fmt::Display for TimesChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self, TIMES.iter().find(|(_, choice)| choice == self)) {
            (Self::List(path), _) => write!(f, "{}", path.display()),
            (_, found) => f.write_str(found.map_or("", |found| found.0)),
        }
    }
}

/// Frames `start..end` of a burst (`end` excluded), as `--frames A..B` and `--take A..B` name them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FrameRange {
    /// First frame, counted from 0.
    pub start: usize,
    /// One past the last frame.
    pub end: usize,
}

impl FrameRange {
    /// Checks that the range holds a frame; otherwise the fault and its remedy.
    pub(crate) fn check(&self) -> Result<(), (String, String)> {
        if self.start < self.end {
            return Ok(());
        }
        Err((format!("{self} holds no frame"), "give A..B with A below B".to_owned()))
    }
}

impl fmt::Display for FrameRange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}..{}", self.start, self.end)
    }
}

impl FromStr for FrameRange {
    type Err = String;

    /// Reads `A..B`, the frames A … B−1.
    fn from_str(text: &str) -> Result<Self, String> {
        let bad = || format!("'{text}' is not A..B, such as 0..10 for the first ten frames");
        let (start, end) = text.split_once("..").ok_or_else(bad)?;
        let side = |text| whole_number(text).map_err(|fault| format!("{} ({fault})", bad()));
        Ok(Self { start: side(start)?, end: side(end)? })
    }
}

/// Numbers of rows and of columns of a grid of views.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct ViewGrid {
    pub(super) rows: usize,
    pub(super) columns: usize,
}

/// Largest number of rows and of columns of views.
pub(super) const MAX_SIDE: usize = 4096;

impl ViewGrid {
    /// Grid of `rows` × `columns` views; `None` unless both are 1 to 4096.
    pub fn new(rows: usize, columns: usize) -> Option<Self> {
        [rows, columns].iter().all(|side| (1..=MAX_SIDE).contains(side)).then_some(Self { rows, columns })
    }

    /// Rows of views, 1 to 4096.
    pub fn rows(self) -> usize {
        self.rows
    }

    /// Columns of views, 1 to 4096.
    pub fn columns(self) -> usize {
        self.columns
    }

    /// Number of views, rows × columns.
    pub fn count(self) -> usize {
        self.rows * self.columns
    }
}

impl FromStr for ViewGrid {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (rows, columns) = text.split_once('x').unwrap_or_default();
        let grid = rows.parse().ok().zip(columns.parse().ok()).and_then(|(rows, columns)| Self::new(rows, columns));
        grid.ok_or_else(|| format!("'{text}' is not ROWSxCOLUMNS, such as 9x9"))
    }
}

impl fmt::Display for ViewGrid {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}x{}", self.rows, self.columns)
    }
}

/// Places of the pixels of all views in one picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, EnumString, strum::Display)]
#[strum(serialize_all = "lowercase")]
pub enum Tiling {
    /// Views side by side, in rows and columns.
    Tiled,
    /// Interleaved, as in Lytro cameras' ESLF files: pixel (v·rows + t, u·columns + s) is pixel (v, u) of view (t, s).
    Eslf,
}

/// Statement that frames are the views of a light field: `names`, `9x9`, `9x9:tiled` or `9x9:eslf`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, strum::Display)]
#[serde(try_from = "String", into = "String")]
pub enum ViewsChoice {
    /// Rows and columns in the names of the files, such as `view_03_07.png`.
    #[strum(to_string = "names")]
    Names,
    /// Frames are a grid, row by row. A grid of one row is a burst.
    #[strum(to_string = "{0}")]
    Grid(ViewGrid),
    /// All views of a grid are in one picture.
    #[strum(to_string = "{0}:{1}")]
    Picture(ViewGrid, Tiling),
}

impl ViewsChoice {
    /// Grid and tiling of pictures that hold all views.
    pub(super) fn picture(self) -> Option<(ViewGrid, Tiling)> {
        if let Self::Picture(grid, tiling) = self { Some((grid, tiling)) } else { None }
    }
}

impl FromStr for ViewsChoice {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let read = || match text.split_once(':') {
            _ if text == "names" => Some(Self::Names),
            None => text.parse().ok().map(Self::Grid),
            Some((grid, tiling)) => Some(Self::Picture(grid.parse().ok()?, tiling.parse().ok()?)),
        };
        read().ok_or_else(|| {
            format!("'{text}' is neither names nor ROWSxCOLUMNS, such as 9x9, or 9x9:tiled or 9x9:eslf for one picture")
        })
    }
}

macro_rules! as_text {
    ($($type:ty)*) => { $(
        impl TryFrom<String> for $type {
            type Error = String;

            fn try_from(text: String) -> Result<Self, String> {
                text.parse()
            }
        }

        impl From<$type> for String {
            fn from(value: $type) -> Self {
                value.to_string()
            }
        }
    )* };
}

as_text!(Dump AxisChoice TimesChoice ViewGrid ViewsChoice);
