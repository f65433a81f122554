//! File actions of the window: asks for files, opens, restores, loads and writes them.

use super::dialogs::{ExportKind, FileAnswer, PathField, Purpose, Question, ReplaceFile};
use super::session::Session;
use super::window::BurstscopeApp;
use crate::app::pane::KindOfPicture;
use crate::app::project::BottomTab;
use crate::app::project::side::Side;
use crate::app::project::trajectories::Which;
use crate::app::project::workspace::Workspace;
use crate::dataset::DatasetSource;
use crate::detector::SearchParams;
use crate::export::{OpenedFiles, OutputRules, Overwrite};
use crate::files::{MAX_SESSION_BYTES, MAX_SETTINGS_BYTES, explained, read_text};
use crate::requests::{BurstSource, JobId, OpenRequest};
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
        if let (Some(draft), [one]) = (&mut self.overlays.calibration, paths.as_slice()) {
            // Dropped on the open dialog: the bias frame first, then the flat frame.
            let field = if draft.bias.is_none() { &mut draft.bias } else { &mut draft.flat };
            *field = Some(one.clone());
            return;
        }
        match paths.as_slice() {
            [one] if one.extension().is_some_and(|e| e == "toml") => {
                let is_session = read_text(one, MAX_SESSION_BYTES).is_ok_and(|text| Session::from_toml(&text).is_ok());
                self.use_files(if is_session { Purpose::RestoreSession } else { Purpose::LoadParams }, paths);
            }
            [one] if self.model.workspace == Workspace::Trajectories => {
                // The first file dropped is the estimate, the second the truth; a third replaces the estimate.
                let compared = &self.model.trajectories.compared;
                let truth = compared.estimate.is_some() && compared.truth.is_none();
                let which = if truth { Which::Truth } else { Which::Estimate };
                self.open_trajectory(which, one.clone());
            }
            _ if self.is_dropped_on_b(ctx) => self.open_second(BurstSource::Paths(paths)),
            _ => self.open(BurstSource::Paths(paths)),
        }
    }

    /// Whether the pointer is over a pane of the second burst, for dropped files.
    fn is_dropped_on_b(&self, ctx: &egui::Context) -> bool {
        let pointer = ctx.input(|i| i.pointer.latest_pos());
        let is_there = |rect: &egui::Rect| pointer.is_some_and(|pos| rect.contains(pos));
        self.drop_places().iter().any(|(rect, side)| *side == Side::B && is_there(rect))
    }

    /// Rectangles of the panes in *Two bursts*, with the side for which files dropped there are opened.
    pub(super) fn drop_places(&self) -> Vec<(egui::Rect, Side)> {
        if self.model.workspace != Workspace::Pair || self.model.slots.a.burst.is_none() {
            return Vec::new();
        }
        let place = |id| Some((self.widgets.rect_ui(id)?, self.model.panes.get(id)?.side));
        self.model.visible_panes().into_iter().filter_map(place).collect()
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
        let burst = self.model.slots.a.burst.as_ref().map_or("burst", |b| b.burst.name.as_str());
        let stem = std::path::Path::new(burst).file_stem().map_or("burst".into(), |s| s.to_string_lossy());
        match purpose {
            Purpose::SaveSession => format!("{stem}.burstscope.toml"),
            Purpose::SaveParams => "params.toml".to_owned(),
            Purpose::Export(kind) => {
                let (content, of_cursor) = (self.model.focused().content, self.model.cursor().kind);
                let what = match kind {
                    ExportKind::Csv | ExportKind::Colmap | ExportKind::Npz => "features",
                    ExportKind::Matches | ExportKind::MatchPicture => "matches",
                    ExportKind::Profile => "profile",
                    ExportKind::Svg | ExportKind::FigurePng => "figure",
                    ExportKind::CurvesCsv | ExportKind::CurvesSvg => "curves",
                    ExportKind::Tiff | ExportKind::Png => KindOfPicture::of_content(content, of_cursor).file_name,
                };
                format!("{stem}-{what}.{}", kind.extension())
            }
            _ => String::new(),
        }
    }

    fn folder_of_burst(&self) -> Option<PathBuf> {
        match &self.model.slots.a.burst.as_ref()?.source {
            BurstSource::Paths(paths) => paths.first()?.parent().map(PathBuf::from).filter(|p| p.is_dir()),
            BurstSource::Demo
            | BurstSource::DemoLater
            | BurstSource::Example(_)
            | BurstSource::Chart(_)
            | BurstSource::DarkCopy { .. } => None,
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
            Purpose::PaperFigures => self.model.make_figures(first, &self.engine),
            #[cfg(feature = "colmap")]
            Purpose::ExportDatabase => self.export_database(first),
            // Without the feature `colmap` there is no action for this.
            #[cfg(not(feature = "colmap"))]
            Purpose::ExportDatabase => {}
            Purpose::OpenFolderB | Purpose::OpenFilesB | Purpose::OpenPathB => {
                self.open_second(BurstSource::Paths(paths));
            }
            Purpose::OpenGold(side) => self.model.open_gold(side, BurstSource::Paths(paths), &self.engine),
            Purpose::OpenBias => self.overlays.calibration_draft(&self.model.calibration).bias = Some(first),
            Purpose::OpenFlat => self.overlays.calibration_draft(&self.model.calibration).flat = Some(first),
            Purpose::OpenFeatures => {
                self.model.lay_over(first);
                self.model.bottom_tab = BottomTab::Compared;
            }
            Purpose::OpenLessons => self.open_lessons(&first),
            Purpose::RestoreSession => {
                self.restore_session(&first);
            }
            Purpose::LoadParams => self.load_params(&first),
            Purpose::SaveSession | Purpose::SaveParams | Purpose::Export(_) => self.write(purpose, first),
        }
    }

    /// Restores a session file: opens its burst, then restores everything else, even if the burst could not be opened.
    /// Until then nothing changes. Returns the request that opens the burst; `None` if the file cannot be read.
    pub fn restore_session(&mut self, path: &std::path::Path) -> Option<JobId> {
        let read = read_text(path, MAX_SESSION_BYTES).map_err(|e| e.to_string());
        match read.and_then(|text| Session::from_toml(&text).map_err(|e| explained(&text, &e))) {
            Ok(session) => {
                self.model.messages.resolved("Open session");
                let (source, options) = (session.burst.clone(), session.calibration.clone());
                let id = self.model.slots.a.opening.ask(&self.engine, OpenRequest { source, options });
                self.restoring.session = Some((id, Box::new(session)));
                Some(id)
            }
            Err(error) => {
                self.model.messages.error("Open session", format!("{error}: {}", path.display()));
                None
            }
        }
    }

    fn load_params(&mut self, path: &std::path::Path) {
        let read = read_text(path, MAX_SETTINGS_BYTES).map_err(|e| e.to_string());
        match read.and_then(|text| SearchParams::from_toml(&text).map_err(|e| explained(&text, &e))) {
            Ok(params) => {
                self.model.set_search(params);
                self.model.messages.resolved("Load parameters");
                self.model.messages.note(format!("Loaded parameters from {}", path.display()));
            }
            Err(error) => self.model.messages.error("Load parameters", format!("{error}: {}", path.display())),
        }
    }

    /// Writes a file to a path that was typed; where there is a file, it asks first.
    pub(super) fn ask_and_write(&mut self, purpose: Purpose, path: PathBuf) {
        let is_there = std::fs::symlink_metadata(&path).is_ok();
        match self.may_replace(&path).check(&path) {
            Ok(()) if is_there => self.overlays.replace_file = Some(ReplaceFile::new(purpose, path)),
            _ => self.write(purpose, path),
        }
    }

    /// Rules for overwriting after the user agreed: any file but those that are open.
    fn may_replace(&self, path: &std::path::Path) -> OutputRules {
        // A file that does not exist is not open either; this avoids listing the files of a large dataset.
        let is_there = std::fs::symlink_metadata(path).is_ok();
        let opened = if is_there { self.model.opened_files() } else { Vec::new() };
        OutputRules::new(OpenedFiles::of(opened), Overwrite::Force)
    }

    /// Writes a file. The dialog that gave the path has asked before overwriting.
    pub(super) fn write(&mut self, purpose: Purpose, path: PathBuf) {
        let rules = self.may_replace(&path);
        let prepared = crate::app::jobs::writing::prepare(purpose, &self.model, &self.widgets);
        match rules.check(&path).map_err(|e| e.to_string()).and(prepared) {
            Ok(work) => {
                self.model.messages.resolved(purpose.title());
                self.engine.task(purpose.title(), move || {
                    // The task may have waited, and files changed meanwhile.
                    rules.check(&path).map_err(|e| e.to_string())?;
                    work(&path)?;
                    Ok(format!("Wrote {}", path.display()))
                });
            }
            Err(why) => self.model.messages.error(purpose.title(), why),
        }
    }
}
