//! Pictures of a burst, and how they are computed: a frame, a motion stack, a DoG response, a map, the merged frames,
//! or a difference of two.

use super::{
    BurstId, Caches, JobError, MotionMap, OpenBurst, PREVIEW_OCTAVES, PictureKind, RangeClass, Request, Urgency,
    ViewKind, Work, locked,
};
use crate::baseline::merge_burst;
use crate::detect::prepare;
use crate::detector::stack::motion_stack;
use crate::detector::view::{
    combined_view, coverage_view, dog_view, field_view, gate_noise_map, in_focus_view, stack_part_view, stack_view,
};
use crate::detector::{DetectorParams, Feature, FrameRange, Interpolation, Method, Scale};
use crate::detector::{field::NO_FIELD, params::Stage, scale_space::octave_size};
use crate::inspect::place::winning_slopes;
use crate::monitor::{Cancelled, Monitor};
use crate::plane::blur::smoothed;
use crate::plane::display::{Display, to_rgba8};
use crate::plane::sample::difference;
use crate::plane::statistics::Region;
use crate::plane::{Mask, Plane};
use image::RgbaImage;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::mem::{Discriminant, discriminant};
use std::sync::Arc;
use std::time::Duration;

/// Least number of pixels of a frame with previews: the whole picture takes longer than a tenth of a second.
const PREVIEWED_PX: usize = 3_000_000;

/// Part of a picture that a preview shows.
#[derive(Debug, Clone, PartialEq)]
pub struct Preview {
    pub octave: i32,
    /// Place in the picture, in pixels of the octave.
    pub region: Region,
}

impl RangeClass {
    pub fn of(request: &PictureRequest) -> Self {
        if request.minus().is_some() { Self::Difference } else { request.kind.about().range }
    }
}

#[derive(Debug, Clone)]
pub struct PictureRequest {
    pub burst: OpenBurst,
    pub kind: PictureKind,
    /// The parameters; only those that decide the picture make two requests differ.
    pub params: DetectorParams,
    /// Standard deviation of the Gaussian by which it is smoothed for looking at it, input pixels; 0 for none.
    pub smoothing_px: f32,
    /// Preview that is made first; it decides nothing about the picture.
    pub preview: Option<Preview>,
    minus: Option<Box<PictureRequest>>,
}

/// Key of a picture: two requests with equal keys give the same picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) struct PictureKey {
    burst: BurstId,
    kind: KindKey,
    minus: Option<(BurstId, KindKey)>,
    smoothing_bits: u32,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct KindKey {
    kind: Discriminant<PictureKind>,
    frame: Option<usize>,
    map: Option<ViewKind>,
    slope_bits: Option<(u32, u32)>,
    scale: Option<Scale>,
    params: u64,
}

impl PictureRequest {
    pub fn new(burst: OpenBurst, kind: PictureKind, params: DetectorParams) -> Self {
        Self { burst, kind, params, smoothing_px: 0.0, preview: None, minus: None }
    }

    /// By a Gaussian of `sigma_px` input pixels; unchanged where the values are no brightnesses or responses.
    #[must_use]
    pub fn smoothed(self, sigma_px: f32) -> Self {
        let is_smooth = matches!(RangeClass::of(&self), RangeClass::Noise | RangeClass::Share | RangeClass::Motion);
        Self { smoothing_px: if is_smooth { 0.0 } else { sigma_px }, ..self }
    }

    /// On this picture's pixels. Of a difference that is subtracted, or subtracted from, the first picture counts.
    #[must_use]
    pub fn less(self, other: &Self) -> Self {
        Self { minus: Some(Box::new(other.alone())), ..self }
    }

    pub fn minus(&self) -> Option<&Self> {
        self.minus.as_deref()
    }

    /// The picture without what is subtracted from it, and without smoothing.
    #[must_use]
    pub fn alone(&self) -> Self {
        Self { minus: None, smoothing_px: 0.0, preview: None, ..self.clone() }
    }

