//! Pairs of panes between which match lines are drawn: panes of A and of B that face each other, in any arrangement.

use crate::app::pane::{Content, PaneId};
use crate::app::project::Model;
use crate::app::project::method::Contender;
use crate::app::project::side::Side;
use egui::Rect;

/// Panes of one method, and the joined ones among them; as indices into the given places.
pub struct JoinedPanes {
    /// Panes of A and of B.
    pub sides: [Vec<usize>; 2],
    /// A pane of A and one of B that faces it.
    pub pairs: Vec<(usize, usize)>,
}

/// Finds the panes that show the input of `method` (those without a method, for `None`) among `places`: visible panes
/// and their rectangles. Differences and slices show no places of one burst.
pub fn joined_panes(model: &Model, places: &[(PaneId, Rect)], method: Option<Contender>) -> JoinedPanes {
    let is_of = |id: PaneId, side: Side| {
        let pane = model.panes.get(id).filter(|pane| pane.side == side && pane.method == method);
        pane.is_some_and(|pane| !matches!(pane.content, Content::Difference(..) | Content::Slice(_)))
    };
    let sides = Side::BOTH.map(|side| (0..places.len()).filter(|i| is_of(places[*i].0, side)).collect::<Vec<_>>());
    let rects = sides.each_ref().map(|side| side.iter().map(|place| places[*place].1).collect::<Vec<_>>());
    let all: Vec<Rect> = places.iter().map(|(_, rect)| *rect).collect();
    let pairs = joined(&rects[0], &rects[1], &all).into_iter().map(|(a, b)| (sides[0][a], sides[1][b])).collect();
    JoinedPanes { sides, pairs }
}

/// Pairs of `a` and `b` between which lines go, as indices; `all` are the canvases of all panes on the screen.
///
/// Two panes are joined where one faces the other with no third between them. Where A and B are farther apart, two
/// panes are joined when each is the nearest to the other.
fn joined(a: &[Rect], b: &[Rect], all: &[Rect]) -> Vec<(usize, usize)> {
    let nearest = |from: &Rect, to: &[Rect]| {
        let place = |i: &usize| apart(from, &to[*i]);
        (0..to.len()).min_by(|i, j| place(i).total_cmp(&place(j)))
    };
    let mut pairs = Vec::new();
    for (i, of_a) in a.iter().enumerate() {
        for (j, of_b) in b.iter().enumerate() {
            let each_nearest = nearest(of_a, b) == Some(j) && nearest(of_b, a) == Some(i);
            if each_nearest || face(of_a, of_b, all) {
                pairs.push((i, j));
            }
        }
    }
    pairs
}

/// Distance between two rectangles.
fn apart(a: &Rect, b: &Rect) -> f32 {
    let gap = |min: f32, max: f32| (min - max).max(0.0);
    let x = gap(b.left(), a.right()).max(gap(a.left(), b.right()));
    let y = gap(b.top(), a.bottom()).max(gap(a.top(), b.bottom()));
    x.hypot(y)
}

/// Whether two rectangles stand side by side or one above the other, with nothing between them.
fn face(a: &Rect, b: &Rect, all: &[Rect]) -> bool {
    let common = |a: egui::Rangef, b: egui::Rangef| egui::Rangef::new(a.min.max(b.min), a.max.min(b.max));
    let between = |a: egui::Rangef, b: egui::Rangef| egui::Rangef::new(a.max.min(b.max), a.min.max(b.min));
    let (x, y) = (common(a.x_range(), b.x_range()), common(a.y_range(), b.y_range()));
    let gap = match (x.span() > 0.0, y.span() > 0.0) {
        (false, true) => Rect::from_x_y_ranges(between(a.x_range(), b.x_range()), y),
        (true, false) => Rect::from_x_y_ranges(x, between(a.y_range(), b.y_range())),
        _ => return false,
    };
    let gap = gap.shrink(1.0);
    all.iter().all(|other| other == a || other == b || !(gap.is_positive() && other.intersects(gap)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::{pos2, vec2};

    /// Pane in a grid of panes of 100 × 80 points.
    fn at(column: usize, row: usize) -> Rect {
        Rect::from_min_size(pos2(104.0 * column as f32, 110.0 * row as f32), vec2(100.0, 80.0))
    }

    fn of(a: &[Rect], b: &[Rect], others: &[Rect]) -> Vec<(usize, usize)> {
        let all: Vec<Rect> = a.iter().chain(b).chain(others).copied().collect();
        joined(a, b, &all)
    }

    #[test]
    fn neighbours_are_joined_and_what_lies_behind_them_is_not() {
        assert_eq!(of(&[at(0, 0)], &[at(1, 0)], &[]), [(0, 0)]);
        assert_eq!(of(&[at(0, 0)], &[at(0, 1)], &[]), [(0, 0)], "one above the other");
        assert_eq!(of(&[at(0, 0), at(1, 0)], &[at(2, 0)], &[]), [(1, 0)], "A twice, B once");
        assert_eq!(of(&[at(0, 0), at(0, 1)], &[at(1, 0), at(1, 1)], &[]), [(0, 0), (1, 1)], "row by row");
        let tall = Rect::from_min_max(at(1, 0).min, at(1, 1).max);
        assert_eq!(of(&[at(0, 0), at(0, 1)], &[tall], &[]), [(0, 0), (1, 0)]);
    }

    #[test]
    fn those_far_apart_are_joined_all_the_same() {
        assert_eq!(of(&[at(0, 0)], &[at(2, 0)], &[at(1, 0)]), [(0, 0)], "a difference stands between them");
        assert_eq!(of(&[at(0, 0)], &[at(1, 1)], &[]), [(0, 0)], "across the corner");
        assert!(of(&[at(0, 0)], &[], &[]).is_empty());
    }
}
