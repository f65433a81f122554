//! Response over slope and scale, with gate, candidates and a bar of its colours. A click moves the cursor there.

use super::strength_text;
use crate::app::canvas::overlay::rgb;
use crate::app::document::{Action, Destination, Queue};
use crate::app::panel::widgets::{WHOLE, draw_plane, named, small_text, weak_ui};
use crate::app::results::Read;
use crate::detector::Slope;
use crate::inspect::place::{Fate, FineAxis, MapScale, PlaceMotion, ProbeSubject, ResponseMap, outline};
use crate::inspect::words::{number, slope_text};
use crate::plane::Plane;
use crate::plane::display::Display;
use crate::requests::{Probed, ViewKind};
use egui::{Align2, Color32, Painter, Pos2, Rect, RichText, Sense, Stroke, StrokeKind, TextStyle, Ui, pos2, vec2};

const ROW: f32 = 9.0;

pub(super) fn response_ui(ui: &mut Ui, model: Read<'_>, answer: &Probed, queue: &mut Queue) {
    let map = &answer.probe.response;
    scales_ui(ui, model, answer, queue);
    slopes_ui(ui, model, answer, queue);
    let unit = if map.is_noiseless {
        "D; each scale has its own range".to_owned()
    } else {
        format!("D in σ of its noise, each scale with its own range; lines: gate {} σ", number(map.gate, 2))
    };
    let motion = if answer.probe.motion.is_some() { "; band: the place's own motion, ± its error" } else { "" };
    let legend = format!("{unit}; dashes: range searched; rings: candidates, bold: kept{motion}");
    weak_ui(ui, RichText::new(legend).small());
}

fn scales_ui(ui: &mut Ui, model: Read<'_>, answer: &Probed, queue: &mut Queue) {
    let map = &answer.probe.response;
    let rows = map.snr.height();
    let height = (ROW * rows as f32).clamp(80.0, 190.0);
    let (area, response) = area_ui(ui, height, map.snr.size());
    let values = Some(((&answer.probe).into(), WHOLE, || within_scales(map)));
    draw_plane(ui, ("probe response", area.rect), Display::symmetric(1.0), values);
    let painter = ui.painter().with_clip_rect(area.rect);
    grid_below(ui, &area, &map.slopes, if map.along_v { "slope v, px/frame" } else { "slope, px/frame" });
    rims(&painter, &area, &map.slopes, false);
    contour(&painter, &area, &map.snr, map.gate);
    if let Some(motion) = &answer.probe.motion {
        let [from, to] = map.band_of(motion).map(|column| area.pos(column, 0.0).x);
        let band = Rect::from_x_y_ranges(from..=to, area.rect.y_range());
        let band = band.expand2(vec2((LEAST_BAND - 0.5 * band.width()).max(0.0), 0.0));
        painter.rect_filled(band, 0.0, MOTION_FILL);
        painter.vline(band.center().x, band.y_range(), MOTION_LINE);
    }
    let cell = response.hover_pos().and_then(|pos| area.cell(pos));
    let subject = map.row_of(answer.probe.subject.octave, answer.probe.subject.level).unwrap_or(0);
    let row = cell.map_or(subject, |(_, row)| row);
    let pointed = cell.map(|(column, row)| map.snr.at(column, row));
    ColourBar { range: range_of(map.snr.row(row), gate_of(map)), gate: gate_of(map), pointed }.draw(ui, area.rect);
    let below = |x: f32| pos2(x, area.rect.bottom() + 8.0);
    small_ui(ui, below(area.rect.right() + RIGHT), &format!("of σ {}", number(map.scales[row].sigma, 1)));
    let each = rows.div_ceil((height / 13.0) as usize).max(1);
    for (row, scale) in map.scales.iter().enumerate().step_by(each) {
        small_ui(ui, pos2(area.rect.left() - 4.0, area.pos(0.0, row as f32).y), &number(scale.sigma, 1));
    }
    small_ui(ui, below(area.rect.left() - 4.0), "σ px");
    for (index, fate) in answer.probe.fates.iter().enumerate().rev() {
        let (slope, sigma) = refined(answer, fate);
        let at = area.pos(map.column_of(slope), map.row_at(sigma));
        ring(&painter, at, fate.is_kept(), answer.probe.subject.fate == Some(index));
    }
    let cursor = model.probed_pane().cursor;
    if let Some(row) = map.row_of(cursor.octave, cursor.level) {
        square(&painter, area.pos(map.column_of(cursor.slope), row as f32));
    }
    named(&response, egui::Role::Image, "Response over slope and scale");
    let Some((column, row)) = cell else { return };
    let (slope, scale) = (map.columns[column], map.scales[row]);
    let value = strength_text(answer, map.snr.at(column, row));
    let clicked = response.on_hover_text_at_pointer(reading(slope, &scale, &value)).clicked();
    queue.push_if(clicked, go_to(model, slope, &scale));
    let slope_index = answer.probe.subject.slope_index;
    let subject = ProbeSubject::Scale { octave: scale.octave, level: scale.level, slope_index };
    queue.push_if(clicked && map.plane.is_some(), Action::ProbeSubject(subject));
}

