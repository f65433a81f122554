//! Finding of the bursts that an input names, and of their sizes, before any pixel is read.
//!
//! A folder that holds pictures is a burst, in natural order (`frame_2` before `frame_10`); one with fewer pictures
//! than subfolders of pictures is a dataset: each of those is a burst, and its own pictures are listed apart, as
//! strays. A subfolder that cannot be read is listed as a burst, whose opening gives the error. A multi-page TIFF or a
//! `.npy` stack is a burst; several single pictures, in the order in which they are named, are the frames of one burst.
//! Films, archives and files without header are taken in a folder that holds no pictures.
//! [`cut_sequence`] makes a burst of every N frames of a long recording; each lists its own files and is opened alone.

use super::formats::{self, Rank};
use super::{options::OpenOptions, stamps::in_order_of_times};
use crate::error::{Error, ErrorKind, Result};
use crate::files::{path_text, shell_path};
use std::path::{Path, PathBuf};
use std::{cmp::Ordering, collections::HashSet, ffi::OsStr, ops::Range};

/// The files of one burst: its name, and the paths for [`Burst::open_with`](super::Burst::open_with).
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BurstFiles {
    /// Name of the folder, or of the stack without its extension. Unique in one result of [`find_bursts`].
    pub name: String,
    /// A folder, a stack, or the frames in time order.
    pub paths: Vec<PathBuf>,
}

impl BurstFiles {
    /// Files with the frames: the folder's files in natural order, or the given paths.
    pub fn files(&self) -> Result<Vec<PathBuf>> {
        files_at(&self.paths)
    }
}

/// Files with the frames at `paths`: those of a single folder in natural order, or the paths themselves.
pub fn files_at(paths: &[PathBuf]) -> Result<Vec<PathBuf>> {
    match paths {
        [folder] if folder.is_dir() => Ok(list(folder)?.0),
        paths => Ok(paths.to_vec()),
    }
}

/// Extensions (lower case, without a dot) of files that are taken for pictures in a folder.
pub fn supported_extensions() -> Vec<&'static str> {
    formats::extensions().collect()
}

/// Bursts that `inputs` name, in natural order, or as given one by one. Reads folders and headers of stacks, no pixels.
///
/// # Errors
/// Nothing given, a missing path, a folder without pictures, folders and files together, a stack among single frames.
pub fn find_bursts(inputs: &[PathBuf], options: &OpenOptions) -> Result<Vec<BurstFiles>> {
    Ok(find_entries(inputs, options)?.bursts)
}

/// The burst of `inputs`, if all of `inputs` together are one burst.
pub(super) fn only_burst(inputs: &[PathBuf], options: &OpenOptions) -> Result<BurstFiles> {
    let mut bursts = find_bursts(inputs, options)?;
    if bursts.len() > 1 {
        const FEW: usize = 8;
        let names: Vec<&str> = bursts.iter().take(FEW).map(|burst| &*burst.name).collect();
        let more = if bursts.len() > FEW { ", …" } else { "" };
        let problem = format!("there are {} bursts here, open one of them: {}{more}", bursts.len(), names.join(", "));
        return Err(Error::new(ErrorKind::SeveralBursts, problem, ""));
    }
    bursts.pop().ok_or_else(Error::nothing_given)
}

/// Bursts and stray pictures of an input.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Entries {
    /// Bursts with unique names, in the order of [`find_bursts`].
    pub bursts: Vec<BurstFiles>,
    /// Pictures that lie beside the bursts of a dataset and belong to none.
    pub strays: Vec<PathBuf>,
}

/// Finds bursts as [`find_bursts`], and the pictures that belong to none.
pub fn find_entries(inputs: &[PathBuf], options: &OpenOptions) -> Result<Entries> {
    if inputs.is_empty() {
        return Err(Error::nothing_given());
    }
    let (mut folders, mut files) = (Vec::new(), Vec::new());
    for path in inputs {
        let metadata = std::fs::metadata(path).map_err(|e| Error::from_io(path, &e))?;
        if metadata.is_dir() {
            folders.push(path.clone());
        } else if metadata.is_file() {
            files.push(path.clone());
        } else {
            return Err(Error::not_a_file(path));
        }
    }
    // Beside a folder, a file could be a burst or a frame.
    if let (Some(folder), Some(file)) = (folders.first(), files.first()) {
        let (folder, file) = (folder.display(), file.display());
        let problem = format!("open either folders or files, not both: {folder} is a folder and {file} is a file");
        return Err(Error::new(ErrorKind::Request, problem, ""));
    }
    let mut entries = Entries::default();
    for folder in &folders {
        let found = entries_of_folder(folder, true, options)?;
        if found.bursts.is_empty() {
            let problem = "this folder holds no pictures, nor do its subfolders";
            let has_bursts = |one: &PathBuf| entries_of_folder(one, true, options).is_ok_and(|e| !e.bursts.is_empty());
            let deeper = list(folder)?.1.into_iter().filter(has_bursts).map(|one| shell_path(&one));
            let remedy = match &deeper.take(2).collect::<Vec<_>>()[..] {
                [] => format!("a burst is a folder of {} files", supported_extensions().join(", ")),
                some => format!("bursts lie a folder deeper: give the folders above them, such as {}", some.join(" ")),
            };
            return Err(Error::new(ErrorKind::Request, problem, remedy).about(folder));
        }
        entries.bursts.extend(found.bursts);
        entries.strays.extend(found.strays);
    }
    if !files.is_empty() {
        entries.bursts.extend(bursts_of_files(files, options)?);
    }
    make_names_unique(&mut entries.bursts);
    Ok(entries)
}

