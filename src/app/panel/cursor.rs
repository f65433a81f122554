//! Cursor of the focused pane: its sliders and buttons. Slopes along an axis have a slider, and below it bars of
//! features and evidence, with the ends of the searched range, which can be dragged; others have a pad.

use super::slopes::chart::{bar_text, feature_colour, on_line};
use crate::app::actions::{ActionId, Queue, button_ui};
use crate::app::document::cursor::{level_range, octave_range, slope_limit, stepped};
use crate::app::document::{Action, PlayOver, Side};
use crate::app::panel::cursor_row::{CursorRow, slider_track, wheel_over};
use crate::app::panel::widgets::{hint, named, section_ui};
use crate::app::{results::Read, view::nearest};
use crate::detector::scale_space::ScaleSpace;
use crate::detector::{SearchParams, Slope, SlopeAxis, SlopeGrid};
use crate::inspect::slopes::features_at_slopes;
use egui::{CursorIcon, Id, Rangef, Rect, Sense, Stroke, StrokeKind, Ui, pos2, vec2};

pub fn cursor_ui(ui: &mut Ui, model: Read<'_>, queue: &mut Queue) {
    section_ui(ui, "Cursor", |ui| {
        let last = model.focused_frame_count().saturating_sub(1) as f32;
        let mut frame = model.document.cursor().frame as f32;
        let row = CursorRow::whole("Frame", "Index from 0; moving it shows the frame", 0.0..=last);
        let is_moved = row.ui(ui, &mut frame);
        queue.push_if(is_moved, Action::SetFrame(model.document.focus(), frame.max(0.0) as usize));
        slope_rows(ui, model, queue);
        buttons_ui(ui, model, queue);
        if strip_of(ui, model).is_none() {
            slope_pad_ui(ui, model, queue);
        }
        if model.document.cursor().kind.about().of_scale {
            scale_rows(ui, model, queue);
        }
    });
}

const STRIP: &str = "strip of the searched slopes";
const FIELDS: &str = "fields of the searched slopes";

/// Notes where the fields of the searched slopes are: those of the `first` axis, and below them those of the second.
pub(super) fn mark_fields(ui: &Ui, rect_ui: Rect, first: bool) {
    let id = Id::unique(FIELDS);
    ui.data_mut(|data| {
        let above = data.get_temp::<Rect>(id).filter(|_| !first);
        data.insert_temp(id, above.map_or(rect_ui, |above| above.union(rect_ui)));
    });
}

/// Whether a strip below a slider shows the slopes of the second axis, or of the first one; `None` where the pad shows
/// them, which is not where they are on one axis. While the pointer is over the fields of the slopes, or one of them is
/// typed in, that stays, so that they do not move.
fn strip_of(ui: &Ui, model: Read<'_>) -> Option<bool> {
    let grid = model.cursor_params().slopes;
    let is_on_axis = grid.direction_deg == 0.0 && (grid.u.count > 1) != (grid.v.count > 1);
    let now = is_on_axis.then_some(grid.v.count > 1);
    let fields: Option<Rect> = ui.data(|data| data.get_temp(Id::unique(FIELDS)));
    let is_over = ui.input(|i| i.pointer.latest_pos()).zip(fields).is_some_and(|(pos, rect)| rect.contains(pos));
    let is_used = is_over || ui.ctx().memory(|memory| memory.focused()).is_some();
    let last = ui.data(|data| data.get_temp(Id::unique(STRIP)));
    let shown = last.filter(|_| is_used).unwrap_or(now);
    ui.data_mut(|data| data.insert_temp(Id::unique(STRIP), shown));
    shown
}

fn slope_rows(ui: &mut Ui, model: Read<'_>, queue: &mut Queue) {
    let grid = model.cursor_params().slopes;
    let limit = slope_limit(&grid);
    // The slopes of a rotated grid are marked by their components on each axis.
    let marks = |of: fn(Slope) -> f32| {
        let mut marks: Vec<f32> = grid.slopes().map(of).collect();
        marks.sort_by(f32::total_cmp);
        marks.dedup();
        marks
    };
    let before = model.document.cursor().slope;
    let mut slope = before;
    let strip = strip_of(ui, model);
    let rows = [
        ("Slope u", "to the right", &mut slope.u, marks(|s| s.u)),
        ("Slope v", "downwards", &mut slope.v, marks(|s| s.v)),
    ];
    // An axis that is searched alone has a slider; where the pad shows both, two numbers are enough.
    let rows_ui = |ui: &mut Ui| {
        for (second, (label, way, component, marks)) in [false, true].into_iter().zip(rows) {
            let help = &format!("Apparent motion {way}, px/frame. Marks: slopes of the grid; others can be shown too");
            let slides = (strip == Some(second)).then(|| slider_range(&grid, second));
            CursorRow { label, help, range: -limit..=limit, marks: &marks, whole: false, slides }.ui(ui, component);
            if strip == Some(second) {
                strip_ui(ui, model, second, queue);
            }
        }
    };
    match strip {
        Some(_) => rows_ui(ui),
        None => _ = ui.horizontal(rows_ui),
    }
    queue.set(&before, slope, |slope| Action::SetSlope(model.document.focus(), slope));
}