fn small_ui(ui: &Ui, at: Pos2, text: &str) {
    small_text(ui, ui.painter(), at, Align2::RIGHT_CENTER, text);
}

/// Draws the response over both slopes at one scale, where both were searched.
fn slopes_ui(ui: &mut Ui, model: Read<'_>, answer: &Probed, queue: &mut Queue) {
    let map = &answer.probe.response;
    let Some(plane) = &map.plane else { return };
    ui.add_space(6.0);
    let text = format!("Slope u and v at σ {} px", number(plane.scale.sigma, 1));
    ui.label(RichText::new(text).small()).on_hover_text("Click a row above to choose another scale");
    let (columns, rows) = plane.snr.size();
    let room = ui.available_width() - LEFT - RIGHT;
    let height = (room * rows as f32 / columns as f32).clamp(60.0, room);
    let (area, response) = area_ui(ui, height, plane.snr.size());
    let (gate, range) = (map.gate, range_of(plane.snr.data(), gate_of(map)));
    let values = Some(((&answer.probe).into(), WHOLE, || plane.snr.clone()));
    draw_plane(ui, ("probe slopes", area.rect), Display::symmetric(range), values);
    let painter = ui.painter().with_clip_rect(area.rect);
    grid_below(ui, &area, &plane.u, "slope u, px/frame");
    rims(&painter, &area, &plane.u, false);
    rims(&painter, &area, &plane.v, true);
    contour(&painter, &area, &plane.snr, gate);
    if let Some(PlaceMotion { slope, sigma }) = answer.probe.motion {
        let at = |u: f32, v: f32| area.pos(plane.u.column_of(u), plane.v.column_of(v));
        let (middle, end) = (at(slope.u, slope.v), at(slope.u + sigma, slope.v + sigma));
        let radius = (end - middle).max(egui::Vec2::splat(LEAST_BAND));
        painter.add(egui::Shape::ellipse_filled(middle, radius, MOTION_FILL));
        painter.add(egui::Shape::ellipse_stroke(middle, radius, MOTION_LINE));
    }
    let tick = Stroke::new(1.0, ui.visuals().weak_text_color());
    let each = plane.v.grid.len().div_ceil((height / 16.0) as usize).max(1);
    for &v in plane.v.grid.iter().step_by(each) {
        let at = pos2(area.rect.left() - 4.0, area.pos(0.0, plane.v.column_of(v)).y);
        ui.painter().hline(area.rect.left() - 3.0..=area.rect.left(), at.y, tick);
        small_ui(ui, at, &number(v, 2));
    }
    small_ui(ui, pos2(area.rect.left() - 4.0, area.rect.bottom() + 8.0), "v");
    let cell = response.hover_pos().and_then(|pos| area.cell(pos));
    let pointed = cell.map(|(column, row)| plane.snr.at(column, row));
    ColourBar { range, gate: gate_of(map), pointed }.draw(ui, area.rect);
    let scale = (plane.scale.octave, plane.scale.level);
    let fates = answer.probe.fates.iter().enumerate();
    for (index, fate) in fates.filter(|(_, fate)| (fate.octave, fate.level) == scale).rev() {
        let (slope, _) = refined(answer, fate);
        let at = area.pos(plane.u.column_of(slope.u), plane.v.column_of(slope.v));
        ring(&painter, at, fate.is_kept(), answer.probe.subject.fate == Some(index));
    }
    let cursor = model.probed_pane().cursor.slope;
    square(&painter, area.pos(plane.u.column_of(cursor.u), plane.v.column_of(cursor.v)));
    named(&response, egui::Role::Image, "Response over both slopes");
    let Some((column, row)) = cell else { return };
    // The axes may be rotated: the grid gives the slope of a cell.
    let grid = answer.request.traced.cache.params().used_slopes();
    let place = |axis: &FineAxis, at: usize| {
        let step = (axis.values.len() as f32 - 1.0) / (axis.grid.len() as f32 + 1.0);
        at as f32 / step - 1.0
    };
    let slope = grid.at(place(&plane.u, column), place(&plane.v, row));
    let text = reading(slope, &plane.scale, &strength_text(answer, plane.snr.at(column, row)));
    queue.push_if(response.on_hover_text_at_pointer(text).clicked(), go_to(model, slope, &plane.scale));
}