fn entries_of_folder(folder: &Path, look_into_subfolders: bool, options: &OpenOptions) -> Result<Entries> {
    let (mut pictures, subfolders) = list(folder)?;
    // Archives and logs lie beside folders of pictures; in a dataset they are none of its bursts.
    let is_other = pictures.first().and_then(|path| formats::rank(path)) == Some(Rank::Other);
    if is_other && !look_into_subfolders && options.raw.is_none() {
        pictures.clear();
    }
    if pictures.len() > 1 && are_stacks(&pictures, options) {
        return Ok(Entries { bursts: pictures.into_iter().map(stack_source).collect(), strays: Vec::new() });
    }
    let mut bursts = Vec::new();
    if look_into_subfolders && (is_other || pictures.len() < subfolders.len()) {
        for subfolder in &subfolders {
            match entries_of_folder(subfolder, false, options) {
                Ok(found) => bursts.extend(found.bursts),
                // Opening it gives the error.
                Err(_) => bursts.push(folder_source(subfolder)),
            }
        }
    }
    if is_other && !bursts.is_empty() {
        return Ok(Entries { bursts, strays: Vec::new() });
    }
    if pictures.len() < bursts.len() {
        return Ok(Entries { bursts, strays: pictures });
    }
    let bursts = if pictures.is_empty() { Vec::new() } else { vec![folder_source(folder)] };
    Ok(Entries { bursts, strays: Vec::new() })
}

fn folder_source(folder: &Path) -> BurstFiles {
    BurstFiles { name: folder_name(folder), paths: vec![folder.into()] }
}

fn bursts_of_files(files: Vec<PathBuf>, options: &OpenOptions) -> Result<Vec<BurstFiles>> {
    if let [single] = &files[..] {
        return Ok(vec![stack_source(single.clone())]);
    }
    if are_stacks(&files, options) {
        return Ok(files.into_iter().map(stack_source).collect());
    }
    if let Some(path) = files.iter().find(|f| is_stack(f, options)) {
        return Err(Error::stack_among_frames(path, formats::frame_count(path, options).unwrap_or(2)));
    }
    let parent = files[0].parent().unwrap_or(Path::new(""));
    let together = files.iter().all(|f| f.parent().unwrap_or(Path::new("")) == parent);
    let name = if together { folder_name(parent) } else { stem(&files[0]) };
    Ok(vec![BurstFiles { name, paths: files }])
}

/// Whether each file is a burst of several frames. One that cannot be read counts: opening it gives the error.
fn are_stacks(files: &[PathBuf], options: &OpenOptions) -> bool {
    let is_single = |file: &PathBuf| formats::frame_count(file, options).is_ok_and(|frames| frames < 2);
    !files.iter().any(is_single) && files.iter().any(|file| is_stack(file, options))
}

/// Whether the file holds more than one frame. False for a file that cannot be read: opening it gives the error.
pub(super) fn is_stack(path: &Path, options: &OpenOptions) -> bool {
    formats::frame_count(path, options).is_ok_and(|frames| frames > 1)
}

fn stack_source(path: PathBuf) -> BurstFiles {
    BurstFiles { name: stem(&path), paths: vec![path] }
}

pub(super) fn stem(path: &Path) -> String {
    path.file_stem().map_or_else(|| "burst".into(), |s| path_text(Path::new(s)).trim_end_matches(".fits").to_owned())
}

/// Name of a folder, also of `.` or `a/..`.
pub(super) fn folder_name(folder: &Path) -> String {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let named = |p: &Path| p.file_name().map(|s| path_text(Path::new(s)));
    named(folder).or_else(|| named(&std::fs::canonicalize(folder).ok()?)).unwrap_or_else(|| "burst".into())
}

