//! One method on one trajectory: writes the dataset and its database, runs COLMAP's mapper, computes the errors.

use crate::evaluate::{BurstMethod, Searches};
use crate::synth::{Motion, Trajectory};
use burstscope_core::error::{Error, ErrorKind, Result};
use burstscope_core::{matching::MatchParams, monitor::Monitor};
use serde::{Deserialize, Serialize};
use std::path::Path;

#[cfg(feature = "colmap")]
pub(super) use with_database::reconstruct;

fn unrun(program: &Path, reason: &str) -> Error {
    let problem = format!("cannot run {}: {reason}", program.display());
    Error::new(ErrorKind::Failed, problem, "install COLMAP anew, or leave it out with --no-colmap")
}

/// Without the database COLMAP has no input; the figure never calls this then.
#[cfg(not(feature = "colmap"))]
pub(super) fn reconstruct(
    program: &Path,
    _: (&Searches, &MatchParams, BurstMethod),
    _: &Trajectory,
    _: &Path,
    _: &Monitor,
) -> Result<Reconstructed> {
    Err(unrun(program, "this program was built without the feature colmap"))
}

#[cfg(feature = "colmap")]
mod with_database {
    use super::*;
    use crate::evaluate::poses::{PoseStudy, evaluate_poses, read_trajectory};
    use crate::synth::write_trajectory;
    use burstscope_core::burst::{BurstFiles, OpenOptions};
    use burstscope_core::dataset::{
        BurstCameras, CameraChoice, ColmapJob, DatasetSource, FeatureJob, FeatureStore, ImageKind, export_colmap,
    };
    use burstscope_core::matching::{Camera, CameraModel, PairSelection};
    use std::fs::File;
    use std::io::{Read, Seek, SeekFrom};
    use std::process::{Command, Stdio};
    use std::time::{Duration, Instant};

    /// Number of bytes read from the end of the mapper's output.
    const TAIL_BYTES: u64 = 4096;
    /// Maximum number of characters that are repeated of its last line.
    const LONGEST_LINE: usize = 120;

    /// Writes the bursts of `way` into `folder`, finds and matches their features, runs COLMAP's mapper and compares
    /// its cameras with the true ones. A mapper that finds no model is a result: nothing registered.
    pub(in crate::figures::reconstruction) fn reconstruct(
        program: &Path,
        (searches, matching, method): (&Searches, &MatchParams, BurstMethod),
        way: &Trajectory,
        folder: &Path,
        monitor: &Monitor,
    ) -> Result<Reconstructed> {
        let silent = monitor.silent();
        let (data, out) = (folder.join("way"), folder.join("out"));
        write_trajectory(&data, way, &silent)?;
        let bursts = match method {
            // Each noise-free view is a burst of one frame.
            BurstMethod::Gold => (0..way.cameras.len())
                .map(|index| {
                    let name = Trajectory::name(index);
                    let paths = vec![data.join("gold").join(format!("{name}.png"))];
                    BurstFiles { name, paths }
                })
                .collect(),
            _ => DatasetSource::of_bursts(vec![data.join("bursts")]).bursts(&OpenOptions::default())?,
        };
        let (width, height, params) = (way.lens.width, way.lens.height, way.lens.colmap_params().to_vec());
        let camera = Camera { model: CameraModel::Pinhole, width, height, params };
        let (detector, open) = (searches.params(method), OpenOptions::default());
        let job = ColmapJob {
            features: FeatureJob { detector, open, images: ImageKind::Middle },
            matching: matching.clone(),
            pairs: PairSelection::default(),
            cameras: BurstCameras { rest: CameraChoice::Known(camera), ..Default::default() },
        };
        let mut store = FeatureStore::open(&out, &job.features)?;
        let report = export_colmap(&mut store, &bursts, &job, &mut |_| {}, &silent)?;
        let sparse = out.join("sparse");
        // Time of the mapper alone; that of features and matches is in `Matched`.
        let started = Instant::now();
        let gave_up = run_mapper(program, &report.database, &report.images_folder, &sparse, monitor)?;
        let mapper_secs = started.elapsed().as_secs_f64();
        let compared = compared(&sparse, &data.join("poses.txt"), way.cameras.len());
        // A mapper that fails after it has written a model still has a result.
        Ok(Reconstructed { mapper_secs, gave_up: gave_up.filter(|_| compared.registered == 0), ..compared })
    }

