//! File questions: the system's dialogs, and a path field where the system has none.
//!
//! The system's dialogs wait for a person, so they run on a thread of their own. They are behind [`FileDialogs`], so
//! that tests can answer for the person. On a Linux desktop without a portal the system's dialog returns "nothing
//! chosen" at once, faster than a person can cancel; the path field opens then.

mod path_field;

pub use path_field::{PathField, ReplaceFile, path_from_text};

use crate::app::project::effect::Purpose;
use crate::engine::OnUpdate;
use std::path::PathBuf;
use std::sync::{Arc, mpsc};
use std::time::{Duration, Instant};

/// Question for files.
#[derive(Debug, Clone)]
pub struct Question {
    /// Purpose of the files.
    pub purpose: Purpose,
    /// Suggested name of a new file, or path of a folder that is written; empty for none.
    pub suggested_name: String,
    /// Folder in which the dialog starts.
    pub folder: Option<PathBuf>,
}

/// Source of answers to file questions. It waits for the answer; `None` means that nothing was chosen.
pub trait FileDialogs: Send + Sync {
    /// Asks the question, and waits for the answer.
    fn ask(&self, question: &Question) -> Option<Vec<PathBuf>>;
}

/// The system's dialogs.
#[derive(Debug, Default, Clone, Copy)]
pub struct SystemDialogs;

impl FileDialogs for SystemDialogs {
    fn ask(&self, question: &Question) -> Option<Vec<PathBuf>> {
        let mut dialog = rfd::FileDialog::new().set_title(question.purpose.title());
        if let Some(folder) = &question.folder {
            dialog = dialog.set_directory(folder);
        }
        let extensions = question.purpose.extensions();
        if !extensions.is_empty() {
            dialog = dialog.add_filter(question.purpose.title(), &extensions).add_filter("All files", &["*"]);
        }
        match question.purpose {
            Purpose::OpenFolder
            | Purpose::OpenFolderB
            | Purpose::OpenLessons
            | Purpose::OpenDataset
            | Purpose::FeatureFolder
            | Purpose::PaperFigures
            | Purpose::ExportDatabase => dialog.pick_folder().map(|p| vec![p]),
            Purpose::OpenFiles | Purpose::OpenFilesB => dialog.pick_files(),
            purpose if purpose.saves() => dialog.set_file_name(&question.suggested_name).save_file().map(|p| vec![p]),
            _ => dialog.pick_file().map(|p| vec![p]),
        }
    }
}

/// Answer to a question.
#[derive(Debug, Clone)]
pub enum FileAnswer {
    /// Files were chosen.
    Chosen(Purpose, Vec<PathBuf>),
    /// The person chose nothing.
    Nothing,
    /// The system showed no dialog.
    NoDialog(Question),
}

/// Minimum time a person needs to cancel: a dialog that returns "nothing" sooner was never shown.
const TOO_QUICK_FOR_A_PERSON: Duration = Duration::from_millis(350);

/// Asks questions on threads of their own and collects the answers.
pub struct Desk {
    dialogs: Arc<dyn FileDialogs>,
    sender: mpsc::Sender<FileAnswer>,
    receiver: mpsc::Receiver<FileAnswer>,
    on_update: OnUpdate,
    open: usize,
}

impl Desk {
    /// Creates a desk that asks with `dialogs` and calls `on_update` when there is an answer.
    pub fn new(dialogs: Arc<dyn FileDialogs>, on_update: OnUpdate) -> Self {
        let (sender, receiver) = mpsc::channel();
        Self { dialogs, sender, receiver, on_update, open: 0 }
    }

    /// Asks a question, unless one is open already.
    pub fn ask(&mut self, question: Question) {
        if self.open > 0 {
            return;
        }
        self.open += 1;
        let (dialogs, sender, on_update) = (self.dialogs.clone(), self.sender.clone(), self.on_update.clone());
        std::thread::Builder::new()
            .name("burstscope-dialog".to_owned())
            .spawn(move || {
                let asked = Instant::now();
                let paths = dialogs.ask(&question);
                let answer = answer(question, paths, asked.elapsed());
                // When the window is closed already, the answer is dropped.
                let _ = sender.send(answer);
                on_update();
            })
            .expect("the system can start a handful of threads");
    }

    /// Returns the answers received since the last call.
    pub fn take_answers(&mut self) -> Vec<FileAnswer> {
        let answers: Vec<FileAnswer> = self.receiver.try_iter().collect();
        self.open -= answers.len();
        answers
    }

    /// Whether a question is open.
    pub fn is_asking(&self) -> bool {
        self.open > 0
    }
}

/// Interprets `paths`, which the system's dialog returned `after` this time.
fn answer(question: Question, paths: Option<Vec<PathBuf>>, after: Duration) -> FileAnswer {
    match paths {
        Some(paths) if !paths.is_empty() => FileAnswer::Chosen(question.purpose, paths),
        _ if after < TOO_QUICK_FOR_A_PERSON => FileAnswer::NoDialog(question),
        _ => FileAnswer::Nothing,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Chooses(&'static str);

    impl FileDialogs for Chooses {
        fn ask(&self, _: &Question) -> Option<Vec<PathBuf>> {
            Some(vec![self.0.into()])
        }
    }

    fn question() -> Question {
        Question { purpose: Purpose::OpenFolder, suggested_name: String::new(), folder: None }
    }

    fn answer_of(dialogs: Chooses) -> FileAnswer {
        let mut desk = Desk::new(Arc::new(dialogs), Arc::new(|| {}));
        desk.ask(question());
        assert!(desk.is_asking());
        let end = Instant::now() + Duration::from_secs(120);
        loop {
            if let Some(answer) = desk.take_answers().pop() {
                assert!(!desk.is_asking());
                return answer;
            }
            assert!(Instant::now() < end, "no answer");
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    #[test]
    fn an_instant_nothing_means_that_there_was_no_dialog() {
        let nothing = |paths, millis| answer(question(), paths, Duration::from_millis(millis));
        for paths in [None, Some(Vec::new())] {
            assert!(matches!(nothing(paths.clone(), 5), FileAnswer::NoDialog(_)));
            assert!(matches!(nothing(paths, 900), FileAnswer::Nothing));
        }
    }

    #[test]
    fn what_was_chosen_is_answered() {
        let chosen = answer_of(Chooses("/x"));
        assert!(matches!(chosen, FileAnswer::Chosen(Purpose::OpenFolder, paths) if paths == [PathBuf::from("/x")]));
    }
}
