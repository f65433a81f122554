//! Features and evidence at each slope, as bars along a line of slopes and as cells of a plane of slopes.

use crate::app::panel::widgets::{dot_ui, named, small_text};
use crate::app::style;
use crate::app::{canvas::number, canvas::overlay::rgb};
use crate::detector::Slope;
use crate::inspect::slopes::{SlopeBar, Spectrum};
use crate::inspect::words::counted;
use egui::{Align2, Color32, Rect, RichText, Sense, Stroke, StrokeKind, Ui, pos2, vec2};

pub(super) struct Marks {
    pub here: Slope,
    /// Slopes of the nearest and the farthest things by the set-up, while it is in use.
    pub expected: Option<[Slope; 2]>,
}

/// Colour of the features at a slope: another one where most of them are at the limit.
pub(in crate::app::panel) fn feature_colour(ui: &Ui, bar: &SlopeBar) -> Color32 {
    if 2 * bar.at_limit > bar.features { style::warning(ui) } else { style::ACCENT }
}

/// Bars on the searched line, each with its place along the line.
pub(in crate::app::panel) fn on_line(spectrum: &Spectrum) -> Vec<(i64, &SlopeBar)> {
    let second = spectrum.grid.u.count == 1 && spectrum.grid.v.count > 1;
    let place = |bar: &SlopeBar| if second { (bar.at[1], bar.at[0]) } else { (bar.at[0], bar.at[1]) };
    let bars = spectrum.bars.iter().map(|bar| (place(bar), bar));
    bars.filter(|((_, across), _)| *across == 0).map(|((along, _), bar)| (along, bar)).collect()
}

pub(in crate::app::panel) fn bar_text(bar: &SlopeBar) -> String {
    let where_to = if bar.is_searched { "" } else { ", beyond what was searched" };
    let at_limit = if bar.at_limit > 0 { format!(", {} at the limit", bar.at_limit) } else { String::new() };
    let (u, v, features) = (number(bar.slope.u, 3), number(bar.slope.v, 3), counted(bar.features, "feature"));
    let (evidence, coverage) = (number(100.0 * bar.evidence, 2), number(100.0 * bar.coverage, 3));
    format!("Slope ({u}, {v}) px/frame{where_to}\n{features}{at_limit}\n")
        + &format!("{evidence} % of the evidence\n{coverage} % of the picture seen by all frames")
}

/// Draws bars: features above the line, evidence below it.
pub(super) fn line_ui(ui: &mut Ui, spectrum: &Spectrum, marks: &Marks, height: f32) {
    let bars = on_line(spectrum);
    key_ui(ui, marks);
    let size = vec2(ui.available_width(), (height - 32.0).min(ui.available_height()).clamp(60.0, 300.0));
    let (rect, response) = ui.allocate_exact_size(size, Sense::hover());
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 3.0, ui.visuals().extreme_bg_color);
    let inner = Rect::from_min_max(rect.min + vec2(8.0, 6.0), rect.max - vec2(8.0, 18.0));
    let (first, last) = bars.iter().fold((i64::MAX, i64::MIN), |(a, b), (at, _)| (a.min(*at), b.max(*at)));
    if first > last {
        return;
    }
    let cell = inner.width() / (last - first + 1) as f32;
    let middle = |at: f32| inner.left() + (at - first as f32 + 0.5) * cell;
    let axis = inner.top() + 0.62 * inner.height();
    let most = bars.iter().map(|(_, bar)| bar.features).max().unwrap_or(0).max(1) as f32;
    let part = bars.iter().map(|(_, bar)| bar.evidence).fold(1e-6, f32::max);
    let searched = bars.iter().filter(|(_, bar)| bar.is_searched);
    let (low, high) = searched.fold((i64::MAX, i64::MIN), |(a, b), (at, _)| (a.min(*at), b.max(*at)));
    let inside = Rect::from_x_y_ranges(middle(low as f32 - 0.5)..=middle(high as f32 + 0.5), inner.y_range());
    painter.rect_filled(inside, 0.0, ui.visuals().faint_bg_color);
    for (at, bar) in &bars {
        let x = middle(*at as f32);
        let half = (0.4 * cell).max(0.5);
        for (count, colour) in [(bar.features, style::ACCENT), (bar.at_limit, style::warning(ui))] {
            let height = (axis - inner.top()) * count as f32 / most;
            painter.rect_filled(Rect::from_x_y_ranges(x - half..=x + half, axis - height..=axis), 0.0, colour);
        }
        let down = (inner.bottom() - axis) * bar.evidence / part;
        let evidence = Rect::from_x_y_ranges(x - half..=x + half, axis + 1.0..=axis + 1.0 + down);
        if bar.is_searched {
            painter.rect_filled(evidence, 0.0, style::good(ui));
        } else if bar.evidence > 0.0 {
            painter.rect_stroke(evidence, 0.0, Stroke::new(1.5, style::good(ui)), StrokeKind::Inside);
        }
    }
    painter.hline(inner.x_range(), axis, Stroke::new(1.0, ui.visuals().weak_text_color()));
    let every = bars.len().div_ceil(8).max(1) as i64;
    for (at, bar) in bars.iter().filter(|(at, _)| at.rem_euclid(every) == 0) {
        let text = number(if bar.slope.v.abs() > bar.slope.u.abs() { bar.slope.v } else { bar.slope.u }, 3);
        let place = pos2(middle(*at as f32), rect.bottom() - 2.0);
        small_text(ui, &painter, place, Align2::CENTER_BOTTOM, &text);
    }
    let is_second = spectrum.grid.u.count == 1 && spectrum.grid.v.count > 1;
    let place = |slope: Slope| {
        let (i, j) = spectrum.grid.position(slope);
        middle(if is_second { j } else { i })
    };
    let x = place(marks.here);
    if inner.x_range().contains(x) {
        painter.vline(x, inner.y_range(), Stroke::new(1.5, ui.visuals().strong_text_color()));
    }
    if let Some([near, far]) = marks.expected.map(|ends| ends.map(place)) {
        // A band along the top, cut where the chart ends.
        let range = inner.x_range();
        let (low, high) = (near.min(far).max(range.min), near.max(far).min(range.max));
        if low <= high {
            let band = Rect::from_x_y_ranges(low - 1.0..=high + 1.0, inner.top() - 4.0..=inner.top() - 1.0);
            painter.rect_filled(band, 1.0, ui.visuals().hyperlink_color);
        }
    }
    named(&response, egui::Role::Image, "Features and evidence by slope");
    let pointed = response.hover_pos().map(|pos| first + ((pos.x - inner.left()) / cell).floor() as i64);
    let bar = pointed.and_then(|at| bars.iter().find(|(place, _)| *place == at));
    response.on_hover_text_at_pointer(bar.map_or_else(|| "No slopes".to_owned(), |(_, bar)| bar_text(bar)));
}

