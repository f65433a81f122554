//! The studies of methods as figures: self-contained SVG, for light and dark pages, readable without colour. Methods
//! differ in colour (the palette of M. Okabe and K. Ito, which colour-blind readers can tell apart) *and* in dashes.
//!
//! Of a chart study the ROC curves, one panel for each signal-to-noise ratio: false features to the right, discs
//! found upwards. A grey line marks where the requested share of the detections is false: the numbers of the table
//! are read near it. The dot at the end of a curve marks the method's default threshold. Of a study over the number
//! of frames the discs found and the false features.

use super::chart::{ChartReport, ChartRow, MethodReport};
use super::frames::FramesReport;
use super::frames_of_burst::{BurstFramesReport, BurstFramesRow};
use super::methods::BurstMethod;
use super::statistics::Mean;
use burstscope_core::export::sheet::{Anchor, Area, BLUE, FAINT, GREEN, RED, Sheet};
use burstscope_core::export::{Plot, Series, SeriesPoint, range_from_zero};

/// Line style of a method: colour, dashes (empty for solid) and width in pixels.
pub fn method_line(method: BurstMethod) -> (&'static str, &'static str, f64) {
    match method {
        BurstMethod::SiftFrame => ("#666666", "1.5 4", 2.0),
        BurstMethod::SiftMean => ("#d55e00", "9 3 2 3", 2.0),
        BurstMethod::SiftMerge => ("#cc79a7", "5 3", 2.0),
        BurstMethod::Buff1d => ("#0072b2", "", 2.4),
        BurstMethod::Buff2d => ("#007a58", "7 4", 2.4),
        BurstMethod::BuffAuto => ("#5b4bb5", "10 3", 2.4),
    }
}

/// A method's line with its points.
pub(super) fn method_series(method: BurstMethod, points: Vec<SeriesPoint>) -> Series {
    let (colour, dashes, width) = method_line(method);
    Series { label: method.label().to_owned(), colour, dashes, width, points }
}

/// Width and height of a panel's plot, pixels.
const PLOT: (f64, f64) = (270.0, 270.0);
/// Margins left of a panel's plot (for its labels) and right of it, pixels.
const SIDES: (f64, f64) = (58.0, 14.0);
/// Margins above the plots (caption, legend, the panels' titles) and below (axis labels), pixels.
const ABOVE: f64 = 92.0;
const BELOW: f64 = 52.0;

/// The figure as an SVG document.
pub fn roc_svg(report: &ChartReport) -> String {
    let panel_width = SIDES.0 + PLOT.0 + SIDES.1;
    // A single panel is as wide as more than two, so that caption and legend fit.
    let mut sheet = Sheet::new(panel_width * (report.rows.len() as f64).max(2.2), "Discs found against false features");
    draw_header(&mut sheet, report);
    for (index, row) in report.rows.iter().enumerate() {
        let (x, y) = (panel_width * index as f64 + SIDES.0, ABOVE);
        draw_panel(&mut sheet, report, row, Area { x, y, width: PLOT.0, height: PLOT.1 });
    }
    sheet.finish(ABOVE + PLOT.1 + BELOW)
}

