//! Display of the pictures: range, gamma, colour map and overlays. And in the corners of pictures: the colour bar of a
//! map, and legends, which a click folds to a small chip, and unfolds.

use crate::app::actions::{ActionId, Queue};
use crate::app::canvas::number;
use crate::app::canvas::overlay::{ColourBy, ColourScale, rgb};
use crate::app::document::look::SMOOTHING_PX;
use crate::app::document::{Action, FeaturesShown, Look, RangeClass};
use crate::app::inspector::{PaneWidget, PaneWidgets};
use crate::app::pane::PaneId;
use crate::app::panel::widgets::{choice_ui, hint, label_ui, named, section_ui, small_text, strip_of_colours};
use crate::app::results::Read;
use crate::plane::display::Display;
use crate::requests::line_of;
use egui::{
    Align2, Color32, Frame, Margin, Rect, RichText, Sense, Stroke, StrokeKind, TextStyle, Ui, UiBuilder, Vec2, pos2,
    vec2,
};

#[derive(Default)]
pub struct DisplayState([crate::app::histogram::HistogramPanel; RangeClass::Motion as usize + 1]);

pub fn display_ui(ui: &mut Ui, model: Read<'_>, widgets: &mut PaneWidgets, with_features: bool, queue: &mut Queue) {
    section_ui(ui, "Display", |ui| {
        range_ui(ui, model, model.document.focus(), widgets, queue);
        let mut look = model.document.look.clone();
        smoothing_ui(ui, &mut look);
        if with_features {
            ui.add_space(4.0);
            overlay_ui(ui, model, &mut look);
        }
        queue.set(&model.document.look, look, Action::SetLook);
        if !with_features {
            return;
        }
        ui.horizontal(|ui| {
            let label = label_ui(ui, "Colour by", 69.0);
            let choices = ColourBy::choices(model.document.set_up.reads_depths);
            let (width, mut by) = (Some(ui.available_width() - 6.0), model.document.colour_by);
            let is_chosen = choice_ui(ui, "colour by", label.id, width, &mut by, choices, ColourBy::name);
            queue.push_if(is_chosen, Action::ColourBy(by));
        });
    });
}

/// Value range, gamma and colours of the picture of pane `id`, with its histogram.
pub fn range_ui(ui: &mut Ui, model: Read<'_>, id: PaneId, widgets: &mut PaneWidgets, queue: &mut Queue) {
    let Some(pane) = model.pane(id) else { return };
    let PaneWidget { picture: pictures, display: state, .. } = widgets.of(id);
    pictures.refresh(model.drawn_in(id));
    let class = model.range_class(id);
    let whose = if pane.own_ranges.is_some() { "This pane's range for" } else { "One range for all" };
    ui.weak(format!("{whose} {}", class.label()))
        .on_hover_text("It stays fixed until you change it, so that pictures can be compared");
    if class == RangeClass::Motion {
        let motion = model.picture_in(id).and_then(|picture| picture.motion.as_ref());
        let is_line = motion.is_some_and(|motion| line_of(&motion.grid, model.features_of_motion(id)).is_some());
        let what = if is_line { "slope along the line of the motions" } else { "direction and length of the motion" };
        ui.add(egui::Label::new(format!("Colour: {what}; bright where it is certain")).wrap());
        return;
    }
    let mut display = model.document.ranges_of(pane).display(class);
    let is_set = state.0[class as usize].ui(ui, pictures.shown.as_ref(), pictures.visible_image, &mut display);
    queue.push_if(is_set, Action::SetDisplay(class, display));
}

