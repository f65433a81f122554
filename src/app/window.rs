//! The window: takes the engine's answers, draws the panels, and asks the engine for what is missing.

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
use super::state::pair::Side;
use super::state::room::Room;
use super::state::scrub::{ViewKind, played};
use super::state::{Busy, Model};
use crate::dataset::DatasetSource;
use crate::detector::DetectorParams;
use crate::engine::{
    Answer as JobAnswer, BurstSource, DetectRequest, Engine, JobError, JobId, LaneKind, OnUpdate, OpenBurst, PairLane,
    PictureRequest, Update,
};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// With what a window starts.
pub struct Startup {
    /// What is opened first; `None` opens nothing and shows how to begin.
    pub source: Option<BurstSource>,
    /// What is opened beside it, as the second burst.
    pub second: Option<BurstSource>,
    /// A dataset that is opened instead.
    pub dataset: Option<DatasetSource>,
    /// The detector's parameters.
    pub params: DetectorParams,
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
            params: DetectorParams::default(),
            session: None,
            settings: Settings::default(),
            dialogs: Arc::new(SystemDialogs),
            cache_bytes: crate::engine::DEFAULT_CACHE_BYTES,
        }
    }
}

/// Pauses between slopes while they are played.
const PLAY_EVERY: Duration = Duration::from_millis(220);

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
    opening: Option<(JobId, BurstSource)>,
    pub(super) restoring: Option<(JobId, Box<Session>)>,
    asked_picture: Option<PictureRequest>,
    asked_patch: Option<PictureRequest>,
    detecting_params: Option<DetectorParams>,
    failed_params: Option<DetectorParams>,
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
        (model.params, model.usable_params) = (startup.params.clone(), startup.params);
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

    /// Takes what the engine published.
    fn take_updates(&mut self, ctx: &egui::Context) {
        for update in self.engine.poll() {
            match update {
                Update::Opened(answer) => self.take_opened(answer),
                Update::Picture(answer) => match answer.result {
                    Ok(picture) => self.model.take_picture(picture),
                    Err(JobError::Cancelled) => self.asked_picture = None,
                    Err(error) => self.model.messages.error("Picture", error.to_string()),
                },
                Update::Patch(answer) => match answer.result {
                    Ok(patch) => self.model.patch = Some(patch),
                    Err(JobError::Cancelled) => {}
                    Err(error) => self.model.messages.error("Patch", error.to_string()),
                },
                Update::Detected(answer) => {
                    let asked = self.detecting_params.take();
                    match answer.result {
                        Ok(detected) => {
                            self.model.messages.resolved("Detection");
                            self.model.take_detection(detected, answer.elapsed);
                        }
                        Err(JobError::Cancelled) => {
                            self.failed_params = asked;
                            self.model.messages.note("Detection cancelled");
                        }
                        Err(error) => {
                            self.failed_params = asked;
                            self.model.messages.error("Detection", error.to_string());
                        }
                    }
                }
                Update::Task(done) => match done.result {
                    Ok(text) => self.model.messages.note(text),
                    Err(error) => self.model.messages.error(done.label, error.to_string()),
                },
                Update::Dataset(update) => self.take_dataset_update(ctx, update),
                Update::ComparedPoses(answer) => self.take_compared(answer),
            }
        }
        self.model.busy = Busy {
            opening: self.engine.running(LaneKind::Open),
            detecting: self.engine.running(LaneKind::Detect),
            picture: self.engine.running(LaneKind::Picture).is_some(),
        };
        self.model.datasets.running = self.engine.datasets.running();
        self.model.trajectories.running = self.engine.poses.running();
    }

    fn take_opened(&mut self, answer: JobAnswer<OpenBurst>) {
        let session = match self.restoring.take() {
            Some((id, session)) if id == answer.id => Some(session),
            other => {
                self.restoring = other;
                None
            }
        };
        match answer.result {
            Ok(mut burst) => {
                self.engine.cancel(LaneKind::Detect);
                self.remember(&mut burst);
                self.model.messages.resolved("Open");
                self.model.messages.note(format!("Opened {}", describe_burst(&burst)));
                self.model.take_burst(burst);
                self.view = View::fit();
                self.forget_asked();
                if let Some(session) = session {
                    self.view = session.apply(&mut self.model);
                    self.restore_dataset(session.dataset.clone());
                    self.restore_trajectories(session.trajectories.clone());
                    if session.detected && self.model.needs_detection() {
                        self.start_detection();
                    }
                    if let Some(gold) = session.gold {
                        self.open_gold(gold, Side::A);
                    }
                    self.restore_pair(session.pair);
                }
            }
            Err(JobError::Cancelled) => self.model.messages.note("Opening cancelled"),
            Err(JobError::Several(_)) if session.is_none() => {
                if let Some((_, BurstSource::Paths(paths))) = self.opening.take_if(|(id, _)| *id == answer.id) {
                    self.open_dataset(DatasetSource::of_bursts(paths));
                }
            }
            Err(error) => self.model.messages.error("Open", error.to_string()),
        }
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

    /// Forgets what was asked for A's burst: another one is open.
    pub(super) fn forget_asked(&mut self) {
        (self.asked_picture, self.asked_patch) = (None, None);
        (self.failed_params, self.detecting_params) = (None, None);
    }

    /// Stops what is being opened, detected and matched.
    pub(super) fn cancel_all(&self) {
        self.engine.cancel(LaneKind::Detect);
        self.engine.cancel(LaneKind::Open);
        for lane in [PairLane::Open, PairLane::Detect, PairLane::Match] {
            self.engine.pair().cancel(lane);
        }
        self.engine.comparer().cancel();
    }

    fn wants_detection(&self) -> bool {
        self.model.needs_detection() && self.failed_params.as_ref() != Some(&self.model.params)
    }

    /// Starts a detection with the present parameters.
    pub(super) fn start_detection(&mut self) {
        if let Some(burst) = self.model.burst.clone() {
            self.detecting_params = Some(self.model.params.clone());
            self.engine.detect(DetectRequest { burst, params: self.model.params.clone() });
            self.model.busy.detecting = self.engine.running(LaneKind::Detect);
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

    fn step_play(&mut self, ctx: &egui::Context) {
        if !self.model.playing {
            return;
        }
        let now = Instant::now();
        let due = self.play_due.is_none_or(|due| now >= due);
        let (side, step) = (self.model.active_side(), self.play_step + 1);
        // The next slope waits for the picture of this one, so that a slow machine plays slowly and skips none.
        let stepped = self.model.on_side(side, |model| {
            let ready = due && model.picture_is_current();
            if ready {
                model.scrub.slope = played(&model.usable_params.slopes, step);
                model.slope_chosen = true;
                if model.scrub.kind == ViewKind::Frame {
                    model.scrub.kind = ViewKind::Stack;
                }
            }
            ready
        });
        if stepped {
            (self.play_step, self.play_due) = (step, Some(now + PLAY_EVERY));
        }
        ctx.request_repaint_after(PLAY_EVERY / 4);
    }

    fn request_what_is_missing(&mut self, ctx: &egui::Context) {
        if let Some(wanted) = self.model.wanted_picture()
            && !self.asked_picture.as_ref().is_some_and(|asked| asked.same_picture(&wanted))
        {
            self.engine.request_picture(wanted.clone());
            self.asked_picture = Some(wanted);
        }
        match self.model.wanted_patch() {
            Some(wanted) if !self.asked_patch.as_ref().is_some_and(|asked| asked.same_picture(&wanted)) => {
                self.engine.request_patch(wanted.clone());
                self.asked_patch = Some(wanted);
            }
            _ => {}
        }
        // While the hand still drags a parameter, every value on the way would start a detection for nothing.
        let dragging = ctx.input(|i| i.pointer.any_down());
        let asked = self.detecting_params.as_ref() == Some(&self.model.params);
        if self.model.auto_detect && !dragging && !asked && self.wants_detection() {
            self.start_detection();
        }
        self.request_for_pair(dragging);
        self.request_for_compare(dragging);
        self.thumbnails.request(&self.engine.datasets);
    }
}

/// A burst in a few words: its name, number of frames and size.
pub(super) fn describe_burst(open: &OpenBurst) -> String {
    let (width, height) = open.burst.size();
    let count = open.burst.len();
    let frames = if count == 1 { "frame" } else { "frames" };
    format!("{}: {count} {frames} of {width} × {height}", open.burst.name)
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
