//! Table of features with the filter above it, and the sorted table that other lists share: a click on a heading sorts,
//! a click on a row selects. Only the visible rows are drawn, so that a table can be long.

use crate::app::actions::{ActionId, Queue, button_ui};
use crate::app::document::filter::{at_slope, range_name, ranged, ranged_quantities};
use crate::app::document::{Action, Filter, Interval, Order, Pointed, Side};
use crate::app::inspector::feature_items_ui;
use crate::app::panel::widgets::{instead_ui, label_ui, named, text_width};
use crate::app::results::Read;
use crate::app::view::{KnownOfFeature, layer_text, quantity_text, shown_quantities};
use crate::app::words::{explained, word};
use crate::detector::{Moves, Quantity};
use crate::inspect::place::Verdict;
use egui::containers::menu::{MenuButton, MenuConfig};
use egui::{Align, Label, Layout, Response, RichText, Sense, Ui};
use egui_extras::{Column as TableColumn, TableBuilder};

impl SortedColumn for Quantity {
    fn look(self) -> Heading {
        let crate::detector::quantity::Record { heading, help, term, width, .. } = self.record();
        Heading { text: heading, help, term, width, ..Heading::default() }
    }
}

pub fn table_ui(ui: &mut Ui, model: Read<'_>, queue: &mut Queue) {
    if model.results.slots.a.found.is_none() {
        return instead_ui(ui, model.without_features(Side::A, "Press Detect to find features"));
    }
    let is_pointed_at = ui.rect_contains_pointer(ui.available_rect_before_wrap());
    let (items, hovered) = (&model.results.listed, model.results.hovered);
    let listed = Listed { items, selected: model.document.selected, hovered };
    let judged = model.judged().cloned();
    let text = |quantity, index: usize| {
        let feature = &model.features()[index];
        let judged = judged.as_ref().and_then(|judged| judged.get(index));
        quantity_text(quantity, index, feature, model.document.set_up.known(feature, judged))
    };
    let mut columns: Vec<Quantity> = shown_quantities(model.document.set_up.reads_depths).collect();
    if model.document.filter.near_slope.is_some() {
        // What decides on it stands together.
        let decides = |column: &Quantity| matches!(column, Quantity::FieldU | Quantity::FieldV | Quantity::Moves);
        let (of_place, others): (Vec<_>, Vec<_>) = columns.into_iter().partition(decides);
        let after = others.iter().position(|column| *column == Quantity::SlopeV).map_or(0, |place| place + 1);
        columns = [&others[..after], &of_place, &others[after..]].concat();
    }
    let menu = |ui: &mut Ui, index: usize| {
        model.features().get(index).into_iter().for_each(|feature| feature_items_ui(ui, feature, index, queue));
    };
    let name = |index: usize| format!("Feature {index}");
    let pointed = sorted_table_ui(ui, &columns, model.document.order, &listed, text, name, menu);
    queue.edit(model.document, Action::SetOrder(pointed.order));
    queue.edit(model.document, Action::Select(pointed.selected));
    // The pointer may be over a picture instead, which then sets the hovered feature.
    if is_pointed_at {
        queue.point(&model.results.hovered, pointed.hovered, Pointed::Feature);
    }
}

pub(in crate::app) const ROW_HEIGHT: f32 = 18.0;

pub(in crate::app) trait SortedColumn: Copy + PartialEq + 'static {
    fn look(self) -> Heading;
}

#[derive(Debug, Clone, Copy, Default)]
pub(in crate::app) struct Heading {
    pub text: &'static str,
    /// Description, with the unit; may be empty.
    pub help: &'static str,
    pub term: Option<&'static str>,
    /// Width that the texts need, points.
    pub width: f32,
    /// Whether the column has exactly this width; the others share the remaining space.
    pub is_exact: bool,
    /// Whether its texts stand at the left end of their cells, and not, as numbers do, at the right.
    pub is_left: bool,
}

/// Items that a table lists, by their indices.
pub(in crate::app) struct Listed<'a> {
    pub items: &'a [usize],
    pub selected: Option<usize>,
    pub hovered: Option<usize>,
}

pub(in crate::app) struct TableClicks<C> {
    /// Order, changed by a click on a heading.
    pub order: Order<C>,
    pub selected: Option<usize>,
    pub hovered: Option<usize>,
}

