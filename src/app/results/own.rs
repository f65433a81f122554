//! What is set for one burst and is not that of the next: its mask, times, views and part, its slopes and frames used, and
//! the filter of its features. Another burst begins without them, and the line that says so offers them to it.

use crate::app::document::filter::Filter;
use crate::app::document::side::Side;
use crate::app::results::{Effect, Model};
use crate::burst::OpenOptions;
use crate::detector::{FrameRange, SlopeChoice, SlopeGrid};
use crate::engine::Engine;
use crate::requests::{BurstSource, JobId, OpenRequest};

#[derive(Debug, Clone, PartialEq)]
pub struct Own {
    /// Name of the burst that it was set for.
    pub of: String,
    /// Side of the burst that began without it.
    pub side: Side,
    calibration: OpenOptions,
    frames: Option<FrameRange>,
    /// `None` for slopes that are found.
    slopes: Option<(SlopeChoice, SlopeGrid)>,
    filter: Filter,
}

impl Own {
    /// Words for what was set.
    fn words(&self) -> Vec<&'static str> {
        let OpenOptions { mask, take, times, views, axis, array, topic, .. } = &self.calibration;
        let words = [
            (mask.is_some(), "mask"),
            (take.is_some(), "part taken"),
            (times.is_some(), "times"),
            (views.is_some(), "views"),
            (axis.is_some(), "axis"),
            (array.is_some(), "array"),
            (topic.is_some(), "topic"),
            (self.frames.is_some(), "frames used"),
            (self.slopes.is_some(), "slopes"),
            (!self.filter.is_open(), "filter"),
        ];
        words.into_iter().filter(|(is_set, _)| *is_set).map(|(_, word)| word).collect()
    }

    /// Sentence that says what is not used, and the words of the button that uses it.
    pub fn offer(&self) -> (String, &'static str) {
        let words = self.words();
        let in_b = if self.side == Side::B { "in B" } else { "here" };
        let (is, use_it) = match words[..] {
            ["mask" | "part taken" | "axis" | "array" | "topic" | "filter"] => ("is", "Use it"),
            _ => ("are", "Use them"),
        };
        let listed = match &words[..] {
            [before @ .., last] if !before.is_empty() => format!("{} and {last}", before.join(", ")),
            words => words.join(""),
        };
        (format!("The {listed} of {} {is} not used {in_b}.", self.of), use_it)
    }
}

/// The burst that a dark copy or one with things planted is made of.
fn origin(source: &BurstSource) -> BurstSource {
    match source {
        BurstSource::DarkCopy { of, .. } | BurstSource::Planted { of, .. } => origin(of),
        source => source.absolute(),
    }
}

impl Model {
    /// Options with which the burst of a side was opened.
    pub fn calibration_of(&self, side: Side) -> &OpenOptions {
        let of_b = self.document.calibration_of_b.as_ref().filter(|_| side == Side::B);
        of_b.unwrap_or(&self.document.calibration)
    }

    /// Whether what is set for one burst holds for the other: copies of one burst, and those of the open dataset.
    fn are_one(&self, a: &BurstSource, b: &BurstSource) -> bool {
        let in_dataset = |source| self.results.datasets.open.as_ref().is_some_and(|dataset| dataset.has(source));
        origin(a) == origin(b) || in_dataset(a) && in_dataset(b)
    }

    /// Burst whose settings a side has: the open one, the one that is being opened, or the one that could not be.
    fn settings_are_of(&self, side: Side) -> Option<&BurstSource> {
        let slot = &self.results.slots[side];
        let open = slot.burst.as_ref().map(|open| &open.source);
        let of_side = open.or_else(|| slot.opening.pending().map(|request| &request.source));
        match side {
            Side::A => of_side.or(slot.refused.as_ref()),
            // B begins with the settings of A, unless both are opened together.
            Side::B => of_side.or_else(|| self.results.slots.a.burst.as_ref().map(|open| &open.source)),
        }
    }

    fn own(&self, of: &BurstSource, side: Side) -> Own {
        let slopes = (self.document.slopes, self.document.params.slopes);
        let is_of_example =
            |example: crate::synth::Example| SlopeGrid::line(example.slopes_u().0, example.slopes_u().1) == slopes.1;
        let is_usual =
            slopes.0 == SlopeChoice::AUTO || matches!(of, BurstSource::Example(example) if is_of_example(*example));
        let own = Own {
            of: of.label(),
            side,
            calibration: OpenOptions::default().with_burst_of(self.calibration_of(side)),
            frames: self.document.params.frames,
            slopes: (!is_usual).then_some(slopes),
            filter: self.document.filter.clone(),
        };
        match side {
            Side::A => own,
            // The search is that of A.
            Side::B => Own { frames: None, slopes: None, filter: Filter::default(), ..own },
        }
    }

