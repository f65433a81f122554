//! What the window asks the engine for in the Lab: studies, and the charts behind their points.

use crate::app::project::lab::{LabResult, LabRunning};
use crate::app::window::BurstscopeApp;
use crate::evaluate::{ChartOfStudy, Study};
use crate::requests::{JobError, JobId, StudyRequest};

/// What the workers were given.
#[derive(Default)]
pub(in crate::app) struct LabAsked {
    study: Option<(JobId, Study)>,
    chart: Option<ChartOfStudy>,
}

impl BurstscopeApp {
    /// Starts the study that is asked for; the one that runs is given up.
    pub(in crate::app) fn run_study(&mut self) {
        match self.model.lab_study() {
            Ok(study) => {
                let lab = &mut self.model.lab;
                (lab.problem, lab.current, lab.selected, lab.shown) = (None, None, None, None);
                let id = self.engine.lab.start(StudyRequest { study: study.clone(), open: self.model.burst.clone() });
                self.lab_asked.study = Some((id, study));
            }
            Err(problem) => self.model.lab.problem = Some(problem),
        }
    }

    /// Takes what the workers found.
    pub(in crate::app) fn take_lab_updates(&mut self) {
        let (newest, answers) = self.engine.lab.poll();
        let lab = &mut self.model.lab;
        if let (Some(report), Some((_, study))) = (newest, &self.lab_asked.study) {
            lab.current = Some(LabResult { study: study.clone(), report, is_whole: false });
        }
        for answer in answers {
            let asked = self.lab_asked.study.take_if(|(id, _)| *id == answer.id);
            match (answer.result, asked) {
                (Ok(report), Some((_, study))) => {
                    lab.current = Some(LabResult { study, report, is_whole: true });
                    self.model.messages.note("The study is finished");
                }
                (Err(JobError::Cancelled), Some(_)) => self.model.messages.note("The study was cancelled"),
                (Err(error), Some(_)) => lab.problem = Some(error.to_string()),
                (_, None) => {}
            }
        }
        for answer in self.engine.lab.poll_charts() {
            match answer.result {
                Ok(shown) => lab.shown = Some(shown),
                Err(JobError::Superseded | JobError::Cancelled) => {}
                Err(error) => lab.problem = Some(error.to_string()),
            }
        }
        lab.running = self
            .engine
            .lab
            .running()
            .map(|running| LabRunning { progress: running.progress, time_left: running.time_left() });
    }

    /// Asks for the chart that is to be looked at.
    pub(in crate::app) fn request_for_lab(&mut self) {
        let wanted = self.model.lab.wanted_chart();
        if self.model.lab.current_chart().is_some() || wanted.is_none() {
            return;
        }
        if self.lab_asked.chart != wanted
            && let Some(chart) = wanted
        {
            self.engine.lab.show(chart.clone());
            self.lab_asked.chart = Some(chart);
        }
    }

    /// Whether the chart that is wanted is there.
    pub(in crate::app) fn lab_is_settled(&self) -> bool {
        self.model.lab.wanted_chart().is_none()
            || self.model.lab.current_chart().is_some()
            || self.model.lab.problem.is_some()
    }
}
