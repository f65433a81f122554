//! Slot of one of the two bursts: the burst, its features, their comparison with others, and the requests for it. What
//! was opened is never overwritten.

use crate::app::document::cursor::{Cursor, ViewKind};
use crate::app::document::filter::SavedSelection;
use crate::app::document::filter::at_slope;
use crate::app::document::side::Side;
use crate::app::pane::PaneId;
use crate::app::results::comparison::ComparisonResults;
use crate::app::results::own::Own;
use crate::app::results::{Effect, Model, Read};
use crate::app::view::{View, fixed};
use crate::burst::OpenOptions;
use crate::dataset::DatasetSource;
use crate::detector::{
    Advice, DetectorParams, Feature, FrameRange, Method, Slope, SlopeGrid, explain, follows, shared_slopes,
};
use crate::engine::{Ended, Engine, Wanted};
use crate::error::Error;
use crate::inspect::spectrum::{features_at_slopes, slope_with_most_features};
use crate::requests::{BurstSource, DetectRequest, Detected, DetectionSource, JobError, OpenBurst, OpenRequest};
use crate::teach::Workspace;
use std::ops::Deref;
use std::path::{Path, PathBuf};
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

impl Side {
    pub(in crate::app) fn opening(self) -> &'static str {
        match self {
            Self::A => "Open",
            Self::B => "Open B",
        }
    }

    fn detection(self) -> &'static str {
        match self {
            Self::A => "Detection",
            Self::B => "Detection in B",
        }
    }
}

impl Model {
    /// Takes a burst that was opened, or says why it was not. With `is_restoring` a session goes on with it.
    #[must_use]
    pub(in crate::app) fn take_opening(
        &mut self,
        side: Side,
        ended: Ended<OpenRequest>,
        is_restoring: bool,
        engine: &Engine,
    ) -> Vec<Effect> {
        let OpenRequest { source, options } = ended.request;
        let error = match ended.result {
            Ok(burst) => {
                let recent = self.take_opened(side, burst, options, engine);
                if side == Side::B && !is_restoring {
                    self.document.workspace = Workspace::Pair;
                }
                return recent.into_iter().collect();
            }
            Err(error) => error,
        };
        let slot = &mut self.results.slots[side];
        (slot.leaves, slot.stepped_to) = (None, None);
        slot.refused = slot.burst.is_none().then(|| source.clone());
        match (error, side, source) {
            (JobError::Several(_), Side::A, BurstSource::Paths(paths)) if !is_restoring => {
                self.look_at_dataset(DatasetSource::of_bursts(paths), None, options, engine);
            }
            (JobError::Several(bursts), Side::B, _) if !is_restoring => return vec![Effect::Choose(Side::B, bursts)],
            (JobError::NoShape(_, shapes), side, source) if !is_restoring => {
                return vec![Effect::AskShape(side, source, shapes)];
            }
            (JobError::Cancelled, Side::A, _) => self.messages.note("Opening cancelled"),
            (JobError::Cancelled, Side::B, _) => self.messages.note("Opening B cancelled"),
            (error, ..) => {
                if side == Side::B && self.results.slots.b.burst.is_none() {
                    // Panes of a session that wait for it would wait for ever.
                    self.document.panes.close_side(Side::B);
                }
                self.messages.error(side.opening(), error.to_string());
            }
        }
        Vec::new()
    }

    /// It goes to the recent list, unless it is one of the open dataset, which gives it its name.
    fn take_opened(
        &mut self,
        side: Side,
        mut burst: OpenBurst,
        options: OpenOptions,
        engine: &Engine,
    ) -> Option<Effect> {
        let dataset = self.results.datasets.open.as_ref().filter(|dataset| dataset.place_of(Some(&burst)).is_some());
        let recent = match dataset {
            Some(dataset) => {
                dataset.name_as_here(&mut burst);
                None
            }
            None => Some(Effect::Recent(burst.source.clone())),
        };
        self.messages.resolved(side.opening());
        let before = self.burst_of(side).map(|open| open.source.clone());
        let is_again = before.as_ref() == Some(&burst.source);
        if !is_again {
            self.results.left_behind = None;
        }
        self.leave_behind(side);
        self.results.slots[side].refused = None;
        match side {
            Side::A => {
                // A step back or forward has said what it changed.
                if self.results.slots.a.stepped_to.as_ref() != Some(&options) {
                    self.messages.note(format!("Opened {}", burst.describe()));
                    burst.burst.notes().iter().for_each(|note| self.messages.note(note.for_window()));
                }
                self.take_burst(burst);
                self.start_probe(before.as_ref());
                self.document.measure.clear();
                self.take_calibration(options, is_again, engine);
            }
            Side::B => {
                self.messages.note(format!("Opened as B: {}", burst.describe()));
                self.take_second_burst(burst);
                self.document.calibration_of_b = Some(options).filter(|options| *options != self.document.calibration);
            }
        }
        self.forget_closed_trails(engine);
        recent
    }

