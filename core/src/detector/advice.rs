//! Advice on a detection with few or no features, or most of them at the slope limit: the reason, and a setting to
//! change.
//!
//! The tally counts what each test rejected, but a good detection rejects nearly everything too: most samples are
//! noise, and of every hundred above it most belong to the flank of some blob. So each test's share of rejected
//! candidates is compared with its usual one; the test that exceeds it most is to blame.

use super::feature::{Detection, Tally, Test};
use super::params::{DetectorParams, Method, ParamDoc, doc};
use crate::detector::params::slope_grid::{SlopeAxis, SlopeGrid};

/// Reason for a poor detection, and a setting to change.
#[derive(Debug, Clone, PartialEq)]
pub struct Advice {
    /// The reason: a clause without a capital at its start or a full stop at its end.
    pub problem: String,
    /// Parameter to change.
    pub parameter: ParamDoc,
    /// Its new value, as the command line takes it.
    pub value: String,
}

impl Advice {
    /// Sentence for the command line, which names the option.
    pub fn for_command(&self) -> String {
        format!("{}; try --{} {}", self.problem, self.parameter.name, self.value)
    }

    /// Sentence for the window, which names the parameter by its label.
    pub fn for_window(&self) -> String {
        format!("{}; try {} {}", capitalised(&self.problem), self.parameter.label, self.value)
    }
}

/// Fewer features than this in a million pixels are too few.
const LITTLE_PER_MEGAPIXEL: f64 = 50.0;
/// Fewer features than this are too few in an image of any size.
const LITTLE: usize = 8;
/// Number of features from which on the slope limit is mentioned.
const FEATURES_FOR_LIMIT: usize = 10;
/// The slope range is called too narrow if at least this share of all features lies at the limit,
const LIMIT_SHARE: f64 = 0.5;
/// and at least this many times the share of the grid's slopes that are on its rim, which is large for small grids.
const LIMIT_OVER_CHANCE: f64 = 1.4;
/// Minimum number of samples above both thresholds for one feature: one of 650 to 1000 became a keypoint wherever
/// [`usual_share`] was measured.
const SAMPLES_PER_FEATURE: u64 = 500;
/// A test that lets pass less than this fraction of its usual share is to blame.
const BLAMED_BELOW: f64 = 0.5;
/// Gate's share of rejected samples below which it had little noise to reject, because the peak threshold before it
/// took that.
const GATE_REJECTS_NOISE: f64 = 0.999;
/// Gate factor below which so much noise passes that lowering it further does not help.
const LOWEST_GATE: f32 = 4.0;

/// Explains why `detection`, found with `params` in images of `size` (columns, rows), has few or no features, or most
/// of them at the slope limit; `None` where it has enough, or where the parameters ask for few.
pub fn explain(detection: &Detection, params: &DetectorParams, size: (usize, usize)) -> Option<Advice> {
    let found = detection.features.len();
    let wanted = LITTLE.max((LITTLE_PER_MEGAPIXEL * 1e-6 * size.0 as f64 * size.1 as f64) as usize);
    if found >= wanted {
        return at_limit(detection);
    }
    if detection.tally.rejected_by(Test::MaxFeatures) > 0 {
        return None;
    }
    let what = match found {
        0 => "no feature was found".to_owned(),
        1 => "only 1 feature was found".to_owned(),
        _ => format!("only {found} features were found"),
    };
    little(&what, wanted as u64, &detection.tally, params, detection.noise_gate_factor)
}

