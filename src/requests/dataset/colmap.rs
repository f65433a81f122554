//! What COLMAP's mapper takes, made of a whole dataset: the work of the command `colmap`, as a request.

use super::DatasetEvent;
use crate::burst::{BurstSource, OpenOptions};
use crate::dataset::{
    CameraChoice, ColmapJob, ColmapReport, DatasetError, Event, FeatureJob, ImageKind, export_colmap,
};
use crate::detector::SearchParams;
use crate::matching::{CameraModel, MatchParams, PairSelection};
use crate::monitor::Monitor;
use std::path::PathBuf;

/// What is made, and where.
#[derive(Debug, Clone, PartialEq)]
pub struct ColmapRequest {
    /// The folder that is written.
    pub out: PathBuf,
    /// How features are found.
    pub params: SearchParams,
    /// How bursts are opened.
    pub open: OpenOptions,
    /// How they are matched; the camera among it, where it is known.
    pub matching: MatchParams,
    /// Which bursts are matched with which.
    pub pairs: PairSelection,
}

impl ColmapRequest {
    /// As the command does it when it is given nothing else.
    fn job(&self) -> ColmapJob {
        let camera = self.matching.camera.clone();
        ColmapJob {
            features: FeatureJob {
                detector: self.params.clone(),
                open: self.open.clone(),
                images: ImageKind::default(),
            },
            matching: self.matching.clone(),
            pairs: self.pairs,
            camera: camera.map_or(CameraChoice::Guessed(CameraModel::SimpleRadial), CameraChoice::Known),
        }
    }
}

/// What was written, and which bursts were left out and why.
#[derive(Debug, Clone)]
pub struct ColmapDone {
    /// What was written.
    pub report: ColmapReport,
    /// Name and reason of each burst that could not be opened.
    pub left_out: Vec<(String, String)>,
}

/// Does it. `tell` hears of each burst; bursts whose features are in the folder already are not done again.
///
/// # Errors
/// As [`export_colmap`].
pub(super) fn run(
    bursts: &[BurstSource],
    request: &ColmapRequest,
    tell: &dyn Fn(DatasetEvent),
    monitor: &Monitor,
) -> Result<ColmapDone, DatasetError> {
    let (mut left_out, mut at) = (Vec::new(), 0);
    let mut on = |event: Event<'_>| match event {
        Event::Begin { index, .. } => {
            at = index;
            tell(DatasetEvent::Begun { index });
        }
        Event::Done(features) => tell(DatasetEvent::Done { index: at, finished: features.summary() }),
        Event::Failed { name, error } => {
            tell(DatasetEvent::Failed { index: at, error: error.to_string() });
            left_out.push((name.to_owned(), error.to_string()));
        }
        Event::Matching { .. } => {}
    };
    let report = export_colmap(bursts, &request.out, &request.job(), &mut on, monitor)?;
    Ok(ColmapDone { report, left_out })
}
