//! Errors of opening a burst: each message names the file, says what is wrong and gives a remedy.

use crate::monitor::Cancelled;
use crate::plane::memory::NoMemory;
use std::borrow::Cow;
use std::path::{Path, PathBuf};

/// Reason why a burst could not be opened. Bursts that are open stay as they are.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum OpenError {
    /// Opening was cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// No input was named.
    #[error("nothing to open: name a folder of frames, image files, a multi-page TIFF or a .npy stack")]
    NothingGiven,
    /// There is no such file or folder.
    #[error("there is no such file or folder; check the spelling: {}", path.display())]
    NotFound {
        /// The named path.
        path: PathBuf,
    },
    /// Neither a regular file nor a folder, such as a device or a pipe.
    #[error("this is neither a regular file nor a folder; save the frames to files first: {}", path.display())]
    NotAFile {
        /// The named path.
        path: PathBuf,
    },
    /// A folder without any picture, and without subfolders that have some.
    #[error(
        "this folder holds no pictures, nor do its subfolders; a burst is a folder of {} files: {}",
        super::supported_extensions().join(", "), path.display()
    )]
    NoPictures {
        /// The folder.
        path: PathBuf,
    },
    /// The system could not read it.
    #[error("cannot read this: {reason}: {}", path.display())]
    Read {
        /// The file or folder.
        path: PathBuf,
        /// The system's message.
        reason: String,
    },
    /// A file of no bytes.
    #[error("this file is empty (0 bytes); copy it again or remove it: {}", path.display())]
    EmptyFile {
        /// The file.
        path: PathBuf,
    },
    /// The first bytes match no kind of file that can be opened.
    #[error(
        "this is not a picture of a kind that can be opened ({}); convert it to PNG or TIFF, or remove it: {}",
        super::supported_extensions().join(", "), path.display()
    )]
    UnknownKind {
        /// The file.
        path: PathBuf,
    },
    /// The first bytes match no kind of file that can be opened, though the extension does.
    #[error(
        "this file is named as a {named} but does not begin like one: it is damaged or of another kind; copy it again or remove it: {}",
        path.display()
    )]
    NotAsNamed {
        /// The file.
        path: PathBuf,
        /// The format that the extension names, such as "PNG".
        named: &'static str,
    },
    /// The file is of a known kind, but truncated or damaged.
    #[error("this {kind} file is truncated or damaged ({reason}); copy it again or remove it: {}", path.display())]
    Corrupt {
        /// The file.
        path: PathBuf,
        /// The file format, such as "PNG".
        kind: &'static str,
        /// The decoder's message.
        reason: String,
    },
    /// The process that decodes the file was ended by a signal that no decoder sends itself.
    #[error(
        "the decoder of this {kind} file was ended by signal {signal}, from outside or because the machine has no memory left; open it again: {}",
        path.display()
    )]
    DecoderEnded {
        /// The file.
        path: PathBuf,
        /// The file format, such as "raw".
        kind: &'static str,
        /// Number of the signal.
        signal: i32,
    },
    /// The file is sound, but its content cannot be opened.
    #[error("this {kind} file cannot be opened: {reason}: {}", path.display())]
    Unsupported {
        /// The file.
        path: PathBuf,
        /// The file format, such as "TIFF".
        kind: &'static str,
        /// The unsupported content, and a remedy.
        reason: String,
    },
    /// Two frames differ in size.
    #[error(
        "all frames of a burst have one size, but this one is {}×{}: {}, and this one is {}×{}: {}; crop them alike or remove the odd one",
        first_size.0, first_size.1, first.display(), size.0, size.1, path.display()
    )]
    DifferentSizes {
        /// The first frame's file.
        first: PathBuf,
        /// Size (columns, rows) of the first frame.
        first_size: (usize, usize),
        /// The frame that differs.
        path: PathBuf,
        /// Size (columns, rows) of that frame.
        size: (usize, usize),
    },
    /// The bias or flat frame's size differs from the burst's.
    #[error(
        "the {kind} frame is {}×{}, but the frames are {}×{}; take it with the same camera settings: {}",
        size.0, size.1, frame_size.0, frame_size.1, path.display()
    )]
    CalibrationSize {
        /// "bias" or "flat".
        kind: &'static str,
        /// File of the bias or flat frame.
        path: PathBuf,
        /// Size (columns, rows) of the bias or flat frame.
        size: (usize, usize),
        /// Size (columns, rows) of the frames.
        frame_size: (usize, usize),
    },
    /// The values of the bias or flat frame cannot be converted to the burst's unit, or are implausible.
    #[error("the {kind} frame does not fit the frames: {reason}: {}", path.display())]
    CalibrationUnit {
        /// "bias" or "flat".
        kind: &'static str,
        /// File of the bias or flat frame.
        path: PathBuf,
        /// The fault, and a remedy.
        reason: &'static str,
    },
    /// A video.
    #[error(
        "this is a video; make frames of it first: mkdir frames && ffmpeg -i {} frames/frame_%05d.png",
        quoted(path)
    )]
    Video {
        /// The file.
        path: PathBuf,
    },
    /// Integer frames of 8 or 16 bit together with frames of float or 32-bit values, which have no unit in common.
    #[error(
        "frames of 8 or 16 bit and frames of float or 32-bit values have no unit in common; save all frames alike: {} and {}",
        first.display(), path.display()
    )]
    MixedSamples {
        /// The first frame's file.
        first: PathBuf,
        /// The frame that differs.
        path: PathBuf,
    },
    /// Frames of different integer types, for which no common full scale is given.
    #[error(
        "this frame has {first_samples}: {}, and this one has {samples}: {}; save all frames alike, or say with a full scale which value is white in all of them",
        first.display(), path.display()
    )]
    MixedBits {
        /// The first frame's file.
        first: PathBuf,
        /// Samples of the first frame, such as "8 bit".
        first_samples: &'static str,
        /// The frame that differs.
        path: PathBuf,
        /// Samples of the frame that differs.
        samples: &'static str,
    },
    /// A value that is not a number, infinite, or too large for 32-bit float.
    #[error(
        "frame {frame} has {value} at pixel ({u}, {v}); replace what is not a finite number, by 0 or a neighbour's value: {}",
        path.display()
    )]
    NotFinite {
        /// The file.
        path: PathBuf,
        /// Index of the frame within the file, from 0.
        frame: usize,
        /// Column.
        u: usize,
        /// Row.
        v: usize,
        /// The value: NaN or ±infinity.
        value: f32,
    },
    /// A frame without pixels.
    #[error("this file's frames have no pixels ({width}×{height}); write it again or remove it: {}", path.display())]
    ZeroSize {
        /// The file.
        path: PathBuf,
        /// Columns.
        width: u64,
        /// Rows.
        height: u64,
    },
    /// An array that is not of two or three dimensions, or has no frames.
    #[error("this array has the shape {shape:?}; a stack is [frames, rows, columns], one frame is [rows, columns]: {}", path.display())]
    NpyShape {
        /// The file.
        path: PathBuf,
        /// Shape of the array.
        shape: Vec<u64>,
    },
    /// Larger than the [`Limits`](super::Limits).
    #[error("this is too large: {found}, and the limit is {limit}; {remedy}: {}", path.display())]
    BeyondLimit {
        /// The file or folder.
        path: PathBuf,
        /// The size found, in words.
        found: String,
        /// The limit, in words.
        limit: String,
        /// A remedy.
        remedy: Cow<'static, str>,
    },
    /// Within the [`Limits`](super::Limits), but more memory than the system gives.
    #[error("{refused}: {}", path.display())]
    NoMemory {
        /// The file.
        path: PathBuf,
        /// Size of the refused allocation.
        refused: NoMemory,
    },
    /// Folders and files were named together.
    #[error(
        "open either folders or files, not both: {} is a folder and {} is a file", folder.display(), file.display()
    )]
    MixedInput {
        /// The first folder.
        folder: PathBuf,
        /// The first file.
        file: PathBuf,
    },
    /// A picture that lies beside the bursts of a dataset.
    #[error("this picture lies beside the bursts of a dataset and belongs to none; move it into one or away: {}", path.display())]
    Stray {
        /// The picture.
        path: PathBuf,
    },
    /// One of several files that are the frames of a burst is itself a stack.
    #[error("several files are taken as the frames of one burst, but this one holds {frames} frames itself; open it alone: {}", path.display())]
    StackAmongFrames {
        /// The stack.
        path: PathBuf,
        /// Number of frames that it holds.
        frames: usize,
    },
    /// One burst was expected and there are several.
    #[error("there are {} bursts here, open one of them: {}", names.len(), list_of(names))]
    SeveralBursts {
        /// Names of the bursts, in natural order.
        names: Vec<String>,
    },
    /// A sequence was to be cut into bursts of no frames, or with no distance between their starts.
    #[error(
        "a sequence is cut into bursts of 1 or more frames that begin 1 or more frames apart, not {length} frames that begin {step} apart"
    )]
    Cut {
        /// Requested number of frames in a burst.
        length: usize,
        /// Requested number of frames from the start of a burst to that of the next.
        step: usize,
    },
    /// A sequence that has fewer frames than one burst needs.
    #[error("this has {frames} frames, too few for a burst of {length}; cut it into shorter bursts: {}", path.display())]
    TooShort {
        /// The folder, or the first frame.
        path: PathBuf,
        /// Number of frames in the sequence.
        frames: usize,
        /// Requested number of frames in a burst.
        length: usize,
    },
    /// A stack in one file, which cannot be cut into bursts.
    #[error("a sequence is cut into bursts between its files, but this one file holds {frames} frames; save each frame as a file of its own: {}", path.display())]
    CutStack {
        /// The stack.
        path: PathBuf,
        /// Number of frames that it holds.
        frames: usize,
    },
    /// The black level is not a number below the full scale.
    #[error(
        "the black level is the file's value that becomes 0; it must be a number below the full scale, {full_scale}, not {value}"
    )]
    BlackLevel {
        /// The given black level.
        value: f32,
        /// The full scale.
        full_scale: f32,
    },
    /// The full scale is not a positive number.
    #[error("the full scale is the file's value that becomes 1.0; it must be a positive number, not {value}")]
    FullScale {
        /// The given full scale.
        value: f32,
    },
}

