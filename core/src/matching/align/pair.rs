//! All matches of a pair of images, measured by their chips.
//!
//! The angle and the scale of a single feature are too uncertain to bring two chips to one another. The matches of a
//! pair agree on one rotation and one ratio of scales, which are known well; the affine fit finds the rest.

use super::chip::Chip;
use super::grid::{Affine, Grid, OnLattice};
use super::lucas_kanade::{FitScratch, Window};
use super::search::{Search, SearchScratch};
use crate::monitor::{Cancelled, Monitor};
use rayon::prelude::*;
use std::f32::consts::{PI, TAU};

/// Radius of the affine fit, σ. Where depth steps are near, 8 is better.
pub const FIT_RADIUS: f32 = 12.0;

/// Window of a fit from an expected place on, σ, least correlation there, and change that ends it, σ. With 12 σ, 0.3
/// and no end a dataset takes a fifth longer and has a twentieth more right matches.
const NEAR_RADIUS: f32 = 8.0;
const NEAR_CORRELATION: f32 = 0.55;
const STILL_SIGMAS: f32 = 0.05;

/// Angles, over a full turn, at which the density of the differences is looked at.
const ANGLES: usize = 180;
/// Width of the density's kernel, radians.
const ANGLE_KERNEL: f32 = 0.1;
/// Differences that are averaged for the rotation, radians from the mode.
const NEAR_MODE: f32 = 0.5;
/// Matches whose ratios of scales count, radians from the rotation; all do where there are fewer than `ENOUGH`.
const ALIKE: f32 = 0.4;
const ENOUGH: usize = 10;

/// A matched feature of one image.
#[derive(Debug, Clone, Copy)]
pub struct View<'a> {
    /// Chip of its place.
    pub chip: &'a Chip,
    /// Orientation, radians from +u towards +v.
    pub orientation: f32,
}

/// Rotation and ratio of scales between two images, as most of their matches have them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PairFrame {
    /// Angle by which directions in A are turned in B, radians from +u towards +v, of (−π, π].
    pub rotation: f32,
    /// Natural logarithm of the scale in B over that in A.
    pub log_ratio: f32,
}

/// Motion of B's place that lays its chip over A's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measured {
    /// Shift of B's place (u, v), pixels: where A's place lies in B.
    pub shift_px: [f64; 2],
    /// How the place in B moves with that in A: rows u and v of B by columns u and v of A.
    pub jacobian: [[f64; 2]; 2],
    /// Correlation of the chips, −1 … 1, after the fit.
    pub correlation: f64,
}

impl Measured {
    /// Angle by which A is turned in B, radians from +u towards +v, and ratio of B's scale to A's.
    pub fn rotation_and_ratio(&self) -> (f64, f64) {
        let [[uu, uv], [vu, vv]] = self.jacobian;
        ((vu - uv).atan2(uu + vv), (uu * vv - uv * vu).abs().sqrt())
    }
}

/// Angle brought into (−π, π].
fn wrapped(angle: f32) -> f32 {
    PI - (PI - angle).rem_euclid(TAU)
}

fn median(mut values: Vec<f32>) -> Option<f32> {
    values.sort_unstable_by(f32::total_cmp);
    let (low, high) = (values.len().checked_sub(1)? / 2, values.len() / 2);
    Some(0.5 * (values[low] + values[high]))
}

