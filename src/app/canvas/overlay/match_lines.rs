//! Match lines between features of two pictures: drawing, and finding the line under the pointer.
//!
//! Colours and dashes are those of [`MatchKind`]. A small ring marks an end whose other end is outside its pane.

use super::{RectTransform, Strokes};
use crate::app::view::nearest;
use crate::export::MatchKind;
use egui::{Color32, Painter, Pos2, Rect, Stroke};

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MatchLine {
    pub index: usize,
    pub a: Pos2,
    pub b: Pos2,
    pub kind: MatchKind,
    pub colour: Color32,
}

#[derive(Debug, Clone, Copy)]
pub struct Pane {
    pub ui_from_image: RectTransform,
    pub rect_ui: Rect,
}

#[derive(Debug, Clone, Copy, Default)]
pub struct MatchLineStyle {
    pub opacity: f32,
    pub selected: Option<usize>,
    pub hovered: Option<usize>,
    pub others_faint: bool,
    /// Whether only the ends in A are marked.
    pub are_vectors: bool,
}

const END_TOLERANCE_POINTS: f32 = 7.0;
const LINE_TOLERANCE_POINTS: f32 = 4.0;
const NEAR_POINTS: f32 = 60.0;
const WIDTH: f32 = 1.3;
/// Length of a dash and of the gap after it, in points.
const DASH: (f32, f32) = (6.0, 4.5);

impl MatchLine {
    fn ends(&self, panes: &[Pane; 2]) -> [(Pos2, bool); 2] {
        let end = |pane: &Pane, at: Pos2| {
            let pos = pane.ui_from_image.pos(at);
            (pos, pos.is_finite() && pane.rect_ui.contains(pos))
        };
        [end(&panes[0], self.a), end(&panes[1], self.b)]
    }

    pub fn is_near(&self, panes: &[Pane; 2], pos_ui: Pos2) -> bool {
        self.ends(panes).iter().any(|(end, seen)| *seen && end.distance(pos_ui) <= NEAR_POINTS)
    }
}

/// Draws `lines` from pane to pane. The painter must cover both panes.
pub fn draw_match_lines(painter: &Painter, panes: &[Pane; 2], lines: &[MatchLine], style: &MatchLineStyle) {
    let mut strokes = Strokes::new(painter.pixels_per_point());
    let lifted = |line: &MatchLine| [style.selected, style.hovered].contains(&Some(line.index));
    let opacity = style.opacity * if style.others_faint { 0.22 } else { 1.0 };
    // Outliers lie below: there may be many, and they matter less.
    for kind in [MatchKind::Outlier, MatchKind::Unverified, MatchKind::Inlier] {
        for line in lines.iter().filter(|line| line.kind == kind && !lifted(line)) {
            draw_one(&mut strokes, panes, line, style, Stroke::new(WIDTH, line.colour.gamma_multiply(opacity)));
        }
    }
    for line in lines.iter().filter(|line| lifted(line)) {
        let wide = if style.selected == Some(line.index) { 2.6 } else { 2.0 };
        // A dark and a white rim make the line stand out on any picture.
        for (extra, colour) in [(3.6, Color32::from_black_alpha(170)), (1.6, Color32::WHITE), (0.0, line.colour)] {
            draw_one(&mut strokes, panes, line, style, Stroke::new(wide + extra, colour));
        }
    }
    strokes.paint(painter);
}

fn draw_one(strokes: &mut Strokes, panes: &[Pane; 2], line: &MatchLine, style: &MatchLineStyle, stroke: Stroke) {
    let Stroke { width, color: colour } = stroke;
    let [(from, from_seen), (to, to_seen)] = line.ends(panes);
    // A line to an end out of sight would cross whatever lies beside the pane.
    if from_seen && to_seen {
        if line.kind.is_dashed() {
            strokes.dashed(from, to, width, colour, DASH);
        } else {
            strokes.line(from, to, width, colour);
        }
    }
    for (end, seen) in [(from, from_seen), (to, to_seen && !style.are_vectors)] {
        if seen {
            strokes.circle(end, 3.0, width, colour, false);
        }
    }
}

/// The line with the nearest end within a few points, otherwise the nearest line.
pub fn match_at(lines: &[MatchLine], panes: &[Pane; 2], pos_ui: Pos2) -> Option<usize> {
    let ends = lines.iter().flat_map(|line| line.ends(panes).map(|end| (end, line.index)));
    let seen = ends.filter(|((_, is_seen), _)| *is_seen);
    let at_end = nearest(seen.map(|((end, _), index)| (end.distance(pos_ui), index)), END_TOLERANCE_POINTS);
    at_end.or_else(|| {
        let whole = lines.iter().map(|line| (line.ends(panes), line.index));
        let whole = whole.filter(|(ends, _)| ends.iter().all(|(_, is_seen)| *is_seen));
        let apart = whole.map(|([from, to], index)| (distance_to_segment(pos_ui, from.0, to.0), index));
        nearest(apart, LINE_TOLERANCE_POINTS)
    })
}

fn distance_to_segment(pos: Pos2, from: Pos2, to: Pos2) -> f32 {
    let along = to - from;
    let t = ((pos - from).dot(along) / along.length_sq().max(1e-9)).clamp(0.0, 1.0);
    pos.distance(from + t * along)
}

#[cfg(test)]
mod tests {
    use super::super::colour_by::rgb;
    use super::*;
    use egui::{pos2, vec2};

    fn panes() -> [Pane; 2] {
        [0.0, 110.0].map(|left| Pane {
            ui_from_image: RectTransform::new(pos2(0.0, 0.0), pos2(left, 0.0), 1.0),
            rect_ui: Rect::from_min_size(pos2(left, 0.0), vec2(100.0, 100.0)),
        })
    }

    fn line(index: usize, a: (f32, f32), b: (f32, f32), kind: MatchKind) -> MatchLine {
        MatchLine { index, a: a.into(), b: b.into(), kind, colour: rgb(kind.color()) }
    }

    #[test]
    fn ends_are_hit_before_lines_and_lines_only_where_they_are() {
        let lines = [
            line(4, (10.0, 50.0), (90.0, 50.0), MatchKind::Inlier),
            line(7, (50.0, 53.0), (50.0, 90.0), MatchKind::Outlier),
        ];
        let at = |u: f32, v: f32| match_at(&lines, &panes(), pos2(u, v));
        assert_eq!(at(30.0, 51.0), Some(4));
        assert_eq!(at(50.0, 50.0), Some(7), "its end is near, the other's line is nearer");
        assert_eq!(at(198.0, 50.5), Some(4));
        assert_eq!(at(30.0, 60.0), None);
        // Of a line with one end out of sight only the other end is there.
        let lines = [line(0, (10.0, 10.0), (500.0, 10.0), MatchKind::Inlier)];
        assert_eq!(match_at(&lines, &panes(), pos2(12.0, 12.0)), Some(0));
        assert_eq!(match_at(&lines, &panes(), pos2(60.0, 10.0)), None);
    }
}
