//! The size of a burst as its files declare it, before any pixel is read.

use super::decode;
use super::error::OpenError;
use super::options::OpenOptions;
use super::source::find_bursts;
use crate::monitor::Monitor;
use std::path::PathBuf;

/// Number and size of a burst's frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Declared {
    /// Number of frames, at least 1.
    pub frames: usize,
    /// Size (columns, rows) of the first frame; the opener refuses others.
    pub size: (usize, usize),
}

impl Declared {
    /// Reads the header of the first frame of the burst that `inputs` name, as [`Burst::open_with`] takes them.
    ///
    /// # Errors
    /// As [`Burst::open_with`], for errors that the first header shows.
    ///
    /// [`Burst::open_with`]: super::Burst::open_with
    pub fn of(inputs: &[PathBuf], options: &OpenOptions) -> Result<Self, OpenError> {
        let mut sources = find_bursts(inputs)?;
        let source = sources.pop().ok_or(OpenError::NothingGiven)?;
        if !sources.is_empty() {
            sources.push(source);
            return Err(OpenError::SeveralBursts { names: sources.into_iter().map(|s| s.name).collect() });
        }
        let files = source.files()?;
        let first = files.first().ok_or(OpenError::NothingGiven)?;
        let (header, _) = decode::header(first, options, &Monitor::default())?;
        let frames = if files.len() == 1 { header.frames } else { files.len() };
        Ok(Self { frames, size: (header.width, header.height) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_and_size_are_those_of_the_opened_burst() {
        let home = tempfile::tempdir().expect("a folder");
        for t in 0..3 {
            let path = home.path().join(format!("{t}.png"));
            image::GrayImage::from_pixel(9, 7, image::Luma([9])).save(path).expect("written");
        }
        let of = |path: PathBuf| Declared::of(&[path], &OpenOptions::default());
        assert_eq!(of(home.path().to_path_buf()), Ok(Declared { frames: 3, size: (9, 7) }));
        assert_eq!(of(home.path().join("1.png")), Ok(Declared { frames: 1, size: (9, 7) }));
        assert!(of(home.path().join("gone.png")).is_err());
    }
}
