//! Handling of the engine's answers about a dataset.

use crate::app::dataset::cut::CutDialog;
use crate::app::project::datasets::{Dataset, Work};
use crate::app::window::BurstscopeApp;
use crate::burst::OpenError;
use crate::engine::Ended;
use crate::inspect::words::counted;
use crate::requests::{BurstSource, DatasetAnswer, DatasetRequest, JobError, OpenDataset};

impl BurstscopeApp {
    pub(in crate::app) fn take_dataset_answer(&mut self, answer: Ended<DatasetRequest>) {
        let work = self.model.datasets.work.take();
        if let Some(dataset) = &mut self.model.datasets.open {
            dataset.stop();
        }
        if answer.result.is_err() {
            self.model.datasets.restoring = None;
        }
        let title = work.map_or("Dataset", Work::title);
        match answer.result {
            Ok(DatasetAnswer::Opened(open)) => {
                self.model.messages.resolved(title);
                self.take_dataset(*open);
            }
            Ok(DatasetAnswer::Detected) => self.say_what_was_found(answer.elapsed.as_secs_f64()),
            Ok(DatasetAnswer::Matched { left_out }) => self.say_what_matched(left_out, answer.elapsed.as_secs_f64()),
            #[cfg(feature = "colmap")]
            Ok(DatasetAnswer::Colmap(done)) => {
                self.say_what_was_exported(&done);
            }
            Err(JobError::Cancelled) => {
                self.model.messages.note(format!("{title}: cancelled; what is done stays done"));
            }
            Err(error) => self.model.messages.error(title, error.to_string()),
        }
        // The states told of the folder that was written; those of the dataset's own are looked at again.
        let own = self.model.datasets.open.as_ref().map(|d| (d.source.clone(), d.folder.clone()));
        if let Some((source, folder)) = own.filter(|_| work == Some(Work::Exporting)) {
            self.look_at_dataset(source, folder);
        }
    }

    fn take_dataset(&mut self, open: OpenDataset) {
        let same = self.model.datasets.open.as_ref().is_some_and(|d| d.bursts == open.bursts);
        match open.frames_of_one {
            // A lone burst of many files is a sequence that is yet to be cut.
            Some(frames) if frames > 1 && open.source.burst_length.is_none() => {
                self.overlays.cut = Some(CutDialog::new(open.source.paths, frames, self.burst_length()));
                return;
            }
            Some(1) if open.source.burst_length.is_none() => {
                self.open(BurstSource::Paths(open.source.paths));
                return;
            }
            _ => {}
        }
        let restoring = self.model.datasets.restoring.take();
        if let Some(error) = &open.folder_error {
            self.model.messages.error("Feature folder", error.clone());
        } else {
            self.model.messages.resolved("Feature folder");
        }
        if let Some(dataset) = self.model.datasets.open.as_mut().filter(|_| same) {
            dataset.look_again(open);
            dataset.restore_pair(restoring.unwrap_or_default());
            return;
        }
        if let [first, rest @ ..] = &open.strays[..] {
            let more = if rest.is_empty() { String::new() } else { format!(" (and {} more)", rest.len()) };
            let stray = OpenError::Stray { path: first.clone() };
            self.model.messages.error("Open dataset", format!("{stray}{more}"));
        }
        let mut dataset = Dataset::new(open);
        dataset.restore_pair(restoring.unwrap_or_default());
        let (count, done) = (dataset.bursts.len(), dataset.counts().done);
        self.model.messages.note(format!(
            "Opened {}: {}, {done} of them done",
            dataset.source.label(),
            counted(count, "burst")
        ));
        self.remember_dataset(&dataset.source);
        self.thumbnails.clear();
        let shown = dataset.place_of(self.model.slots.a.burst.as_ref());
        self.model.datasets.open = Some(dataset);
        self.model.panels.filmstrip = true;
        // A session opens its own burst.
        if shown.is_none() && restoring.is_none() {
            self.open_burst_at(0);
        }
    }

    fn say_what_was_found(&mut self, seconds: f64) {
        let Some(dataset) = &self.model.datasets.open else { return };
        let counts = dataset.counts();
        let mut text = format!(
            "{} done in {seconds:.1} s: {}",
            counted(counts.done, "burst"),
            counted(counts.features, "feature")
        );
        if counts.failed > 0 {
            text += &format!("; {} failed, see the filmstrip", counts.failed);
        }
        self.model.messages.note(text);
    }

    fn say_what_matched(&mut self, left_out: usize, seconds: f64) {
        let Some(dataset) = &self.model.datasets.open else { return };
        let mut text = format!("{} matched in {seconds:.1} s", counted(dataset.matches.len(), "pair"));
        if left_out > 0 {
            text += &format!("; {left_out} left out, whose bursts have no features yet");
        }
        self.model.messages.note(text);
    }
}
