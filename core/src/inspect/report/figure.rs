//! Figures of a probe and of a burst's slopes, for light and dark pages, readable without colour, with their numbers.

use crate::export::sheet::{Anchor, Area, BLUE, FAINT, Face, GREEN, GRID, INK, RED, Sheet, Style};
use crate::export::{CURVE_COLUMNS, Cell, Drawing, Figure, FigureStroke, SPECTRUM_COLUMNS, Table};
use crate::inspect::place::{Fate, Outcome, Probe, Shares, Slice, outline};
use crate::inspect::slopes::{SlopeBar, Spectrum};
use crate::inspect::words::{capitalised, counted, number, sentence, slope_text, value_text};
use crate::plane::{Plane, display::Display};

const WIDTH: f64 = 980.0;
const LEFT: f64 = 64.0;
const RIGHT: f64 = 500.0;
/// Percentiles of the values that are black and white.
const MOST: [f32; 2] = [1.0, 99.0];

/// The figure of a probe; `name` is the burst's. Its numbers are the curves of the response over the slopes, one a
/// scale, and each frame's response with its noise.
pub fn probe_figure(probe: &Probe, name: &str) -> Figure {
    let row = |plot: &str, curve: &str, x: f32, [y, low, high]: [Cell; 3]| {
        vec![name.into(), plot.into(), curve.into(), Cell::single(x, 2), y, low, high]
    };
    let map = &probe.response;
    let mut rows = Vec::new();
    for (scale, values) in map.scales.iter().zip(map.snr.data().chunks(map.snr.width().max(1))) {
        let curve = format!("σ {} px", number(scale.sigma, 2));
        for (&slope, &snr) in map.slopes.values.iter().zip(values) {
            rows.push(row("response over slope", &curve, slope, [Cell::single(snr, 2), Cell::Missing, Cell::Missing]));
        }
    }
    for frame in probe.shares.frames.iter().filter(|frame| frame.covers) {
        let ends = [frame.value, frame.value - frame.sigma_d, frame.value + frame.sigma_d];
        rows.push(row("response of each frame", "D", frame.frame as f32, ends.map(|x| Cell::single(x, 6))));
    }
    let drawing = probe_drawing(probe, name);
    Figure { table: Table::new(&drawing.title, CURVE_COLUMNS, rows), drawing }
}

fn probe_drawing(probe: &Probe, name: &str) -> Drawing {
    let [u, v] = probe.pos_image;
    let mut sheet = Sheet::new(WIDTH, &format!("{name} at ({u}, {v})"));
    sheet.heading((24.0, 30.0), 16.0, &format!("{name} at ({}, {})", number(u, 1), number(v, 1)));
    let top = sheet.paragraph((24.0, 52.0), 13.0, WIDTH - 48.0, &probe.summary) + 22.0;
    response(&mut sheet, Area { x: LEFT, y: top, width: 360.0, height: 250.0 }, probe);
    shares(&mut sheet, Area { x: RIGHT + 52.0, y: top, width: 400.0, height: 150.0 }, &probe.shares);
    patches(&mut sheet, Area { x: RIGHT + 52.0, y: top + 206.0, width: 400.0, height: 60.0 }, &probe.shares);
    let second = top + 340.0;
    slice(&mut sheet, Area { x: LEFT, y: second, width: 360.0, height: 110.0 }, probe, &probe.slices[0]);
    let mut end = second + 180.0;
    if let Some(fate) = probe.subject_fate().or_else(|| probe.fates.first()) {
        end = end.max(tests(&mut sheet, (RIGHT, second), fate));
    }
    for (text, _) in super::doubts(probe) {
        end = sheet.paragraph((24.0, end), 12.0, WIDTH - 48.0, &sentence(&text));
    }
    sheet.finish(end + 12.0)
}

fn heading(sheet: &mut Sheet, size: f64, area: Area, text: &str) {
    sheet.heading((area.x, area.y - 8.0), size, text);
}

