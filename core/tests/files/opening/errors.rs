//! Every failure is an error that names the file, the problem and the remedy.

use super::{crafted::npy_of, support::*};
use ndarray::Array1;

/// Opens a file that must fail, and checks that the message contains all of `words`.
#[track_caller]
fn failure(path: &Path, words: &[&str]) -> Error {
    let error = Burst::open(path).expect_err("this must not open");
    says(&error, &[&path.file_name().expect("named").to_string_lossy()]);
    says(&error, words);
    error
}

#[test]
fn missing_empty_and_foreign_files_and_a_bad_picture_in_a_folder_is_named_and_never_skipped() {
    let folder = folder();
    let at = |name: &str| folder.join(name);
    failure(&at("missing.png"), &["no such file"]);
    assert!(open(&[]).expect_err("nothing").to_string().contains("nothing to open"));
    ["empty", "texts"].into_iter().for_each(|name| fs::create_dir(at(name)).expect("made"));
    failure(&at("empty"), &["no pictures", "png", "tiff", "npy"]);
    fs::write(at("texts/a.txt"), "text").expect("written");
    failure(&at("texts"), &["no pictures"]);
    for (name, content, words) in [
        ("zero.png", "", ["empty", "0 bytes"]),
        ("text.png", "this is no picture at all", ["named as a PNG", "damaged or of another kind"]),
        ("text", "this is no picture at all", ["not a picture", "convert"]),
    ] {
        fs::write(at(name), content).expect("written");
        failure(&at(name), &words);
    }
    let folder = crate::prelude::folder();
    (1..=4).for_each(|t| save(&folder.join(format!("{t}.png")), &grey8(30, 20, t)));
    let good = fs::read(folder.join("3.png")).expect("read");
    fs::write(folder.join("3.png"), &good[..good.len() / 2]).expect("written");
    let error = Burst::open(&folder).expect_err("truncated");
    assert!(error.problem.contains("PNG file is truncated") && error.subject.ends_with("3.png"), "{error}");
    // Of two bad files the first is named, whichever thread fails first.
    fs::write(folder.join("2.png"), "").expect("written");
    for _ in 0..20 {
        let error = Burst::open(&folder).expect_err("two bad ones");
        assert!(error.problem.contains("empty") && error.subject.ends_with("2.png"), "{error}");
    }
    #[cfg(unix)]
    {
        fs::remove_file(folder.join("2.png")).expect("removed");
        std::os::unix::fs::symlink("nowhere", folder.join("2.png")).expect("linked");
        let error = Burst::open(&folder).expect_err("a link to nowhere");
        assert!(error.kind == ErrorKind::NotFound && error.subject.ends_with("2.png"), "{error}");
    }
}

#[test]
fn a_number_of_a_text_picture_that_may_be_cut_is_refused() {
    let (folder, path) = folder_with("a.pgm");
    let whole = "P2\n# words\n3 2\n300\n10 20 30\n40 50 256\n";
    for end in whole.len() - 6..whole.len() {
        fs::write(&path, &whole[..end]).expect("written");
        failure(&path, &["PNM", "truncated or damaged"]);
    }
    fs::write(&path, whole.trim_end()).expect("written");
    failure(&path, &["no space or line end follows its last number"]);
    for after in ["\n", " ", "\r\n", "\t\n"] {
        fs::write(&path, format!("{}{after}", whole.trim_end())).expect("written");
        let value = Burst::open(&path).expect("whole").frames[0].at(2, 1);
        assert!((value - 256.0 / 300.0).abs() < 1e-5, "{value}: the decoder gives 65535 levels");
    }
    fs::write(folder.join("a.ppm"), "P3\n1 1\n99\n1 2 34").expect("written");
    failure(&folder.join("a.ppm"), &["no space or line end follows its last number"]);
    // Samples of one digit cannot be cut, and binary ones may be any byte.
    for (name, content) in [("a.pbm", "P1\n2 1\n1 0"), ("b.pgm", "P5\n2 1\n255\n12")] {
        fs::write(folder.join(name), content).expect("written");
        assert_eq!(Burst::open(folder.join(name)).expect("whole").size(), (2, 1));
    }
}

