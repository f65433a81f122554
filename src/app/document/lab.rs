//! The Lab: its questions with the settings of their studies.

use crate::app::{defaults::with_defaults, words::choices};
use crate::detector::{SearchParams, SlopeGrid};
use crate::evaluate::chart::FRAME_COUNTS;
use crate::evaluate::{AccuracyStudy, BurstFramesStudy, BurstMethod, ChartStudy, Searches};
use crate::recover::RecoverStudy;
use crate::study::{BurstsOfStudy, Study, StudyPoint, StudyReport};
use crate::synth::{ChartParams, NoisyParams};
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LabSet {
    #[default]
    Current,
    Kept(usize),
}

with_defaults! {
    /// Settings of the studies, and the choice among their results.
    #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
    pub struct Lab {
        pub question: LabQuestion,
        /// The charts; ratio and seed are those of the fields below.
        pub chart: ChartParams = ChartStudy::default().chart,
        pub snrs_text: String = "0.2, 0.35, 0.6".to_owned(),
        pub counts_text: String = FRAME_COUNTS.map(|count| count.to_string()).join(", "),
        pub seeds: u64 = ChartStudy::default().seeds,
        pub first_seed: u64 = ChartStudy::default().first_seed,
        pub methods: Vec<BurstMethod> = vec![BurstMethod::SiftFrame, BurstMethod::SiftMerge, BurstMethod::Buff1d],
        /// The ratio whose ROC curves are shown, as an index of the rows.
        pub roc_row: usize,
        pub hidden: BTreeSet<String>,
        pub selected: Option<(LabSet, StudyPoint)>,
        pub selected_chart: u64,
        /// Whether all that was detected on it is marked, not only what lies above the threshold of the curves.
        pub all_detected: bool,
        pub dark_copy: NoisyParams,
        pub planted: RecoverStudy = RecoverStudy { copies: 12, ..RecoverStudy::default() },
        /// The planted thing that is looked at: the seed of its copy, and its number in it.
        pub selected_thing: Option<(u64, usize)>,
    }
}

choices! {
    #[derive(Default)]
    LabQuestion {
        #[default]
        Dark: "Found in the dark",
        "ROC curves of the methods, the discs that each finds, and its false features, against the ratio of signal to noise";
        Frames: "Frames",
        "ROC curves of the methods, the discs that each finds, and its false features, against the number of frames of a burst";
        Accuracy: "Errors",
        "How far place, scale and slope of the discs found are from the truth, against the ratio of signal to noise";
        BurstFrames: "Frames of A",
        "What the middle frames of the open burst show, from two frames to all: features, features that all frames confirm, and matches with as many frames of B";
        InBurst: "In this burst",
        "Would it have been seen? Things of known SNR, slope and size are planted in copies of the open burst, and searched for as it is set: the share found, why the others were missed, and how faint a thing is seen at each place";
    }
}

impl LabQuestion {
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
        self == match report {
            StudyReport::Chart(report) if report.snr.is_some() => Self::Frames,
            StudyReport::Chart(_) => Self::Dark,
            StudyReport::Accuracy(_) => Self::Accuracy,
            StudyReport::BurstFrames(_) => Self::BurstFrames,
            StudyReport::Recover(_) => Self::InBurst,
        }
    }
}

impl Lab {
    pub fn snrs(&self) -> Result<Vec<f64>, String> {
        let mut snrs: Vec<f64> = Vec::new();
        for word in self.snrs_text.split(',').map(str::trim).filter(|word| !word.is_empty()) {
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
        let wrong = |word: &str| format!("'{word}' is no number of frames; give whole numbers, separated by commas");
        words.map(|word| word.parse().map_err(|_| wrong(word))).collect()
    }

    pub fn study(&self, search: &SearchParams, bursts: Option<&BurstsOfStudy>) -> Result<Study, String> {
        let given = search.slopes.given();
        Ok(match self.question {
            LabQuestion::Dark => Study::Chart(Box::new(self.charts(search, given)?)),
            LabQuestion::Frames => {
                let charts = self.charts(search, given)?;
                if charts.snrs.len() > 1 {
                    return Err("give one SNR; the number of frames is what changes".to_owned());
                }
                let frame_counts = self.frame_counts()?;
                if frame_counts.is_empty() {
                    return Err("no number of frames is given; give one or more, such as 2, 5, 10".to_owned());
                }
                Study::Chart(Box::new(ChartStudy { frame_counts, ..charts }))
            }
            LabQuestion::Accuracy => {
                let slopes = given.unwrap_or(AccuracyStudy::with_motion(self.chart.motion).detector.slopes);
                Study::Accuracy(Box::new(AccuracyStudy {
                    chart: self.chart.clone(),
                    snrs: self.snrs()?,
                    first_seed: self.first_seed,
                    seeds: self.seeds,
                    detector: search.at(slopes),
                }))
            }
            LabQuestion::BurstFrames => {
                let bursts = bursts.ok_or("open a burst first")?.clone();
                let mut frame_counts = self.frame_counts()?;
                frame_counts.retain(|count| (2..=bursts.burst.len()).contains(count));
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
        let chosen = |method: &BurstMethod| self.methods.contains(method);
        let methods: Vec<BurstMethod> = BurstMethod::ALL.into_iter().filter(chosen).collect();
        if methods.is_empty() {
            return Err("no method is chosen; choose one or more".to_owned());
        }
        let (chart, snrs, first_seed, seeds) = (self.chart.clone(), self.snrs()?, self.first_seed, self.seeds);
        let searches = Searches::of_charts(search.at(given.unwrap_or_default()), given);
        Ok(ChartStudy { chart, snrs, first_seed, seeds, methods, searches, ..ChartStudy::default() })
    }
}
