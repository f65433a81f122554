//! Widgets that several panels share.

use crate::app::{memo::Itself, style};
use crate::monitor::Progress;
use crate::plane::Plane;
use crate::plane::display::{Display, to_rgba8};
use crate::requests::Running;
use egui::{
    Align, Button, Color32, ComboBox, Context, FontId, Galley, Id, Label, Layout, Mesh, Painter, ProgressBar, Rect,
    Response, RichText, Role, Sense, Shape, Stroke, TextureHandle, TextureId, TextureOptions, Ui, WidgetInfo,
    WidgetText, mutex::Mutex, pos2, vec2,
};
use egui_plot::Plot;
use std::sync::Arc;
use std::time::Duration;

pub fn section_ui(ui: &mut Ui, title: &str, add_contents: impl FnOnce(&mut Ui)) {
    egui::CollapsingHeader::new(RichText::new(title).strong()).default_open(true).show_unindented(ui, |ui| {
        ui.add_space(2.0);
        add_contents(ui);
        ui.add_space(4.0);
    });
}

/// Names a widget for screen readers and tests.
pub fn named(response: &Response, role: Role, name: impl AsRef<str>) {
    response.widget_info(|| WidgetInfo::labeled(role, true, name.as_ref()));
}

pub fn weak_ui(ui: &mut Ui, text: impl Into<RichText>) -> Response {
    ui.add(Label::new(text.into().weak()).wrap())
}

pub fn warning_ui(ui: &mut Ui, text: impl Into<RichText>) -> Response {
    ui.add(Label::new(text.into().color(style::warning(ui))).wrap())
}

pub fn error_ui(ui: &mut Ui, text: impl Into<RichText>) -> Response {
    ui.add(Label::new(text.into().color(ui.visuals().error_fg_color)).wrap())
}

/// Draws a weak text where there is nothing else to draw.
pub fn only_ui(ui: &mut Ui, text: &str) {
    ui.weak(text);
}

pub fn instead_ui(ui: &mut Ui, text: impl Into<String>) {
    ui.centered_and_justified(|ui| ui.weak(text.into()));
}

/// Draws a bar of progress, `width` points wide or as wide as there is room, with those parts of `text` that it holds.
pub fn progress_ui(ui: &mut Ui, running: &Running, width: Option<f32>, text: &str) {
    let fraction = running.progress.map_or(0.0, |p| p.fraction);
    let width = width.unwrap_or_else(|| ui.available_size_before_wrap().x.max(96.0));
    let bar = ProgressBar::new(fraction).desired_width(width).text(fitting(ui, text, width));
    ui.add(bar).on_hover_text(text);
}

/// The parts of `text`, which two spaces separate, that a bar of `width` points holds, the first ones first.
fn fitting(ui: &Ui, mut text: &str, width: f32) -> String {
    let room = width - 2.0 * ui.spacing().item_spacing.x;
    while let Some((shorter, _)) = text.rsplit_once("  ").filter(|_| text_width(ui, text) > room) {
        text = shorter.trim_end();
    }
    text.to_owned()
}

/// Draws a list that unfolds, `width` points wide or as its texts need. Returns whether a choice was clicked.
pub fn choice_ui<T: PartialEq + Copy>(
    ui: &mut Ui,
    id: &str,
    label: Id,
    width: Option<f32>,
    value: &mut T,
    choices: impl IntoIterator<Item = T>,
    name: impl Fn(T) -> &'static str,
) -> bool {
    // All choices are seen at once.
    let mut list = ComboBox::from_id_salt(id).selected_text(name(*value)).height(400.0);
    if let Some(width) = width {
        list = list.width(width).truncate();
    }
    let shown = list.show_ui(ui, |ui| {
        let mut is_clicked = |choice: &T| ui.selectable_value(value, *choice, name(*choice)).clicked();
        choices.into_iter().filter(|choice| is_clicked(choice)).count() > 0
    });
    shown.response.labelled_by(label);
    shown.inner.unwrap_or(false)
}

/// Draws a dialog over the window, `width` points wide, while it is `open`.
pub fn modal_ui(
    ctx: &Context,
    open: &mut bool,
    (id, width, heading): (&str, f32, &str),
    add_contents: impl FnOnce(&mut Ui),
) {
    if *open {
        let modal = egui::Modal::new(Id::unique(id)).show(ctx, |ui| {
            ui.set_width(width);
            ui.heading(heading);
            add_contents(ui);
        });
        *open = !modal.should_close();
    }
}

