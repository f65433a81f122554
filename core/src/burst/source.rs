//! Finding of the bursts that an input names.
//!
//! A folder that holds pictures is a burst. A folder that holds none, but has subfolders that do, is a dataset: each of
//! those subfolders is a burst; so is a folder of bursts beside which fewer pictures lie than it has bursts, such as a
//! preview. Such stray pictures are listed apart. A subfolder that cannot be read is listed as a burst, whose opening
//! gives the error: one bad entry does not hide the others. A multi-page TIFF or a `.npy` stack alone is a burst;
//! several stacks, given together or lying in one folder, are several bursts. Several single pictures are the frames of
//! one burst.
//!
//! A folder is read in natural order (`frame_2` before `frame_10`). Files named one by one keep the order in which they
//! are named, so that frames can be ordered by hand.

use super::decode;
use super::error::OpenError;
use crate::files::path_text;
use std::cmp::Ordering;
use std::collections::HashSet;
use std::path::{Path, PathBuf};

/// The files of one burst: its name, and the paths for [`Burst::open_with`](super::Burst::open_with).
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BurstFiles {
    /// Name of the folder, or of the stack without its extension. Unique in one result of [`find_bursts`].
    pub name: String,
    /// A folder, a stack, or the frames in time order.
    pub paths: Vec<PathBuf>,
}

impl BurstFiles {
    /// Files with its frames: those of its folder in natural order, or its paths.
    ///
    /// # Errors
    /// The folder cannot be read.
    pub fn files(&self) -> Result<Vec<PathBuf>, OpenError> {
        files_at(&self.paths)
    }
}

/// Files with the frames at `paths`: those of a single folder in natural order, or the paths themselves.
///
/// # Errors
/// The folder cannot be read.
pub fn files_at(paths: &[PathBuf]) -> Result<Vec<PathBuf>, OpenError> {
    match paths {
        [folder] if folder.is_dir() => pictures_of_folder(folder),
        paths => Ok(paths.to_vec()),
    }
}

/// Extensions (lower case, without a dot) of files that are taken for pictures in a folder.
pub fn supported_extensions() -> Vec<&'static str> {
    let raw = if cfg!(feature = "raw") { decode::RAW_EXTENSIONS } else { &[] };
    [PICTURE_EXTENSIONS, raw].concat()
}

const PICTURE_EXTENSIONS: &[&str] =
    &["png", "tif", "tiff", "npy", "jpg", "jpeg", "pgm", "ppm", "pnm", "pbm", "pam", "webp", "bmp"];

/// Bursts that `inputs` name, in natural order (folders and stacks named one by one keep their order). Reads folders
/// and the headers of possible stacks, no pixels.
///
/// # Errors
/// Nothing given, a missing path, a folder without pictures, folders and files together, a stack among single frames.
pub fn find_bursts(inputs: &[PathBuf]) -> Result<Vec<BurstFiles>, OpenError> {
    Ok(find_entries(inputs)?.bursts)
}

/// Bursts and stray pictures of an input.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Entries {
    /// The bursts.
    pub bursts: Vec<BurstFiles>,
    /// Pictures that lie beside the bursts of a dataset and belong to none.
    pub strays: Vec<PathBuf>,
}

/// Finds bursts as [`find_bursts`], and the pictures that belong to none.
///
/// # Errors
/// As [`find_bursts`].
pub fn find_entries(inputs: &[PathBuf]) -> Result<Entries, OpenError> {
    if inputs.is_empty() {
        return Err(OpenError::NothingGiven);
    }
    let (mut folders, mut files) = (Vec::new(), Vec::new());
    for path in inputs {
        let metadata = std::fs::metadata(path).map_err(|e| OpenError::from_io(path, &e))?;
        if metadata.is_dir() {
            folders.push(path.clone());
        } else if metadata.is_file() {
            files.push(path.clone());
        } else {
            return Err(OpenError::NotAFile { path: path.clone() });
        }
    }
    if let (Some(folder), Some(file)) = (folders.first(), files.first()) {
        return Err(OpenError::MixedInput { folder: folder.clone(), file: file.clone() });
    }
    let mut entries = Entries::default();
    for folder in &folders {
        let found = entries_of_folder(folder, true)?;
        if found.bursts.is_empty() {
            return Err(OpenError::NoPictures { path: folder.clone() });
        }
        entries.bursts.extend(found.bursts);
        entries.strays.extend(found.strays);
    }
    if !files.is_empty() {
        entries.bursts.extend(bursts_of_files(files)?);
    }
    make_names_unique(&mut entries.bursts);
    Ok(entries)
}

/// Pictures of a folder, in natural order. Hidden files and files of other kinds are left out.
fn pictures_of_folder(folder: &Path) -> Result<Vec<PathBuf>, OpenError> {
    Ok(list(folder)?.0)
}

