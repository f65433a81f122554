//! Why a detection found nothing, or little, or most of it at the limit of the slopes, and the one setting to change.
//!
//! The tally says what each test rejected, but a good detection rejects nearly everything too: most samples are noise,
//! and of every hundred above it most belong to the flank of some blob. So each test is held against what it usually
//! takes of the candidates that reach it; the one that took most beyond that is to blame.

use super::feature::{Detection, Tally, Test};
use super::params::{DetectorParams, Method, ParamDoc, doc};
use crate::detector::params::slope_grid::{SlopeAxis, SlopeGrid};

/// What went wrong, in numbers, and the one setting to change.
#[derive(Debug, Clone, PartialEq)]
pub struct Advice {
    /// What happened: a clause without a capital at its start or a full stop at its end.
    pub problem: String,
    /// The parameter to change.
    pub parameter: ParamDoc,
    /// The value to give it, as the command line takes it.
    pub value: String,
}

impl Advice {
    /// The sentence for a command: names the option.
    pub fn for_command(&self) -> String {
        format!("{}; try --{} {}", self.problem, self.parameter.name, self.value)
    }

    /// The sentence for the window: names the parameter as the window does.
    pub fn for_window(&self) -> String {
        format!("{}; try {} {}", capitalised(&self.problem), self.parameter.label, self.value)
    }
}

/// Fewer features than this many in a million pixels are little.
const LITTLE_PER_MEGAPIXEL: f64 = 50.0;
/// Fewer features than this are little in an image of any size.
const LITTLE: usize = 8;
/// The slope limit is only spoken of when there are this many features at least.
const FEATURES_FOR_LIMIT: usize = 10;
/// At least this share of all features lies at the limit, when the range is said to be too narrow,
const LIMIT_SHARE: f64 = 0.5;
/// and at least this many times the share of the grid's slopes that are on its rim: many are where the grid is small.
const LIMIT_OVER_CHANCE: f64 = 1.4;
/// Samples above both thresholds that a feature costs, at least: of 650 to 1000 one became a keypoint wherever
/// [`usual_share`] was measured.
const SAMPLES_PER_FEATURE: u64 = 500;
/// A test that lets less than this part of its usual share pass is to blame.
const BLAMED_BELOW: f64 = 0.5;
/// A gate that rejects less than this share of what reaches it has little noise to reject: the peak threshold before it
/// took that already.
const GATE_REJECTS_NOISE: f64 = 0.999;
/// Below this factor the noise gate lets so much noise through that lowering it further is no help.
const LOWEST_GATE: f32 = 4.0;

/// Why `detection`, found with `params` in images of `size` (columns, rows), has nothing or little in it, or most of it
/// at the slope limit; `None` where it has enough, or where few were asked for.
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

/// The advice where most features lie at the slope limit.
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
    // The last of equals is never chosen by chance: sides are compared in their order.
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

/// The axis with half its width more below its least slope, above its largest, or both, in whole steps.
fn widened(axis: SlopeAxis, below: bool, above: bool) -> SlopeAxis {
    let more = axis.count.saturating_sub(1).div_ceil(2).max(1);
    axis.with_more(more * usize::from(below), more * usize::from(above))
}

/// The share of the candidates that pass a test in a detection that finds enough. Measured without a peak threshold on
/// a chart, the demo, two trajectories and two real scenes, all dark: they differ by a fifth at most, by a third for
/// slopes. `None` for the thresholds, which are judged by themselves, and for what only cuts a list.
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

/// The advice where there is nothing or little.
fn little(what: &str, wanted: u64, tally: &Tally, params: &DetectorParams, gate: f32) -> Option<Advice> {
    let advice = |problem: String, parameter: ParamDoc, value: String| Some(Advice { problem, parameter, value });
    if tally.samples == 0 {
        let problem = format!("{what}, because the image is too small for the octaves that are searched");
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

/// The test after the thresholds that took most beyond what it usually takes, and how many candidates reached it.
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

/// What to change when `test` took too much; `None` where no setting would help.
fn remedy(test: Test, params: &DetectorParams) -> Option<(ParamDoc, String)> {
    match test {
        Test::PeakThreshold | Test::InterpolatedContrast => {
            (params.peak_threshold > 0.0).then(|| (doc::PEAK_THRESHOLD, "0".to_owned()))
        }
        Test::NoiseGate => Some((doc::NOISE_GATE, LOWEST_GATE.to_string())),
        // More levels make neighbours more alike in scale, fewer tell them apart; what wanders off in the refinement
        // lies between two.
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