    /// Takes the options with which A was opened. Of the burst that was open before they are a step to undo, unless a
    /// step led to them.
    fn take_calibration(&mut self, options: OpenOptions, is_again: bool, engine: &Engine) {
        let is_step = is_again && self.results.slots.a.stepped_to.take().as_ref() != Some(&options);
        let before = self.document.clone();
        let was = std::mem::replace(&mut self.document.calibration, options);
        let is_changed = was != self.document.calibration;
        if is_changed && self.burst_of(Side::B).is_some() {
            // B stays as it was opened.
            self.document.calibration_of_b.get_or_insert(was);
        }
        if !is_again {
            self.history.clear();
        } else if is_step {
            self.history.take(before, &self.document);
            self.close_step(false);
        }
        if is_again && is_changed {
            self.look_at_dataset_again(engine);
        }
    }

    pub(in crate::app) fn forget_closed_trails(&self, engine: &Engine) {
        let open = Side::BOTH.into_iter().filter_map(|side| Some(self.burst_of(side)?.id));
        engine.keep_trails_of(&open.collect::<Vec<_>>());
    }

    /// `press` asks for a detection.
    pub fn without_features(&self, side: Side, press: &'static str) -> &'static str {
        if self.results.slots[side].detecting.is_pending() { "Detecting…" } else { press }
    }

    fn detect_request(&self, side: Side) -> Option<DetectRequest> {
        Some(DetectRequest { burst: self.burst_of(side)?.clone(), params: self.asked_of(side) })
    }

    /// Whether a detection with the present parameters is missing, could be made, and has not failed already.
    pub fn wants_detection(&self, side: Side) -> bool {
        let failed = |request: &DetectRequest| self.results.slots[side].detecting.has_failed(request);
        self.needs_detection(side) && !self.detect_request(side).as_ref().is_some_and(failed)
    }

    /// They need no search, or that of the fewer slopes, and the last ones asked for are there: a newer request would
    /// cancel them.
    pub(in crate::app) fn features_can_follow(&self, side: Side) -> bool {
        let now = self.asked_of(side);
        self.results.slots[side]
            .found
            .as_ref()
            .filter(|_| !self.results.slots[side].detecting.is_pending())
            .is_some_and(|found| {
                let is_near =
                    now.slopes == found.asked.slopes && found.asked.detector.judged_as(&now.detector) == now.detector;
                let shares = |now: &DetectorParams| 2 * shared_slopes(now, &found.searched) >= now.used_slopes().len();
                is_near && follows(&found.params.judged_as(&now.detector), &found.searched)
                    || !now.slopes.is_auto() && shares(&now.detector)
            })
    }

    pub fn start_detection(&mut self, side: Side, engine: &Engine) {
        if let Some(request) = self.detect_request(side).filter(|_| self.results.slots[side].param_error.is_none()) {
            self.results.slots[side].detecting.ask(engine, request);
        }
    }

    /// Features that are wanted by themselves, or by the probe, which begins with them.
    pub(super) fn missing_features(&self, side: Side, dragging: bool) -> Option<DetectRequest> {
        let follows = match side {
            Side::A => !dragging || self.features_can_follow(side),
            Side::B => !dragging && self.document.workspace == Workspace::Pair,
        };
        let is_time = self.document.auto_detect && follows || !dragging && self.probe_wants_features(side);
        self.detect_request(side).filter(|_| is_time && self.wants_detection(side))
    }

    pub(super) fn take_features(&mut self, side: Side, ended: Ended<DetectRequest>) {
        match ended.result {
            Ok(detected) => {
                self.messages.resolved(side.detection());
                self.take_detection(side, detected, ended.elapsed);
            }
            Err(error) => self.say_failed(side.detection(), &error),
        }
    }

    /// Shows the features of one slope of a long search, until all are there; not in place of others of the burst.
    pub(super) fn take_first_features(&mut self, side: Side, first: Detected) {
        let Some(burst) = self.burst_of(side).filter(|burst| burst.id == first.burst) else { return };
        if self.results.slots[side].found.is_some() {
            return;
        }
        // One slope tells nothing about the range.
        let found = FoundFeatures::new(first, burst, Duration::ZERO);
        let found = FoundFeatures { is_first_slope: true, advice: None, ..found };
        self.results.slots[side].found = Some(found);
        self.refresh_listed();
        self.go_to_first_slope(side);
    }

    pub(in crate::app) fn say_failed(&mut self, what: &str, error: &JobError) {
        match error {
            JobError::Cancelled => self.messages.note(format!("{what} cancelled")),
            error => self.messages.error(what, error.to_string()),
        }
    }

    pub fn take_burst(&mut self, burst: OpenBurst) {
        let middle = burst.burst.len() / 2;
        let slot = &mut self.results.slots.a;
        (slot.burst, slot.found, self.results.patch) = (Some(burst), None, None);
        slot.detecting.forget();
        self.forget_asked_pictures();
        (self.document.selected, self.results.hovered, self.document.playing) = (None, None, false);
        self.document.look.ranges.forget();
        (self.results.explained, self.document.selected_candidate) = Default::default();
        self.forget_matches();
        (self.results.compare.gold.a, self.document.gold.a) = (None, None);
        self.begin_comparison(Side::A);
        self.start_panes(Side::A, |cursor| Cursor { kind: cursor.kind, frame: middle, ..Cursor::default() });
        self.begin_panes_of_b();
        self.check_params();
    }

    /// The leading pane (that in focus, if it is on `side`) gets the cursor from `begin`; others keep their distance.
    pub(crate) fn start_panes(&mut self, side: Side, begin: impl Fn(&Cursor) -> Cursor) {
        let focus = self.document.panes.focus();
        let leader =
            if self.document.panes.get(focus).is_some_and(|pane| pane.side == side) { focus } else { PaneId::of(side) };
        let Some(before) = self.document.panes.get(leader).map(|pane| pane.cursor) else { return };
        let after = begin(&before);
        let (panes, pictures) = (&mut self.document.panes, &mut self.results.pictures);
        pictures.retain(|id, _| panes.get(*id).is_some_and(|pane| pane.side != side));
        for (id, pane) in panes.iter_mut().filter(|(_, pane)| pane.side == side) {
            pane.cursor = if id == leader { after } else { pane.cursor.moved_as(&before, &after) };
            pane.slope_chosen = false;
            pane.view = View::fit();
            pane.own_ranges.iter_mut().for_each(|own| own.forget());
        }
    }

    /// Shows the first `count` frames of A, added up along the slope, or of one its frame, which has no motion.
    pub fn use_frames(&mut self, count: usize) {
        let all = self.frame_count();
        let focus = self.document.focus();
        if count <= 1 {
            self.document.lead(focus, |pane| {
                pane.cursor.frame = 0;
                pane.show(ViewKind::Frame);
            });
            return;
        }
        self.document.params.frames = (count < all).then_some(FrameRange { start: 0, end: count });
        if self.document.cursor().kind == ViewKind::Frame {
            self.document.lead(focus, |pane| pane.show(ViewKind::Stack));
        }
        self.check_params();
    }

    pub fn check_params(&mut self) {
        let auto = self.document.slopes.is_auto();
        self.results.slots.a.param_error = checked(
            self.results.slots.a.burst.as_ref(),
            self.document.params.clone(),
            auto,
            &mut self.results.slots.a.usable_params,
        );
        self.results.pair.param_error = self.document.matching.validate().err();
        if self.results.slots.b.burst.is_some() {
            let params = self.params_of(Side::B);
            let b = &mut self.results.slots.b;
            b.param_error = checked(b.burst.as_ref(), params, auto, &mut b.usable_params);
        }
        self.check_cursors();
    }

    /// Brings cursors into the range of their bursts. Those that follow the one in focus may lie outside, so that they
    /// keep their distance to it.
    fn check_cursors(&mut self) {
        let (follows, focus, before) =
            (self.document.panes.followers(), self.document.focus(), *self.document.cursor());
        let bursts = [
            (self.results.slots.a.burst.as_ref(), &self.results.slots.a.usable_params),
            (self.results.slots.b.burst.as_ref(), &self.results.slots.b.usable_params),
        ];
        for (id, pane) in self.document.panes.iter_mut() {
            if let (Some(burst), params) = bursts[pane.side as usize]
                && !follows.contains(&id)
            {
                pane.cursor = pane.cursor_within(burst, params);
            }
        }
        self.document.panes.follow_cursor(focus, before);
    }
}

/// Checks `params` against `burst`. Returns why they are invalid, and keeps the last valid ones in `usable`.
fn checked(
    burst: Option<&OpenBurst>,
    mut params: DetectorParams,
    slopes_are_found: bool,
    usable: &mut DetectorParams,
) -> Option<Error> {
    let check = |params: &DetectorParams| match burst {
        Some(open) => params.validate_for(&open.burst.positions, open.burst.size()),
        None => params.validate(),
    };
    if slopes_are_found && check(&params).is_err() {
        // Slopes that are still to be found cannot be invalid.
        params.slopes = SlopeGrid::single(Slope::default());
    }
    let error = check(&params).err();
    if error.is_none() {
        *usable = params;
    } else if let Some(open) = burst
        && usable.validate_for(&open.burst.positions, open.burst.size()).is_err()
    {
        // Valid for any burst whose frames are not tiny.
        let method = if open.burst.len() <= 1 { Method::Sift } else { Method::Buff };
        *usable = DetectorParams { method, ..DetectorParams::default() };
    }
    error
}

#[derive(Debug, Clone)]
pub struct FoundFeatures {
    pub detected: Detected,
    pub elapsed: Duration,
    pub advice: Option<Advice>,
    /// Whether these are the features of one slope of a search that was long.
    pub is_first_slope: bool,
}

impl FoundFeatures {
    pub fn new(detected: Detected, burst: &OpenBurst, elapsed: Duration) -> Self {
        let advice = explain(&detected.detection, &detected.params, burst.burst.size());
        Self { detected, elapsed, advice, is_first_slope: false }
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
    pub fn features(self) -> &'a [Feature] {
        self.results.slots.a.found.as_ref().map_or(&[], |f| &f.detection.features)
    }