/// Draws a table that a click on a heading sorts; the first column has a fixed width. `text` is the content of an
/// item's cell, `name` the item's name for screen readers, and `menu` draws the menu of its row.
pub(in crate::app) fn sorted_table_ui<C: SortedColumn>(
    ui: &mut Ui,
    columns: &[C],
    order: Order<C>,
    listed: &Listed<'_>,
    text: impl Fn(C, usize) -> String,
    name: impl Fn(usize) -> String,
    mut menu: impl FnMut(&mut Ui, usize),
) -> TableClicks<C> {
    let mut pointed = TableClicks { order, selected: listed.selected, hovered: None };
    let mut headings: Vec<Heading> = columns.iter().map(|column| column.look()).collect();
    headings.iter_mut().take(1).for_each(|first| first.is_exact = true);
    let sorted_by = columns.iter().position(|column| *column == order.column).unwrap_or(columns.len());
    ui.spacing_mut().item_spacing.x = 4.0;
    egui::ScrollArea::horizontal().auto_shrink(false).show(ui, |ui| {
        let cells = texts(&headings, |column, index| text(columns[column], index));
        let clicked = rows_ui(ui, &headings, Some((sorted_by, order.descending)), listed, cells, name, |row, index| {
            row.context_menu(|ui| menu(ui, index));
            pointed.hovered = row.hovered().then_some(index).or(pointed.hovered);
            pointed.selected = row.clicked().then_some(index).or(pointed.selected);
        });
        if let Some(column) = clicked {
            pointed.order = order.clicked(columns[column]);
        }
    });
    pointed
}

pub(in crate::app) fn striped_table(ui: &mut Ui) -> TableBuilder<'_> {
    let table = TableBuilder::new(ui).striped(true).cell_layout(Layout::left_to_right(Align::Center));
    table.min_scrolled_height(0.0).auto_shrink(false)
}

/// Draws the cells of a table that hold a text each: that of a column and an item.
pub(in crate::app) fn texts(
    headings: &[Heading],
    text: impl Fn(usize, usize) -> String,
) -> impl FnMut(&mut Ui, usize, usize) {
    move |ui, column, item| cell_ui(ui, RichText::new(text(column, item)).monospace(), headings[column].is_left)
}

/// Draws a table. `sorted` is the column by which it is sorted and whether the largest come first; `None` for a table
/// that is in an order of its own. `contents_ui` draws the cell of a column and an item, `name` is the item's name for
/// screen readers, and `on_row` takes the response of its row. Returns the column whose heading was clicked.
pub(in crate::app) fn rows_ui(
    ui: &mut Ui,
    headings: &[Heading],
    sorted: Option<(usize, bool)>,
    listed: &Listed<'_>,
    mut contents_ui: impl FnMut(&mut Ui, usize, usize),
    name: impl Fn(usize) -> String,
    mut on_row: impl FnMut(&Response, usize),
) -> Option<usize> {
    let &Listed { items, selected, hovered } = listed;
    let scroll_id = ui.scope_id().with("scrolled to");
    let scrolled_to: Option<usize> = ui.data(|d| d.get_temp(scroll_id)).flatten();
    let (mut clicked, mut now_selected) = (None, selected);
    let mut table = striped_table(ui).sense(Sense::click());
    for &Heading { width, is_exact, .. } in headings {
        let rest = TableColumn::remainder().at_least(width);
        table = table.column(if is_exact { TableColumn::exact(width) } else { rest });
    }
    // Scrolls to the selection once, when it was made elsewhere.
    let selected_row = selected.and_then(|s| items.iter().position(|&item| item == s));
    if let Some(row) = selected_row.filter(|_| selected != scrolled_to) {
        table = table.scroll_to_row(row, None);
    }
    table
        .header(20.0, |mut header| {
            for (column, heading) in headings.iter().enumerate() {
                let sorted_here = sorted.filter(|(by, _)| *by == column);
                let arrow = sorted_here.map_or("", |(_, descending)| if descending { " ⏷" } else { " ⏶" });
                let text = RichText::new(format!("{}{arrow}", heading.text)).small();
                let text = if arrow.is_empty() { text } else { text.strong() };
                let (_, mut cell) = header.col(|ui| cell_ui(ui, text, heading.is_left));
                if sorted.is_some() {
                    named(&cell, egui::Role::Button, format!("Sort by {}", heading.text));
                }
                if !heading.help.is_empty() {
                    cell = explained(cell, heading.help, heading.term.and_then(word));
                }
                clicked = (sorted.is_some() && cell.clicked()).then_some(column).or(clicked);
            }
        })
        .body(|body| {
            body.rows(ROW_HEIGHT, items.len(), |mut row| {
                let item = items[row.index()];
                row.set_selected(selected == Some(item));
                row.set_hovered(hovered == Some(item));
                for column in 0..headings.len() {
                    row.col(|ui| contents_ui(ui, column, item));
                }
                let response = row.response();
                named(&response, egui::Role::Row, name(item));
                now_selected = response.clicked().then_some(item).or(now_selected);
                on_row(&response, item);
            });
        });
    ui.data_mut(|d| d.insert_temp(scroll_id, now_selected));
    clicked
}

