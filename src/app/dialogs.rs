//! Asking for files: the system's dialogs, and a field to type a path into where the system has none.
//!
//! The system's dialogs wait for a person, so they run on a thread of their own. They are behind [`FileDialogs`], so
//! that tests can answer for the person. On a Linux desktop without a portal the system's dialog answers "nothing
//! chosen" at once; nobody cancels that quickly, so then the path field opens instead.

use crate::app::project::pair::Side;
use crate::engine::OnUpdate;
use std::path::PathBuf;
use std::sync::{Arc, mpsc};
use std::time::{Duration, Instant};

/// What a file is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    /// A folder of frames.
    OpenFolder,
    /// Image files.
    OpenFiles,
    /// A folder of bursts, or a long sequence.
    OpenDataset,
    /// A folder that keeps a dataset's features.
    FeatureFolder,
    /// A folder for what COLMAP's mapper takes.
    ExportDatabase,
    /// An estimated trajectory.
    OpenEstimate,
    /// A true trajectory.
    OpenTruth,
    /// Any path of a burst, typed.
    OpenPath,
    /// A folder of frames, for the second burst.
    OpenFolderB,
    /// Image files, for the second burst.
    OpenFilesB,
    /// Any path of a burst, typed, for the second burst.
    OpenPathB,
    /// A sharp image of the view of a side: its gold standard.
    OpenGold(Side),
    /// Somebody else's features.
    OpenFeatures,
    /// A session file to restore.
    RestoreSession,
    /// A session file to write.
    SaveSession,
    /// A parameter file to read.
    LoadParams,
    /// A parameter file to write.
    SaveParams,
    /// A file to export to.
    Export(ExportKind),
}

/// What is exported.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ExportKind {
    /// Features as CSV.
    Csv,
    /// Features as COLMAP's text.
    Colmap,
    /// Features as NumPy arrays.
    Npz,
    /// The picture's values.
    Tiff,
    /// The picture as shown.
    Png,
    /// The panes with everything over them, as vectors.
    Svg,
    /// The matches as CSV.
    Matches,
    /// Both pictures with the matches between them.
    MatchPicture,
    /// The values along the line.
    Profile,
    /// The panes with everything over them, as pixels.
    FigurePng,
}

impl ExportKind {
    /// Its file name extension.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Csv | Self::Matches | Self::Profile => "csv",
            Self::Colmap => "txt",
            Self::Npz => "npz",
            Self::Tiff => "tiff",
            Self::Png | Self::MatchPicture | Self::FigurePng => "png",
            Self::Svg => "svg",
        }
    }

    /// What it is called in messages.
    pub fn label(self) -> &'static str {
        match self {
            Self::Csv => "Export features as CSV",
            Self::Colmap => "Export features for COLMAP",
            Self::Npz => "Export features as NPZ",
            Self::Tiff => "Export picture as TIFF",
            Self::Png => "Export picture as PNG",
            Self::Svg => "Export figure as SVG",
            Self::Matches => "Export matches as CSV",
            Self::MatchPicture => "Export match picture as PNG",
            Self::Profile => "Export line profile as CSV",
            Self::FigurePng => "Export figure as PNG",
        }
    }
}