fn response(sheet: &mut Sheet, area: Area, probe: &Probe) {
    let map = &probe.response;
    heading(sheet, 13.0, area, "Response over slope and scale, σ of its noise");
    let limit = map.snr.data().iter().fold(map.gate.max(1e-6), |max, x| max.max(x.abs()));
    sheet.picture(area, &map.snr, &Display::symmetric(limit));
    let (columns, rows) = (map.snr.width(), map.snr.height());
    let x_of = |column: f64| area.x + (column + 0.5) / columns as f64 * area.width;
    let y_of = |row: f64| area.y + (row + 0.5) / rows as f64 * area.height;
    let column_of = |slope: f32| f64::from(map.slopes.column_of(slope));
    for &slope in &map.slopes.grid {
        let x = x_of(column_of(slope));
        sheet.line((x, area.bottom()), (x, area.bottom() + 5.0), INK);
    }
    if let (Some(&first), Some(&last)) = (map.slopes.values.first(), map.slopes.values.last())
        && map.slopes.grid.len() > 1
    {
        // Limits of the slopes that are searched.
        for rim in [map.slopes.grid[0], map.slopes.grid[map.slopes.grid.len() - 1]] {
            let x = x_of(column_of(rim));
            sheet.line((x, area.y), (x, area.bottom()), FigureStroke::new(FAINT, 1.0).dashed([3.0, 3.0]));
        }
        let half = 0.5 * f64::from(last - first) / (columns - 1).max(1) as f64;
        let axis = if map.along_v { "slope v, px/frame" } else { "slope, px/frame" };
        sheet.axis_below(area, (f64::from(first) - half, f64::from(last) + half), axis);
    } else {
        sheet.text((area.x + 0.5 * area.width, area.bottom() + 16.0), 11.0, Anchor::Middle, "a single slope");
    }
    if let Some(motion) = &probe.motion {
        let [from, to] = map.band_of(motion).map(|column| x_of(column.into()).clamp(area.x, area.right()));
        let band = Area { x: from, width: to - from, ..area };
        sheet.rectangle(band, Style { fill: Some((GREEN, 0.25)), stroke: Some(GREEN.into()) });
    }
    // Outline of the cells whose response reaches the gate.
    for ends in outline(&map.snr, map.gate) {
        let [from, to] = ends.map(|(column, row)| (x_of(column.into()), y_of(row.into())));
        sheet.line(from, to, FigureStroke::new(INK, 1.0));
    }
    for (row, scale) in map.scales.iter().enumerate().step_by(rows.div_ceil(12).max(1)) {
        sheet.text((area.x - 7.0, y_of(row as f64) + 4.0), 11.0, Anchor::End, &number(scale.sigma, 1));
    }
    sheet.label_left(area, "scale σ, px");
    for fate in probe.fates.iter().rev() {
        let Some(row) = map.row_of(fate.octave, fate.level) else { continue };
        let place = (x_of(map.column_of(fate.slope).into()), y_of(row as f64));
        let (radius, ring) = match fate.is_kept() {
            true => (6.0, FigureStroke::new(INK, 2.0)),
            false => (3.5, FigureStroke::new(INK, 0.7).dashed([1.5, 1.5])),
        };
        sheet.circle(place, radius, ring);
    }
    let motion = if probe.motion.is_some() { "; band: the place's own motion" } else { "" };
    let legend = format!(
        "rings: kept (bold) and other candidates; line: the gate, {} σ; dashes: the range searched{motion}",
        number(map.gate, 2)
    );
    sheet.text((area.x, area.bottom() + 50.0), 11.0, Anchor::Start, &legend);
}

fn shares(sheet: &mut Sheet, area: Area, shares: &Shares) {
    let (slope, sigma) = (slope_text(shares.slope), number(shares.sigma, 1));
    heading(sheet, 13.0, area, &format!("Each frame's response at slope {slope}, σ {sigma} px"));
    let covering: Vec<_> = shares.frames.iter().filter(|f| f.covers).collect();
    let ends = covering.iter().flat_map(|f| [f.value - f.sigma_d, f.value + f.sigma_d]);
    let (min, max) = ends.fold((0.0f32, 0.0f32), |(a, b), x| (a.min(x), b.max(x)));
    let range = (f64::from(min) - 1e-9, f64::from(max) + 1e-9);
    let y_of = |value: f32| area.bottom() - (f64::from(value) - range.0) / (range.1 - range.0) * area.height;
    let count = shares.frames.len().max(1) as f64;
    let x_of = |index: usize| area.x + (index as f64 + 0.5) / count * area.width;
    sheet.rectangle(area, FigureStroke::from(GRID));
    sheet.line((area.x, y_of(0.0)), (area.right(), y_of(0.0)), FigureStroke::new(INK, 0.7));
    let mean = y_of(shares.evenness.mean);
    sheet.line((area.x, mean), (area.right(), mean), FigureStroke::new(BLUE, 1.0).dashed([6.0, 4.0]));
    for (index, frame) in shares.frames.iter().enumerate() {
        let x = x_of(index);
        if frame.covers {
            sheet.line((x, y_of(frame.value - frame.sigma_d)), (x, y_of(frame.value + frame.sigma_d)), INK);
            sheet.circle((x, y_of(frame.value)), 3.2, BLUE);
        } else {
            sheet.styled_text((x, area.y + 14.0), 11.0, Anchor::Middle, (Face::Plain, FAINT), "–");
        }
    }
    sheet.axis_left(area, range, "D");
    let text = format!("dashes: their mean. {}.", shares.meaning);
    let _ = sheet.paragraph((area.x, area.bottom() + 16.0), 11.0, area.width, &text);
}

