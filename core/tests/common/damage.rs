//! Random damage, for the tests of all readers of files that somebody else may have written.
#![allow(dead_code)] // Each test program uses a part of it.

use proptest::prelude::*;
use proptest::sample::Index;

/// Bytes inserted where they do not belong: numbers at the ends of their ranges, signatures of the formats, bytes that
/// are no text.
const JUNK: [&[u8]; 30] = [
    b"0",
    b"-1",
    b"1e400",
    b"nan",
    b"inf",
    b"-",
    b".",
    b",",
    b" ",
    b"\n",
    b"\t",
    b"\"",
    b"'",
    b"=",
    b"[",
    b"]",
    b"{",
    b"}",
    b"#",
    b"\\",
    b"\0",
    b"\xff",
    b"\xc3",
    b"e",
    b"null",
    b"true",
    b"18446744073709551616",
    b"1e-400",
    b"[[",
    b"\"\"\"",
];

/// One damage.
#[derive(Debug, Clone)]
pub enum Damage {
    Flip(Index, u8),
    Set(Index, u8),
    Insert(Index, usize),
    Remove(Index, usize),
    Repeat(Index, usize),
    Cut(Index),
}

/// A list of a few damages.
pub fn damage() -> impl Strategy<Value = Vec<Damage>> {
    let at = any::<Index>;
    let one = prop_oneof![
        (at(), 0..8u8).prop_map(|(at, bit)| Damage::Flip(at, bit)),
        (at(), any::<u8>()).prop_map(|(at, byte)| Damage::Set(at, byte)),
        (at(), 0..JUNK.len()).prop_map(|(at, junk)| Damage::Insert(at, junk)),
        (at(), 1..40usize).prop_map(|(at, count)| Damage::Remove(at, count)),
        (at(), 1..200usize).prop_map(|(at, count)| Damage::Repeat(at, count)),
        at().prop_map(Damage::Cut),
    ];
    prop::collection::vec(one, 1..5)
}

/// `sound` after these damages, one after the other.
pub fn damaged(sound: &[u8], damages: &[Damage]) -> Vec<u8> {
    let mut bytes = sound.to_vec();
    for damage in damages {
        if bytes.is_empty() {
            break;
        }
        let end = |at: usize, count: usize| (at + count).min(bytes.len());
        match *damage {
            Damage::Flip(at, bit) => {
                let at = at.index(bytes.len());
                bytes[at] ^= 1 << bit;
            }
            Damage::Set(at, byte) => {
                let at = at.index(bytes.len());
                bytes[at] = byte;
            }
            Damage::Insert(at, junk) => {
                let at = at.index(bytes.len() + 1);
                bytes.splice(at..at, JUNK[junk].iter().copied());
            }
            Damage::Remove(at, count) => {
                let at = at.index(bytes.len());
                bytes.drain(at..end(at, count));
            }
            Damage::Repeat(at, count) => {
                let at = at.index(bytes.len());
                let part = bytes[at..end(at, count)].to_vec();
                bytes.splice(at..at, part);
            }
            Damage::Cut(at) => bytes.truncate(at.index(bytes.len())),
        }
    }
    bytes
}

/// `sound` after these damages as text; invalid UTF-8 is replaced.
pub fn damaged_text(sound: &str, damages: &[Damage]) -> String {
    String::from_utf8_lossy(&damaged(sound.as_bytes(), damages)).into_owned()
}

/// Whether an error's message is not blank.
pub fn says_something(error: &dyn std::fmt::Display) -> bool {
    !error.to_string().trim().is_empty()
}
