//! Features at the limit of the slopes, and the judgement of the slopes, on bursts of known motion inside, at and
//! beyond the range.

use super::slopes::{about, applied, asked, uniform};
use crate::prelude::*;
use burstscope_core::inspect::report::spectrum_text;
use burstscope_core::inspect::slopes::{AdviceSubject, SlopeJudgement, Spectrum, judgement};

const FRAMES: usize = 8;

/// Line from −1 to 1 px/frame.
fn line() -> SlopeGrid {
    SlopeGrid::line(-1.0..=1.0, 5)
}

fn plane() -> SlopeGrid {
    SlopeGrid::plane(-1.0..=1.0, 5, -1.0..=1.0, 5)
}

fn found(burst: &Burst, slopes: SlopeGrid) -> Detection {
    let params = DetectorParams { slopes, octaves: 2, ..DetectorParams::default() };
    detect(burst, &params, &quiet()).expect("valid")
}

/// The share of the stronger half of the features at the limit, and the number of those on the rim.
fn share(detection: &Detection) -> (f64, usize) {
    let strong = &detection.features[..detection.features.len().div_ceil(2)];
    let at_limit = strong.iter().filter(|f| f.at_slope_limit).count();
    let on_rim = strong.iter().filter(|f| detection.slopes.nearest_on_rim(f.slope)).count();
    (at_limit as f64 / strong.len().max(1) as f64, on_rim)
}

#[test]
fn hardly_any_feature_is_at_the_limit_inside_the_range_and_many_half_a_step_beyond_it() {
    for (grid, slopes) in [
        (line(), vec![(0.3, 0.0), (0.9, 0.0), (1.0, 0.0), (-1.0, 0.0), (1.2, 0.0)]),
        (plane(), vec![(0.3, -0.4), (1.0, 0.2), (1.0, -1.0)]),
    ] {
        for (u, v) in slopes {
            let (part, _) = share(&found(&uniform(Slope::new(u, v), FRAMES), grid));
            assert!(part < 0.05, "{u} {v}: {part}");
        }
    }
    // Most features of a motion at the end lie on the rim nevertheless.
    let detection = found(&uniform(Slope::new(1.0, 0.0), FRAMES), line());
    assert!(2 * share(&detection).1 > detection.features.len() / 2, "{}", share(&detection).1);
    for (grid, slopes) in [
        (line(), vec![(1.4, 0.0), (1.6, 0.0), (-2.4, 0.0), (3.0, 0.0)]),
        (plane(), vec![(1.7, 0.1), (0.0, -1.7), (1.6, -1.6)]),
    ] {
        for (u, v) in slopes {
            let detection = found(&uniform(Slope::new(u, v), FRAMES), grid);
            let (part, _) = share(&detection);
            assert!(part > 0.1, "{u} {v}: {part}");
            // They are those at the end towards the motion.
            let towards = |f: &&Feature| f.slope.u * u + f.slope.v * v > 0.0;
            let at_limit: Vec<_> = detection.features.iter().filter(|f| f.at_slope_limit).collect();
            let there = at_limit.iter().copied().filter(towards).count();
            assert!(10 * there >= 8 * at_limit.len(), "{u} {v}: {there} of {}", at_limit.len());
        }
    }
}

#[test]
fn noise_on_the_rim_is_not_at_the_limit_and_a_still_camera_is_told_that_one_slope_is_enough() {
    let mut noise = Stream::new(3, 7);
    let frames = (0..FRAMES).map(|_| Plane::from_fn(320, 240, |_, _| 0.5 + 0.1 * noise.normal() as f32)).collect();
    let noise = Burst::from_planes("noise", frames);
    let params = DetectorParams { slopes: plane(), noise_gate: NoiseGate::Factor(3.2), ..DetectorParams::default() };
    let detection = detect(&noise, &params, &quiet()).expect("valid");
    let on_rim = detection.features.iter().filter(|f| f.is_on_rim(&params)).count();
    let at_limit = detection.features.iter().filter(|f| f.at_slope_limit).count();
    assert!(on_rim >= 20 && 20 * at_limit <= on_rim, "{at_limit} of {on_rim} on the rim");
    let told = judgement(&detection, &params, None, &noise, &quiet()).expect("not cancelled").expect("slopes");
    assert_eq!(told.advice, None, "{}", told.sentence);
    let burst = uniform(Slope::default(), FRAMES);
    for grid in [SlopeGrid::line(-2.0..=2.0, 9), SlopeGrid::line(-0.5..=0.5, 2), plane()] {
        let spectrum = asked(&burst, grid);
        let (judgement, mended) = judged(&spectrum);
        assert!(judgement.sentence.contains("one slope, 0, is enough"), "{}", judgement.sentence);
        assert_eq!((mended.len(), mended.slope(0)), (1, Slope::default()));
    }
    assert_eq!(judged(&asked(&burst, SlopeGrid::single(Slope::default()))).0.advice, None);
}

