//! Export of a whole dataset for COLMAP's mapper: the work of the command `colmap`, as a request.

use super::DatasetEvent;
use crate::burst::{BurstFiles, OpenOptions};
use crate::dataset::{
    BurstEvent, CameraChoice, ColmapJob, ColmapReport, FeatureJob, FeatureStore, ImageKind, export_colmap, gather,
};
use crate::detector::SearchParams;
use crate::error::Error;
use crate::matching::{CameraModel, MatchParams, PairSelection};
use crate::monitor::Monitor;
use std::path::PathBuf;

#[derive(Debug, Clone, PartialEq)]
pub struct ColmapRequest {
    pub out: PathBuf,
    /// Folder in which the dataset's features are kept: those of the same parameters are copied, not found again.
    pub kept: Option<PathBuf>,
    pub params: SearchParams,
    pub open: OpenOptions,
    /// Parameters of matching, with the camera where it is known.
    pub matching: MatchParams,
    pub pairs: PairSelection,
}

impl ColmapRequest {
    fn job(&self) -> ColmapJob {
        let camera = self.matching.camera.clone();
        ColmapJob {
            features: FeatureJob {
                detector: self.params.clone(),
                open: self.open.clone(),
                images: ImageKind::default(),
            },
            matching: self.matching.clone(),
            pairs: self.pairs.clone(),
            camera: camera.map_or(CameraChoice::Guessed(CameraModel::SimpleRadial), CameraChoice::Known),
        }
    }
}

#[derive(Debug, Clone)]
pub struct ColmapDone {
    pub report: ColmapReport,
    pub left_out: Vec<(String, String)>,
}

/// Bursts whose features are in the folder, or where the dataset keeps them, are not searched again.
pub(super) fn run(
    bursts: &[BurstFiles],
    request: &ColmapRequest,
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
    let job = request.job();
    let mut store = FeatureStore::open(&request.out, &job.features)?;
    if let Some(kept) = request.kept.clone().filter(|kept| *kept != request.out && kept.is_dir()) {
        gather(&mut store, bursts, &[kept], monitor)?;
    }
    let report = export_colmap(&mut store, bursts, &job, &mut on, monitor)?;
    Ok(ColmapDone { report, left_out })
}
