//! The window: its state, the steps of each pass, and its layout. What a part changes beyond what it owns comes back as
//! an [`Effect`], which `effects` applies.

use super::actions::menu::menu_bar_ui;
use super::actions::{ActionId, Queue};
use super::dataset::filmstrip::Thumbnails;
use super::dataset::{cut_offer_ui, filmstrip};
use super::dialogs::{FileAnswer, FileChooser, Question};
use super::document::{Document, Journal, Playback};
use super::files::drop_places;
use super::inspector::{PaneWidgets, PlaceValue, is_led};
use super::lesson::{LessonAction, Lessons, lesson_ui, rings_ui, take_hall_keys};
use super::overlays::Overlays;
use super::panel::modals::about_ui;
use super::recovery::Recovery;
use super::session::Restoring;
use super::settings::Settings;
use super::startup::{EndRequest, Startup};
use super::workspace::{WorkspaceParts, switch_ui, workspace_ui};
use super::{actions, clipboard, panel, parts};
use crate::app::apply::{asking, explained, methods, pair, panes, params};
use crate::app::document::{ExportKind, Purpose, Side};
use crate::app::results::{Effect, Model, Read};
use crate::app::view::fixed;
use crate::engine::{Engine, OnUpdate};
use crate::requests::BurstSource;
use crate::teach::Part;
use egui::{CentralPanel, Frame, Margin, Panel, Ui};
use std::sync::Arc;

