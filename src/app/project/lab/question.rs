//! Questions of the Lab, and the studies that answer them.

use super::Lab;
use crate::app::project::Model;
use crate::detector::{DetectorParams, SearchParams, SlopeChoice, SlopeGrid};
use crate::evaluate::{
    AccuracyStudy, BurstFramesStudy, BurstMethod, BurstsOfStudy, ChartStudy, FramesStudy, Study, StudyReport,
};

/// Question of a study.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum LabQuestion {
    /// Detections against the ratio of signal to noise.
    #[default]
    Dark,
    /// Detections against the number of frames.
    Frames,
    /// Errors of place, scale and slope.
    Accuracy,
    /// Features of the open burst with fewer of its frames.
    BurstFrames,
}

impl LabQuestion {
    /// All questions.
    pub const ALL: [Self; 4] = [Self::Dark, Self::Frames, Self::Accuracy, Self::BurstFrames];

    /// Label in the window.
    pub fn label(self) -> &'static str {
        match self {
            Self::Dark => "Found in the dark",
            Self::Frames => "Frames",
            Self::Accuracy => "Errors",
            Self::BurstFrames => "Frames of A",
        }
    }

    /// Explanation of the question.
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
            Self::Accuracy => {
                "How far place, scale and slope of the discs found are from the truth, against the ratio of signal to noise"
            }
        }
    }

    /// Whether the study uses synthetic charts.
    pub fn needs_charts(self) -> bool {
        self != Self::BurstFrames
    }

    /// Whether it compares methods.
    pub fn compares_methods(self) -> bool {
        matches!(self, Self::Dark | Self::Frames)
    }

    /// Whether the study takes numbers of frames.
    pub fn counts_frames(self) -> bool {
        matches!(self, Self::Frames | Self::BurstFrames)
    }

    /// Whether it answers with curves of the same plots as `report`.
    pub fn asks_for(self, report: &StudyReport) -> bool {
        matches!(
            (self, report),
            (Self::Dark, StudyReport::Chart(_))
                | (Self::Frames, StudyReport::Frames(_))
                | (Self::Accuracy, StudyReport::Accuracy(_))
                | (Self::BurstFrames, StudyReport::BurstFrames(_))
        )
    }
}

impl Lab {
    /// The ratios.
    ///
    /// # Errors
    /// When a word is not a positive number.
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
        if snrs.is_empty() {
            Err("no ratio is given; give one or more, such as 0.2, 0.35".to_owned())
        } else {
            Ok(snrs)
        }
    }

    /// The numbers of frames.
    ///
    /// # Errors
    /// When a word is not a whole number.
    pub fn frame_counts(&self) -> Result<Vec<usize>, String> {
        let words = self.counts_text.split(',').map(str::trim).filter(|word| !word.is_empty());
        let count = |word: &str| {
            word.parse()
                .map_err(|_| format!("'{word}' is no number of frames; give whole numbers, separated by commas"))
        };
        words.map(count).collect()
    }

    /// The study of the present question, with the detector's parameters in `search`, and the open bursts.
    ///
    /// # Errors
    /// When a setting is invalid; the message is a sentence that says why.
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
        })
    }

    fn charts(&self, search: &SearchParams, given: Option<SlopeGrid>) -> Result<ChartStudy, String> {
        let (slopes_1d, slopes_2d) = ChartStudy::slopes_for(given);
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
            detector: DetectorParams { slopes, ..search.detector.clone() },
            slopes_1d,
            slopes_2d,
            ..ChartStudy::default()
        })
    }
}

impl Model {
    /// The study that the Lab asks for now.
    ///
    /// # Errors
    /// When a setting is invalid; the message is a sentence that says why.
    pub fn lab_study(&self) -> Result<Study, String> {
        let bursts = self.slots.a.burst.as_ref().map(|open| BurstsOfStudy {
            burst: open.burst.clone(),
            second: self.slots.b.burst.as_ref().map(|second| second.burst.clone()),
            truth: None,
        });
        self.lab.study(&self.asked(), bursts.as_ref())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_asked_is_what_the_commands_ask_by_default() {
        let lab = Lab { methods: BurstMethod::WITH_GIVEN_SLOPES.to_vec(), ..Lab::default() };
        let study = lab.study(&SearchParams::default(), None).expect("sound");
        assert_eq!(study, Study::Chart(Box::default()));
        let given = SearchParams { slopes: SlopeChoice::Given, ..SearchParams::default() };
        let Study::Chart(study) = lab.study(&given, None).expect("sound") else { panic!("a study of charts") };
        assert_eq!(study.slopes_1d, given.detector.slopes);
    }

    #[test]
    fn the_number_of_frames_needs_one_ratio_and_whole_numbers() {
        let with = |snrs: &str, counts: &str| {
            let question = LabQuestion::Frames;
            let (snrs_text, counts_text) = (snrs.to_owned(), counts.to_owned());
            Lab { question, snrs_text, counts_text, ..Lab::default() }.study(&SearchParams::default(), None)
        };
        let Ok(Study::Frames(study)) = with("0.6", "2, 10") else { panic!("a study of frames") };
        assert_eq!((study.frame_counts, study.charts.snrs), (vec![2, 10], vec![0.6]));
        assert!(with("0.6, 1", "2").expect_err("two ratios").contains("one SNR"));
        assert!(with("0.6", "2, ten").expect_err("a word").contains("'ten'"));
        let lab = Lab { question: LabQuestion::BurstFrames, ..Lab::default() };
        assert!(lab.study(&SearchParams::default(), None).expect_err("no burst").contains("open a burst"));
    }

    #[test]
    fn ratios_are_read_as_they_are_typed() {
        let read = |text: &str| Lab { snrs_text: text.to_owned(), ..Lab::default() }.snrs();
        assert_eq!(read(" 0.2,0.35 , 0.2,"), Ok(vec![0.2, 0.35]));
        for (text, says) in [("0.2; 1", "'0.2; 1'"), ("-1", "'-1'"), ("NaN", "'NaN'"), (" ,", "no ratio")] {
            assert!(read(text).expect_err(text).contains(says), "{text}");
        }
    }
}
