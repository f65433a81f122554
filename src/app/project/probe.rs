//! The probe of the window: the probed place, the trail from which answers come, and the answer.

use crate::app::project::Model;
use crate::app::project::pair::Side;
use crate::detector::params::doc;
use crate::detector::{ParamChange, Slope, SlopeChoice, SlopeGrid};
use crate::engine::{Engine, Wanted};
use crate::inspect::probe::Wanted as Subject;
use crate::inspect::remedy::nearest_slope;
use crate::requests::{
    BurstSource, DetectionSource, JobError, OpenBurst, ProbeQuestion, ProbeRequest, Probed, Request, Traced,
};
use crate::synth::Example;
use serde::{Deserialize, Serialize};

/// The probe as a session file stores it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SavedProbe {
    /// The place, pixels at mid-burst.
    pub place: [f32; 2],
    /// Whether the panel showed it.
    #[serde(default)]
    pub is_open: bool,
}

/// The probed place, its request, and the answer.
#[derive(Debug, Default)]
pub struct ProbeModel {
    /// Whether the panel on the right shows the probe.
    pub is_open: bool,
    /// Whether the place follows the pointer.
    pub follows: bool,
    /// The question; `None` while nothing is probed.
    pub question: Option<ProbeQuestion>,
    /// The trail from which answers come.
    pub traced: Option<Traced>,
    /// The last answer.
    pub answer: Option<Probed>,
    /// Why there is no answer.
    pub problem: Option<String>,
    /// The place under the pointer, pixels at mid-burst, as of the last pass.
    pub pointer: Option<[f32; 2]>,
    /// The request for the trail.
    pub wanted_trail: Wanted<DetectionSource>,
    /// The request for the answer.
    pub wanted_answer: Wanted<ProbeRequest>,
}

impl ProbeModel {
    /// Whether a place is probed, or follows the pointer.
    pub fn is_on(&self) -> bool {
        self.follows || self.question.is_some()
    }

    /// Whether there is something for the panel to show.
    pub fn is_in_use(&self) -> bool {
        self.is_open || self.is_on() || self.answer.is_some()
    }

    /// Forgets everything, and closes the panel.
    pub fn clear(&mut self) {
        *self = Self::default();
    }

    /// The place that is probed, pixels at mid-burst: that of the question, or of the answer while that is not known.
    pub fn place(&self) -> Option<[f32; 2]> {
        match self.question? {
            ProbeQuestion::At { place, wanted: Subject::Feature(_) } => Some(match &self.answer {
                Some(answer) if self.is_current() => answer.probe.pos_image,
                _ => place,
            }),
            ProbeQuestion::At { place, .. } => Some(place),
            ProbeQuestion::Strongest => None,
        }
    }

    /// Request for the question about the present trail; `None` without either.
    pub fn wanted(&self) -> Option<ProbeRequest> {
        Some(ProbeRequest { traced: self.traced.clone()?, question: self.question? })
    }

    /// The probe for a session file; `None` while no place is known.
    pub fn saved(&self) -> Option<SavedProbe> {
        Some(SavedProbe { place: self.place()?, is_open: self.is_open })
    }

    /// Whether the answer is that to the present question.
    pub fn is_current(&self) -> bool {
        let wanted = self.wanted();
        self.answer.as_ref().zip(wanted).is_some_and(|(answer, wanted)| answer.request.is_same(&wanted))
    }

    /// Takes a trail. A question about a feature, or about a sample on another grid of slopes, becomes one about the
    /// best candidate at its place.
    pub fn take_trail(&mut self, traced: Traced) {
        let slopes = |traced: &Traced| traced.cache.params().used_slopes();
        let same_grid = self.traced.as_ref().is_some_and(|before| slopes(before) == slopes(&traced));
        let place = self.place();
        if let (Some(ProbeQuestion::At { wanted, .. }), Some(_), Some(place)) = (self.question, &self.traced, place) {
            let wanted = match wanted {
                Subject::Candidate(sample) if same_grid => Subject::Candidate(sample),
                _ => Subject::Best,
            };
            self.question = Some(ProbeQuestion::At { place, wanted });
        }
        (self.traced, self.problem) = (Some(traced), None);
    }