/// Draws a text at the right end of its cell, or at the left. (The whole table cannot be laid out from the right: cells
/// would then take clicks of their neighbours.)
pub(in crate::app) fn cell_ui(ui: &mut Ui, text: RichText, is_left: bool) {
    let label = Label::new(text).selectable(false).extend();
    if is_left {
        ui.add(label);
    } else {
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| ui.add(label));
    }
}

pub fn filter_bar_ui(ui: &mut Ui, model: Read<'_>, queue: &mut Queue) {
    let (total, listed) = (model.features().len(), model.results.listed.len());
    if total == 0 {
        ui.weak(if model.results.slots.a.found.is_some() { "No feature was found" } else { "No features yet" });
        return;
    }
    let text = if listed == total { format!("{total}") } else { format!("{listed} of {total}") };
    // As wide as it gets, so that the filter's popup stays where it is.
    let width = text_width(ui, format!("{total} of {total}"));
    label_ui(ui, text, width).on_hover_text("Features that pass the filter");
    let title = if model.document.filter.is_open() { RichText::new("Filter") } else { RichText::new("Filter (on)") };
    // The popup stays open for several switches.
    let config = MenuConfig::new().close_behavior(egui::PopupCloseBehavior::CloseOnClickOutside);
    let mut filter = model.document.filter.clone();
    MenuButton::new(title).config(config).ui(ui, |ui| {
        ui.set_min_width(330.0);
        ranges_ui(ui, model, &mut filter);
        ui.separator();
        one_of_ui(ui, ("Verdict", Quantity::Verdict), &mut filter.verdict, "all", &Verdict::ALL, Verdict::word);
        one_of_ui(ui, ("Moves", Quantity::Moves), &mut filter.moves, "any way", &Moves::ALL, Moves::words);
        layers_ui(ui, model, &mut filter);
        ui.checkbox(&mut filter.hide_slope_limit, "Hide features at the slope limit")
            .on_hover_text("Their slope is at the end of the searched range, so their true motion may lie beyond it");
        near_slope_ui(ui, model, &mut filter);
        ui.separator();
        button_ui(ui, model, queue, ActionId::ClearFilter, None);
    });
    let mut near = filter.near_slope.is_some();
    if ui.checkbox(&mut near, "At this slope").on_hover_text(AT_SLOPE_HELP).changed() {
        filter.near_slope = near.then(|| model.near_slope());
    }
    if let Some(found) = model.found_of(Side::A).filter(|_| near) {
        let [all, own] = at_slope(&found.detection, model.document.cursor().slope);
        let tip = format!("{all} move with what is sharp here; {own} of all features also by their own slope");
        ui.weak(format!("{own} by their own slope")).on_hover_text(tip);
    }
    queue.edit(model.document, Action::SetFilter(filter));
    if !model.document.filter.is_open() {
        button_ui(ui, model, queue, ActionId::ClearFilter, None);
        crate::app::panel::tally::expected_ui(ui, model, queue);
    }
}

const AT_SLOPE_HELP: &str = "Show only features that move by the shown slope, as This slope does over the picture: with their surroundings (Field u, v) where they move with these, else by their own slope (Slope u, v)";

fn ranges_ui(ui: &mut Ui, model: Read<'_>, filter: &mut Filter) {
    let mut row = |ui: &mut Ui, quantity: Quantity| {
        let values = model.features().iter().filter_map(|feature| ranged(quantity, feature, KnownOfFeature::default()));
        // Coherences are known later.
        let ends = if quantity == Quantity::Coherence { (0.0, 1.0) } else { ends(values) };
        let mut interval = filter.ranges.get(&quantity).copied();
        range_ui(ui, quantity, ends, &mut interval);
        match interval {
            Some(interval) => _ = filter.ranges.insert(quantity, interval),
            None => _ = filter.ranges.remove(&quantity),
        }
    };
    use Quantity as Q;
    let usual = [Q::SlopeU, Q::SlopeV, Q::Sigma, Q::Response, Q::Snr, Q::Coherence];
    usual.into_iter().for_each(|quantity| row(ui, quantity));
    let others = ranged_quantities().filter(|quantity| !usual.contains(quantity));
    ui.collapsing("More ranges", |ui| others.for_each(|quantity| row(ui, quantity)));
}

