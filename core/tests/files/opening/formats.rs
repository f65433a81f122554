//! Round trips: files written in each format are read with the right values, order and full scale; the frames that an
//! input names, their order, and the names of bursts.

use super::support::*;
use image::{LumaA, Rgba};
use ndarray::ShapeBuilder;

#[test]
fn lossless_pictures_of_8_bit_are_exact() {
    let folder = folder();
    for name in ["a.png", "a.bmp", "a.pgm", "a.tiff", "A.PNG"] {
        let path = folder.join(name);
        save(&path, &grey8(5, 4, 30));
        let burst = Burst::open(&path).expect(name);
        assert_eq!((burst.len(), burst.size(), burst.full_scale), (1, (5, 4), 255.0), "{name}");
        assert_eq!(burst.quantisation_step, 1.0 / 255.0);
        assert_eq!(burst.frame_names, [name]);
        for v in 0..4 {
            for u in 0..5 {
                assert_eq!(burst.frames[0].at(u, v), (30 + 10 * v + u) as f32 / 255.0, "{name}");
            }
        }
    }
    // Grey is exact as a colour too, whatever its alpha.
    let [rgb, rgba, grey_alpha] = ["rgb.png", "rgba.png", "la.png"].map(|name| folder.join(name));
    save(&rgb, &ImageBuffer::from_fn(256, 1, |u, _| Rgb([u as u8; 3])));
    save(&rgba, &ImageBuffer::from_fn(256, 1, |u, _| Rgba([u as u8, u as u8, u as u8, 255 - u as u8])));
    save(&grey_alpha, &ImageBuffer::from_fn(256, 1, |u, _| LumaA([u as u8, 7])));
    for path in [rgb, rgba, grey_alpha] {
        let burst = Burst::open(&path).expect("opens");
        assert!((0..256).all(|n| burst.frames[0].at(n, 0) == n as f32 / 255.0), "{}", path.display());
    }
}

#[test]
fn pictures_of_16_bit_are_exact() {
    let folder = folder();
    let values: Vec<u16> = vec![0, 1, 255, 256, 4095, 65535];
    let image: ImageBuffer<Luma<u16>, _> = ImageBuffer::from_raw(3, 2, values.clone()).expect("six values");
    for name in ["a.png", "a.pgm", "a.tif"] {
        let path = folder.join(name);
        save(&path, &image);
        let burst = Burst::open(&path).expect(name);
        assert_eq!((burst.full_scale, burst.quantisation_step), (65535.0, 1.0 / 65535.0), "{name}");
        let expected: Vec<f32> = values.iter().map(|v| f32::from(*v) / 65535.0).collect();
        assert_eq!(burst.frames[0].data(), expected, "{name}");
    }
}

#[test]
fn colour_becomes_luma_and_alpha_is_ignored() {
    let folder = folder();
    let colours = [[255, 0, 0], [0, 255, 0], [0, 0, 255], [9, 9, 9]];
    let expected = [LUMA_WEIGHTS[0], LUMA_WEIGHTS[1], LUMA_WEIGHTS[2], 9.0 / 255.0];
    let rgb = ImageBuffer::from_fn(4, 1, |u, _| Rgb(colours[u as usize]));
    let rgba = ImageBuffer::from_fn(4, 1, |u, _| {
        let [r, g, b] = colours[u as usize];
        Rgba([r, g, b, 60 * u as u8])
    });
    for name in ["a.png", "a.bmp", "a.ppm", "a.webp", "a.tif"] {
        save(&folder.join(name), &rgb);
        assert_close(Burst::open(folder.join(name)).expect(name).frames[0].data(), &expected);
    }
    for name in ["b.png", "b.webp", "b.tif"] {
        save(&folder.join(name), &rgba);
        assert_close(Burst::open(folder.join(name)).expect(name).frames[0].data(), &expected);
    }
    let deep = ImageBuffer::from_fn(4, 1, |u, _| Rgb(colours[u as usize].map(|c| u16::from(c) * 257)));
    for name in ["c.png", "c.tif"] {
        save(&folder.join(name), &deep);
        assert_close(Burst::open(folder.join(name)).expect(name).frames[0].data(), &expected);
    }
    let grey_alpha = ImageBuffer::from_fn(3, 1, |u, _| LumaA([100 * u as u8, 7]));
    save(&folder.join("d.png"), &grey_alpha);
    let burst = Burst::open(folder.join("d.png")).expect("grey with alpha");
    assert_eq!(burst.frames[0].data(), [0.0, 100.0 / 255.0, 200.0 / 255.0]);
}

