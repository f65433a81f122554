//! Slope finder: finds the slopes that a burst needs from the burst alone. (The paper gives their range by hand.)
//!
//! Where the band-passed motion stack at a slope has power there are features. That power is a sum, over pairs of
//! frames, of their correlation at the shift that the slope gives them; without products of frames with themselves it
//! lacks their noise. `spectra` computes the correlations of small windows, `peak` finds a window's slope and the path
//! of the picture, and `evidence` chooses the slopes to search by windows of many places and sizes. `order` finds what
//! happened to the frames (`event`), `regularity` turns and growth. A histogram of features would be flat in the dark.

mod event;
mod evidence;
mod lags;
mod order;
mod peak;
mod regularity;
mod spectra;

pub use event::UniformTimes;
pub use evidence::SlopeEvidence;
pub use regularity::{MotionWarning, MotionWarningKind};

use super::params::{DetectorParams, Method, SearchParams, Slope, SlopeAxis, SlopeGrid, Slopes};
use crate::burst::{Burst, OpenOptions, Positions, TimesChoice};
use crate::detector::scale_space::ScaleSpace;
use crate::error::Result;
use crate::monitor::{Cancelled, Monitor, Stage};
use crate::plane::Plane;
use event::Event;
use evidence::{
    LINE_SLOPES, PLANE_SLOPES, Seen, Steps, confirmed, direction_deg, grid_for, is_clear, is_significant, look, turned,
};
use lags::{Lags, MAX_LAG};
use order::Blocks;
use peak::{Path, SearchTable, Track};
use serde::Serialize;
use spectra::{Fourier, SIDE};
use std::ops::Range;
use std::path::PathBuf;

/// Smear of the outermost frames, in pixels, below which two slopes are equal: about the σ of the finest features.
const SAME_SMEAR_PX: f64 = 1.9;
/// Distance from a uniform motion, in pixels, above which it smears the finest features.
const STRAIGHT_PX: f64 = 1.4;
/// Motion above which a burst is a film, as a part of the picture.
const FILM_PART: f64 = 1.0 / 3.0;
/// Motion of the picture from the first to the last frame, pixels, up to which it stands still.
const STILL_PX: f64 = 0.95;
/// Slope in standard deviations above which the motion is surely not 0.
const SURELY: f64 = 2.5;
/// Number of confirmed moving windows from which a mostly still picture counts as moving.
const MIN_MOVING: usize = 3;
/// Part (0 … 1) of what is seen below which slopes that hold no more are uncertain, and below which none are found.
pub(crate) const UNCERTAIN: f32 = 0.5;
const MIN_CONFIDENCE: f32 = 0.25;
/// Deviation from a uniform motion, pixels of the level, that is forgiven where the windows stand still.
const STILL_LEVEL_PX: f64 = 1.25;

