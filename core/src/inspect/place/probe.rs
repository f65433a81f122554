//! The probe: all explanations of one place of a burst, with the fates of the candidates near it.

use super::hidden_cause::{self, Cause, CauseKind, Clear, Peak, at_slope, clearest};
use super::needed::{Needed, needed};
use super::order::{AT_PLACE_PX, LARGE_PX, Nearness, PlaceMotion, is_like_scale, is_same_motion, strength};
use super::response::{ResponseMap, response_map};
use super::shares::{Shares, Slice, across, direction_of, shares, slice};
use super::suspicion::{Judged, Strengths, Suspicion, suspicions};
use super::{candidate_tests::fate, candidates::open_candidates, fate::Fate, remedy::duplicate_remedy};
use crate::detector::{Sample, Scale, Slope, Test, Trail};
use crate::detector::{scale_space::octave_pixel, test::NOT_SEARCHED};
use crate::error::{Error, Result};
use crate::inspect::ProbeCache;
use crate::inspect::words::{counted, number, slope_text};
use crate::monitor::{Cancelled, Monitor};
use crate::plane::tile::Region;
use serde::{Deserialize, Serialize};

/// Subject that the probe examines more closely.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ProbeSubject {
    /// The first candidate of the list that lies within [`AT_PLACE_PX`] of the place. The place itself, at the slope
    /// looked at or its own motion, where it responds there and no candidate tells why; and where there is none.
    #[default]
    Best,
    /// A feature of the detection, by its index.
    Feature(usize),
    /// A scale and a slope of the grid, at the place.
    Scale {
        /// Octave.
        octave: i32,
        /// DoG level.
        level: i32,
        /// Index of the slope in the grid.
        slope_index: usize,
    },
    /// A candidate near the place, by its sample; as [`ProbeSubject::Best`] where there is none.
    Candidate(Sample),
}

/// Options of a probe.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProbeOptions {
    /// Maximum distance of candidates near the place, in their σ; at least two pixels of their octave.
    pub reach_sigmas: f32,
    /// Subject to examine more closely.
    pub wanted: ProbeSubject,
    /// Scale σ near which candidates come first, input pixels. Without one, that of a [`ProbeSubject::Feature`].
    pub near_sigma: Option<f32>,
    /// Slope that is looked at, px/frame: candidates at the place that move by it come first. For
    /// [`ProbeSubject::Feature`] without one, the feature's.
    pub in_view: Option<Slope>,
    /// Motion of the place: candidates with it come next. Without one, the slope at which the place responds most.
    pub motion: Option<PlaceMotion>,
    /// Pixels to each side in the slices.
    pub slice_half_px: usize,
}

impl Default for ProbeOptions {
    fn default() -> Self {
        let (wanted, near_sigma, in_view, motion) = (ProbeSubject::Best, None, None, None);
        Self { reach_sigmas: 2.0, wanted, near_sigma, in_view, motion, slice_half_px: 60 }
    }
}

/// Subject that is examined more closely.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Subject {
    /// Index of its fate, if it is a candidate near the place.
    pub fate: Option<usize>,
    /// (u, v) at mid-burst, input pixels.
    pub pos_image: [f32; 2],
    /// Slope, px/frame.
    pub slope: Slope,
    /// Index of the slope in the grid.
    pub slope_index: usize,
    /// Octave.
    pub octave: i32,
    /// DoG level.
    pub level: i32,
}

