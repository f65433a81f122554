//! Law of all windows that the tests draw: no text and no control is cut off. Each lies inside the part of the window
//! that its panel clips to, or a scroll bar of that panel leads to it.

use crate::support::*;
use egui::{Id, Shape, WidgetRect, accesskit::NodeId};
use std::collections::{HashMap, HashSet};

/// Points by which a text may reach beyond its clip: rounding, and the descent of letters.
const TOLERANCE: f32 = 1.5;

struct Named {
    widget: WidgetRect,
    role: Role,
    text: String,
}

/// A line for each text and control of the window as last drawn that is cut off; empty where all can be seen or
/// scrolled to.
pub fn cut_off<State>(harness: &Harness<'_, State>) -> Vec<String> {
    let widgets: HashMap<Id, WidgetRect> = harness.ctx.viewport(|viewport| {
        let all = viewport.this_pass.widgets.layers().flat_map(|(_, widgets)| widgets);
        all.map(|widget| (widget.id, *widget)).collect()
    });
    let by_node: HashMap<NodeId, &WidgetRect> =
        widgets.iter().map(|(id, widget)| (id.accesskit_id(), widget)).collect();
    let root = harness.root();
    let named: Vec<Named> = root
        .children_recursive()
        .filter_map(|node| {
            let element = node.accesskit_node();
            let widget = **by_node.get(&element.locate().0)?;
            let text = [element.label(), element.value()].into_iter().flatten().collect::<Vec<_>>().join(" = ");
            Some(Named { widget, role: element.role(), text })
        })
        .collect();
    assert!(named.len() > 3, "the window has widgets");
    let bars: Vec<&WidgetRect> =
        named.iter().filter(|one| one.role == Role::ScrollBar).map(|one| &one.widget).collect();
    let ancestors = |widget: &WidgetRect| {
        let parent = |id: &Id| widgets.get(id).map(|widget| widget.parent_id).filter(|parent| parent != id);
        std::iter::successors(Some(widget.parent_id), parent).collect::<HashSet<Id>>()
    };
    let mut told = BTreeSet::new();
    for Named { widget, role, text } in &named {
        // Drawings have no letters of their own, and are clipped on purpose; a cell's letters are looked at by
        // themselves.
        let is_drawing = matches!(
            role,
            Role::Image | Role::Canvas | Role::GenericContainer | Role::ScrollBar | Role::TextRun | Role::Unknown
        );
        let is_there = widget.visible && widget.rect.is_finite() && widget.rect.width() > 0.0;
        if is_drawing || !is_there || text.is_empty() && !egui::accessibility::is_input(*role) {
            continue;
        }
        let (is_cut_x, is_cut_y) = cut(widget.rect, widget.interact_rect);
        // A cell of a table has its text in a label of its own.
        let holds = |one: &&Named| {
            one.role == Role::Label && one.widget.id != widget.id && widget.rect.contains_rect(one.widget.rect)
        };
        if (is_cut_x || is_cut_y) && matches!(role, Role::Row | Role::Button) && named.iter().any(|one| holds(&one)) {
            continue;
        }
        let above = ancestors(widget);
        let scrolls = |is_vertical: bool| {
            bars.iter()
                .any(|bar| above.contains(&bar.parent_id) && (bar.rect.height() > bar.rect.width()) == is_vertical)
        };
        for (is_cut, side) in [(is_cut_x && !scrolls(false), "beside"), (is_cut_y && !scrolls(true), "above or below")]
        {
            if is_cut {
                told.insert(format!(
                    "{role:?} {text:?} is cut {side}: {} of {}",
                    words(widget.interact_rect),
                    words(widget.rect)
                ));
            }
        }
    }
    for (text, rect, clip) in texts(harness) {
        let (is_cut_x, is_cut_y) = cut(rect, clip);
        if !clip.intersects(rect) || !(is_cut_x || is_cut_y) {
            continue;
        }
        // Texts of widgets are told above, and those that scroll with one are cut by its field.
        let is_of = |one: &&Named| {
            one.widget.rect.expand(TOLERANCE).contains_rect(rect)
                || matches!(one.role, Role::TextInput | Role::MultilineTextInput) && one.widget.rect.intersects(rect)
        };
        // Values in the pixels of a picture move with it, and its edge cuts them.
        let is_picture =
            |one: &Named| one.role == Role::Canvas && one.widget.rect.expand(TOLERANCE).contains_rect(clip);
        if named.iter().any(is_picture) {
            continue;
        }
        let of: Vec<&Named> = named.iter().filter(is_of).collect();
        let is_in_widget = of.iter().any(|one| !matches!(one.role, Role::Image | Role::Canvas | Role::Unknown));
        if !is_in_widget {
            told.insert(format!("text {text:?} is cut: {} of {}", words(clip.intersect(rect)), words(rect)));
        }
    }
    told.into_iter().collect()
}