pub fn close_ui(ui: &mut Ui, text: &str) {
    if ui.button(text).clicked() {
        ui.close();
    }
}

/// Draws a dialog's last row: a button `verb`, enabled if it `is_ready`, whose response is returned, and one to close.
pub fn accept_ui(ui: &mut Ui, verb: &str, is_ready: bool) -> Response {
    let row = ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
        let accept = ui.add_enabled(is_ready, Button::new(verb));
        close_ui(ui, "Cancel");
        accept
    });
    row.inner
}

/// Asks whether to go on, by a button called `verb`. Returns the answer, once it is given.
pub fn confirm_ui(ctx: &Context, id: &str, heading: &str, verb: &str, texts: impl FnOnce(&mut Ui)) -> Option<bool> {
    let (mut goes_on, mut stays) = (false, true);
    modal_ui(ctx, &mut stays, (id, 420.0, heading), |ui| {
        ui.add_space(4.0);
        texts(ui);
        ui.add_space(6.0);
        goes_on = accept_ui(ui, verb, true).clicked();
    });
    (goes_on || !stays).then_some(goes_on)
}

/// Shows a tooltip at the pointer, over whatever is drawn there but an open menu.
pub fn tip_ui(ui: &Ui, id: &str, add_contents: impl FnOnce(&mut Ui)) {
    if egui::Popup::is_any_open(ui.ctx()) {
        return;
    }
    let (id, anchor) = (Id::unique(id), egui::PopupAnchor::Pointer);
    egui::Tooltip::always_open(ui.ctx().clone(), ui.layer_id(), id, anchor).gap(14.0).show(add_contents);
}

pub fn still_plot<'a>(id: impl std::hash::Hash + std::fmt::Debug) -> Plot<'a> {
    Plot::new(id).allow_zoom(false).allow_drag(false).allow_scroll(false)
}

pub fn paint(painter: &Painter, texture: TextureId, rect: Rect) {
    painter.image(texture, rect, Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0)), Color32::WHITE);
}

/// Textures of values, by the names under which these are drawn.
#[derive(Clone, Default)]
struct Textures(Arc<Mutex<std::collections::BTreeMap<String, Drawn>>>);

/// Origin of a texture, the texture, and the number of the pass that drew it last.
type Drawn = (PlaneKey, TextureHandle, u64);

/// Origin of values, the square of it that they show, and how they are shown, in the dark theme or in the light one.
type PlaneKey = (Itself, [f32; 4], Display, bool);

/// Number of passes for which a texture that is not drawn is kept.
const KEPT_PASSES: u64 = 600;

/// The square of values that are drawn whole.
pub const WHOLE: [f32; 4] = [0.0; 4];

/// Draws values into `rect` as sharp pixels. Their texture, kept under a `name` that is unique in the window, is made
/// anew when their origin, its square or `display` has changed. Without `values` the last one is drawn again.
pub fn draw_plane(
    ui: &Ui,
    (name, rect): (&str, Rect),
    display: Display,
    values: Option<(Itself, [f32; 4], impl FnOnce() -> Plane)>,
) {
    let id = Id::unique("textures of values");
    let textures = ui.data_mut(|data| data.get_temp_mut_or_default::<Textures>(id).clone());
    let (mut textures, pass) = (textures.0.lock(), ui.ctx().cumulative_pass_nr());
    textures.retain(|_, (.., last)| *last + KEPT_PASSES > pass);
    let dark = ui.visuals().dark_mode;
    let values = values.map(|(of, square, plane)| ((of, square, display, dark), plane));
    let is_right = |(key, _, last): &Drawn| values.as_ref().map_or(*last + 1 >= pass, |(wanted, _)| key == wanted);
    let kept = textures.remove(name).filter(is_right).map(|(key, texture, _)| (key, texture));
    let made = || values.map(|(key, plane)| (key, texture_of(ui, name, &plane(), &display)));
    if let Some((key, texture)) = kept.or_else(made) {
        paint(ui.painter(), texture.id(), rect);
        textures.insert(name.to_owned(), (key, texture, pass));
    }
}

/// Makes a texture of sharp pixels; NaN, as outside a picture, has the grey of the canvas's backdrop.
fn texture_of(ui: &Ui, name: &str, plane: &Plane, display: &Display) -> TextureHandle {
    let mut rgba = to_rgba8(plane, display);
    let beside = if ui.visuals().dark_mode { 20 } else { 206 };
    for (pixel, value) in rgba.pixels_mut().zip(plane.data()) {
        if value.is_nan() {
            pixel.0 = [beside, beside, beside, 255];
        }
    }
    let image = egui::ColorImage::from_rgba_unmultiplied(plane.size().into(), rgba.as_raw());
    ui.ctx().load_texture(name, image, TextureOptions::NEAREST)
}

