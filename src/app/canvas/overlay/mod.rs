//! Features over a picture: circles of true scale, orientation, motion over the burst; the one under the pointer.
//! The circle is the rim of the disc to which D responds most strongly at scale σ, dashed where the slope lies on the
//! rim of the searched grid. The arrow runs from the feature's place in the first frame to that in the last, with a fan
//! of its uncertainty. Features that only others have are dashed, with a line from the compared place.

mod colour_by;
mod density;
mod fans;
mod match_lines;
mod strokes;

pub use crate::app::view::ColourBy;
pub use colour_by::{ColourScale, UNKNOWN, rgb};
pub use density::{Drawn, Group, drawn, drawn_lines};
pub use fans::{add_fan, draw_field};
pub use match_lines::{MatchLine, MatchLineStyle, Pane, draw_match_lines, match_at};

use super::{CanvasOutput, RectTransform};
use crate::app::view::nearest;
use crate::burst::Positions;
use crate::detector::feature::Feature;
use crate::export::motion_over;
use egui::{Color32, Mesh, Pos2, Rect, Shape, Stroke, Vec2, pos2};
use strokes::{CROWD_WIDTH, Strokes};

#[derive(Debug, Clone, Copy)]
pub struct OverlayStyle<'a> {
    pub scale: &'a ColourScale,
    /// Positions of the frames that were used: the arrow spans them.
    pub positions: &'a Positions,
    /// Flag of each feature, `false` hides it; `None` shows all.
    pub shown: Option<&'a [bool]>,
    pub selected: Option<usize>,
    pub hovered: Option<usize>,
    pub stale: bool,
    pub circles: bool,
    pub orientations: bool,
    pub motion: bool,
}

impl<'a> OverlayStyle<'a> {
    pub fn new(scale: &'a ColourScale, positions: &'a Positions) -> Self {
        let (shown, selected, hovered, stale) = (None, None, None, false);
        let (circles, orientations, motion) = (true, true, true);
        Self { scale, positions, shown, selected, hovered, stale, circles, orientations, motion }
    }
}

fn is_shown(shown: Option<&[bool]>, i: usize) -> bool {
    shown.is_none_or(|flags| flags.get(i).copied().unwrap_or(true))
}

/// Maximum number of visible features with a dark edge around their lines; a larger crowd would only get darker.
const MAX_WITH_EDGE: usize = 1500;

const MIN_RADIUS_POINTS: f32 = 1.5;

const DOT_RADIUS_POINTS: f32 = 0.9;

pub fn draw_dots(output: &CanvasOutput, features: &[Feature], style: &OverlayStyle<'_>, dots: &[usize]) {
    let mut mesh = Mesh::default();
    for &i in dots {
        let colour = style.scale.colour(i, &features[i]).gamma_multiply(if style.stale { 0.3 } else { 0.6 });
        let centre = output.ui_from_image.pos(pos2(features[i].u, features[i].v));
        mesh.add_colored_rect(Rect::from_center_size(centre, Vec2::splat(2.0 * DOT_RADIUS_POINTS)), colour);
    }
    output.painter.add(Shape::mesh(mesh));
}

/// On one thread: waking others takes longer than the few hundred features that a view bears.
pub fn draw_features(output: &CanvasOutput, features: &[Feature], style: &OverlayStyle<'_>) {
    let is_seen = |i: &usize| is_shown(style.shown, *i) && is_visible(output, &features[*i], style.positions);
    let visible: Vec<usize> = (0..features.len()).filter(is_seen).collect();
    let opacity = if style.stale { 0.35 } else { 0.95 };
    let edges = visible.len() <= MAX_WITH_EDGE && !style.stale;
    let painter = &output.painter;
    let is_crowd = visible.len() > MAX_WITH_EDGE;
    let mut strokes = if is_crowd { Strokes::of_crowd(painter) } else { Strokes::new(painter.pixels_per_point()) };
    if style.motion && !style.stale {
        let coloured = visible.iter().map(|&i| (&features[i], style.scale.colour(i, &features[i])));
        fans::draw_fans(output, coloured, style.positions);
    }
    let edge = Color32::from_black_alpha(90);
    // All edges lie below all lines: none darkens the circle of a neighbour.
    for feature in visible.iter().filter(|_| edges).map(|&i| &features[i]) {
        draw_one(&mut strokes, output.ui_from_image, feature, style, Stroke::new(3.2, edge));
    }
    for &i in &visible {
        let colour = style.scale.colour(i, &features[i]).gamma_multiply(opacity);
        draw_one(&mut strokes, output.ui_from_image, &features[i], style, Stroke::new(CROWD_WIDTH, colour));
    }
    // The hovered and the selected feature lie above all others.
    for (highlight, width) in [(style.hovered, 2.0), (style.selected, 2.6)] {
        let shown = highlight.filter(|&i| is_shown(style.shown, i));
        let Some((index, feature)) = shown.and_then(|i| Some((i, features.get(i)?))) else { continue };
        for (extra, colour) in
            [(4.5, Color32::from_black_alpha(150)), (2.4, Color32::WHITE), (0.0, style.scale.colour(index, feature))]
        {
            draw_one(&mut strokes, output.ui_from_image, feature, style, Stroke::new(width + extra, colour));
        }
    }
    strokes.paint(&output.painter);
}

