//! What files declare is used or told: axes and order of pages, frames behind one another, mosaics, colours, values,
//! recordings that were stopped. Each is tried on several instances; pages have values by which they are told apart.

use super::support::*;
use std::{collections::HashSet, fs::File};

const SIZE: (u32, u32) = (8, 6);

impl Made {
    /// A TIFF of pages whose values are their numbers times 100.
    fn tiff(name: &str, pages: u16, description: &str) -> Self {
        let made = Self::new(name, b"");
        write_tiff(&made.path, 0..pages, description);
        made
    }

    /// Numbers of the pages that become frames.
    fn pages(&self, options: &str) -> Vec<u16> {
        let burst = self.open(&given(options)).unwrap_or_else(|e| panic!("{}: {e}", self.path.display()));
        burst.frames.iter().map(|frame| (frame.at(3, 3) * 65535.0 / 100.0).round() as u16).collect()
    }

    fn refusal(&self, options: &str) -> String {
        self.open(&given(options)).expect_err("refused").to_string()
    }
}

fn write_tiff(path: &Path, pages: std::ops::Range<u16>, description: &str) {
    let mut encoder = TiffEncoder::new(File::create(path).expect("made")).expect("begins");
    for page in pages {
        let mut image = encoder.new_image::<colortype::Gray16>(SIZE.0, SIZE.1).expect("a page");
        if page == 0 || description.contains("FileName") {
            image.encoder().write_tag(Tag::ImageDescription, description).expect("a description");
        }
        image.write_data(&vec![100 * page; (SIZE.0 * SIZE.1) as usize]).expect("written");
    }
}

/// Options of one word or two: `axis T,C=1`, `array b`, `raw 8x6:u1`.
fn given(options: &str) -> OpenOptions {
    let plain = OpenOptions::default();
    match options.split_once(' ') {
        None => plain,
        Some(("axis", axis)) => OpenOptions { axis: Some(axis.parse().expect("an axis")), ..plain },
        Some(("array", name)) => OpenOptions { array: Some(name.to_owned()), ..plain },
        Some(("raw", shape)) => OpenOptions { raw: Some(shape.parse().expect("a shape")), ..plain },
        Some(("mosaic", name)) => OpenOptions { mosaic: serde_json::from_value(name.into()).expect("known"), ..plain },
        Some(("take", range)) => OpenOptions { take: Some(range.parse().expect("a range")), ..plain },
        Some(("times", times)) => OpenOptions { times: Some(times.parse().expect("times")), ..plain },
        Some((name, _)) => panic!("no option {name}"),
    }
}

/// An OME description of times and channels; `prefix` stands before each name, `more` before the end of the pixels.
fn ome((times, channels): (usize, usize), prefix: &str, more: &str) -> String {
    let namespace =
        if prefix.is_empty() { "xmlns".to_owned() } else { format!("xmlns:{}", prefix.trim_end_matches(':')) };
    let of_channels: String =
        (0..channels).map(|c| format!("<{prefix}Channel ID=\"C:{c}\" SamplesPerPixel=\"1\"/>")).collect();
    format!(
        "<?xml version=\"1.0\"?><{prefix}OME {namespace}=\"http://www.openmicroscopy.org/Schemas/OME/2016-06\">\
         <{prefix}Image ID=\"I:0\" Name=\"a\"><{prefix}Pixels ID=\"P\" Type=\"uint16\" DimensionOrder=\"XYZCT\" SizeX=\"8\" \
         SizeY=\"6\" SizeZ=\"1\" SizeC=\"{channels}\" SizeT=\"{times}\">{of_channels}{more}</{prefix}Pixels></{prefix}Image>\
         </{prefix}OME>"
    )
}

#[test]
fn descriptions_in_any_form_are_understood() {
    let plain = ome((5, 2), "", "<TiffData IFD=\"0\" PlaneCount=\"10\"/>");
    let long = plain.replace("<Image", &format!("<Notes>{}</Notes><Image", "x".repeat(100_000)));
    for description in [
        plain.clone(),
        ome((5, 2), "OME:", "<OME:TiffData/>"),
        ome((5, 2), "o:", ""),
        plain.replace('"', "'"),
        plain.replace("Name=\"a\"", "Name = \"a &gt; b\""),
        format!("\n{plain}"),
        long,
    ] {
        let file = Made::tiff("a.ome.tif", 10, &description);
        says(file.refusal(""), &["5 times (T) × 2 channels (C)", "--axis T"]);
        assert_eq!(file.pages("axis T"), [0, 2, 4, 6, 8]);
        assert_eq!(file.pages("axis T,C=1"), [1, 3, 5, 7, 9]);
        assert_eq!(file.pages("axis first"), [0, 2, 4, 6, 8]);
    }
}

