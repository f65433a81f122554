//! Peak of the power of a window over slopes, with its significance and ambiguity, and the path of the picture.
//!
//! The power of the motion stack at slope λ, without each frame's own, is P(λ) = Σ_k A_k(k·λ), where A_k is the
//! correlation summed over the pairs of lag k. A point that leaves the window lowers A_k at a shift d by the window's
//! overlap with itself, W(d): so A_k/W is an unbiased measure and W² its weight. P over the standard deviation that the
//! frames' own spectra predict is the significance. The strongest slope of a grid is refined by Newton's method; the
//! decrease of P around it gives the uncertainty, the strongest other slope the ambiguity (of periodic texture).
//!
//! The correlations of frames t and t + 1, summed over the image, have their peak at the shift of the picture as a
//! whole. The sum of the shifts is its path; the motion is straight where that hardly leaves a uniform one.

use super::lags::Lags;
use super::spectra::{CrossSpectra, Fourier, SIDE, Sum};
use crate::burst::Offset;

/// Largest shift used, level pixels: at larger ones little of the window overlaps.
const REACH: f64 = 0.4 * SIDE as f64;
/// Number of lags with which the grid of slopes is searched; the refinement uses all.
const SEARCH_LAGS: usize = 5;
/// Largest shift between neighbouring slopes of the grid, level pixels.
const SEARCH_STEP: f64 = 0.8;
pub(super) const MIN_OVERLAP: f32 = 0.03;
/// Part of P by which texture may shift its peak, in addition to the noise.
const TEXTURE_PART: f64 = 0.01;
const STEPS: usize = 5;

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Track {
    Plane,
    /// Slopes along a unit vector (u, v).
    Line([f64; 2]),
}

/// Slope of a window, in level pixels per frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Peak {
    pub slope: [f64; 2],
    pub significance: f64,
    /// Possible error of the slope in the direction in which it is least certain.
    pub uncertainty: f64,
    pub ambiguity: f64,
}

struct Tap {
    at: [u16; 4],
    weight: [f32; 4],
    overlap: f32,
}

/// Slopes of the search, with the taps that read the correlations. Shared by all windows of all levels.
pub(super) struct SearchTable {
    track: Track,
    /// Level pixels per frame.
    pub slopes: Vec<[f64; 2]>,
    taps: Vec<Vec<Tap>>,
    step: f64,
    /// Distance of the frames of each lag.
    distances: Vec<Offset>,
    overlap: Vec<f32>,
}

impl SearchTable {
    pub fn new(distances: &[Offset], track: Track, overlap: &[f32]) -> Self {
        let lag_count = distances.len();
        let lags = lag_count.clamp(1, SEARCH_LAGS);
        // The farthest lag moves the most by a slope, so it sets the step.
        let step = SEARCH_STEP / lags as f64;
        let radius = REACH / lag_count.clamp(1, 3) as f64;
        let half = (radius / step).floor() as i64;
        let slopes: Vec<[f64; 2]> = match track {
            Track::Plane => (-half..=half)
                .flat_map(|j| (-half..=half).map(move |i| [i as f64 * step, j as f64 * step]))
                .filter(|s| s[0].hypot(s[1]) <= radius)
                .collect(),
            Track::Line([u, v]) => (-half..=half).map(|i| [i as f64 * step * u, i as f64 * step * v]).collect(),
        };
        let of_lags =
            |s: &[f64; 2]| distances.iter().take(lags).filter_map(|apart| Tap::new(*s, *apart, overlap)).collect();
        let taps = slopes.iter().map(of_lags).collect();
        Self { track, slopes, taps, step, distances: distances.to_vec(), overlap: overlap.to_vec() }
    }

