//! The detector at the ends of its parameters: one level an octave and ten, and blobs that lie on the picture's border.

use burstscope_core::detector::{Localisation, Method};
use burstscope_core::synth::{ChartParams, synth_chart};
use burstscope_core::{Burst, DetectorParams, Feature, Monitor, Plane, SlopeGrid, detect};

fn found(burst: &Burst, params: &DetectorParams) -> Vec<Feature> {
    let detection = detect(burst, params, &Monitor::default()).expect("valid parameters");
    assert_eq!(detection.features.len(), detection.descriptors.len());
    let finite = |f: &Feature| {
        [f.u, f.v, f.sigma, f.orientation, f.slope.u, f.slope.v, f.response].iter().all(|x| x.is_finite())
            && f.sigma > 0.0
    };
    assert!(detection.features.iter().all(finite));
    detection.features
}

#[test]
fn one_level_and_ten_levels_find_the_discs() {
    let params = ChartParams { width: 320, height: 240, discs: 12, snr: 12.0, seed: 5, ..ChartParams::default() };
    let params = ChartParams { radius: 4.0..=10.0, max_slope: 1.0, ..params };
    let (burst, truth) = synth_chart(&params, &Monitor::default()).expect("a chart");
    for levels in [1, 10] {
        let search = DetectorParams { levels, slopes: SlopeGrid::line(-1.0..=1.0, 5), ..DetectorParams::default() };
        let features = found(&burst, &search);
        let near = |u: f64, v: f64| features.iter().any(|f| (f64::from(f.u) - u).hypot(f64::from(f.v) - v) < 1.5);
        let hit = truth.features.iter().filter(|disc| near(disc.u, disc.v)).count();
        println!("{levels} levels: {} features, {hit} of {} discs", features.len(), truth.features.len());
        assert!(hit * 3 >= truth.features.len() * 2, "{levels} levels find {hit} of {} discs", truth.features.len());
        assert!(features.iter().all(|f| (0..levels as i32).contains(&f.level)), "{levels} levels");
    }
}

#[test]
fn blobs_on_the_border_are_described_wherever_they_are_placed() {
    // Discs whose middle lies on the border, a little inside and a little outside.
    let places =
        [(0.0, 40.0), (-1.5, 90.0), (159.0, 60.0), (161.0, 100.0), (80.0, -1.0), (120.0, 119.5), (40.0, 121.0)];
    let disc = |u: f64, v: f64| {
        places.iter().map(|(cu, cv)| (-((u - cu).powi(2) + (v - cv).powi(2)) / 40.0).exp()).sum::<f64>()
    };
    let frame = Plane::from_fn(160, 120, |u, v| (0.2 + 0.5 * disc(u as f64, v as f64)) as f32);
    let burst = Burst::from_planes("border", vec![frame]);
    for localisation in [Localisation::Continuous, Localisation::Quadratic] {
        let params = DetectorParams { method: Method::Sift, localisation, ..DetectorParams::default() };
        let features = found(&burst, &params);
        // Beyond the border the filter sees the border's own value; a position may be slightly outside.
        let outside = |f: &&Feature| !(-0.5..=159.5).contains(&f.u) || !(-0.5..=119.5).contains(&f.v);
        println!("{localisation:?}: {} features, {} outside", features.len(), features.iter().filter(outside).count());
        assert!(!features.is_empty());
        let far = |f: &Feature| f.u < -f.sigma || f.v < -f.sigma || f.u > 159.0 + f.sigma || f.v > 119.0 + f.sigma;
        assert!(!features.iter().any(far), "a feature lies far outside the picture");
    }
}