#[test]
fn jpeg_is_near() {
    let (_folder, path) = folder_with("a.jpg");
    save(&path, &ImageBuffer::from_fn(64, 48, |u, v| Luma([(u + v) as u8])));
    let burst = Burst::open(&path).expect("jpeg");
    assert_eq!((burst.size(), burst.full_scale), ((64, 48), 255.0));
    let worst = (0..48).flat_map(|v| (0..64).map(move |u| (u, v)));
    let worst = worst.map(|(u, v)| (burst.frames[0].at(u, v) - (u + v) as f32 / 255.0).abs()).fold(0.0, f32::max);
    assert!(worst < 4.0 / 255.0, "{worst}");
}

#[test]
fn multi_page_tiffs_of_every_type_come_back() {
    let (_folder, path) = folder_with("stack.tif");
    let expect = |full_scale: f32, step: f32, pages: [[f32; 2]; 3]| {
        let burst = Burst::open(&path).expect("opens");
        assert_eq!((burst.len(), burst.size(), burst.name.as_str()), (3, (2, 1), "stack"));
        assert_eq!((burst.full_scale, burst.quantisation_step), (full_scale, step));
        burst.frames.iter().zip(pages).for_each(|(frame, page)| assert_close(frame.data(), &page));
        assert_eq!(burst.frame_names[2], "stack.tif [2]");
    };
    let size = (2, 1);
    tiff_pages::<colortype::Gray8>(&path, size, &[vec![0, 51], vec![102, 153], vec![204, 255]]);
    expect(255.0, 1.0 / 255.0, [[0.0, 0.2], [0.4, 0.6], [0.8, 1.0]]);
    tiff_pages::<colortype::Gray16>(&path, size, &[vec![0, 13107], vec![26214, 39321], vec![52428, 65535]]);
    expect(65535.0, 1.0 / 65535.0, [[0.0, 0.2], [0.4, 0.6], [0.8, 1.0]]);
    tiff_pages::<colortype::GrayI16>(&path, size, &[vec![-32767, 0], vec![0, 0], vec![0, 32767]]);
    expect(32767.0, 1.0 / 32767.0, [[-1.0, 0.0], [0.0, 0.0], [0.0, 1.0]]);
    // Integers of 32 bit are relative to their own largest value.
    tiff_pages::<colortype::Gray32>(&path, size, &[vec![0, 200], vec![400, 600], vec![800, 1000]]);
    expect(1000.0, 1.0 / 1000.0, [[0.0, 0.2], [0.4, 0.6], [0.8, 1.0]]);
    // Floats in [0, 1] are kept, with some noise around; others are divided by the largest value.
    tiff_pages::<colortype::Gray32Float>(&path, size, &[vec![-0.1, 0.2], vec![0.4, 0.6], vec![0.8, 1.1]]);
    expect(1.0, 0.0, [[-0.1, 0.2], [0.4, 0.6], [0.8, 1.1]]);
    tiff_pages::<colortype::Gray32Float>(&path, size, &[vec![0.0, 50.0], vec![100.0, 150.0], vec![200.0, 250.0]]);
    expect(250.0, 0.0, [[0.0, 0.2], [0.4, 0.6], [0.8, 1.0]]);
    // A bad pixel far below 0 says nothing of the full scale.
    tiff_pages::<colortype::Gray32Float>(&path, size, &[vec![-5.0, 0.2], vec![0.4, 0.6], vec![0.8, 1.0]]);
    expect(1.0, 0.0, [[-5.0, 0.2], [0.4, 0.6], [0.8, 1.0]]);
    tiff_pages::<colortype::Gray32Float>(&path, size, &[vec![-900.0, 50.0], vec![100.0, 150.0], vec![200.0, 250.0]]);
    expect(250.0, 0.0, [[-3.6, 0.2], [0.4, 0.6], [0.8, 1.0]]);
    tiff_pages::<colortype::Gray64Float>(&path, size, &[vec![0.0, 0.2], vec![0.4, 0.6], vec![0.8, 1.0]]);
    expect(1.0, 0.0, [[0.0, 0.2], [0.4, 0.6], [0.8, 1.0]]);
    let rgb = |a: u8, b: u8| vec![a, a, a, b, b, b];
    tiff_pages::<colortype::RGB8>(&path, size, &[rgb(0, 51), rgb(102, 153), rgb(204, 255)]);
    expect(255.0, 1.0 / 255.0, [[0.0, 0.2], [0.4, 0.6], [0.8, 1.0]]);
}

