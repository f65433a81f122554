//! Hot pixels: single pixels that stay far brighter or darker than all pixels around them, in every frame.

use crate::plane::Plane;

/// Distance of a hot pixel from every neighbour, in standard deviations of the frames' mean.
const HOT: f32 = 6.0;

/// Difference from both neighbours in its row above which a pixel is examined, in the mean of `frames` frames whose
/// noise has the variance `variance` each.
pub fn limit_of_first_look(frames: usize, variance: f32) -> f32 {
    HOT * (variance / frames as f32).sqrt()
}

/// Hot pixels among those that stand out of their row and their neighbours, from the first row to the last.
pub fn find(standing_out: &[(usize, usize)], frames: &[&Plane], variance: f32) -> Vec<(usize, usize)> {
    let is_hot = |at: &(usize, usize), known: &[(usize, usize)]| is_hot(frames, variance, *at, known);
    let mut found: Vec<(usize, usize)> = standing_out.iter().copied().filter(|at| is_hot(at, &[])).collect();
    // Where two hot pixels touch, the brighter one hides the other.
    let (width, height) = frames[0].size();
    let around = |&(u, v): &(usize, usize)| {
        (v.saturating_sub(1)..(v + 2).min(height))
            .flat_map(move |y| (u.saturating_sub(1)..(u + 2).min(width)).map(move |x| (x, y)))
    };
    let mut beside: Vec<(usize, usize)> = found.iter().flat_map(around).collect();
    beside.sort_unstable();
    beside.dedup();
    beside.retain(|at| !found.contains(at) && is_hot(at, &found));
    found.extend(beside);
    found.sort_by_key(|&(u, v)| (v, u));
    found
}

/// Replaces pixels by the median of the eight around them.
pub fn mask(plane: &mut Plane, pixels: &[(usize, usize)]) {
    for &(u, v) in pixels {
        plane.row_mut(v)[u] = median(neighbours(u, v, plane.size()).map(|(x, y)| plane.at(x, y)));
    }
}

fn median(mut around: [f32; 8]) -> f32 {
    around.sort_by(f32::total_cmp);
    0.5 * (around[3] + around[4])
}

/// The eight pixels around one; beyond the border of an image of `size` they are mirrored.
fn neighbours(u: usize, v: usize, (width, height): (usize, usize)) -> [(usize, usize); 8] {
    let inside = |x: i64, n: usize| {
        if x < 0 {
            1
        } else if x >= n as i64 {
            n - 2
        } else {
            x as usize
        }
    };
    let at = |(du, dv): (i64, i64)| (inside(u as i64 + du, width), inside(v as i64 + dv, height));
    [(-1, -1), (0, -1), (1, -1), (-1, 0), (1, 0), (-1, 1), (0, 1), (1, 1)].map(at)
}

/// Signed distance of a value from the range of `around`; 0 inside it.
fn beyond(value: f32, around: &[f32; 8]) -> f32 {
    let (min, max) = around.iter().fold((f32::INFINITY, f32::NEG_INFINITY), |(a, b), &x| (a.min(x), b.max(x)));
    (value - max).max(0.0) + (value - min).min(0.0)
}

/// Whether the pixel is beyond all its neighbours except the hot ones `known`, in the mean of the frames and in nearly
/// every frame.
fn is_hot(frames: &[&Plane], variance: f32, (u, v): (usize, usize), known: &[(usize, usize)]) -> bool {
    let places = neighbours(u, v, frames[0].size());
    let masked = places.map(|at| known.contains(&at));
    let around_in = |frame: &Plane| {
        let mut around = places.map(|(x, y)| frame.at(x, y));
        if masked.contains(&true) {
            let instead = median(around);
            around.iter_mut().zip(masked).filter(|(_, masked)| *masked).for_each(|(x, _)| *x = instead);
        }
        around
    };
    // The local noise, which may be larger than usual: the change of the pixels around from frame to frame. Objects
    // that cross the pixel make it larger too.
    let n = frames.len() as f32;
    let (mut sums, mut squares) = ([0.0f32; 8], [0.0f32; 8]);
    let (mut value, mut mean, mut own, mut above) = (0.0, 0.0, 0.0, 0usize);
    for frame in frames {
        let around = around_in(frame);
        let here = frame.at(u, v) - around.iter().sum::<f32>() / 8.0;
        (value, mean, own) = (value + frame.at(u, v) / n, mean + here / n, own + here * here);
        above += usize::from(here > 0.0);
        for ((sum, square), x) in sums.iter_mut().zip(&mut squares).zip(around) {
            (*sum, *square) = (*sum + x, *square + x * x);
        }
    }
    let off = beyond(value, &sums.map(|sum| sum / n));
    if off.abs() < HOT * (variance / n).sqrt() {
        return false;
    }
    let around = squares.iter().zip(sums).map(|(square, sum)| square - sum * sum / n).sum::<f32>() / (8.0 * (n - 1.0));
    let own = (own - n * mean * mean) / (n - 1.0);
    let in_nearly_all = above.min(frames.len() - above) * 10 <= frames.len();
    let error = (around.max(variance) / n).sqrt();
    in_nearly_all && off.abs() > HOT * error && mean.abs() > HOT * error.max(0.5 * (own.max(0.0) / n).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synth::random::Stream;

    #[test]
    fn neighbours_of_each_other_are_both_found() {
        let frame = |t: u64| {
            let mut stream = Stream::new(5, t);
            let mut frame = Plane::from_fn(60, 50, |_, _| 0.5 + 0.01 * stream.normal() as f32);
            [(20, 20, 0.4), (21, 20, 0.2), (0, 0, 0.3), (59, 30, -0.3)]
                .iter()
                .for_each(|&(u, v, by)| frame.row_mut(v)[u] += by);
            frame
        };
        let frames = [0, 1, 2, 3, 4, 5].map(frame);
        let frames: Vec<&Plane> = frames.iter().collect();
        assert_eq!(
            find(&[(20, 20), (30, 30), (0, 0), (59, 30)], &frames, 1e-4),
            [(0, 0), (20, 20), (21, 20), (59, 30)]
        );
        let mut clean = frames[0].clone();
        mask(&mut clean, &[(20, 20), (21, 20)]);
        assert!((clean.at(20, 20) - 0.5).abs() < 0.05 && clean.at(59, 30) < 0.3);
    }
}
