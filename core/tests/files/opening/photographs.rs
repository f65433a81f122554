//! Photographs: gamma-encoded, rotated, in tiles; films, which are refused; and bursts of real cameras, where they are
//! available.

use super::support::*;
use image::{ExtendedColorType, ImageEncoder, RgbImage};

fn linearised(path: &Path) -> Burst {
    let options = OpenOptions { linearise: true, ..OpenOptions::default() };
    Burst::open_with(&[path.into()], &options, &quiet()).expect("opens")
}

#[test]
fn colour_of_8_bit_is_said_to_be_encoded_and_is_undone_when_asked() {
    let folder = folder();
    let at = |name: &str| folder.join(name);
    let colour = RgbImage::from_fn(4, 2, |u, _| if u < 2 { Rgb([188, 188, 188]) } else { Rgb([188, 0, 0]) });
    save(&at("colour.png"), &colour);
    save(&at("grey.png"), &image::GrayImage::from_pixel(4, 2, Luma([188])));
    save(&at("wide.png"), &image::ImageBuffer::<Rgb<u16>, _>::from_pixel(4, 2, Rgb([188 * 257; 3])));
    colour.save(at("colour.tif")).expect("written");
    image::GrayImage::from_pixel(8, 8, Luma([188])).save(at("grey.jpg")).expect("written");
    for (name, encoding) in [
        ("colour.png", Encoding::Srgb),
        ("colour.tif", Encoding::Srgb),
        ("grey.jpg", Encoding::Srgb),
        ("grey.png", Encoding::Linear),
        ("wide.png", Encoding::Linear),
    ] {
        let burst = Burst::open(at(name)).expect(name);
        assert_eq!(burst.encoding, encoding, "{name}");
        assert_eq!(
            burst.notes().iter().any(|note| note.option == Some("linearise")),
            encoding == Encoding::Srgb,
            "{name}"
        );
        assert!((burst.frames[0].at(0, 0) - 188.0 / 255.0).abs() < 1e-6, "{name}: as stored");
        let undone = linearised(&at(name));
        assert_eq!(undone.encoding, Encoding::Linear);
        // IEC 61966-2-1: ((188/255 + 0.055)/1.055)^2.4.
        assert!((undone.frames[0].at(0, 0) - 0.50289).abs() < 1e-4, "{name}: {}", undone.frames[0].at(0, 0));
    }
    save(&at("ends.png"), &RgbImage::from_fn(3, 1, |u, _| Rgb([[0, 10, 255][u as usize]; 3])));
    let ends = linearised(&at("ends.png"));
    assert_eq!((ends.frames[0].at(0, 0), ends.frames[0].at(2, 0)), (0.0, 1.0));
    assert!((ends.frames[0].at(1, 0) - 10.0 / 255.0 / 12.92).abs() < 1e-7);
    // Colours are weighted as light, not as encoded values.
    assert_close(&[linearised(&at("colour.png")).frames[0].at(3, 1)], &[0.2126 * 0.502_886]);
}

fn exif(orientation: u16) -> Vec<u8> {
    let mut bytes = b"MM\0*\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01".to_vec();
    bytes.extend(orientation.to_be_bytes());
    bytes.extend([0, 0, 0, 0, 0, 0]);
    bytes
}

#[test]
fn pictures_are_turned_as_the_camera_was_held() {
    let folder = folder();
    // The brightest pixel is in the top right corner.
    let pixels: Vec<u8> = vec![10, 20, 200, 30, 40, 50];
    // For each orientation of EXIF: the size, and the position of the bright pixel.
    for (orientation, size, (u, v)) in [
        (1, (3, 2), (2, 0)),
        (2, (3, 2), (0, 0)),
        (3, (3, 2), (0, 1)),
        (4, (3, 2), (2, 1)),
        (5, (2, 3), (0, 2)),
        (6, (2, 3), (1, 2)),
        (7, (2, 3), (1, 0)),
        (8, (2, 3), (0, 0)),
    ] {
        let png = folder.join(format!("{orientation}.png"));
        let mut encoder = image::codecs::png::PngEncoder::new(fs::File::create(&png).expect("created"));
        encoder.set_exif_metadata(exif(orientation)).expect("PNG has a place for it");
        encoder.write_image(&pixels, 3, 2, ExtendedColorType::L8).expect("written");
        let tiff = folder.join(format!("{orientation}.tif"));
        let bytes = super::support::raw_tiff(false, (3, 2), &[8], &[(262, 1), (274, orientation)], &[&pixels]);
        fs::write(&tiff, bytes).expect("written");
        for path in [png, tiff] {
            let burst = Burst::open(&path).expect("opens");
            assert_eq!(burst.size(), size, "{}", path.display());
            assert_eq!((burst.frames[0].at(u, v) * 255.0).round(), 200.0, "{}", path.display());
        }
    }
    // Frames of the same orientation are one burst; upright and rotated ones have different sizes.
    let at = |n: u16| folder.join(format!("{n}.png"));
    assert_eq!(open(&[at(6), at(8)]).expect("a burst").size(), (2, 3));
    assert!(open(&[at(1), at(6)]).expect_err("turned").problem.contains("have one size"));
}

