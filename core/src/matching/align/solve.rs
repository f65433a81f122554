//! One correction for each place, from the measured matches of all pairs of images.
//!
//! A match says where A's place lies in B, so a place with several matches is measured several times. The corrections c
//! minimise the weighted sum of |c_b − J·c_a − e|²/s² over the matches, besides a weak prior of [`PRIOR`] σ on each. A
//! match that contradicts the others loses its weight (Geman and McClure's function, by iteratively reweighted least
//! squares). A place that would move farther than it may stays, and the others are solved for without its matches.

use super::pair::Measured;
use crate::monitor::{Cancelled, Monitor};
use rayon::prelude::*;
use std::collections::{BTreeMap, HashMap};

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
const REMAINDER: f64 = 1e-5;
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
        Self { of_feature: features.into_iter().enumerate().map(place).collect(), first }
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
    let (mut is_refused, mut is_open) = (vec![false; sigmas.len()], vec![true; sigmas.len()]);
    for _ in 0..PASSES {
        // Open places begin at 0 again. One that lost all its matches is in no component, and stays there.
        corrections.iter_mut().zip(&is_open).filter(|(_, open)| **open).for_each(|(of_place, _)| *of_place = [0.0; 2]);
        let components = Component::all(&terms, &is_open);
        let solved = components.par_iter().map(|component| component.solved(&prior, monitor));
        for (component, solved) in components.iter().zip(solved.collect::<Result<Vec<_>, _>>()?) {
            component.places.iter().zip(solved).for_each(|(place, solved)| corrections[*place] = solved);
        }
        is_open.fill(false);
        for (place, correction) in corrections.iter_mut().enumerate() {
            if *correction != [0.0; 2] && !may_move(place, *correction) {
                (*correction, is_refused[place]) = ([0.0; 2], true);
            }
        }
        // Matches of refused places no longer press on the others.
        for term in terms.iter_mut().filter(|term| term.confidence > 0.0 && (is_refused[term.a] || is_refused[term.b]))
        {
            (term.confidence, is_open[term.a], is_open[term.b]) = (0.0, true, true);
        }
        if !is_open.contains(&true) {
            break;
        }
    }
    let residuals_px = terms.iter().map(|term| term.residual(&corrections)).collect();
    Ok(Solved { corrections, residuals_px, refused: is_refused.iter().filter(|refused| **refused).count() })
}

#[derive(Clone, Copy)]
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
}

/// Connected component of places and matches: its corrections do not depend on those of other components.
#[derive(Default)]
struct Component {
    places: Vec<usize>,
    /// Matches between its places, which are numbered within the component.
    terms: Vec<Term>,
}

impl Component {
    /// Components with a place that `is_open`, in the order of their first places.
    fn all(terms: &[Term], is_open: &[bool]) -> Vec<Self> {
        // Each place leads to an earlier one of its component; the first leads to itself.
        let mut earlier: Vec<usize> = (0..is_open.len()).collect();
        let mut first = |mut place: usize, to: Option<usize>| {
            while earlier[place] != place {
                earlier[place] = earlier[earlier[place]];
                place = earlier[place];
            }
            earlier[place] = to.map_or(place, |to| to.min(place));
            place
        };
        let known = || terms.iter().filter(|term| term.confidence > 0.0);
        for term in known() {
            let (a, b) = (first(term.a, None), first(term.b, None));
            first(a.max(b), Some(a.min(b)));
        }
        let mut components: BTreeMap<usize, Self> = BTreeMap::new();
        known().for_each(|term| components.entry(first(term.a, None)).or_default().terms.push(*term));
        components.retain(|_, component| component.terms.iter().any(|term| is_open[term.a] || is_open[term.b]));
        let mut within = vec![0; is_open.len()];
        for (place, within) in within.iter_mut().enumerate() {
            if let Some(component) = components.get_mut(&first(place, None)) {
                *within = component.places.len();
                component.places.push(place);
            }
        }
        let terms = components.values_mut().flat_map(|component| &mut component.terms);
        terms.for_each(|term| (term.a, term.b) = (within[term.a], within[term.b]));
        components.into_values().collect()
    }

    /// Corrections of its places.
    fn solved(&self, prior: &[f64], monitor: &Monitor) -> Result<Vec<Uv>, Cancelled> {
        let prior: Vec<f64> = self.places.iter().map(|place| prior[*place]).collect();
        let mut corrections = vec![[0.0; 2]; prior.len()];
        let mut weights: Vec<f64> = self.terms.iter().map(|term| term.confidence).collect();
        for _ in 0..ROUNDS {
            System::new(&self.terms, &weights, &prior).solve(&mut corrections, monitor)?;
            let robust = |term: &Term| {
                term.confidence / (1.0 + (term.residual(&corrections) / (2.0 * NOISE_PX)).powi(2)).powi(2)
            };
            weights = self.terms.iter().map(robust).collect();
        }
        Ok(corrections)
    }
}

/// The normal equations of a component.
struct System {
    /// Blocks on the diagonal, and their inverses: (uu, uv, vv) of each place.
    blocks: Vec<[f64; 3]>,
    inverses: Vec<[f64; 3]>,
    /// Places of a term, and minus its block between them, of rows of B by columns of A.
    between: Vec<([u32; 2], [Uv; 2])>,
    right: Vec<Uv>,
}

