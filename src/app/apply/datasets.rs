//! The open dataset: the work on it that is asked for (finding features, matching, writing it for COLMAP), the
//! bursts of it that are gone to, and what the answers about it change.

use crate::app::apply::opening;
use crate::app::document::{DatasetChoice, SavedSelection, Side, Sides};
use crate::app::results::{Dataset, Effect, Model, Read, Work};
#[cfg(feature = "colmap")]
use crate::dataset::{BurstCameras, CameraChoice, ColmapJob, FeatureJob, ImageKind};
use crate::engine::{Ended, Engine};
use crate::inspect::words::counted;
use crate::matching::PairSelection;
use crate::requests::{BurstSource, DatasetAnswer, DatasetEvent, DatasetRequest, JobError, OpenDataset};
use crate::teach::Workspace;
use std::path::PathBuf;

pub(in crate::app) fn use_feature_folder(model: &mut Model, folder: PathBuf, engine: &Engine) {
    if let Some(dataset) = &model.results.datasets.open {
        opening::look_at_dataset(model, dataset.source.clone(), Some(folder), dataset.open.clone(), engine);
    }
}

pub(in crate::app) fn use_folder_params(model: &mut Model, engine: &Engine) {
    if let Some(params) = model.results.datasets.open.as_ref().and_then(|dataset| dataset.other_params.clone()) {
        model.document.params = params;
        opening::look_at_dataset_again(model, engine);
    }
}

pub(in crate::app) fn close_dataset(model: &mut Model) -> Effect {
    (model.results.datasets, model.document.dataset) = Default::default();
    Effect::ForgetThumbnails
}

pub(in crate::app) fn cut_open_burst(model: &mut Model, length: usize, engine: &Engine) {
    if let Some(Effect::Cut(paths, _)) = Read::of(model).cut_of_open_burst() {
        let source = crate::dataset::DatasetSource { paths, burst_length: Some(length), burst_step: None };
        opening::look_at_dataset(model, source, None, model.document.calibration.clone(), engine);
    }
}

