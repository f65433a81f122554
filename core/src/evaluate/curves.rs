//! The plots of a study's report: their titles and axes, and the points of every curve.
//!
//! The Lab draws these plots, and its files are written from them, so that a figure, a table and the screen show the
//! same numbers.

use super::accuracy::{AccuracyReport, AccuracyRow};
use super::chart::{ChartReport, MethodReport};
use super::figure::method_line;
use super::frames::FramesReport;
use super::frames_of_burst::{BurstFramesReport, BurstFramesRow};
use super::methods::BurstMethod;
use super::statistics::Mean;
use crate::export::CURVE_COLUMNS;
use crate::export::sheet::{BLUE, RED};
use std::fmt::Write;

/// Colour and dashes of correct results, where curves are not of methods.
const GOOD: (&str, &str) = (BLUE, "");
/// Colour and dashes of wrong or unconfirmed results.
const BAD: (&str, &str) = (RED, "7 4");
/// Label of the axis of ratios.
const SNR: &str = "SNR of one pixel in one frame";
/// Label of the axis of numbers of frames.
const FRAMES: &str = "number of frames";

/// One plot.
#[derive(Debug, Clone, PartialEq)]
pub struct StudyPlot {
    /// Heading of the plot.
    pub title: String,
    /// Label of the horizontal axis, with its unit.
    pub x_label: &'static str,
    /// Label of the vertical axis, with its unit.
    pub y_label: String,
    /// Whether each point was measured separately and is marked; a ROC curve is one line through all thresholds.
    pub marks_points: bool,
    /// Meaning of the bars at the points; empty where there are none.
    pub spread: &'static str,
    /// The curves, in the order of the methods.
    pub curves: Vec<StudyCurve>,
}

/// One curve of a plot.
#[derive(Debug, Clone, PartialEq)]
pub struct StudyCurve {
    /// Method; `None` for the one search of a study of accuracy.
    pub method: Option<BurstMethod>,
    /// Name of the curve.
    pub label: String,
    /// Colour, as `#rrggbb`: that of the method, and otherwise one that no other curve of its plot has.
    pub colour: &'static str,
    /// Dashes in a figure, in SVG's form; empty for a solid line.
    pub dashes: &'static str,
    /// Points, from left to right.
    pub points: Vec<StudyCurvePoint>,
}

/// One point of a curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StudyCurvePoint {
    /// Horizontal coordinate.
    pub x: f64,
    /// Vertical coordinate.
    pub y: f64,
    /// Ends of the spread: one standard error to both sides of a mean, or a median and 95 %.
    pub spread: Option<[f64; 2]>,
    /// Value of the report's row that the point belongs to: a ratio, or a number of frames.
    pub row_value: f64,
}

impl StudyCurvePoint {
    fn of_mean(x: f64, mean: Mean) -> Self {
        let spread = mean.standard_error.map(|error| [mean.mean - error, mean.mean + error]);
        Self { x, y: mean.mean, spread, row_value: x }
    }
}

/// The plots of a study in the dark: the ROC curves at one ratio (the row `roc_row`), and the features and discs found
/// against the ratio.
pub fn chart_plots(report: &ChartReport, roc_row: usize) -> Vec<StudyPlot> {
    let rows: Vec<(f64, &[MethodReport])> = report.rows.iter().map(|row| (row.snr, &row.methods[..])).collect();
    let mut plots = Vec::new();
    if let Some(row) = report.rows.get(roc_row) {
        plots.push(roc_plot(&row.methods, row.snr, format!("ROC at SNR {}", row.snr), report.chart.discs));
    }
    let share = percent(report.setup.false_fraction);
    let title = format!("Discs found, {share} false, against SNR");
    plots.push(against(&rows, title, SNR, found_label(report.chart.discs), |method| method.true_positives));
    plots.push(against(
        &rows,
        "False features at the default threshold".to_owned(),
        SNR,
        "false features".to_owned(),
        |method| method.default_false_features,
    ));
    plots
}

/// The plots of a study over the number of frames: the ROC curves at one number (the row `roc_row`), and the features
/// and discs found against the number of frames.
pub fn frames_plots(report: &FramesReport, roc_row: usize) -> Vec<StudyPlot> {
    let rows: Vec<(f64, &[MethodReport])> =
        report.rows.iter().map(|row| (row.frames as f64, &row.methods[..])).collect();
    let mut plots = Vec::new();
    if let Some(row) = report.rows.get(roc_row) {
        let title = format!("ROC of {} frames at SNR {}", row.frames, report.snr);
        plots.push(roc_plot(&row.methods, row.frames as f64, title, report.chart.discs));
    }
    let title = format!("Discs found, {} false, against frames", percent(report.setup.false_fraction));
    plots.push(against(&rows, title, FRAMES, found_label(report.chart.discs), |method| method.true_positives));
    let title = "False features at the default threshold".to_owned();
    plots.push(against(&rows, title, FRAMES, "false features".to_owned(), |method| method.default_false_features));
    plots
}

