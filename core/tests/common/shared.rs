//! Folders of tests, words of messages, and the location of the real input.
//!
//! That input and the published implementations' results are in the folder that `BURSTSCOPE_SHARED` names, or else in
//! `../shared` beside the checkout. A test that needs one of them is marked with `#[needs::shared(…)]`, and is ignored
//! where it is missing.
#![allow(dead_code)] // Each test program uses a part of it.

use std::path::{Path, PathBuf};

/// The path `relative` below the folder of real input.
pub fn shared(relative: &str) -> PathBuf {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    let checkout = package.ancestors().find(|folder| folder.join("Cargo.lock").exists()).unwrap_or(package);
    let root = std::env::var_os("BURSTSCOPE_SHARED").map_or_else(|| checkout.join("../shared"), PathBuf::from);
    let path = root.join(relative);
    assert!(path.exists(), "{} is missing; set BURSTSCOPE_SHARED to the folder that holds {relative}", path.display());
    path
}

pub struct Folder(tempfile::TempDir);

impl std::ops::Deref for Folder {
    type Target = Path;

    fn deref(&self) -> &Path {
        self.0.path()
    }
}

impl AsRef<Path> for Folder {
    fn as_ref(&self) -> &Path {
        self
    }
}

pub fn folder() -> Folder {
    Folder(tempfile::tempdir().expect("a temporary folder"))
}

#[track_caller]
pub fn says(text: impl std::fmt::Display, words: &[&str]) {
    let text = text.to_string();
    words.iter().for_each(|word| assert!(text.contains(word), "no '{word}' in: {text}"));
}

/// A new folder that disappears after the test, and the path of this name in it.
pub fn folder_with(name: &str) -> (Folder, PathBuf) {
    let folder = folder();
    let path = folder.join(name);
    (folder, path)
}

/// Names in a folder, sorted, including hidden ones.
pub fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> = std::fs::read_dir(folder)
        .expect("a folder")
        .map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    names
}
