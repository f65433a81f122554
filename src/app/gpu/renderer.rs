//! What stays on the card between frames: the pipeline, the colour maps, the pictures and one bind group for each pane.

use super::PictureId;
use super::layout::Layout;
use super::limits::DeviceLimits;
use super::pipeline::{bind_group, bind_group_layout, lut_texture, pipeline};
use super::texture::PictureTexture;
use super::uniforms::Uniforms;
use crate::plane::Plane;
use crate::plane::colour_map::ColourMap;
use std::collections::HashMap;
use std::sync::{Arc, Mutex};

/// Pictures stay on the card until they take more than this; then those not seen for longest go.
const BUDGET_BYTES: u64 = 512 << 20;

/// Panes not drawn for this many frames lose their bind group.
const PANE_LIFETIME_FRAMES: u64 = 600;

/// Why pictures could not be brought to the card.
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

/// Everything the paint callbacks share. Lives in egui's callback resources.
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
    /// Makes the pipeline and the table of colour maps.
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

    /// Where failed uploads are noted.
    pub fn failures(&self) -> Failures {
        self.failures.clone()
    }

    /// How many pictures were brought to the card so far.
    pub fn uploads(&self) -> u64 {
        self.uploads
    }

    /// Bytes of the pictures on the card.
    pub fn resident_bytes(&self) -> u64 {
        self.pictures.values().map(|p| p.texture.layout.bytes()).sum()
    }

    /// Makes sure that the picture is on the card and that the pane's bind group shows it. `uniforms` are filled in by
    /// the caller, except for what depends on how the picture lies in its texture.
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

    /// Ends the frame, once, after all panes were prepared: what is over the budget and was not seen in this frame
    /// goes, oldest first.
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
                // A bind group would keep the texture's memory.
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
