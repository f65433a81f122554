//! The plots of a study's report: their titles and axes, and the points of every curve.
//!
//! The Lab draws these plots, and all files are written from them, so that all show the same numbers. A figure is for
//! light and dark pages, readable without colour: two plots side by side, under one legend where all have the same
//! curves. A method has one colour in all sets; sets after the first are thinner and dotted.

use super::accuracy::{AccuracyReport, AccuracyRow};
use super::chart::{ChartReport, ChartRow, MethodReport};
use super::frames_of_burst::{BurstFramesReport, BurstFramesRow};
use super::{methods::BurstMethod, motion_label, statistics::Mean};
use burstscope_core::export::sheet::{Anchor, Area, BLUE, Colour, Dashes, FAINT, Face, RED, SOLID, Sheet};
use burstscope_core::export::{
    CURVE_COLUMNS, Cell, Drawing, Figure, Plot, Series, SeriesPoint, Table, range_from_zero,
};

/// Colour and dashes of correct results, where curves are not of methods.
const GOOD: (Colour, Dashes) = (BLUE, SOLID);
/// Colour and dashes of wrong or unconfirmed results.
const BAD: (Colour, Dashes) = (RED, [7.0, 4.0, 0.0, 0.0]);
const SNR: &str = "SNR of one pixel in one frame";
const FRAMES: &str = "number of frames";

/// One plot of a report: axes with their units, and the curves.
#[derive(Debug, Clone, Default, PartialEq)]
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
    /// Row's value of all points, a ratio or a number of frames; `None` where each point has its own row, by its x.
    pub row: Option<f64>,
    /// The line, in the method's colour or one that no other curve of the plot has. Its spread is one standard error to
    /// both sides of a mean, or a median and 95 %; the dot of a ROC curve is the default threshold, a mean over charts.
    pub line: Series,
}

impl StudyCurve {
    pub(crate) fn plain(label: &str, style: (Colour, Dashes), points: Vec<SeriesPoint>) -> Self {
        Self { method: None, row: None, line: Series::new(label, style, LINE, points) }
    }

    fn of(method: BurstMethod, points: Vec<SeriesPoint>) -> Self {
        Self { method: Some(method), ..Self::plain(method.label(), method.line(), points) }
    }

    /// Value of the report's row that a point of the curve belongs to.
    pub fn row_value(&self, point: &SeriesPoint) -> f64 {
        self.row.unwrap_or(point.x)
    }
}

/// Plots of a study in the dark: ROC curves of the row `roc_row`, then discs found and false features over the rows.
pub fn chart_plots(report: &ChartReport, roc_row: usize) -> Vec<StudyPlot> {
    let mut plots = Vec::new();
    if let Some(row) = report.rows.get(roc_row) {
        let title = match report.snr {
            None => format!("ROC at {}", row.at.label()),
            Some(snr) => format!("ROC of {} at SNR {snr}", row.at.label()),
        };
        plots.push(roc_plot(row, title, report.chart.discs));
    }
    let (x_label, over) = if report.snr.is_none() { (SNR, "SNR") } else { (FRAMES, "frames") };
    let title = format!("Discs found, {} false, against {over}", percent(report.setup.false_fraction));
    let found = found_label(report.chart.discs);
    plots.push(against(&report.rows, title, x_label, found, |method| method.true_positives));
    plots.push(if report.snr.is_none() {
        let (title, label) = ("False features per disc, default threshold", "false features per disc");
        let per_disc = |method: &MethodReport| method.default_false_per_disc.unwrap_or(method.default_false_features);
        against(&report.rows, title.to_owned(), x_label, label.to_owned(), per_disc)
    } else {
        let (title, label) = ("False features at the default threshold", "false features");
        against(&report.rows, title.to_owned(), x_label, label.to_owned(), |method| method.default_false_features)
    });
    plots
}