    /// Peak of the correlations of lags 1, 2, …; `None` where the variance is zero, or no slope has power.
    pub fn strongest(&self, planes: &[Vec<f32>], variance: &[f64]) -> Option<Peak> {
        if variance.iter().all(|v| *v <= 0.0) {
            return None;
        }
        let scores = self.scores(planes, variance);
        let unbiased: Vec<Vec<f32>> = planes.iter().map(|plane| unbiased(plane, &self.overlap)).collect();
        let stack = Stack { planes: &unbiased, variance, distances: &self.distances, overlap: &self.overlap };
        let first = best(&scores, |_| true)?;
        let peak = self.refined(&stack, self.slopes[first], STEPS)?;
        // The width of a peak in the grid's search follows from its lags.
        let apart = 6.0 * self.step;
        let distance = |s: &[f64; 2]| (s[0] - peak.slope[0]).hypot(s[1] - peak.slope[1]);
        // A second start that climbs back to the first peak is no other slope.
        let other = best(&scores, |i| distance(&self.slopes[i]) > apart);
        let other =
            other.and_then(|i| self.refined(&stack, self.slopes[i], 2)).filter(|o| distance(&o.slope) > 0.5 * apart);
        match other {
            // Refinement may reverse the grid's order: the stronger peak is the answer.
            Some(other) if other.significance > peak.significance => {
                let ambiguity = peak.significance / other.significance;
                let other = self.refined(&stack, other.slope, STEPS).unwrap_or(other);
                Some(Peak { ambiguity, ..other })
            }
            Some(other) => Some(Peak { ambiguity: other.significance / peak.significance, ..peak }),
            None => Some(peak),
        }
    }

    pub fn scores(&self, planes: &[Vec<f32>], variance: &[f64]) -> Vec<f64> {
        let score = |taps: &Vec<Tap>| {
            let (mut power, mut noise) = (0.0f64, 0.0f64);
            for (tap, (plane, variance)) in taps.iter().zip(planes.iter().zip(variance)) {
                let [a, b, c, d] = tap.at.map(|at| plane[usize::from(at)]);
                let [e, f, g, h] = tap.weight;
                power += f64::from(a * e + b * f + c * g + d * h);
                noise += f64::from(tap.overlap * tap.overlap) * variance;
            }
            if noise > 0.0 { power / noise.sqrt() } else { 0.0 }
        };
        self.taps.iter().map(score).collect()
    }

    /// Maximum of P nearest to `slope`, by Newton's method.
    fn refined(&self, stack: &Stack<'_>, slope: [f64; 2], steps: usize) -> Option<Peak> {
        let axes = match self.track {
            Track::Plane => [[1.0, 0.0], [0.0, 1.0]],
            // On a line the second axis completes the frame, but nothing is varied along it.
            Track::Line([u, v]) => [[u, v], [-v, u]],
        };
        let both = self.track == Track::Plane;
        let (h, mut at) = (0.5 * self.step, slope);
        let mut answer = None;
        for _ in 0..steps {
            // Nine values of P share one set of weights, which hardly change within half a step.
            let weights = stack.weights(at);
            let p = |i: f64, j: f64| {
                let moved = |axis: usize| at[axis] + h * (i * axes[0][axis] + j * axes[1][axis]);
                stack.power(&weights, [moved(0), moved(1)])
            };
            let (middle, left, right) = (p(0.0, 0.0), p(-1.0, 0.0), p(1.0, 0.0));
            let bend = |a: f64, b: f64| (2.0 * middle - a - b) / (h * h);
            let (slant_0, bend_00) = ((right - left) / (2.0 * h), bend(left, right));
            let (slant_1, bend_11, bend_01) = if both {
                let (up, down) = (p(0.0, -1.0), p(0.0, 1.0));
                let corners = p(1.0, 1.0) - p(1.0, -1.0) - p(-1.0, 1.0) + p(-1.0, -1.0);
                ((down - up) / (2.0 * h), bend(up, down), -corners / (4.0 * h * h))
            } else {
                (0.0, 1.0, 0.0)
            };
            let deviation = stack.deviation(&weights);
            let determinant = bend_00 * bend_11 - bend_01 * bend_01;
            if middle <= 0.0 || deviation <= 0.0 {
                return answer;
            }
            let significance = middle / deviation;
            // Smallest curvature of P.
            let mean = 0.5 * (bend_00 + bend_11);
            let min =
                if both { mean - (0.25 * (bend_00 - bend_11).powi(2) + bend_01 * bend_01).sqrt() } else { bend_00 };
            // P may fall by texture's part and by 4.5 nats of noise, three standard errors: s²·ΔP/P = 4.5.
            let part = TEXTURE_PART + 4.5 / (significance * significance);
            let uncertainty = if min > 0.0 { (2.0 * part * middle / min).sqrt() } else { f64::INFINITY };
            answer = Some(Peak { slope: at, significance, uncertainty, ambiguity: 0.0 });
            // At a saddle or a valley Newton's step would lead away from the peak.
            if min <= 0.0 || determinant <= 0.0 {
                return answer;
            }
            let step = [
                (bend_11 * slant_0 - bend_01 * slant_1) / determinant,
                (bend_00 * slant_1 - bend_01 * slant_0) / determinant,
            ];
            let length = step[0].hypot(step[1]);
            // Beyond one step of the grid the quadratic no longer describes P.
            let limit = (self.step / length.max(1e-12)).min(1.0);
            (0..2).for_each(|axis| at[axis] += limit * (step[0] * axes[0][axis] + step[1] * axes[1][axis]));
            if length < 0.02 * self.step {
                break;
            }
        }
        answer
    }
}

