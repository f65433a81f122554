//! What the window does for the probe: takes trails and answers, and asks for what is missing.

use crate::app::window::BurstscopeApp;
use crate::detector::SearchParams;
use crate::engine::{BurstId, DetectRequest, JobError, ProbeRequest};

/// What was asked for and has not come, or could not be had.
#[derive(Default)]
pub(in crate::app) struct ProbeAsked {
    /// Whether the detection that runs keeps its trail.
    pub keeps_trail: bool,
    /// The detection that is repeated for its trail.
    trail: Option<(BurstId, SearchParams)>,
    place: Option<ProbeRequest>,
}

impl BurstscopeApp {
    /// Takes what the probe's workers published. Comes after the detections, so that a detection's trail is there as
    /// soon as its features are.
    pub(in crate::app) fn take_probe_updates(&mut self) {
        let open = self.model.burst.as_ref().map(|burst| burst.id);
        match self.engine.probe().poll_trail() {
            Some(Ok(traced)) if Some(traced.burst) == open => self.model.probe.take_trail(traced),
            Some(Err(error)) => {
                self.asked.probe.trail = None;
                self.model.probe.problem = Some(match error {
                    JobError::Cancelled => "It was cancelled; probe again to begin anew".to_owned(),
                    error => error.to_string(),
                });
            }
            _ => {}
        }
        if let Some(answer) = self.engine.probe().poll_answer() {
            match answer.result {
                Ok(probed) if Some(probed.request.traced.burst) == open => self.model.probe.take_answer(probed),
                Ok(_) => {}
                Err(JobError::Cancelled) => self.asked.probe.place = None,
                Err(error) => self.model.probe.problem = Some(error.to_string()),
            }
        }
        self.model.probe.tracing = self.engine.probe().tracing();
    }

    /// Probes the place under the pointer, or else the middle of what the pane in focus shows.
    pub(in crate::app) fn probe_here(&mut self) {
        let middle = || {
            let visible = self.widgets.get(self.model.focus())?.picture.visible_image?.center();
            let (width, height) = self.model.size();
            let within = |x: f32, n: usize| x.clamp(0.0, n.saturating_sub(1) as f32);
            Some([within(visible.x, width), within(visible.y, height)])
        };
        if let Some(place) = self.model.probe.pointer.or_else(middle) {
            self.model.probe.follows = false;
            self.model.probe_place(place);
        }
    }

    /// Lets the probe follow the pointer, or stay where it is.
    pub(in crate::app) fn follow_with_probe(&mut self) {
        let probe = &mut self.model.probe;
        probe.follows ^= true;
        if probe.follows {
            (probe.is_open, probe.problem, self.model.panels.right) = (true, None, true);
        }
    }

    /// Forgets what was probed in the burst that was open.
    pub(in crate::app) fn forget_probe(&mut self) {
        self.engine.probe().cancel();
        self.asked.probe = ProbeAsked::default();
    }

    /// Asks for the trail and the answer that are wanted and not there. `dragging` says whether the pointer still drags
    /// something.
    pub(in crate::app) fn request_for_probe(&mut self, dragging: bool) {
        let probe = &mut self.model.probe;
        if probe.follows
            && let Some(place) = probe.pointer
        {
            probe.question =
                Some(crate::engine::ProbeQuestion::At { place, wanted: crate::inspect::probe::Wanted::Best });
        }
        if !probe.is_on() {
            return;
        }
        if self.wants_trail() && !dragging && self.model.probe.problem.is_none() {
            self.request_trail();
        }
        if let Some(wanted) = self.model.probe.wanted()
            && !self.model.probe.is_current()
            && !self.asked.probe.place.as_ref().is_some_and(|asked| asked.same_answer(&wanted))
        {
            self.engine.probe().ask(wanted.clone());
            self.asked.probe.place = Some(wanted);
        }
    }

    /// Whether the trail of the features on show is missing.
    fn wants_trail(&self) -> bool {
        let Some(burst) = &self.model.burst else { return false };
        let found = self.model.found.as_ref().map(|found| &found.asked);
        let traced = self.model.probe.traced.as_ref();
        found.is_none() || traced.is_none_or(|t| t.burst != burst.id || Some(&t.cache.asked) != found)
    }

    fn request_trail(&mut self) {
        let Some(burst) = self.model.burst.clone() else { return };
        if let Some(asked) = &self.asked.detecting {
            // One that has just begun begins again, rather than that all of it is done twice.
            if !self.asked.probe.keeps_trail && *asked == self.model.asked() {
                self.start_detection();
            }
        } else if let Some(found) = &self.model.found {
            let wanted = (burst.id, found.asked.clone());
            if self.asked.probe.trail.as_ref() != Some(&wanted) {
                self.engine.probe().trace(DetectRequest { burst, params: wanted.1.clone() });
                self.asked.probe.trail = Some(wanted);
            }
        } else if self.model.param_error.is_none() && self.wants_detection() {
            self.start_detection();
        }
    }

    /// Whether everything that the probe wants is there, or it is known why not.
    pub(in crate::app) fn probe_is_settled(&self) -> bool {
        let probe = &self.model.probe;
        let can = self.model.burst.is_some() && (self.model.found.is_some() || self.wants_detection());
        !probe.is_on() || !can || probe.question.is_none() || probe.problem.is_some() || probe.is_current()
    }
}