/// The judgement of a spectrum, and the slopes after its advice was applied.
fn judged(spectrum: &Spectrum) -> (&SlopeJudgement, SlopeGrid) {
    let judged = spectrum.judgement.as_ref().expect("slopes were searched");
    let changes = judged.advice.as_ref().map_or(&[][..], |advice| &advice.changes);
    (judged, applied(spectrum.grid, changes).slopes)
}

#[test]
fn one_set_of_changes_mends_both_axes_direction_range_and_step() {
    for (slope, grid, says, subject) in [
        (Slope::new(1.9, -2.0), plane(), "beyond the range u −1 to 1", AdviceSubject::Range),
        (Slope::new(2.6, 0.0), line(), "beyond the range u −1 to 1", AdviceSubject::Range),
        (Slope::new(0.0, 2.2), SlopeGrid::line(-3.0..=3.0, 3), "a line at 90°", AdviceSubject::Direction),
        (Slope::new(-1.6, 0.0), SlopeGrid::line(0.3..=2.7, 7), "moves the other way than", AdviceSubject::Range),
        (Slope::new(1.6, 0.0), SlopeGrid::line(-2.7..=-0.3, 7), "moves the other way than", AdviceSubject::Range),
        (Slope::new(1.5, 0.0), SlopeGrid::single(Slope::new(-1.0, 0.0)), "at the one slope", AdviceSubject::Direction),
    ] {
        let spectrum = asked(&uniform(slope, FRAMES), grid);
        let (judgement, mended) = judged(&spectrum);
        assert!(judgement.sentence.contains(says), "{slope:?}: {}", judgement.sentence);
        assert!(!judgement.sentence.contains("faster"), "{}", judgement.sentence);
        assert_eq!(judgement.advice.as_ref().map(|advice| advice.subject), Some(subject), "{slope:?}");
        assert_eq!(about(&spectrum, subject), judgement.advice.as_ref(), "it is the advice");
        let again = asked(&uniform(slope, FRAMES), mended);
        let (after, _) = judged(&again);
        assert!(after.advice.is_none(), "{slope:?}, {mended:?}: {}", after.sentence);
        assert!(after.sentence.starts_with("the slopes fit the burst; "), "{}", after.sentence);
    }
}

#[test]
fn slopes_that_were_found_fit_and_features_decide_where_frames_were_not_examined() {
    let demo = demo_burst();
    let grid = find_slopes(&demo, &DetectorParams::default(), None, &quiet()).expect("not cancelled").grid;
    let spectrum = asked(&demo, grid);
    let (told, same) = judged(&spectrum);
    assert_eq!((&told.advice, same), (&None, grid));
    assert!(told.sentence.starts_with("the slopes fit the burst; "), "{}", told.sentence);
    assert!(50 * spectrum.at_limit < spectrum.features, "{} of {}", spectrum.at_limit, spectrum.features);
    assert_eq!(spectrum.bars.iter().map(|bar| bar.at_limit).sum::<usize>(), spectrum.at_limit);
    assert!(spectrum_text(&spectrum, "demo").contains(&told.sentence));
    let burst = uniform(Slope::new(1.8, 0.0), FRAMES);
    let params = DetectorParams { slopes: line(), octaves: 2, ..DetectorParams::default() };
    let detection = found(&burst, line());
    let judged = judgement(&detection, &params, None, &burst, &quiet()).expect("not cancelled").expect("slopes");
    assert!(judged.sentence.contains("still rises beyond u 1 px/frame"), "{}", judged.sentence);
    let wider = applied(line(), &judged.advice.expect("advice").changes).slopes;
    assert!(wider.u.max >= 1.8 && wider.u.min == -1.0, "{wider:?}");
    // A method that merges the frames has no slopes.
    let merge = DetectorParams { method: Method::Merge, ..params };
    assert_eq!(judgement(&detection, &merge, None, &burst, &quiet()), Ok(None));
}
