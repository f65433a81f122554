//! Cases, of the whole burst and of a part: what was written comes back.

use crate::prelude::*;
use burstscope_core::export::case::{Case, Enclosed, has_truth, read_case, read_session, read_truth, write_case};
use burstscope_core::files::MAX_SESSION_BYTES;
use std::io::{Cursor, Write};
use zip::{ZipArchive, ZipWriter, write::SimpleFileOptions};

fn chart() -> (Burst, Truth) {
    let chart = ChartParams { width: 96, height: 64, discs: 3, frames: 4, radius: 3.6..=8.0, ..ChartParams::default() };
    synth_chart(&chart, &quiet()).expect("a chart")
}

fn written(case: &Case, burst: &Burst, enclosed: &Enclosed) -> (Folder, PathBuf) {
    let (home, path) = folder_with("a.burstcase");
    write_case(&path, (case, burst), enclosed, &quiet()).expect("written");
    (home, path)
}

#[test]
fn a_case_comes_back_as_it_was() {
    let (burst, truth) = chart();
    let search = SearchParams::default();
    let of = |place, note: &str| Case::of(&burst, &search, place, note, &quiet()).expect("whole");
    let (case, part) = of((Some([40.0, 30.0]), None), "why not this one?");
    // A masked frame comes back masked, and its seen values to the bit.
    let mask = Mask::new(Plane::from_fn(96, 64, |u, v| f32::from(u > 20 || v > 9)));
    let frames = part.frames.iter().map(|frame| Arc::new(Plane::clone(frame).masked(mask.clone()))).collect();
    let masked = Burst { frames, ..part.clone() };
    let whole = Case::of(&masked, &search, (None, None), "", &quiet()).expect("not cancelled").0;
    let (_home, path) = written(&whole, &masked, &Enclosed::default());
    let back = read_case(&path, &Limits::default(), &quiet()).expect("read").1;
    assert!(back.frames == masked.frames);
    let views = Burst { positions: Positions::grid(2, 2), ..part.clone() };
    let of_views = Case::of(&views, &search, (None, None), "", &quiet()).expect("not cancelled").0;
    let (_home, path) = written(&of_views, &views, &Enclosed::default());
    let back = read_case(&path, &Limits::default(), &quiet()).expect("read").1;
    assert_eq!(back.positions, views.positions);
    // A case without session and truth.
    let (_home, path) = written(&case, &part, &Enclosed::default());
    assert!(!has_truth(&path));
    assert!(matches!((read_session(&path), read_truth(&path)), (Ok(None), Ok(None))));
    let enclosed = Enclosed { session: Some("version = 3\n".to_owned()), truth: Some(truth.clone()) };
    let (_home, path) = written(&case, &part, &enclosed);
    assert!(has_truth(&path));
    assert_eq!(read_session(&path).expect("read"), enclosed.session);
    assert_eq!(read_truth(&path).expect("read"), enclosed.truth);
    let (read, back) = read_case(&path, &Limits::default(), &quiet()).expect("read");
    assert_eq!(read, case);
    assert!(back.frames == burst.frames, "12-bit values are exact");
    assert!(fs::metadata(&path).expect("a file").len() <= case.estimated_bytes());
    let (case, part) = of((Some([90.0, 30.0]), Some(10)), "");
    assert_eq!((case.corner, case.size, case.place), ([80, 20], [16, 21], Some([10.0, 10.0])));
    assert_eq!(part.frames[1].at(3, 4), burst.frames[1].at(83, 24));
    let (_home, path) = written(&case, &part, &enclosed);
    let of_part = read_truth(&path).expect("read").expect("a truth");
    assert_eq!((of_part.width, of_part.height), (16, 21));
    let inside = truth.features.iter().filter(|one| one.u >= 79.5 && (19.5..40.5).contains(&one.v));
    assert_eq!(of_part.features.len(), inside.count());
    assert!(read_case(&path, &Limits::default(), &quiet()).expect("read").1.frames == part.frames);
}

#[test]
fn numbers_and_sizes_that_make_no_sense_and_endless_texts_are_refused() {
    let search = SearchParams::default();
    let (case, part) = Case::of(&chart().0, &search, (None, None), "", &quiet()).expect("whole");
    let good = || case.clone();
    for (lying, name) in [
        (Case { place: Some([1e9, 0.0]), ..good() }, "place: 1000000000"),
        (Case { place: Some([0.0, f32::NAN]), ..good() }, "place: NaN"),
        (Case { corner: [i64::MAX as usize, 0], ..good() }, "corner: "),
        (Case { size: [1_000_000_000, 64], ..good() }, "size: 1000000000"),
        (Case { frames: i64::MAX as usize, ..good() }, "frames: "),
        (Case { views: vec![[0.0, 0.0]; 4], ..good() }, "views: "),
        (Case { views: vec![[0.0, 0.0], [1.0, 0.0]], ..good() }, "views: "),
        (Case { binning: 0, ..good() }, "binning: 0; there are 1 to 64"),
        (Case { binning: 1_000_000_000, ..good() }, "binning: 1000000000; there are 1 to 64"),
        (Case { offset: 1e300, ..good() }, "offset: "),
        (Case { scale: f64::NAN, ..good() }, "scale: NaN"),
        (Case { scale: 0.0, ..good() }, "scale: 0"),
        (Case { full_scale: -1e9, ..good() }, "full_scale: -1000000000"),
        (Case { quantisation_step: f32::INFINITY, ..good() }, "quantisation_step: inf"),
    ] {
        let (_home, path) = written(&lying, &Burst { frames: Vec::new(), ..part.clone() }, &Enclosed::default());
        says(read_case(&path, &Limits::default(), &quiet()).expect_err(name), &["a.burstcase", name]);
    }
    let search = SearchParams::default();
    let (case, part) = Case::of(&chart().0, &search, (None, None), "", &quiet()).expect("whole");
    let (_home, path) = written(&case, &part, &Enclosed::default());
    let whole = fs::read(&path).expect("read");
    for (size, frames) in [([1 << 40, 1 << 40], 4), ([96, 64], 1 << 40), ([0, 64], 4), ([97, 64], 4), ([96, 64], 5)] {
        let lying = toml::to_string(&Case { size, frames, ..case.clone() }).expect("plain values");
        let mut good = ZipArchive::new(Cursor::new(&whole)).expect("a case is a ZIP");
        let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
        zip.start_file("case.toml", SimpleFileOptions::default()).expect("begun");
        zip.write_all(lying.as_bytes()).expect("written");
        for index in 0..good.len() {
            let entry = good.by_index_raw(index).expect("an entry");
            if entry.name() != "case.toml" {
                zip.raw_copy_file(entry).expect("copied");
            }
        }
        fs::write(&path, zip.finish().expect("zipped").into_inner()).expect("written");
        let error = read_case(&path, &Limits::default(), &quiet()).expect_err("a lie");
        assert_eq!(error.kind, ErrorKind::Content, "{error}");
    }
    // Not read to its end, whatever it unpacks to.
    let session = Some("#".repeat(MAX_SESSION_BYTES as usize + 1));
    let (_home, path) = written(&case, &part, &Enclosed { session, truth: None });
    says(read_session(&path).expect_err("too long"), &["session.toml", "larger"]);
}
