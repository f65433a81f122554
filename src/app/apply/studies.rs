//! Studies: those of the Lab are started and kept, what was planted is opened to be probed, and trajectories of cameras
//! are read, compared and closed.

use crate::app::apply::{opening, probe};
use crate::app::document::{LabSet, Side, Trajectories};
use crate::app::results::studies::{LabResult, TrajectoryResults};
use crate::app::results::{Model, Read};
use crate::engine::{Ended, Engine};
use crate::evaluate::poses::{DEMO_ESTIMATE, DEMO_TRUTH, PoseStudy, Projection};
use crate::figures::{FigureSize, FiguresJob, find_colmap};
use crate::requests::{BurstSource, JobError, PosesRequest, StudyRequest, TrajectorySource, Which};
use crate::study::{ChartOfStudy, StudyReport};
use crate::teach::Workspace;
use std::path::PathBuf;

const TITLE: &str = "Figures of the paper";

pub fn forget_kept(model: &mut Model, index: usize) {
    if index >= model.results.studies.kept.len() {
        return;
    }
    model.results.studies.kept.remove(index);
    match &mut model.document.lab.selected {
        Some((LabSet::Kept(selected), _)) if *selected > index => *selected -= 1,
        Some((LabSet::Kept(selected), _)) if *selected == index => model.document.lab.selected = None,
        _ => {}
    }
}

pub(in crate::app) fn run_study(model: &mut Model, engine: &Engine) {
    match Read::of(model).lab_study() {
        Ok(study) => {
            let open = model.results.slots.a.burst.clone();
            (model.document.lab.selected, model.document.lab.selected_thing) = (None, None);
            model.shell.messages.forget_note();
            let studies = &mut model.results.studies;
            // Of another study the curves stay beside the new ones.
            let is_kept = |last: &LabResult| studies.kept.iter().any(|kept| kept.result.study == last.study);
            let is_another = |last: &LabResult| last.is_whole && last.study != study && !is_kept(last);
            if studies.current.as_ref().is_some_and(is_another) {
                studies.keep_current();
            }
            (studies.problem, studies.current, studies.shown) = (None, None, None);
            studies.wanted.ask(engine, StudyRequest { study, open });
        }
        Err(problem) => model.results.studies.problem = Some(problem),
    }
}

pub(in crate::app) fn open_planted(model: &mut Model, engine: &Engine) {
    let Some(one) = Read::of(model).selected_thing() else { return };
    let Some((study, _)) = model.results.studies.recovered() else { return };
    let Some(open) = &model.results.slots.a.burst else { return };
    // From within a copy, the next one is of the same burst.
    let of = if let BurstSource::Planted { of, .. } = &open.source { of.clone() } else { open.source.clone().into() };
    let source = BurstSource::Planted { of, study: Box::new(study.clone()), seed: one.seed };
    let place = [one.truth.u as f32, one.truth.v as f32];
    model.document.open_workspace(Workspace::Inspect);
    model.results.studies.probe_when_open = Some((source.clone(), place));
    opening::open(model, Side::A, source, engine);
}

pub(super) fn take_part_of_study(model: &mut Model, report: StudyReport) {
    let lab = &mut model.results.studies;
    if let Some(request) = lab.wanted.pending() {
        lab.current = Some(LabResult { study: request.study.clone(), report, is_whole: false });
    }
}

pub(super) fn take_study(model: &mut Model, ended: Ended<StudyRequest>) {
    match ended.result {
        Ok(report) => {
            model.results.studies.current = Some(LabResult { study: ended.request.study, report, is_whole: true });
            model.shell.messages.note("The study is finished");
        }
        Err(JobError::Cancelled) => model.shell.messages.note("The study was cancelled"),
        Err(error) => model.results.studies.problem = Some(error.to_string()),
    }
}

pub(super) fn take_chart(model: &mut Model, ended: Ended<ChartOfStudy>) {
    match ended.result {
        Ok(shown) => model.results.studies.shown = Some(shown),
        Err(JobError::Cancelled) => {}
        Err(error) => model.results.studies.problem = Some(error.to_string()),
    }
}

pub(super) fn probe_planted(model: &mut Model) {
    let is_open = |(source, _): &mut (BurstSource, [f32; 2])| {
        model.results.slots.a.burst.as_ref().is_some_and(|open| open.source == *source)
    };
    if let Some((_, place)) = model.results.studies.probe_when_open.take_if(is_open) {
        probe::probe_place(model, Side::A, place);
    }
}

