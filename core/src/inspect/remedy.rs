//! The verdict about a candidate as a sentence, and the one setting that would keep it.
//!
//! A remedy changes the limit of the first failed test just so far that the candidate passes it. If it would then fail
//! a later test, that is stated. Some verdicts have no remedy: a sample that a neighbour beats is no extremum with any
//! setting.

use super::fate::{Fate, Remedy, apart_sigmas};
use super::words::{number, rounded_down, rounded_up, slope_text};
use crate::detector::params::doc;
use crate::detector::{Distinct, Judgement, NoiseGate, ParamChange, Slope, SlopeAxis, SlopeGrid, Test, Trail};

/// Margin by which a limit is changed further, so that the value passes although the search computes in single
/// precision.
const EASE: f64 = 1e-4;
/// Smallest radius of distinct keypoints that is proposed, and smallest ratio of scales.
const MIN_RADIUS: f64 = 0.05;
const MIN_RATIO: f64 = 1.02;

/// Adds the verdict and the remedy to the fate.
pub(super) fn explained(trail: &Trail, judgement: &Judgement, fate: Fate) -> Fate {
    let verdict = verdict(trail, &fate);
    let remedy = change(trail, judgement, &fate).map(|(sentence, change)| Remedy {
        sentence,
        change,
        then_fails: fate.fails_later().next().or_else(|| fails_uncut(trail, &fate)),
    });
    Fate { verdict, remedy, ..fate }
}

/// The test that a keypoint that is cut would fail otherwise.
fn fails_uncut(trail: &Trail, fate: &Fate) -> Option<Test> {
    let cut = fate.keypoint.filter(|_| fate.first_failed == Some(Test::MaxFeatures))?;
    trail.fails_uncut(cut)
}

/// The verdict as one sentence.
fn verdict(trail: &Trail, fate: &Fate) -> String {
    let Some(test) = fate.first_failed else {
        let limit = if fate.at_slope_limit { ", at the limit of the slopes" } else { "" };
        return match fate.features[..] {
            [] => format!("kept as a keypoint{limit}"),
            [one] => format!("kept as feature {one}{limit}"),
            [first, ..] => {
                format!("kept as {} features, the first of them feature {first}{limit}", fate.features.len())
            }
        };
    };
    let report = fate.report(test);
    let (value, limit) = (report.value.unwrap_or(f64::NAN), report.limit.unwrap_or(f64::NAN));
    let rival = report.rival;
    match test {
        Test::PeakThreshold => format!(
            "below the peak threshold: |D| is {}, at least 0.8 of {} is required",
            scientific(value),
            trail.params().peak_threshold
        ),
        Test::NoiseGate => {
            format!("below the noise gate: {} σ of {} σ", number(value as f32, 2), number(limit as f32, 2))
        }
        Test::SpaceExtremum => "a neighbour in the image is as strong".to_owned(),
        Test::ScaleExtremum => "a neighbour at an adjacent level is as strong".to_owned(),
        Test::SlopeExtremum => rival.map_or_else(
            || test.reason().to_owned(),
            |rival| {
                format!(
                    "beaten by slope {} {}, {} times as strong: {}",
                    slope_text(rival.slope),
                    if away(fate, rival.pos_image) < 1.0 {
                        "at the same place".to_owned()
                    } else {
                        format!("{} px away", number(away(fate, rival.pos_image), 1))
                    },
                    number((limit / value) as f32, 2),
                    if rises_past_the_rim(trail, fate, rival.slope) {
                        "the motion lies beyond"
                    } else {
                        "the same blob"
                    },
                )
            },
        ),
        Test::Refinement => match report.value {
            Some(_) => format!("the fit did not settle: its peak is {} samples away", number(value as f32, 1)),
            None => "the fit has no peak".to_owned(),
        },
        Test::InterpolatedContrast => format!(
            "below the peak threshold after interpolation: |D| is {} of {}",
            scientific(value),
            trail.params().peak_threshold
        ),
        Test::Edge if value.is_finite() => format!(
            "on an edge: one curvature is {} times the other, at most {} is allowed",
            number(value as f32, 1),
            number(limit as f32, 1)
        ),
        Test::Edge => "on a saddle: bright along one direction and dark along the other".to_owned(),
        Test::Outside => "the fit lies outside the image or the scales of its octave".to_owned(),
        Test::Duplicate => rival.map_or_else(
            || test.reason().to_owned(),
            |rival| {
                let who = rival.feature.map_or_else(|| "another keypoint".to_owned(), |f| format!("feature {f}"));
                format!(
                    "the same blob as {who} at ({}, {}) with σ {} and slope {}, {} σ away",
                    number(rival.pos_image[0], 1),
                    number(rival.pos_image[1], 1),
                    number(rival.sigma, 1),
                    slope_text(rival.slope),
                    number(value as f32, 2)
                )
            },
        ),
        Test::MaxFeatures => format!("weaker than the strongest {limit} that are kept: it is number {value}"),
    }
}

