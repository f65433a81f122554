//! Explanations as text, for commands and messages.

use super::fate::{Outcome, Side, TestReport};
use super::shares::Shares;
use super::spectrum::{SlopeBar, Spectrum};
use super::words::{counted, number, slope_text};
use super::{Fate, Probe};
use crate::detector::Test;
use std::fmt::Write;

/// Name of a test in a table.
pub fn test_name(test: Test) -> &'static str {
    match test {
        Test::PeakThreshold => "peak threshold",
        Test::NoiseGate => "noise gate, σ",
        Test::SpaceExtremum => "extremum in space",
        Test::ScaleExtremum => "extremum in scale",
        Test::SlopeExtremum => "extremum in slope",
        Test::Refinement => "fit settles, samples",
        Test::InterpolatedContrast => "interpolated contrast",
        Test::Edge => "no edge, curvature ratio",
        Test::Outside => "inside, samples from the end",
        Test::Duplicate => "distinct, σ from another",
        Test::MaxFeatures => "among the strongest",
    }
}

/// A number of a test as short text, for any magnitude.
pub fn value_text(x: f64) -> String {
    match x.abs() {
        a if !a.is_finite() => "∞".to_owned(),
        a if a >= 1000.0 => number(x as f32, 0),
        a if a >= 0.01 || a == 0.0 => number(x as f32, 2),
        _ => format!("{x:.1e}").replace('-', "−"),
    }
}

/// A test and its outcome in words, with the numbers that were compared; a clause without a full stop.
pub fn test_sentence(report: &TestReport) -> String {
    let (value, limit) = (report.value.unwrap_or(f64::NAN), report.limit.unwrap_or(f64::NAN));
    let (has, needs) = (value_text(value), value_text(limit));
    let (passes, not_asked) = (report.outcome == Outcome::Passes, report.outcome == Outcome::NotAsked);
    let by = report.margin().filter(|margin| margin.is_finite()).map_or_else(String::new, |margin| {
        format!(": {:.0} % {}", 100.0 * margin.abs(), if margin < 0.0 { "too little" } else { "more" })
    });
    // A rival, whose response is the limit.
    let rival_is = |who: &str| match limit / value {
        times if times > 1.0 && times < 100.0 => {
            format!("{who} responds {} times as strongly", number(times as f32, 2))
        }
        _ => format!("{who} responds as strongly or more"),
    };
    match report.test {
        Test::MaxFeatures if not_asked => "the number of features is not limited".to_owned(),
        Test::Duplicate if not_asked && report.limit.is_some() => {
            "not tested: weaker than the strongest that are kept".to_owned()
        }
        Test::MaxFeatures if report.value.is_none() => "it became no keypoint".to_owned(),
        Test::MaxFeatures => format!("number {has} by strength; {needs} are kept"),
        _ if report.outcome == Outcome::Unknown => "unknown, because the fit did not settle".to_owned(),
        Test::PeakThreshold | Test::InterpolatedContrast if not_asked => "no peak threshold is set".to_owned(),
        Test::PeakThreshold => format!("|D| is {has}, {needs} is required{by}"),
        Test::InterpolatedContrast => format!("|D| of the fit is {has}, {needs} is required{by}"),
        Test::NoiseGate if not_asked => "no noise gate is set".to_owned(),
        Test::NoiseGate => format!("{has} σ of its noise, {needs} σ is required{by}"),
        Test::SpaceExtremum if passes => "all neighbours in the picture respond less".to_owned(),
        Test::SpaceExtremum => rival_is("a neighbour in the picture"),
        Test::ScaleExtremum if passes => "all neighbours at the next scales respond less".to_owned(),
        Test::ScaleExtremum => rival_is("a neighbour at the next scale"),
        Test::SlopeExtremum => match report.rival.map(|rival| format!("slope {}", slope_text(rival.slope))) {
            None => "there is no other slope".to_owned(),
            Some(who) if not_asked && limit > value => {
                format!("{}; not required, because each slope is searched for itself", rival_is(&who))
            }
            Some(_) if not_asked => "all other slopes respond less; not required".to_owned(),
            Some(_) if passes => "the slopes compared respond less".to_owned(),
            Some(who) => rival_is(&who),
        },
        Test::Refinement if report.value.is_none() => "the fit has no peak".to_owned(),
        Test::Refinement if passes => format!("the fit settles {has} samples away; {needs} are allowed"),
        Test::Refinement => format!("the fit does not settle: its peak is {has} samples away; {needs} are allowed"),
        Test::Edge if !value.is_finite() => "a saddle: bright along one direction and dark along the other".to_owned(),
        Test::Edge => format!("one curvature is {has} times the other; {needs} is allowed"),
        Test::Outside if passes => "the fit lies inside the image and the scales".to_owned(),
        Test::Outside => "the fit lies outside the image or the scales of its octave".to_owned(),
        Test::Duplicate if not_asked => "duplicates are kept".to_owned(),
        Test::Duplicate => match report.rival {
            None => "no other keypoint stands for this blob".to_owned(),
            Some(rival) => {
                let who =
                    rival.feature.map_or_else(|| "another keypoint".to_owned(), |index| format!("feature {index}"));
                format!("{who}, {has} σ away, stands for this blob; {needs} σ makes two")
            }
        },
    }
}

