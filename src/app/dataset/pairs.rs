//! Matches of all pairs of bursts: a matrix whose cells show inliers as colour and number, and a list.

use super::filmstrip::side_colour;
use crate::app::document::{Action, BurstPair, DatasetChoice, PairColumn, Queue, Side};
use crate::app::panel::table::{Heading, Listed, rows_ui, texts};
use crate::app::panel::widgets::{instead_ui, middle_elided, strip_of_colours};
use crate::app::results::datasets::pairs::PairTable;
use crate::app::results::{BurstState, Dataset};
use crate::app::style;
use crate::app::{canvas::overlay::rgb, document::datasets::pair_of};
use crate::inspect::words::counted;
use crate::plane::display::ColourMap;
use egui::epaint::TextShape;
use egui::{Align2, Color32, FontId, Pos2, Rect, Response, RichText, Sense, Stroke, StrokeKind, Ui, pos2, vec2};

/// Range of a cell's side, in points: below the smallest the matrix scrolls.
const CELL_RANGE: std::ops::RangeInclusive<f32> = 7.0..=64.0;
/// Minimum side of cells with a number, and of those with names beside rows and columns.
const CELL_WITH_NUMBER: f32 = 22.0;
const CELL_WITH_NAMES: f32 = 11.0;
const NAMES_WIDTH: f32 = 96.0;
/// Space for the names of columns, which are written upwards, in points.
const HEAD_HEIGHT: f32 = 72.0;

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grid {
    origin: Pos2,
    cell: f32,
    count: usize,
}

impl Grid {
    pub fn cell_at(&self, pos: Pos2) -> Option<(usize, usize)> {
        let at = |x: f32, origin: f32| {
            let place = ((x - origin) / self.cell).floor();
            (place >= 0.0 && place < self.count as f32).then_some(place as usize)
        };
        Some((at(pos.y, self.origin.y)?, at(pos.x, self.origin.x)?))
    }

    pub fn cell(&self, row: usize, column: usize) -> Rect {
        let corner = self.origin + self.cell * vec2(column as f32, row as f32);
        Rect::from_min_size(corner, egui::Vec2::splat(self.cell))
    }
}

/// Draws the matrix. A click selects a pair; returns the double-clicked pair, which is to be opened.
pub fn matrix_ui(ui: &mut Ui, dataset: &Dataset, set: &DatasetChoice, queue: &mut Queue) -> Option<BurstPair> {
    let count = dataset.bursts.len();
    let room = ui.available_size() - vec2(12.0 + NAMES_WIDTH, 12.0 + HEAD_HEIGHT);
    let cell = (room.min_elem() / count.max(1) as f32).floor().clamp(*CELL_RANGE.start(), *CELL_RANGE.end());
    let side = count as f32 * cell;
    let mut opened = None;
    egui::ScrollArea::both().auto_shrink(false).show(ui, |ui| {
        let (rect, response) = ui.allocate_exact_size(vec2(NAMES_WIDTH + side, HEAD_HEIGHT + side), Sense::click());
        let grid = Grid { origin: rect.min + vec2(NAMES_WIDTH, HEAD_HEIGHT), cell, count };
        let pointed = response.hover_pos().and_then(|pos| grid.cell_at(pos));
        draw(ui, dataset, set, &grid, pointed);
        if let Some(pair) = pointed.and_then(|(row, column)| pair_of(row, column)) {
            queue.push_if(response.clicked(), Action::SelectPair(pair));
            opened = response.double_clicked().then_some(pair);
        }
        move_selection(ui, dataset, set, &response, queue);
        let text = set.selected().map_or_else(String::new, |pair| pair_text(dataset, pair));
        // The matrix is one widget, whose value for screen readers is the selected pair.
        response.widget_info(|| egui::WidgetInfo {
            current_text_value: Some(text.clone()),
            ..egui::WidgetInfo::labeled(egui::Role::Image, true, "Match matrix")
        });
        if let Some((row, column)) = pointed {
            let text = match pair_of(row, column) {
                Some(pair) => format!("{}\nClick to select, click twice to open", pair_text(dataset, pair)),
                None => format!("{}\n{}", dataset.bursts[row].name, dataset.states[row].sentence()),
            };
            response.on_hover_text_at_pointer(text);
        }
    });
    opened
}

/// Moves the selection with the arrow keys while the matrix has the keyboard focus.
fn move_selection(ui: &Ui, dataset: &Dataset, set: &DatasetChoice, response: &Response, queue: &mut Queue) {
    if response.clicked() {
        response.request_focus();
    }
    if !response.has_focus() {
        return;
    }
    let Some((row, column)) = set.selected() else { return };
    // Without this lock the arrow keys would move the focus to another widget.
    ui.memory_mut(|m| {
        let keys = egui::EventFilter { horizontal_arrows: true, vertical_arrows: true, ..Default::default() };
        m.set_focus_lock_filter(response.id, keys);
    });
    let last = dataset.bursts.len() - 1;
    let moved = ui.input_mut(|i| {
        let mut step = |key| i.count_and_consume_key(egui::Modifiers::NONE, key) as isize;
        let down = step(egui::Key::ArrowDown) - step(egui::Key::ArrowUp);
        let right = step(egui::Key::ArrowRight) - step(egui::Key::ArrowLeft);
        (row.saturating_add_signed(down).min(last), column.saturating_add_signed(right).min(last))
    });
    // The selection is above the diagonal; it stops there.
    queue.push_if(moved.0 < moved.1 && moved != (row, column), Action::SelectPair(moved));
}