/// A TIFF of `size` in planes of red, green and blue, each in tiles of 16×16, with `sample(plane, u, v)` as values.
fn tiled_planar(size: (usize, usize), sample: impl Fn(usize, usize, usize) -> u8) -> Vec<u8> {
    const SIDE: usize = 16;
    let (across, down) = (size.0.div_ceil(SIDE), size.1.div_ceil(SIDE));
    let mut bytes = b"II*\0\0\0\0\0".to_vec();
    let mut offsets: Vec<u8> = Vec::new();
    let mut counts: Vec<u8> = Vec::new();
    for plane in 0..3 {
        for tile in 0..across * down {
            let (left, top) = (tile % across * SIDE, tile / across * SIDE);
            offsets.extend((bytes.len() as u32).to_le_bytes());
            counts.extend(((SIDE * SIDE) as u32).to_le_bytes());
            for v in top..top + SIDE {
                // Pixels outside the picture have arbitrary values.
                bytes.extend(
                    (left..left + SIDE).map(|u| if u < size.0 && v < size.1 { sample(plane, u, v) } else { 99 }),
                );
            }
        }
    }
    let tiles = (3 * across * down) as u32;
    let mut place = |data: &[u8]| {
        let at = bytes.len() as u32;
        bytes.extend(data);
        at
    };
    let (bits, offsets, counts) = (place(&[8, 0, 8, 0, 8, 0]), place(&offsets), place(&counts));
    const SHORT: u16 = 3;
    const LONG: u16 = 4;
    let entries = [
        (256u16, SHORT, 1u32, size.0 as u32),
        (257, SHORT, 1, size.1 as u32),
        (258, SHORT, 3, bits),
        (259, SHORT, 1, 1),
        (262, SHORT, 1, 2),
        (277, SHORT, 1, 3),
        (284, SHORT, 1, 2),
        (322, SHORT, 1, SIDE as u32),
        (323, SHORT, 1, SIDE as u32),
        (324, LONG, tiles, offsets),
        (325, LONG, tiles, counts),
    ];
    let directory = (bytes.len() as u32).to_le_bytes();
    bytes[4..8].copy_from_slice(&directory);
    bytes.extend(super::crafted::entries(&entries));
    bytes
}

#[test]
fn planes_in_tiles_open_at_any_size() {
    let (_folder, path) = folder_with("tiled.tif");
    for size in [(16, 16), (32, 16), (21, 37), (5, 3), (33, 16)] {
        // Grey, so that luma is the value itself.
        fs::write(&path, tiled_planar(size, |_, u, v| (7 * v + 3 * u) as u8)).expect("written");
        let burst = Burst::open(&path).unwrap_or_else(|e| panic!("{size:?}: {e}"));
        assert_eq!(burst.size(), size);
        for v in 0..size.1 {
            for u in 0..size.0 {
                assert_eq!(
                    (burst.frames[0].at(u, v) * 255.0).round(),
                    f32::from((7 * v + 3 * u) as u8),
                    "({u}, {v}) of {size:?}"
                );
            }
        }
        fs::write(&path, tiled_planar(size, |plane, _, _| if plane == 1 { 255 } else { 0 })).expect("written");
        assert!(Burst::open(&path).expect("opens").frames[0].data().iter().all(|v| (v - 0.7152).abs() < 1e-5));
    }
}

