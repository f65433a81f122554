//! The probe: all explanations of one place of a burst, with the candidates near it, their fates, and a summary in
//! words.

use super::ProbeCache;
use super::fate::Fate;
use super::remedy::duplicate_remedy;
use super::response::{ResponseMap, response_map};
use super::shares::{Shares, Slice, across, direction_of, shares, slice};
use super::suspicion::{Suspicion, suspicions};
use crate::detector::scale_space::octave_pixel;
use crate::detector::search::extrema::{Candidate, Thresholds, own_slope_extrema};
use crate::detector::{Sample, Slope, Tally, Test, Trail};
use crate::inspect::telling::fate;
use crate::inspect::words::{number, slope_text};
use crate::monitor::{Cancelled, Monitor};
use crate::plane::tile::Region;
use serde::Serialize;

/// Reason why a place was not probed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ProbeError {
    /// The place is outside the picture.
    #[error("({u}, {v}) is outside the {width}×{height} image; give 0 to {} and 0 to {}", width - 1, height - 1)]
    Outside {
        /// Column, input pixels.
        u: f32,
        /// Row, input pixels.
        v: f32,
        /// Columns of the image.
        width: usize,
        /// Rows of the image.
        height: usize,
    },
    /// No feature has this index.
    #[error("there is no feature {index}: the detection has {count}")]
    NoFeature {
        /// Requested index.
        index: usize,
        /// Number of features.
        count: usize,
    },
    /// No such octave, level or slope was searched.
    #[error("there is no octave {octave}, level {level} and slope number {slope_index} in this search")]
    NoScale {
        /// Octave.
        octave: i32,
        /// Level.
        level: i32,
        /// Index of the slope in the grid.
        slope_index: usize,
    },
    /// The probe was cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// Subject that the probe examines more closely.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Wanted {
    /// The strongest kept candidate near the place, or else the candidate that came closest to being kept.
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
    /// A candidate near the place, by its sample; as [`Wanted::Best`] where no candidate near the place has this
    /// sample.
    Candidate(Sample),
}

/// Options of a probe.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProbeOptions {
    /// Maximum distance of candidates near the place, in their σ; at least two pixels of their octave.
    pub reach_sigmas: f32,
    /// Subject to examine more closely.
    pub wanted: Wanted,
    /// Pixels to each side in the slices.
    pub slice_half_px: usize,
}

