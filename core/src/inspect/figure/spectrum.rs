//! The figure of a burst's slopes: features and evidence at each slope, the range searched, and the advice.

use crate::export::sheet::{Anchor, Area, BLUE, FAINT, GREEN, GRID, INK, RED, Sheet};
use crate::inspect::spectrum::{SlopeBar, Spectrum};
use crate::inspect::texture::dirichlet;
use crate::inspect::words::{counted, number};
use crate::plane::Plane;
use crate::plane::display::Display;

const WIDTH: f64 = 820.0;
const LEFT: f64 = 76.0;

/// The figure as an SVG document; `name` is the burst's.
pub fn spectrum_svg(spectrum: &Spectrum, name: &str) -> String {
    let mut sheet = Sheet::new(WIDTH, &format!("Slopes of {name}"));
    let title = format!("Slopes of {name}");
    sheet.styled_text((24.0, 30.0), 16.0, Anchor::Start, r#"font-weight="bold""#, &title);
    let found = format!(
        "{} at {}; {} at the limit. What the frames show: {}.",
        counted(spectrum.features, "feature"),
        counted(spectrum.cost.slopes, "slope"),
        spectrum.at_limit,
        spectrum.finding.summary()
    );
    let top = sheet.paragraph((24.0, 52.0), 13.0, WIDTH - 48.0, &found) + 24.0;
    let mut end =
        if spectrum.grid.is_plane() { plane(&mut sheet, top, spectrum) } else { line(&mut sheet, top, spectrum) };
    if let Some(alias) = spectrum.aliases.first() {
        end = kernel(&mut sheet, end + 34.0, spectrum.frames, f64::from(alias.period_px));
    }
    end += 18.0;
    if spectrum.advice.is_empty() {
        sheet.text((24.0, end), 13.0, Anchor::Start, "The slopes fit the burst; nothing to change.");
        end += 18.0;
    }
    for advice in &spectrum.advice {
        end = sheet.paragraph((24.0, end), 13.0, WIDTH - 48.0, &format!("• {}.", advice.sentence));
        let options: Vec<String> = advice.changes.iter().map(|change| change.option()).collect();
        if !options.is_empty() {
            let style = format!(r#"font-family="monospace" fill="{BLUE}""#);
            sheet.styled_text((38.0, end), 12.0, Anchor::Start, &style, &options.join(" "));
            end += 20.0;
        }
    }
    sheet.finish(end + 6.0)
}

/// Draws the bars of a line of slopes: features above, evidence below. Returns the position of its end.
fn line(sheet: &mut Sheet, top: f64, spectrum: &Spectrum) -> f64 {
    let second = spectrum.grid.u.count == 1 && spectrum.grid.v.count > 1;
    let place = |bar: &SlopeBar| if second { bar.at[1] } else { bar.at[0] };
    // Evidence beside the line has no position on this axis.
    let on_line = |bar: &&SlopeBar| if second { bar.at[0] == 0 } else { bar.at[1] == 0 };
    let bars: Vec<&SlopeBar> = spectrum.bars.iter().filter(on_line).collect();
    let (first, last) = bars.iter().map(|bar| place(bar)).fold((i64::MAX, i64::MIN), |(a, b), x| (a.min(x), b.max(x)));
    let axis = if second { spectrum.grid.v } else { spectrum.grid.u };
    let step = f64::from(axis.step());
    let upper = Area { x: LEFT, y: top, width: WIDTH - LEFT - 30.0, height: 150.0 };
    let lower = Area { y: upper.bottom() + 26.0, height: 80.0, ..upper };
    let count = (last - first + 1).max(1) as f64;
    let cell = upper.width / count;
    let x_of = |at: i64| upper.x + (at - first) as f64 * cell;
    let max = 1.05 * bars.iter().map(|bar| bar.features).max().unwrap_or(0).max(1) as f64;
    let part = bars.iter().map(|bar| bar.evidence).fold(0.0, f32::max).max(1e-6);
    heading(sheet, upper, "Features whose slope is nearest to each (orange: at the limit)");
    heading(sheet, lower, "Evidence: what the frames have in common at each slope, before any threshold");
    for bar in &bars {
        let x = x_of(place(bar)) + 0.1 * cell;
        let width = 0.8 * cell;
        let height = bar.features as f64 / max * upper.height;
        let colour = if bar.is_on_rim { RED } else { BLUE };
        if bar.features > 0 {
            let area = Area { x, y: upper.bottom() - height, width, height };
            sheet.rectangle(area, &format!(r#"fill="{colour}""#));
        }
        if bar.evidence > 0.0 {
            let height = f64::from(bar.evidence / part) * lower.height;
            let area = Area { x, y: lower.bottom() - height, width, height };
            let style = if bar.is_searched {
                format!(r#"fill="{GREEN}""#)
            } else {
                format!(r#"fill="none" stroke="{GREEN}" stroke-width="1.5""#)
            };
            sheet.rectangle(area, &style);
        }
    }
    // The limits of the searched range.
    let searched = |at: i64| x_of(at);
    let count_axis = axis.count as i64;
    for x in [searched(0), searched(count_axis)] {
        sheet.line((x, upper.y), (x, lower.bottom()), FAINT, r#"stroke-dasharray="3 3""#);
    }
    sheet.line((upper.x, upper.bottom()), (upper.right(), upper.bottom()), INK, "");
    sheet.line((lower.x, lower.bottom()), (lower.right(), lower.bottom()), INK, "");
    sheet.axis_left(upper, (0.0, max), "features");
    sheet.label_left(lower, "evidence");
    let begin = f64::from(axis.value(0.0)) + (first as f64 - 0.5) * step;
    let unit = if step > 0.0 { step } else { 1.0 };
    sheet.axis_below(lower, (begin, begin + count * unit), "slope, px/frame (dashes: the range searched)");
    lower.bottom() + 44.0
}

fn heading(sheet: &mut Sheet, area: Area, text: &str) {
    sheet.styled_text((area.x, area.y - 8.0), 12.0, Anchor::Start, r#"font-weight="bold""#, text);
}

/// Draws the plane of slopes: features and evidence, side by side. Returns the position of its end.
fn plane(sheet: &mut Sheet, top: f64, spectrum: &Spectrum) -> f64 {
    let range = |axis: usize| {
        spectrum.bars.iter().map(|bar| bar.at[axis]).fold((i64::MAX, i64::MIN), |(a, b), x| (a.min(x), b.max(x)))
    };
    let ((i0, i1), (j0, j1)) = (range(0), range(1));
    let size = ((i1 - i0 + 1) as usize, (j1 - j0 + 1) as usize);
    let side = (300.0 / size.0.max(size.1) as f64).min(40.0);
    let grid = spectrum.grid;
    let mut end = top;
    for (column, (name, value)) in [
        ("Features", (|bar: &SlopeBar| bar.features as f32) as fn(&SlopeBar) -> f32),
        ("Evidence before any threshold", |bar: &SlopeBar| bar.evidence),
    ]
    .into_iter()
    .enumerate()
    {
        let area =
            Area { x: LEFT + 380.0 * column as f64, y: top, width: side * size.0 as f64, height: side * size.1 as f64 };
        heading(sheet, area, name);
        let mut values = Plane::from_fn(size.0, size.1, |_, _| 0.0);
        for bar in &spectrum.bars {
            let (x, y) = ((bar.at[0] - i0) as usize, (bar.at[1] - j0) as usize);
            values.row_mut(y)[x] = value(bar);
        }
        let max = values.data().iter().copied().fold(1e-9, f32::max);
        // Large values are dark.
        let inverted = Plane::from_fn(size.0, size.1, |x, y| max - values.at(x, y));
        sheet.picture(area, &inverted, &Display::default().with_range(0.0, max));
        sheet.rectangle(area, &format!(r#"fill="none" stroke="{GRID}""#));
        // Outline of the slopes that were searched.
        let searched = Area {
            x: area.x - i0 as f64 * side,
            y: area.y - j0 as f64 * side,
            width: grid.u.count as f64 * side,
            height: grid.v.count as f64 * side,
        };
        sheet.rectangle(searched, &format!(r#"fill="none" stroke="{RED}" stroke-width="1.5" stroke-dasharray="4 3""#));
        let ends = |axis: &crate::detector::SlopeAxis, first: i64, count: usize| {
            let begin = f64::from(axis.value(0.0)) + (first as f64 - 0.5) * f64::from(axis.step());
            (begin, begin + count as f64 * f64::from(axis.step()))
        };
        sheet.axis_below(area, ends(&grid.u, i0, size.0), "slope u, px/frame");
        let (top_v, bottom_v) = ends(&grid.v, j0, size.1);
        for row in 0..size.1 {
            if row % size.1.div_ceil(8) == 0 {
                let v = top_v + (row as f64 + 0.5) / size.1 as f64 * (bottom_v - top_v);
                sheet.text(
                    (area.x - 7.0, area.y + (row as f64 + 0.5) * side + 4.0),
                    11.0,
                    Anchor::End,
                    &number(v as f32, 2),
                );
            }
        }
        sheet.label_left(area, "slope v");
        end = area.bottom() + 44.0;
    }
    sheet.text((LEFT, end + 6.0), 11.0, Anchor::Start, "dashes: the slopes searched");
    end + 14.0
}

/// Draws the response of a texture of a period at slopes around its own: aliases and side lobes. Returns the position
/// of its end.
fn kernel(sheet: &mut Sheet, top: f64, frames: usize, period: f64) -> f64 {
    let area = Area { x: LEFT, y: top, width: WIDTH - LEFT - 30.0, height: 70.0 };
    let text =
        format!("A texture of period {} px in {frames} frames, at slopes beside its own", number(period as f32, 1));
    heading(sheet, area, &text);
    let range = (-1.5 * period, 1.5 * period);
    let point = |k: usize| {
        let x = f64::from(k as u32) / 600.0;
        let slope = range.0 + x * (range.1 - range.0);
        Some((area.x + x * area.width, area.bottom() - dirichlet(frames, period, slope) * area.height))
    };
    sheet.rectangle(area, &format!(r#"fill="none" stroke="{GRID}""#));
    sheet.polyline((0..=600).map(point), &format!(r#"stroke="{INK}" stroke-width="1.2""#));
    sheet.axis_below(area, range, "px/frame off");
    area.bottom() + 40.0
}
