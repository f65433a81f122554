//! A window for tests, and the actions of a user on it.

// Names that most tests of the window use.
pub use crate::shared::{Folder, folder, folder_with};
pub use burstscope::app::canvas::Zoom;
pub use burstscope::app::document::{
    Action, Compared, Document, FeaturesShown, FilmContent, Filter, Interval, MatchColumn, MatchesAs, MethodId, Order,
    PairColumn, PairTab, Panels, Purpose, Queue, Reference, Reselect, SavedSelection, SetUpState, Side, Steps,
    Trajectories, Visibility, cursor::ViewKind,
};
pub use burstscope::app::messages::Message;
pub use burstscope::app::pane::{Content, Over, PaneId};
pub use burstscope::app::results::{FoundFeatures, Matches, Model, Read, Results, datasets::BurstState};
pub use burstscope::app::{Startup, apply, session::Session, settings::Settings};
pub use burstscope::burst::OpenOptions;
pub use burstscope::dataset::{FeatureJob, FeatureStore, ImageKind};
pub use burstscope::detector::{
    Descriptor, Detection, DetectorParams, Feature, FrameRange, Method, Moves, NoiseGate, Quantity, SearchParams,
    Slope, SlopeAxis, SlopeGrid, SlopeVerdict, Slopes, Tally, Test,
};
pub use burstscope::inspect::{ProbeCache, place::Verdict};
pub use burstscope::matching::{MatchCounts, MatchParams, PairSelection};
pub use burstscope::requests::{
    BurstSource, ComparedPoses, Detected, JobError, OpenBurst, PictureKind, PictureRequest, Probed, ReadTrajectory,
    Request, Urgency, Which, Work,
};
pub use burstscope::synth::Example;
pub use burstscope::teach::{
    Between, BottomTab, Goal, GoalValue, InView, Layout, Lesson, Near, Part, Step, Workspace, built_in, sheet,
};
pub use burstscope::{Burst, Monitor, Plane};
pub use egui::{Key, Modifiers, Pos2, Rect, Vec2, accesskit::Role, pos2, vec2};
pub use egui_kittest::{Harness, kittest::NodeT, kittest::Queryable};
pub use image::RgbaImage;
pub use ndarray::Array3;
pub use std::{collections::BTreeSet, fs, path::Path, path::PathBuf, sync::Arc, time::Duration};

use crate::{harness as common, pictures};
use burstscope::app::{BurstscopeApp, dialogs::FileDialogs, dialogs::Question};
use std::{collections::HashMap, collections::VecDeque, sync::Mutex, time::Instant};

const PATIENCE: Duration = Duration::from_secs(120);

/// Dialogs that answer from a list; an empty list is a system without dialogs.
#[derive(Default, Clone)]
pub struct Scripted(Arc<Mutex<VecDeque<Option<PathBuf>>>>);

impl Scripted {
    pub fn will_choose(&self, path: impl Into<PathBuf>) {
        self.0.lock().unwrap().push_back(Some(path.into()));
    }

    pub fn will_end(&self) {
        self.0.lock().unwrap().push_back(None);
    }
}

impl FileDialogs for Scripted {
    fn exist(&self) -> bool {
        !self.0.lock().unwrap().is_empty()
    }

    fn ask(&self, _: &Question) -> Option<Vec<PathBuf>> {
        self.0.lock().unwrap().pop_front().flatten().map(|p| vec![p])
    }
}

/// Storage of the program's settings, in memory instead of a file.
#[derive(Default)]
pub struct Memory(HashMap<String, String>);

impl eframe::Storage for Memory {
    fn get_string(&self, key: &str) -> Option<String> {
        self.0.get(key).cloned()
    }
    fn set_string(&mut self, key: &str, value: String) {
        self.0.insert(key.to_owned(), value);
    }
    fn remove_string(&mut self, key: &str) {
        self.0.remove(key);
    }
    fn flush(&mut self) {}
}

pub struct Window {
    pub harness: Harness<'static, BurstscopeApp>,
    pub dialogs: Scripted,
}

pub struct Start {
    pub size: [f32; 2],
    pub pixels_per_point: f32,
    pub startup: Startup,
}

impl Default for Start {
    fn default() -> Self {
        Self { size: [1280.0, 720.0], pixels_per_point: 1.0, startup: given() }
    }
}

/// Settings of a window with all panels open, in which tests reach every part.
fn all_open() -> Settings {
    Settings { panels: Panels::all(), ..Settings::default() }
}

/// The demo, searched at the default slopes: for tests of given slopes.
pub fn given() -> Startup {
    let params = SearchParams { slopes: SlopeGrid::default().into(), ..SearchParams::default() };
    Startup { params, settings: all_open(), ..Startup::default() }
}

