//! Opens the window on the desktop, and opens it again after the graphics device was lost.
//!
//! The toolkit ties the device to the window, so a lost device cannot be replaced under an open window. Instead the
//! drawing ends, and the program continues in a new window with a new device; open data, running work and the history
//! stay.

use super::gpu;
use super::recovery::{KeptIn, SAVED_EVERY};
use super::settings::Settings;
use super::startup::Startup;
use super::window::BurstscopeApp;
use anyhow::anyhow;
use std::cell::RefCell;
use std::rc::Rc;
use std::time::{Duration, Instant};

/// The name under which the desktop knows the program, and under which settings are stored.
const APP_ID: &str = "burstscope";

/// Pixels of the icon on each side; desktops make it smaller.
const ICON_SIDE: u32 = 256;

/// Subfolder of the program's data folder for the sessions of running windows.
const RUNNING_FOLDER: &str = "running";

/// Losses of the device within [`LOSSES_WITHIN`] after which it is not set up again.
const MOST_LOSSES: usize = 3;
const LOSSES_WITHIN: Duration = Duration::from_secs(60);

/// The window, kept across losses of the graphics device.
type Kept = Rc<RefCell<Option<BurstscopeApp>>>;

/// The kept window, as the toolkit draws it.
struct Shown(Kept);

impl Shown {
    fn with(&self, work: impl FnOnce(&mut BurstscopeApp)) {
        if let Some(app) = &mut *self.0.borrow_mut() {
            work(app);
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

/// Opens the window and returns when it is closed. Stored settings replace those in `startup`.
///
/// # Errors
/// When there is no display, or no graphics card (nor a software one) that can draw the window, or its device is lost
/// again and again.
pub fn run(mut startup: Startup) -> anyhow::Result<()> {
    let running = eframe::storage_dir(APP_ID).map(|folder| folder.join(RUNNING_FOLDER));
    startup.kept = running.map(|folder| KeptIn { folder, every: SAVED_EVERY });
    let window = Kept::default();
    let mut startup = Some(startup);
    let mut context = None;
    let mut losses: Vec<Instant> = Vec::new();
    loop {
        let opened = draw_until_closed(&window, &mut startup, &mut context);
        let saved = "what was open was saved and is offered at the next start";
        let opened = if losses.is_empty() { opened } else { opened.map_err(|error| anyhow!("{error}; {saved}")) };
        let Some(why) = window.borrow_mut().as_mut().and_then(BurstscopeApp::take_lost_device) else { return opened };
        opened?;
        losses.retain(|at| at.elapsed() < LOSSES_WITHIN);
        losses.push(Instant::now());
        if losses.len() >= MOST_LOSSES {
            let seconds = LOSSES_WITHIN.as_secs();
            return Err(anyhow!(
                "the graphics device was lost {MOST_LOSSES} times within {seconds} seconds ({why}); {saved}"
            ));
        }
    }
}

/// Draws the kept window on a new device until it is closed; without a kept one, creates and keeps it.
fn draw_until_closed(
    window: &Kept,
    startup: &mut Option<Startup>,
    context: &mut Option<egui::Context>,
) -> anyhow::Result<()> {
    let options = eframe::NativeOptions {
        viewport: egui::ViewportBuilder::default()
            .with_app_id(APP_ID)
            .with_title("Burstscope")
            .with_icon(super::icon::icon(ICON_SIDE))
            .with_inner_size([1280.0, 800.0])
            .with_min_inner_size([900.0, 560.0])
            .with_drag_and_drop(true),
        renderer: eframe::Renderer::Wgpu,
        wgpu_options: gpu::wgpu_configuration(),
        ..Default::default()
    };
    let before = context.clone();
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
        Ok(Box::new(Shown(window.clone())))
    });
    eframe::run_native_ext(APP_ID, options, before, create).map_err(|error| {
        anyhow!("the window cannot be opened: {error}; without a display use `burstscope render` or the other commands")
    })
}
