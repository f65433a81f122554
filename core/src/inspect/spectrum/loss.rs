//! Cost of the step of the slopes: the loss of a blob's response half a step away from its slope.

/// The part (0 … 1) of its response that the finest blob loses half a step away from its slope: `step` in px/frame,
/// `frames` frames, the blob's scale `sigma` in px.
///
/// A blob shifted by x px under a filter of its own size has (1 − x²/(2s²))·exp(−x²/(2s²)) of its response, s² = 2σ²,
/// along the direction of the shift; the mean over the frames, the outermost of which are (N − 1)/2 half-steps away, is
/// the response that remains.
pub fn step_loss(step: f32, frames: usize, sigma: f32) -> f32 {
    off_by(0.5 * step, frames, sigma)
}

/// The part (0 … 1) of its response that a blob loses at a slope that is `error` px/frame off.
pub(super) fn off_by(error: f32, frames: usize, sigma: f32) -> f32 {
    let t0 = 0.5 * (frames.max(1) - 1) as f64;
    let variance = 2.0 * f64::from(sigma).powi(2);
    let left: f64 = (0..frames)
        .map(|t| {
            let x = (t as f64 - t0) * f64::from(error);
            let q = x * x / (2.0 * variance);
            (1.0 - q) * (-q).exp()
        })
        .sum::<f64>()
        / frames.max(1) as f64;
    (1.0 - left).clamp(0.0, 1.0) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_loss_grows_with_step_and_frames_and_not_with_scale() {
        // The step that METHOD recommends, 2σ/(N − 1), loses little; twice that begins to matter.
        let recommended = 2.0 * 1.9 / 9.0;
        let loss = step_loss(recommended, 10, 1.9);
        assert!((0.02..0.08).contains(&loss), "{loss}");
        assert!(step_loss(3.0 * recommended, 10, 1.9) > 5.0 * loss);
        assert!(step_loss(recommended, 20, 1.9) > loss && step_loss(recommended, 10, 4.0) < loss);
        assert_eq!((step_loss(1.0, 1, 2.0), step_loss(0.0, 10, 2.0)), (0.0, 0.0));
        // Far beyond, no response remains.
        assert!(step_loss(60.0, 20, 1.9) > 0.9);
    }
}