/// Finds the slopes that the frames of `burst` used by `params` show, on the line in direction `direction_deg` (degrees
/// from +u towards +v) or anywhere in the plane; for views of a light field on a grid along the picture's axes.
///
/// Of `params` only the frames used, the first octave and the levels matter: they give the step, 2σ of the finest scale
/// over the time from first to last frame, or coarser for long ranges. Threads do not change the result, to the bit.
///
/// ```
/// use burstscope_core::detector::{SlopeVerdict, find_slopes};
/// use burstscope_core::{DetectorParams, Monitor, synth::demo_burst};
/// let finding = find_slopes(&demo_burst(), &DetectorParams::default(), None, &Monitor::default())?;
/// assert_eq!(finding.verdict, SlopeVerdict::Found);
/// assert!(finding.grid.is_plane(), "houses move sideways, and the lanterns rise");
/// # Ok::<(), burstscope_core::Cancelled>(())
/// ```
///
/// # Errors
/// [`Cancelled`] once `monitor` was cancelled.
pub fn find_slopes(
    burst: &Burst,
    params: &DetectorParams,
    direction_deg: Option<f32>,
    monitor: &Monitor,
) -> Result<SlopeFinding, Cancelled> {
    monitor.report(Stage::Slopes, 0.0);
    let used = burst.frames.get(params.used_frames(burst.len())).unwrap_or_default();
    let all: Vec<&Plane> = used.iter().map(|f| &**f).collect();
    if all.len() < 2 {
        let grid = SlopeGrid::single(Slope::default());
        return Ok(SlopeFinding { grid, verdict: SlopeVerdict::Still, ..SlopeFinding::default() });
    }
    let positions = burst.positions.part(params.used_frames(burst.len()));
    // A copy repeats the noise of the frame before, and would correlate as if nothing moved.
    let copies = event::copies(&all);
    let kept: Vec<usize> = (0..all.len()).filter(|t| !copies.contains(t)).collect();
    let frames: Vec<&Plane> = kept.iter().map(|t| all[*t]).collect();
    // With times of their own, frames are in their order and the gaps are known; views follow no time.
    let (is_even, are_views) = (positions.is_even(), positions.are_views());
    let positions = if is_even { Positions::even(kept.len()) } else { positions.of(&kept) };
    let direction_deg = direction_deg.or(are_views.then_some(0.0));
    let track = direction_deg.map_or(Track::Plane, |degrees| {
        let (sin, cos) = f64::from(degrees).to_radians().sin_cos();
        Track::Line([cos, sin])
    });
    let levels = spectra::levels_for(burst.size(), SIDE);
    let lags = Lags::of(&positions);
    let pyramids = spectra::pyramids(&frames, levels.clone(), monitor)?;
    let fourier = Fourier::of(pyramids.first().map_or(&[], Vec::as_slice));
    let (mut seen, mut table) = look((&pyramids, &lags), (levels.start, 0), track, &fourier, monitor)?;
    let whole = seen.wholes.first().filter(|_| !are_views);
    let shared = whole.map_or(0, |whole| peak::lags_of_shared_noise(whole, &lags, &fourier));
    // Shared noise peaks at shift 0 like a scene that stands still: look again without its lags.
    if shared > 0 {
        (seen, table) = look((&pyramids, &lags), (levels.start, shared), track, &fourier, monitor)?;
    }
    let steps = steps_of(params, &positions);
    let size = Size { gaps: positions.span(), pixels: burst.size() };
    let finding = conclude(&seen, steps, direction_deg, size);
    // Views follow no time, and shared noise hides the shifts of neighbours: neither has a path.
    let path = if are_views || shared > 0 { None } else { path_of(&seen, &lags, &fourier, levels.start) };
    let is_told = is_even && (event::MIN_FRAMES..=event::MAX_FRAMES).contains(&frames.len());
    let blocks = seen.blocks.first().filter(|_| is_told);
    let blocks = blocks.map(|blocks| Blocks::of(blocks, (&lags, shared), levels.start, &fourier));
    let event = blocks.and_then(|blocks| blocks.event());
    let uniform = (event.is_some() || is_even && !copies.is_empty())
        .then(|| UniformTimes::of(event.as_ref().unwrap_or(&Event::Nothing), &kept));
    let order = event.and_then(|event| event.warning_of(&kept));
    let still = finding.verdict == SlopeVerdict::Still && order.is_none();
    let is_irregular = order.is_some();
    let mut warnings = regularity::of_places(&seen.evidence, steps, size);
    warnings.extend(order.into_iter().chain(event::copies_warning(copies)));
    let deviation_of = |path: &Path, part: Range<usize>| {
        peak::distance_from_a_line(&path.way[part.clone()], positions.part(part).offsets())
    };
    let deviation_of_middle = |path: &Path| {
        let middle = |count: usize| (kept.len() - count) / 2..(kept.len() - count) / 2 + count;
        (0..=kept.len()).map(|count| if count < 2 { 0.0 } else { deviation_of(path, middle(count)) as f32 }).collect()
    };
    let is_whole = kept.len() == all.len();
    let deviation_of_middle = path.as_ref().filter(|_| is_whole).map(deviation_of_middle).unwrap_or_default();
    let deviation = path.map(|path| (deviation_of(&path, 0..kept.len()), path.limit(still)));
    monitor.report(Stage::Slopes, 1.0);
    // The grid of a crooked motion is still the best one, but no slope of it aligns all frames.
    let verdict = match finding.verdict {
        SlopeVerdict::Found | SlopeVerdict::Still
            if is_irregular || deviation.is_some_and(|(distance, limit)| distance > limit) =>
        {
            SlopeVerdict::NotStraight
        }
        // A large disparity between views is no reason to cut them.
        SlopeVerdict::Film if are_views => SlopeVerdict::Found,
        verdict => verdict,
    };
    let deviation_px = deviation.map(|(distance, _)| distance as f32);
    let spectrum = spectrum(&seen, &table, levels.start);
    Ok(SlopeFinding { verdict, deviation_px, deviation_of_middle, spectrum, warnings, uniform, ..finding })
}

