//! Setup of the graphics device, and copies of the toolkit's own textures (letters, icons, small pictures): the toolkit
//! hands each to the card once and forgets it, and a new device in place of a lost one must get them all again.

use super::renderer::Failures;
use super::{DeviceLimits, PictureRenderer};
use egui::epaint::{ColorImage, ImageData, ImageDelta, TextureId};
use egui::{Context, FullOutput, TextureOptions};
use egui_wgpu::{RenderState, WgpuSetup, WgpuSetupCreateNew};
use std::collections::BTreeMap;
use std::sync::{Arc, OnceLock};

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum AdapterChoice {
    #[default]
    Fastest,
    /// A software one if there is one: it draws identical pictures on every machine, as comparing pictures requires.
    Software,
}

/// The device gets the adapter's own limits of size: the portable ones would refuse pictures that the machine holds.
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

/// Portable limits, raised to the adapter's where the size of pictures depends on them.
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

/// Enables `ctx` to draw float pictures with `render_state`, which draws without multisampling and without a depth
/// buffer. Called before the first canvas is shown, and again for a new device in place of a [lost](Gpu::lost) one.
pub fn install(ctx: &egui::Context, render_state: &RenderState) {
    let device = &render_state.device;
    let limits = DeviceLimits::of(device);
    let failures = Gpu::of(ctx).map_or_else(Failures::default, |gpu| gpu.failures);
    let mut renderer = PictureRenderer::new(render_state, limits, failures.clone());
    renderer.window = Some(ctx.clone());
    let lost = Arc::new(OnceLock::new());
    let (noted, waker) = (lost.clone(), ctx.clone());
    let lose = move |why: String| {
        // A device is lost only once.
        let _ = noted.set(why);
        waker.request_repaint();
    };
    let lose_without_memory = lose.clone();
    device.set_device_lost_callback(move |reason, message| {
        lose(if message.is_empty() { format!("{reason:?}") } else { message });
    });
    let noted = lost.clone();
    device.on_uncaptured_error(Arc::new(move |error| match error {
        // Pictures cope with refused memory. Without memory for letters and shapes a device is of no use.
        wgpu::Error::OutOfMemory { .. } => lose_without_memory("it has no memory left".to_owned()),
        // Requests to a lost device fail.
        _ if noted.get().is_some() => {}
        error => panic!("{error}"),
    }));
    let adapter_name = Arc::from(render_state.adapter.get_info().name);
    render_state.renderer.write().callback_resources.insert(renderer);
    TextureMirror::install(ctx);
    ctx.data_mut(|data| data.insert_temp(egui::Id::NULL, Gpu { adapter_name, limits, failures, lost }));
}

#[derive(Debug, Clone)]
pub struct Gpu {
    pub adapter_name: Arc<str>,
    pub limits: DeviceLimits,
    failures: Failures,
    lost: Arc<OnceLock<String>>,
}

impl Gpu {
    pub fn of(ctx: &egui::Context) -> Option<Self> {
        ctx.data(|data| data.get_temp(egui::Id::NULL))
    }

    /// In the driver's words; `None` while it works. A lost device draws nothing.
    pub fn lost(&self) -> Option<&str> {
        self.lost.get().map(String::as_str)
    }

    /// Why a picture of `size` = (columns, rows) cannot be shown, as a sentence for the user.
    pub fn obstacle(&self, id: super::PictureId, size: (usize, usize)) -> Option<String> {
        if let Err(message) = super::texture::Layout::new(size, self.limits) {
            return Some(message);
        }
        self.failures.lock().ok()?.get(&id).cloned()
    }

    pub fn newest_failure(&self) -> Option<(super::PictureId, String)> {
        self.failures.lock().ok()?.last_key_value().map(|(id, why)| (*id, why.clone()))
    }
}

#[derive(Default)]
pub(super) struct TextureMirror {
    textures: BTreeMap<u64, (Arc<ColorImage>, TextureOptions)>,
    wanted: bool,
}

impl TextureMirror {
    /// Keeps the textures of `ctx` from now on; if they are kept already, the next frame uploads all of them again.
    pub(super) fn install(ctx: &Context) {
        if ctx.with_plugin(|mirror: &mut Self| mirror.wanted = true).is_none() {
            ctx.add_plugin(Self::default());
        }
    }

    fn take(&mut self, id: TextureId, delta: &ImageDelta) {
        let TextureId::Managed(number) = id else { return };
        let ImageData::Color(image) = &delta.image;
        match (delta.pos, self.textures.get_mut(&number)) {
            (None, _) => _ = self.textures.insert(number, (image.clone(), delta.options)),
            (Some([left, top]), Some((whole, options))) => {
                *options = delta.options;
                let whole = Arc::make_mut(whole);
                let (width, whole_width) = (image.width(), whole.width());
                for (row, pixels) in image.pixels.chunks_exact(width.max(1)).enumerate() {
                    let start = (top + row) * whole_width + left;
                    if let Some(place) = whole.pixels.get_mut(start..start + width) {
                        place.copy_from_slice(pixels);
                    }
                }
            }
            // Part of a texture that was never set whole.
            (Some(_), None) => {}
        }
    }

    fn all(&self) -> impl Iterator<Item = (TextureId, ImageDelta)> {
        let whole = |(image, options): &(Arc<ColorImage>, TextureOptions)| ImageDelta::full(image.clone(), *options);
        self.textures.iter().map(move |(number, texture)| (TextureId::Managed(*number), whole(texture)))
    }
}

impl egui::Plugin for TextureMirror {
    fn debug_name(&self) -> &'static str {
        "burstscope textures"
    }

    fn output_hook(&mut self, _ctx: &Context, output: &mut FullOutput) {
        let delta = &mut output.textures_delta;
        for (id, deltas) in &delta.set {
            deltas.iter().for_each(|delta| self.take(*id, delta));
        }
        if std::mem::take(&mut self.wanted) {
            self.all().for_each(|(id, whole)| delta.push(id, whole));
        }
        self.textures.retain(|number, _| !delta.free.contains(&TextureId::Managed(*number)));
    }
}

pub fn textures_of(ctx: &Context) -> Vec<(TextureId, ImageDelta)> {
    ctx.with_plugin(|mirror: &mut TextureMirror| mirror.all().collect()).unwrap_or_default()
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
