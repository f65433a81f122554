//! Harness of the window's tests: it draws as the program does, on a software adapter.

use crate::support::*;
use burstscope::app::gpu::{self, AdapterChoice};
use egui_kittest::{HarnessBuilder, wgpu::WgpuTestRenderer, wgpu::create_render_state};

/// Setup of the program's own device, on a software adapter where there is one: pictures are equal on every machine.
pub fn wgpu_setup() -> egui_wgpu::WgpuSetup {
    gpu::wgpu_setup(AdapterChoice::Software)
}

/// Builder of a harness for a window of `size` points, without a renderer; add `.wgpu_setup(wgpu_setup())` and
/// `build_eframe` for the whole app.
pub fn builder<State>(size: [f32; 2]) -> HarnessBuilder<State> {
    // Pictures leave the pointer out: its effect matters more than its place.
    Harness::builder().with_size(size).with_max_steps(120).with_render_cursor(false)
}

/// Enables a harness without an app to draw float pictures: for tests of single widgets with `build_ui_state`.
pub fn with_pictures<State>(builder: HarnessBuilder<State>) -> HarnessBuilder<State> {
    let render_state = create_render_state(wgpu_setup(), egui_wgpu::RendererOptions::PREDICTABLE);
    let for_context = render_state.clone();
    builder
        .renderer(WgpuTestRenderer::from_render_state(render_state))
        .with_context_setup(move |ctx| gpu::install(ctx, &for_context))
}
