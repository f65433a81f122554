//! Tests of `dataset::kept`.
#![allow(unused_imports)]

use burstscope_core::dataset::*;
use burstscope_core::error::*;
use burstscope_core::export::*;
use burstscope_core::files::*;
use burstscope_core::files::mark::*;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::io::Write;
use std::path::Path;
use burstscope_core::detector::REVISION;
use serde_json::{Value, json};

/// A folder with a manifest, changed by `change`.
fn begun(change: impl FnOnce(&mut Value)) -> tempfile::TempDir {
    let home = tempfile::tempdir().expect("a folder");
    let manifest = MadeFrom::new(json!({ DETECTOR_KEY: "levels = 4" }));
    let mut value = serde_json::to_value(&manifest).expect("plain values");
    change(&mut value);
    std::fs::write(home.path().join(Kind::Dataset.file()), claiming(Kind::Dataset, &value)).expect("written");
    home
}

#[test]
fn the_parameters_of_a_folder_are_those_that_this_program_would_find_again() {
    assert_eq!(detector_text(begun(|_| ()).path()).as_deref(), Some("levels = 4"));
    let changes: [fn(&mut Value); 5] = [
        |manifest| manifest["detector_revision"] = json!(REVISION + 1),
        |manifest| manifest["detector_revision"] = Value::Null,
        |manifest| drop(manifest.as_object_mut().expect("an object").remove("detector_revision")),
        |manifest| manifest["version"] = json!("0.0.1"),
        |manifest| *manifest = json!([1, 2]),
    ];
    for change in changes {
        assert_eq!(detector_text(begun(change).path()), None);
    }
}

#[test]
fn what_differs_is_named_as_it_is_asked_for() {
    let ours = MadeFrom::new(json!({ DETECTOR_KEY: "levels = 4\nedge_threshold = 10\n", "bias": [] }));
    let other = |change: fn(&mut Value)| {
        let mut value = serde_json::to_value(&ours).expect("plain values");
        change(&mut value["settings"]);
        differences(&serde_json::from_value(value).expect("a manifest"), &ours)
    };
    assert_eq!(other(|_| ()), Vec::<String>::new());
    assert_eq!(other(|s| s[DETECTOR_KEY] = json!("levels = 4\nedge_threshold = 5\n")), ["edge-threshold"]);
    assert_eq!(other(|s| s["black_level"] = json!(3)), ["black-level"]);
    assert_eq!(other(|s| s[DETECTOR_KEY] = json!(3)), ["detector"]);
    assert_eq!(other(|s| *s = json!(null)), ["bias", "detector"]);
}