/// Opens a burst as [`Burst::open_with`] does; [`TimesChoice::Found`]: in the order and at the times of uniform motion.
///
/// # Errors
/// Those of [`Burst::open_with`].
pub fn open_burst(inputs: &[PathBuf], options: &OpenOptions, monitor: &Monitor) -> Result<Burst> {
    if options.times != Some(TimesChoice::Found) {
        return Burst::open_with(inputs, options, monitor);
    }
    let mut burst = Burst::open_with(inputs, options, &monitor.part(0.0, 0.8))?;
    let finding = find_slopes(&burst, &DetectorParams::default(), None, &monitor.part(0.8, 0.2))?;
    let found = retimed(&burst, &finding, monitor)?;
    let told = match &found {
        Some(_) => format!("times found: {}; the frames are taken so", finding.irregularities()),
        None => "times found: nothing shows that the frames are not even".to_owned(),
    };
    burst = found.unwrap_or(burst);
    burst.taken.push(told);
    Ok(burst)
}

/// `burst` in the order and at the times that `finding` shows; `None` without any, or where they look no more even.
pub(crate) fn retimed(burst: &Burst, finding: &SlopeFinding, monitor: &Monitor) -> Result<Option<Burst>, Cancelled> {
    let times = |uniform: &UniformTimes| Some((uniform.frames.clone(), Positions::new(&uniform.times)?));
    let Some((frames, positions)) = finding.uniform.as_ref().and_then(times) else { return Ok(None) };
    let retimed = burst.clone().of_frames(&frames, positions);
    // The times are inferred: a second look confirms them before frames are exchanged.
    let after = find_slopes(&retimed, &DetectorParams::default(), None, &monitor.silent())?;
    let is_crooked = after.verdict == SlopeVerdict::NotStraight && after.deviation_px >= finding.deviation_px;
    let is_even = after.uniform.is_none() && after.verdict != SlopeVerdict::NothingSeen && !is_crooked;
    Ok(is_even.then_some(retimed))
}

fn steps_of(params: &DetectorParams, positions: &Positions) -> Steps {
    let gaps = positions.span().max(1.0);
    let space = ScaleSpace::of(params);
    Steps {
        search: 2.0 * space.sigma_image(space.first_octave, 0.0) / gaps,
        // Half of the lags of views are along the rows.
        same: 2.0 * SAME_SMEAR_PX / gaps.min(MAX_LAG as f64 / if positions.are_views() { 2.0 } else { 1.0 }),
    }
}

impl SlopeFinding {
    /// Evidence from which the grid for a search with `params` is chosen: clear, and certain by itself or confirmed.
    pub fn confirmed(&self, params: &DetectorParams, positions: &Positions) -> Vec<SlopeEvidence> {
        let steps = steps_of(params, &positions.part(params.used_frames(positions.len())));
        let clear: Vec<SlopeEvidence> = self.evidence.iter().filter(|e| is_clear(e, steps)).copied().collect();
        confirmed(&clear, steps)
    }

    /// Part (0 … 1) of all significant evidence, by its significance, whose slope a `grid` holds.
    pub fn agreement(&self, grid: &SlopeGrid, params: &DetectorParams, positions: &Positions) -> f32 {
        let significant: Vec<SlopeEvidence> = self.evidence.iter().filter(|e| is_significant(e)).copied().collect();
        agreement(&significant, grid, steps_of(params, positions))
    }

    /// Texts of the warnings, joined by semicolons; empty without any.
    pub fn irregularities(&self) -> String {
        self.warnings.iter().map(|warning| &warning.text[..]).collect::<Vec<_>>().join("; ")
    }

    /// One line of text: the verdict, the grid, the confidence, and the irregularities.
    pub fn summary(&self) -> String {
        let verdict = self.verdict_text();
        if self.warnings.is_empty() { verdict } else { format!("{verdict}; {}", self.irregularities()) }
    }

