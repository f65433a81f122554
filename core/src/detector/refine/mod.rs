//! Refinement of an extremum between the samples, in place and scale, then in slope; and the tests that need it.
//!
//! Place and scale: Brown and Lowe's quadratic fit as in VLFeat: up to four moves of a pixel while the fitted offset
//! exceeds 0.6 pixel in u or v (never in scale), accepted when every offset is below 1.5. In octaves after the first
//! the fit only starts an [ascent] to the exact maximum. Slope: D over slope is nearly a Gaussian bump, so a parabola
//! is fitted to log |D| over the neighbouring slopes, or to |D| itself where a neighbour has the other sign.

pub mod ascent;

use self::ascent::{FirstLevel, Peak};
use super::feature::Test;
use crate::detector::scale_space::DogTile;

/// Upper limit of [`Fit::edge_quotient`] for an upper limit of the ratio of principal curvatures.
pub fn edge_limit(edge_threshold: f32) -> f64 {
    let edge = f64::from(edge_threshold);
    (edge + 1.0).powi(2) / edge
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Lower limit of |D| after interpolation due to noise.
    pub gate: f32,
    pub peak_threshold: f32,
    pub edge_threshold: f32,
}

impl Limits {
    /// Applies the tests of D at an extremum and of its [`Fit::edge_quotient`], each by itself, in their order.
    pub(crate) fn tests(&self, value: f32, edge_quotient: f64) -> [(Test, bool); 3] {
        [
            (Test::NoiseGate, value.abs() >= self.gate),
            (Test::InterpolatedContrast, value.abs() > self.peak_threshold),
            // Below 0 where the curvatures differ in sign.
            (Test::Edge, edge_quotient > 0.0 && edge_quotient < edge_limit(self.edge_threshold)),
        ]
    }
}

/// Maximum number of fits, with moves of a pixel between. The tile holds so many pixels and one more around.
pub const MAX_FITS: usize = 5;

/// Solves the symmetric 3×3 system `a·x = −g` by elimination with pivoting; `None` when it is singular.
fn solve(mut a: [[f64; 3]; 3], g: [f64; 3]) -> Option<[f64; 3]> {
    let mut b = [-g[0], -g[1], -g[2]];
    for j in 0..3 {
        let pivot = (j..3).max_by(|&p, &q| a[p][j].abs().total_cmp(&a[q][j].abs()))?;
        // A flat direction: the quadratic has no single extremum.
        if a[pivot][j].abs() < 1e-14 {
            return None;
        }
        a.swap(j, pivot);
        b.swap(j, pivot);
        for i in j + 1..3 {
            let factor = a[i][j] / a[j][j];
            let upper = a[j];
            a[i].iter_mut().zip(upper).skip(j).for_each(|(x, above)| *x -= factor * above);
            b[i] -= factor * b[j];
        }
    }
    let mut x = [0.0; 3];
    for j in (0..3).rev() {
        let sum: f64 = (j + 1..3).map(|k| a[j][k] * x[k]).sum();
        x[j] = (b[j] - sum) / a[j][j];
    }
    Some(x)
}

/// A fitted extremum, in octave pixels and DoG level indices.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fit {
    /// Of the sample after the moves.
    pub x: usize,
    pub y: usize,
    /// Offset from that sample to the extremum: octave pixels along u and v, and DoG levels.
    pub offset: [f64; 3],
    /// DoG level index of the extremum (1 is level 0).
    pub level_refined: f64,
    /// Upper limit of an accepted offset in levels.
    pub level_reach: f64,
    pub value: f64,
    /// Second derivatives of D in the image: uu, uv, vv.
    pub curvature: [f64; 3],
}

/// Upper limit of the offsets of an accepted fit.
pub const MAX_OFFSET: f64 = 1.5;

impl Fit {
    /// Largest offset in magnitude, with [`Self::level_reach`] levels as [`MAX_OFFSET`]. Infinite where one is NaN.
    pub fn largest_offset(&self) -> f64 {
        let [x, y, level] = self.offset;
        let offsets = [x, y, level * (MAX_OFFSET / self.level_reach)];
        offsets.iter().map(|d| if d.is_nan() { f64::INFINITY } else { d.abs() }).fold(0.0, f64::max)
    }

    fn determinant(&self) -> f64 {
        let [xx, xy, yy] = self.curvature;
        xx * yy - xy * xy
    }

    /// Squared trace over determinant of the second derivatives in the image, which the edge test limits.
    pub fn edge_quotient(&self) -> f64 {
        let trace = self.curvature[0] + self.curvature[2];
        trace * trace / self.determinant()
    }

