//! Tests of `dataset::stamp`.
#![allow(unused_imports)]

use burstscope_core::dataset::*;
use burstscope_core::error::*;
use burstscope_core::files::*;
use burstscope_core::monitor::*;
use serde::{Deserialize, Serialize};
use std::fs::Metadata;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::time::UNIX_EPOCH;

fn agree(kept: &[FileStamp], files: &[PathBuf], comparison: Comparison) -> bool {
    FileStamp::all_agree(kept, files, comparison, &Monitor::default()).expect("readable")
}

const ALL: [Comparison; 3] = [Comparison::Times, Comparison::Content, Comparison::Glance];

#[test]
fn a_file_of_the_same_length_and_date_is_told_from_the_one_that_was_read() {
    let home = tempfile::tempdir().expect("a folder");
    let path = home.path().join("a.png");
    let files = [path.clone()];
    std::fs::write(&path, "one").expect("written");
    let modified = std::fs::metadata(&path).and_then(|file| file.modified()).expect("a time");
    let kept = FileStamp::with_checksums(&files, &Monitor::default()).expect("readable");
    assert!(ALL.iter().all(|comparison| agree(&kept, &files, *comparison)));
    // The clock of the file system may stand still for some milliseconds.
    std::thread::sleep(std::time::Duration::from_millis(30));
    std::fs::write(&path, "two").expect("written");
    std::fs::File::options().write(true).open(&path).and_then(|file| file.set_modified(modified)).expect("set");
    assert!(!agree(&kept, &files, Comparison::Content));
    if cfg!(unix) {
        assert!(!agree(&kept, &files, Comparison::Times) && !agree(&kept, &files, Comparison::Glance));
    }
    // The same content written again: other times, so a glance reports a change.
    std::fs::write(&path, "one").expect("written");
    assert!(agree(&kept, &files, Comparison::Times) && agree(&kept, &files, Comparison::Content));
    if cfg!(unix) {
        assert!(!agree(&kept, &files, Comparison::Glance));
    }
    let renewed = FileStamp::with_times_of(&kept, &files).expect("readable");
    assert!(ALL.iter().all(|comparison| agree(&renewed, &files, *comparison)));
    std::fs::write(&path, "longer").expect("written");
    assert!(ALL.iter().all(|comparison| !agree(&kept, &files, *comparison)));
    assert!(ALL.iter().all(|comparison| !agree(&kept, &[], *comparison)));
    // Neither is one that cannot be read, nor a check that is cancelled.
    std::fs::write(&path, "two").expect("written");
    let cancelled = FileStamp::all_agree(&kept, &files, Comparison::Content, &Monitor::cancelled());
    assert!(cancelled.is_err_and(|error| error.is_cancelled()));
    std::fs::remove_file(&path).expect("removed");
    let gone = FileStamp::all_agree(&kept, &files, Comparison::Times, &Monitor::default());
    assert!(gone.as_ref().is_err_and(|error| error.problem.starts_with("cannot read this")), "{gone:?}");
}

