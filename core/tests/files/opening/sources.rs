//! The frames that an input names, their order, and the names of bursts.

use super::support::{folder, grey8, open, save, tiff_pages};
use burstscope_core::burst::{
    Burst, BurstFiles, OpenError, SequenceCut, cut_sequence, find_bursts, supported_extensions,
};
use std::fs;
use std::path::{Path, PathBuf};
use tiff::encoder::colortype;

fn names(inputs: &[PathBuf]) -> Vec<String> {
    find_bursts(inputs).expect("bursts").into_iter().map(|s| s.name).collect()
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
        save(&folder.path().join(format!("frame_{t}.png")), &grey8(3, 2, t));
    }
    for other in ["calib.txt", "truth.json", "features.csv", ".hidden.png", "notes"] {
        fs::write(folder.path().join(other), "no picture").expect("written");
    }
    fs::create_dir(folder.path().join("results")).expect("made");
    save(&folder.path().join("results/a.png"), &grey8(9, 9, 0));
    let burst = Burst::open(folder.path()).expect("opens");
    assert_eq!(first_values(&burst), [1, 2, 9, 10, 100]);
    assert_eq!(burst.frame_names[3], "frame_10.png");
    assert_eq!(burst.name, folder.path().file_name().expect("named").to_string_lossy());
    assert!(burst.sources[0].is_absolute());
}

#[test]
fn named_files_keep_the_order_in_which_they_are_named() {
    let folder = folder();
    let order = [5, 1, 2, 4, 3];
    let files: Vec<PathBuf> = order.iter().map(|t| folder.path().join(format!("{t}.png"))).collect();
    for (path, t) in files.iter().zip(order) {
        save(path, &grey8(3, 2, t));
    }
    let burst = open(&files).expect("opens");
    assert_eq!(first_values(&burst), [5, 1, 2, 4, 3]);
    assert_eq!(burst.name, folder.path().file_name().expect("named").to_string_lossy());
    assert_eq!(first_values(&open(&burst.sources).expect("opens again")), [5, 1, 2, 4, 3]);
    assert_eq!(open(&files[..1]).expect("one").name, "5");
}

#[test]
fn a_dataset_is_a_folder_of_burst_folders() {
    let folder = folder();
    for name in ["burst10", "burst2", "burst1"] {
        fs::create_dir(folder.path().join(name)).expect("made");
        save(&folder.path().join(name).join("1.png"), &grey8(3, 2, 0));
    }
    fs::create_dir(folder.path().join("empty")).expect("made");
    fs::create_dir(folder.path().join(".git")).expect("made");
    save(&folder.path().join(".git/1.png"), &grey8(3, 2, 0));
    fs::write(folder.path().join("README.md"), "text").expect("written");
    let dataset = [folder.path().to_path_buf()];
    assert_eq!(names(&dataset), ["burst1", "burst2", "burst10"]);
    for source in find_bursts(&dataset).expect("bursts") {
        assert_eq!(open(&source.paths).expect("opens").name, source.name);
    }
    let error = open(&dataset).expect_err("three bursts");
    assert_eq!(error.to_string(), "there are 3 bursts here, open one of them: burst1, burst2, burst10");
}

#[test]
fn a_long_sequence_is_cut_into_bursts_in_natural_order() {
    let folder = folder();
    for t in 0..12 {
        save(&folder.path().join(format!("f{t}.png")), &grey8(3, 2, t));
    }
    let sequence = &find_bursts(&[folder.path().to_path_buf()]).expect("one sequence")[0];
    let cut = SequenceCut::new(5, None).expect("a cut");
    let bursts = cut_sequence(sequence, cut).expect("two bursts");
    assert_eq!(bursts.iter().map(|b| b.name.as_str()).collect::<Vec<_>>(), ["f2", "f7"]);
    assert_eq!(first_values(&open(&bursts[1].paths).expect("opens")), [5, 6, 7, 8, 9]);
    // Bursts of single frames, for SIFT on each of them.
    let frames = cut_sequence(sequence, SequenceCut::new(1, None).expect("a cut")).expect("twelve");
    assert_eq!(first_values(&open(&frames[10].paths).expect("opens")), [10]);
    // Frames in one file are not cut.
    let path = folder.path().join("film.tif");
    stack(&path);
    let film = BurstFiles { name: "film".into(), paths: vec![path.clone()] };
    let error = cut_sequence(&film, cut).expect_err("a stack");
    assert!(matches!(error, OpenError::CutStack { path: ref at, frames: 2 } if *at == path), "{error}");
    let error = cut_sequence(sequence, cut).expect_err("a stack among frames");
    assert!(matches!(error, OpenError::CutStack { .. }), "{error}");
}