/// Fills `rect` from left to right with `count` colours, by the index and the middle of each.
pub fn strip_of_colours(painter: &Painter, rect: Rect, count: usize, colour: impl Fn(usize, f32) -> Color32) {
    let mut mesh = Mesh::default();
    for i in 0..count {
        let x = |i: usize| rect.left() + rect.width() * i as f32 / count as f32;
        let part = Rect::from_x_y_ranges(x(i)..=x(i + 1), rect.y_range());
        mesh.add_colored_rect(part, colour(i, part.center().x));
    }
    painter.add(Shape::mesh(mesh));
}

pub fn small_text(ui: &Ui, painter: &Painter, pos_ui: egui::Pos2, align: egui::Align2, text: &str) {
    painter.text(pos_ui, align, text, egui::TextStyle::Small.resolve(ui.style()), ui.visuals().weak_text_color());
}

pub fn dashed_circle(painter: &Painter, centre: egui::Pos2, radius: f32, stroke: Stroke, (dash, gap): (f32, f32)) {
    let point = |i: u8| centre + radius * egui::Vec2::angled(f32::from(i) / 48.0 * std::f32::consts::TAU);
    painter.extend(Shape::dashed_line(&(0..=48).map(point).collect::<Vec<_>>(), stroke, dash, gap));
}

pub fn dots_ui(ui: &mut Ui, texts: impl IntoIterator<Item = (Color32, String)>) {
    ui.horizontal(|ui| {
        for (colour, text) in texts {
            dot_ui(ui, colour);
            ui.label(text);
        }
    });
}

/// Adds a tooltip that is hidden while its widget is dragged, so that it covers nothing then.
pub fn hint(response: Response, help: impl Into<WidgetText>) -> Response {
    if response.is_pointer_button_down_on() || response.dragged() { response } else { response.on_hover_text(help) }
}

pub fn progress_text(running: &Running) -> String {
    stage_text(running.progress, running.time_left())
}

/// Text in which spaces between digits do not break a line: "1 085" stays whole.
pub fn with_whole_numbers(text: &str) -> String {
    let chars: Vec<char> = text.chars().collect();
    let is_digit = |at: Option<usize>| at.and_then(|at| chars.get(at)).is_some_and(char::is_ascii_digit);
    let whole = |(at, &c): (usize, &char)| {
        let is_inside = c == ' ' && is_digit(at.checked_sub(1)) && is_digit(Some(at + 1));
        if is_inside { '\u{a0}' } else { c }
    };
    chars.iter().enumerate().map(whole).collect()
}

/// Time that work took, as " in 1.23 s"; nothing where it would be shown as zero, because the result was kept.
pub fn in_time(elapsed: Duration) -> String {
    if elapsed < Duration::from_millis(5) { String::new() } else { format!(" in {:.2} s", elapsed.as_secs_f32()) }
}

pub fn stage_text(progress: Option<Progress>, time_left: Option<Duration>) -> String {
    let Some(progress) = progress else { return "Starting".to_owned() };
    let left = time_left.map_or_else(String::new, |left| format!("  {}", time_left_text(left)));
    format!("{}  {:.0} %{left}", progress.stage, 100.0 * progress.fraction)
}

fn time_left_text(left: Duration) -> String {
    match left.as_secs_f32() {
        seconds if seconds < 60.0 => format!("about {:.0} s left", seconds.ceil().max(1.0)),
        seconds => format!("about {:.0} min left", (seconds / 60.0).ceil()),
    }
}

/// Lays out a text in one line of at most `width` points, without its middle if it is longer: names differ at the ends.
pub fn middle_elided(painter: &Painter, text: &str, font: &FontId, colour: Color32, width: f32) -> Arc<Galley> {
    let lay_out = |text: String| painter.layout_no_wrap(text, font.clone(), colour);
    let whole = lay_out(text.to_owned());
    if whole.size().x <= width {
        return whole;
    }
    let letters: Vec<char> = text.chars().collect();
    let shortened = |kept: usize| {
        // The end gets the larger half.
        let (head, tail) = (kept / 2, kept - kept / 2);
        letters[..head].iter().chain(&['…']).chain(&letters[letters.len() - tail..]).collect::<String>()
    };
    let (mut fits, mut too_many) = (0, letters.len());
    while too_many - fits > 1 {
        let kept = fits.midpoint(too_many);
        if lay_out(shortened(kept)).size().x <= width {
            fits = kept;
        } else {
            too_many = kept;
        }
    }
    lay_out(shortened(fits))
}

