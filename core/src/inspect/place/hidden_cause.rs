//! Causes at a place that no single candidate shows: a thing too small for the scales that are searched, one that was
//! found at another slope, and a setting that would only keep a ghost. They come from the extrema of D in space at each
//! slope, candidates or not.

use super::order::{AT_PLACE_PX, LARGE_PX, Nearness, is_like_scale, is_same_motion};
use super::pixels::{Around, around};
use super::{fate::Fate, remedy::time_factor, response::covering};
use crate::burst::Burst;
use crate::detector::coherence::Shape;
use crate::detector::scale_space::octave_pixel;
use crate::detector::test::LOWEST_GATE;
use crate::detector::{DetectorParams, Feature, Neighbourhood, NoiseGate, ParamChange, Sample, Scale, Slope, Trail};
use crate::detector::{noise::gate_factor, params::doc, pipeline::search};
use crate::inspect::words::{number, slope_text};
use crate::monitor::{Cancelled, Monitor};
use crate::plane::tile::Region;
use serde::Serialize;

/// Kind of a hidden cause.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum CauseKind {
    /// The response still rises towards the smallest scale that is searched.
    TooSmall,
    /// A feature was kept at the place, at another slope than the one looked at.
    AtAnotherSlope,
    /// The setting that would keep the candidate would keep a ghost.
    Ghost,
}

/// Cause that acts at a place and that no single candidate there shows.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Cause {
    /// Its kind.
    pub kind: CauseKind,
    /// Slope that it is about, px/frame.
    pub slope: Slope,
    /// A sentence without a capital at its start or a full stop at its end. Features are counted from 0.
    pub sentence: String,
    /// Scale σ of the thing, input pixels, and its SNR there, of one that is too small.
    pub sigma_and_snr: Option<(f32, f32)>,
    /// Index of the feature of the detection, of one that was found.
    pub feature: Option<usize>,
    /// Setting by which it is found.
    pub change: Option<ParamChange>,
}

impl Cause {
    fn new(kind: CauseKind, slope: Slope, sentence: String) -> Self {
        Self { kind, slope, sentence, sigma_and_snr: None, feature: None, change: None }
    }
}

/// Extremum of D in space at its own slope and level, near a place.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Peak {
    pub sample: Sample,
    /// D.
    pub value: f32,
    /// Whether it lies at the smallest scale, and |D| is larger at the level below.
    rises: bool,
}

/// The extrema in space within [`AT_PLACE_PX`] of a place, at scales up to [`LARGE_PX`] and all slopes.
pub(super) fn peaks(trail: &Trail, around: &Neighbourhood, place: [f32; 2]) -> Vec<Peak> {
    let (octave, pixel, space) = (around.octave, octave_pixel(around.octave), trail.space());
    let within = |at: f32, n: usize| {
        let end = ((at + AT_PLACE_PX) / pixel).floor() as usize + 1;
        ((at - AT_PLACE_PX) / pixel).ceil().max(1.0) as usize..end.min(n.saturating_sub(1))
    };
    let (columns, rows) = (within(place[0], around.size.0), within(place[1], around.size.1));
    let small = |level: &i32| space.sigma_image(octave, f64::from(*level)) as f32 <= LARGE_PX;
    let levels: Vec<i32> = (0..space.levels as i32).filter(small).collect();
    let mut found = Vec::new();
    for (slope_index, dog) in around.tiles.iter().enumerate() {
        for (&level, y) in levels.iter().flat_map(|level| rows.clone().map(move |y| (level, y))) {
            let away = |x: usize| (x as f32 * pixel - place[0]).hypot(y as f32 * pixel - place[1]);
            for x in columns.clone().filter(|x| away(*x) <= AT_PLACE_PX) {
                let sample = Sample { octave, level, slope_index, x, y };
                let value = dog.at(sample.level_index(), x, y);
                // The strongest of the 3 × 3 samples of a level, but for the middle of the own one.
                let strongest = |at: usize| {
                    let near = (y - 1..=y + 1).flat_map(move |v| (x - 1..=x + 1).map(move |u| (u, v)));
                    let others = near.filter(|place| at != sample.level_index() || *place != (x, y));
                    others.map(|(u, v)| value.signum() * dog.at(at, u, v)).fold(f32::NEG_INFINITY, f32::max)
                };
                if strongest(sample.level_index()) < value.abs() {
                    let is_finest = (octave, level) == (space.first_octave, 0);
                    found.push(Peak { sample, value, rises: is_finest && strongest(0) > value.abs() });
                }
            }
        }
    }
    found
}

/// A peak that noise hardly makes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Clear {
    pub peak: Peak,
    pub pos_image: [f32; 2],
    pub slope: Slope,
    pub snr: f32,
}

