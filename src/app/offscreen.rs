//! Window without a display: runs frames as a window would, and draws the last one into a picture in memory.
//!
//! It needs a graphics adapter that Vulkan, Metal or DirectX can reach; Mesa's software adapter is enough.

use super::gpu::{self, AdapterChoice};
use crate::error::{Error, ErrorKind};
use crate::monitor::Monitor;
use egui_wgpu::{RenderState, RendererOptions, ScreenDescriptor, WgpuConfiguration, WgpuError, WgpuSetup};
use image::RgbaImage;
use std::time::{Duration, Instant};

/// Minimum number of frames run, so that everything measured in one frame and placed in the next has settled.
const MIN_FRAMES: usize = 3;

pub struct Offscreen {
    pub context: egui::Context,
    setup: WgpuSetup,
    pub render_state: RenderState,
    size_points: egui::Vec2,
    pixels_per_point: f32,
    size_px: [u32; 2],
    start: Instant,
    shapes: Vec<egui::epaint::ClippedShape>,
}

#[derive(Debug)]
pub struct Rendered {
    pub image: RgbaImage,
    /// `false` when the time ran out first: the picture shows the state at that moment.
    pub settled: bool,
}

const BYTES_PER_PIXEL: u64 = 4;

/// Longest side of a drawn window, pixels: a software adapter takes minutes for one that is twice as large.
pub const MAX_SIDE_PX: u32 = 8192;

impl Offscreen {
    pub fn new(size_points: egui::Vec2, pixels_per_point: f32, choice: AdapterChoice) -> Result<Self, Error> {
        Self::with_setup(size_points, pixels_per_point, gpu::wgpu_setup(choice))
    }

    fn with_setup(size_points: egui::Vec2, pixels_per_point: f32, setup: WgpuSetup) -> Result<Self, Error> {
        let render_state = new_render_state(&setup)?;
        let limits = render_state.device.limits();
        let limit = limits.max_texture_dimension_2d.min(MAX_SIDE_PX);
        // The pixels are read back in one buffer.
        let max_pixels = limits.max_buffer_size / BYTES_PER_PIXEL;
        let size = size_points * pixels_per_point;
        let fits = |x: f32| x.is_finite() && x.round() >= 1.0 && x.round() <= limit as f32;
        let fits_buffer = (size.x.round() as u64).saturating_mul(size.y.round() as u64) <= max_pixels;
        if !(fits(size.x) && fits(size.y) && fits_buffer && pixels_per_point > 0.0) {
            let max_megapixels = max_pixels / 1_000_000;
            let problem = format!(
                "a window of {} × {} pixels cannot be drawn; this graphics adapter draws 1 to {limit} pixels a side and \
                 {max_megapixels} megapixels in all",
                size.x, size.y
            );
            return Err(Error::new(ErrorKind::TooLarge, problem, "name a smaller size or scale"));
        }
        let context = egui::Context::default();
        // No one sees the drawing: animations are skipped.
        context.all_styles_mut(|style| style.animation_time = 0.0);
        gpu::install(&context, &render_state);
        let size_px = [size.x.round() as u32, size.y.round() as u32];
        let (start, shapes) = (Instant::now(), Vec::new());
        Ok(Self { context, setup, render_state, size_points, pixels_per_point, size_px, start, shapes })
    }

    fn is_lost(&self) -> bool {
        // A lost device is reported while it is polled; the result of the poll itself does not matter.
        let _ = self.render_state.device.poll(wgpu::PollType::Poll);
        gpu::Gpu::of(&self.context).is_some_and(|gpu| gpu.lost().is_some())
    }

    fn set_up_again(&mut self) -> Result<(), Error> {
        self.render_state = new_render_state(&self.setup)?;
        gpu::install(&self.context, &self.render_state);
        let mut renderer = self.render_state.renderer.write();
        for (id, whole) in gpu::textures_of(&self.context) {
            renderer.update_texture(&self.render_state.device, &self.render_state.queue, id, &whole);
        }
        Ok(())
    }