#[test]
fn a_long_tiff_keeps_its_order() {
    let (_folder, path) = folder_with("long.tiff");
    let pages: Vec<Vec<u16>> = (0..200).map(|t| vec![t * 300; 12]).collect();
    tiff_pages::<colortype::Gray16>(&path, (4, 3), &pages);
    let burst = Burst::open(&path).expect("opens");
    assert_eq!(burst.len(), 200);
    for (t, frame) in burst.frames.iter().enumerate() {
        assert!(frame.data().iter().all(|v| *v == (t * 300) as f32 / 65535.0), "frame {t}");
    }
}

#[test]
fn thumbnails_in_a_tiff_are_left_out() {
    let (_folder, path) = folder_with("with_thumbnail.tif");
    let mut encoder = TiffEncoder::new(fs::File::create(&path).expect("created")).expect("begins");
    encoder.write_image::<colortype::Gray8>(4, 2, &[7; 8]).expect("page");
    let mut thumbnail = encoder.new_image::<colortype::Gray8>(2, 1).expect("thumbnail");
    thumbnail.encoder().write_tag(Tag::NewSubfileType, 1u32).expect("tag");
    thumbnail.write_data(&[1, 2]).expect("thumbnail");
    let burst = Burst::open(&path).expect("opens");
    assert_eq!((burst.len(), burst.size()), (1, (4, 2)));
}

#[test]
fn npy_stacks_of_every_type_come_back() {
    let (_folder, path) = folder_with("stack.npy");
    let index = |(t, v, u): (usize, usize, usize)| 100 * t + 10 * v + u;
    let check = |full_scale: f32, scale: f32, step: f32, what: &str| {
        let burst = Burst::open(&path).expect(what);
        assert_eq!((burst.len(), burst.size()), (2, (4, 3)), "{what}");
        assert_eq!((burst.full_scale, burst.quantisation_step), (full_scale, step), "{what}");
        for (t, frame) in burst.frames.iter().enumerate() {
            let expected: Vec<f32> = (0..12).map(|i| index((t, i / 4, i % 4)) as f32 * scale / full_scale).collect();
            assert_close(frame.data(), &expected);
        }
    };
    macro_rules! roundtrip {
        ($($type:ty: $full_scale:expr, $step:expr;)*) => { $(
            let array = Array3::from_shape_fn((2, 3, 4), |i| index(i) as $type);
            write_npy(&path, &array).expect("written");
            check($full_scale, 1.0, $step, stringify!($type));
            let fortran = Array3::from_shape_fn((2, 3, 4).f(), |i| index(i) as $type);
            write_npy(&path, &fortran).expect("written");
            check($full_scale, 1.0, $step, concat!(stringify!($type), " in Fortran order"));
        )* };
    }
    roundtrip! {
        u8: 255.0, 1.0 / 255.0;
        u16: 65535.0, 1.0 / 65535.0;
        i16: 32767.0, 1.0 / 32767.0;
        u32: 123.0, 1.0 / 123.0;
        i32: 123.0, 1.0 / 123.0;
        u64: 123.0, 1.0 / 123.0;
        i64: 123.0, 1.0 / 123.0;
        f32: 123.0, 0.0;
        f64: 123.0, 0.0;
    }
    let array = Array3::from_shape_fn((2, 3, 4), |i| index(i) as f64 / 200.0);
    write_npy(&path, &array).expect("written");
    check(1.0, 1.0 / 200.0, 0.0, "floats in [0, 1]");
    write_npy(&path, &Array3::from_elem((2, 3, 4), true)).expect("written");
    let burst = Burst::open(&path).expect("booleans");
    assert!(burst.frames.iter().all(|f| f.data().iter().all(|v| *v == 1.0)));
}

