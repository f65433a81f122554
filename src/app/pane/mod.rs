//! Panes: each shows one picture of one open burst.
//!
//! A [`Pane`] is a plain value: which burst, and as which method sees it; where in it ([`Cursor`]: frame, slope,
//! octave, level), which kind of picture, pan and zoom, a range of its own if it has one, and what it shares with other
//! panes ([`PaneLinks`]). [`Panes`] holds all of them. *Inspect*, *Two bursts* and *Methods* have an [`Arrangement`]
//! each, with one pane in focus: the one that sliders and keys move. Two panes are always there, one for each of the
//! two bursts.
//!
//! What every pane wants to show follows from its values alone ([`wanted`](Pane::wanted)). The window asks the engine
//! for it under the pane's own number, and puts the answer into [`Pane::picture`].

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
use crate::requests::{MapKind, OpenBurst, Picture, PictureKind, PictureRequest};
use serde::{Deserialize, Serialize};

/// Names a pane, for as long as it is open.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(transparent)]
pub struct PaneId(pub u32);

impl PaneId {
    /// The pane that is always there for the burst of `side`.
    pub fn of(side: Side) -> Self {
        Self(side as u32)
    }
}

/// What a pane shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Content {
    /// What its cursor says: a frame, a motion stack or a DoG response.
    #[default]
    Cursor,
    /// The frames of its burst, aligned and merged into one image.
    Merge,
    /// What decides in the search, by place, where the cursor is.
    Map(MapKind),
    /// The picture of one pane less that of another.
    Difference(PaneId, PaneId),
    /// A slice through the frames at the place that is probed.
    Slice(SliceAxis),
}

/// Which way a slice through the frames runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SliceAxis {
    /// Along the motion of what is probed: the x–t slice where that is to the side.
    Along,
    /// Across it: the y–t slice then.
    Across,
}

impl SliceAxis {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Along, Self::Across];

    /// Its name.
    pub fn label(self) -> &'static str {
        match self {
            Self::Along => "Slice along the motion",
            Self::Across => "Slice across the motion",
        }
    }

    /// What it shows.
    pub fn help(self) -> &'static str {
        match self {
            Self::Along => {
                "A row for each frame through the probed place, along its motion (x–t): what moves is slanted"
            }
            Self::Across => "A row for each frame through the probed place, across its motion (y–t)",
        }
    }
}

/// Another pane's picture in the same place, to compare the two.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Over {
    /// Right of a line that can be moved.
    Wipe {
        /// The pane whose picture it is.
        other: PaneId,
        /// Where the line is, 0 … 1 from the left.
        at: f32,
    },
    /// One after the other.
    Flip {
        /// The pane whose picture it is.
        other: PaneId,
        /// Whether the other's picture is on show.
        flipped: bool,
    },
}

impl Over {
    /// The same with another pane's picture.
    #[must_use]
    pub fn with_other(self, other: PaneId) -> Self {
        match self {
            Self::Wipe { at, .. } => Self::Wipe { other, at },
            Self::Flip { flipped, .. } => Self::Flip { other, flipped },
        }
    }

    /// The pane whose picture it is.
    pub fn other(self) -> PaneId {
        match self {
            Self::Wipe { other, .. } | Self::Flip { other, .. } => other,
        }
    }
}

/// One picture of one open burst.
#[derive(Debug, Clone)]
pub struct Pane {
    /// Which of the open bursts.
    pub side: Side,
    /// As which method sees it, where methods are compared.
    pub method: Option<Contender>,
    /// What it shows.
    pub content: Content,
    /// Where in the burst it is. A linked pane may have been moved beyond what there is; [`Pane::cursor_within`] is
    /// what is shown.
    pub cursor: Cursor,
    /// Whether the slope was chosen (by hand or by a session) since the burst was opened.
    pub slope_chosen: bool,
    /// Pan and zoom.
    pub view: View,
    /// Value ranges and colour maps of its own; `None` shares those of all.
    pub own_ranges: Option<Ranges>,
    /// What it shares with the other panes.
    pub links: PaneLinks,
    /// Another pane's picture in the same place.
    pub over: Option<Over>,
    /// The last good picture.
    pub picture: Option<Picture>,
    /// A picture that could not be made, and why.
    pub problem: Option<(PictureRequest, String)>,
}

impl Pane {
    /// A pane on the burst of `side`.
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

    /// Shows one of the kinds of picture that the cursor moves through.
    pub fn show(&mut self, kind: ViewKind) {
        (self.content, self.cursor.kind) = (Content::Cursor, kind);
    }

    /// Shows a slice through the frames, which is no picture of the image plane.
    pub fn show_slice(&mut self, axis: SliceAxis) {
        (self.content, self.over, self.picture) = (Content::Slice(axis), None, None);
    }

    /// Shows the burst as `method` sees it.
    pub fn show_method(&mut self, method: Option<Contender>) {
        if self.method != method {
            (self.method, self.picture, self.problem) = (method, None, None);
        }
    }

    /// Whether it shows this kind of picture.
    pub fn shows(&self, kind: ViewKind) -> bool {
        self.content == Content::Cursor && self.cursor.kind == kind
    }

    /// A slope was moved, which cannot be seen in a frame: shows the motion stack then. Maps are of a slope.
    pub fn show_slope(&mut self) {
        self.slope_chosen = true;
        let is_seen = match self.content {
            Content::Cursor => self.cursor.kind != ViewKind::Frame,
            Content::Map(map) => map.is_of_slope(),
            // There the slope is a line.
            Content::Slice(_) => true,
            Content::Merge | Content::Difference(..) => false,
        };
        if !is_seen {
            self.show(ViewKind::Stack);
        }
    }

    /// Octave or level was moved, which can be seen in few pictures: shows the DoG where it cannot.
    pub fn show_scale(&mut self) {
        if !matches!(self.content, Content::Map(map) if map.is_of_octave()) {
            self.show(ViewKind::Dog);
        }
    }

    /// The cursor, brought into what the burst and the parameters have.
    pub fn cursor_within(&self, burst: &OpenBurst, params: &DetectorParams) -> Cursor {
        self.cursor.within(params, burst.burst.len(), burst.burst.size())
    }

    /// The picture that it wants of its own burst; `None` for a difference, which is made of other panes' pictures, and
    /// a slice.
    pub fn wanted(&self, burst: &OpenBurst, params: &DetectorParams) -> Option<PictureRequest> {
        let kind = match self.content {
            Content::Cursor => self.seen_by_method(self.cursor_within(burst, params).picture_kind(), burst, params),
            Content::Merge => PictureKind::Merge,
            Content::Map(map) => {
                let Cursor { octave, level, slope, .. } = self.cursor_within(burst, params);
                PictureKind::Map { map, octave, level, slope }
            }
            Content::Difference(..) | Content::Slice(_) => return None,
        };
        Some(PictureRequest::new(burst.clone(), kind, params.clone()))
    }

    /// Where methods are compared, what the method looks at instead of a motion stack: SIFT at one frame, or at the
    /// merged frames.
    fn seen_by_method(&self, kind: PictureKind, burst: &OpenBurst, params: &DetectorParams) -> PictureKind {
        match (kind, params.method) {
            (PictureKind::Stack { .. }, Method::Sift) if self.method.is_some() => {
                PictureKind::Frame(params.used_frames(burst.burst.len()).start)
            }
            (PictureKind::Stack { .. }, Method::Merge) if self.method.is_some() => PictureKind::Merge,
            _ => kind,
        }
    }

    /// The panes whose pictures it shows besides its own.
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