fn draw_header(sheet: &mut Sheet, report: &ChartReport) {
    let chart = &report.chart;
    let charts =
        if report.setup.seeds == 1 { "one chart".to_owned() } else { format!("mean of {} charts", report.setup.seeds) };
    let caption = format!(
        "{} discs in {} frames of {}×{}, moving in {}; {charts}",
        chart.discs,
        chart.frames,
        chart.width,
        chart.height,
        if chart.motion == "2d" { "2D" } else { "1D" },
    );
    sheet.styled_text((SIDES.0, 24.0), 14.0, Anchor::Start, r#"font-weight="bold""#, &caption);
    let methods = report.rows.first().map_or(&[][..], |row| &row.methods);
    let series: Vec<Series> = methods.iter().map(|method| method_series(method.method, Vec::new())).collect();
    sheet.legend((SIDES.0, 44.0), f64::INFINITY, &series);
}

/// Values at the ends of a panel's axes: false features, discs found.
fn ranges(report: &ChartReport) -> [(f64, f64); 2] {
    let discs = report.chart.discs;
    [(0.0, discs.div_ceil(2).max(1) as f64), (0.0, discs.max(1) as f64)]
}

fn draw_panel(sheet: &mut Sheet, report: &ChartReport, row: &ChartRow, area: Area) {
    let [range_x, range_y] = ranges(report);
    let x_of = |count: f64| area.x + count / range_x.1 * area.width;
    let y_of = |count: f64| area.bottom() - count / range_y.1 * area.height;
    draw_share_line(sheet, report, area.right(), x_of, y_of);
    let snr = if row.snr.is_finite() { format!("SNR {}", row.snr) } else { "no noise".to_owned() };
    let series: Vec<Series> = row.methods.iter().map(curve).collect();
    let plot = Plot {
        title: &snr,
        label_x: "false features",
        label_y: &format!("discs found, of {}", report.chart.discs),
        range_x,
        range_y,
        has_dots: false,
        series: &series,
    };
    sheet.plot(area, &plot);
    for method in &row.methods {
        let end = (method.default_false_features.mean, method.default_true_positives.mean);
        if end.0 <= range_x.1 {
            let style = format!(r#"fill="{}" stroke="white""#, method_line(method.method).0);
            sheet.circle((x_of(end.0), y_of(end.1)), 3.6, &style);
        }
    }
}

/// Draws the line on which the requested share of the detections is false.
fn draw_share_line(
    sheet: &mut Sheet,
    report: &ChartReport,
    right: f64,
    x_of: impl Fn(f64) -> f64,
    y_of: impl Fn(f64) -> f64,
) {
    let share = report.setup.false_fraction;
    if !(share > 0.0 && share < 1.0) {
        return;
    }
    let [(_, most_false), (_, most_true)] = ranges(report);
    let false_at = |true_positives: f64| true_positives * share / (1.0 - share);
    let end = if false_at(most_true) <= most_false { most_true } else { most_false * (1.0 - share) / share };
    // The label stands at the foot of the line, which good curves do not reach.
    let foot = 0.07 * most_true;
    sheet.line((x_of(0.0), y_of(0.0)), (x_of(false_at(end)), y_of(end)), FAINT, "");
    let at = ((x_of(false_at(foot)) + 6.0).min(right - 60.0), y_of(foot) + 4.0);
    let label = format!("{} % false", (share * 1000.0).round() / 10.0);
    sheet.styled_text(at, 11.0, Anchor::Start, &format!(r#"fill="{FAINT}""#), &label);
}

/// A method's curve: discs found over false features.
fn curve(method: &MethodReport) -> Series {
    // No chart has more than this many; nothing was measured further right.
    let measured = method.charts.iter().map(|chart| chart.default_false_features).max().unwrap_or(0);
    let points = method.roc.iter().enumerate().take(measured + 1).map(|(count, &mean)| (count as f64, mean, None));
    method_series(method.method, points.collect())
}

const WIDTH: f64 = 880.0;
const LEFT: f64 = 70.0;

/// Discs found and false features over the number of frames, as an SVG document.
pub fn frames_svg(report: &FramesReport) -> String {
    let caption = format!(
        "SNR {}, {}; {} discs of {}×{} pixels, moving in {}",
        report.snr,
        if report.setup.seeds == 1 {
            "one chart each".to_owned()
        } else {
            format!("mean of {} charts each", report.setup.seeds)
        },
        report.chart.discs,
        report.chart.width,
        report.chart.height,
        report.chart.motion.to_uppercase(),
    );
    let series = |value: fn(&super::chart::MethodReport) -> Mean| -> Vec<Series> {
        let methods = report.rows.first().map_or(&[][..], |row| &row.methods);
        let line = |(index, method): (usize, &super::chart::MethodReport)| {
            let point = |row: &super::frames::FramesRow| {
                let value = value(&row.methods[index]);
                (row.frames as f64, value.mean, value.within_error())
            };
            method_series(method.method, report.rows.iter().map(point).collect())
        };
        methods.iter().enumerate().map(line).collect()
    };
    let found = series(|method| method.true_positives);
    let wrong = series(|method| method.default_false_features);
    let share = (report.setup.false_fraction * 1000.0).round() / 10.0;
    let discs = (0.0, report.chart.discs.max(1) as f64 * 1.03);
    let panels = [
        (format!("Discs found where {share} % are false"), "discs found", found, Some(discs)),
        ("False features at the default threshold".to_owned(), "false features", wrong, None),
    ];
    figure("The number of frames of a burst", &caption, panels)
}

/// Features, discs and matches of a burst over the number of frames, as an SVG document.
pub fn burst_frames_svg(report: &BurstFramesReport) -> String {
    let line = |label: &str, (colour, dashes), value: &dyn Fn(&BurstFramesRow) -> Option<usize>| {
        let point = |row: &BurstFramesRow| Some((row.frames as f64, value(row)? as f64, None));
        let points: Vec<_> = report.rows.iter().filter_map(point).collect();
        let is_known = !points.is_empty();
        is_known.then(|| Series { label: label.to_owned(), colour, dashes, width: 2.2, points })
    };
    let features: Vec<Series> = [
        line("confirmed by all frames", (BLUE, ""), &|row| Some(row.confirmed)),
        line("not confirmed", (RED, "7 4"), &|row| Some(row.unconfirmed)),
        line("discs found", (GREEN, "2 3"), &|row| row.discs_found),
        line("false", (FAINT, "9 3 2 3"), &|row| row.false_features),
    ]
    .into_iter()
    .flatten()
    .collect();
    let matches: Vec<Series> = [
        line("putative matches", (RED, "7 4"), &|row| row.matches.map(|m| m.putative)),
        line("inliers", (BLUE, ""), &|row| row.matches.and_then(|m| m.inliers)),
    ]
    .into_iter()
    .flatten()
    .collect();
    let caption = format!("{}: the middle frames as a burst", report.burst);
    let panel = |title: String, label, series: Vec<Series>| (title, label, series, None);
    let first = panel("Features of the middle frames".to_owned(), "features", features);
    match &report.second {
        None => figure("The number of frames of a burst", &caption, [first]),
        Some(second) => {
            let title = format!("Matches with as many frames of {second}");
            figure("The number of frames of a burst", &caption, [first, panel(title, "matches", matches)])
        }
    }
}

/// A panel: title, name of the vertical axis, lines, and its range.
type Panel = (String, &'static str, Vec<Series>, Option<(f64, f64)>);

fn figure<const N: usize>(title: &str, caption: &str, panels: [Panel; N]) -> String {
    let mut sheet = Sheet::new(WIDTH, title);
    sheet.styled_text((LEFT, 28.0), 15.0, Anchor::Start, r#"font-weight="bold""#, title);
    sheet.text((LEFT, 48.0), 12.0, Anchor::Start, caption);
    let room = (WIDTH - 24.0) / 2.0;
    // Panels with the same lines share a legend.
    let is_shared =
        panels.windows(2).all(|two| two[0].2.iter().map(|s| &s.label).eq(two[1].2.iter().map(|s| &s.label)));
    let mut top: f64 = 0.0;
    for (index, (_, _, series, _)) in panels.iter().enumerate() {
        let left = LEFT + room * index as f64;
        if index == 0 && is_shared {
            top = sheet.legend((left, 70.0), WIDTH - LEFT - 20.0, series);
        } else if !is_shared {
            top = top.max(sheet.legend((left, 70.0), room - LEFT, series));
        }
    }
    let mut end = 0.0;
    for (index, (title, label_y, series, range)) in panels.iter().enumerate() {
        let area = Area { x: LEFT + room * index as f64, y: top + 18.0, width: room - LEFT - 8.0, height: 280.0 };
        let counts = series.iter().flat_map(|s| &s.points).map(|p| p.0);
        let last = counts.fold(3.0, f64::max);
        let plot = Plot {
            title,
            label_x: "number of frames",
            label_y,
            range_x: (1.5, last + 0.5),
            range_y: range.unwrap_or_else(|| range_from_zero(series, 1.0)),
            has_dots: true,
            series,
        };
        sheet.plot(area, &plot);
        end = area.bottom() + 48.0;
    }
    sheet.finish(end)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_two_methods_look_alike_even_without_colour() {
        for a in BurstMethod::ALL {
            for b in BurstMethod::ALL {
                if a != b {
                    assert_ne!(method_line(a).0, method_line(b).0);
                    assert_ne!(method_line(a).1, method_line(b).1);
                }
            }
        }
    }
}