#[test]
fn npy_of_other_byte_order_and_of_half_floats() {
    let (_folder, path) = folder_with("a.npy");
    let write = |descr: &str, shape: &str, data: &[u8]| {
        let header = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': {shape}, }}\n");
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend((header.len() as u16).to_le_bytes());
        bytes.extend(header.as_bytes());
        bytes.extend(data);
        fs::write(&path, bytes).expect("written");
        Burst::open(&path).expect(descr).frames[0].data().to_vec()
    };
    assert_eq!(write(">u2", "(1, 2)", &[0x00, 0x01, 0xff, 0xff]), [1.0 / 65535.0, 1.0]);
    let float = [0.25f32.to_be_bytes(), 0.75f32.to_be_bytes()].concat();
    assert_eq!(write(">f4", "(2, 1)", &float), [0.25, 0.75]);
    assert_eq!(write("<f2", "(1, 1, 2)", &[0x00, 0x38, 0x00, 0x3c]), [0.5, 1.0]);
}

#[test]
fn a_two_dimensional_array_is_one_frame() {
    let (_folder, path) = folder_with("one.npy");
    for array in [
        Array2::from_shape_fn((3, 4), |(v, u)| (10 * v + u) as u8),
        Array2::from_shape_fn((3, 4).f(), |(v, u)| (10 * v + u) as u8),
    ] {
        write_npy(&path, &array).expect("written");
        let burst = Burst::open(&path).expect("opens");
        assert_eq!((burst.len(), burst.size()), (1, (4, 3)));
        assert_eq!(burst.frames[0].at(3, 2), 23.0 / 255.0);
    }
    // Arrays of one frame are treated like pictures.
    let burst = open(&[path.clone(), path]).expect("two frames");
    assert_eq!(burst.len(), 2);
}

