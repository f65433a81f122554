//! The database for COLMAP as another program would read it: table by table, and byte by byte.

use crate::prelude::*;
use burstscope_core::{error::Result, export::*};
use nalgebra::{Isometry3, Matrix3, Vector3};
use rusqlite::Connection;

fn keypoints(count: usize) -> Vec<ColmapKeypoint> {
    let at = |k: usize| ColmapKeypoint { x: k as f32 + 0.5, y: 7.25, scale: 1.6, orientation: -0.1 * k as f32 };
    (0..count).map(at).collect()
}

fn descriptors(count: usize) -> Vec<Descriptor> {
    (0..count).map(|k| std::array::from_fn(|i| (i + 3 * k) as u8)).collect()
}

const CAMERA: [f64; 4] = [500.0, 320.0, 240.0, 0.1];

fn add_camera(database: &mut DatabaseWriter<'_>) -> Result<u32> {
    database.add_camera(2, (640, 480), &CAMERA, true)
}

/// A database of two images with four and three features, with matches and a geometry of every kind, in a folder of its
/// own within a temporary one, and its path.
fn written() -> (Folder, PathBuf) {
    let (home, path) = folder_with("out/database.db");
    write_colmap_database(&path, |database| {
        let camera = add_camera(database)?;
        let a = database.add_image("a.png", camera, &keypoints(4), &descriptors(4))?;
        let b = database.add_image("b.png", camera, &keypoints(3), &descriptors(3))?;
        let geometry = DatabaseGeometry {
            kind: GeometryKind::Calibrated,
            inliers: vec![[3, 1]],
            matrix: Some(Matrix3::new(0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9)),
            b_from_a: Some(Isometry3::new(
                Vector3::new(1.0, 2.0, 3.0),
                Vector3::new(0.0, 0.0, std::f64::consts::PI / 3.0),
            )),
        };
        assert_eq!(database.features(a)?, (keypoints(4), descriptors(4)), "they are read back as they were added");
        let none = database.add_image("none.png", camera, &[], &[])?;
        assert_eq!((database.features(none)?, database.features(none + 1).is_err()), ((vec![], vec![]), true));
        database.add_matches(a, b, &[[0, 0], [3, 1]])?;
        database.add_geometry(a, b, &geometry)?;
        let of = |kind, matrix| DatabaseGeometry { kind, matrix: Some(matrix), ..DatabaseGeometry::default() };
        let fundamental = Matrix3::new(0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0);
        database.add_geometry(a, none, &of(GeometryKind::Uncalibrated, fundamental))?;
        let homography = Matrix3::new(2.0, 0.0, 10.0, 0.0, 2.0, 20.0, 0.0, 0.0, 1.0);
        database.add_geometry(b, none, &of(GeometryKind::PlanarOrPanoramic, homography))
    })
    .expect("written");
    (home, path)
}

fn floats(bytes: &[u8]) -> Vec<f64> {
    bytes.chunks_exact(8).map(|b| f64::from_le_bytes(b.try_into().expect("8 bytes"))).collect()
}

