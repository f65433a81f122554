//! Panels and panes as they are set: what is open, cursors that follow the one in focus, views, links and ranges.

use crate::app::document::{Cursor, Document, Ranges, Side};
use crate::app::pane::{Direction, Link, MethodsPreset, Pane, PaneGroup, PaneId, Preset, SidesPreset};
use crate::app::{defaults::with_defaults, document::cursor::ViewKind};
use crate::app::{view::View, words::choices};
use crate::detector::Slope;
use crate::teach::{BottomTab, Workspace};
use egui::{Pos2, Rect};
use serde::{Deserialize, Serialize};

/// Place to which a pane is moved: what is `None` stays as it is.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Destination {
    pub slope: Option<Slope>,
    pub scale: Option<(i32, i32)>,
    pub frame: Option<usize>,
    pub kind: Option<ViewKind>,
    /// (u, v) in the middle of the view, image pixels, and the least zoom, points per pixel.
    pub at: Option<([f32; 2], f32)>,
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Change {
    Split(PaneId, Direction),
    Close(PaneId),
    LayOut(PaneId, Preset),
    LayOutSides(SidesPreset),
    LayOutMethods(MethodsPreset),
}

impl Document {
    /// Changes a pane. The cursors that are linked with that of the pane in focus follow it. It may leave the range of
    /// its burst, into which the next pass of the window brings it.
    pub fn lead(&mut self, id: PaneId, change: impl FnOnce(&mut Pane)) {
        let Some(pane) = self.panes.get_mut(id) else { return };
        let before = pane.cursor;
        change(pane);
        if id == self.focus() {
            self.panes.follow_cursor(id, before);
        }
    }

    /// Shows a frame. A pane beside one that shows frames, whose cursors are linked, keeps its own kind of picture.
    pub fn show_frame(&mut self, id: PaneId, frame: usize) {
        let Some(pane) = self.panes.get(id) else { return };
        let shows_frame = |other: &Pane| other.shows(ViewKind::Frame) && other.links.cursor && other.side == pane.side;
        let is_beside = pane.links.cursor && self.panes.each_shown().any(shows_frame);
        self.lead(id, |pane| {
            pane.cursor.frame = frame;
            if !is_beside {
                pane.show(ViewKind::Frame);
            }
        });
    }

    pub fn show_slope(&mut self, id: PaneId, slope: Slope) {
        self.lead(id, |pane| {
            pane.cursor.slope = slope;
            pane.show_slope();
        });
    }

    pub fn show_scale(&mut self, id: PaneId, octave: i32, level: i32) {
        self.lead(id, |pane| {
            (pane.cursor.octave, pane.cursor.level) = (octave, level);
            pane.show_scale();
        });
    }

    /// The document with the playing stopped: the user goes to a picture of their own.
    pub fn paused(&mut self) -> &mut Self {
        self.playing = false;
        self
    }

    /// Moves the view of a pane as a canvas moved it from `before` to `after`, and those that are linked with it.
    pub fn move_view(&mut self, id: PaneId, before: &View, after: View) {
        let Some(pane) = self.panes.get_mut(id) else { return };
        let from = pane.view;
        pane.view.take(before, after);
        self.panes.follow_view(id, &from);
    }

    pub fn change_views(&mut self, change: impl Fn(&mut View)) {
        let (focus, shown) = (self.focus(), self.panes.shown());
        let is_linked = self.focused().links.view;
        for (id, pane) in self.panes.iter_mut() {
            if id == focus || (is_linked && pane.links.view && shown.contains(&id)) {
                change(&mut pane.view);
            }
        }
    }

    /// Moves the pane in focus, or the first one on the burst of `side`.
    pub fn go_to(&mut self, side: Side, to: &Destination) {
        self.focus_on_side(side);
        self.playing = false;
        let focus = self.focus();
        self.lead(focus, |pane| {
            if let Some(slope) = to.slope {
                pane.cursor.slope = slope;
                pane.show_slope();
            }
            pane.cursor.frame = to.frame.unwrap_or(pane.cursor.frame);
            if let Some((octave, level)) = to.scale {
                (pane.cursor.octave, pane.cursor.level) = (octave, level);
            }
            to.kind.into_iter().for_each(|kind| pane.show(kind));
        });
        if let (Some((place, zoom)), Some(pane)) = (to.at, self.panes.get_mut(focus)) {
            let before = pane.view;
            pane.view.look_at(place.into(), zoom);
            self.panes.follow_view(focus, &before);
        }
    }

    /// Shows panes of several methods in *One burst*, with the table of their numbers.
    pub fn compare_methods(&mut self) {
        (self.workspace, self.bottom_tab) = (Workspace::Inspect, BottomTab::Methods);
        self.panes.open = PaneGroup::Methods;
    }

    pub fn open_workspace(&mut self, workspace: Workspace) {
        self.workspace = workspace;
        self.panes.turn_to(workspace);
    }

    pub fn focus(&self) -> PaneId {
        self.panes.focus()
    }

    pub fn focused(&self) -> &Pane {
        self.panes.get(self.focus()).unwrap_or_else(|| self.panes.of(Side::A))
    }

    pub fn focused_mut(&mut self) -> &mut Pane {
        let focus = self.focus();
        let focus = if self.panes.get(focus).is_some() { focus } else { PaneId::of(Side::A) };
        self.panes.get_mut(focus).expect("A's pane is always there")
    }

    pub fn cursor(&self) -> &Cursor {
        &self.focused().cursor
    }