/// Slopes that the slider of an axis of `grid` reaches: those of a range far from 0 alone, so that its ends lie apart.
fn slider_range(grid: &SlopeGrid, second: bool) -> Rangef {
    let SlopeAxis { min, max, .. } = if second { grid.v } else { grid.u };
    let (limit, around) = (slope_limit(grid), Rangef::new(min, max).expand(0.5 * (max - min)));
    if around.contains(0.0) || min == max { Rangef::new(-limit, limit) } else { around }
}

fn buttons_ui(ui: &mut Ui, model: Read<'_>, queue: &mut Queue) {
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        let play = if model.document.playing { "⏸ Pause" } else { "▶ Play" };
        button_ui(ui, model, queue, ActionId::Play, Some(play));
        let mut playing = model.document.play;
        // The choice comes with the playing, and stays where something else than what is shown was chosen.
        if !model.document.playing && playing.over == PlayOver::Shown {
            return;
        }
        let choices = [(PlayOver::Frames, "frames"), (PlayOver::Slopes, "slopes"), (PlayOver::Scales, "scales")];
        let name = choices.iter().find(|(over, _)| *over == model.played()).map_or("", |(_, name)| name);
        let menu = ui.button(format!("{name} ⏷"));
        named(&menu, egui::Role::Button, "What is played");
        egui::Popup::menu(&menu.on_hover_text("What Play steps through, and how fast")).show(|ui| {
            ui.radio_value(&mut playing.over, PlayOver::Shown, "what the picture shows");
            for (over, name) in choices {
                ui.radio_value(&mut playing.over, over, name);
            }
            let rate = egui::DragValue::new(&mut playing.rate).range(1..=30).suffix(" pictures a second");
            ui.add(rate).on_hover_text("Slower where pictures take longer to compute; none is left out");
        });
        queue.edit(model.document, Action::SetPlay(playing));
    });
}

fn scale_rows(ui: &mut Ui, model: Read<'_>, queue: &mut Queue) {
    let octaves = octave_range(model.cursor_params(), model.focused_size());
    let levels = level_range(model.cursor_params());
    let (mut octave, mut level) = (model.document.cursor().octave as f32, model.document.cursor().level as f32);
    let mut row = |label, help, range: std::ops::RangeInclusive<i32>, value| {
        CursorRow::whole(label, help, *range.start() as f32..=*range.end() as f32).ui(ui, value)
    };
    let help = "Octave of the DoG: each is twice as coarse as the one before";
    let is_other_octave = row("Octave", help, octaves, &mut octave);
    let help = "Level within the octave. Features lie at 0 and up; the two outermost levels are only compared with";
    let is_other = row("Level", help, levels, &mut level) || is_other_octave;
    queue.push_if(is_other, Action::SetScale(model.document.focus(), octave as i32, level as i32));
    let space = ScaleSpace::of(model.cursor_params());
    let sigma = space.sigma_image(model.document.cursor().octave, f64::from(model.document.cursor().level));
    let rim = crate::detector::localise::rim_radius(sigma, space.levels);
    let help = format!("Pixels of the input image; discs with a radius of {rim:.1} px respond most strongly");
    ui.weak(format!("Scale σ = {sigma:.2} px")).on_hover_text(help);
}

