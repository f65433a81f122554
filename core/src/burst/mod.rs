//! A burst: frames of one size, in time order, as `f32` in [0, 1] of the file's full scale.
//!
//! All code that knows file formats is in this module; the detector sees only the frames. [`find_bursts`] lists the
//! bursts that an input names, [`cut_sequence`] makes bursts of a long sequence of frames, [`Burst::open_with`] opens
//! one of them, and [`Burst::from_arrays`] makes one of arrays in memory.
//!
//! ```
//! use burstscope_core::{Burst, Plane, export::write_tiff};
//! let night = tempfile::tempdir()?;
//! for t in 0..3usize {
//!     let frame = Plane::from_fn(8, 6, |u, _| (u + t) as f32 / 10.0);
//!     write_tiff(&night.path().join(format!("{t}.tiff")), &frame)?;
//! }
//! let burst = Burst::open(night.path())?;
//! assert_eq!((burst.len(), burst.frames[2].at(7, 0)), (3, 0.9));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod arrays;
mod error;
mod formats;
mod info;
mod layout;
mod masks;
mod notes;
mod number;
mod open;
mod options;
mod positions;
mod reading;
mod rotations;
mod source;
mod stamps;
mod times;
mod views;

pub use arrays::{ArrayFrame, Arrays};
pub use formats::{FormatRecord, LikelyShape, file_formats, likely_shapes, serve_decoding, shape_of};
pub(crate) use formats::{Ran, ffmpeg, file_url, ran};
pub use info::Info;
pub use layout::{Axis, AxisChoice, Dump, FrameRange, Mosaic, Tiling, TimesChoice, ViewGrid, ViewsChoice};
pub use notes::{Note, Remark, RemarkKind};
pub use options::{Encoding, Limits, OpenOptions, RawColour};
pub use positions::{Offset, Positions};
pub use reading::{confined::DecodeWorker, pixels::LUMA_WEIGHTS};
pub use source::{
    BurstFiles, Entries, SequenceCut, cut_sequence, files_at, find_bursts, find_entries, name_among_several,
    supported_extensions,
};

use crate::plane::Plane;
use std::{path::PathBuf, sync::Arc};

/// A sequence of frames of one size, in time order. Cheap to clone: the pixels are shared.
#[derive(Debug, Clone)]
pub struct Burst {
    /// Name for display: the folder's or file's name, or "demo".
    pub name: String,
    /// The frames, in time order (natural file order); all of one size; at least one. Values in [0, 1] of full scale.
    pub frames: Vec<Arc<Plane>>,
    /// Name of each frame (file name, or file name and index in a stack).
    pub frame_names: Vec<String>,
    /// Position of each frame: its time where [`OpenOptions`] ask for it, otherwise even; of views, their places.
    pub positions: Positions,
    /// File value that became 1.0: unless given, 255 or 65535 for 8 or 16 bit, and 1 or the largest value for others.
    pub full_scale: f32,
    /// Smallest difference that the files can hold, in [0, 1] units: 1/255 for 8 bit; 0 when unknown (float).
    pub quantisation_step: f32,
    /// Relation of the values to light.
    pub encoding: Encoding,
    /// Sensor pixels along a side of a frame's pixel, the unit of places and slopes: 1 unless a mosaic was binned.
    pub binning: usize,
    /// Largest value of a converter of fewer bits that could have made these 16-bit files. Only a suggestion.
    pub suggested_full_scale: Option<f32>,
    /// Remarks on the files of single frames: damage that was accepted, file types that contradict the names.
    pub remarks: Vec<Remark>,
    /// Guesses and choices about the files, as clauses: which axis is that of the frames, which array was taken.
    pub taken: Vec<String>,
    /// Files or folders that it was opened from; empty for synthetic bursts.
    pub sources: Vec<PathBuf>,
}

impl Burst {
    /// Makes a burst from planes in memory. Panics if there is none, or the sizes differ. (The opener checks files.)
    ///
    /// ```
    /// use burstscope_core::{Burst, Plane};
    /// let point = |t: usize| Plane::from_fn(64, 48, |u, v| if (u, v) == (20 + t, 24) { 1.0 } else { 0.0 });
    /// let burst = Burst::from_planes("a point moves right", (0..5).map(point).collect());
    /// assert_eq!((burst.len(), burst.size(), burst.frames[4].at(24, 24)), (5, (64, 48), 1.0));
    /// ```
    pub fn from_planes(name: impl Into<String>, frames: Vec<Plane>) -> Self {
        assert!(!frames.is_empty(), "a burst has at least one frame");
        assert!(frames.iter().all(|f| f.size() == frames[0].size()), "all frames of a burst have one size");
        Self {
            name: name.into(),
            frame_names: (0..frames.len()).map(|t| format!("frame {t}")).collect(),
            positions: Positions::even(frames.len()),
            frames: frames.into_iter().map(Arc::new).collect(),
            full_scale: 1.0,
            quantisation_step: 0.0,
            encoding: Encoding::Linear,
            binning: 1,
            suggested_full_scale: None,
            remarks: Vec::new(),
            taken: Vec::new(),
            sources: Vec::new(),
        }
    }

    /// The burst of some `frames` alone, in this order, at `positions`.
    ///
    /// # Panics
    /// If there is no such frame, or not one position a frame.
    pub fn of_frames(mut self, frames: &[usize], positions: Positions) -> Self {
        assert_eq!(frames.len(), positions.len(), "a frame has one position");
        self.remarks.retain_mut(|remark| {
            let place = frames.iter().position(|frame| *frame == remark.frame);
            place.map(|place| remark.frame = place).is_some()
        });
        self.frame_names = frames.iter().map(|frame| self.frame_names[*frame].clone()).collect();
        self.frames = frames.iter().map(|frame| self.frames[*frame].clone()).collect();
        Self { positions, ..self }
    }

    /// Number of frames, N.
    pub fn len(&self) -> usize {
        self.frames.len()
    }

    /// Whether there is no frame; always false, because every burst has at least one.
    pub fn is_empty(&self) -> bool {
        self.frames.is_empty()
    }

    /// Size (columns, rows) of each frame.
    pub fn size(&self) -> (usize, usize) {
        self.frames[0].size()
    }
}
