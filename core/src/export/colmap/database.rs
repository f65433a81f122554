//! COLMAP's database: cameras, images with their features, matches and two-view geometries, in one SQLite file.
//!
//! Numbers are stored as little-endian rows: keypoints as four `f32` (x, y, scale, orientation), descriptors as 128
//! bytes in UBC order, matches as pairs of `u32`, matrices as nine `f64` by rows. Each camera gets a rig and each image
//! a frame of its own, as COLMAP does for cameras that are not mounted together.

use super::{FIRST_PIXEL, text::ColmapKeypoint};
use crate::error::{Error, Result};
use crate::{detector::Descriptor, export::atomic::replace, files::mark::DATABASE_ID};
use nalgebra::{Isometry3, Matrix3};
use rusqlite::{Connection, OptionalExtension, Params, params};
use std::{fs::File, io, path::Path};

/// Largest id of an image, and the factor by which two ids are combined into one number.
pub const MAX_IMAGE_ID: u64 = 2_147_483_647;

/// Writer of a database. Ids count up from 1 in the order of the additions.
#[derive(Debug)]
pub struct DatabaseWriter<'a> {
    connection: &'a Connection,
    path: &'a Path,
    cameras: u32,
    /// Number of keypoints of each image.
    keypoints: Vec<usize>,
}

