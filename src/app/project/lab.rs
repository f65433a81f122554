//! The Lab: its questions with the settings of their studies, and the studies that answer them: the curves so far, and
//! the chart on show.

use crate::app::project::side::Side;
use crate::app::project::workspace::Workspace;
use crate::app::project::{Effect, Model};
use crate::detector::{DetectorParams, SearchParams, SlopeChoice, SlopeGrid};
use crate::engine::{Ended, Engine, Wanted};
use crate::evaluate::frames::FRAME_COUNTS;
use crate::evaluate::{AccuracyStudy, BurstFramesStudy, BurstMethod, ChartStudy, FramesStudy, Searches};
use crate::recover::{Planted, RecoverReport, RecoverStudy};
use crate::requests::{BurstSource, JobError, StudyRequest};
use crate::study::{BurstsOfStudy, ChartOfStudy, ShownChart, Study, StudyPoint, StudyReport};
use crate::synth::{ChartParams, NoisyParams};
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;

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

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LabSet {
    #[default]
    Current,
    Kept(usize),
}

/// Settings of the studies, and the choice among their results.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Lab {
    pub question: LabQuestion,
    /// The charts; ratio and seed are those of the fields below.
    pub chart: ChartParams,
    pub snrs_text: String,
    pub counts_text: String,
    pub seeds: u64,
    pub first_seed: u64,
    pub methods: Vec<BurstMethod>,
    /// The ratio whose ROC curves are shown, as an index of the rows.
    pub roc_row: usize,
    pub hidden: BTreeSet<String>,
    pub selected: Option<(LabSet, StudyPoint)>,
    pub selected_chart: u64,
    /// Whether all that was detected on it is marked, not only what lies above the threshold of the curves.
    pub all_detected: bool,
    pub dark_copy: NoisyParams,
    pub planted: RecoverStudy,
    /// The planted thing that is looked at: the seed of its copy, and its number in it.
    pub selected_thing: Option<(u64, usize)>,
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

impl Default for Lab {
    fn default() -> Self {
        let study = ChartStudy::default();
        Self {
            question: LabQuestion::default(),
            chart: study.chart,
            snrs_text: "0.2, 0.35, 0.6".to_owned(),
            counts_text: FRAME_COUNTS.map(|count| count.to_string()).join(", "),
            seeds: study.seeds,
            first_seed: study.first_seed,
            methods: vec![BurstMethod::SiftFrame, BurstMethod::SiftMerge, BurstMethod::Buff1d],
            roc_row: 0,
            hidden: BTreeSet::new(),
            selected: None,
            selected_chart: 0,
            all_detected: false,
            dark_copy: NoisyParams::default(),
            planted: RecoverStudy { copies: 12, ..RecoverStudy::default() },
            selected_thing: None,
        }
    }
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
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LabQuestion {
    #[default]
    Dark,
    Frames,
    Accuracy,
    BurstFrames,
    InBurst,
}

impl LabQuestion {
    pub const ALL: [Self; 5] = [Self::Dark, Self::Frames, Self::Accuracy, Self::BurstFrames, Self::InBurst];

    pub fn label(self) -> &'static str {
        match self {
            Self::Dark => "Found in the dark",
            Self::Frames => "Frames",
            Self::Accuracy => "Errors",
            Self::BurstFrames => "Frames of A",
            Self::InBurst => "In this burst",
        }
    }

    pub fn help(self) -> &'static str {
        match self {
            Self::Dark => {
                "ROC curves of the methods, the discs that each finds, and its false features, against the ratio of signal to noise"
            }
            Self::Frames => {
                "ROC curves of the methods, the discs that each finds, and its false features, against the number of frames of a burst"
            }
            Self::BurstFrames => {
                "What the middle frames of the open burst show, from two frames to all: features, those that all frames confirm, and the matches with as many frames of B"
            }
            Self::InBurst => {
                "Would it have been seen? Things of known SNR, slope and size are planted in copies of the open burst, and searched for as it is set: the share found, why the others were missed, and how faint a thing is seen at each place"
            }
            Self::Accuracy => {
                "How far place, scale and slope of the discs found are from the truth, against the ratio of signal to noise"
            }
        }
    }

    pub fn needs_charts(self) -> bool {
        !matches!(self, Self::BurstFrames | Self::InBurst)
    }

    pub fn compares_methods(self) -> bool {
        matches!(self, Self::Dark | Self::Frames)
    }

    pub fn counts_frames(self) -> bool {
        matches!(self, Self::Frames | Self::BurstFrames)
    }

    pub fn asks_for(self, report: &StudyReport) -> bool {
        matches!(
            (self, report),
            (Self::Dark, StudyReport::Chart(_))
                | (Self::Frames, StudyReport::Frames(_))
                | (Self::Accuracy, StudyReport::Accuracy(_))
                | (Self::BurstFrames, StudyReport::BurstFrames(_))
                | (Self::InBurst, StudyReport::Recover(_))
        )
    }
}

