//! Comparing the window with its pictures in `screenshots/`.
//!
//! Beside `NAME.png` is `NAME.txt`: the roles, texts and places of all drawn elements, as given to screen readers. This
//! structure does not depend on the graphics driver, and is always compared. Pixels are compared on the driver that
//! made them, named in `driver.txt`; other drivers round edges differently.
//!
//! `UPDATE_SNAPSHOTS=1` rewrites both files of changed pictures; `UPDATE_SNAPSHOTS=force` rewrites all, and the name of
//! the driver.

use egui::Rect;
use egui::accesskit::Role;
use egui_kittest::kittest::NodeT;
use egui_kittest::{Harness, Node};
use std::collections::BTreeSet;
use std::fmt::Write;
use std::path::Path;
use std::sync::OnceLock;

/// Maximum difference of a place from that in the file, points.
const TOLERANCE: f32 = 4.0;

/// Driver on which this program draws.
static DRIVER: OnceLock<String> = OnceLock::new();

/// Notes the driver on which the program draws.
pub fn drawn_on(adapter: &wgpu::AdapterInfo) {
    DRIVER.get_or_init(|| format!("{}, {} {}", adapter.name, adapter.driver, adapter.driver_info));
}

/// Compares the window of `harness` with the picture `name`.
///
/// # Panics
/// When it differs, or when pictures of another driver were to be updated one by one.
#[track_caller]
pub fn compare<State>(harness: &mut Harness<'_, State>, name: &str) {
    let folder = &harness.options().output_path;
    let (structure, driver) = (folder.join(format!("{name}.txt")), folder.join("driver.txt"));
    let shown = structure_of(&harness.root(), harness.ctx.content_rect());
    let here = DRIVER.get().expect("each harness says on which driver it draws");
    let made_on = std::fs::read_to_string(&driver).unwrap_or_default();
    let is_same_driver = made_on.trim() == here;
    match std::env::var("UPDATE_SNAPSHOTS").as_deref() {
        Err(_) | Ok("0" | "false" | "no" | "off") => check_structure(&structure, &shown),
        Ok("force") => {
            write(&structure, &shown);
            write(&driver, &format!("{here}\n"));
            return harness.snapshot(name);
        }
        Ok(_) => {
            assert!(
                is_same_driver,
                "the pictures were made on '{}', and this is '{here}'; UPDATE_SNAPSHOTS=force makes all of them anew",
                made_on.trim()
            );
            if differences(&read(&structure), &shown).is_some() {
                write(&structure, &shown);
            }
        }
    }
    if is_same_driver {
        harness.snapshot(name);
    } else {
        println!("'{name}' is compared by its structure: it was made on '{}', and this is '{here}'", made_on.trim());
        // Also checks that the window can be drawn.
        harness.render().expect("it can be drawn");
    }
}

fn write(path: &Path, text: &str) {
    std::fs::write(path, text).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
}

/// Structure in the file; empty where there is none.
fn read(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_default()
}

#[track_caller]
fn check_structure(path: &Path, shown: &str) {
    let new = path.with_extension("new.txt");
    let _ = std::fs::remove_file(&new);
    if let Some(differences) = differences(&read(path), shown) {
        write(&new, shown);
        panic!(
            "{} differs from what is shown, {}:\n{differences}Run with UPDATE_SNAPSHOTS=1 to accept it.",
            path.display(),
            new.display()
        );
    }
}

/// Writes a line for each element in the window that has a text: its left, top, width and height in points, its role,
/// its text, and its value or state.
fn structure_of(root: &Node<'_>, window: Rect) -> String {
    let mut text = String::new();
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
    }
    text
}

/// Left, top, width and height, and the rest of the line.
fn placed(line: &str) -> Option<([f32; 4], &str)> {
    let mut parts = line.splitn(5, ' ');
    let mut number = || parts.next()?.parse().ok();
    let place = [number()?, number()?, number()?, number()?];
    Some((place, parts.next()?))
}

/// Lines that only one of two structures has, or both at different places; `None` where there are none.
fn differences(expected: &str, shown: &str) -> Option<String> {
    let is_same = |a: &str, b: &str| match (placed(a), placed(b)) {
        (Some((a, what_a)), Some((b, what_b))) => {
            what_a == what_b && a.iter().zip(b).all(|(a, b)| (a - b).abs() <= TOLERANCE)
        }
        _ => a == b,
    };
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
