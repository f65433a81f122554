//! What the panes show, as panels of a figure.

use crate::app::canvas::overlay::{ColourBy, ColourScale, circle_radius_image, motion_image};
use crate::app::canvas::{self, number};
use crate::app::inspector::PaneWidgets;
use crate::app::pane::PaneId;
use crate::app::panel::features::FeatureLayer;
use crate::app::panel::picture::describe;
use crate::app::project::Model;
use crate::app::project::look::RangeClass;
use crate::app::project::workspace::Workspace;
use crate::detector::{Detection, Feature, Slope};
use crate::export::{ColourBar, Drawing, FigureMark, FigureOptions, FigurePanel, LegendEntry, lay_out};
use crate::plane::Plane;
use crate::plane::display::{Display, to_rgba8};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// What a figure shows, and how.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct FigureChoice {
    /// All panes of the inspector, or the one in focus alone.
    pub all_panes: bool,
    /// The whole picture, or the part of it that can be seen.
    pub whole_picture: bool,
    /// Figure pixels for each image pixel.
    pub scale: f32,
    /// Width of strokes, figure pixels.
    pub stroke_width_px: f32,
    /// Height of letters, figure pixels.
    pub font_size_px: f32,
    /// A line above each picture.
    pub titles: bool,
    /// (a), (b), … where there are several.
    pub letters: bool,
    /// What the features' colours mean.
    pub legend: bool,
    /// What the pictures' colours mean.
    pub colour_bar: bool,
    /// A bar of known length.
    pub scale_bar: bool,
}

impl Default for FigureChoice {
    fn default() -> Self {
        Self {
            all_panes: true,
            whole_picture: false,
            scale: 2.0,
            stroke_width_px: 1.5,
            font_size_px: 14.0,
            titles: true,
            letters: true,
            legend: true,
            colour_bar: true,
            scale_bar: true,
        }
    }
}

impl FigureChoice {
    fn options(&self) -> FigureOptions {
        FigureOptions {
            scale: self.scale,
            stroke_width_px: self.stroke_width_px,
            font_size_px: self.font_size_px,
            letters: self.letters,
            scale_bar: self.scale_bar,
        }
    }
}

/// The figure of what is on show.
///
/// # Errors
/// That there is no picture.
pub fn drawing_of(model: &Model, widgets: &PaneWidgets, choice: &FigureChoice) -> Result<Drawing, String> {
    let rows = if choice.all_panes && model.workspace == Workspace::Inspect {
        model.panes.arrangement().in_rows()
    } else {
        vec![vec![model.focus()]]
    };
    let panels = |row: Vec<PaneId>| row.into_iter().filter_map(|id| panel_of(model, widgets, id, choice)).collect();
    let rows: Vec<Vec<FigurePanel>> = rows.into_iter().map(panels).collect();
    if rows.iter().all(Vec::is_empty) {
        return Err("there is no picture; open a burst first".to_owned());
    }
    Ok(lay_out(&rows, &choice.options()))
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
        Some(layer) if choice.legend => legend(&layer.scale(model.colour_by), &layer.detection),
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

/// The features as the window draws them: the faint ones at the bottom, the selected one on top.
fn marks(model: &Model, layer: &FeatureLayer) -> Vec<FigureMark> {
    let scale = layer.scale(model.colour_by);
    let frames = layer.detection.frames_used.len();
    let selected = |i: usize| layer.selected == Some(i);
    let mark = |i: usize| {
        let (placed, own) = (&layer.placed[i], &layer.detection.features[i]);
        let faint = layer.is_faint(i);
        // The way over the whole burst stays where it is in every frame.
        let (first, last) = motion_image(own, frames);
        FigureMark {
            centre: [placed.u, placed.v],
            radius: circle_radius_image(placed),
            orientation: (model.look.orientations && !faint).then_some(placed.orientation),
            motion: (model.look.motion_vectors && !faint).then(|| [first.into(), last.into()]),
            color: rgb(scale.colour(placed)),
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

/// Entries that show the colours of the slopes of the grid that have features (at most a dozen), or of five steps
/// through the range.
fn legend(scale: &ColourScale, detection: &Detection) -> Vec<LegendEntry> {
    const MOST: usize = 12;
    let Some(sample) = detection.features.first().copied() else { return Vec::new() };
    let entry = |feature: Feature, label: String| LegendEntry { color: rgb(scale.colour(&feature)), label };
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
    (0..5)
        .map(|step| {
            let x = scale.min + (scale.max - scale.min) * step as f32 / 4.0;
            let feature = match scale.by {
                ColourBy::SlopeU => Feature { slope: Slope::new(x, 0.0), ..sample },
                ColourBy::SlopeV => Feature { slope: Slope::new(0.0, x), ..sample },
                ColourBy::Scale => Feature { sigma: x, ..sample },
                ColourBy::Response | ColourBy::SlopeDirection => Feature { response: x, ..sample },
            };
            entry(feature, format!("{} {}", canvas::number(x, 3), scale.by.unit()))
        })
        .collect()
}

fn rgb(colour: egui::Color32) -> [u8; 3] {
    [colour.r(), colour.g(), colour.b()]
}
