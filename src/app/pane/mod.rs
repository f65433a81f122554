//! Panes, which show a picture of an open burst each.
//!
//! A [`Pane`] is a plain value, and the picture that it needs follows from its values alone ([`wanted`](Pane::wanted)).
//! *One burst*, *Two bursts* and the comparison of methods have an [`Arrangement`] each, with one focused pane, which
//! sliders and keys move. Two panes are permanent, one for each of the two bursts.

mod arrangement;
mod changes;
mod links;
mod preset;
mod set;
mod tiles;

pub use arrangement::{Arrangement, Direction, MAX_PANES, Part};
pub use links::{Link, PaneLinks, place_in};
pub use preset::{MethodsPreset, Preset, SidesPreset};
pub use set::{PaneGroup, Panes};
pub use tiles::{arrangement_of, tree_of};

use crate::app::{document::cursor::Cursor, document::look::Ranges, document::method::MethodId};
use crate::app::{document::side::Side, view::View, words::choices};
use crate::detector::{DetectorParams, Method};
use crate::requests::{OpenBurst, PictureKind, PictureRequest, ViewKind};
use serde::{Deserialize, Serialize};

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(transparent)]
pub struct PaneId(pub u32);

impl PaneId {
    pub const fn of(side: Side) -> Self {
        Self(side as u32)
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Content {
    #[default]
    Cursor,
    Merge,
    Map(ViewKind),
    Difference(PaneId, PaneId),
    Slice(SliceAxis),
}

impl Content {
    /// Name in the glossary and in exported files' names of a content, with the kind of picture of its cursor.
    pub fn key(self, of_cursor: ViewKind) -> &'static str {
        match self {
            Self::Difference(..) => "difference",
            Self::Slice(_) => "slice",
            Self::Cursor => of_cursor.key(),
            Self::Merge => ViewKind::Merge.key(),
            Self::Map(map) => map.key(),
        }
    }
}

choices! {
    SliceAxis {
        Along: "Slice along the motion",
        "A row for each frame through the probed place, along its motion (x–t): what moves is slanted";
        Across: "Slice across the motion", "A row for each frame through the probed place, across its motion (y–t)";
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Over {
    Wipe { other: PaneId, at: f32 },
    Flip { other: PaneId, flipped: bool },
}

impl Over {
    pub fn other_mut(&mut self) -> &mut PaneId {
        match self {
            Self::Wipe { other, .. } | Self::Flip { other, .. } => other,
        }
    }

    pub fn other(self) -> PaneId {
        match self {
            Self::Wipe { other, .. } | Self::Flip { other, .. } => other,
        }
    }
}

#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Pane {
    pub side: Side,
    pub method: Option<MethodId>,
    pub content: Content,
    /// A linked pane may have been moved beyond the burst's range; [`Pane::cursor_within`] limits it.
    pub cursor: Cursor,
    /// Whether the slope was chosen (by hand or by a session) since the burst was opened.
    pub slope_chosen: bool,
    pub view: View,
    /// Own value ranges and colour maps; `None` shares those of all panes.
    pub own_ranges: Option<Ranges>,
    pub links: PaneLinks,
    pub over: Option<Over>,
}

impl Pane {
    pub fn new(side: Side) -> Self {
        Self { side, ..Self::default() }
    }

    pub fn show(&mut self, kind: ViewKind) {
        self.content = match kind {
            ViewKind::Merge => Content::Merge,
            // The cursor remembers the last of these kinds, also while the pane shows another.
            of_cursor if ViewKind::OF_CURSOR.contains(&of_cursor) => {
                self.cursor.kind = kind;
                Content::Cursor
            }
            map => Content::Map(map),
        };
    }

    /// Shows a slice through the frames, which is no picture of the image plane.
    pub fn show_slice(&mut self, axis: SliceAxis) {
        (self.content, self.over) = (Content::Slice(axis), None);
    }

    /// The kind of picture that the pane shows; `None` for slices and differences, which are made of several.
    pub fn shown(&self) -> Option<ViewKind> {
        match self.content {
            Content::Cursor => Some(self.cursor.kind),
            Content::Merge => Some(ViewKind::Merge),
            Content::Map(map) => Some(map),
            Content::Difference(..) | Content::Slice(_) => None,
        }
    }

    pub fn shows(&self, kind: ViewKind) -> bool {
        self.shown() == Some(kind)
    }

    /// Switches to the motion stack where the content does not depend on the slope, after the slope was moved.
    pub fn show_slope(&mut self) {
        self.slope_chosen = true;
        // A slice shows the slope as a line.
        let is_slice = matches!(self.content, Content::Slice(_));
        if !is_slice && !self.shown().is_some_and(|kind| kind.about().of_slope) {
            self.show(ViewKind::Stack);
        }
    }

    /// Switches to the DoG where the content does not depend on octave and level, after one of them was moved.
    pub fn show_scale(&mut self) {
        if !self.shown().is_some_and(|kind| kind.about().of_scale) {
            self.show(ViewKind::Dog);
        }
    }

    pub fn cursor_within(&self, burst: &OpenBurst, params: &DetectorParams) -> Cursor {
        self.cursor.within(params, burst.burst.len(), burst.burst.size())
    }

    /// `None` for a difference, which is made of other panes' pictures, and for a slice.
    pub fn wanted(&self, burst: &OpenBurst, params: &DetectorParams) -> Option<PictureRequest> {
        let kind = self.cursor_within(burst, params).picture(self.shown()?);
        Some(PictureRequest::new(burst.clone(), self.seen_by_method(kind, burst, params), params.clone()))
    }

    /// In a comparison of methods SIFT shows its input, one frame or the merged frames, in place of a motion stack.
    fn seen_by_method(&self, kind: PictureKind, burst: &OpenBurst, params: &DetectorParams) -> PictureKind {
        match (kind, params.method) {
            (PictureKind::Stack { .. }, Method::Sift) if self.method.is_some() => {
                PictureKind::Frame(params.used_frames(burst.burst.len()).start)
            }
            (PictureKind::Stack { .. }, Method::Merge) if self.method.is_some() => PictureKind::Merge,
            _ => kind,
        }
    }

    pub fn others(&self) -> Vec<PaneId> {
        let subtracted = if let Content::Difference(a, b) = self.content { vec![a, b] } else { Vec::new() };
        subtracted.into_iter().chain(self.over.map(Over::other)).collect()
    }
}