    /// With a preview of the part between the corners `seen` (u, v) at the resolution at which it is seen, if that is
    /// cheap: of the sum of large frames without masks.
    #[must_use]
    pub fn previewed(self, points_per_pixel: f32, seen: [[f32; 2]; 2]) -> Self {
        let octave = ((1.0 / points_per_pixel).log2().ceil() as i32).min(PREVIEW_OCTAVES[2]);
        let octave = if PREVIEW_OCTAVES.contains(&octave) { octave } else { 0 };
        let is_sum = matches!(self.kind, PictureKind::Stack { .. }) && self.params.method == Method::Buff;
        let size = self.burst.burst.size();
        let range = |axis: usize, count: usize| {
            let [from, to] = seen.map(|corner| (corner[axis] / (octave as f32).exp2()).max(0.0) as usize);
            // A pixel at the rim is seen in part.
            from.min(count)..(to + 2).min(count)
        };
        let (columns, rows) = octave_size(size, octave);
        let region = Region { columns: range(0, columns), rows: range(1, rows) };
        let is_part = octave > 0 || 2 * region.len() < columns * rows;
        let is_masked = || self.burst.burst.frames.iter().any(|frame| frame.mask().is_some());
        let is_cheap = size.0 * size.1 >= PREVIEWED_PX && is_part && is_sum && self.minus.is_none() && !is_masked();
        Self { preview: is_cheap.then_some(Preview { octave, region }), ..self }
    }

    pub(crate) fn key(&self) -> PictureKey {
        let minus = self.minus().map(|minus| (minus.burst.id, minus.kind_key()));
        PictureKey { burst: self.burst.id, kind: self.kind_key(), minus, smoothing_bits: self.smoothing_px.to_bits() }
    }

    fn kind_key(&self) -> KindKey {
        KindKey {
            kind: discriminant(&self.kind),
            frame: if let PictureKind::Frame(index) = self.kind { Some(index) } else { None },
            map: if let PictureKind::Map { map, .. } = self.kind { Some(map) } else { None },
            // Adding 0 makes −0 and 0 one slope.
            slope_bits: self.kind.slope().map(|slope| ((slope.u + 0.0).to_bits(), (slope.v + 0.0).to_bits())),
            scale: self.kind.scale(),
            params: self.kind.about().stage.map_or(0, |stage| self.hash_of_params(stage)),
        }
    }

    /// Before the search, methods differ only in their frames and in whether these are merged.
    fn hash_of_params(&self, stage: Stage) -> u64 {
        let mut params = self.params.clone();
        if stage < Stage::Search {
            let used = params.used_frames(self.burst.burst.len());
            params.frames = Some(FrameRange { start: used.start, end: used.end });
            if params.method != Method::Merge || stage == Stage::Frames {
                params.method = Method::Buff;
            }
        }
        let mut hasher = DefaultHasher::new();
        params.deciding(stage).hash(&mut hasher);
        hasher.finish()
    }
}

#[derive(Debug, Clone)]
pub struct PictureAnswer {
    pub request: PictureRequest,
    /// Pixels, fraction of full scale.
    pub plane: Arc<Plane>,
    /// Pixels as drawn: `plane`, or smoothed.
    pub drawn: Arc<Plane>,
    pub motion: Option<Arc<MotionMap>>,
    /// Part that is shown of it, where this is a preview, whose values are not the picture's.
    pub preview: Option<Preview>,
}

impl PictureAnswer {
    pub fn bytes(&self) -> usize {
        let pixels = std::mem::size_of_val(self.plane.data());
        // Motions take three times as much as the plane: slope and certainty are three floats.
        let drawn = if Arc::ptr_eq(&self.plane, &self.drawn) { 0 } else { pixels };
        drawn + if self.motion.is_some() { 4 * pixels } else { pixels }
    }

    /// One opaque pixel for each value, in `display`'s range and colours; motions coloured as those of `features`.
    pub fn rgba(&self, display: &Display, features: &[Feature]) -> RgbaImage {
        self.motion.as_ref().map_or_else(|| to_rgba8(&self.drawn, display), |motion| motion.colours(features))
    }