fn smoothing_ui(ui: &mut Ui, look: &mut Look) {
    ui.horizontal(|ui| {
        let label = label_ui(ui, "Smoothing", 69.0);
        ui.spacing_mut().slider_width = (ui.available_width() - 66.0).max(40.0);
        let (least, most) = SMOOTHING_PX.span().into_inner();
        let (least, most) = (least as f32, most as f32);
        let slider = egui::Slider::new(&mut look.smoothing_px, least..=most).max_decimals(1).suffix(" px");
        let help = "σ of a Gaussian over the picture, to see through noise. Of the display only: values, profiles and \
                    features are not smoothed; the range follows";
        hint(ui.add(slider).labelled_by(label.id), help);
    });
}

fn overlay_ui(ui: &mut Ui, model: Read<'_>, look: &mut Look) {
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 6.0;
        ui.spacing_mut().icon_spacing = 3.0;
        let boxes = [
            (&mut look.motion_vectors, "Motion", "Each feature's motion over the burst (M)"),
            (&mut look.orientations, "Ticks", "Each feature's orientation (R)"),
            (&mut look.legend, "Legend", "What the colours mean (L)"),
        ];
        for (on, label, tip) in boxes {
            ui.checkbox(on, label).on_hover_text(tip);
        }
    });
    ui.horizontal(|ui| {
        label_ui(ui, "Features", 69.0);
        features_shown_ui(ui, &mut look.overlay, model, model.document.focus());
    });
}

/// Choice of the features that are drawn in pane `id`; over a picture without a slope of its own, those of all.
pub fn features_shown_ui(ui: &mut Ui, shown: &mut FeaturesShown, model: Read<'_>, id: PaneId) {
    let has_slope = model.picture_in(id).is_none() || model.slope_in_picture(id).is_some();
    for choice in FeaturesShown::ALL {
        let is_possible = has_slope || choice != FeaturesShown::ThisSlope;
        let is_shown = *shown == choice || (*shown == FeaturesShown::ThisSlope && choice == FeaturesShown::All);
        let is_lit = if has_slope { *shown == choice } else { is_possible && is_shown };
        let [label, help] = choice.words();
        let button = egui::Button::selectable(is_lit, RichText::new(label).small());
        let button = ui.add_enabled(is_possible, button).on_hover_text(format!("{help} (O)"));
        if button.on_disabled_hover_text("The picture is of no single slope: features of all are drawn").clicked() {
            *shown = choice;
        }
    }
}

/// Size of the key with its background, points.
const SIZE: Vec2 = vec2(196.0, 50.0);

/// Draws the colour bar of pane `id` over its picture in `rect`, if the picture is a map.
pub fn colour_bar_ui(ui: &mut Ui, model: Read<'_>, id: PaneId, rect: Rect) {
    let title = match model.range_class(id) {
        _ if !model.has_colour_bar(id) => return,
        RangeClass::Frame | RangeClass::Intensity | RangeClass::Response | RangeClass::Difference => return,
        RangeClass::Noise => "Noise (σ) of the response, of full scale",
        RangeClass::Share => "Share of the frames",
        RangeClass::Motion => return motion_key_ui(ui, model, id, rect),
    };
    if rect.width() < KEY_ROOM.x || rect.height() < KEY_ROOM.y {
        return;
    }
    let display = model.display_of(id);
    let background = Rect::from_min_size(rect.right_bottom() - SIZE - vec2(10.0, 10.0), SIZE);
    ui.painter().rect_filled(background, 5.0, ground(ui));
    let inner = background.shrink2(vec2(8.0, 5.0));
    let font = TextStyle::Small.resolve(ui.style());
    ui.painter().text(inner.left_top(), Align2::LEFT_TOP, title, font, ui.visuals().text_color());
    let bar = Rect::from_min_max(pos2(inner.left(), inner.top() + 14.0), pos2(inner.right(), inner.top() + 25.0));
    bar_ui(ui, bar, &display);
    let (low, high) = (number(display.min, 3), number(display.max, 3));
    small_text(ui, ui.painter(), inner.left_bottom(), Align2::LEFT_BOTTOM, &low);
    small_text(ui, ui.painter(), inner.right_bottom(), Align2::RIGHT_BOTTOM, &high);
    let response = ui.interact(background, ui.scope_id().with(("colour bar", id)), Sense::hover());
    let text = format!("Colour bar: {title}, from {low} to {high}");
    named(&response, egui::Role::Image, &text);
    response.on_hover_text(format!("{text}; change the range in the panel Display"));
}