fn go_to(model: Read<'_>, slope: Slope, scale: &MapScale) -> Action {
    let scale = Some((scale.octave, scale.level));
    let kind = Some(ViewKind::Dog);
    Action::GoTo(model.document.probe.side, Destination { slope: Some(slope), scale, kind, ..Destination::default() })
}

fn reading(slope: Slope, scale: &MapScale, value: &str) -> String {
    let (slope, sigma, MapScale { octave, level, .. }) = (slope_text(slope), number(scale.sigma, 2), scale);
    format!("{value}\nslope {slope} px/frame\nσ {sigma} px (octave {octave}, level {level})\nClick to go there")
}

/// The gate, in the unit of the map's values; `None` where these are D itself.
fn gate_of(map: &ResponseMap) -> Option<f32> {
    (!map.is_noiseless).then_some(map.gate)
}

/// The map with each scale divided by its own range: one strong scale does not flatten the others.
fn within_scales(map: &ResponseMap) -> Plane {
    let ranges: Vec<f32> = (0..map.scales.len()).map(|row| range_of(map.snr.row(row), gate_of(map))).collect();
    Plane::from_fn(map.columns.len(), map.scales.len(), |column, row| map.snr.at(column, row) / ranges[row])
}

/// Slope and σ of a candidate: refined, if it became a feature, otherwise those of its sample.
fn refined(answer: &Probed, fate: &Fate) -> (Slope, f32) {
    let features = &answer.request.traced.cache.detection().features;
    let feature = fate.features.first().and_then(|&index| features.get(index));
    feature.map_or((fate.slope, fate.sigma), |feature| (feature.slope, feature.sigma))
}

/// Space for the numbers beside and below a map, and for the bar of its colours on the right, points.
const LEFT: f32 = 30.0;
const BELOW: f32 = 28.0;
const RIGHT: f32 = 46.0;

struct Area {
    rect: Rect,
    cells: (usize, usize),
}

impl Area {
    /// Position of a cell's centre; fractions lie between cells.
    fn pos(&self, column: f32, row: f32) -> Pos2 {
        let (width, height) = (self.cells.0 as f32, self.cells.1 as f32);
        self.rect.min + vec2((column + 0.5) / width * self.rect.width(), (row + 0.5) / height * self.rect.height())
    }

    fn cell(&self, pos: Pos2) -> Option<(usize, usize)> {
        let at = |part: f32, n: usize| ((part * n as f32).max(0.0) as usize).min(n - 1);
        let part = (pos - self.rect.min) / self.rect.size();
        self.rect.contains(pos).then(|| (at(part.x, self.cells.0), at(part.y, self.cells.1)))
    }
}