fn patches(sheet: &mut Sheet, area: Area, shares: &Shares) {
    let count = shares.frames.len().max(1);
    let side = (area.width / count as f64).min(area.height);
    let values: Vec<f32> = shares.patches.iter().flat_map(|patch| patch.data().iter().copied()).collect();
    let display = Display::default().over_percentiles(&Plane::from_vec(values.len(), 1, values), MOST);
    for (index, (frame, patch)) in shares.frames.iter().zip(&shares.patches).enumerate() {
        let x = area.x + (index as f64 + 0.5) / count as f64 * area.width - 0.5 * side;
        let place = Area { x: x + 0.02 * side, y: area.y, width: 0.96 * side, height: 0.96 * side };
        sheet.picture(place, patch, &display);
        if count <= 16 {
            sheet.text((x + 0.5 * side, area.y + side + 11.0), 10.0, Anchor::Middle, &frame.frame.to_string());
        }
    }
    let note = format!("the {} px around it in each frame", number(shares.patch_px, 0));
    sheet.text((area.x, area.y + side + 25.0), 11.0, Anchor::Start, &note);
}

fn slice(sheet: &mut Sheet, area: Area, probe: &Probe, slice: &Slice) {
    heading(sheet, 13.0, area, "Slice along the motion: one row a frame");
    sheet.picture(area, &slice.plane, &Display::default().over_percentiles(&slice.plane, MOST));
    let (columns, rows) = slice.plane.size();
    let x_of = |column: f32| area.x + (f64::from(column) + 0.5) / columns as f64 * area.width;
    let y_of = |row: usize| area.y + (row as f64 + 0.5) / rows as f64 * area.height;
    let inside = |row: usize| {
        let column = slice.column_at(probe.subject.slope, row);
        (0.0..=columns as f32 - 1.0).contains(&column).then(|| (x_of(column), y_of(row)))
    };
    sheet.polyline((0..rows).map(inside), FigureStroke::new(RED, 1.5).dashed([5.0, 3.0]));
    let half = slice.centre_column as f64 + 0.5;
    sheet.axis_below(area, (-half, half), "px along the motion");
    for row in [0, rows.saturating_sub(1)] {
        sheet.text((area.x - 7.0, y_of(row) + 4.0), 11.0, Anchor::End, &slice.frames[row].to_string());
    }
    sheet.label_left(area, "frame");
}

/// Returns the position of its end, as do [`line`], [`plane`] and [`kernel`].
fn tests(sheet: &mut Sheet, (x, y): (f64, f64), fate: &Fate) -> f64 {
    let area = Area { x, y, width: WIDTH - x - 24.0, height: 0.0 };
    heading(sheet, 13.0, area, "The tests, in order");
    let mut y = y + 12.0;
    for report in fate.tests.iter().filter(|report| report.outcome != Outcome::NotAsked) {
        let fails = report.outcome == Outcome::Fails;
        let face = if Some(report.test) == fate.first_failed { Face::Bold } else { Face::Plain };
        let style = (face, if fails { RED } else { INK });
        let word = match report.outcome {
            Outcome::Passes => "passes",
            Outcome::Fails => "fails",
            Outcome::Unknown => "unknown",
            Outcome::NotAsked => "",
        };
        sheet.styled_text((x, y), 12.0, Anchor::Start, style, report.test.record().name);
        let value = report.value.map(value_text).unwrap_or_default();
        for (column, text) in [(224.0, &*value), (310.0, &*report.limit_text()), (372.0, word)] {
            sheet.styled_text((x + column, y), 12.0, Anchor::End, style, text);
        }
        y += 17.0;
    }
    y = sheet.paragraph((x, y + 6.0), 12.0, area.width, &sentence(&fate.verdict));
    if let Some(remedy) = &fate.remedy {
        let text = format!("{}: {}", capitalised(&remedy.sentence), remedy.change.option());
        y = sheet.paragraph((x, y), 12.0, area.width, &text);
    }
    y
}