    /// Runs one frame with `events` as input; returns the time until the window wants the next one.
    pub fn frame(&mut self, events: Vec<egui::Event>, draw: impl FnMut(&mut egui::Ui)) -> Duration {
        let mut input = egui::RawInput {
            screen_rect: Some(egui::Rect::from_min_size(egui::Pos2::ZERO, self.size_points)),
            max_texture_side: Some(self.render_state.device.limits().max_texture_dimension_2d as usize),
            time: Some(self.start.elapsed().as_secs_f64()),
            focused: true,
            events,
            ..Default::default()
        };
        let viewport = input.viewports.entry(egui::ViewportId::ROOT).or_default();
        viewport.native_pixels_per_point = Some(self.pixels_per_point);
        let mut output = self.context.run_ui(input, draw);
        let mut renderer = self.render_state.renderer.write();
        for (id, deltas) in output.textures_delta.set.drain() {
            for delta in deltas {
                renderer.update_texture(&self.render_state.device, &self.render_state.queue, id, &delta);
            }
        }
        for id in output.textures_delta.free.drain() {
            renderer.free_texture(&id);
        }
        self.shapes = output.shapes;
        output.viewport_output.get(&egui::ViewportId::ROOT).map_or(Duration::MAX, |v| v.repaint_delay)
    }

    /// Draws the last frame. A lost device is set up again, once.
    pub fn image(&mut self) -> Result<RgbaImage, Error> {
        let failure = |context: &egui::Context| gpu::Gpu::of(context).and_then(|gpu| gpu.newest_failure());
        let before = failure(&self.context);
        let drawn = (!self.is_lost()).then(|| self.draw());
        let drawn = match drawn.filter(|_| !self.is_lost()) {
            Some(drawn) => drawn?,
            None => {
                self.set_up_again()?;
                self.draw()?
            }
        };
        let failed = failure(&self.context).filter(|newest| before.as_ref() != Some(newest));
        failed.map_or(Ok(drawn), |(_, why)| Err(Error::new(ErrorKind::NoMemory, why, "")))
    }

    fn draw(&self) -> Result<RgbaImage, Error> {
        let RenderState { device, queue, renderer, target_format, .. } = &self.render_state;
        let screen = ScreenDescriptor { size_in_pixels: self.size_px, pixels_per_point: self.pixels_per_point };
        let primitives = self.context.tessellate(self.shapes.clone(), self.pixels_per_point);
        let mut encoder = device.create_command_encoder(&Default::default());
        let mut renderer = renderer.write();
        let mut commands = renderer.update_buffers(device, queue, &mut encoder, &primitives, &screen);
        let [width, height] = self.size_px;
        let size = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
        let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC;
        let texture = device.create_texture(&gpu::flat_texture("burstscope offscreen", size, *target_format, usage));
        let view = texture.create_view(&Default::default());
        let ops = wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::BLACK), store: wgpu::StoreOp::Store };
        let attachment = wgpu::RenderPassColorAttachment { view: &view, resolve_target: None, ops, depth_slice: None };
        let pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("burstscope offscreen"),
            color_attachments: &[Some(attachment)],
            ..Default::default()
        });
        // The pass ends with this statement.
        renderer.render(&mut pass.forget_lifetime(), &primitives, &screen);
        commands.push(encoder.finish());
        queue.submit(commands);
        read_back(device, queue, &texture)
    }
}

fn new_render_state(setup: &WgpuSetup) -> Result<RenderState, Error> {
    let instance = pollster::block_on(setup.new_instance());
    let configuration = WgpuConfiguration { wgpu_setup: setup.clone(), ..Default::default() };
    // Predictable: no dithering, the same texture filter on every card.
    let options = RendererOptions::PREDICTABLE;
    pollster::block_on(RenderState::create(&configuration, &instance, None, options)).map_err(|error| match error {
        WgpuError::RequestAdapterError(e) => no_adapter(&e.to_string()),
        WgpuError::CustomNativeAdapterSelectionError(e) => no_adapter(&e),
        other => Error::new(ErrorKind::Failed, format!("the graphics adapter cannot be used: {other}"), ""),
    })
}

fn no_adapter(reason: &str) -> Error {
    let problem = format!("there is no graphics adapter to draw with ({reason})");
    let remedy = "install a software one (on Debian and Ubuntu: apt install mesa-vulkan-drivers), or use a machine \
                  with a Vulkan driver";
    Error::new(ErrorKind::Failed, problem, remedy)
}

/// Runs frames of `draw` until `is_idle`, `max_duration` is over or `monitor` is cancelled, and draws the last one.
pub fn render_offscreen<App>(
    size_points: egui::Vec2,
    pixels_per_point: f32,
    max_duration: Duration,
    monitor: &Monitor,
    make: impl FnOnce(&egui::Context, &RenderState) -> App,
    mut draw: impl FnMut(&mut App, &mut egui::Ui),
    mut is_idle: impl FnMut(&mut App) -> bool,
) -> Result<Rendered, Error> {
    let mut offscreen = Offscreen::new(size_points, pixels_per_point, AdapterChoice::Fastest)?;
    let mut app = make(&offscreen.context, &offscreen.render_state);
    let end = Instant::now() + max_duration;
    let mut idle_frames = 0;
    for frame in 1.. {
        let delay = offscreen.frame(Vec::new(), |ui| draw(&mut app, ui));
        // One more frame after the last answer shows the answer.
        idle_frames = if is_idle(&mut app) { idle_frames + 1 } else { 0 };
        let has_settled = frame >= MIN_FRAMES && idle_frames >= 2;
        if has_settled || Instant::now() >= end || monitor.is_cancelled() {
            break;
        }
        if idle_frames == 0 {
            std::thread::sleep(delay.min(Duration::from_millis(10)));
        }
    }
    Ok(Rendered { image: offscreen.image()?, settled: idle_frames >= 2 })
}