/// The distance of a place from the candidate, input pixels.
fn away(fate: &Fate, [u, v]: [f32; 2]) -> f32 {
    (u - fate.pos_image[0]).hypot(v - fate.pos_image[1])
}

/// Whether the rival that beats the candidate lies on the rim of the slopes.
fn rises_past_the_rim(trail: &Trail, fate: &Fate, slope: Slope) -> bool {
    let grid = trail.params().used_slopes();
    let nearest = grid.slopes().position(|s| s == slope);
    nearest.is_some_and(|index| {
        let (i, j) = grid.coordinates(index);
        grid.on_rim(i, j) && index != fate.slope_index
    })
}

/// The sentence and the change that make the candidate pass its first failed test.
fn change(trail: &Trail, judgement: &Judgement, fate: &Fate) -> Option<(String, ParamChange)> {
    let test = fate.first_failed?;
    let params = trail.params();
    let report = fate.report(test);
    let instead = |what: &str, change: &ParamChange, of: String| format!("{what} {} instead of {of}", change.value);
    match test {
        Test::PeakThreshold | Test::InterpolatedContrast => {
            // Both tests use the threshold: for the sample's own value, and for the fit's.
            let first = f64::from(judgement.value.abs()) / f64::from(crate::detector::pipeline::FIRST_PEAK_PART);
            let fit = judgement.fit.map_or(f64::INFINITY, |fit| fit.value.abs());
            let value = rounded_down((1.0 - EASE) * first.min(fit), 2);
            let change = ParamChange::new(doc::PEAK_THRESHOLD, value);
            Some((instead("a peak threshold of", &change, params.peak_threshold.to_string()), change))
        }
        Test::NoiseGate => {
            let value = rounded_down((1.0 - EASE) * report.value?, 2);
            let change = ParamChange::new(doc::NOISE_GATE, value);
            let was = match params.noise_gate {
                NoiseGate::Factor(k) => k.to_string(),
                word => format!("{} ({word})", number(trail.detection().noise_gate_factor, 2)),
            };
            Some((instead("a noise gate of", &change, was), change))
        }
        Test::SlopeExtremum => {
            let rival = report.rival?;
            if rises_past_the_rim(trail, fate, rival.slope) {
                let change = widened_towards(&params.used_slopes(), fate)?;
                return Some((
                    format!("it rises towards the limit of the slopes: widen them to {}", change.value),
                    change,
                ));
            }
            let change = ParamChange::new(doc::SLOPE_EXTREMA, "each");
            Some(("each slope for itself instead of joint extrema".to_owned(), change))
        }
        Test::Edge => {
            let value = rounded_up((1.0 + EASE) * report.value.filter(|ratio| ratio.is_finite())?, 2);
            let change = ParamChange::new(doc::EDGE_THRESHOLD, value);
            Some((instead("an edge threshold of", &change, params.edge_threshold.to_string()), change))
        }
        Test::Outside => {
            let below = judgement.fit.is_some_and(|fit| fit.level_refined < 0.0);
            let finer = params.first_octave - 1;
            (below && finer >= -1).then(|| {
                let change = ParamChange::new(doc::FIRST_OCTAVE, finer);
                (
                    instead(
                        "it is finer than the first octave: a first octave of",
                        &change,
                        params.first_octave.to_string(),
                    ),
                    change,
                )
            })
        }
        // See `duplicate_remedy`.
        Test::Duplicate => None,
        Test::MaxFeatures => {
            let change = ParamChange::new(doc::MAX_FEATURES, report.value? as u64);
            Some((instead("max features", &change, params.max_features.to_string()), change))
        }
        Test::SpaceExtremum | Test::ScaleExtremum | Test::Refinement => None,
    }
}

