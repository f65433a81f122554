//! The picture of a burst for programs that take one image: 8 bit, stretched so that dark content is visible.

use super::DatasetError;
use crate::baseline::prepare;
use crate::burst::Burst;
use crate::detector::{DetectError, DetectorParams, Method};
use crate::export::{Picture, write_png};
use crate::monitor::Monitor;
use crate::plane::Plane;
use crate::plane::display::{Display, to_rgba8};
use crate::plane::statistics::{Region, percentiles};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Content of a burst's picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ImageKind {
    /// Middle frame of those used, which lies at the features' reference time (half a frame after it for an even number
    /// of frames).
    #[default]
    Middle,
    /// The used frames, merged at the middle one: makes the content of a dark burst visible.
    Merged,
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
    pub fn picture(&self) -> Picture<'_> {
        Picture::rgb(self.size.0, self.size.1, &self.rgb)
    }
}

/// Percentiles of the pixels that become black and white.
const BLACK_WHITE_PERCENT: [f32; 2] = [0.1, 99.9];

/// Makes the picture of `burst` from the frames that `params` use.
///
/// # Errors
/// Frames that the burst does not have, or cancellation.
pub fn burst_picture(
    burst: &Burst,
    kind: ImageKind,
    params: &DetectorParams,
    monitor: &Monitor,
) -> Result<BurstPicture, DetectError> {
    monitor.check()?;
    let method = match kind {
        ImageKind::Middle => Method::Sift,
        ImageKind::Merged => Method::Merge,
    };
    let params = DetectorParams { method, ..params.clone() };
    let (burst, params) = prepare(burst, &params, monitor)?;
    let plane = &burst.frames[params.used_frames(burst.len()).start];
    let shown = to_rgba8(plane, &stretched(plane));
    Ok(BurstPicture { size: plane.size(), rgb: shown.pixels().flat_map(|p| [p[0], p[1], p[2]]).collect() })
}

/// Writes the picture of `burst` to `path` as PNG.
pub(super) fn write_picture(
    path: &Path,
    burst: &Burst,
    kind: ImageKind,
    params: &DetectorParams,
    monitor: &Monitor,
) -> Result<(), DatasetError> {
    Ok(write_png(path, burst_picture(burst, kind, params, monitor)?.picture())?)
}

/// The display range that covers nearly all pixels.
pub(super) fn stretched(plane: &Plane) -> Display {
    match percentiles(plane, &Region::whole(plane), &BLACK_WHITE_PERCENT).as_deref() {
        Some([black, white]) => Display::default().with_range(*black, *white),
        _ => Display::default(),
    }
}