    /// Ratio of the principal curvatures, 1 or more; infinite where they differ in sign, as on a saddle.
    pub fn curvature_ratio(&self) -> f64 {
        let determinant = self.determinant();
        if determinant <= 0.0 || determinant.is_nan() {
            return f64::INFINITY;
        }
        // (r + 1)²/r = trace²/determinant, solved for the larger r.
        let sum = (self.edge_quotient() - 2.0).max(2.0);
        0.5 * (sum + (sum * sum - 4.0).sqrt())
    }

    /// Applies the tests that follow the fit, each by itself, in order, in an octave of `size` with `levels` levels.
    pub fn tests(&self, size: (usize, usize), levels: usize, limits: Limits) -> [(Test, bool); 5] {
        let inside = |at: f64, n: usize| (0.0..=(n - 1) as f64).contains(&at);
        let (x, y) = self.place();
        let [gate, contrast, edge] = limits.tests(self.value as f32, self.edge_quotient());
        [
            (Test::Refinement, self.largest_offset() < MAX_OFFSET),
            gate,
            contrast,
            edge,
            // Scales from level −1, the outermost DoG level, to level S+1, one step beyond the other end, as in VLFeat.
            (
                Test::Outside,
                inside(x, size.0) && inside(y, size.1) && (0.0..=levels as f64).contains(&self.level_refined),
            ),
        ]
    }

    /// Place (column, row) of the extremum, octave pixels.
    pub fn place(&self) -> (f64, f64) {
        (self.x as f64 + self.offset[0], self.y as f64 + self.offset[1])
    }
}

