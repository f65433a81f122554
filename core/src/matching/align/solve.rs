//! One correction for each place, from the measured matches of all pairs of images.
//!
//! A match says where A's place lies in B, so a place with several matches is measured several times. The corrections c
//! minimise the weighted sum of |c_b − J·c_a − e|²/s² over the matches, besides a weak prior of [`PRIOR`] σ on each. A
//! match that contradicts the others loses its weight (Geman and McClure's function, by iteratively reweighted least
//! squares). A place that would move farther than it may stays, and the others are solved for without its matches.

use super::pair::Measured;
use crate::monitor::{Cancelled, Monitor};
use std::collections::HashMap;

/// Standard deviation of a correction before anything is measured, scales σ of the place.
pub const PRIOR: f64 = 2.0;
/// Standard deviation of a measured shift, pixels.
pub const NOISE_PX: f64 = 0.5;
/// Correlation from which on a match counts; its weight grows with the square of the rest.
const LEAST_CORRELATION: f64 = 0.5;
/// Solutions with weights from the one before.
const ROUNDS: usize = 8;
/// Conjugate-gradient steps in a round, which begins where the last one ended, and the share that may remain.
const STEPS: usize = 100;
const REMAINDER: f64 = 1e-3;
/// Solutions in which places are refused, each without the matches of those before.
const PASSES: usize = 4;
/// Least change of scale that is believed.
const LEAST_SCALE: f64 = 0.3;

type Uv = [f64; 2];

/// Places of an image's features: those of several orientations share one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Places {
    /// Place of each feature, counted in the order of the features.
    pub of_feature: Vec<usize>,
    /// First feature of each place.
    pub first: Vec<usize>,
}

impl Places {
    /// Places of features at (u, v, σ): equal numbers are one place.
    pub fn of(features: impl IntoIterator<Item = [f32; 3]>) -> Self {
        let (mut known, mut first) = (HashMap::new(), Vec::new());
        let place = |(index, at): (usize, [f32; 3])| {
            *known.entry(at.map(f32::to_bits)).or_insert_with(|| {
                first.push(index);
                first.len() - 1
            })
        };
        let of_feature = features.into_iter().enumerate().map(place).collect();
        Self { of_feature, first }
    }
}

/// A measured match between two places, counted over all images.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Link {
    /// Place in A.
    pub a: usize,
    /// Place in B.
    pub b: usize,
    /// Measurement of B's place from A's.
    pub measured: Measured,
}

/// Corrections on which the matches agree best.
#[derive(Debug, Clone, PartialEq)]
pub struct Solved {
    /// Correction (u, v) of each place, pixels: exactly 0 where nothing was measured.
    pub corrections: Vec<[f64; 2]>,
    /// Contradiction of each link with the corrections, pixels: the mean of those of A and B.
    pub residuals_px: Vec<f64>,
    /// Number of places that stay because they would be moved too far.
    pub refused: usize,
}

