//! Signal-to-noise ratio of a spot, measured in the shown picture, while frames are added one by one.

use crate::app::document::{Action, Queue};
use crate::app::results::Read;
use crate::app::{panel::cursor_row::CursorRow, panel::widgets::still_plot, parts};
use crate::detector::Slope;
use crate::inspect::place::{SpotSnr, spot_snr};
use crate::inspect::words::counted;
use crate::requests::{PictureKind, ViewKind};
use crate::teach::{Part, Spot};
use egui::{Color32, Rect, RichText, Ui, pos2};
use egui_plot::{Line, PlotPoints, Points};
use std::collections::BTreeMap;
use std::time::{Duration, Instant};

const EVERY: Duration = Duration::from_millis(450);
const HEIGHT: f32 = 130.0;

#[derive(Debug, Default)]
pub(in crate::app) struct SnrTrace {
    slope: Option<Slope>,
    measured: BTreeMap<usize, f32>,
    /// Largest ratio at any slope. It stays on the axis, so that a smaller ratio is seen to be small.
    largest: f32,
    /// When the next frame is added, while frames are.
    pub(super) next: Option<Instant>,
}

impl SnrTrace {
    fn take(&mut self, slope: Slope, frames: usize, ratio: f32) {
        if self.slope != Some(slope) {
            (self.slope, self.measured) = (Some(slope), BTreeMap::new());
        }
        self.measured.insert(frames, ratio);
        self.largest = self.largest.max(ratio);
    }

    /// Factor c of the law c·√N that fits the measurements best.
    fn of_one_frame(&self) -> Option<f64> {
        let weights: f64 = self.measured.keys().map(|n| *n as f64).sum();
        let sum: f64 = self.measured.iter().map(|(n, ratio)| f64::from(*ratio) * (*n as f64).sqrt()).sum();
        (weights > 0.0).then(|| sum / weights)
    }
}

/// Number of frames in the shown picture, and the place of the spot in it.
pub(super) fn shown_spot(model: Read<'_>, spot: Spot, slope: Slope) -> Option<(usize, [f32; 2])> {
    let picture = model.picture()?;
    let used = picture.request.params.used_frames(model.frame_count());
    // Position of the picture from mid-burst of the whole burst.
    let positions = &picture.request.burst.burst.positions;
    let (frames, after) = match picture.request.kind {
        PictureKind::Frame(t) => (1, positions.offset(t)),
        PictureKind::Stack { .. } => {
            let mean = positions.offset(used.start) - positions.offset_from(used.clone(), used.start);
            (used.len(), mean)
        }
        _ => return None,
    };
    let (moved_u, moved_v) = slope.displacement(after.to_f32());
    Some((frames, [spot.place[0] + moved_u, spot.place[1] + moved_v]))
}

/// Draws the number of frames added, and the measured ratio beside the law of √N. `slope` is the spot's own.
pub(super) fn snr_ui(ui: &mut Ui, model: Read<'_>, trace: &mut SnrTrace, spot: Spot, slope: Slope, queue: &mut Queue) {
    let top = ui.cursor().min;
    frames_ui(ui, model, trace, queue);
    let below = |ui: &Ui, top| Rect::from_min_max(top, pos2(ui.max_rect().right(), ui.min_rect().bottom()));
    parts::mark(ui, Part::FramesAdded, below(ui, top));
    ui.add_space(4.0);
    let top = ui.cursor().min;
    let now = shown_spot(model, spot, slope).and_then(|(frames, place)| {
        let picture = model.picture().filter(|_| model.picture_is_current())?;
        Some((frames, spot_snr(&picture.plane, place, spot.inner, spot.ground)?))
    });
    if let Some((frames, snr)) = now {
        let at = trace.slope.filter(|_| frames == 1).unwrap_or(model.document.cursor().slope);
        trace.take(at, frames, snr.ratio());
        let SpotSnr { signal, noise, .. } = snr;
        ui.horizontal_wrapped(|ui| {
            ui.label(RichText::new(format!("SNR {:.2}", snr.ratio())).strong());
            let with = counted(frames, "frame");
            ui.weak(format!("measured with {with}; √{frames} = {:.2}", (frames as f32).sqrt()));
        })
        .response
        .on_hover_text(format!(
            "The spot is {signal:.4} of full scale above the background; the noise of a pixel is {noise:.4}"
        ));
    } else {
        let is_coming = !model.picture_is_current();
        ui.weak(if is_coming { "Measuring…" } else { "SNR: show a frame or the motion stack to measure it" });
    }
    plot_ui(ui, model.frame_count(), trace, now.map(|(frames, _)| frames));
    parts::mark(ui, Part::Snr, below(ui, top));
}