fn best(scores: &[f64], counts: impl Fn(usize) -> bool) -> Option<usize> {
    (0..scores.len()).filter(|i| counts(*i)).max_by(|a, b| scores[*a].total_cmp(&scores[*b]))
}

impl Tap {
    fn new(slope: [f64; 2], apart: Offset, overlap: &[f32]) -> Option<Self> {
        let shift = shift_at(slope, apart);
        let w = overlap_at(overlap, shift);
        if w < MIN_OVERLAP {
            return None;
        }
        let ([u, v], [fu, fv]) = split(shift);
        let at = [(v, u), (v, u + 1), (v + 1, u), (v + 1, u + 1)].map(|(v, u)| index(u, v) as u16);
        let weight = [(1.0 - fv) * (1.0 - fu), (1.0 - fv) * fu, fv * (1.0 - fu), fv * fu].map(|x| w * x as f32);
        Some(Self { at, weight, overlap: w })
    }
}

/// Shift of one frame against another, `apart` from it, at `slope`.
fn shift_at([u, v]: [f64; 2], apart: Offset) -> [f64; 2] {
    apart.displacement((u, v)).into()
}

fn split(shift: [f64; 2]) -> ([i64; 2], [f64; 2]) {
    let whole = shift.map(f64::floor);
    (whole.map(|x| x as i64), [shift[0] - whole[0], shift[1] - whole[1]])
}

fn index(u: i64, v: i64) -> usize {
    v.rem_euclid(SIDE as i64) as usize * SIDE + u.rem_euclid(SIDE as i64) as usize
}

/// Overlap of the window with itself at `shift`; 0 beyond the reach.
pub(super) fn overlap_at(overlap: &[f32], shift: [f64; 2]) -> f32 {
    if shift.iter().any(|d| d.abs() > REACH + 1.0) {
        return 0.0;
    }
    let ([u, v], [fu, fv]) = split(shift);
    let at = |u: i64, v: i64| f64::from(overlap[index(u, v)]);
    let row = |v: i64| (1.0 - fu) * at(u, v) + fu * at(u + 1, v);
    ((1.0 - fv) * row(v) + fv * row(v + 1)) as f32
}

pub(super) fn unbiased(plane: &[f32], overlap: &[f32]) -> Vec<f32> {
    plane.iter().zip(overlap).map(|(a, w)| if *w < 0.2 * MIN_OVERLAP { 0.0 } else { a / w }).collect()
}

struct Stack<'a> {
    /// Correlations divided by the overlap.
    planes: &'a [Vec<f32>],
    variance: &'a [f64],
    /// Distance of the frames of each lag.
    distances: &'a [Offset],
    overlap: &'a [f32],
}

impl Stack<'_> {
    fn weights(&self, slope: [f64; 2]) -> Vec<f64> {
        let weight = |apart: &Offset| f64::from(overlap_at(self.overlap, shift_at(slope, *apart)));
        self.distances
            .iter()
            .take(self.planes.len())
            .map(weight)
            .map(|w| if w < f64::from(MIN_OVERLAP) { 0.0 } else { w })
            .collect()
    }

    fn power(&self, weights: &[f64], slope: [f64; 2]) -> f64 {
        let lag = |(k, w): (usize, &f64)| w * w * cubic(&self.planes[k], shift_at(slope, self.distances[k]));
        weights.iter().enumerate().filter(|(_, w)| **w > 0.0).map(lag).sum()
    }

    fn deviation(&self, weights: &[f64]) -> f64 {
        weights.iter().zip(self.variance).map(|(w, v)| w * w * v).sum::<f64>().sqrt()
    }
}

