//! Matches between the panes of a figure, as the window draws them.

use crate::app::canvas::overlay::LineKind;
use crate::app::inspector::{PaneWidgets, joined_panes};
use crate::app::pane::PaneId;
use crate::app::panel::picture::{at_time, frames_from_middle};
use crate::app::project::Model;
use crate::app::project::compare::Contender;
use crate::app::project::pair::Matches;
use crate::app::project::side::Side;
use crate::app::project::workspace::Workspace;
use crate::export::FigureLink;

/// Lines between `panes`, the figure's panels in reading order.
pub fn links_of(model: &Model, widgets: &PaneWidgets, panes: &[PaneId]) -> Vec<FigureLink> {
    match model.workspace {
        Workspace::Pair => {
            let Some(matches) = &model.pair.matches else { return Vec::new() };
            links(model, widgets, panes, None, matches, &model.pair.drawn())
        }
        Workspace::Methods => Contender::ALL
            .into_iter()
            .filter_map(|method| Some((method, model.method_matches(method)?)))
            .flat_map(|(method, matches)| {
                let rows = matches.rows().filter(|row| model.pair.look.shows(row.inlier)).map(|row| row.index);
                links(model, widgets, panes, Some(method), matches, &rows.collect::<Vec<_>>())
            })
            .collect(),
        _ => Vec::new(),
    }
}

fn links(
    model: &Model,
    widgets: &PaneWidgets,
    panes: &[PaneId],
    method: Option<Contender>,
    matches: &Matches,
    drawn: &[usize],
) -> Vec<FigureLink> {
    // Panes hidden behind a tab have no neighbours.
    let places: Vec<_> = panes
        .iter()
        .map(|id| (*id, widgets.rect_ui(*id).unwrap_or(egui::Rect::NOTHING)))
        .filter(|(_, rect)| rect.is_positive())
        .collect();
    let shift = |id: PaneId, side| {
        let picture = model.panes.get(id).and_then(|pane| pane.picture.as_ref());
        frames_from_middle(picture, matches.detection(side)).unwrap_or(0.0)
    };
    let panel = |id: PaneId| panes.iter().position(|pane| *pane == id).unwrap_or(usize::MAX);
    let mut links = Vec::new();
    for (a, b) in joined_panes(model, &places, method).pairs {
        let (a, b) = (places[a].0, places[b].0);
        let shifts = [shift(a, Side::A), shift(b, Side::B)];
        for row in drawn.iter().filter_map(|index| matches.row(*index)) {
            let kind = LineKind::of(row.inlier);
            let colour = kind.colour();
            let ends = [at_time(row.a, shifts[0]), at_time(row.b, shifts[1])];
            links.push(FigureLink {
                panels: [panel(a), panel(b)],
                ends_image: ends.map(|feature| [feature.u, feature.v]),
                color: [colour.r(), colour.g(), colour.b()],
                opacity: model.pair.look.opacity,
                weight: if method.is_none() && model.pair.selected == Some(row.index) { 2.0 } else { 0.8 },
                dashed: kind.is_dashed(),
            });
        }
    }
    links
}