/// Writes the database `path` by `fill`. It is made beside its target and replaces it when it is complete: after a
/// failure an older file is unchanged and no other one is left behind. An error of `fill` is passed on.
pub fn write_colmap_database(path: &Path, fill: impl FnOnce(&mut DatabaseWriter<'_>) -> Result<()>) -> Result<()> {
    // The error of `fill` is kept apart, since a replacement reports errors of files alone.
    let mut made = Ok(());
    let written = replace(path, |new| {
        made = make(new, path, fill);
        // Any error keeps the old file; its text is not shown.
        made.as_ref().map_err(|_| io::Error::other("the database was not completed"))?;
        File::options().read(true).write(true).open(new)
    });
    made?;
    written
}

fn make(temporary: &Path, path: &Path, fill: impl FnOnce(&mut DatabaseWriter<'_>) -> Result<()>) -> Result<()> {
    let fail = |e: rusqlite::Error| failure(path, &e);
    let connection = Connection::open(temporary).map_err(fail)?;
    // No journal and no waiting for the disk: the file is useless until it is complete, and is then flushed.
    connection.execute_batch("PRAGMA journal_mode = OFF; PRAGMA synchronous = OFF; BEGIN;").map_err(fail)?;
    connection.pragma_update(None, "application_id", DATABASE_ID).map_err(fail)?;
    connection.execute_batch(TABLES).map_err(fail)?;
    let mut writer = DatabaseWriter { connection: &connection, path, cameras: 0, keypoints: Vec::new() };
    fill(&mut writer)?;
    connection.execute_batch("COMMIT;").map_err(fail)?;
    connection.close().map_err(|(_, e)| fail(e))?;
    Ok(())
}

fn failure(path: &Path, error: &rusqlite::Error) -> Error {
    Error::unwritten(path, &io::Error::other(error.to_string()))
}

impl DatabaseWriter<'_> {
    /// Adds a camera of images of `size` (columns, rows) and returns its id. `model` is COLMAP's number, and `params`
    /// are in COLMAP's order, with the principal point from the first pixel's corner. On a focal length that
    /// `is_known`, not guessed, COLMAP relies when it chooses the first two images.
    pub fn add_camera(&mut self, model: u32, size: (usize, usize), params: &[f64], is_known: bool) -> Result<u32> {
        self.cameras += 1;
        let (id, [width, height]) = (self.cameras, [size.0, size.1].map(|side| side as u64 as i64));
        let intrinsics = float_bytes(params.iter().copied());
        self.execute(
            "INSERT INTO cameras VALUES (?, ?, ?, ?, ?, ?)",
            params![id, model, width, height, intrinsics, is_known],
        )?;
        self.execute("INSERT INTO rigs VALUES (?, ?, ?)", params![id, id, SENSOR_CAMERA])?;
        Ok(id)
    }

    /// Adds an image of camera `camera_id` with its features; returns its id. `name` is below the images' folder.
    ///
    /// # Errors
    /// The file cannot be written, or already has an image of this name.
    ///
    /// # Panics
    /// When the numbers of keypoints and descriptors differ, or there is no such camera.
    pub fn add_image(
        &mut self,
        name: &str,
        camera_id: u32,
        keypoints: &[ColmapKeypoint],
        descriptors: &[Descriptor],
    ) -> Result<u32> {
        assert_eq!(keypoints.len(), descriptors.len(), "each feature has one descriptor");
        assert!((1..=self.cameras).contains(&camera_id), "the camera is added first");
        self.keypoints.push(keypoints.len());
        let id = self.keypoints.len() as u32;
        self.execute("INSERT INTO images (image_id, name, camera_id) VALUES (?, ?, ?)", params![id, name, camera_id])?;
        // The rig has its camera's id.
        self.execute("INSERT INTO frames VALUES (?, ?)", params![id, camera_id])?;
        self.execute("INSERT INTO frame_data VALUES (?, ?, ?, ?)", params![id, id, camera_id, SENSOR_CAMERA])?;
        let rows = keypoints.len() as i64;
        self.execute("INSERT INTO keypoints VALUES (?, ?, 4, ?)", params![id, rows, keypoint_bytes(keypoints)])?;
        let bytes = descriptors.as_flattened();
        self.execute("INSERT INTO descriptors VALUES (?, ?, 128, ?)", params![id, rows, bytes])?;
        Ok(id)
    }

    /// Moves the features of the image `id` to `places` (u, v), pixels, whose first centre is at (0, 0).
    ///
    /// # Panics
    /// When the image was not added, or has another number of features.
    pub fn move_features(&mut self, id: u32, places: &[[f64; 2]]) -> Result<()> {
        let (mut keypoints, _) = self.features(id)?;
        assert_eq!(keypoints.len(), places.len(), "each feature has a place");
        keypoints.iter_mut().zip(places).for_each(|(keypoint, place)| keypoint.set_pos_image(*place));
        self.execute("UPDATE keypoints SET data = ? WHERE image_id = ?", params![keypoint_bytes(&keypoints), id])
    }

    /// Adds the matches of images `a` and `b`, index pairs of their features, in place of any added before.
    ///
    /// # Errors
    /// The file cannot be written.
    ///
    /// # Panics
    /// When `a` is not before `b`, an image was not added, or a match has the index of a missing feature.
    pub fn add_matches(&mut self, a: u32, b: u32, matches: &[[u32; 2]]) -> Result<()> {
        let id = self.pair_of(a, b, matches);
        let (rows, bytes) = (matches.len() as i64, index_bytes(matches));
        self.execute("INSERT OR REPLACE INTO matches VALUES (?, ?, 2, ?)", params![id, rows, bytes])
    }

    /// Reads the matches of images `a` and `b` back; none where none were added.
    pub fn matches(&self, a: u32, b: u32) -> Result<Vec<[u32; 2]>> {
        let sql = "SELECT data FROM matches WHERE pair_id = ?";
        let index = |bytes: &[u8; 8], k: usize| u32::from_le_bytes(std::array::from_fn(|i| bytes[4 * k + i]));
        let pairs = |bytes: &[u8]| bytes.as_chunks().0.iter().map(|pair| [index(pair, 0), index(pair, 1)]).collect();
        let read = self.connection.query_row(sql, [pair_id(a, b) as i64], |row| Ok(pairs(row.get_ref(0)?.as_blob()?)));
        read.optional().map(Option::unwrap_or_default).map_err(|e| failure(self.path, &e))
    }

    /// Adds the two-view geometry of images `a` and `b` in place of any before; errors and panics as of
    /// [`Self::add_matches`].
    pub fn add_geometry(&mut self, a: u32, b: u32, geometry: &DatabaseGeometry) -> Result<()> {
        let id = self.pair_of(a, b, &geometry.inliers);
        let DatabaseGeometry { kind, inliers, matrix, b_from_a } = geometry;
        let of = |of: GeometryKind| matrix.filter(|_| *kind == of);
        // The only place where the half pixel between both conventions enters matrices. It acts on F transposed, on
        // both sides; E is of directions, which it leaves.
        let there = Matrix3::new(1.0, 0.0, FIRST_PIXEL, 0.0, 1.0, FIRST_PIXEL, 0.0, 0.0, 1.0);
        let back = Matrix3::new(1.0, 0.0, -FIRST_PIXEL, 0.0, 1.0, -FIRST_PIXEL, 0.0, 0.0, 1.0);
        let fundamental = of(GeometryKind::Uncalibrated).map(|f| back.transpose() * f * back);
        let homography = of(GeometryKind::PlanarOrPanoramic).map(|h| there * h * back);
        let turn = b_from_a.map(|pose| {
            // COLMAP stores quaternions with w first.
            let q = pose.rotation.quaternion();
            float_bytes([q.w, q.i, q.j, q.k])
        });
        self.execute(
            "INSERT OR REPLACE INTO two_view_geometries VALUES (?, ?, 2, ?, ?, ?, ?, ?, ?, ?)",
            params![
                id,
                inliers.len() as i64,
                index_bytes(inliers),
                *kind as u32,
                fundamental.map(matrix_bytes),
                of(GeometryKind::Calibrated).map(matrix_bytes),
                homography.map(matrix_bytes),
                turn,
                b_from_a.map(|pose| float_bytes(pose.translation.vector.iter().copied())),
            ],
        )
    }

    fn pair_of(&self, a: u32, b: u32, matches: &[[u32; 2]]) -> i64 {
        assert!(1 <= a && a < b && b as usize <= self.keypoints.len(), "pairs are of images that were added, in order");
        let (of_a, of_b) = (self.keypoints[a as usize - 1], self.keypoints[b as usize - 1]);
        let exist = matches.iter().all(|&[i, j]| (i as usize) < of_a && (j as usize) < of_b);
        assert!(exist, "matches are of features that were added");
        pair_id(a, b) as i64
    }

    /// Reads the features of the image `id` back, as they were added.
    pub fn features(&self, id: u32) -> Result<(Vec<ColmapKeypoint>, Vec<Descriptor>)> {
        let sql = "SELECT keypoints.data, descriptors.data FROM keypoints JOIN descriptors USING (image_id) WHERE image_id = ?";
        let read = self.connection.query_row(sql, [id], |row| {
            let number = |bytes: &[u8], k: usize| f32::from_le_bytes(std::array::from_fn(|i| bytes[4 * k + i]));
            let keypoint = |bytes: &[u8]| {
                let [x, y, scale, orientation] = std::array::from_fn(|k| number(bytes, k));
                ColmapKeypoint { x, y, scale, orientation }
            };
            // Four `f32` a row.
            let keypoints = row.get_ref(0)?.as_blob()?.chunks_exact(16).map(keypoint).collect();
            Ok((keypoints, row.get_ref(1)?.as_blob()?.as_chunks().0.to_vec()))
        });
        read.map_err(|e| failure(self.path, &e))
    }

    fn execute(&self, sql: &str, values: impl Params) -> Result<()> {
        self.connection.execute(sql, values).map(|_| ()).map_err(|e| failure(self.path, &e))
    }
}

/// The number of the pair of images `a` and `b`, in either order.
pub fn pair_id(a: u32, b: u32) -> u64 {
    MAX_IMAGE_ID * u64::from(a.min(b)) + u64::from(a.max(b))
}

fn keypoint_bytes(keypoints: &[ColmapKeypoint]) -> Vec<u8> {
    keypoints.iter().flat_map(|k| [k.x, k.y, k.scale, k.orientation]).flat_map(f32::to_le_bytes).collect()
}

fn index_bytes(pairs: &[[u32; 2]]) -> Vec<u8> {
    pairs.as_flattened().iter().flat_map(|index| index.to_le_bytes()).collect()
}

fn float_bytes(values: impl IntoIterator<Item = f64>) -> Vec<u8> {
    values.into_iter().flat_map(f64::to_le_bytes).collect()
}

/// The matrix by rows; nalgebra's own order is by columns.
fn matrix_bytes(matrix: Matrix3<f64>) -> Vec<u8> {
    float_bytes(matrix.transpose().iter().copied())
}

/// Kind of a two-view geometry, with COLMAP's number for it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum GeometryKind {
    /// Too few matches agree on a geometry.
    #[default]
    Degenerate = 1,
    /// Essential matrix, of calibrated cameras.
    Calibrated = 2,
    /// Fundamental matrix.
    Uncalibrated = 3,
    /// Homography, of a plane or of a camera that only turns.
    PlanarOrPanoramic = 6,
}

