//! The plots of a report of planted things, in the form of those of the studies, and the figure with its map.

use super::report::{LevelShare, RecoverReport};
use super::{Planted, Varied};
use crate::evaluate::curves::{DOTS, StudyCurve, StudyPlot, curves_figure};
use burstscope_core::export::sheet::{Area, BLUE, GREEN, INK, RED, SOLID, Sheet, Style, WHITE, stacked};
use burstscope_core::export::{Drawing, Figure, FigureStroke, SeriesPoint};
use burstscope_core::plane::display::{ColourMap, Display};

const CURVE_POINTS: usize = 60;

/// The plots of a report: shares found over SNR, slope and radius, each with what noise and gate let expect.
pub fn recover_plots(report: &RecoverReport) -> Vec<StudyPlot> {
    let plot = |varied: Varied| {
        let (title, x_label) = match varied {
            Varied::Snr => ("Planted things found against SNR", "SNR of one pixel in one frame"),
            Varied::Slope => ("Planted things found against slope", "slope, px/frame"),
            Varied::Size => ("Planted things found against radius", "radius, px"),
        };
        let shares = report.shares_over(varied);
        let curve = |label: &str, line, point: &dyn Fn(&LevelShare) -> SeriesPoint| {
            StudyCurve::plain(label, line, shares.iter().map(point).collect())
        };
        let found = |share: &LevelShare| SeriesPoint {
            x: share.level,
            y: 100.0 * share.share(),
            spread: Some(share.interval.map(|end| 100.0 * end)),
        };
        let expected = |share: &LevelShare| SeriesPoint { x: share.level, y: 100.0 * share.expected, spread: None };
        let mut curves = vec![
            curve("found", (BLUE, SOLID), &found),
            curve("expected of noise and gate", (RED, [7.0, 4.0, 0.0, 0.0]), &expected),
        ];
        // The curve is fitted over SNR alone, and without a measured half it is the prior's.
        if varied == Varied::Snr && report.half.is_some() {
            curves.push(fitted_curve(report));
        }
        let (title, y_label) = (title.to_owned(), "found, %".to_owned());
        StudyPlot { title, x_label, y_label, marks_points: true, spread: "bars: 68 %", curves }
    };
    Varied::ALL.into_iter().map(plot).filter(|plot| !plot.curves[0].line.points.is_empty()).collect()
}

fn fitted_curve(report: &RecoverReport) -> StudyCurve {
    let snrs = &report.levels.snrs;
    let (first, last) = (snrs.first().copied().unwrap_or(0.1), snrs.last().copied().unwrap_or(1.0));
    let point = |i: usize| {
        let x = first * (last / first).powf(i as f64 / (CURVE_POINTS - 1) as f64);
        SeriesPoint { x, y: 100.0 * report.curve.share(x), spread: None }
    };
    StudyCurve::plain("fitted", (GREEN, DOTS), (0..CURVE_POINTS).map(point).collect())
}

/// The report as a figure: its curves, and the map with the things on it.
pub fn recover_figure(report: &RecoverReport) -> Figure {
    let curves = curves_figure(&[(report.burst.clone(), recover_plots(report))]);
    let title = format!("Would it have been seen in {}?", report.burst);
    Figure { drawing: stacked(&title, vec![map(report), curves.drawing]), ..curves }
}

const WIDTH: f64 = 880.0;

fn map(report: &RecoverReport) -> Drawing {
    let mut sheet = Sheet::new(WIDTH, "How faint a thing is seen at each place");
    let heading = format!("Would it have been seen in {}?", report.burst);
    sheet.heading((70.0, 28.0), 15.0, &heading);
    let mut top = 48.0;
    // The first line of the text names the burst, as the heading does.
    for line in report.text().lines().skip(1).take(2) {
        top = sheet.paragraph((70.0, top), 12.0, WIDTH - 140.0, line.trim());
    }
    let Some([min, max]) = report.map_range() else { return sheet.finish(top + 10.0) };
    let [columns, rows] = report.size.map(|n| n as f64);
    let scale = (560.0 / columns).min(420.0 / rows);
    let area = Area { x: 70.0, y: top + 14.0, width: columns * scale, height: rows * scale };
    let plane = &*report.map.plane;
    let cells = [plane.width() as f64, plane.height() as f64].map(|n| n * report.map.cell_px * scale);
    // A map of one value still needs a range for its colours.
    let display =
        Display { map: ColourMap::Viridis, ..Display::default() }.with_range(min as f32, max.max(1.001 * min) as f32);
    sheet.clipped(area, |sheet| {
        sheet.picture(Area { width: cells[0], height: cells[1], ..area }, plane, &display);
        let mut dot = |one: &Planted| {
            let place = (area.x + (one.truth.u + 0.5) * scale, area.y + (one.truth.v + 0.5) * scale);
            let style = match one.found {
                Some(_) => Style { fill: Some((WHITE, 1.0)), stroke: Some(FigureStroke::new(INK, 0.7)) },
                None => FigureStroke::from(WHITE).into(),
            };
            sheet.circle(place, 1.8, style);
        };
        // Things beyond the searched slopes are missed at any place, and so report nothing about a place.
        report.planted.iter().filter(|one| one.is_in_range).for_each(&mut dot);
    });
    sheet.rectangle(area, FigureStroke::from(INK));
    let percent = |x: f64| burstscope_core::export::sheet::short((1e5 * x).round() / 1e3);
    let legend = format!(
        "How faint: half are found from {} % of full scale (dark) to {} % (bright). Dots: found; rings: missed.",
        percent(min),
        percent(max)
    );
    let below = sheet.paragraph((70.0, area.bottom() + 20.0), 12.0, WIDTH - 140.0, &legend);
    sheet.finish(below + 10.0)
}