/// Advice where most features lie at the slope limit.
fn at_limit(detection: &Detection) -> Option<Advice> {
    // The stronger half: a strong blob beyond the range also leaves weaker smears of itself at all other slopes.
    let (features, grid) = (&detection.features[..detection.features.len().div_ceil(2)], &detection.slopes);
    let share = |count: usize, of: usize| count as f64 / of.max(1) as f64;
    let count = features.iter().filter(|f| f.at_slope_limit).count();
    let rim = (0..grid.len()).filter(|&index| {
        let (i, j) = grid.coordinates(index);
        grid.on_rim(i, j)
    });
    let chance = share(rim.count(), grid.len());
    if detection.features.len() < FEATURES_FOR_LIMIT
        || share(count, features.len()) < LIMIT_SHARE.max(LIMIT_OVER_CHANCE * chance)
    {
        return None;
    }
    let coordinates = |index: usize| grid.coordinates(index);
    let at = |wanted: &dyn Fn(usize, usize) -> bool| {
        features.iter().filter(|f| matches!(coordinates(f.slope_index), (i, j) if wanted(i, j))).count()
    };
    let sides = [
        (doc::SLOPES_U, grid.u, -1.0, at(&|i, _| i == 0)),
        (doc::SLOPES_U, grid.u, 1.0, at(&|i, _| i + 1 == grid.u.count)),
        (doc::SLOPES_V, grid.v, -1.0, at(&|_, j| j == 0)),
        (doc::SLOPES_V, grid.v, 1.0, at(&|_, j| j + 1 == grid.v.count)),
    ];
    // Of equal counts the first side is taken.
    let (parameter, axis, side, there) =
        sides.into_iter().filter(|(_, axis, ..)| axis.count > 1).reduce(|a, b| if b.3 > a.3 { b } else { a })?;
    let end = if side < 0.0 { axis.min } else { axis.max };
    let problem = format!(
        "{count} of the {} strongest features lie at the limit of the slopes, {there} of them at {} {end} px/frame, so the range is probably too narrow",
        features.len(),
        if parameter == doc::SLOPES_U { "u" } else { "v" },
    );
    Some(Advice { problem, parameter, value: widened(axis, side < 0.0, side > 0.0).to_string() })
}

/// Widens the axis by half its width below its smallest slope, above its largest, or both, in whole steps.
fn widened(axis: SlopeAxis, below: bool, above: bool) -> SlopeAxis {
    let more = axis.count.saturating_sub(1).div_ceil(2).max(1);
    axis.with_more(more * usize::from(below), more * usize::from(above))
}

/// Usual share of the candidates that pass a test, in a detection that finds enough. Measured without a peak threshold
/// on a chart, the demo, two trajectories and two real scenes, all dark: they differ by a fifth at most, by a third for
/// slopes. `None` for the thresholds, which are judged apart, and for the maximum number of features.
fn usual_share(test: Test) -> Option<f64> {
    match test {
        Test::PeakThreshold | Test::NoiseGate | Test::MaxFeatures => None,
        Test::SpaceExtremum => Some(0.04),
        Test::ScaleExtremum => Some(0.09),
        Test::SlopeExtremum => Some(0.3),
        Test::Refinement => Some(0.97),
        Test::InterpolatedContrast | Test::Outside => Some(0.99),
        Test::Edge => Some(0.93),
        Test::Duplicate => Some(0.45),
    }
}

/// Advice where there are few or no features.
fn little(what: &str, wanted: u64, tally: &Tally, params: &DetectorParams, gate: f32) -> Option<Advice> {
    let advice = |problem: String, parameter: ParamDoc, value: String| Some(Advice { problem, parameter, value });
    if tally.samples == 0 {
        let problem = format!("{what}, because the image is too small for the searched octaves");
        return advice(problem, doc::FIRST_OCTAVE, (params.first_octave - 1).max(-1).to_string());
    }
    let took = |test: Test, reached: u64| {
        format!(
            "{what}: of {} samples {} were rejected as {}",
            grouped(reached),
            grouped(tally.rejected_by(test)),
            test.reason()
        )
    };
    let above_peak = tally.samples.saturating_sub(tally.rejected_by(Test::PeakThreshold));
    let above = above_peak.saturating_sub(tally.rejected_by(Test::NoiseGate));
    if above < SAMPLES_PER_FEATURE * wanted {
        let gated = tally.rejected_by(Test::NoiseGate) as f64 / above_peak.max(1) as f64;
        if params.peak_threshold > 0.0 && above_peak < tally.samples && gated < GATE_REJECTS_NOISE {
            let problem = took(Test::PeakThreshold, tally.samples);
            return advice(format!("{problem} of {}", params.peak_threshold), doc::PEAK_THRESHOLD, "0".to_owned());
        }
        let problem = format!("{} of {gate:.2} σ", took(Test::NoiseGate, above_peak));
        return match params.method {
            Method::Sift => advice(problem, doc::METHOD, Method::Buff.name().to_owned()),
            Method::Buff | Method::Merge if gate > LOWEST_GATE => {
                advice(problem, doc::NOISE_GATE, LOWEST_GATE.to_string())
            }
            Method::Buff => {
                let (parameter, axis) = wider_axis(&params.slopes);
                advice(problem, parameter, widened(axis, true, true).to_string())
            }
            Method::Merge => advice(problem, doc::METHOD, Method::Buff.name().to_owned()),
        };
    }
    let (test, reached) = to_blame(tally)?;
    let (parameter, value) = remedy(test, params)?;
    advice(took(test, reached), parameter, value)
}

