//! Rules for overwriting files: never a file that was opened, and files of others only with `--force`.
//!
//! An existing file is checked before the work begins, so that a refusal comes early, and again before it is written.
//! Whether it is one of the inputs is decided by the system's data about both: the names by which a file was opened may
//! be relative, lead through links, or be one of several of the same file.

use super::atomic::is_of_system;
use super::error::ExportError;
use super::mark::is_ours;
use std::collections::HashSet;
use std::fs::Metadata;
use std::path::{Path, PathBuf};

/// Whether files that Burstscope did not write may be replaced.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Overwrite {
    /// Only files that Burstscope wrote are replaced. Links stay.
    #[default]
    Refuse,
    /// Any file is replaced, and a link by the file; the link's target stays.
    Force,
}

/// Files that were opened, or will be.
#[derive(Debug, Clone, Default)]
pub struct OpenedFiles {
    /// Names in their folders, without links in the folders.
    places: HashSet<PathBuf>,
    /// Files that the names lead to.
    targets: HashSet<Identity>,
}

/// Identity of a file: equal for two names of the same file.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
enum Identity {
    /// Device and inode number of the file.
    #[cfg(unix)]
    Number(u64, u64),
    /// Name without links.
    #[cfg(not(unix))]
    Path(PathBuf),
}

impl Identity {
    #[cfg(unix)]
    fn of(_: &Path, metadata: &Metadata) -> Option<Self> {
        use std::os::unix::fs::MetadataExt;
        Some(Self::Number(metadata.dev(), metadata.ino()))
    }

    #[cfg(not(unix))]
    fn of(path: &Path, _: &Metadata) -> Option<Self> {
        std::fs::canonicalize(path).ok().map(Self::Path)
    }
}

impl OpenedFiles {
    /// The inputs `files`. A name of a missing file is left out.
    pub fn of(files: impl IntoIterator<Item = PathBuf>) -> Self {
        let mut inputs = Self::default();
        // Frames usually lie in one folder: consecutive files of a folder share its look-up.
        let mut last: Option<(PathBuf, PathBuf)> = None;
        for file in files {
            let Some((folder, name)) = parted(&file) else { continue };
            let known = last.take().filter(|(asked, _)| asked == folder).map(|(_, real)| real);
            let Some(real) = known.or_else(|| std::fs::canonicalize(folder).ok()) else { continue };
            inputs.places.insert(real.join(name));
            inputs.targets.extend(std::fs::metadata(&file).ok().and_then(|metadata| Identity::of(&file, &metadata)));
            last = Some((folder.to_path_buf(), real));
        }
        inputs
    }

    /// Whether `path`, whose `metadata` the system gave without following a link, is one of the inputs.
    fn hold(&self, path: &Path, metadata: &Metadata) -> bool {
        let by_name = parted(path)
            .and_then(|(folder, name)| Some(std::fs::canonicalize(folder).ok()?.join(name)))
            .is_some_and(|place| self.places.contains(&place));
        // A link to an input is no input: replacing it loses nothing.
        let by_target = || Identity::of(path, metadata).is_some_and(|identity| self.targets.contains(&identity));
        by_name || (!metadata.is_symlink() && by_target())
    }

    /// Whether an input lies in `folder`, or below it.
    fn any_below(&self, folder: &Path) -> bool {
        let Ok(folder) = std::fs::canonicalize(folder) else { return false };
        self.places.iter().any(|place| place.starts_with(&folder))
    }
}

/// The folder and the name of a file.
fn parted(path: &Path) -> Option<(&Path, &std::ffi::OsStr)> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    Some((folder, path.file_name()?))
}

/// Rules for overwriting files.
#[derive(Debug, Clone, Default)]
pub struct OutputRules {
    inputs: OpenedFiles,
    overwrite: Overwrite,
}

impl OutputRules {
    /// Rules for a run that opens `inputs`.
    pub fn new(inputs: OpenedFiles, overwrite: Overwrite) -> Self {
        Self { inputs, overwrite }
    }

    /// These rules for a run that has also opened `files`.
    pub fn and_opened(mut self, files: impl IntoIterator<Item = PathBuf>) -> Self {
        let OpenedFiles { places, targets } = OpenedFiles::of(files);
        self.inputs.places.extend(places);
        self.inputs.targets.extend(targets);
        self
    }

    /// Checks whether the file `path` may be written. An empty file counts as missing.
    ///
    /// # Errors
    /// [`ExportError::Input`] for a file that was opened, in any case; [`ExportError::NotAFile`] for a folder or a
    /// device; without [`Overwrite::Force`] [`ExportError::Link`] for a link and [`ExportError::Foreign`] for a file
    /// that Burstscope did not write.
    pub fn check(&self, path: &Path) -> Result<(), ExportError> {
        self.check_if(path, |metadata| metadata.len() == 0 || is_ours(path))
    }

    /// Checks whether `path` may be written in a folder known to be this program's own: every file there may be
    /// replaced.
    ///
    /// # Errors
    /// As [`Self::check`], except for [`ExportError::Foreign`].
    pub fn check_own(&self, path: &Path) -> Result<(), ExportError> {
        self.check_if(path, |_| true)
    }

