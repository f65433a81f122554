//! The window: what it holds, and what it does in each pass. What goes to the engine and comes from it is in
//! `burst_work` and its neighbours.

use super::actions::{self, ActionId, Queue};
use super::canvas::Readout;
use super::dataset::thumbnails::Thumbnails;
use super::dialogs::{Desk, FileDialogs, SystemDialogs};
use super::inspector::{PaneWidgets, PlaceValue};
use super::measure::RegionCache;
use super::overlays::Overlays;
use super::pane::PaneId;
use super::session::Session;
use super::settings::Settings;
use crate::app::jobs::against::AgainstAsked;
use crate::app::jobs::compare::CompareAsked;
use crate::app::jobs::explain::ExplainAsked;
use crate::app::jobs::losses::LossesAsked;
use crate::app::jobs::pair::PairAsked;
use crate::app::jobs::panes::CursorsBefore;
use crate::app::jobs::probe::ProbeAsked;
use crate::app::panel::probe::ProbePanel;
use crate::app::panel::selection::SelectionState;
use crate::app::project::Model;
use crate::app::project::history;
use crate::app::project::pair::Side;
use crate::app::project::workspace::Workspace;
use crate::app::workspace::compare::ComparePictures;
use crate::app::workspace::pair::PairPanels;
use crate::dataset::DatasetSource;
use crate::detector::SearchParams;
use crate::engine::{BurstSource, Engine, JobId, OnUpdate, OpenBurst, PictureRequest};
use std::collections::HashMap;
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

/// What the engine is asked for and has not answered yet, so that it is not asked for again.
#[derive(Default)]
pub(super) struct Asked {
    /// What is being opened.
    pub opening: Option<(JobId, BurstSource)>,
    pub restoring: Option<(JobId, Box<Session>)>,
    pub pictures: HashMap<PaneId, PictureRequest>,
    pub patch: Option<PictureRequest>,
    pub detecting: Option<SearchParams>,
    /// What was looked for in vain.
    pub failed: Option<SearchParams>,
    pub probe: ProbeAsked,
}

/// Where playing through the slopes is.
#[derive(Default)]
pub(super) struct Play {
    pub step: usize,
    /// When the next slope is due.
    pub due: Option<Instant>,
}

/// The window.
pub struct BurstscopeApp {
    /// What is shown.
    pub model: Model,
    /// The workers.
    pub engine: Engine,
    /// What the panes' widgets keep.
    pub widgets: PaneWidgets,
    /// What the workspace of two bursts keeps.
    pub pair_panels: PairPanels,
    /// What the workspace of methods keeps.
    pub compare_pictures: ComparePictures,
    pub(super) selection: SelectionState,
    pub(super) probe: ProbePanel,
    /// What was computed of the rectangle that is measured.
    pub(super) regions: RegionCache,
    pub(super) thumbnails: Thumbnails,
    pub(super) overlays: Overlays,
    pub(super) asked: Asked,
    pub(super) pair_asked: PairAsked,
    pub(super) compare_asked: CompareAsked,
    pub(super) explain_asked: ExplainAsked,
    pub(super) against_asked: AgainstAsked,
    pub(super) losses_asked: LossesAsked,
    pub(super) play: Play,
    /// Whether cursors were set on purpose, each to its own place, so that none follows another.
    pub(super) cursors_set: bool,
    /// Whether what is set was changed otherwise than by a step that can be undone.
    pub(super) history_set: bool,
    pub(super) desk: Desk,
    settings: Settings,
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
        (model.auto_detect, model.figure) = (startup.settings.auto_detect, startup.settings.figure);
        (model.pair.links, model.pair.look) = (startup.settings.links, startup.settings.match_look.sanitised());
        model.link_ranges(model.pair.links.ranges);
        model.check_params();
        let mut app = Self {
            model,
            engine: Engine::new(on_update.clone(), startup.cache_bytes),
            widgets: PaneWidgets::default(),
            pair_panels: PairPanels::default(),
            compare_pictures: ComparePictures::default(),
            selection: SelectionState::default(),
            probe: ProbePanel::default(),
            regions: RegionCache::default(),
            thumbnails: Thumbnails::default(),
            overlays: Overlays::default(),
            asked: Asked::default(),
            pair_asked: PairAsked::default(),
            compare_asked: CompareAsked::default(),
            explain_asked: ExplainAsked::default(),
            against_asked: AgainstAsked::default(),
            losses_asked: LossesAsked::default(),
            play: Play::default(),
            cursors_set: false,
            history_set: false,
            desk: Desk::new(startup.dialogs, on_update),
            settings: startup.settings,
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
        self.asked.restoring = None;
        self.asked.opening = Some((self.engine.open(source.clone()), source));
    }

