//! Two pictures side by side with their matches as lines between them, as PNG.
//!
//! Inliers are solid and yellow, other matches dashed and vermilion (of M. Okabe and K. Ito's palette, which
//! colour-blind readers can tell apart), under the inliers. Each end is a small ring. A match's ends are at (u + ½, v +
//! ½) of the drawing, where the first pixel's centre is at (0.5, 0.5).

use super::png::{Picture, write_png};
use crate::error::Error;
use crate::plane::memory;
use std::path::Path;

/// A match to be drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MatchLine {
    /// (u, v) in picture A, pixels.
    pub a: [f64; 2],
    /// (u, v) in picture B, pixels.
    pub b: [f64; 2],
    /// Whether it is an inlier.
    pub inlier: bool,
}

/// Distance between the pictures, pixels.
pub const PICTURE_GAP_PX: usize = 8;
/// Colour of inliers.
pub const INLIER_COLOR: [u8; 3] = [240, 228, 66];
/// Colour of the other matches.
pub const OUTLIER_COLOR: [u8; 3] = [213, 94, 0];
const HALF_WIDTH_PX: f64 = 0.6;
const RING_PX: f64 = 2.5;
/// Length of a dash and of the gap after it, pixels.
const DASH_PX: (f64, f64) = (7.0, 5.0);
const BACKGROUND: [u8; 3] = [32, 32, 32];

/// Writes the picture: A on the left, B on the right. Lines with numbers not finite or beyond 10⁶ are left out.
pub fn write_match_picture(path: &Path, a: Picture<'_>, b: Picture<'_>, lines: &[MatchLine]) -> Result<(), Error> {
    a.check_size(path)?;
    b.check_size(path)?;
    let right = a.size().0 + PICTURE_GAP_PX;
    let mut canvas = Canvas::new(right + b.size().0, a.size().1.max(b.size().1));
    canvas.paste(a, 0);
    canvas.paste(b, right);
    let drawable = |line: &&MatchLine| line.a.iter().chain(&line.b).all(|x| x.abs() < 1e6);
    for inliers in [false, true] {
        let color = if inliers { INLIER_COLOR } else { OUTLIER_COLOR };
        for line in lines.iter().filter(drawable).filter(|line| line.inlier == inliers) {
            let from = (line.a[0] + 0.5, line.a[1] + 0.5);
            let to = (line.b[0] + 0.5 + right as f64, line.b[1] + 0.5);
            canvas.line(from, to, color, !inliers);
            canvas.ring(from, color);
            canvas.ring(to, color);
        }
    }
    write_png(path, Picture::rgb(canvas.width, canvas.height, canvas.pixels.as_flattened()))
}

struct Canvas {
    width: usize,
    height: usize,
    pixels: Vec<[u8; 3]>,
}

impl Canvas {
    fn new(width: usize, height: usize) -> Self {
        let mut pixels = memory::with_capacity(width * height);
        pixels.resize(width * height, BACKGROUND);
        Self { width, height, pixels }
    }

    fn paste(&mut self, picture: Picture<'_>, left: usize) {
        let width = picture.size().0;
        for (row, line) in picture.rgb_pixels().chunks(width).zip(self.pixels.chunks_mut(self.width)) {
            line[left..left + width].copy_from_slice(row);
        }
    }

    /// Mixes `color` into the pixels of the rectangle around `from` and `to`, wider by `rim` on all sides, by the
    /// coverage that `at` gives for a pixel's centre.
    fn mix(&mut self, from: (f64, f64), to: (f64, f64), rim: f64, color: [u8; 3], at: impl Fn(f64, f64) -> f64) {
        let range = |a: f64, b: f64, size: usize| {
            let (first, last) = (a.min(b) - rim, a.max(b) + rim);
            (first.floor().max(0.0) as usize).min(size)..(last.ceil().max(0.0) as usize).min(size)
        };
        for v in range(from.1, to.1, self.height) {
            for u in range(from.0, to.0, self.width) {
                let coverage = at(u as f64 + 0.5, v as f64 + 0.5).clamp(0.0, 1.0);
                if coverage > 0.0 {
                    for (channel, new) in self.pixels[v * self.width + u].iter_mut().zip(color) {
                        *channel = (f64::from(*channel) * (1.0 - coverage) + f64::from(new) * coverage).round() as u8;
                    }
                }
            }
        }
    }

    fn line(&mut self, from: (f64, f64), to: (f64, f64), color: [u8; 3], dashed: bool) {
        let (du, dv) = (to.0 - from.0, to.1 - from.1);
        let length = du.hypot(dv).max(1e-9);
        // Piece by piece, so that the rectangle around each piece is small.
        let pieces = (length / 16.0).ceil();
        for piece in 0..pieces as usize {
            let place = |k: f64| (from.0 + du * k / pieces, from.1 + dv * k / pieces);
            let (start, end) = (place(piece as f64), place((piece + 1) as f64));
            let (low, high) = (length * piece as f64 / pieces, length * (piece + 1) as f64 / pieces);
            self.mix(start, end, HALF_WIDTH_PX + 1.0, color, |x, y| {
                let along = ((x - from.0) * du + (y - from.1) * dv) / length;
                if along < low || along >= high || (dashed && along % (DASH_PX.0 + DASH_PX.1) >= DASH_PX.0) {
                    return 0.0;
                }
                let across = ((x - from.0) * dv - (y - from.1) * du).abs() / length;
                HALF_WIDTH_PX + 0.5 - across
            });
        }
    }

    fn ring(&mut self, centre: (f64, f64), color: [u8; 3]) {
        self.mix(centre, centre, RING_PX + HALF_WIDTH_PX + 1.0, color, |x, y| {
            HALF_WIDTH_PX + 0.5 - ((x - centre.0).hypot(y - centre.1) - RING_PX).abs()
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_go_where_the_matches_are() {
        let (a, b) = (vec![0u8; 40 * 30 * 3], vec![90u8; 50 * 20 * 4]);
        let (a, b) = (Picture::rgb(40, 30, &a), Picture::rgba(50, 20, &b));
        let lines = [
            MatchLine { a: [10.0, 5.0], b: [20.0, 5.0], inlier: true },
            MatchLine { a: [10.0, 12.0], b: [20.0, 12.0], inlier: false },
            MatchLine { a: [f64::NAN, 0.0], b: [0.0, 0.0], inlier: true },
            MatchLine { a: [-900.0, 400.0], b: [1e5, -1e4], inlier: false },
        ];
        let home = tempfile::tempdir().expect("a folder");
        let path = home.path().join("m.png");
        write_match_picture(&path, a, b, &lines).expect("written");
        let image = image::open(&path).expect("a picture").to_rgb8();
        assert_eq!(image.dimensions(), (40 + 8 + 50, 30));
        assert_eq!(image.get_pixel(1, 1).0, [0; 3]);
        assert_eq!(image.get_pixel(90, 18).0, [90; 3]);
        assert_eq!(image.get_pixel(90, 28).0, BACKGROUND, "below the lower picture");
        // The inlier is drawn along its whole row; the other one has gaps.
        let along = |v: u32, color: [u8; 3]| (13..65).filter(|u| image.get_pixel(*u, v).0 == color).count();
        assert_eq!(along(5, INLIER_COLOR), 52);
        assert!((20..40).contains(&along(12, OUTLIER_COLOR)), "{}", along(12, OUTLIER_COLOR));
        assert_eq!(image.get_pixel(40, 8).0, BACKGROUND);
        let none = home.path().join("none.png");
        assert!(write_match_picture(&none, a, Picture::rgb(0, 2, &[]), &[]).is_err() && !none.exists());
    }
}
