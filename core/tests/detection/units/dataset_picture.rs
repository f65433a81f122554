//! Tests of `dataset::picture`.
#![allow(unused_imports)]

use burstscope_core::burst::*;
use burstscope_core::dataset::*;
use burstscope_core::detect::*;
use burstscope_core::detector::*;
use burstscope_core::error::*;
use burstscope_core::export::*;
use burstscope_core::monitor::*;
use burstscope_core::plane::display::*;
use burstscope_core::plane::*;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

#[test]
fn the_middle_frame_is_shown_and_a_broken_one_named() {
    let home = tempfile::tempdir().expect("a folder");
    for t in 0..3u8 {
        let frame = image::GrayImage::from_fn(8, 4, |u, _| image::Luma([if t == 1 && u > 3 { 40 } else { 10 }]));
        frame.save(home.path().join(format!("{t}.png"))).expect("written");
    }
    let source = BurstFiles { name: "b".into(), paths: vec![home.path().into()] };
    // A frame minus itself as the bias frame is empty.
    let options = OpenOptions { bias: Some(home.path().join("1.png")), ..OpenOptions::default() };
    let made = |options: &OpenOptions| thumbnail(&source, 4, options, &Monitor::default());
    let dark = made(&options).expect("a picture");
    assert!(dark.rgb.iter().all(|value| *value == dark.rgb[0]));
    let shown = made(&OpenOptions::default()).expect("a picture");
    assert_eq!((shown.size, shown.rgb.len()), ((4, 2), 24));
    assert_eq!((shown.rgb[0], shown.rgb[9]), (0, 255), "a dark frame is stretched");
    std::fs::write(home.path().join("1.png"), "no picture").expect("written");
    let error = made(&OpenOptions::default()).expect_err("broken").to_string();
    assert!(error.contains("1.png"), "{error}");
}
