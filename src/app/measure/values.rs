//! Values along the line and in the rectangle, in every pane linked by place with the one they were drawn on.

use super::{MeasuredLine, MeasuredRegion};
use crate::app::canvas::Picture;
use crate::app::inspector::{PaneWidgets, compact_description, same_place};
use crate::app::pane::{Link, PaneId};
use crate::app::project::Model;
use crate::plane::sample::{ProfileSample, profile};
use crate::plane::statistics::Region;
use egui::{Pos2, Rect};

/// The values of one pane along the line.
#[derive(Debug, Clone, PartialEq)]
pub struct PaneProfile {
    /// Pane.
    pub id: PaneId,
    /// Number of the pane, from 1.
    pub number: usize,
    /// Description of the pane's picture.
    pub label: String,
    /// Samples along the line; places in image pixels.
    pub samples: Vec<ProfileSample>,
}

/// The pixels of one pane in the rectangle.
#[derive(Debug, Clone)]
pub struct PaneRegion {
    /// Pane.
    pub id: PaneId,
    /// Number of the pane, from 1.
    pub number: usize,
    /// Description of the pane's picture.
    pub label: String,
    /// Picture of the pane.
    pub picture: Picture,
    /// The pixels of that picture.
    pub region: Region,
}

/// The pane that was drawn on and those linked with it by place, in reading order; empty when that pane is no longer
/// shown.
pub fn measured_panes(model: &Model, drawn_on: PaneId) -> Vec<PaneId> {
    let shown = model.panes.shown();
    if !shown.contains(&drawn_on) {
        return Vec::new();
    }
    let is_linked = |id: &PaneId| model.panes.get(*id).is_some_and(|pane| pane.links.has(Link::Place));
    let alone = !is_linked(&drawn_on);
    shown.into_iter().filter(|id| *id == drawn_on || (!alone && is_linked(id))).collect()
}

/// Maps a place of the pane that was drawn on to another pane.
pub(super) fn mapped(model: &Model, drawn_on: PaneId, to: PaneId, pos_image: Pos2) -> Option<Pos2> {
    if drawn_on == to { Some(pos_image) } else { same_place(model, drawn_on, to, pos_image) }
}

/// Values along `line`, in every measured pane.
pub fn profiles_of(model: &Model, widgets: &PaneWidgets, line: &MeasuredLine) -> Vec<PaneProfile> {
    let of = |id: PaneId| {
        let picture = widgets.get(id)?.picture.shown()?;
        let ends = [line.from_image, line.to_image].map(|pos| mapped(model, line.pane, id, pos));
        let (from, to) = (ends[0]?, ends[1]?);
        let samples = profile(&picture.plane, from.into(), to.into(), picture.image_from_picture_scale);
        Some(PaneProfile { id, number: model.panes.number(id)?, label: compact_description(model, id), samples })
    };
    measured_panes(model, line.pane).into_iter().filter_map(of).collect()
}

/// The pixels in `region` of pane `id`.
pub fn region_in(model: &Model, widgets: &PaneWidgets, region: &MeasuredRegion, id: PaneId) -> Option<PaneRegion> {
    let picture = widgets.get(id)?.picture.shown()?.clone();
    let rect = region.rect_image;
    let corners = [rect.min, rect.max].map(|pos| mapped(model, region.pane, id, pos));
    let rect = Rect::from_min_max(corners[0]?, corners[1]?);
    let region = picture.region(rect);
    let (number, label) = (model.panes.number(id)?, compact_description(model, id));
    Some(PaneRegion { id, number, label, picture, region })
}
