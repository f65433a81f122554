//! A format for the test of this room: what one needs is this file and its line of the list.

use super::{Input, Numbers, Rank, Record, file_formats};
use crate::burst::reading::{plain::Plain, read_at};
use crate::burst::{Burst, info::Info, number::Number, options::OpenOptions};
use crate::error::{Error, ErrorKind, Result};
use crate::monitor::Monitor;
use std::path::Path;

const HEADER_BYTES: u64 = 6;

pub(super) struct Toy;

impl Numbers for Toy {
    const MAGIC: Option<&'static [u8]> = Some(b"TOY");

    fn record(&self) -> Record {
        Record { name: "toy", rank: Rank::Film, extensions: &["toy"], opens: "bytes", options: "" }
    }

    fn plain(&self, input: Input, path: &Path, options: &OpenOptions) -> Result<Plain> {
        let mut header = [0; HEADER_BYTES as usize];
        read_at(&mut &input.file, 0, &mut header).map_err(|e| Error::from_io(path, &e))?;
        let [frames, rows, columns] = [header[3], header[4], header[5]].map(u64::from);
        let place = (HEADER_BYTES, rows * columns, input.length);
        let places = Plain::places_in(path, "toy", (frames, rows, columns), place, &options.limits)?;
        Ok(Plain::new("toy", (columns as usize, rows as usize), places, Number::U8))
    }
}

#[test]
fn a_format_is_a_file_and_a_line() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("burst.toy");
    let pixels: Vec<u8> = (0..60).map(|i| i * 4).collect();
    std::fs::write(&path, [b"TOY\x03\x04\x05", &pixels[..]].concat()).expect("written");
    let options = OpenOptions::default();
    let open_at = |path: &Path, options: &OpenOptions| Burst::open_with(&[path.into()], options, &Monitor::default());
    let open = |options: &OpenOptions| open_at(&path, options);
    let burst = open(&options).expect("a burst");
    assert_eq!((burst.len(), burst.size(), burst.frames[1].at(2, 3)), (3, (5, 4), f32::from(pixels[37]) / 255.0));
    let info = Info::of(std::slice::from_ref(&path), &options, &Monitor::default()).expect("described");
    assert_eq!((info.frames, info.width, info.height), (3, 5, 4));
    let taken = open(&OpenOptions { take: Some("1..3".parse().expect("a range")), ..options.clone() }).expect("a part");
    assert_eq!(taken.frames, burst.frames[1..]);
    assert!(file_formats().any(|format| format.name == "toy") && super::rank(&path) == Some(Rank::Film));
    // In a folder, under the name of another format, and cut.
    assert_eq!(open_at(folder.path(), &options).expect("of a folder").len(), 3);
    let cut = folder.path().join("cut.fits");
    std::fs::write(&cut, [b"TOY\x03\x04\x05", &pixels[..59]].concat()).expect("written");
    let error = open_at(&cut, &options).expect_err("it is cut");
    assert!(error.kind == ErrorKind::Damaged && error.to_string().contains("toy"), "{error}");
}
