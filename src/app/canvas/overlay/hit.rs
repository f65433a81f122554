//! Finds the feature under the pointer.

use super::{circle_radius_image, is_shown};
use crate::app::canvas::RectTransform;
use crate::detector::feature::Feature;
use egui::Pos2;

/// Maximum distance of the pointer from a centre or a circle line, in points.
const TOLERANCE_POINTS: f32 = 7.0;

/// Index of the feature under `pos_ui`: that with the nearest centre or circle line within a few points; otherwise the
/// smallest circle around the pointer. `shown` is as in [`super::OverlayStyle`].
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
        let radius = circle_radius_image(feature) * ui_from_image.scale();
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

#[cfg(test)]
mod tests {
    use super::super::tests::feature;
    use super::*;
    use egui::pos2;

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
        let shown = [true, false, true];
        assert_eq!(feature_at(&features, Some(&shown), t, t.pos(pos2(120.0, 100.0))), Some(2));
    }
}