impl Lab {
    pub fn snrs(&self) -> Result<Vec<f64>, String> {
        let words = self.snrs_text.split(',').map(str::trim).filter(|word| !word.is_empty());
        let mut snrs: Vec<f64> = Vec::new();
        for word in words {
            let snr = word.parse().ok().filter(|snr: &f64| *snr > 0.0);
            let snr = snr.ok_or_else(|| format!("'{word}' is no ratio; give numbers above 0, separated by commas"))?;
            if !snrs.contains(&snr) {
                snrs.push(snr);
            }
        }
        let none = "no ratio is given; give one or more, such as 0.2, 0.35";
        if snrs.is_empty() { Err(none.to_owned()) } else { Ok(snrs) }
    }

    pub fn frame_counts(&self) -> Result<Vec<usize>, String> {
        let words = self.counts_text.split(',').map(str::trim).filter(|word| !word.is_empty());
        let count = |word: &str| {
            word.parse()
                .map_err(|_| format!("'{word}' is no number of frames; give whole numbers, separated by commas"))
        };
        words.map(count).collect()
    }

    pub fn study(&self, search: &SearchParams, bursts: Option<&BurstsOfStudy>) -> Result<Study, String> {
        let given = (search.slopes == SlopeChoice::Given).then_some(search.detector.slopes);
        Ok(match self.question {
            LabQuestion::Dark => Study::Chart(Box::new(self.charts(search, given)?)),
            LabQuestion::Frames => {
                let charts = self.charts(search, given)?;
                if charts.snrs.len() > 1 {
                    return Err("give one SNR; the number of frames is what changes".to_owned());
                }
                Study::Frames(Box::new(FramesStudy { charts, frame_counts: self.frame_counts()? }))
            }
            LabQuestion::Accuracy => {
                let slopes = given.unwrap_or(AccuracyStudy::with_motion(self.chart.motion).detector.slopes);
                Study::Accuracy(Box::new(AccuracyStudy {
                    chart: self.chart.clone(),
                    snrs: self.snrs()?,
                    first_seed: self.first_seed,
                    seeds: self.seeds,
                    detector: DetectorParams { slopes, ..search.detector.clone() },
                }))
            }
            LabQuestion::BurstFrames => {
                let bursts = bursts.ok_or("open a burst first")?.clone();
                let all = bursts.burst.len();
                let mut frame_counts = self.frame_counts()?;
                frame_counts.retain(|count| (2..=all).contains(count));
                let study = BurstFramesStudy { search: search.clone(), frame_counts, ..BurstFramesStudy::default() };
                Study::BurstFrames(Box::new(study), bursts)
            }
            LabQuestion::InBurst => {
                let bursts = bursts.ok_or("open a burst first")?.clone();
                Study::Recover(Box::new(RecoverStudy { search: search.clone(), ..self.planted.clone() }), bursts)
            }
        })
    }

    fn charts(&self, search: &SearchParams, given: Option<SlopeGrid>) -> Result<ChartStudy, String> {
        let slopes = given.unwrap_or(DetectorParams::default().slopes);
        let chosen = |method: &BurstMethod| self.methods.contains(method);
        let methods: Vec<BurstMethod> = BurstMethod::ALL.into_iter().filter(chosen).collect();
        if methods.is_empty() {
            return Err("no method is chosen; choose one or more".to_owned());
        }
        Ok(ChartStudy {
            chart: self.chart.clone(),
            snrs: self.snrs()?,
            first_seed: self.first_seed,
            seeds: self.seeds,
            methods,
            searches: Searches::of_charts(DetectorParams { slopes, ..search.detector.clone() }, given),
            ..ChartStudy::default()
        })
    }
}

impl Model {
    pub fn lab_study(&self) -> Result<Study, String> {
        let bursts = self.results.slots.a.burst.as_ref().map(|open| BurstsOfStudy {
            burst: open.burst.clone(),
            second: self.results.slots.b.burst.as_ref().map(|second| second.burst.clone()),
            truth: None,
        });
        self.document.lab.study(&self.asked(), bursts.as_ref())
    }
}