#[cfg(unix)]
#[test]
fn a_pipe_is_refused_instead_of_waited_for() {
    let (_socket, path) = folder_with("pipe.png");
    let _listener = std::os::unix::net::UnixListener::bind(&path).expect("a socket");
    failure(&path, &["neither a regular file nor a folder"]);
    failure(Path::new("/dev/null"), &["neither a regular file nor a folder"]);
}

#[test]
fn different_sizes_units_and_kinds_of_one_burst_are_refused_by_their_names() {
    let folder = folder();
    save(&folder.join("1.png"), &grey8(30, 20, 0));
    save(&folder.join("2.png"), &grey8(30, 21, 0));
    says(Burst::open(&folder).expect_err("sizes differ"), &["1.png", "30×20", "2.png", "30×21"]);
    let stack = folder.join("pages.tif");
    let mut encoder = TiffEncoder::new(fs::File::create(&stack).expect("created")).expect("begins");
    for rows in [2, 3] {
        encoder.write_image::<colortype::Gray8>(2, rows, &vec![0; 2 * rows as usize]).expect("page");
    }
    drop(encoder);
    failure(&stack, &["(page 1)", "2×2", "(page 2)", "2×3"]);
    let folder = crate::prelude::folder();
    save(&folder.join("1.png"), &grey8(2, 1, 0));
    write_npy(folder.join("2.npy"), &Array2::from_elem((1, 2), 300.0f32)).expect("written");
    let error = Burst::open(&folder).expect_err("no common unit");
    assert!(error.problem.contains("no unit in common") && error.remedy.ends_with("2.npy"), "{error}");
    let (folder, file) = folder_with("a.png");
    save(&file, &grey8(2, 2, 0));
    says(open(&[file, folder.to_path_buf()]).expect_err("mixed").problem, &["either folders or files"]);
}

#[test]
fn infinite_values_are_located_and_arrays_of_other_shapes_and_types_refused() {
    let (folder, path) = folder_with("a.npy");
    for (value, word) in [(f32::INFINITY, "inf"), (f32::NEG_INFINITY, "-inf")] {
        let mut stack = Array3::<f32>::zeros((3, 4, 5));
        (stack[[1, 3, 2]], stack[[2, 0, 0]]) = (value, value);
        write_npy(&path, &stack).expect("written");
        failure(&path, &["frame 1", "(2, 3)", word]);
    }
    write_npy(&path, &Array2::from_elem((2, 2), 1e300f64)).expect("written");
    failure(&path, &["frame 0", "(0, 0)", "inf"]);
    let path = folder.join("a.tif");
    tiff_pages::<colortype::Gray32Float>(&path, (2, 1), &[vec![0.0, 0.5], vec![f32::NAN, f32::INFINITY]]);
    failure(&path, &["frame 1", "(1, 0)", "inf"]);
    write_npy(&path, &Array1::<f32>::zeros(5)).expect("written");
    failure(&path, &["[5]", "[frames, rows, columns]"]);
    for shape in [(2, 3, 4, 5), (5, 40, 60, 2), (5, 40, 60, 8)] {
        // A last axis of channels is neither views nor time.
        write_npy(&path, &Array4::<u8>::zeros(shape)).expect("written");
        failure(&path, &[&format!("{shape:?}").replace('(', "[").replace(')', "]")]);
    }
    for (shape, words) in [((0, 3, 4), "[0, 3, 4]"), ((2, 0, 4), "no pixels (4×0)")] {
        write_npy(&path, &Array3::<u8>::zeros(shape)).expect("written");
        failure(&path, &[words]);
    }
    for (kind, says) in [("'<c8'", "<c8"), ("[('x', '|u1')]", "type 'record'")] {
        fs::write(&path, npy_of(kind, "False", "2, 2", &[])).expect("written");
        failure(&path, &[says, "uint16 or float32"]);
    }
    write_npy(&path, &Array3::<f64>::from_elem((2, 3, 4), 1e300)).expect("written");
    failure(&path, &["beyond 3.4e38", "pixel (0, 0)"]);
}