impl Purpose {
    /// The dialog's title.
    pub fn title(self) -> &'static str {
        match self {
            Self::OpenFolder => "Open a folder of frames",
            Self::OpenFiles => "Open image files",
            Self::OpenDataset => "Open a folder of bursts, or a long sequence",
            Self::FeatureFolder => "Choose a folder for the dataset's features",
            Self::ExportDatabase => "Choose a folder for COLMAP's database",
            Self::OpenEstimate => "Open an estimated trajectory",
            Self::OpenTruth => "Open a true trajectory",
            Self::OpenPath => "Open a path",
            Self::OpenFolderB => "Open a folder of frames as B",
            Self::OpenFilesB => "Open image files as B",
            Self::OpenPathB => "Open a path as B",
            Self::OpenGold(Side::A) => "Open the gold standard of A",
            Self::OpenGold(Side::B) => "Open the gold standard of B",
            Self::OpenFeatures => "Open features",
            Self::RestoreSession => "Open a session",
            Self::SaveSession => "Save the session",
            Self::LoadParams => "Load parameters",
            Self::SaveParams => "Save parameters",
            Self::Export(kind) => kind.label(),
        }
    }

    /// Whether a file is to be written.
    pub fn saves(self) -> bool {
        matches!(self, Self::SaveSession | Self::SaveParams | Self::Export(_))
    }

    /// What the path field says about itself.
    pub fn hint(self) -> &'static str {
        match self {
            Self::OpenFolder
            | Self::OpenFiles
            | Self::OpenPath
            | Self::OpenFolderB
            | Self::OpenFilesB
            | Self::OpenPathB
            | Self::OpenGold(_) => "A folder of frames, an image, a multi-page TIFF or a .npy stack",
            Self::OpenDataset => "A folder of bursts (each a folder of frames), or one long sequence of frames",
            Self::OpenEstimate | Self::OpenTruth => {
                "A sparse model (its folder, or a file of it), or a file of lines: timestamp tx ty tz qx qy qz qw"
            }
            Self::ExportDatabase => {
                "A new or an empty folder, or one that was written so before: its features are not found again"
            }
            Self::FeatureFolder => "A new or an empty folder, or one that burstscope colmap wrote",
            Self::OpenFeatures => "A table of features (CSV), or the text that COLMAP imports",
            Self::RestoreSession | Self::SaveSession => "A session file, such as night.burstscope.toml",
            Self::LoadParams | Self::SaveParams => "A parameter file, such as params.toml",
            Self::Export(_) => "The file to write",
        }
    }

    /// The extensions that the dialog offers; empty for all files.
    pub fn extensions(self) -> Vec<&'static str> {
        match self {
            Self::OpenFolder
            | Self::OpenDataset
            | Self::FeatureFolder
            | Self::ExportDatabase
            | Self::OpenEstimate
            | Self::OpenTruth
            | Self::OpenPath
            | Self::OpenFolderB
            | Self::OpenPathB => Vec::new(),
            Self::OpenFiles | Self::OpenFilesB | Self::OpenGold(_) => crate::burst::supported_extensions().to_vec(),
            Self::RestoreSession | Self::SaveSession | Self::LoadParams | Self::SaveParams => vec!["toml"],
            Self::OpenFeatures => vec!["csv", "txt"],
            Self::Export(kind) => vec![kind.extension()],
        }
    }
}

/// A question for files.
#[derive(Debug, Clone)]
pub struct Question {
    /// What for.
    pub purpose: Purpose,
    /// The name that a new file gets unless another is given.
    pub suggested_name: String,
    /// Where the dialog starts.
    pub folder: Option<PathBuf>,
}

/// Something that asks a person for files. It waits for the answer; `None` means that nothing was chosen.
pub trait FileDialogs: Send + Sync {
    /// Asks, and waits for the answer.
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
            | Purpose::OpenDataset
            | Purpose::FeatureFolder
            | Purpose::ExportDatabase => dialog.pick_folder().map(|p| vec![p]),
            Purpose::OpenFiles | Purpose::OpenFilesB => dialog.pick_files(),
            purpose if purpose.saves() => dialog.set_file_name(&question.suggested_name).save_file().map(|p| vec![p]),
            _ => dialog.pick_file().map(|p| vec![p]),
        }
    }
}

/// What came of a question.
#[derive(Debug, Clone)]
pub enum FileAnswer {
    /// Files were chosen.
    Chosen(Purpose, Vec<PathBuf>),
    /// The person chose nothing.
    Nothing,
    /// The system showed no dialog.
    NoDialog(Question),
}

/// A dialog that answers "nothing" within this time was never shown.
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
    /// A desk that asks with `dialogs` and calls `on_update` when there is an answer.
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
                let answer = match dialogs.ask(&question) {
                    Some(paths) if !paths.is_empty() => FileAnswer::Chosen(question.purpose, paths),
                    _ if asked.elapsed() < TOO_QUICK_FOR_A_PERSON => FileAnswer::NoDialog(question),
                    _ => FileAnswer::Nothing,
                };
                // The window may be gone by now; then nobody wants the answer.
                let _ = sender.send(answer);
                on_update();
            })
            .expect("the system can start a handful of threads");
    }

    /// Answers that came since the last call.
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

/// The field to type a path into.
#[derive(Debug, Clone)]
pub struct PathField {
    /// What for.
    pub purpose: Purpose,
    /// What was typed.
    pub text: String,
    /// Whether it stands in for a dialog that the system does not have.
    pub instead_of_dialog: bool,
    fresh: bool,
}

impl PathField {
    /// An open field that holds `text`.
    pub fn new(purpose: Purpose, text: String, instead_of_dialog: bool) -> Self {
        Self { purpose, text, instead_of_dialog, fresh: true }
    }

