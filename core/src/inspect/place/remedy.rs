//! The verdict about a candidate as a sentence, and the one setting that would keep it.
//!
//! A remedy changes the limit of the first failed test just so far that the candidate passes it. Some verdicts have
//! none: a sample that a neighbour beats is no extremum with any setting.

use super::fate::{Fate, OnEdge, Remedy, Rival, apart_sigmas};
use crate::detector::params::{Word, doc};
use crate::detector::pipeline::FIRST_PEAK_PART;
use crate::detector::scale_space::{octave_size, searched_octaves};
use crate::detector::test::Side;
use crate::detector::{
    DetectorParams, Distinct, Judgement, NoiseGate, ParamChange, Slope, SlopeExtrema, SlopeGrid, Test, Trail,
};
use crate::inspect::words::{filled, number, rounded_down, rounded_up};

/// Margin by which a limit is changed further: the search computes in single precision.
const EASE: f64 = 1e-4;
/// Lowest gate that is proposed: at it white noise gives 2400 features a megapixel and 7 slopes. Nothing is promised to
/// what is weaker, since noise is as strong at many places.
pub(super) const LEAST_GATE: f64 = 2.5;
/// Smallest part of the radius of distinct keypoints, and of its ratio of scales beyond 1, that is proposed: nearer
/// ones are the same thing, and would be kept many times.
const LEAST_PART: f64 = 0.5;

pub(super) fn explained(trail: &Trail, judgement: &Judgement, fate: Fate) -> Fate {
    let verdict = verdict(trail, &fate);
    let remedy = change(trail, judgement, &fate).map(|(sentence, change)| Remedy {
        sentence,
        change,
        // A keypoint that is cut may fail another test without the cut.
        then_fails: fate.fails_later().next().or_else(|| {
            let cut = fate.keypoint.filter(|_| fate.first_failed == Some(Test::MaxFeatures));
            cut.and_then(|cut| trail.fails_uncut(cut))
        }),
    });
    Fate { verdict, remedy, ..fate }
}

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
    let (report, record) = (fate.report(test), test.record());
    let edge = match fate.edge {
        Some(OnEdge { along_motion: true, .. }) => ": an edge along its motion, which looks alike at every slope",
        Some(_) if test == Test::Refinement => ": it lies on an edge",
        _ => "",
    };
    let verdict = filled(report.unless_boundless(record.verdict), |word| match (word, report.rival) {
        ("threshold", _) => {
            record.parameter.map_or_else(String::new, |parameter| parameter.text(&trail.params().clone().into()))
        }
        ("where", Some(Rival { pos_image: [u, v], .. })) => {
            match (u - fate.pos_image[0]).hypot(v - fate.pos_image[1]) {
                px if px < 1.0 => "at the same place".to_owned(),
                px => format!("{} px away", number(px, 1)),
            }
        }
        ("cause", Some(rival)) if rises_past_the_rim(trail, fate, rival.slope) => "the motion lies beyond".to_owned(),
        ("cause", _) => "the same blob".to_owned(),
        _ => report.word(word),
    });
    verdict + edge
}

fn rises_past_the_rim(trail: &Trail, fate: &Fate, slope: Slope) -> bool {
    let grid = trail.params().used_slopes();
    grid.slopes().position(|s| s == slope).is_some_and(|index| {
        let (i, j) = grid.coordinates(index);
        grid.on_rim(i, j) && index != fate.slope_index
    })
}

fn change(trail: &Trail, judgement: &Judgement, fate: &Fate) -> Option<(String, ParamChange)> {
    let test = fate.first_failed?;
    let (params, report, record) = (trail.params(), fate.report(test), test.record());
    let parameter = record.parameter?;
    let eased = |value: f64| match record.side {
        Side::AtLeast => rounded_down((1.0 - EASE) * value, 2).to_string(),
        Side::AtMost => rounded_up((1.0 + EASE) * value, 2).to_string(),
    };
    let value = match test {
        Test::PeakThreshold | Test::InterpolatedContrast => {
            // Both tests use the threshold: for the sample's own value, and for the fit's.
            let first = f64::from(judgement.value.abs()) / f64::from(FIRST_PEAK_PART);
            eased(first.min(judgement.fit.map_or(f64::INFINITY, |fit| fit.value.abs())))
        }
        Test::SlopeExtremum if rises_past_the_rim(trail, fate, report.rival?.slope) => {
            let change = widened_towards(&params.used_slopes(), fate)?;
            return Some((format!("it rises towards the limit of the slopes: widen them to {}", change.value), change));
        }
        Test::SlopeExtremum => SlopeExtrema::Each.word().to_owned(),
        Test::Outside => {
            let is_finer = params.first_octave > -1 && judgement.fit.is_some_and(|fit| fit.level_refined < 0.0);
            is_finer.then(|| (params.first_octave - 1).to_string())?
        }
        Test::MaxFeatures => report.value?.to_string(),
        Test::NoiseGate if report.value? < LEAST_GATE => return None,
        // See `duplicate_remedy`.
        Test::Duplicate => return None,
        _ => eased(report.value.filter(|value| value.is_finite())?),
    };
    let mut was = parameter.text(&params.clone().into());
    if test == Test::NoiseGate && !matches!(params.noise_gate, NoiseGate::Factor(_)) {
        was = format!("{} ({was})", number(trail.detection().noise_gate_factor, 2));
    }
    Some(remedied(test, ParamChange::new(parameter, value), &was))
}