/// Correlation at `shift` by cubic convolution: linear interpolation would prefer shifts of whole pixels.
pub(super) fn cubic(plane: &[f32], shift: [f64; 2]) -> f64 {
    let ([u, v], [fu, fv]) = split(shift);
    let (wu, wv) = (cubic_weights(fu), cubic_weights(fv));
    let row =
        |j: usize| (0..4).map(|i| wu[i] * f64::from(plane[index(u + i as i64 - 1, v + j as i64 - 1)])).sum::<f64>();
    (0..4).map(|j| wv[j] * row(j)).sum()
}

fn cubic_weights(f: f64) -> [f64; 4] {
    let (f2, f3) = (f * f, f * f * f);
    [-0.5 * f + f2 - 0.5 * f3, 1.0 - 2.5 * f2 + 1.5 * f3, 0.5 * f + 2.0 * f2 - 1.5 * f3, -0.5 * f2 + 0.5 * f3]
}

/// Minimum significance of every pair of neighbours.
const MIN_SIGNIFICANCE: f64 = 6.0;
/// Maximum number of steps up a peak, and the step length below which they end, level pixels.
const MAX_STEPS: usize = 60;
const FINEST_STEP: f64 = 0.02;
/// Standard error of a shift times its peak's significance, level pixels: one over the root of the band's curvature.
const SHIFT_ERROR: f64 = 1.2;

/// Least curvature of a correlation at its top, standard deviations a square level pixel: along stripes alone the tops
/// that noise makes had up to 4.5, on real pictures the least was 7.6.
const MIN_BEND: f64 = 5.0;
/// Curvature, in the height of the top, that is no ridge however faint: textures have about 0.5.
const FLAT: f64 = 0.25;

/// Path of the picture as a whole; all lengths in one unit.
pub(super) struct Path {
    pub way: Vec<[f64; 2]>,
    /// Distance from a uniform motion that noise alone would cause.
    pub noise: f64,
    /// Width of a pixel of the level at which it was measured.
    pub pixel: f64,
}

impl Path {
    /// Distance above which the motion is not straight, for a path in image pixels.
    pub fn limit(&self, still: bool) -> f64 {
        // In clear frames the path is exact, and nothing is forgiven.
        let least = if still { (super::STILL_LEVEL_PX * self.pixel).min(10.0 * self.noise) } else { 0.0 };
        super::STRAIGHT_PX.max(3.0 * self.noise).max(least)
    }
}

/// Smallest overlap of two frames, 0 … 1, at which their correlation shows whether the shifts between them add up.
const MIN_SEEN: f32 = 0.2;
/// Ratio of the nats of a uniform motion to those of a path from which the path is none; noise makes 4.5 nats besides.
const REFUTED: f64 = 1.1;

