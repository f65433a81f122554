//! Checks that `screenshots/` holds the pictures that documents show, those without noise, and no others.

use super::documents::{documents, targets};
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

pub(super) struct Stored {
    pub path: PathBuf,
    pub bytes: u64,
}

impl Stored {
    pub(super) fn is_picture(&self) -> bool {
        self.path.extension().is_some_and(|extension| extension == "png")
    }
}

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("screenshots")
}

/// Files in `screenshots/`, except those that a failed test left.
pub(super) fn stored() -> Vec<Stored> {
    let in_folder =
        |folder: PathBuf| fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path());
    let paths = in_folder(folder()).chain(in_folder(folder().join("flat"))).filter(|path| path.is_file());
    let is_kept = |path: &PathBuf| !path.to_string_lossy().contains(".new.");
    let stored = paths.filter(is_kept).map(|path| Stored {
        bytes: path.metadata().expect("a file").len(),
        path: path.strip_prefix(folder()).expect("it is in there").to_owned(),
    });
    stored.collect()
}

pub(super) fn bytes(stored: &[Stored]) -> usize {
    stored.iter().map(|file| file.bytes as usize).sum()
}

/// Pictures of `screenshots/` that documents show, as paths below it.
fn shown() -> BTreeSet<PathBuf> {
    let below = |target: &str| {
        Some(PathBuf::from(target.split_once("screenshots/")?.1)).filter(|path| path.extension().is_some())
    };
    documents().iter().flat_map(|(_, text)| targets(text).filter_map(below).collect::<Vec<_>>()).collect()
}

#[test]
fn each_picture_is_shown_by_a_document_or_free_of_noise_and_has_its_text() {
    let (stored, shown) = (stored(), shown());
    let paths: BTreeSet<PathBuf> = stored.iter().map(|file| file.path.clone()).collect();
    let (flat, of_documents): (BTreeSet<PathBuf>, _) = stored
        .iter()
        .filter(|file| file.is_picture())
        .map(|file| file.path.clone())
        .partition(|path| path.starts_with("flat"));
    assert_eq!(of_documents, shown, "left: the pictures in screenshots/; right: those that documents show");
    for path in paths.iter().filter(|path| path.starts_with("flat")) {
        assert!(flat.contains(&path.with_extension("png")), "{} has no picture", path.display());
    }
    for picture in flat.iter().chain(&of_documents) {
        assert!(paths.contains(&picture.with_extension("txt")), "{}: no test draws it", picture.display());
    }
    assert!(shown.len() > 10 && flat.len() > 10, "{} and {}", shown.len(), flat.len());
}

#[test]
fn each_text_is_that_of_a_test() {
    let tests = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/window");
    let read =
        |entry: std::io::Result<fs::DirEntry>| fs::read_to_string(entry.expect("an entry").path()).expect("a text");
    let code: String = fs::read_dir(tests).expect("a folder").map(read).collect();
    for file in stored().iter().filter(|file| !file.is_picture()) {
        let name = file.path.with_extension("").to_string_lossy().replace('\\', "/");
        // Those of lessons are named by their lessons.
        let is_drawn = name.starts_with("lesson_") || code.contains(&format!("\"{name}\""));
        assert!(is_drawn, "no test draws {name}");
    }
}