#[test]
fn every_blob_is_as_documented_and_a_geometry_moved_by_half_a_pixel_and_laid_down_by_rows() {
    let (_home, path) = written();
    assert_eq!(fs::read_dir(path.parent().expect("one")).expect("a folder").count(), 1, "no leftovers");
    let db = Connection::open(&path).expect("a database");
    let row = |sql: &str| {
        db.query_row(sql, [], |row| Ok((row.get::<_, i64>(0)?, row.get::<_, i64>(1)?, row.get::<_, Vec<u8>>(2)?)))
    };
    let (rows, cols, bytes) = row("SELECT rows, cols, data FROM keypoints WHERE image_id = 1").expect("a row");
    let numbers: Vec<f32> = bytes.chunks_exact(4).map(|b| f32::from_le_bytes(b.try_into().expect("4 bytes"))).collect();
    assert_eq!((rows, cols, numbers.len()), (4, 4, 16));
    assert_eq!(numbers[4..8], [1.5, 7.25, 1.6, -0.1]);
    let (rows, cols, bytes) = row("SELECT rows, cols, data FROM descriptors WHERE image_id = 2").expect("a row");
    assert_eq!((rows, cols, bytes), (3, 128, descriptors(3).concat()));
    let (id, rows, bytes) = row("SELECT pair_id, rows, data FROM matches").expect("a row");
    let indices: Vec<u32> = bytes.chunks_exact(4).map(|b| u32::from_le_bytes(b.try_into().expect("4 bytes"))).collect();
    assert_eq!((id, rows, indices), (2_147_483_647 + 2, 2, vec![0, 0, 3, 1]));
    let (model, prior, bytes) = row("SELECT model, prior_focal_length, params FROM cameras").expect("a row");
    assert_eq!((model, prior, floats(&bytes)), (2, 1, CAMERA.to_vec()));
    assert_eq!(pair_id(7, 3), 3 * MAX_IMAGE_ID + 7);
    // Rigs and frames: one for each camera, one for each image.
    let count = |table: &str| db.query_row(&format!("SELECT COUNT(*) FROM {table}"), [], |row| row.get::<_, i64>(0));
    let counts =
        ["cameras", "rigs", "rig_sensors", "images", "frames", "frame_data"].map(|t| count(t).expect("a table"));
    assert_eq!(counts, [1, 1, 0, 3, 3, 3]);
    assert_eq!(db.query_row("PRAGMA integrity_check", [], |row| row.get::<_, String>(0)), Ok("ok".to_owned()));
    let db = Connection::open(&path).expect("a database");
    let blob = |column: &str, config: u32| {
        let found = format!("FROM two_view_geometries WHERE {column} IS NOT NULL");
        let configs: Vec<u32> = db
            .prepare(&format!("SELECT config {found}"))
            .and_then(|mut query| query.query_map([], |row| row.get(0))?.collect())
            .expect("rows");
        assert_eq!(configs, [config], "{column}");
        let sql = format!("SELECT {column} {found}");
        floats(&db.query_row(&sql, [], |row| row.get::<_, Vec<u8>>(0)).expect("a blob"))
    };
    // F for the pixels x − 0.5: the last column and row lose half of the others; the corner (8) loses half of 5 and of
    // 7, and gains a quarter of 0 + 1 + 3 + 4.
    let corner = 8.0 - 0.5 * (2.0 + 5.0) - 0.5 * (6.0 + 7.0) + 0.25 * (0.0 + 1.0 + 3.0 + 4.0);
    assert_eq!(blob("F", 3), [0.0, 1.0, 1.5, 3.0, 4.0, 1.5, 4.5, 4.5, corner]);
    assert_eq!(blob("E", 2), [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9]);
    // (0.5, 0.5) is our (0, 0), which goes to our (10, 20), which is (10.5, 20.5).
    assert_eq!(blob("H", 6), [2.0, 0.0, 9.5, 0.0, 2.0, 19.5, 0.0, 0.0, 1.0]);
    assert_eq!(blob("tvec", 2), [1.0, 2.0, 3.0]);
    let turn = blob("qvec", 2);
    let expected = [(std::f64::consts::PI / 6.0).cos(), 0.0, 0.0, (std::f64::consts::PI / 6.0).sin()];
    assert!(turn.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{turn:?}");
}

#[test]
fn a_database_is_whole_or_not_there_and_text_that_is_no_features_is_named() {
    let (home, path) = written();
    let before = fs::read(&path).expect("a file");
    let twice = write_colmap_database(&path, |database| {
        let camera = add_camera(database)?;
        database.add_image("a.png", camera, &[], &[])?;
        database.add_image("a.png", camera, &[], &[]).map(|_| ())
    });
    assert!(twice.as_ref().is_err_and(|error| error.problem.contains("images.name")), "{twice:?}");
    // An error of `fill` is returned unchanged.
    assert_eq!(write_colmap_database(&path, |_| Err(Cancelled.into())), Err(Cancelled.into()));
    assert_eq!(fs::read(&path).expect("a file"), before);
    assert_eq!(fs::read_dir(path.parent().expect("one")).expect("a folder").count(), 1);
    assert_eq!(write_colmap_database(&home, |_| Ok(())).expect_err("a folder").kind, ErrorKind::Refused);
    let (home, path) = folder_with("a.txt");
    let row = |extra: &str| format!("1 2 3 0.5{}{extra}\n", " 9".repeat(128));
    for (text, words) in [
        (String::new(), "line 1"),
        ("2 64\n".to_owned(), "line 1"),
        (format!("2 128\n{}", row("")), "2 features are announced, but there are 1"),
        (format!("1 128\n{}", row(" 7")), "line 2: there is more"),
        ("1 128\n1 2 3\n".to_owned(), "line 2: it ends too early"),
        (format!("1 128\n{}", row("").replace(" 9\n", " 256\n")), "'256' is not a number"),
        (format!("1 128\n{}", row("").replace("0.5", "inf")), "not finite"),
    ] {
        fs::write(&path, text).expect("written");
        let error = read_colmap(&path).expect_err(words).to_string();
        assert!(error.contains(words) && error.ends_with("a.txt"), "{error}");
    }
    assert!(read_colmap(&home.join("gone.txt")).is_err_and(|error| error.kind == ErrorKind::System));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]
    #[test]
    fn text_is_read_back_number_for_number(
        numbers in prop::collection::vec(prop::array::uniform4(-1e6f32..1e6), 0..5),
        shift: u8,
    ) {
        let (_home, path) = folder_with("a.txt");
        let keypoints: Vec<ColmapKeypoint> =
            numbers.iter().map(|&[x, y, scale, orientation]| ColmapKeypoint { x, y, scale, orientation }).collect();
        let descriptors: Vec<Descriptor> =
            (0..keypoints.len()).map(|k| std::array::from_fn(|i| (i * 5 + k) as u8 ^ shift)).collect();
        write_colmap_keypoints(&path, &keypoints, &descriptors).expect("written");
        prop_assert_eq!(read_colmap(&path), Ok((keypoints, descriptors)));
    }
}
