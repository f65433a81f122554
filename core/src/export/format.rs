//! The formats in which features are exported, and the names of their files, for the window's dialog and `--format`.

use super::csv::{FeatureVerdict, write_csv};
use super::{colmap::write_colmap, npz::write_npz};
use crate::detector::Detection;
use crate::error::{Error, Result};
use std::path::{Path, PathBuf};
use std::{collections::HashSet, ffi::OsStr, str::FromStr};

/// Export format of features.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, strum::Display)]
#[strum(serialize_all = "lowercase")]
pub enum ExportFormat {
    /// A table of the features, `NAME.csv`.
    Csv,
    /// Features and descriptors for COLMAP's importer, `NAME.txt`.
    Colmap,
    /// Features and descriptors for numpy, `NAME.npz`.
    Npz,
}

impl ExportFormat {
    /// All formats.
    pub const ALL: [Self; 3] = [Self::Csv, Self::Colmap, Self::Npz];

    /// Extension of its files, without the dot.
    pub fn extension(self) -> &'static str {
        ["csv", "txt", "npz"][self as usize]
    }

    /// Description for a dialog or a help text.
    pub fn description(self) -> &'static str {
        match self {
            Self::Csv => "Table of features (CSV)",
            Self::Colmap => "Features and descriptors for COLMAP (text)",
            Self::Npz => "Features and descriptors for numpy (npz)",
        }
    }

    /// Writes the features of `detection` to the file `path` in this format.
    pub fn write(self, path: &Path, detection: &Detection, verdicts: Option<&[FeatureVerdict]>) -> Result<()> {
        match self {
            Self::Csv => write_csv(path, &detection.features, verdicts),
            Self::Colmap => write_colmap(path, &detection.features, &detection.descriptors),
            Self::Npz => write_npz(path, &detection.features, &detection.descriptors, verdicts),
        }
    }
}

impl FromStr for ExportFormat {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        Self::ALL.into_iter().find(|f| f.to_string().eq_ignore_ascii_case(text.trim())).ok_or_else(|| {
            let problem = format!("there is no export format '{text}'");
            Error::param("", problem, "the formats are csv, colmap and npz")
        })
    }
}

/// Writes the detection into `folder` (created if missing) in each of `formats`: `NAME.csv`, `NAME.txt` for COLMAP,
/// `NAME.npz`, with `burst_name` made safe by [`safe_file_name`]. Returns the paths in the order of `formats`.
///
/// # Errors
/// The one of the first file that cannot be written; earlier files are complete.
pub fn write_detection(
    folder: &Path,
    burst_name: &str,
    detection: &Detection,
    verdicts: Option<&[FeatureVerdict]>,
    formats: &[ExportFormat],
) -> Result<Vec<PathBuf>> {
    // Stops at the first error: a full disk fails for every format.
    let written = detection_files(folder, burst_name, formats).into_iter().zip(formats).map(|(path, format)| {
        format.write(&path, detection, verdicts)?;
        Ok(path)
    });
    written.collect()
}

/// The paths of the files that [`write_detection`] writes, one for each of `formats`.
pub fn detection_files(folder: &Path, burst_name: &str, formats: &[ExportFormat]) -> Vec<PathBuf> {
    let name = safe_file_name(burst_name);
    formats.iter().map(|format| folder.join(format!("{name}.{}", format.extension()))).collect()
}

/// Longest name, bytes: a file's may have 255, with extensions such as `.matches.csv` and `-burstscope-100-100`.
const LONGEST_NAME: usize = 200;

/// The name with all characters replaced by `_` that some system does not allow in a file's name. Never empty, never a
/// path. A name of more than 200 bytes is cut, and ends with a checksum of the whole.
pub fn safe_file_name(name: &str) -> String {
    let forbidden = |c: char| c.is_control() || r#"/\:*?"<>|"#.contains(c);
    let name: String = name.chars().map(|c| if forbidden(c) { '_' } else { c }).collect();
    // Windows drops dots and spaces at the end; a dot at the start would hide the file.
    let name = name.trim_end_matches(['.', ' ']).trim_start_matches(['.', ' ']);
    if name.len() <= LONGEST_NAME {
        return if name.is_empty() { "burst".into() } else { name.into() };
    }
    // Two long names that differ only at their ends stay different.
    let checksum = format!("~{:08x}", crc32fast::hash(name.as_bytes()));
    format!("{}{checksum}", &name[..name.floor_char_boundary(LONGEST_NAME - checksum.len())])
}

/// Makes file names ([`safe_file_name`]) unique, even where upper and lower case are the same. Names that clash get the
/// name of the folder above their path in front (`n1_a`); those that clash still, or have no path, get a number.
pub fn make_file_names_unique<'a>(names: impl Iterator<Item = (&'a mut String, Option<PathBuf>)>) {
    let key = |name: &str| safe_file_name(name).to_lowercase();
    let (names, mut taken): (Vec<_>, HashSet<String>) = (names.collect(), HashSet::new());
    let mut uses = std::collections::HashMap::<String, usize>::new();
    names.iter().for_each(|(name, _)| *uses.entry(key(name)).or_default() += 1);
    for (name, path) in names {
        let is_of_name = |path: &&Path| [path.file_name(), path.file_stem()].contains(&Some(OsStr::new(&*name)));
        let of_name = path.as_ref().and_then(|path| path.ancestors().find(is_of_name));
        let folder = of_name.and_then(Path::parent).and_then(Path::file_name);
        if let Some(folder) = folder.filter(|_| uses[&key(name)] > 1) {
            *name = format!("{}_{name}", folder.to_string_lossy());
        }
        if !taken.insert(key(name)) {
            let number = (2..).find(|n| !taken.contains(&key(&format!("{name}_{n}")))).expect("numbers never end");
            *name = format!("{name}_{number}");
            taken.insert(key(name));
        }
    }
}
