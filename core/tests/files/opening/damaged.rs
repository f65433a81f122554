//! Truncated or damaged files are refused, and files that announce huge contents take little memory.

use super::{crafted, support::*};

/// A progressive JPEG of 45×37 with chroma of half the size.
pub const PROGRESSIVE: &[u8] = include_bytes!("samples/progressive.jpg");

fn accepting() -> OpenOptions {
    OpenOptions { accept_damaged: true, ..OpenOptions::default() }
}

fn noise() -> ImageBuffer<Rgb<u8>, Vec<u8>> {
    ImageBuffer::from_fn(40, 30, |u, v| Rgb([(u * 37 + v * 91) as u8, (u * v) as u8, v as u8]))
}

/// Writes one sound file of each format into `folder`; returns their names.
fn one_of_each(folder: &Path) -> Vec<&'static str> {
    let at = |name: &str| folder.join(name);
    let deep: ImageBuffer<Luma<u16>, _> = ImageBuffer::from_fn(40, 30, |u, v| Luma([(u * 1500 + v * 977) as u16]));
    let pictures = ["8.png", "8.jpg", "8.tif", "8.ppm", "8.webp", "8.bmp"];
    pictures.iter().for_each(|name| save(&at(name), &noise()));
    ["16.png", "16.pgm", "16.tif"].iter().for_each(|name| save(&at(name), &deep));
    fs::write(at("progressive.jpg"), PROGRESSIVE).expect("written");
    tiff_pages::<colortype::Gray16>(&at("pages.tif"), (40, 30), &[vec![7; 1200], vec![9; 1200], vec![2; 1200]]);
    let mut big = TiffEncoder::new_big(fs::File::create(at("big.tif")).expect("made")).expect("begins");
    big.write_image::<colortype::Gray16>(40, 30, &[500; 1200]).expect("a page");
    write_npy(at("stack.npy"), &Array3::<u16>::ones((3, 20, 30))).expect("written");
    let mut names = pictures.to_vec();
    names.extend(["16.png", "16.pgm", "16.tif", "progressive.jpg", "pages.tif", "big.tif", "stack.npy"]);
    #[cfg(feature = "raw")]
    {
        let dng = super::dng::Dng::new((40, 30), |u, v| (64 + 31 * u + 7 * v) as u16);
        fs::write(at("raw.dng"), dng.bytes()).expect("written");
        names.push("raw.dng");
    }
    names
}

#[test]
fn what_is_cut_off_is_refused_in_every_format_wherever_it_is_cut() {
    let folder = folder();
    for name in one_of_each(&folder) {
        let path = folder.join(name);
        open(from_ref(&path)).unwrap_or_else(|e| panic!("sound: {e}"));
        let bytes = fs::read(&path).expect("read");
        let parts = [2, 10, 25, 50, 75, 90, 99].map(|percent| bytes.len() * percent / 100);
        for cut in parts.into_iter().chain([bytes.len() - 2, bytes.len() - 1]) {
            fs::write(&path, &bytes[..cut]).expect("written");
            // Even with the option to accept damaged files only JPEGs are accepted.
            let is_jpeg = name.ends_with("jpg");
            let all = [OpenOptions::default(), accepting()];
            for options in &all[..if is_jpeg { 1 } else { 2 }] {
                let Err(error) = open_with(&path, options) else {
                    panic!("{name} cut to {cut} of {} opens", bytes.len());
                };
                says(&error, &[name, "copy it again"]);
                assert_eq!(error.kind, ErrorKind::Damaged, "{name} cut to {cut}: {error:?}");
            }
        }
    }
}

#[test]
fn what_begins_wrongly_is_damaged_and_need_not_be_converted() {
    let folder = folder();
    for name in one_of_each(&folder) {
        let path = folder.join(name);
        let mut bytes = fs::read(&path).expect("read");
        bytes[..4].fill(0);
        let anonymous = folder.join("no extension");
        fs::write(&path, &bytes).expect("written");
        fs::write(&anonymous, &bytes).expect("written");
        let told = |path: &Path| open(&[path.to_path_buf()]).expect_err(name).to_string();
        assert!(told(&path).contains("copy it again") && !told(&path).contains("convert"), "{}", told(&path));
        // A PNG is known by what follows its signature.
        assert_eq!(told(&anonymous).contains("this PNG file is truncated or damaged"), name.ends_with("png"));
    }
}

