//! Choice of features drawn in full and of lines of matches: the strongest, as many as each part of the view bears.
//!
//! In each cell ([`crate::export::Cells`]) the strongest [`IN_A_CELL`] are drawn, up to [`SEEN_IN_A_CELL`] as dots.

use super::{MatchLine, Pane};
use crate::app::canvas::RectTransform;
use crate::detector::feature::Feature;
use crate::export::{Cells, IN_A_CELL, MatchKind};
use egui::{Rect, pos2};

/// Number of features in a cell of which anything is drawn.
const SEEN_IN_A_CELL: u16 = 14;

fn cells(points_per_pixel: f32, view_image: Rect) -> Cells {
    Cells::new(points_per_pixel, [view_image.min.into(), view_image.max.into()])
}

#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Drawn {
    pub flags: Vec<bool>,
    /// Features in view that are drawn as dots, strongest first.
    pub dots: Vec<usize>,
    pub drawn: usize,
    pub in_view: usize,
}

/// Group of a drawn feature: the two groups take no place from each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Group {
    Own,
    Faint,
}

/// Chooses which of `features`, strongest first, are drawn in full: `always` ones, and the strongest of each cell.
pub fn drawn(
    features: &[Feature],
    group: impl Fn(usize) -> Option<Group>,
    ui_from_image: RectTransform,
    view_image: Rect,
    always: impl Fn(usize) -> bool,
) -> Drawn {
    let mut cells = [(); 2].map(|()| cells(ui_from_image.scale(), view_image));
    let mut out = Drawn { flags: vec![false; features.len()], ..Drawn::default() };
    for (i, feature) in features.iter().enumerate() {
        let Some(group) = group(i) else { continue };
        let place = pos2(feature.u, feature.v);
        // Features come strongest first: those already in the cell are stronger.
        let Some(stronger) = cells[group as usize].add(place.into()) else { continue };
        let is_drawn = stronger < IN_A_CELL || always(i);
        out.flags[i] = is_drawn;
        if view_image.contains(place) {
            out.in_view += 1;
            out.drawn += usize::from(is_drawn);
            if !is_drawn && stronger < SEEN_IN_A_CELL {
                out.dots.push(i);
            }
        }
    }
    out
}

/// Lines that are drawn, inliers first: `most`, or a few for each part of A's picture; and those that are `always`.
pub fn drawn_lines(
    lines: &[MatchLine],
    pane_a: &Pane,
    (are_vectors, most): (bool, Option<usize>),
    always: impl Fn(usize) -> bool,
) -> Vec<MatchLine> {
    let t = pane_a.ui_from_image;
    // Lines from picture to picture take more room than vectors.
    let (in_a_cell, scale) = if are_vectors { (3, t.scale()) } else { (1, 0.5 * t.scale()) };
    let mut cells = cells(scale, t.inverse().rect(pane_a.rect_ui));
    let mut numbers = 0..most.unwrap_or(0);
    let mut flags = vec![false; lines.len()];
    for is_inlier in [true, false] {
        for (flag, line) in flags.iter_mut().zip(lines).filter(|(_, l)| (l.kind == MatchKind::Inlier) == is_inlier) {
            let is_chosen = match most {
                Some(_) => numbers.next().is_some(),
                None => cells.add(line.a.into()).is_some_and(|before| before < in_a_cell),
            };
            *flag = is_chosen || always(line.index);
        }
    }
    lines.iter().zip(flags).filter(|(_, is_drawn)| *is_drawn).map(|(line, _)| *line).collect()
}

#[cfg(test)]
mod tests {
    use super::super::tests::feature;
    use super::*;
    use egui::vec2;

    fn crowd(count: usize) -> Vec<Feature> {
        let fraction = |i: usize, step: f32| (i as f32 * step).fract();
        let one = |i: usize| {
            let (u, v) = (fraction(i, 0.618_034), fraction(i, 0.754_878));
            let (u, v) = if i.is_multiple_of(3) { (0.4 + 0.2 * u, 0.4 + 0.2 * v) } else { (u, v) };
            feature(400.0 * u, 300.0 * v, 2.0, (0.0, 0.0), 1.0 / (1.0 + i as f32))
        };
        (0..count).map(one).collect()
    }

    fn view(corner: egui::Pos2, zoom: f32) -> (RectTransform, Rect) {
        let size = vec2(800.0, 600.0) / zoom;
        (RectTransform::new(corner, pos2(0.0, 0.0), zoom), Rect::from_min_size(corner, size))
    }

    fn strongest(features: &[Feature], corner: egui::Pos2, zoom: f32) -> Drawn {
        let (transform, rect) = view(corner, zoom);
        drawn(features, |_| Some(Group::Own), transform, rect, |_| false)
    }

    fn flags(features: &[Feature], corner: egui::Pos2, zoom: f32) -> Vec<bool> {
        strongest(features, corner, zoom).flags
    }