/// Lets worker processes decode raw files, as the window of the program does.
fn with_decode_worker() {
    use burstscope::burst::DecodeWorker;
    let program = PathBuf::from(env!("CARGO_BIN_EXE_burstscope"));
    // All windows of these tests share the worker; the first setting stays.
    DecodeWorker { program, arguments: vec![burstscope::cli::DECODE_WORKER.into()] }.install();
}

impl Start {
    pub fn automatic() -> Self {
        Self { startup: Startup { settings: all_open(), ..Startup::default() }, ..Self::default() }
    }

    pub fn first(size: [f32; 2]) -> Self {
        Self { size, startup: Startup::default(), ..Self::default() }
    }

    pub fn two_bursts(size: [f32; 2]) -> Self {
        Self { size, startup: Startup { second: Some(BurstSource::DemoLater), ..given() }, ..Self::default() }
    }

    pub fn nothing_open() -> Self {
        Self { startup: Startup { source: None, ..given() }, ..Self::default() }
    }

    pub fn without_auto_detect() -> Self {
        let settings = Settings { auto_detect: false, ..all_open() };
        Self { startup: Startup { settings, ..given() }, ..Self::default() }
    }

    pub fn of(path: &Path) -> Self {
        let source = Some(BurstSource::Paths(vec![path.to_owned()]));
        let startup = Startup { source, ..Self::without_auto_detect().startup };
        Self { startup, ..Self::default() }
    }

    /// A burst, to be searched at these slopes, in a window of 1280×800 points.
    pub fn at_slopes(path: &Path, slopes: SlopeGrid) -> Self {
        let mut start = Self { size: [1280.0, 800.0], ..Self::of(path) };
        start.startup.params = DetectorParams { slopes, ..DetectorParams::default() }.into();
        start
    }

    pub fn open(self) -> Window {
        let mut window = self.open_without_waiting();
        window.settle();
        window
    }

    pub fn open_without_waiting(mut self) -> Window {
        with_decode_worker();
        let dialogs = Scripted::default();
        self.startup.dialogs = Arc::new(dialogs.clone());
        let harness = common::builder(self.size)
            .with_pixels_per_point(self.pixels_per_point)
            .wgpu_setup(common::wgpu_setup())
            .build_eframe(|cc| BurstscopeApp::new(&cc.egui_ctx, cc.wgpu_render_state.as_ref(), self.startup));
        Window { harness, dialogs }
    }
}

impl Window {
    /// Place in the window, points, of a place of the image, pixels, in the pane in focus, as last drawn.
    pub fn ui_from_image(&self, pos_image: Pos2) -> Option<Pos2> {
        self.ui_from_image_in(self.document().focus(), pos_image)
    }

    pub fn ui_from_image_of(&self, side: Side, pos_image: Pos2) -> Option<Pos2> {
        self.ui_from_image_in(PaneId::of(side), pos_image)
    }

    fn ui_from_image_in(&self, id: PaneId, pos_image: Pos2) -> Option<Pos2> {
        self.app().widgets.ui_from_image(id).map(|t| t.pos(pos_image))
    }

    pub fn app(&self) -> &BurstscopeApp {
        self.harness.state()
    }

    pub fn model(&self) -> &Model {
        &self.app().model
    }

    pub fn document(&self) -> &Document {
        &self.model().document
    }

    pub fn results(&self) -> &Results {
        &self.model().results
    }

    pub fn opened(&self) -> &OpenBurst {
        self.results().slots.a.burst.as_ref().unwrap()
    }

    pub fn found(&self) -> &FoundFeatures {
        self.results().slots.a.found.as_ref().unwrap()
    }

    pub fn matches(&self) -> &Matches {
        self.results().pair.matches.as_ref().unwrap()
    }

    pub fn errors(&self) -> &[Message] {
        &self.model().shell.messages.errors
    }

