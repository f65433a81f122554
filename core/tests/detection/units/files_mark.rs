//! Tests of `files::mark`.
#![allow(unused_imports)]

use burstscope_core::files::mark::*;
use burstscope_core::files::*;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom, Write};
use std::path::Path;
use tiff::decoder::Decoder;
use tiff::tags::Tag;

#[test]
fn a_folder_is_ours_as_long_as_nobody_changes_it() {
    let home = tempfile::tempdir().expect("a folder");
    let at = |name: &str| home.path().join(name);
    std::fs::create_dir(at("deep")).expect("made");
    for name in ["a.png", "deep/b.png"] {
        std::fs::write(at(name), name).expect("written");
    }
    let is_ours = |kind| is_unchanged(home.path(), kind).expect("it can be read");
    assert!(!is_ours(Kind::Burst), "it has no mark");
    seal_folder(home.path(), Kind::Burst).expect("marked");
    assert!(is_ours(Kind::Burst) && !is_ours(Kind::Trajectory) && has_mark(&at(Kind::Burst.file()), true));
    for (name, content) in [("a.png", "A.png"), ("deep/c.png", ""), ("notes.txt", "mine")] {
        let before = std::fs::read(at(name)).ok();
        std::fs::write(at(name), content).expect("written");
        assert!(!is_ours(Kind::Burst), "{name}");
        let undone = before.map_or_else(|| std::fs::remove_file(at(name)), |text| std::fs::write(at(name), text));
        undone.expect("as it was");
    }
    std::fs::create_dir(at("empty")).expect("made");
    assert!(!is_ours(Kind::Burst));
    std::fs::remove_dir(at("empty")).expect("removed");
    std::fs::remove_file(at("a.png")).expect("removed");
    assert!(is_ours(Kind::Burst), "what is gone is lost to nobody");
    let mark = std::fs::read_to_string(at(Kind::Burst.file())).expect("there");
    for wrong in [mark.replace("b.png", "a.png"), mark.replace("burstscope", "another"), "{}".into(), "".into()] {
        std::fs::write(at(Kind::Burst.file()), wrong).expect("written");
        assert!(!is_ours(Kind::Burst) && !has_mark(&at(Kind::Burst.file()), false));
    }
}

#[test]
fn claims_come_back_with_all_their_digits_or_not_at_all() {
    let home = tempfile::tempdir().expect("a folder");
    // Numbers whose last digit a reader of JSON may lose.
    let numbers: Vec<f64> = (1..200).map(|n| (n as f64).sqrt() * 1e-7).collect();
    std::fs::write(home.path().join(Kind::Dataset.file()), claiming(Kind::Dataset, &numbers)).expect("written");
    let read: Vec<f64> = claims(home.path(), Kind::Dataset).expect("whole");
    assert!(read.iter().zip(&numbers).all(|(a, b)| (a - b).abs() < 1e-20) && read.len() == numbers.len());
    assert_eq!(claims::<Vec<f64>>(home.path(), Kind::Figures), None);
    assert_eq!(claims::<String>(home.path(), Kind::Dataset), None);
}