/// Time allowed to the card for each [`TIMED_PIXELS`] of a frame. A software adapter needs a fraction of a second.
const CARD_TIMEOUT: Duration = Duration::from_secs(30);
const TIMED_PIXELS: u32 = 1 << 23;

fn read_back(device: &wgpu::Device, queue: &wgpu::Queue, texture: &wgpu::Texture) -> Result<RgbaImage, Error> {
    let (width, height) = (texture.width(), texture.height());
    let row_bytes = 4 * width as usize;
    let padded_bytes = row_bytes.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT as usize);
    let usage = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST;
    let (label, size) = (Some("burstscope offscreen"), (padded_bytes * height as usize) as u64);
    let buffer = device.create_buffer(&wgpu::BufferDescriptor { label, size, usage, mapped_at_creation: false });
    let mut encoder = device.create_command_encoder(&Default::default());
    let bytes_per_row = Some(padded_bytes as u32);
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row, rows_per_image: None };
    let into = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
    encoder.copy_texture_to_buffer(texture.as_image_copy(), into, texture.size());
    let submission = queue.submit([encoder.finish()]);
    let timeout = CARD_TIMEOUT * (width * height).div_ceil(TIMED_PIXELS);
    let (sender, receiver) = std::sync::mpsc::channel();
    buffer.map_async(wgpu::MapMode::Read, .., move |result| {
        // The receiver is gone when the wait has timed out.
        let _ = sender.send(result);
    });
    let failed = |error: &dyn std::fmt::Display| {
        Error::new(ErrorKind::Failed, format!("the graphics adapter failed while drawing: {error}"), "")
    };
    let wait = wgpu::PollType::Wait { submission_index: Some(submission), timeout: Some(timeout) };
    device.poll(wait).map_err(|e| failed(&e))?;
    receiver.recv_timeout(timeout).map_err(|e| failed(&e))?.map_err(|e| failed(&e))?;
    let mapped = buffer.get_mapped_range(..).map_err(|e| failed(&e))?;
    let rows: Vec<&[u8]> = mapped.chunks_exact(padded_bytes).map(|row| &row[..row_bytes]).collect();
    // Without a surface egui's target is Rgba8Unorm; other formats would need their channels reordered.
    debug_assert_eq!(texture.format(), wgpu::TextureFormat::Rgba8Unorm);
    RgbaImage::from_raw(width, height, rows.concat()).ok_or_else(|| failed(&"the answer had the wrong size"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::vec2;

    #[test]
    fn waits_for_idle_and_gives_up_in_time() {
        let draw = |count: &mut usize, ui: &mut egui::Ui| {
            *count += 1;
            ui.label("hello");
        };
        for (millis, frames, settles) in [(20_000, 5, true), (50, usize::MAX, false)] {
            let (size, time) = (vec2(80.0, 30.0), Duration::from_millis(millis));
            let drawn = render_offscreen(size, 1.0, time, &Monitor::default(), |_, _| 0, draw, |n| *n > frames);
            assert_eq!(drawn.unwrap().settled, settles);
        }
    }

    #[test]
    fn no_adapter_and_odd_sizes_are_errors_that_help() {
        let WgpuSetup::CreateNew(mut none) = gpu::wgpu_setup(AdapterChoice::Fastest) else {
            panic!("the program makes its own device");
        };
        none.instance_descriptor.backends = wgpu::Backends::empty();
        let error = Offscreen::with_setup(vec2(10.0, 10.0), 1.0, none.into()).err().unwrap();
        let helps = error.problem.contains("no graphics adapter") && error.remedy.contains("mesa-vulkan-drivers");
        assert!(helps, "{error}");
        for size in [vec2(0.0, 10.0), vec2(1e9, 10.0), vec2(f32::NAN, 10.0), vec2(16384.0, 200.0)] {
            let error = Offscreen::new(size, 1.0, AdapterChoice::Software).err().unwrap();
            assert_eq!(error.kind, ErrorKind::TooLarge, "{error}");
        }
    }
}