/// Width of a text in one line, points.
pub fn text_width(ui: &Ui, text: impl Into<WidgetText>) -> f32 {
    text.into().into_galley(ui, Some(egui::TextWrapMode::Extend), f32::INFINITY, egui::TextStyle::Body).size().x
}

pub fn label_ui(ui: &mut Ui, text: impl Into<WidgetText>, width: f32) -> Response {
    let size = vec2(width, ui.spacing().interact_size.y);
    ui.allocate_ui_with_layout(size, egui::Layout::left_to_right(egui::Align::Center), |ui| {
        ui.set_min_width(width);
        ui.add(egui::Label::new(text).truncate())
    })
    .inner
}

pub fn dot_ui(ui: &mut Ui, colour: Color32) {
    let (rect, _) = ui.allocate_exact_size(vec2(9.0, 12.0), Sense::hover());
    ui.painter().circle_filled(rect.center(), 4.0, colour);
}

/// Draws a row of a grid of two columns. A long value takes further lines, so that it widens neither grid nor panel.
pub fn number_row_ui(ui: &mut Ui, name: &str, help: &str, value: &str) {
    ui.label(RichText::new(name).weak()).on_hover_text(help);
    ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
        ui.add(Label::new(RichText::new(value).monospace()).selectable(true).wrap());
    });
    ui.end_row();
}

pub fn name_field(response: &Response, name: &str, text: &str) {
    let info = || WidgetInfo::text_edit(response.enabled(), text, text, name);
    response.widget_info(|| WidgetInfo { label: Some(name.to_owned()), ..info() });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bar_holds_whole_parts_of_its_text() {
        let text = "Search  45 %  about 1 s left";
        let mut output = Context::default().run_ui(egui::RawInput::default(), |ui| {
            let whole = text_width(ui, text) + 2.0 * ui.spacing().item_spacing.x;
            let held = [whole + 1.0, whole - 1.0, 1.0].map(|width| fitting(ui, text, width));
            assert_eq!(held, [text, "Search  45 %", "Search"]);
        });
        output.textures_delta.clear();
    }

    #[test]
    fn a_number_is_not_broken_over_lines_and_no_time_is_said_for_what_was_kept() {
        assert_eq!(with_whole_numbers("762 of 1 085 features"), "762 of 1\u{a0}085 features");
        assert_eq!(with_whole_numbers("at 3 px"), "at 3 px");
        assert_eq!(in_time(Duration::from_millis(1234)), " in 1.23 s");
        assert_eq!(in_time(Duration::from_micros(40)), "");
    }

    #[test]
    fn the_time_left_is_said_as_such() {
        assert_eq!(time_left_text(Duration::from_millis(3400)), "about 4 s left");
        assert_eq!(time_left_text(Duration::from_millis(10)), "about 1 s left");
        assert_eq!(time_left_text(Duration::from_secs(61)), "about 2 min left");
        let at = |fraction| Some(Progress { stage: crate::monitor::Stage::Describe, fraction });
        let left = Some(Duration::from_millis(10_400));
        assert_eq!(stage_text(at(0.5), left), "Describing features  50 %  about 11 s left");
        assert_eq!(stage_text(at(0.01), None), "Describing features  1 %", "too early to say");
        assert_eq!(stage_text(None, None), "Starting");
    }

    #[test]
    fn long_names_keep_both_ends() {
        let mut output = Context::default().run_ui(egui::RawInput::default(), |ui| {
            let font = FontId::proportional(11.0);
            let elided = |name: &str| middle_elided(ui.painter(), name, &font, Color32::WHITE, 60.0);
            assert_eq!(elided("night").text(), "night");
            let [a, b] = ["burst_of_the_night_0012", "burst_of_the_night_0013"].map(elided);
            assert!(a.size().x <= 60.0 && a.text().starts_with('b') && a.text().contains('…'), "{}", a.text());
            assert!(a.text() != b.text() && a.text().ends_with("12"), "{} {}", a.text(), b.text());
        });
        // Nothing that was laid out here is drawn.
        output.textures_delta.clear();
    }
}
