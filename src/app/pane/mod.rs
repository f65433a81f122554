//! Panes: each shows one picture of one open burst.
//!
//! A [`Pane`] is a plain value: its burst, and the method whose input it shows; its place there ([`Cursor`]: frame,
//! slope, octave, level), kind of picture, pan and zoom, own value range if it has one, and links to other panes
//! ([`PaneLinks`]). [`Panes`] holds all of them. *Inspect*, *Two bursts* and *Methods* have an [`Arrangement`] each,
//! with one focused pane, which sliders and keys move. Two panes are permanent, one for each of the two bursts.
//!
//! The picture that a pane needs follows from its values alone ([`wanted`](Pane::wanted)). The window requests it from
//! the engine under the pane's own number, and stores the answer in [`Pane::picture`].

mod arrangement;
mod changes;
mod links;
mod methods;
mod place;
mod preset;
mod saved;
mod set;
mod sides;
mod tiles;
mod together;

pub use arrangement::{Arrangement, Direction, MAX_PANES, Part};
pub use links::{Link, PaneLinks};
pub use methods::MethodsPreset;
pub use place::place_in;
pub use preset::Preset;
pub use saved::{SavedPane, SavedPanes, SavedWorkspaces};
pub use set::Panes;
pub use sides::SidesPreset;
pub use tiles::{arrangement_of, tree_of};

use crate::app::project::cursor::{Cursor, ViewKind};
use crate::app::project::look::Ranges;
use crate::app::project::method::Contender;
use crate::app::project::side::Side;
use crate::app::view::View;
use crate::detector::{DetectorParams, Method};
use crate::requests::{OpenBurst, Picture, PictureKind, PictureRequest};
use serde::{Deserialize, Serialize};

/// Id of a pane, for as long as it is open.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(transparent)]
pub struct PaneId(pub u32);

impl PaneId {
    pub fn of(side: Side) -> Self {
        Self(side as u32)
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Content {
    /// Picture at the cursor: a frame, a motion stack or a DoG response.
    #[default]
    Cursor,
    /// The frames of its burst, aligned and merged into one image.
    Merge,
    /// Map of a quantity that decides in the search, at the cursor.
    Map(ViewKind),
    /// The picture of one pane less that of another.
    Difference(PaneId, PaneId),
    Slice(SliceAxis),
}

impl Content {
    /// Name in the glossary and in exported files' names of a content, with the kind of picture of its cursor.
    pub fn key(self, of_cursor: ViewKind) -> &'static str {
        match self {
            Self::Difference(..) => "difference",
            Self::Slice(_) => "slice",
            Self::Cursor => of_cursor.about().key,
            Self::Merge => ViewKind::Merge.about().key,
            Self::Map(map) => map.about().key,
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SliceAxis {
    /// Along the probed motion: the x–t slice for horizontal motion.
    Along,
    /// Across it: the y–t slice for horizontal motion.
    Across,
}

impl SliceAxis {
    pub const ALL: [Self; 2] = [Self::Along, Self::Across];

    pub fn label(self) -> &'static str {
        match self {
            Self::Along => "Slice along the motion",
            Self::Across => "Slice across the motion",
        }
    }

    pub fn help(self) -> &'static str {
        match self {
            Self::Along => {
                "A row for each frame through the probed place, along its motion (x–t): what moves is slanted"
            }
            Self::Across => "A row for each frame through the probed place, across its motion (y–t)",
        }
    }
}

/// Another pane's picture in the same place, for comparison.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Over {
    /// On the right of a line that can be moved.
    Wipe { other: PaneId, at: f32 },
    /// In turn with the pane's own.
    Flip { other: PaneId, flipped: bool },
}

impl Over {
    #[must_use]
    pub fn with_other(self, other: PaneId) -> Self {
        match self {
            Self::Wipe { at, .. } => Self::Wipe { other, at },
            Self::Flip { flipped, .. } => Self::Flip { other, flipped },
        }
    }

