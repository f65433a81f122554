//! Tests of `export::atomic`.
#![allow(unused_imports)]

use burstscope_core::error::*;
use burstscope_core::export::*;
use burstscope_core::files::mark::*;
use burstscope_core::files::unfinished::*;
use burstscope_core::files::*;
use std::fs::{File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::Path;

fn count(folder: &Path) -> usize {
    std::fs::read_dir(folder).expect("folder").count()
}

#[test]
fn a_failing_or_panicking_write_leaves_the_old_file_and_nothing_else() {
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("a.txt");
    write_whole(&path, |w| w.write_all(b"old")).expect("written");
    let full = || Err(io::Error::other("disk full"));
    let error = write_whole(&path, |w| w.write_all(&[b'x'; 1 << 18]).and_then(|()| full()));
    assert_eq!(error, Err(Error::unwritten(&path, &io::Error::other("disk full"))));
    assert_eq!(std::fs::read(&path).expect("read"), b"old");
    assert_eq!(count(folder.path()), 1);
    let path = folder.path().join("new.txt");
    let panicked = std::panic::catch_unwind(|| write_whole(&path, |_| panic!("on purpose")));
    assert!(panicked.is_err());
    assert_eq!(count(folder.path()), 1);
}