impl Default for ProbeOptions {
    fn default() -> Self {
        Self { reach_sigmas: 2.0, wanted: Wanted::Best, slice_half_px: 60 }
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
    /// Fates of the candidates near it: kept ones first, then in order of how far they came and of their strength.
    pub fates: Vec<Fate>,
    /// Number of samples of D examined near the place, candidates or not.
    pub samples: usize,
    /// Subject that is examined more closely.
    pub subject: Subject,
    /// Response over slope and scale.
    pub response: ResponseMap,
    /// Response of each frame along the subject's motion.
    pub shares: Shares,
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
}

/// Explains what happened at `place` (u, v), input pixels of the mid-burst picture.
///
/// # Errors
/// See [`ProbeError`].
pub fn probe(
    cache: &ProbeCache,
    place: [f32; 2],
    options: &ProbeOptions,
    monitor: &Monitor,
) -> Result<Probe, ProbeError> {
    let trail = &cache.trail;
    let place = match options.wanted {
        Wanted::Feature(index) => {
            let features = &trail.detection().features;
            let feature = features.get(index).ok_or(ProbeError::NoFeature { index, count: features.len() })?;
            [feature.u, feature.v]
        }
        _ => place,
    };
    check_place(trail, place)?;
    let (mut fates, mut samples) = (Vec::new(), 0);
    for octave in trail.octaves() {
        samples += candidates_near(trail, place, octave, options.reach_sigmas, monitor, &mut fates)?;
    }
    if let Wanted::Feature(index) = options.wanted {
        add_feature(trail, index, monitor, &mut fates)?;
    }
    sort(&mut fates);
    let subject = subject(trail, place, &fates, options.wanted)?;
    if let Some(fate) = subject.fate.map(|index| &mut fates[index]).filter(|fate| fate.remedy.is_none()) {
        fate.remedy = duplicate_remedy(trail, fate);
    }
    let grid = trail.params().used_slopes();
    let scale = (subject.octave, subject.level);
    let response = response_map(trail, subject.pos_image, grid.coordinates(subject.slope_index), scale, monitor)?;
    let shares = shares(trail, scale, subject.pos_image, subject.slope, monitor)?;
    let suspicions = match subject.fate {
        Some(index) => suspicions(trail, &fates[index], &shares, monitor)?,
        None => Vec::new(),
    };
    let direction = direction_of(subject.slope);
    let slices = [direction, across(direction)].map(|d| slice(trail, subject.pos_image, d, options.slice_half_px));
    let summary = summary_of(&fates, &response);
    Ok(Probe { pos_image: place, fates, samples, subject, response, shares, suspicions, slices, summary })
}

fn check_place(trail: &Trail, [u, v]: [f32; 2]) -> Result<(), ProbeError> {
    let (width, height) = trail.size_image();
    let inside = |x: f32, n: usize| x >= -0.5 && x <= n as f32 - 0.5;
    if inside(u, width) && inside(v, height) { Ok(()) } else { Err(ProbeError::Outside { u, v, width, height }) }
}

fn subject(trail: &Trail, place: [f32; 2], fates: &[Fate], wanted: Wanted) -> Result<Subject, ProbeError> {
    let grid = trail.params().used_slopes();
    if let Wanted::Scale { octave, level, slope_index } = wanted {
        let levels = 0..trail.space().levels as i32;
        if !trail.octaves().contains(&octave) || !levels.contains(&level) || slope_index >= grid.len() {
            return Err(ProbeError::NoScale { octave, level, slope_index });
        }
        let fate = fates.iter().position(|f| (f.octave, f.level, f.slope_index) == (octave, level, slope_index));
        return Ok(Subject { fate, pos_image: place, slope: grid.slope(slope_index), slope_index, octave, level });
    }
    let by_sample = match wanted {
        Wanted::Candidate(sample) => fates.iter().position(|fate| fate.of_sample() == sample),
        _ => None,
    };
    let index = match wanted {
        _ if by_sample.is_some() => by_sample,
        Wanted::Feature(feature) => fates.iter().position(|fate| fate.features.contains(&feature)),
        // Kept candidates come first; then strong and near ones, with distances in their own scale.
        _ => {
            let weight = |index: usize| {
                let fate: &Fate = &fates[index];
                let apart = (fate.pos_image[0] - place[0]).hypot(fate.pos_image[1] - place[1]) / fate.sigma;
                let strength = if fate.snr.is_finite() { fate.snr } else { fate.value.abs() };
                (fate.is_kept(), strength * (-0.5 * apart * apart).exp())
            };
            (0..fates.len()).max_by(|&a, &b| {
                let (a, b) = (weight(a), weight(b));
                a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
            })
        }
    };
    let subject = match index.map(|index| (index, &fates[index])) {
        Some((index, fate)) => Subject {
            fate: Some(index),
            pos_image: fate.pos_image,
            slope: fate.slope,
            slope_index: fate.slope_index,
            octave: fate.octave,
            level: fate.level,
        },
        None => {
            let slope_index = (0..grid.len())
                .min_by(|&a, &b| grid.slope(a).magnitude().total_cmp(&grid.slope(b).magnitude()))
                .unwrap_or(0);
            let (octave, slope) = (trail.octaves().start, grid.slope(slope_index));
            Subject { fate: None, pos_image: place, slope, slope_index, octave, level: 0 }
        }
    };
    Ok(subject)
}

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

fn sort(fates: &mut [Fate]) {
    fates.sort_by(|a, b| {
        let stage = |fate: &Fate| fate.first_failed.map_or(Test::ALL.len(), |test| test as usize);
        let strength = |fate: &Fate| if fate.snr.is_finite() { fate.snr } else { fate.value.abs() };
        stage(b).cmp(&stage(a)).then(strength(b).total_cmp(&strength(a)))
    });
}

/// Appends the fates of an octave's candidates near a place; returns the number of samples examined.
fn candidates_near(
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

/// The summary, a sentence or two.
fn summary_of(fates: &[Fate], response: &ResponseMap) -> String {
    let kept = fates.iter().filter(|f| f.is_kept()).count();
    if kept > 0 {
        let covered = fates.iter().filter(|f| f.first_failed == Some(Test::Duplicate)).count();
        let also = match covered {
            0 => String::new(),
            1 => "; 1 weaker keypoint lies on the same blob".to_owned(),
            n => format!("; {n} weaker keypoints lie on the same blob"),
        };
        return match kept {
            1 => format!("One candidate here was kept{also}."),
            n => format!("{n} candidates here were kept{also}."),
        };
    }
    let (column, row, strongest) = response.strongest();
    let Some(best) = fates.iter().max_by(|a, b| a.snr.total_cmp(&b.snr)) else {
        let scale = response.scales.get(row).map_or(0.0, |scale| scale.sigma);
        let slope = response.columns.get(column).copied().unwrap_or_default();
        let strength = if response.is_noiseless { format!("{strongest:+.1e}") } else { format!("{strongest:+.1} σ") };
        return format!(
            "Nothing here is an extremum at any slope and scale. The strongest response is {strength}, at scale {} px and slope {}.",
            number(scale, 1),
            slope_text(slope)
        );
    };
    let strength = if response.is_noiseless {
        format!("The strongest candidate here has |D| {:.2e}", best.value.abs())
    } else if best.snr.is_finite() {
        format!("The strongest candidate here has {:.1} σ (the gate requires {:.2})", best.snr, response.gate)
    } else {
        format!("The strongest response here is {strongest:.1} σ")
    };
    format!("Nothing was kept here. {strength}: {}.", best.verdict)
}
