//! The studies over the number of frames as figures: self-contained SVG, for light and dark pages, readable without
//! colour.

use super::figure::method_series;
use super::frames::FramesReport;
use super::frames_of_burst::{BurstFramesReport, BurstFramesRow};
use super::statistics::Mean;
use crate::export::sheet::{Anchor, Area, BLUE, FAINT, GREEN, RED, Sheet};
use crate::export::{Plot, Series, range_from_zero};

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
                let Mean { mean, standard_error } = value(&row.methods[index]);
                (row.frames as f64, mean, standard_error)
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
            range_y: range.unwrap_or_else(|| range_from_zero(series)),
            has_dots: true,
            series,
        };
        sheet.plot(area, &plot);
        end = area.bottom() + 48.0;
    }
    sheet.finish(end)
}