    /// Between the pixels `other` is taken linearly; beside it the difference is NaN.
    pub(crate) fn minus(&self, other: &Self) -> Self {
        // Pictures of different octaves have pixels of different sizes.
        let (step, step_other) = (self.request.kind.input_px_per_pixel(), other.request.kind.input_px_per_pixel());
        let plane = Arc::new(difference(&self.plane, &other.plane, step / step_other));
        let request = self.request.alone().less(&other.request);
        Self { request, drawn: plane.clone(), plane, motion: None, preview: None }
    }

    pub(crate) fn smoothed(self, sigma_px: f32, monitor: &Monitor) -> Result<Self, Cancelled> {
        let sigma = f64::from(sigma_px / self.request.kind.input_px_per_pixel());
        let drawn = Arc::new(smoothed(&self.plane, sigma, monitor)?);
        Ok(Self { drawn, request: self.request.smoothed(sigma_px), ..self })
    }
}

fn plain(request: PictureRequest, work: &Work<'_, PictureAnswer>) -> Result<PictureAnswer, JobError> {
    let (trails, monitor) = (&work.caches.trails, work.monitor);
    let mut motion = None;
    let no_field = || JobError::failed(NO_FIELD);
    let burst = &request.burst.burst;
    let plane = match request.kind {
        PictureKind::Frame(index) => burst.frames.get(index).cloned().ok_or_else(|| {
            JobError::Failed(format!("there is no frame {index}; the burst has {} frames", burst.len()))
        })?,
        PictureKind::Stack { slope } => {
            // A method on merged frames searches one merged frame, which is then the picture.
            let (burst, params) = prepare(burst, &request.params, monitor)?;
            Arc::new(stack_view(&burst, &params, slope, monitor)?)
        }
        PictureKind::Dog { octave, level, slope } => {
            let (burst, params) = prepare(burst, &request.params, monitor)?;
            Arc::new(dog_view(&burst, &params, slope, octave, level, monitor)?)
        }
        PictureKind::Merge => {
            let used = request.params.used_frames(burst.len());
            if used.is_empty() || used.end > burst.len() {
                let wrong =
                    format!("frames {}..{} cannot be merged; the burst has {}", used.start, used.end, burst.len());
                return Err(JobError::Failed(wrong));
            }
            merge_burst(burst, used, monitor)?.frames[0].clone()
        }
        // The search's own trail has the winners: their SNR is the picture, their slopes are its colours.
        PictureKind::Map { map: ViewKind::Motion, octave, level, .. } => {
            let cache = trails.get_or_make_for(&request.burst, &request.params, monitor)?;
            let winning = winning_slopes(&cache.trail, octave, level, monitor)?;
            motion = Some(Arc::new(MotionMap::winning(&winning, &request.params.used_slopes())));
            Arc::new(winning.snr)
        }
        PictureKind::Map { map: ViewKind::Field, .. } => {
            let field = field_view(burst, &request.params, monitor)?.ok_or_else(no_field)?;
            let lengths = Arc::new(field.magnitudes(burst.size()));
            motion = Some(Arc::new(MotionMap::field(field, burst.size(), &request.params.used_slopes())));
            lengths
        }
        PictureKind::Map { map: ViewKind::InFocus, .. } => {
            Arc::new(in_focus_view(burst, &request.params, monitor)?.ok_or_else(no_field)?)
        }
        PictureKind::Map { map, octave, level, slope } => {
            let (burst, params) = prepare(burst, &request.params, monitor)?;
            Arc::new(match map.about().combine {
                Some(combine) => combined_view(&burst, &params, slope, combine, monitor)?,
                None if map == ViewKind::Coverage => coverage_view(&burst, &params, slope, monitor)?,
                None => gate_noise_map(&burst, &params, slope, octave, level, monitor)?,
            })
        }
    };
    let plane = with_unseen(plane, &request, monitor)?;
    Ok(PictureAnswer { request, drawn: plane.clone(), plane, motion, preview: None })
}