/// Finds the features of all bursts; where that replaces features of other parameters, the user is asked first.
pub(in crate::app) fn ask_and_detect_all(model: &mut Model, engine: &Engine) -> Option<Effect> {
    if model.results.datasets.open.as_ref().is_some_and(|dataset| dataset.would_replace(&Read::of(model).asked())) {
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

pub(in crate::app) fn show_selected_pair(model: &mut Model, engine: &Engine) {
    let (Some(_), Some(set)) = (&model.results.datasets.open, &model.document.dataset) else { return };
    let Sides { a: Some(a), b: Some(b) } = set.pair else { return };
    open_burst_at(model, Side::A, a, engine);
    open_burst_at(model, Side::B, b, engine);
    model.document.open_workspace(Workspace::Pair);
}

pub(in crate::app) fn step_burst(model: &mut Model, by: isize, engine: &Engine) {
    let Some(dataset) = &model.results.datasets.open else { return };
    let last = dataset.bursts.len() - 1;
    let here = Read::of(model).place_of(Side::A);
    open_burst_at(model, Side::A, here.map_or(0, |place| place.saturating_add_signed(by).min(last)), engine);
}

pub(in crate::app) fn open_burst_at(model: &mut Model, side: Side, place: usize, engine: &Engine) {
    let source = model.results.datasets.open.as_ref().and_then(|dataset| dataset.source_at(place));
    if let Some(source) = source.filter(|_| Read::of(model).place_of(side) != Some(place)) {
        opening::open(model, side, source, engine);
    }
}

/// Shows the burst of a camera, with the feature of an index as soon as its features are found.
pub(in crate::app) fn look_at_camera(model: &mut Model, label: &str, feature: Option<usize>, engine: &Engine) {
    let dataset = model.results.datasets.open.as_ref();
    match dataset.map(|d| (d.place_of_camera(label), d.source.label())) {
        Some((Some(place), _)) => {
            let is_open = Read::of(model).place_of(Side::A) == Some(place);
            if let Some(saved) = feature.map(SavedSelection::of_index) {
                model.document.selected = Read::of(model).find_again(&saved).filter(|_| is_open);
                model.results.reselect = Some(saved).filter(|_| model.document.selected.is_none());
            }
            open_burst_at(model, Side::A, place, engine);
            model.document.open_workspace(Workspace::Inspect);
        }
        Some((None, name)) => {
            model.shell.messages.note(format!("{name} has no burst with the name of the camera {label}"));
        }
        None => model.shell.messages.note(format!("Open the dataset of {label} to show its burst")),
    }
}

pub(in crate::app) fn choose_open_burst(model: &mut Model, side: Side) {
    let place = Read::of(model).place_of(Side::A);
    if let (Some(set), Some(place)) = (&mut model.document.dataset, place) {
        set.choose(side, place);
    }
}

pub(super) fn take_dataset_event(model: &mut Model, event: &DatasetEvent) {
    model.results.datasets.open.iter_mut().for_each(|dataset| dataset.take_event(event));
    // Counts that were said before are old.
    model.shell.messages.forget_note();
}

pub(super) fn take_dataset_answer(model: &mut Model, answer: Ended<DatasetRequest>, engine: &Engine) -> Vec<Effect> {
    let work = model.results.datasets.work.take();
    if let Some(dataset) = &mut model.results.datasets.open {
        dataset.stop();
    }
    if work == Some(Work::Opening) && answer.result.is_err() {
        // A session may have named another one.
        let choice = |d: &Dataset| model.document.dataset.take_if(|set| set.source == d.source).unwrap_or(d.choice());
        model.document.dataset = model.results.datasets.open.as_ref().map(choice);
    }
    let title = work.map_or("Dataset", Work::title);
    let mut effects = Vec::new();
    match answer.result {
        Ok(DatasetAnswer::Opened(open)) => {
            model.shell.messages.resolved(title);
            effects = take_dataset(model, *open, engine);
        }
        Ok(DatasetAnswer::Detected) => say_what_was_found(model, answer.elapsed.as_secs_f64()),
        Ok(DatasetAnswer::Matched { left_out }) => say_what_matched(model, left_out, answer.elapsed.as_secs_f64()),
        #[cfg(feature = "colmap")]
        Ok(DatasetAnswer::Colmap(done)) => say_what_was_exported(model, &done),
        Err(JobError::Cancelled) => model.shell.messages.note(format!("{title}: cancelled; what is done stays done")),
        Err(error) => model.shell.messages.error(title, error.to_string()),
    }
    // The states told of the folder that was written; those of the dataset's own are looked at again.
    if work == Some(Work::Exporting) {
        opening::look_at_dataset_again(model, engine);
    }
    effects
}

fn take_dataset(model: &mut Model, open: OpenDataset, engine: &Engine) -> Vec<Effect> {
    let same = model.results.datasets.open.as_ref().is_some_and(|d| d.bursts == open.bursts);
    match open.frames_of_one {
        // A lone burst of many files is a sequence that is yet to be cut.
        Some(frames) if frames > 1 && open.source.burst_length.is_none() => {
            return vec![Effect::Cut(open.source.paths, frames)];
        }
        Some(1) if open.source.burst_length.is_none() => {
            opening::open(model, Side::A, BurstSource::Paths(open.source.paths), engine);
            return Vec::new();
        }
        _ => {}
    }
    let set = model.document.dataset.take().filter(|set| set.source == open.source);
    let is_set = set.is_some();
    let (source, folder) = (open.source.clone(), open.folder.clone());
    let choice = DatasetChoice { source, folder, pair: set.map(|set| set.pair).unwrap_or_default() };
    model.document.dataset = Some(choice.within(open.bursts.len()));
    model.shell.messages.settle("Feature folder", open.folder_error.clone().map_or(Ok(()), Err));
    if let Some(dataset) = model.results.datasets.open.as_mut().filter(|_| same) {
        dataset.look_again(open);
        return Vec::new();
    }
    if let [first, rest @ ..] = &open.strays[..] {
        let more = if rest.is_empty() { String::new() } else { format!(" (and {} more)", rest.len()) };
        model.shell.messages.error("Open dataset", format!("{}{more}", crate::error::Error::stray(first)));
    }
    let dataset = Dataset::new(open);
    let (name, bursts) = (dataset.source.label(), counted(dataset.bursts.len(), "burst"));
    model.shell.messages.note(format!("Opened {name}: {bursts}, {} of them done", dataset.counts().done));
    let recent = Effect::RecentDataset(dataset.source.clone());
    (model.results.datasets.open, model.results.datasets.exported) = (Some(dataset), None);
    model.document.panels.filmstrip = true;
    // A session opens its own burst.
    if Read::of(model).place_of(Side::A).is_none() && !is_set {
        open_burst_at(model, Side::A, 0, engine);
    }
    vec![recent, Effect::ForgetThumbnails]
}

fn say_what_was_found(model: &mut Model, seconds: f64) {
    let Some(dataset) = &model.results.datasets.open else { return };
    let counts = dataset.counts();
    let (bursts, features) = (counted(counts.done, "burst"), counted(counts.features, "feature"));
    let mut text = format!("{bursts} done in {seconds:.1} s: {features}");
    if counts.failed > 0 {
        text += &format!("; {} failed, see the filmstrip", counts.failed);
    }
    model.shell.messages.note(text);
}

fn say_what_matched(model: &mut Model, left_out: usize, seconds: f64) {
    let Some(dataset) = &model.results.datasets.open else { return };
    let mut text = format!("{} matched in {seconds:.1} s", counted(dataset.matches.counts.len(), "pair"));
    if left_out > 0 {
        text += &format!("; {left_out} left out, whose bursts have no features yet");
    }
    model.shell.messages.note(text);
}

#[cfg(feature = "colmap")]
fn say_what_was_exported(model: &mut Model, done: &crate::requests::ColmapDone) {
    let report = &done.report;
    let verified = report.pairs.iter().filter(|pair| pair.counts.inliers.is_some_and(|n| n > 0)).count();
    model.shell.messages.resolved(Work::Exporting.title());
    let folder = report.database.parent();
    model.results.datasets.exported = folder.map(|folder| (folder.into(), report.known_camera));
    let old = folder.and_then(crate::requests::old_model).map_or_else(String::new, |old| format!("; {old}"));
    let (images, pairs) = (counted(report.images.len(), "image"), counted(report.pairs.len(), "pair"));
    let (path, next) = (report.database.display(), report.no_start.as_deref().unwrap_or("Matches has the next step"));
    let text = format!("Wrote {path}: {images}, {pairs}, {verified} of them verified; {next}{old}");
    model.shell.messages.note(text);
    if let Some((name, why)) = done.left_out.first() {
        let others = match done.left_out.len() - 1 {
            0 => String::new(),
            more => format!(" (and {} more)", counted(more, "burst")),
        };
        model.shell.messages.error(Work::Exporting.title(), format!("{name} was left out{others}: {why}"));
    }
}