/// Maximum number of candidates in the text.
const LISTED: usize = 12;
/// Width of the longest bar, characters.
const BAR_WIDTH: f32 = 30.0;

/// The result of a probe as text; ends with an empty line. `name` is the burst's.
pub fn probe_text(probe: &Probe, name: &str) -> String {
    let mut text = String::new();
    // Writing into a string cannot fail.
    let _ = write_probe(&mut text, probe, name);
    text
}

fn write_probe(out: &mut String, probe: &Probe, name: &str) -> std::fmt::Result {
    let [u, v] = probe.pos_image;
    writeln!(out, "{name} at ({}, {})", number(u, 1), number(v, 1))?;
    writeln!(out, "  {}", probe.summary)?;
    if let Some(fate) = probe.subject_fate() {
        writeln!(out)?;
        write_fate(out, fate)?;
    }
    if let Some(outlook) = &probe.outlook {
        writeln!(out, "    {}", outlook.sentence)?;
    }
    if let Some(judged) = &probe.judged {
        writeln!(out, "  {}: {}", judged.verdict.clause(), judged.why)?;
    }
    for suspicion in &probe.suspicions {
        let what = match suspicion.kind {
            super::suspicion::Kind::Duplicate => "duplicate",
            super::suspicion::Kind::Ghost => "ghost",
            super::suspicion::Kind::AtLimit => "at the limit of the slopes",
            super::suspicion::Kind::Alias => "alias",
        };
        if probe.judged.as_ref().is_none_or(|judged| judged.why != suspicion.evidence) {
            writeln!(out, "  {what}? {}", suspicion.evidence)?;
        }
        if let Some(change) = &suspicion.change {
            writeln!(out, "    try {}", change.option())?;
        }
    }
    write_others(out, probe)?;
    writeln!(out)?;
    write_shares(out, &probe.shares)?;
    writeln!(out)
}