pub(in crate::app) fn make_figures(model: &mut Model, out: PathBuf, engine: &Engine) {
    model.shell.messages.resolved(TITLE);
    let job = FiguresJob { out, only: Vec::new(), size: FigureSize::Full, colmap: find_colmap() };
    model.results.figures.ask(engine, job);
}

pub(super) fn take_figures(model: &mut Model, ended: Ended<FiguresJob>) {
    match ended.result {
        Ok(report) => {
            model.shell.messages.resolved(TITLE);
            model.shell.messages.note(format!("The figures are there: open {}", report.page.display()));
        }
        Err(JobError::Cancelled) => {
            model.shell.messages.note("Figures of the paper cancelled; what is finished is kept");
        }
        Err(error) => model.shell.messages.error(TITLE, error.to_string()),
    }
}

pub fn open_trajectory(model: &mut Model, which: Which, path: Option<PathBuf>, engine: &Engine) {
    let (set, poses) = (&mut model.document.trajectories, &mut model.results.poses);
    let mut request = poses.request(set.study);
    request.sources[which as usize] = path.clone().map(|path| TrajectorySource { path, read: None });
    *set.paths_mut()[which as usize] = path;
    poses.reading.ask(engine, request);
    model.document.open_workspace(Workspace::Trajectories);
}

pub(in crate::app) fn set_pose_study(model: &mut Model, study: PoseStudy, engine: &Engine) {
    model.document.trajectories.study = study;
    model.results.poses.reading.ask(engine, model.results.poses.request(study));
}

pub fn close_trajectories(model: &mut Model) {
    let Trajectories { study, projection, points, .. } = model.document.trajectories;
    model.document.trajectories = Trajectories { study, projection, points, ..Trajectories::default() };
    model.results.poses = TrajectoryResults::default();
}

/// Takes the answers. Other trajectories than before reset pan and zoom, and another truth the selection; where one
/// cannot be read, those that are open stay.
pub(super) fn take_trajectories(model: &mut Model, ended: Ended<PosesRequest>) {
    const TITLE: &str = "Trajectories";
    let (set, before) = (&mut model.document.trajectories, &model.results.poses.compared.read);
    match ended.result {
        Ok(compared) => {
            model.shell.messages.resolved(TITLE);
            let is_other = |which: Which| match (&before[which as usize], &compared.read[which as usize]) {
                (Some((_, before)), Some((_, now))) => !std::sync::Arc::ptr_eq(before, now),
                (before, now) => before.is_some() && now.is_none(),
            };
            if Which::ALL.into_iter().any(is_other) {
                set.view = crate::app::view::View::fit();
            }
            set.selected.take_if(|_| is_other(Which::Truth));
            set.point.take_if(|_| is_other(Which::Estimate));
            let mut models = compared.read.iter().flatten().filter_map(|(_, read)| read.model.as_ref());
            if let Some(taken) = models.find_map(|model| model.taken()) {
                model.shell.messages.note(crate::inspect::words::capitalised(&taken));
            }
            let reading = std::mem::take(&mut model.results.poses.reading);
            model.results.poses = TrajectoryResults { compared, reading, ..TrajectoryResults::default() };
        }
        Err(error) => {
            for (set, before) in set.paths_mut().into_iter().zip(before) {
                *set = before.as_ref().map(|(path, _)| path.clone());
            }
            model.shell.messages.error(TITLE, error.to_string());
        }
    }
}

pub(in crate::app) fn show_demo_cameras(model: &mut Model, engine: &Engine) {
    let [estimate, truth] = [DEMO_ESTIMATE, DEMO_TRUTH].map(|name| Some(PathBuf::from(name)));
    let (points, projection) = (true, Projection::Xz);
    model.document.trajectories = Trajectories { estimate, truth, points, projection, ..Trajectories::default() };
    read_trajectories(model, engine);
}

pub(in crate::app) fn read_trajectories(model: &mut Model, engine: &Engine) {
    model.results.poses = TrajectoryResults::default();
    let set = &model.document.trajectories;
    let sources = set.paths().map(|path| path.clone().map(|path| TrajectorySource { path, read: None }));
    if sources.iter().any(Option::is_some) {
        model.results.poses.reading.ask(engine, PosesRequest { sources, study: set.study });
    }
}
