//! The probe of the window: the burst and the place that are probed, the trail from which answers come, and the answer.
//!
//! One place of one burst is probed at a time. Swapping the sides takes the probe along with its burst.

use crate::app::document::cursor::ViewKind;
use crate::app::document::probe::Probe;
use crate::app::document::side::Side;
use crate::app::pane::{Pane, PaneId};
use crate::app::results::Model;
use crate::detector::scale_space::ScaleSpace;
use crate::detector::{ParamChange, Slope, SlopeChoice, SlopeGrid};
use crate::engine::{Ended, Wanted};
use crate::inspect::Fate;
use crate::inspect::price::time_factor;
use crate::inspect::probe::{AT_PLACE_PX, Wanted as Subject};
use crate::inspect::remedy::nearest_slope;
use crate::inspect::words::capitalised;
use crate::requests::{BurstSource, DetectionSource, JobError, OpenBurst, ProbeQuestion, ProbeRequest, Probed, Traced};
use crate::synth::Example;
use crate::teach::Workspace;

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
    /// Features of the answer that lie at its place.
    pub fn features_here(&self) -> Vec<usize> {
        let Some(probe) = self.answer.as_ref().map(|answer| &answer.probe) else { return Vec::new() };
        let away =
            |fate: &&Fate| (fate.pos_image[0] - probe.pos_image[0]).hypot(fate.pos_image[1] - probe.pos_image[1]);
        let here = probe.near_fates().iter().filter(|fate| away(fate) <= AT_PLACE_PX);
        here.filter_map(|fate| fate.features.first().copied()).collect()
    }
}

impl Model {
    pub fn has_probe(&self) -> bool {
        self.document.probe.is_open || self.document.probe.is_on() || self.results.probed.answer.is_some()
    }

    pub fn clear_probe(&mut self) {
        (self.document.probe, self.results.probed) = Default::default();
    }

    /// Probes the burst of `side` from now on. Question and answer about the other burst are forgotten.
    fn turn_probe_to(&mut self, side: Side) {
        if self.document.probe.side != side {
            let Probe { is_open, follows, .. } = self.document.probe;
            self.document.probe = Probe { side, is_open, follows, ..Probe::default() };
            self.results.probed = ProbeResults { pointer: self.results.probed.pointer, ..ProbeResults::default() };
        }
    }

    /// The place that is probed, pixels at mid-burst: that of the question, or of the answer while that is not known.
    pub fn probed_place(&self) -> Option<[f32; 2]> {
        match self.document.probe.question? {
            ProbeQuestion::At { place, wanted: Subject::Feature(_) } => Some(match &self.results.probed.answer {
                Some(answer) if self.probe_is_current() => answer.probe.pos_image,
                _ => place,
            }),
            ProbeQuestion::At { place, .. } => Some(place),
            ProbeQuestion::Strongest => None,
        }
    }

    fn wanted_probe(&self) -> Option<ProbeRequest> {
        let Probe { question, near_sigma, in_view, .. } = self.document.probe;
        Some(ProbeRequest { traced: self.results.probed.traced.clone()?, question: question?, near_sigma, in_view })
    }

    pub fn probe_is_current(&self) -> bool {
        let wanted = self.wanted_probe();
        self.results.probed.answer.as_ref().zip(wanted).is_some_and(|(answer, wanted)| answer.request == wanted)
    }

    /// A question about a feature, or a sample on another grid, becomes one about the best candidate at its place.
    fn take_trail(&mut self, traced: Traced) {
        let slopes = |traced: &Traced| traced.cache.params().used_slopes();
        let same_grid = self.results.probed.traced.as_ref().is_some_and(|before| slopes(before) == slopes(&traced));
        if let (Some(ProbeQuestion::At { wanted, .. }), Some(_)) =
            (self.document.probe.question, &self.results.probed.traced)
        {
            self.look_at(match wanted {
                Subject::Candidate(sample) if same_grid => Subject::Candidate(sample),
                _ => Subject::Best,
            });
        }
        (self.results.probed.traced, self.results.probed.problem) = (Some(traced), None);
    }

    /// Takes an answer. The question for the strongest candidate then becomes one for its place.
    fn take_probe(&mut self, mut answer: Probed) {
        let is_asked = self.document.probe.question == Some(answer.request.question);
        if answer.request.question == ProbeQuestion::Strongest {
            let wanted = answer.probe.subject_fate().map_or(Subject::Best, |f| Subject::Candidate(f.of_sample()));
            answer.request.question = ProbeQuestion::At { place: answer.probe.pos_image, wanted };
            if is_asked {
                self.document.probe.question = Some(answer.request.question);
            }
        }
        (self.results.probed.answer, self.results.probed.problem) = (Some(answer), None);
    }

