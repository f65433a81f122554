//! Files in general: which are read and how far, names as text, errors about them, and locks of folders.

use crate::prelude::*;
use burstscope_core::files::lock::{FolderLock, LOCK_FILE};
use burstscope_core::files::{explained, path_text, read_text, whole_number, write_problem, written_by};
use std::io;

#[test]
fn files_are_read_up_to_their_limit_which_is_said_also_by_an_encoder() {
    let (home, path) = folder_with("a.toml");
    fs::write(&path, "levels = 4\n").expect("written");
    assert_eq!(read_text(&path, 11).expect("just fits"), "levels = 4\n");
    assert_eq!(read_text(&path, 10).expect_err("too large").kind(), io::ErrorKind::FileTooLarge);
    assert_eq!(read_text(&home, 10).expect_err("a folder").kind(), io::ErrorKind::InvalidInput);
    fs::write(&path, [0xff, b'a']).expect("written");
    assert_eq!(read_text(&path, 10).expect_err("no text").kind(), io::ErrorKind::InvalidData);
    #[cfg(unix)]
    assert_eq!(read_text(Path::new("/dev/zero"), 10).expect_err("a device").kind(), io::ErrorKind::InvalidInput);
    let limit = || io::Error::from(io::ErrorKind::FileTooLarge);
    for error in [limit(), io::Error::other(limit()), io::Error::other(io::Error::other(limit()))] {
        assert!(write_problem(&error).contains("ulimit -f"), "{error}");
    }
    assert_eq!(write_problem(&io::Error::other("disk full")), "disk full");
}

#[test]
fn a_newer_writer_is_said_and_a_path_ends_the_line_while_anything_else_begins_it() {
    assert_eq!(explained(&format!("{}levels = 4\n", written_by()), "unknown field"), "unknown field");
    assert_eq!(explained("levels = 4", "unknown field"), "unknown field");
    let newer = "# Written by Burstscope 99.10.2\nlevels = 4\n";
    says(explained(newer, "unknown field"), &["99.10.2", env!("CARGO_PKG_VERSION"), "unknown field"]);
    assert_eq!(explained("# Written by Burstscope soon\n", "x"), "x");
    let path = Path::new("night/f0.png");
    let content = Error::new(ErrorKind::Content, "made for 9 pixels", "give another").about(path);
    for (error, words) in [
        (Error::param("ratio", "2 is above 1", "give 0 to 1"), "ratio: 2 is above 1; give 0 to 1"),
        (Error::param("", "there is no format 'x'", ""), "there is no format 'x'"),
        (content, "night/f0.png: made for 9 pixels; give another"),
        (Error::unread(path, "it is gone"), "cannot read this: it is gone: night/f0.png"),
        (Error::new(ErrorKind::Locked, "another writes", "wait").about(path), "another writes; wait: night/f0.png"),
        (Cancelled.into(), "cancelled"),
    ] {
        assert_eq!(error.to_string(), words);
    }
}

#[cfg(unix)]
#[test]
fn names_that_are_no_text_are_said_and_told_apart() {
    use std::os::unix::ffi::OsStrExt;
    let text = |bytes: &[u8]| path_text(Path::new(std::ffi::OsStr::from_bytes(bytes)));
    assert_eq!(text("nächte/1".as_bytes()), "nächte/1");
    assert_eq!(text(b"night\xff\xfe1"), "night\\xFF\\xFE1");
    assert_ne!(text(b"\xff"), text(b"\xfe"));
}

