//! Collects the content of the panes as panels of a figure.

use crate::app::canvas::overlay::{ColourBy, ColourScale, circle_radius_image, motion_image};
use crate::app::canvas::{self, number};
use crate::app::figure::links::links_of;
use crate::app::inspector::PaneWidgets;
use crate::app::pane::PaneId;
use crate::app::panel::features::FeatureLayer;
use crate::app::panel::picture::describe;
use crate::app::project::Model;
use crate::app::project::figure::FigureChoice;
use crate::app::project::look::RangeClass;
use crate::detector::{Detection, Feature};
use crate::export::{ColourBar, Drawing, FigureMark, FigurePanel, LegendEntry, draw_links, lay_out};
use crate::plane::Plane;
use crate::plane::display::{Display, to_rgba8};
use std::sync::Arc;

/// Makes the figure of the shown panes.
///
/// # Errors
/// When there is no picture.
pub fn drawing_of(model: &Model, widgets: &PaneWidgets, choice: &FigureChoice) -> Result<Drawing, String> {
    let rows = if choice.all_panes && model.workspace.needs_burst() {
        model.panes.arrangement().in_rows()
    } else {
        vec![vec![model.focus()]]
    };
    let mut panes = Vec::new();
    let mut panels = |row: Vec<PaneId>| {
        let panel = |id: PaneId| {
            let panel = panel_of(model, widgets, id, choice)?;
            panes.push(id);
            Some(panel)
        };
        row.into_iter().filter_map(panel).collect()
    };
    let rows: Vec<Vec<FigurePanel>> = rows.into_iter().map(&mut panels).collect();
    if rows.iter().all(Vec::is_empty) {
        return Err("there is no picture; open a burst first".to_owned());
    }
    let mut drawing = lay_out(&rows, &choice.options());
    draw_links(&mut drawing, &rows, &links_of(model, widgets, &panes), choice.stroke_width_px);
    Ok(drawing)
}

fn panel_of(model: &Model, widgets: &PaneWidgets, id: PaneId, choice: &FigureChoice) -> Option<FigurePanel> {
    let picture = model.panes.get(id)?.picture.as_ref()?;
    let shown = crate::app::panel::picture::canvas_picture(picture);
    let visible = widgets.get(id).and_then(|widget| widget.picture.visible_image).filter(|_| !choice.whole_picture);
    let region = shown.region(visible.unwrap_or_else(|| shown.rect_image()));
    if region.is_empty() {
        return None;
    }
    let display = model.display_of(id);
    let part =
        Plane::from_fn(region.u.len(), region.v.len(), |u, v| shown.plane.at(region.u.start + u, region.v.start + v));
    let rgba = match &picture.motion {
        Some(motion) => {
            let (u, v) = (region.u.start as u32, region.v.start as u32);
            let (width, height) = (region.u.len() as u32, region.v.len() as u32);
            image::imageops::crop_imm(&motion.colours, u, v, width, height).to_image()
        }
        None => to_rgba8(&part, &display),
    };
    let step = shown.image_from_picture_scale;
    let layer = FeatureLayer::of(model, id);
    let legend = match &layer {
        Some(layer) if choice.legend => legend(&layer.scale(model), &layer.detection),
        _ => Vec::new(),
    };
    Some(FigurePanel {
        size: part.size(),
        rgba: Arc::new(rgba.into_raw()),
        origin_image: [(region.u.start as f32 - 0.5) * step, (region.v.start as f32 - 0.5) * step],
        image_px_per_px: step,
        marks: layer.map(|layer| marks(model, &layer)).unwrap_or_default(),
        title: choice.titles.then(|| describe(picture)),
        legend,
        bar: (choice.colour_bar && picture.motion.is_none()).then(|| colour_bar(&display, model.range_class(id))),
    })
}

/// Marks of the features as the window draws them: faint ones below, the selected one on top.
fn marks(model: &Model, layer: &FeatureLayer) -> Vec<FigureMark> {
    let scale = layer.scale(model);
    let frames = layer.detection.frames_used.len();
    let selected = |i: usize| layer.selected == Some(i);
    let mark = |i: usize| {
        let (placed, own) = (&layer.placed[i], &layer.detection.features[i]);
        let faint = layer.is_faint(i);
        // The motion over the whole burst is the same in every frame.
        let (first, last) = motion_image(own, frames);
        FigureMark {
            centre: [placed.u, placed.v],
            radius: circle_radius_image(placed),
            orientation: (layer.orientations && !faint).then_some(placed.orientation),
            motion: (layer.motions && !faint).then(|| [first.into(), last.into()]),
            color: rgb(scale.colour(i, placed)),
            opacity: if faint || layer.stale { 0.35 } else { 0.95 },
            weight: if selected(i) { 2.0 } else { 1.0 },
            dashed: placed.at_slope_limit,
        }
    };
    let mut order: Vec<usize> = (0..layer.placed.len()).filter(|&i| layer.shown[i]).collect();
    order.sort_by_key(|&i| (selected(i), !layer.is_faint(i)));
    order.into_iter().map(mark).collect()
}

fn colour_bar(display: &Display, class: RangeClass) -> ColourBar {
    const STEPS: usize = 64;
    let colours = display.colours();
    let value = |i: usize| display.min + (display.max - display.min) * (i as f32 + 0.5) / STEPS as f32;
    ColourBar {
        colors: (0..STEPS).map(|i| colours.colour(value(i))).collect(),
        low: number(display.min, 3),
        high: match class {
            RangeClass::Share => format!("{} of the frames", number(display.max, 3)),
            _ => format!("{} of full scale", number(display.max, 3)),
        },
    }
}

/// Legend entries: the colours of the slopes of the grid that have features (at most 12), or of five steps through the
/// range.
fn legend(scale: &ColourScale, detection: &Detection) -> Vec<LegendEntry> {
    const MOST: usize = 12;
    let Some(sample) = detection.features.first().copied() else { return Vec::new() };
    let entry = |feature: Feature, label: String| LegendEntry { color: rgb(scale.colour(0, &feature)), label };
    if scale.by == ColourBy::SlopeDirection {
        let grid = detection.slopes;
        let mut used: Vec<usize> = detection.features.iter().map(|f| f.slope_index).collect();
        used.sort_unstable();
        used.dedup();
        let every = used.len().div_ceil(MOST).max(1);
        return used
            .into_iter()
            .step_by(every)
            .map(|i| {
                let slope = grid.slope(i);
                entry(Feature { slope, ..sample }, format!("({:.2}, {:.2}) px/frame", slope.u, slope.v))
            })
            .collect();
    }
    if scale.by == ColourBy::Limit {
        return [(false, "inside the searched slopes"), (true, "at their limit")]
            .map(|(at_slope_limit, label)| entry(Feature { at_slope_limit, ..sample }, label.to_owned()))
            .to_vec();
    }
    let step = |step: usize| {
        let x = scale.min + (scale.max - scale.min) * step as f32 / 4.0;
        let label = format!("{} {}", canvas::number(x, 3), scale.by.unit());
        LegendEntry { color: rgb(scale.along(x)), label: label.trim_end().to_owned() }
    };
    let grey = LegendEntry { color: rgb(scale.unknown()), label: "not known".to_owned() };
    (0..5).map(step).chain(scale.has_unknown().then_some(grey)).collect()
}

fn rgb(colour: egui::Color32) -> [u8; 3] {
    [colour.r(), colour.g(), colour.b()]
}