    /// Takes an answer. The question for the strongest candidate then becomes one for its place.
    pub fn take_answer(&mut self, mut answer: Probed) {
        let is_asked = self.question == Some(answer.request.question);
        if answer.request.question == ProbeQuestion::Strongest {
            let wanted = answer.probe.subject_fate().map_or(Subject::Best, |f| Subject::Candidate(f.of_sample()));
            answer.request.question = ProbeQuestion::At { place: answer.probe.pos_image, wanted };
            if is_asked {
                self.question = Some(answer.request.question);
            }
        }
        (self.answer, self.problem) = (Some(answer), None);
    }

    /// Asks about another subject at the same place.
    pub fn look_at(&mut self, wanted: Subject) {
        if let Some(place) = self.place() {
            self.question = Some(ProbeQuestion::At { place, wanted });
        }
    }
}

impl Model {
    /// Takes the trail and the answer, or the reason why there is none.
    pub(in crate::app) fn take_probed(&mut self) {
        let open = self.slots.a.burst.as_ref().map(|burst| burst.id);
        for ended in self.probe.wanted_trail.take() {
            match ended.result {
                Ok(traced) if Some(traced.burst) == open => self.probe.take_trail(traced),
                Ok(_) => {}
                Err(JobError::Cancelled) => {
                    self.probe.problem = Some("Cancelled; probe the place again".to_owned());
                }
                Err(error) => self.probe.problem = Some(error.to_string()),
            }
        }
        for ended in self.probe.wanted_answer.take() {
            match ended.result {
                Ok(probed) if Some(probed.request.traced.burst) == open => self.probe.take_answer(probed),
                Ok(_) => {}
                Err(JobError::Cancelled) => self.probe.wanted_answer.forget(),
                Err(error) => self.probe.problem = Some(error.to_string()),
            }
        }
    }

    /// Requests the trail and the answer that are missing. A running detection comes first: it leaves its trail.
    pub(in crate::app) fn ask_for_probed(&mut self, engine: &Engine, dragging: bool) {
        let probe = &mut self.probe;
        if let Some(place) = probe.pointer.filter(|_| probe.follows) {
            probe.question = Some(ProbeQuestion::At { place, wanted: Subject::Best });
        }
        if !probe.is_on() {
            return;
        }
        if !dragging && !self.slots.a.detecting.is_pending() && self.probe.problem.is_none() {
            match self.untraced() {
                Some(source) => self.probe.wanted_trail.want(engine, Some(source)),
                None if self.slots.a.found.is_none() && self.wants_detection(Side::A) => {
                    self.start_detection(Side::A, engine);
                }
                None => {}
            }
        }
        let missing = self.probe.wanted().filter(|_| !self.probe.is_current());
        if missing.is_some() {
            self.probe.wanted_answer.want(engine, missing);
        }
    }

    /// Switches whether the probe follows the pointer.
    pub(in crate::app) fn follow_with_probe(&mut self) {
        let probe = &mut self.probe;
        probe.follows ^= true;
        if probe.follows {
            (probe.is_open, probe.problem, self.panels.right) = (true, None, true);
        }
    }

    /// Whether the question is answered or cannot be answered, or there is none.
    pub(in crate::app) fn probe_is_settled(&self) -> bool {
        let (probe, a) = (&self.probe, &self.slots.a);
        let can = a.burst.is_some() && (a.found.is_some() || self.wants_detection(Side::A));
        !probe.is_on() || !can || probe.question.is_none() || probe.problem.is_some() || probe.is_current()
    }

    /// Asks a question, and shows the panel with the answer. A place outside the picture only gives a note.
    pub fn ask_probe(&mut self, question: ProbeQuestion) {
        let inside = match question {
            ProbeQuestion::At { place: [u, v], .. } => {
                let (width, height) = self.size();
                let last = |n: usize| n.saturating_sub(1) as f32;
                (-0.5..=last(width) + 0.5).contains(&u) && (-0.5..=last(height) + 0.5).contains(&v)
            }
            ProbeQuestion::Strongest => true,
        };
        if !inside {
            self.messages.note("That place lies outside the picture at mid-burst");
            return;
        }
        self.probe.question = Some(question);
        (self.probe.is_open, self.probe.problem, self.panels.right) = (true, None, true);
    }