    /// Whether everything that is wanted is there and nothing runs.
    pub fn is_settled(&self) -> bool {
        self.engine.is_idle()
            && !self.desk.is_asking()
            && self.model.pictures_are_current()
            && !self.thumbnails.is_waiting()
            && !(self.model.auto_detect && self.wants_detection())
            && self.pair_is_settled()
            && self.probe_is_settled()
            && self.compare_is_settled()
            && self.explanations_are_settled()
            && self.comparison_is_settled()
    }

    /// Draws the window and answers what happened since the last time.
    pub fn show(&mut self, ui: &mut egui::Ui) {
        let ctx = ui.ctx().clone();
        ctx.set_theme(self.model.theme);
        let cursors_before = CursorsBefore::of(&self.model);
        self.take_updates(&ctx);
        self.take_probe_updates();
        self.take_pair_updates();
        self.take_compare_updates();
        self.take_explanations();
        self.take_against_updates();
        self.take_losses();
        self.take_answers();
        self.take_dropped_files(&ctx);
        let before = history::Settings::of(&self.model);
        let mut queue = Queue::new();
        // While a dialog is open, or is being opened by the system, keys are for it alone.
        if !self.modal_is_open() && !self.desk.is_asking() {
            actions::take_shortcuts(&ctx, &self.model, &mut queue);
            if ctx.input_mut(|i| i.consume_shortcut(&actions::registry::PALETTE_ALSO)) {
                queue.push(ActionId::Palette);
            }
            self.take_copy(&ctx);
        }
        self.step_play(&ctx);
        super::shell::shell_ui(self, ui, &mut queue);
        self.overlays_ui(&ctx, &mut queue);
        for id in queue {
            self.run_action(&ctx, id);
        }
        self.model.check_params();
        self.model.check_pair();
        if !std::mem::take(&mut self.cursors_set) {
            cursors_before.lead(&mut self.model);
        }
        self.keep_history(&ctx, before);
        self.model.refresh_listed();
        self.model.pair.refresh_listed();
        self.request_what_is_missing(&ctx);
    }

    /// Adds what a person has changed in this pass to what can be undone.
    fn keep_history(&mut self, ctx: &egui::Context, before: history::Settings) {
        if std::mem::take(&mut self.history_set) {
            return;
        }
        let after = history::Settings::of(&self.model);
        let goes_on = self.model.playing || ctx.egui_wants_keyboard_input() || ctx.input(|i| i.pointer.any_down());
        self.model.history.take(before, &after, goes_on);
    }

    /// Puts a burst at the top of the recent ones. One of the dataset is remembered with it, and has the name that it
    /// has there.
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
        self.widgets.pos_ui(self.model.focus(), pos_image)
    }

    /// The same in the pane of the burst of `side`.
    pub fn ui_from_image_of(&self, side: Side, pos_image: egui::Pos2) -> Option<egui::Pos2> {
        self.widgets.pos_ui(PaneId::of(side), pos_image)
    }

    /// The value under the pointer; with several panes those of all that are linked.
    pub(super) fn readout(&self) -> Option<String> {
        if self.model.workspace == Workspace::Inspect && self.model.panes.are_many() {
            let (first, rest) = self.widgets.values.split_first()?;
            let value = |v: &PlaceValue| format!("{}: {}", v.number, v.readout.short_text());
            let values: Vec<String> = std::iter::once(first).chain(rest).map(value).collect();
            return Some(format!("u {:.1}  v {:.1}   {}", first.readout.u, first.readout.v, values.join("  ")));
        }
        let readouts = self.model.visible_panes().into_iter().filter_map(|id| self.widgets.get(id)?.picture.readout);
        readouts.into_iter().next().map(|readout: Readout| readout.to_string())
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