impl PairFrame {
    /// Frame of the matches `pairs` of A and B: the mode of the differences of orientations, and the median ratio of
    /// the scales of those that are turned so. No rotation and equal scales where there are none.
    pub fn of(pairs: &[[View<'_>; 2]]) -> Self {
        let turned: Vec<f32> = pairs.iter().map(|[a, b]| wrapped(b.orientation - a.orientation)).collect();
        // Von Mises kernels: a mode, unlike a mean, is not drawn off by wrong matches.
        let density = |angle: f32| {
            let near = |turned: &f32| ((turned - angle).cos() - 1.0) / (ANGLE_KERNEL * ANGLE_KERNEL);
            turned.iter().map(|turned| near(turned).exp()).sum::<f32>()
        };
        let angles = (0..ANGLES).map(|k| TAU * k as f32 / ANGLES as f32 - PI);
        let mode =
            angles.map(|angle| (density(angle), angle)).fold((f32::MIN, 0.0), |a, b| if b.0 > a.0 { b } else { a });
        // The median near the mode is finer than the angles that were compared.
        let from_mode = || turned.iter().map(|turned| wrapped(turned - mode.1));
        let beyond = median(from_mode().filter(|apart| apart.abs() < NEAR_MODE).collect()).unwrap_or(0.0);
        let rotation = wrapped(mode.1 + beyond);
        let ratio = |[a, b]: &[View<'_>; 2]| (b.chip.sigma / a.chip.sigma).ln();
        let alike = pairs.iter().zip(&turned).filter(|(_, turned)| wrapped(*turned - rotation).abs() < ALIKE);
        let mut ratios: Vec<f32> = alike.map(|(pair, _)| ratio(pair)).collect();
        if ratios.len() < ENOUGH {
            ratios = pairs.iter().map(ratio).collect();
        }
        Self { rotation, log_ratio: median(ratios).unwrap_or(0.0) }
    }
}

/// Measures where the place of each match in A lies in B, in a window of `fit_radius` σ ([`FIT_RADIUS`]); `frame`
/// brings the chips to one another. `None` where the place is not found within 3 σ, or a chip shows too little.
pub fn measure(
    pairs: &[[View<'_>; 2]],
    frame: PairFrame,
    fit_radius: f32,
    monitor: &Monitor,
) -> Result<Vec<Option<Measured>>, Cancelled> {
    let (search, window) = (Search::new(), Window::new(fit_radius));
    let (sin, cos) = frame.rotation.sin_cos();
    let turn = (frame.log_ratio, [[cos, -sin], [sin, cos]]);
    let scratch = || (SearchScratch::default(), FitScratch::default());
    let one = |(searched, fitted): &mut (SearchScratch, FitScratch), [a, b]: &[View<'_>; 2]| {
        monitor.check()?;
        let start = |a: OnLattice, b: OnLattice, _: &Affine| search.peak(a, b, searched);
        Ok(measured(&window, [a.chip, b.chip], turn, start, fitted))
    };
    pairs.par_iter().map_init(scratch, one).collect()
}

/// Map by which a place of A is expected to move with B, before it is measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Guess {
    /// Shift of B's place (u, v), pixels, as [`Measured::shift_px`].
    pub shift_px: [f64; 2],
    /// Jacobian as [`Measured::jacobian`].
    pub jacobian: [[f64; 2]; 2],
}

/// Measures as [`measure`], from a guess on and near it. `None` also where the chips are not alike there.
///
/// # Errors
/// [`Cancelled`] once `monitor` was cancelled.
pub fn measure_near(pairs: &[([View<'_>; 2], Guess)], monitor: &Monitor) -> Result<Vec<Option<Measured>>, Cancelled> {
    let window = Window::near(NEAR_RADIUS, NEAR_CORRELATION, STILL_SIGMAS);
    let one = |fitted: &mut FitScratch, ([a, b], guess): &([View<'_>; 2], Guess)| {
        monitor.check()?;
        let [[uu, uv], [vu, vv]] = guess.jacobian;
        let ratio = (uu * vv - uv * vu).abs().sqrt();
        let turn = (ratio.ln() as f32, guess.jacobian.map(|row| row.map(|x| (x / ratio) as f32)));
        let [du, dv] = guess.shift_px.map(|x| x as f32);
        let start = |_: OnLattice, _: OnLattice, turned: &Affine| Some(turned.inverse()?.apply(du, dv));
        Ok(measured(&window, [a.chip, b.chip], turn, start, fitted))
    };
    pairs.par_iter().map_init(FitScratch::default, one).collect()
}

/// Fit of two chips from `start` on, whose lattices have the logarithm of the ratio and the axes of B's in `turn`.
fn measured(
    window: &Window,
    [a, b]: [&Chip; 2],
    (log_ratio, turn): (f32, [[f32; 2]; 2]),
    start: impl FnOnce(OnLattice, OnLattice, &Affine) -> Option<[f32; 2]>,
    fitted: &mut FitScratch,
) -> Option<Measured> {
    // One step of the lattice in each image: the mean of both scales, in the ratio of the pair.
    let sigma = (a.sigma * b.sigma).sqrt();
    let units = [-0.5, 0.5].map(|half| sigma * (half * log_ratio).exp());
    let grids = [Grid::new(a)?, Grid::new(b)?];
    let places = [Grid::places(a, units[0], [[1.0, 0.0], [0.0, 1.0]]), Grid::places(b, units[1], turn)];
    let turned = Affine { matrix: turn.map(|row| row.map(|x| x * units[1])), shift: [0.0; 2] };
    let (a, b) = ((&grids[0], &places[0]), (&grids[1], &places[1]));
    let found = window.fit(a, b, start(a, b, &turned)?, fitted)?;
    let map = turned.after(&found.map);
    let jacobian = map.matrix.map(|row| row.map(|x| f64::from(x / units[0])));
    let (shift_px, correlation) = (map.shift.map(f64::from), f64::from(found.correlation));
    let finite = shift_px.iter().chain(jacobian.iter().flatten()).chain([&correlation]).all(|x| x.is_finite());
    finite.then_some(Measured { shift_px, jacobian, correlation })
}