    pub fn selected_feature(self) -> Option<&'a Feature> {
        self.features().get(self.document.selected?)
    }

    pub fn saved_selection(self) -> Option<SavedSelection> {
        let feature = self.selected_feature()?;
        let index = self.document.selected?;
        Some(SavedSelection { index, u: feature.u, v: feature.v, sigma: feature.sigma, slope: feature.slope })
    }
}

impl Model {
    /// Takes the features, unless they are of another burst. The selection stays if the same feature was found again.
    pub fn take_detection(&mut self, side: Side, detected: Detected, elapsed: Duration) {
        let Some(burst) = self.burst_of(side).filter(|burst| burst.id == detected.burst) else { return };
        let found = FoundFeatures::new(detected, burst, elapsed);
        if side == Side::B {
            self.results.slots.b.found = Some(found);
            self.check_params();
            self.go_to_first_slope(Side::B);
            return;
        }
        let keep = self.results.reselect.take().or_else(|| self.read().saved_selection());
        if self.document.slopes.is_auto() && found.asked.slopes == self.document.slopes {
            self.document.params.slopes = found.params.slopes;
            self.check_params();
        }
        self.results.slots.a.found = Some(found);
        self.results.explained.slopes_wanted = false;
        self.results.hovered = None;
        self.document.selected = keep.and_then(|saved| self.find_again(&saved));
        self.refresh_listed();
        self.go_to_first_slope(Side::A);
    }

