//! What the window shows, as plain values: the burst, the parameters, where the hand is, the picture, the features, the messages.
//!
//! The [`Model`] draws nothing and starts nothing. Panels read and change it; after each pass the window compares what is wanted with
//! what is there and asks the engine for the difference.

pub mod compare;
pub mod filter;
pub mod look;
pub mod messages;
pub mod order;
pub mod pair;
pub mod room;
pub mod scrub;

use super::canvas::overlay::ColourBy;
use super::dataset::{Datasets, Trajectories};
use crate::detector::{
    Advice, Detection, DetectorParams, Feature, ParamError, SearchParams, Slope, SlopeChoice, SlopeFinding, SlopeGrid,
    explain,
};
use crate::engine::{BurstId, Detected, OpenBurst, Picture, PictureKind, PictureRequest, Running};
use compare::Compare;
use filter::{Column, Filter};
use look::Look;
use messages::Messages;
use order::Order;
use pair::Pair;
use room::Room;
use scrub::{Scrub, ViewKind};
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use std::time::Duration;

/// Features of the open burst, with what they were made from.
#[derive(Debug, Clone)]
pub struct Found {
    /// What was asked for.
    pub asked: SearchParams,
    /// The parameters they were made with: where slopes were to be found, with those that were.
    pub params: DetectorParams,
    /// What was found of the slopes, if they were to be found.
    pub finding: Option<SlopeFinding>,
    /// The features, descriptors and the tally.
    pub detection: Arc<Detection>,
    /// How long it took, by the wall clock.
    pub elapsed: Duration,
    /// Why there is nothing or little, or most of it at the slope limit, and what to change.
    pub advice: Option<Advice>,
}

impl Found {
    /// What the engine answered after `elapsed` for `burst`.
    pub fn new(detected: Detected, burst: &OpenBurst, elapsed: Duration) -> Self {
        let Detected { asked, params, finding, detection, .. } = detected;
        let advice = explain(&detection, &params, burst.burst.size());
        Self { asked, params, finding, detection, elapsed, advice }
    }
}

/// Which parts of the window are open.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct Panels {
    /// Scrubbing and parameters.
    pub left: bool,
    /// Selected feature and display.
    pub right: bool,
    /// Table and tally.
    pub bottom: bool,
    /// The bursts of a dataset, while one is open.
    pub filmstrip: bool,
}

impl Default for Panels {
    fn default() -> Self {
        Self { left: true, right: true, bottom: true, filmstrip: true }
    }
}

/// The tabs below the picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BottomTab {
    /// One row a feature.
    #[default]
    Table,
    /// How many candidates each test rejected.
    Tally,
    /// What is known of the noise.
    Noise,
}

/// What the engine is doing, as of this pass.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Busy {
    /// A burst is being opened.
    pub opening: Option<Running>,
    /// A detection runs.
    pub detecting: Option<Running>,
    /// A picture is being made.
    pub picture: bool,
}

/// A feature to be selected again once it has been found again.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SavedSelection {
    /// Its rank when it was saved.
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

/// Everything the window shows.
#[derive(Debug, Default)]
pub struct Model {
    /// What the window is about.
    pub room: Room,
    /// The open burst, if any.
    pub burst: Option<OpenBurst>,
    /// The parameters as they are being edited; they may make no sense for the moment. Where slopes are found, theirs are those found last.
    pub params: DetectorParams,
    /// How the slopes are chosen.
    pub slopes: SlopeChoice,
    /// Why they make no sense.
    pub param_error: Option<ParamError>,
    /// The last parameters that made sense for the burst: pictures are made with these.
    pub usable_params: DetectorParams,
    /// Where the hand is.
    pub scrub: Scrub,
    /// Whether the slope was chosen (by hand or by a session) since the burst was opened.
    pub slope_chosen: bool,
    /// The last good picture.
    pub picture: Option<Picture>,
    /// The motion-stack image at the selected feature's slope.
    pub patch: Option<Picture>,
    /// The features of the open burst.
    pub found: Option<Found>,
    /// Index of the selected feature.
    pub selected: Option<usize>,
    /// Index of the feature under the pointer, in the picture or in the table.
    pub hovered: Option<usize>,
    /// To be selected when the next detection ends.
    pub reselect: Option<SavedSelection>,
    /// Which features are shown.
    pub filter: Filter,
    /// The table's order.
    pub order: Order<Column>,
    /// Indices of the features that pass the filter, in the table's order; see [`Model::refresh_listed`].
    pub listed: Vec<usize>,
    /// Ranges, maps and overlay.
    pub look: Look,
    /// By what features are coloured.
    pub colour_by: ColourBy,
    /// Light, dark, or as the system.
    pub theme: egui::ThemePreference,
    /// Whether a detection starts by itself after a change.
    pub auto_detect: bool,
    /// Whether the slopes are being played.
    pub playing: bool,
    /// Open parts of the window.
    pub panels: Panels,
    /// The open tab below the picture.
    pub bottom_tab: BottomTab,
    /// The second burst, and the matches with it.
    pub pair: Pair,
    /// Several methods on the same burst.
    pub compare: Compare,
    /// Errors and the last note.
    pub messages: Messages,
    /// What the engine is doing.
    pub busy: Busy,
    /// Many bursts.
    pub datasets: Datasets,
    /// An estimated and a true trajectory.
    pub trajectories: Trajectories,
    listed_for: Option<ListedFor>,
}

