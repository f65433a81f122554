//! Tests of `export::film`.
#![allow(unused_imports)]

use burstscope_core::error::*;
use burstscope_core::export::film::*;
use burstscope_core::export::*;
use burstscope_core::files::mark::*;
use burstscope_core::files::*;
use burstscope_core::monitor::*;
use image::Rgba;
use image::RgbaImage;
use std::io::{self, Write};
use std::path::Path;

fn encoded(pictures: Vec<RgbaImage>, monitor: &Monitor) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    encode_film(&mut bytes, (pictures.len(), pictures.into_iter().map(Ok)), 10, monitor).map(|()| bytes)
}

fn pictures() -> Vec<RgbaImage> {
    (0..3u8).map(|t| RgbaImage::from_fn(20, 10, |x, _| Rgba([80 * t, (12 * x) as u8, 9, 255]))).collect()
}

#[test]
fn films_come_back_picture_by_picture() {
    let bytes = encoded(pictures(), &Monitor::default()).expect("encoded");
    let mut options = gif::DecodeOptions::new();
    options.set_color_output(gif::ColorOutput::RGBA);
    let mut decoder = options.read_info(&bytes[..]).expect("a GIF");
    for truth in pictures() {
        let frame = decoder.read_next_frame().expect("read").expect("a picture");
        assert_eq!(frame.delay, 10);
        let off = frame.buffer.iter().zip(truth.as_raw()).map(|(a, b)| a.abs_diff(*b)).max();
        assert!(off.is_some_and(|off| off <= 4), "{off:?}");
    }
    assert!(decoder.read_next_frame().expect("read").is_none());
    let estimate = estimated_film_bytes([&pictures()[0], &pictures()[1]], 3) as f64;
    assert!((0.4..3.0).contains(&(estimate / bytes.len() as f64)));
}