/// Solves for corrections of places of scales `sigmas`, pixels, from `links`. `may_move` decides how far places move.
///
/// # Errors
/// [`Cancelled`] once `monitor` was cancelled.
///
/// # Panics
/// When a link names a place that does not exist: a mistake of the caller.
pub fn solve(
    sigmas: &[f32],
    links: &[Link],
    may_move: impl Fn(usize, [f64; 2]) -> bool,
    monitor: &Monitor,
) -> Result<Solved, Cancelled> {
    let mut terms: Vec<Term> = links.iter().map(Term::of).collect();
    let prior: Vec<f64> = sigmas.iter().map(|sigma| (PRIOR * f64::from(*sigma)).powi(-2)).collect();
    let mut corrections = vec![[0.0; 2]; sigmas.len()];
    let mut is_refused = vec![false; sigmas.len()];
    for _ in 0..PASSES {
        // Weights begin anew: matches of refused places no longer press on the others.
        let mut weights: Vec<f64> = terms.iter().map(|term| term.confidence).collect();
        for _ in 0..ROUNDS {
            let system = System::new(&terms, &weights, &prior);
            system.solve(&mut corrections, monitor)?;
            let robust = |term: &Term| {
                term.confidence / (1.0 + (term.residual(&corrections) / (2.0 * NOISE_PX)).powi(2)).powi(2)
            };
            weights = terms.iter().map(robust).collect();
        }
        // Places that would move too far stay at 0 from here on.
        let mut is_done = true;
        for (place, correction) in corrections.iter_mut().enumerate() {
            if *correction != [0.0; 2] && !may_move(place, *correction) {
                (*correction, is_refused[place], is_done) = ([0.0; 2], true, false);
            }
        }
        if is_done {
            break;
        }
        terms.iter_mut().filter(|term| is_refused[term.a] || is_refused[term.b]).for_each(|term| term.confidence = 0.0);
    }
    let residuals_px = terms.iter().map(|term| term.residual(&corrections)).collect();
    Ok(Solved { corrections, residuals_px, refused: is_refused.iter().filter(|refused| **refused).count() })
}

struct Term {
    a: usize,
    b: usize,
    jacobian: [Uv; 2],
    shift: Uv,
    /// One over the root of the scale of B over A: residuals of both images are worth the same.
    scale: f64,
    /// Weight before any contradiction, 0 … 1.
    confidence: f64,
}

impl Term {
    fn of(link: &Link) -> Self {
        let Measured { shift_px, jacobian, correlation } = link.measured;
        let [[xx, xy], [yx, yy]] = jacobian;
        let scale = (xx * yy - xy * yx).abs().sqrt().max(LEAST_SCALE).sqrt().recip();
        let confidence = ((correlation - LEAST_CORRELATION) / (1.0 - LEAST_CORRELATION)).clamp(0.0, 1.0).powi(2);
        Self { a: link.a, b: link.b, jacobian, shift: shift_px, scale, confidence }
    }

    /// c_b − J·c_a.
    fn apart(&self, corrections: &[Uv]) -> Uv {
        let (a, b) = (corrections[self.a], corrections[self.b]);
        [0, 1].map(|i| b[i] - (self.jacobian[i][0] * a[0] + self.jacobian[i][1] * a[1]))
    }

    fn residual(&self, corrections: &[Uv]) -> f64 {
        let [u, v] = self.apart(corrections);
        self.scale * (u - self.shift[0]).hypot(v - self.shift[1])
    }

    /// Adds the term's part of Aᵀ·`of` times `weight` to `sums`.
    fn spread(&self, of: Uv, weight: f64, sums: &mut [Uv]) {
        for i in 0..2 {
            sums[self.b][i] += weight * of[i];
            sums[self.a][i] -= weight * (self.jacobian[0][i] * of[0] + self.jacobian[1][i] * of[1]);
        }
    }
}

struct System<'a> {
    terms: Vec<(&'a Term, f64)>,
    prior: &'a [f64],
}

impl<'a> System<'a> {
    fn new(terms: &'a [Term], weights: &[f64], prior: &'a [f64]) -> Self {
        let known = terms.iter().zip(weights).filter(|(_, weight)| **weight > 0.0);
        Self { terms: known.map(|(term, weight)| (term, weight * (term.scale / NOISE_PX).powi(2))).collect(), prior }
    }

    fn times(&self, of: &[Uv], product: &mut [Uv]) {
        for ((product, x), prior) in product.iter_mut().zip(of).zip(self.prior) {
            *product = x.map(|x| prior * x);
        }
        self.terms.iter().for_each(|(term, weight)| term.spread(term.apart(of), *weight, product));
    }

    fn right_side(&self) -> Vec<Uv> {
        let mut sums = vec![[0.0; 2]; self.prior.len()];
        self.terms.iter().for_each(|(term, weight)| term.spread(term.shift, *weight, &mut sums));
        sums
    }

