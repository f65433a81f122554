//! Header above a pane's picture: number, description, links, and the drawn buttons that split and close the pane.

use super::menu::pane_menu_ui;
use super::widgets::{PaneWidgets, long_description, short_description};
use crate::app::actions::{ActionId, Queue};
use crate::app::document::panes::Change;
use crate::app::document::{Action, Panels, RangeClass, Visibility};
use crate::app::histogram::{ends_ui, ranges_ui};
use crate::app::pane::{Content, Direction, Link, MAX_PANES, PaneId};
use crate::app::{canvas, style};
use crate::app::{panel::display::features_shown_ui, panel::picture::PictureState};
use crate::app::{panel::tally::expected_ui, panel::widgets::named, results::Read};
use crate::inspect::words::capitalised;
use egui::{
    Align, Button, Frame, Label, Layout, Margin, Pos2, Rect, Response, RichText, Sense, Stroke, Ui, Vec2, vec2,
};

// Minimum widths of headers, in points: on one line (others have the links on a second one), with range and zoom, and
// with split buttons (others have them in the menu only).
const ONE_LINE: f32 = 440.0;
const ROOM_FOR_WORDS: f32 = 300.0;
const ROOM_FOR_NUMBERS: f32 = 560.0;
const ROOM_FOR_SPLITS: f32 = 190.0;
// The same of a single pane, whose header has no links: with range and zoom, with the features' switch, with all.
const ROOM_FOR_NUMBERS_ALONE: f32 = 400.0;
const ROOM_FOR_FEATURES: f32 = 620.0;
const ROOM_FOR_ALL: f32 = 800.0;

/// Draws the header of pane `id`; returns the response of its name, by which the pane is dragged.
pub fn header_ui(
    ui: &mut Ui,
    model: Read<'_>,
    id: PaneId,
    widgets: &mut PaneWidgets,
    queue: &mut Queue,
) -> Option<Response> {
    let mut name = None;
    let many = model.document.panes.are_many();
    let width = ui.available_width();
    let is_slice = matches!(model.pane(id).map(|pane| pane.content), Some(Content::Slice(_)));
    widgets.of(id).picture.refresh(model.drawn_in(id));
    let margin = if many { Margin::symmetric(4, 1) } else { Margin::symmetric(8, 3) };
    Frame::new().inner_margin(margin).fill(ui.visuals().panel_fill).show(ui, |ui| {
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = if many { 3.0 } else { 6.0 };
            // From the right: each part takes room from those after it, and the name is truncated to what is left.
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                buttons_ui(ui, model, id, width, queue);
                if many && width >= ONE_LINE {
                    links_ui(ui, model, id, true, width, queue);
                    // Keeps the links apart from the numbers.
                    ui.add_space(4.0);
                }
                ui.spacing_mut().item_spacing.x = 6.0;
                if !is_slice && width >= if many { ROOM_FOR_NUMBERS } else { ROOM_FOR_NUMBERS_ALONE } {
                    numbers_ui(ui, model, id, widgets, many || width >= ROOM_FOR_ALL, queue);
                }
                if !many || width >= ONE_LINE {
                    filter_chip_ui(ui, model, id, width, queue);
                }
                if !is_slice && (!many || width >= ONE_LINE) {
                    drawn_ui(ui, model, id, widgets, !many && width >= ROOM_FOR_FEATURES, queue);
                }
                if model.picture_in(id).is_some() && !model.is_current(id) && width >= ROOM_FOR_SPLITS {
                    ui.label(RichText::new("updating…").small().color(style::warning(ui)));
                }
                ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                    name = Some(name_ui(ui, model, id, width, many));
                });
            });
        });
        if many && width < ONE_LINE {
            ui.horizontal(|ui| {
                ui.spacing_mut().item_spacing.x = 2.0;
                links_ui(ui, model, id, false, width, queue);
                filter_chip_ui(ui, model, id, width, queue);
                if !is_slice {
                    drawn_ui(ui, model, id, widgets, false, queue);
                }
            });
        }
    });
    name
}

