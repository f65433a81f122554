//! The signal-to-noise ratio of a flat spot on a flat background, measured in a picture.

use crate::plane::Plane;

/// Measurement of a spot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpotSnr {
    /// Mean of the spot minus that of its background, fraction of full scale.
    pub signal: f32,
    /// Standard deviation of one pixel, around the mean of the spot or of the background, fraction of full scale.
    pub noise: f32,
}

impl SpotSnr {
    /// |signal| over noise; infinite without noise.
    pub fn ratio(&self) -> f32 {
        self.signal.abs() / self.noise
    }
}

const MIN_PIXELS: usize = 12;

/// Measures the spot around `place` (u, v): its pixels are nearer than `inner`, those of its background between
/// `ground[0]` and `ground[1]` away, in pixels. `None` where the picture holds too few of either.
pub fn spot_snr(picture: &Plane, place: [f32; 2], inner: f32, ground: [f32; 2]) -> Option<SpotSnr> {
    let (mut spot, mut around) = (Vec::new(), Vec::new());
    let [u, v] = place;
    let span = |x: f32, n: usize| {
        let (first, end) = ((x - ground[1]).floor().max(0.0), (x + ground[1]).ceil() + 1.0);
        first as usize..(end.max(0.0) as usize).min(n)
    };
    for row in span(v, picture.height()) {
        for column in span(u, picture.width()) {
            let away = (column as f32 - u).hypot(row as f32 - v);
            let value = picture.at(column, row);
            if !value.is_finite() {
                continue;
            }
            if away < inner {
                spot.push(value);
            } else if (ground[0]..=ground[1]).contains(&away) {
                around.push(value);
            }
        }
    }
    if spot.len() < MIN_PIXELS || around.len() < MIN_PIXELS {
        return None;
    }
    let mean = |values: &[f32]| values.iter().map(|&x| f64::from(x)).sum::<f64>() / values.len() as f64;
    let means = [mean(&spot), mean(&around)];
    let squares = |values: &[f32], mean: f64| values.iter().map(|&x| (f64::from(x) - mean).powi(2)).sum::<f64>();
    // Two means were estimated from the same pixels.
    let free = (spot.len() + around.len() - 2) as f64;
    let noise = ((squares(&spot, means[0]) + squares(&around, means[1])) / free).sqrt();
    Some(SpotSnr { signal: (means[0] - means[1]) as f32, noise: noise as f32 })
}
