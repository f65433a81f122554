//! Positions of the named parts of the window: the code that draws a part marks it in one line, and a lesson points at
//! it.

use crate::teach::Part;
use egui::{Context, Id, Rect, Ui, Vec2};
use std::collections::BTreeMap;

#[derive(Debug, Clone, Default)]
struct Parts {
    wanted: Vec<Part>,
    /// Step of the lesson that wants them.
    step: Option<usize>,
    /// Area in which a wanted part is scrolled to, and for how many passes still: what comes above or below it as the
    /// step is set up must not hide it. When the area changes it begins anew.
    scrolled_in: BTreeMap<Part, (Vec2, u8)>,
    pass: u64,
    drawn: BTreeMap<Part, Rect>,
}

const SCROLLED_PASSES: u8 = 30;

fn with<T>(ctx: &Context, use_parts: impl FnOnce(&mut Parts) -> T) -> T {
    ctx.data_mut(|data| use_parts(data.get_temp_mut_or_default(Id::unique("parts of the window"))))
}

pub fn mark(ui: &Ui, part: Part, rect: Rect) {
    let pass = ui.ctx().cumulative_pass_nr();
    let is_scrolled_by_user = ui.input(|input| input.smooth_scroll_delta != Vec2::ZERO);
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
        let (before, passes) = parts.scrolled_in.get(&part).copied().unwrap_or((Vec2::ZERO, 0));
        let passes = if before == area { passes } else { SCROLLED_PASSES };
        let left = if is_scrolled_by_user { 0 } else { passes.saturating_sub(1) };
        parts.scrolled_in.insert(part, (area, left));
        let is_whole = ui.clip_rect().top() <= rect.top() && rect.bottom() <= ui.clip_rect().bottom();
        passes > 0 && !is_scrolled_by_user && !is_whole
    });
    if scroll {
        ui.scroll_to_rect(rect, None);
    }
}

pub fn is_wanted(ctx: &Context, part: Part) -> bool {
    with(ctx, |parts| parts.wanted.contains(&part))
}

pub fn want(ctx: &Context, wanted: &[Part], step: Option<usize>) {
    with(ctx, |parts| {
        if parts.wanted != wanted || parts.step != step {
            (parts.wanted, parts.step) = (wanted.to_vec(), step);
            parts.scrolled_in.clear();
            parts.drawn.clear();
        }
    });
}

pub fn drawn(ctx: &Context) -> Vec<(Part, Rect)> {
    with(ctx, |parts| parts.drawn.iter().map(|(part, rect)| (*part, *rect)).collect())
}
