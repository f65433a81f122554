//! What the window does for the probe: takes trails and answers, and asks for what is missing.

use crate::app::window::BurstscopeApp;
use crate::requests::{DetectionSource, JobError, ProbeRequest};

/// What was asked for and has not come, or could not be had.
#[derive(Default)]
pub(in crate::app) struct ProbeAsked {
    /// The detection that is repeated because what it left behind was not kept.
    trail: Option<DetectionSource>,
    place: Option<ProbeRequest>,
}

impl BurstscopeApp {
    /// Takes what the probe's workers published. Comes after the detections, so that what a detection left behind is
    /// there as soon as its features are.
    pub(in crate::app) fn take_probe_updates(&mut self) {
        if self.model.probe.is_on()
            && let Some(source) = self.model.untraced()
            && let Some(traced) = self.engine.probe().kept(&source)
        {
            self.model.probe.take_trail(traced);
        }
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
                Some(crate::requests::ProbeQuestion::At { place, wanted: crate::inspect::probe::Wanted::Best });
        }
        if !probe.is_on() {
            return;
        }
        // What is being detected comes first, with all it leaves behind.
        if !dragging && self.asked.detecting.is_none() && self.model.probe.problem.is_none() {
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

    /// Has the detection repeated of which nothing is left, or made if there is none.
    fn request_trail(&mut self) {
        if let Some(source) = self.model.untraced() {
            if !self.asked.probe.trail.as_ref().is_some_and(|asked| asked.is_same(&source)) {
                self.engine.probe().trace(source.clone());
                self.asked.probe.trail = Some(source);
            }
        } else if self.model.found.is_none() && self.model.param_error.is_none() && self.wants_detection() {
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
