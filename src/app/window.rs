//! The window: its state, and the steps of each pass. Requests to the engine and its answers are in
//! `jobs`.

mod reading;

use super::actions::{self, ActionId, Queue};
use super::dataset::thumbnails::Thumbnails;
use super::dialogs::Desk;
use super::ending::EndRequest;
use super::inspector::PaneWidgets;
use super::lesson::{Captions, Lessons};
use super::measure::RegionCache;
use super::overlays::Overlays;
use super::recovery::Recovery;
use super::settings::Settings;
use super::startup::Startup;
use crate::app::jobs::opening::Restoring;
use crate::app::jobs::panes::CursorBefore;
use crate::app::panel::probe::{PlaneTexture, ProbePanel};
use crate::app::panel::selection::SelectionState;
use crate::app::project::Model;
use crate::app::project::history;
use crate::app::project::pair::Side;
use crate::app::workspace::pair::PairPanels;
use crate::engine::{Engine, OnUpdate};
use crate::requests::OpenBurst;
use std::sync::Arc;
use std::time::Instant;

/// Progress of playing through the slopes.
#[derive(Default)]
pub(super) struct Play {
    pub step: usize,
    /// When the next slope is due.
    pub due: Option<Instant>,
}

/// The window.
pub struct BurstscopeApp {
    /// The model: everything that is shown.
    pub model: Model,
    /// The workers.
    pub engine: Engine,
    /// State of the panes' widgets.
    pub widgets: PaneWidgets,
    /// State of the panels of the workspace of two bursts.
    pub pair_panels: PairPanels,
    pub(super) selection: SelectionState,
    pub(super) probe: ProbePanel,
    /// The Lab's chart as a texture.
    pub(super) lab_picture: PlaneTexture,
    /// Computed values of the measured rectangle.
    pub(super) regions: RegionCache,
    pub(super) thumbnails: Thumbnails,
    pub(super) overlays: Overlays,
    pub(super) restoring: Restoring,
    pub(super) play: Play,
    /// Whether cursors were set explicitly, each to its own place, so that none follows another.
    pub(super) cursors_set: bool,
    /// Whether settings were changed by something other than a step that can be undone.
    pub(super) history_set: bool,
    /// The lessons, and the one that is open.
    pub lessons: Lessons,
    pub(super) captions: Captions,
    pub(super) desk: Desk,
    pub(super) recovery: Option<Recovery>,
    /// Reason why the device that drew the window was lost, until another draws it.
    pub(super) lost_device: Option<String>,
    /// Asks the window to end from outside.
    pub(super) end: EndRequest,
    /// Whether the window is ending.
    pub(super) is_ending: bool,
    settings: Settings,
}

impl BurstscopeApp {
    /// Creates a window in `ctx`. Float pictures need `render_state`; without it everything else works.
    pub fn new(ctx: &egui::Context, render_state: Option<&egui_wgpu::RenderState>, startup: Startup) -> Self {
        if let Some(render_state) = render_state {
            super::gpu::install(ctx, render_state);
        }
        super::style::apply(ctx);
        startup.end.wakes(ctx);
        let waker = ctx.clone();
        let on_update: OnUpdate = Arc::new(move || waker.request_repaint());
        let mut model = Model::default();
        model.set_search(startup.params);
        model.calibration = startup.calibration;
        model.slots.a.usable_params = model.params.clone();
        (model.theme, model.panels) = (startup.settings.theme, startup.settings.panels);
        (model.auto_detect, model.figure) = (startup.settings.auto_detect, startup.settings.figure);
        model.pair.look = startup.settings.match_look.sanitised();
        model.set_pair_links(startup.settings.links);
        model.check_params();
        let mut app = Self {
            model,
            engine: Engine::new(on_update.clone(), startup.cache_bytes),
            widgets: PaneWidgets::default(),
            pair_panels: PairPanels::default(),
            selection: SelectionState::default(),
            probe: ProbePanel::default(),
            lab_picture: PlaneTexture::default(),
            regions: RegionCache::default(),
            thumbnails: Thumbnails::default(),
            overlays: Overlays::default(),
            restoring: Restoring::default(),
            play: Play::default(),
            cursors_set: false,
            history_set: false,
            lessons: Lessons { progress: startup.settings.lessons.clone(), ..Lessons::default() },
            captions: Captions::default(),
            desk: Desk::new(startup.dialogs, on_update),
            recovery: None,
            lost_device: None,
            end: startup.end,
            is_ending: false,
            settings: startup.settings,
        };
        app.begin_keeping_session(startup.kept.as_ref());
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
        app.lessons.add(startup.lessons);
        if let Some(lesson) = startup.lesson {
            app.start_lesson(lesson);
        }
        app
    }