pub fn pair_text(dataset: &Dataset, pair: BurstPair) -> String {
    let name = |place: usize| dataset.bursts.get(place).map_or("?", |b| b.name.as_str());
    let names = format!("{} – {}", name(pair.0), name(pair.1));
    let Some(counts) = dataset.matches.counts.get(&pair) else { return format!("{names}\nnot matched yet") };
    let share = |x: Option<f64>| x.map_or("–".to_owned(), |x| format!("{x:.3}"));
    let inliers = match (counts.inliers, counts.refused) {
        (_, Some(reason)) => format!("refused: {}", reason.words()),
        (None, None) => "not verified".to_owned(),
        (Some(inliers), None) => counted(inliers, "inlier"),
    };
    let (putative, ratio) = (counted(counts.putative, "putative match"), counts.match_ratio());
    let [score, inlier_ratio] = [counts.match_score(), counts.inlier_ratio()].map(share);
    format!("{names}\n{putative}, {inliers}\nmatch ratio {ratio:.3}, match score {score}, inlier ratio {inlier_ratio}")
}

/// Colours of counts, uniform in lightness. The square root makes small counts visible beside large ones.
pub struct CountColours {
    table: [[u8; 3]; 256],
    most: usize,
}

impl CountColours {
    pub fn new(most: usize) -> Self {
        Self { table: ColourMap::Viridis.lut(), most: most.max(1) }
    }

    pub fn of(&self, count: usize) -> (Color32, Color32) {
        let share = (count as f32 / self.most as f32).clamp(0.0, 1.0).sqrt();
        let text = if share > 0.62 { Color32::BLACK } else { Color32::WHITE };
        (rgb(self.table[(255.0 * share).round() as usize]), text)
    }
}

pub fn legend_ui(ui: &mut Ui, most: usize) {
    const STEPS: usize = 48;
    ui.label(RichText::new("inliers   0").small().weak());
    let (rect, response) = ui.allocate_exact_size(vec2(160.0, 8.0), Sense::hover());
    // The bar's colours are uniform; the counts along it grow with the square.
    let colours = ColourMap::Viridis.lut();
    strip_of_colours(ui.painter(), rect, STEPS, |step, _| rgb(colours[255 * step / (STEPS - 1)]));
    ui.label(RichText::new(most.to_string()).small().weak());
    response.on_hover_text("Inliers of a pair; the colour grows with the square root of their number");
}

fn draw(ui: &Ui, dataset: &Dataset, set: &DatasetChoice, grid: &Grid, pointed: Option<(usize, usize)>) {
    let painter = ui.painter();
    let visuals = ui.visuals();
    let colours = CountColours::new(dataset.matches.strongest());
    let visible = ui.clip_rect();
    let font = FontId::proportional((0.36 * grid.cell).clamp(9.0, 13.0));
    for row in 0..grid.count {
        // A long dataset has very many cells: rows out of view are skipped as a whole.
        if !visible.y_range().intersects(grid.cell(row, 0).y_range()) {
            continue;
        }
        for column in 0..grid.count {
            let rect = grid.cell(row, column);
            if !visible.intersects(rect) {
                continue;
            }
            let inner = if grid.cell > 12.0 { rect.shrink(0.5) } else { rect };
            let counts = pair_of(row, column).and_then(|pair| dataset.matches.counts.get(&pair));
            let shown = counts.map(PairTable::strength);
            let is_refused = counts.is_some_and(|counts| counts.refused.is_some());
            let empty = if row == column { visuals.extreme_bg_color } else { visuals.faint_bg_color };
            let (fill, text_colour) = shown.map_or((empty, visuals.weak_text_color()), |count| colours.of(count));
            painter.rect_filled(inner, 0.0, fill);
            // The diagonal holds the features of each burst.
            let number = shown.or(match &dataset.states[row] {
                BurstState::Done(finished) if row == column => Some(finished.features),
                _ => None,
            });
            if let Some(number) = number.filter(|_| grid.cell >= CELL_WITH_NUMBER) {
                // A burst without features is nothing to match.
                let text_colour = if row == column && number == 0 { style::warning(ui) } else { text_colour };
                let text = if is_refused { "×".to_owned() } else { number.to_string() };
                painter.text(rect.center(), Align2::CENTER_CENTER, text, font.clone(), text_colour);
            }
        }
    }
    names(ui, dataset, set, grid, pointed);
    // A pair has two cells, one on either side of the diagonal.
    let outline = |(row, column): (usize, usize), stroke: Stroke| {
        painter.rect_stroke(grid.cell(row, column), 0.0, stroke, StrokeKind::Middle);
        painter.rect_stroke(grid.cell(column, row), 0.0, stroke, StrokeKind::Middle);
    };
    if let Some(pair) = set.selected() {
        outline(pair, Stroke::new(2.0, visuals.strong_text_color()));
    }
    if let Some(cell) = pointed {
        outline(cell, Stroke::new(1.0, visuals.text_color()));
    }
}