/// The plots of the middle frames of a burst: its features, the confirmed ones among them, and the matches with a
/// second burst.
pub fn burst_frames_plots(report: &BurstFramesReport) -> Vec<StudyPlot> {
    let curve = |label: &str, (colour, dashes), value: &dyn Fn(&BurstFramesRow) -> Option<usize>| {
        let point = |row: &BurstFramesRow| {
            let x = row.frames as f64;
            Some(StudyCurvePoint { x, y: value(row)? as f64, spread: None, row_value: x })
        };
        let points: Vec<StudyCurvePoint> = report.rows.iter().filter_map(point).collect();
        (!points.is_empty()).then(|| StudyCurve { method: None, label: label.to_owned(), colour, dashes, points })
    };
    let plot = |title: String, y_label: &str, curves: [Option<StudyCurve>; 2]| {
        let curves: Vec<StudyCurve> = curves.into_iter().flatten().collect();
        let (is_known, y_label) = (!curves.is_empty(), y_label.to_owned());
        is_known.then_some(StudyPlot { title, x_label: FRAMES, y_label, marks_points: true, spread: "", curves })
    };
    let features = [
        curve("confirmed by all frames", GOOD, &|row| Some(row.confirmed)),
        curve("not confirmed", BAD, &|row| Some(row.unconfirmed)),
    ];
    let truth = [curve("discs found", GOOD, &|row| row.discs_found), curve("false", BAD, &|row| row.false_features)];
    let matches = [
        curve("putative matches", BAD, &|row| row.matches.map(|m| m.putative)),
        curve("inliers", GOOD, &|row| row.matches.and_then(|m| m.inliers)),
    ];
    let with = report.second.as_deref().unwrap_or_default();
    let plots = [
        plot(format!("Features of the middle frames of {}", report.burst), "features", features),
        plot("Against the truth".to_owned(), "features", truth),
        plot(format!("Matches with as many frames of {with}"), "matches", matches),
    ];
    plots.into_iter().flatten().collect()
}

/// The ROC curves of one row's methods.
fn roc_plot(methods: &[MethodReport], row_value: f64, title: String, discs: usize) -> StudyPlot {
    let curve = |method: &MethodReport| {
        // No chart has more false features than this; nothing was measured further right.
        let measured = method.charts.iter().map(|chart| chart.default_false_features).max().unwrap_or(0);
        let points = method.roc.iter().take(measured + 1).enumerate();
        let point = |(count, &y): (usize, &f64)| StudyCurvePoint { x: count as f64, y, spread: None, row_value };
        curve_of(method.method, points.map(point).collect())
    };
    StudyPlot {
        title,
        x_label: "false features",
        y_label: found_label(discs),
        marks_points: false,
        spread: "",
        curves: methods.iter().map(curve).collect(),
    }
}

/// One number of every method against the value that varies from row to row.
fn against(
    rows: &[(f64, &[MethodReport])],
    title: String,
    x_label: &'static str,
    y_label: String,
    number: impl Fn(&MethodReport) -> Mean,
) -> StudyPlot {
    let methods = rows.first().map_or(&[][..], |(_, methods)| methods);
    let curve = |(index, method): (usize, &MethodReport)| {
        let point = |(x, methods): &(f64, &[MethodReport])| StudyCurvePoint::of_mean(*x, number(&methods[index]));
        let mut points: Vec<StudyCurvePoint> = rows.iter().map(point).collect();
        points.sort_by(|a, b| a.x.total_cmp(&b.x));
        curve_of(method.method, points)
    };
    let curves = methods.iter().enumerate().map(curve).collect();
    StudyPlot { title, x_label, y_label, marks_points: true, spread: "bars: standard error", curves }
}