/// The strongest of the `peaks` relative to their noise; `None` where none is clear, and in a burst without noise.
pub(super) fn clearest<'p>(trail: &Trail, peaks: impl Iterator<Item = &'p Peak>) -> Option<Clear> {
    let over_least = |peak: &Peak| {
        let Sample { octave, level, slope_index, .. } = peak.sample;
        peak.value.abs() / trail.sigma_d_min(Scale { octave, level }, slope_index)
    };
    // The noise of a place costs some time: it is computed for the strongest of each slope.
    let mut of_slopes: Vec<Option<(&Peak, f32)>> = vec![None; trail.params().used_slopes().len()];
    for (peak, ratio) in peaks.map(|peak| (peak, over_least(peak))).filter(|(_, ratio)| ratio.is_finite()) {
        let best = &mut of_slopes[peak.sample.slope_index];
        if best.is_none_or(|(_, other)| ratio > other) {
            *best = Some((peak, ratio));
        }
    }
    let clear = |(peak, _): (&Peak, f32)| {
        let Sample { octave, level, slope_index, x, y } = peak.sample;
        let (pixel, slope) = (octave_pixel(octave), trail.params().used_slopes().slope(slope_index));
        let pos_image = [x as f32 * pixel, y as f32 * pixel];
        let snr = peak.value.abs() / noise_at(trail, Scale { octave, level }, pos_image, slope);
        Clear { peak: *peak, pos_image, slope, snr }
    };
    let strongest = of_slopes.into_iter().flatten().map(clear).max_by(|a, b| a.snr.total_cmp(&b.snr));
    strongest.filter(|clear| clear.snr.is_finite() && clear.snr >= LOWEST_GATE)
}

/// σ of D at any scale, place and slope, over the frames that show it.
fn noise_at(trail: &Trail, scale: Scale, [u, v]: [f32; 2], slope: Slope) -> f32 {
    trail.sigma_d_at(scale, ((u, v), slope), &covering(trail, [u, v], slope))
}

/// The reason why a thing at the place that moves by one of `slopes` is too small, if one is: the clearest of several.
pub(crate) fn too_small(
    trail: &Trail,
    peaks: &[Peak],
    slopes: &[Slope],
    monitor: &Monitor,
) -> Result<Option<Cause>, Cancelled> {
    let grid = trail.params().used_slopes();
    let sigma = trail.space().sigma_image(trail.space().first_octave, 0.0) as f32;
    let mut best: Option<((bool, f32), Cause)> = None;
    for &slope in slopes {
        let moves = |peak: &&Peak| is_same_motion(trail, grid.slope(peak.sample.slope_index), slope, sigma);
        let Some(clear) = clearest(trail, peaks.iter().filter(|peak| peak.rises).filter(moves)) else { continue };
        let Some(reason) = finer(trail, &clear, monitor)? else { continue };
        let rank = (reason.change.is_some(), clear.snr);
        if best.as_ref().is_none_or(|(best, _)| rank > *best) {
            best = Some((rank, reason));
        }
    }
    Ok(best.map(|(_, reason)| reason))
}

/// Scale, slope and strength of what rises beyond the smallest scale, in the octaves below, as a reason. `None` where
/// it falls again, or does not reach the gate of a search from there.
fn finer(trail: &Trail, clear: &Clear, monitor: &Monitor) -> Result<Option<Cause>, Cancelled> {
    let (params, first) = (trail.params(), trail.space().first_octave);
    let smallest = number(trail.space().sigma_image(first, 0.0) as f32, 1);
    let rises = |slope: Slope| {
        let rises = format!("the response still rises towards scales below σ {smallest} px");
        format!("too small for the smallest scale: at slope {} {rises}", slope_text(slope))
    };
    if first <= FINEST_OCTAVE {
        let reaches = clear.snr >= trail.detection().noise_gate_factor;
        return Ok(reaches.then(|| Cause::new(CauseKind::TooSmall, clear.slope, rises(clear.slope))));
    }
    let next = number((first - 1) as f32, 0);
    let peak = climbed(trail, clear, first - 1, monitor)?;
    let changed = DetectorParams { first_octave: first - 1, ..params.clone() };
    if peak.height <= clear.peak.value.abs() || peak.snr < gate_factor(&changed) {
        return Ok(None);
    }
    let mut sigma_and_snr = (trail.space().sigma_image(first - 1, f64::from(peak.level)) as f32, peak.snr);
    if peak.level < 0 {
        // At its own slope it may still rise, and yet be kept at one of the grid.
        let Some(kept) = kept_there(trail, &changed, (clear.pos_image, peak.slope), monitor)? else {
            let sentence = format!("{}, and a first octave of {next} keeps nothing here either", rises(peak.slope));
            return Ok(Some(Cause::new(CauseKind::TooSmall, peak.slope, sentence)));
        };
        sigma_and_snr = kept;
    }
    let times = number(time_factor(params, &changed, trail.size_image()), 0);
    let sentence = format!(
        "{}; first octave {next} finds it (σ {} px, {} σ of its noise), and the search of as many slopes then takes about {times} times as long",
        rises(peak.slope),
        number(sigma_and_snr.0, 1),
        number(sigma_and_snr.1, 1)
    );
    let change = Some(ParamChange::new(doc::FIRST_OCTAVE, first - 1));
    let reason = Cause::new(CauseKind::TooSmall, peak.slope, sentence);
    Ok(Some(Cause { sigma_and_snr: Some(sigma_and_snr), change, ..reason }))
}

