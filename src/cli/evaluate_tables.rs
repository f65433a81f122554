//! Tables that `evaluate` prints for people.

use crate::evaluate::accuracy::{AccuracyReport, AccuracyRow, RangeCount};
use crate::evaluate::chart::{ChartReport, ChartSummary, MethodReport};
use crate::evaluate::frames::FramesReport;
use crate::evaluate::frames_of_burst::{BurstFramesReport, BurstFramesRow};
use crate::evaluate::pure_noise::{NoiseLevel, NoiseReport};
use crate::evaluate::statistics::Errors;
use crate::inspect::score::Ranking;
use crate::synth::RadiusLaw;
use std::fmt::{Result, Write};

pub(super) fn chart_table(report: &ChartReport) -> String {
    let mut text = String::new();
    // Writing into a string cannot fail, here and below.
    let _ = write_chart(&mut text, report);
    text
}

pub(super) fn frames_table(report: &FramesReport) -> String {
    let mut text = String::new();
    let _ = write_frames(&mut text, report);
    text
}

pub(super) fn burst_frames_table(report: &BurstFramesReport) -> String {
    let mut text = String::new();
    let _ = write_burst_frames(&mut text, report);
    text
}

/// Tables of the crowded charts, then of those with discs apart.
pub(super) fn accuracy_tables(crowded: &AccuracyReport, apart: Option<&AccuracyReport>) -> String {
    let mut text = String::new();
    let _ = write_accuracy(&mut text, crowded, apart);
    text
}

pub(super) fn noise_table(report: &NoiseReport) -> String {
    let mut text = String::new();
    let _ = write_noise(&mut text, report);
    text
}

/// `frames` is a number of frames, or a range of them; `each` names the setting that has `seeds` charts.
fn write_charts(
    out: &mut String,
    chart: &ChartSummary,
    (frames, each): (&str, &str),
    first_seed: u64,
    seeds: u64,
) -> Result {
    writeln!(
        out,
        "{} discs of radius {} to {} px{}, contrast {}, in {} frames of {}×{}, {} bits, slopes up to ±{} px/frame in {}",
        chart.discs,
        chart.radius[0],
        chart.radius[1],
        if chart.radius_law == RadiusLaw::Log { " (log-uniform)" } else { "" },
        chart.contrast,
        frames,
        chart.width,
        chart.height,
        chart.bits,
        chart.max_slope,
        chart.motion.to_uppercase()
    )?;
    if seeds == 1 {
        writeln!(out, "one chart for each {each}, seed {first_seed}")
    } else {
        writeln!(out, "{seeds} charts for each {each}, seeds {first_seed} to {}", first_seed.saturating_add(seeds - 1))
    }
}

fn write_chart(out: &mut String, report: &ChartReport) -> Result {
    let frames = report.chart.frames.to_string();
    write_charts(out, &report.chart, (&frames, "SNR"), report.setup.first_seed, report.setup.seeds)?;
    let rows: Vec<Row<'_>> = report.rows.iter().map(|row| (row.snr.to_string(), &row.methods[..])).collect();
    let judged = (report.chart.discs, report.setup.ranking, report.setup.false_fraction);
    write_found(out, judged, ("SNR", &rows))
}

fn write_frames(out: &mut String, report: &FramesReport) -> Result {
    let first = report.rows.first().map_or(report.chart.frames, |row| row.frames);
    let frames = match report.chart.frames {
        last if last == first => last.to_string(),
        last => format!("{first} to {last}"),
    };
    write_charts(out, &report.chart, (&frames, "number of frames"), report.setup.first_seed, report.setup.seeds)?;
    writeln!(out, "SNR {}", report.snr)?;
    let rows: Vec<Row<'_>> = report.rows.iter().map(|row| (row.frames.to_string(), &row.methods[..])).collect();
    let judged = (report.chart.discs, report.setup.ranking, report.setup.false_fraction);
    write_found(out, judged, ("frames", &rows))
}

/// Label of a row, and the methods in it.
type Row<'a> = (String, &'a [MethodReport]);