#[test]
fn tiffs_of_rarer_layouts() {
    let (_folder, path) = folder_with("a.tif");
    let values = |bytes: Vec<u8>| {
        fs::write(&path, bytes).expect("written");
        Burst::open(&path).map(|b| b.frames[0].data().to_vec())
    };
    // Grey of 16 bit in both byte orders; inverted grey.
    let found = values(raw_tiff(true, (2, 1), &[16], &[(262, 1)], &[&[0, 1, 0xff, 0xff]])).expect("big endian");
    assert_eq!(found, [1.0 / 65535.0, 1.0]);
    let found = values(raw_tiff(false, (2, 1), &[16], &[(262, 1)], &[&[1, 0, 0xff, 0xff]])).expect("little endian");
    assert_eq!(found, [1.0 / 65535.0, 1.0]);
    let found = values(raw_tiff(false, (2, 1), &[8], &[(262, 0)], &[&[0, 255]])).expect("white is zero");
    assert_eq!(found, [1.0, 0.0]);
    // RGB in planes: red, then green, then blue.
    let found = values(raw_tiff(false, (2, 1), &[8, 8, 8], &[(262, 2), (284, 2)], &[&[255, 0], &[0, 255], &[0, 255]]));
    assert_close(&found.expect("planar"), &[LUMA_WEIGHTS[0], 1.0 - LUMA_WEIGHTS[0]]);
    // Floats of 16 bit.
    let found = values(raw_tiff(false, (2, 1), &[16], &[(262, 1), (339, 3)], &[&[0x00, 0x38, 0x00, 0x3c]]));
    assert_eq!(found.expect("half floats"), [0.5, 1.0]);
    // Errors of variants that cannot be opened.
    for (what, bytes) in [
        ("12 bit", raw_tiff(false, (2, 1), &[12], &[(262, 1)], &[&[0; 3]])),
        ("1 bit", raw_tiff(false, (8, 1), &[1], &[(262, 1)], &[&[0x55]])),
        ("CMYK", raw_tiff(false, (1, 1), &[8; 4], &[(262, 5)], &[&[0; 4]])),
        ("palette", raw_tiff(false, (2, 1), &[8], &[(262, 3)], &[&[0; 2]])),
    ] {
        let error = values(bytes).expect_err(what);
        assert_eq!(error.kind, ErrorKind::Unsupported, "{what}: {error}");
    }
}

fn names(inputs: &[PathBuf]) -> Vec<String> {
    find_bursts(inputs, &OpenOptions::default()).expect("bursts").into_iter().map(|s| s.name).collect()
}

fn first_values(burst: &Burst) -> Vec<u32> {
    burst.frames.iter().map(|f| (f.at(0, 0) * 255.0).round() as u32).collect()
}

fn stack(path: &Path) {
    tiff_pages::<colortype::Gray8>(path, (2, 1), &[vec![1, 2], vec![3, 4]]);
}

#[test]
fn a_folder_is_read_in_natural_order_without_what_is_no_picture() {
    let folder = folder();
    for t in [10, 2, 1, 9, 100] {
        save(&folder.join(format!("frame_{t}.png")), &grey8(3, 2, t));
    }
    for other in ["calib.txt", "truth.json", "features.csv", ".hidden.png", "notes"] {
        fs::write(folder.join(other), "no picture").expect("written");
    }
    fs::create_dir(folder.join("results")).expect("made");
    save(&folder.join("results/a.png"), &grey8(9, 9, 0));
    let burst = Burst::open(&folder).expect("opens");
    assert_eq!(first_values(&burst), [1, 2, 9, 10, 100]);
    assert_eq!(burst.frame_names[3], "frame_10.png");
    assert_eq!(burst.name, folder.file_name().expect("named").to_string_lossy());
    assert!(burst.sources[0].is_absolute());
}

#[test]
fn named_files_keep_the_order_in_which_they_are_named() {
    let folder = folder();
    let order = [5, 1, 2, 4, 3];
    let files: Vec<PathBuf> = order.iter().map(|t| folder.join(format!("{t}.png"))).collect();
    files.iter().zip(order).for_each(|(path, t)| save(path, &grey8(3, 2, t)));
    let burst = open(&files).expect("opens");
    assert_eq!(first_values(&burst), [5, 1, 2, 4, 3]);
    assert_eq!(burst.name, folder.file_name().expect("named").to_string_lossy());
    assert_eq!(first_values(&open(&burst.sources).expect("opens again")), [5, 1, 2, 4, 3]);
    assert_eq!(open(&files[..1]).expect("one").name, "5");
}