#[test]
fn channels_and_depths_of_microscopes_are_not_time() {
    let scanimage = "scanimage.SI.hChannels.channelSave = [1;2]\nscanimage.SI.hStackManager.enable = false\n";
    let fast = "SI.hChannels.channelSave = 1\nSI.hFastZ.enable = 1\nSI.hFastZ.numFramesPerVolume = 2\n";
    let slow = "SI.hChannels.channelSave = 2\nSI.hStackManager.enable = 1\nSI.hStackManager.numSlices = 2\n";
    for (description, asked, axis, pages) in [
        (scanimage, "3 times (T) × 2 channels (C)", "T,C=1", [1, 3, 5]),
        ("scanimage.SI5.channelsSave = [1;2]\n", "3 times (T) × 2 channels (C)", "T", [0, 2, 4]),
        ("state.acq.numberOfChannelsSave=2\rstate.acq.zoomFactor=1\r", "3 times (T)", "T", [0, 2, 4]),
        (fast, "3 times (T) × 2 depths (Z)", "T,Z=1", [1, 3, 5]),
        (slow, "2 depths (Z) × 3 times (T)", "T,Z=1", [3, 4, 5]),
    ] {
        let file = Made::tiff("a.tif", 6, description);
        says(file.refusal(""), &[asked, "--axis T"]);
        assert_eq!(file.pages(&format!("axis {axis}")), pages, "{description}");
    }
    let channels = Made::tiff("q.tif", 3, "<?xml version=\"1.0\"?><PerkinElmer-QPI-ImageDescription/>");
    says(channels.refusal(""), &["3 channels (C)"]);
    assert_eq!(Made::tiff("one.tif", 3, "SI.hChannels.channelSave = 4\n").pages(""), [0, 1, 2]);
}

#[test]
fn what_does_not_fit_or_cannot_be_understood_is_an_error_with_a_way_out() {
    let page_elsewhere = "<TiffData FirstC=\"2\" IFD=\"0\"/>";
    for description in [
        "<OME><Image><Pixels".to_owned(),
        "<?xml version=\"1.0\"?><OME></OME>".to_owned(),
        ome((3, 1), "", page_elsewhere),
        ome((3, 1), "", "<TiffData IFD=\"x\"/>"),
        ome((3, 1), "", "").replace("XYZCT", "XYQQQ"),
        ome((0, 1), "", ""),
        "<OME xmlns=\"o\"><BinaryOnly MetadataFile=\"none.companion.ome\"/></OME>".to_owned(),
        "ImageJ=1.53\nimages=2\nframes=2\n".to_owned(),
        "{\"shape\": [2, 6, 8], \"axes\": \"TYX\"}".to_owned(),
    ] {
        let file = Made::tiff("a.ome.tif", 6, &description);
        says(file.refusal(""), &["--axis first", "a.ome.tif"]);
        assert_eq!(file.pages("axis first"), [0, 1, 2, 3, 4, 5], "{description}");
    }
    // What tells nothing of pages is no description of them.
    for description in ["", "words", "{", "{\"shape\": 3}", "<svg/>", "ImageJ=1.53\nimages=6\n"] {
        assert_eq!(Made::tiff("a.tif", 6, description).pages(""), [0, 1, 2, 3, 4, 5], "{description}");
    }
}

