//! Contents of the card between frames (pipeline, colour maps, pictures, bind groups), and the paint callback.

use super::texture::{Layout, PictureTexture, flat_texture, wait_for_card};
use super::{DeviceLimits, PictureId};
use crate::app::canvas::RectTransform;
use crate::plane::Plane;
use crate::plane::display::{ColourMap, Display};
use std::collections::{BTreeMap, HashMap};
use std::sync::{Arc, Mutex};
use wgpu::util::{DeviceExt as _, TextureDataOrder};

/// Memory of the pictures on the card, bytes; beyond it those unused for longest are removed.
const BUDGET_BYTES: u64 = 512 << 20;
/// Budget of a software driver: its memory is the program's own, where the picture cache holds the pictures already.
const SOFTWARE_BUDGET_BYTES: u64 = 64 << 20;

/// Number of frames after which a pane that is not drawn loses its bind group.
const PANE_LIFETIME_FRAMES: u64 = 600;

pub type Failures = Arc<Mutex<BTreeMap<PictureId, String>>>;

struct Resident {
    texture: PictureTexture,
    last_used_frame: u64,
}

struct Pane {
    buffer: wgpu::Buffer,
    bind_group: wgpu::BindGroup,
    picture: PictureId,
    last_used_frame: u64,
}

/// State that the paint callbacks share. Lives in egui's callback resources.
pub struct PictureRenderer {
    pipeline: wgpu::RenderPipeline,
    lut: wgpu::TextureView,
    limits: DeviceLimits,
    budget_bytes: u64,
    target_is_srgb: bool,
    pictures: HashMap<PictureId, Resident>,
    panes: HashMap<u64, Pane>,
    failures: Failures,
    pub(super) window: Option<egui::Context>,
    frame: u64,
    frame_open: bool,
    pub uploads: u64,
}

impl PictureRenderer {
    /// Failed uploads are noted in `failures`, and are not tried again.
    pub fn new(state: &egui_wgpu::RenderState, limits: DeviceLimits, failures: Failures) -> Self {
        let is_software = state.adapter.get_info().device_type == wgpu::DeviceType::Cpu;
        Self {
            pipeline: pipeline(&state.device, state.target_format),
            lut: lut_texture(&state.device, &state.queue),
            limits,
            budget_bytes: if is_software { SOFTWARE_BUDGET_BYTES } else { BUDGET_BYTES },
            target_is_srgb: state.target_format.is_srgb(),
            pictures: HashMap::new(),
            panes: HashMap::new(),
            failures,
            window: None,
            frame: 0,
            frame_open: false,
            uploads: 0,
        }
    }

