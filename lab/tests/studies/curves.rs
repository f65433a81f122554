//! The plots of studies: their points, their figures, and their numbers.

use crate::prelude::*;
use burstscope_core::export::{Series, SeriesPoint, sheet::BLUE, sheet::SOLID};
use burstscope_lab::evaluate::chart::ChartReport;
use burstscope_lab::evaluate::curves::{StudyCurve, StudyPlot, chart_plots, curves_figure, curves_table};
use burstscope_lab::evaluate::{BurstMethod, ChartStudy, RowStudy};

fn report() -> ChartReport {
    let chart = ChartParams { width: 160, height: 120, discs: 4, radius: 4.0..=9.0, ..ChartParams::default() };
    let study = ChartStudy { chart, snrs: vec![1.5, 0.8], seeds: 2, ..ChartStudy::default() };
    let study = ChartStudy { methods: vec![BurstMethod::SiftMean, BurstMethod::Buff1d], ..study };
    study.run(&quiet()).expect("a report")
}

#[test]
fn points_are_the_reports_numbers_and_bars_reach_from_the_lower_to_the_upper_end() {
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
    let svg = curves_figure(&[("now".to_owned(), vec![plot(None, "Errors", 2.5)])]).drawing.svg();
    let document = roxmltree::Document::parse(&svg).expect("sound XML");
    let number = |node: roxmltree::Node<'_, '_>, name| node.attribute(name).and_then(|text| text.parse::<f64>().ok());
    let bars = document.descendants().filter(|node| node.has_attribute("stroke-opacity"));
    let bars: Vec<[f64; 3]> = bars.map(|bar| ["x1", "y1", "y2"].map(|name| number(bar, name).expect(name))).collect();
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

#[test]
fn a_table_has_a_row_for_each_point_and_plots_of_one_title_share_their_axes() {
    let plots = chart_plots(&report(), 0);
    let points: usize = plots.iter().flat_map(|plot| &plot.curves).map(|curve| curve.line.points.len()).sum();
    let csv = curves_table(&[("gate \"4\", more".to_owned(), plots)]).csv();
    assert_eq!(csv.lines().count(), 1 + points);
    for line in csv.lines().skip(1) {
        let numbers = line.strip_prefix("\"gate \"\"4\"\", more\",").expect("the name, quoted").rsplit(',');
        let numbers: Vec<&str> = numbers.take(4).collect();
        assert!(numbers[2..].iter().all(|number| number.parse::<f64>().is_ok()), "{line}");
    }
    let found = || plot(Some(BurstMethod::Buff1d), "Found", 1.5);
    let sets = [("now".to_owned(), vec![found(), plot(None, "Errors", 2.5)]), ("before".to_owned(), vec![found()])];
    let svg = curves_figure(&sets).drawing.svg();
    let document = roxmltree::Document::parse(&svg).expect("sound XML");
    let texts: Vec<&str> = document.descendants().filter(|n| n.is_text()).filter_map(|n| n.text()).collect();
    assert_eq!(texts.iter().filter(|text| **text == "Found").count(), 1);
    assert!(texts.contains(&"a & b, before") && texts.iter().all(|text| !text.contains("a & b:")), "{texts:?}");
    assert_eq!(texts.iter().filter(|text| **text == "bars: 68 %").count(), 2, "one a plot");
    assert!(!svg.contains("NaN"));
    roxmltree::Document::parse(&curves_figure(&[]).drawing.svg()).expect("sound XML");
}

fn plot(method: Option<BurstMethod>, title: &str, most: f64) -> StudyPlot {
    let point = |x: f64| SeriesPoint { x, y: 2.0 * x, spread: Some([x, 2.0 * most * x]) };
    let points = vec![point(1.0), point(2.0)];
    let line = Series::new("a & b", (BLUE, SOLID), 2.2, points);
    let curve = StudyCurve { method, row: None, line };
    StudyPlot {
        title: title.to_owned(),
        x_label: "x",
        y_label: "y".to_owned(),
        marks_points: true,
        spread: "bars: 68 %",
        curves: vec![curve],
    }
}
