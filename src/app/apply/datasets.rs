//! Work on a dataset that is asked for: opening it, finding features and matching in it, and writing it for COLMAP.

use crate::app::document::DatasetChoice;
use crate::app::results::{Effect, Model, Read, Work};
use crate::burst::OpenOptions;
use crate::dataset::DatasetSource;
#[cfg(feature = "colmap")]
use crate::dataset::{BurstCameras, CameraChoice, ColmapJob, FeatureJob, ImageKind};
use crate::engine::Engine;
use crate::matching::PairSelection;
use crate::requests::DatasetRequest;
use std::path::PathBuf;

/// Opens a dataset in the background; the open one stays until then. Without a folder the features are kept beside
/// the bursts. A single long sequence is first offered for cutting.
pub(in crate::app) fn look_at_dataset(
    model: &mut Model,
    source: DatasetSource,
    folder: Option<PathBuf>,
    open: OpenOptions,
    engine: &Engine,
) {
    let params = Read::of(model).asked();
    model.results.datasets.begin(Work::Opening, DatasetRequest::Open { source, folder, params, open }, engine);
}

pub(in crate::app) fn look_at_dataset_again(model: &mut Model, engine: &Engine) {
    if let Some(dataset) = &model.results.datasets.open {
        let options = model.document.calibration.clone();
        look_at_dataset(model, dataset.source.clone(), dataset.folder.clone(), options, engine);
    }
}

pub(in crate::app) fn use_feature_folder(model: &mut Model, folder: PathBuf, engine: &Engine) {
    if let Some(dataset) = &model.results.datasets.open {
        look_at_dataset(model, dataset.source.clone(), Some(folder), dataset.open.clone(), engine);
    }
}

pub(in crate::app) fn use_folder_params(model: &mut Model, engine: &Engine) {
    if let Some(params) = model.results.datasets.open.as_ref().and_then(|dataset| dataset.other_params.clone()) {
        model.document.params = params;
        look_at_dataset_again(model, engine);
    }
}

pub(in crate::app) fn close_dataset(model: &mut Model) -> Effect {
    (model.results.datasets, model.document.dataset) = Default::default();
    Effect::ForgetThumbnails
}

pub(in crate::app) fn cut_open_burst(model: &mut Model, length: usize, engine: &Engine) {
    if let Some(Effect::Cut { paths, .. }) = Read::of(model).cut_of_open_burst() {
        let source = DatasetSource { paths, burst_length: Some(length), burst_step: None };
        look_at_dataset(model, source, None, model.document.calibration.clone(), engine);
    }
}

/// Finds the features of all bursts; where that replaces features of other parameters, the user is asked first.
pub(in crate::app) fn ask_and_detect_all(model: &mut Model, engine: &Engine) -> Option<Effect> {
    let params = Read::of(model).asked();
    if model.results.datasets.open.as_ref().is_some_and(|dataset| dataset.would_replace(&params)) {
        return Some(Effect::ReplaceFeatures);
    }
    detect_all(model, engine);
    None
}

pub(in crate::app) fn detect_all(model: &mut Model, engine: &Engine) {
    let params = Read::of(model).asked();
    let Some(dataset) = &mut model.results.datasets.open else { return };
    dataset.begin_detection(&params);
    if let Some(keeping) = dataset.keeping() {
        let bursts = dataset.bursts.clone();
        model.shell.messages.resolved(Work::Detecting.title());
        model.results.datasets.begin(Work::Detecting, DatasetRequest::Detect { bursts, keeping }, engine);
    }
}

pub(in crate::app) fn match_pairs(model: &mut Model, engine: &Engine) {
    start_matching_pairs(model, model.document.pairs.selection(), engine);
}

pub(in crate::app) fn match_selected(model: &mut Model, engine: &Engine) {
    if let Some(pair) = model.document.dataset.as_ref().and_then(DatasetChoice::selected) {
        start_matching_pairs(model, PairSelection::Listed(vec![pair]), engine);
    }
}

fn start_matching_pairs(model: &mut Model, pairs: PairSelection, engine: &Engine) {
    let matching = model.document.matching.clone();
    let Some(dataset) = &mut model.results.datasets.open else { return };
    dataset.matches.begin(&matching);
    if let Some(keeping) = dataset.keeping() {
        let bursts = dataset.bursts.clone();
        model.shell.messages.resolved(Work::Matching.title());
        let request = DatasetRequest::Match { bursts, keeping, pairs, matching };
        model.results.datasets.begin(Work::Matching, request, engine);
    }
}

#[cfg(feature = "colmap")]
pub(in crate::app) fn export_database(model: &mut Model, out: PathBuf, engine: &Engine) {
    let Some(dataset) = &model.results.datasets.open else { return };
    let matching = model.document.matching.clone();
    let rest = matching.camera.clone().map_or_else(CameraChoice::default, CameraChoice::Known);
    let (detector, images) = (Read::of(model).asked(), ImageKind::default());
    let job = ColmapJob {
        features: FeatureJob { detector, open: dataset.open.clone(), images },
        matching,
        pairs: model.document.pairs.selection(),
        cameras: BurstCameras { rest, ..Default::default() },
    };
    let (inputs, kept) = (dataset.source.paths.clone(), dataset.folder.clone());
    let request = crate::requests::ColmapRequest { out, inputs, kept, job };
    let bursts = dataset.bursts.clone();
    model.shell.messages.resolved(Work::Exporting.title());
    let request = DatasetRequest::Colmap { bursts, request: Box::new(request) };
    model.results.datasets.begin(Work::Exporting, request, engine);
}