/// Plots of the middle frames of a burst: features, those confirmed, and the matches with a second burst.
pub fn burst_frames_plots(report: &BurstFramesReport) -> Vec<StudyPlot> {
    let curve = |label: &str, line, value: &dyn Fn(&BurstFramesRow) -> Option<usize>| {
        let point =
            |row: &BurstFramesRow| Some(SeriesPoint { x: row.frames as f64, y: value(row)? as f64, spread: None });
        let points: Vec<SeriesPoint> = report.rows.iter().filter_map(point).collect();
        // Without a truth or a second burst there is nothing to draw: such curves, and their plots, are left out.
        (!points.is_empty()).then(|| StudyCurve::plain(label, line, points))
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

fn roc_plot(row: &ChartRow, title: String, discs: usize) -> StudyPlot {
    let curve = |method: &MethodReport| {
        // No chart has more false features than this; nothing was measured further right.
        let measured = method.charts.iter().map(|chart| chart.default_false_features).max().unwrap_or(0);
        let points = method.roc.iter().take(measured + 1).enumerate();
        let point = |(count, &y): (usize, &f64)| SeriesPoint { x: count as f64, y, spread: None };
        let mut curve = StudyCurve::of(method.method, points.map(point).collect());
        curve.row = Some(row.at.value());
        curve.line.dot = Some((method.default_false_features.mean, method.default_true_positives.mean));
        curve
    };
    let (y_label, curves) = (found_label(discs), row.methods.iter().map(curve).collect());
    StudyPlot { title, x_label: "false features", y_label, curves, ..StudyPlot::default() }
}

/// One number of every method against the value that varies from row to row.
fn against(
    rows: &[ChartRow],
    title: String,
    x_label: &'static str,
    y_label: String,
    number: impl Fn(&MethodReport) -> Mean,
) -> StudyPlot {
    let methods = rows.first().map_or(&[][..], |row| &row.methods);
    let curve = |(index, method): (usize, &MethodReport)| {
        let point = |row: &ChartRow| {
            let mean = number(&row.methods[index]);
            SeriesPoint { x: row.at.value(), y: mean.mean, spread: mean.within_error() }
        };
        let mut points: Vec<SeriesPoint> = rows.iter().map(point).collect();
        // Rows may be given in any order, but a line joins its points from left to right.
        points.sort_by(|a, b| a.x.total_cmp(&b.x));
        StudyCurve::of(method.method, points)
    };
    let curves = methods.iter().enumerate().map(curve).collect();
    StudyPlot { title, x_label, y_label, marks_points: true, spread: "bars: standard error", curves }
}

/// The plots of a study of accuracy: errors of position, scale and slope against the ratio, median and 95 %.
pub fn accuracy_plots(report: &AccuracyReport) -> Vec<StudyPlot> {
    let plot = |title: &str, y_label: &str, errors: &dyn Fn(&AccuracyRow) -> [f64; 2]| {
        let point = |row: &AccuracyRow| {
            let [median, most] = errors(row);
            SeriesPoint { x: row.snr, y: median, spread: Some([median, most]) }
        };
        let mut points: Vec<SeriesPoint> = report.rows.iter().map(point).collect();
        points.sort_by(|a, b| a.x.total_cmp(&b.x));
        let (title, y_label) = (title.to_owned(), y_label.to_owned());
        let curves = vec![StudyCurve::plain("median", GOOD, points)];
        StudyPlot { title, x_label: SNR, y_label, marks_points: true, spread: "bars: up to 95 %", curves }
    };
    vec![
        plot("Errors of place", "distance, px", &|row| row.distance),
        plot("Errors of scale", "|error|, %", &|row| {
            [100.0 * row.scale.median_magnitude, 100.0 * row.scale.magnitude_95]
        }),
        plot("Errors of slope", "distance, px/frame", &|row| row.slope_distance),
    ]
}

fn found_label(discs: usize) -> String {
    format!("discs found, of {discs}")
}

/// A share (0 … 1) as text in percent, with a decimal where it has one.
pub fn percent(share: f64) -> String {
    format!("{} %", (1000.0 * share).round() / 10.0)
}

/// All points of named sets of plots as a table `set,plot,curve,x,y,low,high`; no spread leaves `low`, `high` empty.
pub fn curves_table(sets: &[(String, Vec<StudyPlot>)]) -> Table {
    let mut rows = Vec::new();
    for (set, plots) in sets {
        for (plot, line) in plots.iter().flat_map(|plot| plot.curves.iter().map(move |curve| (plot, &curve.line))) {
            rows.extend(line.points.iter().map(|point| {
                let number = |x: f64| Cell::Number(x, 3);
                let [low, high] = point.spread.map_or([Cell::Missing, Cell::Missing], |ends| ends.map(number));
                let [set, plot, curve] = [set, &plot.title, &line.label].map(|text| Cell::Text(text.clone()));
                vec![set, plot, curve, number(point.x), number(point.y), low, high]
            }));
        }
    }
    Table::new("Curves of the studies", CURVE_COLUMNS, rows)
}

const WIDTH: f64 = 880.0;
/// Dashes of curves of sets after the first, and of fitted ones.
pub(crate) const DOTS: Dashes = [2.0, 3.0, 0.0, 0.0];
const LEFT: f64 = 70.0;
const HEIGHT: f64 = 280.0;
pub(crate) const LINE: f64 = 2.2;

/// ROC curves of a study in the dark as a figure, a plot for each ratio. A grey line marks the requested share of false
/// detections, a dot the method's default threshold. Several plots have letters from `first_letter` on, 0 for (a).
pub fn roc_figure(report: &ChartReport, first_letter: usize) -> Figure {
    let discs = report.chart.discs;
    let plot = |row: &ChartRow| {
        let title = if row.at.value().is_finite() { row.at.label() } else { "no noise".to_owned() };
        let mut plot = roc_plot(row, title, discs);
        plot.curves.extend(share_line(report));
        plot
    };
    let plots: Vec<StudyPlot> = report.rows.iter().map(plot).collect();
    let chart = &report.chart;
    let count = chart.uneven.count_and_span(chart.frames).0;
    let frames = format!("{discs} discs in {count} frames of {}×{}", chart.width, chart.height);
    let caption = format!("{frames}, moving in {}; {}", motion_label(chart.motion), charts(report.setup.seeds));
    figure("Discs found against false features", &caption, plots, first_letter)
}

/// The line on which the requested share of the detections is false; none for a share of 0 or 1.
fn share_line(report: &ChartReport) -> Option<StudyCurve> {
    let share = report.setup.false_fraction;
    let (most_found, most_false) = (report.chart.discs as f64, report.chart.discs.div_ceil(2) as f64);
    // The line ends at the rim of the plot: all discs found, or half as many false features as discs.
    let end = most_found.min(most_false * (1.0 - share) / share);
    let point = |y: f64| SeriesPoint { x: y * share / (1.0 - share), y, spread: None };
    let (label, points) = (format!("{} false", percent(share)), vec![point(0.0), point(end)]);
    (share > 0.0 && share < 1.0).then(|| StudyCurve::plain(&label, (FAINT, SOLID), points))
}

/// Discs found and false features over the number of frames as a figure.
pub fn frames_figure(report: &ChartReport) -> Figure {
    let chart = &report.chart;
    let discs = format!("{} discs of {}×{} pixels", chart.discs, chart.width, chart.height);
    let charts = charts(report.setup.seeds);
    let snr = report.snr.map_or_else(String::new, |snr| format!("SNR {snr}, "));
    let caption = format!("{snr}{charts} each; {discs}, moving in {}", motion_label(chart.motion));
    figure("The number of frames of a burst", &caption, chart_plots(report, usize::MAX), 0)
}

/// Features, discs and matches of a burst over the number of frames as a figure.
pub fn burst_frames_figure(report: &BurstFramesReport) -> Figure {
    let caption = format!("{}: the middle frames as a burst", report.burst);
    figure("The number of frames of a burst", &caption, burst_frames_plots(report), 0)
}

fn charts(seeds: u64) -> String {
    if seeds == 1 { "one chart".to_owned() } else { format!("mean of {seeds} charts") }
}

/// Title of a part of a figure with its letter: (a), (b), … for 0, 1, …
pub(crate) fn lettered(index: usize, title: &str) -> String {
    format!("({}) {title}", char::from(b'a' + (index % 26) as u8))
}

fn figure(title: &str, caption: &str, plots: Vec<StudyPlot>, first_letter: usize) -> Figure {
    let has_letters = plots.len() > 1 || first_letter > 0;
    let titled = |(index, plot): (usize, &StudyPlot)| {
        let title = if has_letters { lettered(first_letter + index, &plot.title) } else { plot.title.clone() };
        StudyPlot { title, ..plot.clone() }
    };
    let lettered: Vec<StudyPlot> = plots.iter().enumerate().map(titled).collect();
    let drawn_plots: Vec<_> = lettered.iter().map(|plot| (plot, series_of(plot, None))).collect();
    Figure { drawing: drawn(title, caption, &drawn_plots), table: curves_table(&[(caption.to_owned(), plots)]) }
}

/// All plots of named sets as a figure, those of one title laid over one another.
pub fn curves_figure(sets: &[(String, Vec<StudyPlot>)]) -> Figure {
    let mut plots: Vec<(&StudyPlot, Vec<Series>)> = Vec::new();
    for (index, (set, of_set)) in sets.iter().enumerate() {
        for plot in of_set {
            let series = series_of(plot, (index > 0).then_some(set.as_str()));
            match plots.iter_mut().find(|(first, _)| first.title == plot.title) {
                Some((_, all)) => all.extend(series),
                None => plots.push((plot, series)),
            }
        }
    }
    Figure { drawing: drawn("Studies of the detector", "", &plots), table: curves_table(sets) }
}

fn drawn(title: &str, caption: &str, plots: &[(&StudyPlot, Vec<Series>)]) -> Drawing {
    let mut sheet = Sheet::new(WIDTH, title);
    sheet.heading((LEFT, 28.0), 15.0, title);
    let mut top = 56.0;
    if !caption.is_empty() {
        sheet.text((LEFT, 48.0), 12.0, Anchor::Start, caption);
        top = 70.0;
    }
    let labels = |series: &[Series]| series.iter().map(|one| one.label.clone()).collect::<Vec<_>>();
    // Plots whose curves have equal names share a legend above them.
    let is_shared = plots.windows(2).all(|two| labels(&two[0].1) == labels(&two[1].1));
    if let Some((_, series)) = plots.first().filter(|_| is_shared) {
        top = sheet.legend((LEFT, top), WIDTH - LEFT - 20.0, series);
    }
    let room = (WIDTH - 24.0) / 2.0;
    for pair in plots.chunks(2) {
        // Legends of a pair come before its plots, so that both plots start below the taller legend.
        let mut below: f64 = top;
        for (column, (_, series)) in pair.iter().enumerate().filter(|_| !is_shared) {
            below = below.max(sheet.legend((LEFT + room * column as f64, top), room - LEFT, series));
        }
        for (column, (plot, series)) in pair.iter().enumerate() {
            let x = LEFT + room * column as f64;
            let area = Area { x, y: below + 18.0, width: room - LEFT - 8.0, height: HEIGHT };
            let ends = series.iter().flat_map(|s| &s.points).map(|point| point.x).filter(|x| x.is_finite());
            // A little room, so that the outermost points do not lie on the frame.
            let range_x = (1.03 * ends.clone().fold(0.0, f64::min), 1.03 * ends.fold(1e-6, f64::max));
            // Errors may be hundredths.
            let range_y = range_from_zero(series, 1e-6);
            let (title, label_x, label_y, has_dots) = (&*plot.title, plot.x_label, &*plot.y_label, plot.marks_points);
            sheet.plot(area, &Plot { title, label_x, label_y, range_x, range_y, has_dots, series });
            let has_dots = series.iter().any(|one| one.dot.is_some());
            let note = if has_dots { "dots: default threshold, mean of the charts" } else { plot.spread };
            sheet.styled_text((area.x, area.bottom() + 50.0), 11.0, Anchor::Start, (Face::Plain, FAINT), note);
        }
        top = below + HEIGHT + 78.0;
    }
    sheet.finish(top)
}

/// The lines of a plot; those of a set after the first, which has a name, are thinner and dotted, without their dots.
fn series_of(plot: &StudyPlot, set: Option<&str>) -> Vec<Series> {
    let line = |StudyCurve { line, .. }: &StudyCurve| match set {
        None => line.clone(),
        Some(set) => {
            Series { label: format!("{}, {set}", line.label), dashes: DOTS, width: 1.4, dot: None, ..line.clone() }
        }
    };
    plot.curves.iter().map(line).collect()
}