#[derive(Debug, Clone, PartialEq)]
struct ListedFor {
    detection: usize,
    filter: Filter,
    order: Order<Column>,
    slope: Slope,
}

/// Why the features on show are not those of what is set now.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stale {
    /// The parameters changed since.
    Parameters,
    /// The parameters make no sense now.
    InvalidParameters,
}

impl Model {
    /// (columns, rows) of the open burst's frames; (0, 0) without one.
    pub fn size(&self) -> (usize, usize) {
        self.burst.as_ref().map_or((0, 0), |b| b.burst.size())
    }

    /// Frames of the open burst.
    pub fn frame_count(&self) -> usize {
        self.burst.as_ref().map_or(0, |b| b.burst.len())
    }

    /// Takes a newly opened burst in place of the one that was open.
    pub fn take_burst(&mut self, burst: OpenBurst) {
        let middle = burst.burst.len() / 2;
        self.burst = Some(burst);
        (self.picture, self.patch, self.found) = (None, None, None);
        (self.selected, self.hovered, self.playing, self.slope_chosen) = (None, None, false, false);
        self.look.forget_ranges();
        self.pair.forget_matches();
        self.compare.gold[0] = None;
        self.scrub = Scrub { kind: self.scrub.kind, frame: middle, ..Scrub::default() };
        self.check_params();
    }

    /// Checks the edited parameters against the burst and brings the scrub position into range.
    pub fn check_params(&mut self) {
        let check = |params: &DetectorParams| match &self.burst {
            Some(b) => params.validate_for(b.burst.len(), b.burst.size()),
            None => params.validate(),
        };
        let mut params = self.params.clone();
        if self.slopes.is_auto() && check(&params).is_err() {
            // Slopes that are still to be found cannot be wrong.
            params.slopes = SlopeGrid::single(Slope::default());
        }
        self.param_error = check(&params).err();
        if self.param_error.is_none() {
            self.usable_params = params;
        } else if let Some(b) = &self.burst
            && self.usable_params.validate_for(b.burst.len(), b.burst.size()).is_err()
        {
            self.usable_params = usable_for(b.burst.len());
        }
        if self.burst.is_some() {
            self.scrub = self.scrub.within(&self.usable_params, self.frame_count(), self.size());
        }
    }

    /// The picture that is wanted now.
    pub fn wanted_picture(&self) -> Option<PictureRequest> {
        self.wanted_picture_of(pair::Side::A)
    }

    /// The motion-stack image that the selected feature's patch is cut from.
    pub fn wanted_patch(&self) -> Option<PictureRequest> {
        let slope = self.selected_feature()?.slope;
        let (burst, found) = (self.burst.clone()?, self.found.as_ref()?);
        Some(PictureRequest { burst, kind: PictureKind::Stack { slope }, params: found.params.clone() })
    }

    /// Whether the picture on show is the one that is wanted.
    pub fn picture_is_current(&self) -> bool {
        match (&self.picture, self.wanted_picture()) {
            (Some(picture), Some(wanted)) => picture.request.same_picture(&wanted),
            (None, None) => true,
            _ => false,
        }
    }

    /// The slope by which the picture on show was shifted; `None` for a frame.
    pub fn slope_in_picture(&self) -> Option<Slope> {
        match self.picture.as_ref()?.request.kind {
            PictureKind::Frame(_) => None,
            PictureKind::Stack { slope } | PictureKind::Dog { slope, .. } => Some(slope),
        }
    }

    /// Takes a picture, unless it is of another burst.
    pub fn take_picture(&mut self, picture: Picture) {
        if self.is_of_open_burst(picture.request.burst.id) {
            self.look.fix_range_once(&picture);
            self.picture = Some(picture);
        }
    }

    /// Takes the features, unless they are of another burst. The selection is kept where the same feature was found again.
    pub fn take_detection(&mut self, detected: Detected, elapsed: Duration) {
        let Some(burst) = self.burst.as_ref().filter(|burst| burst.id == detected.burst) else { return };
        let found = Found::new(detected, burst, elapsed);
        let keep = self.reselect.take().or_else(|| self.saved_selection());
        if self.slopes.is_auto() && found.asked.slopes == self.slopes {
            self.params.slopes = found.params.slopes;
            self.check_params();
        }
        self.found = Some(found);
        self.hovered = None;
        self.selected = keep.and_then(|saved| self.find_again(&saved));
        self.refresh_listed();
        if !self.slope_chosen {
            self.go_to_busiest_slope();
        }
    }

    fn is_of_open_burst(&self, id: BurstId) -> bool {
        self.burst.as_ref().is_some_and(|b| b.id == id)
    }

