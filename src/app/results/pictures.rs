//! Pictures of panes: those that are wanted, those that are there, the pane in focus, and the pictures' value ranges.
//! Panes get the same range in whichever order their pictures are made: a shared one is set by the pane in focus, or by
//! the first in reading order that shows the class.

use crate::app::document::cursor::{octave_range, row_of};
use crate::app::document::{Action, Cursor, FilmContent, Filter, PlayOver, RangeClass, Side};
use crate::app::pane::{Content, Pane, PaneId};
use crate::app::results::{FoundFeatures, Read};
use crate::burst::Offset;
use crate::detector::{Detection, DetectorParams, Feature, Slope, SlopeAxis};
use crate::engine::{Ended, Wanted};
use crate::plane::Plane;
use crate::plane::display::Display;
use crate::requests::{
    Film, MAX_FILM_PICTURES, OpenBurst, PictureAnswer, PictureKind, PictureRequest, Request, Sweep, ViewKind,
};
use std::borrow::Cow;
use std::sync::Arc;

/// Preview in a form: of the figure that it would write, say.
#[derive(Debug)]
pub struct Preview<R: Request<Answer = A>, A> {
    /// Request of the form, as of the last pass; `None` without a form.
    pub asked: Option<R>,
    /// The last one that was made; a failure stays with the request.
    pub made: Option<(R, Arc<A>)>,
    pub wanted: Wanted<R>,
}

impl<R: Request<Answer = A>, A> Default for Preview<R, A> {
    fn default() -> Self {
        Self { asked: None, made: None, wanted: Wanted::default() }
    }
}

impl<R: Request<Answer = A>, A> Preview<R, A> {
    /// Takes the request of the form; without a form nothing is kept.
    pub fn ask(&mut self, asked: Option<R>) {
        match asked {
            None => *self = Self::default(),
            asked => self.asked = asked,
        }
    }

    pub fn missing(&self) -> Option<R> {
        self.asked.clone().filter(|asked| self.made.as_ref().is_none_or(|(of, _)| of != asked))
    }

    pub fn take(&mut self, ended: Ended<R>) {
        self.made = ended.result.ok().map(|made| (ended.request, Arc::new(made))).or(self.made.take());
    }

    /// The last answer, until that of `asked` is there; the error says why there will be none.
    pub fn on_show(&self, asked: &Result<R, String>) -> Result<Option<&Arc<A>>, String> {
        let failure = |asked| self.wanted.failure().filter(|(of, _)| *of == asked).map(|(_, why)| why.to_string());
        let why = asked.as_ref().map_or_else(|why| Some(why.clone()), failure);
        why.map_or(Ok(self.made.as_ref().map(|(_, made)| made)), Err)
    }
}

/// Pictures from which patches are cut: of features, of matches, and of the place in the loupe.
#[derive(Debug, Default)]
pub struct PatchResults {
    /// Burst and motion of the place in the loupe, as of the last pass; `None` without a loupe.
    pub loupe: Option<(Side, Slope)>,
    /// Motion stacks; `None` for one that cannot be made.
    pub stacks: Vec<(PictureRequest, Option<PictureAnswer>)>,
    pub wanted: Wanted<PictureRequest>,
    /// The burst of the loupe, each place shifted by its own motion.
    pub in_focus: Option<PictureAnswer>,
    pub wanted_in_focus: Wanted<PictureRequest>,
}

impl<'a> Read<'a> {
    /// Pictures that are played in the pane in focus: how many, the place of that on show, and the action for a place.
    pub fn sweep(self) -> (usize, usize, Box<dyn Fn(usize) -> Action + 'a>) {
        let (id, cursor, params) = (self.document.focus(), *self.document.cursor(), self.cursor_params());
        match self.played() {
            PlayOver::Frames => (self.focused_frame_count(), cursor.frame, Box::new(move |t| Action::PlayFrame(id, t))),
            PlayOver::Scales => {
                let of_octave = |octave| (0..params.levels as i32).map(move |level| (octave, level));
                let scales: Vec<(i32, i32)> = octave_range(params, self.focused_size()).flat_map(of_octave).collect();
                let here = scales.iter().position(|scale| *scale == (cursor.octave, cursor.level)).unwrap_or(0);
                (scales.len(), here, Box::new(move |place| Action::PlayScale(id, scales[place].0, scales[place].1)))
            }
            PlayOver::Slopes | PlayOver::Shown => {
                let (slopes, here) = row_of(&params.slopes, cursor.slope);
                (slopes.len(), here, Box::new(move |place| Action::PlaySlope(id, slopes[place])))
            }
        }
    }