fn entries_of_folder(folder: &Path, look_into_subfolders: bool) -> Result<Entries, OpenError> {
    let (pictures, subfolders) = list(folder)?;
    if pictures.len() > 1 && pictures.iter().all(|p| is_stack(p)) {
        return Ok(Entries { bursts: pictures.into_iter().map(stack_source).collect(), strays: Vec::new() });
    }
    let mut bursts = Vec::new();
    if look_into_subfolders && pictures.len() < subfolders.len() {
        for subfolder in &subfolders {
            match entries_of_folder(subfolder, false) {
                Ok(found) => bursts.extend(found.bursts),
                // Opening it gives the error.
                Err(_) => bursts.push(folder_source(subfolder)),
            }
        }
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

fn bursts_of_files(files: Vec<PathBuf>) -> Result<Vec<BurstFiles>, OpenError> {
    if let [single] = &files[..] {
        return Ok(vec![stack_source(single.clone())]);
    }
    let stacks = files.iter().filter(|f| is_stack(f)).count();
    if stacks == files.len() {
        return Ok(files.into_iter().map(stack_source).collect());
    }
    if stacks > 0 {
        let path = files.iter().find(|f| is_stack(f)).expect("there is at least one stack").clone();
        let frames = decode::frame_count(&path).unwrap_or(2);
        return Err(OpenError::StackAmongFrames { path, frames });
    }
    let parent = files[0].parent().unwrap_or(Path::new(""));
    let together = files.iter().all(|f| f.parent().unwrap_or(Path::new("")) == parent);
    let name = if together { folder_name(parent) } else { stem(&files[0]) };
    Ok(vec![BurstFiles { name, paths: files }])
}

/// Whether the file holds more than one frame. False for a file that cannot be read: opening it gives the error.
pub(super) fn is_stack(path: &Path) -> bool {
    decode::frame_count(path).is_ok_and(|frames| frames > 1)
}

fn stack_source(path: PathBuf) -> BurstFiles {
    BurstFiles { name: stem(&path), paths: vec![path] }
}

pub(super) fn stem(path: &Path) -> String {
    path.file_stem().map_or_else(|| "burst".into(), |s| path_text(Path::new(s)))
}

/// Name of a folder, also of `.` or `a/..`.
pub(super) fn folder_name(folder: &Path) -> String {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let named = |p: &Path| p.file_name().map(|s| path_text(Path::new(s)));
    named(folder).or_else(|| named(&std::fs::canonicalize(folder).ok()?)).unwrap_or_else(|| "burst".into())
}

/// Pictures and subfolders of a folder, each in natural order.
fn list(folder: &Path) -> Result<(Vec<PathBuf>, Vec<PathBuf>), OpenError> {
    let (mut pictures, mut subfolders) = (Vec::new(), Vec::new());
    let entries = std::fs::read_dir(folder).map_err(|e| OpenError::from_io(folder, &e))?;
    for entry in entries {
        let entry = entry.map_err(|e| OpenError::from_io(folder, &e))?;
        if entry.file_name().to_string_lossy().starts_with('.') {
            continue;
        }
        let path = entry.path();
        // Follows links. A broken link with a picture's extension counts as a picture, so that opening names it.
        match std::fs::metadata(&path) {
            Ok(metadata) if metadata.is_dir() => subfolders.push(path),
            _ if has_picture_extension(&path) => pictures.push(path),
            _ => {}
        }
    }
    pictures.sort_by(|a, b| natural_order(a, b));
    subfolders.sort_by(|a, b| natural_order(a, b));
    Ok((pictures, subfolders))
}

fn has_picture_extension(path: &Path) -> bool {
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
    extension.is_some_and(|e| supported_extensions().contains(&&*e))
}

/// Natural order of file names; names that differ only in leading zeros are ordered by their bytes, so that the order
/// never depends on the file system.
pub(super) fn natural_order(a: &Path, b: &Path) -> Ordering {
    let name = |p: &Path| p.file_name().unwrap_or_default().to_os_string();
    alphanumeric_sort::compare_os_str(name(a), name(b)).then_with(|| a.cmp(b))
}

/// Numbers the second and later bursts of one name, so that their exports do not overwrite each other. Letter case is
/// ignored, as some file systems do.
pub(super) fn make_names_unique(sources: &mut [BurstFiles]) {
    let mut taken = HashSet::new();
    for source in sources {
        let mut name = source.name.clone();
        let mut number = 2;
        while !taken.insert(name.to_lowercase()) {
            name = format!("{}-{number}", source.name);
            number += 1;
        }
        source.name = name;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn numbers_count_as_numbers() {
        let mut names = ["frame_10.png", "frame_2.png", "frame_002.png", "frame_1.png", "a.png", "frame_.png"];
        names.sort_by(|a, b| natural_order(Path::new(a), Path::new(b)));
        assert_eq!(names, ["a.png", "frame_.png", "frame_1.png", "frame_2.png", "frame_002.png", "frame_10.png"]);
    }

    proptest! {
        // If this were not a total order, sorting could panic, and would depend on the file system.
        #[test]
        fn natural_order_is_total(names in prop::array::uniform3("[0-9a_.é٣\u{ff11}-]{0,6}|[0-9]{15,25}")) {
            let [a, b, c] = names.each_ref().map(Path::new);
            prop_assert_eq!(natural_order(a, b), natural_order(b, a).reverse());
            prop_assert_eq!(natural_order(a, b) == Ordering::Equal, a == b);
            if natural_order(a, b) != Ordering::Greater && natural_order(b, c) != Ordering::Greater {
                prop_assert_ne!(natural_order(a, c), Ordering::Greater);
            }
        }
    }
}
