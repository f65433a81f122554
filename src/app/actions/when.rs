//! When actions are possible, and whether they are on: what rows of the table have in common.

use crate::app::document::panes::Tool;
use crate::app::document::{Document, Reference, Side};
use crate::app::inspector::PaneWidgets;
use crate::app::pane::{MAX_PANES, Over};
use crate::app::results::{Read, Slot};
use crate::detector::{Method, SlopeGrid};
use crate::requests::BurstSource;

pub fn has_burst(model: Read<'_>) -> bool {
    model.results.slots.a.burst.is_some()
}

pub fn has_both(model: Read<'_>) -> bool {
    model.results.slots.both().into_iter().all(|slot| slot.burst.is_some())
}

pub fn in_inspect(model: Read<'_>) -> bool {
    model.document.workspace.inspects()
}

pub fn in_pair(model: Read<'_>) -> bool {
    model.document.workspace.shows_pair()
}

pub fn inspects_burst(model: Read<'_>) -> bool {
    has_burst(model) && in_inspect(model)
}

pub fn active(model: Read<'_>) -> &Slot {
    &model.results.slots[model.active_side()]
}

pub fn many_panes(model: Read<'_>) -> bool {
    model.document.workspace.needs_burst() && model.document.panes.are_many()
}

pub fn has_room(model: Read<'_>) -> bool {
    let Document { workspace, panes, .. } = model.document;
    has_burst(model) && workspace.needs_burst() && panes.shown().len() < MAX_PANES
}

pub fn flips(model: Read<'_>) -> bool {
    matches!(model.document.panes.over(model.document.focus()), Some(Over::Flip { .. }))
}

pub fn has_picture(model: Read<'_>) -> bool {
    model.picture().is_some()
}

/// Whether the table has features, or matches of two bursts, to step through.
pub fn lists_any(model: Read<'_>) -> bool {
    !model.listed().is_empty()
}

pub fn has_place_to_go(model: Read<'_>) -> bool {
    match in_pair(model) {
        true => model.document.selected_match.is_some(),
        false => model.selected_feature().is_some(),
    }
}

pub fn has_selection(model: Read<'_>) -> bool {
    if in_pair(model) {
        return model.asked_feature().is_some();
    }
    let holds_tool = in_inspect(model) && model.document.measure.tool != Tool::Pan;
    holds_tool || has_place_to_go(model) || model.document.comparisons.a.selected.is_some()
}

pub fn refers_to(model: Read<'_>, with: Reference) -> bool {
    model.has_reference(model.active_side(), with)
}

pub fn shows_truth(model: Read<'_>) -> bool {
    model.document.comparisons[model.active_side()].with == Some(Reference::Truth)
}

pub fn can_detect(model: Read<'_>) -> bool {
    let is_free = model.results.slots.both().into_iter().all(|slot| !slot.detecting.is_pending());
    has_burst(model) && model.results.slots.a.param_error.is_none() && is_free
}

pub fn can_match(model: Read<'_>) -> bool {
    in_pair(model) && !model.results.pair.matching.is_pending() && model.wanted_matches().is_some()
}

pub fn can_probe(model: Read<'_>) -> bool {
    let active = active(model);
    has_burst(model) && model.document.workspace.probes() && (active.found.is_some() || active.param_error.is_none())
}

pub fn has_dataset(model: Read<'_>) -> bool {
    model.results.datasets.open.is_some()
}

pub fn is_in_dataset(model: Read<'_>) -> bool {
    model.place_of(Side::A).is_some()
}

pub fn has_chosen(model: Read<'_>) -> bool {
    model.document.dataset.as_ref().is_some_and(|set| set.selected().is_some())
}

pub fn can_match_pairs(model: Read<'_>) -> bool {
    model.results.datasets.can_match(model.document.matching.validate().is_ok())
}

pub fn can_export_database(model: Read<'_>) -> bool {
    let datasets = &model.results.datasets;
    let several = datasets.open.as_ref().is_some_and(|dataset| dataset.bursts.len() > 1);
    cfg!(feature = "colmap") && several && datasets.work.is_none()
}

pub fn can_be_cut(model: Read<'_>) -> bool {
    model.burst_of(Side::A).is_some_and(|open| matches!(open.source, BurstSource::Paths(_))) && model.frame_count() > 1
}

pub fn draws_features(model: Read<'_>) -> bool {
    (model.document.workspace.record().draws_features)(model.document)
}

fn searched_grid(model: Read<'_>) -> Option<SlopeGrid> {
    let is_known = model.document.params.method == Method::Buff && model.knows_slopes(Side::A);
    is_known.then(|| model.grid_of(Side::A))
}

pub fn searches_line(model: Read<'_>) -> bool {
    searched_grid(model).is_some_and(|grid| !grid.is_plane() && grid.len() > 1)
}

pub fn searches_plane(model: Read<'_>) -> bool {
    searched_grid(model).is_some_and(|grid| grid.is_plane())
}

/// The place under the pointer, or else the middle of what is seen of the picture in focus; with its side.
pub fn place_to_probe(model: Read<'_>, widgets: &PaneWidgets) -> Option<(Side, [f32; 2])> {
    let middle = || {
        let visible = widgets.get(model.document.focus())?.picture.visible_image?.center();
        let (width, height) = model.focused_size();
        let within = |x: f32, n: usize| x.clamp(0.0, n.saturating_sub(1) as f32);
        Some((model.document.focused().side, [within(visible.x, width), within(visible.y, height)]))
    };
    model.results.probed.pointer.or_else(middle)
}
