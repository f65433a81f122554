//! The plots of studies as a figure: self-contained SVG, for light and dark pages, readable without colour.
//!
//! Two plots stand side by side, each with its legend. Curves of one method have one colour in all sets; those of sets
//! after the first are thinner and dotted.

use super::curves::{StudyCurve, StudyCurvePoint, StudyPlot};
use crate::export::sheet::{Anchor, Area, Sheet};
use crate::export::{Plot, Series};

const WIDTH: f64 = 880.0;
const LEFT: f64 = 70.0;
const HEIGHT: f64 = 280.0;

/// The plots of named sets as an SVG document; plots of the same title are overlaid.
pub fn curves_svg(sets: &[(String, Vec<StudyPlot>)]) -> String {
    let title = "Studies of the detector";
    let mut sheet = Sheet::new(WIDTH, title);
    sheet.styled_text((LEFT, 28.0), 15.0, Anchor::Start, r#"font-weight="bold""#, title);
    let mut plots: Vec<(&StudyPlot, Vec<Series>)> = Vec::new();
    for (index, (set, of_set)) in sets.iter().enumerate() {
        for plot in of_set {
            let series = plot.curves.iter().flat_map(|curve| series_of(curve, (index > 0).then_some(set.as_str())));
            match plots.iter_mut().find(|(first, _)| first.title == plot.title) {
                Some((_, all)) => all.extend(series),
                None => plots.push((plot, series.collect())),
            }
        }
    }
    let room = (WIDTH - 24.0) / 2.0;
    let mut top = 56.0;
    for pair in plots.chunks(2) {
        let mut below: f64 = top;
        for (column, (_, series)) in pair.iter().enumerate() {
            below = below.max(sheet.legend((LEFT + room * column as f64, top), room - LEFT, series));
        }
        for (column, (plot, series)) in pair.iter().enumerate() {
            let x = LEFT + room * column as f64;
            let area = Area { x, y: below + 18.0, width: room - LEFT - 8.0, height: HEIGHT };
            let ends = series.iter().flat_map(|s| &s.points).map(|point| point.0).filter(|x| x.is_finite());
            sheet.plot(
                area,
                &Plot {
                    title: &plot.title,
                    label_x: plot.x_label,
                    label_y: &plot.y_label,
                    range_x: (0.0, 1.03 * ends.fold(1e-6, f64::max)),
                    range_y: range_from_zero(series),
                    has_dots: plot.marks_points,
                    series,
                },
            );
        }
        top = below + HEIGHT + 78.0;
    }
    sheet.finish(top)
}

/// Range from 0 to a little above the largest value, however small: errors may be hundredths.
fn range_from_zero(series: &[Series]) -> (f64, f64) {
    let tops = series.iter().flat_map(|s| &s.points).map(|&(_, y, spread)| y + spread.unwrap_or(0.0));
    (0.0, 1.06 * tops.filter(|y| y.is_finite()).fold(1e-6, f64::max))
}

/// The lines of a curve: the curve itself, and for errors the 95 % as a separate line.
fn series_of(curve: &StudyCurve, set: Option<&str>) -> Vec<Series> {
    let label = set.map_or_else(|| curve.label.clone(), |set| format!("{}, {set}", curve.label));
    // Curves of sets after the first are thinner and dotted.
    let (dashes, width) = if set.is_some() { ("2 3", 1.4) } else { (curve.dashes, 2.2) };
    let line = |label: String, dashes, point: fn(&StudyCurvePoint) -> (f64, f64, Option<f64>)| Series {
        label,
        colour: curve.colour,
        dashes,
        width,
        points: curve.points.iter().map(point).collect(),
    };
    let is_symmetric = |point: &StudyCurvePoint| {
        point.spread.is_none_or(|[low, high]| (high + low - 2.0 * point.y).abs() < 1e-9 * high.abs().max(1.0))
    };
    if curve.points.iter().all(is_symmetric) {
        let with_error =
            |point: &StudyCurvePoint| (point.x, point.y, point.spread.map(|[low, high]| 0.5 * (high - low)));
        return vec![line(label, dashes, with_error)];
    }
    let upper = |point: &StudyCurvePoint| (point.x, point.spread.map_or(point.y, |[_, high]| high), None);
    vec![line(label.clone(), dashes, |point| (point.x, point.y, None)), line(format!("{label}: 95 %"), "7 4", upper)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::BurstMethod;

    /// A plot of one curve, whose points reach up to `most` times their value.
    fn plot(method: Option<BurstMethod>, title: &str, most: f64) -> StudyPlot {
        let point = |x: f64| StudyCurvePoint { x, y: 2.0 * x, spread: Some([x, 2.0 * most * x]), row_value: x };
        let points = vec![point(1.0), point(2.0)];
        let curve = StudyCurve { method, label: "a & b".to_owned(), colour: "#0072b2", dashes: "", points };
        StudyPlot {
            title: title.to_owned(),
            x_label: "x",
            y_label: "y".to_owned(),
            marks_points: true,
            spread: "",
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
        assert!(texts.contains(&"a & b, before") && texts.contains(&"a & b: 95 %"), "{texts:?}");
        assert!(!svg.contains("NaN"));
        // Without plots the sheet is empty.
        roxmltree::Document::parse(&curves_svg(&[])).expect("sound XML");
    }
}