    pub fn read(&self) -> Read<'_> {
        self.app().read()
    }

    pub fn app_mut(&mut self) -> &mut BurstscopeApp {
        self.harness.state_mut()
    }

    pub fn set(&mut self) -> &mut Document {
        &mut self.app_mut().model.document
    }

    pub fn steps(&mut self, count: usize) -> &mut Self {
        self.harness.run_steps(count);
        self
    }

    /// Changes what is set, without a widget.
    pub fn change<R>(&mut self, change: impl FnOnce(&mut Document) -> R) -> &mut Self {
        change(self.set());
        self
    }

    pub fn will_choose(&mut self, path: impl Into<PathBuf>) -> &mut Self {
        self.dialogs.will_choose(path);
        self
    }

    pub fn hover(&mut self, pos: Pos2) -> &mut Self {
        self.harness.hover_at(pos);
        self
    }

    pub fn has(&self, role: Role, label: &str) -> bool {
        self.harness.query_by_role_and_label(role, label).is_some()
    }

    pub fn rect(&self, role: Role, label: &str) -> Rect {
        self.harness.get_by_role_and_label(role, label).rect()
    }

    pub fn type_into(&mut self, field: &str, text: &str) -> &mut Self {
        self.harness.get_by_role_and_label(Role::TextInput, field).type_text(text);
        self
    }

    /// Zooms at a place of the window, as the wheel does; the pointer is gone afterwards.
    pub fn zoom_at(&mut self, pos: Pos2) -> &mut Self {
        self.hover(pos).steps(1);
        self.harness.event(egui::Event::Zoom(1.8));
        self.steps(4);
        self.harness.remove_cursor();
        self.steps(2)
    }

    /// Clicks a widget of this kind with this text; the window does not draw yet.
    pub fn click_on(&mut self, role: Role, label: &str) -> &mut Self {
        self.harness.get_by_role_and_label(role, label).click();
        self
    }

    /// Runs the window until no requested result is missing.
    pub fn settle(&mut self) -> &mut Self {
        self.wait("the window comes to rest", |app| app.is_settled());
        // Sizes measured in one pass are used in the next.
        self.harness.run_steps(3);
        self.wait("the window comes to rest", |app| app.is_settled());
        self
    }

    pub fn wait(&mut self, what: &str, wanted: impl Fn(&BurstscopeApp) -> bool) -> &mut Self {
        let end = Instant::now() + PATIENCE;
        let mut held = 0;
        while held < 2 {
            assert!(Instant::now() < end, "in {PATIENCE:?} this did not happen: {what}");
            self.harness.step();
            held = if wanted(self.harness.state()) { held + 1 } else { 0 };
            if held == 0 {
                std::thread::sleep(Duration::from_millis(2));
            }
        }
        self
    }

    pub fn wait_for_error(&mut self) -> &mut Self {
        self.wait("a message", |app| !app.model.shell.messages.errors.is_empty())
    }

    pub fn click(&mut self, label: &str) -> &mut Self {
        self.harness.get_by_role_and_label(Role::Button, label).click();
        self.steps(3)
    }

    pub fn key(&mut self, key: Key) -> &mut Self {
        self.harness.key_press(key);
        self.steps(2)
    }

    pub fn ctrl(&mut self, key: Key) -> &mut Self {
        self.harness.key_press_modifiers(Modifiers::COMMAND, key);
        self.steps(2)
    }

    pub fn shift(&mut self, key: Key) -> &mut Self {
        self.harness.key_press_modifiers(Modifiers::SHIFT, key);
        self.steps(2)
    }

    /// Chooses an action in the command palette by typing its name.
    pub fn run_action(&mut self, name: &str) -> &mut Self {
        self.ctrl(Key::P);
        self.harness.get_by_role_and_label(Role::TextInput, "Find an action").type_text(name);
        self.harness.run_steps(2);
        self.key(Key::Enter);
        self.steps(2)
    }

    pub fn kept_and_opened_in_another(&mut self, file: &Path) -> Self {
        self.kept_and_opened_in(Start::without_auto_detect(), file)
    }

    pub fn kept_and_opened_in(&mut self, start: Start, file: &Path) -> Self {
        self.will_choose(file).run_action("save session").settle();
        let mut other = start.open();
        other.will_choose(file).run_action("open session").settle();
        other
    }

    pub fn drop_file(&mut self, path: PathBuf) -> &mut Self {
        #[derive(Debug)]
        struct Dropped(PathBuf);
        impl egui::DroppedFile for Dropped {
            fn path(&self) -> &Path {
                &self.0
            }
            fn bytes(&self) -> Result<Vec<u8>, String> {
                fs::read(&self.0).map_err(|e| e.to_string())
            }
        }
        self.harness.input_mut().dropped_files.push(Arc::new(Dropped(path)));
        self.harness.step();
        self
    }

    pub fn slide(&mut self, label: &str, value: f64) -> &mut Self {
        // A slope that a pad shows has a number alone.
        let slider = self.harness.query_by_role_and_label(Role::Slider, label);
        slider
            .unwrap_or_else(|| self.harness.get_by_role_and_label(Role::SpinButton, label))
            .set_value_accesskit(value);
        self.steps(2)
    }

    pub fn open_tab(&mut self, label: &str) -> &mut Self {
        if !self.read().shows_bottom() {
            self.run_action("table and tally");
        }
        if format!("{:?}", self.document().bottom_tab) != label {
            self.click(label);
        }
        self
    }

    pub fn choose(&mut self, menu: &str, entry: &str) -> &mut Self {
        self.click(menu);
        self.harness.get_by_label_contains(entry).click();
        self.steps(3)
    }

    pub fn click_at(&mut self, pos: Pos2) -> &mut Self {
        self.click_with(Modifiers::NONE, pos)
    }

    pub fn shift_click_at(&mut self, pos: Pos2) -> &mut Self {
        self.click_with(Modifiers::SHIFT, pos)
    }

    fn click_with(&mut self, modifiers: Modifiers, pos: Pos2) -> &mut Self {
        self.hover(pos).steps(1);
        for pressed in [true, false] {
            let button = egui::PointerButton::Primary;
            let event = egui::Event::PointerButton { pos, button, pressed, modifiers };
            self.harness.event_modifiers(event, modifiers);
            self.harness.run_steps(1);
        }
        self.steps(1)
    }

    /// Double-clicks at a place of the window. A step here takes longer than a person's double click, so a slower one
    /// is accepted.
    pub fn double_click_at(&mut self, pos: Pos2) -> &mut Self {
        let set_delay = |window: &Self, seconds| {
            window.harness.ctx.options_mut(|o| o.input_options.max_double_click_delay = seconds);
        };
        let usual = self.harness.ctx.options(|o| o.input_options.max_double_click_delay);
        set_delay(self, 5.0);
        self.click_at(pos);
        self.click_at(pos);
        set_delay(self, usual);
        self
    }

    pub fn drag(&mut self, from: Pos2, to: Pos2) -> &mut Self {
        self.harness.hover_at(from);
        self.harness.run_steps(1);
        self.harness.drag_at(from);
        self.harness.run_steps(1);
        for part in [0.3, 0.6, 1.0] {
            self.harness.hover_at(from + part * (to - from));
            self.harness.run_steps(1);
        }
        self.harness.drop_at(to);
        self.harness.run_steps(2);
        self.settle();
        self
    }

    pub fn shows(&self, text: &str) -> bool {
        let has_value = egui_kittest::kittest::by().predicate(|n| n.value().is_some_and(|v| v.contains(text)));
        self.harness.query_all_by_label_contains(text).next().is_some()
            || self.harness.query_all(has_value).next().is_some()
    }

    pub fn snapshot(&mut self, name: &str) -> &mut Self {
        self.harness.remove_cursor();
        self.compare(name);
        self
    }

    pub fn snapshot_with_pointer(&mut self, name: &str, pos: Pos2) {
        self.harness.hover_at(pos);
        self.harness.run_steps(30);
        self.compare(name);
    }

    fn compare(&mut self, name: &str) {
        self.settle();
        // Which of several bursts' or methods' answers comes last differs from run to run.
        let document = self.document();
        if document.workspace.shows_pair() || document.compares_methods() {
            self.app_mut().model.shell.messages.note("");
        }
        // Durations differ from run to run.
        if let Some(found) = &mut self.app_mut().model.results.slots.a.found {
            (found.elapsed, found.detected.search_secs) = (Duration::from_millis(120), 0.12);
        }
        if let Some(matches) = &mut self.app_mut().model.results.pair.matches {
            matches.elapsed = Duration::from_millis(10);
        }
        for found in self.app_mut().model.results.compare.found.values_mut() {
            found.elapsed = Duration::from_millis(120);
        }
        self.harness.run_steps(2);
        pictures::compare(&mut self.harness, name);
    }
}

