//! Tests of the public functions of `dataset`.

use crate::prelude::*;
use burstscope_core::{dataset::camera::*, dataset::pairs::*, dataset::*, error::*, matching::*};

#[test]
fn a_guess_is_colmaps_and_a_known_camera_is_for_its_own_images_and_camera_files_are_read_or_explained() {
    let camera = CameraChoice::default().for_images((640, 480)).expect("a guess");
    assert_eq!(camera.to_string(), "SIMPLE_RADIAL 640 480 768 320 240 0");
    let camera = CameraChoice::Guessed(CameraModel::OpenCv).for_images((480, 640)).expect("a guess");
    assert_eq!(camera.params, [768.0, 768.0, 240.0, 320.0, 0.0, 0.0, 0.0, 0.0]);
    let choice = CameraChoice::Known(Camera::centred(64, 48, 50.0));
    assert_eq!(choice.for_images((64, 48)).map(|c| c.params[0]), Ok(50.0));
    says(choice.for_images((48, 64)).expect_err("another size"), &["64×48", "48×64"]);
    let (home, path) = folder_with("camera.toml");
    let read = |text: &str| {
        fs::write(&path, text).expect("written");
        read_camera(&path)
    };
    let text = "model = \"OPENCV\"\nwidth = 8\nheight = 6\nparams = [5, 5, 4, 3, 0.1, 0, 0, 0]\n";
    assert_eq!(read(text).expect("a camera").to_string(), "OPENCV 8 6 5 5 4 3 0.1 0 0 0");
    for (text, words) in [
        ("model = \"FISHEYE\"\nwidth = 8\nheight = 6\nparams = [5, 4, 3]\n", "FISHEYE"),
        ("model = \"PINHOLE\"\nwidth = 8\nheight = 6\n", "params"),
        ("model = \"PINHOLE\"\nwidth = 8\nheight = 6\nparams = [5]\n", "fx, fy, cx, cy"),
        ("model = \"PINHOLE\"\nfocal = 3\n", "focal"),
    ] {
        says(read(text).expect_err(words), &[words]);
    }
    assert!(read_camera(&home.join("gone.toml")).expect_err("absent").to_string().contains("gone.toml"));
}

#[test]
fn bursts_have_the_camera_that_is_given_for_their_folder_or_lies_beside_them() {
    let (home, input) = folder_with("flight");
    let write = |folder: &str, focal_px: f64| {
        let text = format!("model = \"SIMPLE_PINHOLE\"\nwidth = 8\nheight = 6\nparams = [{focal_px}, 4, 3]\n");
        fs::create_dir_all(home.join(folder)).expect("made");
        fs::write(home.join(folder).join("camera.toml"), text).expect("written");
    };
    // Above the input no file counts.
    write("", 1.0);
    write("flight/right", 3.0);
    fs::create_dir_all(input.join("left")).expect("made");
    let burst = |name: &str, path: &str| BurstFiles { name: name.into(), paths: vec![input.join(path)] };
    let bursts = [burst("left", "left"), burst("one", "right/one.npy"), burst("two", "right/two.npy")];
    let given = |names: &[(&str, f64)]| -> Vec<(String, CameraChoice)> {
        let own = |focal_px| CameraChoice::Own(Camera::centred(8, 6, focal_px), "given".into());
        names.iter().map(|(name, focal_px)| ((*name).to_owned(), own(*focal_px))).collect()
    };
    let focal_px = |names: &[(&str, f64)], rest: CameraChoice| {
        let cameras = BurstCameras::of(&bursts, std::slice::from_ref(&input), &given(names), rest).expect("cameras");
        bursts.each_ref().map(|burst| cameras.of_burst(&burst.name).known().map(|camera| camera.params[0]))
    };
    let unknown = CameraChoice::default;
    assert_eq!(focal_px(&[], unknown()), [None, Some(3.0), Some(3.0)]);
    assert_eq!(focal_px(&[("left", 7.0), ("two", 8.0)], unknown()), [Some(7.0), Some(3.0), Some(8.0)]);
    assert_eq!(focal_px(&[("right/", 7.0), ("right", 8.0)], unknown()), [None, Some(8.0), Some(8.0)]);
    assert_eq!(focal_px(&[("flight", 7.0), ("right", 8.0)], unknown()), [Some(7.0), Some(8.0), Some(8.0)]);
    let known = CameraChoice::Known(Camera::centred(8, 6, 9.0));
    assert_eq!(focal_px(&[("one", 7.0)], known), [Some(9.0), Some(7.0), Some(9.0)]);
    write("flight", 2.0);
    assert_eq!(focal_px(&[], unknown()), [Some(2.0), Some(3.0), Some(3.0)]);
    let of = |names: &[(&str, f64)]| BurstCameras::of(&bursts, std::slice::from_ref(&input), &given(names), unknown());
    assert_eq!(of(&[]).expect("cameras").own["two"].source(), Some(&input.join("right/camera.toml")));
    says(of(&[("righ", 7.0)]).expect_err("no such folder"), &["'righ'", "flight, left, one, right, two"]);
    fs::write(input.join("right/camera.toml"), "model = 3").expect("written");
    says(of(&[]).expect_err("no camera"), &["camera.toml"]);
}