#[test]
fn pages_have_the_order_that_the_description_gives_them() {
    let backwards: String =
        (0..4).map(|t| format!("<TiffData FirstT=\"{t}\" IFD=\"{}\" PlaneCount=\"1\"/>", 3 - t)).collect();
    assert_eq!(Made::tiff("b.ome.tif", 4, &ome((4, 1), "", &backwards)).pages(""), [3, 2, 1, 0]);
    let by_channel: String =
        (0..6).map(|k| format!("<TiffData FirstC=\"{}\" FirstT=\"{}\" IFD=\"{k}\"/>", k / 3, k % 3)).collect();
    let file = Made::tiff("c.ome.tif", 6, &ome((3, 2), "", &by_channel));
    assert_eq!((file.pages("axis T"), file.pages("axis T,C=1")), (vec![0, 1, 2], vec![3, 4, 5]));
    // Of a set of files, each tells of all.
    let part = |k: usize| {
        let file = format!("<UUID FileName=\"run_{n}.ome.tif\">u:{n}</UUID>", n = k / 3);
        format!("<TiffData FirstT=\"{k}\" IFD=\"{}\">{file}</TiffData>", k % 3)
    };
    let description = ome((6, 1), "", &(0..6).map(part).collect::<String>());
    let file = Made::tiff("run_0.ome.tif", 3, &description);
    says(file.refusal(""), &["run_1.ome.tif"]);
    write_tiff(&file.folder.join("run_1.ome.tif"), 3..6, &description);
    assert_eq!(file.pages(""), [0, 1, 2, 3, 4, 5]);
    says(file.info(&given("")).taken.join("; "), &["set of 2"]);
    // The description may lie in a file beside it.
    let file = Made::tiff("d.ome.tif", 4, "<OME xmlns=\"o\"><BinaryOnly MetadataFile=\"x/run.companion.ome\"/></OME>");
    fs::write(file.folder.join("run.companion.ome"), ome((2, 2), "", "")).expect("written");
    assert_eq!(file.pages("axis T,C=1"), [1, 3]);
}

#[test]
fn one_of_several_images_is_named() {
    let one = ome((3, 1), "", "<TiffData IFD=\"0\" PlaneCount=\"3\"/>");
    let image = &one[one.find("<Image").expect("an image")..one.find("</OME>").expect("an end")];
    let second = image.replace("Name=\"a\"", "Name=\"b\"").replace("IFD=\"0\"", "IFD=\"3\"");
    let file = Made::tiff("p.ome.tif", 6, &one.replace("</OME>", &format!("{second}</OME>")));
    says(file.refusal(""), &["2 images", "--array", "a, b"]);
    assert_eq!((file.pages("array b"), file.pages("array 0")), (vec![3, 4, 5], vec![0, 1, 2]));
    assert!(file.refusal("array c").contains("'c'"));
}

#[test]
fn a_recording_that_was_stopped_opens_and_ser_films_that_are_odd_are_told() {
    for (description, pages) in [
        (ome((10, 2), "", "<TiffData IFD=\"0\" PlaneCount=\"20\"/>"), 7),
        (ome((10, 2), "", ""), 7),
        ("ImageJ=1.53\nimages=20\nchannels=2\nframes=10\n".to_owned(), 7),
        ("{\"shape\": [10, 2, 6, 8], \"axes\": \"TCYX\"}".to_owned(), 7),
    ] {
        let file = Made::tiff("s.tif", pages, &description);
        assert!(file.refusal("").contains("(7 pages are written)"), "{}", file.refusal(""));
        assert_eq!(file.pages("axis T"), [0, 2, 4]);
        let told = file.info(&given("axis T")).taken;
        assert!(told.iter().any(|taken| taken.contains("10 along T") && taken.contains("3 are written")), "{told:?}");
        assert_eq!(file.pages("axis C,T=2"), [4, 5]);
    }
    let values: Vec<u16> = (0..40).collect();
    let stopped = Made::new("c.ser", &ser(0, 16, &values, &[]));
    assert_eq!(stopped.open(&given("")).expect("opens").len(), 5);
    says(stopped.info(&given("")).taken.join("; "), &["stopped"]);
    let upper: Vec<u16> = (0..40).map(|v| (v * 100) << 4).collect();
    let left = Made::new("l.ser", &ser(5, 12, &upper, &[]));
    let burst = left.open(&given("")).expect("opens");
    assert_eq!(burst.full_scale, 65520.0);
    assert!(burst.notes().iter().any(|note| note.text.contains("upper 12")), "{:?}", burst.notes());
    let second = 10_000_000;
    let from = 621_355_968_000_000_000 + second;
    let stamps = [0, 2, 1, 3, 4].map(|k| from + k * second);
    let told = Made::new("u.ser", &ser(5, 16, &values, &stamps)).refusal("times header");
    assert!(!told.contains("0 times") && told.contains("times"), "{told}");
}