    /// The detection on show, if the present trail is not of it.
    pub fn untraced(&self) -> Option<DetectionSource> {
        let (burst, found) = (self.slots.a.burst.as_ref()?, self.slots.a.found.as_ref()?);
        let is_of = |traced: &Traced| {
            traced.burst == burst.id && traced.cache.asked == found.asked && traced.cache.made_with() == found.params
        };
        if self.probe.traced.as_ref().is_some_and(is_of) { None } else { self.found_source(Side::A) }
    }

    /// Asks about a place, pixels at mid-burst.
    pub fn probe_place(&mut self, place: [f32; 2]) {
        self.ask_probe(ProbeQuestion::At { place, wanted: Subject::Best });
    }

    /// Asks about a feature.
    pub fn probe_feature(&mut self, index: usize) {
        if let Some(feature) = self.features().get(index) {
            let place = [feature.u, feature.v];
            self.selected = Some(index);
            self.ask_probe(ProbeQuestion::At { place, wanted: Subject::Feature(index) });
        }
    }

    /// Restores the probe of a session; without one nothing is probed.
    pub fn restore_probe(&mut self, saved: Option<SavedProbe>) {
        self.probe.clear();
        self.probe.is_open = saved.is_some_and(|saved| saved.is_open);
        if let Some(SavedProbe { place, is_open }) = saved {
            let right = self.panels.right;
            self.probe_place(place);
            (self.probe.is_open, self.panels.right) = (is_open, right);
        }
    }

    /// Whether the answer was made with other parameters than the present ones.
    pub fn probe_is_stale(&self) -> bool {
        self.probe.answer.as_ref().is_some_and(|answer| answer.request.traced.cache.asked != self.asked())
    }

    /// Changes a parameter, as its row in the panel does; a message gives the change or the error.
    pub fn apply_change(&mut self, change: &ParamChange) {
        match change.applied(&self.params) {
            Ok(params) => {
                let slopes = [doc::SLOPES_U, doc::SLOPES_V, doc::SLOPE_DIRECTION];
                if slopes.iter().any(|doc| doc.name == change.parameter.name) {
                    self.slopes = SlopeChoice::Given;
                }
                self.params = params;
                self.messages.note(format!("Set {}", change.label()));
            }
            Err(error) => self.messages.error("Apply", error.to_string()),
        }
    }

    /// Prepares the probe for a newly opened burst; `before` is the earlier one. An example gets its own grid of slopes
    /// if none was given, and is probed at its place of interest if detections start automatically. The next burst
    /// drops that grid again.
    pub fn start_probe(&mut self, before: Option<&BurstSource>) {
        let grid = |example: Example| {
            let (range, count) = example.slopes_u();
            SlopeGrid::line(range, count)
        };
        self.probe.clear();
        if let Some(BurstSource::Example(example)) = before
            && !self.slopes.is_auto()
            && self.params.slopes == grid(*example)
        {
            self.slopes = SlopeChoice::AUTO;
        }
        if let Some(OpenBurst { source: BurstSource::Example(example), .. }) = self.slots.a.burst {
            if self.slopes.is_auto() {
                (self.params.slopes, self.slopes) = (grid(example), SlopeChoice::Given);
            }
            let has_its_slopes = self.params.slopes == grid(example);
            if has_its_slopes {
                let pane = self.panes.of_mut(Side::A);
                (pane.cursor.slope, pane.slope_chosen) = (Slope::new(example.slope_u(), 0.0), true);
            }
            if self.auto_detect {
                let wanted = match example.scale() {
                    Some((octave, level)) if has_its_slopes && self.params.first_octave <= octave => {
                        let slope_index = nearest_slope(&self.params.slopes, Slope::new(example.slope_u(), 0.0));
                        Subject::Scale { octave, level, slope_index }
                    }
                    _ => Subject::Best,
                };
                self.ask_probe(ProbeQuestion::At { place: example.place(), wanted });
            }
        }
        self.check_params();
    }
}