    /// The summary where a judgement of the slopes stands beside it, which says what happened to the frames.
    pub fn summary_beside_judgement(&self) -> String {
        if self.uniform.is_some() { self.verdict_text() } else { self.summary() }
    }

    fn verdict_text(&self) -> String {
        let (grid, percent) = (grid_text(&self.grid), 100.0 * self.confidence);
        match self.verdict {
            SlopeVerdict::Found if self.confidence < UNCERTAIN => {
                format!("uncertain: {grid}; only {percent:.0} % of what is seen agrees")
            }
            SlopeVerdict::Found => format!("found: {grid}; {percent:.0} % of what is seen agrees"),
            SlopeVerdict::Still => "nothing moves: slope 0".to_owned(),
            SlopeVerdict::NothingSeen => format!("nothing to be seen: {grid}"),
            // The irregularities are the reason.
            SlopeVerdict::NotStraight if !self.warnings.is_empty() => grid,
            SlopeVerdict::NotStraight => format!(
                "the motion is not straight (up to {:.1} px off): {grid}; use fewer frames",
                self.deviation_px.unwrap_or(0.0)
            ),
            SlopeVerdict::Film => format!(
                "the frames move by {:.0} px, more than a third of the picture: {grid}; cut the film into bursts",
                self.moved_px
            ),
        }
    }
}

/// Axis of slopes in direction `direction_deg` for a line that holds the confirmed `evidence`; `None` without any.
pub(crate) fn axis_through(
    evidence: &[SlopeEvidence],
    params: &DetectorParams,
    positions: &Positions,
    direction_deg: f32,
) -> Option<SlopeAxis> {
    let range = || evidence::ranges(evidence, f64::from(direction_deg)).0;
    (!evidence.is_empty()).then(|| evidence::axis(range(), steps_of(params, positions).search, LINE_SLOPES))
}

pub(crate) fn slopes_needed(axis: &SlopeAxis, params: &DetectorParams, positions: &Positions, is_plane: bool) -> usize {
    let most = if is_plane { PLANE_SLOPES } else { LINE_SLOPES };
    evidence::count([axis.min, axis.max].map(f64::from), steps_of(params, positions).search, most)
}

/// Parameters with which `burst` is searched, and the finding where slopes are found from it, which baselines do not.
///
/// # Errors
/// Parameters that make no sense for the burst, and cancellation once `monitor` was cancelled.
pub fn resolve(
    burst: &Burst,
    params: &SearchParams,
    monitor: &Monitor,
) -> Result<(DetectorParams, Option<SlopeFinding>)> {
    params.validate()?;
    let direction_deg = match params.slopes {
        Slopes::Auto { direction_deg } if params.method == Method::Buff => direction_deg,
        _ => return Ok((params.at_given(), None)),
    };
    // All parameters but the slopes are checked before the slopes are searched.
    let unmoved = params.at_given();
    unmoved.validate_for(&burst.positions, burst.size())?;
    let finding = find_slopes(burst, &unmoved, direction_deg, monitor)?;
    Ok((DetectorParams { slopes: finding.grid, ..unmoved }, Some(finding)))
}

#[derive(Clone, Copy)]
struct Size {
    /// Time from the first to the last frame, frame intervals.
    gaps: f64,
    pixels: (usize, usize),
}