/// A `.npy` stack of `light(t, v, u)` in `folder`; its size is in frames, rows and columns.
pub fn stack(
    folder: &Path,
    name: &str,
    size: (usize, usize, usize),
    light: impl FnMut((usize, usize, usize)) -> f32,
) -> PathBuf {
    let path = folder.join(name);
    ndarray_npy::write_npy(&path, &Array3::from_shape_fn(size, light)).unwrap();
    path
}

/// A burst of noise with a few discs that move by (1, 0), as a `.npy` stack in `folder`.
pub fn noisy_stack(folder: &Path, frames: usize, height: usize, width: usize) -> PathBuf {
    let noise = |i: usize| {
        let mut h = (i as u32).wrapping_mul(0x9E37_79B9) ^ 0x85EB_CA6B;
        h = (h ^ (h >> 15)).wrapping_mul(0x2C1B_3C6D);
        h = (h ^ (h >> 12)).wrapping_mul(0x297A_2D39);
        (h >> 8) as f32 / (1 << 24) as f32 - 0.5
    };
    stack(folder, "noisy.npy", (frames, height, width), |(t, v, u)| {
        let disc = |cu: f32, cv: f32| {
            let d2 = (u as f32 - cu - t as f32).powi(2) + (v as f32 - cv).powi(2);
            (-d2 / 32.0).exp()
        };
        let light = disc(0.3 * width as f32, 0.4 * height as f32) + disc(0.6 * width as f32, 0.7 * height as f32);
        0.1 + 0.1 * light + 0.08 * noise((t * height + v) * width + u)
    })
}