fn name_ui(ui: &mut Ui, model: Read<'_>, id: PaneId, width: f32, many: bool) -> Response {
    let long = long_description(model, id);
    // While the picture is being made, the short text describes the coming one.
    let text = if (many && width < ROOM_FOR_NUMBERS) || long.is_empty() {
        short_description(model, id, width < ROOM_FOR_SPLITS)
    } else {
        long.clone()
    };
    let number = model.document.panes.number(id).filter(|_| many);
    let text = number.map_or_else(String::new, |number| format!("{number}   ")) + &text;
    let sense = if many { Sense::click_and_drag() } else { Sense::click() };
    let label = ui.add(Label::new(RichText::new(&text).strong()).truncate().selectable(false).sense(sense));
    let label = label.on_hover_text(if many { format!("{long}\nDrag it to put this pane elsewhere") } else { long });
    if many { label.on_hover_cursor(egui::CursorIcon::Grab) } else { label }
}

/// Draws how many features are drawn in full of those in view, where there is room as a menu of which those are.
fn drawn_ui(ui: &mut Ui, model: Read<'_>, id: PaneId, widgets: &mut PaneWidgets, has_menu: bool, queue: &mut Queue) {
    let tip = "Drawn in full: the strongest of each part of the view. Zoom in for more, or choose View > All circles";
    let mut look = model.document.look.clone();
    let text = match widgets.of(id).picture.drawn_of {
        Some((_, in_view)) if look.draws_all => {
            let chip = ui.add(Button::new(RichText::new(format!("all {in_view} drawn ✖")).small()));
            let chip = chip.on_hover_text("All circles are drawn; a click draws the strongest alone");
            queue.push_if(chip.clicked(), ActionId::DrawAll);
            String::new()
        }
        Some((drawn, in_view)) if drawn < in_view => format!("{drawn} of {in_view} drawn"),
        _ => String::new(),
    };
    if has_menu && model.document.workspace.inspects() {
        let [choice, _] = look.overlay.words();
        let text = match &*text {
            "" => format!("Features: {} ⏷", choice.to_lowercase()),
            count => format!("{choice}: {count} ⏷"),
        };
        let menu = ui.menu_button(RichText::new(text).small(), |ui| {
            features_shown_ui(ui, &mut look.overlay, model, id);
            expected_ui(ui, model, queue);
        });
        menu.response.on_hover_text(tip);
        queue.set(&model.document.look, look, Action::SetLook);
    } else if !text.is_empty() {
        ui.weak(text).on_hover_text(tip);
    }
}

/// Draws what the features are filtered by, as long as they are; a click shows all.
fn filter_chip_ui(ui: &mut Ui, model: Read<'_>, id: PaneId, width: f32, queue: &mut Queue) {
    let Some(filter) = model.filter_of(id).filter(|filter| !filter.is_open()) else { return };
    let words = filter.words();
    let short = match &words[..] {
        [only] if width >= ROOM_FOR_NUMBERS_ALONE => format!(": {only}"),
        [first, rest @ ..] if width >= ROOM_FOR_NUMBERS_ALONE => format!(": {first} and {} more", rest.len()),
        _ => String::new(),
    };
    let noise = model.results.listed_decoys.as_ref().map(|report| format!(", {}", report.expected_words()));
    let noise = noise.unwrap_or_default();
    let more = if width < ROOM_FOR_ALL { "" } else { &noise };
    let text = RichText::new(format!("Filter{short}{more} ✖")).small().color(style::warning(ui));
    let chip = ui.add(Button::new(text).min_size(vec2(16.0, 16.0)));
    named(&chip, egui::Role::Button, "Show all features again");
    let count = format!("{} of {} features pass{noise}", model.results.listed.len(), model.features().len());
    let chip = chip.on_hover_text(format!("Filter: {}. {count}; a click shows all", words.join(", ")));
    queue.push_if(chip.clicked(), ActionId::ClearFilter);
}

