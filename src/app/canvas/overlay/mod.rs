//! Features over a picture: circles of true scale, orientation, motion over the burst.
//!
//! The circle is the rim of the disc to which D responds most strongly at scale σ. The tick points along the
//! orientation. The arrow runs from the feature's place in the first frame to that in the last. Features whose slope
//! lies on the rim of the searched grid have a dashed circle: their true motion may lie outside.

mod colour_by;
mod compared;
mod hit;
mod marks;
mod match_lines;
mod strokes;

pub use crate::app::view::ColourBy;
pub use colour_by::ColourScale;
pub use compared::{ComparedMark, draw_compared, mark_at};
pub use hit::feature_at;
pub use marks::{CircleMark, circle_at, draw_marks};
pub use match_lines::{LineKind, MatchLine, MatchLineStyle, Pane, draw_match_lines, match_at};

use super::{CanvasOutput, RectTransform};
use crate::detector::feature::Feature;
use crate::detector::localise::rim_radius;
use egui::{Color32, Mesh, Pos2, Shape, pos2};
use rayon::prelude::*;
use strokes::Strokes;

/// Style of the features.
#[derive(Debug, Clone, Copy)]
pub struct OverlayStyle<'a> {
    /// Colours of the features.
    pub scale: &'a ColourScale,
    /// Number of frames of the burst that were used, N: the arrow spans N − 1 steps.
    pub frames: usize,
    /// Flag of each feature, `false` hides it; `None` shows all.
    pub shown: Option<&'a [bool]>,
    /// Index of the selected feature.
    pub selected: Option<usize>,
    /// Index of the feature under the pointer.
    pub hovered: Option<usize>,
    /// Whether the features belong to older parameters or another picture, and are drawn dimmed.
    pub stale: bool,
    /// Whether circles are drawn.
    pub circles: bool,
    /// Whether orientation ticks are drawn.
    pub orientations: bool,
    /// Whether arrows of motion are drawn.
    pub motion: bool,
}

impl<'a> OverlayStyle<'a> {
    /// Style that shows everything and selects nothing, for a burst of `frames` frames.
    pub fn new(scale: &'a ColourScale, frames: usize) -> Self {
        Self {
            scale,
            frames,
            shown: None,
            selected: None,
            hovered: None,
            stale: false,
            circles: true,
            orientations: true,
            motion: true,
        }
    }
}

/// Radius of a feature's circle, in image pixels: the rim of the disc to which D responds most strongly at its scale;
/// 1.51·σ for the usual five levels an octave (four: 1.54·σ, ten: 1.46·σ).
pub fn circle_radius_image(feature: &Feature) -> f32 {
    rim_radius(f64::from(feature.sigma), USUAL_LEVELS) as f32
}

/// Levels of the default parameters.
const USUAL_LEVELS: usize = 5;

/// Places of a feature in the first and in the last of `frames` frames, in image pixels.
pub fn motion_image(feature: &Feature, frames: usize) -> (Pos2, Pos2) {
    let half_span = 0.5 * frames.saturating_sub(1) as f32;
    let (du, dv) = (half_span * feature.slope.u, half_span * feature.slope.v);
    (pos2(feature.u - du, feature.v - dv), pos2(feature.u + du, feature.v + dv))
}

/// Whether feature `i` is shown.
fn is_shown(shown: Option<&[bool]>, i: usize) -> bool {
    shown.is_none_or(|flags| flags.get(i).copied().unwrap_or(true))
}

/// Maximum number of visible features with a dark edge around their lines; a larger crowd would only get darker.
const MAX_WITH_EDGE: usize = 1500;

/// Minimum radius of a drawn circle, in points, so that a feature never vanishes.
const MIN_RADIUS_POINTS: f32 = 1.5;