/// The test after the thresholds whose share of rejections most exceeds the usual one, and how many candidates reached
/// it.
fn to_blame(tally: &Tally) -> Option<(Test, u64)> {
    let mut reached = tally.samples;
    let mut worst: Option<(f64, Test, u64)> = None;
    for test in Test::ALL {
        let passed = reached.saturating_sub(tally.rejected_by(test));
        if let Some(usual) = usual_share(test).filter(|_| reached > 0) {
            let over_usual = passed as f64 / reached as f64 / usual;
            if over_usual < BLAMED_BELOW && worst.is_none_or(|(min, ..)| over_usual < min) {
                worst = Some((over_usual, test, reached));
            }
        }
        reached = passed;
    }
    worst.map(|(_, test, reached)| (test, reached))
}

/// Setting to change where `test` rejected too much; `None` where none would help.
fn remedy(test: Test, params: &DetectorParams) -> Option<(ParamDoc, String)> {
    match test {
        Test::PeakThreshold | Test::InterpolatedContrast => {
            (params.peak_threshold > 0.0).then(|| (doc::PEAK_THRESHOLD, "0".to_owned()))
        }
        Test::NoiseGate => Some((doc::NOISE_GATE, LOWEST_GATE.to_string())),
        // More levels make neighbours more alike in scale, fewer make them differ; a candidate that moves away in the
        // refinement lies between two levels.
        Test::ScaleExtremum | Test::Refinement => {
            Some((doc::LEVELS, if params.levels > 3 { "3" } else { "4" }.to_owned()))
        }
        Test::SlopeExtremum => {
            let (parameter, axis) = wider_axis(&params.slopes);
            (axis.count > 3).then(|| (parameter, SlopeAxis { count: axis.count.div_ceil(2), ..axis }.to_string()))
        }
        Test::Edge => Some((doc::EDGE_THRESHOLD, (1.5 * params.edge_threshold).to_string())),
        Test::Outside => (params.first_octave > -1).then(|| (doc::FIRST_OCTAVE, (params.first_octave - 1).to_string())),
        Test::Duplicate => Some((doc::DISTINCT, "off".to_owned())),
        Test::SpaceExtremum | Test::MaxFeatures => None,
    }
}

/// The axis with more slopes, and its parameter.
fn wider_axis(grid: &SlopeGrid) -> (ParamDoc, SlopeAxis) {
    if grid.v.count > grid.u.count { (doc::SLOPES_V, grid.v) } else { (doc::SLOPES_U, grid.u) }
}

fn capitalised(text: &str) -> String {
    let mut chars = text.chars();
    chars.next().map_or_else(String::new, |first| first.to_uppercase().chain(chars).collect())
}

/// A count as text, with a space between groups of three digits: 12345678 becomes "12 345 678".
pub fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::with_capacity(digits.len() * 4 / 3);
    for (k, digit) in digits.chars().enumerate() {
        if k > 0 && (digits.len() - k).is_multiple_of(3) {
            text.push(' ');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests;
