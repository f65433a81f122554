//! Pictures of panes: those that are wanted, those that are there, the pane in focus, and the pictures' value ranges.
//!
//! A shared range is set by the pane in focus, or if that shows another class of picture by the first in reading order,
//! once its wanted picture is there. So the result does not depend on the order in which the pictures are made: the
//! same panes always get the same range.

use crate::app::pane::{Content, Link, Pane, PaneId, Preset};
use crate::app::project::cursor::Cursor;
use crate::app::project::look::{RangeClass, Ranges};
use crate::app::project::pair::Side;
use crate::app::project::workspace::Workspace;
use crate::app::project::{FoundFeatures, Model};
use crate::detector::{Detection, DetectorParams, Slope};
use crate::engine::Engine;
use crate::plane::display::Display;
use crate::requests::{JobError, OpenBurst, Picture, PictureKind, PictureRequest, Request, Urgency};
use std::borrow::Cow;
use std::sync::Arc;

impl Model {
    /// Opens a workspace, with its panes.
    pub fn open_workspace(&mut self, workspace: Workspace) {
        self.workspace = workspace;
        self.panes.turn_to(workspace);
    }

    /// The pane that sliders and keys move.
    pub fn focus(&self) -> PaneId {
        self.panes.focus()
    }

    /// The pane that sliders and keys move.
    pub fn focused(&self) -> &Pane {
        self.panes.get(self.focus()).unwrap_or_else(|| self.panes.of(Side::A))
    }

    /// The pane that sliders and keys move, for changing.
    pub fn focused_mut(&mut self) -> &mut Pane {
        let focus = self.focus();
        let focus = if self.panes.get(focus).is_some() { focus } else { PaneId::of(Side::A) };
        self.panes.get_mut(focus).expect("A's pane is always there")
    }

    /// Cursor of the pane in focus.
    pub fn cursor(&self) -> &Cursor {
        &self.focused().cursor
    }

    /// The picture on show of the pane in focus.
    pub fn picture(&self) -> Option<&Picture> {
        self.focused().picture.as_ref()
    }

    /// The panes that are on the screen.
    pub fn visible_panes(&self) -> Vec<PaneId> {
        self.panes.shown()
    }

    /// The open burst of `side`.
    pub fn burst_of(&self, side: Side) -> Option<&OpenBurst> {
        self.slots[side].burst.as_ref()
    }

    /// The features of `side`.
    pub fn found_of(&self, side: Side) -> Option<&FoundFeatures> {
        self.slots[side].found.as_ref()
    }

    /// Whether the features of `side` were found with the present parameters.
    pub fn features_are_current(&self, side: Side) -> bool {
        self.found_of(side).is_some_and(|found| found.asked == self.asked_of(side))
    }

    /// The last valid parameters for the burst of `side`.
    pub fn usable_params_of(&self, side: Side) -> &DetectorParams {
        &self.slots[side].usable_params
    }

    /// The burst that `pane` shows; where methods are compared that may be the gold standard.
    pub fn burst_in(&self, pane: &Pane) -> Option<&OpenBurst> {
        match pane.method {
            Some(method) => self.method_burst(method, pane.side),
            None => self.burst_of(pane.side),
        }
    }

