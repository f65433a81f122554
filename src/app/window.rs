//! The window: what it holds, and what it does in each pass. What goes to the engine and comes from it is in `burst_work` and its
//! neighbours.

use super::actions::{self, ActionId, Queue, palette::Palette};
use super::canvas::{Readout, View};
use super::compare_work::CompareAsked;
use super::dataset::CutDialog;
use super::dataset::thumbnails::Thumbnails;
use super::dialogs::{Desk, FileDialogs, PathField, SystemDialogs};
use super::pair_work::PairAsked;
use super::panels::display::DisplayState;
use super::panels::picture::PictureState;
use super::panels::selection::SelectionState;
use super::rooms::compare::ComparePictures;
use super::rooms::pair::PairPanels;
use super::session::Session;
use super::settings::Settings;
use super::state::Model;
use super::state::pair::Side;
use super::state::room::Room;
use super::state::scrub::ViewKind;
use crate::dataset::DatasetSource;
use crate::detector::SearchParams;
use crate::engine::{BurstSource, Engine, JobId, OnUpdate, OpenBurst, PictureRequest};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

/// With what a window starts.
pub struct Startup {
    /// What is opened first; `None` opens nothing and shows how to begin.
    pub source: Option<BurstSource>,
    /// What is opened beside it, as the second burst.
    pub second: Option<BurstSource>,
    /// A dataset that is opened instead.
    pub dataset: Option<DatasetSource>,
    /// The detector's parameters, and how the slopes are chosen.
    pub params: SearchParams,
    /// A session file that is restored instead.
    pub session: Option<PathBuf>,
    /// What was remembered from the last time.
    pub settings: Settings,
    /// Asks for files.
    pub dialogs: Arc<dyn FileDialogs>,
    /// Bytes of pictures that are kept.
    pub cache_bytes: usize,
}

impl Default for Startup {
    fn default() -> Self {
        Self {
            source: Some(BurstSource::Demo),
            second: None,
            dataset: None,
            params: SearchParams::default(),
            session: None,
            settings: Settings::default(),
            dialogs: Arc::new(SystemDialogs),
            cache_bytes: crate::engine::DEFAULT_CACHE_BYTES,
        }
    }
}

/// The window.
pub struct BurstscopeApp {
    /// What is shown.
    pub model: Model,
    /// The workers.
    pub engine: Engine,
    /// Pan and zoom of the picture.
    pub view: View,
    pub(super) palette: Palette,
    pub(super) sheet_open: bool,
    pub(super) about_open: bool,
    pub(super) play_step: usize,
    pub(super) play_due: Option<Instant>,
    pub(super) pictures: PictureState,
    pub(super) display: DisplayState,
    pub(super) selection: SelectionState,
    /// What the room of two bursts keeps.
    pub pair_panels: PairPanels,
    pub(super) pair_asked: PairAsked,
    /// What the room of methods keeps.
    pub compare_pictures: ComparePictures,
    pub(super) compare_asked: CompareAsked,
    /// Whether both hands were set, each to its own place, so that neither follows the other.
    pub(super) hands_set: bool,
    settings: Settings,
    pub(super) desk: Desk,
    pub(super) path_field: Option<PathField>,
    /// Bursts of a folder, of which one is to be chosen.
    choice: Vec<BurstSource>,
    choice_side: Side,
    /// How a sequence is to be cut, while that is being asked.
    pub(super) cut: Option<CutDialog>,
    pub(super) thumbnails: Thumbnails,
    /// What is being opened.
    pub(super) opening: Option<(JobId, BurstSource)>,
    pub(super) restoring: Option<(JobId, Box<Session>)>,
    pub(super) asked_picture: Option<PictureRequest>,
    pub(super) asked_patch: Option<PictureRequest>,
    pub(super) detecting_params: Option<SearchParams>,
    pub(super) failed_params: Option<SearchParams>,
}