#[test]
fn a_dataset_is_a_folder_of_burst_folders() {
    let folder = folder();
    for name in ["burst10", "burst2", "burst1"] {
        fs::create_dir(folder.join(name)).expect("made");
        save(&folder.join(name).join("1.png"), &grey8(3, 2, 0));
    }
    fs::create_dir(folder.join("empty")).expect("made");
    fs::create_dir(folder.join(".git")).expect("made");
    save(&folder.join(".git/1.png"), &grey8(3, 2, 0));
    fs::write(folder.join("README.md"), "text").expect("written");
    let dataset = [folder.to_path_buf()];
    assert_eq!(names(&dataset), ["burst1", "burst2", "burst10"]);
    for source in find_bursts(&dataset, &OpenOptions::default()).expect("bursts") {
        assert_eq!(open(&source.paths).expect("opens").name, source.name);
    }
    let error = open(&dataset).expect_err("three bursts");
    assert_eq!(error.to_string(), "there are 3 bursts here, open one of them: burst1, burst2, burst10");
}

#[test]
fn of_bursts_a_folder_too_deep_the_folders_above_are_told() {
    let folder = folder();
    for name in ["left/burst_0", "left/burst_1", "right/burst_0", "notes"] {
        fs::create_dir_all(folder.join(name)).expect("made");
        if name != "notes" {
            save(&folder.join(name).join("1.png"), &grey8(3, 2, 0));
        }
    }
    let error = find_bursts(&[folder.to_path_buf()], &OpenOptions::default()).expect_err("too deep");
    let [left, right] = ["left", "right"].map(|name| folder.join(name));
    let given = format!("give the folders above them, such as {} {}", left.display(), right.display());
    assert_eq!(error.remedy, format!("bursts lie a folder deeper: {given}"));
    assert_eq!(names(&[left, right]), ["burst_0", "burst_1", "burst_0-2"]);
}

#[test]
fn a_long_sequence_is_cut_into_bursts_in_natural_order() {
    let folder = folder();
    (0..12).for_each(|t| save(&folder.join(format!("f{t}.png")), &grey8(3, 2, t)));
    let sequence = &find_bursts(&[folder.to_path_buf()], &OpenOptions::default()).expect("one sequence")[0];
    let cut = SequenceCut::new(5, None).expect("a cut");
    let bursts = cut_sequence(sequence, cut, &OpenOptions::default()).expect("two bursts");
    assert_eq!(bursts.iter().map(|b| b.name.as_str()).collect::<Vec<_>>(), ["f2", "f7"]);
    assert_eq!(first_values(&open(&bursts[1].paths).expect("opens")), [5, 6, 7, 8, 9]);
    // Bursts of single frames, for SIFT on each of them.
    let frames =
        cut_sequence(sequence, SequenceCut::new(1, None).expect("a cut"), &OpenOptions::default()).expect("twelve");
    assert_eq!(first_values(&open(&frames[10].paths).expect("opens")), [10]);
    // Frames in one file are not cut.
    let path = folder.join("film.tif");
    stack(&path);
    let film = BurstFiles { name: "film".into(), paths: vec![path.clone()] };
    let error = cut_sequence(&film, cut, &OpenOptions::default()).expect_err("a stack");
    assert!(error.problem.contains("this one file holds several frames"), "{error}");
    assert!(error.subject == path.display().to_string(), "{error}");
    let error = cut_sequence(sequence, cut, &OpenOptions::default()).expect_err("a stack among frames");
    assert!(error.problem.contains("this one file holds"), "{error}");
}

#[test]
fn several_stacks_are_several_bursts() {
    let folder = folder();
    let paths = [folder.join("b.tif"), folder.join("a.npy")];
    stack(&paths[0]);
    write_npy(&paths[1], &Array3::<u8>::zeros((3, 2, 2))).expect("written");
    assert_eq!(names(&paths), ["b", "a"]);
    assert_eq!(names(&[folder.to_path_buf()]), ["a", "b"]);
    // A stack alone in its folder is the folder's burst, and has the folder's name.
    fs::remove_file(&paths[1]).expect("removed");
    let burst = Burst::open(&folder).expect("opens");
    assert_eq!((burst.len(), burst.name), (2, folder.file_name().expect("name").to_string_lossy().into_owned()));
    // Beside single pictures it would be both a frame and a burst.
    let picture = folder.join("1.png");
    save(&picture, &grey8(2, 1, 0));
    let error = open(&[picture, paths[0].clone()]).expect_err("mixed");
    let named = paths[0].display().to_string();
    assert!(error.problem.contains("this one holds several frames itself") && error.subject == named, "{error}");
    let error = Burst::open(&folder).expect_err("mixed");
    assert!(error.problem.contains("frames itself") && error.subject == named, "{error}");
}