fn motion_key_ui(ui: &mut Ui, model: Read<'_>, id: PaneId, rect: Rect) {
    let Some(scale) = motion_key(model, id, rect) else { return };
    let size = vec2(148.0, scale.height() + 12.0);
    let background = Rect::from_min_size(rect.right_bottom() - size - vec2(10.0, 10.0), size);
    ui.painter().rect_filled(background, 5.0, ground(ui));
    ui.scope_builder(UiBuilder::new().max_rect(background.shrink2(vec2(8.0, 6.0))), |ui| scale.legend_ui(ui));
}

pub fn bar_ui(ui: &Ui, bar: Rect, display: &Display) {
    const STEPS: usize = 96;
    let colours = display.colours();
    let value = |i: usize| display.min + (display.max - display.min) * (i as f32 + 0.5) / STEPS as f32;
    strip_of_colours(ui.painter(), bar, STEPS, |i, _| rgb(colours.colour(value(i))));
    ui.painter().rect_stroke(bar, 1.0, Stroke::new(1.0, ui.visuals().weak_text_color()), StrokeKind::Outside);
}

/// Draws a legend of `size` points, margins included, or its chip, in the corner `align`; a click folds or unfolds it.
pub fn legend_ui(
    ui: &mut Ui,
    model: Read<'_>,
    (align, rect_ui, size): (Align2, Rect, Vec2),
    queue: &mut Queue,
    add_contents: impl FnOnce(&mut Ui),
) {
    let is_open = model.document.look.legend;
    let rect = align.align_size_within_rect(if is_open { size } else { CHIP }, rect_ui.shrink(10.0));
    let response = ui.interact(rect, ui.scope_id().with("legend"), Sense::click());
    named(&response, egui::Role::Button, if is_open { "Fold the legend" } else { "Show the legend" });
    ui.scope_builder(UiBuilder::new().max_rect(rect), |ui| {
        ui.spacing_mut().item_spacing.y = 4.0;
        if is_open {
            Frame::new().fill(ground(ui)).corner_radius(5).inner_margin(Margin::symmetric(8, 6)).show(ui, |ui| {
                ui.set_width(ui.available_width());
                add_contents(ui);
            });
        } else {
            ui.painter().rect_filled(rect, 5.0, ground(ui));
            let (font, colour) = (TextStyle::Small.resolve(ui.style()), ui.visuals().text_color());
            ui.painter().text(rect.center(), Align2::CENTER_CENTER, "Legend", font, colour);
        }
    });
    let help = if is_open { "Colours of the features; click to fold (L)" } else { "Colours of the features (L)" };
    queue.push_if(response.on_hover_text(help).clicked(), ActionId::ToggleLegend);
}

/// Minimum size of a picture with a key of its own colours, in points.
pub const KEY_ROOM: Vec2 = vec2(430.0, 150.0);

/// Colours of the motions in the picture of pane `id`, drawn in `rect`, which a key in its corner explains.
pub fn motion_key(model: Read<'_>, id: PaneId, rect: Rect) -> Option<ColourScale> {
    let motion = model.picture_in(id)?.motion.as_ref()?;
    let has_room = rect.width() >= KEY_ROOM.x && rect.height() >= KEY_ROOM.y;
    has_room.then(|| ColourScale::of_slopes(&motion.grid, model.features_of_motion(id)))
}

const CHIP: Vec2 = vec2(62.0, 20.0);

pub fn ground(ui: &Ui) -> Color32 {
    if ui.visuals().dark_mode { Color32::from_black_alpha(190) } else { Color32::from_white_alpha(225) }
}