/// Path of the picture as a whole, level pixels; `None` where pairs are too noisy or the picture moves in parts.
pub(super) fn path(pairs: &CrossSpectra, lags: &Lags, fourier: &Fourier) -> Option<Path> {
    let (neighbours, farther) = pairs.products.split_at(lags.neighbours());
    let (of_neighbours, of_farther) = pairs.variance.split_at(lags.neighbours());
    let variance = of_neighbours.iter().sum::<f64>() / neighbours.len() as f64;
    if neighbours.len() < 2 || variance <= 0.0 {
        return None;
    }
    let planes = fourier.correlations(neighbours, &mut fourier.scratch(0));
    let (mut way, mut min) = (vec![[0.0, 0.0]], f64::INFINITY);
    for plane in &planes {
        let ([u, v], significance) = peak_of(plane, &fourier.overlap, variance)?;
        // On a ridge noise makes the top, and with it the part of the shift along the ridge.
        let bend = least(bends(&unbiased(plane, &fourier.overlap), [u, v])) / variance.sqrt();
        let (u, v) = (bend >= MIN_BEND.min(FLAT * significance)).then_some((u, v))?;
        min = min.min(significance);
        let [x, y] = *way.last()?;
        way.push([x + u, y + v]);
    }
    // Frames farther apart measure the sums of shifts independently. Of several motions now one and now another is the
    // strongest, and in the dark now and then a peak of noise: then the shifts do not add up to those two frames apart,
    // or one shift, kept up, explains the frames farther apart better.
    let farther = fourier.correlations(farther, &mut fourier.scratch(0));
    let pairs = || farther.iter().zip(of_farther).zip(&lags.near[planes.len()..]);
    let shift = |way: &[[f64; 2]], (s, t): (usize, usize)| [0, 1].map(|axis| way[t][axis] - way[s][axis]);
    let adds_up = |((plane, variance), ends): ((&Vec<f32>, &f64), &(usize, usize))| {
        let (plain, shift) = (unbiased(plane, &fourier.overlap), shift(&way, *ends));
        overlap_at(&fourier.overlap, shift) < MIN_SEEN
            || peak_of(plane, &fourier.overlap, *variance)
                .is_none_or(|(at, _)| cubic(&plain, shift) >= SAME_SCENE * cubic(&plain, at))
    };
    let nats = |way: &[[f64; 2]]| {
        let (mut power, mut noise) = (0.0, 0.0);
        for ((plane, variance), ends) in pairs() {
            let at = shift(way, *ends);
            let overlap = f64::from(overlap_at(&fourier.overlap, at));
            power += overlap * cubic(plane, at);
            noise += overlap * overlap * variance;
        }
        0.5 * power.max(0.0).powi(2) / noise.max(f64::MIN_POSITIVE)
    };
    let kept_up = |shift: [f64; 2]| (0..way.len()).map(|t| shift.map(|x| x * t as f64)).collect::<Vec<_>>();
    let refutes = |k: usize| nats(&kept_up(shift(&way, (k - 1, k)))) > REFUTED * nats(&way) + 4.5;
    if !pairs().take(planes.len() - 1).all(adds_up) || (1..way.len()).any(refutes) {
        return None;
    }
    // Each shift has an error of about a pixel divided by its significance; the errors add up along the path.
    Some(Path { way, noise: SHIFT_ERROR / min * (planes.len() as f64).sqrt(), pixel: 1.0 })
}

/// Least ratio of two correlations of the same scene.
const SAME_SCENE: f64 = 0.5;

/// Index of a correlation's largest value; 0 is shift 0.
fn largest_at(plane: &[f32]) -> usize {
    (0..plane.len()).max_by(|a, b| plane[*a].total_cmp(&plane[*b])).unwrap_or(0)
}

/// Number of lags, from 1 on, at which frames have noise in common: the correlation is largest at shift 0, for most
/// pairs of neighbours too (where a scene moves to and fro they show the shifts), and far smaller at the next lag, or,
/// after a filter over time, fades from lag to lag and keeps its shape.
pub(super) fn lags_of_shared_noise(sum: &Sum, lags: &Lags, fourier: &Fourier) -> usize {
    let pairs = fourier.correlations(&sum.pairs.products[..lags.neighbours()], &mut fourier.scratch(0));
    if 2 * pairs.iter().filter(|pair| largest_at(pair) == 0).count() <= pairs.len() {
        return 0;
    }
    let planes = fourier.correlations(&sum.lags.products, &mut fourier.scratch(0));
    let largest = |lag: usize| {
        let plane = &planes[lag - 1];
        let at = largest_at(plane);
        let pairs = lags.pairs(lag) as f64;
        (at, f64::from(plane[at]) / pairs, sum.lags.variance[lag - 1].sqrt() / pairs)
    };
    let is_clear = |lag: usize| {
        let (at, value, error) = largest(lag);
        at == 0 && value > MIN_SIGNIFICANCE * error
    };
    // Motions apart make the peak of their sum fade as well, but they make it wider, too.
    let sharpness = |lag: usize| {
        let [uu, vv, _] = bends(&planes[lag - 1], [0.0, 0.0]);
        [uu, vv].map(|bend| bend / f64::from(planes[lag - 1][0]))
    };
    let first = largest(1).1;
    let faded = (2..planes.len()).find(|lag| largest(*lag).1 < FADED * first).filter(|lag| is_clear(*lag));
    let keeps_shape = |lag: &usize| sharpness(*lag).iter().zip(sharpness(1)).all(|(now, then)| *now > KEEPS * then);
    let farthest = (2..planes.len()).rev().find(|lag| lags.pairs(*lag) > 1);
    let left = farthest.map(|lag| largest(lag).1 + largest(lag).2).filter(|left| *left < SAME_SCENE * first);
    let left = left.filter(|_| faded.is_some_and(|lag| keeps_shape(&lag)));
    // A scene that stands still correlates as well at the next lag; noise of few frames does not.
    let is_noise = |lag: usize| {
        let ((_, value, _), (_, next, next_error)) = (largest(lag), largest(lag + 1));
        let fades = left.is_some_and(|left| value > STILL_FADES * left);
        is_clear(lag) && (next + next_error < SAME_SCENE * value || fades)
    };
    (1..planes.len()).take_while(|lag| is_noise(*lag)).count()
}

