//! Widgets of panes between passes, names of panes, and the pairs of panes between which match lines are drawn.

use crate::app::canvas::{self, Readout, RectTransform};
use crate::app::document::{MethodId, Side};
use crate::app::pane::{Content, Pane, PaneId};
use crate::app::panel::display::DisplayState;
use crate::app::panel::picture::{PictureState, describe};
use crate::app::results::Read;
use crate::app::view::{View, Zoom};
use crate::requests::{PictureKind, ViewKind};
use egui::{Rect, Vec2};
use std::collections::HashMap;

#[derive(Default)]
pub struct PaneWidget {
    pub picture: PictureState,
    pub display: DisplayState,
    pub rect_ui: Option<Rect>,
    pub(super) aside: HeldPlace,
    pub(super) menu: MenuPlace,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlaceValue {
    pub id: PaneId,
    pub number: usize,
    pub readout: Readout,
}

#[derive(Default)]
pub struct PaneWidgets {
    pub(super) all: HashMap<PaneId, PaneWidget>,
    /// Values at the place under the pointer: first that of the pane under it, then those of the panes linked to it.
    pub values: Vec<PlaceValue>,
}

impl PaneWidgets {
    pub fn of(&mut self, id: PaneId) -> &mut PaneWidget {
        self.all.entry(id).or_default()
    }

    pub fn get(&self, id: PaneId) -> Option<&PaneWidget> {
        self.all.get(&id)
    }

    pub fn ui_from_image(&self, id: PaneId) -> Option<RectTransform> {
        self.get(id)?.picture.ui_from_image
    }

    pub fn rect_ui(&self, id: PaneId) -> Option<Rect> {
        self.get(id)?.rect_ui
    }