#[test]
fn several_stacks_are_several_bursts() {
    let folder = folder();
    let paths = [folder.path().join("b.tif"), folder.path().join("a.npy")];
    stack(&paths[0]);
    ndarray_npy::write_npy(&paths[1], &ndarray::Array3::<u8>::zeros((3, 2, 2))).expect("written");
    assert_eq!(names(&paths), ["b", "a"]);
    assert_eq!(names(&[folder.path().to_path_buf()]), ["a", "b"]);
    // A stack alone in its folder is the folder's burst, and has the folder's name.
    fs::remove_file(&paths[1]).expect("removed");
    let burst = Burst::open(folder.path()).expect("opens");
    assert_eq!((burst.len(), burst.name), (2, folder.path().file_name().expect("name").to_string_lossy().into_owned()));
    // Beside single pictures it would be both a frame and a burst.
    let picture = folder.path().join("1.png");
    save(&picture, &grey8(2, 1, 0));
    let error = open(&[picture, paths[0].clone()]).expect_err("mixed");
    assert!(matches!(error, OpenError::StackAmongFrames { ref path, frames: 2 } if *path == paths[0]), "{error}");
    let error = Burst::open(folder.path()).expect_err("mixed");
    assert!(matches!(error, OpenError::StackAmongFrames { ref path, .. } if *path == paths[0]), "{error}");
}

#[test]
fn bursts_of_one_name_are_numbered() {
    let folder = folder();
    let inputs: Vec<PathBuf> = ["a/night", "b/Night", "c/night"].iter().map(|p| folder.path().join(p)).collect();
    for path in &inputs {
        fs::create_dir_all(path).expect("made");
        save(&path.join("1.png"), &grey8(2, 1, 0));
    }
    assert_eq!(names(&inputs), ["night", "Night-2", "night-3"]);
}

#[test]
fn folders_without_a_last_name_have_one() {
    let folder = folder();
    save(&folder.path().join("1.png"), &grey8(2, 1, 0));
    fs::create_dir(folder.path().join("sub")).expect("made");
    let name = folder.path().file_name().expect("named").to_string_lossy().into_owned();
    assert_eq!(names(&[folder.path().join("sub/..")]), [name.as_str()]);
    assert_eq!(names(&[folder.path().join(".")]), [name]);
}

#[test]
fn every_supported_ending_can_be_opened() {
    let folder = folder();
    for extension in supported_extensions() {
        let path = folder.path().join(format!("a.{extension}"));
        match extension {
            "npy" => ndarray_npy::write_npy(&path, &ndarray::Array2::<u8>::zeros((2, 3))).expect("written"),
            "ppm" => save(&path, &image::RgbImage::new(3, 2)),
            "webp" => save(&path, &image::RgbImage::new(3, 2)),
            "pbm" => fs::write(&path, "P1\n3 2\n1 0 1\n0 1 0\n").expect("written"),
            "pnm" => fs::write(&path, "P2\n3 2\n9\n1 0 1\n0 1 0\n").expect("written"),
            "pam" => {
                let header = "P7\nWIDTH 3\nHEIGHT 2\nDEPTH 1\nMAXVAL 255\nTUPLTYPE GRAYSCALE\nENDHDR\n";
                fs::write(&path, format!("{header}abcdef")).expect("written");
            }
            "png" | "tif" | "tiff" | "jpg" | "jpeg" | "pgm" | "bmp" => save(&path, &image::GrayImage::new(3, 2)),
            // Extensions of raw files, which have separate tests; the kind is recognised by the content.
            _ => {
                let png = folder.path().join("really.png");
                save(&png, &image::GrayImage::new(3, 2));
                fs::rename(&png, &path).expect("renamed");
            }
        }
        let burst = Burst::open(&path).expect(extension);
        assert_eq!(burst.size(), (3, 2), "{extension}");
    }
    assert_eq!(Burst::open(folder.path()).expect("all together").len(), supported_extensions().len());
}

#[test]
fn the_content_tells_the_kind_not_the_name() {
    let folder = folder();
    let path = folder.path().join("really_a_png.jpg");
    save(&folder.path().join("a.png"), &grey8(3, 2, 0));
    fs::rename(folder.path().join("a.png"), &path).expect("renamed");
    assert_eq!(Burst::open(&path).expect("opens").size(), (3, 2));
    let odd = folder.path().join("no_ending");
    fs::copy(&path, &odd).expect("copied");
    assert_eq!(Burst::open(&odd).expect("opens").size(), (3, 2));
}
