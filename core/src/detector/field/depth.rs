//! Relative inverse depths of places of a burst, from their motions.
//!
//! While a camera moves without turning, a point x at inverse depth ρ moves in the picture by ρ·(e − e_z·x), where (e,
//! e_z) is the camera's velocity: towards or away from the focus of expansion e/e_z, which lies at infinity where the
//! camera moves sideways (Longuet-Higgins and Prazdny, "The interpretation of a moving retinal image", 1980). All
//! places together give the focus; each motion then gives an inverse depth, up to one factor for the burst.

use crate::detector::params::Slope;
use nalgebra::{Matrix3, SymmetricEigen, Vector3};

/// Inverse depth of a place, in a unit of its burst, with its standard deviation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct InverseDepth {
    pub value: f64,
    pub sigma: f64,
}

/// Standard deviations from which a motion counts as that of a thing that moves by itself.
const OTHER_SIGMAS: f64 = 3.0;
/// Number of rounds in which the weights of the motions follow the focus.
const ROUNDS: usize = 10;
/// Fewest known motions that determine the focus.
const FEWEST: usize = 8;

/// Inverse depths of `places` (u, v), pixels, from their `motions` and standard deviations, pixels per frame, infinite
/// where unknown; `None` where the motion is unknown, does not point along the focus, or lies too close to it.
pub(crate) fn inverse_depths(places: &[[f64; 2]], motions: &[(Slope, f32)]) -> Vec<Option<InverseDepth>> {
    let none = || vec![None; places.len()];
    let known: Vec<(usize, &(Slope, f32))> = motions.iter().enumerate().filter(|(_, m)| m.1.is_finite()).collect();
    if known.len() < FEWEST {
        return none();
    }
    // Coordinates of about unit size, so that the three numbers of the focus compare.
    let count = known.len() as f64;
    let centre = [0, 1].map(|axis| known.iter().map(|(i, _)| places[*i][axis]).sum::<f64>() / count);
    let off = |i: usize| [0, 1].map(|axis| places[i][axis] - centre[axis]);
    let size = (known.iter().map(|(i, _)| off(*i).map(|x| x * x).iter().sum::<f64>()).sum::<f64>() / count).sqrt();
    if size <= 0.0 || !size.is_finite() {
        return none();
    }
    let at = |i: usize| off(i).map(|x| x / size);
    let motion = |moving: &(Slope, f32)| [f64::from(moving.0.u), f64::from(moving.0.v)];
    // m × (e − e_z·x) = 0 is linear in (e, e_z).
    let row = |i: usize, moving: &(Slope, f32)| {
        let ([x, y], [u, v]) = (at(i), motion(moving));
        Vector3::new(-v, u, v * x - u * y)
    };
    let away = |focus: &Vector3<f64>, [x, y]: [f64; 2]| [focus.x - focus.z * x, focus.y - focus.z * y];
    let mut focus: Option<Vector3<f64>> = None;
    for _ in 0..ROUNDS {
        let mut normal = Matrix3::zeros();
        for &(i, moving) in &known {
            let row = row(i, moving);
            let sigma = f64::from(moving.1);
            let weight = focus.map_or(1.0, |focus| {
                let [x, y] = away(&focus, at(i));
                let variance = sigma * sigma * (x * x + y * y).max(1e-6);
                // A Cauchy weight: a thing that moves by itself pulls less and less at the focus.
                let off = row.dot(&focus).powi(2) / (OTHER_SIGMAS * OTHER_SIGMAS * variance);
                1.0 / (variance * (1.0 + off))
            });
            normal += row * row.transpose() * weight;
        }
        let is_finite = normal.iter().all(|x| x.is_finite());
        let eigen = is_finite.then(|| SymmetricEigen::try_new(normal, f64::EPSILON, 500)).flatten();
        let Some(eigen) = eigen else { return none() };
        // The direction that all rows are most nearly perpendicular to.
        focus = Some(eigen.eigenvectors.column(eigen.eigenvalues.imin()).into_owned());
    }
    let Some(focus) = focus else { return none() };
    let depth = |i: usize, moving: &(Slope, f32)| {
        let ([x, y], [u, v]) = (away(&focus, at(i)), motion(moving));
        let squared = x * x + y * y;
        let sigma = f64::from(moving.1) / squared.sqrt();
        let across = (u * y - v * x).abs() / squared.sqrt();
        let is_of_scene = across <= OTHER_SIGMAS * f64::from(moving.1);
        (squared > 0.0 && is_of_scene).then(|| InverseDepth { value: (u * x + v * y) / squared, sigma })
    };
    let mut depths = none();
    known.iter().for_each(|&(i, moving)| depths[i] = depth(i, moving));
    // The sign of the focus is free: things lie before the camera, not behind.
    if depths.iter().flatten().map(|depth| depth.value.signum()).sum::<f64>() < 0.0 {
        depths.iter_mut().flatten().for_each(|depth| depth.value = -depth.value);
    }
    depths
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synth::random::Stream;

    type Scene = (Vec<[f64; 2]>, Vec<f64>, Vec<(Slope, f32)>);

    /// View of a camera with the velocity (`e`, `e_z`), with `sigma` px/frame of noise.
    fn scene(velocity: [f64; 3], sigma: f64, on_a_line: bool) -> Scene {
        let mut random = Stream::new(3, 1);
        let (mut places, mut depths, mut motions) = (Vec::new(), Vec::new(), Vec::new());
        for i in 0..400 {
            let place = [random.within(0.0, 640.0), random.within(0.0, 480.0)];
            let depth = random.within(0.2, 1.0);
            let [x, y] = [(place[0] - 320.0) / 500.0, (place[1] - 240.0) / 500.0];
            let mut motion = [velocity[0] - velocity[2] * x, velocity[1] - velocity[2] * y]
                .map(|m| 4.0 * depth * m + sigma * random.normal());
            if on_a_line {
                motion[1] = 0.0;
            }
            let slope = Slope::new(motion[0] as f32, motion[1] as f32);
            let is_known = i % 10 != 0;
            let motion_sigma = if is_known { sigma.max(0.01) as f32 } else { f32::INFINITY };
            places.push(place);
            depths.push(depth);
            motions.push((slope, motion_sigma));
        }
        (places, depths, motions)
    }

    fn median_error(found: &[Option<InverseDepth>], truth: &[f64]) -> f64 {
        let ratio = |(found, truth): (&Option<InverseDepth>, &f64)| found.map(|depth| depth.value / truth);
        let mut ratios: Vec<f64> = found.iter().zip(truth).filter_map(ratio).collect();
        ratios.sort_by(f64::total_cmp);
        let middle = ratios[ratios.len() / 2];
        let mut errors: Vec<f64> = ratios.iter().map(|ratio| (ratio / middle - 1.0).abs()).collect();
        errors.sort_by(f64::total_cmp);
        errors[errors.len() / 2]
    }

    #[test]
    fn inverse_depths_are_proportional_to_the_true_ones_however_the_camera_moves() {
        for (velocity, on_a_line) in
            [([1.0, 0.0, 0.0], true), ([-0.6, 0.8, 0.0], false), ([0.0, 0.0, 1.0], false), ([0.5, -0.2, -0.8], false)]
        {
            let (places, depths, motions) = scene(velocity, 0.03, on_a_line);
            let found = inverse_depths(&places, &motions);
            let known = found.iter().flatten().count();
            assert!(known > 320 && found[0].is_none(), "{velocity:?}: {known}");
            let error = median_error(&found, &depths);
            assert!(error < 0.03, "{velocity:?}: {error}");
        }
    }

    #[test]
    fn what_moves_otherwise_has_none_and_does_not_move_the_focus() {
        let (places, depths, mut motions) = scene([0.3, 0.1, 1.0], 0.03, false);
        motions.iter_mut().take(60).for_each(|moving| moving.0 = Slope::new(3.0, -3.0));
        let found = inverse_depths(&places, &motions);
        let left = found[..60].iter().flatten().count();
        assert!(left < 6, "{left} movers have a depth");
        let error = median_error(&found[60..], &depths[60..]);
        assert!(error < 0.03, "{error}");
    }

    #[test]
    fn too_little_tells_nothing() {
        let (places, _, mut motions) = scene([1.0, 0.0, 0.0], 0.03, false);
        assert!(inverse_depths(&[], &[]).is_empty());
        assert!(inverse_depths(&[[3.0, 4.0]; 20], &motions[..20]).iter().all(Option::is_none));
        motions.iter_mut().for_each(|moving| moving.1 = f32::INFINITY);
        assert!(inverse_depths(&places, &motions).iter().all(Option::is_none));
        motions.fill((Slope::new(0.0, 0.0), 0.05));
        assert!(inverse_depths(&places, &motions).iter().flatten().all(|depth| depth.value.is_finite()));
    }
}