    pub fn look_at(&mut self, wanted: Subject) {
        if let Some(place) = self.probed_place() {
            self.document.probe.question = Some(ProbeQuestion::At { place, wanted });
        }
    }

    pub(super) fn take_probed_trail(&mut self, ended: Ended<DetectionSource>) {
        let open = self.burst_of(self.document.probe.side).map(|burst| burst.id);
        match ended.result {
            Ok(traced) if Some(traced.burst) == open => self.take_trail(traced),
            Ok(_) => {}
            Err(JobError::Cancelled) => {
                self.results.probed.problem = Some("Cancelled; probe the place again".to_owned());
            }
            Err(error) => self.results.probed.problem = Some(error.to_string()),
        }
    }

    pub(super) fn take_probed(&mut self, ended: Ended<ProbeRequest>) {
        let open = self.burst_of(self.document.probe.side).map(|burst| burst.id);
        match ended.result {
            Ok(probed) if Some(probed.request.traced.burst) == open => self.take_probe(probed),
            Ok(_) => {}
            Err(JobError::Cancelled) => self.results.probed.wanted_answer.forget(),
            Err(error) => self.results.probed.problem = Some(error.to_string()),
        }
    }

    pub(super) fn follow_pointer(&mut self) {
        if let Some((side, place)) = self.results.probed.pointer.filter(|_| self.document.probe.follows) {
            self.set_question(side, ProbeQuestion::At { place, wanted: Subject::Best });
        }
    }

    pub(super) fn probe_wants_features(&self, side: Side) -> bool {
        let (probe, slot) = (&self.document.probe, &self.results.slots[side]);
        probe.is_on() && probe.side == side && slot.found.is_none() && self.results.probed.problem.is_none()
    }

    /// A running detection comes first: it leaves its trail.
    pub(super) fn missing_trail(&self, dragging: bool) -> Option<DetectionSource> {
        let waits = dragging || self.results.slots[self.document.probe.side].detecting.is_pending();
        let is_asked = self.document.probe.is_on() && self.results.probed.problem.is_none();
        self.untraced().filter(|_| is_asked && !waits)
    }

    pub(super) fn missing_probe(&self) -> Option<ProbeRequest> {
        self.wanted_probe().filter(|_| !self.probe_is_current())
    }

    pub(in crate::app) fn follow_with_probe(&mut self) {
        let probe = &mut self.document.probe;
        probe.follows ^= true;
        if probe.follows {
            self.open_probe();
        }
    }

    /// A place outside the picture only gives a note.
    pub fn ask_probe(&mut self, side: Side, question: ProbeQuestion) {
        let Some((width, height)) = self.burst_of(side).map(|open| open.burst.size()) else { return };
        let inside = match question {
            ProbeQuestion::At { place: [u, v], .. } => {
                let last = |n: usize| n.saturating_sub(1) as f32;
                (-0.5..=last(width) + 0.5).contains(&u) && (-0.5..=last(height) + 0.5).contains(&v)
            }
            ProbeQuestion::Strongest => true,
        };
        if !inside {
            self.messages.note("That place lies outside the picture at mid-burst");
            return;
        }
        self.set_question(side, question);
        self.open_probe();
    }

    /// A question about a feature has its own scale and slope.
    fn set_question(&mut self, side: Side, question: ProbeQuestion) {
        self.turn_probe_to(side);
        self.document.probe.question = Some(question);
        let has_scale = matches!(question, ProbeQuestion::At { wanted: Subject::Feature(_), .. });
        self.document.probe.near_sigma = if has_scale { None } else { self.sigma_in_view() };
        self.document.probe.in_view = if has_scale { None } else { self.slope_in_view() };
    }

    /// Scale σ of the DoG that the pane of the probed burst shows, input pixels; `None` for other content.
    fn sigma_in_view(&self) -> Option<f32> {
        let (pane, params) = (self.probed_pane(), &self.results.slots[self.document.probe.side].usable_params);
        let space = ScaleSpace::of(params);
        pane.shows(ViewKind::Dog).then(|| space.sigma_image(pane.cursor.octave, f64::from(pane.cursor.level)) as f32)
    }

    /// The slope of the picture that the pane of the probed burst shows; `None` for other content.
    fn slope_in_view(&self) -> Option<Slope> {
        let pane = self.probed_pane();
        let is_of_slope = pane.shown().is_some_and(|kind| kind.about().of_slope);
        is_of_slope.then_some(pane.cursor.slope)
    }

