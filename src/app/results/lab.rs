//! The Lab: its questions with the settings of their studies, and the studies that answer them: the curves so far, and
//! the chart on show.

use crate::app::document::lab::{LabQuestion, LabSet};
use crate::app::document::side::Side;
use crate::app::results::{Effect, Model};
use crate::engine::{Ended, Engine, Wanted};
use crate::figures::{FigureSize, FiguresJob, find_colmap};
use crate::recover::{Planted, RecoverReport, RecoverStudy};
use crate::requests::{BurstSource, JobError, StudyRequest};
use crate::study::{BurstsOfStudy, ChartOfStudy, ShownChart, Study, StudyReport};
use crate::teach::Workspace;
use std::path::PathBuf;

#[derive(Debug, Clone)]
pub struct LabResult {
    pub study: Study,
    pub report: StudyReport,
    pub is_whole: bool,
}

#[derive(Debug, Clone)]
pub struct KeptCurves {
    pub name: String,
    pub is_shown: bool,
    pub result: LabResult,
}

/// Results of studies.
#[derive(Debug, Default)]
pub struct Studies {
    pub current: Option<LabResult>,
    pub kept: Vec<KeptCurves>,
    pub shown: Option<ShownChart>,
    pub wanted: Wanted<StudyRequest>,
    pub wanted_chart: Wanted<ChartOfStudy>,
    pub problem: Option<String>,
    pub probe_when_open: Option<(BurstSource, [f32; 2])>,
}

impl Studies {
    pub fn result(&self, set: LabSet) -> Option<&LabResult> {
        match set {
            LabSet::Current => self.current.as_ref(),
            LabSet::Kept(index) => self.kept.get(index).map(|kept| &kept.result),
        }
    }

    /// The results that are drawn, the newest first, each with the name that its curves have beside their method's.
    pub fn shown_results(&self, question: LabQuestion) -> Vec<(LabSet, Option<&str>, &LabResult)> {
        let current = self.current.iter().map(|result| (LabSet::Current, None, result));
        let kept = self.kept.iter().enumerate().filter(|(_, kept)| kept.is_shown);
        let kept = kept.map(|(index, kept)| (LabSet::Kept(index), Some(kept.name.as_str()), &kept.result));
        current.chain(kept).filter(|(.., result)| question.asks_for(&result.report)).collect()
    }

    pub fn keep_current(&mut self) {
        if let Some(result) = self.current.clone() {
            let name = format!("Kept {}", self.kept.len() + 1);
            self.kept.push(KeptCurves { name, is_shown: true, result });
        }
    }

    pub fn recovered(&self) -> Option<(&RecoverStudy, &RecoverReport)> {
        match (&self.current.as_ref()?.study, &self.current.as_ref()?.report) {
            (Study::Recover(study, _), StudyReport::Recover(report)) => Some((study, report)),
            _ => None,
        }
    }
}

impl Model {
    pub fn lab_results(&self) -> Vec<(LabSet, Option<&str>, &LabResult)> {
        self.results.studies.shown_results(self.document.lab.question)
    }

    pub fn forget_kept(&mut self, index: usize) {
        if index >= self.results.studies.kept.len() {
            return;
        }
        self.results.studies.kept.remove(index);
        match &mut self.document.lab.selected {
            Some((LabSet::Kept(selected), _)) if *selected > index => *selected -= 1,
            Some((LabSet::Kept(selected), _)) if *selected == index => self.document.lab.selected = None,
            _ => {}
        }
    }

    pub fn selected_chart(&self) -> Option<ChartOfStudy> {
        let (set, point) = self.document.lab.selected?;
        let study = self.results.studies.result(set)?.study.clone();
        let (first, count) = study.seeds()?;
        let seed = first.saturating_add(self.document.lab.selected_chart.min(count.saturating_sub(1)));
        Some(ChartOfStudy { study, point, seed })
    }

    pub fn selected_thing(&self) -> Option<&Planted> {
        let (seed, id) = self.document.lab.selected_thing?;
        self.results.studies.recovered()?.1.planted.iter().find(|one| (one.seed, one.truth.id) == (seed, id))
    }

    pub fn current_chart(&self) -> Option<&ShownChart> {
        let wanted = self.selected_chart()?;
        self.results.studies.shown.as_ref().filter(|shown| shown.of == wanted)
    }

