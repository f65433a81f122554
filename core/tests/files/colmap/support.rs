//! A small dataset, and running jobs on it.

use burstscope_core::burst::{BurstFiles, OpenOptions, SequenceCut, cut_sequence, find_bursts};
use burstscope_core::dataset::{
    CameraChoice, ColmapJob, ColmapReport, DatasetError, Event, FeatureJob, ImageKind, export_colmap,
};
use burstscope_core::detector::DetectorParams;
use burstscope_core::matching::MatchParams;
use burstscope_core::matching::PairSelection;
use burstscope_core::synth::{SceneParams, synth_scene, write_burst};
use burstscope_core::{Monitor, SlopeGrid};
use std::path::Path;

/// Size of the frames.
pub const SIZE: (usize, usize) = (260, 200);

/// Three bursts of five frames, cut from one walk past a layered scene in `home`.
pub fn walk(home: &Path) -> Vec<BurstFiles> {
    let params = SceneParams {
        width: SIZE.0,
        height: SIZE.1,
        frames: 15,
        max_slope: 1.5,
        snr: 20.0,
        seed: 3,
        ..SceneParams::default()
    };
    let (burst, truth) = synth_scene(&params, &Monitor::default()).expect("a scene");
    let film = home.join("film");
    write_burst(&film, &burst, &truth, &Monitor::default()).expect("written");
    let sequence = &find_bursts(&[film]).expect("one sequence")[0];
    cut_sequence(sequence, SequenceCut::new(5, None).expect("a cut")).expect("three bursts")
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
        camera: CameraChoice::default(),
    }
}

/// Runs the job; also returns the names of bursts that failed.
pub fn export(bursts: &[BurstFiles], out: &Path, job: &ColmapJob) -> (Result<ColmapReport, DatasetError>, Vec<String>) {
    let mut failed = Vec::new();
    let mut on = |event: Event<'_>| {
        if let Event::Failed { name, .. } = event {
            failed.push(name.to_owned());
        }
    };
    let report = export_colmap(bursts, out, job, &mut on, &Monitor::default());
    (report, failed)
}
