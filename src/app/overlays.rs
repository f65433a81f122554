//! What floats over the window: dialogs, the palette, sheets, messages.

use super::actions::{Queue, palette::Palette, shortcuts_sheet};
use super::dataset::CutDialog;
use super::dialogs::PathField;
use super::window::BurstscopeApp;
use crate::app::project::pair::Side;
use crate::engine::{BurstId, BurstSource};

/// What floats over the window.
#[derive(Default)]
pub(super) struct Overlays {
    pub palette: Palette,
    pub sheet_open: bool,
    pub about_open: bool,
    pub figure_open: bool,
    pub path_field: Option<PathField>,
    /// Bursts of a folder, of which one is to be chosen, and as which it is opened.
    pub choice: Vec<BurstSource>,
    pub choice_side: Side,
    /// How a sequence is to be cut, while that is being asked.
    pub cut: Option<CutDialog>,
    /// Whether features of other parameters may be replaced, while that is being asked.
    pub replace_features: bool,
    /// The burst that stays as long as it is, though it could be cut.
    pub stays_whole: Option<BurstId>,
}

impl BurstscopeApp {
    /// Bursts of which a person has to choose one before anything is opened; mostly none.
    pub fn choice(&self) -> &[BurstSource] {
        &self.overlays.choice
    }

    /// Whether a dialog has the keys.
    pub(super) fn modal_is_open(&self) -> bool {
        self.overlays.palette.is_open()
            || self.overlays.sheet_open
            || self.overlays.about_open
            || self.overlays.figure_open
            || self.overlays.path_field.is_some()
            || self.overlays.cut.is_some()
            || self.overlays.replace_features
            || !self.overlays.choice.is_empty()
    }

    pub(super) fn overlays_ui(&mut self, ctx: &egui::Context, queue: &mut Queue) {
        self.overlays.palette.ui(ctx, &self.model, queue);
        shortcuts_sheet::sheet_ui(ctx, &mut self.overlays.sheet_open);
        crate::app::panel::about::about_ui(ctx, &mut self.overlays.about_open);
        super::figure::figure_dialog_ui(ctx, &mut self.overlays.figure_open, &mut self.model.figure, queue);
        if let Some(field) = &mut self.overlays.path_field {
            let purpose = field.purpose;
            let (path, stay) = field.ui(ctx);
            if !stay {
                self.overlays.path_field = None;
            }
            if let Some(path) = path {
                self.use_files(purpose, vec![path]);
            }
        }
        if let Some(burst) = crate::app::panel::chooser::chooser_ui(ctx, &mut self.overlays.choice) {
            match self.overlays.choice_side {
                Side::A => self.open(burst),
                Side::B => self.open_second(burst),
            }
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
        crate::app::panel::messages::messages_ui(ctx, &mut self.model.messages);
    }

    /// Asks the person which of `bursts` is to be opened as `side`.
    pub(super) fn choose_among(&mut self, bursts: Vec<BurstSource>, side: Side) {
        (self.overlays.choice, self.overlays.choice_side) = (bursts, side);
    }
}
