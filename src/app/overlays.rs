//! Overlays of the window: dialogs, the palette, sheets, messages.

use super::actions::{Queue, palette::Palette, shortcuts_sheet};
use super::dataset::CutDialog;
use super::dialogs::{PathField, ReplaceFile};
use super::window::BurstscopeApp;
use crate::app::panel::glossary::GlossaryWindow;
use crate::app::panel::modals::CalibrationChoice;
use crate::app::project::pair::Side;
use crate::burst::OpenOptions;
use crate::requests::{BurstId, BurstSource};

/// State of the overlays.
#[derive(Default)]
pub(super) struct Overlays {
    pub palette: Palette,
    pub sheet_open: bool,
    pub about_open: bool,
    pub glossary: GlossaryWindow,
    pub figure_open: bool,
    /// The calibration that is being set, while its dialog is open.
    pub calibration: Option<OpenOptions>,
    pub path_field: Option<PathField>,
    /// A file to be overwritten, while the user is asked.
    pub replace_file: Option<ReplaceFile>,
    /// Bursts of a folder, of which one is to be chosen, and the side for which it is opened.
    pub choice: Vec<BurstSource>,
    pub choice_side: Side,
    /// Options for cutting a sequence, while the user is asked.
    pub cut: Option<CutDialog>,
    /// Whether the user is being asked to replace features of other parameters.
    pub replace_features: bool,
    /// A burst that could be cut, and that the user chose not to cut.
    pub stays_whole: Option<BurstId>,
}

impl Overlays {
    /// The calibration that is being set; its dialog is opened if it is not.
    pub fn calibration_draft(&mut self, now: &OpenOptions) -> &mut OpenOptions {
        self.calibration.get_or_insert_with(|| now.clone())
    }
}

impl BurstscopeApp {
    /// Opens the bursts and the dataset again with this calibration.
    pub(super) fn calibrate(&mut self, options: OpenOptions) {
        self.model.calibration = options;
        // The thumbnails were made with the earlier calibration.
        self.thumbnails.clear();
        if let Some(source) = self.model.slots.a.burst.as_ref().map(|open| open.source.clone()) {
            self.open(source);
        }
        if let Some(source) = self.model.slots.b.burst.as_ref().map(|open| open.source.clone()) {
            self.open_second(source);
        }
        if let Some(dataset) = &self.model.datasets.open {
            self.look_at_dataset(dataset.source.clone(), dataset.folder.clone());
        }
    }

    /// Bursts of which the user has to choose one before anything is opened; usually none.
    pub fn choice(&self) -> &[BurstSource] {
        &self.overlays.choice
    }

    /// Whether a dialog is open that gets all keys.
    pub(super) fn modal_is_open(&self) -> bool {
        self.overlays.palette.is_open()
            || self.overlays.sheet_open
            || self.overlays.about_open
            || self.lessons.list_is_open
            || self.overlays.figure_open
            || self.overlays.calibration.is_some()
            || self.overlays.path_field.is_some()
            || self.overlays.replace_file.is_some()
            || self.overlays.cut.is_some()
            || self.overlays.replace_features
            || !self.overlays.choice.is_empty()
    }

    pub(super) fn overlays_ui(&mut self, ctx: &egui::Context, queue: &mut Queue) {
        self.overlays.palette.ui(ctx, &self.model, queue);
        shortcuts_sheet::sheet_ui(ctx, &mut self.overlays.sheet_open);
        crate::app::panel::modals::about_ui(ctx, &mut self.overlays.about_open);
        self.overlays.glossary.ui(ctx);
        if let Some(lesson) = super::lesson::list_ui(ctx, &mut self.lessons, queue) {
            self.start_lesson(lesson);
        }
        if self.lessons.open.is_some() && !self.modal_is_open() {
            super::lesson::highlights_ui(ctx);
        }
        super::figure::figure_dialog_ui(ctx, &mut self.overlays.figure_open, &mut self.model.figure, queue);
        match crate::app::panel::modals::calibration_ui(ctx, &mut self.overlays.calibration) {
            Some(CalibrationChoice::Choose(purpose)) => self.ask(purpose),
            Some(CalibrationChoice::Apply(options)) => self.calibrate(options),
            None => {}
        }
        if let Some(field) = &mut self.overlays.path_field {
            let purpose = field.purpose;
            let (path, stay) = field.ui(ctx);
            if !stay {
                self.overlays.path_field = None;
            }
            match path {
                Some(path) if purpose.saves() => self.ask_and_write(purpose, path),
                Some(path) => self.use_files(purpose, vec![path]),
                None => {}
            }
        } else if let Some(question) = &self.overlays.replace_file
            && let Some(may_replace) = question.ui(ctx)
            && let Some(ReplaceFile { purpose, path, .. }) = self.overlays.replace_file.take()
            && may_replace
        {
            self.write(purpose, path);
        }
        if let Some(burst) = crate::app::panel::modals::chooser_ui(ctx, &mut self.overlays.choice) {
            self.open_for(self.overlays.choice_side, burst);
        }
        if let Some(dialog) = &mut self.overlays.cut {
            let (source, stay) = dialog.ui(ctx);
            if !stay {
                self.overlays.cut = None;
            }
            if let Some(source) = source {
                self.open_dataset(source);
            }
        }
        if super::dataset::replace_features_ui(ctx, &mut self.overlays.replace_features, &self.model.datasets) {
            self.detect_all();
        }
        crate::app::panel::status::messages_ui(ctx, &mut self.model.messages);
    }

    /// Asks the user which of `bursts` is to be opened as `side`.
    pub(super) fn choose_among(&mut self, bursts: Vec<BurstSource>, side: Side) {
        (self.overlays.choice, self.overlays.choice_side) = (bursts, side);
    }
}