    fn check_if(&self, path: &Path, is_ours: impl FnOnce(&Metadata) -> bool) -> Result<(), ExportError> {
        let Ok(metadata) = std::fs::symlink_metadata(path) else { return Ok(()) };
        let refused = match self.overwrite {
            _ if is_of_system(path) => ExportError::NotAFile { path: path.into() },
            _ if self.inputs.hold(path, &metadata) => ExportError::Input { path: path.into() },
            Overwrite::Refuse if metadata.is_symlink() => ExportError::Link { path: path.into() },
            _ if !(metadata.is_file() || metadata.is_symlink()) => ExportError::NotAFile { path: path.into() },
            Overwrite::Refuse if !is_ours(&metadata) => ExportError::Foreign { path: path.into() },
            _ => return Ok(()),
        };
        Err(refused)
    }

    /// Checks that `folder` may be replaced as a whole with respect to opened files.
    ///
    /// # Errors
    /// [`ExportError::Input`] when an opened file lies in it.
    pub fn check_folder(&self, folder: &Path) -> Result<(), ExportError> {
        if self.inputs.any_below(folder) { Err(ExportError::Input { path: folder.into() }) } else { Ok(()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A folder with a frame, a note, and a table of ours.
    fn home() -> (tempfile::TempDir, impl Fn(&str) -> PathBuf) {
        let home = tempfile::tempdir().expect("a folder");
        let root = home.path().to_path_buf();
        let at = move |name: &str| root.join(name);
        std::fs::create_dir(at("night")).expect("made");
        std::fs::write(at("night/f0.png"), "a frame").expect("written");
        std::fs::write(at("notes.txt"), "about the night").expect("written");
        std::fs::write(at("a.txt"), "0 128\n").expect("written");
        (home, at)
    }

    fn rules(inputs: &[PathBuf], overwrite: Overwrite) -> OutputRules {
        OutputRules::new(OpenedFiles::of(inputs.iter().cloned()), overwrite)
    }

    #[test]
    fn what_was_opened_is_never_replaced() {
        let (_home, at) = home();
        let opened = [at("night/f0.png"), at("gone.png"), at("a.txt")];
        for overwrite in [Overwrite::Refuse, Overwrite::Force] {
            let rules = rules(&opened, overwrite);
            for name in ["night/f0.png", "night/../night/./f0.png", "a.txt"] {
                let path = at(name);
                assert_eq!(rules.check(&path), Err(ExportError::Input { path: path.clone() }), "{name}");
                assert_eq!(rules.check_own(&path), Err(ExportError::Input { path }), "{name}");
            }
            assert_eq!(rules.check(&at("new/x.png")), Ok(()));
            assert!(rules.check_folder(&at("night")).is_err() && rules.check_folder(&at("")).is_err());
            assert_eq!(rules.check_folder(&at("new")), Ok(()));
            assert!(matches!(rules.check(&at("night")), Err(ExportError::NotAFile { .. })));
        }
    }

    #[test]
    fn what_others_wrote_is_replaced_by_force_alone() {
        let (_home, at) = home();
        std::fs::write(at("empty.txt"), "").expect("written");
        let careful = rules(&[], Overwrite::Refuse);
        assert_eq!(careful.check(&at("notes.txt")), Err(ExportError::Foreign { path: at("notes.txt") }));
        for name in ["a.txt", "empty.txt", "none.txt"] {
            assert_eq!(careful.check(&at(name)), Ok(()), "{name}");
        }
        assert_eq!(careful.check_own(&at("notes.txt")), Ok(()));
        assert_eq!(rules(&[], Overwrite::Force).check(&at("notes.txt")), Ok(()));
    }

    #[cfg(unix)]
    #[test]
    fn links_and_second_names_are_told() {
        let (_home, at) = home();
        let link = |target: &str, name: &str| std::os::unix::fs::symlink(at(target), at(name)).expect("linked");
        std::fs::hard_link(at("night/f0.png"), at("second.png")).expect("linked");
        link("night/f0.png", "to_frame.png");
        link("a.txt", "to_ours.txt");
        link("nowhere", "to_nowhere.txt");
        link("night", "to_folder");
        let names = ["to_frame.png", "to_ours.txt", "to_nowhere.txt", "to_folder"];
        for (overwrite, is_refused) in [(Overwrite::Refuse, true), (Overwrite::Force, false)] {
            let rules = rules(&[at("night/f0.png")], overwrite);
            assert!(matches!(rules.check(&at("second.png")), Err(ExportError::Input { .. })), "the frame's other name");
            assert!(matches!(rules.check(&at("to_folder/f0.png")), Err(ExportError::Input { .. })));
            for name in names {
                let link = Err(ExportError::Link { path: at(name) });
                assert_eq!(rules.check(&at(name)), if is_refused { link } else { Ok(()) }, "{name}");
            }
        }
        // A link that was opened as a frame counts as a frame.
        let of_links = rules(&[at("to_frame.png")], Overwrite::Force);
        assert!(matches!(of_links.check(&at("to_frame.png")), Err(ExportError::Input { .. })));
        assert!(matches!(of_links.check(&at("night/f0.png")), Err(ExportError::Input { .. })));
    }
}