    #[test]
    fn a_view_bears_a_few_hundred_of_the_strongest_in_every_part() {
        let features = crowd(5000);
        let all = strongest(&features, pos2(0.0, 0.0), 2.0);
        assert!((100..600).contains(&all.drawn), "{}", all.drawn);
        assert_eq!(all.in_view, 5000);
        assert_eq!(all.drawn, all.flags.iter().filter(|flag| **flag).count());
        // Each quarter of the picture has some, and the strongest is there.
        for (u, v) in [(0.0, 0.0), (200.0, 0.0), (0.0, 150.0), (200.0, 150.0)] {
            let quarter = Rect::from_min_size(pos2(u, v), vec2(200.0, 150.0));
            let inside = |i: &usize| all.flags[*i] && quarter.contains(pos2(features[*i].u, features[*i].v));
            assert!((0..features.len()).filter(inside).count() > 20);
        }
        assert!(all.flags[0]);
        // Of the others a few in each part are dots.
        assert!(all.dots.iter().all(|i| !all.flags[*i]) && all.dots.len() > 2 * all.drawn);
        assert!(all.dots.len() < 3000, "{}", all.dots.len());
    }

    #[test]
    fn zooming_in_only_adds_and_panning_changes_nothing() {
        let features = crowd(3000);
        let mut before = flags(&features, pos2(0.0, 0.0), 0.5);
        for zoom in [0.7, 1.0, 1.3, 2.0, 3.9, 8.0, 30.0] {
            let here = flags(&features, pos2(0.0, 0.0), zoom);
            let seen = view(pos2(0.0, 0.0), zoom).1;
            for (i, feature) in features.iter().enumerate().filter(|(_, f)| seen.contains(pos2(f.u, f.v))) {
                assert!(here[i] || !before[i], "zoom {zoom}: ({}, {})", feature.u, feature.v);
            }
            before = here;
        }
        let corners = [pos2(20.0, 30.0), pos2(63.0, 47.0)];
        let [in_a, in_b] = corners.map(|corner| flags(&features, corner, 4.0));
        let [a, b] = corners.map(|corner| view(corner, 4.0).1);
        let is_in_both = |i: &usize| a.intersect(b).contains(pos2(features[*i].u, features[*i].v));
        let compared: Vec<usize> = (0..features.len()).filter(is_in_both).collect();
        assert!(compared.len() > 50 && compared.iter().all(|&i| in_a[i] == in_b[i]));
    }

    #[test]
    fn as_many_lines_are_drawn_as_are_asked_for_inliers_first() {
        let line = |index: usize| {
            let kind = if [0, 3, 6].contains(&index) { MatchKind::Inlier } else { MatchKind::Outlier };
            MatchLine { index, a: pos2(5.0, 5.0), b: pos2(9.0, 9.0), kind, colour: egui::Color32::WHITE }
        };
        let lines: Vec<MatchLine> = (0..9).map(line).collect();
        let (ui_from_image, rect_ui) = view(pos2(0.0, 0.0), 1.0);
        let drawn = |most, always: usize| -> Vec<usize> {
            let drawn = drawn_lines(&lines, &Pane { ui_from_image, rect_ui }, (false, most), |index| index == always);
            drawn.iter().map(|line| line.index).collect()
        };
        assert_eq!(drawn(Some(4), 99), [0, 1, 3, 6]);
        assert_eq!(drawn(Some(2), 8), [0, 3, 8]);
        assert_eq!((drawn(Some(20), 99).len(), drawn(None, 99)), (9, vec![0]));
    }

    #[test]
    fn some_are_drawn_whatever_stands_around_them_and_hidden_ones_take_no_place() {
        let features = crowd(5000);
        let (transform, rect) = view(pos2(0.0, 0.0), 1.0);
        let chosen = drawn(&features, |_| Some(Group::Own), transform, rect, |i| i == 4999);
        assert!(chosen.flags[4999] && !flags(&features, pos2(0.0, 0.0), 1.0)[4999]);
        let only_weak: Vec<bool> = (0..features.len()).map(|i| i >= 4900).collect();
        let weak = drawn(&features, |i| only_weak[i].then_some(Group::Own), transform, rect, |_| false);
        assert!(weak.drawn > 40 && weak.in_view == 100 && !weak.flags[0]);
        // Faint features and the others do not compete for room.
        let groups = |i: usize| Some(if only_weak[i] { Group::Faint } else { Group::Own });
        let both = drawn(&features, groups, transform, rect, |_| false);
        assert!((0..features.len()).filter(|&i| only_weak[i]).all(|i| both.flags[i] == weak.flags[i]));
    }

    #[test]
    fn odd_views_and_places_are_borne() {
        let mut features = crowd(100);
        features[3].u = f32::NAN;
        features[4].v = f32::INFINITY;
        features[5].u = -1e30;
        for zoom in [1e-9, 1e-3, 1.0, 1e4, 1e9] {
            assert_eq!(flags(&features, pos2(-1e5, 2e5), zoom).len(), 100);
        }
    }
}
