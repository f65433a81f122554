//! Pictures of bursts, 8 bit, stretched so that dark content is visible: for other programs, and as thumbnails.

use crate::burst::{Burst, BurstFiles, OpenOptions, ViewsChoice};
use crate::detector::view::{in_focus_view, stack_view};
use crate::detector::{DetectorParams, Method};
use crate::error::{Error, Result};
use crate::plane::display::{Display, to_rgba8};
use crate::{detect::prepare, export::Bitmap, monitor::Monitor, plane::Plane};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Content of a burst's picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
#[serde(rename_all = "lowercase")]
pub enum ImageKind {
    /// Middle frame of those used: at the features' reference time, half a frame later for an even number of frames.
    #[default]
    Middle,
    /// The used frames, merged at the middle one: makes the content of a dark burst visible.
    Merged,
    /// The used frames, each place stacked along its own motion at mid-burst, the features' reference time; at the
    /// middle one of the slopes where no field of motion is found.
    Stack,
}

impl ImageKind {
    /// Checks that the picture shows the time of the features that `method` finds.
    pub(super) fn check(self, method: Method) -> Result<()> {
        if self != Self::Stack || method == Method::Buff {
            return Ok(());
        }
        let problem = "a stack shows mid-burst, and this method finds features in the middle frame";
        Err(Error::param("images", problem, "give middle or merged, or leave --method out"))
    }
}

/// 8-bit picture, three bytes for each pixel.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BurstPicture {
    /// Size (columns, rows).
    pub size: (usize, usize),
    /// Red, green, blue of each pixel, row by row.
    pub rgb: Vec<u8>,
}

impl BurstPicture {
    /// The picture in the form for writing.
    pub fn picture(&self) -> Bitmap<'_> {
        Bitmap::rgb(self.size.0, self.size.1, &self.rgb)
    }

    /// A picture of `plane`, reduced by a whole factor so that no side is longer than `max_side_px` (1 or more).
    pub fn small(plane: &Plane, max_side_px: usize) -> Self {
        Self::of(&reduced(plane, max_side_px.max(1)))
    }

    pub(super) fn of(plane: &Plane) -> Self {
        let rgb = to_rgba8(plane, &Display::stretched(plane)).pixels().flat_map(|p| [p[0], p[1], p[2]]).collect();
        Self { size: plane.size(), rgb }
    }

    pub(super) fn of_mask(plane: &Plane) -> Self {
        let (width, height) = plane.size();
        let at = |index: usize| if plane.weight_at(index % width, index / width) < 0.5 { 0 } else { 255 };
        Self { size: (width, height), rgb: (0..width * height).flat_map(|index| [at(index); 3]).collect() }
    }
}

/// Values of the picture of `burst` from the frames that `params` use, with its mask: of a stack that of the middle
/// frame.
///
/// # Errors
/// Frames that the burst does not have, a stack for a method of one frame, or cancellation.
pub fn burst_plane(burst: &Burst, kind: ImageKind, params: &DetectorParams, monitor: &Monitor) -> Result<Arc<Plane>> {
    monitor.check()?;
    kind.check(params.method)?;
    let method = if kind == ImageKind::Merged { Method::Merge } else { Method::Sift };
    let (of_one, one) = prepare(burst, &DetectorParams { method, ..params.clone() }, monitor)?;
    let frame = &of_one.frames[one.used_frames(of_one.len()).start];
    if kind != ImageKind::Stack {
        return Ok(frame.clone());
    }
    let slopes = params.used_slopes();
    let middle = slopes.slopes().nth(slopes.len() / 2).unwrap_or_default();
    let stack = match in_focus_view(burst, params, monitor)? {
        Some(stack) => stack,
        None => stack_view(burst, params, middle, monitor)?,
    };
    Ok(Arc::new(stack.masked(frame.mask().cloned())))
}

/// The middle frame of `source`, reduced by a whole factor to sides of at most `max_side_px`; no other one is read.
pub fn thumbnail(
    source: &BurstFiles,
    max_side_px: usize,
    options: &OpenOptions,
    monitor: &Monitor,
) -> Result<BurstPicture> {
    let files = source.files()?;
    let middle = files.get(files.len() / 2).ok_or_else(Error::nothing_given)?;
    // One of several files is no grid of views.
    let views = options.views.filter(|views| matches!(views, ViewsChoice::Picture(..)));
    let options = OpenOptions { mask: None, mask_saturated: false, views, ..options.clone() };
    let burst = Burst::open_with(std::slice::from_ref(middle), &options, monitor)?;
    Ok(BurstPicture::small(&burst.frames[burst.len() / 2], max_side_px))
}

/// Means of square blocks; columns and rows at the end that do not fill a block are left out.
fn reduced(plane: &Plane, max_side_px: usize) -> Plane {
    let (width, height) = plane.size();
    let factor = width.max(height).div_ceil(max_side_px);
    // The factor is limited to the shorter side, so that a very long picture keeps some pixels.
    let (factor_u, factor_v) = (factor.min(width), factor.min(height));
    let count = (factor_u * factor_v) as f32;
    Plane::from_fn(width / factor_u, height / factor_v, |u, v| {
        let row = |dv: usize| &plane.row(v * factor_v + dv)[u * factor_u..(u + 1) * factor_u];
        (0..factor_v).map(|dv| row(dv).iter().sum::<f32>()).sum::<f32>() / count
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_are_averaged_and_no_side_is_too_long() {
        let plane = Plane::from_fn(10, 7, |u, v| (u + 10 * v) as f32);
        let small = reduced(&plane, 4);
        // The factor is 3; the block at the origin holds 0, 1, 2, 10, …, 22.
        assert_eq!((small.size(), small.at(0, 0), small.at(2, 1)), ((3, 2), 11.0, 47.0));
        assert_eq!(reduced(&plane, 10).data(), plane.data());
        assert_eq!(reduced(&Plane::zeros(900, 1), 100).size(), (100, 1));
    }
}