/// Result of a probe.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Probe {
    /// Place, input pixels.
    pub pos_image: [f32; 2],
    /// Fates of the candidates near it. Those at the place ([`AT_PLACE_PX`]) come first: at the slope in view, then at
    /// the place's own motion, then others. Of these, and farther away, those nearest in place and given scale come
    /// first, then kept ones, then those with the largest SNR. Larger blobs that reach over the place come last.
    pub fates: Vec<Fate>,
    /// Number of fates before the larger blobs.
    #[serde(skip)]
    pub near: usize,
    /// Number of samples of D examined near the place, candidates or not.
    pub samples: usize,
    /// Subject that is examined more closely.
    pub subject: Subject,
    /// Causes at the place that no single candidate shows.
    pub reasons: Vec<Cause>,
    /// Motion of the place as given.
    pub motion: Option<PlaceMotion>,
    /// Slope of that motion, or else that at which the place responds most, px/frame. `None` without a clear response.
    pub own_slope: Option<Slope>,
    /// Response over slope and scale.
    pub response: ResponseMap,
    /// Response of each frame along the subject's motion.
    pub shares: Shares,
    /// Changes in the world by which the subject would pass the noise gate, if it fails that.
    pub outlook: Option<Needed>,
    /// Likely nature of the subject, if it was kept.
    pub judged: Option<Judged>,
    /// Reasons to doubt the subject, if it was kept.
    pub suspicions: Vec<Suspicion>,
    /// Slices through the subject's position: along its motion, and across it.
    #[serde(skip)]
    pub slices: [Slice; 2],
    /// Summary, a sentence or two.
    pub summary: String,
}

impl Probe {
    /// The fate of the subject.
    pub fn subject_fate(&self) -> Option<&Fate> {
        self.subject.fate.map(|index| &self.fates[index])
    }

    /// The candidates near the place, without larger blobs that only reach over it.
    pub fn near_fates(&self) -> &[Fate] {
        &self.fates[..self.near]
    }

    /// The larger blobs that only reach over the place.
    pub fn larger_fates(&self) -> &[Fate] {
        &self.fates[self.near..]
    }
}

/// Checks that `place` (u, v) lies in a picture of `size` (columns, rows), whose outer pixels reach half a pixel
/// beyond their centres.
pub fn check_place(place: [f32; 2], size: (usize, usize)) -> Result<()> {
    let inside = |x: f32, n: usize| x >= -0.5 && x <= n as f32 - 0.5;
    if inside(place[0], size.0) && inside(place[1], size.1) { Ok(()) } else { Err(outside(place, size)) }
}

/// Error for a place outside a picture of `size` (columns, rows).
pub fn outside([u, v]: [f32; 2], (width, height): (usize, usize)) -> Error {
    let problem = format!("({u}, {v}) is outside the {width}×{height} image");
    Error::param("at", problem, format!("give 0 to {} and 0 to {}", width - 1, height - 1))
}