#[test]
fn a_jpeg_whose_codes_lead_nowhere_is_refused_and_what_follows_its_end_is_not_read() {
    let (_folder, path) = folder_with("a.jpg");
    save(&path, &noise());
    for sound in [fs::read(&path).expect("read"), PROGRESSIVE.to_vec()] {
        let start = sound.windows(2).position(|two| two == [0xff, 0xda]).expect("picture data") + 14;
        // Ones alone are a code of no table.
        let ones = [0xff, 0].repeat(16);
        fs::write(&path, [&sound[..start], &ones, &sound[start..]].concat()).expect("written");
        let error = open(from_ref(&path)).expect_err("codes of no table");
        assert!(error.problem.contains("this JPEG file is truncated or damaged"), "{error}");
        // Bytes after the end of the picture are ignored.
        fs::write(&path, [&sound[..], b"a film"].concat()).expect("written");
        open(from_ref(&path)).expect("whole");
    }
}

#[test]
fn damaged_jpegs_are_taken_where_that_is_asked_for_and_named_and_jpegs_within_a_tiff_must_be_whole_too() {
    let folder = folder();
    (0..3).for_each(|t| save(&folder.join(format!("{t}.jpg")), &noise()));
    let path = folder.join("1.jpg");
    let sound = fs::read(&path).expect("read");
    fs::write(&path, &sound[..sound.len() / 2]).expect("written");
    let error = Burst::open(&folder).expect_err("cut");
    assert!(error.kind == ErrorKind::Damaged && error.subject.ends_with("1.jpg"), "{error}");
    let burst = open_with(&folder, &accepting()).expect("taken");
    let [remark] = &burst.remarks[..] else { panic!("{:?}", burst.remarks) };
    assert!(remark.frame == 1 && matches!(remark.kind, RemarkKind::Damaged(_)), "{remark:?}");
    // The intact part is unchanged; the rest is grey.
    assert_eq!(burst.frames[1].row(0), burst.frames[0].row(0));
    assert_ne!(burst.frames[1].row(29), burst.frames[0].row(29));
    let notes: String = burst.notes().iter().map(Note::for_command).collect();
    says(notes, &["1 of 3 frames are damaged", "1.jpg (its end marker is missing"]);
    let whole = open_with(folder.join("0.jpg").as_path(), &accepting()).expect("sound");
    assert!(whole.remarks.is_empty());
    let mut jpeg = Vec::new();
    grey8(40, 30, 3).write_to(&mut std::io::Cursor::new(&mut jpeg), image::ImageFormat::Jpeg).expect("a JPEG");
    let path = folder.join("a.tif");
    let write = |strip: &[u8]| {
        let mut bytes = raw_tiff(false, (40, 30), &[8], &[(262, 1)], &[strip]);
        let compression = [3, 1, 3, 0, 1, 0, 0, 0]; // tag 259, one short
        let at = bytes.windows(8).position(|entry| entry == compression).expect("the entry") + 8;
        bytes[at] = 7;
        fs::write(&path, bytes).expect("written");
    };
    write(&jpeg);
    open(from_ref(&path)).expect("whole");
    let start = jpeg.windows(2).position(|two| two == [0xff, 0xda]).expect("picture data");
    write(&jpeg[..(start + jpeg.len()) / 2]);
    says(open(from_ref(&path)).expect_err("cut").problem, &["this TIFF file is truncated or damaged"]);
    assert_eq!(open_with(&path, &accepting()).expect("taken").remarks.len(), 1);
}