    /// Uploads the picture if it is missing.
    fn prepare(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, paint: &PicturePaint, pixels_per_point: f32) {
        self.frame_open = true;
        let (pane, id) = (paint.pane.value(), paint.id);
        let Some(layout) = self.ensure_picture(device, queue, paint) else {
            // Without its picture a pane must not go on showing the one before.
            self.panes.remove(&pane);
            return;
        };
        let uniforms = paint.uniforms(pixels_per_point, layout, self.target_is_srgb);
        let view = &self.pictures[&id].texture.view;
        let bind_group = |uniforms: &wgpu::Buffer| {
            let textures = [view, &self.lut].map(wgpu::BindingResource::TextureView);
            let resources = [uniforms.as_entire_binding()].into_iter().chain(textures);
            let entry = |(binding, resource)| wgpu::BindGroupEntry { binding, resource };
            device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("burstscope pane"),
                layout: &self.pipeline.get_bind_group_layout(0),
                entries: &(0..).zip(resources).map(entry).collect::<Vec<_>>(),
            })
        };
        let pane = self.panes.entry(pane).or_insert_with(|| {
            let usage = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
            let (label, size) = (Some("burstscope pane"), size_of::<Uniforms>() as u64);
            let described = wgpu::BufferDescriptor { label, size, usage, mapped_at_creation: false };
            let buffer = device.create_buffer(&described);
            Pane { bind_group: bind_group(&buffer), buffer, picture: id, last_used_frame: 0 }
        });
        // A bind group names its texture: another picture in the pane needs another group.
        if pane.picture != id {
            (pane.bind_group, pane.picture) = (bind_group(&pane.buffer), id);
        }
        pane.last_used_frame = self.frame;
        queue.write_buffer(&pane.buffer, 0, bytemuck::bytes_of(&uniforms));
    }

    fn ensure_picture(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, paint: &PicturePaint) -> Option<Layout> {
        let PicturePaint { id, ref plane, .. } = *paint;
        if let Some(resident) = self.pictures.get_mut(&id) {
            resident.last_used_frame = self.frame;
            return Some(resident.texture.layout);
        }
        // It would fail again in every pass.
        if self.failures.lock().ok()?.contains_key(&id) {
            return None;
        }
        let texture = Layout::new(plane.size(), self.limits).and_then(|layout| {
            PictureTexture::upload(device, queue, plane, layout).or_else(|_| {
                // Pictures that are not on show may take the memory.
                let frame = self.frame;
                self.pictures.retain(|_, picture| picture.last_used_frame == frame);
                self.panes.retain(|_, pane| self.pictures.contains_key(&pane.picture));
                wait_for_card(device, None);
                PictureTexture::upload(device, queue, plane, layout)
            })
        });
        match texture {
            Ok(texture) => {
                let layout = texture.layout;
                self.uploads += 1;
                self.pictures.insert(id, Resident { texture, last_used_frame: self.frame });
                Some(layout)
            }
            Err(message) => {
                self.failures.lock().ok()?.insert(id, message);
                // The canvas reports the failure, and has been drawn already in this pass.
                self.window.iter().for_each(egui::Context::request_repaint);
                None
            }
        }
    }

    /// Once, after all panes were prepared: removes pictures beyond the budget not seen in this frame, oldest first.
    pub(super) fn end_frame(&mut self) {
        // Every pane's callback ends the frame, and only the first of them counts.
        if !std::mem::take(&mut self.frame_open) {
            return;
        }
        let frame = self.frame;
        let mut bytes: u64 = self.pictures.values().map(|p| p.texture.layout.bytes()).sum();
        let unseen = self.pictures.iter().filter(|(_, p)| p.last_used_frame < frame);
        let mut unseen: Vec<(u64, PictureId)> = unseen.map(|(&id, p)| (p.last_used_frame, id)).collect();
        unseen.sort_unstable();
        for (_, id) in unseen {
            if bytes <= self.budget_bytes {
                break;
            }
            bytes -= self.pictures.remove(&id).map_or(0, |p| p.texture.layout.bytes());
            // A bind group would keep the texture's memory alive.
            self.panes.retain(|_, pane| pane.picture != id);
        }
        self.panes.retain(|_, pane| frame - pane.last_used_frame < PANE_LIFETIME_FRAMES);
        self.frame += 1;
    }

    pub(super) fn paint(&self, pane: u64, pass: &mut wgpu::RenderPass<'static>) {
        if let Some(pane) = self.panes.get(&pane) {
            pass.set_pipeline(&self.pipeline);
            pass.set_bind_group(0, &pane.bind_group, &[]);
            pass.draw(0..3, 0..1);
        }
    }
}

fn pipeline(device: &wgpu::Device, target: wgpu::TextureFormat) -> wgpu::RenderPipeline {
    let module = device.create_shader_module(wgpu::include_wgsl!("picture.wgsl"));
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("burstscope picture"),
        // That of the shader's bindings.
        layout: None,
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("vs_main"),
            buffers: &[],
            compilation_options: Default::default(),
        },
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some("fs_main"),
            targets: &[Some(wgpu::ColorTargetState {
                format: target,
                blend: Some(wgpu::BlendState::PREMULTIPLIED_ALPHA_BLENDING),
                write_mask: wgpu::ColorWrites::ALL,
            })],
            compilation_options: Default::default(),
        }),
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: None,
        multisample: wgpu::MultisampleState::default(),
        multiview_mask: None,
        cache: None,
    })
}

