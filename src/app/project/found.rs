//! Features of a burst with the parameters that they were found with, and the selection across detections.

use crate::app::pane::PaneId;
use crate::app::project::Model;
use crate::app::project::pair::Side;
use crate::detector::{Advice, Detection, DetectorParams, Feature, SearchParams, Slope, SlopeFinding, explain};
use crate::inspect::spectrum::{features_at_slopes, slope_with_most_features};
use crate::requests::{Detected, DetectionSource, OpenBurst};
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use std::time::Duration;

/// Features of a burst, with the parameters that they were found with.
#[derive(Debug, Clone)]
pub struct FoundFeatures {
    /// The parameters that were requested.
    pub asked: SearchParams,
    /// The parameters that were used: with the slopes found, if slopes were to be found.
    pub params: DetectorParams,
    /// The search for slopes, if they were to be found.
    pub finding: Option<SlopeFinding>,
    /// The features, descriptors and the tally.
    pub detection: Arc<Detection>,
    /// Wall-clock time that the detection took.
    pub elapsed: Duration,
    /// Advice where there are few or no features, or most of them at the slope limit: the reason, and what to change.
    pub advice: Option<Advice>,
}

impl FoundFeatures {
    /// Combines the engine's answer for `burst`, after `elapsed`, with advice.
    pub fn new(detected: Detected, burst: &OpenBurst, elapsed: Duration) -> Self {
        let Detected { asked, params, finding, detection, .. } = detected;
        let advice = explain(&detection, &params, burst.burst.size());
        Self { asked, params, finding, detection, elapsed, advice }
    }
}

/// A selected feature, to be selected again after the next detection.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SavedSelection {
    /// Index of the feature when it was saved.
    pub index: usize,
    /// Column, input pixels.
    pub u: f32,
    /// Row, input pixels.
    pub v: f32,
    /// Scale σ, input pixels.
    pub sigma: f32,
    /// Slope, pixels per frame.
    pub slope: Slope,
}

/// Reason why the features on show are not those of the present parameters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stale {
    /// The parameters changed since the detection.
    Parameters,
    /// The present parameters are invalid.
    InvalidParameters,
}

impl Model {
    /// Takes the features, unless they are of another burst. The selection stays if the same feature was found again.
    pub fn take_detection(&mut self, side: Side, detected: Detected, elapsed: Duration) {
        let Some(burst) = self.burst_of(side).filter(|burst| burst.id == detected.burst) else { return };
        let found = FoundFeatures::new(detected, burst, elapsed);
        if side == Side::B {
            self.slots.b.found = Some(found);
            self.check_pair();
            self.go_to_first_slope(Side::B);
            return;
        }
        let keep = self.reselect.take().or_else(|| self.saved_selection());
        if self.slopes.is_auto() && found.asked.slopes == self.slopes {
            self.params.slopes = found.params.slopes;
            self.check_params();
        }
        self.slots.a.found = Some(found);
        self.explained.slopes_wanted = false;
        self.hovered = None;
        self.selected = keep.and_then(|saved| self.find_again(&saved));
        self.refresh_listed();
        self.go_to_first_slope(Side::A);
    }

    /// The detection from which the features of `side` come.
    pub fn found_source(&self, side: Side) -> Option<DetectionSource> {
        let (burst, found) = (self.burst_of(side)?.clone(), self.found_of(side)?);
        let FoundFeatures { asked, params, finding, .. } = found.clone();
        Some(DetectionSource { burst, asked, params, finding })
    }

    /// The features on show; none without a detection.
    pub fn features(&self) -> &[Feature] {
        self.slots.a.found.as_ref().map_or(&[], |f| &f.detection.features)
    }

    /// The selected feature.
    pub fn selected_feature(&self) -> Option<&Feature> {
        self.features().get(self.selected?)
    }

    /// Reason why the features on show are not those of the present parameters; `None` when they are.
    pub fn stale(&self) -> Option<Stale> {
        let found = self.slots.a.found.as_ref()?;
        if found.asked == self.asked() {
            None
        } else if self.slots.a.param_error.is_some() {
            Some(Stale::InvalidParameters)
        } else {
            Some(Stale::Parameters)
        }
    }

    /// The selection as a session stores it.
    pub fn saved_selection(&self) -> Option<SavedSelection> {
        let feature = self.selected_feature()?;
        let index = self.selected?;
        Some(SavedSelection { index, u: feature.u, v: feature.v, sigma: feature.sigma, slope: feature.slope })
    }

    /// Index of the feature nearest to `saved` in place, scale and slope, if it is near enough to be the same feature.
    fn find_again(&self, saved: &SavedSelection) -> Option<usize> {
        let distance = |f: &Feature| {
            let place = (f.u - saved.u).hypot(f.v - saved.v) / saved.sigma.max(0.5);
            let scale = (f.sigma / saved.sigma).log2().abs();
            let slope = (f.slope.u - saved.slope.u).hypot(f.slope.v - saved.slope.v);
            place + scale + slope
        };
        let features = self.features();
        let nearest = (0..features.len()).min_by(|&a, &b| {
            distance(&features[a])
                .total_cmp(&distance(&features[b]))
                .then(a.abs_diff(saved.index).cmp(&b.abs_diff(saved.index)))
        })?;
        (distance(&features[nearest]) < 1.0).then_some(nearest)
    }

    /// Moves the cursor to the slope with most features in the burst of `side`, unless a slope was chosen since that
    /// burst was opened.
    pub(crate) fn go_to_first_slope(&mut self, side: Side) {
        let (focus, own) = (self.panes.focus(), PaneId::of(side));
        let leader = if self.panes.get(focus).is_some_and(|pane| pane.side == side) { focus } else { own };
        // The burst's own pane, which other workspaces show, moves too if it is not on the screen.
        let alone = own != leader && !self.panes.shown().contains(&own);
        for id in [Some(leader), alone.then_some(own)].into_iter().flatten() {
            if self.panes.get(id).is_some_and(|pane| !pane.slope_chosen) {
                self.go_to_busiest_slope(id);
            }
        }
    }

    /// Moves the cursor of pane `id` to the slope of the grid with most features, and shows a note. Slopes on the
    /// grid's rim count only if there are features nowhere else. Does nothing without features.
    pub fn go_to_busiest_slope(&mut self, id: PaneId) {
        let Some(side) = self.panes.get(id).map(|pane| pane.side) else { return };
        let Some(found) = self.found_of(side) else { return };
        let grid = found.detection.slopes;
        if let Some((index, count)) = slope_with_most_features(&grid, &features_at_slopes(&found.detection)) {
            let slope = grid.slope(index);
            self.panes.get_mut(id).into_iter().for_each(|pane| pane.cursor.slope = slope);
            let Slope { u, v } = slope;
            self.messages.note(format!("Most features ({count}) are at slope ({u:.2}, {v:.2}) px/frame"));
        }
    }
}