fn cut(whole: Rect, part: Rect) -> (bool, bool) {
    let along =
        |whole: egui::Rangef, part: egui::Rangef| whole.min < part.min - TOLERANCE || whole.max > part.max + TOLERANCE;
    (along(whole.x_range(), part.x_range()), along(whole.y_range(), part.y_range()))
}

fn words(rect: Rect) -> String {
    let [left, top, right, bottom] = [rect.left(), rect.top(), rect.right(), rect.bottom()].map(f32::round);
    format!("x {left} … {right}, y {top} … {bottom}")
}

fn texts<State>(harness: &Harness<'_, State>) -> Vec<(String, Rect, Rect)> {
    fn add(shape: &Shape, clip: Rect, to: &mut Vec<(String, Rect, Rect)>) {
        match shape {
            Shape::Vec(shapes) => shapes.iter().for_each(|shape| add(shape, clip, to)),
            Shape::Text(text) if !text.galley.text().trim().is_empty() => {
                let rect = if text.angle == 0.0 {
                    text.galley.rect.translate(text.pos.to_vec2())
                } else {
                    text.visual_bounding_rect()
                };
                to.push((text.galley.text().to_owned(), rect, clip));
            }
            _ => {}
        }
    }
    let mut all = Vec::new();
    harness.output().shapes.iter().for_each(|clipped| add(&clipped.shape, clipped.clip_rect, &mut all));
    all
}

#[track_caller]
pub fn assert_none_cut_off<State>(harness: &Harness<'_, State>, of: &str) {
    let told = cut_off(harness);
    assert!(told.is_empty(), "{of}: these are cut off:\n{}", told.join("\n"));
}

#[test]
fn texts_and_controls_that_are_cut_are_told_and_those_to_scroll_to_are_not() {
    let told = |add: fn(&mut egui::Ui)| {
        let mut harness = Harness::builder().with_size([300.0, 200.0]).build_ui(add);
        harness.run_steps(3);
        cut_off(&harness)
    };
    let rows = |ui: &mut egui::Ui| (0..30).for_each(|i| drop(ui.label(format!("row {i}"))));
    assert_eq!(told(|ui| (0..5).for_each(|i| drop(ui.label(format!("row {i}"))))), Vec::<String>::new());
    let many = told(rows);
    assert!(many.iter().any(|line| line.contains("row 29")) && !many.iter().any(|line| line.contains("\"row 3\"")));
    let scrolled = |ui: &mut egui::Ui| {
        egui::ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            (0..30).for_each(|i| drop(ui.label(format!("row {i}"))));
        });
    };
    assert_eq!(told(scrolled), Vec::<String>::new());
    let wide = |ui: &mut egui::Ui| {
        egui::ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            (0..30).for_each(|i| drop(ui.label(format!("row {i}"))));
            ui.add(
                egui::Button::new("a button whose text is longer than its panel is wide")
                    .wrap_mode(egui::TextWrapMode::Extend),
            );
        });
    };
    assert_eq!(told(wide).len(), 1, "what scrolls up and down is still cut beside");
    let painted = |ui: &mut egui::Ui| {
        (0..4).for_each(|i| drop(ui.label(format!("row {i}"))));
        let (font, colour) = (egui::FontId::proportional(12.0), egui::Color32::WHITE);
        ui.painter().text(Pos2::new(290.0, 50.0), egui::Align2::LEFT_TOP, "a painted text", font, colour);
    };
    assert!(told(painted).iter().any(|line| line.contains("a painted text")));
}
