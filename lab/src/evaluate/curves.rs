//! The plots of a study's report: their titles and axes, and the points of every curve.
//!
//! The Lab draws these plots, and all files are written from them, so that all show the same numbers. A figure is
//! self-contained SVG for light and dark pages, readable without colour: two plots side by side, under one legend where
//! all have the same curves. A method has one colour in all sets; sets after the first are thinner and dotted.

use super::accuracy::{AccuracyReport, AccuracyRow};
use super::chart::{ChartReport, ChartRow, MethodReport};
use super::frames_of_burst::{BurstFramesReport, BurstFramesRow};
use super::methods::BurstMethod;
use super::motion_label;
use super::statistics::Mean;
use burstscope_core::export::sheet::{Anchor, Area, BLUE, FAINT, RED, Sheet};
use burstscope_core::export::{CURVE_COLUMNS, Plot, Series, SeriesPoint, range_from_zero};

/// Colour and dashes of correct results, where curves are not of methods.
const GOOD: (&str, &str) = (BLUE, "");
/// Colour and dashes of wrong or unconfirmed results.
const BAD: (&str, &str) = (RED, "7 4");
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
    /// The line. Its colour is the method's, or one that no other curve of its plot has. Its spread is one standard
    /// error to both sides of a mean, or a median and 95 %. The dot of a ROC curve is the default threshold, the mean
    /// over the charts.
    pub line: Series,
}

