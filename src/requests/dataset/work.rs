//! Work on a dataset: opening, detecting and matching.

use super::{DatasetAnswer, DatasetEvent, DatasetRequest, Keeping, OpenDataset};
use crate::burst::{Entries, OpenOptions};
use crate::dataset::{
    BurstCameras, BurstEvent, DatasetSource, FeatureStore, KeptBursts, MatchedPair, detect_all, match_pairs,
};
use crate::detector::SearchParams;
use crate::monitor::{Monitor, Stage};
use crate::requests::{JobError, Request, Urgency, Work};
use std::path::PathBuf;
use std::sync::Arc;

impl Request for DatasetRequest {
    type Answer = DatasetAnswer;
    type Partial = DatasetEvent;
    const URGENCY: Urgency = Urgency::Dataset;

    fn compute(self, work: &Work<'_, DatasetEvent>) -> Result<DatasetAnswer, JobError> {
        let (tell, monitor) = (work.tell, work.monitor);
        match self {
            Self::Open { source, folder, params, open } => {
                look(source, folder, params, open, monitor).map(|open| DatasetAnswer::Opened(Box::new(open)))
            }
            Self::Detect { bursts, keeping } => {
                let mut on = |event: BurstEvent<'_>| DatasetEvent::of(&event).into_iter().for_each(tell);
                detect_all(&mut keeping.store()?, &bursts, &BurstCameras::default(), &mut on, monitor)?;
                Ok(DatasetAnswer::Detected)
            }
            Self::Match { bursts, keeping, pairs, matching } => {
                // Features are read when a pair needs them, so that few bursts are in memory.
                let mut kept = KeptBursts { store: &keeping.store()?, bursts: &bursts, monitor };
                let pairs = kept.pairs(&pairs)?;
                let mut on = |matched: MatchedPair<'_>| {
                    let aligned = matched.aligned(&matching, &monitor.silent())?;
                    tell(DatasetEvent::Matched { pair: matched.indices, counts: aligned.counts });
                    Ok(())
                };
                let left_out = match_pairs::<JobError>(&pairs, &matching, &mut kept, &mut on, monitor)?;
                Ok(DatasetAnswer::Matched { left_out })
            }
            #[cfg(feature = "colmap")]
            Self::Colmap { bursts, request } => {
                let done = super::colmap::run(&bursts, *request, tell, monitor)?;
                Ok(DatasetAnswer::Colmap(Box::new(done)))
            }
        }
    }
}

fn look(
    source: DatasetSource,
    folder: Option<PathBuf>,
    params: SearchParams,
    open: OpenOptions,
    monitor: &Monitor,
) -> Result<OpenDataset, JobError> {
    monitor.report(Stage::Open, 0.0);
    let Entries { bursts, strays } = source.entries(&open)?;
    monitor.check()?;
    let frames_of_one = if let [one] = &bursts[..] { one.files().ok().map(|files| files.len()) } else { None };
    let folder = folder.or_else(|| source.default_folder());
    let (mut finished, mut folder_error, mut other_params) = (vec![None; bursts.len()], None, None);
    // A folder that cannot be read is reported beside the open dataset, and does not keep it from opening.
    if let Some(folder) = &folder {
        match (Keeping { folder: folder.clone(), params: params.clone(), open: open.clone() }).store() {
            Ok(store) => {
                for (index, (burst, finished)) in bursts.iter().zip(&mut finished).enumerate() {
                    monitor.check()?;
                    monitor.report(Stage::Open, index as f32 / bursts.len() as f32);
                    *finished = store.finished(burst);
                }
                other_params = FeatureStore::params_in(folder).filter(|stored| *stored != params);
            }
            Err(error) => folder_error = Some(error.to_string()),
        }
    }
    let bursts = Arc::new(bursts);
    Ok(OpenDataset {
        source,
        bursts,
        strays,
        frames_of_one,
        folder,
        folder_error,
        params,
        open,
        finished,
        other_params,
    })
}
