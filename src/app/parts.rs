//! Where the named parts of the window are: whoever draws a part says so in one line, and a lesson points at it.

use crate::teach::Part;
use egui::{Context, Id, Rect, Ui};
use std::collections::BTreeMap;

/// What is pointed at, and where it was drawn.
#[derive(Debug, Clone, Default)]
struct Parts {
    wanted: Vec<Part>,
    /// Of these, those that are to be scrolled to.
    scroll_to: Vec<Part>,
    /// The pass in which they were drawn.
    pass: u64,
    drawn: BTreeMap<Part, Rect>,
}

fn with<T>(ctx: &Context, use_parts: impl FnOnce(&mut Parts) -> T) -> T {
    ctx.data_mut(|data| use_parts(data.get_temp_mut_or_default(Id::unique("parts of the window"))))
}

/// Says that `part` was drawn in `rect`. Scrolls to it, where it is one that was just asked for.
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
            // What is drawn in pieces is all of them.
            parts.drawn.entry(part).and_modify(|drawn| *drawn = drawn.union(seen)).or_insert(seen);
        }
        let place = parts.scroll_to.iter().position(|wanted| *wanted == part);
        place.map(|place| parts.scroll_to.remove(place)).is_some()
    });
    if scroll {
        ui.scroll_to_rect(rect, None);
    }
}

/// Says which parts are pointed at from now on; where they are not seen, they are scrolled to.
pub fn want(ctx: &Context, wanted: &[Part]) {
    with(ctx, |parts| {
        if parts.wanted != wanted {
            (parts.wanted, parts.scroll_to) = (wanted.to_vec(), wanted.to_vec());
            parts.drawn.clear();
        }
    });
}

/// The parts that are pointed at, with where they can be seen, as drawn last.
pub fn drawn(ctx: &Context) -> Vec<(Part, Rect)> {
    with(ctx, |parts| parts.drawn.iter().map(|(part, rect)| (*part, *rect)).collect())
}
