//! Tests of `dataset::source`.

use burstscope_core::burst::*;
use burstscope_core::dataset::*;
use std::path::Path;

fn film(folder: &Path, frames: usize) {
    std::fs::create_dir_all(folder).expect("made");
    let frame = image::GrayImage::from_pixel(4, 4, image::Luma([9]));
    (0..frames).for_each(|t| frame.save(folder.join(format!("f{t}.png"))).expect("written"));
}

fn names(source: &DatasetSource) -> Vec<String> {
    source.bursts(&OpenOptions::default()).expect("bursts").into_iter().map(|b| b.name).collect()
}

#[test]
fn folders_of_bursts_and_cut_sequences() {
    let home = tempfile::tempdir().expect("a folder");
    film(&home.path().join("nights/a"), 2);
    film(&home.path().join("nights/b"), 5);
    let nights = DatasetSource::of_bursts(vec![home.path().join("nights")]);
    assert_eq!(names(&nights), ["a", "b"]);
    let one = DatasetSource { paths: vec![home.path().join("nights/b")], burst_length: Some(2), burst_step: None };
    assert_eq!(names(&one), ["f1", "f3"]);
    let overlapping = DatasetSource { burst_step: Some(1), ..one.clone() };
    assert_eq!(names(&overlapping), ["f1", "f2", "f3", "f4"]);
    let both = DatasetSource { burst_length: Some(2), ..nights.clone() };
    assert_eq!(names(&both), ["a_f1", "b_f1", "b_f3"]);
    for (wrong, words) in [
        (DatasetSource { burst_length: Some(3), ..nights.clone() }, "2 frames"),
        (DatasetSource { burst_length: Some(0), ..nights.clone() }, "1"),
        (DatasetSource::of_bursts(vec![home.path().join("gone")]), "gone"),
        (DatasetSource::of_bursts(Vec::new()), "nothing"),
    ] {
        let error = wrong.bursts(&OpenOptions::default()).expect_err(words).to_string();
        assert!(error.contains(words), "{error}");
    }
    assert_eq!(nights.default_folder(), Some(home.path().join("nights-burstscope")));
    assert_eq!(one.default_folder(), Some(home.path().join("nights/b-burstscope-2")));
    assert_eq!(overlapping.default_folder(), Some(home.path().join("nights/b-burstscope-2-1")));
    assert_eq!(nights.label(), "nights");
}