#[test]
fn a_name_that_says_another_kind_is_noted_and_nothing_more_and_a_long_text_in_a_tiff_harms_nobody() {
    let folder = folder();
    let at = |name: &str| folder.join(name);
    save(&at("a.jpg"), &noise());
    fs::rename(at("a.jpg"), at("1.png")).expect("renamed");
    save(&at("2.jpg"), &noise());
    let burst = Burst::open(&folder).expect("opens");
    let [remark] = &burst.remarks[..] else { panic!("{:?}", burst.remarks) };
    assert_eq!((remark.frame, &remark.kind), (0, &RemarkKind::Misnamed("JPEG")));
    let words = burst.notes().iter().map(|note| note.for_window()).collect::<String>();
    assert!(words.contains("1 of 2 frames are of another kind than their names say: 1.png is JPEG"), "{words}");
    // A single file takes another code path.
    assert_eq!(Burst::open(at("1.png")).expect("opens").remarks.len(), 1);
    assert!(Burst::open(at("2.jpg")).expect("opens").remarks.is_empty());
    let (_folder, path) = folder_with("a.tif");
    let mut encoder = TiffEncoder::new(fs::File::create(&path).expect("created")).expect("begins");
    let mut page = encoder.new_image::<colortype::Gray8>(2, 1).expect("page");
    page.encoder().write_tag(Tag::ImageDescription, &*"x".repeat(3 << 20)).expect("tag");
    page.write_data(&[1, 2]).expect("page");
    drop(encoder);
    let limits = Limits { max_pixels: 1 << 10, ..Default::default() };
    open_with(&path, &OpenOptions { limits, ..OpenOptions::default() }).expect("a long text harms nobody");
}

#[test]
fn a_damaged_png_is_called_so_and_what_stands_beside_its_pixels_is_not_unpacked() {
    let (_folder, path) = folder_with("a.png");
    save(&path, &noise());
    let sound = fs::read(&path).expect("read");
    // Line ends changed and a bit lost, as by transfers as text; only the signature; a changed chunk.
    let changed = |change: &dyn Fn(&mut Vec<u8>)| {
        let mut bytes = sound.clone();
        change(&mut bytes);
        fs::write(&path, bytes).expect("written");
        let words = open(from_ref(&path)).expect_err("damaged").to_string();
        assert!(words.contains("PNG") && words.contains("damaged") && !words.contains("convert it to PNG"), "{words}");
    };
    changed(&|bytes| drop(bytes.drain(4..5)));
    changed(&|bytes| bytes[0] = 0x09);
    changed(&|bytes| bytes[..8].fill(0));
    changed(&|bytes| bytes[16] ^= 1);
    changed(&|bytes| bytes[12..16].fill(b'x'));
    changed(&|bytes| bytes[sound.len() / 2] ^= 0x10);
    // 64 MiB of each; more would only make the test slow where it fails.
    let bytes = crafted::packed_chunks_png(64 << 20);
    assert!(bytes.len() < 1 << 20, "{}", bytes.len());
    fs::write(&path, bytes).expect("written");
    let before = peak();
    let burst = Burst::open(&path).expect("sound");
    assert_eq!((burst.size(), burst.frames[0].at(3, 2)), ((8, 8), 62.0 / 255.0));
    assert!(peak() < before + (32 << 20), "{} MiB", peak() >> 20);
}

#[test]
fn files_that_announce_much_are_refused_at_once() {
    let folder = folder();
    let refused = |name: &str, bytes: Vec<u8>, word: &str| {
        let path = folder.join(name);
        fs::write(&path, bytes).expect("written");
        let error = open(&[path]).expect_err(name);
        assert_eq!(error.kind, ErrorKind::Damaged, "{error:?}");
        assert!(error.to_string().contains(word) && error.to_string().contains(name), "{error}");
    };
    for kind in [5, 10, 12] {
        let bytes = crafted::huge_count_dng(kind);
        assert_eq!(bytes.len(), 226);
        refused("bad.dng", bytes.clone(), "4294967295 values");
        refused("bad.tif", bytes.clone(), "4294967295 values");
        refused("bad.nef", bytes, "4294967295 values");
    }
    refused("text.tif", crafted::huge_description_tiff(), "tag 270");
    let encoded = |format| {
        let mut bytes = Vec::new();
        grey8(8, 8, 0).write_to(&mut std::io::Cursor::new(&mut bytes), format).expect("encoded");
        bytes
    };
    let mut bmp = encoded(image::ImageFormat::Bmp);
    bmp[18..26].copy_from_slice(&[16000i32.to_le_bytes(), 16000i32.to_le_bytes()].concat());
    refused("few.bmp", bmp, "too few for 16000×16000 pixels");
    refused("few.pgm", b"P5 16000 16000 255\n".to_vec(), "too few for 16000×16000 pixels");
    let mut png = encoded(image::ImageFormat::Png);
    png[16..24].copy_from_slice(&[0, 0, 0x3e, 0x80, 0, 0, 0x3e, 0x80]);
    refused("few.png", png, "CRC");
    let mut jpeg = encoded(image::ImageFormat::Jpeg);
    let frame = jpeg.windows(2).position(|two| two == [0xff, 0xc0]).expect("its size");
    jpeg[frame + 5..frame + 9].copy_from_slice(&[0x3e, 0x80, 0x3e, 0x80]);
    refused("few.jpg", jpeg, "too few for 16000×16000 pixels");
}