const SLOPES_WIDTH: f64 = 820.0;
const SLOPES_LEFT: f64 = 76.0;

/// The figure of a burst's slopes; `name` is the burst's. Its numbers are those of the bars.
pub fn spectrum_figure(spectrum: &Spectrum, name: &str) -> Figure {
    let row = |bar: &SlopeBar| {
        let [u, v, evidence] = [bar.slope.u, bar.slope.v, bar.evidence].map(|x| Cell::single(x, 3));
        vec![u, v, Cell::count(bar.is_searched.into()), Cell::count(bar.features), Cell::count(bar.at_limit), evidence]
    };
    let drawing = spectrum_drawing(spectrum, name);
    let rows = spectrum.bars.iter().map(row).collect();
    Figure { table: Table::new(&drawing.title, SPECTRUM_COLUMNS, rows), drawing }
}

fn spectrum_drawing(spectrum: &Spectrum, name: &str) -> Drawing {
    let title = format!("Slopes of {name}");
    let mut sheet = Sheet::new(SLOPES_WIDTH, &title);
    sheet.heading((24.0, 30.0), 16.0, &title);
    let (features, slopes) = (counted(spectrum.features, "feature"), counted(spectrum.cost.slopes, "slope"));
    let (at_limit, summary) = (spectrum.at_limit, spectrum.finding.summary_beside_judgement());
    let found = format!("{features} at {slopes}; {at_limit} at the limit. What the frames show: {summary}.");
    let top = sheet.paragraph((24.0, 52.0), 13.0, SLOPES_WIDTH - 48.0, &found) + 24.0;
    let mut end =
        if spectrum.grid.is_plane() { plane(&mut sheet, top, spectrum) } else { line(&mut sheet, top, spectrum) };
    end += 18.0;
    if let Some(fits) = spectrum.judgement.as_ref().filter(|judgement| judgement.advice.is_none()) {
        end = sheet.paragraph((24.0, end), 13.0, SLOPES_WIDTH - 48.0, &sentence(&fits.sentence));
    }
    for advice in &spectrum.advice {
        end = sheet.paragraph((24.0, end), 13.0, SLOPES_WIDTH - 48.0, &format!("• {}.", advice.sentence));
        let options = advice.options();
        if !options.is_empty() {
            sheet.styled_text((38.0, end), 12.0, Anchor::Start, (Face::Mono, BLUE), &options);
            end += 20.0;
        }
    }
    sheet.finish(end + 6.0)
}