/// Geometry of images A and B in Burstscope's pixels (first centre (0, 0)); by default, of matches that disagree.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct DatabaseGeometry {
    /// Kind of the geometry.
    pub kind: GeometryKind,
    /// Index pairs of the inliers' features, of A and of B.
    pub inliers: Vec<[u32; 2]>,
    /// Matrix of that kind: E with d_bᵀ·E·d_a = 0 for directions; F, x_bᵀ·F·x_a = 0, or H, x_b ~ H·x_a, for pixels.
    pub matrix: Option<Matrix3<f64>>,
    /// Map from the frame of A's camera to that of B's.
    pub b_from_a: Option<Isometry3<f64>>,
}

pub(super) const TABLES: &str = "
CREATE TABLE cameras (
    camera_id INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL,
    model INTEGER NOT NULL,
    width INTEGER NOT NULL,
    height INTEGER NOT NULL,
    params BLOB,
    prior_focal_length INTEGER NOT NULL);
CREATE TABLE images (
    image_id INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL,
    name TEXT NOT NULL UNIQUE,
    camera_id INTEGER NOT NULL,
    prior_qw REAL, prior_qx REAL, prior_qy REAL, prior_qz REAL,
    prior_tx REAL, prior_ty REAL, prior_tz REAL,
    CONSTRAINT image_id_check CHECK(image_id >= 0 and image_id < 2147483647),
    FOREIGN KEY(camera_id) REFERENCES cameras(camera_id));