#[test]
fn frames_behind_one_another_are_opened() {
    // One directory, and the numbers of four frames.
    let pixels: Vec<u8> = (0..4u16).flat_map(|t| [100 * t; 48]).flat_map(u16::to_le_bytes).collect();
    let file = |more: &[(u16, u16, u32, u32)], description: &str| {
        let text = format!("{description}\0\0\0\0\0");
        let mut entries = vec![
            (256, 3, 1, 8),
            (257, 3, 1, 6),
            (258, 3, 1, 16),
            (259, 3, 1, 1),
            (262, 3, 1, 1),
            (270, 2, text.len() as u32, 8),
            (273, 4, 1, 8 + text.len() as u32 + 96),
            (277, 3, 1, 1),
            (278, 3, 1, 6),
            (279, 4, 1, 96),
        ];
        entries.extend(more);
        entries.sort_unstable();
        let numbers: Vec<u8> =
            (0..4u32).flat_map(|t| [0, 1, 2_455_000, 40 * t, 0, 0]).flat_map(u32::to_le_bytes).collect();
        assert_eq!(numbers.len(), 96);
        let at = (8 + text.len() + numbers.len() + pixels.len()) as u32;
        let directory = super::crafted::entries(&entries);
        [b"II*\0", &at.to_le_bytes()[..], text.as_bytes(), &numbers, &pixels, &directory].concat()
    };
    let stk = file(&[(33629, 5, 4, 8 + "words\0\0\0\0\0".len() as u32)], "words");
    let big = file(&[], "ImageJ=1.53\nimages=4\nframes=4\n");
    let array = file(&[], "{\"shape\": [4, 6, 8], \"axes\": \"TYX\", \"truncated\": true}");
    for (name, bytes) in [("m.stk", &stk), ("m.tif", &stk), ("i.tif", &big), ("t.tif", &array)] {
        let made = Made::new(name, bytes);
        assert_eq!(made.pages(""), [0, 1, 2, 3], "{name}");
        assert_eq!(made.pages("take 1..3"), [1, 2], "{name}");
        // What is announced and not there is damage.
        let cut = Made::new(name, &file(&[], "ImageJ=1.53\nimages=40\nframes=40\n"));
        assert!(cut.refusal("").contains("are there"), "{}", cut.refusal(""));
    }
    let times = Made::new("m.stk", &stk).info(&given("")).times_s;
    assert!(times.iter().zip([0.0, 0.04, 0.08, 0.12]).all(|(a, b)| (a - b).abs() < 1e-6), "{times:?}");
    // A volume is no film.
    let volume = Made::new("v.tif", &file(&[(32997, 4, 1, 4)], ""));
    assert!(volume.refusal("").contains("4 depths (Z)"), "{}", volume.refusal(""));
    assert_eq!(volume.pages("axis Z"), [0, 1, 2, 3]);
}