fn conclude(seen: &Seen, steps: Steps, line_deg: Option<f32>, size: Size) -> SlopeFinding {
    let significant: Vec<SlopeEvidence> = seen.evidence.iter().filter(|e| is_significant(e)).copied().collect();
    let max = significant.iter().map(|e| e.significance).fold(0.0, f32::max);
    let clear: Vec<SlopeEvidence> = significant.iter().filter(|e| is_clear(e, steps)).copied().collect();
    let mut kept = confirmed(&clear, steps);
    // Beyond these slopes nearly all that is seen at mid-burst has left the picture at the burst's ends.
    let stays = |slope: f32, pixels: usize| f64::from(slope).abs() * 0.5 * size.gaps < 0.9 * pixels as f64;
    kept.retain(|e| stays(e.slope.u, size.pixels.0) && stays(e.slope.v, size.pixels.1));
    // Where hardly anything agrees chance has chosen.
    let sure = |grid: &SlopeGrid| agreement(&significant, grid, steps) >= MIN_CONFIDENCE;
    let Some(grid) = grid_for(&kept, steps, line_deg).filter(sure) else {
        return SlopeFinding { significance: max, evidence: seen.evidence.clone(), ..SlopeFinding::default() };
    };
    let still = stands_still(&kept, steps, size.gaps);
    let grid = if still { SlopeGrid::single(Slope::default()) } else { grid };
    let moved_px = typical(&kept, |e| f64::from(e.slope.magnitude())) * size.gaps;
    let part = typical(&kept, |e| {
        let (u, v) = (f64::from(e.slope.u).abs(), f64::from(e.slope.v).abs());
        (u / size.pixels.0 as f64).max(v / size.pixels.1 as f64)
    }) * size.gaps;
    SlopeFinding {
        verdict: match () {
            () if part > FILM_PART => SlopeVerdict::Film,
            () if still => SlopeVerdict::Still,
            () => SlopeVerdict::Found,
        },
        confidence: agreement(&significant, &grid, steps),
        significance: max,
        direction_deg: (!still).then(|| direction_deg(&kept) as f32),
        moved_px: moved_px as f32,
        evidence: seen.evidence.clone(),
        grid,
        ..SlopeFinding::default()
    }
}

/// Whether most evidence lies no farther from slope 0 than its uncertainty, and too little is surely farther.
fn stands_still(evidence: &[SlopeEvidence], steps: Steps, gaps: f64) -> bool {
    let still = STILL_PX / gaps;
    let middle = typical(evidence, |e| f64::from(e.slope.u)).hypot(typical(evidence, |e| f64::from(e.slope.v)));
    let beyond = |e: &SlopeEvidence, least: f64, uncertainties: f64| {
        f64::from(e.slope.magnitude()) > least.max(uncertainties * f64::from(e.uncertainty))
    };
    let may_move = typical(evidence, |e| f64::from(u8::from(beyond(e, still, 1.0)))) > 0.5;
    let surely: Vec<SlopeEvidence> =
        evidence.iter().filter(|e| beyond(e, still.max(0.5 * steps.search), SURELY)).copied().collect();
    middle <= still && !may_move && confirmed(&surely, steps).len() < MIN_MOVING
}

/// Median of a value over the evidence, weighted by significance; 0 without evidence.
fn typical(evidence: &[SlopeEvidence], value: impl Fn(&SlopeEvidence) -> f64) -> f64 {
    let mut values: Vec<(f64, f64)> = evidence.iter().map(|e| (value(e), f64::from(e.significance))).collect();
    values.sort_by(|a, b| a.0.total_cmp(&b.0));
    let half = 0.5 * values.iter().map(|v| v.1).sum::<f64>();
    let mut sum = 0.0;
    let reaches = |v: &&(f64, f64)| {
        sum += v.1;
        sum >= half
    };
    values.iter().find(reaches).map_or(0.0, |v| v.0)
}

/// Part of the significant evidence, by significance, whose slope the grid holds.
fn agreement(significant: &[SlopeEvidence], grid: &SlopeGrid, steps: Steps) -> f32 {
    let holds = |e: &&SlopeEvidence| {
        let around = (0.5 * steps.search).max(f64::from(e.uncertainty).min(steps.same));
        let [along, across] = turned(e.slope, f64::from(grid.direction_deg));
        let within = |x: f64, axis: &SlopeAxis| x > f64::from(axis.min) - around && x < f64::from(axis.max) + around;
        within(along, &grid.u) && within(across, &grid.v)
    };
    let sum = |evidence: &mut dyn Iterator<Item = &SlopeEvidence>| evidence.map(|e| e.significance).sum::<f32>();
    // An empty sum of floats is −0, which would be shown with its sign.
    (sum(&mut significant.iter().filter(holds)) + 0.0) / sum(&mut significant.iter()).max(f32::MIN_POSITIVE)
}