/// Writes the other candidates near the place: separate ones one by one, duplicates together; then the larger blobs.
fn write_others(out: &mut String, probe: &Probe) -> std::fmt::Result {
    let others = probe.near_fates().iter().enumerate().filter(|(index, _)| Some(*index) != probe.subject.fate);
    let (same, alone): (Vec<&Fate>, Vec<&Fate>) =
        others.map(|(_, fate)| fate).partition(|fate| fate.first_failed == Some(Test::Duplicate));
    if !alone.is_empty() {
        writeln!(out)?;
        let shown = alone.len().min(LISTED);
        let which = if shown < alone.len() { format!(", the first {shown}") } else { String::new() };
        writeln!(out, "  {} here{which}", counted(alone.len(), "other candidate"))?;
        writeln!(out, "       u       v    σ px          slope   response  what happened")?;
        for fate in &alone[..shown] {
            writeln!(
                out,
                "  {:>6} {:>7} {:>7} {:>14} {:>8} σ  {}",
                number(fate.pos_image[0], 1),
                number(fate.pos_image[1], 1),
                number(fate.sigma, 1),
                slope_text(fate.slope),
                if fate.snr.is_finite() { number(fate.snr, 1) } else { "∞".to_owned() },
                fate.verdict
            )?;
        }
    }
    // Grouped by the keypoint that covers them, in order of the strongest covered.
    let mut groups: Vec<(super::fate::Rival, Vec<&Fate>)> = Vec::new();
    for fate in same {
        let Some(rival) = fate.report(Test::Duplicate).rival else { continue };
        match groups.iter_mut().find(|(other, _)| *other == rival) {
            Some((_, fates)) => fates.push(fate),
            None => groups.push((rival, vec![fate])),
        }
    }
    for (rival, fates) in groups.iter().take(LISTED) {
        let who = rival.feature.map_or_else(|| "another keypoint".to_owned(), |index| format!("feature {index}"));
        let strongest = fates.iter().map(|f| f.snr).fold(0.0, f32::max);
        writeln!(
            out,
            "  {} of {who} at ({}, {}), σ {} px, slope {}: the strongest has {} σ",
            counted(fates.len(), "duplicate"),
            number(rival.pos_image[0], 1),
            number(rival.pos_image[1], 1),
            number(rival.sigma, 1),
            slope_text(rival.slope),
            if strongest.is_finite() { number(strongest, 1) } else { "∞".to_owned() }
        )?;
    }
    write_larger(out, probe)
}

/// Writes the larger blobs that only reach over the place, in one line.
fn write_larger(out: &mut String, probe: &Probe) -> std::fmt::Result {
    let larger = probe.larger_fates();
    if larger.is_empty() {
        return Ok(());
    }
    let sigmas = larger.iter().map(|fate| fate.sigma);
    let [min, max] = [sigmas.clone().fold(f32::INFINITY, f32::min), sigmas.fold(0.0, f32::max)];
    let range = if larger.len() == 1 { number(min, 1) } else { format!("{} to {}", number(min, 1), number(max, 1)) };
    let kept = larger.iter().filter(|fate| fate.is_kept()).count();
    writeln!(out, "  {} over this place, σ {range} px; {kept} kept", counted(larger.len(), "larger blob"))
}

fn write_fate(out: &mut String, fate: &Fate) -> std::fmt::Result {
    let [u, v] = fate.pos_image;
    writeln!(
        out,
        "  candidate at ({}, {}), σ {} px, slope {} px/frame (octave {}, level {}): D {:+.2e}, its noise {:.2e}",
        number(u, 1),
        number(v, 1),
        number(fate.sigma, 1),
        slope_text(fate.slope),
        fate.octave,
        fate.level,
        fate.value,
        fate.sigma_d
    )?;
    for report in &fate.tests {
        match report.outcome {
            Outcome::NotAsked if report.test == Test::SlopeExtremum => {
                writeln!(out, "    {}: {}", test_name(report.test), test_sentence(report))?;
            }
            Outcome::NotAsked => {}
            _ => writeln!(out, "    {}", report_line(report, Some(report.test) == fate.first_failed))?,
        }
    }
    writeln!(out, "  → {}", fate.verdict)?;
    if let Some(remedy) = &fate.remedy {
        writeln!(out, "    {}: try {}", remedy.sentence, remedy.change.option())?;
        if let Some(test) = remedy.then_fails {
            writeln!(out, "    (it would then be rejected as {})", test.reason())?;
        }
    }
    Ok(())
}

/// One test as a line: name, value, limit, margin, and outcome.
fn report_line(report: &TestReport, is_first_failed: bool) -> String {
    let value = report.value.map_or_else(|| "–".to_owned(), value_text);
    let sign = if report.side == Side::AtLeast { '≥' } else { '≤' };
    let limit = report.limit.map_or_else(String::new, |limit| format!("{sign} {}", value_text(limit)));
    let margin = match report.margin() {
        Some(margin) if margin.is_finite() && margin.abs() < 10.0 => {
            format!("{:+.0} %", 100.0 * margin).replace('-', "−")
        }
        _ => String::new(),
    };
    let outcome = match report.outcome {
        Outcome::Passes => "passes",
        Outcome::Fails if is_first_failed => "FAILS",
        Outcome::Fails => "would fail too",
        Outcome::Unknown => "cannot be decided",
        Outcome::NotAsked => "",
    };
    format!("{:<32}{value:>9} {limit:<11}{margin:>8}  {outcome}", test_name(report.test))
}

