//! Panes between which matches are drawn, as drawn in this pass.

use crate::app::canvas::CanvasOutput;
use crate::app::canvas::overlay::Pane;
use crate::app::inspector::{Drawn, JoinedPanes, joined_panes};
use crate::app::pane::PaneId;
use crate::app::panel::features::frames_from_middle;
use crate::app::project::Model;
use crate::app::project::method::Contender;
use crate::app::project::side::Side;
use egui::{Pos2, Rect};

/// Pane of one burst.
pub struct MatchView<'a> {
    /// Burst that it shows.
    pub side: Side,
    /// Canvas of the pane.
    pub output: &'a CanvasOutput,
    /// Time of its picture, frames after mid-burst; 0 if it shows no frame.
    pub shift: f32,
}

/// Panes of one method, or of none where no methods are compared.
pub struct MatchViews<'a> {
    /// The panes.
    pub views: Vec<MatchView<'a>>,
    /// Pairs between which lines go: indices of a pane of A and of one of B.
    pub pairs: Vec<(usize, usize)>,
}

impl<'a> MatchViews<'a> {
    /// Collects the drawn panes that show the input of `method`.
    pub fn of(model: &Model, drawn: &'a [(PaneId, Drawn)], method: Option<Contender>) -> Self {
        let places: Vec<_> = drawn.iter().map(|(_, drawn)| (drawn.shown, drawn.output.response.rect)).collect();
        let JoinedPanes { sides, pairs } = joined_panes(model, &places, method);
        let mut of_drawn: Vec<(usize, Side)> =
            sides.iter().zip(Side::BOTH).flat_map(|(places, side)| places.iter().map(move |i| (*i, side))).collect();
        of_drawn.sort_by_key(|(place, _)| *place);
        let shift = |id: PaneId| {
            let pane = model.panes.get(id)?;
            frames_from_middle(pane.picture.as_ref(), model.detection_in(pane)?)
        };
        let view = |(place, side): &(usize, Side)| {
            let drawn = &drawn[*place].1;
            MatchView { side: *side, output: &drawn.output, shift: shift(drawn.shown).unwrap_or(0.0) }
        };
        let views = of_drawn.iter().map(view).collect();
        let place = |of: usize| of_drawn.iter().position(|(place, _)| *place == of);
        let pairs = pairs.into_iter().filter_map(|(a, b)| Some((place(a)?, place(b)?))).collect();
        Self { views, pairs }
    }

    /// Panes of one burst.
    pub fn on(&self, side: Side) -> impl Iterator<Item = &MatchView<'a>> {
        self.views.iter().filter(move |view| view.side == side)
    }

    /// Index of the pane under the pointer, and the pointer's position, in points.
    pub fn pointed(&self) -> Option<(usize, Pos2)> {
        self.views.iter().enumerate().find_map(|(place, view)| Some((place, view.output.pointer_ui?)))
    }

    /// Canvases of each pair, A's first. A pane without a partner is paired with an empty rectangle, so that the ends
    /// of its matches are marked. The pair under the pointer comes last.
    pub fn canvases(&self) -> Vec<Canvases> {
        let pane = |place: usize| {
            let output = self.views[place].output;
            Pane { ui_from_image: output.ui_from_image, rect_ui: output.response.rect }
        };
        let nothing = |place: usize| Pane { rect_ui: Rect::NOTHING, ..pane(place) };
        let paired = self.pairs.iter().map(|&(a, b)| Canvases {
            panes: [pane(a), pane(b)],
            shifts: [a, b].map(|place| self.views[place].shift),
            places: [Some(a), Some(b)],
        });
        let alone = (0..self.views.len()).filter(|place| !self.pairs.iter().any(|(a, b)| [a, b].contains(&place)));
        let alone = alone.map(|place| {
            let (is_a, shift) = (self.views[place].side == Side::A, self.views[place].shift);
            Canvases {
                panes: if is_a { [pane(place), nothing(place)] } else { [nothing(place), pane(place)] },
                shifts: [shift; 2],
                places: if is_a { [Some(place), None] } else { [None, Some(place)] },
            }
        });
        let mut all: Vec<Canvases> = paired.chain(alone).collect();
        let pointed = self.pointed().map(|(place, _)| place);
        all.sort_by_key(|canvases| pointed.is_some() && canvases.places.contains(&pointed));
        all
    }
}

/// Two canvases between which lines go.
pub struct Canvases {
    /// Canvases of A and B.
    pub panes: [Pane; 2],
    /// Times of their pictures, frames after mid-burst.
    pub shifts: [f32; 2],
    /// Indices of the views; `None` for a missing partner.
    pub places: [Option<usize>; 2],
}