impl BurstscopeApp {
    /// A window in `ctx`. Float pictures need `render_state`; without it everything else works.
    pub fn new(ctx: &egui::Context, render_state: Option<&egui_wgpu::RenderState>, startup: Startup) -> Self {
        if let Some(render_state) = render_state {
            super::gpu::install(ctx, render_state);
        }
        super::style::apply(ctx);
        let waker = ctx.clone();
        let on_update: OnUpdate = Arc::new(move || waker.request_repaint());
        let mut model = Model::default();
        model.set_search(startup.params);
        model.usable_params = model.params.clone();
        (model.theme, model.panels) = (startup.settings.theme, startup.settings.panels);
        model.auto_detect = startup.settings.auto_detect;
        (model.pair.links, model.pair.look) = (startup.settings.links, startup.settings.match_look.sanitised());
        model.check_params();
        let mut app = Self {
            model,
            engine: Engine::new(on_update.clone(), startup.cache_bytes),
            view: View::fit(),
            palette: Palette::default(),
            sheet_open: false,
            about_open: false,
            play_step: 0,
            play_due: None,
            pictures: PictureState::default(),
            display: DisplayState::default(),
            selection: SelectionState::default(),
            pair_panels: PairPanels::default(),
            pair_asked: PairAsked::default(),
            compare_pictures: ComparePictures::default(),
            compare_asked: CompareAsked::default(),
            hands_set: false,
            settings: startup.settings,
            desk: Desk::new(startup.dialogs, on_update),
            path_field: None,
            choice: Vec::new(),
            choice_side: Side::A,
            cut: None,
            thumbnails: Thumbnails::default(),
            opening: None,
            restoring: None,
            asked_picture: None,
            asked_patch: None,
            detecting_params: None,
            failed_params: None,
        };
        if let Some(path) = startup.session {
            app.restore_session(&path);
        } else if let Some(dataset) = startup.dataset {
            app.open_dataset(dataset);
        } else if let Some(source) = startup.source {
            app.open(source);
        }
        if let Some(second) = startup.second {
            app.open_second(second);
        }
        app
    }

    /// Opens a burst in the background; the one that is open stays until the new one is there.
    pub fn open(&mut self, source: BurstSource) {
        self.restoring = None;
        self.opening = Some((self.engine.open(source.clone()), source));
    }

    /// Whether everything that is wanted is there and nothing runs.
    pub fn is_settled(&self) -> bool {
        self.engine.is_idle()
            && !self.desk.is_asking()
            && self.model.picture_is_current()
            && !self.thumbnails.is_waiting()
            && !(self.model.auto_detect && self.wants_detection())
            && self.pair_is_settled()
            && self.compare_is_settled()
    }

    /// Bursts of which a person has to choose one before anything is opened; mostly none.
    pub fn choice(&self) -> &[BurstSource] {
        &self.choice
    }

    /// Draws the window and answers what happened since the last time.
    pub fn show(&mut self, ui: &mut egui::Ui) {
        let ctx = ui.ctx().clone();
        ctx.set_theme(self.model.theme);
        let hands = [self.model.scrub, self.model.pair.b.scrub];
        self.take_updates(&ctx);
        self.take_pair_updates();
        self.take_compare_updates();
        self.take_answers();
        self.take_dropped_files(&ctx);
        let mut queue = Queue::new();
        if !self.modal_is_open() {
            actions::take_shortcuts(&ctx, &self.model, &mut queue);
        }
        if ctx.input_mut(|i| i.consume_shortcut(&actions::registry::PALETTE_ALSO)) {
            queue.push(ActionId::Palette);
        }
        self.step_play(&ctx);
        super::shell::shell_ui(self, ui, &mut queue);
        self.overlays_ui(&ctx, &mut queue);
        for id in queue {
            self.run_action(&ctx, id);
        }
        self.model.check_params();
        self.model.check_pair();
        if !std::mem::take(&mut self.hands_set) {
            self.model.follow_hand(hands);
        }
        self.model.refresh_listed();
        self.model.pair.refresh_listed();
        self.request_what_is_missing(&ctx);
    }