    /// Runs the mapper, or ends it once `monitor` is cancelled; returns its last line if it gave up.
    fn run_mapper(
        program: &Path,
        database: &Path,
        images: &Path,
        sparse: &Path,
        monitor: &Monitor,
    ) -> Result<Option<String>> {
        let because = |reason: String| unrun(program, &reason);
        let failed = |error: std::io::Error| because(error.to_string());
        std::fs::create_dir_all(sparse).map_err(failed)?;
        // A file, since a full pipe would block the mapper.
        let mut said = tempfile::tempfile().map_err(failed)?;
        let mut child = Command::new(program)
            .arg("mapper")
            .args(["--database_path".as_ref(), database.as_os_str()])
            .args(["--image_path".as_ref(), images.as_os_str()])
            .args(["--output_path".as_ref(), sparse.as_os_str()])
            .stdin(Stdio::null())
            .stdout(said.try_clone().map_err(failed)?)
            .stderr(said.try_clone().map_err(failed)?)
            .spawn()
            .map_err(failed)?;
        let status = loop {
            if let Some(status) = child.try_wait().map_err(failed)? {
                break status;
            }
            if let Err(cancelled) = monitor.check() {
                // A mapper that has already ended cannot be killed.
                let _ = child.kill();
                let _ = child.wait();
                return Err(cancelled.into());
            }
            // Short beside the mapper's work, and prompt for somebody who cancels.
            std::thread::sleep(Duration::from_millis(50));
        };
        // An interrupt at the terminal ends both at once.
        monitor.check()?;
        let mut last = || last_line(&mut said).unwrap_or_default();
        match status.code() {
            Some(0) => Ok(None),
            // Without a pair to begin with the mapper makes no model, which is a result.
            Some(_) => Ok(Some(last())),
            None => Err(because(format!("the mapper ended with {status}: {}", last()))),
        }
    }

    /// The last line that is not blank, without control characters, of at most [`LONGEST_LINE`] characters.
    fn last_line(said: &mut File) -> std::io::Result<String> {
        let end = said.seek(SeekFrom::End(0))?;
        said.seek(SeekFrom::Start(end.saturating_sub(TAIL_BYTES)))?;
        let mut tail = Vec::new();
        said.read_to_end(&mut tail)?;
        let tail = String::from_utf8_lossy(&tail);
        let line = tail.lines().rev().map(str::trim).find(|line| !line.is_empty()).unwrap_or_default();
        Ok(line.chars().filter(|c| !c.is_control()).take(LONGEST_LINE).collect())
    }

    fn compared(sparse: &Path, truth: &Path, images: usize) -> Reconstructed {
        let Ok(estimate) = read_trajectory(sparse) else { return Reconstructed::default() };
        let mut result = Reconstructed {
            registered: estimate.poses.len(),
            points_per_image: estimate.model.as_ref().map(|model| model.summary().points_per_image),
            ..Reconstructed::default()
        };
        let Ok(truth) = read_trajectory(truth) else { return result };
        // Too few poses cannot be aligned.
        if let Ok(report) =
            evaluate_poses(&estimate, &truth, &PoseStudy { images: Some(images), ..PoseStudy::default() })
        {
            let mean = |errors: &crate::evaluate::poses::PoseErrors| {
                (errors.count > 0).then_some([errors.translation.mean, errors.rotation_deg.mean])
            };
            result.absolute = mean(&report.absolute);
            result.relative = mean(&report.relative);
            result.centres = report.pairs.iter().map(|pair| (pair.truth, pair.aligned_centre)).collect();
        }
        result
    }