    /// Draws it. Answers the path when it was accepted, and whether it is to stay open.
    pub fn ui(&mut self, ctx: &egui::Context) -> (Option<PathBuf>, bool) {
        let mut accepted = None;
        let modal = egui::Modal::new(egui::Id::unique("path field")).show(ctx, |ui| {
            ui.set_width(480.0);
            ui.heading(self.purpose.title());
            if self.instead_of_dialog {
                ui.weak("This system shows no file dialog, so please type the path.");
            }
            ui.add_space(4.0);
            let edit = ui.add(
                egui::TextEdit::singleline(&mut self.text).hint_text(self.purpose.hint()).desired_width(f32::INFINITY),
            );
            crate::app::panel::widgets::name_field(&edit, "Path", &self.text);
            if std::mem::take(&mut self.fresh) {
                edit.request_focus();
                select_stem(ctx, edit.id, &self.text);
            }
            if let Some(folder) = self.purpose.saves().then(|| new_folder(&path_from_text(&self.text))).flatten() {
                ui.weak(format!("The folder {} will be made.", folder.display()));
            }
            ui.add_space(6.0);
            let entered = edit.lost_focus() && ui.input(|i| i.key_pressed(egui::Key::Enter));
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                let verb = if self.purpose.saves() { "Save" } else { "Open" };
                let ready = !self.text.trim().is_empty();
                if (ui.add_enabled(ready, egui::Button::new(verb)).clicked() || entered) && ready {
                    accepted = Some(path_from_text(&self.text));
                }
                if ui.button("Cancel").clicked() {
                    ui.close();
                }
            });
        });
        let stay = accepted.is_none() && !modal.should_close();
        (accepted, stay)
    }
}

/// Selects the name without its extension, so that typing gives another one and the kind of file stays.
fn select_stem(ctx: &egui::Context, id: egui::Id, text: &str) {
    let letters = |part: &str| part.chars().count();
    let name = text.rfind('/').map_or(0, |slash| slash + 1);
    // What has two extensions keeps both.
    let end = text[name..].find('.').filter(|dot| *dot > 0).map_or(text.len(), |dot| name + dot);
    let mut state = egui::TextEdit::load_state(ctx, id).unwrap_or_default();
    let at = |place: usize| egui::text::CCursor::new(letters(&text[..place]));
    state.cursor.set_char_range(Some(egui::text::CCursorRange::two(at(name), at(end))));
    egui::TextEdit::store_state(ctx, id, state);
}

/// The folder that has to be made for a file at `path`; `None` where it is there.
fn new_folder(path: &std::path::Path) -> Option<PathBuf> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty())?;
    (!folder.exists()).then(|| folder.to_path_buf())
}

/// The path that a person typed or pasted: without blanks around it, quotes, or a `file://` in front; `~` is the home
/// folder.
pub fn path_from_text(text: &str) -> PathBuf {
    let text = text.trim();
    let unquoted = ['"', '\''].iter().find_map(|q| text.strip_prefix(*q)?.strip_suffix(*q)).unwrap_or(text);
    let plain = unquoted.strip_prefix("file://").unwrap_or(unquoted);
    match (plain.strip_prefix("~/"), std::env::home_dir()) {
        (Some(rest), Some(home)) => home.join(rest),
        _ => PathBuf::from(plain),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pasted_paths_are_understood() {
        assert_eq!(path_from_text("  /data/night "), PathBuf::from("/data/night"));
        assert_eq!(path_from_text("'/data/a b.tiff'"), PathBuf::from("/data/a b.tiff"));
        assert_eq!(path_from_text("\"/data/x\""), PathBuf::from("/data/x"));
        assert_eq!(path_from_text("file:///data/x.npy"), PathBuf::from("/data/x.npy"));
        if let Some(home) = std::env::home_dir() {
            assert_eq!(path_from_text("~/bursts"), home.join("bursts"));
        }
    }

    #[test]
    fn a_folder_that_is_to_be_made_is_known_before() {
        let home = tempfile::tempdir().expect("a folder");
        assert_eq!(new_folder(&home.path().join("a.csv")), None);
        assert_eq!(new_folder(&home.path().join("new/a.csv")), Some(home.path().join("new")));
        assert_eq!(new_folder(std::path::Path::new("a.csv")), None);
    }

    struct Answers(Option<Vec<PathBuf>>);

    impl FileDialogs for Answers {
        fn ask(&self, _: &Question) -> Option<Vec<PathBuf>> {
            self.0.clone()
        }
    }

    fn answer_of(dialogs: Answers) -> FileAnswer {
        let mut desk = Desk::new(Arc::new(dialogs), Arc::new(|| {}));
        desk.ask(Question { purpose: Purpose::OpenFolder, suggested_name: String::new(), folder: None });
        assert!(desk.is_asking());
        let end = Instant::now() + Duration::from_secs(10);
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
        assert!(matches!(answer_of(Answers(None)), FileAnswer::NoDialog(_)));
        let chosen = answer_of(Answers(Some(vec!["/x".into()])));
        assert!(matches!(chosen, FileAnswer::Chosen(Purpose::OpenFolder, paths) if paths == [PathBuf::from("/x")]));
    }
}