const MAX_ARROW_POINTS: f32 = 60.0;

fn draw_one(strokes: &mut Strokes, t: RectTransform, feature: &Feature, style: &OverlayStyle<'_>, line: Stroke) {
    let centre = t.pos(pos2(feature.u, feature.v));
    let radius = (feature.circle_radius_px() * t.scale()).max(MIN_RADIUS_POINTS);
    if style.motion {
        let mut ends = motion_over(feature, style.positions).map(|place| t.pos(place.into()));
        // Over a long burst only the part around its middle, so that arrows do not cover the picture.
        let part = MAX_ARROW_POINTS / ends[0].distance(ends[1]).max(MAX_ARROW_POINTS);
        ends.iter_mut().for_each(|end| *end = centre + part * (*end - centre));
        let [first, last] = ends;
        if first.distance(last) > 3.0 {
            strokes.arrow(first, last, 0.8 * line.width, line.color.gamma_multiply(0.85));
        }
    }
    if style.circles {
        strokes.circle(centre, radius, line.width, line.color, feature.at_slope_limit);
    }
    if style.orientations && radius > 4.0 {
        strokes.line(centre, centre + radius * egui::Vec2::angled(feature.orientation), line.width, line.color);
    }
}

fn is_visible(output: &CanvasOutput, feature: &Feature, positions: &Positions) -> bool {
    let [first, last] = motion_over(feature, positions).map(Pos2::from);
    let reach = feature.circle_radius_px() + 4.0 / output.ui_from_image.scale();
    let circle = Rect::from_center_size(pos2(feature.u, feature.v), Vec2::splat(2.0 * reach));
    // The arrow may be in view where the circle is not.
    let bounds = Rect::from_two_pos(first, last).union(circle);
    bounds.is_finite() && bounds.intersects(output.visible_image)
}

const TOLERANCE_POINTS: f32 = 7.0;

pub fn dot_at(features: &[Feature], dots: &[usize], ui_from_image: RectTransform, pos_ui: Pos2) -> Option<usize> {
    let distance = |i: usize| ui_from_image.pos(pos2(features[i].u, features[i].v)).distance(pos_ui);
    nearest(dots.iter().map(|&i| (distance(i), i)), TOLERANCE_POINTS)
}

/// The feature with the nearest centre or circle line within a few points; otherwise the smallest circle around.
pub fn feature_at(
    features: &[Feature],
    shown: Option<&[bool]>,
    ui_from_image: RectTransform,
    pos_ui: Pos2,
) -> Option<usize> {
    let mut near: Option<(f32, f32, usize)> = None;
    let mut around: Option<(f32, usize)> = None;
    for (i, feature) in features.iter().enumerate().filter(|&(i, _)| is_shown(shown, i)) {
        let distance = ui_from_image.pos(Pos2::new(feature.u, feature.v)).distance(pos_ui);
        let radius = feature.circle_radius_px() * ui_from_image.scale();
        if !(distance.is_finite() && radius.is_finite()) {
            continue;
        }
        let to_mark = distance.min((distance - radius).abs());
        if to_mark <= TOLERANCE_POINTS {
            // Of equally near ones, the smaller one is chosen, which is harder to hit.
            if near.is_none_or(|(d, r, _)| (to_mark, radius) < (d, r)) {
                near = Some((to_mark, radius, i));
            }
        } else if distance < radius && around.is_none_or(|(r, _)| radius < r) {
            around = Some((radius, i));
        }
    }
    near.map(|(_, _, i)| i).or(around.map(|(_, i)| i))
}

/// A circle at a place of the picture that is no feature of the shown detection, or not only one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CircleMark {
    pub pos_image: Pos2,
    /// Scale σ, image pixels.
    pub sigma: f32,
    /// Previous place of a feature that moved, image pixels; a line is drawn from it.
    pub from_image: Option<Pos2>,
    pub colour: Color32,
    pub dashed: bool,
}

