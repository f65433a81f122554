//! Files of plain numbers: without header, `.npz`, shapes of arrays, FITS, SER, Y4M, films, and the axes of TIFFs. The
//! files in `samples/` were written by tifffile, numpy, astropy, serfilesreader and ffmpeg; their value number i is
//! 7·i + 3 unless a test says another, and the expected values are those that the same tools read.

use super::{crafted, support::*};
use std::io::Read;

/// Bytes of a file of another program; one that is stored compressed is unpacked.
macro_rules! sample {
    ($name:literal) => {
        include_bytes!(concat!("samples/", $name)).as_slice()
    };
    ($name:literal, gz) => {
        &unpacked(include_bytes!(concat!("samples/", $name, ".gz")))
    };
}

pub(super) fn unpacked(bytes: &[u8]) -> Vec<u8> {
    let mut whole = Vec::new();
    flate2::read::GzDecoder::new(bytes).read_to_end(&mut whole).expect("unpacked");
    whole
}

pub fn samples() -> Vec<(&'static str, Vec<u8>)> {
    let mut samples = vec![
        ("mono12.ser", sample!("mono12.ser").to_vec()),
        ("grey16.y4m", sample!("grey16.y4m").to_vec()),
        ("c420.y4m", sample!("c420.y4m").to_vec()),
        ("two.npz", sample!("two.npz").to_vec()),
        ("stored.npz", sample!("stored.npz").to_vec()),
        ("cube_u16.fits", sample!("cube_u16.fits", gz).to_vec()),
        ("extensions.fits", sample!("extensions.fits", gz).to_vec()),
        ("scaled.fits", sample!("scaled.fits", gz).to_vec()),
        ("dump.raw", (0..24).collect()),
    ];
    // Each compressed image by itself.
    let tiles = unpacked(include_bytes!("samples/tiles.fits.gz"));
    let starts: Vec<_> = (0..tiles.len()).step_by(2880).filter(|at| tiles[*at..].starts_with(b"XTENSION")).collect();
    let files = TILES.iter().zip(starts.windows(2));
    samples.extend(files.map(|((_, name), unit)| (*name, [&tiles[..2880], &tiles[unit[0]..unit[1]]].concat())));
    samples
}

/// Compressed images of a sample, and names for files of one of them.
const TILES: [(&str, &str); 10] = [
    ("U8", "gzip.fits"),
    ("I16", "square.fits"),
    ("U16", "rice.fits"),
    ("I32", "layers.fits"),
    ("MASK", "plio.fits"),
    ("H16", "smooth.fits"),
    ("F32", "dithered.fits"),
    ("D32", "hcompress.fits"),
    ("F64", "double.fits"),
    ("WIDE", "whole.fits"),
];

impl Made {
    /// The message of its failure, which names the file.
    fn failure(&self, options: &OpenOptions) -> String {
        let message = self.open(options).expect_err("refused").to_string();
        assert!(message.contains(self.path.file_name().expect("a name").to_str().expect("text")), "{message}");
        message
    }
}

fn plain() -> OpenOptions {
    OpenOptions::default()
}

fn raw(shape: &str) -> OpenOptions {
    OpenOptions { raw: Some(shape.parse().expect("a shape")), ..plain() }
}

fn axis(axis: &str) -> OpenOptions {
    OpenOptions { axis: Some(axis.parse().expect("an axis")), ..plain() }
}

/// Three pictures of a FITS image may be colours.
fn frames_of(name: &str) -> OpenOptions {
    OpenOptions { axis: axis("last").axis, ..array(name) }
}

fn array(name: &str) -> OpenOptions {
    OpenOptions { array: Some(name.to_owned()), ..plain() }
}

fn values(burst: &Burst) -> Vec<f32> {
    burst.frames.iter().flat_map(|frame| frame.data().iter().map(|v| v * burst.full_scale)).collect()
}

fn numbered(range: std::ops::Range<usize>) -> Vec<f32> {
    range.map(|i| (7 * i + 3) as f32).collect()
}