/// Shows what is seen of the stack first, where that is asked for.
fn preview(request: &PictureRequest, work: &Work<'_, PictureAnswer>) -> Result<(), Cancelled> {
    let (PictureKind::Stack { slope }, Some(Preview { octave, region })) = (request.kind, &request.preview) else {
        return Ok(());
    };
    let (burst, frames) = (&request.burst.burst, request.burst.frames_on(*octave));
    let plane = stack_part_view((burst, &frames), &request.params, slope, (*octave, region), work.monitor)?;
    let sigma_px = request.smoothing_px / (*octave as f32).exp2();
    let plane = Arc::new(smoothed(&plane, sigma_px.into(), work.monitor)?);
    let preview = request.preview.clone();
    (work.tell)(PictureAnswer { request: request.clone(), drawn: plane.clone(), plane, motion: None, preview });
    Ok(())
}

/// `plane` with a mask over the pixels that no frame shows at the slope: their values come from filled pixels.
fn with_unseen(plane: Arc<Plane>, request: &PictureRequest, monitor: &Monitor) -> Result<Arc<Plane>, Cancelled> {
    let burst = &request.burst.burst;
    let used = request.params.used_frames(burst.len());
    let masks = burst.frames[used.clone()].iter().map(|frame| frame.mask().map(|mask| mask.weights()));
    let is_frame = matches!(request.kind, PictureKind::Frame(_)) || plane.mask().is_some();
    let Some(masks) = masks.collect::<Option<Vec<_>>>().filter(|masks| !masks.is_empty() && !is_frame) else {
        return Ok(plane);
    };
    let (slope, positions) = (request.kind.slope().unwrap_or_default(), burst.positions.part(used));
    let seen = motion_stack(&masks, &positions, slope, Interpolation::Linear, monitor)?;
    // At least one frame has to show the place by half.
    let (step, least) = (request.kind.input_px_per_pixel(), 0.5 / masks.len() as f32);
    let at = |x: usize, count: usize| ((x as f32 * step).round() as usize).min(count - 1);
    let weight = |u, v| f32::from(seen.at(at(u, seen.width()), at(v, seen.height())) >= least);
    let mut masked = Plane::clone(&plane).masked(Mask::new(Plane::from_fn(plane.width(), plane.height(), weight)));
    // `masked` would fill the hidden pixels again from around.
    masked.data_mut().copy_from_slice(plane.data());
    Ok(Arc::new(masked))
}

impl Request for PictureRequest {
    type Answer = PictureAnswer;
    type Partial = PictureAnswer;

    fn urgency(&self) -> Urgency {
        let own = if self.kind.about().is_slow { Urgency::SlowPicture } else { Urgency::Picture };
        self.minus().map_or(own, |minus| own.max(minus.urgency()))
    }

    fn cached(&self, caches: &Caches) -> Option<PictureAnswer> {
        locked(&caches.pictures).get(self)
    }

    /// With a preview, a superseded picture ends soon after it: the next one is as quick.
    fn grace(&self) -> Duration {
        Duration::from_millis(if self.preview.is_some() { 60 } else { 250 })
    }

    fn compute(self, work: &Work<'_, PictureAnswer>) -> Result<PictureAnswer, JobError> {
        if let Some(picture) = self.cached(&work.caches) {
            return Ok(picture);
        }
        preview(&self, work)?;
        let picture = match self.minus().cloned() {
            // The picture without smoothing is kept too, for another one.
            _ if self.smoothing_px > 0.0 => {
                let sigma_px = self.smoothing_px;
                self.smoothed(0.0).compute(work)?.smoothed(sigma_px, work.monitor)?
            }
            None => plain(self, work)?,
            // Both pictures are kept too: they are mostly shown beside their difference.
            Some(minus) => self.alone().compute(work)?.minus(&minus.compute(work)?),
        };
        locked(&work.caches.pictures).insert(&picture);
        Ok(picture)
    }
}