/// Draws the key of the colours, on a second line where there is no room beside: it must not push the advice away.
fn key_ui(ui: &mut Ui, marks: &Marks) {
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        let keys = [
            (style::ACCENT, "features", "Features whose slope is nearest to each"),
            (style::warning(ui), "at the limit", "Features whose response still rises beyond the searched slopes"),
            (style::good(ui), "evidence", "What the frames have in common at each slope, before any threshold"),
        ];
        let tip = "Slopes of things between the nearest and the farthest, by the set-up";
        let set_up = (ui.visuals().hyperlink_color, "set-up", tip);
        for (colour, text, tip) in keys.into_iter().chain(marks.expected.map(|_| set_up)) {
            dot_ui(ui, colour);
            ui.label(RichText::new(text).small()).on_hover_text(tip);
            ui.add_space(6.0);
        }
        ui.label(RichText::new("outlined: beyond what was searched").small().weak());
    });
}

/// Draws cells: features on the left, evidence on the right; a frame around the searched slopes.
pub(super) fn plane_ui(ui: &mut Ui, spectrum: &Spectrum, marks: &Marks, height: f32) {
    let range = |axis: usize| {
        spectrum.bars.iter().map(|bar| bar.at[axis]).fold((i64::MAX, i64::MIN), |(a, b), x| (a.min(x), b.max(x)))
    };
    let ((i0, i1), (j0, j1)) = (range(0), range(1));
    let (columns, rows) = ((i1 - i0 + 1) as f32, (j1 - j0 + 1) as f32);
    let half = 0.5 * (ui.available_width() - 16.0);
    let side = ((height - 52.0).clamp(50.0, 300.0) / rows).min(half / columns).max(1.0);
    let size = vec2(side * columns, side * rows);
    let grid = spectrum.grid;
    let lut = crate::plane::display::ColourMap::Viridis.lut();
    ui.horizontal_top(|ui| {
        type Value = fn(&SlopeBar) -> f32;
        let charts: [(&str, Value); 2] = [("Features", |bar| bar.features as f32), ("Evidence", |bar| bar.evidence)];
        for (name, value) in charts {
            ui.vertical(|ui| {
                ui.set_width(half);
                ui.label(RichText::new(name).small());
                let (rect, response) = ui.allocate_exact_size(size, Sense::hover());
                let painter = ui.painter_at(rect.expand(2.0));
                painter.rect_filled(rect, 0.0, ui.visuals().extreme_bg_color);
                let most = spectrum.bars.iter().map(value).fold(1e-9, f32::max);
                let cell = |i: i64, j: i64| {
                    let corner = rect.min + side * vec2((i - i0) as f32, (j - j0) as f32);
                    Rect::from_min_size(corner, vec2(side, side))
                };
                for bar in &spectrum.bars {
                    let colour = rgb(lut[(255.0 * (value(bar) / most).sqrt()) as usize]);
                    painter.rect_filled(cell(bar.at[0], bar.at[1]), 0.0, colour);
                }
                let last = cell(grid.u.count as i64 - 1, grid.v.count as i64 - 1);
                let searched = Rect::from_min_max(cell(0, 0).min, last.max);
                painter.rect_stroke(searched, 0.0, Stroke::new(1.5, style::warning(ui)), StrokeKind::Inside);
                if let Some(ends) = marks.expected {
                    let place = |slope: Slope| {
                        let (i, j) = grid.position(slope);
                        rect.min + side * vec2(i - i0 as f32 + 0.5, j - j0 as f32 + 0.5)
                    };
                    let inside = ui.painter_at(rect);
                    inside.line_segment(ends.map(place), Stroke::new(2.0, ui.visuals().hyperlink_color));
                }
                named(&response, egui::Role::Image, format!("{name} by slope"));
                let at = response.hover_pos().map(|pos| {
                    let at = (pos - rect.min) / side;
                    [i0 + at.x.floor() as i64, j0 + at.y.floor() as i64]
                });
                if let Some(bar) = at.and_then(|at| spectrum.bars.iter().find(|bar| bar.at == at)) {
                    response.on_hover_text_at_pointer(bar_text(bar));
                }
            });
        }
    });
    let line = if marks.expected.is_some() { "; line: the set-up" } else { "" };
    ui.label(RichText::new(format!("right: u, down: v; framed: the slopes searched{line}")).small().weak());
}