fn area_ui(ui: &mut Ui, height: f32, cells: (usize, usize)) -> (Area, egui::Response) {
    let (whole, response) = ui.allocate_exact_size(vec2(ui.available_width(), height + BELOW), Sense::click());
    let rect = Rect::from_min_max(whole.min + vec2(LEFT, 2.0), whole.max - vec2(RIGHT, BELOW - 2.0));
    (Area { rect, cells }, response)
}

fn grid_below(ui: &Ui, area: &Area, axis: &FineAxis, name: &str) {
    let (painter, bottom) = (ui.painter(), area.rect.bottom());
    let stroke = Stroke::new(1.0, ui.visuals().weak_text_color());
    let room = (area.rect.width() / 42.0).max(1.0) as usize;
    let each = axis.grid.len().div_ceil(room).max(1);
    for (index, &slope) in axis.grid.iter().enumerate() {
        let x = area.pos(axis.column_of(slope), 0.0).x;
        painter.vline(x, bottom..=bottom + 3.0, stroke);
        if index % each == 0 {
            small_text(ui, painter, pos2(x, bottom + 3.0), Align2::CENTER_TOP, &number(slope, 2));
        }
    }
    small_text(ui, painter, pos2(area.rect.center().x, bottom + 14.0), Align2::CENTER_TOP, name);
}

/// Draws dashes at the ends of the searched slopes, and faint lines at each slope.
fn rims(painter: &Painter, area: &Area, axis: &FineAxis, upright: bool) {
    let [_, .., last] = axis.grid[..] else { return };
    let line = |at: f32| {
        let (rect, column) = (area.rect, axis.column_of(at));
        let (x, y) = (area.pos(column, 0.0).x, area.pos(0.0, column).y);
        let upright_ends = [pos2(rect.left(), y), pos2(rect.right(), y)];
        if upright { upright_ends } else { [pos2(x, rect.top()), pos2(x, rect.bottom())] }
    };
    for &slope in &axis.grid {
        painter.line_segment(line(slope), Stroke::new(0.5, Color32::from_black_alpha(40)));
    }
    for rim in [axis.grid[0], last] {
        painter.extend(egui::Shape::dashed_line(&line(rim), Stroke::new(1.0, Color32::from_gray(60)), 3.0, 3.0));
    }
}

fn contour(painter: &Painter, area: &Area, plane: &Plane, gate: f32) {
    for ends in outline(plane, gate) {
        let ends = ends.map(|(column, row)| area.pos(column, row));
        painter.line_segment(ends, Stroke::new(1.2, Color32::BLACK));
    }
}

/// Colours and least half width, points, of the mark of the place's own motion.
const MOTION_LINE: Stroke = Stroke { width: 1.5, color: Color32::from_rgb(0, 110, 60) };
const MOTION_FILL: Color32 = Color32::from_rgba_premultiplied(0, 40, 20, 60);
const LEAST_BAND: f32 = 2.0;

/// Draws a candidate; kept and selected ones are larger.
fn ring(painter: &Painter, at: Pos2, kept: bool, selected: bool) {
    let radius = if kept || selected { 5.5 } else { 2.5 };
    let width = if kept { 2.0 } else { 1.0 };
    let colour = if selected { Color32::from_rgb(0, 90, 30) } else { Color32::from_gray(30) };
    if kept || selected {
        painter.circle_stroke(at, radius, Stroke::new(width + 2.0, Color32::from_white_alpha(200)));
    }
    painter.circle_stroke(at, radius, Stroke::new(width, colour));
}

fn square(painter: &Painter, at: Pos2) {
    let rect = Rect::from_center_size(at, vec2(8.0, 8.0));
    for (width, colour) in [(3.0, Color32::from_white_alpha(200)), (1.2, Color32::BLACK)] {
        painter.rect_stroke(rect, 0.0, Stroke::new(width, colour), StrokeKind::Middle);
    }
}

