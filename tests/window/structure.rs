//! Structure of the drawn window as text: what is shown where, as screen readers are told it, and the greys of its
//! panes and plots. It does not depend on the graphics driver.

use crate::{greys::Greys, support::*};
use egui_kittest::Node;
use std::fmt::Write;

/// Maximum difference of a place from that in the file, points.
const TOLERANCE: f32 = 4.0;
/// Width and height of the smallest pane or plot whose greys are written, points.
const MIN_SIZE: [f32; 2] = [100.0, 60.0];
/// Word in place of a role in the lines of greys.
const GREYS: &str = "Greys";

/// Writes a line for each element in the window that has a text: its left, top, width and height in points, its role,
/// its text, and its value or state. Then follows a line for each pane and plot with its greys in `image`, the drawn
/// window.
pub fn structure_of(root: &Node<'_>, window: Rect, image: &RgbaImage) -> String {
    let (mut text, mut greys) = (String::new(), String::new());
    let pixels_per_point = image.width() as f32 / window.width();
    for node in root.children_recursive() {
        let element = node.accesskit_node();
        let (label, value) = (element.label().unwrap_or_default(), element.value().unwrap_or_default());
        let silent = label.is_empty() && value.is_empty() && element.toggled().is_none();
        // Runs of text repeat their labels.
        let is_part = element.role() == Role::TextRun;
        if silent || is_part || element.is_hidden() || element.bounding_box().is_none() {
            continue;
        }
        let rect = node.rect();
        if !window.intersects(rect) {
            continue;
        }
        let [x, y, w, h] = [rect.left(), rect.top(), rect.width(), rect.height()].map(f32::round);
        write!(text, "{x} {y} {w} {h} {:?}", element.role()).expect("memory");
        if !label.is_empty() {
            write!(text, " {label:?}").expect("memory");
        }
        if !value.is_empty() && value != label {
            write!(text, " = {value:?}").expect("memory");
        }
        if let Some(toggled) = element.toggled() {
            write!(text, " {toggled:?}").expect("memory");
        }
        if element.is_disabled() {
            text += " disabled";
        }
        text += "\n";
        let is_drawn = matches!(element.role(), Role::Canvas | Role::Image) && w >= MIN_SIZE[0] && h >= MIN_SIZE[1];
        if let Some(found) = is_drawn.then(|| Greys::of(image, rect * pixels_per_point)).flatten() {
            writeln!(greys, "{x} {y} {w} {h} {GREYS} {label:?} {}", found.words()).expect("memory");
        }
    }
    text + &greys
}

fn placed(line: &str) -> Option<([f32; 4], &str)> {
    let mut parts = line.splitn(5, ' ');
    let mut number = || parts.next()?.parse().ok();
    let place = [number()?, number()?, number()?, number()?];
    Some((place, parts.next()?))
}

/// Whether both lines say the same, except for a few points of the place and for what the greys may differ by.
fn is_same(a: &str, b: &str) -> bool {
    let (Some((place_a, what_a)), Some((place_b, what_b))) = (placed(a), placed(b)) else { return a == b };
    let is_same_thing = match (greys_in(what_a), greys_in(what_b)) {
        (Some((name_a, a)), Some((name_b, b))) => name_a == name_b && a.are_near(&b),
        _ => what_a == what_b,
    };
    is_same_thing && place_a.iter().zip(place_b).all(|(a, b)| (a - b).abs() <= TOLERANCE)
}

fn greys_in(what: &str) -> Option<(&str, Greys)> {
    what.starts_with(GREYS).then(|| Greys::read(what)).flatten()
}

/// Lines that only one of two structures has, or both at different places; `None` where there are none.
pub fn differences(expected: &str, shown: &str) -> Option<String> {
    let (expected, shown): (Vec<&str>, Vec<&str>) = (expected.lines().collect(), shown.lines().collect());
    if expected.len() == shown.len() && expected.iter().zip(&shown).all(|(a, b)| is_same(a, b)) {
        return None;
    }
    let lines = |of: &[&str], but: &[&str], sign: char| -> BTreeSet<String> {
        let gone = |line: &&&str| !but.iter().any(|other| is_same(line, other));
        of.iter().filter(gone).map(|line| format!("{sign} {line}\n")).collect()
    };
    let all: String = lines(&expected, &shown, '-').into_iter().chain(lines(&shown, &expected, '+')).collect();
    Some(if all.is_empty() { "the same elements in another order or number\n".to_owned() } else { all })
}

#[test]
fn structures_differ_by_texts_roles_states_and_places() {
    let expected = "0 0 40 20 Button \"Open…\"\n10 30 80 12 Slider \"Slope u\" = \"1.5\"\n";
    assert_eq!(differences(expected, expected), None);
    assert_eq!(differences(expected, &expected.replace("10 30", "12 27")), None, "a few points are no difference");
    for (from, to) in [("10 30", "10 38"), ("Button", "Label"), ("Open", "Save"), ("1.5", "2.5")] {
        let told = differences(expected, &expected.replace(from, to)).unwrap();
        assert!(told.starts_with("- ") && told.contains("\n+ ") && told.lines().count() == 2, "{told}");
    }
    assert!(differences(expected, "0 0 40 20 Button \"Open…\"\n").unwrap().starts_with("- 10 30"));
    assert!(differences("", expected).is_some());
    let turned: String = expected.lines().rev().map(|line| format!("{line}\n")).collect();
    assert!(differences(expected, &turned).is_some());
}

#[test]
fn structures_differ_by_greys_that_are_far_apart() {
    let line = |digit: char, percent: &str| {
        let row = String::from(digit).repeat(16);
        format!("300 80 680 417 Greys \"Picture\" {} {percent}\n", [row.as_str(); 10].join(" "))
    };
    let expected = line('4', "0 10 80 10 0 0 0 0");
    let one_cell = expected.replacen("4444", "9444", 1);
    for near in [expected.clone(), one_cell, line('4', "0 12 78 10 0 0 0 0"), expected.replace("300 80", "302 79")] {
        assert_eq!(differences(&expected, &near), None, "{near}");
    }
    let others = [line('6', "0 10 80 10 0 0 0 0"), line('4', "0 30 60 10 0 0 0 0"), line('0', "100 0 0 0 0 0 0 0")];
    for other in others.into_iter().chain([expected.replace("Picture", "Picture 2"), String::new()]) {
        let told = differences(&expected, &other).expect("another picture");
        assert!(told.starts_with("- 300 80 680 417 Greys"), "{told}");
    }
}
