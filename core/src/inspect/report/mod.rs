//! Answers written down: as text here, for commands and messages; as a figure in `figure`; all of a burst on
//! one page in `page`, and many bursts on one in `flight`.

mod figure;
mod flight;
mod page;

pub use figure::{probe_figure, spectrum_figure};
pub use flight::{BurstHealth, FlightRow, flight_page, flight_table, joined_text, worst_bursts};
pub use page::{BurstPage, Page};

use super::place::{Cause, Fate, Outcome, Probe, Rival, Shares, TestReport};
use super::result::{DecoyReport, FalseRate};
use super::slopes::{SlopeBar, Spectrum};
use super::words::{counted, number, sentence, slope_text, snr_text, value_text};
use crate::detector::{ParamChange, Test};
use std::fmt::Write;

const LISTED: usize = 12;
const BAR_WIDTH: f32 = 30.0;

/// The result of a probe as text; ends with an empty line. `name` is the burst's.
pub fn probe_text(probe: &Probe, name: &str) -> String {
    written(|text| write_probe(text, probe, name))
}

fn written(write: impl FnOnce(&mut String) -> std::fmt::Result) -> String {
    let mut text = String::new();
    write(&mut text).expect("writing into a string cannot fail");
    text
}

fn write_probe(out: &mut String, probe: &Probe, name: &str) -> std::fmt::Result {
    let [u, v] = probe.pos_image;
    writeln!(out, "{name} at ({}, {})", number(u, 1), number(v, 1))?;
    writeln!(out, "  {}", probe.summary)?;
    write_told(out, reasons(probe))?;
    if let Some(fate) = probe.subject_fate() {
        writeln!(out)?;
        write_fate(out, fate)?;
    }
    probe.outlook.iter().try_for_each(|outlook| writeln!(out, "    {}", outlook.sentence))?;
    write_told(out, doubts(probe))?;
    write_others(out, probe)?;
    writeln!(out)?;
    write_shares(out, &probe.shares)?;
    writeln!(out)
}

fn write_told(out: &mut String, told: Vec<(String, String)>) -> std::fmt::Result {
    for (words, option) in told {
        let option = if option.is_empty() { option } else { format!("\n    try {option}") };
        writeln!(out, "  {words}{option}")?;
    }
    Ok(())
}

/// Causes at the place, each with the option that mends it, which may be empty; so are those of [`doubts`].
fn reasons(probe: &Probe) -> Vec<(String, String)> {
    let option = |reason: &Cause| reason.change.as_ref().map_or_else(String::new, ParamChange::option);
    probe.reasons.iter().map(|reason| (sentence(&reason.sentence), option(reason))).collect()
}