    /// Inverses of the matrix's blocks on the diagonal: (uu, uv, vv) of each place.
    fn preconditioner(&self) -> Vec<[f64; 3]> {
        let mut blocks: Vec<[f64; 3]> = self.prior.iter().map(|&prior| [prior, 0.0, prior]).collect();
        for &(term, weight) in &self.terms {
            let [[xx, xy], [yx, yy]] = term.jacobian;
            let of_a = [xx * xx + yx * yx, xx * xy + yx * yy, xy * xy + yy * yy];
            // The prior keeps every block positive: a place without a match has an inverse too.
            blocks[term.a].iter_mut().zip(of_a).for_each(|(block, x)| *block += weight * x);
            blocks[term.b][0] += weight;
            blocks[term.b][2] += weight;
        }
        let inverse = |[uu, uv, vv]: [f64; 3]| {
            let determinant = uu * vv - uv * uv;
            [vv / determinant, -uv / determinant, uu / determinant]
        };
        blocks.into_iter().map(inverse).collect()
    }

    /// Improves `solution` by preconditioned conjugate gradients. A place without a term keeps exactly what it has.
    fn solve(&self, solution: &mut [Uv], monitor: &Monitor) -> Result<(), Cancelled> {
        let (right, blocks) = (self.right_side(), self.preconditioner());
        let condition = |from: &[Uv], to: &mut [Uv]| {
            for ((to, r), b) in to.iter_mut().zip(from).zip(&blocks) {
                *to = [b[0] * r[0] + b[1] * r[1], b[1] * r[0] + b[2] * r[1]];
            }
        };
        let mut product = vec![[0.0; 2]; right.len()];
        let (mut conditioned, mut remainder) = (product.clone(), right.clone());
        condition(&right, &mut conditioned);
        // Relative to the right side, so that rounds that begin near the solution end soon.
        let enough = REMAINDER * REMAINDER * dot(&right, &conditioned);
        // A warm start: the remainder is what the last round's solution leaves.
        self.times(solution, &mut product);
        add(&mut remainder, -1.0, &product);
        condition(&remainder, &mut conditioned);
        let mut direction = conditioned.clone();
        let mut fall = dot(&remainder, &conditioned);
        for _ in 0..STEPS {
            monitor.check()?;
            if fall <= enough {
                break;
            }
            self.times(&direction, &mut product);
            let length = fall / dot(&direction, &product);
            add(solution, length, &direction);
            add(&mut remainder, -length, &product);
            condition(&remainder, &mut conditioned);
            let falls = dot(&remainder, &conditioned);
            let keep = falls / fall;
            direction.iter_mut().zip(&conditioned).for_each(|(d, n)| *d = [n[0] + keep * d[0], n[1] + keep * d[1]]);
            fall = falls;
        }
        Ok(())
    }
}

fn dot(a: &[Uv], b: &[Uv]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a[0] * b[0] + a[1] * b[1]).sum()
}

fn add(to: &mut [Uv], factor: f64, of: &[Uv]) {
    to.iter_mut().zip(of).for_each(|(to, x)| *to = [to[0] + factor * x[0], to[1] + factor * x[1]]);
}

#[cfg(test)]
mod tests {
    use super::*;

    const IDENTITY: [Uv; 2] = [[1.0, 0.0], [0.0, 1.0]];

    fn link(a: usize, b: usize, shift_px: Uv, correlation: f64) -> Link {
        Link { a, b, measured: Measured { shift_px, jacobian: IDENTITY, correlation } }
    }

    fn solved(sigmas: &[f32], links: &[Link]) -> Solved {
        solve(sigmas, links, |_, _| true, &Monitor::default()).expect("not cancelled")
    }

