//! Opens the window on the desktop, and opens it again after the graphics device was lost.
//!
//! The toolkit ties the device to the window, so the drawing ends and the program goes on in a new window with a new
//! device; open data, running work and the history stay. The toolkit itself panics where it has no memory for shapes
//! and letters; that is a lost device too.

use super::gpu::{self, AdapterChoice};
use super::recovery::{KeptIn, Record, SAVED_EVERY};
use super::settings::Settings;
use super::startup::Startup;
use super::window::BurstscopeApp;
use anyhow::anyhow;
use egui_wgpu::WgpuConfiguration;
use std::cell::{Cell, RefCell};
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::path::PathBuf;
use std::rc::Rc;
use std::time::{Duration, Instant};

/// The name under which the desktop knows the program, and under which settings are stored.
const APP_ID: &str = "burstscope";

/// `assets/icon.svg`, drawn on 256 × 256 pixels.
const ICON: &[u8] = include_bytes!("../../assets/icon.png");

const RUNNING_FOLDER: &str = "running";

/// Losses of the device within [`LOSSES_WITHIN`] after which it is not set up again.
const MAX_LOSSES: usize = 3;
const LOSSES_WITHIN: Duration = Duration::from_secs(60);

type SharedWindow = Rc<RefCell<Option<BurstscopeApp>>>;

/// The kept window, as the toolkit draws it, and whether the window itself is at work.
struct Shown(SharedWindow, Rc<Cell<bool>>);

impl Shown {
    fn with(&self, work: impl FnOnce(&mut BurstscopeApp)) {
        if let Some(app) = &mut *self.0.borrow_mut() {
            self.1.set(true);
            work(app);
            self.1.set(false);
        }
    }
}

impl eframe::App for Shown {
    fn ui(&mut self, ui: &mut egui::Ui, frame: &mut eframe::Frame) {
        self.with(|app| app.ui(ui, frame));
    }

    fn save(&mut self, storage: &mut dyn eframe::Storage) {
        self.with(|app| app.save(storage));
    }

    fn on_exit(&mut self) {
        self.with(eframe::App::on_exit);
    }
}

pub fn run(mut startup: Startup) -> anyhow::Result<()> {
    let running = eframe::storage_dir(APP_ID).map(|folder| folder.join(RUNNING_FOLDER));
    // A second window at the place of the first would hide it; its place is left to the desktop.
    let is_first = !running.as_ref().is_some_and(|folder| Record::is_kept_in(folder));
    startup.kept = running.map(|folder| KeptIn { folder, every: SAVED_EVERY });
    let window = SharedWindow::default();
    let mut startup = Some(startup);
    let mut context = None;
    let mut losses: Vec<Instant> = Vec::new();
    loop {
        let opened = draw_until_closed(&window, &mut startup, &mut context, is_first);
        let saved = "what was open was saved and is offered at the next start";
        let opened = if losses.is_empty() { opened } else { opened.map_err(|error| anyhow!("{error}; {saved}")) };
        let Some(why) = window.borrow_mut().as_mut().and_then(BurstscopeApp::take_lost_device) else { return opened };
        opened?;
        losses.retain(|at| at.elapsed() < LOSSES_WITHIN);
        losses.push(Instant::now());
        if losses.len() >= MAX_LOSSES {
            let seconds = LOSSES_WITHIN.as_secs();
            return Err(anyhow!(
                "the graphics device was lost {MAX_LOSSES} times within {seconds} seconds ({why}); {saved}"
            ));
        }
    }
}

/// File of the settings where the usual one is no regular file, which the toolkit would wait for.
fn other_settings() -> Option<PathBuf> {
    let folder = eframe::storage_dir(APP_ID)?;
    std::fs::metadata(folder.join("app.ron")).is_ok_and(|found| !found.is_file()).then(|| folder.join("settings.ron"))
}

fn draw_until_closed(
    window: &SharedWindow,
    startup: &mut Option<Startup>,
    context: &mut Option<egui::Context>,
    keeps_place: bool,
) -> anyhow::Result<()> {
    let options = eframe::NativeOptions {
        viewport: egui::ViewportBuilder::default()
            .with_app_id(APP_ID)
            .with_title("Burstscope")
            .with_icon(eframe::icon_data::from_png_bytes(ICON).expect("the icon is a picture"))
            .with_inner_size([1280.0, 800.0])
            .with_min_inner_size([900.0, 560.0])
            .with_drag_and_drop(true),
        renderer: eframe::Renderer::Wgpu,
        wgpu_options: WgpuConfiguration { wgpu_setup: gpu::wgpu_setup(AdapterChoice::Fastest), ..Default::default() },
        persistence_path: other_settings(),
        persist_window: keeps_place,
        ..Default::default()
    };
    let before = context.clone();
    let is_at_work = Rc::new(Cell::new(false));
    let at_work = is_at_work.clone();
    let create: eframe::AppCreator<'_> = Box::new(move |cc| {
        let render_state = cc.wgpu_render_state.as_ref();
        if let Some(mut startup) = startup.take() {
            if let Some(storage) = cc.storage {
                startup.settings = Settings::load(storage);
            }
            *window.borrow_mut() = Some(BurstscopeApp::new(&cc.egui_ctx, render_state, startup));
            *context = Some(cc.egui_ctx.clone());
        } else if let Some(render_state) = render_state {
            gpu::install(&cc.egui_ctx, render_state);
        }
        Ok(Box::new(Shown(window.clone(), at_work.clone())))
    });
    let drawn = catch_unwind(AssertUnwindSafe(|| eframe::run_native_ext(APP_ID, options, before, create)));
    match (drawn, &mut *window.borrow_mut()) {
        (Ok(result), _) => result.map_err(|error| {
            anyhow!(
                "the window cannot be opened: {error}; without a display use `burstscope render` or the other commands"
            )
        }),
        // The window's own state is whole: the toolkit failed while it drew what the window had left.
        (Err(_), Some(app)) if !is_at_work.get() => {
            app.lose_device("it failed while drawing");
            Ok(())
        }
        (Err(panic), _) => resume_unwind(panic),
    }
}