/// Draws `features` over the canvas of `output`. Invisible features cost nothing; thousands are drawn at display rate.
pub fn draw_features(output: &CanvasOutput, features: &[Feature], style: &OverlayStyle<'_>) {
    let pixels_per_point = output.painter.pixels_per_point();
    let visible: Vec<usize> = (0..features.len())
        .filter(|&i| is_shown(style.shown, i) && is_visible(output, &features[i], style.frames))
        .collect();
    let opacity = if style.stale { 0.35 } else { 0.95 };
    let edges = visible.len() <= MAX_WITH_EDGE && !style.stale;
    // Meshes are built in parallel, in the features' order.
    let meshes: Vec<Mesh> = visible
        .par_chunks(256)
        .map(|chunk| {
            let mut strokes = Strokes::new(pixels_per_point);
            for feature in chunk.iter().filter(|_| edges).map(|&i| &features[i]) {
                let edge = Color32::from_black_alpha(90);
                draw_one(&mut strokes, output.ui_from_image, feature, style, Line { width: 3.2, colour: edge });
            }
            for &i in chunk {
                let colour = style.scale.colour(i, &features[i]).gamma_multiply(opacity);
                draw_one(&mut strokes, output.ui_from_image, &features[i], style, Line { width: 1.4, colour });
            }
            strokes.into_mesh()
        })
        .collect();
    output.painter.extend(meshes.into_iter().filter(|mesh| !mesh.is_empty()).map(Shape::mesh));
    let mut strokes = Strokes::new(pixels_per_point);
    // The hovered and the selected feature lie above all others.
    for (highlight, width) in [(style.hovered, 2.0), (style.selected, 2.6)] {
        let shown = highlight.filter(|&i| is_shown(style.shown, i));
        let Some((index, feature)) = shown.and_then(|i| Some((i, features.get(i)?))) else { continue };
        for (extra, colour) in
            [(4.5, Color32::from_black_alpha(150)), (2.4, Color32::WHITE), (0.0, style.scale.colour(index, feature))]
        {
            draw_one(&mut strokes, output.ui_from_image, feature, style, Line { width: width + extra, colour });
        }
    }
    let mesh = strokes.into_mesh();
    if !mesh.is_empty() {
        output.painter.add(Shape::mesh(mesh));
    }
}

#[derive(Clone, Copy)]
struct Line {
    width: f32,
    colour: Color32,
}

fn draw_one(strokes: &mut Strokes, t: RectTransform, feature: &Feature, style: &OverlayStyle<'_>, line: Line) {
    let centre = t.pos(pos2(feature.u, feature.v));
    let radius = (circle_radius_image(feature) * t.scale()).max(MIN_RADIUS_POINTS);
    if style.motion {
        let (first, last) = motion_image(feature, style.frames);
        let (first, last) = (t.pos(first), t.pos(last));
        if first.distance(last) > 3.0 {
            strokes.arrow(first, last, 0.8 * line.width, line.colour.gamma_multiply(0.85));
        }
    }
    if style.circles {
        strokes.circle(centre, radius, line.width, line.colour, feature.at_slope_limit);
    }
    if style.orientations && radius > 4.0 {
        strokes.line(centre, centre + radius * egui::Vec2::angled(feature.orientation), line.width, line.colour);
    }
}

/// Whether any part of the feature may be visible in the canvas.
fn is_visible(output: &CanvasOutput, feature: &Feature, frames: usize) -> bool {
    let (first, last) = motion_image(feature, frames);
    let reach = circle_radius_image(feature) + 4.0 / output.ui_from_image.scale();
    let bounds = egui::Rect::from_two_pos(first, last)
        .union(egui::Rect::from_center_size(pos2(feature.u, feature.v), egui::Vec2::splat(2.0 * reach)));
    bounds.is_finite() && bounds.intersects(output.visible_image)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::detector::params::slope_grid::Slope;

    /// Test feature with the given values.
    pub(super) fn feature(u: f32, v: f32, sigma: f32, slope: (f32, f32), response: f32) -> Feature {
        Feature {
            u,
            v,
            sigma,
            orientation: 0.3,
            slope: Slope::new(slope.0, slope.1),
            response,
            snr: 5.0,
            octave: 0,
            level: 0,
            slope_index: 0,
            at_slope_limit: false,
        }
    }

    #[test]
    fn motion_spans_the_burst_about_the_middle() {
        let (first, last) = motion_image(&feature(100.0, 50.0, 2.0, (2.0, -1.0), 0.1), 5);
        assert_eq!((first, last), (pos2(96.0, 52.0), pos2(104.0, 48.0)));
        let (first, last) = motion_image(&feature(100.0, 50.0, 2.0, (2.0, -1.0), 0.1), 1);
        assert_eq!(first, last);
    }
}
