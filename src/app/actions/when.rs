//! When actions are possible, and whether they are on: what rows of the table have in common.

use crate::app::document::comparison::Reference;
use crate::app::document::look::FeaturesShown;
use crate::app::document::panes::Tool;
use crate::app::document::side::Side;
use crate::app::inspector::PaneWidgets;
use crate::app::pane::{MAX_PANES, Over};
use crate::app::results::Model;
use crate::app::results::slot::Slot;
use crate::detector::Method;
use crate::requests::BurstSource;
use crate::teach::Workspace;

pub fn has_burst(model: &Model) -> bool {
    model.results.slots.a.burst.is_some()
}

pub fn has_both(model: &Model) -> bool {
    model.results.slots.both().into_iter().all(|slot| slot.burst.is_some())
}

pub fn in_inspect(model: &Model) -> bool {
    model.document.workspace == Workspace::Inspect
}

pub fn in_pair(model: &Model) -> bool {
    model.document.workspace == Workspace::Pair
}

pub fn in_methods(model: &Model) -> bool {
    model.document.workspace == Workspace::Methods
}

pub fn inspects_burst(model: &Model) -> bool {
    has_burst(model) && in_inspect(model)
}

/// The slot of the pane in focus.
pub fn active(model: &Model) -> &Slot {
    &model.results.slots[model.active_side()]
}

pub fn many_panes(model: &Model) -> bool {
    model.document.workspace.needs_burst() && model.document.panes.are_many()
}

pub fn has_room(model: &Model) -> bool {
    let has_panes = model.document.workspace.needs_burst();
    has_burst(model) && has_panes && model.document.panes.shown().len() < MAX_PANES
}

pub fn flips(model: &Model) -> bool {
    matches!(model.document.panes.over(model.document.focus()), Some(Over::Flip { .. }))
}

pub fn has_picture(model: &Model) -> bool {
    model.picture().is_some()
}

/// Whether the table has features, or matches of two bursts, to step through.
pub fn lists_any(model: &Model) -> bool {
    !if in_pair(model) { &model.results.pair.listed } else { &model.results.listed }.is_empty()
}

pub fn has_place_to_go(model: &Model) -> bool {
    match in_pair(model) {
        true => model.document.selected_match.is_some(),
        false => model.read().selected_feature().is_some(),
    }
}

/// Whether there is a selection to clear, or a tool to put away.
pub fn has_selection(model: &Model) -> bool {
    if in_pair(model) {
        return model.asked_feature().is_some();
    }
    let holds_tool = in_inspect(model) && model.document.measure.tool != Tool::Pan;
    holds_tool || has_place_to_go(model) || model.document.comparisons.a.selected.is_some()
}

pub fn refers_to(model: &Model, with: Reference) -> bool {
    model.has_reference(model.active_side(), with)
}

pub fn shows_truth(model: &Model) -> bool {
    model.document.comparisons[model.active_side()].with == Some(Reference::Truth)
}

pub fn can_detect(model: &Model) -> bool {
    let is_free = model.results.slots.both().into_iter().all(|slot| !slot.detecting.is_pending());
    has_burst(model) && model.results.slots.a.param_error.is_none() && is_free
}

pub fn can_match(model: &Model) -> bool {
    in_pair(model) && !model.results.pair.matching.is_pending() && model.wanted_matches().is_some()
}

pub fn has_probe_panel(model: &Model) -> bool {
    in_inspect(model) || in_pair(model)
}

pub fn can_probe(model: &Model) -> bool {
    let active = active(model);
    has_burst(model) && has_probe_panel(model) && (active.found.is_some() || active.param_error.is_none())
}

pub fn has_dataset(model: &Model) -> bool {
    model.results.datasets.open.is_some()
}

pub fn is_in_dataset(model: &Model) -> bool {
    let open = model.results.datasets.open.as_ref();
    open.is_some_and(|dataset| dataset.place_of(model.results.slots.a.burst.as_ref()).is_some())
}

pub fn has_chosen(model: &Model) -> bool {
    model.document.dataset.as_ref().is_some_and(|set| set.selected().is_some())
}

pub fn can_match_pairs(model: &Model) -> bool {
    model.results.datasets.can_match(model.document.matching.validate().is_ok())
}

pub fn can_export_database(model: &Model) -> bool {
    let datasets = &model.results.datasets;
    let several = datasets.open.as_ref().is_some_and(|dataset| dataset.bursts.len() > 1);
    cfg!(feature = "colmap") && several && datasets.work.is_none()
}

pub fn can_be_cut(model: &Model) -> bool {
    let is_in_files = |source: &BurstSource| matches!(source, BurstSource::Paths(_));
    model.results.slots.a.burst.as_ref().is_some_and(|open| is_in_files(&open.source)) && model.frame_count() > 1
}

pub fn draws_features(model: &Model) -> bool {
    match model.document.workspace {
        Workspace::Methods => model.document.methods.features,
        Workspace::Pair => model.document.match_look.features,
        _ => model.document.look.overlay != FeaturesShown::None,
    }
}

fn searches_given(model: &Model) -> bool {
    !model.document.slopes.is_auto() && model.document.params.method == Method::Buff
}

pub fn searches_line(model: &Model) -> bool {
    let slopes = &model.document.params.slopes;
    searches_given(model) && !slopes.is_plane() && slopes.len() > 1
}

pub fn searches_plane(model: &Model) -> bool {
    searches_given(model) && model.document.params.slopes.is_plane()
}

/// The place under the pointer, or else the middle of what is seen of the picture in focus; with its side.
pub fn place_to_probe(model: &Model, widgets: &PaneWidgets) -> Option<(Side, [f32; 2])> {
    let middle = || {
        let visible = widgets.get(model.document.focus())?.picture.visible_image?.center();
        let (width, height) = model.focused_size();
        let within = |x: f32, n: usize| x.clamp(0.0, n.saturating_sub(1) as f32);
        Some((model.document.focused().side, [within(visible.x, width), within(visible.y, height)]))
    };
    model.results.probed.pointer.or_else(middle)
}
