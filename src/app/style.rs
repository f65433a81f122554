//! Style of the window: muted colours, small type and little spacing, so that most of the space is for the picture.

use super::view::with_minus;
use egui::style::{NumberFormatter, ScrollStyle, Widgets};
use egui::{Color32, CornerRadius, FontId, Stroke, Style, TextStyle, Theme, vec2};

/// Accent colour in both themes: a blue that is neither end of a diverging map.
pub const ACCENT: Color32 = Color32::from_rgb(0x2f, 0x7f, 0xd6);

/// Longest press that counts as a click.
const SLOWEST_CLICK_SECS: f64 = 10.0;

pub fn apply(ctx: &egui::Context) {
    ctx.all_styles_mut(common);
    // A long press is a click too: some users press for more than a second.
    ctx.options_mut(|options| options.input_options.max_click_duration = SLOWEST_CLICK_SECS);
    ctx.style_mut_of(Theme::Dark, dark);
    ctx.style_mut_of(Theme::Light, light);
}

pub fn warning(ui: &egui::Ui) -> Color32 {
    if ui.visuals().dark_mode { Color32::from_rgb(0xf2, 0xb1, 0x4b) } else { Color32::from_rgb(0x9a, 0x5b, 0x00) }
}

pub fn good(ui: &egui::Ui) -> Color32 {
    if ui.visuals().dark_mode { Color32::from_rgb(0x5c, 0xc8, 0x8a) } else { Color32::from_rgb(0x1b, 0x7f, 0x4b) }
}

fn common(style: &mut Style) {
    style.text_styles = [
        (TextStyle::Heading, FontId::proportional(16.0)),
        (TextStyle::Body, FontId::proportional(13.0)),
        (TextStyle::Button, FontId::proportional(13.0)),
        (TextStyle::Small, FontId::proportional(11.0)),
        (TextStyle::Monospace, FontId::monospace(12.0)),
    ]
    .into();
    numbers(style);
    style.spacing.item_spacing = vec2(6.0, 4.0);
    style.spacing.button_padding = vec2(7.0, 2.0);
    style.spacing.interact_size.y = 20.0;
    // Space is reserved for the scroll bar, so that it never covers a widget.
    style.spacing.scroll = ScrollStyle { floating_allocated_width: 9.0, ..ScrollStyle::floating() };
    style.spacing.combo_width = 60.0;
    let Widgets { noninteractive, inactive, hovered, active, open } = &mut style.visuals.widgets;
    for widget in [noninteractive, inactive, hovered, active, open] {
        widget.corner_radius = CornerRadius::same(4);
    }
    style.visuals.menu_corner_radius = CornerRadius::same(6);
    style.visuals.window_corner_radius = CornerRadius::same(8);
}

pub(in crate::app) fn numbers(style: &mut Style) {
    style.number_formatter =
        NumberFormatter::new(|value, decimals| with_minus(egui::emath::format_with_decimals_in_range(value, decimals)));
}

fn dark(style: &mut Style) {
    let visuals = &mut style.visuals;
    visuals.panel_fill = Color32::from_gray(30);
    visuals.window_fill = Color32::from_gray(36);
    visuals.faint_bg_color = Color32::from_gray(37);
    visuals.extreme_bg_color = Color32::from_gray(18);
    visuals.widgets.noninteractive.fg_stroke.color = Color32::from_gray(190);
    visuals.widgets.inactive.fg_stroke.color = Color32::from_gray(205);
    visuals.widgets.noninteractive.bg_stroke = Stroke::new(1.0, Color32::from_gray(52));
    visuals.selection.bg_fill = Color32::from_rgb(0x1f, 0x56, 0x92);
    visuals.selection.stroke = Stroke::new(1.0, Color32::from_rgb(0xdd, 0xec, 0xff));
    visuals.hyperlink_color = Color32::from_rgb(0x7a, 0xb5, 0xf5);
    visuals.error_fg_color = Color32::from_rgb(0xff, 0x7b, 0x72);
}

fn light(style: &mut Style) {
    let visuals = &mut style.visuals;
    visuals.panel_fill = Color32::from_gray(246);
    visuals.window_fill = Color32::from_gray(252);
    visuals.faint_bg_color = Color32::from_gray(238);
    visuals.widgets.noninteractive.fg_stroke.color = Color32::from_gray(56);
    visuals.widgets.inactive.fg_stroke.color = Color32::from_gray(44);
    visuals.widgets.noninteractive.bg_stroke = Stroke::new(1.0, Color32::from_gray(212));
    visuals.selection.bg_fill = Color32::from_rgb(0xb9, 0xd8, 0xf8);
    visuals.selection.stroke = Stroke::new(1.0, Color32::from_rgb(0x0b, 0x3a, 0x6b));
    visuals.hyperlink_color = ACCENT;
    visuals.error_fg_color = Color32::from_rgb(0xb4, 0x23, 0x18);
}