fn one_of_ui<T: PartialEq + Copy>(
    ui: &mut Ui,
    (label, quantity): (&str, Quantity),
    chosen: &mut Option<T>,
    all: &'static str,
    values: &[T],
    word: fn(T) -> &'static str,
) {
    ui.horizontal_wrapped(|ui| {
        label_ui(ui, label, 70.0).on_hover_text(quantity.record().help);
        for value in std::iter::once(None).chain(values.iter().copied().map(Some)) {
            ui.selectable_value(chosen, value, value.map_or(all, word));
        }
    });
}

/// Draws a switch for each layer and for what is in none, with a button that shows it alone; nothing without a field.
fn layers_ui(ui: &mut Ui, model: Read<'_>, filter: &mut Filter) {
    let Some(field) = model.found_of(Side::A).and_then(|found| found.detection.field.as_ref()) else { return };
    ui.horizontal_top(|ui| {
        label_ui(ui, "Layers", 70.0).on_hover_text(Quantity::Layer.record().help);
        let names = (1..).zip(&field.layers).map(|(number, layer)| (number, layer_text(number, layer)));
        egui::ScrollArea::vertical().max_height(LAYERS_HEIGHT).show(ui, |ui| {
            ui.vertical(|ui| {
                for (number, name) in names.chain([(0, "no layer".to_owned())]) {
                    layer_ui(ui, filter, number, &name);
                }
            });
        });
    });
}

fn layer_ui(ui: &mut Ui, filter: &mut Filter, number: i32, name: &str) {
    ui.horizontal(|ui| {
        let is_alone = filter.solo_layer == Some(number);
        let solo = ui.selectable_label(is_alone, "solo");
        named(&solo, egui::Role::Button, format!("Solo {name}"));
        let tip =
            "Show it alone, over the picture, in the table and in the field of motion; again for those switched on";
        if solo.on_hover_text(tip).clicked() {
            filter.solo_layer = (!is_alone).then_some(number);
        }
        let mut is_on = !filter.hidden_layers.contains(&number);
        let tip = "Show or hide what moves with this layer: features, and places in the field of motion";
        let switch = ui.add_enabled(filter.solo_layer.is_none(), egui::Checkbox::new(&mut is_on, name));
        if switch.on_hover_text(tip).on_disabled_hover_text("One layer is shown alone: see solo").changed() {
            let hidden = &mut filter.hidden_layers;
            _ = if is_on { hidden.remove(&number) } else { hidden.insert(number) };
        }
    });
}

/// Maximum height of the list of layers, points.
const LAYERS_HEIGHT: f32 = 130.0;

fn ends(values: impl Iterator<Item = f32>) -> (f32, f32) {
    let finite = values.filter(|x| x.is_finite());
    finite.fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)))
}

/// Draws two handles over a range, that of the features' values; the whole range accepts all.
fn range_ui(ui: &mut Ui, quantity: Quantity, (low, high): (f32, f32), interval: &mut Option<Interval>) {
    ui.horizontal(|ui| {
        let name = label_ui(ui, range_name(quantity), 70.0);
        let name = name.on_hover_text(format!("{}. Features without a value pass", quantity.record().help));
        if high <= low {
            ui.weak("all the same");
            return;
        }
        let set = interval.unwrap_or(Interval { min: low, max: high });
        let (mut min, mut max) = (set.min, set.max);
        ui.spacing_mut().slider_width = 140.0;
        let text = |x: f64, _: std::ops::RangeInclusive<usize>| crate::app::canvas::number(x as f32, 4);
        ui.add(egui::RangeSlider::new(&mut min, &mut max, low..=high).custom_formatter(text)).labelled_by(name.id);
        // The slider rounds what it shows; only the pointer moves it further. A handle at its end accepts all beyond.
        let step = 0.002 * (high - low);
        if (min - set.min).abs() > step || (max - set.max).abs() > step {
            let min = if min - low <= step { low } else { min };
            let max = if high - max <= step { high } else { max };
            *interval = (min > low || max < high).then_some(Interval { min, max });
        }
    });
}

fn near_slope_ui(ui: &mut Ui, model: Read<'_>, filter: &mut Filter) {
    let mut near = filter.near_slope.is_some();
    ui.horizontal(|ui| {
        let switch = ui.checkbox(&mut near, "Only what moves by the shown slope, within");
        if switch.on_hover_text(AT_SLOPE_HELP).changed() {
            filter.near_slope = near.then(|| model.near_slope());
        }
        let mut limit = filter.near_slope.unwrap_or_else(|| model.near_slope());
        let field = egui::DragValue::new(&mut limit).range(0.0..=100.0).speed(0.01).suffix(" px/frame");
        let response = ui.add_enabled(near, field);
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::SpinButton, near, "Distance in slope"));
        if response.changed() {
            filter.near_slope = Some(limit);
        }
    });
}