#[test]
fn files_without_header_have_the_shape_that_is_said() {
    let words: Vec<u16> = (0..12).map(|i| 1000 * i + 7).collect();
    let expected: Vec<f32> = words.iter().map(|v| f32::from(*v)).collect();
    let little = Made::new("a.raw", &words.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<_>>());
    let burst = little.open(&raw("3x2:u16le")).expect("two frames");
    assert_eq!((burst.len(), burst.size(), burst.full_scale), (2, (3, 2), 65535.0));
    assert_close(&values(&burst), &expected);
    assert_eq!(little.open(&raw("4x3:u16le")).expect("one frame").len(), 1);
    let behind =
        Made::new("b.bin", &[&[9; 5][..], &words.iter().flat_map(|v| v.to_be_bytes()).collect::<Vec<_>>()].concat());
    assert_close(&values(&behind.open(&raw("3x2:u16be+5")).expect("skipped")), &expected);
    let floats = Made::new("c.dat", &[0.25f32, 0.5, 1.0, 0.0].iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<_>>());
    assert_eq!(floats.open(&raw("2x2:f32")).expect("opens").frames[0].data(), [0.25, 0.5, 1.0, 0.0]);
    // Any name, as many programs give none.
    let nameless = Made::new("dump", &[1, 2, 3, 4, 5, 6]);
    assert_close(&values(&nameless.open(&raw("3x1:u8")).expect("opens")), &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    // The standards' 12 bits of 0xabc and 0x123; 10 bits of 0x2ab, 0x1cd, 0x001 and 0x3ff; an odd number of pixels.
    let four = (0x2ab | 0x1cd << 10 | 0x001u64 << 20 | 0x3ff << 30).to_le_bytes();
    for (shape, bytes, white, expected) in [
        ("2x1:mono12p", &[0xbc, 0x3a, 0x12, 0xbc, 0x3a, 0x12][..], 4095.0, &[2748.0, 291.0, 2748.0, 291.0][..]),
        ("3x1:mono12p", &[0xbc, 0x3a, 0x12, 0xbc, 0x0a], 4095.0, &[2748.0, 291.0, 2748.0]),
        ("2x1:mono12packed", &[0xab, 0x3c, 0x12], 4095.0, &[2748.0, 291.0]),
        ("2x1:mono10packed", &[0xaa, 0x13, 0x73], 1023.0, &[683.0, 461.0]),
        ("4x1:mono10p", &four[..5], 1023.0, &[683.0, 461.0, 1.0, 1023.0]),
    ] {
        let burst = Made::new("p.raw", bytes).open(&raw(shape)).expect(shape);
        assert_eq!((burst.len(), burst.full_scale), (expected.len() / burst.size().0, white), "{shape}");
        assert_close(&values(&burst), expected);
    }
    // A file that begins like a picture by chance.
    assert_eq!(Made::new("chance.raw", b"BM\x89PNG\r\n\x1a\n\0\0").open(&raw("4x3:u8")).expect("opens").len(), 1);
}

#[test]
fn files_without_header_are_refused_with_what_reads_them_and_folders_of_them_are_frames() {
    let file = Made::new("night.raw", &vec![0; 640 * 480 * 2 * 3]);
    says(file.failure(&plain()), &["--raw", "640x480:u16le (3 frames)"]);
    says(file.failure(&raw("641x480:u16le")), &["no whole number of frames of 641x480:u16le"]);
    assert!(Made::new("odd.bin", &[0; 7]).failure(&plain()).contains("no usual size fills its 7 bytes"));
    assert!(file.failure(&raw("640x480:u16le+99999999")).contains("0 bytes"));
    for (name, start, way) in [
        ("a.h5", b"\x89HDF\r\n\x1a\n\0\0".as_slice(), "h5py"),
        ("a.mat", b"MATLAB 5.0 MAT-file, Platform", "scipy.io"),
        ("a.fits.gz", b"\x1f\x8b\x08\0", "gunzip"),
    ] {
        says(Made::new(name, start).failure(&plain()), &[way]);
    }
    let home = folder();
    (0..3u8).for_each(|t| fs::write(home.join(format!("f{t}.raw")), [t; 12]).expect("written"));
    let paths = [home.to_path_buf()];
    let burst = Burst::open_with(&paths, &raw("4x3:u8"), &quiet()).expect("three frames");
    assert_eq!((burst.len(), burst.frame_names[2].as_str()), (3, "f2.raw"));
    assert_eq!(find_bursts(&paths, &raw("2x3:u8")).expect("bursts").len(), 3, "each holds two frames");
    // In a dataset, files of which nobody says that they are frames are no burst; nor is what lies beside its folders.
    let parent = folder();
    fs::create_dir(parent.join("logs")).expect("made");
    fs::create_dir(parent.join("night")).expect("made");
    fs::write(parent.join("logs/run.dat"), [0; 12]).expect("written");
    fs::write(parent.join("points.npz"), sample!("two.npz")).expect("written");
    save(&parent.join("night/p.png"), &grey8(4, 3, 0));
    let names = |options: &OpenOptions| -> Vec<String> {
        let found = find_bursts(&[parent.to_path_buf()], options).expect("bursts");
        found.into_iter().map(|burst| burst.name).collect()
    };
    assert_eq!((names(&plain()), names(&raw("4x3:u8"))), (vec!["night".into()], vec!["logs".into(), "night".into()]));
    // Beside pictures they are no frames.
    save(&home.join("p.png"), &grey8(4, 3, 0));
    assert_eq!(Burst::open(&home).expect("a picture").frame_names, ["p.png"]);
}

#[test]
fn a_mosaic_is_binned_in_every_kind_of_file() {
    // Green, red, blue, green.
    let square = [40u8, 10, 90, 60];
    let bytes: Vec<u8> = (0..4).flat_map(|v| (0..4).map(move |u| square[2 * (v % 2) + u % 2])).collect();
    let home = folder();
    let image = image::GrayImage::from_raw(4, 4, bytes.clone()).expect("sixteen values");
    ["m.png", "m.tif"].into_iter().for_each(|name| save(&home.join(name), &image));
    fs::write(home.join("m.raw"), &bytes).expect("written");
    let array = Array3::from_shape_vec((1, 4, 4), bytes).expect("sixteen values");
    write_npy(home.join("m.npy"), &array).expect("written");
    for name in ["m.png", "m.tif", "m.raw", "m.npy"] {
        let greens = [(RawColour::Luma, 50.0), (RawColour::Green, 50.0)];
        for (raw_colour, expected) in greens.into_iter().chain([(RawColour::Red, 10.0), (RawColour::Blue, 90.0)]) {
            let options = OpenOptions { mosaic: Some(Mosaic::Grbg), raw_colour, ..raw("4x4:u8") };
            let paths = [home.join(name)];
            let burst = Burst::open_with(&paths, &options, &quiet()).expect(name);
            assert_eq!((burst.size(), burst.binning), ((2, 2), 2), "{name}");
            assert_close(&values(&burst), &[expected; 4]);
            let info = Info::of(&paths, &options, &quiet()).expect(name);
            assert_eq!((info.width, info.height, info.binning), (2, 2, 2), "{name}");
        }
    }
    let colours = home.join("c.png");
    save(&colours, &image::RgbImage::from_pixel(4, 4, image::Rgb([1, 2, 3])));
    let options = OpenOptions { mosaic: Some(Mosaic::Rggb), ..plain() };
    let error = Burst::open_with(&[colours], &options, &quiet()).expect_err("colours");
    assert!(error.kind == ErrorKind::Unsupported && error.problem.contains("colours already"), "{error}");
}

#[test]
fn arrays_have_frames_first_or_last_and_colours() {
    let (_home, path) = folder_with("a.npy");
    let open = |options: &OpenOptions| Burst::open_with(from_ref(&path), options, &quiet());
    let zeros = |shape| write_npy(&path, &Array3::<u8>::zeros(shape)).expect("written");
    let last = Array3::from_shape_fn((24, 16, 2), |(v, u, t)| (v * 100 + u * 5 + t) as u16);
    write_npy(&path, &last).expect("written");
    let burst = open(&plain()).expect("opens");
    assert_eq!((burst.len(), burst.size()), (2, (16, 24)));
    let at = |t: usize, u, v| (burst.frames[t].at(u, v) * 65535.0).round();
    assert_eq!((at(0, 3, 7), at(1, 3, 7), at(1, 15, 23)), (715.0, 716.0, 2376.0));
    assert!(burst.notes().iter().any(|note| note.text.contains("last axis")), "it is told");
    assert_eq!(open(&axis("first")).expect("as it is said").size(), (2, 16));
    zeros((20, 48, 12));
    assert_eq!(open(&plain()).expect("not by far the shortest").size(), (12, 48));
    assert!(open(&axis("T")).expect_err("no names").to_string().contains("the axes of an array have no names"));
    // A picture with colours or frames: nobody knows.
    zeros((24, 32, 3));
    assert!(open(&plain()).expect_err("either").to_string().contains("3 colours or 3 frames"));
    assert_eq!(open(&axis("last")).expect("frames").len(), 3);
    let colours = Array4::from_shape_fn((2, 3, 4, 3), |(t, v, u, c)| (t * 60 + v * 10 + u + [0, 1, 2][c]) as u8);
    write_npy(&path, &colours).expect("written");
    let burst = open(&plain()).expect("opens");
    assert_eq!((burst.len(), burst.size(), burst.encoding), (2, (4, 3), Encoding::Srgb));
    let luma = |base: f32| base + 0.7152 + 2.0 * 0.0722;
    assert!((burst.frames[1].at(2, 1) * 255.0 - luma(72.0)).abs() < 1e-3);
    let one = Array4::from_shape_fn((5, 1, 3, 4), |(t, _, v, u)| (t * 60 + v * 10 + u) as u8);
    write_npy(&path, &one).expect("written");
    let burst = open(&plain()).expect("opens");
    assert_eq!((burst.len(), (burst.frames[2].at(3, 1) * 255.0).round()), (5, 133.0));
}

#[test]
fn archives_hold_one_array_of_frames() {
    let two = Made::new("two.npz", sample!("two.npz"));
    let burst = two.open(&plain()).expect("times are no frames");
    assert_eq!((burst.len(), burst.size()), (3, (5, 4)));
    assert_close(&values(&burst), &numbered(0..60));
    assert!(burst.notes().iter().any(|note| note.text.contains("'frames' is taken")), "{:?}", burst.notes());
    assert_eq!(two.info(&plain()).kind, "NPZ");
    assert!(two.failure(&array("other")).contains("frames [3, 4, 5], times [3]"));
    assert!(two.failure(&array("times")).contains("[3]"));
    let stored = Made::new("stored.npz", sample!("stored.npz"));
    let burst = stored.open(&plain()).expect("opens");
    assert_eq!((burst.len(), burst.full_scale), (2, 164.0));
    assert_close(&values(&burst), &numbered(0..24));
    let both = Made::new("both.npz", b"");
    let mut npz = ndarray_npy::NpzWriter::new(fs::File::create(&both.path).expect("created"));
    for (name, frames) in [("a", 2), ("b", 5)] {
        npz.add_array(name, &Array3::<u8>::ones((frames, 3, 4))).expect("written");
    }
    npz.finish().expect("written");
    says(both.failure(&plain()), &["--array NAME"]);
    assert_eq!(both.open(&array("b")).expect("chosen").len(), 5);
}

#[test]
fn channels_and_depths_are_never_taken_for_time() {
    for (name, bytes, others) in [
        ("imagej_tcyx.tif", sample!("imagej_tcyx.tif"), 3),
        ("ome_tzyx.ome.tif", sample!("ome_tzyx.ome.tif"), 3),
        ("shaped_tcyx.tif", sample!("shaped_tcyx.tif"), 2),
    ] {
        let file = Made::new(name, bytes);
        let other = if name.contains("tz") { "Z" } else { "C" };
        says(file.failure(&plain()), &[&format!("{others} "), "--axis T"]);
        let frame = |page: usize| -> Vec<f32> {
            let wrapped = |v: f32| if name.starts_with("imagej") { v } else { v % 256.0 };
            numbered(20 * page..20 * (page + 1)).into_iter().map(wrapped).collect()
        };
        let times = 6 / others;
        let burst = file.open(&axis("T")).expect(name);
        assert_eq!(burst.len(), times, "{name}");
        assert_close(&values(&burst)[20..40], &frame(others));
        let burst = file.open(&axis(&format!("T,{other}=1"))).expect(name);
        assert_close(&values(&burst)[20..40], &frame(others + 1));
        let burst = file.open(&axis(&format!("{other},T=1"))).expect(name);
        assert_eq!(burst.len(), others, "{name}");
        assert_close(&values(&burst)[..20], &frame(others));
        assert!(burst.notes().iter().any(|note| note.text.contains("T=1")), "{:?}", burst.notes());
        assert_eq!(file.info(&axis("T")).frames, times);
        file.failure(&axis(if other == "Z" { "C" } else { "Z" }));
    }
}

#[test]
fn fits_images_are_those_that_astropy_reads() {
    let cube = Made::new("cube.fits", sample!("cube_u16.fits", gz));
    let burst = cube.open(&axis("last")).expect("opens");
    assert_eq!((burst.len(), burst.size(), burst.full_scale), (3, (5, 4), 65535.0));
    assert_close(&values(&burst), &numbered(0..60).iter().map(|v| v + 40_000.0).collect::<Vec<_>>());
    let extensions = Made::new("extensions.fits", sample!("extensions.fits", gz));
    let burst = extensions.open(&plain()).expect("opens");
    assert_close(&values(&burst), &numbered(0..20).iter().map(|v| v / 8.0).collect::<Vec<_>>());
    assert!(burst.notes().iter().any(|note| note.text.contains("SCI")), "{:?}", burst.notes());
    let below: Vec<f32> = numbered(0..20).iter().map(|v| -v).collect();
    for name in ["DQ", "1"] {
        assert_close(&values(&extensions.open(&array(name)).expect("chosen")), &below);
    }
    assert!(extensions.failure(&array("ERR")).contains("SCI, DQ"));
    let scaled = Made::new("scaled.fits", sample!("scaled.fits", gz));
    let burst = scaled.open(&plain()).expect("opens");
    assert_close(&values(&burst), &numbered(0..20).iter().map(|v| v * 0.5 + 10.0).collect::<Vec<_>>());
    let info = scaled.info(&plain());
    assert_eq!((info.kind.as_str(), info.begins.as_deref()), ("FITS", Some("2021-03-01T22:00:15.250Z")));
}

/// Each image of the sample stands there twice: compressed by astropy, and as astropy reads it.
#[test]
fn tiles_of_fits_hold_what_astropy_reads_and_what_is_not_asked_for_is_read_by_name() {
    let file = Made::new("tiles.fits.fz", sample!("tiles.fits", gz));
    for (name, _) in TILES {
        let (packed, read) = (file.open(&frames_of(name)), file.open(&frames_of(&format!("{name}_READ"))));
        let (packed, read) = (packed.expect(name), read.expect("opens"));
        assert_eq!((&*packed.name, packed.len(), packed.size()), ("tiles", 3, (10, 12)), "{name}");
        assert_eq!(values(&packed), values(&read), "{name}");
        let masked = |burst: &Burst| burst.frames.iter().filter(|frame| frame.mask().is_some()).count();
        assert_eq!(masked(&packed), masked(&read), "{name}");
        let part = OpenOptions { take: Some("2..3".parse().expect("a part")), ..frames_of(name) };
        assert_eq!(values(&file.open(&part).expect(name)), values(&read)[240..], "{name}");
    }
    assert_eq!(file.info(&axis("last")).kind, "FITS");
    // Results and lists beside frames are no frames.
    let home = folder();
    (0..3).for_each(|t| save(&home.join(format!("{t}.png")), &grey8(4, 3, t)));
    for (name, bytes) in
        [("features.npz", sample!("two.npz")), ("times.dat", b"0 1 2"), ("all.mp4", b"\0\0\0\x18ftypisom")]
    {
        fs::write(home.join(name), bytes).expect("written");
    }
    assert_eq!(Burst::open(&home).expect("opens").len(), 3);
    let of = |name: &str| Info::of(&[home.join(name)], &plain(), &quiet());
    assert!(of("times.dat").is_err() && of("0.png").is_ok_and(|info| info.kind == "PNG"));
    assert!(Path::new(&of("0.png").expect("described").name).extension().is_none());
}

#[test]
fn damage_of_tiles_is_an_error() {
    let whole = unpacked(include_bytes!("samples/tiles.fits.gz"));
    let changed = |name: &str, from: &str, to: &str| {
        let mut bytes = whole.clone();
        let (name, from) = (format!("EXTNAME = '{name:<8}'"), from.as_bytes());
        let find =
            |part: &[u8], start| bytes[start..].windows(part.len()).position(|own| own == part).map(|at| start + at);
        let unit = find(name.as_bytes(), 0).expect("the image") / 2880 * 2880;
        let at = find(from, unit).expect("the keyword");
        bytes[at..at + to.len()].copy_from_slice(to.as_bytes());
        Made::new("bad.fits", &bytes).failure(&frames_of(name[11..].trim_end_matches(['\'', ' '])))
    };
    assert!(changed("I16", "ZNAXIS1 =                   10", "ZNAXIS1 =                  -10").contains("ZNAXIS1"));
    assert!(changed("I16", "ZNAXIS3 =                    3", "ZNAXIS3 =                    9").contains("tiles in"));
    assert!(changed("I16", "ZVAL1   =                   32", "ZVAL1   =                    0").contains("ZVAL1"));
    assert!(changed("I16", "TFIELDS =                    1", "TFIELDS =           9000000000").contains("TFIELDS"));
    assert!(changed("I16", "TFORM1  = '1PB", "TFORM1  = '1?B").contains("(TFORM)"));
    assert!(changed("I16", "ZCMPTYPE= 'RICE_1  '", "ZCMPTYPE= 'RICE_7  '").contains("compression"));
    let packed = |unpacked| Made::new("packed.fits", &crafted::packed_tile_fits(unpacked));
    assert_eq!(packed(64).open(&plain()).expect("opens").size(), (8, 8));
    assert!(packed(1 << 22).failure(&plain()).contains("unpacks to more than its pixels"));
}

#[test]
fn damage_of_fits_names_the_keyword() {
    let whole = unpacked(include_bytes!("samples/cube_u16.fits.gz"));
    let changed = |from: &str, to: &str| {
        let mut bytes = whole.clone();
        let at = bytes.windows(from.len()).position(|part| part == from.as_bytes()).expect(from);
        bytes[at..at + to.len()].copy_from_slice(to.as_bytes());
        Made::new("bad.fits", &bytes).failure(&axis("last"))
    };
    let card = |name: &str, value: &str| format!("{name:<8}= {value:>20}");
    for (name, from, to, words) in [
        ("NAXIS", "3", "x", "NAXIS is no whole number"),
        ("NAXIS2", "4", "-4", "NAXIS2"),
        ("BITPIX", "16", "17", "BITPIX is 17"),
        ("BZERO", "32768", "many", "BZERO is no number"),
        ("NAXIS1", "5", "9999999", "9999999×4"),
    ] {
        says(changed(&card(name, from), &card(name, to)), &[words]);
    }
    assert!(changed("END     ", "EMD     ").contains("too early"));
    // The third axis is wavelengths.
    let mut bytes = whole.clone();
    let at = bytes.windows(8).position(|part| part == b"END     ").expect("an end");
    let card = format!("{:<80}END", "CTYPE3  = 'WAVE    '");
    bytes[at..at + card.len()].copy_from_slice(card.as_bytes());
    let spectral = Made::new("spectral.fits", &bytes);
    assert!(spectral.failure(&plain()).contains("differ in WAVE"));
    assert_eq!(spectral.open(&axis("last")).expect("asked for").len(), 3);
    // An undefined value is masked.
    let card = format!("{:<80}END", "BLANK   =                -32768");
    bytes[at..at + card.len()].copy_from_slice(card.as_bytes());
    bytes[2880..2882].copy_from_slice(&(-32768i16).to_be_bytes());
    let burst = Made::new("blank.fits", &bytes).open(&axis("last")).expect("opens");
    let masked = burst.frames[0].mask().expect("masked");
    assert_eq!((masked.weights().at(0, 0), masked.weights().data().iter().sum::<f32>()), (0.0, 19.0));
    assert!(burst.frames[1].mask().is_none() && burst.frames.iter().all(|f| f.data().iter().all(|x| x.is_finite())));
    assert!(burst.taken.contains(&"pixels without a value (NaN) are masked: 1 in 1 of 3 frames".to_owned()));
}

#[test]
fn ser_films_have_times_bits_and_mosaics() {
    let ser = Made::new("jupiter.ser", sample!("mono12.ser"));
    let expected: Vec<f32> = numbered(0..36).iter().map(|v| (v * 31.0) % 4096.0).collect();
    let burst = ser.open(&plain()).expect("opens");
    assert_eq!((burst.len(), burst.size(), burst.full_scale), (3, (4, 3), 4095.0));
    assert_close(&values(&burst), &expected);
    let info = ser.info(&plain());
    assert_eq!((info.samples.as_str(), info.begins.as_deref()), ("12 bit", Some("2021-03-01T22:00:00.000Z")));
    assert!((info.times_s[1] - 0.0333333).abs() < 1e-6 && (info.times_s[2] - 0.07).abs() < 1e-6, "{:?}", info.times_s);
    let with = |changes: &[(usize, u32)]| {
        let mut bytes = sample!("mono12.ser").to_vec();
        changes.iter().for_each(|(at, value)| bytes[*at..at + 4].copy_from_slice(&value.to_le_bytes()));
        Made::new("bad.ser", &bytes)
    };
    let (colour, order, width, height, bits, frames) = (18, 22, 26, 30, 34, 38);
    let swapped = with(&[(order, 1)]).open(&OpenOptions { full_scale: Some(65535.0), ..plain() }).expect("opens");
    let first = (expected[0] as u16).swap_bytes();
    assert_close(&values(&swapped)[..1], &[f32::from(first)]);
    let mosaic = with(&[(colour, 8)]).open(&plain()).expect("opens");
    assert_eq!((mosaic.size(), mosaic.binning), ((2, 1), 2));
    assert_close(&values(&mosaic)[..1], &[(expected[0] + expected[1] + expected[4] + expected[5]) / 4.0]);
    // 36 numbers of 16 bits are 8 pixels of three bytes, three times.
    let rgb = [(bits, 8), (width, 4), (height, 2)];
    let of = |id| with(&[&rgb[..], &[(colour, id)]].concat()).open(&plain()).expect("opens");
    assert_eq!((of(100).size(), of(100).len()), ((4, 2), 3));
    let bytes = &sample!("mono12.ser")[178..181];
    let luma =
        |r: usize, b: usize| 0.2126 * f32::from(bytes[r]) + 0.7152 * f32::from(bytes[1]) + 0.0722 * f32::from(bytes[b]);
    assert_close(&values(&of(100))[..1], &[luma(0, 2)]);
    assert_close(&values(&of(101))[..1], &[luma(2, 0)]);
    for (changes, word) in [
        (&[(bits, 17)][..], "PixelDepthPerPlane"),
        (&[(colour, 7)], "ColorID is 7"),
        (&[(colour, 16)], "cyan"),
        (&[(frames, 2000)], "bytes of values are announced"),
        (&[(width, u32::MAX), (height, u32::MAX)], "4294967295×4294967295"),
    ] {
        says(with(changes).failure(&plain()), &[word]);
    }
}

#[test]
fn films_of_y4m_give_their_luma() {
    let grey = Made::new("grey.y4m", sample!("grey16.y4m"));
    let burst = grey.open(&plain()).expect("opens");
    assert_eq!((burst.len(), burst.size(), burst.full_scale, burst.encoding), (3, (16, 12), 65535.0, Encoding::Linear));
    let expected: Vec<f32> = numbered(0..576).iter().map(|v| v * 50.0 % 65536.0).collect();
    assert_close(&values(&burst), &expected);
    let colour = Made::new("colour.y4m", sample!("c420.y4m"));
    let burst = colour.open(&plain()).expect("opens");
    assert_eq!((burst.len(), burst.encoding), (3, Encoding::Srgb));
    assert_close(&values(&burst), &numbered(0..576).iter().map(|v| v % 219.0 + 16.0).collect::<Vec<_>>());
    let info = colour.info(&plain());
    assert!((info.times_s[2] - 2.0 * 1001.0 / 30000.0).abs() < 1e-9, "{:?}", info.times_s);
    let ten = Made::new("ten.y4m", sample!("c422p10.y4m"));
    let burst = ten.open(&plain()).expect("opens");
    assert_eq!((burst.len(), burst.full_scale), (2, 1023.0));
    assert_close(&values(&burst), &numbered(0..96).iter().map(|v| v % 1024.0).collect::<Vec<_>>());
    let changed = |from: &str, to: &str| {
        let text = sample!("c420.y4m");
        let at = text.windows(from.len()).position(|part| part == from.as_bytes()).expect(from);
        let bytes = [&text[..at], to.as_bytes(), &text[at + from.len()..]].concat();
        Made::new("bad.y4m", &bytes).failure(&plain())
    };
    assert!(changed("W16", "Wide").contains("no number of pixels W"));
    for colours in ["410", "", "42", "420p8", "420p17", "mono8", "mono99999999999", "rgb", "4\u{e9}\u{e9}"] {
        says(changed("C420jpeg", &format!("C{colours}")), &[&format!("colours are {colours};")]);
    }
    let mono = Made::new("mono.y4m", b"YUV4MPEG2 W2 H1 Cmono\nFRAME\n\x01\x02").open(&plain()).expect("opens");
    assert_eq!(mono.full_scale, 255.0);
    assert_close(&values(&mono), &[1.0, 2.0]);
    assert!(changed(" Ip", " It").contains("interlaced"));
    assert!(changed("FRAME", "FROM").contains("FRAME"));
    assert!(changed("H12", "H0").contains("no pixels"));
    let cut = sample!("c420.y4m");
    assert!(Made::new("cut.y4m", &cut[..cut.len() - 1]).failure(&plain()).contains("ends within frame 2"));
}

#[needs::program("ffmpeg")]
#[test]
fn films_are_decoded_by_ffmpeg_with_all_bits() {
    let film = Made::new("it's a film.mkv", sample!("grey16.mkv"));
    let burst = film.open(&plain()).expect("opens");
    let expected: Vec<f32> = numbered(0..576).iter().map(|v| v * 50.0 % 65536.0).collect();
    assert_eq!((burst.len(), burst.size(), burst.full_scale), (3, (16, 12), 65535.0));
    assert_close(&values(&burst), &expected);
    let info = film.info(&plain());
    assert_eq!((info.kind.as_str(), info.frames), ("film", 3));
    assert!((info.times_s[2] - 0.08).abs() < 1e-3, "{:?}", info.times_s);
    let paths = [film.path.clone()];
    assert!(Burst::open_with(&paths, &plain(), &cancelled()).expect_err("cancelled").is_cancelled());
    // Colours become luma by this program's weights, whatever ffmpeg's are.
    let (_home, path) = folder_with("colours.mkv");
    let source = "color=red:size=16x12:rate=5:duration=0.6,format=rgb24";
    let arguments = ["-v", "error", "-f", "lavfi", "-i", source, "-c:v", "ffv1", "-pix_fmt", "bgr0"];
    let made = std::process::Command::new("ffmpeg").args(arguments).arg(&path).status().expect("ffmpeg runs");
    assert!(made.success());
    let burst = Burst::open_with(&[path], &plain(), &quiet()).expect("opens");
    assert_eq!((burst.len(), burst.size()), (3, (16, 12)));
    assert!(burst.frames.iter().all(|frame| frame.data().iter().all(|v| (v - 0.2126).abs() < 0.001)));
    // A camera of depth records a track for each of its pictures; a cover is none.
    let (_home, path) = folder_with("tracks.mkv");
    let other = "color=white:size=24x20:rate=5:duration=0.4";
    let arguments = ["-v", "error", "-f", "lavfi", "-i", source, "-f", "lavfi", "-i", other];
    let arguments = [&arguments[..], &["-map", "0", "-map", "1", "-c:v", "ffv1"]].concat();
    let made = std::process::Command::new("ffmpeg").args(arguments).arg(&path).status().expect("ffmpeg runs");
    assert!(made.success());
    for (track, size, frames) in [(None, (16, 12), 3), (Some("1"), (24, 20), 2)] {
        let options = track.map_or_else(plain, array);
        let info = Info::of(std::slice::from_ref(&path), &options, &quiet()).expect("described");
        says(info.text(), &["of 2 tracks number", track.unwrap_or("0")]);
        let burst = Burst::open_with(std::slice::from_ref(&path), &options, &quiet()).expect("opens");
        assert_eq!((info.frames, burst.len(), burst.size()), (frames, frames, size));
    }
    for track in ["7", "left"] {
        assert!(Burst::open_with(std::slice::from_ref(&path), &array(track), &quiet()).is_err(), "{track}");
    }
    let cut = sample!("grey16.mkv");
    assert!(Made::new("cut.mkv", &cut[..cut.len() / 2]).failure(&plain()).contains("and says"));
}

#[cfg(unix)]
#[test]
fn options_beside_a_path_that_is_no_text_are_told() {
    use std::os::unix::ffi::OsStrExt;
    let bias = Path::new(std::ffi::OsStr::from_bytes(b"dark\xff.png")).to_owned();
    let options = OpenOptions { bias: Some(bias), ..array("SCI") };
    let told = |name: &str, value: &str| (name.to_owned(), Some(value.to_owned()));
    assert_eq!(options.given(), [told("array", "SCI"), told("bias", "dark\u{fffd}.png")]);
}
