//! Overlays of the window: dialogs, the palette, sheets, messages.

use super::actions::menu::Palette;
use super::actions::{ActionId, Queue, menu};
use super::dataset::CutDialog;
use super::dialogs::{PathField, ReplaceFile, ShapeDialog};
use super::figure::{figure_ui, film_ui};
use super::files;
use super::inspector::PaneWidgets;
use super::lesson::Lessons;
use super::settings::Settings;
use crate::app::document::{Action, Purpose, Side};
use crate::app::results::{Effect, Read};
use crate::app::{panel::glossary::GlossaryWindow, panel::modals};
use crate::burst::OpenOptions;
use crate::requests::{BurstId, BurstSource};
use egui::Context;
use std::path::PathBuf;

#[derive(Default)]
pub(super) struct Overlays {
    pub palette: Palette,
    pub sheet_open: bool,
    pub about_open: bool,
    pub glossary: GlossaryWindow,
    pub figure_open: bool,
    pub film_open: bool,
    pub calibration: Option<OpenOptions>,
    pub path_field: Option<PathField>,
    pub replace_file: Option<ReplaceFile>,
    pub choice: Vec<BurstSource>,
    pub choice_side: Side,
    pub shape: ShapeDialog,
    pub cut: Option<CutDialog>,
    pub replace_features: bool,
    /// The mask that is being written, which then is that of the frames.
    pub mask: Option<PathBuf>,
    /// A burst that could be cut, and that the user chose not to cut.
    pub stays_whole: Option<BurstId>,
}

impl Overlays {
    pub fn calibration_draft(&mut self, now: &OpenOptions) -> &mut OpenOptions {
        self.calibration.get_or_insert_with(|| now.clone())
    }

    pub fn open(&mut self, id: ActionId, model: Read<'_>) -> bool {
        match id {
            ActionId::Palette => self.palette.open(),
            ActionId::Shortcuts => self.sheet_open = !self.sheet_open,
            ActionId::About => self.about_open = true,
            ActionId::Glossary => self.glossary.open(None),
            ActionId::FigureOptions => self.figure_open = true,
            ActionId::FilmOptions => self.film_open = true,
            ActionId::Calibration => _ = self.calibration_draft(&model.document.calibration),
            ActionId::OpenPath => self.open_path_field(Purpose::OpenPath(Side::A), String::new(), false),
            ActionId::OpenPathB => self.open_path_field(Purpose::OpenPath(Side::B), String::new(), false),
            _ => return false,
        }
        true
    }

    pub fn open_path_field(&mut self, purpose: Purpose, text: String, instead_of_dialog: bool) {
        self.path_field = Some(PathField::new(purpose, text, instead_of_dialog));
    }

    pub fn are_modal(&self, lessons: &Lessons) -> bool {
        self.palette.is_open
            || self.sheet_open
            || self.about_open
            || lessons.list_is_open
            || self.figure_open
            || self.film_open
            || self.calibration.is_some()
            || self.path_field.is_some()
            || self.replace_file.is_some()
            || self.shape.is_open()
            || self.cut.is_some()
            || self.replace_features
            || !self.choice.is_empty()
    }

    pub fn ui(
        &mut self,
        ctx: &Context,
        (model, widgets): (Read<'_>, &PaneWidgets),
        remembered: &Settings,
        lessons: &mut Lessons,
        queue: &mut Queue,
    ) -> Vec<Effect> {
        let mut effects = Vec::new();
        self.palette.ui(ctx, model, queue);
        menu::sheet_ui(ctx, &mut self.sheet_open);
        self.glossary.ui(ctx);
        effects.extend(super::lesson::list_ui(ctx, lessons, queue).map(Effect::StartLesson));
        if lessons.open.is_some() && !self.are_modal(lessons) {
            super::lesson::highlights_ui(ctx);
        }
        figure_ui(ctx, &mut self.figure_open, (model, widgets), queue);
        film_ui(ctx, &mut self.film_open, model, queue);
        effects.extend(modals::calibration_ui(ctx, &mut self.calibration, queue).map(Effect::Ask));
        effects.extend(self.path_ui(ctx, (model, remembered), queue));
        if let Some(burst) = modals::chooser_ui(ctx, &mut self.choice) {
            queue.push(Action::Open(self.choice_side, burst));
        }
        if let Some((side, source, dump)) = self.shape.ui(ctx, model, queue) {
            queue.push(Action::Calibrate(OpenOptions { raw: Some(dump), ..model.document.calibration.clone() }));
            queue.push(Action::Open(side, source));
        }
        if let Some(dialog) = &mut self.cut {
            let (source, stay) = dialog.ui(ctx);
            self.cut.take_if(|_| !stay);
            source.into_iter().for_each(|source| queue.push(Action::OpenDataset(source)));
        }
        super::dataset::replace_features_ui(ctx, &mut self.replace_features, &model.results.datasets, queue);
        let has_filmstrip = model.results.datasets.open.is_some() && model.document.panels.filmstrip;
        let below = if has_filmstrip { super::dataset::filmstrip::HEIGHT } else { 0.0 };
        crate::app::panel::status::messages_ui(ctx, &model.shell.messages, below, queue);
        effects
    }

    fn path_ui(
        &mut self,
        ctx: &Context,
        (model, remembered): (Read<'_>, &Settings),
        queue: &mut Queue,
    ) -> Option<Effect> {
        if let Some(field) = &mut self.path_field {
            let purpose = field.purpose;
            let (path, stay) = field.ui(ctx, (model, &remembered.recent_paths(purpose)), queue);
            self.path_field.take_if(|_| !stay);
            let path = path?;
            if !purpose.saves() {
                return Some(Effect::UseFiles(purpose, vec![path]));
            }
            if std::fs::symlink_metadata(&path).is_ok() && files::may_replace(&path, model).check(&path).is_ok() {
                self.replace_file = Some(ReplaceFile::new(purpose, path));
                return None;
            }
            return Some(Effect::Write(purpose, path));
        }
        let may_replace = self.replace_file.as_ref()?.ui(ctx)?;
        let ReplaceFile { purpose, path, .. } = self.replace_file.take()?;
        may_replace.then_some(Effect::Write(purpose, path))
    }
}
