//! Thumbnails of bursts, for a list of many bursts.

use super::picture::stretched;
use crate::burst::{Burst, BurstFiles, OpenError, OpenOptions};
use crate::monitor::Monitor;
use crate::plane::Plane;
use crate::plane::display::to_rgba8;

/// Small picture, 8-bit RGB.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Thumbnail {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Red, green, blue of each pixel, row by row.
    pub rgb: Vec<u8>,
}

/// The middle frame of `source`, opened with `options`, stretched so that dark content is visible, and reduced by a
/// whole factor so that no side is longer than `max_side_px` (1 or more). Where each frame is a file, no other is read.
///
/// # Errors
/// See [`OpenError`].
pub fn thumbnail(
    source: &BurstFiles,
    max_side_px: usize,
    options: &OpenOptions,
    monitor: &Monitor,
) -> Result<Thumbnail, OpenError> {
    let files = source.files()?;
    let middle = files.get(files.len() / 2).ok_or(OpenError::NothingGiven)?;
    let burst = Burst::open_with(std::slice::from_ref(middle), options, monitor)?;
    let plane = reduced(&burst.frames[burst.len() / 2], max_side_px.max(1));
    let shown = to_rgba8(&plane, &stretched(&plane));
    let rgb = shown.pixels().flat_map(|p| [p[0], p[1], p[2]]).collect();
    Ok(Thumbnail { width: plane.width(), height: plane.height(), rgb })
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

    #[test]
    fn the_middle_frame_is_shown_and_a_broken_one_named() {
        let home = tempfile::tempdir().expect("a folder");
        for t in 0..3u8 {
            let frame = image::GrayImage::from_fn(8, 4, |u, _| image::Luma([if t == 1 && u > 3 { 40 } else { 10 }]));
            frame.save(home.path().join(format!("{t}.png"))).expect("written");
        }
        let source = BurstFiles { name: "b".into(), paths: vec![home.path().into()] };
        // A frame minus itself as the bias frame is empty.
        let options = OpenOptions { bias: Some(home.path().join("1.png")), ..OpenOptions::default() };
        let dark = thumbnail(&source, 4, &options, &Monitor::default()).expect("a picture");
        assert!(dark.rgb.iter().all(|value| *value == dark.rgb[0]));
        let shown = thumbnail(&source, 4, &OpenOptions::default(), &Monitor::default()).expect("a picture");
        assert_eq!((shown.width, shown.height, shown.rgb.len()), (4, 2, 24));
        assert_eq!((shown.rgb[0], shown.rgb[9]), (0, 255), "a dark frame is stretched");
        std::fs::write(home.path().join("1.png"), "no picture").expect("written");
        let error =
            thumbnail(&source, 4, &OpenOptions::default(), &Monitor::default()).expect_err("broken").to_string();
        assert!(error.contains("1.png"), "{error}");
    }
}