/// Explains what happened at `place` (u, v), input pixels of the mid-burst picture.
///
/// ```
/// use burstscope_core::inspect::{ProbeCache, place::{ProbeOptions, probe}};
/// use burstscope_core::{Monitor, detector::SearchParams, synth::demo_burst};
/// let (burst, monitor) = (demo_burst(), Monitor::default());
/// let cache = ProbeCache::new(&burst, &SearchParams::default(), &monitor)?;
/// let answer = probe(&cache, [92.0, 58.0], &ProbeOptions::default(), &monitor)?;
/// assert!(!answer.fates.is_empty(), "candidates near the place, each with its tests");
/// # Ok::<(), burstscope_core::Error>(())
/// ```
pub fn probe(cache: &ProbeCache, place: [f32; 2], options: &ProbeOptions, monitor: &Monitor) -> Result<Probe> {
    let trail = &cache.trail;
    let mut nearness = Nearness { place, sigma: options.near_sigma, slopes: options.in_view.into_iter().collect() };
    if let ProbeSubject::Feature(index) = options.wanted {
        let features = &trail.detection().features;
        let feature = features.get(index).ok_or_else(|| {
            let problem = format!("there is no feature {index}: the detection has {}", features.len());
            Error::param("feature", problem, "")
        })?;
        nearness.place = [feature.u, feature.v];
        nearness.sigma = options.near_sigma.or(Some(feature.sigma));
        nearness.slopes = vec![options.in_view.unwrap_or(feature.slope)];
    }
    let place = nearness.place;
    check_place(place, trail.size_image())?;
    let Near { mut fates, samples, peaks } = near(trail, place, options.reach_sigmas, monitor)?;
    if let ProbeSubject::Feature(index) = options.wanted {
        add_feature(trail, index, monitor, &mut fates)?;
    }
    let motion = options.motion.or_else(|| motion_of(trail, place));
    let own_slope = motion.map(|motion| motion.slope);
    let own_slope = own_slope.or_else(|| clearest(trail, peaks.iter()).map(|clear| clear.slope));
    nearness.slopes.extend(own_slope);
    let near = nearness.sort(trail, &mut fates);
    let subject = subject(trail, &nearness, (&fates, &peaks), options.wanted)?;
    let mut reasons = reasons(trail, &nearness, (&fates, &peaks), own_slope, monitor)?;
    if let Some(fate) = subject.fate.map(|index| &mut fates[index]) {
        fate.remedy = fate.remedy.take().or_else(|| duplicate_remedy(trail, fate));
        if fate.remedy.is_some()
            && let Some(reason) = hidden_cause::ghost(trail, fate, monitor)?
        {
            fate.remedy = None;
            reasons.push(reason);
        }
    }
    let grid = trail.params().used_slopes();
    let scale = Scale { octave: subject.octave, level: subject.level };
    let response = response_map(trail, subject.pos_image, grid.coordinates(subject.slope_index), scale, monitor)?;
    let shares = shares(trail, scale, subject.pos_image, subject.slope, monitor)?;
    let suspected = subject.fate.map(|index| suspicions(trail, &fates[index], &shares.evenness, monitor));
    let suspicions = suspected.transpose()?.unwrap_or_default();
    let is_no_ghost = reasons.iter().all(|reason| reason.kind != CauseKind::Ghost);
    let outlook = subject.fate.filter(|_| is_no_ghost).and_then(|index| needed(trail, &fates[index]));
    let feature = subject.fate.and_then(|index| fates[index].features.first());
    let snr = feature.map(|index| trail.detection().features[*index].snr);
    let judged = snr.map(|snr| Judged::of(&shares.evenness, &suspicions, snr, &Strengths::of(trail)));
    let direction = direction_of(subject.slope);
    let slices = [direction, across(direction)].map(|d| slice(trail, subject.pos_image, d, options.slice_half_px));
    let left_out = grid.len() - searched_slopes(trail, place);
    let mut summary = summary_of(&nearness, (&fates, near), &reasons, &response);
    if left_out > 0 {
        let here = match trail.searches(place, subject.slope_index) {
            true => format!("{left_out} of {} slopes are not searched here", grid.len()),
            false => format!("It is {NOT_SEARCHED}, nor at {} others of {}", left_out - 1, grid.len()),
        };
        summary += &format!(" {here}: the field of motion has none near. --search full tries them.");
    }
    Ok(Probe {
        pos_image: place,
        fates,
        near,
        samples,
        subject,
        reasons,
        motion,
        own_slope,
        response,
        shares,
        outlook,
        judged,
        suspicions,
        slices,
        summary,
    })
}

/// Certainty of the field's motion from which on it is taken for that of a single place. Between two planes the field
/// goes from one motion to the other within a few cells; places in between are less certain.
const CERTAIN: f32 = 0.8;

/// Motion of a place from the field of the search, where it is certain.
fn motion_of(trail: &Trail, [u, v]: [f32; 2]) -> Option<PlaceMotion> {
    let field = trail.detection().field.as_ref()?;
    let motion = field.at(u, v);
    (field.certainty(&motion) > CERTAIN).then(|| PlaceMotion { slope: motion.slope, sigma: motion.ellipse().0[0] })
}