/// Pixels beyond the motion of a place that decide whether a small thing is kept there.
const AROUND_PX: f32 = 64.0;

/// Scale, input pixels, and SNR of the strongest feature too small for the search that one with `params` keeps at a
/// place (u, v) with its slope: the frames are searched again around it.
fn kept_there(
    trail: &Trail,
    params: &DetectorParams,
    ([u, v], slope): ([f32; 2], Slope),
    monitor: &Monitor,
) -> Result<Option<(f32, f32)>, Cancelled> {
    let (frames, kept, positions) = trail.frames();
    let fastest = trail.params().used_slopes().slopes().map(Slope::magnitude).fold(0.0, f32::max);
    let reach = fastest * positions.reach() as f32;
    let part = |x: f32, n: usize| {
        let from = (x - reach - AROUND_PX).max(0.0) as usize;
        from..n.min((x + reach + AROUND_PX) as usize + 1)
    };
    let near = Region { columns: part(u, trail.size_image().0), rows: part(v, trail.size_image().1) };
    let burst = Burst::from_planes("place", frames.iter().map(|frame| frame.part(&near)).collect());
    let burst = Burst { positions: positions.of(kept), ..burst };
    let early = kept.first().map_or((0.0, 0.0), |first| {
        slope.displacement((positions.offset(*first) - burst.positions.offset(0)).to_f32())
    });
    let place = [u - early.0 - near.columns.start as f32, v - early.1 - near.rows.start as f32];
    let noise_gate = NoiseGate::Factor(gate_factor(params));
    let params = DetectorParams { frames: None, octaves: 1, max_features: 0, noise_gate, ..params.clone() };
    let Ok(found) = search(&burst, &params, monitor) else { return monitor.check().map(|()| None) };
    let smallest = trail.space().sigma_image(trail.space().first_octave, 0.0) as f32;
    let is_it = |feature: &&Feature| {
        (feature.u - place[0]).hypot(feature.v - place[1]) <= AT_PLACE_PX
            && feature.sigma <= smallest
            && is_same_motion(trail, feature.slope, slope, feature.sigma)
    };
    let strongest = found.features.iter().filter(is_it).max_by(|a, b| a.snr.total_cmp(&b.snr));
    Ok(strongest.map(|feature| (feature.sigma, feature.snr)))
}

const FINEST_OCTAVE: i32 = -1;

/// The extremum over place, scale and slope that a peak leads to in an octave that may not have been searched.
struct Climbed {
    height: f32,
    /// −1 where it still rises.
    level: i32,
    slope: Slope,
    snr: f32,
}

/// Climbs from scale to scale, downwards as long as |D| rises: noise is larger at small scales, farther away.
fn climbed(trail: &Trail, clear: &Clear, octave: i32, monitor: &Monitor) -> Result<Climbed, Cancelled> {
    let (grid, pixel, levels) = (trail.params().used_slopes(), octave_pixel(octave), trail.space().levels);
    let (width, height) = trail.size_image();
    // Of all levels from −1 on.
    let heights = |[u, v]: [f32; 2], slope: Slope| -> Vec<f32> {
        let chosen = covering(trail, [u, v], slope);
        let values = trail.along().response(octave, -1..levels as i32, (u, v), slope, &chosen);
        values.into_iter().map(|value| clear.peak.value.signum() * value).collect()
    };
    // Its slope first: beside it a small thing is smeared, and noise outdoes it.
    let (i, j) = grid.position(clear.slope);
    let thirds = |count: usize| if count > 1 { -THIRDS..=THIRDS } else { 0..=0 };
    let near = thirds(grid.u.count).flat_map(|du| thirds(grid.v.count).map(move |dv| (du, dv)));
    let slopes = near.map(|(du, dv)| grid.at(i + du as f32 * THIRD, j + dv as f32 * THIRD));
    let at_slopes = slopes.map(|slope| (slope, heights(clear.pos_image, slope)[levels]));
    let slope = at_slopes.max_by(|a, b| a.1.total_cmp(&b.1)).map_or(clear.slope, |(slope, _)| slope);
    let steps = (REACH_PX / pixel).ceil() as i32;
    let moved = |x: f32, step: i32, n: usize| (x + step as f32 * pixel).clamp(0.0, n as f32 - 1.0);
    let [u, v] = clear.pos_image;
    let mut around = Vec::new();
    for (row, column) in (-steps..=steps).flat_map(|row| (-steps..=steps).map(move |column| (row, column))) {
        monitor.check()?;
        let place = [moved(u, column, width), moved(v, row, height)];
        around.push((place, heights(place, slope)));
    }
    let highest = |index: usize, near: [f32; 2], reach_px: f32| {
        let is_near = |place: &[f32; 2]| (place[0] - near[0]).hypot(place[1] - near[1]) <= reach_px;
        let there = around.iter().filter(|(place, _)| is_near(place)).map(|(place, heights)| (*place, heights[index]));
        there.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((near, f32::NEG_INFINITY))
    };
    let mut index = levels;
    let mut top = highest(index, clear.pos_image, REACH_PX);
    while index > 0 {
        let below = highest(index - 1, top.0, 1.5 * pixel);
        if below.1 <= top.1 {
            break;
        }
        (index, top) = (index - 1, below);
    }
    let level = index as i32 - 1;
    let snr = top.1 / noise_at(trail, Scale { octave, level: level.max(0) }, top.0, slope);
    Ok(Climbed { height: top.1, level, slope, snr })
}