/// The peak memory of this process, bytes; 0 where the system does not tell.
fn peak() -> u64 {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    line.and_then(|line| line.trim().trim_end_matches(" kB").trim().parse::<u64>().ok()).map_or(0, |kb| kb << 10)
}

#[test]
fn frames_of_different_bits_are_refused_unless_a_full_scale_says_their_unit() {
    let folder = folder();
    let at = |name: &str| folder.join(name);
    let eight: ImageBuffer<Luma<u8>, _> = ImageBuffer::from_pixel(2, 1, Luma([200]));
    save(&at("1.png"), &eight);
    save(&at("2.png"), &ImageBuffer::from_pixel(2, 1, Luma([4000u16])));
    says(Burst::open(&folder).expect_err("no common unit"), &["1.png", "2.png", "8 bit", "16 bit", "full scale"]);
    let options = OpenOptions { full_scale: Some(4000.0), ..OpenOptions::default() };
    let burst = open_with(&folder, &options).expect("values of one unit");
    assert_eq!((burst.frames[0].at(0, 0), burst.frames[1].at(0, 0)), (0.05, 1.0));
    // Pages of one file.
    let stack = at("pages.tif");
    let mut encoder = TiffEncoder::new(fs::File::create(&stack).expect("created")).expect("begins");
    encoder.write_image::<colortype::Gray8>(2, 1, &[0; 2]).expect("page");
    encoder.write_image::<colortype::Gray16>(2, 1, &[0; 2]).expect("page");
    drop(encoder);
    says(Burst::open(&stack).expect_err("no common unit").problem, &["this frame has 8 bit", "pages.tif"]);
    // Integers of many bits and floats.
    write_npy(at("a.npy"), &Array2::from_elem((1, 2), 7u32)).expect("written");
    write_npy(at("b.npy"), &Array2::from_elem((1, 2), 0.5f32)).expect("written");
    says(open(&[at("a.npy"), at("b.npy")]).expect_err("no common unit").problem, &["this one has floats"]);
}

/// A decoder of raw files reads notes that go on behind the end of a file as far as they are there, and makes room for
/// what their entries announce.
#[cfg(feature = "raw")]
#[test]
fn notes_that_go_on_behind_the_end_are_not_left_to_a_decoder() {
    let behind: &[_] = &[
        (34665, 14, 1, 0x010a),
        (0x4686, 18, 5, 0x5716_eb8a),
        (34665, 5, 0, 0x0080_0000),
        (0x6a89, 6, 0, 0xffd2_89dc),
        (34665, 1, 5, 123),
    ];
    // Four bytes of an unknown type, the first of which is taken for the place of notes.
    let unknown: &[_] = &[(320, 4, 0, 247), (34665, 16, 4, 0x57de_b116)];
    let (_folder, path) = folder_with("notes.dng");
    for (entries, length) in [(behind, 74), (unknown, 224)] {
        fs::write(&path, crafted::directory(entries, length)).expect("written");
        says(Burst::open(&path).expect_err("nothing is in it"), &["announces"]);
    }
}