impl System {
    fn new(terms: &[Term], weights: &[f64], prior: &[f64]) -> Self {
        let mut blocks: Vec<[f64; 3]> = prior.iter().map(|&prior| [prior, 0.0, prior]).collect();
        let mut right = vec![[0.0; 2]; prior.len()];
        let mut between = Vec::with_capacity(terms.len());
        for (&Term { a, b, jacobian, shift, scale, .. }, weight) in terms.iter().zip(weights) {
            let weight = weight * (scale / NOISE_PX).powi(2);
            let [[xx, xy], [yx, yy]] = jacobian;
            let of_a = [xx * xx + yx * yx, xx * xy + yx * yy, xy * xy + yy * yy];
            blocks[a].iter_mut().zip(of_a).for_each(|(block, x)| *block += weight * x);
            blocks[b][0] += weight;
            blocks[b][2] += weight;
            let row = jacobian.map(|row| row.map(|x| weight * x));
            for i in 0..2 {
                right[b][i] += weight * shift[i];
                right[a][i] -= row[0][i] * shift[0] + row[1][i] * shift[1];
            }
            between.push(([a as u32, b as u32], row));
        }
        // The prior keeps every block positive: each has an inverse.
        let inverse = |&[uu, uv, vv]: &[f64; 3]| {
            let determinant = uu * vv - uv * uv;
            [vv / determinant, -uv / determinant, uu / determinant]
        };
        Self { inverses: blocks.iter().map(inverse).collect(), blocks, between, right }
    }

    fn times(&self, of: &[Uv], product: &mut [Uv]) {
        scale(&self.blocks, of, product);
        for &([a, b], [[uu, uv], [vu, vv]]) in &self.between {
            let ([au, av], [bu, bv]) = (of[a as usize], of[b as usize]);
            let b = &mut product[b as usize];
            *b = [b[0] - (uu * au + uv * av), b[1] - (vu * au + vv * av)];
            let a = &mut product[a as usize];
            *a = [a[0] - (uu * bu + vu * bv), a[1] - (uv * bu + vv * bv)];
        }
    }

    /// Improves `solution` by preconditioned conjugate gradients.
    fn solve(&self, solution: &mut [Uv], monitor: &Monitor) -> Result<(), Cancelled> {
        let mut product = vec![[0.0; 2]; self.right.len()];
        let (mut conditioned, mut remainder) = (product.clone(), self.right.clone());
        scale(&self.inverses, &self.right, &mut conditioned);
        // Relative to the right side, so that rounds that begin near the solution end soon.
        let enough = REMAINDER * REMAINDER * dot(&self.right, &conditioned);
        // A warm start: the remainder is what the last round's solution leaves.
        self.times(solution, &mut product);
        add(&mut remainder, -1.0, &product);
        scale(&self.inverses, &remainder, &mut conditioned);
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
            scale(&self.inverses, &remainder, &mut conditioned);
            let falls = dot(&remainder, &conditioned);
            let keep = falls / fall;
            direction.iter_mut().zip(&conditioned).for_each(|(d, n)| *d = [n[0] + keep * d[0], n[1] + keep * d[1]]);
            fall = falls;
        }
        Ok(())
    }
}

/// Products of symmetric blocks (uu, uv, vv) with `of`.
fn scale(blocks: &[[f64; 3]], of: &[Uv], product: &mut [Uv]) {
    for ((product, x), block) in product.iter_mut().zip(of).zip(blocks) {
        *product = [block[0] * x[0] + block[1] * x[1], block[1] * x[0] + block[2] * x[1]];
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
        let mut links = Vec::new();
        for (x, y) in (0..views).flat_map(|x| (x + 1..views).map(move |y| (x, y))) {
            let (sin, cos) = (0.3 * (y - x) as f64).sin_cos();
            let jacobian = [[cos, -sin], [sin, cos]].map(|row| row.map(|c| c * (10 + y) as f64 / (10 + x) as f64));
            for k in 0..count {
                let (a, b) = (x * count + k, y * count + k);
                let term = Term { a, b, jacobian, shift: [0.0; 2], scale: 1.0, confidence: 1.0 };
                let measured = Measured { shift_px: term.apart(&truth), jacobian, correlation: 0.95 };
                links.push(Link { a, b, measured });
            }
        }
        (vec![4.0; truth.len()], truth, links)
    }

    #[test]
    fn what_all_pairs_say_is_satisfied() {
        let (sigmas, truth, links) = exact();
        let found = solved(&sigmas, &links);
        let contradiction = found.residuals_px.iter().copied().fold(0.0, f64::max);
        assert!(contradiction < 0.05, "{contradiction}");
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
    fn refused_places_and_other_components_leave_places_alone() {
        let own = [link(0, 1, [1.0, 0.0], 0.9), link(1, 2, [0.0, 0.4], 0.8)];
        let far = [link(3, 4, [8.0, 0.0], 1.0), link(2, 3, [0.0, 7.0], 0.9)];
        // Place 3 stays where it is. Place 4 has a match with place 3 alone; place 2 keeps its match with place 1.
        let found = solve(&[2.0; 5], &[own, far].concat(), |place, _| place != 3, &Monitor::default());
        let (found, alone) = (found.expect("not cancelled"), solved(&[2.0; 3], &own));
        assert_eq!((&found.corrections[..3], found.refused), (&alone.corrections[..], 1));
        assert_eq!(found.corrections[3..], [[0.0; 2]; 2]);
    }

    #[test]
    fn cancelling_leaves_no_result() {
        assert_eq!(solve(&[1.0; 2], &[link(0, 1, [1.0; 2], 1.0)], |_, _| true, &Monitor::cancelled()), Err(Cancelled));
    }
}