fn frames_shown(model: Read<'_>) -> usize {
    let pane = model.document.focused();
    let is_frame = pane.content == crate::app::pane::Content::Cursor && pane.cursor.kind == ViewKind::Frame;
    if is_frame { 1 } else { model.document.params.used_frames(model.frame_count()).len() }
}

fn frames_ui(ui: &mut Ui, model: Read<'_>, trace: &mut SnrTrace, queue: &mut Queue) {
    let all = model.frame_count();
    let mut count = frames_shown(model) as f32;
    let help = "How many frames are shifted and added, from the first one on";
    if CursorRow::whole("Frames", help, 1.0..=all.max(1) as f32).ui(ui, &mut count) {
        trace.next = None;
        queue.push(Action::UseFrames(count as usize));
    }
    let is_playing = trace.next.is_some();
    let label = if is_playing { "⏸ Stop" } else { "▶ Add one by one" };
    if ui.button(label).on_hover_text("Begin with one frame and add the next ones, one after the other").clicked() {
        trace.next = (!is_playing).then(|| Instant::now() + EVERY);
        queue.push_if(!is_playing, Action::UseFrames(1));
    }
    let Some(next) = trace.next else { return };
    // The next frame is added once the picture of the present ones is shown.
    if Instant::now() >= next && model.picture_is_current() {
        let shown = frames_shown(model);
        queue.push(Action::UseFrames(shown + 1));
        trace.next = (shown + 1 < all).then(|| Instant::now() + EVERY);
    }
    ui.ctx().request_repaint_after(EVERY / 4);
}

fn plot_ui(ui: &mut Ui, all: usize, trace: &SnrTrace, now: Option<usize>) {
    let law = ui.visuals().weak_text_color();
    let points: Vec<[f64; 2]> = trace.measured.iter().map(|(n, ratio)| [*n as f64, f64::from(*ratio)]).collect();
    let count = points.len();
    let one = trace.of_one_frame().unwrap_or(0.0);
    let top = 1.15 * f64::from(trace.largest).max(0.1).max(one * (all as f64).sqrt());
    still_plot("snr over frames")
        .height(HEIGHT)
        .show_x(false)
        .show_y(false)
        .x_axis_label("frames N")
        .y_axis_label("SNR")
        .y_grid_spacer(crate::app::ticks::of_height)
        .include_x(0.0)
        .include_x(all as f64 + 0.5)
        .include_y(0.0)
        .include_y(top)
        .show(ui, |plot| {
            let frames = (0..=20 * all).map(|i| f64::from(i as u32) / 20.0);
            let curve: Vec<[f64; 2]> = frames.map(|n| [n, one * n.sqrt()]).collect();
            plot.line(Line::new("√N", PlotPoints::from(curve)).color(law).width(1.5));
            let here = points.iter().copied().filter(|point| Some(point[0] as usize) == now).collect::<Vec<_>>();
            plot.points(Points::new("measured", PlotPoints::from(points)).color(crate::app::style::ACCENT).radius(4.0));
            plot.points(Points::new("now", PlotPoints::from(here)).color(Color32::from_rgb(255, 200, 60)).radius(5.5));
        });
    ui.weak(format!("{} measured    line: c·√N", counted(count, "dot")));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_law_goes_through_what_follows_it() {
        let mut trace = SnrTrace::default();
        assert_eq!(trace.of_one_frame(), None);
        for n in [1usize, 4, 9] {
            trace.take(Slope::new(1.0, 0.0), n, 0.7 * (n as f32).sqrt());
        }
        assert!((trace.of_one_frame().expect("measured") - 0.7).abs() < 1e-6);
        trace.take(Slope::new(2.0, 0.0), 4, 9.0);
        assert_eq!(trace.measured.len(), 1, "of another slope everything is measured anew");
        trace.take(Slope::new(1.0, 0.0), 4, 0.5);
        assert_eq!(trace.largest, 9.0, "the axis keeps what was largest");
    }
}