    /// The last valid parameters for the burst of `pane`, as its method takes them.
    pub fn params_in(&self, pane: &Pane) -> Cow<'_, DetectorParams> {
        let usable = self.usable_params_of(pane.side);
        pane.method.map_or(Cow::Borrowed(usable), |method| Cow::Owned(method.params(usable)))
    }

    /// Detection in the burst of `pane`, by the pane's method.
    pub fn detection_in(&self, pane: &Pane) -> Option<&Arc<Detection>> {
        match pane.method {
            Some(method) => self.method_found(method, pane.side).map(|found| &found.detection),
            None => self.found_of(pane.side).map(|found| &found.detection),
        }
    }

    /// The last valid parameters for the burst of the pane in focus.
    pub fn cursor_params(&self) -> &DetectorParams {
        self.usable_params_of(self.focused().side)
    }

    /// Number of frames of the burst in focus; 0 without one.
    pub fn focused_frame_count(&self) -> usize {
        self.burst_of(self.focused().side).map_or(0, |open| open.burst.len())
    }

    /// (columns, rows) of the burst in focus; (0, 0) without one.
    pub fn focused_size(&self) -> (usize, usize) {
        self.burst_of(self.focused().side).map_or((0, 0), |open| open.burst.size())
    }

    /// Request for the picture that `id` is to show now; `None` without its burst.
    pub fn wanted(&self, id: PaneId) -> Option<PictureRequest> {
        let pane = self.panes.get(id)?;
        let request = match pane.content {
            Content::Difference(a, b) => {
                let [a, b] = [a, b].map(|id| self.wanted_alone(id));
                a?.less(&b?)
            }
            Content::Cursor | Content::Merge | Content::Map(_) => self.wanted_alone(id)?,
            Content::Slice(_) => return None,
        };
        Some(request.smoothed(self.look.smoothing_px))
    }

    fn wanted_alone(&self, id: PaneId) -> Option<PictureRequest> {
        let pane = self.panes.get(id)?;
        pane.wanted(self.burst_in(pane)?, &self.params_in(pane))
    }

    /// The motion-stack image that the selected feature's patch is cut from.
    pub fn patch_request(&self) -> Option<PictureRequest> {
        let slope = self.selected_feature()?.slope;
        let (burst, found) = (self.slots.a.burst.clone()?, self.slots.a.found.as_ref()?);
        Some(PictureRequest::new(burst, PictureKind::Stack { slope }, found.params.clone()))
    }

    /// Whether `id` shows the picture that it wants, or that picture is known to have failed.
    pub fn is_current(&self, id: PaneId) -> bool {
        let Some(wanted) = self.wanted(id) else { return true };
        self.panes.get(id).is_some_and(|pane| {
            let failed = pane.problem.as_ref().is_some_and(|(request, _)| request.is_same(&wanted));
            failed || pane.picture.as_ref().is_some_and(|picture| picture.request.is_same(&wanted))
        })
    }

    /// Whether the picture of the pane in focus is current.
    pub fn picture_is_current(&self) -> bool {
        self.is_current(self.focus())
    }

    /// Whether the pictures of all visible panes are current.
    pub fn pictures_are_current(&self) -> bool {
        self.visible_panes().into_iter().all(|id| self.is_current(id))
    }

    /// Switches a link of a pane. A pane that no longer shares its display keeps the ranges that it had.
    pub fn set_link(&mut self, id: PaneId, link: Link, on: bool) {
        let shared = self.look.ranges;
        let Some(pane) = self.panes.get_mut(id) else { return };
        pane.links.set(link, on);
        if link == Link::Display {
            pane.own_ranges = (!on).then_some(pane.own_ranges.unwrap_or(shared));
        }
    }

    /// Slope by which the frames were shifted for the picture of `id`; `None` for pictures without a single slope.
    pub fn slope_in_picture(&self, id: PaneId) -> Option<Slope> {
        let picture = self.panes.get(id)?.picture.as_ref().filter(|picture| picture.request.minus().is_none())?;
        picture.request.kind.slope()
    }

    /// Takes the pictures of panes, and that of the selected feature's patch.
    pub(in crate::app) fn take_pictures(&mut self) {
        let ended: Vec<_> = self
            .wanted_pictures
            .iter_mut()
            .flat_map(|(id, wanted)| wanted.take().into_iter().map(|ended| (*id, ended)))
            .collect();
        for (id, ended) in ended {
            match ended.result {
                Ok(picture) => self.take_picture(id, picture),
                Err(JobError::Cancelled) => self.wanted_pictures.entry(id).or_default().forget(),
                Err(error) => self.take_problem(id, ended.request, &error),
            }
        }
        for ended in self.wanted_patch.take() {
            match ended.result {
                Ok(patch) => self.patch = Some(patch),
                Err(JobError::Cancelled) => {}
                Err(error) => self.messages.error("Patch", error.to_string()),
            }
        }
    }

    /// Requests the missing pictures of visible panes, that of the pane in focus first, and that of the selected
    /// feature's patch. Pictures that need a search wait for the end of a drag, and for a running detection in
    /// their burst, from which they may be made.
    pub(in crate::app) fn ask_for_pictures(&mut self, engine: &Engine, dragging: bool) {
        let focus = self.focus();
        let mut ids = self.visible_panes();
        ids.sort_by_key(|id| *id != focus);
        for id in ids {
            let Some(wanted) = self.wanted(id).filter(|_| !self.is_current(id)) else { continue };
            let side = self.panes.get(id).map_or(Side::A, |pane| pane.side);
            let waits = dragging || self.slots[side].detecting.is_pending();
            if !(waits && wanted.urgency() == Urgency::SlowPicture) {
                self.wanted_pictures.entry(id).or_default().want(engine, Some(wanted));
            }
        }
        let is_there = |wanted: &PictureRequest| self.patch.as_ref().is_some_and(|patch| patch.request.is_same(wanted));
        let missing = self.patch_request().filter(|wanted| !is_there(wanted));
        if missing.is_some() {
            self.wanted_patch.want(engine, missing);
        }
    }

    /// Cancels the requests of panes that were closed.
    pub(in crate::app) fn forget_closed_pictures(&mut self) {
        let panes = &self.panes;
        self.wanted_pictures.retain(|id, _| panes.get(*id).is_some());
    }

    /// Cancels the requests for pictures; those still wanted are requested again.
    pub(in crate::app) fn forget_asked_pictures(&mut self) {
        self.wanted_pictures.clear();
        self.wanted_patch.forget();
        self.pair.wanted_patches.forget();
    }

    /// Takes the picture of a pane, unless it is of another burst than the one that the pane shows now.
    pub fn take_picture(&mut self, id: PaneId, picture: Picture) {
        let Some(pane) = self.panes.get(id) else { return };
        let is_open = |burst: &OpenBurst| {
            self.panes.iter().any(|(_, pane)| self.burst_in(pane).is_some_and(|open| open.id == burst.id))
        };
        let fits = match pane.content {
            Content::Difference(..) => is_open(&picture.request.burst),
            Content::Slice(_) => false,
            Content::Cursor | Content::Merge | Content::Map(_) => {
                self.burst_in(pane).is_some_and(|open| open.id == picture.request.burst.id)
            }
        };
        if !fits {
            return;
        }
        let Some(pane) = self.panes.get_mut(id) else { return };
        pane.own_ranges.as_mut().unwrap_or(&mut self.look.ranges).propose(&picture);
        (pane.picture, pane.problem) = (Some(picture), None);
        self.settle_ranges();
    }

    /// Stores why the picture of a pane could not be made.
    pub fn take_problem(&mut self, id: PaneId, request: PictureRequest, error: &JobError) {
        if let Some(pane) = self.panes.get_mut(id) {
            pane.problem = Some((request, error.to_string()));
        }
    }

    /// Moves the focus to a visible pane on the burst of `side`, if there is one and the focus is not on such a pane.
    pub fn focus_on_side(&mut self, side: Side) {
        let is_on = |id: &PaneId| self.panes.get(*id).is_some_and(|pane| pane.side == side);
        if !is_on(&self.panes.focus())
            && let Some(id) = self.panes.shown().into_iter().find(is_on)
        {
            self.panes.set_focus(id);
        }
    }

    /// Arranges the panes by a preset, made from the pane in focus.
    pub fn lay_out(&mut self, preset: Preset) {
        let params = self.cursor_params().clone();
        self.panes.lay_out(preset, &params);
        self.check_params();
    }
}