/// The smallest change that keeps a keypoint beside the stronger one on its blob; `None` for a candidate that is no
/// duplicate. It takes a while, because the nearby keypoints are compared again, so [`Fate::remedy`] of a duplicate is
/// left out where many candidates are listed.
pub fn duplicate_remedy(trail: &Trail, fate: &Fate) -> Option<Remedy> {
    let index = fate.keypoint.filter(|_| fate.first_failed == Some(Test::Duplicate))?;
    let (sentence, change) = distinct_change(trail, index)?;
    Some(Remedy { sentence, change, then_fails: fate.fails_later().next() })
}

fn distinct_change(trail: &Trail, index: usize) -> Option<(String, ParamChange)> {
    let params = trail.params();
    let Distinct::Radius(radius) = params.distinct else {
        return None;
    };
    let (own, stronger) = (trail.keypoints()[index], trail.keypoints()[trail.covered_by(index)?]);
    let distance = f64::from(apart_sigmas(&stronger, &own));
    let (a, b) = (stronger.in_image().2, own.in_image().2);
    let ratio = f64::from(a.max(b) / a.min(b));
    let (closer, less) = (rounded_down((1.0 - EASE) * distance, 2), rounded_down((1.0 - EASE) * ratio, 3));
    // The smaller change first; whether it has the effect depends on the nearby keypoints.
    let by_radius = (closer >= MIN_RADIUS && trail.would_stay(index, closer as f32, params.distinct_scale))
        .then(|| (closer / f64::from(radius), ParamChange::new(doc::DISTINCT, closer), radius.to_string()));
    let by_ratio = (less > MIN_RATIO && trail.would_stay(index, radius, less as f32)).then(|| {
        let part = (less - 1.0) / f64::from(params.distinct_scale - 1.0);
        (part, ParamChange::new(doc::DISTINCT_SCALE, less), params.distinct_scale.to_string())
    });
    let smaller = by_radius.into_iter().chain(by_ratio).max_by(|a, b| a.0.total_cmp(&b.0));
    let (_, change, was) =
        smaller.unwrap_or_else(|| (0.0, ParamChange::new(doc::DISTINCT, Distinct::Off), radius.to_string()));
    let name = change.parameter.label.to_lowercase();
    Some((format!("{name} {} instead of {was} would keep both", change.value), change))
}

/// The index of the grid's slope nearest to a slope.
pub fn nearest_slope(grid: &SlopeGrid, slope: Slope) -> usize {
    let (i, j) = grid.position(slope);
    let nearest = |at: f32, axis: &SlopeAxis| at.round().clamp(0.0, (axis.count.max(1) - 1) as f32) as usize;
    nearest(j, &grid.v) * grid.u.count + nearest(i, &grid.u)
}

/// The change that extends the axis on whose rim a candidate lies by one step; `None` for a candidate that is not on a
/// rim.
pub(super) fn widened_towards(grid: &SlopeGrid, fate: &Fate) -> Option<ParamChange> {
    let rival = fate.report(Test::SlopeExtremum).rival;
    let index = match fate.first_failed {
        Some(Test::SlopeExtremum) => grid.slopes().position(|s| Some(s) == rival.map(|r| r.slope))?,
        _ => nearest_slope(grid, fate.slope),
    };
    let (i, j) = grid.coordinates(index);
    let ends = |at: usize, count: usize| (count > 1 && at == 0, count > 1 && at + 1 == count);
    let (u, v) = (ends(i, grid.u.count), ends(j, grid.v.count));
    if u.0 || u.1 {
        return Some(ParamChange::new(doc::SLOPES_U, grid.u.with_more(usize::from(u.0), usize::from(u.1))));
    }
    (v.0 || v.1).then(|| ParamChange::new(doc::SLOPES_V, grid.v.with_more(usize::from(v.0), usize::from(v.1))))
}

/// |D| with three digits, as text.
fn scientific(x: f64) -> String {
    if x >= 0.01 { number(x as f32, 4) } else { format!("{x:.2e}") }
}