fn remedied(test: Test, change: ParamChange, was: &str) -> (String, ParamChange) {
    let sentence = filled(test.record().remedy, |word| match word {
        "new" => change.value.clone(),
        "was" => was.to_owned(),
        _ => change.parameter.label.to_lowercase(),
    });
    (sentence, change)
}

/// The smallest change that keeps a keypoint beside the stronger one on its blob; `None` for one that is no duplicate,
/// and where it would keep almost all duplicates. It takes a while: the nearby keypoints are compared again.
pub fn duplicate_remedy(trail: &Trail, fate: &Fate) -> Option<Remedy> {
    let index = fate.keypoint.filter(|_| fate.first_failed == Some(Test::Duplicate))?;
    let (sentence, change) = distinct_change(trail, index)?;
    Some(Remedy { sentence, change, then_fails: fate.fails_later().next() })
}

fn distinct_change(trail: &Trail, index: usize) -> Option<(String, ParamChange)> {
    let params = trail.params();
    let Distinct::Radius(radius) = params.distinct else { return None };
    let (own, stronger) = (trail.keypoints()[index], trail.keypoints()[trail.covered_by(index)?]);
    let distance = f64::from(apart_sigmas(&stronger, &own));
    let (a, b) = (stronger.in_image().2, own.in_image().2);
    let ratio = f64::from(a.max(b) / a.min(b));
    let (closer, less) = (rounded_down((1.0 - EASE) * distance, 2), rounded_down((1.0 - EASE) * ratio, 3));
    let (part_closer, part_less) = (closer / f64::from(radius), (less - 1.0) / f64::from(params.distinct_scale - 1.0));
    // The smaller change first; whether it has the effect depends on the nearby keypoints.
    let by_radius = (part_closer >= LEAST_PART && trail.would_stay(index, closer as f32, params.distinct_scale))
        .then(|| (part_closer, ParamChange::new(doc::DISTINCT, closer), radius.to_string()));
    let by_ratio = (part_less >= LEAST_PART && trail.would_stay(index, radius, less as f32))
        .then(|| (part_less, ParamChange::new(doc::DISTINCT_SCALE, less), params.distinct_scale.to_string()));
    let (_, change, was) = by_radius.into_iter().chain(by_ratio).max_by(|a, b| a.0.total_cmp(&b.0))?;
    Some(remedied(Test::Duplicate, change, &was))
}

/// The change that extends the axis on whose rim a candidate lies by one step.
pub(super) fn widened_towards(grid: &SlopeGrid, fate: &Fate) -> Option<ParamChange> {
    let rival = fate.report(Test::SlopeExtremum).rival;
    let index = match fate.first_failed {
        Some(Test::SlopeExtremum) => grid.slopes().position(|s| Some(s) == rival.map(|r| r.slope))?,
        _ => grid.nearest(fate.slope),
    };
    let (i, j) = grid.coordinates(index);
    let ends = |at: usize, count: usize| (count > 1 && at == 0, count > 1 && at + 1 == count);
    let (u, v) = (ends(i, grid.u.count), ends(j, grid.v.count));
    if u.0 || u.1 {
        return Some(ParamChange::new(doc::SLOPES_U, grid.u.with_more(usize::from(u.0), usize::from(u.1))));
    }
    (v.0 || v.1).then(|| ParamChange::new(doc::SLOPES_V, grid.v.with_more(usize::from(v.0), usize::from(v.1))))
}

/// Ratio of the samples that searches with `then` and with `now` examine in frames of `size` (columns, rows).
pub fn time_factor(now: &DetectorParams, then: &DetectorParams, size: (usize, usize)) -> f32 {
    let samples = |params: &DetectorParams| {
        let pixels = |octave: i32| {
            let (width, height) = octave_size(size, octave);
            width as f64 * height as f64
        };
        let of_slope: f64 = searched_octaves(params, size).map(pixels).sum();
        of_slope * f64::from(params.levels) * params.used_slopes().len() as f64
    };
    (samples(then) / samples(now).max(1.0)) as f32
}