/// Causes at the place: of a thing that is too small, unless one like it was kept, and of features at other slopes.
fn reasons(
    trail: &Trail,
    nearness: &Nearness,
    (fates, peaks): (&[Fate], &[Peak]),
    own_slope: Option<Slope>,
    monitor: &Monitor,
) -> Result<Vec<Cause>, Cancelled> {
    let small = hidden_cause::too_small(trail, peaks, &nearness.slopes, monitor)?;
    let is_kept = |fate: &Fate| fate.is_kept() && nearness.is_here(fate);
    let smallest = trail.space().sigma_image(trail.space().first_octave, 0.0) as f32;
    let is_it = |small: &Cause, fate: &Fate| {
        is_like_scale(fate.sigma, smallest) && is_same_motion(trail, fate.slope, small.slope, smallest)
    };
    let small = small.filter(|small| !fates.iter().any(|fate| is_kept(fate) && is_it(small, fate)));
    Ok(small.into_iter().chain(hidden_cause::at_another_slope(trail, nearness, fates, own_slope)).collect())
}

fn subject(
    trail: &Trail,
    nearness: &Nearness,
    (fates, peaks): (&[Fate], &[Peak]),
    wanted: ProbeSubject,
) -> Result<Subject> {
    let (grid, place) = (trail.params().used_slopes(), nearness.place);
    if let ProbeSubject::Scale { octave, level, slope_index } = wanted {
        let levels = 0..trail.space().levels as i32;
        if !trail.octaves().contains(&octave) || !levels.contains(&level) || slope_index >= grid.len() {
            let problem =
                format!("there is no octave {octave}, level {level} and slope number {slope_index} in this search");
            return Err(Error::param("", problem, ""));
        }
        let fate = fates.iter().position(|f| (f.octave, f.level, f.slope_index) == (octave, level, slope_index));
        return Ok(Subject { fate, pos_image: place, slope: grid.slope(slope_index), slope_index, octave, level });
    }
    let of_fate = |index: usize| {
        let &Fate { octave, level, slope_index, pos_image, slope, .. } = &fates[index];
        Subject { fate: Some(index), pos_image, slope, slope_index, octave, level }
    };
    let chosen = match wanted {
        ProbeSubject::Candidate(sample) => fates.iter().position(|fate| fate.of_sample() == sample),
        ProbeSubject::Feature(feature) => fates.iter().position(|fate| fate.features.contains(&feature)),
        _ => None,
    };
    if let Some(index) = chosen {
        return Ok(of_fate(index));
    }
    for (class, &slope) in nearness.slopes.iter().enumerate() {
        let is_of_it = |fate: &Fate| nearness.is_here(fate) && nearness.class(trail, fate) == class;
        let candidate = fates.iter().position(is_of_it);
        let clear = at_slope(trail, nearness, peaks, slope);
        // What is much larger than the candidate is something else.
        let sigma = |peak: &Peak| trail.space().sigma_image(peak.sample.octave, f64::from(peak.sample.level)) as f32;
        let is_less = |fate: &Fate, clear: &Clear| {
            let is_of_size = sigma(&clear.peak) <= fate.sigma || is_like_scale(sigma(&clear.peak), fate.sigma);
            is_of_size && strength(fate) < TELLING_PART * clear.snr
        };
        let tells = |fate: &Fate| fate.is_kept() || !clear.is_some_and(|(_, clear)| is_less(fate, &clear));
        match (candidate.filter(|index| tells(&fates[*index])), clear) {
            (Some(index), _) => return Ok(of_fate(index)),
            (None, Some((slope_index, Clear { peak, pos_image, snr, .. }))) => {
                // The motion of the strongest response is taken for the motion of the place.
                let is_small = |fate: &Fate| nearness.is_here(fate) && fate.sigma <= LARGE_PX;
                let is_more = |fate: &Fate| is_small(fate) && strength(fate) >= SAME_PART * snr;
                let is_own = class + 1 == nearness.slopes.len();
                if let Some(index) = fates.iter().position(is_more).filter(|_| is_own) {
                    return Ok(of_fate(index));
                }
                let Sample { octave, level, .. } = peak.sample;
                return Ok(Subject { fate: None, pos_image, slope, slope_index, octave, level });
            }
            (None, None) => {}
        }
    }
    if let Some(index) = fates.iter().position(|fate| nearness.is_here(fate)) {
        return Ok(of_fate(index));
    }
    let speed = |index: usize| grid.slope(index).magnitude();
    let slowest = || (0..grid.len()).min_by(|&a, &b| speed(a).total_cmp(&speed(b))).unwrap_or(0);
    let looked_at = nearness.slopes.first().copied();
    let slope_index = looked_at.map_or_else(slowest, |slope| grid.nearest(slope));
    let (octave, level) = fates.first().map_or((trail.octaves().start, 0), |fate| (fate.octave, fate.level));
    let slope = looked_at.unwrap_or_else(|| grid.slope(slope_index));
    Ok(Subject { fate: None, pos_image: place, slope, slope_index, octave, level })
}