pub fn slope_pad_ui(ui: &mut Ui, model: Read<'_>, queue: &mut Queue) {
    let side = ui.available_width().min(170.0);
    let (full, _) = ui.allocate_exact_size(vec2(ui.available_width(), side), Sense::hover());
    let rect = egui::Rect::from_center_size(full.center(), vec2(side, side));
    let response = ui.interact(rect, ui.scope_id().with("slope pad"), Sense::click_and_drag());
    let grid = model.cursor_params().slopes;
    let limit = slope_limit(&grid);
    let scale = (0.5 * side - 8.0) / limit;
    let ui_from_slope = |s: Slope| rect.center() + scale * vec2(s.u, s.v);
    let notches = wheel_over(ui, &response);
    if notches != 0 {
        let along_v = ui.input(|i| i.modifiers.shift);
        let before = model.document.cursor().slope;
        let slope = (0..notches.abs()).fold(before, |slope, _| stepped(&grid, slope, along_v, notches > 0));
        queue.push(Action::SetSlope(model.document.focus(), slope));
    }
    if let Some(pos) = response.interact_pointer_pos() {
        let at = (pos - rect.center()) / scale;
        let slope = Slope::new(at.x.clamp(-limit, limit), at.y.clamp(-limit, limit));
        queue.push(Action::SetSlope(model.document.focus(), slope));
    }
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 4.0, ui.visuals().extreme_bg_color);
    painter.rect_stroke(rect, 4.0, ui.visuals().widgets.noninteractive.bg_stroke, StrokeKind::Inside);
    painter.hline(rect.x_range(), rect.center().y, ui.visuals().widgets.noninteractive.bg_stroke);
    painter.vline(rect.center().x, rect.y_range(), ui.visuals().widgets.noninteractive.bg_stroke);
    let found = model.found_of(model.document.focused().side).filter(|f| f.detection.slopes == grid);
    let counts = found.map_or_else(|| vec![0; grid.len()], |found| features_at_slopes(&found.detection));
    let most = counts.iter().copied().max().unwrap_or(0).max(1) as f32;
    let largest = (0.45 * grid.u.step().min(grid.v.step()) * scale).clamp(2.0, 8.0);
    for (slope, &count) in grid.slopes().zip(&counts) {
        let colour = if count > 0 { ui.visuals().hyperlink_color } else { ui.visuals().weak_text_color() };
        let radius = 1.2 + (largest - 1.2) * (count as f32 / most).sqrt();
        painter.circle_filled(ui_from_slope(slope), radius, colour);
    }
    let here = ui_from_slope(model.document.cursor().slope);
    painter.circle_stroke(here, 5.5, Stroke::new(2.0, ui.visuals().strong_text_color()));
    named(&response, egui::Role::Canvas, "Slope plane");
    let help = "Slope plane: u to the right, v downwards. Dots: slopes of the grid, larger where more features were found. Drag to change both; the wheel goes to the next slope along u, with Shift along v.";
    hint(response, help);
}

/// Height of the strip, points.
const HEIGHT: f32 = 30.0;
/// Maximum distance of the pointer from an end of the range, points.
const REACH: f32 = 5.0;

/// Draws the strip below the slider of the first (`second` false) or second axis.
pub fn strip_ui(ui: &mut Ui, model: Read<'_>, second: bool, queue: &mut Queue) {
    let grid = model.cursor_params().slopes;
    let axis = if second { grid.v } else { grid.u };
    let (track, width) = slider_track(ui);
    let (row, _) = ui.allocate_exact_size(vec2(width, HEIGHT), Sense::hover());
    let rect = Rect::from_x_y_ranges(track, row.y_range());
    let ends_id = ui.scope_id().with(("range ends", second));
    // While an end is dragged the slider keeps its scale, or the end would move away from the pointer.
    let dragged: Option<Drag> = ui.data(|data| data.get_temp(ends_id));
    let range = dragged.map_or_else(|| slider_range(&grid, second), |drag| drag.range);
    let x_of = |slope: f32| egui::remap(slope, range, rect.x_range());
    bars_ui(ui, model, second, rect, &x_of);
    for (index, (value, name)) in [(axis.min, "Range start"), (axis.max, "Range end")].into_iter().enumerate() {
        let x = x_of(value).clamp(rect.left() - 2.0, rect.right() + 2.0);
        let grip = Rect::from_center_size(pos2(x, rect.center().y), vec2(2.0 * REACH, rect.height()));
        let response = ui.interact(grip, ends_id.with(index), Sense::drag());
        if response.drag_started() {
            ui.data_mut(|data| data.insert_temp(ends_id, Drag { range, axis }));
        }
        if response.dragged()
            && let (Some(drag), Some(delta)) = (ui.data(|d| d.get_temp::<Drag>(ends_id)), response.total_drag_delta())
        {
            let axis = moved(drag.axis, index == 1, delta.x * range.span() / rect.width());
            let grid = model.grid_of(Side::A);
            let after = if second { SlopeGrid { v: axis, ..grid } } else { SlopeGrid { u: axis, ..grid } };
            if after != grid {
                let after = SearchParams { slopes: after.into(), ..model.document.params.clone() };
                model.document.action_to(after).into_iter().for_each(|action| queue.push(action));
            }
        }
        if response.drag_stopped() {
            ui.data_mut(|data| data.remove::<Drag>(ends_id));
        }
        let lit = response.hovered() || response.dragged();
        let colour = if lit { ui.visuals().strong_text_color() } else { ui.visuals().text_color() };
        ui.painter().vline(x, rect.y_range(), Stroke::new(if lit { 2.5 } else { 1.5 }, colour));
        let knob = Rect::from_center_size(pos2(x, rect.top() + 3.0), vec2(6.0, 6.0));
        ui.painter().rect_filled(knob, 1.0, colour);
        let name = format!("{name} {}", if second { "v" } else { "u" });
        response.widget_info(|| egui::WidgetInfo::slider(true, f64::from(value), &name));
        response
            .on_hover_and_drag_cursor(CursorIcon::ResizeHorizontal)
            .on_hover_text("End of the searched range of slopes; drag it by whole steps");
    }
}