/// Draws the zoom and the value range, as an icon where there is less room. Dragged sideways the range moves, up and
/// down it widens; a click opens its ends and the values that it can be set from.
fn numbers_ui(ui: &mut Ui, model: Read<'_>, id: PaneId, widgets: &mut PaneWidgets, has_range: bool, queue: &mut Queue) {
    let Some(pane) = model.pane(id) else { return };
    let percent = 100.0 * pane.view.points_per_pixel() * ui.ctx().pixels_per_point();
    ui.weak(format!("{percent:.0} %")).on_hover_text("Zoom: screen pixels per image pixel");
    let class = model.range_class(id);
    if class == RangeClass::Motion {
        return;
    }
    let number = model.document.panes.number(id).filter(|_| model.document.panes.are_many());
    let name = number.map_or_else(|| "Contrast".to_owned(), |number| format!("Contrast of pane {number}"));
    let tip = "Values drawn black and white. Drag sideways for brightness, up and down for contrast; click for numbers";
    let before = model.display_of(id);
    let mut display = before;
    let range = if has_range {
        let [min, max] = [display.min, display.max].map(|end| canvas::number(end, 3));
        let text = RichText::new(format!("{min} … {max}")).weak();
        let button = Button::new(text).frame_when_inactive(false).sense(Sense::click_and_drag());
        let button_ui = |ui: &mut Ui| {
            ui.spacing_mut().button_padding = vec2(2.0, 0.0);
            ui.add(button).on_hover_text(tip)
        };
        ui.scope(button_ui).inner
    } else {
        icon_button_ui(ui, Icon::Contrast, &name, tip, true)
    };
    named(&range, egui::Role::Button, &name);
    if range.dragged() {
        let [dx, dy] = (range.drag_delta() * 0.005).into();
        let (middle, half) = (0.5 * (display.min + display.max), 0.5 * (display.max - display.min) * (2.0 * dy).exp());
        let middle = if display.symmetric { 0.0 } else { middle - 2.0 * half * dx };
        display = display.with_range(middle - half, middle + half);
    }
    let PictureState { visible_image, .. } = widgets.of(id).picture;
    let picture = widgets.of(id).picture.shown.as_ref();
    egui::Popup::menu(&range).close_behavior(egui::PopupCloseBehavior::CloseOnClickOutside).show(|ui| {
        ends_ui(ui, &mut display);
        ranges_ui(ui, picture, visible_image, &mut display);
        if ui.button("Histogram, colours…").on_hover_text("Open the panel Display").clicked() {
            queue.push(Action::SetPanels(Panels { right: Visibility::Open, ..model.document.panels }));
            ui.close();
        }
    });
    if display != before {
        queue.push(Action::Focus(id));
        queue.push(Action::SetDisplay(class, display));
    }
}

/// Draws a switch for each link, in a very narrow pane by the word's first letter. From the right end of a line they
/// are drawn in reverse, so that their order stays.
fn links_ui(ui: &mut Ui, model: Read<'_>, id: PaneId, from_the_right: bool, width: f32, queue: &mut Queue) {
    let number = model.document.panes.number(id).unwrap_or(0);
    let mut links = Link::ALL;
    if from_the_right {
        links.reverse();
    }
    for link in links {
        let on = model.document.panes.has_link(id, link);
        let [label, help] = link.words();
        let word = capitalised(label.trim_start_matches("Link "));
        let text = RichText::new(if width >= ROOM_FOR_WORDS { &word } else { &word[..1] }).small();
        let button = Button::selectable(on, text).min_size(vec2(16.0, 16.0));
        ui.spacing_mut().button_padding = vec2(3.0, 0.0);
        let response = ui.add(button).on_hover_text(format!("{label}: {help}"));
        let name = format!("{label} of pane {number}");
        response.widget_info(|| egui::WidgetInfo::selected(egui::Role::Button, true, on, &name));
        queue.push_if(response.clicked(), Action::SetLink(id, link, !on));
    }
}

