//! Round trips: files written in each format are read with the right values, order and full scale; the frames that an
//! input names, their order, and the names of bursts.

use super::{crafted::npy_of, support::*};
use image::{DynamicImage, LumaA, Rgba};
use ndarray::ShapeBuilder;

#[test]
fn lossless_pictures_of_8_and_of_16_bit_are_exact() {
    let folder = folder();
    let expected: Vec<f32> = grey8(5, 4, 30).iter().map(|value| f32::from(*value) / 255.0).collect();
    for name in ["a.png", "a.bmp", "a.pgm", "a.tiff", "A.PNG"] {
        save(&folder.join(name), &grey8(5, 4, 30));
        let burst = Burst::open(folder.join(name)).expect(name);
        assert_eq!((burst.len(), burst.size(), burst.full_scale), (1, (5, 4), 255.0), "{name}");
        assert_eq!((burst.quantisation_step, &burst.frame_names[..]), (1.0 / 255.0, &[name.to_owned()][..]));
        assert_eq!(burst.frames[0].data(), expected, "{name}");
    }
    // Grey is exact as a colour too, whatever its alpha.
    save(&folder.join("rgb.png"), &ImageBuffer::from_fn(256, 1, |u, _| Rgb([u as u8; 3])));
    save(&folder.join("rgba.png"), &ImageBuffer::from_fn(256, 1, |u, _| Rgba([u, u, u, 255 - u].map(|x| x as u8))));
    save(&folder.join("la.png"), &ImageBuffer::from_fn(256, 1, |u, _| LumaA([u as u8, 7])));
    for name in ["rgb.png", "rgba.png", "la.png"] {
        let burst = Burst::open(folder.join(name)).expect(name);
        assert!((0..256).all(|n| burst.frames[0].at(n, 0) == n as f32 / 255.0), "{name}");
    }
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
fn colour_becomes_luma_and_alpha_is_ignored_and_the_content_tells_the_kind_not_the_name() {
    let folder = folder();
    let colours = [[255, 0, 0], [0, 255, 0], [0, 0, 255], [9, 9, 9]];
    let expected = [LUMA_WEIGHTS[0], LUMA_WEIGHTS[1], LUMA_WEIGHTS[2], 9.0 / 255.0];
    let rgb = ImageBuffer::from_fn(4, 1, |u, _| Rgb(colours[u as usize]));
    let rgba = DynamicImage::from(ImageBuffer::from_fn(4, 1, |u, _| {
        let [r, g, b] = colours[u as usize];
        Rgba([r, g, b, 60 * u as u8])
    }));
    let deep = DynamicImage::from(rgb.clone()).into_rgb16();
    for (picture, names) in [
        (rgb.into(), &["a.png", "a.bmp", "a.ppm", "a.webp", "a.tif"][..]),
        (rgba, &["b.png", "b.webp", "b.tif"]),
        (DynamicImage::from(deep), &["c.png", "c.tif"]),
    ] {
        for name in names {
            picture.save(folder.join(name)).expect("saved");
            assert_close(Burst::open(folder.join(name)).expect(name).frames[0].data(), &expected);
        }
    }
    let (folder, path) = folder_with("really_a_png.jpg");
    save(&folder.join("a.png"), &grey8(3, 2, 0));
    fs::rename(folder.join("a.png"), &path).expect("renamed");
    assert_eq!(Burst::open(&path).expect("opens").size(), (3, 2));
    let odd = folder.join("no_ending");
    fs::copy(&path, &odd).expect("copied");
    assert_eq!(Burst::open(&odd).expect("opens").size(), (3, 2));
}

#[test]
fn jpeg_is_near_thumbnails_in_a_tiff_are_left_out_and_a_long_one_keeps_its_order() {
    let (_folder, path) = folder_with("a.jpg");
    save(&path, &ImageBuffer::from_fn(64, 48, |u, v| Luma([(u + v) as u8])));
    let burst = Burst::open(&path).expect("jpeg");
    assert_eq!((burst.size(), burst.full_scale), ((64, 48), 255.0));
    let off = |(n, value): (usize, &f32)| (value - (n % 64 + n / 64) as f32 / 255.0).abs();
    let worst = burst.frames[0].data().iter().enumerate().map(off).fold(0.0, f32::max);
    assert!(worst < 4.0 / 255.0, "{worst}");
    let (_folder, path) = folder_with("with_thumbnail.tif");
    let mut encoder = TiffEncoder::new(fs::File::create(&path).expect("created")).expect("begins");
    encoder.write_image::<colortype::Gray8>(4, 2, &[7; 8]).expect("page");
    let mut thumbnail = encoder.new_image::<colortype::Gray8>(2, 1).expect("thumbnail");
    thumbnail.encoder().write_tag(Tag::NewSubfileType, 1u32).expect("tag");
    thumbnail.write_data(&[1, 2]).expect("thumbnail");
    let burst = Burst::open(&path).expect("opens");
    assert_eq!((burst.len(), burst.size()), (1, (4, 2)));
    let (_folder, path) = folder_with("long.tiff");
    let pages: Vec<Vec<u16>> = (0..200).map(|t| vec![t * 300; 12]).collect();
    tiff_pages::<colortype::Gray16>(&path, (4, 3), &pages);
    let burst = Burst::open(&path).expect("opens");
    assert_eq!(burst.len(), 200);
    let value = |t: usize| (t * 300) as f32 / 65535.0;
    assert!(burst.frames.iter().enumerate().all(|(t, frame)| frame.data().iter().all(|v| *v == value(t))));
}

#[test]
fn multi_page_tiffs_of_every_type_come_back() {
    let (_folder, path) = folder_with("stack.tif");
    const FIFTHS: [[f32; 2]; 3] = [[0.0, 0.2], [0.4, 0.6], [0.8, 1.0]];
    let expect = |full_scale: f32, step: f32, pages: [[f32; 2]; 3]| {
        let burst = Burst::open(&path).expect("opens");
        assert_eq!((burst.len(), burst.size(), burst.name.as_str()), (3, (2, 1), "stack"));
        assert_eq!((burst.full_scale, burst.quantisation_step), (full_scale, step));
        burst.frames.iter().zip(pages).for_each(|(frame, page)| assert_close(frame.data(), &page));
        assert_eq!(burst.frame_names[2], "stack.tif [2]");
    };
    macro_rules! come_back {
        ($($type:ident: $($page:expr),*; $full_scale:expr, $step:expr, $expected:expr;)*) => { $(
            tiff_pages::<colortype::$type>(&path, (2, 1), &[$($page.to_vec()),*]);
            expect($full_scale, $step, $expected);
        )* };
    }
    // Integers of 32 bit are relative to their own largest value. Floats in [0, 1] are kept, with some noise around;
    // others are divided by the largest value. A bad pixel far below 0 says nothing of the full scale.
    come_back! {
        Gray8: [0, 51], [102, 153], [204, 255]; 255.0, 1.0 / 255.0, FIFTHS;
        Gray16: [0, 13107], [26214, 39321], [52428, 65535]; 65535.0, 1.0 / 65535.0, FIFTHS;
        GrayI16: [-32767, 0], [0, 0], [0, 32767]; 32767.0, 1.0 / 32767.0, [[-1.0, 0.0], [0.0, 0.0], [0.0, 1.0]];
        Gray32: [0, 200], [400, 600], [800, 1000]; 1000.0, 1.0 / 1000.0, FIFTHS;
        Gray32Float: [-0.1, 0.2], [0.4, 0.6], [0.8, 1.1]; 1.0, 0.0, [[-0.1, 0.2], [0.4, 0.6], [0.8, 1.1]];
        Gray32Float: [0.0, 50.0], [100.0, 150.0], [200.0, 250.0]; 250.0, 0.0, FIFTHS;
        Gray32Float: [-5.0, 0.2], [0.4, 0.6], [0.8, 1.0]; 1.0, 0.0, [[-5.0, 0.2], [0.4, 0.6], [0.8, 1.0]];
        Gray32Float: [-900.0, 50.0], [100.0, 150.0], [200.0, 250.0]; 250.0, 0.0, [[-3.6, 0.2], [0.4, 0.6], [0.8, 1.0]];
        Gray64Float: [0.0, 0.2], [0.4, 0.6], [0.8, 1.0]; 1.0, 0.0, FIFTHS;
        RGB8: [0, 0, 0, 51, 51, 51], [102, 102, 102, 153, 153, 153], [204, 204, 204, 255, 255, 255]; 255.0, 1.0 / 255.0, FIFTHS;
    }
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
    assert!(Burst::open(&path).expect("booleans").frames.iter().all(|f| f.data().iter().all(|v| *v == 1.0)));
}

#[test]
fn npy_of_other_byte_order_and_of_half_floats_and_a_two_dimensional_array_is_one_frame() {
    let (_folder, path) = folder_with("a.npy");
    let write = |kind: &str, shape: &str, data: &[u8]| {
        fs::write(&path, npy_of(kind, "False", shape, data)).expect("written");
        Burst::open(&path).expect(kind).frames[0].data().to_vec()
    };
    assert_eq!(write("'>u2'", "1, 2", &[0x00, 0x01, 0xff, 0xff]), [1.0 / 65535.0, 1.0]);
    assert_eq!(write("'>f4'", "2, 1", &[0.25f32.to_be_bytes(), 0.75f32.to_be_bytes()].concat()), [0.25, 0.75]);
    assert_eq!(write("'<f2'", "1, 1, 2", &[0x00, 0x38, 0x00, 0x3c]), [0.5, 1.0]);
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
    assert_eq!(open(&[path.clone(), path]).expect("two frames").len(), 2);
}

#[test]
fn tiffs_of_rarer_layouts() {
    let (_folder, path) = folder_with("a.tif");
    let values = |bytes: Vec<u8>| {
        fs::write(&path, bytes).expect("written");
        Burst::open(&path).map(|b| b.frames[0].data().to_vec())
    };
    for (what, bytes, expected) in [
        ("big endian", raw_tiff(true, (2, 1), &[16], &[(262, 1)], &[&[0, 1, 0xff, 0xff]]), [1.0 / 65535.0, 1.0]),
        ("little endian", raw_tiff(false, (2, 1), &[16], &[(262, 1)], &[&[1, 0, 0xff, 0xff]]), [1.0 / 65535.0, 1.0]),
        ("white is zero", raw_tiff(false, (2, 1), &[8], &[(262, 0)], &[&[0, 255]]), [1.0, 0.0]),
        ("half floats", raw_tiff(false, (2, 1), &[16], &[(262, 1), (339, 3)], &[&[0, 0x38, 0, 0x3c]]), [0.5, 1.0]),
    ] {
        assert_eq!(values(bytes).expect(what), expected, "{what}");
    }
    // RGB in planes: red, then green, then blue.
    let found = values(raw_tiff(false, (2, 1), &[8, 8, 8], &[(262, 2), (284, 2)], &[&[255, 0], &[0, 255], &[0, 255]]));
    assert_close(&found.expect("planar"), &[LUMA_WEIGHTS[0], 1.0 - LUMA_WEIGHTS[0]]);
    for (what, bytes) in [
        ("12 bit", raw_tiff(false, (2, 1), &[12], &[(262, 1)], &[&[0; 3]])),
        ("1 bit", raw_tiff(false, (8, 1), &[1], &[(262, 1)], &[&[0x55]])),
        ("CMYK", raw_tiff(false, (1, 1), &[8; 4], &[(262, 5)], &[&[0; 4]])),
        ("palette", raw_tiff(false, (2, 1), &[8], &[(262, 3)], &[&[0; 2]])),
    ] {
        assert_eq!(values(bytes).expect_err(what).kind, ErrorKind::Unsupported, "{what}");
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
fn a_folder_is_read_in_natural_order_and_named_files_in_theirs() {
    let folder = folder();
    [10, 2, 1, 9, 100].into_iter().for_each(|t| save(&folder.join(format!("frame_{t}.png")), &grey8(3, 2, t)));
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
fn a_dataset_is_a_folder_of_burst_folders_and_of_bursts_a_folder_too_deep_the_folders_above_are_told() {
    let folder = folder();
    for name in ["burst10", "burst2", "burst1"] {
        fs::create_dir(folder.join(name)).expect("made");
        save(&folder.join(name).join("1.png"), &grey8(3, 2, 0));
    }
    ["empty", ".git"].into_iter().for_each(|name| fs::create_dir(folder.join(name)).expect("made"));
    save(&folder.join(".git/1.png"), &grey8(3, 2, 0));
    fs::write(folder.join("README.md"), "text").expect("written");
    let dataset = [folder.to_path_buf()];
    assert_eq!(names(&dataset), ["burst1", "burst2", "burst10"]);
    for source in find_bursts(&dataset, &OpenOptions::default()).expect("bursts") {
        assert_eq!(open(&source.paths).expect("opens").name, source.name);
    }
    let error = open(&dataset).expect_err("three bursts");
    assert_eq!(error.to_string(), "there are 3 bursts here, open one of them: burst1, burst2, burst10");
    let folder = crate::prelude::folder();
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
    let single = SequenceCut::new(1, None).expect("a cut");
    let frames = cut_sequence(sequence, single, &OpenOptions::default()).expect("twelve");
    assert_eq!(first_values(&open(&frames[10].paths).expect("opens")), [10]);
    // Frames in one file are not cut.
    let path = folder.join("film.tif");
    stack(&path);
    let film = BurstFiles { name: "film".into(), paths: vec![path.clone()] };
    for (cut_up, subject) in [(&film, path.display().to_string()), (sequence, String::new())] {
        let error = cut_sequence(cut_up, cut, &OpenOptions::default()).expect_err("a stack, and one among frames");
        assert!(error.problem.contains("this one file holds several frames"), "{error}");
        assert!(error.subject == subject || subject.is_empty(), "{error}");
    }
}

#[test]
fn several_stacks_are_several_bursts_bursts_of_one_name_are_numbered_and_all_have_one() {
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
    let named = paths[0].display().to_string();
    for error in [open(&[picture, paths[0].clone()]).expect_err("mixed"), Burst::open(&folder).expect_err("mixed")] {
        assert!(error.problem.contains("this one holds several frames itself") && error.subject == named, "{error}");
    }
    let inputs: Vec<PathBuf> = ["a/night", "b/Night", "c/night"].iter().map(|p| folder.join(p)).collect();
    for path in &inputs {
        fs::create_dir_all(path).expect("made");
        save(&path.join("1.png"), &grey8(2, 1, 0));
    }
    assert_eq!(names(&inputs), ["night", "Night-2", "night-3"]);
    let folder = crate::prelude::folder();
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
            "ppm" | "webp" => save(&path, &image::RgbImage::new(3, 2)),
            "pbm" => fs::write(&path, "P1\n3 2\n1 0 1\n0 1 0\n").expect("written"),
            "pnm" => fs::write(&path, "P2\n3 2\n255\n1 0 1\n0 1 0\n").expect("written"),
            "pam" => fs::write(&path, "P7\nWIDTH 3\nHEIGHT 2\nDEPTH 1\nMAXVAL 255\nTUPLTYPE GRAYSCALE\nENDHDR\nabcdef")
                .expect("written"),
            "png" | "tif" | "tiff" | "jpg" | "jpeg" | "pgm" | "bmp" => save(&path, &image::GrayImage::new(3, 2)),
            // Extensions of raw files, which have separate tests; the kind is recognised by the content.
            _ => {
                let png = folder.join("really.png");
                save(&png, &image::GrayImage::new(3, 2));
                fs::rename(&png, &path).expect("renamed");
            }
        }
        assert_eq!(Burst::open(&path).expect(extension).size(), (3, 2), "{extension}");
    }
    // Beside pictures lie films, archives and files without header, which are none of the frames.
    let apart = "fits fit fts fz ser y4m npz mp4 mkv avi mov webm mpg gif raw bin dat bag mcap db3";
    let apart: Vec<&str> = apart.split(' ').collect();
    let together = Burst::open(&folder).expect("all together");
    assert_eq!(together.len() + apart.len(), supported_extensions().len());
    assert!(together.frame_names.iter().all(|name| !apart.iter().any(|end| name.ends_with(&format!(".{end}")))));
}
