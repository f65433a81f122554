//! Revision of the detector: a number that changes whenever the bits of features do.
//!
//! Features are stored in files beside a dataset and reused. Those of an older detector are a little displaced, or have
//! other descriptors, and match new ones less well; mixed, they would degrade a reconstruction without a message. So
//! code that stores features writes this number beside them, and reuses only those with an equal number.

/// Revision of the detector. It goes up by one with every change after which an unchanged burst and unchanged
/// parameters give other bits of any feature or descriptor; not with new parameters whose defaults change nothing
/// (parameters are compared separately).
pub const REVISION: u32 = 4;

#[cfg(test)]
mod tests {
    use super::super::pipeline::search;
    use super::super::{DetectorParams, SlopeGrid};
    use super::*;
    use crate::monitor::Monitor;
    use crate::synth::{ChartParams, Motion, synth_chart};

    /// Results of this revision on a small chart: features; sums over all of |u|, |v|, σ, |slope u|, |response|·10³;
    /// mean of the descriptors' values. Sums, with a tolerance, because processors round the last bit differently.
    const FOUND: (u32, usize, [f64; 6]) =
        (4, 144, [12458.099422, 13128.652863, 529.047963, 116.715769, 90.589541, 33.617405]);

    #[test]
    fn other_features_come_with_another_revision() {
        let chart =
            ChartParams { width: 200, height: 150, discs: 10, radius: 3.6..=9.0, snr: 2.0, ..ChartParams::default() };
        let (burst, _) =
            synth_chart(&ChartParams { motion: Motion::TwoD, max_slope: 1.0, ..chart }, &Monitor::default())
                .expect("a chart");
        let slopes = SlopeGrid::plane(-1.0..=1.0, 3, -1.0..=1.0, 3);
        let detection = search(&burst, &DetectorParams { slopes, ..DetectorParams::default() }, &Monitor::default())
            .expect("a detection");
        let sum = |value: fn(&super::super::Feature) -> f32| {
            detection.features.iter().map(|f| f64::from(value(f).abs())).sum::<f64>()
        };
        let elements = detection.descriptors.iter().flatten();
        let mean = elements.map(|&x| f64::from(x)).sum::<f64>() / (128.0 * detection.descriptors.len().max(1) as f64);
        let sums = [sum(|f| f.u), sum(|f| f.v), sum(|f| f.sigma), sum(|f| f.slope.u), 1e3 * sum(|f| f.response), mean];
        let (revision, features, expected) = FOUND;
        let same = features == detection.features.len()
            && expected.iter().zip(&sums).all(|(a, b)| (a - b).abs() <= 1e-4 * b.abs());
        assert!(
            same && revision == REVISION,
            "features have changed: raise REVISION, and let FOUND be (revision, {}, {sums:.6?})",
            detection.features.len()
        );
    }
}
