//! Opening a burst (what is left behind for the next one, calibration, and the panes that begin with it), or a dataset.

use crate::app::apply::{comparison, pair, panes, params, probe};
use crate::app::document::{Cursor, Filter, Side};
use crate::app::results::{Effect, Model, Own, Read, Work};
use crate::burst::OpenOptions;
use crate::dataset::DatasetSource;
use crate::engine::{Ended, Engine};
use crate::requests::{BurstSource, DatasetRequest, JobError, JobId, OpenBurst, OpenRequest};

/// Takes a burst that was opened, or says why it was not. With `is_restoring` a session goes on with it.
#[must_use]
pub(in crate::app) fn take_opening(
    model: &mut Model,
    side: Side,
    ended: Ended<OpenRequest>,
    is_restoring: bool,
    engine: &Engine,
) -> Vec<Effect> {
    let OpenRequest { source, options } = ended.request;
    let error = match ended.result {
        Ok(burst) => {
            let recent = take_opened(model, side, burst, options, engine);
            if side == Side::B && !is_restoring {
                model.document.open_workspace(crate::teach::Workspace::Pair);
            }
            return recent.into_iter().collect();
        }
        Err(error) => error,
    };
    let slot = &mut model.results.slots[side];
    (slot.leaves, slot.stepped_to) = (None, None);
    slot.refused = slot.burst.is_none().then(|| source.clone());
    match (error, side, source) {
        (JobError::Several(_), Side::A, BurstSource::Paths(paths)) if !is_restoring => {
            look_at_dataset(model, DatasetSource::of_bursts(paths), None, options, engine);
        }
        (JobError::Several(bursts), Side::B, _) if !is_restoring => return vec![Effect::Choose(Side::B, bursts)],
        (JobError::NoShape(_, shapes), side, source) if !is_restoring => {
            return vec![Effect::AskShape(side, source, shapes)];
        }
        (JobError::Cancelled, Side::A, _) => model.shell.messages.note("Opening cancelled"),
        (JobError::Cancelled, Side::B, _) => model.shell.messages.note("Opening B cancelled"),
        (error, ..) => {
            if side == Side::B && model.results.slots.b.burst.is_none() {
                // Panes of a session that wait for it would wait for ever.
                model.document.panes.close_side(Side::B);
            }
            model.shell.messages.error(side.opening(), error.to_string());
        }
    }
    Vec::new()
}

/// It goes to the recent list, unless it is one of the open dataset, which gives it its name.
fn take_opened(
    model: &mut Model,
    side: Side,
    mut burst: OpenBurst,
    options: OpenOptions,
    engine: &Engine,
) -> Option<Effect> {
    let dataset = model.results.datasets.open.as_ref().filter(|dataset| dataset.place_of(&burst.source).is_some());
    let recent = dataset.is_none().then(|| Effect::Recent(burst.source.clone()));
    dataset.into_iter().for_each(|dataset| dataset.name_as_here(&mut burst));
    model.shell.messages.resolved(side.opening());
    let before = Read::of(model).burst_of(side).map(|open| open.source.clone());
    let is_again = before.as_ref() == Some(&burst.source);
    model.results.left_behind.take_if(|_| !is_again);
    leave_behind(model, side);
    model.results.slots[side].refused = None;
    match side {
        Side::A => {
            // A step back or forward has said what it changed.
            if model.results.slots.a.stepped_to.as_ref() != Some(&options) {
                // The status bar names the burst that is open.
                model.shell.messages.forget_note();
                burst.burst.notes().iter().for_each(|note| model.shell.messages.note(note.for_window()));
            }
            take_burst(model, burst);
            probe::start_probe(model, before.as_ref());
            model.document.measure.clear();
            take_calibration(model, options, is_again, engine);
        }
        Side::B => {
            model.shell.messages.note(format!("Opened as B: {}", burst.describe()));
            pair::take_second_burst(model, burst);
            model.document.calibration_of_b = Some(options).filter(|options| *options != model.document.calibration);
        }
    }
    Read::of(model).forget_closed_trails(engine);
    recent
}

/// Takes the options A was opened with: of the burst open before a step to undo, unless a step led to them.
fn take_calibration(model: &mut Model, options: OpenOptions, is_again: bool, engine: &Engine) {
    let is_step = is_again && model.results.slots.a.stepped_to.take().as_ref() != Some(&options);
    let before = model.document.clone();
    let was = std::mem::replace(&mut model.document.calibration, options);
    let is_changed = was != model.document.calibration;
    if is_changed && Read::of(model).burst_of(Side::B).is_some() {
        // B stays as it was opened.
        model.document.calibration_of_b.get_or_insert(was);
    }
    if !is_again {
        model.shell.history = Default::default();
    } else if is_step {
        model.shell.history.take(before, &model.document);
        model.shell.history.close_step(&model.document, false);
    }
    if is_again && is_changed {
        look_at_dataset_again(model, engine);
    }
}