    fn modal_is_open(&self) -> bool {
        self.palette.is_open()
            || self.sheet_open
            || self.about_open
            || self.path_field.is_some()
            || self.cut.is_some()
            || !self.choice.is_empty()
    }

    fn overlays_ui(&mut self, ctx: &egui::Context, queue: &mut Queue) {
        self.palette.ui(ctx, &self.model, queue);
        actions::shortcuts_sheet::sheet_ui(ctx, &mut self.sheet_open);
        super::panels::about::about_ui(ctx, &mut self.about_open);
        if let Some(field) = &mut self.path_field {
            let purpose = field.purpose;
            let (path, stay) = field.ui(ctx);
            if !stay {
                self.path_field = None;
            }
            if let Some(path) = path {
                self.use_files(purpose, vec![path]);
            }
        }
        if let Some(burst) = super::panels::chooser::chooser_ui(ctx, &mut self.choice) {
            match self.choice_side {
                Side::A => self.open(burst),
                Side::B => self.open_second(burst),
            }
        }
        if let Some(dialog) = &mut self.cut {
            let (source, stay) = dialog.ui(ctx);
            if !stay {
                self.cut = None;
            }
            if let Some(source) = source {
                self.open_dataset(source);
            }
        }
        super::panels::messages::messages_ui(ctx, &mut self.model.messages);
    }

    /// Asks the person which of `bursts` is to be opened as `side`.
    pub(super) fn choose_among(&mut self, bursts: Vec<BurstSource>, side: Side) {
        (self.choice, self.choice_side) = (bursts, side);
    }

    /// Puts a burst at the top of the recent ones. One of the dataset is remembered with it, and has the name that it has there.
    pub(super) fn remember(&mut self, burst: &mut OpenBurst) {
        match &self.model.datasets.open {
            Some(dataset) if dataset.place_of(Some(burst)).is_some() => dataset.name_as_here(burst),
            _ => self.settings.remember(&burst.source),
        }
    }

    pub(super) fn go_to_selected(&mut self) {
        if let Some(feature) = self.model.selected_feature().copied() {
            self.model.scrub.slope = feature.slope;
            (self.model.slope_chosen, self.model.playing) = (true, false);
            if self.model.scrub.kind == ViewKind::Frame {
                self.model.scrub.kind = ViewKind::Stack;
            }
            self.view.look_at(egui::pos2(feature.u, feature.v), 60.0 / feature.sigma.max(1.0));
        }
    }
}

impl eframe::App for BurstscopeApp {
    fn ui(&mut self, ui: &mut egui::Ui, _frame: &mut eframe::Frame) {
        self.show(ui);
    }

    fn save(&mut self, storage: &mut dyn eframe::Storage) {
        self.settings.take_from(&self.model);
        self.settings.store(storage);
    }
}

impl BurstscopeApp {
    /// Where a place of the image (in pixels) is in the window (in points), as last drawn.
    pub fn ui_from_image(&self, pos_image: egui::Pos2) -> Option<egui::Pos2> {
        self.pictures.ui_from_image.map(|t| t.pos(pos_image))
    }

    /// The value under the pointer.
    pub(super) fn readout(&self) -> Option<&Readout> {
        let in_b = self.pair_panels.pictures_b.readout.as_ref().filter(|_| self.model.room == Room::Pair);
        self.pictures.readout.as_ref().or(in_b)
    }

    /// What is remembered from the last time.
    pub fn remembered(&self) -> &Settings {
        &self.settings
    }

    pub(super) fn remember_dataset(&mut self, source: &DatasetSource) {
        self.settings.remember_dataset(source);
    }

    pub(super) fn burst_length(&self) -> usize {
        self.settings.burst_length
    }

    /// Bursts that were opened before, the latest first.
    pub fn recent(&self) -> &[BurstSource] {
        &self.settings.recent
    }
}
