//! Export of a dataset to COLMAP: the written files, resuming without repeated work, and, where pycolmap is installed,
//! reading by COLMAP.

use crate::prelude::*;
use burstscope_core::dataset::{
    BurstCameras, BurstEvent, BurstPicture, CameraChoice, ColmapJob, ColmapReport, FeatureJob, FeatureStore, ImageKind,
    burst_plane, export_colmap,
};
use burstscope_core::detect::Searched;
use burstscope_core::detector::view::{in_focus_view, stack_view};
use burstscope_core::export::{ColmapKeypoint, pair_id, read_colmap};
use burstscope_core::matching::{Camera, PairSelection};
use burstscope_lab::synth::{SceneParams, synth_scene, write_burst};
use rusqlite::Connection;
use std::process::Command;

pub const SIZE: (usize, usize) = (260, 200);

/// Three bursts of five frames, cut from one walk past a layered scene in a folder, and a place for what is made.
pub fn walk() -> (Folder, Vec<BurstFiles>, PathBuf) {
    let (home, out) = folder_with("out");
    let scene = SceneParams { width: SIZE.0, height: SIZE.1, frames: 15, ..SceneParams::default() };
    let params = SceneParams { max_slope: 1.5, snr: 20.0, seed: 3, ..scene };
    let (burst, truth) = synth_scene(&params, &quiet()).expect("a scene");
    let film = home.join("film");
    write_burst(&film, &burst, &truth, &quiet()).expect("written");
    let sequence = &find_bursts(&[film], &OpenOptions::default()).expect("one sequence")[0];
    let cut = SequenceCut::new(5, None).expect("a cut");
    (home, cut_sequence(sequence, cut, &OpenOptions::default()).expect("three bursts"), out)
}

/// A job with few slopes and an unknown camera.
pub fn job() -> ColmapJob {
    ColmapJob {
        features: FeatureJob {
            detector: DetectorParams { slopes: SlopeGrid::line(-2.0..=2.0, 5), ..DetectorParams::default() }.into(),
            open: OpenOptions::default(),
            images: ImageKind::default(),
        },
        matching: MatchParams::default(),
        pairs: PairSelection::All,
        cameras: BurstCameras::default(),
    }
}

pub fn export(bursts: &[BurstFiles], out: &Path, job: &ColmapJob) -> (Result<ColmapReport, Error>, Vec<String>) {
    let mut failed = Vec::new();
    let mut on = |event: BurstEvent<'_>| {
        if let BurstEvent::Failed(index, _) = event {
            failed.push(bursts[index].name.clone());
        }
    };
    let report = FeatureStore::open(out, &job.features)
        .and_then(|mut store| export_colmap(&mut store, bursts, job, &mut on, &quiet()));
    (report, failed)
}

fn written(known: bool) -> (Folder, ColmapReport, PathBuf) {
    let (home, bursts, out) = walk();
    let mut job = job();
    if known {
        job.cameras.rest = CameraChoice::Known(Camera::centred(SIZE.0, SIZE.1, 250.0));
        job.matching.geometry = Geometry::Essential;
    }
    let (report, failed) = export(&bursts, &out, &job);
    assert!(failed.is_empty());
    (home, report.expect("written"), out)
}