    /// The features on show; none without a detection.
    pub fn features(&self) -> &[Feature] {
        self.found.as_ref().map_or(&[], |f| &f.detection.features)
    }

    /// The selected feature.
    pub fn selected_feature(&self) -> Option<&Feature> {
        self.features().get(self.selected?)
    }

    /// Why the features on show are not those of what is set now; `None` when they are.
    pub fn stale(&self) -> Option<Stale> {
        let found = self.found.as_ref()?;
        if found.asked == self.asked() {
            None
        } else if self.param_error.is_some() {
            Some(Stale::InvalidParameters)
        } else {
            Some(Stale::Parameters)
        }
    }

    /// What a detection is asked for now. Slopes that are to be found are not part of it.
    pub fn asked(&self) -> SearchParams {
        self.asked_of(pair::Side::A)
    }

    /// Chooses how the slopes are chosen, and for the detector all that `params` say.
    pub fn set_search(&mut self, params: SearchParams) {
        (self.params, self.slopes) = (params.detector, params.slopes);
    }

    /// Whether a detection with the present parameters is missing and could be made.
    pub fn needs_detection(&self) -> bool {
        self.burst.is_some()
            && self.param_error.is_none()
            && self.found.as_ref().is_none_or(|f| f.asked != self.asked())
    }

    /// The selection as it is kept in a session.
    pub fn saved_selection(&self) -> Option<SavedSelection> {
        let feature = self.selected_feature()?;
        let index = self.selected?;
        Some(SavedSelection { index, u: feature.u, v: feature.v, sigma: feature.sigma, slope: feature.slope })
    }

    /// The feature that `saved` was: the one nearest in place, scale and slope, if it is near enough to be the same.
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

    /// Brings [`Model::listed`] up to date. Cheap when nothing changed.
    pub fn refresh_listed(&mut self) {
        let Some(found) = &self.found else {
            self.listed.clear();
            self.listed_for = None;
            return;
        };
        // The slope on show matters only to the filter that looks at it.
        let slope = if self.filter.near_slope.is_some() { self.scrub.slope } else { Slope::default() };
        let now = ListedFor {
            detection: Arc::as_ptr(&found.detection) as usize,
            filter: self.filter,
            order: self.order,
            slope,
        };
        if self.listed_for.as_ref() != Some(&now) {
            self.listed = filter::listed(&found.detection.features, &self.filter, slope, self.order);
            self.listed_for = Some(now);
        }
    }

    /// For each feature whether it passes the filter.
    pub fn listed_flags(&self) -> Vec<bool> {
        let mut flags = vec![false; self.features().len()];
        for &i in &self.listed {
            if let Some(flag) = flags.get_mut(i) {
                *flag = true;
            }
        }
        flags
    }

    /// Selects the feature after (or before) the selected one in the table's order.
    pub fn select_neighbour(&mut self, forward: bool) {
        self.refresh_listed();
        self.selected = neighbour(&self.listed, self.selected, forward);
    }

    /// Goes to the slope of the grid at which most features were found, and says so. Does nothing without features.
    pub fn go_to_busiest_slope(&mut self) {
        let Some(found) = &self.found else { return };
        let grid = found.detection.slopes;
        let mut counts = vec![0usize; grid.len()];
        for feature in &found.detection.features {
            if let Some(count) = counts.get_mut(feature.slope_index) {
                *count += 1;
            }
        }
        // The last of equals loses, so that the answer does not depend on the order of equal counts.
        let busiest = counts.iter().enumerate().max_by_key(|(i, count)| (**count, std::cmp::Reverse(*i)));
        if let Some((index, &count)) = busiest.filter(|(_, count)| **count > 0) {
            self.scrub.slope = grid.slope(index);
            let Slope { u, v } = self.scrub.slope;
            self.messages.note(format!("Most features ({count}) are at slope ({u:.2}, {v:.2}) px/frame"));
        }
    }

    /// Switches the kind of picture.
    pub fn show_kind(&mut self, kind: ViewKind) {
        self.scrub.kind = kind;
    }
}

/// Of the items of a list the one after (or before) the selected one: the first (or last) where none is, and the last where there is no further one.
fn neighbour(listed: &[usize], selected: Option<usize>, forward: bool) -> Option<usize> {
    let place = selected.and_then(|s| listed.iter().position(|&i| i == s));
    let last = listed.len().saturating_sub(1);
    let next = match (place, forward) {
        (None, true) => 0,
        (None, false) => last,
        (Some(p), true) => (p + 1).min(last),
        (Some(p), false) => p.saturating_sub(1),
    };
    listed.get(next).copied().or(selected)
}

/// Parameters that make sense for any burst of `frame_count` frames whose frames are not tiny.
fn usable_for(frame_count: usize) -> DetectorParams {
    let mut params = DetectorParams::default();
    if frame_count <= 1 {
        params.method = crate::detector::Method::Sift;
    }
    params
}

#[cfg(test)]
mod tests;
