//! What the window does with files: asks for them, opens, restores, loads and writes them.

use super::dataset::Which;
use super::dialogs::{ExportKind, FileAnswer, PathField, Purpose, Question};
use super::session::Session;
use super::window::BurstscopeApp;
use crate::app::pane::Content;
use crate::app::project::BottomTab;
use crate::app::project::cursor::ViewKind;
use crate::app::project::workspace::Workspace;
use crate::dataset::DatasetSource;
use crate::detector::SearchParams;
use crate::engine::{BurstSource, MapKind};
use std::path::PathBuf;

impl BurstscopeApp {
    pub(super) fn take_answers(&mut self) {
        for answer in self.desk.take_answers() {
            match answer {
                FileAnswer::Chosen(purpose, paths) => self.use_files(purpose, paths),
                FileAnswer::Nothing => {}
                FileAnswer::NoDialog(question) => {
                    let text = if question.purpose.saves() { question.suggested_name } else { String::new() };
                    self.overlays.path_field = Some(PathField::new(question.purpose, text, true));
                }
            }
        }
    }

    pub(super) fn take_dropped_files(&mut self, ctx: &egui::Context) {
        let paths: Vec<PathBuf> = ctx.input(|i| i.raw.dropped_files.iter().map(|f| f.path().to_path_buf()).collect());
        if paths.is_empty() {
            return;
        }
        match paths.as_slice() {
            [one] if one.extension().is_some_and(|e| e == "toml") => {
                let is_session = std::fs::read_to_string(one).is_ok_and(|text| Session::from_toml(&text).is_ok());
                self.use_files(if is_session { Purpose::RestoreSession } else { Purpose::LoadParams }, paths);
            }
            [one] if self.model.workspace == Workspace::Trajectories => {
                // The first that comes is the estimate, the second the truth; a third takes the place of the estimate.
                let compared = &self.model.trajectories.compared;
                let truth = compared.estimate.is_some() && compared.truth.is_none();
                self.open_trajectory(if truth { Which::Truth } else { Which::Estimate }, one.clone());
            }
            _ if self.is_dropped_on_b(ctx) => self.open_second(BurstSource::Paths(paths)),
            _ => self.open(BurstSource::Paths(paths)),
        }
    }

    /// Whether what is dropped now falls on the pane of the second burst.
    fn is_dropped_on_b(&self, ctx: &egui::Context) -> bool {
        let pointer = ctx.input(|i| i.pointer.latest_pos());
        self.model.workspace == Workspace::Pair
            && self.pair_panels.rect_b.zip(pointer).is_some_and(|(pane, pos)| pane.contains(pos))
    }

    /// Asks for files with the system's dialog.
    pub(super) fn ask(&mut self, purpose: Purpose) {
        let question =
            Question { purpose, suggested_name: self.suggested_name(purpose), folder: self.folder_of_burst() };
        self.desk.ask(question);
    }

    /// Asks for a path with a field to type it into.
    pub(super) fn open_path_field(&mut self, purpose: Purpose, instead_of_dialog: bool) {
        self.overlays.path_field = Some(PathField::new(purpose, String::new(), instead_of_dialog));
    }

    fn suggested_name(&self, purpose: Purpose) -> String {
        let burst = self.model.burst.as_ref().map_or("burst", |b| b.burst.name.as_str());
        let stem = std::path::Path::new(burst).file_stem().map_or("burst".into(), |s| s.to_string_lossy());
        match purpose {
            Purpose::SaveSession => format!("{stem}.burstscope.toml"),
            Purpose::SaveParams => "params.toml".to_owned(),
            Purpose::Export(kind) => {
                let of_picture = match (self.model.focused().content, self.model.cursor().kind) {
                    (Content::Map(MapKind::Noise), _) => "noise",
                    (Content::Map(MapKind::Coverage), _) => "coverage",
                    (Content::Map(MapKind::Motion), _) => "winning-slopes",
                    (Content::Merge, _) => "merge",
                    (Content::Slice(_), _) => "slice",
                    (Content::Difference(..), _) => "difference",
                    (Content::Cursor, ViewKind::Frame) => "frame",
                    (Content::Cursor, ViewKind::Stack) => "stack",
                    (Content::Cursor, ViewKind::Dog) => "dog",
                };
                let what = match kind {
                    ExportKind::Csv | ExportKind::Colmap | ExportKind::Npz => "features",
                    ExportKind::Matches | ExportKind::MatchPicture => "matches",
                    ExportKind::Profile => "profile",
                    ExportKind::Svg | ExportKind::FigurePng => "figure",
                    ExportKind::Tiff | ExportKind::Png => of_picture,
                };
                format!("{stem}-{what}.{}", kind.extension())
            }
            _ => String::new(),
        }
    }

