//! Tests of `export::outputs`.
#![allow(unused_imports)]

use burstscope_core::detector::SearchParams;
use burstscope_core::error::*;
use burstscope_core::export::case::{Case, Enclosed, write_case};
use burstscope_core::export::film::write_film;
use burstscope_core::export::*;
use burstscope_core::export::{
    CURVE_COLUMNS, ColmapKeypoint, Drawing, Picture, PictureProfile, sheet, write_colmap_keypoints, write_csv,
    write_drawing_svg, write_matches_csv, write_npz, write_png, write_profiles_csv, write_tiff,
};
use burstscope_core::files::mark::Kind;
use burstscope_core::files::mark::*;
use burstscope_core::files::*;
use burstscope_core::monitor::Monitor;
use burstscope_core::plane::Plane;
use std::collections::HashSet;
use std::fs::Metadata;
use std::path::{Path, PathBuf};

#[test]
fn every_file_that_is_written_is_known_until_somebody_changes_it() {
    let home = tempfile::tempdir().expect("a folder");
    let at = |name: &str| home.path().join(name);
    write_png(&at("a.png"), Picture::rgb(2, 1, &[9; 6])).expect("written");
    write_tiff(&at("a.tiff"), &Plane::from_fn(400, 300, |u, v| (u * v) as f32)).expect("written");
    let pictures = (2, [9, 8].map(|_| Ok(image::RgbaImage::new(9, 9))));
    write_film(&at("a.gif"), pictures, 10, &Monitor::default()).expect("written");
    let unit = burstscope_core::export::FigureUnit::Pixel;
    let drawing = Drawing { title: "a".into(), size: [10.0, 10.0], unit, shapes: Vec::new() };
    write_drawing_svg(&at("a.svg"), &drawing).expect("written");
    let parts = vec![sheet::Sheet::new(80.0, "b").finish(40.0); 2];
    write_text(&at("b.svg"), Kind::Drawing, sheet::stacked("both", &parts)).expect("written");
    write_text(&at("p.toml"), Kind::Settings, burstscope_core::files::written_by() + "levels = 4\n").expect("written");
    let burst = burstscope_core::burst::Burst::from_planes("a", vec![Plane::zeros(9, 9)]);
    let (case, part) =
        Case::of(&burst, &SearchParams::default(), (None, None), "", &Monitor::default()).expect("nobody cancels");
    write_case(&at("a.burstcase"), (&case, &part), &Enclosed::default(), &Monitor::default()).expect("written");
    write_npz(&at("a.npz"), &[], &[]).expect("written");
    write_csv(&at("a.csv"), &[]).expect("written");
    write_matches_csv(&at("m.csv"), &[]).expect("written");
    let profile = PictureProfile { picture: "a \"b\", c".into(), samples: Vec::new() };
    write_profiles_csv(&at("p.csv"), &[profile]).expect("written");
    std::fs::write(at("c.csv"), format!("{CURVE_COLUMNS}\n")).expect("written");
    write_colmap_keypoints(&at("a.txt"), &[KEYPOINT], &[[7; 128]]).expect("written");
    let mut known = 0;
    for entry in std::fs::read_dir(home.path()).expect("a folder") {
        let path = entry.expect("an entry").path();
        assert!(is_ours(&path), "{}", path.display());
        // A byte of the pixels or the text is changed; then one more comes at the end.
        let bytes = std::fs::read(&path).expect("read");
        let place = if path.ends_with("a.tiff") { 2000 } else { 60.min(bytes.len() / 2) };
        for changed in
            [[&bytes[..place], &[bytes[place] ^ 1], &bytes[place + 1..]].concat(), [&bytes[..], b"?"].concat()]
        {
            std::fs::write(&path, &changed).expect("written");
            let is_longer_tiff = path.ends_with("a.tiff") && changed.len() > bytes.len();
            assert_eq!(is_ours(&path), is_longer_tiff, "{}", path.display());
        }
        known += 1;
    }
    assert_eq!(known, 13);
}

const KEYPOINT: ColmapKeypoint = ColmapKeypoint { x: 10.25, y: 0.1, scale: 1.6, orientation: -3.0 };

#[test]
fn files_of_others_are_not_taken_for_ours() {
    let home = tempfile::tempdir().expect("a folder");
    let at = |name: &str| home.path().join(name);
    for name in ["a.png", "a.tiff", "a.jpg"] {
        image::GrayImage::from_pixel(8, 8, image::Luma([9])).save(at(name)).expect("written");
        assert!(!is_ours(&at(name)), "{name}");
    }
    let numbers = |first: &str| format!("1 128\n{first} 0.1 1.6 -3{}\n", " 7".repeat(128));
    std::fs::write(at("x"), numbers("10.25")).expect("written");
    assert!(is_ours(&at("x")), "as this program writes it");
    let texts = ["", "\n", " 128\n", "12 a 128", "0 127\n", "2 128\n", "PK\u{3}\u{4}", "II*\0", "SQLite format 3\0"];
    let more = [
        &numbers("10.250000"),
        "u,v\n1,2\n",
        "u,v,sigma\n",
        "set,plot,curve,x,y,low,high\nmine\n",
        "about Burstscope 0.1.0: # Written by Burstscope 0.1.0\n",
        "# Written by Burstscope 0.1.0\nlevels = 4\n",
        "<svg><!-- Written by Burstscope 0.1.0 --></svg>",
    ];
    for text in texts.into_iter().chain(more) {
        std::fs::write(at("x"), text).expect("written");
        assert!(!is_ours(&at("x")), "{text:?}");
    }
    assert!(!is_ours(home.path()) && !is_ours(&at("none")));
}