fn line(sheet: &mut Sheet, top: f64, spectrum: &Spectrum) -> f64 {
    let along = usize::from(spectrum.grid.u.count == 1 && spectrum.grid.v.count > 1);
    let place = |bar: &SlopeBar| bar.at[along];
    // Evidence beside the line has no position on this axis.
    let on_line = |bar: &&SlopeBar| bar.at[1 - along] == 0;
    let bars: Vec<&SlopeBar> = spectrum.bars.iter().filter(on_line).collect();
    let (first, last) = bars.iter().map(|bar| place(bar)).fold((i64::MAX, i64::MIN), |(a, b), x| (a.min(x), b.max(x)));
    let axis = [spectrum.grid.u, spectrum.grid.v][along];
    let step = f64::from(axis.step());
    let upper = Area { x: SLOPES_LEFT, y: top, width: SLOPES_WIDTH - SLOPES_LEFT - 30.0, height: 150.0 };
    let lower = Area { y: upper.bottom() + 26.0, height: 80.0, ..upper };
    let count = (last - first + 1).max(1) as f64;
    let cell = upper.width / count;
    let x_of = |at: i64| upper.x + (at - first) as f64 * cell;
    let max = 1.05 * bars.iter().map(|bar| bar.features).max().unwrap_or(0).max(1) as f64;
    let part = bars.iter().map(|bar| bar.evidence).fold(0.0, f32::max).max(1e-6);
    heading(sheet, 12.0, upper, "Features whose slope is nearest to each (orange: at the limit)");
    heading(sheet, 12.0, lower, "Evidence: what the frames have in common at each slope, before any threshold");
    for bar in &bars {
        let x = x_of(place(bar)) + 0.1 * cell;
        let width = 0.8 * cell;
        for (count, colour) in [(bar.features, BLUE), (bar.at_limit, RED)] {
            let height = count as f64 / max * upper.height;
            if count > 0 {
                sheet.rectangle(Area { x, y: upper.bottom() - height, width, height }, colour);
            }
        }
        if bar.evidence > 0.0 {
            let height = f64::from(bar.evidence / part) * lower.height;
            let area = Area { x, y: lower.bottom() - height, width, height };
            let beyond = FigureStroke::new(GREEN, 1.5);
            sheet.rectangle(area, if bar.is_searched { GREEN.into() } else { Style::from(beyond) });
        }
    }
    // The limits of the searched range.
    for x in [x_of(0), x_of(axis.count as i64)] {
        sheet.line((x, upper.y), (x, lower.bottom()), FigureStroke::new(FAINT, 1.0).dashed([3.0, 3.0]));
    }
    sheet.line((upper.x, upper.bottom()), (upper.right(), upper.bottom()), INK);
    sheet.line((lower.x, lower.bottom()), (lower.right(), lower.bottom()), INK);
    sheet.axis_left(upper, (0.0, max), "features");
    sheet.label_left(lower, "evidence");
    let begin = f64::from(axis.value(0.0)) + (first as f64 - 0.5) * step;
    let unit = if step > 0.0 { step } else { 1.0 };
    sheet.axis_below(lower, (begin, begin + count * unit), "slope, px/frame (dashes: the range searched)");
    lower.bottom() + 44.0
}

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
        let (width, height) = (side * size.0 as f64, side * size.1 as f64);
        let area = Area { x: SLOPES_LEFT + 380.0 * column as f64, y: top, width, height };
        heading(sheet, 12.0, area, name);
        let mut values = Plane::from_fn(size.0, size.1, |_, _| 0.0);
        for bar in &spectrum.bars {
            let (x, y) = ((bar.at[0] - i0) as usize, (bar.at[1] - j0) as usize);
            values.row_mut(y)[x] = value(bar);
        }
        let max = values.data().iter().copied().fold(1e-9, f32::max);
        // Large values are dark.
        let inverted = Plane::from_fn(size.0, size.1, |x, y| max - values.at(x, y));
        sheet.picture(area, &inverted, &Display::default().with_range(0.0, max));
        sheet.rectangle(area, FigureStroke::from(GRID));
        // Outline of the slopes that were searched.
        let (x, y) = (area.x - i0 as f64 * side, area.y - j0 as f64 * side);
        let (width, height) = (grid.u.count as f64 * side, grid.v.count as f64 * side);
        sheet.rectangle(Area { x, y, width, height }, FigureStroke::new(RED, 1.5).dashed([4.0, 3.0]));
        let ends = |axis: &crate::detector::SlopeAxis, first: i64, count: usize| {
            let begin = f64::from(axis.value(0.0)) + (first as f64 - 0.5) * f64::from(axis.step());
            (begin, begin + count as f64 * f64::from(axis.step()))
        };
        sheet.axis_below(area, ends(&grid.u, i0, size.0), "slope u, px/frame");
        let (top_v, bottom_v) = ends(&grid.v, j0, size.1);
        for row in 0..size.1 {
            if row % size.1.div_ceil(8) == 0 {
                let v = top_v + (row as f64 + 0.5) / size.1 as f64 * (bottom_v - top_v);
                let at = (area.x - 7.0, area.y + (row as f64 + 0.5) * side + 4.0);
                sheet.text(at, 11.0, Anchor::End, &number(v as f32, 2));
            }
        }
        sheet.label_left(area, "slope v");
        end = area.bottom() + 44.0;
    }
    sheet.text((SLOPES_LEFT, end + 6.0), 11.0, Anchor::Start, "dashes: the slopes searched");
    end + 14.0
}
