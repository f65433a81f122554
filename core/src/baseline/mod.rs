//! Baselines for comparison with burst features: a burst made into one image, on which an ordinary detector runs.
//!
//! [`merge_burst`], the robust merge of aligned frames, and [`plain_mean`]. The same detector then runs on the one
//! frame, so that a comparison shows the effect of the burst search alone.

mod merge;

pub use merge::merge_burst;

use crate::burst::Burst;
use crate::monitor::{Cancelled, Monitor};
use crate::plane::{Plane, memory};

/// Mean of all frames of `burst`, as a burst of one frame with the middle frame's mask: moving structure is smeared.
pub fn plain_mean(burst: &Burst, monitor: &Monitor) -> Result<Burst, Cancelled> {
    let (width, height) = burst.size();
    // Sums of many 16-bit values need more than the 24 bits of f32.
    let mut sums: Vec<f64> = memory::zeroed(width * height);
    for frame in &burst.frames {
        monitor.check()?;
        sums.iter_mut().zip(frame.data()).for_each(|(sum, &value)| *sum += f64::from(value));
    }
    let count = burst.len() as f64;
    let mean = Plane::from_vec(width, height, sums.into_iter().map(|sum| (sum / count) as f32).collect());
    let mask = burst.frames[burst.len() / 2].mask().cloned();
    Ok(of_one_image(burst, "mean", mean.with_mask(mask), burst.len()))
}

/// The burst of one image that some way of averaging, its name, made of `count` frames of `burst`.
fn of_one_image(burst: &Burst, way: &str, image: Plane, count: usize) -> Burst {
    let mut merged = Burst::from_planes(format!("{way} of {}", burst.name), vec![image]);
    merged.full_scale = burst.full_scale;
    // The mean of N numbers on a lattice lies on a lattice N times as fine.
    merged.quantisation_step = burst.quantisation_step / count as f32;
    merged.sources.clone_from(&burst.sources);
    merged
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_is_exact_and_keeps_what_is_known_of_the_files() {
        let frames = (0..4).map(|t| Plane::from_fn(3, 2, |u, v| (t * 10 + u + v) as f32)).collect();
        let mut burst = Burst::from_planes("steps", frames);
        burst.quantisation_step = 0.5;
        burst.full_scale = 255.0;
        let merged = plain_mean(&burst, &Monitor::default()).expect("not cancelled");
        assert_eq!((merged.len(), merged.size()), (1, (3, 2)));
        assert_eq!(merged.frames[0].data(), [15.0, 16.0, 17.0, 16.0, 17.0, 18.0]);
        assert_eq!((merged.quantisation_step, merged.full_scale), (0.125, 255.0));
    }
}
