//! An image at halving resolutions: each level is the mean of 2×2 pixels of the one before, so that white noise stays
//! white and halves.

use super::tiles::TILE;
use crate::plane::Plane;

/// Maximum number of levels, with the image itself: enough to follow motion of up to about 100 pixels.
const MAX_LEVELS: usize = 5;

/// The image and its coarser copies, finest first; at least one level. Each coarser level's sides are at least a
/// tile's.
pub(super) fn pyramid(image: &Plane) -> Vec<Plane> {
    let mut levels = vec![image.clone()];
    while levels.len() < MAX_LEVELS {
        let last = &levels[levels.len() - 1];
        if last.width().min(last.height()) < 2 * TILE {
            break;
        }
        levels.push(halved(last));
    }
    levels
}

/// Means of 2×2 pixels; an odd last column or row is left out.
fn halved(image: &Plane) -> Plane {
    let (width, height) = (image.width() / 2, image.height() / 2);
    let mut out = Plane::zeros(width, height);
    for v in 0..height {
        let (upper, lower) = (image.row(2 * v), image.row(2 * v + 1));
        for ((out, a), b) in out.row_mut(v).iter_mut().zip(upper.chunks_exact(2)).zip(lower.chunks_exact(2)) {
            *out = 0.25 * ((a[0] + a[1]) + (b[0] + b[1]));
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_halve_until_a_tile_is_all_there_is() {
        let sizes = |width, height| -> Vec<(usize, usize)> {
            pyramid(&Plane::zeros(width, height)).iter().map(Plane::size).collect()
        };
        assert_eq!(sizes(100, 65), [(100, 65), (50, 32), (25, 16)]);
        assert_eq!(sizes(3, 1), [(3, 1)]);
        assert_eq!(sizes(4000, 3000).len(), MAX_LEVELS);
    }

    #[test]
    fn a_pixel_is_the_mean_of_four() {
        let coarse = halved(&Plane::from_fn(5, 4, |u, v| (u + 10 * v) as f32));
        assert_eq!((coarse.size(), coarse.data()), ((2, 2), &[5.5, 7.5, 25.5, 27.5][..]));
    }
}