    /// Frames, slopes or scales: as chosen, or as the picture on show has them.
    pub fn played(self) -> PlayOver {
        match (self.document.play.over, self.document.focused().shown()) {
            (PlayOver::Shown, Some(ViewKind::Frame)) => PlayOver::Frames,
            (PlayOver::Shown, _) => PlayOver::Slopes,
            (chosen, _) => chosen,
        }
    }

    pub fn pane(self, id: PaneId) -> Option<&'a Pane> {
        self.document.panes.get(id)
    }

    pub fn picture(self) -> Option<&'a PictureAnswer> {
        self.picture_in(self.document.focus())
    }

    /// The last picture of pane `id`, if it is of a burst that the pane shows now.
    pub fn picture_in(self, id: PaneId) -> Option<&'a PictureAnswer> {
        let pane = self.pane(id)?;
        self.results.pictures.get(&id)?.picture.as_ref().filter(|picture| self.fits(pane, picture))
    }

    /// Features with whose motions those in the picture of pane `id` share their colours.
    pub fn features_of_motion(self, id: PaneId) -> &'a [Feature] {
        let grid = self.picture_in(id).and_then(|picture| picture.motion.as_ref()).map(|motion| motion.grid);
        let found = self.pane(id).and_then(|pane| self.found_of(pane.side));
        found.filter(|found| grid == Some(found.detection.slopes)).map_or(&[], |found| &found.detection.features)
    }

    /// The filter that holds for pane `id`: where A is inspected.
    pub fn filter_of(self, id: PaneId) -> Option<&'a Filter> {
        let is_of_a = self.pane(id).is_some_and(|pane| pane.side == Side::A && pane.method.is_none());
        (is_of_a && self.document.workspace.inspects()).then_some(&self.document.filter)
    }

    /// Value in the file that became 1.0, of the burst of `id`; 1 where the picture's values are not the file's.
    pub fn full_scale(self, id: PaneId) -> f32 {
        if matches!(self.range_class(id), RangeClass::Share | RangeClass::Motion) {
            return 1.0;
        }
        self.pane(id).and_then(|pane| self.burst_in(pane)).map_or(1.0, |open| open.burst.full_scale)
    }

    /// Position of the frame in the picture of pane `id` from the mean of the searched ones; `None` if it is no frame.
    pub fn frames_from_middle(self, id: PaneId, detection: &Detection) -> Option<Offset<f32>> {
        let request = &self.picture_in(id)?.request;
        let PictureKind::Frame(t) = request.kind else { return None };
        Some(request.burst.burst.positions.offset_from(detection.frames_used.clone(), t).to_f32())
    }

    /// Whether `picture` is of the burst that `pane` shows; the difference of two panes may be of any open burst.
    pub fn fits(self, pane: &Pane, picture: &PictureAnswer) -> bool {
        let is_of = |pane: &Pane| self.burst_in(pane).is_some_and(|open| open.id == picture.request.burst.id);
        match pane.content {
            Content::Difference(..) => self.document.panes.iter().any(|(_, pane)| is_of(pane)),
            Content::Slice(_) => false,
            Content::Cursor | Content::Merge | Content::Map(_) => is_of(pane),
        }
    }

    /// Pictures to draw in pane `id`: the last one, and a preview of the next.
    pub fn drawn_in(self, id: PaneId) -> [Option<&'a PictureAnswer>; 2] {
        let preview = self.results.pictures.get(&id).and_then(|shown| shown.preview.as_ref());
        let fits = |preview: &&PictureAnswer| self.pane(id).is_some_and(|pane| self.fits(pane, preview));
        [self.picture_in(id), preview.filter(fits).filter(|_| !self.is_current(id))]
    }

    pub fn problem_of(self, id: PaneId) -> Option<String> {
        let (request, why) = self.results.pictures.get(&id)?.wanted.failure()?;
        (*request == self.wanted(id)?).then(|| why.to_string())
    }

    pub fn burst_of(self, side: Side) -> Option<&'a OpenBurst> {
        self.results.slots[side].burst.as_ref()
    }

    pub fn found_of(self, side: Side) -> Option<&'a FoundFeatures> {
        self.results.slots[side].found.as_ref()
    }

    /// The features of a whole search: of those of a first slope nothing is asked, as no search finds just these.
    pub fn whole_found_of(self, side: Side) -> Option<&'a FoundFeatures> {
        self.found_of(side).filter(|found| !found.is_first_slope)
    }

    pub fn features_are_current(self, side: Side) -> bool {
        self.found_of(side).is_some_and(|found| found.asked == self.asked_of(side))
    }

    /// The burst that `pane` shows; where methods are compared that may be the gold standard.
    pub fn burst_in(self, pane: &Pane) -> Option<&'a OpenBurst> {
        pane.method.map_or_else(|| self.burst_of(pane.side), |method| self.method_burst(method, pane.side))
    }

    pub fn params_in(self, pane: &Pane) -> Cow<'a, DetectorParams> {
        let usable = &self.results.slots[pane.side].usable_params;
        pane.method.map_or(Cow::Borrowed(usable), |method| Cow::Owned(method.params(usable)))
    }

    pub fn detection_in(self, pane: &Pane) -> Option<&'a Arc<Detection>> {
        match pane.method {
            Some(method) => self.method_found(method, pane.side).map(|found| &found.detection),
            None => self.found_of(pane.side).map(|found| &found.detection),
        }
    }

    pub fn cursor_params(self) -> &'a DetectorParams {
        &self.results.slots[self.document.focused().side].usable_params
    }

    pub fn focused_frame_count(self) -> usize {
        self.burst_of(self.document.focused().side).map_or(0, |open| open.burst.len())
    }

    pub fn focused_size(self) -> (usize, usize) {
        self.burst_of(self.document.focused().side).map_or((0, 0), |open| open.burst.size())
    }

    pub fn wanted(self, id: PaneId) -> Option<PictureRequest> {
        let request = match self.pane(id)?.content {
            Content::Difference(a, b) => {
                let [a, b] = [a, b].map(|id| self.wanted_alone(id));
                a?.less(&b?)
            }
            Content::Cursor | Content::Merge | Content::Map(_) => self.wanted_alone(id)?,
            Content::Slice(_) => return None,
        };
        // A picture that is laid over another is seen there too.
        let shows = |of: PaneId, pane: &Pane| of == id || pane.over.is_some_and(|over| over.other() == id);
        let views = self.document.panes.iter().filter(|(of, pane)| shows(*of, pane)).map(|(_, pane)| pane.view);
        let seen = views.map(|view| view.visible_image()).reduce(egui::Rect::union)?;
        let (request, view) = (request.smoothed(self.document.look.smoothing_px), self.pane(id)?.view);
        Some(request.previewed(view.points_per_pixel(), [seen.min.into(), seen.max.into()]))
    }

    fn wanted_alone(self, id: PaneId) -> Option<PictureRequest> {
        let pane = self.pane(id)?;
        pane.wanted(self.burst_in(pane)?, &self.params_in(pane))
    }

    fn with_found(self, side: Side, kind: PictureKind) -> Option<PictureRequest> {
        Some(PictureRequest::new(self.burst_of(side)?.clone(), kind, self.found_of(side)?.params.clone()))
    }

    /// Motion stacks from which the patches on show are cut, each at the slope of its feature or place.
    pub fn stacks_of_patches(self) -> Vec<PictureRequest> {
        let selected = self.selected_feature().map(|feature| (Side::A, feature.slope));
        let all = self.results.patches.loupe.into_iter().chain(selected).chain(self.patches_of_pair());
        all.filter_map(|(side, slope)| self.with_found(side, PictureKind::Stack { slope })).collect()
    }

    /// The motion stack of a side at the slope of a feature or place, if it is there.
    pub fn stack_at(self, side: Side, slope: Slope) -> Option<&'a Arc<Plane>> {
        let wanted = self.with_found(side, PictureKind::Stack { slope })?;
        let (_, stack) = self.results.patches.stacks.iter().find(|(request, _)| *request == wanted)?;
        stack.as_ref().map(|stack| &stack.plane)
    }

    pub fn missing_stack(self) -> Option<PictureRequest> {
        let stacks = &self.results.patches.stacks;
        self.stacks_of_patches().into_iter().find(|wanted| !stacks.iter().any(|(request, _)| request == wanted))
    }

    /// All in focus for the loupe, if it is missing. A drag and a running detection come first.
    pub fn missing_in_focus(self, dragging: bool) -> Option<PictureRequest> {
        let (side, _) = self.results.patches.loupe?;
        let wanted = self.with_found(side, Cursor::default().picture(ViewKind::InFocus))?;
        let is_there = self.results.patches.in_focus.as_ref().is_some_and(|picture| picture.request == wanted);
        (!is_there && !dragging && !self.results.slots[side].detecting.is_pending()).then_some(wanted)
    }

    /// Whether `id` shows the picture that it wants, or that picture is known to have failed.
    pub fn is_current(self, id: PaneId) -> bool {
        let Some(wanted) = self.wanted(id) else { return true };
        self.results.pictures.get(&id).is_some_and(|shown| {
            shown.wanted.has_failed(&wanted) || shown.picture.as_ref().is_some_and(|picture| picture.request == wanted)
        })
    }

    pub fn picture_is_current(self) -> bool {
        self.is_current(self.document.focus())
    }

    pub fn pictures_are_current(self) -> bool {
        self.document.panes.shown().into_iter().all(|id| self.is_current(id))
    }

    /// Whether each pane shows what it wants, or a preview of it.
    pub fn pictures_are_seen(self) -> bool {
        let preview = |id: PaneId| self.results.pictures.get(&id)?.preview.as_ref().map(|preview| &preview.request);
        let is_seen =
            |id: PaneId| self.is_current(id) || preview(id).is_some() && preview(id) == self.wanted(id).as_ref();
        self.document.panes.shown().into_iter().all(is_seen)
    }

    pub fn slope_in_picture(self, id: PaneId) -> Option<Slope> {
        self.picture_in(id).filter(|picture| picture.request.minus().is_none())?.request.kind.slope()
    }

    pub fn range_class(self, id: PaneId) -> RangeClass {
        let picture = self.picture_in(id);
        let wanted = || self.wanted(id).map_or(RangeClass::Intensity, |wanted| RangeClass::of(&wanted));
        picture.map_or_else(wanted, |picture| RangeClass::of(&picture.request))
    }

    pub fn has_colour_bar(self, id: PaneId) -> bool {
        use RangeClass::{Difference, Frame, Intensity, Response};
        self.picture_in(id).is_some() && !matches!(self.range_class(id), Frame | Intensity | Response | Difference)
    }

    pub fn display_of(self, id: PaneId) -> Display {
        let ranges = self.pane(id).map_or(&self.document.look.ranges, |pane| self.document.ranges_of(pane));
        ranges.display(self.range_class(id))
    }

    pub fn film_to_export(self) -> Option<Film> {
        let side = self.active_side();
        let burst = self.burst_of(side)?.clone();
        let found = self.found_of(side);
        let params = found.map_or_else(|| self.results.slots[side].usable_params.clone(), |found| found.params.clone());
        let grid = params.used_slopes();
        // The slopes of the grid, and those half-way between.
        let count = |axis: &SlopeAxis| (2 * axis.count - 1).min(MAX_FILM_PICTURES);
        let sweep = match self.document.film.content {
            FilmContent::Scales => Sweep::Scale,
            FilmContent::Slopes if grid.u.count > 1 => Sweep::SlopeU(grid.u.min, grid.u.max, count(&grid.u)),
            FilmContent::Slopes if grid.v.count > 1 => Sweep::SlopeV(grid.v.min, grid.v.max, count(&grid.v)),
            FilmContent::Slopes | FilmContent::Frames => Sweep::Frames,
        };
        let detection = found.map(|found| found.detection.clone());
        let (slope, max_side_px) = (self.document.cursor().slope, self.document.film.max_side_px);
        Some(Film { burst, params, sweep, slope, detection, max_side_px })
    }
}