fn write_shares(out: &mut String, shares: &Shares) -> std::fmt::Result {
    writeln!(
        out,
        "  each frame's response along slope {} (σ {} px): {}",
        slope_text(shares.slope),
        number(shares.sigma, 1),
        shares.meaning
    )?;
    let sign = if shares.mean < 0.0 { -1.0 } else { 1.0 };
    let max =
        shares.frames.iter().filter(|f| f.covers).map(|f| (sign * f.value).abs()).fold(f32::MIN_POSITIVE, f32::max);
    for frame in &shares.frames {
        if !frame.covers {
            writeln!(out, "    frame {:>3}  does not show the place", frame.frame)?;
            continue;
        }
        let length = (BAR_WIDTH * (sign * frame.value).max(0.0) / max).round() as usize;
        writeln!(
            out,
            "    frame {:>3} {:>+10.2e} ± {:.1e}  {}",
            frame.frame,
            frame.value,
            frame.sigma_d,
            "#".repeat(length)
        )?;
    }
    Ok(())
}

/// Maximum number of slopes in the text.
const SLOPES_LISTED: usize = 25;

/// The spectrum as text; ends with an empty line. `name` is the burst's.
pub fn spectrum_text(spectrum: &Spectrum, name: &str) -> String {
    let mut text = String::new();
    // Writing into a string cannot fail.
    let _ = write_spectrum(&mut text, spectrum, name);
    text
}

