//! Reduced frames for the slope finder: means over squares of pixels.
//!
//! The finder works at σ of about two to eight pixels, and coarser structure needs fewer samples. Level `l` has pixels
//! of 2^l image pixels; a level pixel's value is the mean of the image pixels that it covers.

use crate::monitor::{Cancelled, Monitor};
use crate::plane::Plane;
use multiversion::multiversion;
use rayon::prelude::*;
use std::ops::Range;

/// Number of pixels up to which images are examined from level 0 on.
const SMALL_PIXELS: usize = 25_000;
/// Number of pixels up to which images are examined from level 1 on, larger ones from level 2 on: so the finder costs a
/// small part of a detection.
const MEDIUM_PIXELS: usize = 270_000;
/// Maximum number of levels.
const LEVELS: u32 = 3;

/// Levels at which an image of `size` is examined: those of [`LEVELS`] whose sides are at least `min_side` level
/// pixels.
pub(super) fn levels_for((width, height): (usize, usize), min_side: usize) -> Range<u32> {
    let larger_than = |pixels: usize| u32::from(width * height > pixels);
    let first = larger_than(SMALL_PIXELS) + larger_than(MEDIUM_PIXELS);
    let fits = |level: &u32| (width.min(height) >> level) >= min_side;
    let first = (0..=first).rev().find(fits).unwrap_or(0);
    first..first + (first..first + LEVELS).take_while(fits).count() as u32
}

/// Computes every frame at each of `levels`.
///
/// # Errors
/// [`Cancelled`] once `monitor` was cancelled.
pub(super) fn pyramids(frames: &[&Plane], levels: Range<u32>, monitor: &Monitor) -> Result<Vec<Vec<Plane>>, Cancelled> {
    let of_frames: Vec<Vec<Plane>> = frames
        .par_iter()
        .map(|frame| {
            monitor.check()?;
            let mut planes: Vec<Plane> = Vec::with_capacity(levels.len());
            for level in levels.clone() {
                let next = match planes.last() {
                    Some(finer) => means(finer, 2),
                    None => means(frame, 1 << level),
                };
                planes.push(next);
            }
            Ok(planes)
        })
        .collect::<Result<_, Cancelled>>()?;
    let mut by_level: Vec<Vec<Plane>> = levels.map(|_| Vec::with_capacity(frames.len())).collect();
    for planes in of_frames {
        for (level, plane) in by_level.iter_mut().zip(planes) {
            level.push(plane);
        }
    }
    Ok(by_level)
}

/// Means over squares of `side` × `side` pixels; left-over pixels at the right and below are dropped.
fn means(plane: &Plane, side: usize) -> Plane {
    let (width, height) = (plane.width() / side, plane.height() / side);
    let mut out = Plane::zeros(width, height);
    let mut sums = vec![0.0; width * side];
    for (v, row) in out.data_mut().chunks_exact_mut(width.max(1)).enumerate() {
        sums.copy_from_slice(&plane.row(v * side)[..width * side]);
        (1..side).for_each(|i| add_row(&mut sums, plane.row(v * side + i)));
        mean_row(row, &sums, side);
    }
    out
}

#[multiversion(targets("x86_64+avx2+fma", "aarch64+neon"))]
fn add_row(sums: &mut [f32], row: &[f32]) {
    sums.iter_mut().zip(row).for_each(|(sum, x)| *sum += x);
}

#[multiversion(targets("x86_64+avx2+fma", "aarch64+neon"))]
fn mean_row(row: &mut [f32], sums: &[f32], side: usize) {
    let scale = 1.0 / (side * side) as f32;
    match side {
        2 => row.iter_mut().zip(sums.chunks_exact(2)).for_each(|(x, s)| *x = (s[0] + s[1]) * scale),
        4 => row.iter_mut().zip(sums.chunks_exact(4)).for_each(|(x, s)| *x = ((s[0] + s[1]) + (s[2] + s[3])) * scale),
        _ => row.iter_mut().zip(sums.chunks_exact(side)).for_each(|(x, s)| *x = s.iter().sum::<f32>() * scale),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_level_holds_the_means_of_its_squares() {
        let frame = Plane::from_fn(43, 38, |u, v| (u * 3 + v * 7 % 5) as f32);
        let levels = pyramids(&[&frame, &frame], 1..3, &Monitor::default()).expect("not cancelled");
        assert_eq!((levels.len(), levels[0].len()), (2, 2));
        for (plane, side) in levels.iter().map(|l| &l[1]).zip([2, 4]) {
            assert_eq!(plane.size(), (43 / side, 38 / side));
            let sum: f32 = (0..side * side).map(|i| frame.at(2 * side + i % side, 3 * side + i / side)).sum();
            assert!((plane.at(2, 3) - sum / (side * side) as f32).abs() < 1e-4);
        }
    }

    #[test]
    fn levels_suit_the_size_and_never_get_too_small() {
        assert_eq!(levels_for((120, 160), 32), 0..2);
        assert_eq!(levels_for((480, 360), 32), 1..4);
        assert_eq!(levels_for((1600, 1200), 32), 2..5);
        assert_eq!(levels_for((4000, 40), 32), 0..1);
        assert!(levels_for((31, 500), 32).is_empty());
    }
}