    /// Switches a link of a pane. A pane that no longer shares its display keeps the ranges that it had.
    pub fn set_link(&mut self, id: PaneId, link: Link, on: bool) {
        let Some(pane) = self.panes.get_mut(id) else { return };
        pane.links.set(link, on);
        if link == Link::Display {
            pane.own_ranges = (!on).then_some(pane.own_ranges.unwrap_or(self.look.ranges));
        }
    }

    /// Moves the focus to a visible pane on the burst of `side`, if there is one and the focus is not on such a pane.
    pub fn focus_on_side(&mut self, side: Side) {
        if !self.panes.is_on(self.panes.focus(), side)
            && let Some(id) = self.panes.shown().into_iter().find(|id| self.panes.is_on(*id, side))
        {
            self.panes.set_focus(id);
        }
    }

    pub fn ranges_of<'a>(&'a self, pane: &'a Pane) -> &'a Ranges {
        pane.own_ranges.as_ref().unwrap_or(&self.look.ranges)
    }

    pub fn focused_ranges_mut(&mut self) -> &mut Ranges {
        self.ranges_mut(self.focus())
    }

    pub fn ranges_mut(&mut self, id: PaneId) -> &mut Ranges {
        self.panes.get_mut(id).and_then(|pane| pane.own_ranges.as_mut()).unwrap_or(&mut self.look.ranges)
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Visibility {
    /// Where there is room and something to show in it.
    #[default]
    Auto,
    Open,
    /// Only where something is asked of it.
    Closed,
}

impl Visibility {
    /// Whether the panel is shown if `auto` says so for [`Visibility::Auto`].
    pub(in crate::app) fn or(self, auto: bool) -> bool {
        match self {
            Self::Auto => auto,
            Self::Open => true,
            Self::Closed => false,
        }
    }
}

impl From<bool> for Visibility {
    fn from(is_open: bool) -> Self {
        if is_open { Self::Open } else { Self::Closed }
    }
}

with_defaults! {
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
    #[serde(default)]
    pub struct Panels {
        /// Cursor and parameters; by itself where the window is wide enough.
        pub left: Visibility,
        /// Display, selection and probe; by itself with a selection or a probe.
        pub right: Visibility,
        /// Table, tally and measurements; by itself in workspaces other than *One burst* and *Two bursts*.
        pub bottom: Visibility,
        pub filmstrip: bool = true,
        pub advanced: bool,
        pub welcome: bool = true,
        /// A lesson is shown to a hall: large pictures, large letters, and only the panels that a step points at.
        pub hall: bool,
        /// The focus under the pointer is shown in a loupe beside it; else in the whole pane.
        pub loupe: bool,
    }
}

impl Panels {
    pub fn all() -> Self {
        let open = Visibility::Open;
        Self { left: open, right: open, bottom: open, advanced: true, welcome: false, ..Self::default() }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Tool {
    #[default]
    Pan,
    Line,
    Region,
    /// Outlines of what the frames do not show.
    Mask,
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct MeasuredLine {
    pub pane: PaneId,
    pub from_image: Pos2,
    pub to_image: Pos2,
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct MeasuredRegion {
    pub pane: PaneId,
    pub rect_image: Rect,
}

choices! {
    /// How the pointer draws what a mask hides.
    #[derive(Default)]
    MaskShape {
        #[default]
        Outline: "outline", "Drag around what is not to be seen; with Shift a rectangle";
        Rectangle: "rectangle", "Drag from corner to corner";
        Polygon: "polygon", "Click corners; a click on the first one, or a double click, ends it";
        Brush: "brush", "Drag over what is not to be seen";
    }
}

/// A drawn part of the frames that a mask hides, image pixels.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Hidden {
    /// The inside of a closed outline.
    Outline(Vec<Pos2>),
    /// All pixels no farther from a path than its radius.
    Stroke { path: Vec<Pos2>, radius_px: f32 },
}

impl Hidden {
    pub fn points_mut(&mut self) -> &mut Vec<Pos2> {
        match self {
            Self::Outline(points) | Self::Stroke { path: points, .. } => points,
        }
    }
}

with_defaults! {
    #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
    #[serde(default)]
    pub struct Measure {
        pub tool: Tool,
        pub shape: MaskShape,
        /// Radius of the brush, image pixels.
        pub brush_px: f32 = 8.0,
        /// Whether the last outline is a polygon that gets more corners.
        pub is_open: bool,
        pub line: Option<MeasuredLine>,
        pub region: Option<MeasuredRegion>,
        pub drag: Option<(PaneId, Pos2)>,
        /// Parts of the mask, in the order drawn; during a drag the last one is being drawn.
        #[serde(skip_serializing_if = "Vec::is_empty")]
        pub hidden: Vec<Hidden>,
    }
}

impl Measure {
    pub fn toggle(&mut self, tool: Tool) {
        self.tool = if self.tool == tool { Tool::Pan } else { tool };
        self.drag = None;
    }

    pub fn clear(&mut self) {
        *self = Self { shape: self.shape, brush_px: self.brush_px, ..Self::default() };
    }

    pub fn is_empty(&self) -> bool {
        *self == Self { shape: self.shape, brush_px: self.brush_px, ..Self::default() }
    }

    pub fn take_back(&mut self) {
        match self.hidden.last_mut().map(Hidden::points_mut).filter(|points| self.is_open && points.len() > 1) {
            Some(corners) => _ = corners.pop(),
            None => {
                self.hidden.pop();
                self.is_open = false;
            }
        }
    }
}
