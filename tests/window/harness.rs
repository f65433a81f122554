//! What the window's tests share: a harness that draws as the program does, on a software adapter, and the options of
//! compared pictures.

use super::pictures;
use burstscope::app::gpu::{self, AdapterChoice};
use egui_kittest::wgpu::{WgpuTestRenderer, create_render_state};
use egui_kittest::{Harness, HarnessBuilder, SnapshotOptions};

/// The program's own device, on a software adapter where there is one: pictures are the same on every machine.
pub fn wgpu_setup() -> egui_wgpu::WgpuSetup {
    gpu::wgpu_setup(AdapterChoice::Software)
}

/// Options of compared pictures. The numbers are in `kittest.toml`.
pub fn snapshot_options() -> SnapshotOptions {
    SnapshotOptions::new()
}

/// A harness for a window of `size` points, without a renderer; give it `.wgpu_setup(wgpu_setup())` and `build_eframe`
/// for the whole app.
pub fn builder<State>(size: [f32; 2]) -> HarnessBuilder<State> {
    // The pointer is left out of pictures: where it stands matters less than what it shows.
    Harness::builder().with_size(size).with_max_steps(120).with_options(snapshot_options()).with_render_cursor(false)
}

/// Lets a harness without an app draw float pictures: for tests of single widgets with `build_ui_state`.
pub fn with_pictures<State>(builder: HarnessBuilder<State>) -> HarnessBuilder<State> {
    let render_state = create_render_state(wgpu_setup(), egui_wgpu::RendererOptions::PREDICTABLE);
    pictures::drawn_on(&render_state.adapter.get_info());
    let for_context = render_state.clone();
    builder
        .renderer(WgpuTestRenderer::from_render_state(render_state))
        .with_context_setup(move |ctx| gpu::install(ctx, &for_context))
}