fn buttons_ui(ui: &mut Ui, model: Read<'_>, id: PaneId, width: f32, queue: &mut Queue) {
    ui.spacing_mut().item_spacing.x = 1.0;
    let many = model.document.panes.are_many();
    let of = model.document.panes.number(id).filter(|_| many).map_or_else(String::new, |number| format!(" {number}"));
    let (close, menu) = (format!("Close pane{of}"), format!("Menu of pane{of}"));
    let closes = many && icon_button_ui(ui, Icon::Close, &close, "Close this pane  (Ctrl+W)", true).clicked();
    queue.push_if(closes, Action::ChangePanes(Change::Close(id)));
    let menu = icon_button_ui(ui, Icon::Menu, &menu, "What this pane shows and shares; layouts", true);
    egui::Popup::menu(&menu).show(|ui| pane_menu_ui(ui, model, id, queue));
    // Keys and menu split a single pane.
    if width < ROOM_FOR_SPLITS || !many {
        return;
    }
    let room = model.document.panes.shown().len() < MAX_PANES;
    for (icon, direction, name, key) in [
        (Icon::SplitDown, Direction::Down, "Split down", "Shift+S"),
        (Icon::SplitRight, Direction::Right, "Split right", "S"),
    ] {
        let tip = format!("{name}: a second pane that shows the same to begin with  ({key})");
        let split = icon_button_ui(ui, icon, &format!("{name}{of}"), &tip, room);
        queue.push_if(split.clicked(), Action::ChangePanes(Change::Split(id, direction)));
    }
    ui.add_space(4.0);
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Icon {
    SplitRight,
    SplitDown,
    Contrast,
    Menu,
    Close,
}

pub const ICON_SIZE: Vec2 = vec2(20.0, 18.0);

pub fn icon_button_ui(ui: &mut Ui, icon: Icon, name: &str, tip: &str, enabled: bool) -> Response {
    let sense = if enabled { Sense::click() } else { Sense::hover() };
    let (rect, response) = ui.allocate_exact_size(ICON_SIZE, sense);
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, enabled, name));
    let is_lit = response.hovered() && enabled;
    if is_lit {
        ui.painter().rect_filled(rect, 4.0, ui.visuals().widgets.hovered.weak_bg_fill);
    }
    let colour = if is_lit { ui.visuals().strong_text_color() } else { ui.visuals().weak_text_color() };
    draw(ui, icon, rect, Stroke::new(1.0, colour));
    response.on_hover_text(tip)
}

fn draw(ui: &Ui, icon: Icon, rect: Rect, stroke: Stroke) {
    let painter = ui.painter();
    let frame = Rect::from_center_size(rect.center(), vec2(13.0, 11.0));
    let line = |from: Pos2, to: Pos2| painter.line_segment([from, to], stroke);
    if matches!(icon, Icon::SplitRight | Icon::SplitDown) {
        painter.rect_stroke(frame, 2.0, stroke, egui::StrokeKind::Inside);
    }
    match icon {
        Icon::SplitRight => _ = line(frame.center_top(), frame.center_bottom()),
        Icon::SplitDown => _ = line(frame.left_center(), frame.right_center()),
        Icon::Contrast => {
            let (centre, radius) = (rect.center(), 5.5);
            painter.circle_stroke(centre, radius, stroke);
            let half = (-6..=6).map(|step| centre + radius * Vec2::angled(step as f32 * std::f32::consts::PI / 12.0));
            painter.add(egui::Shape::convex_polygon(half.collect(), stroke.color, Stroke::NONE));
        }
        Icon::Menu => {
            for dy in [-3.5, 0.0, 3.5] {
                line(rect.center() + vec2(-5.0, dy), rect.center() + vec2(5.0, dy));
            }
        }
        Icon::Close => {
            for sign in [-1.0, 1.0] {
                line(rect.center() + vec2(-4.0, -4.0 * sign), rect.center() + vec2(4.0, 4.0 * sign));
            }
        }
    }
}