/// Pictures and subfolders of a folder, in natural order; without pictures films, else archives and raw numbers.
fn list(folder: &Path) -> Result<(Vec<PathBuf>, Vec<PathBuf>)> {
    let (mut found, mut subfolders) = (Vec::<(Rank, PathBuf)>::new(), Vec::new());
    for entry in std::fs::read_dir(folder).map_err(|e| Error::from_io(folder, &e))? {
        let entry = entry.map_err(|e| Error::from_io(folder, &e))?;
        if entry.file_name().to_string_lossy().starts_with('.') {
            continue;
        }
        let path = entry.path();
        // Follows links. A broken link with a picture's extension counts as a picture, so that opening names it.
        match std::fs::metadata(&path) {
            Ok(metadata) if metadata.is_dir() => subfolders.push(path),
            _ => found.extend(formats::rank(&path).map(|rank| (rank, path))),
        }
    }
    let first = found.iter().map(|(rank, _)| *rank).min();
    let mut pictures: Vec<PathBuf> =
        found.into_iter().filter(|(rank, _)| Some(*rank) == first).map(|one| one.1).collect();
    pictures.sort_by(|a, b| natural_order(a, b));
    subfolders.sort_by(|a, b| natural_order(a, b));
    Ok((pictures, subfolders))
}

/// Natural order of file names without extensions, so that `x.png` precedes `x(1).png`; then by bytes.
fn natural_order(a: &Path, b: &Path) -> Ordering {
    let by = |part: fn(&Path) -> Option<&OsStr>| {
        alphanumeric_sort::compare_os_str(part(a).unwrap_or_default(), part(b).unwrap_or_default())
    };
    by(Path::file_stem).then_with(|| by(Path::extension)).then_with(|| a.cmp(b))
}

/// Numbers the later bursts of a name, so that no export overwrites another. Letter case does not count.
pub(super) fn make_names_unique(sources: &mut [BurstFiles]) {
    let mut taken = HashSet::new();
    for source in sources {
        let numbered = (2..).map(|number| format!("{}-{number}", source.name));
        let mut names = std::iter::once(source.name.clone()).chain(numbered);
        source.name = names.find(|name| taken.insert(name.to_lowercase())).expect("numbers never end");
    }
}

/// Lengths of a cut: the frames of a burst, and the distance between the starts of bursts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SequenceCut {
    length: usize,
    step: usize,
}

impl SequenceCut {
    /// Bursts of `length` frames that begin `step` frames apart, by default `length`. Either being 0 is an error.
    pub fn new(length: usize, step: Option<usize>) -> Result<Self> {
        let step = step.unwrap_or(length);
        if length == 0 || step == 0 {
            let problem = format!(
                "a sequence is cut into bursts of 1 or more frames that begin 1 or more frames apart, \
                 not {length} frames that begin {step} apart"
            );
            return Err(Error::new(ErrorKind::Request, problem, ""));
        }
        Ok(Self { length, step })
    }

    /// Frames of a burst, at least 1.
    pub fn length(self) -> usize {
        self.length
    }

    /// Frames from the start of a burst to the start of the next, at least 1.
    pub fn step(self) -> usize {
        self.step
    }

    /// The frames of each burst in a sequence of `frames` frames, in order; a last part that fills none is left out.
    pub fn ranges(self, frames: usize) -> impl ExactSizeIterator<Item = Range<usize>> {
        let count = if frames < self.length { 0 } else { (frames - self.length) / self.step + 1 };
        (0..count).map(move |k| k * self.step..k * self.step + self.length)
    }
}

/// Cuts the sequence `sequence` (a folder of frames, or the frames themselves) into bursts, in the order of the times
/// that `options` say, and otherwise in natural order. A burst has the name of its middle frame, number N/2, which SIFT
/// on one frame also uses; among bursts of several sequences, [`name_among_several`] makes the names differ.
///
/// # Errors
/// A folder cannot be read; a sequence is shorter than one burst; a file is a stack.
pub fn cut_sequence(sequence: &BurstFiles, cut: SequenceCut, options: &OpenOptions) -> Result<Vec<BurstFiles>> {
    let frames = sequence.files()?;
    if let Some(path) = frames.iter().find(|f| is_stack(f, options)) {
        let problem = "a sequence is cut into bursts between its files, but this one file holds several frames";
        let remedy = "save each frame as a file of its own";
        return Err(Error::new(ErrorKind::Request, problem, remedy).about(path));
    }
    // Ordered before the cut, so that the frames of a burst follow one another in time.
    let frames = in_order_of_times(frames, options);
    let ranges = cut.ranges(frames.len());
    if ranges.len() == 0 {
        let path = sequence.paths.first().cloned().unwrap_or_default();
        let problem = format!("this has too few frames ({}) for a burst of {}", frames.len(), cut.length);
        return Err(Error::new(ErrorKind::Request, problem, "cut it into shorter bursts").about(&path));
    }
    let burst_of = |range: Range<usize>| {
        let frames = &frames[range];
        BurstFiles { name: stem(&frames[frames.len() / 2]), paths: frames.to_vec() }
    };
    let mut bursts: Vec<BurstFiles> = ranges.map(burst_of).collect();
    make_names_unique(&mut bursts);
    Ok(bursts)
}

/// Name of a burst of one of several sequences.
pub fn name_among_several(sequence: &str, burst: &str) -> String {
    format!("{sequence}_{burst}")
}
