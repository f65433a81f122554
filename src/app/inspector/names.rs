//! Names of panes: in their headers, on tabs, for screen readers and tests.

use crate::app::canvas;
use crate::app::pane::{Content, Pane, PaneId};
use crate::app::panel::picture::describe;
use crate::app::project::Model;
use crate::app::project::cursor::ViewKind;
use crate::app::project::pair::Side;
use crate::app::project::workspace::Workspace;
use crate::requests::{MapKind, PictureKind};

/// Describes the content of a pane in few words.
pub fn compact_description(model: &Model, id: PaneId) -> String {
    short_description(model, id, false)
}

/// Describes the content of a pane in few words; with `tiny` only by what distinguishes it from its neighbours.
pub(super) fn short_description(model: &Model, id: PaneId, tiny: bool) -> String {
    let Some(pane) = model.panes.get(id) else { return String::new() };
    let what = what(model, pane, id, tiny);
    match pane.method {
        Some(method) if tiny => format!("{}{}", side(model, pane), method.label()),
        Some(method) => format!("{}{}  ·  {what}", side(model, pane), method.label()),
        None => format!("{}{what}", side(model, pane)),
    }
}

/// Names the pane's burst, where there are two.
fn side(model: &Model, pane: &Pane) -> String {
    let both = model.burst_of(Side::B).is_some() || model.workspace == Workspace::Pair;
    if both { format!("{}  ", pane.side.name()) } else { String::new() }
}

fn what(model: &Model, pane: &Pane, id: PaneId, tiny: bool) -> String {
    let cursor = match model.burst_in(pane) {
        Some(open) => pane.cursor_within(open, &model.params_in(pane)),
        None => pane.cursor,
    };
    let slope = format!("({}, {})", canvas::number(cursor.slope.u, 3), canvas::number(cursor.slope.v, 3));
    let number = |id: PaneId| model.panes.number(id).unwrap_or(0);
    // The input of some methods is no motion stack.
    match (pane.method, model.wanted(id).map(|wanted| wanted.kind)) {
        (Some(_), Some(PictureKind::Frame(t))) => return format!("Frame {t}"),
        (Some(_), Some(PictureKind::Merge)) => return "Merged frames".to_owned(),
        _ => {}
    }
    match (pane.content, cursor.kind) {
        (Content::Merge, _) if tiny => "Merged".to_owned(),
        (Content::Merge, _) => "Merged frames".to_owned(),
        (Content::Map(MapKind::Noise), _) => format!("σ {}/{} {slope}", cursor.octave, cursor.level),
        (Content::Map(MapKind::Motion), _) => format!("Winning slope {}/{}", cursor.octave, cursor.level),
        (Content::Map(map), _) if tiny => map.about().label.to_owned(),
        (Content::Map(map), _) => format!("{} {slope}", map.about().label),
        (Content::Slice(_), _) if tiny => "Slice".to_owned(),
        (Content::Slice(axis), _) => axis.label().to_owned(),
        (Content::Difference(a, b), _) => format!("{} − {}", number(a), number(b)),
        (Content::Cursor, ViewKind::Frame) => format!("Frame {}", cursor.frame),
        (Content::Cursor, ViewKind::Stack) if tiny => slope,
        (Content::Cursor, ViewKind::Dog) if tiny => format!("{}/{} {slope}", cursor.octave, cursor.level),
        (Content::Cursor, ViewKind::Stack) => format!("Stack {slope}"),
        (Content::Cursor, ViewKind::Dog) => format!("DoG {}/{} {slope}", cursor.octave, cursor.level),
    }
}

/// Describes the pane's picture in full, with the burst's name where there are two; empty while there is no picture.
pub(super) fn long_description(model: &Model, id: PaneId) -> String {
    let Some(pane) = model.panes.get(id) else { return String::new() };
    let Some(picture) = &pane.picture else { return String::new() };
    let what = describe(picture);
    match (pane.method, model.workspace) {
        (Some(method), _) => format!("{}{}  ·  {what}", side(model, pane), method.label()),
        (None, Workspace::Pair) => {
            let burst = model.burst_in(pane).map_or("", |open| open.burst.name.as_str());
            format!("{}{burst}  ·  {what}", side(model, pane))
        }
        _ => what,
    }
}

/// Name of the pane's canvas: by its number, or by its burst or method where these stand side by side. Names are unique
/// on the screen.
pub(super) fn canvas_name(model: &Model, id: PaneId) -> String {
    let (Some(pane), Some(number)) = (model.panes.get(id), model.panes.number(id)) else { return String::new() };
    let alone = model.panes.shown_of(pane.side, pane.method).len() < 2;
    let named = match (pane.method, model.workspace) {
        (Some(method), _) => Some(format!("{}: {}", pane.side.name(), method.label())),
        (None, Workspace::Pair) => Some(format!("Picture {}", pane.side.name())),
        _ => None,
    };
    match named {
        Some(name) if alone => name,
        Some(name) => format!("{name}, pane {number}"),
        None if model.panes.are_many() => format!("Picture {number}"),
        None => "Picture".to_owned(),
    }
}
