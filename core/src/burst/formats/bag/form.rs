//! Formats of recordings, by their first bytes.

use crate::files;
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// Name of the file that says which files a ROS 2 bag has, and its first bytes.
const METADATA: (&str, &[u8]) = ("metadata.yaml", b"rosbag2_bagfile_information:");
/// First bytes of each form; the version of a ROS 1 bag follows.
const MAGICS: [(&[u8], Form); 3] =
    [(b"#ROSBAG V", Form::Ros1), (b"\x89MCAP0\r\n", Form::Mcap), (b"SQLite format 3\0", Form::Rows)];

/// Whether a file that begins with `start` is a recording, or the list of the files of one.
pub(super) fn is_recording(start: &[u8]) -> bool {
    Form::of(start).is_some() || start.starts_with(METADATA.1)
}

/// Whether `path` lists the files of a ROS 2 bag, which then are taken together.
pub(super) fn is_metadata(path: &Path) -> bool {
    let mut start = Vec::new();
    let read = |file: File| file.take(METADATA.1.len() as u64).read_to_end(&mut start);
    path.file_name().is_some_and(|name| name == METADATA.0)
        && files::open(path).and_then(read).is_ok()
        && start == METADATA.1
}

/// Format of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Form {
    Ros1,
    Mcap,
    Rows,
}

impl Form {
    /// Form that the first bytes show.
    pub(super) fn of(start: &[u8]) -> Option<Self> {
        MAGICS.into_iter().find(|(magic, _)| start.starts_with(magic)).map(|(_, form)| form)
    }

    pub(super) fn name(self) -> &'static str {
        ["ROS 1 bag", "MCAP", "ROS 2 bag"][self as usize]
    }

    /// Program that writes a whole file of what is left of a damaged one.
    pub(super) fn repair(self) -> &'static str {
        ["rosbag reindex", "mcap recover", "ros2 bag reindex"][self as usize]
    }

    /// Program that writes a file anew, with chunks that can be read.
    pub(super) fn rewrite(self) -> &'static str {
        ["rosbag decompress", "mcap compress", "ros2 bag convert"][self as usize]
    }
}
