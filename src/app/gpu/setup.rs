//! Setup of the graphics device for the window, for drawing without a display and for tests.

use super::limits::DeviceLimits;
use super::mirror::TextureMirror;
use super::renderer::PictureRenderer;
use egui_wgpu::{RenderState, WgpuConfiguration, WgpuSetup, WgpuSetupCreateNew};
use std::sync::{Arc, OnceLock};

/// Choice of the adapter when a machine has several.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum AdapterChoice {
    /// The fastest one.
    #[default]
    Fastest,
    /// A software one if there is one: it draws identical pictures on every machine, as comparing pictures requires.
    Software,
}

/// Setup of instance, adapter and device, for the whole program.
///
/// Vulkan, Metal or DirectX 12 (or what the environment variable `WGPU_BACKEND` names). The device gets the adapter's
/// own limits for the size of pictures and buffers; the portable defaults would refuse pictures that the machine can
/// hold.
pub fn wgpu_setup(choice: AdapterChoice) -> WgpuSetup {
    let mut setup = WgpuSetupCreateNew::without_display_handle();
    setup.instance_descriptor.backends = wgpu::Backends::from_env().unwrap_or(wgpu::Backends::PRIMARY);
    setup.device_descriptor = Arc::new(|adapter| wgpu::DeviceDescriptor {
        label: Some("burstscope device"),
        required_limits: required_limits(&adapter.limits()),
        ..Default::default()
    });
    if choice == AdapterChoice::Software {
        setup.native_adapter_selector = Some(Arc::new(|adapters, _surface| {
            let software = |a: &&wgpu::Adapter| a.get_info().device_type == wgpu::DeviceType::Cpu;
            adapters.iter().find(software).or(adapters.first()).cloned().ok_or_else(|| "no graphics adapter".to_owned())
        }));
    }
    WgpuSetup::CreateNew(setup)
}

/// Graphics options of the window: [`wgpu_setup`] with the fastest adapter. For `eframe::NativeOptions::wgpu_options`.
pub fn wgpu_configuration() -> WgpuConfiguration {
    WgpuConfiguration { wgpu_setup: wgpu_setup(AdapterChoice::Fastest), ..Default::default() }
}

/// Portable limits (the smaller portable set on weak adapters), raised to the adapter's where the size of pictures
/// depends on them.
fn required_limits(adapter: &wgpu::Limits) -> wgpu::Limits {
    let base = if wgpu::Limits::default().check_limits(adapter) {
        wgpu::Limits::default()
    } else {
        wgpu::Limits::downlevel_defaults().using_resolution(adapter.clone())
    };
    wgpu::Limits {
        max_texture_dimension_2d: adapter.max_texture_dimension_2d,
        max_texture_array_layers: adapter.max_texture_array_layers,
        max_buffer_size: adapter.max_buffer_size,
        max_storage_buffer_binding_size: adapter.max_storage_buffer_binding_size,
        ..base
    }
}

/// Enables `ctx` to draw float pictures with `render_state`. Call it once when the window (or the offscreen drawing) is
/// created, before the first canvas is shown: in an eframe app with `cc.egui_ctx` and `cc.wgpu_render_state`. Call it
/// again for a new device in place of a [lost](Gpu::lost) one: everything on the card is uploaded to the new one.
///
/// The renderer of `render_state` must draw without multisampling and without a depth buffer, which are egui's
/// defaults.
pub fn install(ctx: &egui::Context, render_state: &RenderState) {
    let limits = DeviceLimits::of(&render_state.device);
    let renderer = PictureRenderer::new(&render_state.device, &render_state.queue, render_state.target_format, limits);
    let lost = Arc::new(OnceLock::new());
    let (noted, waker) = (lost.clone(), ctx.clone());
    render_state.device.set_device_lost_callback(move |reason, message| {
        // A device is lost only once.
        let _ = noted.set(if message.is_empty() { format!("{reason:?}") } else { message });
        waker.request_repaint();
    });
    let adapter_name = Arc::from(render_state.adapter.get_info().name);
    let gpu = Gpu { adapter_name, limits, failures: renderer.failures(), lost };
    render_state.renderer.write().callback_resources.insert(renderer);
    TextureMirror::install(ctx);
    ctx.data_mut(|data| data.insert_temp(egui::Id::NULL, gpu));
}

/// State of the card for widgets. Present in a context after [`install`].
#[derive(Debug, Clone)]
pub struct Gpu {
    /// Adapter's own name, for an "about" box or an error report.
    pub adapter_name: Arc<str>,
    /// Limits of the device.
    pub limits: DeviceLimits,
    failures: super::renderer::Failures,
    lost: Arc<OnceLock<String>>,
}

impl Gpu {
    /// State of the card that draws `ctx`, or `None` when [`install`] was never called for it.
    pub fn of(ctx: &egui::Context) -> Option<Self> {
        ctx.data(|data| data.get_temp(egui::Id::NULL))
    }

    /// Reason why the device is lost, in the driver's words; `None` while it works. A lost device draws nothing.
    pub fn lost(&self) -> Option<&str> {
        self.lost.get().map(String::as_str)
    }

    /// Reason why a picture of `size` = (columns, rows) cannot be shown, as a sentence for the user; `None` when it
    /// can.
    pub fn obstacle(&self, id: super::PictureId, size: (usize, usize)) -> Option<String> {
        if let Err(message) = super::layout::Layout::new(size, self.limits) {
            return Some(message);
        }
        self.failures.lock().ok()?.get(&id).cloned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_follow_the_adapter_where_pictures_need_it() {
        let strong =
            wgpu::Limits { max_texture_dimension_2d: 32768, max_buffer_size: 1 << 40, ..wgpu::Limits::default() };
        let limits = required_limits(&strong);
        assert_eq!((limits.max_texture_dimension_2d, limits.max_buffer_size), (32768, 1 << 40));
        let weak = wgpu::Limits::downlevel_defaults();
        assert!(required_limits(&weak).check_limits(&weak), "a weak adapter must still get a device");
    }
}