#[test]
fn files_and_tables_agree() {
    let (home, report, out) = written(false);
    let names: Vec<&str> = report.images.iter().map(|i| i.image.as_str()).collect();
    assert_eq!(names, ["frame_002.png", "frame_007.png", "frame_012.png"]);
    assert_eq!(report.cameras[0].camera.to_string(), "SIMPLE_RADIAL 260 200 312 130 100 0");
    assert!(!report.known_camera);
    let db = Connection::open(&report.database).expect("a database");
    for image in &report.images {
        let (keypoints, descriptors) =
            read_colmap(&out.join(format!("features/{}.txt", image.image))).expect("features");
        assert!(keypoints.len() > 50 && keypoints.len() == image.features, "{} features", image.features);
        let blob = |table: &str| {
            let sql = format!("SELECT data FROM {table} WHERE image_id = {}", image.id);
            db.query_row(&sql, [], |row| row.get::<_, Vec<u8>>(0)).expect("a row")
        };
        assert!(blob("descriptors") == descriptors.concat());
        // The file has the blobs' places; matches have moved those of the table.
        let number = |bytes: &[u8]| f32::from_le_bytes(bytes.try_into().expect("four bytes"));
        let table: Vec<f32> = blob("keypoints").chunks_exact(4).map(number).collect();
        assert_eq!(table.len(), 4 * keypoints.len());
        let moved = |(k, row): (&ColmapKeypoint, &[f32])| {
            assert_eq!(row[2..], [k.scale, k.orientation]);
            (row[0] - k.x).hypot(row[1] - k.y)
        };
        let moved: Vec<f32> = keypoints.iter().zip(table.chunks_exact(4)).map(moved).collect();
        let still = moved.iter().filter(|px| **px == 0.0).count();
        assert!(0 < still && still < moved.len() && moved.iter().all(|px| *px < 20.0), "{moved:?}");
        // The picture has the frames' size, and uses the whole range.
        let picture = image::open(report.images_folder.join(&image.image)).expect("a picture").into_luma8();
        assert_eq!(picture.dimensions(), (SIZE.0 as u32, SIZE.1 as u32));
        assert!(picture.iter().any(|&x| x < 5) && picture.iter().any(|&x| x > 250));
    }
    for pair in &report.pairs {
        let id = pair_id(pair.ids[0], pair.ids[1]) as i64;
        let rows = |table: &str| {
            db.query_row(&format!("SELECT rows FROM {table} WHERE pair_id = {id}"), [], |row| row.get::<_, u32>(0))
        };
        assert_eq!(rows("matches"), Ok(pair.counts.putative as u32));
        assert_eq!(rows("two_view_geometries").ok(), pair.counts.inliers.map(|n| n as u32));
    }
    assert!(report.pairs[0].counts.inliers.is_some_and(|n| n > 30), "{:?}", report.pairs[0]);
    // The picture of a burst is its middle frame.
    let burst = Burst::open(home.join("film/frame_007.png")).expect("a frame");
    let picture = image::open(report.images_folder.join("frame_007.png")).expect("a picture").into_luma8();
    let (mut a, mut b): (Vec<f32>, Vec<f32>) = (Vec::new(), Vec::new());
    for (u, v) in (0..SIZE.0).flat_map(|u| (0..SIZE.1).map(move |v| (u, v))) {
        a.push(burst.frames[0].at(u, v));
        b.push(f32::from(picture.get_pixel(u as u32, v as u32)[0]));
    }
    let mean = |x: &[f32]| x.iter().sum::<f32>() / x.len() as f32;
    let (ma, mb) = (mean(&a), mean(&b));
    let dot = |x: &[f32], mx: f32, y: &[f32], my: f32| x.iter().zip(y).map(|(x, y)| (x - mx) * (y - my)).sum::<f32>();
    let correlation = dot(&a, ma, &b, mb) / (dot(&a, ma, &a, ma) * dot(&b, mb, &b, mb)).sqrt();
    assert!(correlation > 0.99, "{correlation}");
}

fn python() -> String {
    std::env::var("BURSTSCOPE_PYTHON").unwrap_or_else(|_| "python3".to_owned())
}

/// Prints everything that COLMAP finds in the database, as JSON, and for each pair the largest error of its inliers
/// under its own geometry, in COLMAP's pixels.
const READ_ALL: &str = r#"
import json, sys
import numpy as np
import pycolmap

database = pycolmap.Database.open(sys.argv[1]) if hasattr(pycolmap.Database, "open") else pycolmap.Database(sys.argv[1])
number = lambda x: x() if callable(x) else x
images = database.read_all_images()
keypoints = {i.image_id: np.asarray(database.read_keypoints(i.image_id)) for i in images}
descriptors = {}
for i in images:
    d = database.read_descriptors(i.image_id)
    descriptors[i.image_id] = np.asarray(d.data if hasattr(d, "data") and not isinstance(d, np.ndarray) else d)
cameras = {c.camera_id: c for c in database.read_all_cameras()}
pairs = []
for a in images:
    for b in images:
        if a.image_id < b.image_id:
            geometry = database.read_two_view_geometry(a.image_id, b.image_id)
            inliers = np.asarray(geometry.inlier_matches)
            xa, xb = keypoints[a.image_id][inliers[:, 0], :2], keypoints[b.image_id][inliers[:, 1], :2]
            one = np.ones((len(inliers), 1))
            F, E = geometry.F, geometry.E
            if E is not None and np.any(E):
                K = cameras[a.camera_id].calibration_matrix()
                F = np.linalg.inv(K).T @ E @ np.linalg.inv(K)
            xa, xb = np.hstack([xa, one]), np.hstack([xb, one])
            la, lb = xb @ F, xa @ F.T
            sampson = np.abs(np.sum(xb * lb, axis=1)) / np.sqrt(la[:, 0]**2 + la[:, 1]**2 + lb[:, 0]**2 + lb[:, 1]**2)
            pose = geometry.cam2_from_cam1
            pairs.append({
                "ids": [a.image_id, b.image_id], "matches": len(np.asarray(database.read_matches(a.image_id, b.image_id))),
                "inliers": len(inliers), "config": int(geometry.config), "worst": float(sampson.max()), "rms": float(np.sqrt((sampson**2).mean())),
                "pose": None if pose is None else [float(x) for x in pose.translation],
            })