/// Path of the picture, image pixels, at the finest level that can measure it.
fn path_of(seen: &Seen, lags: &Lags, fourier: &Fourier, first_level: u32) -> Option<Path> {
    let mut levels = seen.wholes.iter().zip(first_level..);
    levels.find_map(|(whole, level)| {
        let Path { way, noise, .. } = peak::path(&whole.pairs, lags, fourier)?;
        let unit = f64::from(1u32 << level);
        Some(Path { way: way.iter().map(|x| x.map(|x| x * unit)).collect(), noise: noise * unit, pixel: unit })
    })
}

fn spectrum(seen: &Seen, table: &SearchTable, first_level: u32) -> SlopeSpectrum {
    let Some(whole) = seen.wholes.first() else {
        return SlopeSpectrum::default();
    };
    let unit = f64::from(1u32 << first_level);
    let fourier = Fourier::new();
    let planes = fourier.correlations(&whole.lags.products, &mut fourier.scratch(0));
    let slopes = table.slopes.iter().map(|s| Slope::new((s[0] * unit) as f32, (s[1] * unit) as f32)).collect();
    let significance = table.scores(&planes, &whole.lags.variance).into_iter().map(|s| s as f32).collect();
    SlopeSpectrum { slopes, significance }
}

/// Kind of motion that a burst shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum SlopeVerdict {
    /// Slopes were found, and `grid` spans them.
    Found,
    /// Nothing moves: a still tripod.
    Still,
    /// The frames have nothing significant in common; the grid is the usual one.
    #[default]
    NothingSeen,
    /// No slope aligns all frames. The finding's warnings name the reason where it is known.
    NotStraight,
    /// The frames move by more than a third of the picture: a film that should be cut into bursts.
    Film,
}

/// Power of the motion stack over slopes, for the whole image at the finest level used.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SlopeSpectrum {
    /// Slopes, pixels per frame.
    pub slopes: Vec<Slope>,
    /// For each slope, the power over its standard deviation if the frames had nothing in common.
    pub significance: Vec<f32>,
}

/// Slopes to search, and the evidence for them. By default nothing is seen.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct SlopeFinding {
    /// Grid to search; the default grid where nothing is seen.
    pub grid: SlopeGrid,
    /// Kind of motion, and so whether `grid` aligns all frames.
    pub verdict: SlopeVerdict,
    /// Part (0 … 1) of all significant evidence, by its significance, whose slope the grid holds; 0 without any.
    pub confidence: f32,
    /// Largest significance of a window, which counts from 6.5 if it is large, and from 11.5 if it is small.
    pub significance: f32,
    /// Direction in which most of the picture moves, degrees from +u towards +v, −180 … 180; `None` where nothing does.
    pub direction_deg: Option<f32>,
    /// Typical motion of the picture from the first to the last frame, pixels.
    pub moved_px: f32,
    /// Largest distance of the picture's path from a uniform motion, pixels; `None` where frames are too noisy.
    pub deviation_px: Option<f32>,
    /// Deviation of the middle 0, 1, 2, … frames alone, pixels; empty where it is not known.
    #[serde(skip)]
    pub deviation_of_middle: Vec<f32>,
    /// Irregularities of the motion: frames out of order, missing, late or copied, a picture that turns or grows.
    pub warnings: Vec<MotionWarning>,
    /// Order and times in which the motion is uniform, where the frames show that those they have are wrong.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub uniform: Option<UniformTimes>,
    /// Evidence of every window with any signal; [`Self::confirmed`] selects what `grid` comes from.
    #[serde(skip)]
    pub evidence: Vec<SlopeEvidence>,
    /// Power over slopes of the whole image; empty for a single frame.
    #[serde(skip)]
    pub spectrum: SlopeSpectrum,
}

/// Text of a grid for sentences, with the ends that options of commands take.
pub fn grid_text(grid: &SlopeGrid) -> String {
    let axis = |(second, SlopeAxis { min, max, count }): (bool, SlopeAxis)| {
        format!("{} {min} to {max} in {count} slopes", if second { "v" } else { "u" })
    };
    let turned = if grid.direction_deg == 0.0 { "" } else { &format!(", turned by {}°", grid.direction_deg) };
    let axes = grid.axes().map(axis).collect::<Vec<String>>().join(", ") + turned;
    let Slope { u, v } = grid.slope(0);
    if grid.len() == 1 { format!("slope {u}, {v}") } else { axes }.replace('-', "−")
}