    pub fn retain(&mut self, keep: impl Fn(PaneId) -> bool) {
        self.all.retain(|id, _| keep(*id));
    }
}

#[derive(Debug, Clone, Copy, Default)]
pub struct MenuPlace {
    pub(super) feature: Option<usize>,
    pub(super) matched: Option<usize>,
    pub(super) readout: Option<Readout>,
    /// Place at mid-burst of a burst, input pixels.
    pub(super) mid_burst: Option<(Side, [f32; 2])>,
}

/// Describes the content of a pane in few words; with `tiny` only by what distinguishes it from its neighbours.
pub fn short_description(model: Read<'_>, id: PaneId, tiny: bool) -> String {
    let Some(pane) = model.pane(id) else { return String::new() };
    let (side, what) = (side(model, pane), what(model, pane, id, tiny));
    match pane.method.map(MethodId::label) {
        Some(method) if tiny => format!("{side}{method}"),
        Some(method) => format!("{side}{method}  ·  {what}"),
        None => format!("{side}{what}"),
    }
}

fn side(model: Read<'_>, pane: &Pane) -> String {
    let both = model.burst_of(Side::B).is_some() || model.document.workspace.shows_pair();
    if both { format!("{}  ", pane.side.name()) } else { String::new() }
}

fn what(model: Read<'_>, pane: &Pane, id: PaneId, tiny: bool) -> String {
    let within = |open| pane.cursor_within(open, &model.params_in(pane));
    let cursor = model.burst_in(pane).map_or(pane.cursor, within);
    let slope = format!("({}, {})", canvas::number(cursor.slope.u, 3), canvas::number(cursor.slope.v, 3));
    let number = |id: PaneId| model.document.panes.number(id).unwrap_or(0);
    // The input of some methods is no motion stack.
    match model.wanted(id).map(|wanted| wanted.kind).filter(|_| pane.method.is_some()) {
        Some(PictureKind::Frame(t)) => return format!("Frame {t}"),
        Some(PictureKind::Merge) => return "Merged frames".to_owned(),
        _ => {}
    }
    let scale = format!("{}/{}", cursor.octave, cursor.level);
    match (pane.content, pane.shown()) {
        (Content::Slice(_), _) if tiny => "Slice".to_owned(),
        (Content::Slice(axis), _) => axis.words()[0].to_owned(),
        (Content::Difference(a, b), _) => format!("{} − {}", number(a), number(b)),
        (_, Some(ViewKind::Frame)) => format!("Frame {}", cursor.frame),
        (_, Some(ViewKind::Stack)) if tiny => slope,
        (_, Some(ViewKind::Dog)) if tiny => format!("{scale} {slope}"),
        (_, Some(ViewKind::Stack)) => format!("Stack {slope}"),
        (_, Some(ViewKind::Dog)) => format!("DoG {scale} {slope}"),
        (_, Some(ViewKind::Merge)) => if tiny { "Merged" } else { "Merged frames" }.to_owned(),
        (_, Some(ViewKind::Noise)) => format!("σ {scale} {slope}"),
        (_, Some(ViewKind::Motion)) => format!("Winning slope {scale}"),
        (_, Some(kind)) if tiny || !kind.about().of_slope => kind.label().to_owned(),
        (_, kind) => format!("{} {slope}", kind.map_or("", ViewKind::label)),
    }
}

/// Describes the pane's picture in full, with the burst's name where there are two; empty while there is no picture.
pub(super) fn long_description(model: Read<'_>, id: PaneId) -> String {
    let (Some(pane), Some(picture)) = (model.pane(id), model.picture_in(id)) else { return String::new() };
    let what = describe(picture);
    match pane.method {
        Some(method) => format!("{}{}  ·  {what}", side(model, pane), method.label()),
        None if model.document.workspace.shows_pair() => {
            let burst = model.burst_in(pane).map_or("", |open| open.burst.name.as_str());
            format!("{}{burst}  ·  {what}", side(model, pane))
        }
        None => what,
    }
}

/// By its number, or by its burst or method where these stand side by side; unique on the screen.
pub(super) fn canvas_name(model: Read<'_>, id: PaneId) -> String {
    let (Some(pane), Some(number)) = (model.pane(id), model.document.panes.number(id)) else {
        return String::new();
    };
    let name = match pane.method {
        Some(method) => format!("{}: {}", pane.side.name(), method.label()),
        None if model.document.workspace.shows_pair() => format!("Picture {}", pane.side.name()),
        None if model.document.panes.are_many() => return format!("Picture {number}"),
        None => return "Picture".to_owned(),
    };
    let is_alone = model.document.panes.shown_of(pane.side, pane.method).len() < 2;
    if is_alone { name } else { format!("{name}, pane {number}") }
}

/// Side of a pane with the input of `method` (`None`: without a method); no differences, no slices.
pub fn side_of(model: Read<'_>, id: PaneId, method: Option<MethodId>) -> Option<Side> {
    model.pane(id).filter(|pane| pane.method == method && pane.shown().is_some()).map(|pane| pane.side)
}

/// Pairs of a pane of A and one of B with the input of `method` that are joined; as indices into `places`.
pub fn joined_panes(model: Read<'_>, places: &[(PaneId, Rect)], method: Option<MethodId>) -> Vec<(usize, usize)> {
    let is_on = |place: usize, side| side_of(model, places[place].0, method) == Some(side);
    let [a, b] = Side::BOTH.map(|side| (0..places.len()).filter(|i| is_on(*i, side)).collect::<Vec<_>>());
    let rects = |of: &[usize]| of.iter().map(|place| places[*place].1).collect::<Vec<Rect>>();
    let all: Vec<Rect> = places.iter().map(|(_, rect)| *rect).collect();
    joined(&rects(&a), &rects(&b), &all).into_iter().map(|(i, j)| (a[i], b[j])).collect()
}

/// Pairs of `a` and `b` between which lines go, as indices: panes that face each other with none of `all` between, and
/// mutually nearest panes.
fn joined(a: &[Rect], b: &[Rect], all: &[Rect]) -> Vec<(usize, usize)> {
    let nearest = |from: &Rect, to: &[Rect]| {
        let place = |i: &usize| apart(from, &to[*i]);
        (0..to.len()).min_by(|i, j| place(i).total_cmp(&place(j)))
    };
    let is_joined = |&(i, j): &(usize, usize)| {
        // Nearest neighbours are joined even where they do not face each other.
        let each_nearest = nearest(&a[i], b) == Some(j) && nearest(&b[j], a) == Some(i);
        each_nearest || face(&a[i], &b[j], all)
    };
    (0..a.len()).flat_map(|i| (0..b.len()).map(move |j| (i, j))).filter(is_joined).collect()
}

fn apart(a: &Rect, b: &Rect) -> f32 {
    // Of rectangles apart the common part has a negative size.
    (-a.intersect(*b).size()).max(Vec2::ZERO).length()
}

fn face(a: &Rect, b: &Rect, all: &[Rect]) -> bool {
    let common = a.intersect(*b);
    let (x, y) = (common.x_range(), common.y_range());
    let gap = match (x.span() > 0.0, y.span() > 0.0) {
        (false, true) => Rect::from_x_y_ranges(x.flipped(), y),
        (true, false) => Rect::from_x_y_ranges(x, y.flipped()),
        _ => return false,
    };
    // Neighbours touch the rim of the gap: only what reaches into it stands between.
    let gap = gap.shrink(1.0);
    all.iter().all(|other| other == a || other == b || !(gap.is_positive() && other.intersects(gap)))
}

/// Canvas of the last pass, and its view before the panel came.
#[derive(Debug, Default)]
pub struct HeldPlace {
    last: Option<(Rect, bool)>,
    moved: Option<(View, View)>,
    /// View at the end of the last pass.
    pub(super) left: Option<View>,
}

impl HeldPlace {
    /// Adapts `view` to the canvas `rect_ui` of this pass, beside which a panel came by itself (`is_beside`) or not.
    /// When the panel comes, the picture keeps its place and size; when it goes, an untouched view is as before. A
    /// view that was set as the panel came, such as that of a session, is one beside it.
    pub fn keep(&mut self, view: &mut View, rect_ui: Rect, is_beside: bool) {
        let Some((before, was_beside)) = self.last.replace((rect_ui, is_beside)) else { return };
        let untouched = self.moved.filter(|(after, _)| after == view).map(|(_, original)| original);
        // A panel finds its width in its first passes.
        let is_growing = is_beside && untouched.is_some();
        if before == rect_ui || (was_beside == is_beside && !is_growing) {
            return;
        }
        match untouched.filter(|_| !is_beside) {
            Some(original) => *view = original,
            None if is_beside && self.left.is_some_and(|left| left != *view) => self.moved = None,
            // A picture fitted beside the panel is fitted again without the panel.
            None if !is_beside && !matches!(view.zoom, Zoom::PointsPerPixel(_)) => self.moved = None,
            None => {
                let original = untouched.unwrap_or(*view);
                view.keep_place(before, rect_ui);
                self.moved = is_beside.then_some((*view, original));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::{pos2, vec2};

    fn at(column: usize, row: usize) -> Rect {
        Rect::from_min_size(pos2(104.0 * column as f32, 110.0 * row as f32), vec2(100.0, 80.0))
    }

    fn of(a: &[Rect], b: &[Rect], others: &[Rect]) -> Vec<(usize, usize)> {
        let all: Vec<Rect> = a.iter().chain(b).chain(others).copied().collect();
        joined(a, b, &all)
    }

    #[test]
    fn neighbours_are_joined_without_what_lies_behind_them_and_so_are_those_far_apart() {
        assert_eq!(of(&[at(0, 0)], &[at(1, 0)], &[]), [(0, 0)]);
        assert_eq!(of(&[at(0, 0)], &[at(0, 1)], &[]), [(0, 0)], "one above the other");
        assert_eq!(of(&[at(0, 0), at(1, 0)], &[at(2, 0)], &[]), [(1, 0)], "A twice, B once");
        assert_eq!(of(&[at(0, 0), at(0, 1)], &[at(1, 0), at(1, 1)], &[]), [(0, 0), (1, 1)], "row by row");
        let tall = Rect::from_min_max(at(1, 0).min, at(1, 1).max);
        assert_eq!(of(&[at(0, 0), at(0, 1)], &[tall], &[]), [(0, 0), (1, 0)]);
        assert_eq!(of(&[at(0, 0)], &[at(2, 0)], &[at(1, 0)]), [(0, 0)], "a difference stands between them");
        assert_eq!(of(&[at(0, 0)], &[at(1, 1)], &[]), [(0, 0)], "across the corner");
        assert!(of(&[at(0, 0)], &[], &[]).is_empty());
    }

    const SIZE: (usize, usize) = (480, 360);

    fn rect(width: f32) -> Rect {
        Rect::from_min_size(pos2(240.0, 84.0), Vec2::new(width, 600.0))
    }

    #[test]
    fn a_view_that_was_changed_meanwhile_stays_as_it_is_and_a_resized_window_fits_anew() {
        let (mut aside, mut view) = (HeldPlace::default(), View::fit());
        aside.keep(&mut view, rect(1040.0), false);
        view.settle(rect(1040.0), SIZE, 1.0);
        aside.keep(&mut view, rect(780.0), true);
        view.zoom_by(1.5);
        let place = pos2(200.0, 150.0);
        let before = view.settle(rect(780.0), SIZE, 1.0).pos(place);
        aside.keep(&mut view, rect(1040.0), false);
        let after = view.settle(rect(1040.0), SIZE, 1.0).pos(place);
        assert!((after - before).length() < 0.6 && !view.is_fit());
        let (mut aside, mut view) = (HeldPlace::default(), View::fit());
        aside.keep(&mut view, rect(1040.0), false);
        aside.keep(&mut view, rect(600.0), false);
        assert!(view.is_fit());
    }
}
