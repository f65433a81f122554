//! The probe of the window: the burst and the place that are probed, the trail from which answers come, and the answer.
//!
//! One place of one burst is probed at a time. Swapping the sides takes the probe along with its burst.

use crate::app::document::{PinnedPlace, Probe, Side};
use crate::app::pane::{Pane, PaneId};
use crate::app::{results::Read, results::own::origin};
use crate::detector::scale_space::ScaleSpace;
use crate::detector::{ParamChange, Slope};
use crate::engine::Wanted;
use crate::inspect::place::{AT_PLACE_PX, Fate, ProbeSubject, time_factor};
use crate::requests::{DetectionSource, ProbeQuestion, ProbeRequest, Probed, Traced, ViewKind};

#[derive(Debug, Default)]
pub struct ProbeResults {
    /// Features at the place that the pane of the probed burst drew as dots in the last pass.
    pub as_dots: Vec<usize>,
    pub traced: Option<Traced>,
    pub answer: Option<Probed>,
    pub problem: Option<String>,
    /// The place under the pointer as of the last pass: its burst, and pixels at mid-burst.
    pub pointer: Option<(Side, [f32; 2])>,
    pub wanted_trail: Wanted<DetectionSource>,
    pub wanted_answer: Wanted<ProbeRequest>,
}

impl ProbeResults {
    pub fn features_here(&self) -> Vec<usize> {
        let Some(probe) = self.answer.as_ref().map(|answer| &answer.probe) else { return Vec::new() };
        let away = |fate: &&Fate| egui::Pos2::from(fate.pos_image).distance(probe.pos_image.into());
        let here = probe.near_fates().iter().filter(|fate| away(fate) <= AT_PLACE_PX);
        here.filter_map(|fate| fate.features.first().copied()).collect()
    }
}

impl<'a> Read<'a> {
    pub fn has_probe(self) -> bool {
        let probe = &self.document.probe;
        let has_place = self.places_of(probe.side).next().is_some();
        probe.is_open || probe.is_on() || self.results.probed.answer.is_some() || has_place
    }

    /// Pinned places of the burst of `side`, each with its index in the document.
    pub fn places_of(self, side: Side) -> impl Iterator<Item = (usize, &'a PinnedPlace)> {
        let open = self.burst_of(side).map(|open| origin(&open.source));
        self.document.places.iter().enumerate().filter(move |(_, place)| open.as_ref() == Some(&place.of))
    }

    /// The probed place with a name that is free; `None` where it is pinned already.
    pub fn place_to_pin(self) -> Option<PinnedPlace> {
        let side = self.document.probe.side;
        let (at, of) = (self.probed_place()?, origin(&self.burst_of(side)?.source));
        let is_free = |name: &String| self.places_of(side).all(|(_, place)| place.name != *name);
        let numbers = 1 + self.places_of(side).count()..;
        let name = numbers.map(|number| format!("Place {number}")).find(is_free)?;
        self.places_of(side).all(|(_, place)| place.at != at).then_some(PinnedPlace { name, at, of })
    }

    /// The place that is probed, pixels at mid-burst: that of the question, or of the answer while that is not known.
    pub fn probed_place(self) -> Option<[f32; 2]> {
        match self.document.probe.question? {
            ProbeQuestion::At { place, wanted: ProbeSubject::Feature(_) } => Some(match &self.results.probed.answer {
                Some(answer) if self.probe_is_current() => answer.probe.pos_image,
                _ => place,
            }),
            ProbeQuestion::At { place, .. } => Some(place),
            ProbeQuestion::Strongest => None,
        }
    }

    fn wanted_probe(self) -> Option<ProbeRequest> {
        let Probe { question, near_sigma, in_view, .. } = self.document.probe;
        Some(ProbeRequest { traced: self.results.probed.traced.clone()?, question: question?, near_sigma, in_view })
    }

    pub fn probe_is_current(self) -> bool {
        let wanted = self.wanted_probe();
        self.results.probed.answer.as_ref().zip(wanted).is_some_and(|(answer, wanted)| answer.request == wanted)
    }

    /// A running detection comes first: it leaves its trail.
    pub fn missing_trail(self, dragging: bool) -> Option<DetectionSource> {
        let waits = dragging || self.results.slots[self.document.probe.side].detecting.is_pending();
        let is_asked = self.document.probe.is_on() && self.results.probed.problem.is_none();
        self.untraced().filter(|_| is_asked && !waits)
    }

    pub fn missing_probe(self) -> Option<ProbeRequest> {
        self.wanted_probe().filter(|_| !self.probe_is_current())
    }

    /// Scale σ of the DoG that the pane of the probed burst shows, input pixels; `None` for other content.
    pub fn sigma_in_view(self) -> Option<f32> {
        let (pane, params) = (self.probed_pane(), &self.results.slots[self.document.probe.side].usable_params);
        let space = ScaleSpace::of(params);
        pane.shows(ViewKind::Dog).then(|| space.sigma_image(pane.cursor.octave, f64::from(pane.cursor.level)) as f32)
    }

    /// The slope of the picture that the pane of the probed burst shows; `None` for other content.
    pub fn slope_in_view(self) -> Option<Slope> {
        let pane = self.probed_pane();
        pane.shown().is_some_and(|kind| kind.about().of_slope).then_some(pane.cursor.slope)
    }

    pub fn untraced(self) -> Option<DetectionSource> {
        let side = self.document.probe.side;
        let (burst, found) = (self.burst_of(side)?, self.found_of(side)?);
        let is_of = |traced: &Traced| {
            traced.burst == burst.id && traced.cache.asked == found.asked && traced.cache.made_with() == found.params
        };
        if self.results.probed.traced.as_ref().is_some_and(is_of) { None } else { self.found_source(side) }
    }

    /// With its side: the selected one; of two bursts that of the match or the one asked about, on the side in focus.
    pub fn feature_to_probe(self) -> Option<(Side, usize)> {
        if !self.document.workspace.shows_pair() {
            return self.selected_feature().and(self.document.selected).map(|index| (Side::A, index));
        }
        let of_match = self.selected_match().map(|row| match self.active_side() {
            Side::A => (Side::A, row.found.a),
            Side::B => (Side::B, row.found.b),
        });
        of_match.or_else(|| Some((Side::A, self.asked_feature()?)))
    }

    pub fn probed_pane_id(self) -> PaneId {
        let side = self.document.probe.side;
        if self.document.focused().side == side { self.document.focus() } else { self.document.pane_for(side) }
    }

    pub fn probed_pane(self) -> &'a Pane {
        let panes = &self.document.panes;
        panes.get(self.probed_pane_id()).unwrap_or_else(|| panes.of(self.document.probe.side))
    }

    pub fn probe_is_stale(self) -> bool {
        let asked = || self.asked_of(self.document.probe.side);
        self.results.probed.answer.as_ref().is_some_and(|answer| answer.request.traced.cache.asked != asked())
    }

    /// Time of a search with `change`, a sentence without a full stop; `None` for what cannot be made.
    pub fn search_time_text(self, side: Side, change: &ParamChange) -> Option<String> {
        let (found, burst) = (self.found_of(side)?, self.burst_of(side)?);
        let changed = change.applied(&found.params).ok()?;
        let secs = found.search_secs * time_factor(&found.searched, &changed, burst.burst.size());
        Some(match secs {
            ..1.0 => "A new search takes less than a second".to_owned(),
            _ => format!("A new search takes about {secs:.0} s"),
        })
    }
}
