//! File questions: the system's dialogs, on threads of their own, and a path field where the system has none. A free
//! desktop shows dialogs through its portal, or through the program `zenity`. A dialog that returns nothing was
//! cancelled or has failed, which cannot be told apart: both are said.

mod path_field;
mod shape;

pub use path_field::{PathField, ReplaceFile, path_from_text};
pub use shape::ShapeDialog;

use crate::app::document::Purpose;
use crate::engine::OnUpdate;
use std::path::PathBuf;
use std::sync::{Arc, mpsc};

#[derive(Debug, Clone)]
pub struct Question {
    pub purpose: Purpose,
    /// Suggested name of a new file, or path of a folder that is written; empty for none.
    pub suggested_name: String,
    pub folder: Option<PathBuf>,
}

pub trait FileDialogs: Send + Sync {
    /// Whether there are dialogs at all. May wait for the system.
    fn exist(&self) -> bool;

    fn ask(&self, question: &Question) -> Option<Vec<PathBuf>>;
}

#[derive(Debug, Default, Clone, Copy)]
pub struct SystemDialogs;

impl FileDialogs for SystemDialogs {
    #[cfg(all(unix, not(target_os = "macos")))]
    fn exist(&self) -> bool {
        free_desktop::shows_dialogs(zbus::connection::Builder::session(), std::env::var_os("PATH").as_deref())
    }

    #[cfg(not(all(unix, not(target_os = "macos"))))]
    fn exist(&self) -> bool {
        true
    }

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
            Purpose::OpenFolder(_)
            | Purpose::OpenLessons
            | Purpose::OpenMasks
            | Purpose::OpenDataset
            | Purpose::FeatureFolder
            | Purpose::PaperFigures
            | Purpose::ExportDatabase => dialog.pick_folder().map(|p| vec![p]),
            Purpose::OpenFiles(_) => dialog.pick_files(),
            purpose if purpose.saves() => dialog.set_file_name(&question.suggested_name).save_file().map(|p| vec![p]),
            _ => dialog.pick_file().map(|p| vec![p]),
        }
    }
}

#[cfg(all(unix, not(target_os = "macos")))]
pub mod free_desktop {
    use std::ffi::OsStr;
    use std::os::unix::fs::PermissionsExt;
    use std::time::Duration;

    /// Time in which a portal answers: the bus itself waits as long for a service that it starts.
    const PATIENCE: Duration = Duration::from_secs(25);

    /// Whether the portal on `bus`, that of the session, has a file chooser, or a folder of `search_path` has `zenity`.
    pub fn shows_dialogs(bus: zbus::Result<zbus::connection::Builder<'_>>, search_path: Option<&OsStr>) -> bool {
        let has_zenity = |path| std::env::split_paths(path).any(|folder| is_program(&folder.join("zenity")));
        pollster::block_on(portal_chooses_files(bus)).is_ok() || search_path.is_some_and(has_zenity)
    }

    /// Asks the portal for the version of its file chooser. A portal without a desktop behind it has none.
    async fn portal_chooses_files(session_bus: zbus::Result<zbus::connection::Builder<'_>>) -> zbus::Result<()> {
        let bus = session_bus?.method_timeout(PATIENCE).build().await?;
        let (portal, object) = ("org.freedesktop.portal.Desktop", "/org/freedesktop/portal/desktop");
        let property = ("org.freedesktop.portal.FileChooser", "version");
        bus.call_method(Some(portal), object, Some("org.freedesktop.DBus.Properties"), "Get", &property).await?;
        Ok(())
    }

    fn is_program(path: &std::path::Path) -> bool {
        path.metadata().is_ok_and(|file| file.is_file() && file.permissions().mode() & 0o111 != 0)
    }
}

#[derive(Debug, Clone)]
pub enum FileAnswer {
    Chosen(Purpose, Vec<PathBuf>),
    Nothing(Question),
    NoDialog(Question),
}

pub struct FileChooser {
    dialogs: Arc<dyn FileDialogs>,
    sender: mpsc::Sender<FileAnswer>,
    receiver: mpsc::Receiver<FileAnswer>,
    on_update: OnUpdate,
    open: usize,
}

impl FileChooser {
    pub fn new(dialogs: Arc<dyn FileDialogs>, on_update: OnUpdate) -> Self {
        let (sender, receiver) = mpsc::channel();
        Self { dialogs, sender, receiver, on_update, open: 0 }
    }

    /// Returns the question when an earlier one is not answered yet.
    pub fn ask(&mut self, question: Question) -> Result<(), Question> {
        if self.open > 0 {
            return Err(question);
        }
        self.open += 1;
        let (dialogs, sender, on_update) = (self.dialogs.clone(), self.sender.clone(), self.on_update.clone());
        std::thread::Builder::new()
            .name("burstscope-dialog".to_owned())
            .spawn(move || {
                let answer = match dialogs.exist().then(|| dialogs.ask(&question)) {
                    None => FileAnswer::NoDialog(question),
                    Some(Some(paths)) if !paths.is_empty() => FileAnswer::Chosen(question.purpose, paths),
                    Some(_) => FileAnswer::Nothing(question),
                };
                // When the window is closed already, the answer is dropped.
                let _ = sender.send(answer);
                on_update();
            })
            .expect("the system can start a handful of threads");
        Ok(())
    }

    pub fn take_answers(&mut self) -> Vec<FileAnswer> {
        let answers: Vec<FileAnswer> = self.receiver.try_iter().collect();
        self.open -= answers.len();
        answers
    }

    pub fn is_asking(&self) -> bool {
        self.open > 0
    }
}