#[test]
fn a_film_that_is_none_is_refused_and_ffmpeg_is_named() {
    let folder = folder();
    for (name, start) in [
        ("it's.mp4", b"\0\0\0\x18ftypisom\0\0\x02\0isomiso2".as_slice()),
        ("b.mov", b"\0\0\0\x14ftypqt  \0\0\0\0qt  "),
        ("c.mkv", b"\x1a\x45\xdf\xa3\x9f\x42\x86\x81\x01\x42"),
        ("d.avi", b"RIFF\x24\0\0\0AVI LIST\0\0\0\0"),
        ("e.gif", b"GIF89a\x01\0\x01\0\0\0\0"),
        ("f.mpg", b"\0\0\x01\xba\x44\0\x04\0"),
    ] {
        let path = folder.join(name);
        fs::write(&path, start).expect("written");
        let error = open(&[path]).expect_err(name);
        // What ffmpeg says about it, or that there is no ffmpeg.
        says(error, &["film", "ffmpeg"]);
    }
    // A still picture in the same container is no film, but cannot be opened either.
    let heic = folder.join("g.heic");
    fs::write(&heic, b"\0\0\0\x18ftypheic\0\0\0\0mif1heic").expect("written");
    assert!(open(&[heic]).expect_err("of another kind").problem.contains("not a picture of a kind"));
    assert!(
        find_bursts(&[folder.join("e.gif")], &OpenOptions::default()).is_ok(),
        "what it is, is told when it is opened"
    );
}

#[needs::shared("data")]
#[test]
fn real_bursts_open() {
    let data = shared("data");
    for (name, frames, size) in [
        ("buff-demo-1d", 5, (800, 640)),
        ("buff-demo-2d", 5, (200, 200)),
        ("slider-far", 60, (240, 180)),
        ("visp-cube", 40, (384, 288)),
        ("light-field-shop", 27, (960, 640)),
    ] {
        let burst = Burst::open(data.join(name)).expect(name);
        assert_eq!((burst.name.as_str(), burst.len(), burst.size(), burst.full_scale), (name, frames, size, 255.0));
        let values = burst.frames.iter().flat_map(|f| f.data());
        let (min, max) = values.fold((1.0f32, 0.0f32), |(a, b), &v| (a.min(v), b.max(v)));
        assert!(min >= 0.0 && max <= 1.0 && max - min > 0.05, "{name}: {min} … {max}");
    }
    let burst = Burst::open(data.join("slider-far")).expect("opens");
    assert_eq!(burst.frame_names[0], "frame_00000008.png");
    assert_eq!(burst.frame_names[59], "frame_00000067.png");
    // Four channels, all grey: the values equal those of the file.
    let discs = Burst::open(data.join("buff-demo-2d")).expect("opens");
    assert!(discs.frames[0].data().iter().all(|v| (v * 255.0).round() / 255.0 == *v));
}

#[needs::shared("data")]
#[test]
fn the_data_folder_is_a_dataset() {
    let data = shared("data");
    let names: Vec<String> =
        find_bursts(&[data], &OpenOptions::default()).expect("bursts").into_iter().map(|s| s.name).collect();
    let raw = cfg!(feature = "raw").then_some("raw");
    let expected: Vec<&str> = ["buff-demo-1d", "buff-demo-2d", "light-field-shop"]
        .into_iter()
        .chain(raw)
        .chain(["slider-far", "visp-cube"])
        .collect();
    assert_eq!(names, expected);
}

#[needs::shared("data")]
#[test]
fn sensor_raw_files_open_or_are_refused_with_a_reason() {
    let data = shared("data");
    let opened = Burst::open(data.join("raw/colorchart.dng"));
    if cfg!(feature = "raw") {
        let chart = opened.expect("a camera's own DNG");
        let (width, height) = chart.size();
        assert!(chart.binning == 2 && width > 500 && height > 500, "{width}×{height}");
        let values = chart.frames[0].data();
        let mean = values.iter().sum::<f32>() / values.len() as f32;
        println!("{width}×{height}, white {}, mean {mean}", chart.full_scale);
        assert!((0.01..0.9).contains(&mean) && values.iter().all(|v| (-0.1..1.3).contains(v)), "mean {mean}");
    } else {
        let error = opened.expect_err("nothing reads it");
        assert!(error.kind == ErrorKind::Unsupported && error.to_string().contains("raw"), "{error}");
    }
    let error = Burst::open(data.join("raw/openisp_test_1920x1080.raw")).expect_err("no header");
    assert!(error.remedy.contains("1920x1080:u16le (one frame)"), "{error}");
}
