//! The picture of a burst for programs that take one image: of 8 bit, stretched so that a dark one can be seen.

use super::DatasetError;
use crate::burst::Burst;
use crate::detector::DetectorParams;
use crate::export::{Picture, write_png};
use crate::monitor::Monitor;
use crate::plane::Plane;
use crate::plane::display::{Display, to_rgba8};
use crate::plane::statistics::{Region, percentiles};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// What a burst's picture shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ImageKind {
    /// The middle frame of those used, which lies at the features' reference time (half a frame after it for an even number of frames).
    #[default]
    Middle,
}

/// The percentiles of the pixels that become black and white.
const BLACK_WHITE_PERCENT: [f32; 2] = [0.1, 99.9];

/// Writes the picture of `burst` to `path` as PNG.
pub(super) fn write_picture(
    path: &Path,
    burst: &Burst,
    kind: ImageKind,
    params: &DetectorParams,
    monitor: &Monitor,
) -> Result<(), DatasetError> {
    monitor.check()?;
    let plane = match kind {
        ImageKind::Middle => {
            let used =
                DetectorParams { method: crate::detector::Method::Sift, ..params.clone() }.used_frames(burst.len());
            burst.frames[used.start].clone()
        }
    };
    let shown = to_rgba8(&plane, &stretched(&plane));
    let rgb: Vec<u8> = shown.pixels().flat_map(|p| [p[0], p[1], p[2]]).collect();
    Ok(write_png(path, Picture::rgb(plane.width(), plane.height(), &rgb))?)
}

/// The range that shows nearly all pixels.
pub(super) fn stretched(plane: &Plane) -> Display {
    match percentiles(plane, &Region::whole(plane), &BLACK_WHITE_PERCENT).as_deref() {
        Some([black, white]) => Display::default().with_range(*black, *white),
        _ => Display::default(),
    }
}