    #[cfg(all(test, unix))]
    mod tests {
        use super::*;

        fn run(script: &str) -> Result<Option<String>> {
            run_with(script, &Monitor::default())
        }

        /// The result of a mapper that is this shell script.
        fn run_with(script: &str, monitor: &Monitor) -> Result<Option<String>> {
            let folder = tempfile::tempdir().expect("a temporary folder");
            let program = folder.path().join("colmap");
            // Another process writes it: a file that this one had open for writing could be inherited by the child
            // of another test, and cannot be run while that has it.
            let write = "printf '#!/bin/sh\n%s\n' \"$1\" > \"$0\" && chmod 755 \"$0\"";
            let written = Command::new("sh").args(["-c", write]).arg(&program).arg(script).status();
            assert!(written.expect("a shell").success());
            run_mapper(&program, Path::new("a.db"), folder.path(), &folder.path().join("sparse"), monitor)
        }

        #[test]
        fn a_mapper_that_an_interruption_has_ended_is_cancelled_and_no_crash() {
            let folder = tempfile::tempdir().expect("a temporary folder");
            let (go, monitor) = (folder.path().join("go"), Monitor::default());
            let script = format!("while [ ! -e '{}' ]; do sleep 0.01; done; kill -INT $$", go.display());
            std::thread::scope(|scope| {
                scope.spawn(|| {
                    monitor.cancel();
                    std::fs::write(&go, "").expect("writable");
                });
                assert!(run_with(&script, &monitor).is_err_and(|error| error.is_cancelled()));
            });
        }

        #[test]
        fn a_mapper_that_gives_up_is_an_answer_with_its_last_words_and_a_crash_is_an_error() {
            assert_eq!(run("echo fine").expect("it ran"), None);
            let gave_up = run("echo one; printf 'ERROR: no \\033[31mpair\\n\\n' >&2; exit 1").expect("an answer");
            assert_eq!(gave_up.as_deref(), Some("ERROR: no [31mpair"));
            let long = run("head -c 100000 /dev/zero | tr '\\0' x; exit 3").expect("an answer");
            assert_eq!(long.map(|line| line.len()), Some(LONGEST_LINE));
            let error = run("echo out of memory >&2; kill -9 $$").expect_err("a crash").to_string();
            assert!(error.contains("signal") && error.contains("out of memory"), "{error}");
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub(super) struct Matched {
    /// Features of an image, mean over the images.
    pub keypoints: f64,
    /// Putative matches of an image with all others, mean.
    pub putative: f64,
    /// Inliers of an image with all others, mean.
    pub inliers: f64,
    /// Putative matches over features.
    pub match_ratio: f64,
    /// Inliers over features.
    pub match_score: f64,
    /// Inliers over putative matches, if there are any.
    #[serde(alias = "precision")]
    pub inlier_ratio: Option<f64>,
    /// Time for the features of all bursts and their matches, seconds.
    pub seconds: f64,
}

#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub(super) struct Reconstructed {
    /// Number of images that have a pose in the largest model.
    pub registered: usize,
    pub points_per_image: Option<f64>,
    /// Mean absolute error of the poses: metres, and degrees.
    pub absolute: Option<[f64; 2]>,
    /// Mean error from one pose to the next: metres, and degrees.
    pub relative: Option<[f64; 2]>,
    /// Registered cameras by their index on the trajectory, with their estimated centres after the alignment, metres.
    pub centres: Vec<(usize, [f64; 3])>,
    pub mapper_secs: f64,
    /// Last line of the mapper's output where it gave up and left no model.
    pub gave_up: Option<String>,
}

/// Results of one method on one trajectory.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Run {
    pub motion: Motion,
    pub seed: u64,
    pub method: BurstMethod,
    pub bursts: usize,
    pub matched: Matched,
    /// Results of COLMAP; `None` without COLMAP.
    pub reconstructed: Option<Reconstructed>,
    /// Centres of the true cameras, metres.
    pub true_centres: Vec<[f64; 3]>,
}