/// The plots of a study of accuracy: errors of position, scale and slope against the ratio, median and 95 %.
pub fn accuracy_plots(report: &AccuracyReport) -> Vec<StudyPlot> {
    let plot = |title: &str, y_label: &str, errors: &dyn Fn(&AccuracyRow) -> [f64; 2]| {
        let point = |row: &AccuracyRow| {
            let [median, most] = errors(row);
            StudyCurvePoint { x: row.snr, y: median, spread: Some([median, most]), row_value: row.snr }
        };
        let mut points: Vec<StudyCurvePoint> = report.rows.iter().map(point).collect();
        points.sort_by(|a, b| a.x.total_cmp(&b.x));
        let (colour, dashes) = GOOD;
        let curve = StudyCurve { method: None, label: "median".to_owned(), colour, dashes, points };
        StudyPlot {
            title: title.to_owned(),
            x_label: SNR,
            y_label: y_label.to_owned(),
            marks_points: true,
            spread: "bars: up to 95 %",
            curves: vec![curve],
        }
    };
    vec![
        plot("Errors of place", "distance, px", &|row| row.distance),
        plot("Errors of scale", "|error|, %", &|row| {
            [100.0 * row.scale.median_magnitude, 100.0 * row.scale.magnitude_95]
        }),
        plot("Errors of slope", "distance, px/frame", &|row| row.slope_distance),
    ]
}

fn curve_of(method: BurstMethod, points: Vec<StudyCurvePoint>) -> StudyCurve {
    let (colour, dashes, _) = method_line(method);
    StudyCurve { method: Some(method), label: method.label().to_owned(), colour, dashes, points }
}

fn found_label(discs: usize) -> String {
    format!("discs found, of {discs}")
}

fn percent(share: f64) -> String {
    format!("{} %", (1000.0 * share).round() / 10.0)
}

/// All points of named sets of plots as a table: `set,plot,curve,x,y,low,high`, one row for each point; `low` and
/// `high` are empty where there is no spread.
pub fn curves_csv(sets: &[(String, Vec<StudyPlot>)]) -> String {
    let mut out = format!("{CURVE_COLUMNS}\n");
    let quoted = |text: &str| format!("\"{}\"", text.replace('"', "\"\""));
    for (set, plots) in sets {
        for plot in plots {
            for curve in &plot.curves {
                for point in &curve.points {
                    let bound = |index: usize| point.spread.map_or_else(String::new, |s| s[index].to_string());
                    // Writing into a string cannot fail.
                    let _ = writeln!(
                        out,
                        "{},{},{},{},{},{},{}",
                        quoted(set),
                        quoted(&plot.title),
                        quoted(&curve.label),
                        point.x,
                        point.y,
                        bound(0),
                        bound(1)
                    );
                }
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::ChartStudy;
    use crate::monitor::Monitor;
    use crate::synth::ChartParams;

    fn report() -> ChartReport {
        let chart = ChartParams { width: 160, height: 120, discs: 4, radius: 4.0..=9.0, ..ChartParams::default() };
        let study = ChartStudy {
            chart,
            snrs: vec![1.5, 0.8],
            seeds: 2,
            methods: vec![BurstMethod::SiftMean, BurstMethod::Buff1d],
            ..ChartStudy::default()
        };
        study.run(&Monitor::default()).expect("a report")
    }

    #[test]
    fn the_points_are_the_reports_numbers_from_left_to_right() {
        let report = report();
        let [roc, found, false_ones] = &chart_plots(&report, 1)[..] else { panic!("three plots") };
        assert_eq!(roc.title, "ROC at SNR 0.8");
        assert_eq!(roc.curves[1].points[0].y, report.rows[1].methods[1].roc[0]);
        let buff = &found.curves[1];
        assert_eq!(buff.label, "BuFF 1D");
        assert_eq!(buff.points.iter().map(|p| (p.x, p.row_value)).collect::<Vec<_>>(), [(0.8, 0.8), (1.5, 1.5)]);
        assert_eq!(buff.points[1].y, report.rows[0].methods[1].true_positives.mean);
        assert!(buff.points[1].spread.is_some_and(|[low, high]| low <= buff.points[1].y && high >= buff.points[1].y));
        assert_eq!(false_ones.curves.len(), 2);
    }

    #[test]
    fn a_table_has_a_row_for_each_point_and_quotes_names() {
        let plots = chart_plots(&report(), 0);
        let points: usize = plots.iter().flat_map(|plot| &plot.curves).map(|curve| curve.points.len()).sum();
        let csv = curves_csv(&[("gate \"4\", more".to_owned(), plots)]);
        assert_eq!(csv.lines().count(), 1 + points);
        for line in csv.lines().skip(1) {
            let numbers = line.strip_prefix("\"gate \"\"4\"\", more\",").expect("the name, quoted").rsplit(',');
            let numbers: Vec<&str> = numbers.take(4).collect();
            assert!(numbers[2..].iter().all(|number| number.parse::<f64>().is_ok()), "{line}");
        }
    }
}
