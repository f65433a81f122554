//! From a method's features to COLMAP's cameras: the dataset on disk, its database, the mapper, the errors.

use super::run::Reconstructed;
use crate::detector::SearchParams;
use crate::figures::FiguresError;
use crate::matching::MatchParams;
use crate::monitor::Monitor;
use crate::synth::Trajectory;
use std::path::Path;

/// How a method finds and matches its features.
#[derive(Debug, Clone)]
#[cfg_attr(not(feature = "colmap"), expect(dead_code, reason = "without the database nobody runs the mapper"))]
pub(super) struct How {
    /// Whether it looks at the noise-free views instead of the bursts.
    pub is_gold: bool,
    /// How features are found.
    pub search: SearchParams,
    /// How they are matched.
    pub matching: MatchParams,
}

/// Writes the bursts of `way` into `folder`, finds and matches their features, runs COLMAP's mapper and
/// compares its cameras with the true ones. A mapper that finds no model is a result: nothing registered.
#[cfg(feature = "colmap")]
pub(super) fn reconstruct(
    program: &Path,
    how: &How,
    way: &Trajectory,
    folder: &Path,
    monitor: &Monitor,
) -> Result<Reconstructed, FiguresError> {
    with_database::reconstruct(program, how, way, folder, monitor)
}

/// Without the database there is nothing that COLMAP could read; the figure never asks then.
#[cfg(not(feature = "colmap"))]
pub(super) fn reconstruct(
    program: &Path,
    _: &How,
    _: &Trajectory,
    _: &Path,
    _: &Monitor,
) -> Result<Reconstructed, FiguresError> {
    let reason = "this program was built without the feature colmap".to_owned();
    Err(FiguresError::Colmap { program: program.into(), reason })
}

#[cfg(feature = "colmap")]
mod with_database {
    use super::*;
    use crate::burst::{BurstSource, OpenOptions};
    use crate::dataset::{CameraChoice, ColmapJob, DatasetSource, FeatureJob, ImageKind, export_colmap};
    use crate::evaluate::poses::{PoseStudy, evaluate_poses, read_trajectory};
    use crate::matching::{Camera, CameraModel, PairSelection};
    use crate::synth::write_trajectory;
    use std::process::{Command, Stdio};
    use std::time::{Duration, Instant};

    pub(super) fn reconstruct(
        program: &Path,
        how: &How,
        way: &Trajectory,
        folder: &Path,
        monitor: &Monitor,
    ) -> Result<Reconstructed, FiguresError> {
        let silent = monitor.silent();
        let (data, out) = (folder.join("way"), folder.join("out"));
        write_trajectory(&data, way, &silent)?;
        let bursts = match how.is_gold {
            false => bursts_in(&data.join("bursts"))?,
            // Each view is a burst of one frame.
            true => (0..way.cameras.len())
                .map(|index| {
                    let name = Trajectory::name(index);
                    let paths = vec![data.join("gold").join(format!("{name}.png"))];
                    BurstSource { name, paths }
                })
                .collect(),
        };
        let lens = &way.lens;
        let camera = Camera {
            model: CameraModel::Pinhole,
            width: lens.width,
            height: lens.height,
            params: lens.colmap_params().to_vec(),
        };
        let job = ColmapJob {
            features: FeatureJob {
                detector: how.search.clone(),
                open: OpenOptions::default(),
                images: ImageKind::Middle,
            },
            matching: how.matching.clone(),
            pairs: PairSelection::default(),
            camera: CameraChoice::Known(camera),
        };
        let report = export_colmap(&bursts, &out, &job, &mut |_| {}, &silent)?;
        let sparse = out.join("sparse");
        let started = Instant::now();
        run_mapper(program, &report.database, &report.images_folder, &sparse, monitor)?;
        let mapper_secs = started.elapsed().as_secs_f64();
        Ok(Reconstructed { mapper_secs, ..compared(&sparse, &data.join("poses.txt"), way.cameras.len()) })
    }

    fn bursts_in(folder: &Path) -> Result<Vec<BurstSource>, FiguresError> {
        let found = DatasetSource::of_bursts(vec![folder.to_path_buf()]).bursts();
        Ok(found.map_err(crate::dataset::DatasetError::from)?)
    }

    /// Runs the mapper to its end, or ends it once `monitor` was cancelled.
    fn run_mapper(
        program: &Path,
        database: &Path,
        images: &Path,
        sparse: &Path,
        monitor: &Monitor,
    ) -> Result<(), FiguresError> {
        let failed =
            |error: std::io::Error| FiguresError::Colmap { program: program.into(), reason: error.to_string() };
        std::fs::create_dir_all(sparse).map_err(failed)?;
        let mut child = Command::new(program)
            .arg("mapper")
            .args(["--database_path".as_ref(), database.as_os_str()])
            .args(["--image_path".as_ref(), images.as_os_str()])
            .args(["--output_path".as_ref(), sparse.as_os_str()])
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .map_err(failed)?;
        loop {
            // A mapper that gives up says so by its exit code, and leaves no model: that is an answer.
            if child.try_wait().map_err(failed)?.is_some() {
                return Ok(());
            }
            if let Err(cancelled) = monitor.check() {
                // One that has ended by itself cannot be ended.
                let _ = child.kill();
                let _ = child.wait();
                return Err(cancelled.into());
            }
            std::thread::sleep(Duration::from_millis(50));
        }
    }

    /// What the model says, if there is one.
    fn compared(sparse: &Path, truth: &Path, images: usize) -> Reconstructed {
        let Ok(estimate) = read_trajectory(sparse) else { return Reconstructed::default() };
        let mut result = Reconstructed {
            registered: estimate.poses.len(),
            points_per_image: estimate.model.as_ref().map(|model| model.summary().points_per_image),
            ..Reconstructed::default()
        };
        let Ok(truth) = read_trajectory(truth) else { return result };
        // Fewer than three poses cannot be aligned.
        if let Ok(report) =
            evaluate_poses(&estimate, &truth, &PoseStudy { images: Some(images), ..PoseStudy::default() })
        {
            let mean = |errors: &crate::evaluate::poses::PoseErrors| {
                (errors.count > 0).then_some([errors.translation.mean, errors.rotation_deg.mean])
            };
            result.absolute = mean(&report.absolute);
            result.relative = mean(&report.relative);
            result.centres = report.pairs.iter().map(|pair| pair.aligned_centre).collect();
        }
        result
    }
}