/// Share of the strongest response at its slope from which a candidate that was not kept tells of it.
const TELLING_PART: f32 = 0.5;
/// Share of the strongest response of a place from which a candidate there is as strong.
const SAME_PART: f32 = 0.95;

/// Candidates that passed most tests first, then the strongest.
pub(crate) fn sorted_by_stage(mut fates: Vec<Fate>) -> Vec<Fate> {
    fates.sort_by(|a, b| {
        let stage = |fate: &Fate| fate.first_failed.map_or(Test::ALL.len(), |test| test as usize);
        stage(b).cmp(&stage(a)).then(strength(b).total_cmp(&strength(a)))
    });
    fates
}

fn searched_slopes(trail: &Trail, place: [f32; 2]) -> usize {
    (0..trail.params().used_slopes().len()).filter(|&index| trail.searches(place, index)).count()
}

/// Samples near a place.
#[derive(Debug, Default)]
pub(crate) struct Near {
    /// Candidates.
    pub fates: Vec<Fate>,
    /// Number of samples examined.
    pub samples: usize,
    /// Extrema in space at the place.
    pub peaks: Vec<Peak>,
}

/// Examines the samples within `reach_sigmas` of their σ of a place (u, v), input pixels.
pub(crate) fn near(trail: &Trail, place: [f32; 2], reach_sigmas: f32, monitor: &Monitor) -> Result<Near, Cancelled> {
    let mut out = Near::default();
    trail.octaves().try_for_each(|octave| add_octave(trail, place, octave, reach_sigmas, monitor, &mut out))?;
    Ok(out)
}

fn add_octave(
    trail: &Trail,
    place: [f32; 2],
    octave: i32,
    reach_sigmas: f32,
    monitor: &Monitor,
    out: &mut Near,
) -> Result<(), Cancelled> {
    let (size, pixel, levels) = (trail.octave_size(octave), octave_pixel(octave), trail.space().levels);
    let reach = |level: i32| (reach_sigmas * trail.space().sigma_octave(f64::from(level)) as f32).max(2.0);
    let widest = reach(levels as i32 - 1).ceil() as usize;
    let region = Region::around(place.map(|x| x / pixel), widest, size);
    let around = trail.neighbourhood(octave, &region, monitor)?;
    let mut samples = open_candidates(trail, &around);
    samples.retain(|sample| {
        let (du, dv) = (sample.x as f32 - place[0] / pixel, sample.y as f32 - place[1] / pixel);
        du.hypot(dv) <= reach(sample.level)
    });
    let judged = trail.judge(&around, &samples);
    out.fates.extend(samples.iter().zip(judged).filter_map(|(sample, j)| Some(fate(trail, &around, sample, &j?))));
    out.samples += region.columns.len() * region.rows.len() * levels * searched_slopes(trail, place);
    out.peaks.extend(hidden_cause::peaks(trail, &around, place));
    Ok(())
}

