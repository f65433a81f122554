//! Times of photographs: when they were taken by their EXIF data, or by the date of a TIFF.

use crate::burst::times::{Times, seconds_of};
use exif::{DateTime, Exif, Field, In, Reader, Tag, Value};
use std::{fs::File, io::BufReader, path::Path};

/// Largest file that is read for its time, bytes: of a TIFF all of it is.
const MAX_BYTES: u64 = 1 << 30;
const TAGS: [(Tag, Tag); 3] = [
    (Tag::DateTimeOriginal, Tag::SubSecTimeOriginal),
    (Tag::DateTimeDigitized, Tag::SubSecTimeDigitized),
    (Tag::DateTime, Tag::SubSecTime),
];

pub fn times(path: &Path) -> Times {
    let read = || {
        let file = File::open(path).ok().filter(|file| file.metadata().is_ok_and(|of| of.len() <= MAX_BYTES))?;
        let found = Reader::new().continue_on_error(true).read_from_container(&mut BufReader::new(file));
        // Damaged parts are passed over: the rest may hold the time.
        let exif = found.or_else(|error| error.distill_partial_result(|_| ())).ok()?;
        TAGS.iter().find_map(|(time, fraction)| seconds(&exif, *time, *fraction))
    };
    read().map_or_else(Times::default, |seconds| Times { seconds: vec![seconds], is_absolute: true })
}

fn seconds(exif: &Exif, time: Tag, fraction: Tag) -> Option<f64> {
    let text = |tag: Tag| match exif.get_field(tag, In::PRIMARY) {
        Some(Field { value: Value::Ascii(texts), .. }) => texts.first(),
        _ => None,
    };
    let mut date = DateTime::from_ascii(text(time)?).ok()?;
    if let Some(fraction) = text(fraction) {
        // A fraction that makes no sense leaves the whole second.
        let _ = date.parse_subsec(fraction);
    }
    let DateTime { year, month, day, hour, minute, second, nanosecond, .. } = date;
    let whole = seconds_of(&format!("{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}"))?;
    Some(whole + f64::from(nanosecond.unwrap_or(0)) * 1e-9)
}