/// Creates a texture of all colour maps: 256 columns, one row for each map in the order of [`ColourMap::ALL`].
fn lut_texture(device: &wgpu::Device, queue: &wgpu::Queue) -> wgpu::TextureView {
    let colours = ColourMap::ALL.into_iter().flat_map(ColourMap::lut);
    let bytes: Vec<u8> = colours.flat_map(|[r, g, b]| [r, g, b, 255]).collect();
    let size = wgpu::Extent3d { width: 256, height: ColourMap::ALL.len() as u32, depth_or_array_layers: 1 };
    // Not sRGB, which would convert the values of the maps as they are read.
    let (format, usage) = (wgpu::TextureFormat::Rgba8Unorm, wgpu::TextureUsages::TEXTURE_BINDING);
    let described = flat_texture("burstscope colour maps", size, format, usage);
    let texture = device.create_texture_with_data(queue, &described, TextureDataOrder::LayerMajor, &bytes);
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

/// Uniforms of the shader; field by field those of `picture.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Uniforms {
    /// Anchor in the framebuffer, in pixels of the screen.
    pub origin_px: [f32; 2],
    /// Place of the picture shown at the anchor, in its pixels.
    pub anchor_picture: [f32; 2],
    /// Colour towards which a dimmed picture fades, sRGB in [0, 1].
    pub backdrop: [f32; 3],
    pub picture_px_per_px: f32,
    pub size: [u32; 2],
    pub tile: [u32; 2],
    pub tiles_across: u32,
    pub level: u32,
    pub lut_row: u32,
    /// Bits: 1, diverging map; 2, target converts from linear light; 4, screen pixels show the mean of what they cover.
    pub flags: u32,
    pub range_min: f32,
    /// 1 / width of the value range.
    pub range_scale: f32,
    /// 1 / gamma.
    pub exponent: f32,
    pub dim: f32,
}

#[derive(Debug, Clone)]
pub struct PicturePaint {
    pub pane: egui::Id,
    pub id: PictureId,
    /// Values of the picture; read only when it is not on the card yet.
    pub plane: Arc<Plane>,
    /// Transform from pixels of the picture (centre of the first one at 0) to points of the window.
    pub ui_from_picture: RectTransform,
    pub display: Display,
    /// Dimming: 0 none, 1 that of a stale picture.
    pub dim: f32,
    pub backdrop: egui::Color32,
}

impl PicturePaint {
    fn uniforms(&self, pixels_per_point: f32, layout: Layout, target_is_srgb: bool) -> Uniforms {
        let RectTransform { anchor_from: anchor, anchor_to: origin_ui, .. } = self.ui_from_picture;
        let display = self.display.sanitised();
        let backdrop = [self.backdrop.r(), self.backdrop.g(), self.backdrop.b()].map(|c| f32::from(c) / 255.0);
        let ratio = 1.0 / (self.ui_from_picture.scale() * pixels_per_point);
        // 1 where it differs only by rounding, so that pixels are copied and not mixed with neighbours.
        let picture_px_per_px = if (ratio - 1.0).abs() < 1e-5 { 1.0 } else { ratio };
        Uniforms {
            origin_px: [origin_ui.x * pixels_per_point, origin_ui.y * pixels_per_point],
            anchor_picture: [anchor.x, anchor.y],
            backdrop,
            picture_px_per_px,
            size: layout.size.into(),
            tile: layout.tile.into(),
            tiles_across: layout.tiles.0,
            level: layout.level_for(picture_px_per_px),
            lut_row: display.map as u32,
            flags: u32::from(display.map.is_diverging())
                + 2 * u32::from(target_is_srgb)
                + 4 * u32::from(picture_px_per_px > 1.0),
            range_min: display.min,
            range_scale: 1.0 / (display.max - display.min),
            exponent: 1.0 / display.gamma,
            dim: self.dim.clamp(0.0, 1.0),
        }
    }
}

impl egui_wgpu::CallbackTrait for PicturePaint {
    fn prepare(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        screen: &egui_wgpu::ScreenDescriptor,
        _encoder: &mut wgpu::CommandEncoder,
        resources: &mut egui_wgpu::CallbackResources,
    ) -> Vec<wgpu::CommandBuffer> {
        if let Some(renderer) = resources.get_mut::<PictureRenderer>() {
            renderer.prepare(device, queue, self, screen.pixels_per_point);
        }
        Vec::new()
    }

    fn finish_prepare(
        &self,
        _device: &wgpu::Device,
        _queue: &wgpu::Queue,
        _encoder: &mut wgpu::CommandEncoder,
        resources: &mut egui_wgpu::CallbackResources,
    ) -> Vec<wgpu::CommandBuffer> {
        if let Some(renderer) = resources.get_mut::<PictureRenderer>() {
            renderer.end_frame();
        }
        Vec::new()
    }

    fn paint(
        &self,
        _info: egui::PaintCallbackInfo,
        pass: &mut wgpu::RenderPass<'static>,
        resources: &egui_wgpu::CallbackResources,
    ) {
        if let Some(renderer) = resources.get::<PictureRenderer>() {
            renderer.paint(self.pane.value(), pass);
        }
    }
}