struct Counted {
    missing: Option<usize>,
    loads: usize,
}

impl PairSource<Error> for Counted {
    fn features(&mut self, index: usize) -> Result<Option<BurstSide>> {
        self.loads += 1;
        let (places, descriptors) = (vec![[1.0, 2.0]; 3], vec![[7; 128]; 3]);
        let side = BurstSide { places, descriptors, blobs: Vec::new(), pictures: None };
        Ok((Some(index) != self.missing).then_some(side))
    }

    fn burst(&mut self, index: usize) -> Result<(Burst, DetectorParams)> {
        unreachable!("the pictures of burst {index} are not needed")
    }
}

#[test]
fn each_pair_is_matched_once_with_few_loads_and_pairs_without_features_are_left_out() {
    for (selection, missing) in
        [(PairSelection::All, None), (PairSelection::All, Some(4)), (PairSelection::Sequential(1), Some(0))]
    {
        let pairs = selection.pairs(40);
        let (mut source, mut seen) = (Counted { missing, loads: 0 }, Vec::new());
        let mut on = |pair: MatchedPair<'_>| {
            seen.push(pair.indices);
            Ok(())
        };
        let params = MatchParams { align: false, ..MatchParams::default() };
        let left_out = match_pairs(&pairs, &params, &mut source, &mut on, &quiet()).expect("matched");
        seen.sort_unstable();
        let is_there = |&&(a, b): &&(usize, usize)| Some(a) != missing && Some(b) != missing;
        assert_eq!(seen, pairs.iter().filter(is_there).copied().collect::<Vec<_>>());
        assert_eq!(left_out, pairs.len() - seen.len());
        assert!(source.loads < 40 + pairs.len() / 3, "{} loads for {} pairs", source.loads, pairs.len());
    }
}

#[test]
fn lists_name_bursts_with_or_without_an_extension_and_wrong_lines_are_numbered() {
    let (_home, path) = folder_with("pairs.txt");
    let bursts = ["a", "b 1", "c/2", "d.5", "d"].map(|name| BurstFiles { name: name.into(), paths: Vec::new() });
    let read = |text: &str| {
        fs::write(&path, text).expect("written");
        read_pairs(&path, &bursts)
    };
    let text = "\u{feff}# by retrieval\n\nb 1.png a.png\n  c_2.png\td.5.jpg \r\na b 1\nd.5 a\nc/2 b 1\n";
    assert_eq!(read(text), Ok(vec![(0, 1), (0, 3), (1, 2), (2, 3)]));
    for (text, line, words) in [
        ("a d.5\na e.png\n", 2, "e.png"),
        ("a\n", 1, "two bursts"),
        ("\na a\n", 2, "two"),
        ("a d.5 0.7\n", 1, "0.7"),
        // The end of a name is no extension of a picture.
        ("a d.7\n", 1, "d.7"),
    ] {
        says(read(text).expect_err(text), &[&format!("line {line}: "), words, "pairs.txt"]);
    }
    let long = read(&"a ".repeat(1 << 20)).expect_err("one line").to_string();
    assert!(long.contains("line 1: ") && long.len() < 1000, "{}", long.len());
    assert!(read("# nothing\n").expect_err("empty").to_string().contains("it names no pair"));
}

