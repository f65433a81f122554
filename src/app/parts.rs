//! Positions of the named parts of the window: the code that draws a part marks it in one line, and a lesson points at
//! it.

use crate::teach::Part;
use egui::{Context, Id, Rect, Ui, Vec2};
use std::collections::BTreeMap;

#[derive(Debug, Clone, Default)]
struct Parts {
    wanted: Vec<Part>,
    /// Size of the area in which a wanted part was last scrolled to. It is scrolled to once, and again when that area
    /// changed: what opens below it must not hide it.
    scrolled_in: BTreeMap<Part, Vec2>,
    pass: u64,
    drawn: BTreeMap<Part, Rect>,
}

fn with<T>(ctx: &Context, use_parts: impl FnOnce(&mut Parts) -> T) -> T {
    ctx.data_mut(|data| use_parts(data.get_temp_mut_or_default(Id::unique("parts of the window"))))
}

pub fn mark(ui: &Ui, part: Part, rect: Rect) {
    let pass = ui.ctx().cumulative_pass_nr();
    let scroll = with(ui.ctx(), |parts| {
        if !parts.wanted.contains(&part) {
            return false;
        }
        if parts.pass != pass {
            (parts.pass, parts.drawn) = (pass, BTreeMap::new());
        }
        let seen = rect.intersect(ui.clip_rect());
        if seen.is_positive() {
            // A part that is drawn in pieces extends over all of them.
            parts.drawn.entry(part).and_modify(|drawn| *drawn = drawn.union(seen)).or_insert(seen);
        }
        let area = ui.clip_rect().size();
        parts.scrolled_in.insert(part, area) != Some(area)
    });
    if scroll {
        ui.scroll_to_rect(rect, None);
    }
}

pub fn is_wanted(ctx: &Context, part: Part) -> bool {
    with(ctx, |parts| parts.wanted.contains(&part))
}

pub fn want(ctx: &Context, wanted: &[Part]) {
    with(ctx, |parts| {
        if parts.wanted != wanted {
            parts.wanted = wanted.to_vec();
            parts.scrolled_in.clear();
            parts.drawn.clear();
        }
    });
}

pub fn drawn(ctx: &Context) -> Vec<(Part, Rect)> {
    with(ctx, |parts| parts.drawn.iter().map(|(part, rect)| (*part, *rect)).collect())
}