#[test]
fn bits_in_reverse_are_turned_and_frames_of_bits_open_packed() {
    let bytes: Vec<u8> = [1u8, 2, 200, 255].iter().map(|byte| byte.reverse_bits()).collect();
    let file = Made::new("r.tif", &raw_tiff(false, (4, 1), &[8], &[(262, 1), (266, 2)], &[&bytes]));
    let found = file.open(&given("")).expect("opens").frames[0].data().to_vec();
    assert_eq!(found, [1.0, 2.0, 200.0, 255.0].map(|v| v / 255.0));
    let packed: Vec<u8> = vec![0b1010_0000, 0xff, 0, 1];
    for (name, bytes) in [("b.raw", packed.clone()), ("b.npy", super::crafted::npy("2, 2, 1", &packed))] {
        let file = Made::new(name, &bytes);
        let burst = file.open(&given("raw 8x2:u1")).expect("opens");
        assert_eq!((burst.len(), burst.size(), burst.full_scale), (2, (8, 2), 1.0));
        assert_eq!(burst.frames[0].row(0), [1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        assert_eq!(burst.frames[1].row(1), [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
    }
    assert!("9x2:u1".parse::<Dump>().is_err());
}

fn fits(cards: &[&str], values: usize) -> Vec<u8> {
    let mut header: String = cards.iter().map(|card| format!("{card:<80}")).collect();
    header += &format!("{:<80}", "END");
    let mut bytes = format!("{header:<2880}").into_bytes();
    bytes.extend((0..values).flat_map(|k| (k as i16).to_be_bytes()));
    bytes.resize(bytes.len().next_multiple_of(2880), 0);
    bytes
}

const FITS: [&str; 3] =
    ["SIMPLE  =                    T", "BITPIX  =                   16", "NAXIS   =                    2"];

#[test]
fn shapes_of_arrays_are_told_from_those_of_their_pages() {
    // Of arrays of pages, and of pages that were written one by one, each with its own description.
    for shape in ["[4, 6, 8]", "[4, 6, 8, 1]", "[4, 1, 6, 8]", "[6, 8]", "[6, 8, 1]", "[1, 6, 8]"] {
        assert_eq!(Made::tiff("a.tif", 4, &format!("{{\"shape\": {shape}}}")).pages(""), [0, 1, 2, 3], "{shape}");
    }
    let file = Made::tiff("b.tif", 4, "{\"shape\": [2, 2, 6, 8]}");
    assert!(file.refusal("").contains("2 pages without a meaning × 2"), "{}", file.refusal(""));
    let file = Made::tiff("c.tif", 4, "{\"shape\": [2, 6, 8]}");
    assert!(file.refusal("").contains("and it has 4 pages"), "{}", file.refusal(""));
    for shape in ["[4, 6, 8, 3]", "[4, 3, 6, 8]", "[6, 8, 3]", "[3, 6, 8]"] {
        let made = Made::new("d.tif", b"");
        let mut encoder = TiffEncoder::new(File::create(&made.path).expect("made")).expect("begins");
        for page in 0..4 {
            let mut image = encoder.new_image::<colortype::RGB16>(SIZE.0, SIZE.1).expect("a page");
            let description = format!("{{\"shape\": {shape}}}");
            image.encoder().write_tag(Tag::ImageDescription, &*description).expect("a description");
            image.write_data(&vec![100 * page; 3 * (SIZE.0 * SIZE.1) as usize]).expect("written");
        }
        assert_eq!(made.pages(""), [0, 1, 2, 3], "{shape}");
    }
}

#[test]
fn pictures_behind_the_first_of_a_file_are_told() {
    let one: Vec<u8> = b"P5\n16 16\n255\n".iter().copied().chain(0..=255).collect();
    assert!(Made::new("one.pgm", &one).info(&given("")).taken.is_empty());
    let three = Made::new("three.pgm", &one.repeat(3));
    assert!(three.info(&given("")).text().contains("as long as 3 pictures, of which the first is taken"));
    assert!(three.open(&given("")).expect("opens").taken.iter().any(|note| note.contains("3 pictures")));
    let array = super::crafted::npy("6, 8", &[7; 48]);
    assert!(Made::new("one.npy", &array).info(&given("")).taken.iter().all(|note| !note.contains("behind")));
    let two = Made::new("two.npy", &array.repeat(2)).info(&given(""));
    says(two.text(), &[&format!("behind the array lie {} bytes that are not read", array.len())]);
    // A file of one piece may end with anything.
    let cards = [&FITS[..], &["NAXIS1  =                    8", "NAXIS2  =                    6"]].concat();
    let preallocated = [fits(&cards, 48), vec![0; 3 * 2880]].concat();
    assert_eq!(Made::new("p.fits", &preallocated).open(&given("")).expect("opens").size(), (8, 6));
}

#[test]
fn what_is_not_opened_is_not_described_and_records_tell_of_every_format_once() {
    let made = Made::new("cmyk.tif", b"");
    let mut encoder = TiffEncoder::new(File::create(&made.path).expect("made")).expect("begins");
    let image = encoder.new_image::<colortype::CMYK8>(SIZE.0, SIZE.1).expect("a page");
    image.write_data(&[0; 4 * (SIZE.0 * SIZE.1) as usize]).expect("written");
    let told = Info::of(from_ref(&made.path), &OpenOptions::default(), &quiet());
    assert_eq!(told.expect_err("refused").to_string(), made.refusal(""));
    let (mut names, mut extensions) = (HashSet::new(), HashSet::new());
    for of in file_formats() {
        assert!(!of.opens.is_empty() && !of.extensions.is_empty() && names.insert(of.name), "{of:?}");
        for extension in of.extensions {
            assert!(*extension == extension.to_lowercase() && extensions.insert(*extension), "{extension}");
        }
    }
}

/// A TIFF/EP of two pages, 9×7, whose pixels are 100, 200 and 300 where the square `pattern` is red, green and blue.
fn tiff_of_sensor(pattern: &[u8], orientation: u16) -> Made {
    let made = Made::new("ep.tif", b"");
    let mut encoder = TiffEncoder::new(File::create(&made.path).expect("made")).expect("begins");
    let colour = |k: usize| pattern.get(k / 9 % 2 * 2 + k % 9 % 2).copied().unwrap_or(1);
    for _ in 0..2 {
        let mut image = encoder.new_image::<colortype::Gray16>(9, 7).expect("a page");
        let tags = image.encoder();
        tags.write_tag(Tag::PhotometricInterpretation, 32803u16).expect("a tag");
        tags.write_tag(Tag::Orientation, orientation).expect("a tag");
        if !pattern.is_empty() {
            tags.write_tag(Tag::Unknown(33421), &[2u16, 2][..]).expect("a tag");
            tags.write_tag(Tag::Unknown(33422), pattern).expect("a tag");
        }
        image.write_data(&(0..63).map(|k| 100 + 100 * u16::from(colour(k))).collect::<Vec<u16>>()).expect("written");
    }
    made
}

#[test]
fn the_mosaic_of_a_tiff_is_used_however_the_camera_was_held() {
    for pattern in [[0, 1, 1, 2], [1, 0, 2, 1], [1, 2, 0, 1], [2, 1, 1, 0]] {
        for orientation in 1..=8 {
            let file = tiff_of_sensor(&pattern, orientation);
            let size = if orientation < 5 { (4, 3) } else { (3, 4) };
            assert_eq!((file.info(&given("")).binning, file.info(&given("")).width), (2, size.0), "{pattern:?}");
            let blue = OpenOptions { raw_colour: RawColour::Blue, ..OpenOptions::default() };
            let blue = file.open(&blue).expect("opens");
            assert_eq!((blue.size(), blue.len()), (size, 2));
            let is_blue = |value: &f32| (value * 65535.0 - 300.0).abs() < 0.1;
            assert!(blue.frames.iter().all(|frame| frame.data().iter().all(is_blue)), "{pattern:?}, {orientation}");
            let whole = file.open(&given("mosaic none")).expect("opens").size();
            assert_eq!(whole, if orientation < 5 { (9, 7) } else { (7, 9) });
        }
    }
    let told = tiff_of_sensor(&[1, 0, 2, 1], 1).info(&given("")).text();
    says(told, &["is what the file says, grbg: squares of 2×2"]);
    let silent = tiff_of_sensor(&[], 1);
    assert!(silent.refusal("").contains("has no pattern"), "{}", silent.refusal(""));
    assert_eq!(silent.open(&given("mosaic rggb")).expect("opens").size(), (4, 3));
    let odd = tiff_of_sensor(&[0, 1, 2, 1], 1);
    assert!(odd.refusal("").contains("--mosaic none"), "{}", odd.refusal(""));
    assert_eq!(odd.open(&given("mosaic none")).expect("opens").size(), (9, 7));
    assert_eq!(odd.info(&given("mosaic none")).binning, 1);
}

#[test]
fn fits_files_tell_their_mosaic_their_colours_and_their_times() {
    let sides = ["NAXIS1  =                    8", "NAXIS2  =                    6"];
    let image = |more: &[&str]| fits(&[&FITS[..], &sides, more].concat(), 48);
    for pattern in ["RGGB", "GBRG", "bggr"] {
        let file =
            Made::new("m.fits", &image(&[&format!("BAYERPAT= '{pattern}    '"), "XBAYROFF=                    1"]));
        assert_eq!(file.info(&given("")).binning, 2, "{pattern}");
        assert_eq!(file.open(&given("")).expect("opens").size(), (4, 3), "{pattern}");
        assert_eq!(file.info(&given("mosaic none")).binning, 1);
        assert_eq!(file.open(&given("mosaic none")).expect("opens").size(), (8, 6));
    }
    assert_eq!(Made::new("n.fits", &image(&["BAYERPAT= 'TRUE    '"])).info(&given("")).binning, 1);
    for (card, at) in [
        ("MJD-OBS =              40587.5", 43_200.0),
        ("DATE-OBS= '1970-01-01T12:00:00'", 43_200.0),
        ("DATE-AVG= '1970-01-01T00:00:10'", 10.0),
    ] {
        let made = Made::new("t.fits", &image(&[card]));
        let second = Made::new("t.fits", &image(&[&card.replace("87.5", "88.5").replace("01T", "02T")]));
        fs::copy(&second.path, made.folder.join("u.fits")).expect("copied");
        let info = Info::of(&[made.folder.to_path_buf()], &given(""), &quiet()).expect("described");
        assert_eq!(info.times_s, [0.0, 86_400.0], "{card}");
        assert!(at > 0.0 && info.begins.expect("a time").starts_with("1970-01-01"), "{card}");
    }
    // What only times need refuses no frame.
    for exposure in ["EXPTIME = '0,5     '", "EXPTIME ="] {
        let file = Made::new("e.fits", &image(&["DATE-OBS= '1970-01-01T12:00:00'", exposure]));
        assert_eq!(file.open(&given("")).expect("opens").len(), 1);
    }
    let cube = |more: &[&str]| {
        let three = ["NAXIS   =                    3", sides[0], sides[1], "NAXIS3  =                    3"];
        Made::new("c.fits", &fits(&[&FITS[..2], &three, more].concat(), 144))
    };
    says(cube(&[]).refusal(""), &["colours", "--axis C", "--axis last"]);
    assert_eq!(cube(&[]).open(&given("axis last")).expect("frames").len(), 3);
    for (file, options) in [(cube(&[]), "axis C"), (cube(&["CTYPE3  = 'RGB     '"]), "")] {
        let burst = file.open(&given(options)).expect("colours");
        let luma = 0.2126 * 0.0 + 0.7152 * 48.0 + 0.0722 * 96.0;
        assert_eq!((burst.len(), file.info(&given(options)).is_colour), (1, true));
        assert!((burst.frames[0].at(0, 0) * burst.full_scale - luma).abs() < 0.01, "{}", burst.frames[0].at(0, 0));
    }
}

fn ser(frames: u32, bits: u32, values: &[u16], stamps: &[u64]) -> Vec<u8> {
    let mut bytes = b"LUCAM-RECORDER".to_vec();
    [0, 0, 0, 4, 2, bits, frames].into_iter().for_each(|number| bytes.extend(number.to_le_bytes()));
    bytes.resize(178, b' ');
    bytes.extend(values.iter().flat_map(|v| v.to_le_bytes()));
    bytes.extend(stamps.iter().flat_map(|v| v.to_le_bytes()));
    bytes
}

#[test]
fn values_are_in_the_unit_of_the_file_and_dates_of_files_go_there_and_back() {
    let pgm = |largest: u32, values: &[u16]| {
        let mut bytes = format!("P5 # words\n4 1\n# more\n{largest}\n").into_bytes();
        match largest {
            256.. => bytes.extend(values.iter().flat_map(|v| v.to_be_bytes())),
            _ => bytes.extend(values.iter().map(|v| *v as u8)),
        }
        Made::new("v.pgm", &bytes)
    };
    for (largest, others) in [(1023, [512, 0]), (4095, [1, 0]), (60_000, [59_999, 1]), (100, [1, 0])] {
        let values = [64, largest as u16, others[0], others[1]];
        let (file, white) = (pgm(largest, &values), largest as f32);
        let scaled = OpenOptions { full_scale: Some(white), black_level: Some(64.0), ..OpenOptions::default() };
        let frame = file.open(&scaled).expect("opens").frames[0].clone();
        assert!(frame.at(0, 0) == 0.0 && (frame.at(1, 0) - 1.0).abs() < 1e-6, "{largest}: {:?}", frame.data());
        let plain = file.open(&given("")).expect("opens");
        assert_eq!(plain.full_scale, white);
        let is_near = |(found, value): (&f32, u16)| (found - f32::from(value) / white).abs() < 1e-7;
        assert!(plain.frames[0].data().iter().zip(values).all(is_near), "{largest}: {:?}", plain.frames[0].data());
    }
    let sides = ["NAXIS1  =                    8", "NAXIS2  =                    6"];
    let begins = |date: &str| {
        let card = format!("DATE-OBS= '{date}'");
        Made::new("d.fits", &fits(&[&FITS[..], &sides, &[card.as_str()]].concat(), 48)).info(&given("")).begins
    };
    let whole =
        ["1970-01-01T00:00:00.000", "2000-02-29T12:30:01.250", "2026-11-24T20:31:07.000", "1969-12-31T23:59:59.500"];
    whole.into_iter().for_each(|date| assert_eq!(begins(date), Some(format!("{date}Z"))));
    assert!(begins("2021-03-01").is_some() && begins("2021-03-01") == begins("2021-03-01T00:00"));
    let bad = "2021 2021-13-01 2021-01-00 2021-01-01T24:00 2021-01-01T10:61 2021-01-01T10:10:x 99999999-1-1";
    bad.split(' ').chain([""]).for_each(|bad| assert_eq!(begins(bad), None, "{bad}"));
}

#[test]
fn all_frames_of_an_animation_are_opened_with_their_times() {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 4, 3);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_animated(3, 0).expect("animated");
    encoder.set_frame_delay(1, 25).expect("a delay");
    let mut writer = encoder.write_header().expect("a header");
    [10u8, 20, 30].into_iter().for_each(|value| writer.write_image_data(&[value; 12]).expect("a frame"));
    writer.finish().expect("written");
    let file = Made::new("a.png", &bytes);
    let burst = file.open(&given("")).expect("opens");
    assert_eq!(burst.frames.iter().map(|f| (f.at(1, 1) * 255.0).round()).collect::<Vec<_>>(), [10.0, 20.0, 30.0]);
    assert_eq!((file.info(&given("")).frames, file.open(&given("take 1..3")).expect("a part").len()), (3, 2));
    let times = file.info(&given("")).times_s;
    assert!((times[2] - 0.08).abs() < 1e-9, "{times:?}");
}

#[test]
fn jpegs_without_tables_and_with_bytes_between_segments_open_as_the_same_picture() {
    let mut bytes = Vec::new();
    let picture = image::GrayImage::from_fn(40, 24, |u, v| image::Luma([(u * 5 + v * 3) as u8]));
    image::codecs::jpeg::JpegEncoder::new(&mut bytes).encode_image(&picture).expect("encoded");
    let whole = Made::new("w.jpg", &bytes).open(&given("")).expect("opens");
    // The encoder writes the usual tables.
    let (mut at, mut bare, mut loose) = (2, bytes[..2].to_vec(), bytes[..2].to_vec());
    while bytes[at + 1] != 0xda {
        let end = at + 2 + usize::from(u16::from_be_bytes([bytes[at + 2], bytes[at + 3]]));
        if bytes[at + 1] != 0xc4 {
            bare.extend(&bytes[at..end]);
        }
        loose.extend(&bytes[at..end]);
        loose.extend([0, 7, 0xff, 0, 3]);
        at = end;
    }
    bare.extend(&bytes[at..]);
    loose.extend(&bytes[at..]);
    for (name, odd) in [("bare.jpg", &bare), ("loose.jpg", &loose)] {
        let burst = Made::new(name, odd).open(&given("")).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert_eq!(burst.frames[0].data(), whole.frames[0].data(), "{name}");
        assert!(Made::new(name, &odd[..odd.len() - 9]).open(&given("")).is_err(), "a cut one is still refused");
    }
    // Lossless, and of 12 bits: sound, and not read here.
    for (marker, bits) in [(0xc3, 8), (0xc1, 12), (0xc9, 8)] {
        let mut other = bytes.clone();
        let at = other.windows(2).position(|two| two == [0xff, 0xc0]).expect("a frame");
        (other[at + 1], other[at + 4]) = (marker, bits);
        let told = Made::new("o.jpg", &other).refusal("");
        assert!(told.contains("PNG") && !told.contains("damaged"), "{told}");
    }
}

proptest! {
    #[test]
    fn no_description_panics_or_takes_other_pages_than_there_are(
        text in "(<OME( xmlns='o')?>|ImageJ=1\n|\\{\"shape\": \\[)?[ -~\n]{0,80}",
        (times, channels) in (0usize..9, 0usize..4),
        ifd in 0usize..12,
        count in prop::option::of(0usize..30),
        axis in prop::sample::select(vec!["", "axis T", "axis first", "axis C", "axis T,C=1"]),
    ) {
        let count = count.map_or(String::new(), |count| format!(" PlaneCount=\"{count}\""));
        let described = ome((times, channels), "", &format!("<TiffData IFD=\"{ifd}\"{count}/>"));
        for description in [text, described] {
            let file = Made::tiff("p.tif", 5, &description.replace('\0', ""));
            if let Ok(burst) = file.open(&given(axis)) {
                prop_assert!((1..=5).contains(&burst.len()));
            }
        }
    }
}