print(json.dumps({
    "images": [{"id": i.image_id, "name": i.name, "camera": i.camera_id} for i in images],
    "cameras": [{"model": c.model.name if hasattr(c.model, "name") else str(c.model), "width": c.width, "params": [float(p) for p in c.params],
                 "prior": bool(c.has_prior_focal_length)} for c in cameras.values()],
    "frames": number(database.num_frames) if hasattr(database, "num_frames") else None,
    "keypoints": {str(k): [float(x) for x in v.flatten()] for k, v in keypoints.items()},
    "descriptors": {str(k): int(v.astype(np.int64).sum()) for k, v in descriptors.items()},
    "pairs": pairs,
}))
"#;

#[needs::pycolmap]
#[test]
fn colmap_reads_what_was_written() {
    for known in [false, true] {
        let (_home, report, out) = written(known);
        let answer = Command::new(python()).args(["-c", READ_ALL]).arg(&report.database).output().expect("it starts");
        assert!(answer.status.success(), "{}", String::from_utf8_lossy(&answer.stderr));
        let json: serde_json::Value = serde_json::from_slice(&answer.stdout).expect("JSON");
        let camera = &json["cameras"][0];
        let model = if known { "SIMPLE_PINHOLE" } else { "SIMPLE_RADIAL" };
        assert_eq!((camera["model"].as_str(), camera["width"].as_u64()), (Some(model), Some(SIZE.0 as u64)));
        assert_eq!(camera["params"].as_array().map(Vec::len), Some(report.cameras[0].camera.params.len()));
        assert_eq!(camera["prior"], known);
        if let Some(frames) = json["frames"].as_u64() {
            assert_eq!(frames, 3);
        }
        for image in &report.images {
            let id = image.id.to_string();
            assert!(
                json["images"]
                    .as_array()
                    .is_some_and(|all| all.iter().any(|i| i["name"] == image.image.as_str() && i["id"] == image.id))
            );
            let (keypoints, descriptors) =
                read_colmap(&out.join(format!("features/{}.txt", image.image))).expect("features");
            let expected: Vec<f32> = keypoints.iter().flat_map(|k| [k.x, k.y, k.scale, k.orientation]).collect();
            let read: Vec<f32> = json["keypoints"][&id]
                .as_array()
                .expect("numbers")
                .iter()
                .map(|x| x.as_f64().unwrap_or_default() as f32)
                .collect();
            assert_eq!(read, expected);
            let sum: u64 = descriptors.as_flattened().iter().map(|&x| u64::from(x)).sum();
            assert_eq!(json["descriptors"][&id], sum);
        }
        for (pair, read) in report.pairs.iter().zip(json["pairs"].as_array().expect("pairs")) {
            assert_eq!(read["matches"].as_u64(), Some(pair.counts.putative as u64));
            assert_eq!(read["inliers"].as_u64().map(|n| n as usize), pair.counts.inliers);
            assert_eq!(read["config"], if known { 2 } else { 3 });
            // In COLMAP's pixels the inliers agree with the geometry as they did in ours: half a pixel off would show
            // where lines are not parallel.
            assert!(read["worst"].as_f64().is_some_and(|worst| worst <= 4.01), "{read}");
            let length = |t: &serde_json::Value| {
                t.as_array().map(|t| t.iter().filter_map(|x| x.as_f64()).map(|x| x * x).sum::<f64>())
            };
            if known {
                assert!(length(&read["pose"]).is_some_and(|length| (length - 1.0).abs() < 1e-9), "{read}");
            }
        }
    }
}

/// Prints for each pair the number of inliers of COLMAP's fundamental matrix from the same matches, with the same
/// largest error.
const ESTIMATE_ALL: &str = r#"
import json, sys
import numpy as np
import pycolmap

database = pycolmap.Database.open(sys.argv[1]) if hasattr(pycolmap.Database, "open") else pycolmap.Database(sys.argv[1])
options = pycolmap.RANSACOptions()
options.max_error = 4.0
if hasattr(options, "random_seed"):
    options.random_seed = 0
counts = []
for a, b in json.loads(sys.argv[2]):
    matches = np.asarray(database.read_matches(a, b))
    xa, xb = np.asarray(database.read_keypoints(a)), np.asarray(database.read_keypoints(b))
    found = pycolmap.estimate_fundamental_matrix(xa[matches[:, 0], :2].astype(float), xb[matches[:, 1], :2].astype(float), options)
    counts.append(found["num_inliers"] if found else 0)