/// The path quoted as one word of a shell command.
fn quoted(path: &Path) -> String {
    format!("'{}'", path.display().to_string().replace('\'', r"'\''"))
}

fn list_of(names: &[String]) -> String {
    let mut text = names.iter().take(8).cloned().collect::<Vec<_>>().join(", ");
    if names.len() > 8 {
        text.push_str(", …");
    }
    text
}

impl OpenError {
    /// Error for a file or folder that the system could not read.
    pub(super) fn from_io(path: &Path, error: &std::io::Error) -> Self {
        match error.kind() {
            std::io::ErrorKind::NotFound => Self::NotFound { path: path.into() },
            _ => Self::Read { path: path.into(), reason: error.to_string() },
        }
    }

    /// Error for a decoder's failed read of a file of the format `kind`: damage where the file ends early or the data
    /// is invalid, the system's error otherwise.
    pub(super) fn from_read(path: &Path, kind: &'static str, error: &std::io::Error) -> Self {
        use std::io::ErrorKind::{InvalidData, InvalidInput, Other, UnexpectedEof};
        let reason = match error.kind() {
            UnexpectedEof => "it ends too early".to_owned(),
            InvalidData | InvalidInput | Other => error.to_string(),
            _ => return Self::from_io(path, error),
        };
        Self::Corrupt { path: path.into(), kind, reason }
    }

    /// Whether opening was cancelled, rather than failed.
    pub fn is_cancelled(&self) -> bool {
        matches!(self, Self::Cancelled(_))
    }
}