    pub fn untraced(&self) -> Option<DetectionSource> {
        let side = self.document.probe.side;
        let (burst, found) = (self.burst_of(side)?, self.found_of(side)?);
        let is_of = |traced: &Traced| {
            traced.burst == burst.id && traced.cache.asked == found.asked && traced.cache.made_with() == found.params
        };
        if self.results.probed.traced.as_ref().is_some_and(is_of) { None } else { self.found_source(side) }
    }

    pub fn probe_place(&mut self, side: Side, place: [f32; 2]) {
        self.ask_probe(side, ProbeQuestion::At { place, wanted: Subject::Best });
    }

    pub fn probe_feature(&mut self, side: Side, index: usize) {
        let feature = self.found_of(side).and_then(|found| found.detection.features.get(index));
        if let Some(place) = feature.map(|feature| [feature.u, feature.v]) {
            if side == Side::A {
                self.document.selected = Some(index);
            }
            self.ask_probe(side, ProbeQuestion::At { place, wanted: Subject::Feature(index) });
        }
    }

    /// With its side: the selected one; of two bursts that of the match or the one asked about, on the side in focus.
    pub fn feature_to_probe(&self) -> Option<(Side, usize)> {
        if self.document.workspace != Workspace::Pair {
            return self.read().selected_feature().and(self.document.selected).map(|index| (Side::A, index));
        }
        let of_match =
            self.results.pair.matches.as_ref().zip(self.document.selected_match).and_then(|(matches, index)| {
                let found = matches.row(index)?.found;
                Some(match self.active_side() {
                    Side::A => (Side::A, found.a),
                    Side::B => (Side::B, found.b),
                })
            });
        of_match.or_else(|| Some((Side::A, self.asked_feature()?)))
    }

    pub fn probe_is_here(&self) -> bool {
        self.document.probe.side == Side::A || self.document.workspace == Workspace::Pair
    }

    pub fn probed_pane_id(&self) -> PaneId {
        let side = self.document.probe.side;
        if self.document.focused().side == side { self.document.focus() } else { self.document.pane_for(side) }
    }

    pub fn probed_pane(&self) -> &Pane {
        self.document
            .panes
            .get(self.probed_pane_id())
            .unwrap_or_else(|| self.document.panes.of(self.document.probe.side))
    }

    pub(in crate::app) fn clear_probe_of(&mut self, side: Side) {
        if self.document.probe.side == side {
            self.clear_probe();
        }
    }

    pub fn probe_is_stale(&self) -> bool {
        let asked = || self.asked_of(self.document.probe.side);
        self.results.probed.answer.as_ref().is_some_and(|answer| answer.request.traced.cache.asked != asked())
    }

    /// A sentence without a full stop: the price, or the time of the search; `None` for what cannot be made.
    pub fn price_text(&self, side: Side, change: &ParamChange) -> Option<String> {
        let answer =
            self.results.probed.answer.as_ref().filter(|_| self.document.probe.side == side && !self.probe_is_stale());
        let known = answer.and_then(|answer| answer.prices.iter().find(|(of, _)| of == change));
        if let Some((_, price)) = known {
            return Some(capitalised(&price.sentence()));
        }
        let (found, burst) = (self.found_of(side)?, self.burst_of(side)?);
        let changed = change.applied(&found.params).ok()?;
        let secs = found.search_secs * time_factor(&found.searched, &changed, burst.burst.size());
        Some(match secs {
            ..1.0 => "Takes a new search, less than a second".to_owned(),
            _ => format!("Takes a new search, about {secs:.0} s"),
        })
    }