impl StudyCurve {
    pub(crate) fn plain(label: &str, (colour, dashes): (&'static str, &'static str), points: Vec<SeriesPoint>) -> Self {
        let line = Series { label: label.to_owned(), colour, dashes, width: LINE, points, dot: None };
        Self { method: None, row: None, line }
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
        StudyPlot {
            title: title.to_owned(),
            x_label: SNR,
            y_label: y_label.to_owned(),
            marks_points: true,
            spread: "bars: up to 95 %",
            curves: vec![StudyCurve::plain("median", GOOD, points)],
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

fn found_label(discs: usize) -> String {
    format!("discs found, of {discs}")
}

/// A share (0 … 1) as text in percent, with a decimal where it has one.
pub fn percent(share: f64) -> String {
    format!("{} %", (1000.0 * share).round() / 10.0)
}

/// All points of named sets of plots as a table `set,plot,curve,x,y,low,high`; no spread leaves `low`, `high` empty.
pub fn curves_csv(sets: &[(String, Vec<StudyPlot>)]) -> String {
    let mut out = format!("{CURVE_COLUMNS}\n");
    // Names of bursts may hold commas and quotes.
    let quoted = |text: &str| format!("\"{}\"", text.replace('"', "\"\""));
    for (set, plots) in sets {
        for plot in plots {
            for line in plot.curves.iter().map(|curve| &curve.line) {
                for point in &line.points {
                    let bound = |index: usize| point.spread.map_or_else(String::new, |s| s[index].to_string());
                    out += &format!(
                        "{},{},{},{},{},{},{}\n",
                        quoted(set),
                        quoted(&plot.title),
                        quoted(&line.label),
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

const WIDTH: f64 = 880.0;
const LEFT: f64 = 70.0;
const HEIGHT: f64 = 280.0;
pub(crate) const LINE: f64 = 2.2;

/// ROC curves of a study in the dark as a figure, a plot for each ratio. A grey line marks the requested share of false
/// detections, a dot the method's default threshold. Several plots have letters from `first_letter` on, 0 for (a).
pub fn roc_svg(report: &ChartReport, first_letter: usize) -> String {
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
    figure("Discs found against false features", &caption, &plots, first_letter)
}

/// The line on which the requested share of the detections is false; none for a share of 0 or 1.
fn share_line(report: &ChartReport) -> Option<StudyCurve> {
    let share = report.setup.false_fraction;
    let (most_found, most_false) = (report.chart.discs as f64, report.chart.discs.div_ceil(2) as f64);
    // The line ends at the rim of the plot: all discs found, or half as many false features as discs.
    let end = most_found.min(most_false * (1.0 - share) / share);
    let point = |y: f64| SeriesPoint { x: y * share / (1.0 - share), y, spread: None };
    let (label, points) = (format!("{} false", percent(share)), vec![point(0.0), point(end)]);
    (share > 0.0 && share < 1.0).then(|| StudyCurve::plain(&label, (FAINT, ""), points))
}

/// Discs found and false features over the number of frames as a figure.
pub fn frames_svg(report: &ChartReport) -> String {
    let chart = &report.chart;
    let discs = format!("{} discs of {}×{} pixels", chart.discs, chart.width, chart.height);
    let charts = charts(report.setup.seeds);
    let snr = report.snr.map_or_else(String::new, |snr| format!("SNR {snr}, "));
    let caption = format!("{snr}{charts} each; {discs}, moving in {}", motion_label(chart.motion));
    figure("The number of frames of a burst", &caption, &chart_plots(report, usize::MAX), 0)
}

/// Features, discs and matches of a burst over the number of frames as a figure.
pub fn burst_frames_svg(report: &BurstFramesReport) -> String {
    let caption = format!("{}: the middle frames as a burst", report.burst);
    figure("The number of frames of a burst", &caption, &burst_frames_plots(report), 0)
}

fn charts(seeds: u64) -> String {
    if seeds == 1 { "one chart".to_owned() } else { format!("mean of {seeds} charts") }
}

/// Title of a part of a figure with its letter: (a), (b), … for 0, 1, …
pub(crate) fn lettered(index: usize, title: &str) -> String {
    format!("({}) {title}", char::from(b'a' + (index % 26) as u8))
}

fn figure(title: &str, caption: &str, plots: &[StudyPlot], first_letter: usize) -> String {
    let has_letters = plots.len() > 1 || first_letter > 0;
    let titled = |(index, plot): (usize, &StudyPlot)| {
        let title = if has_letters { lettered(first_letter + index, &plot.title) } else { plot.title.clone() };
        StudyPlot { title, ..plot.clone() }
    };
    let plots: Vec<StudyPlot> = plots.iter().enumerate().map(titled).collect();
    drawn(title, caption, &plots.iter().map(|plot| (plot, series_of(plot, None))).collect::<Vec<_>>())
}

/// All plots of named sets as an SVG figure, those of one title laid over one another.
pub fn curves_svg(sets: &[(String, Vec<StudyPlot>)]) -> String {
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
    drawn("Studies of the detector", "", &plots)
}

fn drawn(title: &str, caption: &str, plots: &[(&StudyPlot, Vec<Series>)]) -> String {
    let mut sheet = Sheet::new(WIDTH, title);
    sheet.styled_text((LEFT, 28.0), 15.0, Anchor::Start, r#"font-weight="bold""#, title);
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
            sheet.plot(
                area,
                &Plot {
                    title: &plot.title,
                    label_x: plot.x_label,
                    label_y: &plot.y_label,
                    range_x,
                    range_y,
                    has_dots: plot.marks_points,
                    series,
                },
            );
            let style = format!(r#"fill="{FAINT}""#);
            let has_dots = series.iter().any(|one| one.dot.is_some());
            let note = if has_dots { "dots: default threshold, mean of the charts" } else { plot.spread };
            sheet.styled_text((area.x, area.bottom() + 50.0), 11.0, Anchor::Start, &style, note);
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
            Series { label: format!("{}, {set}", line.label), dashes: "2 3", width: 1.4, dot: None, ..line.clone() }
        }
    };
    plot.curves.iter().map(line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::{BurstMethod, ChartStudy, RowStudy};
    use crate::synth::ChartParams;
    use burstscope_core::monitor::Monitor;

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
        assert_eq!(roc.curves[1].line.points[0].y, report.rows[1].methods[1].roc[0]);
        let buff = &found.curves[1];
        let points = &buff.line.points;
        assert_eq!(buff.line.label, "BuFF 1D");
        let rows: Vec<_> = points.iter().map(|point| (point.x, buff.row_value(point))).collect();
        assert_eq!(rows, [(0.8, 0.8), (1.5, 1.5)]);
        assert_eq!(roc.curves[1].row_value(&roc.curves[1].line.points[0]), 0.8);
        assert_eq!(points[1].y, report.rows[0].methods[1].true_positives.mean);
        assert!(points[1].spread.is_some_and(|[low, high]| low <= points[1].y && high >= points[1].y));
        assert_eq!(false_ones.curves.len(), 2);
    }

    #[test]
    fn a_table_has_a_row_for_each_point_and_quotes_names() {
        let plots = chart_plots(&report(), 0);
        let points: usize = plots.iter().flat_map(|plot| &plot.curves).map(|curve| curve.line.points.len()).sum();
        let csv = curves_csv(&[("gate \"4\", more".to_owned(), plots)]);
        assert_eq!(csv.lines().count(), 1 + points);
        for line in csv.lines().skip(1) {
            let numbers = line.strip_prefix("\"gate \"\"4\"\", more\",").expect("the name, quoted").rsplit(',');
            let numbers: Vec<&str> = numbers.take(4).collect();
            assert!(numbers[2..].iter().all(|number| number.parse::<f64>().is_ok()), "{line}");
        }
    }

    /// A plot of one curve, whose bars reach from half to `most` times the value.
    fn plot(method: Option<BurstMethod>, title: &str, most: f64) -> StudyPlot {
        let point = |x: f64| SeriesPoint { x, y: 2.0 * x, spread: Some([x, 2.0 * most * x]) };
        let points = vec![point(1.0), point(2.0)];
        let curve = StudyCurve { method, ..StudyCurve::plain("a & b", ("#0072b2", ""), points) };
        StudyPlot {
            title: title.to_owned(),
            x_label: "x",
            y_label: "y".to_owned(),
            marks_points: true,
            spread: "bars: 68 %",
            curves: vec![curve],
        }
    }

    #[test]
    fn plots_of_one_title_share_their_axes_and_the_document_is_sound() {
        let found = || plot(Some(BurstMethod::Buff1d), "Found", 1.5);
        let sets = [("now".to_owned(), vec![found(), plot(None, "Errors", 2.5)]), ("before".to_owned(), vec![found()])];
        let svg = curves_svg(&sets);
        let document = roxmltree::Document::parse(&svg).expect("sound XML");
        let texts: Vec<&str> = document.descendants().filter(|n| n.is_text()).filter_map(|n| n.text()).collect();
        assert_eq!(texts.iter().filter(|text| **text == "Found").count(), 1);
        assert!(texts.contains(&"a & b, before") && texts.iter().all(|text| !text.contains("a & b:")), "{texts:?}");
        assert_eq!(texts.iter().filter(|text| **text == "bars: 68 %").count(), 2, "one a plot");
        assert!(!svg.contains("NaN"));
        // Without plots the sheet is empty.
        roxmltree::Document::parse(&curves_svg(&[])).expect("sound XML");
    }

    #[test]
    fn bars_reach_from_the_lower_to_the_upper_end_around_the_only_curve() {
        let svg = curves_svg(&[("now".to_owned(), vec![plot(None, "Errors", 2.5)])]);
        let document = roxmltree::Document::parse(&svg).expect("sound XML");
        let number =
            |node: roxmltree::Node<'_, '_>, name| node.attribute(name).and_then(|text| text.parse::<f64>().ok());
        let bars = document.descendants().filter(|node| node.has_attribute("stroke-opacity"));
        let bars: Vec<[f64; 3]> =
            bars.map(|bar| ["x1", "y1", "y2"].map(|name| number(bar, name).expect(name))).collect();
        let dots = document.descendants().filter(|node| node.has_tag_name("circle"));
        let dots: Vec<[f64; 2]> = dots.map(|dot| ["cx", "cy"].map(|name| number(dot, name).expect(name))).collect();
        assert_eq!((bars.len(), dots.len()), (2, 2), "{svg}");
        for ([x, low, high], [dot_x, dot_y]) in bars.into_iter().zip(dots) {
            assert_eq!(x, dot_x);
            // The values are 1, 2 and 5 times x; higher ones are further up.
            let (below, above) = (low - dot_y, dot_y - high);
            assert!(below > 1.0 && (above / below - 3.0).abs() < 0.01, "{low} {dot_y} {high}");
        }
    }
}