    pub fn found_source(&self, side: Side) -> Option<DetectionSource> {
        let (burst, found) = (self.burst_of(side)?.clone(), self.whole_found_of(side)?);
        let Detected { asked, params, finding, .. } = found.detected.clone();
        Some(DetectionSource { burst, asked, params, finding })
    }

    pub fn stale(&self) -> Option<Stale> {
        let found = self.results.slots.a.found.as_ref()?;
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

    /// Index of the feature nearest to `saved` in place, scale and slope, if it is near enough to be the same feature.
    fn find_again(&self, saved: &SavedSelection) -> Option<usize> {
        let distance = |f: &Feature| {
            let place = (f.u - saved.u).hypot(f.v - saved.v) / saved.sigma.max(0.5);
            let scale = (f.sigma / saved.sigma).log2().abs();
            let slope = (f.slope.u - saved.slope.u).hypot(f.slope.v - saved.slope.v);
            place + scale + slope
        };
        let features = self.read().features();
        let nearest = (0..features.len()).min_by(|&a, &b| {
            distance(&features[a])
                .total_cmp(&distance(&features[b]))
                .then(a.abs_diff(saved.index).cmp(&b.abs_diff(saved.index)))
        })?;
        (distance(&features[nearest]) < 1.0).then_some(nearest)
    }

    /// Unless a slope was chosen since that burst was opened.
    pub(crate) fn go_to_first_slope(&mut self, side: Side) {
        let (focus, own) = (self.document.panes.focus(), PaneId::of(side));
        let leader = if self.document.panes.get(focus).is_some_and(|pane| pane.side == side) { focus } else { own };
        // The burst's own pane, which other workspaces show, moves too if it is not on the screen.
        let alone = own != leader && !self.document.panes.shown().contains(&own);
        for id in [Some(leader), alone.then_some(own)].into_iter().flatten() {
            if self.document.panes.get(id).is_some_and(|pane| !pane.slope_chosen) {
                self.forget_range_of(id);
                self.go_to_busiest_slope(id);
            }
        }
    }

    /// Slopes on the grid's rim count only if there are features nowhere else.
    pub fn go_to_busiest_slope(&mut self, id: PaneId) {
        let Some(side) = self.document.panes.get(id).map(|pane| pane.side) else { return };
        let Some(found) = self.found_of(side) else { return };
        let grid = found.detection.slopes;
        if let Some((index, count)) = slope_with_most_features(&grid, &features_at_slopes(&found.detection)) {
            let slope = grid.slope(index);
            let [_, own] = at_slope(&found.detection, slope);
            self.document.lead(id, |pane| pane.cursor.slope = slope);
            let [u, v] = [slope.u, slope.v].map(|part| fixed(part, 2));
            let by_own = if own == count { String::new() } else { format!(", {own} by their own slope") };
            self.messages.note(format!("Most features ({count}) are at slope ({u}, {v}) px/frame{by_own}"));
        }
    }

    /// Parameter and session files are not among them, because they may be saved again after changes.
    pub fn opened_files(&self) -> Vec<PathBuf> {
        let gold = self.results.compare.gold.both().into_iter().flatten();
        let bursts = self.results.slots.both().into_iter().flat_map(|slot| &slot.burst).chain(gold);
        let mut files: Vec<PathBuf> = bursts.flat_map(|open| open.source.files()).collect();
        for burst in self.results.datasets.open.iter().flat_map(|dataset| dataset.bursts.iter()) {
            files.extend(BurstSource::Paths(burst.paths.clone()).files());
        }
        let calibrations = Side::BOTH.map(|side| self.calibration_of(side));
        let calibration = calibrations.into_iter().flat_map(OpenOptions::paths);
        files.extend(calibration.flat_map(|path| BurstSource::Paths(vec![path]).files()));
        files.extend(self.document.comparisons.both().into_iter().filter_map(|comparison| comparison.file.clone()));
        let trajectories = [&self.document.trajectories.estimate, &self.document.trajectories.truth];
        files.extend(trajectories.into_iter().flatten().flat_map(|path| files_of_model(path)));
        files
    }
}

fn files_of_model(path: &Path) -> Vec<PathBuf> {
    let inside = std::fs::read_dir(path).into_iter().flatten().flatten().map(|entry| entry.path());
    inside.chain([path.to_path_buf()]).collect()
}