/// Refines the extremum at (x, y, level index) in place and scale, and applies the tests that follow. `first` is the
/// octave's first level except in the first octave; `size` is the octave's. Fails with the test that rejects it.
pub fn refine(
    (dog, first): (&DogTile, Option<&FirstLevel<'_>>),
    place: (usize, usize),
    level_index: usize,
    size: (usize, usize),
    limits: Limits,
) -> Result<Fit, Test> {
    let fit = fit((dog, first), place, level_index, size).ok_or(Test::Refinement)?;
    let failed = fit.tests(size, dog.levels.len(), limits).into_iter().find(|(_, passes)| !passes);
    failed.map_or(Ok(fit), |(test, _)| Err(test))
}

/// Distance from the sample, in pixels or levels, at which an ascent begins where the quadratic fit leads farther.
const LONGEST_START: f64 = 0.7;

/// Distance in levels from which the quadratic fit shows that a sample is not the nearest to a peak.
const FARTHEST_FIT: f64 = 0.8;

/// Distance in levels up to which an ascent's peak belongs to a sample: a little more than half a level, as not every
/// sample nearest to a peak begins an ascent. Peaks found twice fall to the choice of distinct keypoints.
const NEAREST: f64 = 0.6;
/// [`NEAREST`] below the octave's first level: farther into the finer octave, so that no peak is lost between them.
const BELOW_FIRST: f64 = 0.65;

/// Distance in levels beyond those at which an ascent ends.
const STRAY: f64 = 0.2;

/// Extremum of D around (x, y, level index): by the quadratic fit, or, with the octave's first level, the exact one by
/// the [ascent] from there; `None` where there is none. `size` is the octave's.
pub fn fit(
    (dog, first): (&DogTile, Option<&FirstLevel<'_>>),
    place: (usize, usize),
    level_index: usize,
    size: (usize, usize),
) -> Option<Fit> {
    let quadratic = quadratic(dog, place, level_index, size)?;
    let Some(first) = first else { return Some(quadratic) };
    // Most samples that are only nearly as strong as the adjacent level lie on no peak, as the fit shows cheaply.
    let quadratic = Fit { level_reach: FARTHEST_FIT, ..quadratic };
    if quadratic.largest_offset() >= MAX_OFFSET {
        return Some(quadratic);
    }
    // The fit may lie far off where the samples are coarse: the ascent starts near the sample.
    let start = |sample: usize, fitted: f64| fitted.clamp(sample as f64 - LONGEST_START, sample as f64 + LONGEST_START);
    let (x, y) = quadratic.place();
    let (x, y) = (start(place.0, x), start(place.1, y));
    let level = start(level_index, quadratic.level_refined);
    let sign = f64::from(dog.at(level_index, place.0, place.1)).signum();
    let (sample, below) = (level_index as f64, if level_index == 1 { BELOW_FIRST } else { NEAREST });
    let within = sample - below - STRAY..sample + NEAREST + STRAY;
    let peak = first.ascend((x, y), level, within, sign)?;
    let offset = [peak.x - place.0 as f64, peak.y - place.1 as f64, peak.level - sample];
    let level_reach = if offset[2] < 0.0 { below } else { NEAREST };
    let Peak { level: level_refined, value, curvature, .. } = peak;
    Some(Fit { x: place.0, y: place.1, offset, level_refined, level_reach, value, curvature })
}

/// Quadratic fit in place and scale around (x, y, level `s`), after up to [`MAX_FITS`] − 1 moves of a pixel; `None`
/// where its equations have no unique solution. `size` is the octave's.
fn quadratic(dog: &DogTile, (mut x, mut y): (usize, usize), s: usize, (width, height): (usize, usize)) -> Option<Fit> {
    let (mut hessian, mut gradient, mut offset);
    let mut moves = 0;
    loop {
        let at = |dx: i32, dy: i32, ds: i32| {
            let (x, y) = ((x as i32 + dx) as usize, (y as i32 + dy) as usize);
            f64::from(dog.at((s as i32 + ds) as usize, x, y))
        };
        let here = at(0, 0, 0);
        let second = |plus: f64, minus: f64| plus + minus - 2.0 * here;
        let cross = |pp: f64, mm: f64, pm: f64, mp: f64| 0.25 * (pp + mm - pm - mp);
        gradient = [
            0.5 * (at(1, 0, 0) - at(-1, 0, 0)),
            0.5 * (at(0, 1, 0) - at(0, -1, 0)),
            0.5 * (at(0, 0, 1) - at(0, 0, -1)),
        ];
        let (xx, yy, ss) =
            (second(at(1, 0, 0), at(-1, 0, 0)), second(at(0, 1, 0), at(0, -1, 0)), second(at(0, 0, 1), at(0, 0, -1)));
        let xy = cross(at(1, 1, 0), at(-1, -1, 0), at(1, -1, 0), at(-1, 1, 0));
        let xs = cross(at(1, 0, 1), at(-1, 0, -1), at(1, 0, -1), at(-1, 0, 1));
        let ys = cross(at(0, 1, 1), at(0, -1, -1), at(0, 1, -1), at(0, -1, 1));
        hessian = [[xx, xy, xs], [xy, yy, ys], [xs, ys, ss]];
        offset = solve(hessian, gradient)?;
        // Moves stay inside: the fit needs a pixel on each side.
        let step = |offset: f64, at: usize, end: usize| -> i32 {
            i32::from(offset > 0.6 && at + 2 < end) - i32::from(offset < -0.6 && at > 1)
        };
        let (dx, dy) = (step(offset[0], x, width), step(offset[1], y, height));
        if (dx == 0 && dy == 0) || moves == MAX_FITS - 1 {
            break;
        }
        x = (x as i32 + dx) as usize;
        y = (y as i32 + dy) as usize;
        moves += 1;
    }
    // As in VLFeat, the value follows from the last fit even where it did not settle.
    let here = f64::from(dog.at(s, x, y));
    let value = here + 0.5 * (0..3).map(|i| gradient[i] * offset[i]).sum::<f64>();
    let [[xx, xy, _], [_, yy, _], _] = hessian;
    let (level_refined, curvature) = (s as f64 + offset[2], [xx, xy, yy]);
    Some(Fit { x, y, offset, level_refined, level_reach: MAX_OFFSET, value, curvature })
}

/// Offset of the peak of a bump from its middle sample, in steps within ±1, from three equally spaced samples of which
/// the middle one is the largest in magnitude. 0 where the samples have no peak.
pub fn peak_offset(before: f32, here: f32, after: f32) -> f32 {
    let sign = here.signum();
    let (a, b, c) = (f64::from(sign * before), f64::from(sign * here), f64::from(sign * after));
    // Logarithms need samples well above zero; below a hundredth of the peak they would only amplify noise.
    let floor = 0.01 * b;
    let (a, b, c) = if a > floor && c > floor { (a.ln(), b.ln(), c.ln()) } else { (a, b, c) };
    let curvature = a - 2.0 * b + c;
    if curvature >= 0.0 {
        return 0.0;
    }
    (0.5 * (a - c) / curvature).clamp(-1.0, 1.0) as f32
}

/// Offset of the peak of a bump from the middle of 3×3 samples `values[j][i]`, in steps along (i, j), each within ±1. A
/// quadratic is fitted to the logarithms by least squares; where that fails, each axis is fitted alone.
pub fn peak_offset_2d(values: [[f32; 3]; 3]) -> (f32, f32) {
    let separate = || {
        (peak_offset(values[1][0], values[1][1], values[1][2]), peak_offset(values[0][1], values[1][1], values[2][1]))
    };
    let here = f64::from(values[1][1]);
    let sign = here.signum();
    let mut z = [[0.0f64; 3]; 3];
    for (out, row) in z.iter_mut().zip(values) {
        for (out, value) in out.iter_mut().zip(row) {
            let value = sign * f64::from(value);
            if value <= 0.01 * here.abs() {
                return separate();
            }
            *out = value.ln();
        }
    }
    // Least squares for z = c + gx·i + gy·j + (hxx·i² + 2·hxy·i·j + hyy·j²)/2 over i, j in −1 … 1.
    let column = |i: usize| z[0][i] + z[1][i] + z[2][i];
    let row = |j: usize| z[j].iter().sum::<f64>();
    let (gx, gy) = ((column(2) - column(0)) / 6.0, (row(2) - row(0)) / 6.0);
    let hxx = (column(0) + column(2) - 2.0 * column(1)) / 3.0;
    let hyy = (row(0) + row(2) - 2.0 * row(1)) / 3.0;
    let hxy = (z[0][0] + z[2][2] - z[0][2] - z[2][0]) / 4.0;
    let determinant = hxx * hyy - hxy * hxy;
    // A saddle or a ridge has no peak in two dimensions; an axis alone may still have one.
    if !(hxx < 0.0 && determinant > 0.0) {
        return separate();
    }
    let (i, j) = ((hxy * gy - hyy * gx) / determinant, (hxy * gx - hxx * gy) / determinant);
    (i.clamp(-1.0, 1.0) as f32, j.clamp(-1.0, 1.0) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plane::tile::{Region, Tile};

    /// Tile whose D is a Gaussian bump of the given centre and spread along u, v and level.
    fn bump(centre: [f64; 3], spread: [f64; 3], amplitude: f64) -> DogTile {
        let levels = (0..5)
            .map(|s| {
                let mut rows = Tile::default();
                rows.reset(&Region { columns: 0..40, rows: 0..40 }, 40);
                for v in 0..40 {
                    for u in 0..40 {
                        let at = [u as f64, v as f64, s as f64];
                        let d2: f64 = (0..3).map(|i| ((at[i] - centre[i]) / spread[i]).powi(2)).sum();
                        rows.row_mut(v)[u] = (amplitude * (-0.5 * d2).exp()) as f32;
                    }
                }
                rows
            })
            .collect();
        DogTile { levels }
    }

    const ROUND: [f64; 3] = [4.0, 4.0, 1.5];

    fn refined(dog: &DogTile, place: (usize, usize)) -> Result<Fit, Test> {
        let limits = Limits { gate: 0.1, peak_threshold: 0.2, edge_threshold: 10.0 };
        refine((dog, None), place, 2, (40, 40), limits)
    }

    #[test]
    fn a_bump_is_found_between_samples_even_from_two_pixels_off() {
        let fit = refined(&bump([20.3, 18.8, 2.2], ROUND, -0.5), (20, 19)).expect("a clean bump");
        let (x, y) = fit.place();
        assert!((x - 20.3).abs() < 0.02 && (y - 18.8).abs() < 0.02 && (fit.level_refined - 2.2).abs() < 0.03);
        assert!((fit.value + 0.5).abs() < 0.01);
        let moved = refined(&bump([22.0, 20.0, 2.0], ROUND, 0.5), (20, 20)).expect("it moves");
        assert_eq!((moved.x, moved.y), (22, 20));
    }

    #[test]
    fn weak_bumps_and_ridges_are_rejected_by_name() {
        for (spread, amplitude, test) in [
            (ROUND, 0.15, Test::InterpolatedContrast),
            (ROUND, 0.05, Test::NoiseGate),
            ([2.0, 30.0, 1.0], 1.0, Test::Edge),
        ] {
            assert_eq!(refined(&bump([20.0, 20.0, 2.0], spread, amplitude), (20, 20)), Err(test));
        }
    }

    #[test]
    fn slope_peaks_are_exact_for_gaussian_bumps() {
        let bump = |x: f32| -(-0.5 * ((x - 0.3) / 0.8).powi(2)).exp();
        assert!((peak_offset(bump(-1.0), bump(0.0), bump(1.0)) - 0.3).abs() < 1e-4);
        assert_eq!(peak_offset(1.0, 1.0, 1.0), 0.0);
        let bump2 = |i: i32, j: i32| {
            let (x, y) = (i as f32 - 0.2, j as f32 + 0.4);
            (-0.5 * (x * x + y * y + 0.6 * x * y)).exp()
        };
        let values = std::array::from_fn(|j| std::array::from_fn(|i| bump2(i as i32 - 1, j as i32 - 1)));
        let (i, j) = peak_offset_2d(values);
        assert!((i - 0.2).abs() < 1e-4 && (j + 0.4).abs() < 1e-4, "{i} {j}");
    }
}
