//! Computation of pictures.

use super::{
    Caches, JobError, MotionMap, PictureAnswer, PictureKind, PictureRequest, Preview, Request, Urgency, ViewKind, Work,
    locked,
};
use crate::baseline::merge_burst;
use crate::detect::prepare;
use crate::detector::Interpolation;
use crate::detector::field::NO_FIELD;
use crate::detector::stack::motion_stack;
use crate::detector::view::{
    combined_view, coverage_view, dog_view, field_view, gate_noise_map, in_focus_view, stack_part_view, stack_view,
};
use crate::inspect::place::winning_slopes;
use crate::monitor::{Cancelled, Monitor};
use crate::plane::blur::smoothed;
use crate::plane::{Mask, Plane};
use std::sync::Arc;
use std::time::Duration;

/// Computes a picture that is not a difference.
fn plain(request: PictureRequest, work: &Work<'_, PictureAnswer>) -> Result<PictureAnswer, JobError> {
    let (trails, monitor) = (&work.caches.trails, work.monitor);
    let mut motion = None;
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
            let snr = Arc::new(winning.snr.clone());
            motion = Some(Arc::new(MotionMap::winning(&winning, &request.params.used_slopes())));
            snr
        }
        PictureKind::Map { map: ViewKind::Field, .. } => {
            let grid = request.params.used_slopes();
            let Some(field) = field_view(burst, &request.params, monitor)? else {
                return Err(JobError::Failed(NO_FIELD.to_owned()));
            };
            let lengths = Arc::new(field.magnitudes(burst.size()));
            motion = Some(Arc::new(MotionMap::field(field, burst.size(), &grid)));
            lengths
        }
        PictureKind::Map { map: ViewKind::InFocus, .. } => {
            let in_focus = in_focus_view(burst, &request.params, monitor)?;
            Arc::new(in_focus.ok_or_else(|| JobError::Failed(NO_FIELD.to_owned()))?)
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