/// Width of the bar of the colours, and its distance from the map, points.
const BAR: f32 = 9.0;
const GAP: f32 = 5.0;
const STEPS: usize = 48;
const APART: f32 = 11.0;

/// Bar beside a map: the colours, the values that they stand for, the gate, and the value under the pointer.
struct ColourBar {
    range: f32,
    /// Factor of the noise gate, where the values are in its unit.
    gate: Option<f32>,
    pointed: Option<f32>,
}

/// Largest magnitude that the colours of `values` span: at least the gate, so that mere noise stays pale.
fn range_of<'v>(values: impl IntoIterator<Item = &'v f32>, gate: Option<f32>) -> f32 {
    let finite = values.into_iter().filter(|x| x.is_finite());
    finite.fold(gate.unwrap_or_default().max(1e-12), |max, x| max.max(x.abs()))
}

/// A value of a map as short text: in σ of its noise, or D itself where there is no gate.
fn text(value: f32, gate: Option<f32>) -> String {
    match gate {
        Some(_) => number(value, if value.abs() < 9.95 { 1 } else { 0 }),
        None if value == 0.0 => "0".to_owned(),
        None => format!("{value:.0e}").replace('-', "−"),
    }
}

impl ColourBar {
    /// Values with a number, each far enough from those before it: 0 and the ends first.
    fn ticks(&self, height: f32) -> Vec<f32> {
        let mut ticks: Vec<f32> = Vec::new();
        let gates = self.gate.into_iter().flat_map(|gate| [gate, -gate]);
        for value in [self.range, -self.range, 0.0].into_iter().chain(gates) {
            let apart = |other: &f32| (other - value).abs() / (2.0 * self.range) * height;
            if value.abs() <= self.range && ticks.iter().all(|other| apart(other) >= APART) {
                ticks.push(value);
            }
        }
        ticks
    }