#[derive(Clone, Copy)]
struct Drag {
    range: Rangef,
    axis: SlopeAxis,
}

/// Moves the axis's lower or `upper` end by about `pulled`, by whole steps, so that the other slopes stay.
fn moved(axis: SlopeAxis, upper: bool, pulled: f32) -> SlopeAxis {
    let outwards = (pulled / axis.step()).round() as i64 * if upper { 1 } else { -1 };
    let outwards = outwards.max(2 - axis.count as i64);
    let more = outwards.max(0) as usize;
    let wider = if upper { axis.with_more(0, more) } else { axis.with_more(more, 0) };
    let fewer = (-outwards).max(0) as f32;
    let [lower, upper] = if upper { [0.0, fewer] } else { [fewer, 0.0] };
    let (min, max) = (wider.min + lower * axis.step(), wider.max - upper * axis.step());
    SlopeAxis { min, max, count: wider.count - fewer as usize }
}

fn bars_ui(ui: &Ui, model: Read<'_>, second: bool, rect: Rect, x_of: &dyn Fn(f32) -> f32) {
    let painter = ui.painter_at(rect.expand2(vec2(3.0, 0.0)));
    painter.rect_filled(rect.expand2(vec2(3.0, 0.0)), 2.0, ui.visuals().extreme_bg_color);
    let response = ui.interact(rect, ui.scope_id().with(("slope strip", second)), Sense::hover());
    named(&response, egui::Role::Image, "Features and evidence below the slider");
    let Some(spectrum) = model.spectrum().filter(|spectrum| !spectrum.grid.is_plane()) else { return };
    let component = |slope: Slope| if second { slope.v } else { slope.u };
    let bars: Vec<_> = on_line(spectrum).into_iter().map(|(_, bar)| bar).collect();
    let most = bars.iter().map(|bar| bar.features).max().unwrap_or(0).max(1) as f32;
    let part = bars.iter().map(|bar| bar.evidence).fold(1e-6, f32::max);
    let axis = if second { spectrum.grid.v } else { spectrum.grid.u };
    let half = (0.38 * (x_of(axis.step()) - x_of(0.0))).clamp(0.8, 9.0);
    let height = rect.height() - 3.0;
    for bar in &bars {
        let x = x_of(component(bar.slope));
        let features = (half, bar.features as f32 / most, feature_colour(ui, bar));
        let evidence = ((0.4 * half).max(0.8), bar.evidence / part, crate::app::style::good(ui));
        for (half, share, colour) in std::iter::once(features).chain((bar.evidence > 0.0).then_some(evidence)) {
            let heights = rect.bottom() - share * height..=rect.bottom();
            painter.rect_filled(Rect::from_x_y_ranges(x - half..=x + half, heights), 0.0, colour);
        }
    }
    let near = |pos: egui::Pos2| bars.iter().map(move |bar| ((x_of(component(bar.slope)) - pos.x).abs(), bar));
    if let Some(bar) = response.hover_pos().and_then(|pos| nearest(near(pos), f32::INFINITY)) {
        response.on_hover_text_at_pointer(bar_text(bar));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_end_moves_by_whole_steps_and_keeps_the_other_slopes() {
        let axis = SlopeAxis { min: -1.0, max: 1.0, count: 5 };
        assert_eq!(moved(axis, true, 0.9), SlopeAxis { min: -1.0, max: 2.0, count: 7 });
        assert_eq!(moved(axis, false, -0.6), SlopeAxis { min: -1.5, max: 1.0, count: 6 });
        assert_eq!(moved(axis, true, -0.5), SlopeAxis { min: -1.0, max: 0.5, count: 4 });
        assert_eq!(moved(axis, false, 9.0), SlopeAxis { min: 0.5, max: 1.0, count: 2 }, "two slopes are left");
        assert_eq!(moved(axis, true, 0.1), axis);
    }
}