impl CircleMark {
    fn radius_image(&self) -> f32 {
        std::f32::consts::SQRT_2 * self.sigma
    }
}

pub fn draw_circles(output: &CanvasOutput, marks: &[CircleMark], highlighted: Option<usize>) {
    let mut strokes = Strokes::new(output.painter.pixels_per_point());
    let is_seen = |mark: &&CircleMark| output.visible_image.expand(mark.radius_image()).contains(mark.pos_image);
    let seen: Vec<&CircleMark> = marks.iter().filter(is_seen).collect();
    // All edges lie below all marks: none covers the line of a neighbour.
    for mark in seen.iter().filter(|_| seen.len() <= MAX_WITH_EDGE) {
        draw_circle(&mut strokes, output, mark, 3.4, Color32::from_black_alpha(110));
    }
    for mark in &seen {
        draw_circle(&mut strokes, output, mark, 1.6, mark.colour);
    }
    if let Some(mark) = highlighted.and_then(|index| marks.get(index)) {
        for (width, colour) in [(7.0, Color32::from_black_alpha(150)), (5.0, Color32::WHITE), (2.6, mark.colour)] {
            draw_circle(&mut strokes, output, mark, width, colour);
        }
    }
    strokes.paint(&output.painter);
}

fn draw_circle(strokes: &mut Strokes, output: &CanvasOutput, mark: &CircleMark, width: f32, colour: Color32) {
    let t = output.ui_from_image;
    let centre = t.pos(mark.pos_image);
    let radius = (mark.radius_image() * t.scale()).max(MIN_RADIUS_POINTS);
    strokes.circle(centre, radius, width, colour, mark.dashed);
    if let Some(from) = mark.from_image.map(|from| t.pos(from)).filter(|from| from.distance(centre) > 3.0) {
        strokes.arrow(from, centre, 0.8 * width, colour);
    }
}

/// The mark whose centre or line is nearest to the pointer, within a few points.
pub fn circle_at(output: &CanvasOutput, marks: &[CircleMark], pointer_ui: Pos2) -> Option<usize> {
    const REACH_POINTS: f32 = 8.0;
    let t = output.ui_from_image;
    let apart = |mark: &CircleMark| {
        let distance = t.pos(mark.pos_image).distance(pointer_ui);
        distance.min((distance - mark.radius_image() * t.scale()).abs())
    };
    nearest(marks.iter().enumerate().map(|(index, mark)| (apart(mark), index)), REACH_POINTS)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::detector::params::slope_grid::Slope;

    pub(super) fn feature(u: f32, v: f32, sigma: f32, slope: (f32, f32), response: f32) -> Feature {
        let slope = Slope::new(slope.0, slope.1);
        Feature { u, v, sigma, slope, response, snr: 5.0, orientation: 0.3, ..Feature::default() }
    }

    #[test]
    fn motion_spans_the_burst_about_the_middle() {
        let over = |frames| motion_over(&feature(100.0, 50.0, 2.0, (2.0, -1.0), 0.1), &Positions::even(frames));
        assert_eq!(over(5), [[96.0, 52.0], [104.0, 48.0]]);
        assert_eq!(over(1), [[100.0, 50.0]; 2]);
    }

    #[test]
    fn nearest_mark_wins_then_the_smallest_circle_around() {
        let features = [
            feature(100.0, 100.0, 60.0, (0.0, 0.0), 0.1),
            feature(120.0, 100.0, 5.0, (0.0, 0.0), 0.1),
            feature(100.0, 100.0, 20.0, (0.0, 0.0), 0.1),
        ];
        let t = RectTransform::new(pos2(0.0, 0.0), pos2(0.0, 0.0), 2.0);
        let at = |u: f32, v: f32| feature_at(&features, None, t, t.pos(pos2(u, v)));
        assert_eq!(at(120.0, 100.0), Some(1));
        // Both large circles share their centre: the smaller is taken.
        assert_eq!(at(100.0, 100.0), Some(2));
        // On the largest circle's line.
        assert_eq!(at(100.0 + 60.0 * 1.513, 100.0), Some(0));
        // Between the marks, inside both large ones.
        assert_eq!(at(100.0, 114.0), Some(2));
        assert_eq!(at(300.0, 300.0), None);
        assert_eq!(feature_at(&features, Some(&[true, false, true]), t, t.pos(pos2(120.0, 100.0))), Some(2));
    }
}