    /// Whether everything that is wanted is there and no work runs.
    pub fn is_settled(&self) -> bool {
        self.engine.is_idle()
            && !self.desk.is_asking()
            && self.model.is_settled()
            && !self.thumbnails.is_waiting()
            && self.lesson_is_settled()
    }

    /// Whether a dialog for files is open.
    pub fn is_asking(&self) -> bool {
        self.desk.is_asking()
    }

    /// Runs one pass: takes answers and input, draws the window, and requests what is missing.
    pub fn show(&mut self, ui: &mut egui::Ui) {
        let ctx = ui.ctx().clone();
        ctx.set_theme(self.model.theme);
        self.model.refresh_workspace();
        let cursor_before = CursorBefore::of(&self.model);
        self.take_updates(&ctx);
        self.take_answers();
        self.take_dropped_files(&ctx);
        let before = history::Settings::of(&self.model);
        let mut queue = Queue::new();
        // While a dialog is open, or is being opened by the system, only the dialog gets keys.
        if !self.modal_is_open() && !self.desk.is_asking() {
            actions::take_shortcuts(&ctx, &self.model, &mut queue);
            if ctx.input_mut(|i| i.consume_shortcut(&actions::registry::PALETTE_ALSO)) {
                queue.push(ActionId::Palette);
            }
            self.take_copy(&ctx);
        }
        self.step_play(&ctx);
        let wish = super::shell::shell_ui(self, ui, &mut queue);
        self.overlays_ui(&ctx, &mut queue);
        for id in queue {
            self.run_action(&ctx, id);
            self.model.refresh_workspace();
        }
        self.go_on_with_lesson(&ctx, wish);
        self.model.check_params();
        self.model.check_pair();
        if !std::mem::take(&mut self.cursors_set) {
            cursor_before.lead(&mut self.model);
        }
        self.keep_history(&ctx, before);
        self.model.refresh_listed();
        self.model.pair.refresh_listed();
        self.request_what_is_missing(&ctx);
        self.keep_session(&ctx);
    }

    /// Records the user's changes of this pass in the history, for undo.
    fn keep_history(&mut self, ctx: &egui::Context, before: history::Settings) {
        if std::mem::take(&mut self.history_set) {
            return;
        }
        let after = history::Settings::of(&self.model);
        let goes_on = self.model.playing || ctx.egui_wants_keyboard_input() || ctx.input(|i| i.pointer.any_down());
        self.model.history.take(before, &after, goes_on);
    }

    /// Puts a burst at the top of the recent list. A burst of the open dataset is not listed, and gets its name in the
    /// dataset.
    pub(super) fn remember(&mut self, burst: &mut OpenBurst) {
        match &self.model.datasets.open {
            Some(dataset) if dataset.place_of(Some(burst)).is_some() => dataset.name_as_here(burst),
            _ => self.settings.remember(&burst.source),
        }
    }

    pub(super) fn go_to_selected(&mut self) {
        let Some(feature) = self.model.selected_feature().copied() else { return };
        self.model.focus_on_side(Side::A);
        self.model.playing = false;
        let pane = self.model.focused_mut();
        pane.cursor.slope = feature.slope;
        pane.show_slope();
        let before = pane.view;
        pane.view.look_at(egui::pos2(feature.u, feature.v), 60.0 / feature.sigma.max(1.0));
        let focus = self.model.focus();
        self.model.panes.follow_view(focus, &before);
    }
}

impl eframe::App for BurstscopeApp {
    fn ui(&mut self, ui: &mut egui::Ui, _frame: &mut eframe::Frame) {
        // Drawing on a lost device fails, so nothing is drawn.
        if !self.leaves_lost_device(ui.ctx()) && !self.leaves_when_asked(ui.ctx()) {
            self.show(ui);
        }
    }

    fn save(&mut self, storage: &mut dyn eframe::Storage) {
        // Settings made by a lesson are not stored.
        self.settings.take_from(self.lessons.open.as_ref().map_or(&self.model, |open| open.before()));
        (self.settings.theme, self.settings.lessons) = (self.model.theme, self.lessons.progress.clone());
        self.settings.store(storage);
    }

    fn on_exit(&mut self) {
        // With a lost device only the drawing ends: the window is opened again, or its session is offered at the next
        // start. After a request from outside the session is offered too.
        if let (Some(recovery), None, false) = (&self.recovery, &self.lost_device, self.end.is_made()) {
            recovery.end();
        }
    }
}
