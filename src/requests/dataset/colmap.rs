//! Export of a whole dataset for COLMAP's mapper: the work of the command `colmap`, as a request.

use super::DatasetEvent;
use crate::burst::BurstFiles;
use crate::dataset::{BurstCameras, BurstEvent, ColmapJob, ColmapReport, FeatureStore, export_colmap, gather};
use crate::error::Error;
use crate::monitor::Monitor;
use std::path::PathBuf;

#[derive(Debug, Clone, PartialEq)]
pub struct ColmapRequest {
    pub out: PathBuf,
    /// Paths of the dataset: a file `camera.toml` in a folder there is the camera of its bursts, if `job` has none.
    pub inputs: Vec<PathBuf>,
    /// Folder in which the dataset's features are kept: those of the same parameters are copied, not found again.
    pub kept: Option<PathBuf>,
    pub job: ColmapJob,
}

#[derive(Debug, Clone)]
pub struct ColmapDone {
    pub report: ColmapReport,
    pub left_out: Vec<(String, String)>,
}

/// Bursts whose features are in the folder, or where the dataset keeps them, are not searched again.
pub(super) fn run(
    bursts: &[BurstFiles],
    ColmapRequest { out, inputs, kept, mut job }: ColmapRequest,
    tell: &dyn Fn(DatasetEvent),
    monitor: &Monitor,
) -> Result<ColmapDone, Error> {
    let mut left_out = Vec::new();
    let mut on = |event: BurstEvent<'_>| {
        if let BurstEvent::Failed(index, error) = event {
            left_out.push((bursts[index].name.clone(), error.to_string()));
        }
        DatasetEvent::of(&event).into_iter().for_each(tell);
    };
    job.cameras = BurstCameras::of(bursts, &inputs, &[], job.cameras.rest)?;
    let mut store = FeatureStore::open(&out, &job.features)?;
    if let Some(kept) = kept.filter(|kept| *kept != out && kept.is_dir()) {
        gather(&mut store, bursts, &[kept], monitor)?;
    }
    let report = export_colmap(&mut store, bursts, &job, &mut on, monitor)?;
    Ok(ColmapDone { report, left_out })
}