    fn draw(&self, ui: &Ui, map: Rect) {
        let painter: &Painter = ui.painter();
        let left = map.right() + GAP;
        let rect = Rect::from_min_max(pos2(left, map.top()), pos2(left + BAR, map.bottom()));
        let at = |value: f32| rect.bottom() - (0.5 + 0.5 * value / self.range) * rect.height();
        let colours = Display::symmetric(1.0).colours();
        for row in 0..STEPS {
            let edge = |row: usize| rect.top() + row as f32 / STEPS as f32 * rect.height();
            let colour = rgb(colours.colour(1.0 - 2.0 * (row as f32 + 0.5) / STEPS as f32));
            painter.rect_filled(Rect::from_x_y_ranges(rect.x_range(), edge(row)..=edge(row + 1)), 0.0, colour);
        }
        let (weak, strong) = (ui.visuals().weak_text_color(), ui.visuals().strong_text_color());
        painter.rect_stroke(rect, 0.0, Stroke::new(1.0, weak), StrokeKind::Outside);
        let font = TextStyle::Small.resolve(ui.style());
        let beside = |value: f32| pos2(rect.right() + 4.0, at(value).clamp(rect.top() + 5.0, rect.bottom() - 5.0));
        for gate in self.gate.into_iter().flat_map(|gate| [gate, -gate]).filter(|gate| gate.abs() <= self.range) {
            painter.hline(rect.x_range(), at(gate), Stroke::new(1.2, Color32::BLACK));
        }
        let pointed = self.pointed.filter(|value| value.is_finite());
        let is_free = |value: &f32| pointed.is_none_or(|other| (at(other) - at(*value)).abs() >= APART);
        for value in self.ticks(rect.height()).into_iter().filter(is_free) {
            painter.text(beside(value), Align2::LEFT_CENTER, text(value, self.gate), font.clone(), weak);
        }
        if let Some(value) = pointed {
            let y = at(value.clamp(-self.range, self.range));
            painter.hline(rect.left() - 3.0..=rect.right() + 3.0, y, Stroke::new(2.0, strong));
            painter.text(beside(value), Align2::LEFT_CENTER, text(value, self.gate), font, strong);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::apply::bench::open;
    use crate::detector::{DetectorParams, SlopeGrid};
    use crate::inspect::ProbeCache;
    use crate::inspect::place::{ProbeOptions, probe};
    use crate::monitor::Monitor;

    fn map(slopes: SlopeGrid) -> ResponseMap {
        let params = DetectorParams { slopes, octaves: 2, ..DetectorParams::default() };
        let cache = ProbeCache::new(&open((48, 40), 3).burst, &params.into(), &Monitor::default()).expect("valid");
        let probe = probe(&cache, [24.0, 20.0], &ProbeOptions::default(), &Monitor::default()).expect("inside");
        probe.response
    }

    #[test]
    fn places_on_the_map_are_even_in_slope_and_in_the_logarithm_of_the_scale() {
        let map = map(SlopeGrid::line(-1.0..=1.0, 3));
        let (last, scales) = (map.scales.len() - 1, &map.scales);
        assert!(last >= 3);
        for (row, scale) in scales.iter().enumerate() {
            assert!((map.row_at(scale.sigma) - row as f32).abs() < 1e-3, "row {row}");
        }
        let between = (scales[1].sigma * scales[2].sigma).sqrt();
        assert!((map.row_at(between) - 1.5).abs() < 1e-3);
        assert_eq!((map.row_at(0.01), map.row_at(1e4)), (0.0, last as f32), "beyond the map is its rim");
        for (column, &slope) in map.columns.iter().enumerate() {
            assert!((map.column_of(slope) - column as f32).abs() < 1e-4, "column {column}");
        }
        let (first, next) = (map.columns[0], map.columns[1]);
        let motion = PlaceMotion { slope: map.columns[3], sigma: 2.0 * (next.u - first.u) };
        assert!(map.band_of(&motion).into_iter().zip([1.0, 5.0]).all(|(a, b)| (a - b).abs() < 1e-3));
        let outside = map.column_of(Slope::new(first.u - 0.5 * (next.u - first.u), first.v));
        assert!((outside + 0.5).abs() < 1e-4, "{outside}");
    }

    #[test]
    fn each_scale_has_its_own_range() {
        let mut map = map(SlopeGrid::line(-1.0..=1.0, 3));
        (map.gate, map.is_noiseless) = (5.0, false);
        let strong = [3.0, 10.0, 100.0];
        map.snr = Plane::from_fn(map.columns.len(), map.scales.len(), |column, row| {
            strong[row.min(2)] * (1.0 - column as f32 / map.columns.len() as f32)
        });
        let shown = within_scales(&map);
        assert!(shown.row(1).iter().zip(shown.row(2)).all(|(a, b)| (a - b).abs() < 1e-6), "ten times as strong");
        assert!((shown.at(0, 1) - 1.0).abs() < 1e-6 && (shown.at(0, 0) - 0.6).abs() < 1e-6, "noise stays pale");
    }

    #[test]
    fn the_range_holds_the_gate_and_all_finite_values_and_its_numbers_are_apart() {
        assert_eq!(range_of(&[-0.5, f32::NAN, 0.2], Some(0.1)), 0.5);
        assert_eq!(range_of(&[-0.5, f32::NAN, 0.2], Some(0.9)), 0.9);
        assert_eq!(range_of(&[2e-3, -3e-3], None), 3e-3, "without noise there is no gate");
        let bar = |range, gate| ColourBar { range, gate: Some(gate), pointed: None };
        assert_eq!(bar(10.0, 4.6).ticks(150.0), [10.0, -10.0, 0.0, 4.6, -4.6]);
        assert_eq!(bar(5.0, 4.6).ticks(150.0), [5.0, -5.0, 0.0], "the gate is too near to the ends");
        let texts = [(-0.04, Some(4.6)), (-12.34, Some(4.6)), (-0.0123, None)].map(|(value, gate)| text(value, gate));
        assert_eq!(texts, ["0", "−12", "−1e−2"]);
    }
}