    pub(in crate::app) fn run_study(&mut self, engine: &Engine) {
        match self.lab_study() {
            Ok(study) => {
                let open = self.results.slots.a.burst.clone();
                (self.document.lab.selected, self.document.lab.selected_thing) = (None, None);
                self.messages.forget_note();
                let studies = &mut self.results.studies;
                // Of another study the curves stay beside the new ones.
                let is_kept = |last: &LabResult| studies.kept.iter().any(|kept| kept.result.study == last.study);
                let is_another = |last: &LabResult| last.is_whole && last.study != study && !is_kept(last);
                if studies.current.as_ref().is_some_and(is_another) {
                    studies.keep_current();
                }
                (studies.problem, studies.current, studies.shown) = (None, None, None);
                studies.wanted.ask(engine, StudyRequest { study, open });
            }
            Err(problem) => self.results.studies.problem = Some(problem),
        }
    }

    pub(in crate::app) fn open_planted(&mut self, engine: &Engine) {
        let (Some(one), Some((study, _)), Some(open)) =
            (self.selected_thing(), self.results.studies.recovered(), &self.results.slots.a.burst)
        else {
            return;
        };
        // From within a copy, the next one is of the same burst.
        let of = match &open.source {
            BurstSource::Planted { of, .. } => of.clone(),
            source => Box::new(source.clone()),
        };
        let source = BurstSource::Planted { of, study: Box::new(study.clone()), seed: one.seed };
        let place = [one.truth.u as f32, one.truth.v as f32];
        self.document.workspace = Workspace::Inspect;
        self.results.studies.probe_when_open = Some((source.clone(), place));
        self.open(Side::A, source, engine);
    }

    pub(super) fn take_part_of_study(&mut self, report: StudyReport) {
        let lab = &mut self.results.studies;
        if let Some(request) = lab.wanted.pending() {
            lab.current = Some(LabResult { study: request.study.clone(), report, is_whole: false });
        }
    }

    pub(super) fn take_study(&mut self, ended: Ended<StudyRequest>) -> Vec<Effect> {
        match ended.result {
            Ok(report) => {
                self.results.studies.current = Some(LabResult { study: ended.request.study, report, is_whole: true });
                self.messages.note("The study is finished");
            }
            Err(JobError::Cancelled) => self.messages.note("The study was cancelled"),
            Err(error) => self.results.studies.problem = Some(error.to_string()),
        }
        Vec::new()
    }

    pub(super) fn missing_chart(&self) -> Option<ChartOfStudy> {
        self.selected_chart().filter(|_| self.current_chart().is_none())
    }

    pub(super) fn take_chart(&mut self, ended: Ended<ChartOfStudy>) {
        match ended.result {
            Ok(shown) => self.results.studies.shown = Some(shown),
            Err(JobError::Cancelled) => {}
            Err(error) => self.results.studies.problem = Some(error.to_string()),
        }
    }

    pub(super) fn probe_planted(&mut self) {
        let is_open = |(source, _): &mut (BurstSource, [f32; 2])| {
            self.results.slots.a.burst.as_ref().is_some_and(|open| open.source == *source)
        };
        if let Some((_, place)) = self.results.studies.probe_when_open.take_if(is_open) {
            self.probe_place(Side::A, place);
        }
    }

    pub fn lab_study(&self) -> Result<Study, String> {
        let bursts = self.results.slots.a.burst.as_ref().map(|open| BurstsOfStudy {
            burst: open.burst.clone(),
            second: self.results.slots.b.burst.as_ref().map(|second| second.burst.clone()),
            truth: None,
        });
        self.document.lab.study(&self.asked(), bursts.as_ref())
    }
}

const TITLE: &str = "Figures of the paper";

impl Model {
    pub(in crate::app) fn make_figures(&mut self, out: PathBuf, engine: &Engine) {
        self.messages.resolved(TITLE);
        let job = FiguresJob { out, only: Vec::new(), size: FigureSize::Full, colmap: find_colmap() };
        self.results.figures.ask(engine, job);
    }

    pub(super) fn take_figures(&mut self, ended: Ended<FiguresJob>) -> Vec<Effect> {
        match ended.result {
            Ok(report) => {
                self.messages.resolved(TITLE);
                self.messages.note(format!("The figures are there: open {}", report.page.display()));
            }
            Err(JobError::Cancelled) => {
                self.messages.note("Figures of the paper cancelled; what is finished is kept");
            }
            Err(error) => self.messages.error(TITLE, error.to_string()),
        }
        Vec::new()
    }
}