fn add_feature(trail: &Trail, index: usize, monitor: &Monitor, fates: &mut Vec<Fate>) -> Result<(), Cancelled> {
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
pub fn fate_of(trail: &Trail, sample: &Sample, monitor: &Monitor) -> Result<Option<Fate>, Cancelled> {
    let region = Region { columns: sample.x..sample.x + 1, rows: sample.y..sample.y + 1 };
    let around = trail.neighbourhood(sample.octave, &region, monitor)?;
    let judgement = trail.judge(&around, std::slice::from_ref(sample))[0];
    Ok(judgement.map(|judgement| {
        let fate = fate(trail, &around, sample, &judgement);
        Fate { remedy: duplicate_remedy(trail, &fate).or_else(|| fate.remedy.clone()), ..fate }
    }))
}

fn summary_of(nearness: &Nearness, (fates, near): (&[Fate], usize), reasons: &[Cause], map: &ResponseMap) -> String {
    let here: Vec<&Fate> = fates.iter().filter(|fate| nearness.is_here(fate)).collect();
    let kept = here.iter().filter(|f| f.is_kept()).count();
    if let Some(small) = reasons.iter().find(|reason| reason.kind == CauseKind::TooSmall) {
        let others = match kept {
            0 => String::new(),
            1 => "; one candidate here was kept, another thing or at another slope".to_owned(),
            n => format!("; {n} candidates here were kept, other things or at other slopes"),
        };
        let slope = slope_text(small.slope);
        return format!("What moves by {slope} here is too small for the scales that are searched{others}.");
    }
    if kept > 0 {
        let also = match fates[..near].iter().filter(|f| f.first_failed == Some(Test::Duplicate)).count() {
            0 => String::new(),
            1 => "; 1 duplicate on a blob nearby was removed".to_owned(),
            n => format!("; {n} duplicates on blobs nearby were removed"),
        };
        let several = format!("{kept} candidates here were kept{also}.");
        return if kept == 1 { format!("One candidate here was kept{also}.") } else { several };
    }
    if let Some(first) = here.first() {
        let who = match nearness.sigma {
            _ if here.len() == 1 => "The candidate here".to_owned(),
            Some(sigma) => format!("The candidate nearest to σ {} px", number(sigma, 1)),
            None => "The strongest candidate here".to_owned(),
        };
        let sigma = number(first.sigma, 1);
        // The gate's verdict has its own number, of the sample that it compares.
        if first.first_failed == Some(Test::NoiseGate) {
            return format!("Nothing was kept here. {who}, σ {sigma} px, is {}.", first.verdict);
        }
        let strength = match first.snr {
            snr if snr.is_finite() => format!("SNR {}", number(snr, 1)),
            _ => format!("|D| {:.2e}", first.value.abs()),
        };
        return format!("Nothing was kept here. {who} has {strength} at σ {sigma} px: {}.", first.verdict);
    }
    let nothing = format!("No candidate lies within {AT_PLACE_PX} px of this place");
    if let Some(first) = fates[..near].first() {
        let nearest = if nearness.sigma.is_some() { "The nearest in place and scale" } else { "The nearest" };
        let (px, sigma) = (number(nearness.distance(first), 1), number(first.sigma, 1));
        return format!("{nothing}. {nearest} is {px} px away, with σ {sigma} px: {}.", first.verdict);
    }
    if !fates.is_empty() {
        let reach = if fates.len() == 1 { "reaches" } else { "reach" };
        return format!("{nothing}; {} {reach} over it.", counted(fates.len(), "larger blob"));
    }
    let (column, row, strongest) = map.strongest();
    let scale = number(map.scales.get(row).map_or(0.0, |scale| scale.sigma), 1);
    let slope = slope_text(map.columns.get(column).copied().unwrap_or_default());
    let strength = if map.is_noiseless { format!("{strongest:+.1e}") } else { format!("{strongest:+.1} σ") };
    format!(
        "Nothing here is an extremum at any slope and scale. The strongest response is {strength}, at scale {scale} px and slope {slope}."
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::burst::Burst;
    use crate::detector::{DetectorParams, NoiseGate, SearchParams, SlopeGrid};
    use crate::plane::Plane;
    use crate::synth::random::Stream;

    /// A small blob at (80, 80), and a large one whose centre is 13 px away and which reaches over it.
    fn small_under_large(gate: NoiseGate) -> ProbeCache {
        let blobs = [(80.0, 80.0, 2.0, 0.1), (93.0, 80.0, 16.0, 0.2)];
        let mut stream = Stream::new(5, 0);
        let mut frame = |_| {
            Plane::from_fn(192, 160, |u, v| {
                let of = |(bu, bv, sigma, height): (f32, f32, f32, f32)| {
                    let (du, dv) = (u as f32 - bu, v as f32 - bv);
                    height * (-(du * du + dv * dv) / (2.0 * sigma * sigma)).exp()
                };
                0.3 + 0.01 * stream.normal() as f32 + blobs.into_iter().map(of).sum::<f32>()
            })
        };
        let burst = Burst::from_planes("blobs", (0..6).map(&mut frame).collect());
        let params = DetectorParams { slopes: SlopeGrid::line(-1.0..=1.0, 3), noise_gate: gate, ..Default::default() };
        ProbeCache::new(&burst, &SearchParams::from(params), &Monitor::default()).expect("valid parameters")
    }

    fn at(cache: &ProbeCache, place: [f32; 2], options: ProbeOptions) -> Probe {
        probe(cache, place, &options, &Monitor::default()).expect("inside")
    }

    #[test]
    fn a_place_without_a_candidate_stays_and_the_summary_says_what_is_near() {
        let cache = small_under_large(NoiseGate::Factor(1000.0));
        let place = [81.0, 80.5];
        let probe = at(&cache, place, ProbeOptions::default());
        let one = |du: f32, sigma| Fate { pos_image: [place[0] + du, place[1]], sigma, ..probe.fates[0].clone() };
        let (nearness, trail) = (Nearness { place, sigma: None, slopes: Vec::new() }, &cache.trail);
        let mut fates = [one(30.0, 20.0), one(5.0, 12.0), one(7.0, 4.0), one(4.0, 2.0)];
        assert_eq!(nearness.sort(trail, &mut fates), 2);
        assert_eq!(fates.each_ref().map(|fate| fate.sigma), [2.0, 4.0, 12.0, 20.0]);
        let summary = |fates: &[Fate], near| summary_of(&nearness, (fates, near), &[], &probe.response);
        let text = summary(&fates, 2);
        let nothing = "No candidate lies within 3 px of this place";
        assert!(text.starts_with(&format!("{nothing}. The nearest is 4 px away, with σ 2 px: below")), "{text}");
        assert_eq!(summary(&fates[2..], 0), format!("{nothing}; 2 larger blobs reach over it."));
        let gated = summary(&[one(1.0, 2.0)], 1);
        assert!(gated.starts_with("Nothing was kept here. The candidate here, σ 2 px, is below the noise"), "{gated}");
        // The place is examined at the slope that is looked at, not at that of another place's candidate.
        let slope = Slope::new(-0.8, 0.0);
        let looked_at = Nearness { slopes: vec![slope], ..nearness.clone() };
        for (nearness, slope) in [(nearness, Slope::default()), (looked_at, slope)] {
            let subject = subject(trail, &nearness, (&fates, &[]), ProbeSubject::Best).expect("valid");
            assert_eq!((subject.fate, subject.pos_image, subject.level), (None, place, fates[0].level));
            assert_eq!(subject.slope, slope);
        }
    }
}
