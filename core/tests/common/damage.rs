//! Random damage, for the tests of all readers of files that somebody else may have written.
#![allow(dead_code)] // Each test program uses a part of it.

use proptest::{prelude::*, sample::Index};

/// Bytes inserted where they do not belong: numbers at the ends of their ranges, signatures of the formats, bytes that
/// are no text.
#[rustfmt::skip]
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

#[derive(Debug, Clone)]
pub enum Damage {
    Flip(Index, u8),
    Set(Index, u8),
    Insert(Index, usize),
    Remove(Index, usize),
    Repeat(Index, usize),
    Cut(Index),
}

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

pub fn damaged_text(sound: &str, damages: &[Damage]) -> String {
    String::from_utf8_lossy(&damaged(sound.as_bytes(), damages)).into_owned()
}

pub fn says_something(error: &dyn std::fmt::Display) -> bool {
    !error.to_string().trim().is_empty()
}

/// Each number of a TOML file replaced by each of the numbers that are absurd in its place: the number's path, the text
/// of the file, and the value.
pub fn absurd_tomls(text: &str) -> Vec<(String, String, String)> {
    let whole: toml::Value = toml::from_str(text).expect("TOML");
    let mut found = Vec::new();
    for (path, number) in numbers(&whole) {
        for absurd in absurd(&number) {
            let mut changed = whole.clone();
            *at(&mut changed, &path) = absurd.clone();
            found.push((path.join("."), toml::to_string(&changed).expect("plain values"), absurd.to_string()));
        }
    }
    found
}

/// Numbers that are absurd in the place of `number`, of its type.
pub fn absurd(number: &toml::Value) -> Vec<toml::Value> {
    if number.is_float() {
        [1e9, -1e9, 0.0, 1e300, f64::NAN, f64::INFINITY].map(toml::Value::Float).to_vec()
    } else {
        [1_000_000_000, -1_000_000_000, 0, i64::MAX].map(toml::Value::Integer).to_vec()
    }
}

pub fn numbers(value: &toml::Value) -> Vec<(Vec<String>, toml::Value)> {
    let below = |key: String, value: &toml::Value| {
        let prefixed = move |(path, number): (Vec<String>, _)| ([vec![key.clone()], path].concat(), number);
        numbers(value).into_iter().map(prefixed).collect::<Vec<_>>()
    };
    match value {
        toml::Value::Table(table) => table.iter().flat_map(|(key, value)| below(key.clone(), value)).collect(),
        toml::Value::Array(all) => all.iter().enumerate().flat_map(|(i, value)| below(i.to_string(), value)).collect(),
        toml::Value::Integer(_) | toml::Value::Float(_) => vec![(Vec::new(), value.clone())],
        _ => Vec::new(),
    }
}

/// The value at a path that [`numbers`] gave.
pub fn at<'a>(value: &'a mut toml::Value, path: &[String]) -> &'a mut toml::Value {
    path.iter().fold(value, |value, key| match value {
        toml::Value::Table(table) => table.get_mut(key).expect("a key"),
        toml::Value::Array(all) => &mut all[key.parse::<usize>().expect("an index")],
        _ => panic!("{path:?} leads nowhere"),
    })
}
