//! Conversion of matching results to the form of COLMAP's database.

use super::BurstFeatures;
use crate::export::{DatabaseCamera, DatabaseGeometry, GeometryKind};
use crate::matching::{Camera, CameraModel, MatchResult, TwoViewModel, Verification};
use nalgebra::{Isometry3, Rotation3, Translation3, UnitQuaternion};

/// COLMAP's number of a camera model.
fn model_id(model: CameraModel) -> u32 {
    match model {
        CameraModel::SimplePinhole => 0,
        CameraModel::Pinhole => 1,
        CameraModel::SimpleRadial => 2,
        CameraModel::OpenCv => 4,
    }
}

/// The camera for the database. `known` is whether its focal length was given.
pub(super) fn database_camera(camera: &Camera, known: bool) -> DatabaseCamera {
    DatabaseCamera {
        model_id: model_id(camera.model),
        width: camera.width,
        height: camera.height,
        params: camera.params.clone(),
        prior_focal_length: known,
    }
}

/// The index pairs of all putative matches.
pub(super) fn match_indices(result: &MatchResult) -> Vec<[u32; 2]> {
    result.matches.iter().map(|m| [m.a as u32, m.b as u32]).collect()
}

/// The geometry that the verified matches of the bursts `a` and `b` agree on; `None` where they were not verified.
pub(super) fn database_geometry(
    a: &BurstFeatures,
    b: &BurstFeatures,
    result: &MatchResult,
) -> Option<DatabaseGeometry> {
    let Verification { model, inlier, .. } = result.verification.as_ref()?;
    let Some(model) = model else {
        return Some(DatabaseGeometry::degenerate());
    };
    let agreed = || result.matches.iter().zip(inlier).filter(|(_, inlier)| **inlier).map(|(m, _)| m);
    let none = DatabaseGeometry {
        inliers: agreed().map(|m| [m.a as u32, m.b as u32]).collect(),
        ..DatabaseGeometry::degenerate()
    };
    Some(match model {
        TwoViewModel::Fundamental { fundamental } => {
            DatabaseGeometry { kind: GeometryKind::Uncalibrated, fundamental: Some(*fundamental), ..none }
        }
        TwoViewModel::Homography { forward, .. } => {
            DatabaseGeometry { kind: GeometryKind::PlanarOrPanoramic, homography: Some(*forward), ..none }
        }
        TwoViewModel::Essential { essential, .. } => {
            let places: Vec<([f64; 2], [f64; 2])> =
                agreed().map(|m| (a.keypoints[m.a].pos_image(), b.keypoints[m.b].pos_image())).collect();
            let pose = model.relative_pose(&places).map(|(pose, _)| {
                let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(pose.rotation));
                Isometry3::from_parts(Translation3::from(pose.translation), rotation)
            });
            DatabaseGeometry { kind: GeometryKind::Calibrated, essential: Some(*essential), b_from_a: pose, ..none }
        }
    })
}
