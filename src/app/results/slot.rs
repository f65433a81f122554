//! Slot of one of the two bursts: the burst, its features, their comparison with others, and the requests for it. What
//! was opened is never overwritten.

use crate::app::document::filter::near_slope;
use crate::app::document::{Document, SavedSelection, Side};
use crate::app::view::quantity_value;
use crate::app::{results::Read, results::comparison::ComparisonResults, results::own::Own};
use crate::burst::OpenOptions;
use crate::detector::{DetectorParams, Feature, Slope, SlopeGrid, follows, shared_slopes};
use crate::engine::{Engine, Wanted};
use crate::error::Error;
use crate::inspect::place::Judged;
use crate::requests::{BurstSource, DetectRequest, Detected, DetectionSource, JobId, OpenBurst, OpenRequest};
use std::ops::Deref;
use std::path::PathBuf;
use std::time::Duration;

#[derive(Debug, Default)]
pub struct Slot {
    pub burst: Option<OpenBurst>,
    /// The last parameters that were valid for the burst: pictures are made with these.
    pub usable_params: DetectorParams,
    pub param_error: Option<Error>,
    pub found: Option<FoundFeatures>,
    pub comparison: ComparisonResults,
    pub opening: Wanted<OpenRequest>,
    /// What is left behind once the burst that is being opened is open.
    pub leaves: Option<Own>,
    /// Source that could not be opened while nothing was open.
    pub refused: Option<BurstSource>,
    /// Options that a step back or forward opens the burst with.
    pub stepped_to: Option<OpenOptions>,
    pub detecting: Wanted<DetectRequest>,
}

impl Slot {
    /// Opens a burst, which leaves nothing behind unless it is given.
    pub(in crate::app) fn open(&mut self, request: OpenRequest, leaves: Option<Own>, engine: &Engine) -> JobId {
        self.leaves = leaves;
        self.opening.ask(engine, request)
    }
}

impl Side {
    pub(in crate::app) fn opening(self) -> &'static str {
        ["Open", "Open B"][self as usize]
    }

    pub fn detection(self) -> &'static str {
        ["Detection", "Detection in B"][self as usize]
    }
}

#[derive(Debug, Clone)]
pub struct FoundFeatures {
    pub detected: Detected,
    pub elapsed: Duration,
    /// Whether these are the features of one slope of a search that was long.
    pub is_first_slope: bool,
}

impl FoundFeatures {
    pub fn new(detected: Detected, elapsed: Duration) -> Self {
        Self { detected, elapsed, is_first_slope: false }
    }
}

impl Deref for FoundFeatures {
    type Target = Detected;

    fn deref(&self) -> &Detected {
        &self.detected
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stale {
    /// Those of one slope are there: the search for the others runs, or was cancelled.
    FirstSlope,
    Parameters,
    InvalidParameters,
}

impl<'a> Read<'a> {
    pub fn title(self) -> String {
        let is_shown = |side: &Side| *side == Side::A || self.document.workspace.shows_pair();
        let name = |side: Side| Some(self.results.slots[side].burst.as_ref()?.source.label());
        let names: Vec<String> = Side::BOTH.into_iter().filter(is_shown).filter_map(name).collect();
        if names.is_empty() { "Burstscope".to_owned() } else { format!("{} – Burstscope", names.join(" and ")) }
    }

    pub fn features(self) -> &'a [Feature] {
        self.found_of(Side::A).map_or(&[], |f| &f.detection.features)
    }

    pub fn selected_feature(self) -> Option<&'a Feature> {
        self.features().get(self.document.selected?)
    }

    pub fn saved_selection(self) -> Option<SavedSelection> {
        let feature = self.selected_feature()?;
        let index = self.document.selected?;
        Some(SavedSelection { index, u: feature.u, v: feature.v, sigma: feature.sigma, slope: feature.slope })
    }

    pub fn found_source(self, side: Side) -> Option<DetectionSource> {
        let (burst, found) = (self.burst_of(side)?.clone(), self.whole_found_of(side)?);
        let Detected { asked, params, finding, .. } = found.detected.clone();
        Some(DetectionSource { burst, asked, params, finding })
    }

    pub fn stale(self) -> Option<Stale> {
        let found = self.found_of(Side::A)?;
        if found.asked == self.asked() {
            None
        } else if found.is_first_slope {
            Some(Stale::FirstSlope)
        } else if self.results.slots.a.param_error.is_some() {
            Some(Stale::InvalidParameters)
        } else {
            Some(Stale::Parameters)
        }
    }

    /// Index of the feature nearest to `saved` in place, scale and slope, if it is near enough to be the same feature;
    /// the index in `saved` where nothing else is known.
    pub fn find_again(self, saved: &SavedSelection) -> Option<usize> {
        if saved.sigma == 0.0 {
            return Some(saved.index).filter(|index| *index < self.features().len());
        }
        let features = self.features();
        let distance = |index: usize| {
            let f = &features[index];
            let place = (f.u - saved.u).hypot(f.v - saved.v) / saved.sigma.max(0.5);
            let scale = (f.sigma / saved.sigma).log2().abs();
            let slope = (f.slope.u - saved.slope.u).hypot(f.slope.v - saved.slope.v);
            place + scale + slope
        };
        let nearest = (0..features.len()).min_by(|&a, &b| {
            let [from_a, from_b] = [a, b].map(|index| index.abs_diff(saved.index));
            distance(a).total_cmp(&distance(b)).then(from_a.cmp(&from_b))
        })?;
        (distance(nearest) < 1.0).then_some(nearest)
    }