impl Model {
    /// Class of the value range in which the picture of `id` is shown.
    pub fn range_class(&self, id: PaneId) -> RangeClass {
        let picture = self.panes.get(id).and_then(|pane| pane.picture.as_ref());
        let wanted = || self.wanted(id).map_or(RangeClass::Intensity, |wanted| RangeClass::of(&wanted));
        picture.map_or_else(wanted, |picture| RangeClass::of(&picture.request))
    }

    /// Whether a colour bar lies over the picture of pane `id`: over a map.
    pub fn has_colour_bar(&self, id: PaneId) -> bool {
        use RangeClass::{Difference, Intensity, Response};
        let has_picture = self.panes.get(id).is_some_and(|pane| pane.picture.is_some());
        has_picture && !matches!(self.range_class(id), Intensity | Response | Difference)
    }

    /// Value ranges of `pane`: its own, or those that panes share.
    pub fn ranges_of<'a>(&'a self, pane: &'a Pane) -> &'a Ranges {
        pane.own_ranges.as_ref().unwrap_or(&self.look.ranges)
    }

    /// Value ranges of the pane in focus, for changing: its own, or those that panes share.
    pub fn focused_ranges_mut(&mut self) -> &mut Ranges {
        let focus = self.focus();
        match self.panes.get_mut(focus).and_then(|pane| pane.own_ranges.as_mut()) {
            Some(own) => own,
            None => &mut self.look.ranges,
        }
    }

    /// Display of the picture of `id`: range, gamma and colours.
    pub fn display_of(&self, id: PaneId) -> Display {
        let ranges = self.panes.get(id).map_or(&self.look.ranges, |pane| self.ranges_of(pane));
        ranges.display(self.range_class(id))
    }

    /// Sets the ranges that are not set yet: a pane's own range from its picture, a shared one from the pane in focus
    /// or the first in reading order that shows this class.
    pub fn settle_ranges(&mut self) {
        let mut led = Vec::new();
        let focus = self.focus();
        let mut ids = self.visible_panes();
        ids.sort_by_key(|id| *id != focus);
        for id in ids {
            let Some(wanted) = self.wanted(id) else { continue };
            let class = RangeClass::of(&wanted);
            let is_current = self.is_current(id);
            let Some(pane) = self.panes.get_mut(id) else { continue };
            let own = pane.own_ranges.as_mut();
            if pane.problem.is_some() || (own.is_none() && led.contains(&class)) {
                continue;
            }
            if own.is_none() {
                led.push(class);
            }
            if let Some(picture) = pane.picture.as_ref().filter(|_| is_current) {
                own.unwrap_or(&mut self.look.ranges).fix_once(picture);
            }
        }
    }
}