pub struct BurstscopeApp {
    pub model: Model,
    pub engine: Engine,
    pub widgets: PaneWidgets,
    pub(super) thumbnails: Thumbnails,
    pub(super) overlays: Overlays,
    pub(super) restoring: Restoring,
    pub(super) journal: Journal,
    /// Steps that are done again, as soon as the window has settled after the one before.
    pub(super) playback: Option<Playback>,
    pub lessons: Lessons,
    pub(super) chooser: FileChooser,
    pub(super) recovery: Option<Recovery>,
    pub(super) lost_device: Option<String>,
    pub(super) end: EndRequest,
    pub(super) is_ending: bool,
    pub settings: Settings,
    title: String,
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
        let begins = startup.actions();
        let mut app = Self {
            model: Model::from(Document::of_new_window()),
            engine: Engine::new(on_update.clone(), startup.settings.cache_bytes()),
            widgets: PaneWidgets::default(),
            thumbnails: Thumbnails::default(),
            overlays: Overlays::default(),
            restoring: Restoring::default(),
            journal: Journal::default(),
            playback: startup.play.map(|steps| Playback { steps, ..Playback::default() }),
            lessons: Lessons { progress: startup.settings.lessons.clone(), ..Lessons::default() },
            chooser: FileChooser::new(startup.dialogs, on_update),
            recovery: None,
            lost_device: None,
            end: startup.end,
            is_ending: false,
            settings: startup.settings,
            title: String::new(),
        };
        app.recovery = Recovery::begin(startup.kept.as_ref(), &mut app.model.shell.messages);
        for action in begins.0 {
            app.run(ctx, action);
            app.journal.close(false);
        }
        params::check_params(&mut app.model);
        app.model.shell.history = Default::default();
        if let Some(path) = startup.session {
            app.apply([Effect::UseFiles(Purpose::RestoreSession, vec![path])]);
        }
        app.lessons.add(startup.lessons);
        if let Some(lesson) = startup.lesson {
            app.start_lesson(lesson);
        }
        app
    }

    pub fn is_settled(&self) -> bool {
        self.rests() && self.playback.as_ref().is_none_or(|playback| playback.steps.is_empty())
    }

    pub(super) fn rests(&self) -> bool {
        self.engine.is_idle()
            && !self.chooser.is_asking()
            && Read::of(&self.model).is_settled()
            && !self.thumbnails.is_waiting()
            && self.lessons.is_settled(Read::of(&self.model))
    }

    pub fn is_asking(&self) -> bool {
        self.chooser.is_asking()
    }

    pub fn show(&mut self, ui: &mut Ui) {
        let ctx = ui.ctx().clone();
        ctx.set_theme(self.model.document.theme);
        self.model.shell.window_width_points = ctx.content_rect().width();
        methods::refresh_workspace(&mut self.model);
        let title = self.read().title();
        if self.title != title {
            self.title.clone_from(&title);
            ctx.send_viewport_cmd(egui::ViewportCommand::Title(title));
        }
        self.take_answers(&ctx);
        self.take_dropped_files(&ctx);
        let (mut queue, in_hall) = (Queue::default(), self.model.document.panels.hall);
        let mut asked = None;
        // While a dialog is open, or is being opened by the system, only the dialog gets keys.
        let recovery_asks = self.recovery.as_ref().is_some_and(|recovery| recovery.is_asking);
        if !self.overlays.are_modal(&self.lessons) && !recovery_asks && !self.chooser.is_asking() {
            self.overlays.glossary.take_escape(&ctx);
            asked = take_hall_keys(&ctx, &self.lessons, self.read());
            actions::take_shortcuts(&ctx, self.read(), &mut queue);
            queue.push_if(ctx.input_mut(|i| i.consume_shortcut(&actions::registry::PALETTE_ALSO)), ActionId::Palette);
            if clipboard::is_asked(&ctx) {
                self.note(clipboard::copy_row(&ctx, self.read(), &self.widgets));
            }
        }
        let plays_on = self.play_step(&ctx);
        // Pictures that were played are among what is done again.
        if self.playback.is_none()
            && let Some((next, rest)) = panes::step_play(&mut self.model)
        {
            next.into_iter().for_each(|next| queue.push(next));
            ctx.request_repaint_after(rest);
        }
        asked = self.layout_ui(ui, &mut queue).or(asked);
        if !self.overlays.are_modal(&self.lessons) {
            rings_ui(&ctx, &self.lessons, Read::of(&self.model), &self.widgets);
        }
        about_ui(&ctx, &mut self.overlays.about_open, &self.engine, &mut self.settings);
        let shown = (Read::of(&self.model), &self.widgets);
        let effects = self.overlays.ui(&ctx, shown, &self.settings, &mut self.lessons, &mut queue);
        self.apply(effects);
        self.act(&ctx, queue);
        self.go_on_with_lesson(&ctx, asked);
        params::check_params(&mut self.model);
        let is_led = ctx.input(|i| i.pointer.any_down()) || is_led(&ctx);
        let goes_on = plays_on || ctx.egui_wants_keyboard_input() || is_led;
        self.model.shell.history.close_step(&self.model.document, goes_on);
        self.journal.close(goes_on || self.model.document.playing);
        explained::refresh_listed(&mut self.model);
        pair::refresh_listed_matches(&mut self.model);
        let (panes, pictures) = (&self.model.document.panes, &mut self.model.results.pictures);
        self.widgets.retain(|id| panes.get(id).is_some());
        pictures.retain(|id, _| panes.get(*id).is_some());
        asking::ask(&mut self.model, &self.engine, ctx.input(|i| i.pointer.any_down()));
        if let Some(dataset) = &self.model.results.datasets.open {
            self.thumbnails.request(&self.engine, &dataset.open);
        }
        self.keep_session(&ctx);
        if self.model.document.panels.hall != in_hall {
            ctx.send_viewport_cmd(egui::ViewportCommand::Fullscreen(!in_hall));
        }
    }

    fn take_answers(&mut self, ctx: &egui::Context) {
        let effects = asking::take_answers(&mut self.model, &self.engine);
        self.apply(effects);
        if let Some(dataset) = &self.model.results.datasets.open {
            self.thumbnails.take_made(ctx, &dataset.bursts);
        }
        for done in self.engine.take_tasks() {
            let messages = &mut self.model.shell.messages;
            if self.recovery.as_mut().is_some_and(|recovery| recovery.has_kept(&done, messages)) {
                continue;
            }
            match done.result {
                Ok(text) => {
                    messages.note(text);
                    if done.label == Purpose::Export(ExportKind::Mask).title()
                        && let Some(path) = self.overlays.mask.take()
                    {
                        self.overlays.calibration_draft(&self.model.document.calibration).mask = Some(path);
                    }
                }
                Err(error) => messages.error(done.label, error.to_string()),
            }
        }
        for answer in self.chooser.take_answers() {
            match answer {
                FileAnswer::Chosen(purpose, paths) => self.apply([Effect::UseFiles(purpose, paths)]),
                FileAnswer::Nothing(Question { purpose, suggested_name, .. }) => {
                    let why = "the dialog ended without a file";
                    self.model.shell.messages.note_unanswered(purpose, suggested_name, why);
                }
                FileAnswer::NoDialog(Question { purpose, suggested_name, .. }) => {
                    self.overlays.open_path_field(purpose, suggested_name, true);
                }
            }
        }
    }

    fn go_on_with_lesson(&mut self, ctx: &egui::Context, mut asked: Option<LessonAction>) {
        loop {
            let is_restoring = self.restoring.waits_for(Read::of(&self.model)).is_some();
            let staged = self.lessons.go_on(asked.take(), is_restoring, Read::of(&self.model));
            if staged.is_empty() {
                break;
            }
            self.stage(staged);
        }
        parts::want(ctx, self.lessons.highlighted(), self.lessons.open.as_ref().map(|open| open.step));
    }

    fn keep_session(&mut self, ctx: &egui::Context) {
        let waits_for = self.restoring.waits_for(Read::of(&self.model));
        let Some(recovery) = &mut self.recovery else { return };
        // A session is given up when something else is opened in its burst's place.
        recovery.restoring = recovery.restoring.filter(|restoring| Some(*restoring) == waits_for);
        // A burst that is being opened would be missing; the session is saved in a pass after that.
        if self.model.results.slots.both().into_iter().any(|slot| slot.opening.is_pending()) {
            return;
        }
        if let Some(rest) = recovery.keep(Read::of(&self.model).project_of_user(), &self.journal, &self.engine) {
            ctx.request_repaint_after(rest);
        }
    }

    /// Saves the session at once: another window goes on with it, and if that fails it is offered later.
    pub(super) fn keep_session_now(&mut self) {
        let Some(recovery) = &self.recovery else { return };
        if let Err((title, error)) = recovery.keep_now(Read::of(&self.model).project_of_user(), &self.journal) {
            self.model.shell.messages.error(title, error);
        }
    }

    fn layout_ui(&mut self, ui: &mut Ui, queue: &mut Queue) -> Option<LessonAction> {
        let bar = |ui: &Ui| Frame::side_top_panel(ui.style()).inner_margin(Margin::symmetric(8, 3));
        Panel::top("menu bar").frame(bar(ui)).show(ui, |ui| {
            ui.horizontal(|ui| {
                menu_bar_ui(ui, Read::of(&self.model), &self.settings, queue);
                switch_ui(ui, Read::of(&self.model), queue);
            });
        });
        let in_toolbar = |part: &Part| matches!(part, Part::Kinds | Part::Detect);
        if !self.model.document.panels.hall || self.lessons.highlighted().iter().any(in_toolbar) {
            let toolbar_ui = |ui: &mut Ui| panel::toolbar::toolbar_ui(ui, self.read(), queue);
            Panel::top("toolbar").frame(bar(ui)).show(ui, toolbar_ui);
        }
        let status = Panel::bottom("status bar").frame(bar(ui));
        let readout = self.readout();
        let status_ui = |ui: &mut Ui| panel::status::status_ui(ui, Read::of(&self.model), readout.as_deref(), queue);
        let types_path = !self.model.document.panels.hall && status.show(ui, status_ui).inner;
        if let Some((purpose, name)) = self.model.shell.messages.unanswered.as_ref().filter(|_| types_path).cloned() {
            self.overlays.open_path_field(purpose, name, false);
            self.model.shell.messages.forget_note();
        }
        self.offers_ui(ui, bar(ui), queue);
        if self.model.results.datasets.open.is_some() && self.model.document.panels.filmstrip {
            Panel::bottom("filmstrip").frame(bar(ui)).exact_size(filmstrip::HEIGHT).show(ui, |ui| {
                filmstrip::filmstrip_ui(ui, Read::of(&self.model), &mut self.thumbnails, queue);
            });
        }
        let asked = self.lesson_panel_ui(ui, queue);
        let mut start_lesson = None;
        if self.model.results.slots.a.burst.is_none() && self.model.document.workspace.needs_burst() {
            let page_ui =
                |ui: &mut Ui| panel::welcome::welcome_ui(ui, self.read(), &self.settings, &self.lessons, queue);
            start_lesson = CentralPanel::default().show(ui, page_ui).inner;
        } else {
            let (model, widgets) = (Read::of(&self.model), &mut self.widgets);
            workspace_ui(ui, &mut WorkspaceParts { model, widgets, queue });
            if let Some(rect_ui) = self.widgets.rect_ui(self.model.document.focus()) {
                start_lesson = panel::welcome::card_ui(ui.ctx(), self.read(), &self.lessons, rect_ui, queue);
            }
        }
        self.drop_hint_ui(ui);
        self.apply(start_lesson.map(Effect::StartLesson));
        asked
    }

    fn offers_ui(&mut self, ui: &mut Ui, bar: Frame, queue: &mut Queue) {
        let offer_ui = |offer, ui: &mut Ui| panel::status::recovery_ui(ui, &offer);
        if let Some(recovery) = &mut self.recovery
            && let Some(offer) = recovery.offer()
            && let Some(choice) = Panel::top("recovery offer").frame(bar).show(ui, |ui| offer_ui(offer, ui)).inner
            && let Some(path) = recovery.settle(choice, &mut self.model.shell.messages)
        {
            self.apply([Effect::UseFiles(Purpose::RestoreSession, vec![path])]);
            let waits_for = self.restoring.waits_for(Read::of(&self.model));
            self.recovery.iter_mut().for_each(|recovery| recovery.restoring = waits_for);
        }
        if let Some(own) = &self.model.results.left_behind {
            Panel::top("left behind").frame(bar).show(ui, |ui| panel::status::left_behind_ui(ui, own, queue));
        }
        let open = self.read().burst_of(Side::A).map(|open| open.id);
        if self.read().is_film() && self.overlays.stays_whole != open && self.overlays.cut.is_none() {
            let (frames, length) = (self.read().frame_count(), self.settings.burst_length);
            let offer_ui = |ui: &mut Ui| cut_offer_ui(ui, frames, length, queue);
            if Panel::top("cut offer").frame(bar).show(ui, offer_ui).inner {
                self.overlays.stays_whole = open;
            }
        }
    }

    fn lesson_panel_ui(&mut self, ui: &mut Ui, queue: &mut Queue) -> Option<LessonAction> {
        self.lessons.open.as_ref()?;
        let (id, width) = if self.model.document.panels.hall {
            ("lesson in hall", (0.35 * ui.available_width()).clamp(300.0, 520.0))
        } else {
            ("lesson", (0.27 * ui.available_width()).clamp(290.0, 360.0))
        };
        let frame = Frame::side_top_panel(ui.style()).inner_margin(Margin { left: 12, right: 10, top: 8, bottom: 2 });
        let panel = Panel::right(id).frame(frame).default_size(width).size_range(270.0..=520.0);
        panel.show(ui, |ui| lesson_ui(ui, &mut self.lessons, Read::of(&self.model), queue)).inner
    }

    fn drop_hint_ui(&self, ui: &Ui) {
        let hint = |side: Side| if side == Side::A { "Let go to open as A" } else { "Let go to open as B" };
        let places = drop_places(self.read(), &self.widgets).into_iter();
        let mut hints: Vec<_> = places.map(|(rect, side)| (rect, hint(side))).collect();
        if hints.is_empty() {
            hints.push((ui.ctx().content_rect(), "Let go to open"));
        }
        panel::welcome::drop_hint_ui(ui.ctx(), &hints);
    }

    pub fn read(&self) -> Read<'_> {
        Read::of(&self.model)
    }

    fn readout(&self) -> Option<String> {
        if self.model.document.panes.are_many() {
            let first = &self.widgets.values.first()?.readout;
            let value = |v: &PlaceValue| format!("{}: {}", v.number, v.readout.short_text());
            let values: Vec<String> = self.widgets.values.iter().map(value).collect();
            let [u, v] = [first.u, first.v].map(|at| fixed(at, 1));
            return Some(format!("u {u}  v {v}   {}", values.join("  ")));
        }
        let mut shown = self.model.document.panes.shown().into_iter();
        shown.find_map(|id| self.widgets.get(id)?.picture.readout).map(|readout| readout.to_string())
    }

    pub fn asks_for_shape(&self) -> bool {
        self.overlays.shape.is_open()
    }

    pub fn choice(&self) -> &[BurstSource] {
        &self.overlays.choice
    }

    /// Saves the session, in case no other device is found, and closes the window to be opened again.
    fn leaves_lost_device(&mut self, ctx: &egui::Context) -> bool {
        let gpu = super::gpu::Gpu::of(ctx);
        let Some(why) = gpu.as_ref().and_then(super::gpu::Gpu::lost) else { return false };
        self.lose_device(why);
        ctx.send_viewport_cmd(egui::ViewportCommand::Close);
        true
    }

    pub(super) fn lose_device(&mut self, why: &str) {
        if self.lost_device.is_none() {
            self.lost_device = Some(why.to_owned());
            self.keep_session_now();
        }
    }

    /// Whether the window was asked to end from outside. If so, saves its session and closes it.
    fn leaves_when_asked(&mut self, ctx: &egui::Context) -> bool {
        if !self.end.is_made() {
            return false;
        }
        if !std::mem::replace(&mut self.is_ending, true) {
            self.keep_session_now();
        }
        ctx.send_viewport_cmd(egui::ViewportCommand::Close);
        true
    }

    pub(super) fn take_lost_device(&mut self) -> Option<String> {
        let why = self.lost_device.take()?;
        let text = format!("the driver gave it up ({why}); the window was opened again, and nothing else has changed");
        self.model.shell.messages.error("Graphics device lost", text);
        Some(why)
    }
}

impl eframe::App for BurstscopeApp {
    fn ui(&mut self, ui: &mut Ui, _frame: &mut eframe::Frame) {
        // Drawing on a lost device fails, so nothing is drawn.
        if !self.leaves_lost_device(ui.ctx()) && !self.leaves_when_asked(ui.ctx()) {
            self.show(ui);
        }
    }

    fn save(&mut self, storage: &mut dyn eframe::Storage) {
        // Settings made by a lesson are not stored.
        self.settings.take_from(Read::of(&self.model).project_of_user().document);
        (self.settings.theme, self.settings.lessons) = (self.model.document.theme, self.lessons.progress.clone());
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