    /// Parameter and session files are not among them, because they may be saved again after changes.
    pub fn opened_files(self) -> Vec<PathBuf> {
        let gold = self.results.compare.gold.both().into_iter().flatten();
        let bursts = self.results.slots.both().into_iter().flat_map(|slot| &slot.burst).chain(gold);
        let mut files: Vec<PathBuf> = bursts.flat_map(|open| open.source.files()).collect();
        for burst in self.results.datasets.open.iter().flat_map(|dataset| dataset.bursts.iter()) {
            files.extend(BurstSource::Paths(burst.paths.clone()).files());
        }
        let calibration = Side::BOTH.map(|side| self.calibration_of(side)).into_iter().flat_map(OpenOptions::paths);
        files.extend(calibration.flat_map(|path| BurstSource::Paths(vec![path]).files()));
        files.extend(self.document.comparisons.both().into_iter().filter_map(|comparison| comparison.file.clone()));
        for path in self.document.trajectories.paths().into_iter().flatten() {
            // A model is a folder.
            files.extend(std::fs::read_dir(path).into_iter().flatten().flatten().map(|entry| entry.path()));
            files.push(path.clone());
        }
        files
    }

    /// Default of `near_slope` of a filter: as for the features over the picture.
    pub fn near_slope(self) -> f32 {
        near_slope(self.found_of(Side::A).map_or(&self.results.slots.a.usable_params.slopes, |f| &f.detection.slopes))
    }

    pub fn listed_flags(self) -> Vec<bool> {
        let mut flags = vec![false; self.features().len()];
        for &i in &self.results.listed {
            flags.get_mut(i).into_iter().for_each(|flag| *flag = true);
        }
        flags
    }

    pub(in crate::app) fn forget_closed_trails(self, engine: &Engine) {
        let open = Side::BOTH.into_iter().filter_map(|side| Some(self.burst_of(side)?.id));
        engine.keep_trails_of(&open.collect::<Vec<_>>());
    }

    pub fn without_features(self, side: Side, press: &'static str) -> &'static str {
        if self.results.slots[side].detecting.is_pending() { "Detecting…" } else { press }
    }

    pub fn detect_request(self, side: Side) -> Option<DetectRequest> {
        Some(DetectRequest { burst: self.burst_of(side)?.clone(), params: self.asked_of(side) })
    }

    /// They need no search, or one of fewer slopes, and the last ones are there: a newer request would cancel them.
    pub(in crate::app) fn features_can_follow(self, side: Side) -> bool {
        let now = self.asked_of(side);
        self.found_of(side).filter(|_| !self.results.slots[side].detecting.is_pending()).is_some_and(|found| {
            let is_near = found.asked.judged_as(&now) == now;
            let shares = |now: &DetectorParams| 2 * shared_slopes(now, &found.searched) >= now.used_slopes().len();
            is_near && follows(&found.params.judged_as(&now), &found.searched)
                || now.slopes.given().is_some_and(|grid| shares(&now.at(grid)))
        })
    }

    /// Features that are wanted by themselves, or by the probe, which begins with them.
    pub fn missing_features(self, side: Side, dragging: bool) -> Option<DetectRequest> {
        let follows = match side {
            Side::A => !dragging || self.features_can_follow(side),
            Side::B => !dragging && self.document.workspace.shows_pair(),
        };
        let (probe, slot) = (&self.document.probe, &self.results.slots[side]);
        let is_probed = probe.is_on() && probe.side == side;
        let by_probe = is_probed && slot.found.is_none() && self.results.probed.problem.is_none();
        let is_time = self.document.auto_detect && follows || !dragging && by_probe;
        let is_missing = is_time && self.needs_detection(side);
        self.detect_request(side).filter(|request| is_missing && !slot.detecting.has_failed(request))
    }
}

impl Document {
    /// Indices of the features that pass the filter at `slope`, in the chosen order; `judged` says more of them.
    pub fn listed(&self, features: &[Feature], judged: &[Judged], grid: &SlopeGrid, slope: Slope) -> Vec<usize> {
        let passes = |&i: &usize| self.filter.passes(&features[i], judged.get(i), grid, slope);
        let value = |index: usize| {
            let known = self.set_up.known(&features[index], judged.get(index));
            // What is not known is greatest.
            quantity_value(self.order.column, index, &features[index], known).unwrap_or(f32::INFINITY)
        };
        let mut listed: Vec<(f32, usize)> = (0..features.len()).filter(passes).map(|i| (value(i), i)).collect();
        listed.sort_unstable_by(|a, b| {
            let by = a.0.total_cmp(&b.0);
            let by = if self.order.descending { by.reverse() } else { by };
            by.then(a.1.cmp(&b.1))
        });
        listed.into_iter().map(|(_, index)| index).collect()
    }
}
