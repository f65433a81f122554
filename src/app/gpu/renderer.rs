//! Resources kept on the card between frames: the pipeline, the colour maps, the pictures and one bind group for each
//! pane.

use super::PictureId;
use super::layout::Layout;
use super::limits::DeviceLimits;
use super::pipeline::{bind_group, bind_group_layout, lut_texture, pipeline};
use super::texture::PictureTexture;
use super::uniforms::Uniforms;
use crate::plane::Plane;
use crate::plane::display::ColourMap;
use std::collections::HashMap;
use std::sync::{Arc, Mutex};

/// Memory of the pictures on the card, bytes; beyond it those unused for longest are removed.
const BUDGET_BYTES: u64 = 512 << 20;

/// Number of frames after which a pane that is not drawn loses its bind group.
const PANE_LIFETIME_FRAMES: u64 = 600;

/// Reasons why pictures could not be uploaded.
pub type Failures = Arc<Mutex<HashMap<PictureId, String>>>;

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
    layout: wgpu::BindGroupLayout,
    lut: wgpu::TextureView,
    limits: DeviceLimits,
    target_is_srgb: bool,
    pictures: HashMap<PictureId, Resident>,
    panes: HashMap<u64, Pane>,
    failures: Failures,
    frame: u64,
    frame_open: bool,
    uploads: u64,
}

impl PictureRenderer {
    /// Creates the pipeline and the table of colour maps.
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue, target: wgpu::TextureFormat, limits: DeviceLimits) -> Self {
        let layout = bind_group_layout(device);
        Self {
            pipeline: pipeline(device, &layout, target),
            lut: lut_texture(device, queue),
            layout,
            limits,
            target_is_srgb: target.is_srgb(),
            pictures: HashMap::new(),
            panes: HashMap::new(),
            failures: Failures::default(),
            frame: 0,
            frame_open: false,
            uploads: 0,
        }
    }

    /// Map in which failed uploads are noted.
    pub fn failures(&self) -> Failures {
        self.failures.clone()
    }

    /// Number of pictures uploaded so far.
    pub fn uploads(&self) -> u64 {
        self.uploads
    }

    /// Size of the pictures on the card, bytes.
    pub fn resident_bytes(&self) -> u64 {
        self.pictures.values().map(|p| p.texture.layout.bytes()).sum()
    }

    /// Uploads the picture if it is missing, and makes the pane's bind group show it. The caller fills in `uniforms`,
    /// except for values that depend on the picture's layout in its texture.
    pub(super) fn prepare(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        pane: u64,
        (id, plane): (PictureId, &Plane),
        mut uniforms: Uniforms,
    ) {
        self.frame_open = true;
        let Some(layout) = self.ensure_picture(device, queue, id, plane) else {
            self.panes.remove(&pane);
            return;
        };
        uniforms.size = layout.size.into();
        uniforms.tile = layout.tile.into();
        uniforms.tiles_across = layout.tiles.0;
        uniforms.level = layout.level_for(uniforms.picture_px_per_px);
        uniforms.flags |= if self.target_is_srgb { 2 } else { 0 };

        let view = &self.pictures[&id].texture.view;
        let pane = self.panes.entry(pane).or_insert_with(|| {
            let buffer = device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("burstscope pane"),
                size: size_of::<Uniforms>() as u64,
                usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            });
            let bind_group = bind_group(device, &self.layout, &buffer, view, &self.lut);
            Pane { buffer, bind_group, picture: id, last_used_frame: 0 }
        });
        if pane.picture != id {
            pane.bind_group = bind_group(device, &self.layout, &pane.buffer, view, &self.lut);
            pane.picture = id;
        }
        pane.last_used_frame = self.frame;
        queue.write_buffer(&pane.buffer, 0, bytemuck::bytes_of(&uniforms));
    }

    fn ensure_picture(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        id: PictureId,
        plane: &Plane,
    ) -> Option<Layout> {
        if let Some(resident) = self.pictures.get_mut(&id) {
            resident.last_used_frame = self.frame;
            return Some(resident.texture.layout);
        }
        let mut failures = self.failures.lock().ok()?;
        if failures.contains_key(&id) {
            return None;
        }
        let texture = Layout::new(plane.size(), self.limits)
            .and_then(|layout| PictureTexture::upload(device, queue, plane, layout));
        match texture {
            Ok(texture) => {
                let layout = texture.layout;
                self.uploads += 1;
                self.pictures.insert(id, Resident { texture, last_used_frame: self.frame });
                Some(layout)
            }
            Err(message) => {
                failures.insert(id, message);
                None
            }
        }
    }

    /// Ends the frame, once, after all panes were prepared: removes pictures beyond the budget that were not seen in
    /// this frame, oldest first.
    pub(super) fn end_frame(&mut self) {
        if !std::mem::take(&mut self.frame_open) {
            return;
        }
        let frame = self.frame;
        let mut bytes = self.resident_bytes();
        if bytes > BUDGET_BYTES {
            let mut unseen: Vec<(u64, PictureId)> = self
                .pictures
                .iter()
                .filter(|(_, p)| p.last_used_frame < frame)
                .map(|(&id, p)| (p.last_used_frame, id))
                .collect();
            unseen.sort_unstable();
            for (_, id) in unseen {
                if bytes <= BUDGET_BYTES {
                    break;
                }
                bytes -= self.pictures.remove(&id).map_or(0, |p| p.texture.layout.bytes());
                // A bind group would keep the texture's memory alive.
                self.panes.retain(|_, pane| pane.picture != id);
            }
        }
        self.panes.retain(|_, pane| frame - pane.last_used_frame < PANE_LIFETIME_FRAMES);
        self.frame += 1;
    }

    /// Draws the pane into the viewport that egui has set.
    pub(super) fn paint(&self, pane: u64, pass: &mut wgpu::RenderPass<'static>) {
        if let Some(pane) = self.panes.get(&pane) {
            pass.set_pipeline(&self.pipeline);
            pass.set_bind_group(0, &pane.bind_group, &[]);
            pass.draw(0..3, 0..1);
        }
    }
}

/// Row of `map` in the table.
pub(super) fn lut_row(map: ColourMap) -> u32 {
    ColourMap::ALL.iter().position(|&m| m == map).unwrap_or(0) as u32
}