    #[test]
    fn places_without_a_measurement_stay_to_the_bit() {
        assert_eq!(solved(&[2.0, 3.0], &[]).corrections, [[0.0; 2]; 2]);
        let found = solved(&[2.0; 5], &[link(0, 1, [1.0, 0.0], 0.9), link(2, 3, [1.0, 0.0], 0.5)]);
        assert!(found.corrections[0][0] < -0.3 && found.corrections[1][0] > 0.3, "{found:?}");
        assert_eq!(found.corrections[2..], [[0.0; 2]; 3], "a correlation of 0.5 says nothing");
        assert_eq!(found.residuals_px[1], 1.0);
    }

    /// Six views of 30 places of known errors, measured exactly; view k sees all turned and 1 + k/10 times as large.
    fn exact() -> (Vec<f32>, Vec<Uv>, Vec<Link>) {
        let mut random = crate::synth::random::Stream::new(5, 0);
        let (views, count) = (6, 30);
        let truth: Vec<Uv> = (0..views * count).map(|_| [random.normal(), random.normal()]).collect();
        let matrix = |view: usize| {
            let (sin, cos) = (0.3 * view as f64).sin_cos();
            let scale = 1.0 + 0.1 * view as f64;
            [[scale * cos, -scale * sin], [scale * sin, scale * cos]]
        };
        let mut links = Vec::new();
        for (x, y) in (0..views).flat_map(|x| (x + 1..views).map(move |y| (x, y))) {
            let ([[a, b], [c, d]], to) = (matrix(x), matrix(y));
            let determinant = a * d - b * c;
            let back = [[d, -b], [-c, a]].map(|row| row.map(|x| x / determinant));
            let jacobian = [0, 1].map(|i| [0, 1].map(|j| to[i][0] * back[0][j] + to[i][1] * back[1][j]));
            for k in 0..count {
                let (a, b) = (x * count + k, y * count + k);
                let term = Term { a, b, jacobian, shift: [0.0; 2], scale: 1.0, confidence: 1.0 };
                links.push(Link {
                    a,
                    b,
                    measured: Measured { shift_px: term.apart(&truth), jacobian, correlation: 0.95 },
                });
            }
        }
        (vec![4.0; truth.len()], truth, links)
    }

    /// Largest distance of corrections from the truth, apart from what all views of a place have in common.
    fn contradiction(found: &Solved) -> f64 {
        found.residuals_px.iter().copied().fold(0.0, f64::max)
    }

    #[test]
    fn what_all_pairs_say_is_satisfied() {
        let (sigmas, truth, links) = exact();
        let found = solved(&sigmas, &links);
        assert!(contradiction(&found) < 0.05, "{}", contradiction(&found));
        // The prior makes the common part small; the rest of the errors is found.
        let length = |all: &[Uv]| dot(all, all);
        let left: Vec<Uv> = found.corrections.iter().zip(&truth).map(|(a, b)| [a[0] - b[0], a[1] - b[1]]).collect();
        assert!(length(&left) < 0.3 * length(&truth), "{} of {}", length(&left), length(&truth));
    }

    #[test]
    fn an_outlier_does_not_move_its_place() {
        let (sigmas, _, mut links) = exact();
        let without = solved(&sigmas, &links);
        let index = 40;
        links[index].measured.shift_px[0] += 9.0;
        let with = solved(&sigmas, &links);
        let moved = |place: usize| {
            let (a, b) = (without.corrections[place], with.corrections[place]);
            (a[0] - b[0]).hypot(a[1] - b[1])
        };
        let most = (0..sigmas.len()).map(moved).fold(0.0, f64::max);
        assert!(most < 0.05, "{most}");
        assert!(with.residuals_px[index] > 7.0, "{}", with.residuals_px[index]);
    }

    #[test]
    fn cancelling_leaves_no_result() {
        assert_eq!(solve(&[1.0; 2], &[link(0, 1, [1.0; 2], 1.0)], |_, _| true, &Monitor::cancelled()), Err(Cancelled));
    }
}
