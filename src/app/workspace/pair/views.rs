//! The panes between which matches are drawn, as they are on the screen in this pass.

use crate::app::canvas::CanvasOutput;
use crate::app::canvas::overlay::Pane;
use crate::app::inspector::{Drawn, JoinedPanes, joined_panes};
use crate::app::pane::PaneId;
use crate::app::panel::features::frames_from_middle;
use crate::app::project::Model;
use crate::app::project::method::Contender;
use crate::app::project::side::Side;
use egui::{Pos2, Rect};

/// One pane.
pub struct MatchView<'a> {
    /// Whose burst it shows.
    pub side: Side,
    /// Its canvas.
    pub output: &'a CanvasOutput,
    /// How many frames what it shows is after mid-burst; 0 where that is no frame.
    pub shift: f32,
}

/// All of one method, or of none where no methods are compared.
pub struct MatchViews<'a> {
    /// The panes.
    pub views: Vec<MatchView<'a>>,
    /// Between which of them lines go: the place of one of A, and of one of B.
    pub pairs: Vec<(usize, usize)>,
}

impl<'a> MatchViews<'a> {
    /// Those among what was drawn that show what `method` looks at.
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

    /// The panes of one burst.
    pub fn on(&self, side: Side) -> impl Iterator<Item = &MatchView<'a>> {
        self.views.iter().filter(move |view| view.side == side)
    }

    /// The pane that the pointer is over, and where.
    pub fn pointed(&self) -> Option<(usize, Pos2)> {
        self.views.iter().enumerate().find_map(|(place, view)| Some((place, view.output.pointer_ui?)))
    }

    /// The two canvases of each pair, A's first; those that have no partner stand beside nothing, so that the ends of
    /// their matches are seen. The pair that the pointer is in comes last.
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
    /// A's and B's.
    pub panes: [Pane; 2],
    /// How many frames what each shows is after mid-burst.
    pub shifts: [f32; 2],
    /// Which views they are; `None` beside a pane that has no partner.
    pub places: [Option<usize>; 2],
}
