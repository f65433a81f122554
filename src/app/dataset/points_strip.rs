//! Numbers of 3D points that the images of a reconstruction see, as bars in the order of the images.

use super::plane_view::{estimate_colour, pair_text, points_of};
use crate::app::project::trajectories::Trajectories;
use egui::{Align2, FontId, Rect, Sense, Ui, pos2, vec2};

/// Bar of one image.
#[derive(Debug, Clone, PartialEq)]
struct Bar {
    label: String,
    /// Number of 3D points; `None` for an image that was not registered.
    points: Option<usize>,
    pair: Option<usize>,
}

/// Makes a bar for each image: those of the truth in their order where there is a comparison, otherwise those of the
/// estimate.
fn bars(trajectories: &Trajectories) -> Vec<Bar> {
    let compared = &trajectories.compared;
    let Some((_, estimate)) = &compared.estimate else { return Vec::new() };
    if estimate.model.is_none() {
        return Vec::new();
    }
    match (&compared.truth, trajectories.report()) {
        (Some((_, truth)), Some(report)) => {
            let mut bars: Vec<Bar> =
                truth.poses.iter().map(|p| Bar { label: p.label.clone(), points: None, pair: None }).collect();
            for (index, pair) in report.pairs.iter().enumerate() {
                bars[pair.truth] = Bar {
                    label: pair.label.clone(),
                    points: points_of(trajectories, pair.estimate),
                    pair: Some(index),
                };
            }
            bars
        }
        _ => {
            let bar = |(index, pose): (usize, &crate::evaluate::poses::Pose)| Bar {
                label: pose.label.clone(),
                points: points_of(trajectories, index),
                pair: None,
            };
            estimate.poses.iter().enumerate().map(bar).collect()
        }
    }
}

/// Draws the strip in the available space; without points it says what is missing.
pub fn points_strip_ui(ui: &mut Ui, trajectories: &mut Trajectories) {
    let bars = bars(trajectories);
    let (rect, response) = ui.allocate_exact_size(ui.available_size().max(vec2(40.0, 40.0)), Sense::click());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, "3D points of each image"));
    let (painter, visuals) = (ui.painter_at(rect), ui.visuals());
    let font = FontId::proportional(11.0);
    if bars.is_empty() {
        let text = "A sparse model tells how many 3D points each image sees; a trajectory file does not";
        painter.text(rect.center(), Align2::CENTER_CENTER, text, font, visuals.weak_text_color());
        return;
    }
    let most = bars.iter().filter_map(|b| b.points).max().unwrap_or(0).max(1);
    let plot = Rect::from_min_max(rect.min + vec2(44.0, 6.0), rect.max - vec2(6.0, 4.0));
    let step = plot.width() / bars.len() as f32;
    let gap = if step > 6.0 { 1.0 } else { 0.0 };
    let bar_at = |k: usize| {
        Rect::from_x_y_ranges(
            plot.left() + k as f32 * step + gap..=plot.left() + (k + 1) as f32 * step - gap,
            plot.y_range(),
        )
    };
    for (text, y, align) in
        [(most.to_string(), plot.top(), Align2::RIGHT_TOP), ("0".to_owned(), plot.bottom(), Align2::RIGHT_BOTTOM)]
    {
        painter.text(pos2(plot.left() - 6.0, y), align, text, font.clone(), visuals.weak_text_color());
    }
    let pointed = response.hover_pos().filter(|p| plot.contains(*p)).map(|p| ((p.x - plot.left()) / step) as usize);
    if response.hovered() {
        trajectories.hovered = pointed.and_then(|k| bars.get(k)?.pair);
    }
    if response.clicked() {
        trajectories.selected = trajectories.hovered;
    }
    for (k, bar) in bars.iter().enumerate() {
        let column = bar_at(k);
        let marked = bar.pair.is_some() && (bar.pair == trajectories.hovered || bar.pair == trajectories.selected);
        if marked || pointed == Some(k) {
            painter.rect_filled(column.expand(gap), 0.0, visuals.widgets.hovered.weak_bg_fill);
        }
        match bar.points {
            Some(points) => {
                let top = plot.bottom() - plot.height() * points as f32 / most as f32;
                let colour = if marked { visuals.strong_text_color() } else { estimate_colour(ui) };
                painter.rect_filled(column.with_min_y(top), 0.0, colour);
            }
            None => {
                // A low bar of another colour: an image that was not registered differs from one without points.
                painter.rect_filled(column.with_min_y(plot.bottom() - 3.0), 0.0, visuals.error_fg_color);
            }
        }
    }
    if let Some(bar) = pointed.and_then(|k| bars.get(k)) {
        let text = match (trajectories.report(), bar.pair, bar.points) {
            (Some(report), Some(pair), _) => pair_text(trajectories, &report.pairs[pair]),
            (_, _, Some(points)) => format!("{}\n{points} 3D points", bar.label),
            _ => format!("{}\nnot registered", bar.label),
        };
        response.on_hover_text_at_pointer(text);
    }
}