#[test]
fn complex_samples_and_an_image_list_that_imagej_left_out_are_told() {
    let (_folder, path) = folder_with("complex.tif");
    // 2×2 pixels of two floats each, at byte 8 + 2 + 10·12 + 4.
    let entries =
        [(256, 2), (257, 2), (258, 64), (259, 1), (262, 1), (273, 134), (277, 1), (278, 2), (279, 32), (339, 6)];
    let bytes = super::crafted::directory(&entries.map(|(tag, value)| (tag, 4, 1, value)), 134 + 32);
    fs::write(&path, &bytes).expect("written");
    failure(&path, &["complex", "magnitude"]);
    let described = Info::of(&[path], &OpenOptions::default(), &quiet()).expect_err("described as it opens");
    assert!(described.problem.contains("complex"), "{described}");
    let (_folder, path) = folder_with("imagej.tif");
    let mut encoder = TiffEncoder::new(fs::File::create(&path).expect("created")).expect("begins");
    let mut image = encoder.new_image::<colortype::Gray8>(2, 1).expect("page");
    let description = "ImageJ=1.54f\nimages=7\nslices=7\n";
    image.encoder().write_tag(Tag::ImageDescription, description).expect("tag");
    image.write_data(&[1, 2]).expect("page");
    drop(encoder);
    failure(&path, &["7 depths", "--axis Z"]);
    let along = OpenOptions { axis: Some("Z".parse().expect("an axis")), ..OpenOptions::default() };
    let told = Burst::open_with(&[path], &along, &quiet()).expect_err("they are not there").to_string();
    assert!(told.contains("14 bytes of values are announced"), "{told}");
}

#[test]
fn limits_are_checked_before_memory_is_taken() {
    let folder = folder();
    let limits = Limits { max_side_px: 50, max_pixels: 1000, max_frames: 3, max_bytes: 8000 };
    let options = OpenOptions { limits, ..OpenOptions::default() };
    let fails = |path: &Path, word: &str| {
        let error = Burst::open_with(&[path.into()], &options, &quiet()).expect_err(word);
        assert_eq!(error.kind, ErrorKind::TooLarge, "{error}");
        assert!(error.to_string().contains(word), "{error}");
    };
    let at = |name: &str| folder.join(name);
    save(&at("wide.png"), &grey8(51, 2, 0));
    fails(&at("wide.png"), "51×2");
    save(&at("large.tif"), &grey8(40, 30, 0));
    fails(&at("large.tif"), "40×30");
    write_npy(at("long.npy"), &Array3::<u8>::zeros((4, 2, 2))).expect("written");
    fails(&at("long.npy"), "4 frames");
    tiff_pages::<colortype::Gray8>(&at("long.tif"), (2, 2), &vec![vec![0; 4]; 4]);
    fails(&at("long.tif"), "4 frames");
    fs::create_dir(at("many")).expect("made");
    (0..3).for_each(|t| save(&at(&format!("many/{t}.png")), &grey8(30, 30, 0)));
    fails(&at("many"), "3 × 30×30");
    fs::create_dir(at("edge")).expect("made");
    (0..2).for_each(|t| save(&at(&format!("edge/{t}.png")), &grey8(50, 20, 0)));
    assert_eq!(Burst::open_with(&[at("edge")], &options, &quiet()).expect("within the limits").len(), 2);
    // A few bytes that announce a huge picture, against the default limits.
    fs::write(at("giant.pam"), "P7\nWIDTH 200000\nHEIGHT 200000\nDEPTH 1\nMAXVAL 255\nENDHDR\n").expect("written");
    assert_eq!(failure(&at("giant.pam"), &["200000×200000"]).kind, ErrorKind::TooLarge);
    fs::write(at("giant.npy"), npy_of("'<f8'", "True", "4000, 16000, 16000", &[])).expect("written");
    assert_eq!(failure(&at("giant.npy"), &["MiB"]).kind, ErrorKind::TooLarge);
}