#[test]
fn bursts_of_one_name_are_numbered() {
    let folder = folder();
    let inputs: Vec<PathBuf> = ["a/night", "b/Night", "c/night"].iter().map(|p| folder.join(p)).collect();
    for path in &inputs {
        fs::create_dir_all(path).expect("made");
        save(&path.join("1.png"), &grey8(2, 1, 0));
    }
    assert_eq!(names(&inputs), ["night", "Night-2", "night-3"]);
}

#[test]
fn folders_without_a_last_name_have_one() {
    let folder = folder();
    save(&folder.join("1.png"), &grey8(2, 1, 0));
    fs::create_dir(folder.join("sub")).expect("made");
    let name = folder.file_name().expect("named").to_string_lossy().into_owned();
    assert_eq!(names(&[folder.join("sub/..")]), [name.as_str()]);
    assert_eq!(names(&[folder.join(".")]), [name]);
}

#[test]
fn every_supported_ending_can_be_opened() {
    let folder = folder();
    for extension in supported_extensions() {
        let path = folder.join(format!("a.{extension}"));
        match extension {
            "npy" => write_npy(&path, &Array2::<u8>::zeros((2, 3))).expect("written"),
            "ppm" => save(&path, &image::RgbImage::new(3, 2)),
            "webp" => save(&path, &image::RgbImage::new(3, 2)),
            "pbm" => fs::write(&path, "P1\n3 2\n1 0 1\n0 1 0\n").expect("written"),
            "pnm" => fs::write(&path, "P2\n3 2\n255\n1 0 1\n0 1 0\n").expect("written"),
            "pam" => {
                let header = "P7\nWIDTH 3\nHEIGHT 2\nDEPTH 1\nMAXVAL 255\nTUPLTYPE GRAYSCALE\nENDHDR\n";
                fs::write(&path, format!("{header}abcdef")).expect("written");
            }
            "png" | "tif" | "tiff" | "jpg" | "jpeg" | "pgm" | "bmp" => save(&path, &image::GrayImage::new(3, 2)),
            // Extensions of raw files, which have separate tests; the kind is recognised by the content.
            _ => {
                let png = folder.join("really.png");
                save(&png, &image::GrayImage::new(3, 2));
                fs::rename(&png, &path).expect("renamed");
            }
        }
        let burst = Burst::open(&path).expect(extension);
        assert_eq!(burst.size(), (3, 2), "{extension}");
    }
    // Beside pictures lie films, archives and files without header, which are none of the frames.
    let apart = [
        "fits", "fit", "fts", "fz", "ser", "y4m", "npz", "mp4", "mkv", "avi", "mov", "webm", "mpg", "gif", "raw",
        "bin", "dat", "bag", "mcap", "db3",
    ];
    let together = Burst::open(&folder).expect("all together");
    assert_eq!(together.len() + apart.len(), supported_extensions().len());
    assert!(together.frame_names.iter().all(|name| !apart.iter().any(|end| name.ends_with(&format!(".{end}")))));
}

#[test]
fn the_content_tells_the_kind_not_the_name() {
    let (folder, path) = folder_with("really_a_png.jpg");
    save(&folder.join("a.png"), &grey8(3, 2, 0));
    fs::rename(folder.join("a.png"), &path).expect("renamed");
    assert_eq!(Burst::open(&path).expect("opens").size(), (3, 2));
    let odd = folder.join("no_ending");
    fs::copy(&path, &odd).expect("copied");
    assert_eq!(Burst::open(&odd).expect("opens").size(), (3, 2));
}