/// Verdict on the subject, and the suspicions that it does not tell.
fn doubts(probe: &Probe) -> Vec<(String, String)> {
    let judged = probe.judged.as_ref();
    let mut told: Vec<(String, String)> =
        judged.iter().map(|judged| (format!("{}: {}", judged.verdict.clause(), judged.why), String::new())).collect();
    for suspicion in &probe.suspicions {
        let [what, _] = suspicion.kind.words();
        let option = suspicion.change.as_ref().map_or_else(String::new, ParamChange::option);
        match told.first_mut().filter(|_| judged.is_some_and(|judged| judged.why == suspicion.evidence)) {
            Some((_, of_verdict)) => *of_verdict = option,
            None => told.push((format!("{what}? {}", suspicion.evidence), option)),
        }
    }
    told
}

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
            let [u, v] = fate.pos_image.map(|x| number(x, 1));
            let (sigma, slope, snr) = (number(fate.sigma, 1), slope_text(fate.slope), fate.snr_text());
            writeln!(out, "  {u:>6} {v:>7} {sigma:>7} {slope:>14} {snr:>8} σ  {}", fate.verdict)?;
        }
    }
    // Grouped by the keypoint that covers them, in order of the strongest covered.
    let mut groups: Vec<(Rival, Vec<&Fate>)> = Vec::new();
    for fate in same {
        let Some(rival) = fate.report(Test::Duplicate).rival else { continue };
        match groups.iter_mut().find(|(other, _)| *other == rival) {
            Some((_, fates)) => fates.push(fate),
            None => groups.push((rival, vec![fate])),
        }
    }
    for (rival, fates) in groups.iter().take(LISTED) {
        let strongest = fates.iter().map(|f| f.snr).fold(0.0, f32::max);
        let (count, name, [u, v]) =
            (counted(fates.len(), "duplicate"), rival.name(), rival.pos_image.map(|x| number(x, 1)));
        let (sigma, slope, snr) = (number(rival.sigma, 1), slope_text(rival.slope), snr_text(strongest));
        writeln!(out, "  {count} of {name} at ({u}, {v}), σ {sigma} px, slope {slope}: the strongest has {snr} σ")?;
    }
    write_larger(out, probe)
}

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
    let [u, v] = fate.pos_image.map(|x| number(x, 1));
    let (sigma, slope) = (number(fate.sigma, 1), slope_text(fate.slope));
    let Fate { octave, level, value, sigma_d, .. } = fate;
    writeln!(
        out,
        "  candidate at ({u}, {v}), σ {sigma} px, slope {slope} px/frame (octave {octave}, level {level}): D {value:+.2e}, its noise {sigma_d:.2e}"
    )?;
    for report in &fate.tests {
        match report.outcome {
            Outcome::NotAsked if report.test == Test::SlopeExtremum => {
                writeln!(out, "    {}: {}", report.test.record().name, report.sentence())?;
            }
            Outcome::NotAsked => {}
            _ => {
                let [name, value, limit, margin, outcome] = test_cells(report, Some(report.test) == fate.first_failed);
                writeln!(out, "    {name:<32}{value:>9} {limit:<11}{margin:>8}  {outcome}")?;
            }
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

/// Name of the test, value, limit, margin and outcome.
fn test_cells(report: &TestReport, is_first_failed: bool) -> [String; 5] {
    let value = report.value.map_or_else(|| "–".to_owned(), value_text);
    let outcome = match report.outcome {
        Outcome::Passes => "passes",
        Outcome::Fails if is_first_failed => "FAILS",
        Outcome::Fails => "would fail too",
        Outcome::Unknown => "cannot be decided",
        Outcome::NotAsked => "",
    };
    [report.test.record().name.to_owned(), value, report.limit_text(), report.margin_text(), outcome.to_owned()]
}

fn write_shares(out: &mut String, shares: &Shares) -> std::fmt::Result {
    let (slope, sigma) = (slope_text(shares.slope), number(shares.sigma, 1));
    writeln!(out, "  each frame's response along slope {slope} (σ {sigma} px): {}", shares.meaning)?;
    let sign = if shares.evenness.mean < 0.0 { -1.0 } else { 1.0 };
    let max =
        shares.frames.iter().filter(|f| f.covers).map(|f| (sign * f.value).abs()).fold(f32::MIN_POSITIVE, f32::max);
    for frame in &shares.frames {
        if !frame.covers {
            writeln!(out, "    frame {:>3}  does not show the place", frame.frame)?;
            continue;
        }
        let bar = "#".repeat((BAR_WIDTH * (sign * frame.value).max(0.0) / max).round() as usize);
        writeln!(out, "    frame {:>3} {:>+10.2e} ± {:.1e}  {bar}", frame.frame, frame.value, frame.sigma_d)?;
    }
    Ok(())
}

const SLOPES_LISTED: usize = 25;

/// The spectrum as text; ends with an empty line. `name` is the burst's.
pub fn spectrum_text(spectrum: &Spectrum, name: &str) -> String {
    written(|text| write_spectrum(text, spectrum, name))
}

/// False rates by strength as text; ends with an empty line. `name` is the burst's.
pub fn decoys_text(report: &DecoyReport, name: &str) -> String {
    written(|text| write_decoys(text, report, name))
}

fn write_decoys(out: &mut String, report: &DecoyReport, name: &str) -> std::fmt::Result {
    let copies = if report.copies == 1 { "1 copy".to_owned() } else { format!("{} copies", report.copies) };
    writeln!(out, "{name}: {} frames, {copies} in other orders (seed {})", report.frames, report.seed)?;
    writeln!(out, "  SNR from  found here  in a copy  there for each here")?;
    for rate in &report.rates {
        let [from, found, in_a_copy, ratio] = decoy_cells(rate);
        writeln!(out, "  {from:>8} {found:>11} {in_a_copy:>10}  {ratio:>18}")?;
    }
    match report.doubt() {
        Some(doubt) => writeln!(out, "  {}\n", sentence(&doubt)),
        None => writeln!(out),
    }
}

/// Smallest SNR, number found here, mean number in a copy, and their ratio.
fn decoy_cells(rate: &FalseRate) -> [String; 4] {
    let from = if rate.snr > 0.0 { number(rate.snr, 1) } else { "any".to_owned() };
    let ratio = rate.rate.zip(rate.error);
    let ratio = ratio.map_or_else(|| "–".to_owned(), |(rate, error)| format!("{rate:.2} ± {error:.2}"));
    [from, rate.found.to_string(), format!("{:.1}", rate.mean_in_copies()), ratio]
}

/// Up to `most` slopes with features or evidence, in the order of the grid, and how many others there are.
fn shown_bars(spectrum: &Spectrum, most: usize) -> (Vec<&SlopeBar>, usize) {
    let mut shown: Vec<&SlopeBar> =
        spectrum.bars.iter().filter(|bar| bar.features > 0 || bar.evidence >= 0.005).collect();
    let hidden = shown.len().saturating_sub(most);
    if hidden > 0 {
        shown.sort_by(|a, b| b.features.cmp(&a.features).then(b.evidence.total_cmp(&a.evidence)));
        shown.truncate(most);
    }
    shown.sort_by(|a, b| (a.at[1], a.at[0]).cmp(&(b.at[1], b.at[0])));
    (shown, hidden)
}

/// Slope, number of features, evidence and coverage.
fn slope_cells(bar: &SlopeBar) -> [String; 4] {
    let features = if bar.is_searched { bar.features.to_string() } else { "–".to_owned() };
    let evidence = if bar.evidence > 0.0 { format!("{:.1} %", 100.0 * bar.evidence) } else { "–".to_owned() };
    [slope_text(bar.slope), features, evidence, format!("{:.0} %", 100.0 * bar.coverage)]
}

fn write_spectrum(out: &mut String, spectrum: &Spectrum, name: &str) -> std::fmt::Result {
    let cost = &spectrum.cost;
    let (features, slopes) = (counted(spectrum.features, "feature"), counted(cost.slopes, "slope"));
    let (frames, at_limit, secs) = (spectrum.frames, spectrum.at_limit, cost.search_secs);
    write!(out, "{name}: {features} at {slopes} in {frames} frames, {at_limit} of them at the limit")?;
    writeln!(out, "; searched in {secs:.2} s")?;
    writeln!(out, "  the frames show  {}", spectrum.finding.summary_beside_judgement())?;
    let max = spectrum.bars.iter().map(|bar| bar.features).max().unwrap_or(0).max(1);
    let (shown, hidden) = shown_bars(spectrum, SLOPES_LISTED);
    writeln!(out, "           slope  features  evidence  seen by all frames")?;
    for bar in shown {
        let place = match bar {
            _ if !bar.is_searched => " beyond",
            _ if bar.at_limit > 0 => &format!(" {} at the limit", bar.at_limit),
            _ => "",
        };
        let [slope, features, evidence, coverage] = slope_cells(bar);
        let marks = "#".repeat((bar.features * BAR_WIDTH as usize).div_ceil(max));
        writeln!(out, "  {slope:>14} {features:>9} {evidence:>9} {coverage:>9}  {marks}{place}")?;
    }
    if hidden > 0 {
        writeln!(out, "  and {} with less", counted(hidden, "more slope"))?;
    }
    if let Some(fits) = spectrum.judgement.as_ref().filter(|judgement| judgement.advice.is_none()) {
        writeln!(out, "  {}", fits.sentence)?;
    }
    let advice = spectrum.advice.iter().map(|advice| (format!("→ {}", advice.sentence), advice.options()));
    write_told(out, advice.collect())?;
    writeln!(out)
}