#[test]
fn one_at_a_time_and_the_owner_is_named_and_whole_numbers_are_those_that_files_keep() {
    let (home, folder) = folder_with("deep/new");
    for lock in [FolderLock::take, FolderLock::beside] {
        let first = lock(&folder).expect("free");
        let refused = lock(&folder).expect_err("another has it").to_string();
        assert!(refused.starts_with(&format!("process {}", std::process::id())), "{refused}");
        drop(first);
        lock(&folder).expect("free again");
    }
    let of_another = FolderLock::beside(&home.join("b")).expect("free");
    FolderLock::beside(&home.join("a")).expect("another folder's lock is no hindrance");
    drop(of_another);
    assert_eq!((whole_number(" 7 "), whole_number("9223372036854775807")), (Ok(7u64), Ok(i64::MAX.unsigned_abs())));
    assert_eq!(whole_number::<u32>("4294967295"), Ok(u32::MAX));
    let fault = |text: &str| whole_number::<u64>(text).expect_err(text);
    assert_eq!(fault("-1"), "'-1' is not a whole number of 0 or more");
    let most = "is more than 9223372036854775807";
    assert!(fault("9223372036854775808").contains(most) && fault(&"9".repeat(40)).contains(most));
    assert!(whole_number::<u32>("4294967296").is_err_and(|fault| fault.contains("more than 4294967295")));
}

#[cfg(unix)]
#[test]
fn nothing_is_left_but_what_was_written_and_a_link_in_place_of_the_lock_is_not_followed() {
    let home = folder();
    let names = || fs::read_dir(&home).expect("a folder").count();
    let folder = home.join("a/b/c");
    drop(FolderLock::take(&folder).expect("free"));
    assert_eq!(names(), 0, "folders that were made for nothing");
    let lock = FolderLock::take(&folder).expect("free");
    fs::write(folder.join("x"), "").expect("written");
    drop(lock);
    assert_eq!(fs::read_dir(&folder).expect("it stays").count(), 1);
    // A lock file left by a killed run is removed by the next lock there.
    fs::write(home.join(".burstscope-old.lock"), "process 4711").expect("written");
    drop(FolderLock::beside(&home.join("d")).expect("free"));
    assert_eq!(names(), 1);
    let (home, precious) = folder_with("thesis.txt");
    fs::write(&precious, "precious").expect("written");
    std::os::unix::fs::symlink(&precious, home.join(LOCK_FILE)).expect("linked");
    assert!(FolderLock::take(&home).is_err_and(|error| error.kind == ErrorKind::Unwritten));
    assert_eq!(fs::read_to_string(&precious).expect("there"), "precious");
}

#[cfg(unix)]
#[test]
fn a_folder_that_is_removed_or_replaced_is_noticed() {
    let (_home, folder) = folder_with("a");
    let lock = FolderLock::take(&folder).expect("free");
    lock.check().expect("it is there");
    fs::remove_dir_all(&folder).expect("removed");
    let gone = lock.check().expect_err("it is gone");
    assert!(gone.kind == ErrorKind::Locked && gone.to_string().contains("was removed while"), "{gone}");
    let next = FolderLock::take(&folder).expect("a new folder has a new lock");
    assert_eq!(lock.check(), Err(gone));
    drop(lock);
    next.check().expect("the old lock has left it alone");
}

#[cfg(unix)]
#[test]
fn many_who_want_it_have_it_one_after_the_other() {
    use std::sync::atomic::{AtomicUsize, Ordering};
    let (_home, folder) = folder_with("a");
    let (inside, had) = (AtomicUsize::new(0), AtomicUsize::new(0));
    std::thread::scope(|scope| {
        for _ in 0..4 {
            scope.spawn(|| {
                let mut own = 0;
                while own < 40 {
                    match FolderLock::take(&folder) {
                        Ok(_lock) => {
                            assert_eq!(inside.fetch_add(1, Ordering::SeqCst), 0, "two have the lock");
                            had.fetch_add(1, Ordering::SeqCst);
                            own += 1;
                            inside.fetch_sub(1, Ordering::SeqCst);
                        }
                        Err(error) if error.kind == ErrorKind::Locked => {}
                        Err(error) => panic!("{error}"),
                    }
                }
            });
        }
    });
    assert_eq!(had.load(Ordering::SeqCst), 160);
}