    /// An example that was opened as A gets its own grid of slopes if none was given, and is probed at its place of
    /// interest if detections start automatically. The next burst, for which `before` is that example, drops the grid
    /// again.
    pub fn start_probe(&mut self, before: Option<&BurstSource>) {
        let grid = |example: Example| {
            let (range, count) = example.slopes_u();
            SlopeGrid::line(range, count)
        };
        self.clear_probe_of(Side::A);
        if let Some(BurstSource::Example(example)) = before
            && !self.document.slopes.is_auto()
            && self.document.params.slopes == grid(*example)
        {
            self.document.slopes = SlopeChoice::AUTO;
        }
        if let Some(OpenBurst { source: BurstSource::Example(example), .. }) = self.results.slots.a.burst {
            if self.document.slopes.is_auto() {
                (self.document.params.slopes, self.document.slopes) = (grid(example), SlopeChoice::Given);
            }
            let has_its_slopes = self.document.params.slopes == grid(example);
            if has_its_slopes {
                let pane = self.document.panes.of_mut(Side::A);
                (pane.cursor.slope, pane.slope_chosen) = (Slope::new(example.slope_u(), 0.0), true);
            }
            if self.document.auto_detect {
                let wanted = match example.scale() {
                    Some((octave, level)) if has_its_slopes && self.document.params.first_octave <= octave => {
                        let slope_index =
                            nearest_slope(&self.document.params.slopes, Slope::new(example.slope_u(), 0.0));
                        Subject::Scale { octave, level, slope_index }
                    }
                    _ => Subject::Best,
                };
                self.ask_probe(Side::A, ProbeQuestion::At { place: example.place(), wanted });
            }
        }
        self.check_params();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::results::tests::Bench;
    use crate::detector::NoiseGate;
    use crate::detector::params::doc;
    use crate::inspect::{ProbeOptions, probe};
    use crate::monitor::Monitor;

    fn answered(model: &Model) -> (Side, crate::requests::BurstId, [f32; 2]) {
        let answer = model.results.probed.answer.as_ref().filter(|_| model.probe_is_current()).expect("answered");
        (model.document.probe.side, answer.request.traced.burst, answer.probe.pos_image)
    }

    #[test]
    fn the_scale_of_the_dog_in_view_comes_first_and_another_one_can_be_chosen() {
        let mut bench = Bench::with_two_charts();
        let place = [50.0, 30.0];
        bench.model.probe_place(Side::A, place);
        assert_eq!(bench.model.document.probe.near_sigma, None, "a stack shows all scales");
        let pane = bench.model.document.panes.of_mut(Side::A);
        (pane.cursor.octave, pane.cursor.level) = (1, 2);
        pane.show(ViewKind::Dog);
        bench.model.probe_place(Side::A, place);
        bench.settle();
        let scales =
            |model: &Model| model.results.probed.answer.as_ref().expect("answered").probe.response.scales.clone();
        let shown = scales(&bench.model).into_iter().find(|s| (s.octave, s.level) == (1, 2)).expect("searched");
        assert_eq!(bench.model.document.probe.near_sigma, Some(shown.sigma));
        let finest = scales(&bench.model)[0].sigma;
        bench.model.document.probe.near_sigma = Some(finest);
        assert!(!bench.model.probe_is_current(), "another scale is another question");
        bench.settle();
        assert!(bench.model.probe_is_current());
        let pane = bench.model.document.panes.of_mut(Side::A);
        (pane.cursor.slope, pane.cursor.kind) = (Slope::new(0.25, 0.0), ViewKind::Stack);
        bench.model.probe_place(Side::A, place);
        assert_eq!(bench.model.document.probe.in_view, Some(Slope::new(0.25, 0.0)), "the slope in view comes first");
        bench.model.document.panes.of_mut(Side::A).show(ViewKind::Frame);
        bench.model.probe_place(Side::A, place);
        assert_eq!(bench.model.document.probe.in_view, None, "a frame has no slope");
        bench.model.probe_feature(Side::A, 0);
        let own = (bench.model.document.probe.near_sigma, bench.model.document.probe.in_view);
        assert_eq!(own, (None, None), "a feature has its own scale and slope");
    }

    #[test]
    fn the_price_of_a_change_is_what_it_gives_or_the_time_of_the_search_that_it_takes() {
        let mut bench = Bench::with_two_charts();
        bench.model.document.open_workspace(Workspace::Inspect);
        bench.settle();
        // The search left what a stricter gate rejects.
        bench.model.document.params.noise_gate = NoiseGate::Factor(300.0);
        bench.settle();
        bench.model.ask_probe(Side::A, ProbeQuestion::Strongest);
        bench.settle();
        let answer = bench.model.results.probed.answer.clone().expect("answered");
        let fate = answer.probe.subject_fate().expect("a candidate").clone();
        assert!(!fate.is_kept(), "the gate rejects all");
        let change = fate.remedy.as_ref().expect("it has one").change.clone();
        let [(of, price)] = &answer.prices[..] else { panic!("not counted: {:?}", answer.prices) };
        assert_eq!((of, price.now), (&change, bench.model.read().features().len()));
        assert!(price.own.is_some_and(|(now, then)| now == 0 && then > 0), "{price:?}");
        assert!(bench.model.price_text(Side::A, &change).is_some_and(|text| text.starts_with("Keeps this one, and ")));
        bench.model.apply_advice(Side::A, std::slice::from_ref(&change));
        bench.settle();
        assert_eq!(bench.model.read().features().len(), price.then);
        // Twice the slopes.
        bench.model.results.slots.a.found.as_mut().expect("found").detected.search_secs = 4.0;
        let slopes = bench.model.found_of(Side::A).expect("found").params.slopes.u;
        let twice = ParamChange::new(doc::SLOPES_U, slopes.with_more(0, slopes.count));
        let text = bench.model.price_text(Side::A, &twice);
        assert_eq!(text.as_deref(), Some("Takes a new search, about 8 s"));
        let wrong = ParamChange::new(doc::LEVELS, -1);
        assert_eq!(bench.model.price_text(Side::A, &wrong), None);
    }

    #[test]
    fn a_probe_stays_with_its_burst_and_ends_with_it() {
        let mut bench = Bench::with_two_charts();
        bench.model.probe_place(Side::B, [20.0, 40.0]);
        bench.settle();
        let (_, burst, place) = answered(&bench.model);
        bench.model.swap_sides();
        bench.settle();
        assert_eq!(answered(&bench.model), (Side::A, burst, place));
        bench.model.close_second(&bench.engine);
        bench.settle();
        assert_eq!(answered(&bench.model), (Side::A, burst, place), "another burst was closed");
        let mut bench = Bench::with_two_charts();
        bench.model.probe_place(Side::B, [20.0, 40.0]);
        bench.settle();
        bench.model.start_probe(None);
        assert_eq!(bench.model.probed_place(), Some([20.0, 40.0]), "another burst was opened as A");
        bench.model.close_second(&bench.engine);
        assert!(!bench.model.has_probe());
        bench.settle();
    }

    #[test]
    fn a_change_of_the_slopes_that_is_advised_for_b_begins_with_the_slopes_of_b() {
        let mut bench = Bench::with_two_charts();
        bench.model.document.slopes = SlopeChoice::AUTO;
        let own = SlopeGrid::line(-4.0..=4.0, 9);
        bench.model.results.slots.b.found.as_mut().expect("found").detected.params.slopes = own;
        let before = bench.model.document.params.clone();
        let change = |parameter, value: &str| ParamChange { parameter, value: value.to_owned() };
        bench.model.document.probe.side = Side::B;
        bench.model.apply_advice(Side::B, &[change(doc::EDGE_THRESHOLD, "7")]);
        assert_eq!(
            (bench.model.document.params.edge_threshold, bench.model.document.params.slopes),
            (7.0, before.slopes)
        );
        assert!(bench.model.document.slopes.is_auto(), "slopes were not touched");
        bench.model.apply_advice(Side::B, &[change(doc::SLOPE_DIRECTION, "90")]);
        let slopes = bench.model.document.params.slopes;
        assert_eq!((slopes.u.count, slopes.u.max, bench.model.document.slopes), (9, 4.0, SlopeChoice::Given));
    }

    #[test]
    fn each_burst_is_probed_where_it_lies_and_the_answer_is_that_of_its_own_search() {
        let mut bench = Bench::with_two_charts();
        let ids = Side::BOTH.map(|side| bench.model.burst_of(side).expect("open").id);
        for (side, place) in [(Side::B, [80.0, 30.0]), (Side::A, [110.0, 30.0]), (Side::B, [20.0, 40.0])] {
            bench.model.probe_place(side, place);
            assert!(bench.model.results.probed.answer.is_none(), "what was said of the other burst is not shown");
            bench.settle();
            assert_eq!(answered(&bench.model), (side, ids[side as usize], place));
            let model = &bench.model;
            let answer = model.results.probed.answer.as_ref().expect("there");
            let cache = &answer.request.traced.cache;
            assert_eq!(cache.detection().features, model.found_of(side).expect("found").detection.features);
            let options = ProbeOptions { in_view: answer.request.in_view, ..ProbeOptions::default() };
            let expected = probe(cache, place, &options, &Monitor::default()).expect("inside");
            assert_eq!(answer.probe.fates, expected.fates);
            assert!(model.untraced().is_none() && !model.probe_is_stale() && model.probe_is_here());
        }
        assert_eq!(Side::BOTH.map(|side| bench.model.burst_of(side).expect("open").id), ids, "nothing was swapped");
        // This place is inside of A only.
        bench.model.probe_place(Side::B, [110.0, 30.0]);
        assert_eq!((bench.model.document.probe.side, bench.model.probed_place()), (Side::B, Some([20.0, 40.0])));
        // In *One burst* only A is looked at, and B's probe waits.
        bench.model.document.open_workspace(Workspace::Inspect);
        assert!(!bench.model.probe_is_here() && bench.model.probe_is_current());
    }
}