/// Distance, input pixels, from a peak within which the extremum lies.
const REACH_PX: f32 = 1.5;
/// Slopes around that of a peak: so many to each side of each axis, a part of the grid's step apart.
const THIRDS: i32 = 3;
const THIRD: f32 = 1.0 / 3.0;

/// Features at the place that move by another slope than the first one in order, if none there moves by that.
pub(super) fn at_another_slope(trail: &Trail, nearness: &Nearness, fates: &[Fate], own: Option<Slope>) -> Vec<Cause> {
    let is_small =
        |fate: &&Fate| fate.sigma <= LARGE_PX || nearness.sigma.is_some_and(|s| is_like_scale(fate.sigma, s));
    let kept = || fates.iter().filter(|fate| fate.is_kept() && nearness.is_here(fate)).filter(is_small);
    if nearness.slopes.is_empty() || kept().any(|fate| nearness.class(trail, fate) == 0) {
        return Vec::new();
    }
    let reason = |fate: &Fate| {
        let feature = *fate.features.first()?;
        let other = own.filter(|own| !is_same_motion(trail, fate.slope, *own, fate.sigma));
        let most =
            other.map_or_else(String::new, |own| format!(", while the place's own motion is {}", slope_text(own)));
        let sentence = format!("found at another slope: feature {feature} at slope {}{most}", slope_text(fate.slope));
        Some(Cause { feature: Some(feature), ..Cause::new(CauseKind::AtAnotherSlope, fate.slope, sentence) })
    };
    kept().filter_map(reason).take(MOST_OTHERS).collect()
}

const MOST_OTHERS: usize = 2;

/// The reason why the setting that would keep `fate` is not proposed, if only some of the frames respond along its
/// motion, or the picture around it changes: it would not be judged real.
pub(super) fn ghost(trail: &Trail, fate: &Fate, monitor: &Monitor) -> Result<Option<Cause>, Cancelled> {
    if fate.is_kept() {
        return Ok(None);
    }
    let &Fate { pos_image: [u, v], would_move: slope, octave, level, sigma, .. } = fate;
    let feature = Feature { u, v, slope, sigma, octave, level, ..Feature::default() };
    let why = match trail.evenness_of(&[feature], &monitor.silent())?[0].shape {
        Shape::Bump => Some("only some of the frames respond along its motion, as for a ghost".to_owned()),
        _ => around(trail, &feature, monitor)?
            .filter(|(motion, ..)| !matches!(motion, Around::MovesAlsoBy(_)))
            .map(|(.., evidence)| evidence),
    };
    Ok(why.map(|why| Cause::new(CauseKind::Ghost, slope, format!("no setting is proposed: {why}"))))
}

/// Index of the grid's slope nearest to `slope`, and the strongest of the `peaks` there, or of those around it.
pub(super) fn at_slope(trail: &Trail, nearness: &Nearness, peaks: &[Peak], slope: Slope) -> Option<(usize, Clear)> {
    let (grid, space) = (trail.params().used_slopes(), trail.space());
    let scale = |peak: &&Peak| {
        let sigma = space.sigma_image(peak.sample.octave, f64::from(peak.sample.level)) as f32;
        nearness.sigma.is_none_or(|near| is_like_scale(sigma, near))
            && is_same_motion(trail, grid.slope(peak.sample.slope_index), slope, sigma)
    };
    Some((grid.nearest(slope), clearest(trail, peaks.iter().filter(scale))?))
}