/// Writes the tables of discs found: `discs` is their number on a chart, `ranking` the score with the threshold, and
/// `false_fraction` the share of false detections there.
fn write_found(
    out: &mut String,
    (discs, ranking, false_fraction): (usize, Ranking, f64),
    rows: (&str, &[Row<'_>]),
) -> Result {
    writeln!(
        out,
        "\nDiscs found, of {discs}, at the threshold on {} where {} % of the detections are false (mean ± standard error)",
        ranking.name(),
        (false_fraction * 1000.0).round() / 10.0
    )?;
    write_columns(out, rows, |method| format!("{:.1}", method.true_positives))?;
    writeln!(out, "\nDiscs found + false features among all that was detected (means)")?;
    write_columns(out, rows, |method| {
        format!("{:.1} + {:.1}", method.default_true_positives.mean, method.default_false_features.mean)
    })?;
    writeln!(out, "\nFalse features a disc among all that was detected (mean)")?;
    write_columns(out, rows, |method| {
        method.default_false_per_disc.map_or_else(|| "–".into(), |n| format!("{:.2}", n.mean))
    })?;
    writeln!(out, "\nEstimated over true noise of a frame")?;
    write_columns(out, rows, |method| {
        method.noise_estimate_ratio.map_or_else(|| "–".into(), |r| format!("{:.3}", r.mean))
    })
}

fn write_columns(
    out: &mut String,
    (first, rows): (&str, &[Row<'_>]),
    cell: impl Fn(&MethodReport) -> String,
) -> Result {
    write!(out, "{first:>8}")?;
    for method in rows.first().map_or(&[][..], |(_, methods)| methods) {
        write!(out, "{:>18}", method.method.label())?;
    }
    writeln!(out)?;
    for (name, methods) in rows {
        write!(out, "{name:>8}")?;
        for method in *methods {
            write!(out, "{:>18}", cell(method))?;
        }
        writeln!(out)?;
    }
    Ok(())
}

fn write_burst_frames(out: &mut String, report: &BurstFramesReport) -> Result {
    let grid = report.detector.used_slopes();
    writeln!(
        out,
        "{}: the middle frames as a burst, searched at slopes u {} and v {} (min:max:count, px/frame)",
        report.burst, grid.u, grid.v
    )?;
    writeln!(out, "features of all frames: {} (orientations of one keypoint count once)", report.features)?;
    if let Some(discs) = report.discs {
        writeln!(out, "discs known: {discs}")?;
    }
    if let Some(second) = &report.second {
        writeln!(out, "matched with as many middle frames of {second}")?;
    }
    let or_dash = |count: Option<usize>| count.map_or_else(|| "–".to_owned(), |count| count.to_string());
    type Column = (&'static str, fn(&BurstFramesRow) -> Option<usize>);
    let columns: [Column; 7] = [
        ("features", |row| Some(row.features)),
        ("confirmed", |row| Some(row.confirmed)),
        ("not", |row| Some(row.unconfirmed)),
        ("discs", |row| row.discs_found),
        ("false", |row| row.false_features),
        ("putative", |row| row.matches.map(|m| m.putative)),
        ("inliers", |row| row.matches.and_then(|m| m.inliers)),
    ];
    let columns: Vec<Column> =
        columns.into_iter().filter(|(_, value)| report.rows.iter().any(|row| value(row).is_some())).collect();
    write!(out, "\n{:>8}", "frames")?;
    columns.iter().try_for_each(|(name, _)| write!(out, "{name:>11}"))?;
    writeln!(out)?;
    for row in &report.rows {
        write!(out, "{:>8}", row.frames)?;
        columns.iter().try_for_each(|(_, value)| write!(out, "{:>11}", or_dash(value(row))))?;
        writeln!(out)?;
    }
    Ok(())
}

fn write_accuracy(out: &mut String, crowded: &AccuracyReport, apart: Option<&AccuracyReport>) -> Result {
    let grid = crowded.detector.used_slopes();
    writeln!(out, "searched at slopes u {} and v {} (min:max:count, px/frame)", grid.u, grid.v)?;
    let titles = ["Crowded charts: neighbours draw features aside", "Charts of discs that stand apart in all frames"];
    for (title, report) in titles.into_iter().zip([Some(crowded), apart]) {
        let Some(report) = report else { continue };
        writeln!(out, "\n{title}")?;
        let frames = report.chart.frames.to_string();
        write_charts(out, &report.chart, (&frames, "SNR"), report.first_seed, report.seeds)?;
        for row in &report.rows {
            write_accuracy_row(out, row)?;
        }
    }
    writeln!(
        out,
        "\nErrors are those of found discs that are not on the rim of the slopes. Scales are compared with the σ at which a\n\
         difference of Gaussians answers a disc most strongly, not with r/√2."
    )
}

fn write_accuracy_row(out: &mut String, row: &AccuracyRow) -> Result {
    writeln!(out, "\nSNR {}", row.snr)?;
    let mut counts = |words: &str, count: RangeCount| {
        let RangeCount { discs, found, marked } = count;
        writeln!(out, "  {words:36}{discs:>6}, found {found:>5}, of these on the rim of the slopes {marked:>4}")
    };
    counts("discs within the range of slopes", row.within)?;
    counts("discs beyond the range", row.beyond)?;
    writeln!(out, "  {:24}{:>16}{:>12}{:>31}", "", "median |error|", "95 %", "mean ± standard error")?;
    // Of no disc there is no error.
    let or_dash = |x: f64| if x.is_nan() { "–".to_owned() } else { format!("{x:.4}") };
    let mut line = |words: &str, median: f64, max: f64, signed: String| {
        writeln!(out, "  {words:24}{:>16}{:>12}{signed:>31}", or_dash(median), or_dash(max))
    };
    let mut errors = |words: &str, e: &Errors, factor: f64| {
        let signed = match e.signed.standard_error {
            _ if e.count == 0 => "–".to_owned(),
            Some(error) => format!("{:+.4} ± {:.4}", e.signed.mean * factor, error * factor),
            None => format!("{:+.4}", e.signed.mean * factor),
        };
        line(words, e.median_magnitude * factor, e.magnitude_95 * factor, signed)
    };
    errors("place u, px", &row.u, 1.0)?;
    errors("place v, px", &row.v, 1.0)?;
    errors("scale, %", &row.scale, 100.0)?;
    errors("slope u, px/frame", &row.slope_u, 1.0)?;
    errors("slope v, px/frame", &row.slope_v, 1.0)?;
    line("distance, px", row.distance[0], row.distance[1], format!("of {} discs", row.u.count))?;
    let apart = format!("of {} discs that stand apart", row.apart);
    line("distance, px", row.distance_apart[0], row.distance_apart[1], apart)?;
    line("slope distance, px/frame", row.slope_distance[0], row.slope_distance[1], String::new())
}

fn write_noise(out: &mut String, report: &NoiseReport) -> Result {
    writeln!(
        out,
        "{} bursts of {} frames of {}×{} for each row, {:.1} Mpx of image, seeds from {}",
        report.bursts, report.frames, report.width, report.height, report.megapixels, report.first_seed
    )?;
    writeln!(
        out,
        "\nFalse features in a million pixels of the image (± standard error), how many there were, and most in a burst"
    )?;
    write!(out, "{:22}{:>8}{:>7}{:>6}", "noise", "sigma", "mean", "bits")?;
    let columns = report.rows.first().map_or(&[][..], |row| &row.searches);
    for search in columns {
        write!(out, "{:>30}", format!("{}, {} slopes", search.label, search.slopes))?;
    }
    writeln!(out)?;
    for row in &report.rows {
        let NoiseLevel { sigma, bits, case, mean } = row.level;
        write!(
            out,
            "{:22}{sigma:>8}{mean:>7}{:>6}",
            case.name(),
            bits.map_or("–".to_owned(), |bits| bits.to_string())
        )?;
        for search in &row.searches {
            let most = search.of_bursts.iter().max().unwrap_or(&0);
            let (rate, error, count) = (search.per_megapixel, search.standard_error, search.false_features);
            let cell = format!("{rate:.2} ± {error:.2} ({count}, {most})");
            write!(out, "{cell:>30}")?;
        }
        writeln!(out)?;
    }
    write!(out, "{:43}", "noise gate")?;
    for search in columns {
        write!(out, "{:>30}", format!("{:.2} σ", search.noise_gate_factor))?;
    }
    writeln!(out)
}