#[test]
fn the_middle_frame_is_shown_and_a_broken_one_named_and_folders_of_bursts_and_cut_sequences() {
    let home = folder();
    for t in 0..3u8 {
        let frame = image::GrayImage::from_fn(8, 4, |u, _| image::Luma([if t == 1 && u > 3 { 40 } else { 10 }]));
        frame.save(home.join(format!("{t}.png"))).expect("written");
    }
    let source = BurstFiles { name: "b".into(), paths: vec![home.to_path_buf()] };
    // A frame minus itself as the bias frame is empty.
    let options = OpenOptions { bias: Some(home.join("1.png")), ..OpenOptions::default() };
    let made = |options: &OpenOptions| thumbnail(&source, 4, options, &quiet());
    let dark = made(&options).expect("a picture");
    assert!(dark.rgb.iter().all(|value| *value == dark.rgb[0]));
    let shown = made(&OpenOptions::default()).expect("a picture");
    assert_eq!((shown.size, shown.rgb.len()), ((4, 2), 24));
    assert_eq!((shown.rgb[0], shown.rgb[9]), (0, 255), "a dark frame is stretched");
    fs::write(home.join("1.png"), "no picture").expect("written");
    says(made(&OpenOptions::default()).expect_err("broken"), &["1.png"]);
    let home = folder();
    film(&home.join("nights/a"), 2);
    film(&home.join("nights/b"), 5);
    let nights = DatasetSource::of_bursts(vec![home.join("nights")]);
    assert_eq!(names(&nights), ["a", "b"]);
    let one = DatasetSource { paths: vec![home.join("nights/b")], burst_length: Some(2), burst_step: None };
    assert_eq!(names(&one), ["f1", "f3"]);
    let overlapping = DatasetSource { burst_step: Some(1), ..one.clone() };
    assert_eq!(names(&overlapping), ["f1", "f2", "f3", "f4"]);
    assert_eq!(names(&DatasetSource { burst_length: Some(2), ..nights.clone() }), ["a_f1", "b_f1", "b_f3"]);
    for (wrong, words) in [
        (DatasetSource { burst_length: Some(3), ..nights.clone() }, "too few frames (2)"),
        (DatasetSource { burst_length: Some(0), ..nights.clone() }, "1"),
        (DatasetSource::of_bursts(vec![home.join("gone")]), "gone"),
        (DatasetSource::of_bursts(Vec::new()), "nothing"),
    ] {
        says(wrong.bursts(&OpenOptions::default()).expect_err(words), &[words]);
    }
    assert_eq!(nights.default_folder(), Some(home.join("nights-burstscope")));
    assert_eq!(one.default_folder(), Some(home.join("nights/b-burstscope-2")));
    assert_eq!(overlapping.default_folder(), Some(home.join("nights/b-burstscope-2-1")));
    assert_eq!(nights.label(), "nights");
}

fn film(folder: &Path, frames: usize) {
    fs::create_dir_all(folder).expect("made");
    let frame = image::GrayImage::from_pixel(4, 4, image::Luma([9]));
    (0..frames).for_each(|t| frame.save(folder.join(format!("f{t}.png"))).expect("written"));
}

fn names(source: &DatasetSource) -> Vec<String> {
    source.bursts(&OpenOptions::default()).expect("bursts").into_iter().map(|b| b.name).collect()
}