print(json.dumps(counts))
"#;

#[needs::pycolmap]
#[test]
fn inliers_are_as_many_as_colmaps() {
    let (_home, report, _) = written(false);
    let pairs: Vec<[u32; 2]> = report.pairs.iter().map(|pair| pair.ids).collect();
    let pairs = serde_json::to_string(&pairs).expect("JSON");
    let answer = Command::new(python()).args(["-c", ESTIMATE_ALL]).arg(&report.database).arg(pairs).output();
    let answer = answer.expect("it starts");
    assert!(answer.status.success(), "{}", String::from_utf8_lossy(&answer.stderr));
    let theirs: Vec<usize> = serde_json::from_slice(&answer.stdout).expect("counts");
    for (pair, theirs) in report.pairs.iter().zip(theirs) {
        let ours = pair.counts.inliers.expect("verified");
        println!("of {} matches: {ours} inliers, COLMAP {theirs}", pair.counts.putative);
        assert!(ours * 100 >= theirs * 97, "{ours} and {theirs}");
    }
}

#[test]
fn each_image_refers_to_its_own_camera_and_pairs_of_other_cameras_are_matched_anew() {
    let (_home, bursts, out) = walk();
    let names = ["frame_002", "frame_007", "frame_012"];
    let of = |focal_px| Camera::centred(SIZE.0, SIZE.1, focal_px);
    let own = |focal_px, from: &str| CameraChoice::Own(of(focal_px), from.into());
    let job = |own: &[(&str, CameraChoice)], rest| {
        let own = own.iter().map(|(name, choice)| ((*name).to_owned(), choice.clone())).collect();
        let matching = MatchParams { geometry: Geometry::Essential, ..MatchParams::default() };
        ColmapJob { cameras: BurstCameras { own, rest }, matching, ..job() }
    };
    let known = CameraChoice::Known(of(250.0));
    let database = || fs::read(out.join("database.db")).expect("a file");
    // One camera for all, and equal ones from two files: one row, and pairs that are matched once.
    let report = done(&bursts, &out, &job(&[], known.clone()));
    assert_eq!((report.cameras.len(), &report.cameras[0].images, report.known_camera), (1, &vec![1, 2, 3], true));
    let first = database();
    let equal = [own(250.0, "a.toml"), own(250.0, "b.toml"), own(250.0, "a.toml")];
    let equal: Vec<(&str, CameraChoice)> = names.into_iter().zip(equal).collect();
    let report = done(&bursts, &out, &job(&equal, CameraChoice::default()));
    assert!(database() == first && report.pairs.iter().all(|pair| pair.resumed) && report.known_camera);
    assert_eq!((report.cameras.len(), &report.cameras[0].from), (1, &vec!["a.toml".into(), "b.toml".into()]));
    // Another camera for the last: its pairs alone are matched again, with both cameras.
    let table = |report: &ColmapReport| -> (Vec<(u32, u32)>, Vec<u32>) {
        let db = Connection::open(&report.database).expect("a database");
        let rows = |sql: &str| {
            let mut query = db.prepare(sql).expect("a query");
            let rows = query.query_map([], |row| Ok((row.get(0)?, row.get(1)?))).expect("rows");
            rows.collect::<Result<Vec<(u32, u32)>, _>>().expect("numbers")
        };
        let images =
            "SELECT camera_id, prior_focal_length FROM images JOIN cameras USING (camera_id) ORDER BY image_id";
        let kinds = rows("SELECT config, rows FROM two_view_geometries WHERE config > 1 ORDER BY pair_id");
        (rows(images), kinds.into_iter().map(|(config, _)| config).collect())
    };
    let report = done(&bursts, &out, &job(&[("frame_012", own(245.0, "c.toml"))], known));
    let matched_before = |report: &ColmapReport| report.pairs.iter().map(|pair| pair.resumed).collect::<Vec<_>>();
    assert_eq!(matched_before(&report), [true, false, false]);
    let (cameras, kinds) = table(&report);
    assert_eq!((cameras, report.known_camera), (vec![(1, 1), (1, 1), (2, 1)], true));
    assert!(kinds.contains(&2) && !kinds.contains(&3), "essential matrices: {kinds:?}");
    // A pair of which one camera is unknown has a fundamental matrix.
    let report = done(&bursts, &out, &job(&[("frame_012", own(245.0, "c.toml"))], CameraChoice::default()));
    assert_eq!(matched_before(&report), [false; 3]);
    let (cameras, kinds) = table(&report);
    assert_eq!((cameras, report.known_camera), (vec![(1, 0), (1, 0), (2, 1)], false));
    assert!(kinds.contains(&3) && !kinds.contains(&2), "fundamental matrices: {kinds:?}");
    let wrong = CameraChoice::Own(Camera::centred(9, 9, 9.0), "c.toml".into());
    let (refused, _) = export(&bursts, &out, &job(&[("frame_012", wrong)], CameraChoice::default()));
    says(refused.expect_err("another size"), &["c.toml", "9×9"]);
}

