//! The candidates near a place, with their fates.

use crate::detector::scale_space::octave_pixel;
use crate::detector::search::extrema::{Candidate, Thresholds, own_slope_extrema};
use crate::detector::{Sample, Tally, Test, Trail};
use crate::inspect::fate::Fate;
use crate::inspect::remedy::duplicate_remedy;
use crate::inspect::telling::fate;
use crate::monitor::{Cancelled, Monitor};
use crate::plane::tile::Region;

/// The fates of all candidates near a place (u, v), input pixels, within `reach_sigmas` of their σ: kept ones first,
/// then in order of how far they came and of their strength.
///
/// # Errors
/// [`Cancelled`] once `monitor` was cancelled.
pub fn fates_near(
    trail: &Trail,
    place: [f32; 2],
    reach_sigmas: f32,
    monitor: &Monitor,
) -> Result<Vec<Fate>, Cancelled> {
    let mut fates = Vec::new();
    for octave in trail.octaves() {
        candidates_near(trail, place, octave, reach_sigmas, monitor, &mut fates)?;
    }
    sort(&mut fates);
    Ok(fates)
}

pub(super) fn sort(fates: &mut [Fate]) {
    fates.sort_by(|a, b| {
        let stage = |fate: &Fate| fate.first_failed.map_or(Test::ALL.len(), |test| test as usize);
        let strength = |fate: &Fate| if fate.snr.is_finite() { fate.snr } else { fate.value.abs() };
        stage(b).cmp(&stage(a)).then(strength(b).total_cmp(&strength(a)))
    });
}

/// Appends the fates of an octave's candidates near a place; returns the number of samples examined.
pub(super) fn candidates_near(
    trail: &Trail,
    place: [f32; 2],
    octave: i32,
    reach_sigmas: f32,
    monitor: &Monitor,
    out: &mut Vec<Fate>,
) -> Result<usize, Cancelled> {
    let (size, pixel, levels) = (trail.octave_size(octave), octave_pixel(octave), trail.space().levels);
    let reach = |level: i32| (reach_sigmas * trail.space().sigma_octave(f64::from(level)) as f32).max(2.0);
    let widest = reach(levels as i32 - 1).ceil() as usize;
    let middle = |x: f32, n: usize| ((x / pixel).round().max(0.0) as usize).min(n - 1);
    let (x, y) = (middle(place[0], size.0), middle(place[1], size.1));
    let region = Region { columns: x..x + 1, rows: y..y + 1 }.widened(widest, size);
    let around = trail.neighbourhood(octave, &region, monitor)?;
    let open = Thresholds { peak: 0.0, gate: vec![0.0; levels + 2] };
    let mut samples = Vec::new();
    for (slope_index, dog) in around.tiles.iter().enumerate() {
        let mut found: Vec<Candidate> = Vec::new();
        own_slope_extrema(&dog.levels, &region, size, &open, &mut Tally::default(), &mut found);
        samples.extend(found.iter().filter_map(|c| {
            let level = c.level_index as i32 - 1;
            let (du, dv) = (c.x as f32 - place[0] / pixel, c.y as f32 - place[1] / pixel);
            (du.hypot(dv) <= reach(level)).then_some(Sample { octave, level, slope_index, x: c.x, y: c.y })
        }));
    }
    let judged = trail.judge(&around, &samples);
    out.extend(samples.iter().zip(judged).filter_map(|(sample, j)| Some(fate(trail, &around, sample, &j?))));
    Ok(region.columns.len() * region.rows.len() * levels * around.tiles.len())
}

/// Appends the fate of a feature whose sample is too far from its refined position to be among the candidates near
/// that.
pub(super) fn add_feature(
    trail: &Trail,
    index: usize,
    monitor: &Monitor,
    fates: &mut Vec<Fate>,
) -> Result<(), Cancelled> {
    let keypoint = trail.keypoint_of_feature(index);
    if fates.iter().any(|fate| fate.keypoint == Some(keypoint)) {
        return Ok(());
    }
    let k = trail.keypoints()[keypoint];
    let [x, y] = k.sample.map(|at| at as usize);
    let sample = Sample { octave: k.octave, level: k.level, slope_index: k.slope_index, x, y };
    fates.extend(fate_of(trail, &sample, monitor)?);
    Ok(())
}

/// The fate of one sample; `None` on its octave's border, which the search does not examine.
///
/// # Errors
/// [`Cancelled`] once `monitor` was cancelled.
pub fn fate_of(trail: &Trail, sample: &Sample, monitor: &Monitor) -> Result<Option<Fate>, Cancelled> {
    let region = Region { columns: sample.x..sample.x + 1, rows: sample.y..sample.y + 1 };
    let around = trail.neighbourhood(sample.octave, &region, monitor)?;
    let judgement = trail.judge(&around, std::slice::from_ref(sample))[0];
    Ok(judgement.map(|judgement| {
        let fate = fate(trail, &around, sample, &judgement);
        let remedy = duplicate_remedy(trail, &fate).or_else(|| fate.remedy.clone());
        Fate { remedy, ..fate }
    }))
}
