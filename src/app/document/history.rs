//! Undo and redo of the user's settings: the parameters of the detector and of matching, the calibration of the open
//! burst, pinned places, and the slopes of cursors.
//! Automatic changes (slopes that were found, the slope with most features) are no steps. A continued change (a drag,
//! typing, playing through the slopes) is one step.

use crate::app::document::{Document, PinnedPlace};
use crate::app::pane::{Pane, PaneId};
use crate::burst::OpenOptions;
use crate::detector::params::doc;
use crate::detector::{SearchParams, Slope};
use crate::matching::MatchParams;

const MAX_STEPS: usize = 200;

impl Document {
    fn given(&self) -> (&SearchParams, &MatchParams, &OpenOptions, &[PinnedPlace]) {
        (&self.params, &self.matching, &self.calibration, &self.places)
    }

    fn slopes_on_show(&self) -> Vec<(PaneId, Slope)> {
        self.panes.iter().map(|(id, pane)| (id, pane.cursor.slope)).collect()
    }

    /// Takes the settings that undo covers but the calibration, which opens the burst again, and is returned.
    fn take_settings(&mut self, from: Self) -> OpenOptions {
        for (id, pane) in from.panes.iter() {
            self.panes.get_mut(id).into_iter().for_each(|own| own.cursor.slope = pane.cursor.slope);
        }
        (self.params, self.matching, self.places) = (from.params, from.matching, from.places);
        from.calibration
    }

    pub(in crate::app) fn changed_from(&self, before: &Self) -> String {
        let (now, was) = (self.given(), before.given());
        let ranges = [doc::SLOPES_U, doc::SLOPES_V, doc::SLOPE_DIRECTION];
        // Slopes that were found have no ranges before.
        let is_switched = now.0.slopes.is_auto() != was.0.slopes.is_auto();
        let records = doc::ALL.into_iter().filter(|record| !(is_switched && ranges.contains(record)));
        let changed = records.filter(|record| record.text(now.0) != record.text(was.0));
        let mut names: Vec<&str> = changed.map(|record| record.label).collect();
        let timeless = |options: &OpenOptions| OpenOptions { times: None, ..options.clone() };
        let others = [
            (now.1 != was.1, "Matching"),
            (now.3 != was.3, "Places"),
            (now.2.times != was.2.times, "Times"),
            (timeless(now.2) != timeless(was.2), "Calibration"),
            (self.slopes_on_show() != before.slopes_on_show(), "Slope on show"),
        ];
        names.extend(others.into_iter().filter(|(differ, _)| *differ).map(|(_, name)| name));
        names.dedup();
        names.join(", ")
    }

    /// Whether the change from `before` is a step to undo. Opening or closing panes is none.
    fn is_step_from(&self, before: &Self) -> bool {
        let has_moved =
            |(id, pane): (PaneId, &Pane)| self.panes.get(id).is_some_and(|now| now.cursor.slope != pane.cursor.slope);
        before.panes.iter().any(has_moved) || self.given() != before.given()
    }
}

/// Documents before the steps that can be undone, and after those that were.
#[derive(Debug, Default)]
pub struct History {
    past: Vec<Document>,
    future: Vec<Document>,
    begun: Option<Document>,
}

impl History {
    /// Takes a change. It belongs to the step that is open, or opens one.
    pub fn take(&mut self, before: Document, after: &Document) {
        if after.is_step_from(&before) {
            self.begun.get_or_insert(before);
        }
    }

    /// Ends an open step, unless `goes_on`: its change may continue in the next pass. Records it if anything changed.
    pub fn close_step(&mut self, now: &Document, goes_on: bool) {
        let ends = !goes_on && !now.playing;
        if let Some(begun) = self.begun.take_if(|_| ends).filter(|begun| now.is_step_from(begun)) {
            self.past.push(begun);
            self.future.clear();
            if self.past.len() > MAX_STEPS {
                self.past.remove(0);
            }
        }
    }

    pub fn can_undo(&self) -> bool {
        !self.past.is_empty()
    }

    pub fn can_redo(&self) -> bool {
        !self.future.is_empty()
    }

    /// Takes a step back; returns the calibration before it.
    pub fn undo(&mut self, document: &mut Document) -> Option<OpenOptions> {
        let before = self.past.pop()?;
        self.future.push(document.clone());
        Some(document.take_settings(before))
    }

    /// Takes a step again; returns the calibration after it.
    pub fn redo(&mut self, document: &mut Document) -> Option<OpenOptions> {
        let after = self.future.pop()?;
        self.past.push(document.clone());
        Some(document.take_settings(after))
    }

    pub fn swap_sides(&mut self) {
        let steps = self.past.iter_mut().chain(&mut self.future).chain(&mut self.begun);
        steps.for_each(|document| document.panes.swap_sides());
    }
}