fn write_spectrum(out: &mut String, spectrum: &Spectrum, name: &str) -> std::fmt::Result {
    let cost = &spectrum.cost;
    writeln!(
        out,
        "{name}: {} at {} in {} frames, {} of them at the limit; searched in {:.2} s",
        counted(spectrum.features, "feature"),
        counted(cost.slopes, "slope"),
        spectrum.frames,
        spectrum.at_limit,
        cost.search_secs
    )?;
    writeln!(out, "  the frames show  {}", spectrum.finding.summary())?;
    let max = spectrum.bars.iter().map(|bar| bar.features).max().unwrap_or(0).max(1);
    let mut shown: Vec<&SlopeBar> =
        spectrum.bars.iter().filter(|bar| bar.features > 0 || bar.evidence >= 0.005).collect();
    let hidden = shown.len().saturating_sub(SLOPES_LISTED);
    if hidden > 0 {
        shown.sort_by(|a, b| b.features.cmp(&a.features).then(b.evidence.total_cmp(&a.evidence)));
        shown.truncate(SLOPES_LISTED);
    }
    shown.sort_by(|a, b| (a.at[1], a.at[0]).cmp(&(b.at[1], b.at[0])));
    writeln!(out, "           slope  features  evidence  seen by all frames")?;
    for bar in &shown {
        let place = match bar {
            _ if !bar.is_searched => " beyond",
            _ if bar.at_limit > 0 => &format!(" {} at the limit", bar.at_limit),
            _ => "",
        };
        writeln!(
            out,
            "  {:>14} {:>9} {:>9} {:>7.0} %  {}{place}",
            slope_text(bar.slope),
            if bar.is_searched { bar.features.to_string() } else { "–".to_owned() },
            if bar.evidence > 0.0 { format!("{:.1} %", 100.0 * bar.evidence) } else { "–".to_owned() },
            100.0 * bar.coverage,
            "#".repeat((bar.features * BAR_WIDTH as usize).div_ceil(max)),
        )?;
    }
    if hidden > 0 {
        writeln!(out, "  and {} with less", counted(hidden, "more slope"))?;
    }
    for alias in &spectrum.aliases {
        let [u, v] = alias.places[0];
        writeln!(
            out,
            "  repeats itself  every {} px around ({}, {}){}",
            number(alias.period_px, 1),
            number(u, 0),
            number(v, 0),
            if alias.places.len() > 1 {
                format!(" and at {}", counted(alias.places.len() - 1, "more place"))
            } else {
                String::new()
            }
        )?;
    }
    if let Some(fits) = spectrum.judgement.as_ref().filter(|judgement| judgement.advice.is_none()) {
        writeln!(out, "  {}", fits.sentence)?;
    }
    for advice in &spectrum.advice {
        writeln!(out, "  → {}", advice.sentence)?;
        if !advice.changes.is_empty() {
            let options: Vec<String> = advice.changes.iter().map(|change| change.option()).collect();
            writeln!(out, "    try {}", options.join(" "))?;
        }
    }
    writeln!(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::detector::Slope;
    use crate::inspect::fate::Rival;

    #[test]
    fn tests_are_sentences_with_their_numbers() {
        let slope = Slope::new(1.5, 0.0);
        let rival = Rival { pos_image: [3.0, 4.0], sigma: 2.0, slope, value: 0.0036, feature: Some(9) };
        let report = |test, outcome, value: f64, limit: f64, side| TestReport {
            test,
            outcome,
            value: value.is_finite().then_some(value),
            limit: limit.is_finite().then_some(limit),
            side,
            unit: "",
            rival: Some(rival),
        };
        let (least, most, nan) = (Side::AtLeast, Side::AtMost, f64::NAN);
        let cases = [
            (
                report(Test::SlopeExtremum, Outcome::NotAsked, 0.002, 0.0036, least),
                "slope 1.5 responds 1.8 times as strongly; not required, because each slope is searched for itself",
            ),
            (
                report(Test::SlopeExtremum, Outcome::NotAsked, 0.0036, 0.002, least),
                "all other slopes respond less; not required",
            ),
            (
                report(Test::SlopeExtremum, Outcome::Fails, 0.002, 0.0036, least),
                "slope 1.5 responds 1.8 times as strongly",
            ),
            (
                report(Test::NoiseGate, Outcome::Fails, 3.28, 4.0, least),
                "3.28 σ of its noise, 4 σ is required: 18 % too little",
            ),
            (report(Test::NoiseGate, Outcome::Passes, 5.0, 4.0, least), "5 σ of its noise, 4 σ is required: 25 % more"),
            (report(Test::NoiseGate, Outcome::NotAsked, 5.0, 0.0, least), "no noise gate is set"),
            (
                report(Test::ScaleExtremum, Outcome::Fails, 0.002, 0.002, least),
                "a neighbour at the next scale responds as strongly or more",
            ),
            (
                report(Test::Edge, Outcome::Fails, 45.9, 12.0, most),
                "one curvature is 45.9 times the other; 12 is allowed",
            ),
            (report(Test::Edge, Outcome::Unknown, nan, 12.0, most), "unknown, because the fit did not settle"),
            (report(Test::Refinement, Outcome::Fails, nan, 1.5, most), "the fit has no peak"),
            (
                report(Test::Duplicate, Outcome::Fails, 0.4, 1.25, least),
                "feature 9, 0.4 σ away, stands for this blob; 1.25 σ makes two",
            ),
            (report(Test::MaxFeatures, Outcome::Fails, 501.0, 500.0, most), "number 501 by strength; 500 are kept"),
            (report(Test::MaxFeatures, Outcome::Unknown, nan, 500.0, most), "it became no keypoint"),
        ];
        for (report, sentence) in cases {
            assert_eq!(test_sentence(&report), sentence);
        }
        let alone = TestReport { rival: None, ..report(Test::SlopeExtremum, Outcome::NotAsked, 0.002, nan, least) };
        assert_eq!(test_sentence(&alone), "there is no other slope");
    }

    #[test]
    fn numbers_of_all_sizes_are_short() {
        let cases = [
            (4.643, "4.64"),
            (0.000_31, "3.1e−4"),
            (f64::INFINITY, "∞"),
            (123_456.0, "123456"),
            (0.0, "0"),
            (-2.5, "−2.5"),
        ];
        for (x, text) in cases {
            assert_eq!(value_text(x), text);
        }
    }
}
