//! Finished bursts are not computed again, and foreign files are left unchanged.

use super::support::{SIZE, export, job, walk};
use burstscope_core::Monitor;
use burstscope_core::burst::BurstFiles;
use burstscope_core::dataset::{CameraChoice, ColmapJob, ColmapReport, DatasetError, Event, export_colmap};
use burstscope_core::matching::PairSelection;
use burstscope_core::matching::{Camera, Geometry, MatchParams};
use std::fs;
use std::path::Path;

fn done(bursts: &[BurstFiles], out: &Path, job: &ColmapJob) -> ColmapReport {
    let (report, failed) = export(bursts, out, job);
    assert!(failed.is_empty(), "{failed:?}");
    report.expect("written")
}

fn resumed(report: &ColmapReport) -> Vec<bool> {
    report.images.iter().map(|i| i.resumed).collect()
}

#[test]
fn a_second_run_finds_everything_done_and_writes_the_same_bytes() {
    let home = tempfile::tempdir().expect("a folder");
    let (bursts, out) = (walk(home.path()), home.path().join("out"));
    let database = || fs::read(out.join("database.db")).expect("a file");
    assert_eq!(resumed(&done(&bursts, &out, &job())), [false; 3]);
    let first = database();
    assert_eq!(resumed(&done(&bursts, &out, &job())), [true; 3]);
    assert!(database() == first, "features from files give the same database");
    // Missing or damaged files are made again, and nothing else.
    fs::remove_file(out.join("features/frame_007.png.txt")).expect("removed");
    assert_eq!(resumed(&done(&bursts, &out, &job())), [true, false, true]);
    fs::write(out.join("features/frame_002.png.txt"), "7 128\n").expect("written");
    assert_eq!(resumed(&done(&bursts, &out, &job())), [false, true, true]);
    fs::remove_file(out.join("images/frame_012.png")).expect("removed");
    assert_eq!(resumed(&done(&bursts, &out, &job())), [true; 3]);
    assert!(out.join("images/frame_012.png").is_file());
    assert!(database() == first);
    // Other pairs need no other features.
    let next_ones = ColmapJob { pairs: PairSelection::Sequential(1), ..job() };
    let report = done(&bursts, &out, &next_ones);
    assert_eq!((resumed(&report), report.pairs.len()), (vec![true; 3], 2));
}

#[test]
fn other_parameters_or_other_frames_are_other_features() {
    let home = tempfile::tempdir().expect("a folder");
    let (bursts, out) = (walk(home.path()), home.path().join("out"));
    done(&bursts, &out, &job());
    let mut weaker = job();
    weaker.features.detector.detector.edge_threshold *= 1.5;
    assert_eq!(resumed(&done(&bursts, &out, &weaker)), [false; 3]);
    // A frame that is written again has another time, whatever its content.
    let frame = home.path().join("film/frame_006.png");
    let bytes = fs::read(&frame).expect("a frame");
    fs::write(&frame, [&bytes[..], b"\0"].concat()).expect("written");
    assert_eq!(resumed(&done(&bursts, &out, &weaker)), [true, false, true]);
}

#[test]
fn an_interrupted_run_is_continued() {
    let home = tempfile::tempdir().expect("a folder");
    let (bursts, out) = (walk(home.path()), home.path().join("out"));
    let monitor = Monitor::default();
    let mut on = |event: Event<'_>| {
        if let Event::Done(_) = event {
            monitor.cancel();
        }
    };
    let stopped = export_colmap(&bursts, &out, &job(), &mut on, &monitor);
    assert!(matches!(stopped, Err(DatasetError::Cancelled(_))), "{stopped:?}");
    assert!(!out.join("database.db").exists());
    assert_eq!(resumed(&done(&bursts, &out, &job())), [true, false, false]);
}

#[test]
fn a_broken_burst_is_left_out_and_a_foreign_folder_left_alone() {
    let home = tempfile::tempdir().expect("a folder");
    let (bursts, out) = (walk(home.path()), home.path().join("out"));
    fs::write(home.path().join("film/frame_006.png"), "broken").expect("written");
    let (report, failed) = export(&bursts, &out, &job());
    let report = report.expect("written");
    assert_eq!((failed, report.images.len(), report.pairs.len()), (vec!["frame_007".to_owned()], 2, 1));
    let (too_few, _) = export(&bursts[..1], &home.path().join("one"), &job());
    assert!(matches!(too_few, Err(DatasetError::TooFew { count: 1 })));
    let own = home.path().join("own");
    fs::create_dir(&own).expect("made");
    fs::write(own.join("thesis.txt"), "precious").expect("written");
    let (occupied, _) = export(&bursts, &own, &job());
    assert!(matches!(occupied, Err(DatasetError::Occupied(_))));
    assert_eq!(fs::read_dir(&own).expect("a folder").count(), 1);
}

#[test]
fn what_makes_no_sense_is_said_before_anything_is_done() {
    let home = tempfile::tempdir().expect("a folder");
    let (bursts, out) = (walk(home.path()), home.path().join("out"));
    let error = |job: ColmapJob| export(&bursts, &out, &job).0.expect_err("refused").to_string();
    let unverified = MatchParams { geometry: Geometry::None, ..MatchParams::default() };
    assert!(error(ColmapJob { matching: unverified, ..job() }).contains("geometry"));
    let calibrated = MatchParams { geometry: Geometry::Essential, ..MatchParams::default() };
    assert!(error(ColmapJob { matching: calibrated, ..job() }).contains("camera"));
    let mut nonsense = job();
    nonsense.features.detector.detector.levels = 0;
    assert!(error(nonsense).contains("levels"));
    assert!(!out.exists());
    let small = CameraChoice::Known(Camera::centred(SIZE.0 / 2, SIZE.1 / 2, 100.0));
    assert!(error(ColmapJob { camera: small, ..job() }).contains("130×100"));
}