/// Ratio of the correlation of a lag to that of the first below which it has faded, and least ratio of its sharpness to
/// that of the first: noise has 1, motions that are spread as far along a line 0.5.
const FADED: f64 = 0.7;
const KEEPS: f64 = 0.75;
/// Ratio of what correlates at a lag to what does at the farthest, above which noise still fades.
const STILL_FADES: f64 = 1.25;

/// Curvature of a correlation at its top along u, along v, and mixed, per square level pixel.
fn bends(plane: &[f32], at: [f64; 2]) -> [f64; 3] {
    let by = |u: f64, v: f64| cubic(plane, [at[0] + u, at[1] + v]);
    let along = |u: f64, v: f64| 2.0 * by(0.0, 0.0) - by(-u, -v) - by(u, v);
    [along(1.0, 0.0), along(0.0, 1.0), 0.25 * (by(1.0, -1.0) + by(-1.0, 1.0) - by(1.0, 1.0) - by(-1.0, -1.0))]
}

/// Curvature in the direction in which it is least.
fn least([uu, vv, uv]: [f64; 3]) -> f64 {
    0.5 * (uu + vv) - (0.25 * (uu - vv).powi(2) + uv * uv).sqrt()
}

pub(super) fn peak_of(plane: &[f32], overlap: &[f32], variance: f64) -> Option<([f64; 2], f64)> {
    let largest = largest_at(plane);
    let significance = f64::from(plane[largest]) / variance.sqrt();
    // Frames with values that are not finite have no significance either.
    if !significance.is_finite() || significance < MIN_SIGNIFICANCE {
        return None;
    }
    let signed = |i: usize| if i > SIDE / 2 { i as f64 - SIDE as f64 } else { i as f64 };
    let mut at = [signed(largest % SIDE), signed(largest / SIDE)];
    // The overlap falls with the shift and would pull the peak towards 0.
    let unbiased = unbiased(plane, overlap);
    // Hill climbing by steps that are halved at each top.
    let mut step = 0.5;
    for _ in 0..MAX_STEPS {
        let around = [[0.0, 0.0], [step, 0.0], [-step, 0.0], [0.0, step], [0.0, -step]];
        let value = |d: &[f64; 2]| cubic(&unbiased, [at[0] + d[0], at[1] + d[1]]);
        let best = around.iter().max_by(|a, b| value(a).total_cmp(&value(b)))?;
        if *best == [0.0, 0.0] {
            step *= 0.5;
        } else {
            at = [at[0] + best[0], at[1] + best[1]];
        }
        if step < FINEST_STEP {
            break;
        }
    }
    Some((at, significance))
}

/// Largest distance of points reached at times `at`, whose mean is 0, from the uniform motion that fits them best.
pub(super) fn distance_from_a_line(way: &[[f64; 2]], at: &[Offset]) -> f64 {
    let times = || at.iter().map(|at| at.u);
    let spread: f64 = times().map(|t| t * t).sum();
    let fit = |axis: usize| {
        let mean = way.iter().map(|x| x[axis]).sum::<f64>() / way.len() as f64;
        let slope = way.iter().zip(times()).map(|(x, t)| x[axis] * t).sum::<f64>() / spread;
        (mean, slope)
    };
    let fits = [fit(0), fit(1)];
    let off = |x: &[f64; 2], t: f64, axis: usize| x[axis] - fits[axis].0 - fits[axis].1 * t;
    way.iter().zip(times()).map(|(x, t)| off(x, t, 0).hypot(off(x, t, 1))).fold(0.0, f64::max)
}
