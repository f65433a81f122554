//! Tests of `dataset::blobs`.
#![allow(unused_imports)]

use burstscope_core::dataset::*;
use burstscope_core::detector::*;
use burstscope_core::matching::*;
use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::fmt::Write;
use proptest::prelude::*;

#[test]
fn blobs_survive_a_file_and_altered_ones_are_refused() {
    let (slope, motion) = (Slope::new(2.0, 0.5), Slope::new(-1.5, 0.25));
    let blob = |sigma, motion_sigma| Blob { sigma, orientation: 1.0, slope, motion, motion_sigma };
    let blobs = StoredBlobs(vec![blob(2.5, 0.1), blob(7.0, f32::INFINITY)]);
    let json = serde_json::to_string(&blobs).expect("plain text");
    assert_eq!(serde_json::from_str::<StoredBlobs>(&json).ok(), Some(blobs.clone()));
    assert_eq!(StoredBlobs::from_text(&StoredBlobs(Vec::new()).text()), Some(StoredBlobs(Vec::new())));
    let text = blobs.text();
    for wrong in [&text[1..], &text[..text.len() - 2], &text.replace('c', "d"), "", "xy", "é"] {
        assert_eq!(StoredBlobs::from_text(wrong), None, "{wrong}");
    }
    for wrong in [blob(f32::NAN, 0.1), blob(1.0, -0.1)] {
        assert_eq!(StoredBlobs::from_text(&StoredBlobs(vec![wrong]).text()), None);
    }
}

proptest! {
    #[test]
    fn no_text_panics(text in ".{0,80}", digits in "[0-9a-f]{0,80}") {
        for text in [text, digits] {
            prop_assert!(StoredBlobs::from_text(&text).is_none_or(|blobs| blobs.text() == text.to_lowercase()));
        }
    }
}