CREATE UNIQUE INDEX index_name ON images(name);
CREATE TABLE keypoints (
    image_id INTEGER PRIMARY KEY NOT NULL,
    rows INTEGER NOT NULL,
    cols INTEGER NOT NULL,
    data BLOB,
    FOREIGN KEY(image_id) REFERENCES images(image_id) ON DELETE CASCADE);
CREATE TABLE descriptors (
    image_id INTEGER PRIMARY KEY NOT NULL,
    rows INTEGER NOT NULL,
    cols INTEGER NOT NULL,
    data BLOB,
    FOREIGN KEY(image_id) REFERENCES images(image_id) ON DELETE CASCADE);
CREATE TABLE matches (
    pair_id INTEGER PRIMARY KEY NOT NULL,
    rows INTEGER NOT NULL,
    cols INTEGER NOT NULL,
    data BLOB);
CREATE TABLE two_view_geometries (
    pair_id INTEGER PRIMARY KEY NOT NULL,
    rows INTEGER NOT NULL,
    cols INTEGER NOT NULL,
    data BLOB,
    config INTEGER NOT NULL,
    F BLOB, E BLOB, H BLOB,
    qvec BLOB, tvec BLOB);
CREATE TABLE rigs (
    rig_id INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL,
    ref_sensor_id INTEGER NOT NULL,
    ref_sensor_type INTEGER NOT NULL);
CREATE UNIQUE INDEX rig_ref_sensor_assignment ON rigs(ref_sensor_id, ref_sensor_type);
CREATE TABLE rig_sensors (
    rig_id INTEGER NOT NULL,
    sensor_id INTEGER NOT NULL,
    sensor_type INTEGER NOT NULL,
    sensor_from_rig BLOB,
    FOREIGN KEY(rig_id) REFERENCES rigs(rig_id) ON DELETE CASCADE);
CREATE UNIQUE INDEX rig_sensor_assignment ON rig_sensors(sensor_id, sensor_type);
CREATE TABLE frames (
    frame_id INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL,
    rig_id INTEGER NOT NULL,
    FOREIGN KEY(rig_id) REFERENCES rigs(rig_id) ON DELETE CASCADE);
CREATE TABLE frame_data (
    frame_id INTEGER NOT NULL,
    data_id INTEGER NOT NULL,
    sensor_id INTEGER NOT NULL,
    sensor_type INTEGER NOT NULL,
    FOREIGN KEY(frame_id) REFERENCES frames(frame_id) ON DELETE CASCADE);
CREATE UNIQUE INDEX frame_sensor_assignment ON frame_data(data_id, sensor_type);
";

pub(super) const SENSOR_CAMERA: u32 = 0;