    fn folder_of_burst(&self) -> Option<PathBuf> {
        match &self.model.burst.as_ref()?.source {
            BurstSource::Paths(paths) => paths.first()?.parent().map(PathBuf::from).filter(|p| p.is_dir()),
            BurstSource::Demo | BurstSource::DemoLater | BurstSource::Example(_) => None,
        }
    }

    pub(super) fn use_files(&mut self, purpose: Purpose, paths: Vec<PathBuf>) {
        let Some(first) = paths.first().cloned() else { return };
        match purpose {
            Purpose::OpenFolder | Purpose::OpenFiles | Purpose::OpenPath => self.open(BurstSource::Paths(paths)),
            Purpose::OpenDataset => self.open_dataset(DatasetSource::of_bursts(paths)),
            Purpose::OpenEstimate => self.open_trajectory(Which::Estimate, first),
            Purpose::OpenTruth => self.open_trajectory(Which::Truth, first),
            Purpose::FeatureFolder => self.use_feature_folder(first),
            #[cfg(feature = "colmap")]
            Purpose::ExportDatabase => self.export_database(first),
            // Without COLMAP's database nobody can ask for it.
            #[cfg(not(feature = "colmap"))]
            Purpose::ExportDatabase => {}
            Purpose::OpenFolderB | Purpose::OpenFilesB | Purpose::OpenPathB => {
                self.open_second(BurstSource::Paths(paths));
            }
            Purpose::OpenGold(side) => self.open_gold(BurstSource::Paths(paths), side),
            Purpose::OpenFeatures => {
                self.model.lay_over(first);
                self.model.bottom_tab = BottomTab::Compared;
            }
            Purpose::RestoreSession => self.restore_session(&first),
            Purpose::LoadParams => self.load_params(&first),
            Purpose::SaveSession | Purpose::SaveParams | Purpose::Export(_) => self.write(purpose, first),
        }
    }

    /// Restores a session file: opens its burst, and when that worked takes over everything else. Until then nothing
    /// changes.
    pub fn restore_session(&mut self, path: &std::path::Path) {
        let read = std::fs::read_to_string(path).map_err(|e| e.to_string());
        match read.and_then(|text| Session::from_toml(&text)) {
            Ok(session) => {
                self.model.messages.resolved("Open session");
                let id = self.engine.open(session.burst.clone());
                self.asked.restoring = Some((id, Box::new(session)));
            }
            Err(error) => self.model.messages.error("Open session", format!("{error}: {}", path.display())),
        }
    }

    fn load_params(&mut self, path: &std::path::Path) {
        let read = std::fs::read_to_string(path).map_err(|e| e.to_string());
        match read.and_then(|text| SearchParams::from_toml(&text)) {
            Ok(params) => {
                self.model.set_search(params);
                self.model.messages.resolved("Load parameters");
                self.model.messages.note(format!("Loaded parameters from {}", path.display()));
            }
            Err(error) => self.model.messages.error("Load parameters", format!("{error}: {}", path.display())),
        }
    }

    fn write(&mut self, purpose: Purpose, path: PathBuf) {
        match crate::app::jobs::writing::prepare(purpose, &self.model, &self.widgets) {
            Ok(work) => {
                self.engine.task(purpose.title(), move || {
                    work(&path)?;
                    Ok(format!("Wrote {}", path.display()))
                });
            }
            Err(why) => self.model.messages.error(purpose.title(), why),
        }
    }
}
