//! Opens the window on the desktop.

use super::gpu;
use super::settings::Settings;
use super::window::{BurstscopeApp, Startup};
use anyhow::anyhow;

/// The name under which the desktop knows the program, and under which settings are stored.
const APP_ID: &str = "burstscope";

/// Opens the window and answers when it is closed. Settings of the last time come on top of those in `startup`.
///
/// # Errors
/// When there is no display, or no graphics card (nor a software one) that can draw the window.
pub fn run(mut startup: Startup) -> anyhow::Result<()> {
    let options = eframe::NativeOptions {
        viewport: egui::ViewportBuilder::default()
            .with_app_id(APP_ID)
            .with_title("Burstscope")
            .with_inner_size([1280.0, 800.0])
            .with_min_inner_size([900.0, 560.0])
            .with_drag_and_drop(true),
        renderer: eframe::Renderer::Wgpu,
        wgpu_options: gpu::wgpu_configuration(),
        ..Default::default()
    };
    eframe::run_native(
        APP_ID,
        options,
        Box::new(move |cc| {
            if let Some(storage) = cc.storage {
                startup.settings = Settings::load(storage);
            }
            Ok(Box::new(BurstscopeApp::new(&cc.egui_ctx, cc.wgpu_render_state.as_ref(), startup)))
        }),
    )
    .map_err(|error| {
        anyhow!("the window cannot be opened: {error}; without a display use `burstscope render` or the other commands")
    })
}