pub fn take_burst(model: &mut Model, burst: OpenBurst) {
    let middle = burst.burst.len() / 2;
    let slot = &mut model.results.slots.a;
    (slot.burst, slot.found) = (Some(burst), None);
    slot.detecting.forget();
    panes::forget_asked_pictures(model);
    (model.document.selected, model.results.hovered, model.document.playing) = (None, None, false);
    model.document.look.ranges.forget();
    (model.results.explained, model.document.selected_candidate) = Default::default();
    pair::forget_matches(model);
    (model.results.compare.gold.a, model.document.gold.a) = (None, None);
    comparison::begin_comparison(model, Side::A);
    panes::start_panes(model, Side::A, |cursor| Cursor { kind: cursor.kind, frame: middle, ..Cursor::default() });
    pair::begin_panes_of_b(model);
    params::check_params(model);
}

/// Opens a burst. One that is another than that of the side leaves what was set for that behind, once it is open.
pub(in crate::app) fn open(model: &mut Model, side: Side, source: BurstSource, engine: &Engine) -> JobId {
    let (read, slot) = (Read::of(model), &model.results.slots[side]);
    let is_open = slot.burst.as_ref().is_some_and(|open| read.are_one(&open.source, &source));
    let pending = slot.opening.pending().filter(|request| !is_open || read.are_one(&request.source, &source));
    let options = pending.map_or_else(|| read.calibration_of(side).clone(), |request| request.options.clone());
    let before = read.settings_are_of(side).filter(|before| !is_open && !read.are_one(before, &source));
    let own = before.map(|before| read.own(before, side));
    let options = match model.results.datasets.open.as_ref().filter(|dataset| dataset.place_of(&source).is_some()) {
        Some(dataset) => dataset.open.clone(),
        None if own.is_some() => options.with_burst_of(&OpenOptions::default()),
        None => options,
    };
    model.results.slots[side].open(OpenRequest { source, options }, own, engine)
}

/// Takes what was set for the burst before off the one that is open now. What was set since it was asked for stays.
pub(super) fn leave_behind(model: &mut Model, side: Side) {
    let Some(own) = model.results.slots[side].leaves.take() else { return };
    let now = Read::of(model).own(&BurstSource::Demo, side);
    if own.frames.is_some() && own.frames == now.frames {
        model.document.params.frames = None;
    }
    if own.slopes.is_some() && own.slopes == now.slopes {
        model.document.params.slopes = crate::detector::Slopes::AUTO;
    }
    if !own.filter.is_open() && own.filter == now.filter {
        model.document.filter = Filter::default();
    }
    model.results.left_behind = Some(own).filter(|own| !own.words().is_empty());
}

/// Uses what the burst before left behind, or drops it.
pub(in crate::app) fn take_left_behind(model: &mut Model, uses: bool, engine: &Engine) {
    let Some(own) = model.results.left_behind.take().filter(|_| uses) else { return };
    let Own { side, calibration, frames, slopes, filter, .. } = own;
    if side == Side::A {
        (model.document.params.frames, model.document.filter) = (frames.or(model.document.params.frames), filter);
        model.document.params.slopes = slopes.unwrap_or(model.document.params.slopes);
    }
    let options = Read::of(model).calibration_of(side).clone().with_burst_of(&calibration);
    let source = Read::of(model).burst_of(side).map(|open| open.source.clone());
    if let Some(source) = source.filter(|_| options != *Read::of(model).calibration_of(side)) {
        model.results.slots[side].open(OpenRequest { source, options }, None, engine);
    }
}

/// Opens what is open again with other options; those that are refused change nothing.
pub(in crate::app) fn calibrate(model: &mut Model, options: OpenOptions, engine: &Engine) -> Effect {
    let burst_of = |options: &OpenOptions| OpenOptions::default().with_burst_of(options);
    let is_of_a = burst_of(&options) == burst_of(&model.document.calibration);
    let of_b = match &model.document.calibration_of_b {
        Some(of_b) if is_of_a => options.clone().with_burst_of(of_b),
        _ => options.clone(),
    };
    for (side, options) in [(Side::A, options), (Side::B, of_b)] {
        let slot = &mut model.results.slots[side];
        let pending = slot.opening.pending().map(|request| request.source.clone());
        match pending.or_else(|| slot.burst.as_ref().map(|open| open.source.clone())) {
            Some(source) => {
                let leaves = slot.leaves.take();
                slot.open(OpenRequest { source, options }, leaves, engine);
            }
            // No frames refuse them.
            None if side == Side::A => {
                model.document.calibration = options;
                look_at_dataset_again(model, engine);
            }
            None => {}
        }
    }
    Effect::ForgetThumbnails
}

/// Opens a dataset in the background; the open one stays until then. Without a folder the features are kept beside
/// the bursts. A single long sequence is first offered for cutting.
pub(in crate::app) fn look_at_dataset(
    model: &mut Model,
    source: DatasetSource,
    folder: Option<std::path::PathBuf>,
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