/// Draws the bursts' names beside the rows and, upwards, above the columns; the hovered and selected ones stand out.
fn names(ui: &Ui, dataset: &Dataset, set: &DatasetChoice, grid: &Grid, pointed: Option<(usize, usize)>) {
    let (painter, visuals) = (ui.painter(), ui.visuals());
    let marked = |place: usize| {
        let of = |pair: Option<(usize, usize)>| pair.is_some_and(|(a, b)| a == place || b == place);
        of(pointed) || of(set.selected())
    };
    for (place, burst) in dataset.bursts.iter().enumerate() {
        let colour = match Side::BOTH.into_iter().find(|&side| set.pair[side] == Some(place)) {
            Some(side) => side_colour(side),
            None if marked(place) => visuals.strong_text_color(),
            None => visuals.weak_text_color(),
        };
        // Names of small cells would overlap: only those pointed at or selected are drawn.
        if grid.cell < CELL_WITH_NAMES && !marked(place) {
            continue;
        }
        let font = FontId::proportional(11.0);
        let row = grid.cell(place, 0);
        let room = Rect::from_min_max(pos2(row.left() - NAMES_WIDTH, row.top()), pos2(row.left() - 4.0, row.bottom()));
        let name = middle_elided(painter, &burst.name, &font, colour, room.width());
        let place_ui = pos2(room.right() - name.size().x, room.center().y - 0.5 * name.size().y);
        painter.with_clip_rect(room.expand2(vec2(0.0, 4.0)).intersect(ui.clip_rect())).galley(place_ui, name, colour);
        let column = grid.cell(0, place);
        let name = middle_elided(painter, &burst.name, &font, colour, HEAD_HEIGHT - 6.0);
        let foot = pos2(column.center().x - 0.5 * name.size().y, column.top() - 3.0);
        painter.add(TextShape::new(foot, name, colour).with_angle(-0.25 * std::f32::consts::TAU));
    }
}

pub fn pair_list_ui(ui: &mut Ui, dataset: &Dataset, set: &DatasetChoice, queue: &mut Queue) -> Option<BurstPair> {
    if dataset.matches.counts.is_empty() {
        instead_ui(ui, "Match pairs to see them here");
        return None;
    }
    // The table lists numbers: a pair is the place of its cell in the matrix.
    let count = dataset.bursts.len();
    let item = |(a, b): BurstPair| a * count + b;
    let pair_at = |item: usize| (item / count, item % count);
    let rows: Vec<usize> = dataset.matches.listed().into_iter().map(|(pair, _)| item(pair)).collect();
    let listed = Listed { items: &rows, selected: set.selected().map(item), hovered: None };
    let order = dataset.matches.order;
    let sorted_by = PairColumn::ALL.iter().position(|column| *column == order.column).unwrap_or_default();
    let names = |item: usize| {
        let (a, b) = pair_at(item);
        format!("{} – {}", dataset.bursts[a].name, dataset.bursts[b].name)
    };
    let text = |column: usize, item: usize| match (PairColumn::ALL[column], dataset.matches.counts.get(&pair_at(item)))
    {
        (PairColumn::Pair, _) => names(item),
        (column, counts) => counts.map_or_else(String::new, |counts| column.text(counts)),
    };
    let heading = |column: PairColumn| {
        let ([text, help], is_left) = (column.words(), column == PairColumn::Pair);
        let width = match column {
            PairColumn::Pair => 120.0,
            // Its heading is longer than its values.
            PairColumn::InlierRatio => 66.0,
            _ => 50.0,
        };
        Heading { text, help, width, is_exact: !is_left, is_left, ..Heading::default() }
    };
    let mut opened = None;
    ui.spacing_mut().item_spacing.x = 2.0;
    let (headings, name) = (PairColumn::ALL.map(heading), |item| format!("Pair {}", names(item)));
    let cells = texts(&headings, text);
    let sort = rows_ui(ui, &headings, Some((sorted_by, order.descending)), &listed, cells, name, |row, item| {
        queue.push_if(row.clicked(), Action::SelectPair(pair_at(item)));
        if row.double_clicked() {
            opened = Some(pair_at(item));
        }
    });
    sort.into_iter().for_each(|column| queue.push(Action::SortPairs(PairColumn::ALL[column])));
    opened
}
