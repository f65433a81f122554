//! Plots on a [`Sheet`]: lines over axes with their spread, and a legend.

use super::shape::{Anchor, Colour, Dashes, FigureStroke, Style};
use super::sheet::{Area, GRID, INK, Sheet, WHITE, ticks};

/// A line of a plot.
#[derive(Debug, Clone, PartialEq)]
#[allow(missing_docs)] // where a name says it
pub struct Series {
    pub label: String,
    pub colour: Colour,
    pub dashes: Dashes,
    /// Width, pixels.
    pub width: f64,
    /// Points, from left to right. Points that are not finite break the line.
    pub points: Vec<SeriesPoint>,
    /// Place (x, y) of a single larger dot, drawn within the axes.
    pub dot: Option<(f64, f64)>,
}

/// Point of a line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SeriesPoint {
    /// Horizontal coordinate.
    pub x: f64,
    /// Vertical coordinate.
    pub y: f64,
    /// Lower and upper end of the value's spread, if known.
    pub spread: Option<[f64; 2]>,
}

/// Axes and the lines over them.
#[derive(Debug, Clone, PartialEq)]
#[allow(missing_docs)] // where a name says it
pub struct Plot<'a> {
    pub title: &'a str,
    pub label_x: &'a str,
    pub label_y: &'a str,
    /// Values at the left and the right end.
    pub range_x: (f64, f64),
    /// Values at the lower and the upper end.
    pub range_y: (f64, f64),
    pub has_dots: bool,
    /// Lines, the first at the bottom.
    pub series: &'a [Series],
}

impl Series {
    /// A line without a dot.
    pub fn new(label: &str, (colour, dashes): (Colour, Dashes), width: f64, points: Vec<SeriesPoint>) -> Self {
        Self { label: label.to_owned(), colour, dashes, width, points, dot: None }
    }

    fn stroke(&self) -> FigureStroke {
        FigureStroke { dashes: self.dashes, ..FigureStroke::new(self.colour, self.width as f32) }
    }

    fn dot_style(&self) -> Style {
        Style { fill: Some((self.colour, 1.0)), stroke: Some(WHITE.into()) }
    }
}

/// Range from 0 to a little above the largest finite value of the points with their spread, or `least` (above 0).
pub fn range_from_zero(series: &[Series], least: f64) -> (f64, f64) {
    let tops = series.iter().flat_map(|s| &s.points).flat_map(|p| [p.y, p.spread.map_or(p.y, |[_, high]| high)]);
    (0.0, 1.06 * tops.filter(|y| y.is_finite()).fold(least, f64::max))
}

impl Sheet {
    /// Draws a plot into `area`; its labels need space around it: 60 px to the left, 40 px below, 12 px above.
    pub fn plot(&mut self, area: Area, plot: &Plot<'_>) {
        let part = |value: f64, range: (f64, f64)| (value - range.0) / (range.1 - range.0);
        let x_of = |x: f64| area.x + part(x, plot.range_x) * area.width;
        let y_of = |y: f64| area.bottom() - part(y, plot.range_y) * area.height;
        // The grid first, under everything.
        ticks(plot.range_y).into_iter().map(y_of).for_each(|y| self.line((area.x, y), (area.right(), y), GRID));
        ticks(plot.range_x).into_iter().map(x_of).for_each(|x| self.line((x, area.y), (x, area.bottom()), GRID));
        self.heading((area.x, area.y - 10.0), 13.0, plot.title);
        self.axis_below(area, plot.range_x, plot.label_x);
        self.axis_left(area, plot.range_y, plot.label_y);
        self.clipped(area, |sheet| {
            for series in plot.series {
                let Series { colour, points, .. } = series;
                // A missing value is a gap, not a straight line to the next one.
                let finite = |p: &SeriesPoint| (p.x.is_finite() && p.y.is_finite()).then(|| (x_of(p.x), y_of(p.y)));
                for &SeriesPoint { x, y, spread } in points {
                    let is_finite = |ends: &[f64; 2]| [x, y, ends[0], ends[1]].iter().all(|n| n.is_finite());
                    if let Some([low, high]) = spread.filter(is_finite) {
                        let bar = FigureStroke { opacity: 0.75, ..FigureStroke::new(*colour, 1.2) };
                        sheet.line((x_of(x), y_of(low)), (x_of(x), y_of(high)), bar);
                    }
                }
                sheet.polyline(points.iter().map(finite), series.stroke());
                if plot.has_dots {
                    points.iter().filter_map(finite).for_each(|place| sheet.circle(place, 3.2, series.dot_style()));
                }
            }
        });
        // Drawn after the lines, which touch the axes.
        let (left, bottom) = ((area.x, area.y), (area.x, area.bottom()));
        self.line(left, bottom, INK);
        self.line(bottom, (area.right(), area.bottom()), INK);
        // Outside of the clipped part: a dot on an axis is seen whole.
        for (series, (x, y)) in plot.series.iter().filter_map(|series| Some((series, series.dot?))) {
            if x <= plot.range_x.1 && y <= plot.range_y.1 {
                self.circle((x_of(x), y_of(y)), 3.6, series.dot_style());
            }
        }
    }

    /// Draws the lines with their names from `at` in rows of at most `width`; returns the position of the next row.
    pub fn legend(&mut self, at: (f64, f64), width: f64, series: &[Series]) -> f64 {
        let (mut x, mut y) = at;
        for one in series {
            // About 6.3 px for each letter at this size.
            let needed = 42.0 + 6.3 * one.label.chars().count() as f64 + 20.0;
            if x > at.0 && x + needed > at.0 + width {
                (x, y) = (at.0, y + 20.0);
            }
            self.line((x, y), (x + 36.0, y), one.stroke());
            self.text((x + 42.0, y + 4.0), 12.0, Anchor::Start, &one.label);
            x += needed;
        }
        y + 20.0
    }
}