fn done(bursts: &[BurstFiles], out: &Path, job: &ColmapJob) -> ColmapReport {
    let (report, failed) = export(bursts, out, job);
    assert!(failed.is_empty(), "{failed:?}");
    report.expect("written")
}

fn resumed(report: &ColmapReport) -> Vec<bool> {
    report.images.iter().map(|i| i.resumed).collect()
}

#[test]
fn a_stack_has_all_depths_in_focus_and_is_the_same_if_it_is_asked_for_later() {
    let (home, bursts, out) = walk();
    // Slopes that are found, so that a later run has to know them.
    let found = FeatureJob { detector: SearchParams::default(), ..job().features };
    let stacked = ColmapJob { features: FeatureJob { images: ImageKind::Stack, ..found.clone() }, ..job() };
    let picture = |folder: &str| fs::read(home.join(folder).join("images/frame_007.png")).expect("a picture");
    done(&bursts, &out, &ColmapJob { features: found, ..job() });
    let middle = picture("out");
    assert_eq!(resumed(&done(&bursts, &out, &stacked)), [true; 3]);
    done(&bursts, &home.join("new"), &stacked);
    assert!(picture("out") != middle && picture("out") == picture("new"));
    let monitor = Monitor::default();
    let burst = open_burst(&bursts[1].paths, &OpenOptions::default(), &monitor).expect("a burst");
    let Searched { params, .. } = search(&burst, &SearchParams::default(), &monitor).expect("features");
    let in_focus = in_focus_view(&burst, &params, &monitor).expect("known slopes").expect("a field");
    let written = image::open(out.join("images/frame_007.png")).expect("a picture").into_rgb8();
    assert!(written.into_raw() == BurstPicture::small(&in_focus, SIZE.0).rgb);
    // With one slope there is no field to find: it is the picture's.
    let slope = Slope::new(1.0, 0.0);
    let one = DetectorParams { slopes: SlopeGrid::single(slope), ..params };
    let picture = burst_plane(&burst, ImageKind::Stack, &one, &monitor).expect("a picture");
    assert!(picture.data() == stack_view(&burst, &one, slope, &monitor).expect("a stack").data());
    let mut sift = stacked;
    sift.features.detector.method = Method::Sift;
    let refused = export(&bursts, &home.join("sift"), &sift).0.expect_err("another time").to_string();
    assert!(refused.contains("images: a stack shows mid-burst") && !home.join("sift").exists(), "{refused}");
}

#[test]
fn an_interrupted_run_is_continued_and_what_makes_no_sense_is_said_before_anything_is_done() {
    let (_home, bursts, out) = walk();
    let monitor = Monitor::default();
    let mut on = |event: BurstEvent<'_>| {
        if let BurstEvent::Done(..) = event {
            monitor.cancel();
        }
    };
    let mut store = FeatureStore::open(&out, &job().features).expect("a new folder");
    let stopped = export_colmap(&mut store, &bursts, &job(), &mut on, &monitor);
    drop(store);
    assert!(stopped.as_ref().is_err_and(|error| error.is_cancelled()), "{stopped:?}");
    assert!(!out.join("database.db").exists());
    assert_eq!(resumed(&done(&bursts, &out, &job())), [true, false, false]);
    let (home, bursts, out) = walk();
    let error = |job: ColmapJob| export(&bursts, &out, &job).0.expect_err("refused").to_string();
    let unverified = MatchParams { geometry: Geometry::None, ..MatchParams::default() };
    assert!(error(ColmapJob { matching: unverified, ..job() }).contains("geometry"));
    let calibrated = MatchParams { geometry: Geometry::Essential, ..MatchParams::default() };
    assert!(error(ColmapJob { matching: calibrated, ..job() }).contains("camera"));
    let mut nonsense = job();
    nonsense.features.detector.levels = 0;
    assert!(error(nonsense).contains("levels"));
    assert!(!out.exists());
    let (too_few, _) = export(&bursts[..1], &home.join("one"), &job());
    assert!(too_few.is_err_and(|error| error.problem.starts_with("1 burst has features")));
}