    /// Opens a burst. One that is another than that of the side leaves what was set for that behind, once it is open.
    pub(in crate::app) fn open(&mut self, side: Side, source: BurstSource, engine: &Engine) -> JobId {
        let slot = &self.results.slots[side];
        let is_open = slot.burst.as_ref().is_some_and(|open| self.are_one(&open.source, &source));
        let pending = slot.opening.pending().filter(|request| !is_open || self.are_one(&request.source, &source));
        let options = pending.map_or_else(|| self.calibration_of(side).clone(), |request| request.options.clone());
        let before = self.settings_are_of(side).filter(|before| !is_open && !self.are_one(before, &source)).cloned();
        let own = before.map(|before| self.own(&before, side));
        let options = match self.results.datasets.open.as_ref().filter(|dataset| dataset.has(&source)) {
            Some(dataset) => dataset.open.clone(),
            None if own.is_some() => options.with_burst_of(&OpenOptions::default()),
            None => options,
        };
        self.open_with(side, OpenRequest { source, options }, own, engine)
    }

    /// Opens the burst of a session, of a lesson or with other options, which leaves nothing behind unless it is given.
    pub(in crate::app) fn open_with(
        &mut self,
        side: Side,
        request: OpenRequest,
        leaves: Option<Own>,
        engine: &Engine,
    ) -> JobId {
        self.results.slots[side].leaves = leaves;
        self.results.slots[side].opening.ask(engine, request)
    }

    /// Options of a dataset that is opened beside, or in place of, what is open.
    pub(in crate::app) fn options_of_new_dataset(&self) -> OpenOptions {
        let calibration = self.document.calibration.clone();
        match self.settings_are_of(Side::A) {
            Some(_) => calibration.with_burst_of(&OpenOptions::default()),
            None => calibration,
        }
    }

    /// Takes what was set for the burst before off the one that is open now. What was set since it was asked for stays.
    pub(super) fn leave_behind(&mut self, side: Side) {
        let Some(own) = self.results.slots[side].leaves.take() else { return };
        let now = self.own(&BurstSource::Demo, side);
        if own.frames.is_some() && own.frames == now.frames {
            self.document.params.frames = None;
        }
        if own.slopes.is_some() && own.slopes == now.slopes {
            self.document.slopes = SlopeChoice::AUTO;
        }
        if !own.filter.is_open() && own.filter == now.filter {
            self.document.filter = Filter::default();
        }
        self.results.left_behind = Some(own).filter(|own| !own.words().is_empty());
    }

    /// Uses what the burst before left behind, or drops it.
    pub(in crate::app) fn take_left_behind(&mut self, uses: bool, engine: &Engine) {
        let Some(own) = self.results.left_behind.take().filter(|_| uses) else { return };
        let Own { side, calibration, frames, slopes, filter, .. } = own;
        if side == Side::A {
            (self.document.params.frames, self.document.filter) = (frames.or(self.document.params.frames), filter);
            if let Some((choice, grid)) = slopes {
                (self.document.slopes, self.document.params.slopes) = (choice, grid);
            }
        }
        let options = self.calibration_of(side).clone().with_burst_of(&calibration);
        let source = self.burst_of(side).map(|open| open.source.clone());
        if let Some(source) = source.filter(|_| options != *self.calibration_of(side)) {
            self.open_with(side, OpenRequest { source, options }, None, engine);
        }
    }

    /// Opens what is open again with other options; those that are refused change nothing.
    pub(in crate::app) fn calibrate(&mut self, options: OpenOptions, engine: &Engine) -> Effect {
        let burst_of = |options: &OpenOptions| OpenOptions::default().with_burst_of(options);
        let is_of_a = burst_of(&options) == burst_of(&self.document.calibration);
        let of_b = match &self.document.calibration_of_b {
            Some(of_b) if is_of_a => options.clone().with_burst_of(of_b),
            _ => options.clone(),
        };
        for (side, options) in [(Side::A, options), (Side::B, of_b)] {
            let slot = &mut self.results.slots[side];
            let pending = slot.opening.pending().map(|request| request.source.clone());
            match pending.or_else(|| slot.burst.as_ref().map(|open| open.source.clone())) {
                Some(source) => {
                    let leaves = slot.leaves.take();
                    self.open_with(side, OpenRequest { source, options }, leaves, engine);
                }
                // No frames refuse them.
                None if side == Side::A => {
                    self.document.calibration = options;
                    self.look_at_dataset_again(engine);
                }
                None => {}
            }
        }
        Effect::ForgetThumbnails
    }
}