    pub fn other(self) -> PaneId {
        match self {
            Self::Wipe { other, .. } | Self::Flip { other, .. } => other,
        }
    }
}

#[derive(Debug, Clone)]
pub struct Pane {
    pub side: Side,
    /// Method whose input the pane shows, where methods are compared.
    pub method: Option<Contender>,
    pub content: Content,
    /// Place in the burst. A linked pane may have been moved beyond the burst's range; [`Pane::cursor_within`] limits
    /// it.
    pub cursor: Cursor,
    /// Whether the slope was chosen (by hand or by a session) since the burst was opened.
    pub slope_chosen: bool,
    /// Pan and zoom.
    pub view: View,
    /// Value ranges and colour maps of its own; `None` shares those of all.
    pub own_ranges: Option<Ranges>,
    pub links: PaneLinks,
    pub over: Option<Over>,
    pub picture: Option<Picture>,
    /// Request that failed, and why.
    pub problem: Option<(PictureRequest, String)>,
}

impl Pane {
    pub fn new(side: Side) -> Self {
        Self {
            side,
            method: None,
            content: Content::default(),
            cursor: Cursor::default(),
            slope_chosen: false,
            view: View::fit(),
            own_ranges: None,
            links: PaneLinks::default(),
            over: None,
            picture: None,
            problem: None,
        }
    }

    pub fn show(&mut self, kind: ViewKind) {
        self.content = match kind {
            ViewKind::Merge => Content::Merge,
            of_cursor if ViewKind::OF_CURSOR.contains(&of_cursor) => {
                self.cursor.kind = kind;
                Content::Cursor
            }
            map => Content::Map(map),
        };
    }

    /// Shows a slice through the frames, which is no picture of the image plane.
    pub fn show_slice(&mut self, axis: SliceAxis) {
        (self.content, self.over, self.picture) = (Content::Slice(axis), None, None);
    }

    pub fn show_method(&mut self, method: Option<Contender>) {
        if self.method != method {
            (self.method, self.picture, self.problem) = (method, None, None);
        }
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
        let is_seen = is_slice || self.shown().is_some_and(|kind| kind.about().of_slope);
        if !is_seen {
            self.show(ViewKind::Stack);
        }
    }

    /// Switches to the DoG where the content does not depend on octave and level, after one of them was moved.
    pub fn show_scale(&mut self) {
        if !self.shown().is_some_and(|kind| kind.about().of_scale) {
            self.show(ViewKind::Dog);
        }
    }

    /// Cursor, limited to the ranges of the burst and the parameters.
    pub fn cursor_within(&self, burst: &OpenBurst, params: &DetectorParams) -> Cursor {
        self.cursor.within(params, burst.burst.len(), burst.burst.size())
    }

    /// Picture that the pane needs of its own burst; `None` for a difference, which is made of other panes' pictures,
    /// and for a slice.
    pub fn wanted(&self, burst: &OpenBurst, params: &DetectorParams) -> Option<PictureRequest> {
        let kind = self.cursor_within(burst, params).picture(self.shown()?);
        let kind = self.seen_by_method(kind, burst, params);
        Some(PictureRequest::new(burst.clone(), kind, params.clone()))
    }

    /// Where methods are compared, replaces a motion stack by the method's input: one frame or the merged frames for
    /// SIFT.
    fn seen_by_method(&self, kind: PictureKind, burst: &OpenBurst, params: &DetectorParams) -> PictureKind {
        match (kind, params.method) {
            (PictureKind::Stack { .. }, Method::Sift) if self.method.is_some() => {
                PictureKind::Frame(params.used_frames(burst.burst.len()).start)
            }
            (PictureKind::Stack { .. }, Method::Merge) if self.method.is_some() => PictureKind::Merge,
            _ => kind,
        }
    }

    /// Panes whose pictures this one shows besides its own.
    pub fn others(&self) -> Vec<PaneId> {
        let mut others = match self.content {
            Content::Difference(a, b) => vec![a, b],
            Content::Cursor | Content::Merge | Content::Map(_) | Content::Slice(_) => Vec::new(),
        };
        others.extend(self.over.map(Over::other));
        others
    }
}

#[cfg(test)]
mod tests;
